//! Balls, points and planes that touch in space and rub in every direction, against closed forms.

use std::fmt::Write as _;

use bksim::sim::hybrid::ChangeKind;

use crate::support::{Measures, Within, at, close, derive, model, signal, solve};

const G: f64 = 9.81;

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// A ball on the floor of the ground.
fn ball(name: &str, initial: &str) -> String {
    format!(
        "[bodies.{name}]\nmass = 0.2\ninertia = [5e-5, 5e-5, 5e-5]\npoints = {{ C = [0, 0, 0] }}\nfree = true\n\
         [initial]\n{name} = {initial}\n"
    )
}

/// m, and r of I = 2/5 m r².
const MASS: f64 = 0.2;
const RADIUS: f64 = 0.025;

fn table(solve: &str, bodies: &str, contacts: &str) -> String {
    format!(
        "space = \"spatial\"\n[ground]\npoints = {{ O = [0, 0, 0] }}\n{bodies}{contacts}\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, 0, -{G}]\n\
         [solve]\n{solve}\nrtol = 1e-10\natol = 1e-11\n"
    )
}

fn floor(mu: f64, restitution: f64) -> String {
    format!(
        "[contacts.floor]\nbetween = [{{ plane = \"ground.O\" }}, {{ ball = \"ball.C\", radius = {RADIUS} }}]\n\
         mu = {mu}\nrestitution = {restitution}\n"
    )
}

/// Coriolis: the slip w = v + ω × (−r z) keeps its direction and falls by 7/2 μ g, so the ball follows a parabola until
/// 2 |w|/(7 μ g) and then rolls straight on with (5 v + 2 r (ω_y, −ω_x))/7.
#[test]
fn a_ball_with_sidespin_follows_a_parabola_until_it_rolls() {
    let (mu, v, w) = (0.2, [1.0, 0.0], [40.0, -60.0, 25.0]);
    let slip = [v[0] - RADIUS * w[1], v[1] + RADIUS * w[0]];
    let speed = slip[0].hypot(slip[1]);
    let until = 2.0 * speed / (7.0 * mu * G);
    let way = slip.map(|part| part / speed);
    let last = [(5.0 * v[0] + 2.0 * RADIUS * w[1]) / 7.0, (5.0 * v[1] - 2.0 * RADIUS * w[0]) / 7.0];
    let start = format!(
        "{{ x = 0, y = 0, z = {RADIUS}, vx = {}, vy = {}, vz = 0, w = {w:?} }}",
        v[0], v[1]
    );
    let text = table("t_end = 1.2\nevery = 0.05", &ball("ball", &start), &floor(mu, 0.0));
    let text = format!(
        "{text}[outputs]\nN = \"contacts.floor.force\"\nF = \"contacts.floor.friction\"\nslip = \"contacts.floor.slip\"\n"
    );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let names = ["ball.x", "ball.y", "ball.vx", "ball.vy", "ball.wx", "ball.wy", "ball.wz"];
    let measures = Measures::new(&mechanism, &names);
    for sample in &motion.samples {
        let what = format!("at {} s", sample.t);
        let found = measures.at(sample);
        let t = sample.t.min(until);
        for k in 0..2 {
            let along = |t: f64| v[k] * t - 0.5 * mu * G * t * t * way[k];
            close(&what, found[k], along(t) + (sample.t - t) * last[k], within(1e-9));
            close(&what, found[2 + k], v[k] - mu * G * t * way[k], within(1e-9));
        }
        close(&what, found[6], w[2], within(1e-9));
        let is_sliding = sample.t < until;
        close(&what, signal(&mechanism, sample, "N"), MASS * G, within(1e-8));
        let friction = if is_sliding { mu * MASS * G } else { 0.0 };
        close(&what, signal(&mechanism, sample, "F"), friction, within(1e-8));
        let left = if is_sliding { speed - 3.5 * mu * G * t } else { 0.0 };
        close(&what, signal(&mechanism, sample, "slip"), left, within(1e-8));
    }
    let rolls = motion.summary.changes.iter().find(|c| matches!(c.kind, ChangeKind::Stick(_)));
    close("rolls", rolls.expect("a ball that rolls").t, until, within(1e-9));
    let lost = 0.5 * MASS * speed * speed / 3.5;
    let energy = |k: usize| motion.samples[k].energy.kinetic;
    close("energy", energy(0) - energy(motion.samples.len() - 1), lost, within(1e-9));
    let audit = &motion.summary.energy;
    assert!(audit.worst_error <= 1e-8 * audit.scale, "{} of {}", audit.worst_error, audit.scale);
}

