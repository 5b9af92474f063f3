//! How to cull: a struct that can grow.
//!
//! Its first field is its size as the program was compiled, so that later versions of the library know which fields there are. Of a
//! program that is newer than the library, fields that this does not know must be 0: what `antumbra_settings_init` left there.

use std::mem::MaybeUninit;
use std::num::NonZeroU32;
use std::time::Duration;

use antumbra::cull::{Effort, Prices, Settings};
use antumbra::occluders::{Budget, FramesBack, Selection, Weighing};
use antumbra::occlusion::{Accuracy, Approximation, DepthRepresentation, MOST_NTH};
use antumbra::prepare::StaticCriteria;
use antumbra::view::{MapScale, PictureSize, Slack};
use bytemuck::{Pod, Zeroable, bytes_of, bytes_of_mut};

use crate::arguments::{chosen, required, within};
use crate::borrow::{list, room};
use crate::level::level;
use crate::status::AntumbraStatus::ANTUMBRA_ERROR_STRUCT_SIZE;
use crate::status::{AntumbraStatus, Error, guard};

/// What may be lost.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraAccuracy {
    /// Nothing that owns a pixel is ever culled.
    ANTUMBRA_EXACT = 0,
    /// Small holes between occluders are ignored, and what shows only through them is culled: see AntumbraApproximation.
    ANTUMBRA_APPROXIMATE = 1,
}

/// How occluders are chosen.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraSelection {
    /// The clusters that the frames before needed, and what closes the gaps between them.
    ANTUMBRA_SELECT_CONTRIBUTION = 0,
    /// The nearest objects.
    ANTUMBRA_SELECT_NEAREST = 1,
    /// Those that begin nearest along the view.
    ANTUMBRA_SELECT_Z_PLANE = 2,
    /// Those that look largest.
    ANTUMBRA_SELECT_SOLID_ANGLE = 3,
    /// Those that fill their boxes, are large, near and turned towards the eye.
    ANTUMBRA_SELECT_WEIGHT = 4,
    /// Of those that were visible in the last frame or the one before, the nearest.
    ANTUMBRA_SELECT_PREVIOUS_VISIBLE = 5,
    /// The nearest of those and of what has entered the frustum.
    ANTUMBRA_SELECT_COHERENT = 6,
    /// The clusters that are seen from the nearest viewpoint of a grid, if the scene is from an archive that has one.
    ANTUMBRA_SELECT_SAMPLED = 7,
}

/// How many triangles may be drawn as occluders in a frame.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraBudget {
    /// As many as pay, by counted work: the same on any machine.
    ANTUMBRA_BUDGET_AUTO = 0,
    /// Every candidate's.
    ANTUMBRA_BUDGET_ALL = 1,
    /// At most AntumbraSettings.budget_amount.
    ANTUMBRA_BUDGET_TRIANGLES = 2,
    /// As many as pay, until AntumbraSettings.budget_amount nanoseconds have gone by since the frame began. This is the one setting by which
    /// a result depends on the machine: how much is culled, never whether that is right.
    ANTUMBRA_BUDGET_TIME = 3,
}

/// What is kept of the depth of occluders.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraDepth {
    /// The depth of the nearest surfaces in each half of a tile.
    ANTUMBRA_DEPTH_NO_BACKGROUND = 0,
    /// The farthest depth of all that is drawn.
    ANTUMBRA_DEPTH_PLANE = 1,
    /// The farthest depth in each of 64x64 cells.
    ANTUMBRA_DEPTH_ESTIMATION = 2,
    /// A Z-buffer under a pyramid of farthest values: see AntumbraSettings.nth.
    ANTUMBRA_DEPTH_HIERARCHICAL = 3,
}

/// What makes objects unfit to be occluders, whatever the eye sees of them.
#[repr(C)]
#[allow(non_camel_case_types, reason = "these are the names in C")]
pub enum AntumbraStaticCriteria {
    /// They are small.
    ANTUMBRA_UNFIT_BY_SIZE = 1,
    /// They reach far through the scene, or are drawn out.
    ANTUMBRA_UNFIT_BY_LOCALITY = 2,
    /// They have many triangles for what they can cover.
    ANTUMBRA_UNFIT_BY_COMPLEXITY = 4,
    /// They are attached to something larger that covers them.
    ANTUMBRA_UNFIT_BY_REDUNDANCY = 8,
}

use AntumbraAccuracy::*;
use AntumbraBudget::*;
use AntumbraDepth::*;
use AntumbraSelection::*;
use AntumbraStaticCriteria::*;

