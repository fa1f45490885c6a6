//! `[fit]`: parameters, initial values and sensors from measured curves.
//!
//! Three kinds of comparisons: formulas of the columns alone; positions, each row at prescribed measures; the motion
//! in time, each row at its instant. The first two have exact slopes, the last differences of fourth order.

use std::collections::BTreeMap;

use bksim::expr::{Expr, ParseOptions, SymbolId, Tape, parse};
use bksim::model::Measure;
use bksim::model::file::{WrittenUnit, suggest};
use bksim_sweep::{Ending, Monitor, Row, Study};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::base::{Quantity, Source, Stated, Watch, written};
use crate::codes;
use crate::data::{Columns, DataFile, columns};
use crate::error::DesignError;
use crate::formula::formula;
use crate::least_squares::{Loss, Residuals, knowledge, least};
use crate::poses::Poses;
use crate::spec::{Written, located, section};

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
#[serde(untagged)]
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
    /// What the model asks in `[fit]`; nothing of a model without the section.
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

/// What the data leave open.
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
    /// What the data leave open.
    pub open: Unidentifiable,
    /// Number of compared values.
    pub n_values: usize,
    /// Degrees of freedom.
    pub n_free: usize,
    /// Root mean square of the differences, in standard deviations where these are known, else SI.
    pub rms: f64,
    /// Sum of the squares over the degrees of freedom; near one where the standard deviations are right.
    pub s2: f64,
    /// Whether standard deviations were given; else they are estimated from the differences.
    pub sigma_known: bool,
    /// Whether the iteration came to its end.
    pub converged: bool,
    /// Whether it was stopped.
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
    /// SI.
    pub measured: Vec<f64>,
    /// SI.
    pub fitted: Vec<f64>,
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
    let Some(found) = least(&problem, x, &scale, loss, watch.stop) else {
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
        curves: problem.curves(&found.x, wish),
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

/// A run ready to be compared.
fn run(
    source: &Source,
    file: &DataFile,
    wish: &FitWish,
    varied: &[Stated],
    unknowns: &[String],
) -> Result<Run, DesignError> {
    let columns = columns(file)?;
    let is_geometry = !wish.drive.is_empty();
    let column = |name: &str| {
        columns.named(name).ok_or_else(|| {
            let known: Vec<&str> = columns.names.iter().map(String::as_str).collect();
            let message = format!("`{}` has no column `{name}`", file.name);
            let fault = DesignError::fault(codes::BAD_DATA, message, suggest(name, &known));
            located(fault, &source.text, name)
        })
    };
    let mut compared = Vec::new();
    for (k, (name, _)) in wish.compare.iter().enumerate() {
        let at = column(name)?;
        let sigma = wish.sigma.iter().find(|(of, _)| of == name);
        let sigma = sigma.map_or(Ok(1.0), |(_, text)| value_of(text, source))?;
        if sigma <= 0.0 {
            let message = format!("the standard deviation of `{name}` is not above zero");
            return Err(DesignError::fault(codes::BAD_QUESTION, message, "give one above zero"));
        }
        for (row, values) in columns.rows.iter().enumerate() {
            if values[at].is_finite() {
                compared.push(Compared { row, formula: k, measured: values[at], sigma });
            }
        }
    }

    // Names of the motion: whatever is no column, unknown or parameter.
    let model = source.model(&[], is_geometry)?;
    let is_compared = |name: &str| wish.compare.iter().any(|(column, _)| column == name);
    let is_own = |name: &String| {
        // In what it is compared with, the name of a column is that of the motion: as in an exported log.
        (columns.named(name).is_some() && !is_compared(name))
            || unknowns.contains(name)
            || name == "pi"
            || model.parameters.iter().any(|p| p.name == *name)
    };
    let mut quantities: Vec<String> = Vec::new();
    for (_, text) in &wish.compare {
        quantities.extend(names_in(text).into_iter().filter(|name| !is_own(name)));
    }
    quantities.sort();
    quantities.dedup();
    let in_motion = !quantities.is_empty() && !is_geometry;

    // The motion at the instants of the rows, or on a grid.
    let t_column = ["t", "time"].iter().find_map(|name| columns.named(name));
    let mut times = Vec::new();
    let mut grid = None;
    let mut outputs = Vec::new();
    let mut late = Vec::new();
    let mut source = source.clone();
    if in_motion {
        let Some(t) = t_column else { return Err(column("t").expect_err("there is none")) };
        times = columns.rows.iter().map(|row| row[t]).collect();
        if let Some(row) = times.iter().position(|t| !t.is_finite()) {
            let message = format!("row {} of `{}` has no time", row + 1, file.name);
            return Err(DesignError::fault(codes::BAD_DATA, message, "leave the row out"));
        }
        let t_end = times.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        if t_end > model.solve.t_end {
            source.changes.t_end = Some(t_end);
        }
        late = wish
            .compare
            .iter()
            .map(|(name, _)| {
                let of = wish.delay.iter().find(|(of, _)| of == name)?;
                unknowns.iter().position(|unknown| *unknown == of.1)
            })
            .collect();
        let instants = if late.iter().any(Option::is_some) {
            let n = (8 * times.len()).clamp(400, 4000);
            let t_start = model.solve.t_start;
            let t_end = source.changes.t_end.unwrap_or(model.solve.t_end);
            let step = (t_end - t_start) / n as f64;
            grid = Some([t_start, step]);
            (0..=n).map(|k| if k == n { t_end } else { t_start + step * k as f64 }).collect()
        } else {
            times.clone()
        };
        for quantity in &quantities {
            outputs.extend(instants.iter().map(|t| format!("{quantity}@{t}")));
        }
    }
    if outputs.is_empty() {
        outputs.push("0".to_owned());
    }
    let study = source.study(varied, &file.set, &outputs, is_geometry || !in_motion)?;

    // Formulas as functions.
    let mechanism = study.mechanism();
    let (model, pool) = (&mechanism.model, &mechanism.model.pool);
    let symbol = |name: &String| (name.clone(), pool.symbol(&format!("data {name}")));
    let mut own: Vec<(String, Expr)> = columns.names.iter().map(symbol).collect();
    own.extend(unknowns.iter().map(symbol));
    let of_motion = |name: &String| (name.clone(), pool.symbol(&format!("motion {name}")));
    let of_motion: Vec<(String, Expr)> = quantities.iter().map(of_motion).collect();
    let with_motion = [own.clone(), of_motion].concat();
    let id = |(_, expr): &(String, Expr)| pool.symbol_id(*expr).expect("a symbol");
    let parameters: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let read = |all: &[(String, String)], own: &[(String, Expr)]| {
        let one = |(_, text): &(String, String)| {
            let system = is_geometry.then_some(&mechanism.system);
            formula(text, model, system, own).map_err(|fault| located(fault, &source.text, text))
        };
        all.iter().map(one).collect::<Result<Vec<_>, _>>()
    };
    let names = if in_motion { &with_motion } else { &own };
    let first_of_motion = own.len();
    let is_seen =
        |(k, (name, _)): &(usize, &(String, Expr))| *k >= first_of_motion || !is_compared(name);
    let seen: Vec<(String, Expr)> =
        names.iter().enumerate().filter(is_seen).map(|(_, one)| one.clone()).collect();
    let formulas: Vec<Expr> = read(&wish.compare, &seen)?.into_iter().map(|f| f.expr).collect();
    let compile = |formulas: &[Expr], inputs: &[SymbolId]| {
        let jacobian = pool.jacobian(formulas, inputs);
        let entries = jacobian.entries.iter().map(|entry| entry.2);
        let all: Vec<Expr> = formulas.iter().copied().chain(entries).collect();
        let tape = Tape::compile(pool, &all, inputs, &[])
            .map_err(|error| DesignError::fault(codes::BAD_QUESTION, error.to_string(), EXAMPLE))?;
        Ok::<_, DesignError>((
            tape,
            jacobian.entries.iter().map(|&(r, c, _)| (r, c)).collect::<Vec<_>>(),
        ))
    };
    let own_ids: Vec<SymbolId> = own.iter().map(id).collect();
    let (tape, slopes_by, kind) = if is_geometry {
        let mut prescribed = Vec::new();
        for (name, _) in &wish.drive {
            let measure =
                Measure::named(model, name).filter(|m| !m.is_velocity()).ok_or_else(|| {
                    let known: Vec<String> =
                        model.joints.iter().map(|j| format!("{}.angle", j.name)).collect();
                    let known: Vec<&str> = known.iter().map(String::as_str).collect();
                    let message = format!("the model has no position `{name}` to drive");
                    located(
                        DesignError::fault(codes::UNKNOWN_QUANTITY, message, suggest(name, &known)),
                        &source.text,
                        name,
                    )
                })?;
            prescribed.push((name.clone(), measure));
        }
        let targets: Vec<Expr> = read(&wish.drive, &own)?.into_iter().map(|f| f.expr).collect();
        let poses = Poses::new(&mechanism, &prescribed, &formulas, &own_ids)?;
        let inputs = [&own_ids[..], &parameters].concat();
        let (drives, drive_slopes) = compile(&targets, &inputs)?;
        let turns = |text: &str| {
            let mut measured =
                names_in(text).into_iter().filter_map(|name| Measure::named(model, &name));
            measured.next().is_some_and(|m| m.unit(model) == "rad")
                && measured.all(|m| m.unit(model) == "rad")
        };
        let is_turn = wish.compare.iter().map(|(_, text)| turns(text)).collect();
        let (tape, slopes_by) = compile(&[], &[])?;
        (tape, slopes_by, Kind::Positions { poses: Box::new(poses), drives, drive_slopes, is_turn })
    } else {
        let ids: Vec<SymbolId> = names.iter().map(id).collect();
        let (tape, slopes_by) = compile(&formulas, &[&ids[..], &parameters].concat())?;
        let kind = if in_motion {
            Kind::Motion { n_quantities: quantities.len(), times, grid, late }
        } else {
            Kind::Formulas
        };
        (tape, slopes_by, kind)
    };
    Ok(Run {
        file: file.name.clone(),
        columns,
        study,
        compared,
        tape,
        slopes_by,
        n_formulas: formulas.len(),
        kind,
    })
}

/// Six points of an even grid around an instant, as weights of their values.
fn interpolated(values: &[f64], [t_start, step]: [f64; 2], t: f64) -> f64 {
    let at = (t - t_start) / step;
    let last = values.len() - 6;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the grid")]
    let first = ((at.floor() - 2.0).max(0.0) as usize).min(last);
    let at = at - first as f64;
    let weight = |k: usize| {
        let others = (0..6).filter(|other| *other != k);
        others.map(|other| (at - other as f64) / (k as f64 - other as f64)).product::<f64>()
    };
    (0..6).map(|k| weight(k) * values[first + k]).sum()
}

/// An angle without its whole turns.
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::TAU;
    angle - TAU * (angle / TAU).round()
}

