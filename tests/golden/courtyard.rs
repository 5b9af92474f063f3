//! A courtyard made by hand: one of each thing that the generated scenes have little of. Glass, fences cut out by a
//! texture, sheets with one side, mirrored and uneven placements of shared meshes, a proxy, objects with flags.

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::scene::{Alpha, Material, Mesh, Object, Scene, Surface};
use antumbra::view::{Camera, Projection};

use super::stage::Stage;

const fn paint(red: f32, green: f32, blue: f32) -> Material {
    Material {
        alpha: Alpha::Opaque,
        double_sided: false,
        color: [red, green, blue, 1.0],
    }
}

fn from_both_sides(material: Material) -> Material {
    Material {
        double_sided: true,
        ..material
    }
}

/// Glass that one sees from one side only.
fn glass(red: f32, green: f32, blue: f32, opacity: f32) -> Material {
    Material {
        alpha: Alpha::Blend,
        double_sided: false,
        color: [red, green, blue, opacity],
    }
}

/// A sheet from (0, 0, 0) to (1, 1, 0) whose front faces +z.
fn sheet(material: Material) -> Mesh {
    solid(
        "sheet",
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ],
        &[&[0, 1, 2, 3]],
        material,
    )
}

/// A block from (0, 0, 0) to (1, 1, 1).
fn block(material: Material) -> Mesh {
    let bit = |i: u32, axis: u32| (i >> axis & 1) as f32;
    let corners: Vec<[f32; 3]> = (0..8).map(|i| [bit(i, 0), bit(i, 1), bit(i, 2)]).collect();
    let faces: [&[u32]; 6] = [
        &[0, 2, 3, 1],
        &[4, 5, 7, 6],
        &[0, 1, 5, 4],
        &[2, 6, 7, 3],
        &[0, 4, 6, 2],
        &[1, 3, 7, 5],
    ];
    solid("block", &corners, &faces, material)
}

/// A signpost that points to +x: nothing that looks the same in a mirror. A closed surface, 0.2 thick.
fn signpost(material: Material) -> Mesh {
    let outline = [
        [-0.1, 0.0],
        [0.1, 0.0],
        [0.1, 1.4],
        [0.9, 1.4],
        [1.3, 1.7],
        [0.9, 2.0],
        [-0.1, 2.0],
    ];
    let corners: Vec<[f32; 3]> = [0.1, -0.1]
        .iter()
        .flat_map(|&z| outline.map(|[x, y]| [x, y, z]))
        .collect();
    let n = outline.len() as u32;
    let mut faces: Vec<Vec<u32>> = (0..n)
        .map(|i| vec![i, i + n, (i + 1) % n + n, (i + 1) % n])
        .collect();
    // The face is cut into convex parts: the post and the arm.
    faces.extend([vec![0, 1, 2, 6], vec![2, 3, 5, 6], vec![3, 4, 5]]);
    faces.extend([
        vec![n + 6, n + 2, n + 1, n],
        vec![n + 6, n + 5, n + 3, n + 2],
        vec![n + 5, n + 4, n + 3],
    ]);
    let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    solid("signpost", &corners, &faces, material)
}

/// Convex faces, counter-clockwise from outside.
fn solid(name: &str, corners: &[[f32; 3]], faces: &[&[u32]], material: Material) -> Mesh {
    let fan = |face: &&[u32]| {
        (1..face.len() - 1)
            .map(|i| [face[0], face[i], face[i + 1]])
            .collect::<Vec<_>>()
    };
    let triangles: Vec<[u32; 3]> = faces.iter().flat_map(fan).collect();
    let surfaces = vec![Surface {
        triangles: 0..triangles.len(),
        material,
    }];
    Mesh {
        name: name.to_owned(),
        positions: corners.to_vec().into(),
        triangles: triangles.into(),
        surfaces,
    }
}

#[derive(Default)]
struct Yard {
    meshes: Vec<Mesh>,
    objects: Vec<Object>,
}

impl Yard {
    fn mesh(&mut self, mesh: Mesh) -> usize {
        self.meshes.push(mesh);
        self.meshes.len() - 1
    }

    fn place(&mut self, name: &str, mesh: usize, matrix3: DMat3, at: [f64; 3]) -> &mut Object {
        self.objects.push(Object {
            name: name.to_owned(),
            mesh,
            world_from_local: DAffine3 {
                matrix3,
                translation: DVec3::from_array(at),
            },
            never_cull: false,
            never_occlude: false,
            occluder_proxy: None,
        });
        self.objects.last_mut().expect("just placed")
    }

