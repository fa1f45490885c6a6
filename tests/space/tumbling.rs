//! Bodies that turn about all axes: a free body against Jacobi's elliptic functions, a top, a pendulum on
//! a ball that swings through the pole of three angles, loops over ball joints, and what is measured of them.

use crate::support::{Measures, Within, at, close, derive, model, solve};
use bksim::Motion;
use bksim::model::Method;
use bksim::sim::run::Sample;

/// sn, cn and dn of the argument `u` and the parameter m = k², by arithmetic and geometric means.
///
/// Source: M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions* (1964), §16.4.
fn jacobi(u: f64, m: f64) -> [f64; 3] {
    let mut means = vec![(1.0_f64, m.sqrt())];
    let mut b = (1.0 - m).sqrt();
    while let Some(&(a, c)) = means.last()
        && c > f64::EPSILON
    {
        means.push((a.midpoint(b), (a - b) / 2.0));
        b = (a * b).sqrt();
    }
    let n = means.len() - 1;
    let mut phase = f64::from(1 << n) * means[n].0 * u;
    let mut last = phase;
    for &(a, c) in means[1..].iter().rev() {
        last = phase;
        phase = (c / a * phase.sin()).asin().midpoint(phase);
    }
    let cn = phase.cos();
    [phase.sin(), cn, if n == 0 { 1.0 } else { cn / (last - phase).cos() }]
}

#[test]
fn elliptic_functions_have_their_known_values() {
    // K(1/2) = 1.8540746773013719 (Abramowitz and Stegun, table 17.1): sn K/2 = (1 + k′)^−½.
    let half = 1.854_074_677_301_371_9 / 2.0;
    let [sn, cn, dn] = jacobi(half, 0.5);
    close("sn", sn, 1.0 / (1.0 + 0.5_f64.sqrt()).sqrt(), EXACT);
    close("sn² + cn²", sn * sn + cn * cn, 1.0, EXACT);
    close("dn² + m sn²", dn * dn + 0.5 * sn * sn, 1.0, EXACT);
}

const EXACT: Within = Within { relative: 1e-14, absolute: 1e-14 };

/// Moments of inertia of a free body, and its angular velocity at the start about the axes of the least
/// and of the greatest: a little aside from the turning about the middle axis, to which it comes back.
const MOMENTS: [f64; 3] = [0.2, 0.3, 0.4];
const SPIN: [f64; 2] = [1.4, 1.0];

/// A free body with its angular momentum along the vertical.
fn free_body(rest: &str) -> String {
    let lean = -(MOMENTS[0] * SPIN[0]).atan2(MOMENTS[2] * SPIN[1]);
    format!(
        "space = \"spatial\"\n[bodies.rod]\nmass = 2\ninertia = {MOMENTS:?}\nfree = true\n{rest}\n\
         [initial]\nrod = {{ x = 0, y = 0, z = 0, vx = 0.1, vy = 0, vz = 0, rpy = [0, {lean:?}, 0], \
         w = [{:?}, 0, {:?}], frame = \"body\" }}\n\
         [solve]\nt_end = 50\nevery = 0.5\nrtol = 1e-11\natol = 1e-12\n",
        SPIN[0], SPIN[1]
    )
}

/// ω of the free body at a time, body axes (L. D. Landau, E. M. Lifshitz, *Mechanics*, §37).
fn free_spin(t: f64) -> [f64; 3] {
    let [i, j, k] = MOMENTS;
    let [p, r] = SPIN;
    let twice_energy = i * p * p + k * r * r;
    let square = (i * p).powi(2) + (k * r).powi(2);
    let (low, high) = (square - twice_energy * i, twice_energy * k - square);
    assert!(square > twice_energy * j, "the axis of the greatest moment leads");
    let m = (j - i) * high / ((k - j) * low);
    let [sn, cn, dn] = jacobi(t * ((k - j) * low / (i * j * k)).sqrt(), m);
    let size = |of: f64, own: f64, other: f64| (of / (own * other)).sqrt();
    [cn * size(high, i, k - i), sn * size(high, j, k - j), dn * size(low, k, k - i)]
}

