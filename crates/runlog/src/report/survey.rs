//! A run looked through from start to end.

use bksim_mbs::contact::{Contact, Law};
use bksim_mbs::power::Actor;
use bksim_mbs::system::{Switch, SwitchOf};
use bksim_model::{ContactId, Model, MotionKind};
use bksim_sim::Mechanism;
use bksim_sim::redundancy::Uniqueness;
use bksim_sim::run::{Unreplayed, peak};

use super::quantities::{N_ENERGIES, Quantities};
use super::ratio::time_ratio;
use super::{
    DriveReport, EnergyReport, Extreme, MotionReport, OutputReport, PinForce, PointReport,
    ReactionReport, Report, Unreported, WorkReport,
};
use crate::playback::Playback;

/// Nodes and weights of Gauss and Legendre on [0, 1] with three points, exact to degree 5.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Part of stroke and largest rate within which the end of a run repeats its start.
const REPEATS: f64 = 1e-6;

/// Part of a value within which one that is the same throughout a run differs by rounding.
const STEADY: f64 = 1e-9;

/// Rank margin below which reactions and accelerations are those of a singular pose, rounding in place of a
/// result: its constraint Jacobian has a singular value of a hundredth of what it has elsewhere.
const SINGULAR: f64 = 1e-4;

/// A run that is looked at instant by instant.
struct Survey<'p> {
    playback: &'p mut Playback,
    quantities: Quantities,
    /// The channels of the drives' efforts, then those of the outputs.
    signals: Vec<crate::channels::Signal>,
    /// All instants of the grid, and the numbers of each.
    instants: Vec<f64>,
    table: Vec<f64>,
    /// Integrals over the run of all numbers and of their squares, forward in time.
    integrals: Vec<[f64; 2]>,
    /// The kinetic energy that impacts have given, J.
    impacts: f64,
}

