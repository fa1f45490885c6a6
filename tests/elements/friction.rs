//! Friction that follows the reaction of its own joint, against reference motions and statics by hand.

use crate::support::elements::Quantity::{Acceleration, Measure};
use crate::support::elements::{check, check_rows, column, number, reference, text};
use bksim::model::LoadId;
use bksim::sim::hybrid::ChangeKind;

use crate::support::{
    Measures, Within, at, close, coordinate, derive, model, reaction, signal, solve,
};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// The normal force changes along the way. Where it would pull, the reference takes the friction with its sign;
/// a guide that bears on both sides has friction against the motion there too, so that these rows do not count.
#[test]
fn a_slider_on_an_incline() {
    let slope = 30f64.to_radians().cos();
    let columns = [
        ("s", Measure("slope.position", 1.0)),
        ("v", Measure("slope.velocity", 1.0)),
        ("a", Acceleration("block_x", 1.0 / slope)),
    ];
    let data = "elements/slider_incline_rope";
    let normal = column(&reference(data), "N");
    let slider = text("slider-incline-rope");
    for method in ["explicit", "radau"] {
        let text = format!("{slider}method = \"{method}\"\n");
        check_rows(&text, data, &|row| number(row, 0) < 1.45, &columns);
    }
    // The reaction across the slope is the normal force.
    let mechanism = derive(model(&slider));
    let motion = solve(&mechanism);
    for row in reference(data)["rows"].as_array().expect("rows") {
        let t = number(row, 0);
        if t < 1.45 {
            let force = reaction(&mechanism, at(&motion, t), "slope");
            let across = -force[0] * 0.5 + force[1] * slope;
            close("normal force", across.abs(), number(row, normal).abs(), within(1e-6));
        }
    }
}

/// The force across a guide passes zero: friction has a bend there that no step contains, and nothing is repeated.
#[test]
fn a_guide_whose_load_turns_round() {
    let (mu, v0) = (0.3, 10.0);
    for method in ["explicit", "radau"] {
        let text = format!(
            "[bodies.b]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [1, 0]\n\
             [loads.across]\ntype = \"force\"\non = \"b\"\nvector = [0, \"10 - 20*t\"]\n\
             [loads.rub]\ntype = \"friction\"\njoint = \"S\"\nmu = {mu}\n\
             [initial]\nS = {{ position = 0, velocity = {v0} }}\n\
             [solve]\nt_end = 1\nrtol = 1e-9\natol = 1e-11\nmethod = \"{method}\"\n"
        );
        let motion = solve(&derive(model(&text)));
        // v = v₀ − μ ∫ |10 − 20 s| ds, and its integral, at t = 1 s.
        let end = motion.samples.last().expect("a sample");
        close("velocity", end.v[0], v0 - mu * 5.0, within(1e-9));
        close("position", end.q[0], v0 - mu * 2.5, within(1e-9));
        let n_reject = motion.summary.stats.n_reject;
        assert!(method == "radau" || n_reject == 0, "{:?}", motion.summary.stats);
    }
}

/// A joint that bears nothing but what rounding makes has no events without end.
#[test]
fn a_guide_that_bears_nothing() {
    let text = "[bodies.b]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [0.6, 0.8]\n\
         [loads.along]\ntype = \"force\"\non = \"b\"\nvector = [\"6*cos(9*t)\", \"8*cos(9*t)\"]\n\
         [loads.rub]\ntype = \"friction\"\njoint = \"S\"\nmu = 0.3\n\
         [initial]\nS = { position = 0, velocity = 10 }\n[solve]\nt_end = 5\nmethod = \"explicit\"\n";
    let motion = solve(&derive(model(text)));
    let end = motion.samples.last().expect("a sample");
    let expected = 10.0 + 10.0 / 9.0 * f64::sin(45.0);
    close("velocity", end.v[0].hypot(end.v[1]), expected, within(1e-5));
    assert!(motion.summary.driving.is_none(), "{:?}", motion.summary.driving);
    assert!(motion.summary.stats.n_step < 200, "{:?}", motion.summary.stats);
}

