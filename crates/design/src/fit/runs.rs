//! Compared values of runs, with their slopes.

use bksim::model::file::WrittenUnit;
use bksim_sweep::{Ending, Monitor, Row};
use nalgebra::DMatrix;

use super::{Compared, Curve, FitWish, Kind, Problem, Run, names_in};
use crate::base::Watch;
use crate::least_squares::{Found, Loss, Residuals};

/// Places and weights of differences of fourth order.
const STENCIL: [(f64, f64); 4] =
    [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];

/// Six points of an even grid around an instant, as weights of their values.
fn interpolated(values: &[f64], [t_start, step]: [f64; 2], t: f64) -> f64 {
    let at = (t - t_start) / step;
    let last = values.len() - 6;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the grid")]
    let first = ((at.floor() - 2.0).max(0.0) as usize).min(last);
    let at = at - first as f64;
    let weight = |k: usize| {
        let others = (0..6).filter(|other| *other != k);
        others.map(|other| (at - other as f64) / (k as f64 - other as f64)).product::<f64>()
    };
    (0..6).map(|k| weight(k) * values[first + k]).sum()
}

/// An angle without its whole turns.
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::TAU;
    angle - TAU * (angle / TAU).round()
}

impl Run {
    /// Compared values less their formulas, in standard deviations, for many sets of unknowns.
    fn residuals(
        &self,
        points: &[Vec<f64>],
        n_varied: usize,
        watch: Watch<'_>,
    ) -> Vec<Option<Vec<f64>>> {
        let of_model = |x: &Vec<f64>| x[..n_varied].to_vec();
        let motions: Vec<Option<Vec<f64>>> = if let Kind::Motion { .. } = self.kind {
            // Each motion once, however many unknowns of the measurement vary.
            let mut unique: Vec<Vec<f64>> = points.iter().map(of_model).collect();
            unique.sort_by(|a, b| {
                a.iter()
                    .zip(b)
                    .map(|(a, b)| a.total_cmp(b))
                    .find(|o| o.is_ne())
                    .unwrap_or(std::cmp::Ordering::Equal)
            });
            unique.dedup();
            let monitor = Monitor { stop: watch.stop, progress: &|_| () };
            let rows = self.study.rows_at(&unique, 0, &monitor).ok().flatten().unwrap_or_default();
            let outputs = |row: &Row| (row.ending == Ending::Done).then(|| row.outputs.clone());
            let of = |x: &Vec<f64>| {
                let place = unique.iter().position(|known| *known == of_model(x))?;
                rows.get(place).and_then(outputs)
            };
            points.iter().map(of).collect()
        } else {
            points.iter().map(|_| Some(Vec::new())).collect()
        };
        let one = |(x, motion): (&Vec<f64>, Option<Vec<f64>>)| {
            let found = self.fitted(x, n_varied, &motion?)?;
            let off = |(compared, fitted): (&Compared, f64)| {
                (fitted - compared.measured) / compared.sigma
            };
            let all: Vec<f64> = self.compared.iter().zip(found).map(off).collect();
            all.iter().all(|r| r.is_finite()).then_some(all)
        };
        points.iter().zip(motions).map(one).collect()
    }

    /// The formulas of all compared values; angles in the turn of what was measured.
    fn fitted(&self, x: &[f64], n_varied: usize, motion: &[f64]) -> Option<Vec<f64>> {
        if let Kind::Positions { .. } = self.kind {
            return self.positions(x, n_varied).map(|(values, _)| values);
        }
        let parameters = self.study.parameters_at(&x[..n_varied])?;
        let mut space = self.tape.workspace(&[]);
        let mut values = vec![0.0; self.tape.n_outputs()];
        let mut all = Vec::with_capacity(self.compared.len());
        for compared in &self.compared {
            let row = compared.row;
            let mut inputs = [&self.columns.rows[row][..], &x[n_varied..]].concat();
            if let Kind::Motion { n_quantities, times, grid, late } = &self.kind {
                let n = motion.len() / n_quantities;
                for k in 0..*n_quantities {
                    let own = &motion[k * n..(k + 1) * n];
                    inputs.push(match grid {
                        Some(grid) => {
                            let late = late[compared.formula].map_or(0.0, |k| x[n_varied + k]);
                            interpolated(own, *grid, times[row] - late)
                        }
                        None => own[row],
                    });
                }
            }
            inputs.extend(&parameters);
            self.tape.evaluate(&mut space, &inputs, &mut values);
            all.push(values[compared.formula]);
        }
        Some(all)
    }

