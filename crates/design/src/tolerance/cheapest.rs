//! The cheapest limits of parts with which results keep theirs.
//!
//! ```text
//! least Σ wₖ/tₖ      worst:   Σ |Sₖ| tₖ ≤ T        tₖ = T √(wₖ/|Sₖ|) / Σ √(wⱼ |Sⱼ|)
//!                    squares: Σ (Sₖ tₖ)² ≤ T²      tₖ = T (wₖ/Sₖ²)^⅓ / √Σ (wⱼ |Sⱼ|)^⅔
//! ```
//!
//! These are Lagrange's conditions of one result in one pose; of several, the one that is left least binds alone or with
//! others, which a search from its closed form decides. T is less what parts with limits of their own, and play, take. In the
//! worst case the least and largest values over the new limits decide, not slopes alone: where they are beyond T, it is
//! narrowed by as much. Source of the cost 1/t: K. W. Chase, W. H. Greenwood, Manufacturing Review 1 (1988).

use serde::Serialize;

use super::parts::limits_of;
use super::{Tolerance, ToleranceWish, banded};
use crate::base::{Quantity, Source, Watch, written};
use crate::codes;
use crate::error::DesignError;
use crate::spec::located;
use crate::sqp::Problem;

/// A part with its cheapest limit.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CheapestPart {
    /// The parameter.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Cost of a limit of one unit of SI; half the limit costs twice as much.
    pub weight: f64,
    /// Half of the width of the limits before, SI.
    pub before: f64,
    /// Half of the width of the cheapest limits, SI.
    pub after: f64,
    /// Limits as they are written into the model.
    pub written: String,
}

/// Cheapest limits with which results keep theirs.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Cheapest {
    /// `worst` or `squares`.
    pub by: &'static str,
    /// The parts whose limits were free.
    pub parts: Vec<CheapestPart>,
    /// Σ w/t before.
    pub cost_before: f64,
    /// Σ w/t with the cheapest limits.
    pub cost: f64,
    /// By result: the name, its limit, and how far it gets from its nominal value in the pose where that is farthest, SI.
    pub kept: Vec<Kept>,
}

/// A result that keeps its limit.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Kept {
    /// The formula.
    pub of: String,
    /// Wanted limit, SI.
    pub limit: f64,
    /// Largest offset from the nominal value over all poses, by the worst case or the root of squares, SI.
    pub reached: f64,
}

/// One result in one pose: slopes of the free parts, and what is left of its limit, as sums or as squares.
struct Row {
    slopes: Vec<f64>,
    left: f64,
}

/// Rounds in which the worst case narrows what slopes alone say.
const ROUNDS: usize = 6;

fn bad(source: &Source, about: &str, message: String, help: impl Into<String>) -> DesignError {
    located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, about)
}

