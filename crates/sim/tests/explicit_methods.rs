//! Explicit steps: bits do not depend on machine code nor on interruptions.

use bksim_dae::Control;
use bksim_sim::Mechanism;
use bksim_sim::run::{Sample, Summary};

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

#[test]
fn no_bit_depends_on_machine_code() {
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
