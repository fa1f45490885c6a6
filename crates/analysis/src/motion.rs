//! [`Motion`]: a prescribed motion, by a formula, a spline through a table, or the samples of a log.

use std::sync::Arc;

use bksim_expr::{Expr, Tape};
use bksim_model::diagnostic::{Diagnostic, Rejected};
use bksim_model::file::{Formula, Source, amplitude_like_degrees, read_formulas};
use bksim_model::{JointId, Measure, Model};
use nalgebra::{DMatrix, DVector};

use crate::codes;
use crate::drive::{Range, position};
use crate::error::AnalysisError;

/// Value, rate and acceleration as a function of time, SI.
pub(crate) type TimeLaw = Arc<dyn Fn(f64) -> [f64; 3]>;

/// A prescribed motion of a joint, of a body or of a point.
#[derive(Clone)]
pub struct Motion {
    /// Name of the measure: `A.angle`.
    pub name: String,
    /// The measure, a position.
    pub(crate) measure: Measure,
    pub(crate) law: TimeLaw,
    /// First and last time at which it is known, s; `None` of a formula.
    ends: Option<[f64; 2]>,
    /// Amplitude of an angle that looks like degrees, rad.
    pub amplitude: Option<f64>,
}

impl std::fmt::Debug for Motion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Motion").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Motion {
    /// A motion as a formula of `t` and the parameters, SI: `0.4 + 6*t`.
    ///
    /// # Errors
    /// [`AnalysisError`] for a name that is no position's, or a formula that cannot be read.
    pub fn formula(model: &Model, name: &str, formula: &str) -> Result<Self, AnalysisError> {
        let measure = driven(model, name)?;
        let pool = &model.pool;
        let unit = measure.unit(model);
        let bad = || AnalysisError::BadRange { text: formula.to_owned(), unit: unit.to_owned() };
        let value = pool.parse(formula).map_err(|_| bad())?;
        let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
        let law = law_of(model, value, parameters)?;
        let amplitude = if unit == "rad" { amplitude_like_degrees(formula) } else { None };
        Ok(Self { amplitude, ..Self::of(name, measure, law) })
    }

    fn of(name: &str, measure: Measure, law: TimeLaw) -> Self {
        Self { name: name.to_owned(), measure, law, ends: None, amplitude: None }
    }

    /// The warning that a drive of the model is left out because this motion is in its place.
    pub fn replaced_drive(&self, model: &Model) -> Option<Diagnostic> {
        let is_own = |drive: &&bksim_model::Drive| {
            self.measure == Measure::JointPosition(drive.joint, drive.motion_idx)
        };
        let drive = model.drives.iter().find(is_own)?;
        let message =
            format!("the motion of `{}` is in place of that of drive `{}`", self.name, drive.name);
        let help = format!("leave out `--motion {}` for the motion of the drive", self.name);
        let fault = Diagnostic::warning(codes::DRIVE_REPLACED, message);
        Some(fault.at(drive.span.clone(), "left out here").help(help))
    }

    /// Refuses times that the table of this motion does not reach.
    pub(crate) fn check_times(&self, times: &Range) -> Result<(), AnalysisError> {
        /// Part of a table's span by which a time may miss its end by rounding.
        const ROUNDING: f64 = 1e-9;
        let Some(ends @ [first, last]) = self.ends else { return Ok(()) };
        let near = ROUNDING * (last - first);
        let is_beyond = |t: &f64| *t < first - near || *t > last + near;
        match [times.from, times.to].into_iter().find(is_beyond) {
            Some(t) => Err(AnalysisError::BeyondTable { name: self.name.clone(), t, ends }),
            None => Ok(()),
        }
    }

    /// A motion as a formula in SI or, where it is none, in the words of a model file: with units, tables and laws, `100 mm*t/(1 s)`
    /// or `lift(90 deg/s*t)`. `source` is the text that `model` was read from.
    ///
    /// # Errors
    /// [`AnalysisError`] for a name that is no position's, or a formula that cannot be read.
    pub fn written(
        model: &Model,
        name: &str,
        text: &str,
        source: &Source<'_>,
    ) -> Result<Self, AnalysisError> {
        let measure = driven(model, name)?;
        match Self::formula(model, name, text) {
            Err(AnalysisError::BadRange { .. } | AnalysisError::Compile(_)) => {}
            found => return found,
        }
        let what = format!("the motion of `{name}`");
        let formula = Formula { what: &what, text, unit: measure.unit(model) };
        let (read, found) = read_formulas(source, &[formula]).map_err(Rejected)?;
        let value = |p: &bksim_model::Parameter| {
            let known = model.parameters.iter().find(|known| known.name == p.name);
            known.map_or(p.value, |known| known.value)
        };
        let parameters = read.parameters.iter().map(value).collect();
        let law = law_of(&read, found[0], parameters)?;
        Ok(Self::of(name, measure, law))
    }

    /// A motion through measured values, by a natural cubic spline with
    /// Σ (s(tᵢ) − xᵢ)² + `smoothing` ∫ s″² dt smallest; 0 goes through all of them.
    ///
    /// Source: C. H. Reinsch, *Smoothing by spline functions*, Numer. Math. 10 (1967).
    ///
    /// # Errors
    /// [`AnalysisError`] for a name that is no position's, fewer than three times, or times that do not ascend.
    pub fn spline(
        model: &Model,
        name: &str,
        times: &[f64],
        values: &[f64],
        smoothing: f64,
    ) -> Result<Self, AnalysisError> {
        let measure = driven(model, name)?;
        let bad = || AnalysisError::BadRange { text: name.to_owned(), unit: "s".to_owned() };
        check_rows(name, times, 3, |pair| pair[0] < pair[1])?;
        if times.len() != values.len() || smoothing < 0.0 {
            return Err(bad());
        }
        let ends = Some([times[0], times[times.len() - 1]]);
        let spline = Spline::of(times, values, smoothing).ok_or_else(bad)?;
        let law: TimeLaw = Arc::new(move |t| spline.at(t));
        Ok(Self { ends, ..Self::of(name, measure, law) })
    }

    /// A motion by samples of value, rate and acceleration, such as a run logs them; between two samples the
    /// polynomial of fifth degree that has all of them.
    ///
    /// # Errors
    /// [`AnalysisError`] for a name that is no position's, or times that do not ascend.
    pub fn samples(
        model: &Model,
        name: &str,
        times: Vec<f64>,
        values: Vec<[f64; 3]>,
    ) -> Result<Self, AnalysisError> {
        let measure = driven(model, name)?;
        // Where a run has an event it has two samples, the later of which goes on.
        check_rows(name, &times, 2, |pair| pair[0] <= pair[1])?;
        if times.len() != values.len() {
            return Err(AnalysisError::BadRange { text: name.to_owned(), unit: "s".to_owned() });
        }
        let ends = Some([times[0], times[times.len() - 1]]);
        let law: TimeLaw = Arc::new(move |t| {
            let next = times.partition_point(|&known| known <= t).clamp(1, times.len() - 1);
            let (t0, t1) = (times[next - 1], times[next]);
            if t == t0 {
                return values[next - 1];
            }
            if t == t1 {
                return values[next];
            }
            quintic((t - t0, t1 - t0), (values[next - 1], values[next]))
        });
        Ok(Self { ends, ..Self::of(name, measure, law) })
    }
}

