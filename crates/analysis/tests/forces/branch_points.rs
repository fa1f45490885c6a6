//! Starts that yield but go nowhere, and equilibria in which branches of poses cross.

use crate::support::model;
use bksim_analysis::{
    About, Actuators, AnalysisError, Channels, KinematicsOptions, Motion, Prescribed, Range,
    Stability, inverse, kinematics, linearize, modes, statics,
};

const GRAVITY: &str = "[loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n";

/// Two bars of 0.25 m between pins, the second one of which is at `distance` from the first.
fn toggle(distance: f64) -> String {
    format!(
        "[ground]\npoints = {{ D = [{distance}, 0] }}\n\
         [bodies]\nleft = {{ mass = 1, inertia = 0.01, com = [0.125, 0], points = {{ B = [0.25, 0] }} }}\n\
         right = {{ mass = 1, inertia = 0.01, com = [0.125, 0], points = {{ D = [0.25, 0] }} }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"left\"] }}\n\
         B = {{ type = \"revolute\", between = [\"left.B\", \"right\"] }}\n\
         C = {{ type = \"revolute\", between = [\"ground.D\", \"right.D\"] }}\n{GRAVITY}"
    )
}

/// A parallelogram of bars of 0.2 and 0.5 m whose crank starts at an angle.
fn parallelogram(degrees: f64) -> String {
    format!(
        "[ground]\npoints = {{ D = [0.5, 0] }}\n\
         [bodies]\ncrank = {{ mass = 1, inertia = 0.01, com = [0.1, 0], points = {{ B = [0.2, 0] }} }}\n\
         coupler = {{ mass = 1, inertia = 0.01, com = [0.25, 0], points = {{ C = [0.5, 0] }} }}\n\
         rocker = {{ mass = 1, inertia = 0.01, com = [0.1, 0], points = {{ C = [0.2, 0] }} }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"crank\"] }}\n\
         B = {{ type = \"revolute\", between = [\"crank.B\", \"coupler\"] }}\n\
         C = {{ type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }}\n\
         D = {{ type = \"revolute\", between = [\"ground.D\", \"rocker\"] }}\n{GRAVITY}\
         [initial]\nA = {{ angle = \"{degrees} deg\" }}\ncoupler = {{ guess = {{ angle = 0 }} }}\n\
         rocker = {{ guess = {{ angle = \"{degrees} deg\" }} }}\n"
    )
}

/// A crank and a rod of one length; V = 1.962 sin A on both branches.
fn equal_arms(coordinates: &str) -> String {
    format!(
        "coordinates = \"{coordinates}\"\n\
         [bodies]\ncrank = {{ mass = 1, inertia = 0.01, com = [0.1, 0], points = {{ B = [0.2, 0] }} }}\n\
         rod = {{ mass = 1, inertia = 0.01, com = [0.1, 0], points = {{ C = [0.2, 0] }} }}\n\
         slider = {{ mass = 1 }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"crank\"] }}\n\
         B = {{ type = \"revolute\", between = [\"crank.B\", \"rod\"] }}\n\
         C = {{ type = \"revolute\", between = [\"rod.C\", \"slider\"] }}\n\
         guide = {{ type = \"prismatic\", between = [\"ground\", \"slider\"], axis = [1, 0] }}\n{GRAVITY}\
         [initial]\nA = {{ angle = \"-80 deg\" }}\nslider = {{ guess = {{ x = 0.07 }} }}\n"
    )
}

fn drive(model: &bksim_model::Model, values: &str) -> Prescribed {
    let drive = bksim_analysis::Drive::parse(model, "A.angle", values).expect("a range");
    Prescribed::Drives { drives: vec![drive], through: false }
}

fn along(branch: usize) -> KinematicsOptions {
    KinematicsOptions { branch: Some(branch), ..KinematicsOptions::default() }
}

