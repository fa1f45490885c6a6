//! Velocity and acceleration polygons of a planar mechanism in one pose, as the textbook draws them.
//!
//! ```text
//! one body     v_P = v_O + ω × r        a_P = a_O + (−ω² r) + α × r         normal, then tangential
//! slid along   v_Q = v_P + v_rel        a_Q = a_P + 2 ω × v_rel + a_rel     P of the guide, Q on it, at one place
//! ```
//!
//! Every vector goes from one vertex to another; the pole is at rest. Source: R. L. Norton, *Design of Machinery* (2012),
//! §6.7 and §7.3.

use bksim_model::{Anchor, BodyId, GROUND, Model, Space};

use crate::error::AnalysisError;
use crate::kinematics::{Prescribed, at_first};
use crate::positions::Positions;
use crate::quantity::PoseQuantity;

/// Both polygons of a pose.
#[derive(Clone, PartialEq, Debug)]
pub struct Polygons {
    /// Of velocities, m/s.
    pub velocity: Polygon,
    /// Of accelerations, m/s².
    pub acceleration: Polygon,
    /// Name, angular velocity (rad/s) and angular acceleration (rad/s²) of every body.
    pub bodies: Vec<(String, f64, f64)>,
}

/// Vertices and the vectors between them.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Polygon {
    /// Ends of the absolute vectors of points, from the pole at the origin.
    pub vertices: Vec<Vertex>,
    /// Vectors between the pole, vertices and the corners between them.
    pub vectors: Vec<PolygonVector>,
}

/// A point of the mechanism in a polygon.
#[derive(Clone, PartialEq, Debug)]
pub struct Vertex {
    /// `B` of a joint, `coupler.P` of a point, `B on guide` of the place of a guide under a joint.
    pub name: String,
    /// Velocity or acceleration that the vertex stands for.
    pub at: [f64; 2],
}

/// A vector of a polygon.
#[derive(Clone, PartialEq, Debug)]
pub struct PolygonVector {
    /// Point of the vector, then the point that it is relative to; none for one that is absolute.
    pub of: (String, Option<String>),
    /// Part of the vector.
    pub part: VectorPart,
    /// Where it begins.
    pub from: [f64; 2],
    /// Where it ends.
    pub to: [f64; 2],
}

/// Part of a velocity or acceleration that a vector is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum VectorPart {
    /// All of it.
    Whole,
    /// Towards the centre of rotation.
    Normal,
    /// Across that.
    Tangential,
    /// Of Coriolis.
    Coriolis,
    /// Along a guide.
    Sliding,
}

/// Parts smaller than this part of the largest vector are left out.
const NOTHING: f64 = 1e-9;

/// The polygons of `model` at the first of the prescribed values.
///
/// # Errors
/// [`AnalysisError`] as of [`kinematics`](crate::kinematics()), or for a mechanism in space.
pub fn polygons(model: Model, prescribed: &Prescribed) -> Result<Polygons, AnalysisError> {
    if model.space != Space::Planar {
        return Err(AnalysisError::NotPlanar { what: "polygons" });
    }
    let mut positions = Positions::of(model)?;
    let quantities = body_quantities(&positions);
    positions.quantities = quantities;
    let row = at_first(&positions, prescribed)?;
    let motions = [BodyMotion::default()].into_iter().chain(row.chunks(9).map(BodyMotion::of));
    let moving = Moving { positions: &positions, motions: motions.collect() };
    let places = moving.places();
    let mut found = Polygons {
        velocity: Polygon::default(),
        acceleration: Polygon::default(),
        bodies: moving.angular(),
    };
    let mut known: Vec<String> = Vec::new();
    for place in &places {
        if !known.contains(&place.name) && !moving.is_at_rest(place) {
            known.push(place.name.clone());
            let [velocity, acceleration] = moving.rates(place);
            let vertex = |at| Vertex { name: place.name.clone(), at };
            found.velocity.vertices.push(vertex(velocity));
            found.acceleration.vertices.push(vertex(acceleration));
        }
    }
    for body in 1..moving.motions.len() {
        moving.along_body(BodyId(body), &places, &mut found);
    }
    moving.along_guides(&places, &mut found);
    found.velocity.tidy();
    found.acceleration.tidy();
    Ok(found)
}

