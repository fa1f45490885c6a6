//! Equilibria against references of 15 digits.

use crate::support::{Problem, difference, model};
use bksim_analysis::{About, Channels, Stability, linearize, statics};

/// Finds the equilibria of the reference, all and no other.
fn has_these(name: &str) {
    let problem = Problem::load(name);
    let found = statics(problem.model(), &["crank.angle".to_owned()], &[]).expect("equilibria");
    let (columns, mut rows) = (problem.columns(), problem.rows());
    assert!(found.is_complete, "all of the assembly");
    assert_eq!(found.equilibria.len(), rows.len(), "{name}");
    let table = found.table();
    let angle = |q: f64| q.rem_euclid(std::f64::consts::TAU);
    let crank = columns.iter().position(|c| c == "crank.angle").expect("a crank");
    let own = table.column("crank.angle").expect("a crank");
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|&a, &b| angle(own[a]).total_cmp(&angle(own[b])));
    rows.sort_by(|a, b| angle(a[crank]).total_cmp(&angle(b[crank])));
    for (k, column) in columns.iter().enumerate() {
        let expected: Vec<f64> = rows.iter().map(|row| row[k]).collect();
        if column == "stable" {
            let stable = |&i: &usize| {
                f64::from(u8::from(found.equilibria[i].stability == Stability::Stable))
            };
            assert_eq!(order.iter().map(stable).collect::<Vec<_>>(), expected);
            continue;
        }
        // The guide's normal force acts along y, its axis being x.
        let own_name = match column.as_str() {
            "guide.N" => "guide.fy".to_owned(),
            "guide.M" => "guide.mz".to_owned(),
            name => name.replace(".F", ".f").replace(".M", ".m"),
        };
        let values = table.column(&own_name).unwrap_or_else(|| panic!("no column {own_name}"));
        let values: Vec<f64> = order.iter().map(|&i| values[i]).collect();
        // Reactions are compared with the largest of all.
        let largest = if expected.iter().all(|e| e.abs() < 1e-9) { 1e4 } else { 1.0 };
        let off =
            difference(&values, &expected, column.rsplit('.').next() == Some("angle")) / largest;
        assert!(off < 1e-9, "{column} differs by {off:e}: {values:?} against {expected:?}");
    }
}

#[test]
fn toggle_clamp() {
    has_these("eq-toggle-clamp");
}

#[test]
fn four_bar_with_torsion_springs() {
    has_these("eq-four-bar-torsion");
}

/// A body on a ball joint between springs: both quaternions of a pose are one equilibrium.
#[test]
fn a_quaternion_and_its_opposite_are_one_equilibrium() {
    let text = "space = \"spatial\"\n[ground.points]\nS = [1, 0, -0.5]\nT = [0.1, 1, 0]\n\
                [bodies.bob]\nmass = 1\ninertia = [0.02, 0.03, 0.04]\ncom = [0, 0, -0.5]\n\
                points = { S = [0.2, 0, -0.5], T = [0, 0.4, -0.1] }\n\
                [joints.ball]\ntype = \"spherical\"\nbetween = [\"ground\", \"bob\"]\n\
                [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
                [loads.s]\ntype = \"spring\"\nbetween = [\"ground.S\", \"bob.S\"]\nstiffness = 2\nlength = 0.3\n\
                [loads.t]\ntype = \"spring\"\nbetween = [\"ground.T\", \"bob.T\"]\nstiffness = 3\nlength = 0.2\n";
    let found = statics(model(text), &[], &[]).expect("equilibria");
    let poses: Vec<&[f64]> = found.equilibria.iter().map(|e| e.q.as_slice()).collect();
    assert!(poses.len() >= 2, "{poses:?}");
    for (k, a) in poses.iter().enumerate() {
        assert!((a.iter().map(|e| e * e).sum::<f64>() - 1.0).abs() < 1e-9);
        for b in &poses[..k] {
            let cosine: f64 = a.iter().zip(*b).map(|(a, b)| a * b).sum();
            assert!(cosine.abs() < 1.0 - 1e-9, "{a:?} and {b:?} are one");
        }
    }
    assert_eq!(found.equilibria.iter().filter(|e| e.stability == Stability::Stable).count(), 1);
}