#[test]
fn every_question_refuses_a_toggle_in_line_in_the_same_words() {
    let make = || model(&toggle(0.5));
    let range = drive(&make(), "0:30 deg:4");
    let motion = Motion::formula(&make(), "A.angle", "0.1*t").expect("a motion");
    let times = Range { from: 0.0, to: 0.0, n: 1 };
    let faults = [
        statics(make(), &[], &[]).expect_err("static"),
        kinematics(make(), &range).expect_err("kinematics"),
        modes(make(), About::Static).expect_err("modes"),
        modes(make(), About::Start).expect_err("modes about the start"),
        linearize(make(), About::Static, &Channels::default()).expect_err("linearize"),
        linearize(make(), About::Start, &Channels::default())
            .expect_err("linearize about the start"),
        inverse(make(), &[motion], &times, &Actuators::default()).expect_err("inverse"),
        bksim_analysis::limits(make(), &bksim_analysis::LimitsRequest::default())
            .expect_err("limits"),
    ];
    for fault in faults {
        let AnalysisError::GoesNowhere { moves } = &fault else { panic!("{fault:?}") };
        assert!(moves.contains(&"A.angle".to_owned()), "{moves:?}");
        assert_eq!(fault.diagnostics()[0].code, bksim_analysis::codes::GOES_NOWHERE);
    }
    // A little shorter, the bars hang: y = −√(0.25² − 0.24²) is the middle pin.
    let found = statics(model(&toggle(0.48)), &[], &[]);
    assert!(found.is_ok(), "{found:?}");
}

#[test]
fn a_driven_platform_in_a_singular_pose_is_refused() {
    let text = include_str!("../data/gough-rods.toml");
    let fault = statics(model(text), &[], &[]).expect_err("a singular pose");
    assert!(matches!(fault, AnalysisError::GoesNowhere { .. }), "{fault:?}");
    let fault = modes(model(text), About::Start).expect_err("a singular pose");
    assert!(matches!(fault, AnalysisError::GoesNowhere { .. }), "{fault:?}");
}

#[test]
fn equal_arms_hang_stable_on_both_branches() {
    for coordinates in ["relative", "absolute"] {
        let make = || model(&equal_arms(coordinates));
        let found = statics(make(), &[], &[]).expect("equilibria");
        assert_eq!(found.equilibria.len(), 2, "{coordinates}: {:?}", found.equilibria);
        for (e, (degrees, stability)) in
            found.equilibria.iter().zip([(-90.0, Stability::Stable), (90.0, Stability::Unstable)])
        {
            let value = |name: &str| e.pose.iter().find(|(n, ..)| n == name).expect("a value").1;
            let angle = value("A.angle").to_degrees();
            let off = (angle - degrees).rem_euclid(360.0);
            assert!(off.min(360.0 - off) < 1e-6, "{coordinates}: {angle}");
            assert_eq!(e.stability, stability, "{coordinates}");
            assert!(e.stiffness.is_empty() && e.branches.len() == 2, "{:?}", e.branches);
            for branch in &e.branches {
                assert_eq!(branch.stability, stability, "{branch:?}");
                assert_eq!(branch.rates[0].0, "A.angle");
                // V″ = −1.962 sin A by the crank's angle, which is the first to move on either.
                let expected = -1.962 * degrees.to_radians().sin();
                assert!((branch.stiffness - expected).abs() < 1e-6, "{branch:?}");
            }
            // 3 kg hang on the crank's pin and the slider's guide, not 1e9 N.
            assert!(e.reactions.iter().flatten().all(|r| r.abs() < 100.0), "{:?}", e.reactions);
        }
        // J = 0.28 kg m² with the slider, and 0.04 where the rod turns about the crank's pin.
        let swings = modes(make(), About::Static).expect("modes");
        let omegas: Vec<f64> = swings.modes.iter().map(|mode| mode.omega).collect();
        assert_eq!(omegas.len(), 2, "{omegas:?}");
        for (omega, inertia) in omegas.iter().zip([0.28_f64, 0.04]) {
            let expected = (1.962 / inertia).sqrt();
            assert!((omega - expected).abs() < 1e-6 * expected, "{omega} for {expected}");
        }
        let mut branches: Vec<_> = swings.modes.iter().map(|mode| mode.branch).collect();
        branches.sort_unstable();
        assert_eq!(branches, [Some(1), Some(2)]);
        let fault = linearize(make(), About::Static, &Channels::default()).expect_err("a crossing");
        assert!(matches!(fault, AnalysisError::BranchPoint { .. }), "{fault:?}");
    }
}

