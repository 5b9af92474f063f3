//! The culler: a scene, culled frame by frame.

use std::mem::MaybeUninit;
use std::sync::Arc;

use antumbra::cull::{Appearances, Culler, VisibleSet};
use antumbra::occlusion::OcclusionBuffer;
use antumbra::scene::Move;
use antumbra::view::{Camera, PictureSize};
use bytemuck::bytes_of;

use crate::arguments::{ListPlace, affine, chosen, empty, required, within};
use crate::borrow::{handle, list, room};
use crate::camera::AntumbraCamera;
use crate::culler_clusters::Clusters;
use crate::handle::Locked;
use crate::questions::{AntumbraBox, AntumbraVisibility, questions_and_room, test_boxes};
use crate::scene::{AntumbraScene, no_threads};
use crate::settings::AntumbraSettings;
use crate::statistics::AntumbraStatistics;
use crate::status::{AntumbraStatus, Error, guard};

/// Culls a scene, frame by frame. What takes it as const may be called by any number of threads at once; what changes it needs it for itself,
/// or ANTUMBRA_ERROR_BUSY comes of it. It has threads of its own, which sleep between frames and have ended when it is destroyed.
///
/// Lists that a culler gives belong to it. They are valid until the next call that takes the culler as not const.
pub struct AntumbraCuller(pub(crate) Locked<Frames>);

/// A culler and its last frame.
pub(crate) struct Frames {
    pub culler: Culler,
    /// See [`AntumbraScene::identity`].
    pub scene: Arc<()>,
    /// Of the last frame; none before the first, and before the first of another size.
    pub camera: Option<Camera>,
    pub found: VisibleSet,
    pub clusters: Clusters,
    appearances: Appearances,
    in_frustum: Vec<u32>,
    levels: Vec<f32>,
    moves: Vec<Move>,
}

const NO_FRAME: &str = "there is no frame yet: call antumbra_culler_cull first";

impl Frames {
    fn boxed(culler: Culler, scene: Arc<()>) -> Box<AntumbraCuller> {
        Box::new(AntumbraCuller(Locked::new(Frames {
            culler,
            scene,
            camera: None,
            found: VisibleSet::default(),
            clusters: Clusters::default(),
            appearances: Appearances::default(),
            in_frustum: Vec::new(),
            levels: Vec::new(),
            moves: Vec::new(),
        })))
    }

    /// The last frame's camera.
    pub fn camera(&self) -> Result<Camera, Error> {
        self.camera.ok_or_else(|| Error::state(NO_FRAME))
    }

    /// What the last frame drew.
    fn buffer(&self) -> Result<&OcclusionBuffer, Error> {
        let buffer = self.culler.buffer();
        buffer.ok_or_else(|| Error::state(NO_FRAME))
    }
}

/// Makes a culler.
///
/// @param scene May be destroyed before the culler.
/// @param culler Is given a culler, to be destroyed by antumbra_culler_destroy; NULL if there is an error.
///
/// Errors: ANTUMBRA_ERROR_STRUCT_SIZE, ANTUMBRA_ERROR_INVALID_ARGUMENT if a setting makes no sense, ANTUMBRA_ERROR_LEVEL,
/// ANTUMBRA_ERROR_THREADS.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_create(
    scene: Option<&AntumbraScene>,
    settings: *const AntumbraSettings,
    culler: Option<&mut MaybeUninit<Option<Box<AntumbraCuller>>>>,
) -> AntumbraStatus {
    guard(|| {
        let place = empty(culler, "culler")?;
        let scene = required(scene, "scene")?;
        let settings = AntumbraSettings::read(settings)?;
        let culler = Culler::with_prepared(&scene.prepared, settings).map_err(no_threads)?;
        *place = Some(Frames::boxed(culler, scene.identity.clone()));
        Ok(())
    })
}

/// Makes another culler for the same scene as it is now, with other settings and nothing remembered, for another view. What is known of the
/// scene is shared; either may be destroyed first.
///
/// Errors: as antumbra_culler_create.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_another(
    culler: Option<&AntumbraCuller>,
    settings: *const AntumbraSettings,
    another: Option<&mut MaybeUninit<Option<Box<AntumbraCuller>>>>,
) -> AntumbraStatus {
    guard(|| {
        let place = empty(another, "another")?;
        let frames = required(culler, "culler")?.0.read()?;
        let settings = AntumbraSettings::read(settings)?;
        let another = frames.culler.another(settings).map_err(no_threads)?;
        *place = Some(Frames::boxed(another, frames.scene.clone()));
        Ok(())
    })
}

