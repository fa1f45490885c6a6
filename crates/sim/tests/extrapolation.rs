//! Extrapolation in lanes: chosen where outputs are few and nothing switches, and as exact as asked for.

use bksim_dae::{Control, ExplicitMethod};
use bksim_sim::Mechanism;
use bksim_sim::run::{Sample, Summary, cheapest_explicit};

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

const MODELS: [(&str, &str); 4] = [
    ("crates/bench/models/pendulum.toml", "t_end = 10"),
    ("crates/bench/models/caraxis.toml", "t_end = 3"),
    ("crates/bench/models/andrews.toml", "t_end = 0.03"),
    ("crates/bench/models/slidercrank.toml", "t_end = 1"),
];

#[test]
fn few_outputs_are_extrapolated_to_as_many_digits_as_dormand_and_prince_give_in_more_evaluations() {
    for (model, t_end) in MODELS {
        for exponent in [8, 10] {
            let options = format!("{t_end}\nrtol = 1e-{exponent}\natol = 1e-{exponent}\n");
            let few = mechanism(model, &format!("{options}every = 100"));
            let is_extrapolated =
                matches!(cheapest_explicit(&few.model.solve), ExplicitMethod::Extrapolation { .. });
            assert!(is_extrapolated, "{model}");
            let plain = mechanism(model, &format!("{options}every = 100\nmethod = \"explicit\""));
            let tight = t_end.to_owned() + "\nrtol = 1e-12\natol = 1e-12\nmethod = \"explicit\"";
            let (exact, _) = run(&mechanism(model, &(tight + "\nevery = 100")));
            let error = |found: &Sample| {
                let gaps =
                    found.q.iter().zip(&exact.q).map(|(a, b)| (a - b).abs() / b.abs().max(1.0));
                gaps.fold(0.0, f64::max)
            };
            let ((found, summary), (_, other)) = (run(&few), run(&plain));
            let wanted = 10f64.powi(-exponent);
            assert!(error(&found) < wanted, "{model}, {wanted:e}: {:e}", error(&found));
            // Four evaluations at once, and one at the end of each step.
            let in_sequence = summary.stats.n_residual as f64 / 4.0;
            let saved = in_sequence / other.stats.n_residual as f64;
            assert!(saved < 0.8, "{model}, {wanted:e}: {saved:.2}");
        }
    }
}

#[test]
fn constraints_are_kept_and_no_bit_depends_on_machine_code() {
    for (model, t_end) in MODELS {
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
    let options = "t_end = 0.03\nrtol = 1e-9\natol = 1e-9\nevery = 0.004";
    let mechanism = mechanism("crates/bench/models/andrews.toml", options);
    let (whole, undisturbed) = run(&mechanism);
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
