//! What a frame did not do, and why.

use std::fmt;

/// A step that a frame skipped, with its reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Skip {
    /// The whole frame: neither the camera nor anything in the scene has changed since the last one, whose answer holds.
    Everything,
    /// All of the picture but what objects touch that have moved: nothing else has.
    Elsewhere,
    /// Occlusion: what is in the frustum covers too little of the picture to hide much.
    OcclusionLittleCovers,
    /// Occlusion: in the last frames that tried, what was hidden would have cost less to draw than it cost to find.
    OcclusionLittleHidden,
    /// Asking about objects one by one that cost less to draw.
    QuestionsDearerThanDrawing,
    /// The pyramid of occlusion maps: nothing needs it where no hole may be ignored.
    Pyramid,
}

impl Skip {
    /// All there are.
    pub const ALL: [Skip; 6] = [
        Skip::Everything,
        Skip::Elsewhere,
        Skip::OcclusionLittleCovers,
        Skip::OcclusionLittleHidden,
        Skip::QuestionsDearerThanDrawing,
        Skip::Pyramid,
    ];
}

impl fmt::Display for Skip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Skip::Everything => "everything: nothing has moved",
            Skip::Elsewhere => "all but what moved objects touch",
            Skip::OcclusionLittleCovers => "occlusion: little is covered",
            Skip::OcclusionLittleHidden => "occlusion: little was hidden of late",
            Skip::QuestionsDearerThanDrawing => "questions that cost more than drawing",
            Skip::Pyramid => "the pyramid: no hole may be ignored",
        })
    }
}

/// The steps that a frame skipped.
///
/// ```
/// use antumbra::cull::{Skip, Skips};
///
/// let mut skips = Skips::default();
/// skips.add(Skip::Pyramid);
/// assert!(skips.has(Skip::Pyramid) && !skips.has(Skip::Everything));
/// assert_eq!(skips.to_string(), "the pyramid: no hole may be ignored");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skips(u8);

impl Skips {
    /// Adds one.
    pub fn add(&mut self, skip: Skip) {
        self.0 |= 1 << skip as u8;
    }

    /// Whether a step was skipped for that reason.
    pub fn has(self, skip: Skip) -> bool {
        self.0 >> skip as u8 & 1 == 1
    }

    /// Whether occlusion was left out, for whatever reason.
    pub fn has_occlusion(self) -> bool {
        self.has(Skip::OcclusionLittleCovers) || self.has(Skip::OcclusionLittleHidden)
    }

    /// Each of them.
    pub fn iter(self) -> impl Iterator<Item = Skip> {
        Skip::ALL.into_iter().filter(move |&skip| self.has(skip))
    }
}

/// With semicolons between.
impl fmt::Display for Skips {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, skip) in self.iter().enumerate() {
            let between = if i == 0 { "" } else { "; " };
            write!(f, "{between}{skip}")?;
        }
        Ok(())
    }
}
