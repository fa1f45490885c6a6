//! Planar linkages taken apart into dyads: two bodies at a time that close on what stands already, in two ways or in
//! none.
//!
//! ```text
//! RRR   circles of radii a, b at the distance d     c = (a² + d² − b²)/(2 a d)
//! RRP   a circle of radius a and a line h away      c = h/a
//! RPR   a guide k beside pins at the distance d     c = k/d
//! |c| < 1: two closures     |c| > 1: none
//! ```
//!
//! A linkage that comes apart without a rest has as many assemblies as there are ways through its dyads, and no others.

use bksim_mbs::coordinate::Owner;
use bksim_model::{BodyId, GROUND, JointId, JointKind, Measure, Model, Space};

use crate::error::AnalysisError;
use crate::positions::Positions;
use crate::rows::wrapped;
use crate::scalar::Scalars;

/// The proof that a linkage has these assemblies and no others.
#[derive(Clone, PartialEq, Debug)]
pub struct Proof {
    /// Dyads in the order in which they close.
    pub dyads: Vec<Dyad>,
    /// Number of assemblies.
    pub n: usize,
    /// Smallest 1 − |c| of a dyad that closes.
    pub margin: f64,
    /// Smallest |c| − 1 of a dyad that does not; none where all close.
    pub refuted_by: Option<f64>,
}

/// Two bodies with three joints.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Dyad {
    /// `RRR`, `RRP` or `RPR`.
    pub kind: &'static str,
    /// Names of its bodies.
    pub bodies: [String; 2],
    /// Names of its joints: that of the first body with what stands, that between the bodies, that of the second.
    pub joints: [String; 3],
}

/// A body in the plane: its centre of mass and its angle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Place {
    at: [f64; 2],
    angle: f64,
}

/// A step of the taking apart.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// A body that moves with another one, as it did in the start.
    Carried { by: usize, body: usize },
    /// A body with a held angle on a pin.
    Turned { joint: usize, by: usize, body: usize },
    /// A dyad: bodies, and joints as of [`Dyad`].
    Dyad { kind: Kind, bodies: [usize; 2], joints: [usize; 3] },
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Rrr,
    /// The second body slides on what stands.
    Rrp,
    Rpr,
}

/// A distance of |c| from one that rounding can make.
const UNDECIDED: f64 = 1e-9;
/// Places nearer than this, in lengths of the longest link and radians, are one.
const SAME: f64 = 1e-6;

/// A linkage that comes apart, with its geometry in the start.
pub(crate) struct Apart {
    steps: Vec<Step>,
    /// Of each joint the points in the frames of its bodies, and its axis in that of the first.
    points: Vec<[[f64; 2]; 2]>,
    axes: Vec<[f64; 2]>,
    /// First and second body of each joint.
    ends: Vec<[usize; 2]>,
    start: Vec<Place>,
    places: Scalars,
    size: f64,
    t: f64,
}

