//! A rope over sheaves in space as a spring, against the value of another program's test of it.
//!
//! The sheaves are those of the test `reevingSystemSpringsTest` of Exudyn (J. Gerstmayr,
//! <https://github.com/jgerstmayr/EXUDYN>, `main/pythonDev/TestModels`), the equations those of its manual,
//! *ObjectConnectorReevingSystemSprings*: a rope of the length L over a wheel that hangs in it between two sheaves at
//! rest, F = (L − L₀) EA/L₀ + L̇ DA/L₀ where that pulls, with dampers against turning about the rope and against moving
//! across it. The places where the rope leaves a circle come from Newton's iteration, written out as signals:
//!
//! ```text
//! r = R (cos φ t − sin φ n),  n = a × c/|a × c|,  t = n × a      c from centre to centre, a the axis
//! r_A · (c + r_B − r_A) = 0,  r_B · (c + r_B − r_A) = 0
//! ```

use crate::support::{Measures, Within, close, derive, model, solve};

/// Steps of Newton's iteration, from angles that are right within a few degrees.
const N_ITERATIONS: usize = 4;

/// A vector by the expressions of its components.
type Vector = [String; 3];

fn named(name: &str) -> Vector {
    ["x", "y", "z"].map(|axis| format!("{name}_{axis}"))
}

fn each(of: impl Fn(usize) -> String) -> Vector {
    [0, 1, 2].map(of)
}

fn dot(a: &Vector, b: &Vector) -> String {
    format!("({}*{} + {}*{} + {}*{})", a[0], b[0], a[1], b[1], a[2], b[2])
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    each(|i| {
        let [j, k] = [(i + 1) % 3, (i + 2) % 3];
        format!("({}*{} - {}*{})", a[j], b[k], a[k], b[j])
    })
}

fn difference(a: &Vector, b: &Vector) -> Vector {
    each(|i| format!("({} - {})", a[i], b[i]))
}

fn times(factor: &str, a: &Vector) -> Vector {
    each(|i| format!("{factor}*{}", a[i]))
}

/// Signals on the way into a text.
#[derive(Default)]
struct Signals(String);

impl Signals {
    fn scalar(&mut self, name: &str, value: &str) -> String {
        self.0.extend([format!("[signals.{name}]\nvalue = \"{value}\"\n")]);
        name.to_owned()
    }

    fn vector(&mut self, name: &str, value: &Vector) -> Vector {
        let names = named(name);
        for (name, value) in names.iter().zip(value) {
            self.scalar(name, value);
        }
        names
    }

    fn unit(&mut self, name: &str, value: &Vector) -> Vector {
        let raw = self.vector(&format!("{name}_raw"), value);
        self.vector(name, &times(&format!("1/sqrt({})", dot(&raw, &raw)), &raw))
    }
}

/// A circle: centre, axis and radius.
struct Circle {
    centre: Vector,
    axis: Vector,
    radius: f64,
}

