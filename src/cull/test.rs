//! The objects that all occluders together do not hide.

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

/// Whether an object is hidden that its world box's footprint alone does not hide: by that box, or by its own.
pub fn is_hidden(
    frame: &Frame<'_>,
    buffer: &OcclusionBuffer,
    object: usize,
    footprint: Footprint,
) -> bool {
    let scene = frame.scene;
    buffer.hides_aabb_closely(&scene.bounds()[object], footprint)
        || scene
            .own_box(object)
            .is_some_and(|own| buffer.hides_own_box(&own.shape, own.growth, footprint))
}
