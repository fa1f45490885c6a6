//! [`Posed`]: a mechanism that is held in a pose, and whose points follow a hand.

use bksim_analysis::{AnalysisError, Drag, DragLimit, Dragged};
use bksim_mbs::coordinate::Owner;
use bksim_model::{Axis, BodyId, GROUND, Joint, Measure, Model};
use bksim_scene::{
    Attached, Camera, Extras, Form, Scene, Theme, TurnTimes, WrittenSolid, picture, svg,
};
use bksim_sim::pose::{Pose, PoseRunner, Poses};
use serde_json::{Value, json};

use crate::view::View;

/// Part of its length to which a spring may be pressed, and multiple to which it may be drawn out, in a picture.
const SPAN: [f64; 2] = [0.25, 4.0];

/// Numbers of a body: origin, rows of the rotation, velocity and angular velocity.
const N_NUMBERS: usize = 18;

/// A mechanism in a pose.
#[derive(Debug)]
pub struct Posed {
    drag: Drag,
    poses: PoseRunner,
    start: Vec<f64>,
}

impl Posed {
    /// A model at its start; masses take no part.
    ///
    /// # Errors
    /// [`AnalysisError`] when it does not close.
    pub fn of(model: Model) -> Result<Self, AnalysisError> {
        let drag = Drag::of(model)?;
        let mechanism = drag.mechanism();
        let poses = Poses::compile(&mechanism.model, &mechanism.system)?;
        let poses = poses.runner(&mechanism.parameters);
        let start = drag.q();
        Ok(Self { drag, poses, start })
    }

    /// The model, its masses left out.
    pub fn model(&self) -> &Model {
        &self.drag.mechanism().model
    }

    /// The coordinates now.
    pub fn q(&self) -> Vec<f64> {
        self.drag.q()
    }

    /// The coordinates of the start.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// Goes back to the start.
    pub fn go_to_start(&mut self) {
        self.drag.set_q(&self.start.clone());
    }

    /// Goes to other coordinates, which satisfy the constraints.
    ///
    /// # Panics
    /// If `q` has not one number for each coordinate.
    pub fn set_q(&mut self, q: &[f64]) {
        self.drag.set_q(q);
    }

    /// Goes to the pose near that of another model with the same coordinates; false where there is none.
    pub fn go_near(&mut self, other: &Self) -> bool {
        let names = |posed: &Self| -> Vec<String> {
            posed.drag.coordinates().iter().map(|c| c.name.clone()).collect()
        };
        names(self) == names(other) && self.drag.go_near(&other.q())
    }

    /// Goes to the pose near coordinates of these names; false where there is none.
    pub fn go_near_named(&mut self, names: &[String], q: &[f64]) -> bool {
        let is_own = self.drag.coordinates().iter().map(|c| &c.name).eq(names);
        is_own && self.drag.go_near(q)
    }

    /// Names and values of the coordinates of the pose.
    pub(crate) fn coordinates(&self) -> Value {
        let names: Vec<&str> = self.drag.coordinates().iter().map(|c| c.name.as_str()).collect();
        json!({ "names": names, "values": self.q() })
    }

    /// The transmission angles of the pose in degrees, by the joints that they are at, but those of bodies that are driven:
    /// what a motor turns needs no transmission.
    pub(crate) fn transmissions(&mut self) -> Value {
        let found = self.drag.transmissions().unwrap_or_default();
        let model = self.model();
        let ends = |joint: &Joint| [joint.predecessor.body, joint.successor.body];
        let driven = model.drives.iter().flat_map(|drive| ends(&model.joints[drive.joint.0]));
        let driven: Vec<BodyId> = driven.filter(|body| *body != GROUND).collect();
        let is_driven = |at: &str| {
            let joint = model.joints.iter().find(|joint| joint.name == at);
            joint.is_some_and(|joint| ends(joint).iter().any(|body| driven.contains(body)))
        };
        let shown = found.iter().filter(|(at, _)| !is_driven(at));
        let row = |(at, angle): &(String, f64)| json!({ "at": at, "degrees": angle.to_degrees() });
        shown.map(row).collect()
    }

    /// The longest link, m.
    pub fn size(&self) -> f64 {
        self.drag.size()
    }

    /// True if all coordinates are motions of joints.
    pub(crate) fn is_of_joints(&self) -> bool {
        self.drag.coordinates().iter().all(|c| matches!(c.owner, Owner::Joint(..)))
    }

    /// The measures of all coordinates; `None` where one of them cannot be stated.
    pub(crate) fn measures(&self) -> Option<Vec<Measure>> {
        self.drag.coordinates().iter().map(|c| position_of(c.owner)).collect()
    }

    /// Takes hold of a point in the frame of a body, m.
    ///
    /// # Errors
    /// [`AnalysisError::Compile`] never comes of a model that was read.
    pub fn grab(&mut self, body: usize, point: [f64; 3]) -> Result<(), AnalysisError> {
        self.drag.grab(BodyId(body.min(self.model().bodies.len() - 1)), point)
    }

    /// Lets go.
    pub fn release(&mut self) {
        self.drag.release();
    }

    /// Pulls the point that is held to a place in the world.
    pub fn to(&mut self, target: [f64; 3]) -> Dragged {
        self.drag.to(target)
    }

    /// Where every body is now, the ground first.
    pub fn bodies(&mut self) -> Vec<Pose> {
        let q = self.q();
        let mut poses = Vec::new();
        self.poses.at(&q, &vec![0.0; q.len()], &mut poses);
        poses
    }

