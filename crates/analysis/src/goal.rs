//! [`Goal`]: one number of a run, with its derivatives by what the samples show.
//!
//! ```text
//! J = hₖ               the last, the largest or the smallest sample    ∂J/∂hₖ = 1
//! J = Σ wᵢ hᵢ          the mean                                        ∂J/∂hᵢ = wᵢ
//! J = √(Σ wᵢ hᵢ²)      the root of the mean square                     ∂J/∂hᵢ = wᵢ hᵢ / J
//! ```
//!
//! w are the weights of the trapezoidal rule in time, over the whole time. Times of samples are held.

use bksim_mbs::constraint::Source;
use bksim_mbs::quantity::Quantity;
use bksim_model::{CouplingId, Measure, Model};
use bksim_sim::Mechanism;
use bksim_sim::observable::Observables;
use bksim_sim::run::Sample;
use bksim_sim::sensitivity::{SampleWeights, channels};

use crate::error::AnalysisError;
use crate::table::Column;

/// How a quantity over time becomes one number.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum GoalTake {
    /// Value at the end of the run.
    #[default]
    Last,
    /// Mean over time, by the trapezoidal rule.
    Mean,
    /// The root of the mean of its square over time, by the trapezoidal rule.
    Rms,
    /// Largest sample.
    Max,
    /// Smallest sample.
    Min,
}

impl GoalTake {
    /// The word for it: `last`, `mean`, `rms`, `max` or `min`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Last => "last",
            Self::Mean => "mean",
            Self::Rms => "rms",
            Self::Max => "max",
            Self::Min => "min",
        }
    }

    /// The number of some samples, and its derivatives by their values; `None` where it has none, as the root of a
    /// mean square that is zero.
    pub fn of(self, times: &[f64], values: &[f64]) -> (f64, Option<Vec<f64>>) {
        let Some(last) = values.len().checked_sub(1) else { return (f64::NAN, Some(Vec::new())) };
        let one = |k: usize| {
            let weight = |i: usize| if i == k { 1.0 } else { 0.0 };
            (values[k], Some((0..values.len()).map(weight).collect()))
        };
        match self {
            Self::Last => one(last),
            Self::Max => one(first_of(values, |value, most| value > most)),
            Self::Min => one(first_of(values, |value, least| value < least)),
            Self::Mean => {
                let weights = weights_over_time(times);
                (weights.iter().zip(values).map(|(w, h)| w * h).sum(), Some(weights))
            }
            Self::Rms => {
                let weights = weights_over_time(times);
                let square: f64 = weights.iter().zip(values).map(|(w, h)| w * h * h).sum();
                let rms = square.sqrt();
                let slopes = || weights.iter().zip(values).map(|(w, h)| w * h / rms).collect();
                (rms, (rms > 0.0).then(slopes))
            }
        }
    }
}

/// The first of the values that are ahead of all others.
fn first_of(values: &[f64], is_ahead: impl Fn(f64, f64) -> bool) -> usize {
    (1..values.len()).fold(0, |best, k| if is_ahead(values[k], values[best]) { k } else { best })
}

/// The weights of the mean over some times; of one time alone, of its last sample.
fn weights_over_time(times: &[f64]) -> Vec<f64> {
    let mut weights = vec![0.0; times.len()];
    let span = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    if span == 0.0 {
        weights.last_mut().into_iter().for_each(|weight| *weight = 1.0);
        return weights;
    }
    for (k, pair) in times.windows(2).enumerate() {
        let half = 0.5 * (pair[1] - pair[0]) / span;
        weights[k] += half;
        weights[k + 1] += half;
    }
    weights
}

/// A part of a sample and of its weights.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Part {
    Position,
    Velocity,
    Acceleration,
    Multiplier,
    Channel,
}

/// The place of a quantity in the weights of a sample.
#[derive(Clone, Debug)]
struct Place {
    column: Column,
    part: Part,
    /// In its part.
    idx: usize,
    /// The length of its part.
    len: usize,
}

/// Where the values of a quantity come from.
#[derive(Clone, Debug)]
enum Reading {
    /// The number of its part.
    Own,
    /// One of [`ENERGIES`].
    Energy(usize),
    /// A joint, and one of [`COMPONENTS`].
    Reaction(usize, usize),
    /// A named signal.
    Signal(usize),
    Observed(Box<Observables>),
}

/// Parts of the energy.
const ENERGIES: [&str; 4] = ["kinetic", "potential", "total", "power"];
/// Components of a reaction, world axes.
const COMPONENTS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// A quantity of the samples of a run that has derivatives.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    place: Place,
    reading: Reading,
    more: Vec<String>,
}

