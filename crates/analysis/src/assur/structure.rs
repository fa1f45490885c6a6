//! [`Structure`]: rigid parts of a planar linkage with the pins and guides between them.
//!
//! The frame of every part is that of the world in the start, so that a place of a part is its displacement from there,
//! and parts that a guide joins have one angle.

use bksim_mbs::kinematics::Kinematics;
use bksim_model::{BodyId, GROUND, Joint, JointKind, Measure, Model, Space};

use super::place::{Place, dot, left, length, less, turned};
use crate::error::AnalysisError;
use crate::positions::Positions;
use crate::rows::wrapped;
use crate::scalar::Scalars;

/// A joint in the start: its bodies, its point on either, its axis; world axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    pub(super) bodies: [usize; 2],
    pub(super) points: [[f64; 2]; 2],
    pub(super) axis: [f64; 2],
}

/// Bodies and joints in the start.
pub(super) struct Geometry {
    pub(super) bodies: Vec<Place>,
    pub(super) joints: Vec<Ends>,
}

/// A pair between two parts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Pair {
    Pin(usize),
    Slide(usize),
}

/// A point that several parts share.
#[derive(Clone, Debug)]
pub(super) struct Pin {
    /// Parts with their points, each part once.
    pub(super) on: Vec<(usize, [f64; 2])>,
    joint: usize,
}

/// A guide: parts that slide on each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slide {
    pub(super) parts: [usize; 2],
    /// Direction of length one.
    pub(super) axis: [f64; 2],
    joint: usize,
}

/// Parts with their pairs.
pub(super) struct Structure {
    pub(super) n_parts: usize,
    pub(super) part_of_body: Vec<usize>,
    pub(super) pins: Vec<Pin>,
    pub(super) slides: Vec<Slide>,
    /// Parts whose angle is held.
    pub(super) angles: Vec<usize>,
    /// Of each part that is no body the joint that it belongs to.
    joint_of_part: Vec<Option<usize>>,
}

/// A pair of a model's joint before parts are known.
struct LowerPair {
    nodes: [usize; 2],
    points: [[f64; 2]; 2],
    axis: [f64; 2],
    is_pin: bool,
    joint: usize,
    /// The motion that it is, if it is one of the joint's.
    motion: Option<usize>,
}

/// Bodies and joints in the start; none in space.
pub(super) fn geometry(positions: &Positions) -> Result<Option<Geometry>, AnalysisError> {
    let model = positions.model();
    let bends = model.bodies.iter().any(|body| body.flexible.is_some());
    if model.space != Space::Planar || bends || !model.couplings.is_empty() {
        return Ok(None);
    }
    let kinematics = &positions.system().kinematics;
    let mut functions = body_functions(model, kinematics);
    let n_of_bodies = functions.len();
    for joint in &model.joints {
        let sides = kinematics.sides(model, joint);
        let axis = sides.predecessor.rotation.apply(&model.pool, &joint.axis);
        for vector in [sides.p_world_predecessor, sides.p_world_successor, axis] {
            functions.extend([vector[0], vector[1]]);
        }
    }
    let parameters = &positions.mechanism.parameters;
    let values = Scalars::compile(model, positions.system(), &functions, parameters)?
        .values(positions.t(), &positions.q);
    let (bodies, joints) = values.split_at(n_of_bodies);
    let ends = |(joint, v): (&Joint, &[f64])| Ends {
        bodies: [joint.predecessor.body.0, joint.successor.body.0],
        points: [[v[0], v[1]], [v[2], v[3]]],
        axis: [v[4], v[5]],
    };
    let joints = model.joints.iter().zip(joints.chunks(6)).map(ends).collect();
    Ok(Some(Geometry { bodies: Place::all(bodies), joints }))
}

/// Poses of all bodies as functions of the coordinates.
pub(super) fn places(positions: &Positions) -> Result<Scalars, AnalysisError> {
    let (model, system) = (positions.model(), positions.system());
    let functions = body_functions(model, &system.kinematics);
    Ok(Scalars::compile(model, system, &functions, &positions.mechanism.parameters)?)
}

/// Centre of mass and angle of each body.
fn body_functions(model: &Model, kinematics: &Kinematics) -> Vec<bksim_expr::Expr> {
    let body = |idx: usize| {
        let com = kinematics.position(model, BodyId(idx), None);
        let is_ground = BodyId(idx) == GROUND;
        let angle = || kinematics.measure(model, Measure::BodyAngle(BodyId(idx)));
        [com[0], com[1], if is_ground { model.pool.zero() } else { angle() }]
    };
    (0..model.bodies.len()).flat_map(body).collect()
}

