//! Who draws the pictures: the processor, or a graphics processor.

use std::sync::Arc;

#[cfg(feature = "gpu")]
use antumbra::final_pass::gpu::{GpuError, GpuPass};
use antumbra::final_pass::{Image, render_image};
use antumbra::scene::Scene;
use antumbra::view::{Camera, PictureSize, Slack};
use clap::ValueEnum;
use rayon::ThreadPool;

use super::failure::Failure;

/// Who draws the pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FinalPassName {
    /// The processor: the same bytes on every machine
    Cpu,
    /// A graphics processor, or what stands in for one; culling keeps away from what it may do otherwise (--slack)
    Gpu,
}

impl FinalPassName {
    /// What exact culling has to keep away from.
    pub fn slack(self) -> Slack {
        match self {
            FinalPassName::Cpu => Slack::NONE,
            FinalPassName::Gpu => Slack::GPU,
        }
    }
}

/// What draws the pictures of a scene.
pub enum FinalPass {
    Cpu,
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuPass>),
}

impl FinalPass {
    /// Makes it ready.
    ///
    /// # Errors
    /// If this build or this machine has none of the kind, or it cannot hold the scene.
    pub fn open(name: FinalPassName, scene: &Arc<Scene>) -> Result<FinalPass, Failure> {
        match name {
            FinalPassName::Cpu => Ok(FinalPass::Cpu),
            FinalPassName::Gpu => FinalPass::open_gpu(scene),
        }
    }

    #[cfg(feature = "gpu")]
    fn open_gpu(scene: &Arc<Scene>) -> Result<FinalPass, Failure> {
        match GpuPass::new(scene.clone()) {
            Ok(pass) => Ok(FinalPass::Gpu(Box::new(pass))),
            Err(e @ (GpuError::NoDevice(_) | GpuError::Unfit { .. })) => {
                Err(Failure::Lacking(format!("--final-pass gpu: {e}")))
            }
            Err(e) => Err(failed(e)),
        }
    }

    #[cfg(not(feature = "gpu"))]
    fn open_gpu(_: &Arc<Scene>) -> Result<FinalPass, Failure> {
        Err(Failure::Lacking(
            "--final-pass gpu: this build has no such pass; build it with `cargo build --release --features gpu`"
                .to_owned(),
        ))
    }

    /// Its device's name, if it has one.
    pub fn device(&self) -> Option<&str> {
        match self {
            FinalPass::Cpu => None,
            #[cfg(feature = "gpu")]
            FinalPass::Gpu(pass) => Some(pass.device()),
        }
    }

    /// Draws objects of the scene, in scene order.
    pub fn picture(
        &mut self,
        pool: &ThreadPool,
        scene: &Scene,
        camera: &Camera,
        size: PictureSize,
        objects: &[u32],
    ) -> Result<Image, Failure> {
        match self {
            FinalPass::Cpu => Ok(pool.install(|| render_image(scene, camera, size, objects))),
            #[cfg(feature = "gpu")]
            FinalPass::Gpu(pass) => pass.render(camera, size, objects).map_err(failed),
        }
    }
}

#[cfg(feature = "gpu")]
fn failed(error: GpuError) -> Failure {
    Failure::Failed(format!("--final-pass gpu: {error}"))
}
