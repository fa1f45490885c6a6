//! Assemblies that `[initial]` chooses: every start has them, and motions that pass over into another one name the joint.

use std::f64::consts::TAU;

use crate::support::{model, number};
use bksim_analysis::{
    AnalysisError, Drive, Kinematics, Prescribed, assemblies, kinematics, with_held_assembly,
};
use bksim_model::Model;
use bksim_sim::Mechanism;
use serde_json::Value;

const LINKAGES: &str = include_str!("../../../../tests/data/assemblies/planar.json");

fn held(text: &str) -> Model {
    with_held_assembly(model(text)).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn is_same_angle(a: f64, b: f64, tolerance: f64) -> bool {
    let off = a - b;
    (off - TAU * (off / TAU).round()).abs() < tolerance
}

/// Each assembly by its number, then by its name, as the consistent start with masses.
#[test]
fn starts_have_the_assembly_that_is_chosen() {
    let linkages: Vec<Value> = serde_json::from_str(LINKAGES).expect("linkages");
    let mut n_starts = 0;
    for linkage in linkages.iter().step_by(4) {
        let (id, crank) = (&linkage["id"], &linkage["crank"]);
        let text = format!(
            "{}\n[initial]\n{} = {{ angle = {} }}\n",
            linkage["model"].as_str().expect("a model"),
            crank["joint"].as_str().expect("a joint"),
            number(&crank["angle"])
        );
        let all = assemblies(model(&text)).expect("assemblies");
        for assembly in &all.assemblies {
            let name = &assembly.name;
            let n_of_name = all.assemblies.iter().filter(|other| other.name == *name).count();
            assert_eq!(n_of_name, 1, "{id}: `{name}`");
            for choice in [assembly.number.to_string(), format!("{name:?}")] {
                let chosen = held(&format!("{text}assembly = {choice}\n"));
                let again = assemblies(chosen.snapshot().to_model()).expect("assemblies");
                assert_eq!(again.held_number, Some(assembly.number), "{id}: {choice}");
                assert_eq!(again.assemblies, all.assemblies, "{id}: numbers stay");
                let mechanism = Mechanism::derive(chosen, Vec::new()).expect("a mechanism");
                let start = mechanism.start().expect("a start");
                for (coordinate, value) in mechanism.compiled.coordinates.iter().zip(&start.q) {
                    let of = |(known, ..): &&(String, f64, &str)| *known == coordinate.name;
                    let Some((_, expected, unit)) = assembly.pose.iter().find(of) else { continue };
                    let is_there = if *unit == "rad" {
                        is_same_angle(*value, *expected, 1e-9)
                    } else {
                        (value - expected).abs() < 1e-9
                    };
                    assert!(
                        is_there,
                        "{id}: {choice}: {} = {value}, not {expected}",
                        coordinate.name
                    );
                }
                n_starts += 1;
            }
        }
    }
    assert!(n_starts > 100, "{n_starts} starts");
}

/// Links of 0.5, 0.4, 0.5 and 0.9 m: the crank does not turn round.
const DOUBLE_ROCKER: &str = r#"
[ground.points]
D = [0.9, 0]
[bodies]
crank = { mass = 1, inertia = 0.02, points = { B = [0.5, 0] } }
coupler = { mass = 1, inertia = 0.02, points = { C = [0.4, 0] } }
rocker = { mass = 1, inertia = 0.02, points = { C = [0.5, 0] } }
[joints]
A = { type = "revolute", between = ["ground", "crank"] }
B = { type = "revolute", between = ["crank.B", "coupler"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker"] }
[solve]
t_end = 0.5
[initial]
"#;

/// The angle of the crank at which coupler and rocker are in line: cos θ = (a² + d² − (b + c)²) / 2ad.
fn crank_limit() -> f64 {
    ((0.25 + 0.81 - 0.81) / (2.0 * 0.5 * 0.9_f64)).acos()
}

fn over(model: Model, values: &str, through: bool) -> Kinematics {
    let drives = vec![Drive::parse(&model, "A.angle", values).expect("a drive")];
    kinematics(model, &Prescribed::Drives { drives, through }).expect("a table")
}

#[test]
fn a_range_through_a_dead_point_names_the_joint_and_the_place() {
    let text =
        format!("{DOUBLE_ROCKER}A = {{ angle = 1 }}\nassembly = \"A-B-C-D open, C left of B-D\"\n");
    let found = over(held(&text), "1:1.5:51", true);
    let [change] = found.changes.as_slice() else { panic!("{:?}", found.changes) };
    assert_eq!(change.joint.0, 2, "joint C");
    assert!((change.t - crank_limit()).abs() < 1e-12, "{} instead of {}", change.t, crank_limit());
    assert!(over(held(&text), "1:1.25:51", false).changes.is_empty(), "the range ends before");
    let unwatched = format!("{DOUBLE_ROCKER}A = {{ angle = 1 }}\n");
    assert!(over(model(&unwatched), "1:1.5:51", true).changes.is_empty());
}

#[test]
fn a_run_through_a_dead_point_names_the_joint_and_the_instant() {
    for coordinates in ["relative", "absolute"] {
        let text = format!(
            "coordinates = \"{coordinates}\"\n{DOUBLE_ROCKER}A = {{ angle = 1, rate = 1 }}\n\
             assembly = 1\n"
        );
        let mechanism = Mechanism::derive(held(&text), Vec::new()).expect("a mechanism");
        let simulation = mechanism.simulation().expect("a simulation");
        let mut cranks = Vec::new();
        let motion = simulation.solve().expect("a motion");
        let angle = |q: &[f64]| {
            let of_crank = mechanism.compiled.coordinates.iter().position(|c| {
                c.name == "A_angle" || (c.name.contains("crank") && c.name.contains("angle"))
            });
            q[of_crank.expect("the crank's angle")]
        };
        for sample in &motion.samples {
            cranks.push((sample.t, angle(&sample.q)));
        }
        let change = motion.summary.assembly_changes.first().expect("a change");
        assert_eq!(change.joint.0, 2, "joint C");
        // The crank turns back there.
        let (t, _) = cranks.iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("samples");
        assert!((change.t - t).abs() < 0.02, "{} and {t}", change.t);
    }
}

/// Where a parallelogram is flat its assemblies meet, and it goes straight on.
#[test]
fn a_parallelogram_keeps_its_assembly_through_both_change_points() {
    let text = DOUBLE_ROCKER.replace("D = [0.9, 0]", "D = [0.4, 0]")
        + "A = { angle = 1 }\nassembly = \"A-B-C-D open\"\n";
    let found = over(held(&text), "1:8:201", false);
    assert_eq!(found.stopped, None);
    assert!(found.changes.is_empty(), "{:?}", found.changes);
    let (crank, rocker) = (
        found.table.column("A.angle").expect("a column"),
        found.table.column("rocker.angle").expect("a column"),
    );
    assert!(crank.iter().zip(&rocker).all(|(a, b)| is_same_angle(*a, *b, 1e-9)));
}

#[test]
fn an_assembly_that_there_is_not_is_refused_with_all_that_there_are() {
    let text = format!("{DOUBLE_ROCKER}A = {{ angle = 1 }}\nassembly = 3\n");
    let error = with_held_assembly(model(&text)).expect_err("no third assembly");
    let AnalysisError::NoAssembly { known, .. } = &error else { panic!("{error}") };
    let names: Vec<&str> = known.iter().map(|(_, name)| name.as_str()).collect();
    assert_eq!(names.len(), 2, "{names:?}");
    // And a start that nobody has looked for is none.
    let chosen = model(&format!("{DOUBLE_ROCKER}A = {{ angle = 1 }}\nassembly = 1\n"));
    let mechanism = Mechanism::derive(chosen, Vec::new()).expect("a mechanism");
    assert!(mechanism.start().is_err());
}
