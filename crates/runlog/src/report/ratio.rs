//! The times that a motion takes to and fro.

use super::Extreme;

/// The times of two strokes between the same limits, one after the other.
///
/// Their quotient is the time ratio T_R of a quick return (Norton, *Design of Machinery*, eq. 3.1), where a crank
/// turns evenly.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TimeRatio {
    /// From the least to the largest value, s.
    pub forward: f64,
    /// From the largest to the least value, s.
    pub back: f64,
}

impl TimeRatio {
    /// The longer time over the shorter one.
    pub fn value(self) -> f64 {
        self.forward.max(self.back) / self.forward.min(self.back)
    }
}

/// Part of the stroke within which a turning point is one of the limits.
const AT_LIMIT: f64 = 1e-6;

/// The time ratio of a motion by its turning points in order; of the last two strokes where there are more.
/// `period` is the time after which the motion repeats itself, if it does: one turn to and one fro are enough then.
pub(super) fn time_ratio(
    turns: &[Extreme],
    [least, largest]: [f64; 2],
    period: Option<f64>,
) -> Option<TimeRatio> {
    let margin = AT_LIMIT * (largest - least);
    if margin.is_nan() || margin <= 0.0 {
        return None;
    }
    // Turning points at the limits: whether at the upper one, and when.
    let mut at: Vec<(bool, f64)> = Vec::new();
    for turn in turns {
        let is_upper = largest - turn.value <= margin;
        let is_lower = turn.value - least <= margin;
        // A dwell at a limit ends where it is left.
        match at.last_mut() {
            Some(last) if last.0 == is_upper && (is_upper || is_lower) => last.1 = turn.t,
            _ if is_upper || is_lower => at.push((is_upper, turn.t)),
            _ => (),
        }
    }
    let stroke = |from: (bool, f64), to: (bool, f64)| (to.0, (to.1 - from.1).abs());
    let (last, before) = match at.as_slice() {
        [.., a, b, c] => (stroke(*b, *c), stroke(*a, *b).1),
        [a, b] => {
            let one = stroke(*a, *b);
            (one, period? - one.1)
        }
        _ => return None,
    };
    let (forward, back) = if last.0 { (last.1, before) } else { (before, last.1) };
    (forward > 0.0 && back > 0.0).then_some(TimeRatio { forward, back })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turns(of: &[(f64, f64)]) -> Vec<Extreme> {
        of.iter().map(|&(t, value)| Extreme { value, t, is_steady: false }).collect()
    }

    #[test]
    fn strokes_lie_between_turning_points_at_the_limits() {
        let three = turns(&[(0.5, -1.0), (2.0, 1.0), (3.0, -1.0)]);
        let ratio = time_ratio(&three, [-1.0, 1.0], None).expect("two strokes");
        assert_eq!((ratio.forward, ratio.back, ratio.value()), (1.5, 1.0, 1.5));
        // A turning point on the way is none of a stroke.
        let more = turns(&[(0.5, -1.0), (1.0, 0.2), (1.2, 0.1), (2.0, 1.0), (3.0, -1.0)]);
        assert_eq!(time_ratio(&more, [-1.0, 1.0], None), Some(ratio));
        // Of a motion that repeats itself one stroke tells the other.
        assert_eq!(time_ratio(&three[..2], [-1.0, 1.0], Some(2.5)), Some(ratio));
        assert_eq!(time_ratio(&three[..2], [-1.0, 1.0], None), None);
        assert_eq!(time_ratio(&[], [1.0, 1.0], Some(1.0)), None);
    }
}
