//! A cone that holds the normals of a cluster, and tells when all of it looks away from the eye, or towards it.
//!
//! ```text
//!              axis            A triangle with unit normal n and a corner p looks away from the eye e if
//!            \   ↑   /         n·(e − p) < 0. Let every n be within θ of the axis, and let the `back` point
//!       front \  |  /          lie behind every triangle's plane: n·(back − p) ≤ 0. Then e looks at the back
//!              · | ·           of all of them if e − back is within 90° − θ of −axis, for then
//!   ~~~ cluster ~|~~~          n·(e − p) = n·(e − back) + n·(back − p) < 0. Likewise in front.
//!              · | ·
//!        back /  |  \          This is the cone of meshoptimizer's `meshopt_computeClusterBounds`, with an apex for
//!                              each side.
//! ```
//!
//! **Invariant.** What the cone says holds for the exact triangles. A normal in f64 errs by an angle of at most
//! 2⁻⁴⁸ ∕ sin α, α being the angle between the edges it is made of (three roundings of each term, Higham, *Accuracy and
//! Stability of Numerical Algorithms*, §3.1); θ and the two points give way by that much, and the question by 2⁻⁴⁰ of
//! the coordinates in it. Triangles thinner than 2⁻⁴⁰ of their length are lines, which look neither way.

use glam::DVec3;

use super::local_box::LocalBox;

/// The error of a normal's angle, times the sine of the angle it was found at.
const NORMAL_ERROR: f64 = 1.0 / (1u64 << 48) as f64;

/// Less than this sine of a triangle's angle, and it is a line.
const LINE: f64 = 1.0 / (1u64 << 40) as f64;

/// What rounding in a question may add up to, relative to the coordinates; the eye's own transform included.
const QUESTION_ERROR: f64 = 1.0 / (1u64 << 40) as f64;

/// The least cosine of θ: wider cones say nothing from any useful distance.
const LEAST_COSINE: f64 = 0.02;

/// How far the square of an axis' length may be from 1: three coordinates, each rounded to an f32, by 2⁻²⁴ of itself.
const UNIT_ERROR: f64 = 1.0 / (1u32 << 22) as f64;

/// Rounds of finding the axis: half of what could be gained is gained by the fourth.
const ROUNDS: usize = 16;

/// Holds the normals of a cluster's triangles; in the mesh's local coordinates.
///
/// The fronts are the sides that wind counter-clockwise in the mesh. A placement that mirrors turns the winding on
/// screen, and the drawing turns with it: what is drawn is still what faces the eye *in local coordinates*, so the
/// question is the same. Only who draws the clockwise sides (culls front faces of an unmirrored placement) asks
/// [`NormalCone::is_front_facing`] instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalCone {
    /// A unit vector, to f32's precision.
    axis: [f32; 3],
    /// Where distances along the axis are measured from.
    middle: [f32; 3],
    /// The sine of θ, rounded up.
    sine: f32,
    /// How far behind `middle` the point is that lies behind every plane, times the axis. May be negative.
    back: f32,
    /// How far before `middle` the point is that lies before every plane.
    front: f32,
}

/// A triangle's plane: a unit normal, how far its direction may be off, and a point.
#[derive(Clone, Copy)]
struct Plane {
    normal: DVec3,
    error: f64,
    point: [f32; 3],
}

impl Plane {
    fn new(corners: [[f32; 3]; 3]) -> Option<Plane> {
        let [a, b, c] = corners.map(wide);
        let (u, v) = (b - a, c - a);
        let across = u.cross(v);
        let (length, largest) = (across.length(), u.length() * v.length());
        // Also false for two corners in one place.
        (length > LINE * largest).then(|| Plane {
            normal: across / length,
            error: NORMAL_ERROR * largest / length,
            point: corners[0],
        })
    }
}

