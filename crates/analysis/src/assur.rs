//! Planar linkages taken apart into Assur groups: parts that close on what stands already in finitely many ways.
//!
//! ```text
//! dyad    two parts, three pairs       closed form, two ways or none
//! triad   a platform on three legs     roots of a polynomial in e^(iθ) on the unit circle, at most six
//! larger  any other parts               ends of paths in complex numbers, as many as ranks allow
//! single  one part, two pairs          redundant: it closes or it does not
//! ```
//!
//! A linkage that comes apart without a rest has as many assemblies as there are ways through its groups, and no others.
//! Only the pose against each other matters, so any part may stand where the ground lets nothing begin.
//!
//! Source: L. V. Assur's groups and their classes, e.g. G. R. Pennock, J. J. Uicker and J. E. Shigley, *Theory of Machines
//! and Mechanisms*; the platform's polynomial in isotropic coordinates: C. W. Wampler, *Solving the kinematics of planar
//! mechanisms*, J. Mech. Des. 121 (1999) 387.

mod dyad;
mod four_bar;
mod larger;
mod laurent;
mod order;
mod place;
mod structure;
mod triad;

use bksim_mbs::coordinate::{Coordinate, Owner};
use bksim_model::{JointId, Measure, Model, MotionKind};

use self::order::{Group, Step};
use self::place::{Place, turned};
use self::structure::Structure;
use crate::error::AnalysisError;
use crate::platform::Platform;
use crate::positions::Positions;
use crate::rows::wrapped;
use crate::scalar::Scalars;

pub(crate) use self::four_bar::four_bars;
pub use self::four_bar::{BarkerType, FourBar, Rotatability, SliderCrank};
pub use self::larger::Solution;
pub use self::laurent::Root;

/// The proof that a linkage has these assemblies and no others.
#[derive(Clone, PartialEq, Debug)]
pub struct Proof {
    /// Groups of two parts, in the order in which they close.
    pub dyads: Vec<Dyad>,
    /// Platforms with three legs, in the order in which they close.
    pub triads: Vec<Triad>,
    /// Other groups, in the order in which they close.
    pub larger: Vec<Larger>,
    /// The platform in space that the mechanism is, in place of groups.
    pub platform: Option<Platform>,
    /// Number of assemblies.
    pub n: usize,
    /// Conditions more than needed: what they ask for holds to rounding in every assembly.
    pub n_redundant: usize,
    /// Smallest 1 − |c| of a dyad that closes, or sine of the angle between its guides.
    pub margin: f64,
    /// Smallest |c| − 1 of a dyad that does not, or miss of a redundant condition in lengths of the longest link; none
    /// where all close.
    pub refuted_by: Option<f64>,
}

/// Two parts with three pairs.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Dyad {
    /// Pairs from end to end, `R` for a pin and `P` for a guide: `RRR`, `RRP`, `RPR`, `PRP` or `RPP`.
    pub kind: &'static str,
    /// Names of its bodies, or of the joint that a part without one belongs to.
    pub bodies: [String; 2],
    /// Names of its joints: that of the first body with what stands, that between the bodies, that of the second.
    pub joints: [String; 3],
}

/// A platform with three legs.
#[derive(Clone, PartialEq, Debug)]
pub struct Triad {
    /// Name of the platform.
    pub platform: String,
    /// Names of the legs.
    pub legs: [String; 3],
    /// Of each leg its pair with what stands, then that with the platform: `RR`, `PR` or `RP`.
    pub kinds: [&'static str; 3],
    /// Names of the joints, in the same order.
    pub joints: [[String; 2]; 3],
    /// For each way in which what comes before stands all roots of the polynomial in e^(iθ), θ being the turn of the
    /// platform from its pose in the start.
    pub solved: Vec<Vec<Root>>,
}

/// Parts that close together and are neither a dyad nor a triad.
#[derive(Clone, PartialEq, Debug)]
pub struct Larger {
    /// Names of its bodies, or of the joints that parts without one belong to.
    pub bodies: Vec<String>,
    /// For each way in which what comes before stands the largest number of isolated closures in complex numbers.
    pub bounds: Vec<u64>,
    /// For each way all closures in complex numbers.
    pub solved: Vec<Vec<Solution>>,
}

impl Proof {
    /// The proof by all poses of a platform, `n` of them real.
    pub(crate) fn of_platform(platform: Platform, n: usize) -> Self {
        Self {
            dyads: Vec::new(),
            triads: Vec::new(),
            larger: Vec::new(),
            platform: Some(platform),
            n,
            n_redundant: 0,
            margin: f64::INFINITY,
            refuted_by: None,
        }
    }

