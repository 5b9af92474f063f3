//! Axis-aligned boxes in f64, and the world box of each object.
//!
//! World coordinates stay in f64 until the eye has been subtracted, so a box far from the origin is as tight as one
//! at it.
//!
//! **Invariant.** An object's box holds each vertex that one of its triangles uses, as any pass will compute it in
//! f64, in whatever order it adds the terms. With u = 2⁻⁵³, a sum of three products and a translation errs by at most
//! 4u/(1−4u) of Σ|mᵢⱼ||pⱼ| + |tᵢ| (Higham, *Accuracy and Stability of Numerical Algorithms*, §3.1), and subtracting
//! the growth by u of the result; twice that is under 2⁻⁴⁹. The boxes grow by 2⁻⁴⁰ of it, 500 times as much, which is
//! still a thousandth of a millimetre on a world of a thousand kilometres.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::validate::{MAX_COORDINATE, object_label};
use super::{Mesh, Object, SceneError};

/// An axis-aligned box; `min` and `max` are world coordinates in scene units.
///
/// [`Aabb::EMPTY`] holds nothing: its `min` is above its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// The box that holds nothing, and that [`Aabb::union`] leaves out.
    pub const EMPTY: Aabb = Aabb {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The smallest box around some points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Aabb {
        points.into_iter().fold(Aabb::EMPTY, |b, p| Aabb {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// The smallest box around two boxes.
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The box with every face moved outwards by `distance`.
    pub fn grown(self, distance: f64) -> Aabb {
        Aabb {
            min: self.min - DVec3::splat(distance),
            max: self.max + DVec3::splat(distance),
        }
    }

    /// The middle of the box.
    pub fn center(self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Edge lengths.
    pub fn size(self) -> DVec3 {
        self.max - self.min
    }

    /// The eight corners; bit 0 of the index chooses `max.x`, bit 1 `max.y`, bit 2 `max.z`.
    pub fn corners(self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f64, hi: f64| if i >> bit & 1 == 0 { lo } else { hi };
            DVec3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            )
        })
    }

    /// Whether the box is finite and holds at least a point.
    pub fn is_valid(self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }

    /// Whether `other` lies wholly inside the box or on its faces.
    pub fn contains(self, other: Aabb) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }
}

/// A box with any orientation, world coordinates. Its axes need not be at right angles to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// The middle.
    pub center: DVec3,
    /// From the middle to the middles of three faces.
    pub half_axes: [DVec3; 3],
}

/// By how much of its magnitude a world box grows.
const GROWTH: f64 = 1.0 / (1u64 << 40) as f64;

/// How many vertices may be transformed to bound a scene: two seconds of one core. Only a file that places large
/// meshes very many times has more.
const TRANSFORMS: u64 = 1 << 30;

/// A larger mesh that moves is bounded by the corners of its local box: a frame has no time to place all of its vertices.
const MOVED_VERTICES: u64 = 1024;

/// What bounding needs to know of a mesh, found once however many objects share it.
#[derive(Debug)]
struct MeshExtent {
    /// The box of the vertices that triangles use, local units.
    local: Aabb,
    /// Those vertices, if not all are used.
    used: Option<Vec<u32>>,
    /// Whether the mesh is placed so often that its local box must stand for its vertices.
    by_corners: bool,
}

fn point(position: [f32; 3]) -> DVec3 {
    DVec3::from(position.map(f64::from))
}

impl MeshExtent {
    fn of(mesh: &Mesh) -> MeshExtent {
        let mut is_used = vec![false; mesh.positions.len()];
        mesh.triangles
            .iter()
            .flatten()
            .for_each(|&i| is_used[i as usize] = true);
        let used = (!is_used.iter().all(|&u| u)).then(|| {
            (0..)
                .zip(&is_used)
                .filter_map(|(i, &used)| used.then_some(i))
                .collect()
        });
        let mut extent = MeshExtent {
            local: Aabb::EMPTY,
            used,
            by_corners: false,
        };
        extent.local = extent.fold(mesh, |p| p);
        extent
    }

    fn vertex_count(&self, mesh: &Mesh) -> u64 {
        self.used.as_ref().map_or(mesh.positions.len(), Vec::len) as u64
    }

    fn fold(&self, mesh: &Mesh, place: impl Fn(DVec3) -> DVec3) -> Aabb {
        match &self.used {
            None => Aabb::around(mesh.positions.iter().map(|&p| place(point(p)))),
            Some(used) => Aabb::around(
                used.iter()
                    .map(|&i| place(point(mesh.positions[i as usize]))),
            ),
        }
    }

    fn world_box(&self, mesh: &Mesh, world_from_local: &DAffine3) -> Aabb {
        self.placed(mesh, world_from_local, self.by_corners)
    }

    /// The box of the vertices where they are placed, or of the local box's corners.
    fn placed(&self, mesh: &Mesh, world_from_local: &DAffine3, by_corners: bool) -> Aabb {
        let exact = if by_corners {
            Aabb::around(
                self.local
                    .corners()
                    .map(|c| world_from_local.transform_point3(c)),
            )
        } else {
            self.fold(mesh, |p| world_from_local.transform_point3(p))
        };
        exact.grown(growth(&self.local, world_from_local))
    }
}

/// How far from its place a vertex of a local box may be computed to be, along any axis of the world.
fn growth(local: &Aabb, world_from_local: &DAffine3) -> f64 {
    let reach = local.min.abs().max(local.max.abs());
    let m = world_from_local.matrix3;
    let terms = m.x_axis.abs() * reach.x
        + m.y_axis.abs() * reach.y
        + m.z_axis.abs() * reach.z
        + world_from_local.translation.abs();
    GROWTH * terms.max_element()
}

