//! `[optimize]`: the values of some parameters for which a number of the mechanism is least or largest.

mod case;
mod choices;
mod front;
mod functions;
mod peaks;
mod ranges;
mod search;

use std::borrow::Cow;
use std::collections::BTreeMap;

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::stated_ranges;
use bksim_sweep::Study;
use serde::{Deserialize, Serialize};

use crate::base::{Source, Stated, Watch};
use crate::codes;
use crate::error::DesignError;
use crate::poses::Poses;
use crate::spec::{Written, located, ranges_of, section};
use case::driven;
use peaks::{parts_of, peaks, sides, windowed, windows};
use ranges::{Range, outside, ranges};
use search::Search;

/// Load case by its name: values of parameters, each by its name, as written.
pub(crate) type NamedCase = (String, Vec<(String, String)>);

/// Question of an optimum: what is to be least or largest, what varies, and what must hold.
#[derive(Clone, Debug, Default)]
pub struct OptimizeWish {
    /// An output as of a sweep: `rms(drives.motor)`.
    pub minimize: Option<String>,
    /// A second output that is to be small, too: the answer is then a front.
    pub against: Option<String>,
    /// Number of points of a front, 11 unless given.
    pub points: Option<u64>,
    /// Catalogues: of each, one row is taken, with its values of parameters.
    pub choose: Vec<(String, Vec<NamedCase>)>,
    /// In its place, what is to be largest.
    pub maximize: Option<String>,
    /// Parameters and initial values, each with its least and largest value.
    pub vary: Vec<(String, [String; 2])>,
    /// Conditions: two sides with `<=`, `>=` or `==` between them.
    pub subject_to: Vec<String>,
    /// `motion`, `static`, or a range of a measure as `kinematics --drive` takes it.
    pub over: Option<String>,
    /// Load cases: other values of parameters, by name.
    pub cases: Vec<NamedCase>,
    /// Number of points of Sobol's sequence from which the best are followed, besides the start.
    pub starts: Option<u64>,
    /// Points to begin from in place of the model's values; what one leaves out is the model's.
    pub from: Vec<Vec<(String, String)>>,
    /// Searches of a front that was stopped: it goes on after them.
    pub resume: Option<Unfinished>,
}

/// The section `[optimize]`.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
struct Section {
    minimize: Option<Goals>,
    maximize: Option<String>,
    points: Option<u64>,
    #[serde(default)]
    choose: BTreeMap<String, BTreeMap<String, BTreeMap<String, Written>>>,
    vary: Option<Varied>,
    #[serde(default)]
    subject_to: Vec<String>,
    over: Option<String>,
    #[serde(default)]
    cases: BTreeMap<String, BTreeMap<String, Written>>,
    starts: Option<u64>,
    #[serde(default)]
    from: Vec<BTreeMap<String, Written>>,
}

/// One objective, or two of which neither is more important.
#[derive(Deserialize, Debug)]
#[serde(untagged, expecting = "an output, or a list of two outputs")]
enum Goals {
    One(String),
    Two([String; 2]),
}

/// Quantities that vary, with two values each, or by their names alone with those of `[ranges]`.
#[derive(Deserialize, Debug)]
#[serde(untagged, expecting = "names with two values each, or a list of names of `[ranges]`")]
enum Varied {
    Ranges(BTreeMap<String, [Written; 2]>),
    Names(Vec<String>),
}

const EXAMPLE: &str = "write it as `minimize = \"max(drives.motor)\"` and `vary = { l1 = [\"80 mm\", \"120 mm\"] }` below `[optimize]`";

/// A quantity at its optimum.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Optimum {
    /// A parameter or initial value.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// In the model, SI.
    pub before: f64,
    /// At the optimum, SI.
    pub after: f64,
    /// Value as it is written into the model.
    pub written: String,
    /// `lower` or `upper` where it is at its bound.
    pub at_bound: Option<Cow<'static, str>>,
    /// Change of the objective where that bound is moved by one unit of SI.
    pub worth: f64,
}

/// A condition at the optimum.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct ConditionAt {
    /// Condition as written, with its case.
    pub condition: String,
    /// Left side less right side before, SI; `None` where the model has no value there.
    pub before: Option<f64>,
    /// Left side less right side at the optimum, SI.
    pub after: f64,
    /// SI unit of the sides.
    pub unit: String,
    /// True if it holds with equality.
    pub is_active: bool,
    /// Change of the objective where the right side grows by one unit of SI.
    pub worth: f64,
}

/// The answer.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Optimized {
    /// `minimize` or `maximize`.
    pub goal: Cow<'static, str>,
    /// Formula of the objective.
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
    /// True if the conditions of a minimum hold.
    pub converged: bool,
    /// True if it was stopped, so that this is the best so far.
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
    pub slopes: Cow<'static, str>,
    /// Where each start is, to go on from there; none of catalogues and fronts.
    pub ends: Vec<EndOfStart>,
    /// Best combinations of rows of catalogues, the best first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<Choice>,
    /// Points of the front of two objectives, by the first of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub front: Option<Front>,
    /// Finished searches of a front that was stopped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unfinished: Option<Unfinished>,
    /// The text of the model with the values of the optimum.
    #[serde(skip)]
    pub model: String,
    /// Quantities that the model states outside of their ranges.
    #[serde(skip)]
    pub warnings: Vec<Diagnostic>,
}

/// The finished searches of a front that was stopped.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Unfinished {
    /// Check sum of the question with its model.
    pub question: u32,
    /// In the order in which a front makes them.
    pub searches: Vec<Finished>,
}

