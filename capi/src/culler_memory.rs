//! What a culler knows of the frames before: to forget it, and to keep it for another view.

use std::mem::MaybeUninit;
use std::sync::Arc;

use antumbra::cull::Remembered;

use crate::arguments::{empty, required};
use crate::borrow::handle;
use crate::culler::AntumbraCuller;
use crate::handle::is_shared_by_threads;
use crate::status::{AntumbraStatus, Error, guard};

/// What a culler knew of its frames at a time. It never changes: any number of threads may use it at once. It chooses occluders and hides
/// nothing, so to recall what does not fit costs time alone.
pub struct AntumbraMemory {
    remembered: Remembered,
    /// Of the scene: numbers of objects and clusters mean nothing in another one.
    scene: Arc<()>,
}

const _: () = is_shared_by_threads::<AntumbraMemory>();

/// Forgets all frames: the next one is as the first.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_forget(culler: *mut AntumbraCuller) -> AntumbraStatus {
    guard(|| {
        handle(culler, "culler")?.0.write()?.culler.forget();
        Ok(())
    })
}

/// Keeps what a culler knows of its frames: for views that take turns, or to cull a frame again.
///
/// @param memory Is given a memory, to be destroyed by antumbra_memory_destroy; NULL if there is an error.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_remember(
    culler: Option<&AntumbraCuller>,
    memory: Option<&mut MaybeUninit<Option<Box<AntumbraMemory>>>>,
) -> AntumbraStatus {
    guard(|| {
        let place = empty(memory, "memory")?;
        let frames = required(culler, "culler")?.0.read()?;
        *place = Some(Box::new(AntumbraMemory {
            remembered: frames.culler.remembered().clone(),
            scene: frames.scene.clone(),
        }));
        Ok(())
    })
}

/// Goes back to what was known at a time, by this culler or another one of the same AntumbraScene.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the memory is of another scene, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_recall(
    culler: *mut AntumbraCuller,
    memory: Option<&AntumbraMemory>,
) -> AntumbraStatus {
    guard(|| {
        let mut frames = handle(culler, "culler")?.0.write()?;
        let memory = required(memory, "memory")?;
        if !Arc::ptr_eq(&frames.scene, &memory.scene) {
            return Err(Error::invalid("the memory is of another scene"));
        }
        frames.culler.recall(&memory.remembered);
        Ok(())
    })
}

/// Ends a memory. NULL is fine.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_memory_destroy(memory: Option<Box<AntumbraMemory>>) {
    drop(memory);
}
