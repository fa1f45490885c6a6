//! Plane areas as triangles, by the even–odd rule.

use lyon_tessellation::math::point;
use lyon_tessellation::path::Path;
use lyon_tessellation::{
    BuffersBuilder, FillOptions, FillRule, FillTessellator, FillVertex, VertexBuffers,
};

use super::primitive::single;

/// Half of the size that areas are scaled to: the tessellator's thresholds are absolute.
const HALF_SIZE: f64 = 512.0;

/// The triangles of an area bounded by closed rings in one plane; none if it has no area.
pub(super) fn triangles(rings: &[Vec<[f64; 3]>]) -> Vec<[[f64; 3]; 3]> {
    let Some(plane) = Plane::of(rings) else { return Vec::new() };
    let mut path = Path::builder();
    for ring in rings {
        let mut points = ring.iter().map(|&p| plane.flat(p)).map(|[x, y]| point(x, y));
        let Some(first) = points.next() else { continue };
        path.begin(first);
        for at in points {
            path.line_to(at);
        }
        path.end(true);
    }
    let mut buffers: VertexBuffers<[f32; 2], u32> = VertexBuffers::new();
    let vertex = |vertex: FillVertex<'_>| vertex.position().to_array();
    let options = FillOptions::default().with_fill_rule(FillRule::EvenOdd);
    let filled = FillTessellator::new().tessellate_path(
        &path.build(),
        &options,
        &mut BuffersBuilder::new(&mut buffers, vertex),
    );
    // An area that the tessellator refuses keeps its edges at least.
    if filled.is_err() {
        return Vec::new();
    }
    let VertexBuffers { vertices, indices } = buffers;
    let corner = |&index: &u32| plane.raised(vertices[index as usize]);
    indices.chunks_exact(3).map(|three| [0, 1, 2].map(|i| corner(&three[i]))).collect()
}

/// The plane of an area: u and v span it.
struct Plane {
    middle: [f64; 3],
    u: [f64; 3],
    v: [f64; 3],
    /// Units of the tessellator per metre.
    scale: f64,
}

impl Plane {
    fn of(rings: &[Vec<[f64; 3]>]) -> Option<Self> {
        let points = || rings.iter().flatten();
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points() {
            for axis in 0..3 {
                low[axis] = low[axis].min(p[axis]);
                high[axis] = high[axis].max(p[axis]);
            }
        }
        let size = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        if !(size.is_finite() && size > 0.0) || points().flatten().any(|x| !x.is_finite()) {
            return None;
        }
        // In the plane, as the middle of their box need not be.
        let n = points().count() as f64;
        let middle = points().fold([0.0; 3], |sum, p| std::array::from_fn(|i| sum[i] + p[i] / n));

        // Newell's normal, of the ring with the largest area.
        let normals = rings.iter().map(|ring| normal(ring, middle));
        let normal = normals.max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)))?;
        let length = dot(normal, normal).sqrt();
        if length <= 1e-12 * size * size {
            return None;
        }
        let n = normal.map(|x| x / length);
        // A plane z = const keeps its own axes.
        let start = if n[2].abs() > 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let along = dot(start, n);
        let u: [f64; 3] = std::array::from_fn(|i| start[i] - along * n[i]);
        let u = u.map(|x| x / dot(u, u).sqrt());
        Some(Self { middle, u, v: cross(n, u), scale: HALF_SIZE / size })
    }

    fn flat(&self, p: [f64; 3]) -> [f32; 2] {
        let arm = std::array::from_fn(|i| self.scale * (p[i] - self.middle[i]));
        [single(dot(arm, self.u)), single(dot(arm, self.v))]
    }

    fn raised(&self, [x, y]: [f32; 2]) -> [f64; 3] {
        let (x, y) = (f64::from(x) / self.scale, f64::from(y) / self.scale);
        std::array::from_fn(|i| self.middle[i] + x * self.u[i] + y * self.v[i])
    }
}

/// Twice the area vector of a ring.
fn normal(ring: &[[f64; 3]], middle: [f64; 3]) -> [f64; 3] {
    let arm = |p: [f64; 3]| std::array::from_fn(|i| p[i] - middle[i]);
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).fold([0.0; 3], |sum, (&a, &b)| {
        let area = cross(arm(a), arm(b));
        std::array::from_fn(|i| sum[i] + area[i])
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(rings: &[Vec<[f64; 3]>]) -> f64 {
        let of = |[a, b, c]: [[f64; 3]; 3]| {
            let to = |p: [f64; 3]| std::array::from_fn(|i| p[i] - a[i]);
            let normal = cross(to(b), to(c));
            0.5 * dot(normal, normal).sqrt()
        };
        triangles(rings).into_iter().map(of).sum()
    }

    fn square(half: f64, at: [f64; 3]) -> Vec<[f64; 3]> {
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        corners.map(|[x, y]| [at[0] + x, at[1] + y, at[2]]).to_vec()
    }

    #[test]
    fn a_hole_is_left_out_and_a_notch_too() {
        let close = |found: f64, expected: f64| {
            assert!((found / expected - 1.0).abs() < 1e-4, "{found} is not {expected}");
        };
        close(area(&[square(1.0, [0.0; 3]), square(0.5, [0.0; 3])]), 3.0);
        let notched = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]];
        close(area(&[notched.map(|[x, y]| [x, y, 0.0]).to_vec()]), 8.0);
        // A micrometre wide, a kilometre from the origin.
        close(area(&[square(1e-6, [1e3, 0.0, 0.0])]), 4e-12);
        // On edge.
        let upright = square(1.0, [0.0; 3]).iter().map(|&[x, y, _]| [0.3, x, y]).collect();
        close(area(&[upright]), 4.0);
    }

    #[test]
    fn triangles_lie_in_the_plane_of_their_area_however_it_is_turned() {
        let place = |[x, y]: [f64; 2]| [x, y, 0.7 * x - 0.4 * y + 2.0];
        let ring = [[0.0, 0.0], [3.0, 0.0], [0.0, 1.0]].map(place).to_vec();
        let corners = triangles(&[ring]).into_iter().flatten();
        let mut n = 0;
        for p in corners {
            n += 1;
            let [_, _, height] = place([p[0], p[1]]);
            assert!((p[2] - height).abs() < 1e-5, "{p:?} is not at {height}");
        }
        assert_eq!(n, 3);
    }

    #[test]
    fn rings_without_area_have_no_triangles() {
        let line = vec![[0.0; 3], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]];
        for rings in [vec![], vec![vec![]], vec![vec![[1.0; 3]]], vec![line]] {
            assert!(triangles(&rings).is_empty());
        }
        assert!(triangles(&[vec![[f64::NAN; 3], [1.0; 3], [0.0; 3]]]).is_empty());
    }
}
