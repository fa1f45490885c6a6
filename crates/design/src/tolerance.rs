//! `[tolerance]`: what the limits of parts do to a pose.
//!
//! ```text
//! linear worst case    Σ |Sₖ| tₖ           root of squares   √Σ (Sₖ tₖ)²       S = dh/dp, exact
//! exact                min, max of h over the box: at corners where every slope keeps its sign, which intervals
//!                      prove; else by search over (q, p) with Φ = 0 and |Φ_q| on one side
//! samples              each followed from the nominal pose; what does not assemble is counted
//! ```

mod aside;
mod cheapest;
mod extreme;
mod fits;
mod job;
mod parts;
mod play;
mod proof;
mod samples;

use std::collections::BTreeMap;

use bksim::Mechanism;
use bksim::analysis::Drive;
use bksim::expr::Expr;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::message::short;
use serde::{Deserialize, Serialize};

use crate::base::{Source, Watch};
use crate::codes;
use crate::error::DesignError;
use crate::formula::formula;
use crate::interval::Steps;
use crate::poses::Poses;
use crate::spec::{Written, located, place, section};
pub use cheapest::{Cheapest, CheapestPart, Kept};
use parts::{Part, Spread, limits_of};
use play::Play;

/// Results that are asked, and the limits of the parts.
#[derive(Clone, Debug, Default)]
pub struct ToleranceWish {
    /// Formulas over the pose: `rocker.angle`, `slider.P.x - d`.
    pub of: Vec<String>,
    /// Parameters with limits and, if it is another than that of all, the distribution.
    pub limits: Vec<(String, String, Option<String>)>,
    /// Pins with play: joints, and how far the centres of pin and hole come apart.
    pub play: Vec<(String, String)>,
    /// Measures with the values, or ranges, at which poses are asked for; the start of the model without any.
    pub at: Vec<(String, String)>,
    /// `uniform`, `normal` (a third of the limit is the standard deviation) or `triangular`; normal unless given.
    pub distribution: Option<String>,
    /// Number of samples of each pose.
    pub samples: Option<u64>,
    /// Other samples for each seed.
    pub seed: Option<u64>,
    /// Results with the limits that they are to keep: those of the parts follow, as the cheapest that do.
    pub keep: Vec<(String, String)>,
    /// Parts whose limits follow, with what a limit of one unit of SI costs; all with 1 unless given.
    pub weights: Vec<(String, String)>,
    /// `worst` or `squares`: how the limits of parts add up; the worst case unless given.
    pub by: Option<String>,
}

/// A limit alone, or with its distribution.
#[derive(Deserialize, Debug)]
#[serde(untagged, expecting = "a limit in quotes such as \"±0.1 mm\", or a table with `limit`")]
enum Limit {
    Alone(String),
    With { limit: String, distribution: Option<String> },
}

/// One or several.
#[derive(Deserialize, Debug)]
#[serde(untagged, expecting = "a text, or a list of texts")]
enum Texts {
    One(String),
    Many(Vec<String>),
}

/// The section `[tolerance]`.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
struct Section {
    of: Option<Texts>,
    #[serde(default)]
    limits: BTreeMap<String, Limit>,
    #[serde(default)]
    play: BTreeMap<String, String>,
    #[serde(default)]
    at: BTreeMap<String, Written>,
    distribution: Option<String>,
    samples: Option<u64>,
    seed: Option<u64>,
    #[serde(default)]
    keep: BTreeMap<String, String>,
    #[serde(default)]
    weights: BTreeMap<String, Written>,
    by: Option<String>,
}

const EXAMPLE: &str =
    "write it as `of = \"rocker.angle\"` and `limits = { l1 = \"±0.1 mm\" }` below `[tolerance]`";

impl ToleranceWish {
    /// Question that the model asks in `[tolerance]`; nothing of a model without the section.
    ///
    /// # Errors
    /// [`codes::BAD_QUESTION`].
    pub fn of_model(text: &str) -> Result<Self, DesignError> {
        let Some(found) = section::<Section>(text, "tolerance", EXAMPLE)? else {
            return Ok(Self::default());
        };
        let limit = |(name, limit): (String, Limit)| match limit {
            Limit::Alone(text) => (name, text, None),
            Limit::With { limit, distribution } => (name, limit, distribution),
        };
        Ok(Self {
            of: match found.of {
                None => Vec::new(),
                Some(Texts::One(text)) => vec![text],
                Some(Texts::Many(texts)) => texts,
            },
            limits: found.limits.into_iter().map(limit).collect(),
            play: found.play.into_iter().collect(),
            at: found.at.into_iter().map(|(name, value)| (name, value.text())).collect(),
            distribution: found.distribution,
            samples: found.samples,
            seed: found.seed,
            keep: found.keep.into_iter().collect(),
            weights: found.weights.into_iter().map(|(name, w)| (name, w.text())).collect(),
            by: found.by,
        })
    }
}