/// A sleeve that bears with both ends jams where 2 μ a/l ≥ 1.
#[test]
fn a_sleeve_pushed_off_its_axis() {
    let data = "elements/guide_offset_jam";
    let columns = [
        ("acc", Acceleration("sleeve_y", 1.0)),
        ("v", Measure("column.velocity", 1.0)),
        ("z", Measure("column.position", 1.0)),
    ];
    let sleeve = text("guide-offset");
    for offset in [0.1, 0.25, 0.35] {
        let text = sleeve.replace("a = \"100 mm\"", &format!("a = {offset}"));
        check_rows(&text, data, &|row| number(row, 0) == offset, &columns);
    }
}

/// Gravity drives the screw on its way down, the workpiece stops it.
#[test]
fn a_screw_press() {
    let data = "elements/screw_press";
    let columns = [
        ("x", Measure("guide.position", 1.0)),
        ("v", Measure("guide.velocity", 1.0)),
        ("w", Measure("A.rate", 1.0)),
    ];
    let press = text("screw-press");
    check(&press, data, &columns);
    check(&format!("{press}method = \"radau\"\n"), data, &columns);
    // The workpiece and the thread take all energy.
    let motion = solve(&derive(model(&press)));
    let spent = motion.summary.energy.work;
    let values = &reference(data)["values"];
    let expected =
        ["work_on_piece", "lost_in_thread"].map(|name| values[name].as_f64().expect("J"));
    close("energy", -spent, expected[0] + expected[1], within(1e-7));
}

/// The accelerations at the start of a model, by coordinate.
fn accelerations(text: &str, names: &[&str]) -> Vec<f64> {
    let mechanism = derive(model(text));
    let start = mechanism.start().expect("a start");
    names.iter().map(|name| start.a[coordinate(&mechanism, name)]).collect()
}

/// Three faces rub. With the push that raises the block, and with the one that lets it sink, it goes on as it
/// goes; where it cannot sink by itself it stays.
#[test]
fn a_wedge() {
    let data = reference("elements/wedge");
    let [alpha, raise, lower, locks] =
        ["alpha_deg", "P_raise", "P_lower", "self_locking"].map(|name| column(&data, name));
    let wedge = text("wedge");
    for row in data["rows"].as_array().expect("rows") {
        let what = format!("{} deg", number(row, alpha));
        let text = wedge.replace("alpha = \"15 deg\"", &format!("alpha = \"{what}\""));
        let upwards = |push: f64, speed: f64| {
            let text = text.replace("130 N", &format!("{push:?} N"));
            let text = text.replace("velocity = 0", &format!("velocity = {speed:?}"));
            accelerations(&text, &["block_y"])[0]
        };
        let (raise, lower) = (number(row, raise), number(row, lower));
        close(&format!("{what}, raised"), upwards(raise, 0.1), 0.0, within(1e-9));
        close(&format!("{what}, sinking"), upwards(lower, -0.1), 0.0, within(1e-9));
        assert!(upwards(raise + 1e-5, 0.0) > 0.0, "{what}: does not begin to rise");
        close(&format!("{what}, held"), upwards(raise - 1e-5, 0.0), 0.0, within(1e-12));
        let stays = upwards(0.0, 0.0) > -1e-12;
        assert_eq!(stays, number(row, locks) == 1.0, "{what}: self-locking");
    }
}

/// A wheel on a pin: the circle of friction has the radius r sin(atan μ).
#[test]
fn a_journal() {
    let text = "[bodies.wheel]\nmass = \"3 kg\"\ninertia = \"0.02 kg m^2\"\n\
        [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"wheel\"]\n\
        [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
        [loads.rubbing]\ntype = \"friction\"\njoint = \"A\"\nmu = 0.3\nradius = \"10 mm\"\n\
        [initial]\nA = { angle = 0, rate = \"5 rad/s\" }\n\
        [solve]\nt_end = 2\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n";
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let deceleration = 0.01 * 0.3f64.atan().sin() * 3.0 * 9.81 / 0.02;
    let rate = Measures::new(&mechanism, &["A.rate"]);
    for sample in &motion.samples {
        let expected = (5.0 - deceleration * sample.t).max(0.0);
        close(&format!("rate at {} s", sample.t), rate.at(sample)[0], expected, within(1e-9));
    }
    assert!(deceleration * 2.0 > 5.0, "it comes to rest in the run");
}