#[test]
fn a_flat_parallelogram_is_followed_along_each_branch() {
    // Starts flat, where neither branch is in balance.
    let found = statics(model(&parallelogram(0.0)), &[], &[]).expect("equilibria");
    assert_eq!(found.ways.len(), 2, "{:?}", found.ways);
    let rate = |k: usize| found.ways[k].iter().find(|(n, ..)| n == "D.angle").expect("a rate").1;
    // D = A, and 0.14 A + 0.06 D = 0 to first order.
    assert!((rate(0) - 1.0).abs() < 1e-5 && (rate(1) + 7.0 / 3.0).abs() < 1e-5, "{:?}", found.ways);
    let mut parallel = 0;
    for e in &found.equilibria {
        let value = |name: &str| e.pose.iter().find(|(n, ..)| n == name).expect("a value").1;
        let [a, d] = ["A.angle", "D.angle"].map(value);
        assert!(e.reactions.iter().flatten().all(|r| r.abs() < 1e4), "{:?}", e.reactions);
        // All rows hold: |B C| = 0.5.
        let (x, y) = (0.5 + 0.2 * (d.cos() - a.cos()), 0.2 * (d.sin() - a.sin()));
        assert!((x.hypot(y) - 0.5).abs() < 1e-9, "{a} {d}");
        if (a - d).abs() < 1e-6 {
            parallel += 1;
            assert!((a.abs() - std::f64::consts::FRAC_PI_2).abs() < 1e-9, "{a}");
            let hangs = if a < 0.0 { Stability::Stable } else { Stability::Unstable };
            assert_eq!(e.stability, hangs);
        }
    }
    assert_eq!(parallel, 2, "{:?}", found.table().column("A.angle"));

    // From another start the parallelogram is the whole assembly.
    let found = statics(model(&parallelogram(30.0)), &[], &[]).expect("equilibria");
    assert!(found.ways.is_empty() && found.equilibria.len() == 2, "{found:?}");
    for fault in [
        modes(model(&parallelogram(0.0)), About::Start).err(),
        linearize(model(&parallelogram(0.0)), About::Start, &Channels::default()).err(),
    ] {
        let is_told = matches!(fault, None | Some(AnalysisError::BranchPoint { .. }));
        assert!(is_told, "{fault:?}");
    }
}