    fn stretched(&mut self, name: &str, mesh: usize, size: [f64; 3], at: [f64; 3]) -> &mut Object {
        self.place(
            name,
            mesh,
            DMat3::from_diagonal(DVec3::from_array(size)),
            at,
        )
    }
}

/// Turned about the vertical so that +x shows where (cos, sin) of the angle says, exactly of length 1.
fn turned(cos: f64, sin: f64) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(cos, 0.0, -sin),
        DVec3::Y,
        DVec3::new(sin, 0.0, cos),
    )
}

fn scene() -> Scene {
    let mut yard = Yard::default();
    let stone = yard.mesh(block(paint(0.50, 0.46, 0.40)));
    let brick = yard.mesh(block(paint(0.45, 0.16, 0.10)));
    let crate_ = yard.mesh(block(paint(0.62, 0.44, 0.18)));
    let plaster = yard.mesh(sheet(paint(0.75, 0.70, 0.55)));
    let awning = yard.mesh(sheet(from_both_sides(paint(0.10, 0.30, 0.55))));
    let post = yard.mesh(signpost(paint(0.12, 0.40, 0.20)));
    let pane = yard.mesh(sheet(glass(0.25, 0.75, 0.85, 0.35)));
    let red_pane = yard.mesh(sheet(from_both_sides(glass(0.85, 0.15, 0.10, 0.5))));
    let fence = yard.mesh(sheet(Material {
        alpha: Alpha::Mask,
        ..from_both_sides(paint(0.20, 0.14, 0.10))
    }));
    let core = yard.mesh(solid_core());

    yard.stretched("ground", stone, [24.0, 0.5, 18.0], [-12.0, -0.5, -9.0]);
    yard.stretched("back wall", brick, [20.0, 5.0, 0.6], [-10.0, 0.0, -8.0]);
    yard.stretched("house", brick, [5.0, 4.5, 4.0], [-9.0, 0.0, -4.0])
        .occluder_proxy = Some(core);
    // Behind the house or the wall, or in the house: these are culled.
    for i in 0..6 {
        let x = f64::from(i) * 3.1 - 9.0;
        yard.stretched("hidden crate", crate_, [0.9, 0.7, 0.5], [x, 0.8, -8.8]);
    }
    for i in 0..4 {
        let z = f64::from(i) * 0.9 - 3.6;
        yard.stretched(
            "crate in the house",
            crate_,
            [0.6, 0.6, 0.6],
            [-8.0 + z * 0.2, 0.2, z],
        );
    }
    for (i, x) in [1.0, 2.2, 1.5].into_iter().enumerate() {
        yard.stretched(
            "crate",
            crate_,
            [1.0, 0.9, 1.0],
            [x, if i == 2 { 0.9 } else { 0.0 }, -5.5],
        );
    }
    // One signpost, and the same seen in a mirror, turned, and drawn out.
    yard.place("signpost", post, DMat3::IDENTITY, [-1.5, 0.0, -1.0]);
    let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    yard.place("mirrored signpost", post, mirrored, [-1.9, 0.0, -1.0]);
    let stretched = DMat3::from_diagonal(DVec3::new(1.6, 0.8, 2.5));
    yard.place(
        "turned signpost",
        post,
        turned(0.6, 0.8) * stretched,
        [5.0, 0.0, -3.0],
    );
    yard.place(
        "turned mirrored signpost",
        post,
        turned(0.6, -0.8) * mirrored * stretched,
        [8.6, 0.0, -3.0],
    );
    // Seen from its front it hides the crate behind it; its twin is seen from the back, shows and hides nothing.
    yard.stretched("screen", plaster, [2.0, 2.2, 1.0], [2.8, 0.0, 1.0]);
    yard.stretched(
        "crate behind the screen",
        crate_,
        [0.6, 0.6, 0.6],
        [3.4, 0.7, -0.4],
    );
    yard.stretched(
        "screen seen from behind",
        plaster,
        [2.0, 2.2, -1.0],
        [5.6, 0.0, 1.0],
    );
    yard.place("turned screen", plaster, turned(-1.0, 0.0), [7.6, 0.0, 1.4]);
    yard.stretched(
        "crate behind nothing",
        crate_,
        [0.6, 0.6, 0.6],
        [6.3, 0.0, -0.4],
    );
    yard.place("awning", awning, slope(), [-8.8, 3.2, 0.0]);
    // Glass over glass over a crate, a pane whose back is to the camera, and glass behind the house.
    yard.stretched(
        "crate behind glass",
        crate_,
        [0.8, 0.8, 0.8],
        [-6.2, 0.0, 3.0],
    );
    yard.stretched("pane", pane, [2.6, 2.0, 1.0], [-7.2, 0.0, 5.0]);
    yard.stretched("red pane", red_pane, [2.0, 1.3, 1.0], [-6.0, 0.0, 5.6]);
    yard.place(
        "pane seen from behind",
        pane,
        turned(-1.0, 0.0),
        [-2.5, 0.0, 5.0],
    );
    yard.stretched("hidden pane", pane, [2.0, 2.0, 1.0], [-7.5, 0.0, -7.0]);
    // Cut out by a texture that is not read: it shows, but hides nothing.
    yard.stretched("fence", fence, [6.0, 0.9, 1.0], [0.0, 0.0, 6.5]);
    yard.stretched(
        "crate behind the fence",
        crate_,
        [0.5, 0.5, 0.5],
        [1.0, 0.0, 5.4],
    );
    yard.stretched("statue", stone, [0.5, 1.6, 0.5], [0.2, 0.0, 2.6])
        .never_occlude = true;
    yard.stretched(
        "crate behind the statue",
        crate_,
        [0.2, 0.2, 0.2],
        [0.3, 0.3, 2.2],
    );
    yard.stretched(
        "lamp in the house",
        crate_,
        [0.2, 0.2, 0.2],
        [-6.0, 2.0, -2.0],
    )
    .never_cull = true;
    Scene::new(yard.meshes, yard.objects).expect("a scene")
}

