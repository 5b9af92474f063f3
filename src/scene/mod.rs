//! The scene: meshes, the objects that place them in the world, and a hierarchy of bounds over the objects.
//!
//! A mesh is stored once however many objects share it; an object is a placement (HOM §3.2 calls the objects of the
//! hierarchy's leaves the units of culling). A [`Scene`] is valid by construction: every index is in range, every
//! coordinate finite, so that nothing behind this border can fail.

mod array;
mod bounds;
mod bvh;
mod error;
mod gltf;
mod load_budget;
mod movement;
mod obj;
mod validate;
mod warnings;

use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

pub use array::Array;
pub use bounds::{Aabb, OrientedBox, OwnBox};
pub use bvh::{Bvh, BvhNode};
pub use error::SceneError;
pub use movement::Move;
pub(crate) use movement::Moved;
pub use validate::MAX_COORDINATE;

use load_budget::LoadBudget;
use warnings::Warnings;

/// How a surface lets light through; glTF's `alphaMode`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alpha {
    /// Hides what is behind it. The only kind that occludes.
    Opaque,
    /// Cut out by a texture that is not read: drawn as if opaque, but never an occluder.
    Mask,
    /// Translucent: drawn after the opaque surfaces, never an occluder.
    Blend,
}

/// What a surface looks like, as far as culling and the CPU picture need to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// How the surface lets light through.
    pub alpha: Alpha,
    /// Whether both sides are drawn. A single-sided surface is drawn, and occludes, with its front faces only:
    /// those that wind counter-clockwise on screen (clockwise if [`Object::is_mirrored`]).
    pub double_sided: bool,
    /// Base colour, red, green, blue and opacity, linear in 0 to 1.
    pub color: [f32; 4],
}

impl Default for Material {
    fn default() -> Self {
        Material {
            alpha: Alpha::Opaque,
            double_sided: false,
            color: [1.0; 4],
        }
    }
}

impl Material {
    /// Whether a surface of this material hides what is behind it.
    pub fn occludes(&self) -> bool {
        self.alpha == Alpha::Opaque
    }
}

/// A run of a mesh's triangles that share a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Which of [`Mesh::triangles`].
    pub triangles: Range<usize>,
    /// What they look like.
    pub material: Material,
}

/// Geometry in its own local coordinates.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// The mesh's name in its file, or empty.
    pub name: String,
    /// Vertex positions, local units.
    pub positions: Array<[f32; 3]>,
    /// Three indices into `positions` each; counter-clockwise is the front.
    pub triangles: Array<[u32; 3]>,
    /// Runs of `triangles`, in order, that together are all of them.
    pub surfaces: Vec<Surface>,
}

/// One placement of a mesh in the world: the unit that is culled or kept.
#[derive(Clone, Debug)]
pub struct Object {
    /// The object's name in its file, or one made from its place there.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// From the mesh's local coordinates to the world's. May mirror and scale unevenly.
    pub world_from_local: DAffine3,
    /// Always in the visible set while its box meets the frustum.
    pub never_cull: bool,
    /// Never drawn as an occluder.
    pub never_occlude: bool,
    /// A mesh to draw in place of the object's own when it is an occluder, in the same local coordinates. Culling is
    /// exact only if the proxy lies inside the object, whose surface is opaque and closed, and so deep that snapping
    /// (1/256 of a pixel) does not bring its outline out. It is left out where the object's box reaches the near plane:
    /// seen from inside, the surface does not hide it.
    pub occluder_proxy: Option<usize>,
}

/// A whole scene, checked when it is made.
///
/// ```
/// use antumbra::scene::{Material, Mesh, Object, Scene, Surface};
/// use glam::{DAffine3, DVec3};
///
/// let wall = Mesh {
///     name: "wall".to_owned(),
///     positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [0.0, 3.0, 0.0]].into(),
///     triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
///     surfaces: vec![Surface { triangles: 0..2, material: Material::default() }],
/// };
/// // The mesh is stored once, however many objects place it.
/// let placed = |name: &str, x| Object {
///     name: name.to_owned(),
///     mesh: 0,
///     world_from_local: DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)),
///     never_cull: false,
///     never_occlude: false,
///     occluder_proxy: None,
/// };
/// let scene = Scene::new(vec![wall], vec![placed("west", -10.0), placed("east", 10.0)])?;
/// assert_eq!((scene.meshes().len(), scene.triangle_count()), (1, 4));
/// assert!((scene.bounds()[1].center() - DVec3::new(12.0, 1.5, 0.0)).length() < 1e-9);
/// # Ok::<(), antumbra::scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    meshes: Arc<Vec<Mesh>>,
    objects: Vec<Object>,
    /// Objects whose boxes are swept, and whether each never occludes where it stands still.
    swept: Vec<(u32, bool)>,
    boxes: bounds::Boxes,
    bvh: Bvh,
    warnings: Vec<String>,
}

/// What a [`Bvh`] is made of, but for the boxes.
pub(crate) struct Hierarchy {
    /// Of each node, [`BvhNode::first`] and [`BvhNode::count`].
    pub links: Vec<[u32; 2]>,
    /// The objects in the order of the leaves.
    pub objects: Vec<u32>,
}

/// What reads one kind of file: its bytes and the folder it lies in become meshes and objects.
type Loader = fn(
    Vec<u8>,
    &Path,
    &LoadBudget,
    &mut Warnings,
) -> Result<(Vec<Mesh>, Vec<Object>), error::Fault>;

