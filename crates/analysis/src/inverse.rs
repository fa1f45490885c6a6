//! Inverse dynamics: a motion gives the efforts of the drives, all reactions, and the power.
//!
//! ```text
//! positions, velocities and accelerations from the constraints and the prescribed motions
//! Gᵀ λ = f − M a        the efforts of the drives are the multipliers of their rows
//! ```

use std::sync::Arc;

use bksim_expr::Tape;
use bksim_mbs::constraint::Source;
use bksim_model::{Drive as ModelDrive, JointId, Measure, Model};
use nalgebra::{DMatrix, DVector};

use crate::drive::Range;
use crate::equilibrium::reaction_columns;
use crate::error::AnalysisError;
use crate::forces::{At, Forces};
use crate::loaded::{Loaded, without_states};
use crate::positions::Positions;
use crate::rows::{Clock, Rows, Solver};
use crate::table::{Column, Table};

/// Value, rate and acceleration as a function of time, SI.
type TimeLaw = Arc<dyn Fn(f64) -> [f64; 3]>;

/// A prescribed motion of a joint.
#[derive(Clone)]
pub struct Motion {
    /// Name of the measure: `A.angle`.
    pub name: String,
    joint: JointId,
    /// Index of the joint's motion.
    of_joint: usize,
    law: TimeLaw,
}

/// Largest and quadratic mean of a quantity over a motion.
#[derive(Clone, PartialEq, Debug)]
pub struct Load {
    /// Name of the column of the table.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The value of largest magnitude.
    pub peak: f64,
    /// Time of the peak, s.
    pub at: f64,
    /// √(1/T ∫ x² dt), by the trapezoidal rule.
    pub rms: f64,
}

/// Efforts over a motion.
#[derive(Clone, PartialEq, Debug)]
pub struct Inverse {
    /// A row for each time: t; for each drive its position, rate, acceleration, effort, power; the reactions
    /// of the joints.
    pub table: Table,
    /// Of all efforts, powers and reactions.
    pub loads: Vec<Load>,
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
    /// [`AnalysisError`] for a name that is no joint's, or a formula that cannot be read.
    pub fn formula(model: &Model, name: &str, formula: &str) -> Result<Self, AnalysisError> {
        let (joint, motion_idx) = driven(model, name)?;
        let pool = &model.pool;
        let unit = Measure::JointPosition(joint, motion_idx).unit(model);
        let bad = || AnalysisError::BadRange { text: formula.to_owned(), unit: unit.to_owned() };
        let value = pool.parse(formula).map_err(|_| bad())?;
        let rate = pool.diff(value, model.time);
        let acceleration = pool.diff(rate, model.time);
        let symbols: Vec<_> = model.parameters.iter().map(|p| p.symbol).collect();
        let tape = Tape::compile(pool, &[value, rate, acceleration], &[model.time], &symbols)?;
        let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
        let law: TimeLaw = Arc::new(move |t| {
            let mut out = [0.0; 3];
            tape.evaluate(&mut tape.workspace(&parameters), &[t], &mut out);
            out
        });
        Ok(Self { name: name.to_owned(), joint, of_joint: motion_idx, law })
    }

    /// A motion through measured values, by a natural cubic spline with
    /// Σ (s(tᵢ) − xᵢ)² + `smoothing` ∫ s″² dt smallest; 0 goes through all of them.
    ///
    /// Source: C. H. Reinsch, *Smoothing by spline functions*, Numer. Math. 10 (1967).
    ///
    /// # Errors
    /// [`AnalysisError`] for a name that is no joint's, fewer than three times, or times that do not ascend.
    pub fn spline(
        model: &Model,
        name: &str,
        times: &[f64],
        values: &[f64],
        smoothing: f64,
    ) -> Result<Self, AnalysisError> {
        let (joint, motion_idx) = driven(model, name)?;
        let bad = || AnalysisError::BadRange { text: name.to_owned(), unit: "s".to_owned() };
        let ascends = times.windows(2).all(|pair| pair[0] < pair[1]);
        if times.len() < 3 || times.len() != values.len() || !ascends || smoothing < 0.0 {
            return Err(bad());
        }
        let spline = Spline::of(times, values, smoothing).ok_or_else(bad)?;
        let law: TimeLaw = Arc::new(move |t| spline.at(t));
        Ok(Self { name: name.to_owned(), joint, of_joint: motion_idx, law })
    }

