//! The two passes down the hierarchy of boxes.

use glam::DVec3;
use rayon::prelude::*;

use super::Statistics;
use crate::occlusion::OcclusionBuffer;
use crate::scene::{Aabb, BvhNode, Scene};
use crate::view::{Containment, Frustum, Planes};

/// Subtrees that the second pass hands to threads, at the least. A constant, so that the result does not know how many
/// threads there are.
const FRONTIER: usize = 64;

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
        if node.count == 0 {
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

fn objects_of<'a>(scene: &'a Scene, node: &BvhNode) -> &'a [u32] {
    &scene.bvh().objects[node.first as usize..(node.first + node.count) as usize]
}

/// The objects in the frustum that the buffer does not hide, in no particular order. `hidden` says of objects that
/// they are known to be.
pub fn not_hidden(
    scene: &Scene,
    frustum: &Frustum,
    buffer: &OcclusionBuffer,
    hidden: &[bool],
    statistics: &mut Statistics,
) -> Vec<u32> {
    let mut pass = Pass {
        scene,
        frustum,
        buffer,
        hidden,
        visible: Vec::new(),
        statistics: *statistics,
    };
    let mut frontier = vec![Pending {
        node: 0,
        planes: Planes::ALL,
    }];
    // Breadth first, until there is enough to share out.
    let mut next = 0;
    while next < frontier.len() && frontier.len() - next < FRONTIER {
        let pending = frontier[next];
        next += 1;
        pass.step(pending, &mut frontier);
    }
    let parts: Vec<(Vec<u32>, Statistics)> = frontier[next..]
        .par_iter()
        .map(|&pending| {
            let mut part = pass.fork();
            let mut stack = vec![pending];
            while let Some(pending) = stack.pop() {
                part.step(pending, &mut stack);
            }
            (part.visible, part.statistics)
        })
        .collect();
    *statistics = pass.statistics;
    let mut visible = pass.visible;
    for (part, counts) in parts {
        visible.extend(part);
        statistics.nodes_tested += counts.nodes_tested;
        statistics.nodes_hidden += counts.nodes_hidden;
        statistics.objects_tested += counts.objects_tested;
    }
    visible
}

struct Pass<'a> {
    scene: &'a Scene,
    frustum: &'a Frustum,
    buffer: &'a OcclusionBuffer,
    hidden: &'a [bool],
    visible: Vec<u32>,
    statistics: Statistics,
}

impl<'a> Pass<'a> {
    /// The same question, with nothing found yet.
    fn fork(&self) -> Pass<'a> {
        Pass {
            visible: Vec::new(),
            statistics: Statistics::default(),
            ..*self
        }
    }

    /// Tests a node; pushes its children, or keeps its objects that are not hidden.
    fn step(&mut self, pending: Pending, children: &mut Vec<Pending>) {
        let node = &self.scene.bvh().nodes[pending.node as usize];
        let bounds = bounds_of(node);
        let Containment::Meets(planes) = self.frustum.contains(&bounds, pending.planes) else {
            return;
        };
        if node.count == 0 {
            self.statistics.nodes_tested += 1;
            if self.buffer.test_aabb(&bounds).is_hidden() {
                self.statistics.nodes_hidden += 1;
                return;
            }
            children.push(Pending {
                node: node.first + 1,
                planes,
            });
            children.push(Pending {
                node: node.first,
                planes,
            });
            return;
        }
        for &object in objects_of(self.scene, node) {
            let bounds = &self.scene.bounds()[object as usize];
            if self.frustum.contains(bounds, planes) == Containment::Outside {
                continue;
            }
            if !self.hidden[object as usize] && !self.is_hidden(object) {
                self.visible.push(object);
            }
        }
    }

    fn is_hidden(&mut self, object: u32) -> bool {
        self.statistics.objects_tested += 1;
        let world_box = &self.scene.bounds()[object as usize];
        let world_box = self.buffer.screen().project_aabb(world_box);
        super::is_hidden(self.scene, self.buffer, object, &world_box)
    }
}
