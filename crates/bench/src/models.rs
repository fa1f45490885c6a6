//! The measured mechanisms, as model texts.

use std::fmt::Write;

use bksim_model::Model;
use bksim_model::file::{Source, read};

use crate::error::BenchError;

/// Reads a model.
pub(crate) fn model(text: &str, name: &str) -> Result<Model, BenchError> {
    let reading = read(&Source::new(text, name));
    reading.model.ok_or_else(|| {
        let first = reading.diagnostics.first().expect("a refused model has a diagnostic");
        BenchError::Model { name: name.to_owned(), message: first.message.clone() }
    })
}

/// A chain of `n` links with relative angles; every length, mass and inertia is a parameter.
pub(crate) fn chain(n: usize) -> String {
    let mut text = String::from("coordinates = \"relative\"\n[parameters]\ng = \"9.81 m/s^2\"\n");
    let mut line = |arguments: std::fmt::Arguments<'_>| {
        text.write_fmt(arguments).expect("text takes everything");
    };
    for i in 1..=n {
        line(format_args!("l{i} = \"1 m\"\na{i} = \"0.5 m\"\nm{i} = \"1 kg\"\n"));
        line(format_args!("I{i} = \"0.1 kg*m^2\"\n"));
    }
    for i in 1..=n {
        line(format_args!("[bodies.b{i}]\nmass = \"m{i}\"\ninertia = \"I{i}\"\n"));
        line(format_args!("com = [\"a{i}\", 0]\npoints = {{ O = [0, 0], E = [\"l{i}\", 0] }}\n"));
    }
    for i in 1..=n {
        let predecessor = if i == 1 { "ground".to_owned() } else { format!("b{}.E", i - 1) };
        line(format_args!("[joints.j{i}]\ntype = \"revolute\"\n"));
        line(format_args!("between = [\"{predecessor}\", \"b{i}.O\"]\ncoordinate = \"q{i}\"\n"));
    }
    line(format_args!("[loads]\ngravity = {{ type = \"gravity\", acceleration = [0, \"-g\"] }}\n"));
    text
}

/// Crank and rod by relative angles, the slider by its position; the pin between them is cut.
pub(crate) const SLIDER_CRANK: &str = r#"
coordinates = "relative"
[parameters]
g = "9.81 m/s^2"
l1 = "1 m"
s1 = "0.5 m"
m1 = "5 kg"
i1 = "1 kg m^2"
l2 = "3 m"
s2 = "1.5 m"
m2 = "5 kg"
i2 = "1 kg m^2"
m3 = "20 kg"
[bodies.crank]
mass = "m1"
com = ["s1", 0]
inertia = "i1"
points = { A = [0, 0], B = ["l1", 0] }
[bodies.rod]
mass = "m2"
com = ["s2", 0]
inertia = "i2"
points = { B = [0, 0], C = ["l2", 0] }
[bodies.slider]
mass = "m3"
inertia = 0
points = { C = [0, 0] }
[joints.A]
type = "revolute"
between = ["ground", "crank.A"]
coordinate = "q1"
[joints.B]
type = "revolute"
between = ["crank.B", "rod.B"]
coordinate = "q2"
[joints.D]
type = "prismatic"
between = ["ground", "slider.C"]
axis = [1, 0]
coordinate = "x3"
[joints.C]
type = "revolute"
between = ["rod.C", "slider.C"]
cut = true
[loads.gravity]
type = "gravity"
acceleration = [0, "-g"]
"#;

/// The joint at which the loop of the four-bar is cut.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cut {
    /// Between coupler and rocker: two branches.
    Coupler,
    /// Between rocker and ground: one branch of three links.
    Ground,
}

/// A four-bar by relative angles; every length, mass and inertia is a parameter.
pub(crate) fn four_bar(cut: Cut) -> String {
    // The origin of the rocker's frame is the joint in the spanning tree.
    let (points, carried, open) = match cut {
        Cut::Coupler => ("D = [0, 0], C = [\"l3\", 0]", FOUR_BAR_D, FOUR_BAR_C),
        Cut::Ground => ("C = [0, 0], D = [\"l3\", 0]", FOUR_BAR_C, FOUR_BAR_D),
    };
    format!(
        "{FOUR_BAR}points = {{ {points} }}\n{carried}coordinate = \"q3\"\n{open}cut = true\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-g\"]\n"
    )
}

const FOUR_BAR_C: &str = r#"
[joints.C]
type = "revolute"
between = ["coupler.C", "rocker.C"]
"#;

const FOUR_BAR_D: &str = r#"
[joints.D]
type = "revolute"
between = ["ground.D", "rocker.D"]
"#;