impl Survey<'_> {
    /// The numbers at an instant; NaN where a singular pose leaves them undetermined.
    fn at(&mut self, t: f64, out: &mut [f64]) -> Result<(), Unreplayed> {
        self.playback.seek(t)?;
        let signals: Vec<f64> =
            self.signals.iter().map(|&signal| self.playback.value(signal)).collect();
        self.quantities.write(self.playback.sample(), &signals, self.playback.modes(), out);
        if self.playback.rank_margin() < SINGULAR {
            self.quantities.forget_undetermined(out);
        }
        Ok(())
    }

    /// Fills the grid: start, end and Gauss nodes of every step.
    fn fill(&mut self) -> Result<(), Unreplayed> {
        let n = self.quantities.count();
        let steps: Vec<[f64; 2]> =
            self.playback.log().segments.iter().map(|step| [step.t0, step.t1]).collect();
        self.integrals = vec![[0.0; 2]; n];
        let mut row = vec![0.0; n];
        let may_hit = may_hit(self.playback.mechanism());
        for (step_idx, &[t0, t1]) in steps.iter().enumerate() {
            if may_hit {
                self.impacts += self.playback.seek_impact(step_idx)?;
            }
            if step_idx == 0 {
                self.at(t0, &mut row)?;
                self.keep(t0, &row);
            }
            for (node, weight) in GAUSS {
                let t = t0 + node * (t1 - t0);
                self.at(t, &mut row)?;
                let numbers = self.integrals.iter_mut().zip(&row);
                for (integral, value) in numbers.filter(|(_, value)| !value.is_nan()) {
                    integral[0] += weight * (t1 - t0) * value;
                    integral[1] += weight * (t1 - t0).abs() * value * value;
                }
                self.keep(t, &row);
            }
            self.at(t1, &mut row)?;
            self.keep(t1, &row);
        }
        Ok(())
    }

    /// The potentials of all parts at an instant.
    fn potentials(&mut self, t: f64) -> Result<Vec<f64>, Unreplayed> {
        self.playback.seek(t)?;
        let sample = self.playback.sample();
        let state = (sample.t, &sample.q[..], &sample.v[..]);
        let powers = &mut self.quantities.powers;
        Ok(powers.at(state, &sample.lambda, self.playback.modes()).1.to_vec())
    }

    /// The work of every part, from the integrals of their powers.
    fn works(&mut self, [first, last]: [f64; 2]) -> Result<Vec<WorkReport>, Unreplayed> {
        let place = self.quantities.places()[4] + N_ENERGIES;
        let potentials = [self.potentials(first)?, self.potentials(last)?];
        let model = &self.playback.mechanism().model;
        let actors = self.quantities.powers.actors().iter().enumerate();
        let work = |(idx, actor): (usize, &Actor)| {
            let (kind, name) = actor.named(model);
            let stored = potentials[1][idx] - potentials[0][idx];
            WorkReport { name: name.to_owned(), kind, work: self.integrals[place + idx][0], stored }
        };
        // The places of a contact are parts of it.
        let mut works: Vec<WorkReport> = Vec::new();
        for next in actors.map(work) {
            let known = |of: &&mut WorkReport| (of.kind, &of.name) == (next.kind, &next.name);
            match works.iter_mut().find(known) {
                Some(of) => (of.work, of.stored) = (of.work + next.work, of.stored + next.stored),
                None => works.push(next),
            }
        }
        if self.impacts != 0.0 {
            let name = "impacts".to_owned();
            works.push(WorkReport { name, kind: "impact", work: self.impacts, stored: 0.0 });
        }
        Ok(works)
    }

    fn keep(&mut self, t: f64, row: &[f64]) {
        self.instants.push(t);
        self.table.extend_from_slice(row);
    }

    fn value(&self, instant: usize, place: usize) -> f64 {
        self.table[instant * self.quantities.count() + place]
    }

    /// The largest value of a function of one number: of the number, its negative or its size. What is
    /// undetermined is less than all.
    fn largest(&mut self, place: usize, of: fn(f64) -> f64) -> Result<Extreme, Unreplayed> {
        let of = |value: f64| if value.is_nan() { f64::NEG_INFINITY } else { of(value) };
        let n = self.instants.len();
        let best = |best: usize, next: usize| {
            let is_more = of(self.value(next, place)) > of(self.value(best, place));
            if is_more { next } else { best }
        };
        let idx = (1..n).fold(0, best);
        let mut extreme =
            Extreme { value: self.value(idx, place), t: self.instants[idx], is_steady: false };
        // Of what stays as it is, rounding would choose the instant.
        let values = (0..n).map(|instant| self.value(instant, place));
        let is_same = |value: f64| (value - extreme.value).abs() <= STEADY * extreme.value.abs();
        if values.filter(|value| !value.is_nan()).all(is_same) {
            return Ok(Extreme { t: self.instants[0], is_steady: true, ..extreme });
        }
        // Between the neighbours.
        let [before, after] = [idx.saturating_sub(1), (idx + 1).min(n - 1)];
        let samples = [before, idx, after]
            .map(|instant| (self.instants[instant], of(self.value(instant, place))));
        let mut row = vec![0.0; self.quantities.count()];
        let mut value = |t: f64| {
            self.at(t, &mut row)?;
            let value = of(row[place]);
            if value > of(extreme.value) {
                extreme = Extreme { value: row[place], t, is_steady: false };
            }
            Ok::<f64, Unreplayed>(value)
        };
        peak(&mut value, samples)?;
        Ok(extreme)
    }

    /// The instants at which the rate of a motion changes its sign, by bisection.
    fn turns(&mut self, place: usize) -> Result<Vec<Extreme>, Unreplayed> {
        let rate = place + 1;
        let mut row = vec![0.0; self.quantities.count()];
        let mut turns = Vec::new();
        // The last instant with a rate: a motion may rest in between.
        let mut before: Option<usize> = None;
        for idx in 0..self.instants.len() {
            let value = self.value(idx, rate);
            if value == 0.0 {
                continue;
            }
            let from = before.replace(idx);
            let Some(from) = from.filter(|&from| self.value(from, rate) * value < 0.0) else {
                continue;
            };
            let (mut low, mut high) = (self.instants[from], self.instants[idx]);
            loop {
                let middle = f64::midpoint(low, high);
                if middle == low || middle == high {
                    break;
                }
                self.at(middle, &mut row)?;
                if row[rate] * value < 0.0 { low = middle } else { high = middle }
            }
            self.at(high, &mut row)?;
            turns.push(Extreme { value: row[place], t: high, is_steady: false });
        }
        Ok(turns)
    }

    /// The reaction of a joint or contact and the pose at an instant.
    fn pin_force(&mut self, joint: usize, t: f64) -> Result<PinForce, Unreplayed> {
        let mut row = vec![0.0; self.quantities.count()];
        self.at(t, &mut row)?;
        let Self { playback, quantities, .. } = self;
        let reaction = quantities.bearings(playback.sample(), playback.modes())[joint];
        // Driven motions come first.
        let Quantities { motions, drives, .. } = &self.quantities;
        let others = (0..motions.len()).filter(|idx| !drives.contains(idx));
        let pose = drives.iter().copied().chain(others).map(|idx| {
            let (.., name, kind) = &motions[idx];
            (name.clone(), row[3 * idx], unit_of(*kind))
        });
        Ok(PinForce { reaction, pose: pose.collect() })
    }

    fn motion(&mut self, idx: usize) -> Result<MotionReport, Unreplayed> {
        let place = 3 * idx;
        let limits = [self.largest(place, |x| -x)?, self.largest(place, |x| x)?];
        let rate = self.largest(place + 1, f64::abs)?;
        let acceleration = self.largest(place + 2, f64::abs)?;
        let [least, largest] = limits.map(|limit| limit.value);
        let turns = self.turns(place)?;
        let last = self.instants.len() - 1;
        let differs = |place: usize, by: f64| {
            (self.value(last, place) - self.value(0, place)).abs() > REPEATS * by
        };
        let repeats = !differs(place, largest - least) && !differs(place + 1, rate.value.abs());
        let period = repeats.then(|| (self.instants[last] - self.instants[0]).abs());
        let (_, _, name, kind) = &self.quantities.motions[idx];
        Ok(MotionReport {
            name: name.clone(),
            unit: unit_of(*kind),
            limits,
            rate,
            acceleration,
            time_ratio: time_ratio(&turns, [least, largest], period),
        })
    }
}

