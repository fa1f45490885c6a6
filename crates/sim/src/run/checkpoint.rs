//! A run between two steps, as plain numbers: continued, it equals the undisturbed run bit for bit.
//!
//! Nothing of the model is stored but its fingerprint: the equations, parameters, start and options
//! with which a run goes on must be those with which it began.

use bksim_dae::{Checkpoint, Loader, Method, Saver, SolveError};

use super::legs::Run;
use super::recorder::Recorder;
use super::singular::{SingularPose, Watch};
use super::{EnergyBalance, Integrator, MethodChange, Reason, Sample, Summary};
use crate::compiled::CompiledSystem;
use crate::evaluator::Energy;
use crate::hybrid::Change;
use crate::multiplier::MultiplierSystem;
use crate::start::Start;
use bksim_model::{Outputs, SolveOptions};

/// What a stopped run goes on from.
#[derive(Clone, PartialEq, Debug)]
pub struct RunCheckpoint {
    fingerprint: Fingerprint,
    pub(super) numbers: Checkpoint,
}

/// Why a run cannot go on from a checkpoint.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// The model is another one.
    #[error("the checkpoint was saved with other {what}")]
    Model {
        /// Which part of it.
        what: &'static str,
    },
    /// An option is another one.
    #[error("the checkpoint was saved with `{option}` = {saved}, not {given}")]
    Option {
        /// Its key in `[solve]`.
        option: &'static str,
        /// Its value then; NaN where it was not stated.
        saved: f64,
        /// Its value now.
        given: f64,
    },
    /// A choice among words is another one.
    #[error("the checkpoint was saved with another `{option}`")]
    Choice {
        /// Its key in `[solve]`.
        option: &'static str,
    },
    /// It is damaged.
    #[error(transparent)]
    Damaged(SolveError),
}

/// First bytes of a stored checkpoint, the last of them the version of its layout.
const MAGIC: [u8; 8] = *b"bkrun\0\0\x01";

impl RunCheckpoint {
    /// Numbers with the fingerprint of what they belong to.
    pub(super) fn new(fingerprint: Fingerprint, numbers: Checkpoint) -> Self {
        Self { fingerprint, numbers }
    }

    /// Time of the last step, s.
    pub fn t(&self) -> f64 {
        self.numbers.reals.first().copied().unwrap_or(f64::NAN)
    }

    /// Samples that had been handed out, the start included.
    pub fn n_samples(&self) -> u64 {
        self.numbers.counts.first().copied().unwrap_or_default()
    }

    /// As little-endian bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let words = self.fingerprint.0.iter().flat_map(|word| word.to_le_bytes());
        MAGIC.into_iter().chain(words).chain(self.numbers.to_bytes()).collect()
    }

    /// From the bytes of [`RunCheckpoint::to_bytes`].
    ///
    /// # Errors
    /// [`Unfit::Damaged`] when they are not such bytes, or those of another version.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Unfit> {
        let damaged = |reason| Unfit::Damaged(SolveError::Checkpoint { reason });
        let rest = bytes.strip_prefix(&MAGIC).ok_or(damaged("it has another version"))?;
        let (words, numbers) =
            rest.split_at_checked(8 * TRAITS.len()).ok_or(damaged("numbers are missing"))?;
        let mut fingerprint = Fingerprint([0; TRAITS.len()]);
        let chunks = words.as_chunks::<8>().0;
        fingerprint.0.iter_mut().zip(chunks).for_each(|(w, &c)| *w = u64::from_le_bytes(c));
        let numbers = Checkpoint::from_bytes(numbers).map_err(Unfit::Damaged)?;
        Ok(Self { fingerprint, numbers })
    }

    /// Whether it belongs to the run with this fingerprint.
    pub(super) fn check(&self, given: &Fingerprint) -> Result<(), Unfit> {
        let words = self.fingerprint.0.iter().zip(&given.0);
        let mut pairs = TRAITS.iter().zip(words);
        let Some(((what, kind), (&saved, &given))) = pairs.find(|(_, (a, b))| a != b) else {
            return Ok(());
        };
        Err(match kind {
            Kind::Model => Unfit::Model { what },
            Kind::Choice => Unfit::Choice { option: what },
            Kind::Number => Unfit::Option {
                option: what,
                saved: f64::from_bits(saved),
                given: f64::from_bits(given),
            },
        })
    }
}

/// What a run must have in common with the one that goes on from its checkpoint.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Fingerprint([u64; TRAITS.len()]);

/// What a word of a fingerprint is.
enum Kind {
    /// A hash.
    Model,
    /// The bits of a number.
    Number,
    /// The place of a word in its list.
    Choice,
}

