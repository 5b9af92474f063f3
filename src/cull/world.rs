//! What all frames share: the scene, where its objects are now, and what is known of it before any frame.

use std::collections::VecDeque;
use std::sync::Arc;

use super::occluders::Occluders;
use super::traverse::Subtrees;
use super::{Frame, Settings};
use crate::prepare::{Prepared, VisibilityGrid, VisibilityGridError};
use crate::scene::{Aabb, Move, Moved, Scene, SceneError};
use crate::tasks::Tasks;

/// A scene, ready to be culled.
#[derive(Clone, Debug)]
pub struct World {
    pub scene: Arc<Scene>,
    pub occluders: Arc<Occluders>,
    subtrees: Arc<Subtrees>,
    visibility_grid: Option<Arc<VisibilityGrid>>,
    /// Objects that stand out, in scene order, and how much.
    salient: Vec<(u32, f32)>,
    pub changes: Changes,
    /// How many triangles an object has, on average.
    mean_triangles: f64,
}

/// So many moves of objects are noted. Who has missed more has to look at everything again.
const MOST_NOTED: usize = 64;

/// What has changed in the world, so that each view can find out what has since its last frame.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// How many changes there were.
    count: u64,
    /// The last of them, as far as they were moves of objects: which, and the box that it had.
    moves: VecDeque<(u32, Aabb)>,
}

impl Changes {
    /// How many changes there were so far.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The moves since there were `before` changes: objects, and the boxes they had; none if something else has changed, or too much.
    pub fn since(&self, before: u64) -> Option<impl Iterator<Item = &(u32, Aabb)> + Clone> {
        let missed = usize::try_from(self.count - before).ok()?;
        let noted = self.moves.len();
        (missed <= noted).then(|| self.moves.range(noted - missed..))
    }

    /// Notes that an object has left a box.
    fn note(&mut self, object: u32, bounds: Aabb) {
        self.count += 1;
        if self.moves.len() == MOST_NOTED {
            self.moves.pop_front();
        }
        self.moves.push_back((object, bounds));
    }

    /// Notes that something else has changed.
    fn note_all(&mut self) {
        self.count += 1;
        self.moves.clear();
    }
}

impl World {
    /// That of a prepared scene.
    pub fn new(prepared: &Prepared) -> World {
        let scene = prepared.scene().clone();
        World {
            mean_triangles: scene.triangle_count() as f64 / scene.objects().len() as f64,
            subtrees: Arc::new(Subtrees::new(&scene)),
            scene,
            occluders: Arc::new(Occluders::new(prepared)),
            visibility_grid: prepared.visibility_grid().cloned(),
            salient: Vec::new(),
            changes: Changes::default(),
        }
    }

    /// Finds out what settings ask of the scene's objects; `by` does the work.
    pub fn prepare_for(&self, settings: &Settings, by: impl Fn(&(dyn Fn() + Sync))) {
        self.occluders.prepare_for(&self.scene, settings, by);
    }

    /// A frame of this world, as it is.
    pub fn frame_of<'a>(&'a self, settings: &'a Settings, tasks: Tasks<'a>) -> Frame<'a> {
        Frame {
            scene: &self.scene,
            occluders: &self.occluders,
            subtrees: &self.subtrees,
            visibility_grid: self.visibility_grid.as_deref(),
            salient: &self.salient,
            settings,
            price: settings.effort.prices.of(self.mean_triangles),
            tasks,
            ends: None,
            region: None,
        }
    }

    /// The sampled visibility that frames use, if there is any.
    pub fn visibility_grid(&self) -> Option<&Arc<VisibilityGrid>> {
        self.visibility_grid.as_ref()
    }

    /// Gives sampled visibility to the frames.
    pub fn set_visibility_grid(
        &mut self,
        grid: Arc<VisibilityGrid>,
    ) -> Result<(), VisibilityGridError> {
        self.changes.note_all();
        self.visibility_grid = None;
        grid.check_scene(&self.scene, self.occluders.clusters())?;
        self.visibility_grid = Some(grid);
        Ok(())
    }

    /// Says how much an object stands out.
    pub fn set_salience(&mut self, object: u32, salience: f32) {
        assert!((object as usize) < self.scene.objects().len());
        self.changes.note_all();
        let salient = &mut self.salient;
        let place = salient.binary_search_by_key(&object, |&(object, _)| object);
        match place {
            Ok(place) if salience > 0.0 => salient[place].1 = salience,
            Ok(place) => {
                salient.remove(place);
            }
            Err(place) if salience > 0.0 => salient.insert(place, (object, salience)),
            Err(_) => {}
        }
    }

    /// Moves objects.
    pub fn move_objects(&mut self, moves: &[Move]) -> Result<(), SceneError> {
        self.scene.check_moves(moves)?;
        let scene = Arc::make_mut(&mut self.scene);
        for &Move { object, .. } in moves {
            self.changes.note(object, scene.bounds()[object as usize]);
        }
        if scene.apply(moves) == Moved::Rebuilt {
            self.subtrees = Arc::new(Subtrees::new(scene));
            self.changes.note_all();
        }
        Ok(())
    }
}
