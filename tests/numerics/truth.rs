//! What is on the screen, found exactly and without the code under test: positions go through the placement and the camera's
//! rows in exact arithmetic, triangles are clipped there without a division, and depth is a fraction.
//!
//! Two things are taken from the library, since they define the picture and do not approximate it: the rows of
//! [`Camera::screen_from_eye`], and that coverage is decided on the sub-pixel grid.
#![allow(dead_code)] // Each program uses its own share.

use antumbra::glam::{DAffine3, DVec3};
use antumbra::view::{Camera, PictureSize};
use antumbra_simd::GUARD_BAND;
use antumbra_simd::vertex::ScreenTransform;

use crate::exact::{Dyadic, Fraction};
use crate::oracle::{Point, covers};

/// A point in homogeneous coordinates of the screen: X and Y over W are sub-pixels, D over W is depth.
#[derive(Clone, Debug)]
pub struct Corner {
    pub x: Dyadic,
    pub y: Dyadic,
    pub depth: Dyadic,
    pub w: Dyadic,
    /// All four are this much too large: 1 for what no plane has cut.
    pub scale: Dyadic,
    /// How far the library may have cut elsewhere, along the edge: X, Y, D and W. Where a plane is all but along an edge, what
    /// an end's distance from it is off by moves the cut by as much as the edge is longer than it is steep.
    pub blur: [f64; 4],
}

impl Corner {
    fn over_w(&self, above: &Dyadic) -> Fraction {
        Fraction {
            above: above.clone(),
            below: self.w.clone(),
        }
    }

    pub fn column(&self) -> Fraction {
        self.over_w(&self.x)
    }

    pub fn row(&self) -> Fraction {
        self.over_w(&self.y)
    }

    pub fn true_depth(&self) -> Fraction {
        self.over_w(&self.depth)
    }

    /// X, Y, D and W as the library has them, but for rounding.
    pub fn as_drawn(&self) -> [f64; 4] {
        [&self.x, &self.y, &self.depth, &self.w].map(|v| v.ratio(&self.scale))
    }

    /// The nearest point of the grid, halves up; none outside the guard band.
    pub fn snapped(&self) -> Option<Point> {
        let twice = &self.w + &self.w;
        let nearest = |v: &Dyadic| {
            let grid = (&(v + v) + &self.w).floor_of_ratio(&twice);
            i32::try_from(grid).ok().filter(|g| g.abs() <= GUARD_BAND)
        };
        Some((nearest(&self.x)?, nearest(&self.y)?))
    }

    /// `self·a + other·b`, where `moved` is what the place between the two is off by, as a share of the edge.
    fn mixed(&self, a: &Dyadic, other: &Corner, b: &Dyadic, moved: f64) -> Corner {
        let mix = |p: &Dyadic, q: &Dyadic| &(p * a) + &(q * b);
        let (p, q) = (self.as_drawn(), other.as_drawn());
        let blur = |i: usize| self.blur[i].max(other.blur[i]) + moved * (q[i] - p[i]).abs();
        Corner {
            x: mix(&self.x, &other.x),
            y: mix(&self.y, &other.y),
            depth: mix(&self.depth, &other.depth),
            w: mix(&self.w, &other.w),
            scale: mix(&self.scale, &other.scale),
            blur: std::array::from_fn(blur),
        }
    }
}

/// A plane that clips: what is at least 0 of the products with X, Y, D and W is kept.
struct Plane([f64; 4]);

impl Plane {
    fn distance(&self, v: &Corner) -> Dyadic {
        let terms = [&v.x, &v.y, &v.depth, &v.w];
        let factors = self
            .0
            .into_iter()
            .zip(terms)
            .filter(|(factor, _)| *factor != 0.0);
        factors.fold(Dyadic::whole(0), |sum, (factor, v)| {
            &sum + &(&Dyadic::of(factor) * v)
        })
    }

