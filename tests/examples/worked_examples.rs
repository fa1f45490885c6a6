//! Examples against the formulas of textbooks that their READMEs name.

use super::worked::{column, meet, near, over};
use crate::support::example;
use bksim::analysis::{
    Actuators, CurvesRequest, LimitsRequest, Range, curves, inverse, limits, statics, workspaces,
};

/// The points of a curve on the branch of the start.
fn way(name: &str, point: &str) -> Vec<[f64; 3]> {
    let request = CurvesRequest { points: vec![point.to_owned()], ..CurvesRequest::default() };
    let mut found = curves(example(name), &request).expect("curves");
    found.points.swap_remove(0).branches.swap_remove(0).points
}

/// R. L. Norton, *Design of Machinery*, §3.6: the ram turns back where the crank is square to the link, cos δ = r/e; the
/// time ratio is (360° − 2 δ)/2 δ. The ram's velocity follows from tan θ = (e + r sin φ)/(r cos φ) and the rod.
#[test]
fn quick_return_has_its_time_ratio_and_ram_velocity() {
    let (e, r, h, p, y) = (0.25_f64, 0.1_f64, 0.5_f64, 0.2_f64, 0.48_f64);
    let request = LimitsRequest {
        drive: Some("C.angle".into()),
        outputs: vec!["link.angle".into()],
        ..LimitsRequest::default()
    };
    let found = limits(example("quick-return"), &request).expect("limits");
    let delta = (r / e).acos();
    let ratio = (std::f64::consts::PI - delta) / delta;
    near(found.branches[0].outputs[0].time_ratio.expect("a ratio"), ratio, 1e-10);

    let found = over(example("quick-return"), "C.angle", "0:360 deg:37");
    let (crank, ram) = (column(&found, "C.angle"), column(&found, "ram.vx"));
    for (phi, velocity) in crank.into_iter().zip(ram) {
        let (sin, cos) = phi.sin_cos();
        let theta = (e + r * sin).atan2(r * cos);
        let rate = (r * r + e * r * sin) / (r * r + e * e + 2.0 * e * r * sin);
        let rise = y - h * theta.sin();
        let rod = (p * p - rise * rise).sqrt();
        // The rod goes to the right of the link.
        let expected = rate * (-h * theta.sin() + rise * h * theta.cos() / rod);
        near(velocity, expected, 1e-12);
    }
}

/// The coupler point at P = B + 2 (C − B): height 4 a at 90°, 180° and 270°; elsewhere by the triangle of sides 2.5 a over BD.
#[test]
fn hoekens_linkage_draws_its_line() {
    let a = 0.04;
    let found = over(example("hoeken"), "A.angle", "90:270 deg:61");
    let crank = column(&found, "A.angle");
    let [x, y] = ["coupler.P.x", "coupler.P.y"].map(|name| column(&found, name));
    for (i, phi) in crank.iter().enumerate() {
        let b = [a * phi.cos(), a * phi.sin()];
        let d = [2.0 * a - b[0], -b[1]];
        let half = 0.5 * d[0].hypot(d[1]);
        let height = (6.25 * a * a - half * half).sqrt();
        let expected = [0, 1].map(|k| {
            let across = [-d[1], d[0]][k] / (2.0 * half);
            b[k] + d[k] + 2.0 * height * across
        });
        near(x[i], expected[0], 1e-12);
        near(y[i], expected[1], 1e-12);
        near(y[i], 4.0 * a, 0.02 * a);
    }
    for (i, way) in [(0, 4.0), (30, 2.0), (60, 0.0)] {
        near(x[i], way * a, 1e-12);
        near(y[i], 4.0 * a, 1e-12);
    }
}

