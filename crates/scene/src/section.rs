//! [`Section`]: a plane that cuts a mechanism in space, so that its inside is seen.
//!
//! ```text
//! Section + direction to the eye → HalfSpace   the half that is kept
//! Scene + poses + HalfSpace → Scene            what is left of it, with the cut faces of its solids
//! ```
//!
//! No kept point lies before the plane. So where the plane is seen from the half that is left out, cut faces hide
//! all else and never each other: they are painted last.

mod area;
mod hatching;
mod solid;

use bksim_sim::pose::Pose;

use self::area::Cutter;
use self::hatching::{Hatching, hatching};
use self::solid::{Cut, cut};
use crate::geometry::{Plane, across3, along3, cross3, dot3, sub3, unit3};
use crate::rod::faceted;
use crate::{Form, Scene, Shape, Solid};

/// Slack of the half of space that is kept, radii of a pin.
const SLACK: f64 = 1e-6;

/// A plane of the world at which a mechanism is cut.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Section {
    /// Unit normal.
    normal: [f64; 3],
    /// Distance from the origin along the normal, m.
    pub offset: f64,
    /// The side that is left out.
    pub side: CutSide,
}

/// The side of a section plane that is left out.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum CutSide {
    /// The side nearer to the eye, whichever that is.
    #[default]
    Nearer,
    /// The side that the normal points to.
    Above,
}

impl Section {
    /// The plane through a point, m, across a normal of any length; none if the normal has no direction.
    pub fn new(normal: [f64; 3], point: [f64; 3], side: CutSide) -> Option<Self> {
        let normal = unit3(normal)?;
        let offset = dot3(normal, point);
        offset.is_finite().then_some(Self { normal, offset, side })
    }

    /// The unit normal.
    pub fn normal(&self) -> [f64; 3] {
        self.normal
    }

    /// Plane with its normal reversed.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self { normal: self.normal.map(|x| -x), offset: -self.offset, ..self }
    }

    /// The half of space that is kept, for a unit vector to the eye. Its plane is raised by `slack`, m, so that
    /// rounding errors leave out nothing that lies in it.
    pub fn kept(&self, eye: [f64; 3], slack: f64) -> HalfSpace {
        let turned = self.side == CutSide::Nearer && dot3(self.normal, eye) < 0.0;
        let Self { normal, offset, .. } = if turned { self.reversed() } else { *self };
        let u = across3(normal, [0.0, 0.0, 1.0]);
        let origin = normal.map(|x| (offset + slack) * x);
        HalfSpace { plane: Plane { origin, u, v: cross3(normal, u) }, normal, slack }
    }
}

/// All points that are not above a plane.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpace {
    /// Plane of the half space.
    plane: Plane,
    /// Unit normal of the plane, away from the half.
    normal: [f64; 3],
    /// The plane's distance from that of the section, m.
    slack: f64,
}

impl HalfSpace {
    /// Height of a point above the plane, m: positive where it is left out.
    pub fn height(&self, p: [f64; 3]) -> f64 {
        dot3(self.normal, sub3(p, self.plane.origin))
    }

    /// The pieces of a line through points that are kept.
    pub fn pieces(&self, points: &[[f64; 3]]) -> Vec<Vec<[f64; 3]>> {
        let mut pieces: Vec<Vec<[f64; 3]>> = Vec::new();
        let mut last: Option<([f64; 3], f64)> = None;
        for &p in points {
            let height = self.height(p);
            let is_kept = height <= 0.0;
            let was_kept = last.is_some_and(|(_, height)| height <= 0.0);
            // Where the line passes the plane.
            let crossing = last.filter(|_| is_kept != was_kept).map(|(before, before_height)| {
                along3(before, before_height / (before_height - height), sub3(p, before))
            });
            if is_kept && !was_kept {
                pieces.push(crossing.into_iter().collect());
            } else if let (true, Some(piece)) = (was_kept, pieces.last_mut()) {
                piece.extend(crossing);
            }
            if let (true, Some(piece)) = (is_kept, pieces.last_mut()) {
                piece.push(p);
            }
            last = Some((p, height));
        }
        pieces
    }

    /// Half space in the frame of a body.
    fn on_body(&self, pose: &Pose) -> Self {
        let back = |v: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|axis| (0..3).map(|i| pose.r_world_from_body[i][axis] * v[i]).sum())
        };
        let Plane { origin, u, v } = self.plane;
        let plane = Plane { origin: back(sub3(origin, pose.origin)), u: back(u), v: back(v) };
        Self { plane, normal: back(self.normal), slack: self.slack }
    }
}

impl Scene {
    /// The half of space that a picture shows, for a unit vector to the eye: all of it if none. A planar mechanism
    /// is not cut.
    pub fn half(&self, section: Option<Section>, eye: [f64; 3]) -> Option<HalfSpace> {
        let section = section.filter(|_| !self.is_planar)?;
        Some(section.kept(eye, SLACK * self.pin))
    }

