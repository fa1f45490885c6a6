//! Closing the mechanism: positions and velocities that satisfy the constraints and what the author
//! stated, as near to the guesses as possible, and what stands in the way when there are none.

mod equations;
mod normal;
mod parts;
mod positions;
mod scale;
mod search;
mod sequence;
mod sides;
mod turns;
mod velocities;
mod walk;
mod ways;
mod weighted;

use std::collections::HashMap;

use bksim_expr::{Expr, SymbolId, Tape, TapeError};

use self::equations::{Equations, Numbers, SlopeBuffers, WithSlopes};
use self::scale::Units;
pub(crate) use self::sides::take_sides;
use crate::evaluator::Evaluator;
use crate::start_error::Moved;
use bksim_mbs::constraint::Source;
use bksim_mbs::coordinate::Owner;
use bksim_mbs::kinematics::Kinematics;
use bksim_mbs::spatial::Quaternions;
use bksim_mbs::system::SymbolicSystem;
use bksim_mbs::tree::Tree;
use bksim_model::flexible::Flexible;
use bksim_model::{Axis, BodyId, Drive, Initial, JointId, Measure, Model, Space};

/// Constraints count as closed below this, relative to the size of the mechanism.
const CLOSURE_TOLERANCE: f64 = 1e-10;

/// The conditions of a model's start, as functions of numbers: they serve every parameter value.
#[derive(Clone, Debug)]
pub(crate) struct Closure {
    initial: Vec<Initial>,
    /// Every initial value's measure, with its slopes by q (positions) or v (velocities).
    measures: WithSlopes,
    /// Derivatives by q of 1 − cos, for cosines that are one where the axes of cut joints are alike.
    senses: WithSlopes,
    /// The cut joint that each of these is of.
    joint_of_sense: Vec<JointId>,
    /// The stated and guessed values.
    stated: Tape,
    /// The system's coordinates by those of a tree without cuts.
    guess: Tape,
    /// The initial value that each coordinate of that tree has, if one.
    given: Vec<Option<usize>>,
    gap_of_joint: Vec<Option<JointId>>,
    units: Units,
    /// The coordinate that each initial value is of, if of one alone.
    own: Vec<Option<usize>>,
    /// Constraint rows that prescribe a coordinate, and it.
    driven: Vec<(usize, usize)>,
    /// Rows of drives, and which drive each is of.
    drives: Vec<(usize, usize)>,
    /// Coordinates of shapes of beams whose positions, and whose rates, are not stated: none bends to close a loop unless it must.
    shapes: [Vec<usize>; 2],
}

/// These functions at one set of parameters.
pub(crate) struct Closing<'a> {
    of: &'a Closure,
    parameters: &'a [f64],
    measures: SlopeBuffers,
    senses: SlopeBuffers,
    /// The values that the initial ones are held at: as written, but for whole turns.
    stated: Vec<f64>,
    /// The values that the author wrote.
    written: Vec<f64>,
    /// True while shapes of beams are held.
    is_unbent: bool,
}

