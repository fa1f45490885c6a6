//! The coefficients of the linear equations of changes written down as one function of (t, q, v), for small mechanisms.
//!
//! ```text
//! F_z (a_q, λ_q) = F_q,   F_z (a_v, λ_v) = F_v,   F_z (a_p, λ_p) = F_p        z = (a, λ), see `following`
//! ```
//!
//! The elimination of the accelerations serves all of these right sides. Several instants are evaluated at once, in the
//! lanes of registers.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use bksim_dae::LinearCoefficients;
use bksim_expr::{Composition, Jit, LaneRunner, LaneWorkspace, Tape, Value};

use crate::compiled::CompiledSystem;
use crate::formulate::MotionEquations;
use crate::function::{Function, LANES, Lanes};
use crate::linear::elimination::Elimination;
use crate::linear::shape::Shape;
use crate::multiplier::MultiplierSystem;
use crate::state::StateRef;

/// Updates by the elimination for all right sides up to which they are written down: beyond, loops over numbers are as
/// fast, and making the function takes longer than runs do.
const LARGEST: usize = 10_000;
/// Steps by loops that cost about as much as making the function.
const STEPS_PAID: usize = 40;

/// The function, made once steps by loops have cost as much; runs share it.
#[derive(Debug)]
pub(super) struct WrittenCoefficients {
    jit: Jit,
    n_steps: AtomicUsize,
    made: OnceLock<Option<LaneRunner<LANES>>>,
}

/// Parameters, arguments and results of the function.
#[derive(Debug)]
pub(super) struct CoefficientLanes {
    workspace: LaneWorkspace<LANES>,
    arguments: Vec<Lanes>,
    results: Vec<Lanes>,
}

impl CoefficientLanes {
    /// With these values of the parameters.
    pub(super) fn new(function: &LaneRunner<LANES>, parameters: &[f64]) -> Self {
        let zeros = |n: usize| vec![[0.0; LANES]; n];
        Self {
            workspace: function.workspace(parameters),
            arguments: zeros(function.tape().n_inputs()),
            results: zeros(function.tape().n_outputs()),
        }
    }
}

/// Instants at which coefficients are asked for.
#[derive(Clone, Copy)]
pub(super) struct Instants<'a> {
    pub(super) t: &'a [f64],
    /// q and v of one after the other.
    pub(super) states: &'a [f64],
}

/// More about some instants.
#[derive(Debug, Default)]
pub(super) struct OfInstants {
    /// a and λ.
    pub(super) unknowns: Vec<f64>,
    /// The changes of the constraints.
    pub(super) constraints: Vec<f64>,
}

impl<'a> Instants<'a> {
    /// How many.
    pub(super) fn len(self) -> usize {
        self.t.len()
    }

    /// One after the other.
    pub(super) fn iter(self) -> impl Iterator<Item = StateRef<'a>> {
        let n = self.states.len() / self.t.len().max(1);
        let states = self.states.chunks_exact(n.max(1)).map(move |state| state.split_at(n / 2));
        self.t.iter().zip(states).map(|(&t, (q, v))| StateRef { t, q, v })
    }
}

impl WrittenCoefficients {
    /// Coefficients that are not made yet.
    pub(super) fn new(jit: Jit) -> Self {
        Self { jit, n_steps: AtomicUsize::new(0), made: OnceLock::new() }
    }

    /// The function if it is due now; `tape` makes its tape.
    pub(super) fn due(&self, tape: impl FnOnce() -> Option<Tape>) -> Option<&LaneRunner<LANES>> {
        let n_paid = match self.jit {
            Jit::Off => return None,
            Jit::On => 0,
            Jit::Auto => STEPS_PAID,
        };
        let make = || tape().map(|tape| LaneRunner::new(tape, self.jit));
        match self.made.get() {
            Some(made) => made.as_ref(),
            None if self.n_steps.fetch_add(1, Relaxed) < n_paid => None,
            None => self.made.get_or_init(make).as_ref(),
        }
    }
}

/// The function of (t, q, v): z, the pivots, then by rows of accelerations the solutions for F_q, F_v and F_p, by
/// `n_directions` columns of the latter; then `constraints`, of the same arguments. `None` for mechanisms that are too large, or whose accelerations are not
/// straight-line code.
pub(super) fn coefficients(
    compiled: &CompiledSystem,
    equations: &MotionEquations,
    (columns, n_directions): (&Function, usize),
    constraints: &Function,
) -> Option<Tape> {
    let line = compiled.unrolled.as_ref()?.tape();
    let Shape { nq, nc, .. } = compiled.shape;
    let rows: Vec<usize> = (0..nc).collect();
    let elimination = Elimination::new(&compiled.shape, &rows);
    let n_sides = 2 * nq + n_directions;
    let is_small = elimination.n_updates() * n_sides <= LARGEST;
    let (columns, constraints) = (columns.tape(), constraints.tape());
    let is_same = [columns, constraints].iter().all(|of| of.n_parameters() == line.n_parameters());
    let parts = Parts { line, columns, constraints, equations, elimination };
    (is_small && is_same).then(|| parts.record((nq, nc), n_directions))
}

