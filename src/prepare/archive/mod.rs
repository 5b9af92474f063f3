//! The project's own file: a scene and all that was found of it, to be used where it lies.
//!
//! **Problem.** To cluster a scene takes seven times as long as to read it, and every program that culls it would do so
//! again. What is large is therefore written as it lies in memory, and a program that loads the file maps it: positions,
//! triangles, clusters' vertices and quadrilaterals are not copied. What is small is read into its own types.
//!
//! ```text
//!      0 ┌──────────────────────────────────────────────┐
//!        │ "ANTUMBRA"                            8 bytes │
//!        │ version                                  u32  │    all numbers little-endian
//!        │ number of sections                       u32  │
//!        │ length of the file                       u64  │
//!        │ checksum of the header and the table     u64  │    with zeros in its own place
//!     32 ├──────────────────────────────────────────────┤
//!        │ of each section, in the order they lie:       │
//!        │   kind                                   u32  │
//!        │   flags: bit 0, a reader has to know it  u32  │
//!        │   offset                                 u64  │    a multiple of 64
//!        │   length in bytes                        u64  │
//!        │   checksum                               u64  │
//!        ├──────────────────────────────────────────────┤
//!        │ zeros up to a multiple of 64                  │
//!        ├──────────────────────────────────────────────┤
//!        │ a section                                     │
//!        │ zeros up to a multiple of 64                  │    but for the last
//!        │ a section …                                   │
//!        └──────────────────────────────────────────────┘
//! ```
//!
//! | section | a record of | bytes | used in place |
//! |---|---|---|---|
//! | meshes | sizes of all that is a mesh's in the sections below | 64 | |
//! | surfaces | triangles, alpha mode, sides, colour | 32 | |
//! | positions | x, y, z | 12 | yes |
//! | triangles | three indices | 12 | yes |
//! | objects | mesh, proxy, flags, length of the name, matrix | 112 | |
//! | names | UTF-8: of the meshes, then of the objects | | |
//! | hierarchy | first child or first object, number of objects | 8 | |
//! | order | an object, in the order of the leaves | 4 | |
//! | clusters | vertices, triangles, quadrilaterals, flags, axis of the cone | 16 | |
//! | x, y, z of clusters | a coordinate; vertices padded to blocks of 16 | 4 each | yes |
//! | quads of clusters | four indices within the cluster | 4 | yes |
//! | warnings | length, and a sentence in UTF-8; need not be known | | |
//! | visibility | a grid of viewpoints ([`VisibilityGrid`](super::VisibilityGrid)), or nothing; need not be known | | |
//!
//! What is a mesh's own follows what is the last one's, so that sizes suffice and no two can overlap. A section that this
//! version does not know is passed over, or is an error if its flag says that it has to be known.
//!
//! **Invariant.** What loads is as valid as what [`Scene::new`] and [`ClusteredScene::new`] make, whoever wrote the file.
//! Damage is found by the checksums; each byte is covered by one or has to be zero. What a checksum cannot tell is checked
//! one by one: numbers in range and finite, names in UTF-8, the links of the hierarchy. What culling rests on but is quick to find is not
//! even written: boxes of objects, of nodes and of clusters, all of a cone but its axis, the places of clusters. And the
//! clusters hold the triangles of their meshes, see `likeness`.
//!
//! **The file must not change while it is mapped**: whoever writes into it changes a scene under the culler's hands, and
//! whoever shortens it ends the program. [`save`](write::save) does neither: it writes another file and gives it the name.
//! Without the feature `mmap`, or where there are no files to map, the file is read into memory as a whole, and from there
//! on all is the same (`mapping`).
//!
//! [`Scene::new`]: crate::scene::Scene::new
//! [`ClusteredScene::new`]: super::ClusteredScene::new

mod checksum;
mod error;
mod mapping;
mod read;
mod records;
mod table;
mod write;

pub use error::ArchiveError;
pub(super) use read::{is_archive, load};
pub(super) use write::save;

/// What an archive begins with.
const MAGIC: [u8; 8] = *b"ANTUMBRA";

/// The version that is written, and the only one that is read: an archive can always be made again.
const VERSION: u32 = 1;

/// Sections begin at a multiple of this.
const ALIGNMENT: usize = 64;

/// A section's kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    number: u32,
    name: &'static str,
    /// Whether a reader has to know it.
    required: bool,
}

const fn required(number: u32, name: &'static str) -> Kind {
    Kind {
        number,
        name,
        required: true,
    }
}

const MESHES: Kind = required(1, "meshes");
const SURFACES: Kind = required(2, "surfaces");
const POSITIONS: Kind = required(3, "positions");
const TRIANGLES: Kind = required(4, "triangles");
const OBJECTS: Kind = required(5, "objects");
const NAMES: Kind = required(6, "names");
const HIERARCHY: Kind = required(7, "hierarchy");
const ORDER: Kind = required(8, "order");
const CLUSTERS: Kind = required(9, "clusters");
const CLUSTER_X: Kind = required(10, "x of clusters");
const CLUSTER_Y: Kind = required(11, "y of clusters");
const CLUSTER_Z: Kind = required(12, "z of clusters");
const CLUSTER_QUADS: Kind = required(13, "quads of clusters");
const WARNINGS: Kind = Kind {
    number: 14,
    name: "warnings",
    required: false,
};

const VISIBILITY: Kind = Kind {
    number: 15,
    name: "visibility",
    required: false,
};

/// All of them, in the order they are written.
const KINDS: [Kind; 15] = [
    MESHES,
    SURFACES,
    POSITIONS,
    TRIANGLES,
    OBJECTS,
    NAMES,
    HIERARCHY,
    ORDER,
    CLUSTERS,
    CLUSTER_X,
    CLUSTER_Y,
    CLUSTER_Z,
    CLUSTER_QUADS,
    WARNINGS,
    VISIBILITY,
];
