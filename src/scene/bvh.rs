//! A bounding volume hierarchy over the objects' world boxes, built by obvhs (PLOC).
//!
//! **Problem.** The frame asks about whole groups of objects at once, so near objects must share a node. PLOC (Meister
//! and Bittner, *Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction*, 2018, §3) sorts the
//! boxes along a Morton curve and merges mutual nearest neighbours.
//!
//! **Invariant.** Every object is in exactly one leaf; a node's box holds its children's, a leaf's box holds the f64
//! boxes of its objects; children come after their parent and lie side by side; the objects of any subtree are
//! consecutive in [`Bvh::objects`].
//!
//! obvhs decides only *which* boxes share a node. It sees the scene scaled to a unit cube, so that no area overflows
//! an f32 however large the world, and each box a little enlarged by an amount made from its index. That breaks ties:
//! in a row of equal boxes each one's nearest neighbour is the next one, only the last pair agrees, and one pair is
//! merged in each pass over all of them. (Rows, grids and nests of 20,000 boxes took a minute and made a chain as deep;
//! now 0.1 s and 32 levels: `rows_grids_and_heaps_of_equal_boxes_are_quick_and_shallow`.) The boxes of our nodes are
//! then made from the true ones.

use glam::{DVec3, Vec3A};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::Aabb;

/// One node of a [`Bvh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhNode {
    /// Smallest corner, rounded down from the f64 bounds.
    pub min: [f32; 3],
    /// Largest corner, rounded up from the f64 bounds.
    pub max: [f32; 3],
    /// An inner node: the index of its first child, the second follows it. A leaf: where its objects start in
    /// [`Bvh::objects`].
    pub first: u32,
    /// How many objects a leaf holds; 0 for an inner node.
    pub count: u32,
}

impl BvhNode {
    const UNSET: BvhNode = BvhNode {
        min: [f32::INFINITY; 3],
        max: [f32::NEG_INFINITY; 3],
        first: 0,
        count: 0,
    };

    /// Whether the node holds objects rather than children.
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }

    /// The node's box, exactly, in f64.
    pub fn bounds(&self) -> Aabb {
        Aabb {
            min: DVec3::from(self.min.map(f64::from)),
            max: DVec3::from(self.max.map(f64::from)),
        }
    }

    /// The area of its box.
    fn area(&self) -> f64 {
        let [x, y, z]: [f64; 3] =
            std::array::from_fn(|axis| f64::from(self.max[axis]) - f64::from(self.min[axis]));
        2.0 * (x * y + y * z + z * x)
    }

    fn include(&mut self, min: [f32; 3], max: [f32; 3]) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(min[axis]);
            self.max[axis] = self.max[axis].max(max[axis]);
        }
    }
}

/// The hierarchy; node 0 is the root.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    /// All nodes, parents before their children.
    pub nodes: Vec<BvhNode>,
    /// Object indices in leaf order; those of a subtree are consecutive.
    pub objects: Vec<u32>,
    /// The parent of each node; of the root, itself.
    parents: Vec<u32>,
    /// The leaf that holds each object.
    leaves: Vec<u32>,
    /// The areas of all nodes' boxes together, when they were built and now: what a ray, or a frustum, is likely to meet.
    built_area: f64,
    area: f64,
}

/// The hierarchy is built again when what has moved has made its boxes so many times as large.
const WORN: f64 = 2.0;

/// The largest f32 that is not above `x`.
fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x {
        nearest.next_down()
    } else {
        nearest
    }
}

/// The smallest f32 that is not below `x`.
fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

/// Six fractions in 0 to 1, the same for the same index on every machine (splitmix64; Steele, Lea and Flood, *Fast
/// Splittable Pseudorandom Number Generators*, 2014, figure 14).
fn tie_breakers(index: usize) -> [f32; 6] {
    let mut state = (index as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    std::array::from_fn(|_| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u32 << 24) as f32
    })
}

/// The boxes as obvhs is to see them: in a unit cube, and no two alike.
fn unit_boxes(bounds: &[Aabb]) -> Vec<obvhs::aabb::Aabb> {
    let world = bounds.iter().fold(Aabb::EMPTY, |all, &b| all.union(b));
    let longest = world.size().max_element();
    let scale = if longest > 0.0 { 1.0 / longest } else { 0.0 };
    let unit_box = |(index, b): (usize, &Aabb)| {
        let to_unit = |p: DVec3| Vec3A::from(((p - world.min) * scale).as_vec3());
        let (min, max) = (to_unit(b.min), to_unit(b.max));
        // A sixty-fourth of the box at most: it loses little. The constant is for boxes that are points.
        let slack = (max - min) * (1.0 / 64.0)
            + Vec3A::splat((max - min).max_element() / 256.0 + 1.0 / (1 << 20) as f32);
        let [a, b, c, d, e, f] = tie_breakers(index);
        obvhs::aabb::Aabb::new(
            min - slack * Vec3A::new(a, b, c),
            max + slack * Vec3A::new(d, e, f),
        )
    };
    bounds.iter().enumerate().map(unit_box).collect()
}

