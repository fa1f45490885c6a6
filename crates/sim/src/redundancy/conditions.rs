//! Conditions of joints and couplings by name and direction, and those that follow from others.

use bksim_model::{CouplingId, JointId, Model};

/// A condition that others keep already.
#[derive(Clone, PartialEq, Debug)]
pub struct RepeatedCondition {
    /// The condition.
    pub condition: Condition,
    /// Conditions before it in the file that it follows from.
    pub by: Vec<Condition>,
}

/// One condition of a joint or coupling.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Condition {
    /// The part that keeps it.
    pub of: Keeper,
    /// Direction of the condition.
    pub direction: Direction,
}

/// A part of a mechanism that keeps conditions.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Keeper {
    /// A joint.
    Joint(JointId),
    /// A coupling.
    Coupling(CouplingId),
}

/// The direction of the force or moment that keeps a condition: unit vectors in the axes of the joint, those of its
/// first point's frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Direction {
    /// A force along an axis.
    Force([f64; 3]),
    /// A moment about an axis.
    Moment([f64; 3]),
    /// A force along an axis and the moment that goes with it, as in a screw.
    Wrench([f64; 3]),
    /// The only one of a coupling, of a link along itself, or of a contact.
    Alone,
}

impl Direction {
    /// The direction of a force and a moment; parts below a millionth are rounding.
    pub(super) fn of(force: [f64; 3], moment: [f64; 3]) -> Self {
        const ROUNDING: f64 = 1e-6;
        let norm = |v: [f64; 3]| v.iter().map(|part| part * part).sum::<f64>().sqrt();
        let [of_force, of_moment] = [norm(force), norm(moment)];
        // Either sign keeps the same condition: the largest part is taken as positive.
        let unit = |v: [f64; 3], norm: f64| {
            let larger = |a: f64, b: f64| if b.abs() > a.abs() * (1.0 + ROUNDING) { b } else { a };
            let sign = v.into_iter().fold(0.0, larger).signum();
            v.map(|part| if part.abs() > ROUNDING * norm { sign * part / norm } else { 0.0 })
        };
        if of_moment <= ROUNDING * of_force {
            Self::Force(unit(force, of_force))
        } else if of_force <= ROUNDING * of_moment {
            Self::Moment(unit(moment, of_moment))
        } else {
            Self::Wrench(unit(force, of_force))
        }
    }

    /// The axis; none of what has one direction only.
    pub fn axis(&self) -> Option<[f64; 3]> {
        match *self {
            Self::Force(axis) | Self::Moment(axis) | Self::Wrench(axis) => Some(axis),
            Self::Alone => None,
        }
    }

    /// `x`, `y` or `z` of what is along an axis of the joint, else `oblique`; none of what has one direction only.
    fn word(&self) -> Option<&'static str> {
        /// Sine of the angle within which a direction is along an axis.
        const ALONG: f64 = 1e-9;
        let axis = self.axis()?;
        let others =
            |k: usize| (0..3).filter(|i| *i != k).map(|i| axis[i].abs()).fold(0.0, f64::max);
        let along = (0..3).find(|&k| others(k) < ALONG);
        Some(along.map_or("oblique", |k| ["x", "y", "z"][k]))
    }
}

impl Condition {
    /// The name of the joint or coupling.
    pub fn name<'m>(&self, model: &'m Model) -> &'m str {
        match self.of {
            Keeper::Joint(joint) => &model.joints[joint.0].name,
            Keeper::Coupling(coupling) => &model.couplings[coupling.0].name,
        }
    }

    /// The effort that keeps it: `force`, `moment`, or `force and moment` as in a screw; of a coupling `coupling`.
    pub fn effort(&self) -> &'static str {
        match (self.direction, self.of) {
            (Direction::Force(_), _) | (Direction::Alone, Keeper::Joint(_)) => "force",
            (Direction::Moment(_), _) => "moment",
            (Direction::Wrench(_), _) => "force and moment",
            (Direction::Alone, Keeper::Coupling(_)) => "coupling",
        }
    }

    /// Direction in words: `x`, `y` or `z` of what is along an axis of the joint, `oblique` of what is along none; `length`
    /// of a link, `normal` of a contact, `motion` of a coupling.
    pub fn direction_word(&self, model: &Model) -> &'static str {
        self.direction.word().unwrap_or(match self.of {
            Keeper::Coupling(_) => "motion",
            Keeper::Joint(joint) => match model.joints[joint.0].kind.link_length() {
                Some(_) => "length",
                None => "normal",
            },
        })
    }

    /// The condition in words: "moment about the y axis of `B`".
    pub fn words(&self, model: &Model) -> String {
        let name = self.name(model);
        let along = match (self.direction.word(), self.direction.axis()) {
            (Some("oblique"), Some(axis)) => {
                let parts = axis.map(|part| format!("{:.3}", part + 0.0));
                format!("[{}] in the axes of `{name}`", parts.join(", "))
            }
            (Some(word), _) => format!("the {word} axis of `{name}`"),
            (None, _) => format!("`{name}`"),
        };
        match (self.direction, self.of) {
            (Direction::Force(_), _) | (Direction::Alone, Keeper::Joint(_)) => {
                format!("force along {along}")
            }
            (Direction::Moment(_), _) => format!("moment about {along}"),
            (Direction::Wrench(_), _) => format!("force and moment along {along}"),
            (Direction::Alone, Keeper::Coupling(_)) => format!("coupling {along}"),
        }
    }
}