impl Run {
    /// Compared values less their formulas, in standard deviations, for many sets of unknowns.
    fn residuals(
        &self,
        points: &[Vec<f64>],
        n_varied: usize,
        watch: Watch<'_>,
    ) -> Vec<Option<Vec<f64>>> {
        let of_model = |x: &Vec<f64>| x[..n_varied].to_vec();
        let motions: Vec<Option<Vec<f64>>> = if let Kind::Motion { .. } = self.kind {
            // Each motion once, however many unknowns of the measurement vary.
            let mut unique: Vec<Vec<f64>> = points.iter().map(of_model).collect();
            unique.sort_by(|a, b| {
                a.iter()
                    .zip(b)
                    .map(|(a, b)| a.total_cmp(b))
                    .find(|o| o.is_ne())
                    .unwrap_or(std::cmp::Ordering::Equal)
            });
            unique.dedup();
            let monitor = Monitor { stop: watch.stop, progress: &|_| () };
            let rows = self.study.rows_at(&unique, 0, &monitor).ok().flatten().unwrap_or_default();
            let outputs = |row: &Row| (row.ending == Ending::Done).then(|| row.outputs.clone());
            let of = |x: &Vec<f64>| {
                let place = unique.iter().position(|known| *known == of_model(x))?;
                rows.get(place).and_then(outputs)
            };
            points.iter().map(of).collect()
        } else {
            points.iter().map(|_| Some(Vec::new())).collect()
        };
        let one = |(x, motion): (&Vec<f64>, Option<Vec<f64>>)| {
            let found = self.fitted(x, n_varied, &motion?)?;
            let off = |(compared, fitted): (&Compared, f64)| {
                (fitted - compared.measured) / compared.sigma
            };
            let all: Vec<f64> = self.compared.iter().zip(found).map(off).collect();
            all.iter().all(|r| r.is_finite()).then_some(all)
        };
        points.iter().zip(motions).map(one).collect()
    }

