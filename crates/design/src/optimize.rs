//! `[optimize]`: the values of some parameters for which a number of the mechanism is least or largest.

use std::collections::BTreeMap;

use bksim::analysis::{Drive, statics};
use bksim::sim::run::Sample;
use bksim_sweep::{Ending, Monitor, Study};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use crate::base::{Quantity, Source, Stated, Watch, written};
use crate::codes;
use crate::error::DesignError;
use crate::poses::{Pose, Poses};
use crate::spec::{Written, located, section};
use crate::sqp::{Ended, Problem};

/// What is to be least or largest, what varies, and what must hold.
#[derive(Clone, Debug, Default)]
pub struct OptimizeWish {
    /// An output as of a sweep: `rms(drives.motor.effort)`.
    pub minimize: Option<String>,
    /// In its place, what is to be largest.
    pub maximize: Option<String>,
    /// Parameters and initial values, each with its least and largest value.
    pub vary: Vec<(String, [String; 2])>,
    /// Conditions: two sides with `<=`, `>=` or `==` between them.
    pub subject_to: Vec<String>,
    /// `motion`, `static`, or a range of a measure as `kinematics --drive` takes it.
    pub over: Option<String>,
    /// Load cases: other values of parameters, by name.
    pub cases: Vec<(String, Vec<(String, String)>)>,
    /// Number of points of Sobol's sequence from which the best are followed, besides the start.
    pub starts: Option<u64>,
}

/// The section `[optimize]`.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
struct Section {
    minimize: Option<String>,
    maximize: Option<String>,
    #[serde(default)]
    vary: BTreeMap<String, [Written; 2]>,
    #[serde(default)]
    subject_to: Vec<String>,
    over: Option<String>,
    #[serde(default)]
    cases: BTreeMap<String, BTreeMap<String, Written>>,
    starts: Option<u64>,
}

const EXAMPLE: &str = "write it as `minimize = \"max(drives.motor.effort)\"` and `vary = { l1 = [\"80 mm\", \"120 mm\"] }` below `[optimize]`";

/// A quantity at its optimum.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Optimum {
    /// A parameter or initial value.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// In the model, SI.
    pub before: f64,
    /// At the optimum, SI.
    pub after: f64,
    /// As it is written into the model.
    pub written: String,
    /// `lower` or `upper` where it is at its bound.
    pub at_bound: Option<&'static str>,
    /// Change of the objective where that bound is moved by one unit of SI.
    pub worth: f64,
}

/// A condition at the optimum.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ConditionAt {
    /// As written, with its case.
    pub condition: String,
    /// Left side less right side before, SI; `None` where the model has no value there.
    pub before: Option<f64>,
    /// Left side less right side at the optimum, SI.
    pub after: f64,
    /// SI unit of the sides.
    pub unit: String,
    /// Whether it holds with equality.
    pub is_active: bool,
    /// Change of the objective where the right side grows by one unit of SI.
    pub worth: f64,
}

/// The answer.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Optimized {
    /// `minimize` or `maximize`.
    pub goal: &'static str,
    /// What it is of.
    pub objective: String,
    /// SI unit.
    pub unit: String,
    /// In the model; `None` where it has no value there.
    pub before: Option<f64>,
    /// At the optimum.
    pub after: f64,
    /// The quantities that varied.
    pub quantities: Vec<Optimum>,
    /// The conditions.
    pub conditions: Vec<ConditionAt>,
    /// Whether the conditions of a minimum hold.
    pub converged: bool,
    /// Whether it was stopped, so that this is the best so far.
    pub stopped: bool,
    /// Largest slope of the Lagrangian, relative.
    pub stationarity: f64,
    /// Starts that were followed, and those of them that ended at this optimum.
    pub starts: [usize; 2],
    /// Evaluations of the mechanism.
    pub evaluations: u64,
    /// Iterations of the start that ended here.
    pub iterations: usize,
    /// How slopes were found.
    pub slopes: &'static str,
    /// The text of the model with the values of the optimum.
    #[serde(skip)]
    pub model: String,
}

