//! Events: zero crossings of functions of the state, found on the dense output of accepted steps.
//!
//! The functions are sampled at nine points of a step. A change of sign brackets a crossing. Where
//! a function keeps its sign but turns back towards zero between samples, its extremum is located,
//! so that two crossings close together are not missed.

use crate::dense::Step;
use crate::error::SolveError;
use crate::run::Start;

/// Directions of a crossing that count, seen along the run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Crossing {
    /// From negative to positive.
    Rising,
    /// From positive to negative.
    Falling,
    /// Both.
    #[default]
    Either,
}

/// A crossing that was found.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Event {
    /// Index of the function, from zero.
    pub i: usize,
    /// Time, to a few units of rounding of `t`, on the far side of the crossing.
    pub t: f64,
    /// [`Crossing::Rising`] or [`Crossing::Falling`].
    pub crossing: Crossing,
}

/// Functions of the state whose zero crossings are searched for.
pub trait Events {
    /// Number of functions.
    fn count(&self) -> usize;

    /// The crossings of function `i` that count.
    fn crossing(&self, _i: usize) -> Crossing {
        Crossing::Either
    }

    /// The amount by which function `i` is raised above the one that is meant, so that rounding about
    /// zero is no event. A falling crossing counts once the raised function passes zero, and its time
    /// is that at which the function that is meant did. None by default.
    fn band(&self, _i: usize) -> f64 {
        0.0
    }

    /// Writes the functions at a state to `out`. They should be continuous; a value that is not
    /// finite counts as no crossing.
    fn values(&mut self, t: f64, y: &[f64], out: &mut [f64]);

    /// Function `i` at a state, the same number as among all of them; `room` has room for these.
    fn value(&mut self, i: usize, t: f64, y: &[f64], room: &mut [f64]) -> f64 {
        self.values(t, y, room);
        room[i]
    }
}

/// Sample points of a step, closer at its ends: an extremum needs a sample on either side.
const NODES: [f64; N_PARTS + 1] = [0.0, 0.02, 0.15, 0.325, 0.5, 0.675, 0.85, 0.98, 1.0];
/// Parts of a step between samples.
const N_PARTS: usize = 8;
/// The first sample point of the first step.
const FIRST_NODE: f64 = 0.001;
/// A parabola through three samples that passes zero between them has an outer one larger than the middle one by
/// 1.6 or more, with these nodes; a function that stays as it is, by rounding.
const BEND: f64 = 1.1;
/// Crossings this near to one another, as a part of t, may be taken for one.
const SAME_INSTANT: f64 = 64.0 * f64::EPSILON;
/// Refinements of an extremum.
const MAX_EXTREMUM: usize = 24;
/// Refinements of a bracket; bisection alone needs 52.
const MAX_BRACKET: usize = 120;

/// Search for the crossings of some [`Events`] in one step after the other.
///
/// ```
/// use bksim_dae::{EventSearch, Events, ExplicitSolver, Layout, NotFinite, Ode, Settings, Start};
///
/// /// A stone in free fall, `y = (height, velocity)`.
/// struct Stone(Layout);
///
/// impl Ode for Stone {
///     fn layout(&self) -> &Layout { &self.0 }
///     fn derivative(&mut self, _t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
///         ydot.copy_from_slice(&[y[1], -9.81]);
///         Ok(())
///     }
/// }
///
/// /// The ground at height zero.
/// struct Ground;
///
/// impl Events for Ground {
///     fn count(&self) -> usize { 1 }
///     fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) { out[0] = y[0]; }
/// }
///
/// let start = Start { t: 0.0, y: vec![1.0, 0.0], ydot: vec![0.0; 2] };
/// let mut search = EventSearch::new(&mut Ground, &start);
/// let layout = Layout::from_groups(&[(2, bksim_dae::Index::One)]);
/// let mut solver = ExplicitSolver::new(Stone(layout), start, 2.0, Settings::default())?;
/// let impact = loop {
///     let step = solver.step()?.expect("the stone reaches the ground within two seconds");
///     if let Some(event) = search.crossings(&mut Ground, &step).first() {
///         break event.t;
///     }
/// };
/// assert!((impact - (2.0f64 / 9.81).sqrt()).abs() < 1e-9);
/// # Ok::<(), bksim_dae::SolveError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EventSearch {
    /// Samples, one row of functions after the other; the first row outlives the step.
    samples: Vec<f64>,
    n: usize,
    scratch: Vec<f64>,
    y: Vec<f64>,
    found: Vec<Event>,
    /// The next step is the first.
    is_first: bool,
    /// Where only the first crossing is looked for: an instant just after the first of those found, and the functions there.
    after: Option<(f64, Vec<f64>)>,
}

