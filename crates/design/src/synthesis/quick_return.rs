//! Quick returns by their ratio of times.
//!
//! ```text
//! α = π (Q − 1)/(Q + 1)
//! slotted lever:   r = d sin(α/2),  stroke = 2 L sin(α/2)
//! Whitworth:       d = r sin(α/2)
//! crank-rocker, slider-crank: the crank pivot A sees both ends of the output's path, C₁ and C₂, at the angle α, so that it is on
//! a circle through both; with β at C₂, |A C₁| = S sin β / sin α and |A C₂| = S sin(α + β) / sin α are b ∓ a.
//! ```
//!
//! Of all β that with the best transmission is taken. Source: Hall, Kinematics and Linkage Design, ch. 3.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use serde::Deserialize;

use super::four_bar::{FourBar, bar, revolute};
use super::function::largest;
use super::lines::pin;
use super::{Candidate, DesignError, Point, Synthesis, none, optional};
use crate::spec::Written;

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Wish {
    /// Time of the slow stroke over that of the quick one, above one.
    time_ratio: f64,
    /// Slotted lever: distance of the pivots.
    ground: Option<Written>,
    /// Slotted lever: chord that the end of the lever makes; without `ground`, the stroke of a slider-crank.
    stroke: Option<Written>,
    /// Crank-rocker: its rocker, and the angle between the ends of its swing.
    rocker: Option<Written>,
    swing: Option<Written>,
    /// Whitworth: length of the crank.
    crank: Option<Written>,
}

pub(super) fn solve(wish: &Wish) -> Result<Synthesis, DesignError> {
    let q = wish.time_ratio;
    if q.is_nan() || q <= 1.0 {
        return Err(none(
            "no quick return has a ratio of times of one or less",
            "give the time of the slow stroke over that of the quick one",
        ));
    }
    let alpha = PI * (q - 1.0) / (q + 1.0);
    let mut candidates = Vec::new();
    if let Some(d) = optional(wish.ground.as_ref())? {
        let r = d * (0.5 * alpha).sin();
        let length = optional(wish.stroke.as_ref())?
            .map_or(1.5 * d, |stroke| 0.5 * stroke / (0.5 * alpha).sin());
        candidates.push(candidate(
            "slotted-lever",
            [("crank", r), ("ground", d), ("lever", length), ("swing", alpha)],
            (r, d, length),
            true,
        ));
    }
    if let Some(r) = optional(wish.crank.as_ref())? {
        let d = r * (0.5 * alpha).sin();
        candidates.push(candidate(
            "whitworth",
            [("crank", r), ("ground", d), ("lever", 2.0 * r), ("swing", 2.0 * PI)],
            (r, d, 2.0 * r),
            false,
        ));
    }
    let (stroke, ground) = (optional(wish.stroke.as_ref())?, wish.ground.is_some());
    candidates.extend(stroke.filter(|_| !ground).and_then(|stroke| slider_crank(stroke, alpha)));
    if let Some((c, swing)) = optional(wish.rocker.as_ref())?.zip(optional(wish.swing.as_ref())?) {
        candidates.extend(crank_rocker(c, swing, alpha));
    }
    if candidates.is_empty() {
        return Err(none(
            "no quick return of these sizes has that ratio of times, or none is given",
            "give `ground` for a slotted lever, `crank` for Whitworth's, `stroke` for a slider-crank, `rocker` and `swing` for a crank-rocker, with a ratio nearer to one",
        ));
    }
    let facts = [("alpha".to_owned(), vec![alpha])].into_iter().collect();
    Ok(Synthesis { task: "quick_return".to_owned(), facts, candidates, ..Synthesis::default() })
}

/// Crank pivot and lengths of crank and coupler, with the ends of the output's path at (−S/2, 0) and (S/2, 0).
fn pivot(stroke: f64, alpha: f64, beta: f64) -> (Point, f64, f64) {
    let scale = stroke / alpha.sin();
    let (to_first, to_last) = (scale * beta.sin(), scale * (alpha + beta).sin());
    let at = [0.5 * stroke - to_last * beta.cos(), to_last * beta.sin()];
    (at, 0.5 * (to_last - to_first).abs(), 0.5 * (to_last + to_first))
}

