//! Compliances of joints as they are written: a name and a stiffness.

use super::written_unit::WrittenUnit;
use crate::compliance::Compliance;
use crate::ids::JointId;
use crate::measure::Measure;
use crate::model::Model;

/// Why a text is no compliance.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum NoCompliance {
    /// No joint, or no component of a reaction, has this name.
    #[error("no joint and no component of a reaction is called `{0}`")]
    Unknown(String),
    /// No stiffness of such a spring.
    #[error("`{0}` is no stiffness")]
    Stiffness(String),
}

impl Compliance {
    /// Reads `A = 1e8 N/m` or `1e5 N m/rad` for all directions, `A.fy` or `A.mz_joint` for one, in SI unless a unit is written.
    ///
    /// # Errors
    /// [`NoCompliance`] for an unknown name, and for what is no stiffness above zero.
    pub fn parse(model: &Model, name: &str, stiffness: &str) -> Result<Self, NoCompliance> {
        let unknown = || NoCompliance::Unknown(name.to_owned());
        let joint = |own: &str| model.joints.iter().position(|of| of.name == own).map(JointId);
        let component = || {
            let (own, word) = name.strip_prefix("reactions.").unwrap_or(name).rsplit_once('.')?;
            Measure::of_reaction(joint(own)?, word)
        };
        let (joint, along) = match (joint(name), component()) {
            (Some(joint), _) => (joint, None),
            (None, Some(Measure::Reaction(joint, frame, k))) => (joint, Some((frame, k))),
            _ => return Err(unknown()),
        };
        let bad = || NoCompliance::Stiffness(stiffness.to_owned());
        let (number, unit) = number_and_unit(stiffness).ok_or_else(bad)?;
        let kinds = match along {
            Some((_, ..3)) => &[false][..],
            Some(_) => &[true],
            None => &[false, true],
        };
        let found = kinds.iter().find_map(|&is_moment| {
            let si = WrittenUnit::parse(if is_moment { "N m/rad" } else { "N/m" })?;
            let written = if unit.is_empty() { si } else { WrittenUnit::parse(unit)? };
            (written.si() == si.si()).then(|| (is_moment, written.to_si(number)))
        });
        let (is_moment, stiffness) =
            found.filter(|(_, k)| *k > 0.0 && k.is_finite()).ok_or_else(bad)?;
        Ok(Self { joint, along, is_moment, stiffness })
    }
}

/// The number that a text begins with, and what follows it.
fn number_and_unit(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let is_number = |end: usize| text[..end].trim().parse::<f64>().is_ok_and(f64::is_finite);
    let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]);
    let end = ends.rev().find(|&end| is_number(end))?;
    Some((text[..end].trim().parse().ok()?, text[end..].trim()))
}
