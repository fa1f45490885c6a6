//! Measures by the names that expressions of a model file use, and their units.

use crate::body::Body;
use crate::body::Space;
use crate::ids::{BodyId, ContactId, DriveId, JointId, PointId, StateId};
use crate::joint::{MotionKind, motion_words};
use crate::measure::{Axis, ContactPart, Frame, Initial, LinePart, Measure, Resultant};
use crate::model::Model;
use crate::state::NamedSignal;

/// A word of the model file, and what it measures of a body or its point.
pub(crate) type BodyWord = (&'static str, fn(BodyId, Option<PointId>) -> Measure);

/// The measures of a body; a point has the first [`N_POINT_WORDS`], and a start is stated by those up to
/// [`N_START_WORDS`].
#[rustfmt::skip]
pub(crate) const BODY_WORDS: [BodyWord; 36] = {
    use Axis::{X, Y, Z};
    [
        ("x", |b, p| Measure::PointPosition(b, p, X)),
        ("y", |b, p| Measure::PointPosition(b, p, Y)),
        ("z", |b, p| Measure::PointPosition(b, p, Z)),
        ("vx", |b, p| Measure::PointVelocity(b, p, X)),
        ("vy", |b, p| Measure::PointVelocity(b, p, Y)),
        ("vz", |b, p| Measure::PointVelocity(b, p, Z)),
        ("angle", |b, _| Measure::BodyAngle(b)),
        ("rate", |b, _| Measure::BodyRate(b)),
        ("roll", |b, _| Measure::RollPitchYaw(b, X)),
        ("pitch", |b, _| Measure::RollPitchYaw(b, Y)),
        ("yaw", |b, _| Measure::RollPitchYaw(b, Z)),
        ("wx", |b, _| Measure::AngularVelocity(b, Frame::World, X)),
        ("wy", |b, _| Measure::AngularVelocity(b, Frame::World, Y)),
        ("wz", |b, _| Measure::AngularVelocity(b, Frame::World, Z)),
        ("wx_body", |b, _| Measure::AngularVelocity(b, Frame::Body, X)),
        ("wy_body", |b, _| Measure::AngularVelocity(b, Frame::Body, Y)),
        ("wz_body", |b, _| Measure::AngularVelocity(b, Frame::Body, Z)),
        ("cxx", |b, _| Measure::DirectionCosine(b, X, X)),
        ("cxy", |b, _| Measure::DirectionCosine(b, X, Y)),
        ("cxz", |b, _| Measure::DirectionCosine(b, X, Z)),
        ("cyx", |b, _| Measure::DirectionCosine(b, Y, X)),
        ("cyy", |b, _| Measure::DirectionCosine(b, Y, Y)),
        ("cyz", |b, _| Measure::DirectionCosine(b, Y, Z)),
        ("czx", |b, _| Measure::DirectionCosine(b, Z, X)),
        ("czy", |b, _| Measure::DirectionCosine(b, Z, Y)),
        ("czz", |b, _| Measure::DirectionCosine(b, Z, Z)),
        ("e0", |b, _| Measure::Quaternion(b, 0)),
        ("e1", |b, _| Measure::Quaternion(b, 1)),
        ("e2", |b, _| Measure::Quaternion(b, 2)),
        ("e3", |b, _| Measure::Quaternion(b, 3)),
        ("px", |b, _| Measure::Momentum(Some(b), X)),
        ("py", |b, _| Measure::Momentum(Some(b), Y)),
        ("pz", |b, _| Measure::Momentum(Some(b), Z)),
        ("lx", |b, _| Measure::AngularMomentum(Some(b), X)),
        ("ly", |b, _| Measure::AngularMomentum(Some(b), Y)),
        ("lz", |b, _| Measure::AngularMomentum(Some(b), Z)),
    ]
};

/// Number of rows of [`BODY_WORDS`] that a point has.
pub(crate) const N_POINT_WORDS: usize = 6;
/// Number of rows of [`BODY_WORDS`] that a start is stated by.
pub(crate) const N_START_WORDS: usize = 17;

/// Number of rows of [`ACCELERATION_WORDS`] that a point has.
pub(crate) const N_POINT_ACCELERATIONS: usize = 3;

/// Accelerations of a body, which results have but no load; a point has the first three.
#[rustfmt::skip]
pub(crate) const ACCELERATION_WORDS: [BodyWord; 10] = {
    use Axis::{X, Y, Z};
    [
        ("ax", |b, p| Measure::PointAcceleration(b, p, X)),
        ("ay", |b, p| Measure::PointAcceleration(b, p, Y)),
        ("az", |b, p| Measure::PointAcceleration(b, p, Z)),
        ("acceleration", |b, _| Measure::AngularAcceleration(b, Frame::World, Z)),
        ("alx", |b, _| Measure::AngularAcceleration(b, Frame::World, X)),
        ("aly", |b, _| Measure::AngularAcceleration(b, Frame::World, Y)),
        ("alz", |b, _| Measure::AngularAcceleration(b, Frame::World, Z)),
        ("alx_body", |b, _| Measure::AngularAcceleration(b, Frame::Body, X)),
        ("aly_body", |b, _| Measure::AngularAcceleration(b, Frame::Body, Y)),
        ("alz_body", |b, _| Measure::AngularAcceleration(b, Frame::Body, Z)),
    ]
};

/// Words of a free body's coordinates.
pub fn free_motion_names(space: Space) -> &'static [&'static str] {
    match space {
        Space::Planar => &["x", "y", "angle"],
        Space::Spatial => &["x", "y", "z", "angle1", "angle2", "angle3"],
    }
}

