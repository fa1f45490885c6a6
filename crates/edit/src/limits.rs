//! Limits of a mechanism with one free motion as tables: types of loops, ranges, dead points, transmission angles.

use bksim_analysis::{
    Branch, Extreme, FourBar, Limits, LimitsRequest, RangeOf, Rotatability, SliderCrank,
    Transmission, TransmissionAt,
};
use bksim_model::Model;
use serde_json::{Value, json};

use crate::numbers::{angle, length, rounded};

/// Tables of the limits of a model, `{"tables": [{"title", "heads", "rows"}]}`, or `{"refused": …}` with the reason.
pub(crate) fn limits(model: Model) -> Value {
    match bksim_analysis::limits(model, &LimitsRequest::default()) {
        Ok(found) => json!({ "tables": tables(&found), "beyond": found.beyond }),
        Err(error) => json!({ "refused": error.to_string() }),
    }
}

fn tables(found: &Limits) -> Vec<Value> {
    let mut all = Vec::new();
    let mut add = |title: &str, heads: &[&str], rows: Vec<Vec<String>>| {
        if !rows.is_empty() {
            all.push(json!({ "title": title, "heads": heads, "rows": rows }));
        }
    };
    let four_bars = found.four_bars.iter().map(four_bar).collect();
    add("Four-bars", &["joints", "lengths", "", "Barker’s type"], four_bars);
    let slider_cranks = found.slider_cranks.iter().map(slider_crank).collect();
    add("Slider-cranks", &["joints", "", "links", "offset"], slider_cranks);
    if let Some(Branch { ranges, extremes, transmissions, .. }) = found.branches.first() {
        add("Ranges", &["", "smallest", "largest"], ranges.iter().map(range).collect());
        let ends = extremes.iter().map(extreme).collect();
        add("Limit positions", &["", "", "value", "where"], ends);
        let heads = ["joint", "least", "where", "greatest", "where"];
        add("Transmission angles", &heads, transmissions.iter().map(transmission).collect());
    }
    all
}

fn four_bar(of: &FourBar) -> Vec<String> {
    let kind = match of.rotatability {
        Rotatability::Grashof => "Grashof",
        Rotatability::ChangePoint => "change point",
        Rotatability::NonGrashof => "not Grashof",
    };
    let barker = format!("{} {}", of.barker.code, of.barker.name);
    vec![of.joints.join("–"), lengths(&of.lengths), kind.to_owned(), barker]
}

fn slider_crank(of: &SliderCrank) -> Vec<String> {
    let offset = length(of.offset);
    vec![of.joints.join("–"), of.inversion.to_owned(), lengths(&of.lengths), offset]
}

fn lengths(of: &[f64]) -> String {
    of.iter().map(|l| length(*l)).collect::<Vec<_>>().join(" / ")
}

fn range(of: &RangeOf) -> Vec<String> {
    let [min, max] = [of.min, of.max].map(|value| shown(value, of.unit));
    let [min, max] = if of.turns { ["turns round".to_owned(), String::new()] } else { [min, max] };
    vec![of.name.clone(), min, max]
}

fn extreme(of: &Extreme) -> Vec<String> {
    let kind = if of.is_maximum { "largest" } else { "smallest" };
    let value = shown(of.value, unit_of(&of.name));
    vec![of.name.clone(), kind.to_owned(), value, place(&of.pose)]
}

fn transmission(of: &Transmission) -> Vec<String> {
    let two = |at: &TransmissionAt| [angle(at.angle), place(&at.pose)];
    let [least, greatest] = [&of.least, &of.greatest].map(two);
    [vec![of.at.clone()], least.to_vec(), greatest.to_vec()].concat()
}

/// A pose by its first quantity.
fn place(pose: &[(String, f64)]) -> String {
    let first = pose.first();
    first.map_or_else(String::new, |(name, value)| {
        format!("{name} = {}", shown(*value, unit_of(name)))
    })
}

fn unit_of(name: &str) -> &'static str {
    let is_angle = name.rsplit('.').next() == Some("angle");
    if is_angle || name.starts_with("transmission ") { "rad" } else { "m" }
}

fn shown(value: f64, unit: &str) -> String {
    match unit {
        "rad" => angle(value),
        // Large machines are not measured in millimetres.
        _ if value.abs() >= 10.0 => format!("{} m", rounded(value)),
        _ => length(value),
    }
}
