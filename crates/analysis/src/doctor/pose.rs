//! [`Placed`]: a mechanism in one pose, every joint by its constraint rows, whatever coordinates it was closed in.

use bksim_expr::{Expr, SymbolId, Tape};
use bksim_mbs::assemble::assemble_positions;
use bksim_mbs::constraint::{Constraint, Source};
use bksim_mbs::coordinate::{CoordinateKind, Owner};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{BodyId, CoordinatePolicy, JointId, Model};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, UnitQuaternion};

use crate::error::AnalysisError;
use crate::positions::Positions;

/// Where the bodies of a closed mechanism are.
#[derive(Clone, Debug)]
pub(crate) struct Pose {
    /// Time, s.
    t: f64,
    /// The longest link, m.
    pub(crate) size: f64,
    /// Centres of mass, world axes, m.
    coms: Vec<[f64; 3]>,
    /// Rotations of the bodies.
    rotations: Vec<Matrix3<f64>>,
    /// Point and axis of each joint, world axes.
    pub(crate) axes: Vec<[[f64; 3]; 2]>,
    /// Positions of the motions of each joint, rad and m.
    motions: Vec<Vec<f64>>,
    /// Values of the parameters.
    parameters: Vec<f64>,
}

impl Pose {
    /// The pose that `positions` closed in.
    pub(crate) fn of(positions: &Positions) -> Result<Self, AnalysisError> {
        let (model, system) = (positions.model(), positions.system());
        let pool = &model.pool;
        let kinematics = &system.kinematics;
        let mut outputs: Vec<Expr> = Vec::new();
        for (idx, pose) in kinematics.poses.iter().enumerate() {
            outputs.extend(kinematics.position(model, BodyId(idx), None));
            for axis in 0..3 {
                let mut unit = [pool.zero(); 3];
                unit[axis] = pool.one();
                outputs.extend(pose.rotation.apply(pool, &unit));
            }
        }
        for joint in &model.joints {
            let sides = kinematics.sides(model, joint);
            outputs.extend(sides.p_world_predecessor);
            outputs.extend(sides.predecessor.rotation.apply(pool, &joint.axis));
        }
        for idx in 0..model.joints.len() {
            outputs.extend(kinematics.joint_positions(model, JointId(idx)));
        }
        let q: Vec<SymbolId> = system.coordinates().iter().map(|c| c.q).collect();
        let parameters = positions.mechanism.parameters.clone();
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let values =
            evaluated(model, (&outputs, &q, &symbols), positions.t(), &positions.q, &parameters)?;
        let (bodies, rest) = values.split_at(12 * model.bodies.len());
        let (axes, mut joints) = rest.split_at(6 * model.joints.len());
        let mut motions = Vec::new();
        for idx in 0..model.joints.len() {
            let n = kinematics.joint_positions(model, JointId(idx)).len();
            let (own, rest) = joints.split_at(n);
            motions.push(own.to_vec());
            joints = rest;
        }
        Ok(Self {
            t: positions.t(),
            size: positions.size,
            coms: bodies.chunks(12).map(|body| [body[0], body[1], body[2]]).collect(),
            rotations: bodies
                .chunks(12)
                .map(|body| Matrix3::from_column_slice(&body[3..]))
                .collect(),
            axes: axes.chunks(6).map(|a| [[a[0], a[1], a[2]], [a[3], a[4], a[5]]]).collect(),
            motions,
            parameters,
        })
    }
}

/// Values of expressions of time, coordinates and parameters.
fn evaluated(
    model: &Model,
    (outputs, q, symbols): (&[Expr], &[SymbolId], &[SymbolId]),
    t: f64,
    at: &[f64],
    parameters: &[f64],
) -> Result<Vec<f64>, AnalysisError> {
    let arguments = [&[model.time], q].concat();
    let tape = Tape::compile(&model.pool, outputs, &arguments, symbols)?;
    let mut values = vec![0.0; outputs.len()];
    let inputs = [&[t], at].concat();
    tape.evaluate(&mut tape.workspace(parameters), &inputs, &mut values);
    Ok(values)
}

/// A mechanism in a pose, in coordinates of all bodies.
pub(crate) struct Placed {
    pub(crate) model: Model,
    pub(crate) system: SymbolicSystem,
    /// Rows with their slopes as a function of the coordinates.
    tape: Tape,
    slopes: Vec<(usize, usize)>,
    /// Coordinates, SI.
    pub(crate) q: Vec<f64>,
    /// Unit of each coordinate.
    pub(crate) units: Vec<f64>,
    unit_of_row: Vec<f64>,
    pub(crate) parameters: Vec<f64>,
    pub(crate) t: f64,
}

