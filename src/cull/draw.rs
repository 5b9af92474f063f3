//! Draws occluders into the buffer: batch after batch, each asked first, cluster by cluster.

use antumbra_simd::Level;
use antumbra_simd::assemble as simd;
use antumbra_simd::query::Covered;
use antumbra_simd::spans::SpanBlock;
use rayon::prelude::*;

use super::traverse::{TraverseMemory, hide_subtrees};
use super::{Settings, Statistics};
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::prepare::{Cluster, ClusteredMesh, ClusteredScene};
use crate::raster::{ClusterAssembler, CullMode};
use crate::scene::{Object, Scene, is_mirroring};

/// Objects that are asked, and then drawn, together. An answer sees only what whole batches before its own have
/// drawn, so that any number of threads gives the same one.
const OBJECTS_PER_BATCH: usize = 16;

/// After so many batches, and four times as many, and so on, whole groups of objects are looked at: what is near has been
/// drawn, and most of the others need not be asked one by one.
const BATCHES_BEFORE_LOOK: usize = 8;

/// An occluder with so many triangles is asked a second time, by its outline and faces, before it is drawn.
const WORTH_ASKING_CLOSELY: u32 = 24;

/// A thread that draws alone fills when it has this many blocks, while they are still in its nearest cache.
const BLOCKS_PER_FLUSH: usize = 12;

/// Fewer clusters than this are drawn by the calling thread alone: waking others costs more.
const FEWEST_TO_SHARE: usize = 8;

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
                .map_or(0, |mesh| mesh.triangle_count() as u32)
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
    batch: Vec<u32>,
    traverse: TraverseMemory,
    to_draw: Vec<ToDraw>,
    workers: Vec<Worker>,
}

/// A cluster of an object that was not found hidden.
#[derive(Clone, Copy, Debug)]
struct ToDraw {
    object: u32,
    cluster: u32,
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
#[expect(
    clippy::too_many_arguments,
    reason = "the parts of a culler, apart so that each can be borrowed"
)]
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
    let mut next_look = BATCHES_BEFORE_LOOK;
    for (index, batch) in candidates.chunks(OBJECTS_PER_BATCH).enumerate() {
        if index == next_look {
            next_look *= 4;
            hide_subtrees(
                scene,
                buffer,
                settings.level,
                &mut memory.traverse,
                drawn.hidden,
                drawn.statistics,
            );
        }
        memory.batch.clear();
        let unknown = batch.iter().filter(|&&o| !drawn.hidden[o as usize]);
        memory.batch.extend(unknown);
        let batch = &memory.batch;
        ask(
            scene,
            occluders,
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
        let objects = &drawn.occluders[first..];
        drawn.statistics.occluders_drawn += objects.len() as u64;
        memory.to_draw.clear();
        for &object in objects {
            ask_clusters(scene, occluders, object, settings.level, buffer, memory);
        }
        draw_clusters(scene, occluders, settings.level, threads, buffer, memory);
        if spent {
            break;
        }
    }
}

/// Whether objects are hidden behind what is drawn so far. On one thread: a batch has too few to share out.
fn ask(
    scene: &Scene,
    occluders: &Occluders,
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
    answers.extend(
        batch
            .iter()
            .zip(footprints)
            .map(|(&object, &mut footprint)| {
                let has_proxy = scene.objects()[object as usize].occluder_proxy.is_some();
                if has_proxy && footprint == Footprint::Unbounded {
                    Answer::CutOpen
                } else if buffer.hides(footprint, Covered::Samples)
                    || occluders.triangles_of(object) >= WORTH_ASKING_CLOSELY
                        && buffer.hides_aabb_closely(&scene.bounds()[object as usize], footprint)
                {
                    Answer::Hidden
                } else {
                    Answer::Visible
                }
            }),
    );
}

/// Appends the clusters of an object that are not hidden to those to draw. Drawing a hidden one would not change a bit.
fn ask_clusters(
    scene: &Scene,
    occluders: &Occluders,
    object: u32,
    level: Level,
    buffer: &OcclusionBuffer,
    memory: &mut DrawMemory,
) {
    let placed = &scene.objects()[object as usize];
    let Some(mesh) = occluders.mesh_of(placed) else {
        return;
    };
    let all = (0..mesh.clusters().len() as u32).map(|cluster| ToDraw { object, cluster });
    if mesh.clusters().len() == 1 {
        return memory.to_draw.extend(all);
    }
    let screen = buffer.screen();
    memory.footprints.clear();
    screen.footprints_of_local_boxes(
        level,
        &screen.screen_from_local(&placed.world_from_local),
        &scene.bounds()[object as usize],
        mesh.clusters().iter().map(Cluster::bounds),
        &mut memory.footprints,
    );
    let asked = all.zip(&memory.footprints);
    let visible = asked.filter(|&(_, &footprint)| !buffer.hides(footprint, Covered::Samples));
    memory.to_draw.extend(visible.map(|(cluster, _)| cluster));
}

fn draw_clusters(
    scene: &Scene,
    occluders: &Occluders,
    level: Level,
    threads: usize,
    buffer: &mut OcclusionBuffer,
    memory: &mut DrawMemory,
) {
    let DrawMemory {
        to_draw, workers, ..
    } = memory;
    if threads == 1 || to_draw.len() < FEWEST_TO_SHARE {
        let worker = &mut workers[0];
        worker.blocks.clear();
        for of_object in to_draw.chunk_by(|a, b| a.object == b.object) {
            worker.assemble(scene, occluders, of_object, level, buffer);
            if worker.blocks.len() >= BLOCKS_PER_FLUSH {
                buffer.draw_blocks(std::iter::once(&worker.blocks[..]), 1);
                worker.blocks.clear();
            }
        }
        return buffer.draw_blocks(std::iter::once(&worker.blocks[..]), 1);
    }
    let share = to_draw.len().div_ceil(workers.len());
    let shares = workers.par_iter_mut().zip(to_draw.par_chunks(share));
    let count = shares.len();
    shares.for_each(|(worker, share)| {
        worker.blocks.clear();
        for of_object in share.chunk_by(|a, b| a.object == b.object) {
            worker.assemble(scene, occluders, of_object, level, buffer);
        }
    });
    let runs = workers[..count].iter().map(|worker| &worker.blocks[..]);
    buffer.draw_blocks(runs, threads);
}

impl Worker {
    /// Appends the triangles of some clusters of one object.
    fn assemble(
        &mut self,
        scene: &Scene,
        occluders: &Occluders,
        clusters: &[ToDraw],
        level: Level,
        buffer: &OcclusionBuffer,
    ) {
        let object = &scene.objects()[clusters[0].object as usize];
        let Some(mesh) = occluders.mesh_of(object) else {
            return;
        };
        let place = &object.world_from_local;
        let screen = buffer.screen().screen_from_local(place);
        let single_sided = if is_mirroring(place) {
            CullMode::Front
        } else {
            CullMode::Back
        };
        for to_draw in clusters {
            let index = to_draw.cluster as usize;
            let geometry = mesh.geometry(index);
            let cull = if mesh.clusters()[index].double_sided {
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
                    quads: geometry.quads,
                },
                &screen,
                cull,
                buffer.tiles(),
                &mut self.blocks,
            );
        }
    }
}
