//! Clusters into the buffer, round after round.
//!
//! The clusters of a round are asked, and those that are not hidden set up, before any of them is filled: each task makes a
//! list of its own. Then bands of rows of tiles are filled, each from all lists in their order. What a question sees
//! depends on rounds alone, which are the same for any number of threads. They are small: what is nearer hides clusters of
//! the next, and blocks stay in the caches.

use antumbra_simd::assemble::{Cluster, MOST_QUADS};

use super::draw::Drawn;
use super::waiting::{Placed, Waiting, WaitingCluster};
use super::{Frame, grow, share_of};
use crate::occluders::DrawnCluster;
use crate::occlusion::OcclusionBuffer;
use crate::raster::{BlockList, ClusterAssembler, CullMode};
use crate::tasks::Work;

/// A horizon that nothing is beyond.
pub const EVERYTHING: u32 = 0;

/// Clusters of a round.
const CLUSTERS_PER_ROUND: usize = 64;
/// The same while so many wait that they can hardly hide each other better in smaller rounds, and threads have more to
/// share: as many as a mask has bits.
const CLUSTERS_PER_LARGE_ROUND: usize = 128;
const MANY_WAITING: usize = 512;

/// A round has so many tasks for each thread, so that a long one does not hold up the others,
const TASKS_PER_THREAD: usize = 4;
/// each with at least so many clusters.
const FEWEST_CLUSTERS: usize = 2;

/// Memory that is kept from round to round.
#[derive(Debug, Default)]
pub struct RoundMemory {
    round: Vec<WaitingCluster>,
    assemblies: Vec<Assembly>,
    /// How many samples each cluster of the round took over: see [`TileRows::gains`](antumbra_simd::fill::TileRows).
    gains: Vec<u32>,
}

impl RoundMemory {
    /// Forgets clusters that were left for a next round.
    pub fn clear(&mut self) {
        self.round.clear();
    }
}

/// What a task keeps.
#[derive(Debug, Default)]
struct Assembly {
    assembler: ClusterAssembler,
    list: BlockList,
    /// Bit `i` is set if cluster `i` of the task is hidden.
    hidden: u128,
}

/// Draws the clusters that wait and are at least as near as `horizon` says, each if it is not hidden, as far as the budget goes;
/// marks the objects that turn out to be hidden as a whole. Whether the budget allows for more.
pub fn draw_waiting(
    frame: &Frame<'_>,
    waiting: &mut Waiting,
    horizon: u32,
    buffer: &mut OcclusionBuffer,
    memory: &mut RoundMemory,
    drawn: &mut Drawn<'_>,
) -> bool {
    let RoundMemory {
        round,
        assemblies,
        gains,
    } = memory;
    let threads = frame.tasks.threads();
    let most = if waiting.len() < MANY_WAITING {
        CLUSTERS_PER_ROUND
    } else {
        CLUSTERS_PER_LARGE_ROUND
    };
    let mut is_first = true;
    loop {
        if frame.is_time_over() {
            return false;
        }
        let left = frame
            .settings
            .budget
            .left(drawn.statistics.occluder_triangles);
        let is_spent = waiting.take(horizon, most, left, round);
        // A few more may wait for the next batch: the fewer rounds, the less threads wait for each other.
        let is_worth_it = is_first || round.len() >= most || horizon == EVERYTHING;
        if round.is_empty() || !is_worth_it {
            return !is_spent;
        }
        is_first = false;
        let share = match threads {
            1 => round.len(),
            threads => round
                .len()
                .div_ceil(TASKS_PER_THREAD * threads)
                .max(FEWEST_CLUSTERS),
        };
        let count = round.len().div_ceil(share);
        grow(assemblies, count);
        let assemblies = &mut assemblies[..count];
        frame
            .tasks
            .each(Work::Assemble, assemblies, |task, assembly| {
                let clusters = share_of(round, share, task);
                assembly.assemble(frame, clusters, task * share, waiting, buffer);
                // One task is filled as a whole.
                if count > 1 {
                    assembly.list.find_rows();
                }
            });
        // What is one task to set up is not worth sharing the filling of.
        let tasks = if count == 1 {
            frame.tasks.by_one()
        } else {
            frame.tasks
        };
        gains.clear();
        gains.resize(round.len(), 0);
        let lists = assemblies.iter().map(|assembly| &assembly.list);
        buffer.draw_blocks(lists, gains, tasks);
        let of_tasks = assemblies.iter().enumerate();
        let hidden = of_tasks.fold(0, |hidden, (task, assembly)| {
            hidden | assembly.hidden << (task * share)
        });
        for (i, (cluster, &gain)) in round.iter().zip(&*gains).enumerate() {
            if hidden >> i & 1 == 1 {
                continue;
            }
            let id = waiting.id_of(cluster);
            let triangles = cluster.triangles;
            drawn.occluders.push(DrawnCluster {
                id,
                triangles,
                gain,
            });
            drawn.statistics.occluder_triangles += u64::from(triangles);
            if let Some(known) = cluster.known {
                drawn.contributions.drawn(known, gain);
            }
        }
        let hide = |object| drawn.hidden.set(object);
        waiting.drawn(round, hidden, hide);
        round.clear();
    }
}

impl Assembly {
    /// Asks clusters, and sets the triangles up of those that are not hidden. The first of them is number `first` of the round.
    fn assemble(
        &mut self,
        frame: &Frame<'_>,
        clusters: &[WaitingCluster],
        first: usize,
        waiting: &Waiting,
        buffer: &OcclusionBuffer,
    ) {
        self.list.clear();
        self.hidden = 0;
        let asks = frame.asks_before_drawing();
        for (i, cluster) in clusters.iter().enumerate() {
            if asks && !waiting.was_just_asked(cluster) && buffer.hides(cluster.footprint) {
                self.hidden |= 1 << i;
            } else {
                let placed = waiting.object_of(cluster);
                let blocks = self.list.blocks.len();
                self.set_up(frame, placed, cluster.cluster as usize, buffer);
                self.list.blocks.set_owner(blocks, (first + i) as u32);
            }
        }
    }

    fn set_up(
        &mut self,
        frame: &Frame<'_>,
        placed: &Placed,
        cluster: usize,
        buffer: &OcclusionBuffer,
    ) {
        let object = &frame.scene.objects()[placed.object as usize];
        let Some(mesh) = frame.occluders.mesh_of(object) else {
            return;
        };
        let geometry = mesh.geometry(cluster);
        let cull = if mesh.clusters()[cluster].double_sided {
            CullMode::None
        } else {
            placed.single_sided
        };
        let mut assemble = |quads| {
            self.assembler.assemble(
                frame.settings.level,
                Cluster {
                    quads,
                    ..geometry.for_loops()
                },
                &placed.screen,
                cull,
                buffer.tiles(),
                &mut self.list.blocks,
            );
        };
        assemble(geometry.quads);
        if !frame.settings.slack.is_none() {
            let bridges = frame.occluders.bridges_of(object, cluster);
            bridges.chunks(MOST_QUADS).for_each(assemble);
        }
    }
}
