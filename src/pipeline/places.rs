//! The places of a pipeline: threads that hand frames on to each other.
//!
//! Each place has an inbox, a bounded channel, and takes the earliest stage of what lies there. A frame is one piece of memory that
//! goes from place to place and comes back to the calling thread after its final draw; what is remembered goes round from the cull
//! to the select. So nothing large is allocated once all frames are under way, and nobody ever waits to hand something on: an inbox
//! has room for all that there is.
//!
//! **Invariant.** Every stage sees frames in their order, since it stands at one place, and what goes from one stage to the next goes
//! through one channel. A place that ends, however it ends, tells all others to end: nobody waits for a thread that has gone.

use std::collections::VecDeque;
use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, scope};
use std::time::Instant;

use super::{PipelineError, Schedule, Stage};

/// A frame under way.
#[derive(Debug)]
pub struct UnderWay<F, M> {
    /// The frame.
    pub frame: F,
    /// Its number, from 0 on.
    pub number: u64,
    /// When its camera was taken.
    pub camera_in: Instant,
    /// What it remembers, from its select to its cull.
    memory: Option<M>,
}

#[derive(Debug)]
enum Message<F, M> {
    /// A frame, for its next stage.
    Frame(Stage, Box<UnderWay<F, M>>),
    /// What the frame to select next remembers, or one after it.
    Memory(M),
    /// All is over.
    End,
}

/// The inboxes of all places, and whose they are.
#[derive(Debug)]
struct Inboxes<F, M> {
    of_places: Vec<SyncSender<Message<F, M>>>,
    place_of: [usize; 4],
}

impl<F, M> Inboxes<F, M> {
    /// Nobody waits here, and what a place that has ended does not take is lost.
    fn send(&self, stage: Stage, message: Message<F, M>) {
        let _ = self.of_places[self.place_of[stage as usize]].try_send(message);
    }
}

/// Tells all places to end when its own does.
struct EndOnDrop<'a, F, M>(&'a Inboxes<F, M>);

impl<F, M> Drop for EndOnDrop<'_, F, M> {
    fn drop(&mut self) {
        for inbox in &self.0.of_places {
            let _ = inbox.try_send(Message::End);
        }
    }
}

/// A thread's share of the stages.
struct Place<'a, F, M> {
    inbox: Receiver<Message<F, M>>,
    inboxes: EndOnDrop<'a, F, M>,
    /// What waits for each stage, in the order of frames.
    waiting: [VecDeque<Box<UnderWay<F, M>>>; 4],
    memories: VecDeque<M>,
    has_ended: bool,
}

impl<'a, F, M> Place<'a, F, M> {
    fn new(
        inbox: Receiver<Message<F, M>>,
        inboxes: &'a Inboxes<F, M>,
        schedule: &Schedule,
    ) -> Self {
        let (frames, memories) = (schedule.in_flight(), schedule.back());
        Place {
            inbox,
            inboxes: EndOnDrop(inboxes),
            waiting: [(); 4].map(|()| VecDeque::with_capacity(frames)),
            memories: VecDeque::with_capacity(memories),
            has_ended: false,
        }
    }

    fn send(&self, stage: Stage, message: Message<F, M>) {
        self.inboxes.0.send(stage, message);
    }

    fn take(&mut self, message: Message<F, M>) {
        match message {
            Message::Frame(stage, frame) => self.waiting[stage as usize].push_back(frame),
            Message::Memory(memory) => self.memories.push_back(memory),
            Message::End => self.has_ended = true,
        }
    }

    /// Waits for something to do. None when all is over.
    fn next(&mut self) -> Option<(Stage, Box<UnderWay<F, M>>)> {
        loop {
            while let Ok(message) = self.inbox.try_recv() {
                self.take(message);
            }
            if self.has_ended {
                return None;
            }
            if let Some(next) = self.first_ready() {
                return Some(next);
            }
            let message = self.inbox.recv().ok()?;
            self.take(message);
        }
    }