/// The foot by intersections of circles, rod by rod; its step is at least twice as long as high.
#[test]
fn jansens_leg_walks() {
    let found = over(example("jansen"), "O.angle", "0:360 deg:361");
    let crank = column(&found, "O.angle");
    let [x, y] = ["foot.F.x", "foot.F.y"].map(|name| column(&found, name));
    let z = [-38.0, -7.8];
    for (i, phi) in crank.iter().enumerate() {
        let crank_pin = [15.0 * phi.cos(), 15.0 * phi.sin()];
        let upper = meet(z, 41.5, crank_pin, 50.0);
        let lower = meet(crank_pin, 61.9, z, 39.3);
        let back = meet(z, 40.1, upper, 55.8);
        let heel = meet(lower, 36.7, back, 39.4);
        let foot = meet(lower, 49.0, heel, 65.7);
        near(1e3 * x[i], foot[0], 1e-9);
        near(1e3 * y[i], foot[1], 1e-9);
    }
    let span = |values: &[f64]| {
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        high - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    assert!(span(&x) > 2.0 * span(&y), "{} and {}", span(&x), span(&y));
}

/// Norton, §4.16: two equal links at α press 1/(2 tan α) times as hard as the knee is pushed.
#[test]
fn a_toggle_clamp_multiplies_the_push() {
    let found = over(example("toggle-clamp"), "O.angle", "20:1 deg:20");
    let alpha = column(&found, "O.angle");
    let l = 0.08;
    let jaw = column(&found, "guide.velocity");
    for (alpha, jaw) in alpha.iter().zip(jaw) {
        // Powers are equal: the knee goes across at l cos α for each radian.
        let advantage = l * alpha.cos() / jaw.abs();
        near(advantage * 2.0 * alpha.tan(), 1.0, 1e-12);
    }
}

/// Spackman: a ram at the floor pulls n cot θ times the weight of the table and of half the links; in motion, what changes
/// the kinetic energy, too.
#[test]
fn a_scissor_lift_needs_its_ram() {
    let (table, link, speed) = (200.0, 10.0, -0.1);
    let foot = |t: f64| 0.95 + speed * t;
    let kinetic = |t: f64| {
        let cos: f64 = foot(t);
        let sin = (1.0 - cos * cos).sqrt();
        let rate = -speed / sin;
        let of_link = |centre: f64| {
            let [vx, vy] = [0.5 * speed, centre * cos * rate];
            0.5 * link * (vx * vx + vy * vy) + link / 24.0 * rate * rate
        };
        0.5 * table * (2.0 * cos * rate).powi(2) + 2.0 * (of_link(0.5) + of_link(1.5))
    };
    let found = inverse(
        example("scissor-lift"),
        &[],
        &Range { from: 0.5, to: 4.5, n: 9 },
        &Actuators::default(),
    );
    let found = found.expect("efforts").table;
    let column = |name: &str| found.column(name).unwrap_or_else(|| panic!("{:?}", found.columns));
    for (t, effort) in column("t").into_iter().zip(column("ram.effort")) {
        let cos = foot(t);
        let cot = cos / (1.0 - cos * cos).sqrt();
        let at_rest = -2.0 * cot * 9.81 * (table + 0.5 * 4.0 * link);
        let more = (kinetic(t + 1e-4) - kinetic(t - 1e-4)) / (2e-4 * speed);
        near(effort, at_rest + more, 1e-5 * at_rest.abs());
    }
}

/// Watt's curve: r² = b² − (a sin θ ± √(c² − a² cos² θ))², about the middle between the pivots.
#[test]
fn the_piston_rod_of_the_beam_engine_follows_watts_curve() {
    let (b, c) = (1.5_f64, 0.25_f64);
    // Pivots at the origin and at (−3, −0.5).
    let a = 0.5 * 3.0_f64.hypot(0.5);
    let turn = 0.5_f64.atan2(3.0);
    let points = way("beam-engine", "link.P");
    assert!(points.len() > 100);
    for [x, y, _] in points {
        let [x, y] = [x + 1.5, y + 0.25];
        // Along the line of the pivots.
        let (sin, cos) = turn.sin_cos();
        let [u, v] = [cos * x + sin * y, -sin * x + cos * y];
        let (r, theta) = (u.hypot(v), v.atan2(u));
        let root = (c * c - a * a * theta.cos().powi(2)).max(0.0).sqrt();
        let off = |sign: f64| r * r - b * b + (a * theta.sin() + sign * root).powi(2);
        let least = off(1.0).abs().min(off(-1.0).abs());
        assert!(least < 1e-6, "{x}, {y}: {least}");
    }
}

/// The law of cosines in the triangle of a cylinder, and the moments about the boom's pin at rest.
#[test]
fn the_cylinders_of_the_excavator_hold_its_arm() {
    let found = statics(example("excavator"), &[], &[]).expect("an equilibrium");
    let at = &found.equilibria[0];
    let pose = |name: &str| at.pose.iter().find(|(known, ..)| known == name).expect(name).1;
    let (p, q) = (0.4_f64.hypot(0.3), 1.4_f64.hypot(0.1));
    let length = pose("boom_cylinder.position");
    let beta = ((p * p + q * q - length * length) / (2.0 * p * q)).acos();
    let drawn = pose("boom.angle") + 0.1_f64.atan2(1.4) + 0.3_f64.atan2(0.4);
    near(drawn, beta, 1e-9);
    let weights = [(800.0, "boom.x"), (400.0, "stick.x"), (1000.0, "stick.T.x")];
    let moment: f64 = weights.iter().map(|(mass, name)| 9.81 * mass * pose(name)).sum();
    let lever = p * q * beta.sin() / length;
    let cylinder = found.joints.iter().position(|name| name == "boom_cylinder").expect("a joint");
    let [fx, fy, ..] = at.reactions[cylinder];
    near(fx.hypot(fy), moment / lever, 1e-6 * moment);
}

/// Norton, §4.11: the triangles with crank and coupler in line.
#[test]
fn the_wiper_wipes_its_angle() {
    let request = LimitsRequest { drive: Some("A.angle".into()), ..LimitsRequest::default() };
    let found = limits(example("wiper"), &request).expect("limits");
    let range = found.branches[0].ranges.iter().find(|range| range.name == "D.angle");
    let range = range.expect("a range");
    let (a, b, c, g) = (0.05_f64, 0.29_f64, 0.075_f64, 0.3_f64.hypot(0.08));
    let at = |side: f64| ((g * g + c * c - side * side) / (2.0 * g * c)).acos();
    near(range.max - range.min, at(b + a) - at(b - a), 1e-12);
}

/// The region of the bucket's pin lies between the circles that the lengths of boom and stick allow.
#[test]
fn the_bucket_reaches_no_farther_than_boom_and_stick() {
    let found = workspaces(example("excavator"), &["stick.T".into()]).expect("a workspace");
    assert!(found[0].area > 1.0, "{}", found[0].area);
    for p in found[0].boundary.iter().flatten() {
        let distance = p[0].hypot(p[1] - 1.5);
        assert!((1.6 - 1e-9..=5.6 + 1e-9).contains(&distance), "{p:?}");
    }
}