impl NormalCone {
    /// The cone of some triangles, counter-clockwise seen from the front. None if their normals are spread over nearly
    /// a half-space or more, or if no triangle has an area.
    pub fn around(triangles: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Option<NormalCone> {
        let planes: Vec<Plane> = triangles.into_iter().filter_map(Plane::new).collect();
        let axis = narrow(axis_of(&planes)?);
        NormalCone::of(&planes, axis)
    }

    /// The cone of some triangles around an axis that [`NormalCone::around`] once found for them, or any other: what the
    /// cone says holds. None as there, or if the axis is no unit vector.
    pub(super) fn along(
        axis: [f32; 3],
        triangles: impl IntoIterator<Item = [[f32; 3]; 3]>,
    ) -> Option<NormalCone> {
        // Also false for what is not a number.
        let is_unit = (wide(axis).length_squared() - 1.0).abs() <= UNIT_ERROR;
        let planes: Vec<Plane> = triangles.into_iter().filter_map(Plane::new).collect();
        (is_unit && !planes.is_empty())
            .then(|| NormalCone::of(&planes, axis))
            .flatten()
    }

    /// The axis.
    pub(super) fn axis(&self) -> [f32; 3] {
        self.axis
    }

    fn of(planes: &[Plane], axis: [f32; 3]) -> Option<NormalCone> {
        let direction = wide(axis);
        let length = direction.length();

        let cosine = planes.iter().fold(1.0, |least, p| {
            let cosine = p.normal.dot(direction) / length - p.error;
            if cosine < least { cosine } else { least }
        });
        if cosine < LEAST_COSINE {
            return None;
        }
        let bounds = LocalBox::around(planes.iter().map(|p| p.point));
        let middle = std::array::from_fn(|a| bounds.min[a] * 0.5 + bounds.max[a] * 0.5);

        // n·(middle ∓ t·axis − p) ∓ is as it should be from t = ±n·(middle − p) / n·axis on.
        let (mut back, mut front) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for p in planes {
            let offset = wide(middle) - wide(p.point);
            let above = p.normal.dot(offset);
            let error = p.error * offset.length();
            let steepness = p.normal.dot(direction);
            let reach = |above: f64| {
                let above = above + 2.0 * error;
                above / (steepness - p.error.copysign(above))
            };
            back = larger(back, reach(above));
            front = larger(front, reach(-above));
        }
        let sine_squared = 1.0 - cosine * cosine;
        let sine = if sine_squared > 0.0 {
            sine_squared.sqrt()
        } else {
            0.0
        };
        Some(NormalCone {
            axis,
            middle,
            sine: above(sine + 1e-6),
            back: above(back),
            front: above(front),
        })
    }

    /// Whether every triangle looks away from an eye at this place, local coordinates: as a single-sided surface,
    /// none of the cluster is drawn in perspective. False if in doubt, or if the eye is not finite.
    pub fn is_back_facing(&self, eye_local: DVec3) -> bool {
        self.is_beyond(eye_local, -1.0, self.back)
    }

    /// Whether every triangle looks towards an eye at this place, local coordinates. False if in doubt, or if the eye
    /// is not finite.
    pub fn is_front_facing(&self, eye_local: DVec3) -> bool {
        self.is_beyond(eye_local, 1.0, self.front)
    }

    /// Whether every triangle looks away from an eye that is infinitely far: an orthographic camera that looks along
    /// `view_direction_local`, which is a camera's forward in local coordinates, of any length. False if in doubt.
    pub fn is_back_facing_along(&self, view_direction_local: DVec3) -> bool {
        self.is_within(view_direction_local)
    }

    /// Whether every triangle looks towards an orthographic camera that looks along `view_direction_local`. False if in
    /// doubt.
    pub fn is_front_facing_along(&self, view_direction_local: DVec3) -> bool {
        self.is_within(-view_direction_local)
    }

    /// Whether the eye is in the cone around the axis (`sign` 1) or against it (−1), from `reach` beyond the middle on.
    fn is_beyond(&self, eye: DVec3, sign: f64, reach: f32) -> bool {
        let (axis, middle, reach) = (wide(self.axis), wide(self.middle), f64::from(reach));
        let from_apex = (eye - middle) * sign - axis * reach;
        let largest = |v: DVec3| v.x.abs() + v.y.abs() + v.z.abs();
        let slack = QUESTION_ERROR * (largest(eye) + largest(middle) + reach.abs());
        from_apex.dot(axis) > f64::from(self.sine) * from_apex.length() + slack
    }

    /// Whether a direction is so close to the axis that it is less than 90° from every normal.
    fn is_within(&self, direction: DVec3) -> bool {
        direction.dot(wide(self.axis)) > f64::from(self.sine) * direction.length()
    }
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

fn narrow(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// Not `f64::max`, which of −0 and 0 may answer either.
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The least f32 that is not below a number by rounding, and a little more.
fn above(value: f64) -> f32 {
    let value = value + value.abs() * 1e-9;
    let nearest = value as f32;
    if f64::from(nearest) < value {
        nearest.next_up()
    } else {
        nearest
    }
}

/// The axis of the smallest cone around unit normals, nearly: the centre of the smallest ball around them, which
/// Bădoiu and Clarkson (*Smaller Core-Sets for Balls*, 2003) approach by stepping towards the farthest by less and less.
fn axis_of(planes: &[Plane]) -> Option<DVec3> {
    let unit = |v: DVec3| {
        let length = v.length();
        (length > 1e-3).then(|| v / length)
    };
    let least_cosine = |axis: DVec3| {
        planes
            .iter()
            .fold((f64::INFINITY, DVec3::ZERO), |least, p| {
                let cosine = p.normal.dot(axis);
                if cosine < least.0 {
                    (cosine, p.normal)
                } else {
                    least
                }
            })
    };
    let mean: DVec3 = planes.iter().map(|p| p.normal).sum::<DVec3>() / planes.len() as f64;
    let mut center = mean;
    let mut best = (f64::NEG_INFINITY, None);
    for round in 0..ROUNDS {
        let axis = unit(center)?;
        let (cosine, farthest) = least_cosine(axis);
        if cosine > best.0 {
            best = (cosine, Some(axis));
        }
        center += (farthest - center) / (round + 2) as f64;
    }
    best.1
}
