//! The state that an answer is about, in words and as JSON, with values in the units of the file.

use bksim::analysis::{About, OtherState, Place, Search, Stability, State, WayRates, in_words};
use bksim::model::file::ShownUnits;
use serde_json::{Value, json};

use super::answer::in_units;
use crate::output::number;

/// Most other equilibria, and most coordinates of one, that a report lists.
const MOST: usize = 8;

/// The state as the first line of a report has it: `about the equilibrium nearest to the start: A.angle = 90 deg, unstable; 1
/// other`.
pub fn about(state: &State, units: &ShownUnits) -> String {
    let which = match state.about {
        About::Static => "the equilibrium nearest to the start".to_owned(),
        About::Stable => "the stable equilibrium nearest to the start".to_owned(),
        About::Number(number) => format!("equilibrium {number}"),
        About::Start if state.left_out.is_empty() => "the start".to_owned(),
        About::Start => "the start as if at rest".to_owned(),
        About::Instant(_) => format!("the run at t = {} s", number(state.t)),
    };
    let place = match placed(&state.place, units) {
        place if place.is_empty() => place,
        place => format!(": {place}"),
    };
    let stability = state.stability.map_or(String::new(), |s| format!(", {}", word(s)));
    let found = if state.search == Search::Complete { "" } else { " found" };
    let others = match (state.number, state.others.len()) {
        (None, _) => String::new(),
        (_, 0) if state.search == Search::None => "; others were not searched for".to_owned(),
        (_, 0) => format!("; no other{found}"),
        (_, n) => format!("; {n} {}{found}", if n == 1 { "other" } else { "others" }),
    };
    format!("about {which}{place}{stability}{others}")
}

/// Lines about what else there is to know of a state: the other equilibria, and what is left out.
pub(super) fn besides(state: &State, units: &ShownUnits) -> String {
    let mut text = String::new();
    if !state.others.is_empty() {
        let other = |o: &OtherState| {
            let (place, stability) = (placed(&o.place, units), word(o.stability));
            let comma = if place.is_empty() { "" } else { ", " };
            format!("{}: {place}{comma}{stability}", o.number)
        };
        let shown: Vec<String> = state.others.iter().take(MOST).map(other).collect();
        let more = match state.others.len().saturating_sub(MOST) {
            0 => String::new(),
            n => format!("; {n} more, which `bksim static` lists"),
        };
        text.extend([format!("\n  others, by number for `--at`: {}{more}", shown.join("; "))]);
    }
    if !state.left_out.is_empty() {
        let rate = |(name, rate, unit): &(String, f64, String)| {
            let own = units.of(unit);
            format!("{name} = {} {}", number(own.of_si(*rate)), own.unit)
        };
        let rates: Vec<String> = state.left_out.iter().map(rate).collect();
        text.extend([format!(
            "\n  left out, with gyroscopic and centrifugal terms: {}; `bksim linearize --at start` has them",
            rates.join(", ")
        )]);
    }
    for kink in &state.kinks {
        let [below, above] = kink.stiffness.map(number);
        let whole = kink.omega.map_or(String::new(), |[a, b, whole]| {
            format!(
                ": {} and {} rad/s, and as half a period is on each side {} rad/s as a whole",
                number(a),
                number(b),
                number(whole)
            )
        });
        text.extend([format!(
            "\n  a kink: the stiffness along {} is {below} below and {above} above this pose, and these equations are those of one side{whole}",
            kink.name
        )]);
    }
    if state.by_quaternions {
        text.push_str(
            "\n  by components of a quaternion, which turn with half the rate of the body: the imaginary parts of poles are shifted by that, but for states that `--state` names",
        );
    }
    if state.is_passing {
        text.push_str(
            "\n  of this instant alone: the motion changes these equations, so that poles do not say how deviations grow",
        );
    }
    text
}

/// Branches that cross, a line for each.
pub(super) fn branches(ways: &[WayRates]) -> String {
    if ways.is_empty() {
        return String::new();
    }
    let line = |(k, way): (usize, &WayRates)| format!("\n    branch {}: {}", k + 1, in_words(way));
    let lines: String = ways.iter().enumerate().map(line).collect();
    format!("\n  branches that cross there, by rates of joints:{lines}")
}

/// Branches as JSON: the rates of each.
pub(super) fn branches_json(ways: &[WayRates]) -> Value {
    let rate = |(name, rate, _): &(String, f64, &'static str)| (name.clone(), json!(rate));
    ways.iter().map(|way| Value::Object(way.iter().map(rate).collect())).collect()
}

/// Values of a place in the units of the file; angles in degrees where it has no unit of them.
fn placed(place: &Place, units: &ShownUnits) -> String {
    let value = |(name, value, unit): &(String, f64, &'static str)| {
        let (value, unit) = in_units(*value, unit, units);
        // What is left by rounding is no result.
        let value = if value.abs() < 1e-12 { 0.0 } else { value };
        let space = if unit.is_empty() { "" } else { " " };
        format!("{name} = {}{space}{unit}", number(value))
    };
    let shown = place.iter().take(MOST).map(value).collect::<Vec<_>>().join(", ");
    match place.len().saturating_sub(MOST) {
        0 => shown,
        n => format!("{shown} and {n} more"),
    }
}

/// The state as JSON, with values in the units of the file.
pub fn json(state: &State, units: &ShownUnits) -> Value {
    let place = |place: &Place| -> Value {
        let one = |(name, value, unit): &(String, f64, &'static str)| {
            let (value, unit) = in_units(*value, unit, units);
            json!({ "name": name, "value": value, "unit": unit })
        };
        place.iter().map(one).collect()
    };
    let other = |o: &OtherState| json!({ "number": o.number, "coordinates": place(&o.place), "stability": word(o.stability) });
    let left_out = |(name, rate, unit): &(String, f64, String)| {
        let own = units.of(unit);
        json!({ "name": name, "value": own.of_si(*rate), "unit": own.unit })
    };
    json!({
        "about": match state.about {
            About::Start => "start",
            About::Instant(_) => "instant",
            _ => "equilibrium",
        },
        "t": state.t,
        "coordinates": place(&state.place),
        "stability": state.stability.map(word),
        "number": state.number,
        "others": state.others.iter().map(other).collect::<Vec<_>>(),
        "complete": state.search == Search::Complete,
        "searched": state.search != Search::None,
        "passing": state.is_passing,
        "quaternions": state.by_quaternions,
        "kinks": state.kinks.iter().map(|kink| {
            json!({ "name": kink.name, "stiffness": kink.stiffness, "omega": kink.omega })
        }).collect::<Vec<_>>(),
        "left_out": state.left_out.iter().map(left_out).collect::<Vec<_>>(),
    })
}

/// Stability in a word.
pub(super) fn word(stability: Stability) -> &'static str {
    match stability {
        Stability::Stable => "stable",
        Stability::Unstable => "unstable",
        Stability::Flutter => "unstable (flutter)",
        Stability::Marginal => "marginal",
        Stability::Neutral => "neutral",
    }
}