    /// Derivatives of parameters by what varies: one for itself, differences for those that follow from it.
    fn by_varied(&self, x: &[f64], n_varied: usize) -> Option<DMatrix<f64>> {
        let varied = &x[..n_varied];
        let here = self.study.parameters_at(varied)?;
        let mut by = DMatrix::zeros(here.len(), n_varied);
        let names: Vec<String> = self.study.input_columns().into_iter().map(|c| c.name).collect();
        let model = self.study.mechanism().model;
        for k in 0..n_varied {
            let step = 1e-4 * if x[k] == 0.0 { 1.0 } else { x[k].abs() };
            let moved = |off: f64| {
                let mut x = varied.to_vec();
                x[k] += off;
                self.study.parameters_at(&x)
            };
            let (above, below) = (moved(step)?, moved(-step)?);
            for (i, parameter) in model.parameters.iter().enumerate() {
                by[(i, k)] = if parameter.name == names[k] {
                    1.0
                } else {
                    (above[i] - below[i]) / (2.0 * step)
                };
            }
        }
        Some(by)
    }

    /// The values of formulas of positions with their slopes by all unknowns.
    fn positions(&self, x: &[f64], n_varied: usize) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let Kind::Positions { poses, drives, drive_slopes, is_turn } = &self.kind else {
            return None;
        };
        let parameters = self.study.parameters_at(&x[..n_varied])?;
        let by_varied = self.by_varied(x, n_varied)?;
        let n_columns = self.columns.names.len();
        let n_own = n_columns + x.len() - n_varied;
        let mut solver = poses.solver();
        let mut pose = solver.follow(&poses.start, &parameters, &poses.start.u).ok()?;
        let mut space = drives.workspace(&[]);
        let mut targets = vec![0.0; drives.n_outputs()];
        let n_u = poses.start.u.len();
        let mut slopes = DMatrix::zeros(self.compared.len(), x.len());
        let mut values = vec![0.0; self.compared.len()];
        let mut last = usize::MAX;
        let mut found = None;
        // Rows in their order, whatever is compared.
        let mut order: Vec<usize> = (0..self.compared.len()).collect();
        order.sort_by_key(|&i| self.compared[i].row);
        for i in order {
            let Compared { row, formula, measured, .. } = self.compared[i];
            let own = [&self.columns.rows[row][..], &x[n_varied..]].concat();
            if row != last {
                let inputs = [&own[..], &parameters].concat();
                drives.evaluate(&mut space, &inputs, &mut targets);
                pose = solver.follow(&pose, &parameters, &targets[..n_u]).ok()?;
                found = solver.outputs(&pose, &own);
                last = row;
            }
            let at = found.as_ref()?;
            let value = at.values[formula];
            let off = value - measured;
            values[i] = if is_turn[formula] { measured + wrapped(off) } else { value };
            // By drives, then what these are by; by parameters; by own unknowns.
            let mut by_own = at.by_own.row(formula).into_owned();
            let mut by_p = at.by_p.row(formula).into_owned();
            for (&(drive, column), slope) in drive_slopes.iter().zip(&targets[n_u..]) {
                let through = at.by_u[(formula, drive)] * slope;
                if column < n_own {
                    by_own[column] += through;
                } else {
                    by_p[column - n_own] += through;
                }
            }
            let of_parameters = by_p * &by_varied;
            for k in 0..n_varied {
                slopes[(i, k)] = of_parameters[k];
            }
            for k in n_varied..x.len() {
                slopes[(i, k)] = by_own[n_columns + k - n_varied];
            }
        }
        Some((values, slopes))
    }

    /// Exact slopes of formulas of columns alone.
    fn of_formulas(&self, x: &[f64], n_varied: usize) -> Option<DMatrix<f64>> {
        let parameters = self.study.parameters_at(&x[..n_varied])?;
        let by_varied = self.by_varied(x, n_varied)?;
        let n_columns = self.columns.names.len();
        let n_own = n_columns + x.len() - n_varied;
        let mut space = self.tape.workspace(&[]);
        let mut values = vec![0.0; self.tape.n_outputs()];
        let mut slopes = DMatrix::zeros(self.compared.len(), x.len());
        for (i, compared) in self.compared.iter().enumerate() {
            let inputs =
                [&self.columns.rows[compared.row][..], &x[n_varied..], &parameters].concat();
            self.tape.evaluate(&mut space, &inputs, &mut values);
            for (&(formula, column), slope) in self.slopes_by.iter().zip(&values[self.n_formulas..])
            {
                if formula != compared.formula || column < n_columns {
                    continue;
                }
                if column < n_own {
                    slopes[(i, n_varied + column - n_columns)] += slope;
                } else {
                    for k in 0..n_varied {
                        slopes[(i, k)] += slope * by_varied[(column - n_own, k)];
                    }
                }
            }
        }
        Some(slopes)
    }
}