    /// The part of the mechanism in a half of space, with its bodies at these poses. Solids, areas and lines are
    /// cut; signs are left out whose middle is. Where the plane faces `eye`, a unit vector, solids have
    /// [cut faces](Form::Section). Springs, ropes and the like become lines of the ground.
    #[must_use]
    pub fn cut(&self, half: &HalfSpace, poses: &[Pose], eye: [f64; 3]) -> Self {
        let has_faces = dot3(half.normal, eye) > 0.0;
        let mut shapes = Vec::new();
        for shape in &self.shapes {
            let Some(pose) = poses.get(shape.body) else { continue };
            let half = half.on_body(pose);
            let hatched = has_faces.then(|| Hatching::of_body(shape.body, self.pin));
            let forms = cut_form(shape, &half, hatched);
            shapes.extend(forms.into_iter().map(|form| Shape { form, ..*shape }));
        }
        for (role, points) in self.stretched(poses, eye).into_iter().flat_map(|it| it.lines) {
            let line = |points| Form::Line { points, is_closed: false };
            let pieces = half.pieces(&points).into_iter();
            shapes.extend(pieces.map(|points| Shape { body: 0, role, form: line(points) }));
        }
        Self { shapes, ..self.without_drawing() }
    }

    /// The scene without shapes, and without all that is stretched between bodies.
    #[must_use]
    pub fn without_drawing(&self) -> Self {
        Self {
            is_planar: self.is_planar,
            bodies: self.bodies.clone(),
            markers: self.markers.clone(),
            pin: self.pin,
            shapes: Vec::new(),
            spans: Vec::new(),
            cords: Vec::new(),
            turns: Vec::new(),
        }
    }
}

/// The forms that are left of a shape in a half of the space of its body.
fn cut_form(shape: &Shape, half: &HalfSpace, hatched: Option<Hatching>) -> Vec<Form> {
    if shape.role.is_in_front() && !shape.role.is_curve() {
        let points = shape.form.reach();
        let middle = points.iter().map(|&p| half.height(p)).sum::<f64>() / points.len() as f64;
        return if middle <= 0.0 { vec![shape.form.clone()] } else { Vec::new() };
    }
    match &shape.form {
        Form::Line { points, is_closed } => cut_line(points, *is_closed, half),
        Form::Region(rings) => {
            let rings = cut_region(rings, half);
            if rings.is_empty() { Vec::new() } else { vec![Form::Region(rings)] }
        }
        Form::Rod { ends, radius } => {
            let [low, high] = ends.map(|end| half.height(end));
            let (low, high) = (low.min(high), low.max(high));
            if high <= -radius {
                vec![shape.form.clone()]
            } else if low < *radius {
                cut_solid(&faceted(*ends, *radius), half, hatched)
            } else {
                Vec::new()
            }
        }
        Form::Solid(solid) => cut_solid(solid, half, hatched),
        Form::Section { .. } => vec![shape.form.clone()],
    }
}

/// The pieces of a line.
fn cut_line(points: &[[f64; 3]], is_closed: bool, half: &HalfSpace) -> Vec<Form> {
    if points.iter().all(|&p| half.height(p) <= 0.0) {
        return vec![Form::Line { points: points.to_vec(), is_closed }];
    }
    // A closed line is passed through from a point that is left out.
    let first = points.iter().position(|&p| half.height(p) > 0.0).filter(|_| is_closed);
    let turned: Vec<[f64; 3]> = match first {
        Some(first) => [&points[first..], &points[..=first]].concat(),
        None => points.to_vec(),
    };
    let line = |points| Form::Line { points, is_closed: false };
    half.pieces(&turned).into_iter().map(line).collect()
}

/// The rings of a plane area.
fn cut_region(rings: &[Vec<[f64; 3]>], half: &HalfSpace) -> Vec<Vec<[f64; 3]>> {
    let mut cutter = Cutter::new(half, rings.concat());
    let mut first = 0;
    let corners: Vec<Vec<usize>> = rings
        .iter()
        .map(|ring| {
            first += ring.len();
            (first - ring.len()..first).collect()
        })
        .collect();
    // The largest ring tells the plane of the area best.
    let normals = rings.iter().map(|ring| crate::solid::normal(ring.iter().copied()));
    let normal = normals.max_by(|a, b| dot3(*a, *a).total_cmp(&dot3(*b, *b))).unwrap_or_default();
    let area = cutter.area(&corners, normal);
    let ring = |ring: &Vec<usize>| ring.iter().map(|&corner| cutter.corners[corner]).collect();
    area.rings.iter().map(ring).collect()
}

/// The part of a solid that is left, and its cut face, if that is seen.
fn cut_solid(solid: &Solid, half: &HalfSpace, hatched: Option<Hatching>) -> Vec<Form> {
    match cut(solid, half) {
        Cut::Whole => vec![Form::Solid(solid.clone())],
        Cut::Gone => Vec::new(),
        Cut::Part { solid, rings } => {
            let face = hatched.filter(|_| !rings.is_empty()).map(|hatched| Form::Section {
                hatching: hatching(&rings, &half.plane, &hatched),
                rings,
            });
            std::iter::once(Form::Solid(solid)).chain(face).collect()
        }
    }
}
