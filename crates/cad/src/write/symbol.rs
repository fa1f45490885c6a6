//! Symbols of all blocks, as textbooks have them.
//!
//! Symbols at one point are drawn about the origin, with a pin of diameter 0.4; those between two
//! points lead from the origin to (1, 0).

use std::f64::consts::PI;

use super::canvas::Mark;
use crate::geometry::Point;

/// The title and the shape of a block.
pub(super) struct Symbol {
    /// In a few words.
    pub(super) title: &'static str,
    pub(super) marks: Vec<Mark>,
}

/// The symbol of a kind; `None` for a name that is none.
pub(super) fn symbol(kind: &str) -> Option<Symbol> {
    let (title, marks) = match kind {
        "ground" => ("the ground is here: a bearing", bearing()),
        "body" => ("a body: name and mass, inside of its outline", marker()),
        "point" => ("a named point of a body", point()),
        "com" => ("centre of mass of a body", centre_of_mass()),
        "frame" => ("frame of a body, if it is to be another", frame()),
        "revolute" => ("revolute joint", pin()),
        "prismatic" => ("prismatic joint, along x", slider()),
        "slot" => ("pin of body 2 in a slot of body 1, along x", slot()),
        "weld" => ("rigid connection", weld()),
        "link" => ("massless link between two points", link()),
        "gravity" => ("gravity, down when it is not turned", gravity()),
        "force" => ("force at a point, along x", arrow([0.0, 0.0], [1.5, 0.0], 0.3)),
        "actuator" => ("force between two points", actuator()),
        "torque" => ("torque on a body", curved_arrow(0.5)),
        "spring" => ("spring, with a damper beside it", spring()),
        "damper" => ("damper", damper()),
        "torsion" => ("torsional spring of a joint", spiral()),
        "stop" => ("limits of a joint", stop()),
        "friction" => ("dry friction of a joint", friction()),
        "drive" => ("prescribed motion of a joint", drive()),
        "point-on-curve" => (
            "point or roller of body 2 on a curve of body 1",
            follower(Mark::Circle([0.4, 0.18], 0.05)),
        ),
        "line-on-curve" => (
            "flat face of body 2 on a curve of body 1",
            follower(Mark::Line([0.3, 0.05], [0.55, 0.25])),
        ),
        "curve-on-curve" => ("curve of body 2 on a curve of body 1", touching()),
        "cylinder" => ("actuator or rope between two points", cylinder()),
        "gear" => ("gears, from wheel to wheel", gear()),
        "rack" => ("pinion and rack, from one to the other", rack()),
        "belt" => ("belt around wheels", belt(0.0)),
        "chain" => ("chain around wheels", belt(0.03)),
        "screw" => ("nut on a spindle", screw()),
        "relation" => ("a relation of motions", sheet("=")),
        "table" => ("a table of numbers", table()),
        "curve" => ("a curve that is followed", curve()),
        "cam-law" => ("the law of a cam", sheet("h")),
        "cam" => ("the profile of a cam", cam()),
        "state" => ("a quantity that is integrated", sheet("1/s")),
        "clock" => ("the clock of a sampled controller", clock()),
        "signal" => ("a named expression", sheet("u")),
        "part" => ("a model of another file, or of the library", part()),
        "io" => ("inputs and outputs of linear equations", sheet("io")),
        "parameter" => ("a named number", sheet("P")),
        "initial" => ("where the motion starts", sheet("0")),
        "solve" => ("how to solve", sheet("S")),
        "model" => ("name and coordinates of the mechanism", sheet("M")),
        _ => return None,
    };
    Some(Symbol { title, marks })
}

/// A shaft and a filled head at its end.
pub(super) fn arrow(from: Point, to: Point, head: f64) -> Vec<Mark> {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let length = dx.hypot(dy);
    if length == 0.0 {
        return Vec::new();
    }
    let (along, head) = ([dx / length, dy / length], head.min(length));
    let base = [to[0] - head * along[0], to[1] - head * along[1]];
    let side = |width: f64| [base[0] - width * along[1], base[1] + width * along[0]];
    vec![Mark::Line(from, base), Mark::Fill([to, side(head / 4.0), side(-head / 4.0)])]
}

/// Short strokes below a line from `from` to `to`, towards the ground.
fn hatching(from: f64, to: f64, y: f64) -> impl Iterator<Item = Mark> {
    const STROKES: u8 = 5;
    (0..STROKES).map(move |i| {
        let x = from + (to - from) * (f64::from(i) + 1.0) / f64::from(STROKES);
        Mark::Line([x, y], [x - 0.15, y - 0.15])
    })
}

