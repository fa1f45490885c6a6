//! [`LoadForces`], [`LoadTorques`]: what the loads of a model put on its bodies, as functions of the state.

use crate::compiled::CompiledSystem;
use crate::values::{State, Values};
use bksim_expr::{Expr, Number, TapeError};
use bksim_mbs::force::{self, Wrench};
use bksim_mbs::signal::signal_values;
use bksim_mbs::spatial;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{BodyId, GROUND, LoadId, LoadKind, Model};

/// A force of a load on a body that moves.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LoadForce {
    /// The load.
    pub load: LoadId,
    /// The body that it acts on.
    pub body: BodyId,
}

/// The size of a force, and where it acts.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ForceAt {
    /// Components in world axes, N.
    pub force: [f64; 3],
    /// Where it acts, world, m.
    pub point: [f64; 3],
}

/// The forces of all loads at one set of parameters, with their buffers. Torques, stops and friction
/// have none; neither have forces on the ground.
#[derive(Clone, Debug)]
pub struct LoadForces {
    forces: Vec<LoadForce>,
    values: Values,
}

/// The axis about which the torque of a load is asked for.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TorqueAxis {
    /// A torque on a body, or an effort in a rotation of a joint, which is about the axis of that rotation alone.
    pub load: LoadId,
    /// The body that the axis is fixed to.
    pub body: BodyId,
    /// Unit vector in the frame of that body.
    pub axis: [f64; 3],
}

/// The torques of loads about axes of bodies at one set of parameters, N m, with their buffers.
#[derive(Clone, Debug)]
pub struct LoadTorques {
    values: Values,
}

/// Numbers of a force: its components, and where it acts.
const NUMBERS: usize = 6;

impl LoadForces {
    /// Compiles the forces of the loads of `model`, in file order; those of gravity by body.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn compile(
        model: &Model,
        system: &SymbolicSystem,
        compiled: &CompiledSystem,
        parameters: &[f64],
    ) -> Result<Self, TapeError> {
        let kinematics = &system.kinematics;
        let signals = signal_values(model, kinematics);
        let mut forces = Vec::new();
        let mut outputs: Vec<Expr> = Vec::new();
        for (load_idx, load) in model.loads.iter().enumerate() {
            let action = force::action(model, kinematics, &signals, &load.kind);
            let on_bodies = [action.conservative, action.applied].concat();
            for wrench in at_points(model, on_bodies) {
                forces.push(LoadForce { load: LoadId(load_idx), body: wrench.body });
                outputs.extend(wrench.force);
                outputs.extend(wrench.at);
            }
        }
        let values = Values::compile(model, system, compiled, parameters, (&outputs, &[]))?;
        Ok(Self { forces, values })
    }

    /// Whose forces they are, in the order of [`LoadForces::at`].
    pub fn forces(&self) -> &[LoadForce] {
        &self.forces
    }

    /// The forces at an instant.
    ///
    /// # Panics
    /// If the state is not as long as in the model.
    pub fn at(&mut self, state: State<'_>, lambda: &[f64]) -> impl Iterator<Item = ForceAt> {
        let numbers = self.values.at(state, &[], lambda, &[]);
        numbers.chunks_exact(NUMBERS).map(|numbers| ForceAt {
            force: std::array::from_fn(|i| numbers[i]),
            point: std::array::from_fn(|i| numbers[3 + i]),
        })
    }
}

impl LoadTorques {
    /// Compiles the torques about these axes; a load that is no torque has none: zero.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn compile(
        model: &Model,
        system: &SymbolicSystem,
        compiled: &CompiledSystem,
        parameters: &[f64],
        axes: &[TorqueAxis],
    ) -> Result<Self, TapeError> {
        let (pool, kinematics) = (&model.pool, &system.kinematics);
        let signals = signal_values(model, kinematics);
        let about = |of: &TorqueAxis| match &model.loads[of.load.0].kind {
            LoadKind::Torque { vector, .. } => {
                let axis = of.axis.map(|x| pool.number(Number::float(x)));
                let axis = kinematics.poses[of.body.0].rotation.apply(pool, &axis);
                spatial::dot(pool, vector, &axis)
            }
            LoadKind::Effort { value, .. } => *value,
            _ => pool.zero(),
        };
        let outputs: Vec<Expr> = axes.iter().map(about).collect();
        let outputs = pool.substitute_all(&outputs, &signals);
        let values = Values::compile(model, system, compiled, parameters, (&outputs, &[]))?;
        Ok(Self { values })
    }

    /// The torques at an instant, N m, one for each axis.
    ///
    /// # Panics
    /// If the state is not as long as in the model.
    pub fn at(&mut self, state: State<'_>, lambda: &[f64]) -> &[f64] {
        self.values.at(state, &[], lambda, &[])
    }
}

