//! What the benches share: scenes to stand in, and the mean frame of a walk.
#![allow(dead_code)] // Each bench uses its own share.

pub mod clusters;
pub mod town;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use antumbra::cull::{Culler, Level, Settings, VisibleSet};
use antumbra::glam::{DAffine3, DMat4, DVec3};
use antumbra::scene::{Alpha, Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, CameraPath, PictureSize};
use antumbra_fixtures::{Fixture, Kind, Recipe, generate};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion};

/// A scene, and cameras that walk through it.
#[derive(Clone)]
pub struct Stage {
    pub scene: Arc<Scene>,
    pub cameras: Vec<Camera>,
}

/// So many cameras stand for a generated scene's path.
const CAMERAS: usize = 8;

impl Stage {
    /// A generated scene.
    pub fn generated(kind: Kind, triangles: Option<u64>) -> Stage {
        let recipe = Recipe {
            triangles,
            ..Recipe::new(kind)
        };
        let fixture = generate(&recipe).expect("enough triangles");
        let path = CameraPath::parse(&fixture.path_json(), Path::new("generated"))
            .expect("a generated path");
        let every = path.cameras().len() / CAMERAS;
        Stage {
            cameras: path
                .cameras()
                .iter()
                .step_by(every)
                .take(CAMERAS)
                .copied()
                .collect(),
            scene: Arc::new(scene_of(fixture)),
        }
    }

    /// A real scene and every so many cameras of its path, where there is one, see [`real_scene`].
    pub fn real(name: &str, every: usize) -> Option<Stage> {
        let file = real_scene(name)?;
        let path = CameraPath::load(&file.with_extension("path.json")).expect("a path");
        Some(Stage {
            scene: Arc::new(Scene::load(&file).expect("a sound file")),
            cameras: path.cameras().iter().step_by(every).copied().collect(),
        })
    }
}

/// A fixture as a scene, without the way through a file.
fn scene_of(fixture: Fixture) -> Scene {
    let parts = fixture.parts.into_iter().map(|part| Mesh {
        surfaces: vec![Surface {
            triangles: 0..part.triangles.len(),
            material: Material {
                alpha: if part.alpha_blend {
                    Alpha::Blend
                } else {
                    Alpha::Opaque
                },
                double_sided: part.double_sided,
                color: part.color,
            },
        }],
        name: part.name,
        positions: part.positions.into(),
        triangles: part.triangles.into(),
    });
    let nodes = fixture.nodes.into_iter().map(|node| {
        let matrix = DMat4::from_cols_array(&node.matrix.map(f64::from));
        object(node.part, DAffine3::from_mat4(matrix))
    });
    Scene::new(parts.collect(), nodes.collect()).expect("a sound scene")
}

/// A mesh placed somewhere.
pub fn object(mesh: usize, world_from_local: DAffine3) -> Object {
    Object {
        name: String::new(),
        mesh,
        world_from_local,
        never_cull: false,
        never_occlude: false,
        occluder_proxy: None,
    }
}

/// A mesh of one single-sided, opaque surface.
pub fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name: String::new(),
        surfaces: vec![Surface {
            triangles: 0..triangles.len(),
            material: Material::default(),
        }],
        positions: positions.into(),
        triangles: triangles.into(),
    }
}

/// A real scene's file, where there is one: in the folder `ANTUMBRA_SCENES`, by default `../shared/scenes`.
pub fn real_scene(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("ANTUMBRA_SCENES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        PathBuf::from,
    );
    let file = folder.join(format!("{name}.glb"));
    if !file.exists() {
        eprintln!("skipped: there is no {}", file.display());
        return None;
    }
    Some(file)
}

/// The picture of all benches.
pub fn size() -> PictureSize {
    PictureSize::new(1280, 768).expect("a size")
}

/// One thread, and the best instruction set.
pub fn settings() -> Settings {
    Settings {
        threads: 1,
        ..Settings::new(size())
    }
}

/// The levels with vectors of their own, and the plain form where there are none.
pub fn fast_levels() -> &'static [Level] {
    let all = Level::available();
    if all.len() > 1 { &all[1..] } else { all }
}