    /// True where no group can have more closures than were found.
    pub(crate) fn is_complete(&self) -> bool {
        let is_all = |group: &Larger| {
            group
                .bounds
                .iter()
                .zip(&group.solved)
                .all(|(bound, found)| found.len() as u64 == *bound)
        };
        self.larger.iter().all(is_all) && self.platform.iter().all(Platform::is_complete)
    }
}

/// 1 − |c|, or a miss, from one that rounding can make.
const UNDECIDED: f64 = 1e-9;
/// Places nearer than this, in lengths of the longest link and radians, are one.
const SAME: f64 = 1e-6;

/// A linkage that comes apart, with its geometry in the start.
pub(crate) struct Apart {
    structure: Structure,
    root: usize,
    steps: Vec<Step>,
    /// Bodies in the start.
    start: Vec<Place>,
    places: Scalars,
    /// First and second body of each joint, their points and the axis, world axes in the start.
    joints: Vec<structure::Ends>,
    size: f64,
    t: f64,
}

/// The ways on from a step.
enum Outcome {
    /// Places of all parts, for each way on.
    Ways(Vec<Vec<Option<Place>>>),
    /// Rounding could decide.
    Undecided,
}

impl Apart {
    /// The linkage of `positions` with `held` measures; none where something is left over.
    pub(crate) fn of(
        positions: &Positions,
        held: &[Measure],
    ) -> Result<Option<Self>, AnalysisError> {
        let geometry = structure::geometry(positions)?;
        let Some(geometry) = geometry else { return Ok(None) };
        let Some(structure) = Structure::of(positions.model(), &geometry, held, positions.size)
        else {
            return Ok(None);
        };
        let Some((root, steps)) = order::steps(&structure) else { return Ok(None) };
        let places = structure::places(positions)?;
        let (size, t) = (positions.size, positions.t());
        let structure::Geometry { bodies, joints } = geometry;
        Ok(Some(Self { structure, root, steps, start: bodies, places, joints, size, t }))
    }

    /// All assemblies, as places of the bodies, and why there are no others; none where rounding could decide.
    pub(crate) fn assemblies(&self, model: &Model) -> Option<(Vec<Vec<Place>>, Proof)> {
        /// Most ways that are followed at once.
        const MOST: usize = 4096;
        let mut proof = self.groups(model);
        let mut standing = vec![None; self.structure.n_parts];
        standing[self.root] = Some(Place::START);
        let mut ways = vec![standing];
        let (mut n_triads, mut n_larger) = (0, 0);
        for step in &self.steps {
            let mut next = Vec::new();
            // The number of the group among those of its kind.
            let kind = match step.group {
                Group::Triad { .. } => &mut n_triads,
                _ => &mut n_larger,
            };
            let number = *kind;
            if let Group::Triad { .. } | Group::Larger { .. } = step.group {
                *kind += 1;
            }
            for way in &ways {
                match self.closed(step, number, way, &mut proof) {
                    Outcome::Ways(more) => next.extend(more),
                    Outcome::Undecided => return None,
                }
            }
            ways = next;
            if ways.len() > MOST {
                return None;
            }
        }
        let ways: Vec<Vec<Place>> =
            ways.into_iter().map(|way| self.bodies(&way)).collect::<Option<_>>()?;
        proof.n = ways.len();
        Some((ways, proof))
    }

    /// The ways on from one way, through a group.
    fn closed(
        &self,
        step: &Step,
        number: usize,
        way: &[Option<Place>],
        proof: &mut Proof,
    ) -> Outcome {
        let structure = &self.structure;
        let closures = match &step.group {
            Group::Turned { part, pin, angle } => {
                dyad::turned_on(structure, *part, *pin, *angle, way).into_iter().collect()
            }
            Group::Single { part, pairs } => {
                dyad::single(structure, *part, *pairs, way).into_iter().collect()
            }
            Group::Dyad { parts, pairs } => {
                let Some(closure) = dyad::closures(structure, *parts, *pairs, way) else {
                    return Outcome::Undecided;
                };
                if closure.margin.is_nan() || closure.margin.abs() < UNDECIDED {
                    return Outcome::Undecided;
                }
                if closure.margin < 0.0 {
                    refute(proof, -closure.margin);
                    return Outcome::Ways(Vec::new());
                }
                proof.margin = proof.margin.min(closure.margin);
                closure.ways
            }
            Group::Triad { platform, legs } => {
                let Some((roots, ways)) =
                    triad::closures(structure, *platform, legs, way, self.size)
                else {
                    return Outcome::Undecided;
                };
                proof.triads[number].solved.push(roots);
                ways
            }
            Group::Larger { parts } => {
                let Some(closed) = larger::closures(structure, parts, way, self.size) else {
                    return Outcome::Undecided;
                };
                proof.larger[number].bounds.push(closed.bound);
                proof.larger[number].solved.push(closed.solutions);
                closed.ways
            }
        };
        let mut next = Vec::new();
        for closure in closures {
            let mut way = way.to_vec();
            for (part, place) in closure {
                way[part] = Some(place);
            }
            // Pairs that the group did not use, but closed.
            let miss = structure.miss(&step.parts(), &way) / self.size;
            if miss < UNDECIDED {
                next.push(way);
            } else if miss > SAME {
                refute(proof, miss);
            } else {
                return Outcome::Undecided;
            }
        }
        Outcome::Ways(next)
    }

