//! Springs, dampers, cylinders and links between two points, as lines.
//!
//! Across its line, a span has a width that does not change; along it, everything but the straight
//! ends is stretched.

use bksim_sim::pose::Pose;

use crate::geometry::across3;
use crate::{Role, Scene, Span, SpanKind};

/// Half width of a spring, radii of a pin.
const COIL: f64 = 2.0;
/// Half width of a damper's cylinder.
const CYLINDER: f64 = 1.5;
/// Half width of the barrel of an actuator.
const BARREL: f64 = 1.3;
/// Length of the straight ends.
const LEAD: f64 = 3.0;
/// Unloaded length of one turn.
const TURN: f64 = 2.2;
/// Distance of a spring, and of the damper parallel to it, from their line.
const APART: f64 = 2.2;

/// A line, and the part that it depicts.
type Line = (Role, Vec<[f64; 3]>);

/// Something stretched between bodies, where these are.
#[derive(Clone, PartialEq, Debug)]
pub struct Stretched<'a> {
    /// Name of the load, joint, rope or belt.
    pub name: &'a str,
    /// Lines in the world, m, and the parts that they depict.
    pub lines: Vec<Line>,
}

impl Scene {
    /// All that is stretched between bodies at these poses, facing `eye`: spans, then ropes and belts.
    pub fn stretched(&self, poses: &[Pose], eye: [f64; 3]) -> Vec<Stretched<'_>> {
        let span = |span: &'_ Span| {
            let [Some(a), Some(b)] = span.ends.each_ref().map(|end| poses.get(end.body)) else {
                return Vec::new();
            };
            let ends = [a.place(span.ends[0].position), b.place(span.ends[1].position)];
            span.lines(ends, self.pin, eye)
        };
        let spans = self.spans.iter().map(|it| Stretched { name: &it.name, lines: span(it) });
        let cords = self.cords.iter().map(|cord| {
            let lines = cord.line(poses).map(|points| (Role::Link, points)).into_iter().collect();
            Stretched { name: &cord.name, lines }
        });
        spans.chain(cords).collect()
    }
}

impl Span {
    /// Lines of the span with ends at these points of the world, and the parts that they depict. `pin`
    /// is the radius of a pin, m. Everything lies in the plane through the ends that faces `eye`, a
    /// unit vector: z where the mechanism is planar, else the direction to the viewer.
    pub fn lines(&self, ends: [[f64; 3]; 2], pin: f64, eye: [f64; 3]) -> Vec<Line> {
        let axis = Baseline::new(ends, pin, eye);
        match self.kind {
            SpanKind::Spring { length, is_damped: false } => {
                vec![axis.line(Role::Spring, &axis.spring(length, 0.0))]
            }
            SpanKind::Spring { length, is_damped: true } => {
                let mut lines = vec![axis.line(Role::Spring, &axis.spring(length, APART))];
                lines.extend(axis.damper(length, -APART));
                let bar = |x: f64| [[x, APART * pin], [x, -APART * pin]];
                let [from, to] = axis.inner();
                for (outer, inner) in [(0.0, from), (axis.length, to)] {
                    lines.push(axis.line(Role::Spring, &[[outer, 0.0], [inner, 0.0]]));
                    lines.push(axis.line(Role::Spring, &bar(inner)));
                }
                lines
            }
            SpanKind::Damper { length } => axis.damper(length, 0.0),
            SpanKind::Cylinder { length } => axis.cylinder(length),
            SpanKind::Link => vec![(Role::Link, ends.to_vec())],
        }
    }
}

/// The straight line from one end to the other, with coordinates along it and across.
struct Baseline {
    ends: [[f64; 3]; 2],
    along: [f64; 3],
    across: [f64; 3],
    length: f64,
    pin: f64,
}

impl Baseline {
    fn new(ends: [[f64; 3]; 2], pin: f64, eye: [f64; 3]) -> Self {
        let d: [f64; 3] = std::array::from_fn(|i| ends[1][i] - ends[0][i]);
        let length = d[0].hypot(d[1]).hypot(d[2]);
        // Ends that coincide have no direction; any will do.
        let along = d.map(|x| x / length);
        let along = if along.iter().all(|x| x.is_finite()) { along } else { [1.0, 0.0, 0.0] };
        let across = across3(along, eye);
        let length = if length.is_finite() { length } else { 0.0 };
        Self { ends, along, across, length, pin }
    }

