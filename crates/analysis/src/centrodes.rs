//! Instant centres of pairs of bodies, and the curves that they draw in both: fixed and moving centrode.
//!
//! ```text
//! v(P) = v₀ + ω × P of either body, so at the centre
//! P = (−Δv₀ʸ, Δv₀ˣ) / Δω
//! ```
//!
//! Rates are by the arc length of the motion, so that no drive is needed. Source: J. J. Uicker, G. R. Pennock
//! and J. E. Shigley, *Theory of Machines and Mechanisms* (2017), §3.12–3.21.

use bksim_model::{Anchor, BodyId, Measure};

use crate::curve::{Curve, Point};
use crate::error::AnalysisError;
use crate::path::Path;
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::scalar::Scalars;
use crate::trace::Trace;

/// The instant centre of two bodies in the pose of the start.
#[derive(Clone, PartialEq, Debug)]
pub struct InstantCentre {
    /// Names of the bodies.
    pub bodies: [String; 2],
    /// Where both have one velocity.
    pub place: CentrePlace,
}

/// Where an instant centre is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum CentrePlace {
    /// At this point, m.
    At([f64; 2]),
    /// At infinity, in this direction: the bodies do not turn against each other.
    Towards([f64; 2]),
    /// Everywhere: they do not move against each other.
    Everywhere,
}

/// The curves of an instant centre over the whole motion; those of the moving body roll on those of the other.
#[derive(Clone, PartialEq, Debug)]
pub struct Centrodes {
    /// The body taken as fixed, then the moving one.
    pub bodies: [String; 2],
    /// Number of the branch, from one.
    pub branch: usize,
    /// The curve in the frame of the fixed body, m, in pieces between infinity and infinity.
    pub fixed: Vec<Vec<[f64; 2]>>,
    /// Centrodes in the frame of the moving body, point by point.
    pub moving: Vec<Vec<[f64; 2]>>,
}

/// Centres farther from both bodies than so many longest links are left out of centrodes: these go to infinity, and
/// in a picture of all that is left the mechanism can still be seen.
const FAR: f64 = 2.0;
/// Relative rates below this are none.
const NO_RATE: f64 = 1e-10;

/// Poses and rates of all bodies.
#[derive(Debug)]
pub(crate) struct BodyRates {
    scalars: Scalars,
    names: Vec<String>,
    size: f64,
}

/// Origin and angle of the frame of a body with their slopes by the arc length.
#[derive(Clone, Copy, Debug)]
struct BodyRate {
    at: [f64; 3],
    slope: [f64; 3],
}

impl BodyRates {
    pub(crate) fn of(positions: &Positions) -> Result<Self, AnalysisError> {
        let model = positions.model();
        let kinematics = &positions.system().kinematics;
        let of_body = |id: usize| {
            let [x, y, _] = kinematics.anchor(model, Anchor { body: BodyId(id), point: None });
            [x, y, kinematics.measure(model, Measure::BodyAngle(BodyId(id)))]
        };
        let quantity =
            |value| PoseQuantity { names: [const { String::new() }; 3], unit: "", value };
        let all: Vec<PoseQuantity> =
            (1..model.bodies.len()).flat_map(of_body).map(quantity).collect();
        Ok(Self {
            scalars: positions.scalars(&all)?,
            names: model.bodies.iter().map(|body| body.name.clone()).collect(),
            size: positions.size,
        })
    }

    fn at(&mut self, curve: &Curve<Path<'_>>, point: &Point) -> Vec<BodyRate> {
        let rows = &curve.equations.rows;
        let [q, direction] =
            [&point.z, &point.tangent].map(|x| rows.unscaled(&x.as_slice()[..rows.n()]));
        let t = curve.equations.time(0.0);
        let values = self.scalars.values(t, &q);
        let slopes = self.scalars.along(t, &q, &direction);
        let ground = BodyRate { at: [0.0; 3], slope: [0.0; 3] };
        let three = |all: &[f64]| [all[0], all[1], all[2]];
        let moving = values.chunks(3).zip(slopes.chunks(3));
        let moving = moving.map(|(at, slope)| BodyRate { at: three(at), slope: three(slope) });
        std::iter::once(ground).chain(moving).collect()
    }

