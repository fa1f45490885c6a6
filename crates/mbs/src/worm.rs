//! Worms: where their threads press on the teeth of a wheel, and in which directions.
//!
//! ```text
//! d = w (c₂ − c₁)·w/w·w             from the axis of the worm to that of the wheel, w = n₁ × n₂
//! p = c₁ + … + r₁ d/|d|             the pitch point
//! u = n₁ × r₁ d/|d| + i n₂ × r₂ d/|d|   sliding there for a unit rate of the worm, i the ratio
//! T = e/e·g, e = d × u              across the threads, 1 along the pitch circle of the wheel, g
//! ```
//!
//! Without friction the normal force is T/cos α with the part |T| tan α along d. Source: J. E. Shigley, *Mechanical
//! Engineering Design*, worm gearing.

use bksim_expr::{Expr, Pool};

use crate::folding::short;
use crate::force::Wrench;
use crate::kinematics::Kinematics;
use crate::spatial;
use bksim_model::{BodyId, Model, Vector, Wheels};

/// The place of a worm and its wheel where they press, in the axes of the ground.
pub struct Worm {
    at: Vector,
    /// T, on the wheel for a unit force along its pitch circle.
    along: Vector,
    /// Unit vector from the worm to the wheel.
    pub(crate) apart: Vector,
    /// u of the worm against the wheel, m.
    pub(crate) sliding: Vector,
    /// Distance of the axes, m.
    pub distance: Expr,
    /// Cosine of the axes' angle.
    pub cosine: Expr,
}

impl Worm {
    /// The worm of a pair of gears; `None` of others, and of axes that are parallel by form.
    pub fn of(model: &Model, kinematics: &Kinematics, wheels: &Wheels) -> Option<Self> {
        let pool = &model.pool;
        let (worm, [_, wheel]) = (wheels.worm?, wheels.radii?);
        let [first, second] = wheels.axes.map(|joint| kinematics.axis_of(model, joint));
        let across = spatial::cross(pool, &first, &second);
        let square = short(pool, spatial::dot(pool, &across, &across));
        if pool.is_zero(square) {
            return None;
        }
        let [from, to] = wheels.wheels.map(|wheel| kinematics.anchor(model, wheel));
        let line = spatial::sub(pool, &to, &from);
        let length = pool.sqrt(square);
        let way = pool.div(short(pool, spatial::dot(pool, &line, &across)), length);
        let distance = pool.sqrt(pool.powi(way, 2));
        let sense = pool.div(way, pool.mul(distance, length));
        let apart = spatial::scale(pool, sense, &across);
        // The foot of the common perpendicular on the axis of the worm.
        let turned = spatial::cross(pool, &line, &second);
        let foot = pool.div(short(pool, spatial::dot(pool, &turned, &across)), square);
        let at = spatial::add(pool, &from, &spatial::scale(pool, foot, &first));
        let at = spatial::add(pool, &at, &spatial::scale(pool, worm.radius, &apart));

        let circle = spatial::neg(pool, &spatial::cross(pool, &second, &apart));
        let of_wheel = spatial::scale(pool, pool.mul(wheels.ratio, wheel), &circle);
        let of_worm = spatial::scale(pool, worm.radius, &spatial::cross(pool, &first, &apart));
        let sliding = spatial::sub(pool, &of_worm, &of_wheel);
        let across_threads = spatial::cross(pool, &apart, &sliding);
        let part = short(pool, spatial::dot(pool, &across_threads, &circle));
        Some(Self {
            at,
            along: spatial::scale(pool, pool.div(pool.one(), part), &across_threads),
            apart,
            sliding,
            distance,
            cosine: spatial::dot(pool, &first, &second),
        })
    }

    /// The wrenches of a unit force along the pitch circle of the wheel.
    pub(crate) fn pair(&self, pool: &Pool, wheels: &Wheels) -> Vec<Wrench> {
        self.push(pool, wheels, self.along)
    }

    /// A force on the wheel at the pitch point, and the opposite on the worm.
    pub(crate) fn push(&self, pool: &Pool, wheels: &Wheels, force: Vector) -> Vec<Wrench> {
        let [worm, wheel] = wheels.wheels.map(|wheel| wheel.body);
        let moment = spatial::zero(pool);
        let on = |body: BodyId, force: Vector| Wrench { body, force, at: self.at, moment };
        vec![on(wheel, force), on(worm, spatial::neg(pool, &force))]
    }
}
