//! What of the last frame's answer still holds: all of it if nothing has changed, and most of it if a few objects have moved while the
//! camera stood still.
//!
//! **Why a part is right.** Let the camera and all objects but some be where they were. Surfaces that moved lie within the rectangles
//! of their objects, before and after; let the region hold all of these. Outside of it, every sample shows what it showed. So an
//! object that is hidden there is so still, by the same surfaces, and one whose rectangle does not meet the region has the answer
//! that it had. The tiles that the region touches are drawn anew, from what is remembered, and every object whose rectangle meets it is
//! asked again, with all of its rectangle.

use super::Frame;
use super::draw::{Drawn, draw_recalled, draw_what_closes_gaps, recall_remembered};
use super::effort::GAP;
use super::frame::Memory;
use super::skips::Skip;
use super::statistics::Clock;
use super::test::{NOT_LOOKED_AT, look_closely};
use super::traverse::not_hidden_so_far;
use super::{Remembered, Statistics, VisibleSet};
use crate::occlusion::{Footprint, OcclusionBuffer, Screen};
use crate::scene::Aabb;
use crate::tasks::Work;
use crate::view::{Containment, Frustum, Planes};

/// A region that is larger than one in so many parts of the picture is not worth it: a frame anew takes little more.
const LARGEST_SHARE: i64 = 4;

/// A rectangle of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    x: [i32; 2],
    y: [i32; 2],
}

impl Region {
    /// One without a sample.
    pub const EMPTY: Region = Region {
        x: [i32::MAX, i32::MIN],
        y: [i32::MAX, i32::MIN],
    };

    /// What holds all that boxes touch in a frustum; none if one reaches its near plane, or it is too large to be worth it.
    pub fn around<'a>(
        screen: &Screen,
        frustum: &Frustum,
        boxes: impl Iterator<Item = &'a Aabb>,
    ) -> Option<Region> {
        let mut region = Region::EMPTY;
        let is_inside =
            |bounds: &&Aabb| frustum.contains(bounds, Planes::ALL) != Containment::Outside;
        for bounds in boxes.filter(is_inside) {
            match screen.footprint_of_aabb(bounds) {
                Footprint::Unbounded => return None,
                Footprint::Nowhere => {}
                Footprint::Within(rect) => {
                    let both = |a: [i32; 2], b: [i32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
                    region.x = both(region.x, rect.x);
                    region.y = both(region.y, rect.y);
                }
            }
        }
        let samples = |[first, last]: [i32; 2]| i64::from(last) - i64::from(first) + 1;
        let all = (screen.size().width() * screen.size().height()) as i64;
        let is_small =
            region.is_empty() || samples(region.x) * samples(region.y) * LARGEST_SHARE <= all;
        is_small.then_some(region)
    }

    fn is_empty(&self) -> bool {
        self.x[0] > self.x[1]
    }

    /// Whether a shape has no sample in it.
    pub fn misses(self, footprint: Footprint) -> bool {
        match footprint {
            Footprint::Unbounded => self.is_empty(),
            Footprint::Nowhere => true,
            Footprint::Within(rect) => {
                let apart = |a: [i32; 2], b: [i32; 2]| a[1] < b[0] || b[1] < a[0];
                apart(self.x, rect.x) || apart(self.y, rect.y)
            }
        }
    }
}