/// Ends a culler and its threads. NULL is fine. Not to be called while another call has the culler.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_destroy(culler: Option<Box<AntumbraCuller>>) {
    drop(culler);
}

/// Finds which objects a camera may see.
///
/// @param objects Is given the visible objects in ascending order; NULL if there are none, or an error.
/// @param count Is given how many.
///
/// Frames follow each other: a frame remembers which occluders the last one needed. Where accuracy is exact, every object that
/// owns a pixel of the picture is in the list. A frame like the last one allocates nothing on one thread.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the camera is none, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_cull(
    culler: *mut AntumbraCuller,
    camera: Option<&AntumbraCamera>,
    objects: Option<&mut MaybeUninit<*const u32>>,
    count: Option<&mut MaybeUninit<usize>>,
) -> AntumbraStatus {
    guard(|| {
        let place = ListPlace::empty(objects, count)?;
        let mut frames = handle(culler, "culler")?.0.write()?;
        let frames = &mut *frames;
        let camera = required(camera, "camera")?.checked()?;
        frames.culler.cull_into(&camera, &mut frames.found);
        frames.camera = Some(camera);
        place.put(&frames.found.visible);
        Ok(())
    })
}

/// Finds which objects are in a camera's frustum, those that culling chooses from, in ascending order. (A frame does not look at
/// all of them.)
///
/// Errors: as antumbra_culler_cull.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_in_frustum(
    culler: *mut AntumbraCuller,
    camera: Option<&AntumbraCamera>,
    objects: Option<&mut MaybeUninit<*const u32>>,
    count: Option<&mut MaybeUninit<usize>>,
) -> AntumbraStatus {
    guard(|| {
        let place = ListPlace::empty(objects, count)?;
        let mut frames = handle(culler, "culler")?.0.write()?;
        let camera = required(camera, "camera")?.checked()?;
        frames.in_frustum = frames.culler.in_frustum(&camera);
        place.put(&frames.in_frustum);
        Ok(())
    })
}

/// About what share of each visible object of the last frame may be seen, more than 0 and up to 1, in their order: where a
/// coarser model would do.
///
/// Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_visibility_levels(
    culler: *mut AntumbraCuller,
    levels: Option<&mut MaybeUninit<*const f32>>,
    count: Option<&mut MaybeUninit<usize>>,
) -> AntumbraStatus {
    guard(|| {
        let place = ListPlace::empty(levels, count)?;
        let mut frames = handle(culler, "culler")?.0.write()?;
        let frames = &mut *frames;
        frames.camera()?;
        let (found, levels) = (&frames.found, &mut frames.levels);
        frames.culler.visibility_levels(found, levels);
        place.put(&frames.levels);
        Ok(())
    })
}

/// The objects that the last frame found visible and that were in the frustum, but not visible, when this was called before:
/// hints for fading them in. To be called once after each antumbra_culler_cull; the first call gives none.
///
/// Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_appearances(
    culler: *mut AntumbraCuller,
    objects: Option<&mut MaybeUninit<*const u32>>,
    count: Option<&mut MaybeUninit<usize>>,
) -> AntumbraStatus {
    guard(|| {
        let place = ListPlace::empty(objects, count)?;
        let mut frames = handle(culler, "culler")?.0.write()?;
        let camera = frames.camera()?;
        let frames = &mut *frames;
        let (scene, size) = (frames.culler.scene(), frames.culler.settings().size);
        place.put(
            frames
                .appearances
                .of_frame(scene, &camera, size, &frames.found),
        );
        Ok(())
    })
}

/// Where an object goes.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraMove {
    /// The object.
    pub object: u32,
    /// 0 or 1: whether its box is to hold it where it was as well, for who draws it in between: a picture that is late, or blurred by
    /// motion. Until its next move it hides nothing then, since nobody knows where it is.
    pub swept: u32,
    /// From its mesh's local coordinates to the world's, from now on: 16 numbers, column by column, whose last row is 0 0 0 1.
    pub world_from_local: [f64; 16],
}

impl AntumbraMove {
    fn checked(&self, objects: usize) -> Result<Move, Error> {
        if self.object as usize >= objects {
            return Err(Error::out_of_range("object", self.object, objects));
        }
        Ok(Move {
            object: self.object,
            world_from_local: affine(self.world_from_local.as_ptr(), "world_from_local")?,
            swept: chosen(self.swept, &[(0, false), (1, true)], "swept")?,
        })
    }
}

