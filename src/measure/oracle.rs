//! The oracle: the clusters that truly own the most pixels for their triangles.
//!
//! What a selection is worth shows beside the best there could be. So the clusters of the prepared occluders are drawn exactly
//! at final size, in place of the surfaces that they stand for and with an id each, and their pixels are counted. The picture
//! is the one of [`Reference`](super::Reference): surfaces that do not occlude but are drawn as opaque ones (masked ones, or those
//! of objects that never occlude) own pixels, too, and take them from clusters behind. Translucent ones own none there, and none
//! here.
//!
//! It is no bound: of two clusters that own as many pixels, one may hide many objects and the other none. But nothing that a frame
//! knows beforehand tells more.

use crate::final_pass::draw_placed;
use crate::occluders::Budget;
use crate::prepare::{ClusterId, ClusteredMesh, ClusteredScene};
use crate::scene::{Alpha, Material, Mesh, Object, Scene, Surface};
use crate::view::{Camera, PictureSize};

/// A cluster that owns pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    /// Which.
    pub id: ClusterId,
    /// Its triangles; at least 1.
    pub triangles: u32,
    /// Its pixels; at least 1.
    pub pixels: u32,
}

/// Knows which clusters own the pixels of a picture.
#[derive(Debug)]
pub struct Oracle<'a> {
    scene: &'a Scene,
    /// What objects are drawn as, each shape once.
    shapes: Vec<Shape>,
    /// The shape of each object.
    shape_of: Vec<usize>,
}

/// A mesh in clusters, and what else there is of it.
#[derive(Debug)]
struct Shape {
    mesh: Mesh,
    /// For each cluster, where its triangles end. Those after the last belong to none.
    ends: Vec<usize>,
}

/// The id of a pixel.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Id {
    object: u32,
    triangle: u32,
}

#[derive(Clone, Copy)]
struct Pixel {
    depth: f32,
    id: Option<Id>,
}

impl<'a> Oracle<'a> {
    /// Of a scene, and its prepared occluders.
    pub fn new(scene: &'a Scene, clusters: &ClusteredScene) -> Oracle<'a> {
        // Objects with the same mesh and the same proxy are drawn as the same shape.
        let key = |object: &Object| (object.mesh, object.occluder_mesh());
        let mut keys: Vec<_> = scene.objects().iter().map(key).collect();
        keys.sort_unstable();
        keys.dedup();
        let shape = |&(mesh, occluder): &(usize, Option<usize>)| {
            let occluder = occluder.and_then(|occluder| clusters.mesh(occluder));
            Shape::new(&scene.meshes()[mesh], occluder)
        };
        let place = |object| keys.partition_point(|other| *other < key(object));
        Oracle {
            scene,
            shapes: keys.iter().map(shape).collect(),
            shape_of: scene.objects().iter().map(place).collect(),
        }
    }

    /// The clusters that own pixels of a picture, those with the most for their triangles first, ties in the order of ids.
    pub fn owners(&self, camera: &Camera, size: PictureSize) -> Vec<Owner> {
        let empty = Pixel {
            depth: f32::NEG_INFINITY,
            id: None,
        };
        let mut pixels = vec![empty; size.width() * size.height()];
        let all: Vec<u32> = (0..self.shape_of.len() as u32).collect();
        let placed = |object: u32| {
            let shape = &self.shapes[self.shape_of[object as usize]];
            let object = &self.scene.objects()[object as usize];
            (&shape.mesh, &object.world_from_local)
        };
        draw_placed(
            placed,
            camera,
            size,
            &all,
            |material| material.alpha != Alpha::Blend,
            &mut pixels,
            |pixel, fragment| {
                if fragment.depth > pixel.depth {
                    *pixel = Pixel {
                        depth: fragment.depth,
                        id: Some(Id {
                            object: fragment.object,
                            triangle: fragment.triangle as u32,
                        }),
                    };
                }
            },
        );
        let mut ids: Vec<ClusterId> = pixels
            .iter()
            .filter_map(|pixel| self.cluster_of(pixel.id?))
            .collect();
        ids.sort_unstable();
        let mut owners: Vec<Owner> = ids
            .chunk_by(|a, b| a == b)
            .map(|of_one| Owner {
                id: of_one[0],
                triangles: self.triangles_of(of_one[0]),
                pixels: of_one.len() as u32,
            })
            .collect();
        owners.sort_by(|a, b| {
            // Pixels a triangle, without a division.
            let [of_a, of_b] =
                [(a, b), (b, a)].map(|(a, b)| u64::from(a.pixels) * u64::from(b.triangles));
            of_b.cmp(&of_a).then(a.id.cmp(&b.id))
        });
        owners
    }

    fn cluster_of(&self, id: Id) -> Option<ClusterId> {
        let ends = &self.shapes[self.shape_of[id.object as usize]].ends;
        let cluster = ends.partition_point(|&end| end <= id.triangle as usize);
        (cluster < ends.len()).then_some(ClusterId {
            object: id.object,
            cluster: cluster as u32,
        })
    }

    fn triangles_of(&self, id: ClusterId) -> u32 {
        let ends = &self.shapes[self.shape_of[id.object as usize]].ends;
        let cluster = id.cluster as usize;
        let before = cluster.checked_sub(1).map_or(0, |before| ends[before]);
        (ends[cluster] - before) as u32
    }
}

impl Shape {
    /// The clusters of an occluder, and what they do not stand for.
    fn new(own: &Mesh, occluder: Option<&ClusteredMesh>) -> Shape {
        let mut mesh = Mesh::default();
        let mut ends = Vec::new();
        let clusters = occluder.into_iter().flat_map(|occluder| {
            let numbers = 0..occluder.clusters().len();
            numbers.map(|number| (&occluder.clusters()[number], occluder.geometry(number)))
        });
        for (cluster, geometry) in clusters {
            let first = mesh.positions.len() as u32;
            let vertices = 0..geometry.vertex_count;
            mesh.positions
                .to_mut()
                .extend(vertices.map(|v| [geometry.x[v], geometry.y[v], geometry.z[v]]));
            let begin = mesh.triangles.len();
            mesh.triangles.to_mut().extend(
                geometry
                    .triangles()
                    .map(|t| t.map(|v| first + u32::from(v))),
            );
            ends.push(mesh.triangles.len());
            mesh.surfaces.push(Surface {
                triangles: begin..mesh.triangles.len(),
                material: Material {
                    double_sided: cluster.double_sided,
                    ..Material::default()
                },
            });
        }
        let has_stand_in = |surface: &&Surface| occluder.is_some() && surface.material.occludes();
        let others = own.surfaces.iter().filter(|surface| !has_stand_in(surface));
        let first = mesh.positions.len() as u32;
        if others.clone().next().is_some() {
            mesh.positions.to_mut().extend_from_slice(&own.positions);
        }
        for surface in others {
            let begin = mesh.triangles.len();
            let triangles = &own.triangles[surface.triangles.clone()];
            mesh.triangles
                .to_mut()
                .extend(triangles.iter().map(|t| t.map(|v| first + v)));
            mesh.surfaces.push(Surface {
                triangles: begin..mesh.triangles.len(),
                material: surface.material,
            });
        }
        Shape { mesh, ends }
    }
}

/// The clusters that fit a budget, in their order until the first that does not.
pub fn within(budget: Budget, owners: &[Owner]) -> Vec<ClusterId> {
    let mut triangles = 0;
    let fit = owners.iter().take_while(|owner| {
        let fits = u64::from(owner.triangles) <= budget.left(triangles);
        triangles += u64::from(owner.triangles);
        fits
    });
    fit.map(|owner| owner.id).collect()
}