impl Goal {
    /// The quantity of a name: what derivatives in a log are called, `theta1_dot`, `reactions.B.fx`, columns of a run,
    /// `state.theta1_dot`, `drives.motor`, and whatever [`Measure::named`] finds.
    ///
    /// # Errors
    /// [`AnalysisError::UnknownGoal`] when nothing with a derivative has this name.
    pub(crate) fn named(mechanism: &Mechanism, name: &str) -> Result<Self, AnalysisError> {
        let (model, all) = (&mechanism.model, places(mechanism));
        let find = |name: &str| all.iter().find(|place| place.column.name == name).cloned();
        let signal = || find(&format!("signals.{}", model.signal_named(name)?.name));
        let found = find(name).or_else(|| find(&without_topic(name)?)).or_else(signal);
        let found = found.or_else(|| effort(mechanism, &all, name));
        if let Some(place) = found {
            let reading = match place.part {
                Part::Channel => of_sample(model, &place.column.name),
                _ => Some(Reading::Own),
            };
            let observed = || observed(mechanism, &place.column.name).map(|(reading, _)| reading);
            let reading = reading.map_or_else(observed, Ok)?;
            return Ok(Self { place, reading, more: Vec::new() });
        }
        let (reading, unit) = observed(mechanism, name)?;
        let idx = all.iter().filter(|place| place.part == Part::Channel).count();
        let column = Column::new(name, unit);
        let place = Place { column, part: Part::Channel, idx, len: idx + 1 };
        Ok(Self { place, reading, more: vec![name.to_owned()] })
    }

    /// Quantities of these names, with the names of those that are none of the channels that a run has derivatives of.
    ///
    /// # Errors
    /// [`AnalysisError::UnknownGoal`] as for one.
    pub(crate) fn all(
        mechanism: &Mechanism,
        names: &[String],
    ) -> Result<(Vec<Self>, Vec<String>), AnalysisError> {
        let mut more: Vec<String> = Vec::new();
        let mut all = Vec::new();
        for name in names {
            let mut goal = Self::named(mechanism, name)?;
            goal.place.idx += if goal.more.is_empty() { 0 } else { more.len() };
            more.append(&mut goal.more.clone());
            all.push(goal);
        }
        // Weights have a place for each of them.
        for goal in &mut all {
            if goal.place.part == Part::Channel {
                goal.place.len += more.len() - goal.more.len();
            }
        }
        Ok((all, more))
    }

    /// Name of the goal, if it is none of the channels that a run has derivatives of.
    pub(crate) fn more(&self) -> &[String] {
        &self.more
    }

    /// Name and unit.
    pub(crate) fn column(&self) -> &Column {
        &self.place.column
    }

    /// Value in a sample.
    pub(crate) fn value(&mut self, sample: &Sample) -> f64 {
        let Place { part, idx, .. } = self.place;
        match &mut self.reading {
            Reading::Own => match part {
                Part::Position => sample.q[idx],
                Part::Velocity => sample.v[idx],
                Part::Acceleration => sample.a[idx],
                Part::Multiplier | Part::Channel => sample.lambda[idx],
            },
            Reading::Energy(k) => {
                let energy = &sample.energy;
                let total = energy.kinetic + energy.potential;
                [energy.kinetic, energy.potential, total, energy.power][*k]
            }
            Reading::Reaction(joint, component) => sample.reactions[*joint][*component],
            Reading::Signal(k) => sample.signals[*k],
            Reading::Observed(observables) => {
                let mut value = [0.0];
                let state = [&sample.q[..], &sample.v, &sample.a, &sample.lambda];
                observables.at(state, &|joint| sample.reactions[joint.0], &mut value);
                value[0]
            }
        }
    }

    /// The weights of a sample on whose value the number depends by `weight`.
    pub(crate) fn weights(&self, weight: f64) -> SampleWeights {
        let mut weights = SampleWeights::default();
        self.weigh(weight, &mut weights);
        weights
    }

    /// Adds [`Goal::weights`] to other weights of the sample.
    pub(crate) fn weigh(&self, weight: f64, to: &mut SampleWeights) {
        let Place { part, idx, len, .. } = self.place;
        let own = match part {
            Part::Position => &mut to.q,
            Part::Velocity => &mut to.v,
            Part::Acceleration => &mut to.a,
            Part::Multiplier => &mut to.lambda,
            Part::Channel => &mut to.channels,
        };
        own.resize(len, 0.0);
        own[idx] += weight;
    }
}

/// Everything that has derivatives, in the order of weights.
fn places(mechanism: &Mechanism) -> Vec<Place> {
    let coordinates = &mechanism.compiled.coordinates;
    let rates = |order: usize| {
        let column =
            move |c: &Quantity| Column::new(c.rates[order][0].clone(), c.rates[order][1].clone());
        coordinates.iter().map(column).collect::<Vec<_>>()
    };
    let of_quantity = |q: &Quantity| Column::new(q.name.clone(), q.unit.clone());
    let shown = channels(&mechanism.model, &mechanism.system);
    let parts: [(Part, Vec<Column>); 5] = [
        (Part::Position, coordinates.iter().map(of_quantity).collect()),
        (Part::Velocity, rates(0)),
        (Part::Acceleration, rates(1)),
        (Part::Multiplier, mechanism.compiled.multipliers.iter().map(of_quantity).collect()),
        (Part::Channel, shown.into_iter().map(|c| Column::new(c.name, c.unit)).collect()),
    ];
    let of_part = |(part, columns): (Part, Vec<Column>)| {
        let len = columns.len();
        let place = move |(idx, column): (usize, Column)| Place { column, part, idx, len };
        columns.into_iter().enumerate().map(place)
    };
    parts.into_iter().flat_map(of_part).collect()
}