/// Which holes are ignored where accuracy is approximate. antumbra_settings_init fills in the defaults.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct AntumbraApproximation {
    /// So many uncovered pixels of the picture are ignored in any window of a base cell's size.
    pub hole: u32,
    /// Base cells are 8 * 2^base_level pixels wide, from 0 to 12. Of finer cells nothing is ignored.
    pub base_level: u32,
    /// The coarsest level whose cells are looked at, from 0 to 255.
    pub coarsest_level: u32,
    /// 0.
    pub reserved: u32,
    /// From 1, where the hole's size is a promise, to 4: how favourably holes are assumed to be distributed.
    pub distribution: f64,
    /// From 0 to 1: such a share of a base cell's pixels may be covered, and what is behind it is visible without a closer look.
    pub transparency: f64,
}

/// How to cull. antumbra_settings_init fills in the defaults; then width and height have to be set.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct AntumbraSettings {
    /// sizeof(AntumbraSettings), set by antumbra_settings_init.
    pub struct_size: u64,
    /// Of the picture, in pixels: from 1 to 16384, any number.
    pub width: u32,
    /// Of the picture, in pixels: from 1 to 16384, any number.
    pub height: u32,
    /// An AntumbraAccuracy.
    pub accuracy: u32,
    /// 0 or 1: whether translucent surfaces are occluders too, whose opacities combine, where accuracy is approximate.
    pub translucent: u32,
    /// Which holes are ignored where accuracy is approximate.
    pub approximation: AntumbraApproximation,
    /// Pixels of the picture along the edge of the occlusion map's: 1, 2 or 4; 0 for what goes well with the accuracy: 1 where it is exact,
    /// and 4 where it is approximate. Exact accuracy is exact with any.
    pub map_scale: u32,
    /// An AntumbraSelection.
    pub selection: u32,
    /// An AntumbraBudget.
    pub budget: u32,
    /// Where selection is by contribution: passes of a frame at the most; 0 for as many as pay.
    pub most_passes: u32,
    /// Triangles or nanoseconds, where the budget is one of those.
    pub budget_amount: u64,
    /// AntumbraStaticCriteria, added up; by contribution nothing makes objects unfit.
    pub static_criteria: u32,
    /// Where selection is by what was visible: in which frame, 1 for the last one or 2 for the one before it.
    pub frames_back: u32,
    /// Where selection is by weight: objects that fill their boxes less are no occluders, from 0 to 1.
    pub least_compactness: f32,
    /// Where selection is by weight: objects that are drawn at the most; 0 for as many as the budget allows.
    pub most_active: u32,
    /// An AntumbraDepth. With another one than the default, occluders are drawn first, nearest first if they are to be chosen by
    /// contribution, and all objects are asked after. With a map that is coarser than the picture it is the default one.
    pub depth: u32,
    /// Where depth is hierarchical and accuracy approximate: the nth farthest value stands for a cell, and nth - 1 samples are
    /// ignored; from 1 to 64.
    pub nth: u32,
    /// Threads to use: 1 is the caller's own; several are the culler's, and the caller waits for them; 0 for as many as the machine runs at
    /// once, up to 1024. The visible set is the same for any number.
    pub threads: u32,
    /// An AntumbraLevel. The visible set is the same for any.
    pub level: u32,
    /// 0 or 1: whether a frame takes from the last one's answer what still holds: all of it where neither the camera nor the scene has
    /// changed, and all but what they touch where a few objects have moved. A budget of time has every frame find out everything.
    pub reuse: u32,
    /// 0 or 1: whether a frame does without occlusion where looking for what is hidden costs more than drawing it, and does not ask about
    /// objects that cost less to draw. Only where selection is by contribution.
    pub skip: u32,
    /// What it costs to draw an object, without its triangles, in nanoseconds: a draw call. Not negative.
    pub object_price_ns: f64,
    /// What it costs to draw a triangle, in nanoseconds. Not negative.
    pub triangle_price_ns: f64,
    /// How far the final pass may draw beside where this library would, so that culling is exact for it too: in pixels of the picture, from
    /// 0 to 4. 0 for a picture by this library; 0.125 for a graphics processor with one sample in the middle of each pixel, and 1
    /// where samples may lie anywhere in it (docs/gpu.md).
    pub slack_pixels: f64,
    /// Likewise how far off its positions may be, as a share of their distance, from 0 to 0.5: 4.76837158203125e-7 for 32-bit floats.
    pub slack_position: f64,
    /// Likewise how far off its depths may be, as a share of the depth buffer's range, from 0 to 1: 2.384185791015625e-7 for 24 bits.
    pub slack_depth: f64,
}