impl Body {
    /// The identifier of one of its coordinates where it moves freely: the author's, else its name and a
    /// [word](free_motion_names).
    ///
    /// # Panics
    /// If a free body has no such motion.
    pub fn coordinate_name(&self, space: Space, motion_idx: usize) -> String {
        let stated = self.coordinate_names.get(motion_idx).cloned();
        stated.unwrap_or_else(|| format!("{}_{}", self.name, free_motion_names(space)[motion_idx]))
    }
}

/// The owner of the reactions of all joints, where no body or joint has this name: `reactions.A.fx`.
pub(crate) const REACTIONS: &str = "reactions";

/// The owner of the forces of couplings, where no body or joint has this name: `couplings.pair`.
pub(crate) const COUPLINGS: &str = "couplings";

/// The owner of the quantities of contacts, where no body or joint has this name: `contacts.floor.force`.
pub(crate) const CONTACTS: &str = "contacts";

/// The words of quantities of contacts.
pub(crate) const CONTACT_WORDS: [(&str, ContactPart); 5] = [
    ("force", ContactPart::Force),
    ("friction", ContactPart::Friction),
    ("rolling", ContactPart::Rolling),
    ("gap", ContactPart::Gap),
    ("slip", ContactPart::Slip),
];

/// The owner of the quantities of loads between two points, where no body or joint has this name: `loads.spring.force`.
pub(crate) const LOADS: &str = "loads";

/// The words of quantities of loads between two points.
pub(crate) const LINE_WORDS: [(&str, LinePart); 3] =
    [("force", LinePart::Force), ("length", LinePart::Length), ("rate", LinePart::Rate)];

/// The owner of the efforts of drives, where no body or joint has this name: `drives.crank`.
pub(crate) const DRIVES: &str = "drives";

/// The components of a reaction; with `_joint` behind them in the axes of its joint.
const REACTION_WORDS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// The words of reactions as a whole.
const RESULTANT_WORDS: [(&str, Resultant); 2] =
    [("force", Resultant::Force), ("moment", Resultant::Moment)];

/// The words of reactions: components in the axes of the ground and of joints, then resultants.
pub fn reaction_words() -> impl Iterator<Item = String> {
    let ends = ["", "_joint"].into_iter();
    let components = ends.flat_map(|end| REACTION_WORDS.map(|word| format!("{word}{end}")));
    components.chain(RESULTANT_WORDS.map(|(word, _)| word.to_owned()))
}

