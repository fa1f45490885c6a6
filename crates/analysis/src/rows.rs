//! [`Rows`]: the equations that positions satisfy, as functions of numbers, with prescribed measures
//! among them.
//!
//! ```text
//! Φ = 0       g(t, q)       closed loops, and the drives of the model
//!             m(q) − u      prescribed measures
//! ```
//!
//! Coordinates and rows are counted in units of the mechanism: radians, and lengths of its longest link.

use bksim_expr::{Expr, SymbolId, Tape, TapeError, Workspace};
use bksim_mbs::constraint::Source;
use bksim_mbs::contact::Penetration;
use bksim_mbs::coordinate::{Coordinate, CoordinateKind};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Measure, Model, MotionKind};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

/// How time passes where positions are followed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Clock {
    /// The drives of the model stand still.
    Held,
    /// They move as in a run.
    Running,
}

/// Φ with its slopes, and what velocities make of it.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    levels: Tape,
    levels_space: Workspace,
    gamma: Tape,
    gamma_space: Workspace,
    /// Rates of the rows, and that of the time.
    velocities: (Vec<Expr>, Expr),
    /// d³Φ/dt³ without the third rates of the coordinates, where they are asked for.
    third: Option<(Tape, Workspace)>,
    outputs: Vec<f64>,
    /// Row and column of each slope, in the order of the outputs.
    slopes: Vec<(usize, usize)>,
    n_all: usize,
    n_prescribed: usize,
    /// Unit of each coordinate: 1 rad or the longest link, m.
    pub(crate) unit_of_column: Vec<f64>,
    /// Whether whole turns of a coordinate mean nothing.
    pub(crate) is_turn: Vec<bool>,
    /// First coordinates of quaternions, of which both signs mean the same.
    quaternions: Vec<usize>,
    unit_of_row: Vec<f64>,
    /// Rows whose values one turn apart mean the same.
    is_angle: Vec<bool>,
}

/// Rows at one position, in units of the mechanism.
#[derive(Clone, Debug)]
pub(crate) struct RowsAt {
    /// Φ.
    pub(crate) value: DVector<f64>,
    /// ∂Φ/∂q.
    pub(crate) jacobian: DMatrix<f64>,
    /// ∂Φ/∂t, 1/s.
    pub(crate) rate: DVector<f64>,
}

