//! Extrapolation in lanes and Taylor series: chosen where they need less work, and as exact as asked for.

use bksim_dae::{Control, ExplicitMethod};
use bksim_sim::Mechanism;
use bksim_sim::run::{Sample, Summary, explicit_method};

/// An example with other options at the end of its text.
fn mechanism(folder: &str, solve: &str) -> Mechanism {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let path = format!("{root}/{folder}");
    let text = std::fs::read_to_string(path).expect("a model");
    let (before, _) = text.split_once("[solve]").expect("options");
    Mechanism::from_toml(&format!("{before}[solve]\n{solve}\n"), "example").expect("a model")
}

/// The last sample and the summary of a run.
fn run(mechanism: &Mechanism) -> (Sample, Summary) {
    let (start, simulation) =
        (mechanism.start().expect("a start"), mechanism.simulation().expect("equations"));
    let mut last = Sample::default();
    let mut keep = |sample: &Sample| {
        last.clone_from(sample);
        Control::Continue
    };
    let summary = simulation.run(&start, &mut keep, &|| false).expect("the run ends");
    (last, summary)
}

const PENDULUM: (&str, &str) = ("crates/bench/models/pendulum.toml", "t_end = 10");

const CAR_AXIS: (&str, &str) = ("crates/bench/models/caraxis.toml", "t_end = 3");

/// Of more operations.
const LARGER: [(&str, &str); 2] = [
    ("crates/bench/models/andrews.toml", "t_end = 0.03"),
    ("crates/bench/models/slidercrank.toml", "t_end = 1"),
];

fn method(mechanism: &Mechanism) -> ExplicitMethod {
    explicit_method(&mechanism.compiled, &mechanism.model.solve)
}

/// The largest difference from a run at the tightest tolerance, of coordinates beyond one in parts of them.
fn error((model, t_end): (&str, &str), found: &Sample) -> f64 {
    let tight = t_end.to_owned() + "\nrtol = 1e-12\natol = 1e-12\nmethod = \"explicit\"";
    let (exact, _) = run(&mechanism(model, &(tight + "\nevery = 100")));
    let gaps = found.q.iter().zip(&exact.q).map(|(a, b)| (a - b).abs() / b.abs().max(1.0));
    gaps.fold(0.0, f64::max)
}

#[test]
fn few_outputs_are_extrapolated_to_as_many_digits_as_dormand_and_prince_give_in_more_evaluations() {
    let (model, t_end) = CAR_AXIS;
    for exponent in [8, 10] {
        let options = format!("{t_end}\nrtol = 1e-{exponent}\natol = 1e-{exponent}\n");
        let few = mechanism(model, &format!("{options}every = 100"));
        assert!(matches!(method(&few), ExplicitMethod::Extrapolation { .. }), "1e-{exponent}");
        let plain = mechanism(model, &format!("{options}every = 100\nmethod = \"explicit\""));
        let ((found, summary), (_, other)) = (run(&few), run(&plain));
        let (wanted, error) = (10f64.powi(-exponent), error(CAR_AXIS, &found));
        assert!(error < wanted, "{wanted:e}: {error:e}");
        // Four evaluations at once, and one at the end of each step.
        let in_sequence = summary.stats.n_residual as f64 / 4.0;
        let saved = in_sequence / other.stats.n_residual as f64;
        assert!(saved < 0.8, "{wanted:e}: {saved:.2}");
    }
}

#[test]
fn equations_of_many_operations_are_solved_by_whole_steps_at_any_accuracy() {
    for (model, t_end) in LARGER {
        let options = format!("{t_end}\nrtol = 1e-9\natol = 1e-9\nevery = 100");
        assert_eq!(method(&mechanism(model, &options)), ExplicitMethod::DormandPrince, "{model}");
    }
}

