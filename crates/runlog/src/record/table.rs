//! A run as a table: one row per value of a sample, in the order of the channels, and back.

use bksim_log::Field;
use bksim_sim::run::Sample;

use crate::channels::{Channels, N_MADE, TopicKind};

impl Channels {
    /// Names and fields of all values of a sample: `state.theta1`, `energy.total`.
    pub fn columns(&self) -> impl Iterator<Item = (String, &Field)> {
        self.topics
            .iter()
            .flat_map(|(topic, _)| topic.fields.iter().map(|f| (topic.column_name(f), f)))
    }

    /// The number of [`Channels::columns`].
    pub fn n_columns(&self) -> usize {
        self.topics.iter().map(|(topic, _)| topic.fields.len()).sum()
    }

    /// Whether each of [`Channels::columns`] has a value at every instant, and not only in samples.
    pub fn are_lasting(&self) -> impl Iterator<Item = bool> {
        self.topics.iter().flat_map(|(topic, of)| topic.fields.iter().map(|f| of.is_lasting(f)))
    }

    /// Appends the values of a sample to `row`.
    pub fn append_row(&self, sample: &Sample, row: &mut Vec<f64>) {
        let mut made = [0.0; N_MADE];
        for &(_, of) in &self.topics {
            self.values(of, sample, &mut made).iter().for_each(|part| row.extend_from_slice(part));
        }
    }

    /// The sample that a row was taken from; counters that no channel has are those of `like`.
    ///
    /// # Panics
    /// If the row is shorter than a row of this table.
    pub fn sample_of(&self, t: f64, row: &[f64], like: &Sample) -> Sample {
        let mut sample = Sample { t, signals: Vec::new(), ..like.clone() };
        let mut rest = row;
        for (topic, of) in &self.topics {
            let (values, others) = rest.split_at(topic.fields.len());
            rest = others;
            put(&mut sample, *of, values);
        }
        sample
    }
}

fn put(sample: &mut Sample, of: TopicKind, values: &[f64]) {
    match of {
        TopicKind::State => {
            let (q, v) = values.split_at(values.len() / 2);
            (sample.q, sample.v) = (q.to_vec(), v.to_vec());
        }
        TopicKind::Acceleration => sample.a = values.to_vec(),
        TopicKind::Multipliers => sample.lambda = values.to_vec(),
        TopicKind::Reaction(joint) => {
            let n_joints = sample.reactions.len().max(joint + 1);
            sample.reactions.resize(n_joints, [0.0; 6]);
            sample.reactions[joint].copy_from_slice(values);
        }
        // They are among the multipliers.
        TopicKind::Couplings | TopicKind::Drives => (),
        TopicKind::Inputs => sample.inputs = values.to_vec(),
        TopicKind::Signals => sample.signals = values.to_vec(),
        // Their topic comes after that of signals, whose values they follow.
        TopicKind::Outputs => sample.signals.extend_from_slice(values),
        TopicKind::Energy => {
            let energy = &mut sample.energy;
            (energy.kinetic, energy.potential) = (values[0], values[1]);
            (sample.work, energy.power) = (values[3], values[4]);
        }
        TopicKind::Solver => {
            sample.step_size = values[0];
            sample.position_residual = [values[3], values[1]];
            sample.velocity_residual = [values[4], values[2]];
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "counters were integers before they were written"
            )]
            let counter = |k: usize| values[k] as usize;
            let stats = &mut sample.stats;
            (stats.n_step, stats.n_reject) = (counter(5), counter(6));
            (stats.n_newton, stats.n_jacobian, stats.n_factor) =
                (counter(7), counter(8), counter(9));
        }
    }
}
