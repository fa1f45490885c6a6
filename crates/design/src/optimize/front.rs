//! The front of two objectives: the first is least while the second is held below a bound, which moves from one end to
//! the other (the ε-constraint method; Haimes, Lasdon and Wismer 1971).
//!
//! A front is a sequence of searches, each of which follows from those before. One that was stopped has the finished ones in its
//! answer; given them, it takes their answers in place of searches and goes on, so that nothing shows the interruption.

use std::cell::RefCell;

use super::choices::best;
use super::{Finished, Front, FrontPoint, OptimizeWish, Optimized, Unfinished};
use crate::base::{Source, Watch};
use crate::codes;
use crate::error::DesignError;

/// Part of an objective that is given away for the other one at the ends of a front.
const SLACK: f64 = 1e-9;
/// Points unless their number is given.
const N_POINTS: u64 = 11;

/// Points between the optima of both objectives; the answer is their compromise.
pub(super) fn front(
    source: &Source,
    wish: &OptimizeWish,
    against: &str,
    watch: Watch<'_>,
) -> Result<Optimized, DesignError> {
    let n = wish.points.unwrap_or(N_POINTS);
    let journal = Journal::of(source, wish, watch)?;
    let first = wish.minimize.clone().unwrap_or_default();
    let alone = |objective: &str| OptimizeWish {
        minimize: Some(objective.to_owned()),
        against: None,
        from: Vec::new(),
        resume: None,
        ..wish.clone()
    };
    // The value of the other objective at an optimum: nothing varies.
    let value = |objective: &str, at: &Optimized| {
        let plain = OptimizeWish {
            vary: Vec::new(),
            choose: Vec::new(),
            subject_to: Vec::new(),
            ..alone(objective)
        };
        journal.best(&Source { text: at.model.clone(), ..source.clone() }, &plain)
    };
    // Of all places where one is least, that where the other one is least, too.
    let end = |least: &str, other: &str| -> Result<Optimized, DesignError> {
        let found = journal.best(source, &alone(least))?;
        let mut wish = alone(other);
        let bound = found.after + SLACK * found.after.abs().max(f64::MIN_POSITIVE);
        wish.subject_to.push(format!("{least} <= {bound} {}", found.unit));
        let from = Source { text: found.model.clone(), ..source.clone() };
        match journal.best(&from, &wish) {
            Ok(other) => Ok(Optimized {
                objective: found.objective,
                unit: found.unit,
                before: found.before,
                after: found.after,
                evaluations: found.evaluations + other.evaluations,
                ..other
            }),
            Err(_) => Ok(found),
        }
    };
    let first_end = end(&first, against)?;
    let other_end = || -> Result<(Optimized, Optimized, f64), DesignError> {
        if (watch.stop)() {
            return Err(DesignError::Stopped);
        }
        let other = end(against, &first)?;
        let of_first = value(&first, &other)?.after;
        Ok((value(against, &first_end)?, other, of_first))
    };
    let Some((of_second, other, of_first)) = unless_stopped(other_end())? else {
        let unfinished = Some(journal.unfinished());
        return Ok(Optimized { stopped: true, ends: Vec::new(), unfinished, ..first_end });
    };
    let ends = [first_end, other];
    let (high, low, unit) = (of_second.after, ends[1].after, of_second.unit);
    if high - low <= 1e-9 * high.abs().max(low.abs()) {
        let message = format!("`{first}` and `{against}` are least at the same values");
        let help = "minimize one of them alone";
        return Err(DesignError::fault(codes::BAD_QUESTION, message, help));
    }

    // From the least of the second objective on, which meets every bound.
    let mut found = vec![([of_first, low], ends[1].clone())];
    let mut text = ends[1].model.clone();
    let mut evaluations = ends[0].evaluations + ends[1].evaluations;
    for k in (1..n - 1).rev() {
        if (watch.stop)() {
            break;
        }
        let share = k as f64 / (n - 1) as f64;
        let bound = high + share * (low - high);
        let mut wish = alone(&first);
        wish.subject_to.push(format!("{against} <= {bound} {unit}"));
        let one = journal.best(&Source { text: text.clone(), ..source.clone() }, &wish);
        let Some(one) = unless_stopped(one)? else { break };
        text.clone_from(&one.model);
        evaluations += one.evaluations;
        let Some(second) = unless_stopped(value(against, &one))? else { break };
        let second = second.after;
        found.push(([one.after, second], one));
        (watch.reached)(&format!("point {} of {n}", n - k), 1.0 - share);
    }
    found.push(([ends[0].after, high], ends[0].clone()));
    found.reverse();

    // Parts of the ranges between both ends: the corner in which both are zero is out of reach.
    let part = |[a, b]: [f64; 2]| {
        let [x, y] = [(a - found[0].0[0]) / (of_first - found[0].0[0]), (b - low) / (high - low)];
        x.hypot(y)
    };
    let parts: Vec<f64> = found.iter().map(|(values, _)| part(*values)).collect();
    let compromise = (0..parts.len()).min_by(|a, b| parts[*a].total_cmp(&parts[*b])).unwrap_or(0);
    let points = found
        .iter()
        .map(|(values, one)| FrontPoint {
            values: *values,
            quantities: one.quantities.iter().map(|q| (q.name.clone(), q.after)).collect(),
            rows: one.choices.first().map(|choice| choice.rows.clone()).unwrap_or_default(),
        })
        .collect();
    let (values, mut chosen) = found.swap_remove(compromise);
    if chosen.objective != first {
        (chosen.objective, chosen.after, chosen.unit) = (first, values[0], ends[0].unit.clone());
    }
    chosen.before = ends[0].before;
    for (quantity, of_model) in chosen.quantities.iter_mut().zip(&ends[0].quantities) {
        quantity.before = of_model.before;
    }
    chosen.ends.clear();
    chosen.stopped = (watch.stop)();
    chosen.unfinished = chosen.stopped.then(|| journal.unfinished());
    chosen.evaluations = evaluations;
    chosen.front = Some(Front { against: against.to_owned(), unit, points, compromise });
    Ok(chosen)
}