impl Apart {
    /// The linkage of `positions` with `held` measures; none where something is left over.
    pub(crate) fn of(
        positions: &Positions,
        held: &[Measure],
    ) -> Result<Option<Self>, AnalysisError> {
        let model = positions.model();
        if model.space != Space::Planar || !model.couplings.is_empty() {
            return Ok(None);
        }
        let Some(steps) = steps(model, held) else { return Ok(None) };
        // Bodies, then joints, in the start.
        let kinematics = &positions.system().kinematics;
        let pool = &model.pool;
        let mut functions = Vec::new();
        for idx in 0..model.bodies.len() {
            let com = kinematics.position(model, BodyId(idx), None);
            functions.extend([com[0], com[1]]);
            let is_ground = BodyId(idx) == GROUND;
            let angle = || kinematics.measure(model, Measure::BodyAngle(BodyId(idx)));
            functions.push(if is_ground { pool.zero() } else { angle() });
        }
        let n_of_bodies = functions.len();
        for joint in &model.joints {
            let sides = kinematics.sides(model, joint);
            let axis = sides.predecessor.rotation.apply(pool, &joint.axis);
            for vector in [sides.p_world_predecessor, sides.p_world_successor, axis] {
                functions.extend([vector[0], vector[1]]);
            }
        }
        let parameters = &positions.mechanism.parameters;
        let values = Scalars::compile(model, positions.system(), &functions, parameters)?
            .values(positions.t(), &positions.q);
        let places =
            Scalars::compile(model, positions.system(), &functions[..n_of_bodies], parameters)?;
        let (bodies, joints) = values.split_at(n_of_bodies);
        let start: Vec<Place> = places_of(bodies);
        let ends: Vec<[usize; 2]> =
            model.joints.iter().map(|j| [j.predecessor.body.0, j.successor.body.0]).collect();
        let in_body = |body: usize, p: &[f64]| {
            let Place { at, angle } = start[body];
            turned([p[0] - at[0], p[1] - at[1]], -angle)
        };
        let of_joint = |(v, [first, second]): (&[f64], &[usize; 2])| {
            let axis = turned([v[4], v[5]], -start[*first].angle);
            ([in_body(*first, &v[..2]), in_body(*second, &v[2..4])], axis)
        };
        let (points, axes) = joints.chunks(6).zip(&ends).map(of_joint).unzip();
        let (size, t) = (positions.size, positions.t());
        Ok(Some(Self { steps, points, axes, ends, start, places, size, t }))
    }

    /// All assemblies, and why there are no others; none where rounding could decide.
    pub(crate) fn assemblies(&self, model: &Model) -> Option<(Vec<Vec<Place>>, Proof)> {
        /// Most dyads that are followed.
        const MOST: usize = 12;
        let n_dyads = self.steps.iter().filter(|step| matches!(step, Step::Dyad { .. })).count();
        if n_dyads > MOST {
            return None;
        }
        let (mut margin, mut refuted_by): (f64, Option<f64>) = (f64::INFINITY, None);
        let mut ways = vec![vec![self.start[0]; self.start.len()]];
        for step in &self.steps {
            let mut next = Vec::new();
            for places in ways {
                match *step {
                    Step::Carried { by, body } => {
                        let mut places = places;
                        places[body] = self.carried(&places[by], by, body);
                        next.push(places);
                    }
                    Step::Turned { joint, by, body } => {
                        let pin = self.point(&places[by], joint, by);
                        let mut places = places;
                        places[body] = self.on_pin(joint, body, pin, self.start[body].angle);
                        next.push(places);
                    }
                    Step::Dyad { kind, bodies, joints } => {
                        let (c, closures) = self.closures(kind, bodies, joints, &places);
                        if !(c.is_finite() && (1.0 - c.abs()).abs() > UNDECIDED) {
                            return None;
                        }
                        if c.abs() > 1.0 {
                            let by = c.abs() - 1.0;
                            refuted_by = Some(refuted_by.map_or(by, |known| known.min(by)));
                            continue;
                        }
                        margin = margin.min(1.0 - c.abs());
                        for closure in closures {
                            let mut places = places.clone();
                            (places[bodies[0]], places[bodies[1]]) = (closure[0], closure[1]);
                            next.push(places);
                        }
                    }
                }
            }
            ways = next;
        }
        let dyad = |step: &Step| match *step {
            Step::Dyad { kind, bodies, joints } => Some(Dyad {
                kind: match kind {
                    Kind::Rrr => "RRR",
                    Kind::Rrp => "RRP",
                    Kind::Rpr => "RPR",
                },
                bodies: bodies.map(|body| model.bodies[body].name.clone()),
                joints: joints.map(|joint| model.joints[joint].name.clone()),
            }),
            _ => None,
        };
        let dyads = self.steps.iter().filter_map(dyad).collect();
        let proof = Proof { dyads, n: ways.len(), margin, refuted_by };
        Some((ways, proof))
    }