const TRAITS: [(&str, Kind); 13] = [
    ("coordinates", Kind::Model),
    ("parameters", Kind::Model),
    ("initial values", Kind::Model),
    ("equations", Kind::Model),
    ("t_start", Kind::Number),
    ("t_end", Kind::Number),
    ("every", Kind::Number),
    ("output times", Kind::Model),
    ("rtol", Kind::Number),
    ("atol", Kind::Number),
    ("step", Kind::Number),
    ("method", Kind::Choice),
    ("formulation", Kind::Choice),
];

impl Fingerprint {
    /// Equations are compared by their values at the start.
    pub(super) fn of(
        compiled: &CompiledSystem,
        start: &Start,
        parameters: &[f64],
        options: &SolveOptions,
    ) -> Self {
        let quantities = compiled.coordinates.iter().chain(&compiled.multipliers);
        let names = quantities.flat_map(|quantity| quantity.name.bytes().chain([0]));
        let mut evaluator = compiled.evaluator(&start.modes.parameters_with_modes(parameters));
        let at = evaluator.dynamics(start.t, &start.q, &start.v);
        let values = [at.mass, at.jacobian, at.force, at.gamma].concat();
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN).to_bits();
        Self([
            hash(names),
            hash(bytes(parameters)),
            hash(bytes(&start.q).chain(bytes(&start.v))),
            hash(bytes(&values)),
            start.t.to_bits(),
            options.t_end.to_bits(),
            or_nan(options.every),
            match &options.outputs {
                Outputs::Even => 0,
                Outputs::Steps => 1,
                Outputs::Times(times) => hash(bytes(times)),
            },
            options.rtol.to_bits(),
            options.atol.to_bits(),
            or_nan(options.step),
            options.method as u64,
            options.formulation as u64,
        ])
    }
}

fn bytes(values: &[f64]) -> impl Iterator<Item = u8> {
    values.iter().flat_map(|value| value.to_le_bytes())
}

/// FNV-1a of 64 bits (G. Fowler, L. C. Noll, K.-P. Vo).
fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    bytes.fold(OFFSET, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}

impl<'a> Run<'a, '_> {
    /// The run between two steps.
    pub(super) fn save(&self) -> Checkpoint {
        let mut saver = Saver::default();
        // These two come first, to be read by themselves.
        saver.count(self.recorder.summary.n_samples);
        saver.real(self.reached.t);
        saver.indices(&self.dependent);
        self.recorder.save(&mut saver);
        saver.slice(&self.reached.q);
        saver.slice(&self.reached.v);
        self.multipliers.save(&mut saver);
        self.watch.save(&mut saver);
        saver.option(self.passing);
        saver.option(self.failed_at);
        saver.stats(&self.before);
        saver.flag(self.leg.is_some());
        if let Some(leg) = &self.leg {
            saver.checkpoint(leg);
        }
        saver.finish(match self.method {
            Integrator::Radau => Method::Radau,
            Integrator::Explicit => Method::Explicit,
        })
    }

    /// Goes on from what was saved by a run with the same fingerprint.
    pub(super) fn load(
        &mut self,
        numbers: &Checkpoint,
        compiled: &'a CompiledSystem,
    ) -> Result<(), SolveError> {
        const MORE: SolveError = SolveError::Checkpoint { reason: "it holds too many numbers" };
        let mut loader = Loader::new(numbers, numbers.method)?;
        self.method = match numbers.method {
            Method::Radau => Integrator::Radau,
            Method::Explicit => Integrator::Explicit,
        };
        loader.count()?;
        self.reached.t = loader.real()?;
        self.dependent = loader.indices(compiled.nc())?;
        self.recorder.load(&mut loader, compiled, &self.dependent)?;
        loader.fill(&mut self.reached.q)?;
        loader.fill(&mut self.reached.v)?;
        self.multipliers = MultiplierSystem::new(&compiled.shape, &self.dependent);
        self.multipliers.load(&compiled.shape, &mut loader)?;
        self.watch = Watch::load(&mut loader)?;
        self.passing = loader.option()?;
        self.failed_at = loader.option()?;
        self.before = loader.stats()?;
        self.leg = if loader.flag()? { Some(loader.checkpoint()?) } else { None };
        if loader.is_empty() { Ok(()) } else { Err(MORE) }
    }
}

impl Recorder<'_> {
    /// Whether every sample up to the end time has been handed out.
    pub(super) fn is_complete(&self, t_end: f64) -> bool {
        self.summary.t == t_end && self.pending.is_empty()
    }
}

impl Sample {
    pub(super) fn save(&self, saver: &mut Saver) {
        let Self { t, q, v, a, lambda, inputs, reactions, energy, work, step_size, stats, .. } =
            self;
        let Energy { kinetic, potential, power } = *energy;
        for part in [q, v, a, lambda, inputs] {
            saver.slice(part);
        }
        saver.slice(reactions.as_flattened());
        saver.slice(&[*t, *work, *step_size, kinetic, potential, power]);
        saver.slice(&[self.position_residual, self.velocity_residual].concat());
        saver.stats(stats);
    }

