//! [`Edit`]: one change of a model, as a value.

use std::ops::Range;

use bksim_model::diagnostic::{Code, Diagnostic};
use bksim_model::file::code;
use serde::{Deserialize, Serialize};

use crate::codes;
use crate::places::Places;
use crate::scan::Place;

/// One change of a model. Lengths and places are in m, angles in rad; values are written as in the file.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(tag = "edit", rename_all = "snake_case", deny_unknown_fields)]
pub enum Edit {
    /// Another text in place of all.
    Text {
        /// The text.
        text: String,
    },
    /// A value by its path, new or in place of another: `parameters.l1`, `bodies.rod.mass`,
    /// `initial.A.angle`, `joints.A.coordinate`.
    Set {
        /// Keys with dots between them; elements of lists by their number, from zero.
        path: String,
        /// Value as it is written in the file, quotes left out: `120 mm`, `l1/2`, `[0, "2 N"]`.
        value: String,
    },
    /// Takes out a value or a table by its path.
    Remove {
        /// Path as of [`Edit::Set`].
        path: String,
    },
    /// Moves a named point, of the ground or of a body.
    Move {
        /// `rod.B`, or `ground.O`.
        point: String,
        /// New place in the frame of its body.
        to: [f64; 2],
    },
    /// A point with a name.
    Point {
        /// A body, or `ground`.
        body: String,
        /// Place of the point in the frame of the body.
        at: [f64; 2],
    },
    /// A link between two ends, with a parameter for its length; an end on a point gets a pin there.
    Link {
        /// Where it begins.
        from: End,
        /// Where it ends.
        to: End,
    },
    /// A plate with three corners or more; a corner on a point gets a pin there.
    Plate {
        /// Corners of the plate, in order around it.
        corners: Vec<End>,
    },
    /// A revolute joint between two ends.
    Pin {
        /// On the first body.
        from: End,
        /// On the second body.
        to: End,
    },
    /// A pin between the ground and a point.
    Ground {
        /// The point.
        at: End,
    },
    /// Another distance between two named points of one body or of the ground: the parameter that it is, or the place of
    /// the second point.
    Length {
        /// The point that stays.
        from: String,
        /// Point of the same body that moves.
        to: String,
        /// Distance as it is written in the file: `120 mm`.
        value: String,
    },
    /// A guide along which a point slides, while its body turns.
    Slide {
        /// The point.
        at: End,
        /// Direction of the guide against the x axis of its body.
        angle: f64,
        /// Place that the guide goes through; without it, the point's own in the ground.
        #[serde(default)]
        guide: Option<End>,
    },
    /// Two wheels in mesh, each of half the distance; the radius of the first becomes a parameter.
    Gear {
        /// The joints about which they turn.
        between: [String; 2],
        /// Distance of these joints.
        distance: f64,
        /// Angle of the second where that of the first is zero, rad.
        #[serde(default)]
        phase: f64,
    },
    /// A body like another one, joined with nothing.
    Copy {
        /// The body.
        name: String,
        /// Guess of the place of its centre of mass.
        at: [f64; 2],
        /// True if the points of the copy are mirrored in the x axis of its frame.
        #[serde(default)]
        mirrored: bool,
    },
    /// A spring between two ends, unloaded at the distance that they have.
    Spring {
        /// One end.
        from: End,
        /// The other.
        to: End,
    },
    /// A damper between two ends.
    Damper {
        /// One end.
        from: End,
        /// The other.
        to: End,
    },
    /// A force of constant direction on a point.
    Force {
        /// The point.
        at: End,
        /// Components of the force, N.
        vector: [f64; 2],
    },
    /// Gravity along −y.
    Gravity {},
    /// A drive that turns a joint evenly, from the angle that it has.
    Motor {
        /// The joint.
        joint: String,
        /// Angle at the start.
        angle: f64,
    },
    /// Another name for a parameter, body, joint, load or drive, wherever it is used.
    Rename {
        /// The name.
        name: String,
        /// The new one.
        to: String,
    },
    /// Takes out a body, joint, load, drive or parameter, with all that cannot be without it.
    Delete {
        /// New name.
        name: String,
    },
    /// Several elements at once.
    Group {
        /// Bodies; to be deleted, other elements too.
        names: Vec<String>,
        /// The change that all of them undergo.
        to: Deed,
    },
    /// Several changes that are undone together.
    Several {
        /// One after the other.
        edits: Vec<Edit>,
    },
}

/// Change of all elements of a group: `"delete"`, `{"move": [0.1, 0]}`.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Deed {
    /// All are taken out, with all that cannot be without them.
    Delete,
    /// The places where they are attached to the ground, and their start, go by this.
    Move([f64; 2]),
    /// Copies of the bodies and of what is between them, by this from them.
    Copy([f64; 2]),
}

