//! A hand that pulls at a body of a running motion: a spring and a damper to a place that inputs state.

use bksim_expr::{Expr, Number};
use bksim_model::{
    Anchor, Axis, Body, BodyId, Load, LoadKind, Measure, Model, Parameter, Point, PointId, Signal,
    Space, Vector,
};

/// How often a second the mechanism would swing on the hand, as if all of its mass were there, rad/s.
const SLOWEST: f64 = 12.0;
/// Part of the mechanism's size by which its own weight may draw it out of the hand.
const SAG: f64 = 0.02;
/// Standard free fall, m/s².
const FREE_FALL: f64 = 9.81;

/// Where a hand pulls: a point in the frame of a body, m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Hold {
    pub(crate) body: BodyId,
    pub(crate) point: [f64; 3],
}

/// A hand with its inputs: three places, stiffness and damping.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Hand {
    pub(crate) hold: Hold,
    inputs: [String; 5],
    stiffness: f64,
    damping: f64,
}

impl Hand {
    /// Adds a hand to a model of this size, m; it pulls only once it is closed.
    pub(crate) fn of(model: &mut Model, hold: Hold, size: f64) -> Self {
        let mass = total_mass(model);
        let square = (SLOWEST * SLOWEST).max(FREE_FALL / (SAG * size));
        let inputs =
            [("x", "m"), ("y", "m"), ("z", "m"), ("stiffness", "N/m"), ("damping", "N s/m")]
                .map(|(name, unit)| input(model, &format!("hand {name}"), unit));
        let place = [0, 1, 2].map(|i| inputs[i].1);
        let [stiffness, damping] = [3, 4].map(|i| inputs[i].1);

        let point = PointId(model.bodies[hold.body.0].points.len());
        let at = hold.point.map(|x| number(model, x));
        let named = Point { name: "hand".to_owned(), position: at, orientation: Vec::new() };
        model.bodies[hold.body.0].points.push(named);
        let mut vector: Vector = [number(model, 0.0); 3];
        let n_axes = if model.space == Space::Planar { 2 } else { 3 };
        for (i, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate().take(n_axes) {
            let at = signal(model, Measure::PointPosition(hold.body, Some(point), axis));
            let rate = signal(model, Measure::PointVelocity(hold.body, Some(point), axis));
            let pool = &model.pool;
            let pull = pool.mul(stiffness, pool.sub(place[i], at));
            vector[i] = pool.sub(pull, pool.mul(damping, rate));
        }
        let on = Anchor { body: hold.body, point: Some(point) };
        let kind = LoadKind::Force { on, vector, follows_body: false };
        model.loads.push(Load { name: "hand".to_owned(), kind, span: 0..0 });
        Self {
            hold,
            inputs: inputs.map(|(name, _)| name),
            stiffness: mass * square,
            damping: 2.0 * mass * square.sqrt(),
        }
    }

    /// Values of the inputs while the hand is at a place of the world, or open.
    pub(crate) fn values(&self, at: Option<[f64; 3]>) -> [(&str, f64); 5] {
        let [x, y, z] = at.unwrap_or_default();
        let is_closed = f64::from(u8::from(at.is_some()));
        let values = [x, y, z, is_closed * self.stiffness, is_closed * self.damping];
        std::array::from_fn(|i| (self.inputs[i].as_str(), values[i]))
    }
}

fn number(model: &Model, x: f64) -> Expr {
    model.pool.number(Number::float(x))
}

/// A parameter that is zero at first, by a name that no text can have.
fn input(model: &mut Model, name: &str, unit: &str) -> (String, Expr) {
    let symbol = model.pool.symbol(name);
    let definition = number(model, 0.0);
    if let Some(id) = model.pool.symbol_id(symbol) {
        let (name, unit) = (name.to_owned(), unit.to_owned());
        let parameter = Parameter { name, symbol: id, definition, value: 0.0, unit, span: 0..0 };
        model.parameters.push(parameter);
    }
    (name.to_owned(), symbol)
}

/// The symbol of a measure, which the model gets where it has none.
fn signal(model: &mut Model, measure: Measure) -> Expr {
    let symbol = model.pool.symbol(&format!("hand {measure:?}"));
    if let Some(id) = model.pool.symbol_id(symbol) {
        model.signals.push(Signal { symbol: id, measure });
    }
    symbol
}

/// The mass of all bodies, kg.
fn total_mass(model: &Model) -> f64 {
    let value = |symbol| {
        let own = model.parameters.iter().find(|parameter| parameter.symbol == symbol);
        own.map(|parameter| parameter.value)
    };
    let of_body = |body: &Body| model.pool.evaluate(body.mass, &value).unwrap_or(0.0);
    model.bodies.iter().map(of_body).sum()
}
