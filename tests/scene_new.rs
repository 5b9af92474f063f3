//! Scenes made in memory: what is checked, how tight the boxes are, what the hierarchy promises.

mod scene_files;

use std::time::Instant;

use antumbra::scene::{Aabb, MAX_COORDINATE, Material, Mesh, Object, Scene, Surface};
use glam::{DAffine3, DMat3, DVec3};

fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let surfaces = vec![Surface {
        triangles: 0..triangles.len(),
        material: Material::default(),
    }];
    Mesh {
        name: "m".to_owned(),
        positions: positions.into(),
        triangles: triangles.into(),
        surfaces,
    }
}

fn wedge() -> Mesh {
    mesh(
        vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        vec![[0, 1, 2]],
    )
}

fn object(world_from_local: DAffine3) -> Object {
    Object {
        name: "o".to_owned(),
        mesh: 0,
        world_from_local,
        never_cull: false,
        never_occlude: false,
        occluder_proxy: None,
    }
}

fn at(x: f64, y: f64, z: f64) -> Object {
    object(DAffine3::from_translation(DVec3::new(x, y, z)))
}

/// Uniform in 0 to 1, the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self, half_size: f64) -> DVec3 {
        DVec3::from([(); 3].map(|()| (self.next() * 2.0 - 1.0) * half_size))
    }
}

