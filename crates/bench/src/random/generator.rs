//! Mechanisms at random, each from its number alone: as text of a model, with a start that closes.
//!
//! Bodies are put somewhere, and joints where two of them happen to meet: so every loop is closed to rounding in the
//! pose that the start guesses. Loads, stops, friction and drives are added by chance.

use std::fmt::Write;

/// Numbers between −1 and 1, the same in each run: a linear congruence.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn three(&mut self, size: f64) -> [f64; 3] {
        [0; 3].map(|_| size * self.next())
    }
}

/// A body where it starts: its origin, m, and its angle about z, rad.
#[derive(Clone, Copy, Default)]
struct Place {
    origin: [f64; 3],
    angle: f64,
}

impl Place {
    /// A point of the world in the frame of the body.
    fn local(&self, world: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = std::array::from_fn(|k| world[k] - self.origin[k]);
        let (sine, cosine) = self.angle.sin_cos();
        [cosine * x + sine * y, cosine * y - sine * x, z]
    }

    /// A point of the body in the world.
    fn world(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sine, cosine) = self.angle.sin_cos();
        let [a, b, c] = self.origin;
        [a + cosine * x - sine * y, b + sine * x + cosine * y, c + z]
    }
}

/// A joint with one motion that loads may act on.
struct Motion {
    joint: String,
    turns: bool,
    /// Where it starts, rad or m.
    start: f64,
}

/// A mechanism in the making.
struct Draft {
    random: Random,
    is_spatial: bool,
    /// The ground, then the bodies.
    places: Vec<Place>,
    points: Vec<Vec<[f64; 3]>>,
    joints: String,
    motions: Vec<Motion>,
    n_free: usize,
    loads: String,
}

/// The model of this number.
pub(crate) fn model(number: u64, is_spatial: bool) -> String {
    let mut draft = Draft {
        random: Random(2 * number + u64::from(is_spatial)),
        is_spatial,
        places: vec![Place::default()],
        points: vec![Vec::new()],
        joints: String::new(),
        motions: Vec::new(),
        n_free: 0,
        loads: String::new(),
    };
    // The first numbers of neighbouring seeds are alike.
    for _ in 0..8 {
        draft.random.next();
    }
    let n_bodies = 1 + draft.pick(if is_spatial { 3 } else { 5 });
    for body in 1..=n_bodies {
        draft.body(body);
    }
    for k in 0..draft.pick(3) {
        draft.close(k);
    }
    draft.load();
    draft.text(number)
}

impl Draft {
    /// A whole number below `n`.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below n")]
    fn pick(&mut self, n: usize) -> usize {
        ((self.share() * n as f64) as usize).min(n - 1)
    }

    /// A number between 0 and 1.
    fn share(&mut self) -> f64 {
        0.5 * (1.0 + self.random.next())
    }

    /// True in so many cases of a hundred.
    fn chance(&mut self, percent: f64) -> bool {
        100.0 * self.share() < percent
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.share()
    }

    fn place(&mut self) -> [f64; 3] {
        let [x, y, z] = self.random.three(1.0);
        [x, y, if self.is_spatial { z } else { 0.0 }]
    }

    /// The point of a body at a place of the world, by name.
    fn point(&mut self, body: usize, world: [f64; 3]) -> String {
        let local = self.places[body].local(world);
        self.points[body].push(local);
        format!("{}.P{}", name(body), self.points[body].len())
    }

    /// A body, joined to one before it.
    fn body(&mut self, body: usize) {
        let origin = self.place();
        let angle = if self.is_spatial { 0.0 } else { 3.0 * self.random.next() };
        self.places.push(Place { origin, angle });
        self.points.push(Vec::new());
        let before = self.pick(body);
        let at = self.place();
        let (first, second) = (self.point(before, at), self.point(body, at));
        let turned = angle - self.places[before].angle;
        let joint = format!("J{body}");
        let axis = if self.is_spatial { self.direction() } else { "[0, 0, 1]".to_owned() };
        let (kind, own, free) = match self.pick(100) {
            _ if !self.is_spatial && self.chance(75.0) => ("revolute", String::new(), 1),
            _ if !self.is_spatial => {
                let along = 180.0 * self.random.next();
                let own = format!(", direction = \"{along} deg\", angle = \"{turned} rad\"");
                ("prismatic", own, 1)
            }
            0..45 => ("revolute", format!(", axis = {axis}"), 1),
            45..60 => ("prismatic", format!(", axis = {axis}"), 1),
            60..75 => ("cylindrical", format!(", axis = {axis}"), 2),
            75..85 => ("universal", ", axis = [1, 0, 0], second = [0, 1, 0]".to_owned(), 2),
            _ => ("spherical", String::new(), 3),
        };
        self.n_free += free;
        if free == 1 {
            let turns = kind == "revolute";
            let start = if turns && !self.is_spatial { turned } else { 0.0 };
            self.motions.push(Motion { joint: joint.clone(), turns, start });
        }
        self.join(&joint, kind, [first, second], &own);
    }

