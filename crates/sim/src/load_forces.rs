//! [`LoadForces`]: the forces that the loads of a model put on its bodies, as functions of the state.

use crate::compiled::CompiledSystem;
use crate::input::{InputValues, input_symbols, without_inputs};
use bksim_expr::{Expr, SymbolId, TapeError};

use crate::function::{Buffers, Function};
use bksim_mbs::force::{self, Wrench};
use bksim_mbs::signal::signal_values;
use bksim_mbs::spatial;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{BodyId, GROUND, LoadId, Model};

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
    function: Function,
    buffers: Buffers,
    inputs: InputValues,
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
        let outputs = model.pool.substitute_all(&outputs, &system.reaction_values);
        let coordinates = system.coordinates();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let arguments = [&[model.time][..], &q, &v, &lambda, &input_symbols(model)];
        let symbols = model.parameters.iter().map(|p| p.symbol).collect();
        let symbols = without_inputs(model, symbols);
        let function = Function::compile(model, &outputs, &arguments, &symbols)?;
        let buffers = function.buffers(parameters);
        Ok(Self { forces, function, buffers, inputs: InputValues::new(&compiled.inputs) })
    }

    /// Whose forces they are, in the order of [`LoadForces::at`].
    pub fn forces(&self) -> &[LoadForce] {
        &self.forces
    }

    /// The forces at an instant.
    ///
    /// # Panics
    /// If the state is not as long as in the model.
    pub fn at(
        &mut self,
        (t, q, v): (f64, &[f64], &[f64]),
        lambda: &[f64],
    ) -> impl Iterator<Item = ForceAt> {
        let arguments = [&[t], q, v, lambda, self.inputs.at(t, q, v)];
        let numbers = self.function.evaluate(&mut self.buffers, &arguments);
        numbers.chunks_exact(NUMBERS).map(|numbers| ForceAt {
            force: std::array::from_fn(|i| numbers[i]),
            point: std::array::from_fn(|i| numbers[3 + i]),
        })
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
    }
}
