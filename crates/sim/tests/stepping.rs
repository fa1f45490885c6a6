//! A run that is held between two steps: it reaches given times, is sampled there, and goes on as if it
//! had not been held.

use bksim_dae::Control;
use bksim_sim::Mechanism;
use bksim_sim::run::{
    Observer, Problem, Replay, Run, Sample, Segment, StateSensitivity, StepOutcome, Summary, run,
};

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
            assert!(run.checkpoint().is_some());
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
        let saved = run.checkpoint().expect("a checkpoint");
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