/// The bands of the cheapest limits with which the results of the question keep theirs.
pub(super) fn allocated(
    source: &Source,
    wish: &ToleranceWish,
    watch: Watch<'_>,
) -> Result<Tolerance, DesignError> {
    let is_worst = match wish.by.as_deref().unwrap_or("worst") {
        "worst" => true,
        "squares" => false,
        other => {
            let message = format!("`{other}` is no way in which limits add up");
            return Err(bad(source, other, message, "write `worst` or `squares`"));
        }
    };
    let mut asked = wish.clone();
    let mut limits = Vec::new();
    for (of, text) in &wish.keep {
        let read = limits_of(text).filter(|([low, high], _)| (low + high).abs() <= 1e-12 * high);
        let ([_, limit], one) = read.ok_or_else(|| {
            let message = format!("`{text}` is no limit that `{of}` can keep");
            bad(source, text, message, "write one that is alike on both sides, as in `±0.2 mm`")
        })?;
        limits.push((of.clone(), limit, one));
        if !asked.of.iter().any(|known| known.trim() == of.trim()) {
            asked.of.push(of.clone());
        }
    }
    let (mut names, mut weights) = (Vec::new(), Vec::new());
    for (name, text) in &wish.weights {
        let weight = Quantity::read(text).map_or(0.0, |weight| weight.value);
        if !wish.limits.iter().any(|(known, ..)| known == name) {
            let message = format!("`{name}` has a weight, but no limits to begin with");
            let help = format!("add `{name}` to `limits`, with limits of its unit");
            return Err(bad(source, name, message, help));
        }
        if weight.is_nan() || weight <= 0.0 {
            let message = format!("`{text}` is no weight of `{name}`");
            return Err(bad(source, text, message, "write a number above zero"));
        }
        names.push(name.clone());
        weights.push(weight);
    }
    if names.is_empty() {
        names = wish.limits.iter().map(|(name, ..)| name.clone()).collect();
        weights = vec![1.0; names.len()];
    }

    // Slopes with the limits of the question; samples belong to the answer.
    let few = Some(2);
    let start = banded(source, &ToleranceWish { samples: few, ..asked.clone() }, watch)?;
    for (of, _, one) in &limits {
        let unit = unit_of(&start, of);
        if !one.fits(unit) && !unit.is_empty() {
            let message = format!("the limit of `{of}` is no quantity of the kind {unit}");
            return Err(bad(source, of, message, format!("give it in units of the kind {unit}")));
        }
    }
    let before: Vec<f64> = names.iter().map(|name| half(&start, name)).collect();
    let mut narrowed = 1.0;
    let mut now = start;
    for round in 0..ROUNDS {
        let rows = rows(&now, &names, &limits, (is_worst, narrowed))?;
        let found = cheapest(&rows, &weights, is_worst, watch).ok_or_else(|| {
            let message =
                "no limits of these parts are as cheap as any: no result depends on one of them"
                    .to_owned();
            bad(source, &wish.keep[0].0, message, "leave out of `weights` what does not matter")
        })?;
        let mut next = asked.clone();
        let mut written_of = Vec::new();
        for (name, half) in names.iter().zip(&found) {
            let Some(own) = next.limits.iter_mut().find(|(known, ..)| known == name) else {
                continue;
            };
            let unit = limits_of(&own.1).map(|(_, one)| one.unit).unwrap_or_default();
            let of_part = now.poses[0].bands[0].contributors.iter().find(|c| c.name == *name);
            let si = of_part.map_or(String::new(), |part| part.unit.clone());
            let unit = match (unit.as_str(), si.as_str()) {
                ("", "m") => "mm".to_owned(),
                ("", _) => si,
                _ => unit,
            };
            own.1 = format!("±{}", written(*half, &unit));
            written_of.push(own.1.clone());
        }
        let last = round + 1 == ROUNDS || !is_worst;
        now = banded(source, &ToleranceWish { samples: few, ..next.clone() }, watch)?;
        let kept = kept(&now, &limits, is_worst);
        let beyond = kept.iter().map(|kept| kept.reached / kept.limit).fold(0.0, f64::max);
        if is_worst && beyond > 1.0 + 1e-12 && !last && beyond.is_finite() {
            narrowed /= beyond;
            continue;
        }
        let mut answer = banded(source, &next, watch)?;
        let part = |k: usize| CheapestPart {
            name: names[k].clone(),
            unit: unit_of_part(&now, &names[k]),
            weight: weights[k],
            before: before[k],
            after: found[k],
            written: written_of[k].clone(),
        };
        let cost = |halves: &[f64]| weights.iter().zip(halves).map(|(w, t)| w / t).sum();
        answer.cheapest = Some(Cheapest {
            by: if is_worst { "worst" } else { "squares" },
            parts: (0..names.len()).map(part).collect(),
            cost_before: cost(&before),
            cost: cost(&found),
            kept,
        });
        answer.model = patched(source, &names, &written_of);
        return Ok(answer);
    }
    Err(DesignError::Stopped)
}

/// The text of the model with these limits, where the model has them.
fn patched(source: &Source, names: &[String], limits: &[String]) -> Option<String> {
    let root = source.text.parse::<toml::Table>().ok()?;
    let own = root.get("tolerance")?.get("limits")?;
    let path = |name: &String| {
        let ending = if own.get(name)?.is_table() { ".limit" } else { "" };
        Some(format!("tolerance.limits.{name}{ending}"))
    };
    let values = names.iter().zip(limits).map(|(name, text)| Some((path(name)?, text.clone())));
    source.with_values(&values.collect::<Option<Vec<_>>>()?).ok()
}

fn unit_of<'t>(found: &'t Tolerance, of: &str) -> &'t str {
    let mut bands = found.poses.iter().flat_map(|pose| &pose.bands);
    let band = bands.find(|band| band.of.trim() == of.trim());
    band.map_or("", |band| &band.unit)
}

fn unit_of_part(found: &Tolerance, name: &str) -> String {
    let mut parts = found.poses[0].bands[0].contributors.iter();
    parts.find(|c| c.name == name).map_or(String::new(), |c| c.unit.clone())
}

fn half(found: &Tolerance, name: &str) -> f64 {
    let mut parts = found.poses[0].bands[0].contributors.iter();
    parts.find(|c| c.name == name).map_or(f64::NAN, |c| 0.5 * (c.limits[1] - c.limits[0]))
}