/// A parameter with its share of a band.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Contributor {
    /// The parameter.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Least and largest value less the nominal one, SI.
    pub limits: [f64; 2],
    /// Distribution of the part.
    pub distribution: &'static str,
    /// Derivative of the result by it, SI.
    pub sensitivity: f64,
    /// |S t|.
    pub linear: f64,
    /// Part of the linear worst case, per cent.
    pub percent_of_worst: f64,
    /// Part of the linear variance, per cent.
    pub percent_of_variance: f64,
}

/// Effect of limits on one result in one pose.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Band {
    /// The formula.
    pub of: String,
    /// SI unit; empty of a formula.
    pub unit: String,
    /// With nominal values.
    pub nominal: f64,
    /// Half of the linear worst case, Σ |S t|.
    pub linear_worst: f64,
    /// By slopes alone.
    pub linear_interval: [f64; 2],
    /// √Σ (S t)².
    pub rss: f64,
    /// Standard deviation by slopes.
    pub sigma_linear: f64,
    /// Least and largest value of all parts that assemble.
    pub exact_interval: [f64; 2],
    /// By parameter, on which limit the ends are: `-` or `+`; empty where they are none of the corners.
    pub exact_at: [Vec<&'static str>; 2],
    /// True if intervals prove the ends.
    pub proved: bool,
    /// Whether slopes alone give less than nine tenths or more than eleven tenths of the exact band.
    pub linear_fails: bool,
    /// Mean of the samples that assemble, with its standard error.
    pub mean: [f64; 2],
    /// Standard deviation of the samples that assemble, with its standard error.
    pub sigma: [f64; 2],
    /// Skewness of the samples that assemble.
    pub skewness: f64,
    /// Least and largest sample.
    pub sampled: [f64; 2],
    /// The parameters, in the order of the question.
    pub contributors: Vec<Contributor>,
}

/// All results in one pose.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct PoseTolerance {
    /// Prescribed measures and their values, SI.
    pub at: BTreeMap<String, f64>,
    /// The range whose greatest and least values these are, in place of a pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
    /// Whether all parts within the limits assemble; `None` where that is not proved.
    pub assembles: Option<bool>,
    /// Part of the samples that do not assemble, with its standard error.
    pub share_without_assembly: [f64; 2],
    /// By formula.
    pub bands: Vec<Band>,
    /// Points both of whose coordinates are asked for, `P.x` and `P.y` one after the other, as one pose after another moves them.
    pub paths: Vec<PathBand>,
}

/// How far limits move the path of a point aside.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct PathBand {
    /// The point.
    pub of: String,
    /// Place of the point, m.
    pub at: [f64; 2],
    /// Unit vector across the path.
    pub normal: [f64; 2],
    /// Half of the linear worst case along the normal, m.
    pub linear_worst: f64,
    /// Standard deviation along the normal by slopes, m.
    pub sigma_linear: f64,
}

/// The answer.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Tolerance {
    /// By pose.
    pub poses: Vec<PoseTolerance>,
    /// Samples of each pose.
    pub samples: u64,
    /// True if it was stopped before the samples were done.
    pub stopped: bool,
    /// The cheapest limits, where results are to keep theirs; the poses are then with these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cheapest: Option<Cheapest>,
    /// The text of the model with the cheapest limits.
    #[serde(skip)]
    pub model: Option<String>,
    /// Limits that go as far as the value itself.
    #[serde(skip)]
    pub warnings: Vec<Diagnostic>,
}

/// Finds what limits do to the results of a model, or the cheapest limits with which results keep theirs.
///
/// # Errors
/// [`DesignError`] for what cannot be read, and poses that are not reached.
pub fn tolerance(
    source: &Source,
    wish: &ToleranceWish,
    watch: Watch<'_>,
) -> Result<Tolerance, DesignError> {
    if wish.keep.is_empty() {
        banded(source, wish, watch)
    } else {
        cheapest::allocated(source, wish, watch)
    }
}

