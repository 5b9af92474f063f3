//! Garbage in: however an archive is damaged, or made to harm, loading it ends in an error or in a scene that is as valid
//! as any.
//!
//! `ANTUMBRA_MUTATIONS` says how many mutations to try (2,000 without it).

mod archives;
mod scene_files;

use antumbra::prepare::Prepared;
use archives::*;
use scene_files::garbage::{Random, change_bytes, change_words};

#[test]
fn every_change_of_a_byte_is_found() {
    let folder = Folder::new("archive_bytes");
    let archive = folder.saved(&prepared(1, true));
    for at in 0..archive.len() {
        for change in [1 << (at % 8), 0xff] {
            let mut damaged = archive.clone();
            damaged[at] ^= change;
            assert!(folder.load(&damaged).is_err(), "byte {at} ^ {change}");
        }
    }
}

#[test]
fn every_truncation_is_found() {
    let folder = Folder::new("archive_cuts");
    let mut archive = folder.saved(&prepared(1, true));
    for length in 0..archive.len() {
        assert!(folder.load(&archive[..length]).is_err(), "{length} bytes");
    }
    archive.push(0);
    assert!(folder.load(&archive).is_err());
}

/// What has to hold of any scene that loads, whoever wrote it.
fn check(prepared: &Prepared, said: &str) {
    let scene = prepared.scene();
    assert_eq!(scene.bvh().validate(scene.bounds()), Ok(()), "{said}");
    // What another scene of these meshes and objects would have.
    let again = antumbra::scene::Scene::new(scene.meshes().to_vec(), scene.objects().to_vec());
    let again = again.expect("valid");
    assert_eq!(again.bounds(), scene.bounds(), "{said}");
    for (index, mesh) in scene.meshes().iter().enumerate() {
        let Some(clustered) = prepared.occluders().mesh(index) else {
            continue;
        };
        let corner = |i: &u32| mesh.positions[*i as usize].map(f32::to_bits);
        // From its least corner on, so that it does not matter where a triangle begins.
        let from_least = |mut corners: [[u32; 3]; 3]| {
            let least = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
            corners.rotate_left(least);
            corners
        };
        let mut own = Vec::new();
        for surface in mesh.surfaces.iter().filter(|s| s.material.occludes()) {
            for triangle in &mesh.triangles[surface.triangles.clone()] {
                let [a, b, c] = triangle.each_ref().map(|&i| mesh.positions[i as usize]);
                if a != b && b != c && c != a {
                    let corners = from_least(triangle.each_ref().map(corner));
                    own.push((surface.material.double_sided, corners));
                }
            }
        }
        let mut clusters = Vec::new();
        for (i, cluster) in clustered.clusters().iter().enumerate() {
            let geometry = clustered.geometry(i);
            for triangle in geometry.triangles() {
                let corners = geometry.corners(triangle);
                for corner in corners {
                    let is_inside =
                        |a: usize| (cluster.min[a]..=cluster.max[a]).contains(&corner[a]);
                    assert!((0..3).all(is_inside), "{said}");
                }
                clusters.push((
                    cluster.double_sided,
                    from_least(corners.map(|c| c.map(f32::to_bits))),
                ));
            }
        }
        own.sort_unstable();
        clusters.sort_unstable();
        assert_eq!(own, clusters, "{said}, mesh {index}");
    }
    cull_exactly(prepared, said);
}

/// Sections that are other than they were, in one to three ways.
fn mutate(sections: &mut Vec<Section>, random: &mut Random) {
    for _ in 0..=random.below(2) {
        let of = random.below(sections.len());
        let bytes = &mut sections[of].bytes;
        match random.below(10) {
            0 => change_bytes(bytes, random),
            1 => {
                sections.remove(of);
                return;
            }
            2 => {
                let other = random.below(sections.len());
                sections.swap(of, other);
            }
            3 => sections[of].kind = random.below(18) as u32,
            4 => {
                // Another place of the same section, or what lies there and is not too far from right.
                let words = bytes.len() / 4;
                let (from, to) = (4 * random.below(words), 4 * random.below(words));
                if words > 0 {
                    bytes.copy_within(from..from + 4, to);
                }
            }
            5 | 6 if !bytes.is_empty() => {
                // One more or less: sizes and indices that are nearly right.
                let at = random.below(bytes.len());
                bytes[at] = bytes[at].wrapping_add([1, 255][random.below(2)]);
            }
            _ if bytes.len() >= 4 => change_words(bytes, random),
            _ => {}
        }
    }
}

#[test]
fn an_archive_that_was_made_to_harm_ends_in_an_error_or_a_valid_scene() {
    let folder = Folder::new("archive_mutations");
    let mutations: usize = std::env::var("ANTUMBRA_MUTATIONS")
        .ok()
        .and_then(|count| count.parse().ok())
        .unwrap_or(2_000);
    let seeds: Vec<Vec<Section>> = [(1, false), (2, true), (9, false)]
        .iter()
        .map(|&(fineness, proxies)| take_apart(&folder.saved(&prepared(fineness, proxies))))
        .collect();
    let mut random = Random(0x5eed_a4c1);
    let mut sound = 0;
    for attempt in 0..mutations {
        let mut sections = seeds[attempt % seeds.len()].clone();
        mutate(&mut sections, &mut random);
        if let Ok(prepared) = folder.load(&put_together(1, &sections)) {
            sound += 1;
            check(&prepared, &format!("mutation {attempt}"));
        }
    }
    eprintln!("{sound} of {mutations} mutations still load");
    // The test is of use if some get through.
    assert!(sound * 50 > mutations && sound < mutations);
}