/// Parts of the energy with their units: `energy.total`.
pub const ENERGIES: [(&str, &str); 4] =
    [("kinetic", "J"), ("potential", "J"), ("total", "J"), ("power", "W")];

/// The owner of the measures of all bodies together, where no body or joint has this name.
const ALL: &str = "mechanism";

impl Measure {
    /// The measure of a name, by which files, commands and Python call it: `A.angle`, `rod.vx`, `rod.B.y`, `rod.ax`,
    /// `mechanism.px`, a coordinate or its rate (`theta`, `state.theta_dot`), a state, `reactions.A.fx`,
    /// `reactions.A.fx_joint`, `reactions.A.force`, `drives.crank`, `contacts.floor.gap`, `loads.spring.force`. `None` when the model has nothing of this name.
    pub fn named(model: &Model, name: &str) -> Option<Self> {
        let parts: Vec<&str> = name.split('.').collect();
        let (&word, owner) = parts.split_last()?;
        match *owner {
            // A parameter keeps its name from the coordinates of a joint.
            [] if model.parameters.iter().any(|parameter| parameter.name == word) => None,
            [] => of_coordinate(model, word).or_else(|| of_state(model, word)),
            [owner] => of_joint(model, owner, word)
                .or_else(|| of_body(model, owner, None, word))
                .or_else(|| Self::of_all(owner, word))
                .or_else(|| match owner {
                    DRIVES => {
                        let drive = model.drives.iter().position(|drive| drive.name == word)?;
                        Some(Self::Effort(DriveId(drive)))
                    }
                    // The pull of a rope that stretches; other forces of couplings are channels by themselves.
                    COUPLINGS => {
                        let mut sections = model.ropes.iter().flat_map(|rope| &rope.sections);
                        sections.find(|own| own.pull.is_some() && own.name == word)?;
                        model.force_names.iter().position(|own| own == word).map(Self::Force)
                    }
                    "state" | "acceleration" | "states" => Self::named(model, word),
                    _ => None,
                }),
            [owner, point] => of_body(model, owner, Some(point), word).or_else(|| {
                let is_it = |joint: &crate::Joint| owner == REACTIONS && joint.name == point;
                match model.joints.iter().position(is_it) {
                    Some(joint) => Self::of_reaction(JointId(joint), word),
                    None => of_contact(model, owner, point, word)
                        .or_else(|| of_line(model, owner, point, word)),
                }
            }),
            _ => None,
        }
    }

    /// Names by which [`Measure::named`] finds measures, as a message suggests them: joints, bodies, points,
    /// coordinates, states, reactions, drives.
    pub fn names(model: &Model) -> Vec<String> {
        let is_planar = model.space == Space::Planar;
        let fits = |word: &str| !is_planar || !word.contains('z');
        let words = |n: usize, n_planar: usize| {
            let own = &BODY_WORDS[..if is_planar { n_planar } else { n }];
            let accelerations = &ACCELERATION_WORDS[..N_POINT_ACCELERATIONS];
            let all = own.iter().chain(accelerations).map(|(word, _)| *word);
            all.filter(|word| fits(word)).collect::<Vec<_>>()
        };
        let mut names = Vec::new();
        let mut add = |owner: &str, words: &[&str]| {
            names.extend(words.iter().map(|word| format!("{owner}.{word}")));
        };
        for joint in &model.joints {
            let motions = joint.kind.motions();
            (0..motions.len()).for_each(|idx| add(&joint.name, &motion_words(motions, idx)));
        }
        for body in model.bodies.iter().skip(1) {
            add(&body.name, &words(BODY_WORDS.len(), N_POINT_WORDS + 2));
            for point in &body.points {
                add(&format!("{}.{}", body.name, point.name), &words(N_POINT_WORDS, N_POINT_WORDS));
            }
        }
        let reactions: Vec<String> = reaction_words().collect();
        let reactions: Vec<&str> = reactions.iter().map(String::as_str).collect();
        for joint in &model.joints {
            add(&format!("{REACTIONS}.{}", joint.name), &reactions);
        }
        for drive in &model.drives {
            add(DRIVES, &[&drive.name]);
        }
        let words = CONTACT_WORDS.map(|(word, _)| word);
        model.contacts.iter().for_each(|own| add(&format!("{CONTACTS}.{}", own.name), &words));
        let words = LINE_WORDS.map(|(word, _)| word);
        model.line_names.iter().for_each(|own| add(&format!("{LOADS}.{own}"), &words));
        let of_joints = model.joints.iter().flat_map(|joint| &joint.coordinate_names);
        let of_bodies = model.bodies.iter().flat_map(|body| &body.coordinate_names);
        let rates = of_joints
            .chain(of_bodies)
            .flat_map(|name| ["", "_dot"].map(|end| format!("{name}{end}")));
        names.extend(rates.chain(model.states.iter().map(|state| state.name.clone())));
        names
    }

