//! Rational B-splines: made from the numbers of a file, cut into Bézier pieces.
//!
//! A piece between two knots is found by its polar form (blossom): the i-th Bézier point of the
//! span `[a, b]` is `f(a, …, a, b, …, b)` with `i` times `b` (Ramshaw 1989; Piegl & Tiller, The
//! NURBS Book, chapter 5).

use super::bezier::{Bezier, Homogeneous, mix, projected};
use super::error::{MAX_DEGREE, check_points};
use super::vector::{along, distance, scaled, sub};
use super::{GeometryError, Point, Spline};

impl Spline {
    /// A spline as DXF states it; no weights mean weights of one.
    ///
    /// Knots may be clamped or not: the curve runs from `knots[degree]` to `knots[control.len()]`.
    ///
    /// # Errors
    /// Whatever [`Spline::check`] finds.
    pub fn new(
        degree: usize,
        knots: Vec<f64>,
        control: Vec<Point>,
        weights: Vec<f64>,
    ) -> Result<Self, GeometryError> {
        let weights = if weights.is_empty() { vec![1.0; control.len()] } else { weights };
        let spline = Self { degree, knots, control, weights };
        spline.check()?;
        Ok(spline)
    }

    /// The cubic spline through points, for files that state nothing else.
    ///
    /// Twice continuously differentiable over the chord lengths; an end without a stated tangent
    /// has no curvature (a natural spline). Only the direction of a tangent counts. Points that
    /// repeat are taken once.
    ///
    /// # Errors
    /// [`GeometryError`] for numbers that are none, or fewer than two different points.
    pub fn through(points: &[Point], tangents: [Option<Point>; 2]) -> Result<Self, GeometryError> {
        check_points(points.iter().copied())?;
        check_points(tangents.into_iter().flatten())?;
        let mut fit = points.to_vec();
        fit.dedup();
        if fit.len() < 2 {
            return Err(GeometryError::Points { found: fit.len(), needed: 2 });
        }
        let chords: Vec<f64> = fit.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
        let slopes = slopes(&fit, &chords, tangents.map(|t| t.and_then(unit)));

        // Each stretch is a Bézier piece; its inner points follow from the slopes at its ends.
        let (mut control, mut knots) = (vec![fit[0]], vec![0.0; 4]);
        let mut at = 0.0;
        for (i, &h) in chords.iter().enumerate() {
            control.push(along(fit[i], h / 3.0, slopes[i]));
            control.push(along(fit[i + 1], -h / 3.0, slopes[i + 1]));
            control.push(fit[i + 1]);
            at += h;
            knots.extend([at; 3]);
        }
        knots.push(at);
        Self::new(3, knots, control, Vec::new())
    }

