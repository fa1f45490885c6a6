//! Limit positions and assemblies against references of 15 digits.

use std::f64::consts::TAU;

use crate::support::{Problem, geometry, model, number};
use bksim_analysis::{
    Branch, CurvesRequest, Drive, Limits, LimitsRequest, Prescribed, Rotatability, assemblies,
    curves, kinematics, limits,
};

fn value(pose: &[(String, f64)], name: &str) -> f64 {
    pose.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no {name}")).1
}

fn off(a: f64, b: f64) -> f64 {
    let off = a - b;
    (off - TAU * (off / TAU).round()).abs()
}

fn of(branch: &Branch, name: &str) -> Vec<Vec<(String, f64)>> {
    let own = branch.extremes.iter().filter(|extreme| extreme.name == name);
    own.map(|extreme| extreme.pose.clone()).collect()
}

fn found(name: &str, drive: Option<&str>, outputs: &[&str], all: bool) -> (Problem, Limits) {
    let problem = Problem::load(name);
    let request = LimitsRequest {
        drive: drive.map(str::to_owned),
        outputs: outputs.iter().map(|name| (*name).to_owned()).collect(),
        all_assemblies: all,
    };
    let limits = limits(problem.model(), &request).expect("limits");
    (problem, limits)
}

#[test]
fn crank_rocker() {
    let (problem, limits) =
        found("lim-crank-rocker", Some("crank.angle"), &["rocker.angle"], false);
    let values = &problem.0["values"];
    let [branch] = limits.branches.as_slice() else { panic!("one branch") };
    let poses = of(branch, "rocker.angle");
    assert_eq!(poses.len(), 2);
    for limit in values["limits"].as_array().expect("limits") {
        let meets = |pose: &Vec<(String, f64)>| {
            ["crank", "coupler", "rocker"].iter().all(|body| {
                off(value(pose, &format!("{body}.angle")), number(&limit[*body])) < 1e-10
            })
        };
        assert!(poses.iter().any(meets), "{limit} is not among {poses:?}");
    }
    let ratio = branch.outputs[0].time_ratio.expect("a time ratio");
    assert!((ratio - number(&values["time_ratio"])).abs() < 1e-10);
    for expected in values["transmission"].as_array().expect("angles") {
        let meets = |pose: &Vec<(String, f64)>| {
            off(value(pose, "crank.angle"), number(&expected["crank"])) < 1e-10
                && (value(pose, "transmission C").abs() - number(&expected["angle"])).abs() < 1e-10
        };
        let poses = of(branch, "transmission C");
        assert!(poses.len() == 2 && poses.iter().any(meets), "{expected}: {poses:?}");
    }
}

#[test]
fn quick_return() {
    let (problem, limits) = found("lim-whitworth", Some("crank.angle"), &["ram.x"], false);
    let values = &problem.0["values"];
    let branch = &limits.branches[0];
    let poses = of(branch, "ram.x");
    assert_eq!(poses.len(), 2);
    for limit in values["limits"].as_array().expect("limits") {
        let meets = |pose: &Vec<(String, f64)>| {
            off(value(pose, "crank.angle"), number(&limit["crank"])) < 1e-10
                && (value(pose, "ram.x") - number(&limit["position"])).abs() < 1e-10
        };
        assert!(poses.iter().any(meets), "{limit} is not among {poses:?}");
    }
    let output = &branch.outputs[0];
    let ratio = output.time_ratio.expect("a time ratio");
    assert!((ratio - number(&values["time_ratio"])).abs() < 1e-10);
    for speed in values["largest_speed"].as_array().expect("speeds") {
        let meets = |[crank, _, rate]: &[f64; 3]| {
            off(*crank, number(&speed["crank"])) < 1e-10
                && (rate - number(&speed["velocity_per_crank_rate"])).abs() < 1e-10
        };
        assert!(output.fastest.iter().any(meets), "{speed} is not among {:?}", output.fastest);
    }
}

#[test]
fn rockers_on_both_sides() {
    let (problem, limits) = found("lim-triple-rocker", None, &[], true);
    assert_eq!(limits.branches.len(), 1, "both assemblies are one branch");
    let branch = &limits.branches[0];
    let rows = problem.rows();
    for (input, name) in [(0.0, "crank.angle"), (1.0, "rocker.angle")] {
        let poses = of(branch, name);
        let own: Vec<_> = rows.iter().filter(|row| row[0] == input).collect();
        assert_eq!(poses.len(), own.len(), "{name}");
        for row in own {
            let meets = |pose: &Vec<(String, f64)>| {
                ["crank", "coupler", "rocker"].iter().zip(&row[1..]).all(|(body, expected)| {
                    off(value(pose, &format!("{body}.angle")), *expected) < 1e-10
                })
            };
            assert!(poses.iter().any(meets), "{row:?} is not among {poses:?}");
        }
    }
}

