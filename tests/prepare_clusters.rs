//! Clusters of occluders: nothing lost, nothing twice, limits kept, and no cone that hides what faces the eye.

mod oracle;
mod worlds;

use antumbra::glam::{DAffine3, DMat4, DVec3};
use antumbra::prepare::{
    ClusteredMesh, ClusteredScene, NormalCone, TRIANGLES_PER_CLUSTER, VERTEX_BLOCK,
    VERTICES_PER_CLUSTER,
};
use antumbra::raster::ObjectAssembler;
use antumbra::scene::{Alpha, Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, PictureSize, Projection};
use antumbra_fixtures::{Kind, Recipe, generate};
use num_rational::BigRational;
use oracle::Chance;
use worlds::{DOUBLE_SIDED, SHAPES, SINGLE_SIDED, Shape, direction, object, placed, shape};

type Corners = [[f32; 3]; 3];

const SEEN_THROUGH: [Alpha; 2] = [Alpha::Mask, Alpha::Blend];

fn fixture(kind: Kind, triangles: u64) -> Scene {
    let recipe = Recipe {
        kind,
        triangles: Some(triangles),
        seed: 7,
    };
    let fixture = generate(&recipe).expect("a scene");
    let meshes = fixture.parts.into_iter().map(|part| {
        let material = Material {
            alpha: if part.alpha_blend {
                Alpha::Blend
            } else {
                Alpha::Opaque
            },
            double_sided: part.double_sided,
            color: part.color,
        };
        worlds::mesh(part.positions, part.triangles, material)
    });
    let objects = fixture.nodes.iter().map(|node| {
        let matrix = DMat4::from_cols_array(&node.matrix.map(f64::from));
        object(node.part, DAffine3::from_mat4(matrix))
    });
    Scene::new(meshes.collect(), objects.collect()).expect("a valid scene")
}

/// A shape of several surfaces of all kinds, here or far away.
fn patchwork(chance: &mut Chance, kind: Shape) -> Mesh {
    let (points, mut triangles) = shape(chance, kind);
    let (place, scale) = (worlds::home(chance), chance.real(0.1, 50.0));
    let positions: Vec<[f32; 3]> = points
        .iter()
        .map(|&p| (p * scale + place).as_vec3().to_array())
        .collect();
    if chance.one_in(3) {
        triangles.push([0, 1, 1]);
    }
    let mut surfaces = Vec::new();
    let mut start = 0;
    while start < triangles.len() {
        let end = (start + chance.whole(1, 400) as usize).min(triangles.len());
        let mut material = if chance.one_in(2) {
            SINGLE_SIDED
        } else {
            DOUBLE_SIDED
        };
        if chance.one_in(5) {
            material.alpha = SEEN_THROUGH[chance.whole(0, 1) as usize];
        }
        surfaces.push(Surface {
            triangles: start..end,
            material,
        });
        start = end;
    }
    Mesh {
        name: String::new(),
        positions: positions.into(),
        triangles: triangles.into(),
        surfaces,
    }
}

/// All sorts of meshes, up to some thousands of triangles.
fn meshes() -> Vec<Mesh> {
    let mut chance = Chance::seeded(31);
    let large = [
        Shape::Ball(4),
        Shape::Ball(5),
        Shape::Wall(9),
        Shape::Wall(40),
        Shape::Soup(65),
        Shape::Soup(1_500),
        Shape::Slivers(300),
    ];
    let mut meshes = Vec::new();
    for kind in SHAPES.into_iter().chain(large) {
        for _ in 0..5 {
            meshes.push(patchwork(&mut chance, kind));
            let (mesh, _) = placed(&mut chance, kind, SINGLE_SIDED, DVec3::ZERO, 10.0);
            meshes.push(mesh);
        }
    }
    for (kind, triangles) in [
        (Kind::City, 30_000),
        (Kind::Teapots, 300_000),
        (Kind::MachineRoom, 40_000),
    ] {
        meshes.extend_from_slice(fixture(kind, triangles).meshes());
    }
    meshes
}

/// The occluding triangles of a class, sorted, corners in their order.
fn expected(mesh: &Mesh, double_sided: bool) -> Vec<[[u32; 3]; 3]> {
    let surfaces = mesh
        .surfaces
        .iter()
        .filter(|s| s.material.alpha == Alpha::Opaque && s.material.double_sided == double_sided);
    let mut triangles: Vec<_> = surfaces
        .flat_map(|s| &mesh.triangles[s.triangles.clone()])
        .map(|t| t.map(|i| mesh.positions[i as usize]))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .map(as_it_winds)
        .collect();
    triangles.sort_unstable();
    triangles
}