/// Garwin and Cross: a ball that lands slips through the impact while its slip is above 7/2 μ (1 + ε) u, and else grips, with
/// the slip zero after it; both along the slip, which is askew here.
#[test]
fn a_ball_bounces_with_spin_by_slipping_or_gripping() {
    let (height, restitution, v, spin): (f64, f64, [f64; 2], [f64; 3]) =
        (0.5, 0.8, [0.9, -1.2], [30.0, 20.0, 7.0]);
    let u = (2.0 * G * height).sqrt();
    let until = u / G;
    for (mu, slips) in [(0.02, true), (0.6, false)] {
        let start = format!(
            "{{ x = 0, y = 0, z = {}, vx = {}, vy = {}, vz = 0, w = {spin:?} }}",
            RADIUS + height,
            v[0],
            v[1]
        );
        let text =
            table("t_end = 0.4\nevery = 0.4", &ball("ball", &start), &floor(mu, restitution));
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let measures = Measures::new(
            &mechanism,
            &["ball.vx", "ball.vy", "ball.vz", "ball.wx", "ball.wy", "ball.wz"],
        );
        let found = measures.at(motion.samples.last().expect("a sample"));
        let slip = [v[0] - RADIUS * spin[1], v[1] + RADIUS * spin[0]];
        let speed = slip[0].hypot(slip[1]);
        let most = mu * (1.0 + restitution) * u;
        let change = if slips { most } else { speed / 3.5 };
        assert_eq!(3.5 * most < speed, slips, "{most} and {speed}");
        for k in 0..2 {
            close("velocity", found[k], v[k] - change * slip[k] / speed, within(1e-9));
        }
        close("upwards", found[2], restitution * u - G * (0.4 - until), within(1e-9));
        let turned = 2.5 * change / RADIUS;
        close("wx", found[3], spin[0] - turned * slip[1] / speed, within(1e-8));
        close("wy", found[4], spin[1] + turned * slip[0] / speed, within(1e-8));
        close("wz", found[5], spin[2], within(1e-9));
    }
}

/// Balls of one mass, without friction: the one at rest takes the part of the velocity along the line of centres. With
/// friction and ε = 1: that slips, a tangential impulse μ of the normal one on both.
#[test]
fn balls_meet_off_their_centres() {
    let cosine = 0.8_f64;
    for mu in [0.0, 0.1] {
        let first = ball(
            "ball",
            &format!(
                "{{ x = -0.2, y = {}, z = 0, vx = 2, vy = 0, vz = 0, w = [0, 0, 0] }}",
                0.6 * 2.0 * RADIUS
            ),
        );
        let second = "[bodies.other]\nmass = 0.2\ninertia = [5e-5, 5e-5, 5e-5]\npoints = { C = [0, 0, 0] }\nfree = true\n";
        let contact = format!(
            "other = {{ x = 0, y = 0, z = 0, vx = 0, vy = 0, vz = 0, w = [0, 0, 0] }}\n\
             [contacts.hit]\nbetween = [{{ ball = \"ball.C\", radius = {RADIUS} }}, {{ ball = \"other.C\", radius = {RADIUS} }}]\n\
             restitution = 1\nmu = {mu}\n"
        );
        let text = table("t_end = 0.2\nevery = 0.2", &format!("{second}{first}"), &contact)
            .replace(&format!("-{G}"), "0");
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let measures = Measures::new(
            &mechanism,
            &["ball.vx", "ball.vy", "other.vx", "other.vy", "ball.wz", "other.wz"],
        );
        let found = measures.at(motion.samples.last().expect("a sample"));
        // From the first centre to the second: (0.8, −0.6). The slip of the first along (0.6, 0.8): 1.2 m/s.
        let normal = 2.0 * cosine;
        let friction: f64 = mu * normal;
        assert!(3.5 * 2.0 * friction < 1.2, "it slips");
        let other = [normal * 0.8 + friction * 0.6, -normal * 0.6 + friction * 0.8];
        close("other.vx", found[2], other[0], within(1e-9));
        close("other.vy", found[3], other[1], within(1e-9));
        close("ball.vx", found[0], 2.0 - other[0], within(1e-9));
        close("ball.vy", found[1], -other[1], within(1e-9));
        let spin = -2.5 * friction / RADIUS;
        close("ball.wz", found[4], spin, within(1e-8));
        close("other.wz", found[5], spin, within(1e-8));
    }
}

