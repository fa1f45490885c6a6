//! Closing the mechanism: positions and velocities that satisfy the constraints and what the author
//! stated, as near to the guesses as possible, and what stands in the way when there are none.

use std::collections::BTreeMap;

use bksim_expr::{Expr, SymbolId, Tape, TapeError, Workspace};

use crate::evaluator::Evaluator;
use crate::linear::rows::{SparseRows, length, shortest_solution};
use crate::multiplier::largest;
use crate::start_error::{Conflict, Moved, StartError};
use bksim_mbs::constraint::Source;
use bksim_mbs::kinematics::{Kinematics, Owner};
use bksim_mbs::system::SymbolicSystem;
use bksim_mbs::tree::Tree;
use bksim_model::{Axis, Initial, JointId, Measure, Model, Space};

/// Constraints count as closed below this, relative to the size of the mechanism.
const CLOSURE_TOLERANCE: f64 = 1e-10;

/// What a model says about its start, as functions of numbers: they serve every parameter value.
#[derive(Clone, Debug)]
pub(crate) struct Closure {
    initial: Vec<Initial>,
    /// Every initial value's measure, then its slopes by q (positions) or v (velocities).
    measures: Tape,
    /// The coordinates that each of these slopes is by.
    moving: Vec<Vec<usize>>,
    /// The stated and guessed values.
    stated: Tape,
    /// The system's coordinates by those of a tree without cuts.
    guess: Tape,
    /// The initial value that each coordinate of that tree has, if one.
    given: Vec<Option<usize>>,
    gap_of_joint: Vec<JointId>,
    /// The first drive.
    drive_idx: Option<usize>,
}

/// These functions at one set of parameters.
pub(crate) struct Closing<'a> {
    of: &'a Closure,
    parameters: &'a [f64],
    workspace: Workspace,
    stated: Vec<f64>,
}

/// Equations values = 0 near a state, with their slopes by q or v.
struct Equations {
    values: Vec<f64>,
    gradients: SparseRows,
}

impl Closure {
    pub(crate) fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let pool = &model.pool;
        let symbols = |of: fn(&bksim_mbs::kinematics::Coordinate) -> SymbolId| -> Vec<SymbolId> {
            system.coordinates().iter().map(of).collect()
        };
        let (q, v) = (symbols(|c| c.q), symbols(|c| c.v));
        let (mut outputs, mut moving) = (Vec::new(), Vec::new());
        for initial in &model.initial {
            let measure = system.kinematics.measure(model, initial.measure);
            outputs.push(measure);
            let symbols = if is_velocity(initial.measure) { &v } else { &q };
            let coordinates = system.kinematics.coordinates_in(pool, &[measure]);
            let by: Vec<SymbolId> = coordinates.iter().map(|&i| symbols[i]).collect();
            outputs.extend(pool.gradient(measure, &by));
            moving.push(coordinates);
        }
        let inputs = [vec![model.time], q, v].concat();
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let values: Vec<Expr> = model.initial.iter().map(|i| i.value).collect();
        let first_drive = system.constraints.iter().find_map(|c| match c.source {
            Source::Drive(drive) => Some(drive.0),
            _ => None,
        });
        let (guess, given) = uncut_guess(model, system, &symbols)?;
        Ok(Self {
            initial: model.initial.clone(),
            measures: Tape::compile(pool, &outputs, &inputs, &symbols)?,
            moving,
            stated: Tape::compile(pool, &values, &[], &symbols)?,
            guess,
            given,
            gap_of_joint: system.constraints.iter().map(|c| c.source.joint(model)).collect(),
            drive_idx: first_drive,
        })
    }

    /// At these parameter values, some initial values replaced.
    pub(crate) fn at<'a>(
        &'a self,
        parameters: &'a [f64],
        replaced: &[(usize, f64)],
    ) -> Closing<'a> {
        let mut stated = vec![0.0; self.initial.len()];
        self.stated.evaluate(&mut self.stated.workspace(parameters), &[], &mut stated);
        for &(initial_idx, value) in replaced {
            stated[initial_idx] = value;
        }
        let workspace = self.measures.workspace(parameters);
        Closing { of: self, parameters, workspace, stated }
    }
}

