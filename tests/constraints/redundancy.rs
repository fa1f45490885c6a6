//! Reactions that are not unique: which components, by what self-stresses, and from when on.

use std::collections::BTreeMap;

use crate::support::{Measures, Within, all_close, at, close, derive, model, path, solve};
use bksim::Mechanism;
use bksim::sim::mobility::mobility;
use bksim::sim::redundancy::{SelfStress, Uniqueness};
use serde_json::Value;

const COMPONENTS: [&str; 6] = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"];

fn fixture(name: &str) -> String {
    let file = path(&format!("tests/fixtures/{name}.toml"));
    std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// The components that are not unique: `A.Fx`, efforts of drives as `drive 0`, contacts as `contact 1`.
fn shared(mechanism: &Mechanism, uniqueness: &Uniqueness) -> Vec<String> {
    let mut names = Vec::new();
    for (joint, six) in mechanism.compiled.joints.iter().zip(&uniqueness.reactions) {
        let of_joint = COMPONENTS.iter().zip(six).filter(|(_, is_unique)| !**is_unique);
        names.extend(of_joint.map(|(component, _)| format!("{joint}.{component}")));
    }
    for (word, efforts) in [("drive", &uniqueness.drives), ("contact", &uniqueness.contacts)] {
        let efforts = efforts.iter().enumerate().filter(|(_, is_unique)| !**is_unique);
        names.extend(efforts.map(|(k, _)| format!("{word} {k}")));
    }
    names
}

/// All of these components of these joints.
fn components(joints: &[&str], of: &[&str]) -> Vec<String> {
    joints.iter().flat_map(|j| of.iter().map(move |c| format!("{j}.{c}"))).collect()
}

/// A self-stress over the components that `index` numbers.
fn vector(mechanism: &Mechanism, stress: &SelfStress, index: &BTreeMap<String, usize>) -> Vec<f64> {
    let mut found = vec![0.0; index.len()];
    for (joint, six) in &stress.reactions {
        for (component, part) in COMPONENTS.iter().zip(six).filter(|(_, part)| **part != 0.0) {
            let name = format!("{}.{component}", mechanism.model.joints[joint.0].name);
            found[index[&name]] = *part;
        }
    }
    assert!(stress.efforts.is_empty(), "nothing is driven here: {stress:?}");
    found
}

/// An orthonormal basis of what some vectors span.
fn orthonormal(vectors: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for vector in vectors {
        let mut rest = vector.clone();
        for direction in basis.iter().chain(&basis) {
            let along = dot(direction, &rest);
            rest.iter_mut().zip(direction).for_each(|(x, d)| *x -= along * d);
        }
        let norm = dot(&rest, &rest).sqrt();
        assert!(norm > 1e-6 * dot(vector, vector).sqrt(), "the vectors are dependent");
        basis.push(rest.iter().map(|x| x / norm).collect());
    }
    basis
}

/// P x with P the projector on what an orthonormal basis spans.
fn projected(basis: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; x.len()];
    for direction in basis {
        let along: f64 = direction.iter().zip(x).map(|(d, x)| d * x).sum();
        image.iter_mut().zip(direction).for_each(|(y, d)| *y += along * d);
    }
    image
}