    /// What the library's distance of a corner may be off by, where positions are off by `position`.
    fn error(&self, v: &Corner, rows: &ScreenTransform, position: f64) -> f64 {
        let rows = [rows.x, rows.y, rows.depth, rows.w];
        let rounding = 2_f64.powi(-51);
        let part = |i: usize| {
            let row = DVec3::new(rows[i][0], rows[i][1], rows[i][2]).length();
            self.0[i].abs() * (position * row + v.blur[i] + v.as_drawn()[i].abs() * rounding)
        };
        (0..4).map(part).sum()
    }
}

fn dyadics<const N: usize>(values: [f64; N]) -> [Dyadic; N] {
    values.map(Dyadic::of)
}

/// A camera and a picture, exactly as their numbers say.
pub struct View {
    x: [Dyadic; 4],
    y: [Dyadic; 4],
    depth: [Dyadic; 4],
    w: [Dyadic; 4],
    eye: [Dyadic; 3],
    near_depth: Dyadic,
    pub rows: ScreenTransform,
    pub eye_reach: f64,
    pub width: i32,
    pub height: i32,
}

impl View {
    pub fn new(camera: &Camera, size: PictureSize) -> View {
        let rows = camera.screen_from_eye(size);
        View {
            x: dyadics(rows.x),
            y: dyadics(rows.y),
            depth: dyadics(rows.depth),
            w: dyadics(rows.w),
            eye: dyadics(camera.eye().to_array()),
            near_depth: Dyadic::of(rows.near_depth),
            rows,
            eye_reach: camera.eye().abs().max_element(),
            width: size.width() as i32,
            height: size.height() as i32,
        }
    }

    fn seen(&self, world: [Dyadic; 3]) -> Corner {
        let [x, y, z] = std::array::from_fn(|i| &world[i] - &self.eye[i]);
        let row = |r: &[Dyadic; 4]| {
            let [a, b, c, constant] = r;
            &(&(&(a * &x) + &(b * &y)) + &(c * &z)) + constant
        };
        Corner {
            x: row(&self.x),
            y: row(&self.y),
            depth: row(&self.depth),
            w: row(&self.w),
            scale: Dyadic::whole(1),
            blur: [0.0; 4],
        }
    }

    /// Where a point of the world is seen.
    pub fn corner_of_world(&self, point: DVec3) -> Corner {
        self.seen(dyadics(point.to_array()))
    }

    /// Where a placed position is seen.
    pub fn corner(&self, place: &DAffine3, position: [f32; 3]) -> Corner {
        let p = position.map(|v| Dyadic::of(v.into()));
        let m = place.matrix3;
        let columns = [m.x_axis, m.y_axis, m.z_axis].map(|c| dyadics(c.to_array()));
        let origin = dyadics(place.translation.to_array());
        self.seen(std::array::from_fn(|i| {
            let turned = &(&columns[0][i] * &p[0]) + &(&columns[1][i] * &p[1]);
            &(&turned + &(&columns[2][i] * &p[2])) + &origin[i]
        }))
    }

    /// Whether a point lies behind the near plane, as what is seen does; on it, too.
    pub fn is_behind_near(&self, v: &Corner) -> bool {
        v.depth <= &self.near_depth * &v.w
    }

    /// What is left of a triangle between the planes and within the guard band, from the corner that Sutherland and Hodgman's
    /// algorithm begins with. Its positions may be off by `position`.
    pub fn clipped(&self, corners: &[Corner; 3], position: f64) -> Vec<Corner> {
        let mut polygon = corners.to_vec();
        let (near, far) = (self.rows.near_depth, self.rows.far_depth);
        let band = f64::from(GUARD_BAND);
        let mut planes = vec![Plane([0.0, 0.0, -1.0, near])];
        if far.is_finite() {
            planes.push(Plane([0.0, 0.0, 1.0, -far]));
        }
        planes.push(Plane([1.0, 0.0, 0.0, band]));
        planes.push(Plane([-1.0, 0.0, 0.0, band]));
        planes.push(Plane([0.0, 1.0, 0.0, band]));
        planes.push(Plane([0.0, -1.0, 0.0, band]));
        for plane in planes {
            let distances: Vec<Dyadic> = polygon.iter().map(|c| plane.distance(c)).collect();
            if distances.iter().all(|d| d.sign() >= 0) {
                continue;
            }
            let mut left_over = Vec::new();
            for i in 0..polygon.len() {
                let before = (i + polygon.len() - 1) % polygon.len();
                let ([a, b], [da, db]) = (
                    [&polygon[before], &polygon[i]],
                    [&distances[before], &distances[i]],
                );
                if (da.sign() >= 0) != (db.sign() >= 0) {
                    let off =
                        plane.error(a, &self.rows, position) + plane.error(b, &self.rows, position);
                    let apart = (da.ratio(&a.scale) - db.ratio(&b.scale)).abs();
                    let moved = (off / apart).min(1.0);
                    // Positive multiples of both, so that W stays positive where it was.
                    left_over.push(if db.sign() < 0 {
                        a.mixed(&-db, b, da, moved)
                    } else {
                        b.mixed(&-da, a, db, moved)
                    });
                }
                if db.sign() >= 0 {
                    left_over.push(b.clone());
                }
            }
            polygon = left_over;
        }
        polygon
    }
}

