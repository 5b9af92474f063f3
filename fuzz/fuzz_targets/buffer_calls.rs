//! Calls of an `OcclusionBuffer` in any order, with any numbers: no panic, the same bits on every instruction set, tiles that hold what
//! was drawn and nothing nearer, and never "hidden" for a box that owns a pixel of the picture so far.
#![no_main]

#[path = "../drawn.rs"]
mod drawn;
#[path = "../numbers.rs"]
mod numbers;

use antumbra::glam::{DAffine3, DVec3};
use antumbra::occlusion::{Accuracy, Occluder, OcclusionBuffer, OrientedBox, Sphere};
use antumbra::raster::{CullMode, Geometry, Positions};
use antumbra::scene::Aabb;
use antumbra::view::Camera;
use antumbra_simd::Level;
use arbitrary::Arbitrary;
use drawn::{CUBE, FACES, Picture, cube_in, is_promised};
use libfuzzer_sys::fuzz_target;
use numbers::{CameraWish, Matrix, Number, Size, Vector};

#[derive(Clone, Debug, Arbitrary)]
enum Shape {
    Cube,
    /// A square across the z axis.
    Wall,
    Soup {
        points: Vec<[Number; 3]>,
        indices: Vec<u8>,
    },
}

#[derive(Clone, Debug, Arbitrary)]
enum Call {
    Clear(CameraWish),
    /// The same camera again.
    ClearOnly,
    Draw {
        shape: Shape,
        matrix: Matrix,
        translation: Vector,
        cull: u8,
    },
    Finish,
    Accuracy(Option<u8>),
    Aabb {
        center: Vector,
        half: Vector,
    },
    RawAabb {
        min: Vector,
        max: Vector,
    },
    Oriented {
        center: Vector,
        axes: Matrix,
    },
    Ball {
        center: Vector,
        radius: Number,
    },
    Rectangle {
        x: [Number; 2],
        y: [Number; 2],
        distance: Number,
    },
    Pixel(u8, u8),
    Map,
    Clone,
}

#[derive(Debug, Arbitrary)]
struct Program {
    size: Size,
    camera: CameraWish,
    calls: Vec<Call>,
}

struct State {
    buffers: Vec<OcclusionBuffer>,
    picture: Picture,
    camera: Camera,
    exact: bool,
}

impl State {
    /// What all instruction sets answer.
    fn ask(&self, question: impl Fn(&OcclusionBuffer) -> bool) -> bool {
        let answers: Vec<bool> = self.buffers.iter().map(question).collect();
        assert!(answers.iter().all(|a| *a == answers[0]), "{answers:?}");
        answers[0]
    }

    /// A hidden cube shows nowhere.
    fn check_cube(&self, hidden: bool, place: &DAffine3) {
        if hidden && self.exact && is_promised(place) {
            let shows = self.picture.shows(&self.camera, &CUBE, &FACES, place);
            assert!(!shows, "{place:?}");
        }
    }

    fn draw(&mut self, positions: &[[f32; 3]], indices: &[u32], place: DAffine3, cull: CullMode) {
        for buffer in &mut self.buffers {
            buffer.draw(&Occluder {
                geometry: Geometry::new(Positions::packed(positions), indices).expect("sound"),
                world_from_local: place,
                cull_mode: cull,
            });
        }
        self.picture
            .draw(&self.camera, positions, indices, &place, cull);
        self.picture.check(self.buffers[0].tiles());
    }

    fn clear(&mut self, camera: Camera) {
        self.camera = camera;
        self.picture = Picture::new(self.picture.size);
        for buffer in &mut self.buffers {
            buffer.clear(&camera);
        }
    }

