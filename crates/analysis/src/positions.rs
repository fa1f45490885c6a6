//! [`Positions`]: a mechanism at its start, as far as joints and drives tell.

use bksim_expr::Expr;
use bksim_mbs::constraint::Source;
use bksim_mbs::contact::Penetration;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Measure, Model};
use bksim_sim::Mechanism;

use crate::error::AnalysisError;
use crate::quantity::{PoseQuantity, pose_quantities};
use crate::rows::{Clock, Rows, rank};
use crate::scalar::{Rates, Scalars};

/// A mechanism with its closed start and its quantities; no masses take part.
#[derive(Debug)]
pub struct Positions {
    pub(crate) mechanism: Mechanism,
    /// Generalised coordinates of the start.
    pub(crate) q: Vec<f64>,
    /// The longest link, m: the unit of lengths.
    pub(crate) size: f64,
    /// Everything that a pose shows.
    pub(crate) quantities: Vec<PoseQuantity>,
}

impl Positions {
    /// Closes `model` at its start.
    ///
    /// # Errors
    /// [`AnalysisError::Rejected`] when it does not close.
    pub fn of(model: Model) -> Result<Self, AnalysisError> {
        let mechanism = Mechanism::positions(model)?;
        let closed = mechanism.closed()?;
        let quantities = pose_quantities(&mechanism.model, &mechanism.system);
        let size = if closed.longest_link > 0.0 { closed.longest_link } else { 1.0 };
        Ok(Self { q: closed.q, size, quantities, mechanism })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.mechanism.model
    }

    pub(crate) fn system(&self) -> &SymbolicSystem {
        &self.mechanism.system
    }

    /// Time of the start, s.
    pub(crate) fn t(&self) -> f64 {
        self.model().solve.t_start
    }

    /// All quantities of a pose.
    pub fn quantities(&self) -> &[PoseQuantity] {
        &self.quantities
    }

    /// The value of a measure at the start.
    pub(crate) fn value(&self, measure: Measure) -> Result<f64, AnalysisError> {
        let quantity = self.quantity_of("", measure);
        Ok(self.scalars(&[quantity])?.values(self.t(), &self.q)[0])
    }

    /// The value of an expression of parameters.
    pub(crate) fn constant(&self, e: Expr) -> f64 {
        let known = self.model().parameters.iter().zip(&self.mechanism.parameters);
        let value = |symbol| {
            known.clone().find(|(parameter, _)| parameter.symbol == symbol).map(|(_, value)| *value)
        };
        self.model().pool.evaluate(e, &value).unwrap_or(f64::NAN)
    }

    pub(crate) fn rows(
        &self,
        prescribed: &[Measure],
        released: &[usize],
        clock: Clock,
    ) -> Result<Rows, AnalysisError> {
        self.rows_with_stops((prescribed, &[]), released, clock)
    }

    /// Rows of [`Positions::rows`], with the limits of stops that bear.
    pub(crate) fn rows_with_stops(
        &self,
        prescribed: (&[Measure], &[Penetration]),
        released: &[usize],
        clock: Clock,
    ) -> Result<Rows, AnalysisError> {
        let parameters = &self.mechanism.parameters;
        let numbers = (parameters.as_slice(), self.size, clock);
        let is_kept = |row: &usize| match self.system().constraints[*row].source {
            Source::Drive(drive) => !released.contains(&drive.0),
            _ => true,
        };
        let kept: Vec<usize> = (0..self.system().constraints.len()).filter(is_kept).collect();
        Ok(Rows::with_stops(self.model(), self.system(), prescribed, &kept, numbers)?)
    }

    pub(crate) fn scalars(&self, quantities: &[PoseQuantity]) -> Result<Scalars, AnalysisError> {
        let functions: Vec<_> = quantities.iter().map(|quantity| quantity.value).collect();
        Ok(Scalars::compile(self.model(), self.system(), &functions, &self.mechanism.parameters)?)
    }

    pub(crate) fn rates(&self, quantities: &[PoseQuantity]) -> Result<Rates, AnalysisError> {
        self.rates_with(quantities, false)
    }

    /// Rates of quantities, where it is asked for with the third ones.
    pub(crate) fn rates_with(
        &self,
        quantities: &[PoseQuantity],
        has_jerk: bool,
    ) -> Result<Rates, AnalysisError> {
        let functions: Vec<_> = quantities.iter().map(|quantity| quantity.value).collect();
        let order = (self.mechanism.parameters.as_slice(), if has_jerk { 3 } else { 2 });
        Ok(Rates::of_order(self.model(), self.system(), &functions, order)?)
    }

    /// Lets rows give the third rates of coordinates.
    pub(crate) fn add_jerks(&self, rows: &mut Rows) -> Result<(), AnalysisError> {
        Ok(rows.add_jerks(self.model(), self.system(), &self.mechanism.parameters)?)
    }

    /// A prescribed measure as a quantity, with the names that it has among those of a pose.
    pub(crate) fn quantity_of(&self, name: &str, measure: Measure) -> PoseQuantity {
        if let Some(known) = self.quantities.iter().find(|known| known.names[0] == name) {
            return known.clone();
        }
        let names = [name.to_owned(), format!("{name}_dot"), format!("{name}_ddot")];
        let value = self.system().kinematics.measure(self.model(), measure);
        PoseQuantity { names, unit: measure.fixed_unit(self.model()), value }
    }

    /// Drives of the model that the prescribed measures take the place of: those without which the measures
    /// are free to be prescribed.
    pub(crate) fn replaced_drives(
        &self,
        prescribed: &[Measure],
    ) -> Result<Vec<usize>, AnalysisError> {
        let mut released = Vec::new();
        if self.model().drives.is_empty() {
            return Ok(released);
        }
        // All rows once; the first of the measures are taken, and the drives that are not released.
        let mut rows = self.rows(prescribed, &[], Clock::Held)?;
        let x = rows.scaled(&self.q);
        let jacobian = rows.at(self.t(), &x, &vec![0.0; prescribed.len()]).jacobian;
        let constraints = &self.system().constraints;
        let rank_with = |n_measures: usize, released: &[usize]| {
            let is_taken = |row: &usize| match constraints.get(*row).map(|c| c.source) {
                Some(Source::Drive(drive)) => !released.contains(&drive.0),
                Some(_) => true,
                None => *row < constraints.len() + n_measures,
            };
            let taken: Vec<usize> = (0..jacobian.nrows()).filter(is_taken).collect();
            rank(&jacobian.select_rows(&taken))
        };
        for k in 0..prescribed.len() {
            if rank_with(k + 1, &released) > rank_with(k, &released) {
                continue;
            }
            for drive in 0..self.model().drives.len() {
                let without = [released.clone(), vec![drive]].concat();
                if !released.contains(&drive) && rank_with(k + 1, &without) > rank_with(k, &without)
                {
                    released = without;
                    break;
                }
            }
        }
        Ok(released)
    }
}
