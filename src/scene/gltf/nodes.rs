//! The tree of nodes becomes a list of placements, depth first, in the order of the file (glTF §3.5).
//!
//! **Invariants.** Transforms are composed in f64. No recursion: a chain of a million nodes is walked with a list.
//! Cycles are found before the walk (Kahn, *Topological sorting of large networks*, 1962), so it ends. A node with two
//! parents, which glTF forbids but files have, is placed once for each; since such sharing can double with every
//! level, each visit beyond the first is paid for.

use std::cell::RefCell;
use std::collections::HashMap;

use ::gltf::json::accessor::{ComponentType, Type};
use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::accessor::Elements;
use super::document::{Document, Extras, Flags, Instancing, Node};
use super::meshes::Meshes;
use super::pose::{Pose, Skin};
use super::{Result, Source, label, lookup};
use crate::scene::error::{Fault, Label};
use crate::scene::load_budget::OBJECT_BYTES;
use crate::scene::warnings::Warnings;
use crate::scene::{Mesh, Object};

const NO_PARENT: u32 = u32::MAX;

/// Who is whose child, and where nodes stand.
pub(super) struct Tree {
    /// The first parent of each node.
    parents: Vec<u32>,
    /// World transforms found so far, for joints.
    worlds: HashMap<u32, DAffine3>,
}

fn node_label(document: &Document, index: u32) -> Label<'_> {
    label(
        "node",
        index,
        document
            .nodes
            .get(index as usize)
            .and_then(|n| n.name.as_deref()),
    )
}

impl Tree {
    /// Checks that every child exists and that nobody is their own ancestor.
    fn of(document: &Document, warnings: &mut Warnings) -> Result<Tree> {
        let mut parents = vec![NO_PARENT; document.nodes.len()];
        let mut waiting_for = vec![0u32; document.nodes.len()];
        for (i, node) in (0..).zip(&document.nodes) {
            for &child in &node.children {
                lookup(&document.nodes, child, "node")
                    .map_err(|fault| fault.within(node_label(document, i)))?;
                let child = child as usize;
                waiting_for[child] += 1;
                if parents[child] == NO_PARENT {
                    parents[child] = i;
                } else {
                    warnings.note(
                        "it has more than one parent, which glTF forbids; it is placed once for each",
                        node_label(document, child as u32),
                    );
                }
            }
        }
        let mut ready: Vec<u32> = (0..)
            .zip(&waiting_for)
            .filter_map(|(i, &parents)| (parents == 0).then_some(i))
            .collect();
        let mut left = document.nodes.len();
        while let Some(i) = ready.pop() {
            left -= 1;
            for &child in &document.nodes[i as usize].children {
                waiting_for[child as usize] -= 1;
                if waiting_for[child as usize] == 0 {
                    ready.push(child);
                }
            }
        }
        if left > 0 {
            // Whoever still waits has a parent that waits; going up from anyone ends on the cycle.
            let mut came_by = vec![false; document.nodes.len()];
            let mut waiting_parent = vec![NO_PARENT; document.nodes.len()];
            for (i, node) in (0..)
                .zip(&document.nodes)
                .filter(|(i, _)| waiting_for[*i as usize] > 0)
            {
                node.children
                    .iter()
                    .for_each(|&child| waiting_parent[child as usize] = i);
            }
            let mut at = waiting_for.iter().position(|&w| w > 0).unwrap_or(0) as u32;
            while at != NO_PARENT && !std::mem::replace(&mut came_by[at as usize], true) {
                at = waiting_parent[at as usize];
            }
            return Err(Fault::damaged(
                node_label(document, at),
                "it is its own ancestor: the nodes form a cycle",
            ));
        }
        Ok(Tree {
            parents,
            worlds: HashMap::new(),
        })
    }

    /// Where a node stands in the world, through its first parent.
    pub(super) fn world(&mut self, source: &Source, index: u32) -> Result<DAffine3> {
        lookup(&source.document.nodes, index, "node")?;
        let mut chain = Vec::new();
        let mut at = index;
        while at != NO_PARENT && !self.worlds.contains_key(&at) {
            chain.push(at);
            at = self.parents[at as usize];
        }
        let mut world = self.worlds.get(&at).copied().unwrap_or(DAffine3::IDENTITY);
        for node in chain.into_iter().rev() {
            world *= local_transform(source.document, node)?;
            source
                .budget
                .reserve(size_of::<DAffine3>() as u64 + 16, "its joints")?;
            self.worlds.insert(node, world);
        }
        Ok(world)
    }
}

