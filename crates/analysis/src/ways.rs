//! Ways on from a pose: their names by rates of joints, and the faults of poses that none or several lead on from.

use bksim_mbs::coordinate::{Coordinate, CoordinateKind};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use nalgebra::DVector;

use crate::around::{Around, Way, around};
use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::path::{Law, NoPath, Path};
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::rows::Clock;
use crate::scalar::Scalars;
use crate::way_rates::{ASIDE, WayRates};

/// Part of the largest rate below which one counts as none.
const NO_RATE: f64 = 1e-5;

/// Positions whose rates name a way.
pub(crate) struct Named<'a> {
    quantities: &'a [PoseQuantity],
    n_of_joints: usize,
    scalars: Scalars,
    /// The longest link, m.
    size: f64,
    t: f64,
    /// Units of the coordinates: 1 rad or the longest link.
    units: Vec<f64>,
}

impl Positions {
    /// The names of ways.
    fn named(&self) -> Result<Named<'_>, AnalysisError> {
        let scalars = self.scalars(&self.quantities)?;
        let of = (self.model(), self.system());
        Ok(Named::of(of, &self.quantities, scalars, (self.size, self.t())))
    }

    /// Refuses a start that yields, but goes nowhere, and one in which branches cross, by its joints and by all its drives.
    ///
    /// # Errors
    /// [`AnalysisError::GoesNowhere`] or [`AnalysisError::BranchPoint`].
    pub(crate) fn leads_on(&self) -> Result<(), AnalysisError> {
        let all: Vec<usize> = (0..self.model().drives.len()).collect();
        let released: &[&[usize]] = if all.is_empty() { &[&[]] } else { &[&all, &[]] };
        for released in released {
            let mut rows = self.rows(&[], released, Clock::Held)?;
            let law = Law { t: self.t(), ..Law::default() };
            let x = rows.scaled(&self.q);
            let mut path = Path::of_all(&mut rows, (law, false));
            let z = path.unknowns(&x);
            let no_path = match around(&mut path, &z) {
                Around::Nowhere(directions) => NoPath::Nowhere(directions),
                Around::Crossing(ways) if ways.len() > 1 => NoPath::Crossing(ways),
                Around::Crossing(_) | Around::Regular(_) => continue,
            };
            return Err(
                self.no_path(no_path, ASIDE, |n_free| AnalysisError::NotOneMotion { n_free })
            );
        }
        Ok(())
    }

    /// The fault that poses around the start are no curve.
    pub(crate) fn no_path(
        &self,
        no_path: NoPath,
        cure: &'static str,
        of_number: impl Fn(usize) -> AnalysisError,
    ) -> AnalysisError {
        self.named().map_or_else(|e| e, |mut named| named.fault(no_path, &self.q, cure, of_number))
    }
}

impl Loaded {
    /// The names of ways.
    pub(crate) fn named(&self) -> Result<Named<'_>, AnalysisError> {
        let scalars = self.scalars(&self.quantities)?;
        let of = (self.model(), self.system());
        Ok(Named::of(of, &self.quantities, scalars, (self.size, self.t)))
    }

    /// The fault that poses around the start are no curve.
    pub(crate) fn no_path(
        &self,
        no_path: NoPath,
        of_number: impl Fn(usize) -> AnalysisError,
    ) -> AnalysisError {
        self.named().map_or_else(|e| e, |mut named| named.fault(no_path, &self.q, ASIDE, of_number))
    }
}

/// Units of coordinates: 1, and the longest link of lengths.
fn units(coordinates: &[Coordinate], size: f64) -> Vec<f64> {
    let is_length = |kind| kind == CoordinateKind::Length;
    coordinates.iter().map(|c| if is_length(c.kind) { size } else { 1.0 }).collect()
}

impl<'a> Named<'a> {
    /// The names of ways by `quantities`, whose functions are `scalars`; the longest link, and the time.
    pub(crate) fn of(
        (model, system): (&Model, &SymbolicSystem),
        quantities: &'a [PoseQuantity],
        scalars: Scalars,
        (size, t): (f64, f64),
    ) -> Self {
        let n_of_joints = model.joints.iter().map(|joint| joint.kind.motions().len()).sum();
        let units = units(system.coordinates(), size);
        Self { quantities, n_of_joints, scalars, size, t, units }
    }

    /// The fault of a pose that is no point of one curve.
    pub(crate) fn fault(
        &mut self,
        no_path: NoPath,
        q: &[f64],
        cure: &'static str,
        of_number: impl Fn(usize) -> AnalysisError,
    ) -> AnalysisError {
        match no_path {
            NoPath::Free(n_free) => of_number(n_free),
            NoPath::Nowhere(directions) => self.nowhere(q, &directions),
            NoPath::Crossing(ways) => {
                AnalysisError::BranchPoint { ways: self.of_ways(q, &ways), cure }
            }
            NoPath::Still(number) => AnalysisError::StillBranch { number },
            NoPath::NoWay(number, ways) => AnalysisError::NoBranch { number, n: ways.len() },
        }
    }

    /// The fault of a pose that yields in some directions, but goes nowhere.
    pub(crate) fn nowhere(&mut self, q: &[f64], directions: &[DVector<f64>]) -> AnalysisError {
        let mut moves: Vec<String> = Vec::new();
        for direction in directions {
            for (name, ..) in self.rates(q, direction) {
                if !moves.contains(&name) {
                    moves.push(name);
                }
            }
        }
        AnalysisError::GoesNowhere { moves }
    }

    /// The rates of all ways.
    pub(crate) fn of_ways(&mut self, q: &[f64], ways: &[Way]) -> Vec<WayRates> {
        ways.iter().map(|way| self.rates(q, &way.tangent)).collect()
    }

    /// Rates of joints along a direction, in units of the mechanism; of bodies where no joint moves.
    pub(crate) fn rates(&mut self, q: &[f64], direction: &DVector<f64>) -> WayRates {
        let along: Vec<f64> = direction.iter().zip(&self.units).map(|(d, unit)| d * unit).collect();
        let rates = self.scalars.along(self.t, q, &along);
        let weighed = |k: &usize| {
            let unit = if self.quantities[*k].is_angle() { 1.0 } else { self.size };
            (rates[*k] / unit).abs()
        };
        let moving = |range: std::ops::Range<usize>| -> Vec<usize> {
            let range = range.filter(|&k| rates[k].is_finite());
            let largest = range.clone().map(|k| weighed(&k)).fold(0.0, f64::max);
            range.filter(|k| largest > 0.0 && weighed(k) > NO_RATE * largest).collect()
        };
        let n_of_joints = self.n_of_joints.min(rates.len());
        let of_joints = moving(0..n_of_joints);
        // Of bodies without joints their own places, not those of their points.
        let is_of_body = |k: &usize| self.quantities[*k].names[0].matches('.').count() == 1;
        let of_bodies = || -> Vec<usize> {
            moving(n_of_joints..rates.len()).into_iter().filter(is_of_body).collect()
        };
        let shown = if of_joints.is_empty() { of_bodies() } else { of_joints };
        let first = shown.first().map_or(1.0, |&k| rates[k]);
        let named = |&k: &usize| {
            let own = &self.quantities[k];
            (own.names[0].clone(), rates[k] / first, own.unit)
        };
        shown.iter().map(named).collect()
    }
}
