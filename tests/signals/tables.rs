//! Tables of measured values and cam laws: an engine, splines against their points, ends, followers.

use crate::support::elements::reference;
use crate::support::{Within, close, coordinate, derive, elements, messages, model, solve};
use serde_json::Value;

use bksim::model::file::{Source, read};

/// A single-cylinder engine over one cycle, the gas force linear between 37 rows.
#[test]
fn an_engine_with_a_table_of_gas_force() {
    let data = reference("elements/engine_gas_table");
    let rows = data["rows"].as_array().expect("rows");
    let number = |row: &Value, k: usize| row[k].as_f64().expect("a number");
    let text = elements::text("engine");
    let line = text.lines().find(|line| line.starts_with("t_end")).expect("an end").to_owned();
    // The rows are at angles of the crank, so each has a run that ends there.
    for row in rows.iter().skip(3).step_by(3) {
        let until = format!("t_end = {:?}", number(row, 1));
        let mechanism = derive(model(&text.replace(&line, &until)));
        let motion = solve(&mechanism);
        let last = motion.samples.last().expect("a sample");
        let crank = coordinate(&mechanism, "O_angle");
        let guide = coordinate(&mechanism, "guide_position");
        let within = |absolute: f64| Within { relative: 0.0, absolute };
        close("angle", last.q[crank], number(row, 0), within(1e-9 * 12.6));
        close("speed", last.v[crank], number(row, 2), within(1e-9 * 160.0));
        close("piston", last.q[guide], number(row, 3), within(1e-9 * 0.18));
    }
}

/// A mass that a table of the time pushes: its acceleration is the table.
fn pushed(table: &str) -> String {
    format!(
        "[bodies.m]\nmass = \"1 kg\"\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"m\"]\n\
         axis = [1, 0]\n[tables.push]\nunits = [\"s\", \"N\"]\n{table}\n[loads.push]\ntype = \"force\"\n\
         on = \"m\"\nvector = [\"push(t)\", 0]\n[solve]\nt_end = 3\nevery = 0.5\nrtol = 1e-11\natol = 1e-12\n"
    )
}

#[test]
fn a_table_has_its_points_and_goes_on_as_it_is_told() {
    let points = "points = [[0, 1], [0.5, 4], [1, 2], [2, -3], [2.5, 0]]";
    let cases = [
        ("interpolation = \"linear\"\nextrapolate = \"constant\"", -0.5, 0.0),
        ("interpolation = \"linear\"\nextrapolate = \"linear\"", -0.5, 3.0),
    ];
    for (how, between, beyond) in cases {
        let mechanism = derive(model(&pushed(&format!("{points}\n{how}"))));
        let motion = solve(&mechanism);
        let force = |k: usize| motion.samples[k].a[0];
        let within = Within { relative: 0.0, absolute: 1e-9 };
        for (k, expected) in
            [(0, 1.0), (1, 4.0), (2, 2.0), (3, between), (4, -3.0), (5, 0.0), (6, beyond)]
        {
            close(&format!("{how} at {} s", 0.5 * k as f64), force(k), expected, within);
        }
        // Straight lines: 1.25 + 1.5 − 0.5 − 0.75, and what is beyond.
        close("speed", motion.samples[5].v[0], 1.25 + 1.5 - 0.5 - 0.75, within);
        close("speed", motion.samples[6].v[0], 1.5 + 0.25 * beyond, within);
    }
    // A spline: smooth, through the points, straight beyond them.
    let smooth = derive(model(&pushed(&format!("{points}\nextrapolate = \"linear\""))));
    let motion = solve(&smooth);
    for (k, expected) in [(0, 1.0), (1, 4.0), (2, 2.0), (4, -3.0), (5, 0.0)] {
        let within = Within { relative: 0.0, absolute: 1e-9 };
        close("spline", motion.samples[k].a[0], expected, within);
    }
}

