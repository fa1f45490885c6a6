//! Laws of motion from rest to rest against closed forms.

use std::fmt::Write;

use bksim_design::{OptimizeWish, Optimized, Source, Watch, optimize};
use serde_json::Value;

/// A value of the reference.
fn given(name: &str) -> f64 {
    let text = include_str!("../fixtures/opt_motion_law.json");
    let fixture: Value = serde_json::from_str(text).expect("a fixture");
    fixture["values"][name].as_f64().expect("a number")
}

/// A slide of one kilogram on a law of motion: its force is the acceleration.
fn solved(parameters: &str, motion: &str, t_end: &str, question: &str) -> Optimized {
    let text = format!(
        "[parameters]\n{parameters}\n[bodies.slide]\nmass = \"1 kg\"\ninertia = 1\n\
         [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"slide\"]\naxis = [1, 0]\n\
         [drives.motor]\njoint = \"S\"\nmotion = \"{motion}\"\n\
         [outputs]\nforce = \"drives.motor\"\nspeed = \"S.velocity\"\n\
         [solve]\nt_end = \"{t_end}\"\nevery = \"1 ms\"\n[optimize]\n{question}\n"
    );
    let source = Source { text: text.clone(), name: "law".to_owned(), ..Source::default() };
    let wish = OptimizeWish::of_model(&text).expect("a question");
    optimize(&source, &wish, Watch::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Acceleration linear between eleven values, 80 mm in half a second from rest to rest; the end is reached by two equations.
fn between_knots(conditions: &str) -> f64 {
    const N: usize = 10;
    let mut parameters = "dt = \"0.05 s\"\n".to_owned();
    let mut vary = Vec::new();
    for k in 0..=N {
        let start = 1.92 * (1.0 - 2.0 * k as f64 / N as f64);
        let _ = writeln!(parameters, "a{k} = \"{start} m/s^2\"");
        vary.push(format!("a{k} = [\"-10 m/s^2\", \"10 m/s^2\"]"));
    }
    let mut motion = "a0*t^2/2 + (a1 - a0)/dt*t^3/6".to_owned();
    for k in 1..N {
        let _ = write!(motion, " + (a{} - 2*a{k} + a{})/dt*max(t - {k}*dt, 0 s)^3/6", k + 1, k - 1);
    }
    let question = format!(
        "minimize = \"rms(outputs.force)\"\nvary = {{ {} }}\n\
         subject_to = [\"final(S.position) == 80 mm\", \"final(S.velocity) == 0 m/s\"{conditions}]",
        vary.join(", ")
    );
    let found = solved(&parameters, &motion, "0.5 s", &question);
    0.5 * found.after * found.after
}

#[test]
fn the_least_square_of_acceleration_is_that_of_a_cubic() {
    let found = between_knots("");
    assert!((found / given("a_integral") - 1.0).abs() < 1e-4, "{found}");
}

#[test]
fn a_bound_of_speed_costs_what_theory_says() {
    // Speed in the knots by the trapezoidal rule, exact for this law.
    let speed = |k: usize| {
        let inner: Vec<String> = (1..k).map(|i| format!(" + 2*a{i}")).collect();
        let inner = inner.concat();
        format!(", \"dt*(a0{inner} + a{k})/2 <= 0.2 m/s\"")
    };
    let found = between_knots(&(1..10).map(speed).collect::<String>());
    assert!((found / given("d_integral") - 1.0).abs() < 1e-4, "{found}");
}

#[test]
fn the_shortest_times_and_the_least_peak_are_those_of_trapezoids() {
    let motion = "h/(2*t1*(T - t1))*(max(t, 0 s)^2 - max(t - t1, 0 s)^2 - max(t - T + t1, 0 s)^2)";
    let parameters = "h = \"80 mm\"\nT = \"0.8 s\"\nt1 = \"0.3 s\"";
    let least = |more: &str| {
        let question = format!(
            "minimize = \"T\"\nvary = {{ T = [\"0.2 s\", \"2 s\"], t1 = [\"0.05 s\", \"1 s\"] }}\n\
             subject_to = [{more}\"max(outputs.force) <= 1.2 N\", \"2*t1 <= T\"]"
        );
        solved(parameters, motion, "T", &question).after
    };
    let with_speed = least("\"max(outputs.speed) <= 0.2 m/s\", ");
    assert!((with_speed - given("e_time")).abs() < 1e-9, "{with_speed}");
    let without = least("");
    assert!((without - given("f_time")).abs() < 1e-9, "{without}");
    let peak = solved(
        "h = \"80 mm\"\nT = \"0.5 s\"\nt1 = \"0.2 s\"",
        motion,
        "0.5 s",
        "minimize = \"max(outputs.force)\"\nvary = { t1 = [\"0.05 s\", \"0.25 s\"] }",
    );
    assert!((peak.after - given("c_peak_a")).abs() < 1e-9, "{}", peak.after);
}
