//! What `bksim solve` says in the end, in words and as JSON.

use std::path::Path;
use std::time::Duration;

use bksim::Mechanism;
use bksim::mbs::assemble::Source;
use bksim::mbs::model::{Formulation, Method, Model, Outputs, SolveOptions};
use bksim::mbs::run::{Integrator, Reason, Summary};
use bksim::mbs::sensitivity::Sensitive;
use serde_json::{Value, json};

use crate::exit::Status;
use crate::output::{number, size, table};
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

pub(crate) const FORMULATIONS: [(&str, Formulation); 4] = [
    ("ggl", Formulation::Ggl),
    ("index2", Formulation::Index2),
    ("index3", Formulation::Index3),
    ("index1", Formulation::Index1),
];

pub(crate) const METHODS: [(&str, Method); 3] =
    [("auto", Method::Auto), ("radau", Method::Radau), ("explicit", Method::Explicit)];

/// All options of the run as they were used, for the log.
pub(crate) fn options_of(model: &Model, sensitive: &[Sensitive]) -> Vec<(String, String)> {
    let solve = &model.solve;
    let formulation = word(&FORMULATIONS, solve.formulation);
    let method = word(&METHODS, solve.method);
    let exact = |value: f64| format!("{value:?}");
    let every = match solve.outputs {
        Outputs::Steps => "step".to_owned(),
        _ => solve.every.map_or("default".to_owned(), exact),
    };
    let mut options: Vec<(String, String)> = vec![
        ("method".into(), method.into()),
        ("formulation".into(), formulation.into()),
        ("t_start".into(), exact(solve.t_start)),
        ("t_end".into(), exact(solve.t_end)),
        ("every".into(), every),
        ("rtol".into(), exact(solve.rtol)),
        ("atol".into(), exact(solve.atol)),
        ("step".into(), solve.step.map_or("adaptive".to_owned(), exact)),
    ];
    if !sensitive.is_empty() {
        let names: Vec<&str> = sensitive.iter().map(|by| by.name(model)).collect();
        options.push(("sensitivity".into(), names.join(" ")));
    }
    if let Outputs::Times(times) = &solve.outputs {
        let times: Vec<_> = times.iter().copied().map(exact).collect();
        options.push(("times".into(), times.join(" ")));
    }
    options
}