    /// A point in the world, counted from the nearer end, so that both ends are met exactly.
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let [from, to] = self.ends;
        let (end, x) = if 2.0 * x <= self.length { (from, x) } else { (to, x - self.length) };
        std::array::from_fn(|i| end[i] + x * self.along[i] + y * self.across[i])
    }

    fn line(&self, role: Role, points: &[[f64; 2]]) -> Line {
        (role, points.iter().map(|&p| self.at(p)).collect())
    }

    /// Positions where the straight ends stop: at a fifth of a short span.
    fn inner(&self) -> [f64; 2] {
        let lead = (LEAD * self.pin).min(0.2 * self.length);
        [lead, self.length - lead]
    }

    /// A zigzag at a distance `aside` from the line, radii of a pin; on the line, with its ends.
    fn spring(&self, unloaded: f64, aside: f64) -> Vec<[f64; 2]> {
        let [from, to] = self.inner();
        let (middle, half) = (aside * self.pin, COIL * self.pin);
        let half = if aside == 0.0 { half } else { 0.7 * half };
        let n = n_turns(unloaded / (TURN * self.pin));
        let mut points = Vec::with_capacity(2 * n + 4);
        if aside == 0.0 {
            points.push([0.0, 0.0]);
        }
        points.push([from, middle]);
        for i in 0..2 * n {
            let side = if i % 2 == 0 { half } else { -half };
            points.push([from + (to - from) * (i as f64 + 0.5) / (2 * n) as f64, middle + side]);
        }
        points.push([to, middle]);
        if aside == 0.0 {
            points.push([self.length, 0.0]);
        }
        points
    }

    /// A closed barrel on the first end, out of which the rod of the second comes; at its first length the
    /// piston is in the middle.
    fn cylinder(&self, first: f64) -> Vec<Line> {
        let first = if first > 0.0 && first < 1e100 { first } else { self.length };
        let half = BARREL * self.pin;
        let barrel = (0.6 * first).min(0.9 * self.length);
        let bottom = (1.5 * self.pin).min(0.2 * barrel);
        let rod = first - 0.5 * (bottom + barrel);
        let piston = (self.length - rod).clamp(bottom + 0.08 * barrel, 0.95 * barrel);
        let shell =
            [[bottom, half], [bottom, -half], [barrel, -half], [barrel, half], [bottom, half]];
        vec![
            self.line(Role::Damper, &[[0.0, 0.0], [bottom, 0.0]]),
            self.line(Role::Damper, &shell),
            self.line(Role::Damper, &[[piston, half], [piston, -half]]),
            self.line(Role::Damper, &[[piston, 0.0], [self.length, 0.0]]),
        ]
    }

    /// A cylinder on the first end and a piston on the second.
    fn damper(&self, unloaded: f64, aside: f64) -> Vec<Line> {
        let [from, to] = self.inner();
        let (middle, half) = (aside * self.pin, CYLINDER * self.pin);
        // The cylinder hangs on the first end, the rod on the second; both keep their lengths as
        // long as there is room for them, and the piston stays in the cylinder.
        let unloaded = if unloaded > 0.0 && unloaded < 1e100 { unloaded } else { self.length };
        let bottom = (from + 0.1 * unloaded).min(0.3 * self.length);
        let cylinder = (0.5 * unloaded).min(0.5 * self.length);
        // Unloaded, the piston is in the middle.
        let rod = 0.65 * unloaded - LEAD * self.pin;
        let piston = (self.length - rod).clamp(bottom + 0.12 * cylinder, bottom + 0.88 * cylinder);
        let start = if aside == 0.0 { 0.0 } else { from };
        let end = if aside == 0.0 { self.length } else { to };
        let open = bottom + cylinder;
        let shell = [
            [open, middle + half],
            [bottom, middle + half],
            [bottom, middle - half],
            [open, middle - half],
        ];
        let face = 0.75 * half;
        vec![
            self.line(Role::Damper, &[[start, middle], [bottom, middle]]),
            self.line(Role::Damper, &shell),
            self.line(Role::Damper, &[[piston, middle + face], [piston, middle - face]]),
            self.line(Role::Damper, &[[piston, middle], [end, middle]]),
        ]
    }
}

