//! The occlusion buffer, for engines that have their own scene.

use std::mem::MaybeUninit;

use antumbra::occlusion::{Accuracy, OcclusionBuffer, Sphere};
use antumbra::view::{MapScale, PictureSize};

use crate::arguments::{empty, required, vector, within};
use crate::borrow::{handle, list, room};
use crate::camera::AntumbraCamera;
use crate::handle::Locked;
use crate::level::level;
use crate::occluder::AntumbraOccluder;
use crate::questions::{
    AntumbraBox, AntumbraOrientedBox, AntumbraVisibility, questions_and_room, test_boxes,
};
use crate::settings::{AntumbraApproximation, map_scale};
use crate::status::{AntumbraStatus, Error, guard};

/// What occluders hide, for engines that have their own scene. A frame is: clear, draw, finish, ask. Questions before finish are answered
/// too, from what is drawn so far.
///
/// What takes it as const may be called by any number of threads at once; what changes it needs it for itself, or
/// ANTUMBRA_ERROR_BUSY comes of it. It has no threads of its own.
pub struct AntumbraOcclusionBuffer(Locked<State>);

struct State {
    buffer: OcclusionBuffer,
    size: PictureSize,
    stage: Stage,
}

/// How far a frame has come.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    Cleared,
    Drawing,
    Finished,
}

impl State {
    /// Comes to drawing, if the frame is not over.
    fn draws(&mut self) -> Result<&mut OcclusionBuffer, Error> {
        if self.stage == Stage::Finished {
            return Err(Error::state(
                "the frame is finished: call antumbra_occlusion_buffer_clear before drawing again",
            ));
        }
        self.stage = Stage::Drawing;
        Ok(&mut self.buffer)
    }
}

/// Makes an empty buffer for pictures of a size, seen by a camera, at the best level, exact.
///
/// @param width, height Of the picture in pixels, from 1 to 16384.
/// @param map_scale How many of its pixels lie along the edge of the map's, 1, 2 or 4; coarse maps take less time and memory, and
///     hide less; 0 for 1.
/// @param buffer Is given a buffer, to be destroyed by antumbra_occlusion_buffer_destroy; NULL if there is an error.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the size, the scale or the camera is none.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_create(
    width: u32,
    height: u32,
    map_scale: u32,
    camera: Option<&AntumbraCamera>,
    buffer: Option<&mut MaybeUninit<Option<Box<AntumbraOcclusionBuffer>>>>,
) -> AntumbraStatus {
    guard(|| {
        let place = empty(buffer, "buffer")?;
        let size = PictureSize::new(width, height)?;
        let scale = self::map_scale(map_scale)?.unwrap_or(MapScale::Full);
        let camera = required(camera, "camera")?.checked()?;
        let state = State {
            buffer: OcclusionBuffer::with_map_scale(size, camera, scale),
            size,
            stage: Stage::Cleared,
        };
        *place = Some(Box::new(AntumbraOcclusionBuffer(Locked::new(state))));
        Ok(())
    })
}

/// Ends a buffer. NULL is fine. Not to be called while another call has the buffer.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_destroy(buffer: Option<Box<AntumbraOcclusionBuffer>>) {
    drop(buffer);
}

/// Sets what may be lost, before anything is drawn.
///
/// @param approximation NULL for exact accuracy, as at first.
///
/// Errors: ANTUMBRA_ERROR_STATE if something has been drawn since the last antumbra_occlusion_buffer_clear,
/// ANTUMBRA_ERROR_INVALID_ARGUMENT, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_set_approximation(
    buffer: *mut AntumbraOcclusionBuffer,
    approximation: Option<&AntumbraApproximation>,
) -> AntumbraStatus {
    guard(|| {
        let mut state = handle(buffer, "buffer")?.0.write()?;
        if state.stage != Stage::Cleared {
            return Err(Error::state(
                "accuracy has to be set before anything is drawn: call antumbra_occlusion_buffer_clear first",
            ));
        }
        let accuracy = match approximation {
            None => Accuracy::Exact,
            Some(approximation) => Accuracy::Approximate(approximation.checked()?),
        };
        state.buffer.set_accuracy(accuracy);
        Ok(())
    })
}

