//! Down the hierarchy of boxes: which objects meet the frustum, and which groups of them are hidden.

use std::ops::Range;

use super::marks::Marks;
use super::seen::Seen;
use super::{Frame, Statistics, grow, share_of};
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::scene::{Aabb, BvhNode, Scene};
use crate::tasks::Work;
use crate::view::{Containment, Frustum, Planes};

/// The walk to the objects in the frustum is shared out in so many parts for each thread,
const WALKS_PER_THREAD: usize = 4;
/// but in no more than this: finding the parts is one thread's work.
const MOST_WALKS: usize = 64;

/// A node that meets the frustum, and the planes that its children still have to be tested against.
#[derive(Clone, Copy, Debug)]
struct Pending {
    node: u32,
    planes: Planes,
}

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct FrustumMemory {
    walks: Vec<Walk>,
    /// Bit `i` of the whole is set if object `i` meets the frustum.
    met: Vec<u64>,
}

/// What a task walks down, and what it finds.
#[derive(Debug, Default)]
struct Walk {
    stack: Vec<Pending>,
    found: Vec<u32>,
    /// How often what is found may cover the picture, in parts of 2⁻³²: sums of these do not depend on their order.
    covered: u64,
    /// The same of what may cover most of it.
    largest: u64,
}

/// What objects in a frustum may cover, at a guess: by Cauchy's formula a quarter of a box's area is what it shows, seen from
/// everywhere on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MayCover {
    /// How many times they may cover the picture.
    pub times: f64,
    /// How much of it the largest may.
    pub largest: f64,
}

/// Finds the objects whose boxes meet the frustum, in scene order, and what they may cover.
pub fn in_frustum(
    frame: &Frame<'_>,
    frustum: &Frustum,
    memory: &mut FrustumMemory,
    found: &mut Vec<u32>,
) -> MayCover {
    let scene = frame.scene;
    let FrustumMemory { walks, met } = memory;
    grow(walks, 1);
    walks[0].found.clear();
    walks[0].covered = 0;
    walks[0].largest = 0;
    walks[0].stack.clear();
    walks[0].stack.push(Pending {
        node: 0,
        planes: Planes::ALL,
    });
    let threads = frame.tasks.threads();
    let mut count = 1;
    if threads > 1 {
        count = (WALKS_PER_THREAD * threads).min(MOST_WALKS);
        frame
            .tasks
            .alone(Work::Select, || walks[0].until(frame, frustum, count));
        grow(walks, count);
        let (first, others) = walks.split_at_mut(1);
        let stack = &mut first[0].stack;
        for walk in &mut others[..count - 1] {
            walk.found.clear();
            walk.covered = 0;
            walk.largest = 0;
            walk.stack.clear();
            if stack.len() > 1 {
                walk.stack.extend(stack.pop());
            }
        }
    }
    let walks = &mut walks[..count];
    frame.tasks.each(Work::Select, walks, |_, walk| {
        walk.until(frame, frustum, usize::MAX);
    });
    frame.tasks.alone(Work::Select, || {
        met.clear();
        met.resize(scene.objects().len().div_ceil(64), 0);
        for &object in walks.iter().flat_map(|walk| &walk.found) {
            met[object as usize / 64] |= 1 << (object % 64);
        }
        found.clear();
        for (word, &met) in met.iter().enumerate() {
            let mut left = met;
            while left != 0 {
                found.push(64 * word as u32 + left.trailing_zeros());
                left &= left - 1;
            }
        }
    });
    let covered = walks.iter().map(|walk| walk.covered);
    let largest = walks.iter().map(|walk| walk.largest);
    MayCover {
        times: covered.sum::<u64>() as f64 / PARTS,
        largest: largest.max().unwrap_or(0) as f64 / PARTS,
    }
}

