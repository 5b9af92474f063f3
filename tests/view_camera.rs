//! Cameras from points, from a direction and from axes are the same cameras; what is no camera is an error.

mod oracle;

use antumbra::glam::DVec3;
use antumbra::view::{Camera, Projection, ViewError};
use oracle::Chance;

const PERSPECTIVE: Projection = Projection::Perspective {
    fov_y: 1.0,
    near: 0.1,
    far: None,
};

fn axes(camera: &Camera) -> [DVec3; 3] {
    [camera.right(), camera.up(), camera.forward()]
}

#[test]
fn the_axes_of_a_camera_make_it_again() {
    let mut chance = Chance(7);
    for step in 0..2000 {
        let mut number = || f64::from(chance.whole(-1_000_000, 1_000_000)) * 1e-6;
        let mut vector = || DVec3::from_array([(); 3].map(|()| number()));
        let (eye, up, aim) = (vector() * 1e6, vector(), vector() * 10.0);
        // Also nearly along the view, where the axes are least exact.
        let up = if step % 4 == 0 {
            aim * 0.1 + up * 1e-7
        } else {
            up
        };
        let Ok(camera) = Camera::look_at(eye, eye + aim, up, PERSPECTIVE) else {
            continue;
        };
        assert_eq!(
            Camera::from_axes(eye, axes(&camera), PERSPECTIVE),
            Ok(camera)
        );
    }
}

#[test]
fn looking_along_is_looking_at_what_is_there() {
    let eye = DVec3::new(3.0, -2.0, 8.0);
    let forward = DVec3::new(-0.5, 4.0, 0.25);
    let along = Camera::look_along(eye, forward, DVec3::Z, PERSPECTIVE);
    assert_eq!(
        along,
        Camera::look_at(eye, eye + forward, DVec3::Z, PERSPECTIVE)
    );
    assert!(along.is_ok());
}

#[test]
fn what_is_no_camera_is_an_error() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let from = |axes| Camera::from_axes(DVec3::ZERO, axes, PERSPECTIVE);
    assert!(from([x, y, -z]).is_ok());
    let bad_axes = [
        [x, y, z],
        [x, y, -z * 1.001],
        [x * 0.999, y, -z],
        [x, y * 1e-12, -z],
        [DVec3::ZERO; 3],
        [x, y, (x * 1e-3 - z).normalize()],
    ];
    for axes in bad_axes {
        let error = from(axes);
        assert!(
            matches!(error, Err(ViewError::NoOrientation { .. })),
            "{axes:?}: {error:?}"
        );
    }
    for bad in [DVec3::NAN, DVec3::INFINITY, DVec3::splat(1e200)] {
        for camera in [
            Camera::from_axes(bad, [x, y, -z], PERSPECTIVE),
            Camera::from_axes(DVec3::ZERO, [x, bad, -z], PERSPECTIVE),
            Camera::look_along(DVec3::ZERO, bad, y, PERSPECTIVE),
            Camera::look_at(DVec3::ZERO, x, bad, PERSPECTIVE),
        ] {
            assert!(
                matches!(camera, Err(ViewError::NotFinite { .. })),
                "{bad}: {camera:?}"
            );
        }
    }
    for (forward, up) in [(DVec3::ZERO, y), (x, DVec3::ZERO), (x, x), (x, -x * 7.0)] {
        let error = Camera::look_along(DVec3::ONE, forward, up, PERSPECTIVE);
        assert!(
            matches!(error, Err(ViewError::NoOrientation { .. })),
            "{forward} {up}: {error:?}"
        );
    }
}
