//! Runs say what their numbers are worth, and healthy ones are not suspected.

use std::fs;
use std::path::{Path, PathBuf};

use bksim::Mechanism;
use bksim::model::diagnostic::Diagnostic;
use bksim::sim::run::Summary;

/// How a run ended, and the warnings about its numbers.
fn worth(mechanism: &Mechanism) -> (Summary, Vec<Diagnostic>) {
    let simulation = mechanism.simulation().expect("functions");
    let summary = simulation.solve().expect("a motion").summary;
    let warnings = simulation.diagnose_worth(&summary);
    (summary, warnings)
}

fn models_in(folder: &str, is_taken: impl Fn(&Path) -> bool) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let entries = fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path());
    let mut found: Vec<PathBuf> = entries.filter(|path| is_taken(path)).collect();
    found.sort();
    found
}

/// A warning about a healthy run is as wrong as none about a bad one.
#[test]
fn no_example_is_suspected() {
    let examples = crate::support::example_names();
    let examples =
        examples.iter().map(|name| (PathBuf::from(name), crate::support::example_text(name)));
    let is_model = |path: &Path| path.extension().is_some_and(|ending| ending == "toml");
    // One turns for hours, one has places to be filled, and one passes singular poses, near which its accelerations are
    // known to few digits.
    let fixtures = models_in("tests/fixtures", |path| {
        let is_special = |name: &&str| path.ends_with(name);
        is_model(path) && !["long-pendulum.toml", "swinging-door.toml"].iter().any(is_special)
    });
    let elements = models_in("tests/fixtures/elements", |path| !path.ends_with("ravigneaux.toml"));
    let mut n_runs = 0;
    let files = fixtures.into_iter().chain(elements);
    let files = files.map(|path| (path.clone(), fs::read_to_string(&path).expect("a model")));
    for (path, text) in examples.chain(files) {
        let mechanism = Mechanism::from_toml(&text, "model").expect("a model");
        let (summary, warnings) = worth(&mechanism);
        assert!(summary.slowness.is_none(), "{}: {:?}", path.display(), summary.slowness);
        assert!(warnings.is_empty(), "{}: {warnings:?}", path.display());
        n_runs += 1;
    }
    assert!(n_runs > 25, "{n_runs} models");
}

/// At the step of Lê and Đinh, 0.01 s, 53 J of the work of 1955 J are missing in the end.
#[test]
fn a_coarse_fixed_step_is_told_from_a_fine_one() {
    let with_step = |step: f64| {
        let mut mechanism = crate::support::derive(crate::support::example("slider-crank"));
        mechanism.model.solve.step = Some(step);
        mechanism.model.solve.formulation = bksim::model::Formulation::Index3;
        let (_, warnings) = worth(&mechanism);
        warnings.iter().map(|warning| warning.code.0).collect::<Vec<_>>()
    };
    assert_eq!(with_step(0.01), ["R010", "R011"]);
    assert_eq!(with_step(0.001), [""; 0]);
}

/// The rotation of a light cross is followed by Newton's iteration alone: the light part leaves explicit steps only
/// rounding to follow.
#[test]
fn a_light_part_does_not_keep_the_steps_small() {
    let text = include_str!("../fixtures/light-cross.toml");
    let mechanism = Mechanism::from_toml(text, "light-cross").expect("a model");
    let (summary, _) = worth(&mechanism);
    assert!(summary.stats.n_step < 30_000, "{} steps", summary.stats.n_step);
}

/// A linkage without masses and loads, driven: all forces and energies are rounding.
#[test]
fn rounding_of_nothing_is_no_loss_of_energy() {
    let text = "[ground]\npoints = { D = [\"80 mm\", 0] }\n\
                [bodies.crank]\nmass = 0\npoints = { B = [\"40 mm\", 0] }\n\
                [bodies.coupler]\nmass = 0\npoints = { C = [\"100 mm\", 0] }\n\
                [bodies.rocker]\nmass = 0\npoints = { C = [\"100 mm\", 0] }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"crank\"] }\n\
                B = { type = \"revolute\", between = [\"crank.B\", \"coupler\"] }\n\
                C = { type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }\n\
                D = { type = \"revolute\", between = [\"ground.D\", \"rocker\"] }\n\
                [drives.motor]\njoint = \"A\"\nmotion = \"360 deg/s*t\"\n[solve]\nt_end = \"1 s\"\n";
    let mechanism = Mechanism::from_toml(text, "hoeken").expect("a model");
    let (summary, warnings) = worth(&mechanism);
    assert!(warnings.is_empty(), "{}: {warnings:?}", summary.energy.worst_error);
}
