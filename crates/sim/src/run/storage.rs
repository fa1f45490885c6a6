//! A run and its parts as numbers, and back, in the order of a checkpoint.

use bksim_dae::{Checkpoint, Loader, Method, Noise, Saver, SolveError};

use super::pace::{Pace, Slowness};
use super::progress::{Progress, Run};
use super::sample::{Energy, Sample};
use super::singular::SingularMonitor;
use super::summary::{
    EnergyBalance, Integrator, MethodChange, NearPole, Reason, SingularPose, Summary,
};
use bksim_model::{JointId, LoadId};

use crate::compiled::CompiledSystem;
use crate::held_assembly::AssemblyChange;
use crate::hybrid::Change;
use crate::redundancy::{Uniqueness, UniquenessChange};

impl Run<'_> {
    /// The run between two steps.
    pub(crate) fn save(&mut self) -> Checkpoint {
        let phase = match &mut self.progress {
            Progress::Between => None,
            Progress::Saved(saved) => Some(saved.clone()),
            Progress::Within(phase) => {
                self.multipliers.clone_from(phase.stepper.multipliers());
                Some(phase.save())
            }
            Progress::Passing(..) => unreachable!("a run is saved between two steps"),
        };
        let mut saver = Saver::default();
        // These two come first, to be read by themselves.
        saver.count(self.summary.n_samples);
        saver.real(self.reached.t);
        saver.indices(&self.mechanism.inactive);
        self.mechanism.save(&mut saver);
        self.sampler.save(&mut saver, &self.summary);
        saver.slice(&self.reached.q);
        saver.slice(&self.reached.v);
        self.multipliers.save(&mut saver);
        self.singular_monitor.save(&mut saver);
        saver.option(self.passing);
        saver.option(self.failed_at);
        saver.stats(&self.before);
        save_noise(&self.noise_before, &mut saver);
        self.pace.save(&mut saver);
        saver.flag(phase.is_some());
        if let Some(phase) = &phase {
            saver.checkpoint(phase);
        }
        saver.finish(match self.method {
            Integrator::Radau => Method::Radau,
            Integrator::Explicit => Method::Explicit,
        })
    }

    /// Goes on from what was saved by a run with the same fingerprint.
    pub(super) fn load(&mut self, numbers: &Checkpoint) -> Result<(), SolveError> {
        const MORE: SolveError = SolveError::Checkpoint { reason: "it holds too many numbers" };
        let compiled = self.problem.compiled;
        let mut loader = Loader::new(numbers, numbers.method)?;
        self.method = match numbers.method {
            Method::Radau => Integrator::Radau,
            Method::Explicit => Integrator::Explicit,
        };
        loader.count()?;
        self.reached.t = loader.real()?;
        let inactive = loader.indices(compiled.nc())?;
        self.mechanism.load(&mut loader, inactive)?;
        self.summary = self.sampler.load(&mut loader, &self.mechanism)?;
        loader.fill(&mut self.reached.q)?;
        loader.fill(&mut self.reached.v)?;
        self.multipliers = self.mechanism.multipliers();
        self.multipliers.load(&compiled.shape, &mut loader)?;
        self.singular_monitor = SingularMonitor::load(&mut loader)?;
        self.passing = loader.option()?;
        self.failed_at = loader.option()?;
        self.before = loader.stats()?;
        self.noise_before = load_noise(&mut loader)?;
        self.pace = Pace::load(&mut loader)?;
        if loader.flag()? {
            self.progress = Progress::Saved(loader.checkpoint()?);
        }
        if loader.is_empty() { Ok(()) } else { Err(MORE) }
    }
}

