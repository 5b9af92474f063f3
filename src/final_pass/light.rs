//! What colour a surface has: flat shading from the face's own normal, in linear light.
//!
//! Three lights that need no setting up in any scene: a sky that is brighter above than below, a key light from over
//! the viewer's shoulder in the world, and a weak lamp at the eye, so that walls at right angles differ indoors too.
//! Faces are lit on the side they show. Only additions, multiplications, divisions and square roots of f64 are used,
//! so a picture has the same bytes on every machine.

use glam::DVec3;

use super::surfaces::distance_at;
use crate::scene::{Aabb, Alpha, Material, Scene};
use crate::view::{Camera, Projection};

/// A colour in linear light: red, green, blue, 0 to 1.
pub type Linear = [f32; 3];

/// Light from straight above, and from straight below.
pub const SKY: [f64; 3] = [0.34, 0.38, 0.44];
pub const GROUND: [f64; 3] = [0.15, 0.135, 0.12];
/// The key light: where it stands, and its colour.
const KEY_DIRECTION: DVec3 = DVec3::new(0.48, 0.78, 0.40);
pub const KEY: [f64; 3] = [0.80, 0.735, 0.615];
/// The lamp at the eye.
pub const LAMP: f64 = 0.26;

/// The background at the top of the picture and at its bottom.
pub const BACKGROUND_TOP: Linear = [0.30, 0.38, 0.50];
pub const BACKGROUND_BOTTOM: Linear = [0.74, 0.78, 0.80];

/// What distance fades to, and how much of it far away.
pub const HAZE: Linear = [0.52, 0.58, 0.66];
pub const MOST_HAZE: f64 = 0.28;

/// Opacity of translucent surfaces whose material leaves it to a texture.
const UNKNOWN_OPACITY: f32 = 0.5;

/// Lights a scene for a camera.
#[derive(Clone, Debug)]
pub struct Light<'a> {
    scene: &'a Scene,
    eye: DVec3,
    projection: Projection,
    forward: DVec3,
    key: DVec3,
    /// Haze begins here, and has half its strength this much farther; scene units.
    clear_distance: f64,
    haze_distance: f64,
    /// All solid surfaces have one colour: objects get colours of their own, to be told apart.
    plain: bool,
}