impl OptimizeWish {
    /// What the model asks in `[optimize]`; nothing of a model without the section.
    ///
    /// # Errors
    /// [`codes::BAD_QUESTION`].
    pub fn of_model(text: &str) -> Result<Self, DesignError> {
        let Some(found) = section::<Section>(text, "optimize", EXAMPLE)? else {
            return Ok(Self::default());
        };
        let pair = |[from, to]: [Written; 2]| [from.text(), to.text()];
        let case = |values: BTreeMap<String, Written>| {
            values.into_iter().map(|(name, value)| (name, value.text())).collect()
        };
        Ok(Self {
            minimize: found.minimize,
            maximize: found.maximize,
            vary: found.vary.into_iter().map(|(name, range)| (name, pair(range))).collect(),
            subject_to: found.subject_to,
            over: found.over,
            cases: found.cases.into_iter().map(|(name, values)| (name, case(values))).collect(),
            starts: found.starts,
        })
    }
}

/// A varied quantity with its range.
struct Range {
    stated: Stated,
    from: f64,
    to: f64,
    unit: String,
}

/// One function of the problem, an output of every case.
struct Row {
    /// Its text, for messages.
    text: String,
    /// The factor of the output.
    sign: f64,
    /// The condition that it is part of.
    condition: Option<usize>,
}

/// A condition as it is written.
struct Condition {
    text: String,
    is_equal: bool,
}

/// The finest steps with which the mechanism is evaluated.
enum Over {
    Motion,
    Static,
    Drive(Box<Poses>, Vec<f64>),
}

/// A case with all that evaluates it.
struct Case {
    study: Study,
    over: Over,
}

/// Finds the optimum of a model.
///
/// # Errors
/// [`DesignError`] for what cannot be read, and where nothing closes or conditions exclude each other.
pub fn optimize(
    source: &Source,
    wish: &OptimizeWish,
    watch: Watch<'_>,
) -> Result<Optimized, DesignError> {
    let over = wish.over.as_deref().unwrap_or("motion").trim();
    let is_geometry = over != "motion" && over != "static";
    let (goal, objective) = match (&wish.minimize, &wish.maximize) {
        (Some(text), None) => ("minimize", text.trim()),
        (None, Some(text)) => ("maximize", text.trim()),
        (Some(_), Some(_)) => {
            let message = "the model is to have a number both least and largest";
            return Err(DesignError::fault(
                codes::BAD_QUESTION,
                message,
                "keep one of `minimize` and `maximize`",
            ));
        }
        (None, None) => {
            let message = "nothing is said to be least or largest";
            return Err(DesignError::fault(codes::NOTHING_ASKED, message, EXAMPLE));
        }
    };
    let ranges = ranges(source, wish, is_geometry)?;

    // Functions: parts of the objective, equations, other conditions.
    let (parts, is_squared) = parts_of(goal, objective);
    let mut rows: Vec<Row> = parts
        .iter()
        .map(|(sign, text)| Row { text: text.clone(), sign: *sign, condition: None })
        .collect();
    let n_parts = rows.len();
    let mut conditions = Vec::new();
    let mut others = Vec::new();
    for text in &wish.subject_to {
        let (left, relation, right) = sides(text).ok_or_else(|| {
            let message = format!("`{text}` is no condition");
            let help = "write two sides with `<=`, `>=` or `==` between them, as in `max(A.angle) <= 40 deg`";
            located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, text)
        })?;
        let condition = Some(conditions.len());
        let is_equal = relation == "==";
        conditions.push(Condition { text: text.clone(), is_equal });
        if is_equal {
            rows.push(Row { text: format!("({left}) - ({right})"), sign: 1.0, condition });
            continue;
        }
        // The side that is to be the smaller one, in smooth parts.
        let (small, large) = if relation == "<=" { (left, right) } else { (right, left) };
        for (sign, small) in peaks(small) {
            let sign = if sign < 0.0 { "-" } else { "" };
            others.push(Row { text: format!("({large}) - {sign}({small})"), sign: 1.0, condition });
        }
    }
    let n_equal = rows.len() - n_parts;
    rows.extend(others);

    // The cases, each with its functions; one number of the objective itself is reported.
    let outputs: Vec<String> =
        rows.iter().map(|row| row.text.clone()).chain([objective.to_owned()]).collect();
    let none = vec![(String::new(), Vec::new())];
    let named = if wish.cases.is_empty() { &none } else { &wish.cases };
    let varied: Vec<Stated> = ranges.iter().map(|range| range.stated.clone()).collect();
    let mut cases = Vec::new();
    for (_, fixed) in named {
        let study = source.study(&varied, fixed, &outputs, is_geometry);
        let study = study.map_err(|fault| located_any(fault, source, wish))?;
        let over = match over {
            "motion" => Over::Motion,
            "static" => Over::Static,
            range => driven(&study, range).map_err(|fault| located(fault, &source.text, range))?,
        };
        cases.push(Case { study, over });
    }

    let search =
        Search { ranges: &ranges, cases: &cases, rows: &rows, n_parts, n_equal, is_squared, watch };
    search.answer(source, (goal, objective), (&conditions, named), wish)
}

