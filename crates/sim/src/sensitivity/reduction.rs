//! [`Reduction`]: the linear equations of the changes at the nodes of a step, of independent coordinates alone.

use bksim_dae::LinearCoefficients;

use super::dependent::{ConstraintChanges, Dependents, Partition};

/// The equations of a step, with the partition that is kept from step to step.
#[derive(Debug, Default)]
pub(super) struct Reduction {
    partition: Option<Partition>,
    /// By node.
    dependents: Vec<Dependents>,
    coefficients: Vec<LinearCoefficients>,
}

impl Reduction {
    /// Takes the equations at the nodes, with the values of the constraints' changes there, one node after the other. The
    /// partition changes where dependent coordinates come to move far more than independent ones; `None` where there is
    /// none, as close to a singular pose or without constraints.
    pub(super) fn take(
        &mut self,
        changes: &ConstraintChanges,
        values: &[f64],
        rows: &[usize],
        full: &[LinearCoefficients],
    ) -> Option<&Partition> {
        if rows.is_empty() {
            return None;
        }
        let n = changes.function.n_outputs();
        let of_node = |node: usize| &values[node * n..][..n];
        self.dependents.resize_with(full.len(), Dependents::default);
        let kept = self.partition.take().filter(|kept| kept.is_by(rows));
        let kept = kept.filter(|kept| self.dependents_by(kept, changes, of_node));
        let middle = of_node(full.len() / 2);
        let partition = kept.or_else(|| {
            let chosen = Partition::choose(changes, middle, rows)?;
            self.dependents_by(&chosen, changes, of_node).then_some(chosen)
        })?;

        let (ni, m) = (partition.independent.len(), changes.n_directions());
        if self.coefficients.first().is_none_or(|of| of.by_position.len() != ni * ni) {
            self.coefficients = vec![LinearCoefficients::zeros(ni, m); full.len()];
        }
        let nodes = full.iter().zip(&self.dependents).zip(&mut self.coefficients);
        nodes.for_each(|((full, dependents), out)| partition.reduce(full, dependents, out));
        Some(self.partition.insert(partition))
    }

    fn dependents_by<'v>(
        &mut self,
        partition: &Partition,
        changes: &ConstraintChanges,
        of_node: impl Fn(usize) -> &'v [f64],
    ) -> bool {
        let mut nodes = self.dependents.iter_mut().enumerate();
        nodes.all(|(node, out)| partition.dependents_into(changes, of_node(node), out))
    }

    /// The partition of the equations that were taken last.
    pub(super) fn partition(&self) -> Option<&Partition> {
        self.partition.as_ref()
    }

    /// X, Y, ξ and η at the nodes.
    pub(super) fn dependents(&self) -> &[Dependents] {
        &self.dependents
    }

    /// K, C and B of the independent coordinates at the nodes.
    pub(super) fn coefficients(&self) -> &[LinearCoefficients] {
        &self.coefficients
    }
}