/// Turns of a spring: at least three, so that it looks like one, and no more than can be counted.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "3 to 24")]
fn n_turns(turns: f64) -> usize {
    if turns.is_finite() { turns.round().clamp(3.0, 24.0) as usize } else { 6 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Attached;

    const KINDS: [SpanKind; 7] = [
        SpanKind::Spring { length: 1.0, is_damped: false },
        SpanKind::Spring { length: 1.0, is_damped: true },
        SpanKind::Spring { length: f64::NAN, is_damped: true },
        SpanKind::Damper { length: 0.7 },
        SpanKind::Damper { length: f64::INFINITY },
        SpanKind::Link,
        SpanKind::Cylinder { length: 0.9 },
    ];

    fn lines(kind: SpanKind, ends: [[f64; 3]; 2]) -> Vec<Line> {
        let end = Attached { body: 0, position: [0.0; 3] };
        Span { name: String::new(), ends: [end; 2], kind }.lines(ends, 0.03, [0.0, 0.0, 1.0])
    }

    #[test]
    fn the_ends_are_met_at_any_distance_and_in_any_direction() {
        let from = [0.3, -0.2, 0.1];
        let vectors =
            [[1.0, 0.5, 0.0], [0.0, 0.0, 0.4], [1e-3, 0.0, 0.0], [0.0; 3], [-9.0, 2.0, 5.0]];
        for kind in KINDS {
            for vector in vectors {
                let to = std::array::from_fn(|i| from[i] + vector[i]);
                let lines = lines(kind, [from, to]);
                let points: Vec<[f64; 3]> =
                    lines.iter().flat_map(|(_, line)| line.clone()).collect();
                assert!(points.iter().flatten().all(|x| x.is_finite()), "{kind:?} {vector:?}");
                for end in [from, to] {
                    assert!(points.contains(&end), "{kind:?} {vector:?} does not meet {end:?}");
                }
            }
        }
    }

    #[test]
    fn a_spring_is_as_wide_from_wherever_it_is_seen() {
        let end = Attached { body: 0, position: [0.0; 3] };
        let span = Span { name: String::new(), ends: [end; 2], kind: KINDS[0] };
        for eye in [[0.0, 0.0, 1.0], [0.6, 0.8, 0.0], [0.48, 0.64, -0.6]] {
            let drawn = span.lines([[0.0; 3], [-0.8, 0.6, 0.0]], 0.03, eye);
            let depth = |p: &[f64; 3]| p.iter().zip(eye).map(|(a, b)| a * b).sum::<f64>();
            let ends = [0.0, depth(&[-0.8, 0.6, 0.0])];
            let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            // No nearer to the eye than its ends, nor farther: it does not lean.
            let is_level = |p: &[f64; 3]| (low - 1e-12..=high + 1e-12).contains(&depth(p));
            assert!(drawn[0].1.iter().all(is_level), "{eye:?}");
        }
    }

    #[test]
    fn a_stretched_spring_is_as_wide_and_has_as_many_turns_as_before() {
        let measure = |length: f64| {
            let drawn = lines(KINDS[0], [[0.0; 3], [length, 0.0, 0.0]]);
            let line = &drawn[0].1;
            (line.len(), line.iter().map(|p| p[1]).fold(0.0, f64::max))
        };
        let (n, half) = measure(1.0);
        assert_eq!(measure(3.0), (n, half));
        assert!((half - COIL * 0.03).abs() < 1e-12);
        // Two corners for each turn, two ends, and where the straight ends stop.
        assert_eq!(n, 2 * n_turns(1.0 / (TURN * 0.03)) + 4);
    }

    #[test]
    fn the_rod_of_a_damper_keeps_its_length() {
        let rod = |length: f64| {
            let drawn = lines(KINDS[3], [[0.0; 3], [length, 0.0, 0.0]]);
            let [from, to] = [drawn[3].1[0], drawn[3].1[1]];
            to[0] - from[0]
        };
        assert!((rod(0.75) - rod(0.65)).abs() < 1e-12);
    }

    #[test]
    fn ends_that_are_no_numbers_make_no_panic() {
        for kind in KINDS {
            for end in [[f64::NAN; 3], [1e300, -1e300, 1e300], [f64::INFINITY, 0.0, 0.0]] {
                assert!(!lines(kind, [[0.0; 3], end]).is_empty());
            }
        }
    }
}