fn located_any(fault: DesignError, source: &Source, wish: &OptimizeWish) -> DesignError {
    let about = wish.subject_to.iter().chain(&wish.minimize).chain(&wish.maximize);
    let message = fault.to_string();
    let quoted =
        |text: &&String| message.split('`').skip(1).step_by(2).any(|name| text.contains(name));
    match about.into_iter().find(quoted) {
        Some(text) => located(fault, &source.text, text),
        None => fault,
    }
}

fn ranges(
    source: &Source,
    wish: &OptimizeWish,
    is_geometry: bool,
) -> Result<Vec<Range>, DesignError> {
    if wish.vary.is_empty() {
        let help = "name what varies with its ends: `vary = { l1 = [\"80 mm\", \"120 mm\"] }`, or `--vary \"l1=80 mm:120 mm\"`";
        return Err(DesignError::fault(codes::NOTHING_ASKED, "nothing varies", help));
    }
    let names: Vec<String> = wish.vary.iter().map(|(name, _)| name.clone()).collect();
    let stated = source.stated(&names, is_geometry)?;
    let range = |(stated, (_, [from, to])): (Stated, &(String, [String; 2]))| {
        let ends = Quantity::read(from).zip(Quantity::read(to));
        let is_range = |(from, to): &(Quantity, Quantity)| {
            from.value < to.value && from.fits(&stated.unit) && to.fits(&stated.unit)
        };
        let (from, to) = ends.filter(is_range).ok_or_else(|| {
            let message = format!("`{from}` to `{to}` is no range of `{}`", stated.name);
            let unit = &stated.unit;
            let help = format!("give the least value first, and units of the kind {unit}: `{} = [\"0.5 {unit}\", \"2 {unit}\"]`", stated.name);
            located(DesignError::fault(codes::BAD_QUESTION, message, help), &source.text, from)
        })?;
        let unit = if to.unit.is_empty() { from.unit.clone() } else { to.unit.clone() };
        Ok(Range { stated, from: from.value, to: to.value, unit })
    };
    stated.into_iter().zip(&wish.vary).map(range).collect()
}

/// The two sides of a condition and its sign.
fn sides(text: &str) -> Option<(&str, &str, &str)> {
    let found = ["<=", ">=", "=="].into_iter().find_map(|sign| {
        let (left, right) = text.split_once(sign)?;
        Some((left.trim(), sign, right.trim()))
    })?;
    (!found.0.is_empty() && !found.2.is_empty()).then_some(found)
}

/// What stands in the parentheses of a call of `name` that is all of the text.
fn inside<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    let rest = text.trim().strip_prefix(name)?.trim_start().strip_prefix('(')?;
    let mut depth = 1;
    for (at, c) in rest.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => (),
        }
        if depth == 0 {
            return (at + 1 == rest.len()).then(|| rest[..at].trim());
        }
    }
    None
}

/// Texts whose largest value, each times its sign, is that of the text: the peak of a magnitude is that of either side.
fn peaks(text: &str) -> Vec<(f64, String)> {
    if let Some(of) = inside(text, "max").and_then(|of| inside(of, "abs")) {
        return vec![(1.0, format!("max({of})")), (-1.0, format!("min({of})"))];
    }
    if let Some(of) = inside(text, "abs") {
        return vec![(1.0, of.to_owned()), (-1.0, of.to_owned())];
    }
    vec![(1.0, text.to_owned())]
}

/// The smooth parts of an objective, the largest of which is least; true where these are of its square.
fn parts_of(goal: &str, objective: &str) -> (Vec<(f64, String)>, bool) {
    if goal == "maximize" {
        return (vec![(-1.0, objective.to_owned())], false);
    }
    // The square of a root of squares is smooth where it vanishes.
    if inside(objective, "rms").is_some() {
        return (vec![(1.0, format!("({objective})^2"))], true);
    }
    (peaks(objective), false)
}