/// Origin and angle of the frame of every body.
fn body_quantities(positions: &Positions) -> Vec<PoseQuantity> {
    let model = positions.model();
    let kinematics = &positions.system().kinematics;
    let of_body = |id: usize| {
        let [x, y, _] = kinematics.anchor(model, Anchor { body: BodyId(id), point: None });
        let angle = kinematics.measure(model, bksim_model::Measure::BodyAngle(BodyId(id)));
        [x, y, angle].into_iter().enumerate().map(move |(k, value)| {
            let names = ["", "'", "''"].map(|level| format!("{id}.{k}{level}"));
            PoseQuantity { names, unit: if k == 2 { "rad" } else { "m" }, value }
        })
    };
    (1..model.bodies.len()).flat_map(of_body).collect()
}

/// A body in one pose: values, rates and accelerations of x, y and the angle of its frame.
#[derive(Clone, Copy, Default, Debug)]
struct BodyMotion([[f64; 3]; 3]);

impl BodyMotion {
    fn of(numbers: &[f64]) -> Self {
        Self(std::array::from_fn(|level| std::array::from_fn(|k| numbers[3 * k + level])))
    }

    fn world(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x0, y0, angle] = self.0[0];
        let (sin, cos) = angle.sin_cos();
        [x0 + cos * x - sin * y, y0 + sin * x + cos * y]
    }

    fn rate(&self) -> f64 {
        self.0[1][2]
    }

    fn acceleration(&self) -> f64 {
        self.0[2][2]
    }

    /// Velocity and acceleration of the point of the body that is at `p` in the world.
    fn rates(&self, p: [f64; 2]) -> [[f64; 2]; 2] {
        let [[x, y, _], [vx, vy, w], [ax, ay, a]] = self.0;
        let r = [p[0] - x, p[1] - y];
        [
            [vx - w * r[1], vy + w * r[0]],
            [ax - a * r[1] - w * w * r[0], ay + a * r[0] - w * w * r[1]],
        ]
    }
}

/// A point of a body with a name.
#[derive(Clone, Debug)]
struct Place {
    name: String,
    body: BodyId,
    /// In the world, m.
    p: [f64; 2],
}

/// A mechanism in motion.
struct Moving<'a> {
    positions: &'a Positions,
    motions: Vec<BodyMotion>,
}