/// The places where a strand touches its two circles, from their centres. The other program divides the normal of the
/// second circle by the length of that of the first, so that its radius is not quite its own.
fn touch(signals: &mut Signals, name: &str, ends: [&Circle; 2], is_theirs: bool) -> [Vector; 2] {
    let span = difference(&ends[1].centre, &ends[0].centre);
    let span = signals.vector(&format!("{name}_c"), &span);
    let along = signals.unit(&format!("{name}_e"), &span);
    let across = ends.map(|end| cross(&end.axis, &along));
    let across = [0, 1].map(|k| signals.vector(&format!("{name}_m{k}"), &across[k]));
    let lengths = [&across[0], if is_theirs { &across[0] } else { &across[1] }];
    let lengths = lengths.map(|m| format!("1/sqrt({})", dot(m, m)));
    let normals =
        [0, 1].map(|k| signals.vector(&format!("{name}_n{k}"), &times(&lengths[k], &across[k])));
    let tangents =
        [0, 1].map(|k| signals.vector(&format!("{name}_t{k}"), &cross(&normals[k], &ends[k].axis)));

    let mut angles = [0, 1].map(|_| "1.6".to_owned());
    for step in 0..=N_ITERATIONS {
        let at = |signals: &mut Signals, k: usize, word: &str, [of_t, of_n]: [String; 2]| {
            let radius = ends[k].radius;
            let parts = each(|i| {
                format!("{radius}*({of_t}*{} - {of_n}*{})", tangents[k][i], normals[k][i])
            });
            signals.vector(&format!("{name}_{word}{k}_{step}"), &parts)
        };
        let [a, b] = [0, 1].map(|k| {
            let angle = &angles[k];
            at(signals, k, "r", [format!("cos({angle})"), format!("sin({angle})")])
        });
        if step == N_ITERATIONS {
            return [a, b];
        }
        let [da, db] = [0, 1].map(|k| {
            let angle = &angles[k];
            at(signals, k, "d", [format!("(-sin({angle}))"), format!("cos({angle})")])
        });
        let scalar = |signals: &mut Signals, word: &str, value: &str| {
            signals.scalar(&format!("{name}_{word}_{step}"), value)
        };
        let square = |k: usize| ends[k].radius * ends[k].radius;
        let [f, g] = [
            format!("{} - {} + {}", dot(&span, &a), square(0), dot(&a, &b)),
            format!("{} + {} - {}", dot(&span, &b), square(1), dot(&a, &b)),
        ];
        let (f, g) = (scalar(signals, "f", &f), scalar(signals, "g", &g));
        let fa = scalar(signals, "fa", &format!("{} + {}", dot(&span, &da), dot(&da, &b)));
        let fb = scalar(signals, "fb", &dot(&a, &db));
        let ga = scalar(signals, "ga", &format!("-{}", dot(&da, &b)));
        let gb = scalar(signals, "gb", &format!("{} - {}", dot(&span, &db), dot(&a, &db)));
        let det = scalar(signals, "det", &format!("{fa}*{gb} - {fb}*{ga}"));
        let next = [
            format!("{} - ({gb}*{f} - {fb}*{g})/{det}", angles[0]),
            format!("{} - ({fa}*{g} - {ga}*{f})/{det}", angles[1]),
        ];
        for (k, value) in next.iter().enumerate() {
            angles[k] = scalar(signals, &format!("phi{k}"), value);
        }
    }
    unreachable!("the last step returns")
}

