//! Sampled visibility (HOM §7.5): what is seen from viewpoints on a regular grid, found once for a scene.
//!
//! For each viewpoint the grid lists clusters that own much of what is seen around it, each with the solid angle that it owns.
//! A frame takes the list of the viewpoint next to its eye as occluders. The list only chooses: what it is wrong about costs time and
//! hides nothing, since every cluster is drawn from where the eye really is.
//!
//! Lists are kept in one row, in the order of the clusters' ids, so that a frame finds all clusters of an object together; a budget
//! takes them by [`SampledCluster::worth`].

use glam::DVec3;
use thiserror::Error;

use super::{CLUSTER_COST, ClusterId, ClusteredScene};
use crate::scene::{Aabb, Scene};

/// The most viewpoints that a grid has.
pub const MOST_VIEWPOINTS: u64 = 1 << 20;

/// The most clusters in the list of a viewpoint.
pub const MOST_CLUSTERS_PER_VIEWPOINT: usize = 1 << 14;

/// An eye is near a viewpoint up to this share of the spacing: a little more than half of a cell's diagonal, so that there is always
/// a viewpoint near an eye in the grid.
const REACH: f64 = 0.87;

/// A grid, or the bytes of one, that cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum VisibilityGridError {
    /// The spacing is not a positive finite number, or the box that is to be filled has no finite extent.
    #[error("no grid can be laid out: {0}")]
    Layout(&'static str),
    /// There would be more viewpoints than a grid may have.
    #[error(
        "the grid would have {viewpoints} viewpoints, but {MOST_VIEWPOINTS} are the most: choose a larger spacing"
    )]
    TooMany {
        /// How many there would be.
        viewpoints: u64,
    },
    /// The bytes are not those of a grid.
    #[error("the visibility grid is damaged: {0}")]
    Damaged(&'static str),
    /// The grid names a cluster that the scene does not have.
    #[error(
        "the visibility grid is of another scene: it names cluster {} of object {}",
        .0.cluster,
        .0.object
    )]
    OtherScene(ClusterId),
    /// No threads are to be had.
    #[error("no threads: {0}")]
    Threads(String),
}

/// Where the viewpoints of a grid stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridLayout {
    /// The first viewpoint: the one with the least coordinates, in world units.
    pub first: DVec3,
    /// The distance between neighbours along each axis, in world units.
    pub spacing: f64,
    /// How many there are along each axis, each at least 1.
    pub counts: [u32; 3],
}

impl GridLayout {
    /// Fills a box: none of its points is farther than half the spacing from a viewpoint along any axis.
    ///
    /// # Errors
    /// If the box or the spacing is not finite and positive, or there would be too many viewpoints.
    pub fn with_spacing(bounds: &Aabb, spacing: f64) -> Result<GridLayout, VisibilityGridError> {
        let size = bounds.size();
        let is_sound = bounds.min.is_finite() && size.is_finite() && size.min_element() >= 0.0;
        if !is_sound {
            return Err(VisibilityGridError::Layout("the box is not finite"));
        }
        let is_positive = spacing.is_finite() && spacing > 0.0;
        if !is_positive {
            return Err(VisibilityGridError::Layout(
                "the spacing is not a finite number above 0",
            ));
        }
        // A cast saturates.
        let counts = size
            .to_array()
            .map(|side| (side / spacing).ceil().max(1.0) as u32);
        let layout = GridLayout {
            first: DVec3::from(std::array::from_fn::<f64, 3, _>(|axis| {
                let span = f64::from(counts[axis] - 1) * spacing;
                bounds.center()[axis] - 0.5 * span
            })),
            spacing,
            counts,
        };
        layout.check()?;
        Ok(layout)
    }

    /// Fills a box with at most so many viewpoints, as densely as that allows.
    ///
    /// # Errors
    /// If the box is not finite or `viewpoints` is 0.
    pub fn with_viewpoints(
        bounds: &Aabb,
        viewpoints: u64,
    ) -> Result<GridLayout, VisibilityGridError> {
        if viewpoints == 0 {
            return Err(VisibilityGridError::Layout("it would have no viewpoints"));
        }
        // With the whole box to each viewpoint there is one; halving finds what still fits.
        let mut widest = bounds.size().max_element().max(f64::MIN_POSITIVE);
        let fits = |spacing: f64| {
            GridLayout::with_spacing(bounds, spacing).is_ok_and(|l| l.viewpoints() <= viewpoints)
        };
        let mut narrowest = 0.0;
        for _ in 0..64 {
            let middle = 0.5 * (narrowest + widest);
            if fits(middle) {
                widest = middle;
            } else {
                narrowest = middle;
            }
        }
        GridLayout::with_spacing(bounds, widest)
    }

