//! Questions besides motion in time: a function for each, whose answer is that of the command of its name.

use bksim::analysis::{
    About, Actuators, AnalysisError, Channels, KinematicsOptions, LimitsRequest, Motion,
    MotorCurve, assembly_panels, balanced, bode, closing, compliances, curves, doctor, inverse,
    kinematics_along, letters, limits, linearize, modes, singular_poses, statics, statics_over,
    workspaces,
};
use bksim::model::Model;
use bksim::model::file::{ShownUnits, Source};
use bksim::panels::Sheet;
use bksim_scene::Theme;
use bksim_studio::questions::{self, Answer};
use numpy::PyArray2;
use numpy::ndarray::Array2;
use pyo3::prelude::*;

use crate::arrays::table;
use crate::engine::Engine;
use crate::fault::{Fault, guard, warn};

/// The object of `--json`, the text, names and units of the columns, and a row of the array for each column.
type Told<'py> = (String, String, Vec<String>, Vec<String>, Bound<'py, PyArray2<f64>>);

/// Asks about the model with its present values.
fn ask<'py>(
    py: Python<'py>,
    engine: &Engine,
    question: impl FnOnce(&str, Model) -> Result<Answer, AnalysisError> + Send,
) -> PyResult<Told<'py>> {
    let answer = guard(py, || {
        let mechanism = engine.mechanism();
        let mut model = mechanism.model;
        for (parameter, value) in model.parameters.iter_mut().zip(&mechanism.parameters) {
            parameter.value = *value;
        }
        let name = model.name.clone();
        question(&name, model).map_err(|error| Fault::model(engine.source(), &error.diagnostics()))
    })?;
    let Answer { json, text, table: found, .. } = answer;
    let (n_rows, n_columns) = (found.rows.len(), found.columns.len());
    let values =
        Array2::from_shape_fn((n_columns, n_rows), |(column, row)| found.rows[row][column]);
    let names = found.columns.iter().map(|column| column.name.clone()).collect();
    let units = found.columns.into_iter().map(|column| column.unit).collect();
    Ok((json.to_string(), text, names, units, table(py, values)))
}

/// The state of a word.
fn about(at: &str) -> PyResult<About> {
    at.parse::<About>()
        .map_err(|words| pyo3::exceptions::PyValueError::new_err(format!("at = {at:?}: {words}")))
}

/// Positions with their rates over a range.
#[pyfunction]
pub(crate) fn kinematics_of(
    py: Python<'_>,
    engine: Py<Engine>,
    drive: Vec<(String, String)>,
    rates: [Vec<String>; 2],
    along: (bool, Option<usize>, bool),
) -> PyResult<Told<'_>> {
    ask(py, engine.get(), move |name, model| {
        let [rate, acceleration] = &rates;
        let (through, branch, has_jerk) = along;
        let prescribed =
            questions::kinematics::prescribed(&model, &drive, [rate, acceleration], through)?;
        let prescribed = prescribed.ok_or(AnalysisError::NDrives { n_free: 1, n_driven: 0 })?;
        let found = kinematics_along(model, &prescribed, KinematicsOptions { branch, has_jerk })?;
        Ok(questions::kinematics::told_range(name, found, true))
    })
}

/// Values of parameters with which the start closes.
#[pyfunction]
pub(crate) fn closing_of(
    py: Python<'_>,
    engine: Py<Engine>,
    solve: Vec<String>,
) -> PyResult<Told<'_>> {
    ask(py, engine.get(), move |name, model| {
        Ok(questions::kinematics::told_closing(name, &closing(model, &solve)?))
    })
}

/// Ranges, limit positions, dead points, transmission angles.
#[pyfunction]
pub(crate) fn limits_of(
    py: Python<'_>,
    engine: Py<Engine>,
    drive: Option<String>,
    outputs: Vec<String>,
    all_assemblies: bool,
) -> PyResult<Told<'_>> {
    let request = LimitsRequest { drive, outputs, all_assemblies };
    ask(py, engine.get(), move |name, model| {
        Ok(questions::limits::told_limits(name, &limits(model, &request)?))
    })
}

