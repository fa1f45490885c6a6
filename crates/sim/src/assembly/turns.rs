//! Whole turns: a closed position stays closed when a coordinate turns once around, and of all these
//! positions the author means the one with the angles as written.

use std::f64::consts::TAU;

use super::scale::whole_turns;

/// Most coordinates that turns are sorted out for.
const MOST: usize = 400;

/// An angle that is off by whole turns.
pub(super) struct AngleRow {
    /// Slopes by coordinates that turn.
    pub(super) slopes: Vec<(usize, f64)>,
    /// Value less what it should be, rad.
    pub(super) value: f64,
}

/// Whole turns to add to each of `n` coordinates so that all rows come right, those before others
/// first; the rows that cannot, with the turns that they keep.
///
/// Angles along a tree are sums of coordinates with slopes of ±1, so that the elimination stays with
/// whole numbers (matrices of paths in a tree are totally unimodular; A. Schrijver, *Theory of Linear
/// and Integer Programming*, 1986, §19.3).
pub(super) fn turns(rows: &[AngleRow], n: usize) -> (Vec<f64>, Vec<(usize, f64)>) {
    let mut turns = vec![0.0; n];
    let off = |row: &AngleRow| whole_turns(row.value);
    if n > MOST || rows.iter().all(|row| off(row) == 0.0) {
        return (turns, Vec::new());
    }

    // Each row freed of the pivots of those before; one without a pivot says the same as they do.
    let mut eliminated: Vec<(usize, Vec<f64>)> = Vec::new();
    let mut kept = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        let mut rest = vec![0.0; n + 1];
        row.slopes.iter().for_each(|&(column, slope)| rest[column] = slope.round());
        rest[n] = -off(row);
        for (pivot, done) in &eliminated {
            let share = rest[*pivot] / done[*pivot];
            rest.iter_mut().zip(done).for_each(|(rest, done)| *rest -= share * done);
        }
        match (0..n).find(|&column| rest[column].abs() > 0.5) {
            Some(pivot) => eliminated.push((pivot, rest)),
            None if rest[n].abs() > 0.5 => kept.push((k, -rest[n].round())),
            None => (),
        }
    }
    for (pivot, row) in eliminated.iter().rev() {
        let known: f64 = (0..n).filter(|i| i != pivot).map(|i| row[i] * turns[i]).sum();
        turns[*pivot] = ((row[n] - known) / row[*pivot]).round();
    }
    (turns, kept)
}

/// Adds whole turns.
pub(super) fn turn(q: &mut [f64], turns: &[f64]) {
    q.iter_mut().zip(turns).filter(|(_, n)| **n != 0.0).for_each(|(q, n)| *q += TAU * n);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(slopes: &[(usize, f64)], n_turns: f64) -> AngleRow {
        AngleRow { slopes: slopes.to_vec(), value: TAU * n_turns + 0.1 }
    }

    #[test]
    fn every_row_comes_right_or_is_named() {
        // A loop of a crank that stays, two sums of angles, and one that follows from them.
        let rows = [
            row(&[(0, 1.0)], 0.0),
            row(&[(0, 1.0), (1, 1.0)], 2.0),
            row(&[(1, 1.0), (2, -1.0)], -1.0),
            row(&[(0, 1.0), (2, 1.0)], 0.0),
        ];
        let (found, kept) = turns(&rows, 3);
        assert_eq!(found, [0.0, -2.0, -3.0]);
        assert_eq!(kept, [(3, -3.0)]);
    }
}