/// T · R · S. The quaternion need not be of unit length, since f32 or fewer bits wrote it; zero is refused.
fn compose(
    translation: [f64; 3],
    rotation: [f64; 4],
    scale: [f64; 3],
) -> std::result::Result<DAffine3, String> {
    let quaternion = DQuat::from_array(rotation);
    let length = quaternion.length();
    if !(length.is_finite() && length > 1e-6) {
        return Err(format!("its rotation is no rotation: {rotation:?}"));
    }
    let rotation = DMat3::from_quat(quaternion * (1.0 / length));
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(
            rotation.x_axis * scale[0],
            rotation.y_axis * scale[1],
            rotation.z_axis * scale[2],
        ),
        translation: DVec3::from(translation),
    })
}

/// From a node's coordinates to its parent's.
fn local_transform(document: &Document, index: u32) -> Result<DAffine3> {
    let node = lookup(&document.nodes, index, "node")?;
    let damaged = |cause: String| Fault::damaged(node_label(document, index), cause);
    let Some(m) = node.matrix.as_deref() else {
        return compose(
            node.translation.as_deref().copied().unwrap_or([0.0; 3]),
            node.rotation
                .as_deref()
                .copied()
                .unwrap_or([0.0, 0.0, 0.0, 1.0]),
            node.scale.as_deref().copied().unwrap_or([1.0; 3]),
        )
        .map_err(damaged);
    };
    let last_row = [m[3], m[7], m[11], m[15]];
    if last_row
        .iter()
        .zip([0.0, 0.0, 0.0, 1.0])
        .any(|(have, want): (&f64, f64)| (have - want).abs() > 1e-6)
    {
        return Err(damaged(format!(
            "the last row of its matrix is {last_row:?}, not 0 0 0 1"
        )));
    }
    Ok(DAffine3 {
        matrix3: DMat3::from_cols_array(&[m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]]),
        translation: DVec3::new(m[12], m[13], m[14]),
    })
}

/// Reads the meshes and objects of the default scene.
pub(super) fn place(source: &Source, warnings: &mut Warnings) -> Result<(Vec<Mesh>, Vec<Object>)> {
    let document = source.document;
    let tree = Tree::of(document, warnings)?;
    let roots = roots(document, &tree, warnings)?;
    let mut walk = Walk {
        source,
        warnings,
        tree: RefCell::new(tree),
        meshes: Meshes::new(source),
        meshes_by_name: None,
        objects: Vec::new(),
        visits: 0,
    };
    for root in roots {
        walk.subtree(root)?;
    }
    if walk.objects.is_empty() {
        return Err(Fault::no_triangles());
    }
    Ok((walk.meshes.into_decoded(), walk.objects))
}

fn roots(document: &Document, tree: &Tree, warnings: &mut Warnings) -> Result<Vec<u32>> {
    if document.scenes.is_empty() && document.scene.is_none() {
        return Ok((0..)
            .zip(&tree.parents)
            .filter_map(|(i, &p)| (p == NO_PARENT).then_some(i))
            .collect());
    }
    let index = document.scene.unwrap_or(0);
    let scene = lookup(&document.scenes, index, "scene")?;
    for &root in &scene.nodes {
        lookup(&document.nodes, root, "node")
            .map_err(|fault| fault.within(format_args!("scene {index}")))?;
        if tree.parents[root as usize] != NO_PARENT {
            warnings.note(
                "it is a root of the scene and has a parent; it is placed for each",
                node_label(document, root),
            );
        }
    }
    if document.scenes.len() > 1 {
        let others = document.scenes.len() - 1;
        warnings.note(
            "other scenes are left out",
            format_args!("scene {index} is read ({others} not)"),
        );
    }
    Ok(scene.nodes.to_vec())
}

/// A node on the way down.
struct Step {
    node: u32,
    next_child: usize,
    world: DAffine3,
}

