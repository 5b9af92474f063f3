//! What the tests of archives share: a scene with one of everything, and archives taken apart and put together again, from
//! the layout alone.
#![allow(dead_code, reason = "each test file uses some")]

use std::path::PathBuf;
use std::sync::Arc;

use antumbra::cull::{Culler, Settings};
use antumbra::final_pass::render_image;
use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::prepare::{
    ArchiveError, ClusterId, GridLayout, Prepared, SampledCluster, VisibilityGrid,
};
use antumbra::scene::{Alpha, Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, PictureSize, Projection};

/// An empty folder that is removed at the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Folder {
        // Where this is not a test of the package, there is no folder for tests.
        let tests = option_env!("CARGO_TARGET_TMPDIR").map(PathBuf::from);
        let folder = tests.unwrap_or_else(std::env::temp_dir).join(name);
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder can be made");
        Folder(folder)
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let file = self.file(name);
        std::fs::write(&file, bytes).expect("written");
        file
    }

    /// The bytes of what is saved.
    pub fn saved(&self, prepared: &Prepared) -> Vec<u8> {
        let file = self.file("saved.antumbra");
        let length = prepared.save(&file).expect("saved");
        let bytes = std::fs::read(&file).expect("read");
        assert_eq!(bytes.len() as u64, length);
        bytes
    }

    /// What bytes load as.
    pub fn load(&self, bytes: &[u8]) -> Result<Prepared, ArchiveError> {
        Prepared::load(&self.write("loaded.antumbra", bytes))
    }

    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).expect("the folder is there");
        let name = |e: std::io::Result<std::fs::DirEntry>| e.expect("an entry").file_name();
        let mut names: Vec<String> = entries
            .map(|e| name(e).to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn surface(triangles: std::ops::Range<usize>, alpha: Alpha, double_sided: bool) -> Surface {
    Surface {
        triangles,
        material: Material {
            alpha,
            double_sided,
            color: [0.25, 0.5, 0.75, 1.0],
        },
    }
}

/// A bent sheet of `n`×`n` squares, ±1 across.
fn sheet(name: &str, n: u32, surfaces: impl Fn(usize) -> Vec<Surface>) -> Mesh {
    let row = |i: u32| f64::from(i) * 2.0 / f64::from(n) - 1.0;
    let vertex = |i: u32| {
        let (x, y) = (row(i % (n + 1)), row(i / (n + 1)));
        [x as f32, y as f32, (0.1 * x * x - 0.05 * x * y) as f32]
    };
    let square = |i: u32| {
        let a = i / n * (n + 1) + i % n;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    let triangles: Vec<[u32; 3]> = (0..n * n).flat_map(square).collect();
    Mesh {
        name: name.to_owned(),
        positions: (0..(n + 1) * (n + 1)).map(vertex).collect(),
        surfaces: surfaces(triangles.len()),
        triangles: triangles.into(),
    }
}

/// An object somewhere.
pub fn object(name: &str, mesh: usize, world_from_local: DAffine3) -> Object {
    Object {
        name: name.to_owned(),
        mesh,
        world_from_local,
        never_cull: false,
        never_occlude: false,
        occluder_proxy: None,
    }
}

/// A row of sheets, one behind the other: single- and double-sided, mixed, glass, cut out, mirrored; a mesh that nobody
/// places and one without triangles. With proxies if asked for.
pub fn scene(fineness: u32, with_proxies: bool) -> Scene {
    let whole = |alpha, double_sided| move |all| vec![surface(0..all, alpha, double_sided)];
    let mixed = |all: usize| {
        vec![
            surface(0..all / 3, Alpha::Opaque, true),
            surface(all / 3..all / 3, Alpha::Mask, false),
            surface(all / 3..all - 1, Alpha::Opaque, false),
            surface(all - 1..all, Alpha::Blend, false),
        ]
    };
    let mut core = sheet("core", 1, whole(Alpha::Opaque, true));
    // Both zeros, a triangle that is a line, and a vertex that none uses.
    core.positions.to_mut()[0] = [-0.9, -0.9, -0.0];
    core.positions.to_mut().push([7.0, -0.0, 0.0]);
    core.triangles.to_mut().push([1, 1, 2]);
    core.surfaces[0].triangles.end += 1;
    let meshes = vec![
        sheet("wall", fineness, whole(Alpha::Opaque, false)),
        sheet("Türblatt", fineness, whole(Alpha::Opaque, true)),
        sheet("mixed", fineness, mixed),
        sheet("glass", 1, whole(Alpha::Blend, true)),
        sheet("", 1, whole(Alpha::Mask, false)),
        core,
        Mesh::default(),
    ];
    let turned = DMat3::from_cols(
        DVec3::new(0.6, 0.8, 0.0),
        DVec3::new(-0.8, 0.6, 0.0),
        DVec3::Z,
    );
    let mut objects = Vec::new();
    for i in 0..12u32 {
        let z = -f64::from(i);
        let matrix3 = match i % 3 {
            0 => DMat3::from_diagonal(DVec3::new(1.0 + 0.1 * z, 1.0, 1.0)),
            1 => turned,
            _ => DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 0.5)),
        };
        let translation = DVec3::new(0.01 * z, 0.02 * z, z);
        let place = DAffine3 {
            matrix3,
            translation,
        };
        objects.push(object(&format!("object {i} ✓"), i as usize % 5, place));
    }
    objects[4].never_cull = true;
    objects[6].never_occlude = true;
    objects[11].name.clear();
    if with_proxies {
        objects[0].occluder_proxy = Some(5);
        objects[5].occluder_proxy = Some(6);
        objects[6].occluder_proxy = Some(0);
    }
    Scene::new(meshes, objects).expect("a sound scene")
}

