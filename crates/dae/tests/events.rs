//! Events: times against closed forms, order, double roots, restarts, resuming, both methods.

use bksim_dae::{
    Crossing, Event, EventSearch, Events, ExplicitSolver, Layout, NotFinite, Ode, Settings,
    SolveError, Solver, Start, Step, System, Tolerance,
};

use crate::common::dual::Real;
use crate::common::{Differentiated, Residual, uniform};

const G: f64 = 9.81;

/// A ball in free fall, `y = (height, velocity)`.
struct Ball(Layout);

impl Ode for Ball {
    fn layout(&self) -> &Layout {
        &self.0
    }
    fn derivative(&mut self, _t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        ydot.copy_from_slice(&[y[1], -G]);
        Ok(())
    }
}

impl Residual for Ball {
    fn layout(&self) -> Layout {
        uniform(2)
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        vec![ydot[0] - y[1], ydot[1] + T::from(G)]
    }
}

/// The ground at height zero.
struct Ground;

impl Events for Ground {
    fn count(&self) -> usize {
        1
    }
    fn crossing(&self, _i: usize) -> Crossing {
        Crossing::Falling
    }
    fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) {
        out[0] = y[0];
    }
}

fn settings(tolerance: f64) -> Settings {
    Settings { rtol: tolerance, atol: Tolerance::Scalar(tolerance), ..Settings::default() }
}

fn dropped() -> Start {
    Start { t: 0.0, y: vec![1.0, 0.0], ydot: vec![0.0, -G] }
}

/// The two methods, for tests that hold for both.
trait Restartable {
    fn step(&mut self) -> Option<Step<'_>>;
    fn restart(&mut self, state: &Start);
}

impl<S: System> Restartable for Solver<S> {
    fn step(&mut self) -> Option<Step<'_>> {
        Solver::step(self).expect("no failure")
    }
    fn restart(&mut self, state: &Start) {
        Solver::restart(self, state).expect("the state fits");
    }
}

impl<S: Ode> Restartable for ExplicitSolver<S> {
    fn step(&mut self) -> Option<Step<'_>> {
        ExplicitSolver::step(self).expect("no failure")
    }
    fn restart(&mut self, state: &Start) {
        ExplicitSolver::restart(self, state.t, &state.y).expect("the state fits");
    }
}

/// Times at which a dropped ball hits the ground; it bounces with restitution `e`.
fn bounce(solver: &mut impl Restartable, e: f64) -> Vec<f64> {
    let mut search = EventSearch::new(&mut Ground, &dropped());
    let mut impacts = Vec::new();
    while let Some(step) = solver.step() {
        let Some(&Event { t, .. }) = search.crossings(&mut Ground, &step).first() else { continue };
        let mut y = [0.0; 2];
        step.at(t, &mut y);
        impacts.push(t);
        let after = Start { t, y: vec![0.0, -e * y[1]], ydot: vec![-e * y[1], -G] };
        solver.restart(&after);
        // The ball leaves from the height zero, which must not count as another impact.
        search = EventSearch::new(&mut Ground, &after);
    }
    impacts
}

#[test]
fn a_ball_bounces_at_the_times_of_the_closed_form_with_both_methods() {
    let e = 0.8f64;
    let first = (2.0 / G).sqrt();
    // t_k = t_1 (1 + 2 e + 2 e² + …).
    let exact = |k: i32| first * (1.0 + (1..=k).map(|j| 2.0 * e.powi(j)).sum::<f64>());
    let check = |name: &str, impacts: &[f64]| {
        assert_eq!(impacts.len(), 6, "{name}: {impacts:?}");
        for (k, &found) in (0..).zip(impacts) {
            let exact = exact(k);
            assert!((found - exact).abs() < 1e-11, "{name}: impact at {found}, exact {exact}");
        }
    };
    let mut solver =
        ExplicitSolver::new(Ball(uniform(2)), dropped(), 3.0, settings(1e-10)).expect("valid");
    check("explicit", &bounce(&mut solver, e));
    let system = Differentiated::dense(Ball(uniform(2)));
    let mut solver = Solver::new(system, dropped(), 3.0, settings(1e-10)).expect("valid");
    check("Radau", &bounce(&mut solver, e));
}