impl Walk {
    /// Walks on until so many nodes are left to visit, or none.
    fn until(&mut self, frame: &Frame<'_>, frustum: &Frustum, pending_nodes: usize) {
        let scene = frame.scene;
        let Walk {
            stack,
            found,
            covered,
            largest,
        } = self;
        let mut next = 0;
        while !stack.is_empty() && stack.len() < pending_nodes {
            // What is to be shared out is walked level by level, so that the shares are alike.
            let pending = if pending_nodes == usize::MAX {
                stack.pop()
            } else {
                next = (next + 1) % stack.len();
                Some(stack.swap_remove(next))
            };
            let Some(pending) = pending else { return };
            let node = &scene.bvh().nodes[pending.node as usize];
            if node.is_leaf() {
                for &object in objects_of(scene, node) {
                    let bounds = &scene.bounds()[object as usize];
                    if frustum.contains(bounds, pending.planes) != Containment::Outside {
                        found.push(object);
                        let part = covered_by(frustum, bounds, area_of(bounds));
                        *covered += part;
                        *largest = part.max(*largest);
                    }
                }
                continue;
            }
            let Containment::Meets(planes) = frustum.contains(&node.bounds(), pending.planes)
            else {
                continue;
            };
            if planes.is_empty() {
                found.extend_from_slice(frame.subtrees.objects(scene, pending.node));
                let [all, most] = frame.subtrees.areas[pending.node as usize];
                let by = |area: f32| covered_by(frustum, &node.bounds(), f64::from(area));
                *covered += by(all);
                *largest = by(most).max(*largest);
                continue;
            }
            for node in [node.first + 1, node.first] {
                stack.push(Pending { node, planes });
            }
        }
    }
}

/// The area of a box.
fn area_of(bounds: &Aabb) -> f64 {
    let [x, y, z] = bounds.size().to_array();
    2.0 * (x * y + y * z + z * x)
}

/// The share of the picture that boxes of this area within bounds may cover, in parts of 2⁻³².
fn covered_by(frustum: &Frustum, bounds: &Aabb, area: f64) -> u64 {
    let share = area * 0.25 / frustum.picture_area_at(bounds.center());
    // What is at the eye covers all of it, and so does what is not a number.
    let most = 4.0;
    ((if share < most { share } else { most }) * PARTS) as u64
}

/// Shares of the picture are counted in so many parts.
const PARTS: f64 = (1_u64 << 32) as f64;

/// The objects below each node of a scene's hierarchy: they are consecutive.
#[derive(Debug)]
pub struct Subtrees {
    objects: Vec<Range<u32>>,
    /// The areas of the boxes of the objects below each node, where they were when the hierarchy was built: of all together, and of
    /// the largest.
    areas: Vec<[f32; 2]>,
}

impl Subtrees {
    /// Those of a scene.
    pub fn new(scene: &Scene) -> Subtrees {
        let nodes = &scene.bvh().nodes;
        let range = |node: &BvhNode| {
            let (mut first, mut last) = (node, node);
            while first.count == 0 {
                first = &nodes[first.first as usize];
            }
            while last.count == 0 {
                last = &nodes[last.first as usize + 1];
            }
            first.first..last.first + last.count
        };
        let mut areas = vec![[0.0; 2]; nodes.len()];
        let both = |[a, b]: [f32; 2], [c, d]: [f32; 2]| [a + c, if d > b { d } else { b }];
        for (i, node) in nodes.iter().enumerate().rev() {
            areas[i] = if node.is_leaf() {
                let of_object =
                    |&object: &u32| [area_of(&scene.bounds()[object as usize]) as f32; 2];
                let of_objects = objects_of(scene, node).iter().map(of_object);
                of_objects.fold([0.0; 2], both)
            } else {
                let first = node.first as usize;
                both(areas[first], areas[first + 1])
            };
        }
        Subtrees {
            objects: nodes.iter().map(range).collect(),
            areas,
        }
    }

    /// How many objects are below a node.
    pub fn len(&self, node: u32) -> usize {
        self.objects[node as usize].len()
    }

    /// The objects below a node.
    pub fn objects<'a>(&self, scene: &'a Scene, node: u32) -> &'a [u32] {
        let Range { start, end } = self.objects[node as usize];
        &scene.bvh().objects[start as usize..end as usize]
    }
}

fn objects_of<'a>(scene: &'a Scene, node: &BvhNode) -> &'a [u32] {
    &scene.bvh().objects[node.first as usize..(node.first + node.count) as usize]
}

/// The children of a node with fewer objects than this below it are not asked: its objects are, one by one.
pub const FEWEST_OBJECTS: usize = 8;

/// When there are so many nodes to ask for each thread, they are shared out with all below them: a stage for each level of
/// the hierarchy would leave threads waiting for each other more than asking.
const NODES_PER_THREAD: usize = 16;
/// The shares are more than the threads, so that a long one does not hold up the others.
const LOOKS_PER_THREAD: usize = 4;