/// Positions over a range of a measure.
fn driven(study: &Study, range: &str) -> Result<Over, DesignError> {
    let mechanism = study.mechanism();
    let bad = || {
        let message = format!("`{range}` is nothing that is evaluated over");
        let help =
            "write `motion`, `static` or a range of a measure, as in `crank.angle=0:360 deg:361`";
        DesignError::fault(codes::BAD_QUESTION, message, help)
    };
    let (name, values) = range.split_once('=').ok_or_else(bad)?;
    let drive = Drive::parse(&mechanism.model, name.trim(), values.trim())?;
    let poses = Poses::new(&mechanism, &[(drive.name.clone(), drive.measure)], &[], &[])?;
    Ok(Over::Drive(Box::new(poses), drive.range.values()))
}

impl Case {
    /// The outputs at some points, SI; `None` where the mechanism has none.
    fn at(&self, points: &[Vec<f64>], watch: Watch<'_>) -> Vec<Option<Vec<f64>>> {
        let found: Vec<Option<Vec<f64>>> = match &self.over {
            Over::Motion => {
                let monitor = Monitor { stop: watch.stop, progress: &|_| () };
                let rows =
                    self.study.rows_at(points, 0, &monitor).ok().flatten().unwrap_or_default();
                let outputs =
                    |row: bksim_sweep::Row| (row.ending == Ending::Done).then_some(row.outputs);
                let mut found: Vec<_> = rows.into_iter().map(outputs).collect();
                found.resize(points.len(), None);
                found
            }
            Over::Static => points.par_iter().map(|point| self.at_rest(point)).collect(),
            Over::Drive(poses, values) => {
                points.par_iter().map(|point| self.over_drive(point, poses, values)).collect()
            }
        };
        let is_finite = |values: &Vec<f64>| values.iter().all(|value| value.is_finite());
        found.into_iter().map(|values| values.filter(is_finite)).collect()
    }

    /// The first equilibrium.
    fn at_rest(&self, point: &[f64]) -> Option<Vec<f64>> {
        let parameters = self.study.parameters_at(point)?;
        let mut model = self.study.mechanism().model;
        for (parameter, value) in model.parameters.iter_mut().zip(&parameters) {
            parameter.value = *value;
        }
        let found = statics(model, &[], &[]).ok()?;
        let first = found.equilibria.first()?;
        let n = first.q.len();
        let sample = Sample {
            q: first.q.clone(),
            v: vec![0.0; n],
            a: vec![0.0; n],
            lambda: first.lambda.clone(),
            reactions: first.reactions.clone(),
            ..self.blank()
        };
        Some(self.study.outputs_of(&parameters, &[sample]))
    }

    /// Positions over the range, the measure in place of time; rates are by it.
    fn over_drive(&self, point: &[f64], poses: &Poses, values: &[f64]) -> Option<Vec<f64>> {
        let parameters = self.study.parameters_at(point)?;
        let mut solver = poses.solver();
        let mut pose: Pose = solver.follow(&poses.start, &parameters, &poses.start.u).ok()?;
        let mut samples = Vec::with_capacity(values.len());
        for &value in values {
            pose = solver.follow(&pose, &parameters, &[value]).ok()?;
            let rate = solver.rate(&pose)?;
            let a = vec![f64::NAN; pose.q.len()];
            samples.push(Sample { t: value, q: pose.q.clone(), v: rate, a, ..self.blank() });
        }
        Some(self.study.outputs_of(&parameters, &samples))
    }

    /// A sample that has nothing.
    fn blank(&self) -> Sample {
        let model = self.study.mechanism().model;
        Sample {
            reactions: vec![[f64::NAN; 6]; model.joints.len()],
            signals: vec![f64::NAN; model.named_signals.len()],
            inputs: vec![f64::NAN; model.inputs.len()],
            ..Sample::default()
        }
    }
}

/// All that a search needs.
struct Search<'a> {
    ranges: &'a [Range],
    cases: &'a [Case],
    rows: &'a [Row],
    n_parts: usize,
    n_equal: usize,
    is_squared: bool,
    watch: Watch<'a>,
}

/// Points of a global search whose paths are followed.
const FOLLOWED: usize = 5;

