//! The measured mechanisms, as model texts.

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

/// A chain of `n` homogeneous links of 1 m and 1 kg, horizontal and at rest at the start.
pub(crate) fn link_chain(n: usize) -> String {
    let mut text = ABSOLUTE.to_owned();
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
pub(crate) fn n_four_bar(n: usize) -> String {
    let mut text = format!("{ABSOLUTE}[ground]\npoints = {{ ");
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

/// Three coordinates of each body, every joint cut.
const ABSOLUTE: &str = "coordinates = \"absolute\"\n";
const LINK: &str = "mass = 1\ninertia = \"1/12\"\n";
const GRAVITY: &str = "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n";
