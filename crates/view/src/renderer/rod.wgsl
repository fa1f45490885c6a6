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
