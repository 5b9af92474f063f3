//! Down the hierarchy of boxes: which objects meet the frustum.

use glam::DVec3;

use crate::scene::{Aabb, BvhNode, Scene};
use crate::view::{Containment, Frustum, Planes};

fn bounds_of(node: &BvhNode) -> Aabb {
    let corner = |c: [f32; 3]| DVec3::from_array(c.map(f64::from));
    Aabb {
        min: corner(node.min),
        max: corner(node.max),
    }
}

/// A node that meets the frustum, and the planes that its children still have to be tested against.
#[derive(Clone, Copy)]
struct Pending {
    node: u32,
    planes: Planes,
}

/// The objects whose boxes meet the frustum, in hierarchy order.
pub fn in_frustum(scene: &Scene, frustum: &Frustum) -> Vec<u32> {
    let mut found = Vec::new();
    let mut stack = vec![Pending {
        node: 0,
        planes: Planes::ALL,
    }];
    while let Some(pending) = stack.pop() {
        let node = &scene.bvh().nodes[pending.node as usize];
        let Containment::Meets(planes) = frustum.contains(&bounds_of(node), pending.planes) else {
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
    found
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
