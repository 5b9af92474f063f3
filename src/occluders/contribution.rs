//! The memory of contribution: which clusters a frame needed, so that the next draws them first, and no others.
//!
//! A cluster is needed if something behind it is seen without it. Most of what can be seen is not needed in this sense: it
//! hides nothing that what stands behind it does not hide as well. (The papers remember which objects were visible: GW §5.2,
//! VDR §5.3, HOM equation 7.1. Of the clusters visible in a frame, a tenth to a third hide as much as all of them.)
//!
//! So the memory is put to the test. Every now and then a frame leaves a cluster out that it remembers. If something is seen
//! then that was not before, the cluster is drawn after all, in the same frame, and is not left out for twice as long; if
//! not, it is forgotten. What is remembered follows what is seen, not what exists.

use super::Budget;
use crate::prepare::{CLUSTER_COST, ClusterId};

/// A cluster is remembered for so many frames before it is left out for the first time,
const FIRST_HOLD: u8 = 2;
/// and for some more, up to this, so that not all that were drawn first in the same frame are left out in the same one.
const STAGGER: u32 = 8;
/// When it has turned out to be needed, it is not left out for so many frames,
const NEEDED_HOLD: u8 = 64;
/// and each time again for twice as many, up to this.
const LONGEST_HOLD: u8 = 250;

/// Values are kept in so many parts of a sample, so that halving does not lose them at once.
const PARTS_OF_SAMPLE: u32 = 16;

/// Of a budget of triangles, the memory takes so many quarters; what turns out to be needed takes what is left.
const QUARTERS_OF_BUDGET: u64 = 3;

/// What is remembered of a cluster.
#[derive(Clone, Copy, Debug)]
struct Known {
    id: ClusterId,
    /// The samples that it took over, in parts of them: half of it from the last frame, a quarter from the one before …
    value: u32,
    triangles: u8,
    /// For how many frames it will not be left out.
    hold: u8,
    /// What that was when it was last found to be needed.
    last_hold: u8,
    /// What became of it in this frame.
    fate: Fate,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// It was left out.
    LeftOut,
    /// It was to be drawn, but is outside the picture or hidden.
    Hidden,
    /// There was no time to find out.
    Untried,
    /// It was drawn.
    Drawn,
}

/// The clusters of instances that were needed.
#[derive(Clone, Debug, Default)]
pub struct Contributions {
    /// In the order of their ids.
    known: Vec<Known>,
    /// Those that this frame needed and did not draw from memory.
    needed: Vec<Known>,
    merged: Vec<Known>,
}

impl Known {
    /// The larger, the more it hides for what it costs.
    fn density(&self) -> u64 {
        (u64::from(self.value) << 16) / u64::from(u32::from(self.triangles) + CLUSTER_COST)
    }
}