struct Walk<'a, 's, 'w> {
    source: &'a Source<'s>,
    warnings: &'w mut Warnings,
    tree: RefCell<Tree>,
    meshes: Meshes<'a, 's>,
    meshes_by_name: Option<HashMap<&'a str, u32>>,
    objects: Vec<Object>,
    visits: usize,
}

impl Walk<'_, '_, '_> {
    fn subtree(&mut self, root: u32) -> Result<()> {
        const STEP: u64 = size_of::<Step>() as u64;
        let document = self.source.document;
        let mut path: Vec<Step> = Vec::new();
        let mut entering = Some((root, DAffine3::IDENTITY));
        loop {
            if let Some((node, parent)) = entering.take() {
                self.visits += 1;
                if self.visits > document.nodes.len() {
                    self.source
                        .budget
                        .reserve(64, "nodes with several parents")?;
                }
                let world = parent * local_transform(document, node)?;
                let shown = self
                    .enter(node, world)
                    .map_err(|fault| fault.within(node_label(document, node)))?;
                self.source.budget.reserve(STEP, "a deep tree of nodes")?;
                path.push(Step {
                    node,
                    next_child: if shown { 0 } else { usize::MAX },
                    world,
                });
            }
            let Some(step) = path.last_mut() else {
                return Ok(());
            };
            match document.nodes[step.node as usize]
                .children
                .get(step.next_child)
            {
                Some(&child) => {
                    step.next_child += 1;
                    entering = Some((child, step.world));
                }
                None => {
                    path.pop();
                    self.source.budget.release(STEP);
                }
            }
        }
    }

    /// Places what a node draws; says whether its children are to be seen.
    fn enter(&mut self, index: u32, world: DAffine3) -> Result<bool> {
        let node = &self.source.document.nodes[index as usize];
        let extensions = node.extensions.as_deref();
        if extensions
            .and_then(|e| e.visibility.as_ref())
            .is_some_and(|v| !v.visible)
        {
            self.warnings.note(
                "it is hidden (KHR_node_visibility) and left out with its children",
                node_label(self.source.document, index),
            );
            return Ok(false);
        }
        let Some(mesh) = node.mesh else {
            return Ok(true);
        };
        let pose = self.pose(node, mesh)?;
        let Some(place) = self.meshes.get(mesh, pose.as_ref(), self.warnings)? else {
            self.warnings.note(
                "its mesh has no triangles, so it is not an object",
                node_label(self.source.document, index),
            );
            return Ok(true);
        };
        let flags = flags(node)?;
        let occluder_proxy = match &flags.occluder_proxy {
            Some(name) => Some(self.proxy(name)?),
            None => None,
        };
        let name = node
            .name
            .as_deref()
            .filter(|n| !n.is_empty())
            .map_or_else(|| format!("node {index}"), str::to_owned);
        let object = |name, world_from_local| Object {
            name,
            mesh: place,
            world_from_local,
            never_cull: flags.never_cull,
            never_occlude: flags.never_occlude,
            occluder_proxy,
        };
        let cost = OBJECT_BYTES + name.len() as u64;
        if let Some(instancing) = extensions.and_then(|e| e.instancing.as_ref()) {
            let instances = Instances::open(self.source, instancing)?;
            self.source
                .budget
                .reserve(cost.saturating_mul(instances.count as u64), "its instances")?;
            for i in 0..instances.count {
                let local = instances.transform(i)?;
                self.objects
                    .push(object(format!("{name}[{i}]"), world * local));
            }
        } else {
            self.source.budget.reserve(cost, "its object")?;
            let skinned = pose
                .and_then(|p| p.skin)
                .map(|skin| DAffine3::from_translation(skin.origin));
            self.objects.push(object(name, skinned.unwrap_or(world)));
        }
        Ok(true)
    }

    /// How a node deforms its mesh, if it does.
    fn pose(&self, node: &Node, mesh: u32) -> Result<Option<Pose>> {
        let record = lookup(&self.source.document.meshes, mesh, "mesh")?;
        let weights = node
            .weights
            .as_deref()
            .or(record.weights.as_deref())
            .unwrap_or_default();
        let morphed = weights.iter().any(|&w| w != 0.0);
        let skin = node
            .skin
            .map(|skin| Skin::at_rest(self.source, &self.tree, skin))
            .transpose()?;
        let weights = if morphed {
            weights.into()
        } else {
            Box::default()
        };
        self.source
            .budget
            .reserve(size_of_val(&*weights) as u64, "its weights")?;
        Ok((morphed || skin.is_some()).then_some(Pose { weights, skin }))
    }

    fn proxy(&mut self, name: &str) -> Result<usize> {
        let document = self.source.document;
        let by_name = self.meshes_by_name.get_or_insert_with(|| {
            // Of several with one name the first.
            let named = document
                .meshes
                .iter()
                .enumerate()
                .filter_map(|(i, m)| m.name.as_deref().map(|name| (name, i as u32)));
            named.rev().collect()
        });
        let place = match by_name.get(name) {
            Some(&index) => self.meshes.get(index, None, self.warnings)?,
            None => {
                return Err(Fault::damaged(
                    "its occluder_proxy",
                    format!("no mesh is named {name:?}"),
                ));
            }
        };
        place.ok_or_else(|| {
            Fault::damaged(
                "its occluder_proxy",
                format!("mesh {name:?} has no triangles"),
            )
        })
    }
}

