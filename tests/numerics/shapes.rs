//! Triangles that strain numbers: thin, long, huge, in one plane, and with vertices in the middle of others' edges.

use antumbra::glam::{DAffine3, DMat3, DVec3, Vec3Swizzles};
use antumbra::view::{Camera, Projection};

use crate::oracle::Chance;
use crate::scatter::*;
use crate::world::{Thing, World};
use crate::worlds::{self, Shape};

fn camera(chance: &mut Chance) -> Camera {
    let near = one_of(chance, &[0.01, 0.1, 1.0]);
    let projection = if chance.one_in(4) {
        let height = chance.real(1.0, 9.0);
        Projection::Orthographic {
            height,
            near,
            far: None,
        }
    } else {
        Projection::Perspective {
            fov_y: chance.real(0.3, 2.0),
            near,
            far: None,
        }
    };
    camera_at(chance, DVec3::ZERO, projection)
}

fn distance(chance: &mut Chance) -> f64 {
    chance.real(2.0, 12.0)
}

/// Triangles a few sub-pixels thin, or far less; needles that point at the eye; and triangles whose corners all but coincide.
pub fn slivers_and_needles(chance: &mut Chance) -> World {
    let camera = camera(chance);
    let size = small(chance);
    let mut things = scattered(chance, &camera, size, distance);
    for _ in 0..chance.whole(1, 5) {
        let mut points = Vec::new();
        for _ in 0..chance.whole(2, 12) {
            let (from, to) = (distance(chance), distance(chance));
            let (a, half) = in_view(chance, &camera, size, from);
            let (b, _) = in_view(chance, &camera, size, to);
            let sub_pixel = half / (size.height() as f64 * 128.0);
            let c = match chance.whole(0, 3) {
                // A sliver: the third corner off the line between the others.
                0 | 1 => {
                    let thin = sub_pixel * one_of(chance, &[1e-3, 0.5, 2.0, 20.0]);
                    a + (b - a) * chance.real(0.0, 1.0) + worlds::direction(chance) * thin
                }
                // A needle: almost the same place on screen, elsewhere in depth.
                2 => {
                    let far = a * chance.real(0.3, 30.0);
                    far + worlds::direction(chance) * sub_pixel * one_of(chance, &[0.1, 3.0, 99.0])
                }
                // A crumb.
                _ => a + worlds::direction(chance) * sub_pixel * chance.real(0.0, 9.0),
            };
            let b = if chance.one_in(4) {
                a + worlds::direction(chance) * sub_pixel * chance.real(0.0, 400.0)
            } else {
                b
            };
            points.extend([a, b, c]);
        }
        let triangles = (0..points.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        things.push(of_world(&points, triangles.collect(), !chance.one_in(3)));
    }
    World {
        camera,
        size,
        things,
    }
}

/// Triangles a million to a million million times as large as what is seen of them, before, through and behind the eye.
pub fn huge(chance: &mut Chance) -> World {
    let camera = camera(chance);
    let size = small(chance);
    let mut things = scattered(chance, &camera, size, distance);
    for _ in 0..chance.whole(1, 4) {
        let reach = power(chance, 1e3, 1e12);
        let through = match chance.whole(0, 2) {
            0 => in_view(chance, &camera, size, 5.0).0,
            1 => camera.up() * -1.0,
            _ => camera.forward() * distance(chance),
        };
        // In a plane through that point: upright, level, or any.
        let turned = if chance.one_in(2) {
            DMat3::from_cols(camera.right(), camera.up(), camera.forward())
        } else {
            worlds::rotation(chance)
        };
        let mut corner = || {
            let angle = chance.real(0.0, 6.3);
            let aside = turned.x_axis * angle.cos() + turned.y_axis * angle.sin();
            through + aside * (reach * chance.real(0.1, 1.0))
        };
        let points: Vec<DVec3> = (0..6).map(|_| corner()).collect();
        things.push(of_world(
            &points,
            vec![[0, 1, 2], [3, 4, 5]],
            !chance.one_in(4),
        ));
    }
    World {
        camera,
        size,
        things,
    }
}

/// Layers in one plane: the same triangles again, other triangles of the same plane, and some that are off by less than depths can
/// tell.
pub fn coplanar(chance: &mut Chance) -> World {
    let camera = camera(chance);
    let size = small(chance);
    let mut things = Vec::<Thing>::new();
    for _ in 0..chance.whole(1, 2) {
        let away = distance(chance);
        let (center, half) = in_view(chance, &camera, size, away);
        let axes = if chance.one_in(2) {
            DMat3::from_cols(camera.right(), camera.up(), -camera.forward())
        } else {
            worlds::rotation(chance)
        };
        let first = things.len();
        for layer in 0..chance.whole(2, 6) {
            let step = one_of(chance, &[0.0, 0.0, 1e-16, 1e-12, 1e-8, 1e-6]);
            let translation = center + camera.forward() * (step * f64::from(layer));
            let kind = one_of(chance, &[Shape::Wall(1), Shape::Wall(2), Shape::Wall(5)]);
            let wide = half * chance.real(0.2, 1.2);
            let mut thing = if layer > 0 && chance.one_in(3) {
                things[first].clone()
            } else {
                shaped(chance, kind, axes * wide, translation)
            };
            (thing.double_sided, thing.drawn) = (true, !chance.one_in(4));
            things.push(thing);
        }
    }
    let away = distance(chance) * 2.0;
    let (center, half) = in_view(chance, &camera, size, away);
    things.push(any_thing(chance, center, half * 0.1));
    World {
        camera,
        size,
        things,
    }
}

/// Walls square to the view, one before another by less than a step of f32, or by a few: depths that round to the same number, and
/// to numbers in the wrong order if they were rounded the wrong way.
pub fn close_layers(chance: &mut Chance) -> World {
    let near = one_of(chance, &[0.01, 0.1, 1.0]);
    let projection = if chance.one_in(3) {
        Projection::Orthographic {
            height: chance.real(1.0, 9.0),
            near,
            far: None,
        }
    } else {
        Projection::Perspective {
            fov_y: chance.real(0.3, 2.0),
            near,
            far: None,
        }
    };
    let look = one_of(chance, &[DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z]);
    let up = one_of(chance, &[look.yzx(), -look.zxy()]);
    let camera = Camera::look_at(DVec3::ZERO, look, up, projection).expect("a camera");
    let size = small(chance);
    let away = distance(chance);
    let half = in_view(chance, &camera, size, away).1;
    let mut layer = |away: f64, part: f64, drawn: bool| {
        let axes = DMat3::from_cols(
            camera.right() * (half * part * size.aspect()),
            camera.up() * (half * part),
            -camera.forward() * half,
        );
        let aside = camera.right() * (half * (1.0 - part).max(0.0) * chance.real(-1.0, 1.0));
        let mut thing = shaped(
            chance,
            Shape::Wall(1),
            axes,
            camera.forward() * away + aside,
        );
        (thing.double_sided, thing.drawn) = (true, drawn);
        thing
    };
    let mut things = vec![layer(away, 1.1, true)];
    for i in 0..6 {
        let steps = [0.1, 0.3, 0.6, -0.2, 1.5, -3.0][i];
        let nearer = 1.0 - steps * 2_f64.powi(-24);
        things.push(layer(away * nearer, 0.3, i == 0));
    }
    World {
        camera,
        size,
        things,
    }
}

/// A wall of strips, each cut into its own number of rows: where two strips meet, corners of one lie within edges of the other,
/// and cracks open that no one drew. What stands behind is seen through them, or it is not.
pub fn t_junctions(chance: &mut Chance) -> World {
    let camera = camera(chance);
    let size = small(chance);
    let away = chance.real(3.0, 6.0);
    let (center, half) = (
        camera.forward() * away,
        in_view(chance, &camera, size, away).1,
    );
    let tilt = camera.forward() * chance.real(-0.5, 0.5);
    let (across, down) = (
        (camera.right() + tilt) * (half * size.aspect() * 1.4),
        (camera.up() + tilt * 0.5) * (half * 1.4),
    );
    let turn = chance.real(-0.3, 0.3);
    let strips = chance.whole(2, 9);
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for strip in 0..strips {
        let rows = chance.whole(1, 40);
        let x = [strip, strip + 1].map(|i| f64::from(i) * 2.0 / f64::from(strips) - 1.0);
        let base = points.len() as u32;
        for row in 0..=rows {
            let y = f64::from(row) * 2.0 / f64::from(rows) - 1.0;
            points.extend(x.map(|x| center + across * (x - turn * y) + down * (y + turn * x)));
        }
        for row in 0..rows as u32 {
            let a = base + 2 * row;
            triangles.extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
        }
    }
    let mut things = vec![of_world(&points, triangles, true)];
    for _ in 0..chance.whole(2, 8) {
        let away = away * chance.real(2.0, 4.0);
        let (center, half) = in_view(chance, &camera, size, away);
        let radius = half * chance.real(0.01, 0.4);
        things.push(any_thing(chance, center, radius));
    }
    // Placed exactly, so that both strips of a pair keep their common corners.
    things[0].place = DAffine3::IDENTITY;
    World {
        camera,
        size,
        things,
    }
}
