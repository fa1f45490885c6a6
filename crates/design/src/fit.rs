//! `[fit]`: parameters, initial values and sensors from measured curves.
//!
//! Three kinds of comparisons: formulas of the columns alone; positions, each row at prescribed measures; the motion
//! in time, each row at its instant. The first two have exact slopes, the last differences of fourth order.

mod prepare;
mod runs;

use std::collections::BTreeMap;

use bksim::expr::{ParseOptions, Tape, parse};
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::WrittenUnit;
use bksim_sweep::Study;
use serde::{Deserialize, Serialize};

use crate::base::{Quantity, Source, Stated, Watch, written};
use crate::codes;
use crate::data::{Columns, DataFile};
use crate::error::DesignError;
use crate::least_squares::{Loss, knowledge, least};
use crate::poses::Poses;
use crate::spec::{Written, located, section};
use prepare::run;

/// The unknowns, and what is compared with what.
#[derive(Clone, Debug, Default)]
pub struct FitWish {
    /// Parameters and initial values of the model, each with a value to begin with in place of the model's.
    pub vary: Vec<(String, Option<String>)>,
    /// Unknowns of the measurement, with values to begin with: offsets, factors, delays.
    pub unknowns: Vec<(String, String)>,
    /// Columns of the data, and formulas that they are compared with.
    pub compare: Vec<(String, String)>,
    /// Measures, and formulas of columns that prescribe them row by row.
    pub drive: Vec<(String, String)>,
    /// Standard deviations of columns.
    pub sigma: Vec<(String, String)>,
    /// Columns that come late, and the unknown by which.
    pub delay: Vec<(String, String)>,
    /// `squares`, `huber`, `soft_l1` or `cauchy`.
    pub loss: Option<String>,
    /// Where a robust loss begins, in standard deviations.
    pub scale: Option<f64>,
}

/// Names alone, or with values.
#[derive(Deserialize, Debug)]
#[serde(untagged, expecting = "a list of names, or a table of names with values")]
enum Names {
    List(Vec<String>),
    Table(BTreeMap<String, Written>),
}

/// The section `[fit]`.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
struct Section {
    vary: Option<Names>,
    #[serde(default)]
    unknowns: BTreeMap<String, Written>,
    #[serde(default)]
    compare: BTreeMap<String, String>,
    #[serde(default)]
    drive: BTreeMap<String, String>,
    #[serde(default)]
    sigma: BTreeMap<String, Written>,
    #[serde(default)]
    delay: BTreeMap<String, String>,
    loss: Option<String>,
    scale: Option<f64>,
}

const EXAMPLE: &str = "write it as `vary = [\"k\", \"c\"]` and `compare = { theta = \"A.angle\" }` below `[fit]`, where `theta` is a column of the data";

impl FitWish {
    /// Question that the model asks in `[fit]`; nothing of a model without the section.
    ///
    /// # Errors
    /// [`codes::BAD_QUESTION`].
    pub fn of_model(text: &str) -> Result<Self, DesignError> {
        let Some(found) = section::<Section>(text, "fit", EXAMPLE)? else {
            return Ok(Self::default());
        };
        let texts =
            |all: BTreeMap<String, Written>| all.into_iter().map(|(k, v)| (k, v.text())).collect();
        let vary = match found.vary {
            None => Vec::new(),
            Some(Names::List(names)) => names.into_iter().map(|name| (name, None)).collect(),
            Some(Names::Table(all)) => all.into_iter().map(|(k, v)| (k, Some(v.text()))).collect(),
        };
        Ok(Self {
            vary,
            unknowns: texts(found.unknowns),
            compare: found.compare.into_iter().collect(),
            drive: found.drive.into_iter().collect(),
            sigma: texts(found.sigma),
            delay: found.delay.into_iter().collect(),
            loss: found.loss,
            scale: found.scale,
        })
    }
}

