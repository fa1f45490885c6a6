//! A run against the same motion by an independent formulation: other coordinates, another integrator, tighter
//! tolerances.
//!
//! ```text
//! difference of a channel  max |x − x*|      angles without whole turns
//! allowed                  f (atol + rtol max |x|)    f = 10 for positions, 100 for rates and energies,
//!                                                     1000 for accelerations and reactions
//! ```
//!
//! The largest |x| is that of all channels of the kind and unit: an error of one shows in those that it moves. Where that is
//! exceeded, the growth of a small difference of the start is measured ([`crate::growth`]), by which every error of a
//! run grows, too: allowed is as much more, up to the time at which it hides all else.

use std::cell::Cell;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use bksim_mbs::coordinate::{Coordinate, Owner};
use bksim_mbs::joint::rotation;
use bksim_model::{
    Axis, CoordinatePolicy, Formulation, Measure, Method, Model, Outputs, SolveOptions, Space,
};
use bksim_sim::hybrid::Change;
use bksim_sim::run::Sample;
use bksim_sim::{Mechanism, Motion};

use crate::error::AnalysisError;
use crate::growth::{Growth, growth};
use crate::quantity::pose_quantities;
use crate::scalar::Rates;
use crate::table::{Column, Table};
use crate::watch::Watch;

/// A run next to its independent twin.
#[derive(Clone, PartialEq, Debug)]
pub struct Verified {
    /// How the run and its twin were made.
    pub ways: [Way; 2],
    /// Times that both have, s, but for those at which modes change.
    pub times: Vec<f64>,
    /// In the order of channels.
    pub channels: Vec<Compared>,
    /// The end of the run as it was asked for, s; the last of the times is before it where a run was stopped.
    pub t_end: f64,
    /// How differences grow; measured where a channel exceeds what a calm motion allows.
    pub growth: Option<Growth>,
}

/// Coordinates, method and tolerances of a run.
#[derive(Clone, PartialEq, Debug)]
pub struct Way {
    /// Number of coordinates.
    pub n_coordinates: usize,
    /// Number of constraint rows.
    pub n_constraints: usize,
    /// The integrator that was asked for: `auto`, `explicit` or `radau`.
    pub method: &'static str,
    /// Relative and absolute tolerance.
    pub tolerances: [f64; 2],
    /// Steps that were accepted.
    pub n_steps: usize,
}

/// A channel of both runs.
#[derive(Clone, PartialEq, Debug)]
pub struct Compared {
    /// Name of the compared quantity: `crank.angle`, `A.fx`, `energy.kinetic`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Differences, by time.
    pub differences: Vec<f64>,
    /// The largest of them.
    pub largest: f64,
    /// The time of that, s.
    pub t: f64,
    /// The difference that the tolerances allow, at the time of the largest difference.
    pub allowed: f64,
    /// True where every difference up to the horizon is within what is allowed then.
    pub is_within: bool,
}

impl Verified {
    /// True where every channel keeps to what the tolerances allow.
    pub fn is_within(&self) -> bool {
        self.channels.iter().all(|channel| channel.is_within)
    }

    /// True where the runs were compared up to the end that was asked for.
    pub fn is_whole(&self) -> bool {
        let is_stopped = self.times.last().is_none_or(|last| *last != self.t_end);
        !is_stopped && self.growth.as_ref().is_none_or(|growth| growth.horizon.is_none())
    }

    /// A row for each time: t, then the differences of all channels.
    pub fn table(&self) -> Table {
        let columns = self.channels.iter().map(|c| Column::new(c.name.clone(), c.unit.clone()));
        let columns = std::iter::once(Column::new("t", "s")).chain(columns).collect();
        let row = |(k, t): (usize, &f64)| {
            std::iter::once(*t).chain(self.channels.iter().map(|c| c.differences[k])).collect()
        };
        Table { columns, rows: self.times.iter().enumerate().map(row).collect() }
    }
}

