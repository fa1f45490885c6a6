//! Teeth: directions of their force in the bearings, play between their flanks.

use bksim::sim::hybrid::ChangeKind;
use serde_json::Value;

use crate::support::elements::{check_outputs, column, number, reference, touch_text};
use crate::support::{at, derive, model, reaction, signal, solve};

/// Three gears in a row or around a corner, all as a model of one plane.
fn three_gears(layout: f64, helix: f64) -> String {
    let radius = |teeth: f64| teeth * 0.003 / (2.0 * helix.to_radians().cos());
    let [r1, r2, r3] = [18.0, 30.0, 54.0].map(radius);
    let (sin, cos) = (180.0 - layout).to_radians().sin_cos();
    let (x, y) = (r1 + r2 + (r2 + r3) * cos, (r2 + r3) * sin);
    // The idler is left-handed where the first is right-handed, and so on.
    format!(
        r#"
[ground]
points = {{ A = [0, 0], B = [{}, 0], C = [{x}, {y}] }}
[bodies.g1]
mass = "1 kg"
inertia = "1e-3 kg m^2"
[bodies.g2]
mass = "1 kg"
inertia = "2e-3 kg m^2"
[bodies.g3]
mass = "1 kg"
inertia = "4e-3 kg m^2"
[joints.A]
type = "revolute"
between = ["ground.A", "g1"]
[joints.B]
type = "revolute"
between = ["ground.B", "g2"]
[joints.C]
type = "revolute"
between = ["ground.C", "g3"]
[couplings.ab]
type = "gear"
between = ["A", "B"]
teeth = [18, 30]
module = "3 mm"
pressure_angle = "20 deg"
helix = "{helix} deg"
[couplings.bc]
type = "gear"
between = ["B", "C"]
teeth = [30, 54]
module = "3 mm"
pressure_angle = "20 deg"
helix = "{} deg"
[loads.load]
type = "torque"
joint = "C"
value = "-180 N m"
[drives.motor]
joint = "A"
motion = "20 rad/s*t"
[solve]
t_end = "0.01 s"
every = "0.01 s"
[outputs]
Ft = "abs(couplings.ab)"
bearing1 = "reactions.A.force"
bearing2_x = "-reactions.B.fx"
bearing2_y = "-reactions.B.fy"
bearing2 = "sqrt(reactions.B.fx^2 + reactions.B.fy^2)"
bearing3_x = "-reactions.C.fx"
bearing3_y = "-reactions.C.fy"
load_torque = "3*drives.motor"
"#,
        r1 + r2,
        -helix
    )
}

#[test]
fn bearings_carry_the_force_that_parts_the_gears() {
    let data = reference("touch/gear_separating");
    let names = [
        "Ft",
        "bearing1",
        "bearing2_x",
        "bearing2_y",
        "bearing2",
        "bearing3_x",
        "bearing3_y",
        "load_torque",
    ];
    for row in data["rows"].as_array().expect("rows") {
        let case = number(row, 0);
        let (layout, helix) =
            [(180.0, 0.0), (90.0, 0.0), (120.0, 0.0), (180.0, 15.0), (90.0, 25.0)]
                [usize::try_from(row[0].as_u64().expect("a number")).expect("few") - 1];
        for coordinates in ["relative", "absolute"] {
            let text = format!("coordinates = \"{coordinates}\"\n{}", three_gears(layout, helix));
            let mechanism = derive(model(&text));
            let motion = solve(&mechanism);
            let sample = at(&motion, 0.0);
            let compare = |name: &str, found: f64| {
                let expected = number(row, column(&data, name));
                assert!(
                    (found - expected).abs() <= 1e-12 * 4444.4,
                    "case {case}, {coordinates}, {name}: {found:.14e} for {expected:.14e}"
                );
            };
            for name in names {
                compare(name, signal(&mechanism, sample, name));
            }
            compare("Fr", signal(&mechanism, sample, "ab_radial"));
            if helix > 0.0 {
                // The idler's axial forces cancel; a positive one is along z, on the second gear.
                let axial = signal(&mechanism, sample, "ab_axial");
                compare("Fa", -axial);
                assert!((axial - signal(&mechanism, sample, "bc_axial")).abs() < 1e-9, "{axial}");
            }
        }
    }
}

