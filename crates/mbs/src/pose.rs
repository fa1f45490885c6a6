//! [`Poses`]: where every body is and how fast it moves, as functions of the state.

use bksim_expr::{Expr, Runner, SymbolId, Tape, TapeError};

use crate::assemble::SymbolicSystem;
use crate::model::{BodyId, Measure, Model};
use crate::spatial;

/// Where a body's frame is in the plane, and its rates.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Pose {
    /// World position of the frame's origin, m.
    pub origin: [f64; 2],
    /// Angle of the frame against the ground about z, rad.
    pub angle: f64,
    /// World velocity of the origin, m/s.
    pub velocity: [f64; 2],
    /// rad/s.
    pub rate: f64,
}

impl Pose {
    /// World position of a point of the body.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle.sin_cos();
        [self.origin[0] + cos * x - sin * y, self.origin[1] + sin * x + cos * y]
    }

    /// World velocity of a point of the body: that of the origin and ω × r.
    pub fn velocity_of(&self, point: [f64; 2]) -> [f64; 2] {
        let there = self.place(point);
        let arm = [there[0] - self.origin[0], there[1] - self.origin[1]];
        [self.velocity[0] - self.rate * arm[1], self.velocity[1] + self.rate * arm[0]]
    }
}

/// The poses of all bodies of a planar model as one tape.
#[derive(Clone, Debug)]
pub struct Poses {
    runner: Runner,
    n_coordinates: usize,
}

/// Numbers of a body: x, y, angle, and their rates.
const NUMBERS: usize = 6;

impl Poses {
    /// Compiles the poses along the tree of `system`.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither a parameter nor part of the state.
    pub fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let (pool, kinematics) = (&model.pool, &system.kinematics);
        let outputs = (0..model.bodies.len()).flat_map(|body| {
            let pose = &kinematics.poses[body];
            let [x, y, _] = pose.place(pool, &spatial::zero(pool));
            let [angle, rate] = [Measure::BodyAngle(BodyId(body)), Measure::BodyRate(BodyId(body))]
                .map(|measure| kinematics.measure(model, measure));
            [x, y, angle, kinematics.rate(model, x), kinematics.rate(model, y), rate]
        });
        let outputs: Vec<Expr> = outputs.collect();
        let coordinates = system.coordinates();
        let values = coordinates.iter().map(|c| c.q);
        let inputs: Vec<SymbolId> = values.chain(coordinates.iter().map(|c| c.v)).collect();
        let parameters: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let tape = Tape::compile(pool, &outputs, &inputs, &parameters)?;
        let runner = Runner::new(tape, model.solve.jit);
        Ok(Self { runner, n_coordinates: coordinates.len() })
    }

    /// The pose of every body, the ground first, at each state `(q, v)`.
    ///
    /// # Panics
    /// If `parameters` or a state is not as long as in the model.
    pub fn at<'a>(
        &self,
        parameters: &[f64],
        states: impl IntoIterator<Item = (&'a [f64], &'a [f64])>,
    ) -> Vec<Vec<Pose>> {
        let mut workspace = self.runner.tape().workspace(parameters);
        let mut numbers = vec![0.0; self.runner.tape().n_outputs()];
        let mut inputs = Vec::with_capacity(2 * self.n_coordinates);
        let mut of_state = |(q, v): (&[f64], &[f64])| {
            inputs.clear();
            inputs.extend_from_slice(q);
            inputs.extend_from_slice(v);
            self.runner.evaluate(&mut workspace, &inputs, &mut numbers);
            let of_body = |body: &[f64]| Pose {
                origin: [body[0], body[1]],
                angle: body[2],
                velocity: [body[3], body[4]],
                rate: body[5],
            };
            numbers.chunks_exact(NUMBERS).map(of_body).collect()
        };
        states.into_iter().map(&mut of_state).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assemble::assemble;
    use crate::file::{Source, read};

    #[test]
    fn a_double_pendulum_hangs_where_the_sines_put_it() {
        let text = r#"
            [parameters]
            l = "0.5 m"
            [bodies.a]
            mass = 1
            points = { P = ["l", 0] }
            [bodies.b]
            mass = 1
            [joints.A]
            type = "revolute"
            between = ["ground", "a"]
            [joints.B]
            type = "revolute"
            between = ["a.P", "b"]
        "#;
        let model = read(&Source::new(text, "double")).model.expect("a model");
        let system = assemble(&model);
        let poses = Poses::compile(&model, &system).expect("compiles");
        let (q, v) = ([0.3, 0.4], [1.5, -0.25]);
        let at = poses.at(&[0.5], [(&q[..], &v[..])]).remove(0);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} is not {b}");
        assert_eq!(at[0], Pose::default());
        let arm = [0.5 * 0.3_f64.cos(), 0.5 * 0.3_f64.sin()];
        close(at[2].origin[0], arm[0]);
        close(at[2].origin[1], arm[1]);
        close(at[2].angle, 0.7);
        close(at[2].velocity[0], -1.5 * arm[1]);
        close(at[2].velocity[1], 1.5 * arm[0]);
        close(at[2].rate, 1.25);
        // The end of the first arm moves as the second body's origin does.
        let end = at[1].velocity_of([0.5, 0.0]);
        close(end[0], at[2].velocity[0]);
        close(end[1], at[2].velocity[1]);
    }
}
