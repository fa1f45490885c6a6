//! The last words of `bksim solve`, as text and as JSON.

use std::path::Path;
use std::time::Duration;

use bksim::Mechanism;
use bksim::describe;
use bksim::model::message::counted;
use bksim::model::{Formulation, Outputs};
use bksim::options::described;
use bksim::sim::mobility::Mobility;
use bksim::sim::run::{Integrator, Summary};
use bksim::sim::sensitivity::Sensitive;
use serde_json::{Map, Value, json};

use crate::exit::Status;
use crate::output::{facts, number, size};
use crate::source::Text;

/// Time spent in each phase.
#[derive(Clone, Copy, Default, Debug)]
pub(crate) struct Times {
    pub(crate) parse: Duration,
    pub(crate) derive: Duration,
    pub(crate) compile: Duration,
    pub(crate) assemble: Duration,
    pub(crate) integrate: Duration,
    pub(crate) log: Duration,
}

/// The last words of the command.
pub(crate) struct Report<'a> {
    pub(crate) source: &'a Text,
    pub(crate) path: &'a Path,
    pub(crate) summary: &'a Summary,
    pub(crate) times: &'a Times,
    pub(crate) status: Status,
    pub(crate) mechanism: &'a Mechanism,
    pub(crate) found: &'a Mobility,
    pub(crate) sensitive: &'a [Sensitive],
}

/// Changes of method, and singular poses, that are told one by one; more are counted.
const CHANGES_TOLD: usize = 4;
const POSES_TOLD: usize = 12;

impl Report<'_> {
    pub(crate) fn text(&self) -> String {
        let model = &self.mechanism.model;
        let Summary { n_samples, stats, position_residual, velocity_residual, energy, .. } =
            self.summary;
        let solve = &model.solve;
        // Samples and method.
        let when = match solve.outputs {
            Outputs::Even => format!("every {} s", number(solve.interval())),
            Outputs::Steps => "at every step".to_owned(),
            Outputs::Times(_) => "at given times".to_owned(),
        };
        let kept = |what: &str, [drift, kept]: [f64; 2]| {
            format!("{what} {} (drift {} before projection)", size(kept), size(drift))
        };
        let times = self.phases().map(|(name, time)| format!("{name} {}", milliseconds(time)));
        let total = self.phases().iter().map(|&(_, time)| time).sum();
        let mut rows = vec![("samples", format!("{n_samples}, {when}"))];
        rows.extend(self.methods());
        if !self.sensitive.is_empty() {
            let names: Vec<&str> = self.sensitive.iter().map(|by| by.name(model)).collect();
            rows.push(("derivatives", format!("by {}", some_of(&names))));
        }
        // Work of the integrator.
        rows.push((
            "steps",
            format!(
                "{} accepted, {} rejected, {} failed",
                stats.n_accept, stats.n_reject, stats.n_newton_failed
            ),
        ));
        let mut work = vec![counted(stats.n_residual, "residual", "residuals")];
        if stats.n_newton > 0 {
            work.extend([
                counted(stats.n_newton, "Newton iteration", "Newton iterations"),
                counted(stats.n_jacobian, "Jacobian", "Jacobians"),
                counted(stats.n_factor, "factorisation", "factorisations"),
                counted(stats.n_solve, "solve", "solves"),
            ]);
        }
        rows.push(("work", work.join(", ")));
        // Drift, singular poses and events on the way.
        if !self.mechanism.system.constraints.is_empty() {
            let [position, velocity] = [*position_residual, *velocity_residual];
            let both = [kept("position", position), kept("velocity", velocity)];
            rows.push(("constraints", both.join(", ")));
        }
        let relations = describe::without_bearing(model);
        if !relations.is_empty() {
            let told = format!(
                "no bearing has the force of {}, as it has that of a `rope` or `rack`",
                some_of(&relations)
            );
            rows.push(("relations", told));
        }
        rows.extend(self.singular_poses().map(|told| ("singular", told)));
        let changes = describe::uniqueness(self.mechanism, &self.summary.uniqueness);
        rows.extend(not_unique(&changes).into_iter().map(|told| ("not unique", told)));
        let events = super::events::told(self.mechanism, &self.summary.changes, energy.impacts);
        rows.extend(events.map(|told| ("events", told)));
        // Energy, time and where the log is.
        rows.extend([
            (
                "energy",
                format!(
                    "{} → {} J, work {} J, balance kept to {} J",
                    number(energy.initial),
                    number(energy.last),
                    number(negligible(energy.work, energy.scale)),
                    size(energy.worst_error)
                ),
            ),
            ("time", format!("{} = {}", milliseconds(total), times.join(" + "))),
            ("log", self.path.display().to_string()),
        ]);
        let rows: Vec<_> =
            rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]).collect();
        format!("{}: {}\n{}", model.name, self.ending(), facts(&rows))
    }

    /// The method of the start and what it changed to, with the reasons.
    fn methods(&self) -> Vec<(&'static str, String)> {
        let solve = &self.mechanism.model.solve;
        let mode = match solve.step {
            Some(h) => format!("fixed step {} s", number(h)),
            None => format!("rtol {:e}, atol {:e}", solve.rtol, solve.atol),
        };
        let Some((first, changes)) = self.summary.methods.split_first() else { return Vec::new() };
        let mut rows =
            vec![("method", format!("{}, {mode}", method(self.mechanism, first.method)))];
        let told = changes.iter().take(CHANGES_TOLD);
        rows.extend(told.map(|change| {
            let (t, method) = (number(change.t), method(self.mechanism, change.method));
            ("", format!("from t = {t} s {method}: {}", describe::reason_words(change.reason)))
        }));
        if changes.len() > CHANGES_TOLD {
            let n = changes.len() - CHANGES_TOLD;
            rows.push(("", format!("and {}", counted(n, "more change", "more changes"))));
        }
        rows
    }

    /// When the constraints lost rank, to what, and whose they are.
    fn singular_poses(&self) -> Option<String> {
        let poses = &self.summary.singular_poses;
        let first = poses.first()?;
        let times: Vec<_> = poses.iter().take(POSES_TOLD).map(|pose| number(pose.t)).collect();
        let more = match poses.len().saturating_sub(POSES_TOLD) {
            0 => String::new(),
            rest => format!(" and {rest} more"),
        };
        Some(format!(
            "poses passed at t = {} s{more}: {}, rank {} of {}; multipliers are not unique there",
            times.join(", "),
            some_of(&describe::sources(self.mechanism, &first.rows)),
            first.rank,
            self.mechanism.system.constraints.len(),
        ))
    }

    /// How the run ended, in a few words.
    fn ending(&self) -> String {
        let model = &self.mechanism.model;
        let (from, to) = (number(model.solve.t_start), number(self.summary.t));
        match self.status {
            Status::Done => format!("solved from t = {from} s to {to} s"),
            Status::Interrupted => format!("interrupted at t = {to} s"),
            Status::Terminated => format!("terminated at t = {to} s"),
            _ => format!("stopped early at t = {to} s"),
        }
    }

    pub(crate) fn describe(&self) -> Value {
        let model = &self.mechanism.model;
        let mut times = Map::new();
        let mut total = 0.0;
        for (name, time) in self.phases() {
            total += time.as_secs_f64();
            times.insert(name.to_owned(), json!(time.as_secs_f64()));
        }
        times.insert("total".to_owned(), json!(total));
        let options = described(model, self.sensitive).into_iter();
        let mut body = json!({
            "ok": self.status == Status::Done,
            "model": model.name,
            "file": self.source.path.display().to_string(),
            "output": self.path.display().to_string(),
            "exit_status": self.status.code(),
            "options": options.map(|(k, v)| (k, Value::from(v))).collect::<Map<_, _>>(),
            "mobility": self.found.mobility,
            "redundant": describe::redundant(self.mechanism, self.found),
            "time_s": times,
        });
        let run = describe::summary(self.mechanism, self.summary);
        if let (Some(body), Value::Object(run)) = (body.as_object_mut(), run) {
            body.extend(run);
        }
        body
    }

    fn phases(&self) -> [(&'static str, Duration); 6] {
        let t = self.times;
        [
            ("parse", t.parse),
            ("derive", t.derive),
            ("compile", t.compile),
            ("assemble", t.assemble),
            ("integrate", t.integrate),
            ("log", t.log),
        ]
    }
}

