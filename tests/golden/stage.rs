//! A scene with its cameras, ready to be drawn.

use std::path::Path;
use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::final_pass::{Image, PictureFrame, overlay_image, render_image};
use antumbra::occluders::{Budget, DrawnCluster};
use antumbra::occlusion::OcclusionBuffer;
use antumbra::scene::Scene;
use antumbra::view::{Camera, CameraPath, PictureSize, Projection};
use antumbra_fixtures::{Kind, Recipe, generate};

/// Whole tiles fit neither across nor down.
pub const WIDTH: u32 = 317;
pub const HEIGHT: u32 = 211;

/// A scene and its camera path.
#[derive(Clone)]
pub struct Stage {
    pub name: String,
    pub scene: Arc<Scene>,
    pub cameras: Vec<Camera>,
    pub size: PictureSize,
}

/// What one frame looks like, and what it was drawn from.
#[derive(Debug, PartialEq)]
pub struct Shot {
    /// What the camera sees, drawn from the survivors.
    pub picture: Image,
    /// The buffer that the objects were tested against.
    pub occluders: Image,
    /// Objects in the frustum, and visible ones.
    pub objects: [Vec<u32>; 2],
    /// The clusters drawn as occluders.
    pub drawn: Vec<DrawnCluster>,
    /// A hash of the buffer.
    pub buffer_hash: u64,
}

impl Stage {
    /// A scene and cameras made in code.
    pub fn new(name: impl Into<String>, scene: Scene, cameras: Vec<Camera>) -> Stage {
        Stage {
            name: name.into(),
            scene: Arc::new(scene),
            cameras,
            size: PictureSize::new(WIDTH, HEIGHT).expect("a size"),
        }
    }

    /// A generated scene, written to a file and read again, and its walk.
    pub fn generated(kind: Kind, triangles: u64) -> Stage {
        let recipe = Recipe {
            kind,
            triangles: Some(triangles),
            seed: 1,
        };
        let fixture = generate(&recipe).expect("enough triangles");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        // Tests run at once: each call has a file of its own.
        let thread = std::thread::current();
        let test = thread.name().unwrap_or("main").replace("::", "-");
        let file = folder.join(format!("golden-{test}-{kind}.glb"));
        let out = std::fs::File::create(&file).expect("the file can be written");
        fixture.write_glb(out).expect("the file can be written");
        let scene = Scene::load(&file).expect("a sound file");
        let _ = std::fs::remove_file(&file);
        let path = CameraPath::parse(&fixture.path_json(), &file).expect("a path");
        Stage::new(kind.name(), scene, path.cameras().to_vec())
    }

    /// A frame, culled and drawn.
    pub fn shoot(&self, frame: usize) -> Shot {
        self.shoot_all(2, &[frame]).remove(0)
    }

    /// Frames, culled and drawn one after another on so many threads.
    pub fn shoot_all(&self, threads: usize, frames: &[usize]) -> Vec<Shot> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        let mut culler = self.culler(threads);
        let shots = frames.iter().map(|&frame| {
            let camera = &self.cameras[frame];
            let set = culler.cull(camera);
            let buffer = culler.buffer().expect("a frame was culled");
            Shot {
                picture: pool
                    .install(|| render_image(&self.scene, camera, self.size, &set.visible)),
                occluders: occluders_in_grey(buffer, camera.projection(), self.size),
                objects: [culler.in_frustum(camera), set.visible],
                drawn: set.occluders,
                buffer_hash: buffer.tiles().hash(),
            }
        });
        shots.collect()
    }

    /// The sheet that shows what the culling of a frame did.
    pub fn overlay(&self, frame: usize, title: &str) -> Image {
        let (scene, camera, size) = (&*self.scene, &self.cameras[frame], self.size);
        let mut culler = self.culler(2);
        let set = culler.cull(camera);
        let in_frustum = culler.in_frustum(camera);
        let map = culler.buffer().expect("a frame was culled").map();
        let picture = render_image(scene, camera, size, &set.visible);
        let set = &set;
        let culled = PictureFrame {
            scene,
            camera,
            size,
            in_frustum: &in_frustum,
            set,
            map,
        };
        overlay_image(&culled, &picture, title)
    }

    fn culler(&self, threads: usize) -> Culler {
        // Every occluder is drawn, so that a frame does not depend on those before it.
        let settings = Settings {
            threads,
            budget: Budget::All,
            ..Settings::new(self.size)
        };
        Culler::new(self.scene.clone(), settings).expect("threads")
    }

    /// What the camera sees, drawn from the whole scene.
    pub fn picture_without_culling(&self, frame: usize) -> Image {
        let all: Vec<u32> = (0..self.scene.objects().len() as u32).collect();
        render_image(&self.scene, &self.cameras[frame], self.size, &all)
    }
}

/// Coverage and depth of each pixel: black where nothing is covered, else the lighter the nearer.
fn occluders_in_grey(
    buffer: &OcclusionBuffer,
    projection: &Projection,
    size: PictureSize,
) -> Image {
    let shade = |depth: f32| match *projection {
        // The bits of a positive float count up with its logarithm: 16 shades each time that the distance doubles,
        // from 0.1 m to 200 m, say.
        Projection::Perspective { .. } => {
            let below_nearest = 1f32.to_bits().saturating_sub(depth.to_bits()) >> 19;
            255 - below_nearest.min(215) as u8
        }
        Projection::Orthographic { near, far, .. } => {
            let reach = far.expect("the golden scenes have a far plane") - near;
            let share = (-f64::from(depth) - near) / reach;
            255 - (share * 215.0) as u8
        }
    };
    let mut picture = Image::filled(size.width(), size.height(), [0; 3]);
    for (i, pixel) in picture.pixels_mut().iter_mut().enumerate() {
        if let Some(depth) = buffer.pixel(i % size.width(), i / size.width()) {
            *pixel = [shade(depth); 3];
        }
    }
    picture
}