/// A pendulum that starts where it hangs: the work of its weight is a rounding there, of one sign or the other after a
/// turn.
#[test]
fn an_equilibrium_in_the_start_is_found() {
    for degrees in [-90, 90, 270, 450] {
        let text = format!(
            "[bodies.rod]\nmass = 2\ninertia = 1\ncom = [0.7, 0]\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"rod\"] }}\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
             [initial]\nA = {{ angle = \"{degrees} deg\" }}\n"
        );
        let found = statics(model(&text), &[], &[]).expect("equilibria");
        let mut stabilities: Vec<_> = found.equilibria.iter().map(|e| e.stability).collect();
        stabilities.sort_by_key(|stability| *stability == Stability::Unstable);
        assert_eq!(stabilities, [Stability::Stable, Stability::Unstable], "{degrees}");
    }
}

#[test]
fn an_equilibrium_lies_on_a_branch_that_the_start_does_not_take() {
    // A weight of 10 N comes to rest 0.1 m into a buffer that begins at 1 m, and so it is told from the other side.
    for start in ["0", "3"] {
        let buffer = model(&format!(
            r#"
            [bodies.weight]
            mass = 1
            inertia = 0
            [joints.guide]
            type = "prismatic"
            between = ["ground", "weight"]
            axis = [1, 0]
            coordinate = "x"
            [loads.both]
            type = "force"
            on = "weight"
            vector = ["10 + if(x > 1, -100*(x - 1), 0)", 0]
            [initial]
            x = {start}
            "#
        ));
        let found = statics(buffer, &[], &[]).expect("an equilibrium");
        let places = found.table().column("x").expect("a position");
        assert!(places.len() == 1 && (places[0] - 1.1).abs() < 1e-9, "from {start}: {places:?}");
        assert_eq!(found.equilibria[0].stability, Stability::Stable);
    }
}

/// Rods that hang in a row, each with its weight at its end.
#[test]
fn equilibria_are_told_in_the_turn_of_the_start() {
    for n_rods in [1, 2] {
        for degrees in [-300.0_f64, 40.0, 80.0, 89.0, 200.0, 700.0] {
            let mut text =
                "[loads]\ng = { type = \"gravity\", acceleration = [0, -9.81] }\n".to_owned();
            for k in 0..n_rods {
                let before = if k == 0 { "ground".to_owned() } else { format!("rod{}.end", k - 1) };
                text.extend([format!(
                    "[bodies.rod{k}]\nmass = 1\ninertia = 0\ncom = [1, 0]\npoints = {{ end = [1, 0] }}\n\
                     [joints.J{k}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"rod{k}\"]\n\
                     [initial.J{k}]\nangle = \"{} deg\"\n",
                    if k == 0 { degrees } else { 0.0 }
                )]);
            }
            let found = statics(model(&text), &[], &[]).expect("equilibria");
            assert_eq!(found.equilibria.len(), 1 << n_rods, "from {degrees}");
            let angles = found.table().column("J0.angle").expect("angles");
            for angle in angles.iter().map(|angle| angle.to_degrees()) {
                assert!((angle - degrees).abs() < 180.0, "{angle} from {degrees}");
                assert!((angle.rem_euclid(180.0) - 90.0).abs() < 1e-6, "{angle}");
            }
        }
    }
}

/// A weight on a crank that a torsion spring turns back: k (θ − θ₀) + m g l cos θ = 0 has roots in several turns.
#[test]
fn equilibria_lie_in_every_turn_that_a_torsion_spring_counts() {
    let rod = |spring: &str| {
        model(&format!(
            "[bodies.rod]\nmass = 2\ninertia = 1\ncom = [0.5, 0]\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"rod\"] }}\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -10] }}\n{spring}\n\
             [initial]\nA = {{ angle = 0.4 }}\n"
        ))
    };
    for (k, start) in [(0.7, 0.3), (2.5, 9.0), (40.0, -30.0)] {
        let spring = format!(
            "[loads.s]\ntype = \"torsion\"\njoint = \"A\"\nstiffness = {k}\nangle = {start}"
        );
        let found = statics(rod(&spring), &[], &[]).expect("equilibria");
        assert!(found.is_complete);

        // Roots between |θ − θ₀| = m g l / k by bisection on a fine grid.
        let moment = |angle: f64| k * (angle - start) + 10.0 * angle.cos();
        let reach = 10.0 / k + 0.1;
        let grid = |i: u32| start - reach + 2.0 * reach * f64::from(i) / 20_000.0;
        let mut expected = Vec::new();
        for i in 0..20_000 {
            let (mut low, mut high) = (grid(i), grid(i + 1));
            if moment(low) * moment(high) > 0.0 {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if moment(low) * moment(middle) > 0.0 { low = middle } else { high = middle }
            }
            expected.push(low);
        }
        let mut angles = found.table().column("A.angle").expect("angles");
        angles.sort_by(f64::total_cmp);
        assert_eq!(angles.len(), expected.len(), "{k}: {angles:?} against {expected:?}");
        for (own, expected) in angles.iter().zip(&expected) {
            assert!((own - expected).abs() < 1e-10, "{own} against {expected}");
        }

        // The one that is nearest to the start, turns counted, of those where the moment falls: k > m g l sin θ.
        let stable = expected.iter().filter(|&&angle| k > 10.0 * angle.sin());
        let near = stable.min_by(|a, b| (*a - 0.4).abs().total_cmp(&(*b - 0.4).abs()));
        let about = linearize(rod(&spring), About::Stable, &Channels::default()).expect("a system");
        let angle = about.pose.iter().find(|(name, ..)| name == "A.angle").expect("a pose").1;
        assert!((angle - near.expect("a stable one")).abs() < 1e-10, "{angle} against {near:?}");
    }

    // A torque that grows otherwise from turn to turn: what it does beyond is not known.
    let cubic = "[loads.s]\ntype = \"torque\"\njoint = \"A\"\nvalue = \"-0.3 N m*A.angle^3\"";
    assert!(!statics(rod(cubic), &[], &[]).expect("equilibria").is_complete);
}

/// A bar of mass m with its centre of mass at the distance c, whose angle `stop` limits.
fn bar_on_a_stop(start: &str, stop: &str) -> bksim_analysis::Statics {
    let text = format!(
        "[bodies.bar]\nmass = 3\ninertia = 1\ncom = [0.8, 0]\n\
         [joints]\nhinge = {{ type = \"revolute\", between = [\"ground\", \"bar\"] }}\n\
         [loads]\ng = {{ type = \"gravity\", acceleration = [0, -10] }}\n\
         end = {{ type = \"stop\", joint = \"hinge\", {stop} }}\n\
         [initial]\nhinge = {{ angle = \"{start}\" }}\n"
    );
    statics(model(&text), &["hinge.angle".to_owned()], &[]).expect("equilibria")
}

/// Angles of equilibria in degrees, with the moments of the stop that they are on.
fn rests(found: &bksim_analysis::Statics) -> Vec<(f64, Option<f64>)> {
    let angles = found.table().column("hinge.angle").expect("angles");
    let efforts = found.equilibria.iter().map(|e| e.bearing.first().map(|stop| stop.effort));
    angles.iter().map(|angle| angle.to_degrees()).zip(efforts).collect()
}

#[test]
fn a_bar_rests_on_the_stop_that_its_weight_presses_on() {
    // m g c cos θ turns it back; the lower stop pushes with that moment, the upper one would have to pull.
    let found = bar_on_a_stop("10 deg", "min = \"-60 deg\", max = \"30 deg\"");
    assert!(found.is_complete);
    let rests_at = rests(&found);
    assert_eq!(rests_at.len(), 1, "{rests_at:?}");
    let (angle, effort) = rests_at[0];
    let moment = 3.0 * 10.0 * 0.8 * f64::cos((-60_f64).to_radians());
    assert!((angle + 60.0).abs() < 1e-9, "{angle}");
    assert!((effort.expect("an effort") - moment).abs() < 1e-9 * moment, "{effort:?}");
    let stop = &found.equilibria[0].bearing[0];
    assert_eq!((stop.name.as_str(), stop.limit, stop.unit), ("end", "min", "N*m"));
    assert_eq!(found.equilibria[0].stability, Stability::Stable);
    // The joint takes the whole weight, as the stop gives a moment alone.
    let weight = found.table().column("hinge.fy").expect("a reaction");
    assert!((weight[0] - 30.0).abs() < 1e-9, "{weight:?}");
    assert_eq!(found.table().column("end.min").expect("an effort"), [effort.expect("an effort")]);
    // Hanging and standing lie beyond.
    let beyond = found.left_out.iter().map(|e| (e.stability, e.beyond[0].limit, e.beyond[0].depth));
    let beyond: Vec<_> = beyond.map(|(s, limit, depth)| (s, limit, depth.to_degrees())).collect();
    let [(Stability::Unstable, "max", up), (Stability::Stable, "min", down)] = beyond[..] else {
        panic!("{beyond:?}")
    };
    assert!((up - 60.0).abs() < 1e-6 && (down - 30.0).abs() < 1e-6, "{up}, {down}");

    // Between stops on both sides of the upright, the bar leans on either.
    let found = bar_on_a_stop("80 deg", "min = \"70 deg\", max = \"140 deg\"");
    let mut rests_at = rests(&found);
    rests_at.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(left, Some(a)), (up, None), (right, Some(b))] = rests_at[..] else {
        panic!("{rests_at:?}")
    };
    assert!((left - 70.0).abs() < 1e-9 && (right - 140.0).abs() < 1e-9, "{left}, {right}");
    assert!((up - 90.0).abs() < 1e-9, "{up}");
    assert!((a - 24.0 * f64::cos(70_f64.to_radians())).abs() < 1e-9, "{a}");
    assert!((b + 24.0 * f64::cos(140_f64.to_radians())).abs() < 1e-9, "{b}");
    assert_eq!(found.left_out.len(), 1);
}

#[test]
fn stops_count_whole_turns() {
    // It may hang at 270° alone, though -90° is nearer to the start.
    let found = bar_on_a_stop("0 deg", "min = \"-80 deg\", max = \"300 deg\"");
    let mut rests_at = rests(&found);
    rests_at.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(low, Some(_)), (up, None), (down, None)] = rests_at[..] else { panic!("{rests_at:?}") };
    assert!((low + 80.0).abs() < 1e-9 && (up - 90.0).abs() < 1e-9, "{low}, {up}");
    assert!((down - 270.0).abs() < 1e-9, "{down}");
    assert!(found.left_out.is_empty());

    // A stop turns further on.
    let found = bar_on_a_stop("750 deg", "min = \"700 deg\", max = \"760 deg\"");
    let rests_at = rests(&found);
    let [(angle, Some(moment))] = rests_at[..] else { panic!("{rests_at:?}") };
    assert!((angle - 700.0).abs() < 1e-9, "{angle}");
    assert!((moment - 24.0 * f64::cos(20_f64.to_radians())).abs() < 1e-9, "{moment}");
}

