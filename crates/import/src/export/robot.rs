//! A model as links and joints with numbers, in world axes where its reference pose has them.

use bksim_model::diagnostic::{Diagnostic, Rejected, Span};
use bksim_model::{Joint, JointKind, Model, MotionKind};

use crate::Format;
use crate::codes;
use crate::spatial::{Pose, Rotation, Vector, cross, dot, scale, sub, unit};

use super::numbers::Numbers;
use super::parts::{Axis, Link, Report, Robot, axis_name};
use super::tree::tree;

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
        let mut links = Vec::new();
        for (idx, body) in model.bodies.iter().enumerate() {
            let inertia = numbers.inertia(idx, is_planar);
            let inertia = inertia.ok_or_else(|| {
                no_numbers(&format!("the inertia of `{}`", body.name), &body.span)
            })?;
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
            if let Some(acceleration) = load.kind.gravity().and_then(|g| numbers.vector(g)) {
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
            no_numbers(&format!("the frame of joint `{}`", joint.name), &joint.span)
        };
        if !has_loops {
            for &link in &self.order {
                let Some(connection) = self.links[link].carrier.map(|idx| &self.connections[idx])
                else {
                    continue;
                };
                let Some(joint) = connection.joint.map(|joint| &joints[joint]) else { continue };
                if joint.kind.is_free() {
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

/// The fault of what is no number at the values of the parameters.
fn no_numbers(what: &str, span: &Span) -> Rejected {
    let message = format!("{what} depends on time or on the motion");
    let fault = Diagnostic::error(codes::NOT_HELD, message).at(span.clone(), "no number");
    Rejected(vec![fault.help("give it a value of parameters alone: robot files hold numbers")])
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
