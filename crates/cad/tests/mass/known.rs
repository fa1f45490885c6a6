//! Area properties from textbook formulas, put together by the parallel-axis theorem.

use bksim_cad::geometry::Point;
use bksim_cad::mass::AreaProperties;

/// Moments about the origin: area, ∫x, ∫y, ∫x², ∫xy, ∫y²; and the perimeter, stated apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    moments: [f64; 6],
    pub(crate) perimeter: f64,
}

impl Known {
    /// From area, centroid, and second moments ∫x², ∫xy, ∫y² about the centroid.
    pub(crate) fn about_centroid(area: f64, [x, y]: Point, [xx, xy, yy]: [f64; 3]) -> Self {
        let moments =
            [area, area * x, area * y, xx + area * x * x, xy + area * x * y, yy + area * y * y];
        Self { moments, perimeter: 0.0 }
    }

    pub(crate) fn rectangle(centre: Point, w: f64, h: f64) -> Self {
        Self::about_centroid(w * h, centre, [h * w.powi(3) / 12.0, 0.0, w * h.powi(3) / 12.0])
    }

    /// The second moment of a triangle is that of a twelfth of its area at each corner.
    pub(crate) fn triangle(corners: [Point; 3]) -> Self {
        let [[x0, y0], [x1, y1], [x2, y2]] = corners;
        let area = 0.5 * ((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)).abs();
        let centroid = [(x0 + x1 + x2) / 3.0, (y0 + y1 + y2) / 3.0];
        let sum = |i: usize, k: usize| {
            let each = |p: Point| (p[i] - centroid[i]) * (p[k] - centroid[k]);
            area / 12.0 * corners.into_iter().map(each).sum::<f64>()
        };
        Self::about_centroid(area, centroid, [sum(0, 0), sum(0, 1), sum(1, 1)])
    }

    pub(crate) fn disc(centre: Point, r: f64) -> Self {
        Self::ellipse(centre, r, r, 0.0)
    }

    /// Half axes `a` at `angle` and `b` across.
    pub(crate) fn ellipse(centre: Point, a: f64, b: f64, angle: f64) -> Self {
        let pi = std::f64::consts::PI;
        let (along, across) = (pi / 4.0 * a.powi(3) * b, pi / 4.0 * a * b.powi(3));
        Self::about_centroid(pi * a * b, centre, turned([along, 0.0, across], angle))
    }

    /// Half the ellipse, on the side of `a`; by affine image of the half disc.
    pub(crate) fn half_ellipse(centre: Point, a: f64, b: f64, angle: f64) -> Self {
        let pi = std::f64::consts::PI;
        let out = 4.0 * a / (3.0 * pi);
        let area = pi / 2.0 * a * b;
        let along = pi / 8.0 * a.powi(3) * b - area * out * out;
        let (sin, cos) = angle.sin_cos();
        let centroid = [centre[0] + out * cos, centre[1] + out * sin];
        let second = turned([along, 0.0, pi / 8.0 * a * b.powi(3)], angle);
        Self::about_centroid(area, centroid, second)
    }

    /// Half angle `a`, symmetric about `angle`.
    pub(crate) fn sector(centre: Point, r: f64, a: f64, angle: f64) -> Self {
        let sc = a.sin() * a.cos();
        let second = [r.powi(4) / 4.0 * (a + sc), 0.0, r.powi(4) / 4.0 * (a - sc)];
        Self::symmetric(centre, a * r * r, 2.0 * r * a.sin() / (3.0 * a), second, angle)
    }

    /// Between arc and chord; half angle `a`, symmetric about `angle`.
    pub(crate) fn segment(centre: Point, r: f64, a: f64, angle: f64) -> Self {
        let (s3c, lens) = (a.sin().powi(3) * a.cos(), a - a.sin() * a.cos());
        let (along, across) = (lens + 2.0 * s3c, lens - 2.0 / 3.0 * s3c);
        let second = [along, 0.0, across].map(|m| r.powi(4) / 4.0 * m);
        let out = 2.0 * r * a.sin().powi(3) / (3.0 * lens);
        Self::symmetric(centre, r * r * lens, out, second, angle)
    }

    /// From second moments about `centre` in axes along `angle`, the centroid `out` that way.
    fn symmetric(centre: Point, area: f64, out: f64, second: [f64; 3], angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let centroid = [centre[0] + out * cos, centre[1] + out * sin];
        let about = [second[0] - area * out * out, second[1], second[2]];
        Self::about_centroid(area, centroid, turned(about, angle))
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        self.combined(other, 1.0)
    }

    pub(crate) fn minus(self, other: Self) -> Self {
        self.combined(other, -1.0)
    }

    fn combined(mut self, other: Self, sign: f64) -> Self {
        for k in 0..6 {
            self.moments[k] += sign * other.moments[k];
        }
        self
    }

    pub(crate) fn with_perimeter(self, perimeter: f64) -> Self {
        Self { perimeter, ..self }
    }

    pub(crate) fn properties(&self) -> AreaProperties {
        let [area, x, y, xx, xy, yy] = self.moments;
        let (ixx, iyy) = (yy - y * y / area, xx - x * x / area);
        AreaProperties {
            area,
            perimeter: self.perimeter,
            centroid: [x / area, y / area],
            ixx,
            iyy,
            ixy: xy - x * y / area,
            polar: ixx + iyy,
        }
    }
}

/// Second moments in axes turned back by `angle`.
pub(crate) fn turned([xx, xy, yy]: [f64; 3], angle: f64) -> [f64; 3] {
    let (s, c) = angle.sin_cos();
    [
        c * c * xx - 2.0 * s * c * xy + s * s * yy,
        s * c * (xx - yy) + (c * c - s * s) * xy,
        s * s * xx + 2.0 * s * c * xy + c * c * yy,
    ]
}

/// Compares all properties: each relative to itself, centroids relative to the size of the outline
/// and where it is, second moments relative to the polar one.
pub(crate) fn assert_near(
    name: &str,
    found: &AreaProperties,
    known: &AreaProperties,
    tolerance: f64,
) {
    let size = known.area.sqrt();
    let distance = known.centroid[0].abs().max(known.centroid[1].abs());
    let rows = [
        ("area", found.area, known.area, known.area),
        ("perimeter", found.perimeter, known.perimeter, known.perimeter),
        ("centroid x", found.centroid[0], known.centroid[0], size.max(distance)),
        ("centroid y", found.centroid[1], known.centroid[1], size.max(distance)),
        ("ixx", found.ixx, known.ixx, known.polar),
        ("iyy", found.iyy, known.iyy, known.polar),
        ("ixy", found.ixy, known.ixy, known.polar),
        ("polar", found.polar, known.polar, known.polar),
    ];
    for (what, found, known, scale) in rows {
        let error = (found - known).abs() / scale;
        assert!(error <= tolerance, "{name}: {what} is {found}, not {known}; off by {error:.1e}");
    }
}