/// R. L. Norton, *Design of Machinery*: links of 40, 120, 80 and 100 mm at 40°.
const NORTON: &str = r#"
[ground]
points = { D = ["100 mm", 0] }
[bodies.crank]
mass = 1
points = { B = ["40 mm", 0] }
[bodies.coupler]
mass = 1
points = { C = ["120 mm", 0] }
[bodies.rocker]
mass = 1
points = { C = ["80 mm", 0] }
[joints]
A = { type = "revolute", between = ["ground", "crank"] }
B = { type = "revolute", between = ["crank.B", "coupler"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker"] }
[initial]
A = { angle = "40 deg" }
coupler = { guess = { angle = "20 deg" } }
"#;

#[test]
fn four_bar_open_and_crossed() {
    let found = assemblies(model(NORTON)).expect("assemblies");
    let names: Vec<&str> = found.assemblies.iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names, ["A-B-C-D open", "A-B-C-D crossed"]);
    let expected = [[20.2979, 57.3249], [-60.9780, -98.0050]];
    for (assembly, angles) in found.assemblies.iter().zip(expected) {
        for (body, angle) in ["coupler.angle", "rocker.angle"].iter().zip(angles) {
            let (_, value, _) =
                assembly.pose.iter().find(|(name, ..)| name == body).expect("an angle");
            assert!(off(*value, f64::to_radians(angle)) < 1e-6, "{body}: {}", value.to_degrees());
        }
    }
}

#[test]
fn rocker_and_transmission_angle_of_the_four_bar() {
    let limits = limits(model(NORTON), &LimitsRequest::default()).expect("limits");
    let branch = &limits.branches[0];
    let range = |name: &str| {
        let range = branch.ranges.iter().find(|range| range.name == name).expect("a range");
        [range.min, range.max].map(f64::to_degrees)
    };
    let close = |found: [f64; 2], expected: [f64; 2]| {
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-4, "{found:?} instead of {expected:?}");
        }
    };
    close(range("rocker.angle"), [54.9004, 128.6822]);
    // From the rocker to the coupler; Norton's angle is the acute one.
    let cranks: Vec<f64> =
        of(branch, "rocker.angle").iter().map(|p| value(p, "crank.angle")).collect();
    for crank in [24.1468, 231.3178_f64] {
        assert!(cranks.iter().any(|c| off(*c, crank.to_radians()) < 2e-6), "{cranks:?}");
    }
}

