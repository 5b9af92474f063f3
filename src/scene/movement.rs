//! Objects that move.

use glam::DAffine3;

use super::validate::{check_placement, object_label};
use super::{Scene, SceneError};

/// Where an object goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// The object: an index into [`Scene::objects`].
    pub object: u32,
    /// From its mesh's local coordinates to the world's, from now on.
    pub world_from_local: DAffine3,
    /// Whether its box is to hold it where it was as well, for who draws it in between: a picture that is late, or blurred by
    /// motion. Until its next move it hides nothing then, since nobody knows where it is.
    pub swept: bool,
}

/// What moving did to the hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moved {
    /// Its boxes fit.
    Refitted,
    /// It is another one.
    Rebuilt,
}

impl Scene {
    /// Moves objects. Their boxes are those of the scene as if it had been made so, except that the vertices of a mesh with more than
    /// 1,024 of them are bounded by their local box.
    ///
    /// The hierarchy keeps its shape and its boxes are fitted, from the moved objects upwards, until they have become twice as
    /// large together as they were; then it is built again, which takes 3 ms for 10,000 objects.
    ///
    /// # Errors
    /// If there is no such object, or a matrix is not finite or leads beyond [`MAX_COORDINATE`](super::MAX_COORDINATE). Nothing
    /// has moved then.
    pub fn move_objects(&mut self, moves: &[Move]) -> Result<(), SceneError> {
        self.check_moves(moves)?;
        self.apply(moves);
        Ok(())
    }

    /// Whether all objects can go where they are to.
    pub(crate) fn check_moves(&self, moves: &[Move]) -> Result<(), SceneError> {
        for to in moves {
            let Some(object) = self.objects.get(to.object as usize) else {
                return Err(SceneError::Invalid {
                    file: None,
                    object: format!("object {}", to.object),
                    cause: format!("there are {} objects", self.objects.len()),
                });
            };
            let place = &to.world_from_local;
            check_placement(place)
                .and_then(|()| self.boxes.check_place(object.mesh, place))
                .map_err(|cause| SceneError::Invalid {
                    file: None,
                    object: object_label(to.object as usize, object),
                    cause,
                })?;
        }
        Ok(())
    }

    /// Moves objects that can be moved so.
    pub(crate) fn apply(&mut self, moves: &[Move]) -> Moved {
        for to in moves {
            let index = to.object as usize;
            let object = &mut self.objects[index];
            let mesh = &self.meshes[object.mesh];
            let box_at = |place| self.boxes.moved(mesh, object.mesh, place);
            let there = box_at(&to.world_from_local);
            let here = to.swept.then(|| box_at(&object.world_from_local));
            object.world_from_local = to.world_from_local;
            let was_swept = self.swept.binary_search_by_key(&to.object, |&(o, _)| o);
            match (was_swept, to.swept) {
                (Err(place), true) => {
                    self.swept.insert(place, (to.object, object.never_occlude));
                    object.never_occlude = true;
                }
                (Ok(place), false) => object.never_occlude = self.swept.remove(place).1,
                _ => {}
            }
            match here {
                Some(here) => self.boxes.set_swept(index, here.union(there)),
                None => self.boxes.set(index, object, there),
            }
            self.bvh.refit(to.object, &self.boxes.world);
        }
        if self.bvh.is_worn() {
            self.bvh = super::Bvh::over(&self.boxes.world);
            return Moved::Rebuilt;
        }
        Moved::Refitted
    }
}
