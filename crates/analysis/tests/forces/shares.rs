//! Shares of joints that repeat each other where they yield, and the set of reactions that equilibrium allows.

use crate::support::{Problem, model, number};
use bksim_analysis::{OpenReactions, ReactionBound, Stability, statics};
use bksim_model::{Compliance, Model};
use bksim_sim::{Mechanism, Motion};

fn yielding(mut model: Model, springs: &[(&str, &str)]) -> Model {
    let read = |(name, value): &(&str, &str)| Compliance::parse(&model, name, value);
    let springs: Vec<Compliance> = springs.iter().map(|s| read(s).expect("a spring")).collect();
    model.compliances = springs;
    model
}

fn run(mut model: Model, t_end: f64) -> (Mechanism, Motion) {
    model.solve.t_end = t_end;
    let mechanism = Mechanism::derive(model, Vec::new()).expect("equations");
    let motion = mechanism.solve().expect("a run");
    (mechanism, motion)
}

/// The component `A.Fx` of a sample.
fn component(mechanism: &Mechanism, sample: &bksim_sim::run::Sample, name: &str) -> f64 {
    let (joint, word) = name.rsplit_once('.').expect("a component");
    let joint = mechanism.compiled.joints.iter().position(|known| known == joint).expect("a joint");
    let k = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"].iter().position(|w| *w == word).expect("a word");
    sample.reactions[joint][k]
}

/// With equal springs everywhere the shares are the reactions of least norm of the reference.
#[test]
fn equal_springs_give_the_reactions_of_least_norm() {
    for name in ["red-door", "red-three-cranks"] {
        let problem = Problem::load(name);
        let own = problem.model();
        let joints: Vec<String> = own.joints.iter().map(|joint| joint.name.clone()).collect();
        let springs = joints
            .iter()
            .flat_map(|joint| [(joint.as_str(), "1e8 N/m"), (joint.as_str(), "1e8 N m/rad")]);
        let springs: Vec<(&str, &str)> = springs.collect();
        let (mechanism, motion) = run(yielding(own, &springs), 1e-3);
        let rows = problem.0["rows"].as_array().expect("rows");
        let size = rows.iter().fold(0.0, |most: f64, row| most.max(number(&row[2]).abs()));
        for row in rows {
            let name = row[0].as_str().expect("a name");
            let found = component(&mechanism, &motion.samples[0], name);
            let off = (found - number(&row[2])).abs();
            assert!(off <= 1e-10 * size, "{name}: {found} instead of {}", row[2]);
        }
        assert!(motion.summary.uniqueness.iter().all(|change| change.uniqueness.is_complete()));
    }
}

/// A plate of 90 N that hangs on three strings at x = 0, 1 and 3 m, its centre of mass at 1.2 m.
fn hanging(support: &str) -> String {
    let mut text = String::from(
        "[bodies.plate]\nmass = 9\ninertia = 2\ncom = [1.2, 0]\n\
         points = { P = [0, 0], Q = [1, 0], R = [3, 0] }\n\
         [loads.weight]\ntype = \"gravity\"\nacceleration = [0, -10]\n\
         [ground]\npoints = { A = [0, 2], B = [1, 2], C = [3, 2] }\n",
    );
    for (top, bottom, k) in [("A", "P", 2.0), ("B", "Q", 1.0), ("C", "R", 4.0)] {
        text.extend([format!(
            "[bodies.s{top}]\nmass = 1e-9\ninertia = 1e-9\npoints = {{ top = [0, 2], end = [0, 0] }}\n\
             [joints.{bottom}]\ntype = \"revolute\"\nbetween = [\"s{top}.end\", \"plate.{bottom}\"]\n"
        )]);
        if support == "rigid" {
            text.extend([format!(
                "[joints.{top}]\ntype = \"revolute\"\nbetween = [\"ground.{top}\", \"s{top}.top\"]\n"
            )]);
        } else {
            text.extend([format!(
                "[loads.k{top}]\ntype = \"spring\"\nbetween = [\"ground.{top}\", \"s{top}.top\"]\n\
                 stiffness = {}\nlength = 0\n",
                k * 1e9
            )]);
        }
    }
    if support != "rigid" {
        text = text.replace("[bodies.plate]\n", "[bodies.plate]\nfree = true\n");
    }
    text + "[initial]\nplate = { guess = { angle = 0, x = 1.2, y = 0 } }\n"
}

