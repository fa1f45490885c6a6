//! Conditions on rates: blades, wheels and balls against reference motions, in every formulation and by linear equations.

use bksim::analysis::{About, Channels, linearize};

use crate::support::elements::{check_outputs, reference, touch_text};
use crate::support::{Within, at, close, derive, messages, model, signal, solve};
use bksim::model::file::{Source, read};
use bksim::sim::mobility::mobility;
use serde_json::Value;

#[test]
fn a_skate_drifts_across_its_slope() {
    let columns = ["x", "y", "phi", "v"];
    let with_force = [&columns[..], &["side"]].concat();
    check_outputs(&touch_text("skate"), "skate", &|_| true, &with_force);
    check_outputs(&touch_text("skate-by-rate"), "skate", &|_| true, &columns);
}

#[test]
fn every_formulation_keeps_a_blade() {
    for formulation in ["index1", "index2", "index3", "ggl"] {
        let method = format!("[solve]\nmethod = \"radau\"\nformulation = \"{formulation}\"\n");
        let text = touch_text("skate").replace("[solve]\n", &method).replace("1e-11", "1e-9");
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let within = Within { relative: 1e-7, absolute: 1e-7 };
        let rows = reference("touch/skate");
        let last = &rows["rows"][30];
        for (k, name) in ["x", "y", "phi", "v"].iter().enumerate() {
            let expected = last[k + 1].as_f64().expect("a number");
            let found = signal(&mechanism, at(&motion, 6.0), name);
            close(&format!("{name} by {formulation}"), found, expected, within);
        }
    }
}

#[test]
fn a_ball_goes_round_on_a_turntable_and_drifts_where_it_is_tilted() {
    let columns = ["x", "y", "vx", "vy"];
    let tilted = touch_text("turntable");
    let case = |k: u64| move |row: &Value| row[0].as_u64() == Some(k);
    check_outputs(&tilted, "ball_turntable", &case(2), &columns);
    let level = tilted.replace("tilt = \"1 deg\"", "tilt = \"0 deg\"");
    check_outputs(&level, "ball_turntable", &case(1), &columns);
}

#[test]
fn a_disc_rolls_in_a_steady_circle_with_the_friction_of_the_reference() {
    let known = reference("touch/coin_steady");
    for row in [0, 3, 5].map(|k: usize| &known["rows"][k]) {
        let column = |name: &str| {
            let mut columns = known["columns"].as_array().expect("columns").iter();
            row[columns.position(|c| c == name).expect("a column")].as_f64().expect("a number")
        };
        let mut text = touch_text("coin");
        for (word, name) in [("LEAN", "lean_deg"), ("TURNING", "turning"), ("SPIN", "spin")] {
            text = text.replace(&format!("\"{word} "), &format!("\"{:.15e} ", column(name)));
        }
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        for t in [0.0, 0.25, 1.0] {
            let sample = at(&motion, t);
            let found = |name: &str| signal(&mechanism, sample, name);
            let within = Within { relative: 1e-9, absolute: 0.0 };
            for name in ["v_centre", "height", "friction", "mu_needed"] {
                close(&format!("{name} at {t} s"), found(name), column(name), within);
            }
            close("the circle of the centre", found("circle"), 0.4, within);
        }
    }
}

#[test]
fn a_bicycle_has_the_eigenvalues_of_the_benchmark() {
    let known = reference("touch/bicycle");
    // At a speed at which it is stable.
    for row in [&known["rows"][5]] {
        let number = |k: usize| row[k].as_f64().expect("a number");
        let text = touch_text("bicycle").replace("\"5 m/s\"", &format!("\"{} m/s\"", number(0)));
        let linear = linearize(model(&text), About::Start, &Channels::default()).expect("linear");
        let largest =
            (0..4).map(|k| number(2 * k + 1).hypot(number(2 * k + 2))).fold(0.0, f64::max);
        for k in 0..4 {
            let [re, im] = [number(2 * k + 1), number(2 * k + 2)];
            let off = linear.poles.iter().map(|p| (p[0] - re).hypot(p[1] - im));
            let off = off.fold(f64::INFINITY, f64::min) / largest;
            assert!(
                off < 1e-9,
                "{re} + {im} i at {} m/s: off by {off:e} of {:?}",
                number(0),
                linear.poles
            );
        }
        // Place, heading, turned wheels, and the speed that stays.
        assert_eq!(linear.poles.len(), 10);
        let near_zero = linear.poles.iter().filter(|p| p[0].hypot(p[1]) < 1e-3).count();
        assert!(near_zero >= 6, "{:?}", linear.poles);
    }
}

