//! Which objects are fit to be occluders at all, decided once, when a scene is prepared.
//!
//! HOM §7.1 names four criteria, each in a file of its own here: `size`, `locality`, `complexity` and `redundancy`. LOD §5.1 asks how
//! well an object fills its box (`compactness`, by `silhouette`s of its `tight_box`). None of them knows where the eye will be,
//! so none is more than a guess, as the papers say: any object may be a good occluder from somewhere. What is unfit is only not
//! drawn as an occluder. It is asked and culled like everything else.

mod compactness;
mod complexity;
mod locality;
mod redundancy;
mod silhouette;
mod size;
mod tight_box;

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use crate::prepare::ClusteredScene;
use crate::scene::{Aabb, Object, Scene};
use compactness::BoxedMesh;

/// The criteria of HOM §7.1, each on or off: those that are on make objects unfit to be occluders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StaticCriteria {
    /// What is small is unfit.
    pub size: bool,
    /// What reaches far through the scene, or is drawn out, is unfit.
    pub locality: bool,
    /// What has many triangles for what it can cover is unfit.
    pub complexity: bool,
    /// What is attached to something larger that covers it is unfit.
    pub redundancy: bool,
}

impl StaticCriteria {
    /// None of them.
    pub const NONE: StaticCriteria = StaticCriteria {
        size: false,
        locality: false,
        complexity: false,
        redundancy: false,
    };

    /// All of them.
    pub const ALL: StaticCriteria = StaticCriteria {
        size: true,
        locality: true,
        complexity: true,
        redundancy: true,
    };

    /// Each of them alone, and its name on the command line and in reports.
    pub const NAMED: [(&'static str, StaticCriteria); 4] = [
        (
            "size",
            StaticCriteria {
                size: true,
                ..StaticCriteria::NONE
            },
        ),
        (
            "locality",
            StaticCriteria {
                locality: true,
                ..StaticCriteria::NONE
            },
        ),
        (
            "complexity",
            StaticCriteria {
                complexity: true,
                ..StaticCriteria::NONE
            },
        ),
        (
            "redundancy",
            StaticCriteria {
                redundancy: true,
                ..StaticCriteria::NONE
            },
        ),
    ];

    /// These and others.
    pub fn and(self, other: StaticCriteria) -> StaticCriteria {
        StaticCriteria {
            size: self.size || other.size,
            locality: self.locality || other.locality,
            complexity: self.complexity || other.complexity,
            redundancy: self.redundancy || other.redundancy,
        }
    }

    /// Whether one of these is among others.
    pub fn meets(self, other: StaticCriteria) -> bool {
        self.size && other.size
            || self.locality && other.locality
            || self.complexity && other.complexity
            || self.redundancy && other.redundancy
    }
}

impl fmt::Display for StaticCriteria {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let on = StaticCriteria::NAMED.iter();
        let on = on.filter(|(_, criterion)| criterion.meets(*self));
        let names: Vec<&str> = on.map(|(name, _)| *name).collect();
        if names.is_empty() {
            f.pad("none")
        } else {
            f.pad(&names.join(","))
        }
    }
}

/// What is known of each object of a scene as an occluder, before any frame.
#[derive(Clone, Debug)]
pub struct OccluderFitness {
    objects: Vec<Fitness>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Fitness {
    /// But for redundancy, which takes that what covers it is fit.
    unfit_by: StaticCriteria,
    covered_by: Option<u32>,
    compactness: f32,
    across: DVec3,
}

/// An object as the criteria see it.
#[derive(Clone, Copy, Debug)]
struct Candidate<'a> {
    /// Its number in the scene.
    object: u32,
    /// Its world box.
    bounds: &'a Aabb,
    /// The triangles it is drawn with as an occluder.
    triangles: usize,
}

