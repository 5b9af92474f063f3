// Surfaces: flat-shaded as the CPU picture is (`light.rs`), or the numbers of their objects.
//
// A vertex looks its triangle up. All that is the same over a face is found here once: its light hangs on no interpolation, so two
// pictures in which a pixel shows the same face at the same depth have the same bits there.

struct View {
    // Directions, world axes.
    key_direction: vec3f,
    // 1 in perspective: the direction to the eye differs from place to place.
    perspective: f32,
    forward: vec3f,
    lamp: f32,
    ground: vec3f,
    near: f32,
    sky_less_ground: vec3f,
    // Haze begins at this distance, and has half its strength this much farther.
    clear_distance: f32,
    key: vec3f,
    haze_distance: f32,
    haze: vec3f,
    most_haze: f32,
    // Depth is the first and the second times z.
    depth: vec2f,
    // Half the picture's width and height, pixels.
    half_size: vec2f,
}

// A surface of an object, ready to be drawn: rows that take a position relative to the middle of its mesh.
struct Draw {
    clip: array<vec4f, 4>,
    // To coordinates relative to the eye, world axes.
    from_eye: array<vec4f, 3>,
    // Linear; and how opaque.
    color: vec4f,
    object: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> draws: array<Draw>;
@group(1) @binding(0) var<storage, read> positions: array<f32>;
@group(1) @binding(1) var<storage, read> corners: array<u32>;

struct Vertex {
    @builtin(position) @invariant position: vec4f,
    @location(0) @interpolate(flat) lit: vec4f,
    @location(1) @interpolate(flat) range_of_z: vec2f,
    @location(2) @interpolate(flat) object: u32,
}

struct Lit {
    @location(0) light: vec4f,
    @builtin(frag_depth) z: f32,
}

struct Owned {
    @location(0) object: u32,
    @builtin(frag_depth) z: f32,
}

fn z_of(in: Vertex) -> f32 {
    return clamp(in.position.z, in.range_of_z.x, in.range_of_z.y);
}

fn position_of(corner: u32) -> vec3f {
    let at = 3u * corners[corner];
    return vec3f(positions[at], positions[at + 1u], positions[at + 2u]);
}

fn unit_or_zero(v: vec3f) -> vec3f {
    let most = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if most > 0.0 {
        return normalize(v / most);
    }
    return vec3f(0.0);
}

fn clip_of(draw: Draw, position: vec3f) -> vec4f {
    let p = vec4f(position, 1.0);
    return vec4f(dot(draw.clip[0], p), dot(draw.clip[1], p), dot(draw.clip[2], p), dot(draw.clip[3], p));
}

// A sliver is thinner than this, pixels.
const THINNEST: f32 = 1.0 / 16.0;

// The least and the largest z of a triangle's samples. The slope of a sliver's depth is all rounding, and devices go on along it beyond
// the corners' depths. So, as in the CPU picture, no sample lies outside of these, and a sliver is as far away all over as its farthest
// corner.
fn range_of_z(a: vec4f, b: vec4f, c: vec4f) -> vec2f {
    if min(min(a.w, b.w), c.w) <= 0.0 {
        return vec2f(0.0, 1.0);
    }
    let z = vec3f(a.z / a.w, b.z / b.w, c.z / c.w);
    let at = a.xy / a.w;
    let to_b = (b.xy / b.w - at) * view.half_size;
    let to_c = (c.xy / c.w - at) * view.half_size;
    let area = abs(to_b.x * to_c.y - to_b.y * to_c.x);
    let side = max(max(length(to_b), length(to_c)), length(to_b - to_c));
    let least = min(min(z.x, z.y), z.z);
    return vec2f(least, select(max(max(z.x, z.y), z.z), least, area < side * THINNEST));
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) number: u32) -> Vertex {
    let draw = draws[number];
    let first = corner - corner % 3u;
    let a = position_of(first);
    var b = position_of(first + 1u);
    var c = position_of(first + 2u);
    var out: Vertex;
    out.position = clip_of(draw, position_of(corner));
    out.range_of_z = range_of_z(clip_of(draw, a), clip_of(draw, b), clip_of(draw, c));
    out.object = draw.object;

    b -= a;
    c -= a;
    let place = draw.from_eye;
    let along_b = vec3f(dot(place[0].xyz, b), dot(place[1].xyz, b), dot(place[2].xyz, b));
    let along_c = vec3f(dot(place[0].xyz, c), dot(place[1].xyz, c), dot(place[2].xyz, c));
    let from_eye = vec3f(
        dot(place[0], vec4f(a, 1.0)),
        dot(place[1], vec4f(a, 1.0)),
        dot(place[2], vec4f(a, 1.0)),
    );
    let to_eye = select(-view.forward, unit_or_zero(-from_eye), view.perspective == 1.0);
    var normal = unit_or_zero(cross(along_b, along_c));
    if dot(normal, to_eye) < 0.0 {
        normal = -normal;
    }
    let above = 0.5 + 0.5 * normal.y;
    let key = max(dot(normal, view.key_direction), 0.0);
    let lamp = view.lamp * max(dot(normal, to_eye), 0.0);
    let light = view.ground + view.sky_less_ground * above + view.key * key + lamp;
    out.lit = vec4f(draw.color.rgb * light, draw.color.a);
    return out;
}

// What the light of a face is after the way from its depth.
@fragment
fn light(in: Vertex) -> Lit {
    let z = z_of(in);
    var haze = 0.0;
    if view.perspective == 1.0 {
        let distance = view.near / (view.depth.x + view.depth.y * z) - view.clear_distance;
        if distance > 0.0 {
            haze = view.most_haze * (distance / (distance + view.haze_distance));
        }
    }
    return Lit(vec4f(mix(in.lit.rgb, view.haze, haze), in.lit.a), z);
}

@fragment
fn owner(in: Vertex) -> Owned {
    return Owned(in.object, z_of(in));
}
