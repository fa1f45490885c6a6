//! [`SeriesStep`]: steps by the Taylor series of the motion, for mechanisms of few operations without loads and drives
//! that have power.
//!
//! Their work would be an unknown of no part in the error control, whose series falls more slowly than those of the
//! coordinates. One function, made of that of the accelerations and that of the constraints, is a step and all that the
//! next one needs:
//!
//! ```text
//! (t1, h, y, c_1 … c_p of y = (q, v, W)) → the end, projected, f near it and there
//!                                        → c_1 … c_p from there, the series of the pivots
//! ```

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

use bksim_dae::{ExplicitMethod, N_SERIES_VECTORS, SeriesVector, StepSpan, record_series_end};
use bksim_expr::{
    Coefficient, Composition, Function, Jit, LaneRunner, LaneWorkspace, Tape, TapeSeries, Value,
};

use crate::linear::elimination::{n_padded, padded};
use crate::linear::shape::Shape;
use crate::whole_step::{ProjectedEnd, StepParts, StepRecorder, record_projection};

/// Operations of the accelerations up to which series are looked at: beyond, steps by stages are cheaper at any tolerance.
const LARGEST: usize = 40;

/// Orders among which the best is sought.
const ORDERS: std::ops::RangeInclusive<usize> = 8..=24;

/// Nanoseconds of a step: around its functions, for an operation of the series, for an operation of the accelerations in
/// all stages, for an unknown in their sums. Measured on the pendulum at orders 8 to 24, the car axis, Andrews' mechanism
/// and the slider-crank, on an AMD EPYC of 2024; only their ratios count.
const AROUND_SERIES: f64 = 210.0;
const AROUND_STAGES: f64 = 230.0;
const OF_SERIES: f64 = 0.187;
const OF_STAGES: f64 = 2.0;
const OF_SUMS: f64 = 10.0;

/// The way of a step by stages, in radii of convergence, is this and the eighth root of the tolerance, there as well.
const BY_STAGES: f64 = 1.45;

/// Part of the work that extrapolation needs in the place of Dormand and Prince, where it is chosen.
const EXTRAPOLATED: f64 = 0.75;

/// Series are taken where they save more than a tenth.
const GAIN: f64 = 0.9;

/// Part of its value at the start that a pivot may lose within a step.
const LOST: f64 = 0.9;

/// The span of a step: its end, its size, and one where a run begins, else zero.
const N_SPAN: usize = 3;

/// The function by the order of the series, made when it is first asked for; shared by all runs of a mechanism.
#[derive(Debug)]
pub(crate) struct SeriesStep {
    parts: Arc<StepParts>,
    jit: Jit,
    /// Operations of series up to each order; `None` where there are no series.
    n_operations: OnceLock<Option<Vec<usize>>>,
    /// `None` where there are none.
    made: Mutex<BTreeMap<usize, Option<Arc<SeriesFunction>>>>,
}

/// The function for one order.
#[derive(Debug)]
pub(crate) struct SeriesFunction {
    shape: Shape,
    order: usize,
    step: LaneRunner<1>,
}

/// The function with parameters.
#[derive(Debug)]
pub(crate) struct SeriesWork {
    function: Arc<SeriesFunction>,
    workspace: LaneWorkspace<1>,
}

/// The results of a step by their meaning.
pub(crate) struct SeriesResults<'a> {
    /// All vectors of the step.
    pub(crate) vectors: &'a [f64],
    /// The end before its projection.
    pub(crate) unprojected: &'a [f64],
    pub(crate) end: ProjectedEnd<'a>,
    /// The pivots near the end and there, each [`padded`].
    pub(crate) pivots: &'a [f64],
}

impl SeriesStep {
    /// Nothing made yet.
    pub(crate) fn new(parts: Arc<StepParts>, jit: Jit) -> Self {
        Self { parts, jit, n_operations: OnceLock::new(), made: Mutex::default() }
    }