    fn join(&mut self, joint: &str, kind: &str, [first, second]: [String; 2], own: &str) {
        let line = format!("type = \"{kind}\", between = [\"{first}\", \"{second}\"]{own}");
        writeln!(self.joints, "{joint} = {{ {line} }}").expect("a text takes it");
    }

    fn direction(&mut self) -> String {
        let [x, y, z] = self.random.three(1.0);
        format!("[{x}, {y}, {}]", z + 1.5)
    }

    /// A loop, where motions are left.
    fn close(&mut self, k: usize) {
        let needed = if self.is_spatial { 1 } else { 2 };
        let n = self.places.len();
        let (a, b) = (self.pick(n), self.pick(n));
        if self.n_free <= needed || a == b {
            return;
        }
        self.n_free -= needed;
        let [here, there] = [self.place(), self.place()];
        let name = format!("L{k}");
        if self.is_spatial {
            let ends = [self.point(a, here), self.point(b, there)];
            let length: f64 = (0..3).map(|k| (here[k] - there[k]).powi(2)).sum::<f64>().sqrt();
            self.join(&name, "link", ends, &format!(", length = \"{length} m\""));
        } else {
            let ends = [self.point(a, here), self.point(b, here)];
            self.join(&name, "revolute", ends, "");
        }
    }

    fn add(&mut self, name: &str, keys: &str) {
        writeln!(self.loads, "{name} = {{ {keys} }}").expect("a text takes it");
    }

    /// Gravity, springs, forces, and what switches.
    fn load(&mut self) {
        if self.chance(80.0) {
            let down = if self.is_spatial { "0, 0, \"-9.81 m/s^2\"" } else { "0, \"-9.81 m/s^2\"" };
            self.add("gravity", &format!("type = \"gravity\", acceleration = [{down}]"));
        }
        let n = self.places.len();
        for k in 0..self.pick(3) {
            let (a, b) = (self.pick(n), self.pick(n));
            if a == b {
                continue;
            }
            let [here, there] = [self.place(), self.place()];
            let ends = [self.point(a, here), self.point(b, there)];
            let (stiffness, length) = (self.between(20.0, 500.0), self.between(0.2, 1.0));
            let damping = if self.chance(50.0) { self.between(0.1, 5.0) } else { 0.0 };
            self.add(
                &format!("spring{k}"),
                &format!(
                    "type = \"spring\", between = [\"{}\", \"{}\"], stiffness = \"{stiffness} N/m\", length = \"{length} m\", damping = \"{damping} N s/m\"",
                    ends[0], ends[1]
                ),
            );
        }
        if self.chance(30.0) {
            let body = 1 + self.pick(n - 1);
            let at = self.place();
            let (point, force, pace) =
                (self.point(body, at), self.between(1.0, 8.0), self.between(1.0, 20.0));
            let rest = if self.is_spatial { ", 0, 0" } else { ", 0" };
            let vector = format!("[\"{force} N*sin({pace} rad/s*t)\"{rest}]");
            self.add("shake", &format!("type = \"force\", on = \"{point}\", vector = {vector}"));
        }
        for k in 0..self.motions.len() {
            self.on_motion(k);
        }
    }

    /// Loads on the motion of a joint.
    fn on_motion(&mut self, k: usize) {
        let Motion { joint, turns, start } = &self.motions[k];
        let (joint, turns, start) = (joint.clone(), *turns, *start);
        if self.chance(20.0) {
            let (stiffness, off) = (self.between(1.0, 40.0), self.random.next());
            let own = if turns {
                format!(
                    "type = \"torsion\", stiffness = \"{stiffness} N m/rad\", angle = \"{} rad\"",
                    start + off
                )
            } else {
                format!(
                    "type = \"spring\", stiffness = \"{} N/m\", length = \"{off} m\"",
                    10.0 * stiffness
                )
            };
            self.add(&format!("hold{k}"), &format!("joint = \"{joint}\", {own}"));
        }
        if self.chance(20.0) {
            let size = self.between(0.05, 2.0);
            let own = match (self.chance(40.0), turns) {
                (true, true) => format!("mu = {}, radius = \"10 mm\"", 0.2 * size),
                (true, false) => format!("mu = {}", 0.2 * size),
                (false, true) => format!("torque = \"{size} N m\""),
                (false, false) => format!("force = \"{} N\"", 3.0 * size),
            };
            self.add(
                &format!("rub{k}"),
                &format!("type = \"friction\", joint = \"{joint}\", {own}"),
            );
        }
        if self.chance(20.0) {
            let unit = if turns { "rad" } else { "m" };
            let (below, above) = (self.between(0.05, 1.0), self.between(0.05, 1.0));
            let restitution = if self.chance(50.0) { self.between(0.1, 0.8) } else { 0.0 };
            let (least, most) = (start - below, start + above);
            self.add(
                &format!("stop{k}"),
                &format!("type = \"stop\", joint = \"{joint}\", min = \"{least} {unit}\", max = \"{most} {unit}\", restitution = {restitution}"),
            );
        }
    }

