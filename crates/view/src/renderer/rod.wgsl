// Rods with round ends, and balls: without perspective they are equally wide in every view.

// The part of a pixel that a rod or its rim paints.
fn rod_coverage(pixel: vec2f, in: Painted) -> f32 {
    let own = distance_to(pixel, in.ends.xy, in.ends.zw);
    let whole = covered(own, in.half_width);
    if in.kind == RIM {
        return whole - covered(own, in.neighbours.x);
    }
    return whole;
}

// The direction to the light: right, up, towards the eye.
const LIGHT = vec3f(-0.35, 0.55, 0.758);

// How far a ball is turned away from the light at a pixel: 0 towards it, 1 across and beyond.
fn ball_shade(pixel: vec2f, in: Painted) -> f32 {
    let across = (pixel - in.ends.xy) / in.half_width;
    let near = sqrt(max(0.0, 1.0 - dot(across, across)));
    return 1.0 - saturate(dot(vec3f(across.x, -across.y, near), LIGHT));
}