    /// The formulas of all compared values; angles in the turn of what was measured.
    fn fitted(&self, x: &[f64], n_varied: usize, motion: &[f64]) -> Option<Vec<f64>> {
        if let Kind::Positions { .. } = self.kind {
            return self.positions(x, n_varied).map(|(values, _)| values);
        }
        let parameters = self.study.parameters_at(&x[..n_varied])?;
        let mut space = self.tape.workspace(&[]);
        let mut values = vec![0.0; self.tape.n_outputs()];
        let mut all = Vec::with_capacity(self.compared.len());
        for compared in &self.compared {
            let row = compared.row;
            let mut inputs = [&self.columns.rows[row][..], &x[n_varied..]].concat();
            if let Kind::Motion { n_quantities, times, grid, late } = &self.kind {
                let n = motion.len() / n_quantities;
                for k in 0..*n_quantities {
                    let own = &motion[k * n..(k + 1) * n];
                    inputs.push(match grid {
                        Some(grid) => {
                            let late = late[compared.formula].map_or(0.0, |k| x[n_varied + k]);
                            interpolated(own, *grid, times[row] - late)
                        }
                        None => own[row],
                    });
                }
            }
            inputs.extend(&parameters);
            self.tape.evaluate(&mut space, &inputs, &mut values);
            all.push(values[compared.formula]);
        }
        Some(all)
    }

