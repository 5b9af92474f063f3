//! Closes gaps: where an object shows that ought to be hidden, what covers it is drawn.
//!
//! After the clusters that the last frame needed are drawn, some objects are still to be seen that were not seen before. Each
//! shows itself at some samples. A ray through such a sample tells whether there is a cluster, not drawn yet, that covers it.
//! If there is none, the object is visible. If there is one for each of the samples, these are drawn, and the object is asked
//! again. So nothing is drawn but what hides an object, or a part of one, that would be seen without it.
//!
//! This is multi-pass culling (HOM §2.1.4) with passes as small as they can be.

use super::Frame;
use super::clusters::ClusterWalk;
use super::covers::{Cover, Covers, Sample};
use super::draw::Drawn;
use super::rounds::{EVERYTHING, RoundMemory, draw_waiting};
use super::test::is_hidden;
use super::waiting::{Waiting, WaitingCluster};
use crate::occlusion::{Footprint, OcclusionBuffer, SampleRect};

/// So many objects are looked at before what might cover them is drawn: others are often seen through the same gap.
const LOOKED_AT_TOGETHER: usize = 32;

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct GapMemory {
    covers: Covers,
    /// Those that are not decided yet, the next one last.
    questions: Vec<Question>,
    /// Those that are looked at next.
    to_look_at: Vec<Question>,
    /// Those for which something is to be drawn.
    looked_at: Vec<Question>,
    clusters: ClusterWalk,
    /// What is to be drawn.
    to_draw: Vec<Cover>,
}

#[derive(Clone, Copy, Debug)]
struct Question {
    object: u32,
    rect: SampleRect,
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
    memory.covers.begin(frame, undecided, drawn.occluders);
    drawn.statistics.objects_in_question += memory.questions.len() as u64;
    // Each pass decides about an object or draws a cluster, and none is drawn twice.
    while !memory.questions.is_empty()
        && !frame.is_time_over()
        && frame.has_pass_left(drawn.statistics.passes)
    {
        memory.look(frame, buffer, drawn);
        if memory.looked_at.is_empty() {
            continue;
        }
        for cover in &memory.to_draw {
            let placed = waiting.place(frame, cover.id.object, true, buffer.screen());
            waiting.push(WaitingCluster {
                placed,
                cluster: cover.id.cluster,
                triangles: cover.triangles,
                known: None,
                footprint: cover.footprint,
                asked_before: None,
            });
            memory.covers.take(cover.id);
        }
        drawn.statistics.passes += 1;
        let first_drawn = drawn.occluders.len();
        let is_within_budget = draw_waiting(frame, waiting, EVERYTHING, buffer, rounds, drawn);
        buffer.close_holes();
        memory.judge(frame, buffer, first_drawn, drawn);
        if !is_within_budget {
            return;
        }
    }
}

/// What is found of an object.
enum Found {
    /// It is hidden already.
    IsHidden,
    /// Nothing covers one of the samples at which it shows.
    Nothing,
    /// Something covers each of them.
    Closers,
}

impl GapMemory {
    /// Finds out what is to be drawn to hide some objects.
    fn look(&mut self, frame: &Frame<'_>, buffer: &OcclusionBuffer, drawn: &mut Drawn<'_>) {
        self.looked_at.clear();
        self.to_draw.clear();
        let from = self.questions.len().saturating_sub(LOOKED_AT_TOGETHER);
        self.to_look_at.clear();
        self.to_look_at.extend(self.questions.drain(from..));
        for i in 0..self.to_look_at.len() {
            let question = self.to_look_at[i];
            let before = self.to_draw.len();
            match self.find_closers(frame, buffer, question) {
                Found::Closers => self.looked_at.push(question),
                Found::Nothing => {
                    self.to_draw.truncate(before);
                    // It is visible, unless what there is of it within its box is not.
                    if self.clusters.are_all_hidden(frame, buffer, question.object) {
                        drawn.hidden.set(question.object);
                    }
                }
                Found::IsHidden => drawn.hidden.set(question.object),
            }
        }
    }

    /// Finds clusters that cover the samples at which an object shows.
    fn find_closers(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        Question { object, rect }: Question,
    ) -> Found {
        let bounds = &frame.scene.bounds()[object as usize];
        let looks = buffer.looks_at(bounds, rect);
        let seen = (0..8).filter(|i| looks.seen >> i & 1 == 1);
        let seen = seen.map(|i| {
            let sample = [looks.columns[i] as i32, looks.rows[i] as i32];
            (sample, looks.depths[i] as f32)
        });
        let hardly_seen = if looks.seen == 0 {
            if is_hidden(frame, buffer, object as usize, Footprint::Within(rect)) {
                return Found::IsHidden;
            }
            buffer.open_sample(bounds, rect)
        } else {
            None
        };
        let mut found = Found::Nothing;
        for ([column, row], depth) in seen.chain(hardly_seen) {
            let sample = Sample { column, row, depth };
            found = Found::Closers;
            let GapMemory {
                covers, to_draw, ..
            } = self;
            let mut chosen = to_draw.iter().rev();
            if chosen.any(|cover| covers.covers(frame, cover, sample)) {
                continue;
            }
            match covers.find(frame, buffer.screen(), sample, object) {
                Some(closer) => to_draw.push(closer),
                None => return Found::Nothing,
            }
        }
        found
    }

    /// Decides about the objects that were looked at, after what covers them is drawn, and remembers what that was.
    fn judge(
        &mut self,
        frame: &Frame<'_>,
        buffer: &OcclusionBuffer,
        first_drawn: usize,
        drawn: &mut Drawn<'_>,
    ) {
        for question in self.looked_at.drain(..) {
            let Question { object, rect } = question;
            let footprint = Footprint::Within(rect);
            let is_hidden =
                buffer.hides(footprint) || is_hidden(frame, buffer, object as usize, footprint);
            if is_hidden {
                drawn.hidden.set(object);
            } else {
                // There may be something else that covers its samples.
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
        for &Cover { id, .. } in &self.to_draw {
            let mut new = drawn.occluders[first_drawn..].iter();
            if let Some(cluster) = new.find(|new| new.id == id && new.gain > 0) {
                drawn
                    .contributions
                    .needed(id, cluster.triangles, cluster.gain);
            }
        }
    }
}
