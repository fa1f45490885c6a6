//! [`Poses`]: closed positions as functions of parameters and prescribed measures, with exact derivatives.
//!
//! ```text
//! Φ(q, p) = (0, u)        closed loops, drives, stated positions; prescribed measures
//! ∂q/∂p = −Φ_q⁻¹ Φ_p      ∂q/∂u = Φ_q⁻¹ (0, 1)
//! h(q, p)                 dh/dp = h_q ∂q/∂p + h_p
//! ```
//!
//! A pose is followed from one that is known as p and u move on a straight line; where |Φ_q| changes its sign, the
//! assembly ends.

use bksim::Mechanism;
use bksim::expr::{Expr, SymbolId, Tape, Workspace};
use bksim::mbs::constraint::Source;
use bksim::mbs::coordinate::CoordinateKind;
use bksim::model::{Measure, MotionKind};
use nalgebra::{DMatrix, DVector};

use crate::codes;
use crate::error::DesignError;

/// A row of the equations that determine a pose.
#[derive(Clone, Copy, Debug)]
struct Row {
    expr: Expr,
    is_angle: bool,
    /// The number of its prescribed value.
    prescribed: Option<usize>,
}

/// The equations of poses, compiled; shared by threads.
#[derive(Debug)]
pub(crate) struct Poses {
    /// Rows, then their slopes, then outputs with theirs, by q, p and own symbols.
    tape: Tape,
    /// Row and column of every slope, the columns in the order of inputs after the time.
    slopes: Vec<(usize, usize)>,
    rows: Vec<Row>,
    n_outputs: usize,
    n_own: usize,
    t: f64,
    /// Unit of every coordinate and row: 1, or the longest link.
    unit_of_q: Vec<f64>,
    unit_of_row: Vec<f64>,
    /// The expressions of rows and outputs, and all symbols in the order of inputs, for intervals.
    pub(crate) expressions: Vec<Expr>,
    pub(crate) symbols: Vec<SymbolId>,
    /// The start of the model.
    pub(crate) start: Pose,
}

/// A closed pose.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Pose {
    pub(crate) q: Vec<f64>,
    pub(crate) p: Vec<f64>,
    pub(crate) u: Vec<f64>,
}

/// Values of outputs with their derivatives, a row each.
#[derive(Clone, Debug)]
pub(crate) struct Outputs {
    pub(crate) values: Vec<f64>,
    pub(crate) by_p: DMatrix<f64>,
    pub(crate) by_u: DMatrix<f64>,
    pub(crate) by_own: DMatrix<f64>,
}

/// Rows at one pose.
struct At {
    value: DVector<f64>,
    by_q: DMatrix<f64>,
    by_p: DMatrix<f64>,
}