    /// The order of series that need the least work at this tolerance of the integrator; `None` where steps by stages,
    /// or by extrapolation if that would be chosen, need less, or accelerations have kinks.
    pub(crate) fn cheapest_order(&self, rtol: f64, is_extrapolated: bool) -> Option<usize> {
        let StepParts { shape, line, .. } = &*self.parts;
        if line.operation_count() > LARGEST {
            return None;
        }
        let count = || Some(TapeSeries::of(line)?.operation_counts(*ORDERS.end()));
        let counted = self.n_operations.get_or_init(count).as_ref()?;
        let work = |order: usize| {
            let n_operations = (counted[order - 1] + 2 * shape.nq * order) as f64;
            (AROUND_SERIES + OF_SERIES * n_operations) / ExplicitMethod::way_of_series(order, rtol)
        };
        let works = ORDERS.map(|order| (order, work(order)));
        let (best, least) = works.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let (n, n_operations) = (2 * shape.nq + 1, line.operation_count());
        let step = AROUND_STAGES + OF_STAGES * n_operations as f64 + OF_SUMS * n as f64;
        let by_stages = step / (BY_STAGES * rtol.powf(0.125));
        let part = if is_extrapolated { EXTRAPOLATED } else { 1.0 };
        (least < GAIN * part * by_stages).then_some(best)
    }

    /// The function for series of this order; `None` where accelerations have kinks.
    pub(crate) fn function(&self, order: usize) -> Option<Arc<SeriesFunction>> {
        let mut made = self.made.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let make = || SeriesFunction::of(&self.parts, order, self.jit).map(Arc::new);
        made.entry(order).or_insert_with(make).clone()
    }
}

impl SeriesFunction {
    fn of(parts: &StepParts, order: usize, jit: Jit) -> Option<Self> {
        let step = LaneRunner::new(step_tape(parts, order)?, jit);
        Some(Self { shape: parts.shape.clone(), order, step })
    }

    /// The numbers that a step is a function of, which are the first of the results of another; the last of them are
    /// the span of the step.
    fn n_arguments(&self) -> usize {
        n_arguments(self.n(), self.order)
    }

    /// Numbers of y.
    fn n(&self) -> usize {
        2 * self.shape.nq + 1
    }
}

fn n_arguments(n: usize, order: usize) -> usize {
    (order + N_SERIES_VECTORS) * n + N_SPAN
}

/// A step as a function of some results of the one before, and of its span: the coefficients of y from its end, order by
/// order, the [`SeriesVector`]s, room for the span of the next step, the coefficients of the pivots that change, pivot by
/// pivot, the gaps of [`ProjectedEnd`], and the pivots near the end and there. Where a run begins, the end is y itself.
fn step_tape(parts: &StepParts, order: usize) -> Option<Tape> {
    let Shape { nq, nc, .. } = parts.shape;
    let n = 2 * nq + 1;
    let mut line = TapeSeries::of(&parts.line)?;
    let n_inputs = n_arguments(n, order);
    let mut recorder = StepRecorder(Composition::new(n_inputs, parts.line.n_parameters()));
    let inputs: Vec<Value> = (0..n_inputs).map(|i| recorder.0.input(i)).collect();
    let (coefficients, rest) = inputs.split_at(order * n);
    let y = &rest[SeriesVector::ProjectedEnd as usize * n..][..n];
    let [t1, h, begins] = *inputs.last_chunk().expect("a span");

    // The end by the series; there is no power.
    let zero = recorder.0.constant(0.0);
    let (mut near, mut end, mut last_term) = (Vec::new(), Vec::new(), Vec::new());
    for (i, &y) in y[..2 * nq].iter().enumerate() {
        let own = coefficients.iter().copied().skip(i).step_by(n);
        let [own_near, own_end, own_last] = record_series_end(&mut recorder, h, y, own);
        near.push(own_near);
        end.push(own_end);
        last_term.push(own_last);
    }
    near.push(y[2 * nq]);
    end.push(y[2 * nq]);
    last_term.push(zero);
    let StepRecorder(mut composition) = recorder;

    // The end, projected by the factors near it.
    let (near_slope, factors) = parts.record_derivative(&mut composition, t1, &near);
    let (gaps, projected) = record_projection(parts, &mut composition, t1, &end, &factors);
    let choices = y.iter().zip(&projected);
    let choose = |(&y, &end)| composition.apply(Function::If, &[begins, y, end]);
    let projected: Vec<Value> = choices.map(choose).collect();
    let (slope, end_factors) = parts.record_derivative(&mut composition, t1, &projected);
    let near_pivots = padded(&factors[..nq + nc]);
    let pivots: Vec<Value> = near_pivots.chain(padded(&end_factors[..nq + nc])).collect();

    // State and time from there, order by order.
    let one = composition.constant(1.0);
    let mut state: Vec<Coefficient> = projected[..2 * nq].iter().copied().map(Some).collect();
    let mut results: Vec<Value> = Vec::new();
    let mut pivot_series: Vec<Vec<Coefficient>> = vec![Vec::new(); nq + nc];
    for k in 0..order {
        let time = match k {
            0 => Some(t1),
            1 => Some(one),
            _ => None,
        };
        let arguments = [&[time], &state[..]].concat();
        let solved = line.extend(&mut composition, &arguments);
        let (solution, factors) = solved.split_at(nq + nc);
        pivot_series.iter_mut().zip(factors).for_each(|(pivot, &next)| pivot.push(next));

        // The next order is the integral of what was found.
        let part = composition.constant(1.0 / (k + 1) as f64);
        let slopes = state[nq..].iter().chain(&solution[..nq]).chain([&None]).copied();
        let next = slopes.map(|slope| slope.map(|slope| composition.multiply(part, slope)));
        let next: Vec<Coefficient> = next.collect();
        results.extend(next.iter().map(|c| c.unwrap_or(zero)));
        state = next[..2 * nq].to_vec();
    }

    // In the order of the vectors.
    results.extend([near, near_slope, end, last_term, projected, slope].concat());
    results.extend([zero; N_SPAN]);
    let changing = pivot_series.iter().filter(|pivot| pivot[1..].iter().any(Option::is_some));
    results.extend(changing.flatten().map(|c| c.unwrap_or(zero)));
    results.extend([gaps, pivots].concat());
    Some(composition.finish(&results))
}