/// A row for every result that has to keep its limit, in every pose.
fn rows(
    found: &Tolerance,
    names: &[String],
    limits: &[(String, f64, Quantity)],
    (is_worst, narrowed): (bool, f64),
) -> Result<Vec<Row>, DesignError> {
    let mut rows = Vec::new();
    for (of, limit, _) in limits {
        for band in found.poses.iter().flat_map(|pose| &pose.bands) {
            if band.of.trim() != of.trim() {
                continue;
            }
            let slope = |name: &String| {
                let own = band.contributors.iter().find(|c| c.name == *name);
                own.map_or(0.0, |own| own.sensitivity.abs())
            };
            let fixed = band.contributors.iter().filter(|c| !names.contains(&c.name));
            let part = |x: f64| if is_worst { x } else { x * x };
            let left = part(limit * narrowed) - fixed.map(|c| part(c.linear)).sum::<f64>();
            if left.is_nan() || left <= 0.0 {
                let message = format!("parts with limits of their own take all of that of `{of}`");
                let help = "widen the limit that is to be kept, or give these parts a weight";
                return Err(DesignError::fault(codes::UNMET, message, help));
            }
            rows.push(Row { slopes: names.iter().map(slope).collect(), left });
        }
    }
    Ok(rows)
}

/// How much of what is left the halves of the limits use: above one is too much.
fn used(row: &Row, halves: &[f64], is_worst: bool) -> f64 {
    let part = |(s, t): (&f64, &f64)| if is_worst { s * t } else { (s * t) * (s * t) };
    row.slopes.iter().zip(halves).map(part).sum::<f64>() / row.left
}

/// Halves of the cheapest limits; none if a part matters nowhere.
fn cheapest(rows: &[Row], weights: &[f64], is_worst: bool, watch: Watch<'_>) -> Option<Vec<f64>> {
    const ROUNDING: f64 = 1e-12;
    let n = weights.len();
    // By Lagrange, as if a result were alone.
    let alone = |row: &Row| -> Option<Vec<f64>> {
        if row.slopes.iter().any(|s| s.is_nan() || *s <= 0.0) {
            return None;
        }
        let pairs = || weights.iter().zip(&row.slopes);
        Some(if is_worst {
            let sum: f64 = pairs().map(|(w, s)| (w * s).sqrt()).sum();
            pairs().map(|(w, s)| row.left * (w / s).sqrt() / sum).collect()
        } else {
            let sum: f64 = pairs().map(|(w, s)| (w * s).powf(2.0 / 3.0)).sum();
            pairs().map(|(w, s)| (row.left / sum).sqrt() * (w / (s * s)).cbrt()).collect()
        })
    };
    let keeps =
        |halves: &Vec<f64>| rows.iter().all(|row| used(row, halves, is_worst) < 1.0 + ROUNDING);
    let closed: Vec<Vec<f64>> = rows.iter().filter_map(alone).collect();
    if let Some(one) = closed.iter().find(|halves| keeps(halves)) {
        return Some(one.clone());
    }

    // Several bind: from inside of all, in parts of what each part may have alone.
    let alone = |k: usize| {
        let of = |row: &Row| if is_worst { row.left } else { row.left.sqrt() } / row.slopes[k];
        Some(rows.iter().map(of).fold(f64::INFINITY, f64::min)).filter(|most| most.is_finite())
    };
    let most = (0..n).map(alone).collect::<Option<Vec<f64>>>()?;
    let halves = |x: &[f64]| -> Vec<f64> { x.iter().zip(&most).map(|(x, t)| x * t).collect() };
    let cost = |x: &[f64]| -> f64 { halves(x).iter().zip(weights).map(|(t, w)| w / t).sum() };
    let begin = vec![1.0 / n as f64; n];
    let unit = cost(&begin);
    let evaluate = |points: &[Vec<f64>]| -> Vec<Option<Vec<f64>>> {
        let at = |x: &Vec<f64>| {
            let slack = rows.iter().map(|row| 1.0 - used(row, &halves(x), is_worst));
            let all: Vec<f64> = std::iter::once(cost(x) / unit).chain(slack).collect();
            all.iter().all(|value| value.is_finite()).then_some(all)
        };
        points.iter().map(at).collect()
    };
    let problem = Problem {
        n,
        n_goals: 1,
        n_equal: 0,
        evaluate: &evaluate,
        slopes: &|_| None,
        stop: watch.stop,
        reached: &|_, _| (),
    };
    let found = halves(&problem.minimize(begin)?.x);
    // Onto the limit that is used most.
    let most = rows.iter().map(|row| used(row, &found, is_worst)).fold(0.0, f64::max);
    let factor = if is_worst { most } else { most.sqrt() };
    Some(found.into_iter().map(|half| half / factor).collect())
}

/// How far every result gets, in the pose where that is farthest.
fn kept(found: &Tolerance, limits: &[(String, f64, Quantity)], is_worst: bool) -> Vec<Kept> {
    let one = |(of, limit, _): &(String, f64, Quantity)| {
        let bands = found.poses.iter().flat_map(|pose| &pose.bands);
        let reached = bands.filter(|band| band.of.trim() == of.trim()).map(|band| {
            let [low, high] = band.exact_interval;
            if is_worst { (high - band.nominal).max(band.nominal - low) } else { band.rss }
        });
        Kept { of: of.clone(), limit: *limit, reached: reached.fold(0.0, f64::max) }
    };
    limits.iter().map(one).collect()
}