    /// Derivatives of parameters by what varies: one for itself, differences for those that follow from it.
    fn by_varied(&self, x: &[f64], n_varied: usize) -> Option<DMatrix<f64>> {
        let varied = &x[..n_varied];
        let here = self.study.parameters_at(varied)?;
        let mut by = DMatrix::zeros(here.len(), n_varied);
        let names: Vec<String> = self.study.input_columns().into_iter().map(|c| c.name).collect();
        let model = self.study.mechanism().model;
        for k in 0..n_varied {
            let step = 1e-4 * if x[k] == 0.0 { 1.0 } else { x[k].abs() };
            let moved = |off: f64| {
                let mut x = varied.to_vec();
                x[k] += off;
                self.study.parameters_at(&x)
            };
            let (above, below) = (moved(step)?, moved(-step)?);
            for (i, parameter) in model.parameters.iter().enumerate() {
                by[(i, k)] = if parameter.name == names[k] {
                    1.0
                } else {
                    (above[i] - below[i]) / (2.0 * step)
                };
            }
        }
        Some(by)
    }

    /// The values of formulas of positions with their slopes by all unknowns.
    fn positions(&self, x: &[f64], n_varied: usize) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let Kind::Positions { poses, drives, drive_slopes, is_turn } = &self.kind else {
            return None;
        };
        let parameters = self.study.parameters_at(&x[..n_varied])?;
        let by_varied = self.by_varied(x, n_varied)?;
        let n_columns = self.columns.names.len();
        let n_own = n_columns + x.len() - n_varied;
        let mut solver = poses.solver();
        let mut pose = solver.follow(&poses.start, &parameters, &poses.start.u).ok()?;
        let mut space = drives.workspace(&[]);
        let mut targets = vec![0.0; drives.n_outputs()];
        let n_u = poses.start.u.len();
        let mut slopes = DMatrix::zeros(self.compared.len(), x.len());
        let mut values = vec![0.0; self.compared.len()];
        let mut last = usize::MAX;
        let mut found = None;
        // Rows in their order, whatever is compared.
        let mut order: Vec<usize> = (0..self.compared.len()).collect();
        order.sort_by_key(|&i| self.compared[i].row);
        for i in order {
            let Compared { row, formula, measured, .. } = self.compared[i];
            let own = [&self.columns.rows[row][..], &x[n_varied..]].concat();
            if row != last {
                let inputs = [&own[..], &parameters].concat();
                drives.evaluate(&mut space, &inputs, &mut targets);
                pose = solver.follow(&pose, &parameters, &targets[..n_u]).ok()?;
                found = solver.outputs(&pose, &own);
                last = row;
            }
            let at = found.as_ref()?;
            let value = at.values[formula];
            let off = value - measured;
            values[i] = if is_turn[formula] { measured + wrapped(off) } else { value };
            // By drives, then what these are by; by parameters; by own unknowns.
            let mut by_own = at.by_own.row(formula).into_owned();
            let mut by_p = at.by_p.row(formula).into_owned();
            for (&(drive, column), slope) in drive_slopes.iter().zip(&targets[n_u..]) {
                let through = at.by_u[(formula, drive)] * slope;
                if column < n_own {
                    by_own[column] += through;
                } else {
                    by_p[column - n_own] += through;
                }
            }
            let of_parameters = by_p * &by_varied;
            for k in 0..n_varied {
                slopes[(i, k)] = of_parameters[k];
            }
            for k in n_varied..x.len() {
                slopes[(i, k)] = by_own[n_columns + k - n_varied];
            }
        }
        Some((values, slopes))
    }

    /// Exact slopes of formulas of columns alone.
    fn of_formulas(&self, x: &[f64], n_varied: usize) -> Option<DMatrix<f64>> {
        let parameters = self.study.parameters_at(&x[..n_varied])?;
        let by_varied = self.by_varied(x, n_varied)?;
        let n_columns = self.columns.names.len();
        let n_own = n_columns + x.len() - n_varied;
        let mut space = self.tape.workspace(&[]);
        let mut values = vec![0.0; self.tape.n_outputs()];
        let mut slopes = DMatrix::zeros(self.compared.len(), x.len());
        for (i, compared) in self.compared.iter().enumerate() {
            let inputs =
                [&self.columns.rows[compared.row][..], &x[n_varied..], &parameters].concat();
            self.tape.evaluate(&mut space, &inputs, &mut values);
            for (&(formula, column), slope) in self.slopes_by.iter().zip(&values[self.n_formulas..])
            {
                if formula != compared.formula || column < n_columns {
                    continue;
                }
                if column < n_own {
                    slopes[(i, n_varied + column - n_columns)] += slope;
                } else {
                    for k in 0..n_varied {
                        slopes[(i, k)] += slope * by_varied[(column - n_own, k)];
                    }
                }
            }
        }
        Some(slopes)
    }
}