    /// The measure of all bodies together by its words: `mechanism.px`, `mechanism.lz`.
    pub(crate) fn of_all(owner: &str, word: &str) -> Option<Self> {
        let index = |letter: &str| ["x", "y", "z"].iter().position(|known| *known == letter);
        let axis = |letter: &str| Some([Axis::X, Axis::Y, Axis::Z][index(letter)?]);
        match (owner == ALL).then(|| word.split_at_checked(1))?? {
            ("p", letter) => Some(Self::Momentum(None, axis(letter)?)),
            ("l", letter) => Some(Self::AngularMomentum(None, axis(letter)?)),
            _ => None,
        }
    }

    /// The measure of `fx`, `mz_joint` or `force` of the reaction of a joint.
    pub(crate) fn of_reaction(joint: JointId, word: &str) -> Option<Self> {
        if let Some((_, whole)) = RESULTANT_WORDS.iter().find(|(known, _)| *known == word) {
            return Some(Self::Resultant(joint, *whole));
        }
        let n = REACTION_WORDS.len();
        let place = reaction_words().position(|known| known == word)?;
        let frame = if place < n { Frame::World } else { Frame::Body };
        Some(Self::Reaction(joint, frame, place % n))
    }

    /// Names of a position of a joint, body or point, of its rate and of its second rate: `A.angle`, `A.rate`,
    /// `A.acceleration`; none of anything else.
    pub fn motion_names(self, model: &Model) -> Option<[String; 3]> {
        match self {
            Self::JointPosition(JointId(joint), idx) => {
                let joint = &model.joints[joint];
                let words = motion_words(joint.kind.motions(), idx);
                Some(words.map(|word| format!("{}.{word}", joint.name)))
            }
            Self::BodyAngle(BodyId(body)) => {
                let own = &model.bodies[body].name;
                Some(["angle", "rate", "acceleration"].map(|word| format!("{own}.{word}")))
            }
            Self::PointPosition(BodyId(body), point, axis) => {
                let body = &model.bodies[body];
                let of_point = |PointId(k): PointId| format!(".{}", body.points[k].name);
                let owner = format!("{}{}", body.name, point.map_or_else(String::new, of_point));
                let axis = match axis {
                    Axis::X => "x",
                    Axis::Y => "y",
                    Axis::Z => "z",
                };
                Some(["", "v", "a"].map(|order| format!("{owner}.{order}{axis}")))
            }
            _ => None,
        }
    }

    /// SI unit of the measure; empty of a pure number.
    pub fn unit(self, model: &Model) -> &str {
        match self {
            Self::State(StateId(state)) => &model.states[state].units[1],
            _ => self.fixed_unit(model),
        }
    }