/// A screw that its load drives: it sinks with r tan(α − φ) as its lever, and holds where φ ≥ α.
#[test]
fn a_screw_that_locks_itself() {
    let press = text("screw-press").replace("30 rad/s", "0 rad/s");
    let lever = 0.12 / std::f64::consts::TAU;
    let slope: f64 = lever / 0.04;
    for mu in [0.0, 0.08, 0.3, 0.47, 0.48, 0.9] {
        let text = press.replace("mu = 0.08", &format!("mu = {mu}"));
        let found = accelerations(&text, &["A_angle"])[0];
        let arm = 0.04 * (slope.atan() - f64::atan(mu)).tan();
        let expected = (80.0 * 9.81 * arm / (2.5 + 80.0 * lever * arm)).max(0.0);
        close(&format!("mu = {mu}"), found, expected, within(1e-12));
    }
}

/// Static friction below the sliding one counts as that.
#[test]
fn static_friction_below_the_sliding_one() {
    let block = |friction: &str| {
        let text = format!(
            "[bodies.block]\nmass = \"1 kg\"\ninertia = 1\n\
             [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\naxis = [1, 0]\n\
             [loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"4 N\", \"-10 N\"]\n\
             [loads.rubbing]\ntype = \"friction\"\njoint = \"S\"\n{friction}\n[solve]\nt_end = 1\n"
        );
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        Measures::new(&mechanism, &["S.position"]).at(motion.samples.last().expect("a sample"))[0]
    };
    assert_eq!(block("force = \"5 N\"\nstatic = \"3 N\""), 0.0);
    close("slides", block("force = \"3 N\"\nstatic = \"3.5 N\""), 0.5, within(1e-9));
    close("holds", block("mu = 0.5\nstatic = 0.3"), 0.0, within(1e-15));
    close("slides", block("mu = 0.3\nstatic = 0.35"), 0.5, within(1e-9));
}

/// Every pin of a four-bar rubs; each friction is that of the reaction in its own joint, by both methods.
#[test]
fn the_pins_of_a_four_bar() {
    let pins = ["A", "B", "C", "D"];
    let friction = pins.map(|pin| {
        format!(
            "\n[loads.rub_{pin}]\ntype = \"friction\"\njoint = \"{pin}\"\nmu = 0.15\nradius = \"20 mm\"\n"
        )
    });
    let text = crate::support::example_text("four-bar") + &friction.concat();
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let circle = 0.02 * 0.15f64.atan().sin();
    let mut largest: f64 = 0.0;
    for sample in &motion.samples {
        for pin in pins {
            let description = format!("friction `rub_{pin}`");
            let mut multipliers = mechanism.compiled.multipliers.iter();
            let row = multipliers.position(|m| m.description == description).expect("its row");
            let [x, y, ..] = reaction(&mechanism, sample, pin);
            let size = circle * x.hypot(y);
            largest = largest.max(size);
            close(&description, sample.lambda[row].abs(), size, within(1e-9));
        }
    }
    assert!(largest > 0.01, "the pins are loaded: {largest} N m at most");
    let radau = solve(&derive(model(&text.replace("[solve]", "[solve]\nmethod = \"radau\""))));
    let [a, b] = [&motion, &radau].map(|run| run.samples.last().expect("a sample"));
    for (x, y) in a.lambda.iter().zip(&b.lambda) {
        close("multiplier", *y, *x, within(1e-4));
    }
}

