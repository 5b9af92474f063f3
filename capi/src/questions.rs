//! Shapes to ask about, and the answers.

use std::mem::MaybeUninit;

use antumbra::occlusion::{OcclusionBuffer, OrientedBox, Visibility};
use antumbra::scene::Aabb;

use crate::borrow::{list, room};
use crate::status::Error;

/// A box along the axes of the world.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraBox {
    /// The least coordinates.
    pub min: [f64; 3],
    /// The largest coordinates.
    pub max: [f64; 3],
}

/// A box with any orientation, world coordinates. Its axes need not be at right angles to each other.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraOrientedBox {
    /// The middle.
    pub center: [f64; 3],
    /// From the middle to the middles of three faces.
    pub half_axes: [[f64; 3]; 3],
}

/// What kind of answer it is.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraAnswer {
    /// It covers no sample of the picture: it lies outside, or between samples. So it is hidden.
    ANTUMBRA_OUTSIDE = 0,
    /// Nothing of it can reach a pixel: it is hidden.
    ANTUMBRA_OCCLUDED = 1,
    /// Something of it may reach a pixel.
    ANTUMBRA_VISIBLE = 2,
}

/// The answer to a question.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraVisibility {
    /// An AntumbraAnswer.
    pub answer: u32,
    /// About what share of it may be seen: more than 0 and up to 1 where it is visible, 0 where it is hidden.
    pub level: f32,
}

impl From<Visibility> for AntumbraVisibility {
    fn from(visibility: Visibility) -> AntumbraVisibility {
        let answer = match visibility {
            Visibility::Outside => AntumbraAnswer::ANTUMBRA_OUTSIDE,
            Visibility::Occluded => AntumbraAnswer::ANTUMBRA_OCCLUDED,
            Visibility::Visible(_) => AntumbraAnswer::ANTUMBRA_VISIBLE,
        };
        AntumbraVisibility {
            answer: answer as u32,
            level: visibility.level(),
        }
    }
}

impl AntumbraBox {
    pub fn of(bounds: &Aabb) -> AntumbraBox {
        AntumbraBox {
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
        }
    }
}

impl From<&AntumbraBox> for Aabb {
    fn from(bounds: &AntumbraBox) -> Aabb {
        Aabb {
            min: bounds.min.into(),
            max: bounds.max.into(),
        }
    }
}

impl From<&AntumbraOrientedBox> for OrientedBox {
    fn from(bounds: &AntumbraOrientedBox) -> OrientedBox {
        OrientedBox {
            center: bounds.center.into(),
            half_axes: bounds.half_axes.map(Into::into),
        }
    }
}

/// Lists of questions and room for as many answers.
pub fn questions_and_room<'a, Q>(
    questions: *const Q,
    count: usize,
    answers: *mut AntumbraVisibility,
    name: &str,
) -> Result<(&'a [Q], &'a mut [MaybeUninit<AntumbraVisibility>]), Error> {
    let questions = list(questions, count, name)?;
    Ok((questions, room(answers, count, "visibilities")?))
}

/// Asks a buffer about boxes.
pub fn test_boxes(
    buffer: &OcclusionBuffer,
    boxes: &[AntumbraBox],
    answers: &mut [MaybeUninit<AntumbraVisibility>],
) {
    for (bounds, answer) in boxes.iter().zip(answers) {
        answer.write(buffer.test_aabb(&bounds.into()).into());
    }
}
