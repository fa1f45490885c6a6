//! [`Walk`]: positions of a prescribed motion, followed in time.

use crate::motion::Motion;
use crate::rows::{Rows, Solver};

/// Positions followed in time.
pub(crate) struct Walk<'a> {
    /// In units of the mechanism.
    pub(crate) x: Vec<f64>,
    pub(crate) t: f64,
    pub(crate) motions: &'a [Motion],
}

impl Walk<'_> {
    fn prescribed(&self, t: f64) -> [Vec<f64>; 3] {
        let values: Vec<[f64; 3]> = self.motions.iter().map(|motion| (motion.law)(t)).collect();
        std::array::from_fn(|level| values.iter().map(|value| value[level]).collect())
    }

    /// Goes to another time; q, v and a there.
    pub(crate) fn to(&mut self, rows: &mut Rows, t: f64) -> Option<[Vec<f64>; 3]> {
        const SHORTEST: f64 = 1e-9;
        const LONGEST_STEP: f64 = 0.1;
        let whole = t - self.t;
        let mut share = 1.0;
        while self.t != t {
            let step = if (t - self.t).abs() <= (share * whole).abs() {
                t - self.t
            } else {
                share * whole
            };
            let next = if step == t - self.t { t } else { self.t + step };
            let [_, u_dot, u_ddot] = self.prescribed(self.t);
            let [v, a] = rows.rates(self.t, &self.x, (&u_dot, &u_ddot))?;
            let (v, a) = (rows.scaled(&v), rows.scaled(&a));
            let guess: Vec<f64> =
                (0..v.len()).map(|i| self.x[i] + step * (v[i] + 0.5 * step * a[i])).collect();
            let longest = (0..v.len()).fold(0.0, |l: f64, i| l.max((guess[i] - self.x[i]).abs()));
            let [u, ..] = self.prescribed(next);
            let closed =
                (longest <= LONGEST_STEP).then(|| close(rows, next, guess, &u, longest)).flatten();
            match closed {
                Some(x) => {
                    (self.x, self.t) = (x, next);
                    share = (share * 1.5).min(1.0);
                }
                None => share *= 0.5,
            }
            if share < SHORTEST {
                return None;
            }
        }
        let [u, u_dot, u_ddot] = self.prescribed(t);
        self.x = close(rows, t, self.x.clone(), &u, 1.0)?;
        let [v, a] = rows.rates(t, &self.x, (&u_dot, &u_ddot))?;
        Some([rows.unscaled(&self.x), v, a])
    }
}

/// Newton's iteration on all rows from a guess that is off by less than a part of `step`.
fn close(rows: &mut Rows, t: f64, mut x: Vec<f64>, u: &[f64], step: f64) -> Option<Vec<f64>> {
    for iteration in 0..12 {
        let at = rows.at(t, &x, u);
        let change = Solver::of(&at.jacobian)?.solve(&at.value)?;
        let size = change.norm();
        if !size.is_finite() || (iteration == 0 && size > 0.2 * step + 1e-9) {
            return None;
        }
        x.iter_mut().zip(change.iter()).for_each(|(x, change)| *x -= change);
        if size < 1e-12 {
            // Rows that exclude each other have a nearest pose, too.
            return (rows.at(t, &x, u).value.amax() < 1e-8).then_some(x);
        }
    }
    None
}