    /// A motion by samples of value, rate and acceleration, such as a run logs them; between two samples the
    /// polynomial of fifth degree that has all of them.
    ///
    /// # Errors
    /// [`AnalysisError`] for a name that is no joint's, or times that do not ascend.
    pub fn samples(
        model: &Model,
        name: &str,
        times: Vec<f64>,
        values: Vec<[f64; 3]>,
    ) -> Result<Self, AnalysisError> {
        let (joint, motion_idx) = driven(model, name)?;
        let ascends = times.windows(2).all(|pair| pair[0] < pair[1]);
        if times.len() < 2 || times.len() != values.len() || !ascends {
            return Err(AnalysisError::BadRange { text: name.to_owned(), unit: "s".to_owned() });
        }
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
        Ok(Self { name: name.to_owned(), joint, of_joint: motion_idx, law })
    }
}

/// The joint motion of a measure: `A.angle`, or `crank.angle` of a body that a joint holds to the ground.
fn driven(model: &Model, name: &str) -> Result<(JointId, usize), AnalysisError> {
    let unknown = || AnalysisError::UnknownMeasure { name: name.to_owned() };
    match Measure::named(model, name).ok_or_else(unknown)? {
        Measure::JointPosition(joint, motion_idx) => Ok((joint, motion_idx)),
        Measure::BodyAngle(body) => {
            let holds = |joint: &bksim_model::Joint| {
                joint.predecessor.body == bksim_model::GROUND
                    && joint.successor.body == body
                    && matches!(joint.kind, bksim_model::JointKind::Revolute)
            };
            let joint = model.joints.iter().position(holds).ok_or_else(unknown)?;
            Ok((JointId(joint), 0))
        }
        _ => Err(AnalysisError::NotAPosition { name: name.to_owned() }),
    }
}

/// Efforts that make `model` follow `motions`, and its own drives, at `times`.
///
/// # Errors
/// [`AnalysisError`] when there is no start, motions are left free, or the motion cannot be followed.
pub fn inverse(
    mut model: Model,
    motions: &[Motion],
    times: &Range,
) -> Result<Inverse, AnalysisError> {
    without_states(&model)?;
    // Each motion becomes a drive; one that is there already goes.
    model.drives.retain(|drive| {
        !motions.iter().any(|m| m.joint == drive.joint && m.of_joint == drive.motion_idx)
    });
    let n_own = model.drives.len();
    model.solve.t_start = times.from;
    for motion in motions {
        let start = model.pool.float((motion.law)(times.from)[0]);
        let span = model.joints[motion.joint.0].span.clone();
        let name = model.joints[motion.joint.0].name.clone();
        let (joint, motion_idx) = (motion.joint, motion.of_joint);
        model.drives.push(ModelDrive { name, joint, motion_idx, motion: start, span });
    }
    // What is stated of a driven joint would be stated twice.
    let is_driven = |measure: Measure| {
        model.drives.iter().any(|d| {
            measure == Measure::JointPosition(d.joint, d.motion_idx)
                || measure == Measure::JointVelocity(d.joint, d.motion_idx)
        })
    };
    model.initial.retain(|initial| !is_driven(initial.measure));
    for initial in &mut model.initial {
        initial.is_guess = true;
    }
    let snapshot = model.snapshot();
    let positions = Positions::of(snapshot.to_model())?;
    let measures: Vec<Measure> =
        motions.iter().map(|m| Measure::JointPosition(m.joint, m.of_joint)).collect();
    let added: Vec<usize> = (n_own..positions.model().drives.len()).collect();
    let mut rows = positions.rows(&measures, &added, Clock::Running)?;
    let mut walk = Walk { x: rows.scaled(&positions.q), t: times.from, motions };
    walk.check_drives(&mut rows, positions.model().drives.len())?;

    // Forces of the same mechanism, masses and loads included.
    let mechanism = bksim_sim::Mechanism::derive(snapshot.to_model(), Vec::new())?;
    let loaded = Loaded::at_position(mechanism, &positions);
    let system = loaded.system();
    let mut forces =
        Forces::compile(loaded.model(), system, &loaded.kept, &[], &loaded.parameters)?;
    let driven: Vec<_> = loaded
        .model()
        .drives
        .iter()
        .map(|d| Measure::JointPosition(d.joint, d.motion_idx))
        .collect();
    let quantities: Vec<_> = (driven.iter().zip(&loaded.model().drives))
        .map(|(&measure, drive)| {
            let value = system.kinematics.measure(loaded.model(), measure);
            let names = [drive.name.clone(), String::new(), String::new()];
            crate::PoseQuantity { names, unit: measure.unit(loaded.model()), value }
        })
        .collect();
    let mut rates = loaded.rates(&quantities)?;
    let mut table = Table { columns: heads(&loaded, &quantities), rows: Vec::new() };
    for t in times.values() {
        let [q, v, a] = walk.to(&mut rows, t).ok_or(AnalysisError::Lost { t })?;
        let nothing = vec![0.0; forces.nc()];
        let at = forces.at(At { t, q: &q, v: &v, a: &a, lambda: &nothing, p: &[] });
        let lambda = multipliers(&at.jacobian, &at.residual).ok_or(AnalysisError::Lost { t })?;
        let lambda = forces.all_multipliers(system.constraints.len(), &lambda);
        let mut row = vec![t];
        let shown = rates.at(t, [&q, &v, &a]);
        for (drive_idx, values) in shown.iter().enumerate() {
            let is_own = |c: &bksim_mbs::constraint::Constraint| matches!(c.source, Source::Drive(id) if id.0 == drive_idx);
            let at = system.constraints.iter().position(is_own);
            let effort = at.map_or(0.0, |row| lambda[row]);
            row.extend(values);
            row.extend([effort, effort * values[1]]);
        }
        let reactions = loaded.reactions(t, &loaded.parameters, [&q, &v, &a, &lambda]);
        row.extend(reactions.iter().flatten());
        table.rows.push(row);
    }
    let loads = loads(&table);
    Ok(Inverse { table, loads })
}

