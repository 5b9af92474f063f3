//! Down the hierarchy of boxes: which objects meet the frustum, and which groups of them are hidden.

use antumbra_simd::Level;
use antumbra_simd::query::Covered;

use super::Statistics;
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::scene::{Aabb, BvhNode, Scene};
use crate::view::{Containment, Frustum, Planes};

/// A node that meets the frustum, and the planes that its children still have to be tested against.
#[derive(Clone, Copy, Debug)]
pub struct Pending {
    node: u32,
    planes: Planes,
}

/// Finds the objects whose boxes meet the frustum, in hierarchy order. `stack` is memory to work in.
pub fn in_frustum(
    scene: &Scene,
    frustum: &Frustum,
    stack: &mut Vec<Pending>,
    found: &mut Vec<u32>,
) {
    found.clear();
    stack.clear();
    stack.push(Pending {
        node: 0,
        planes: Planes::ALL,
    });
    while let Some(pending) = stack.pop() {
        let node = &scene.bvh().nodes[pending.node as usize];
        let Containment::Meets(planes) = frustum.contains(&node.bounds(), pending.planes) else {
            continue;
        };
        if planes.is_empty() {
            found.extend_from_slice(subtree(scene, node));
        } else if node.count == 0 {
            stack.push(Pending {
                node: node.first + 1,
                planes,
            });
            stack.push(Pending {
                node: node.first,
                planes,
            });
        } else {
            found.extend(objects_of(scene, node).iter().filter(|&&object| {
                frustum.contains(&scene.bounds()[object as usize], planes) != Containment::Outside
            }));
        }
    }
}

/// All objects below a node: they are consecutive.
fn subtree<'a>(scene: &'a Scene, node: &BvhNode) -> &'a [u32] {
    let nodes = &scene.bvh().nodes;
    let (mut first, mut last) = (node, node);
    while first.count == 0 {
        first = &nodes[first.first as usize];
    }
    while last.count == 0 {
        last = &nodes[last.first as usize + 1];
    }
    &scene.bvh().objects[first.first as usize..(last.first + last.count) as usize]
}

fn objects_of<'a>(scene: &'a Scene, node: &BvhNode) -> &'a [u32] {
    &scene.bvh().objects[node.first as usize..(node.first + node.count) as usize]
}

/// The children of a node with fewer objects than this below it are not asked: its objects are, one by one.
const FEWEST_OBJECTS: usize = 8;

/// Marks all objects below nodes whose boxes are hidden behind what is drawn so far.
pub fn hide_subtrees(
    scene: &Scene,
    buffer: &OcclusionBuffer,
    level: Level,
    memory: &mut TraverseMemory,
    hidden: &mut [bool],
    statistics: &mut Statistics,
) {
    let TraverseMemory {
        nodes,
        group,
        footprints,
    } = memory;
    let frustum = Frustum::new(buffer.screen().camera(), buffer.tiles().size());
    nodes.clear();
    nodes.extend((!scene.bvh().nodes.is_empty()).then_some(0));
    while !nodes.is_empty() {
        // As many as are projected at once.
        group.clear();
        group.extend(nodes.drain(nodes.len().saturating_sub(8)..));
        footprints.clear();
        let boxes: [Aabb; 8] = std::array::from_fn(|i| {
            group.get(i).map_or(Aabb::EMPTY, |&node| {
                scene.bvh().nodes[node as usize].bounds()
            })
        });
        buffer
            .screen()
            .footprints_of_aabbs(level, boxes[..group.len()].iter(), footprints);
        for (&node, &footprint) in group.iter().zip(&*footprints) {
            let node = &scene.bvh().nodes[node as usize];
            // What is nowhere on the screen is nobody's question. Of what reaches the near plane the frustum has to say so.
            let is_outside = match footprint {
                Footprint::Nowhere => true,
                Footprint::Within(_) => false,
                Footprint::Unbounded => {
                    frustum.contains(&node.bounds(), Planes::ALL) == Containment::Outside
                }
            };
            if is_outside {
                continue;
            }
            statistics.nodes_tested += 1;
            if buffer.hides(footprint, Covered::Samples) {
                statistics.nodes_hidden += 1;
                for &object in subtree(scene, node) {
                    hidden[object as usize] = true;
                }
            } else if node.count == 0 && subtree(scene, node).len() >= FEWEST_OBJECTS {
                nodes.extend([node.first, node.first + 1]);
            }
        }
    }
}

/// Memory that is kept from traversal to traversal.
#[derive(Debug, Default)]
pub struct TraverseMemory {
    nodes: Vec<u32>,
    group: Vec<u32>,
    footprints: Vec<Footprint>,
}
