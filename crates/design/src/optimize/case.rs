//! Evaluations of a mechanism: over its motion, at rest, over positions.

use bksim::analysis::{Drive, statics};
use bksim::model::Model;
use bksim::model::diagnostic::Diagnostic;
use bksim::sim::run::Sample;
use bksim_sweep::{Ending, Monitor, Study};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::{Case, Over};
use crate::base::Watch;
use crate::codes;
use crate::error::DesignError;
use crate::poses::{Pose, Poses, Solver};

/// Positions over a range of a measure.
pub(super) fn driven(study: &Study, range: &str) -> Result<Over, DesignError> {
    let mechanism = study.mechanism();
    let bad = || {
        let message = format!("`{range}` is nothing that is evaluated over");
        let help =
            "write `motion`, `static` or a range of a measure, as in `crank.angle=0:360 deg:361`";
        DesignError::fault(codes::BAD_QUESTION, message, help)
    };
    let (name, values) = range.split_once('=').ok_or_else(bad)?;
    let drive = Drive::parse(&mechanism.model, name.trim(), values.trim())?;
    let poses = Poses::new(&mechanism, &[(drive.name.clone(), drive.measure)], &[], &[])?;
    Ok(Over::Drive(Box::new(poses), drive.range.values()))
}

impl Case {
    /// The outputs at some points, SI; `None` where the mechanism has none.
    pub(super) fn at(&self, points: &[Vec<f64>], watch: Watch<'_>) -> Vec<Option<Vec<f64>>> {
        let unless = |of: &(dyn Fn() -> Option<Vec<f64>> + Sync)| {
            if (watch.stop)() { None } else { of() }
        };
        match &self.over {
            Over::Motion => {
                let monitor = Monitor { stop: watch.stop, progress: &|_| () };
                let rows =
                    self.study.rows_at(points, 0, &monitor).ok().flatten().unwrap_or_default();
                let outputs =
                    |row: bksim_sweep::Row| (row.ending == Ending::Done).then_some(row.outputs);
                let mut found: Vec<_> = rows.into_iter().map(outputs).collect();
                found.resize(points.len(), None);
                found
            }
            Over::Static => {
                points.par_iter().map(|point| unless(&|| self.at_rest(point))).collect()
            }
            Over::Drive(poses, values) => {
                let at = |point: &Vec<f64>| unless(&|| self.over_drive(point, poses, values));
                points.par_iter().map(at).collect()
            }
        }
    }

    /// Fault of the mechanism at a point where nothing is found at rest.
    pub(super) fn fault_at_rest(&self, point: &[f64]) -> Option<Diagnostic> {
        let Over::Static = self.over else { return None };
        let parameters = self.study.parameters_at(point)?;
        statics(self.model_with(&parameters), &[], &[]).err()?.diagnostics().into_iter().next()
    }

    /// The model with these values of its parameters.
    fn model_with(&self, parameters: &[f64]) -> Model {
        let mut model = self.study.mechanism().model;
        for (parameter, value) in model.parameters.iter_mut().zip(parameters) {
            parameter.value = *value;
        }
        model
    }

    /// The first equilibrium.
    fn at_rest(&self, point: &[f64]) -> Option<Vec<f64>> {
        let parameters = self.study.parameters_at(point)?;
        let found = statics(self.model_with(&parameters), &[], &[]).ok()?;
        let first = found.equilibria.first()?;
        let n = first.q.len();
        let sample = Sample {
            q: first.q.clone(),
            v: vec![0.0; n],
            a: vec![0.0; n],
            lambda: first.lambda.clone(),
            reactions: first.reactions.clone(),
            ..self.blank()
        };
        Some(self.study.outputs_of(&parameters, &[sample], &mut |_| None))
    }

    /// Positions over the range, the measure in place of time; rates are by it.
    fn over_drive(&self, point: &[f64], poses: &Poses, values: &[f64]) -> Option<Vec<f64>> {
        let parameters = self.study.parameters_at(point)?;
        let mut solver = poses.solver();
        let blank = self.blank();
        let sample = |solver: &mut Solver<'_>, from: &Pose, value: f64| {
            let pose = solver.follow(from, &parameters, &[value]).ok()?;
            let v = solver.rate(&pose)?;
            let a = vec![f64::NAN; pose.q.len()];
            Some((Sample { t: value, q: pose.q.clone(), v, a, ..blank.clone() }, pose))
        };
        let mut pose: Pose = solver.follow(&poses.start, &parameters, &poses.start.u).ok()?;
        let (mut samples, mut all) = (Vec::with_capacity(values.len()), Vec::new());
        for &value in values {
            let (next, at) = sample(&mut solver, &pose, value)?;
            samples.push(next);
            all.push(pose);
            pose = at;
        }
        all.push(pose);
        let mut between = |t: f64| {
            let before = values.windows(2).position(|ends| (t - ends[0]) * (ends[1] - t) >= 0.0)?;
            Some(sample(&mut solver, &all[before + 1], t)?.0)
        };
        Some(self.study.outputs_of(&parameters, &samples, &mut between))
    }

    /// A sample that has nothing.
    fn blank(&self) -> Sample {
        let model = self.study.mechanism().model;
        Sample {
            reactions: vec![[f64::NAN; 6]; model.joints.len()],
            signals: vec![f64::NAN; model.named_signals.len()],
            inputs: vec![f64::NAN; model.inputs.len()],
            ..Sample::default()
        }
    }
}
