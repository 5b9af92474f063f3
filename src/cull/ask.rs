//! Which occluders of a batch are hidden behind what is drawn so far, and which of their clusters.

use glam::DAffine3;

use super::{Frame, grow, share_of};
use crate::occlusion::{Footprint, OcclusionBuffer};
use crate::prepare::{Cluster, NormalCone};
use crate::tasks::Work;
use crate::view::{Camera, Projection};

/// An occluder with so many triangles is asked a second time, by its outline and faces, before it is drawn.
const WORTH_ASKING_CLOSELY: u32 = 24;

/// A task asks at least so many objects: one question takes about a microsecond.
const FEWEST_OBJECTS: usize = 2;

/// Clusters of one object that are asked together; as many as a mask has bits.
const CLUSTERS_PER_GROUP: usize = 64;
/// The same where there are others to ask some of them.
const CLUSTERS_PER_SHARED_GROUP: usize = 16;

/// What is known of an object before it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// It is hidden.
    Hidden,
    /// It may be seen.
    Visible,
    /// The object reaches the near plane: its surface does not hide its proxy.
    CutOpen,
}

/// A cluster of an object that was not found hidden.
#[derive(Clone, Copy, Debug)]
pub struct ToDraw {
    /// The object.
    pub object: u32,
    /// Which of its clusters.
    pub cluster: u32,
}

/// Memory that is kept from batch to batch.
#[derive(Debug, Default)]
pub struct AskMemory {
    questions: Vec<Questions>,
    answers: Vec<Answer>,
    groups: Vec<Group>,
}

/// What a task asks, and its answers.
#[derive(Debug, Default)]
struct Questions {
    footprints: Vec<Footprint>,
    answers: Vec<Answer>,
    /// For each group of clusters, those that are not hidden.
    visible: Vec<u64>,
}

/// Some clusters of an object.
#[derive(Clone, Copy, Debug)]
struct Group {
    object: u32,
    first: u32,
    count: u32,
}

/// Whether objects are hidden behind what is drawn so far.
pub fn ask<'m>(
    frame: &Frame<'_>,
    batch: &[u32],
    buffer: &OcclusionBuffer,
    memory: &'m mut AskMemory,
) -> &'m [Answer] {
    let share = match frame.tasks.threads() {
        1 => batch.len().max(1),
        threads => (batch.len() / (4 * threads)).max(FEWEST_OBJECTS),
    };
    let count = batch.len().div_ceil(share);
    grow(&mut memory.questions, count);
    let questions = &mut memory.questions[..count];
    frame.tasks.each(Work::Ask, questions, |task, questions| {
        questions.ask(frame, share_of(batch, share, task), buffer);
    });
    memory.answers.clear();
    for questions in questions {
        memory.answers.extend_from_slice(&questions.answers);
    }
    &memory.answers
}

/// Finds the clusters of objects that face the eye and are not hidden, in order. Drawing a hidden one would not change a bit.
pub fn ask_clusters(
    frame: &Frame<'_>,
    objects: &[u32],
    buffer: &OcclusionBuffer,
    memory: &mut AskMemory,
    to_draw: &mut Vec<ToDraw>,
) {
    let threads = frame.tasks.threads();
    let per_group = if threads == 1 {
        CLUSTERS_PER_GROUP
    } else {
        CLUSTERS_PER_SHARED_GROUP
    };
    let groups = &mut memory.groups;
    groups.clear();
    for &object in objects {
        let placed = &frame.scene.objects()[object as usize];
        let mesh = frame.occluders.mesh_of(placed);
        let clusters = mesh.map_or(0, |mesh| mesh.clusters().len());
        groups.extend((0..clusters).step_by(per_group).map(|first| Group {
            object,
            first: first as u32,
            count: (clusters - first).min(per_group) as u32,
        }));
    }
    let share = match threads {
        1 => groups.len().max(1),
        threads => groups.len().div_ceil(4 * threads).max(1),
    };
    let count = groups.len().div_ceil(share);
    grow(&mut memory.questions, count);
    let questions = &mut memory.questions[..count];
    frame
        .tasks
        .each(Work::AskClusters, questions, |task, questions| {
            questions.ask_clusters(frame, share_of(groups, share, task), buffer);
        });
    to_draw.clear();
    let visible = questions.iter().flat_map(|questions| &questions.visible);
    for (group, &visible) in groups.iter().zip(visible) {
        let mut left = visible;
        while left != 0 {
            to_draw.push(ToDraw {
                object: group.object,
                cluster: group.first + left.trailing_zeros(),
            });
            left &= left - 1;
        }
    }
}

