//! [`Summary`]: how a run went, and [`Failure`]: why it stopped early.

use bksim_dae::{Noise, SolveError, Standstill, Stats};

use super::checkpoint::RunCheckpoint;
use super::pace::Slowness;
use super::sample::Sample;
use crate::held_assembly::AssemblyChange;
use crate::hybrid::{Change, NoConsistentModes};
use crate::redundancy::{Uniqueness, UniquenessChange};
use crate::start::{Start, StartError};
use bksim_model::LoadId;

/// How a run ended and how good it was.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Summary {
    /// True if the end time was reached.
    pub reached_end: bool,
    /// Last instant, s.
    pub t: f64,
    /// Number of samples, the start included.
    pub n_samples: usize,
    /// Work of the integrator.
    pub stats: Stats,
    /// Worst of [`Sample::position_residual`].
    pub position_residual: [f64; 2],
    /// Worst of [`Sample::velocity_residual`].
    pub velocity_residual: [f64; 2],
    /// The energy balance.
    pub energy: EnergyBalance,
    /// The singular poses that were passed.
    pub singular_poses: Vec<SingularPose>,
    /// Where the motion passed over into another assembly than the one that the model holds.
    pub assembly_changes: Vec<AssemblyChange>,
    /// The sample at which three angles in sequence came nearest to their pole, where it is near.
    pub pole: Option<NearPole>,
    /// Friction whose size was below zero, with the first sample at which it was, s.
    pub driving: Option<(f64, LoadId)>,
    /// The constraint row of a taut rope that has pushed, with the first sample at which it did, s.
    pub pushing: Option<(f64, usize)>,
    /// The place, by its number, that a rope held to it would have left, or that a rope has come to from its other side,
    /// with the first sample after that, s.
    pub left: Option<(f64, usize)>,
    /// The place, by its number, that a rope goes nearly once around at the start, and the turn, rad.
    pub wound: Option<(usize, f64)>,
    /// That the run takes far more steps than expected, if it does.
    pub slowness: Option<Slowness>,
    /// Repeated explicit steps whose error has not fallen with their size.
    pub noise: Noise,
    /// Largest magnitudes of a coordinate and of a velocity over the samples, SI.
    pub largest: [f64; 2],
    /// The methods that were used, the first from the start.
    pub methods: Vec<MethodChange>,
    /// The switches of modes, in order.
    pub changes: Vec<Change>,
    /// Which components of the reactions are unique, from the start on and wherever that changes.
    pub uniqueness: Vec<UniquenessChange>,
    /// State from which a run that was stopped goes on; see [`crate::run::resume`].
    pub checkpoint: Option<RunCheckpoint>,
}

/// A method, from when it was used, and why.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MethodChange {
    /// s.
    pub t: f64,
    /// The method used from there on.
    pub method: Integrator,
    /// Why.
    pub reason: Reason,
}

/// Method that integrates the equations of motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Integrator {
    /// Dormand–Prince 8(5,3) on the accelerations, with projection.
    Explicit,
    /// Radau IIA on the formulation asked for.
    Radau,
}

/// Why a method is used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reason {
    /// The model asks for it.
    Asked,
    /// It needs the least work as long as the motion is not stiff.
    Cheapest,
    /// The motion has turned stiff.
    Stiff,
    /// Explicit steps would be far too many.
    Slow,
    /// Radau IIA needs nearly as many.
    NoGain,
    /// The other method failed here.
    OtherFailed,
    /// Explicit steps pass the singular pose ahead.
    SingularPose,
    /// The singular pose has been passed.
    Regular,
    /// The motion is no longer stiff.
    Relaxed,
}

/// A sample at which three angles in sequence are near their pole.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NearPole {
    /// s.
    pub t: f64,
    /// The coordinate of the second angle.
    pub coordinate_idx: usize,
    /// Cosine of the angle.
    pub cosine: f64,
}

impl NearPole {
    /// Cosine below which angles are near their pole.
    pub(crate) const NEAR: f64 = 0.03;

    /// The nearest of some second angles at positions `q`, where one is near.
    fn of(t: f64, q: &[f64], second_angles: &[usize]) -> Option<Self> {
        let at = |&coordinate_idx: &usize| Self {
            t,
            coordinate_idx,
            cosine: q[coordinate_idx].cos().abs(),
        };
        let near = second_angles.iter().map(at).filter(|pole| pole.cosine < Self::NEAR);
        near.min_by(|a, b| a.cosine.total_cmp(&b.cosine))
    }
}

/// A pose in which constraint rows have lost rank.
#[derive(Clone, PartialEq, Debug)]
pub struct SingularPose {
    /// s.
    pub t: f64,
    /// Rank of the constraints there.
    pub rank: usize,
    /// Rows that take part in the loss, those of the system's constraints.
    pub rows: Vec<usize>,
}

