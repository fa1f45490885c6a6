//! States and sampled signals of controllers along a prescribed motion.
//!
//! ```text
//! ż = r(t, q(t), q̇(t), z, x),   z(t₀) as the model starts
//! x                              signals that change at the ticks of clocks, held in between
//! ```
//!
//! The motion is given, and nothing acts back on it: states are followed first, and then all forces are known. Radau IIA
//! takes them, since motors and filters are often faster than what they move.

use std::collections::VecDeque;

use bksim_dae::{
    Control, Index, Layout, NotFinite, Pattern, Settings, Start, System, Tolerance, solve,
};
use bksim_expr::{SymbolId, Tape, Workspace};
use bksim_model::Measure;
use bksim_sim::sampled::{Held, Sampling};

use crate::error::AnalysisError;
use crate::loaded::Loaded;

/// Positions, velocities and accelerations of a motion at a time, where it can be followed.
pub(crate) type MotionAt<'a> = dyn FnMut(f64) -> Option<[Vec<f64>; 3]> + 'a;

/// States and sampled signals at one time.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct ControllerState {
    /// z, in the order of the model's states, SI.
    pub(crate) z: Vec<f64>,
    /// ż, SI.
    pub(crate) rates: Vec<f64>,
    /// Values of the signals that are held, SI.
    pub(crate) held: Vec<f64>,
}

/// The rates of states as functions of numbers, along a motion.
struct StateRates<'a, 'm> {
    tape: Tape,
    space: Workspace,
    /// ż, then ∂ż/∂z by columns.
    outputs: Vec<f64>,
    n: usize,
    motion: &'a mut MotionAt<'m>,
    /// Positions and velocities at the instants that were asked for last: stages come again in every iteration.
    known: VecDeque<(f64, [Vec<f64>; 2])>,
    /// An instant at which the motion could not be followed.
    lost: Option<f64>,
    layout: Layout,
    pattern: Pattern,
}

/// Instants that are kept: more than the stages of a step.
const N_KNOWN: usize = 16;

/// Tolerances of the states, which are inputs of everything that is told.
const RTOL: f64 = 1e-10;
const ATOL: f64 = 1e-12;

/// The states and sampled signals of `loaded` at `times`, in order, along a motion; a tick counts as passed at its own
/// instant.
///
/// # Errors
/// [`AnalysisError`] where the motion cannot be followed, or a state or signal has no finite value.
pub(crate) fn controller_states(
    loaded: &Loaded,
    motion: &mut MotionAt<'_>,
    times: &[f64],
) -> Result<Vec<ControllerState>, AnalysisError> {
    let (model, first) = (loaded.model(), times.first().copied().unwrap_or(loaded.t));
    if model.states.is_empty() && model.held.is_empty() {
        return Ok(vec![ControllerState::default(); times.len()]);
    }
    let last = times.last().copied().unwrap_or(first);
    let mut sampling = loaded.mechanism.sampling()?;
    let mut held = sampling.begin(first);
    let mut rates = StateRates::compile(loaded, motion)?;
    let mut z = starts(loaded);
    let mut found: Vec<ControllerState> = Vec::with_capacity(times.len());
    let mut t = first;
    loop {
        // What ticks here, then all until the next tick.
        rates.tick((loaded, &mut sampling), t, &z, &mut held)?;
        let tick = sampling.next(&held).filter(|tick| !tick.is_after(last));
        let (end, begin) = tick.map_or((last, f64::INFINITY), |tick| (tick.t, tick.begin()));
        let left = &times[found.len()..];
        let n_here = left.iter().take_while(|&&time| time < begin).count();
        rates.set_parameters(&with_held(&loaded.parameters, &held.values));
        let mut here = Vec::with_capacity(n_here);
        z = rates.follow((t, end), z, &left[..n_here], &mut here)?;
        for (&time, z) in left.iter().zip(here) {
            let rates = rates.values(time, &z)?.to_vec();
            found.push(ControllerState { z, rates, held: held.values.clone() });
        }
        t = end;
        if tick.is_none() {
            return Ok(found);
        }
    }
}

/// The parameters of everything that is compiled, which end with the signals that are held, with these values of them.
pub(crate) fn with_held(parameters: &[f64], held: &[f64]) -> Vec<f64> {
    let n_others = parameters.len() - held.len();
    [&parameters[..n_others], held].concat()
}

/// z(t₀) of all states.
fn starts(loaded: &Loaded) -> Vec<f64> {
    let model = loaded.model();
    let known = model.parameters.iter().zip(&loaded.parameters);
    let value = |symbol: SymbolId| {
        known.clone().find(|(parameter, _)| parameter.symbol == symbol).map(|(_, value)| *value)
    };
    let start = |k: usize| {
        let is_own = |m: Measure| matches!(m, Measure::State(id) if id.0 == k);
        let stated = model.initial.iter().find(|initial| is_own(initial.measure));
        stated.and_then(|stated| model.pool.evaluate(stated.value, &value).ok()).unwrap_or(0.0)
    };
    (0..model.states.len()).map(start).collect()
}