impl Questions {
    fn ask(&mut self, frame: &Frame<'_>, objects: &[u32], buffer: &OcclusionBuffer) {
        let &Frame {
            scene, occluders, ..
        } = frame;
        self.footprints.clear();
        let bounds = objects.iter().map(|&o| &scene.bounds()[o as usize]);
        buffer
            .screen()
            .footprints_of_aabbs(frame.settings.level, bounds, &mut self.footprints);
        self.answers.clear();
        self.answers.extend(
            objects
                .iter()
                .zip(&self.footprints)
                .map(|(&object, &footprint)| {
                    let has_proxy = scene.objects()[object as usize].occluder_proxy.is_some();
                    if has_proxy && footprint == Footprint::Unbounded {
                        Answer::CutOpen
                    } else if buffer.hides(footprint)
                        || occluders.triangles_of(object) >= WORTH_ASKING_CLOSELY
                            && buffer
                                .hides_aabb_closely(&scene.bounds()[object as usize], footprint)
                    {
                        Answer::Hidden
                    } else {
                        Answer::Visible
                    }
                }),
        );
    }

    fn ask_clusters(&mut self, frame: &Frame<'_>, groups: &[Group], buffer: &OcclusionBuffer) {
        self.visible.clear();
        for group in groups {
            let placed = &frame.scene.objects()[group.object as usize];
            let Some(mesh) = frame.occluders.mesh_of(placed) else {
                self.visible.push(0);
                continue;
            };
            let screen = buffer.screen();
            let clusters = &mesh.clusters()[group.first as usize..][..group.count as usize];
            let facing = facing(clusters, screen.camera(), &placed.world_from_local);
            if facing == 0 || mesh.clusters().len() == 1 {
                // The object has just been asked.
                self.visible.push(facing);
                continue;
            }
            self.footprints.clear();
            screen.footprints_of_local_boxes(
                frame.settings.level,
                &screen.screen_from_local(&placed.world_from_local),
                &frame.scene.bounds()[group.object as usize],
                clusters.iter().map(Cluster::bounds),
                &mut self.footprints,
            );
            let bits = self.footprints.iter().enumerate();
            self.visible.push(bits.fold(0, |visible, (i, &footprint)| {
                let is_seen = facing >> i & 1 == 1 && !buffer.hides(footprint);
                visible | u64::from(is_seen) << i
            }));
        }
    }
}

/// Which clusters of a placed mesh may show a front: those whose cones do not say that all of it looks away.
fn facing(clusters: &[Cluster], camera: &Camera, world_from_local: &DAffine3) -> u64 {
    let all = u64::MAX >> (u64::BITS as usize - clusters.len());
    if clusters.iter().all(|cluster| cluster.cone.is_none()) {
        return all;
    }
    let local_from_world = world_from_local.inverse();
    let eye = local_from_world.transform_point3(camera.eye());
    let view = local_from_world.transform_vector3(camera.forward());
    let is_perspective = matches!(camera.projection(), Projection::Perspective { .. });
    let looks_away = |cone: &NormalCone| {
        if is_perspective {
            cone.is_back_facing(eye)
        } else {
            cone.is_back_facing_along(view)
        }
    };
    let cones = clusters.iter().map(|cluster| cluster.cone.as_ref());
    cones.enumerate().fold(all, |facing, (i, cone)| {
        facing & !(u64::from(cone.is_some_and(looks_away)) << i)
    })
}
