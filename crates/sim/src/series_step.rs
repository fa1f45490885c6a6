//! [`SeriesStep`]: steps by the Taylor series of the motion, for mechanisms of few operations without loads and drives
//! that have power.
//!
//! Their work would be an unknown of no part in the error control, whose series falls more slowly than those of the
//! coordinates. Two functions, made of those of the accelerations and the constraints:
//!
//! ```text
//! series   (t, y) → c_1 … c_p of y = (q, v, W), and the series of the pivots
//! end      (t1, y near the end, y at the end) → f at the first, the second projected, f there
//! ```

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

use bksim_dae::ExplicitMethod;
use bksim_expr::{
    Coefficient, Composition, Jit, LaneRunner, LaneWorkspace, Tape, TapeSeries, Value,
};

use crate::linear::elimination::padded;
use crate::linear::shape::Shape;
use crate::whole_step::{ProjectedEnd, StepParts, record_end};

/// Operations of the accelerations up to which series are looked at: beyond, steps by stages are cheaper at any tolerance.
const LARGEST: usize = 40;

/// The order whose operations are counted, those of others being about in proportion to its square.
const COUNTED: usize = 8;

/// Orders among which the best is sought.
const ORDERS: std::ops::RangeInclusive<usize> = 8..=24;

/// Instructions of a step: around its functions, for an operation of the series, for an operation of the accelerations in
/// all stages, for an unknown in their sums. Counted on the pendulum, the car axis, Andrews' mechanism and the slider-crank.
const AROUND_SERIES: f64 = 4300.0;
const AROUND_STAGES: f64 = 3400.0;
const OF_SERIES: f64 = 1.5;
const OF_STAGES: f64 = 30.0;
const OF_SUMS: f64 = 150.0;

/// The way of a step by stages, in radii of convergence, is this and the eighth root of the tolerance, there as well.
const BY_STAGES: f64 = 1.7;

/// Part of the work that extrapolation needs in the place of Dormand and Prince, where it is chosen.
const EXTRAPOLATED: f64 = 0.75;

/// Series are taken where they save more than a tenth.
const GAIN: f64 = 0.9;

/// Part of its value at the start that a pivot may lose within a step.
const LOST: f64 = 0.9;

/// The functions by the order of the series, made when they are first asked for; shared by all runs of a mechanism.
#[derive(Debug)]
pub(crate) struct SeriesStep {
    parts: StepParts,
    jit: Jit,
    /// Operations of series of the order that is counted; `None` where there are no series.
    n_operations: OnceLock<Option<usize>>,
    /// `None` where there are none.
    made: Mutex<BTreeMap<usize, Option<Arc<SeriesFunctions>>>>,
}

/// The functions for one order.
#[derive(Debug)]
pub(crate) struct SeriesFunctions {
    shape: Shape,
    order: usize,
    series: LaneRunner<1>,
    end: LaneRunner<1>,
}

/// The functions with parameters, and room for their arguments and results.
#[derive(Debug)]
pub(crate) struct SeriesWork {
    functions: Arc<SeriesFunctions>,
    series: LaneWorkspace<1>,
    end: LaneWorkspace<1>,
    arguments: Vec<[f64; 1]>,
    ends: Vec<[f64; 1]>,
}

impl SeriesStep {
    /// Nothing made yet.
    pub(crate) fn new(parts: StepParts, jit: Jit) -> Self {
        Self { parts, jit, n_operations: OnceLock::new(), made: Mutex::default() }
    }