fn check_against_reference(name: &str) {
    let file = path(&format!("tests/data/redundancy/{name}.json"));
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{name}: {e}"));
    let reference: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
    let rows: Vec<&Vec<Value>> =
        reference["rows"].as_array().expect("rows").iter().filter_map(Value::as_array).collect();
    let number = |value: &Value| value.as_f64().expect("a number");
    let label = |row: &[Value]| row[0].as_str().expect("a name").to_owned();
    let index: BTreeMap<String, usize> =
        rows.iter().enumerate().map(|(k, row)| (label(row), k)).collect();

    // Which components, and how many self-stresses.
    let mechanism = derive(model(reference["model"].as_str().expect("a model")));
    let simulation = mechanism.simulation().unwrap_or_else(|e| panic!("{name}: {e}"));
    let start = simulation.start().unwrap_or_else(|e| panic!("{name}: {e}"));
    let not_unique = rows.iter().filter(|row| row[1] == Value::Bool(false));
    let mut expected: Vec<String> = not_unique.map(|row| label(row)).collect();
    let mut found = shared(&mechanism, &start.uniqueness);
    expected.sort();
    found.sort();
    assert_eq!(found, expected, "{name}");
    let n = reference["columns"].as_array().expect("columns").len() - 3;
    assert_eq!(start.uniqueness.n_self_stresses, n, "{name}");

    // The same space of self-stresses: either basis stays as it is under the projector on the other.
    let stresses = simulation.self_stresses(&start);
    let ours: Vec<_> = stresses.iter().map(|s| vector(&mechanism, s, &index)).collect();
    let theirs: Vec<Vec<f64>> =
        (0..n).map(|k| rows.iter().map(|row| number(&row[3 + k])).collect()).collect();
    let bases = [orthonormal(&ours), orthonormal(&theirs)];
    let within = Within { relative: 0.0, absolute: 1e-9 };
    for (basis, vectors) in bases.iter().zip([&theirs, &ours]) {
        for vector in vectors {
            all_close(name, &projected(basis, vector), vector, within);
        }
    }

    // Less their part along the self-stresses, the reactions are those of least norm.
    let sample = &solve(&mechanism).samples[0];
    let mut reactions = vec![0.0; index.len()];
    for (joint, six) in mechanism.compiled.joints.iter().zip(&sample.reactions) {
        for (component, part) in COMPONENTS.iter().zip(six) {
            match index.get(&format!("{joint}.{component}")) {
                Some(&k) => reactions[k] = *part,
                None => assert!(part.abs() < 1e-9, "{name}: {joint}.{component} = {part}"),
            }
        }
    }
    let along = projected(&bases[0], &reactions);
    let least: Vec<f64> = reactions.iter().zip(&along).map(|(r, along)| r - along).collect();
    let expected: Vec<f64> = rows.iter().map(|row| number(&row[2])).collect();
    all_close(name, &least, &expected, Within { relative: 1e-9, absolute: 1e-9 });
}

#[test]
fn reactions_of_three_cranks_are_those_of_the_reference() {
    check_against_reference("three-cranks");
}

#[test]
fn reactions_of_a_door_are_those_of_the_reference() {
    check_against_reference("door");
}

/// The planar four-bar as bodies in space.
fn four_bar_in_space(policy: &str) -> Mechanism {
    let text = fixture("swinging-four-bar");
    let mut text = text.replace("[ground]", &format!("space = \"spatial\"\n{policy}\n[ground]"));
    for inertia in ["0.002", "0.006", "0.004"] {
        let one = format!("\"{inertia} kg m^2\"");
        text = text.replace(&one, &format!("[{one}, {one}, {one}]"));
    }
    derive(model(&text))
}

#[test]
fn a_plane_four_bar_in_space_keeps_its_plane_reactions_whichever_rows_fold_to_nothing() {
    for policy in ["coordinates = \"relative\"", "coordinates = \"absolute\""] {
        let mechanism = four_bar_in_space(policy);
        let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
        let expected = components(&["A", "B", "C", "D"], &["Fz", "Mx", "My"]);
        assert_eq!(shared(&mechanism, &start.uniqueness), expected, "{policy}");
        let count = mobility(&mechanism.model, &mechanism.system, &start);
        assert_eq!((count.gruebler, count.mobility, count.n_redundant), (-2, 1, 3), "{policy}");
        assert_eq!(count.redundant.len(), 4, "{policy}: {count:?}");
        // Rows of the tree and rows that fold to 0 = 0 are told in both coordinates.
        let words = count.repeated.iter().map(|of| of.condition.words(&mechanism.model));
        let expected =
            ["force along the z axis", "moment about the x axis", "moment about the y axis"];
        let expected = expected.map(|words| format!("{words} of `D`"));
        assert_eq!(words.collect::<Vec<_>>(), expected, "{policy}");
    }
    // In the plane nothing is shared.
    let mechanism = derive(model(&fixture("swinging-four-bar")));
    let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(shared(&mechanism, &start.uniqueness), Vec::<String>::new());
}