/// `y′ = 1`: time itself, so that every crossing is known.
struct Clock(Layout);

impl Ode for Clock {
    fn layout(&self) -> &Layout {
        &self.0
    }
    fn derivative(&mut self, _t: f64, _y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        ydot[0] = 1.0;
        Ok(())
    }
}

fn clock(from: f64, to: f64) -> (ExplicitSolver<Clock>, Start) {
    let start = Start { t: from, y: vec![from], ydot: vec![1.0] };
    let settings = Settings { h_initial: Some(1.0), ..settings(1e-9) };
    (ExplicitSolver::new(Clock(uniform(1)), start.clone(), to, settings).expect("valid"), start)
}

/// Functions of the clock.
struct OfTime<'a>(Vec<(Crossing, &'a dyn Fn(f64) -> f64)>);

impl Events for OfTime<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }
    fn crossing(&self, i: usize) -> Crossing {
        self.0[i].0
    }
    fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) {
        for (out, (_, function)) in out.iter_mut().zip(&self.0) {
            *out = function(y[0]);
        }
    }
}

/// All crossings on the way from one time to another.
fn crossings(mut functions: OfTime<'_>, from: f64, to: f64) -> Vec<Event> {
    let (mut solver, start) = clock(from, to);
    let mut search = EventSearch::new(&mut functions, &start);
    let mut found = Vec::new();
    while let Some(step) = solver.step().expect("no failure") {
        found.extend_from_slice(search.crossings(&mut functions, &step));
    }
    found
}

#[test]
fn the_first_crossings_are_those_that_all_crossings_begin_with() {
    // Waves of many lengths, some of which touch zero twice between samples, and some that cross at one instant.
    let waves: Vec<Box<dyn Fn(f64) -> f64>> = (0..60_i32)
        .map(|k| {
            let (rate, lag) = (0.3 + 0.17 * f64::from(k % 13), 0.011 * f64::from(k * k % 29));
            let level = 0.02 * f64::from(k % 7);
            Box::new(move |t: f64| (rate * (t - lag)).cos() - level) as Box<dyn Fn(f64) -> f64>
        })
        .collect();
    let all = || OfTime(waves.iter().map(|wave| (Crossing::Falling, &**wave)).collect());
    let (mut solver, start) = clock(0.0, 20.0);
    let mut whole = EventSearch::new(&mut all(), &start);
    let mut first = EventSearch::new(&mut all(), &start);
    let mut n_met = 0;
    while let Some(step) = solver.step().expect("no failure") {
        let expected = whole.crossings(&mut all(), &step);
        let found = first.first_crossings(&mut all(), &step);
        assert_eq!(found.first(), expected.first());
        let Some(earliest) = expected.first() else { continue };
        let now = |events: &[Event]| events.iter().filter(|e| e.t == earliest.t).count();
        assert_eq!(now(found), now(expected));
        n_met += expected.len();
    }
    assert!(n_met > 100, "{n_met} crossings");
}

fn assert_times(found: &[Event], expected: &[(usize, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}, expected {expected:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.i, expected.0, "order of {found:?} and {expected:?}");
        assert!((found.t - expected.1).abs() < 1e-14, "{found:?}, expected {expected:?}");
    }
}

#[test]
fn several_events_in_a_step_come_in_order_and_in_their_direction() {
    let late = |t: f64| t - 0.7;
    let early = |t: f64| 0.2 - t;
    let wave = |t: f64| (t - 0.3) * (t - 0.6);
    let all = || {
        OfTime(vec![
            (Crossing::Rising, &late),
            (Crossing::Falling, &early),
            (Crossing::Either, &wave),
        ])
    };
    let found = crossings(all(), 0.0, 1.0);
    assert_times(&found, &[(1, 0.2), (2, 0.3), (2, 0.6), (0, 0.7)]);
    let directions: Vec<_> = found.iter().map(|event| event.crossing).collect();
    let (falling, rising) = (Crossing::Falling, Crossing::Rising);
    assert_eq!(directions, [falling, falling, rising, rising]);

    // Backwards, directions are those met on the way.
    assert_times(&crossings(all(), 1.0, 0.0), &[(2, 0.6), (2, 0.3)]);
}

