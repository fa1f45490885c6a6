//! Runs by series against those of Dormand and Prince.

use crate::dense::Step;
use crate::explicit::straight_line::Eager;
use crate::explicit::{ExplicitSolver, N_SERIES_VECTORS, record_series_end, solve_ode};
use crate::run::{Control, Start};
use crate::settings::{ExplicitMethod, Settings, StepControl, Tolerance};
use crate::system::{Index, Layout, NotFinite, Ode, StepSpan};

/// `x″ = −x³`, with its series or without, and with whole steps by it or without.
struct Duffing {
    layout: Layout,
    has_series: bool,
    has_whole_steps: bool,
    n_series: usize,
    order: usize,
}

impl Duffing {
    fn new(has_series: bool) -> Self {
        let layout = Layout::from_groups(&[(2, Index::One)]);
        Self { layout, has_series, has_whole_steps: false, n_series: 0, order: 0 }
    }
}

impl Ode for Duffing {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn derivative(&mut self, _: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        (ydot[0], ydot[1]) = (y[1], -y[0].powi(3));
        Ok(())
    }

    fn series(&mut self, _: f64, y: &[f64], order: usize, results: &mut Vec<f64>) -> bool {
        self.n_series += 1;
        self.order = order;
        let (mut x, mut square, mut v) = (vec![y[0]], Vec::new(), vec![y[1]]);
        for k in 0..order {
            let product = |a: &[f64], b: &[f64]| (0..=k).map(|i| a[i] * b[k - i]).sum::<f64>();
            square.push(product(&x, &x));
            let cube = product(&x, &square);
            let part = 1.0 / (k + 1) as f64;
            x.push(part * v[k]);
            v.push(-part * cube);
            (results[2 * k], results[2 * k + 1]) = (x[k + 1], v[k + 1]);
        }
        self.has_series
    }

    /// As if something vanished two seconds ahead.
    fn series_holds(&self, h: f64, _: &[f64]) -> bool {
        h.abs() < 2.0
    }

    fn series_step(
        &mut self,
        StepSpan { h, t1, .. }: StepSpan,
        y: &[f64],
        begin: &mut [f64],
        end: &mut Vec<f64>,
    ) -> bool {
        if !self.has_whole_steps {
            return false;
        }
        let mut by_series = |i: usize| {
            let own = (0..self.order).map(|k| begin[2 * k + i]);
            record_series_end(&mut Eager, h, y[i], own)
        };
        let [x, v] = [0, 1].map(&mut by_series);
        let mut slopes = [[0.0; 2]; 2];
        for (slope, at) in slopes.iter_mut().zip([[x[0], v[0]], [x[1], v[1]]]) {
            self.derivative(t1, &at, slope).expect("a slope everywhere");
        }
        end.resize((self.order + N_SERIES_VECTORS) * 2, 0.0);
        self.series(t1, &[x[1], v[1]], self.order, end);
        let [near_slope, slope] = slopes;
        let vectors = [[x[0], v[0]], near_slope, [x[1], v[1]], [x[2], v[2]], [x[1], v[1]], slope];
        end[2 * self.order..].copy_from_slice(vectors.as_flattened());
        true
    }
}

fn by_series(order: usize, rtol: f64) -> Settings {
    Settings {
        explicit: ExplicitMethod::Taylor { order },
        rtol,
        atol: Tolerance::Scalar(rtol),
        ..Settings::default()
    }
}

fn from_rest() -> Start {
    Start { t: 0.0, y: vec![1.0, 0.0], ydot: vec![0.0; 2] }
}

#[test]
fn series_are_exact_to_the_tolerance_at_the_ends_of_steps_and_between_them() {
    for (rtol, order, t_end) in [(1e-6, 10, 30.0), (1e-9, 14, -30.0), (1e-12, 20, 30.0)] {
        let exact = |t: f64| {
            let settings = Settings { explicit: ExplicitMethod::default(), ..by_series(4, 1e-14) };
            let mut keep = |_: &Step<'_>| Control::Continue;
            solve_ode(Duffing::new(false), from_rest(), t, settings, &mut keep).expect("it runs").y
        };
        let (mut n_steps, mut worst) = (0, 0.0f64);
        let mut energies = Vec::new();
        let mut observe = |step: &Step<'_>| {
            n_steps += 1;
            assert!(step.h().abs() < 2.0, "what must not vanish does not");
            let mut y = [0.0; 2];
            for part in [0.21, 0.55, 0.87] {
                step.at(step.t0() + part * step.h(), &mut y);
                energies.push(0.5 * y[1] * y[1] + 0.25 * y[0].powi(4));
                let mut slope = [0.0; 2];
                step.derivative_at(step.t0() + part * step.h(), &mut slope);
                worst = worst.max((slope[0] - y[1]).abs());
            }
            Control::Continue
        };
        let mut system = Duffing::new(true);
        let settings = by_series(order, rtol);
        let end = solve_ode(&mut system, from_rest(), t_end, settings, &mut observe);
        let end = end.expect("it runs");
        let error = end.y.iter().zip(exact(t_end)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 60.0 * rtol, "{error:e} at {rtol:e}");
        let drift = energies.iter().map(|energy| (energy - 0.25).abs()).fold(0.0, f64::max);
        assert!(drift < 60.0 * rtol && worst < 60.0 * rtol, "{drift:e}, {worst:e} at {rtol:e}");
        assert_eq!((end.stats.n_reject, system.n_series), (0, n_steps + 1));
    }
}

