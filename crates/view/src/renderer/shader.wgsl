// All primitives, in their order: triangles, segments of lines and rods.

struct Globals {
    size: vec2f,
    pixels_per_point: f32,
    n_fixed: u32,
    is_ordered: u32,
    pixels_per_metre: f32,
}

struct Primitive {
    a: vec3f,
    body: u32,
    b: vec3f,
    half_width: f32,
    before: vec3f,
    color: u32,
    after: vec3f,
    kind: u32,
}

// From the frame of a body to pixels.
struct Placement {
    x: vec4f,
    y: vec4f,
}

struct Layer {
    first_placement: u32,
    opacity: f32,
}

@group(0) @binding(0) var<uniform> globals: Globals;
@group(0) @binding(1) var<storage, read> fixed_primitives: array<Primitive>;
@group(0) @binding(2) var<storage, read> moving_primitives: array<Primitive>;
@group(0) @binding(3) var<storage, read> placements: array<Placement>;
@group(0) @binding(4) var<storage, read> layers: array<Layer>;
@group(0) @binding(5) var<storage, read> order: array<u32>;

// Whether the target takes linear light instead of sRGB.
override is_linear: bool = false;

const TRIANGLE = 0u;
const HAS_BEFORE = 2u;
const HAS_AFTER = 4u;
const ROD = 8u;
const RIM = 9u;
const BALL = 10u;

struct Painted {
    @builtin(position) position: vec4f,
    @location(0) pixel: vec2f,
    @location(1) @interpolate(flat) color: vec4f,
    @location(2) @interpolate(flat) ends: vec4f,
    @location(3) @interpolate(flat) neighbours: vec4f,
    @location(4) @interpolate(flat) half_width: f32,
    @location(5) @interpolate(flat) kind: u32,
}

@vertex
fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) layer_idx: u32) -> Painted {
    var idx = vertex / 6u;
    if globals.is_ordered != 0u {
        idx = order[idx];
    }
    // Two triangles: corners 0, 1, 2 and 2, 1, 3, from the lowest digit.
    let corner = (0x312210u >> (4u * (vertex % 6u))) & 3u;
    var primitive: Primitive;
    if idx < globals.n_fixed {
        primitive = fixed_primitives[idx];
    } else {
        primitive = moving_primitives[idx - globals.n_fixed];
    }
    let layer = layers[layer_idx];
    let placement = placements[layer.first_placement + primitive.body];
    let a = in_pixels(placement, primitive.a);
    let b = in_pixels(placement, primitive.b);
    let before = in_pixels(placement, primitive.before);
    let after = in_pixels(placement, primitive.after);

    var out: Painted;
    let color = unpack4x8unorm(primitive.color);
    out.color = vec4f(color.rgb, color.a * layer.opacity);
    out.ends = vec4f(a, b);
    out.neighbours = vec4f(before, after);
    out.half_width = primitive.half_width * globals.pixels_per_point;
    out.kind = primitive.kind;
    if primitive.kind == TRIANGLE {
        out.pixel = triangle_corner(a, b, before, corner);
    } else {
        if primitive.kind >= ROD {
            // A rod has no neighbours: in their stead, the distance from the line where a rim begins, and the
            // colour of a ball across the light.
            let radius = primitive.before.x * globals.pixels_per_metre;
            out.neighbours = vec4f(radius - out.half_width, primitive.after);
            out.half_width += radius;
        }
        out.pixel = segment_corner(a, b, out.half_width, corner);
    }
    let ndc = 2.0 * out.pixel / globals.size - 1.0;
    out.position = vec4f(ndc.x, -ndc.y, 0.0, 1.0);
    return out;
}

@fragment
fn fragment(in: Painted) -> @location(0) vec4f {
    var coverage = 1.0;
    if in.kind >= ROD {
        coverage = rod_coverage(in.pixel, in);
    } else if in.kind != TRIANGLE {
        // The middle of the pixel in the viewport, the same to the last bit for all segments there:
        // neighbours have to agree which of them paints it.
        let viewport = round(in.position.xy - in.pixel);
        coverage = segment_coverage(in.position.xy - viewport, in);
    }
    let alpha = in.color.a * coverage;
    var rgb = in.color.rgb;
    if in.kind == BALL {
        rgb = mix(rgb, in.neighbours.yzw, ball_shade(in.pixel, in));
    }
    if is_linear {
        rgb = linear_from_srgb(rgb);
    }
    return vec4f(rgb * alpha, alpha);
}

fn in_pixels(placement: Placement, p: vec3f) -> vec2f {
    let x = placement.x;
    let y = placement.y;
    return vec2f(dot(x.xyz, p) + x.w, dot(y.xyz, p) + y.w);
}

fn linear_from_srgb(c: vec3f) -> vec3f {
    let steep = pow((c + 0.055) / 1.055, vec3f(2.4));
    return select(steep, c / 12.92, c <= vec3f(0.04045));
}