/// An unknown with its estimate.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Unknown {
    /// A parameter, initial value or unknown of the measurement.
    pub name: String,
    /// SI unit; empty of unknowns of the measurement.
    pub unit: String,
    /// Where the search began, SI.
    pub start: f64,
    /// SI.
    pub estimate: f64,
    /// `None` where the data cannot find it.
    pub standard_error: Option<f64>,
}

/// Unknowns that the data leave open.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Unidentifiable {
    /// Number of independent combinations that the data find.
    pub rank: usize,
    /// Unknowns that nothing depends on.
    pub without_effect: Vec<String>,
    /// Unknowns that can only be found together, if one of them is known.
    pub unidentifiable_together: Vec<Vec<String>>,
    /// Directions that change nothing, by unknown, SI, up to a factor.
    pub null_vectors: Vec<BTreeMap<String, f64>>,
}

/// The answer.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Fit {
    /// The unknowns in the order of the question.
    pub unknowns: Vec<Unknown>,
    /// By unknown, SI.
    pub covariance: Vec<Vec<f64>>,
    /// By unknown.
    pub correlation: Vec<Vec<f64>>,
    /// Unknowns that the data leave open.
    pub open: Unidentifiable,
    /// Number of compared values.
    pub n_values: usize,
    /// Degrees of freedom.
    pub n_free: usize,
    /// Root mean square of the differences, in standard deviations where these are known, else SI.
    pub rms: f64,
    /// Sum of the squares over the degrees of freedom; near one where the standard deviations are right.
    pub s2: f64,
    /// True if standard deviations were given; else they are estimated from the differences.
    pub sigma_known: bool,
    /// True if the iteration came to its end.
    pub converged: bool,
    /// True if it was stopped.
    pub stopped: bool,
    /// Number of iterations.
    pub iterations: usize,
    /// How slopes were found.
    pub slopes: &'static str,
    /// By column: row of the data, measured and fitted values, SI.
    pub curves: Vec<Curve>,
    /// The text of the model with the estimates.
    #[serde(skip)]
    pub model: String,
    /// Columns whose units look wrong.
    #[serde(skip)]
    pub warnings: Vec<Diagnostic>,
}

/// A compared column.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Curve {
    /// The file.
    pub file: String,
    /// The column.
    pub column: String,
    /// The time, or the first driven measure, or the number of the row.
    pub at: Vec<f64>,
    /// Name of the column in `at`, or `row`.
    pub over: String,
    /// SI units of `at` and of the column; empty where the table states none.
    pub units: [String; 2],
    /// SI.
    pub measured: Vec<f64>,
    /// SI.
    pub fitted: Vec<f64>,
    /// Standard error of the fitted curve, from the covariance of the unknowns.
    pub standard_error: Vec<f64>,
    /// Standard deviation of another measurement from the fitted curve.
    pub prediction_error: Vec<f64>,
}

/// A compared value.
struct Compared {
    /// Row of the data.
    row: usize,
    /// Of `compare`.
    formula: usize,
    measured: f64,
    sigma: f64,
}

/// A run with its data.
struct Run {
    file: String,
    warnings: Vec<Diagnostic>,
    columns: Columns,
    study: Study,
    compared: Vec<Compared>,
    /// From columns, unknowns, parameters and quantities of the motion to the formulas.
    tape: Tape,
    slopes_by: Vec<(usize, usize)>,
    n_formulas: usize,
    kind: Kind,
}

enum Kind {
    Formulas,
    Positions {
        poses: Box<Poses>,
        drives: Tape,
        drive_slopes: Vec<(usize, usize)>,
        is_turn: Vec<bool>,
    },
    /// Outputs at the rows, by quantity, or on an even grid where columns come late.
    Motion {
        n_quantities: usize,
        times: Vec<f64>,
        grid: Option<[f64; 2]>,
        late: Vec<Option<usize>>,
    },
}

