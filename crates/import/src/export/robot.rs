//! [`Robot`]: a model as links and joints with numbers, in world axes where its reference pose has them.

use bksim_model::diagnostic::{Diagnostic, Rejected, Span};
use bksim_model::{Anchor, FixedTurn, Joint, JointKind, LoadKind, Model, MotionKind, SolidForm};

use crate::Format;
use crate::codes;
use crate::shapes::Solid;
use crate::spatial::{Inertia, Pose, Rotation, Vector, cross, dot, of_point, scale, sub, unit};

use super::loads::{Mimic, Motor, Tendon};
use super::tree::tree;

/// A body; the ground is the first.
pub(super) struct Link {
    pub(super) name: String,
    pub(super) inertia: Inertia,
    /// Place of its frame in the world.
    pub(super) pose: Pose,
    pub(super) shapes: Vec<(Solid, Pose)>,
    /// The connection that carries it in the tree.
    pub(super) carrier: Option<usize>,
}

impl Link {
    pub(super) fn is_massless(&self) -> bool {
        self.inertia.mass == 0.0 && self.inertia.tensor == [0.0; 6]
    }
}

/// One motion of a joint, and what acts in it.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) name: String,
    pub(super) kind: MotionKind,
    /// Unit vector in world axes, so that the child moves against the parent by the joint's coordinate.
    pub(super) along: Vector,
    /// Coordinate in the reference pose.
    pub(super) at: f64,
    pub(super) limits: Option<[Option<f64>; 2]>,
    pub(super) stiffness: f64,
    /// Coordinate at which the spring is at rest.
    pub(super) rest: f64,
    pub(super) damping: f64,
    pub(super) friction: f64,
    pub(super) armature: f64,
}

/// A joint between two links.
pub(super) struct Connection {
    /// Index of the joint in the model; `None` of a body that nothing holds.
    pub(super) joint: Option<usize>,
    pub(super) name: String,
    /// Word of the joint's type.
    pub(super) word: &'static str,
    pub(super) parent: usize,
    pub(super) child: usize,
    /// Joint point, world axes.
    pub(super) center: Vector,
    /// Motions in their order, those of a ball left out.
    pub(super) axes: Vec<Axis>,
    /// True if it turns as it likes after them.
    pub(super) has_ball: bool,
    /// Translation that goes with one turn, m.
    pub(super) lead: Option<f64>,
    pub(super) is_loop: bool,
    pub(super) span: Span,
}

/// Warnings and parts that are left out.
#[derive(Default)]
pub(super) struct Report {
    pub(super) faults: Vec<Diagnostic>,
    pub(super) left_out: Vec<(String, Span)>,
}

impl Report {
    pub(super) fn leave_out(&mut self, what: String, span: &Span) {
        self.left_out.push((what, span.clone()));
    }
}

/// A model on its way to another format.
pub(super) struct Robot {
    pub(super) name: String,
    pub(super) notes: Vec<String>,
    pub(super) links: Vec<Link>,
    pub(super) connections: Vec<Connection>,
    /// Links but the ground, parents first.
    pub(super) order: Vec<usize>,
    pub(super) is_planar: bool,
    pub(super) gravity: Vector,
    pub(super) mimics: Vec<Mimic>,
    pub(super) motors: Vec<Motor>,
    pub(super) tendons: Vec<Tendon>,
}

/// Numbers of a model.
pub(super) struct Numbers<'m>(pub(super) &'m Model);

