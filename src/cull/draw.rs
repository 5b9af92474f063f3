//! Draws occluders into the buffer: batch after batch, each asked first, cluster by cluster.

use antumbra_simd::Level;
use antumbra_simd::assemble as simd;
use antumbra_simd::query::Covered;
use antumbra_simd::spans::SpanBlock;
use rayon::prelude::*;

use super::{Settings, Statistics};
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::prepare::{Cluster, ClusteredMesh, ClusteredScene};
use crate::raster::{ClusterAssembler, CullMode};
use crate::scene::{Object, Scene, is_mirroring};

/// Objects that are asked, and then drawn, together. An answer sees only what whole batches before its own have
/// drawn, so that any number of threads gives the same one.
const OBJECTS_PER_BATCH: usize = 16;

/// A thread that draws alone fills when it has this many blocks, while they are still in its nearest cache.
const BLOCKS_PER_FLUSH: usize = 12;

/// What is known of a scene's occluders before any frame.
#[derive(Debug)]
pub struct Occluders {
    clusters: ClusteredScene,
    /// How many triangles each object puts in the way.
    triangles: Vec<u32>,
}

impl Occluders {
    /// Makes a scene's occluders ready, on the current threads.
    pub fn new(scene: &Scene) -> Occluders {
        let clusters = ClusteredScene::new(scene);
        let triangles = |object: &Object| {
            clusters
                .occluder(object)
                .map_or(0, |mesh| mesh.triangles().len() as u32)
        };
        Occluders {
            triangles: scene.objects().iter().map(triangles).collect(),
            clusters,
        }
    }

    /// How many triangles an object puts in the way as an occluder; 0 if it is none.
    pub fn triangles_of(&self, object: u32) -> u32 {
        self.triangles[object as usize]
    }

    fn mesh_of(&self, object: &Object) -> Option<&ClusteredMesh> {
        self.clusters.occluder(object)
    }
}

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct DrawMemory {
    footprints: Vec<Footprint>,
    answers: Vec<Answer>,
    workers: Vec<Worker>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Answer {
    Hidden,
    Visible,
    /// The object reaches the near plane: its surface does not hide its proxy.
    CutOpen,
}

/// What a thread keeps.
#[derive(Debug, Default)]
struct Worker {
    assembler: ClusterAssembler,
    footprints: Vec<Footprint>,
    blocks: Vec<SpanBlock>,
}

/// What drawing found and did.
pub struct Drawn<'a> {
    /// For each object, whether it was found hidden. What a part of the occluders hides stays hidden behind all of them.
    pub hidden: &'a mut [bool],
    /// The objects that were drawn, in order.
    pub occluders: &'a mut Vec<u32>,
    /// Counts.
    pub statistics: &'a mut Statistics,
}

/// Draws candidates in their order, as far as the budget goes, each asked first.
pub fn draw_occluders(
    scene: &Scene,
    occluders: &Occluders,
    settings: &Settings,
    threads: usize,
    candidates: &[u32],
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
    drawn: Drawn<'_>,
) {
    memory.workers.resize_with(threads, Worker::default);
    for batch in candidates.chunks(OBJECTS_PER_BATCH) {
        ask(
            scene,
            batch,
            settings.level,
            buffer,
            &mut memory.footprints,
            &mut memory.answers,
        );
        drawn.statistics.occluders_asked += batch.len() as u64;
        let first = drawn.occluders.len();
        let mut spent = false;
        for (&object, answer) in batch.iter().zip(&memory.answers) {
            let cost = u64::from(occluders.triangles_of(object));
            match answer {
                Answer::Hidden => drawn.hidden[object as usize] = true,
                // Its own mesh may be far beyond any budget: that is what it has a proxy for.
                Answer::CutOpen => {}
                Answer::Visible => {
                    if settings
                        .budget
                        .allows(drawn.statistics.occluder_triangles + cost)
                    {
                        drawn.statistics.occluder_triangles += cost;
                        drawn.occluders.push(object);
                    } else {
                        spent = true;
                        break;
                    }
                }
            }
        }
        let to_draw = &drawn.occluders[first..];
        drawn.statistics.occluders_drawn += to_draw.len() as u64;
        if threads == 1 {
            let worker = &mut memory.workers[0];
            worker.blocks.clear();
            for &object in to_draw {
                worker.assemble(scene, occluders, object, settings.level, buffer);
                if worker.blocks.len() >= BLOCKS_PER_FLUSH {
                    buffer.draw_blocks(&worker.blocks, 1);
                    worker.blocks.clear();
                }
            }
        } else {
            let share = to_draw.len().div_ceil(threads).max(1);
            memory
                .workers
                .par_iter_mut()
                .enumerate()
                .for_each(|(index, worker)| {
                    worker.blocks.clear();
                    for &object in to_draw.iter().skip(index * share).take(share) {
                        worker.assemble(scene, occluders, object, settings.level, buffer);
                    }
                });
        }
        for worker in &memory.workers {
            buffer.draw_blocks(&worker.blocks, threads);
        }
        if spent {
            break;
        }
    }
}

/// Whether objects are hidden behind what is drawn so far. On one thread: a batch has too few to share out.
fn ask(
    scene: &Scene,
    batch: &[u32],
    level: Level,
    buffer: &OcclusionBuffer,
    footprints: &mut Vec<Footprint>,
    answers: &mut Vec<Answer>,
) {
    footprints.clear();
    let bounds = batch.iter().map(|&o| &scene.bounds()[o as usize]);
    buffer
        .screen()
        .footprints_of_aabbs(level, bounds, footprints);
    answers.clear();
    answers.extend(batch.iter().zip(footprints).map(|(&object, &mut footprint)| {
        let has_proxy = scene.objects()[object as usize].occluder_proxy.is_some();
        if has_proxy && footprint == Footprint::Unbounded {
            Answer::CutOpen
        } else if buffer.hides(footprint, Covered::Samples) {
            Answer::Hidden
        } else {
            Answer::Visible
        }
    }));
}

impl Worker {
    fn assemble(
        &mut self,
        scene: &Scene,
        occluders: &Occluders,
        object: u32,
        level: Level,
        buffer: &OcclusionBuffer,
    ) {
        let bounds = &scene.bounds()[object as usize];
        let object = &scene.objects()[object as usize];
        let Some(mesh) = occluders.mesh_of(object) else {
            return;
        };
        let place = &object.world_from_local;
        let size = buffer.tiles().size();
        let screen = buffer.screen().camera().screen_from_local(size, place);
        let single_sided = if is_mirroring(place) {
            CullMode::Front
        } else {
            CullMode::Back
        };
        self.footprints.clear();
        if mesh.clusters().len() > 1 {
            buffer.screen().footprints_of_local_boxes(
                level,
                &screen,
                bounds,
                mesh.clusters().iter().map(Cluster::bounds),
                &mut self.footprints,
            );
        }
        for (index, cluster) in mesh.clusters().iter().enumerate() {
            // Drawing what is hidden would not change a bit, now or when its turn comes.
            let footprint = self.footprints.get(index);
            if footprint.is_some_and(|&f| buffer.hides(f, Covered::Parts)) {
                continue;
            }
            let geometry = mesh.geometry(index);
            let cull = if cluster.double_sided {
                CullMode::None
            } else {
                single_sided
            };
            self.assembler.assemble(
                level,
                simd::Cluster {
                    x: geometry.x,
                    y: geometry.y,
                    z: geometry.z,
                    triangles: geometry.triangles,
                },
                &screen,
                cull,
                buffer.tiles(),
                &mut self.blocks,
            );
        }
    }
}