/// All runs as one problem.
struct Problem<'a> {
    runs: Vec<Run>,
    varied: Vec<Stated>,
    n_unknowns: usize,
    scale: Vec<f64>,
    is_exact: bool,
    watch: Watch<'a>,
}

/// Finds the unknowns from data.
///
/// # Errors
/// [`DesignError`] for what cannot be read, names that are unknown, and a start that does not close or run.
pub fn fit(
    source: &Source,
    data: &[DataFile],
    wish: &FitWish,
    watch: Watch<'_>,
) -> Result<Fit, DesignError> {
    if wish.compare.is_empty()
        || (wish.vary.is_empty() && wish.unknowns.is_empty())
        || data.is_empty()
    {
        let message = match (data.is_empty(), wish.compare.is_empty()) {
            (true, _) => "there are no data to fit",
            (_, true) => "nothing is compared with the data",
            _ => "nothing is unknown",
        };
        let help = if data.is_empty() { "name a file with `--data run.csv`" } else { EXAMPLE };
        return Err(DesignError::fault(codes::NOTHING_ASKED, message, help));
    }
    let loss = wish.loss.as_deref().unwrap_or("squares");
    let loss = Loss::named(loss, wish.scale).ok_or_else(|| {
        let message = format!("`{loss}` is no loss");
        DesignError::fault(
            codes::BAD_QUESTION,
            message,
            "write `squares`, `huber`, `soft_l1` or `cauchy`",
        )
    })?;

    // The unknowns with their starts.
    let is_geometry = !wish.drive.is_empty();
    let names: Vec<String> = wish.vary.iter().map(|(name, _)| name.clone()).collect();
    let mut varied = source.stated(&names, is_geometry)?;
    for (stated, (_, start)) in varied.iter_mut().zip(&wish.vary) {
        if let Some(start) = start {
            stated.value = value_of(start, source)?;
        }
    }
    let mut x: Vec<f64> = varied.iter().map(|stated| stated.value).collect();
    let of_measurement: Vec<String> = wish.unknowns.iter().map(|(name, _)| name.clone()).collect();
    for (_, start) in &wish.unknowns {
        x.push(value_of(start, source)?);
    }
    let scale: Vec<f64> = x.iter().map(|x| if x.abs() > 1e-6 { x.abs() } else { 1.0 }).collect();

    let runs = data.iter().map(|file| run(source, file, wish, &varied, &of_measurement));
    let runs = runs.collect::<Result<Vec<Run>, DesignError>>()?;
    let is_exact = !matches!(runs[0].kind, Kind::Motion { .. });
    let n_unknowns = of_measurement.len();
    let problem = Problem { runs, varied, n_unknowns, scale: scale.clone(), is_exact, watch };
    let start = x.clone();
    let Some(found) = least(&problem, x, &scale, loss, watch) else {
        if (watch.stop)() {
            return Err(DesignError::Stopped);
        }
        let message = "the model does not close and run at the values that the fit begins with";
        let help = "give values near to those of the data: `vary = { k = \"55 N/m\" }`";
        return Err(DesignError::fault(codes::NO_START, message, help));
    };

    // What is known, and how well.
    let size: Vec<f64> = found.x.iter().zip(&scale).map(|(x, s)| x.abs().max(*s)).collect();
    let tolerance = if is_exact { 1e-8 } else { 1e-6 };
    let known = knowledge(&found.slopes, &size, tolerance).ok_or(DesignError::Stopped)?;
    let n_values = found.residuals.len();
    let n_free = n_values.saturating_sub(known.rank);
    let sum: f64 = found.residuals.iter().map(|r| r * r).sum();
    let s2 = if n_free > 0 { sum / n_free as f64 } else { f64::NAN };
    let sigma_known =
        wish.compare.iter().all(|(column, _)| wish.sigma.iter().any(|(c, _)| c == column));
    let covariance = if sigma_known { known.covariance.clone() } else { &known.covariance * s2 };
    let all_names: Vec<String> = names.iter().chain(&of_measurement).cloned().collect();
    let n = all_names.len();
    let is_open = |k: usize| {
        known.without_effect.contains(&k) || known.null_vectors.iter().any(|v| v[k] != 0.0)
    };
    let error = |k: usize| covariance[(k, k)].sqrt();
    let unknowns: Vec<Unknown> = (0..n)
        .map(|k| Unknown {
            name: all_names[k].clone(),
            unit: problem.varied.get(k).map_or_else(String::new, |stated| stated.unit.clone()),
            start: start[k],
            estimate: found.x[k],
            standard_error: (!is_open(k)).then(|| error(k)),
        })
        .collect();
    let rows = |of: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..n).map(|i| (0..n).map(|j| of(i, j)).collect()).collect()
    };
    let open = Unidentifiable {
        rank: known.rank,
        without_effect: known.without_effect.iter().map(|&k| all_names[k].clone()).collect(),
        unidentifiable_together: groups(&known.null_vectors)
            .into_iter()
            .map(|group| group.into_iter().map(|k| all_names[k].clone()).collect())
            .collect(),
        null_vectors: known
            .null_vectors
            .iter()
            .map(|v| {
                (0..n).filter(|&k| v[k] != 0.0).map(|k| (all_names[k].clone(), v[k])).collect()
            })
            .collect(),
    };
    let patches: Vec<(String, String)> = problem
        .varied
        .iter()
        .zip(&wish.vary)
        .zip(&found.x)
        .map(|((stated, (_, start)), x)| {
            let unit =
                start.as_deref().and_then(Quantity::read).map(|q| q.unit).filter(|u| !u.is_empty());
            (stated.name.clone(), written(*x, &unit.unwrap_or_else(|| stated.unit.clone())))
        })
        .collect();
    Ok(Fit {
        warnings: problem.runs.iter().flat_map(|run| run.warnings.iter().cloned()).collect(),
        correlation: rows(&|i, j| {
            let product = error(i) * error(j);
            if product > 0.0 { covariance[(i, j)] / product } else { 0.0 }
        }),
        covariance: rows(&|i, j| covariance[(i, j)]),
        unknowns,
        open,
        n_values,
        n_free,
        rms: (sum / n_values.max(1) as f64).sqrt(),
        s2,
        sigma_known,
        converged: found.converged,
        stopped: (watch.stop)(),
        iterations: found.n_iterations,
        slopes: if is_exact { "exact" } else { "differences of fourth order" },
        curves: problem.curves(&found, (&covariance, s2), (loss, sigma_known), wish),
        model: source.with_values(&patches)?,
    })
}