/// The name that derivatives have for a column of a log.
fn without_topic(name: &str) -> Option<String> {
    match name.split_once('.')? {
        ("state" | "acceleration" | "multipliers", own) => Some(own.to_owned()),
        ("outputs", own) => Some(format!("signals.{own}")),
        _ => None,
    }
}

/// The effort of a drive or the force of a coupling: the multiplier of its row.
fn effort(mechanism: &Mechanism, all: &[Place], name: &str) -> Option<Place> {
    let model = &mechanism.model;
    let source = if let Some(Measure::Effort(drive)) = Measure::named(model, name) {
        Source::Drive(drive)
    } else {
        let own = name.strip_prefix("couplings.")?;
        let coupling = model.couplings.iter().position(|coupling| coupling.name == own)?;
        Source::Coupling(CouplingId(coupling))
    };
    let row = mechanism.system.constraints.iter().position(|row| row.source == source)?;
    let mut multipliers = all.iter().filter(|place| place.part == Part::Multiplier);
    let place = multipliers.nth(row)?.clone();
    Some(Place { column: Column { name: name.to_owned(), ..place.column }, ..place })
}

/// Values of a measure along a run, with its unit.
fn observed(mechanism: &Mechanism, name: &str) -> Result<(Reading, String), AnalysisError> {
    let Mechanism { model, system, parameters, .. } = mechanism;
    let known = || {
        let all = places(mechanism).into_iter().map(|place| place.column.name);
        all.chain(Measure::names(model)).collect()
    };
    let unknown = || AnalysisError::UnknownGoal { name: name.to_owned(), known: known() };
    let measure = Observables::named(model, name).ok_or_else(unknown)?;
    let observables = Observables::compile(model, system, &[measure], parameters)?;
    Ok((Reading::Observed(Box::new(observables)), measure.unit(model).to_owned()))
}

/// Values of a channel that a sample has as it is.
fn of_sample(model: &Model, name: &str) -> Option<Reading> {
    let (topic, own) = name.split_once('.')?;
    match topic {
        "energy" => ENERGIES.iter().position(|part| *part == own).map(Reading::Energy),
        "reactions" => {
            let (joint, word) = own.rsplit_once('.')?;
            let joint = model.joints.iter().position(|of| of.name == joint)?;
            let component = COMPONENTS.iter().position(|known| *known == word)?;
            Some(Reading::Reaction(joint, component))
        }
        "signals" => {
            model.named_signals.iter().position(|signal| signal.name == own).map(Reading::Signal)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [GoalTake; 5] =
        [GoalTake::Last, GoalTake::Mean, GoalTake::Rms, GoalTake::Max, GoalTake::Min];

    #[test]
    fn derivatives_are_those_of_differences() {
        // Two samples at one time, as where something switches.
        let times = [0.0, 0.5, 0.75, 0.75, 2.0];
        let values = [1.0, -2.0, 3.0, 0.5, -1.0];
        for take in ALL {
            let weights = take.of(&times, &values).1.expect("derivatives");
            for (k, weight) in weights.iter().enumerate() {
                let at = |off: f64| {
                    let mut values = values;
                    values[k] += off;
                    take.of(&times, &values).0
                };
                let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!((slope - weight).abs() < 1e-8, "{take:?}, {k}: {weight} for {slope}");
            }
        }
    }

    #[test]
    fn means_are_over_time_in_either_direction() {
        let values = [0.0, 1.0, 2.0];
        for times in [[0.0, 1.0, 4.0], [4.0, 3.0, 0.0]] {
            let (mean, weights) = GoalTake::Mean.of(&times, &values);
            assert!((mean - 1.25).abs() < 1e-15, "{mean}");
            let sum: f64 = weights.expect("weights").iter().sum();
            assert!((sum - 1.0).abs() < 1e-15, "{sum}");
        }
    }

    #[test]
    fn one_instant_is_its_own_mean() {
        assert_eq!(GoalTake::Mean.of(&[2.0], &[-3.0]), (-3.0, Some(vec![1.0])));
        assert_eq!(GoalTake::Rms.of(&[2.0], &[-3.0]), (3.0, Some(vec![-1.0])));
    }

    #[test]
    fn a_quantity_that_is_zero_throughout_has_no_slope_of_its_rms() {
        assert_eq!(GoalTake::Rms.of(&[0.0, 1.0], &[0.0, 0.0]), (0.0, None));
    }
}
