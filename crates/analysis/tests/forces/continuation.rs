//! Equilibria over a parameter against closed forms, and against equilibria of the model at single values.

use crate::support::model;
use bksim_analysis::{
    BranchPoint, Continuation, PointKind, Range, Stability, statics, statics_over,
};

fn over(text: &str, name: &str, [from, to]: [f64; 2], n: usize) -> Continuation {
    statics_over(model(text), (name, Range { from, to, n }), &[]).expect("equilibria")
}

fn points(found: &Continuation) -> impl Iterator<Item = &BranchPoint> {
    found.branches.iter().flat_map(|branch| &branch.points)
}

fn of_kind(found: &Continuation, kind: PointKind) -> Vec<&BranchPoint> {
    points(found).filter(|point| point.kind == kind).collect()
}

fn measured(point: &BranchPoint, name: &str) -> f64 {
    let known = point.equilibrium.pose.iter().find(|(known, ..)| known == name);
    known.unwrap_or_else(|| panic!("no {name}")).1
}

#[track_caller]
fn assert_close(found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs();
    assert!(off <= tolerance, "{found} for {expected}: off by {off:e}");
}

/// A block on a vertical guide, held aside by a spring: with the load P downwards and the height y,
/// P = k y (l₀/√(b² + y²) − 1), with limit points where b² + y² = (l₀ b²)^(2/3).
#[test]
fn a_truss_snaps_through_at_its_limit_loads() {
    let text = "[parameters]\nP = \"1 N\"\n[ground.points]\nS = [0.6, 0]\n[bodies.block]\nmass = 1\n\
                [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\naxis = [0, 1]\n\
                [loads.spring]\ntype = \"spring\"\nbetween = [\"ground.S\", \"block\"]\nstiffness = 200\nlength = 1\n\
                [loads.P]\ntype = \"force\"\non = \"block\"\nvector = [0, \"-P\"]\n\
                [initial]\nguide = { position = 0.8 }\n";
    let found = over(text, "P", [-60.0, 60.0], 13);
    let (k, l, b): (f64, f64, f64) = (200.0, 1.0, 0.6);
    let load = |y: f64| k * y * (l / b.hypot(y) - 1.0);
    let y = ((l * b * b).powf(2.0 / 3.0) - b * b).sqrt();
    let limits = of_kind(&found, PointKind::Limit);
    assert_eq!(limits.len(), 2, "{limits:?}");
    for limit in &limits {
        let at = measured(limit, "guide.position");
        assert_close(at.abs(), y, 1e-9);
        assert_close(limit.value, load(at), 1e-9);
        assert_eq!(limit.equilibrium.stability, Stability::Neutral);
    }
    assert_eq!(found.branches.len(), 1, "one curve, snapping twice");
    assert!(of_kind(&found, PointKind::Crossing).is_empty());
    let values = of_kind(&found, PointKind::Value);
    for point in &values {
        let at = measured(point, "guide.position");
        assert_close(point.value, load(at), 1e-9);
        let is_stable = at.abs() > y;
        assert_eq!(point.equilibrium.stability == Stability::Stable, is_stable, "{at}");
    }
    // Three equilibria between the limit loads, one beyond them.
    for load_now in (0..13).map(|i| -60.0 + 10.0 * f64::from(i)) {
        let n = values.iter().filter(|point| (point.value - load_now).abs() < 1e-9).count();
        let expected = if load_now.abs() < load(y).abs() { 3 } else { 1 };
        assert_eq!(n, expected, "at {load_now} N");
    }
}

/// A rod on a torsion spring: k θ = m g l sin θ, upright with a branch point at k = m g l.
#[test]
fn an_upright_rod_buckles_at_the_weight_of_its_moment() {
    let text = "[parameters]\nk = \"3 N m/rad\"\n[bodies.rod]\nmass = 1\ninertia = 0.1\ncom = [0, 0.4]\n\
                [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\n\
                [loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
                [loads.s]\ntype = \"torsion\"\njoint = \"A\"\nstiffness = \"k\"\n";
    let found = over(text, "k", [3.0, 5.0], 5);
    let critical = 9.81 * 0.4;
    let crossings = of_kind(&found, PointKind::Crossing);
    assert!(crossings.len() >= 2, "one name on each branch: {crossings:?}");
    for crossing in &crossings {
        assert_close(crossing.value, critical, 1e-7);
        assert_close(measured(crossing, "A.angle"), 0.0, 1e-7);
        assert_eq!(crossing.name.as_deref(), Some("B1"));
    }
    let mut aside = 0;
    for point in of_kind(&found, PointKind::Value) {
        let angle = measured(point, "A.angle");
        assert_close(point.value * angle, critical * angle.sin(), 1e-9);
        if angle.abs() > 1e-6 && angle.abs() < 3.0 {
            aside += 1;
            assert_eq!(
                point.equilibrium.stability,
                Stability::Stable,
                "{angle} at {}",
                point.value
            );
        } else if angle.abs() < 1e-6 {
            assert_eq!(point.equilibrium.stability == Stability::Stable, point.value > critical);
        }
    }
    assert_eq!(aside, 4, "k = 3 and 3.5, to either side");
}

