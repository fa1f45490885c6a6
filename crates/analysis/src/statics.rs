//! Equilibria: every one along a single free motion; with several, those that a search from many poses finds.
//!
//! ```text
//! ∂V/∂q − Q(q, 0) + Gᵀ λ = 0,   g = 0
//! along one free motion:    w(σ) = (Q − ∂V/∂q) · τ changes its sign
//! K_r = Zᵀ (∂r/∂q) Z        stable where all its eigenvalues are positive
//! ```

use bksim_model::Model;

use crate::balance::Balance;
use crate::equilibrium::{Equilibrium, Stability, cells, columns};
use crate::error::AnalysisError;
use crate::families::FamilyAt;
use crate::loaded::Loaded;
use crate::open_reactions::ReactionBound;
use crate::table::Table;

/// All equilibria that were found.
#[derive(Clone, PartialEq, Debug)]
pub struct Statics {
    /// Names of the joints, for the reactions.
    pub joints: Vec<String>,
    /// The independent quantities that the stiffness is by, with their units.
    pub by: Vec<(String, &'static str)>,
    /// In order along the free motion, from the start; else by their distance from the start.
    pub equilibria: Vec<Equilibrium>,
    /// Whether these are all on the assembly of the start.
    pub is_complete: bool,
    /// Stops and friction that count as constraints.
    pub held: Vec<String>,
}

/// Equilibria this near to each other that have no stiffness are one, rad or parts of the longest link.
const NEAR: f64 = 0.05;

/// Finds the equilibria of `model`, in which states of controllers have no rates; of a family of equilibria the first that is
/// found. The stiffness is by the measures `by`, else by coordinates. Reactions that are not unique keep to `bounds`.
///
/// # Errors
/// [`AnalysisError`] when there is no start, or no equilibrium.
pub fn statics(
    model: Model,
    by: &[String],
    bounds: &[ReactionBound],
) -> Result<Statics, AnalysisError> {
    let loaded = Loaded::of(model)?;
    let mut balance = Balance::of(&loaded, by, &[])?;
    balance.bounds = bounds.to_vec();
    let (poses, is_complete) = balance.all()?;
    let mut equilibria: Vec<Equilibrium> = Vec::new();
    let mut families: Vec<(usize, FamilyAt)> = Vec::new();
    for q in poses {
        // The first of a family stands for all.
        let family = balance.family(&q);
        if let Some(at) = &family {
            let mut known = families.iter().filter(|(_, known)| known.family == at.family);
            if known.any(|(k, known)| balance.is_of_family(&equilibria[*k].q, known, &q)) {
                continue;
            }
        }
        let mut found = balance.equilibrium(&q)?;
        // A search comes only near to one whose stiffness vanishes.
        let is_near = |e: &Equilibrium| {
            e.stability == Stability::Neutral
                && balance.apart(&e.q, &q).iter().all(|off| off.abs() < NEAR)
        };
        if family.is_none()
            && found.stability == Stability::Neutral
            && equilibria.iter().any(is_near)
        {
            continue;
        }
        if let Some(at) = family {
            found.family = Some(at.family.clone());
            families.push((equilibria.len(), at));
        }
        equilibria.push(found);
    }
    if equilibria.is_empty() {
        return Err(AnalysisError::NoEquilibrium);
    }
    Ok(Statics {
        joints: loaded.mechanism.compiled.joints.clone(),
        by: balance.by_names(&equilibria[0].q)?,
        equilibria,
        is_complete,
        held: loaded.held_contacts(),
    })
}

impl Statics {
    /// A row for each equilibrium: stability (1, 0, −1: stable, neutral, unstable), the smallest stiffness, the
    /// pose, the reactions.
    pub fn table(&self) -> Table {
        let rows = self.equilibria.iter().map(cells).collect();
        Table { columns: columns(self.equilibria.first(), &self.joints), rows }
    }
}
