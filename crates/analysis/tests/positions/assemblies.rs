//! Assemblies against lists of all that planar linkages have.

use std::f64::consts::{PI, TAU};

use crate::support::{geometry, model, number};
use bksim_analysis::{Assembly, Proof, assemblies};
use nalgebra::{Complex, DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

const LINKAGES: &str = include_str!("../../../../tests/data/assemblies/planar.json");

/// The model of a linkage with its crank held.
fn held(linkage: &Value) -> String {
    let crank = &linkage["crank"];
    let joint = crank["joint"].as_str().expect("a joint");
    let text = linkage["model"].as_str().expect("a model");
    format!("{text}\n[initial]\n{joint} = {{ angle = {} }}\n", number(&crank["angle"]))
}

/// True where a found assembly has the listed places of all bodies.
fn is_at(found: &Assembly, bodies: &serde_json::Map<String, Value>) -> bool {
    let value =
        |name: String| found.pose.iter().find(|(known, ..)| *known == name).expect("a quantity").1;
    bodies.iter().all(|(body, place)| {
        let turn = value(format!("{body}.angle")) - number(&place[2]);
        (value(format!("{body}.x")) - number(&place[0])).abs() < 1e-9
            && (value(format!("{body}.y")) - number(&place[1])).abs() < 1e-9
            && (turn - TAU * (turn / TAU).round()).abs() < 1e-9
    })
}

#[test]
fn all_listed_linkages_have_the_listed_assemblies_and_that_is_proved() {
    let linkages: Vec<Value> = serde_json::from_str(LINKAGES).expect("linkages");
    assert_eq!(linkages.len(), 145);
    for linkage in &linkages {
        let id = linkage["id"].as_str().expect("a name");
        let listed = linkage["assemblies"].as_array().expect("assemblies");
        let found = assemblies(model(&held(linkage))).expect("assemblies");
        let proof = found.proof.as_ref().unwrap_or_else(|| panic!("{id} is not proved"));
        assert_eq!([proof.n, found.assemblies.len()], [listed.len(); 2], "{id}");
        assert_eq!(
            proof.n_redundant as u64,
            linkage["redundant"].as_u64().expect("a count"),
            "{id}"
        );
        assert!(proof.triads.len() == usize::from(id.starts_with("stephenson-triad")), "{id}");
        for expected in listed {
            let bodies = expected["bodies"].as_object().expect("bodies");
            let n = found.assemblies.iter().filter(|found| is_at(found, bodies)).count();
            assert_eq!(n, 1, "{id}");
        }
    }
}

/// A block on a turning guide: two closures, one dyad RPR.
#[test]
fn an_inverted_slider_crank_is_proved() {
    let text = "[ground.points]\nD = [0.3, 0]\n\
                [bodies]\ncrank = { mass = 1, inertia = 1, points = { B = [0.1, 0] } }\n\
                block = { mass = 1, inertia = 1 }\nguide = { mass = 1, inertia = 1, points = { G = [0, 0.05] } }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"crank\"] }\n\
                B = { type = \"revolute\", between = [\"crank.B\", \"block\"] }\n\
                S = { type = \"prismatic\", between = [\"guide.G\", \"block\"], axis = [1, 0] }\n\
                D = { type = \"revolute\", between = [\"ground.D\", \"guide\"] }\n\
                [initial]\nA = { angle = 0.8 }\n";
    let found = assemblies(model(text)).expect("assemblies");
    let proof = found.proof.expect("a proof");
    assert_eq!([found.assemblies.len(), proof.n], [2, 2]);
    assert_eq!(proof.dyads[0].kind, "RPR");
    // The guide passes at 0.05 m next to D, pin B at the distance d.
    let (x, y) = (0.1 * 0.8f64.cos() - 0.3, 0.1 * 0.8f64.sin());
    assert!((proof.margin - (1.0 - 0.05 / x.hypot(y))).abs() < 1e-12);
}

/// A platform on the ground: by links between pins, by pins in slots of the ground, by slots on pins of the ground.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Leg {
    Link,
    GroundSlot,
    PlatformSlot,
}

/// A leg with its point on the ground and that on the platform; the platform's frame is that of the world in one pose.
type Placed = (Leg, Complex<f64>, Complex<f64>);

