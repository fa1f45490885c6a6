//! A tape over many points, group by group in lanes.

use super::due::Jit;
use super::lanes::{Group, LaneRunner, LaneValues, LaneWorkspace, Layout, widest_lanes};
use crate::tape::Tape;

/// A [`Tape`] with its parameters set, to be evaluated at many points at once.
///
/// ```
/// use bksim_expr::{Pool, Tape};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let outputs = [pool.parse("k*x + y")?, pool.parse("x*y")?];
/// let id = |name| pool.find_symbol(name).expect("was parsed");
/// let tape = Tape::compile(&pool, &outputs, &[id("x"), id("y")], &[id("k")])?;
/// let mut batch = tape.batch(&[10.0]);
/// let mut out = [0.0; 6];
/// // Three points: all x, then all y; out come all values of the first output, then the second's.
/// batch.evaluate(3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &mut out);
/// assert_eq!(out, [14.0, 25.0, 36.0, 4.0, 10.0, 18.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Batch(Lanes);

/// Groups of as many points as this machine has lanes; clones of a batch share machine code.
#[derive(Clone, Debug)]
enum Lanes {
    Four(Groups<4>),
    Eight(Groups<8>),
}

/// A tape at `N` points at once, group by group, where they stand in their columns.
#[derive(Clone, Debug)]
struct Groups<const N: usize> {
    runner: LaneRunner<N>,
    workspace: LaneWorkspace<N>,
    /// Of a last group of fewer points.
    inputs: LaneValues<N>,
    out: LaneValues<N>,
}

impl Tape {
    /// The tape for many points, with everything computed that depends on parameters only.
    ///
    /// # Panics
    /// When the number of parameters differs from the compiled one.
    pub fn batch(&self, parameters: &[f64]) -> Batch {
        Batch(if widest_lanes() == 8 {
            Lanes::Eight(Groups::new(self, parameters))
        } else {
            Lanes::Four(Groups::new(self, parameters))
        })
    }
}

impl Batch {
    /// Computes all outputs at `n_points` points.
    ///
    /// `inputs` holds all values of the first input, then all of the second and so on; `out`
    /// takes the outputs in the same way.
    ///
    /// # Panics
    /// When `inputs` or `out` do not hold `n_points` values of each input and output.
    pub fn evaluate(&mut self, n_points: usize, inputs: &[f64], out: &mut [f64]) {
        match &mut self.0 {
            Lanes::Four(groups) => groups.evaluate(n_points, inputs, out),
            Lanes::Eight(groups) => groups.evaluate(n_points, inputs, out),
        }
    }
}

impl<const N: usize> Groups<N> {
    fn new(tape: &Tape, parameters: &[f64]) -> Self {
        let runner = LaneRunner::with_layout(tape.clone(), Jit::Auto, Layout::Columns);
        Self {
            workspace: runner.workspace(parameters),
            inputs: LaneValues::zeros(tape.n_inputs),
            out: LaneValues::zeros(tape.outputs.len()),
            runner,
        }
    }

    fn evaluate(&mut self, n_points: usize, inputs: &[f64], out: &mut [f64]) {
        assert_eq!(inputs.len(), n_points * self.inputs.len(), "values of all inputs");
        assert_eq!(out.len(), n_points * self.out.len(), "values of all outputs");
        let n_whole = n_points - n_points % N;
        for first in (0..n_whole).step_by(N) {
            let group = Group { n_points, first };
            self.runner.evaluate_group(&mut self.workspace, group, inputs, out);
        }
        if n_whole < n_points {
            self.evaluate_last(Group { n_points, first: n_whole }, inputs, out);
        }
    }

    /// Computes all outputs at a last group of fewer points; lanes without one repeat the last one.
    fn evaluate_last(&mut self, Group { n_points, first }: Group, inputs: &[f64], out: &mut [f64]) {
        for (lanes, values) in self.inputs.iter_mut().zip(inputs.chunks_exact(n_points)) {
            *lanes = std::array::from_fn(|lane| values[(first + lane).min(n_points - 1)]);
        }
        self.runner.evaluate(&mut self.workspace, &self.inputs, &mut self.out);
        for (lanes, values) in self.out.iter().zip(out.chunks_exact_mut(n_points)) {
            values[first..].copy_from_slice(&lanes[..n_points - first]);
        }
    }
}
