//! A scene with what has been found of it, from whatever kind of file.

use std::path::Path;
use std::sync::Arc;

use super::{ArchiveError, ClusteredScene, VisibilityGrid, VisibilityGridError, archive};
use crate::scene::Scene;

/// A scene, and all that is found of it once: what a [`Culler`](crate::cull::Culler) starts from.
///
/// To find it takes seconds for a million triangles, to load it from an archive a fraction of one:
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use antumbra::prepare::Prepared;
/// # use antumbra::scene::{Material, Mesh, Object, Scene, Surface};
/// # let folder = std::env::temp_dir().join(format!("antumbra-prepared-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder)?;
/// # let (scene_file, archive_file) = (folder.join("city.obj"), folder.join("city.antumbra"));
/// # std::fs::write(&scene_file, "o roof\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
///
/// let prepared = Prepared::load(&scene_file)?;
/// prepared.save(&archive_file)?;
///
/// // Later, and as often as you like.
/// let again = Prepared::load(&archive_file)?;
/// assert_eq!(again.occluders(), prepared.occluders());
/// assert_eq!(again.scene().objects()[0].name, "roof");
/// # drop(again);
/// # std::fs::remove_dir_all(&folder)?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Prepared {
    scene: Arc<Scene>,
    occluders: Arc<ClusteredScene>,
    visibility_grid: Option<Arc<VisibilityGrid>>,
}

impl Prepared {
    /// Prepares a scene, with rayon's current threads. The result is the same for any number of them.
    pub fn new(scene: Arc<Scene>) -> Prepared {
        let occluders = Arc::new(ClusteredScene::new(&scene));
        Prepared::of(scene, occluders)
    }

    pub(super) fn of(scene: Arc<Scene>, occluders: Arc<ClusteredScene>) -> Prepared {
        Prepared {
            scene,
            occluders,
            visibility_grid: None,
        }
    }

    /// The same with sampled visibility of the scene.
    ///
    /// # Errors
    /// If the grid names a cluster that the scene does not have.
    pub fn with_visibility_grid(
        self,
        grid: Arc<VisibilityGrid>,
    ) -> Result<Prepared, VisibilityGridError> {
        grid.check_scene(&self.scene, &self.occluders)?;
        Ok(Prepared {
            visibility_grid: Some(grid),
            ..self
        })
    }

    /// Loads an archive that [`Prepared::save`] or `antumbra prepare` wrote, whatever its name; or a scene as
    /// [`Scene::load`] does, which is then prepared.
    ///
    /// An archive is checked, but not found again: with the cargo feature `mmap` it is mapped into memory, and its large
    /// lists are used where they lie. It must not be written into while it is in use; to replace it is fine, as
    /// [`Prepared::save`] does. However the file is damaged, or made to harm, loading it gives an error or a scene that is
    /// valid.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged, is an archive of another version, or is no scene. The error names the file,
    /// the cause, and what to do.
    pub fn load(file: &Path) -> Result<Prepared, ArchiveError> {
        let named_so = file
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("antumbra"));
        if named_so || archive::is_archive(file) {
            return archive::load(file);
        }
        Ok(Prepared::new(Arc::new(Scene::load(file)?)))
    }

    /// Writes an archive, and gives its length in bytes. A file of that name is replaced when all is written, and stays as it
    /// is if that fails.
    ///
    /// The same scene gives the same bytes on every machine.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, file: &Path) -> Result<u64, ArchiveError> {
        archive::save(self, file)
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The clusters of its occluders.
    pub fn occluders(&self) -> &Arc<ClusteredScene> {
        &self.occluders
    }

    /// Its sampled visibility, if somebody had it made.
    pub fn visibility_grid(&self) -> Option<&Arc<VisibilityGrid>> {
        self.visibility_grid.as_ref()
    }
}
