//! The way of a belt around wheels in a plane, in numbers.

use std::f64::consts::TAU;

/// A way around wheels, closed in itself.
#[derive(Clone, PartialEq, Debug)]
pub struct Way {
    /// From each wheel to the next: where the belt leaves the one and comes to the other, m.
    pub strands: Vec<[[f64; 2]; 2]>,
    /// The angle around each wheel from the strand before it, 0 … 2π, rad.
    pub wraps: Vec<f64>,
}

/// The strand to which there is no tangent: from the wheel of this number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NoStrand(pub usize);

/// The free part of a belt or rope between two wheels.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FreeSpan {
    /// Direction of the span, a unit vector.
    pub direction: [f64; 2],
    /// Where it leaves the one and comes to the other, m.
    pub touching: [[f64; 2]; 2],
}

/// The free span from one wheel to the next, with their centres and radii, m: radii below zero where it turns right;
/// `None` where there is no tangent.
pub fn span_between(
    (from, first): ([f64; 2], f64),
    (to, second): ([f64; 2], f64),
) -> Option<FreeSpan> {
    let ([x, y], delta) = ([to[0] - from[0], to[1] - from[1]], second - first);
    let square = x * x + y * y;
    let length = (square - delta * delta).sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    let e = [(length * x + delta * y) / square, (length * y - delta * x) / square];
    let touching = |c: [f64; 2], r: f64| [c[0] + r * e[1], c[1] - r * e[0]];
    Some(FreeSpan { direction: e, touching: [touching(from, first), touching(to, second)] })
}

impl Way {
    /// The way around wheels with these centres and radii, m: radii below zero where it turns right.
    ///
    /// # Errors
    /// [`NoStrand`] where two wheels that follow each other leave no way between them.
    pub fn around(wheels: &[([f64; 2], f64)]) -> Result<Self, NoStrand> {
        let n = wheels.len();
        let mut strands = Vec::with_capacity(n);
        let mut directions = Vec::with_capacity(n);
        for k in 0..n {
            let span = span_between(wheels[k], wheels[(k + 1) % n]).ok_or(NoStrand(k))?;
            strands.push(span.touching);
            directions.push(span.direction);
        }
        let wrap = |k: usize| {
            let ([ax, ay], [bx, by]) = (directions[(k + n - 1) % n], directions[k]);
            let turn = (ax * by - ay * bx).atan2(ax * bx + ay * by);
            (wheels[k].1.signum() * turn).rem_euclid(TAU)
        };
        let wraps = (0..n).map(wrap).collect();
        Ok(Self { strands, wraps })
    }

    /// Length of the way around these wheels, m.
    pub fn length(&self, wheels: &[([f64; 2], f64)]) -> f64 {
        let strands = self.strands.iter().map(|[a, b]| (b[0] - a[0]).hypot(b[1] - a[1]));
        let arcs = self.wraps.iter().zip(wheels).map(|(wrap, wheel)| wrap * wheel.1.abs());
        strands.chain(arcs).sum()
    }

    /// Turns of the belt to the left while it goes around once.
    pub fn turns(&self, wheels: &[([f64; 2], f64)]) -> f64 {
        let turns = self.wraps.iter().zip(wheels).map(|(wrap, wheel)| wrap * wheel.1.signum());
        turns.sum::<f64>() / TAU
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_belt_around_two_wheels_has_the_length_of_the_textbook() {
        // Open: 2 s + r₁ (π − 2 β) + r₂ (π + 2 β) with sin β = (r₂ − r₁)/C; crossed: the sum instead.
        let (first, second, distance) = (0.05, 0.12, 0.5_f64);
        for (sign, turns) in [(1.0, 1.0), (-1.0, 0.0)] {
            let wheels = [([0.0, 0.0], first), ([distance, 0.0], sign * second)];
            let way = Way::around(&wheels).expect("a way");
            let beta = ((second - sign * first) / distance).asin();
            let strand = 2.0 * distance * beta.cos();
            let expected = strand + second * (PI + 2.0 * beta) + first * (PI - sign * 2.0 * beta);
            assert!((way.length(&wheels) - expected).abs() < 1e-14, "{sign}");
            assert!((way.turns(&wheels) - turns).abs() < 1e-14, "{sign}");
        }
        let within = [([0.0, 0.0], 0.3), ([0.1, 0.0], 0.1)];
        assert_eq!(Way::around(&within), Err(NoStrand(0)));
    }
}