/// The word of a choice.
fn word<T: PartialEq + Copy>(words: &[(&'static str, T)], choice: T) -> &'static str {
    words.iter().find(|(_, known)| *known == choice).map_or("", |(word, _)| word)
}

/// What the command says in the end.
pub(crate) struct Report<'a> {
    pub(crate) source: &'a Text,
    pub(crate) path: &'a Path,
    pub(crate) summary: &'a Summary,
    pub(crate) times: &'a Times,
    pub(crate) status: Status,
    pub(crate) mechanism: &'a Mechanism,
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
            rows.push((
                "derivatives",
                format!("by {}, with Radau IIA throughout", some_of(&names)),
            ));
        }
        rows.push((
            "steps",
            format!(
                "{} accepted, {} rejected, {} failed",
                stats.n_accept, stats.n_reject, stats.n_newton_failed
            ),
        ));
        let mut work = vec![format!("{} residuals", stats.n_residual)];
        if stats.n_newton > 0 {
            work.extend([
                format!("{} Newton iterations", stats.n_newton),
                format!("{} Jacobians", stats.n_jacobian),
                format!("{} factorisations", stats.n_factor),
                format!("{} solves", stats.n_solve),
            ]);
        }
        rows.push(("work", work.join(", ")));
        if !self.mechanism.system.constraints.is_empty() {
            let [position, velocity] = [*position_residual, *velocity_residual];
            let both = [kept("position", position), kept("velocity", velocity)];
            rows.push(("constraints", both.join(", ")));
        }
        rows.extend(self.singular_poses().map(|told| ("singular", told)));
        let events = super::events::told(self.mechanism, &self.summary.changes, energy.blows);
        rows.extend(events.map(|told| ("events", told)));
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
        format!("{}: {}\n{}", model.name, self.ending(), table(&rows))
    }

    /// The method of the start and what it changed to, with the reasons.
    fn methods(&self) -> Vec<(&'static str, String)> {
        let solve = &self.mechanism.model.solve;
        let mode = match solve.step {
            Some(h) => format!("fixed step {} s", number(h)),
            None => format!("rtol {:e}, atol {:e}", solve.rtol, solve.atol),
        };
        let Some((first, changes)) = self.summary.methods.split_first() else { return Vec::new() };
        let mut rows = vec![("method", format!("{}, {mode}", method(solve, first.method)))];
        let told = changes.iter().take(CHANGES_TOLD);
        rows.extend(told.map(|change| {
            let (t, method) = (number(change.t), method(solve, change.method));
            ("", format!("from t = {t} s {method}: {}", reason(change.reason)))
        }));
        if changes.len() > CHANGES_TOLD {
            rows.push(("", format!("and {} more changes", changes.len() - CHANGES_TOLD)));
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
            some_of(&self.sources(&first.rows)),
            first.rank,
            self.mechanism.system.constraints.len(),
        ))
    }

    /// Names of the joints, drives and loads of some constraint rows, each once.
    fn sources(&self, rows: &[usize]) -> Vec<&str> {
        let Mechanism { model, system, .. } = self.mechanism;
        let mut names: Vec<&str> = Vec::new();
        for &row in rows {
            let name = match system.constraints[row].source {
                Source::Joint(joint) => &model.joints[joint.0].name,
                Source::Drive(drive) => &model.drives[drive.0].name,
                Source::Stop(load) | Source::Friction(load) => &model.loads[load.0].name,
            };
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        names
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
        let Summary { t, n_samples, stats, position_residual, velocity_residual, energy, .. } =
            self.summary;
        let mut times = serde_json::Map::new();
        let mut total = 0.0;
        for (name, time) in self.phases() {
            total += time.as_secs_f64();
            times.insert(name.to_owned(), json!(time.as_secs_f64()));
        }
        times.insert("total".to_owned(), json!(total));
        let relative = if energy.scale > 0.0 { energy.worst_error / energy.scale } else { 0.0 };
        json!({
            "ok": self.status == Status::Done,
            "model": model.name,
            "file": self.source.path.display().to_string(),
            "output": self.path.display().to_string(),
            "exit_status": self.status.code(),
            "end": { "reached": self.summary.reached_end, "t": t },
            "samples": n_samples,
            "options": options_of(model, self.sensitive).into_iter().map(|(k, v)| (k, Value::from(v))).collect::<serde_json::Map<_, _>>(),
            "methods": self.summary.methods.iter().map(|change| json!({
                "t": change.t,
                "method": word_of(change.method),
                "reason": reason(change.reason),
            })).collect::<Vec<_>>(),
            "singular_poses": self.summary.singular_poses.iter().map(|pose| json!({
                "t": pose.t,
                "rank": pose.rank,
                "names": self.sources(&pose.rows),
            })).collect::<Vec<_>>(),
            "events": super::events::described(self.mechanism, &self.summary.changes),
            "steps": {
                "n_step": stats.n_step, "n_accept": stats.n_accept, "n_reject": stats.n_reject,
                "n_newton_failed": stats.n_newton_failed, "n_newton": stats.n_newton,
                "n_residual": stats.n_residual, "n_jacobian": stats.n_jacobian,
                "n_factor": stats.n_factor, "n_solve": stats.n_solve,
            },
            "time_s": times,
            "residual": {
                "position": position_residual[1], "velocity": velocity_residual[1],
                "position_before_projection": position_residual[0],
                "velocity_before_projection": velocity_residual[0],
            },
            "energy": {
                "initial": energy.initial, "last": energy.last, "work": energy.work,
                "blows": energy.blows,
                "worst_error": energy.worst_error, "scale": energy.scale,
                "relative_error": relative,
            },
        })
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

/// The first names of a list, and how many there are besides.
fn some_of(names: &[&str]) -> String {
    const TOLD: usize = 6;
    let told: Vec<_> = names.iter().take(TOLD).map(|name| format!("`{name}`")).collect();
    let rest = names.len().saturating_sub(TOLD);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    told.join(", ") + &more
}

/// A method in words.
fn method(solve: &SolveOptions, method: Integrator) -> String {
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

fn word_of(method: Integrator) -> &'static str {
    match method {
        Integrator::Explicit => "explicit",
        Integrator::Radau => "radau",
    }
}

fn reason(reason: Reason) -> &'static str {
    match reason {
        Reason::Asked => "as asked",
        Reason::Cheapest => "least work while the motion is not stiff",
        Reason::Stiff => "the motion is stiff",
        Reason::OtherFailed => "the other method cannot go on here",
        Reason::SingularPose => "past the singular pose ahead",
        Reason::Regular => "behind the singular pose",
    }
}

/// Zero in place of the rounding that a sum of larger terms has left.
fn negligible(value: f64, scale: f64) -> f64 {
    if value.abs() < 1e-14 * scale { 0.0 } else { value }
}

fn milliseconds(time: Duration) -> String {
    format!("{:.1} ms", time.as_secs_f64() * 1e3)
}