impl Structure {
    /// The structure that is left where `held` measures and the drives do not move; none where a joint or a measure
    /// is of another kind.
    pub(super) fn of(
        model: &Model,
        geometry: &Geometry,
        held: &[Measure],
        size: f64,
    ) -> Option<Self> {
        let drives = model.drives.iter();
        let driven = drives.map(|drive| Measure::JointPosition(drive.joint, drive.motion_idx));
        let held: Vec<Measure> = driven.chain(held.iter().copied()).collect();
        Self::holding(model, geometry, &held, size)
    }

    /// Structure with the drives released; see [`Structure::of`].
    pub(super) fn holding(
        model: &Model,
        geometry: &Geometry,
        held: &[Measure],
        size: f64,
    ) -> Option<Self> {
        let (mut held_motions, mut held_angles) = (Vec::new(), Vec::new());
        for measure in held {
            match *measure {
                Measure::JointPosition(joint, motion) => held_motions.push((joint.0, motion)),
                Measure::BodyAngle(body) => held_angles.push(body.0),
                _ => return None,
            }
        }
        let n_bodies = model.bodies.len();
        let (pairs, joint_of_node, mut leader) =
            lower_pairs(model, geometry, &mut held_motions, n_bodies)?;
        // What is held moves as one.
        let is_held = |pair: &LowerPair| {
            pair.motion.is_some_and(|motion| held_motions.contains(&(pair.joint, motion)))
        };
        let all_found = held_motions.iter().all(|held| {
            pairs.iter().any(|p| p.motion.is_some_and(|motion| (p.joint, motion) == *held))
        });
        if !all_found {
            return None;
        }
        for pair in pairs.iter().filter(|pair| is_held(pair)) {
            join(&mut leader, pair.nodes);
        }
        // Parts by number, the ground's first.
        let leaders: Vec<usize> = (0..leader.len()).map(|node| find(&leader, node)).collect();
        let mut numbers: Vec<usize> = leaders.clone();
        numbers.sort_unstable();
        numbers.dedup();
        let part = |node: usize| numbers.binary_search(&leaders[node]).unwrap_or(0);
        let mut structure = Self {
            n_parts: numbers.len(),
            part_of_body: (0..n_bodies).map(part).collect(),
            pins: Vec::new(),
            slides: Vec::new(),
            angles: held_angles.iter().map(|&body| part(body)).collect(),
            joint_of_part: numbers
                .iter()
                .map(|&node| node.checked_sub(n_bodies).map(|k| joint_of_node[k]))
                .collect(),
        };
        for pair in pairs.iter().filter(|pair| !is_held(pair)) {
            let parts = pair.nodes.map(part);
            if parts[0] == parts[1] {
                continue;
            }
            if pair.is_pin {
                let ends = [0, 1].map(|k| (parts[k], pair.points[k]));
                structure.add_pin(ends, pair.joint, size);
            } else {
                structure.slides.push(Slide { parts, axis: pair.axis, joint: pair.joint });
            }
        }
        Some(structure)
    }

    /// Adds a pin, or its parts to a pin that one of them has in the same point.
    fn add_pin(&mut self, ends: [(usize, [f64; 2]); 2], joint: usize, size: f64) {
        /// Points of one part nearer than this share of the longest link are one.
        const ONE_POINT: f64 = 1e-11;
        let is_on = |pin: &Pin| {
            ends.iter().any(|(part, p)| {
                pin.on
                    .iter()
                    .any(|(known, at)| known == part && length(less(*at, *p)) < ONE_POINT * size)
            })
        };
        let (same, mut rest): (Vec<Pin>, Vec<Pin>) =
            std::mem::take(&mut self.pins).into_iter().partition(is_on);
        let mut pin = Pin { on: Vec::new(), joint: same.first().map_or(joint, |pin| pin.joint) };
        for (part, point) in same.into_iter().flat_map(|pin| pin.on).chain(ends) {
            if pin.on.iter().all(|(known, _)| *known != part) {
                pin.on.push((part, point));
            }
        }
        rest.push(pin);
        self.pins = rest;
    }

    /// The point of a part at a pin.
    pub(super) fn point(&self, pin: usize, part: usize) -> [f64; 2] {
        let on = self.pins[pin].on.iter().find(|(known, _)| *known == part);
        on.map_or([f64::NAN; 2], |(_, point)| *point)
    }

    /// The place of a pin, if a part of it stands.
    pub(super) fn standing_pin(&self, pin: usize, way: &[Option<Place>]) -> Option<[f64; 2]> {
        self.pins[pin].on.iter().find_map(|(part, point)| Some(way[*part]?.apply(*point)))
    }

