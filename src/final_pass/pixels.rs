//! Draws objects sample by sample, in scene order, on all threads, with the same picture for any number of them.
//!
//! Coverage and depth come from the same code as the occluders' (see [`crate::raster`]), so a surface lies at the same
//! samples and depths in both passes.

use glam::DAffine3;
use rayon::prelude::*;

use crate::raster::{ObjectAssembler, ObjectTriangle, for_each_sample};
use crate::scene::{Material, Mesh, Scene};
use crate::view::{Camera, PictureSize};

/// Rows of pixels that one thread draws at a time: whole tiles.
const ROWS_PER_BAND: usize = 32;

/// Triangles assembled before they are drawn: bounds the memory of a frame.
const TRIANGLES_PER_FLUSH: usize = 50_000;

/// One covered sample of an object.
#[derive(Clone, Copy, Debug)]
pub struct Fragment<'a> {
    /// The object.
    pub object: u32,
    /// The mesh's triangle.
    pub triangle: usize,
    /// Its material.
    pub material: &'a Material,
    /// The depth, the larger the nearer.
    pub depth: f32,
}

/// Draws the surfaces that `wanted` says of `objects`, in order: calls `write` with the pixel and the fragment for
/// every sample that a triangle covers. `pixels` is the picture, row by row.
///
/// # Panics
/// If `pixels` is not of the picture's size.
pub fn draw_objects<'a, P: Send>(
    scene: &'a Scene,
    camera: &Camera,
    size: PictureSize,
    objects: &[u32],
    wanted: impl Fn(&Material) -> bool + Sync,
    pixels: &mut [P],
    write: impl Fn(&mut P, Fragment<'a>) + Sync,
) {
    let placed = |object: u32| {
        let object = &scene.objects()[object as usize];
        (&scene.meshes()[object.mesh], &object.world_from_local)
    };
    draw_placed(placed, camera, size, objects, wanted, pixels, write);
}

/// The same for meshes that need not be a scene's: `placed` says what an object is drawn as, and where it stands.
///
/// # Panics
/// If `pixels` is not of the picture's size.
pub fn draw_placed<'a, P: Send>(
    placed: impl Fn(u32) -> (&'a Mesh, &'a DAffine3) + Sync,
    camera: &Camera,
    size: PictureSize,
    objects: &[u32],
    wanted: impl Fn(&Material) -> bool + Sync,
    pixels: &mut [P],
    write: impl Fn(&mut P, Fragment<'a>) + Sync,
) {
    assert_eq!(pixels.len(), size.width() * size.height());
    let assembler = ObjectAssembler::new(*camera, size);
    let triangles_of = |object: u32| placed(object).0.triangles.len();
    let mut rest = objects;
    while !rest.is_empty() {
        let mut triangles = 0;
        let mut fits = |&object: &u32| {
            let fits = triangles < TRIANGLES_PER_FLUSH;
            triangles += triangles_of(object);
            fits
        };
        let count = rest.iter().take_while(|o| fits(o)).count();
        let (now, later) = rest.split_at(count);
        rest = later;
        let assembled: Vec<Vec<ObjectTriangle<'a>>> = now
            .par_iter()
            .map_init(
                || assembler.clone(),
                |assembler, &object| {
                    let (mesh, world_from_local) = placed(object);
                    let mut triangles = Vec::new();
                    assembler.assemble(mesh, world_from_local, &wanted, |t| {
                        triangles.push(t);
                    });
                    triangles
                },
            )
            .collect();
        pixels
            .par_chunks_mut(ROWS_PER_BAND * size.width())
            .enumerate()
            .for_each(|(band, pixels)| {
                let first = (band * ROWS_PER_BAND) as i32;
                let rows = first..first + (pixels.len() / size.width()) as i32;
                for (&object, triangles) in now.iter().zip(&assembled) {
                    for ObjectTriangle {
                        triangle,
                        index,
                        material,
                    } in triangles
                    {
                        for_each_sample(triangle, rows.clone(), |x, y, depth| {
                            let at = (y - first) as usize * size.width() + x as usize;
                            write(
                                &mut pixels[at],
                                Fragment {
                                    object,
                                    triangle: *index,
                                    material,
                                    depth,
                                },
                            );
                        });
                    }
                }
            });
    }
}