#[test]
fn two_crossings_close_together_are_not_missed() {
    for gap in [1e-1, 1e-3, 1e-6] {
        for middle in [0.06, 0.31, 0.5, 0.77, 0.94] {
            let gap = gap * 0.5;
            let dip = move |t: f64| (t - middle).powi(2) - gap * gap;
            let found = crossings(OfTime(vec![(Crossing::Either, &dip)]), 0.0, 1.0);
            assert_eq!(found.len(), 2, "gap {gap}, middle {middle}: {found:?}");
            assert!((found[0].t - (middle - gap)).abs() < 1e-9, "{found:?}");
            assert!((found[1].t - (middle + gap)).abs() < 1e-9, "{found:?}");
        }
    }
    // One that only comes close does not cross.
    let near = |t: f64| (t - 0.4).powi(2) + 1e-9;
    assert_eq!(crossings(OfTime(vec![(Crossing::Either, &near)]), 0.0, 1.0), []);
}

#[test]
fn functions_that_cross_at_one_instant_are_all_found_in_their_order() {
    let closing = |t: f64| 0.5 - t;
    let contacts = OfTime(vec![(Crossing::Falling, &closing); 12]);
    let expected: Vec<_> = (0..12).map(|i| (i, 0.5)).collect();
    assert_times(&crossings(contacts, 0.0, 1.0), &expected);
}

#[test]
fn a_function_that_starts_at_zero_crosses_only_when_it_returns() {
    let hop = |t: f64| t * (0.4 - t);
    let found = crossings(OfTime(vec![(Crossing::Either, &hop)]), 0.0, 1.0);
    assert_times(&found, &[(0, 0.4)]);
    // So early that only the first sample of a first step lies before it.
    let hop = |t: f64| t * (0.004 - t);
    let found = crossings(OfTime(vec![(Crossing::Either, &hop)]), 0.0, 1.0);
    assert_times(&found, &[(0, 0.004)]);
}

/// Heights that a ball passes.
struct Levels<'a>(&'a [f64]);

impl Events for Levels<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }
    fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) {
        out.iter_mut().zip(self.0).for_each(|(out, level)| *out = y[0] - level);
    }
}

#[test]
fn a_search_resumed_after_any_step_finds_the_same_crossings() {
    let start = Start { t: 0.0, y: vec![1.0, 0.0], ydot: vec![0.0; 2] };
    let mut solver =
        ExplicitSolver::new(Ball(uniform(2)), start.clone(), 50.0, settings(1e-9)).expect("valid");
    // They are passed in different steps.
    let levels = [0.9999, 0.5, 0.0, -100.0, -5000.0];
    let mut undisturbed = EventSearch::new(&mut Levels(&levels), &start);
    let mut resumed = undisturbed.clone();
    let mut n_found = 0;
    while let Some(step) = solver.step().expect("no failure") {
        let (values, is_first) = resumed.remembered();
        // Another search, begun elsewhere.
        let elsewhere = Start { t: 7.0, y: vec![-3.0, 2.0], ydot: vec![0.0; 2] };
        resumed = EventSearch::new(&mut Levels(&levels), &elsewhere);
        resumed.resume(&values, is_first).expect("the same functions");
        let found = resumed.crossings(&mut Levels(&levels), &step);
        assert_eq!(found, undisturbed.crossings(&mut Levels(&levels), &step));
        n_found += found.len();
    }
    assert_eq!(n_found, levels.len());

    let fewer = resumed.resume(&[0.0; 2], false);
    assert!(matches!(fewer, Err(SolveError::Checkpoint { .. })), "{fewer:?}");
}
