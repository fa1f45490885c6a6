//! Numbers without what rounding left of them.

use toml_edit::Value;

use crate::geometry::Point;

/// A few roundings of numbers around one.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A unit vector along another; along x where the other has no direction.
pub(super) fn direction([x, y]: Point) -> Point {
    let length = x.hypot(y);
    if length == 0.0 {
        return [1.0, 0.0];
    }
    [x / length, y / length].map(clean)
}

/// Sine and cosine of right angles are whole.
fn clean(x: f64) -> f64 {
    if (x - x.round()).abs() < ROUNDING { x.round() + 0.0 } else { x }
}

/// An angle, rad; zero where rounding alone is left.
pub(super) fn clean_angle(angle: f64) -> f64 {
    if angle.abs() < ROUNDING { 0.0 } else { angle }
}

/// A number; whole ones without a point.
pub(super) fn number(x: f64) -> Value {
    // TOML has no infinite numbers as Rust prints them.
    x.to_string().parse().unwrap_or_else(|_| Value::from(x))
}
