//! Which triangles stand together in a cluster.
//!
//! From the top down: a set of n triangles that fills c = ⌈n / 64⌉ clusters is cut in two where the cut leaves c
//! clusters still. Of those cuts, along each axis of the triangles' middles and of their normals, the one of least
//! cost is taken. That is the surface area heuristic (Goldsmith and Salmon 1987): what a side takes to draw, times the
//! area of its box, times the share of directions from which its triangles do not all look away, if they have but one
//! side. A vertex takes as much to draw as a triangle; to count vertices makes neighbours stay together, which spares
//! up to a tenth of them. Large sets are cut in the middle of their longest axis, which is faster.

use super::cost::{Piece, Seen, Side, middle, ordered};
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
    /// Three times its middle.
    middle: [f32; 3],
    /// Its index in the mesh.
    triangle: usize,
}

/// Cuts `triangles`, indices into the mesh's, into clusters: each at most [`TRIANGLES_PER_CLUSTER`] triangles with at
/// most [`VERTICES_PER_CLUSTER`] distinct positions. Each cluster's are in ascending order.
pub(super) fn partition(mesh: &Mesh, triangles: Vec<usize>, one_sided: bool) -> Vec<Vec<usize>> {
    let mut items: Vec<Item> = triangles
        .into_iter()
        .map(|triangle| Item {
            middle: middle(corners(mesh, triangle)),
            triangle,
        })
        .collect();
    if items.is_empty() {
        Vec::new()
    } else {
        cut_in_the_middle(mesh, &mut items, one_sided)
    }
}

/// A triangle's corners, local units.
pub(super) fn corners(mesh: &Mesh, triangle: usize) -> [[f32; 3]; 3] {
    mesh.triangles[triangle].map(|i| mesh.positions[i as usize])
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

/// Cuts a set of at most [`SWEEP_AT_MOST`] triangles, and each part again.
struct Sweep {
    one_sided: bool,
    /// In ascending order of triangles.
    pieces: Vec<Piece>,
    /// A set in order along one axis: its key above, its index in `pieces` below.
    order: Vec<u64>,
    best_order: Vec<u64>,
    /// The cost of the first 0, 1, 2 … of an order, where it may be cut.
    left_costs: Vec<f64>,
    seen: Seen,
    clusters: Vec<Vec<usize>>,
}

impl Sweep {
    fn over(mesh: &Mesh, items: &mut [Item], one_sided: bool) -> Sweep {
        items.sort_unstable_by_key(|i| i.triangle);
        let mut positions = PositionSet::for_triangles(items.len());
        let pieces = items
            .iter()
            .map(|i| Piece::new(i.triangle, corners(mesh, i.triangle), &mut positions));
        let pieces: Vec<Piece> = pieces.collect();
        let seen = Seen::of(positions.into_positions().len());
        Sweep {
            one_sided,
            pieces,
            order: Vec::new(),
            best_order: Vec::new(),
            left_costs: Vec::new(),
            seen,
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
        self.seen.clear();
        let vertices = set.iter().map(|&i| self.pieces[i as usize].vertices);
        vertices.map(|v| self.seen.add(v)).sum::<usize>() <= VERTICES_PER_CLUSTER
    }

    /// Sorts a set along the axis of its cheapest cut into parts of `clusters` in all, and says where that is.
    fn find_cut(&mut self, set: &mut [u32], clusters: usize) -> usize {
        let count = set.len();
        let least = (count / LEAST_SHARE).max(1);
        let filled_by = |triangles: usize| triangles.div_ceil(TRIANGLES_PER_CLUSTER);
        let may_cut = |at: usize| filled_by(at) + filled_by(count - at) <= clusters;
        let halfway = (clusters / 2 * TRIANGLES_PER_CLUSTER).min(count / 2);
        let mut best = (f64::INFINITY, halfway);
        self.best_order.clear();
        for axis in 0..if self.one_sided { 6 } else { 3 } {
            self.order.clear();
            self.order.extend(set.iter().map(|&i| {
                let key = self.pieces[i as usize].keys[axis];
                u64::from(key) << 32 | u64::from(i)
            }));
            self.order.sort_unstable();
            let piece = |key: u64| &self.pieces[(key & u64::from(u32::MAX)) as usize];

            self.seen.clear();
            let mut left = Side::EMPTY;
            self.left_costs.clear();
            self.left_costs.push(0.0);
            for (&key, at) in self.order[..count - least].iter().zip(1..) {
                left.add(piece(key), &mut self.seen);
                let cost = if may_cut(at) {
                    left.cost(self.one_sided)
                } else {
                    0.0
                };
                self.left_costs.push(cost);
            }
            self.seen.clear();
            let mut right = Side::EMPTY;
            let mut is_best = self.best_order.is_empty();
            for at in (least..count).rev() {
                right.add(piece(self.order[at]), &mut self.seen);
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