#[test]
fn equations_of_few_operations_are_solved_by_series_in_fewer_steps() {
    let (model, t_end) = PENDULUM;
    // At loose tolerances the stages of few steps are less work.
    let loose = mechanism(model, &format!("{t_end}\nrtol = 1e-4\natol = 1e-4\nevery = 0.001"));
    assert_eq!(method(&loose), ExplicitMethod::DormandPrince);
    for exponent in [6, 8, 10] {
        let options = format!("{t_end}\nrtol = 1e-{exponent}\natol = 1e-{exponent}\n");
        // However many outputs there are.
        let dense = mechanism(model, &format!("{options}every = 0.001"));
        assert!(matches!(method(&dense), ExplicitMethod::Taylor { .. }), "1e-{exponent}");
        let plain = mechanism(model, &format!("{options}every = 0.001\nmethod = \"explicit\""));
        assert_eq!(method(&plain), ExplicitMethod::DormandPrince);
        let ((found, summary), (_, other)) = (run(&dense), run(&plain));
        let (wanted, error) = (10f64.powi(-exponent), error(PENDULUM, &found));
        assert!(error < wanted, "{wanted:e}: {error:e}");
        let n_steps = [summary.stats.n_step, other.stats.n_step];
        assert!(n_steps[0] * 4 < n_steps[1] * 3, "{wanted:e}: {n_steps:?} steps");
        assert_eq!(summary.stats.n_reject, 0, "{wanted:e}");
        assert!(summary.position_residual[1] < 1e-13, "{:?}", summary.position_residual);
    }
}

#[test]
fn motions_with_loads_are_solved_by_stages() {
    let model = |loads: &str| {
        let text = format!(
            r#"
            [bodies.rod]
            mass = "2 kg"
            com = ["0.5 m", 0]
            inertia = "0.3 kg*m^2"
            [joints.pin]
            type = "revolute"
            between = ["ground", "rod"]
            coordinate = "a"
            [loads.gravity]
            type = "gravity"
            acceleration = [0, "-9.81 m/s^2"]
            {loads}
            [solve]
            t_end = 10
            "#
        );
        Mechanism::from_toml(&text, "rod").expect("a model")
    };
    let plain = model("");
    assert!(matches!(method(&plain), ExplicitMethod::Taylor { .. }));
    let motor = "[loads.motor]\ntype = \"torque\"\non = \"rod\"\nvalue = \"-1 N m*a\"\n";
    assert_eq!(method(&model(motor)), ExplicitMethod::DormandPrince);

    // From rest, where the series has terms of every fourth order alone.
    let (_, summary) = run(&plain);
    let energy = &summary.energy;
    assert!(energy.worst_error < 1e-5 * energy.scale, "{energy:?}");
}

#[test]
fn constraints_are_kept_and_no_bit_depends_on_machine_code() {
    for (model, t_end) in LARGER.into_iter().chain([CAR_AXIS, PENDULUM]) {
        let [on, off] = ["on", "off"].map(|jit| {
            let options =
                format!("{t_end}\nrtol = 1e-8\natol = 1e-8\nevery = 100\njit = \"{jit}\"");
            run(&mechanism(model, &options))
        });
        let bits = |sample: &Sample| {
            sample.q.iter().chain(&sample.v).map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        assert_eq!(bits(&on.0), bits(&off.0), "{model}");
        assert_eq!(on.1.stats, off.1.stats, "{model}");
    }
}

#[test]
fn a_run_that_was_stopped_goes_on_bit_for_bit() {
    for ((model, t_end), every) in [(CAR_AXIS, 0.4), (PENDULUM, 1.0)] {
        stop_and_go_on(&mechanism(
            model,
            &format!("{t_end}\nrtol = 1e-9\natol = 1e-9\nevery = {every}"),
        ));
    }
}

fn stop_and_go_on(mechanism: &Mechanism) {
    let (whole, undisturbed) = run(mechanism);
    let (start, simulation) =
        (mechanism.start().expect("a start"), mechanism.simulation().expect("equations"));
    for after in [1, 5, 20] {
        let n = std::cell::Cell::new(0);
        let stop = || {
            n.set(n.get() + 1);
            n.get() >= after
        };
        let mut ignore = |_: &Sample| Control::Continue;
        let part = simulation.run(&start, &mut ignore, &stop).expect("it is only stopped");
        let checkpoint = part.checkpoint.expect("where to go on from");
        let mut last = Sample::default();
        let mut keep = |sample: &Sample| {
            last.clone_from(sample);
            Control::Continue
        };
        let rest =
            simulation.resume(&start, &checkpoint, &mut keep, &|| false).expect("it goes on");
        assert_eq!(rest.stats, undisturbed.stats, "after {after}");
        assert_eq!(last, whole, "after {after}");
    }
}
