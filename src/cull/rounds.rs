//! Clusters into the buffer, round after round.
//!
//! A thread that draws alone sets up a few blocks of triangles and fills them at once. Several set up a round of clusters
//! together, each task into a list of its own, and fill it by bands of rows of tiles, each band all lists in their order.
//! Rounds are small: their blocks stay in the caches, and a small triangle that an earlier round hides is not set up.

use antumbra_simd::assemble as simd;
use antumbra_simd::spans::SpanBlock;

use super::ask::ToDraw;
use super::{Frame, grow, share_of};
use crate::occlusion::OcclusionBuffer;
use crate::raster::{BlockList, ClusterAssembler, CullMode};
use crate::scene::is_mirroring;
use crate::tasks::{Tasks, Work};

/// A thread that draws alone fills when it has this many blocks, while they are still in its nearest cache.
const BLOCKS_PER_FLUSH: usize = 12;

/// Fewer clusters than this are drawn by the calling thread alone: sharing them out costs more.
const FEWEST_TO_SHARE: usize = 2;

/// A round has so many tasks for each thread, so that a long one does not hold up the others,
const TASKS_PER_THREAD: usize = 4;
/// each with at most so many clusters.
const CLUSTERS_PER_TASK: usize = 16;

/// What a task keeps.
#[derive(Debug, Default)]
pub struct Assembly {
    assembler: ClusterAssembler,
    list: BlockList,
}

/// Draws clusters in their order.
pub fn draw_clusters(
    frame: &Frame<'_>,
    to_draw: &[ToDraw],
    buffer: &mut OcclusionBuffer,
    memory: &mut Vec<Assembly>,
) {
    let tasks = frame.tasks;
    if tasks.threads() == 1 || to_draw.len() < FEWEST_TO_SHARE {
        grow(memory, 1);
        return tasks.alone(Work::Assemble, || {
            draw_alone(frame, to_draw, buffer, &mut memory[0]);
        });
    }
    let most = tasks.threads() * TASKS_PER_THREAD;
    for round in to_draw.chunks(most * CLUSTERS_PER_TASK) {
        let share = round.len().div_ceil(most);
        let count = round.len().div_ceil(share);
        grow(memory, count);
        let assemblies = &mut memory[..count];
        tasks.each(Work::Assemble, assemblies, |task, assembly| {
            assembly.list.clear();
            for of_object in share_of(round, share, task).chunk_by(|a, b| a.object == b.object) {
                assembly.assemble(frame, of_object, buffer);
            }
            assembly.list.find_rows();
        });
        let lists = assemblies.iter().map(|assembly| &assembly.list);
        buffer.draw_blocks(lists, tasks);
    }
}

fn draw_alone(
    frame: &Frame<'_>,
    to_draw: &[ToDraw],
    buffer: &mut OcclusionBuffer,
    assembly: &mut Assembly,
) {
    let flush = |list: &mut BlockList, buffer: &mut OcclusionBuffer| {
        buffer.draw_blocks(std::iter::once(&*list), Tasks::ALONE);
        list.clear();
    };
    assembly.list.clear();
    for of_object in to_draw.chunk_by(|a, b| a.object == b.object) {
        assembly.assemble(frame, of_object, buffer);
        if assembly.list.blocks.len() >= BLOCKS_PER_FLUSH {
            flush(&mut assembly.list, buffer);
        }
    }
    flush(&mut assembly.list, buffer);
}

impl Assembly {
    /// Appends the triangles of some clusters of one object.
    fn assemble(&mut self, frame: &Frame<'_>, clusters: &[ToDraw], buffer: &OcclusionBuffer) {
        let object = &frame.scene.objects()[clusters[0].object as usize];
        let Some(mesh) = frame.occluders.mesh_of(object) else {
            return;
        };
        let place = &object.world_from_local;
        let screen = buffer.screen().screen_from_local(place);
        let single_sided = if is_mirroring(place) {
            CullMode::Front
        } else {
            CullMode::Back
        };
        let blocks: &mut Vec<SpanBlock> = &mut self.list.blocks;
        for to_draw in clusters {
            let index = to_draw.cluster as usize;
            let geometry = mesh.geometry(index);
            let cull = if mesh.clusters()[index].double_sided {
                CullMode::None
            } else {
                single_sided
            };
            self.assembler.assemble(
                frame.settings.level,
                simd::Cluster {
                    x: geometry.x,
                    y: geometry.y,
                    z: geometry.z,
                    vertices: geometry.vertex_count,
                    quads: geometry.quads,
                },
                &screen,
                cull,
                buffer.tiles(),
                blocks,
            );
        }
    }
}