fn bearing() -> Vec<Mark> {
    let mut marks = vec![
        Mark::chain(&[[0.0, 0.0], [0.35, -0.55], [-0.35, -0.55]], true),
        Mark::Line([-0.5, -0.55], [0.5, -0.55]),
    ];
    marks.extend(hatching(-0.5, 0.5, -0.55));
    marks
}

/// A tag that lies on a part.
fn marker() -> Vec<Mark> {
    const HALF: f64 = 0.12;
    vec![
        Mark::chain(&[[-HALF, 0.0], [0.0, -HALF], [HALF, 0.0], [0.0, HALF]], true),
        Mark::chain(&[[HALF, 0.0], [HALF + 0.2, 0.2]], false),
    ]
}

fn frame() -> Vec<Mark> {
    let mut marks = arrow([0.0, 0.0], [0.9, 0.0], 0.25);
    marks.extend(arrow([0.0, 0.0], [0.0, 0.9], 0.25));
    marks.push(Mark::chain(&[[0.12, 0.0], [0.12, 0.12], [0.0, 0.12]], false));
    marks
}

fn point() -> Vec<Mark> {
    vec![Mark::Line([-0.12, -0.12], [0.12, 0.12]), Mark::Line([-0.12, 0.12], [0.12, -0.12])]
}

fn centre_of_mass() -> Vec<Mark> {
    const RADIUS: f64 = 0.2;
    const SLICES: u8 = 4;
    let mut marks = vec![
        Mark::Circle([0.0, 0.0], RADIUS),
        Mark::Line([-RADIUS, 0.0], [RADIUS, 0.0]),
        Mark::Line([0.0, -RADIUS], [0.0, RADIUS]),
    ];
    // Two of the quarters are filled.
    for quarter in [0.0, PI] {
        let at = |i: u8| {
            let angle = quarter + PI / 2.0 * f64::from(i) / f64::from(SLICES);
            [RADIUS * angle.cos(), RADIUS * angle.sin()]
        };
        marks.extend((0..SLICES).map(|i| Mark::Fill([[0.0, 0.0], at(i), at(i + 1)])));
    }
    marks
}

fn pin() -> Vec<Mark> {
    vec![Mark::Circle([0.0, 0.0], 0.2), Mark::Circle([0.0, 0.0], 0.04)]
}

fn slider() -> Vec<Mark> {
    let mut marks = vec![
        rectangle([-0.4, -0.2], [0.4, 0.2]),
        Mark::Line([-0.9, 0.24], [0.9, 0.24]),
        Mark::Line([-0.9, -0.24], [0.9, -0.24]),
    ];
    marks.extend(hatching(-0.9, 0.9, -0.24));
    marks
}

fn slot() -> Vec<Mark> {
    // Half circles are bulges of one.
    let corners =
        vec![([-0.7, -0.2], 0.0), ([0.7, -0.2], 1.0), ([0.7, 0.2], 0.0), ([-0.7, 0.2], 1.0)];
    vec![Mark::Polyline { corners, is_closed: true }, Mark::Circle([0.0, 0.0], 0.16)]
}

fn weld() -> Vec<Mark> {
    let [a, b, c, d] = [[-0.15, -0.15], [0.15, -0.15], [0.15, 0.15], [-0.15, 0.15]];
    vec![rectangle(a, c), Mark::Fill([a, b, c]), Mark::Fill([a, c, d])]
}

fn link() -> Vec<Mark> {
    vec![
        Mark::Line([0.03, 0.0], [0.97, 0.0]),
        Mark::Circle([0.0, 0.0], 0.03),
        Mark::Circle([1.0, 0.0], 0.03),
    ]
}

/// Down, as long as the block is not turned.
fn gravity() -> Vec<Mark> {
    vec![
        Mark::chain(&[[0.06, -1.0], [0.06, 0.0], [-0.06, 0.0], [-0.06, -1.0]], false),
        Mark::Fill([[0.0, -1.5], [0.18, -1.0], [-0.18, -1.0]]),
    ]
}

fn actuator() -> Vec<Mark> {
    vec![
        Mark::Line([0.0, 0.0], [0.2, 0.0]),
        rectangle([0.2, -0.06], [0.65, 0.06]),
        Mark::Line([0.5, -0.06], [0.5, 0.06]),
        Mark::Line([0.5, 0.0], [1.0, 0.0]),
        Mark::Fill([[0.95, 0.0], [0.87, 0.025], [0.87, -0.025]]),
    ]
}

/// Three quarters of a circle, counter-clockwise, with a head.
fn curved_arrow(radius: f64) -> Vec<Mark> {
    let [start, end] = [-0.25 * PI, 1.1 * PI];
    let tip = [radius * end.cos(), radius * end.sin()];
    let along = [-end.sin(), end.cos()];
    let side = |width: f64| [tip[0] + width * end.cos(), tip[1] + width * end.sin()];
    let point = [tip[0] + 0.28 * along[0], tip[1] + 0.28 * along[1]];
    vec![Mark::Arc([0.0, 0.0], radius, [start, end]), Mark::Fill([point, side(0.08), side(-0.08)])]
}