impl<'a> Light<'a> {
    /// The light of a scene, seen by a camera.
    pub fn new(scene: &'a Scene, camera: &Camera) -> Light<'a> {
        let all = scene
            .bounds()
            .iter()
            .fold(Aabb::EMPTY, |all, &b| all.union(b));
        let eye = camera.eye();
        let outside = eye - eye.max(all.min).min(all.max);
        let mut colors = scene
            .meshes()
            .iter()
            .flat_map(|m| &m.surfaces)
            .filter(|s| s.material.alpha != Alpha::Blend)
            .map(|s| s.material.color);
        let first = colors.next();
        Light {
            scene,
            eye,
            projection: *camera.projection(),
            forward: camera.forward(),
            key: KEY_DIRECTION / KEY_DIRECTION.length(),
            clear_distance: outside.length(),
            haze_distance: all.size().length(),
            plain: first.is_none_or(|first| colors.all(|c| c == first)),
        }
    }

    /// The direction to the key light, world axes.
    #[cfg(feature = "gpu")]
    pub fn key(&self) -> DVec3 {
        self.key
    }

    /// The distance where haze begins, and how much farther it has half its strength.
    #[cfg(feature = "gpu")]
    pub fn haze(&self) -> [f64; 2] {
        [self.clear_distance, self.haze_distance]
    }

    /// The background in a row of pixels.
    pub fn background(&self, row: usize, rows: usize) -> Linear {
        mix(
            BACKGROUND_TOP,
            BACKGROUND_BOTTOM,
            (row as f64 + 0.5) / rows as f64,
        )
    }

    /// The colour of the light that a face of an object sends to the eye from a depth.
    pub fn color_of(
        &self,
        object: u32,
        triangle: usize,
        material: &Material,
        depth: f32,
    ) -> Linear {
        let base = self.base_color(object, material);
        let lit = self.lit(object, triangle, base);
        let distance = distance_at(&self.projection, depth);
        // Orthographic views have no distance from an eye.
        let haze = match self.projection {
            Projection::Perspective { .. } if distance > self.clear_distance => {
                let distance = distance - self.clear_distance;
                MOST_HAZE * (distance / (distance + self.haze_distance))
            }
            _ => 0.0,
        };
        mix(lit, HAZE, haze)
    }

    /// The colour of an object's surface in white light.
    pub fn base_color(&self, object: u32, material: &Material) -> Linear {
        if self.plain && material.alpha != Alpha::Blend {
            color_of_index(object)
        } else {
            let c = material.color;
            [unit(c[0]), unit(c[1]), unit(c[2])]
        }
    }

    /// A surface of colour `base`, lit as the face lies.
    pub fn lit(&self, object: u32, triangle: usize, base: Linear) -> Linear {
        let (normal, to_eye) = self.facing(object, triangle);
        let above = 0.5 + 0.5 * normal.y;
        let key = positive(normal.dot(self.key));
        let lamp = LAMP * positive(normal.dot(to_eye));
        std::array::from_fn(|i| {
            let light = GROUND[i] + (SKY[i] - GROUND[i]) * above + KEY[i] * key + lamp;
            (f64::from(base[i]) * light) as f32
        })
    }

    /// The unit normal of a face on the side that shows, world axes, and the direction to the eye.
    fn facing(&self, object: u32, triangle: usize) -> (DVec3, DVec3) {
        let placed = &self.scene.objects()[object as usize];
        let mesh = &self.scene.meshes()[placed.mesh];
        let corner = |i: u32| {
            let p = mesh.positions[i as usize].map(f64::from);
            placed.world_from_local.matrix3 * DVec3::from_array(p)
        };
        let [a, b, c] = mesh.triangles[triangle].map(corner);
        let to_eye = match self.projection {
            Projection::Perspective { .. } => {
                direction(self.eye - placed.world_from_local.translation - a)
            }
            Projection::Orthographic { .. } => -self.forward,
        };
        let normal = direction((b - a).cross(c - a));
        if normal.dot(to_eye) < 0.0 {
            (-normal, to_eye)
        } else {
            (normal, to_eye)
        }
    }
}

/// How opaque a translucent material is.
pub fn opacity(material: &Material) -> f32 {
    let opacity = material.color[3];
    if opacity < 1.0 {
        unit(opacity)
    } else {
        UNKNOWN_OPACITY
    }
}

/// From `a` to `b`, as `share` goes from 0 to 1.
pub fn mix(a: Linear, b: Linear, share: f64) -> Linear {
    std::array::from_fn(|i| {
        let (a, b) = (f64::from(a[i]), f64::from(b[i]));
        (a + (b - a) * share) as f32
    })
}

/// A vector of length 1, or 0 if there is none in that direction.
fn direction(v: DVec3) -> DVec3 {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest < f64::INFINITY {
        let v = v / largest;
        v / v.length()
    } else {
        DVec3::ZERO
    }
}

fn positive(v: f64) -> f64 {
    if v > 0.0 { v } else { 0.0 }
}

fn unit(v: f32) -> f32 {
    if v >= 1.0 {
        1.0
    } else if v > 0.0 {
        v
    } else {
        0.0
    }
}

/// Muted colours, linear, of like lightness: stone, sand, clay, brick, moss, sage, slate, steel, plum, ash.
const MUTED: [Linear; 10] = [
    [0.46, 0.43, 0.38],
    [0.54, 0.46, 0.33],
    [0.52, 0.37, 0.28],
    [0.43, 0.27, 0.23],
    [0.36, 0.38, 0.24],
    [0.39, 0.46, 0.36],
    [0.31, 0.37, 0.42],
    [0.34, 0.43, 0.52],
    [0.42, 0.34, 0.42],
    [0.40, 0.41, 0.42],
];

/// A muted colour of an object's own, from a hash of its index.
fn color_of_index(object: u32) -> Linear {
    // Multiplied, folded, and multiplied again, so that neighbours differ in the high bits.
    let hash = object.wrapping_mul(0x9E37_79B1);
    let hash = (hash ^ (hash >> 15)).wrapping_mul(0x85EB_CA6B);
    let color = MUTED[(hash >> 16) as usize % MUTED.len()];
    let lightness = 0.76 + 0.26 * ((hash & 0xff) as f32 / 255.0);
    color.map(|c| c * lightness)
}
