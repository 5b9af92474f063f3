//! Which triangles stand together in a cluster.
//!
//! From the top down: a set of n triangles that fills c = ⌈n / 64⌉ clusters is cut in two where the cut leaves c
//! clusters still. Of those cuts, along each axis of the triangles' middles and of their normals, the one of least
//! cost is taken: the surface area heuristic (Goldsmith and Salmon 1987), triangles × area of their box, times the
//! share of directions from which the side's triangles do not all look away, where they have but one side. Large sets
//! are cut in the middle of their longest axis, which is faster and hardly differs.

use glam::DVec3;

use super::local_box::LocalBox;
use super::position_set::PositionSet;
use super::{TRIANGLES_PER_CLUSTER, VERTICES_PER_CLUSTER};
use crate::scene::Mesh;

/// Sets above this size are cut in the middle.
const SWEEP_AT_MOST: usize = 1024;

/// The smaller side of a cut has at least one in this many of the triangles: few cuts lie above any cluster.
const LEAST_SHARE: usize = 8;

/// A triangle to find a cluster for.
#[derive(Clone, Copy)]
struct Item {
    /// The sum of its corners: three times its middle.
    middle: [f32; 3],
    /// Its index in the mesh.
    triangle: usize,
}

/// Cuts `triangles`, indices into the mesh's, into clusters: each at most [`TRIANGLES_PER_CLUSTER`] triangles with at
/// most [`VERTICES_PER_CLUSTER`] distinct positions. Each cluster's are in ascending order.
pub(super) fn partition(mesh: &Mesh, triangles: Vec<usize>, one_sided: bool) -> Vec<Vec<usize>> {
    let mut items: Vec<Item> = triangles
        .into_iter()
        .map(|triangle| {
            let [a, b, c] = corners(mesh, triangle);
            Item {
                middle: std::array::from_fn(|axis| a[axis] + b[axis] + c[axis]),
                triangle,
            }
        })
        .collect();
    if items.is_empty() {
        Vec::new()
    } else {
        cut_in_the_middle(mesh, &mut items, one_sided)
    }
}

pub(super) fn corners(mesh: &Mesh, triangle: usize) -> [[f32; 3]; 3] {
    mesh.triangles[triangle].map(|i| mesh.positions[i as usize])
}

/// An integer that orders as the number does.
fn ordered(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 {
        bits | 1 << 31
    } else {
        !bits
    }
}

fn cut_in_the_middle(mesh: &Mesh, items: &mut [Item], one_sided: bool) -> Vec<Vec<usize>> {
    if items.len() <= SWEEP_AT_MOST {
        return Sweep::over(mesh, items, one_sided).cut();
    }
    let size = LocalBox::around(items.iter().map(|i| i.middle)).size();
    let axis = (1..3).fold(0, |best, a| if size[a] > size[best] { a } else { best });
    let clusters = items.len().div_ceil(TRIANGLES_PER_CLUSTER);
    let at = clusters / 2 * TRIANGLES_PER_CLUSTER;
    items.select_nth_unstable_by_key(at, |i| (ordered(i.middle[axis]), i.triangle));
    let (left, right) = items.split_at_mut(at);
    let (mut left, right) = rayon::join(
        || cut_in_the_middle(mesh, left, one_sided),
        || cut_in_the_middle(mesh, right, one_sided),
    );
    left.extend(right);
    left
}

/// What the cost of a side is made of.
#[derive(Clone, Copy)]
struct Side {
    bounds: LocalBox,
    normals: DVec3,
    triangles: usize,
}

impl Side {
    const EMPTY: Side = Side {
        bounds: LocalBox::EMPTY,
        normals: DVec3::ZERO,
        triangles: 0,
    };

    fn add(&mut self, piece: &Piece) {
        self.bounds = self.bounds.union(piece.bounds);
        self.normals += piece.normal;
        self.triangles += 1;
    }

    fn cost(&self, one_sided: bool) -> f64 {
        let triangles = self.triangles as f64;
        let drawn = triangles * self.bounds.half_area();
        if !one_sided {
            return drawn;
        }
        // Unit normals spread evenly over a cap of half angle θ have a mean of length (1 + cos θ) / 2, and all of them
        // look away from a share (1 − sin θ) / 2 of all directions.
        let cosine = 2.0 * (self.normals.length() / triangles) - 1.0;
        if cosine <= 0.0 {
            drawn
        } else {
            let sine_squared = 1.0 - cosine * cosine;
            let sine = if sine_squared > 0.0 {
                sine_squared.sqrt()
            } else {
                0.0
            };
            drawn * (0.5 + 0.5 * sine)
        }
    }
}

/// A triangle as cuts see it.
struct Piece {
    bounds: LocalBox,
    /// Unit normal; zero for a triangle without area.
    normal: DVec3,
    /// Where the triangle comes along each axis: three of its middle, three of its normal.
    keys: [u32; 6],
    triangle: usize,
}