    fn call(&mut self, call: &Call) {
        match call {
            Call::Clear(wish) => self.clear(wish.get().unwrap_or(self.camera)),
            Call::ClearOnly => self.clear(self.camera),
            Call::Draw {
                shape,
                matrix,
                translation,
                cull,
            } => {
                let place = DAffine3 {
                    matrix3: matrix.get(),
                    translation: translation.get(),
                };
                let cull = [CullMode::None, CullMode::Back, CullMode::Front][usize::from(cull % 3)];
                match shape {
                    Shape::Cube => self.draw(&CUBE, &FACES, place, cull),
                    Shape::Wall => self.draw(&CUBE, &[0, 1, 3, 0, 3, 2], place, cull),
                    Shape::Soup { points, indices } => {
                        let points: Vec<[f32; 3]> = points
                            .iter()
                            .take(24)
                            .map(|p| p.map(|n| n.0 as f32))
                            .collect();
                        let count = points.len().max(1) as u32;
                        let used = indices.len().min(60) / 3 * 3;
                        let indices: Vec<u32> = indices[..used]
                            .iter()
                            .map(|&i| u32::from(i) % count)
                            .collect();
                        if !points.is_empty() {
                            self.draw(&points, &indices, place, cull);
                        }
                    }
                }
            }
            Call::Finish => {
                for buffer in &mut self.buffers {
                    buffer.finish();
                }
                for pair in self.buffers.windows(2) {
                    assert!(pair[0].tiles() == pair[1].tiles());
                }
            }
            Call::Accuracy(hole) => {
                let accuracy = hole.map_or(Accuracy::Exact, |hole| Accuracy::Approximate {
                    hole: u32::from(hole),
                });
                self.exact = accuracy == Accuracy::Exact;
                for buffer in &mut self.buffers {
                    buffer.set_accuracy(accuracy);
                }
            }
            Call::Aabb { center, half } => {
                let (center, half) = (center.get(), half.get().abs());
                self.ask_aabb(center - half, center + half);
            }
            Call::RawAabb { min, max } => self.ask_aabb(min.get(), max.get()),
            Call::Oriented { center, axes } => {
                let (center, axes) = (center.get(), axes.get());
                let bounds = OrientedBox {
                    center,
                    half_axes: [axes.x_axis, axes.y_axis, axes.z_axis],
                };
                let hidden = self.ask(|b| b.test_oriented_box(&bounds).is_hidden());
                let place = DAffine3 {
                    matrix3: axes,
                    translation: center,
                };
                self.check_cube(hidden, &place);
            }
            Call::Ball { center, radius } => {
                let (center, radius) = (center.get(), radius.0);
                let ball = Sphere { center, radius };
                let hidden = self.ask(|b| b.test_sphere(&ball).is_hidden());
                // The cube within, a little smaller for its corners to be in the ball however they are rounded.
                let half = DVec3::splat(radius * 0.577);
                self.check_cube(hidden, &cube_in(center - half, center + half));
            }
            Call::Rectangle { x, y, distance } => {
                let (x, y) = (x.map(|n| n.0), y.map(|n| n.0));
                let hidden = self.ask(|b| b.test_rectangle(x, y, distance.0).is_hidden());
                if hidden && self.exact {
                    self.check_rectangle(x, y, distance.0);
                }
            }
            Call::Pixel(x, y) => {
                let size = self.picture.size;
                let (x, y) = (
                    usize::from(*x) % size.width(),
                    usize::from(*y) % size.height(),
                );
                let covered = self.ask(|b| b.pixel(x, y).is_some());
                assert_eq!(
                    covered,
                    self.picture.nearest[y * size.width() + x].is_some()
                );
            }
            Call::Map => {
                for buffer in &self.buffers {
                    let _ = buffer.map();
                }
            }
            Call::Clone => self.buffers = self.buffers.clone(),
        }
    }

    fn ask_aabb(&self, min: DVec3, max: DVec3) {
        let hidden = self.ask(|b| b.test_aabb(&Aabb { min, max }).is_hidden());
        self.check_cube(hidden, &cube_in(min, max));
    }

    /// At the centres within a hidden rectangle, everything is covered by what is nearer.
    fn check_rectangle(&self, x: [f64; 2], y: [f64; 2], distance: f64) {
        let size = self.picture.size;
        let depth = self.camera.projection().depth_at(distance) as f32;
        for (at, nearest) in self.picture.nearest.iter().enumerate() {
            let column = (at % size.width()) as f64 + 0.5;
            let row = (at / size.width()) as f64 + 0.5;
            if x[0] <= column && column <= x[1] && y[0] <= row && row <= y[1] {
                assert!(
                    nearest.is_some_and(|nearest| nearest > depth),
                    "({column}, {row})"
                );
            }
        }
    }
}

fuzz_target!(|program: Program| {
    let Some(camera) = program.camera.get() else {
        return;
    };
    let size = program.size.small();
    let buffer = |level: &Level| {
        let mut buffer = OcclusionBuffer::new(size, camera);
        buffer.set_level(*level);
        buffer
    };
    let mut state = State {
        buffers: Level::available().iter().map(buffer).collect(),
        picture: Picture::new(size),
        camera,
        exact: true,
    };
    for call in program.calls.iter().take(32) {
        state.call(call);
    }
});