#[test]
fn a_weight_that_only_a_stop_holds_rests_on_it() {
    let text = "[bodies.weight]\nmass = 2\n[joints.guide]\ntype = \"prismatic\"\n\
                between = [\"ground\", \"weight\"]\naxis = [0, 1]\n\
                [loads]\ng = { type = \"gravity\", acceleration = [0, -10] }\n\
                floor = { type = \"stop\", joint = \"guide\", min = -0.4 }\n";
    let found = statics(model(text), &[], &[]).expect("a rest");
    assert_eq!(found.table().column("guide.position").expect("a position").len(), 1);
    let rest = &found.equilibria[0];
    assert!((rest.q[0] + 0.4).abs() < 1e-9, "{:?}", rest.q);
    assert_eq!((rest.bearing[0].limit, rest.bearing[0].unit), ("min", "N"));
    assert!((rest.bearing[0].effort - 20.0).abs() < 1e-9, "{:?}", rest.bearing);
    assert!(rest.pose.iter().any(|(name, ..)| name == "guide.position"));

    // Small motions have nothing to be about.
    let fault = linearize(model(text), About::Static, &Channels::default()).expect_err("no motion");
    assert_eq!(fault.to_string(), "no equilibrium lies before stop `floor`");
}

/// Two bars in a row: the second one hangs, and the first one lies on its stop.
#[test]
fn one_of_two_free_motions_rests_on_a_stop() {
    let text = "[bodies.first]\nmass = 2\ninertia = 0\ncom = [0.5, 0]\npoints = { end = [1, 0] }\n\
                [bodies.second]\nmass = 1\ninertia = 0\ncom = [0.3, 0]\n\
                [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"first\"]\n\
                [joints.B]\ntype = \"revolute\"\nbetween = [\"first.end\", \"second\"]\n\
                [loads]\ng = { type = \"gravity\", acceleration = [0, -10] }\n\
                end = { type = \"stop\", joint = \"A\", min = \"-30 deg\", max = \"60 deg\" }\n\
                [initial]\nA = { angle = \"20 deg\" }\n";
    let found = statics(model(text), &[], &[]).expect("equilibria");
    // The weights turn the first one down, wherever the second one stands.
    let moment = (2.0 * 10.0 * 0.5 + 10.0) * f64::cos(30_f64.to_radians());
    let mut turned: Vec<(f64, Stability)> = Vec::new();
    for rest in &found.equilibria {
        let value = |name: &str| rest.pose.iter().find(|(own, ..)| own == name).expect(name).1;
        assert_eq!(rest.bearing[0].limit, "min");
        assert!((value("A.angle").to_degrees() + 30.0).abs() < 1e-9);
        assert!((rest.bearing[0].effort - moment).abs() < 1e-9, "{:?}", rest.bearing);
        turned.push((value("second.angle").to_degrees().rem_euclid(360.0), rest.stability));
    }
    turned.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(up, Stability::Unstable), (down, Stability::Stable)] = turned[..] else {
        panic!("{turned:?}")
    };
    assert!((up - 90.0).abs() < 1e-6 && (down - 270.0).abs() < 1e-6, "{up}, {down}");
    // The first one neither stands nor hangs.
    assert_eq!((found.equilibria.len(), found.left_out.len()), (2, 4));
}

