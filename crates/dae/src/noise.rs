//! [`Noise`]: what rounding leaves of errors, however small steps are.

use std::ops::AddAssign;

use crate::checkpoint::{Loader, Saver};
use crate::error::SolveError;

/// Repeated steps whose error has not fallen with their size: it holds noise of the equations.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Noise {
    /// How many there were.
    pub count: usize,
    /// The logarithms of their errors, in tolerances, in all.
    pub log_error: f64,
}

impl Noise {
    /// Takes note of one more, with its error in tolerances.
    pub(crate) fn count(&mut self, error: f64) {
        self.count += 1;
        self.log_error += error.ln();
    }

    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.count(self.count);
        saver.real(self.log_error);
    }

    pub(crate) fn load(loader: &mut Loader<'_>) -> Result<Self, SolveError> {
        Ok(Self { count: loader.count()?, log_error: loader.real()? })
    }

    /// The mean of their errors, in tolerances, as the logarithm has it.
    pub fn mean_error(&self) -> f64 {
        (self.log_error / self.count.max(1) as f64).exp()
    }
}

impl AddAssign for Noise {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.log_error += other.log_error;
    }
}
