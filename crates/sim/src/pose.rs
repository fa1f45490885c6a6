//! [`Poses`]: where every body is and how fast it moves, as functions of the state.

use bksim_expr::{Expr, SymbolId, Tape, TapeError};

use crate::function::{Buffers, Function};
use bksim_mbs::spatial;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;

/// Where a body's frame is in the world, and its rates.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Pose {
    /// World position of the frame's origin, m.
    pub origin: [f64; 3],
    /// Rotation from the frame to the world, its rows.
    pub r_world_from_body: [[f64; 3]; 3],
    /// World velocity of the origin, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity in world axes, rad/s.
    pub omega: [f64; 3],
}

impl Default for Pose {
    /// That of the ground.
    fn default() -> Self {
        Self {
            origin: [0.0; 3],
            r_world_from_body: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            velocity: [0.0; 3],
            omega: [0.0; 3],
        }
    }
}

impl Pose {
    /// World components of a vector of the body.
    pub fn turn(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        self.r_world_from_body.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }

    /// World position of a point of the body.
    pub fn place(&self, point: [f64; 3]) -> [f64; 3] {
        let arm = self.turn(point);
        std::array::from_fn(|i| self.origin[i] + arm[i])
    }

    /// World velocity of a point of the body: that of the origin and ω × r.
    pub fn velocity_of(&self, point: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.turn(point);
        let ([p, q, r], [vx, vy, vz]) = (self.omega, self.velocity);
        [vx + q * z - r * y, vy + r * x - p * z, vz + p * y - q * x]
    }

    /// The part of it that shows in the plane z = 0.
    pub fn in_plane(&self) -> PlanarPose {
        let [[cos, ..], [sin, ..], _] = self.r_world_from_body;
        let ([x, y, _], [vx, vy, _]) = (self.origin, self.velocity);
        PlanarPose {
            origin: [x, y],
            angle: sin.atan2(cos),
            velocity: [vx, vy],
            rate: self.omega[2],
        }
    }
}

/// Where a body's frame is in the plane, and its rates.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct PlanarPose {
    /// World position of the frame's origin, m.
    pub origin: [f64; 2],
    /// Angle of the frame against the ground about z, rad, in (−π, π].
    pub angle: f64,
    /// World velocity of the origin, m/s.
    pub velocity: [f64; 2],
    /// rad/s.
    pub rate: f64,
}

impl PlanarPose {
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

/// The poses of all bodies of a model as one tape.
#[derive(Clone, Debug)]
pub struct Poses {
    function: Function,
}

/// Numbers of a body: origin, rotation, velocity, angular velocity.
const NUMBERS: usize = 18;

impl Poses {
    /// Compiles the poses along the tree of `system`.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither a parameter nor part of the state.
    pub fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let (pool, kinematics) = (&model.pool, &system.kinematics);
        let unit = |axis: usize| std::array::from_fn(|i| pool.int(i64::from(i == axis)));
        let mut outputs: Vec<Expr> = Vec::with_capacity(NUMBERS * model.bodies.len());
        for pose in &kinematics.poses {
            let origin = pose.position(pool, &spatial::zero(pool));
            let columns = [0, 1, 2].map(|axis| pose.rotation.apply(pool, &unit(axis)));
            outputs.extend(origin);
            outputs.extend((0..3).flat_map(|row| columns.map(|column| column[row])));
            outputs.extend(origin.map(|x| kinematics.rate(model, x)));
            outputs.extend(pose.omega);
        }
        let coordinates = system.coordinates();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let parameters: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        Ok(Self { function: Function::compile(model, &outputs, &[&q, &v], &parameters)? })
    }

    /// The tape: from q and v to 18 numbers per body, which are origin, rows of the rotation, velocity
    /// and angular velocity.
    pub fn tape(&self) -> &Tape {
        self.function.tape()
    }

    /// The poses at these values of the parameters, one state after another.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn runner(self, parameters: &[f64]) -> PoseRunner {
        PoseRunner { buffers: self.function.buffers(parameters), poses: self }
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
        let mut runner = self.clone().runner(parameters);
        let mut of_state = |(q, v): (&[f64], &[f64])| {
            let mut poses = Vec::new();
            runner.at(q, v, &mut poses);
            poses
        };
        states.into_iter().map(&mut of_state).collect()
    }
}

/// [`Poses`] at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct PoseRunner {
    poses: Poses,
    buffers: Buffers,
}

impl PoseRunner {
    /// Puts the pose of every body, the ground first, into `poses`.
    ///
    /// # Panics
    /// If the state is not as long as in the model.
    pub fn at(&mut self, q: &[f64], v: &[f64], poses: &mut Vec<Pose>) {
        let of_body = |body: &[f64]| {
            let three = |first: usize| std::array::from_fn(|i| body[first + i]);
            Pose {
                origin: three(0),
                r_world_from_body: [three(3), three(6), three(9)],
                velocity: three(12),
                omega: three(15),
            }
        };
        let numbers = self.poses.function.evaluate(&mut self.buffers, &[q, v]);
        poses.clear();
        poses.extend(numbers.chunks_exact(NUMBERS).map(of_body));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bksim_mbs::assemble::assemble;
    use bksim_model::file::{Source, read};

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
            inertia = 0.1
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
        close(at[2].in_plane().angle, 0.7);
        close(at[2].velocity[0], -1.5 * arm[1]);
        close(at[2].velocity[1], 1.5 * arm[0]);
        close(at[2].omega[2], 1.25);
        // The end of the first arm moves as the second body's origin does.
        let end = at[1].velocity_of([0.5, 0.0, 0.0]);
        close(end[0], at[2].velocity[0]);
        close(end[1], at[2].velocity[1]);
    }
}