#[test]
fn what_friction_alone_could_hold_is_refused_with_the_friction_by_name() {
    // A block on a slope of 3 in 4 with a friction coefficient of 0.9.
    let slope = |velocity: &str| {
        format!(
            r#"
            [bodies.block]
            mass = "1 kg"
            [joints]
            slope = {{ type = "prismatic", between = ["ground", "block"], axis = [4, -3] }}
            [initial]
            slope = {{ velocity = "{velocity}" }}
            [loads]
            gravity = {{ type = "gravity", acceleration = [0, "-9.81 m/s^2"] }}
            rub = {{ type = "friction", joint = "slope", mu = 0.9 }}
            "#
        )
    };
    let found = |velocity: &str| statics(model(&slope(velocity)), &[], &[]);
    let fault = found("0.1 m/s").expect_err("it slides").to_string();
    assert!(fault.contains("without friction `rub`"), "{fault}");
    assert_eq!(found("0 m/s").expect("it sticks").equilibria.len(), 1);
}

/// A mass on a spring of 100 N/m, with a load that depends on a rate: where nothing moves, conditions are as written.
#[test]
fn loads_that_switch_by_a_rate_are_as_written_at_rest() {
    let cases = [
        ("if(b.vx > 0, 10, 0)", 0.0),
        ("if(b.vx >= 0, 10, 0)", 0.1),
        ("if(S.velocity > 0, 5, -5)", -0.05),
        ("if(S.velocity > 0, 10, 0) + if(S.velocity < 0, -20, 0)", 0.0),
        ("if(S.velocity > 0, 10, 2) + if(S.velocity >= 0, 3, 0)", 0.05),
        ("2 + 10*sign(S.velocity)", 0.02),
        ("if(S.position < 0.5 and S.velocity < 0, 10, 0)", 0.0),
    ];
    for (force, expected) in cases {
        for axis in ["[1, 0]", "[\"cos(20 deg)\", \"sin(20 deg)\"]"] {
            let text = format!(
                "[bodies.b]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = {axis}\n\
                 [loads]\nk = {{ type = \"spring\", joint = \"S\", stiffness = 100, length = 0 }}\n\
                 f = {{ type = \"force\", on = \"b\", vector = [\"({force})*cos(0)\", 0] }}\n"
            );
            let expected = expected * if axis == "[1, 0]" { 1.0 } else { 20f64.to_radians().cos() };
            let found = statics(model(&text), &[], &[]).expect("an equilibrium");
            let places = found.table().column("S.position").expect("a position");
            assert_eq!(places.len(), 1, "{force}: {places:?}");
            assert!((places[0] - expected).abs() < 1e-12, "{force}: {places:?}");
            // What the guide bears is that of the same force.
            let across = -found.equilibria[0].reactions[0][0];
            let along =
                100.0 * expected / if axis == "[1, 0]" { 1.0 } else { 20f64.to_radians().cos() };
            let bears =
                if axis == "[1, 0]" { 0.0 } else { along * 20f64.to_radians().sin().powi(2) };
            assert!((across - bears).abs() < 1e-9, "{force}: {across} and {bears}");
        }
    }
}