/// Runs `model` as it is and in another way, and compares every channel as far as both runs are let.
///
/// # Errors
/// [`AnalysisError::Rejected`] when it has no start, or one of the runs ends early.
pub fn verify(model: Model, watch: Watch<'_>) -> Result<Verified, AnalysisError> {
    let other = model.snapshot().to_model();
    let own = Mechanism::derive(model, Vec::new())?;
    let simulation = own.simulation()?;
    let motion = watch.run("the run", &simulation, simulation.start()?)?;
    let twin = twin(&own, other, &motion, watch)?;

    // Instants of both; of two samples at one instant the later.
    let ends = |samples: &[Sample], t: f64| samples.iter().rposition(|sample| sample.t == t);
    let mut times: Vec<f64> = motion.samples.iter().map(|sample| sample.t).collect();
    times.dedup();
    let between = switching(&own.model.solve, [&motion, &twin.motion]);
    let last = times.last().copied();
    times.retain(|t| Some(*t) == last || !between.iter().any(|sides| sides.contains(t)));
    let pairs: Vec<(f64, usize, usize)> = times
        .iter()
        .filter_map(|&t| Some((t, ends(&motion.samples, t)?, ends(&twin.motion.samples, t)?)))
        .collect();
    let mut channels = [channels(&own, &motion)?, channels(&twin.mechanism, &twin.motion)?];
    let [first, second] = &mut channels;
    let is_shared = |channel: &Channel| second.iter().any(|other| other.name == channel.name);
    first.retain(is_shared);
    let differences = first.iter().map(|channel| {
        let other = second.iter().find(|other| other.name == channel.name);
        let off = |&(_, i, k): &(f64, usize, usize)| {
            let off = channel.values[i] - other.map_or(f64::NAN, |other| other.values[k]);
            if channel.unit == "rad" { off - TAU * (off / TAU).round() } else { off }
        };
        pairs.iter().map(off).collect::<Vec<f64>>()
    });
    let differences: Vec<Vec<f64>> = differences.collect();
    let options = &own.model.solve;
    let compare = |channel: &Channel, differences: Vec<f64>| {
        let alike = first.iter().filter(|c| c.factor == channel.factor && c.unit == channel.unit);
        let size =
            alike.flat_map(|c| &c.values).fold(0.0, |size: f64, value| size.max(value.abs()));
        // A difference that is no number is the largest.
        let at = (0..differences.len()).max_by(|&a, &b| {
            let key = |k: usize| {
                if differences[k].is_nan() { f64::INFINITY } else { differences[k].abs() }
            };
            key(a).total_cmp(&key(b))
        });
        let largest = at.map_or(0.0, |at| differences[at].abs());
        let allowed = channel.factor * (options.atol + options.rtol * size);
        Compared {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            largest: if largest.is_nan() { f64::INFINITY } else { largest },
            t: at.map_or(0.0, |at| pairs[at].0),
            allowed,
            is_within: largest <= allowed,
            differences,
        }
    };
    let compared: Vec<Compared> = first
        .iter()
        .zip(differences)
        .map(|(channel, differences)| compare(channel, differences))
        .collect();
    let mut found = Verified {
        channels: compared,
        times: pairs.iter().map(|(t, ..)| *t).collect(),
        ways: [way(&own, &motion), way(&twin.mechanism, &twin.motion)],
        t_end: own.model.solve.t_end,
        growth: None,
    };
    if !found.is_within()
        && let Some(growth) = growth(&own, &motion, &found.times, watch)?
    {
        found.grown(growth);
    }
    Ok(found)
}

impl Verified {
    /// Allows for differences that grow, up to the horizon.
    fn grown(&mut self, growth: Growth) {
        let n = growth.horizon.map_or(self.times.len(), |horizon| {
            self.times
                .iter()
                .take_while(|t| (**t - self.times[0]).abs() < (horizon - self.times[0]).abs())
                .count()
        });
        for channel in &mut self.channels {
            let share =
                |k: usize| channel.differences[k].abs() / (channel.allowed * growth.factors[k]);
            let worst = (0..n).max_by(|&a, &b| share(a).total_cmp(&share(b)));
            let Some(worst) = worst else { continue };
            channel.is_within = share(worst) <= 1.0;
            channel.largest = channel.differences[worst].abs();
            channel.allowed *= growth.factors[worst];
            channel.t = self.times[worst];
        }
        self.growth = Some(growth);
    }
}

/// Spans of time in which two runs are on different sides of a change of modes: accelerations and forces may jump
/// there, and a sample at that very instant shows one side or the other. Changes that lie farther apart than the
/// tolerance of `options` lets them are no such.
fn switching(options: &SolveOptions, runs: [&Motion; 2]) -> Vec<RangeInclusive<f64>> {
    let [own, twin] = runs.map(|run| &run.summary.changes);
    let span = (options.t_end - runs[0].start.t).abs();
    let allowed = RATE * options.rtol.max(options.atol) * span;
    let rounding = ROUNDING * (span + options.t_end.abs());
    let sides = |t: f64| {
        let off = |other: &&Change| (other.t - t).abs();
        let nearest = twin.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let other = nearest.filter(|other| off(other) <= allowed)?.t;
        Some(t.min(other) - rounding..=t.max(other) + rounding)
    };
    own.iter().filter_map(|change| sides(change.t)).collect()
}

/// A run in another way.
struct Twin {
    mechanism: Mechanism,
    motion: Motion,
}