/// Memory that is kept from traversal to traversal.
#[derive(Debug, Default)]
pub struct TraverseMemory {
    looks: Vec<Look>,
}

/// What a task asks, and its answers.
#[derive(Debug, Default)]
struct Look {
    /// The nodes to visit next.
    level: Vec<u32>,
    /// And those after them.
    below: Vec<u32>,
    /// The nodes to ask.
    asked: Vec<u32>,
    footprints: Vec<Footprint>,
    tested: u64,
    hidden: Vec<u32>,
    /// Objects to ask.
    objects: Vec<u32>,
    /// Those that are not hidden.
    undecided: Vec<(u32, Footprint)>,
}

/// Marks all objects below nodes whose boxes are hidden behind what is drawn so far.
pub fn hide_subtrees(
    frame: &Frame<'_>,
    buffer: &OcclusionBuffer,
    memory: &mut TraverseMemory,
    hidden: &mut Marks,
    statistics: &mut Statistics,
) {
    for look in look(frame, None, buffer, memory) {
        statistics.nodes_tested += look.tested;
        statistics.nodes_hidden += look.hidden.len() as u64;
        for &node in &look.hidden {
            for &object in frame.subtrees.objects(frame.scene, node) {
                hidden.set(object);
            }
        }
    }
}

/// Finds the objects in the frustum that are not known to be hidden behind what is drawn so far, by their boxes' rectangles, in
/// no order.
pub fn not_hidden_so_far(
    frame: &Frame<'_>,
    seen: &Seen,
    buffer: &OcclusionBuffer,
    memory: &mut TraverseMemory,
    undecided: &mut Vec<(u32, Footprint)>,
    statistics: &mut Statistics,
) {
    undecided.clear();
    for look in look(frame, Some(seen), buffer, memory) {
        statistics.nodes_tested += look.tested;
        statistics.nodes_hidden += look.hidden.len() as u64;
        let below = look.hidden.iter().map(|&node| frame.subtrees.len(node));
        let hidden = look.objects.len() - look.undecided.len();
        statistics.objects_hidden += (below.sum::<usize>() + hidden) as u64;
        statistics.objects_asked += look.objects.len() as u64;
        undecided.extend_from_slice(&look.undecided);
    }
}

/// The same among given objects.
pub fn not_hidden_among(
    frame: &Frame<'_>,
    seen: &Seen,
    objects: &[u32],
    buffer: &OcclusionBuffer,
    memory: &mut TraverseMemory,
    undecided: &mut Vec<(u32, Footprint)>,
) {
    let frustum = frame.frustum(buffer.screen().camera());
    let share = match frame.tasks.threads() {
        1 => objects.len().max(1),
        threads => objects.len().div_ceil(LOOKS_PER_THREAD * threads).max(1),
    };
    let count = objects.len().div_ceil(share);
    grow(&mut memory.looks, count);
    let looks = &mut memory.looks[..count];
    frame.tasks.each(Work::Look, looks, |task, look| {
        look.begin(None);
        look.objects
            .extend_from_slice(share_of(objects, share, task));
        look.ask_objects(frame, seen, &frustum, buffer);
    });
    undecided.clear();
    for look in looks {
        undecided.extend_from_slice(&look.undecided);
    }
}

/// Walks down the hierarchy as far as nodes are not hidden; to objects, if it is known what the last frame has seen.
fn look<'m>(
    frame: &Frame<'_>,
    seen: Option<&Seen>,
    buffer: &OcclusionBuffer,
    memory: &'m mut TraverseMemory,
) -> &'m [Look] {
    let scene = frame.scene;
    let looks = &mut memory.looks;
    let frustum = frame.frustum(buffer.screen().camera());
    grow(looks, 1);
    looks[0].begin((!scene.bvh().nodes.is_empty()).then_some(0));
    let threads = frame.tasks.threads();
    let mut count = 1;
    if threads > 1 {
        frame.tasks.alone(Work::Look, || {
            looks[0].until(frame, seen, &frustum, buffer, NODES_PER_THREAD * threads);
        });
        count = (LOOKS_PER_THREAD * threads).min(looks[0].level.len().max(1));
        grow(looks, count);
        let (first, others) = looks.split_at_mut(1);
        let nodes = &mut first[0].level;
        let share = nodes.len().div_ceil(count);
        for look in &mut others[..count - 1] {
            let from = nodes.len().saturating_sub(share);
            look.begin(nodes.drain(from..));
        }
    }
    let looks = &mut looks[..count];
    frame.tasks.each(Work::Look, looks, |_, look| {
        look.until(frame, seen, &frustum, buffer, usize::MAX);
        if let Some(seen) = seen {
            look.ask_objects(frame, seen, &frustum, buffer);
        }
    });
    looks
}