#[test]
fn wheels_in_space_are_derived_without_multiplying_out() {
    let mechanism = derive(model(&touch_text("bicycle")));
    let n_nodes = mechanism.model.pool.len();
    assert!(n_nodes < 20_000, "{n_nodes} expressions were made");
}

#[test]
fn positions_and_velocities_are_counted_apart() {
    for (fixture, [velocities, positions]) in [("skate", [2, 3]), ("turntable", [4, 6])] {
        let mechanism = derive(model(&touch_text(fixture)));
        let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
        let found = mobility(&mechanism.model, &mechanism.system, &start);
        assert_eq!([found.mobility, found.of_positions], [velocities, positions], "{fixture}");
    }
}

/// A wheel on a straight way, whose turning and travel a condition on rates or a relation ties.
fn wheel(tie: &str) -> String {
    format!(
        "[bodies.cart]\nmass = 2\n[bodies.wheel]\nmass = 1\ninertia = 0.02\n\
         [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"cart\"]\naxis = [1, 0]\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"cart\", \"wheel\"]\n\
         [loads.F]\ntype = \"force\"\non = \"cart\"\nvector = [\"3 N*cos(2 rad/s*t)\", 0]\n\
         {tie}\n[initial]\nS = {{ position = 0, velocity = 1 }}\nA = {{ angle = 0 }}\n\
         [solve]\nt_end = 2\nevery = 0.5\nrtol = 1e-11\natol = 1e-12\n"
    )
}

#[test]
fn rolling_that_can_be_integrated_is_the_relation_of_positions() {
    let relation =
        "[couplings.tie]\ntype = \"relation\"\nrelation = \"S.position - 0.2 m*A.angle\"\n";
    let rate = "[conditions.tie]\nrate = \"S.velocity - 0.2 m*A.rate\"\n";
    let [relation, rate] = [relation, rate].map(|tie| {
        let mechanism = derive(model(&wheel(tie)));
        let motion = solve(&mechanism);
        motion.samples.iter().map(|s| [s.q[0], s.q[1], s.v[0], s.lambda[0]]).collect::<Vec<_>>()
    });
    let within = Within { relative: 1e-10, absolute: 1e-10 };
    for (a, b) in relation.iter().zip(&rate) {
        (0..4).for_each(|k| close(&format!("column {k}"), b[k], a[k], within));
    }
}

#[test]
fn conditions_that_are_none_are_refused_with_what_to_write() {
    let faults = [
        ("S.position - 0.2 m*A.angle", "M031"),
        ("S.velocity*A.rate/(1 rad/s) - 1 m/s", "M106"),
        ("if(S.position > 1, 2 m/s, 1 m/s)", "M106"),
    ];
    for (rate, code) in faults {
        let text = wheel(&format!("[conditions.tie]\nrate = \"{rate}\"\n"));
        let reading = read(&Source::new(&text, "wheel"));
        let found = messages(&reading.diagnostics);
        assert!(found.contains(code), "{rate}: {found}");
    }
}

/// Upright at speed v, poles ±√(4 g/5 r − 12 v²/5 r²): stable above v² = g r/3.
#[test]
fn a_disc_that_rolls_upright_has_poles_where_its_angles_have_names() {
    let text = |named: &str, v: f64| {
        format!(
            "space = \"spatial\"\n[bodies.disc]\nmass = 2\ninertia = [0.045, 0.045, 0.09]\nfree = true\n{named}\n\
             [joints.floor]\ntype = \"rolling\"\nbetween = [\"ground\", \"disc\"]\naxis = [0, 0, 1]\nshape = \"disc\"\nradius = 0.3\n\
             [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
             [initial]\ndisc = {{ x = 0, y = 0, z = 0.3, rpy = [\"90 deg\", 0, 0], w = [0, {}, 0] }}\n",
            v / 0.3
        )
    };
    let linear = |text: &str| {
        linearize(model(text), About::Start, &Channels::default()).expect("linear equations")
    };
    let named = "coordinates = [\"x\", \"y\", \"z\", \"lean\", \"yaw\", \"spin\"]";
    for v in [0.6_f64, 1.4] {
        let found = linear(&text(named, v));
        assert!(!found.state.is_passing, "the equations do not change");
        let square = 0.8 * 9.81 / 0.3 - 2.4 * (v / 0.3).powi(2);
        let [re, im] = if square > 0.0 { [square.sqrt(), 0.0] } else { [0.0, (-square).sqrt()] };
        for sign in [-1.0, 1.0] {
            let off = found.poles.iter().map(|p| (p[0] - sign * re).hypot(p[1] - sign * im));
            let off = off.fold(f64::INFINITY, f64::min);
            assert!(off < 1e-6, "{re} + {im} i: {:?}", found.poles);
        }
        // A quaternion that turns changes them all the time.
        assert!(linear(&text("", v)).state.is_passing);
    }
}