/// Two times with the values of one function, of opposite sign or around an extremum.
#[derive(Clone, Copy)]
struct Bracket {
    a: (f64, f64),
    b: (f64, f64),
}

impl EventSearch {
    /// A search that begins at a state. A function that is zero there must move away before it can
    /// cross.
    pub fn new<E: Events>(events: &mut E, start: &Start) -> Self {
        let n = events.count();
        let mut search = Self {
            samples: vec![0.0; (N_PARTS + 1) * n],
            n,
            scratch: vec![0.0; n],
            y: vec![0.0; start.y.len()],
            found: Vec::with_capacity(2 * n),
            is_first: true,
            after: None,
        };
        events.values(start.t, &start.y, &mut search.samples[..n]);
        search
    }

    /// The functions at the end of the last step, and whether there was none yet: the state of the
    /// search between two steps.
    pub fn remembered(&self) -> (Vec<f64>, bool) {
        (self.samples[..self.n].to_vec(), self.is_first)
    }

    /// Goes on from what [`EventSearch::remembered`] returned.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when there are more functions, or fewer.
    pub fn resume(&mut self, values: &[f64], is_first: bool) -> Result<(), SolveError> {
        if values.len() != self.n {
            return Err(SolveError::Checkpoint { reason: "saved with other events" });
        }
        self.samples[..self.n].copy_from_slice(values);
        self.is_first = is_first;
        Ok(())
    }

    /// All crossings of a step that count, in its order of time. Each step begins where the one
    /// before it ended.
    pub fn crossings<E: Events>(&mut self, events: &mut E, step: &Step<'_>) -> &[Event] {
        self.search(events, step, false)
    }

    /// The first crossing of a step that counts, with all that are as early up to rounding, and maybe some that come later.
    ///
    /// They are those that begin what [`EventSearch::crossings`] returns, to the last bit. Functions that have not crossed yet just
    /// after the first crossing found so far are left out, so that many functions which cross in a step are not all located.
    pub fn first_crossings<E: Events>(&mut self, events: &mut E, step: &Step<'_>) -> &[Event] {
        self.search(events, step, true)
    }

    fn search<E: Events>(
        &mut self,
        events: &mut E,
        step: &Step<'_>,
        is_first_enough: bool,
    ) -> &[Event] {
        self.found.clear();
        self.after = None;
        if self.n == 0 {
            return &self.found;
        }
        let times: [f64; N_PARTS + 1] = std::array::from_fn(|k| self.time(step, k));
        for (k, &t) in times.iter().enumerate().skip(1) {
            step.at(t, &mut self.y);
            events.values(t, &self.y, &mut self.samples[k * self.n..(k + 1) * self.n]);
        }
        let forward = step.h().signum();
        for k in 1..=N_PARTS {
            for i in 0..self.n {
                let n_before = self.found.len();
                self.crossings_in(events, step, (i, k), &times);
                if is_first_enough && self.found.len() > n_before {
                    self.look_after(events, step);
                }
            }
            // What crosses in later parts does so after this.
            let is_past = |after: &(f64, Vec<f64>)| forward * (after.0 - times[k]) < 0.0;
            if self.after.as_ref().is_some_and(is_past) {
                break;
            }
        }
        // Functions that cross at the same instant keep their order.
        self.found.sort_by(|a, b| (forward * a.t).total_cmp(&(forward * b.t)).then(a.i.cmp(&b.i)));

        self.samples.copy_within(N_PARTS * self.n.., 0);
        self.is_first = false;
        &self.found
    }