impl Search<'_> {
    fn unscaled(&self, x: &[f64]) -> Vec<f64> {
        let ranges = self.ranges.iter().zip(x);
        ranges.map(|(range, x)| range.from + x * (range.to - range.from)).collect()
    }

    /// By point: goals, equations, conditions of all cases, then the objective by case.
    fn functions(&self, points: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
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
            let values: Vec<&Vec<f64>> =
                by_case.iter().map(|case| case[k].as_ref()).collect::<Option<_>>()?;
            let mut all = of_kind(&values, 0..self.n_parts);
            all.extend(of_kind(&values, self.n_parts..self.n_parts + self.n_equal));
            all.extend(of_kind(&values, self.n_parts + self.n_equal..n));
            all.extend(values.iter().map(|case| case[n]));
            Some(all)
        };
        (0..points.len()).map(at).collect()
    }

    /// The row and the case of every function.
    fn order(&self) -> Vec<(usize, usize)> {
        let (a, b, n) = (self.n_parts, self.n_parts + self.n_equal, self.rows.len());
        let kinds = [0..a, a..b, b..n];
        let of = |kind: std::ops::Range<usize>| {
            (0..self.cases.len()).flat_map(move |case| kind.clone().map(move |row| (row, case)))
        };
        kinds.into_iter().flat_map(of).collect()
    }

    fn answer(
        &self,
        source: &Source,
        (goal, objective): (&'static str, &str),
        (conditions, named): (&[Condition], &[(String, Vec<(String, String)>)]),
        wish: &OptimizeWish,
    ) -> Result<Optimized, DesignError> {
        let n_cases = self.cases.len();
        let n_functions = self.rows.len() * n_cases;
        let evaluations = std::sync::atomic::AtomicU64::new(0);
        let counted = |points: &[Vec<f64>]| {
            let n = (points.len() * n_cases) as u64;
            evaluations.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
            self.functions(points)
        };

        // Starts: that of the model, then the best of Sobol's sequence.
        let of_model: Vec<f64> = self
            .ranges
            .iter()
            .map(|r| ((r.stated.value - r.from) / (r.to - r.from)).clamp(0.0, 1.0))
            .collect();
        let before = counted(std::slice::from_ref(&of_model)).pop().flatten();
        let asked = usize::try_from(wish.starts.unwrap_or(0)).unwrap_or(usize::MAX).min(1 << 16);
        let n_points = if before.is_none() { asked.max(64) } else { asked };
        let points: Vec<Vec<f64>> = (0..n_points).map(|k| sobol(k, self.ranges.len())).collect();
        let found = counted(&points);

        // Scales: the size of every function among the points that have values.
        let all: Vec<&Vec<f64>> = before.iter().chain(found.iter().flatten()).collect();
        if all.is_empty() {
            let message = format!(
                "none of {} points of the ranges has a mechanism that closes and runs to its end",
                n_points + 1
            );
            let help = "correct the model until `bksim solve` runs, or choose ranges around values with which it does";
            return Err(DesignError::fault(codes::NO_START, message, help));
        }
        let order = self.order();
        let n_goals = self.n_parts * n_cases;
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
        let problem = Problem {
            n: self.ranges.len(),
            n_goals,
            n_equal: self.n_equal * n_cases,
            evaluate: &scaled,
            stop: self.watch.stop,
            reached: &|iteration, merit| {
                (self.watch.reached)(&format!("iteration {iteration}, {merit:.6}"), 0.0);
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
        if before.is_some() {
            starts.insert(0, (0.0, of_model.clone()));
        }

        // Each to its end; the best that meets the conditions.
        let mut ends: Vec<Ended> = Vec::new();
        for (_, from) in starts {
            if (self.watch.stop)() && !ends.is_empty() {
                break;
            }
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
        let values = self.functions(std::slice::from_ref(&best.x)).pop().flatten();
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
                    at_bound,
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
            goal,
            objective: objective.to_owned(),
            unit: units[self.rows.len()].unit.clone(),
            before: before.as_deref().map(objective_of),
            after,
            quantities,
            conditions,
            converged: best.stationarity < 1e-5,
            stopped: is_stopped,
            stationarity: best.stationarity,
            starts: [ends.len(), n_same],
            evaluations: evaluations.into_inner(),
            iterations: best.n_iterations,
            slopes: "differences of fourth order",
            model: source.with_values(&patches)?,
        })
    }

    /// Where the largest violation of a condition is least, from where a search ended.
    fn nearest(
        &self,
        problem: &Problem<'_>,
        from: &Ended,
        evaluate: &dyn Fn(&[Vec<f64>]) -> Vec<Option<Vec<f64>>>,
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
        named: &[(String, Vec<(String, String)>)],
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