impl Rows {
    /// The constraint rows `kept`, then rows of `prescribed` measures; parameters are those of
    /// `SymbolicSystem::parameters`.
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
        prescribed: &[Measure],
        kept: &[usize],
        numbers: (&[f64], f64, Clock),
    ) -> Result<Self, TapeError> {
        Self::with_stops(model, system, (prescribed, &[]), kept, numbers)
    }

    /// Rows of [`Rows::compile`], with the limits of stops that bear before the prescribed ones.
    pub(crate) fn with_stops(
        model: &Model,
        system: &SymbolicSystem,
        (prescribed, bearing): (&[Measure], &[Penetration]),
        kept: &[usize],
        (parameters, size, clock): (&[f64], f64, Clock),
    ) -> Result<Self, TapeError> {
        let pool = &model.pool;
        let coordinates = system.coordinates();
        let measure = |&m: &Measure| system.kinematics.measure(model, m);
        let kept: Vec<_> = kept.iter().map(|&row| &system.constraints[row]).collect();
        let turns = |m: &Measure| m.unit(model) == "rad";
        let is_angle_row = |c: &&bksim_mbs::constraint::Constraint| match c.source {
            Source::Drive(id) => {
                let drive = &model.drives[id.0];
                let kind = model.joints[drive.joint.0].kind.motions()[drive.motion_idx];
                kind == MotionKind::Rotation
            }
            _ => c.direction == "angle",
        };
        // Of unit size: angles, and the length of a quaternion.
        let is_number = |c: &&bksim_mbs::constraint::Constraint| {
            let is_coupled_turn =
                matches!(c.source, Source::Coupling(_)) && c.effort == MotionKind::Rotation;
            is_angle_row(c) || is_coupled_turn || matches!(c.source, Source::Quaternion(_))
        };
        let planar_turn = |c: &&bksim_mbs::constraint::Constraint| {
            is_angle_row(c)
                && (model.space == bksim_model::Space::Planar
                    || !matches!(c.source, Source::Joint(_)))
        };
        let expressions: Vec<Expr> = (kept.iter().map(|c| c.expression))
            .chain(bearing.iter().map(|stop| stop.expression))
            .chain(prescribed.iter().map(measure))
            .collect();
        // The gap of a stop counts whole turns.
        let is_angle: Vec<bool> = (kept.iter().map(planar_turn))
            .chain(bearing.iter().map(|_| false))
            .chain(prescribed.iter().map(turns))
            .collect();
        let is_unit: Vec<bool> = (kept.iter().map(is_number))
            .chain(bearing.iter().map(|stop| stop.motion == MotionKind::Rotation))
            .chain(prescribed.iter().map(turns))
            .collect();

        // Values, slopes that there are, and the rate at rest.
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let mut slopes = Vec::new();
        let mut outputs = expressions.clone();
        let mut velocities = Vec::new();
        let jacobian = pool.jacobian(&expressions, &q);
        for &(row, column, slope) in &jacobian.entries {
            slopes.push((row, column));
            outputs.push(slope);
        }
        let runs = clock == Clock::Running;
        for (row, &e) in expressions.iter().enumerate() {
            let rate = if runs { pool.diff(e, model.time) } else { pool.zero() };
            outputs.push(rate);
            let moving = jacobian.entries.iter().filter(|entry| entry.0 == row);
            let terms = moving.map(|&(_, i, slope)| pool.mul(slope, pool.symbol_expr(v[i])));
            velocities.push(pool.sum(terms.chain([rate]).collect::<Vec<_>>()));
        }
        let time_rate = if runs { pool.one() } else { pool.zero() };
        let rates: Vec<(SymbolId, Expr)> = (q.iter().zip(&v))
            .map(|(&q, &v)| (q, pool.symbol_expr(v)))
            .chain([(model.time, time_rate)])
            .collect();
        let gammas = pool.total_derivatives(&velocities, &rates);
        let symbols = system.parameters(model);
        let at_position = [&[model.time][..], &q].concat();
        let levels = Tape::compile(pool, &outputs, &at_position, &symbols)?;
        let gamma = Tape::compile(pool, &gammas, &[at_position, v].concat(), &symbols)?;
        let unit = |&is_number: &bool| if is_number { 1.0 } else { size };
        let is_length = |c: &Coordinate| c.kind == CoordinateKind::Length;
        Ok(Self {
            levels_space: levels.workspace(parameters),
            gamma_space: gamma.workspace(parameters),
            outputs: vec![0.0; levels.n_outputs()],
            levels,
            gamma,
            velocities: (velocities, time_rate),
            third: None,
            slopes,
            n_all: expressions.len(),
            n_prescribed: prescribed.len(),
            unit_of_column: coordinates.iter().map(|c| unit(&!is_length(c))).collect(),
            quaternions: (0..coordinates.len())
                .filter(|&i| coordinates[i].kind == CoordinateKind::Quaternion)
                .step_by(4)
                .collect(),
            is_turn: coordinates.iter().map(|c| c.kind == CoordinateKind::Angle).collect(),
            unit_of_row: is_unit.iter().map(unit).collect(),
            is_angle,
        })
    }

    /// Makes ready for [`jerks`](Self::jerks); parameters are those of the rows.
    pub(crate) fn add_jerks(
        &mut self,
        model: &Model,
        system: &SymbolicSystem,
        parameters: &[f64],
    ) -> Result<(), TapeError> {
        let pool = &model.pool;
        let of = |f: fn(&Coordinate) -> SymbolId| -> Vec<SymbolId> {
            system.coordinates().iter().map(f).collect()
        };
        let (q, v, a) = (of(|c| c.q), of(|c| c.v), of(|c| c.a));
        let pairs = [(&q, &v), (&v, &a)];
        let rates = pairs.into_iter().flat_map(|(of, rates)| {
            of.iter().zip(rates).map(|(&x, &rate)| (x, pool.symbol_expr(rate)))
        });
        let (velocities, time_rate) = &self.velocities;
        let rates: Vec<(SymbolId, Expr)> = rates.chain([(model.time, *time_rate)]).collect();
        let accelerations = pool.total_derivatives(velocities, &rates);
        let third = pool.total_derivatives(&accelerations, &rates);
        let inputs = [vec![model.time], q, v, a].concat();
        let tape = Tape::compile(pool, &third, &inputs, &system.parameters(model))?;
        let space = tape.workspace(parameters);
        self.third = Some((tape, space));
        Ok(())
    }

    /// True after [`add_jerks`](Self::add_jerks).
    pub(crate) fn has_jerks(&self) -> bool {
        self.third.is_some()
    }

    /// Third rates of the coordinates, where these have velocities and accelerations that the rows determine, SI; the
    /// prescribed measures have none.
    pub(crate) fn jerks(&mut self, t: f64, x: &[f64], [v, a]: [&[f64]; 2]) -> Option<Vec<f64>> {
        let u = vec![0.0; self.n_prescribed];
        let solver = Solver::of(&self.at(t, x, &u).jacobian)?;
        let inputs = [&[t], self.unscaled(x).as_slice(), v, a].concat();
        let (tape, space) = self.third.as_mut()?;
        let mut third = vec![0.0; self.n_all];
        tape.evaluate(space, &inputs, &mut third);
        let right = DVector::from_fn(self.n_all, |row, _| -third[row] / self.unit_of_row[row]);
        Some(self.unscaled(solver.solve(&right)?.as_slice()))
    }

    /// Gives the parameters other values.
    pub(crate) fn set_parameters(&mut self, parameters: &[f64]) {
        self.levels_space = self.levels.workspace(parameters);
        self.gamma_space = self.gamma.workspace(parameters);
        if let Some((tape, space)) = &mut self.third {
            *space = tape.workspace(parameters);
        }
    }

    /// Number of coordinates.
    pub(crate) fn n(&self) -> usize {
        self.unit_of_column.len()
    }

    /// Number of rows.
    pub(crate) fn n_rows(&self) -> usize {
        self.n_all
    }

    /// Number of the first row of a prescribed measure.
    pub(crate) fn first_prescribed(&self) -> usize {
        self.n_all - self.n_prescribed
    }

    /// Unit of a prescribed measure.
    pub(crate) fn unit_of_prescribed(&self, k: usize) -> f64 {
        self.unit_of_row[self.first_prescribed() + k]
    }

    /// Coordinates in their own units.
    pub(crate) fn unscaled(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.unit_of_column).map(|(x, unit)| x * unit).collect()
    }

    /// Coordinates in units of the mechanism.
    pub(crate) fn scaled(&self, q: &[f64]) -> Vec<f64> {
        q.iter().zip(&self.unit_of_column).map(|(q, unit)| q / unit).collect()
    }

    /// True of coordinates that show one pose: each no farther from the other than this, but for whole turns and the sign of
    /// quaternions.
    pub(crate) fn is_same(&self, x: &[f64], y: &[f64], near: f64) -> bool {
        let is_near = |i: usize, sign: f64| {
            let off = x[i] - sign * y[i];
            (if self.is_turn[i] { wrapped(off) } else { off }).abs() < near
        };
        let mut i = 0;
        while i < x.len() {
            let of = if self.quaternions.contains(&i) { i..i + 4 } else { i..i + 1 };
            let is_turned = of.len() == 4 && of.clone().all(|i| is_near(i, -1.0));
            if !is_turned && !of.clone().all(|i| is_near(i, 1.0)) {
                return false;
            }
            i = of.end;
        }
        true
    }

    /// Rows at coordinates in units of the mechanism; `u` are the prescribed values, SI.
    pub(crate) fn at(&mut self, t: f64, x: &[f64], u: &[f64]) -> RowsAt {
        let inputs: Vec<f64> = std::iter::once(t).chain(self.unscaled(x)).collect();
        self.levels.evaluate(&mut self.levels_space, &inputs, &mut self.outputs);
        let (m, n) = (self.n_all, self.n());
        let mut value = DVector::from_column_slice(&self.outputs[..m]);
        for (k, u) in u.iter().enumerate() {
            value[m - self.n_prescribed + k] -= u;
        }
        for row in (0..m).filter(|&row| self.is_angle[row]) {
            value[row] = wrapped(value[row]);
        }
        let mut jacobian = DMatrix::zeros(m, n);
        for (&(row, column), slope) in self.slopes.iter().zip(&self.outputs[m..]) {
            jacobian[(row, column)] = slope * self.unit_of_column[column] / self.unit_of_row[row];
        }
        let mut rate = DVector::from_column_slice(&self.outputs[m + self.slopes.len()..]);
        for row in 0..m {
            value[row] /= self.unit_of_row[row];
            rate[row] /= self.unit_of_row[row];
        }
        RowsAt { value, jacobian, rate }
    }

    /// Velocities, from ∂Φ/∂q v + ∂Φ/∂t = u̇, and accelerations, from ∂Φ/∂q a + γ = ü, where the rows
    /// determine them; SI.
    pub(crate) fn rates(
        &mut self,
        t: f64,
        x: &[f64],
        (u_dot, u_ddot): (&[f64], &[f64]),
    ) -> Option<[Vec<f64>; 2]> {
        let u = vec![0.0; self.n_prescribed];
        let at = self.at(t, x, &u);
        let solver = Solver::of(&at.jacobian)?;
        let first = self.first_prescribed();
        let mut right = -at.rate;
        for (k, u_dot) in u_dot.iter().enumerate() {
            right[first + k] += u_dot / self.unit_of_row[first + k];
        }
        let v = self.unscaled(solver.solve(&right)?.as_slice());
        let inputs: Vec<f64> =
            std::iter::once(t).chain(self.unscaled(x)).chain(v.iter().copied()).collect();
        let mut gamma = vec![0.0; self.n_all];
        self.gamma.evaluate(&mut self.gamma_space, &inputs, &mut gamma);
        let mut right = DVector::from_fn(self.n_all, |row, _| -gamma[row] / self.unit_of_row[row]);
        for (k, u_ddot) in u_ddot.iter().enumerate() {
            right[first + k] += u_ddot / self.unit_of_row[first + k];
        }
        let a = self.unscaled(solver.solve(&right)?.as_slice());
        Some([v, a])
    }
}