fn heads(loaded: &Loaded, quantities: &[crate::PoseQuantity]) -> Vec<Column> {
    let mut columns = vec![Column::new("t", "s")];
    for quantity in quantities {
        let [name, ..] = &quantity.names;
        let is_angle = quantity.is_angle();
        let words = if is_angle {
            ["angle", "rate", "acceleration"]
        } else {
            ["position", "velocity", "acceleration"]
        };
        let units = quantity.units();
        columns.extend(
            words.iter().zip(units).map(|(word, unit)| Column::new(format!("{name}.{word}"), unit)),
        );
        columns.push(Column::new(format!("{name}.effort"), if is_angle { "N*m" } else { "N" }));
        columns.push(Column::new(format!("{name}.power"), "W"));
    }
    columns.extend(reaction_columns(&loaded.mechanism.compiled.joints));
    columns
}

/// λ with Gᵀ λ = −r, the smallest where it is not unique.
fn multipliers(jacobian: &DMatrix<f64>, residual: &DVector<f64>) -> Option<Vec<f64>> {
    let transposed = jacobian.transpose();
    let right = -residual;
    let square = transposed.is_square().then(|| transposed.clone().lu().solve(&right)).flatten();
    let fits = |x: &DVector<f64>| {
        let left = (&transposed * x - &right).norm();
        left.is_finite() && left <= 1e-9 * (1.0 + right.norm())
    };
    if let Some(x) = square.filter(fits) {
        return Some(x.as_slice().to_vec());
    }
    let tolerance = crate::rows::RANK_TOLERANCE * transposed.norm();
    let x = transposed.clone().svd(true, true).solve(&right, tolerance).ok()?;
    Some(x.as_slice().to_vec())
}

