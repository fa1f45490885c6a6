//! [`Ways`]: where the walks of a part have come to, and the assembly that each has led to in the end.
//!
//! Most shapes lead to few places. A walk that comes where another with the same goal has ended is not walked to
//! its end.

/// Goal of a walk: the rows hold, and the guesses next to them with some weight.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Goal {
    /// The rows alone, from a shape.
    Rows,
    /// Rows and guesses.
    Guesses,
    /// Guesses of a tenth of their weight, from where they had all of it.
    Tenth,
    /// Guesses of a hundredth.
    Hundredth,
    /// The rows alone, from where guesses had a hundredth: the end of all ways.
    Assembly,
}

impl Goal {
    /// From a shape towards rows and guesses, then down to the rows alone.
    pub(super) const BY_GUESSES: [Self; 4] =
        [Self::Guesses, Self::Tenth, Self::Hundredth, Self::Assembly];
    /// To the rows first, as guesses far off can lead where nothing closes.
    pub(super) const BY_ROWS: [Self; 3] = [Self::Rows, Self::Hundredth, Self::Assembly];

    /// Weight of the guesses; that of the rows is one.
    pub(super) fn wish_weight(self) -> f64 {
        match self {
            Self::Rows | Self::Assembly => 0.0,
            Self::Guesses => 1.0,
            Self::Tenth => 0.1,
            Self::Hundredth => 0.01,
        }
    }
}

/// End of a walk.
#[derive(Clone, Debug)]
pub(super) struct End {
    pub(super) goal: Goal,
    /// Coordinates of the part.
    pub(super) q: Vec<f64>,
}

/// Outcome of a way: the place of an assembly, or none where the rows do not hold in the end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Outcome(pub(super) Option<usize>);

/// Ends of walks with the outcomes of their ways.
#[derive(Debug, Default)]
pub(super) struct Ways {
    ends: Vec<(End, Outcome)>,
}

impl Ways {
    /// Takes note of the ends along a way.
    pub(super) fn add(&mut self, ends: Vec<End>, outcome: Outcome) {
        self.ends.extend(ends.into_iter().map(|end| (end, outcome)));
    }

    /// The outcome from the end with this goal that `is_here`, if there is one.
    pub(super) fn from(&self, goal: Goal, is_here: impl Fn(&[f64]) -> bool) -> Option<Outcome> {
        let known = self.ends.iter().find(|(end, _)| end.goal == goal && is_here(&end.q));
        known.map(|&(_, outcome)| outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_known_for_its_goal_alone() {
        let mut ways = Ways::default();
        ways.add(vec![End { goal: Goal::Guesses, q: vec![1.0] }], Outcome(Some(2)));
        ways.add(vec![End { goal: Goal::Tenth, q: vec![1.0] }], Outcome(None));
        let from = |goal, x: f64| ways.from(goal, |q| (q[0] - x).abs() < 0.1);
        assert_eq!(from(Goal::Guesses, 1.05), Some(Outcome(Some(2))));
        assert_eq!(from(Goal::Tenth, 1.0), Some(Outcome(None)));
        assert_eq!((from(Goal::Guesses, 2.0), from(Goal::Assembly, 1.0)), (None, None));
    }
}