impl Closure {
    pub(crate) fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let pool = &model.pool;
        let symbols = |of: fn(&bksim_mbs::coordinate::Coordinate) -> SymbolId| -> Vec<SymbolId> {
            system.coordinates().iter().map(of).collect()
        };
        let (q, v) = (symbols(|c| c.q), symbols(|c| c.v));
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let measures: Vec<(Expr, &[SymbolId])> = model
            .initial
            .iter()
            .map(|initial| {
                let by = if initial.measure.is_velocity() { &v } else { &q };
                (system.kinematics.measure(model, initial.measure), by.as_slice())
            })
            .collect();
        let inputs = [vec![model.time], q.clone(), v.clone()].concat();
        let measures = WithSlopes::compile(system, pool, &measures, (&inputs, &symbols))?;
        let (joint_of_sense, senses): (Vec<JointId>, Vec<Expr>) =
            senses(model, system).into_iter().unzip();
        let senses: Vec<(Expr, &[SymbolId])> =
            senses.into_iter().map(|sense| (sense, q.as_slice())).collect();
        let senses = WithSlopes::compile(system, pool, &senses, (&inputs, &symbols))?;
        let values: Vec<Expr> = model.initial.iter().map(|i| i.value).collect();
        let own = model.initial.iter().zip(&measures.moving).map(|(initial, moving)| {
            let &[column] = moving.as_slice() else { return None };
            let is_own = !initial.measure.is_velocity()
                && system.kinematics.measure(model, initial.measure)
                    == pool.symbol_expr(system.coordinates()[column].q);
            is_own.then_some(column)
        });
        let own = own.collect();
        let rows = system.constraints.iter().enumerate();
        let drives = rows.filter_map(|(row, c)| match c.source {
            Source::Drive(drive) => Some((row, drive.0)),
            _ => None,
        });
        let drives = drives.collect();
        let (guess, given) = uncut_guess(model, system, &symbols)?;
        Ok(Self {
            initial: model.initial.clone(),
            measures,
            senses,
            joint_of_sense,
            stated: Tape::compile(pool, &values, &[], &symbols)?,
            guess,
            given,
            units: Units::of(model, system, &symbols)?,
            own,
            driven: driven_coordinates(model, system),
            gap_of_joint: system.constraints.iter().map(|c| c.source.joint(model)).collect(),
            drives,
            shapes: [false, true].map(|is_rate| shapes(model, system, is_rate)),
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
        let [measures, senses] = [&self.measures, &self.senses].map(|f| f.buffers(parameters));
        let written = stated.clone();
        Closing { of: self, parameters, measures, senses, stated, written, is_unbent: false }
    }
}

/// The system's coordinates as functions of those of a tree without cuts, and the initial value that
/// each of the latter has.
fn uncut_guess(
    model: &Model,
    system: &SymbolicSystem,
    parameters: &[SymbolId],
) -> Result<(Tape, Vec<Option<usize>>), TapeError> {
    let pool = &model.pool;
    let uncut = Kinematics::of_start(model, &Tree::uncut(model));
    // The first of each measure.
    let initial = model.initial.iter().enumerate().rev();
    let places: HashMap<Measure, usize> = initial.map(|(idx, i)| (i.measure, idx)).collect();
    let found = |measure: Measure| places.get(&measure).copied();
    let given =
        |c: &bksim_mbs::coordinate::Coordinate| measure_of(model.space, c.owner).and_then(found);
    // A quaternion is that of its body against the parent, or in its joint.
    let mut quaternions = Quaternions::default();
    let mut turned = |body: BodyId| match system.tree.joint_of(body) {
        None => quaternions.of(pool, &uncut.poses[body.0].rotation),
        Some(joint) => {
            let joint = &model.joints[joint.0];
            bksim_mbs::joint::rotation(pool, joint, &uncut.sides(model, joint)).quaternion(pool)
        }
    };
    let measures: Vec<Expr> = system
        .coordinates()
        .iter()
        .map(|c| match (measure_of(model.space, c.owner), c.owner) {
            (Some(measure), _) => uncut.measure(model, measure),
            (None, Owner::Quaternion(body, part)) => turned(body).0[part],
            (None, Owner::Joint(..) | Owner::Body(..) | Owner::State(_)) => pool.zero(),
        })
        .collect();
    // Ways of belts count from where the start puts their wheels, and there need be none elsewhere: what a drive
    // prescribes is taken from the first guess on.
    let own_drive = |c: &bksim_mbs::coordinate::Coordinate| {
        let is_own = |drive: &&Drive| c.owner == Owner::Joint(drive.joint, drive.motion_idx);
        Some((c.q, model.drives.iter().find(is_own)?.motion))
    };
    let prescribed: Vec<(SymbolId, Expr)> = if model.at_start.is_empty() {
        Vec::new()
    } else {
        uncut.coordinates.iter().filter_map(own_drive).collect()
    };
    // All at once: the measures of a long chain have most of their parts in common.
    let measures = pool.substitute_all(&measures, &prescribed);
    let symbols = uncut.coordinates.iter().map(|c| c.q);
    let inputs: Vec<SymbolId> = std::iter::once(model.time).chain(symbols).collect();
    let tape = Tape::compile(&model.pool, &measures, &inputs, parameters)?;
    Ok((tape, uncut.coordinates.iter().map(given).collect()))
}

/// 1 − cosine of the axes that are alike where a cut joint holds; angles in the plane tell by
/// themselves, but those of curves that touch.
fn senses(model: &Model, system: &SymbolicSystem) -> Vec<(JointId, Expr)> {
    let pool = &model.pool;
    let of_joint = |&id: &JointId| {
        let joint = &model.joints[id.0];
        let is_told = model.space == Space::Planar && joint.kind.second_curve().is_none();
        let sides = (!is_told).then(|| system.kinematics.sides(model, joint));
        let cosines =
            sides.map_or_else(Vec::new, |sides| bksim_mbs::joint::alignments(pool, joint, &sides));
        cosines.into_iter().map(move |cosine| (id, pool.sub(pool.one(), cosine)))
    };
    system.tree.cuts.iter().flat_map(of_joint).collect()
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

/// The coordinates of shapes of beams, but for those whose positions, or rates, are stated.
fn shapes(model: &Model, system: &SymbolicSystem, is_rate: bool) -> Vec<usize> {
    let is_stated = |joint: JointId| {
        let of = |measure: Measure| match measure {
            Measure::JointPosition(own, _) => !is_rate && own == joint,
            Measure::JointVelocity(own, _) => is_rate && own == joint,
            _ => false,
        };
        model.initial.iter().any(|initial| of(initial.measure))
    };
    let beams = model.bodies.iter().filter_map(|body| body.flexible.as_ref());
    let free: Vec<JointId> =
        beams.flat_map(Flexible::shapes).filter(|shape| !is_stated(*shape)).collect();
    let is_shape = |owner: Owner| matches!(owner, Owner::Joint(joint, _) if free.contains(&joint));
    let coordinates = system.coordinates().iter().enumerate();
    coordinates.filter(|(_, c)| is_shape(c.owner)).map(|(column, _)| column).collect()
}

impl Closing<'_> {
    /// The coordinates that some initial values are of.
    fn own_coordinates(&self, initial: &[usize]) -> Vec<bool> {
        let mut is_own = vec![false; self.of.units.is_turn.len()];
        initial.iter().filter_map(|&k| self.of.own[k]).for_each(|column| is_own[column] = true);
        is_own
    }

    /// The coordinates that are stated, or driven by rows that are not `released`.
    fn fixed(&self, stated: &[usize], released: &[usize]) -> Vec<bool> {
        let mut is_fixed = self.own_coordinates(stated);
        for (row, column) in &self.of.driven {
            is_fixed[*column] |= !released.contains(row);
        }
        if self.is_unbent {
            self.of.shapes[0].iter().for_each(|&column| is_fixed[column] = true);
        }
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
        let mut rows = Equations::new(q.len());
        if with_constraints {
            evaluator.constraints(t, q).add_to(&mut rows);
        }
        // Measures of positions do not ask for velocities.
        self.add_rows(which, (t, q, q), &mut rows);
        rows
    }

    /// Writes the numbers of [`Self::position_rows`].
    fn write_position_numbers(
        &mut self,
        evaluator: &mut Evaluator,
        (which, with_constraints): (&[usize], bool),
        (t, q): (f64, &[f64]),
        to: &mut Numbers,
    ) {
        to.clear();
        if with_constraints {
            evaluator.constraints(t, q).add_numbers_to(to);
        }
        self.add_numbers(which, (t, q), to);
    }

    /// Measures of the initial values that `which` selects: value minus stated value, gradient.
    fn rows(&mut self, which: &[usize], t: f64, q: &[f64], v: &[f64]) -> Equations {
        let mut rows = Equations::new(q.len());
        self.add_rows(which, (t, q, v), &mut rows);
        rows
    }

    /// Adds [`Self::rows`] to other equations.
    fn add_rows(&mut self, which: &[usize], state: (f64, &[f64], &[f64]), to: &mut Equations) {
        let Self { of, measures, stated, .. } = self;
        let first = to.values.len();
        of.measures.add_to(to, measures, which.iter().copied(), state);
        to.values[first..].iter_mut().zip(which).for_each(|(value, &k)| *value -= stated[k]);
    }

    /// 1 − cos, for cosines that are one where the axes of cut joints are alike.
    fn sense_rows(&mut self, t: f64, q: &[f64]) -> Equations {
        let mut rows = Equations::new(q.len());
        self.add_sense_rows(t, q, &mut rows);
        rows
    }

    /// Adds the numbers of [`Self::rows`] of measures of positions.
    fn add_numbers(&mut self, which: &[usize], (t, q): (f64, &[f64]), to: &mut Numbers) {
        let Self { of, measures, stated, .. } = self;
        let first = to.values.len();
        if which.iter().all(|&k| of.own[k].is_some()) {
            // Coordinates need no functions.
            to.values.extend(which.iter().filter_map(|&k| of.own[k]).map(|column| q[column]));
            to.slopes.resize(to.slopes.len() + which.len(), 1.0);
        } else {
            of.measures.add_numbers_to(to, measures, which.iter().copied(), (t, q, q));
        }
        to.values[first..].iter_mut().zip(which).for_each(|(value, &k)| *value -= stated[k]);
    }

    /// Adds the numbers of [`Self::sense_rows`].
    fn add_sense_numbers(&mut self, (t, q): (f64, &[f64]), to: &mut Numbers) {
        let Self { of, senses, .. } = self;
        of.senses.add_numbers_to(to, senses, 0..of.joint_of_sense.len(), (t, q, q));
    }

    /// Adds [`Self::sense_rows`] to other equations.
    fn add_sense_rows(&mut self, t: f64, q: &[f64], to: &mut Equations) {
        let Self { of, senses, .. } = self;
        of.senses.add_to(to, senses, 0..of.joint_of_sense.len(), (t, q, q));
    }

    fn select(&self, keep: impl Fn(&Initial) -> bool) -> Vec<usize> {
        (0..self.of.initial.len()).filter(|&k| keep(&self.of.initial[k])).collect()
    }

    /// The longest link, m.
    pub(crate) fn longest_link(&self) -> f64 {
        self.of.units.longest_link(self.parameters)
    }

    pub(crate) fn moved(&mut self, t: f64, q: &[f64], v: &[f64]) -> Vec<Moved> {
        let all: Vec<usize> = (0..self.of.initial.len()).collect();
        let off = self.rows(&all, t, q, v).values;
        let moved = |k: usize| Moved {
            name: self.of.initial[k].name.clone(),
            stated: self.written[k],
            found: self.stated[k] + off[k],
            is_guess: self.of.initial[k].is_guess,
        };
        all.iter().map(|&k| moved(k)).collect()
    }
}

/// The measure that a coordinate is; parts of a quaternion and integrals of states are none.
fn measure_of(space: Space, owner: Owner) -> Option<Measure> {
    Some(match (owner, space) {
        (Owner::Joint(joint, motion_idx), _) => Measure::JointPosition(joint, motion_idx),
        (Owner::Body(body, 0), _) => Measure::PointPosition(body, None, Axis::X),
        (Owner::Body(body, 1), _) => Measure::PointPosition(body, None, Axis::Y),
        (Owner::Body(body, _), Space::Planar) => Measure::BodyAngle(body),
        (Owner::Body(body, 2), Space::Spatial) => Measure::PointPosition(body, None, Axis::Z),
        (Owner::Body(body, motion_idx), Space::Spatial) => {
            Measure::CardanAngle(body, motion_idx - 3)
        }
        (Owner::Quaternion(..) | Owner::State(_), _) => return None,
    })
}

/// Size of a state, for relative tolerances: at least one.
fn size(state: &[f64]) -> f64 {
    state.iter().fold(1.0, |size: f64, value| size.max(value.abs()))
}
