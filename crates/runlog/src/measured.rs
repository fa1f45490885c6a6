//! Quantities of a logged run that are no channels of its log: computed from its samples by the equations of its
//! model.

use bksim_expr::TapeError;
use bksim_log::{Field, Header, Making, Topic, TopicId};
use bksim_model::{JointId, Measure};
use bksim_sim::Mechanism;
use bksim_sim::observable::Observables;
use bksim_sim::run::Sample;

/// Quantities by name, as topics to be made from a log.
#[derive(Clone, Debug)]
pub struct Measured {
    topics: Vec<Topic>,
    observables: Observables,
    /// The topics of the log that they are made from: state, accelerations, reactions.
    from: Vec<TopicId>,
    /// The joint of each topic of reactions.
    joints: Vec<JointId>,
    n_coordinates: usize,
    /// True if the multipliers are among those topics.
    has_multipliers: bool,
}

/// Why quantities cannot be computed from a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unmeasured {
    /// The model has nothing of this name.
    #[error("the model has nothing called `{0}`")]
    Unknown(String),
    /// The log was written without the samples that are needed.
    #[error("the log has no samples of `{0}`")]
    Missing(&'static str),
    /// Their functions cannot be compiled.
    #[error(transparent)]
    Tape(#[from] TapeError),
}

impl Measured {
    /// The quantities of these names in runs of `mechanism` whose logs have this header.
    ///
    /// # Errors
    /// [`Unmeasured`].
    pub fn new(
        mechanism: &Mechanism,
        header: &Header,
        names: &[String],
    ) -> Result<Self, Unmeasured> {
        let model = &mechanism.model;
        let mut topics: Vec<Topic> = Vec::new();
        let mut joints: Vec<JointId> = Vec::new();
        let mut of_topic: Vec<Vec<Measure>> = Vec::new();
        for name in names {
            let unknown = || Unmeasured::Unknown(name.clone());
            let measure = Observables::named(model, name).ok_or_else(unknown)?;
            if let Measure::Reaction(joint, ..) | Measure::Resultant(joint, _) = measure
                && !joints.contains(&joint)
            {
                joints.push(joint);
            }
            // `rod.B.x` is the field `x` of the topic `/rod/B`.
            let (owner, word) = name.rsplit_once('.').ok_or_else(unknown)?;
            let topic = format!("/{}", owner.replace('.', "/"));
            let place = topics.iter().position(|known| known.name == topic);
            let place = place.unwrap_or_else(|| {
                topics.push(Topic::new(&topic, []));
                of_topic.push(Vec::new());
                topics.len() - 1
            });
            topics[place].fields.push(Field::new(word, &measure.unit(model).replace(' ', "*"), ""));
            of_topic[place].push(measure);
        }

        // The samples that they are made from, in the order of the log.
        let id = |name: &str| header.topic_id(name);
        let mut from = vec![
            id("/state").ok_or(Unmeasured::Missing("/state"))?,
            id("/acceleration").ok_or(Unmeasured::Missing("/acceleration"))?,
        ];
        joints.sort_unstable();
        for joint in &joints {
            let topic = format!("/reactions/{}", model.joints[joint.0].name);
            from.push(id(&topic).ok_or(Unmeasured::Missing("/reactions"))?);
        }
        let all = of_topic.concat();
        let has_multipliers = Observables::need_multipliers(&all);
        if has_multipliers {
            from.insert(2, id("/multipliers").ok_or(Unmeasured::Missing("/multipliers"))?);
        }
        let n_coordinates = mechanism.system.coordinates().len();
        for (topic, n_fields) in from.iter().zip([2 * n_coordinates, n_coordinates]) {
            let topic = &header.topics[topic.index()];
            if topic.fields.len() != n_fields {
                return Err(Unmeasured::Missing("/state"));
            }
        }
        let observables =
            Observables::compile(model, &mechanism.system, &all, &mechanism.parameters)?;
        Ok(Self { topics, observables, from, joints, n_coordinates, has_multipliers })
    }

    /// The place of a quantity among the values of [`Measured::at`].
    pub fn position(&self, name: &str) -> Option<usize> {
        let columns = |topic: &Topic| -> Vec<String> {
            topic.fields.iter().map(|field| topic.column_name(field)).collect()
        };
        self.topics.iter().flat_map(columns).position(|known| known == name)
    }

    /// The quantities at a sample of the run, topic by topic.
    pub fn at(&mut self, sample: &Sample) -> Vec<f64> {
        let n_values = self.topics.iter().map(|topic| topic.fields.len()).sum();
        let mut values = vec![0.0; n_values];
        let reaction = |joint: JointId| sample.reactions[joint.0];
        self.observables.at(
            [&sample.q, &sample.v, &sample.a, &sample.lambda],
            &reaction,
            &mut values,
        );
        values
    }

    /// The topics, to be made by a [reader](bksim_log::LogReader::making) of the log.
    pub fn making(&self) -> Making {
        let Self { mut observables, joints, n_coordinates, has_multipliers, .. } = self.clone();
        let make = move |samples: &[Vec<f64>], values: &mut [f64]| {
            let [state, accelerations, rest @ ..] = samples else { return };
            let (multipliers, reactions) = rest.split_at(usize::from(has_multipliers));
            let multipliers = multipliers.first().map_or(&[][..], Vec::as_slice);
            let (q, v) = state.split_at(n_coordinates);
            let reaction = |joint: JointId| {
                let place = joints.iter().position(|known| *known == joint);
                let six = place.and_then(|place| reactions.get(place)?.first_chunk::<6>());
                six.copied().unwrap_or([f64::NAN; 6])
            };
            observables.at([q, v, accelerations, multipliers], &reaction, values);
        };
        Making { topics: self.topics.clone(), from: self.from.clone(), make: Box::new(make) }
    }
}
