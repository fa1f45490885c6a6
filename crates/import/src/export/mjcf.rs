//! A robot as MJCF: bodies within bodies, several joints on one, loops as equalities between sites.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use bksim_model::MotionKind;

use crate::draft::number;
use crate::shapes::Solid;
use crate::spatial::{Pose, Rotation, Vector, add, principal_moments, scale};

use super::parts::{Axis, Connection, Report, Robot};
use super::{Xml, escaped, numbers};

/// Distance between the two points by which a loop is held about an axis, m.
const ARM: f64 = 0.1;

/// Moment of inertia that stands for none, kg m².
const LEAST_MOMENT: f64 = 1e-12;

/// Beyond any range.
const NO_LIMIT: f64 = 1e15;

struct Writer<'r> {
    robot: &'r Robot,
    xml: Xml,
    /// Joints on the body of a link, those of links without mass before it among them.
    joints: Vec<Vec<usize>>,
    /// Links in a link.
    within: Vec<Vec<usize>>,
    /// Sites of a link.
    sites: BTreeMap<usize, Vec<(String, Vector, Rotation)>>,
    equalities: Vec<String>,
}

/// The text of the file.
pub(super) fn text(robot: &Robot, report: &mut Report) -> String {
    let none = vec![Vec::new(); robot.links.len()];
    let mut writer = Writer {
        robot,
        xml: Xml::default(),
        joints: none.clone(),
        within: none,
        sites: BTreeMap::new(),
        equalities: Vec::new(),
    };
    writer.loops();
    writer.tree(report);
    writer.xml.open(&format!("mujoco model=\"{}\"", escaped(&robot.name)));
    writer.xml.leaf("compiler angle=\"radian\" autolimits=\"true\" inertiafromgeom=\"false\"");
    let gravity = numbers(&robot.gravity);
    writer.xml.leaf(&format!("option gravity=\"{gravity}\""));
    writer.xml.open("worldbody");
    writer.contents(0);
    // Bodies from the outermost to the innermost: each opens after those before it at its level are closed.
    let mut open: Vec<(usize, usize)> = vec![(0, 0)];
    while let Some((link, next)) = open.last_mut() {
        if let Some(&child) = writer.within[*link].get(*next) {
            let parent = *link;
            *next += 1;
            writer.body(parent, child);
            open.push((child, 0));
        } else {
            open.pop();
            writer.xml.close(if open.is_empty() { "worldbody" } else { "body" });
        }
    }
    writer.rest();
    writer.xml.close("mujoco");
    writer.xml.text
}

