//! Contacts: loops that touch are distinguished from loops that cross.
//!
//! Pieces of two loops near each other are cut wherever they could cross: at the lines and circles
//! the other pieces are part of, and abeam of their ends. Each part between two cuts is then on one
//! side of the other loop, and its middle says on which. Loops with parts on both sides cross.

use super::OutlineError;
use super::border::Border;
use super::boxes::BoxTree;
use crate::geometry::conic::Conic;
use crate::geometry::vector::{along, cross, distance, dot, norm, sub};
use crate::geometry::{Bounds, Curve, Point};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Contacts shallower than this part of the whole are touches.
const SHALLOW: f64 = 1e-6;

/// No tolerance is larger than this part of the whole: else everything would touch everything.
const COARSE: f64 = 1e-3;

/// Which loop is inside which, of those that touch.
#[derive(Clone, Debug, Default)]
pub(super) struct Contacts {
    inside: BTreeMap<(usize, usize), bool>,
}

impl Contacts {
    /// Whether loop `a` is inside loop `b`; `None` when they do not touch.
    pub(super) fn is_inside(&self, a: usize, b: usize) -> Option<bool> {
        self.inside.get(&(a, b)).copied()
    }
}

/// Loops that meet as they must not.
pub(super) struct Meeting {
    pub(super) loops: [usize; 2],
    at: Point,
    is_crossing: bool,
}

impl Meeting {
    pub(super) fn error(self, entities: [usize; 2]) -> OutlineError {
        let at = self.at;
        if self.is_crossing {
            OutlineError::Crossing { at, entities }
        } else {
            OutlineError::Coincident { at, entities }
        }
    }
}

/// A line or a part of a circle, of a loop.
struct Element {
    loop_idx: usize,
    form: Form,
}

#[derive(Clone, Copy)]
enum Form {
    Line([Point; 2]),
    Arc(Conic),
}

/// The contacts of all loops.
///
/// Ellipses and splines are followed here by lines within a quarter of the tolerance; what is near
/// or inside is asked of the curves themselves.
///
/// # Errors
/// Loops that cross another or themselves, or lie on another.
pub(super) fn contacts(borders: &[Border], tolerance: f64) -> Result<Contacts, Meeting> {
    let all = borders.iter().map(|border| border.bounds).fold(Bounds::EMPTY, Bounds::union);
    let tolerance = tolerance.max(SHALLOW * all.diagonal()).min(COARSE * all.diagonal());
    let mut elements = Vec::new();
    for (loop_idx, border) in borders.iter().enumerate() {
        for curve in &border.path.curves {
            forms_into(curve, tolerance / 4.0, |form| elements.push(Element { loop_idx, form }));
        }
    }
    let boxes: Vec<Bounds> =
        elements.iter().map(|element| element.form.bounds().grown(tolerance)).collect();
    let tree = BoxTree::anywhere(&boxes);

    let mut sides: BTreeMap<(usize, usize), Sides> = BTreeMap::new();
    for (i, element) in elements.iter().enumerate() {
        // Where this piece could cross pieces of other loops, loop by loop.
        let mut cuts: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        let mut crossing = None;
        tree.meeting(&boxes[i], |k| {
            let other = &elements[k];
            if other.loop_idx != element.loop_idx {
                let found = cuts.entry(other.loop_idx).or_insert_with(|| vec![0.0, 1.0]);
                element.form.cuts_into(&other.form, found);
            } else if k > i && crossing.is_none() {
                crossing = element.form.crossing(&other.form, tolerance);
            }
        });
        if let Some(at) = crossing {
            return Err(Meeting { loops: [element.loop_idx; 2], at, is_crossing: true });
        }
        for (other, mut cuts) in cuts {
            let sides = sides.entry((element.loop_idx, other)).or_default();
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2) {
                let middle = element.form.point(0.5 * (pair[0] + pair[1]));
                sides.see(&borders[other], middle, tolerance);
            }
            if let (Some(at), Some(_)) = (sides.inside, sides.outside) {
                return Err(Meeting { loops: [element.loop_idx, other], at, is_crossing: true });
            }
        }
    }
    decided(borders, &sides, tolerance)
}

/// Where parts of one loop were seen, on the two sides of another.
#[derive(Default)]
struct Sides {
    inside: Option<Point>,
    outside: Option<Point>,
}

impl Sides {
    fn see(&mut self, other: &Border, point: Point, tolerance: f64) {
        if other.is_near(point, tolerance) {
            return;
        }
        let side = if other.contains(point) { &mut self.inside } else { &mut self.outside };
        side.get_or_insert(point);
    }
}

/// Turns what was seen near contacts into what is inside what.
fn decided(
    borders: &[Border],
    seen: &BTreeMap<(usize, usize), Sides>,
    tolerance: f64,
) -> Result<Contacts, Meeting> {
    let mut contacts = Contacts::default();
    for (&(a, b), sides) in seen {
        let is_inside = match (sides.inside, sides.outside) {
            (Some(_), _) => true,
            (_, Some(_)) => false,
            // Only touching where they are near: any other part of the loop decides.
            (None, None) => {
                let middles = borders[a]
                    .path
                    .curves
                    .iter()
                    .flat_map(|curve| [0.25, 0.5, 0.75].map(|t| curve.point(t)));
                let mut away = middles.filter(|point| !borders[b].is_near(*point, tolerance));
                let Some(point) = away.next() else {
                    let at = borders[a].start();
                    return Err(Meeting { loops: [a, b], at, is_crossing: false });
                };
                borders[b].contains(point)
            }
        };
        contacts.inside.insert((a, b), is_inside);
    }
    Ok(contacts)
}