impl Numbers<'_> {
    /// The value of an expression that depends on parameters alone.
    pub(super) fn value(&self, e: bksim_expr::Expr) -> Option<f64> {
        let of = |symbol| {
            let known = self.0.parameters.iter().find(|parameter| parameter.symbol == symbol);
            known.map(|parameter| parameter.value)
        };
        self.0.pool.evaluate(e, &of).ok().filter(|value| value.is_finite())
    }

    pub(super) fn vector(&self, vector: bksim_model::Vector) -> Option<Vector> {
        let [x, y, z] = vector.map(|part| self.value(part));
        Some([x?, y?, z?])
    }

    fn turned(&self, turns: &[FixedTurn]) -> Option<Rotation> {
        turns.iter().try_fold(Rotation::NONE, |turned, turn| {
            Some(turned.then(Rotation::about(self.vector(turn.axis)?, self.value(turn.angle)?)))
        })
    }

    /// The frame of an anchor in its body.
    pub(super) fn frame(&self, anchor: Anchor) -> Option<Pose> {
        let Some(point) = anchor.point else { return Some(Pose::NONE) };
        let point = &self.0.bodies[anchor.body.0].points[point.0];
        Some(Pose { at: self.vector(point.position)?, turn: self.turned(&point.orientation)? })
    }

    /// The frames of a joint in both bodies, equal where all its motions are zero.
    fn frames(&self, joint: &Joint) -> Option<[Pose; 2]> {
        let fixed = match joint.kind {
            JointKind::Prismatic { angle } | JointKind::Weld { angle } => {
                Rotation::about([0.0, 0.0, 1.0], self.value(angle)?)
            }
            _ => Rotation::NONE,
        };
        let first = self.frame(joint.predecessor)?;
        let second = self.frame(joint.successor)?;
        let aligned = second.turn.then(self.turned(&joint.alignment)?);
        let first = Pose { turn: first.turn.then(fixed), ..first };
        Some([first, Pose { turn: aligned, ..second }])
    }

    /// Inertia about the centre of mass; a flat body has its two other moments as a plate has them.
    fn inertia(&self, body: usize, is_planar: bool) -> Option<Inertia> {
        let body = &self.0.bodies[body];
        let (mass, com) = (self.value(body.mass)?, self.vector(body.com)?);
        let [[xx, yy, zz], [xy, yz, zx]] =
            [self.vector(body.inertia.moments)?, self.vector(body.inertia.products)?];
        let mut tensor = [xx, yy, zz, xy, yz, zx];
        if let Some(point) = body.inertia.about {
            let arm = sub(self.vector(body.points[point.0].position)?, com);
            let moved = of_point(mass, arm);
            tensor.iter_mut().zip(moved).for_each(|(entry, moved)| *entry -= moved);
        }
        if is_planar {
            tensor = [tensor[2] / 2.0, tensor[2] / 2.0, tensor[2], 0.0, 0.0, 0.0];
        }
        Some(Inertia { mass, com, tensor })
    }

    fn shapes(&self, body: usize, report: &mut Report) -> Vec<(Solid, Pose)> {
        let body = &self.0.bodies[body];
        let mut shapes = Vec::new();
        for solid in &body.solids {
            let form = match &solid.form {
                SolidForm::Box(size) => {
                    self.vector(*size).map(|size| Solid::Box { half: size.map(|side| side / 2.0) })
                }
                SolidForm::Cylinder { radius, length } => self
                    .value(*radius)
                    .zip(self.value(*length))
                    .map(|(radius, length)| Solid::Cylinder { radius, half: length / 2.0 }),
                SolidForm::Sphere(radius) => {
                    self.value(*radius).map(|radius| Solid::Sphere { radius })
                }
                SolidForm::Plate { .. } | SolidForm::Mesh(_) => None,
            };
            let place = self.vector(solid.position).zip(self.turned(&solid.orientation));
            match form.zip(place) {
                Some((form, (at, turn))) => shapes.push((form, Pose { at, turn })),
                None => report.leave_out(format!("a shape of body {}", body.name), &body.span),
            }
        }
        shapes
    }
}