#[test]
fn three_strings_share_a_weight_by_least_work_and_as_bushings_do() {
    let springs = [("A", "2 kN/m"), ("B", "1 kN/m"), ("C", "4 kN/m")];
    let found = statics(yielding(model(&hanging("rigid")), &springs), &[], &[]).expect("balance");
    let rigid = &found.equilibria.iter().find(|e| e.q.iter().all(|x| x.is_finite())).expect("one");
    // The plate goes down by y + θ x, so that Fᵢ = kᵢ (y + θ xᵢ): two equations of balance.
    let (k, x) = ([2.0, 1.0, 4.0], [0.0, 1.0, 3.0]);
    let sum = |f: &dyn Fn(usize) -> f64| (0..3).map(f).sum::<f64>();
    let (s0, s1, s2) = (sum(&|i| k[i]), sum(&|i| k[i] * x[i]), sum(&|i| k[i] * x[i] * x[i]));
    let (weight, moment) = (90.0, 90.0 * 1.2);
    let determinant = s0 * s2 - s1 * s1;
    let (y, theta) =
        ((weight * s2 - moment * s1) / determinant, (moment * s0 - weight * s1) / determinant);
    let of = |name: &str| found.joints.iter().position(|joint| joint == name).expect("a joint");
    for (i, name) in ["P", "Q", "R"].into_iter().enumerate() {
        let expected = k[i] * (y + theta * x[i]);
        let force = rigid.reactions[of(name)][1];
        assert!((force - expected).abs() < 1e-6, "{name}: {force} instead of {expected}");
    }
    assert!(rigid.open.components.is_empty());

    // Stiff springs in the place of the pins above.
    let bushings = statics(model(&hanging("bushings")), &[], &[]).expect("balance");
    let lowest = |e: &&bksim_analysis::Equilibrium| {
        e.pose.iter().all(|(name, value, _)| name != "plate.angle" || value.abs() < 1e-3)
            && e.pose.iter().all(|(name, value, _)| name != "plate.y" || value.abs() < 1e-3)
    };
    let soft = bushings.equilibria.iter().find(lowest).expect("the pose of the start");
    let of_soft = |name: &str| bushings.joints.iter().position(|j| j == name).expect("a joint");
    for name in ["P", "Q", "R"] {
        let (a, b) = (rigid.reactions[of(name)][1], soft.reactions[of_soft(name)][1]);
        assert!((a - b).abs() < 1e-5, "{name}: {a} beside {b}");
    }
}

fn range(open: &OpenReactions, name: &str) -> [f64; 2] {
    open.components.iter().find(|c| c.name == name).unwrap_or_else(|| panic!("no {name}")).range
}

#[test]
fn strings_that_only_pull_have_forces_within_ranges() {
    let own = model(&hanging("rigid"));
    let bounds: Vec<ReactionBound> = ["P.fy", "Q.fy", "R.fy"]
        .iter()
        .map(|name| ReactionBound::parse(&own, name, "0:60 N").expect("a bound"))
        .collect();
    let open = &statics(own, &[], &bounds).expect("balance").equilibria[0].open;
    assert_eq!((open.n_self_stresses, open.is_possible), (1, true));
    // Q = q, R = (108 − q)/3, P = 90 − q − R: q ≤ 60 and 0 ≤ P ≤ 60.
    let close = |found: [f64; 2], expected: [f64; 2]| {
        let off = (found[0] - expected[0]).abs().max((found[1] - expected[1]).abs());
        assert!(off < 1e-4, "{found:?} instead of {expected:?}");
    };
    close(range(open, "Q.fy"), [0.0, 60.0]);
    close(range(open, "R.fy"), [16.0, 36.0]);
    close(range(open, "P.fy"), [14.0, 54.0]);

    // Without bounds all is open, and bounds that exclude each other are told.
    let open = &statics(model(&hanging("rigid")), &[], &[]).expect("balance").equilibria[0].open;
    assert_eq!(range(open, "Q.fy"), [f64::NEG_INFINITY, f64::INFINITY]);
    let own = model(&hanging("rigid"));
    let bounds = ["P.fy", "Q.fy", "R.fy"]
        .map(|name| ReactionBound::parse(&own, name, "0:20 N").expect("a bound"));
    assert!(!statics(own, &[], &bounds).expect("balance").equilibria[0].open.is_possible);
}