/// Two rods with torsion springs under a load: P l/k = (3 ∓ √5)/2.
#[test]
fn two_rods_buckle_at_both_loads() {
    let text = "[parameters]\nP = \"1 N\"\n\
                [bodies]\nlower = { mass = 0, inertia = 0.1, points = { A = [0, 0], B = [0, 0.5] } }\n\
                upper = { mass = 0, inertia = 0.1, points = { B = [0, 0], C = [0, 0.5] } }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"lower.A\"] }\n\
                B = { type = \"revolute\", between = [\"lower.B\", \"upper.B\"] }\n\
                [loads.a]\ntype = \"torsion\"\njoint = \"A\"\nstiffness = 10\n\
                [loads.b]\ntype = \"torsion\"\njoint = \"B\"\nstiffness = 10\n\
                [loads.P]\ntype = \"force\"\non = \"upper.C\"\nvector = [0, \"-P\"]\n";
    let found = over(text, "P", [0.0, 60.0], 13);
    let mut loads: Vec<f64> = of_kind(&found, PointKind::Crossing)
        .iter()
        .filter(|point| {
            measured(point, "A.angle").abs() < 1e-6 && measured(point, "B.angle").abs() < 1e-6
        })
        .map(|point| point.value)
        .collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    assert_eq!(loads.len(), 2, "{loads:?}");
    for (load, sign) in loads.iter().zip([-1.0, 1.0]) {
        assert_close(*load, 20.0 * (3.0 + sign * 5f64.sqrt()) / 2.0, 1e-6);
    }
}

/// A length of a four-bar varies: at every value the equilibria are those of the model with that length.
#[test]
fn equilibria_over_a_length_are_those_of_each_length() {
    let with = |length: f64| {
        format!(
            "[parameters]\nl = \"{length} m\"\nhalf = \"l/2\"\n[ground.points]\nD = [0.1, 0]\n\
             [bodies.crank]\nmass = 0.3\ninertia = 1e-4\ncom = [0.02, 0]\npoints = {{ B = [0.04, 0] }}\n\
             [bodies.coupler]\nmass = 0.5\ninertia = 1e-4\ncom = [\"half\", 0]\npoints = {{ B = [0, 0], C = [\"l\", 0] }}\n\
             [bodies.rocker]\nmass = 0.4\ninertia = 1e-4\ncom = [0.04, 0]\npoints = {{ C = [0.08, 0] }}\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"crank\"] }}\n\
             B = {{ type = \"revolute\", between = [\"crank.B\", \"coupler.B\"] }}\n\
             C = {{ type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }}\n\
             D = {{ type = \"revolute\", between = [\"ground.D\", \"rocker\"] }}\n\
             [loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
             [loads.s]\ntype = \"torsion\"\njoint = \"D\"\nstiffness = 0.4\nangle = 1.2\n\
             [initial]\nA = {{ angle = 0.7 }}\nrocker = {{ guess = {{ angle = 1.0 }} }}\n"
        )
    };
    let found = over(&with(0.12), "l", [0.11, 0.13], 5);
    let values = of_kind(&found, PointKind::Value);
    assert!(!values.is_empty());
    for k in 0..5 {
        let length = 0.11 * (1.0 - f64::from(k) / 4.0) + 0.13 * f64::from(k) / 4.0;
        let alone = statics(model(&with(length)), &[], &[]).expect("equilibria");
        let own: Vec<_> = values.iter().filter(|p| (p.value - length).abs() < 1e-12).collect();
        assert_eq!(own.len(), alone.equilibria.len(), "at {length} m");
        for expected in &alone.equilibria {
            let angle = |pose: &[(String, f64, &str)]| {
                pose.iter().find(|(name, ..)| name == "A.angle").expect("an angle").1
            };
            let tau = std::f64::consts::TAU;
            let off = |p: &&&BranchPoint| {
                let off = angle(&p.equilibrium.pose) - angle(&expected.pose);
                (off - tau * (off / tau).round()).abs()
            };
            let nearest = own.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("one");
            assert_close(off(nearest), 0.0, 1e-9);
            assert_eq!(nearest.equilibrium.stability, expected.stability);
            let (a, b) = (&nearest.equilibrium.reactions, &expected.reactions);
            for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
                assert_close(*a, *b, 1e-7);
            }
        }
    }
}

fn balanced_value(text: &str, names: &[&str]) -> Result<Vec<f64>, String> {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let found = bksim_analysis::balanced(model(text), &names, &[]).map_err(|e| e.to_string())?;
    Ok(found.values.iter().map(|(_, value, _)| *value).collect())
}