/// Three feet at the height of the centre of mass slide on a plane that falls along x by the angle σ of friction, μ = tan σ:
/// v′ = g sin σ (x − v/|v|), so the speed and its part down the slope keep their sum, |v| + v_x.
#[test]
fn a_block_slides_down_a_slope_askew_with_its_speed_and_descent_in_balance() {
    let slope = 0.3_f64;
    let (sin, cos) = slope.sin_cos();
    let text = format!(
        "space = \"spatial\"\n[ground]\npoints = {{ O = [0, 0, 0] }}\n\
         [bodies.block]\nmass = 2\ninertia = [0.02, 0.02, 0.02]\n\
         points = {{ a = [0.1, 0, 0], b = [-0.05, 0.08, 0], c = [-0.05, -0.08, 0] }}\nfree = true\n\
         [contacts.floor]\nbetween = [{{ plane = \"ground.O\" }}, {{ points = [\"block.a\", \"block.b\", \"block.c\"] }}]\n\
         mu = {}\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [{}, 0, {}]\n\
         [initial]\nblock = {{ x = 0, y = 0, z = 0, vx = 0, vy = 1.5, vz = 0, w = [0, 0, 0] }}\n\
         [solve]\nt_end = 1\nevery = 0.1\nrtol = 1e-10\natol = 1e-11\n",
        slope.tan(),
        G * sin,
        -G * cos
    );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["block.vx", "block.vy", "block.wz", "block.z"]);
    for sample in &motion.samples {
        let what = format!("at {} s", sample.t);
        let [vx, vy, wz, z] = measures.at(sample)[..] else { unreachable!("four measures") };
        let speed = vx.hypot(vy);
        close(&what, speed + vx, 1.5, within(1e-8));
        close(&what, wz, 0.0, within(1e-8));
        close(&what, z, 0.0, within(1e-9));
    }
    // The first component obeys v_x′ = g sin (1 − v_x/|v|), |v| = 1.5 − v_x: t = ∫ |v|/(|v| − v_x) dv_x/(g sin).
    let last = measures.at(at(&motion, 1.0));
    let x = last[0];
    let time = (0.5 * x - 0.375 * (1.0 - 2.0 * x / 1.5).ln()) / (G * sin);
    close("time", time, 1.0, within(1e-7));
}

/// A ball that rolls on a turntable: v′ = 2/7 Ω z × v, a circle.
#[test]
fn a_ball_rolls_in_a_circle_on_a_turntable() {
    let rate = 3.0;
    let text = table(
        "t_end = 3\nevery = 0.5",
        &format!(
            "[bodies.table]\nmass = 5\ninertia = [1, 1, 1]\npoints = {{ T = [0, 0, 0] }}\n\
             [joints.axle]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"table.T\"]\n\
             [drives.motor]\njoint = \"axle\"\nmotion = \"{rate}*t\"\n{}",
            // At rest on the table: v − r ω × z = Ω z × r.
            ball(
                "ball",
                &format!(
                    "{{ x = 0.3, y = 0, z = {RADIUS}, vx = 0, vy = 0.5, vz = 0, w = [{}, 0, 0] }}",
                    (0.9 - 0.5) / RADIUS
                )
            )
        ),
        "[contacts.face]\nbetween = [{ plane = \"table.T\" }, { ball = \"ball.C\", radius = 0.025 }]\nmu = 2\n",
    );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["ball.x", "ball.y", "ball.vx", "ball.vy"]);
    let turn = 2.0 / 7.0 * rate;
    for sample in &motion.samples {
        let what = format!("at {} s", sample.t);
        let (sin, cos) = (turn * sample.t).sin_cos();
        let found = measures.at(sample);
        close(&what, found[0], 0.3 - 0.5 / turn * (1.0 - cos), within(1e-8));
        close(&what, found[1], 0.5 / turn * sin, within(1e-8));
        close(&what, found[2], -0.5 * sin, within(1e-8));
        close(&what, found[3], 0.5 * cos, within(1e-8));
    }
}

const BLOCK: &str = "[bodies.block]\nmass = 2\ninertia = [0.02, 0.02, 0.02]\n\
     points = { a = [0.1, 0, 0], b = [-0.05, 0.08, 0], c = [-0.05, -0.08, 0] }\nfree = true\n\
     [contacts.floor]\nbetween = [{ plane = \"ground.O\" }, { points = [\"block.a\", \"block.b\", \"block.c\"] }]\n";