fn cross(a: Point, b: Point, p: Point) -> i64 {
    let wide = i64::from;
    (wide(b.0) - wide(a.0)) * (wide(p.1) - wide(a.1))
        - (wide(b.1) - wide(a.1)) * (wide(p.0) - wide(a.0))
}

/// Twice the area of a triangle on the grid; above 0 where it runs clockwise for the viewer.
pub fn twice_area([a, b, c]: [Point; 3]) -> i64 {
    cross(a, b, c)
}

/// A triangle on the grid with the depths of its true corners: the surface that a picture shows.
#[derive(Clone, Debug)]
pub struct Facet {
    pub points: [Point; 3],
    /// The corners' depths, rounded.
    pub depths: [f64; 3],
    weights: [Dyadic; 3],
    below: Dyadic,
}

impl Facet {
    /// None without an area.
    pub fn new(points: [Point; 3], corners: [&Corner; 3]) -> Option<Facet> {
        let area = twice_area(points);
        if area == 0 {
            return None;
        }
        let [a, b, c] = corners;
        let w = [&b.w * &c.w, &c.w * &a.w, &a.w * &b.w];
        let turned = Dyadic::whole(area.signum());
        Some(Facet {
            points,
            depths: corners.map(|v| v.true_depth().approximately()),
            weights: std::array::from_fn(|i| &(&corners[i].depth * &w[i]) * &turned),
            below: &(&a.w * &w[0]) * &Dyadic::whole(area.abs()),
        })
    }

    /// The depth of its plane at the centre of a pixel.
    pub fn depth_at(&self, x: i32, y: i32) -> Fraction {
        let p = (256 * x + 128, 256 * y + 128);
        let [a, b, c] = self.points;
        let parts = [cross(b, c, p), cross(c, a, p), cross(a, b, p)].map(Dyadic::whole);
        let [u, v, w] = std::array::from_fn(|i| &self.weights[i] * &parts[i]);
        Fraction {
            above: &(&u + &v) + &w,
            below: self.below.clone(),
        }
    }

    /// The pixels whose centres it covers, of a picture.
    pub fn samples(&self, width: i32, height: i32) -> impl Iterator<Item = (i32, i32)> + '_ {
        let pixels = |low: i32, high: i32, end: i32| {
            (low.div_euclid(256) - 1).clamp(0, end)..(high.div_euclid(256) + 1).clamp(0, end)
        };
        let [a, b, c] = self.points;
        let columns = pixels(a.0.min(b.0).min(c.0), a.0.max(b.0).max(c.0), width);
        let rows = pixels(a.1.min(b.1).min(c.1), a.1.max(b.1).max(c.1), height);
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
            .filter(move |&(x, y)| covers(self.points, x, y))
    }

    /// Whether depth over it is not known closely: its box is more than 2²⁴ times its own area.
    pub fn is_sliver(&self) -> bool {
        let [a, b, c] = self.points.map(|(x, y)| (f64::from(x), f64::from(y)));
        let extent = |a: f64, b: f64, c: f64| a.max(b).max(c) - a.min(b).min(c);
        let around = extent(a.0, b.0, c.0) * extent(a.1, b.1, c.1);
        around > 16_777_216.0 * twice_area(self.points).abs() as f64
    }
}