impl<'a, 'm> StateRates<'a, 'm> {
    fn compile(loaded: &Loaded, motion: &'a mut MotionAt<'m>) -> Result<Self, AnalysisError> {
        let (model, system) = (loaded.model(), loaded.system());
        let coordinates = system.coordinates();
        let states = loaded.state_coordinates();
        let n = states.len();
        let rates: Vec<_> = states.iter().map(|&i| system.applied_force[i]).collect();
        let z: Vec<SymbolId> = states.iter().map(|&i| coordinates[i].v).collect();
        let mut outputs = rates.clone();
        for &z in &z {
            outputs.extend(rates.iter().map(|&rate| model.pool.diff(rate, z)));
        }
        let (q, v): (Vec<_>, Vec<_>) = coordinates.iter().map(|c| (c.q, c.v)).unzip();
        let arguments = [vec![model.time], q, v].concat();
        let tape = Tape::compile(&model.pool, &outputs, &arguments, &system.parameters(model))?;
        Ok(Self {
            space: tape.workspace(&loaded.parameters),
            outputs: vec![0.0; tape.n_outputs()],
            tape,
            n,
            motion,
            known: VecDeque::with_capacity(N_KNOWN),
            lost: None,
            layout: Layout::new(vec![Index::One; n]),
            pattern: Pattern::dense(n),
        })
    }

    fn set_parameters(&mut self, parameters: &[f64]) {
        self.space = self.tape.workspace(parameters);
    }

    /// Positions and velocities of all coordinates, with these states.
    fn state(&mut self, t: f64, z: &[f64]) -> Result<[Vec<f64>; 2], NotFinite> {
        let known = self.known.iter().find(|(known, _)| *known == t).map(|(_, at)| at.clone());
        let [mut q, mut v] = if let Some(at) = known {
            at
        } else {
            let at = (self.motion)(t).map(|[q, v, _]| [q, v]);
            let Some(at) = at else {
                self.lost = Some(t);
                return Err(NotFinite { row: 0 });
            };
            if self.known.len() == N_KNOWN {
                self.known.pop_front();
            }
            self.known.push_back((t, at.clone()));
            at
        };
        // Integrals of states are the last coordinates, and nothing depends on them.
        q.resize(q.len() + self.n, 0.0);
        v.extend_from_slice(z);
        Ok([q, v])
    }

    fn evaluate(&mut self, t: f64, z: &[f64]) -> Result<(), NotFinite> {
        let [q, v] = self.state(t, z)?;
        let inputs = [&[t], &q[..], &v].concat();
        self.tape.evaluate(&mut self.space, &inputs, &mut self.outputs);
        match self.outputs.iter().position(|value| !value.is_finite()) {
            Some(k) => Err(NotFinite { row: k % self.n.max(1) }),
            None => Ok(()),
        }
    }

    /// ż at a time.
    fn values(&mut self, t: f64, z: &[f64]) -> Result<&[f64], AnalysisError> {
        if self.n > 0 && self.evaluate(t, z).is_err() {
            return Err(self.end(t));
        }
        Ok(&self.outputs[..self.n])
    }

    /// The reason why the states go no further than `t`.
    fn end(&self, t: f64) -> AnalysisError {
        self.lost.map_or(AnalysisError::StatesLost { t }, |t| AnalysisError::Lost { t })
    }

    /// Takes the values of the signals whose clocks tick at `t`.
    fn tick(
        &mut self,
        (loaded, sampling): (&Loaded, &mut Sampling<'_>),
        t: f64,
        z: &[f64],
        held: &mut Held,
    ) -> Result<(), AnalysisError> {
        if held.values.is_empty() {
            return Ok(());
        }
        let [q, v] = self.state(t, z).map_err(|_| AnalysisError::Lost { t })?;
        let name = |signal: usize| loaded.model().held[signal].name.clone();
        let no_signal = |fault: bksim_sim::sampled::NoSignal| AnalysisError::NoSignal {
            name: name(fault.signal),
            t,
        };
        sampling.tick(t, &q, &v, held).map_err(no_signal)
    }

    /// Follows the states from one time to another; those at `times`, which lie in between, go to `found`.
    fn follow(
        &mut self,
        (from, to): (f64, f64),
        z: Vec<f64>,
        times: &[f64],
        found: &mut Vec<Vec<f64>>,
    ) -> Result<Vec<f64>, AnalysisError> {
        let sign = if to < from { -1.0 } else { 1.0 };
        // Times of the start itself, and of a tick that rounding puts before it.
        let n_first = times.iter().take_while(|&&time| sign * (time - from) <= 0.0).count();
        found.extend(std::iter::repeat_n(
            z.clone(),
            if self.n == 0 { times.len() } else { n_first },
        ));
        if from == to || self.n == 0 {
            return Ok(z);
        }
        let ydot = self.values(from, &z)?.to_vec();
        let settings =
            Settings { rtol: RTOL, atol: Tolerance::Scalar(ATOL), ..Settings::default() };
        let (start, mut reached) = (Start { t: from, y: z.clone(), ydot }, from);
        self.lost = None;
        let outcome = solve(&mut *self, start, to, settings, &mut |step| {
            while let Some(&time) =
                times.get(found.len()).filter(|&&t| sign * (t - step.t1()) <= 0.0)
            {
                let mut there = z.clone();
                step.at(time, &mut there);
                found.push(if time == step.t1() { step.y1().to_vec() } else { there });
            }
            reached = step.t1();
            Control::Continue
        });
        outcome.map(|outcome| outcome.y).map_err(|_| self.end(reached))
    }
}

impl System for StateRates<'_, '_> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    fn residual(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.evaluate(t, y)?;
        out.iter_mut().zip(ydot.iter().zip(&self.outputs)).for_each(|(out, (y, r))| *out = y - r);
        Ok(())
    }

    fn jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        _: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.evaluate(t, y)?;
        let n = self.n;
        df_dy.iter_mut().zip(&self.outputs[n..]).for_each(|(to, slope)| *to = -slope);
        df_dydot.fill(0.0);
        (0..n).for_each(|i| df_dydot[i * n + i] = 1.0);
        Ok(())
    }
}