/// No version will have more bytes of settings: what says so was never initialised.
const LARGEST: u64 = 1 << 16;

/// The most threads that can be asked for.
pub(crate) const MOST_THREADS: u32 = 1024;

const ACCURACIES: [(u32, bool); 2] = [
    (ANTUMBRA_EXACT as u32, true),
    (ANTUMBRA_APPROXIMATE as u32, false),
];

const SELECTIONS: [(u32, Selection); 8] = [
    (ANTUMBRA_SELECT_CONTRIBUTION as u32, Selection::Contribution),
    (ANTUMBRA_SELECT_NEAREST as u32, Selection::Nearest),
    (ANTUMBRA_SELECT_Z_PLANE as u32, Selection::ZPlane),
    (ANTUMBRA_SELECT_SOLID_ANGLE as u32, Selection::SolidAngle),
    (ANTUMBRA_SELECT_WEIGHT as u32, Selection::Weight),
    (
        ANTUMBRA_SELECT_PREVIOUS_VISIBLE as u32,
        Selection::PreviousVisible,
    ),
    (ANTUMBRA_SELECT_COHERENT as u32, Selection::Coherent),
    (ANTUMBRA_SELECT_SAMPLED as u32, Selection::Sampled),
];

const DEPTHS: [(u32, DepthRepresentation); 4] = [
    (
        ANTUMBRA_DEPTH_NO_BACKGROUND as u32,
        DepthRepresentation::NoBackground,
    ),
    (ANTUMBRA_DEPTH_PLANE as u32, DepthRepresentation::Plane),
    (
        ANTUMBRA_DEPTH_ESTIMATION as u32,
        DepthRepresentation::Estimation,
    ),
    (
        ANTUMBRA_DEPTH_HIERARCHICAL as u32,
        DepthRepresentation::HIERARCHICAL,
    ),
];

const MAP_SCALES: [(u32, Option<MapScale>); 4] = [
    (0, None),
    (1, Some(MapScale::Full)),
    (2, Some(MapScale::Half)),
    (4, Some(MapScale::Quarter)),
];

/// The scale of a map; none for what goes well with the accuracy.
pub fn map_scale(pixels: u32) -> Result<Option<MapScale>, Error> {
    chosen(pixels, &MAP_SCALES, "map_scale")
}

impl AntumbraApproximation {
    fn of(approximation: &Approximation) -> AntumbraApproximation {
        AntumbraApproximation {
            hole: approximation.hole,
            base_level: approximation.base_level.into(),
            coarsest_level: approximation.coarsest_level.into(),
            reserved: 0,
            distribution: approximation.distribution,
            transparency: approximation.transparency,
        }
    }

    pub fn checked(&self) -> Result<Approximation, Error> {
        within(self.reserved, 0..=0, "approximation.reserved")?;
        Ok(Approximation {
            hole: self.hole,
            base_level: within(self.base_level, 0..=12, "base_level")? as u8,
            coarsest_level: within(self.coarsest_level, 0..=255, "coarsest_level")? as u8,
            distribution: within(self.distribution, 1.0..=4.0, "distribution")?,
            transparency: within(self.transparency, 0.0..=1.0, "transparency")?,
        })
    }
}

impl AntumbraSettings {
    fn defaults() -> AntumbraSettings {
        AntumbraSettings {
            struct_size: size_of::<AntumbraSettings>() as u64,
            approximation: AntumbraApproximation::of(&Approximation::default()),
            frames_back: FramesBack::default().count(),
            least_compactness: Weighing::default().least_compactness,
            nth: 1,
            reuse: 1,
            skip: 1,
            object_price_ns: Prices::default().object,
            triangle_price_ns: Prices::default().triangle,
            ..AntumbraSettings::zeroed()
        }
    }

    /// Reads a caller's settings, as far as this version knows them.
    pub fn read(settings: *const AntumbraSettings) -> Result<Settings, Error> {
        let size = list(settings.cast::<u64>(), 1, "settings")?[0];
        // The only size so far.
        let known = size_of::<AntumbraSettings>();
        let refuse = |why: &str| {
            let message = format_args!("settings are {size} bytes: {why}");
            Err(Error::new(ANTUMBRA_ERROR_STRUCT_SIZE, message))
        };
        if !(known as u64..=LARGEST).contains(&size) {
            return refuse("use antumbra_settings_init, and give it sizeof(AntumbraSettings)");
        }
        let bytes = list(settings.cast::<u8>(), size as usize, "settings")?;
        if bytes[known..].iter().any(|byte| *byte != 0) {
            return refuse("they have fields that this version of the library does not know");
        }
        let mut read = AntumbraSettings::zeroed();
        bytes_of_mut(&mut read).copy_from_slice(&bytes[..known]);
        read.checked()
    }

