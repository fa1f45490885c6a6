//! [`CouplerCurve`]: the way of a point over a whole motion, in points as near to each other as it bends.

use bksim_expr::Expr;

use crate::curve::{Curve, Point};
use crate::error::AnalysisError;
use crate::path::Path;
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::scalar::Scalars;
use crate::trace::Trace;

/// A point of the mechanism as a function of its position.
#[derive(Debug)]
pub(crate) struct Tracer {
    scalars: Scalars,
    /// The unit of lengths, m.
    pub(crate) size: f64,
}

/// The tracer at one pose.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    /// The pose.
    pub(crate) pose: Point,
    /// Where the point is, m.
    pub(crate) p: [f64; 3],
    /// Slope by the arc length of the pose, m.
    pub(crate) slope: [f64; 3],
}

/// The way of a point along one trace.
#[derive(Clone, Debug)]
pub(crate) struct CouplerCurve {
    pub(crate) samples: Vec<Sample>,
    /// True where the point comes back to where it began, and goes on as before.
    pub(crate) is_closed: bool,
    /// How often it goes along the way until the motion comes back; `None` where the motion does not.
    pub(crate) n_laps: Option<usize>,
}

/// Largest angle between the slopes of neighbours, rad.
const BEND: f64 = 0.1;
/// How often a step is halved where the curve bends: at a cusp without end.
const MOST_HALVINGS: u32 = 14;
/// Slopes below this part of the size are of a point at rest.
const AT_REST: f64 = 1e-12;

impl Tracer {
    /// The point with these coordinates.
    pub(crate) fn of(positions: &Positions, at: [Expr; 3]) -> Result<Self, AnalysisError> {
        let quantity =
            |value| PoseQuantity { names: [const { String::new() }; 3], unit: "m", value };
        let scalars = positions.scalars(&at.map(quantity))?;
        Ok(Self { scalars, size: positions.size })
    }

    /// True where the point moves in a pose.
    pub(crate) fn moves(&self, at: &Sample) -> bool {
        length(&at.slope) > AT_REST * self.size
    }

    /// The tracer at a pose.
    pub(crate) fn at(&mut self, curve: &Curve<Path<'_>>, pose: Point) -> Sample {
        let rows = &curve.equations.rows;
        let [q, direction] =
            [&pose.z, &pose.tangent].map(|x| rows.unscaled(&x.as_slice()[..rows.n()]));
        let t = curve.equations.time(0.0);
        let p = self.scalars.values(t, &q);
        let slope = self.scalars.along(t, &q, &direction);
        Sample { pose, p: [p[0], p[1], p[2]], slope: [slope[0], slope[1], slope[2]] }
    }

    /// The pose at the arc length `s` from that of a sample.
    pub(crate) fn beyond(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        from: &Sample,
        s: f64,
    ) -> Option<Sample> {
        let mut z = &from.pose.z + &from.pose.tangent * s;
        curve.correct(&mut z, &from.pose.tangent)?;
        let pose = curve.point(z, &from.pose.tangent)?;
        Some(self.at(curve, pose))
    }

    /// The whole way along a trace, or one lap of it where laps repeat each other.
    pub(crate) fn along(&mut self, curve: &mut Curve<Path<'_>>, trace: &Trace) -> CouplerCurve {
        let mut samples: Vec<Sample> = Vec::new();
        for pose in &trace.points {
            let to = self.at(curve, pose.clone());
            if let Some(from) = samples.last().cloned() {
                self.refine(curve, (from, &to), MOST_HALVINGS, &mut samples);
            }
            samples.push(to);
        }
        let n_laps = trace.is_closed.then_some(1);
        let way = CouplerCurve { samples, is_closed: trace.is_closed, n_laps };
        self.once(curve, way)
    }

    /// Adds what lies between two samples, as near to each other as the curve bends.
    fn refine(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        (from, to): (Sample, &Sample),
        n_halvings: u32,
        samples: &mut Vec<Sample>,
    ) {
        let [a, b] = [length(&from.slope), length(&to.slope)];
        let bend = dot(&from.slope, &to.slope);
        let is_straight = bend >= a * b * BEND.cos() || a.max(b) <= AT_REST * self.size;
        if is_straight || n_halvings == 0 {
            return;
        }
        let whole = from.reach(to);
        let Some(middle) = self.beyond(curve, &from, 0.5 * whole) else { return };
        self.refine(curve, (from, &middle), n_halvings - 1, samples);
        samples.push(middle.clone());
        self.refine(curve, (middle, to), n_halvings - 1, samples);
    }
}

impl Sample {
    /// The arc length to the next sample, along the direction of this one.
    pub(crate) fn reach(&self, to: &Self) -> f64 {
        self.pose.tangent.dot(&(&to.pose.z - &self.pose.z))
    }
}

impl CouplerCurve {
    /// Points of the coupler curve, m.
    pub(crate) fn points(&self) -> Vec<[f64; 3]> {
        self.samples.iter().map(|sample| sample.p).collect()
    }

    /// Length of the way, m.
    pub(crate) fn length(&self) -> f64 {
        self.samples.windows(2).map(|pair| arc(&pair[0], &pair[1])).sum()
    }
}

/// The length of the curve between two samples: that of a cubic with these slopes, by Simpson's rule.
fn arc(from: &Sample, to: &Sample) -> f64 {
    let whole = from.reach(to);
    let middle: [f64; 3] = std::array::from_fn(|i| {
        1.5 * (to.p[i] - from.p[i]) - 0.25 * whole * (from.slope[i] + to.slope[i])
    });
    (whole * (length(&from.slope) + length(&to.slope)) + 4.0 * length(&middle)) / 6.0
}

pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn length(a: &[f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
