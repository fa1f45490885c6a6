//! Events: times against closed forms, order, double roots, restarts, chatter, both methods.

mod common;

use bksim_dae::{
    Action, Chatter, ChatterSettings, Checkpoint, Control, Crossing, Event, EventMemory,
    EventOutcome, Events, ExplicitSolver, Integrator, Layout, NotFinite, Ode, Settings, SolveError,
    Solver, Start, Step, Tolerance, continue_events, solve_events,
};

use common::dual::Real;
use common::{Differentiated, Residual, uniform};

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

/// Bounces on the ground with restitution `e`, and notes when.
struct Ground {
    e: f64,
    impacts: Vec<f64>,
    chatter: Option<Chatter>,
    rests: bool,
}

impl Ground {
    fn new(e: f64) -> Self {
        Self { e, impacts: Vec::new(), chatter: None, rests: false }
    }
}

impl Events for Ground {
    fn count(&self) -> usize {
        1
    }
    fn crossing(&self, _i: usize) -> Crossing {
        Crossing::Falling
    }
    fn name(&self, _i: usize) -> String {
        "ground".into()
    }
    fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) {
        out[0] = y[0];
    }
    fn handle(&mut self, event: &Event, state: &mut Start) -> Action {
        self.impacts.push(event.t);
        state.y[0] = 0.0;
        state.y[1] *= -self.e;
        state.ydot = vec![state.y[1], -G];
        Action::Restart
    }
    fn accumulate(&mut self, chatter: &Chatter, _state: &mut Start) -> Option<Action> {
        self.chatter = Some(*chatter);
        self.rests.then_some(Action::Stop)
    }
}

fn settings(tolerance: f64) -> Settings {
    Settings { rtol: tolerance, atol: Tolerance::Scalar(tolerance), ..Settings::default() }
}

fn dropped() -> Start {
    Start { t: 0.0, y: vec![1.0, 0.0], ydot: vec![0.0, -G] }
}

fn bounce(
    integrator: &mut impl Integrator,
    ground: &mut Ground,
) -> Result<EventOutcome, SolveError> {
    let mut last = 0.0;
    solve_events(integrator, ground, ChatterSettings::default(), &mut |step| {
        assert_eq!(step.t0(), last, "steps follow each other");
        assert!(step.y1()[0] > -1e-12, "below the ground at {}: {}", step.t1(), step.y1()[0]);
        last = step.t1();
        Control::Continue
    })
}

/// Times of the impacts of a ball dropped from height one.
fn impacts(e: f64, count: i32) -> Vec<f64> {
    let first = (2.0 / G).sqrt();
    // t_k = t_1 (1 + 2 e + 2 e² + …).
    (0..count).map(|k| first * (1.0 + (1..=k).map(|j| 2.0 * e.powi(j)).sum::<f64>())).collect()
}

#[test]
fn a_ball_bounces_at_the_times_of_the_closed_form_with_both_methods() {
    let check = |name: &str, outcome: EventOutcome, ground: &Ground| {
        let expected = impacts(0.8, 6);
        assert_eq!(ground.impacts.len(), 6, "{name}: {:?}", ground.impacts);
        assert_eq!(outcome.n_events, 6);
        for (found, exact) in ground.impacts.iter().zip(expected) {
            assert!((found - exact).abs() < 1e-11, "{name}: impact at {found}, exact {exact}");
        }
        assert_eq!(outcome.outcome.t, 3.0);
    };
    let mut ground = Ground::new(0.8);
    let mut solver =
        ExplicitSolver::new(Ball(uniform(2)), dropped(), 3.0, settings(1e-10)).expect("valid");
    let outcome = bounce(&mut solver, &mut ground).expect("the run ends");
    check("explicit", outcome, &ground);

    let mut ground = Ground::new(0.8);
    let system = Differentiated::dense(Ball(uniform(2)));
    let mut solver = Solver::new(system, dropped(), 3.0, settings(1e-10)).expect("valid");
    let outcome = bounce(&mut solver, &mut ground).expect("the run ends");
    check("Radau", outcome, &ground);
}