/// Moves objects, occluders among them: from the next frame on they are where they go, in every way, for this culler alone.
/// antumbra_scene_object_bounds tells where they were. The first call copies the scene, but for its meshes.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such object, ANTUMBRA_ERROR_INVALID_ARGUMENT if a matrix is not finite and affine,
/// ANTUMBRA_ERROR_SCENE if one leads beyond coordinates of 2^100, ANTUMBRA_ERROR_BUSY. Nothing has moved then.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_move_objects(
    culler: *mut AntumbraCuller,
    moves: *const AntumbraMove,
    count: usize,
) -> AntumbraStatus {
    guard(|| {
        let mut frames = handle(culler, "culler")?.0.write()?;
        let Frames {
            culler,
            moves: places,
            ..
        } = &mut *frames;
        let objects = culler.scene().objects().len();
        places.clear();
        for to in list(moves, count, "moves")? {
            places.push(to.checked(objects)?);
        }
        culler.move_objects(places)?;
        Ok(())
    })
}

/// Makes pictures of another size from the next frame on. What is remembered stays.
///
/// @param width, height In pixels, from 1 to 16384.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the size is none, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_resize(
    culler: *mut AntumbraCuller,
    width: u32,
    height: u32,
) -> AntumbraStatus {
    guard(|| {
        let mut frames = handle(culler, "culler")?.0.write()?;
        let size = PictureSize::new(width, height)?;
        if size != frames.culler.settings().size {
            frames.culler.resize(size);
            frames.camera = None;
        }
        Ok(())
    })
}

/// Says how much an object stands out against what may hide it, from 0, as at first, to 1: a lamp behind leaves. Where holes are
/// ignored, such an object is culled only if it shows in no more than a share of 1 - salience of what may be ignored in a tile.
///
/// Errors: ANTUMBRA_ERROR_OUT_OF_RANGE if there is no such object, ANTUMBRA_ERROR_INVALID_ARGUMENT if salience is not from 0 to
/// 1, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_set_salience(
    culler: *mut AntumbraCuller,
    object: u32,
    salience: f32,
) -> AntumbraStatus {
    guard(|| {
        let mut frames = handle(culler, "culler")?.0.write()?;
        let objects = frames.culler.scene().objects().len();
        if object as usize >= objects {
            return Err(Error::out_of_range("object", object, objects));
        }
        let salience = within(salience, 0.0..=1.0, "salience")?;
        frames.culler.set_salience(object, salience);
        Ok(())
    })
}

/// What the last frame did and what it took.
///
/// @param struct_size sizeof(AntumbraStatistics). Fields that this version of the library does not have become 0.
///
/// Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_statistics(
    culler: Option<&AntumbraCuller>,
    statistics: *mut AntumbraStatistics,
    struct_size: usize,
) -> AntumbraStatus {
    guard(|| {
        let frames = required(culler, "culler")?.0.read()?;
        frames.camera()?;
        let known = AntumbraStatistics::of(&frames.found);
        let places = room(statistics.cast::<u8>(), struct_size, "statistics")?;
        let bytes = bytes_of(&known).iter().chain(std::iter::repeat(&0));
        for (place, byte) in places.iter_mut().zip(bytes) {
            place.write(*byte);
        }
        Ok(())
    })
}

/// Asks whether world boxes are hidden by what the last frame drew: things that are not in the scene because they move. What is
/// asked is what that frame's camera sees.
///
/// @param boxes, visibilities count of each; they must not overlap. A box that reaches the near plane, or is not finite, is
///     visible.
///
/// Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_test_boxes(
    culler: Option<&AntumbraCuller>,
    boxes: *const AntumbraBox,
    count: usize,
    visibilities: *mut AntumbraVisibility,
) -> AntumbraStatus {
    guard(|| {
        let frames = required(culler, "culler")?.0.read()?;
        let (boxes, room) = questions_and_room(boxes, count, visibilities, "boxes")?;
        test_boxes(frames.buffer()?, boxes, room);
        Ok(())
    })
}

/// A hash of what the last frame drew, coverage and depths: the same on every machine.
///
/// Errors: ANTUMBRA_ERROR_STATE if nothing has been culled yet, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_culler_buffer_hash(
    culler: Option<&AntumbraCuller>,
    hash: Option<&mut MaybeUninit<u64>>,
) -> AntumbraStatus {
    guard(|| {
        let frames = required(culler, "culler")?.0.read()?;
        let hash_of_tiles = frames.buffer()?.tiles().hash();
        required(hash, "hash")?.write(hash_of_tiles);
        Ok(())
    })
}
