//! The times at which a number is one of many solutions of the equilibrium.

/// Spans of time, each from its smaller end to its larger one, out of the instants from which on something is
/// unique, or is not, in the order of a run over `span`, s.
pub(crate) fn not_unique(changes: &[(f64, bool)], [first, last]: [f64; 2]) -> Vec<[f64; 2]> {
    let ends = changes.iter().skip(1).map(|&(t, _)| t).chain([last]);
    let parts = changes.iter().zip(ends).filter(|((_, is_unique), _)| !is_unique);
    let mut spans: Vec<[f64; 2]> =
        parts.map(|(&(t, _), end)| if last < first { [end, t] } else { [t, end] }).collect();
    spans.sort_by(|[a, _], [b, _]| a.total_cmp(b));
    spans
}

#[cfg(test)]
mod tests {
    use super::not_unique;

    #[test]
    fn spans_end_where_a_number_becomes_unique_again() {
        let changes = [(0.0, true), (1.0, false), (2.0, true), (3.0, false)];
        assert_eq!(not_unique(&changes, [0.0, 4.0]), [[1.0, 2.0], [3.0, 4.0]]);
        assert_eq!(not_unique(&[(0.0, true)], [0.0, 4.0]), [[0.0; 2]; 0]);
        let backwards = [(4.0, false), (3.0, true), (2.0, false)];
        assert_eq!(not_unique(&backwards, [4.0, 0.0]), [[0.0, 2.0], [3.0, 4.0]]);
    }
}