impl OccluderFitness {
    /// Of a scene's objects, on rayon's current threads, the same for any number of them. Objects that are no occluders fit
    /// all criteria.
    pub fn new(scene: &Scene, clusters: &ClusteredScene) -> OccluderFitness {
        let meshes = (0..scene.meshes().len()).into_par_iter();
        let boxed: Vec<Option<BoxedMesh>> = meshes
            .map(|mesh| BoxedMesh::new(clusters.mesh(mesh)?))
            .collect();
        let boxed_of = |object: &Object| boxed[object.occluder_mesh()?].as_ref();
        let compactness: Vec<f32> = boxed
            .par_iter()
            .map(|boxed| boxed.as_ref().map_or(0.0, BoxedMesh::compactness) as f32)
            .collect();
        let mut objects: Vec<Fitness> = scene
            .objects()
            .iter()
            .map(|object| Fitness {
                unfit_by: StaticCriteria::NONE,
                covered_by: None,
                compactness: object.occluder_mesh().map_or(0.0, |mesh| compactness[mesh]),
                across: boxed_of(object).map_or(DVec3::ZERO, |boxed| {
                    boxed.bounds.across_largest_face(&object.world_from_local)
                }),
            })
            .collect();

        let candidates: Vec<Candidate<'_>> = (0..)
            .zip(scene.objects().iter().zip(scene.bounds()))
            .filter_map(|(number, (object, bounds))| {
                Some(Candidate {
                    object: number,
                    bounds,
                    triangles: clusters.occluder(object)?.triangle_count(),
                })
            })
            .collect();
        for number in size::unfit(&candidates) {
            objects[number as usize].unfit_by.size = true;
        }
        for number in locality::unfit(&candidates) {
            objects[number as usize].unfit_by.locality = true;
        }
        for number in complexity::unfit(&candidates) {
            objects[number as usize].unfit_by.complexity = true;
        }
        let covers = redundancy::covered_by(scene, &candidates, boxed_of);
        for (candidate, cover) in candidates.iter().zip(covers) {
            objects[candidate.object as usize].covered_by = cover;
        }
        OccluderFitness { objects }
    }

    /// Whether an object is fit to be an occluder by some criteria. What covers a redundant object has to be fit by the others:
    /// it stands for both.
    pub fn is_fit(&self, object: u32, criteria: StaticCriteria) -> bool {
        let fitness = &self.objects[object as usize];
        let is_fit = |fitness: &Fitness| !fitness.unfit_by.meets(criteria);
        is_fit(fitness)
            && !(criteria.redundancy
                && fitness
                    .covered_by
                    .is_some_and(|cover| is_fit(&self.objects[cover as usize])))
    }

    /// How well an object fills its tight box, from 0 to 1 (LOD §5.1, equation 2); 0 if it is no occluder.
    pub fn compactness(&self, object: u32) -> f32 {
        self.objects[object as usize].compactness
    }

    /// A unit vector across the largest face of an object's tight box, in the world (LOD §5.2, equation 3); zero if no
    /// face has an area.
    pub fn across_largest_face(&self, object: u32) -> DVec3 {
        self.objects[object as usize].across
    }
}