/// Without other forces N = m v² κ turns the way, so that v = v₀ e^(−μφ) after a turn of the tangent by φ, on any
/// curve that bends one way: a wire in a plane, and one that lies askew in space.
#[test]
fn a_bead_on_a_wire_loses_its_speed_as_a_rope_its_tension() {
    let wire = |space: &str, axes: &str| {
        format!(
            "{space}[curves.wire]\ntype = \"formula\"\nformula = [\"0.5 m*cos(p)\", \"0.3 m*sin(p)\"]\n{axes}\
             [bodies.bead]\nmass = 2\n\
             [joints.wire]\ntype = \"point-on-curve\"\nbetween = [\"ground.O\", \"bead\"]\ncurve = \"wire\"\n\
             [loads.rub]\ntype = \"friction\"\njoint = \"wire\"\nmu = 0.2\n\
             [initial]\nwire = {{ angle = 0.3, rate = 4 }}\nbead = {{ guess = {{ x = 0.45, y = 0.1 }} }}\n\
             [solve]\nt_end = 2\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n"
        )
    };
    let plane = wire("", "[ground]\npoints = { O = [0, 0] }\n");
    let space = wire(
        "space = \"spatial\"\n",
        "[ground]\npoints = { O = { at = [0, 0, 0], rpy = [\"30 deg\", \"40 deg\", 0] } }\n",
    );
    for text in [plane, space] {
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let measures = Measures::new(&mechanism, &["wire.angle", "wire.rate"]);
        let [angle, speed] = [
            // The tangent is that of a circle, stretched.
            |p: f64| (0.3 * p.cos()).atan2(-0.5 * p.sin()),
            |p: f64| (0.5 * p.sin()).hypot(0.3 * p.cos()),
        ];
        let (mut turned, mut before) = (0.0, angle(0.3));
        for sample in &motion.samples {
            let found = measures.at(sample);
            let now = angle(found[0]);
            turned += (now - before).rem_euclid(std::f64::consts::TAU);
            before = now;
            let expected = 4.0 * speed(0.3) * (-0.2 * turned).exp();
            let what = format!("at {} s", sample.t);
            close(&what, found[1] * speed(found[0]), expected, within(1e-8));
        }
    }
}

/// A bead at rest on a slope stays where the slope is below the friction at rest, and slides where it is above.
#[test]
fn a_bead_on_a_slope_of_a_wire_stays_or_slides() {
    // The slope of the parabola at p is p; `static` is 0.4.
    for (place, rests) in [(0.39, true), (0.41, false)] {
        let text = format!(
            "[curves.wire]\ntype = \"formula\"\nformula = [\"1 m*p\", \"0.5 m*p^2\"]\n\
             [bodies.bead]\nmass = 2\n\
             [joints.wire]\ntype = \"point-on-curve\"\nbetween = [\"ground\", \"bead\"]\ncurve = \"wire\"\n\
             [loads.rub]\ntype = \"friction\"\njoint = \"wire\"\nmu = 0.3\nstatic = 0.4\n\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
             [initial]\nwire = {{ angle = {place}, rate = 0 }}\nbead = {{ guess = {{ x = {place}, y = 0.08 }} }}\n"
        );
        let slope = f64::atan(place);
        let expected = if rests { 0.0 } else { -9.81 * (slope.sin() - 0.3 * slope.cos()) };
        let found = accelerations(&text, &["bead_x"])[0];
        close("along the slope", found / slope.cos(), expected, within(1e-9));
    }
}

/// A collar of 2 kg on a level rod, whose centre of mass is `arm` next to its middle, and a bead on a sloping line.
fn on_a_rod(kind: &str, axis: &str, keys: &str, start: &str) -> String {
    format!(
        "space = \"spatial\"\n[bodies.collar]\nmass = 2\ncom = [0.05, 0, 0]\ninertia = [0.01, 0.02, 0.02]\n\
         [joints.J]\ntype = \"{kind}\"\nbetween = [\"ground\", \"collar\"]\naxis = {axis}\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
         [loads.rub]\ntype = \"friction\"\njoint = \"J\"\nmu = 0.2\n{keys}\n\
         [initial]\nJ = {{ {start} }}\n\
         [solve]\nt_end = 1\nevery = 0.1\nrtol = 1e-11\natol = 1e-12\n"
    )
}

/// μ m g where the collar bears at its middle; of a sleeve the ends bear m g/2 ± m g a/l. It stops and stays.
#[test]
fn a_collar_slides_on_a_rod_and_turns_about_it() {
    let sliding = [("", 1.0), ("length = 0.2", 1.0), ("length = 0.04", 2.0 * 0.05 / 0.04)];
    for (keys, factor) in sliding {
        let keys = format!("of = \"position\"\n{keys}");
        let text = on_a_rod("cylindrical", "[1, 0, 0]", &keys, "position = 0, velocity = 1.5");
        let mechanism = derive(model(&text));
        let velocity = Measures::new(&mechanism, &["J.velocity"]);
        for sample in &solve(&mechanism).samples {
            let expected = (1.5 - 0.2 * 9.81 * factor * sample.t).max(0.0);
            close(
                &format!("{keys} at {} s", sample.t),
                velocity.at(sample)[0],
                expected,
                within(1e-9),
            );
        }
    }
    // About the rod the circle of friction has the radius r sin(atan μ).
    let keys = "of = \"angle\"\nradius = 0.01";
    let text = on_a_rod("cylindrical", "[1, 0, 0]", keys, "angle = 0, rate = 3");
    let mechanism = derive(model(&text));
    let rate = Measures::new(&mechanism, &["J.rate"]);
    for sample in &solve(&mechanism).samples {
        let slowing = 0.01 * 0.2f64.atan().sin() * 2.0 * 9.81 / 0.01;
        let expected = (3.0 - slowing * sample.t).max(0.0);
        close(&format!("turning at {} s", sample.t), rate.at(sample)[0], expected, within(1e-9));
    }
}

