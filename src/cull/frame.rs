//! The frame's two ways from a camera to the visible set: in order, and by contribution.
//!
//! Either has three stages: occluders are selected, drawn, and the rest is asked. What one leaves for the next stands in the frame's
//! memory, its buffer and what it has found, so that another thread may go on with them.

use super::draw::{
    DrawMemory, Drawn, draw_occluders, draw_recalled, draw_remembered, draw_sampled,
    draw_what_closes_gaps, recall_remembered,
};
use super::effort::GAP;
use super::marks::Marks;
use super::sampled::seen_nearby;
use super::skips::Skip;
use super::statistics::Clock;
use super::test::{Kept, LookMemory, NOT_LOOKED_AT, TestMemory, look_closely, not_hidden};
use super::translucent::draw_translucent;
use super::traverse::{
    self, FrustumMemory, MayCover, TraverseMemory, hide_subtrees, not_hidden_among,
    not_hidden_so_far,
};
use super::two_passes::TwoPassMemory;
use super::{Frame, Remembered, Statistics, VisibleSet, grow, share_of};
use crate::occluders::{
    Budget, Contributions, DrawnCluster, LastFrame, Selection, distance_keys, keep_active,
    keep_promising, solid_angle_keys, weight_keys, z_plane_keys,
};
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::tasks::Work;
use crate::view::{Camera, Containment, Planes};

/// Of so many objects, a frame that remembers nothing draws what is promising, before it closes gaps, if no grid tells what is seen
/// from nearby.
const FIRST_OCCLUDERS: usize = 64;

/// If more than one in so many of the objects in its frustum are in question then, it goes on in order instead. So does one that
/// shows something else than the last.
const MOST_UNDECIDED: usize = 8;

/// Each thread has so many tasks of finding keys,
const KEY_TASKS_PER_THREAD: usize = 4;
/// each for at least so many objects.
const FEWEST_KEYS: usize = 128;

/// What is kept from frame to frame, so that none allocates.
#[derive(Debug, Default)]
pub struct Memory {
    selected: Selected,
    pub(super) draw: DrawMemory,
    frustum: FrustumMemory,
    pub(super) traverse: TraverseMemory,
    pub(super) in_frustum: Vec<u32>,
    /// Those of them that the last frame names as candidates.
    of_last: Vec<u32>,
    /// The keys of the occluders in the frustum, as tasks found them.
    candidates: Vec<Vec<u64>>,
    /// The objects that their boxes' rectangles do not hide,
    pub(super) undecided: Vec<(u32, Footprint)>,
    /// and those of them that closer questions do not hide either.
    pub(super) kept: Vec<Kept>,
    pub(super) look: LookMemory,
    test: TestMemory,
    pub(super) two_passes: TwoPassMemory,
    pub(super) hidden: Marks,
    pub(super) footprints: Vec<Footprint>,
}

/// What a frame is to draw first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Selected {
    /// Objects: the candidates.
    #[default]
    Candidates,
    /// The clusters that are seen from a viewpoint nearby.
    Sampled,
    /// The clusters that the last frame needed.
    Remembered,
    /// The same, but they are largely out of the picture: it shows something else than the last.
    RememberedInPart,
    /// Nothing: what is in the frustum is the answer.
    Nothing,
}

