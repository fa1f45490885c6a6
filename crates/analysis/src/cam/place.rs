//! [`Place`]: a cam at one angle.

use bksim_expr::{Expr, SymbolId, Tape, TapeError};
use bksim_model::{Cam, CamLaw, Curve, FollowerKind, Model};

/// The functions of a law and its profile.
pub(super) struct Places {
    lift: Function,
    profile: Option<(FollowerKind, Function)>,
    /// Lifts are angles.
    pub(super) is_angle: bool,
    /// The radius of the base circle, m; zero without a profile.
    pub(super) base: f64,
    /// The radius of the roller, m; zero of other followers.
    pub(super) roller: f64,
    /// 1, or −1 of a cam that turns clockwise.
    sense: f64,
}

/// A compiled function, with the values of the model's parameters.
struct Function {
    tape: Tape,
    parameters: Vec<f64>,
}

/// A cam at one angle, in its frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Place {
    kind: FollowerKind,
    /// Of the follower's point, or of the contact with a face, m.
    pub(super) at: [f64; 2],
    /// Unit vector out of the profile.
    pub(super) normal: [f64; 2],
    /// Curvature of the path of the point, or of the profile of a face, 1/m; positive where it is convex.
    pub(super) bend: f64,
    /// Between the normal and the way of the point, rad; positive where the cam lifts.
    pub(super) pressure: f64,
    /// Of a face: from the foot of the perpendicular from the axis, m.
    pub(super) contact: f64,
    roller: f64,
}

impl Places {
    pub(super) fn compile(
        model: &Model,
        law: &CamLaw,
        profile: Option<(&Curve, &Cam)>,
    ) -> Result<Self, TapeError> {
        let pool = &model.pool;
        let value = |e: Expr| {
            let of = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
            pool.evaluate(e, &of).unwrap_or(f64::NAN)
        };
        let derivatives = |e: Expr, by: SymbolId, n: usize| -> Vec<Expr> {
            std::iter::successors(Some(e), |&e| Some(pool.diff(e, by))).take(n + 1).collect()
        };
        let lift = Function::compile(model, &derivatives(law.lift, law.angle, 3), &[law.angle])?;
        let mut places = Self {
            lift,
            profile: None,
            is_angle: law.is_angle,
            base: 0.0,
            roller: 0.0,
            sense: 1.0,
        };
        if let Some((curve, cam)) = profile {
            let by = curve.parameter;
            let [x, y] = [0, 1].map(|axis| derivatives(cam.pitch[axis], by, 2));
            let [u, v] = [0, 1].map(|axis| derivatives(cam.travel[axis], by, 1));
            let outputs = [x[0], y[0], x[1], y[1], x[2], y[2], u[0], v[0], u[1], v[1]];
            let function = Function::compile(model, &outputs, &[by, cam.base])?;
            places.profile = Some((cam.kind, function));
            places.base = value(cam.base_circle);
            places.roller = cam.roller.map_or(0.0, value);
            places.sense = if cam.is_clockwise { -1.0 } else { 1.0 };
        }
        Ok(places)
    }

    pub(super) fn kind(&self) -> Option<FollowerKind> {
        self.profile.as_ref().map(|(kind, _)| *kind)
    }

    /// The lift and its derivatives by the angle.
    pub(super) fn lift(&self, angle: f64) -> [f64; 4] {
        self.lift.at(&[angle])
    }

    /// The profile at an angle.
    pub(super) fn at(&self, angle: f64) -> Option<Place> {
        self.at_base(angle, self.base)
    }

    /// Place with another base circle.
    pub(super) fn at_base(&self, angle: f64, base: f64) -> Option<Place> {
        let (kind, function) = self.profile.as_ref()?;
        let [x, y, dx, dy, ddx, ddy, u, v, du, dv] = function.at(&[angle, base]);
        let roller = self.roller;
        if *kind == FollowerKind::Flat {
            // By the angle of the normal: x′ = ρ φ′ t.
            let [tx, ty] = [-v, u];
            let turning = du * tx + dv * ty;
            let radius = (dx * tx + dy * ty) / turning;
            let contact = -(x * tx + y * ty);
            let (at, normal) = ([x, y], [u, v]);
            return Some(Place {
                kind: *kind,
                at,
                normal,
                bend: 1.0 / radius,
                pressure: 0.0,
                contact,
                roller,
            });
        }
        let speed = dx.hypot(dy);
        let [tx, ty] = [dx / speed, dy / speed];
        let normal = [-self.sense * ty, self.sense * tx];
        let bend = -self.sense * (dx * ddy - dy * ddx) / speed.powi(3);
        let pressure = (tx * u + ty * v).atan2(normal[0] * u + normal[1] * v);
        Some(Place { kind: *kind, at: [x, y], normal, bend, pressure, contact: 0.0, roller })
    }
}

impl Function {
    fn compile(model: &Model, outputs: &[Expr], inputs: &[SymbolId]) -> Result<Self, TapeError> {
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let tape = Tape::compile(&model.pool, outputs, inputs, &symbols)?;
        Ok(Self { tape, parameters: model.parameters.iter().map(|p| p.value).collect() })
    }

    fn at<const N: usize>(&self, inputs: &[f64]) -> [f64; N] {
        let mut out = [0.0; N];
        self.tape.evaluate(&mut self.tape.workspace(&self.parameters), inputs, &mut out);
        out
    }
}

impl Place {
    /// A point at a distance outside of the follower's point.
    fn moved(&self, distance: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.at[axis] + distance * self.normal[axis])
    }

    /// The point of the profile, m.
    pub(super) fn profile(&self) -> [f64; 2] {
        self.moved(-self.roller)
    }

    /// The centre of a circle that touches the profile from outside, m.
    pub(super) fn outside(&self, radius: f64) -> [f64; 2] {
        self.moved(radius - self.roller)
    }

    /// Radius of curvature of the profile, m; positive where it is convex.
    pub(super) fn radius(&self) -> f64 {
        1.0 / self.bend - self.roller
    }

    /// Positive where the profile is not undercut: m of a face, a pure number of a roller.
    pub(super) fn margin(&self) -> f64 {
        match self.kind {
            FollowerKind::Flat => 1.0 / self.bend,
            FollowerKind::Knife | FollowerKind::Roller => 1.0 - self.roller * self.bend,
        }
    }
}