/// The bands of all results at the limits of the question.
fn banded(
    source: &Source,
    wish: &ToleranceWish,
    watch: Watch<'_>,
) -> Result<Tolerance, DesignError> {
    let has_parts = !wish.limits.is_empty() || !wish.play.is_empty();
    if wish.of.is_empty() || !has_parts {
        let message =
            if wish.of.is_empty() { "no result is asked for" } else { "no part has limits" };
        return Err(DesignError::fault(codes::NOTHING_ASKED, message, EXAMPLE));
    }
    let names: Vec<String> = wish.limits.iter().map(|(name, ..)| name.clone()).collect();
    let stated = source.stated(&names, true)?;
    let study = source.study(&stated, &[], &["0".to_owned()], true)?;
    let mut mechanism = study.mechanism();
    let mut plays = Vec::new();
    if !wish.play.is_empty() {
        plays = play::added(&mut mechanism.model, &wish.play, &source.text)?;
        mechanism = Mechanism::positions(mechanism.model)?;
    }
    let model = &mechanism.model;
    let common = wish.distribution.as_deref().unwrap_or("normal");
    let mut parts = Vec::new();
    for (stated, (name, text, own)) in stated.iter().zip(&wish.limits) {
        let read = limits_of(text).filter(|(_, one)| {
            one.fits(&stated.unit) && (stated.unit.is_empty() || !one.unit.is_empty())
        });
        let by_letters = || {
            let is_length = stated.unit == "m";
            fits::limits(text.trim(), stated.value).filter(|_| is_length)
        };
        let limits = read.map(|(limits, _)| limits).or_else(by_letters).ok_or_else(|| {
            let message = format!("`{text}` is no limit of `{name}`");
            let unit = if stated.unit == "m" { "mm" } else { &stated.unit };
            let letters = if stated.unit == "m" {
                ", or of a size up to 500 mm letters such as `H7`, `g6` or `ZC9`, with the grades 1 to 18"
            } else {
                ""
            };
            let help = format!("write `±0.1 {unit}` or `+0.2/-0.1 {unit}`{letters}");
            located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, text)
        })?;
        let word = own.as_deref().unwrap_or(common);
        let spread = Spread::named(word).ok_or_else(|| {
            let message = format!("`{word}` is no distribution");
            let help = "write `uniform`, `normal` or `triangular`";
            located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, word)
        })?;
        let place = model.parameters.iter().position(|p| p.name == *name).ok_or_else(|| {
            let message = format!("`{name}` is an initial value, which has no limits");
            DesignError::fault(
                codes::UNKNOWN_QUANTITY,
                message,
                "give limits to parameters, and positions with `at`",
            )
        })?;
        parts.push(Part {
            name: name.clone(),
            unit: stated.unit.clone(),
            place,
            nominal: stated.value,
            limits,
            spread,
        });
    }

    // Results, and the poses at which they are asked for.
    let read = |text: &String| {
        let read = formula(text, model, Some(&mechanism.system), &[]);
        let read = read.map_err(|fault| extreme::in_formula(text).unwrap_or(fault));
        read.map_err(|fault| located(fault, &source.text, text))
    };
    let (over, plain): (Vec<&String>, Vec<&String>) =
        wish.of.iter().partition(|text| extreme::parts_of(text).is_some());
    let results = plain.iter().map(|text| read(text)).collect::<Result<Vec<_>, _>>()?;
    let drives = wish.at.iter().map(|(name, values)| Drive::parse(model, name, values));
    let drives = drives.collect::<Result<Vec<Drive>, _>>()?;
    let prescribed: Vec<_> =
        drives.iter().map(|drive| (drive.name.clone(), drive.measure)).collect();
    let outputs: Vec<Expr> = results.iter().map(|result| result.expr).collect();
    let poses = Poses::new(&mechanism, &prescribed, &outputs, &[])?;
    let n_at = drives.iter().map(|drive| drive.range.n).max().unwrap_or(1);
    // Of a range each sample finds its poses anew.
    let default = if plain.is_empty() { 10_000 } else { (100_000 / n_at as u64).max(2000) };
    let n_samples = wish.samples.unwrap_or(default);

    let parameters = |point: &[f64]| {
        let (of_parts, of_plays) = point.split_at(parts.len());
        let mut parameters = study.parameters_at(of_parts)?;
        parameters.extend(of_plays);
        Some(parameters)
    };
    let mut job = Job {
        poses: &poses,
        parts: &parts,
        steps: steps(&mechanism, &poses),
        plays: &plays,
        parameters: &parameters,
        paths: if drives.is_empty() { Vec::new() } else { paths_of(&plain) },
        n_outputs: outputs.len(),
        seed: wish.seed.unwrap_or(0),
        watch,
        progress: [0.0, n_at as f64],
    };
    let mut solver = poses.solver();
    let mut pose = poses.start.clone();
    let mut found = Vec::new();
    let n_at = if plain.is_empty() { 0 } else { n_at };
    for k in 0..n_at {
        let u: Vec<f64> =
            drives.iter().map(|drive| drive.range.values()[k.min(drive.range.n - 1)]).collect();
        let p = pose.p.clone();
        pose = solver.follow(&pose, &p, &u).map_err(|_| {
            let message = format!("the pose with {} is not reached from the start", told(&drives, &u));
            DesignError::fault(codes::NOT_ASSEMBLED, message, "choose values within the range of the mechanism: `bksim kinematics MODEL --limits`")
        })?;
        let at = drives.iter().map(|drive| drive.name.clone()).zip(u.iter().copied()).collect();
        job.progress[0] = k as f64;
        let mut bands = match job.pose(&pose, at, n_samples) {
            // Poses that are whole are an answer.
            Err(DesignError::Stopped) if !found.is_empty() => break,
            bands => bands?,
        };
        for (path, &k) in bands.paths.iter_mut().zip(&job.paths) {
            plain[k].trim().trim_end_matches(".x").clone_into(&mut path.of);
        }
        for (band, (text, result)) in bands.bands.iter_mut().zip(plain.iter().zip(&results)) {
            band.of.clone_from(text);
            band.unit.clone_from(&result.unit);
        }
        found.push(bands);
        (watch.kept)();
        if (watch.stop)() {
            break;
        }
    }
    if !over.is_empty() && (found.is_empty() || !(watch.stop)()) {
        let job = Job { paths: Vec::new(), ..job };
        found.push(extreme::ranged(&mechanism, job, (&over, wish, n_samples), (&read, source))?);
    }
    Ok(Tolerance {
        poses: found,
        samples: n_samples,
        stopped: (watch.stop)(),
        cheapest: None,
        model: None,
        warnings: parts.iter().filter_map(|part| beyond_zero(part, &source.text)).collect(),
    })
}

