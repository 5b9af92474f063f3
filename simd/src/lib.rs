//! The hot loops of the antumbra occlusion culling runtime, one file per loop.
//!
//! The plain scalar form of each loop stands here and **defines** it: a vector form has to give the same bits. All
//! arithmetic is IEEE-754 additions, subtractions, multiplications, divisions, comparisons and roundings, and exact
//! integers; nothing is fused and nothing is approximated, so the same input gives the same bits on any machine.
//!
//! The loops, in the order of a frame:
//!
//! | file | what it does |
//! |---|---|
//! | [`vertex`] | transforms positions and snaps them to 1/256 of a pixel |
//! | [`triangle`] | sets a snapped triangle up: exact edge functions and a depth plane |
//! | [`quad`] | two triangles that share a diagonal, as one |
//! | [`assemble`] | all of these for a cluster: its vertices (`project`), what needs no set-up (`reject`), and the rest (`set_up`: `planes` and `crossings`) |
//! | [`coverage`] | which of a tile's 64 pixel centres a triangle covers |
//! | [`spans`] | a polygon's edges solved for x: an interval of columns for each row |
//! | [`part_depth`] | a polygon's depth over the parts of tiles |
//! | [`tile`] | merges a polygon into a tile's coverage and depth |
//! | [`fill`] | fills polygons into rows of tiles: finds their strips of eight rows, and merges them (`merge`) |
//! | [`small`] | finds the strips of small polygons, eight at once |
//! | [`pyramid`] | averages four cells of an occlusion map into one |
//! | [`boxes`] | projects boxes to rectangles of samples, eight at once |
//! | [`query`] | asks whether a rectangle lies behind what tiles show |
//! | [`blocks`] | what blocks of tiles hide as a whole, for the sake of large rectangles |
//! | [`glance`] | looks at a box through one sample |
//! | [`tree`] | which leaves of a tree of boxes the ray through a sample may enter |
//! | [`pierce`] | what the ray through a sample meets of a cluster |
//! | [`covering`] | which of many rectangles hold a sample and may hide what is there |
//! | [`bounds`] | projects the corners of boxes to the screen |
//! | [`projected`] | a box on screen: its outline and its faces |
//! | [`outline`] | the samples inside a box's outline, and whether they are covered |
//! | [`faces`] | the nearest depth of a box over tile parts, and whether it is farther than theirs |
//! | [`closer`] | asks both of these of a box, whole parts first (`part_bounds`) |

pub mod assemble;
pub mod blocks;
pub mod bounds;
pub mod boxes;
pub mod closer;
pub mod coverage;
pub mod covering;
mod crossings;
pub mod faces;
pub mod fill;
pub mod glance;
mod level;
mod merge;
mod order;
pub mod outline;
mod part_bounds;
pub mod part_depth;
pub mod pierce;
mod planes;
mod project;
pub mod projected;
pub mod pyramid;
pub mod quad;
pub mod query;
mod reject;
mod set_up;
pub mod small;
pub mod spans;
mod strip_masks;
pub mod tile;
pub mod tree;
pub mod triangle;
pub mod vertex;

pub use level::{Level, LevelUnavailable};

/// Sub-pixel positions in one pixel along an axis: coordinates are 24.8 fixed point.
pub const SUBPIXELS: i32 = 256;

/// Pixels along the edge of a tile.
pub const TILE_SIZE: i32 = 8;

/// Depth is kept for parts of a tile as wide as the tile and this many pixels high.
pub const PART_HEIGHT: i32 = 4;

/// Depth parts in a tile, from the upper to the lower.
pub const PARTS_PER_TILE: usize = 2;

/// Vertices farther than this many sub-pixels from the picture's corner are clipped: 2^15 pixels.
pub const GUARD_BAND: i32 = (1 << 15) * SUBPIXELS;

// Two parts' masks are read as the halves of a tile's word.
const _: () = assert!(cfg!(target_endian = "little"));
const _: () = assert!(PARTS_PER_TILE as i32 * PART_HEIGHT == TILE_SIZE);
