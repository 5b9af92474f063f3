//! Draws occluders into the buffer: batch after batch, each asked first (`ask`); cluster by cluster, nearest first
//! (`waiting`, `rounds`).

use super::ask::{Answer, AskMemory, ask};
use super::gaps::{self, GapMemory};
use super::marks::Marks;
use super::recall::{RecallMemory, recall};
use super::rounds::{EVERYTHING, RoundMemory, draw_waiting};
use super::sampled::{SampledMemory, sampled};
use super::traverse::{TraverseMemory, hide_subtrees};
use super::waiting::{Waiting, nearness};
use super::{Frame, Statistics};
use crate::occluders::{Contributions, DrawnCluster, object_of, sort_nearest};
use crate::occlusion::{Footprint, OcclusionBuffer, SampleRect, Screen};
use crate::prepare::{ClusterId, SampledCluster};
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
    /// The clusters that are drawn already, in the order of their ids.
    done: Vec<ClusterId>,
    ask: AskMemory,
    waiting: Waiting,
    rounds: RoundMemory,
    traverse: TraverseMemory,
    recall: RecallMemory,
    sampled: SampledMemory,
    gaps: GapMemory,
}

impl DrawMemory {
    /// Forgets what waits: what a spent budget has left over.
    fn begin(&mut self) {
        self.waiting.clear();
        self.rounds.clear();
    }
}

/// What drawing found and did.
pub struct Drawn<'a> {
    /// For each object, whether it was found hidden. What a part of the occluders hides stays hidden behind all of them.
    pub hidden: &'a mut Marks,
    /// The clusters that were drawn, in order.
    pub occluders: &'a mut Vec<DrawnCluster>,
    /// What is remembered of clusters.
    pub contributions: &'a mut Contributions,
    /// Counts.
    pub statistics: &'a mut Statistics,
}

/// Draws occluders, nearest first, as far as the budget goes, each asked first, but for clusters that are drawn already.
/// `candidates` are their keys
/// ([`distance_keys`](crate::occluders::distance_keys)), in any order.
pub fn draw_occluders(
    frame: &Frame<'_>,
    candidates: &mut Vec<u64>,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: &mut Drawn<'_>,
) {
    let mut before_look = OBJECTS_BEFORE_LOOK;
    let mut per_batch = if frame.settings.occluders.is_by_distance() {
        OBJECTS_PER_BATCH
    } else {
        // A batch is drawn nearest first, and a budget is to be spent in the order of the selection.
        1
    };
    memory.begin();
    memory.done.clear();
    let done = drawn.occluders.iter().map(|cluster| cluster.id);
    memory.done.extend(done);
    memory.done.sort_unstable();
    loop {
        let taken = candidates.len().min(before_look);
        frame.tasks.alone(Work::Select, || {
            sort_nearest(candidates, taken);
        });
        let mut batches = candidates[..taken].chunks(per_batch);
        let is_within_budget = batches.all(|batch| {
            memory.batch.clear();
            memory.batch.extend(batch.iter().map(|&key| object_of(key)));
            draw_batch(frame, buffer, memory, drawn)
        });
        candidates.drain(..taken);
        if !is_within_budget {
            return;
        }
        if candidates.is_empty() {
            draw_until(EVERYTHING, frame, buffer, memory, drawn);
            return;
        }
        if frame.asks_before_drawing() {
            frame.tasks.alone(Work::Look, || buffer.close_holes());
            hide_subtrees(
                frame,
                buffer,
                &mut memory.traverse,
                drawn.hidden,
                drawn.statistics,
            );
        }
        candidates.retain(|&key| !drawn.hidden.has(object_of(key)));
        before_look *= MORE_BEFORE_NEXT_LOOK;
        if per_batch > 1 {
            per_batch = MOST_PER_BATCH.min(2 * per_batch);
        }
    }
}

/// Asks the objects of a batch, and draws those that are not hidden. Whether the budget allows for more.
fn draw_batch(
    frame: &Frame<'_>,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: &mut Drawn<'_>,
) -> bool {
    if frame.is_time_over() {
        return false;
    }
    let batch = &memory.batch;
    let answers = ask(frame, batch, buffer, &mut memory.ask);
    drawn.statistics.occluders_asked += batch.len() as u64;
    memory.to_draw.clear();
    for (&object, &answer) in batch.iter().zip(answers) {
        match answer {
            Answer::Hidden => drawn.hidden.set(object),
            // Its own mesh may be far beyond any budget: that is what it has a proxy for.
            Answer::CutOpen => {}
            Answer::Visible(footprint) => memory.to_draw.push((object, footprint)),
        }
    }
    // What is behind all that begins here may wait for others that begin before it.
    let Some(&(_, farthest)) = memory.to_draw.last() else {
        return true;
    };
    let DrawMemory {
        waiting,
        to_draw,
        done,
        ..
    } = memory;
    let hide = |object: u32| drawn.hidden.set(object);
    waiting.add(frame, to_draw, done, buffer, hide);
    let horizon = if frame.settings.occluders.is_by_distance() {
        nearness(farthest)
    } else {
        EVERYTHING
    };
    draw_until(horizon, frame, buffer, memory, drawn)
}

/// Draws the clusters that are remembered.
pub fn draw_remembered(
    frame: &Frame<'_>,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: &mut Drawn<'_>,
) {
    recall_remembered(frame, drawn.contributions, buffer.screen(), memory);
    draw_recalled(frame, buffer, memory, drawn);
}

/// Lets the clusters wait that are remembered. Returns whether more than one in four of them is out of the picture.
pub fn recall_remembered(
    frame: &Frame<'_>,
    contributions: &mut Contributions,
    screen: &Screen,
    memory: &mut DrawMemory,
) -> bool {
    memory.begin();
    recall(
        frame,
        contributions,
        screen,
        &mut memory.recall,
        &mut memory.waiting,
    )
}

/// Draws the clusters that wait.
pub fn draw_recalled(
    frame: &Frame<'_>,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: &mut Drawn<'_>,
) {
    draw_until(EVERYTHING, frame, buffer, memory, drawn);
}

/// Draws the clusters that are seen from a viewpoint near the eye.
pub fn draw_sampled(
    frame: &Frame<'_>,
    seen: &[SampledCluster],
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: &mut Drawn<'_>,
) {
    memory.begin();
    sampled(
        frame,
        seen,
        buffer.screen(),
        &mut memory.sampled,
        &mut memory.waiting,
    );
    draw_until(EVERYTHING, frame, buffer, memory, drawn);
}

/// Draws what keeps objects in question from being seen, and marks those that are hidden then: [`close_gaps`](gaps::close_gaps).
pub fn draw_what_closes_gaps(
    frame: &Frame<'_>,
    buffer: &mut OcclusionBuffer,
    undecided: &[(u32, Footprint)],
    questions: impl Iterator<Item = (u32, SampleRect)>,
    memory: &mut DrawMemory,
    drawn: &mut Drawn<'_>,
) {
    memory.begin();
    let DrawMemory {
        gaps,
        waiting,
        rounds,
        ..
    } = memory;
    gaps::close_gaps(
        frame,
        buffer,
        undecided,
        questions,
        gaps,
        (waiting, rounds),
        drawn,
    );
}

/// Draws what waits as far as a horizon. Whether the budget allows for more.
fn draw_until(
    horizon: u32,
    frame: &Frame<'_>,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: &mut Drawn<'_>,
) -> bool {
    let DrawMemory {
        waiting, rounds, ..
    } = memory;
    draw_waiting(frame, waiting, horizon, buffer, rounds, drawn)
}