fn value_of(text: &str, source: &Source) -> Result<f64, DesignError> {
    let value = Quantity::read(text).map(|quantity| quantity.value);
    value.ok_or_else(|| {
        let message = format!("`{text}` is no value to begin with");
        let help = "write a number with its unit, as in `\"55 N/m\"`";
        located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, text)
    })
}

/// Unknowns that share directions.
fn groups(vectors: &[Vec<f64>]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for vector in vectors {
        let mut own: Vec<usize> = (0..vector.len()).filter(|&k| vector[k] != 0.0).collect();
        groups.retain(|group| {
            let is_shared = group.iter().any(|k| own.contains(k));
            if is_shared {
                own.extend(group.iter().filter(|k| vector[**k] == 0.0));
            }
            !is_shared
        });
        own.sort_unstable();
        own.dedup();
        groups.push(own);
    }
    groups.sort();
    groups
}

/// Names in a formula that are no functions.
fn names_in(text: &str) -> Vec<String> {
    let is_unit = |word: &str| WrittenUnit::parse(word).is_some();
    let options = ParseOptions { is_unit: &is_unit, ..ParseOptions::default() };
    let Ok(syntax) = parse(text, &options) else { return Vec::new() };
    syntax.names().map(|(name, _)| name.to_owned()).collect()
}
