//! The multiplier system of a compiled mechanism, by the plan that it keeps.

use super::MultiplierSystem;
use crate::compiled::CompiledSystem;

impl CompiledSystem {
    /// The multiplier system without the `inactive` rows.
    pub(crate) fn multiplier_system(&self, inactive: &[usize]) -> MultiplierSystem {
        let mut takes_part = vec![true; self.shape.nc];
        for &row in inactive {
            takes_part[row] = false;
        }
        let active: Vec<usize> = (0..self.shape.nc).filter(|&row| takes_part[row]).collect();
        let elimination = self.elimination.of(&self.shape, &active);
        MultiplierSystem::new(&self.shape, active, elimination)
    }
}