impl Robot {
    /// Numbers and the tree of a model; `start` are poses that close its loops.
    pub(super) fn of(
        model: &Model,
        format: Format,
        start: &[Pose],
    ) -> Result<(Self, Report), Rejected> {
        let numbers = Numbers(model);
        let mut report = Report::default();
        let is_planar = model.space == bksim_model::Space::Planar;
        let unread = |what: String, span: &Span| {
            let message = format!("{what} depends on time or on the motion");
            let fault = Diagnostic::error(codes::NOT_HELD, message).at(span.clone(), "");
            Rejected(vec![
                fault.help("give it a value of parameters alone: robot files hold numbers"),
            ])
        };
        let mut links = Vec::new();
        for (idx, body) in model.bodies.iter().enumerate() {
            let inertia = numbers.inertia(idx, is_planar);
            let inertia = inertia
                .ok_or_else(|| unread(format!("the inertia of `{}`", body.name), &body.span))?;
            let name = if body.name == "world" { "world_link" } else { &body.name };
            if body.flexible.is_some() {
                report.leave_out(format!("bending of body {}", body.name), &body.span);
            }
            let shapes = numbers.shapes(idx, &mut report);
            let (name, pose) = (name.to_owned(), start[idx]);
            links.push(Link { name, inertia, pose, shapes, carrier: None });
        }
        "world".clone_into(&mut links[0].name);
        let (order, connections) = tree(model, format, &mut links, &mut report)?;
        let mut robot = Self {
            name: model.name.clone(),
            notes: Vec::new(),
            links,
            connections,
            order,
            is_planar,
            gravity: [0.0; 3],
            mimics: Vec::new(),
            motors: Vec::new(),
            tendons: Vec::new(),
        };
        let has_loops = robot.connections.iter().any(|connection| connection.is_loop);
        robot.place(&numbers, has_loops)?;
        if has_loops && format == Format::Sdf {
            let note = "Bodies are where the loops of the start are closed: all coordinates are zero there.";
            robot.notes.push(note.to_owned());
        }
        for load in &model.loads {
            if let LoadKind::Gravity { acceleration } = load.kind
                && let Some(acceleration) = numbers.vector(acceleration)
            {
                robot.gravity = acceleration;
            }
        }
        robot.add_loads(model, format, &mut report);
        Ok((robot, report))
    }

    /// Puts the links to the reference pose, and the motions of joints into the world there.
    fn place(&mut self, numbers: &Numbers<'_>, has_loops: bool) -> Result<(), Rejected> {
        let joints = &numbers.0.joints;
        let unread = |joint: &Joint| {
            let message =
                format!("the frame of joint `{}` depends on time or on the motion", joint.name);
            let fault = Diagnostic::error(codes::NOT_HELD, message).at(joint.span.clone(), "");
            Rejected(vec![
                fault.help("give it a value of parameters alone: robot files hold numbers"),
            ])
        };
        if !has_loops {
            for &link in &self.order {
                let Some(connection) = self.links[link].carrier.map(|idx| &self.connections[idx])
                else {
                    continue;
                };
                let Some(joint) = connection.joint.map(|joint| &joints[joint]) else { continue };
                if matches!(joint.kind, JointKind::Free) {
                    continue;
                }
                let [first, second] = numbers.frames(joint).ok_or_else(|| unread(joint))?;
                let is_reversed = joint.predecessor.body.0 == link;
                let (near, far) = if is_reversed { (second, first) } else { (first, second) };
                let parent = self.links[connection.parent].pose;
                self.links[link].pose = parent.then(near).then(far.inverse());
            }
        }
        for idx in 0..self.connections.len() {
            let Some(joint) = self.connections[idx].joint.map(|joint| &joints[joint]) else {
                continue;
            };
            let frames = numbers.frames(joint).ok_or_else(|| unread(joint))?;
            let ends = [joint.predecessor.body.0, joint.successor.body.0];
            let [first, second] = [0, 1].map(|end| self.links[ends[end]].pose.then(frames[end]));
            let stated = numbers.frame(joint.predecessor).ok_or_else(|| unread(joint))?;
            let stated = self.links[ends[0]].pose.then(stated);
            let mut axes =
                axes(numbers, joint, [first, second], stated.turn).ok_or_else(|| unread(joint))?;
            let connection = &mut self.connections[idx];
            connection.center = second.at;
            if connection.child == ends[0] {
                // Passed from the successor: the same motions in the other order and direction.
                axes.reverse();
                for axis in &mut axes {
                    axis.along = scale(-1.0, axis.along);
                }
            }
            connection.axes = axes;
        }
        Ok(())
    }