impl Poses {
    /// The poses of a mechanism in which `prescribed` measures have values of their own; `outputs` may depend on the
    /// symbols `own`. `parameters` are those of the model.
    ///
    /// # Errors
    /// [`codes::NOT_DETERMINED`] where the poses are not determined, and faults of the start.
    pub(crate) fn new(
        mechanism: &Mechanism,
        prescribed: &[(String, Measure)],
        outputs: &[Expr],
        own: &[SymbolId],
    ) -> Result<Self, DesignError> {
        let Mechanism { model, system, parameters, .. } = mechanism;
        let pool = &model.pool;
        let closed = mechanism.closed()?;
        let size = if closed.longest_link > 0.0 { closed.longest_link } else { 1.0 };
        let q: Vec<SymbolId> = system.coordinates().iter().map(|c| c.q).collect();
        let p: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let symbols = [&[model.time][..], &q, &p, own].concat();

        // All rows that may determine a pose, the strongest first.
        let is_turn = |m: Measure| m.unit(model) == "rad";
        let row = |expr, is_angle| Row { expr, is_angle, prescribed: None };
        let of_drive = |c: &bksim::mbs::constraint::Constraint| match c.source {
            Source::Drive(id) => {
                let drive = &model.drives[id.0];
                model.joints[drive.joint.0].kind.motions()[drive.motion_idx] == MotionKind::Rotation
            }
            _ => c.direction == "angle" && model.space == bksim::model::Space::Planar,
        };
        let of = |is_wanted: fn(Source) -> bool| {
            let wanted = system.constraints.iter().filter(move |c| is_wanted(c.source));
            wanted.map(|c| row(c.expression, of_drive(c))).collect::<Vec<_>>()
        };
        let loops =
            of(|s| matches!(s, Source::Joint(_) | Source::Quaternion(_) | Source::Coupling(_)));
        let drives = of(|s| matches!(s, Source::Drive(_)));
        let measured = |m: Measure| system.kinematics.measure(model, m);
        let wanted = prescribed
            .iter()
            .enumerate()
            .map(|(k, (_, m))| Row { prescribed: Some(k), ..row(measured(*m), is_turn(*m)) });
        let stated = model.initial.iter().filter(|i| !i.is_guess && !i.measure.is_velocity());
        let stated =
            stated.map(|i| row(pool.sub(measured(i.measure), i.value), is_turn(i.measure)));
        let all: Vec<Row> = loops.into_iter().chain(wanted).chain(drives).chain(stated).collect();

        // Those that are independent at the start.
        let rows_alone: Vec<Expr> = all.iter().map(|row| row.expr).collect();
        let unit_of_q: Vec<f64> = system
            .coordinates()
            .iter()
            .map(|c| if c.kind == CoordinateKind::Length { size } else { 1.0 })
            .collect();
        let slopes = pool.jacobian(&rows_alone, &q);
        let entries: Vec<Expr> = slopes.entries.iter().map(|entry| entry.2).collect();
        let tape =
            Tape::compile(pool, &entries, &symbols, &[]).map_err(|error| uncompiled(&error))?;
        let t = model.solve.t_start;
        let own_values = vec![0.0; own.len()];
        let inputs = [&[t][..], &closed.q, parameters, &own_values].concat();
        let mut values = vec![0.0; entries.len()];
        tape.evaluate(&mut tape.workspace(&[]), &inputs, &mut values);
        let mut jacobian = DMatrix::zeros(all.len(), q.len());
        for (&(row, column, _), value) in slopes.entries.iter().zip(values) {
            jacobian[(row, column)] = value * unit_of_q[column];
        }
        let chosen = independent(&jacobian);
        let rows: Vec<Row> = chosen.iter().map(|&row| all[row]).collect();
        let n_taken = rows.iter().filter(|row| row.prescribed.is_some()).count();
        if rows.len() < q.len() || n_taken < prescribed.len() {
            let missing = q.len() - rows.len();
            let message = if missing > 0 {
                format!(
                    "the pose is not determined: {missing} of its free motions have no stated position"
                )
            } else {
                format!(
                    "{} positions are stated, which are more than the pose has free motions",
                    prescribed.len()
                )
            };
            let help = "state one position for each free motion: with `at`, with `drive`, or in `[initial]` without `guess`";
            return Err(DesignError::fault(codes::NOT_DETERMINED, message, help));
        }

        // Everything as one function.
        let expressions: Vec<Expr> =
            rows.iter().map(|row| row.expr).chain(outputs.iter().copied()).collect();
        let slopes = pool.jacobian(&expressions, &symbols[1..]);
        let entries = slopes.entries.iter().map(|entry| entry.2);
        let all: Vec<Expr> = expressions.iter().copied().chain(entries).collect();
        let tape = Tape::compile(pool, &all, &symbols, &[]).map_err(|error| uncompiled(&error))?;
        let unit_of_row = rows.iter().map(|row| if row.is_angle { 1.0 } else { size }).collect();
        let mut poses = Self {
            tape,
            slopes: slopes.entries.iter().map(|&(row, column, _)| (row, column)).collect(),
            rows,
            n_outputs: outputs.len(),
            n_own: own.len(),
            t,
            unit_of_q,
            unit_of_row,
            expressions,
            symbols,
            start: Pose { q: closed.q, p: parameters.clone(), u: vec![0.0; prescribed.len()] },
        };
        // The prescribed measures have the values of the start.
        let at = poses.solver().evaluate(&poses.start.q, parameters, &[]);
        for (row, value) in poses.rows.iter().zip(&at) {
            if let Some(k) = row.prescribed {
                poses.start.u[k] = *value;
            }
        }
        Ok(poses)
    }

    /// Number of coordinates.
    pub(crate) fn n(&self) -> usize {
        self.unit_of_q.len()
    }

    /// The slopes that are compiled: function, and place of its symbol after the time.
    pub(crate) fn slopes(&self) -> &[(usize, usize)] {
        &self.slopes
    }

    /// Unit of a coordinate.
    pub(crate) fn unit_of_q(&self, k: usize) -> f64 {
        self.unit_of_q[k]
    }

    /// The prescribed value that a row is less by, and whether whole turns mean nothing to it.
    pub(crate) fn row(&self, row: usize) -> (Option<usize>, bool) {
        (self.rows[row].prescribed, self.rows[row].is_angle)
    }

