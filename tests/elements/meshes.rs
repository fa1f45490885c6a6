//! Teeth that give: vibrations of two gears, their decay, and gears that bounce in their play.

use crate::support::{Within, close, derive, model, reaction, signal, solve};

const RADII: [f64; 2] = [0.027, 0.045];
const INERTIAS: [f64; 2] = [1e-3, 4e-3];
const STIFFNESS: f64 = 2e7;

fn gears(keys: &str, starts: [[f64; 2]; 2], t_end: f64) -> String {
    let [[a, va], [b, vb]] = starts;
    format!(
        "[ground]\npoints = {{ A = [0, 0], B = [0.072, 0] }}\n\
         [bodies]\ng1 = {{ mass = 1, inertia = 1e-3 }}\ng2 = {{ mass = 1, inertia = 4e-3 }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground.A\", \"g1\"] }}\n\
         B = {{ type = \"revolute\", between = [\"ground.B\", \"g2\"] }}\n\
         [couplings.pair]\ntype = \"gear\"\nbetween = [\"A\", \"B\"]\nteeth = [18, 30]\nmodule = \"3 mm\"\n\
         pressure_angle = \"20 deg\"\nstiffness = \"20 MN/m\"\n{keys}\n\
         [initial]\nA = {{ angle = {a:?}, rate = {va:?} }}\nB = {{ angle = {b:?}, rate = {vb:?} }}\n\
         [outputs]\na = \"A.angle\"\nva = \"A.rate\"\nvb = \"B.rate\"\n\
         [solve]\nt_end = {t_end:?}\nevery = {:?}\nrtol = 1e-11\natol = 1e-13\n",
        t_end / 40.0
    )
}

/// The mass of both on the pitch circles, and the stiffness along these.
fn reduced() -> [f64; 2] {
    let per_mass: f64 = (0..2).map(|k| RADII[k] * RADII[k] / INERTIAS[k]).sum();
    [1.0 / per_mass, STIFFNESS * 20_f64.to_radians().cos().powi(2)]
}

#[test]
fn gears_vibrate_on_their_teeth_and_come_to_rest_by_damping() {
    let [mass, stiffness] = reduced();
    let lead = 2e-5;
    for damping in [0.0, 3000.0] {
        let keys = if damping > 0.0 { format!("damping = {damping}") } else { String::new() };
        let decay = damping * 20_f64.to_radians().cos().powi(2) / (2.0 * mass);
        let rate = (stiffness / mass - decay * decay).sqrt();
        let t_end = 3.0 * std::f64::consts::TAU / rate;
        let text = gears(&keys, [[lead / RADII[0], 0.0], [0.0, 0.0]], t_end);
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        for sample in &motion.samples {
            let t = sample.t;
            let (sin, cos) = (rate * t).sin_cos();
            let fading = (-decay * t).exp();
            let s = lead * fading * (cos + decay / rate * sin);
            let v = -lead * fading * (rate + decay * decay / rate) * sin;
            let force = stiffness * s + 2.0 * mass * decay * v;
            let get = |name: &str| signal(&mechanism, sample, name);
            close("lead", get("pair_lead"), s, Within { relative: 0.0, absolute: 1e-12 });
            let within = Within { relative: 0.0, absolute: 1e-4 };
            close("force", get("pair_force"), force, within);
            // On the second along the pitch circle downwards, and away from the first.
            let radial = force.abs() * 20_f64.to_radians().tan();
            close("radial", get("pair_radial"), radial, within);
            let bearing = reaction(&mechanism, sample, "B");
            close("bearing, across", bearing[0], -radial, within);
            close("bearing, along", bearing[1].abs(), force.abs(), within);
        }
    }
}

#[test]
fn gears_bounce_between_the_flanks_of_their_play() {
    // The play is 0.1 mm; the first begins in the middle of it, at 10 rad/s.
    let [mass, stiffness] = reduced();
    let speed = 10.0 * RADII[0];
    let [reach, contact] = [0.05e-3 / speed, std::f64::consts::PI * (mass / stiffness).sqrt()];
    let t_end = reach + contact + 0.5 * 0.1e-3 / speed;
    let text = gears("backlash = \"0.1 mm\"", [[-0.05e-3 / RADII[0], 10.0], [0.0, 0.0]], t_end);
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    // An elastic impact on the pitch circles; the second goes backwards where the first goes forward.
    let impulse = 2.0 * mass * speed;
    let after = [10.0 - impulse * RADII[0] / INERTIAS[0], -impulse * RADII[1] / INERTIAS[1]];
    let mut n_pressed = 0;
    for sample in &motion.samples {
        let get = |name: &str| signal(&mechanism, sample, name);
        let within = Within { relative: 0.0, absolute: 1e-7 };
        let since = sample.t - reach;
        if since < 0.0 || since > contact {
            let expected = if since < 0.0 { [10.0, 0.0] } else { after };
            close("the first", get("va"), expected[0], within);
            close("the second", get("vb"), expected[1], within);
            assert!(get("pair_force") == 0.0, "{}", get("pair_force"));
        } else {
            let peak = speed * (mass * stiffness).sqrt();
            let push = peak * (std::f64::consts::PI * since / contact).sin();
            close("push", get("pair_force"), push, Within { relative: 0.0, absolute: 1e-3 });
            n_pressed += 1;
        }
    }
    assert!(n_pressed > 3, "{n_pressed}");
}
