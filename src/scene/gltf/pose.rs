//! Meshes that are deformed where they stand: skins at rest and morph targets at their weights (glTF §3.7.3, §3.7.2.2).
//!
//! A culler needs the geometry as drawn, so a deformed mesh is made once, in the pose that the file is in. Its
//! vertices are computed in f64; a skinned one's are kept relative to its first joint, so that f32 does not coarsen
//! them far from the origin, and that joint's place is where its object stands.

use std::cell::RefCell;

use ::gltf::json::accessor::{ComponentType, Type};
use glam::{DAffine3, DMat3, DVec3};

use super::accessor::Elements;
use super::document::Primitive;
use super::nodes::Tree;
use super::{Result, Source, label, lookup};
use crate::scene::error::Fault;

/// How one node deforms its mesh.
pub(super) struct Pose {
    /// One for each morph target, or none at all.
    pub weights: Box<[f64]>,
    pub skin: Option<Skin>,
}

impl Pose {
    /// What tells one pose of a mesh from another: a skin moves its mesh alike wherever it is placed.
    pub(super) fn key(&self) -> PoseKey {
        (
            self.skin.as_ref().map(|skin| skin.index),
            self.weights.iter().map(|w| w.to_bits()).collect(),
        )
    }
}

/// See [`Pose::key`]; the default is no pose.
pub(super) type PoseKey = (Option<u32>, Box<[u64]>);

/// A skin at rest.
pub(super) struct Skin {
    index: u32,
    /// From the mesh's local coordinates to the world's, for each joint.
    joints: Vec<DAffine3>,
    /// Where the first joint stands: the skinned mesh's origin.
    pub origin: DVec3,
}

const FLOAT: &[ComponentType] = &[ComponentType::F32];
const JOINT_COMPONENTS: &[ComponentType] = &[ComponentType::U8, ComponentType::U16];
const WEIGHT_COMPONENTS: &[ComponentType] =
    &[ComponentType::F32, ComponentType::U8, ComponentType::U16];
const TARGET_COMPONENTS: &[ComponentType] = &[
    ComponentType::F32,
    ComponentType::I8,
    ComponentType::U8,
    ComponentType::I16,
    ComponentType::U16,
];

impl Skin {
    /// The skin with its joints where the file leaves them.
    pub(super) fn at_rest(source: &Source, tree: &RefCell<Tree>, index: u32) -> Result<Skin> {
        let record = lookup(&source.document.skins, index, "skin")?;
        let name = || label("skin", index, record.name.as_deref());
        let within = |fault: Fault| fault.within(name());
        let matrices = record
            .inverse_bind_matrices
            .map(|m| Elements::open(source, m))
            .transpose()
            .map_err(within)?;
        if let Some(matrices) = &matrices {
            matrices
                .must_be(Type::Mat4, FLOAT, "an inverse bind matrix")
                .map_err(within)?;
            if matrices.count < record.joints.len() {
                return Err(Fault::damaged(
                    name(),
                    format!(
                        "{} joints, but {} inverse bind matrices",
                        record.joints.len(),
                        matrices.count
                    ),
                ));
            }
        }
        source
            .budget
            .reserve((record.joints.len() * size_of::<DAffine3>()) as u64, name())?;
        let mut joints = Vec::with_capacity(record.joints.len());
        let mut origin = None;
        for (i, &joint) in record.joints.iter().enumerate() {
            let world = tree.borrow_mut().world(source, joint).map_err(within)?;
            origin.get_or_insert(world.translation);
            let bound = match &matrices {
                Some(matrices) => {
                    let m = matrices.floats::<16>(i).map(f64::from);
                    DAffine3 {
                        matrix3: DMat3::from_cols_array(&[
                            m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10],
                        ]),
                        translation: DVec3::new(m[12], m[13], m[14]),
                    }
                }
                None => DAffine3::IDENTITY,
            };
            joints.push(world * bound);
        }
        match origin {
            Some(origin) => Ok(Skin {
                index,
                joints,
                origin,
            }),
            None => Err(Fault::damaged(name(), "it has no joints")),
        }
    }
}

