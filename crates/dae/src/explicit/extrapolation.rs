//! Extrapolation of the midpoint rule (W. B. Gragg 1965, R. Bulirsch and J. Stoer 1966), several columns at
//! once.
//!
//! ```text
//! column j = 1 … s:  n_j = 2 j,  h_j = h/n_j
//! x_0 = y0,  x_1 = y0 + h_j f0,  x_{i+1} = x_{i−1} + 2 h_j f(t0 + i h_j, x_i),  T_j1 = x_{n_j}
//! T_{j,l+1} = T_jl + (T_jl − T_{j−1,l}) / ((n_j/n_{j−l})² − 1),  y1 = T_ss of order 2 s
//! err = ‖T_ss − T_{s,s−1}‖
//! ```
//!
//! HNW1 §II.9. Columns know nothing of each other until they are extrapolated, so that as many of them go on
//! together as there are lanes; a lane whose column has ended goes on with the next of its own. A lane
//! without work stays at its last end, where it shows by the way how fast `f` changes with the state.

use super::lanes::LaneWork;
use super::sums::{Columns, extrapolate};
use crate::stats::Stats;
use crate::system::{LANES, Lanes, NotFinite, Ode};

/// The method with one number of columns, and the buffers of a step.
pub(super) struct Extrapolation {
    n_columns: usize,
    /// Columns of each lane in the order of their turns, counted from one.
    turns: [Vec<usize>; LANES],
    /// `x_{i−1}`, unknown by unknown.
    before: Vec<Lanes>,
    /// `x_i` and `f` there.
    now: LaneWork,
    /// `T_j1`.
    table: Columns,
}

/// Places for the results of a step.
pub(super) struct Ends<'a> {
    pub(super) y1: &'a mut Columns,
    pub(super) error: &'a mut Columns,
    /// A state near the end of the step, at the same time, and `f` there.
    pub(super) near: &'a mut [f64],
    pub(super) f_near: &'a mut [f64],
}

/// Where the columns under way stand.
#[derive(Clone, Copy, Debug)]
struct Progress {
    /// Turns that have begun.
    turn: [usize; LANES],
    /// Steps of the column that have been taken, and how many it has; no count where a lane has no work.
    i: [usize; LANES],
    n: [usize; LANES],
    /// Their start and size; of size zero in a lane without work.
    t0: Lanes,
    h: Lanes,
}

impl Extrapolation {
    /// For `n` unknowns.
    pub(super) fn new(n: usize, n_columns: usize) -> Self {
        Self {
            n_columns,
            turns: turns(n_columns),
            before: vec![[0.0; LANES]; n],
            now: LaneWork::new(n),
            table: Columns::new(n, n_columns),
        }
    }

    /// Evaluations in sequence that a step takes, that at its end among them.
    pub(super) fn n_stages(&self) -> usize {
        2 * self.n_columns
    }

    /// A step from `(y0, f0)`.
    ///
    /// # Errors
    /// [`NotFinite`] where `f` has no value at an argument, see [`Extrapolation::argument_into`].
    pub(super) fn step<S: Ode>(
        &mut self,
        system: &mut S,
        (t, h): (f64, f64),
        start: (&[f64], &[f64]),
        ends: &mut Ends<'_>,
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        let mut at = Progress {
            turn: [0; LANES],
            i: [0; LANES],
            n: [0; LANES],
            t0: [t; LANES],
            h: [0.0; LANES],
        };
        for lane in 0..LANES {
            self.begin(&mut at, lane, h, start);
        }
        // The lane whose column is the highest of those that have ended.
        let mut near = (0, 0);
        while at.h.iter().any(|&h| h != 0.0) {
            let times = std::array::from_fn(|lane| at.t0[lane] + at.i[lane] as f64 * at.h[lane]);
            self.now.evaluate(system, times, stats)?;
            self.now.midpoint(&at.h, &mut self.before);
            for lane in 0..LANES {
                at.i[lane] += 1;
                if at.i[lane] == at.n[lane] {
                    let column = at.n[lane] / 2;
                    self.end(column, lane);
                    if near.0 < column && column < self.n_columns {
                        near = (column, lane);
                    }
                    self.begin(&mut at, lane, h, start);
                }
            }
        }
        self.now.lane_into(near.1, ends.near, ends.f_near);
        extrapolate(&self.table, ends.y1, ends.error);
        Ok(())
    }

    /// Begins the next column of a lane, if there is one.
    fn begin(&mut self, at: &mut Progress, lane: usize, h: f64, (y0, f0): (&[f64], &[f64])) {
        let Some(&column) = self.turns[lane].get(at.turn[lane]) else {
            self.rest(at, lane, h, y0);
            return;
        };
        let size = h / (2 * column) as f64;
        at.turn[lane] += 1;
        (at.i[lane], at.n[lane], at.h[lane]) = (1, 2 * column, size);
        let states = self.before.iter_mut().zip(&mut self.now.y);
        for ((before, now), (y0, f0)) in states.zip(y0.iter().zip(f0)) {
            before[lane] = *y0;
            now[lane] = y0 + size * f0;
        }
    }

    /// Leaves a lane where its last column has ended, or at the start if it never had one.
    fn rest(&mut self, at: &mut Progress, lane: usize, h: f64, y0: &[f64]) {
        (at.n[lane], at.h[lane]) = (usize::MAX, 0.0);
        if at.turn[lane] == 0 {
            self.now.y.iter_mut().zip(y0).for_each(|(now, y0)| now[lane] = *y0);
        } else {
            at.t0[lane] += h;
        }
        self.before.iter_mut().zip(&self.now.y).for_each(|(before, now)| before[lane] = now[lane]);
    }

    /// Takes down the end of a column.
    fn end(&mut self, column: usize, lane: usize) {
        let ends = self.table.column_mut(column - 1).iter_mut();
        ends.zip(&self.now.y).for_each(|(end, now)| *end = now[lane]);
    }

    /// The argument at which `f` had no value.
    pub(super) fn argument_into(&self, argument: &mut [f64]) {
        self.now.argument_into(argument);
    }
}

/// The columns dealt out so that lanes have about the same work, the longest of each last.
fn turns(n_columns: usize) -> [Vec<usize>; LANES] {
    let mut turns: [Vec<usize>; LANES] = Default::default();
    for column in (1..=n_columns).rev() {
        let work = |turns: &Vec<usize>| turns.iter().map(|column| 2 * column - 1).sum::<usize>();
        if let Some(least) = turns.iter_mut().min_by_key(|turns| work(turns)) {
            least.insert(0, column);
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seven_columns_take_as_long_as_the_longest_of_them() {
        let turns = turns(7);
        assert_eq!(turns, [vec![7], vec![1, 6], vec![2, 5], vec![3, 4]].map(|columns| columns));
    }
}