#[test]
fn overconstrained_linkages_have_no_singular_poses_that_they_do_not_have() {
    for (name, kutzbach, n_redundant) in [("bennett", -2, 3), ("sarrus", 0, 1)] {
        for cut in ["A", "B", "C", "D"] {
            let text = fixture(name);
            let line = text.lines().find(|l| l.starts_with(&format!("{cut} = {{ type")));
            let text = match line {
                Some(line) => text.replace(line, &line.replace(" }", ", cut = true }")),
                None => {
                    text.replace(&format!("[joints.{cut}]"), &format!("[joints.{cut}]\ncut = true"))
                }
            };
            let mechanism = derive(model(&text));
            let motion = solve(&mechanism);
            let count = mobility(&mechanism.model, &mechanism.system, &motion.start);
            let found = (count.gruebler, count.mobility, count.n_redundant);
            assert_eq!(found, (kutzbach, 1, n_redundant), "{name} cut at {cut}: {count:?}");
            let poses = &motion.summary.singular_poses;
            assert!(poses.is_empty(), "{name} cut at {cut}: {poses:?}");
            assert_eq!(motion.summary.uniqueness.len(), 1, "{name} cut at {cut}");
            let energy = motion.summary.energy;
            assert!(energy.worst_error < 1e-6 * energy.scale, "{name} cut at {cut}: {energy:?}");
        }
    }
}

#[test]
fn mobile_linkages_keep_their_energy_for_a_hundred_seconds() {
    for name in ["bennett", "sarrus"] {
        let mut model = model(&fixture(name));
        (model.solve.t_end, model.solve.every) = (100.0, Some(10.0));
        (model.solve.rtol, model.solve.atol) = (1e-10, 1e-12);
        let energy = solve(&derive(model)).summary.energy;
        assert!(energy.scale > 0.1, "{name} stands still: {energy:?}");
        assert!(energy.worst_error < 1e-7 * energy.scale, "{name}: {energy:?}");
    }
}

#[test]
fn sarrus_linkage_shares_one_twisting_moment() {
    let mechanism = derive(model(&fixture("sarrus")));
    let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
    let expected = components(&["A", "B", "C", "D", "E", "F"], &["Mz"]);
    assert_eq!(shared(&mechanism, &start.uniqueness), expected);
}

#[test]
fn joints_that_repeat_each_other_share_their_reactions_and_a_chain_behind_them_does_not() {
    let text = r#"
        [bodies.arm]
        mass = 2
        inertia = 0.1
        com = [0.5, 0]
        points = { P = [0, 0], Q = [1, 0] }
        [bodies.bob]
        mass = 1
        inertia = 0.01
        com = [0.2, 0]
        [joints.A]
        type = "revolute"
        between = ["ground", "arm.P"]
        [joints.twin]
        type = "revolute"
        between = ["ground", "arm.P"]
        [joints.B]
        type = "revolute"
        between = ["arm.Q", "bob"]
        [loads.gravity]
        type = "gravity"
        acceleration = [0, -9.81]
    "#;
    let mechanism = derive(model(text));
    let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(shared(&mechanism, &start.uniqueness), components(&["A", "twin"], &["Fx", "Fy"]));
    let count = mobility(&mechanism.model, &mechanism.system, &start);
    assert_eq!((count.mobility, count.n_redundant, count.redundant.len()), (2, 2, 2), "{count:?}");
}

#[test]
fn stops_that_repeat_each_other_share_their_force_from_when_both_hold() {
    let mechanism = derive(model(&fixture("block-against-stops")));
    let motion = solve(&mechanism);
    let changes = &motion.summary.uniqueness;
    let found: Vec<Vec<String>> =
        changes.iter().map(|change| shared(&mechanism, &change.uniqueness)).collect();
    assert_eq!(
        found,
        [vec![], vec!["contact 0".to_owned(), "contact 1".to_owned()]],
        "{changes:?}"
    );
    let hit = motion.summary.changes.iter().map(|change| change.t).fold(0.0, f64::max);
    assert_eq!(changes[1].t, hit, "{:?}", motion.summary.changes);
    // The joint itself carries what it always did.
    let simulation = mechanism.simulation().unwrap_or_else(|e| panic!("{e}"));
    assert!(simulation.self_stresses(&motion.start).is_empty());
}

/// The wall carries 5 N less what friction takes, and that may be anything up to 2 N either way.
#[test]
fn friction_that_rests_on_a_closed_stop_shares_its_force_with_it() {
    let text = fixture("block-against-friction");
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let changes = &motion.summary.uniqueness;
    let found: Vec<Vec<String>> =
        changes.iter().map(|change| shared(&mechanism, &change.uniqueness)).collect();
    let both = vec!["contact 0".to_owned(), "contact 1".to_owned()];
    assert_eq!(found, [vec![], both], "{changes:?}");
    // While it slides, nothing is shared, nor where the wall is away.
    let free = derive(model(&text.replace("max = \"1 m\"", "max = \"10 m\"")));
    let motion = solve(&free);
    assert!(motion.summary.uniqueness.iter().all(|change| change.uniqueness.is_complete()));
}

