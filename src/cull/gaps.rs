//! Closes gaps: where an object shows that ought to be hidden, what covers it is drawn.
//!
//! After the clusters that the last frame needed are drawn, some objects are still to be seen that were not seen before. Each
//! shows itself at some samples. A ray through such a sample tells whether there is a cluster, not drawn yet, that covers it.
//! If there is none, the object is visible. If there is one for each of the samples, these are drawn, and the object is asked
//! again. So nothing is drawn but what hides an object, or a part of one, that would be seen without it.
//!
//! This is multi-pass culling (HOM §2.1.4) with passes as small as they can be.

use super::Frame;
use super::covers::{Cover, Covers, Sample};
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
    /// Those for which something is to be drawn.
    looked_at: Vec<LookedAt>,
    /// Places of clusters to draw.
    to_draw: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Question {
    object: u32,
    rect: SampleRect,
}

/// An object, and a sample at which it shows.
#[derive(Clone, Copy, Debug)]
struct LookedAt {
    question: Question,
    gap: Sample,
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
    drawn.statistics.objects_in_question += memory.questions.len() as u64;
    for _ in 0..MOST_PASSES {
        memory.look(frame, buffer, drawn);
        if memory.looked_at.is_empty() {
            if memory.questions.is_empty() {
                return;
            }
            continue;
        }
        for &index in &memory.to_draw {
            let Some(cover) = memory.covers.cluster(index) else {
                continue;
            };
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
        drawn.statistics.passes += 1;
        let first_drawn = drawn.occluders.len();
        let (dl, dd, dq) = (memory.looked_at.len(), memory.to_draw.len(), memory.questions.len());
        let is_within_budget = draw_waiting(frame, waiting, EVERYTHING, buffer, rounds, drawn);
        let closed = memory.looked_at.iter().filter(|l| buffer.is_nearer_at(l.gap.column, l.gap.row, l.gap.depth)).count();
        memory.judge(frame, buffer, first_drawn, drawn);
        if std::env::var("GAPS").is_ok() { eprintln!("   looked {dl} draw {dd} waiting {dq} -> closed {closed} credited? {} drawn {} gain0 {} left {}", memory.to_draw.len(), drawn.occluders.len() - first_drawn, drawn.occluders[first_drawn..].iter().filter(|c| c.gain == 0).count(), memory.questions.len()); }
        if !is_within_budget {
            return;
        }
    }
}

impl GapMemory {
    /// Finds out what is to be drawn to hide some objects.
    fn look(&mut self, frame: &Frame<'_>, buffer: &OcclusionBuffer, drawn: &Drawn<'_>) {
        self.looked_at.clear();
        self.to_draw.clear();
        let from = self.questions.len().saturating_sub(LOOKED_AT_TOGETHER);
        for question in self.questions.split_off(from) {
            let before = self.to_draw.len();
            match self.find_closers(frame, buffer, drawn, question) {
                Some(gap) => self.looked_at.push(LookedAt { question, gap }),
                // It is visible.
                None => self.to_draw.truncate(before),
            }
        }
    }

    /// Finds clusters that cover the samples at which an object shows; returns one of these. None if there is one that nothing
    /// covers, or the object shows somewhere else.
    fn find_closers(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        drawn: &Drawn<'_>,
        Question { object, rect }: Question,
    ) -> Option<Sample> {
        let looks = buffer.looks_at(&frame.scene.bounds()[object as usize], rect);
        let mut gap = None;
        for i in (0..8).filter(|i| looks.seen >> i & 1 == 1) {
            let sample = Sample {
                column: looks.columns[i] as i32,
                row: looks.rows[i] as i32,
                depth: looks.depths[i] as f32,
            };
            gap = Some(sample);
            let GapMemory {
                covers, to_draw, ..
            } = self;
            let mut chosen = to_draw.iter().rev();
            if chosen.any(|&place| covers.covers(frame, place, sample)) {
                continue;
            }
            let contributions = &*drawn.contributions;
            let screen = buffer.screen();
            let closer = self
                .covers
                .find(frame, screen, contributions, sample, object)?;
            self.to_draw.push(closer);
        }
        gap
    }

    /// Decides about the objects that were looked at, after what covers them is drawn, and remembers what that was.
    fn judge(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        first_drawn: usize,
        drawn: &mut Drawn<'_>,
    ) {
        for &LookedAt { question, gap } in &self.looked_at {
            let Question { object, rect } = question;
            let footprint = Footprint::Within(rect);
            let is_hidden = buffer.hides(footprint)
                || super::test::is_hidden(frame, buffer, object as usize, footprint);
            if is_hidden {
                drawn.hidden.set(object);
            } else if buffer.is_nearer_at(gap.column, gap.row, gap.depth) {
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
        for &place in &self.to_draw {
            let Some(&Cover { id, .. }) = self.covers.cluster(place) else {
                continue;
            };
            let mut new = drawn.occluders[first_drawn..].iter();
            if let Some(cluster) = new.find(|new| new.id == id && new.gain > 0) {
                drawn
                    .contributions
                    .needed(id, cluster.triangles, cluster.gain);
            }
        }
    }
}