/// The system's coordinates as functions of those of a tree without cuts, and the initial value that
/// each of the latter has.
fn uncut_guess(
    model: &Model,
    system: &SymbolicSystem,
    parameters: &[SymbolId],
) -> Result<(Tape, Vec<Option<usize>>), TapeError> {
    let uncut = Kinematics::along(model, &Tree::uncut(model));
    let found = |measure: Measure| model.initial.iter().position(|i| i.measure == measure);
    let given =
        |c: &bksim_mbs::kinematics::Coordinate| measure_of(model.space, c.owner).and_then(found);
    let measures: Vec<Expr> = system
        .coordinates()
        .iter()
        .map(|c| match measure_of(model.space, c.owner) {
            Some(measure) => uncut.measure(model, measure),
            None => model.pool.zero(),
        })
        .collect();
    let symbols = uncut.coordinates.iter().map(|c| c.q);
    let inputs: Vec<SymbolId> = std::iter::once(model.time).chain(symbols).collect();
    let tape = Tape::compile(&model.pool, &measures, &inputs, parameters)?;
    Ok((tape, uncut.coordinates.iter().map(given).collect()))
}

impl Closing<'_> {
    /// Measures of the initial values that `which` selects: value minus stated value, gradient.
    fn rows(&mut self, which: &[usize], t: f64, q: &[f64], v: &[f64]) -> Equations {
        let mut outputs = vec![0.0; self.of.measures.n_outputs()];
        let inputs = [&[t], q, v].concat();
        self.of.measures.evaluate(&mut self.workspace, &inputs, &mut outputs);
        let mut rest = outputs.as_slice();
        let measured = self.of.moving.iter().map(|moving| {
            let (row, others) = rest.split_at(1 + moving.len());
            rest = others;
            row
        });
        let measured: Vec<&[f64]> = measured.collect();
        let mut gradients = SparseRows::new(q.len());
        for &k in which {
            let slopes = measured[k][1..].iter().copied();
            gradients.push(self.of.moving[k].iter().copied().zip(slopes));
        }
        let values = which.iter().map(|&k| measured[k][0] - self.stated[k]).collect();
        Equations { values, gradients }
    }

    fn select(&self, keep: impl Fn(&Initial) -> bool) -> Vec<usize> {
        (0..self.of.initial.len()).filter(|&k| keep(&self.of.initial[k])).collect()
    }

    pub(crate) fn close_positions(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
    ) -> Result<Vec<f64>, StartError> {
        let all = self.select(|i| !is_velocity(i.measure));
        let stated = self.select(|i| !is_velocity(i.measure) && !i.is_guess);

        // From the shape that the tree gives, towards everything the author said about positions,
        // then onto the constraints, holding what was stated.
        let mut q = self.first_guess(t);
        self.descend(evaluator, &all, false, t, &mut q);
        let guess = q.clone();
        let left = self.descend(evaluator, &stated, true, t, &mut q);
        if q.iter().any(|value| !value.is_finite()) || !left.is_finite() {
            return Err(StartError::NotFinite);
        }
        if left <= CLOSURE_TOLERANCE * size(&q) {
            drop_rounding(&mut q);
            return Ok(q);
        }

        // Without the stated values: is it they, or the joints themselves?
        let mut free = guess.clone();
        let open = self.descend(evaluator, &[], true, t, &mut free);
        if open > CLOSURE_TOLERANCE * size(&free) {
            return Err(self.cannot_close(evaluator, t, free));
        }
        let conflicts = stated
            .iter()
            .map(|&k| {
                let others: Vec<usize> = stated.iter().copied().filter(|&o| o != k).collect();
                let mut q = guess.clone();
                let open = self.descend(evaluator, &others, true, t, &mut q);
                let zero = vec![0.0; q.len()];
                let found = self.rows(&[k], t, &q, &zero).values[0] + self.stated[k];
                let closed = open <= CLOSURE_TOLERANCE * size(&q);
                Conflict {
                    initial_idx: k,
                    stated: self.stated[k],
                    consistent: closed.then_some(found),
                }
            })
            .collect();
        Err(StartError::StatedPositions { conflicts })
    }

    /// Positions of a tree without cuts at the joint values the author gave, read off in the
    /// coordinates of the system's own tree.
    fn first_guess(&self, t: f64) -> Vec<f64> {
        let Closure { guess, given, .. } = self.of;
        let values = given.iter().map(|given| given.map_or(0.0, |k| self.stated[k]));
        let inputs: Vec<f64> = std::iter::once(t).chain(values).collect();
        let mut q = vec![0.0; guess.n_outputs()];
        guess.evaluate(&mut guess.workspace(self.parameters), &inputs, &mut q);
        q
    }

    /// Damped Gauss–Newton on the chosen measures and, if asked, the constraints; returns what is
    /// left of the largest row.
    fn descend(
        &mut self,
        evaluator: &mut Evaluator,
        which: &[usize],
        with_constraints: bool,
        t: f64,
        q: &mut Vec<f64>,
    ) -> f64 {
        const MAX_STEPS: usize = 200;
        let mut rows = self.position_rows(evaluator, which, with_constraints, t, q);
        for _ in 0..MAX_STEPS {
            let norm = length(&rows.values);
            if !(norm > 0.0 && norm.is_finite()) {
                break;
            }
            let step = shortest_solution(&rows.gradients, &rows.values);
            let mut damping = 1.0;
            let improved = loop {
                let trial: Vec<f64> =
                    q.iter().zip(step.iter()).map(|(q, s)| q - damping * s).collect();
                let next = self.position_rows(evaluator, which, with_constraints, t, &trial);
                let reached = length(&next.values);
                if reached < norm * (1.0 - 1e-4 * damping) {
                    *q = trial;
                    rows = next;
                    break true;
                }
                damping *= 0.5;
                if damping < 1e-6 {
                    break false;
                }
            };
            if !improved {
                break;
            }
        }
        largest(&rows.values)
    }

    fn position_rows(
        &mut self,
        evaluator: &mut Evaluator,
        which: &[usize],
        with_constraints: bool,
        t: f64,
        q: &[f64],
    ) -> Equations {
        let zero = vec![0.0; q.len()];
        let measured = self.rows(which, t, q, &zero);
        if !with_constraints {
            return measured;
        }
        let at = evaluator.constraints(t, q);
        Equations { values: at.value.to_vec(), gradients: at.jacobian_rows() }.with(&measured)
    }

    fn cannot_close(&self, evaluator: &mut Evaluator, t: f64, q: Vec<f64>) -> StartError {
        let open = evaluator.constraints(t, &q).value;
        let mut squares: BTreeMap<JointId, f64> = BTreeMap::new();
        for (&joint, value) in self.of.gap_of_joint.iter().zip(open) {
            *squares.entry(joint).or_default() += value * value;
        }
        let mut gaps: Vec<(JointId, f64)> =
            squares.into_iter().map(|(joint, sum)| (joint, sum.sqrt())).collect();
        gaps.retain(|&(_, gap)| gap > CLOSURE_TOLERANCE * size(&q));
        gaps.sort_by(|a, b| b.1.total_cmp(&a.1));
        StartError::CannotClose { gaps, q }
    }

    pub(crate) fn fit_velocities(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        q: &[f64],
    ) -> Result<Vec<f64>, StartError> {
        let stated = self.select(|i| is_velocity(i.measure) && !i.is_guess);
        let guessed = self.select(|i| is_velocity(i.measure) && i.is_guess);
        let zero = vec![0.0; q.len()];
        let wish = self.rows(&guessed, t, q, &zero);
        let missing: Vec<f64> = wish.values.iter().map(|value| -value).collect();
        let guess = shortest_solution(&wish.gradients, &missing);

        let (v, left) = self.velocities(evaluator, &stated, t, q, &guess);
        if left <= CLOSURE_TOLERANCE * size(&v) {
            return Ok(v);
        }
        let (_, without) = self.velocities(evaluator, &[], t, q, &guess);
        if without > CLOSURE_TOLERANCE * size(&v) {
            return Err(match self.of.drive_idx {
                Some(drive_idx) => StartError::DriveCannotMove { drive_idx },
                None => StartError::NotFinite,
            });
        }
        let mut conflicts = Vec::new();
        for &k in &stated {
            let others: Vec<usize> = stated.iter().copied().filter(|&o| o != k).collect();
            let (v, left) = self.velocities(evaluator, &others, t, q, &guess);
            let found = self.rows(&[k], t, q, &v).values[0] + self.stated[k];
            let consistent = left <= CLOSURE_TOLERANCE * size(&v);
            conflicts.push(Conflict {
                initial_idx: k,
                stated: self.stated[k],
                consistent: consistent.then_some(found),
            });
        }
        Err(StartError::StatedVelocities { conflicts })
    }

    /// The velocities nearest to `guess` on the constraints and the stated rates, and what is left.
    fn velocities(
        &mut self,
        evaluator: &mut Evaluator,
        stated: &[usize],
        t: f64,
        q: &[f64],
        guess: &[f64],
    ) -> (Vec<f64>, f64) {
        let at_guess = self.rows(stated, t, q, guess);
        let at = evaluator.constraints(t, q);
        let rows = Equations { values: at.rate_of(guess), gradients: at.jacobian_rows() };
        let rows = rows.with(&at_guess);
        let step = shortest_solution(&rows.gradients, &rows.values);
        let done = rows.gradients.times(&step);
        let left: Vec<f64> =
            rows.values.iter().zip(done).map(|(value, done)| value - done).collect();
        (guess.iter().zip(&step).map(|(v, step)| v - step).collect(), largest(&left))
    }

    pub(crate) fn moved(&mut self, t: f64, q: &[f64], v: &[f64]) -> Vec<Moved> {
        let all: Vec<usize> = (0..self.of.initial.len()).collect();
        let off = self.rows(&all, t, q, v).values;
        let moved = |k: usize| Moved {
            name: self.of.initial[k].name.clone(),
            stated: self.stated[k],
            found: self.stated[k] + off[k],
            is_guess: self.of.initial[k].is_guess,
        };
        all.iter().map(|&k| moved(k)).collect()
    }
}