#[test]
fn stops_that_are_both_closed_push_with_what_the_other_leaves() {
    let press = model(
        "[bodies.ram]\nmass = 3\ninertia = 1\n[joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"ram\"]\n\
         axis = [0, 1]\n[loads]\nweight = { type = \"gravity\", acceleration = [0, -10] }\n\
         one = { type = \"stop\", joint = \"guide\", min = 0 }\nother = { type = \"stop\", joint = \"guide\", min = 0 }\n\
         [initial]\nguide = { position = 0, velocity = 0 }\n",
    );
    let found = statics(press, &[], &[]).expect("balance");
    let open = &found.equilibria[0].open;
    for name in ["stop one", "stop other"] {
        let [least, most] = range(open, name);
        assert!(least.abs() < 1e-5 && (most - 30.0).abs() < 1e-4, "{name}: {least} to {most}");
    }
}

#[test]
fn a_spring_in_one_direction_decides_that_direction_alone() {
    let problem = Problem::load("red-door");
    let springs = [("lower.fz", "3e7 N/m"), ("upper.fz_joint", "1e7 N/m")];
    let (mechanism, motion) = run(yielding(problem.model(), &springs), 1e-3);
    let weight = 9.81 * 26.5 + 2.0;
    let [lower, upper] =
        ["lower.Fz", "upper.Fz"].map(|name| component(&mechanism, &motion.samples[0], name));
    assert!((lower / upper - 3.0).abs() < 1e-9, "{lower} {upper}");
    let unique = &motion.summary.uniqueness[0].uniqueness;
    assert_eq!(unique.n_self_stresses, 4);
    assert!(unique.reactions[0][2] && !unique.reactions[0][0]);
    assert!((lower + upper).abs() > 0.9 * weight);
}

#[test]
fn names_and_units_of_springs_are_looked_at() {
    let own = Problem::load("red-door").model();
    for (name, value) in [
        ("hinge", "1 N/m"),
        ("lower.fq", "1 N/m"),
        ("lower", "1 m/s"),
        ("lower", "-1 N/m"),
        ("lower.fz", "1 N m/rad"),
    ] {
        assert!(Compliance::parse(&own, name, value).is_err(), "{name} = {value}");
    }
    assert!(Compliance::parse(&own, "lower.mz_joint", "2 kN m/rad").expect("a spring").is_moment);
}

/// An H-frame on two hinges in line, with a lump below: Lᵢ² + Rᵢ² is least over what balances 392.4 N at x = 0.725 m.
#[test]
fn reactions_that_are_not_unique_are_of_least_norm_in_all_coordinates() {
    for coordinates in ["relative", "absolute"] {
        let text = format!(
            "coordinates = \"{coordinates}\"\n{}",
            r#"
            space = "spatial"
            [ground]
            points = { L = { at = [0, 0, 0], rpy = [0, "90 deg", 0] }, R = { at = [1, 0, 0], rpy = [0, "90 deg", 0] } }
            [bodies.frame]
            mass = 10
            com = [0.5, 0, -0.5]
            inertia = [1, 1, 1]
            points = { L = { at = [0, 0, 0], rpy = [0, "90 deg", 0] }, R = { at = [1, 0, 0], rpy = [0, "90 deg", 0] }, M = [0.8, 0, -0.5] }
            [bodies.lump]
            mass = 30
            inertia = [0.1, 0.1, 0.1]
            [joints]
            L = { type = "revolute", between = ["ground.L", "frame.L"] }
            R = { type = "revolute", between = ["ground.R", "frame.R"] }
            M = { type = "weld", between = ["frame.M", "lump"] }
            [loads]
            g = { type = "gravity", acceleration = [0, 0, -9.81] }
            "#
        );
        let found = statics(model(&text), &[], &[]).expect("balance");
        assert_eq!(found.equilibria.len(), 2, "{coordinates}");
        let hangs = found.equilibria.iter().find(|e| e.stability == Stability::Stable);
        let reactions = &hangs.expect("it hangs").reactions;
        let expected = [("L", 2, 178.542), ("R", 2, 213.858), ("L", 4, -35.316), ("R", 4, -35.316)];
        for (joint, k, value) in expected {
            let own = found.joints.iter().position(|known| known == joint).expect("a joint");
            let off = (reactions[own][k] - value).abs();
            assert!(off < 1e-8 * 392.4, "{coordinates}: {joint} {k}: {}", reactions[own][k]);
        }
    }
}
