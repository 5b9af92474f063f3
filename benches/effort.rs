//! What a frame costs where there is little to do: the three worst cases, each with what it may cost at the most.
//!
//! `cargo bench --bench effort`. Each figure is the least of many repeats, frame by frame, and their sums are compared; no criterion,
//! for what counts is a ratio of two things that are done in turns.
//!
//! - *sparse*: the open field. A frame against frustum culling alone: at most 5 % more.
//! - *still*: a camera that stands still. A frame like the last one against a whole one: at most 1 %.
//! - *door*: a camera that stands still while one object turns. What that costs against a whole frame, and the share of the
//!   picture that it touches.

mod common;

use std::time::{Duration, Instant};

use antumbra::cull::{Culler, Effort, Settings, Skip, VisibleSet};
use antumbra::glam::{DAffine3, DVec3};
use antumbra::occlusion::{Footprint, Screen};
use antumbra::scene::Move;
use antumbra_fixtures::Kind;
use common::{Stage, settings};

/// Each frame is repeated so often.
const REPEATS: usize = 200;

fn main() {
    let stages = || {
        let real = ["castle", "clinic"].map(|name| (name, Stage::real(name, 6)));
        let real = real
            .into_iter()
            .filter_map(|(name, stage)| Some((name, stage?)));
        real.chain([("city", Stage::generated(Kind::City, None))])
    };
    println!("case    scene   |  least us of | against us |   ratio | at most");
    sparse(&Stage::generated(Kind::Sparse, None));
    for (name, stage) in stages() {
        still(name, &stage);
    }
    for (name, stage) in stages() {
        door(name, &stage);
    }
}

fn culler(stage: &Stage, effort: Effort) -> Culler {
    let settings = Settings {
        effort,
        ..settings()
    };
    Culler::new(stage.scene.clone(), settings).expect("threads")
}

/// The least times of two things that are done in turns.
fn least<T>(state: &mut T, one: impl Fn(&mut T), other: impl Fn(&mut T)) -> [Duration; 2] {
    let timed = |state: &mut T, what: &dyn Fn(&mut T)| {
        let start = Instant::now();
        what(state);
        start.elapsed()
    };
    (0..REPEATS).fold([Duration::MAX; 2], |[a, b], _| {
        [a.min(timed(state, &one)), b.min(timed(state, &other))]
    })
}

fn say(case: &str, scene: &str, [of, against]: [Duration; 2], at_most: Option<f64>) {
    let us = |d: Duration| d.as_nanos() as f64 / 1000.0;
    let ratio = us(of) / us(against);
    let judged = at_most.map_or(String::new(), |most| {
        let word = if ratio <= most { "ok" } else { "MISSED" };
        format!("{most:.2} {word}")
    });
    println!(
        "{case:7} {scene:7} | {:12.2} | {:10.2} | {ratio:7.4} | {judged}",
        us(of),
        us(against)
    );
}

fn sum(times: impl Iterator<Item = [Duration; 2]>) -> [Duration; 2] {
    times.fold([Duration::ZERO; 2], |[a, b], [c, d]| [a + c, b + d])
}

/// The open field, frame by frame, against frustum culling alone. Objects of the frustum are the answer of both.
fn sparse(stage: &Stage) {
    let effort = Effort {
        reuse: false,
        ..Effort::default()
    };
    let mut state = (culler(stage, effort), VisibleSet::default(), Vec::new());
    let times = stage.cameras.iter().map(|camera| {
        state.0.forget();
        let times = least(
            &mut state,
            |(culler, found, _)| culler.cull_into(camera, found),
            |(culler, _, found)| culler.in_frustum_into(camera, found),
        );
        assert!(state.1.statistics.skipped.has(Skip::OcclusionLittleCovers));
        assert_eq!(state.1.visible, state.2);
        times
    });
    say("sparse", "sparse", sum(times), Some(1.05));
}

/// A frame like the last one, against one that is found anew with what is remembered.
fn still(name: &str, stage: &Stage) {
    let mut state = [Effort::default(), Effort::FULL].map(|effort| {
        let culler = culler(stage, effort);
        (culler, VisibleSet::default())
    });
    let times = stage.cameras.iter().map(|camera| {
        let cull = |(culler, found): &mut (Culler, VisibleSet)| culler.cull_into(camera, found);
        state.iter_mut().for_each(cull);
        let times = least(&mut state, |[still, _]| cull(still), |[_, full]| cull(full));
        assert!(state[0].1.statistics.skipped.has(Skip::Everything));
        times
    });
    say("still", name, sum(times), Some(0.01));
}

/// One object turns there and back while the camera stands still.
fn door(name: &str, stage: &Stage) {
    let mut state = [Effort::default(), Effort::FULL].map(|effort| {
        let culler = culler(stage, effort);
        (culler, VisibleSet::default())
    });
    let (mut doors, mut touched) = (0, 0.0);
    let mut all = [Duration::ZERO; 2];
    for camera in &stage.cameras {
        let cull = |(culler, found): &mut (Culler, VisibleSet)| culler.cull_into(camera, found);
        state.iter_mut().for_each(cull);
        let screen = Screen::new(*camera, settings().size);
        let share_of =
            |object: u32| match screen.footprint_of_aabb(&stage.scene.bounds()[object as usize]) {
                Footprint::Within(rect) => {
                    let samples = |[first, last]: [i32; 2]| f64::from(last - first + 1);
                    let all = settings().size.width() * settings().size.height();
                    samples(rect.x) * samples(rect.y) / all as f64
                }
                _ => 0.0,
            };
        // Of what is seen, what is about as large as a door across a room.
        let seen = state[0].1.visible.clone();
        let Some(&object) = seen
            .iter()
            .find(|&&object| (0.005..0.05).contains(&share_of(object)))
        else {
            continue;
        };
        let at_rest = stage.scene.objects()[object as usize].world_from_local;
        let bounds = stage.scene.bounds()[object as usize];
        let turned = about(bounds.min, 0.3) * at_rest;
        let turn = |culler: &mut Culler| {
            let here = culler.scene().objects()[object as usize].world_from_local;
            let there = if here == at_rest { turned } else { at_rest };
            let moves = [Move {
                object,
                world_from_local: there,
                swept: false,
            }];
            culler.move_objects(&moves).expect("it stays in the world");
        };
        let [part, whole] = least(
            &mut state,
            |[part, _]| {
                turn(&mut part.0);
                cull(part);
            },
            |[_, whole]| {
                turn(&mut whole.0);
                cull(whole);
            },
        );
        if state[0].1.statistics.skipped.has(Skip::Elsewhere) {
            doors += 1;
            touched += share_of(object);
            all = sum([all, [part, whole]].into_iter());
        }
        for (culler, _) in &mut state {
            let back = [Move {
                object,
                world_from_local: at_rest,
                swept: false,
            }];
            culler.move_objects(&back).expect("it stays in the world");
        }
    }
    say("door", name, all, None);
    println!(
        "                | {doors} objects, which touch {:.2} % of the picture on average",
        touched / f64::from(doors.max(1)) * 100.0
    );
}

/// A turn about an upright line.
fn about(pivot: DVec3, angle: f64) -> DAffine3 {
    DAffine3::from_translation(pivot)
        * DAffine3::from_rotation_y(angle)
        * DAffine3::from_translation(-pivot)
}