fn random_legs(random: &mut Pcg64) -> Vec<Placed> {
    let n_links = random.random_range(0..4);
    let mut number = |size: f64| (random.random_range(-size..size) * 1e3).round() / 1e3;
    let mut leg = |k: usize| {
        let kind = if k < n_links {
            Leg::Link
        } else if number(1.0) < 0.0 {
            Leg::GroundSlot
        } else {
            Leg::PlatformSlot
        };
        (kind, Complex::new(number(2.0), number(2.0)), Complex::new(number(1.0), number(1.0)))
    };
    (0..3).map(&mut leg).collect()
}

fn text_of(legs: &[Placed]) -> String {
    let (mut ground, mut own, mut joints) = (String::new(), String::new(), String::new());
    for (k, (kind, a, p)) in legs.iter().enumerate() {
        ground.extend([format!("A{k} = [{}, {}]\n", a.re, a.im)]);
        own.extend([format!("P{k} = [{}, {}], ", p.re, p.im)]);
        let arm = p - a;
        let ([first, second], shape) = match kind {
            Leg::Link => (
                [format!("ground.A{k}"), format!("platform.P{k}")],
                format!("length = {}", arm.norm()),
            ),
            Leg::GroundSlot => (
                [format!("ground.A{k}"), format!("platform.P{k}")],
                format!("axis = [{}, {}]", arm.re, arm.im),
            ),
            Leg::PlatformSlot => (
                [format!("platform.P{k}"), format!("ground.A{k}")],
                format!("axis = [{}, {}]", arm.re, arm.im),
            ),
        };
        let kind = if *kind == Leg::Link { "link" } else { "slot" };
        joints.extend([format!(
            "L{k} = {{ type = \"{kind}\", between = [\"{first}\", \"{second}\"], {shape} }}\n"
        )]);
    }
    format!(
        "[ground.points]\n{ground}[bodies]\nplatform = {{ points = {{ {own} }} }}\n[joints]\n{joints}"
    )
}

/// Misses of the legs with their slopes by x, y and angle of the platform.
fn misses(legs: &[Placed], x: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let (z, t) = (Complex::new(x[0], x[1]), Complex::from_polar(1.0, x[2]));
    let i = Complex::i();
    let (mut miss, mut slopes) = (DVector::zeros(3), DMatrix::zeros(3, 3));
    for (row, (kind, a, p)) in legs.iter().enumerate() {
        let (arm, way) = (p - a, z + t * p - a);
        let moved = [Complex::from(1.0), i, i * t * p];
        let guide = if *kind == Leg::PlatformSlot { t * arm } else { arm };
        // Half the square of the way, or its part across the guide.
        miss[row] = match kind {
            Leg::Link => 0.5 * (way.norm_sqr() - arm.norm_sqr()),
            _ => (guide.conj() * way).im,
        };
        for (k, moved) in moved.iter().enumerate() {
            slopes[(row, k)] = match kind {
                Leg::Link => (way.conj() * moved).re,
                _ => (guide.conj() * moved).im,
            };
        }
        if *kind == Leg::PlatformSlot {
            slopes[(row, 2)] += ((i * guide).conj() * way).im;
        }
    }
    (miss, slopes)
}

/// Poses found by Newton's method from many random ones, each once.
fn multistart(legs: &[Placed], n_starts: usize, random: &mut Pcg64) -> Vec<DVector<f64>> {
    let mut found: Vec<DVector<f64>> = Vec::new();
    for _ in 0..n_starts {
        let mut x = DVector::from_fn(3, |k, _| {
            random.random_range(-1.0..1.0) * if k == 2 { PI } else { 4.0 }
        });
        for _ in 0..100 {
            let (miss, slopes) = misses(legs, &x);
            let Some(step) = slopes.lu().solve(&miss) else { break };
            let share = (0.7 * (1.0 + x.norm()) / step.norm()).min(1.0);
            x -= step * share;
        }
        let turn = |angle: f64| angle - TAU * (angle / TAU).round();
        let is_same = |other: &DVector<f64>| {
            (x[0] - other[0]).abs().max((x[1] - other[1]).abs()) < 1e-6
                && turn(x[2] - other[2]).abs() < 1e-6
        };
        // Links far away have their rounding.
        let is_closed = misses(legs, &x).0.amax() < 1e-12 * (1.0 + x.norm_squared());
        if is_closed && !found.iter().any(is_same) {
            found.push(x);
        }
    }
    found
}

