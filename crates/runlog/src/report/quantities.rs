//! [`Quantities`]: what a report looks at in each instant of a run, as numbers.

use bksim_mbs::system::SymbolicSystem;
use bksim_model::{JointId, Measure, Model, MotionKind, motion_words};
use bksim_sim::Mechanism;
use bksim_sim::observable::Observables;
use bksim_sim::powers::Powers;
use bksim_sim::run::Sample;
use bksim_sim::wrenches::{ContactForces, WrenchAt};

use super::Unreported;

/// The quantities of an instant, one after the other.
pub(super) struct Quantities {
    /// Joint and motion, with its name and unit; each has position, rate and acceleration.
    pub(super) motions: Vec<(JointId, usize, String, MotionKind)>,
    /// Names of points; each has the sizes of velocity and acceleration.
    pub(super) points: Vec<String>,
    /// The motion of each drive among `motions`.
    pub(super) drives: Vec<usize>,
    /// Joints, then contacts.
    n_bearings: usize,
    contacts: Option<ContactForces>,
    n_outputs: usize,
    observables: Observables,
    /// Values of the observables.
    seen: Vec<f64>,
    pub(super) powers: Powers,
}

/// Numbers of an instant that belong to no part: kinetic, potential and total energy, power. Those after them are the
/// powers of parts.
pub(super) const N_ENERGIES: usize = 4;

impl Quantities {
    pub(super) fn new(mechanism: &Mechanism) -> Result<Self, Unreported> {
        let Mechanism { model, system, compiled, parameters, .. } = mechanism;
        let (model, system): (&Model, &SymbolicSystem) = (model, system);
        let mut names: Vec<String> = Vec::new();
        let mut motions = Vec::new();
        for (joint_idx, joint) in model.joints.iter().enumerate() {
            for (motion_idx, kind) in joint.kind.motions().iter().enumerate() {
                let words = motion_words(joint.kind.motions(), motion_idx);
                let of = |word: &str| format!("{}.{word}", joint.name);
                motions.push((JointId(joint_idx), motion_idx, of(words[0]), *kind));
                names.extend(words.map(of));
            }
        }
        // The ground does not move.
        let mut points = Vec::new();
        for body in model.bodies.iter().skip(1) {
            let own = body.points.iter().map(|point| format!("{}.{}", body.name, point.name));
            points.extend(std::iter::once(body.name.clone()).chain(own));
        }
        for point in &points {
            names
                .extend(["vx", "vy", "vz", "ax", "ay", "az"].map(|word| format!("{point}.{word}")));
        }
        let observables: Vec<Measure> = names
            .iter()
            .map(|name| Measure::named(model, name).expect("the names of a model's own parts"))
            .collect();
        let drives = model.drives.iter().map(|drive| {
            let of = motions
                .iter()
                .position(|&(joint, idx, ..)| (joint, idx) == (drive.joint, drive.motion_idx));
            of.expect("a drive is of a motion of a joint")
        });
        Ok(Self {
            drives: drives.collect(),
            n_bearings: model.joints.len() + model.contacts.len(),
            contacts: ContactForces::compile(mechanism)?,
            n_outputs: model.named_signals.iter().filter(|signal| signal.is_output).count(),
            seen: vec![0.0; observables.len()],
            observables: Observables::compile(model, system, &observables, parameters)?,
            powers: Powers::compile(model, system, compiled, parameters)?,
            motions,
            points,
        })
    }

    /// Reactions of joints and contacts on their second bodies: force, N, and moment, N m; that of a contact about the point
    /// where it presses.
    pub(super) fn bearings(&mut self, sample: &Sample, modes: &[f64]) -> Vec<[f64; 6]> {
        let of_contacts = self.contacts.as_mut().map(|contacts| contacts.at(sample, modes));
        let of_contacts = of_contacts.iter().flatten().map(WrenchAt::six);
        sample.reactions.iter().copied().chain(of_contacts).collect()
    }

    /// Places of the first numbers of points, drives, reactions, outputs and energies.
    pub(super) fn places(&self) -> [usize; 5] {
        let points = 3 * self.motions.len();
        let drives = points + 2 * self.points.len();
        let reactions = drives + 2 * self.drives.len();
        let outputs = reactions + 2 * self.n_bearings;
        [points, drives, reactions, outputs, outputs + self.n_outputs]
    }

    pub(super) fn count(&self) -> usize {
        self.places()[4] + N_ENERGIES + self.powers.actors().len()
    }

    /// Forgets those numbers of an instant that a singular pose leaves undetermined.
    pub(super) fn forget_undetermined(&self, out: &mut [f64]) {
        let [points, drives, _, _, energies] = self.places();
        let of_motions = (2..points).step_by(3);
        let of_points = (points + 1..drives).step_by(2);
        for place in of_motions.chain(of_points).chain(drives..energies) {
            out[place] = f64::NAN;
        }
    }

    /// Writes the numbers of an instant; `signals` are the efforts of the drives, then the outputs, `modes` those
    /// that hold there.
    pub(super) fn write(
        &mut self,
        sample: &Sample,
        signals: &[f64],
        modes: &[f64],
        out: &mut [f64],
    ) {
        let (efforts, outputs) = signals.split_at(self.drives.len());
        let reaction = |joint: JointId| sample.reactions[joint.0];
        self.observables.at(
            [&sample.q, &sample.v, &sample.a, &sample.lambda],
            &reaction,
            &mut self.seen,
        );
        let [points, drives, reactions, of_outputs, energies] = self.places();
        let (own, of_points) = self.seen.split_at(points);
        out[..points].copy_from_slice(own);
        let size = |parts: &[f64]| parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        for (sizes, parts) in out[points..drives].iter_mut().zip(of_points.chunks(3)) {
            *sizes = size(parts);
        }
        for (idx, (&effort, &motion)) in efforts.iter().zip(&self.drives).enumerate() {
            let rate = self.seen[3 * motion + 1];
            out[drives + 2 * idx..][..2].copy_from_slice(&[effort, effort * rate]);
        }
        for (idx, six) in self.bearings(sample, modes).iter().enumerate() {
            out[reactions + 2 * idx..][..2].copy_from_slice(&[size(&six[..3]), size(&six[3..])]);
        }
        out[of_outputs..energies].copy_from_slice(outputs);
        let energy = &sample.energy;
        let total = energy.kinetic + energy.potential;
        let all = [energy.kinetic, energy.potential, total, energy.power];
        let (of_energies, of_powers) = out[energies..].split_at_mut(N_ENERGIES);
        of_energies.copy_from_slice(&all);
        let state = (sample.t, &sample.q[..], &sample.v[..]);
        of_powers.copy_from_slice(self.powers.at(state, &sample.lambda, modes).0);
    }
}