#[test]
fn a_free_body_follows_jacobis_elliptic_functions_with_its_flips() {
    let mechanism = derive(model(&free_body("")));
    let motion = solve(&mechanism);
    let names = ["rod.wx_body", "rod.wy_body", "rod.wz_body", "rod.lx", "rod.ly", "rod.lz"];
    let measures = Measures::new(&mechanism, &[&names[..], &["rod.cxz", "rod.cyz"]].concat());
    let [i, j, k] = MOMENTS;
    let momentum = ((i * SPIN[0]).powi(2) + (k * SPIN[1]).powi(2)).sqrt();
    let within = Within { relative: 0.0, absolute: 1e-9 };
    let mut turned = 0.0;
    let mut last: f64 = 0.0;
    let mut flips = 0;
    for sample in &motion.samples {
        let found = measures.at(sample);
        let spin = free_spin(sample.t);
        for axis in 0..3 {
            close(&format!("{} at {} s", names[axis], sample.t), found[axis], spin[axis], within);
        }
        for (axis, value) in [0.0, 0.0, momentum].into_iter().enumerate() {
            close(names[3 + axis], found[3 + axis], value, within);
        }
        // The precession of the third axis about the momentum, by Simpson's rule.
        let rate = |t: f64| {
            let [p, q, _] = free_spin(t);
            momentum * (i * p * p + j * q * q) / ((i * p).powi(2) + (j * q).powi(2))
        };
        let n = 400;
        let h = (sample.t - last) / f64::from(n);
        turned += (0..n)
            .map(|s| {
                let from = last + h * f64::from(s);
                h / 6.0 * (rate(from) + 4.0 * rate(from + h / 2.0) + rate(from + h))
            })
            .sum::<f64>();
        flips += usize::from(spin[0] * free_spin(last)[0] < 0.0);
        last = sample.t;
        let level = (i * spin[0]).hypot(j * spin[1]) / momentum;
        close("azimuth, cosine", found[6], -level * turned.cos(), within);
        close("azimuth, sine", found[7], -level * turned.sin(), within);
    }
    assert!(flips >= 4, "{flips} flips");
}