/// One search of a front.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Finished {
    /// The optimum; `None` where conditions cannot be met.
    pub answer: Option<Box<Optimized>>,
    /// The text of the model with it.
    pub text: String,
}

/// The last point of a start.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct EndOfStart {
    /// The varied quantities, SI.
    pub quantities: BTreeMap<String, f64>,
    /// True if conditions are met.
    pub meets_conditions: bool,
    /// True if it is a minimum.
    pub converged: bool,
}

/// One row of each catalogue.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Choice {
    /// The rows by the names of their catalogues.
    pub rows: BTreeMap<String, String>,
    /// The objective with them; `None` where conditions are not met or nothing closes.
    pub after: Option<f64>,
    /// Why there is none.
    pub why_not: Option<String>,
}

/// Trade of two objectives: of no point can one be made smaller but the other grows.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Front {
    /// The second objective.
    pub against: String,
    /// SI unit of the second objective.
    pub unit: String,
    /// Points from the least of the first objective to the least of the second.
    pub points: Vec<FrontPoint>,
    /// The point whose parts of both ranges are least: the one that the model gets.
    pub compromise: usize,
}

/// A point of a front.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct FrontPoint {
    /// Both objectives, SI.
    pub values: [f64; 2],
    /// The varied quantities there, SI.
    pub quantities: BTreeMap<String, f64>,
    /// Rows of catalogues there.
    pub rows: BTreeMap<String, String>,
}

impl OptimizeWish {
    /// Question that the model asks in `[optimize]`; nothing of a model without the section.
    ///
    /// # Errors
    /// [`codes::BAD_QUESTION`].
    pub fn of_model(text: &str) -> Result<Self, DesignError> {
        let Some(found) = section::<Section>(text, "optimize", EXAMPLE)? else {
            return Ok(Self { vary: stated_ranges(text), ..Self::default() });
        };
        let pair = |[from, to]: [Written; 2]| [from.text(), to.text()];
        let vary = match found.vary {
            Some(Varied::Ranges(ranges)) => {
                ranges.into_iter().map(|(name, range)| (name, pair(range))).collect()
            }
            Some(Varied::Names(names)) => ranges_of(text, &names)?,
            None if found.choose.is_empty() => stated_ranges(text),
            None => Vec::new(),
        };
        let case = |values: BTreeMap<String, Written>| -> Vec<(String, String)> {
            values.into_iter().map(|(name, value)| (name, value.text())).collect()
        };
        let (minimize, against) = match found.minimize {
            Some(Goals::One(text)) => (Some(text), None),
            Some(Goals::Two([first, second])) => (Some(first), Some(second)),
            None => (None, None),
        };
        let rows = |rows: BTreeMap<String, BTreeMap<String, Written>>| {
            rows.into_iter().map(|(name, values)| (name, case(values))).collect()
        };
        Ok(Self {
            minimize,
            against,
            points: found.points,
            choose: found.choose.into_iter().map(|(name, of)| (name, rows(of))).collect(),
            maximize: found.maximize,
            vary,
            subject_to: found.subject_to,
            over: found.over,
            cases: found.cases.into_iter().map(|(name, values)| (name, case(values))).collect(),
            starts: found.starts,
            from: found.from.into_iter().map(case).collect(),
            resume: None,
        })
    }
}

/// One function of the problem, an output of every case.
struct Row {
    /// Text of the row, for messages.
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

/// Finds the optimum of a model, with the best rows of catalogues, or the front of two objectives.
///
/// # Errors
/// [`DesignError`] for what cannot be read, and where nothing closes or conditions exclude each other.
pub fn optimize(
    source: &Source,
    wish: &OptimizeWish,
    watch: Watch<'_>,
) -> Result<Optimized, DesignError> {
    let has_goal = wish.minimize.is_some() || wish.maximize.is_some();
    if has_goal && wish.vary.is_empty() && wish.choose.is_empty() {
        let help = "name what varies with its ends: `vary = { l1 = [\"80 mm\", \"120 mm\"] }`, below `[ranges]`, or `--vary \"l1=80 mm:120 mm\"`";
        return Err(DesignError::fault(codes::NOTHING_ASKED, "nothing varies", help));
    }
    if wish.points.is_some_and(|n| !(3..=1000).contains(&n)) {
        let help = "write 3 to 1000 points, or leave `points` out for 11";
        let fault = DesignError::fault(codes::BAD_QUESTION, "a front has 3 to 1000 points", help);
        return Err(located(fault, &source.text, "points"));
    }
    let mut found = match &wish.against {
        Some(against) => front::front(source, wish, against, watch),
        None => choices::best(source, wish, watch),
    }?;
    found.warnings = outside(source, wish)?;
    Ok(found)
}

/// Finds the optimum of what varies continuously.
fn continuous(
    source: &Source,
    wish: &OptimizeWish,
    watch: Watch<'_>,
) -> Result<Optimized, DesignError> {
    let over = wish.over.as_deref().unwrap_or("motion").trim();
    let is_geometry = is_geometry(wish);
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
    let windows = windows(source, over)?;
    let (parts, is_squared) = parts_of(goal, objective, &windows);
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
        for (sign, small) in peaks(small, &windows) {
            let sign = if sign < 0.0 { "-" } else { "" };
            for large in windowed(-1.0, large, &windows) {
                let text = format!("({large}) - {sign}({small})");
                others.push(Row { text, sign: 1.0, condition });
            }
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

/// True of a question over positions, for which nothing needs a mass.
fn is_geometry(wish: &OptimizeWish) -> bool {
    let over = wish.over.as_deref().unwrap_or("motion").trim();
    over != "motion" && over != "static"
}
