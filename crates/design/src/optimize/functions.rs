//! The functions of a search at points: values of all cases, and their slopes back along the motion.

use nalgebra::DMatrix;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::search::Search;
use super::{Case, Over};

/// Work of the differences by one quantity, four runs that go on together in lanes, and of a run with its way back for
/// one function, as measured.
const DIFFERENCES: usize = 1;
const WAY_BACK: usize = 4;

impl Search<'_> {
    /// By point: goals, equations, conditions of all cases, then the objective by case.
    pub(super) fn functions(&self, points: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        let points: Vec<Vec<f64>> = points.iter().map(|x| self.unscaled(x)).collect();
        let by_case: Vec<_> = self.cases.iter().map(|case| case.at(&points, self.watch)).collect();
        let n = self.rows.len();
        let of_kind = |values: &[&Vec<f64>], kind: std::ops::Range<usize>| -> Vec<f64> {
            let of_case = |case: &&Vec<f64>| {
                let case = (*case).clone();
                kind.clone().map(move |row| self.rows[row].sign * case[row]).collect::<Vec<_>>()
            };
            values.iter().flat_map(of_case).collect()
        };
        let at = |k: usize| {
            let values = by_case.iter().map(|case| self.filled(case[k].as_ref()?));
            let values = values.collect::<Option<Vec<Vec<f64>>>>()?;
            let values: Vec<&Vec<f64>> = values.iter().collect();
            let mut all = of_kind(&values, 0..self.n_parts);
            all.extend(of_kind(&values, self.n_parts..self.n_parts + self.n_equal));
            all.extend(of_kind(&values, self.n_parts + self.n_equal..n));
            all.extend(values.iter().map(|case| case[n]));
            Some(all)
        };
        (0..points.len()).map(at).collect()
    }

    /// Values with those of the least tight window in place of windows without samples; `None` where one is no number.
    fn filled(&self, values: &[f64]) -> Option<Vec<f64>> {
        let is_absent = |k: &usize| values[*k].is_infinite();
        let looseness = |k: &usize| {
            // Goals are to be small, conditions large.
            let sign = if self.rows[*k].condition.is_none() { -1.0 } else { 1.0 };
            sign * self.rows[*k].sign * values[*k]
        };
        let value = |k: usize| {
            if k >= self.rows.len() || !is_absent(&k) {
                return values[k];
            }
            let is_alike = |other: &usize| {
                let [own, other] = [k, *other].map(|row| &self.rows[row]);
                own.condition == other.condition && own.sign == other.sign
            };
            let others = (0..self.rows.len()).filter(|k| !is_absent(k)).filter(is_alike);
            others
                .max_by(|a, b| looseness(a).total_cmp(&looseness(b)))
                .map_or(values[k], |k| values[k])
        };
        let filled: Vec<f64> = (0..values.len()).map(value).collect();
        filled.iter().all(|value| value.is_finite()).then_some(filled)
    }

    /// Slopes of the functions back along the motion, in parts of the ranges and of `scale`; `None` where differences are
    /// cheaper, or a function has no such slopes: a peak is where the motion decides, and a pose has no way back.
    pub(super) fn slopes_back(
        &self,
        x: &[f64],
        order: &[(usize, usize)],
        scale: &[f64],
    ) -> Option<DMatrix<f64>> {
        let n = self.ranges.len();
        let is_cheaper = n * DIFFERENCES > self.rows.len() * WAY_BACK;
        let has_way =
            |case: &Case| case.study.may_have_slopes() && matches!(case.over, Over::Motion);
        if !(is_cheaper && self.cases.iter().all(has_way)) {
            return None;
        }
        let (point, spans) =
            (self.unscaled(x), self.ranges.iter().map(|range| range.to - range.from));
        let spans: Vec<f64> = spans.collect();
        let by_case = self.cases.par_iter();
        let at = (point.as_slice(), spans.as_slice());
        let n_rows = self.rows.len();
        let by_case = by_case.map(|case| case.study.slopes_at(n_rows, at, self.watch.stop));
        let by_case = by_case.collect::<Option<Vec<_>>>()?;
        let slope = |i: usize, k: usize| {
            let (row, case) = order[i];
            self.rows[row].sign * by_case[case][row][k] * spans[k] / scale[i]
        };
        Some(DMatrix::from_fn(order.len(), n, slope))
    }

    /// The row and the case of every function.
    pub(super) fn order(&self) -> Vec<(usize, usize)> {
        let (a, b, n) = (self.n_parts, self.n_parts + self.n_equal, self.rows.len());
        let kinds = [0..a, a..b, b..n];
        let of = |kind: std::ops::Range<usize>| {
            (0..self.cases.len()).flat_map(move |case| kind.clone().map(move |row| (row, case)))
        };
        kinds.into_iter().flat_map(of).collect()
    }
}