fn way(mechanism: &Mechanism, motion: &Motion) -> Way {
    let options = &mechanism.model.solve;
    Way {
        n_coordinates: mechanism.compiled.nq(),
        n_constraints: mechanism.compiled.nc(),
        method: match options.method {
            Method::Auto => "auto",
            Method::Radau => "radau",
            Method::Explicit => "explicit",
        },
        tolerances: [options.rtol, options.atol],
        n_steps: motion.summary.stats.n_accept,
    }
}

/// Steps that a run in other coordinates may take, and as many times those of the run itself: next to a pose that is
/// singular in them alone, all that is left are steps of rounding.
const ALWAYS: usize = 10_000;
const TIMES_OWN: usize = 100;

/// Runs the same motion in other coordinates, by a method that the run has not, a hundredth of its tolerances;
/// where no start closes in those coordinates, as with wheels whose turns count, in its own.
fn twin(
    own: &Mechanism,
    model: Model,
    motion: &Motion,
    watch: Watch<'_>,
) -> Result<Twin, AnalysisError> {
    let is_absolute = own.system.tree.cuts.len() == own.model.joints.len();
    let others = if is_absolute { CoordinatePolicy::Relative } else { CoordinatePolicy::Absolute };
    let mut elsewhere = model.snapshot().to_model();
    elsewhere.coordinates = others;
    elsewhere.forget_cuts();
    elsewhere.bodies.iter_mut().for_each(|body| body.coordinate_names.clear());
    let last = |motion: &Motion| motion.samples.last().map_or(0.0, |sample| sample.t);
    let n_most = ALWAYS + TIMES_OWN * motion.summary.stats.n_step;
    let n_asked = Cell::new(0);
    let stop = || {
        n_asked.set(n_asked.get() + 1);
        n_asked.get() > n_most || (watch.stop)()
    };
    let first = tried(own, elsewhere, motion, Watch { stop: &stop, ..watch });
    // Where other coordinates come to less than half of the motion in their steps, the own ones may come farther.
    let begun = motion.start.t;
    let is_enough =
        |twin: &Twin| (last(&twin.motion) - begun).abs() >= 0.5 * (last(motion) - begun).abs();
    match first {
        Ok(twin) if is_enough(&twin) => Ok(twin),
        Err(_) => tried(own, model, motion, watch),
        Ok(slow) => Ok(match tried(own, model, motion, watch) {
            Ok(twin) if (last(&twin.motion) - begun).abs() > (last(&slow.motion) - begun).abs() => {
                twin
            }
            _ => slow,
        }),
    }
}

/// Runs a model from where another motion began: first by a method that this has not, then by both.
fn tried(
    own: &Mechanism,
    mut model: Model,
    motion: &Motion,
    watch: Watch<'_>,
) -> Result<Twin, AnalysisError> {
    let options = &mut model.solve;
    options.step = None;
    (options.rtol, options.atol) = (tighter(options.rtol), tighter(options.atol));
    options.outputs = Outputs::Times(motion.samples.iter().map(|sample| sample.t).collect());
    let was_radau = own.model.solve.method == Method::Radau || own.model.solve.step.is_some();
    options.method = if was_radau { Method::Auto } else { Method::Radau };
    options.formulation = match options.formulation {
        Formulation::Index2 => Formulation::Ggl,
        _ => Formulation::Index2,
    };
    let mut mechanism = Mechanism::derive(model, Vec::new())?;
    let began = state_in(own, &mechanism, motion)?;
    let run = |mechanism: &Mechanism| -> Result<Motion, AnalysisError> {
        let simulation = mechanism.simulation()?;
        let mut start = simulation.start()?;
        (start.q, start.v) = began.clone();
        watch.run("the same in another way", &simulation, start)
    };
    // What is stiff has no explicit run, and some formulations stall near rounding.
    let first = run(&mechanism);
    if first.is_err() {
        (mechanism.model.solve.method, mechanism.model.solve.formulation) =
            (Method::Auto, Formulation::Index2);
        return run(&mechanism).map(|motion| Twin { mechanism, motion });
    }
    first.map(|motion| Twin { mechanism, motion })
}

/// A hundredth of a tolerance, as far as rounding lets it be.
fn tighter(tolerance: f64) -> f64 {
    (0.01 * tolerance).max(1e-13).min(tolerance)
}

