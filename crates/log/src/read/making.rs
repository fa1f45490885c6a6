//! Topics that a reader makes from samples of a log, next to those that the log has.

use super::Record;
use crate::{Header, Topic, TopicId};

/// The values of made topics, one after the other, from a sample of each topic that they are made from.
pub type Make = Box<dyn FnMut(&[Vec<f64>], &mut [f64]) + Send>;

/// Topics to be made: see [`LogReader::making`](super::LogReader::making).
pub struct Making {
    /// The topics; a name may be that of a topic of the log.
    pub topics: Vec<Topic>,
    /// The topics of the log that they are made from, sampled at the same instants.
    pub from: Vec<TopicId>,
    /// Their values.
    pub make: Make,
}

/// Made topics on their way through a log.
pub(super) struct Made {
    make: Make,
    /// The handles of the topics, with the number of fields of each.
    topics: Vec<(TopicId, usize)>,
    from: Vec<TopicId>,
    /// Their samples at the present instant, and how many of them are there.
    samples: Vec<Vec<f64>>,
    n_seen: usize,
    t: f64,
    values: Vec<f64>,
    /// The topic that is next, and where its values begin.
    next: Option<(usize, usize)>,
}

impl Made {
    pub(super) fn new(making: Making, header: &mut Header) -> Self {
        let Making { topics, from, make } = making;
        let sizes: Vec<usize> = topics.iter().map(|topic| topic.fields.len()).collect();
        let ids = topics.into_iter().map(|topic| header.add_topic(topic));
        Self {
            make,
            topics: ids.zip(sizes.iter().copied()).collect(),
            samples: vec![Vec::new(); from.len()],
            from,
            n_seen: 0,
            t: 0.0,
            values: vec![0.0; sizes.iter().sum()],
            next: None,
        }
    }

    /// True where a sample of this topic is needed for one of these.
    pub(super) fn needs(&self, topic: TopicId, wanted: &[TopicId]) -> bool {
        self.from.contains(&topic) && self.topics.iter().any(|(id, _)| wanted.contains(id))
    }

    /// Takes a sample of the log; with the last one of an instant the topics are made.
    pub(super) fn take(&mut self, topic: TopicId, t: f64, values: &[f64]) {
        let Some(place) = self.from.iter().position(|&from| from == topic) else { return };
        // The topics are written in one order, so the first one begins an instant.
        if place == 0 || self.t != t {
            self.n_seen = 0;
        }
        self.t = t;
        self.samples[place].clear();
        self.samples[place].extend_from_slice(values);
        self.n_seen += 1;
        if self.n_seen == self.from.len() && !self.topics.is_empty() {
            (self.make)(&self.samples, &mut self.values);
            self.next = Some((0, 0));
        }
    }

    pub(super) fn is_pending(&self) -> bool {
        self.next.is_some()
    }

    /// The sample of the next topic of this instant.
    pub(super) fn next(&mut self) -> Option<Record<'_>> {
        let (idx, first) = self.next.take()?;
        let &(topic, n_fields) = self.topics.get(idx)?;
        let end = first + n_fields;
        self.next = (idx + 1 < self.topics.len()).then_some((idx + 1, end));
        Some(Record::Sample { topic, t: self.t, values: &self.values[first..end] })
    }
}
