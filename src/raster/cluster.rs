//! The polygons of a cluster, ready to be filled.

use antumbra_simd::Level;
use antumbra_simd::assemble::{AssembleMemory, Cluster, Drawing, assemble};
use antumbra_simd::spans::{SpanBlocks, SpanPolygon};
use antumbra_simd::triangle::{CullMode, Triangle};
use antumbra_simd::vertex::{ClipVertex, ScreenTransform, transform};

use super::TileBuffer;
use super::clip::clip_triangle;
use crate::view::PictureSize;

/// Assembles clusters; keeps its buffers from one to the next.
#[derive(Clone, Debug, Default)]
pub struct ClusterAssembler {
    memory: AssembleMemory,
    to_clip: Vec<[u8; 3]>,
    clipped: Vec<SpanPolygon>,
}

impl ClusterAssembler {
    /// Appends a cluster's polygons that can cover a sample to `blocks`: first those that need no clipping, in their
    /// order, then what is left of the others. Some that what is drawn already hides are left out.
    pub fn assemble(
        &mut self,
        level: Level,
        cluster: Cluster<'_>,
        screen: &ScreenTransform,
        cull: CullMode,
        drawn: &TileBuffer,
        blocks: &mut SpanBlocks,
    ) {
        let size = drawn.size();
        let (width, height) = (size.width() as i32, size.height() as i32);
        let drawing = Drawing {
            screen,
            cull,
            width,
            height,
            inset: drawn.inset(),
            drawn: drawn.layered(),
        };
        self.to_clip.clear();
        assemble(
            level,
            cluster,
            drawing,
            &mut self.memory,
            blocks,
            &mut self.to_clip,
        );
        if self.to_clip.is_empty() {
            return;
        }
        self.clipped.clear();
        for &triangle in &self.to_clip {
            let corners = triangle.map(|i| {
                let i = usize::from(i);
                transform(screen, [cluster.x[i], cluster.y[i], cluster.z[i]])
            });
            if is_outside(&corners, screen, size) {
                continue;
            }
            clip_triangle(corners, screen, |vertices| {
                let triangle = Triangle::new(vertices, cull).and_then(|t| t.within(width, height));
                let polygon = |t: &Triangle| SpanPolygon::of_triangle(t, drawn.inset());
                self.clipped.extend(triangle.as_ref().map(polygon));
            });
        }
        blocks.pack(self.clipped.iter().copied());
    }
}

/// Whether all corners lie in front of the near plane or beyond the same side of the picture, a pixel away from it. What
/// holds for corners holds for all between them, whatever is clipped.
fn is_outside(corners: &[ClipVertex; 3], t: &ScreenTransform, size: PictureSize) -> bool {
    let pixel = 256.0;
    let right = pixel * (size.width() + 1) as f64;
    let bottom = pixel * (size.height() + 1) as f64;
    let all = |outside: &dyn Fn(&ClipVertex) -> bool| corners.iter().all(outside);
    all(&|v| v.depth > t.near_depth * v.w)
        || all(&|v| v.x < -pixel * v.w)
        || all(&|v| v.y < -pixel * v.w)
        || all(&|v| v.x > right * v.w)
        || all(&|v| v.y > bottom * v.w)
}