    /// The numbers of [`Posed::bodies`], as a page takes them.
    pub fn numbers(&mut self) -> Vec<f64> {
        numbers(&self.bodies())
    }

    /// The value of a measure of positions now.
    pub(crate) fn value(&self, measure: Measure) -> Option<f64> {
        let mechanism = self.drag.mechanism();
        let (model, system) = (&mechanism.model, &mechanism.system);
        let value = system.kinematics.measure(model, measure);
        let q = self.q();
        let coordinates = system.coordinates().iter().zip(&q);
        let parameters = model.parameters.iter().zip(&mechanism.parameters);
        let known = |symbol| {
            let found = coordinates.clone().find(|(c, _)| c.q == symbol).map(|(_, q)| *q);
            let of_parameter =
                || parameters.clone().find(|(p, _)| p.symbol == symbol).map(|(_, value)| *value);
            found.or_else(of_parameter)
        };
        model.pool.evaluate(value, &known).ok()
    }

    /// Measures that fix the pose as it is, as few as do.
    pub(crate) fn independent(&mut self) -> Vec<Measure> {
        let columns = self.drag.independent();
        let owner = |column: usize| self.drag.coordinates()[column].owner;
        columns.into_iter().filter_map(|column| position_of(owner(column))).collect()
    }

    /// The picture of other poses, 18 numbers for each body, as SVG.
    pub(crate) fn svg(&mut self, numbers: &[f64], view: &View) -> String {
        let n_bodies = self.model().bodies.len();
        let bodies = if numbers.len() == N_NUMBERS * n_bodies {
            numbers.chunks_exact(N_NUMBERS).map(pose_of).collect()
        } else {
            self.bodies()
        };
        let mechanism = self.drag.mechanism();
        let motion = [bodies];
        let scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &motion);
        let View { centre, scale, rows, size, is_dark, has_names } = *view;
        let camera = Camera { centre, scale, r_view_from_world: rows, size };
        let theme = if is_dark { Theme::DARK } else { Theme::LIGHT };
        let extras = Extras { has_labels: has_names, ..Extras::default() };
        let [bodies] = motion;
        svg(&picture(&scene, &bodies, &extras, &camera, &theme))
    }

    /// The shapes as JSON for the script of a page.
    pub fn scene(&mut self) -> Value {
        let bodies = self.bodies();
        let mechanism = self.drag.mechanism();
        let motion = [bodies];
        let scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &motion);
        written(&scene, &motion, &[], &|_| Vec::new())
    }
}

/// A scene as JSON, its springs at lengths about those that they have in some poses, its signs turning over at instants, with
/// the times in which the reaction of a joint is one of many solutions.
pub(crate) fn written(
    scene: &Scene,
    motion: &[Vec<Pose>],
    turned: &[TurnTimes],
    shared: &dyn Fn(usize) -> Vec<[f64; 2]>,
) -> Value {
    let length = |bodies: &[Pose], ends: &[Attached; 2]| {
        let [a, b] = ends.each_ref().map(|at| bodies[at.body].place(at.position));
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    };
    let range = |ends: &[Attached; 2]| {
        let lengths = motion.iter().map(|bodies| length(bodies, ends));
        let (low, high) =
            lengths.fold((f64::INFINITY, 0.0_f64), |(low, high), l| (low.min(l), high.max(l)));
        [low * SPAN[0], high * SPAN[1]]
    };
    let lengths: Vec<[f64; 2]> = scene.spans.iter().map(|span| range(&span.ends)).collect();
    let solids: Vec<Option<WrittenSolid<'_>>> = scene
        .shapes
        .iter()
        .map(|shape| match &shape.form {
            Form::Solid(solid) => Some((solid.corners.as_slice(), solid.faces.as_slice())),
            _ => None,
        })
        .collect();
    scene.written(&solids, &lengths, turned, shared)
}

/// Origin, rows of the rotation, velocity and angular velocity of each body.
pub(crate) fn numbers(bodies: &[Pose]) -> Vec<f64> {
    let of_body = |pose: &Pose| {
        let rotation = pose.r_world_from_body.into_iter().flatten();
        pose.origin.into_iter().chain(rotation).chain(pose.velocity).chain(pose.omega)
    };
    bodies.iter().flat_map(of_body).collect()
}

/// The measure that a coordinate is, where a start can state it.
pub(crate) fn position_of(owner: Owner) -> Option<Measure> {
    Some(match owner {
        Owner::Joint(joint, motion_idx) => Measure::JointPosition(joint, motion_idx),
        Owner::Body(body, 0) => Measure::PointPosition(body, None, Axis::X),
        Owner::Body(body, 1) => Measure::PointPosition(body, None, Axis::Y),
        Owner::Body(body, 2) => Measure::BodyAngle(body),
        _ => return None,
    })
}

/// A body's pose from its numbers.
fn pose_of(numbers: &[f64]) -> Pose {
    let three = |first: usize| std::array::from_fn(|i| numbers[first + i]);
    Pose {
        origin: three(0),
        r_world_from_body: [three(3), three(6), three(9)],
        velocity: three(12),
        omega: three(15),
    }
}

/// The limit of a pull in words.
pub fn limit_words(limit: &DragLimit) -> String {
    match limit {
        DragLimit::Stop(joint) => format!("stop of joint {joint}"),
        DragLimit::DeadPoint => "dead point".to_owned(),
    }
}