#[test]
fn a_range_follows_the_branch_that_is_named() {
    let make = || model(&parallelogram(0.0));
    let range = drive(&make(), "0:350 deg:36");
    let fault = kinematics(make(), &range).expect_err("a choice");
    assert!(matches!(fault, AnalysisError::BranchPoint { .. }), "{fault:?}");
    for (number, ratio) in [(1, 1.0), (2, -7.0 / 3.0)] {
        let found = bksim_analysis::kinematics_along(make(), &range, along(number)).expect("rows");
        let column = |name: &str| found.table.column(name).expect("a column");
        let (a, d, rate) = (column("A.angle"), column("D.angle"), column("D.rate"));
        assert_eq!(a.len(), 36, "branch {number}: stopped at {:?}", found.stopped);
        assert!((rate[0] - ratio).abs() < 1e-6, "branch {number}: {}", rate[0]);
        for (a, d) in a.iter().zip(&d) {
            let (x, y) = (0.5 + 0.2 * (d.cos() - a.cos()), 0.2 * (d.sin() - a.sin()));
            assert!((x.hypot(y) - 0.5).abs() < 1e-9, "branch {number}: {a} {d}");
        }
        let all = found.table.rows.iter().flatten();
        assert!(all.clone().all(|x| x.is_finite()), "branch {number}");
        if number == 1 {
            let parallel = a.iter().zip(&d).all(|(a, d)| (a - d).abs() < 1e-7);
            assert!(parallel && rate.iter().all(|r| (r - 1.0).abs() < 1e-7), "{rate:?}");
        }
    }
    let fault = bksim_analysis::kinematics_along(make(), &range, along(3)).expect_err("two");
    assert_eq!(fault.to_string(), "the start has no branch 3, of 2");
    // Efforts need a branch, too.
    let motion = Motion::formula(&make(), "A.angle", "0.1*t").expect("a motion");
    let times = Range { from: 0.0, to: 1.0, n: 3 };
    let fault = inverse(make(), &[motion], &times, &Actuators::default()).expect_err("a choice");
    assert!(matches!(fault, AnalysisError::BranchPoint { .. }), "{fault:?}");
}

/// Three equal cranks in line with the bar that they move: slopes yield in two directions there, poses in one.
#[test]
fn three_cranks_in_line_with_their_bar_move_on() {
    let bodies = |at: &str| {
        let crank = "mass = 1, inertia = 0.01, points = { P = [0.2, 0] }";
        format!(
            "[ground]\npoints = {{ O2 = [0.5, 0], O3 = [1, 0] }}\n\
             [bodies]\nc1 = {{ {crank} }}\nc2 = {{ {crank} }}\nc3 = {{ {crank} }}\n\
             bar = {{ mass = 2, inertia = 0.2, points = {{ A = [0, 0], B = [0.5, 0], C = [1, 0] }} }}\n\
             [joints]\nA0 = {{ type = \"revolute\", between = [\"ground\", \"c1\"] }}\n\
             B0 = {{ type = \"revolute\", between = [\"ground.O2\", \"c2\"] }}\n\
             C0 = {{ type = \"revolute\", between = [\"ground.O3\", \"c3\"] }}\n\
             A = {{ type = \"revolute\", between = [\"c1.P\", \"bar.A\"] }}\n\
             B = {{ type = \"revolute\", between = [\"c2.P\", \"bar.B\"] }}\n\
             C = {{ type = \"revolute\", between = [\"c3.P\", \"bar.C\"] }}\n{GRAVITY}\
             [initial]\nA0 = {{ angle = {at} }}\nB0 = {{ angle = {at} }}\nC0 = {{ angle = {at} }}\n"
        )
    };
    let text = bodies("0");
    let found = statics(model(&text), &[], &[]).expect("equilibria").equilibria;
    let kinds: Vec<Stability> = found.iter().map(|e| e.stability).collect();
    assert!(
        kinds.contains(&Stability::Stable) && kinds.contains(&Stability::Unstable),
        "{kinds:?}"
    );
    // The bar of 2 kg at 0.2 m hangs or stands: V = 2 · 9.81 · 0.2 sin A.
    for one in &found {
        assert!((one.stiffness[0].abs() - 3.924).abs() < 1e-6, "{one:?}");
    }
    let driven = model(&text);
    let range = bksim_analysis::Drive::parse(&driven, "A0.angle", "0:60 deg:7").expect("a range");
    let prescribed = Prescribed::Drives { drives: vec![range], through: false };
    let table = kinematics(driven, &prescribed).expect("a table").table;
    let angles = table.column("C0.angle").expect("the third crank");
    for (k, angle) in angles.iter().enumerate() {
        let turned = 10.0 * f64::from(u32::try_from(k).expect("few"));
        assert!((angle.to_degrees() - turned).abs() < 1e-9, "{angles:?}");
    }
    assert_eq!(angles.len(), 7);
}