/// Platforms on three legs, `BKSIM_ASSEMBLIES=10000` for as many.
#[test]
fn platforms_have_the_assemblies_that_a_multistart_finds() {
    let n = std::env::var("BKSIM_ASSEMBLIES").ok().and_then(|n| n.parse().ok()).unwrap_or(60);
    let mut random = Pcg64::seed_from_u64(20);
    let (mut n_proved, mut counts) = (0, [0; 7]);
    for k in 0..n {
        let legs = random_legs(&mut random);
        let text = text_of(&legs);
        let found = assemblies(geometry(&text)).unwrap_or_else(|e| panic!("{k}: {e}\n{text}"));
        // Near to dead centres nothing is claimed.
        let Some(Proof { n, triads, .. }) = found.proof else { continue };
        n_proved += 1;
        let mut expected = multistart(&legs, 400, &mut random);
        if expected.len() != n {
            // A pose with a small basin.
            expected = multistart(&legs, 40_000, &mut random);
        }
        assert_eq!([n, found.assemblies.len()], [expected.len(); 2], "{k}: {text}");
        assert_eq!(triads.len(), 1);
        counts[n] += 1;
    }
    assert!(n_proved * 100 >= n * 97, "{n_proved} of {n} are proved");
    assert!(counts[2] > 0 && counts[4] > 0, "{counts:?}");
}

/// Six-bars with another joint than the crank's held, so that the ground is no good place to begin.
#[test]
fn six_bars_are_proved_whichever_joint_is_held() {
    let linkages: Vec<Value> = serde_json::from_str(LINKAGES).expect("linkages");
    let six_bars = linkages.iter().filter(|l| {
        l["id"].as_str().is_some_and(|id| id.contains("watt") || id.contains("stephenson"))
    });
    for (k, linkage) in six_bars.enumerate() {
        let listed = &linkage["assemblies"][0];
        let joint = ["B", "C", "E", "F"][k % 4];
        let text = format!(
            "{}\n[initial]\n{joint} = {{ angle = {} }}\nA = {{ guess = {{ angle = {} }} }}\n",
            linkage["model"].as_str().expect("a model"),
            number(&listed["joints"][joint]),
            number(&listed["joints"]["A"]),
        );
        let id = &linkage["id"];
        let found = assemblies(model(&text)).unwrap_or_else(|e| panic!("{id}: {e}"));
        let proof = found.proof.unwrap_or_else(|| panic!("{id} with {joint} is not proved"));
        assert_eq!(proof.n, found.assemblies.len());
        let bodies = listed["bodies"].as_object().expect("bodies");
        let n = found.assemblies.iter().filter(|found| is_at(found, bodies)).count();
        assert_eq!(n, 1, "{id} with {joint} held");
    }
}

#[test]
fn poses_that_can_still_move_are_no_assemblies() {
    // Arms of one length: where those of the lower stage lie on each other, the upper stage turns freely about their end.
    let mut text = String::from("[ground]\npoints = { O = [0, 0] }\n");
    for arm in ["a1", "b1", "a2", "b2"] {
        text.extend([format!(
            "[bodies.{arm}]\nmass = 1\ninertia = 1\npoints = {{ M = [0.5, 0], E = [1, 0] }}\n"
        )]);
    }
    text += "[bodies.table]\nmass = 1\ninertia = 1\n\
             [joints]\nA = { type = \"revolute\", between = [\"ground.O\", \"a1\"] }\n\
             B = { type = \"slot\", between = [\"ground.O\", \"b1\"], axis = [1, 0] }\n\
             M1 = { type = \"revolute\", between = [\"a1.M\", \"b1.M\"] }\n\
             L = { type = \"revolute\", between = [\"b1.E\", \"a2\"] }\n\
             R = { type = \"revolute\", between = [\"a1.E\", \"b2\"] }\n\
             M2 = { type = \"revolute\", between = [\"a2.M\", \"b2.M\"] }\n\
             T = { type = \"revolute\", between = [\"b2.E\", \"table\"] }\n\
             S = { type = \"slot\", between = [\"table\", \"a2.E\"], axis = [1, 0] }\n\
             [initial]\nA = { angle = 0.5 }\nb1 = { guess = { angle = 2.6 } }\na2 = { guess = { angle = 0.5 } }\n\
             b2 = { guess = { angle = 2.6 } }\n";
    let found = assemblies(geometry(&text)).expect("assemblies");
    assert!(found.n_moving > 0);
    assert!(found.assemblies.len() < 12, "{} assemblies", found.assemblies.len());
}
