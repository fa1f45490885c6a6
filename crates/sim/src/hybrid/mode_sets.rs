//! [`ModeSets`]: all combinations of some choices, in order.

/// Combinations that are tried before a search is given up.
const MAX_SETS: usize = 4096;

/// Every way to take one of `n_choices[k]` choices for all k, as the index of each choice.
///
/// The first set takes every first choice, and the choice of the smallest k changes fastest: a
/// counter in mixed base. It ends after [`MAX_SETS`].
#[derive(Clone, Debug)]
pub(super) struct ModeSets {
    n_choices: Vec<usize>,
    next: Option<Vec<usize>>,
    n_left: usize,
}

impl ModeSets {
    pub(super) fn new(n_choices: Vec<usize>) -> Self {
        let has_choices = n_choices.iter().all(|&n| n > 0);
        let next = has_choices.then(|| vec![0; n_choices.len()]);
        Self { n_choices, next, n_left: MAX_SETS }
    }

    /// True if there are more combinations than are tried.
    pub(super) fn are_too_many(n_choices: &[usize]) -> bool {
        let n_sets = n_choices.iter().try_fold(1_usize, |sets, &n| sets.checked_mul(n));
        n_sets.is_none_or(|n_sets| n_sets > MAX_SETS)
    }
}

impl Iterator for ModeSets {
    type Item = Vec<usize>;

    fn next(&mut self) -> Option<Vec<usize>> {
        self.n_left = self.n_left.checked_sub(1)?;
        let set = self.next.take()?;
        // The first digit that can rise does, those before it start again.
        let rising = set.iter().zip(&self.n_choices).position(|(choice, n)| choice + 1 < *n);
        self.next = rising.map(|k| {
            let mut next = set.clone();
            next[..k].fill(0);
            next[k] += 1;
            next
        });
        Some(set)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_count_in_mixed_base_with_the_first_choice_fastest() {
        let sets: Vec<Vec<usize>> = ModeSets::new(vec![2, 3]).collect();
        assert_eq!(sets, [[0, 0], [1, 0], [0, 1], [1, 1], [0, 2], [1, 2]]);
    }

    #[test]
    fn no_choices_leave_one_set_and_none_to_choose_from_leaves_none() {
        assert_eq!(ModeSets::new(Vec::new()).collect::<Vec<_>>(), [Vec::<usize>::new()]);
        assert_eq!(ModeSets::new(vec![2, 0]).count(), 0);
    }

    #[test]
    fn large_counts_end_at_the_bound() {
        // More sets than an integer can count.
        assert_eq!(ModeSets::new(vec![3; 1000]).count(), MAX_SETS);
        assert_eq!(ModeSets::new(vec![2; 11]).count(), 2048);
    }
}