impl Writer<'_> {
    /// Loops as equalities between sites, relations, and springs between sites.
    fn loops(&mut self) {
        let robot = self.robot;
        for closing in robot.connections.iter().filter(|connection| connection.is_loop) {
            let name = &closing.name;
            if closing.word == "weld" {
                self.hold(closing, (name, "weld"), closing.center);
                continue;
            }
            let axis =
                closing.axes.first().filter(|_| closing.word == "revolute" && !robot.is_planar);
            match axis {
                Some(axis) => {
                    let arm = scale(ARM / 2.0, axis.along);
                    self.hold(closing, (&format!("{name}_1"), "connect"), add(closing.center, arm));
                    let other = add(closing.center, scale(-1.0, arm));
                    self.hold(closing, (&format!("{name}_2"), "connect"), other);
                }
                None => self.hold(closing, (name, "connect"), closing.center),
            }
        }
        for tendon in &robot.tendons {
            for ((link, at), end) in tendon.ends.iter().zip(["a", "b"]) {
                let site = (format!("{}_{end}", tendon.name), *at, Rotation::NONE);
                self.sites.entry(*link).or_default().push(site);
            }
        }
    }

    /// Holds two links together at a place; a weld has the axes of the world there.
    fn hold(&mut self, closing: &Connection, (name, kind): (&str, &str), at: Vector) {
        for (link, end) in [(closing.parent, "a"), (closing.child, "b")] {
            let there = self.robot.links[link].pose.inverse().then(Pose::at(at));
            let turn = if kind == "weld" { there.turn } else { Rotation::NONE };
            let site = (format!("{name}_{end}"), there.at, turn);
            self.sites.entry(link).or_default().push(site);
        }
        self.equalities
            .push(format!("{kind} name=\"{name}\" site1=\"{name}_a\" site2=\"{name}_b\""));
    }

    /// Links within links; one without mass and with one link on it lends its joints to that one.
    fn tree(&mut self, report: &mut Report) {
        let links = &self.robot.links;
        let mut parents: Vec<usize> = vec![0; links.len()];
        let mut children = vec![0_usize; links.len()];
        for &link in &self.robot.order {
            let Some(carrier) = links[link].carrier else { continue };
            let connection = &self.robot.connections[carrier];
            parents[link] = connection.parent;
            children[connection.parent] += 1;
            self.joints[link] = vec![carrier];
        }
        for &link in &self.robot.order {
            let parent = parents[link];
            let of = &links[parent];
            let is_between = parent != 0
                && of.is_massless()
                && of.shapes.is_empty()
                && children[parent] == 1
                && !self.sites.contains_key(&parent);
            let is_free = |idx: &usize| self.robot.connections[*idx].word == "free";
            if is_between && !self.joints[parent].iter().chain(&self.joints[link]).any(is_free) {
                let mut joints = std::mem::take(&mut self.joints[parent]);
                joints.append(&mut self.joints[link]);
                self.joints[link] = joints;
                parents[link] = parents[parent];
                self.within[parents[parent]].retain(|known| *known != parent);
            } else if parent != 0 && of.is_massless() {
                self.robot.warn_of_inertia(parent, report);
            }
            self.within[parents[link]].push(link);
            if !links[link].is_massless() || children[link] == 0 {
                self.robot.warn_of_inertia(link, report);
            }
        }
    }

    fn body(&mut self, parent: usize, link: usize) {
        let robot = self.robot;
        let of = &robot.links[link];
        let pose = robot.links[parent].pose.inverse().then(of.pose);
        let place = format!("pos=\"{}\"{}", numbers(&pose.at), quaternion("quat", pose.turn));
        self.xml.open(&format!("body name=\"{}\" {place}", of.name));
        if !of.is_massless() {
            let [xx, yy, zz, xy, yz, zx] = of.inertia.tensor;
            // MuJoCo takes no moving body without inertia: a point mass and a line get the least that counts.
            let is_point = principal_moments(of.inertia.tensor)[0].abs() < LEAST_MOMENT;
            let more = if is_point { LEAST_MOMENT } else { 0.0 };
            let inertia = numbers(&[xx + more, yy + more, zz + more, xy, zx, yz]);
            self.xml.leaf(&format!(
                "inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{inertia}\"",
                numbers(&of.inertia.com),
                number(of.inertia.mass)
            ));
        }
        for idx in self.joints[link].clone() {
            self.joint(&robot.connections[idx], parent, link);
        }
        self.contents(link);
    }

    fn joint(&mut self, connection: &Connection, parent: usize, link: usize) {
        let name = &connection.name;
        if connection.word == "free" && parent == 0 {
            return self.xml.leaf(&format!("freejoint name=\"{name}\""));
        }
        let into = self.robot.links[link].pose.inverse();
        let at = numbers(&into.apply(connection.center));
        let ball = format!("joint name=\"{name}{{}}\" type=\"ball\" pos=\"{at}\"");
        let has_many = !connection.axes.is_empty();
        let named = ball.replace("{}", if has_many { "_ball" } else { "" });
        let is_reversed =
            connection.axes.first().is_some_and(|axis| axis.kind == MotionKind::Translation)
                || !connection.has_ball;
        if connection.has_ball && !is_reversed {
            self.xml.leaf(&named);
        }
        for axis in &connection.axes {
            let along = numbers(&into.turn.apply(axis.along));
            let kind = if axis.kind == MotionKind::Rotation { "hinge" } else { "slide" };
            let attributes = acting(axis);
            self.xml.leaf(&format!(
                "joint name=\"{}\" type=\"{kind}\" pos=\"{at}\" axis=\"{along}\"{attributes}",
                axis.name
            ));
        }
        if connection.has_ball && is_reversed {
            self.xml.leaf(&named);
        }
        if let (Some(lead), Some(axis)) = (connection.lead, connection.axes.first()) {
            let along = numbers(&into.turn.apply(axis.along));
            let slide = format!("{name}_slide");
            self.xml.leaf(&format!(
                "joint name=\"{slide}\" type=\"slide\" pos=\"{at}\" axis=\"{along}\""
            ));
            let pitch = number(lead / std::f64::consts::TAU);
            self.equalities.push(format!(
                "joint name=\"{name}_thread\" joint1=\"{slide}\" joint2=\"{name}\" polycoef=\"0 {pitch} 0 0 0\""
            ));
        }
    }

    /// Shapes and sites of a link.
    fn contents(&mut self, link: usize) {
        for (solid, pose) in &self.robot.links[link].shapes {
            let (kind, size) = match *solid {
                Solid::Box { half } => ("box", numbers(&half)),
                Solid::Cylinder { radius, half } => ("cylinder", numbers(&[radius, half])),
                Solid::Sphere { radius } => ("sphere", number(radius)),
                Solid::Capsule { .. } | Solid::Ellipsoid { .. } => continue,
            };
            let place = format!("pos=\"{}\"{}", numbers(&pose.at), quaternion("quat", pose.turn));
            self.xml.leaf(&format!(
                "geom type=\"{kind}\" size=\"{size}\" {place} mass=\"0\" contype=\"0\" conaffinity=\"0\""
            ));
        }
        for (name, at, turn) in self.sites.get(&link).into_iter().flatten() {
            let place = format!("pos=\"{}\"{}", numbers(at), quaternion("quat", *turn));
            self.xml.leaf(&format!("site name=\"{name}\" {place}"));
        }
    }

    /// Equalities, springs between sites, motors.
    fn rest(&mut self) {
        let robot = self.robot;
        let at = |name: &str| {
            let mut axes = robot.connections.iter().flat_map(|connection| &connection.axes);
            axes.find(|axis| axis.name == name).map_or(0.0, |axis| axis.at)
        };
        for mimic in &robot.mimics {
            let by = mimic.by.as_deref();
            let shifted = mimic.about([at(&mimic.of), by.map_or(0.0, at)]);
            let second = by.map_or(String::new(), |by| format!(" joint2=\"{by}\""));
            self.equalities.push(format!(
                "joint name=\"{}\" joint1=\"{}\"{second} polycoef=\"{}\"",
                mimic.name,
                mimic.of,
                shifted.map(number).join(" ")
            ));
        }
        let equalities = std::mem::take(&mut self.equalities);
        self.section("equality", &equalities);
        if !robot.tendons.is_empty() {
            self.xml.open("tendon");
            for tendon in &robot.tendons {
                let name = &tendon.name;
                self.xml.open(&format!(
                    "spatial name=\"{name}\" stiffness=\"{}\" springlength=\"{}\" damping=\"{}\"",
                    number(tendon.stiffness),
                    number(tendon.length),
                    number(tendon.damping)
                ));
                for end in ["a", "b"] {
                    self.xml.leaf(&format!("site site=\"{name}_{end}\""));
                }
                self.xml.close("spatial");
            }
            self.xml.close("tendon");
        }
        let motors = robot.motors.iter().map(|motor| {
            let gear = number(motor.gear);
            format!("motor name=\"{}\" joint=\"{}\" gear=\"{gear}\"", motor.name, motor.on)
        });
        self.section("actuator", &motors.collect::<Vec<_>>());
    }

    fn section(&mut self, name: &str, elements: &[String]) {
        if elements.is_empty() {
            return;
        }
        self.xml.open(name);
        for element in elements {
            self.xml.leaf(element);
        }
        self.xml.close(name);
    }
}

/// Attributes of a motion: its springs, limits, friction and rotor.
fn acting(axis: &Axis) -> String {
    let mut text = String::new();
    let mut put = |key: &str, value: f64| {
        if value != 0.0 {
            let _ = write!(text, " {key}=\"{}\"", number(value));
        }
    };
    put("ref", axis.at);
    put("stiffness", axis.stiffness);
    put("springref", axis.rest);
    put("damping", axis.damping);
    put("frictionloss", axis.friction);
    put("armature", axis.armature);
    if let Some([min, max]) = axis.limits {
        let range = [min.unwrap_or(-NO_LIMIT), max.unwrap_or(NO_LIMIT)];
        let _ = write!(text, " range=\"{}\"", range.map(number).join(" "));
    }
    text
}

/// An attribute of a rotation; nothing for none.
fn quaternion(key: &str, turn: Rotation) -> String {
    if turn.is_none() { String::new() } else { format!(" {key}=\"{}\"", numbers(&turn.0)) }
}