#[test]
fn gears_fly_through_their_play_and_come_to_rest_on_the_other_flanks() {
    let columns = ["phi1", "w1", "phi2", "w2", "s"];
    check_outputs(&touch_text("backlash"), "gear_backlash", &|_| true, &columns);
    // At 0.2 s the torque jumps.
    let is_meant = |row: &Value| row[0].as_f64() != Some(0.2);
    check_outputs(&touch_text("backlash"), "gear_backlash", &is_meant, &["mesh"]);

    let data = reference("touch/gear_backlash");
    let numbers = |name: &str| -> Vec<f64> {
        serde_json::from_value(data["values"][name].clone()).expect("numbers")
    };
    let motion = solve(&derive(model(&touch_text("backlash"))));
    let hits: Vec<(f64, f64)> = (motion.summary.changes.iter())
        .filter_map(|change| match change.kind {
            ChangeKind::Hit(_, speed) => Some((change.t, speed)),
            _ => None,
        })
        .collect();
    // Speeds are those of the second gear.
    for (k, (t, speed)) in
        numbers("impact_times").into_iter().zip(numbers("relative_speeds")).enumerate()
    {
        let (found, at) = hits[k];
        let within = if k < 5 { 1e-9 } else { 1e-8 };
        assert!((found - t).abs() < within, "impact {k}: {found} for {t}");
        assert!((at + 0.25 * speed).abs() < 1e-7, "impact {k}: {at} for {speed}");
    }
    let rest = motion.summary.changes.iter().rfind(|c| matches!(c.kind, ChangeKind::Rest(_)));
    let end = data["values"]["end_of_bounces"].as_f64().expect("a time");
    let rest = rest.expect("it rests").t;
    // The last bounces are lower than what the angles are rounded by.
    assert!((rest - end).abs() < 1e-6, "{rest} for {end}");
}

/// A pair in balance under these torques, with or without play.
fn pair(is_ring: bool, torques: [f64; 2], more: &str) -> String {
    let (place, internal) = if is_ring { (-18, "internal = true") } else { (72, "") };
    format!(
        r#"
coordinates = "absolute"
[ground]
points = {{ A = [0, 0], B = ["{place} mm", 0] }}
[bodies.g1]
mass = "1 kg"
inertia = "1e-3 kg m^2"
[bodies.g2]
mass = "1 kg"
inertia = "2e-3 kg m^2"
[joints.A]
type = "revolute"
between = ["ground.A", "g1"]
[joints.B]
type = "revolute"
between = ["ground.B", "g2"]
[couplings.pair]
type = "gear"
between = ["A", "B"]
radii = ["27 mm", "45 mm"]
pressure_angle = "20 deg"
{internal}
{more}
[loads.first]
type = "torque"
joint = "A"
value = "{} N m"
[loads.second]
type = "torque"
joint = "B"
value = "{} N m"
[outputs]
force = "couplings.pair"
[solve]
t_end = "0.01 s"
every = "0.01 s"
"#,
        torques[0], torques[1]
    )
}

#[test]
fn flanks_with_play_press_as_teeth_without() {
    for is_ring in [false, true] {
        for first in [18.0, -18.0] {
            let second = if is_ring { -30.0 } else { 30.0 } * f64::signum(first);
            // Where the first pushes backwards, the other flanks touch at the start.
            let phase = if is_ring { -0.1 / 45.0 } else { 0.1 / 45.0 };
            let phase = if first > 0.0 { 0.0 } else { phase };
            let play = format!("backlash = \"0.1 mm\"\nphase = \"{phase} rad\"");
            let found = ["", play.as_str()].map(|more| {
                let mechanism = derive(model(&pair(is_ring, [first, second], more)));
                let motion = solve(&mechanism);
                let last = at(&motion, 0.01);
                (signal(&mechanism, last, "force"), reaction(&mechanism, last, "B"))
            });
            let tangential = -second / 0.045;
            let radial = tangential.abs() * 20f64.to_radians().tan();
            // Away from a pinion to the left; with its centre to the right, in a ring, its teeth press on to the right, too.
            for (force, bearing) in found {
                let close = |found: f64, expected: f64| (found - expected).abs() < 1e-7;
                assert!(close(force, tangential), "ring {is_ring}, {first}: {force} {tangential}");
                assert!(close(bearing[0], -radial), "ring {is_ring}, {first}: {bearing:?}");
                assert!(
                    close(bearing[1].abs(), tangential.abs()),
                    "{is_ring} {first}: {bearing:?}"
                );
            }
        }
    }
}

