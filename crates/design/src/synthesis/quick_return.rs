//! Quick returns by their ratio of times.
//!
//! ```text
//! α = π (Q − 1)/(Q + 1)
//! slotted lever:   r = d sin(α/2),  stroke = 2 L sin(α/2)
//! Whitworth:       d = r sin(α/2)
//! ```

use std::collections::BTreeMap;
use std::f64::consts::PI;

use serde::Deserialize;

use super::{Candidate, DesignError, Synthesis, none, optional};
use crate::spec::Written;

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Wish {
    /// Time of the slow stroke over that of the quick one, above one.
    time_ratio: f64,
    /// Slotted lever: distance of the pivots.
    ground: Option<Written>,
    /// Slotted lever: chord that the end of the lever makes.
    stroke: Option<Written>,
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
    if candidates.is_empty() {
        return Err(none(
            "neither the distance of the pivots nor the crank is given",
            "give `ground` for a slotted lever, or `crank` for Whitworth's",
        ));
    }
    let facts = [("alpha".to_owned(), vec![alpha])].into_iter().collect();
    Ok(Synthesis { task: "quick_return".to_owned(), facts, candidates })
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
    let model = format!(
        r#"name = "{name}"

[parameters]
crank = "{r} m"
ground = "{d} m"
lever = "{length} m"
speed = "60 rpm"

[ground]
points = {{ O = [0, "ground"], P = [0, 0] }}

[bodies.crank]
mass = "1 kg"
inertia = "1 kg*crank^2/12"
com = ["crank/2", 0]
points = {{ O = [0, 0], C = ["crank", 0] }}

[bodies.block]
mass = "0.1 kg"
inertia = "1e-4 kg*m^2"

[bodies.lever]
mass = "1 kg"
inertia = "1 kg*lever^2/12"
com = ["lever/2", 0]
points = {{ P = [0, 0], E = ["lever", 0] }}

[joints.O]
type = "revolute"
between = ["ground.O", "crank.O"]

[joints.C]
type = "revolute"
between = ["crank.C", "block"]

[joints.S]
type = "prismatic"
between = ["lever", "block"]
axis = [1, 0]

[joints.P]
type = "revolute"
between = ["ground.P", "lever.P"]

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
