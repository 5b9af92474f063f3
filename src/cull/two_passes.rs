//! HOM's two passes (§3.2), for depth representations that cannot be asked while there is still drawing.
//!
//! The frame draws its occluders, asking nothing. Then all that was drawn is noted in the representation, and the hierarchy and
//! the objects in the frustum are asked: hidden is what lies within the covered samples and behind the representation. Both tests
//! take a rectangle and its nearest depth, and what a node passes all below it pass as well: their rectangles lie within its own,
//! and none of them is nearer.

use antumbra_simd::triangle::CullMode;

use super::marks::Marks;
use super::traverse::FEWEST_OBJECTS;
use super::{Frame, VisibleSet, grow, share_of};
use crate::occluders::DrawnCluster;
use crate::occlusion::{
    Accuracy, DepthMap, DepthRepresentation, DrawnSurface, Footprint, OcclusionBuffer,
    OcclusionMap, Thresholds, is_covered,
};
use crate::raster::SurfaceTriangles;
use crate::scene::is_mirroring;
use crate::tasks::Work;
use crate::view::{Containment, MapScale, Planes};

/// A task asks so many objects.
const OBJECTS_PER_TASK: usize = 64;

/// Memory that is kept from frame to frame.
#[derive(Debug, Default)]
pub struct TwoPassMemory {
    /// What is noted, and the representation that it was made for.
    depth: Option<(DepthRepresentation, DepthMap)>,
    /// The map, and the thresholds of an exact overlap test: holes that may be ignored are covered in the tiles by then.
    map: Option<(OcclusionMap, Thresholds)>,
    triangles: SurfaceTriangles,
    level: Vec<u32>,
    below: Vec<u32>,
    footprints: Vec<Footprint>,
    undecided: Vec<u32>,
    tests: Vec<Test>,
}

/// What a task asks, and its answers.
#[derive(Debug, Default)]
struct Test {
    footprints: Vec<Footprint>,
    kept: Vec<u32>,
}

/// What answers.
struct Question<'a> {
    buffer: &'a OcclusionBuffer,
    map: &'a OcclusionMap,
    depth: &'a DepthMap,
    thresholds: &'a Thresholds,
}

impl TwoPassMemory {
    /// The depth of what the last frame drew, if it was of two passes.
    pub fn depth_map(&self) -> Option<&DepthMap> {
        self.depth.as_ref().map(|(_, depth)| depth)
    }
}

impl Question<'_> {
    fn hides(&self, footprint: Footprint) -> bool {
        let tiles = self.buffer.tiles();
        match footprint {
            Footprint::Unbounded => false,
            Footprint::Nowhere => true,
            Footprint::Within(rect) => {
                self.depth.is_behind(tiles, &rect)
                    && is_covered(self.map, tiles, &rect, self.thresholds)
            }
        }
    }
}