#[test]
fn types_and_transmission_angles_of_the_four_bar() {
    let request = LimitsRequest {
        drive: Some("crank.angle".to_owned()),
        outputs: vec!["rocker.angle".to_owned()],
        ..LimitsRequest::default()
    };
    let found = limits(model(NORTON), &request).expect("limits");
    let [four_bar] = found.four_bars.as_slice() else { panic!("{:?}", found.four_bars) };
    assert_eq!(four_bar.parts, ["ground", "crank", "coupler", "rocker"]);
    assert_eq!(four_bar.joints, ["A", "B", "C", "D"]);
    for (length, expected) in four_bar.lengths.iter().zip([0.1, 0.04, 0.12, 0.08]) {
        assert!((length - expected).abs() < 1e-15);
    }
    assert!((four_bar.excess - 0.02).abs() < 1e-15, "80 + 100 − 40 − 120 mm");
    assert_eq!((four_bar.barker.number, four_bar.barker.code), (2, "GCRR"));
    assert!(found.slider_cranks.is_empty());

    // cos μ = (b² + c² − (d ∓ a)²) / 2bc, folded and stretched.
    let branch = &found.branches[0];
    let of_c = branch.transmissions.iter().find(|t| t.at == "C").expect("the angle at C");
    let folded =
        ((0.12f64.powi(2) + 0.08f64.powi(2) - 0.06f64.powi(2)) / (2.0 * 0.12 * 0.08)).acos();
    let stretched =
        ((0.12f64.powi(2) + 0.08f64.powi(2) - 0.14f64.powi(2)) / (2.0 * 0.12 * 0.08)).acos();
    let acute = folded.min(stretched.min(std::f64::consts::PI - stretched));
    assert!((of_c.least.angle - acute).abs() < 1e-12, "{}", of_c.least.angle.to_degrees());
    assert!((acute.to_degrees() - 26.3843).abs() < 1e-4);
    assert!((of_c.least.pressure() - (TAU / 4.0 - acute)).abs() < 1e-12);
    assert!(off(value(&of_c.least.pose, "crank.angle"), 0.0) < 1e-9);
    assert!((of_c.greatest.angle - stretched).abs() < 1e-12);
    assert!((stretched.to_degrees() - 86.4167).abs() < 1e-4);
    assert!(off(value(&of_c.greatest.pose, "crank.angle"), TAU / 2.0) < 1e-9);

    // The advantage is the least where the rocker is fastest, and without bound where it turns back.
    let output = &branch.outputs[0];
    let [advantage, drive] = output.least_advantage.expect("an advantage");
    let drives =
        vec![Drive::parse(&model(NORTON), "crank.angle", "0:360 deg:721").expect("a drive")];
    let table = kinematics(model(NORTON), &Prescribed::Drives { drives, through: false });
    let table = table.expect("a table").table;
    let rates = table.column("rocker.rate").expect("rates");
    let sampled = rates.iter().map(|rate| 1.0 / rate.abs()).fold(f64::INFINITY, f64::min);
    assert!(advantage <= sampled && advantage > sampled * (1.0 - 1e-4), "{advantage} {sampled}");
    let nearest =
        (0..rates.len()).min_by(|&a, &b| rates[b].abs().total_cmp(&rates[a].abs())).expect("rows");
    let crank = table.column("crank.angle").expect("angles")[nearest];
    assert!(off(crank, drive) < 0.01);
    let mut dead: Vec<f64> =
        output.dead_points[0].iter().map(|x| x.rem_euclid(TAU).to_degrees()).collect();
    dead.sort_by(f64::total_cmp);
    assert!((dead[0] - 24.1468).abs() < 1e-4 && (dead[1] - 231.3178).abs() < 1e-4, "{dead:?}");
    assert!(output.dead_points[1].is_empty());
}

/// Norton's offset slider-crank, 40, 120 and −20 mm, as a model of guides and as inversions of it.
fn slider_crank(crank: f64, rod: f64, ground: &str) -> String {
    let mut text = format!(
        "[ground]\npoints = {{ O = [0, 0], E = [0, -0.02] }}\n[bodies]\n\
         crank = {{ mass = 1, inertia = 1, points = {{ B = [{crank}, 0] }} }}\n\
         rod = {{ mass = 1, inertia = 1, points = {{ C = [{rod}, 0] }} }}\nslider = {{ mass = 1, inertia = 1 }}\n\
         frame = {{ mass = 1, inertia = 1, points = {{ O = [0, 0], E = [0, -0.02] }} }}\n[joints]\n\
         A = {{ type = \"revolute\", between = [\"frame.O\", \"crank\"] }}\n\
         B = {{ type = \"revolute\", between = [\"crank.B\", \"rod\"] }}\n\
         C = {{ type = \"revolute\", between = [\"rod.C\", \"slider\"] }}\n\
         G = {{ type = \"prismatic\", between = [\"frame.E\", \"slider\"], axis = [1, 0] }}\n\
         F = {{ type = \"weld\", between = [\"ground\", \"{ground}\"] }}\n"
    );
    text.push_str(
        "[initial]\ncrank = { guess = { angle = 1.05 } }\nrod = { guess = { angle = -0.5 } }\n",
    );
    text
}

#[test]
fn slider_cranks_are_told_by_their_inversion() {
    let of = |crank: f64, rod: f64, ground: &str| {
        let found = limits(geometry(&slider_crank(crank, rod, ground)), &LimitsRequest::default());
        let found = found.unwrap_or_else(|error| panic!("{ground}: {error}"));
        assert_eq!(found.slider_cranks.len(), 1, "{ground}");
        (found.slider_cranks[0].clone(), found.branches[0].transmissions.clone())
    };
    let (plain, transmissions) = of(0.04, 0.12, "frame");
    assert_eq!((plain.inversion, plain.turning.as_deref()), ("slider-crank", Some("crank")));
    let lengths = plain.lengths.into_iter().zip([0.04, 0.12]);
    lengths.for_each(|(found, known)| assert!((found - known).abs() < 1e-15, "{found}"));
    assert!((plain.offset - 0.02).abs() < 1e-15 && (plain.excess - 0.06).abs() < 1e-15);
    // The pressure angle is the largest where the crank is across: sin α = (a + e) / b.
    let of_c = transmissions.iter().find(|t| t.at == "C").expect("the angle at C");
    assert!((of_c.least.pressure() - 0.5f64.asin()).abs() < 1e-9, "{}", of_c.least.pressure());
    assert!((of_c.greatest.angle - TAU / 4.0).abs() < 1e-7);

    assert_eq!(of(0.04, 0.12, "crank").0.inversion, "inverted slider-crank, turning guide");
    assert_eq!(of(0.04, 0.12, "rod").0.inversion, "inverted slider-crank, swinging guide");
    assert_eq!(of(0.04, 0.12, "slider").0.inversion, "slider-crank");
    let (tight, _) = of(0.105, 0.12, "frame");
    assert_eq!((tight.rotatability, tight.turning), (Rotatability::NonGrashof, None));
}