/// A mesh's own box, where its object stands: any vertex that a pass computes lies no farther than `growth` outside of
/// it along each axis of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnBox {
    /// The box.
    pub shape: OrientedBox,
    /// Scene units.
    pub growth: f64,
}

impl OwnBox {
    /// A box in local coordinates, placed in the world.
    pub(crate) fn placed(local: &Aabb, world_from_local: &DAffine3) -> OwnBox {
        let half = local.size() * 0.5;
        let m = world_from_local.matrix3;
        OwnBox {
            shape: OrientedBox {
                center: world_from_local.transform_point3(local.center()),
                half_axes: [m.x_axis * half.x, m.y_axis * half.y, m.z_axis * half.z],
            },
            growth: growth(local, world_from_local),
        }
    }

    /// The area of its faces: by Cauchy's formula four times that of its outline, seen from everywhere on average.
    fn area(&self) -> f64 {
        let [u, v, w] = self.shape.half_axes;
        8.0 * (u.cross(v).length() + v.cross(w).length() + w.cross(u).length())
    }
}

/// The boxes of a scene's objects.
#[derive(Clone, Debug)]
pub(super) struct Boxes {
    /// Each object's world box.
    pub world: Vec<Aabb>,
    /// What is known of each mesh.
    extents: Arc<Vec<MeshExtent>>,
    /// Whether an object's own box is clearly the smaller one.
    own_is_smaller: Vec<bool>,
}

/// An own box is asked if its area is not more than so much of the world box': it costs a second projection.
const CLEARLY_SMALLER: f64 = 0.95;

impl Boxes {
    /// The own box of an object, if it is smaller than its world box.
    pub fn own(&self, index: usize, object: &Object) -> Option<OwnBox> {
        self.own_is_smaller[index]
            .then(|| OwnBox::placed(&self.extents[object.mesh].local, &object.world_from_local))
    }

    /// Whether a mesh can be placed so: whether its local box's corners stay within [`MAX_COORDINATE`].
    pub fn check_place(&self, mesh: usize, place: &DAffine3) -> Result<(), String> {
        let extent = &self.extents[mesh];
        let corners = extent.local.corners();
        let around = Aabb::around(corners.map(|c| place.transform_point3(c)));
        check_reach(&around.grown(growth(&extent.local, place)))
    }

    /// The box of a mesh in a place.
    pub fn moved(&self, mesh: &Mesh, index: usize, place: &DAffine3) -> Aabb {
        let extent = &self.extents[index];
        let by_corners = extent.by_corners || extent.vertex_count(mesh) > MOVED_VERTICES;
        extent.placed(mesh, place, by_corners)
    }

    /// Gives an object another world box: that of its mesh in another place, or one that holds more.
    pub fn set(&mut self, index: usize, object: &Object, world: Aabb) {
        let local = &self.extents[object.mesh].local;
        self.own_is_smaller[index] = is_own_smaller(local, &object.world_from_local, &world);
        self.world[index] = world;
    }

    /// Gives an object a world box that holds it in several places, where its own box would not.
    pub fn set_swept(&mut self, index: usize, world: Aabb) {
        self.own_is_smaller[index] = false;
        self.world[index] = world;
    }
}

/// Whether an object's own box is clearly smaller than its world box.
fn is_own_smaller(local: &Aabb, place: &DAffine3, world: &Aabb) -> bool {
    let [x, y, z] = world.size().to_array();
    OwnBox::placed(local, place).area() <= 2.0 * (x * y + y * z + z * x) * CLEARLY_SMALLER
}

/// Whether a world box is of numbers, and none of them is too large.
fn check_reach(bounds: &Aabb) -> Result<(), String> {
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    // Written so that a NaN fails.
    if bounds.is_valid() && farthest <= MAX_COORDINATE {
        return Ok(());
    }
    Err(format!(
        "its vertices reach world coordinates of {farthest:e}, beyond {MAX_COORDINATE:e}; scale the scene down"
    ))
}

/// The boxes of all objects, in their order. The meshes and objects have been checked.
pub(super) fn boxes(meshes: &[Mesh], objects: &[Object]) -> Result<Boxes, SceneError> {
    let mut extents: Vec<MeshExtent> = meshes.par_iter().map(MeshExtent::of).collect();
    let mut placed = vec![0u64; meshes.len()];
    objects.iter().for_each(|o| placed[o.mesh] += 1);
    let transforms: Vec<u64> = placed
        .iter()
        .zip(meshes)
        .zip(&extents)
        .map(|((&n, m), e)| n.saturating_mul(e.vertex_count(m)))
        .collect();
    if transforms
        .iter()
        .fold(0, |sum: u64, &t| sum.saturating_add(t))
        > TRANSFORMS
    {
        let fair_share = TRANSFORMS / meshes.len() as u64;
        extents
            .iter_mut()
            .zip(&transforms)
            .for_each(|(e, &t)| e.by_corners = t > fair_share);
    }
    let boxes: Vec<Aabb> = objects
        .par_iter()
        .map(|o| extents[o.mesh].world_box(&meshes[o.mesh], &o.world_from_local))
        .collect();
    for (i, (bounds, object)) in boxes.iter().zip(objects).enumerate() {
        check_reach(bounds).map_err(|cause| SceneError::Invalid {
            file: None,
            object: object_label(i, object),
            cause,
        })?;
    }
    let own_is_smaller = boxes
        .par_iter()
        .zip(objects)
        .map(|(world, o)| is_own_smaller(&extents[o.mesh].local, &o.world_from_local, world))
        .collect();
    Ok(Boxes {
        world: boxes,
        extents: Arc::new(extents),
        own_is_smaller,
    })
}