    /// How many viewpoints there are.
    pub fn viewpoints(&self) -> u64 {
        let counts = self.counts.map(u64::from);
        // Anything above the limit is too many.
        counts[0]
            .saturating_mul(counts[1])
            .saturating_mul(counts[2])
    }

    /// A viewpoint by its number: x counts fastest, then y, then z.
    pub fn viewpoint(&self, number: usize) -> DVec3 {
        let [across, up, _] = self.counts.map(|count| count as usize);
        let place = [number % across, number / across % up, number / across / up];
        self.first + DVec3::from(place.map(|i| i as f64)) * self.spacing
    }

    /// Checks that viewpoints can stand there.
    ///
    /// # Errors
    /// If there are none or too many, the spacing is not positive, or a coordinate is not finite or beyond what a camera may have.
    pub fn check(&self) -> Result<(), VisibilityGridError> {
        let viewpoints = self.viewpoints();
        if viewpoints > MOST_VIEWPOINTS {
            return Err(VisibilityGridError::TooMany { viewpoints });
        }
        if viewpoints == 0 {
            return Err(VisibilityGridError::Layout("it would have no viewpoints"));
        }
        let is_positive = self.spacing.is_finite() && self.spacing > 0.0;
        let last = self.viewpoint(viewpoints as usize - 1);
        // What a camera may be given as its eye.
        let in_reach = |v: DVec3| v.abs().cmple(DVec3::splat(1e30)).all();
        if is_positive && in_reach(self.first) && in_reach(last) {
            Ok(())
        } else {
            Err(VisibilityGridError::Layout(
                "its coordinates are not finite",
            ))
        }
    }

    /// The viewpoint nearest to an eye of those around it that `is_wanted` says, if one is near enough.
    fn nearest(&self, eye: DVec3, is_wanted: impl Fn(usize) -> bool) -> Option<usize> {
        let cell = ((eye - self.first) / self.spacing).floor();
        let [across, up, deep] = self.counts.map(i64::from);
        let mut best: Option<(f64, usize)> = None;
        for corner in 0..8 {
            let offset = |axis: usize| i64::from(corner >> axis & 1);
            // A cast saturates: what is far away stays out of range.
            let [x, y, z] = [0, 1, 2].map(|axis| (cell[axis] as i64).saturating_add(offset(axis)));
            let in_range = |at: i64, count: i64| (0..count).contains(&at);
            if !(in_range(x, across) && in_range(y, up) && in_range(z, deep)) {
                continue;
            }
            let number = ((z * up + y) * across + x) as usize;
            let distance = (eye - self.viewpoint(number)).length();
            let is_near = distance <= REACH * self.spacing;
            if is_near && is_wanted(number) && best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, number));
            }
        }
        best.map(|(_, number)| number)
    }
}

/// A cluster that is seen from a viewpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledCluster {
    /// Which.
    pub id: ClusterId,
    /// The part of the sphere around the viewpoint at which it is what is seen first, in steradians: 4π is all.
    pub solid_angle: f32,
}

impl SampledCluster {
    /// How much it may hide for what it costs to draw: steradians a triangle. A cluster costs as much as some triangles, besides
    /// its own.
    pub fn worth(&self, triangles: u32) -> f32 {
        self.solid_angle / (triangles + CLUSTER_COST) as f32
    }
}

/// For viewpoints on a regular grid, the clusters that own most of what is seen around each.
///
/// Made by [`sample_visibility`](crate::sampling::sample_visibility), kept as bytes ([`VisibilityGrid::to_bytes`]), used by a culler
/// that is given it ([`Culler::set_visibility_grid`](crate::cull::Culler::set_visibility_grid)).
#[derive(Clone, Debug, PartialEq)]
pub struct VisibilityGrid {
    pub(super) layout: GridLayout,
    /// Where each viewpoint's list begins; one more than there are viewpoints.
    pub(super) starts: Vec<u32>,
    /// All lists, each in the order of ids, which differ.
    pub(super) clusters: Vec<SampledCluster>,
}

