//! The common ground of the facade's tests: models from files and text, expressions measured on samples,
//! comparisons that print the numbers that matter.

#![allow(dead_code, reason = "every program of tests uses its own part of it")]

pub(crate) mod elements;
pub(crate) mod large;

use std::path::{Path, PathBuf};

use bksim::expr::{Expr, Pool, SymbolId, Tape};
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Limits, Source, expand, read};
use bksim::model::{Measure, Model};
use bksim::sim::run::Sample;
use bksim::{Mechanism, Motion};

/// A place below the root of the repository.
pub(crate) fn path(relative: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(relative)
}

/// Names of the example models.
pub(crate) fn example_names() -> Vec<String> {
    let folders = std::fs::read_dir(path("examples")).expect("the examples are there");
    let mut names: Vec<String> = folders
        .map(|entry| entry.expect("a readable entry").path())
        .filter(|folder| folder.join("model.toml").is_file())
        .map(|folder| folder.file_name().expect("a name").to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// The text of an example's model, with its parts.
pub(crate) fn example_text(name: &str) -> String {
    let folder = path("examples").join(name);
    let mut read = |file: &str| std::fs::read(folder.join(file)).map_err(|e| e.to_string());
    let text = std::fs::read_to_string(folder.join("model.toml"));
    let text = text.unwrap_or_else(|e| panic!("{name}: {e}"));
    match expand("model.toml", &text, Limits::default(), &mut read) {
        Some(whole) => {
            assert!(whole.faults.is_empty(), "{}", messages(&whole.faults));
            whole.text
        }
        None => text,
    }
}

/// Reads a model that has no fault.
pub(crate) fn model(text: &str) -> Model {
    let reading = read(&Source::new(text, "test"));
    reading.model.unwrap_or_else(|| panic!("rejected: {}", messages(&reading.diagnostics)))
}

/// Reads an example.
pub(crate) fn example(name: &str) -> Model {
    model(&example_text(name))
}

/// Derives the equations of a model.
pub(crate) fn derive(model: Model) -> Mechanism {
    Mechanism::derive(model, Vec::new()).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs a mechanism to its end.
pub(crate) fn solve(mechanism: &Mechanism) -> Motion {
    mechanism.solve().unwrap_or_else(|e| panic!("{}: {e}", mechanism.model.name))
}

/// The text of a model with a method of integration.
pub(crate) fn with_method(text: &str, method: &str) -> String {
    text.replace("[solve]\n", &format!("[solve]\nmethod = \"{method}\"\n"))
}

/// The value of a named signal on a sample.
#[track_caller]
pub(crate) fn signal(mechanism: &Mechanism, sample: &Sample, name: &str) -> f64 {
    let place = mechanism.model.named_signals.iter().position(|signal| signal.name == name);
    sample.signals[place.unwrap_or_else(|| panic!("no signal `{name}`"))]
}

/// Codes and messages of diagnostics in one line.
pub(crate) fn messages(diagnostics: &[Diagnostic]) -> String {
    let line = |d: &Diagnostic| format!("[{}] {}", d.code.0, d.message);
    diagnostics.iter().map(line).collect::<Vec<_>>().join("; ")
}

/// The sample at a time.
pub(crate) fn at(motion: &Motion, t: f64) -> &Sample {
    let nearest = |a: &&Sample, b: &&Sample| (a.t - t).abs().total_cmp(&(b.t - t).abs());
    let sample = motion.samples.iter().min_by(nearest).expect("the start at least");
    assert!((sample.t - t).abs() < 1e-9, "no sample at t = {t}; the nearest is at {}", sample.t);
    sample
}

/// Force and moment on the successor of the joint with this name, world axes.
pub(crate) fn reaction(mechanism: &Mechanism, sample: &Sample, joint: &str) -> [f64; 6] {
    let names = &mechanism.compiled.joints;
    let place = names.iter().position(|name| name == joint);
    sample.reactions[place.unwrap_or_else(|| panic!("no joint `{joint}` among {names:?}"))]
}

/// Index of the coordinate with this name.
pub(crate) fn coordinate(mechanism: &Mechanism, name: &str) -> usize {
    let known = &mechanism.compiled.coordinates;
    let place = known.iter().position(|c| c.name == name);
    place.unwrap_or_else(|| panic!("no coordinate `{name}` among {known:?}"))
}

/// Expressions of coordinates, velocities, accelerations, multipliers, parameters and time,
/// written as text and measured on samples.
pub(crate) struct Probe {
    tape: Tape,
    parameters: Vec<f64>,
    n_measures: usize,
}

impl Probe {
    /// Compiles each text, and its first and second time derivatives.
    pub(crate) fn new(mechanism: &Mechanism, texts: &[&str]) -> Self {
        let pool = &mechanism.model.pool;
        let coordinates = mechanism.system.coordinates();
        let mut rates: Vec<(SymbolId, Expr)> = vec![(mechanism.model.time, pool.one())];
        for c in coordinates {
            rates.extend([(c.q, pool.symbol_expr(c.v)), (c.v, pool.symbol_expr(c.a))]);
        }
        let values: Vec<Expr> = texts.iter().map(|text| parse(pool, text)).collect();
        let derive = |of: &[Expr]| -> Vec<Expr> {
            of.iter().map(|&e| pool.total_derivative(e, &rates)).collect()
        };
        let first = derive(&values);
        let second = derive(&first);
        let inputs: Vec<SymbolId> = std::iter::once(mechanism.model.time)
            .chain(coordinates.iter().map(|c| c.q))
            .chain(coordinates.iter().map(|c| c.v))
            .chain(coordinates.iter().map(|c| c.a))
            .chain(mechanism.system.constraints.iter().map(|c| c.lambda))
            .collect();
        let symbols: Vec<SymbolId> = mechanism.model.parameters.iter().map(|p| p.symbol).collect();
        let tape = Tape::compile(pool, &[values, first, second].concat(), &inputs, &symbols)
            .unwrap_or_else(|e| panic!("{texts:?}: {e}"));
        Self { tape, parameters: mechanism.parameters.clone(), n_measures: texts.len() }
    }

    /// Values, rates and accelerations of the measures on a sample.
    pub(crate) fn at(&self, sample: &Sample) -> [Vec<f64>; 3] {
        let inputs = [&[sample.t], &sample.q[..], &sample.v, &sample.a, &sample.lambda].concat();
        let mut out = vec![0.0; 3 * self.n_measures];
        self.tape.evaluate(&mut self.tape.workspace(&self.parameters), &inputs, &mut out);
        std::array::from_fn(|k| out[k * self.n_measures..(k + 1) * self.n_measures].to_vec())
    }
}

/// Measures by their names in a model file, on samples.
pub(crate) struct Measures {
    tape: Tape,
    parameters: Vec<f64>,
}

impl Measures {
    /// Compiles the measures of these names.
    pub(crate) fn new(mechanism: &Mechanism, names: &[&str]) -> Self {
        let Mechanism { model, system, .. } = mechanism;
        let measure = |name: &&str| {
            let found = Measure::named(model, name).unwrap_or_else(|| panic!("no `{name}`"));
            system.kinematics.measure(model, found)
        };
        let outputs: Vec<Expr> = names.iter().map(measure).collect();
        let coordinates = system.coordinates().iter();
        let [q, v, a] = [coordinates.clone(), coordinates.clone(), coordinates];
        let rates = v.map(|c| c.v).chain(a.map(|c| c.a));
        let inputs: Vec<SymbolId> = q.map(|c| c.q).chain(rates).collect();
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let tape = Tape::compile(&model.pool, &outputs, &inputs, &symbols).expect("measures");
        Self { tape, parameters: mechanism.parameters.clone() }
    }

    /// Their values on a sample.
    pub(crate) fn at(&self, sample: &Sample) -> Vec<f64> {
        let mut out = vec![0.0; self.tape.n_outputs()];
        let inputs = [&sample.q[..], &sample.v, &sample.a].concat();
        self.tape.evaluate(&mut self.tape.workspace(&self.parameters), &inputs, &mut out);
        out
    }
}

/// Parses text that is correct.
pub(crate) fn parse(pool: &Pool, text: &str) -> Expr {
    pool.parse(text).unwrap_or_else(|e| panic!("`{text}`: {e}"))
}

/// A relative and an absolute tolerance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Within {
    /// Relative to the expected magnitude.
    pub(crate) relative: f64,
    /// In the unit of the quantity.
    pub(crate) absolute: f64,
}

/// Asserts |found − expected| ≤ absolute + relative·|expected|.
#[track_caller]
pub(crate) fn close(what: &str, found: f64, expected: f64, within: Within) {
    let error = (found - expected).abs();
    let allowed = within.absolute + within.relative * expected.abs();
    assert!(
        error <= allowed,
        "{what}: found {found:.17e}, expected {expected:.17e}, off by {error:.2e} > {allowed:.2e}"
    );
}

/// [`close`] for each pair of two equally long lists.
#[track_caller]
pub(crate) fn all_close(what: &str, found: &[f64], expected: &[f64], within: Within) {
    assert_eq!(found.len(), expected.len(), "{what}: {found:?} against {expected:?}");
    for (k, (&found, &expected)) in found.iter().zip(expected).enumerate() {
        close(&format!("{what}[{k}]"), found, expected, within);
    }
}

/// Slope of ln(error) over ln(step), fitted by least squares.
pub(crate) fn fitted_order(steps: &[f64], errors: &[f64]) -> f64 {
    let n = steps.len() as f64;
    let x: Vec<f64> = steps.iter().map(|h| h.ln()).collect();
    let y: Vec<f64> = errors.iter().map(|e| e.ln()).collect();
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    covariance / x.iter().map(|x| (x - mean_x).powi(2)).sum::<f64>()
}

/// Largest |found − expected| / (1 + |expected|): in the weights of equal tolerances rtol = atol.
pub(crate) fn weighted_error(found: &[f64], expected: &[f64]) -> f64 {
    let pairs = found.iter().zip(expected);
    pairs.map(|(a, b)| (a - b).abs() / (1.0 + b.abs())).fold(0.0, f64::max)
}

/// Numbers in two digits each.
pub(crate) fn brief(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:.1e}")).collect::<Vec<_>>().join(" ")
}
