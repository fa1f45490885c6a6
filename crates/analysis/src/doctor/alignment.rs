//! Axes that must be parallel or in line, and how far off they are.

use bksim_model::{JointId, Model};
use nalgebra::Vector3;

use super::pose::Pose;

/// Joints whose axes are parallel or in line as far as can be told.
#[derive(Clone, PartialEq, Debug)]
pub struct Alignment {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Largest angle between two of the axes, rad.
    pub angle: f64,
    /// Of axes in line the largest distance of a joint's point from the axis of another, m; none of axes that
    /// are parallel alone.
    pub distance: Option<f64>,
}

/// Axes at a smaller angle are meant to be parallel, rad.
const NEARLY_PARALLEL: f64 = 0.01;
/// Points nearer to an axis, parts of the longest link, are meant to lie on it.
const NEARLY_IN_LINE: f64 = 1e-3;

/// A joint with a point and the direction of its axis.
type Line = (JointId, Vector3<f64>, Vector3<f64>);
/// The distance of a point from a line.
type OffLine<'f> = &'f dyn Fn(&Line, &Vector3<f64>) -> f64;

/// Groups of the `shared` joints with parallel axes, and among these those in line.
pub(super) fn alignments(model: &Model, pose: &Pose, shared: &[JointId]) -> Vec<Alignment> {
    let lines: Vec<Line> = shared.iter().filter_map(|&joint| axis(model, pose, joint)).collect();
    let between = |a: &Vector3<f64>, b: &Vector3<f64>| a.cross(b).norm().atan2(a.dot(b).abs());
    let off_line = |(_, at, along): &Line, p: &Vector3<f64>| (p - at).cross(along).norm();
    let mut found = Vec::new();
    let mut grouped = vec![false; lines.len()];
    for first in 0..lines.len() {
        if grouped[first] {
            continue;
        }
        let is_like = |k: &usize| between(&lines[first].2, &lines[*k].2) < NEARLY_PARALLEL;
        let group: Vec<usize> =
            (first..lines.len()).filter(|k| !grouped[*k]).filter(is_like).collect();
        for &k in &group {
            grouped[k] = true;
        }
        found.extend(told(model, &lines, &group, &between, None));
        // Of parallel axes those in line.
        let mut in_line = vec![false; group.len()];
        for a in 0..group.len() {
            let near = |b: &usize| {
                off_line(&lines[group[a]], &lines[group[*b]].1) < NEARLY_IN_LINE * pose.size
            };
            let own: Vec<usize> = (a..group.len()).filter(|b| !in_line[*b]).filter(near).collect();
            for &b in &own {
                in_line[b] = true;
            }
            let own: Vec<usize> = own.into_iter().map(|b| group[b]).collect();
            if own.len() < group.len() {
                found.extend(told(model, &lines, &own, &between, Some(&off_line)));
            } else if let Some(last) = found.last_mut() {
                last.distance = farthest(&lines, &own, &off_line);
            }
        }
    }
    found
}

fn farthest(lines: &[Line], group: &[usize], off_line: OffLine<'_>) -> Option<f64> {
    let pairs = group.iter().flat_map(|&a| group.iter().map(move |&b| (a, b)));
    (group.len() > 1)
        .then(|| pairs.map(|(a, b)| off_line(&lines[a], &lines[b].1)).fold(0.0, f64::max))
}

fn told(
    model: &Model,
    lines: &[Line],
    group: &[usize],
    between: &dyn Fn(&Vector3<f64>, &Vector3<f64>) -> f64,
    off_line: Option<OffLine<'_>>,
) -> Option<Alignment> {
    if group.len() < 2 {
        return None;
    }
    let pairs = group.iter().flat_map(|&a| group.iter().map(move |&b| (a, b)));
    let angle = pairs.map(|(a, b)| between(&lines[a].2, &lines[b].2)).fold(0.0, f64::max);
    let name = |&k: &usize| model.joints[lines[k].0.0].name.clone();
    Some(Alignment {
        joints: group.iter().map(name).collect(),
        angle,
        distance: off_line.and_then(|off_line| farthest(lines, group, off_line)),
    })
}

/// The point and the direction of a joint's axis, if it has one.
fn axis(model: &Model, pose: &Pose, joint: JointId) -> Option<Line> {
    let of = &model.joints[joint.0];
    if !of.kind.has_line() {
        return None;
    }
    let [point, along] = pose.axes[joint.0].map(Vector3::from);
    Some((joint, point, along.normalize()))
}