/// A triangle's corners, whichever of them comes first.
fn as_it_winds(corners: Corners) -> [[u32; 3]; 3] {
    let [a, b, c] = corners.map(|c| c.map(f32::to_bits));
    [[a, b, c], [b, c, a], [c, a, b]]
        .into_iter()
        .min()
        .expect("three")
}

fn corners_of(clustered: &ClusteredMesh, cluster: usize) -> Vec<Corners> {
    let geometry = clustered.geometry(cluster);
    let triangles = geometry.triangles();
    triangles.map(|t| geometry.corners(t)).collect()
}

#[test]
fn every_occluding_triangle_is_in_one_cluster_as_it_winds() {
    for mesh in meshes() {
        let clustered = ClusteredMesh::new(&mesh);
        for double_sided in [false, true] {
            let of_class = (0..clustered.clusters().len())
                .filter(|&c| clustered.clusters()[c].double_sided == double_sided);
            let mut found: Vec<_> = of_class
                .flat_map(|c| corners_of(&clustered, c))
                .map(as_it_winds)
                .collect();
            found.sort_unstable();
            assert!(found == expected(&mesh, double_sided));
        }
    }
}

#[test]
fn limits_padding_and_bounds_hold() {
    for mesh in meshes() {
        let clustered = ClusteredMesh::new(&mesh);
        let [x, y, z] = clustered.vertices();
        let (mut vertices, mut quads, mut triangles) = (0, 0, 0);
        for (c, cluster) in clustered.clusters().iter().enumerate() {
            assert_eq!(
                (cluster.first_vertex, cluster.first_quad),
                (vertices, quads)
            );
            let count = usize::from(cluster.vertex_count);
            assert!((3..=VERTICES_PER_CLUSTER).contains(&count));
            assert!((1..=TRIANGLES_PER_CLUSTER).contains(&usize::from(cluster.triangle_count)));
            let geometry = clustered.geometry(c);
            assert_eq!(
                geometry.triangles().count(),
                usize::from(cluster.triangle_count)
            );
            assert_eq!(geometry.quads.len(), usize::from(cluster.quad_count));
            assert_eq!(geometry.x.len(), count.next_multiple_of(VERTEX_BLOCK));
            assert_eq!(geometry.y.len(), geometry.x.len());
            assert_eq!(geometry.z.len(), geometry.x.len());

            let vertex = |i: usize| [geometry.x[i], geometry.y[i], geometry.z[i]];
            let mut distinct: Vec<_> = (0..count).map(|i| vertex(i).map(f32::to_bits)).collect();
            for i in count..geometry.x.len() {
                assert_eq!(vertex(i).map(f32::to_bits), distinct[count - 1]);
            }
            distinct.sort_unstable();
            distinct.dedup();
            assert_eq!(distinct.len(), count, "a position twice");
            let mut used: Vec<u8> = geometry.quads.iter().flatten().copied().collect();
            used.sort_unstable();
            used.dedup();
            assert!(used.into_iter().map(usize::from).eq(0..count));

            for axis in 0..3 {
                let all = || (0..count).map(|i| vertex(i)[axis]);
                assert_eq!(cluster.min[axis], all().fold(f32::INFINITY, f32::min));
                assert_eq!(cluster.max[axis], all().fold(f32::NEG_INFINITY, f32::max));
            }
            assert_eq!(cluster.bounds().min.as_vec3().to_array(), cluster.min);
            assert!(cluster.cone.is_none() || !cluster.double_sided);
            vertices += geometry.x.len();
            quads += geometry.quads.len();
            triangles += geometry.triangles().count();
        }
        assert_eq!([x.len(), y.len(), z.len()], [vertices; 3]);
        assert_eq!(clustered.triangle_count(), triangles);
    }
}

/// The sign of n·(eye − p), exactly: 1 if the triangle looks towards the eye.
fn facing([a, b, c]: Corners, eye: DVec3) -> i32 {
    let wide = |p: [f32; 3]| DVec3::from(p.map(f64::from));
    let (u, v, w) = (wide(b) - wide(a), wide(c) - wide(a), eye - wide(a));
    let rough = u.cross(v).dot(w);
    if rough.abs() > 1e-12 * u.length() * v.length() * (w.length() + eye.length()) {
        return if rough > 0.0 { 1 } else { -1 };
    }
    let exact = |p: DVec3| {
        p.to_array()
            .map(|x| BigRational::from_float(x).expect("finite"))
    };
    let from_a = |p: DVec3| {
        let (p, a) = (exact(p), exact(wide(a)));
        [0, 1, 2].map(|i| &p[i] - &a[i])
    };
    let ([ux, uy, uz], [vx, vy, vz], [wx, wy, wz]) =
        (from_a(wide(b)), from_a(wide(c)), from_a(eye));
    let volume =
        wx * (&uy * &vz - &uz * &vy) + wy * (&uz * &vx - &ux * &vz) + wz * (&ux * &vy - &uy * &vx);
    let zero = BigRational::from_integer(0.into());
    i32::from(volume > zero) - i32::from(volume < zero)
}