/// g (sin α − μ cos α) down a line, and at rest where tan α < μ.
#[test]
fn a_bead_slides_down_a_line_in_space() {
    for slope in [0.19_f64, 0.75] {
        let axis = format!("[1, 0, {:?}]", -slope);
        let text =
            on_a_rod("point-on-line", &axis, "of = \"position\"", "position = 0, velocity = 0");
        let text = text.replace("com = [0.05, 0, 0]\n", "");
        let mechanism = derive(model(&text));
        let position = Measures::new(&mechanism, &["J.position"]);
        let alpha = slope.atan();
        let expected = (9.81 * (alpha.sin() - 0.2 * alpha.cos())).max(0.0);
        for sample in &solve(&mechanism).samples {
            let what = format!("slope {slope} at {} s", sample.t);
            close(&what, position.at(sample)[0], 0.5 * expected * sample.t.powi(2), within(1e-9));
        }
    }
}

/// A block on a table that rises under it: the shoe that it leaves behind on the floor bears nothing, and its friction does not
/// hold against the table that carries the block away, sticking: x = ½ m/s³ (t − 2 s)³ until 0.4 g = 3 m/s³ (t − 2 s).
#[test]
fn friction_of_a_joint_that_bears_nothing_holds_nothing() {
    let text = "[bodies]\ntable = { mass = 1 }\ncart = { mass = 1 }\nshoe1 = { mass = 0 }\nshoe2 = { mass = 0 }\nblock = { mass = 4 }\n\
         [joints]\n\
         c = { type = \"prismatic\", between = [\"ground\", \"cart\"], axis = [1, 0] }\n\
         w = { type = \"prismatic\", between = [\"cart\", \"table\"], axis = [0, 1] }\n\
         floor = { type = \"prismatic\", between = [\"ground\", \"shoe1\"], axis = [1, 0] }\n\
         height = { type = \"prismatic\", between = [\"shoe1\", \"block\"], axis = [0, 1] }\n\
         top = { type = \"prismatic\", between = [\"table\", \"shoe2\"], axis = [1, 0] }\n\
         over = { type = \"prismatic\", between = [\"shoe2\", \"block\"], axis = [0, 1] }\n\
         [drives]\n\
         rise = { joint = \"w\", motion = \"-10 mm + 20 mm/s*t\" }\n\
         forth = { joint = \"c\", motion = \"if(t > 2 s, 0.5 m/s^3*(t - 2 s)^3, 0 m)\" }\n\
         [loads]\n\
         gravity = { type = \"gravity\", acceleration = [0, -9.81] }\n\
         floor = { type = \"stop\", joint = \"height\", min = 0 }\n\
         top = { type = \"stop\", joint = \"over\", min = 0 }\n\
         rub1 = { type = \"friction\", joint = \"floor\", mu = 0.4 }\n\
         rub2 = { type = \"friction\", joint = \"top\", mu = 0.4 }\n\
         [initial]\nblock = { x = 0, y = 0, vx = 0, vy = 0 }\n[solve]\nt_end = 3\nevery = 0.01\n";
    for method in ["auto", "radau"] {
        let mechanism = derive(model(&(text.to_owned() + &format!("method = \"{method}\"\n"))));
        let run = solve(&mechanism);
        assert_eq!(run.summary.t, 3.0, "{method}");
        let x = Measures::new(&mechanism, &["block.x", "block.y"]);
        for (t, expected) in [(2.5, [0.0625, 0.04]), (3.0, [0.5, 0.05])] {
            let found = x.at(at(&run, t));
            let within = Within { relative: 1e-6, absolute: 1e-8 };
            close(&format!("{method}, x at {t} s"), found[0], expected[0], within);
            close(&format!("{method}, y at {t} s"), found[1], expected[1], within);
        }
    }
}

