//! Which samples a triangle covers, in exact integers.
#![allow(dead_code)] // Each program uses its own share.

/// A point on the sub-pixel grid.
pub type Point = (i32, i32);

/// The sign of `(b − a) × (p − a)`, where `p` is the centre of pixel (`x`, `y`) moved right by ε and down by ε², ε
/// being infinitely small: never 0 unless `a` is `b`.
///
/// That is the top-left rule in other words. A left edge has its inside to the right, a top edge is level and has its
/// inside below, so a centre on either moves in, and from any other edge it moves out.
pub fn side(a: Point, b: Point, x: i32, y: i32) -> i32 {
    let wide = |v: i32| i128::from(v);
    let (dx, dy) = (wide(b.0) - wide(a.0), wide(b.1) - wide(a.1));
    let (px, py) = (256 * wide(x) + 128, 256 * wide(y) + 128);
    let cross = dx * (py - wide(a.1)) - dy * (px - wide(a.0));
    [cross, -dy, dx]
        .into_iter()
        .find(|&term| term != 0)
        .map_or(0, |term| term.signum() as i32)
}

/// Whether a triangle of either winding covers the centre of a pixel.
pub fn covers([a, b, c]: [Point; 3], x: i32, y: i32) -> bool {
    let sides = [side(a, b, x, y), side(b, c, x, y), side(c, a, x, y)];
    sides == [1; 3] || sides == [-1; 3]
}

/// Whether a closed outline goes around the centre of a pixel, by counting the edges to its right.
pub fn inside_outline(outline: &[Point], x: i32, y: i32) -> bool {
    let py = 256 * y + 128;
    let mut inside = false;
    for (i, &a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        // The centre stands an infinitely small way below py, so an end at py is above it.
        if (a.1 > py) != (b.1 > py) {
            let upwards = b.1 < a.1;
            inside ^= (side(a, b, x, y) > 0) == upwards;
        }
    }
    inside
}