pub fn prepared(fineness: u32, with_proxies: bool) -> Prepared {
    let prepared = Prepared::new(Arc::new(scene(fineness, with_proxies)));
    let layout = GridLayout {
        first: DVec3::new(0.0, 0.0, -4.0),
        spacing: 4.0,
        counts: [1, 1, 2],
    };
    let occludes = |&object: &usize| {
        let object = &prepared.scene().objects()[object];
        prepared.occluders().occluder(object).is_some()
    };
    let seen = |object: usize| SampledCluster {
        id: ClusterId {
            object: object as u32,
            cluster: 0,
        },
        solid_angle: 0.25,
    };
    let objects = 0..prepared.scene().objects().len();
    let list: Vec<SampledCluster> = objects.filter(occludes).take(2).map(seen).collect();
    let grid = VisibilityGrid::new(layout, &[list, Vec::new()]).expect("a grid");
    prepared
        .with_visibility_grid(Arc::new(grid))
        .expect("its own")
}

/// Cameras before, beside and within the row.
pub fn cameras() -> Vec<Camera> {
    let projection = Projection::Perspective {
        fov_y: 1.0,
        near: 0.01,
        far: None,
    };
    let flat = Projection::Orthographic {
        height: 3.0,
        near: 0.1,
        far: Some(20.0),
    };
    let camera = |eye, target, projection| {
        Camera::look_at(eye, target, DVec3::Y, projection).expect("a camera")
    };
    let middle = DVec3::new(0.0, 0.0, -6.0);
    vec![
        camera(DVec3::new(0.1, 0.2, 3.0), middle, projection),
        camera(DVec3::new(0.1, 0.25, 2.0), middle, projection),
        camera(DVec3::new(3.0, 1.0, -5.5), middle, projection),
        camera(DVec3::new(0.3, 0.1, -14.0), middle, flat),
    ]
}

pub fn size() -> PictureSize {
    PictureSize::new(160, 96).expect("a size")
}

/// Culls some frames; the picture of the survivors has to be that of the scene.
pub fn cull_exactly(prepared: &Prepared, said: &str) {
    let settings = Settings {
        threads: 1,
        ..Settings::new(size())
    };
    let mut culler = Culler::with_prepared(prepared, settings).expect("threads");
    let all: Vec<u32> = (0..prepared.scene().objects().len() as u32).collect();
    for (frame, camera) in cameras().iter().enumerate() {
        let visible = culler.cull(camera).visible;
        // A proxy hides what its object does not if it is none: that is its maker's business.
        if prepared
            .scene()
            .objects()
            .iter()
            .any(|o| o.occluder_proxy.is_some())
        {
            continue;
        }
        let picture = |objects: &[u32]| render_image(prepared.scene(), camera, size(), objects);
        let wrong = picture(&visible).differing_pixels(&picture(&all));
        assert_eq!(wrong, 0, "{said}, frame {frame}");
    }
}

/// A section of an archive.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    pub kind: u32,
    pub flags: u32,
    pub bytes: Vec<u8>,
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("8 bytes"))
}

pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes"))
}

/// The sections of a sound archive.
pub fn take_apart(archive: &[u8]) -> Vec<Section> {
    let entry = |i: usize| 32 + 32 * i;
    let section = |i: usize| {
        let (start, length) = (
            u64_at(archive, entry(i) + 8),
            u64_at(archive, entry(i) + 16),
        );
        let bytes = archive[start as usize..][..length as usize].to_vec();
        assert_eq!(u64_at(archive, entry(i) + 24), checksum(&bytes));
        Section {
            kind: u32_at(archive, entry(i)),
            flags: u32_at(archive, entry(i) + 4),
            bytes,
        }
    };
    (0..u32_at(archive, 12) as usize).map(section).collect()
}

/// An archive of these sections, with checksums that hold.
pub fn put_together(version: u32, sections: &[Section]) -> Vec<u8> {
    let mut archive = b"ANTUMBRA".to_vec();
    archive.extend(version.to_le_bytes());
    archive.extend((sections.len() as u32).to_le_bytes());
    archive.extend([0; 16]);
    let mut end = 32 + 32 * sections.len();
    for section in sections {
        let start = end.next_multiple_of(64);
        end = start + section.bytes.len();
        archive.extend(section.kind.to_le_bytes());
        archive.extend(section.flags.to_le_bytes());
        archive.extend((start as u64).to_le_bytes());
        archive.extend((section.bytes.len() as u64).to_le_bytes());
        archive.extend(checksum(&section.bytes).to_le_bytes());
    }
    archive[16..24].copy_from_slice(&(end as u64).to_le_bytes());
    let sum = checksum(&archive);
    archive[24..32].copy_from_slice(&sum.to_le_bytes());
    for section in sections {
        archive.resize(archive.len().next_multiple_of(64), 0);
        archive.extend(&section.bytes);
    }
    archive
}

/// The checksum as the format has it, a byte at a time.
pub fn checksum(bytes: &[u8]) -> u64 {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    let step = |lane: u64, word: u64| ((lane ^ word).wrapping_mul(ODD)).rotate_left(29);
    let mut lanes = [0, 8, 16, 24, 32, 40, 48, 56].map(|turn| ODD.rotate_left(turn));
    for start in (0..bytes.len()).step_by(8) {
        let word = (0..8).fold(0, |word, i| {
            word | u64::from(bytes.get(start + i).copied().unwrap_or(0)) << (8 * i)
        });
        let lane = &mut lanes[start / 8 % 8];
        *lane = step(*lane, word);
    }
    let sum = lanes.iter().fold(0, |sum, &lane| step(sum, lane));
    let sum = step(sum, bytes.len() as u64);
    (sum ^ (sum >> 32)).wrapping_mul(ODD)
}
