//! What each hot loop costs on each instruction set of the machine.
//!
//! `cargo bench --bench kernels`. All work on a sheet of hills that fills the picture: in squares of about 8 pixels or of
//! 128. Questions are about what lies behind it, so that every answer is "hidden" and every tile has to be read: what
//! can be seen shows itself sooner.

mod common;

use antumbra::glam::{DAffine3, DVec3};
use antumbra::occlusion::{Occluder, OcclusionBuffer};
use antumbra::prepare::ClusteredMesh;
use antumbra::raster::{CullMode, Geometry, Positions, TileBuffer};
use antumbra::scene::{Aabb, Mesh};
use antumbra::view::{Camera, Projection};
use antumbra_simd::Level;
use antumbra_simd::assemble::{AssembleMemory, Drawing, assemble};
use antumbra_simd::boxes::{BOXES, BoxBlock, BoxView, RectBlock, project_boxes};
use antumbra_simd::closer::is_box_hidden;
use antumbra_simd::projected::CornerBox;
use antumbra_simd::pyramid::{sum_2x2, uncovered};
use antumbra_simd::query::{Rectangle, is_behind_all};
use antumbra_simd::spans::SpanBlocks;
use common::clusters::{Canvas, cluster, layered, tiles};
use common::{Chance, mesh, quick, size};
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

/// So many questions make a batch.
const QUESTIONS: usize = 1_024;

/// At the origin, looking along −z. What it sees at a distance of 10 is 16⅔ wide and 10 high.
fn camera() -> Camera {
    let projection = Projection::Perspective {
        fov_y: 2.0 * 0.5_f64.atan(),
        near: 0.1,
        far: None,
    };
    Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection).expect("a camera")
}

/// Hills about 10 away that fill the picture and an eighth more, in squares of about so many pixels.
fn hills(pixels: u32) -> Mesh {
    let [across, down] = [1280, 768].map(|length| length * 9 / 8 / pixels + 1);
    let step = f64::from(pixels) * 10.0 / 768.0;
    let vertex = |i: u32| {
        let (column, row) = (i % (across + 1), i / (across + 1));
        let at = |i: u32, count: u32| (f64::from(i) - f64::from(count) / 2.0) * step;
        let (x, y) = (at(column, across), at(row, down));
        let z = -10.0 + 0.3 * (zigzag(x) + zigzag(y));
        [x as f32, y as f32, z as f32]
    };
    let square = |i: u32| {
        let a = i / across * (across + 1) + i % across;
        let d = a + across + 1;
        [[a, a + 1, d + 1], [a, d + 1, d]]
    };
    mesh(
        (0..(across + 1) * (down + 1)).map(vertex).collect(),
        (0..across * down).flat_map(square).collect(),
    )
}

/// Up and down between −1 and 1, over a length of 4.
fn zigzag(x: f64) -> f64 {
    ((x / 4.0).rem_euclid(1.0) - 0.5).abs() * 4.0 - 1.0
}

/// The tiles that show the hills.
fn drawn(hills: &Mesh) -> TileBuffer {
    let indices: Vec<u32> = hills.triangles.iter().flatten().copied().collect();
    let mut buffer = OcclusionBuffer::new(size(), camera());
    buffer.draw(&Occluder {
        geometry: Geometry::new(Positions::packed(&hills.positions), &indices).expect("in range"),
        world_from_local: DAffine3::IDENTITY,
        cull_mode: CullMode::Back,
    });
    assert!(buffer.tiles().coverage().iter().all(|&c| c == u64::MAX));
    buffer.tiles().clone()
}

/// A mesh's triangles as blocks, before a picture that shows nothing yet.
fn assemble_all(level: Level, mesh: &ClusteredMesh, nothing: &TileBuffer, blocks: &mut SpanBlocks) {
    let screen = camera().screen_from_eye(size());
    let drawing = Drawing {
        screen: &screen,
        cull: CullMode::Back,
        width: size().width() as i32,
        height: size().height() as i32,
        inset: 0,
        drawn: layered(nothing),
    };
    let (mut vertices, mut to_clip) = (AssembleMemory::default(), Vec::new());
    blocks.clear();
    for index in 0..mesh.clusters().len() {
        let cluster = cluster(mesh.geometry(index));
        assemble(level, cluster, drawing, &mut vertices, blocks, &mut to_clip);
    }
    assert!(to_clip.is_empty());
}

fn triangles(c: &mut Criterion) {
    let nothing = TileBuffer::new(size());
    for (what, pixels) in [("small", 8), ("large", 128)] {
        let hills = ClusteredMesh::new(&hills(pixels));
        let count = hills.triangle_count() as u64;
        let mut blocks = SpanBlocks::default();
        assemble_all(Level::best(), &hills, &nothing, &mut blocks);
        let empty = Canvas::new(size());
        let mut full = empty.clone();
        full.fill(Level::best(), &blocks);
        assert_eq!(full.covered(), 1280 * 768);
        for &level in Level::available() {
            let mut group = c.benchmark_group("assemble");
            group.throughput(Throughput::Elements(count));
            group.bench_function(BenchmarkId::new(what, level), |b| {
                let mut blocks = SpanBlocks::default();
                b.iter(|| assemble_all(level, &hills, &nothing, &mut blocks));
            });
            group.finish();
            let mut group = c.benchmark_group("fill");
            group.throughput(Throughput::Elements(count));
            group.bench_function(BenchmarkId::new(what, level), |b| {
                let fill = |canvas: &mut Canvas| canvas.fill(level, &blocks);
                b.iter_batched_ref(|| empty.clone(), fill, BatchSize::LargeInput);
            });
        }
    }
}