impl Contributions {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.known.clear();
        self.needed.clear();
    }

    /// How many clusters are remembered.
    pub fn len(&self) -> usize {
        self.known.len()
    }

    /// Whether nothing is remembered.
    pub fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// The cluster at a place of the memory.
    pub fn id(&self, place: u32) -> ClusterId {
        self.known[place as usize].id
    }

    /// Begins a frame: puts the places of the clusters to draw first into `chosen`, in the order of their ids.
    pub fn choose(&mut self, budget: Budget, chosen: &mut Vec<u32>) {
        chosen.clear();
        for (place, known) in (0..).zip(&mut self.known) {
            known.fate = Fate::LeftOut;
            if known.hold > 0 {
                known.hold -= 1;
                known.fate = Fate::Hidden;
                chosen.push(place);
            }
        }
        if let Budget::Triangles(most) = budget {
            let mut left = most * QUARTERS_OF_BUDGET / 4;
            let known = &self.known;
            chosen.sort_unstable_by_key(|&place| (!known[place as usize].density(), place));
            let within = chosen.iter().take_while(|&&place| {
                let triangles = u64::from(known[place as usize].triangles);
                let fits = triangles <= left;
                left = left.saturating_sub(triangles);
                fits
            });
            let count = within.count();
            for place in chosen.drain(count..) {
                self.known[place as usize].fate = Fate::LeftOut;
            }
            chosen.sort_unstable();
        }
    }

    /// Puts the places of all clusters into `chosen`, in the order of their ids, for a frame that is a part of the last one: none
    /// is left out, and [`Contributions::end_part`] ends it.
    pub fn choose_all(&self, chosen: &mut Vec<u32>) {
        chosen.clear();
        chosen.extend(0..self.known.len() as u32);
    }

    /// Ends a frame that is a part of the last one: adds what it needed, and leaves the rest as it is.
    pub fn end_part(&mut self) {
        for known in &mut self.needed {
            known.fate = Fate::Drawn;
        }
        self.known.append(&mut self.needed);
        self.known.sort_by_key(|known| known.id);
        self.known.dedup_by_key(|known| known.id);
    }

    /// Notes that the cluster at a place was drawn, and how many samples it took over.
    pub fn drawn(&mut self, place: u32, gain: u32) {
        let known = &mut self.known[place as usize];
        known.fate = Fate::Drawn;
        known.value += gain * PARTS_OF_SAMPLE;
    }

    /// Notes that there was no time to draw all that was chosen, nor to find out what is missed of what was left out: what was not
    /// drawn fades away like the rest, instead of being forgotten at once.
    pub fn keep_untried(&mut self) {
        for known in &mut self.known {
            if known.fate != Fate::Drawn {
                known.fate = Fate::Untried;
            }
        }
    }

    /// Remembers a cluster that was drawn and needed, but not chosen.
    pub fn needed(&mut self, id: ClusterId, triangles: u32, gain: u32) {
        let stagger = (id.object ^ id.cluster) % STAGGER;
        self.needed.push(Known {
            id,
            value: gain * PARTS_OF_SAMPLE,
            triangles: triangles.min(u32::from(u8::MAX)) as u8,
            hold: FIRST_HOLD + stagger as u8,
            last_hold: 0,
            fate: Fate::Drawn,
        });
    }

    /// Ends a frame: forgets what added nothing, and what was left out and is not needed.
    pub fn end_frame(&mut self) {
        self.needed.sort_unstable_by_key(|known| known.id);
        self.merged.clear();
        let mut needed = self.needed.drain(..).peekable();
        for &known in &self.known {
            while let Some(before) = needed.next_if(|needed| needed.id < known.id) {
                self.merged.push(before);
            }
            if let Some(again) = needed.next_if(|needed| needed.id == known.id) {
                let hold = known
                    .last_hold
                    .saturating_mul(2)
                    .clamp(NEEDED_HOLD, LONGEST_HOLD);
                self.merged.push(Known {
                    hold,
                    last_hold: hold,
                    ..again
                });
            } else if matches!(known.fate, Fate::Drawn | Fate::Untried) && known.value > 0 {
                let value = known.value / 2;
                self.merged.push(Known { value, ..known });
            }
        }
        self.merged.extend(needed);
        std::mem::swap(&mut self.known, &mut self.merged);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(object: u32) -> ClusterId {
        ClusterId { object, cluster: 0 }
    }

    /// A frame in which a cluster is drawn if it is chosen, and found to be needed if it is not. Whether it was left out.
    fn frame(memory: &mut Contributions, is_needed: bool) -> bool {
        let mut chosen = Vec::new();
        memory.choose(Budget::Auto, &mut chosen);
        for &place in &chosen {
            memory.drawn(place, 100);
        }
        let is_left_out = chosen.is_empty();
        if is_left_out && is_needed {
            memory.needed(id(0), 2, 100);
        }
        memory.end_frame();
        is_left_out
    }

    #[test]
    fn what_is_needed_is_left_out_ever_more_seldom() {
        let mut memory = Contributions::default();
        memory.needed(id(0), 2, 100);
        memory.end_frame();
        let left_out: Vec<usize> = (0..600).filter(|_| frame(&mut memory, true)).collect();
        let pauses: Vec<usize> = left_out.windows(2).map(|w| w[1] - w[0] - 1).collect();
        assert_eq!(pauses[..2], [64, 128]);
        assert!(pauses.iter().all(|&pause| pause <= 250));
        assert_eq!(memory.len(), 1);
    }

    #[test]
    fn what_is_not_needed_is_forgotten() {
        let mut memory = Contributions::default();
        memory.needed(id(0), 2, 100);
        memory.end_frame();
        assert!((0..12).any(|_| frame(&mut memory, false)));
        assert!(memory.is_empty());
    }

    #[test]
    fn what_is_hidden_is_forgotten() {
        let mut memory = Contributions::default();
        memory.needed(id(0), 2, 100);
        memory.end_frame();
        memory.choose(Budget::Auto, &mut Vec::new());
        memory.end_frame();
        assert!(memory.is_empty());
    }

    #[test]
    fn what_had_no_turn_fades_away() {
        let mut memory = Contributions::default();
        for object in [0, 8] {
            memory.needed(id(object), 2, 100);
        }
        memory.end_frame();
        let mut frames = 0;
        while !memory.is_empty() {
            let mut chosen = Vec::new();
            memory.choose(Budget::Auto, &mut chosen);
            memory.keep_untried();
            memory.end_frame();
            frames += 1;
        }
        // 100 samples are 1,600 parts.
        assert_eq!(frames, 11 + 1);
    }

    #[test]
    fn a_budget_takes_those_that_hide_most_for_what_they_cost() {
        let mut memory = Contributions::default();
        for (object, triangles, gain) in [(0, 60, 600), (1, 10, 900), (2, 10, 100), (3, 20, 1000)] {
            memory.needed(id(object), triangles, gain);
        }
        memory.end_frame();
        let mut chosen = Vec::new();
        // Three quarters of it are 30 triangles.
        memory.choose(Budget::Triangles(40), &mut chosen);
        let objects: Vec<u32> = chosen
            .iter()
            .map(|&place| memory.id(place).object)
            .collect();
        assert_eq!(objects, [1, 3]);
    }
}
