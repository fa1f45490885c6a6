//! [`Moments`]: integrals over an area of powers of the coordinates up to the second.
//!
//! By Green's theorem each curve gives its share by itself: the triangle between the reference point and
//! the chord, and the lens between the chord and the curve. Closed forms for lines, arcs and ellipses;
//! splines by quadrature to near rounding.

use super::bezier::Bezier;
use super::conic::Conic;
use super::curve::Piece;
use super::lens::Lens;
use super::quadrature::adaptive;
use super::vector::{along, cross, direction, scaled, sub};
use super::{Affine, Curve, Path, Point};

/// Moments about the origin of the axes they are written in; negative areas are allowed.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub(crate) struct Moments {
    /// ∫ dA.
    pub(crate) area: f64,
    /// ∫ x dA, ∫ y dA.
    pub(crate) first: [f64; 2],
    /// ∫ x² dA, ∫ x y dA, ∫ y² dA.
    pub(crate) second: [f64; 3],
}

impl Moments {
    /// Of the area inside a closed path, about a point.
    pub(crate) fn of_path(path: &Path, reference: Point) -> Self {
        let to_reference = Affine::translation(sub([0.0; 2], reference));
        let shares = path.curves.iter().map(|curve| Self::of(&curve.transformed(&to_reference)));
        shares.fold(Self::default(), Self::plus)
    }

    /// Of the area that the ray from the origin sweeps along the curve, positive counter-clockwise.
    fn of(curve: &Curve) -> Self {
        let shares = curve.pieces().into_iter().map(|piece| match piece {
            Piece::Line([from, to]) => Self::triangle(from, to),
            Piece::Conic(conic) => Self::sector(&conic),
            Piece::Bezier(bezier) => Self::swept(&bezier),
        });
        shares.fold(Self::default(), Self::plus)
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            area: self.area + other.area,
            first: [0, 1].map(|k| self.first[k] + other.first[k]),
            second: [0, 1, 2].map(|k| self.second[k] + other.second[k]),
        }
    }

    /// `None` without a positive area.
    pub(crate) fn centroid(&self) -> Option<Point> {
        let centroid = self.first.map(|s| s / self.area);
        (self.area > 0.0 && centroid.iter().all(|x| x.is_finite())).then_some(centroid)
    }

    /// Second moments about the centroid, by the parallel-axis theorem.
    pub(crate) fn about_centroid(&self) -> [f64; 3] {
        let [x, y] = self.first;
        let shift = [x * x, x * y, y * y].map(|s| s / self.area);
        [0, 1, 2].map(|k| self.second[k] - shift[k])
    }

    /// Of the triangle from the origin to `p` and `q`.
    fn triangle(p: Point, q: Point) -> Self {
        let double = cross(p, q);
        let mixed = 2.0 * (p[0] * p[1] + q[0] * q[1]) + p[0] * q[1] + q[0] * p[1];
        let square = |k: usize| p[k] * p[k] + p[k] * q[k] + q[k] * q[k];
        Self {
            area: double / 2.0,
            first: [0, 1].map(|k| double / 6.0 * (p[k] + q[k])),
            second: [square(0), mixed / 2.0, square(1)].map(|s| double / 12.0 * s),
        }
    }

    /// The triangle to the chord, and the lens between chord and arc: the image of a lens of the
    /// unit circle.
    fn sector(conic: &Conic) -> Self {
        let half = 0.5 * conic.sweep.abs();
        let middle = direction(conic.start + 0.5 * conic.sweep);
        // Axes of the lens: from the chord outwards, and along the chord.
        let outwards = image(conic, middle);
        let chord = image(conic, [-middle[1], middle[0]]);
        let from_lens =
            Affine { x: outwards, y: chord, origin: along(conic.centre, half.cos(), outwards) };
        let lens = Lens::of(half);
        let unit = Self {
            area: lens.area,
            first: [lens.first, 0.0],
            second: [lens.outwards, 0.0, lens.chord],
        };
        let triangle = Self::triangle(conic.point(0.0), conic.point(1.0));
        triangle.plus(unit.image(&from_lens).times(conic.sweep.signum()))
    }

    /// `½ ∮ (x dy − y dx)` and its companions: `∫ f dA = ∮ f (x dy − y dx)/(n + 2)` for an `f`
    /// homogeneous of degree n.
    fn swept(bezier: &Bezier) -> Self {
        let [area, x, y, xx, xy, yy] = adaptive(|t| {
            let (p, velocity) = bezier.at(t);
            let rate = cross(p, velocity);
            let [x, y] = p;
            [1.0, x, y, x * x, x * y, y * y].map(|f| f * rate)
        });
        Self { area: area / 2.0, first: [x / 3.0, y / 3.0], second: [xx / 4.0, xy / 4.0, yy / 4.0] }
    }

    fn times(self, factor: f64) -> Self {
        Self {
            area: factor * self.area,
            first: self.first.map(|s| factor * s),
            second: self.second.map(|s| factor * s),
        }
    }

    /// Of the image of the area under `map`, about the origin there; reflections change the sign.
    ///
    /// With `p' = o + L p`: `S' = det L (A o + L S)` and
    /// `J' = det L (A o oᵀ + (L S) oᵀ + o (L S)ᵀ + L J Lᵀ)`.
    fn image(&self, map: &Affine) -> Self {
        let Affine { x: u, y: v, origin: o } = *map;
        let turned = map.vector(self.first);
        let [xx, xy, yy] = self.second;
        let entry = |i: usize, k: usize| {
            let linear = u[i] * u[k] * xx + (u[i] * v[k] + v[i] * u[k]) * xy + v[i] * v[k] * yy;
            linear + turned[i] * o[k] + o[i] * turned[k] + self.area * o[i] * o[k]
        };
        let image = Self {
            area: self.area,
            first: along(scaled(o, self.area), 1.0, turned),
            second: [entry(0, 0), entry(0, 1), entry(1, 1)],
        };
        image.times(map.determinant())
    }
}

/// The area inside a closed path, positive when it runs counter-clockwise.
pub fn signed_area(path: &Path) -> f64 {
    Moments::of_path(path, path.bounds().centre()).area
}

/// The image of a vector of the plane of the unit circle.
fn image(conic: &Conic, unit: Point) -> Point {
    along(scaled(conic.major, unit[0]), unit[1], conic.minor)
}

#[cfg(test)]
mod tests {
    use super::{Affine, Curve, Moments};

    /// The image of the moments is the moments of the image.
    #[test]
    fn moments_move_with_their_area() {
        let curves = |map: &Affine| {
            let arc = Curve::Arc { centre: [0.4, 0.1], radius: 0.7, start: 0.3, sweep: 2.1 };
            let back = Curve::Segment { from: arc.end_point(), to: arc.start_point() };
            [arc, back].map(|curve| Moments::of(&curve.transformed(map)))
        };
        let map = Affine { x: [1.2, -0.4], y: [0.9, 0.8], origin: [-2.0, 0.6] };
        let [arc, back] = curves(&Affine::IDENTITY);
        let moved = arc.plus(back).image(&map);
        let [arc, back] = curves(&map);
        let direct = arc.plus(back);
        assert!((moved.area - direct.area).abs() < 1e-14, "{moved:?} {direct:?}");
        for k in 0..3 {
            assert!((moved.second[k] - direct.second[k]).abs() < 1e-13, "{moved:?} {direct:?}");
        }
    }
}