/// The slider-crank with the least pressure angle.
fn slider_crank(stroke: f64, alpha: f64) -> Option<Candidate> {
    // The sine of the largest pressure angle.
    let worst = |beta: f64| {
        let ([_, offset], a, b) = pivot(stroke, alpha, beta);
        Some((a + offset) / b).filter(|sine| *sine < 1.0)
    };
    let (best, beta) = largest(&|beta| -worst(beta).unwrap_or(2.0), [1e-6, PI - alpha - 1e-6]);
    if best <= -1.0 {
        return None;
    }
    let (_, a, b) = pivot(stroke, alpha, beta);
    let offset = pivot(stroke, alpha, beta).0[1];
    let numbers = [
        ("crank", a),
        ("coupler", b),
        ("offset", offset),
        ("stroke", stroke),
        ("least_transmission_angle", best.abs().acos()),
    ];
    let start: f64 = 60.0;
    let height = -offset - a * start.to_radians().sin();
    let along = a * start.to_radians().cos() + (b * b - height * height).sqrt();
    let rod = (height / b).asin().to_degrees();
    let [crank, coupler] = [bar("crank", ["A", "B"], ""), bar("coupler", ["B", "C"], "")];
    let model = format!(
        r#"name = "slider-crank"

[parameters]
crank = "{a} m"
coupler = "{b} m"
offset = "{offset} m"
speed = "60 rpm"

[ground]
points = {{ A = [0, 0], G = [0, "-offset"] }}
{crank}{coupler}
[bodies.slider]
mass = "1 kg"
inertia = "1e-3 kg*m^2"

[joints]
A = {{ type = "revolute", between = ["ground.A", "crank.A"] }}
B = {{ type = "revolute", between = ["crank.B", "coupler.B"] }}
C = {{ type = "revolute", between = ["coupler.C", "slider"] }}
guide = {{ type = "prismatic", between = ["ground.G", "slider"], axis = [1, 0] }}

[drives.motor]
joint = "A"
motion = "{start} deg + speed*t"

[initial]
B = {{ guess = {{ angle = "{} deg" }} }}
guide = {{ guess = {{ position = "{along} m" }} }}

[solve]
t_end = "2 s"
"#,
        rod - start
    );
    let numbers = numbers.map(|(name, value)| (name.to_owned(), value)).into_iter().collect();
    Some(Candidate { name: "slider-crank".to_owned(), numbers, model, ..Candidate::default() })
}

/// The crank-rocker whose transmission angle is least bad.
fn crank_rocker(c: f64, swing: f64, alpha: f64) -> Option<Candidate> {
    let stroke = 2.0 * c * (0.5 * swing).sin();
    // The rocker's pivot is below the path of its pin, the crank's above or below.
    let height = -c * (0.5 * swing).cos();
    let lengths = |beta: f64, side: f64| {
        let ([x, y], a, b) = pivot(stroke, alpha, beta);
        [a, b, c, x.hypot(side * y - height)]
    };
    // Sine of the transmission angle where it is farthest from a right angle; none of other linkages.
    let least = |beta: f64, side: f64| {
        let [a, b, c, d] = lengths(beta, side);
        let angle = |x: f64, y: f64, z: f64| ((x * x + y * y - z * z) / (2.0 * x * y)).acos();
        let is_crank = a < b.min(c).min(d) && a + b.max(c).max(d) <= 0.5 * (a + b + c + d);
        let turn = angle(d, a + b, c) - angle(d, b - a, c);
        let sway = angle(d, c, a + b) - angle(d, c, b - a);
        let is_own = (turn.abs() - alpha).abs() < 1e-6 && (sway.abs() - swing).abs() < 1e-6;
        let worst = angle(b, c, d - a).sin().min(angle(b, c, d + a).sin());
        Some(worst).filter(|worst| is_crank && is_own && worst.is_finite())
    };
    let best = [1.0, -1.0].map(|side| {
        let range = [1e-6, PI - alpha - 1e-6];
        let (sine, beta) = largest(&|beta| least(beta, side).unwrap_or(-1.0), range);
        (sine, beta, side)
    });
    let (sine, beta, side) = best.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    if sine <= 0.0 {
        return None;
    }
    let [a, b, c, d] = lengths(beta, side);
    let start = PI / 3.0;
    let (pivots, crank_pin) = ([[0.0, 0.0], [d, 0.0]], [a * start.cos(), a * start.sin()]);
    let pins = [crank_pin, pin(crank_pin, b, pivots[1], c)?];
    let mut found = FourBar { pivots, pins, point: None }.candidate("crank-rocker");
    for (name, value) in [("swing", swing), ("least_transmission_angle", sine.asin())] {
        found.numbers.insert(name.to_owned(), value);
    }
    Some(found)
}

fn candidate(
    name: &str,
    numbers: [(&str, f64); 4],
    (r, d, length): (f64, f64, f64),
    is_lever: bool,
) -> Candidate {
    let numbers: BTreeMap<String, f64> =
        numbers.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    // The crank pin is a slider on the lever.
    let start = if is_lever { 90.0 } else { 10.0 };
    let (x, y) = (r * f64::to_radians(start).cos(), d + r * f64::to_radians(start).sin());
    let [crank, lever] = [bar("crank", ["O", "C"], ""), bar("lever", ["P", "E"], "")];
    let pins = revolute("O", ["ground.O", "crank.O"]) + &revolute("C", ["crank.C", "block"]);
    let pivot = revolute("P", ["ground.P", "lever.P"]);
    let model = format!(
        r#"name = "{name}"

[parameters]
crank = "{r} m"
ground = "{d} m"
lever = "{length} m"
speed = "60 rpm"

[ground]
points = {{ O = [0, "ground"], P = [0, 0] }}
{crank}
[bodies.block]
mass = "0.1 kg"
inertia = "1e-4 kg*m^2"
{lever}{pins}
[joints.S]
type = "prismatic"
between = ["lever", "block"]
axis = [1, 0]
{pivot}
[drives.motor]
joint = "O"
motion = "{start} deg + speed*t"

[initial]
P = {{ guess = {{ angle = "{} deg" }} }}
S = {{ guess = {{ position = "{} m" }} }}

[solve]
t_end = "2 s"
"#,
        y.atan2(x).to_degrees(),
        x.hypot(y)
    );
    Candidate { name: name.to_owned(), numbers, model, ..Candidate::default() }
}