struct Parts<'a> {
    /// z and factors of (t, q, v).
    line: &'a Tape,
    /// F_p and more of (t, y, y′), one column after the other.
    columns: &'a Tape,
    /// Changes of the constraints, of (t, q, v).
    constraints: &'a Tape,
    equations: &'a MotionEquations,
    elimination: Elimination,
}

impl Parts<'_> {
    fn record(&self, (nq, nc): (usize, usize), n_directions: usize) -> Tape {
        let Self { line, columns, constraints, equations, elimination } = self;
        let mut recorder = Composition::new(1 + 2 * nq, line.n_parameters());
        let inputs: Vec<Value> = (0..=2 * nq).map(|i| recorder.input(i)).collect();
        let solved = recorder.call(line, &inputs);
        let (z, factors) = solved.split_at(nq + nc);

        // F is a function of t, y = (q, v, λ) and y′ = (v, a, 0).
        let (a, lambda) = z.split_at(nq);
        let zeros = vec![recorder.constant(0.0); nc];
        let arguments = [&inputs[..], lambda, &inputs[1 + nq..], a, &zeros].concat();

        // The right sides: rows of F after those of q′ = v.
        let mut sides = vec![vec![None; nq + nc]; 2 * nq + n_directions];
        for ((row, column), value) in equations.record_jacobian(&mut recorder, &arguments) {
            if row >= nq && column < 2 * nq {
                sides[column][row - nq] = Some(value);
            }
        }
        let by_parameters = recorder.call(columns, &arguments);
        let n = equations.n();
        for (side, column) in sides[2 * nq..].iter_mut().zip(by_parameters.chunks_exact(n)) {
            let not_zero =
                |&value: &Value| Some(value).filter(|&v| recorder.number(v) != Some(0.0));
            side.iter_mut().zip(&column[nq..]).for_each(|(x, value)| *x = not_zero(value));
        }

        // Their solutions, by rows.
        let mut solve =
            |side: &Vec<Option<Value>>| elimination.record_solution(&mut recorder, factors, side);
        let solutions: Vec<Vec<Value>> = sides.iter().map(&mut solve).collect();
        let by_rows = (0..nq).flat_map(|i| solutions.iter().map(move |solution| solution[i]));
        let mut outputs = [z, &factors[..nq + nc]].concat();
        outputs.extend(by_rows);
        outputs.extend(recorder.call(constraints, &inputs));
        recorder.finish(&outputs)
    }
}

/// Writes the coefficients at all instants, and more about them; false where a pivot or a number is not regular.
pub(super) fn coefficients_into(
    (function, lanes): (&LaneRunner<LANES>, &mut CoefficientLanes),
    (multipliers, nc): (&mut MultiplierSystem, usize),
    instants: Instants<'_>,
    (out, OfInstants { unknowns, constraints }): (&mut [LinearCoefficients], &mut OfInstants),
) -> bool {
    let CoefficientLanes { workspace, arguments, results } = lanes;
    let nq = instants.states.len() / instants.t.len().max(1) / 2;
    let n_known = 2 * (nq + nc);
    let all: Vec<StateRef<'_>> = instants.iter().collect();
    let n_changes = constraints.len() / instants.len().max(1);
    for (first, (few, out)) in all.chunks(LANES).zip(out.chunks_mut(LANES)).enumerate() {
        // The last lanes repeat the last instant where there are fewer.
        for lane in 0..LANES {
            let StateRef { t, q, v } = &few[lane.min(few.len() - 1)];
            let numbers = std::iter::once(t).chain(*q).chain(*v);
            arguments.iter_mut().zip(numbers).for_each(|(all, &number)| all[lane] = number);
        }
        function.evaluate(workspace, arguments, results);
        let (z, rest) = results.split_at(nq + nc);
        if !multipliers.accept_lanes(z, rest) {
            return false;
        }
        let (solutions, changes) = results[n_known..].split_at(results.len() - n_known - n_changes);
        for lane in 0..few.len() {
            let instant = first * LANES + lane;
            let own = |lanes: &Lanes| lanes[lane];
            let z = unknowns[instant * (nq + nc)..].iter_mut().zip(z);
            z.for_each(|(x, lanes)| *x = own(lanes));
            let changes = constraints[instant * n_changes..].iter_mut().zip(changes);
            changes.for_each(|(x, lanes)| *x = own(lanes));
        }
        let width = solutions.len() / nq.max(1);
        for (lane, LinearCoefficients { by_position, by_velocity, forcing }) in
            out.iter_mut().enumerate()
        {
            let m = width - 2 * nq;
            for (i, row) in solutions.chunks_exact(width).enumerate() {
                let mut negated = row.iter().map(|lanes| -lanes[lane]);
                for (part, n) in
                    [(&mut *by_position, nq), (&mut *by_velocity, nq), (&mut *forcing, m)]
                {
                    let own = part[i * n..][..n].iter_mut();
                    own.zip(&mut negated).for_each(|(x, value)| *x = value);
                }
            }
        }
        let numbers = out
            .iter()
            .flat_map(|of| of.by_position.iter().chain(&of.by_velocity).chain(&of.forcing));
        if !numbers.fold(true, |all, number| all & number.is_finite()) {
            return false;
        }
    }
    true
}
