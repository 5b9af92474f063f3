//! Draws occluders into the buffer: batch after batch, each asked first (`ask`), cluster by cluster (`rounds`).

use super::ask::{Answer, AskMemory, ToDraw, ask, ask_clusters};
use super::rounds::{Assembly, draw_clusters};
use super::traverse::{TraverseMemory, hide_subtrees};
use super::{Frame, Statistics};
use crate::occlusion::OcclusionBuffer;

/// Objects that are asked, and then drawn, together. An answer sees only what whole batches before its own have
/// drawn, so that any number of threads gives the same one.
const OBJECTS_PER_BATCH: usize = 16;

/// After so many batches, and four times as many, and so on, whole groups of objects are looked at: what is near has been
/// drawn, and most of the others need not be asked one by one.
const BATCHES_BEFORE_LOOK: usize = 8;

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

/// Draws candidates in their order, as far as the budget goes, each asked first.
pub fn draw_occluders(
    frame: &Frame<'_>,
    candidates: &[u32],
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: Drawn<'_>,
) {
    let mut next_look = BATCHES_BEFORE_LOOK;
    for (index, batch) in candidates.chunks(OBJECTS_PER_BATCH).enumerate() {
        if index == next_look {
            next_look *= 4;
            hide_subtrees(
                frame,
                buffer,
                &mut memory.traverse,
                drawn.hidden,
                drawn.statistics,
            );
        }
        memory.batch.clear();
        let unknown = batch.iter().filter(|&&o| !drawn.hidden[o as usize]);
        memory.batch.extend(unknown);
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
                    if frame
                        .settings
                        .budget
                        .allows(drawn.statistics.occluder_triangles + cost)
                    {
                        drawn.statistics.occluder_triangles += cost;
                        drawn.occluders.push(object);
                    } else {
                        spent = true;
                        break;
                    }
                }
            }
        }
        let objects = &drawn.occluders[first..];
        drawn.statistics.occluders_drawn += objects.len() as u64;
        ask_clusters(frame, objects, buffer, &mut memory.ask, &mut memory.to_draw);
        draw_clusters(frame, &memory.to_draw, buffer, &mut memory.assemblies);
        if spent {
            break;
        }
    }
}