    /// Takes the functions just after the first crossing found so far, unless they are known.
    fn look_after<E: Events>(&mut self, events: &mut E, step: &Step<'_>) {
        let forward = step.h().signum();
        let times = self.found.iter().map(|event| forward * event.t);
        let first = times.fold(f64::INFINITY, f64::min);
        let t = forward * (first + SAME_INSTANT * first.abs());
        if self.after.as_ref().is_some_and(|(known, _)| forward * (known - t) <= 0.0) {
            return;
        }
        let mut values = self.after.take().map_or_else(|| vec![0.0; self.n], |(_, values)| values);
        step.at(t, &mut self.y);
        events.values(t, &self.y, &mut values);
        self.after = Some((t, values));
    }

    /// True of function `i` if it has the sign that it has at `a` still after the first crossing found so far: by more than
    /// its band, or from `a` on.
    fn is_later<E: Events>(&self, events: &E, forward: f64, i: usize, a: (f64, f64)) -> bool {
        self.after.as_ref().is_some_and(|(t, values)| {
            let is_before = values[i] * a.1 > 0.0 && values[i].abs() > events.band(i);
            forward * (a.0 - t) >= 0.0 || is_before
        })
    }

    /// Time of sample `k`. The first one of the first step comes early: it shows on which side of
    /// zero a function leaves that starts there.
    fn time(&self, step: &Step<'_>, k: usize) -> f64 {
        let part = match k {
            0 => return step.t0(),
            N_PARTS => return step.t1(),
            1 if self.is_first => FIRST_NODE,
            _ => NODES[k],
        };
        step.t0() + part * (step.t1() - step.t0())
    }

    /// Keeps the crossings of function `i` between samples k − 1 and k, and those about sample k.
    fn crossings_in<E: Events>(
        &mut self,
        events: &mut E,
        step: &Step<'_>,
        (i, k): (usize, usize),
        times: &[f64; N_PARTS + 1],
    ) {
        let sample = |search: &Self, k: usize| (times[k], search.samples[k * search.n + i]);
        let (a, b) = (sample(self, k - 1), sample(self, k));
        let forward = step.h().signum();
        if (a.1 * b.1 < 0.0 || (b.1 == 0.0 && a.1 != 0.0)) && !self.is_later(events, forward, i, a)
        {
            self.keep(events, step, i, Bracket { a, b });
        }
        if k == N_PARTS {
            return;
        }
        // An extremum near the middle of three samples of one sign, the middle nearest to zero, on a curve
        // that bends enough to get there.
        let c = sample(self, k + 1);
        let [before, middle, after] = [a.1, b.1, c.1].map(f64::abs);
        let turns = a.1 * b.1 > 0.0
            && b.1 * c.1 > 0.0
            && middle <= before.min(after)
            && before.max(after) > BEND * middle;
        if turns && let Some(m) = self.opposite(events, step, i, a, c) {
            self.keep(events, step, i, Bracket { a, b: m });
            self.keep(events, step, i, Bracket { a: m, b: c });
        }
    }

    /// Searches between `a` and `c` for a value of the other sign, by golden section on the
    /// magnitude.
    fn opposite<E: Events>(
        &mut self,
        events: &mut E,
        step: &Step<'_>,
        i: usize,
        a: (f64, f64),
        c: (f64, f64),
    ) -> Option<(f64, f64)> {
        const GOLDEN: f64 = 0.381_966_011_250_105_2; // (3 − √5)/2
        let sign = a.1.signum();
        let (mut left, mut right) = (a.0, c.0);
        let mut inner = [GOLDEN, 1.0 - GOLDEN].map(|part| left + part * (right - left));
        let mut magnitude = inner.map(|t| sign * self.value(events, step, i, t));
        for _ in 0..MAX_EXTREMUM {
            for side in 0..2 {
                if magnitude[side] < 0.0 {
                    return Some((inner[side], sign * magnitude[side]));
                }
            }
            if magnitude[0] < magnitude[1] {
                right = inner[1];
                (inner[1], magnitude[1]) = (inner[0], magnitude[0]);
                inner[0] = left + GOLDEN * (right - left);
                magnitude[0] = sign * self.value(events, step, i, inner[0]);
            } else {
                left = inner[0];
                (inner[0], magnitude[0]) = (inner[1], magnitude[1]);
                inner[1] = left + (1.0 - GOLDEN) * (right - left);
                magnitude[1] = sign * self.value(events, step, i, inner[1]);
            }
        }
        None
    }