fn forms_into(curve: &Curve, tolerance: f64, mut push: impl FnMut(Form)) {
    match curve {
        Curve::Segment { from, to } => push(Form::Line([*from, *to])),
        Curve::Arc { .. } => {
            let quarters = curve.conic().into_iter().flat_map(|conic| conic.quarters());
            quarters.for_each(|quarter| push(Form::Arc(quarter)));
        }
        Curve::Ellipse { .. } | Curve::Spline(_) => {
            let mut corners = vec![curve.start_point()];
            curve.corners_into(tolerance, &mut corners);
            corners.windows(2).for_each(|pair| push(Form::Line([pair[0], pair[1]])));
        }
    }
}

impl Form {
    fn bounds(&self) -> Bounds {
        match self {
            Self::Line(ends) => Bounds::of(*ends),
            Self::Arc(arc) => arc.bounds(),
        }
    }

    fn point(&self, t: f64) -> Point {
        match self {
            Self::Line([from, to]) => along(*from, t, sub(*to, *from)),
            Self::Arc(arc) => arc.point(t),
        }
    }

    fn ends(&self) -> [Point; 2] {
        [self.point(0.0), self.point(1.0)]
    }

    /// The parameter of the point abeam of `p`; beyond 0 to 1 when there is none.
    fn abeam(&self, p: Point) -> f64 {
        match self {
            Self::Line([from, to]) => {
                let line = sub(*to, *from);
                dot(sub(p, *from), line) / dot(line, line)
            }
            Self::Arc(arc) => {
                let [x, y] = sub(p, arc.centre);
                let ahead = (y.atan2(x) - arc.start) * arc.sweep.signum();
                ahead.rem_euclid(TAU) / arc.sweep.abs()
            }
        }
    }

    /// Distance of `p` from the whole line or circle, with a sign for its side.
    fn side(&self, p: Point) -> f64 {
        match self {
            Self::Line([from, to]) => {
                let line = sub(*to, *from);
                cross(line, sub(p, *from)) / norm(line)
            }
            Self::Arc(arc) => distance(p, arc.centre) - norm(arc.major),
        }
    }

    /// Parameters within 0 to 1 where `other` could cross, and abeam of its ends.
    fn cuts_into(&self, other: &Self, cuts: &mut Vec<f64>) {
        let mut push = |t: f64| cuts.extend((0.0 < t && t < 1.0).then_some(t));
        self.carrier_cuts(other).into_iter().for_each(&mut push);
        other.ends().into_iter().for_each(|end| push(self.abeam(end)));
    }

    /// Parameters where this piece meets the whole line or circle of `other`; not a number where
    /// they do not meet.
    fn carrier_cuts(&self, other: &Self) -> [f64; 2] {
        match (self, other) {
            (Self::Line([from, to]), Self::Line([start, end])) => {
                let (line, other) = (sub(*to, *from), sub(*end, *start));
                [cross(sub(*start, *from), other) / cross(line, other), f64::NAN]
            }
            (Self::Line(ends), Self::Arc(arc)) => on_circle(*ends, arc).map(|p| self.abeam(p)),
            (Self::Arc(arc), Self::Line(ends)) => on_circle(*ends, arc).map(|p| self.abeam(p)),
            (Self::Arc(arc), Self::Arc(other)) => circles(arc, other).map(|p| self.abeam(p)),
        }
    }

    /// A point where two pieces of the same loop cross, further than `tolerance` from the ends of
    /// both and by more than that.
    fn crossing(&self, other: &Self, tolerance: f64) -> Option<Point> {
        let mut cuts = vec![0.0, 1.0];
        cuts.extend(self.carrier_cuts(other).into_iter().filter(|t| 0.0 < *t && *t < 1.0));
        cuts.sort_by(f64::total_cmp);
        let depth = |from: f64, to: f64| other.side(self.point(0.5 * (from + to)));
        let crosses = |part: &&[f64]| {
            let (before, after) = (depth(part[0], part[1]), depth(part[1], part[2]));
            let p = self.point(part[1]);
            let abeam = other.abeam(p);
            let ends = self.ends().into_iter().chain(other.ends());
            before * after < 0.0
                && before.abs().min(after.abs()) > tolerance
                && 0.0 < abeam
                && abeam < 1.0
                && ends.map(|end| distance(end, p)).fold(f64::INFINITY, f64::min) > tolerance
        };
        cuts.windows(3).find(crosses).map(|part| self.point(part[1]))
    }
}

/// Where a line meets a circle, if it does.
fn on_circle([from, to]: [Point; 2], arc: &Conic) -> [Point; 2] {
    let line = sub(to, from);
    let unit = [line[0] / norm(line), line[1] / norm(line)];
    let foot = along(from, dot(sub(arc.centre, from), unit), unit);
    let (radius, away) = (norm(arc.major), distance(foot, arc.centre));
    let half = ((radius - away) * (radius + away)).sqrt();
    [along(foot, -half, unit), along(foot, half, unit)]
}

/// Where two circles meet, if they do.
fn circles(a: &Conic, b: &Conic) -> [Point; 2] {
    let (ra, rb) = (norm(a.major), norm(b.major));
    let between = sub(b.centre, a.centre);
    let d = norm(between);
    let unit = [between[0] / d, between[1] / d];
    // Along the line of centres to the chord, then along the chord.
    let foot = 0.5 * (d + (ra - rb) * (ra + rb) / d);
    let half = ((ra - foot) * (ra + foot)).sqrt();
    let middle = along(a.centre, foot, unit);
    let across = [-unit[1], unit[0]];
    [along(middle, half, across), along(middle, -half, across)]
}