/// Refuses a table with too few rows, or rows that do not follow each other in time.
fn check_rows(
    name: &str,
    times: &[f64],
    least: usize,
    follows: fn(&[f64]) -> bool,
) -> Result<(), AnalysisError> {
    let name = name.to_owned();
    if times.len() < least {
        return Err(AnalysisError::ShortTable { name, rows: times.len(), least });
    }
    match times.windows(2).find(|pair| !follows(pair)) {
        Some(pair) => Err(AnalysisError::TimesDescend { name, times: [pair[0], pair[1]] }),
        None => Ok(()),
    }
}

/// Value, rate and acceleration of an expression of time at these values of the model's parameters.
fn law_of(model: &Model, value: Expr, parameters: Vec<f64>) -> Result<TimeLaw, AnalysisError> {
    let pool = &model.pool;
    let rate = pool.diff(value, model.time);
    let acceleration = pool.diff(rate, model.time);
    let symbols: Vec<_> = model.parameters.iter().map(|p| p.symbol).collect();
    let tape = Tape::compile(pool, &[value, rate, acceleration], &[model.time], &symbols)?;
    Ok(Arc::new(move |t| {
        let mut out = [0.0; 3];
        tape.evaluate(&mut tape.workspace(&parameters), &[t], &mut out);
        out
    }))
}

