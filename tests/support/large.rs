//! Mechanisms of any size as model texts, for tests of growth.

use std::fmt::Write;

/// Coordinates of a mechanism.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Coordinates {
    /// Three for each body.
    Absolute,
    /// Along a spanning tree.
    Relative,
}

impl Coordinates {
    fn word(self) -> &'static str {
        match self {
            Self::Absolute => "absolute",
            Self::Relative => "relative",
        }
    }
}

/// A uniform link of 1 m and 1 kg from O to E.
pub(crate) const LINK: &str = "mass = \"1 kg\"\ninertia = \"1 kg*m^2/12\"\ncom = [\"0.5 m\", 0]\n\
                    points = { O = [0, 0], E = [\"1 m\", 0] }\n";

/// Free fall along −y, and the output.
pub(crate) const REST: &str =
    "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n";

/// `n` links in line along x, held by a pivot at the origin, at rest.
pub(crate) fn chain(n: usize, coordinates: Coordinates) -> String {
    let mut text = format!("coordinates = \"{}\"\n", coordinates.word());
    let mut add = |arguments: std::fmt::Arguments<'_>| {
        text.write_fmt(arguments).expect("text takes everything");
    };
    for i in 1..=n {
        add(format_args!("[bodies.b{i}]\n{LINK}"));
        if coordinates == Coordinates::Absolute {
            add(format_args!("coordinates = [\"x{i}\", \"y{i}\", \"theta{i}\"]\n"));
        }
    }
    for i in 1..=n {
        let pivot = if i == 1 { "ground".to_owned() } else { format!("b{}.E", i - 1) };
        add(format_args!(
            "[joints.j{i}]\ntype = \"revolute\"\nbetween = [\"{pivot}\", \"b{i}.O\"]\n"
        ));
    }
    text + REST
}

/// `n` square windows side by side: `n + 1` uprights on the ground, `n` horizontals on top. It
/// stands upright and leans to the right at 1 rad/s.
pub(crate) fn windows(n: usize, coordinates: Coordinates) -> String {
    let mut text = format!("coordinates = \"{}\"\n[ground]\npoints = {{", coordinates.word());
    let mut add = |arguments: std::fmt::Arguments<'_>| {
        text.write_fmt(arguments).expect("text takes everything");
    };
    for i in 0..=n {
        add(format_args!(" P{i} = [\"{i} m\", 0]{}", if i < n { "," } else { " }\n" }));
    }
    for i in 0..=n {
        add(format_args!("[bodies.u{i}]\n{LINK}"));
    }
    for i in 1..=n {
        add(format_args!("[bodies.h{i}]\n{LINK}"));
    }
    let mut join = |name: &str, i: usize, [from, to]: [String; 2]| {
        add(format_args!("[joints.{name}{i}]\ntype = \"revolute\"\n"));
        add(format_args!("between = [\"{from}\", \"{to}\"]\n"));
    };
    for i in 0..=n {
        join("g", i, [format!("ground.P{i}"), format!("u{i}.O")]);
    }
    for i in 1..=n {
        join("l", i, [format!("u{}.E", i - 1), format!("h{i}.O")]);
        join("r", i, [format!("h{i}.E"), format!("u{i}.E")]);
    }
    add(format_args!("[initial]\n"));
    for i in 0..=n {
        let start = "angle = \"90 deg\", rate = \"-1 rad/s\"";
        // One angle moves the whole; the others only show the branch.
        if i == 0 {
            add(format_args!("g{i} = {{ {start} }}\n"));
        } else {
            add(format_args!("g{i} = {{ guess = {{ {start} }} }}\n"));
            add(format_args!("h{i} = {{ guess = {{ angle = 0 }} }}\n"));
        }
    }
    text + REST
}
