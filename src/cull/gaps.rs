//! Closes gaps: where an object shows that ought to be hidden, what might cover it is drawn.
//!
//! After the clusters that the last frame needed are drawn, some objects are still to be seen that were not seen before. Each
//! shows itself at some sample. If no cluster that is not drawn yet may cover that sample, the object is visible. Otherwise
//! those that may are drawn, and the object is asked again. So what is drawn is what an object in question is seen through
//! without, whatever else there is.
//!
//! This is multi-pass culling (HOM §2.1.4) whose passes are as small as they can be: the first draws clusters that were left
//! out to see whether they are needed.

use super::Frame;
use super::covers::{Covers, Sample};
use super::draw::Drawn;
use super::rounds::{EVERYTHING, RoundMemory, draw_waiting};
use super::waiting::{Waiting, WaitingCluster};
use crate::occlusion::{Footprint, OcclusionBuffer, SampleRect};

/// So many objects are looked at before what might cover them is drawn: others are often seen through the same gap.
const LOOKED_AT_TOGETHER: usize = 32;

/// After so many passes, what still shows is visible.
const MOST_PASSES: usize = 64;

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct GapMemory {
    covers: Covers,
    /// Those that are not decided yet, the next one last.
    questions: Vec<Question>,
    looked_at: Vec<LookedAt>,
    /// Clusters to draw, and those that may cover each gap.
    to_draw: Vec<usize>,
    closers: Vec<usize>,
    found: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Question {
    object: u32,
    rect: SampleRect,
}

/// An object and a sample at which it shows.
#[derive(Clone, Copy, Debug)]
struct LookedAt {
    question: Question,
    gap: Sample,
    /// Where its closers begin.
    first_closer: usize,
    /// Whether all that may cover the gap is drawn.
    is_last_try: bool,
}

/// Decides about `questions`, objects within rectangles that show themselves and are not known to be visible; `undecided` are
/// they and all others that may hide them. Marks what is hidden after all.
pub fn close_gaps(
    frame: &Frame<'_>,
    buffer: &mut OcclusionBuffer,
    undecided: &[(u32, Footprint)],
    questions: impl Iterator<Item = (u32, SampleRect)>,
    memory: &mut GapMemory,
    (waiting, rounds): (&mut Waiting, &mut RoundMemory),
    drawn: &mut Drawn<'_>,
) {
    memory.questions.clear();
    let questions = questions.map(|(object, rect)| Question { object, rect });
    memory.questions.extend(questions);
    if memory.questions.is_empty() {
        return;
    }
    memory.covers.begin(undecided);
    for _ in 0..MOST_PASSES {
        memory.look(frame, buffer, drawn);
        if memory.looked_at.is_empty() {
            if memory.questions.is_empty() {
                return;
            }
            continue;
        }
        for &index in &memory.to_draw {
            let cover = memory.covers.cluster(index);
            let placed = waiting.place(frame, cover.id.object, true, buffer.screen());
            waiting.push(WaitingCluster {
                placed,
                cluster: cover.id.cluster,
                triangles: cover.triangles,
                known: None,
                footprint: cover.footprint,
                asked_before: None,
            });
            memory.covers.take(index);
        }
        let first_drawn = drawn.occluders.len();
        let is_within_budget = draw_waiting(frame, waiting, EVERYTHING, buffer, rounds, drawn);
        memory.judge(frame, buffer, first_drawn, drawn);
        if !is_within_budget {
            return;
        }
    }
}

impl GapMemory {
    /// Finds a gap for each of some objects, and what to draw.
    fn look(&mut self, frame: &Frame<'_>, buffer: &OcclusionBuffer, drawn: &Drawn<'_>) {
        self.looked_at.clear();
        self.to_draw.clear();
        self.closers.clear();
        let from = self.questions.len().saturating_sub(LOOKED_AT_TOGETHER);
        for question in self.questions.split_off(from) {
            let Some((gap, is_last_try)) = self.find_gap(frame, buffer, drawn, question) else {
                // It is visible.
                continue;
            };
            self.looked_at.push(LookedAt {
                question,
                gap,
                first_closer: self.closers.len(),
                is_last_try,
            });
            self.closers.extend_from_slice(&self.found);
            self.to_draw.extend_from_slice(&self.found);
        }
        self.to_draw.sort_unstable();
        self.to_draw.dedup();
    }

    /// Finds a sample at which an object shows, and puts what may cover it into `found`. None if there is one that nothing may
    /// cover. Whether that is all that may, or only what was left out.
    fn find_gap(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        drawn: &Drawn<'_>,
        Question { object, rect }: Question,
    ) -> Option<(Sample, bool)> {
        let looks = buffer.looks_at(&frame.scene.bounds()[object as usize], rect);
        let mut best: Option<Sample> = None;
        let mut left = looks.seen;
        let mut over = Vec::new();
        self.found.clear();
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            let sample = Sample {
                column: looks.columns[i] as i32,
                row: looks.rows[i] as i32,
                depth: looks.depths[i] as f32,
            };
            let contributions = &*drawn.contributions;
            self.covers.find(frame, buffer.screen(), contributions, sample, object, &mut over);
            if over.is_empty() {
                return None;
            }
            if best.is_none() || over.len() < self.found.len() {
                best = Some(sample);
                std::mem::swap(&mut self.found, &mut over);
            }
        }
        let best = best?;
        let is_left_out = |index: &usize| {
            drawn
                .contributions
                .is_left_out(self.covers.cluster(*index).id)
        };
        if self.found.iter().any(is_left_out) {
            self.found.retain(is_left_out);
            return Some((best, false));
        }
        Some((best, true))
    }

    /// Decides about the objects that were looked at, after what may cover their gaps is drawn, and remembers what closed them.
    fn judge(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        first_drawn: usize,
        drawn: &mut Drawn<'_>,
    ) {
        let hides = |question: &Question| {
            let footprint = Footprint::Within(question.rect);
            buffer.hides(footprint)
                || super::test::is_hidden(frame, buffer, question.object as usize, footprint)
        };
        self.to_draw.clear();
        let ends = self.looked_at[1..].iter().map(|next| next.first_closer);
        let ends = ends.chain([self.closers.len()]);
        for (looked_at, end) in self.looked_at.iter().zip(ends) {
            let &LookedAt {
                question,
                gap,
                first_closer,
                is_last_try,
            } = looked_at;
            let is_closed = buffer.is_nearer_at(gap.column, gap.row, gap.depth);
            if is_closed {
                self.to_draw.extend_from_slice(&self.closers[first_closer..end]);
            }
            if is_closed && hides(&question) {
                drawn.hidden.set(question.object);
            } else if is_closed || !is_last_try {
                self.questions.push(question);
            }
        }
        // Others may have been seen through the same gaps.
        self.questions.retain(|question| {
            let is_hidden = buffer.hides(Footprint::Within(question.rect));
            if is_hidden {
                drawn.hidden.set(question.object);
            }
            !is_hidden
        });
        self.to_draw.sort_unstable();
        self.to_draw.dedup();
        for &index in &self.to_draw {
            let id = self.covers.cluster(index).id;
            let new = drawn.occluders[first_drawn..].iter();
            if let Some(cluster) = new.clone().find(|new| new.id == id && new.gain > 0) {
                drawn.contributions.needed(id, cluster.triangles, cluster.gain);
            }
        }
    }
}