fn rectangles(c: &mut Criterion) {
    let buffer = drawn(&hills(8));
    let mut chance = Chance(1);
    let mut group = c.benchmark_group("rectangle");
    group.throughput(Throughput::Elements(QUESTIONS as u64));
    for [width, height] in [[24, 16], [320, 192]] {
        let rectangles: Vec<Rectangle> = (0..QUESTIONS)
            .map(|_| {
                let mut at = |length: i32, of: i32| {
                    let first = chance.whole(of - length);
                    [first, first + length - 1]
                };
                Rectangle {
                    x: at(width, 1280),
                    y: at(height, 768),
                    nearest: 0.1 / 11.0,
                }
            })
            .collect();
        for &level in Level::available() {
            group.bench_function(BenchmarkId::new(format!("{width}x{height}"), level), |b| {
                b.iter(|| {
                    let hidden = |&&r: &&Rectangle| is_behind_all(level, tiles(&buffer), r);
                    let hidden = rectangles.iter().filter(hidden).count();
                    assert_eq!(hidden, QUESTIONS);
                });
            });
        }
    }
}

/// The camera as loops over boxes take it.
fn box_view() -> BoxView {
    let screen = camera().screen_from_eye(size());
    let norm = |[x, y, z, _]: [f64; 4]| DVec3::new(x, y, z).length();
    BoxView {
        norms: [screen.x, screen.y, screen.depth, screen.w].map(norm),
        screen,
        snap_error: 0.501,
        relative_error: 1e-12,
        slope_error: antumbra_simd::triangle::DepthPlane::SLOPE_ERROR,
        size: [1280.0, 768.0],
    }
}

/// Boxes behind the hills and within the picture.
fn boxes_behind(edge: f64) -> Vec<Aabb> {
    let mut chance = Chance(2);
    let (from, to) = (DVec3::new(-9.0, -5.0, -20.0), DVec3::new(9.0, 5.0, -15.0));
    (0..QUESTIONS)
        .map(|_| {
            let middle = chance.point(from, to);
            Aabb::around([middle]).grown(edge / 2.0)
        })
        .collect()
}

fn block_of(boxes: &[Aabb]) -> BoxBlock {
    let mut block = BoxBlock::EMPTY;
    for (i, b) in boxes.iter().enumerate() {
        for axis in 0..3 {
            block.min[axis][i] = b.min[axis];
            block.max[axis][i] = b.max[axis];
        }
    }
    block
}

fn boxes(c: &mut Criterion) {
    let view = box_view();
    let mut group = c.benchmark_group("boxes");
    group.throughput(Throughput::Elements(QUESTIONS as u64));
    let blocks: Vec<BoxBlock> = boxes_behind(0.5).chunks(BOXES).map(block_of).collect();
    for &level in Level::available() {
        group.bench_function(BenchmarkId::new("projected", level), |b| {
            let mut rects = RectBlock::EMPTY;
            b.iter(|| {
                for block in &blocks {
                    project_boxes(level, &view, block, &mut rects);
                    assert_eq!(rects.bounded, u8::MAX);
                }
            });
        });
    }

    let buffer = drawn(&hills(8));
    for (what, edge) in [("small", 0.5), ("large", 4.0)] {
        let boxes: Vec<(CornerBox, Rectangle)> = boxes_behind(edge).iter().map(asked).collect();
        for &level in Level::available() {
            group.bench_function(
                BenchmarkId::new(format!("close question, {what}"), level),
                |b| {
                    b.iter(|| {
                        let hidden = |(corners, rectangle): &&(CornerBox, Rectangle)| {
                            is_box_hidden(level, &view, layered(&buffer), corners, *rectangle)
                        };
                        assert_eq!(boxes.iter().filter(hidden).count(), QUESTIONS);
                    });
                },
            );
        }
    }
}

/// A box as the close question takes it.
fn asked(b: &Aabb) -> (CornerBox, Rectangle) {
    let corners = b.corners();
    let corner_box = CornerBox {
        corners: std::array::from_fn(|axis| corners.map(|corner| corner[axis])),
        error: 0.0,
        mirrored: false,
    };
    let mut rects = RectBlock::EMPTY;
    project_boxes(Level::best(), &box_view(), &block_of(&[*b]), &mut rects);
    let rectangle = Rectangle {
        x: rects.x.map(|x| x[0] as i32),
        y: rects.y.map(|y| y[0] as i32),
        nearest: rects.nearest[0] as f32,
    };
    (corner_box, rectangle)
}

fn pyramid(c: &mut Criterion) {
    let buffer = drawn(&hills(128));
    let (across, down) = (size().tiles_across(), size().tiles_down());
    let picture = vec![u64::MAX; across * down];
    let mut fine = vec![0; across * down];
    let mut coarse = vec![0; across.div_ceil(2) * down.div_ceil(2)];
    let mut group = c.benchmark_group("pyramid");
    group.throughput(Throughput::Elements(fine.len() as u64));
    for &level in Level::available() {
        group.bench_function(BenchmarkId::new("count", level), |b| {
            b.iter(|| uncovered(level, buffer.coverage(), &picture, &mut fine));
        });
        group.bench_function(BenchmarkId::new("sum 2x2", level), |b| {
            b.iter(|| sum_2x2(level, &fine, across, &mut coarse));
        });
    }
}

criterion_group!(name = benches; config = quick(); targets = triangles, rectangles, boxes, pyramid);
criterion_main!(benches);
