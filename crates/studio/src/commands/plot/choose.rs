//! Which curves to draw, in which panels.

use bksim::log::{Column, Header, LogError, Selection};
use bksim::model::file::ShownUnit;
use bksim::overview::{self, Group, keep, overview};

use super::units::Units;

/// Panels of a figure at most, and curves of one.
pub(super) const MAX_PANELS: usize = overview::MAX_GROUPS;
pub(super) const MAX_CURVES: usize = 12;
/// Curves of a panel of an overview at most.
const OVERVIEW_CURVES: usize = 6;

/// A number at every instant: a channel, or the size of a vector of several.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Quantity {
    /// The channel, or what the vector's channels begin with.
    pub(super) name: String,
    /// SI.
    pub(super) unit: String,
    /// The unit that it is drawn in.
    pub(super) shown: ShownUnit,
    pub(super) channels: Vec<String>,
    /// True if it was named itself, not matched by a pattern.
    pub(super) is_named: bool,
}

/// Quantities of one unit.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct PanelPlan {
    /// A word for them, if a better one than the unit's usual word is known.
    pub(super) label: Option<String>,
    /// SI.
    pub(super) unit: String,
    /// The unit that they are drawn in.
    pub(super) shown: ShownUnit,
    pub(super) quantities: Vec<Quantity>,
}

/// The panels, and how many quantities were left out.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Plan {
    pub(super) panels: Vec<PanelPlan>,
    pub(super) n_left_out: usize,
}

impl Quantity {
    pub(super) fn channel(column: &Column, is_named: bool, units: &Units) -> Self {
        let Column { name, unit, .. } = column;
        let (name, unit) = (name.clone(), unit.clone());
        let shown = units.of(&name, &unit);
        Self { channels: vec![name.clone()], name, unit, shown, is_named }
    }
}

impl Plan {
    /// The quantities that the patterns name, in panels by their units.
    ///
    /// # Errors
    /// [`LogError::UnknownChannel`] for the first pattern that matches nothing in any log.
    pub(super) fn named(
        headers: &[&Header],
        patterns: &[String],
        units: &Units,
    ) -> Result<Self, LogError> {
        // The channels that each pattern names, in one log at least.
        let mut quantities: Vec<Quantity> = Vec::new();
        for pattern in patterns {
            let mut unknown = None;
            let mut is_known = false;
            for header in headers {
                match Selection::new(header, [pattern]) {
                    Err(error) => {
                        unknown.get_or_insert(error);
                    }
                    Ok(selection) => {
                        is_known = true;
                        let dotted = pattern.trim_start_matches('/').replace('/', ".");
                        for column in selection.columns() {
                            if !quantities.iter().any(|known| known.name == column.name) {
                                let is_named = column.name == dotted;
                                quantities.push(Quantity::channel(column, is_named, units));
                            }
                        }
                    }
                }
            }
            if let Some(unknown) = unknown.filter(|_| !is_known) {
                return Err(unknown);
            }
        }
        // A panel for each unit, up to a number that a page holds.
        let mut plan = Self::default();
        for quantity in quantities {
            let is_of = |panel: &&mut PanelPlan| {
                panel.unit == quantity.unit && panel.shown == quantity.shown
            };
            let panel = plan.panels.iter_mut().find(is_of);
            match panel {
                Some(panel) => panel.quantities.push(quantity),
                None => plan.panels.push(PanelPlan {
                    label: None,
                    unit: quantity.unit.clone(),
                    shown: quantity.shown.clone(),
                    quantities: vec![quantity],
                }),
            }
        }
        let beyond = plan.panels.split_off(plan.panels.len().min(MAX_PANELS));
        plan.n_left_out = beyond.iter().map(|panel| panel.quantities.len()).sum();
        let most = (MAX_CURVES / headers.len().max(1)).max(1);
        plan.keep(most);
        Ok(plan)
    }

    /// Coordinates and rates, energies, and efforts of drives or sizes of reactions.
    pub(super) fn overview(header: &Header, n_runs: usize, units: &Units) -> Self {
        let columns = Selection::all(header);
        let columns = columns.columns().iter().map(|c| (c.name.clone(), c.unit.clone()));
        let most = (OVERVIEW_CURVES / n_runs.max(1)).max(1);
        let (groups, n_left_out) = overview(&columns.collect::<Vec<_>>(), most);
        let shown = |of: overview::Quantity| {
            let overview::Quantity { name, unit, channels } = of;
            let shown = units.of(&name, &unit);
            Quantity { name, unit, shown, channels, is_named: true }
        };
        let panel = |Group { label, unit, quantities }: Group| PanelPlan {
            label: label.map(str::to_owned),
            shown: units.of("", &unit),
            unit,
            quantities: quantities.into_iter().map(shown).collect(),
        };
        Self { panels: groups.into_iter().map(panel).collect(), n_left_out }
    }

    /// Keeps that many quantities of each panel, spread evenly over all.
    fn keep(&mut self, most: usize) {
        for panel in &mut self.panels {
            self.n_left_out += keep(&mut panel.quantities, most);
        }
    }

    /// All quantities.
    pub(super) fn quantities(&self) -> impl Iterator<Item = &Quantity> {
        self.panels.iter().flat_map(|panel| &panel.quantities)
    }
}