#[test]
fn bounces_that_accumulate_are_recognised_and_their_limit_is_named() {
    let run = |rests| {
        let mut ground = Ground { rests, ..Ground::new(0.5) };
        let mut solver =
            ExplicitSolver::new(Ball(uniform(2)), dropped(), 3.0, settings(1e-10)).expect("valid");
        (bounce(&mut solver, &mut ground), ground)
    };
    let limit = 3.0 * (2.0 / G).sqrt();
    let (result, _) = run(false);
    let error = result.expect_err("the bounces accumulate");
    let SolveError::Chatter { names, t, chatter } = &error else { panic!("{error}") };
    assert_eq!((names[0].as_str(), chatter.i), ("ground", 0));
    assert!((t - limit).abs() < 1e-5 && *t < limit, "stopped at {t}, limit {limit}");
    let found = chatter.limit.expect("a geometric series");
    assert!((found - limit).abs() < 1e-9, "limit {found}, exact {limit}");
    assert!(error.advice().is_some());

    // The handler may also take over.
    let (result, ground) = run(true);
    let outcome = result.expect("the run ends at rest");
    assert_eq!(outcome.terminal.map(|event| event.i), Some(0));
    assert!(ground.chatter.is_some() && ground.impacts.len() > 20, "{:?}", ground.impacts.len());
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

/// Functions of the clock, noted as they fire.
struct Watch<'a> {
    functions: Vec<(Crossing, &'a dyn Fn(f64) -> f64)>,
    fired: Vec<Event>,
    stop_at: Option<usize>,
}

impl<'a> Watch<'a> {
    fn new(functions: Vec<(Crossing, &'a dyn Fn(f64) -> f64)>) -> Self {
        Self { functions, fired: Vec::new(), stop_at: None }
    }

    fn run(&mut self, from: f64, to: f64) -> EventOutcome {
        let start = Start { t: from, y: vec![from], ydot: vec![1.0] };
        let settings = Settings { h_initial: Some(1.0), ..settings(1e-9) };
        let mut clock = ExplicitSolver::new(Clock(uniform(1)), start, to, settings).expect("valid");
        solve_events(&mut clock, self, ChatterSettings::default(), &mut |_| Control::Continue)
            .expect("the run ends")
    }

    fn times(&self) -> Vec<(usize, f64)> {
        self.fired.iter().map(|event| (event.i, event.t)).collect()
    }
}

impl Events for Watch<'_> {
    fn count(&self) -> usize {
        self.functions.len()
    }
    fn crossing(&self, i: usize) -> Crossing {
        self.functions[i].0
    }
    fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) {
        for (out, (_, g)) in out.iter_mut().zip(&self.functions) {
            *out = g(y[0]);
        }
    }
    fn handle(&mut self, event: &Event, _state: &mut Start) -> Action {
        self.fired.push(*event);
        if self.stop_at == Some(event.i) { Action::Stop } else { Action::Continue }
    }
}

fn assert_times(found: &[(usize, f64)], expected: &[(usize, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}, expected {expected:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.0, expected.0, "order of {found:?} and {expected:?}");
        assert!((found.1 - expected.1).abs() < 1e-14, "{found:?}, expected {expected:?}");
    }
}

#[test]
fn several_events_in_a_step_come_in_order_and_in_their_direction() {
    let late = |t: f64| t - 0.7;
    let early = |t: f64| 0.2 - t;
    let wave = |t: f64| (t - 0.3) * (t - 0.6);
    let all = || -> Vec<(Crossing, &dyn Fn(f64) -> f64)> {
        vec![(Crossing::Rising, &late), (Crossing::Falling, &early), (Crossing::Either, &wave)]
    };
    let mut watch = Watch::new(all());
    watch.run(0.0, 1.0);
    assert_times(&watch.times(), &[(1, 0.2), (2, 0.3), (2, 0.6), (0, 0.7)]);
    let crossings: Vec<_> = watch.fired.iter().map(|event| event.crossing).collect();
    let (falling, rising) = (Crossing::Falling, Crossing::Rising);
    assert_eq!(crossings, [falling, falling, rising, rising]);

    // Backwards, directions are those met on the way.
    let mut watch = Watch::new(all());
    watch.run(1.0, 0.0);
    assert_times(&watch.times(), &[(2, 0.6), (2, 0.3)]);

    let mut watch = Watch::new(all());
    watch.stop_at = Some(2);
    let end = watch.run(0.0, 1.0);
    assert!((end.outcome.t - 0.3).abs() < 1e-14 && end.terminal.is_some(), "{end:?}");
    assert!((end.outcome.y[0] - 0.3).abs() < 1e-14, "{end:?}");
}

