//! Schedules: which stage waits for which stage of which frame.
//!
//! ```text
//! camera → select → draw occluders → cull → final draw      a frame
//!             ↑                         │
//!             └─── what is remembered ──┘                    of the frame `frames_back` before
//! ```
//!
//! - The select of frame N waits for the cull of frame N − `frames_back`, which says what was needed and seen, and for the final draw
//!   of frame N − `frames_in_flight`, whose memory it takes.
//! - Every other stage waits for the one before, of the same frame.
//! - Stages at one place wait for each other: a place is a thread. If several could go on there, the earliest stage does. That is the
//!   order of HOM figure 8.2: occluders of frame N + 1, then the final draw of frame N. (There the final draw also waits if the next
//!   frame's occluders are not selected yet. Here it goes on.)
//!
//! Nothing ever waits for a later frame, so no schedule can come to a stop.
//!
//! **Invariant.** What a frame finds depends on its camera and on what it is told of the frame `frames_back` before it, never on who
//! did what when. So schedules with the same `frames_back` find the same.

/// A stage of a frame in a pipeline (HOM §8.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Chooses the occluders: OccSel.
    Select,
    /// Draws them: OccDraw.
    DrawOccluders,
    /// Finds what may be seen: Cull.
    Cull,
    /// Draws that: FinalDraw.
    FinalDraw,
}

impl Stage {
    /// All, in order.
    pub const ALL: [Stage; 4] = [
        Stage::Select,
        Stage::DrawOccluders,
        Stage::Cull,
        Stage::FinalDraw,
    ];

    /// The stage after this one, of the same frame.
    pub fn next(self) -> Option<Stage> {
        Stage::ALL.get(self as usize + 1).copied()
    }
}

/// How the stages of frames follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// The place of each stage, in the order of [`Stage::ALL`]. Stages at the same place are one thread's work. The place of the
    /// final draw is the calling thread. Which numbers places have does not matter.
    pub places: [u8; 4],
    /// How many frames may be under way at once: the camera of a frame is taken when the final draw of the frame so many before it
    /// is done. 0 is taken for 1.
    pub frames_in_flight: u8,
    /// A frame knows what the frame so many before it needed and saw. 0 is taken for 1.
    pub frames_back: u8,
}

impl Schedule {
    /// All stages of a frame, then those of the next.
    pub const SEQUENTIAL: Schedule = Schedule {
        places: [0; 4],
        frames_in_flight: 1,
        frames_back: 1,
    };

    /// The final draw of a frame, while the next one goes through all other stages. (No paper's: the least that overlaps.)
    pub const TWO_STAGE: Schedule = Schedule {
        places: [0, 0, 0, 1],
        frames_in_flight: 2,
        frames_back: 1,
    };

    /// OccSel of frame N + 2 | Cull of N + 1 | OccDraw of N + 1 and FinalDraw of N, which share one place, as if there were one
    /// graphics pipeline (HOM §8.1, figures 8.1 and 8.2). When OccSel of N + 2 is released, Cull of N − 1 is the last that is done.
    pub const THREE_STAGE: Schedule = Schedule {
        places: [0, 2, 1, 2],
        frames_in_flight: 3,
        frames_back: 3,
    };

    /// Occluders of frame i + 2 are drawn (OR) | i + 1 is culled (STC) | the visible geometry of i is drawn (RVG), each by a process
    /// of its own (GigaWalk §5.1 and figure 6). What occludes is known from two frames before, so that OR does not wait for STC of
    /// the last one (§5.2).
    pub const THREE_PROCESSES: Schedule = Schedule {
        places: [0, 0, 1, 2],
        frames_in_flight: 3,
        frames_back: 2,
    };

    /// The schedules above and their names.
    pub const NAMED: [(&'static str, Schedule); 4] = [
        ("sequential", Schedule::SEQUENTIAL),
        ("two-stage", Schedule::TWO_STAGE),
        ("three-stage", Schedule::THREE_STAGE),
        ("three-processes", Schedule::THREE_PROCESSES),
    ];

    /// How many places there are: threads, the calling one among them.
    pub fn threads(&self) -> usize {
        1 + self.numbered().into_iter().max().unwrap_or_default()
    }

    /// The same on so many threads at the most. The first places are put together: those that are far from the final draw. What
    /// frames find stays the same.
    pub fn on_threads(self, threads: usize) -> Schedule {
        let places = self.numbered();
        let fewer = self.threads().saturating_sub(threads.max(1));
        Schedule {
            places: places.map(|place| place.saturating_sub(fewer) as u8),
            ..self
        }
    }

    /// How long the longest place has to do if stages take so long: no frame can take less in a steady stream, and none takes more if
    /// each place has a processor to itself, all frames are alike, and handing them on costs nothing.
    pub fn longest_place(&self, stages: [f64; 4]) -> f64 {
        let mut of_places = [0.0; 4];
        for (place, time) in self.numbered().into_iter().zip(stages) {
            of_places[place] += time;
        }
        of_places.into_iter().fold(0.0, f64::max)
    }

    /// The place of each stage, from 0 without gaps, the last one that of the final draw.
    pub(super) fn numbered(&self) -> [usize; 4] {
        let last = self.places[3];
        let mut known = Vec::with_capacity(4);
        for place in self.places {
            if place != last && !known.contains(&place) {
                known.push(place);
            }
        }
        known.push(last);
        self.places
            .map(|place| known.iter().position(|&p| p == place).unwrap_or_default())
    }

    /// How many frames may be under way.
    pub(super) fn in_flight(&self) -> usize {
        usize::from(self.frames_in_flight.max(1))
    }

    /// How many frames back a frame knows.
    pub(super) fn back(&self) -> usize {
        usize::from(self.frames_back.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_threads_put_the_first_places_together() {
        let places = |schedule: Schedule, threads| schedule.on_threads(threads).numbered();
        let three = Schedule::THREE_STAGE;
        assert_eq!(places(three, 8), three.numbered());
        assert_eq!(places(three, 2), [0, 1, 0, 1]);
        assert_eq!(places(Schedule::THREE_PROCESSES, 2), [0, 0, 0, 1]);
        for (name, schedule) in Schedule::NAMED {
            assert_eq!(places(schedule, 1), [0; 4], "{name}");
            assert_eq!(places(schedule, 0), [0; 4], "{name}");
            for threads in 1..5 {
                let fewer = schedule.on_threads(threads);
                assert_eq!(fewer.threads(), schedule.threads().min(threads), "{name}");
                assert_eq!(fewer.frames_back, schedule.frames_back, "{name}");
            }
        }
    }

    #[test]
    fn the_longest_place_is_the_sum_of_its_stages() {
        let of = |schedule: Schedule| schedule.longest_place([1.0, 20.0, 30.0, 15.0]);
        assert_eq!(of(Schedule::SEQUENTIAL), 66.0);
        assert_eq!(of(Schedule::TWO_STAGE), 51.0);
        assert_eq!(of(Schedule::THREE_STAGE), 35.0);
        assert_eq!(of(Schedule::THREE_PROCESSES), 30.0);
    }

    #[test]
    fn the_final_draw_stands_at_the_last_place_whatever_its_number() {
        let schedule = Schedule {
            places: [7, 2, 7, 1],
            ..Schedule::SEQUENTIAL
        };
        assert_eq!(schedule.numbered(), [0, 1, 0, 2]);
        assert_eq!(schedule.threads(), 3);
    }
}
