//! Draws occluders into the buffer: batch after batch, each asked first (`ask`); cluster by cluster, nearest first
//! (`waiting`, `rounds`).

use super::ask::{Answer, AskMemory, ask};
use super::rounds::{EVERYTHING, RoundMemory, draw_waiting};
use super::traverse::{TraverseMemory, hide_subtrees};
use super::waiting::{Waiting, nearness};
use super::{Frame, Statistics};
use crate::occluders::{object_of, sort_nearest};
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::tasks::Work;

/// Objects that are asked, and then drawn, together, before the first look. An answer sees only what whole batches before
/// its own have drawn, so that any number of threads gives the same one.
const OBJECTS_PER_BATCH: usize = 16;
/// After each look batches are twice as large, up to this: what is far away hides less of what comes right after it.
const MOST_PER_BATCH: usize = 64;

/// After so many objects whole groups of them are looked at: what is near has been drawn, and most of the others need not
/// be asked one by one.
const OBJECTS_BEFORE_LOOK: usize = 128;
/// As many as before the last look, times this, are taken before the next one.
const MORE_BEFORE_NEXT_LOOK: usize = 3;

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct DrawMemory {
    batch: Vec<u32>,
    to_draw: Vec<(u32, Footprint)>,
    ask: AskMemory,
    waiting: Waiting,
    rounds: RoundMemory,
    traverse: TraverseMemory,
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
    let mut before_look = OBJECTS_BEFORE_LOOK;
    let mut per_batch = OBJECTS_PER_BATCH;
    memory.waiting.clear();
    loop {
        let taken = candidates.len().min(before_look);
        frame.tasks.alone(Work::Select, || {
            sort_nearest(candidates, taken);
        });
        let mut batches = candidates[..taken].chunks(per_batch);
        let is_within_budget = batches.all(|batch| {
            memory.batch.clear();
            memory.batch.extend(batch.iter().map(|&key| object_of(key)));
            draw_batch(frame, buffer, memory, &mut drawn)
        });
        candidates.drain(..taken);
        if candidates.is_empty() || !is_within_budget {
            return draw_until(EVERYTHING, frame, buffer, memory, drawn.hidden);
        }
        hide_subtrees(
            frame,
            buffer,
            &mut memory.traverse,
            drawn.hidden,
            drawn.statistics,
        );
        candidates.retain(|&key| !drawn.hidden[object_of(key) as usize]);
        before_look *= MORE_BEFORE_NEXT_LOOK;
        per_batch = MOST_PER_BATCH.min(2 * per_batch);
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
    memory.to_draw.clear();
    let mut spent = false;
    for (&object, &answer) in batch.iter().zip(answers) {
        let cost = u64::from(frame.occluders.triangles_of(object));
        match answer {
            Answer::Hidden => drawn.hidden[object as usize] = true,
            // Its own mesh may be far beyond any budget: that is what it has a proxy for.
            Answer::CutOpen => {}
            Answer::Visible(footprint) => {
                let triangles = drawn.statistics.occluder_triangles + cost;
                if !frame.settings.budget.allows(triangles) {
                    spent = true;
                    break;
                }
                drawn.statistics.occluder_triangles = triangles;
                drawn.occluders.push(object);
                memory.to_draw.push((object, footprint));
            }
        }
    }
    drawn.statistics.occluders_drawn += memory.to_draw.len() as u64;
    // What is behind all that begins here may wait for others that begin before it.
    let Some(&(_, farthest)) = memory.to_draw.last() else {
        return !spent;
    };
    let hide = |object: u32| drawn.hidden[object as usize] = true;
    memory.waiting.add(frame, &memory.to_draw, buffer, hide);
    draw_until(nearness(farthest), frame, buffer, memory, drawn.hidden);
    !spent
}

/// Draws what waits as far as a horizon.
fn draw_until(
    horizon: u32,
    frame: &Frame<'_>,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    hidden: &mut [bool],
) {
    let DrawMemory {
        waiting, rounds, ..
    } = memory;
    draw_waiting(frame, waiting, horizon, buffer, rounds, |object| {
        hidden[object as usize] = true;
    });
}