/// Linear equations that determine their unknowns, with as many rows as columns or, where some follow
/// from others, more.
pub(crate) enum Solver {
    /// Factors with pivots.
    Square(nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>),
    /// By least squares: rows that follow from others agree.
    Tall(Box<Svd>),
}

impl Solver {
    /// Factors of a matrix; `None` for one without entries.
    pub(crate) fn of(matrix: &DMatrix<f64>) -> Option<Self> {
        if matrix.iter().any(|entry| !entry.is_finite()) {
            return None;
        }
        Some(if matrix.is_square() {
            Self::Square(matrix.clone().lu())
        } else {
            Self::Tall(Box::new(Svd::new(matrix)?))
        })
    }

    /// The solution; `None` where it is not finite or not determined.
    pub(crate) fn solve(&self, right: &DVector<f64>) -> Option<DVector<f64>> {
        let x = match self {
            Self::Square(lu) => lu.solve(right)?,
            Self::Tall(svd) => {
                if rank_of(&svd.singular_values) < svd.v_t.ncols() {
                    return None;
                }
                svd.solve(right, 0.0)
            }
        };
        x.iter().all(|value| value.is_finite()).then_some(x)
    }
}

/// Singular values below this part of the largest count as zero.
pub(crate) const RANK_TOLERANCE: f64 = 1e-9;

/// Number of singular values that are not zero.
pub(crate) fn rank_of(values: &DVector<f64>) -> usize {
    let largest = values.iter().fold(0.0, |a: f64, b| a.max(*b));
    values.iter().filter(|value| **value > RANK_TOLERANCE * largest).count()
}

/// Rank of a matrix.
pub(crate) fn rank(matrix: &DMatrix<f64>) -> usize {
    if matrix.nrows() == 0 || matrix.ncols() == 0 {
        return 0;
    }
    Svd::values(matrix).map_or(0, |values| rank_of(&values))
}

/// An angle without its whole turns, in −π ..= π.
pub(crate) fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::TAU;
    angle - TAU * (angle / TAU).round()
}