fn spring() -> Vec<Mark> {
    const COILS: u8 = 6;
    let mut points = vec![[0.0, 0.0], [0.2, 0.0]];
    for i in 0..2 * COILS {
        let x = 0.2 + 0.6 * (f64::from(i) + 0.5) / f64::from(2 * COILS);
        points.push([x, if i % 2 == 0 { 0.07 } else { -0.07 }]);
    }
    points.extend([[0.8, 0.0], [1.0, 0.0]]);
    vec![Mark::chain(&points, false)]
}

fn damper() -> Vec<Mark> {
    vec![
        Mark::Line([0.0, 0.0], [0.35, 0.0]),
        Mark::chain(&[[0.65, 0.08], [0.35, 0.08], [0.35, -0.08], [0.65, -0.08]], false),
        Mark::Line([0.5, 0.06], [0.5, -0.06]),
        Mark::Line([0.5, 0.0], [1.0, 0.0]),
    ]
}

fn spiral() -> Vec<Mark> {
    const TURNS: f64 = 2.5;
    const POINTS: u8 = 60;
    let at = |i: u8| {
        let part = f64::from(i) / f64::from(POINTS);
        let (radius, angle) = (0.25 + 0.3 * part, 2.0 * PI * TURNS * part);
        [radius * angle.cos(), radius * angle.sin()]
    };
    let mut points: Vec<Point> = (0..=POINTS).map(at).collect();
    points.push([-0.75, 0.0]);
    vec![Mark::chain(&points, false)]
}

fn stop() -> Vec<Mark> {
    let mut marks = vec![
        Mark::Line([-0.5, -0.3], [0.5, -0.3]),
        Mark::chain(&[[-0.2, -0.3], [-0.2, 0.0], [0.2, 0.0], [0.2, -0.3]], false),
    ];
    marks.extend(hatching(-0.5, 0.5, -0.3));
    marks
}

fn friction() -> Vec<Mark> {
    let teeth = |y: f64, height: f64| {
        let corner =
            |i: u8| [-0.5 + 0.1 * f64::from(i), if i.is_multiple_of(2) { y } else { y + height }];
        Mark::chain(&(0..=10).map(corner).collect::<Vec<_>>(), false)
    };
    vec![
        teeth(0.06, 0.08),
        teeth(-0.06, -0.08),
        Mark::Line([-0.5, 0.3], [0.5, 0.3]),
        Mark::Line([-0.5, -0.3], [0.5, -0.3]),
    ]
}

fn drive() -> Vec<Mark> {
    let mut marks = curved_arrow(0.5);
    marks.push(Mark::Circle([0.0, 0.0], 0.34));
    marks.push(Mark::centred([0.0, -0.15], 0.3, "M"));
    marks
}

/// A sheet of paper with a letter.
fn sheet(letter: &str) -> Vec<Mark> {
    vec![
        Mark::chain(&[[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.35, 0.65], [0.0, 0.65]], true),
        Mark::chain(&[[0.35, 0.65], [0.35, 0.5], [0.5, 0.5]], false),
        Mark::centred([0.25, 0.13], 0.25, letter),
    ]
}

/// A rising path, and what follows it at the far end.
fn follower(what: Mark) -> Vec<Mark> {
    let path: Vec<Point> =
        (0..=12).map(|i| 0.04 * f64::from(i)).map(|x| [x, x * x - 0.06]).collect();
    vec![Mark::chain(&path, false), Mark::Line([0.44, 0.16], [1.0, 0.0]), what]
}

/// Two curves that touch halfway.
fn touching() -> Vec<Mark> {
    let path = |side: f64| -> Vec<Point> {
        let at = |i: i32| 0.04 * f64::from(i);
        (-6..=6).map(|i| [0.5 + side * at(i) * at(i), at(i)]).collect()
    };
    vec![
        Mark::chain(&path(1.0), false),
        Mark::chain(&path(-2.0), false),
        Mark::Line([0.0, 0.0], [0.5, 0.0]),
        Mark::Line([0.5, 0.0], [1.0, 0.0]),
    ]
}

/// A barrel and its rod, with pins at both ends.
fn cylinder() -> Vec<Mark> {
    vec![
        Mark::Circle([0.0, 0.0], 0.03),
        rectangle([0.03, -0.07], [0.6, 0.07]),
        Mark::Line([0.5, -0.07], [0.5, 0.07]),
        Mark::Line([0.5, 0.0], [0.97, 0.0]),
        Mark::Circle([1.0, 0.0], 0.03),
    ]
}