/// The measure that a coordinate is; Cardan angles of a free body are none.
fn measure_of(space: Space, owner: Owner) -> Option<Measure> {
    Some(match (owner, space) {
        (Owner::Joint(joint, motion_idx), _) => Measure::JointPosition(joint, motion_idx),
        (Owner::Body(body, 0), _) => Measure::PointPosition(body, None, Axis::X),
        (Owner::Body(body, 1), _) => Measure::PointPosition(body, None, Axis::Y),
        (Owner::Body(body, _), Space::Planar) => Measure::BodyAngle(body),
        (Owner::Body(body, 2), Space::Spatial) => Measure::PointPosition(body, None, Axis::Z),
        (Owner::Body(..), Space::Spatial) => return None,
    })
}

pub(crate) fn is_velocity(measure: Measure) -> bool {
    matches!(
        measure,
        Measure::JointVelocity(..) | Measure::PointVelocity(..) | Measure::BodyRate(..)
    )
}

impl Equations {
    /// These and some more.
    fn with(mut self, more: &Self) -> Self {
        self.values.extend(&more.values);
        for row in 0..more.gradients.n_rows() {
            self.gradients.push(more.gradients.row(row).iter().copied());
        }
        self
    }
}

/// Replaces what rounding has left of a zero by zero, so that a crank held at 0 starts at 0.
fn drop_rounding(q: &mut [f64]) {
    let rounding = 0.1 * f64::EPSILON * size(q);
    q.iter_mut().filter(|value| value.abs() < rounding).for_each(|value| *value = 0.0);
}

/// Size of a state, for relative tolerances: at least one.
fn size(state: &[f64]) -> f64 {
    state.iter().fold(1.0, |size: f64, value| size.max(value.abs()))
}
