//! The picture by a graphics processor: the scene is uploaded once, the survivors are drawn, and the picture is read back.
//!
//! It looks like the CPU picture (`image`): flat-shaded surfaces, creases, translucent surfaces over them, sRGB by the same table. But
//! samples, vertices and depths are the device's, so a culler for it needs [`Slack::GPU`](crate::view::Slack::GPU); `docs/gpu.md` says
//! what that does and does not cover.
//!
//! **Invariant.** The picture of exact survivors is the picture of the whole scene, byte for byte. Both draw in scene order, the nearest
//! stays, of equals the first drawn; a hidden object has no sample that it would own, so its absence changes none, and nothing that a
//! pixel shows hangs on what else is drawn: each vertex goes through the same matrix, and a face's light is found at its own corners.
//!
//! A frame: `draws` makes the list of what is drawn, which is one indirect buffer, `geometry` holds what was uploaded, `pipelines`
//! how it is drawn, `targets` what it is drawn to, and `device` is the device itself.

mod device;
mod draws;
mod geometry;
mod pipelines;
mod targets;

use std::sync::Arc;

use thiserror::Error;

use super::creases::Creases;
use super::image::Image;
use super::light::Light;
use crate::scene::{Alpha, Scene};
use crate::view::{Camera, PictureSize};
use device::Device;
use draws::{DrawList, View};
use geometry::Geometry;
use pipelines::{Look, Pipelines};
use targets::{OwnerTargets, PictureUniform, Targets};

/// What [`GpuPass::owners`] says of a pixel that shows no object.
pub const NOBODY: u32 = u32::MAX;

/// Why there is no picture by a graphics processor.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum GpuError {
    /// There is no device.
    #[error(
        "no graphics processor is to be had, nor anything that stands in for one; on Debian, the package mesa-vulkan-drivers draws without ({0})"
    )]
    NoDevice(String),
    /// The device lacks something.
    #[error("{device} cannot draw the picture: {why}")]
    Unfit {
        /// Its name.
        device: String,
        /// What it lacks.
        why: String,
    },
    /// A mesh is larger than a buffer may be.
    #[error(
        "mesh {mesh:?} takes {bytes} bytes, and a buffer of {device} holds {most}: split the mesh"
    )]
    MeshTooLarge {
        /// Its name.
        mesh: String,
        /// What its positions or its triangles take, the larger.
        bytes: u64,
        /// The device's name.
        device: String,
        /// The most.
        most: u64,
    },
    /// Something went wrong on the device: it has no memory left, or was lost.
    #[error("{device} failed: {why}")]
    Failed {
        /// Its name.
        device: String,
        /// What it said.
        why: String,
    },
}

/// Draws pictures of one scene.
///
/// ```no_run
/// use antumbra::cull::{Culler, Settings};
/// use antumbra::final_pass::gpu::GpuPass;
/// use antumbra::scene::Scene;
/// use antumbra::view::{CameraPath, PictureSize, Slack};
///
/// let scene = std::sync::Arc::new(Scene::load("city.glb".as_ref())?);
/// let size = PictureSize::new(1280, 768)?;
/// let mut culler = Culler::new(scene.clone(), Settings { slack: Slack::GPU, ..Settings::new(size) })?;
/// let mut pass = GpuPass::new(scene)?;
/// for camera in CameraPath::load("city.path.json".as_ref())?.cameras() {
///     let picture = pass.render(camera, size, &culler.cull(camera).visible)?;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct GpuPass {
    scene: Arc<Scene>,
    device: Device,
    pipelines: Pipelines,
    geometry: Geometry,
    targets: Option<Targets>,
}

impl GpuPass {
    /// Finds a device, and uploads the scene to it.
    ///
    /// # Errors
    /// If there is no device that will do, or it cannot hold the scene.
    pub fn new(scene: Arc<Scene>) -> Result<GpuPass, GpuError> {
        let device = Device::open()?;
        let pipelines = Pipelines::new(&device);
        let geometry = device.try_to(|| Geometry::upload(&scene, &device, &pipelines))??;
        Ok(GpuPass {
            scene,
            device,
            pipelines,
            geometry,
            targets: None,
        })
    }

    /// The device's name, and by which interface it is used.
    pub fn device(&self) -> &str {
        self.device.name()
    }

    /// Draws `objects`, which are in scene order, as the camera sees them.
    ///
    /// With all objects of a scene, or with those that exact culling with a slack leaves, the picture is the same.
    ///
    /// # Errors
    /// If the device fails.
    pub fn render(
        &mut self,
        camera: &Camera,
        size: PictureSize,
        objects: &[u32],
    ) -> Result<Image, GpuError> {
        let view = View::new(&self.scene, camera, size);
        let light = Light::new(&self.scene, camera);
        let list = |alpha: fn(Alpha) -> bool| {
            DrawList::new(&self.scene, &self.geometry, &view, &light, objects, |m| {
                alpha(m.alpha)
            })
        };
        let solid = list(|alpha| alpha != Alpha::Blend);
        let translucent = list(|alpha| alpha == Alpha::Blend);
        let creases = Creases::new(size, camera.projection());
        let uniform = PictureUniform::new(&view, camera, size, &creases);
        let (device, pipelines) = (&self.device, &self.pipelines);
        let targets = match self.targets.take().filter(|targets| targets.size() == size) {
            Some(targets) => targets,
            None => device.try_to(|| Targets::new(device, pipelines, size, &creases))?,
        };
        let targets = self.targets.insert(targets);
        let pixels = device.try_to(|| {
            let mut encoder = device.encoder();
            let view = device.uniform(&view.uniform(camera, &light));
            let solid = solid.upload(device, pipelines, &view);
            let translucent = translucent.upload(device, pipelines, &view);
            let mut pass = targets.begin_solid(&mut encoder);
            solid.draw(&mut pass, pipelines, Look::Solid, &self.geometry);
            drop(pass);
            targets.crease(device, pipelines, &uniform, &mut encoder);
            let mut pass = targets.begin_translucent(&mut encoder);
            translucent.draw(&mut pass, pipelines, Look::Translucent, &self.geometry);
            drop(pass);
            targets.encode(pipelines, &mut encoder);
            targets.read_picture(device, encoder)
        })??;
        Ok(Image::of_pixels(size.width(), pixels))
    }

    /// Which of `objects`, in scene order, owns each pixel, row by row: the nearest of those that are not translucent. [`NOBODY`] where
    /// there is none.
    ///
    /// # Errors
    /// If the device fails.
    pub fn owners(
        &self,
        camera: &Camera,
        size: PictureSize,
        objects: &[u32],
    ) -> Result<Vec<u32>, GpuError> {
        let view = View::new(&self.scene, camera, size);
        let light = Light::new(&self.scene, camera);
        let (device, pipelines) = (&self.device, &self.pipelines);
        let solid = |alpha| alpha != Alpha::Blend;
        let list = DrawList::new(&self.scene, &self.geometry, &view, &light, objects, |m| {
            solid(m.alpha)
        });
        device.try_to(|| {
            let mut encoder = device.encoder();
            let list = list.upload(
                device,
                pipelines,
                &device.uniform(&view.uniform(camera, &light)),
            );
            let owners = OwnerTargets::new(device, size);
            let mut pass = owners.begin(&mut encoder);
            list.draw(&mut pass, pipelines, Look::Owner, &self.geometry);
            drop(pass);
            owners.read(device, encoder)
        })?
    }
}