/// A square thread of two starts with a collar, by the numbers of Shigley, *Mechanical Engineering Design*, example 8-1, and
/// flanks that lean by his equation (8-5).
#[test]
fn a_screw_with_a_collar_and_flanks_takes_the_torque_of_shigley() {
    let text = |flank: f64, rate: f64| {
        format!(
            "[ground]\npoints = {{ O = [0, 0, 0] }}\n[bodies.nut]\nmass = 1\ninertia = [0.01, 0.01, 0.01]\n\
             [joints.S]\ntype = \"screw\"\nbetween = [\"ground.O\", \"nut\"]\naxis = [0, 0, 1]\nlead = \"8 mm\"\n\
             [loads]\nthread = {{ type = \"friction\", joint = \"S\", mu = 0.08, radius = \"15 mm\", \
             flank_angle = \"{flank} deg\", collar_mu = 0.08, collar_radius = \"20 mm\" }}\n\
             load = {{ type = \"force\", on = \"nut\", vector = [0, 0, \"-6.4 kN\"] }}\n\
             [drives]\nturn = {{ joint = \"S\", motion = \"{rate} rad/s*t\" }}\n\
             [outputs]\ntorque = \"drives.turn\"\n[solve]\nt_end = 0.1\n"
        )
    };
    let torque = |flank: f64, rate: f64| {
        let mechanism = derive(model(&text(flank, rate)));
        let motion = solve(&mechanism);
        signal(&mechanism, at(&motion, 0.1), "torque")
    };
    close("raising", torque(0.0, 1.0), 26.18, within(0.005));
    close("lowering", -torque(0.0, -1.0), 9.77, within(0.005));
    let (slope, mu) = (0.008 / (std::f64::consts::TAU * 0.015), 0.08 / 14.5_f64.to_radians().cos());
    let collar = 6400.0 * 0.08 * 0.02;
    let raising = 96.0 * (slope + mu) / (1.0 - slope * mu) + collar;
    let lowering = 96.0 * (mu - slope) / (1.0 + slope * mu) + collar;
    close("raising", torque(14.5, 1.0), raising, within(1e-9));
    close("lowering", -torque(14.5, -1.0), lowering, within(1e-9));
}

/// A block is pressed on a wall, then pulled off it: 8 N cos 2t against 3 N of friction. The wall leaves it to the hold of
/// friction, and it slides from cos 2t = −3/8 on.
#[test]
fn friction_takes_over_from_a_stop_that_is_left_and_lets_go_once() {
    let text = "[bodies.block]\nmass = 2\ninertia = 1\n[joints]\n\
         slide = { type = \"prismatic\", between = [\"ground\", \"block\"], axis = [1, 0] }\n[loads]\n\
         wall = { type = \"stop\", joint = \"slide\", max = 0 }\n\
         rub = { type = \"friction\", joint = \"slide\", force = \"3 N\" }\n\
         pull = { type = \"force\", on = \"block\", vector = [\"8 N*cos(2 rad/s*t)\", 0] }\n\
         [initial]\nslide = { position = 0, velocity = 0 }\n[solve]\nt_end = 1.2\nevery = 0.05\nrtol = 1e-10\n";
    let begins = (-0.375_f64).acos() / 2.0;
    for method in ["auto", "radau"] {
        let mechanism = derive(model(&format!("{text}method = \"{method}\"\n")));
        let motion = solve(&mechanism);
        let changes = &motion.summary.changes;
        let kinds: Vec<ChangeKind> = changes.iter().map(|change| change.kind).collect();
        let [wall, rub] = [LoadId(0), LoadId(1)];
        let expected = [ChangeKind::Part(wall), ChangeKind::Stick(rub), ChangeKind::Slide(rub)];
        assert_eq!(kinds, expected, "{method}: {changes:?}");
        close("slides from", changes[2].t, begins, within(1e-8));
        let v = Measures::new(&mechanism, &["slide.velocity"]).at(at(&motion, 1.2))[0];
        let fallen = 2.0 * (2.4_f64.sin() - (2.0 * begins).sin()) + 1.5 * (1.2 - begins);
        close("velocity", v, fallen, within(1e-8));
    }
}