/// A lever at 30°: the spring of stiffness k from a point above, m g c cos φ = k × lever × stretch.
#[test]
fn a_stiffness_a_mass_and_a_length_balance_a_lever() {
    let text = "[parameters]\nk = 50\nm = 2\nl0 = 0.1\na = 0.3\n[ground.points]\nS = [0, 0.5]\n\
                [bodies.lever]\nmass = \"m\"\ninertia = 0.1\ncom = [0.4, 0]\npoints = { S = [\"a\", 0] }\n\
                [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"lever\"]\n\
                [loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
                [loads.s]\ntype = \"spring\"\nbetween = [\"ground.S\", \"lever.S\"]\nstiffness = \"k\"\nlength = \"l0\"\n\
                [initial]\nA = { angle = 0.5 }\n";
    // The moment of the spring about the pin, per stiffness, as a function of its free length and arm.
    let moment = |l0: f64, a: f64| {
        let (x, y) = (a * 0.5f64.cos(), a * 0.5f64.sin());
        let long = x.hypot(0.5 - y);
        (1.0 - l0 / long) * x * 0.5
    };
    let weight = 9.81 * 0.4 * 0.5f64.cos();
    let k = balanced_value(text, &["k"]).expect("a stiffness")[0];
    assert_close(k, 2.0 * weight / moment(0.1, 0.3), 1e-9 * k);
    let m = balanced_value(text, &["m"]).expect("a mass")[0];
    assert_close(m, 50.0 * moment(0.1, 0.3) / weight, 1e-10);
    // Lengths are not linear in the balance.
    let stiff = text.replace("k = 50", "k = 150");
    let l0 = balanced_value(&stiff, &["l0"]).expect("a length")[0];
    assert_close(150.0 * moment(l0, 0.3), 2.0 * weight, 1e-9);
    let a = balanced_value(&stiff, &["a"]).expect("an arm")[0];
    assert_close(150.0 * moment(0.1, a), 2.0 * weight, 1e-8);
    let refused = balanced_value(text, &["k", "m"]).expect_err("two unknowns");
    assert_eq!(refused, "2 unknowns cannot balance 1 free motion");
}

/// Two rods: the stiffness of each torsion spring follows from the moment of what hangs on it.
#[test]
fn two_stiffnesses_balance_two_free_motions() {
    let text = "[parameters]\nka = 1\nkb = 1\n\
                [bodies]\nupper = { mass = 2, inertia = 0.1, com = [0.3, 0], points = { B = [0.6, 0] } }\n\
                lower = { mass = 1, inertia = 0.1, com = [0.2, 0] }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"upper\"] }\n\
                B = { type = \"revolute\", between = [\"upper.B\", \"lower\"] }\n\
                [loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
                [loads.a]\ntype = \"torsion\"\njoint = \"A\"\nstiffness = \"ka\"\nangle = 0.5\n\
                [loads.b]\ntype = \"torsion\"\njoint = \"B\"\nstiffness = \"kb\"\nangle = 0.9\n\
                [initial]\nA = { angle = -0.2 }\nB = { angle = 0.3 }\n";
    let found = balanced_value(text, &["ka", "kb"]).expect("two stiffnesses");
    let on_b = 9.81 * 0.2 * 0.1f64.cos();
    let on_a = 9.81 * (2.0 * 0.3 + 0.6) * 0.2f64.cos() + on_b;
    assert_close(found[0], on_a / 0.7, 1e-8);
    assert_close(found[1], on_b / 0.6, 1e-8);
}

/// A rod balanced by a spring of no free length: at k = m g c/(a h) every pose is in balance, and no limit point is told.
#[test]
fn a_value_that_balances_all_poses_is_no_limit_point() {
    let text = "[parameters]\nk = 30\n[ground.points]\nS = [0, 0.5]\n\
                [bodies.rod]\nmass = 2\ninertia = 0.1\ncom = [0.4, 0]\npoints = { S = [0.3, 0] }\n\
                [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\n\
                [loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
                [loads.s]\ntype = \"spring\"\nbetween = [\"ground.S\", \"rod.S\"]\nstiffness = \"k\"\nlength = 0\n\
                [initial]\nA = { angle = 0.5 }\n";
    let balanced = 2.0 * 9.81 * 0.4 / (0.3 * 0.5);
    let found = over(text, "k", [40.0, 60.0], 5);
    assert!(of_kind(&found, PointKind::Limit).is_empty());
    let crossings = of_kind(&found, PointKind::Crossing);
    assert!(!crossings.is_empty());
    for crossing in crossings {
        assert_close(crossing.value, balanced, 1e-6);
    }
    assert_close(balanced_value(text, &["k"]).expect("a stiffness")[0], balanced, 1e-9);
}

#[test]
fn radians_in_the_unit_of_a_range_are_numbers() {
    let read = |text: &str, si: &str| Range::parse(text, si).map(|range| range.to);
    assert_eq!(read("8:20 rad/s:7", "1/s"), Ok(20.0));
    assert_eq!(read("8:20 1/s:7", "rad/s"), Ok(20.0));
    assert_eq!(read("0:2 N m/rad", "N m"), Ok(2.0));
    assert_eq!(read("0:2 rad", ""), Ok(2.0));
    assert!(read("8:20 m/s", "1/s").is_err() && read("1 kg", "").is_err());
}