impl Piece {
    fn new(mesh: &Mesh, item: &Item) -> Piece {
        let corners = corners(mesh, item.triangle);
        let bounds = LocalBox::around(corners);
        let [a, b, c] = corners.map(|c| DVec3::from(c.map(f64::from)));
        let across = (b - a).cross(c - a);
        let length = across.length();
        let normal = if length > 0.0 {
            across / length
        } else {
            DVec3::ZERO
        };
        let [x, y, z] = item.middle;
        let keys = [x, y, z, normal.x as f32, normal.y as f32, normal.z as f32].map(ordered);
        Piece {
            bounds,
            normal,
            keys,
            triangle: item.triangle,
        }
    }
}

/// Cuts a set of at most [`SWEEP_AT_MOST`] triangles, and each part again.
struct Sweep<'a> {
    mesh: &'a Mesh,
    one_sided: bool,
    /// In ascending order of triangles.
    pieces: Vec<Piece>,
    /// A set in order along one axis: its key above, its index in `pieces` below.
    order: Vec<u64>,
    best_order: Vec<u64>,
    /// The cost of the first 0, 1, 2 … of an order, where it may be cut.
    left_costs: Vec<f64>,
    positions: PositionSet,
    clusters: Vec<Vec<usize>>,
}

impl<'a> Sweep<'a> {
    fn over(mesh: &'a Mesh, items: &mut [Item], one_sided: bool) -> Sweep<'a> {
        items.sort_unstable_by_key(|i| i.triangle);
        Sweep {
            mesh,
            one_sided,
            pieces: items.iter().map(|item| Piece::new(mesh, item)).collect(),
            order: Vec::new(),
            best_order: Vec::new(),
            left_costs: Vec::new(),
            positions: PositionSet::new(),
            clusters: Vec::new(),
        }
    }

    fn cut(mut self) -> Vec<Vec<usize>> {
        let mut all: Vec<u32> = (0..self.pieces.len() as u32).collect();
        self.cut_set(&mut all);
        self.clusters
    }

    fn cut_set(&mut self, set: &mut [u32]) {
        let clusters = set.len().div_ceil(TRIANGLES_PER_CLUSTER);
        if clusters == 1 && self.has_room_for_vertices(set) {
            set.sort_unstable();
            let triangles = set.iter().map(|&i| self.pieces[i as usize].triangle);
            self.clusters.push(triangles.collect());
            return;
        }
        let at = self.find_cut(set, clusters.max(2));
        let (left, right) = set.split_at_mut(at);
        self.cut_set(left);
        self.cut_set(right);
    }

    fn has_room_for_vertices(&mut self, set: &[u32]) -> bool {
        if 3 * set.len() <= VERTICES_PER_CLUSTER {
            return true;
        }
        self.positions.clear();
        for &i in set {
            for corner in corners(self.mesh, self.pieces[i as usize].triangle) {
                self.positions.insert(corner);
            }
        }
        self.positions.positions().len() <= VERTICES_PER_CLUSTER
    }

    /// Sorts a set along the axis of its cheapest cut into parts of `clusters` in all, and says where that is.
    fn find_cut(&mut self, set: &mut [u32], clusters: usize) -> usize {
        let count = set.len();
        let least = (count / LEAST_SHARE).max(1);
        let filled_by = |triangles: usize| triangles.div_ceil(TRIANGLES_PER_CLUSTER);
        let may_cut = |at: usize| filled_by(at) + filled_by(count - at) <= clusters;
        // Were every cost equal, the middle would do.
        let middle = (clusters / 2 * TRIANGLES_PER_CLUSTER).min(count / 2);
        let mut best = (f64::INFINITY, middle);
        self.best_order.clear();
        for axis in 0..if self.one_sided { 6 } else { 3 } {
            self.order.clear();
            self.order.extend(set.iter().map(|&i| {
                let key = self.pieces[i as usize].keys[axis];
                u64::from(key) << 32 | u64::from(i)
            }));
            self.order.sort_unstable();
            let piece = |key: u64| &self.pieces[(key & u64::from(u32::MAX)) as usize];

            let mut left = Side::EMPTY;
            self.left_costs.clear();
            self.left_costs.push(0.0);
            for (&key, at) in self.order[..count - least].iter().zip(1..) {
                left.add(piece(key));
                let cost = if may_cut(at) {
                    left.cost(self.one_sided)
                } else {
                    0.0
                };
                self.left_costs.push(cost);
            }
            let mut right = Side::EMPTY;
            let mut is_best = self.best_order.is_empty();
            for at in (least..count).rev() {
                right.add(piece(self.order[at]));
                if at <= count - least && may_cut(at) {
                    let cost = self.left_costs[at] + right.cost(self.one_sided);
                    if cost < best.0 {
                        best = (cost, at);
                        is_best = true;
                    }
                }
            }
            if is_best {
                std::mem::swap(&mut self.order, &mut self.best_order);
            }
        }
        for (i, &key) in set.iter_mut().zip(&self.best_order) {
            *i = key as u32;
        }
        best.1
    }
}