/// The searches of a front, finished ones first.
struct Journal<'a> {
    watch: Watch<'a>,
    question: u32,
    searches: RefCell<Vec<Finished>>,
    /// Answers that are known and have not been taken.
    known: RefCell<std::vec::IntoIter<Finished>>,
}

impl<'a> Journal<'a> {
    fn of(source: &Source, wish: &OptimizeWish, watch: Watch<'a>) -> Result<Self, DesignError> {
        let Source { text, fixed, changes, .. } = source;
        let plain = OptimizeWish { resume: None, ..wish.clone() };
        let asked = format!("{text} {fixed:?} {changes:?} {plain:?}");
        let question = crc32fast::hash(asked.as_bytes());
        let known = match &wish.resume {
            Some(resume) if resume.question != question => {
                let message = "the front that was stopped is of another question, or another model";
                let help = "ask the question that it was, with the model as it was then, or begin again without `--resume`";
                return Err(DesignError::fault(codes::BAD_QUESTION, message, help));
            }
            Some(resume) => resume.searches.clone(),
            None => Vec::new(),
        };
        let known = RefCell::new(known.into_iter());
        Ok(Self { watch, question, searches: RefCell::default(), known })
    }

    /// The best of a question, from the known answers as long as there are any.
    fn best(&self, source: &Source, wish: &OptimizeWish) -> Result<Optimized, DesignError> {
        let known = self.known.borrow_mut().next();
        let is_known = known.is_some();
        let found = match known {
            Some(Finished { answer: Some(answer), text }) => {
                Ok(Optimized { model: text, ..*answer })
            }
            // Who goes on after a fault does so again.
            Some(_) => Err(DesignError::Stopped),
            None => best(source, wish, self.watch),
        };
        // What a signal cut short is searched again.
        if !is_known && (self.watch.stop)() {
            return found;
        }
        let text = found.as_ref().map_or_else(|_| String::new(), |found| found.model.clone());
        let answer = found.as_ref().ok().cloned().map(Box::new);
        self.searches.borrow_mut().push(Finished { answer, text });
        found
    }

    fn unfinished(&self) -> Unfinished {
        let mut searches = self.searches.borrow().clone();
        searches.extend(self.known.borrow().clone());
        Unfinished { question: self.question, searches }
    }
}

/// `None` of what was stopped before it had anything.
fn unless_stopped<T>(found: Result<T, DesignError>) -> Result<Option<T>, DesignError> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(DesignError::Stopped) => Ok(None),
        Err(error) => Err(error),
    }
}
