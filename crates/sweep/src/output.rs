//! Outputs of a run: one number each of any signal.
//!
//! ```text
//! final(state.x)        min(energy.total)      mean(state.x)
//! max(reactions.B.fx)   rms(acceleration.x_ddot)       theta1@0.5
//! ```
//!
//! Mean and rms are over time: the trapezoidal rule on the samples of the run.

use bksim::Mechanism;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::suggest;
use bksim::record::{Channels, Signal};
use bksim::sim::run::Sample;

use crate::codes;

/// How a signal becomes one number.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Take {
    /// Its value at the end of the run.
    Final,
    /// Its smallest sample.
    Min,
    /// Its largest sample.
    Max,
    /// Its mean over time.
    Mean,
    /// The root of the mean of its square over time.
    Rms,
    /// Its value at a time, s.
    At(f64),
}

const TAKES: [(&str, Take); 5] = [
    ("final", Take::Final),
    ("min", Take::Min),
    ("max", Take::Max),
    ("mean", Take::Mean),
    ("rms", Take::Rms),
];

/// One number of a run.
#[derive(Clone, PartialEq, Debug)]
pub struct Output {
    /// Its name, such as `max(reactions.B.fx)` or `state.theta@0.5`.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
    /// How the signal becomes a number.
    pub take: Take,
    signal: Signal,
}

impl Output {
    /// Reads `max(reactions.B.fx)`, `theta1@0.5` or `energy.total`, which means its final value. A
    /// field may be named alone where no other signal has a field of this name.
    ///
    /// # Errors
    /// A diagnostic with [`codes::UNKNOWN_OUTPUT`].
    pub fn parse(text: &str, channels: &Channels) -> Result<Self, Diagnostic> {
        let text = text.trim();
        let (take, signal) = match (text.split_once('('), text.split_once('@')) {
            (Some((word, rest)), _) => {
                let found = TAKES.iter().find(|(known, _)| *known == word.trim());
                let (Some((_, take)), Some(inner)) = (found, rest.strip_suffix(')')) else {
                    let words: Vec<&str> = TAKES.iter().map(|(known, _)| *known).collect();
                    let message = format!("`{}` is no output", shorten(text));
                    let help = match found {
                        Some(_) => format!("close it: `{})`", shorten(text)),
                        None => suggest(word.trim(), &words),
                    };
                    return Err(Diagnostic::error(codes::UNKNOWN_OUTPUT, message).help(help));
                };
                (*take, inner.trim())
            }
            (None, Some((signal, at))) => {
                let at = at.trim().trim_end_matches('s').trim();
                match at.parse::<f64>() {
                    Ok(t) if t.is_finite() => (Take::At(t), signal.trim()),
                    _ => {
                        let message = format!("`{}` names no time", shorten(text));
                        let help =
                            format!("write seconds after `@`, as in `{}@0.5`", shorten(signal));
                        return Err(Diagnostic::error(codes::UNKNOWN_OUTPUT, message).help(help));
                    }
                }
            }
            (None, None) => (Take::Final, text),
        };
        let (signal, name, unit) = find(signal, channels)?;
        Ok(Self { name: name_of(take, &name), unit, take, signal })
    }

    /// The final value, the smallest and the largest of every coordinate.
    pub fn defaults(mechanism: &Mechanism, channels: &Channels) -> Vec<Self> {
        let coordinates = mechanism.compiled.coordinates.iter();
        let takes = [Take::Final, Take::Min, Take::Max];
        let outputs = coordinates.flat_map(|coordinate| {
            let name = format!("state.{}", coordinate.name);
            let signal = channels.signal(&name);
            takes.into_iter().filter_map(move |take| {
                let (signal, unit) = (signal?, coordinate.unit.clone());
                Some(Self { name: name_of(take, &name), unit, take, signal })
            })
        });
        outputs.collect()
    }
}