impl Problem<'_> {
    fn n_varied(&self) -> usize {
        self.varied.len()
    }

    fn many(&self, points: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        let by_run: Vec<_> = self
            .runs
            .iter()
            .map(|run| run.residuals(points, self.n_varied(), self.watch))
            .collect();
        let at = |k: usize| {
            let all: Option<Vec<Vec<f64>>> = by_run.iter().map(|run| run[k].clone()).collect();
            Some(all?.concat())
        };
        (0..points.len()).map(at).collect()
    }

    /// Measured and fitted values, with √(J cov Jᵀ) and what noise adds to it.
    pub(super) fn curves(
        &self,
        found: &Found,
        (covariance, s2): (&DMatrix<f64>, f64),
        (loss, is_sigma_known): (Loss, bool),
        wish: &FitWish,
    ) -> Vec<Curve> {
        let noise = if is_sigma_known { 1.0 } else { s2 };
        let mut curves = Vec::new();
        let mut first = 0;
        for run in &self.runs {
            let named = |name: &&str| run.columns.named(name).map(|at| ((*name).to_owned(), at));
            let over = if let Kind::Positions { .. } = &run.kind {
                let names = wish.drive.first().map(|(_, text)| names_in(text)).unwrap_or_default();
                names.iter().find_map(|name| named(&name.as_str()))
            } else {
                ["t", "time"].iter().find_map(named)
            };
            for (k, (column, _)) in wish.compare.iter().enumerate() {
                let own = || run.compared.iter().enumerate().filter(move |(_, c)| c.formula == k);
                // Of the fitted curve, in standard deviations of the measurement.
                let variance = |i: usize| {
                    let row = found.slopes.row(first + i) / loss.root(found.residuals[first + i]);
                    (&row * covariance * row.transpose())[(0, 0)].max(0.0)
                };
                let error =
                    |more: f64| own().map(|(i, c)| c.sigma * (variance(i) + more).sqrt()).collect();
                curves.push(Curve {
                    file: run.file.clone(),
                    column: column.clone(),
                    over: over.as_ref().map_or("row".to_owned(), |(name, _)| name.clone()),
                    units: [over.as_ref().map(|(_, at)| *at), run.columns.named(column)].map(
                        |at| {
                            let unit = at.and_then(|at| run.columns.units[at].as_ref());
                            unit.map_or_else(String::new, WrittenUnit::si)
                        },
                    ),
                    at: own()
                        .map(|(_, c)| {
                            over.as_ref()
                                .map_or((c.row + 1) as f64, |(_, at)| run.columns.rows[c.row][*at])
                        })
                        .collect(),
                    measured: own().map(|(_, c)| c.measured).collect(),
                    fitted: own()
                        .map(|(i, c)| c.measured + found.residuals[first + i] * c.sigma)
                        .collect(),
                    standard_error: error(0.0),
                    prediction_error: error(noise),
                });
            }
            first += run.compared.len();
        }
        curves
    }
}

impl Residuals for Problem<'_> {
    fn at(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.many(&[x.to_vec()]).pop().flatten()
    }

    fn slopes(&self, x: &[f64]) -> Option<DMatrix<f64>> {
        debug_assert_eq!(x.len(), self.n_varied() + self.n_unknowns);
        if self.is_exact {
            let mut all: Option<DMatrix<f64>> = None;
            for run in &self.runs {
                let mut own = match run.kind {
                    Kind::Positions { .. } => run.positions(x, self.n_varied())?.1,
                    _ => run.of_formulas(x, self.n_varied())?,
                };
                for (i, compared) in run.compared.iter().enumerate() {
                    own.row_mut(i).scale_mut(1.0 / compared.sigma);
                }
                all = Some(match all {
                    None => own,
                    Some(above) => {
                        let n = above.nrows();
                        let mut joined = above.resize_vertically(n + own.nrows(), 0.0);
                        joined.rows_mut(n, own.nrows()).copy_from(&own);
                        joined
                    }
                });
            }
            return all;
        }
        // Differences of fourth order, all runs at once.
        let step = |k: usize| 1e-3 * self.scale[k];
        let moved = |k: usize, at: f64| {
            let mut x = x.to_vec();
            x[k] += at * step(k);
            x
        };
        let points: Vec<Vec<f64>> =
            (0..x.len()).flat_map(|k| STENCIL.map(|(at, _)| moved(k, at))).collect();
        let found: Option<Vec<Vec<f64>>> = self.many(&points).into_iter().collect();
        let found = found?;
        let m = found.first()?.len();
        Some(DMatrix::from_fn(m, x.len(), |i, k| {
            let terms = STENCIL.iter().zip(&found[4 * k..4 * k + 4]);
            terms.map(|((_, weight), at)| weight * at[i]).sum::<f64>() / step(k)
        }))
    }
}