/// A force that grows by 10 N/s askew holds until it is `static` m g, in both directions together, and moves the block along itself.
#[test]
fn a_block_lets_go_where_both_directions_of_its_friction_reach_one_limit() {
    let (mass, mu, most) = (2.0, 0.3, 0.4);
    let text = table(
        "t_end = 1.5\nevery = 0.25",
        &format!("{BLOCK}mu = {mu}\nstatic = {most}\n"),
        "[loads.pull]\ntype = \"force\"\non = \"block\"\nvector = [\"6 N/s*t\", \"8 N/s*t\", 0]\n\
         [initial]\nblock = { x = 0, y = 0, z = 0, vx = 0, vy = 0, vz = 0, w = [0, 0, 0] }\n",
    );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let slides = motion.summary.changes.iter().find(|c| matches!(c.kind, ChangeKind::Slide(_)));
    let from = most * mass * G / 10.0;
    close("slides", slides.expect("a block that slides").t, from, within(1e-9));
    let measures = Measures::new(&mechanism, &["block.vx", "block.vy", "block.wz"]);
    for sample in &motion.samples {
        let what = format!("at {} s", sample.t);
        let found = measures.at(sample);
        let t = sample.t.max(from);
        let speed = 5.0 / mass * (t * t - from * from) - mu * G * (t - from);
        close(&what, found[0], 0.6 * speed, within(1e-8));
        close(&what, found[1], 0.8 * speed, within(1e-8));
        close(&what, found[2], 0.0, within(1e-8));
    }
}

/// A box that is thrown on the floor comes to rest on four corners, which share its weight; its energy is accounted for.
#[test]
fn a_box_tumbles_until_it_rests_on_four_corners() {
    let corners = [
        (1, 1, 1),
        (-1, 1, 1),
        (-1, -1, 1),
        (1, -1, 1),
        (1, 1, -1),
        (-1, 1, -1),
        (-1, -1, -1),
        (1, -1, -1),
    ];
    let points: Vec<String> = (corners.iter().enumerate())
        .map(|(k, (x, y, z))| format!("p{k} = [\"{x}*0.1\", \"{y}*0.08\", \"{z}*0.05\"]"))
        .collect();
    let names: Vec<String> = (0..8).map(|k| format!("\"box.p{k}\"")).collect();
    let text = table(
        "t_end = 1\nevery = 0.5",
        &format!(
            "[bodies.box]\nmass = 2\ninertia = [0.02, 0.03, 0.04]\nfree = true\npoints = {{ {} }}\n\
             [contacts.floor]\nbetween = [{{ plane = \"ground.O\" }}, {{ points = [{}] }}]\nmu = 0.4\nrestitution = 0.3\n",
            points.join(", "),
            names.join(", ")
        ),
        "[initial]\nbox = { x = 0, y = 0, z = 0.3, vx = 0.5, vy = -0.2, vz = 0, w = [1, 2, 3] }\n\
         [outputs]\nN = \"contacts.floor.force\"\n",
    );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let last = motion.samples.last().expect("a sample");
    assert!(last.v.iter().all(|v| v.abs() < 1e-9), "{:?}", last.v);
    close("N", signal(&mechanism, last, "N"), 2.0 * G, within(1e-8));
    let z = Measures::new(&mechanism, &["box.z"]).at(last)[0];
    close("z", z, 0.05, within(1e-9));
    let audit = &motion.summary.energy;
    assert!(audit.worst_error <= 1e-8 * audit.scale, "{} of {}", audit.worst_error, audit.scale);
}

/// m g (R − r)(cos θ₀ − cos θ) = 7/10 m v² of a ball that rolls in a bowl, through its lowest place and round it.
#[test]
fn a_ball_rolls_in_a_bowl_without_loss() {
    let (reach, lean): (f64, f64) = (0.3 - RADIUS, 0.6);
    let place = format!("x = {}, y = 0, z = {}", reach * lean.sin(), -reach * lean.cos());
    let text = table(
        "t_end = 2\nevery = 0.1",
        &ball("ball", &format!("{{ {place}, vx = 0, vy = 0.35, vz = 0, w = [0, 0, 0] }}")),
        &format!(
            "[contacts.bowl]\nbetween = [{{ bowl = \"ground.O\", radius = 0.3 }}, {{ ball = \"ball.C\", radius = {RADIUS} }}]\nmu = 5\n"
        ),
    )
    // Rolling: the slip v + ω × r n is zero, n from the centre of the bowl.
    .replace("w = [0, 0, 0]", &format!("w = [{}, 0, {}]", -0.35 * lean.cos() / RADIUS, -0.35 * lean.sin() / RADIUS));
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["ball.x", "ball.y", "ball.z"]);
    let first = motion.samples[0].energy;
    for sample in &motion.samples {
        let what = format!("at {} s", sample.t);
        let [x, y, z] = measures.at(sample)[..] else { unreachable!("three measures") };
        close(&what, (x * x + y * y + z * z).sqrt(), reach, within(1e-9));
        let energy = sample.energy;
        let [total, before] = [energy, first].map(|e| e.kinetic + e.potential);
        close(&what, total, before, within(1e-9));
    }
}