#[test]
fn helical_teeth_press_along_the_axes_in_space() {
    let text = pair(false, [18.0, 30.0], "helix = \"15 deg\"");
    let text = text
        .replace("coordinates = \"absolute\"", "space = \"spatial\"")
        .replace("0]", "0, 0]")
        .replace("\"1e-3 kg m^2\"", "[\"1e-3 kg m^2\", \"1e-3 kg m^2\", \"1e-3 kg m^2\"]")
        .replace("\"2e-3 kg m^2\"", "[\"2e-3 kg m^2\", \"2e-3 kg m^2\", \"2e-3 kg m^2\"]");
    for text in [text.clone(), text.replace("[joints.A]", "[joints.A]\ncut = false")] {
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let sample = at(&motion, 0.0);
        let (alpha, beta) = (20f64.to_radians(), 15f64.to_radians());
        let force = signal(&mechanism, sample, "force");
        assert!((force + 30.0 / 0.045).abs() < 1e-9, "{force}");
        // At the pitch point, 45 mm to the left of the second axis.
        let on_second = [force.abs() * alpha.tan() / beta.cos(), -force, force * beta.tan()];
        let bearing = reaction(&mechanism, sample, "B");
        let moments = [0.0, -0.045 * on_second[2], 0.0];
        let expected: Vec<f64> = on_second.iter().map(|f| -f).chain(moments).collect();
        for (found, expected) in bearing.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-9, "{bearing:?} for {expected:?}");
        }
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Bevel wheels on axes at an angle of Σ, both away from the apex: tan δ₁ = r₁ sin Σ/(r₂ + r₁ cos Σ).
#[test]
fn bevel_wheels_press_where_their_cones_touch() {
    let (r1, r2, torque, alpha) = (0.027, 0.045, 10.0, 20.0_f64.to_radians());
    for (angle, is_inward) in [(90.0_f64, false), (70.0, false), (110.0, true)] {
        let (sin, cos) = angle.to_radians().sin_cos();
        let axes = [[0.0, 0.0, 1.0], [sin, 0.0, cos]];
        // Where the cones touch, at distances r₁ and r₂ from the axes, and the centres next to it.
        let [z, x] = [(r2 + r1 * cos) / sin, r1];
        let centers = axes.map(|axis| {
            let along = x * axis[0] + z * axis[2];
            axis.map(|part| along * part)
        });
        let sign = if is_inward { -1.0 } else { 1.0 };
        let [a, b] = axes.map(|axis| axis.map(|part| sign * part));
        let text = format!(
            "space = \"spatial\"\n[ground]\npoints = {{ A = {:?}, B = {:?} }}\n\
             [bodies.g1]\nmass = 1\ninertia = [1e-3, 1e-3, 1e-3]\n[bodies.g2]\nmass = 1\ninertia = [1e-3, 1e-3, 1e-3]\n\
             [joints.A]\ntype = \"revolute\"\nbetween = [\"ground.A\", \"g1\"]\naxis = {a:?}\n\
             [joints.B]\ntype = \"revolute\"\nbetween = [\"ground.B\", \"g2\"]\naxis = {b:?}\n\
             [couplings.pair]\ntype = \"gear\"\nbetween = [\"A\", \"B\"]\nradii = [{r1}, {r2}]\npressure_angle = \"20 deg\"\n\
             [drives.motor]\njoint = \"A\"\nmotion = \"0.2 rad/s*t\"\n\
             [loads.load]\ntype = \"torque\"\njoint = \"B\"\nvalue = {torque}\n\
             [outputs]\neffort = \"drives.motor\"\n[solve]\nt_end = 0.01\nevery = 0.01\n",
            centers[0], centers[1]
        );
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let sample = at(&motion, 0.01);
        // The load turns the second on: teeth hold it with F at the radius.
        let force = torque / r2;
        let turn = cross(b, [x, 0.0, z]);
        let t = turn.map(|part| -force * part / r2);
        let length = x.hypot(z);
        // Across the line of the cones, away from the first axis, on the second wheel.
        let n = [z / length, 0.0, -x / length].map(|part| force * alpha.tan() * part);
        let tooth = [t[0] + n[0], t[1] + n[1], t[2] + n[2]];
        for (wheel, joint) in ["A", "B"].into_iter().enumerate() {
            let sense = if wheel == 1 { -1.0 } else { 1.0 };
            let arm = [x - centers[wheel][0], 0.0, z - centers[wheel][2]];
            let moment = cross(arm, tooth);
            for k in 0..3 {
                let found = reaction(&mechanism, sample, joint)[k];
                let expected = sense * tooth[k];
                assert!(
                    (found - expected).abs() < 1e-9 * force,
                    "{angle}, {joint}, {k}: {found} for {expected}"
                );
                // About the axis the motor and the load hold it.
                let axis = [a, b][wheel];
                let about: f64 = moment.iter().zip(axis).map(|(m, n)| m * n).sum();
                let expected = sense * (moment[k] - about * axis[k]);
                let found = reaction(&mechanism, sample, joint)[3 + k];
                let found_about: f64 =
                    (0..3).map(|i| reaction(&mechanism, sample, joint)[3 + i] * axis[i]).sum();
                let found = found - found_about * axis[k];
                assert!(
                    (found - expected).abs() < 1e-9 * torque,
                    "{angle}, {joint}, moment {k}: {found} for {expected}"
                );
            }
        }
        let radial = signal(&mechanism, sample, "pair_radial");
        assert!((radial - force * alpha.tan()).abs() < 1e-9 * force, "{radial}");
        let effort = signal(&mechanism, sample, "effort");
        assert!((effort.abs() - force * r1).abs() < 1e-9, "{effort}");
    }
}
