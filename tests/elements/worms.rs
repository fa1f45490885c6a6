//! Worms: the forces of Shigley's example, what their friction takes, and when a wheel turns its worm.

use crate::support::{Within, at, close, derive, model, signal, solve};

const INCH: f64 = 0.0254;
const POUND: f64 = 4.448_221_615_260_5;

/// A worm about z and its wheel about x, above it; of Shigley's sizes.
fn worm(friction: &str, rest: &str) -> String {
    format!(
        r#"
[ground]
points = {{ A = [0, 0, 0], B = [0.01, "3.5 in", 0.02] }}
[bodies.worm]
mass = 1
inertia = [1e-3, 1e-3, 1e-3]
[bodies.wheel]
mass = 1
inertia = [2e-2, 2e-2, 2e-2]
[joints.A]
type = "revolute"
between = ["ground.A", "worm"]
axis = [0, 0, 1]
[joints.B]
type = "revolute"
between = ["ground.B", "wheel"]
axis = [1, 0, 0]
[couplings.pair]
type = "gear"
between = ["A", "B"]
teeth = [2, 30]
module = "0.16666666666666667 in"
worm_radius = "1 in"
pressure_angle = "14.5 deg"
{friction}
{rest}
"#
    )
}

/// tan γ, cos α.
const ANGLES: [f64; 2] = [1.0 / 6.0, 0.968_147_640_378_107_7];

#[test]
fn a_worm_bears_the_forces_of_shigleys_example() {
    // 1 hp at 1200 rpm with f = 0.03: around 52.5 lbf, radial 69.6 lbf, axial 264 lbf; 660 lbf in on the wheel.
    let (f, [tan, cos_alpha]) = (0.03, ANGLES);
    let (cos, sin) = (1.0 / f64::hypot(1.0, tan), tan / f64::hypot(1.0, tan));
    let power = 33_000.0 / 60.0 * 12.0 * POUND * INCH;
    let around = power / (1200.0 * std::f64::consts::TAU / 60.0 * INCH);
    let normal = around / (cos_alpha * sin + f * cos);
    let radial = normal * (1.0 - cos_alpha * cos_alpha).sqrt();
    let axial = normal * (cos_alpha * cos - f * sin);
    for (value, printed) in [(around, 52.5), (radial, 69.6), (axial, 264.0)] {
        close("as printed", value / POUND, printed, Within { relative: 3e-3, absolute: 0.0 });
    }

    let friction = format!("[loads.rub]\ntype = \"friction\"\ncoupling = \"pair\"\nmu = {f}");
    for sense in [1.0, -1.0] {
        let rest = format!(
            "[loads.load]\ntype = \"torque\"\njoint = \"B\"\nvalue = {}\n\
             [drives.motor]\njoint = \"A\"\nmotion = \"{} rpm*t\"\n\
             [outputs]\nmotor = \"drives.motor\"\nwhole = \"couplings.pair\"\n{}\
             [solve]\nt_end = 0.01\nevery = 0.01\n",
            // The wheel turns backwards where the worm turns forward.
            sense * axial * 2.5 * INCH,
            1200.0 * sense,
            ["A", "B"]
                .map(|joint| ["fx", "fy", "fz"]
                    .map(|part| format!("{joint}{part} = \"reactions.{joint}.{part}\"\n"))
                    .concat())
                .concat(),
        );
        let mechanism = derive(model(&worm(&friction, &rest)));
        let motion = solve(&mechanism);
        let sample = at(&motion, 0.01);
        let get = |name: &str| signal(&mechanism, sample, name);
        let within = Within { relative: 1e-9, absolute: 1e-9 };
        close("power", get("motor") * sense, around * INCH, within);
        close("normal part", get("whole").abs(), normal * cos_alpha * cos, within);
        close("radial", get("pair_radial"), radial, within);
        // The bearings of both shafts hold what the pitch point gives them.
        close("axial force of the worm", get("Afz").abs(), axial, within);
        close("force around the worm", get("Afx").abs(), around, within);
        close("force from the wheel", get("Afy"), radial, within);
        for part in ["fx", "fy", "fz"] {
            let [a, b] = ["A", "B"].map(|joint| get(&format!("{joint}{part}")));
            close("both shafts", a, -b, within);
        }
    }
}

#[test]
fn a_wheel_turns_its_worm_where_friction_is_small_enough() {
    let [tan, cos_alpha] = ANGLES;
    let (cos, sin) = (1.0 / f64::hypot(1.0, tan), tan / f64::hypot(1.0, tan));
    for mu in [0.1, 0.17] {
        let friction = format!("[loads.rub]\ntype = \"friction\"\ncoupling = \"pair\"\nmu = {mu}");
        let rest = "[loads.load]\ntype = \"torque\"\njoint = \"B\"\nvalue = 20\n\
             [initial]\nB = { position = 0, velocity = 0 }\n\
             [outputs]\nangle = \"B.angle\"\n\
             [solve]\nt_end = 0.1\nevery = 0.1\nrtol = 1e-10\natol = 1e-12\n"
            .replace("position = 0, velocity = 0", "angle = 0, rate = 0");
        let mechanism = derive(model(&worm(&friction, &rest)));
        let motion = solve(&mechanism);
        let found = signal(&mechanism, at(&motion, 0.1), "angle");
        // On the worm W (cos α sin γ − μ cos γ) r₁ = J₁ α₂/i, on the wheel τ − W (cos α cos γ + μ sin γ) r₂ = J₂ α₂.
        let drive = (cos_alpha * sin - mu * cos) * INCH;
        let back = (cos_alpha * cos + mu * sin) * 2.5 * INCH;
        let ratio = 1.0 / 15.0;
        let expected = if drive <= 0.0 {
            0.0
        } else {
            let per_normal = drive * ratio / 1e-3;
            let normal = 20.0 / (back + 2e-2 * per_normal);
            0.5 * per_normal * normal * 0.01
        };
        close("turned", found, expected, Within { relative: 1e-8, absolute: 1e-12 });
    }
}