/// A section with other bytes, and whether that loads.
fn loads_with(
    folder: &Folder,
    sections: &[Section],
    kind: u32,
    change: impl FnOnce(&mut Vec<u8>),
) -> Result<Prepared, String> {
    let mut sections = sections.to_vec();
    let section = sections.iter_mut().find(|s| s.kind == kind).expect("there");
    change(&mut section.bytes);
    folder
        .load(&put_together(1, &sections))
        .map_err(|e| e.to_string())
}

#[test]
fn clusters_that_hold_other_triangles_are_refused() {
    let folder = Folder::new("archive_lies");
    let sections = take_apart(&folder.saved(&prepared(9, false)));
    let load =
        |kind, change: &dyn Fn(&mut Vec<u8>)| match loads_with(&folder, &sections, kind, change) {
            Ok(_) => panic!("section {kind} may be other than it should"),
            Err(error) => error,
        };
    // The second mesh is double-sided: no cone gives the lie away.
    let before = |field: usize| u32_at(&sections[0].bytes, field) as usize;
    let (vertex, quad) = (4 * (before(40) + 20), 4 * before(48));
    // A vertex elsewhere, along each axis.
    for axis in 10..=12 {
        let error = load(axis, &|x| {
            x[vertex..][..4].copy_from_slice(&0.01f32.to_le_bytes());
        });
        assert!(error.contains("mesh 1: they do not hold"), "{error}");
    }
    // The other side of a triangle, and a triangle with a corner elsewhere.
    let error = load(13, &|quads| quads.swap(quad, quad + 1));
    assert!(error.contains("mesh 1: they do not hold"), "{error}");
    let error = load(13, &|quads| quads[quad] ^= 1);
    assert!(error.contains("mesh 1: they do not hold"), "{error}");
    // A cluster with two sides in place of one.
    let error = load(9, &|clusters: &mut Vec<u8>| {
        let last = clusters
            .chunks_exact_mut(16)
            .take_while(|c| c[3] & 1 == 0)
            .last();
        let cluster = last.expect("a single-sided one");
        cluster[3] = 1;
        cluster[4..].fill(0);
    });
    assert!(error.contains("mesh 0"), "{error}");
    // An index of the padding.
    let error = load(13, &|quads| quads[2] = 127);
    assert!(
        error.contains("an index is none of its vertices"),
        "{error}"
    );
}

#[test]
fn a_cone_holds_whatever_axis_it_is_made_around() {
    let folder = Folder::new("archive_cones");
    let before = prepared(9, false);
    let sections = take_apart(&folder.saved(&before));
    let with_axis = |axis: [f32; 3]| {
        loads_with(&folder, &sections, 9, |clusters| {
            let cluster = clusters.chunks_exact_mut(16).find(|c| c[3] & 2 != 0);
            let cluster = cluster.expect("a cluster with a cone");
            for (at, c) in [4, 8, 12].into_iter().zip(axis) {
                cluster[at..at + 4].copy_from_slice(&c.to_le_bytes());
            }
        })
    };
    for axis in [[0.6, 0.0, 0.8], [0.0, 0.8, 0.6]] {
        let tilted = with_axis(axis).expect("another cone of the same triangles");
        assert_ne!(tilted.occluders(), before.occluders());
        check(&tilted, "tilted");
    }
    for axis in [
        [0.0, 0.0, -1.0],
        [-0.6, 0.0, -0.8],
        [0.0, 0.0, 1.01],
        [f32::NAN; 3],
        [0.0; 3],
    ] {
        let error = with_axis(axis).err().unwrap_or_default();
        assert!(
            error.contains("its axis is none of a cone"),
            "{axis:?}: {error}"
        );
    }
}

#[test]
fn a_hierarchy_whose_objects_are_not_consecutive_is_refused() {
    let folder = Folder::new("archive_hierarchy");
    let sections = take_apart(&folder.saved(&prepared(1, false)));
    let swapped = loads_with(&folder, &sections, 7, |links| {
        let leaves: Vec<usize> = (0..links.len() / 8)
            .filter(|i| u32_at(links, 8 * i + 4) > 0)
            .collect();
        let (a, b) = (8 * leaves[0], 8 * leaves[leaves.len() - 1]);
        for i in 0..8 {
            links.swap(a + i, b + i);
        }
    });
    let error = swapped.err().unwrap_or_default();
    assert!(error.contains("not consecutive"), "{error}");
    for (kind, at, value) in [
        (7, 0, 0u32),
        (7, 0, u32::MAX),
        (8, 0, 1 << 20),
        (8, 4, u32::MAX),
    ] {
        let wrong = loads_with(&folder, &sections, kind, |bytes| {
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        });
        let error = wrong.err().unwrap_or_default();
        assert!(error.contains("the hierarchy"), "{kind} {value}: {error}");
    }
}