impl Frame<'_> {
    /// Whether occluders are asked before they are drawn, which takes the depths that drawing leaves in the tiles.
    pub(super) fn asks_before_drawing(&self) -> bool {
        self.settings.depth == DepthRepresentation::NoBackground
            || self.settings.map_scale != MapScale::Full
            || !self.settings.slack.is_none()
    }

    /// Notes what was drawn, and builds the pyramids.
    pub(super) fn finish_depth(
        &self,
        buffer: &OcclusionBuffer,
        drawn: &[DrawnCluster],
        memory: &mut TwoPassMemory,
    ) {
        self.tasks.alone(Work::Finish, || {
            let (map, _) = memory.map.get_or_insert_with(|| {
                let map = OcclusionMap::new(buffer.tiles());
                let exact = Thresholds::new(&Accuracy::Exact, MapScale::Full, map.level_count());
                (map, exact)
            });
            map.build(buffer.tiles());
            let representation = match (self.settings.depth, self.settings.accuracy) {
                (DepthRepresentation::Hierarchical { .. }, Accuracy::Exact) => {
                    DepthRepresentation::HIERARCHICAL
                }
                (any, _) => any,
            };
            let depth = match memory.depth.take() {
                Some((of, depth)) if of == representation => depth,
                _ => DepthMap::new(representation, self.settings.size),
            };
            let (_, depth) = memory.depth.insert((representation, depth));
            depth.clear();
            let (triangles, footprints) = (&mut memory.triangles, &mut memory.footprints);
            self.note(buffer, drawn, depth, triangles, footprints);
            depth.finish();
        });
    }

    fn note(
        &self,
        buffer: &OcclusionBuffer,
        drawn: &[DrawnCluster],
        depth: &mut DepthMap,
        triangles: &mut SurfaceTriangles,
        footprints: &mut Vec<Footprint>,
    ) {
        let screen = buffer.screen();
        for DrawnCluster { id, .. } in drawn {
            let object = &self.scene.objects()[id.object as usize];
            let Some(mesh) = self.occluders.mesh_of(object) else {
                continue;
            };
            let cluster = &mesh.clusters()[id.cluster as usize];
            let bounds = &self.scene.bounds()[id.object as usize];
            let from_local = screen.screen_from_local(&object.world_from_local, bounds);
            let local = cluster.bounds();
            footprints.clear();
            screen.footprints_of_local_boxes(
                self.settings.level,
                &from_local,
                bounds,
                std::iter::once(local),
                footprints,
            );
            triangles.clear();
            if depth.takes_triangles(footprints[0]) {
                let cull = match (cluster.double_sided, is_mirroring(&object.world_from_local)) {
                    (true, _) => CullMode::None,
                    (false, false) => CullMode::Back,
                    (false, true) => CullMode::Front,
                };
                let geometry = mesh.geometry(id.cluster as usize);
                triangles.add(&geometry, &from_local, cull, screen.size());
            }
            depth.note(&DrawnSurface {
                footprint: footprints[0],
                farthest_depth: screen.farthest_depth_of_local_box(&from_local, bounds, &local),
                triangles,
            });
        }
    }

    /// Keeps the objects that are not hidden, and those that are never culled.
    pub(super) fn ask_behind(
        &self,
        buffer: &OcclusionBuffer,
        in_frustum: &[u32],
        hidden: &mut Marks,
        memory: &mut TwoPassMemory,
        found: &mut VisibleSet,
    ) {
        let TwoPassMemory {
            depth: Some((_, depth)),
            map: Some((map, thresholds)),
            level,
            below,
            footprints,
            undecided,
            tests,
            ..
        } = memory
        else {
            return;
        };
        let question = Question {
            buffer,
            map,
            depth,
            thresholds,
        };
        let statistics = &mut found.statistics;
        self.tasks.alone(Work::Look, || {
            let nodes = &self.scene.bvh().nodes;
            let frustum = self.frustum(buffer.screen().camera());
            level.clear();
            level.extend((!nodes.is_empty()).then_some(0));
            while !level.is_empty() {
                footprints.clear();
                let boxes = level.iter().map(|&node| nodes[node as usize].bounds());
                let screen = buffer.screen();
                screen.footprints_of_aabbs(self.settings.level, boxes, footprints);
                below.clear();
                for (&index, &footprint) in level.iter().zip(&*footprints) {
                    let node = &nodes[index as usize];
                    let is_outside = footprint == Footprint::Nowhere
                        || footprint == Footprint::Unbounded
                            && frustum.contains(&node.bounds(), Planes::ALL)
                                == Containment::Outside;
                    if is_outside {
                        continue;
                    }
                    statistics.nodes_tested += 1;
                    if question.hides(footprint) {
                        statistics.nodes_hidden += 1;
                        for &object in self.subtrees.objects(self.scene, index) {
                            hidden.set(object);
                        }
                    } else if !node.is_leaf() && self.subtrees.len(index) >= FEWEST_OBJECTS {
                        below.extend([node.first, node.first + 1]);
                    }
                }
                std::mem::swap(level, below);
            }
            let may_be_seen = |object: &u32| {
                !hidden.has(*object) || self.scene.objects()[*object as usize].never_cull
            };
            undecided.clear();
            undecided.extend(in_frustum.iter().copied().filter(may_be_seen));
        });
        let share = match self.tasks.threads() {
            1 => undecided.len().max(1),
            _ => OBJECTS_PER_TASK,
        };
        let count = undecided.len().div_ceil(share);
        grow(tests, count);
        let tests = &mut tests[..count];
        self.tasks.each(Work::Test, tests, |task, test| {
            test.ask(self, share_of(undecided, share, task), &question);
        });
        found.visible.clear();
        for test in tests {
            found.visible.extend_from_slice(&test.kept);
        }
        found.statistics.objects_tested = undecided.len() as u64;
    }
}

impl Test {
    fn ask(&mut self, frame: &Frame<'_>, objects: &[u32], question: &Question<'_>) {
        let scene = frame.scene;
        self.footprints.clear();
        question.buffer.screen().footprints_of_aabbs(
            frame.settings.level,
            objects.iter().map(|&o| &scene.bounds()[o as usize]),
            &mut self.footprints,
        );
        let asked = objects.iter().zip(&self.footprints);
        let kept = asked.filter(|&(&object, &footprint)| {
            scene.objects()[object as usize].never_cull || !question.hides(footprint)
        });
        self.kept.clear();
        self.kept.extend(kept.map(|(&object, _)| object));
    }
}
