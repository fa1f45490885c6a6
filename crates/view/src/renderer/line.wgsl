// Segments of lines: round ends and joints, smooth edges, a width in pixels.

// A corner of the rectangle about a segment, one pixel larger than the line for its smooth edge.
fn segment_corner(a: vec2f, b: vec2f, half_width: f32, corner: u32) -> vec2f {
    let length = distance(a, b);
    let along = select(vec2f(1.0, 0.0), (b - a) / length, length > 1e-6);
    let across = vec2f(-along.y, along.x);
    let reach = half_width + 1.0;
    let is_end = (corner & 1u) == 1u;
    let side = select(-1.0, 1.0, (corner & 2u) == 2u);
    let origin = select(a - along * reach, b + along * reach, is_end);
    return origin + across * side * reach;
}

// The part of a pixel that a segment paints. Of two neighbours the nearer one paints a pixel, the
// earlier one if both are equally near: so a joint is round, and nothing is painted twice.
fn segment_coverage(pixel: vec2f, in: Painted) -> f32 {
    let own = distance_to(pixel, in.ends.xy, in.ends.zw);
    if (in.kind & HAS_BEFORE) != 0u && distance_to(pixel, in.neighbours.xy, in.ends.xy) <= own {
        return 0.0;
    }
    if (in.kind & HAS_AFTER) != 0u && distance_to(pixel, in.ends.zw, in.neighbours.zw) < own {
        return 0.0;
    }
    return covered(own, in.half_width);
}

// The part of a pixel at some distance from the middle of a line that the line paints. One that is
// thinner than a pixel is a pixel wide, and fainter.
fn covered(distance: f32, half_width: f32) -> f32 {
    let within = clamp(max(half_width, 0.5) + 0.5 - distance, 0.0, 1.0);
    return within * clamp(2.0 * half_width, 0.0, 1.0);
}

// Distance from a point to a segment; beyond its ends it is exactly the distance to the end.
fn distance_to(p: vec2f, a: vec2f, b: vec2f) -> f32 {
    let along = b - a;
    let reach = dot(p - a, along);
    if reach <= 0.0 {
        return distance(p, a);
    }
    let square = dot(along, along);
    if reach >= square {
        return distance(p, b);
    }
    return distance(p, a + along * (reach / square));
}