/// A block on a measured spring, which a cam lifts.
const LIFTED: &str = "[bodies.m]\nmass = \"1 kg\"\n[bodies.cam]\ninertia = \"0.1 kg*m^2\"\nmass = \"1 kg\"\n\
     [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"m\"]\naxis = [0, 1]\n\
     [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"cam\"]\n\
     [tables.spring]\nunits = [\"mm\", \"N\"]\npoints = [[-5, 40], [0, 0], [25, -90]]\n\
     [curves.lift]\ntype = \"cam-law\"\nsegments = [\n\
     { rise = \"20 mm\", over = \"180 deg\", law = \"3-4-5\" },\n\
     { return = \"20 mm\", over = \"180 deg\", law = \"3-4-5\" },\n]\n\
     [loads.spring]\ntype = \"force\"\non = \"m\"\nvector = [0, \"spring(S.position)\"]\n\
     [couplings.cam]\ntype = \"relation\"\nrelation = \"S.position - lift(A.angle)\"\n\
     [initial]\nA = { angle = \"30 deg\", rate = \"2 rad/s\" }\n[solve]\nt_end = 1\n";

#[test]
fn equations_call_tables_and_laws_by_their_names_and_tell_them_below() {
    use bksim::mbs::equations::{ReadingForm, functions, proof};
    let mechanism = derive(model(LIFTED));
    let (model, system) = (&mechanism.model, &mechanism.system);
    let written = mechanism.equations();
    let all = [written.equations.clone(), written.constraints.clone()].concat().join("\n");
    for call in ["spring(S_position)", "lift(A_angle)", "lift'(A_angle)"] {
        assert!(all.contains(call), "{call}: {all}");
    }
    assert!(!all.contains("if("), "{all}");
    let form = ReadingForm::grouped(model, system);
    assert!(proof(model, system, &form).derivation.is_equal(), "{all}");
    // Two pieces of either function, which meet in value.
    let pieces = functions(model, &form);
    assert_eq!(pieces.len(), 4, "{pieces:?}");
    for pair in pieces.chunks(2) {
        let border = pair[0].ranges[0][1];
        assert!(border == pair[1].ranges[0][0]);
        let value = |k: usize| {
            let sum = model.pool.sum(pair[k].terms.iter().copied());
            model.pool.evaluate(sum, &|_| Some(border)).expect("one symbol")
        };
        close("at the border", value(0), value(1), Within { relative: 1e-12, absolute: 1e-13 });
    }
    // The motion is that of the law.
    let motion = solve(&mechanism);
    let (angle, height) = (coordinate(&mechanism, "A_angle"), coordinate(&mechanism, "S_position"));
    let u = motion.samples[0].q[angle] / std::f64::consts::PI;
    let law = 0.02 * (10.0 - 15.0 * u + 6.0 * u * u) * u.powi(3);
    close("lift", motion.samples[0].q[height], law, Within { relative: 1e-12, absolute: 1e-14 });
}

#[test]
fn a_monotone_table_turns_a_rotor_towards_where_its_torque_changes_sign() {
    // A motor that drives backwards beyond its speed without load: the rotor comes to that speed from both sides.
    let text = |start: &str| {
        format!(
            "[bodies.rotor]\nmass = 2\ninertia = \"0.02 kg m^2\"\n[joints.A]\ntype = \"revolute\"\n\
             between = [\"ground\", \"rotor\"]\n[tables.motor]\nunits = [\"rad/s\", \"N m\"]\n\
             points = [[-50, 9], [0, 8], [5, 6], [10, 1], [100, -60]]\ninterpolation = \"monotone\"\n\
             [loads.motor]\ntype = \"torque\"\njoint = \"A\"\nvalue = \"motor(A.rate)\"\n[initial]\n\
             A = {{ angle = 0, rate = \"{start} rad/s\" }}\n[solve]\nt_end = 4\nrtol = 1e-10\natol = 1e-12\n"
        )
    };
    let ends = ["-50", "99"].map(|start| {
        let motion = solve(&derive(model(&text(start))));
        let rates: Vec<f64> = motion.samples.iter().map(|sample| sample.v[0]).collect();
        let sense = if start == "-50" { 1.0 } else { -1.0 };
        assert!(rates.windows(2).all(|pair| sense * (pair[1] - pair[0]) >= -1e-9), "from {start}");
        rates[rates.len() - 1]
    });
    assert!((10.0..12.0).contains(&ends[0]), "{ends:?}");
    close("from above", ends[1], ends[0], Within { relative: 1e-6, absolute: 0.0 });
}

