//! Draws occluders into the buffer: batch after batch, each asked first (`ask`), cluster by cluster (`rounds`).

use super::ask::{Answer, AskMemory, ToDraw, ask, ask_clusters};
use super::rounds::{Assembly, draw_clusters};
use super::traverse::{TraverseMemory, hide_subtrees};
use super::{Frame, Statistics};
use crate::occluders::{object_of, sort_nearest};
use crate::occlusion::OcclusionBuffer;
use crate::tasks::Work;

/// Objects that are asked, and then drawn, together. An answer sees only what whole batches before its own have
/// drawn, so that any number of threads gives the same one.
const OBJECTS_PER_BATCH: usize = 16;

/// After so many batches whole groups of objects are looked at: what is near has been drawn, and most of the others need
/// not be asked one by one.
const BATCHES_BEFORE_LOOK: usize = 8;

/// As many batches as before the last look, times this, are drawn before the next one.
const MORE_BEFORE_NEXT_LOOK: usize = 3;

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct DrawMemory {
    batch: Vec<u32>,
    to_draw: Vec<ToDraw>,
    ask: AskMemory,
    traverse: TraverseMemory,
    assemblies: Vec<Assembly>,
}

/// What drawing found and did.
pub struct Drawn<'a> {
    /// For each object, whether it was found hidden. What a part of the occluders hides stays hidden behind all of them.
    pub hidden: &'a mut [bool],
    /// The objects that were drawn, in order.
    pub occluders: &'a mut Vec<u32>,
    /// Counts.
    pub statistics: &'a mut Statistics,
}

/// Draws occluders, nearest first, as far as the budget goes, each asked first. `candidates` are their keys
/// ([`distance_keys`](crate::occluders::distance_keys)), in any order.
pub fn draw_occluders(
    frame: &Frame<'_>,
    candidates: &mut Vec<u64>,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    mut drawn: Drawn<'_>,
) {
    let mut batches = BATCHES_BEFORE_LOOK;
    loop {
        let before_look = candidates.len().min(batches * OBJECTS_PER_BATCH);
        frame.tasks.alone(Work::Select, || {
            sort_nearest(candidates, before_look);
        });
        for batch in candidates[..before_look].chunks(OBJECTS_PER_BATCH) {
            memory.batch.clear();
            memory.batch.extend(batch.iter().map(|&key| object_of(key)));
            if !draw_batch(frame, buffer, memory, &mut drawn) {
                return;
            }
        }
        candidates.drain(..before_look);
        if candidates.is_empty() {
            return;
        }
        hide_subtrees(
            frame,
            buffer,
            &mut memory.traverse,
            drawn.hidden,
            drawn.statistics,
        );
        candidates.retain(|&key| !drawn.hidden[object_of(key) as usize]);
        batches *= MORE_BEFORE_NEXT_LOOK;
    }
}

/// Asks the objects of a batch, and draws those that are not hidden. Whether the budget allows for more.
fn draw_batch(
    frame: &Frame<'_>,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: &mut Drawn<'_>,
) -> bool {
    let batch = &memory.batch;
    let answers = ask(frame, batch, buffer, &mut memory.ask);
    drawn.statistics.occluders_asked += batch.len() as u64;
    let first = drawn.occluders.len();
    let mut spent = false;
    for (&object, answer) in batch.iter().zip(answers) {
        let cost = u64::from(frame.occluders.triangles_of(object));
        match answer {
            Answer::Hidden => drawn.hidden[object as usize] = true,
            // Its own mesh may be far beyond any budget: that is what it has a proxy for.
            Answer::CutOpen => {}
            Answer::Visible => {
                let triangles = drawn.statistics.occluder_triangles + cost;
                if !frame.settings.budget.allows(triangles) {
                    spent = true;
                    break;
                }
                drawn.statistics.occluder_triangles = triangles;
                drawn.occluders.push(object);
            }
        }
    }
    let objects = &drawn.occluders[first..];
    drawn.statistics.occluders_drawn += objects.len() as u64;
    ask_clusters(frame, objects, buffer, &mut memory.ask, &mut memory.to_draw);
    draw_clusters(frame, &memory.to_draw, buffer, &mut memory.assemblies);
    !spent
}