/// Thinner than what any picture shows: both sides are within 2⁻³⁹ of its length.
fn is_line([a, b, c]: Corners) -> bool {
    let wide = |p: [f32; 3]| DVec3::from(p.map(f64::from));
    let (u, v) = (wide(b) - wide(a), wide(c) - wide(a));
    u.cross(v).length() <= 2_f64.powi(-39) * u.length() * v.length()
}

/// Eyes around a box, near and far, inside and out, and on the planes of its triangles or just off them.
fn eyes(chance: &mut Chance, min: DVec3, max: DVec3, triangles: &[Corners]) -> Vec<DVec3> {
    let (middle, size) = (min * 0.5 + max * 0.5, (max - min).length());
    let mut eyes = Vec::new();
    for reach in [0.2, 0.6, 2.0, 30.0, 1e4] {
        for _ in 0..6 {
            eyes.push(middle + direction(chance) * size * reach);
        }
    }
    for _ in 0..20 {
        let last = triangles.len() as i32 - 1;
        let corners = triangles[chance.whole(0, last) as usize];
        let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
        let mut along = || chance.real(-3.0, 3.0);
        let on_plane = a + (b - a) * along() + (c - a) * along();
        eyes.push(on_plane);
        let off = [0.0, 1e-12, 1e-9, 1e-6, 1e-3][chance.whole(0, 4) as usize];
        eyes.push(on_plane + direction(chance) * off * size);
    }
    eyes
}

#[test]
fn cones_never_say_what_an_exact_triangle_denies() {
    let mut chance = Chance::seeded(32);
    let (mut away, mut towards) = (0, 0);
    for mesh in meshes() {
        let clustered = ClusteredMesh::new(&mesh);
        for (c, cluster) in clustered.clusters().iter().enumerate() {
            let Some(cone) = cluster.cone else { continue };
            let mut triangles = corners_of(&clustered, c);
            triangles.retain(|&t| !is_line(t));
            let bounds = cluster.bounds();
            for eye in eyes(&mut chance, bounds.min, bounds.max, &triangles) {
                if cone.is_back_facing(eye) {
                    away += 1;
                    assert!(
                        triangles.iter().all(|&t| facing(t, eye) < 0),
                        "{cone:?} {eye}"
                    );
                }
                if cone.is_front_facing(eye) {
                    towards += 1;
                    assert!(
                        triangles.iter().all(|&t| facing(t, eye) > 0),
                        "{cone:?} {eye}"
                    );
                }
                // From so far away that the middle of the box hardly matters, a direction is an eye.
                let view = bounds.center() - eye;
                let far = bounds.center() - view * 1e9;
                if cone.is_back_facing_along(view) {
                    assert!(triangles.iter().all(|&t| facing(t, far) < 0));
                }
                if cone.is_front_facing_along(view) {
                    assert!(triangles.iter().all(|&t| facing(t, far) > 0));
                }
            }
        }
    }
    assert!(away > 10_000 && towards > 10_000, "{away} {towards}");
}

#[test]
fn cones_of_nothing_and_eyes_that_are_nowhere_say_nothing() {
    assert_eq!(NormalCone::around([]), None);
    let line = [[0.0; 3], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0]];
    assert_eq!(NormalCone::around([line]), None);
    let up = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let down = [up[0], up[2], up[1]];
    assert_eq!(NormalCone::around([up, down]), None);

    let cone = NormalCone::around([up, line]).expect("a line looks neither way");
    assert!(cone.is_back_facing(DVec3::new(0.3, 0.3, -1e-4)));
    assert!(cone.is_front_facing(DVec3::new(0.3, 0.3, 1e-4)));
    assert!(cone.is_back_facing_along(DVec3::new(9.0, 0.0, 0.01)));
    assert!(cone.is_front_facing_along(DVec3::new(9.0, 0.0, -0.01)));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for eye in [
            DVec3::splat(bad),
            DVec3::new(0.0, 0.0, bad),
            DVec3::new(bad, 0.0, -1.0),
        ] {
            assert!(!cone.is_back_facing(eye) && !cone.is_front_facing(eye));
            assert!(!cone.is_back_facing_along(eye) && !cone.is_front_facing_along(eye));
        }
    }
    assert!(!cone.is_back_facing_along(DVec3::ZERO) && !cone.is_front_facing_along(DVec3::ZERO));
}

