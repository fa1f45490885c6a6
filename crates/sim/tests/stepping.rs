//! A run that is held between two steps: it reaches given times, is sampled there, and goes on as if it
//! had not been held.

use bksim_dae::Control;
use bksim_sim::input::InputError;
use bksim_sim::run::{
    Observer, Problem, Replay, Run, Sample, Segment, StateSensitivity, StepOutcome, Summary, run,
};
use bksim_sim::{Mechanism, Stepping};

/// A ball that bounces on a stop, against air that is a load.
const BOUNCING: &str = r#"
[bodies.ball]
mass = "1 kg"

[joints.S]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
coordinate = "y"

[loads.floor]
type = "stop"
joint = "S"
min = 0
restitution = 0.7

[loads.field]
type = "force"
on = "ball"
vector = [0, "-9.81 N - 0.3 N s/m*S.velocity"]

[initial]
S = { position = "0.5 m" }

[solve]
t_end = "1 s"
every = "10 ms"
method = "METHOD"
"#;

/// A block on a rail, pulled by a force that is a parameter.
const PULLED: &str = include_str!("../../../tests/fixtures/pulled-block.toml");

/// Keeps samples, and the motion over the last step.
#[derive(Default)]
struct Kept {
    samples: Vec<Sample>,
    last: Segment,
}

impl Observer for Kept {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.samples.push(sample.clone());
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        self.last.clone_from(segment);
    }
}