/// Jansen's leg, massless links and pins in one place among its parts.
#[test]
fn four_bars_go_over_massless_links() {
    let text = include_str!("../../../../examples/jansen/model.toml");
    let found = limits(geometry(text), &LimitsRequest::default()).expect("limits");
    let mut joints: Vec<[String; 4]> = found.four_bars.iter().map(|f| f.joints.clone()).collect();
    joints.sort();
    // Both links of the crank share a pin, so they close a loop with the upper triangle and the lower link, too.
    assert_eq!(joints.len(), 4, "{joints:?}");
    let first = found.four_bars.iter().find(|f| f.parts.contains(&"j".to_owned())).expect("a loop");
    assert_eq!(first.parts, ["ground", "crank", "j", "upper"]);
    assert_eq!(first.barker.code, "GCRR");
    assert!(found.branches[0].transmissions.iter().any(|t| t.at == "j at upper"));
}

#[test]
fn a_train_of_gears_turns_round_although_it_is_long_until_it_is_back() {
    let train = geometry(
        "[ground]\npoints = { O = [0, 0] }\n\
         [bodies]\nsun = { mass = 1, inertia = 1 }\nplanet = { mass = 1, inertia = 1 }\n\
         arm = { mass = 1, inertia = 1, points = { P = [0.036, 0] } }\n\
         [joints]\nS = { type = \"revolute\", between = [\"ground.O\", \"sun\"] }\n\
         K = { type = \"revolute\", between = [\"ground.O\", \"arm\"] }\n\
         P = { type = \"revolute\", between = [\"arm.P\", \"planet\"] }\n\
         [couplings]\nsp = { type = \"gear\", between = [\"S\", \"P\"], teeth = [20, 16], carrier = \"arm\" }\n\
         pr = { type = \"gear\", between = [\"P\", \"ground.O\"], teeth = [16, 52], internal = true, carrier = \"arm\" }\n\
         [initial]\nS = { angle = 0 }\n",
    );
    let found = limits(train, &LimitsRequest::default()).expect("limits");
    let branch = &found.branches[0];
    for name in ["S.angle", "K.angle", "P.angle", "planet.angle"] {
        let range = branch.ranges.iter().find(|range| range.name == name).expect("a range");
        assert!(range.turns, "{name}: {} to {}", range.min, range.max);
    }
    let x = branch.ranges.iter().find(|range| range.name == "planet.x").expect("a range");
    assert!(!x.turns && (x.max - 0.036).abs() < 1e-9);
    let told: Vec<_> =
        branch.extremes.iter().filter(|extreme| extreme.name == "planet.x").collect();
    assert_eq!(told.len(), 2, "{told:?}");
}

/// A motion that closes is followed once around from the start: its limits are told to either side of it.
#[test]
fn limits_are_told_in_the_turn_of_the_start() {
    // An inverted slider-crank: the lever through (d, 0) turns back where crank and lever are square.
    let (r, d) = (0.12_f64, 0.3_f64);
    for start in [0.2_f64, 3.0, -2.0, 20.0] {
        let text = format!(
            "[ground]\npoints = {{ C = [{d}, 0] }}\n[bodies.crank]\npoints = {{ B = [{r}, 0] }}\n\
             [bodies.lever]\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"crank\"] }}\n\
             C = {{ type = \"revolute\", between = [\"ground.C\", \"lever\"] }}\n\
             S = {{ type = \"slot\", between = [\"lever\", \"crank.B\"], axis = [1, 0] }}\n\
             [initial]\nA = {{ angle = {start} }}\nC = {{ guess = {{ angle = 3.0 }} }}\n"
        );
        let request = LimitsRequest {
            drive: Some("A.angle".to_owned()),
            outputs: vec!["lever.angle".to_owned()],
            ..LimitsRequest::default()
        };
        let found = limits(geometry(&text), &request).expect("limits");
        let branch = &found.branches[0];
        let poses = of(branch, "lever.angle");
        assert_eq!(poses.len(), 2, "from {start}");
        let [output] = branch.outputs.as_slice() else { panic!("one output") };
        let cranks = poses.iter().map(|pose| value(pose, "A.angle"));
        for crank in cranks.clone().chain(output.fastest.iter().map(|fastest| fastest[0])) {
            assert!((crank - start).abs() < TAU / 2.0, "{crank} from {start}");
        }
        for crank in cranks {
            assert!((crank.cos() - r / d).abs() < 1e-10, "{crank}");
        }
        let [chain] = found.slider_cranks.as_slice() else { panic!("one chain") };
        assert_eq!(chain.offset, 0.0);
    }
}

