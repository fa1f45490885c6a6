//! Equilibria: every one along a single free motion; with several, those that a search from many poses finds.
//!
//! ```text
//! ∂V/∂q − Q(q, 0) + Gᵀ λ = 0,   g = 0
//! along one free motion:    w(σ) = (Q − ∂V/∂q) · τ changes its sign
//! K_r = Zᵀ (∂r/∂q) Z        stable where all its eigenvalues are positive
//! ```

use bksim_model::Model;

use crate::balance::Balance;
use crate::equilibrium::{BearingStop, Equilibrium, cells, columns};
use crate::error::AnalysisError;
use crate::loaded::{HeldContacts, Loaded};
use crate::open_reactions::ReactionBound;
use crate::poses::Poses;
use crate::rests::on_open_stops;
use crate::table::{Column, Table};
use crate::way_rates::WayRates;

/// All equilibria that were found.
#[derive(Clone, PartialEq, Debug)]
pub struct Statics {
    /// Names of the joints, for the reactions.
    pub joints: Vec<String>,
    /// The independent quantities that the stiffness is by, with their units.
    pub by: Vec<(String, &'static str)>,
    /// The nearest to the start first, of those that are as near the stable ones; then those on stops that are open at the
    /// start, in the same order.
    pub equilibria: Vec<Equilibrium>,
    /// Poses in balance beyond stops that are open at the start, in which the mechanism cannot be.
    pub left_out: Vec<Equilibrium>,
    /// True if these are all on the assembly of the start.
    pub is_complete: bool,
    /// The branches that cross in the start, all of which are followed; none where it is on one alone.
    pub ways: Vec<WayRates>,
    /// Stops and friction that count as constraints, and friction that is left out.
    pub held: HeldContacts,
    /// True of a model with drives, which hold their joints.
    pub is_driven: bool,
}

/// Finds the equilibria of `model`, in which states of controllers have no rates; of a family of equilibria the first that is
/// found. The stiffness is by the measures `by`, else by coordinates; on a stop it is by coordinates. Reactions that are not
/// unique keep to `bounds`.
///
/// # Errors
/// [`AnalysisError`] when there is no start, or no equilibrium.
pub fn statics(
    model: Model,
    by: &[String],
    bounds: &[ReactionBound],
) -> Result<Statics, AnalysisError> {
    let mut loaded = Loaded::at_rest(model)?;
    let (mut found, poses, none) = with_the_contacts_of_the_start(&loaded, by, bounds)?;
    let on_stops = on_open_stops(&mut loaded, bounds, poses.on_stops.as_deref())?;
    found.equilibria.extend(Balance::of(&loaded, by, &[])?.nearest_first(on_stops));
    if found.equilibria.is_empty() { Err(none) } else { Ok(found) }
}

/// The equilibria in which no other stop is closed than at the start, their poses, and the fault of a mechanism that has none.
fn with_the_contacts_of_the_start(
    loaded: &Loaded,
    by: &[String],
    bounds: &[ReactionBound],
) -> Result<(Statics, Poses, AnalysisError), AnalysisError> {
    let mut balance = Balance::of(loaded, by, &[])?;
    balance.bounds = bounds.to_vec();
    let poses = balance.all()?;
    let [equilibria, left_out] = balance.listed(&poses)?;
    let on_stops = poses.on_stops.as_deref().unwrap_or_default();
    let none = balance.without_equilibrium(&poses.beyond, on_stops);
    // Where branches cross, more than the motions is free by the slopes.
    let known = equilibria.iter().chain(&left_out).filter(|e| e.branches.is_empty());
    let known = known.map(|equilibrium| &equilibrium.q);
    let first = known.chain(on_stops.iter().map(|(_, q)| q)).next();
    let by = match first {
        Some(q) => balance.by_names(q)?,
        None => balance.by_names(&balance.regular_pose()).unwrap_or_default(),
    };
    let joints = loaded.mechanism.compiled.joints.clone();
    let (is_complete, held) = (poses.is_complete, loaded.held_contacts());
    let ways = balance.ways_of_start()?;
    let is_driven = !loaded.mechanism.model.drives.is_empty();
    let found = Statics { joints, by, equilibria, left_out, is_complete, ways, held, is_driven };
    Ok((found, poses, none))
}

impl Statics {
    /// A row for each equilibrium: stability (1, 0, −1: stable, neutral, unstable), the smallest stiffness, the
    /// pose, the reactions, then what each stop bears that is closed in any of them.
    pub fn table(&self) -> Table {
        let name = |stop: &BearingStop| format!("{}.{}", stop.name, stop.limit);
        let mut stops: Vec<Column> = Vec::new();
        for stop in self.equilibria.iter().flat_map(|equilibrium| &equilibrium.bearing) {
            if stops.iter().all(|known| known.name != name(stop)) {
                stops.push(Column::new(name(stop), stop.unit));
            }
        }
        let effort = |equilibrium: &Equilibrium, column: &Column| {
            let own = equilibrium.bearing.iter().find(|stop| name(stop) == column.name);
            own.map_or(0.0, |stop| stop.effort)
        };
        let row = |equilibrium: &Equilibrium| {
            let efforts = stops.iter().map(|column| effort(equilibrium, column));
            cells(equilibrium).into_iter().chain(efforts).collect()
        };
        let rows = self.equilibria.iter().map(row).collect();
        let columns = columns(self.equilibria.first(), &self.joints);
        Table { columns: columns.into_iter().chain(stops).collect(), rows }
    }
}