/// A pose, with the attributes of one primitive that it needs.
pub(super) struct Deform<'a, 'p> {
    pose: &'p Pose,
    targets: Vec<(f64, Elements<'a>)>,
    influences: Vec<(Elements<'a>, Elements<'a>)>,
}

impl<'a, 'p> Deform<'a, 'p> {
    pub(super) fn new(
        source: &'a Source<'_>,
        pose: &'p Pose,
        primitive: &Primitive,
        vertices: usize,
    ) -> Result<Deform<'a, 'p>> {
        let open = |index: u32, element, components: &[_], role: &str| {
            let elements = Elements::open(source, index)?;
            elements.must_be(element, components, role)?;
            if elements.count != vertices {
                return Err(Fault::damaged(
                    format_args!("accessor {index}"),
                    format!(
                        "it has {} elements, but there are {vertices} vertices",
                        elements.count
                    ),
                ));
            }
            Ok(elements)
        };
        let mut targets = Vec::new();
        if !pose.weights.is_empty() && pose.weights.len() != primitive.targets.len() {
            return Err(Fault::damaged(
                "its morph targets",
                format!(
                    "{} targets, but {} weights",
                    primitive.targets.len(),
                    pose.weights.len()
                ),
            ));
        }
        for (target, &weight) in primitive.targets.iter().zip(&pose.weights) {
            if let Some(position) = target.position.filter(|_| weight != 0.0) {
                // Every vertex will look at every target.
                source
                    .budget
                    .reserve((vertices as u64).saturating_mul(4), "its morph targets")?;
                targets.push((
                    weight,
                    open(position, Type::Vec3, TARGET_COMPONENTS, "a morph target")?,
                ));
            }
        }
        let mut influences = Vec::new();
        if pose.skin.is_some() {
            let a = primitive.attributes;
            for (joints, weights) in [(a.joints_0, a.weights_0), (a.joints_1, a.weights_1)] {
                match (joints, weights) {
                    (Some(j), Some(w)) => influences.push((
                        open(j, Type::Vec4, JOINT_COMPONENTS, "a joint")?,
                        open(w, Type::Vec4, WEIGHT_COMPONENTS, "a joint's weight")?,
                    )),
                    (None, None) if !influences.is_empty() => {}
                    _ => {
                        return Err(Fault::damaged(
                            "its attributes",
                            "a skinned primitive needs JOINTS and WEIGHTS, but one is missing",
                        ));
                    }
                }
            }
        }
        Ok(Deform {
            pose,
            targets,
            influences,
        })
    }

    /// Where the vertex stands, in the coordinates of the object that is made for the node.
    pub(super) fn apply(&self, vertex: usize, local: [f32; 3]) -> Result<[f32; 3]> {
        let wide = |p: [f32; 3]| DVec3::from(p.map(f64::from));
        let mut point = wide(local);
        for (weight, target) in &self.targets {
            point += *weight * wide(target.floats::<3>(vertex));
        }
        if let Some(skin) = &self.pose.skin {
            let (mut sum, mut total) = (DVec3::ZERO, 0.0);
            for (joints, weights) in &self.influences {
                for (joint, weight) in joints
                    .integers::<4>(vertex)
                    .into_iter()
                    .zip(weights.floats::<4>(vertex))
                {
                    let Some(place) = skin.joints.get(joint as usize) else {
                        return Err(Fault::damaged(
                            "its joints",
                            format!("joint {joint}, but the skin has {}", skin.joints.len()),
                        ));
                    };
                    sum += f64::from(weight) * (place.transform_point3(point) - skin.origin);
                    total += f64::from(weight);
                }
            }
            if total <= 0.0 {
                return Err(Fault::damaged("its weights", "they add up to nothing"));
            }
            point = sum / total;
        }
        Ok(point.as_vec3().to_array())
    }
}
