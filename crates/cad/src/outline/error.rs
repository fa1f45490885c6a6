//! [`OutlineError`]: why strokes make no outline.

use crate::codes;
use crate::excerpt::short;
use crate::geometry::{GeometryError, Point};
use bksim_model::diagnostic::{Code, Diagnostic};
use thiserror::Error;

/// An end that meets no other.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OpenEnd {
    /// Where it is.
    pub at: Point,
    /// The entity that ends here.
    pub entity: usize,
    /// Distance to the nearest other open end, where there is one.
    pub gap: Option<f64>,
}

/// Why strokes make no outline; entities are the indices given with the strokes.
#[derive(Clone, PartialEq, Debug, Error)]
#[non_exhaustive]
pub enum OutlineError {
    /// Numbers that make no curve.
    #[error("{reason}")]
    Curve {
        /// The fault of the numbers.
        reason: GeometryError,
        /// Index of the entity.
        entity: usize,
    },
    /// Ends that meet no other.
    #[error("the outline is open at {}", positions(.ends))]
    Open {
        /// All of them, in the order of the strokes.
        ends: Vec<OpenEnd>,
    },
    /// Three or more ends that meet.
    #[error("{n} ends meet at {}, so the outline could go on either way", position(.at), n = .entities.len())]
    Ambiguous {
        /// Where they meet.
        at: Point,
        /// Their entities, one for each end.
        entities: Vec<usize>,
    },
    /// Loops that cross, or one that crosses itself.
    #[error("outlines cross at {}", position(.at))]
    Crossing {
        /// A point near the crossing.
        at: Point,
        /// The first entity of each loop.
        entities: [usize; 2],
    },
    /// Loops on top of each other.
    #[error("two outlines lie on each other at {}", position(.at))]
    Coincident {
        /// A point of both.
        at: Point,
        /// The first entity of each loop.
        entities: [usize; 2],
    },
    /// Loops that hold nothing.
    #[error("the outline at {} has no area", position(.at))]
    NoArea {
        /// A point of it.
        at: Point,
        /// Indices of the entities.
        entities: Vec<usize>,
    },
}

impl OutlineError {
    /// Code of the fault.
    pub fn code(&self) -> Code {
        match self {
            Self::Open { .. } => codes::OPEN_OUTLINE,
            Self::Ambiguous { .. } => codes::AMBIGUOUS_ENDS,
            Self::Crossing { .. } => codes::CROSSING_OUTLINES,
            Self::Coincident { .. } => codes::DOUBLE_OUTLINE,
            Self::NoArea { .. } => codes::NO_AREA,
            Self::Curve { .. } => codes::NO_CURVE,
        }
    }

    /// The entities it is about, each once: a diagnostic shows where they are.
    pub fn entities(&self) -> Vec<usize> {
        let mut entities = match self {
            Self::Curve { entity, .. } => vec![*entity],
            Self::Open { ends } => ends.iter().map(|end| end.entity).collect(),
            Self::Ambiguous { entities, .. } | Self::NoArea { entities, .. } => entities.clone(),
            Self::Crossing { entities, .. } | Self::Coincident { entities, .. } => {
                entities.to_vec()
            }
        };
        let mut known = std::collections::BTreeSet::new();
        entities.retain(|entity| known.insert(*entity));
        entities
    }

    /// Diagnostic without locations: they are those of [`OutlineError::entities`].
    pub fn diagnostic(&self) -> Diagnostic {
        let fault = Diagnostic::error(self.code(), self.to_string());
        match self {
            Self::Open { ends } => match ends.iter().filter_map(|end| end.gap).reduce(f64::min) {
                Some(gap) => fault
                    .note(format!("the smallest gap between two open ends is {} units", short(gap)))
                    .help("close the gaps in the drawing, or allow a larger `--tolerance`"),
                None => fault.help("close the gaps in the drawing"),
            },
            Self::Ambiguous { .. } => {
                fault.help("leave two ends at each corner: move the others to another layer")
            }
            Self::Crossing { .. } => {
                fault.help("draw each outline and each hole without crossing another")
            }
            Self::Coincident { .. } => fault.help("delete one of the two"),
            Self::NoArea { .. } => fault.help("draw a closed outline around an area"),
            Self::Curve { .. } => fault,
        }
    }
}

/// A point in words.
pub(super) fn position([x, y]: &Point) -> String {
    format!("({}, {})", short(*x), short(*y))
}

/// The first few, and how many more there are.
fn positions(ends: &[OpenEnd]) -> String {
    const SHOWN: usize = 4;
    let mut text: Vec<String> = ends.iter().take(SHOWN).map(|end| position(&end.at)).collect();
    if ends.len() > SHOWN {
        text.push(format!("{} more points", ends.len() - SHOWN));
    }
    text.join(", ")
}