    /// Curve from its other end.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut turned = self.clone();
        turned.control.reverse();
        turned.weights.reverse();
        if let (Some(first), Some(last)) = (self.knots.first(), self.knots.last()) {
            turned.knots = self.knots.iter().rev().map(|knot| first + (last - knot)).collect();
        }
        turned
    }

    /// Point at `t` in 0 to 1 along the parameter; not a number for numbers that make no spline.
    pub fn point(&self, t: f64) -> Point {
        if !self.is_counted() {
            return [f64::NAN; 2];
        }
        let (degree, n) = (self.degree, self.control.len());
        let u = (1.0 - t) * self.knots[degree] + t * self.knots[n];
        // The last span that begins at or before u and is not empty.
        let span = self.knots[degree..n].partition_point(|knot| *knot <= u).max(1) + degree - 1;
        let span = (degree..=span).rev().find(|&k| self.knots[k] < self.knots[k + 1]);
        projected(self.blossom(span.unwrap_or(degree), &vec![u; degree]))
    }

    /// The Bézier pieces in order; none for numbers that make no spline.
    pub(crate) fn pieces(&self) -> Vec<Bezier> {
        if !self.is_counted() {
            return Vec::new();
        }
        let spans = (self.degree..self.control.len())
            .filter(|&k| self.knots[k] < self.knots[k + 1])
            .map(|k| self.piece(k));
        spans.collect()
    }

    fn piece(&self, span: usize) -> Bezier {
        let (a, b) = (self.knots[span], self.knots[span + 1]);
        let mut arguments = vec![a; self.degree];
        let mut points = vec![self.blossom(span, &arguments)];
        for i in 0..self.degree {
            arguments[i] = b;
            points.push(self.blossom(span, &arguments));
        }
        Bezier { points }
    }

    /// The polar form of the span that begins at knot `span`, by de Boor with one argument a level.
    fn blossom(&self, span: usize, arguments: &[f64]) -> Homogeneous {
        let (p, t) = (self.degree, &self.knots);
        let mut d: Vec<Homogeneous> = (span - p..=span)
            .map(|i| {
                let (w, [x, y]) = (self.weights[i], self.control[i]);
                [w * x, w * y, w]
            })
            .collect();
        for (level, u) in (1..=p).zip(arguments) {
            for j in (level..=p).rev() {
                let i = span - p + j;
                let share = (u - t[i]) / (t[i + p - level + 1] - t[i]);
                d[j] = mix(d[j - 1], d[j], share);
            }
        }
        d[p]
    }

    /// True if knots, points and weights are as many as they must be.
    fn is_counted(&self) -> bool {
        let n = self.control.len();
        (1..=MAX_DEGREE).contains(&self.degree)
            && n > self.degree
            && self.knots.len() == n + self.degree + 1
            && self.weights.len() == n
    }
}

fn unit(v: Point) -> Option<Point> {
    let length = distance(v, [0.0; 2]);
    (length > 0.0).then(|| scaled(v, 1.0 / length))
}

/// Slopes `m` at the points: the curvature is continuous at inner points,
///
/// ```text
/// m_{i−1}/h_{i−1} + 2 (1/h_{i−1} + 1/h_i) m_i + m_{i+1}/h_i
///     = 3 (p_i − p_{i−1})/h_{i−1}² + 3 (p_{i+1} − p_i)/h_i²
/// ```
///
/// and zero at an end without tangent, `2 m_0 + m_1 = 3 (p_1 − p_0)/h_0` (de Boor, A Practical
/// Guide to Splines, chapter IV). Solved by elimination without pivoting: rows are dominant.
fn slopes(fit: &[Point], chords: &[f64], tangents: [Option<Point>; 2]) -> Vec<Point> {
    let last = fit.len() - 1;
    let mut diagonal = vec![1.0; last + 1];
    let mut upper = vec![0.0; last + 1];
    let mut lower = vec![0.0; last + 1];
    let mut m = vec![[0.0; 2]; last + 1];
    for i in 0..=last {
        let secant = |k: usize| scaled(sub(fit[k + 1], fit[k]), 3.0 / chords[k]);
        let end = if i == 0 { Some(0) } else { (i == last).then_some(1) };
        match end.map(|end| (end, tangents[end])) {
            Some((_, Some(tangent))) => m[i] = tangent,
            Some((0, None)) => (diagonal[0], upper[0], m[0]) = (2.0, 1.0, secant(0)),
            Some((_, None)) => {
                (diagonal[last], lower[last], m[last]) = (2.0, 1.0, secant(last - 1));
            }
            None => {
                let (a, b) = (1.0 / chords[i - 1], 1.0 / chords[i]);
                (lower[i], diagonal[i], upper[i]) = (a, 2.0 * (a + b), b);
                m[i] = along(scaled(secant(i - 1), a), b, secant(i));
            }
        }
    }
    for i in 1..=last {
        let factor = lower[i] / diagonal[i - 1];
        diagonal[i] -= factor * upper[i - 1];
        m[i] = along(m[i], -factor, m[i - 1]);
    }
    m[last] = scaled(m[last], 1.0 / diagonal[last]);
    for i in (0..last).rev() {
        m[i] = scaled(along(m[i], -upper[i], m[i + 1]), 1.0 / diagonal[i]);
    }
    m
}