    /// Buffers for evaluations.
    pub(crate) fn solver(&self) -> Solver<'_> {
        Solver {
            poses: self,
            space: self.tape.workspace(&[]),
            values: vec![0.0; self.tape.n_outputs()],
        }
    }
}

/// Rows that are independent, the first ones first.
fn independent(jacobian: &DMatrix<f64>) -> Vec<usize> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut chosen = Vec::new();
    for row in 0..jacobian.nrows() {
        let mut left: DVector<f64> = jacobian.row(row).transpose();
        let size = left.norm();
        for _ in 0..2 {
            for known in &basis {
                left -= known * known.dot(&left);
            }
        }
        if left.norm() > 1e-8 * size && size > 0.0 && basis.len() < jacobian.ncols() {
            basis.push(left.normalize());
            chosen.push(row);
        }
    }
    chosen
}

fn uncompiled(error: &bksim::expr::TapeError) -> DesignError {
    let help = "leave out what changes in time";
    DesignError::fault(codes::BAD_QUESTION, error.to_string(), help)
}

/// An angle without its whole turns.
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::TAU;
    angle - TAU * (angle / TAU).round()
}

/// Poses with buffers of their own.
pub(crate) struct Solver<'a> {
    poses: &'a Poses,
    space: Workspace,
    values: Vec<f64>,
}

/// Corrections below this, in units of the mechanism, end Newton's iteration.
const CLOSED: f64 = 1e-14;
/// The least part of a way that is tried.
const LEAST_PART: f64 = 1e-10;