#[test]
fn a_driven_linkage_shares_no_effort() {
    let text = fixture("swinging-four-bar")
        + "\n[drives.motor]\njoint = \"A\"\nmotion = \"60 deg + 1*t\"\n";
    let text = text.replace(", rate = \"1 rad/s\"", "").replace("A = { angle = \"60 deg\" }\n", "");
    let mechanism = derive(model(&text));
    let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
    assert!(start.uniqueness.is_complete(), "{:?}", start.uniqueness);
    assert_eq!(start.uniqueness.drives, [true]);
}

/// A pendulum with a plate that a guide and a pin hold, one condition more than it takes, or a weld. A rod is pressed
/// against a stop in its elbow.
fn plate_on_a_pendulum(is_welded: bool, method: &str) -> String {
    let fixing = if is_welded {
        "w = { type = \"weld\", between = [\"arm.A\", \"plate.W\"] }\n".to_owned()
    } else {
        "guide = { type = \"prismatic\", between = [\"arm.A\", \"plate.A\"], direction = \"30 deg\" }\n\
         pin = { type = \"revolute\", between = [\"arm.B\", \"plate.B\"] }\n"
            .to_owned()
    };
    let rub = "rub = { type = \"friction\", joint = \"guide\", force = \"5 N\" }\n";
    let rub = if is_welded { "" } else { rub };
    format!(
        "coordinates = \"absolute\"\n[bodies]\n\
         arm = {{ mass = 2, com = [0.3, 0], inertia = 0.1, points = {{ O = [0, 0], A = [0.2, 0.1], B = [0.7, -0.1] }} }}\n\
         rod = {{ mass = 1, com = [0.2, 0], inertia = 0.02, points = {{ C = [0, 0] }} }}\n\
         [bodies.plate]\nmass = 1\ninertia = 0.05\n\
         points = {{ A = [0, 0], B = [\"0.5 m - 0.1 m*cos(30 deg)\", \"-0.2 m - 0.1 m*sin(30 deg)\"], \
         W = [\"-0.1 m*cos(30 deg)\", \"-0.1 m*sin(30 deg)\"] }}\n\
         [ground]\npoints = {{ O = [0, 0] }}\n[joints]\n{fixing}\
         pivot = {{ type = \"revolute\", between = [\"ground.O\", \"arm.O\"] }}\n\
         elbow = {{ type = \"revolute\", between = [\"arm.B\", \"rod.C\"] }}\n[loads]\n{rub}\
         gravity = {{ type = \"gravity\", acceleration = [0, \"-9.81 m/s^2\"] }}\n\
         limit = {{ type = \"stop\", joint = \"elbow\", max = 0 }}\n\
         press = {{ type = \"torque\", joint = \"elbow\", value = \"20 N*m\" }}\n\
         [initial]\nelbow = {{ angle = 0, rate = 0 }}\npivot = {{ angle = 0, rate = \"6 rad/s\" }}\n\
         [solve]\nt_end = 2\nevery = 0.02\nrtol = 1e-10\natol = 1e-12\nmethod = \"{method}\"\n"
    )
}

/// Friction in what a loop holds neither slides nor is followed as if it did, and the rows that hold the loop are exchanged
/// on the way although a stop bears: rows along fixed axes lose rank as the guide turns.
#[test]
fn a_rigid_loop_that_turns_takes_no_more_steps_than_a_weld() {
    for method in ["explicit", "radau"] {
        let [[welded, angle], [redundant, found]] = [true, false].map(|is_welded| {
            let mechanism = derive(model(&plate_on_a_pendulum(is_welded, method)));
            let motion = solve(&mechanism);
            let angle = Measures::new(&mechanism, &["pivot.angle"]).at(at(&motion, 2.0))[0];
            assert!(motion.summary.velocity_residual[1] < 1e-13, "{method}: {:?}", motion.summary);
            [motion.summary.stats.n_step as f64, angle]
        });
        assert!(redundant < 1.5 * welded, "{method}: {redundant} steps against {welded}");
        close("the angle", found, angle, Within { relative: 1e-7, absolute: 0.0 });
    }
}