    /// True where the coordinates show these places.
    pub(crate) fn is_at(&mut self, q: &[f64], places: &[Place]) -> bool {
        let own = places_of(&self.places.values(self.t, q));
        own.iter().zip(places).all(|(a, b)| {
            let off = (a.at[0] - b.at[0]).hypot(a.at[1] - b.at[1]);
            off < SAME * self.size && wrapped(a.angle - b.angle).abs() < SAME
        })
    }

    /// Coordinates of an assembly, near to those that close it.
    pub(crate) fn coordinates(&self, positions: &Positions, places: &[Place]) -> Vec<f64> {
        let model = positions.model();
        let all = positions.system().coordinates().iter().zip(&positions.q);
        let value = |(coordinate, start): (&bksim_mbs::coordinate::Coordinate, &f64)| {
            match coordinate.owner {
                Owner::Joint(JointId(joint), motion) => {
                    let is_slide = model.joints[joint].kind.motions()[motion]
                        == bksim_model::MotionKind::Translation;
                    let [by, body] = self.ends[joint];
                    if is_slide {
                        start + self.slid(joint, places) - self.slid(joint, &self.start)
                    } else {
                        let turn = |of: &[Place]| of[body].angle - of[by].angle;
                        start + wrapped(turn(places) - turn(&self.start))
                    }
                }
                Owner::Body(BodyId(body), 2) => start + wrapped(places[body].angle - start),
                Owner::Body(BodyId(body), k) => places[body].at[k],
                _ => *start,
            }
        };
        all.map(value).collect()
    }

    /// The way along the axis of a joint.
    fn slid(&self, joint: usize, places: &[Place]) -> f64 {
        let [by, body] = self.ends[joint];
        let from = self.point(&places[by], joint, by);
        let to = self.point(&places[body], joint, body);
        let axis = turned(self.axes[joint], places[by].angle);
        (to[0] - from[0]) * axis[0] + (to[1] - from[1]) * axis[1]
    }

    /// The point of a joint in the frame of one of its bodies.
    fn local(&self, joint: usize, body: usize) -> [f64; 2] {
        self.points[joint][usize::from(self.ends[joint][0] != body)]
    }

    /// The same in the world.
    fn point(&self, place: &Place, joint: usize, body: usize) -> [f64; 2] {
        let [x, y] = turned(self.local(joint, body), place.angle);
        [place.at[0] + x, place.at[1] + y]
    }

    /// A body at an angle with its point of a joint on a pin.
    fn on_pin(&self, joint: usize, body: usize, pin: [f64; 2], angle: f64) -> Place {
        let [x, y] = turned(self.local(joint, body), angle);
        Place { at: [pin[0] - x, pin[1] - y], angle }
    }

    /// A body against another one as in the start.
    fn carried(&self, by: &Place, by_idx: usize, body: usize) -> Place {
        let (from, own) = (self.start[by_idx], self.start[body]);
        let offset =
            turned([own.at[0] - from.at[0], own.at[1] - from.at[1]], by.angle - from.angle);
        Place {
            at: [by.at[0] + offset[0], by.at[1] + offset[1]],
            angle: by.angle + own.angle - from.angle,
        }
    }