    /// The order of series that need the least work at this tolerance of the integrator; `None` where steps by stages,
    /// or by extrapolation if that would be chosen, need less, or accelerations have kinks.
    pub(crate) fn cheapest_order(&self, rtol: f64, is_extrapolated: bool) -> Option<usize> {
        let StepParts { shape, line, .. } = &self.parts;
        if line.operation_count() > LARGEST {
            return None;
        }
        let count = || series_tape(&self.parts, COUNTED).map(|tape| tape.operation_count());
        let counted = (*self.n_operations.get_or_init(count))? as f64;
        let work = |order: usize| {
            let n_operations = counted * (order as f64 / COUNTED as f64).powi(2);
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

    /// The functions for series of this order; `None` where accelerations have kinks.
    pub(crate) fn functions(&self, order: usize) -> Option<Arc<SeriesFunctions>> {
        let mut made = self.made.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let make = || SeriesFunctions::of(&self.parts, order, self.jit).map(Arc::new);
        made.entry(order).or_insert_with(make).clone()
    }
}

impl SeriesFunctions {
    fn of(parts: &StepParts, order: usize, jit: Jit) -> Option<Self> {
        let series = series_tape(parts, order)?;
        Some(Self {
            shape: parts.shape.clone(),
            order,
            series: LaneRunner::new(series, jit),
            end: LaneRunner::new(end_tape(parts), jit),
        })
    }

    /// Numbers of y.
    fn n(&self) -> usize {
        2 * self.shape.nq + 1
    }
}

/// The coefficients of y, order by order, then those of the pivots that change, pivot by pivot, as a function of (t, y).
fn series_tape(parts: &StepParts, order: usize) -> Option<Tape> {
    let Shape { nq, nc, .. } = parts.shape;
    let mut line = TapeSeries::of(&parts.line)?;
    let mut composition = Composition::new(1 + 2 * nq, parts.line.n_parameters());
    let zero = composition.constant(0.0);
    let one = composition.constant(1.0);

    // State and time, order by order.
    let mut state: Vec<Coefficient> = (0..2 * nq).map(|i| Some(composition.input(1 + i))).collect();
    let mut results: Vec<Value> = Vec::new();
    let mut pivots: Vec<Vec<Coefficient>> = vec![Vec::new(); nq + nc];
    for k in 0..order {
        let time = match k {
            0 => Some(composition.input(0)),
            1 => Some(one),
            _ => None,
        };
        let arguments = [&[time], &state[..]].concat();
        let solved = line.extend(&mut composition, &arguments);
        let (solution, factors) = solved.split_at(nq + nc);
        pivots.iter_mut().zip(factors).for_each(|(pivot, &next)| pivot.push(next));

        // The next order is the integral of what was found; there is no power.
        let part = composition.constant(1.0 / (k + 1) as f64);
        let slopes = state[nq..].iter().chain(&solution[..nq]).chain([&None]).copied();
        let next = slopes.map(|slope| slope.map(|slope| composition.multiply(part, slope)));
        let next: Vec<Coefficient> = next.collect();
        results.extend(next.iter().map(|c| c.unwrap_or(zero)));
        state = next[..2 * nq].to_vec();
    }
    let changing = pivots.iter().filter(|pivot| pivot[1..].iter().any(Option::is_some));
    results.extend(changing.flatten().map(|c| c.unwrap_or(zero)));
    Some(composition.finish(&results))
}

/// The derivative at the first state, a [`ProjectedEnd`] from the second, then the pivots of both.
fn end_tape(parts: &StepParts) -> Tape {
    let StepParts { shape, line, .. } = parts;
    let Shape { nq, nc, .. } = *shape;
    let n = 2 * nq + 1;
    let mut composition = Composition::new(1 + 2 * n, line.n_parameters());
    let inputs: Vec<Value> = (0..=2 * n).map(|i| composition.input(i)).collect();
    let (t, (near, y)) = (inputs[0], inputs[1..].split_at(n));
    let (slope, factors) = parts.record_derivative(&mut composition, t, near);
    let pivots: Vec<Value> = padded(&factors[..nq + nc]).collect();
    let (end, end_pivots) = record_end(parts, &mut composition, t, (y, &factors));
    composition.finish(&[slope, end, pivots, end_pivots].concat())
}

impl SeriesWork {
    /// Room for steps with these parameters.
    pub(crate) fn new(functions: Arc<SeriesFunctions>, parameters: &[f64]) -> Self {
        let n = functions.n();
        let (series, end) =
            (functions.series.workspace(parameters), functions.end.workspace(parameters));
        Self {
            series,
            end,
            arguments: vec![[0.0]; 1 + 2 * n],
            ends: vec![[0.0]; functions.end.tape().n_outputs()],
            functions,
        }
    }

    /// Writes the coefficients of the motion through `(t, y)`: unknowns of one order together, then those of the pivots,
    /// orders of one together.
    pub(crate) fn develop(&mut self, t: f64, y: &[f64], results: &mut Vec<f64>) {
        let Self { functions, series, arguments, .. } = self;
        let n_outputs = functions.series.tape().n_outputs();
        let n_inputs = functions.series.tape().n_inputs();
        let all = &mut arguments[..n_inputs];
        let numbers = all.as_flattened_mut();
        numbers[0] = t;
        numbers[1..].copy_from_slice(&y[..n_inputs - 1]);
        results.resize(results.len().max(n_outputs), 0.0);
        functions.series.evaluate(series, all, results[..n_outputs].as_chunks_mut().0);
    }

    /// True where no pivot loses its sign within a step of this size, by a series.
    pub(crate) fn holds(&self, h: f64, results: &[f64]) -> bool {
        let functions = &self.functions;
        let n_outputs = functions.series.tape().n_outputs();
        let pivots = &results[functions.order * functions.n()..n_outputs];
        pivots.chunks_exact(functions.order).all(|pivot| {
            let change = pivot[1..].iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * h.abs());
            change <= LOST * pivot[0].abs()
        })
    }

    /// The derivative near the end of a step at `t1`, the end, and the pivots of both.
    pub(crate) fn end(
        &mut self,
        t1: f64,
        near: &[f64],
        y1: &[f64],
    ) -> (&[f64], ProjectedEnd<'_>, &[f64]) {
        let Self { functions, end, arguments, ends, .. } = self;
        let numbers = arguments.as_flattened_mut();
        numbers[0] = t1;
        let (own_near, own_y1) = numbers[1..].split_at_mut(near.len());
        own_near.copy_from_slice(near);
        own_y1.copy_from_slice(y1);
        functions.end.evaluate(end, arguments, ends);
        let n = functions.n();
        let (slope, rest) = ends.as_flattened().split_at(n);
        let (end, pivots) = ProjectedEnd::of(rest, n, functions.shape.nc);
        (slope, end, pivots)
    }
}