fn unit_of(kind: MotionKind) -> &'static str {
    if kind == MotionKind::Rotation { "rad" } else { "m" }
}

/// True where velocities can change at once: at stops, and where the prescribed rate of a drive jumps.
fn may_hit(mechanism: &Mechanism) -> bool {
    let Mechanism { model, system, .. } = mechanism;
    let is_stop = |contact: &Contact| matches!(contact.law, Law::Stop { .. });
    let is_kink = |switch: &Switch| switch.of != SwitchOf::Multipliers;
    let has_kinks = system.integrated().switches.iter().any(is_kink);
    system.contacts.iter().any(is_stop) || has_kinks && !model.drives.is_empty()
}

/// Names of what bears forces: joints, then contacts as `contacts.floor`.
fn names(mechanism: &Mechanism) -> Vec<String> {
    let Model { joints, contacts, .. } = &mechanism.model;
    let contacts = contacts.iter().map(|contact| format!("contacts.{}", contact.name));
    joints.iter().map(|joint| joint.name.clone()).chain(contacts).collect()
}

/// True if the reaction of a joint, or the forces of a contact, are the same in every solution of the equilibrium.
fn is_unique(playback: &Playback, bearing: usize) -> bool {
    let Mechanism { model, system, .. } = playback.mechanism();
    playback.uniqueness().iter().all(|change| {
        let Uniqueness { reactions, contacts, .. } = &change.uniqueness;
        let Some(contact) = bearing.checked_sub(reactions.len()) else {
            return reactions[bearing].iter().all(|&unique| unique);
        };
        let is_own = |of: &Contact| model.loads[of.load.0].contact() == Some(ContactId(contact));
        let rows = system.contacts.iter().zip(contacts);
        rows.filter(|(of, _)| is_own(of)).all(|(_, &unique)| unique)
    })
}