impl VisibilityGrid {
    /// Puts lists together, one for each viewpoint in order.
    ///
    /// # Errors
    /// If the layout cannot be used, there are not as many lists as viewpoints, a list is not strictly in the order of ids or longer
    /// than [`MOST_CLUSTERS_PER_VIEWPOINT`], or a solid angle is not within 0 and 4π.
    pub fn new(
        layout: GridLayout,
        lists: &[Vec<SampledCluster>],
    ) -> Result<VisibilityGrid, VisibilityGridError> {
        let mut starts = vec![0];
        let mut clusters = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        for list in lists {
            clusters.extend_from_slice(list);
            let end = u32::try_from(clusters.len());
            starts.push(end.map_err(|_| VisibilityGridError::Layout("its lists are too long"))?);
        }
        let grid = VisibilityGrid {
            layout,
            starts,
            clusters,
        };
        grid.check()?;
        Ok(grid)
    }

    /// Where the viewpoints stand.
    pub fn layout(&self) -> &GridLayout {
        &self.layout
    }

    /// How many clusters all lists name together.
    pub fn len(&self) -> usize {
        self.clusters.len()
    }

    /// Whether all lists are empty.
    pub fn is_empty(&self) -> bool {
        self.clusters.is_empty()
    }

    /// What the grid takes in memory, in bytes: 4 a viewpoint, 12 for each cluster of its list.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.clusters[..])
    }

    /// The clusters that are seen from a viewpoint, in the order of their ids; none if there is no such viewpoint.
    pub fn seen_from(&self, viewpoint: usize) -> &[SampledCluster] {
        match self.starts.get(viewpoint..) {
            Some([start, end, ..]) => &self.clusters[*start as usize..*end as usize],
            _ => &[],
        }
    }

    /// The viewpoint that an eye snaps to: the nearest from which something is seen. None where the eye is too far from any.
    pub fn viewpoint_near(&self, eye: DVec3) -> Option<usize> {
        self.layout
            .nearest(eye, |number| !self.seen_from(number).is_empty())
    }

    /// Whether every cluster is one of a scene's.
    ///
    /// # Errors
    /// If one is not.
    pub fn check_scene(
        &self,
        scene: &Scene,
        clusters: &ClusteredScene,
    ) -> Result<(), VisibilityGridError> {
        let is_known = |id: &ClusterId| {
            let object = scene.objects().get(id.object as usize);
            let mesh = object.and_then(|object| clusters.occluder(object));
            mesh.is_some_and(|mesh| (id.cluster as usize) < mesh.clusters().len())
        };
        match self.clusters.iter().find(|seen| !is_known(&seen.id)) {
            Some(unknown) => Err(VisibilityGridError::OtherScene(unknown.id)),
            None => Ok(()),
        }
    }

    /// Checks what holds for any grid, whatever the scene.
    pub(super) fn check(&self) -> Result<(), VisibilityGridError> {
        self.layout.check()?;
        let damaged = |why| Err(VisibilityGridError::Damaged(why));
        let ends_match = self.starts.first() == Some(&0)
            && self.starts.last().map(|&end| end as usize) == Some(self.clusters.len());
        if self.starts.len() as u64 != self.layout.viewpoints() + 1 || !ends_match {
            return damaged("it has not a list for each viewpoint");
        }
        for ends in self.starts.windows(2) {
            if ends[0] > ends[1] || (ends[1] - ends[0]) as usize > MOST_CLUSTERS_PER_VIEWPOINT {
                return damaged("a list has an impossible length");
            }
        }
        for viewpoint in 0..self.starts.len() - 1 {
            let list = self.seen_from(viewpoint);
            if !list.is_sorted_by(|a, b| a.id < b.id) {
                return damaged("a list is not in order");
            }
            // A little more than all directions: sums are rounded.
            let possible = 0.0..=13.0;
            if !list.iter().all(|seen| possible.contains(&seen.solid_angle)) {
                return damaged("a solid angle is not within 0 and 4 pi");
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(counts: [u32; 3]) -> GridLayout {
        GridLayout {
            first: DVec3::new(1.0, 2.0, 3.0),
            spacing: 2.0,
            counts,
        }
    }

    fn seen(object: u32) -> SampledCluster {
        SampledCluster {
            id: ClusterId { object, cluster: 0 },
            solid_angle: 0.5,
        }
    }

    #[test]
    fn an_eye_snaps_to_the_nearest_viewpoint_that_sees_something() {
        let lists: Vec<_> = (0..24).map(|i| vec![seen(i)]).collect();
        let mut grid = VisibilityGrid::new(layout([2, 3, 4]), &lists).expect("a grid");
        for number in 0..24 {
            let at = grid.layout().viewpoint(number);
            for off in [DVec3::ZERO, DVec3::splat(0.9), DVec3::new(-0.9, 0.9, -0.9)] {
                assert_eq!(grid.viewpoint_near(at + off), Some(number));
                assert_eq!(grid.seen_from(number), [seen(number as u32)]);
            }
        }
        // Nothing is seen from the first viewpoint any more; the second takes over what is near enough to it.
        grid.starts[1..].iter_mut().for_each(|start| *start -= 1);
        grid.clusters.remove(0);
        let first = grid.layout().viewpoint(0);
        assert_eq!(grid.viewpoint_near(first), None);
        assert_eq!(grid.viewpoint_near(first + DVec3::X * 0.5), Some(1));
    }

    #[test]
    fn an_eye_too_far_away_snaps_to_none() {
        let lists = vec![vec![seen(0)]; 24];
        let grid = VisibilityGrid::new(layout([2, 3, 4]), &lists).expect("a grid");
        let first = grid.layout().viewpoint(0);
        assert_eq!(grid.viewpoint_near(first - DVec3::X * 1.7), Some(0));
        for off in [1.8, 100.0, 1e30] {
            assert_eq!(grid.viewpoint_near(first - DVec3::X * off), None);
            let last = grid.layout().viewpoint(23);
            assert_eq!(grid.viewpoint_near(last + DVec3::Z * off), None);
        }
        assert_eq!(grid.seen_from(24), []);
        assert_eq!(grid.seen_from(usize::MAX), []);
    }

    #[test]
    fn every_point_of_a_box_has_a_viewpoint_near() {
        let bounds = Aabb {
            min: DVec3::new(-3.0, 0.0, 5.0),
            max: DVec3::new(4.1, 0.0, 25.0),
        };
        for spacing in [0.7, 1.0, 3.0, 30.0] {
            let layout = GridLayout::with_spacing(&bounds, spacing).expect("a layout");
            for i in 0..1000 {
                let part = DVec3::new(
                    f64::from(i % 10) / 9.0,
                    f64::from(i / 10 % 10) / 9.0,
                    f64::from(i / 100) / 9.0,
                );
                let eye = bounds.min + bounds.size() * part;
                assert!(layout.nearest(eye, |_| true).is_some(), "{spacing}, {eye}");
            }
        }
    }

    #[test]
    fn a_number_of_viewpoints_is_not_exceeded_and_nearly_reached() {
        let bounds = Aabb {
            min: DVec3::ZERO,
            max: DVec3::new(40.0, 12.0, 70.0),
        };
        for wanted in [1, 2, 100, 5_000] {
            let layout = GridLayout::with_viewpoints(&bounds, wanted).expect("a layout");
            let count = layout.viewpoints();
            assert!(
                count <= wanted && count * 2 >= wanted,
                "{count} of {wanted}"
            );
        }
        let point = Aabb {
            min: DVec3::ONE,
            max: DVec3::ONE,
        };
        let layout = GridLayout::with_viewpoints(&point, 10).expect("a layout");
        assert_eq!(layout.viewpoints(), 1);
    }

    #[test]
    fn impossible_layouts_are_refused() {
        let bounds = Aabb {
            min: DVec3::ZERO,
            max: DVec3::splat(1e6),
        };
        for spacing in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300, 0.1] {
            assert!(
                GridLayout::with_spacing(&bounds, spacing).is_err(),
                "{spacing}"
            );
        }
        assert!(GridLayout::with_viewpoints(&bounds, 0).is_err());
        let empty = Aabb {
            min: DVec3::splat(f64::INFINITY),
            max: DVec3::splat(f64::NEG_INFINITY),
        };
        assert!(GridLayout::with_spacing(&empty, 1.0).is_err());
        assert!(GridLayout::with_viewpoints(&empty, 10).is_err());
    }
}
