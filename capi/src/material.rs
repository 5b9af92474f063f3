//! What surfaces are like.

use antumbra::scene::{Alpha, Material};

use crate::arguments::{chosen, within};
use crate::status::Error;

/// How a surface lets light through.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraAlpha {
    /// It hides what is behind it. The only kind that occludes, but for ANTUMBRA_ALPHA_BLEND where AntumbraSettings.translucent is set.
    ANTUMBRA_ALPHA_OPAQUE = 0,
    /// It is cut out by a texture: never an occluder.
    ANTUMBRA_ALPHA_MASK = 1,
    /// It is translucent.
    ANTUMBRA_ALPHA_BLEND = 2,
}

use AntumbraAlpha::*;

const ALPHAS: [(u32, Alpha); 3] = [
    (ANTUMBRA_ALPHA_OPAQUE as u32, Alpha::Opaque),
    (ANTUMBRA_ALPHA_MASK as u32, Alpha::Mask),
    (ANTUMBRA_ALPHA_BLEND as u32, Alpha::Blend),
];

/// What a surface is like, as far as culling needs to know.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraMaterial {
    /// An AntumbraAlpha.
    pub alpha: u32,
    /// Whether both sides are drawn: 0 or 1. A single-sided surface is drawn, and occludes, with its front faces only: those whose corners
    /// run counter-clockwise in the mesh's own coordinates.
    pub double_sided: u32,
    /// Of a translucent surface: from 0, all light passes, to 1.
    pub opacity: f32,
}

impl AntumbraMaterial {
    pub fn checked(&self) -> Result<Material, Error> {
        let opacity = within(self.opacity, 0.0..=1.0, "opacity")?;
        Ok(Material {
            alpha: chosen(self.alpha, &ALPHAS, "alpha")?,
            double_sided: chosen(self.double_sided, &[(0, false), (1, true)], "double_sided")?,
            color: [1.0, 1.0, 1.0, opacity],
        })
    }
}
