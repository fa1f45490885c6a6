//! Channels of the derivatives of a run by parameters and stated values.

use bksim_log::{Field, Topic};
use bksim_mbs::quantity::Quantity;
use bksim_sim::Mechanism;
use bksim_sim::sensitivity::{Sensitive, StateSensitivity, channels};

/// Names and fields of the derivatives of a sample by some quantities, in the order of
/// [`sensitivity_row`]: `sensitivity.l1.theta1`.
pub fn sensitivity_columns(mechanism: &Mechanism, by: &[Sensitive]) -> Vec<(String, Field)> {
    let topics = by.iter().flat_map(|&by| sensitivity_topics(mechanism, by));
    let columns = topics.flat_map(|topic| {
        let named = |field: &Field| (topic.column_name(field), field.clone());
        topic.fields.iter().map(named).collect::<Vec<_>>()
    });
    columns.collect()
}

/// Names of everything in a sample that a goal may depend on, in the order of the fields of
/// [`SampleWeights`](bksim_sim::sensitivity::SampleWeights) and of [`sensitivity_row`]: `theta1`, `energy.total`.
pub fn weight_columns(mechanism: &Mechanism) -> Vec<String> {
    let Mechanism { model, system, compiled, .. } = mechanism;
    let names = compiled.coordinates.iter().map(|c| &c.name);
    let rates =
        (0..2).flat_map(|order| compiled.coordinates.iter().map(move |c| &c.rates[order][0]));
    let multipliers = compiled.multipliers.iter().map(|m| &m.name);
    let channels = channels(model, system).into_iter().map(|channel| channel.name);
    names.chain(rates).chain(multipliers).cloned().chain(channels).collect()
}

/// The derivatives of a sample by one quantity.
pub fn sensitivity_row(by: &StateSensitivity) -> impl Iterator<Item = f64> {
    [&by.q, &by.v, &by.a, &by.lambda, &by.channels].into_iter().flatten().copied()
}

/// The topics of the derivatives by one quantity, whose fields follow each other as in [`sensitivity_row`]: one of
/// coordinates, rates, second rates and multipliers, `/sensitivity/l1`, and one for the energies and for each joint and
/// point, `/sensitivity/l1/reactions/B`.
pub(super) fn sensitivity_topics(mechanism: &Mechanism, by: Sensitive) -> Vec<Topic> {
    let (model, compiled) = (&mechanism.model, &mechanism.compiled);
    let name = by.name(model);
    let field = |name: String, unit: String| {
        let unit = by.unit_of_derivative(model, &unit);
        Field::new(&name, &unit, &format!("derivative by {}", by.name(model)))
    };
    let motion = (0..3).flat_map(|order: usize| {
        let of_order = move |c: &Quantity| match order.checked_sub(1) {
            None => (c.name.clone(), c.unit.clone()),
            Some(rate) => (c.rates[rate][0].clone(), c.rates[rate][1].clone()),
        };
        compiled.coordinates.iter().map(of_order)
    });
    let multipliers = compiled.multipliers.iter().map(|m| (m.name.clone(), m.unit.clone()));
    let own = format!("/sensitivity/{}", name.replace('.', "/"));
    let fields = motion.chain(multipliers).map(|(name, unit)| field(name, unit));
    let mut topics = vec![Topic::new(&own, fields)];
    for channel in channels(model, &mechanism.system) {
        let (owner, word) = channel.name.rsplit_once('.').unwrap_or(("", &channel.name));
        let topic = format!("{own}/{}", owner.replace('.', "/"));
        if topics.last().is_none_or(|last| last.name != topic) {
            topics.push(Topic::new(&topic, []));
        }
        if let Some(last) = topics.last_mut() {
            last.fields.push(field(word.to_owned(), channel.unit.clone()));
        }
    }
    topics
}
