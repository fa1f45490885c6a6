//! The scene for the page: shapes with their paint in both themes.

use bksim::overlay;
use bksim::playback::Playback;
use bksim::sim::redundancy::Uniqueness;
use bksim_scene::{Attached, Scene, TurnTimes};
use serde_json::Value;

use crate::curves::shared_spans;
use crate::error::PageError;
use crate::solids;

/// Number of instants at which the lengths of spans are measured.
const N_INSTANTS: u32 = 200;

/// Number of instants at which torques are examined for their signs.
const N_TORQUES: u32 = 1000;

/// Number of instants from which the lengths of guides and slots come.
const N_POSES: usize = 100;

/// The scene of a run as JSON, with solids in at most `budget` bytes, and a remark on what they left out.
pub(crate) fn write(
    playback: &mut Playback,
    budget: usize,
    curves: &[String],
) -> Result<(Value, Option<String>), PageError> {
    let motion = playback.poses_over_run(N_POSES);
    let mechanism = playback.mechanism();
    let mut scene = Scene::of_motion(&mechanism.model, &mechanism.parameters, &motion);
    let read = || playback.log().model_with(&mechanism.parameters);
    overlay::lay_over(&mut scene, &overlay::overlays(&read, curves)?);
    let lengths = lengths(playback, &scene)?;
    let turned = turned(playback, &scene)?;

    let (solids, remark) = solids::take(&scene, budget);
    let solids: Vec<_> = solids
        .iter()
        .map(|solid| solid.as_ref().map(|s| (s.corners.as_slice(), s.faces.as_slice())))
        .collect();
    let span = playback.span();
    let uniqueness = playback.uniqueness();
    let shared = |joint_idx: usize| {
        let is_unique =
            |uniqueness: &Uniqueness| uniqueness.reactions[joint_idx][..3].iter().all(|&it| it);
        let changes: Vec<(f64, bool)> =
            uniqueness.iter().map(|change| (change.t, is_unique(&change.uniqueness))).collect();
        shared_spans(&changes, span)
    };
    let written = scene.written(&solids, &lengths, &turned, &shared);
    Ok((written, remark))
}

/// When the signs of torques turn over.
fn turned(playback: &mut Playback, scene: &Scene) -> Result<Vec<TurnTimes>, PageError> {
    let Some(mut torques) = scene.torques(playback.mechanism()).ok().flatten() else {
        return Ok(Vec::new());
    };
    let [first, last] = playback.span();
    let mut instants = Vec::new();
    for k in 0..=N_TORQUES {
        let sample = playback.seek(first + (last - first) * f64::from(k) / f64::from(N_TORQUES))?;
        let at = torques.at((sample.t, &sample.q, &sample.v), &sample.lambda);
        instants.push((sample.t, at.to_vec()));
    }
    Ok(scene.turn_times(&instants))
}

/// Shortest and longest distance of the ends of every span.
fn lengths(playback: &mut Playback, scene: &Scene) -> Result<Vec<[f64; 2]>, PageError> {
    let mut lengths = vec![[f64::INFINITY, 0.0]; scene.spans.len()];
    if lengths.is_empty() {
        return Ok(lengths);
    }
    let [first, last] = playback.span();
    for k in 0..=N_INSTANTS {
        playback.seek(first + (last - first) * f64::from(k) / f64::from(N_INSTANTS))?;
        let poses = playback.poses();
        let position = |at: &Attached| poses[at.body].place(at.position);
        for (range, span) in lengths.iter_mut().zip(&scene.spans) {
            let [a, b] = span.ends.each_ref().map(position);
            let length = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
            *range = [range[0].min(length), range[1].max(length)];
        }
    }
    Ok(lengths)
}