/// Few samples: what is measured here takes from nanoseconds to a tenth of a second, and whole tables of it.
pub fn quick() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
}

/// Whether what takes minutes to make is measured too: the variable `ANTUMBRA_BENCH_LARGE` is set.
pub fn large_too() -> bool {
    std::env::var_os("ANTUMBRA_BENCH_LARGE").is_some()
}

/// Measures the mean frame of a walk. The stage is set when criterion's filter lets the benchmark run, not before.
pub fn bench_frames(
    group: &mut BenchmarkGroup<'_, WallTime>,
    id: BenchmarkId,
    settings: Settings,
    stage: impl Fn() -> Stage,
) {
    let mut walk: Option<Walk> = None;
    group.bench_function(id, |b| {
        let walk = walk.get_or_insert_with(|| Walk::new(stage(), settings));
        b.iter_custom(|times| walk.mean_frame(times));
    });
}

/// A culler that walks past the cameras of a stage.
struct Walk {
    culler: Culler,
    cameras: Vec<Camera>,
    found: VisibleSet,
}

impl Walk {
    /// Also says what there is to cull, and what a frame does on average.
    fn new(stage: Stage, settings: Settings) -> Walk {
        let begun = Instant::now();
        let mut walk = Walk {
            culler: Culler::new(stage.scene, settings).expect("threads"),
            cameras: stage.cameras,
            found: VisibleSet::default(),
        };
        let prepared = begun.elapsed();
        // Once, so that all memory is there.
        walk.mean_frame(1);
        let (mut counts, mut times) = ([0; 5], [Duration::ZERO; 4]);
        for camera in &walk.cameras {
            walk.culler.cull_into(camera, &mut walk.found);
            let (s, t) = (walk.found.statistics, walk.found.times);
            let of_frame = [
                walk.culler.in_frustum(camera).len() as u64,
                s.objects_visible,
                s.occluders_asked + s.nodes_tested + s.objects_tested,
                walk.found.occluders.len() as u64,
                s.occluder_triangles,
            ];
            counts = std::array::from_fn(|i| counts[i] + of_frame[i]);
            let of_frame = [t.select, t.raster, t.pyramid, t.test];
            times = std::array::from_fn(|i| times[i] + of_frame[i]);
        }
        let frames = walk.cameras.len() as u32;
        let [in_frustum, visible, questions, drawn, triangles] =
            counts.map(|c| c / u64::from(frames));
        let [select, raster, pyramid, test] = times.map(|t| t / frames);
        let scene = walk.culler.scene();
        eprintln!(
            "{} objects, {} triangles, prepared in {prepared:.0?}; a frame: {in_frustum} objects in the frustum, \
             {visible} visible, {questions} questions, {drawn} clusters drawn with {triangles} triangles; select {select:.0?}, raster {raster:.0?}, \
             pyramid {pyramid:.0?}, test {test:.0?}",
            scene.objects().len(),
            scene.triangle_count(),
        );
        walk
    }

    /// Walks so many times; as many mean frames, each frame by the least time that it took: what else runs on a machine
    /// makes nothing faster.
    fn mean_frame(&mut self, times: u64) -> Duration {
        let mut least = vec![Duration::MAX; self.cameras.len()];
        for _ in 0..times {
            for (camera, least) in self.cameras.iter().zip(&mut least) {
                let begun = Instant::now();
                self.culler.cull_into(camera, &mut self.found);
                *least = begun.elapsed().min(*least);
            }
        }
        least.iter().sum::<Duration>() * times as u32 / self.cameras.len() as u32
    }
}

/// Numbers that are the same on every machine (splitmix64).
pub struct Chance(pub u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn whole(&mut self, below: i32) -> i32 {
        (self.next() % below as u64) as i32
    }

    pub fn real(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn point(&mut self, from: DVec3, to: DVec3) -> DVec3 {
        DVec3::new(
            self.real(from.x, to.x),
            self.real(from.y, to.y),
            self.real(from.z, to.z),
        )
    }
}