impl Solver<'_> {
    /// Rows and outputs; missing own symbols are zero.
    fn evaluate(&mut self, q: &[f64], p: &[f64], own: &[f64]) -> Vec<f64> {
        let mut inputs = [&[self.poses.t][..], q, p, own].concat();
        inputs.resize(self.poses.symbols.len(), 0.0);
        self.poses.tape.evaluate(&mut self.space, &inputs, &mut self.values);
        self.values[..self.poses.expressions.len()].to_vec()
    }

    fn at(&mut self, q: &[f64], p: &[f64], u: &[f64]) -> At {
        let values = self.evaluate(q, p, &[]);
        let poses = self.poses;
        let (n, n_p) = (poses.n(), p.len());
        let value = DVector::from_fn(n, |row, _| {
            let of = poses.rows[row];
            let off = values[row] - of.prescribed.map_or(0.0, |k| u[k]);
            let off = if of.is_angle { wrapped(off) } else { off };
            off / poses.unit_of_row[row]
        });
        let (mut by_q, mut by_p) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n_p));
        let slopes = &self.values[poses.expressions.len()..];
        for (&(row, column), slope) in poses.slopes.iter().zip(slopes) {
            if row < n && column < n {
                by_q[(row, column)] = slope * poses.unit_of_q[column] / poses.unit_of_row[row];
            } else if row < n && column < n + n_p {
                by_p[(row, column - n)] = slope / poses.unit_of_row[row];
            }
        }
        At { value, by_q, by_p }
    }

    /// Newton's iteration; the size of its first correction, and the sign of |Φ_q| at its end.
    fn close(&mut self, q: &mut [f64], p: &[f64], u: &[f64]) -> Option<(f64, f64)> {
        let mut first = None;
        let mut last = f64::INFINITY;
        for _ in 0..20 {
            let at = self.at(q, p, u);
            let lu = at.by_q.lu();
            let sign = lu.determinant().signum();
            let correction = lu.solve(&at.value)?;
            let size = correction.amax();
            if !size.is_finite() {
                return None;
            }
            for (k, q) in q.iter_mut().enumerate() {
                *q -= correction[k] * self.poses.unit_of_q[k];
            }
            let first_size = *first.get_or_insert(size);
            if size < CLOSED || (size < 1e-11 && size >= 0.5 * last) {
                return Some((first_size, sign));
            }
            if size > 4.0 * last.min(1.0) {
                return None;
            }
            last = size;
        }
        (last < 1e-9).then(|| (first.unwrap_or(0.0), f64::NAN)).filter(|(_, sign)| !sign.is_nan())
    }

    /// The sign of |Φ_q|.
    pub(crate) fn side(&mut self, pose: &Pose) -> f64 {
        self.at(&pose.q, &pose.p, &pose.u).by_q.determinant().signum()
    }

    /// Rows in units of the mechanism, |Φ_q| and outputs at any coordinates.
    pub(crate) fn raw(&mut self, q: &[f64], p: &[f64], u: &[f64]) -> (Vec<f64>, f64, Vec<f64>) {
        let at = self.at(q, p, u);
        let outputs = self.values[self.poses.n()..self.poses.expressions.len()].to_vec();
        (at.value.iter().copied().collect(), at.by_q.determinant(), outputs)
    }

    /// The pose at other parameters and prescribed values, on the way that begins at `from`.
    ///
    /// # Errors
    /// The last pose of the way, and its part of the way, where it ends before.
    pub(crate) fn follow(
        &mut self,
        from: &Pose,
        p: &[f64],
        u: &[f64],
    ) -> Result<Pose, (Pose, f64)> {
        let between = |from: &[f64], to: &[f64], s: f64| -> Vec<f64> {
            if s == 1.0 {
                to.to_vec()
            } else {
                from.iter().zip(to).map(|(a, b)| a + s * (b - a)).collect()
            }
        };
        let side = self.side(from);
        let mut now = from.clone();
        let (mut s, mut ds) = (0.0, 1.0);
        while s < 1.0 {
            let to: f64 = if s + ds > 1.0 - 1e-12 { 1.0 } else { s + ds };
            let (p_to, u_to) = (between(&from.p, p, to), between(&from.u, u, to));
            let mut q = now.q.clone();
            // Along the tangent, then onto the rows.
            let at = self.at(&now.q, &p_to, &u_to);
            let slopes = self.at(&now.q, &now.p, &now.u);
            if let Some(step) = slopes.by_q.lu().solve(&at.value) {
                for (k, q) in q.iter_mut().enumerate() {
                    *q -= step[k] * self.poses.unit_of_q[k];
                }
            }
            let moved: f64 = (0..q.len())
                .map(|k| ((q[k] - now.q[k]) / self.poses.unit_of_q[k]).abs())
                .fold(0.0, f64::max);
            let found = if moved < 0.3 { self.close(&mut q, &p_to, &u_to) } else { None };
            match found {
                Some((first, sign)) if sign == side && first < 0.5 * moved.max(1e-9) + 1e-9 => {
                    now = Pose { q, p: p_to, u: u_to };
                    s = to;
                    ds *= 2.0;
                }
                _ => {
                    ds *= 0.5;
                    if ds < LEAST_PART {
                        return Err((now, s));
                    }
                }
            }
        }
        Ok(now)
    }

    /// Rates of the coordinates where the first prescribed measure has the rate one, and the parameters rest.
    pub(crate) fn rate(&mut self, pose: &Pose) -> Option<Vec<f64>> {
        let at = self.at(&pose.q, &pose.p, &pose.u);
        let mut right = DVector::zeros(self.poses.n());
        let row = self.poses.rows.iter().position(|row| row.prescribed == Some(0))?;
        right[row] = 1.0 / self.poses.unit_of_row[row];
        let rate = at.by_q.lu().solve(&right)?;
        Some(rate.iter().zip(&self.poses.unit_of_q).map(|(rate, unit)| rate * unit).collect())
    }

    /// Outputs at a pose with their exact derivatives.
    pub(crate) fn outputs(&mut self, pose: &Pose, own: &[f64]) -> Option<Outputs> {
        let poses = self.poses;
        let (n, n_p, n_u) = (poses.n(), pose.p.len(), pose.u.len());
        let at = self.at(&pose.q, &pose.p, &pose.u);
        let values = self.evaluate(&pose.q, &pose.p, own);
        let lu = at.by_q.lu();
        let q_by_p = -lu.solve(&at.by_p)?;
        let mut of_u = DMatrix::zeros(n, n_u);
        for (row, of) in poses.rows.iter().enumerate() {
            if let Some(k) = of.prescribed {
                of_u[(row, k)] = 1.0 / poses.unit_of_row[row];
            }
        }
        let q_by_u = lu.solve(&of_u)?;
        let m = poses.n_outputs;
        let mut h_q = DMatrix::zeros(m, n);
        let mut by_p = DMatrix::zeros(m, n_p);
        let mut by_own = DMatrix::zeros(m, poses.n_own);
        let slopes = &self.values[poses.expressions.len()..];
        for (&(row, column), slope) in poses.slopes.iter().zip(slopes) {
            let Some(row) = row.checked_sub(n) else { continue };
            match column {
                c if c < n => h_q[(row, c)] = slope * poses.unit_of_q[c],
                c if c < n + n_p => by_p[(row, c - n)] = *slope,
                c => by_own[(row, c - n - n_p)] = *slope,
            }
        }
        by_p += &h_q * q_by_p;
        let by_u = h_q * q_by_u;
        let found = Outputs { values: values[n..].to_vec(), by_p, by_u, by_own };
        found.values.iter().all(|value| value.is_finite()).then_some(found)
    }
}