impl Frame<'_> {
    /// Gives an answer again.
    pub(super) fn repeat(&self, visible: &[u32], ignored_pixels: u64, found: &mut VisibleSet) {
        let clock = Clock::start();
        found.visible.clear();
        found.visible.extend_from_slice(visible);
        found.occluders.clear();
        found.statistics = Statistics {
            ignored_pixels,
            ..Statistics::default()
        };
        found.statistics.skipped.add(Skip::Everything);
        clock.end(found);
    }

    /// Whether the same camera and scene give the same answer: not if there is a time to keep to, or occluders are what was visible
    /// before.
    pub(super) fn can_be_repeated(&self) -> bool {
        self.settings.effort.reuse && self.ends.is_none() && !self.remembers_visible()
    }

    /// Whether a part of its answer can be found anew: whether it closes gaps by what it remembers, and no hole is ignored.
    pub(super) fn can_be_in_part(&self) -> bool {
        self.is_by_contribution() && self.settings.accuracy.approximation().is_none()
    }

    /// Finds out again what may be seen in a region; the rest of the answer is the last frame's, with the same camera, in which these
    /// objects were visible. `moved` have moved since.
    pub(super) fn run_in_part(
        &self,
        region: Region,
        (last, moved): (&[u32], &[u32]),
        buffer: &mut OcclusionBuffer,
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        let mut clock = Clock::start();
        found.occluders.clear();
        found.statistics = Statistics::default();
        found.statistics.skipped.add(Skip::Elsewhere);
        found.statistics.skipped.add(Skip::Pyramid);
        memory.hidden.clear(self.scene.objects().len());
        memory.kept.clear();
        clock.lap(|times| &mut times.select);
        if !region.is_empty() {
            self.find_again(region, buffer, remembered, memory, found, &mut clock);
        }
        self.keep_others(region, (last, moved), buffer, memory, &mut found.visible);
        clock.end(found);
    }

    /// Draws what is remembered into the region, asks what meets it, and closes gaps.
    fn find_again(
        &self,
        region: Region,
        buffer: &mut OcclusionBuffer,
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
        clock: &mut Clock,
    ) {
        let frame = &Frame {
            region: Some(region),
            ..*self
        };
        let Remembered {
            contributions,
            seen,
            ..
        } = remembered;
        let tasks = frame.tasks;
        tasks.alone(Work::Clear, || buffer.begin_part(region.x, region.y));
        seen.begin_part();
        recall_remembered(frame, contributions, buffer.screen(), &mut memory.draw);
        clock.lap(|times| &mut times.select);
        let mut drawn = Drawn {
            hidden: &mut memory.hidden,
            occluders: &mut found.occluders,
            contributions,
            statistics: &mut found.statistics,
        };
        draw_recalled(frame, buffer, &mut memory.draw, &mut drawn);
        drawn.statistics.clusters_remembered = drawn.occluders.len() as u64;
        clock.lap(|times| &mut times.raster);

        let (undecided, kept) = (&mut memory.undecided, &mut memory.kept);
        let traverse = &mut memory.traverse;
        not_hidden_so_far(frame, seen, buffer, traverse, undecided, drawn.statistics);
        undecided.sort_unstable_by_key(|(object, _)| *object);
        look_closely(frame, seen, undecided, buffer, &mut memory.look, kept);
        drawn.statistics.objects_tested = seen.count_in_question(undecided);
        clock.lap(|times| &mut times.test);

        let questions = kept.iter().filter_map(|kept| match kept.footprint {
            Footprint::Within(rect) => {
                let is_in_question = kept.seen != NOT_LOOKED_AT && !seen.is_trusted(kept.object);
                let is_cheap = frame.is_cheaper(kept.object, GAP);
                (is_in_question && !is_cheap).then_some((kept.object, rect))
            }
            _ => None,
        });
        let draw = &mut memory.draw;
        draw_what_closes_gaps(frame, buffer, undecided, questions, draw, &mut drawn);
        kept.retain(|kept| !drawn.hidden.has(kept.object));
        buffer.end_part();
        tasks.alone(Work::Finish, || buffer.finish());
        clock.lap(|times| &mut times.raster);
        seen.note_part(undecided, kept);
        contributions.end_part();
    }

    /// Puts what is visible in the region and what was and is not touched by it together.
    fn keep_others(
        &self,
        region: Region,
        (last, moved): (&[u32], &[u32]),
        buffer: &OcclusionBuffer,
        memory: &mut Memory,
        visible: &mut Vec<u32>,
    ) {
        let bounds = self.scene.bounds();
        let footprints = &mut memory.footprints;
        footprints.clear();
        let boxes = last.iter().map(|&object| &bounds[object as usize]);
        buffer
            .screen()
            .footprints_of_aabbs(self.settings.level, boxes, footprints);
        let others = last.iter().zip(&*footprints);
        let others = others
            .filter(|&(object, &footprint)| region.misses(footprint) && !moved.contains(object));
        visible.clear();
        visible.extend(others.map(|(&object, _)| object));
        visible.extend(memory.kept.iter().map(|kept| kept.object));
        visible.sort_unstable();
        self.put_back_never_culled(buffer.screen().camera(), visible);
    }
}
