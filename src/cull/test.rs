//! The objects that all occluders together do not hide.

use super::effort::CLOSE_LOOK;
use super::seen::Seen;
use super::{Frame, grow, share_of};
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::tasks::Work;

/// A task asks so many objects.
const OBJECTS_PER_TASK: usize = 16;

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct TestMemory {
    undecided: Vec<u32>,
    tests: Vec<Test>,
}

/// What a task asks, and its answers.
#[derive(Debug, Default)]
struct Test {
    footprints: Vec<Footprint>,
    kept: Vec<u32>,
}

impl TestMemory {
    /// How many objects were asked.
    pub fn tested(&self) -> usize {
        self.undecided.len()
    }
}

/// Keeps those of some objects that the buffer does not hide, and those that are never culled, in their order.
pub fn not_hidden<'a>(
    frame: &Frame<'_>,
    undecided: impl Iterator<Item = &'a u32>,
    buffer: &OcclusionBuffer,
    memory: &mut TestMemory,
    visible: &mut Vec<u32>,
) {
    let objects = &mut memory.undecided;
    objects.clear();
    objects.extend(undecided);
    let share = match frame.tasks.threads() {
        1 => objects.len().max(1),
        _ => OBJECTS_PER_TASK,
    };
    let count = objects.len().div_ceil(share);
    grow(&mut memory.tests, count);
    let tests = &mut memory.tests[..count];
    frame.tasks.each(Work::Test, tests, |task, test| {
        test.ask(frame, share_of(objects, share, task), buffer);
    });
    visible.clear();
    for test in tests {
        visible.extend_from_slice(&test.kept);
    }
}

impl Test {
    fn ask(&mut self, frame: &Frame<'_>, objects: &[u32], buffer: &OcclusionBuffer) {
        let scene = frame.scene;
        self.footprints.clear();
        buffer.screen().footprints_of_aabbs(
            frame.settings.level,
            objects.iter().map(|&o| &scene.bounds()[o as usize]),
            &mut self.footprints,
        );
        let asked = objects.iter().zip(&self.footprints);
        let kept = asked.filter(|&(&object, &footprint)| {
            scene.objects()[object as usize].never_cull
                || !buffer.test(footprint).is_hidden()
                    && !is_hidden(frame, buffer, object as usize, footprint)
        });
        self.kept.clear();
        self.kept.extend(kept.map(|(&object, _)| object));
    }
}

/// An object is looked at in so many samples.
const LOOKS: u32 = 8;
/// Stands for an object that is visible without a look.
pub const NOT_LOOKED_AT: u32 = LOOKS + 1;
/// It shows at many of them if it shows at so many.
pub const MANY: u32 = 4;

/// An object that is not hidden.
#[derive(Clone, Copy, Debug)]
pub struct Kept {
    /// Which.
    pub object: u32,
    /// Where it may be drawn.
    pub footprint: Footprint,
    /// At how many of the samples where it is looked at it shows; as many as there are if it is taken for visible, or
    /// [`NOT_LOOKED_AT`].
    pub seen: u32,
}

/// Keeps those of some objects that the buffer does not hide, in their order; their footprints alone do not hide them.
pub fn look_closely(
    frame: &Frame<'_>,
    known: &Seen,
    objects: &[(u32, Footprint)],
    buffer: &OcclusionBuffer,
    memory: &mut LookMemory,
    kept: &mut Vec<Kept>,
) {
    let share = match frame.tasks.threads() {
        1 => objects.len().max(1),
        _ => OBJECTS_PER_TASK,
    };
    let count = objects.len().div_ceil(share);
    grow(memory, count);
    let looks = &mut memory[..count];
    frame.tasks.each(Work::Test, looks, |task, kept| {
        kept.clear();
        let objects = share_of(objects, share, task).iter();
        kept.extend(objects.filter_map(|&(object, footprint)| {
            let seen = if known.is_trusted(object) {
                LOOKS
            } else {
                seen_of(frame, buffer, object as usize, footprint)?
            };
            Some(Kept {
                object,
                footprint,
                seen,
            })
        }));
    });
    kept.clear();
    for of_task in looks {
        kept.extend_from_slice(of_task);
    }
}

/// Memory that is kept from frame to frame, task by task.
pub type LookMemory = Vec<Vec<Kept>>;

/// At how many samples an object shows; none if it is hidden.
fn seen_of(
    frame: &Frame<'_>,
    buffer: &OcclusionBuffer,
    object: usize,
    footprint: Footprint,
) -> Option<u32> {
    let Footprint::Within(rect) = footprint else {
        return Some(LOOKS);
    };
    if buffer.is_hardly_covered(&rect) || frame.is_cheaper(object as u32, CLOSE_LOOK) {
        return Some(NOT_LOOKED_AT);
    }
    let bounds = &frame.scene.bounds()[object];
    let seen = buffer.looks_at(bounds, rect).seen.count_ones();
    if seen == 0 && buffer.hides_aabb_closely(bounds, footprint) {
        return None;
    }
    // Where a little may be lost, what shows at many samples is not worth a closer look.
    let is_plain = seen >= MANY && !frame.settings.accuracy.is_exact();
    (is_plain || !is_hidden_by_own_box(frame, buffer, object, footprint)).then_some(seen)
}

/// Whether an object is hidden that its world box's footprint alone does not hide: by that box, or by its own.
pub fn is_hidden(
    frame: &Frame<'_>,
    buffer: &OcclusionBuffer,
    object: usize,
    footprint: Footprint,
) -> bool {
    buffer.hides_aabb_closely(&frame.scene.bounds()[object], footprint)
        || is_hidden_by_own_box(frame, buffer, object, footprint)
}

fn is_hidden_by_own_box(
    frame: &Frame<'_>,
    buffer: &OcclusionBuffer,
    object: usize,
    footprint: Footprint,
) -> bool {
    let own = frame.scene.own_box(object);
    own.is_some_and(|own| buffer.hides_own_box(&own.shape, own.growth, footprint))
}
