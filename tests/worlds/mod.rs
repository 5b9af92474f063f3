//! Random meshes, placements and cameras of the sorts that break culling.
#![allow(dead_code)] // Each test file uses its own share.

use antumbra::glam::{DAffine3, DMat3, DVec3};
use antumbra::occlusion::{OrientedBox, Sphere};
use antumbra::scene::{Alpha, Material, Mesh, Object, Surface};
use antumbra::view::{Camera, Projection};

use crate::oracle::Chance;

pub fn direction(chance: &mut Chance) -> DVec3 {
    loop {
        let mut at = || chance.real(-1.0, 1.0);
        let v = DVec3::new(at(), at(), at());
        let length = v.length();
        if 0.1 < length && length < 1.0 {
            return v / length;
        }
    }
}

/// A right-handed rotation.
pub fn rotation(chance: &mut Chance) -> DMat3 {
    loop {
        let x = direction(chance);
        let y = direction(chance).cross(x);
        if y.length() > 0.1 {
            let y = y / y.length();
            return DMat3::from_cols(x, y, x.cross(y));
        }
    }
}

fn narrow(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// A mesh of one surface.
pub fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, material: Material) -> Mesh {
    let surfaces = vec![Surface {
        triangles: 0..triangles.len(),
        material,
    }];
    Mesh {
        name: String::new(),
        positions: positions.into(),
        triangles: triangles.into(),
        surfaces,
    }
}

pub const DOUBLE_SIDED: Material = Material {
    alpha: Alpha::Opaque,
    double_sided: true,
    color: [1.0; 4],
};

pub const SINGLE_SIDED: Material = Material {
    double_sided: false,
    ..DOUBLE_SIDED
};

/// What a mesh looks like; all are about 2 units wide, around the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A square in the plane z = 0, in `n` × `n` cells.
    Wall(u32),
    /// A cube.
    Cube,
    /// A ball of 8·4ⁿ triangles.
    Ball(u32),
    /// Triangles anywhere.
    Soup(u32),
    /// Triangles as thin as f32 allows.
    Slivers(u32),
}

pub const SHAPES: [Shape; 8] = [
    Shape::Wall(1),
    Shape::Wall(5),
    Shape::Cube,
    Shape::Cube,
    Shape::Ball(0),
    Shape::Ball(2),
    Shape::Soup(9),
    Shape::Slivers(9),
];

/// Positions and triangles of a shape; front faces look outwards.
pub fn shape(chance: &mut Chance, shape: Shape) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    match shape {
        Shape::Wall(n) => {
            let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
            let positions = (0..=n)
                .flat_map(|y| (0..=n).map(move |x| DVec3::new(at(x), at(y), 0.0)))
                .collect();
            let cells = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
            let triangles = cells
                .flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]])
                .collect();
            (positions, triangles)
        }
        Shape::Cube => {
            let sign = |i: u32, bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let positions = (0..8)
                .map(|i| DVec3::new(sign(i, 0), sign(i, 1), sign(i, 2)))
                .collect();
            let faces = [
                [0, 2, 3, 1],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 4, 6, 2],
                [1, 3, 7, 5],
            ];
            (
                positions,
                faces
                    .iter()
                    .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                    .collect(),
            )
        }
        Shape::Ball(splits) => {
            let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
            let mut positions = vec![x, y, -x, -y, z, -z];
            let mut triangles: Vec<[u32; 3]> = (0..4)
                .flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]])
                .collect();
            for _ in 0..splits {
                triangles = triangles
                    .into_iter()
                    .flat_map(|[a, b, c]| {
                        let mut middle = |i: u32, j: u32| {
                            let m = positions[i as usize] + positions[j as usize];
                            positions.push(m / m.length());
                            positions.len() as u32 - 1
                        };
                        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                        [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
                    })
                    .collect();
            }
            (positions, triangles)
        }
        Shape::Soup(n) => {
            let positions = (0..3 * n)
                .map(|_| direction(chance) * chance.real(0.0, 1.0))
                .collect();
            (
                positions,
                (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            )
        }
        Shape::Slivers(n) => {
            let mut positions = Vec::new();
            for _ in 0..n {
                let (a, b) = (direction(chance), direction(chance));
                let off = direction(chance) * 1e-6;
                positions.extend([a, b, a + (b - a) * chance.real(0.0, 1.0) + off]);
            }
            (
                positions,
                (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            )
        }
    }
}