    /// Bodies of a way, with the ground in its place.
    fn bodies(&self, way: &[Option<Place>]) -> Option<Vec<Place>> {
        let ground = way[self.structure.part_of_body[0]]?;
        let body =
            |(start, &part): (&Place, &usize)| Some(ground.inverse().of(&way[part]?.of(start)));
        self.start.iter().zip(&self.structure.part_of_body).map(body).collect()
    }

    /// The groups by name, nothing counted yet.
    fn groups(&self, model: &Model) -> Proof {
        let structure = &self.structure;
        let part = |part: usize| structure.name(model, part);
        let joint = |pair| structure.joint_name(model, pair);
        let (mut dyads, mut triads, mut larger) = (Vec::new(), Vec::new(), Vec::new());
        for step in &self.steps {
            match &step.group {
                Group::Dyad { parts, pairs } => dyads.push(Dyad {
                    kind: dyad::kind(*pairs),
                    bodies: parts.map(part),
                    joints: pairs.map(joint),
                }),
                Group::Triad { platform, legs } => triads.push(Triad {
                    platform: part(*platform),
                    legs: legs.map(|leg| part(leg.part)),
                    kinds: legs.map(|leg| leg.kind()),
                    joints: legs.map(|leg| [joint(leg.standing), joint(leg.platform)]),
                    solved: Vec::new(),
                }),
                Group::Larger { parts } => larger.push(Larger {
                    bodies: parts.iter().map(|of| part(*of)).collect(),
                    bounds: Vec::new(),
                    solved: Vec::new(),
                }),
                Group::Turned { .. } | Group::Single { .. } => {}
            }
        }
        let n_redundant = self.steps.iter().map(|step| step.n_redundant).sum();
        let margin = f64::INFINITY;
        Proof { dyads, triads, larger, platform: None, n: 0, n_redundant, margin, refuted_by: None }
    }

    /// True where the coordinates show these places.
    pub(crate) fn is_at(&mut self, q: &[f64], places: &[Place]) -> bool {
        let own = Place::all(&self.places.values(self.t, q));
        own.iter().zip(places).all(|(a, b)| {
            let off = (a.at[0] - b.at[0]).hypot(a.at[1] - b.at[1]);
            off < SAME * self.size && wrapped(a.angle - b.angle).abs() < SAME
        })
    }

    /// Coordinates of an assembly, near to those that close it.
    pub(crate) fn coordinates(&self, positions: &Positions, places: &[Place]) -> Vec<f64> {
        let model = positions.model();
        let all = positions.system().coordinates().iter().zip(&positions.q);
        let value = |(coordinate, start): (&Coordinate, &f64)| match coordinate.owner {
            Owner::Joint(JointId(joint), motion) => {
                let is_slide =
                    model.joints[joint].kind.motions()[motion] == MotionKind::Translation;
                let [by, body] = self.joints[joint].bodies;
                if is_slide {
                    start + self.slid(joint, places) - self.slid(joint, &self.start)
                } else {
                    let turn = |of: &[Place]| of[body].angle - of[by].angle;
                    start + wrapped(turn(places) - turn(&self.start))
                }
            }
            Owner::Body(body, 2) => start + wrapped(places[body.0].angle - start),
            Owner::Body(body, k) => places[body.0].at[k],
            _ => *start,
        };
        all.map(value).collect()
    }

    /// The way along the axis of a joint.
    fn slid(&self, joint: usize, places: &[Place]) -> f64 {
        let ends = &self.joints[joint];
        let moved = |body: usize| places[body].of(&self.start[body].inverse());
        let [by, body] = ends.bodies;
        let [from, to] = [moved(by).apply(ends.points[0]), moved(body).apply(ends.points[1])];
        let axis = turned(ends.axis, moved(by).angle);
        (to[0] - from[0]) * axis[0] + (to[1] - from[1]) * axis[1]
    }
}

fn refute(proof: &mut Proof, by: f64) {
    proof.refuted_by = Some(proof.refuted_by.map_or(by, |known| known.min(by)));
}