/// A place where something is attached.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct End {
    /// In the world.
    pub world: [f64; 2],
    /// A named point, `rod.B`, or a body, `rod`, that gets one; without it a link ends freely, and all else is
    /// attached to the ground.
    #[serde(default)]
    pub on: Option<String>,
    /// In the frame of the body; needed where `on` is a body alone.
    #[serde(default)]
    pub local: Option<[f64; 2]>,
}

/// Why an edit cannot be made.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum EditError {
    /// The text is not TOML.
    Unreadable,
    /// The text has nothing of this name or path.
    Missing {
        /// The name or path.
        path: String,
    },
    /// A name that something has already.
    Taken {
        /// The name.
        name: String,
    },
    /// No name: letters, digits and `_`.
    NoName {
        /// Name as given.
        name: String,
    },
    /// The coordinate of a point is a formula.
    Formula {
        /// The point.
        point: String,
        /// Formula as written.
        formula: String,
        /// The path of the coordinate.
        path: String,
    },
    /// A section or table is written on one line, in braces, or is none.
    NoTable {
        /// Path of the value.
        path: String,
    },
    /// A joint of a body with itself.
    SelfJoint {
        /// The body, or `ground`.
        body: String,
    },
    /// Two joints about which no wheels can mesh.
    NoGear {
        /// Names of the joints.
        between: [String; 2],
    },
    /// A parameter on which other values depend.
    Used {
        /// The parameter.
        name: String,
        /// The path of a value that uses it.
        by: String,
    },
}

impl EditError {
    pub(crate) fn missing(path: &[&str]) -> Self {
        Self::Missing { path: path.join(".") }
    }

    /// Stable code of the fault.
    pub fn code(&self) -> Code {
        match self {
            Self::Unreadable => codes::UNREADABLE,
            Self::Missing { .. } => codes::MISSING,
            Self::Taken { .. } | Self::NoName { .. } => codes::NAME,
            Self::Formula { .. } => codes::PLACE,
            Self::NoTable { .. } => codes::BRACES,
            Self::Used { .. } => codes::USED,
            Self::SelfJoint { .. } => code::SELF_JOINT,
            Self::NoGear { .. } => code::NO_CARRIER,
        }
    }

    /// The fault with its place in the text that was edited, and its help.
    pub fn diagnostic(&self, text: &str) -> Diagnostic {
        let (message, label, help) = self.words();
        let fault = Diagnostic::error(self.code(), message).help(help);
        match self.place(text) {
            Some(span) => fault.at(span, label),
            None => fault,
        }
    }

    /// Message, label and help.
    fn words(&self) -> (String, &'static str, &'static str) {
        match self {
            Self::Unreadable => (
                "the text is not TOML, so nothing in it can be found".to_owned(),
                "",
                "correct the faults that `bksim check` shows first",
            ),
            Self::Missing { path } => (
                format!("the model has no `{path}`"),
                "",
                "name a value by its path, as in `bodies.rod.mass`, and an element by its name",
            ),
            Self::Taken { name } => (
                format!("the name `{name}` is already taken"),
                "by this",
                "choose a name that nothing in the model has",
            ),
            Self::NoName { name } => (
                format!("`{name}` is no name"),
                "",
                "write letters a–z, digits and `_`, not starting with a digit",
            ),
            Self::Formula { point, formula, .. } => (
                format!("the place of point `{point}` is the formula `{formula}`"),
                "no number and no parameter",
                "change the parameters in it, or write a length in its place, as in \"120 mm\"",
            ),
            Self::NoTable { path } => (
                format!("`{path}` is written in braces or as a value, so nothing can be added"),
                "no table with a header",
                "write it as a table with a header of its own, as in `[bodies.rod]`",
            ),
            Self::SelfJoint { body } => (
                format!("both ends of the joint are on `{body}`"),
                "",
                "choose a point of another body",
            ),
            Self::NoGear { between: [first, second] } => (
                format!("no wheels about `{first}` and `{second}` can mesh"),
                "",
                "name two revolute joints, apart, of two bodies with one that carries both",
            ),
            Self::Used { name, by } => (
                format!("parameter `{name}` is still used by `{by}`"),
                "here",
                "write a value in its place there first",
            ),
        }
    }

    /// Place in the text that the fault is about.
    fn place(&self, text: &str) -> Option<Range<usize>> {
        let places = Places::of_whole(text)?;
        let path = match self {
            Self::Formula { path, .. } | Self::NoTable { path } => path.clone(),
            Self::Used { by, .. } => by.clone(),
            Self::Taken { name } => {
                let of = |place: &&Place| place.path.len() == 2 && place.path[1] == *name;
                let place = places.all.iter().find(of)?;
                return Some(place.own_key().unwrap_or(&place.span).clone());
            }
            Self::Unreadable
            | Self::Missing { .. }
            | Self::NoName { .. }
            | Self::SelfJoint { .. }
            | Self::NoGear { .. } => return None,
        };
        let keys: Vec<&str> = path.split('.').collect();
        places.find(&keys).map(|place| place.span.clone())
    }
}