impl SeriesWork {
    /// For steps with these parameters.
    pub(crate) fn new(function: Arc<SeriesFunction>, parameters: &[f64]) -> Self {
        let workspace = function.step.workspace(parameters);
        Self { function, workspace }
    }

    /// Writes the results of a step that ends where it begins, at `(t, y)`.
    pub(crate) fn begin(&mut self, t: f64, y: &[f64], results: &mut Vec<f64>) {
        let Self { function, .. } = self;
        let mut arguments = vec![0.0; function.n_arguments()];
        let at = (function.order + SeriesVector::ProjectedEnd as usize) * function.n();
        arguments[at..][..y.len()].copy_from_slice(y);
        self.evaluate([t, 0.0, 1.0], &mut arguments, results);
    }

    /// Writes the results of a step from where that with the results `begin` ended.
    pub(crate) fn take(
        &mut self,
        StepSpan { h, t1, .. }: StepSpan,
        begin: &mut [f64],
        results: &mut Vec<f64>,
    ) {
        self.evaluate([t1, h, 0.0], begin, results);
    }

    fn evaluate(&mut self, span: [f64; N_SPAN], begin: &mut [f64], results: &mut Vec<f64>) {
        let Self { function, workspace } = self;
        let arguments = &mut begin[..function.n_arguments()];
        if let Some(own_span) = arguments.last_chunk_mut() {
            *own_span = span;
        }
        let n_outputs = function.step.tape().n_outputs();
        if results.len() < n_outputs {
            results.resize(n_outputs, 0.0);
        }
        let results = results[..n_outputs].as_chunks_mut().0;
        function.step.evaluate(workspace, arguments.as_chunks().0, results);
    }

    /// The results of a step by their meaning.
    pub(crate) fn results<'r>(&self, results: &'r [f64]) -> SeriesResults<'r> {
        let Self { function, .. } = self;
        let (n, Shape { nq, nc, .. }) = (function.n(), &function.shape);
        let results = &results[function.order * n..function.step.tape().n_outputs()];
        let (vectors, rest) = results.split_at(N_SERIES_VECTORS * n);
        let vector = |vector: SeriesVector| &vectors[vector as usize * n..][..n];
        let (rest, pivots) = rest.split_at(rest.len() - 2 * n_padded(nq + nc));
        let gaps = &rest[rest.len() - ProjectedEnd::n_gaps(*nc)..];
        let state = [vector(SeriesVector::ProjectedEnd), vector(SeriesVector::EndDerivative)];
        let end = ProjectedEnd { gaps, state };
        SeriesResults { vectors, unprojected: vector(SeriesVector::End), end, pivots }
    }

    /// True where no pivot loses its sign within a step of this size, by a series.
    pub(crate) fn holds(&self, h: f64, results: &[f64]) -> bool {
        let Self { function, .. } = self;
        let (order, Shape { nq, nc, .. }) = (function.order, &function.shape);
        let others = ProjectedEnd::n_gaps(*nc) + 2 * n_padded(nq + nc);
        let end = function.step.tape().n_outputs() - others;
        let pivots = &results[function.n_arguments()..end];
        pivots.chunks_exact(order).all(|pivot| {
            let change = pivot[1..].iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * h.abs());
            change <= LOST * pivot[0].abs()
        })
    }
}