    /// c of a dyad, and its closures where |c| < 1.
    fn closures(
        &self,
        kind: Kind,
        [first, second]: [usize; 2],
        joints @ [a_joint, between, b_joint]: [usize; 3],
        places: &[Place],
    ) -> (f64, Vec<[Place; 2]>) {
        let standing = |joint: usize, body: usize| {
            let other = self.ends[joint][usize::from(self.ends[joint][0] == body)];
            (other, self.point(&places[other], joint, other))
        };
        let (_, p) = standing(a_joint, first);
        let (slide, q) = standing(b_joint, second);
        // From pin to pin in the frame of a body.
        let arm = |body: usize, from: usize, to: usize| {
            let (a, b) = (self.local(from, body), self.local(to, body));
            [b[0] - a[0], b[1] - a[1]]
        };
        let heading = |v: [f64; 2]| v[1].atan2(v[0]);
        let length = |v: [f64; 2]| v[0].hypot(v[1]);
        let of_first = arm(first, a_joint, between);
        // The first body with its far pin at a point.
        let reaching = |x: [f64; 2]| {
            let angle = heading([x[0] - p[0], x[1] - p[1]]) - heading(of_first);
            self.on_pin(a_joint, first, p, angle)
        };
        match kind {
            Kind::Rrr => {
                let of_second = arm(second, b_joint, between);
                let (a, b) = (length(of_first), length(of_second));
                let line = [q[0] - p[0], q[1] - p[1]];
                let d = length(line);
                let c = (a * a + d * d - b * b) / (2.0 * a * d);
                let closure = |sign: f64| {
                    let angle = heading(line) + sign * c.clamp(-1.0, 1.0).acos();
                    let x = [p[0] + a * angle.cos(), p[1] + a * angle.sin()];
                    let turn = heading([x[0] - q[0], x[1] - q[1]]) - heading(of_second);
                    [reaching(x), self.on_pin(b_joint, second, q, turn)]
                };
                (c, vec![closure(1.0), closure(-1.0)])
            }
            Kind::Rrp => {
                let angle =
                    places[slide].angle + self.start[second].angle - self.start[slide].angle;
                let axis_by = self.ends[b_joint][0];
                let axis_angle = if axis_by == second { angle } else { places[slide].angle };
                let e = turned(self.axes[b_joint], axis_angle);
                let offset = turned(arm(second, b_joint, between), angle);
                let foot = [q[0] + offset[0], q[1] + offset[1]];
                let w = [p[0] - foot[0], p[1] - foot[1]];
                let a = length(of_first);
                let (along, aside) = (w[0] * e[0] + w[1] * e[1], w[0] * e[1] - w[1] * e[0]);
                let c = aside / a;
                let half = (a * a - aside * aside).max(0.0).sqrt();
                let closure = |sign: f64| {
                    let s = along + sign * half;
                    let x = [foot[0] + s * e[0], foot[1] + s * e[1]];
                    let at = self.on_pin(between, second, x, angle);
                    [reaching(x), at]
                };
                (c, vec![closure(1.0), closure(-1.0)])
            }
            Kind::Rpr => {
                // The guide is in the frame of the first body of the joint.
                let guide_is_first = self.ends[between][0] == first;
                let (guide, block) = if guide_is_first { (first, second) } else { (second, first) };
                let (near, far) = if guide_is_first { (p, q) } else { (q, p) };
                let (near_joint, far_joint) =
                    if guide_is_first { (joints[0], joints[2]) } else { (joints[2], joints[0]) };
                let delta = self.start[block].angle - self.start[guide].angle;
                let axis = self.axes[between];
                let normal = [-axis[1], axis[0]];
                let of_block = turned(arm(block, far_joint, between), delta);
                let of_guide = arm(guide, near_joint, between);
                let k = (of_block[0] - of_guide[0]) * normal[0]
                    + (of_block[1] - of_guide[1]) * normal[1];
                let line = [far[0] - near[0], far[1] - near[1]];
                let c = -k / length(line);
                let closure = |sign: f64| {
                    let angle = heading(line) - heading(normal) + sign * c.clamp(-1.0, 1.0).acos();
                    let guide = self.on_pin(near_joint, guide, near, angle);
                    let block = self.on_pin(far_joint, block, far, angle + delta);
                    if guide_is_first { [guide, block] } else { [block, guide] }
                };
                (c, vec![closure(1.0), closure(-1.0)])
            }
        }
    }
}

fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

fn places_of(values: &[f64]) -> Vec<Place> {
    values.chunks(3).map(|v| Place { at: [v[0], v[1]], angle: v[2] }).collect()
}