#[test]
fn two_crossings_close_together_are_not_missed() {
    for gap in [1e-1, 1e-3, 1e-6] {
        for middle in [0.06, 0.31, 0.5, 0.77, 0.94] {
            let gap = gap * 0.5;
            let dip = move |t: f64| (t - middle).powi(2) - gap * gap;
            let mut watch = Watch::new(vec![(Crossing::Either, &dip)]);
            watch.run(0.0, 1.0);
            let found = watch.times();
            assert_eq!(found.len(), 2, "gap {gap}, middle {middle}: {found:?}");
            assert!((found[0].1 - (middle - gap)).abs() < 1e-9, "{found:?}");
            assert!((found[1].1 - (middle + gap)).abs() < 1e-9, "{found:?}");
        }
    }
    // One that only comes close does not cross.
    let near = |t: f64| (t - 0.4).powi(2) + 1e-9;
    let mut watch = Watch::new(vec![(Crossing::Either, &near)]);
    watch.run(0.0, 1.0);
    assert_eq!(watch.times(), []);
}

/// `y′ = −sign(y)`, thrown over by its own event: it slides along zero.
struct Relay {
    layout: Layout,
    sign: std::rc::Rc<std::cell::Cell<f64>>,
}

impl Ode for Relay {
    fn layout(&self) -> &Layout {
        &self.layout
    }
    fn derivative(&mut self, _t: f64, _y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        ydot[0] = -self.sign.get();
        Ok(())
    }
}

struct Switch(std::rc::Rc<std::cell::Cell<f64>>);

impl Events for Switch {
    fn count(&self) -> usize {
        1
    }
    fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) {
        // A little hysteresis, so that the relay overshoots.
        out[0] = y[0] + 1e-9 * self.0.get();
    }
    fn handle(&mut self, _event: &Event, _state: &mut Start) -> Action {
        self.0.set(-self.0.get());
        Action::Restart
    }
}

#[test]
fn a_switch_thrown_forth_and_back_is_recognised() {
    let sign = std::rc::Rc::new(std::cell::Cell::new(1.0));
    let relay = Relay { layout: uniform(1), sign: std::rc::Rc::clone(&sign) };
    let start = Start { t: 0.0, y: vec![1.0], ydot: vec![-1.0] };
    let mut solver = ExplicitSolver::new(relay, start, 5.0, settings(1e-8)).expect("valid");
    let error =
        solve_events(&mut solver, &mut Switch(sign), ChatterSettings::default(), &mut |_| {
            Control::Continue
        })
        .expect_err("the relay chatters at t = 1");
    let SolveError::Chatter { t, chatter, .. } = &error else { panic!("{error}") };
    assert!((t - 1.0).abs() < 1e-6, "{error}");
    assert_eq!(chatter.limit, None, "the intervals do not shrink");
}

/// The relay of two functions that throw each other: one looks at each side.
struct TwoSwitches(std::rc::Rc<std::cell::Cell<f64>>);

impl Events for TwoSwitches {
    fn count(&self) -> usize {
        2
    }
    fn crossing(&self, i: usize) -> Crossing {
        if i == 0 { Crossing::Falling } else { Crossing::Rising }
    }
    fn name(&self, i: usize) -> String {
        ["lower", "upper"][i].into()
    }
    fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) {
        (out[0], out[1]) = (y[0] + 1e-9, y[0] - 1e-9);
    }
    fn handle(&mut self, event: &Event, _state: &mut Start) -> Action {
        self.0.set(if event.i == 0 { -1.0 } else { 1.0 });
        Action::Restart
    }
}

#[test]
fn two_switches_that_throw_each_other_are_recognised_by_name() {
    let sign = std::rc::Rc::new(std::cell::Cell::new(1.0));
    let relay = Relay { layout: uniform(1), sign: std::rc::Rc::clone(&sign) };
    let start = Start { t: 0.0, y: vec![1.0], ydot: vec![-1.0] };
    let mut solver = ExplicitSolver::new(relay, start, 5.0, settings(1e-8)).expect("valid");
    let mut events = TwoSwitches(sign);
    let error = solve_events(&mut solver, &mut events, ChatterSettings::default(), &mut |_| {
        Control::Continue
    })
    .expect_err("the relay chatters at t = 1");
    let SolveError::Chatter { t, chatter, names } = &error else { panic!("{error}") };
    assert!((t - 1.0).abs() < 1e-6, "{error}");
    assert_eq!((chatter.with.is_some(), names.len()), (true, 2), "{error}");
    assert!(error.to_string().contains("` and `"), "{error}");
}