#[test]
fn whole_steps_give_the_bits_of_their_parts() {
    let run = |has_whole_steps: bool| {
        let mut middles = Vec::new();
        let mut observe = |step: &Step<'_>| {
            let mut y = [0.0; 2];
            step.at(0.5 * (step.t0() + step.t1()), &mut y);
            let ends = [step.t1(), step.y1()[0], step.ydot1()[1], y[0], y[1]];
            middles.push(ends.map(f64::to_bits));
            Control::Continue
        };
        let system = Duffing { has_whole_steps, ..Duffing::new(true) };
        let outcome = solve_ode(system, from_rest(), 20.0, by_series(14, 1e-9), &mut observe);
        (middles, outcome.expect("it runs").stats)
    };
    assert_eq!(run(true), run(false));
}

/// Of `x″ = −x³` from the origin, every fourth coefficient alone is not zero.
#[test]
fn series_with_gaps_have_steps_as_others_have() {
    for order in 8..=16 {
        let mut longest = 0.0f64;
        let mut observe = |step: &Step<'_>| {
            longest = longest.max(step.h());
            Control::Stop
        };
        let start = Start { t: 0.0, y: vec![0.0, 0.5], ydot: vec![0.0; 2] };
        let settings = by_series(order, 1e-8);
        solve_ode(Duffing::new(true), start, 20.0, settings, &mut observe).expect("it runs");
        assert!(longest < 1.9, "order {order}: a first step of {longest} s");
    }
}

#[test]
fn steps_without_a_series_are_those_of_dormand_and_prince() {
    let run = |settings: Settings, has_series: bool| {
        let mut ends = Vec::new();
        let mut observe = |step: &Step<'_>| {
            ends.push((step.t1().to_bits(), step.y1()[0].to_bits()));
            Control::Continue
        };
        let system = Duffing::new(has_series);
        solve_ode(system, from_rest(), 20.0, settings, &mut observe).expect("it runs");
        ends
    };
    let plain = Settings { explicit: ExplicitMethod::default(), ..by_series(4, 1e-9) };
    assert_eq!(run(by_series(14, 1e-9), false), run(plain, false));
    assert_ne!(run(by_series(14, 1e-9), true), run(by_series(14, 1e-9), false));
}

#[test]
fn a_run_by_series_goes_on_where_it_was_saved() {
    let new = || ExplicitSolver::new(Duffing::new(true), from_rest(), 20.0, by_series(14, 1e-9));
    let finish = |solver: &mut ExplicitSolver<Duffing>| {
        let mut trace = Vec::new();
        while solver.advance().expect("no failure") {
            trace.push((solver.t().to_bits(), solver.y()[0].to_bits()));
        }
        trace
    };
    let undisturbed = finish(&mut new().expect("valid"));
    for after in [0, 1, undisturbed.len() / 2] {
        let mut solver = new().expect("valid");
        for _ in 0..after {
            solver.advance().expect("no failure");
        }
        let resumed =
            ExplicitSolver::resume(Duffing::new(true), &solver.save(), 20.0, by_series(14, 1e-9));
        assert_eq!(finish(&mut resumed.expect("it fits")), undisturbed[after..]);
    }
}

#[test]
fn steps_of_constant_size_are_taken_by_the_series_of_their_own_starts() {
    for has_whole_steps in [false, true] {
        let settings = |explicit: ExplicitMethod| Settings {
            explicit,
            step: StepControl::Fixed { h: 0.1, newton_tolerance: 1e-12 },
            ..Settings::default()
        };
        let run = |explicit: ExplicitMethod| {
            let system = Duffing { has_whole_steps, ..Duffing::new(true) };
            let mut keep = |_: &Step<'_>| Control::Continue;
            solve_ode(system, from_rest(), 2.0, settings(explicit), &mut keep).expect("it runs").y
        };
        let (series, stages) =
            (run(ExplicitMethod::Taylor { order: 14 }), run(ExplicitMethod::DormandPrince));
        let gaps = series.iter().zip(stages).map(|(a, b)| (a - b).abs());
        let gap = gaps.fold(0.0, f64::max);
        assert!(gap < 1e-9, "{gap:e}, whole steps: {has_whole_steps}");
    }
}