    /// SI unit of the measure; empty of a pure number, and of a state, whose unit is its author's.
    pub fn fixed_unit(self, model: &Model) -> &'static str {
        let turns = |joint: JointId, motion_idx: usize| {
            let motions = model.joints[joint.0].kind.motions();
            motions.get(motion_idx) == Some(&MotionKind::Rotation)
        };
        let turned_by = |DriveId(drive): DriveId| {
            model.drives.get(drive).is_some_and(|drive| turns(drive.joint, drive.motion_idx))
        };
        match self {
            Self::JointPosition(joint, idx) if turns(joint, idx) => "rad",
            Self::JointVelocity(joint, idx) if turns(joint, idx) => "rad/s",
            Self::JointAcceleration(joint, idx) if turns(joint, idx) => "rad/s^2",
            Self::JointPosition(..)
            | Self::PointPosition(..)
            | Self::Contact(_, ContactPart::Gap)
            | Self::Line(_, LinePart::Length) => "m",
            Self::JointVelocity(..)
            | Self::PointVelocity(..)
            | Self::Contact(_, ContactPart::Slip)
            | Self::Line(_, LinePart::Rate) => "m/s",
            Self::BodyAngle(_)
            | Self::Turn(..)
            | Self::CardanAngle(..)
            | Self::RollPitchYaw(..) => "rad",
            Self::BodyRate(_) | Self::CardanRate(..) | Self::AngularVelocity(..) => "rad/s",
            Self::Quaternion(..) | Self::DirectionCosine(..) | Self::State(_) => "",
            Self::AngularAcceleration(..) => "rad/s^2",
            Self::JointAcceleration(..) | Self::PointAcceleration(..) => "m/s^2",
            Self::Effort(drive) if turned_by(drive) => "N m",
            Self::Reaction(_, _, ..3)
            | Self::Resultant(_, Resultant::Force)
            | Self::Effort(_)
            | Self::Force(_)
            | Self::Contact(_, ContactPart::Force | ContactPart::Friction)
            | Self::Line(_, LinePart::Force) => "N",
            Self::Reaction(..)
            | Self::Resultant(..)
            | Self::Moment(_)
            | Self::Contact(_, ContactPart::Rolling) => "N m",
            Self::Momentum(..) => "kg m/s",
            Self::AngularMomentum(..) => "kg m^2/s",
        }
    }
}

impl Model {
    /// The named expression of `u`, `signals.u` or `outputs.mu`.
    pub fn signal_named(&self, name: &str) -> Option<&NamedSignal> {
        let own = ["signals.", "outputs."].iter().find_map(|topic| name.strip_prefix(topic));
        self.named_signals.iter().find(|signal| signal.name == own.unwrap_or(name))
    }

    /// True if a quantity of its runs has this name, one with a formula of the state.
    pub fn has_quantity(&self, name: &str) -> bool {
        let of_coupling = |own| self.couplings.iter().any(|coupling| coupling.name == own);
        Measure::named(self, name).is_some()
            || self.signal_named(name).is_some()
            || name.strip_prefix("couplings.").is_some_and(of_coupling)
            || name
                .strip_prefix("energy.")
                .is_some_and(|own| ENERGIES.iter().any(|(part, _)| *part == own))
    }
}

impl Initial {
    /// The SI unit of its value; empty of a pure number and of a state without unit.
    pub fn unit<'m>(&self, model: &'m Model) -> &'m str {
        self.measure.unit(model)
    }
}

/// The measure of a coordinate by its name, `theta` or `A_angle`, or of its rate, `theta_dot`, or second rate.
fn of_coordinate(model: &Model, name: &str) -> Option<Measure> {
    let rate = |end: &str, order| Some((name.strip_suffix(end)?, order));
    let tries = [Some((name, 0)), rate("_dot", 1), rate("_ddot", 2)];
    tries.into_iter().flatten().find_map(|(stem, order)| {
        let of_joint = model.joints.iter().enumerate().find_map(|(k, joint)| {
            let n = joint.kind.motions().len();
            let idx = (0..n).find(|&idx| joint.coordinate_name(idx) == stem)?;
            Some(joint_measures(JointId(k), idx)[order])
        });
        of_joint.or_else(|| {
            model.bodies.iter().enumerate().skip(1).find_map(|(k, body)| {
                let n = free_motion_names(model.space).len();
                let idx = (0..n).find(|&idx| body.coordinate_name(model.space, idx) == stem)?;
                free_measures(model.space, BodyId(k), idx)[order]
            })
        })
    })
}

