//! [`Stops`]: stops that are open at the start, as functions of the pose.
//!
//! ```text
//! φ(t, q)     penetration, rad or m: negative while there is a gap
//! λ ≥ 0       the effort of a closed stop, which keeps φ from growing
//! ```

use bksim_mbs::contact::Law;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{LoadId, Model, MotionKind};

use crate::equilibrium::{BearingStop, PassedStop};
use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::scalar::Scalars;

/// Penetration that is rounding, rad or parts of the longest link.
const CLOSED: f64 = 1e-9;

/// The limits of stops that no row of the equations holds.
#[derive(Clone, Debug)]
pub(crate) struct Stops {
    limits: Vec<Limit>,
    /// φ of each.
    penetrations: Scalars,
    t: f64,
}

/// One limit of a stop.
#[derive(Clone, Debug)]
struct Limit {
    /// Constraint row of the limit.
    row: usize,
    name: String,
    /// `min` or `max`.
    direction: &'static str,
    motion: MotionKind,
    /// 1 rad or the longest link.
    unit: f64,
}

impl Stops {
    /// Stops whose rows `loaded` does not hold.
    pub(crate) fn of(loaded: &Loaded) -> Result<Self, AnalysisError> {
        let system = loaded.system();
        let is_open = |row: usize| !loaded.kept.contains(&row);
        let contacts = system.contacts.iter().filter(|contact| is_open(contact.row));
        let contacts: Vec<_> =
            contacts.filter(|contact| matches!(contact.law, Law::Stop { .. })).collect();
        let limit = |row: usize, load: LoadId| {
            let motion = system.constraints[row].effort;
            Limit {
                row,
                name: loaded.model().loads[load.0].name.clone(),
                direction: system.constraints[row].direction,
                motion,
                unit: if motion == MotionKind::Rotation { 1.0 } else { loaded.size },
            }
        };
        let functions: Vec<_> = contacts.iter().map(|contact| contact.expression).collect();
        Ok(Self {
            limits: contacts.iter().map(|contact| limit(contact.row, contact.load)).collect(),
            penetrations: Scalars::compile(loaded.model(), system, &functions, &loaded.parameters)?,
            t: loaded.t,
        })
    }

    /// Gives the parameters other values.
    pub(crate) fn set_parameters(&mut self, parameters: &[f64]) {
        self.penetrations.set_parameters(parameters);
    }

    /// Number of limits.
    pub(crate) fn n(&self) -> usize {
        self.limits.len()
    }

    /// The constraint row of a limit.
    pub(crate) fn row(&self, k: usize) -> usize {
        self.limits[k].row
    }

    /// The name of the stop.
    pub(crate) fn name(&self, k: usize) -> &str {
        &self.limits[k].name
    }

    /// Penetrations at a position, rad or parts of the longest link.
    pub(crate) fn penetrations(&mut self, q: &[f64]) -> Vec<f64> {
        let values = self.penetrations.values(self.t, q);
        values.iter().zip(&self.limits).map(|(value, limit)| value / limit.unit).collect()
    }

    /// Slopes of the penetrations along a direction of the coordinates.
    pub(crate) fn along(&mut self, q: &[f64], direction: &[f64]) -> Vec<f64> {
        self.penetrations.along(self.t, q, direction)
    }

    /// Slopes of the penetrations by all coordinates.
    pub(crate) fn gradients(&mut self, q: &[f64]) -> Vec<Vec<f64>> {
        self.penetrations.gradients(self.t, q)
    }

    /// True where one has neither a gap nor a penetration.
    pub(crate) fn is_closed(&mut self, k: usize, q: &[f64]) -> bool {
        self.penetrations(q)[k].abs() <= CLOSED
    }

    /// True where a position lies beyond none.
    pub(crate) fn allow(&mut self, q: &[f64]) -> bool {
        self.limits.is_empty() || self.penetrations(q).iter().all(|depth| *depth <= CLOSED)
    }

    /// Numbers of those that a position lies beyond.
    pub(crate) fn numbers_before(&mut self, q: &[f64]) -> Vec<usize> {
        let depths = self.penetrations(q);
        (0..depths.len()).filter(|&k| depths[k] > CLOSED).collect()
    }

    /// Stops that a position has passed.
    pub(crate) fn passed(&mut self, q: &[f64]) -> Vec<PassedStop> {
        let depths = self.penetrations(q);
        let limits = self.limits.iter().zip(depths).filter(|(_, depth)| *depth > CLOSED);
        let passed = |(limit, depth): (&Limit, f64)| PassedStop {
            name: limit.name.clone(),
            limit: limit.direction,
            depth: depth * limit.unit,
            unit: if limit.motion == MotionKind::Rotation { "rad" } else { "m" },
        };
        limits.map(passed).collect()
    }
}

/// The stops among the constraint rows `kept` with their multipliers, those of all rows.
pub(crate) fn bearing(
    (model, system): (&Model, &SymbolicSystem),
    kept: &[usize],
    lambda: &[f64],
) -> Vec<BearingStop> {
    let stops = system.contacts.iter().filter(|contact| kept.contains(&contact.row));
    let stops = stops.filter(|contact| matches!(contact.law, Law::Stop { .. }));
    let bearing = |row: usize, load: LoadId| BearingStop {
        name: model.loads[load.0].name.clone(),
        limit: system.constraints[row].direction,
        effort: lambda[row],
        unit: if system.constraints[row].effort == MotionKind::Rotation { "N*m" } else { "N" },
    };
    stops.map(|contact| bearing(contact.row, contact.load)).collect()
}