/// The motion by each method.
fn check(with: &dyn Fn(Problem<'_>)) {
    for method in ["auto", "radau"] {
        let text = BOUNCING.replace("METHOD", method);
        let mechanism = Mechanism::from_toml(&text, "ball").expect("a model");
        let simulation = mechanism.simulation().expect("equations");
        let start = mechanism.start().expect("a start");
        with(simulation.problem(&start));
    }
}

fn whole(problem: Problem<'_>) -> (Vec<Sample>, Summary) {
    let mut kept = Kept::default();
    let summary = run(problem, &mut kept, &|| false).expect("a run");
    assert!(summary.reached_end && !summary.changes.is_empty(), "the ball bounces");
    (kept.samples, summary)
}

#[test]
fn a_run_that_is_held_has_the_same_samples() {
    check(&|problem| {
        let (samples, summary) = whole(problem);
        let mut kept = Kept::default();
        let mut run = Run::begin(problem, &mut kept);
        for k in 1..=20 {
            let t = 0.05 * f64::from(k);
            let outcome = run.advance_until(t, &mut kept, &|| false).expect("a step");
            assert_eq!(outcome, StepOutcome::Ongoing, "held at {t}");
            assert!(run.reached().t >= t, "{} against {t}", run.reached().t);
            // To be looked at, and saved, changes nothing.
            assert!(run.checkpoint().n_samples() > 0);
        }
        assert_eq!(run.step(&mut kept, &|| false), Ok(StepOutcome::Reached));
        assert_eq!(run.finish(&mut kept), summary);
        assert_eq!(kept.samples, samples);
    });
}

#[test]
fn a_checkpoint_of_a_held_run_continues_it() {
    check(&|problem| {
        let (samples, summary) = whole(problem);
        let mut kept = Kept::default();
        let mut run = Run::begin(problem, &mut kept);
        run.advance_until(0.4, &mut kept, &|| false).expect("steps");
        let saved = run.checkpoint();
        assert_eq!(saved.n_samples(), kept.samples.len() as u64);
        // The run that was held goes elsewhere meanwhile.
        run.advance_until(0.9, &mut Kept::default(), &|| false).expect("steps");

        let mut again = Run::resume(problem, &saved, &mut kept).expect("it fits");
        while again.step(&mut kept, &|| false).expect("a step") == StepOutcome::Ongoing {}
        assert_eq!(again.finish(&mut kept), summary);
        assert_eq!(kept.samples, samples);
    });
}

#[test]
fn a_replay_of_the_last_step_is_the_sample_at_the_time_asked_for() {
    check(&|problem| {
        let (samples, _) = whole(problem);
        let mut replay = Replay::new(problem.compiled, problem.parameters);
        let mut kept = Kept::default();
        let mut run = Run::begin(problem, &mut kept);
        for expected in samples.iter().skip(1) {
            run.advance_until(expected.t, &mut kept, &|| false).expect("steps");
            let found = replay.at(&kept.last, expected.t).expect("its motion");
            assert_eq!(found.t, expected.t);
            for (a, b) in [(&found.q, &expected.q), (&found.v, &expected.v)] {
                assert!((a[0] - b[0]).abs() < 1e-12, "{a:?} against {b:?} at {}", found.t);
            }
        }
    });
}

#[test]
fn a_stopped_run_takes_no_more_steps() {
    check(&|problem| {
        let mut kept = Kept::default();
        let mut run = Run::begin(problem, &mut kept);
        assert_eq!(run.step(&mut kept, &|| true), Ok(StepOutcome::Stopped));
        let reached = run.reached().clone();
        assert_eq!(run.step(&mut kept, &|| false), Ok(StepOutcome::Stopped));
        assert_eq!(*run.reached(), reached);
        let summary = run.finish(&mut kept);
        assert!(!summary.reached_end && summary.checkpoint.is_some());
    });
}

#[test]
fn a_run_can_be_handed_to_another_thread() {
    fn is_send<T: Send>() {}
    is_send::<Run<'_>>();
}

/// The ball again, with a parameter that only its weight depends on.
fn ball(method: &str, every: &str) -> Mechanism {
    let text = BOUNCING.replace("METHOD", method).replace("10 ms", every);
    let text =
        text.replace("-9.81 N", "-w").replace("[joints", "[parameters]\nw = \"9.81 N\"\n[joints");
    Mechanism::from_toml(&text, "ball").expect("a model")
}

#[test]
fn a_run_held_at_the_output_times_has_the_samples_of_one_that_is_not() {
    for method in ["auto", "radau"] {
        let simulation = ball(method, "10 ms").simulation().expect("equations");
        let motion = simulation.solve().expect("a motion");
        let mut run = simulation.begin().expect("a start");
        assert_eq!(*run.sample(), motion.samples[0]);
        for expected in motion.samples.iter().skip(1) {
            assert_eq!(run.advance_to(expected.t), Ok(expected), "by {method}");
            run.set_input("w", 9.81).expect("an input");
        }
        assert_eq!(run.summary().changes, motion.summary.changes);
    }
}

#[test]
fn holding_a_run_more_often_does_not_change_its_steps() {
    for method in ["auto", "radau"] {
        let simulation = ball(method, "10 ms").simulation().expect("equations");
        let [mut often, mut seldom] = [0; 2].map(|_| simulation.begin().expect("a start"));
        for k in 1..=1000 {
            often.advance_to(1e-3 * f64::from(k)).expect("a motion");
        }
        seldom.advance_to(1.0).expect("a motion");
        assert_eq!(often.state(), seldom.state());
        assert_eq!(often.sample().stats, seldom.sample().stats, "by {method}");
    }
}

#[test]
fn a_restored_run_goes_on_as_if_it_had_never_left() {
    for method in ["auto", "radau"] {
        let simulation = ball(method, "10 ms").simulation().expect("equations");
        let mut run = simulation.begin().expect("a start");
        let weight = |k: u32| 9.81 + 3.0 * f64::from(k / 7 % 3);
        let step = |run: &mut Stepping, k: u32| {
            run.set_input("w", weight(k)).expect("an input");
            run.advance_to(0.01 * f64::from(k)).expect("a motion").clone()
        };
        let mut saved = Vec::new();
        let samples: Vec<Sample> = (1..=90)
            .map(|k| {
                saved.push(run.save());
                step(&mut run, k)
            })
            .collect();
        assert!(run.summary().changes.len() >= 2, "the ball bounces");

        // From each of them, in an order that has nothing to do with the run's; from some as another process has it,
        // which has the bytes and the start.
        let start = simulation.start().expect("a start");
        for begin in [60, 3, 31, 44, 0] {
            let again = simulation.saved_state(&start, &saved[begin].to_bytes()).expect("a state");
            run.restore(if begin % 2 == 0 { &again } else { &saved[begin] }).expect("a state");
            for k in begin..samples.len() {
                let number = u32::try_from(k + 1).expect("a small one");
                assert_eq!(step(&mut run, number), samples[k], "from {begin} on, by {method}");
            }
        }
    }
}

#[test]
fn bytes_that_are_no_state_are_refused() {
    let simulation = ball("auto", "10 ms").simulation().expect("equations");
    let start = simulation.start().expect("a start");
    let mut run = simulation.begin().expect("a start");
    run.set_input("w", 8.0).expect("an input");
    run.advance_to(0.5).expect("a motion");
    let bytes = run.save().to_bytes();
    assert!(simulation.saved_state(&start, &bytes).is_ok());
    for n in [0, 7, 8, 100, bytes.len() - 8] {
        assert!(simulation.saved_state(&start, &bytes[..n]).is_err(), "{n} bytes");
    }
    // Whatever a word is turned into, the answer is a state or an error.
    for word in 0..bytes.len() / 8 {
        let mut damaged = bytes.clone();
        damaged[8 * word..8 * word + 8].fill(0xff);
        let _ = simulation.saved_state(&start, &damaged);
    }
    let other =
        Mechanism::from_toml(PULLED, "block").expect("a model").simulation().expect("equations");
    let at = other.start().expect("a start");
    assert!(other.saved_state(&at, &bytes).is_err(), "of another mechanism");
}

#[test]
fn an_input_acts_from_the_instant_on_at_which_it_is_set() {
    for method in ["explicit", "radau"] {
        let mechanism = Mechanism::from_toml(&format!("{PULLED}method = \"{method}\"\n"), "block");
        let mut run =
            mechanism.expect("a model").simulation().expect("equations").begin().expect("a start");
        let (mut x, mut v, mut work) = (0.0, 0.0, 0.0);
        for k in 1..=50 {
            let force = if k % 2 == 0 { 3.0 } else { -1.0 };
            run.set_input("u", force).expect("an input");
            let found = run.advance_to(0.02 * f64::from(k)).expect("a motion").clone();
            let step = v * 0.02 + 0.5 * (force / 2.0) * 0.02_f64.powi(2);
            (x, v, work) = (x + step, v + force / 2.0 * 0.02, work + force * step);
            let pairs =
                [(found.q[0], x), (found.v[0], v), (found.work, work), (found.a[0], force / 2.0)];
            for (found, expected) in pairs {
                assert!((found - expected).abs() < 1e-13, "{found} against {expected} by {method}");
            }
        }
        let error = run.summary().energy.worst_error;
        assert!(error < 1e-13, "the balance is off by {error} J");
    }
}

#[test]
fn friction_lets_go_when_an_input_pulls_harder() {
    let text = format!(
        "{PULLED}\n[loads.floor]\ntype = \"friction\"\njoint = \"rail\"\nforce = \"4 N\"\n"
    );
    let text = text.replace("1 s", "10 s").replace("3 N", "1 N");
    let mechanism = Mechanism::from_toml(&text, "block").expect("a model");
    let mut run = mechanism.simulation().expect("equations").begin().expect("a start");
    run.advance_to(1.0).expect("it sticks");
    assert_eq!(run.state().v[0], 0.0);
    run.set_input("u", 10.0).expect("an input");
    run.advance_to(2.0).expect("it slides");
    assert!((run.state().v[0] - 3.0).abs() < 1e-9, "{:?}", run.state());
    run.set_input("u", 0.0).expect("an input");
    run.advance_to(9.0).expect("it comes to rest");
    // 1.5 m with the pull, then 3²/(2·2) m.
    assert_eq!(run.state().v[0], 0.0);
    assert!((run.state().q[0] - 3.75).abs() < 1e-8, "{:?}", run.state());
}

#[test]
fn what_cannot_be_set_or_reached_is_refused() {
    let text = BOUNCING.replace("METHOD", "auto").replace("\"1 kg\"", "\"m\"");
    let text = text.replace("[joints", "[parameters]\nm = \"1 kg\"\nw = 2\n[joints");
    let simulation = Mechanism::from_toml(&text, "ball").expect("a model").simulation();
    let mut run = simulation.expect("equations").begin().expect("a start");
    let refused = |fault: Result<(), InputError>| fault.expect_err("no input").to_string();
    assert_eq!(refused(run.set_input("k", 1.0)), "no parameter is called `k`");
    assert_eq!(
        refused(run.set_input("m", 1.0)),
        "`m` cannot be an input: the kinetic energy depends on it, not the loads alone"
    );
    assert_eq!(refused(run.set_input("w", f64::NAN)), "the input `w` must be a number, not NaN");
    run.advance_to(0.5).expect("a motion");
    for t in [0.4, 1.1, f64::NAN] {
        let fault = run.advance_to(t).expect_err("not ahead").to_string();
        let end = "lies outside of what is left of the run, 0.5 s to 1 s";
        assert!(fault.ends_with(end), "{fault}");
    }
    assert_eq!(run.t(), 0.5);
}