    /// Locates a bracketed crossing and keeps it if it counts.
    fn keep<E: Events>(&mut self, events: &mut E, step: &Step<'_>, i: usize, bracket: Bracket) {
        let crossing = if bracket.a.1 < 0.0 { Crossing::Rising } else { Crossing::Falling };
        let counted = events.crossing(i);
        if counted == Crossing::Either || counted == crossing {
            let mut t = self.locate(events, step, i, bracket, 0.0);
            let band = events.band(i);
            if band > 0.0 && crossing == Crossing::Falling {
                t = self.before_band(events, step, i, (bracket.a, t), band);
            }
            self.found.push(Event { i, t, crossing });
        }
    }

    /// When a function that is raised by `band` passed that value, which it has fallen below at `t`;
    /// `t` itself where it has been below all along since `start` of the bracket.
    fn before_band<E: Events>(
        &mut self,
        events: &mut E,
        step: &Step<'_>,
        i: usize,
        (start, t): ((f64, f64), f64),
        band: f64,
    ) -> f64 {
        // Backwards in growing strides, so that the crossing found is the last one.
        const FIRST_STRIDE: f64 = 1e-9;
        const GROWTH: f64 = 8.0;
        let width = t - start.0;
        let mut below = (t, self.value(events, step, i, t) - band);
        let mut stride = FIRST_STRIDE;
        loop {
            let is_whole = stride >= 1.0;
            let earlier = if is_whole { start.0 } else { t - stride * width };
            let value =
                if is_whole { start.1 } else { self.value(events, step, i, earlier) } - band;
            if value > 0.0 {
                return self.locate(
                    events,
                    step,
                    i,
                    Bracket { a: (earlier, value), b: below },
                    band,
                );
            }
            if is_whole {
                return t;
            }
            below = (earlier, value);
            stride *= GROWTH;
        }
    }

    /// Shrinks the bracket of the function less `level` to rounding by the Illinois rule, with a
    /// bisection where that stalls; returns the end beyond the crossing.
    fn locate<E: Events>(
        &mut self,
        events: &mut E,
        step: &Step<'_>,
        i: usize,
        Bracket { mut a, mut b }: Bracket,
        level: f64,
    ) -> f64 {
        for iteration in 0..MAX_BRACKET {
            let width = b.0 - a.0;
            let rounding = 4.0 * f64::EPSILON * a.0.abs().max(b.0.abs());
            if width.abs() <= rounding.max(1e-15 * step.h().abs()) {
                break;
            }
            let secant = b.0 - width * b.1 / (b.1 - a.1);
            let is_inside = (secant - a.0) * (secant - b.0) < 0.0;
            let bisect = iteration % 3 == 2 || !is_inside;
            let t = if bisect { a.0 + 0.5 * width } else { secant };
            if t == a.0 || t == b.0 {
                break;
            }
            let value = self.value(events, step, i, t) - level;
            if value * a.1 > 0.0 {
                a = (t, value);
                b.1 *= 0.5;
            } else {
                b = (t, value);
                a.1 *= 0.5;
            }
        }
        b.0
    }

    fn value<E: Events>(&mut self, events: &mut E, step: &Step<'_>, i: usize, t: f64) -> f64 {
        step.at(t, &mut self.y);
        events.value(i, t, &self.y, &mut self.scratch)
    }
}
