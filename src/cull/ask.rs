//! Which occluders of a batch are hidden behind what is drawn so far.

use super::{Frame, grow, share_of};
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::tasks::Work;

/// An occluder with so many triangles is asked a second time, by its outline and faces, before it is drawn.
const WORTH_ASKING_CLOSELY: u32 = 24;

/// A task asks at least so many objects: one question takes about a microsecond.
const FEWEST_OBJECTS: usize = 2;

/// What is known of an object before it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// It is hidden.
    Hidden,
    /// It may be seen, within this.
    Visible(Footprint),
    /// The object reaches the near plane: its surface does not hide its proxy.
    CutOpen,
}

/// Memory that is kept from batch to batch.
#[derive(Debug, Default)]
pub struct AskMemory {
    questions: Vec<Questions>,
    answers: Vec<Answer>,
}

/// What a task asks, and its answers.
#[derive(Debug, Default)]
struct Questions {
    footprints: Vec<Footprint>,
    answers: Vec<Answer>,
}

/// Whether objects are hidden behind what is drawn so far.
pub fn ask<'m>(
    frame: &Frame<'_>,
    batch: &[u32],
    buffer: &OcclusionBuffer,
    memory: &'m mut AskMemory,
) -> &'m [Answer] {
    let share = match frame.tasks.threads() {
        1 => batch.len().max(1),
        threads => (batch.len() / (4 * threads)).max(FEWEST_OBJECTS),
    };
    let count = batch.len().div_ceil(share);
    grow(&mut memory.questions, count);
    let questions = &mut memory.questions[..count];
    frame.tasks.each(Work::Ask, questions, |task, questions| {
        questions.ask(frame, share_of(batch, share, task), buffer);
    });
    memory.answers.clear();
    for questions in questions {
        memory.answers.extend_from_slice(&questions.answers);
    }
    &memory.answers
}

impl Questions {
    fn ask(&mut self, frame: &Frame<'_>, objects: &[u32], buffer: &OcclusionBuffer) {
        let &Frame {
            scene, occluders, ..
        } = frame;
        let asks = frame.asks_before_drawing();
        self.footprints.clear();
        let bounds = objects.iter().map(|&o| &scene.bounds()[o as usize]);
        buffer
            .screen()
            .footprints_of_aabbs(frame.settings.level, bounds, &mut self.footprints);
        self.answers.clear();
        self.answers.extend(
            objects
                .iter()
                .zip(&self.footprints)
                .map(|(&object, &footprint)| {
                    let has_proxy = scene.objects()[object as usize].occluder_proxy.is_some();
                    if has_proxy && footprint == Footprint::Unbounded {
                        Answer::CutOpen
                    } else if !asks && footprint != Footprint::Nowhere {
                        Answer::Visible(footprint)
                    } else if buffer.hides(footprint)
                        || occluders.triangles_of(object) >= WORTH_ASKING_CLOSELY
                            && buffer
                                .hides_aabb_closely(&scene.bounds()[object as usize], footprint)
                    {
                        Answer::Hidden
                    } else {
                        Answer::Visible(footprint)
                    }
                }),
        );
    }
}