/// A measure that can be prescribed; the angle of a body that a pin holds to the ground is that of the pin.
pub(crate) fn driven(model: &Model, name: &str) -> Result<Measure, AnalysisError> {
    let measure = position(model, name)?;
    let Measure::BodyAngle(body) = measure else { return Ok(measure) };
    let holds = |joint: &bksim_model::Joint| {
        joint.predecessor.body == bksim_model::GROUND
            && joint.successor.body == body
            && joint.kind.is_pin()
    };
    let joint = model.joints.iter().position(holds);
    Ok(joint.map_or(measure, |joint| Measure::JointPosition(JointId(joint), 0)))
}

/// The quintic with given values, rates and accelerations at both ends of an interval of width `h`, at `t`.
fn quintic((t, h): (f64, f64), (a, b): ([f64; 3], [f64; 3])) -> [f64; 3] {
    let c = t / h;
    // In units of the interval.
    let (a, b) = ([a[0], a[1] * h, a[2] * h * h], [b[0], b[1] * h, b[2] * h * h]);
    let rise = b[0] - a[0] - a[1] - 0.5 * a[2];
    let slope = b[1] - a[1] - a[2];
    let bend = b[2] - a[2];
    let k3 = 10.0 * rise - 4.0 * slope + 0.5 * bend;
    let k4 = -15.0 * rise + 7.0 * slope - bend;
    let k5 = 6.0 * rise - 3.0 * slope + 0.5 * bend;
    let value = a[0] + c * (a[1] + c * (0.5 * a[2] + c * (k3 + c * (k4 + c * k5))));
    let rate = a[1] + c * (a[2] + c * (3.0 * k3 + c * (4.0 * k4 + c * 5.0 * k5)));
    let acceleration = a[2] + c * (6.0 * k3 + c * (12.0 * k4 + c * 20.0 * k5));
    [value, rate / h, acceleration / (h * h)]
}

/// A natural cubic spline.
struct Spline {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the times.
    bends: Vec<f64>,
}

impl Spline {
    /// (R + α Qᵀ Q) γ = Qᵀ x, s = x − α Q γ.
    fn of(times: &[f64], values: &[f64], smoothing: f64) -> Option<Self> {
        let n = times.len();
        let h: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut q = DMatrix::zeros(n, n - 2);
        let mut r = DMatrix::zeros(n - 2, n - 2);
        for k in 0..n - 2 {
            q[(k, k)] = 1.0 / h[k];
            q[(k + 1, k)] = -1.0 / h[k] - 1.0 / h[k + 1];
            q[(k + 2, k)] = 1.0 / h[k + 1];
            r[(k, k)] = (h[k] + h[k + 1]) / 3.0;
            if k + 1 < n - 2 {
                r[(k, k + 1)] = h[k + 1] / 6.0;
                r[(k + 1, k)] = h[k + 1] / 6.0;
            }
        }
        let x = DVector::from_column_slice(values);
        let matrix = r + q.transpose() * &q * smoothing;
        let inner = matrix.cholesky()?.solve(&(q.transpose() * &x));
        let smooth = &x - &q * &inner * smoothing;
        let bends = std::iter::once(0.0).chain(inner.iter().copied()).chain([0.0]).collect();
        Some(Self { times: times.to_vec(), values: smooth.as_slice().to_vec(), bends })
    }

    fn at(&self, t: f64) -> [f64; 3] {
        let Self { times, values, bends } = self;
        let next = times.partition_point(|&known| known <= t).clamp(1, times.len() - 1);
        let h = times[next] - times[next - 1];
        let (b, a) = ((t - times[next - 1]) / h, (times[next] - t) / h);
        let (m0, m1) = (bends[next - 1], bends[next]);
        let cubic = |c: f64| c * c * c - c;
        let value =
            a * values[next - 1] + b * values[next] + (cubic(a) * m0 + cubic(b) * m1) * h * h / 6.0;
        let rate = (values[next] - values[next - 1]) / h
            + ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * h / 6.0;
        [value, rate, a * m0 + b * m1]
    }
}