/// The start of a motion in the coordinates of another mechanism.
fn state_in(
    own: &Mechanism,
    other: &Mechanism,
    motion: &Motion,
) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
    let model = &own.model;
    let kinematics = &own.system.kinematics;
    let axes = [Axis::X, Axis::Y, Axis::Z];
    let n_slides = if model.space == Space::Planar { 2 } else { 3 };
    // The turning of a body in a joint of the tree is that of the joint's frames.
    let joint_of = |mechanism: &Mechanism, c: &Coordinate| match c.owner {
        Owner::Quaternion(body, _) => mechanism.system.tree.joint_of(body),
        _ => None,
    };
    let value = |c: &Coordinate| {
        let joint = joint_of(other, c);
        let is_same =
            |own_one: &&Coordinate| own_one.owner == c.owner && joint_of(own, own_one) == joint;
        if let Some(same) = own.system.coordinates().iter().find(is_same) {
            return model.pool.symbol_expr(same.q);
        }
        match c.owner {
            Owner::Joint(joint, motion) => kinematics.joint_positions(model, joint)[motion],
            Owner::Body(body, k) if k < n_slides => {
                kinematics.measure(model, Measure::PointPosition(body, None, axes[k]))
            }
            Owner::Body(body, _) if model.space == Space::Planar => {
                kinematics.measure(model, Measure::BodyAngle(body))
            }
            Owner::Body(body, k) => kinematics.measure(model, Measure::CardanAngle(body, k - 3)),
            Owner::Quaternion(body, part) => match joint {
                None => kinematics.measure(model, Measure::Quaternion(body, part)),
                Some(joint) => {
                    let joint = &model.joints[joint.0];
                    let turned = rotation(&model.pool, joint, &kinematics.sides(model, joint));
                    turned.quaternion(&model.pool).0[part]
                }
            },
            Owner::State(_) => model.pool.zero(),
        }
    };
    let functions: Vec<_> = other.system.coordinates().iter().map(value).collect();
    let parameters = motion.start.parameters_with_modes(&own.parameters);
    let mut rates = Rates::compile(model, own.system.integrated(), &functions, &parameters)?;
    let start = &motion.start;
    let at = rates.at(start.t, [&start.q, &start.v, &start.a]);
    Ok(at.iter().map(|[value, rate, _]| (*value, *rate)).unzip())
}

/// A channel of one run.
struct Channel {
    name: String,
    unit: String,
    factor: f64,
    values: Vec<f64>,
}

/// Part of a run's time within which two instants are one.
const ROUNDING: f64 = 1e-12;

const POSITION: f64 = 10.0;
const RATE: f64 = 100.0;
const ACCELERATION: f64 = 1000.0;

/// Everything that joints, bodies and points show, the reactions that are unique, and the energies.
fn channels(mechanism: &Mechanism, motion: &Motion) -> Result<Vec<Channel>, AnalysisError> {
    let model = &mechanism.model;
    let system = mechanism.system.integrated();
    let coordinates: Vec<&str> = system.coordinates().iter().map(|c| c.name.as_str()).collect();
    let mut quantities = pose_quantities(model, system);
    quantities.retain(|quantity| !coordinates.contains(&quantity.names[0].as_str()));
    let functions: Vec<_> = quantities.iter().map(|quantity| quantity.value).collect();
    let parameters = motion.start.parameters_with_modes(&mechanism.parameters);
    let mut rates = Rates::compile(model, system, &functions, &parameters)?;
    let rows: Vec<Vec<[f64; 3]>> =
        motion.samples.iter().map(|s| rates.at(s.t, [&s.q, &s.v, &s.a])).collect();
    let mut found = Vec::new();
    for (i, quantity) in quantities.iter().enumerate() {
        for (level, factor) in [POSITION, RATE, ACCELERATION].into_iter().enumerate() {
            found.push(Channel {
                name: quantity.names[level].clone(),
                unit: quantity.units()[level].clone(),
                factor,
                values: rows.iter().map(|row| row[i][level]).collect(),
            });
        }
    }
    for (idx, joint) in model.joints.iter().enumerate() {
        let words =
            [("fx", "N"), ("fy", "N"), ("fz", "N"), ("mx", "N*m"), ("my", "N*m"), ("mz", "N*m")];
        for (k, (word, unit)) in words.into_iter().enumerate() {
            let is_unique = motion
                .summary
                .uniqueness
                .iter()
                .all(|change| change.uniqueness.reactions.get(idx).is_none_or(|six| six[k]));
            if is_unique {
                found.push(Channel {
                    name: format!("{}.{word}", joint.name),
                    unit: unit.to_owned(),
                    factor: ACCELERATION,
                    values: motion.samples.iter().map(|s| s.reactions[idx][k]).collect(),
                });
            }
        }
    }
    let energy = |name: &str, value: &dyn Fn(&Sample) -> f64| Channel {
        name: format!("energy.{name}"),
        unit: "J".to_owned(),
        factor: RATE,
        values: motion.samples.iter().map(value).collect(),
    };
    found.push(energy("kinetic", &|s| s.energy.kinetic));
    found.push(energy("potential", &|s| s.energy.potential));
    Ok(found)
}
