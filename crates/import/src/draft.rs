//! A model on its way from another format to text: plain data, names already legal.

use crate::job::Place;
use crate::spatial::{Inertia, Pose, Rotation, Vector};

/// How the axes of a point are written.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Axes {
    /// Axes of the body.
    Own,
    /// Turns about the fixed axes x, y, z.
    Rpy(Vector),
    /// Any rotation.
    Turned(Rotation),
}

/// A point with axes on a body.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Point {
    pub(crate) name: String,
    pub(crate) at: Vector,
    pub(crate) axes: Axes,
}

impl Point {
    pub(crate) fn posed(name: &str, pose: Pose) -> Self {
        let axes = if pose.turn.is_none() { Axes::Own } else { Axes::Turned(pose.turn) };
        Self { name: name.to_owned(), at: pose.at, axes }
    }
}

/// A body.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Body {
    pub(crate) name: String,
    /// Lines of comments above it.
    pub(crate) notes: Vec<String>,
    pub(crate) inertia: Inertia,
    pub(crate) points: Vec<Point>,
    /// Inline tables.
    pub(crate) shapes: Vec<String>,
    /// Further keys; `mass` or `density` in place of the inertia.
    pub(crate) keys: Vec<(&'static str, String)>,
    pub(crate) place: Option<Place>,
}

impl Body {
    pub(crate) fn new(name: String, inertia: Inertia) -> Self {
        Self {
            name,
            notes: Vec::new(),
            inertia,
            points: Vec::new(),
            shapes: Vec::new(),
            keys: Vec::new(),
            place: None,
        }
    }
}

/// A table with its keys in order, values as they are written.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Table {
    pub(crate) name: String,
    pub(crate) notes: Vec<String>,
    pub(crate) keys: Vec<(&'static str, String)>,
}

impl Table {
    pub(crate) fn new(name: String, kind: &str) -> Self {
        Self { name, notes: Vec::new(), keys: vec![("type", quoted(kind))] }
    }

    /// A table without a type.
    pub(crate) fn plain(name: String) -> Self {
        Self { name, notes: Vec::new(), keys: Vec::new() }
    }

    pub(crate) fn key(mut self, key: &'static str, value: impl Into<String>) -> Self {
        self.keys.push((key, value.into()));
        self
    }

    /// The value of a key, as it is written.
    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.keys.iter().find(|(known, _)| *known == key).map(|(_, value)| value.as_str())
    }

    /// Gives a key that is there another value.
    pub(crate) fn set(&mut self, key: &str, value: String) {
        if let Some((_, old)) = self.keys.iter_mut().find(|(known, _)| *known == key) {
            *old = value;
        }
    }

    /// True if the table is of a type.
    pub(crate) fn is(&self, kind: &str) -> bool {
        self.get("type").is_some_and(|known| known.trim_matches('"') == kind)
    }

    /// A key with a text.
    pub(crate) fn text(self, key: &'static str, value: &str) -> Self {
        self.key(key, quoted(value))
    }

    pub(crate) fn number(self, key: &'static str, value: f64) -> Self {
        self.key(key, number(value))
    }

    pub(crate) fn vector(self, key: &'static str, value: Vector) -> Self {
        self.key(key, vector(value))
    }

    pub(crate) fn between(self, first: &str, second: &str) -> Self {
        let ends = format!("[{}, {}]", quoted(first), quoted(second));
        self.key("between", ends)
    }

    pub(crate) fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }
}

/// A parameter.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    pub(crate) value: String,
    pub(crate) note: String,
}

/// A model on its way to text.
#[derive(Clone, PartialEq, Default, Debug)]
pub(crate) struct Draft {
    pub(crate) name: String,
    /// Lines of the heading.
    pub(crate) heading: Vec<String>,
    pub(crate) is_planar: bool,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) ground: Vec<Point>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) joints: Vec<Table>,
    pub(crate) couplings: Vec<Table>,
    pub(crate) loads: Vec<Table>,
    pub(crate) drives: Vec<Table>,
    pub(crate) curves: Vec<Table>,
    /// Keys of `[initial]`.
    pub(crate) initial: Vec<(String, String)>,
    /// Joints that do not start at zero: joint, word of the motion, and where, at a limit on it and a little within it.
    pub(crate) starts: Vec<(String, String, [f64; 2])>,
    /// Parameters that are inputs.
    pub(crate) inputs: Vec<String>,
    pub(crate) gravity: Option<Vector>,
    /// Loads of dry friction with their joints and places.
    pub(crate) frictions: Vec<(String, String, Place)>,
    /// True if the coordinates are those of the joints.
    pub(crate) is_relative: bool,
}

impl Draft {
    /// Adds a point to a body, or to the ground with `None`, and returns how joints call it. A point that is there
    /// already is taken; the frame of the body itself needs none.
    pub(crate) fn point(&mut self, body: Option<usize>, name: &str, point: &Point) -> String {
        let (owner, points) = match body {
            Some(body) => {
                let body = &mut self.bodies[body];
                (body.name.clone(), &mut body.points)
            }
            None => ("ground".to_owned(), &mut self.ground),
        };
        if point.at == [0.0; 3] && point.axes == Axes::Own {
            return owner;
        }
        let is_same = |known: &&Point| known.at == point.at && known.axes == point.axes;
        if let Some(known) = points.iter().find(is_same) {
            return format!("{owner}.{}", known.name);
        }
        let legal = crate::names::legal(name, "point");
        let mut free = legal.clone();
        let mut counter = 2;
        while points.iter().any(|known| known.name == free) {
            free = format!("{legal}_{counter}");
            counter += 1;
        }
        points.push(Point { name: free.clone(), ..point.clone() });
        format!("{owner}.{free}")
    }

    /// Frame: a [`Draft::point`] at a pose.
    pub(crate) fn frame(&mut self, body: Option<usize>, name: &str, pose: Pose) -> String {
        self.point(body, name, &Point::posed(name, pose))
    }
}

/// A text as TOML has it.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A number that reads back as itself, but for the last digits of a sum that was meant to be shorter.
pub(crate) fn number(value: f64) -> String {
    let value = if value == 0.0 { 0.0 } else { value };
    let exact = plain(value);
    let rounded = format!("{value:.14e}").parse::<f64>().map_or_else(|_| exact.clone(), plain);
    if exact.len() > 16 && rounded.len() + 3 < exact.len() { rounded } else { exact }
}

fn plain(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e15).contains(&size) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}

/// A vector; components that are rounding of the largest one are zero.
pub(crate) fn vector(value: Vector) -> String {
    list(&value)
}

pub(crate) fn list(values: &[f64]) -> String {
    let largest = values.iter().fold(0.0_f64, |max, value| max.max(value.abs()));
    let clean = |value: &f64| if value.abs() < 1e-15 * largest { 0.0 } else { *value };
    let parts: Vec<String> = values.iter().map(|value| number(clean(value))).collect();
    format!("[{}]", parts.join(", "))
}

/// A factor and the sign before it, for sums: `+ 2*`, `- `, and nothing for zero.
pub(crate) fn signed(value: f64) -> String {
    if value < 0.0 { format!("- {}", number(-value)) } else { format!("+ {}", number(value)) }
}