/// Position, velocity and acceleration of a motion of a joint.
fn joint_measures(joint: JointId, idx: usize) -> [Measure; 3] {
    [
        Measure::JointPosition(joint, idx),
        Measure::JointVelocity(joint, idx),
        Measure::JointAcceleration(joint, idx),
    ]
}

/// Position, velocity and acceleration of a motion of a free body; Cardan angles have no measure of the last.
fn free_measures(space: Space, body: BodyId, idx: usize) -> [Option<Measure>; 3] {
    let n_translations = if space == Space::Planar { 2 } else { 3 };
    match (space, idx.checked_sub(n_translations)) {
        (_, None) => {
            let axis = [Axis::X, Axis::Y, Axis::Z][idx];
            [
                Some(Measure::PointPosition(body, None, axis)),
                Some(Measure::PointVelocity(body, None, axis)),
                Some(Measure::PointAcceleration(body, None, axis)),
            ]
        }
        (Space::Planar, Some(_)) => [
            Some(Measure::BodyAngle(body)),
            Some(Measure::BodyRate(body)),
            Some(Measure::AngularAcceleration(body, Frame::World, Axis::Z)),
        ],
        (Space::Spatial, Some(turn)) => {
            [Some(Measure::CardanAngle(body, turn)), Some(Measure::CardanRate(body, turn)), None]
        }
    }
}

/// The quantity of a contact: `contacts.floor.force`.
fn of_contact(model: &Model, owner: &str, name: &str, word: &str) -> Option<Measure> {
    let idx = model.contacts.iter().position(|own| own.name == name)?;
    let (_, part) = CONTACT_WORDS.iter().find(|(known, _)| owner == CONTACTS && *known == word)?;
    Some(Measure::Contact(ContactId(idx), *part))
}

/// The quantity of a load between two points: `loads.spring.length`.
fn of_line(model: &Model, owner: &str, name: &str, word: &str) -> Option<Measure> {
    let idx = model.line_names.iter().position(|own| own == name)?;
    let (_, part) = LINE_WORDS.iter().find(|(known, _)| owner == LOADS && *known == word)?;
    Some(Measure::Line(idx, *part))
}

fn of_state(model: &Model, name: &str) -> Option<Measure> {
    let state = model.states.iter().position(|state| state.name == name)?;
    Some(Measure::State(StateId(state)))
}

fn of_joint(model: &Model, owner: &str, word: &str) -> Option<Measure> {
    let joint = model.joints.iter().position(|joint| joint.name == owner)?;
    let motions = model.joints[joint].kind.motions();
    (0..motions.len()).find_map(|idx| {
        let order = motion_words(motions, idx).iter().position(|known| *known == word)?;
        Some(joint_measures(JointId(joint), idx)[order])
    })
}

fn of_body(model: &Model, owner: &str, point: Option<&str>, word: &str) -> Option<Measure> {
    let body = model.bodies.iter().position(|body| body.name == owner)?;
    let points = &model.bodies[body].points;
    let point = match point {
        Some(name) => Some(PointId(points.iter().position(|point| point.name == name)?)),
        None => None,
    };
    let [rows, accelerations] = match point {
        Some(_) => [&BODY_WORDS[..N_POINT_WORDS], &ACCELERATION_WORDS[..N_POINT_ACCELERATIONS]],
        None => [&BODY_WORDS[..], &ACCELERATION_WORDS[..]],
    };
    let (_, measure) = rows.iter().chain(accelerations).find(|(known, _)| *known == word)?;
    Some(measure(BodyId(body), point))
}