fn flags(node: &Node) -> Result<Flags> {
    let Some(text) = node.extras.as_ref().map(|extras| extras.get()) else {
        return Ok(Flags::default());
    };
    if !text.starts_with('{') || !text.contains("antumbra") {
        return Ok(Flags::default());
    }
    match serde_json::from_str::<Extras>(text) {
        Ok(extras) => Ok(extras.antumbra.unwrap_or_default()),
        Err(error) => Err(Fault::damaged(
            "its extras",
            format!(
                "\"antumbra\" may hold never_cull, never_occlude (true or false) and occluder_proxy (a mesh's name): {error}"
            ),
        )),
    }
}

/// The transforms of EXT_mesh_gpu_instancing.
struct Instances<'a> {
    count: usize,
    translation: Option<Elements<'a>>,
    rotation: Option<Elements<'a>>,
    scale: Option<Elements<'a>>,
}

const FLOAT: &[ComponentType] = &[ComponentType::F32];
const ROTATION: &[ComponentType] = &[ComponentType::F32, ComponentType::I8, ComponentType::I16];

impl<'a> Instances<'a> {
    fn open(source: &'a Source<'_>, instancing: &Instancing) -> Result<Instances<'a>> {
        let place = "EXT_mesh_gpu_instancing";
        let open = |index: Option<u32>, element, components: &[_], role: &str| {
            let Some(index) = index else { return Ok(None) };
            let elements = Elements::open(source, index).map_err(|f| f.within(place))?;
            elements
                .must_be(element, components, role)
                .map_err(|f| f.within(place))?;
            Ok(Some(elements))
        };
        let attributes = &instancing.attributes;
        let translation = open(attributes.translation, Type::Vec3, FLOAT, "a TRANSLATION")?;
        let rotation = open(attributes.rotation, Type::Vec4, ROTATION, "a ROTATION")?;
        let scale = open(attributes.scale, Type::Vec3, FLOAT, "a SCALE")?;
        let counts: Vec<usize> = [&translation, &rotation, &scale]
            .into_iter()
            .flatten()
            .map(|e| e.count)
            .collect();
        match counts.first() {
            Some(&count) if counts.iter().all(|&c| c == count) => Ok(Instances {
                count,
                translation,
                rotation,
                scale,
            }),
            Some(_) => Err(Fault::damaged(
                place,
                format!("its attributes have different counts: {counts:?}"),
            )),
            None => Err(Fault::damaged(
                place,
                "it has none of TRANSLATION, ROTATION and SCALE",
            )),
        }
    }

    fn transform(&self, i: usize) -> Result<DAffine3> {
        fn value<const N: usize>(
            elements: &Option<Elements>,
            i: usize,
            default: [f64; N],
        ) -> [f64; N] {
            elements
                .as_ref()
                .map_or(default, |e| e.floats::<N>(i).map(f64::from))
        }
        compose(
            value(&self.translation, i, [0.0; 3]),
            value(&self.rotation, i, [0.0, 0.0, 0.0, 1.0]),
            value(&self.scale, i, [1.0; 3]),
        )
        .map_err(|cause| Fault::damaged(format_args!("instance {i}"), cause))
    }
}
