//! Third rates of positions over a range, next to closed forms.

use bksim::analysis::{Drive, KinematicsOptions, Prescribed, Range, Table, kinematics_along};

use crate::support::{Within, close, model};

const CRANK: f64 = 0.08;
const ROD: f64 = 0.25;

/// A slider-crank; the crank's drive follows this motion.
fn slider_crank(drive: &str) -> String {
    format!(
        "[bodies]\ncrank = {{ mass = 1, inertia = 0.1, points = {{ B = [{CRANK}, 0] }} }}\nrod = {{ mass = 1, inertia = 0.1, points = {{ C = [{ROD}, 0], M = [0.1, 0.02] }} }}\nslider = {{ mass = 1 }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"crank\"] }}\n\
         B = {{ type = \"revolute\", between = [\"crank.B\", \"rod\"] }}\n\
         C = {{ type = \"revolute\", between = [\"rod.C\", \"slider\"] }}\n\
         guide = {{ type = \"prismatic\", between = [\"ground\", \"slider\"], axis = [1, 0] }}\n{drive}\
         [initial]\nA = {{ guess = {{ angle = 0.3 }} }}\nslider = {{ guess = {{ x = 0.3 }} }}\n"
    )
}

/// Derivatives of the slider's position by the crank's angle, of the first to the third order.
fn slopes(angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let f = (ROD * ROD - CRANK * CRANK * sin * sin).sqrt();
    // f′ = −g/f with g = r² sin θ cos θ.
    let (g, g1) = (CRANK * CRANK * sin * cos, CRANK * CRANK * (cos * cos - sin * sin));
    let first = -g / f;
    let second = -g1 / f - g * g / f.powi(3);
    let third = 4.0 * g / f - 3.0 * g * g1 / f.powi(3) - 3.0 * g.powi(3) / f.powi(5);
    [-CRANK * sin + first, -CRANK * cos + second, CRANK * sin + third]
}

fn table(text: &str, prescribed: &dyn Fn(&bksim::model::Model) -> Prescribed) -> Table {
    let model = model(text);
    let prescribed = prescribed(&model);
    let options = KinematicsOptions { has_jerk: true, ..KinematicsOptions::default() };
    kinematics_along(model, &prescribed, options).expect("positions").table
}

#[test]
fn the_jerk_of_a_slider_is_that_of_the_formula() {
    let (rate, acceleration) = (3.7, -2.1);
    let over_angles = |model: &bksim::model::Model| {
        let mut drive = Drive::parse(model, "A.angle", "0.3:6 rad:20").expect("a drive");
        (drive.rate, drive.acceleration) = (rate, acceleration);
        Prescribed::Drives { drives: vec![drive], through: false }
    };
    let of_angles = table(&slider_crank(""), &over_angles);
    // The same by the motion of a drive, whose third rate is not zero.
    let drive = "[drives.m]\njoint = \"A\"\nmotion = \"0.3 + 1 rad/s*t + 0.5 rad/s^2*t^2 + 0.25 rad/s^3*t^3\"\n";
    let over_times =
        |_: &bksim::model::Model| Prescribed::Times(Range { from: 0.0, to: 1.5, n: 20 });
    let of_times = table(&slider_crank(drive), &over_times);
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    for (table, is_timed) in [(&of_angles, false), (&of_times, true)] {
        let column = |name: &str| table.column(name).unwrap_or_else(|| panic!("no {name}"));
        let (angles, jerks, of_body) =
            (column("A.angle"), column("guide.jerk"), column("slider.jx"));
        let third_of_crank = column("A.jerk");
        for (k, &angle) in angles.iter().enumerate() {
            let [omega, alpha, jerk] = if is_timed {
                let t = column("t")[k];
                [1.0 + t + 0.75 * t * t, 1.0 + 1.5 * t, 1.5]
            } else {
                [rate, acceleration, 0.0]
            };
            let [first, second, third] = slopes(angle);
            let expected = third * omega.powi(3) + 3.0 * second * omega * alpha + first * jerk;
            close("guide.jerk", jerks[k], expected, within);
            close("slider.jx", of_body[k], expected, within);
            close("A.jerk", third_of_crank[k], jerk, within);
        }
        // A point of the rod: the third rate of its place, by that of both of its ends.
        for axis in ["x", "y"] {
            let [b, c, m] = ["B", "C", "M"].map(|point| match point {
                "B" => column(&format!("crank.B.j{axis}")),
                "C" => column(&format!("rod.C.j{axis}")),
                _ => column(&format!("rod.M.j{axis}")),
            });
            let other = if axis == "x" { "y" } else { "x" };
            let sign = if axis == "x" { -1.0 } else { 1.0 };
            let [b2, c2] = ["crank.B", "rod.C"].map(|point| column(&format!("{point}.j{other}")));
            for k in 0..b.len() {
                let along = b[k] + 0.1 / ROD * (c[k] - b[k]);
                let expected = along + sign * 0.02 / ROD * (c2[k] - b2[k]);
                close("rod.M", m[k], expected, within);
            }
        }
    }
    let units: Vec<_> = of_angles.columns.iter().filter(|of| of.name == "guide.jerk").collect();
    assert_eq!(units[0].unit, "m/s^3");
}