/// A symmetric top of 15 cm on a ball joint, which leans by 40° and spins at 150 rad/s.
fn top(t_end: f64, rest: &str) -> String {
    format!(
        "space = \"spatial\"\n[bodies.top]\nmass = 0.5\ninertia = [\"8e-4 kg m^2\", \"8e-4 kg m^2\", \
         \"4e-4 kg m^2\"]\ncom = [0, 0, 0.05]\n\
         [joints.tip]\ntype = \"spherical\"\nbetween = [\"ground\", \"top\"]\n{rest}\n\
         [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
         [initial]\ntop = {{ rpy = [\"40 deg\", 0, 0], w = [0, 0, 150], frame = \"body\" }}\n\
         [solve]\nt_end = {t_end:?}\nevery = {:?}\nrtol = 1e-12\natol = 1e-13\n",
        t_end / 100.0
    )
}

#[test]
fn a_top_keeps_energy_and_both_momenta_over_1000_s() {
    let mechanism = derive(model(&top(1000.0, "")));
    let motion = solve(&mechanism);
    // About its own axis, and about the vertical through the tip.
    let measures = Measures::new(&mechanism, &["top.wz_body", "mechanism.lz"]);
    let first = measures.at(&motion.samples[0]);
    let energy = |sample: &Sample| sample.energy.kinetic + sample.energy.potential;
    let within = Within { relative: 1e-9, absolute: 0.0 };
    for sample in &motion.samples {
        let found = measures.at(sample);
        close("energy", energy(sample), energy(&motion.samples[0]), within);
        close("momentum about the axis", found[0], first[0], within);
        close("momentum about the vertical", found[1], first[1], within);
    }
}

/// A pendulum on a ball joint that swings about the y axis, through `angle2` = ±90°, or with both frames
/// turned about z, about x.
fn pendulum(frame: &str, rest: &str) -> String {
    format!(
        "space = \"spatial\"\n\
         [ground.points]\nA = {{ at = [0, 0, 0], {frame} }}\n\
         [bodies.bob]\nmass = 1\ninertia = [0.02, 0.03, 0.04]\ncom = [0, 0, -0.5]\n\
         points.A = {{ at = [0, 0, 0], {frame} }}\n\
         [joints.ball]\ntype = \"spherical\"\nbetween = [\"ground.A\", \"bob.A\"]\n{rest}\n\
         [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
         [initial]\nbob = {{ w = [0.05, \"9.5 rad/s\", 0.02] }}\n\
         [solve]\nt_end = 10\nevery = 0.02\nrtol = 1e-10\natol = 1e-11\n"
    )
}

fn n_steps(motion: &Motion) -> usize {
    motion.summary.stats.n_accept
}

#[test]
fn a_pendulum_passes_the_pole_in_the_steps_that_it_takes_elsewhere() {
    let [through, aside] = ["rpy = [0, 0, 0]", "rpy = [0, 0, \"90 deg\"]"].map(|frame| {
        let mechanism = derive(model(&pendulum(frame, "")));
        let motion = solve(&mechanism);
        let measures = Measures::new(&mechanism, &["ball.angle2", "bob.x", "bob.y", "bob.z"]);
        let rows: Vec<Vec<f64>> = motion.samples.iter().map(|s| measures.at(s)).collect();
        (n_steps(&motion), rows)
    });
    let steepest = through.1.iter().map(|row| row[0].abs()).fold(0.0, f64::max);
    assert!(steepest > 1.4, "it comes to {steepest} rad");
    assert!(through.0.abs_diff(aside.0) * 50 <= aside.0, "{} and {} steps", through.0, aside.0);
    for (a, b) in through.1.iter().zip(&aside.1) {
        for axis in 1..4 {
            close("position", a[axis], b[axis], Within { relative: 0.0, absolute: 1e-7 });
        }
    }
}

#[test]
fn tree_and_cut_move_alike_and_have_the_same_reactions() {
    let [tree, cut] = ["", "cut = true"].map(|keys| {
        let mechanism = derive(model(&pendulum("rpy = [0.2, 0.3, 0]", keys)));
        let motion = solve(&mechanism);
        let measures = Measures::new(&mechanism, &["bob.x", "bob.y", "bob.z", "bob.cxy", "bob.wz"]);
        let row = |s: &Sample| [measures.at(s), s.reactions[0].to_vec()].concat();
        motion.samples.iter().map(row).collect::<Vec<_>>()
    });
    for (a, b) in tree.iter().zip(&cut) {
        for (a, b) in a.iter().zip(b) {
            close("tree and cut", *a, *b, Within { relative: 1e-6, absolute: 1e-6 });
        }
    }
}

#[test]
fn a_quaternion_takes_no_freedom_and_no_reaction() {
    let mechanism = derive(model(&pendulum("rpy = [0, 0, 0]", "")));
    let start = mechanism.start().expect("a start");
    assert_eq!(start.mobility, 3);
    let mobility = bksim::sim::mobility::mobility(&mechanism.model, &mechanism.system, &start);
    assert_eq!((mobility.gruebler, mobility.mobility, mobility.n_redundant), (3, 3, 0));
    assert!(start.uniqueness.is_complete());
    let motion = solve(&mechanism);
    let largest = motion.samples.iter().flat_map(|s| &s.lambda).map(|x| x.abs());
    let largest = largest.fold(0.0, f64::max);
    assert!(largest < 1e-9, "the multiplier of the length is {largest}");
}

#[test]
fn radau_follows_the_same_motion_in_every_formulation() {
    use bksim::model::Formulation;
    let reference = {
        let mechanism = derive(model(&pendulum("rpy = [0, 0, 0]", "")));
        let motion = solve(&mechanism);
        Measures::new(&mechanism, &["bob.x", "bob.y", "bob.z"]).at(at(&motion, 2.0))
    };
    for formulation in
        [Formulation::Ggl, Formulation::Index2, Formulation::Index3, Formulation::Index1]
    {
        let mut model = model(&pendulum("rpy = [0, 0, 0]", ""));
        (model.solve.t_end, model.solve.method) = (2.0, Method::Radau);
        model.solve.formulation = formulation;
        let mechanism = derive(model);
        let motion = mechanism.solve().unwrap_or_else(|e| panic!("{formulation:?}: {e}"));
        let found = Measures::new(&mechanism, &["bob.x", "bob.y", "bob.z"]).at(at(&motion, 2.0));
        for (a, b) in found.iter().zip(&reference) {
            close(&format!("{formulation:?}"), *a, *b, Within { relative: 0.0, absolute: 1e-6 });
        }
    }
}

/// Accepted steps by quaternions, and by angles that `names` makes the coordinates of.
fn steps(text: &str, names: &str) -> [f64; 2] {
    ["", names].map(|names| {
        let motion = solve(&derive(model(&text.replace("#NAMES", names))));
        let n = u32::try_from(n_steps(&motion)).expect("a run of few steps");
        f64::from(n)
    })
}

/// The ratios that `docs/theory.md` states.
#[test]
fn quaternions_save_steps_where_bodies_tumble_and_cost_some_in_a_fast_spin() {
    let three = "coordinate = [\"a\", \"b\", \"c\"]";
    // A free body.
    let text = free_body("#NAMES").replace("w = [1.4, 0, 1.0]", "w = [0.3, 0.2, 1.0]");
    let six = "coordinates = [\"x\", \"y\", \"z\", \"a\", \"b\", \"c\"]";
    let [quaternion, angles] = steps(&text, six);
    assert!(quaternion < 0.6 * angles, "free body: {quaternion} and {angles} steps");
    // A pendulum that nearly meets the pole.
    let near = pendulum("rpy = [0, 0, 0]", "#NAMES").replace("rtol = 1e-10", "rtol = 1e-6");
    let [quaternion, angles] = steps(&near, three);
    assert!(quaternion < 0.3 * angles, "pole: {quaternion} and {angles} steps");
    // A fast top.
    let [quaternion, angles] = steps(&top(1.0, "#NAMES"), three);
    assert!(angles < 0.7 * quaternion, "top: {quaternion} and {angles} steps");
}

/// A crank and a rocker about crossed axes, with a rod on two ball joints between them.
const LINKAGE: &str = include_str!("../fixtures/spatial-four-bar.toml");

#[test]
fn a_loop_closes_over_ball_joints_in_the_tree_and_cut() {
    let cut = LINKAGE.replace("type = \"spherical\"", "type = \"spherical\", cut = true");
    let absolute = format!("coordinates = \"absolute\"\n{LINKAGE}");
    let mut ends: Vec<Vec<f64>> = Vec::new();
    for text in [LINKAGE, &cut, &absolute] {
        let mechanism = derive(model(text));
        let start = mechanism.start().expect("it closes");
        assert_eq!((start.mobility, start.uniqueness.is_complete()), (2, true));
        let motion = solve(&mechanism);
        let names = ["crank.cxx", "rocker.cxz", "rod.x", "rod.y", "rod.z", "rod.wx_body"];
        ends.push(Measures::new(&mechanism, &names).at(at(&motion, 1.0)));
    }
    for other in &ends[1..] {
        for (a, b) in ends[0].iter().zip(other) {
            close("the end", *a, *b, Within { relative: 1e-6, absolute: 1e-6 });
        }
    }
}

#[test]
fn momentum_of_the_whole_is_kept_where_nothing_acts_from_outside() {
    // Two bodies on a ball joint, with a spring between them, which float.
    let text = "space = \"spatial\"\n\
        [bodies.a]\nmass = 1\ninertia = [0.1, 0.2, 0.3]\nfree = true\npoints = { P = [0.5, 0, 0], Q = [0, 0.3, 0] }\n\
        [bodies.b]\nmass = 2\ninertia = [0.2, 0.1, 0.2]\npoints = { P = [-0.4, 0, 0], Q = [0, 0, 0.3] }\n\
        [joints.ball]\ntype = \"spherical\"\nbetween = [\"a.P\", \"b.P\"]\n\
        [loads.s]\ntype = \"spring\"\nbetween = [\"a.Q\", \"b.Q\"]\nstiffness = 50\nlength = 0.3\n\
        [initial]\na = { x = 0.2, vx = 1, vy = -0.5, w = [1, 2, 3] }\nb = { w = [-2, 1, 0.5], frame = \"body\" }\n\
        [solve]\nt_end = 5\nevery = 0.5\nrtol = 1e-11\natol = 1e-12\n";
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let names = ["px", "py", "pz", "lx", "ly", "lz"].map(|word| format!("mechanism.{word}"));
    let all = Measures::new(&mechanism, &names.each_ref().map(String::as_str));
    let first = all.at(&motion.samples[0]);
    assert!(first.iter().all(|value| value.abs() > 1e-3), "{first:?}");
    for sample in &motion.samples {
        for ((name, found), first) in names.iter().zip(all.at(sample)).zip(&first) {
            close(name, found, *first, Within { relative: 0.0, absolute: 1e-9 });
        }
    }
    // That of the whole is the sum of its bodies'.
    let parts = Measures::new(&mechanism, &["a.px", "b.px", "mechanism.px"]);
    let [a, b, sum] = parts.at(&motion.samples[3])[..] else { panic!("three measures") };
    close("sum", a + b, sum, EXACT);
}

#[test]
fn accelerations_are_measures_of_results_and_not_of_loads() {
    let mechanism = derive(model(&pendulum("rpy = [0.2, 0.3, 0]", "")));
    let motion = solve(&mechanism);
    let names = ["bob.ax", "bob.ay", "bob.az", "bob.alx_body", "bob.wy_body", "bob.wz_body"];
    let measures = Measures::new(&mechanism, &names);
    for sample in motion.samples.iter().step_by(50) {
        let [ax, ay, az, alpha, q, r] = measures.at(sample)[..] else { panic!("six measures") };
        // m a = F + m g, and Euler's equation about the first axis through the centre of mass.
        let [fx, fy, fz, ..] = sample.reactions[0];
        for (a, f) in [(ax, fx), (ay, fy), (az, fz - 9.81)] {
            close("m a", a, f, Within { relative: 1e-9, absolute: 1e-9 });
        }
        let axes = Measures::new(&mechanism, &["bob.cxy", "bob.cyy", "bob.czy"]);
        let images = axes.at(sample);
        // The joint is 0.5 above the centre of mass along the third axis: moment of F about the first.
        let along_second = fx * images[0] + fy * images[1] + fz * images[2];
        let moment = 0.02 * alpha + (0.04 - 0.03) * q * r;
        close(
            "Euler's equation",
            moment,
            -0.5 * along_second,
            Within { relative: 1e-8, absolute: 1e-8 },
        );
    }
    let text = pendulum("rpy = [0, 0, 0]", "").replace("acceleration = [0, 0, -9.81]", "acceleration = [0, 0, -9.81]\n[loads.t]\ntype = \"torque\"\non = \"bob\"\nvector = [\"1 N m s^2*bob.alx\", 0, 0]");
    let reading = bksim::model::file::read(&bksim::model::file::Source::new(&text, "test"));
    assert!(crate::support::messages(&reading.diagnostics).contains("undefined `bob.alx`"));
}
