//! A box on screen, as the closer question takes it: see [`antumbra_simd::projected`].

use antumbra_simd::faces::Faces;
use antumbra_simd::glance::Slabs;
use antumbra_simd::outline::Outline;
use antumbra_simd::projected::OnScreen;
use antumbra_simd::query::Rectangle;

use super::{Footprint, SampleRect};

/// A box on screen, ready to be asked about; see [`Screen::project_aabb`](super::Screen::project_aabb).
#[derive(Clone, Debug)]
pub struct ProjectedBox {
    footprint: Footprint,
    on_screen: Option<OnScreen>,
    slabs: Slabs,
}

impl ProjectedBox {
    pub(super) fn new(footprint: Footprint, on_screen: Option<OnScreen>, slabs: Slabs) -> Self {
        ProjectedBox {
            footprint,
            on_screen,
            slabs,
        }
    }

    /// Where the box may be drawn, and its nearest corner's depth.
    pub fn footprint(&self) -> Footprint {
        self.footprint
    }

    /// The samples of `rect` that can be covered: those inside the outline. `rect` is the box's footprint.
    pub fn outline(&self, rect: &SampleRect) -> Outline {
        match &self.on_screen {
            Some(on_screen) => on_screen.outline(rectangle(rect)),
            None => Outline::of_rectangle(rect.x, rect.y),
        }
    }

    /// What bounds the depth of the box's triangles over the samples of `rect`, its footprint.
    pub fn faces(&self, rect: &SampleRect) -> Faces {
        match &self.on_screen {
            Some(on_screen) => on_screen.faces(rectangle(rect)),
            None => Faces::new(rect.nearest_depth),
        }
    }

    /// The box's faces, relative to the eye.
    pub(super) fn slabs(&self) -> &Slabs {
        &self.slabs
    }
}

/// A rectangle as questions take it.
pub(super) fn rectangle(rect: &SampleRect) -> Rectangle {
    Rectangle {
        x: rect.x,
        y: rect.y,
        nearest: rect.nearest_depth,
    }
}