/// Chooses the instruction set, an AntumbraLevel. Answers are the same for any.
///
/// Errors: ANTUMBRA_ERROR_LEVEL, ANTUMBRA_ERROR_INVALID_ARGUMENT, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_set_level(
    buffer: *mut AntumbraOcclusionBuffer,
    level: u32,
) -> AntumbraStatus {
    guard(|| {
        let level = self::level(level)?;
        handle(buffer, "buffer")?.0.write()?.buffer.set_level(level);
        Ok(())
    })
}

/// Forgets all that was drawn and begins a frame.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if the camera is none, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_clear(
    buffer: *mut AntumbraOcclusionBuffer,
    camera: Option<&AntumbraCamera>,
) -> AntumbraStatus {
    guard(|| {
        let mut state = handle(buffer, "buffer")?.0.write()?;
        let camera = required(camera, "camera")?.checked()?;
        state.buffer.clear(&camera);
        state.stage = Stage::Cleared;
        Ok(())
    })
}

/// Draws an opaque occluder.
///
/// Errors: ANTUMBRA_ERROR_STATE after antumbra_occlusion_buffer_finish, ANTUMBRA_ERROR_OUT_OF_RANGE if an index has no vertex,
/// ANTUMBRA_ERROR_INVALID_ARGUMENT, ANTUMBRA_ERROR_BUSY. Nothing is drawn then.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_draw(
    buffer: *mut AntumbraOcclusionBuffer,
    occluder: Option<&AntumbraOccluder>,
) -> AntumbraStatus {
    guard(|| {
        let mut state = handle(buffer, "buffer")?.0.write()?;
        let occluder = required(occluder, "occluder")?.checked()?;
        state.draws()?.draw(&occluder);
        Ok(())
    })
}

/// Draws an occluder that lets light through. Several of them combine, and where what they let through may be ignored, what is
/// behind the farthest of them is hidden. Where accuracy is exact, this does nothing.
///
/// @param opacity From 0, all light passes, to 1.
///
/// Errors: as antumbra_occlusion_buffer_draw.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_draw_translucent(
    buffer: *mut AntumbraOcclusionBuffer,
    occluder: Option<&AntumbraOccluder>,
    opacity: f32,
) -> AntumbraStatus {
    guard(|| {
        let mut state = handle(buffer, "buffer")?.0.write()?;
        let occluder = required(occluder, "occluder")?.checked()?;
        let opacity = within(opacity, 0.0..=1.0, "opacity")?;
        state.draws()?.draw_translucent(&occluder, opacity);
        Ok(())
    })
}

/// Ends drawing: covers the holes that may be ignored. To end it again changes nothing.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_finish(
    buffer: *mut AntumbraOcclusionBuffer,
) -> AntumbraStatus {
    guard(|| {
        let mut state = handle(buffer, "buffer")?.0.write()?;
        if state.stage != Stage::Finished {
            state.buffer.finish();
            state.stage = Stage::Finished;
        }
        Ok(())
    })
}

/// Asks whether world boxes are hidden. One call with many boxes is quicker than many calls.
///
/// @param boxes, visibilities count of each; they must not overlap. A box that reaches the near plane, or is not finite, is
///     visible.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_test_boxes(
    buffer: Option<&AntumbraOcclusionBuffer>,
    boxes: *const AntumbraBox,
    count: usize,
    visibilities: *mut AntumbraVisibility,
) -> AntumbraStatus {
    guard(|| {
        let state = required(buffer, "buffer")?.0.read()?;
        let (boxes, room) = questions_and_room(boxes, count, visibilities, "boxes")?;
        test_boxes(&state.buffer, boxes, room);
        Ok(())
    })
}