/// A conveyor goes at 1.2 m/s along x, the block comes across it at 0.9 m/s: the slip is straight as seen from the conveyor, and ends after
/// |w|/(μ g); then the block goes with it.
#[test]
fn a_block_comes_to_rest_on_a_conveyor_on_a_parabola() {
    let mu = 0.25;
    let (belt, across) = (1.2_f64, 0.9_f64);
    let speed = belt.hypot(across);
    let text = table(
        "t_end = 1\nevery = 0.1",
        &format!(
            "[bodies.conveyor]\nmass = 50\ninertia = [1, 1, 1]\npoints = {{ T = [0, 0, 0] }}\n\
             [joints.guide]\ntype = \"prismatic\"\nbetween = [\"ground.O\", \"conveyor.T\"]\naxis = [1, 0, 0]\n\
             [drives.motor]\njoint = \"guide\"\nmotion = \"{belt}*t\"\n{BLOCK}mu = {mu}\n"
        )
        .replace("ground.O\" }, { points", "conveyor.T\" }, { points"),
        &format!(
            "[initial]\nblock = {{ x = 0, y = 0, z = 0, vx = 0, vy = {across}, vz = 0, w = [0, 0, 0] }}\n"
        ),
    );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &["block.x", "block.y", "block.vx", "block.vy"]);
    let until = speed / (mu * G);
    let pull = [mu * G * belt / speed, -mu * G * across / speed];
    for sample in &motion.samples {
        let what = format!("at {} s", sample.t);
        let found = measures.at(sample);
        let t = sample.t.min(until);
        let rest = sample.t - t;
        close(&what, found[0], 0.5 * pull[0] * t * t + belt * rest, within(1e-9));
        close(&what, found[1], across * t + 0.5 * pull[1] * t * t, within(1e-9));
        close(&what, found[2], pull[0] * t, within(1e-9));
        close(&what, found[3], across + pull[1] * t, within(1e-9));
    }
    let sticks = motion.summary.changes.iter().find(|c| matches!(c.kind, ChangeKind::Stick(_)));
    close("sticks", sticks.expect("a block that sticks").t, until, within(1e-9));
}

/// Five equal balls with gaps, without loss: the velocity goes through, askew in space, and only the last one moves.
#[test]
fn a_row_of_balls_passes_the_velocity_on_to_the_last() {
    let way = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
    let (mut bodies, mut contacts, mut initial) =
        (String::new(), String::new(), "[initial]\n".to_owned());
    for k in 0..5_u8 {
        let along = f64::from(k) * (2.0 * RADIUS + 1e-4) + if k == 0 { -0.05 } else { 0.0 };
        let [x, y, z] = way.map(|part| part * along);
        let [vx, vy, vz] = way.map(|part| if k == 0 { part } else { 0.0 });
        let _ = writeln!(
            bodies,
            "[bodies.b{k}]\nmass = 0.2\ninertia = [5e-5, 5e-5, 5e-5]\npoints = {{ C = [0, 0, 0] }}\nfree = true"
        );
        let _ = writeln!(
            initial,
            "b{k} = {{ x = {x}, y = {y}, z = {z}, vx = {vx}, vy = {vy}, vz = {vz}, w = [0, 0, 0] }}"
        );
        if k > 0 {
            let _ = writeln!(
                contacts,
                "[contacts.c{k}]\nbetween = [{{ ball = \"b{}.C\", radius = {RADIUS} }}, {{ ball = \"b{k}.C\", radius = {RADIUS} }}]\n\
                 restitution = 1\nmu = 0.2",
                k - 1
            );
        }
    }
    let text = table("t_end = 0.1\nevery = 0.1", &bodies, &(contacts + &initial))
        .replace(&format!("-{G}"), "0");
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let names: Vec<String> =
        (0..5).flat_map(|k| ["vx", "vy", "vz"].map(|part| format!("b{k}.{part}"))).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let found = Measures::new(&mechanism, &names).at(motion.samples.last().expect("a sample"));
    for (k, part) in found.iter().enumerate() {
        let expected = if k < 12 { 0.0 } else { way[k - 12] };
        close(names[k], *part, expected, within(1e-9));
    }
}