/// A shape somewhere near `place`: scaled evenly or not, turned, perhaps mirrored. What `baked` takes from the matrix's
/// translation stands in the positions instead, or far away from both, to cancel.
pub fn placed(
    chance: &mut Chance,
    kind: Shape,
    material: Material,
    place: DVec3,
    radius: f64,
) -> (Mesh, DAffine3) {
    let (points, triangles) = shape(chance, kind);
    let turned = rotation(chance);
    let mut scale = || radius * chance.real(0.3, 1.0);
    let mut scales = DVec3::new(scale(), scale(), scale());
    if chance.one_in(3) {
        scales = DVec3::splat(radius);
    } else if chance.one_in(6) {
        scales.z *= 1e-4;
    }
    if chance.one_in(3) {
        scales.x = -scales.x;
    }
    let matrix3 = turned * DMat3::from_diagonal(scales);
    // All in the matrix; all in the positions; or far off in the positions and back by the matrix.
    let offset = match chance.whole(0, 3) {
        0 | 1 => DVec3::ZERO,
        2 => place,
        _ => direction(chance) * 1e7,
    };
    if offset == place {
        // Turned and scaled in the positions too, as an exporter does.
        let positions = points
            .iter()
            .map(|&p| narrow(matrix3 * p + place))
            .collect();
        return (mesh(positions, triangles, material), DAffine3::IDENTITY);
    }
    let positions = points.iter().map(|&p| narrow(p + offset)).collect();
    let translation = place - matrix3 * offset;
    (
        mesh(positions, triangles, material),
        DAffine3 {
            matrix3,
            translation,
        },
    )
}

/// An oriented box around a placed mesh, and a ball: both as a user might find them, with a part in 2⁴⁰ to spare for
/// the user's own rounding.
pub fn around(mesh: &Mesh, world_from_local: &DAffine3) -> (OrientedBox, Sphere) {
    let point = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
    let all = || mesh.positions.iter().map(point);
    let min = all().fold(DVec3::INFINITY, DVec3::min);
    let max = all().fold(DVec3::NEG_INFINITY, DVec3::max);
    let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5);
    let DAffine3 {
        matrix3: m,
        translation,
    } = *world_from_local;
    let far = min.abs().max(max.abs());
    let terms = m.x_axis.abs() * far.x
        + m.y_axis.abs() * far.y
        + m.z_axis.abs() * far.z
        + translation.abs();
    let spare = terms.max_element() / (1_u64 << 40) as f64;
    let center = world_from_local.transform_point3(middle);
    // Half an axis longer by `spare` in its own direction; a flat side gets one from the other two.
    let axes = [m.x_axis * half.x, m.y_axis * half.y, m.z_axis * half.z];
    let longer = |i: usize| {
        let (a, b, c) = (axes[i], axes[(i + 1) % 3], axes[(i + 2) % 3]);
        let along = if a.length() > 0.0 { a } else { b.cross(c) };
        if along.length() > 0.0 {
            a + along * (4.0 * spare / along.length())
        } else {
            a
        }
    };
    let radius = all()
        .map(|p| (world_from_local.transform_point3(p) - center).length())
        .fold(0.0, f64::max);
    (
        OrientedBox {
            center,
            half_axes: [longer(0), longer(1), longer(2)],
        },
        Sphere {
            center,
            radius: radius + 4.0 * spare,
        },
    )
}

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

/// Where worlds stand: at the origin, and far from it in each way.
pub fn home(chance: &mut Chance) -> DVec3 {
    let reach = [0.0, 2_000.0, 200_000.0][chance.whole(0, 2) as usize];
    let sign = |chance: &mut Chance| if chance.one_in(2) { 1.0 } else { -1.0 };
    DVec3::new(sign(chance), sign(chance), sign(chance)) * reach
}

/// A camera `distance` away from a point, which it sees; perspective or orthographic, with a far plane or without.
pub fn camera(chance: &mut Chance, target: DVec3, distance: f64) -> Camera {
    loop {
        let eye = target + direction(chance) * distance;
        let aim = target + direction(chance) * distance * 0.2;
        let far = chance.one_in(3).then(|| distance * chance.real(0.9, 3.0));
        let projection = if chance.one_in(3) {
            let near = if chance.one_in(2) {
                distance * 0.01
            } else {
                -distance
            };
            Projection::Orthographic {
                height: distance * chance.real(0.3, 3.0),
                near,
                far,
            }
        } else {
            Projection::Perspective {
                fov_y: chance.real(0.1, 2.2),
                near: distance * [0.5, 0.1, 1e-3, 1e-6][chance.whole(0, 3) as usize],
                far,
            }
        };
        if let Ok(camera) = Camera::look_at(eye, aim, direction(chance), projection) {
            return camera;
        }
    }
}