    pub(super) fn load(
        loader: &mut Loader<'_>,
        compiled: &CompiledSystem,
    ) -> Result<Self, SolveError> {
        let (nq, nc) = (compiled.nq(), compiled.nc());
        let mut sample = Self {
            q: vec![0.0; nq],
            v: vec![0.0; nq],
            a: vec![0.0; nq],
            lambda: vec![0.0; nc],
            inputs: vec![0.0; compiled.inputs.ids().len()],
            reactions: vec![[0.0; 6]; compiled.joints.len()],
            ..Self::default()
        };
        let Self { q, v, a, lambda, inputs, reactions, .. } = &mut sample;
        for part in [q, v, a, lambda, inputs] {
            loader.fill(part)?;
        }
        loader.fill(reactions.as_flattened_mut())?;
        let mut numbers = [0.0; 6];
        loader.fill(&mut numbers)?;
        let [t, work, step_size, kinetic, potential, power] = numbers;
        let residuals = residuals(loader)?;
        Ok(Self {
            t,
            work,
            step_size,
            energy: Energy { kinetic, potential, power },
            position_residual: residuals[0],
            velocity_residual: residuals[1],
            stats: loader.stats()?,
            ..sample
        })
    }
}

fn residuals(loader: &mut Loader<'_>) -> Result<[[f64; 2]; 2], SolveError> {
    let mut residuals = [[0.0; 2]; 2];
    loader.fill(residuals.as_flattened_mut())?;
    Ok(residuals)
}

impl Summary {
    pub(super) fn save(&self, saver: &mut Saver) {
        let EnergyBalance { initial, last, work, impacts, worst_error, scale } = self.energy;
        saver.real(self.t);
        saver.count(self.n_samples);
        saver.stats(&self.stats);
        saver.slice(&[self.position_residual, self.velocity_residual].concat());
        saver.slice(&[initial, last, work, impacts, worst_error, scale]);
        saver.count(self.singular_poses.len());
        for pose in &self.singular_poses {
            pose.save(saver);
        }
        saver.count(self.methods.len());
        for change in &self.methods {
            change.save(saver);
        }
        saver.count(self.changes.len());
        for change in &self.changes {
            change.save(saver);
        }
    }

    pub(super) fn load(
        loader: &mut Loader<'_>,
        compiled: &CompiledSystem,
    ) -> Result<Self, SolveError> {
        let (t, n_samples, stats) = (loader.real()?, loader.count()?, loader.stats()?);
        let [position_residual, velocity_residual] = residuals(loader)?;
        let mut numbers = [0.0; 6];
        loader.fill(&mut numbers)?;
        let [initial, last, work, impacts, worst_error, scale] = numbers;
        let nc = compiled.nc();
        // A length that is too large fails at the first number that is missing.
        let poses = 0..loader.count()?;
        let singular_poses =
            poses.map(|_| SingularPose::load(loader, nc)).collect::<Result<_, _>>()?;
        let methods = 0..loader.count()?;
        let methods = methods.map(|_| MethodChange::load(loader)).collect::<Result<_, _>>()?;
        let changes = 0..loader.count()?;
        let changes = changes.map(|_| Change::load(loader, compiled)).collect::<Result<_, _>>()?;
        Ok(Self {
            reached_end: false,
            t,
            n_samples,
            stats,
            position_residual,
            velocity_residual,
            energy: EnergyBalance { initial, last, work, impacts, worst_error, scale },
            singular_poses,
            methods,
            changes,
            checkpoint: None,
        })
    }
}

const INTEGRATORS: [Integrator; 2] = [Integrator::Explicit, Integrator::Radau];
const REASONS: [Reason; 6] = [
    Reason::Asked,
    Reason::Cheapest,
    Reason::Stiff,
    Reason::OtherFailed,
    Reason::SingularPose,
    Reason::Regular,
];

impl MethodChange {
    fn save(&self, saver: &mut Saver) {
        saver.real(self.t);
        // Both lists are in the order of their kinds.
        saver.indices(&[self.method as usize, self.reason as usize]);
    }

    fn load(loader: &mut Loader<'_>) -> Result<Self, SolveError> {
        const OTHER: SolveError = SolveError::Checkpoint { reason: "it names an unknown method" };
        let (t, kinds) = (loader.real()?, loader.indices(REASONS.len())?);
        let &[method, reason] = &kinds[..] else { return Err(OTHER) };
        let method = *INTEGRATORS.get(method).ok_or(OTHER)?;
        Ok(Self { t, method, reason: REASONS[reason] })
    }
}
