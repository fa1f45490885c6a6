//! The proof that slopes keep their signs throughout the limits, wherever pins are in their holes.

use nalgebra::DMatrix;

use super::Job;
use crate::interval::{Interval, Steps, times};
use crate::poses::Pose;

/// Block of a matrix of slopes from bounds of its entries: rows from and to, first column, number of columns.
type MatrixOf<'a> = dyn Fn(&[Interval], usize, usize, usize, usize) -> Vec<Vec<Interval>> + 'a;

/// Pieces into which the box is cut for a proof.
const MOST_PIECES: usize = 512;

impl Job<'_> {
    /// The signs of all slopes of a result, if they are the same throughout the box; pieces of it are looked at one by one.
    pub(super) fn signs(&self, pose: &Pose, k: usize) -> Option<Vec<f64>> {
        let steps = self.steps.as_ref()?;
        // Parameters that follow from others are intervals of their own only if each is a part itself.
        let of_parts = self.parts.iter();
        let of_parts = of_parts.map(|p| [p.nominal + p.limits[0], p.nominal + p.limits[1]]);
        let of_plays = self.plays.iter().flat_map(|play| [[-play.reach, play.reach]; 2]);
        let whole: Vec<Interval> =
            of_parts.chain(of_plays).map(|[lo, hi]| Interval::new(lo, hi)).collect();
        let nominal = (self.parameters)(&self.nominal())?;
        let moved = (self.parameters)(&self.corner(&|_| true))?;
        let is_part = |i: usize| self.parts.iter().any(|part| part.place == i);
        if (0..nominal.len()).any(|i| !is_part(i) && moved[i] != nominal[i]) {
            return None;
        }
        let mut open = vec![whole];
        let mut signs: Option<Vec<f64>> = None;
        let mut n_seen = 0;
        while let Some(piece) = open.pop() {
            n_seen += 1;
            if n_seen > MOST_PIECES {
                return None;
            }
            let found = self.slopes_in(steps, pose, k, &piece);
            let found = found.and_then(|slopes| {
                slopes[..self.parts.len()].iter().map(|slope| sign(*slope)).collect()
            });
            let Some(found) = found else {
                // Halves along the part that is widest.
                let size = |i: usize| match i.checked_sub(self.parts.len()) {
                    None => self.parts[i].half(),
                    Some(i) => self.plays[i / 2].reach,
                };
                let width = |i: &usize| piece[*i].radius() / size(*i);
                let widest = (0..piece.len()).max_by(|a, b| width(a).total_cmp(&width(b)))?;
                let [mut low, mut high] = [piece.clone(), piece.clone()];
                let middle = piece[widest].middle();
                low[widest].hi = middle;
                high[widest].lo = middle;
                open.extend([low, high]);
                continue;
            };
            match &signs {
                Some(known) if known.iter().zip(&found).any(|(a, b)| a * b < 0.0) => return None,
                _ => signs = Some(found),
            }
        }
        signs
    }

    /// Bounds of the slopes of a result in one piece, by Krawczyk's operator: by the parts, then by both components of each
    /// play.
    pub(super) fn slopes_in(
        &self,
        steps: &Steps,
        pose: &Pose,
        k: usize,
        piece: &[Interval],
    ) -> Option<Vec<Interval>> {
        let poses = self.poses;
        let n = poses.n();
        let mut solver = poses.solver();
        // The pose in the middle of the piece.
        let middle: Vec<f64> = piece.iter().map(|p| p.middle()).collect();
        let p = (self.parameters)(&middle)?;
        let m = solver.follow(pose, &p, &pose.u).ok()?;
        let mut p_box: Vec<Interval> = p.iter().map(|&p| Interval::point(p)).collect();
        for (place, bounds) in self.places().zip(piece) {
            p_box[place] = *bounds;
        }
        let inputs = |q: Vec<Interval>| [vec![Interval::point(0.0)], q, p_box.clone()].concat();
        let at_middle: Vec<Interval> = m.q.iter().map(|&q| Interval::point(q)).collect();
        let rows: Vec<Interval> = steps.over(&inputs(at_middle.clone()))[..n]
            .iter()
            .enumerate()
            .map(|(row, value)| {
                let (prescribed, is_angle) = poses.row(row);
                let value = prescribed.map_or(*value, |k| value.add(Interval::point(-pose.u[k])));
                let turns = (value.middle() / std::f64::consts::TAU).round();
                let off =
                    if is_angle && turns != 0.0 { -turns * std::f64::consts::TAU } else { 0.0 };
                if off == 0.0 {
                    value
                } else {
                    value.add(
                        Interval::point(off)
                            .add(Interval::new(-1e-15 * off.abs(), 1e-15 * off.abs())),
                    )
                }
            })
            .collect();
        let matrix = |values: &[Interval], from: usize, to: usize, first: usize, count: usize| {
            let mut all = vec![vec![Interval::point(0.0); count]; to - from];
            for (&(row, column), value) in poses.slopes().iter().zip(&values[n + self.n_outputs..])
            {
                if (from..to).contains(&row) && (first..first + count).contains(&column) {
                    all[row - from][column - first] = *value;
                }
            }
            all
        };
        let n_p = p.len();
        let here = steps.over(&inputs(at_middle));
        let slopes = matrix(&here, 0, n, 0, n);
        let y = DMatrix::from_fn(n, n, |i, j| slopes[i][j].middle()).try_inverse()?;
        let column = |v: &[Interval]| v.iter().map(|x| vec![*x]).collect::<Vec<_>>();
        let newton = times(&y, &column(&rows));
        // A box around the pose that the operator maps into itself.
        let mut radius: Vec<f64> = newton.iter().map(|x| 2.0 * x[0].size() + 1e-14).collect();
        for _ in 0..8 {
            let x_box: Vec<Interval> =
                m.q.iter().zip(&radius).map(|(q, r)| Interval::new(q - r, q + r)).collect();
            let values = steps.over(&inputs(x_box.clone()));
            let a = times(&y, &matrix(&values, 0, n, 0, n));
            let off = |i: usize, j: usize| {
                Interval::point(if i == j { 1.0 } else { 0.0 }).add(a[i][j].scaled(-1.0))
            };
            let image: Vec<Interval> = (0..n)
                .map(|i| {
                    let begin = Interval::point(m.q[i]).add(newton[i][0].scaled(-1.0));
                    let terms =
                        (0..n).map(|j| off(i, j).multiply(Interval::new(-radius[j], radius[j])));
                    terms.fold(begin, Interval::add)
                })
                .collect();
            if image.iter().any(|x| !x.size().is_finite()) {
                return None;
            }
            if image.iter().zip(&x_box).all(|(image, of)| image.is_within(*of)) {
                return self.slopes_of(k, (&values, &matrix), &y, (&a, n_p));
            }
            for (radius, (image, q)) in radius.iter_mut().zip(image.iter().zip(&m.q)) {
                *radius = 1.2 * (image.hi - q).abs().max((image.lo - q).abs()) + 1e-15;
            }
        }
        None
    }

    /// Places of the parts, then of both components of each play, among the parameters.
    fn places(&self) -> impl Iterator<Item = usize> {
        let of_plays = self.plays.iter().flat_map(|play| [play.place, play.place + 1]);
        self.parts.iter().map(|part| part.place).chain(of_plays)
    }

    /// Bounds of dh/dp, from bounds of all slopes.
    fn slopes_of(
        &self,
        k: usize,
        (values, matrix): (&[Interval], &MatrixOf<'_>),
        y: &DMatrix<f64>,
        (a, n_p): (&[Vec<Interval>], usize),
    ) -> Option<Vec<Interval>> {
        let n = self.poses.n();
        // D = −(Y Φ_q)⁻¹ Y Φ_p, with I − Y Φ_q smaller than one.
        let row_sum = |i: usize| {
            (0..n)
                .map(|j| {
                    let one = Interval::point(if i == j { 1.0 } else { 0.0 });
                    one.add(a[i][j].scaled(-1.0)).size()
                })
                .sum::<f64>()
        };
        let e = (0..n).map(row_sum).fold(0.0, f64::max) * (1.0 + 1e-12);
        if e.is_nan() || e >= 1.0 {
            return None;
        }
        let b = times(y, &matrix(values, 0, n, n, n_p));
        let h_q = matrix(values, n + k, n + k + 1, 0, n);
        let h_p = matrix(values, n + k, n + k + 1, n, n_p);
        let slope = |place: usize| {
            let column: Vec<Interval> = b.iter().map(|row| row[place]).collect();
            let largest = column.iter().map(|x| x.size()).fold(0.0, f64::max);
            let spread = e / (1.0 - e) * largest * (1.0 + 1e-12);
            let terms = (0..n).map(|i| {
                let d = column[i].scaled(-1.0).add(Interval::new(-spread, spread));
                h_q[0][i].multiply(d)
            });
            terms.fold(h_p[0][place], Interval::add)
        };
        Some(self.places().map(slope).collect())
    }
}

/// The sign of a slope with these bounds; `None` where it has either.
fn sign(slope: Interval) -> Option<f64> {
    match slope {
        Interval { lo, .. } if lo >= 0.0 => Some(1.0),
        Interval { hi, .. } if hi <= 0.0 => Some(-1.0),
        // Nothing depends on it, but for rounding.
        slope if slope.size() < 1e-13 => Some(1.0),
        _ => None,
    }
}
