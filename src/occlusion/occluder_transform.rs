//! Where occluders are drawn for a final pass that is not ours, and how much nearer everything else is asked: see
//! [`Slack`](crate::view::Slack).
//!
//! An occluder's vertices may be off by `e`, a share of the distance to its farthest corner: by that much in each of the rows that lead
//! to the screen. So occluders
//!
//! * stand back by `e`: moved along the view, nothing of them is nearer than the device may draw it;
//! * are cut off in front of a plane. With a row of length `r` that counts from the middle of the picture, half of which is `h`, a vertex
//!   at distance `w` may be drawn `e·(r + h)/w` from its place, and standing back moves it by `e·h/w` more. Where that is over three
//!   eighths of the slack's pixels, nothing is drawn. (A device's grid of sixteenths of a pixel, and samples half a pixel from the
//!   centre, leave more than that: 1/16 of 1/8, and 7/16 of 1.) Nor is it within `e` of the near plane, which a device cuts by its own
//!   roundings.

use antumbra_simd::SUBPIXELS;
use antumbra_simd::vertex::ScreenTransform;
use glam::{DAffine3, DVec3};

use super::Screen;
use crate::scene::Aabb;
use crate::view::{Projection, distance_of_farthest};

/// What of the slack's pixels transforms may be off.
const FOR_TRANSFORMS: f64 = 3.0 / 8.0;

impl Screen {
    /// The transform from local coordinates to the screen for an occluder within these bounds.
    pub(crate) fn screen_from_local(
        &self,
        world_from_local: &DAffine3,
        bounds: &Aabb,
    ) -> ScreenTransform {
        if self.slack.is_none() {
            return self.camera.placed(&self.from_eye, world_from_local);
        }
        let off = self.position_slack(bounds);
        let mut place = *world_from_local;
        place.translation += self.camera.forward() * off;
        let placed = self.camera.placed(&self.from_eye, &place);
        let moved = off * self.subpixels_at_one();
        let allowed = self.slack.subpixels(self.scale) * FOR_TRANSFORMS;
        let slack = self.depth_slack;
        let [near_depth, far_depth] = match *self.camera.projection() {
            Projection::Perspective { near, far, .. } => {
                let safe = if moved > 0.0 { moved / allowed } else { 0.0 };
                let nearest = safe.max(near + off) + off;
                let farthest = far.map(|far| far - off);
                [
                    near / nearest - slack,
                    match farthest {
                        None => f64::NEG_INFINITY,
                        Some(far) if far > 0.0 => near / far + slack,
                        Some(_) => f64::INFINITY,
                    },
                ]
            }
            Projection::Orthographic { .. } => [
                if moved <= allowed {
                    placed.near_depth - 2.0 * off - slack
                } else {
                    f64::NEG_INFINITY
                },
                placed.far_depth + off + slack,
            ],
        };
        ScreenTransform {
            near_depth,
            far_depth,
            ..placed
        }
    }

    /// How far a vertex of something within these bounds may be from where it should be, on behalf of the slack.
    pub(super) fn position_slack(&self, bounds: &Aabb) -> f64 {
        match self.slack.position() {
            0.0 => 0.0,
            share => share * distance_of_farthest(bounds, self.camera.eye()),
        }
    }

    /// How far a vertex at distance 1 may be drawn from its place that is off by 1 and stands back as much, in sub-pixels.
    fn subpixels_at_one(&self) -> f64 {
        let t = &self.from_eye;
        let vector = |r: [f64; 4]| DVec3::new(r[0], r[1], r[2]);
        let w = vector(t.w);
        let along = |row: [f64; 4], pixels: usize| {
            let half = pixels as f64 * f64::from(SUBPIXELS) * 0.5;
            (vector(row) - w * half).length() + 2.0 * half * w.length()
        };
        let (x, y) = (
            along(t.x, self.size.width()),
            along(t.y, self.size.height()),
        );
        x.max(y)
    }
}

/// What shapes are asked by, of what occluders are drawn by: depths that may be off by `slack` on either side are nearer by both.
pub(super) fn asked_by(screen: &ScreenTransform, slack: f64) -> ScreenTransform {
    if slack == 0.0 {
        return *screen;
    }
    ScreenTransform {
        depth: std::array::from_fn(|i| screen.depth[i] + 2.0 * slack * screen.w[i]),
        ..*screen
    }
}