impl Bvh {
    /// Builds the hierarchy over finite boxes, one for each object; empty if there are none.
    pub(super) fn over(bounds: &[Aabb]) -> Bvh {
        if bounds.is_empty() {
            return Bvh::default();
        }
        let indices: Vec<u32> = (0..bounds.len() as u32).collect();
        // No threads inside: the same tree on any machine. 10,000 objects take 3 ms.
        let tree = PlocBuilder::new().build(
            PlocSearchDistance::Medium,
            &unit_boxes(bounds),
            indices,
            SortPrecision::U64,
            0,
        );
        let mut bvh = Bvh {
            nodes: vec![BvhNode::UNSET],
            objects: Vec::with_capacity(bounds.len()),
            ..Bvh::default()
        };
        bvh.nodes.reserve_exact(tree.nodes.len() - 1);
        let mut to_copy = vec![(0usize, 0usize)];
        while let Some((from, to)) = to_copy.pop() {
            let node = &tree.nodes[from];
            let (first, count) = (node.first_index as usize, node.prim_count as usize);
            if node.is_leaf() {
                bvh.nodes[to].first = bvh.objects.len() as u32;
                bvh.nodes[to].count = node.prim_count;
                bvh.objects
                    .extend_from_slice(&tree.primitive_indices[first..first + count]);
            } else {
                let pair = bvh.nodes.len();
                bvh.nodes[to].first = pair as u32;
                bvh.nodes.extend([BvhNode::UNSET; 2]);
                to_copy.extend([(first + 1, pair + 1), (first, pair)]);
            }
        }
        bvh.fit(bounds);
        bvh
    }

    /// Gives every node the smallest f32 box that holds what is below it, and finds what is above each.
    fn fit(&mut self, bounds: &[Aabb]) {
        self.parents = vec![0; self.nodes.len()];
        self.leaves = vec![0; bounds.len()];
        self.area = 0.0;
        for i in (0..self.nodes.len()).rev() {
            let node = self.fitted(i, bounds);
            let first = node.first as usize;
            if node.is_leaf() {
                for &object in &self.objects[first..first + node.count as usize] {
                    self.leaves[object as usize] = i as u32;
                }
            } else {
                self.parents[first..first + 2].fill(i as u32);
            }
            self.area += node.area();
            self.nodes[i] = node;
        }
        self.built_area = self.area;
    }

    /// A node with the smallest f32 box that holds what is below it, whose boxes are right.
    fn fitted(&self, index: usize, bounds: &[Aabb]) -> BvhNode {
        let mut node = BvhNode {
            first: self.nodes[index].first,
            count: self.nodes[index].count,
            ..BvhNode::UNSET
        };
        let first = node.first as usize;
        if node.is_leaf() {
            for &object in &self.objects[first..first + node.count as usize] {
                let b = bounds[object as usize];
                node.include(
                    b.min.to_array().map(round_down),
                    b.max.to_array().map(round_up),
                );
            }
        } else {
            for child in [self.nodes[first], self.nodes[first + 1]] {
                node.include(child.min, child.max);
            }
        }
        node
    }

    /// Fits the nodes that hold an object whose box is another now.
    pub(super) fn refit(&mut self, object: u32, bounds: &[Aabb]) {
        let mut index = self.leaves[object as usize] as usize;
        loop {
            let node = self.fitted(index, bounds);
            let before = std::mem::replace(&mut self.nodes[index], node);
            if node == before {
                return;
            }
            self.area += node.area() - before.area();
            if index == 0 {
                return;
            }
            index = self.parents[index] as usize;
        }
    }

    /// Whether what has moved has made the boxes so large that another hierarchy would be better.
    pub(super) fn is_worn(&self) -> bool {
        self.area > self.built_area * WORN
    }

    /// The node above a node; of the root, itself.
    pub(crate) fn parent_of(&self, node: u32) -> u32 {
        self.parents[node as usize]
    }

    /// The leaf that holds an object.
    pub(crate) fn leaf_of(&self, object: u32) -> u32 {
        self.leaves[object as usize]
    }

