//! The search: starts, ends, and what the best of them is worth.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use super::{
    Case, Condition, ConditionAt, EndOfStart, NamedCase, OptimizeWish, Optimized, Optimum, Range,
    Row,
};
use bksim::model::file::suggest;

use crate::base::{Quantity, Source, Watch, written};
use crate::codes;
use crate::error::DesignError;
use crate::spec::located;
use crate::sqp::{Ended, Evaluate, Problem};

/// All that a search needs.
pub(super) struct Search<'a> {
    pub(super) ranges: &'a [Range],
    pub(super) cases: &'a [Case],
    pub(super) rows: &'a [Row],
    pub(super) n_parts: usize,
    pub(super) n_equal: usize,
    pub(super) is_squared: bool,
    pub(super) watch: Watch<'a>,
}

/// Points of a global search whose paths are followed.
const FOLLOWED: usize = 5;
/// Values of conditions below this are rounding, and no scale.
const ROUNDING: f64 = 1e-9;
/// Slopes of the Lagrangian at a minimum are below this part of their terms.
const SETTLED: f64 = 1e-5;

impl Search<'_> {
    pub(super) fn unscaled(&self, x: &[f64]) -> Vec<f64> {
        let ranges = self.ranges.iter().zip(x);
        ranges.map(|(range, x)| range.from + x * (range.to - range.from)).collect()
    }

    pub(super) fn answer(
        &self,
        source: &Source,
        (goal, objective): (&'static str, &str),
        (conditions, named): (&[Condition], &[NamedCase]),
        wish: &OptimizeWish,
    ) -> Result<Optimized, DesignError> {
        let n_cases = self.cases.len();
        let n_functions = self.rows.len() * n_cases;
        let evaluations = AtomicU64::new(0);
        // Values of points that are evaluated alone, which have an answer after a stop, too.
        let known: Mutex<BTreeMap<Vec<u64>, Vec<f64>>> = Mutex::default();
        let bits = |x: &Vec<f64>| x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
        let keep = |x: &Vec<f64>, values: &[f64]| {
            let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
            known.insert(bits(x), values.to_vec());
        };
        let recalled = |x: &Vec<f64>| {
            known.lock().unwrap_or_else(PoisonError::into_inner).get(&bits(x)).cloned()
        };
        let counted = |points: &[Vec<f64>]| {
            if let [one] = points
                && (self.watch.stop)()
            {
                return vec![recalled(one)];
            }
            evaluations.fetch_add((points.len() * n_cases) as u64, Ordering::Relaxed);
            let found = self.functions(points);
            if let ([one], [Some(values)]) = (points, found.as_slice()) {
                keep(one, values);
            }
            found
        };

        // Starts: that of the model or the nearest in the ranges, then the best of Sobol's sequence.
        let stated: Vec<f64> =
            self.ranges.iter().map(|r| (r.stated.value - r.from) / (r.to - r.from)).collect();
        let of_model: Vec<f64> = stated.iter().map(|x| x.clamp(0.0, 1.0)).collect();
        let start_values = counted(std::slice::from_ref(&of_model)).pop().flatten();
        if start_values.is_some() {
            (self.watch.kept)();
        }
        let before = if stated == of_model {
            start_values.clone()
        } else {
            self.functions(std::slice::from_ref(&stated)).pop().flatten()
        };
        let asked = usize::try_from(wish.starts.unwrap_or(0)).unwrap_or(usize::MAX).min(1 << 16);
        let n_points = if start_values.is_none() { asked.max(64) } else { asked };
        let points: Vec<Vec<f64>> = (0..n_points).map(|k| sobol(k, self.ranges.len())).collect();
        let from = self.begun(source, wish)?;
        let found = counted(&points);
        for (x, values) in points.iter().zip(&found) {
            if let Some(values) = values {
                keep(x, values);
            }
        }

        // Scales: the size of every function among the points that have values.
        let all: Vec<&Vec<f64>> = start_values.iter().chain(found.iter().flatten()).collect();
        if all.is_empty() && (self.watch.stop)() {
            return Err(DesignError::Stopped);
        }
        if all.is_empty() {
            let message = format!(
                "none of {} points of the ranges has a mechanism that closes and runs to its end",
                n_points + 1
            );
            let help = "correct the model until `bksim solve` runs, or choose ranges around values with which it does";
            let cause = self.cases.iter().find_map(|case| case.fault_at_rest(&of_model));
            return Err(cause
                .map_or_else(|| DesignError::fault(codes::NO_START, message, help), Into::into));
        }
        let order = self.order();
        let n_goals = self.n_parts * n_cases;
        // A condition that the start meets to rounding shows its size elsewhere.
        let is_rounding = |i: usize| {
            all.iter().all(|values| values[i].abs() < ROUNDING * (1.0 + values[0].abs()))
        };
        let elsewhere = if (n_goals..n_functions).any(is_rounding) {
            let points: Vec<Vec<f64>> = (1..=4).map(|k| sobol(k, self.ranges.len())).collect();
            counted(&points)
        } else {
            Vec::new()
        };
        let all: Vec<&Vec<f64>> = all.into_iter().chain(elsewhere.iter().flatten()).collect();
        let size = |i: usize| all.iter().map(|values| values[i].abs()).fold(0.0, f64::max);
        // Parts of a condition are missed alike.
        let of_condition = |i: usize| {
            let own =
                |k: &usize| self.rows[order[*k].0].condition == self.rows[order[i].0].condition;
            (n_goals..n_functions).filter(own).map(size).fold(0.0, f64::max)
        };
        let of_goals = (0..n_goals).map(size).fold(0.0, f64::max);
        let scale: Vec<f64> = (0..n_functions)
            .map(|i| if i < n_goals { of_goals } else { of_condition(i) })
            .map(|size| if size > 0.0 { size } else { 1.0 })
            .collect();
        let scaled = |points: &[Vec<f64>]| -> Vec<Option<Vec<f64>>> {
            let one = |values: Vec<f64>| values.iter().zip(&scale).map(|(v, s)| v / s).collect();
            counted(points).into_iter().map(|values| values.map(one)).collect()
        };
        let ways_back = AtomicU64::new(0);
        let slopes = |x: &[f64]| {
            let slopes = self.slopes_back(x, &order, &scale)?;
            ways_back.fetch_add(1, Ordering::Relaxed);
            Some(slopes)
        };
        let start = AtomicU64::new(0);
        let problem = Problem {
            n: self.ranges.len(),
            n_goals,
            n_equal: self.n_equal * n_cases,
            evaluate: &scaled,
            slopes: &slopes,
            stop: self.watch.stop,
            reached: &|iteration, merit| {
                let start = start.load(Ordering::Relaxed);
                let at = match merit * of_goals {
                    square if self.is_squared => square.max(0.0).sqrt(),
                    at if goal == "maximize" => -at,
                    at => at,
                };
                let words = format!("start {start}, iteration {iteration}, {at:.6}");
                (self.watch.reached)(&words, 0.0);
            },
        };
        let merit = |values: &Vec<f64>| {
            let values: Vec<f64> = values.iter().zip(&scale).map(|(v, s)| v / s).collect();
            problem.goal(&values) + 10.0 * problem.violation(&values)
        };
        let mut starts: Vec<(f64, Vec<f64>)> = points
            .iter()
            .zip(&found)
            .filter_map(|(x, values)| Some((merit(values.as_ref()?), x.clone())))
            .collect();
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        starts.truncate(FOLLOWED);
        if !from.is_empty() {
            starts.splice(0..0, from.into_iter().map(|x| (0.0, x)));
        } else if start_values.is_some() {
            starts.insert(0, (0.0, of_model.clone()));
        }
        (self.watch.kept)();

        // Each to its end; the best that meets the conditions.
        let mut ends: Vec<Ended> = Vec::new();
        for (k, (_, from)) in starts.into_iter().enumerate() {
            start.store(k as u64 + 1, Ordering::Relaxed);
            ends.extend(problem.minimize(from));
        }
        let key =
            |end: &Ended| (end.violation > 1e-6, problem.goal(&end.values) + 10.0 * end.violation);
        let best = ends.iter().min_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let Some(mut best) = best.cloned() else { return Err(DesignError::Stopped) };
        let is_stopped = (self.watch.stop)();
        if best.violation > 1e-6 && !is_stopped {
            // Conditions alone: where they are missed least; if nothing is missed there, on from there.
            let nearest = self.nearest(&problem, &best, &scaled).unwrap_or_else(|| best.clone());
            let again =
                if nearest.violation < 1e-7 { problem.minimize(nearest.x.clone()) } else { None };
            match again.filter(|end| end.violation < 1e-6) {
                Some(end) => {
                    best = end.clone();
                    ends.push(end);
                }
                None => return Err(self.unmet(&nearest, &scale, &order, conditions, named)),
            }
        }
        let is_same =
            |end: &&Ended| (problem.goal(&end.values) - problem.goal(&best.values)).abs() < 1e-6;
        let n_same = ends.iter().filter(is_same).count();

        // In the units of the model.
        let point = self.unscaled(&best.x);
        let values = recalled(&best.x)
            .or_else(|| self.functions(std::slice::from_ref(&best.x)).pop().flatten());
        let values = values.ok_or(DesignError::Stopped)?;
        let objective_of = |values: &[f64]| {
            let cases = values[n_functions..].iter().copied();
            if goal == "maximize" {
                cases.fold(f64::INFINITY, f64::min)
            } else {
                cases.fold(f64::NEG_INFINITY, f64::max)
            }
        };
        let after = objective_of(&values);
        // d objective / d (scaled goal).
        let per_goal = match (self.is_squared, goal) {
            (true, _) => of_goals / (2.0 * after),
            (_, "maximize") => -of_goals,
            _ => of_goals,
        };
        let per_goal = if per_goal.is_finite() { per_goal } else { 0.0 };
        let n = self.ranges.len();
        let quantities: Vec<Optimum> = self
            .ranges
            .iter()
            .enumerate()
            .map(|(k, range)| {
                let span = range.to - range.from;
                let [lower, upper] = [best.of_bounds[k], best.of_bounds[n + k]];
                let at_bound = match best.x[k] {
                    x if x <= 1e-9 => Some("lower"),
                    x if x >= 1.0 - 1e-9 => Some("upper"),
                    _ => None,
                };
                let worth = if at_bound == Some("lower") { lower } else { -upper };
                Optimum {
                    name: range.stated.name.clone(),
                    unit: range.stated.unit.clone(),
                    before: range.stated.value,
                    after: point[k],
                    written: written(point[k], &range.unit),
                    at_bound: at_bound.map(Into::into),
                    worth: if at_bound.is_some() { worth * per_goal / span } else { 0.0 },
                }
            })
            .collect();
        let units = self.cases[0].study.outputs();
        let conditions = conditions
            .iter()
            .enumerate()
            .flat_map(|(c, condition)| (0..n_cases).map(move |case| (c, condition, case)))
            .filter_map(|(c, condition, case)| {
                let is_of =
                    |i: &usize| self.rows[order[*i].0].condition == Some(c) && order[*i].1 == case;
                let own: Vec<usize> = (n_goals..n_functions).filter(is_of).collect();
                let tightest = *own.iter().min_by(|a, b| values[**a].total_cmp(&values[**b]))?;
                let turned =
                    if condition.is_equal || condition.text.contains(">=") { 1.0 } else { -1.0 };
                // The slack is large − small; the right side is the large one of `<=`.
                let worth: f64 =
                    own.iter().map(|&i| best.multipliers[i] / scale[i]).sum::<f64>() * per_goal;
                let of_case = if named[case].0.is_empty() {
                    String::new()
                } else {
                    format!(" ({})", named[case].0)
                };
                let is_active =
                    condition.is_equal || values[tightest].abs() <= 1e-7 * scale[tightest];
                Some(ConditionAt {
                    condition: format!("{}{of_case}", condition.text),
                    before: before.as_ref().map(|values| turned * values[tightest]),
                    after: turned * values[tightest],
                    unit: units[order[tightest].0].unit.clone(),
                    is_active,
                    worth: if is_active { turned * worth } else { 0.0 },
                })
            })
            .collect();
        let patches: Vec<(String, String)> =
            quantities.iter().map(|q| (q.name.clone(), q.written.clone())).collect();
        Ok(Optimized {
            goal: goal.into(),
            objective: objective.to_owned(),
            unit: units[self.rows.len()].unit.clone(),
            before: before.as_deref().map(objective_of),
            after,
            quantities,
            conditions,
            converged: best.stationarity < SETTLED,
            stopped: is_stopped,
            stationarity: best.stationarity,
            starts: [ends.len(), n_same],
            evaluations: evaluations.into_inner(),
            iterations: best.n_iterations,
            slopes: match ways_back.into_inner() {
                0 => "differences of fourth order".into(),
                _ => "the adjoint of the motion".into(),
            },
            ends: ends.iter().map(|end| self.end_of(end, best.violation)).collect(),
            choices: Vec::new(),
            front: None,
            unfinished: None,
            model: source.with_values(&patches)?,
            warnings: Vec::new(),
        })
    }

    /// Points to begin from that the question states, in parts of the ranges.
    fn begun(&self, source: &Source, wish: &OptimizeWish) -> Result<Vec<Vec<f64>>, DesignError> {
        let place = |values: &Vec<(String, String)>, range: &Range| {
            let name = &range.stated.name;
            let Some((_, text)) = values.iter().find(|(own, _)| own == name) else {
                return Ok((range.stated.value - range.from) / (range.to - range.from));
            };
            let read = Quantity::read(text).filter(|value| value.fits(&range.stated.unit));
            let value = read.ok_or_else(|| {
                let message = format!("`{text}` is no value of `{name}` to begin from");
                let help = format!(
                    "write it with its unit: `from = [{{ {name} = \"1 {}\" }}]`",
                    range.stated.unit
                );
                located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, text)
            })?;
            Ok((value.value - range.from) / (range.to - range.from))
        };
        let names = self.ranges.iter().map(|range| range.stated.name.as_str()).collect::<Vec<_>>();
        for (name, _) in wish.from.iter().flatten() {
            if !names.contains(&name.as_str()) {
                let message = format!("`from` has a value of `{name}`, which does not vary");
                let fault =
                    DesignError::fault(codes::UNKNOWN_QUANTITY, message, suggest(name, &names));
                return Err(located(fault, &source.text, name));
            }
        }
        let point = |values| {
            let point = self.ranges.iter().map(|range| place(values, range));
            point.map(|x| x.map(|x| x.clamp(0.0, 1.0))).collect()
        };
        wish.from.iter().map(point).collect()
    }

    /// Where a start is, to go on from there.
    fn end_of(&self, end: &Ended, violation: f64) -> EndOfStart {
        let names = self.ranges.iter().map(|range| range.stated.name.clone());
        EndOfStart {
            quantities: names.zip(self.unscaled(&end.x)).collect(),
            meets_conditions: end.violation <= violation.max(1e-6),
            converged: end.stationarity < SETTLED,
        }
    }

    /// Where the largest violation of a condition is least, from where a search ended.
    fn nearest(
        &self,
        problem: &Problem<'_>,
        from: &Ended,
        evaluate: &Evaluate<'_>,
    ) -> Option<Ended> {
        let (n_goals, n_equal) = (problem.n_goals, problem.n_equal);
        let n_functions = self.rows.len() * self.cases.len();
        let missed = |values: Vec<f64>| -> Vec<f64> {
            let equal = &values[n_goals..n_goals + n_equal];
            let rest = values[n_goals + n_equal..n_functions].iter().map(|value| -value);
            equal.iter().copied().chain(equal.iter().map(|value| -value)).chain(rest).collect()
        };
        let violations = |points: &[Vec<f64>]| {
            evaluate(points).into_iter().map(|values| values.map(missed)).collect()
        };
        let alone = Problem {
            n: problem.n,
            n_goals: n_functions - n_goals + n_equal,
            n_equal: 0,
            evaluate: &violations,
            slopes: &|_| None,
            stop: problem.stop,
            reached: problem.reached,
        };
        let x = alone.minimize(from.x.clone())?.x;
        let values = evaluate(std::slice::from_ref(&x)).pop().flatten()?;
        let violation = problem.violation(&values[..n_functions]);
        Some(Ended { x, values: values[..n_functions].to_vec(), violation, ..from.clone() })
    }

    /// The fault of conditions that nothing meets, with the one that is missed most.
    fn unmet(
        &self,
        best: &Ended,
        scale: &[f64],
        order: &[(usize, usize)],
        conditions: &[Condition],
        named: &[NamedCase],
    ) -> DesignError {
        let n_goals = self.n_parts * self.cases.len();
        let n_equal = self.n_equal * self.cases.len();
        let missed = |i: &usize| {
            if *i < n_goals + n_equal { best.values[*i].abs() } else { -best.values[*i] }
        };
        let worst = (n_goals..best.values.len()).max_by(|a, b| missed(a).total_cmp(&missed(b)));
        let worst = worst.unwrap_or(n_goals);
        let (row, case) = order[worst];
        let text = self.rows[row].condition.map_or("", |c| conditions[c].text.as_str());
        let unit = &self.cases[case].study.outputs()[row].unit;
        let of_case = if named[case].0.is_empty() {
            String::new()
        } else {
            format!(" in case `{}`", named[case].0)
        };
        let message = format!(
            "no values were found that meet all conditions: `{text}`{of_case} is missed by {} {unit}",
            bksim::model::message::short(missed(&worst) * scale[worst])
        );
        let help = "relax that condition, widen `vary`, or try more `starts`";
        DesignError::fault(codes::UNMET, message, help)
    }
}

/// A point of Sobol's sequence in the unit cube.
fn sobol(k: usize, n: usize) -> Vec<f64> {
    let k = u32::try_from(k).unwrap_or(u32::MAX);
    (0..n)
        .map(|axis| f64::from(sobol_burley::sample(k, u32::try_from(axis).unwrap_or(0), 0)))
        .collect()
}