#[test]
fn faults_of_tables_name_the_row() {
    let fault = |table: &str| messages(&read(&Source::new(&pushed(table), "pushed")).diagnostics);
    for (table, expected) in [
        ("points = [[0, 1]]", "[M077]"),
        ("points = [[0, 1], [0, 2]]", "row 2 of table `push`"),
        ("points = [[0, 1], [1, 2], [\"1 m\", 2]]", "row 3 of table `push`"),
        ("points = [[0, 1], [1]]", "row 2 of table `push`"),
        ("points = [[0, 1], [1, 2]]\ninterpolation = \"cubic\"", "[M008]"),
        ("points = [[0, 8], [100, 7.5], [110, 6], [120, 0]]", "between rows 1 and 2"),
    ] {
        let found = fault(table);
        assert!(found.contains(expected), "{table}: {found}");
    }
    assert_eq!(fault("points = [[0, 1], [1, 2]]"), "");
    let grid = pushed(
        "points = [[0, 0, 1], [0, 1, 2], [1, 0, 3], [1, 1, 4]]\ninterpolation = \"monotone\"",
    )
    .replace("[\"s\", \"N\"]", "[\"s\", \"s\", \"N\"]");
    let found = messages(&read(&Source::new(&grid, "grid")).diagnostics);
    assert!(found.contains("has two arguments"), "{found}");
}

#[test]
fn a_run_ends_where_the_table_does() {
    let mechanism = derive(model(&pushed("points = [[0, 1], [1, 2]]")));
    let fault = mechanism.solve().expect_err("no value after a second").to_string();
    assert!(fault.contains("the argument of table `push` leaves it at t = 1 s"), "{fault}");
}

/// A follower that a cam law moves: rise over 120°, dwell, return over 150°, dwell; angles are seconds.
fn follower(law: &str, turns: usize) -> String {
    format!(
        "[bodies.m]\nmass = \"1 kg\"\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"m\"]\n\
         axis = [0, 1]\n[curves.lift]\ntype = \"cam-law\"\nturns = {turns}\nsegments = [\n\
         {{ rise = \"20 mm\", over = \"120 deg\", law = \"{law}\" }},\n{{ dwell = \"60 deg\" }},\n\
         {{ return = \"20 mm\", over = \"150 deg\", law = \"{law}\" }},\n{{ dwell = \"30 deg\" }},\n]\n\
         [drives.cam]\njoint = \"S\"\nmotion = \"lift(1 rad/s*t)\"\n\
         [solve]\nt_end = {:?}\nevery = {:?}\nrtol = 1e-10\natol = 1e-12\n",
        2.0 * std::f64::consts::PI * turns as f64,
        std::f64::consts::PI / 18.0
    )
}

#[test]
fn cam_laws_move_their_followers() {
    for (law, file) in [
        ("3-4-5", "cam_law_345"),
        ("cycloidal", "cam_law_cycloidal"),
        ("modified-sine", "cam_law_modsine"),
    ] {
        let data = reference(&format!("elements/{file}"));
        let rows = data["rows"].as_array().expect("rows");
        let number = |row: &Value, k: usize| row[k].as_f64().expect("a number");
        // In every turn as in the first.
        let motion = solve(&derive(model(&follower(law, 6))));
        for turn in 0..6 {
            for (k, row) in rows.iter().enumerate().take(36) {
                let sample = &motion.samples[36 * turn + k];
                let within = |scale: f64| Within { relative: 0.0, absolute: 2e-12 * scale };
                let what = format!("{law} at {} rad of turn {turn}", number(row, 0));
                close(&format!("{what}: s"), sample.q[0], number(row, 1), within(0.02));
                close(&format!("{what}: s′"), sample.v[0], number(row, 2), within(0.02));
                close(&format!("{what}: s″"), sample.a[0], number(row, 3), within(0.1));
            }
        }
    }
}

#[test]
fn all_laws_rise_and_return_without_a_jump() {
    for law in ["4-5-6-7", "harmonic", "modified-trapezoid"] {
        let motion = solve(&derive(model(&follower(law, 1))));
        let heights: Vec<f64> = motion.samples.iter().map(|sample| sample.q[0]).collect();
        let within = Within { relative: 0.0, absolute: 1e-15 };
        close(law, heights[6], 0.01, Within { relative: 1e-12, absolute: 0.0 });
        close(law, heights[12], 0.02, within);
        close(law, heights[18], 0.02, within);
        close(law, heights[33], 0.0, within);
    }
}