/// T + V − W against its value at the start.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct EnergyBalance {
    /// T + V at the start, J.
    pub initial: f64,
    /// T + V at the end, J.
    pub last: f64,
    /// Work of loads and drives, that of impacts included, J.
    pub work: f64,
    /// Work that went in or out, step by step, J: what its error is relative to.
    pub turnover: f64,
    /// Work of impacts, J: what stops and kinks of drives have done to T at once.
    pub impacts: f64,
    /// Largest |T + V − W − (T₀ + V₀)| over the samples, J.
    pub worst_error: f64,
    /// Largest |T| + |V − V₀| + |W| over the samples, or the work that went in and out of drives, J: what the error is
    /// relative to.
    pub scale: f64,
}

impl EnergyBalance {
    /// Takes account of a sample; `potential_start` is V₀.
    pub(crate) fn take(&mut self, sample: &Sample, potential_start: f64) {
        let energy = sample.energy;
        self.last = energy.kinetic + energy.potential;
        let error = (self.last - sample.work - self.initial).abs();
        self.worst_error = self.worst_error.max(error);
        let moved = (energy.potential - potential_start).abs();
        self.scale = self.scale.max(energy.kinetic.abs() + moved + sample.work.abs());
    }
}

impl Summary {
    /// Takes note of the uniqueness from `t` on, where it is another one than before.
    pub(crate) fn note_uniqueness(&mut self, t: f64, uniqueness: Uniqueness) {
        if self.uniqueness.last().is_none_or(|last| last.uniqueness != uniqueness) {
            self.uniqueness.push(UniquenessChange { t, uniqueness });
        }
    }

    /// Takes account of a sample that is handed out; `potential_start` is V₀, `second_angles` are those of
    /// three in sequence.
    pub(crate) fn take(&mut self, sample: &Sample, potential_start: f64, second_angles: &[usize]) {
        let pole = NearPole::of(sample.t, &sample.q, second_angles);
        self.pole = match (self.pole, pole) {
            (Some(known), Some(pole)) if known.cosine <= pole.cosine => Some(known),
            (known, pole) => pole.or(known),
        };
        self.energy.take(sample, potential_start);
        for (largest, values) in self.largest.iter_mut().zip([&sample.q, &sample.v]) {
            *largest = values.iter().fold(*largest, |largest, value| largest.max(value.abs()));
        }
        for side in 0..2 {
            let [position, velocity] =
                [sample.position_residual[side], sample.velocity_residual[side]];
            self.position_residual[side] = self.position_residual[side].max(position);
            self.velocity_residual[side] = self.velocity_residual[side].max(velocity);
        }
        self.t = sample.t;
        self.n_samples = self.n_samples.saturating_add(1);
        self.stats = sample.stats;
    }
}

/// Why a run stopped early, with what was reached.
#[derive(Clone, PartialEq, Debug)]
pub struct Failure {
    /// The integrator's reason; `None` when the run met a singular pose that it could not cross.
    pub error: Option<SolveError>,
    /// Contacts or kinks without consistent modes.
    pub no_modes: Option<NoConsistentModes>,
    /// An instant from which on the motion has no derivatives.
    pub no_sensitivity: Option<NoSensitivity>,
    /// The fault of a start that was changed to a state in which no motion begins.
    pub start: Option<StartError>,
    /// The run so far.
    pub summary: Summary,
    /// The last state that was reached.
    pub last: Sample,
}

/// An instant from which on a motion has no derivatives.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NoSensitivity {
    /// s.
    pub t: f64,
    /// The reason.
    pub why: Undefined,
}

/// The reason why a motion has no derivatives.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Undefined {
    /// A stop is only touched, or the function of a kink, so that for other values nothing would switch there.
    Touching(Option<LoadId>),
    /// Several things switch at one instant, which other values part.
    Together,
    /// The equations have no unique solution, or no finite values.
    Singular,
    /// Multipliers, and reactions made of them, are shared by joints that repeat each other.
    Shared,
    /// The motion takes too much room to go back along it.
    Room,
}

impl Failure {
    /// The failure of a run that cannot begin in the state of a start that was changed.
    pub(crate) fn at_start(start: &Start, error: StartError) -> Self {
        let Start { t, q, v, a, lambda, .. } = start.clone();
        let last = Sample { t, q, v, a, lambda, ..Sample::default() };
        let summary = Summary { t, ..Summary::default() };
        let (error, start) = (None, Some(error));
        Self { error, no_modes: None, no_sensitivity: None, start, summary, last }
    }

    /// The failure of a run whose equations have no value at an output time.
    pub(crate) fn undefined(summary: Summary, last: Sample) -> Self {
        let at = Standstill {
            t: last.t,
            h: last.step_size,
            worst: Vec::new(),
            y: [last.q.as_slice(), &last.v].concat(),
            stats: summary.stats,
        };
        let error = Some(SolveError::NotFinite { row: 0, at: Box::new(at) });
        Self { error, no_modes: None, no_sensitivity: None, start: None, summary, last }
    }
}