/// The report of a run.
///
/// # Errors
/// [`Unreported`].
///
/// # Panics
/// Never: every drive and every output of a mechanism has its signal.
pub fn report(playback: &mut Playback) -> Result<Report, Unreported> {
    let quantities = Quantities::new(playback.mechanism())?;
    let drives = playback.mechanism().compiled.drives.clone();
    let named = &playback.mechanism().model.named_signals;
    let outputs: Vec<_> = named.iter().filter(|signal| signal.is_output).cloned().collect();
    let signal = |topic: &str, name: &str| {
        let signal = playback.signal(&format!("{topic}.{name}"));
        signal.expect("every drive and every output has a channel")
    };
    let efforts = drives.iter().map(|drive| signal("drives", &drive.name));
    let signals = efforts.chain(outputs.iter().map(|it| signal("outputs", &it.name))).collect();
    let bearings = names(playback.mechanism());
    let is_unique: Vec<bool> =
        (0..bearings.len()).map(|bearing| is_unique(playback, bearing)).collect();
    let span = playback.span();
    let mut survey = Survey {
        playback,
        quantities,
        signals,
        instants: Vec::new(),
        table: Vec::new(),
        integrals: Vec::new(),
        impacts: 0.0,
    };
    survey.fill()?;

    let [of_points, of_drives, of_reactions, of_outputs, of_energies] = survey.quantities.places();
    let duration = (span[1] - span[0]).abs();
    let integrals = survey.integrals.clone();
    let rms = |place: usize| (integrals[place][1] / duration).sqrt();
    let mean = |place: usize| integrals[place][0] / (span[1] - span[0]);
    let motions = (0..survey.quantities.motions.len()).map(|idx| survey.motion(idx));
    let motions = motions.collect::<Result<_, _>>()?;
    let mut points = Vec::new();
    for (idx, name) in survey.quantities.points.clone().into_iter().enumerate() {
        let speed = survey.largest(of_points + 2 * idx, |x| x)?;
        let acceleration = survey.largest(of_points + 2 * idx + 1, |x| x)?;
        points.push(PointReport { name, speed, acceleration });
    }
    let mut drive_reports = Vec::new();
    for (idx, drive) in drives.into_iter().enumerate() {
        let place = of_drives + 2 * idx;
        drive_reports.push(DriveReport {
            name: drive.name,
            unit: drive.unit,
            peak: survey.largest(place, f64::abs)?,
            rms: rms(place),
            power: survey.largest(place + 1, f64::abs)?,
            mean_power: mean(place + 1),
        });
    }
    let mut reactions = Vec::new();
    for (idx, name) in bearings.into_iter().enumerate() {
        let place = of_reactions + 2 * idx;
        let force = survey.largest(place, |x| x)?;
        reactions.push(ReactionReport {
            name,
            force,
            largest: survey.pin_force(idx, force.t)?,
            force_rms: rms(place),
            moment: survey.largest(place + 1, |x| x)?,
            moment_rms: rms(place + 1),
            is_unique: is_unique[idx],
        });
    }
    let mut output_reports = Vec::new();
    for (place, output) in (of_outputs..).zip(outputs) {
        output_reports.push(OutputReport {
            name: output.name,
            unit: output.unit.replace(' ', "*"),
            limits: [survey.largest(place, |x| -x)?, survey.largest(place, |x| x)?],
            mean: mean(place),
            rms: rms(place),
        });
    }
    let last = survey.instants.len() - 1;
    let energy = EnergyReport {
        kinetic: survey.largest(of_energies, |x| x)?,
        potential: [
            survey.largest(of_energies + 1, |x| -x)?,
            survey.largest(of_energies + 1, |x| x)?,
        ],
        total: [0, last].map(|instant| survey.value(instant, of_energies + 2)),
        work: integrals[of_energies + 3][0],
        power: survey.largest(of_energies + 3, f64::abs)?,
    };
    let work = survey.works(span)?;
    Ok(Report {
        span,
        motions,
        points,
        drives: drive_reports,
        reactions,
        outputs: output_reports,
        work,
        energy,
    })
}