impl Problem<'_> {
    fn n_varied(&self) -> usize {
        self.varied.len()
    }

    fn many(&self, points: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        let by_run: Vec<_> = self
            .runs
            .iter()
            .map(|run| run.residuals(points, self.n_varied(), self.watch))
            .collect();
        let at = |k: usize| {
            let all: Option<Vec<Vec<f64>>> = by_run.iter().map(|run| run[k].clone()).collect();
            Some(all?.concat())
        };
        (0..points.len()).map(at).collect()
    }

    /// Measured and fitted values.
    fn curves(&self, x: &[f64], wish: &FitWish) -> Vec<Curve> {
        let mut curves = Vec::new();
        for run in &self.runs {
            let Some(residuals) =
                run.residuals(&[x.to_vec()], self.n_varied(), self.watch).pop().flatten()
            else {
                continue;
            };
            let at = match &run.kind {
                Kind::Motion { .. } => {
                    ["t", "time"].iter().find_map(|name| run.columns.named(name))
                }
                Kind::Positions { .. } => {
                    let names =
                        wish.drive.first().map(|(_, text)| names_in(text)).unwrap_or_default();
                    names.iter().find_map(|name| run.columns.named(name))
                }
                Kind::Formulas => ["t", "time"].iter().find_map(|name| run.columns.named(name)),
            };
            for (k, (column, _)) in wish.compare.iter().enumerate() {
                let own =
                    || run.compared.iter().zip(&residuals).filter(move |(c, _)| c.formula == k);
                curves.push(Curve {
                    file: run.file.clone(),
                    column: column.clone(),
                    at: own()
                        .map(|(c, _)| {
                            at.map_or((c.row + 1) as f64, |at| run.columns.rows[c.row][at])
                        })
                        .collect(),
                    measured: own().map(|(c, _)| c.measured).collect(),
                    fitted: own().map(|(c, r)| c.measured + r * c.sigma).collect(),
                });
            }
        }
        curves
    }
}

impl Residuals for Problem<'_> {
    fn at(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.many(&[x.to_vec()]).pop().flatten()
    }

    fn slopes(&self, x: &[f64]) -> Option<DMatrix<f64>> {
        debug_assert_eq!(x.len(), self.n_varied() + self.n_unknowns);
        (self.watch.reached)("slopes", 0.0);
        if self.is_exact {
            let mut all: Option<DMatrix<f64>> = None;
            for run in &self.runs {
                let mut own = match run.kind {
                    Kind::Positions { .. } => run.positions(x, self.n_varied())?.1,
                    _ => run.of_formulas(x, self.n_varied())?,
                };
                for (i, compared) in run.compared.iter().enumerate() {
                    own.row_mut(i).scale_mut(1.0 / compared.sigma);
                }
                all = Some(match all {
                    None => own,
                    Some(above) => {
                        let n = above.nrows();
                        let mut joined = above.resize_vertically(n + own.nrows(), 0.0);
                        joined.rows_mut(n, own.nrows()).copy_from(&own);
                        joined
                    }
                });
            }
            return all;
        }
        // Differences of fourth order, all runs at once.
        const STENCIL: [(f64, f64); 4] =
            [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
        let step = |k: usize| 1e-3 * self.scale[k];
        let moved = |k: usize, at: f64| {
            let mut x = x.to_vec();
            x[k] += at * step(k);
            x
        };
        let points: Vec<Vec<f64>> =
            (0..x.len()).flat_map(|k| STENCIL.map(|(at, _)| moved(k, at))).collect();
        let found: Option<Vec<Vec<f64>>> = self.many(&points).into_iter().collect();
        let found = found?;
        let m = found.first()?.len();
        Some(DMatrix::from_fn(m, x.len(), |i, k| {
            let terms = STENCIL.iter().zip(&found[4 * k..4 * k + 4]);
            terms.map(|((_, weight), at)| weight * at[i]).sum::<f64>() / step(k)
        }))
    }
}