/// A regular file's bytes, `at_most` so many. Devices and pipes are refused: they need not end.
fn read_file(path: &Path, at_most: u64) -> std::io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "it is not a regular file",
        ));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(metadata.len().min(at_most).try_into().unwrap_or(usize::MAX))?;
    file.take(at_most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Whether a placement turns left hands into right ones.
pub(crate) fn is_mirroring(placement: &DAffine3) -> bool {
    placement.matrix3.determinant() < 0.0
}

impl Object {
    /// Whether the placement turns left hands into right ones. A mirrored object's triangles wind the other way in the
    /// world; its front faces are still those that wind counter-clockwise in the mesh (glTF 2.0, §3.7.4).
    pub fn is_mirrored(&self) -> bool {
        is_mirroring(&self.world_from_local)
    }

    /// The mesh to draw for the object when it is an occluder, an index into [`Scene::meshes`]: its proxy, or its own.
    /// None if it never is one.
    pub fn occluder_mesh(&self) -> Option<usize> {
        (!self.never_occlude).then(|| self.occluder_proxy.unwrap_or(self.mesh))
    }
}

impl Scene {
    /// Reads a scene from a file: `.obj`, `.gltf` or `.glb`.
    ///
    /// An object is a glTF node with a mesh, or an OBJ `o` or `g` group. Textures are never read. What the file says
    /// that cannot be used (lines and points, scenes other than the default one) is listed in [`Scene::warnings`].
    /// [`Prepared::load`](crate::prepare::Prepared::load) reads these files and archives too.
    ///
    /// However the file is damaged, loading takes less than ten times its size (with the files it names) plus 64 MiB.
    ///
    /// # Errors
    /// If the file cannot be read, is not of a known kind, is damaged, asks for an extension that is not built in, or
    /// holds no triangle. The error names the file, the object and the cause.
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        let unreadable = |source| SceneError::Read {
            file: path.to_path_buf(),
            source,
        };
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default()
            .to_ascii_lowercase();
        let read: Loader = match extension.as_str() {
            "glb" | "gltf" => gltf::read,
            "obj" => obj::read,
            "antumbra" => {
                return Err(SceneError::Archive {
                    file: path.to_path_buf(),
                });
            }
            _ => {
                return Err(SceneError::UnknownKind {
                    file: path.to_path_buf(),
                });
            }
        };
        let bytes = read_file(path, u64::MAX).map_err(unreadable)?;
        let (budget, mut warnings) = (LoadBudget::default(), Warnings::default());
        budget.has_read(bytes.len() as u64);
        let folder = path.parent().unwrap_or(Path::new(""));
        let (meshes, objects) =
            read(bytes, folder, &budget, &mut warnings).map_err(|fault| fault.in_file(path))?;
        let mut scene = Scene::new(meshes, objects).map_err(|error| error.in_file(path))?;
        scene.warnings = warnings.into_sentences();
        Ok(scene)
    }

    /// Checks and indexes a scene made in memory.
    ///
    /// # Errors
    /// If an index is out of range, a position or a matrix is not finite, a mesh's surfaces are not consecutive runs of
    /// all its triangles, an object's mesh has no triangles or reaches beyond [`MAX_COORDINATE`], or there is no object
    /// at all.
    pub fn new(meshes: Vec<Mesh>, objects: Vec<Object>) -> Result<Scene, SceneError> {
        validate::check(&meshes, &objects)?;
        let boxes = bounds::boxes(&meshes, &objects)?;
        let bvh = Bvh::over(&boxes.world);
        Ok(Scene {
            meshes: Arc::new(meshes),
            objects,
            swept: Vec::new(),
            boxes,
            bvh,
            warnings: Vec::new(),
        })
    }

    /// A scene whose hierarchy is known: checked as any other, but the hierarchy is not built again.
    ///
    /// # Errors
    /// Those of [`Scene::new`], and if the hierarchy is not one over the objects.
    pub(crate) fn restored(
        meshes: Vec<Mesh>,
        objects: Vec<Object>,
        hierarchy: Hierarchy,
        warnings: Vec<String>,
    ) -> Result<Scene, SceneError> {
        validate::check(&meshes, &objects)?;
        let boxes = bounds::boxes(&meshes, &objects)?;
        let bvh = Bvh::relinked(hierarchy.links, hierarchy.objects, &boxes.world);
        let bvh = bvh.map_err(|cause| SceneError::Invalid {
            file: None,
            object: "the hierarchy".to_owned(),
            cause,
        })?;
        Ok(Scene {
            meshes: Arc::new(meshes),
            objects,
            swept: Vec::new(),
            boxes,
            bvh,
            warnings,
        })
    }

    /// The meshes, each stored once.
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// The objects, in the order of their file, which is the order they are drawn in.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The world box of each object, in the order of [`Scene::objects`]. It holds every vertex as any pass computes
    /// it, but for what the eye's own distance from the origin adds.
    pub fn bounds(&self) -> &[Aabb] {
        &self.boxes.world
    }

    /// The box of an object's mesh, placed as the object is, where it is clearly smaller than its world box: the
    /// object is turned.
    pub fn own_box(&self, object: usize) -> Option<OwnBox> {
        self.boxes.own(object, &self.objects[object])
    }

    /// The hierarchy over the objects' world boxes.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// What in the file was understood but could not be used, one sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The triangles of all objects, a shared mesh counted once for each object that places it.
    pub fn triangle_count(&self) -> u64 {
        self.objects
            .iter()
            .map(|o| self.meshes[o.mesh].triangles.len() as u64)
            .sum()
    }
}