/// The box around all candidates.
fn around(candidates: &[Candidate<'_>]) -> Aabb {
    let boxes = candidates.iter().map(|candidate| *candidate.bounds);
    boxes.fold(Aabb::EMPTY, Aabb::union)
}

/// Half the area of a box.
fn half_area(bounds: &Aabb) -> f64 {
    let size = bounds.size();
    size.x * size.y + size.y * size.z + size.z * size.x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Mesh, Surface};
    use glam::DAffine3;

    /// Boxes of some sizes side by side along x.
    pub fn boxes(sizes: &[[f64; 3]]) -> Vec<Aabb> {
        let mut x = 0.0;
        let place = |&size: &[f64; 3]| {
            let min = DVec3::new(x, 0.0, 0.0);
            x += size[0];
            Aabb {
                min,
                max: min + DVec3::from(size),
            }
        };
        sizes.iter().map(place).collect()
    }

    /// Candidates with these boxes and triangles, in the order of their numbers.
    pub fn candidates<'a>(bounds: &'a [Aabb], triangles: &[usize]) -> Vec<Candidate<'a>> {
        let numbered = (0..).zip(bounds.iter().zip(triangles));
        let candidate = |(object, (bounds, &triangles))| Candidate {
            object,
            bounds,
            triangles,
        };
        numbered.map(candidate).collect()
    }

    /// The corners of a box's faces, of which bit `k` says on which side along axis `k` they are.
    pub const BOX_FACES: [[usize; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];

    fn mesh(rectangles: &[[DVec3; 4]]) -> Mesh {
        let narrow = |p: &DVec3| [p.x as f32, p.y as f32, p.z as f32];
        let positions: Vec<[f32; 3]> = rectangles.iter().flatten().map(narrow).collect();
        let first = (0..rectangles.len() as u32).map(|i| 4 * i);
        let triangles: Vec<[u32; 3]> = first
            .flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]])
            .collect();
        Mesh {
            name: String::new(),
            positions: positions.into(),
            surfaces: vec![Surface {
                triangles: 0..triangles.len(),
                material: Material::default(),
            }],
            triangles: triangles.into(),
        }
    }

    /// The corners of a mesh's triangles.
    pub fn corners_of(mesh: &Mesh) -> Vec<[DVec3; 3]> {
        let at = |i: u32| DVec3::from(mesh.positions[i as usize].map(f64::from));
        mesh.triangles.iter().map(|t| t.map(at)).collect()
    }

    /// A wall of 8 × 4 in the plane z = 0 with a window from (2, 1) to (6, 3), and boxes.
    pub fn room(boxes: &[([f64; 3], [f64; 3])]) -> Scene {
        let upright = |x0, y0, x1, y1| {
            [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| DVec3::new(x, y, 0.0))
        };
        let wall = mesh(&[
            upright(0.0, 0.0, 8.0, 1.0),
            upright(0.0, 3.0, 8.0, 4.0),
            upright(0.0, 1.0, 2.0, 3.0),
            upright(6.0, 1.0, 8.0, 3.0),
        ]);
        let block = |(min, max): &([f64; 3], [f64; 3])| {
            let corner = |i: usize| {
                let pick = |k: usize| if i >> k & 1 == 1 { max[k] } else { min[k] };
                DVec3::new(pick(0), pick(1), pick(2))
            };
            mesh(&BOX_FACES.map(|face| face.map(corner)))
        };
        let meshes: Vec<Mesh> = std::iter::once(wall)
            .chain(boxes.iter().map(block))
            .collect();
        let objects = (0..meshes.len()).map(|mesh| Object {
            name: String::new(),
            mesh,
            world_from_local: DAffine3::IDENTITY,
            never_cull: false,
            never_occlude: false,
            occluder_proxy: None,
        });
        let objects = objects.collect();
        Scene::new(meshes, objects).expect("a sound scene")
    }

    #[test]
    fn each_criterion_is_asked_if_it_is_on() {
        // A clock on the wall, a bolt in the window, and a wire before all.
        let scene = room(&[
            ([0.5, 2.0, 0.0], [1.0, 2.5, 0.1]),
            ([4.0, 2.0, 0.0], [4.02, 2.02, 0.02]),
            ([1.0, 0.0, 2.0], [3.0, 0.01, 2.01]),
        ]);
        let fitness = OccluderFitness::new(&scene, &ClusteredScene::new(&scene));
        let fit = |criteria| -> Vec<u32> {
            let objects = 0..4;
            objects.filter(|&o| fitness.is_fit(o, criteria)).collect()
        };
        assert_eq!(fit(StaticCriteria::NONE), [0, 1, 2, 3]);
        let [(_, size), (_, locality), (_, complexity), (_, redundancy)] = StaticCriteria::NAMED;
        assert_eq!(fit(redundancy), [0, 2, 3]);
        assert_eq!(fit(size), [0, 1]);
        assert_eq!(fit(complexity), [0, 1, 2, 3]);
        // The wall is as large as the scene; the clock is not redundant if the wall is no occluder.
        assert_eq!(fit(locality), [1, 2]);
        assert_eq!(fit(locality.and(redundancy)), [1, 2]);
        assert_eq!(fit(size.and(redundancy)), [0]);
        assert_eq!(
            StaticCriteria::ALL.to_string(),
            "size,locality,complexity,redundancy"
        );
        assert_eq!(StaticCriteria::NONE.to_string(), "none");
    }
}