#[track_caller]
fn refused(meshes: Vec<Mesh>, objects: Vec<Object>, parts: &[&str]) {
    let message = Scene::new(meshes, objects)
        .expect_err("the scene should be refused")
        .to_string();
    for part in parts {
        assert!(message.contains(part), "{part:?} is missing in: {message}");
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_its_name() {
    let sound = || vec![at(0.0, 0.0, 0.0)];
    refused(vec![], vec![], &["the scene has no triangles"]);
    refused(vec![wedge()], vec![], &["the scene has no triangles"]);
    refused(
        vec![mesh(vec![], vec![])],
        sound(),
        &["the scene has no triangles"],
    );
    refused(
        vec![],
        sound(),
        &["object 0 \"o\": its mesh is mesh 0, but there are 0"],
    );
    refused(
        vec![wedge()],
        vec![Object {
            occluder_proxy: Some(1),
            ..at(0.0, 0.0, 0.0)
        }],
        &["object 0 \"o\": its occluder proxy is mesh 1, but there are 1"],
    );
    refused(
        vec![wedge(), mesh(vec![], vec![])],
        vec![
            at(0.0, 0.0, 0.0),
            Object {
                mesh: 1,
                ..at(0.0, 0.0, 0.0)
            },
        ],
        &[
            "object 1 \"o\": mesh 1 \"m\" has no triangles",
            "leave it out",
        ],
    );
    refused(
        vec![mesh(vec![[0.0; 3]; 3], vec![[0, 1, 2], [0, 1, 3]])],
        sound(),
        &[
            "mesh 0 \"m\": triangle 1 has an index out of range: [0, 1, 3], but there are 3 vertices",
        ],
    );
    refused(
        vec![mesh(
            vec![[0.0; 3], [0.0, f32::NAN, 0.0], [0.0; 3]],
            vec![[0, 1, 2]],
        )],
        sound(),
        &["mesh 0 \"m\": vertex 1 has a position that is not finite"],
    );
    refused(
        vec![wedge()],
        vec![at(f64::NAN, 0.0, 0.0)],
        &["object 0 \"o\": its matrix is not finite"],
    );
    refused(
        vec![wedge()],
        vec![at(2.0 * MAX_COORDINATE, 0.0, 0.0)],
        &["object 0 \"o\"", "scale the scene down"],
    );
    refused(
        vec![wedge()],
        vec![at(MAX_COORDINATE, 0.0, 0.0)],
        &["object 0 \"o\"", "scale the scene down"],
    );
}

#[test]
fn surfaces_must_be_consecutive_and_cover_every_triangle() {
    let runs = |runs: &[(usize, usize)]| {
        let surface = |&(start, end)| Surface {
            triangles: start..end,
            material: Material::default(),
        };
        let surfaces = runs.iter().map(surface).collect();
        let mesh = Mesh {
            surfaces,
            ..mesh(vec![[0.0; 3]; 3], vec![[0, 1, 2]; 4])
        };
        Scene::new(vec![mesh], vec![at(0.0, 0.0, 0.0)])
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    assert_eq!(runs(&[(0, 4)]), Ok(()));
    assert_eq!(runs(&[(0, 1), (1, 1), (1, 4)]), Ok(()));
    for bad in [
        &[][..],
        &[(0, 3)],
        &[(0, 5)],
        &[(1, 4)],
        &[(0, 2), (3, 4)],
        &[(0, 2), (1, 4)],
        &[(0, 4), (4, 2)],
    ] {
        assert!(runs(bad).unwrap_err().contains("mesh 0 \"m\""), "{bad:?}");
    }
}

#[test]
fn a_box_is_tight_over_the_vertices_in_use() {
    let mut mesh = wedge();
    mesh.positions.to_mut().push([1e6, 1e6, 1e6]);
    // A box of the turned box would reach to 1.41 on both sides.
    let turn = DMat3::from_cols(
        DVec3::new(0.6, 0.8, 0.0),
        DVec3::new(-0.8, 0.6, 0.0),
        DVec3::Z,
    );
    let scene = Scene::new(vec![mesh], vec![object(DAffine3::from_mat3(turn))]).unwrap();
    let expected = Aabb {
        min: DVec3::new(-0.8, 0.0, 0.0),
        max: DVec3::new(0.6, 0.8, 0.0),
    };
    let bounds = scene.bounds()[0];
    assert!(
        bounds.contains(expected) && expected.grown(1e-11).contains(bounds),
        "{bounds:?}"
    );
}

#[test]
fn a_box_holds_every_vertex_in_whatever_order_the_terms_are_added() {
    let mut random = Random(7);
    for far in [1.0, 2e3, 2e5, 1e12] {
        let positions: Vec<[f32; 3]> = (0..300)
            .map(|_| random.point(50.0).as_vec3().to_array())
            .collect();
        let triangles = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let matrix = DMat3::from_cols(random.point(2.0), random.point(2.0), random.point(2.0));
        let place = DAffine3 {
            matrix3: matrix,
            translation: random.point(far),
        };
        let scene = Scene::new(
            vec![mesh(positions.clone(), triangles)],
            vec![object(place)],
        )
        .unwrap();
        let (bounds, m, t) = (
            scene.bounds()[0],
            place.matrix3.to_cols_array_2d(),
            place.translation.to_array(),
        );
        for p in positions.iter().map(|p| p.map(f64::from)) {
            let sums: [[f64; 3]; 3] = std::array::from_fn(|row| {
                let [x, y, z] = [0, 1, 2].map(|column| m[column][row] * p[column]);
                let t = t[row];
                [((x + y) + z) + t, ((t + z) + y) + x, (x + t) + (y + z)]
            });
            for order in [0, 1, 2] {
                let point = DVec3::from(sums.map(|of_row| of_row[order]));
                assert!(
                    bounds.contains(Aabb {
                        min: point,
                        max: point
                    }),
                    "{far}: {point:?} in {bounds:?}"
                );
            }
        }
    }
}

fn scene_of(places: impl IntoIterator<Item = DVec3>) -> Scene {
    let objects = places
        .into_iter()
        .map(|p| object(DAffine3::from_translation(p)))
        .collect();
    Scene::new(vec![wedge()], objects).unwrap()
}

#[track_caller]
fn assert_sound(scene: &Scene) {
    assert_eq!(scene.bvh().validate(scene.bounds()), Ok(()));
    // The objects of every subtree are consecutive: in leaf order, depth first, none is passed over.
    let (mut next, mut to_visit) = (0, vec![0]);
    while let Some(i) = to_visit.pop() {
        let node = scene.bvh().nodes[i];
        if node.is_leaf() {
            assert_eq!(node.first, next);
            next += node.count;
        } else {
            to_visit.extend([node.first as usize + 1, node.first as usize]);
        }
    }
    assert_eq!(next as usize, scene.objects().len());
}

#[test]
fn the_hierarchy_holds_every_object_once() {
    let mut random = Random(1);
    for count in [1, 2, 3, 10, 1000] {
        for half_size in [0.0, 1e-30, 1.0, 1e9, 1e29] {
            assert_sound(&scene_of((0..count).map(|_| random.point(half_size))));
        }
    }
}

#[test]
fn a_broken_hierarchy_is_noticed() {
    let mut random = Random(3);
    let scene = scene_of((0..10).map(|_| random.point(9.0)));
    let broken = |change: &dyn Fn(&mut antumbra::scene::Bvh)| {
        let mut bvh = scene.bvh().clone();
        change(&mut bvh);
        assert!(bvh.validate(scene.bounds()).is_err());
    };
    broken(&|bvh| bvh.objects[0] = bvh.objects[1]);
    broken(&|bvh| bvh.objects[0] = 10);
    broken(&|bvh| bvh.nodes[0].first = 0);
    broken(&|bvh| bvh.nodes[0].max[1] = 0.0);
    broken(&|bvh| bvh.nodes.push(bvh.nodes[3]));
    broken(&|bvh| bvh.nodes.clear());
    let leaf = scene.bvh().nodes.iter().position(|n| n.is_leaf()).unwrap();
    broken(&|bvh| bvh.nodes[leaf].min[2] += 0.5);
    broken(&|bvh| bvh.nodes[leaf].count = 99);
}

#[test]
fn rows_grids_and_heaps_of_equal_boxes_are_quick_and_shallow() {
    let count = 60_000;
    let layouts: [(&str, &dyn Fn(i32) -> DVec3); 5] = [
        ("row", &|i| DVec3::X * f64::from(i)),
        ("grid", &|i| {
            DVec3::new(f64::from(i % 256), 0.0, f64::from(i / 256))
        }),
        ("far grid", &|i| {
            DVec3::new(2e5 + f64::from(i % 256), 0.0, f64::from(i / 256))
        }),
        ("sparse row", &|i| DVec3::X * f64::from(i) * 1e4),
        ("heap", &|_| DVec3::splat(7.0)),
    ];
    for (name, layout) in layouts {
        let begun = Instant::now();
        let scene = scene_of((0..count).map(layout));
        assert_sound(&scene);
        assert!(
            begun.elapsed().as_secs() < 20,
            "{name}: {:?}",
            begun.elapsed()
        );
        assert!(
            scene.bvh().depth() < 200,
            "{name}: {} levels",
            scene.bvh().depth()
        );
    }
    // One inside the other, about a common corner or centre.
    for shift in [0.0, 0.5] {
        let nested = (0..count).map(|i| {
            let size = 1.0 + f64::from(i);
            object(DAffine3 {
                matrix3: DMat3::from_diagonal(DVec3::splat(size)),
                translation: DVec3::splat(-shift * size),
            })
        });
        let begun = Instant::now();
        assert_sound(&Scene::new(vec![wedge()], nested.collect()).unwrap());
        assert!(
            begun.elapsed().as_secs() < 20,
            "nested: {:?}",
            begun.elapsed()
        );
    }
}

#[test]
fn same_bits_for_any_thread_count() {
    let mut random = Random(9);
    let places: Vec<DVec3> = (0..5000).map(|_| random.point(1e4)).collect();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| scene_of(places.iter().copied()))
    };
    let alone = on(1);
    for threads in [2, 3, 8] {
        let scene = on(threads);
        assert_eq!(scene.bounds(), alone.bounds());
        assert_eq!(
            (&scene.bvh().nodes, &scene.bvh().objects),
            (&alone.bvh().nodes, &alone.bvh().objects)
        );
    }
}

#[test]
fn same_bits_on_every_machine() {
    let mut random = Random(21);
    let objects = (0..3000).map(|_| {
        let matrix = DMat3::from_cols(random.point(2.0), random.point(2.0), random.point(2.0));
        object(DAffine3 {
            matrix3: matrix,
            translation: random.point(1e5),
        })
    });
    let scene = Scene::new(vec![wedge()], objects.collect()).unwrap();
    let corners = scene
        .bounds()
        .iter()
        .flat_map(|b| [b.min.to_array(), b.max.to_array()])
        .flatten()
        .map(f64::to_bits);
    let nodes = scene
        .bvh()
        .nodes
        .iter()
        .flat_map(|n| [n.min, n.max].concat())
        .map(|c| u64::from(c.to_bits()));
    let order = scene.bvh().objects.iter().map(|&o| u64::from(o));
    // FNV-1a over whole words.
    let hash = corners
        .chain(nodes)
        .chain(order)
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, word| {
            (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)
        });
    assert_eq!(format!("{hash:016x}"), "25ff1f19b18ef842");
}

#[test]
fn a_large_mesh_placed_very_often_is_bounded_by_its_box() {
    let mut random = Random(5);
    let positions: Vec<[f32; 3]> = (0..60_000)
        .map(|_| random.point(1.0).as_vec3().to_array())
        .collect();
    let triangles = (0..20_000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let objects: Vec<Object> = (0..30_000)
        .map(|_| object(DAffine3::from_translation(random.point(1e3))))
        .collect();
    let begun = Instant::now();
    let scene = Scene::new(vec![mesh(positions, triangles)], objects).unwrap();
    assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
    assert_sound(&scene);
    assert!(
        scene
            .bounds()
            .iter()
            .all(|b| (b.size() - 2.0).abs().max_element() < 1e-2)
    );
}