impl Placed {
    /// `model` with every joint cut, drives and loads left out, in a pose.
    pub(crate) fn of(model: &Model, pose: &Pose) -> Result<Self, AnalysisError> {
        let mut model = model.snapshot().to_model();
        model.coordinates = CoordinatePolicy::Absolute;
        model.drives.clear();
        model.loads.clear();
        model.initial.clear();
        model.orientations.clear();
        model.named_signals.clear();
        model.forget_turns();
        model.held.clear();
        model.states.clear();
        model.forget_cuts();
        model.bodies.iter_mut().for_each(|body| body.coordinate_names.clear());
        let system = assemble_positions(&model);
        let pool = &model.pool;
        let coordinates = system.coordinates();
        let symbols: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let rows: Vec<Expr> = system.constraints.iter().map(|c| c.expression).collect();
        let jacobian = pool.jacobian(&rows, &symbols);
        let entries = jacobian.entries.iter().map(|entry| entry.2);
        let outputs: Vec<Expr> = rows.iter().copied().chain(entries).collect();
        let parameters: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let tape =
            Tape::compile(pool, &outputs, &[&[model.time][..], &symbols].concat(), &parameters)?;

        let value = |owner: Owner| match owner {
            Owner::Joint(joint, motion) => {
                pose.motions[joint.0].get(motion).copied().unwrap_or(0.0)
            }
            Owner::Body(body, k) if model.space == bksim_model::Space::Planar && k == 2 => {
                let rotation = &pose.rotations[body.0];
                rotation[(1, 0)].atan2(rotation[(0, 0)])
            }
            Owner::Body(body, k) => pose.coms[body.0].get(k).copied().unwrap_or(0.0),
            Owner::Quaternion(body, part) => {
                let rotation = Rotation3::from_matrix_unchecked(pose.rotations[body.0]);
                let turn = UnitQuaternion::from_rotation_matrix(&rotation);
                [turn.w, turn.i, turn.j, turn.k][part]
            }
            Owner::State(_) => 0.0,
        };
        let unit =
            |kind: CoordinateKind| if kind == CoordinateKind::Length { pose.size } else { 1.0 };
        let unit_of_row = |c: &Constraint| {
            let is_number = matches!(c.source, Source::Quaternion(_))
                || c.effort == bksim_model::MotionKind::Rotation;
            if is_number { 1.0 } else { pose.size }
        };
        Ok(Self {
            q: coordinates.iter().map(|c| value(c.owner)).collect(),
            units: coordinates.iter().map(|c| unit(c.kind)).collect(),
            unit_of_row: system.constraints.iter().map(unit_of_row).collect(),
            slopes: jacobian.entries.iter().map(|&(row, column, _)| (row, column)).collect(),
            parameters: pose.parameters.clone(),
            t: pose.t,
            tape,
            system,
            model,
        })
    }

    /// Rows and their slopes at coordinates, in units of the mechanism.
    pub(crate) fn at(&self, q: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let (m, n) = (self.unit_of_row.len(), self.units.len());
        let mut values = vec![0.0; self.tape.n_outputs()];
        let inputs = [&[self.t], q].concat();
        self.tape.evaluate(&mut self.tape.workspace(&self.parameters), &inputs, &mut values);
        let value = DVector::from_fn(m, |row, _| {
            let value = values[row] / self.unit_of_row[row];
            let is_turn = self.system.constraints[row].direction == "angle";
            if is_turn { crate::rows::wrapped(value) } else { value }
        });
        let mut jacobian = DMatrix::zeros(m, n);
        for (&(row, column), slope) in self.slopes.iter().zip(&values[m..]) {
            jacobian[(row, column)] = slope * self.units[column] / self.unit_of_row[row];
        }
        (value, jacobian)
    }

    /// Slopes of the rows in the pose.
    pub(crate) fn jacobian(&self) -> DMatrix<f64> {
        self.at(&self.q).1
    }

    /// The nearest position on all rows, and how far the last step went.
    pub(crate) fn closed(&self, mut q: Vec<f64>) -> Option<Vec<f64>> {
        const MOST: usize = 40;
        for _ in 0..MOST {
            let (value, jacobian) = self.at(&q);
            if value.amax() < 1e-14 {
                return Some(q);
            }
            let step = Svd::new(&jacobian)?.solve(&-value, 1e-12);
            q.iter_mut()
                .zip(step.iter().zip(&self.units))
                .for_each(|(q, (s, unit))| *q += s * unit);
        }
        (self.at(&q).0.amax() < 1e-10).then_some(q)
    }
}