    fn first_ready(&mut self) -> Option<(Stage, Box<UnderWay<F, M>>)> {
        Stage::ALL.into_iter().find_map(|stage| {
            let waiting = &mut self.waiting[stage as usize];
            if stage == Stage::Select && !waiting.is_empty() {
                let memory = self.memories.pop_front()?;
                waiting[0].memory = Some(memory);
            }
            Some((stage, waiting.pop_front()?))
        })
    }

    /// Does a stage that is not the final draw, and hands on what comes of it.
    fn work(
        &self,
        stage: Stage,
        mut under_way: Box<UnderWay<F, M>>,
        work: impl Fn(Stage, &mut F, &mut M),
    ) {
        if let Some(memory) = &mut under_way.memory {
            work(stage, &mut under_way.frame, memory);
        }
        if stage == Stage::Cull
            && let Some(memory) = under_way.memory.take()
        {
            self.send(Stage::Select, Message::Memory(memory));
        }
        if let Some(next) = stage.next() {
            self.send(next, Message::Frame(next, under_way));
        }
    }
}

/// Runs frames through all stages. `enter` makes `frames` ready to begin, as many as it has for them; `work` does the first three
/// stages, and `final_draw` the last. The frames come back if all goes well; what is missing of them is lost.
///
/// # Errors
/// If there are no threads, or the final draw fails.
///
/// # Panics
/// If a stage panics: with what it panicked with.
pub fn run<F: Send, M: Send + Default, E>(
    schedule: &Schedule,
    frames: &mut Vec<F>,
    mut enter: impl FnMut(&mut F) -> bool,
    work: impl Fn(Stage, &mut F, &mut M) + Sync,
    mut final_draw: impl FnMut(&mut UnderWay<F, M>) -> Result<(), E>,
) -> Result<(), PipelineError<E>> {
    let threads = schedule.threads();
    let most = schedule.in_flight() + schedule.back() + threads;
    let channels = (1..threads).map(|_| sync_channel(most));
    let (mut of_places, inboxes_of_others): (Vec<_>, Vec<_>) = channels.unzip();
    // The calling thread's place is the last one.
    let (own_sender, own_inbox) = sync_channel(most);
    of_places.push(own_sender);
    let inboxes = Inboxes {
        of_places,
        place_of: schedule.numbered(),
    };
    for _ in 0..schedule.back() {
        inboxes.send(Stage::Select, Message::Memory(M::default()));
    }
    let mut free: Vec<Box<UnderWay<F, M>>> = frames
        .drain(..)
        .map(|frame| {
            Box::new(UnderWay {
                frame,
                number: 0,
                camera_in: Instant::now(),
                memory: None,
            })
        })
        .collect();
    let all = free.len();

    let result = scope(|scope| {
        let mut own = Place::new(own_inbox, &inboxes, schedule);
        let mut others = Vec::with_capacity(threads - 1);
        for (number, inbox) in inboxes_of_others.into_iter().enumerate() {
            let mut place = Place::new(inbox, &inboxes, schedule);
            let work = &work;
            let thread = Builder::new().name(format!("pipeline place {number}"));
            let thread = thread.spawn_scoped(scope, move || {
                while let Some((stage, under_way)) = place.next() {
                    place.work(stage, under_way, work);
                }
            });
            // Those that have begun end with the calling thread's place.
            others.push(thread.map_err(PipelineError::NoThreads)?);
        }
        let mut entered = 0;
        let mut is_over = false;
        let done = loop {
            while !is_over && let Some(mut under_way) = free.pop() {
                is_over = !enter(&mut under_way.frame);
                if is_over {
                    free.push(under_way);
                } else {
                    under_way.number = entered;
                    under_way.camera_in = Instant::now();
                    entered += 1;
                    own.send(Stage::Select, Message::Frame(Stage::Select, under_way));
                }
            }
            if free.len() == all {
                break Ok(());
            }
            match own.next() {
                // Another place has ended: joining it tells why.
                None => break Ok(()),
                Some((Stage::FinalDraw, mut under_way)) => {
                    if let Err(error) = final_draw(&mut under_way) {
                        break Err(PipelineError::FinalDraw(error));
                    }
                    free.push(under_way);
                }
                Some((stage, under_way)) => own.work(stage, under_way, &work),
            }
        };
        drop(own);
        for thread in others {
            if let Err(panic) = thread.join() {
                resume_unwind(panic);
            }
        }
        done
    });
    frames.extend(free.into_iter().map(|under_way| under_way.frame));
    result
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::{RecvTimeoutError, channel};
    use std::time::Duration;

    use super::*;

    /// A frame that keeps what was done to it.
    #[derive(Debug, Default)]
    struct Log {
        number: u64,
        stages: Vec<Stage>,
        told_by: Option<u64>,
    }

    /// All that overlap differently, and on fewer threads.
    fn schedules() -> Vec<Schedule> {
        let mut all: Vec<Schedule> = Schedule::NAMED.map(|(_, schedule)| schedule).into();
        all.push(Schedule {
            places: [0, 1, 2, 3],
            frames_in_flight: 5,
            frames_back: 2,
        });
        all.push(Schedule {
            places: [1, 0, 1, 0],
            frames_in_flight: 0,
            frames_back: 0,
        });
        all.push(Schedule {
            places: [0, 1, 2, 3],
            frames_in_flight: 1,
            frames_back: 4,
        });
        all.into_iter()
            .flat_map(|schedule| (1..5).map(move |threads| schedule.on_threads(threads)))
            .collect()
    }

    /// Runs so many frames; `stage` is called in each with the frame's number, `last` with what became of it.
    fn run_logs(
        schedule: &Schedule,
        count: u64,
        stage: impl Fn(Stage, u64) + Sync,
        mut last: impl FnMut(&Log) -> Result<(), &'static str>,
    ) -> Result<(), PipelineError<&'static str>> {
        let mut frames: Vec<Log> = (0..schedule.in_flight()).map(|_| Log::default()).collect();
        let mut entered = 0;
        let enter = |log: &mut Log| {
            *log = Log {
                number: entered,
                ..Log::default()
            };
            entered += 1;
            entered <= count
        };
        let work = |at, log: &mut Log, memory: &mut Option<u64>| {
            stage(at, log.number);
            log.stages.push(at);
            match at {
                Stage::Select => log.told_by = *memory,
                Stage::Cull => *memory = Some(log.number),
                _ => {}
            }
        };
        let done = run(schedule, &mut frames, enter, work, |under_way| {
            assert_eq!(under_way.number, under_way.frame.number);
            stage(Stage::FinalDraw, under_way.number);
            last(&under_way.frame)
        });
        if done.is_ok() {
            assert_eq!(frames.len(), schedule.in_flight(), "frames come back");
        }
        done
    }

    /// Fails if something takes so long that it must have come to a stop.
    fn ends<R: Send + 'static>(what: impl FnOnce() -> R + Send + 'static) -> R {
        let (sender, receiver) = channel();
        let thread = std::thread::spawn(move || {
            let _ = sender.send(what());
        });
        match receiver.recv_timeout(Duration::from_secs(60)) {
            Ok(result) => result,
            Err(RecvTimeoutError::Timeout) => panic!("it does not end"),
            Err(RecvTimeoutError::Disconnected) => resume_unwind(thread.join().unwrap_err()),
        }
    }

    #[test]
    fn frames_pass_all_stages_in_order_and_know_the_frame_so_many_before() {
        ends(|| {
            for schedule in schedules() {
                let mut next = 0;
                let done = run_logs(
                    &schedule,
                    50,
                    |_, _| {},
                    |log| {
                        assert_eq!(log.number, next, "{schedule:?}");
                        assert_eq!(log.stages, Stage::ALL[..3], "{schedule:?}");
                        let told_by = next.checked_sub(schedule.back() as u64);
                        assert_eq!(log.told_by, told_by, "{schedule:?}");
                        next += 1;
                        Ok(())
                    },
                );
                assert!(done.is_ok());
                assert_eq!(next, 50, "{schedule:?}");
            }
        });
    }

    #[test]
    fn no_more_frames_are_under_way_than_the_schedule_says() {
        ends(|| {
            for schedule in schedules() {
                let (begun, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
                let count = |stage, _| match stage {
                    Stage::Select => {
                        let now = begun.fetch_add(1, Ordering::SeqCst) + 1;
                        most.fetch_max(now, Ordering::SeqCst);
                    }
                    Stage::FinalDraw => {
                        begun.fetch_sub(1, Ordering::SeqCst);
                    }
                    _ => {}
                };
                assert!(run_logs(&schedule, 50, count, |_| Ok(())).is_ok());
                assert!(most.into_inner() <= schedule.in_flight(), "{schedule:?}");
            }
        });
    }

    /// A stage of a frame waits for a stage of a later one: this would not end if they did not overlap.
    #[test]
    fn stages_of_consecutive_frames_overlap() {
        let overlaps = [
            (Schedule::TWO_STAGE, Stage::FinalDraw, Stage::Cull, 1),
            (Schedule::THREE_STAGE, Stage::FinalDraw, Stage::Select, 2),
            (Schedule::THREE_STAGE, Stage::Cull, Stage::Select, 2),
            (Schedule::THREE_STAGE, Stage::Cull, Stage::DrawOccluders, 1),
            (Schedule::THREE_PROCESSES, Stage::FinalDraw, Stage::Cull, 1),
            (
                Schedule::THREE_PROCESSES,
                Stage::FinalDraw,
                Stage::DrawOccluders,
                2,
            ),
            (
                Schedule::THREE_PROCESSES,
                Stage::Cull,
                Stage::DrawOccluders,
                1,
            ),
        ];
        for (schedule, waits, awaited, ahead) in overlaps {
            ends(move || {
                let (sender, receiver) = sync_channel(100);
                let receiver = Mutex::new(receiver);
                let stage = |stage, number| {
                    if stage == awaited {
                        sender.send(number).expect("room for all");
                    } else if stage == waits && number + ahead < 20 {
                        let done = receiver.lock().expect("one thread");
                        while done.recv().expect("a number") < number + ahead {}
                    }
                };
                assert!(run_logs(&schedule, 20, stage, |_| Ok(())).is_ok());
            });
        }
    }

    #[test]
    fn a_panic_in_any_stage_is_passed_on_and_all_places_end() {
        for at in Stage::ALL {
            let caught = ends(move || {
                schedules().into_iter().all(|schedule| {
                    let panics = |stage, number| {
                        if stage == at && number == 7 {
                            // Without the message of the panic hook on stderr.
                            resume_unwind(Box::new("on purpose"));
                        }
                    };
                    let run = || run_logs(&schedule, 50, panics, |_| Ok(()));
                    let panic = catch_unwind(AssertUnwindSafe(run)).expect_err("a panic");
                    panic.downcast_ref::<&str>() == Some(&"on purpose")
                })
            });
            assert!(caught, "{at:?}");
        }
    }

    #[test]
    fn an_error_in_the_final_draw_is_passed_on_and_all_places_end() {
        ends(|| {
            for schedule in schedules() {
                let mut drawn = 0;
                let done = run_logs(
                    &schedule,
                    u64::MAX,
                    |_, _| {},
                    |_| {
                        drawn += 1;
                        if drawn == 9 { Err("enough") } else { Ok(()) }
                    },
                );
                assert!(matches!(done, Err(PipelineError::FinalDraw("enough"))));
                assert_eq!(drawn, 9);
            }
        });
    }

    #[test]
    fn no_frames_are_no_work() {
        ends(|| {
            for schedule in schedules() {
                let none = |stage, _| panic!("{stage:?} of no frame");
                assert!(run_logs(&schedule, 0, none, |_| Ok(())).is_ok());
            }
        });
    }
}