    fn budget(&self) -> Result<Budget, Error> {
        let budgets = [
            (ANTUMBRA_BUDGET_AUTO as u32, Budget::Auto),
            (ANTUMBRA_BUDGET_ALL as u32, Budget::All),
            (
                ANTUMBRA_BUDGET_TRIANGLES as u32,
                Budget::Triangles(self.budget_amount),
            ),
            (
                ANTUMBRA_BUDGET_TIME as u32,
                Budget::Time(Duration::from_nanos(self.budget_amount)),
            ),
        ];
        chosen(self.budget, &budgets, "budget")
    }

    fn depth(&self) -> Result<DepthRepresentation, Error> {
        let nth = within(self.nth, 1..=MOST_NTH, "nth")?;
        Ok(match chosen(self.depth, &DEPTHS, "depth")? {
            DepthRepresentation::Hierarchical { .. } => DepthRepresentation::Hierarchical {
                nth: NonZeroU32::new(nth).unwrap_or(NonZeroU32::MIN),
            },
            depth => depth,
        })
    }

    fn static_criteria(&self) -> Result<StaticCriteria, Error> {
        within(self.static_criteria, 0..=15, "static_criteria")?;
        let has = |criterion: AntumbraStaticCriteria| self.static_criteria & criterion as u32 != 0;
        Ok(StaticCriteria {
            size: has(ANTUMBRA_UNFIT_BY_SIZE),
            locality: has(ANTUMBRA_UNFIT_BY_LOCALITY),
            complexity: has(ANTUMBRA_UNFIT_BY_COMPLEXITY),
            redundancy: has(ANTUMBRA_UNFIT_BY_REDUNDANCY),
        })
    }

    fn checked(&self) -> Result<Settings, Error> {
        let approximation = self.approximation.checked()?;
        let accuracy = match chosen(self.accuracy, &ACCURACIES, "accuracy")? {
            true => Accuracy::Exact,
            false => Accuracy::Approximate(approximation),
        };
        let flags = [(0, false), (1, true)];
        let backs = [FramesBack::One, FramesBack::Two].map(|back| (back.count(), back));
        let or_all = |most: u32| NonZeroU32::new(most).map(NonZeroU32::get);
        Ok(Settings {
            size: PictureSize::new(self.width, self.height)?,
            accuracy,
            translucent: chosen(self.translucent, &flags, "translucent")?,
            map_scale: map_scale(self.map_scale)?.unwrap_or(accuracy.map_scale()),
            slack: Slack::new(self.slack_pixels, self.slack_position, self.slack_depth)?,
            depth: self.depth()?,
            occluders: chosen(self.selection, &SELECTIONS, "selection")?,
            budget: self.budget()?,
            static_criteria: self.static_criteria()?,
            weighing: Weighing {
                least_compactness: within(self.least_compactness, 0.0..=1.0, "least_compactness")?,
                most_active: or_all(self.most_active),
            },
            frames_back: chosen(self.frames_back, &backs, "frames_back")?,
            most_passes: or_all(self.most_passes).unwrap_or(u32::MAX),
            threads: within(self.threads, 0..=MOST_THREADS, "threads")? as usize,
            level: level(self.level)?,
            effort: Effort {
                reuse: chosen(self.reuse, &flags, "reuse")?,
                skip: chosen(self.skip, &flags, "skip")?,
                prices: Prices {
                    object: within(self.object_price_ns, 0.0..=1e18, "object_price_ns")?,
                    triangle: within(self.triangle_price_ns, 0.0..=1e18, "triangle_price_ns")?,
                },
            },
        })
    }
}

/// Fills in the defaults: exact, by contribution, with a budget chosen by counted work, on all threads, at the best level. What
/// remains to be set are width and height.
///
/// @param struct_size sizeof(AntumbraSettings).
///
/// Errors: ANTUMBRA_ERROR_STRUCT_SIZE.
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_settings_init(
    settings: *mut AntumbraSettings,
    struct_size: usize,
) -> AntumbraStatus {
    guard(|| {
        let known = size_of::<AntumbraSettings>();
        if !(known as u64..=LARGEST).contains(&(struct_size as u64)) {
            let message = format_args!("settings have {known} bytes, not {struct_size}");
            return Err(Error::new(ANTUMBRA_ERROR_STRUCT_SIZE, message));
        }
        let defaults = AntumbraSettings {
            struct_size: struct_size as u64,
            ..AntumbraSettings::defaults()
        };
        let rest = std::iter::repeat(&0);
        let bytes = room(settings.cast::<u8>(), struct_size, "settings")?;
        for (place, byte) in bytes.iter_mut().zip(bytes_of(&defaults).iter().chain(rest)) {
            place.write(*byte);
        }
        Ok(())
    })
}