impl Look {
    fn begin(&mut self, nodes: impl IntoIterator<Item = u32>) {
        self.objects.clear();
        self.undecided.clear();
        self.level.clear();
        self.level.extend(nodes);
        self.tested = 0;
        self.hidden.clear();
    }

    /// Asks level after level, until so many nodes are left to ask, or none.
    fn until(
        &mut self,
        frame: &Frame<'_>,
        seen: Option<&Seen>,
        frustum: &Frustum,
        buffer: &OcclusionBuffer,
        nodes: usize,
    ) {
        while !self.level.is_empty() && self.level.len() < nodes {
            self.ask_level(frame, seen, frustum, buffer);
            std::mem::swap(&mut self.level, &mut self.below);
        }
    }

    fn ask_level(
        &mut self,
        frame: &Frame<'_>,
        seen: Option<&Seen>,
        frustum: &Frustum,
        buffer: &OcclusionBuffer,
    ) {
        let scene = frame.scene;
        let node = |node: u32| &scene.bvh().nodes[node as usize];
        self.below.clear();
        self.asked.clear();
        for i in 0..self.level.len() {
            let index = self.level[i];
            // Of a part of a frame most nodes are out of the way.
            let is_whole = frame.region.is_none();
            if is_whole && seen.is_some_and(|seen| seen.was_open(index)) {
                self.go_below(frame, seen, index);
            } else {
                self.asked.push(index);
            }
        }
        self.footprints.clear();
        let boxes = self.asked.iter().map(|&index| node(index).bounds());
        let level = frame.settings.level;
        buffer
            .screen()
            .footprints_of_aabbs(level, boxes, &mut self.footprints);
        for i in 0..self.asked.len() {
            let (index, footprint) = (self.asked[i], self.footprints[i]);
            // What is nowhere on the screen is nobody's question. Of what reaches the near plane the frustum has to say so.
            let is_outside = match footprint {
                _ if { frame.region }.is_some_and(|region| region.misses(footprint)) => true,
                Footprint::Nowhere => true,
                Footprint::Within(_) => false,
                Footprint::Unbounded => {
                    frustum.contains(&node(index).bounds(), Planes::ALL) == Containment::Outside
                }
            };
            if is_outside {
                continue;
            }
            self.tested += 1;
            if buffer.hides(footprint) {
                self.hidden.push(index);
            } else {
                self.go_below(frame, seen, index);
            }
        }
    }

    fn go_below(&mut self, frame: &Frame<'_>, seen: Option<&Seen>, index: u32) {
        let node = &frame.scene.bvh().nodes[index as usize];
        if node.count == 0 && frame.subtrees.len(index) >= FEWEST_OBJECTS {
            self.below.extend([node.first, node.first + 1]);
        } else if seen.is_some() {
            let objects = frame.subtrees.objects(frame.scene, index);
            self.objects.extend_from_slice(objects);
        }
    }

    fn ask_objects(
        &mut self,
        frame: &Frame<'_>,
        seen: &Seen,
        frustum: &Frustum,
        buffer: &OcclusionBuffer,
    ) {
        let scene = frame.scene;
        let bounds = |&object: &u32| &scene.bounds()[object as usize];
        self.footprints.clear();
        buffer.screen().footprints_of_aabbs(
            frame.settings.level,
            self.objects.iter().map(bounds),
            &mut self.footprints,
        );
        let asked = self.objects.iter().zip(&self.footprints);
        let undecided = asked.filter(|&(object, &footprint)| {
            footprint != Footprint::Nowhere
                && !{ frame.region }.is_some_and(|region| region.misses(footprint))
                && (seen.is_trusted(*object) || !buffer.hides(footprint))
                && frustum.contains(bounds(object), Planes::ALL) != Containment::Outside
        });
        self.undecided
            .extend(undecided.map(|(&object, &footprint)| (object, footprint)));
    }
}
