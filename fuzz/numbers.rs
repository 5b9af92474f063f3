//! Numbers as programs pass them: mostly ordinary ones, some small fractions and powers of two, now and then any bits there are.
#![allow(dead_code, reason = "each target uses some")]

use antumbra::glam::{DMat3, DVec3};
use antumbra::view::{Camera, PictureSize, Projection};
use arbitrary::{Arbitrary, Result, Unstructured};

/// A number.
#[derive(Clone, Copy, Debug)]
pub struct Number(pub f64);

impl<'a> Arbitrary<'a> for Number {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Number> {
        Ok(Number(match u.arbitrary::<u8>()? {
            0..=149 => f64::from(u.arbitrary::<i16>()?) / 2048.0,
            150..=199 => f64::from(u.arbitrary::<i8>()?) / 4.0,
            200..=219 => f64::from(u.arbitrary::<i32>()?),
            220..=234 => 2_f64.powi(i32::from(u.arbitrary::<i16>()? % 1074)),
            235..=244 => f64::from(f32::from_bits(u.arbitrary()?)),
            245..=249 => f64::from_bits(u.arbitrary()?),
            250 => 0.0,
            251 => -0.0,
            252 => f64::NAN,
            253 => f64::INFINITY,
            254 => f64::NEG_INFINITY,
            _ => f64::MAX,
        }))
    }
}

/// Three numbers.
#[derive(Clone, Copy, Debug, Arbitrary)]
pub struct Vector(pub [Number; 3]);

impl Vector {
    pub fn get(self) -> DVec3 {
        DVec3::from_array(self.0.map(|n| n.0))
    }
}

/// A matrix: often one that only scales.
#[derive(Clone, Copy, Debug, Arbitrary)]
pub enum Matrix {
    Scale(Number),
    Diagonal(Vector),
    Any([Vector; 3]),
}

impl Matrix {
    pub fn get(self) -> DMat3 {
        match self {
            Matrix::Scale(n) => DMat3::from_diagonal(DVec3::splat(n.0)),
            Matrix::Diagonal(v) => DMat3::from_diagonal(v.get()),
            Matrix::Any([x, y, z]) => DMat3::from_cols(x.get(), y.get(), z.get()),
        }
    }
}

/// A camera as it is asked for.
#[derive(Clone, Copy, Debug, Arbitrary)]
pub struct CameraWish {
    eye: Vector,
    target: Vector,
    up: Option<Vector>,
    perspective: bool,
    /// The angle or the height.
    opening: Number,
    near: Number,
    far: Option<Number>,
}

impl CameraWish {
    /// The camera, if there is such a one.
    pub fn get(&self) -> Option<Camera> {
        let far = self.far.map(|n| n.0);
        // Most numbers are wider than any angle: those that are not large stand for one.
        let angle = match self.opening.0.abs() {
            wide if wide < 20.0 => wide % 3.14,
            other => other,
        };
        let projection = if self.perspective {
            Projection::Perspective {
                fov_y: angle,
                near: self.near.0.abs(),
                far,
            }
        } else {
            Projection::Orthographic {
                height: self.opening.0.abs(),
                near: self.near.0,
                far,
            }
        };
        let up = self.up.map_or(DVec3::Y, Vector::get);
        Camera::look_at(self.eye.get(), self.target.get(), up, projection).ok()
    }
}

/// A picture's size, mostly small.
#[derive(Clone, Copy, Debug, Arbitrary)]
pub struct Size {
    width: u8,
    height: u8,
    odd: bool,
    large: Option<(u16, u16)>,
}

impl Size {
    /// A size up to 40×40.
    pub fn small(&self) -> PictureSize {
        let side = |v: u8| u32::from(v) % 40 + 1;
        PictureSize::new(side(self.width), side(self.height)).expect("a size")
    }

    /// Any size.
    pub fn any(&self) -> PictureSize {
        match self.large {
            Some((w, h)) if self.odd => {
                let side = |v: u16| u32::from(v) % PictureSize::LARGEST + 1;
                PictureSize::new(side(w), side(h)).expect("a size")
            }
            _ => self.small(),
        }
    }
}