/// Fills in the default approximation: 64 pixels in any window of 8x8, distributed favourably (2).
#[unsafe(no_mangle)]
pub extern "C" fn antumbra_approximation_init(
    approximation: Option<&mut MaybeUninit<AntumbraApproximation>>,
) -> AntumbraStatus {
    guard(|| {
        let place = required(approximation, "approximation")?;
        place.write(AntumbraApproximation::of(&Approximation::default()));
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_those_of_the_library() {
        let mut settings = AntumbraSettings::defaults();
        (settings.width, settings.height) = (1280, 768);
        let size = PictureSize::new(1280, 768).expect("a size");
        let read = AntumbraSettings::read(&settings).expect("settings");
        assert_eq!(read, Settings::new(size));
        settings.accuracy = ANTUMBRA_APPROXIMATE as u32;
        let accuracy = Accuracy::Approximate(Approximation::default());
        let expected = Settings {
            accuracy,
            map_scale: accuracy.map_scale(),
            ..Settings::new(size)
        };
        let read = AntumbraSettings::read(&settings).expect("settings");
        assert_eq!(read, expected);
    }

    /// The struct as a later version may have it.
    #[repr(C)]
    #[derive(Clone, Copy, Pod, Zeroable)]
    struct Grown {
        known: AntumbraSettings,
        more: u64,
    }

    #[test]
    fn a_program_that_is_newer_than_the_library_is_understood() {
        let mut grown = Grown {
            known: AntumbraSettings::zeroed(),
            more: 7,
        };
        let size = size_of::<Grown>();
        let first: *mut Grown = &mut grown;
        assert_eq!(
            antumbra_settings_init(first.cast(), size),
            AntumbraStatus::ANTUMBRA_OK
        );
        assert_eq!((grown.known.struct_size, grown.more), (size as u64, 0));
        (grown.known.width, grown.known.height) = (8, 8);
        let first: *const Grown = &grown;
        assert!(AntumbraSettings::read(first.cast()).is_ok());
        grown.more = 1;
        let first: *const Grown = &grown;
        let error = AntumbraSettings::read(first.cast()).expect_err("an unknown field is set");
        assert_eq!(error.status, ANTUMBRA_ERROR_STRUCT_SIZE);
    }

    #[test]
    fn what_makes_no_sense_is_refused_field_by_field() {
        let wrong: [fn(&mut AntumbraSettings); 26] = [
            |s| s.struct_size = 0,
            |s| s.struct_size -= 8,
            |s| s.struct_size = u64::MAX,
            |s| s.width = 0,
            |s| s.height = 1 << 15,
            |s| s.accuracy = 2,
            |s| s.translucent = 2,
            |s| s.approximation.base_level = 13,
            |s| s.approximation.coarsest_level = 256,
            |s| s.approximation.reserved = 1,
            |s| s.approximation.distribution = f64::NAN,
            |s| s.approximation.transparency = -0.1,
            |s| s.map_scale = 3,
            |s| s.selection = 8,
            |s| s.budget = 4,
            |s| s.static_criteria = 16,
            |s| s.frames_back = 0,
            |s| s.least_compactness = f32::NAN,
            |s| s.depth = 4,
            |s| s.nth = 0,
            |s| s.threads = 1025,
            |s| s.level = 6,
            |s| s.reuse = 2,
            |s| s.skip = 2,
            |s| s.object_price_ns = f64::NAN,
            |s| s.triangle_price_ns = -1.0,
        ];
        for (case, spoil) in wrong.iter().enumerate() {
            let mut settings = AntumbraSettings::defaults();
            (settings.width, settings.height) = (640, 480);
            assert!(AntumbraSettings::read(&settings).is_ok());
            spoil(&mut settings);
            assert!(AntumbraSettings::read(&settings).is_err(), "case {case}");
        }
        let none = AntumbraSettings::read(std::ptr::null()).expect_err("there are none");
        assert_eq!(none.status, AntumbraStatus::ANTUMBRA_ERROR_NULL_POINTER);
    }
}
