//! Coordinates and rows that belong together: what one part does is nothing to another.

use crate::linear::rows::SparseRows;

/// Coordinates that share rows with each other and with no others.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Part {
    /// Coordinates of the part.
    pub(super) columns: Vec<usize>,
    /// Rows that must hold: of constraints and of stated values.
    pub(super) rows: Vec<usize>,
    /// Rows of guesses.
    pub(super) wishes: Vec<usize>,
}

/// The parts that the entries of `gradients` connect, `is_fixed` columns aside; rows that `is_wish`
/// are guesses.
pub(super) fn parts(gradients: &SparseRows, is_fixed: &[bool], is_wish: &[bool]) -> Vec<Part> {
    let n = gradients.n_columns;
    let mut group = Groups { parent: (0..n).collect() };
    let free = |row: usize| {
        gradients.row(row).iter().map(|&(column, _)| column).filter(|&column| !is_fixed[column])
    };
    for row in 0..gradients.n_rows() {
        let mut columns = free(row);
        if let Some(first) = columns.next() {
            columns.for_each(|column| group.join(first, column));
        }
    }

    // One part per group, in the order of their first coordinates.
    let mut part_of_root = vec![usize::MAX; n];
    let mut parts: Vec<Part> = Vec::new();
    for column in (0..n).filter(|&column| !is_fixed[column]) {
        let root = group.root(column);
        if part_of_root[root] == usize::MAX {
            part_of_root[root] = parts.len();
            parts.push(Part { columns: Vec::new(), rows: Vec::new(), wishes: Vec::new() });
        }
        parts[part_of_root[root]].columns.push(column);
    }
    for row in 0..gradients.n_rows() {
        if let Some(column) = free(row).next() {
            let part = &mut parts[part_of_root[group.root(column)]];
            if is_wish[row] { &mut part.wishes } else { &mut part.rows }.push(row);
        }
    }
    parts
}

/// Disjoint sets; each has the smallest member as its root.
struct Groups {
    parent: Vec<usize>,
}

impl Groups {
    fn root(&mut self, mut of: usize) -> usize {
        while self.parent[of] != of {
            self.parent[of] = self.parent[self.parent[of]];
            of = self.parent[of];
        }
        of
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fixed_coordinate_separates_what_it_would_connect() {
        let entries = [(0, 0, 1.0), (0, 1, 1.0), (1, 1, 1.0), (1, 2, 1.0), (2, 2, 1.0)];
        let rows = SparseRows::from_entries(3, 4, entries);
        let together = parts(&rows, &[false; 4], &[false, false, true]);
        let all = Part { columns: vec![0, 1, 2], rows: vec![0, 1], wishes: vec![2] };
        let alone = Part { columns: vec![3], rows: vec![], wishes: vec![] };
        assert_eq!(together, [all, alone.clone()]);
        let apart = parts(&rows, &[false, true, false, false], &[false, false, true]);
        let first = Part { columns: vec![0], rows: vec![0], wishes: vec![] };
        let second = Part { columns: vec![2], rows: vec![1], wishes: vec![2] };
        assert_eq!(apart, [first, second, alone]);
    }
}
