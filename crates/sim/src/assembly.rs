//! Closing the mechanism: positions and velocities that satisfy the constraints and what the author
//! stated, as near to the guesses as possible, and what stands in the way when there are none.

mod parts;
mod positions;
mod scale;
mod search;
mod sequence;
mod turns;
mod velocities;
mod walk;

use bksim_expr::{Expr, SymbolId, Tape, TapeError, Workspace};

use self::scale::Units;
use crate::evaluator::Evaluator;
use crate::linear::rows::SparseRows;
use crate::start_error::Moved;
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
    units: Units,
    /// The coordinate that each initial value is of, if of one alone.
    own: Vec<Option<usize>>,
    /// Constraint rows that prescribe a coordinate, and it.
    driven: Vec<(usize, usize)>,
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
        let own = model.initial.iter().zip(&moving).map(|(initial, moving)| {
            let &[column] = moving.as_slice() else { return None };
            let is_own = !is_velocity(initial.measure)
                && system.kinematics.measure(model, initial.measure)
                    == pool.symbol_expr(system.coordinates()[column].q);
            is_own.then_some(column)
        });
        let own = own.collect();
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
            units: Units::of(model, system, &symbols)?,
            own,
            driven: driven_coordinates(model, system),
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

/// Rows of drives on joints of the tree, each with the coordinate that it prescribes.
fn driven_coordinates(model: &Model, system: &SymbolicSystem) -> Vec<(usize, usize)> {
    let rows = system.constraints.iter().enumerate();
    let driven = |(row, constraint): (usize, &bksim_mbs::constraint::Constraint)| {
        let Source::Drive(id) = constraint.source else { return None };
        let drive = &model.drives[id.0];
        let owner = Owner::Joint(drive.joint, drive.motion_idx);
        Some((row, system.coordinates().iter().position(|c| c.owner == owner)?))
    };
    rows.filter_map(driven).collect()
}

impl Closing<'_> {
    /// The coordinates that some initial values are of.
    fn own_coordinates(&self, initial: &[usize]) -> Vec<bool> {
        let mut is_own = vec![false; self.of.units.is_turn.len()];
        initial.iter().filter_map(|&k| self.of.own[k]).for_each(|column| is_own[column] = true);
        is_own
    }

    /// The coordinates that are stated or driven.
    fn fixed(&self, stated: &[usize]) -> Vec<bool> {
        let mut is_fixed = self.own_coordinates(stated);
        self.of.driven.iter().for_each(|&(_, column)| is_fixed[column] = true);
        is_fixed
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

/// Size of a state, for relative tolerances: at least one.
fn size(state: &[f64]) -> f64 {
    state.iter().fold(1.0, |size: f64, value| size.max(value.abs()))
}