#[test]
fn a_cluster_that_looks_away_draws_nothing_mirrored_or_not() {
    let mut chance = Chance::seeded(33);
    let size = PictureSize::new(320, 200).expect("a size");
    let (mut dropped, mut mirrored) = (0, 0);
    for round in 0..4_000 {
        let kind = [Shape::Wall(1), Shape::Wall(5), Shape::Ball(0)][round % 3];
        let (mesh, placement) = placed(&mut chance, kind, SINGLE_SIDED, DVec3::ZERO, 2.0);
        // One side of the ball is enough: all of it never looks away.
        let half = Mesh {
            triangles: mesh.triangles[..2].to_vec().into(),
            surfaces: vec![Surface {
                triangles: 0..2,
                material: SINGLE_SIDED,
            }],
            ..mesh
        };
        let projection = Projection::Perspective {
            fov_y: 1.0,
            near: 0.01,
            far: None,
        };
        let eye = direction(&mut chance) * 6.0;
        let camera = Camera::look_at(eye, DVec3::ZERO, direction(&mut chance), projection);
        let Ok(camera) = camera else { continue };
        let eye_local = placement.inverse().transform_point3(eye);
        let clustered = ClusteredMesh::new(&half);
        // In coordinates of 10⁷ nothing may be left of it.
        let Some(cone) = clustered.clusters().first().and_then(|c| c.cone) else {
            continue;
        };
        // Seen edge-on, snapping may turn a sliver round.
        let is_steep = corners_of(&clustered, 0).iter().all(|corners| {
            let [a, b, c] =
                corners.map(|p| placement.transform_point3(DVec3::from(p.map(f64::from))));
            let (n, v) = ((b - a).cross(c - a), eye - a);
            n.dot(v).abs() > 0.05 * n.length() * v.length()
        });
        if !is_steep || !cone.is_back_facing(eye_local) {
            continue;
        }
        dropped += 1;
        mirrored += i32::from(placement.matrix3.determinant() < 0.0);
        let mut assembler = ObjectAssembler::new(camera, size);
        assembler.assemble(&half, &placement, |_| true, |t| panic!("drawn: {t:?}"));
    }
    assert!(dropped > 800 && mirrored > 100, "{dropped} {mirrored}");
}

fn in_pool<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads").install(run)
}

#[test]
fn same_bits_for_any_thread_count() {
    for (kind, triangles) in [(Kind::City, 60_000), (Kind::Teapots, 300_000)] {
        let scene = fixture(kind, triangles);
        // Debug tells −0 from 0.
        let [one, two, five] =
            [1, 2, 5].map(|n| in_pool(n, || format!("{:?}", ClusteredScene::new(&scene))));
        assert!(one == two && one == five);
    }
}

#[test]
fn instances_share_and_only_occluders_are_clustered() {
    let wall = |material| {
        let (points, triangles) = shape(&mut Chance::seeded(1), Shape::Wall(5));
        let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
        worlds::mesh(positions, triangles, material)
    };
    let glass = Material {
        alpha: Alpha::Blend,
        ..SINGLE_SIDED
    };
    let meshes = vec![
        wall(SINGLE_SIDED), // two objects
        wall(DOUBLE_SIDED), // has a proxy
        wall(SINGLE_SIDED), // the proxy
        wall(SINGLE_SIDED), // never an occluder
        wall(glass),
        wall(SINGLE_SIDED), // used by none
    ];
    let place = |mesh| object(mesh, DAffine3::IDENTITY);
    let objects = vec![
        place(0),
        place(0),
        Object {
            occluder_proxy: Some(2),
            ..place(1)
        },
        Object {
            never_occlude: true,
            ..place(3)
        },
        place(4),
    ];
    let scene = Scene::new(meshes, objects).expect("a valid scene");
    let clustered = ClusteredScene::new(&scene);
    let is_clustered = [0, 1, 2, 3, 4, 5, 6].map(|mesh| clustered.mesh(mesh).is_some());
    assert_eq!(
        is_clustered,
        [true, false, true, false, false, false, false]
    );
    let of = |o: usize| clustered.occluder(&scene.objects()[o]);
    assert!(std::ptr::eq(of(0).unwrap(), of(1).unwrap()));
    assert!(std::ptr::eq(of(2).unwrap(), clustered.mesh(2).unwrap()));
    assert!(of(3).is_none() && of(4).is_none());

    let memory = clustered.memory_use();
    assert_eq!((memory.clusters, memory.triangles), (2, 100));
    assert!((5.0..40.0).contains(&memory.bytes_per_triangle()));
    assert_eq!(memory.bytes_per_cluster() * 2.0, memory.bytes as f64);
}