/// From when on which reactions, efforts and multipliers are not unique: a line for each of some changes.
pub(crate) fn not_unique(changes: &[Value]) -> Vec<String> {
    let told = changes.iter().take(CHANGES_TOLD).map(|change| {
        let names = change["not_unique"].as_array().into_iter().flatten();
        let names: Vec<&str> = names.filter_map(Value::as_str).collect();
        let from = number(change["t"].as_f64().unwrap_or(f64::NAN));
        let what = if names.is_empty() { "nothing".to_owned() } else { some_of(&names) };
        format!("from t = {from} s {what}")
    });
    let mut lines: Vec<String> = told.collect();
    let is_unique = |change: &Value| change["self_stresses"] == 0;
    if changes.iter().all(is_unique) {
        return Vec::new();
    }
    if changes.len() > CHANGES_TOLD {
        let n = changes.len() - CHANGES_TOLD;
        lines.push(format!("and {}", counted(n, "more change", "more changes")));
    }
    lines
}

/// The first names of a list, and how many there are besides.
fn some_of(names: &[&str]) -> String {
    const TOLD: usize = 6;
    let told: Vec<_> = names.iter().take(TOLD).map(|name| format!("`{name}`")).collect();
    let rest = names.len().saturating_sub(TOLD);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    told.join(", ") + &more
}

/// A method in words.
fn method(mechanism: &Mechanism, method: Integrator) -> String {
    let solve = &mechanism.model.solve;
    let formulation = match solve.formulation {
        Formulation::Ggl => "stabilised index 2",
        Formulation::Index2 => "index 2",
        Formulation::Index3 => "index 3",
        Formulation::Index1 => "index 1 with projection",
    };
    match method {
        Integrator::Explicit => "explicit, Dormand–Prince 8(5,3)".to_owned(),
        Integrator::Radau => {
            let order = if solve.step.is_some() { "order 5" } else { "variable order" };
            format!("Radau IIA of {order}, {formulation}")
        }
    }
}

/// Zero in place of the rounding that a sum of larger terms has left.
fn negligible(value: f64, scale: f64) -> f64 {
    if value.abs() < 1e-14 * scale { 0.0 } else { value }
}

fn milliseconds(time: Duration) -> String {
    format!("{:.1} ms", time.as_secs_f64() * 1e3)
}
