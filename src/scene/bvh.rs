//! A bounding volume hierarchy over the objects' world boxes, built by obvhs (PLOC).

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

/// The hierarchy; node 0 is the root.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    /// All nodes.
    pub nodes: Vec<BvhNode>,
    /// Object indices in leaf order.
    pub objects: Vec<u32>,
}