/// Peaks and means of efforts, powers and reactions.
fn loads(table: &Table) -> Vec<Load> {
    let times: Vec<f64> = table.rows.iter().map(|row| row[0]).collect();
    let is_load = |column: &&(usize, &Column)| matches!(column.1.unit.as_str(), "N" | "N*m" | "W");
    let of = |(k, column): (usize, &Column)| {
        let values: Vec<f64> = table.rows.iter().map(|row| row[k]).collect();
        let peak = (0..values.len()).max_by(|&a, &b| values[a].abs().total_cmp(&values[b].abs()));
        let peak = peak.unwrap_or(0);
        let steps = 1..times.len();
        let square: f64 = steps
            .map(|i| 0.5 * (values[i].powi(2) + values[i - 1].powi(2)) * (times[i] - times[i - 1]))
            .sum();
        let span = times.last().copied().unwrap_or(0.0) - times.first().copied().unwrap_or(0.0);
        let own = values.get(peak).copied().unwrap_or(0.0);
        Load {
            name: column.name.clone(),
            unit: column.unit.clone(),
            peak: own,
            at: times.get(peak).copied().unwrap_or(0.0),
            rms: if span == 0.0 { own.abs() } else { (square / span).sqrt() },
        }
    };
    let columns: Vec<(usize, &Column)> = table.columns.iter().enumerate().collect();
    columns.iter().filter(is_load).map(|&column| of(column)).collect()
}

/// Positions followed in time.
struct Walk<'a> {
    /// In units of the mechanism.
    x: Vec<f64>,
    t: f64,
    motions: &'a [Motion],
}

impl Walk<'_> {
    fn prescribed(&self, t: f64) -> [Vec<f64>; 3] {
        let values: Vec<[f64; 3]> = self.motions.iter().map(|motion| (motion.law)(t)).collect();
        std::array::from_fn(|level| values.iter().map(|value| value[level]).collect())
    }

    /// Whether all motions are prescribed.
    fn check_drives(&self, rows: &mut Rows, n_driven: usize) -> Result<(), AnalysisError> {
        let [u, ..] = self.prescribed(self.t);
        let jacobian = rows.at(self.t, &self.x, &u).jacobian;
        let n_left = self.x.len() - crate::curve::independent_rows(&jacobian).len();
        if n_left == 0 {
            Ok(())
        } else {
            Err(AnalysisError::NDrives { n_free: n_driven + n_left, n_driven })
        }
    }

    /// Goes to another time; q, v and a there.
    fn to(&mut self, rows: &mut Rows, t: f64) -> Option<[Vec<f64>; 3]> {
        const SHORTEST: f64 = 1e-9;
        const LONGEST_STEP: f64 = 0.1;
        let whole = t - self.t;
        let mut share = 1.0;
        while self.t != t {
            let step = if (t - self.t).abs() <= (share * whole).abs() {
                t - self.t
            } else {
                share * whole
            };
            let next = if step == t - self.t { t } else { self.t + step };
            let [_, u_dot, u_ddot] = self.prescribed(self.t);
            let [v, a] = rows.rates(self.t, &self.x, (&u_dot, &u_ddot))?;
            let (v, a) = (rows.scaled(&v), rows.scaled(&a));
            let guess: Vec<f64> =
                (0..v.len()).map(|i| self.x[i] + step * (v[i] + 0.5 * step * a[i])).collect();
            let longest = (0..v.len()).fold(0.0, |l: f64, i| l.max((guess[i] - self.x[i]).abs()));
            let [u, ..] = self.prescribed(next);
            let closed =
                (longest <= LONGEST_STEP).then(|| close(rows, next, guess, &u, longest)).flatten();
            match closed {
                Some(x) => {
                    (self.x, self.t) = (x, next);
                    share = (share * 1.5).min(1.0);
                }
                None => share *= 0.5,
            }
            if share < SHORTEST {
                return None;
            }
        }
        let [u, u_dot, u_ddot] = self.prescribed(t);
        self.x = close(rows, t, self.x.clone(), &u, 1.0)?;
        let [v, a] = rows.rates(t, &self.x, (&u_dot, &u_ddot))?;
        Some([rows.unscaled(&self.x), v, a])
    }
}

/// Newton's iteration on all rows from a guess that is off by less than a part of `step`.
fn close(rows: &mut Rows, t: f64, mut x: Vec<f64>, u: &[f64], step: f64) -> Option<Vec<f64>> {
    for iteration in 0..12 {
        let at = rows.at(t, &x, u);
        let change = Solver::of(&at.jacobian)?.solve(&at.value)?;
        let size = change.norm();
        if !size.is_finite() || (iteration == 0 && size > 0.2 * step + 1e-9) {
            return None;
        }
        x.iter_mut().zip(change.iter()).for_each(|(x, change)| *x -= change);
        if size < 1e-12 {
            return Some(x);
        }
    }
    None
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