impl Frame<'_> {
    /// Finds what a camera may see.
    pub(super) fn run(
        &self,
        camera: &Camera,
        buffer: &mut OcclusionBuffer,
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        self.select(camera, buffer, remembered, memory, found);
        self.draw(buffer, remembered, memory, found);
        self.ask(buffer, remembered, memory, found);
    }

    /// Begins a frame, and selects what it draws first.
    pub(super) fn select(
        &self,
        camera: &Camera,
        buffer: &mut OcclusionBuffer,
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        let mut clock = Clock::start();
        self.begin(camera, buffer, memory, found);
        memory.selected = if self.is_by_contribution() {
            self.select_by_contribution(camera, buffer, remembered, memory, found)
        } else {
            self.select_in_order(camera, &remembered.last, memory)
        };
        clock.lap(|times| &mut times.select);
        found.times = clock.times;
    }

    /// Draws what is selected.
    pub(super) fn draw(
        &self,
        buffer: &mut OcclusionBuffer,
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        let mut clock = Clock::go_on(found);
        let mut drawn = Drawn {
            hidden: &mut memory.hidden,
            occluders: &mut found.occluders,
            contributions: &mut remembered.contributions,
            statistics: &mut found.statistics,
        };
        match memory.selected {
            Selected::Candidates => {
                let candidates = &mut memory.candidates[0];
                draw_occluders(self, candidates, buffer, &mut memory.draw, &mut drawn);
            }
            Selected::Sampled => {
                let seen = seen_nearby(self, buffer.screen().camera()).unwrap_or_default();
                draw_sampled(self, seen, buffer, &mut memory.draw, &mut drawn);
                if !self.is_by_contribution() && self.asks_before_drawing() {
                    let Drawn {
                        hidden, statistics, ..
                    } = &mut drawn;
                    hide_subtrees(self, buffer, &mut memory.traverse, hidden, statistics);
                }
            }
            Selected::Nothing => {}
            Selected::Remembered | Selected::RememberedInPart => {
                draw_recalled(self, buffer, &mut memory.draw, &mut drawn);
                drawn.statistics.clusters_remembered = drawn.occluders.len() as u64;
            }
        }
        clock.lap(|times| &mut times.raster);
        found.times = clock.times;
    }

    /// Finds what may be seen past what is drawn; by contribution, draws what closes gaps.
    pub(super) fn ask(
        &self,
        buffer: &mut OcclusionBuffer,
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        let mut clock = Clock::go_on(found);
        if memory.selected == Selected::Nothing {
            self.tasks.alone(Work::Finish, || buffer.finish());
            std::mem::swap(&mut found.visible, &mut memory.in_frustum);
            return clock.end(found);
        }
        if self.settings.translucent && !self.settings.accuracy.is_exact() {
            self.tasks
                .alone(Work::Fill, || draw_translucent(self, buffer));
            clock.lap(|times| &mut times.raster);
        }
        if self.is_by_contribution() {
            self.by_contribution(buffer, remembered, memory, found, &mut clock);
        } else {
            self.ask_all(buffer, memory, found, &mut clock);
            if self.remembers_visible() {
                let last = &mut remembered.last;
                last.remember(&memory.in_frustum, &found.visible);
            }
        }
        clock.end(found);
    }

    /// Lists what is in the frustum.
    pub(super) fn find_in_frustum(&self, camera: &Camera, memory: &mut Memory) -> MayCover {
        let frustum = self.frustum(camera);
        let in_frustum = &mut memory.in_frustum;
        traverse::in_frustum(self, &frustum, &mut memory.frustum, in_frustum)
    }

    /// Where everything is drawn there is nothing to choose.
    pub(super) fn is_by_contribution(&self) -> bool {
        self.settings.occluders == Selection::Contribution
            && self.settings.budget != Budget::All
            && self.asks_before_drawing()
    }

    pub(super) fn remembers_visible(&self) -> bool {
        let selection = self.settings.occluders;
        matches!(selection, Selection::PreviousVisible | Selection::Coherent)
    }

    /// Draws given clusters, and asks the objects in the frustum.
    pub(super) fn run_behind(
        &self,
        camera: &Camera,
        buffer: &mut OcclusionBuffer,
        given: &mut Contributions,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        let mut clock = Clock::start();
        self.begin(camera, buffer, memory, found);
        let frustum = self.frustum(camera);
        let in_frustum = &mut memory.in_frustum;
        traverse::in_frustum(self, &frustum, &mut memory.frustum, in_frustum);
        clock.lap(|times| &mut times.select);
        let mut drawn = Drawn {
            hidden: &mut memory.hidden,
            occluders: &mut found.occluders,
            contributions: given,
            statistics: &mut found.statistics,
        };
        draw_remembered(self, buffer, &mut memory.draw, &mut drawn);
        clock.lap(|times| &mut times.raster);
        self.ask_all(buffer, memory, found, &mut clock);
        clock.end(found);
    }

    /// Empties what a frame fills.
    fn begin(
        &self,
        camera: &Camera,
        buffer: &mut OcclusionBuffer,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) {
        found.occluders.clear();
        found.statistics = Statistics::default();
        if self.settings.accuracy.approximation().is_none() {
            found.statistics.skipped.add(Skip::Pyramid);
        }
        memory.hidden.clear(self.scene.objects().len());
        buffer.set_accuracy(self.settings.accuracy);
        buffer.set_level(self.settings.level);
        buffer.clear_by(self.tasks, camera);
    }

    /// Selects what is in the frustum, in the order of the selection.
    fn select_in_order(&self, camera: &Camera, last: &LastFrame, memory: &mut Memory) -> Selected {
        let frustum = self.frustum(camera);
        let in_frustum = &mut memory.in_frustum;
        traverse::in_frustum(self, &frustum, &mut memory.frustum, in_frustum);
        let selection = self.settings.occluders;
        if selection == Selection::Sampled && seen_nearby(self, camera).is_some() {
            return Selected::Sampled;
        }
        if self.remembers_visible() {
            let of_last = &mut memory.of_last;
            of_last.clear();
            let objects = in_frustum.iter().copied();
            let back = self.settings.frames_back;
            of_last.extend(objects.filter(|&object| last.is_candidate(selection, back, object)));
            self.candidates(camera, of_last, &mut memory.candidates);
        } else {
            self.candidates(camera, in_frustum, &mut memory.candidates);
        }
        Selected::Candidates
    }

    /// Asks the objects in the frustum that drawing did not find hidden.
    fn ask_all(
        &self,
        buffer: &mut OcclusionBuffer,
        memory: &mut Memory,
        found: &mut VisibleSet,
        clock: &mut Clock,
    ) {
        self.tasks.alone(Work::Finish, || buffer.finish());
        found.statistics.ignored_pixels = buffer.ignored_pixels();
        if !self.asks_before_drawing() {
            let (in_frustum, two_passes) = (&memory.in_frustum, &mut memory.two_passes);
            self.finish_depth(buffer, &found.occluders, two_passes);
            clock.lap(|times| &mut times.pyramid);
            self.ask_behind(buffer, in_frustum, &mut memory.hidden, two_passes, found);
            self.put_back_salient(buffer, &mut found.visible);
            return;
        }
        clock.lap(|times| &mut times.pyramid);
        let undecided = |&&object: &&u32| {
            !memory.hidden.has(object) || self.scene.objects()[object as usize].never_cull
        };
        let undecided = memory.in_frustum.iter().filter(undecided);
        not_hidden(
            self,
            undecided,
            buffer,
            &mut memory.test,
            &mut found.visible,
        );
        found.statistics.objects_tested = memory.test.tested() as u64;
        self.put_back_salient(buffer, &mut found.visible);
    }

    /// Selects the clusters that the last frame needed; if it needed none, what is seen from nearby or promising.
    fn select_by_contribution(
        &self,
        camera: &Camera,
        buffer: &OcclusionBuffer,
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
    ) -> Selected {
        let Remembered {
            contributions,
            seen,
            worth,
            ..
        } = remembered;
        let has_grid = seen_nearby(self, camera).is_some();
        let is_known = !contributions.is_empty() || has_grid;
        if !is_known || worth.pauses() {
            let may_cover = self.find_in_frustum(camera, memory);
            let objects = memory.in_frustum.len();
            if let Some(skip) = self.skips_occlusion(worth, camera, objects, may_cover, is_known) {
                found.statistics.skipped.add(skip);
                return Selected::Nothing;
            }
        }
        seen.begin_frame(self.scene);
        if !contributions.is_empty() {
            let is_new = recall_remembered(self, contributions, buffer.screen(), &mut memory.draw);
            if !is_new {
                return Selected::Remembered;
            }
            seen.distrust();
            let frustum = self.frustum(camera);
            let in_frustum = &mut memory.in_frustum;
            traverse::in_frustum(self, &frustum, &mut memory.frustum, in_frustum);
            return Selected::RememberedInPart;
        }
        if has_grid {
            return Selected::Sampled;
        }
        let candidates = self.candidates(camera, &memory.in_frustum, &mut memory.candidates);
        let triangles_of = |object| self.occluders.triangles_of(object);
        let eye = camera.eye();
        keep_promising(self.scene, eye, candidates, FIRST_OCCLUDERS, triangles_of);
        Selected::Candidates
    }

    /// After the clusters that the last frame needed, draws what keeps objects from being seen that were not before.
    fn by_contribution(
        &self,
        buffer: &mut OcclusionBuffer,
        remembered: &mut Remembered,
        memory: &mut Memory,
        found: &mut VisibleSet,
        clock: &mut Clock,
    ) {
        let Remembered {
            contributions,
            seen,
            worth,
            ..
        } = remembered;
        let VisibleSet {
            visible,
            occluders,
            statistics,
            ..
        } = found;
        let camera = &buffer.screen().camera().to_owned();
        let selected = memory.selected;
        let mut drawn = Drawn {
            hidden: &mut memory.hidden,
            occluders,
            contributions,
            statistics,
        };
        self.tasks.alone(Work::Look, || buffer.find_blocks());
        let (undecided, kept) = (&mut memory.undecided, &mut memory.kept);
        let traverse = &mut memory.traverse;
        not_hidden_so_far(self, seen, buffer, traverse, undecided, drawn.statistics);
        let questions = seen.count_in_question(undecided) as usize;
        let is_new = matches!(selected, Selected::Candidates | Selected::RememberedInPart);
        let is_open = is_new
            && self.settings.budget.is_for_what_pays()
            && self.has_pass_left(0)
            && questions * MOST_UNDECIDED > memory.in_frustum.len();
        let remembered = drawn.statistics.clusters_remembered as usize;
        if is_open {
            // So many gaps are not worth closing one by one.
            clock.lap(|times| &mut times.test);
            let objects = &mut memory.in_frustum;
            objects.clear();
            objects.extend(undecided.iter().map(|(object, _)| *object));
            let candidates = self.candidates(camera, objects, &mut memory.candidates);
            draw_occluders(self, candidates, buffer, &mut memory.draw, &mut drawn);
            clock.lap(|times| &mut times.raster);
            objects.retain(|&object| !drawn.hidden.has(object));
            not_hidden_among(self, seen, objects, buffer, traverse, undecided);
        }
        if is_open || !matches!(selected, Selected::Remembered | Selected::RememberedInPart) {
            for &DrawnCluster {
                id,
                triangles,
                gain,
            } in &drawn.occluders[remembered..]
            {
                if gain > 0 {
                    drawn.contributions.needed(id, triangles, gain);
                }
            }
        }
        undecided.sort_unstable_by_key(|(object, _)| *object);
        look_closely(self, seen, undecided, buffer, &mut memory.look, kept);
        drawn.statistics.objects_tested = seen.count_in_question(undecided);
        if kept.iter().any(|kept| self.is_cheaper(kept.object, GAP)) {
            let skipped = &mut drawn.statistics.skipped;
            skipped.add(Skip::QuestionsDearerThanDrawing);
        }
        clock.lap(|times| &mut times.test);

        let questions = kept.iter().filter_map(|kept| match kept.footprint {
            Footprint::Within(rect) => {
                let is_in_question = kept.seen != NOT_LOOKED_AT && !seen.is_trusted(kept.object);
                let is_cheap = self.is_cheaper(kept.object, GAP);
                (is_in_question && !is_open && !is_cheap).then_some((kept.object, rect))
            }
            _ => None,
        });
        let draw = &mut memory.draw;
        draw_what_closes_gaps(self, buffer, undecided, questions, draw, &mut drawn);
        kept.retain(|kept| !drawn.hidden.has(kept.object));
        let is_cut_short = self.is_time_over() || !self.has_pass_left(drawn.statistics.passes);
        if let Budget::Triangles(_) = self.settings.budget {
            // What is left of the budget is there to be spent.
            let objects = &mut memory.in_frustum;
            objects.clear();
            objects.extend(kept.iter().map(|kept| kept.object));
            let candidates = self.candidates(camera, objects, &mut memory.candidates);
            draw_occluders(self, candidates, buffer, &mut memory.draw, &mut drawn);
            kept.retain(|kept| !drawn.hidden.has(kept.object));
        }
        clock.lap(|times| &mut times.raster);
        self.tasks.alone(Work::Finish, || buffer.finish());
        drawn.statistics.ignored_pixels = buffer.ignored_pixels();
        clock.lap(|times| &mut times.pyramid);

        let is_decided = self.settings.budget.is_for_what_pays() && !is_cut_short;
        if is_decided {
            visible.clear();
            visible.extend(kept.iter().map(|kept| kept.object));
        } else {
            let objects = kept.iter().map(|kept| &kept.object);
            not_hidden(self, objects, buffer, &mut memory.test, visible);
            kept.retain(|kept| visible.binary_search(&kept.object).is_ok());
        }
        seen.note(self.scene.bvh(), undecided, kept);
        let counts = [kept.len(), undecided.len()];
        self.judge_worth(worth, camera, statistics, occluders.len(), counts);
        if is_cut_short {
            contributions.keep_untried();
        }
        contributions.end_frame();
        self.put_back_never_culled(camera, visible);
        self.put_back_salient(buffer, visible);
    }

    /// Puts objects back that are never culled.
    pub(super) fn put_back_never_culled(&self, camera: &Camera, visible: &mut Vec<u32>) {
        let never_culled = self.occluders.never_culled();
        if never_culled.is_empty() {
            return;
        }
        let frustum = self.frustum(camera);
        let is_in_it = |object: &&u32| {
            let bounds = &self.scene.bounds()[**object as usize];
            frustum.contains(bounds, Planes::ALL) != Containment::Outside
        };
        visible.extend(never_culled.iter().filter(is_in_it));
        visible.sort_unstable();
        visible.dedup();
    }

    /// Puts objects back that stand out and show through holes that are ignored.
    fn put_back_salient(&self, buffer: &OcclusionBuffer, visible: &mut Vec<u32>) {
        if self.salient.is_empty() || buffer.ignored_pixels() == 0 {
            return;
        }
        let frustum = self.frustum(buffer.screen().camera());
        let culled = visible.len();
        for &(object, salience) in self.salient {
            let bounds = &self.scene.bounds()[object as usize];
            let shows = match buffer.screen().footprint_of_aabb(bounds) {
                Footprint::Within(rect) => buffer.ignores_more_than(1.0 - salience, &rect),
                _ => false,
            };
            let is_in_frustum = frustum.contains(bounds, Planes::ALL) != Containment::Outside;
            if shows && is_in_frustum && visible[..culled].binary_search(&object).is_err() {
                visible.push(object);
            }
        }
        visible.sort_unstable();
    }

    /// The keys of the occluders among objects.
    fn candidates<'m>(
        &self,
        camera: &Camera,
        objects: &[u32],
        memory: &'m mut Vec<Vec<u64>>,
    ) -> &'m mut Vec<u64> {
        let share = match self.tasks.threads() {
            1 => objects.len().max(1),
            threads => objects
                .len()
                .div_ceil(KEY_TASKS_PER_THREAD * threads)
                .max(FEWEST_KEYS),
        };
        let count = objects.len().div_ceil(share).max(1);
        grow(memory, count);
        let keys = &mut memory[..count];
        self.tasks.each(Work::Select, keys, |task, keys| {
            let occludes = |object: &u32| self.occluders.is_candidate(*object, self.settings);
            let objects = share_of(objects, share, task).iter().copied();
            let objects = objects.filter(occludes);
            let (scene, eye) = (self.scene, camera.eye());
            match self.settings.occluders {
                Selection::ZPlane => z_plane_keys(scene, camera, objects, keys),
                Selection::SolidAngle => solid_angle_keys(scene, eye, objects, keys),
                Selection::Weight => {
                    let across = |object| self.occluders.across_largest_face(object);
                    weight_keys(scene, camera, across, objects, keys);
                }
                Selection::Nearest
                | Selection::PreviousVisible
                | Selection::Coherent
                | Selection::Sampled
                | Selection::Contribution => distance_keys(scene, eye, objects, keys),
            }
        });
        let (first, others) = memory.split_at_mut(1);
        for others in &others[..count - 1] {
            first[0].extend_from_slice(others);
        }
        if self.settings.occluders == Selection::Weight {
            keep_active(&self.settings.weighing, &mut first[0]);
        }
        &mut first[0]
    }
}
