// What a picture goes through after its solid surfaces are drawn, pixel by pixel: creases and background (`creases.rs`), and at the
// end, with translucent surfaces over it, from linear light to sRGB by the CPU picture's own table.

struct Picture {
    background_top: vec3f,
    height: f32,
    background_bottom: vec3f,
    // What a difference of depth, in perspective divided by depth, is in pixels.
    pixels: f32,
    // Depth is the first and the second times z.
    depth: vec2f,
    // How much darker and brighter the strongest creases are.
    creases: vec2f,
    perspective: f32,
    steps: u32,
}

@group(0) @binding(0) var<uniform> picture: Picture;
// To one of two opposite neighbours, and one over the distance.
@group(0) @binding(1) var<storage, read> steps: array<vec4f>;
// Four bytes a word.
@group(0) @binding(2) var<storage, read> srgb: array<u32>;
@group(1) @binding(0) var light: texture_2d<f32>;
@group(1) @binding(1) var depths: texture_depth_2d;

@vertex
fn everywhere(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    return vec4f(at, 0.0, 1.0);
}

@fragment
fn crease(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = vec2i(position.xy);
    let z = textureLoad(depths, at, 0);
    if z <= 0.0 {
        let share = position.y / picture.height;
        return vec4f(mix(picture.background_top, picture.background_bottom, share), 1.0);
    }
    let here = picture.depth.x + picture.depth.y * z;
    let size = vec2i(textureDimensions(depths));
    var dark = 0.0;
    var bright = 0.0;
    for (var i = 0u; i < picture.steps; i++) {
        let step = vec2i(steps[i].xy);
        let one = at + step;
        let other = at - step;
        if any(one < vec2i(0)) || any(other < vec2i(0)) || any(one >= size) || any(other >= size) {
            continue;
        }
        let a = textureLoad(depths, one, 0);
        let b = textureLoad(depths, other, 0);
        if a <= 0.0 || b <= 0.0 {
            continue;
        }
        let nearer = ((picture.depth.x + picture.depth.y * a) - here) + ((picture.depth.x + picture.depth.y * b) - here);
        var slope = nearer * picture.pixels;
        if picture.perspective == 1.0 {
            slope = nearer / here * picture.pixels;
        }
        slope = slope * 0.5 * steps[i].z;
        if slope > 1.0 {
            dark += 1.0 / (slope * slope);
        } else if slope > 0.0 {
            dark += slope;
        } else if slope > -1.0 {
            bright -= slope;
        } else {
            bright += 1.0 / (slope * slope);
        }
    }
    let count = f32(picture.steps);
    let factor = (1.0 - picture.creases.x * (dark / count)) * (1.0 + picture.creases.y * (bright / count));
    return vec4f(textureLoad(light, at, 0).rgb * factor, 1.0);
}

fn encoded(linear: f32) -> f32 {
    let last = 4u * arrayLength(&srgb) - 1u;
    let at = min(u32(max(linear * f32(last) + 0.5, 0.0)), last);
    return f32(srgb[at / 4u] >> (8u * (at % 4u)) & 255u) / 255.0;
}

@fragment
fn encode(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let color = textureLoad(light, vec2i(position.xy), 0);
    return vec4f(encoded(color.r), encoded(color.g), encoded(color.b), 1.0);
}