/// A block well inside the unit block.
fn solid_core() -> Mesh {
    let mut core = block(paint(1.0, 1.0, 1.0));
    for position in core.positions.to_mut() {
        *position = position.map(|c| 0.04 + 0.92 * c);
    }
    core
}

/// A sheet that slopes down towards +z.
fn slope() -> DMat3 {
    DMat3::from_cols(
        DVec3::X * 4.6,
        DVec3::new(0.0, -0.6, 1.4),
        DVec3::new(0.0, 1.4, 0.6),
    )
}

fn look_at(eye: [f64; 3], target: [f64; 3], projection: Projection) -> Camera {
    Camera::look_at(
        DVec3::from_array(eye),
        DVec3::from_array(target),
        DVec3::Y,
        projection,
    )
    .expect("a camera")
}

/// Parallel projection from above and from the side; the first frame shows all of it.
pub fn in_parallel() -> Stage {
    let camera = |height, eye, target| {
        look_at(
            eye,
            target,
            Projection::Orthographic {
                height,
                near: 1.0,
                far: Some(60.0),
            },
        )
    };
    Stage::new(
        "courtyard in parallel",
        scene(),
        vec![
            camera(15.0, [9.0, 14.0, 24.0], [-0.5, 1.2, -1.0]),
            camera(9.0, [-9.0, 3.0, 24.0], [-4.0, 1.5, 0.0]),
            camera(13.0, [0.0, 1.6, 30.0], [0.0, 2.0, 0.0]),
            camera(11.0, [20.0, 8.0, -24.0], [0.0, 1.0, 0.0]),
        ],
    )
}

/// Seen by someone who stands in it; the far plane cuts the back wall off in the last frame.
pub fn in_perspective() -> Stage {
    let camera = |far, eye, target| {
        look_at(
            eye,
            target,
            Projection::Perspective {
                fov_y: 0.9,
                near: 0.1,
                far,
            },
        )
    };
    Stage::new(
        "courtyard",
        scene(),
        vec![
            camera(None, [-2.0, 2.6, 11.0], [-0.8, 1.2, 0.0]),
            camera(None, [-6.5, 1.2, 8.5], [-6.0, 1.0, 0.0]),
            camera(None, [5.5, 1.6, 4.0], [5.0, 1.0, -2.0]),
            camera(Some(16.0), [0.0, 2.5, 9.0], [0.0, 1.0, -4.0]),
        ],
    )
}