/// The order in which a linkage closes from the ground on; none where joints or measures are left over.
fn steps(model: &Model, held: &[Measure]) -> Option<Vec<Step>> {
    let mut held_joints: Vec<usize> =
        model.drives.iter().filter(|d| d.motion_idx == 0).map(|drive| drive.joint.0).collect();
    if held_joints.len() < model.drives.len() {
        return None;
    }
    let mut held_angles: Vec<usize> = Vec::new();
    for measure in held {
        match *measure {
            Measure::JointPosition(joint, 0) => held_joints.push(joint.0),
            Measure::BodyAngle(body) => held_angles.push(body.0),
            _ => return None,
        }
    }
    let kind = |joint: usize| match model.joints[joint].kind {
        JointKind::Revolute => Some('R'),
        JointKind::Prismatic { .. } => Some('P'),
        JointKind::Weld { .. } => Some('W'),
        _ => None,
    };
    if (0..model.joints.len()).any(|joint| kind(joint).is_none()) {
        return None;
    }
    let ends: Vec<[usize; 2]> =
        model.joints.iter().map(|j| [j.predecessor.body.0, j.successor.body.0]).collect();
    let mut is_placed = vec![false; model.bodies.len()];
    is_placed[GROUND.0] = true;
    let mut is_used = vec![false; model.joints.len()];
    let mut steps = Vec::new();
    loop {
        // Bodies that stand because a joint or an angle is held.
        let single = (0..ends.len()).filter(|&j| !is_used[j]).find_map(|joint| {
            let [a, b] = ends[joint];
            let (by, body) = match (is_placed[a], is_placed[b]) {
                (true, false) => (a, b),
                (false, true) => (b, a),
                _ => return None,
            };
            let is_held = held_joints.contains(&joint) || kind(joint) == Some('W');
            if is_held {
                return Some((joint, body, Step::Carried { by, body }));
            }
            let turns = kind(joint) == Some('R') && held_angles.contains(&body);
            turns.then_some((joint, body, Step::Turned { joint, by, body }))
        });
        if let Some((joint, body, step)) = single {
            if matches!(step, Step::Turned { .. }) {
                held_angles.retain(|of| *of != body);
            }
            held_joints.retain(|of| *of != joint);
            (is_used[joint], is_placed[body]) = (true, true);
            steps.push(step);
            continue;
        }
        // Two bodies that close.
        let free: Vec<usize> = (0..ends.len())
            .filter(|&j| !is_used[j] && !held_joints.contains(&j) && kind(j) != Some('W'))
            .collect();
        let standing = |body: usize| {
            let free = free.iter().copied();
            free.filter(|&j| {
                let [a, b] = ends[j];
                (a == body && is_placed[b]) || (b == body && is_placed[a])
            })
            .collect::<Vec<_>>()
        };
        let dyad = free.iter().find_map(|&between| {
            let [u, v] = ends[between];
            if is_placed[u] || is_placed[v] {
                return None;
            }
            let (of_u, of_v) = (standing(u), standing(v));
            let ([a], [b]) = (of_u.as_slice(), of_v.as_slice()) else { return None };
            match (kind(*a)?, kind(between)?, kind(*b)?) {
                ('R', 'R', 'R') => Some((Kind::Rrr, [u, v], [*a, between, *b])),
                ('R', 'R', 'P') => Some((Kind::Rrp, [u, v], [*a, between, *b])),
                ('P', 'R', 'R') => Some((Kind::Rrp, [v, u], [*b, between, *a])),
                ('R', 'P', 'R') => Some((Kind::Rpr, [u, v], [*a, between, *b])),
                _ => None,
            }
        });
        let Some((kind, bodies, joints)) = dyad else { break };
        for joint in joints {
            is_used[joint] = true;
        }
        for body in bodies {
            is_placed[body] = true;
        }
        steps.push(Step::Dyad { kind, bodies, joints });
    }
    let is_whole = is_placed.iter().all(|placed| *placed)
        && is_used.iter().all(|used| *used)
        && held_joints.is_empty()
        && held_angles.is_empty();
    is_whole.then_some(steps)
}