impl Sample {
    pub(super) fn save(&self, saver: &mut Saver) {
        let Self {
            t,
            q,
            v,
            a,
            lambda,
            inputs,
            signals,
            reactions,
            energy,
            work,
            step_size,
            stats,
            ..
        } = self;
        let Energy { kinetic, potential, power } = *energy;
        for part in [q, v, a, lambda, inputs, signals] {
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
            signals: vec![
                0.0;
                compiled.signals.as_ref().map_or(0, crate::function::Function::n_outputs)
            ],
            reactions: vec![[0.0; 6]; compiled.joints.len()],
            ..Self::default()
        };
        let Self { q, v, a, lambda, inputs, signals, reactions, .. } = &mut sample;
        for part in [q, v, a, lambda, inputs, signals] {
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

fn save_noise(noise: &Noise, saver: &mut Saver) {
    saver.count(noise.count);
    saver.real(noise.log_error);
}

fn load_noise(loader: &mut Loader<'_>) -> Result<Noise, SolveError> {
    Ok(Noise { count: loader.count()?, log_error: loader.real()? })
}

fn residuals(loader: &mut Loader<'_>) -> Result<[[f64; 2]; 2], SolveError> {
    let mut residuals = [[0.0; 2]; 2];
    loader.fill(residuals.as_flattened_mut())?;
    Ok(residuals)
}

impl Summary {
    pub(super) fn save(&self, saver: &mut Saver) {
        let EnergyBalance { initial, last, work, turnover, impacts, worst_error, scale } =
            self.energy;
        saver.real(self.t);
        saver.count(self.n_samples);
        saver.stats(&self.stats);
        saver.slice(&[self.position_residual, self.velocity_residual].concat());
        saver.slice(&[initial, last, work, turnover, impacts, worst_error, scale]);
        saver.slice(&self.largest);
        saver.flag(self.pole.is_some());
        if let Some(NearPole { t, coordinate_idx, cosine }) = self.pole {
            saver.slice(&[t, cosine]);
            saver.count(coordinate_idx);
        }
        saver.flag(self.driving.is_some());
        if let Some((t, load)) = self.driving {
            saver.real(t);
            saver.count(load.0);
        }
        saver.flag(self.pushing.is_some());
        if let Some((t, row)) = self.pushing {
            saver.real(t);
            saver.count(row);
        }
        saver.flag(self.left.is_some());
        if let Some((t, place)) = self.left {
            saver.real(t);
            saver.count(place);
        }
        saver.flag(self.wound.is_some());
        if let Some((place, turn)) = self.wound {
            saver.count(place);
            saver.real(turn);
        }
        save_noise(&self.noise, saver);
        saver.flag(self.slowness.is_some());
        if let Some(slowness) = &self.slowness {
            slowness.save(saver);
        }
        saver.count(self.singular_poses.len());
        for pose in &self.singular_poses {
            pose.save(saver);
        }
        saver.count(self.assembly_changes.len());
        for change in &self.assembly_changes {
            saver.real(change.t);
            saver.count(change.joint.0);
        }
        saver.count(self.methods.len());
        for change in &self.methods {
            change.save(saver);
        }
        saver.count(self.changes.len());
        for change in &self.changes {
            change.save(saver);
        }
        saver.count(self.uniqueness.len());
        for change in &self.uniqueness {
            saver.real(change.t);
            change.uniqueness.save(saver);
        }
    }

    pub(super) fn load(
        loader: &mut Loader<'_>,
        compiled: &CompiledSystem,
    ) -> Result<Self, SolveError> {
        let (t, n_samples, stats) = (loader.real()?, loader.count()?, loader.stats()?);
        let [position_residual, velocity_residual] = residuals(loader)?;
        let mut numbers = [0.0; 7];
        loader.fill(&mut numbers)?;
        let [initial, last, work, turnover, impacts, worst_error, scale] = numbers;
        let mut largest = [0.0; 2];
        loader.fill(&mut largest)?;
        let pole = loader.flag()?.then(|| {
            let mut numbers = [0.0; 2];
            loader.fill(&mut numbers)?;
            let ([t, cosine], coordinate_idx) = (numbers, loader.index(compiled.nq())?);
            Ok(NearPole { t, coordinate_idx, cosine })
        });
        let pole = pole.transpose()?;
        let driving = loader.flag()?.then(|| Ok((loader.real()?, LoadId(loader.count()?))));
        let driving = driving.transpose()?;
        let nc = compiled.nc();
        let pushing = loader.flag()?.then(|| Ok((loader.real()?, loader.index(nc)?)));
        let pushing = pushing.transpose()?;
        let left = loader.flag()?.then(|| Ok((loader.real()?, loader.count()?)));
        let left = left.transpose()?;
        let wound = loader.flag()?.then(|| Ok((loader.count()?, loader.real()?)));
        let wound = wound.transpose()?;
        let noise = load_noise(loader)?;
        let slowness = loader.flag()?.then(|| Slowness::load(loader, compiled.nq())).transpose()?;
        // A length that is too large fails at the first number that is missing.
        let poses = 0..loader.count()?;
        let singular_poses =
            poses.map(|_| SingularPose::load(loader, nc)).collect::<Result<_, _>>()?;
        let assembly_changes = (0..loader.count()?).map(|_| {
            let (t, joint) = (loader.real()?, JointId(loader.index(compiled.joints.len())?));
            Ok(AssemblyChange { t, joint })
        });
        let assembly_changes = assembly_changes.collect::<Result<_, SolveError>>()?;
        let methods = 0..loader.count()?;
        let methods = methods.map(|_| MethodChange::load(loader)).collect::<Result<_, _>>()?;
        let changes = 0..loader.count()?;
        let changes = changes.map(|_| Change::load(loader, compiled)).collect::<Result<_, _>>()?;
        let uniqueness = (0..loader.count()?).map(|_| {
            let (t, all) = (loader.real()?, compiled.transmissions.all_unique());
            Ok(UniquenessChange { t, uniqueness: all.load(loader)? })
        });
        let uniqueness = uniqueness.collect::<Result<_, _>>()?;
        Ok(Self {
            uniqueness,
            reached_end: false,
            t,
            n_samples,
            stats,
            position_residual,
            velocity_residual,
            energy: EnergyBalance { initial, last, work, turnover, impacts, worst_error, scale },
            singular_poses,
            assembly_changes,
            pole,
            driving,
            pushing,
            left,
            wound,
            noise,
            slowness,
            largest,
            methods,
            changes,
            checkpoint: None,
        })
    }
}

impl Uniqueness {
    /// The numbers of the components that are not unique.
    fn save(&self, saver: &mut Saver) {
        let components = self.reactions.as_flattened().iter().chain(&self.couplings);
        let components = components.chain(&self.drives).chain(&self.contacts).enumerate();
        let shared = components.filter(|(_, is_unique)| !**is_unique).map(|(idx, _)| idx);
        saver.count(self.n_self_stresses);
        saver.indices(&shared.collect::<Vec<_>>());
    }

    /// With the components that were saved as not unique, of a mechanism in which all are.
    fn load(mut self, loader: &mut Loader<'_>) -> Result<Self, SolveError> {
        self.n_self_stresses = loader.count()?;
        let Self { reactions, couplings, drives, contacts, .. } = &mut self;
        let components = reactions.as_flattened_mut().iter_mut().chain(couplings);
        let components = components.chain(drives).chain(contacts);
        let mut components: Vec<&mut bool> = components.collect();
        for idx in loader.indices(components.len())? {
            *components[idx] = false;
        }
        Ok(self)
    }
}

impl SingularPose {
    fn save(&self, saver: &mut Saver) {
        saver.real(self.t);
        saver.count(self.rank);
        saver.indices(&self.rows);
    }

    /// A pose of a mechanism with `nc` rows.
    fn load(loader: &mut Loader<'_>, nc: usize) -> Result<Self, SolveError> {
        Ok(Self { t: loader.real()?, rank: loader.index(nc + 1)?, rows: loader.indices(nc)? })
    }
}

const INTEGRATORS: [Integrator; 2] = [Integrator::Explicit, Integrator::Radau];
const REASONS: [Reason; 9] = [
    Reason::Asked,
    Reason::Cheapest,
    Reason::Stiff,
    Reason::Slow,
    Reason::NoGain,
    Reason::OtherFailed,
    Reason::SingularPose,
    Reason::Regular,
    Reason::Relaxed,
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