    /// Warns of a body that programs refuse for its inertia or, where it moves, for its mass.
    pub(super) fn warn_of_inertia(&self, link: usize, report: &mut Report) {
        let of = &self.links[link];
        let Some(carrier) = of.carrier.map(|idx| &self.connections[idx]) else { return };
        let is_empty = of.inertia.mass == 0.0 && carrier.word != "weld";
        let why = if is_empty { Some("it has no mass") } else { of.inertia.fault() };
        let Some(why) = why else { return };
        let message = format!("programs that read the file refuse body `{}`: {why}", of.name);
        let help = "give the body a mass and an inertia that bodies have";
        let fault = Diagnostic::warning(codes::REFUSED_BODY, message);
        let fault = fault.at(carrier.span.clone(), "carried by this joint").help(help);
        if !report.faults.contains(&fault) {
            report.faults.push(fault);
        }
    }

    /// The motion of a joint of the model.
    pub(super) fn axis_mut(&mut self, joint: usize, name: &str) -> Option<&mut Axis> {
        let connection = self.connections.iter_mut().find(|of| of.joint == Some(joint))?;
        connection.axes.iter_mut().find(|axis| axis.name == name)
    }
}

/// The motions of a joint: directions and values in the reference pose; `None` where they are no numbers.
///
/// Translations are in the frame of the predecessor, turned by `stated`, rotations after them.
fn axes(
    numbers: &Numbers<'_>,
    joint: &Joint,
    [first, second]: [Pose; 2],
    stated: Rotation,
) -> Option<Vec<Axis>> {
    let own = numbers.vector(joint.axis)?;
    let armature = numbers.value(joint.armature)?;
    let z = [0.0, 0.0, 1.0];
    let relative = first.turn.inverse().then(second.turn);
    let about = |axis: Vector| {
        let [w, x, y, z] = relative.0;
        let turned = 2.0 * dot([x, y, z], axis).atan2(w);
        let turn = std::f64::consts::TAU;
        turned - turn * (turned / turn).round()
    };
    let offset = sub(second.at, first.at);
    let slide = |axis: Vector| {
        let along = stated.apply(axis);
        (MotionKind::Translation, along, dot(offset, along))
    };
    let turn = |axis: Vector| (MotionKind::Rotation, first.turn.apply(axis), about(axis));
    // Two directions across the axis: z × n and n × (z × n), or x and y.
    let e1 = unit([-own[1], own[0], 0.0]).unwrap_or([1.0, 0.0, 0.0]);
    let rows = match joint.kind {
        JointKind::Revolute | JointKind::Screw { .. } => vec![turn(own)],
        JointKind::Prismatic { .. } | JointKind::PointOnLine => vec![slide(own)],
        JointKind::PinInSlot => vec![slide(own), turn(z)],
        JointKind::Cylindrical => vec![slide(own), turn(own)],
        JointKind::Planar => vec![slide(e1), slide(cross(own, e1)), turn(own)],
        JointKind::PointOnPlane => vec![slide(e1), slide(cross(own, e1))],
        JointKind::Universal { second: arm } => {
            let arm = numbers.vector(arm)?;
            // The first turn takes the second axis to where the successor has it, the second one then acts about it.
            let there = relative.apply(arm);
            let first_turn = dot(cross(arm, there), own).atan2(dot(arm, there));
            let rest = Rotation::about(own, -first_turn).then(relative).0;
            let second_turn = 2.0 * dot([rest[1], rest[2], rest[3]], arm).atan2(rest[0]);
            vec![
                (MotionKind::Rotation, first.turn.apply(own), first_turn),
                (MotionKind::Rotation, second.turn.apply(arm), second_turn),
            ]
        }
        _ => Vec::new(),
    };
    let is_single = rows.len() == 1 && joint.kind.motions().len() == 1;
    let of = |(idx, (kind, along, at)): (usize, (MotionKind, Vector, f64))| Axis {
        name: axis_name(joint, is_single, idx),
        kind,
        along,
        at: if at.abs() < 1e-14 { 0.0 } else { at },
        limits: None,
        stiffness: 0.0,
        rest: 0.0,
        damping: 0.0,
        friction: 0.0,
        armature,
    };
    Some(rows.into_iter().enumerate().map(of).collect())
}

/// Name of a motion: that of its joint, or that of one of several coordinates.
pub(super) fn axis_name(joint: &Joint, is_single: bool, motion_idx: usize) -> String {
    if is_single { joint.name.clone() } else { joint.coordinate_name(motion_idx) }
}