/// The warning of a length whose limits go through zero.
fn beyond_zero(part: &Part, text: &str) -> Option<Diagnostic> {
    let ends = part.limits.map(|limit| part.nominal + limit);
    if part.unit != "m" || part.nominal == 0.0 || ends[0] * ends[1] > 0.0 {
        return None;
    }
    let [low, nominal, high] = [ends[0], part.nominal, ends[1]].map(short);
    let message = format!(
        "the limits of `{}` go from {low} m to {high} m, through zero, and its value is {nominal} m",
        part.name
    );
    let fault = Diagnostic::warning(codes::LIMIT_THROUGH_ZERO, message)
        .help("write smaller limits with their unit, as in \"±0.1 mm\"");
    Some(match place(text, &part.name) {
        Some(span) => fault.at(span, "its limits"),
        None => fault,
    })
}

/// Places of `P.x` that `P.y` follows.
fn paths_of(of: &[&String]) -> Vec<usize> {
    let is_pair = |k: &usize| {
        let [x, y] = [of[*k], of[k + 1]].map(|text| text.trim());
        x.strip_suffix(".x").is_some_and(|point| y.strip_suffix(".y") == Some(point))
    };
    (0..of.len().saturating_sub(1)).filter(is_pair).collect()
}

fn told(drives: &[Drive], u: &[f64]) -> String {
    let one = |(drive, u): (&Drive, &f64)| {
        format!("{} = {}", drive.name, bksim::model::message::short(*u))
    };
    drives.iter().zip(u).map(one).collect::<Vec<_>>().join(", ")
}

/// Rows, outputs and their slopes for intervals.
fn steps(mechanism: &Mechanism, poses: &Poses) -> Option<Steps> {
    let pool = &mechanism.model.pool;
    let slopes = pool.jacobian(&poses.expressions, &poses.symbols[1..]);
    let entries = slopes.entries.iter().map(|entry| entry.2);
    let all: Vec<Expr> = poses.expressions.iter().copied().chain(entries).collect();
    let names: Vec<String> = poses.symbols.iter().map(|&symbol| pool.symbol_name(symbol)).collect();
    Steps::of(pool, &all, &names)
}

/// All that a pose needs.
struct Job<'a> {
    poses: &'a Poses,
    parts: &'a [Part],
    plays: &'a [Play],
    /// Results that are the abscissa of a point, whose ordinate follows.
    paths: Vec<usize>,
    steps: Option<Steps>,
    /// The parameters of the model at values of the parts and both components of each play.
    parameters: &'a (dyn Fn(&[f64]) -> Option<Vec<f64>> + Sync),
    n_outputs: usize,
    seed: u64,
    watch: Watch<'a>,
    /// Poses that are done, and all of them.
    progress: [f64; 2],
}