/// The four-bar up to the points of its rocker.
const FOUR_BAR: &str = r#"
coordinates = "relative"
[parameters]
g = "9.81 m/s^2"
d = "0.3 m"
l1 = "0.1 m"
s1 = "0.05 m"
m1 = "0.5 kg"
i1 = "0.001 kg m^2"
l2 = "0.3 m"
s2 = "0.15 m"
m2 = "0.8 kg"
i2 = "0.006 kg m^2"
l3 = "0.25 m"
s3 = "0.125 m"
m3 = "0.7 kg"
i3 = "0.004 kg m^2"
[ground]
points = { A = [0, 0], D = ["d", 0] }
[bodies.crank]
mass = "m1"
com = ["s1", 0]
inertia = "i1"
points = { A = [0, 0], B = ["l1", 0] }
[bodies.coupler]
mass = "m2"
com = ["s2", 0]
inertia = "i2"
points = { B = [0, 0], C = ["l2", 0] }
[joints.A]
type = "revolute"
between = ["ground.A", "crank.A"]
coordinate = "q1"
[joints.B]
type = "revolute"
between = ["crank.B", "coupler.B"]
coordinate = "q2"
[bodies.rocker]
mass = "m3"
com = ["s3", 0]
inertia = "i3"
"#;

/// The coordinates of a large mechanism.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Coordinates {
    /// Three per body, every joint cut.
    Absolute,
    /// Chosen by bksim.
    Chosen,
}

impl Coordinates {
    fn key(self) -> &'static str {
        match self {
            Self::Absolute => "absolute",
            Self::Chosen => "auto",
        }
    }
}

/// A chain of `n` homogeneous links of 1 m and 1 kg, horizontal and at rest at the start.
pub(crate) fn link_chain(n: usize, coordinates: Coordinates) -> String {
    let mut text = format!("coordinates = \"{}\"\n", coordinates.key());
    let mut add = |part: String| text.push_str(&part);
    for i in 1..=n {
        add(format!("[bodies.b{i}]\n{LINK}points = {{ A = [-0.5, 0], B = [0.5, 0] }}\n"));
        let before = if i == 1 { "ground".to_owned() } else { format!("b{}.B", i - 1) };
        add(format!("[joints.j{i}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"b{i}.A\"]\n"));
    }
    add(format!("{GRAVITY}[initial]\n"));
    for i in 1..=n {
        let x = i as f64 - 0.5;
        add(format!("b{i} = {{ guess = {{ x = {x}, y = 0, angle = 0 }} }}\n"));
    }
    text
}

/// `n` square windows of homogeneous links of 1 m and 1 kg (IFToMM A02): n + 1 uprights, n beams.
/// The uprights are vertical, their tops move to the right with 1 m/s.
pub(crate) fn n_four_bar(n: usize, coordinates: Coordinates) -> String {
    let mut text = format!("coordinates = \"{}\"\n[ground]\npoints = {{ ", coordinates.key());
    let mut add = |part: String| text.push_str(&part);
    for i in 0..=n {
        add(format!("G{i} = [{i}, 0], "));
    }
    add("}\n".to_owned());
    let revolute = |name: String, from: String, to: String| {
        format!("[joints.{name}]\ntype = \"revolute\"\nbetween = [\"{from}\", \"{to}\"]\n")
    };
    for i in 0..=n {
        add(format!("[bodies.u{i}]\n{LINK}points = {{ A = [0, -0.5], B = [0, 0.5] }}\n"));
        add(revolute(format!("g{i}"), format!("ground.G{i}"), format!("u{i}.A")));
    }
    for i in 1..=n {
        add(format!("[bodies.h{i}]\n{LINK}points = {{ A = [-0.5, 0], B = [0.5, 0] }}\n"));
        add(revolute(format!("l{i}"), format!("u{}.B", i - 1), format!("h{i}.A")));
        add(revolute(format!("r{i}"), format!("h{i}.B"), format!("u{i}.B")));
    }
    add(format!("{GRAVITY}[initial]\ng0 = {{ angle = 0, rate = -1 }}\n"));
    for i in 1..=n {
        let x = i as f64 - 0.5;
        add(format!(
            "u{i} = {{ guess = {{ x = {i}, y = 0.5, angle = 0, vx = 0.5, rate = -1 }} }}\n"
        ));
        add(format!("h{i} = {{ guess = {{ x = {x}, y = 1, angle = 0, vx = 1 }} }}\n"));
    }
    text
}

const LINK: &str = "mass = 1\ninertia = \"1/12\"\n";
const GRAVITY: &str = "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n";
