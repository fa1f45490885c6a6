//! Every channel of a run as a curve: at even times, and at both sides of jumps.

use std::collections::BTreeMap;

use bksim::model::file::{ShownUnit, ShownUnits};
use bksim::overview::floor;
use bksim::playback::Playback;
use bksim::sim::run::Unreplayed;
use serde_json::{Value, json};

use crate::budget::n_numbers;
use crate::escape::{doubles, singles};
use crate::motion::Motion;

/// Number of even times of a curve: more than a chart has columns of pixels.
const N_EVEN: u32 = 1200;
/// Largest number of jumps that are drawn with both sides; there are rarely as many.
const MAX_JUMPS: usize = 1000;

/// The curves of a run.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Curves {
    times: Vec<f64>,
    channels: Vec<Channel>,
    n_left_out: usize,
}

/// One curve.
#[derive(Clone, PartialEq, Debug)]
struct Channel {
    name: String,
    /// The reader's.
    unit: String,
    description: String,
    values: Vec<f64>,
    /// First and last instants of the spans in which it is one of many solutions of the equilibrium,
    /// in the order of rising time.
    shared: Vec<[f64; 2]>,
}

/// The curves of `playback` over the span of `motion`, in at most `bytes` bytes; `load` is the largest applied force, N.
pub(crate) fn take(
    playback: &mut Playback,
    motion: &Motion,
    (units, bytes): (&ShownUnits, usize),
    load: f64,
) -> Result<Curves, Unreplayed> {
    let times = times(motion);
    let capacity = n_numbers(bytes, size_of::<f32>()) / times.len().max(1);
    let (mut signals, mut channels) = (Vec::new(), Vec::new());
    let mut shown = Vec::new();
    let mut n_left_out = 0;
    for (signal, name, field) in playback.channels().signals() {
        if channels.len() == capacity.max(1) {
            n_left_out += 1;
            continue;
        }
        signals.push(signal);
        let own = units.of(&field.unit);
        let (unit, description) = (own.unit.clone(), field.description.clone());
        shown.push((field.unit.clone(), own));
        let shared = shared_spans(&playback.uniqueness_of(signal), motion.span());
        channels.push(Channel { name, unit, description, values: Vec::new(), shared });
    }
    for &t in &times {
        playback.seek(t)?;
        for (channel, &signal) in channels.iter_mut().zip(&signals) {
            channel.values.push(playback.value(signal));
        }
    }
    // What is rounding next to the other channels of a unit is none of its own.
    let mut largest: BTreeMap<&str, f64> = BTreeMap::from([("N", load)]);
    for (channel, (si, _)) in channels.iter().zip(&shown) {
        let size = |value: &f64| if value.is_finite() { value.abs() } else { 0.0 };
        let own = channel.values.iter().map(size).fold(0.0, f64::max);
        let known = largest.entry(si).or_default();
        *known = known.max(own);
    }
    for (channel, (si, unit)) in channels.iter_mut().zip(&shown) {
        in_units(channel, unit, floor(si, largest.get(si.as_str()).copied().unwrap_or(0.0)));
    }
    Ok(Curves { times, channels, n_left_out })
}

/// Puts the values of a channel into the reader's unit, without what is below a floor.
fn in_units(channel: &mut Channel, shown: &ShownUnit, floor: f64) {
    for value in &mut channel.values {
        *value = shown.of_si(if value.abs() <= floor { 0.0 } else { *value });
    }
}

/// The spans in which a signal is not unique, from the instants at which that changes.
pub(crate) fn shared_spans(changes: &[(f64, bool)], [first, last]: [f64; 2]) -> Vec<[f64; 2]> {
    let until = |idx: usize| changes.get(idx + 1).map_or(last, |&(t, _)| t);
    let spans = changes.iter().enumerate().filter(|(_, (_, is_unique))| !is_unique);
    let in_order = |[from, to]: [f64; 2]| [from.min(to), from.max(to)];
    let mut spans: Vec<_> = spans.map(|(idx, &(t, _))| in_order([t, until(idx)])).collect();
    if last < first {
        spans.reverse();
    }
    spans
}

/// Even times, and each event with the last instant before it.
fn times(motion: &Motion) -> Vec<f64> {
    let [first, last] = motion.span();
    let is_forward = last >= first;
    let even = (0..=N_EVEN).map(|k| first + (last - first) * f64::from(k) / f64::from(N_EVEN));
    let before = |t: f64| if is_forward { t.next_down() } else { t.next_up() };
    let within = |t: &&f64| (**t - first) * (last - **t) > 0.0;
    let events = motion.events.iter().filter(within).take(MAX_JUMPS);
    let mut times: Vec<f64> = even.chain(events.flat_map(|&t| [before(t), t])).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

impl Curves {
    /// Number of curves that are kept, and of curves of the run.
    pub(crate) fn counts(&self) -> [usize; 2] {
        [self.channels.len(), self.channels.len() + self.n_left_out]
    }

    /// A sentence on the curves that are left out.
    pub(crate) fn remark(&self) -> Option<String> {
        let [kept, all] = self.counts();
        (kept < all).then(|| {
            format!(
                "The page has {kept} of {all} curves; `bksim plot` and `bksim export` have all."
            )
        })
    }

    /// The curves as JSON for the page, in the order of rising time.
    pub(crate) fn write(&self) -> Value {
        let channel = |channel: &Channel| {
            let Channel { name, unit, description, values, shared } = channel;
            let first = *values.first().expect("a curve has a value at every time");
            let is_constant = first.is_finite() && values.iter().all(|&value| value == first);
            let (constant, values) = if is_constant {
                (Some(first), None)
            } else {
                (None, Some(singles(values.iter().copied())))
            };
            json!({
                "name": name, "unit": unit, "description": description,
                "constant": constant, "values": values, "shared": shared,
            })
        };
        json!({
            "times": doubles(self.times.iter().copied()),
            "channels": self.channels.iter().map(channel).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::shared_spans;

    #[test]
    fn spans_rise_whichever_way_the_run_goes() {
        let changes = [(0.0, false), (1.0, true), (2.0, false)];
        assert_eq!(shared_spans(&changes, [0.0, 3.0]), [[0.0, 1.0], [2.0, 3.0]]);
        let changes = [(3.0, true), (2.0, false), (1.0, true), (0.5, false)];
        assert_eq!(shared_spans(&changes, [3.0, 0.0]), [[0.0, 0.5], [1.0, 2.0]]);
    }
}