fn name_of(take: Take, signal: &str) -> String {
    match (take, TAKES.iter().find(|(_, known)| *known == take)) {
        (Take::At(t), _) => format!("{signal}@{t}"),
        (_, Some((word, _))) => format!("{word}({signal})"),
        (_, None) => signal.to_owned(),
    }
}

/// The signal of this name, or with this field, and its name and unit.
fn find(word: &str, channels: &Channels) -> Result<(Signal, String, String), Diagnostic> {
    let fits = |name: &str| name == word;
    let whole = channels.signals().find(|(_, name, _)| fits(name));
    let found = whole.or_else(|| {
        let mut of_field = channels.signals().filter(|(_, _, field)| fits(&field.name));
        of_field.next().filter(|_| of_field.next().is_none())
    });
    if let Some((signal, name, field)) = found {
        return Ok((signal, name, field.unit.clone()));
    }
    let same: Vec<String> = channels
        .signals()
        .filter(|(_, _, field)| fits(&field.name))
        .map(|(_, name, _)| name)
        .collect();
    let all: Vec<String> = channels.signals().map(|(_, name, _)| name).collect();
    let (message, names) = match same.as_slice() {
        [] => (format!("a run has no signal `{}`", shorten(word)), all),
        _ => (format!("several signals have a field `{}`", shorten(word)), same),
    };
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Err(Diagnostic::error(codes::UNKNOWN_OUTPUT, message).help(suggest(word, &names)))
}

fn shorten(text: &str) -> String {
    text.chars().take(60).collect()
}

/// The outputs of one run as it goes on.
#[derive(Clone, Debug)]
pub(crate) struct Reducer {
    /// By output: the value so far, or the integral.
    values: Vec<f64>,
    /// By output: the sample before.
    before: Vec<f64>,
    t_start: f64,
    t: f64,
    is_empty: bool,
}

impl Reducer {
    pub(crate) fn new(n_outputs: usize) -> Self {
        let values = vec![0.0; n_outputs];
        Self { before: values.clone(), values, t_start: 0.0, t: 0.0, is_empty: true }
    }

    pub(crate) fn clear(&mut self) {
        self.is_empty = true;
    }

    /// Takes a sample; those of a run come in its order.
    pub(crate) fn take(&mut self, outputs: &[Output], channels: &Channels, sample: &Sample) {
        if self.is_empty {
            self.t_start = sample.t;
        }
        let dt = sample.t - self.t;
        for (idx, output) in outputs.iter().enumerate() {
            let value = channels.value(output.signal, sample);
            let (kept, before) = (&mut self.values[idx], &mut self.before[idx]);
            *kept = match output.take {
                Take::At(t) if sample.t == t => value,
                Take::At(_) if self.is_empty => f64::NAN,
                Take::At(_) => *kept,
                Take::Final => value,
                Take::Mean | Take::Rms if self.is_empty => 0.0,
                _ if self.is_empty => value,
                Take::Min => lesser(*kept, value),
                Take::Max => -lesser(-*kept, -value),
                Take::Mean => *kept + 0.5 * dt * (*before + value),
                Take::Rms => *kept + 0.5 * dt * (*before * *before + value * value),
            };
            *before = value;
        }
        self.t = sample.t;
        self.is_empty = false;
    }

    /// Writes the outputs of the run that has ended.
    pub(crate) fn finish(&self, outputs: &[Output], out: &mut Vec<f64>) {
        let span = self.t - self.t_start;
        let values = outputs.iter().zip(self.values.iter().zip(&self.before));
        out.extend(values.map(|(output, (value, last))| match output.take {
            Take::Mean if span == 0.0 => *last,
            Take::Rms if span == 0.0 => last.abs(),
            Take::Mean => value / span,
            Take::Rms => (value / span).sqrt(),
            _ => *value,
        }));
    }
}

/// The smaller one; NaN where either is NaN, so that nothing undefined is lost.
fn lesser(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}