    /// How many nodes the longest way from the root to a leaf has: 1 for a root that is a leaf, 0 for no nodes. A
    /// traversal that keeps the sibling on a stack needs at most that many places.
    pub fn depth(&self) -> usize {
        let mut depth_of = vec![1; self.nodes.len()];
        for i in (0..self.nodes.len())
            .rev()
            .filter(|&i| !self.nodes[i].is_leaf())
        {
            let first = self.nodes[i].first as usize;
            depth_of[i] = 1 + depth_of[first].max(depth_of[first + 1]);
        }
        depth_of.first().copied().unwrap_or(0)
    }

    /// A hierarchy of which each node's [`first`](BvhNode::first) and [`count`](BvhNode::count) are known, and the order of
    /// the objects; the boxes are found from theirs.
    ///
    /// # Errors
    /// The first broken rule, see [`Bvh::validate`].
    pub(super) fn relinked(
        links: impl IntoIterator<Item = [u32; 2]>,
        objects: Vec<u32>,
        bounds: &[Aabb],
    ) -> Result<Bvh, String> {
        let node = |[first, count]: [u32; 2]| BvhNode {
            first,
            count,
            ..BvhNode::UNSET
        };
        let nodes = links.into_iter().map(node).collect();
        let mut bvh = Bvh {
            nodes,
            objects,
            ..Bvh::default()
        };
        bvh.check_links(bounds.len())?;
        bvh.fit(bounds);
        Ok(bvh)
    }

    /// Checks the hierarchy against the boxes it stands for, one for each object.
    ///
    /// # Errors
    /// The first broken rule: an object in no leaf or in several, an index out of range or before its parent, a subtree
    /// whose objects are not consecutive, a node that does not hold its children, a leaf that does not hold its objects.
    pub fn validate(&self, bounds: &[Aabb]) -> Result<(), String> {
        self.check_links(bounds.len())?;
        for (i, node) in self.nodes.iter().enumerate() {
            let (first, count) = (node.first as usize, node.count as usize);
            if node.is_leaf() {
                for &object in &self.objects[first..first + count] {
                    if !node.bounds().contains(bounds[object as usize]) {
                        return Err(format!("leaf {i} does not hold object {object}"));
                    }
                }
                continue;
            }
            for child in [first, first + 1] {
                if !node.bounds().contains(self.nodes[child].bounds()) {
                    return Err(format!("node {i} does not hold its child {child}"));
                }
            }
        }
        Ok(())
    }

    /// Checks everything but the boxes.
    fn check_links(&self, objects: usize) -> Result<(), String> {
        let mut seen = vec![false; objects];
        let mut reached = vec![false; self.nodes.len()];
        let mut to_visit = Vec::new();
        if !self.nodes.is_empty() {
            reached[0] = true;
            to_visit.push(0);
        }
        while let Some(i) = to_visit.pop() {
            let node = self.nodes[i];
            let (first, count) = (node.first as usize, node.count as usize);
            if node.is_leaf() {
                let objects = first.checked_add(count);
                let objects = objects
                    .and_then(|end| self.objects.get(first..end))
                    .ok_or_else(|| format!("leaf {i} is out of range"))?;
                for &object in objects {
                    let seen = seen
                        .get_mut(object as usize)
                        .ok_or_else(|| format!("leaf {i}: no object {object}"))?;
                    if std::mem::replace(seen, true) {
                        return Err(format!("object {object} is in two leaves"));
                    }
                }
                continue;
            }
            for child in [first, first.saturating_add(1)] {
                if child <= i || child >= self.nodes.len() {
                    return Err(format!("node {i} has child {child}"));
                }
                if std::mem::replace(&mut reached[child], true) {
                    return Err(format!("node {child} has two parents"));
                }
                to_visit.push(child);
            }
        }
        match (
            seen.iter().position(|s| !s),
            reached.iter().position(|r| !r),
        ) {
            (Some(object), _) => return Err(format!("object {object} is in no leaf")),
            (_, Some(node)) => return Err(format!("node {node} has no parent")),
            _ if self.objects.len() > objects => {
                return Err("there are more objects in its order than in the scene".to_owned());
            }
            _ => {}
        }
        self.check_order()
    }

    /// Checks that the objects of each subtree are consecutive, those of the first child first. Children come after their
    /// parents.
    fn check_order(&self) -> Result<(), String> {
        let mut below = vec![0..0; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate().rev() {
            let first = node.first as usize;
            below[i] = if node.is_leaf() {
                first..first + node.count as usize
            } else if below[first].end == below[first + 1].start {
                below[first].start..below[first + 1].end
            } else {
                return Err(format!("the objects below node {i} are not consecutive"));
            };
        }
        Ok(())
    }
}