/// Two circles that touch, with the teeth that mesh.
fn gear() -> Vec<Mark> {
    let mut marks = vec![Mark::Circle([0.0, 0.0], 0.4), Mark::Circle([1.0, 0.0], 0.6)];
    for (centre, radius, facing) in [(0.0, 0.4, 0.0), (1.0, 0.6, PI)] {
        marks.extend((-2..=2).map(|i| {
            let angle = facing + 0.08 * f64::from(i) / radius;
            let at = |r: f64| [centre + r * angle.cos(), r * angle.sin()];
            Mark::Line(at(radius - 0.03), at(radius + 0.03))
        }));
    }
    marks
}

/// A circle and a toothed line across the way to the rack.
fn rack() -> Vec<Mark> {
    let tooth = |i: u8| {
        let depth = if i.is_multiple_of(2) { 0.33 } else { 0.27 };
        [depth, 0.06 * f64::from(i) - 0.6]
    };
    let teeth: Vec<Point> = (0..=20).map(tooth).collect();
    vec![
        Mark::Circle([0.0, 0.0], 0.3),
        Mark::chain(&teeth, false),
        Mark::Line([0.33, 0.0], [1.0, 0.0]),
    ]
}

/// Two circles and the strands that touch them outside, `apart` from them.
fn belt(apart: f64) -> Vec<Mark> {
    // The strands touch both circles where the sine of their slope is the difference of the radii.
    let [small, large]: [f64; 2] = [0.2, 0.3];
    let (sin, cos) = (large - small, (1.0 - (large - small).powi(2)).sqrt());
    let strand = |side: f64| {
        let at = |x: f64, radius: f64| [x - (radius + apart) * sin, side * (radius + apart) * cos];
        Mark::Line(at(0.0, small), at(1.0, large))
    };
    vec![
        Mark::Circle([0.0, 0.0], small),
        Mark::Circle([1.0, 0.0], large),
        strand(1.0),
        strand(-1.0),
    ]
}

/// A spindle with its thread in a nut.
fn screw() -> Vec<Mark> {
    let mut marks =
        vec![rectangle([-0.8, -0.12], [0.8, 0.12]), rectangle([-0.25, -0.35], [0.25, 0.35])];
    marks.extend((-7..=7).map(|i| {
        let x = 0.1 * f64::from(i);
        Mark::Line([x - 0.03, -0.12], [x + 0.03, 0.12])
    }));
    marks
}

fn table() -> Vec<Mark> {
    let mut marks = vec![rectangle([0.0, 0.0], [0.6, 0.6])];
    marks.extend([0.2, 0.4].map(|y| Mark::Line([0.0, y], [0.6, y])));
    marks.push(Mark::Line([0.3, 0.0], [0.3, 0.6]));
    marks
}

fn curve() -> Vec<Mark> {
    let at = |i: i32| [0.03 * f64::from(i), 0.3 + 0.2 * (0.3 * f64::from(i)).sin()];
    vec![
        rectangle([0.0, 0.0], [0.6, 0.6]),
        Mark::chain(&(0..=20).map(at).collect::<Vec<_>>(), false),
    ]
}

/// A circle with a nose.
fn cam() -> Vec<Mark> {
    let at = |i: i32| {
        let angle = PI / 30.0 * f64::from(i);
        let radius = 0.2 + 0.16 * (0.5 * angle).sin().powi(4);
        [0.3 - radius * angle.cos(), 0.3 + radius * angle.sin()]
    };
    vec![Mark::chain(&(0..60).map(at).collect::<Vec<_>>(), true), Mark::Circle([0.3, 0.3], 0.05)]
}

fn clock() -> Vec<Mark> {
    vec![
        Mark::Circle([0.3, 0.3], 0.3),
        Mark::Line([0.3, 0.3], [0.3, 0.52]),
        Mark::Line([0.3, 0.3], [0.45, 0.3]),
    ]
}

/// A box with a mechanism in it.
fn part() -> Vec<Mark> {
    vec![
        rectangle([0.0, 0.0], [0.7, 0.6]),
        Mark::chain(&[[0.15, 0.15], [0.25, 0.45], [0.55, 0.4]], false),
        Mark::Circle([0.15, 0.15], 0.05),
        Mark::Circle([0.25, 0.45], 0.05),
        Mark::Circle([0.55, 0.4], 0.05),
    ]
}

fn rectangle([left, bottom]: Point, [right, top]: Point) -> Mark {
    Mark::chain(&[[left, bottom], [right, bottom], [right, top], [left, top]], true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::KINDS;

    #[test]
    fn every_kind_has_a_symbol() {
        for kind in KINDS {
            let symbol = symbol(kind.name).unwrap_or_else(|| panic!("{} has none", kind.name));
            assert!(!symbol.marks.is_empty() && !symbol.title.is_empty(), "{}", kind.name);
        }
    }
}