/// Ways of points, instant centres and centrodes, swept regions.
#[pyfunction]
pub(crate) fn curves_of(
    py: Python<'_>,
    engine: Py<Engine>,
    points: Vec<String>,
    centrodes: Vec<String>,
    swept: Vec<String>,
    all_assemblies: bool,
) -> PyResult<Told<'_>> {
    ask(py, engine.get(), move |name, model| {
        let request = questions::curves::request(&points, &centrodes, &swept, all_assemblies);
        Ok(questions::curves::told(name, &curves(model, &request)?))
    })
}

/// Regions that points of mechanisms with several free motions reach.
#[pyfunction]
pub(crate) fn workspaces_of(
    py: Python<'_>,
    engine: Py<Engine>,
    points: Vec<String>,
) -> PyResult<Told<'_>> {
    ask(py, engine.get(), move |name, model| {
        Ok(questions::curves::told_workspaces(name, &workspaces(model, &points)?))
    })
}

/// The ways in which the start closes, and a picture of them as SVG.
#[pyfunction]
pub(crate) fn assemblies_of(py: Python<'_>, engine: Py<Engine>) -> PyResult<(Told<'_>, String)> {
    let mut svg = String::new();
    let told = ask(py, engine.get(), |name, model| {
        let (found, panels) = assembly_panels(model)?;
        svg = Sheet::of(&panels, Theme::LIGHT).moving(name);
        Ok(questions::kinematics::told_assemblies(name, &found))
    })?;
    Ok((told, svg))
}

/// Equilibria: all, over a parameter, or the start balanced by parameters.
#[pyfunction]
pub(crate) fn static_of(
    py: Python<'_>,
    engine: Py<Engine>,
    by: Vec<String>,
    over: Option<(String, String)>,
    solve: Vec<String>,
    reactions: (Pairs, Pairs),
) -> PyResult<Told<'_>> {
    let (compliance, bound) = reactions;
    ask(py, engine.get(), move |name, mut model| {
        use questions::statics::{bounds, range, told, told_balanced, told_over};
        model.compliances = compliances(&model, &compliance)?;
        if let Some((parameter, values)) = &over {
            let range = range(&model, parameter, values)?;
            return Ok(told_over(name, &statics_over(model, (parameter, range), &by)?));
        }
        if solve.is_empty() {
            let bounds = bounds(&model, &bound)?;
            return Ok(told(name, &statics(model, &by, &bounds)?));
        }
        Ok(told_balanced(name, &balanced(model, &solve, &by)?))
    })
}

/// A, B, C and D.
#[pyfunction]
pub(crate) fn linearize_of<'py>(
    py: Python<'py>,
    engine: Py<Engine>,
    at: &str,
    channels: [Vec<String>; 3],
    in_letters: bool,
) -> PyResult<Told<'py>> {
    let about = about(at)?;
    let units = ShownUnits::of_model(&engine.get().source().text);
    let [inputs, outputs, states] = channels;
    let channels = Channels { inputs, outputs, states };
    ask(py, engine.get(), move |name, model| {
        let twin = in_letters.then(|| model.snapshot());
        let mut answer =
            questions::linearize::told(name, &units, &linearize(model, about, &channels)?);
        if let Some(twin) = twin {
            let written = letters(twin.to_model(), &channels)?;
            questions::linearize::add_letters(&mut answer, written.as_ref());
        }
        Ok(answer)
    })
}

/// Frequencies, damping and shapes.
#[pyfunction]
pub(crate) fn modes_of<'py>(py: Python<'py>, engine: Py<Engine>, at: &str) -> PyResult<Told<'py>> {
    let about = about(at)?;
    let units = ShownUnits::of_model(&engine.get().source().text);
    ask(py, engine.get(), move |name, model| {
        Ok(questions::modes::told(name, &units, &modes(model, about)?))
    })
}

/// Frequency response, poles and zeros.
#[pyfunction]
pub(crate) fn bode_of<'py>(
    py: Python<'py>,
    engine: Py<Engine>,
    at: &str,
    channels: [Vec<String>; 2],
    omega: Option<String>,
) -> PyResult<Told<'py>> {
    let about = about(at)?;
    let units = ShownUnits::of_model(&engine.get().source().text);
    let [inputs, outputs] = channels;
    let channels = Channels { inputs, outputs, states: Vec::new() };
    ask(py, engine.get(), move |name, model| {
        let omega = omega.as_deref().map(questions::bode::frequencies).transpose()?;
        Ok(questions::bode::told(name, &units, &bode(model, about, &channels, omega)?))
    })
}

/// Names with values as text.
type Pairs = Vec<(String, String)>;