/// The forces on moving bodies, those at one point of one body added: a spring and its damper.
fn at_points(model: &Model, wrenches: Vec<Wrench>) -> Vec<Wrench> {
    let pool = &model.pool;
    let mut sums: Vec<Wrench> = Vec::new();
    for wrench in wrenches {
        let is_force = wrench.force.iter().any(|&component| !pool.is_zero(component));
        if wrench.body == GROUND || !is_force {
            continue;
        }
        match sums.iter_mut().find(|sum| sum.body == wrench.body && sum.at == wrench.at) {
            Some(sum) => sum.force = spatial::add(pool, &sum.force, &wrench.force),
            None => sums.push(wrench),
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use bksim_mbs::assemble::assemble;
    use bksim_model::file::{Source, read};

    #[test]
    fn every_load_pulls_where_and_as_its_law_says() {
        let text = r#"
            [parameters]
            k = "30 N/m"
            [ground]
            points = { W = [0, 2] }
            [bodies.a]
            mass = 2
            com = [0.5, 0]
            inertia = 1
            points = { P = [1, 0] }
            [joints.A]
            type = "revolute"
            between = ["ground", "a"]
            [loads.gravity]
            type = "gravity"
            acceleration = [0, -10]
            [loads.spring]
            type = "spring"
            between = ["ground.W", "a.P"]
            stiffness = "k"
            length = 0.5
            damping = 4
            [loads.push]
            type = "force"
            on = "a.P"
            vector = ["3 N/s*t", "-2*A.rate"]
            axes = "body"
            [loads.motor]
            type = "torque"
            on = "a"
            value = 7
        "#;
        let model = read(&Source::new(text, "loads")).model.expect("a model");
        let system = assemble(&model);
        let compiled = crate::compiled::compile(&model, &system).expect("compiles");
        let mut forces =
            LoadForces::compile(&model, &system, &compiled, &[30.0]).expect("compiles");
        let loads: Vec<usize> = forces.forces().iter().map(|f| f.load.0).collect();
        assert_eq!(loads, [0, 1, 2], "a torque is no force, and the wall does not move");

        // Upright, P is at (0, 1) and moves to the left.
        let (angle, rate) = (std::f64::consts::FRAC_PI_2, 1.5);
        let at: Vec<ForceAt> = forces.at((2.0, &[angle], &[rate]), &[]).collect();
        let close = |found: ForceAt, force: [f64; 2], point: [f64; 2]| {
            let gap = |a: [f64; 3], b: [f64; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() + a[2];
            assert!(gap(found.force, force) < 1e-12, "{found:?} against {force:?}");
            assert!(gap(found.point, point) < 1e-12, "{found:?} against {point:?}");
        };
        close(at[0], [0.0, -20.0], [0.0, 0.5]);
        // Length 1, 0.5 too long; the rate of the length is zero there.
        close(at[1], [0.0, 15.0], [0.0, 1.0]);
        // (6, −3) along the axes of the body.
        close(at[2], [3.0, 6.0], [0.0, 1.0]);

        // About an axis of the body, and its opposite; gravity is no torque.
        let axis = |load: usize, z: f64| TorqueAxis {
            load: LoadId(load),
            body: BodyId(1),
            axis: [0.0, 0.0, z],
        };
        let axes = [axis(3, 1.0), axis(3, -1.0), axis(0, 1.0)];
        let mut torques =
            LoadTorques::compile(&model, &system, &compiled, &[30.0], &axes).expect("compiles");
        assert_eq!(torques.at((2.0, &[angle], &[rate]), &[]), [7.0, -7.0, 0.0]);
    }
}