    /// The map from the frame of a body to the world at a pose.
    pub(crate) fn pose(
        &mut self,
        curve: &Curve<Path<'_>>,
        point: &Point,
        body: BodyId,
    ) -> impl Fn([f64; 2]) -> [f64; 2] + use<> {
        let [x0, y0, angle] = self.at(curve, point)[body.0].at;
        let (sin, cos) = angle.sin_cos();
        move |[x, y]| [x0 + cos * x - sin * y, y0 + sin * x + cos * y]
    }

    /// The centres of all pairs of bodies at a pose.
    pub(crate) fn centres(&mut self, curve: &Curve<Path<'_>>, point: &Point) -> Vec<InstantCentre> {
        let rates = self.at(curve, point);
        let mut all = Vec::new();
        for i in 0..rates.len() {
            for j in i + 1..rates.len() {
                let bodies = [self.names[i].clone(), self.names[j].clone()];
                all.push(InstantCentre { bodies, place: self.centre(rates[i], rates[j]) });
            }
        }
        all
    }

    fn centre(&self, a: BodyRate, b: BodyRate) -> CentrePlace {
        let (va, vb) = (a.at_origin(), b.at_origin());
        let (dv, dw) = ([vb[0] - va[0], vb[1] - va[1]], b.slope[2] - a.slope[2]);
        let speed = dv[0].hypot(dv[1]);
        if dw.abs() > NO_RATE {
            return CentrePlace::At([-dv[1] / dw, dv[0] / dw]);
        }
        if speed > NO_RATE * self.size {
            return CentrePlace::Towards([-dv[1] / speed, dv[0] / speed]);
        }
        CentrePlace::Everywhere
    }

    /// The centrodes of two bodies along a trace.
    pub(crate) fn centrodes(
        &mut self,
        curve: &Curve<Path<'_>>,
        (branch, trace): (usize, &Trace),
        [fixed, moving]: [BodyId; 2],
    ) -> Centrodes {
        let bodies = [fixed, moving].map(|id| self.names[id.0].clone());
        let mut found = Centrodes { bodies, branch, fixed: Vec::new(), moving: Vec::new() };
        let mut last: Option<[f64; 2]> = None;
        for point in &trace.points {
            let rates = self.at(curve, point);
            let (a, b) = (rates[fixed.0], rates[moving.0]);
            let near = match self.centre(a, b) {
                CentrePlace::At(p) => {
                    Some(p).filter(|&p| a.distance(p).min(b.distance(p)) < FAR * self.size)
                }
                _ => None,
            };
            let Some(p) = near else {
                last = None;
                continue;
            };
            // What jumps went through infinity in between.
            let is_new = last.is_none_or(|last| (p[0] - last[0]).hypot(p[1] - last[1]) > self.size);
            if is_new {
                found.fixed.push(Vec::new());
                found.moving.push(Vec::new());
            }
            last = Some(p);
            for (pieces, body) in [(&mut found.fixed, a), (&mut found.moving, b)] {
                if let Some(piece) = pieces.last_mut() {
                    piece.push(body.in_frame(p));
                }
            }
        }
        // A single point is no curve.
        found.fixed.retain(|piece| piece.len() > 1);
        found.moving.retain(|piece| piece.len() > 1);
        found
    }
}

impl BodyRate {
    /// Distance of a point of the world from the origin of the body.
    fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        (x - self.at[0]).hypot(y - self.at[1])
    }

    /// Velocity of the point of the body that is at the origin of the world.
    fn at_origin(&self) -> [f64; 2] {
        let [x, y, _] = self.at;
        let [vx, vy, w] = self.slope;
        [vx + w * y, vy - w * x]
    }

    /// A point of the world in the frame of the body.
    fn in_frame(&self, p: [f64; 2]) -> [f64; 2] {
        let [x, y, angle] = self.at;
        let (sin, cos) = angle.sin_cos();
        let (dx, dy) = (p[0] - x, p[1] - y);
        [cos * dx + sin * dy, -sin * dx + cos * dy]
    }
}
