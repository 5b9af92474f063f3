//! Pictures that stay as they are, to the byte; and the same scenes with and without culling, on any number of threads.
//!
//! A test that fails leaves the kept picture, the drawn one, and where they differ under the target folder, and names
//! them. `ANTUMBRA_BLESS=1 cargo test --release --test golden` keeps what is drawn now in `tests/golden/`.

#[path = "golden/compare.rs"]
mod compare;
#[path = "golden/courtyard.rs"]
mod courtyard;
#[path = "golden/stage.rs"]
mod stage;

use antumbra_fixtures::Kind;
use compare::assert_golden;
use stage::Stage;

#[test]
fn a_street_of_the_city() {
    let shot = city().shoot(60);
    assert_golden("city", &shot.picture);
    assert_golden("city_occluders", &shot.occluders);
}

#[test]
fn the_machine_room() {
    let shot = machine_room().shoot(36);
    assert_golden("machine_room", &shot.picture);
    assert_golden("machine_room_occluders", &shot.occluders);
}

#[test]
fn the_power_plant() {
    let shot = power_plant().shoot(36);
    assert_golden("power_plant", &shot.picture);
    assert_golden("power_plant_occluders", &shot.occluders);
}

#[test]
fn the_teapots() {
    let shot = teapots().shoot(150);
    assert_golden("teapots", &shot.picture);
    assert_golden("teapots_occluders", &shot.occluders);
}

#[test]
fn a_courtyard_in_parallel_projection() {
    let shot = courtyard::in_parallel().shoot(0);
    assert_golden("courtyard_parallel", &shot.picture);
    assert_golden("courtyard_parallel_occluders", &shot.occluders);
}

#[test]
fn a_courtyard_in_perspective() {
    let shot = courtyard::in_perspective().shoot(0);
    assert_golden("courtyard", &shot.picture);
    assert_golden("courtyard_occluders", &shot.occluders);
}

#[test]
fn what_culling_did() {
    let sheet = courtyard::in_perspective().overlay(0, "courtyard, frame 0");
    assert_golden("courtyard_overlay", &sheet);
}

#[test]
fn culling_changes_no_byte_and_threads_change_nothing() {
    let stages = [
        city(),
        machine_room(),
        power_plant(),
        teapots(),
        courtyard::in_parallel(),
        courtyard::in_perspective(),
    ];
    for stage in stages {
        let step = stage.cameras.len().div_ceil(5);
        let frames: Vec<usize> = (0..stage.cameras.len()).step_by(step).collect();
        let shots = stage.shoot_all(1, &frames);
        let mut culled = 0;
        for (&frame, shot) in frames.iter().zip(&shots) {
            let whole = stage.picture_without_culling(frame);
            assert!(
                shot.picture == whole,
                "{}: culling changes frame {frame}",
                stage.name
            );
            let [in_frustum, visible] = &shot.objects;
            culled += in_frustum.len() - visible.len();
        }
        assert!(culled > 0, "{}: nothing was culled", stage.name);
        for threads in [2, 3, 5] {
            let again = stage.shoot_all(threads, &frames);
            for ((frame, a), b) in frames.iter().zip(&shots).zip(&again) {
                assert!(
                    a == b,
                    "{}: {threads} threads change frame {frame}",
                    stage.name
                );
            }
        }
    }
}

fn city() -> Stage {
    Stage::generated(Kind::City, 20_000)
}

fn machine_room() -> Stage {
    Stage::generated(Kind::MachineRoom, 40_000)
}

fn power_plant() -> Stage {
    Stage::generated(Kind::PowerPlant, 60_000)
}

fn teapots() -> Stage {
    Stage::generated(Kind::Teapots, 300_000)
}