#[test]
fn odd_meshes_cluster() {
    let one = worlds::mesh(
        vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        vec![[0, 1, 2]],
        SINGLE_SIDED,
    );
    let clustered = ClusteredMesh::new(&one);
    assert_eq!(clustered.clusters().len(), 1);
    assert_eq!(clustered.geometry(0).x.len(), VERTEX_BLOCK);
    assert_eq!(clustered.geometry(0).quads, [[0, 1, 2, 2]]);

    assert_eq!(
        ClusteredMesh::new(&Mesh::default()),
        ClusteredMesh::default()
    );
    for alpha in SEEN_THROUGH {
        let mut glass = one.clone();
        glass.surfaces[0].material.alpha = alpha;
        assert!(ClusteredMesh::new(&glass).clusters().is_empty());
    }

    let point = vec![[3.0, 4.0, 5.0]; 1_000];
    let corners = (0..998).map(|i| [i, i + 1, i + 2]).collect();
    let coincident = worlds::mesh(point, corners, SINGLE_SIDED);
    assert!(ClusteredMesh::new(&coincident).clusters().is_empty());

    // A thousand times the same triangle, each with vertices of its own.
    let positions = (0..1_000).flat_map(|_| one.positions.clone()).collect();
    let corners = (0..1_000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let pile = ClusteredMesh::new(&worlds::mesh(positions, corners, SINGLE_SIDED));
    assert_eq!(pile.clusters().len(), 16);
    assert!(pile.clusters().iter().all(|c| c.vertex_count == 3));
    assert!(pile.clusters().iter().all(|c| c.cone.is_some()));

    // The largest and the smallest numbers there are.
    for scale in [2_f32.powi(100), f32::from_bits(1)] {
        let mut extreme = one.clone();
        extreme
            .positions
            .to_mut()
            .iter_mut()
            .flatten()
            .for_each(|x| *x *= scale);
        let clustered = ClusteredMesh::new(&extreme);
        let cone = clustered.clusters()[0].cone.expect("a cone");
        let eye = DVec3::new(0.1, 0.1, -1.0) * f64::from(scale);
        assert!(cone.is_back_facing(eye) && cone.is_front_facing(-eye));
    }
}

#[test]
fn clusters_are_as_few_as_their_triangles_allow() {
    for (n, clusters) in [(5, 1), (6, 2), (8, 2), (9, 3), (40, 50), (100, 313)] {
        let (points, triangles) = shape(&mut Chance::seeded(1), Shape::Wall(n));
        let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
        let wall = ClusteredMesh::new(&worlds::mesh(positions, triangles, SINGLE_SIDED));
        assert_eq!(wall.clusters().len(), clusters, "{n}×{n} cells");
        // Compact ones: 8 × 4 cells have 45 vertices.
        let vertices: usize = wall
            .clusters()
            .iter()
            .map(|c| usize::from(c.vertex_count))
            .sum();
        assert!(
            n < 40 || vertices <= 50 * clusters,
            "{vertices} in {clusters}"
        );
        for cluster in wall.clusters() {
            let cone = cluster.cone.expect("a wall has a back");
            assert!(cone.is_back_facing(DVec3::new(0.1, 0.2, -0.01)));
        }
    }
}

#[test]
fn clusters_of_a_city_are_full() {
    let scene = fixture(Kind::City, 200_000);
    let clustered = ClusteredScene::new(&scene);
    let large = scene
        .meshes()
        .iter()
        .enumerate()
        .filter(|(_, m)| m.triangles.len() > 64);
    let (mut triangles, mut clusters, mut vertices) = (0, 0, 0);
    for mesh in large.filter_map(|(i, _)| clustered.mesh(i)) {
        triangles += mesh.triangle_count();
        clusters += mesh.clusters().len();
        vertices += mesh.vertices()[0].len();
    }
    let (fill, sharing) = (
        triangles as f64 / clusters as f64,
        vertices as f64 / triangles as f64,
    );
    assert!(fill > 40.0, "{fill} triangles a cluster");
    assert!(sharing < 1.3, "{sharing} padded vertices a triangle");
}