/// The name of an actuator, with the curve of its motor.
type Curve = (String, CurvePoints);

/// Names of actuators, limits of efforts, curves of motors, joints that yield.
type Acting = (Vec<String>, Pairs, Vec<Curve>, Pairs);

/// A motion: a formula, times and values with a spline through them, or the times of a run with value, rate and
/// acceleration at each.
#[derive(FromPyObject)]
pub(crate) enum Prescription {
    Formula(String),
    Table(Vec<f64>, Vec<f64>),
    Samples(Vec<f64>, Vec<[f64; 3]>),
}

/// The curve of a motor: the name of a table of the model, or speeds and efforts.
#[derive(FromPyObject)]
pub(crate) enum CurvePoints {
    Table(String),
    Points(Vec<f64>, Vec<f64>),
}

impl CurvePoints {
    fn of(&self, model: &Model, actuator: &str) -> Result<MotorCurve, AnalysisError> {
        match self {
            Self::Table(table) => MotorCurve::of_table(model, actuator, table),
            Self::Points(speeds, efforts) => {
                let points = speeds.iter().zip(efforts).map(|(speed, effort)| [*speed, *effort]);
                MotorCurve::new(actuator, points.collect())
            }
        }
    }
}

/// The efforts, reactions and powers that a motion needs.
#[pyfunction]
pub(crate) fn inverse_of(
    py: Python<'_>,
    engine: Py<Engine>,
    motion: Vec<(String, Prescription)>,
    smoothing: f64,
    times: Option<String>,
    acting: Acting,
) -> PyResult<Told<'_>> {
    let (named, limit, curve, compliance) = acting;
    let engine = engine.get();
    let (text, overrides) = (engine.source().text.as_str(), engine.overrides.as_slice());
    let mut warnings = Vec::new();
    let told = ask(py, engine, |name, mut model| {
        let source = Source { overrides, ..Source::new(text, name) };
        model.compliances = compliances(&model, &compliance)?;
        let read = |(name, points): &Curve| points.of(&model, name);
        let curves = curve.iter().map(read).collect::<Result<_, _>>()?;
        let limits = questions::inverse::limits(&limit)?;
        let actuators = Actuators { named, limits, curves };
        let is_asked = times.is_some();
        let mut times = questions::inverse::times(&model, times.as_deref())?;
        let read = |(measure, motion): &(String, Prescription)| match motion {
            Prescription::Formula(text) => Motion::written(&model, measure, text, &source),
            Prescription::Table(t, x) => Motion::spline(&model, measure, t, x, smoothing),
            Prescription::Samples(t, x) => Motion::samples(&model, measure, t.clone(), x.clone()),
        };
        for (_, motion) in motion.iter().filter(|_| !is_asked) {
            if let Prescription::Samples(known, _) = motion {
                questions::inverse::keep_within(&mut times, known);
            }
        }
        let motions: Vec<Motion> = motion.iter().map(read).collect::<Result<_, _>>()?;
        warnings.extend(motions.iter().filter_map(questions::inverse::like_degrees));
        Ok(questions::inverse::told(name, &inverse(model, &motions, &times, &actuators)?))
    })?;
    warn(py, engine.source(), &warnings, 1)?;
    Ok(told)
}

/// Free motions, repeated conditions, cures.
#[pyfunction]
pub(crate) fn doctor_of(
    py: Python<'_>,
    engine: Py<Engine>,
    drive: Option<String>,
) -> PyResult<Told<'_>> {
    ask(py, engine.get(), move |name, model| {
        let singular = match &drive {
            Some(drive) => Some(singular_poses(model.snapshot().to_model(), drive)?),
            None => None,
        };
        let along = drive.as_deref().zip(singular.as_deref());
        Ok(questions::doctor::told(name, &doctor(model)?, along))
    })
}

/// The run beside one in another way, each of which takes at most so many seconds.
#[pyfunction]
pub(crate) fn verify_of(
    py: Python<'_>,
    engine: Py<Engine>,
    t_end: Option<f64>,
    patience: f64,
) -> PyResult<Told<'_>> {
    ask(py, engine.get(), move |name, mut model| {
        model.solve.t_end = t_end.unwrap_or(model.solve.t_end);
        let found = questions::verify::within(model, patience, &|_, _| ())?;
        Ok(questions::verify::told(name, &found))
    })
}