/// The wheel in its rope, all numbers in SI.
fn reeving(is_theirs: bool) -> String {
    let word = |text: &str| text.to_owned();
    let at = |place: [f64; 3]| place.map(|x| format!("{x:?}"));
    let mut signals = Signals::default();
    let wheel = Circle {
        centre: ["x", "y", "z"].map(|axis| format!("wheel.P.{axis}")),
        axis: ["wheel.cxz", "wheel.cyz", "wheel.czz"].map(word),
        radius: 2.0,
    };
    let sheave = |place| Circle { centre: at(place), axis: at([0.0, 0.0, -1.0]), radius: 0.5 };
    let sheaves = [sheave([0.0, 0.0, 0.0]), sheave([12.0, 0.0, 2.0])];
    let spin = ["wheel.wx", "wheel.wy", "wheel.wz"].map(word);
    let speed = ["vx", "vy", "vz"].map(|v| format!("wheel.P.{v}"));

    // Of either strand: the place on the wheel, the direction away from the wheel, the length, the velocity of the place.
    let mut strands = Vec::new();
    for (name, k) in [("a", 0), ("b", 1)] {
        let ends = if k == 0 { [&sheaves[0], &wheel] } else { [&wheel, &sheaves[1]] };
        let [first, second] = touch(&mut signals, name, ends, is_theirs);
        let (own, other) = if k == 0 { (second, first) } else { (first, second) };
        let far = each(|i| format!("({} + {})", sheaves[k].centre[i], other[i]));
        let near = each(|i| format!("({} + {})", wheel.centre[i], own[i]));
        let way = signals.vector(&format!("{name}_way"), &difference(&far, &near));
        let length =
            signals.scalar(&format!("{name}_length"), &format!("sqrt({})", dot(&way, &way)));
        let out = signals.vector(&format!("{name}_out"), &times(&format!("1/{length}"), &way));
        let turning = cross(&spin, &own);
        let velocity = each(|i| format!("{} + {}", speed[i], turning[i]));
        let velocity = signals.vector(&format!("{name}_v"), &velocity);
        strands.push((own, out, length, velocity));
    }

    // Tension.
    let [(own_a, out_a, length_a, v_a), (own_b, out_b, length_b, v_b)] = &strands[..] else {
        unreachable!("two strands")
    };
    let across = cross(&wheel.axis, own_a);
    let [sine, cosine] = [dot(&across, own_b), dot(own_a, own_b)];
    let wrap = signals.scalar("wrap", &format!("pi + atan2(-{sine}, -{cosine})"));
    let whole = signals.scalar("whole", &format!("{length_a} + {length_b} + 2*{wrap}"));
    let rate = format!("-({}) - {}", dot(v_a, out_a), dot(v_b, out_b));
    let rest = 450f64.sqrt() + 426f64.sqrt() + 2.0 * std::f64::consts::PI;
    let pull = format!("(1e5*({whole} - {rest:?}) + 5e4*({rate}))/{rest:?}");
    let pull = signals.scalar("pull", &pull);
    let tension = format!("if({pull} > 0, {pull}, 0.1*tanh({pull}/0.1))");
    let tension = signals.scalar("tension", &tension);

    // Forces and moments about the point of the wheel.
    let (mut force, mut moment) = (each(|_| word("0")), each(|_| word("0")));
    for (name, (own, out, length, velocity)) in ["a", "b"].iter().zip(&strands) {
        let along = signals.scalar(&format!("{name}_along"), &dot(velocity, out));
        let turn = signals.scalar(&format!("{name}_turn"), &dot(&spin, out));
        let one = each(|i| {
            format!("({tension}*{} - 5e3/{length}*({} - {along}*{}))", out[i], velocity[i], out[i])
        });
        let one = signals.vector(&format!("{name}_force"), &one);
        let about = cross(own, &one);
        force = each(|i| format!("{} + {}", force[i], one[i]));
        moment = each(|i| format!("{} + {} - 500*{turn}*{}", moment[i], about[i], out[i]));
    }
    let mass = 400.0 * std::f64::consts::PI;
    let (across, about) = (mass * (3.0 * 4.0 + 0.01) / 12.0, 2.0 * mass);
    let listed = |v: &Vector| format!("[\"{}\", \"{}\", \"{}\"]", v[0], v[1], v[2]);
    format!(
        "space = \"spatial\"\n\
         [bodies.wheel]\nmass = {mass:?}\ncom = [0, -2, 0]\ninertia = [{across:?}, {across:?}, {about:?}]\n\
         points = {{ P = [0, 0, 0] }}\nfree = true\n{}\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81, 0]\n\
         [loads.rope]\ntype = \"force\"\non = \"wheel.P\"\nvector = {}\n\
         [loads.twist]\ntype = \"torque\"\non = \"wheel\"\nvector = {}\n\
         [initial]\nwheel = {{ x = 7, y = -22, z = 1, rpy = [0, 0, 0], vx = 0, vy = 0, vz = 0, w = [0, 0, 0] }}\n\
         [solve]\nt_end = 2\nrtol = 1e-10\natol = 1e-11\n",
        signals.0,
        listed(&force),
        listed(&moment),
    )
}

/// The norm of what the test compares: how far the wheel has moved, and its Euler parameters from those of no turn.
fn moved(is_theirs: bool) -> f64 {
    let mechanism = derive(model(&reeving(is_theirs)));
    let motion = solve(&mechanism);
    let last = motion.samples.last().expect("the end");
    let names =
        ["wheel.P.x", "wheel.P.y", "wheel.P.z", "wheel.e0", "wheel.e1", "wheel.e2", "wheel.e3"];
    let start = [7.0, -20.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    let end = Measures::new(&mechanism, &names).at(last);
    end.iter().zip(start).map(|(end, start)| (end - start).powi(2)).sum::<f64>().sqrt()
}

/// The value in the list of the program's tests is of 200 steps of the generalised alpha method; with steps of 0.2 ms the
/// program itself gives 2.21552881.
#[test]
fn a_wheel_in_a_rope_of_springs() {
    let within = |absolute| Within { relative: 0.0, absolute };
    let listed = 2.215_557_571_743_3;
    let theirs = moved(true);
    close("with steps without end", theirs, 2.215_528_80, within(2e-8));
    close("the test's own value", theirs, listed, within(3e-5));
    close("with the circle's own radius", moved(false), 2.215_635_569, within(1e-8));
}