    /// The part that a guide joins to another one.
    pub(super) fn other(&self, slide: usize, part: usize) -> usize {
        let [a, b] = self.slides[slide].parts;
        if a == part { b } else { a }
    }

    /// The largest miss of pairs of `parts` with what stands, m.
    pub(super) fn miss(&self, parts: &[usize], way: &[Option<Place>]) -> f64 {
        // What is no number misses.
        let worse = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
        let mut worst: f64 = 0.0;
        for pin in self.pins.iter().filter(|pin| pin.on.iter().any(|(p, _)| parts.contains(p))) {
            let standing = |(part, point): &(usize, [f64; 2])| Some(way[*part]?.apply(*point));
            let places: Vec<[f64; 2]> = pin.on.iter().filter_map(standing).collect();
            let off = places.iter().map(|p| length(less(*p, places[0])));
            worst = off.fold(worst, worse);
        }
        for slide in self.slides.iter().filter(|s| s.parts.iter().any(|p| parts.contains(p))) {
            let [Some(a), Some(b)] = slide.parts.map(|part| way[part]) else { continue };
            let across = dot(less(b.at, a.at), left(turned(slide.axis, a.angle)));
            worst = worse(worse(worst, across.abs()), wrapped(b.angle - a.angle).abs());
        }
        worst
    }

    /// The name of a part: that of its first body, or of its joint.
    pub(super) fn name(&self, model: &Model, part: usize) -> String {
        if let Some(joint) = self.joint_of_part[part] {
            return model.joints[joint].name.clone();
        }
        let body = self.part_of_body.iter().position(|of| *of == part);
        body.map_or_else(String::new, |body| model.bodies[body].name.clone())
    }

    pub(super) fn joint_name(&self, model: &Model, pair: Pair) -> String {
        let joint = match pair {
            Pair::Pin(pin) => self.pins[pin].joint,
            Pair::Slide(slide) => self.slides[slide].joint,
        };
        model.joints[joint].name.clone()
    }
}

/// Pairs of all joints, nodes being bodies, then blocks of slots and links without mass; welds joined. Lengths of
/// cylinders that are held become links and are taken out of `held`.
fn lower_pairs(
    model: &Model,
    geometry: &Geometry,
    held: &mut Vec<(usize, usize)>,
    n_bodies: usize,
) -> Option<(Vec<LowerPair>, Vec<usize>, Vec<usize>)> {
    let mut pairs = Vec::new();
    let mut joint_of_node = Vec::new();
    let mut leader: Vec<usize> = (0..n_bodies).collect();
    for (joint, (of, ends)) in model.joints.iter().zip(&geometry.joints).enumerate() {
        let Ends { bodies, points, axis } = *ends;
        let pair = |is_pin: bool, nodes, points, motion| LowerPair {
            nodes,
            points,
            axis,
            is_pin,
            joint,
            motion,
        };
        let mut more = |leader: &mut Vec<usize>| {
            joint_of_node.push(joint);
            leader.push(leader.len());
            leader.len() - 1
        };
        match of.kind {
            JointKind::Revolute => pairs.push(pair(true, bodies, points, Some(0))),
            JointKind::Prismatic { .. } => pairs.push(pair(false, bodies, points, Some(0))),
            JointKind::Weld { .. } => join(&mut leader, bodies),
            JointKind::PinInSlot => {
                let block = more(&mut leader);
                pairs.push(pair(false, [bodies[0], block], points, Some(0)));
                pairs.push(pair(true, [block, bodies[1]], [points[1]; 2], Some(1)));
            }
            JointKind::Link { .. } | JointKind::Cylinder => {
                let is_held = held.contains(&(joint, 0));
                if of.kind == JointKind::Cylinder && !is_held {
                    continue;
                }
                held.retain(|(known, _)| *known != joint);
                let link = more(&mut leader);
                pairs.push(pair(true, [bodies[0], link], [points[0]; 2], None));
                pairs.push(pair(true, [link, bodies[1]], [points[1]; 2], None));
            }
            _ => return None,
        }
    }
    Some((pairs, joint_of_node, leader))
}

fn find(leader: &[usize], mut node: usize) -> usize {
    while leader[node] != node {
        node = leader[node];
    }
    node
}

/// Joins the groups of two nodes; the smallest number leads.
fn join(leader: &mut [usize], nodes: [usize; 2]) {
    let [a, b] = nodes.map(|node| find(leader, node));
    leader[a.max(b)] = a.min(b);
}
