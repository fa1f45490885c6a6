//! Every channel of a run as a curve: at even times, and at both sides of what jumps.

use bksim::playback::Playback;
use bksim::sim::run::Unreplayed;
use serde_json::{Value, json};

use crate::budget::n_numbers;
use crate::escape::{doubles, singles};
use crate::motion::Motion;

/// Even times of a curve: more than a screen has columns for each chart.
const N_EVEN: u32 = 1200;
/// Jumps that are drawn with both sides; there are rarely as many.
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
    unit: String,
    description: String,
    values: Vec<f64>,
}

/// The curves of `playback` over what is kept of its motion, in at most `bytes` bytes.
pub(crate) fn take(
    playback: &mut Playback,
    motion: &Motion,
    bytes: usize,
) -> Result<Curves, Unreplayed> {
    let times = times(motion);
    let room = n_numbers(bytes, size_of::<f32>()) / times.len().max(1);
    let (mut signals, mut channels) = (Vec::new(), Vec::new());
    let mut n_left_out = 0;
    for (signal, name, field) in playback.channels().signals() {
        if channels.len() == room.max(1) {
            n_left_out += 1;
            continue;
        }
        signals.push(signal);
        let (unit, description) = (field.unit.clone(), field.description.clone());
        channels.push(Channel { name, unit, description, values: Vec::new() });
    }
    for &t in &times {
        playback.seek(t)?;
        for (channel, &signal) in channels.iter_mut().zip(&signals) {
            channel.values.push(playback.value(signal));
        }
    }
    Ok(Curves { times, channels, n_left_out })
}

/// Even times, and the last instant before each event beside the event itself.
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
    /// Curves that are kept, and curves of the run.
    pub(crate) fn counts(&self) -> [usize; 2] {
        [self.channels.len(), self.channels.len() + self.n_left_out]
    }

    /// What is left out, in a sentence.
    pub(crate) fn remark(&self) -> Option<String> {
        let [kept, all] = self.counts();
        (kept < all).then(|| {
            format!(
                "The page has {kept} of {all} curves; `bksim plot` and `bksim export` have all."
            )
        })
    }

    /// As the page reads them, in the order of rising time.
    pub(crate) fn write(&self) -> Value {
        let channel = |channel: &Channel| {
            let Channel { name, unit, description, values } = channel;
            let first = values.first().copied().unwrap_or(0.0);
            let is_constant = first.is_finite() && values.iter().all(|&value| value == first);
            let (constant, values) = if is_constant {
                (Some(first), None)
            } else {
                (None, Some(singles(values.iter().copied())))
            };
            json!({
                "name": name, "unit": unit, "description": description,
                "constant": constant, "values": values,
            })
        };
        json!({
            "times": doubles(self.times.iter().copied()),
            "channels": self.channels.iter().map(channel).collect::<Vec<_>>(),
        })
    }
}