/// Twelve contacts that close at one instant and are heard one after the other.
struct Together;

impl Events for Together {
    fn count(&self) -> usize {
        12
    }
    fn values(&mut self, t: f64, _y: &[f64], out: &mut [f64]) {
        out.fill(t - 0.5);
    }
    fn handle(&mut self, _event: &Event, _state: &mut Start) -> Action {
        Action::Restart
    }
}

#[test]
fn many_functions_at_one_instant_are_no_chatter() {
    let start = Start { t: 0.0, y: vec![0.0], ydot: vec![1.0] };
    let mut clock = ExplicitSolver::new(Clock(uniform(1)), start, 1.0, settings(1e-8)).expect("ok");
    let end = solve_events(&mut clock, &mut Together, ChatterSettings::default(), &mut |_| {
        Control::Continue
    })
    .expect("the run ends");
    assert_eq!((end.outcome.t, end.n_events), (1.0, 12));
}

/// A ball that loses a third of its speed at each impact and comes to rest after the last.
#[derive(Clone)]
struct Bounces {
    times: Vec<f64>,
    limit: Option<f64>,
}

impl Events for Bounces {
    fn count(&self) -> usize {
        1
    }
    fn crossing(&self, _i: usize) -> Crossing {
        Crossing::Falling
    }
    fn values(&mut self, _t: f64, y: &[f64], out: &mut [f64]) {
        out[0] = y[0];
    }
    fn handle(&mut self, event: &Event, state: &mut Start) -> Action {
        self.times.push(event.t);
        state.y[0] = 0.0;
        state.y[1] *= -2.0 / 3.0;
        Action::Restart
    }
    fn accumulate(&mut self, chatter: &Chatter, _state: &mut Start) -> Option<Action> {
        self.limit = chatter.limit;
        Some(Action::Stop)
    }
}

struct Fall(Layout);

impl Ode for Fall {
    fn layout(&self) -> &Layout {
        &self.0
    }
    fn derivative(&mut self, _t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        ydot.copy_from_slice(&[y[1], -10.0]);
        Ok(())
    }
}

#[test]
fn a_run_with_events_resumed_at_any_step_equals_the_undisturbed_one() {
    let settings = settings(1e-9);
    let chatter = ChatterSettings { count: 6, interval: None };
    let new = || {
        let start = Start { t: 0.0, y: vec![1.0, 0.0], ydot: vec![0.0; 2] };
        ExplicitSolver::new(Fall(uniform(2)), start, 50.0, settings.clone()).expect("valid")
    };
    let fresh = || Bounces { times: Vec::new(), limit: None };

    let mut events = fresh();
    let mut n_steps = 0;
    let whole = solve_events(&mut new(), &mut events, chatter, &mut |_| {
        n_steps += 1;
        Control::Continue
    })
    .expect("it comes to rest");
    // Falls for √0.2 s, then bounces that sum up to four times as long.
    let rest = 5.0 * 0.2f64.sqrt();
    let limit = events.limit.expect("the intervals shrink");
    assert!((limit - rest).abs() < 1e-6, "comes to rest at {limit}, exactly {rest}");

    // Saved as bytes and resumed after every single step, by another solver each time.
    let mut solver = new();
    let mut memory = EventMemory::default();
    let mut resumed = fresh();
    let mut n_events = 0;
    let end = loop {
        let stop = &mut |_: &Step<'_>| Control::Stop;
        let end = continue_events(&mut solver, &mut resumed, chatter, &mut memory, stop)
            .expect("it comes to rest");
        n_events += end.n_events;
        if end.terminal.is_some() {
            break end;
        }
        let bytes = memory.save_with(solver.save()).to_bytes();
        let saved = Checkpoint::from_bytes(&bytes).expect("its own bytes");
        memory = EventMemory::of(&saved).expect("it holds them");
        solver = ExplicitSolver::resume(Fall(uniform(2)), &saved, 50.0, settings.clone())
            .expect("it fits");
    };
    assert!(n_steps > 20, "{n_steps} steps");
    assert_eq!(resumed.times, events.times);
    assert_eq!(resumed.limit, events.limit);
    assert_eq!((end.outcome.t, end.outcome.y), (whole.outcome.t, whole.outcome.y));
    assert_eq!(n_events, whole.n_events);

    assert!(EventMemory::of(&new().save()).is_err(), "a checkpoint without events");
}