/// A triple rocker: what is told of a transmission angle where it turns back lies in its range.
#[test]
fn transmission_angles_have_one_branch_in_all_tables() {
    let text = "[ground]\npoints = { A = [4.1, 3.75], D = [0.165, 1.322] }\n\
                [bodies]\ncrank = { points = { B = [-2.856, -3.554] } }\n\
                coupler = { points = { C = [0, 0], B = [3.564, 2.489] } }\n\
                rocker = { points = { C = [-2.485, -3.615] } }\n\
                [joints]\njA = { type = \"revolute\", between = [\"ground.A\", \"crank\"] }\n\
                jB = { type = \"revolute\", between = [\"crank.B\", \"coupler.B\"] }\n\
                jC = { type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }\n\
                jD = { type = \"revolute\", between = [\"ground.D\", \"rocker\"] }\n\
                [initial]\ncrank = { guess = { x = 4.1, y = 3.75, angle = 0 } }\n\
                coupler = { guess = { x = -2.32, y = -2.293, angle = 0 } }\n\
                rocker = { guess = { x = 0.165, y = 1.322, angle = 0 } }\n";
    let found = limits(geometry(text), &LimitsRequest::default()).expect("limits");
    let branch = &found.branches[0];
    let mut n_told = 0;
    for range in branch.ranges.iter().filter(|range| range.name.starts_with("transmission ")) {
        assert!(range.min > -TAU / 2.0 - 1e-9 && range.min <= TAU / 2.0 + 1e-9, "{range:?}");
        for extreme in branch.extremes.iter().filter(|extreme| extreme.name == range.name) {
            n_told += 1;
            let is_inside = (range.min - 1e-9..=range.max + 1e-9).contains(&extreme.value);
            assert!(is_inside, "{} of {range:?}", extreme.value);
        }
    }
    assert!(n_told > 0);
}

/// Questions about positions go through stops and contacts, and name them.
#[test]
fn positions_beyond_stops_and_contacts_are_named() {
    let arm = |more: &str| {
        geometry(&format!(
            "[ground]\npoints = {{ P = [-2, -0.8], Q = [2, -0.8] }}\n\
             [bodies.arm]\nmass = 1\npoints = {{ tip = [1, 0] }}\n\
             [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n{more}"
        ))
    };
    let stop = |min: &str, max: &str| {
        format!("[loads.end]\ntype = \"stop\"\njoint = \"O\"\nmin = \"{min}\"\nmax = \"{max}\"\n")
    };
    let floor =
        "[contacts.floor]\nbetween = [{ line = [\"ground.P\", \"ground.Q\"] }, \"arm.tip\"]\n";
    let request = LimitsRequest::default();
    let (near, far) = (stop("-50 deg", "40 deg"), stop("-190 deg", "200 deg"));
    for (more, names) in [
        (near.as_str(), vec!["stop `end`"]),
        (far.as_str(), vec![]),
        (floor, vec!["contact `floor`"]),
    ] {
        let found = limits(arm(more), &request).expect("limits");
        assert_eq!(found.beyond, names, "{more}");
        let curves = curves(arm(more), &CurvesRequest::default()).expect("curves");
        assert_eq!(curves.beyond, names, "{more}");
    }
    // A range that stays before the stop, and one that does not; angles by another turn are before it.
    for (values, names) in [
        ("-45 deg:35 deg:5", vec![]),
        ("-45 deg:45 deg:5", vec!["stop `end`".to_owned()]),
        ("315 deg:395 deg:5", vec![]),
    ] {
        let model = arm(&near);
        let drives = vec![Drive::parse(&model, "O.angle", values).expect("a drive")];
        let found = kinematics(model, &Prescribed::Drives { drives, through: false });
        assert_eq!(found.expect("positions").beyond, names, "{values}");
    }
}