    fn text(&mut self, number: u64) -> String {
        let mut text = format!("# Mechanism {number} at random.\n");
        if self.is_spatial {
            text.push_str("space = \"spatial\"\n");
        }
        let mut initial = String::new();
        for body in 1..self.places.len() {
            let com = self.random.three(0.3);
            let mass = self.between(0.2, 3.0);
            let moments = [(); 3].map(|()| mass * self.between(0.06, 0.1));
            let [x, y, z] = self.places[body].world(com);
            let angle = self.places[body].angle;
            if self.is_spatial {
                writeln!(
                    text,
                    "[bodies.B{body}]\nmass = {mass}\ncom = {com:?}\ninertia = {moments:?}"
                )
                .expect("a text takes it");
                writeln!(
                    initial,
                    "B{body} = {{ guess = {{ x = {x}, y = {y}, z = {z}, rpy = [0, 0, 0] }} }}"
                )
                .expect("a text takes it");
            } else {
                let [a, b, _] = com;
                let inertia = moments[0];
                writeln!(
                    text,
                    "[bodies.B{body}]\nmass = {mass}\ncom = [{a}, {b}]\ninertia = {inertia}"
                )
                .expect("a text takes it");
                writeln!(
                    initial,
                    "B{body} = {{ guess = {{ x = {x}, y = {y}, angle = {angle} }} }}"
                )
                .expect("a text takes it");
            }
            text.push_str(&self.points_of(body));
        }
        write!(text, "[ground]\n{}[joints]\n{}", self.points_of(0), self.joints)
            .expect("a text takes it");
        if self.chance(35.0)
            && let Some(Motion { joint, turns, start }) = self.motions.first()
        {
            let unit = if *turns { "rad" } else { "m" };
            let (joint, start) = (joint.clone(), *start);
            let (size, pace) = (self.between(0.1, 0.5), self.between(0.5, 6.0));
            let law = if self.chance(50.0) {
                format!("{start} {unit} + {pace} {unit}/s*t")
            } else {
                format!("{start} {unit} + {size} {unit}*sin({pace} rad/s*t)")
            };
            writeln!(text, "[drives.motor]\njoint = \"{joint}\"\nmotion = \"{law}\"")
                .expect("a text takes it");
        }
        let end = "[solve]\nt_end = \"0.6 s\"\nevery = \"0.02 s\"\nrtol = 1e-8\natol = 1e-10\n";
        text + "[loads]\n" + &self.loads + "[initial]\n" + &initial + end
    }

    fn points_of(&self, body: usize) -> String {
        let coordinates = |[x, y, z]: [f64; 3]| {
            if self.is_spatial { format!("[{x}, {y}, {z}]") } else { format!("[{x}, {y}]") }
        };
        let points = self.points[body].iter().enumerate();
        let listed: Vec<String> =
            points.map(|(k, at)| format!("P{} = {}", k + 1, coordinates(*at))).collect();
        format!("points = {{ {} }}\n", listed.join(", "))
    }
}

/// The name of a body.
fn name(body: usize) -> String {
    if body == 0 { "ground".to_owned() } else { format!("B{body}") }
}

#[cfg(test)]
mod tests {
    use bksim_model::file::{Source, read};

    #[test]
    fn every_number_is_a_model_of_its_own() {
        for is_spatial in [false, true] {
            let texts: Vec<String> = (0..30).map(|k| super::model(k, is_spatial)).collect();
            for (k, text) in texts.iter().enumerate() {
                let reading = read(&Source::new(text, "random"));
                let is_error = |fault: &&bksim_model::diagnostic::Diagnostic| {
                    fault.severity == bksim_model::diagnostic::Severity::Error
                };
                let fault = reading.diagnostics.iter().find(is_error);
                assert!(reading.model.is_some() && fault.is_none(), "{k}: {fault:?}\n{text}");
                assert!(!texts[..k].contains(text), "{k} comes twice");
            }
        }
    }
}