impl Moving<'_> {
    /// The points of joints, one on each body, then points that no joint connects.
    fn places(&self) -> Vec<Place> {
        let model = self.positions.model();
        let mut all: Vec<Place> = Vec::new();
        for joint in &model.joints {
            let is_pin = joint.kind.points_coincide();
            // A guide has the point under that of what slides on it.
            let p = self.place(joint.successor);
            for end in [joint.predecessor, joint.successor] {
                let on_guide = !is_pin && end == joint.predecessor;
                let name = if on_guide {
                    format!("{} on {}", joint.name, model.bodies[end.body.0].name)
                } else {
                    joint.name.clone()
                };
                all.push(Place { name, body: end.body, p });
            }
        }
        for (idx, body) in model.bodies.iter().enumerate().skip(1) {
            for (k, point) in body.points.iter().enumerate() {
                let anchor = Anchor { body: BodyId(idx), point: Some(bksim_model::PointId(k)) };
                let p = self.place(anchor);
                let near = 1e-9 * self.positions.size;
                let is_joint = |known: &Place| {
                    known.body.0 == idx && (known.p[0] - p[0]).hypot(known.p[1] - p[1]) < near
                };
                if !all.iter().any(is_joint) {
                    let name = format!("{}.{}", body.name, point.name);
                    all.push(Place { name, body: BodyId(idx), p });
                }
            }
        }
        all
    }

    fn place(&self, anchor: Anchor) -> [f64; 2] {
        let local = anchor.point.map_or([0.0; 2], |point| {
            let [x, y, _] = self.positions.model().bodies[anchor.body.0].points[point.0].position;
            [self.positions.constant(x), self.positions.constant(y)]
        });
        self.motions[anchor.body.0].world(local)
    }

    fn rates(&self, place: &Place) -> [[f64; 2]; 2] {
        self.motions[place.body.0].rates(place.p)
    }

    /// Whether a point belongs to the ground, or is pinned to it.
    fn is_at_rest(&self, place: &Place) -> bool {
        place.body == GROUND || self.pivot(place.body).is_some_and(|pivot| pivot.name == place.name)
    }

    /// The point of a body that is pinned to the ground.
    fn pivot(&self, body: BodyId) -> Option<Place> {
        let mut joints = self.positions.model().joints.iter();
        let joint = joints.find(|joint| {
            let ends = [joint.predecessor.body, joint.successor.body];
            joint.kind.is_pin() && ends.contains(&GROUND) && ends.contains(&body)
        })?;
        Some(Place { name: joint.name.clone(), body, p: self.place(joint.successor) })
    }

    fn angular(&self) -> Vec<(String, f64, f64)> {
        let bodies = self.positions.model().bodies.iter().zip(&self.motions).skip(1);
        bodies.map(|(body, m)| (body.name.clone(), m.rate(), m.acceleration())).collect()
    }

    /// The vectors from one point of a body to its others: from its pivot, else from the first one.
    fn along_body(&self, body: BodyId, places: &[Place], found: &mut Polygons) {
        let own: Vec<&Place> = places.iter().filter(|place| place.body == body).collect();
        let pivot = self.pivot(body);
        let Some(base) = pivot.as_ref().or(own.first().copied()) else { return };
        let motion = &self.motions[body.0];
        let [v0, a0] = motion.rates(base.p);
        let (w, alpha) = (motion.rate(), motion.acceleration());
        let is_pinned = pivot.is_some();
        if !is_pinned {
            self.absolute(base, found);
        }
        for place in own.iter().filter(|place| place.name != base.name) {
            let r = [place.p[0] - base.p[0], place.p[1] - base.p[1]];
            let relative = (!is_pinned).then(|| base.name.clone());
            let of = (place.name.clone(), relative);
            let [v, a] = motion.rates(place.p);
            found.velocity.add(&of, VectorPart::Whole, v0, v);
            let normal = [a0[0] - w * w * r[0], a0[1] - w * w * r[1]];
            let is_turning = alpha != 0.0 || w != 0.0;
            if is_turning {
                found.acceleration.add(&of, VectorPart::Normal, a0, normal);
                found.acceleration.add(&of, VectorPart::Tangential, normal, a);
            }
            if !is_pinned {
                self.absolute(place, found);
            }
        }
    }

    /// The vector of a point from the pole.
    fn absolute(&self, place: &Place, found: &mut Polygons) {
        let [v, a] = self.rates(place);
        let of = (place.name.clone(), None);
        if !found.velocity.vectors.iter().any(|known| known.of == of) {
            found.velocity.add(&of, VectorPart::Whole, [0.0; 2], v);
            found.acceleration.add(&of, VectorPart::Whole, [0.0; 2], a);
        }
    }

    /// Vectors of parts that slide on guides that move.
    fn along_guides(&self, places: &[Place], found: &mut Polygons) {
        let guided = places.iter().filter_map(|guide| {
            let (name, _) = guide.name.split_once(" on ")?;
            let slider = places.iter().find(|place| place.name == name && place.body != guide.body);
            Some((guide, slider?)).filter(|(guide, _)| guide.body != GROUND)
        });
        for (guide, slider) in guided {
            let [v, a] = self.rates(guide);
            let [v1, a1] = self.rates(slider);
            let relative = [v1[0] - v[0], v1[1] - v[1]];
            let w = self.motions[guide.body.0].rate();
            let coriolis = [a[0] - 2.0 * w * relative[1], a[1] + 2.0 * w * relative[0]];
            let of = (slider.name.clone(), Some(guide.name.clone()));
            found.velocity.add(&of, VectorPart::Sliding, v, v1);
            found.acceleration.add(&of, VectorPart::Coriolis, a, coriolis);
            found.acceleration.add(&of, VectorPart::Sliding, coriolis, a1);
        }
    }
}

impl Polygon {
    fn add(
        &mut self,
        of: &(String, Option<String>),
        part: VectorPart,
        from: [f64; 2],
        to: [f64; 2],
    ) {
        self.vectors.push(PolygonVector { of: of.clone(), part, from, to });
    }

    /// Leaves out vectors that are nothing but rounding, and those that are there already.
    fn tidy(&mut self) {
        let long = |v: &PolygonVector| (v.to[0] - v.from[0]).hypot(v.to[1] - v.from[1]);
        let of_vertices = self.vertices.iter().map(|vertex| vertex.at[0].hypot(vertex.at[1]));
        let largest = self.vectors.iter().map(long).chain(of_vertices).fold(0.0, f64::max);
        let nothing = NOTHING * largest;
        self.vectors.retain(|vector| long(vector) > nothing);
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) <= nothing;
        let mut kept: Vec<PolygonVector> = Vec::new();
        for vector in self.vectors.drain(..) {
            let is_known = |known: &PolygonVector| {
                known.of.0 == vector.of.0
                    && near(known.from, vector.from)
                    && near(known.to, vector.to)
            };
            if !kept.iter().any(is_known) {
                kept.push(vector);
            }
        }
        self.vectors = kept;
    }
}
