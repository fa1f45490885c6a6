// Triangles of areas.

// The corners, the last one twice: the second triangle has no area.
fn triangle_corner(a: vec2f, b: vec2f, c: vec2f, corner: u32) -> vec2f {
    if corner == 0u {
        return a;
    }
    return select(c, b, corner == 1u);
}
