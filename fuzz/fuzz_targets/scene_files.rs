//! Bytes to the loaders: they end in an error or in a valid scene, which is culled without a panic and exactly, in the memory
//! that is promised.
#![no_main]

#[path = "../../tests/archives/mod.rs"]
mod archives;
#[path = "../scene_bytes.rs"]
mod scene_bytes;
#[path = "../../tests/scene_files/mod.rs"]
mod scene_files;

use std::path::PathBuf;
use std::sync::OnceLock;

use antumbra::cull::{Culler, Settings};
use antumbra::final_pass::render_image;
use antumbra::glam::DVec3;
use antumbra::prepare::Prepared;
use antumbra::view::{Camera, PictureSize, Projection};
use libfuzzer_sys::fuzz_target;

/// Scenes with more triangles are loaded only.
const DRAWN: u64 = 20_000;

fn folder() -> &'static PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("antumbra-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("the temporary folder can be written");
        folder
    })
}

/// The most memory that the process has had since [`forget_peak`], in bytes; none where the system does not tell.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.replace("kB", "").trim().parse().ok()?;
    Some(kib << 10)
}

fn forget_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// The picture of what is left is the picture of the scene.
fn cull(prepared: &Prepared) {
    let scene = prepared.scene();
    let size = PictureSize::new(48, 40).expect("a size");
    let settings = Settings {
        threads: 1,
        ..Settings::new(size)
    };
    let mut culler = Culler::with_prepared(prepared, settings).expect("one thread needs no pool");
    let all: Vec<u32> = (0..scene.objects().len() as u32).collect();
    // A proxy that is none hides what its object does not: that is its maker's business.
    let by_proxy = scene.objects().iter().any(|o| o.occluder_proxy.is_some());
    let bounds = scene.bounds()[scene.bounds().len() / 2];
    let (middle, half) = (
        (bounds.min + bounds.max) * 0.5,
        (bounds.max - bounds.min) * 0.5,
    );
    for (direction, far) in [
        (DVec3::new(0.3, 0.2, 1.0), 3.0),
        (DVec3::new(-1.0, 0.4, -0.1), 1.1),
        (DVec3::new(0.1, -0.1, 0.9), 20.0),
    ] {
        let projection = Projection::Perspective {
            fov_y: 1.2,
            near: half.length().clamp(1e-6, 1e6) * 1e-3,
            far: None,
        };
        let eye = middle + direction * far * half.length().max(1e-3);
        let Ok(camera) = Camera::look_at(eye, middle, DVec3::Y, projection) else {
            continue;
        };
        let visible = culler.cull(&camera).visible;
        if by_proxy {
            continue;
        }
        let picture = |objects: &[u32]| render_image(scene, &camera, size, objects);
        assert_eq!(picture(&visible).differing_pixels(&picture(&all)), 0);
    }
}

fuzz_target!(|input: &[u8]| {
    let Some(bytes) = scene_bytes::scene_bytes(input) else {
        return;
    };
    let path = folder().join(bytes.name);
    std::fs::write(folder().join("paint.mtl"), &bytes.materials).expect("written");
    std::fs::write(&path, &bytes.file).expect("written");
    forget_peak();
    let before = peak();
    let loaded = Prepared::load(&path);
    if let (Some(before), Some(after)) = (before, peak()) {
        // What is prepared takes no more than half of what is loaded.
        let limit = 15 * (bytes.file.len() + bytes.materials.len()) as u64 + (64 << 20);
        assert!(
            after.saturating_sub(before) < limit,
            "{} MiB to load {} bytes",
            (after - before) >> 20,
            bytes.file.len()
        );
    }
    let Ok(prepared) = loaded else {
        return;
    };
    let scene = prepared.scene();
    assert_eq!(scene.bvh().validate(scene.bounds()), Ok(()));
    let drawn: u64 = scene
        .objects()
        .iter()
        .map(|o| scene.meshes()[o.mesh].triangles.len() as u64)
        .sum();
    if drawn <= DRAWN {
        cull(&prepared);
    }
});