/// Asks whether boxes with any orientation are hidden.
///
/// @param boxes, visibilities count of each; they must not overlap. A box that reaches the near plane, or is not finite, is
///     visible.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_test_oriented_boxes(
    buffer: Option<&AntumbraOcclusionBuffer>,
    boxes: *const AntumbraOrientedBox,
    count: usize,
    visibilities: *mut AntumbraVisibility,
) -> AntumbraStatus {
    guard(|| {
        let state = required(buffer, "buffer")?.0.read()?;
        let (boxes, room) = questions_and_room(boxes, count, visibilities, "boxes")?;
        for (bounds, answer) in boxes.iter().zip(room) {
            answer.write(state.buffer.test_oriented_box(&bounds.into()).into());
        }
        Ok(())
    })
}

/// Asks whether a ball is hidden.
///
/// @param center Three numbers, world coordinates. A ball that reaches the near plane, or is not finite, is visible.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_test_sphere(
    buffer: Option<&AntumbraOcclusionBuffer>,
    center: *const f64,
    radius: f64,
    visibility: Option<&mut MaybeUninit<AntumbraVisibility>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(visibility, "visibility")?;
        let state = required(buffer, "buffer")?.0.read()?;
        let center = vector(center, "center")?;
        place.write(state.buffer.test_sphere(&Sphere { center, radius }).into());
        Ok(())
    })
}

/// Asks whether something is hidden of which only a rectangle on screen is known.
///
/// @param x, y First and last column and row, two numbers each, in pixels from the upper left corner of the picture, fractions
///     allowed.
/// @param nearest_distance Of its nearest point along the view, scene units. What is not in order or not beyond the near plane is
///     visible.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_test_rectangle(
    buffer: Option<&AntumbraOcclusionBuffer>,
    x: *const f64,
    y: *const f64,
    nearest_distance: f64,
    visibility: Option<&mut MaybeUninit<AntumbraVisibility>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(visibility, "visibility")?;
        let state = required(buffer, "buffer")?.0.read()?;
        let (x, y) = (list(x, 2, "x")?, list(y, 2, "y")?);
        let (x, y) = ([x[0], x[1]], [y[0], y[1]]);
        place.write(state.buffer.test_rectangle(x, y, nearest_distance).into());
        Ok(())
    })
}

/// Copies the depth of what is drawn so far, pixel by pixel, row by row from the upper left corner: no pixel's occluder is
/// farther than that. Depths are the larger the nearer; see AntumbraProjectionKind. Where nothing is drawn it is -INFINITY.
///
/// @param depths Room for count numbers, which must be width * height.
///
/// Errors: ANTUMBRA_ERROR_INVALID_ARGUMENT if count is another number, ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_read_depth(
    buffer: Option<&AntumbraOcclusionBuffer>,
    depths: *mut f32,
    count: usize,
) -> AntumbraStatus {
    guard(|| {
        let state = required(buffer, "buffer")?.0.read()?;
        let (width, height) = (state.size.width(), state.size.height());
        if count != width * height {
            return Err(Error::invalid(format_args!(
                "there is room for {count} depths, but {width} x {height} pixels"
            )));
        }
        let room = room(depths, count, "depths")?;
        for (y, row) in room.chunks_exact_mut(width).enumerate() {
            for (x, place) in row.iter_mut().enumerate() {
                place.write(state.buffer.pixel(x, y).unwrap_or(f32::NEG_INFINITY));
            }
        }
        Ok(())
    })
}

/// A hash of what is drawn so far, coverage and depths: the same on every machine.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_hash(
    buffer: Option<&AntumbraOcclusionBuffer>,
    hash: Option<&mut MaybeUninit<u64>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(hash, "hash")?;
        let state = required(buffer, "buffer")?.0.read()?;
        place.write(state.buffer.tiles().hash());
        Ok(())
    })
}

/// How many pixels of the picture are ignored because accuracy is approximate: no other pixel can be wrong, if the map is as
/// large as the picture or the distribution factor is 1.
///
/// Errors: ANTUMBRA_ERROR_BUSY.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_occlusion_buffer_ignored_pixels(
    buffer: Option<&AntumbraOcclusionBuffer>,
    pixels: Option<&mut MaybeUninit<u64>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(pixels, "pixels")?;
        let state = required(buffer, "buffer")?.0.read()?;
        place.write(state.buffer.ignored_pixels());
        Ok(())
    })
}
