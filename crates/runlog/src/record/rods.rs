//! Massless links as frames of their own: programs that draw no scenes show them by the outlines of frames.

use bksim_log::{Entity, Placement};
use bksim_scene::{Role, Scene};
use bksim_sim::Mechanism;

use super::stage;

/// A link that keeps its length.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Rod {
    /// Place among the spans of the scene.
    pub(super) span_idx: usize,
    /// m.
    length: f64,
}

/// The massless links of a scene whose length does not change.
pub(super) fn rods(mechanism: &Mechanism, scene: &Scene) -> Vec<Rod> {
    let model = &mechanism.model;
    let symbols = model.parameters.iter().map(|parameter| parameter.symbol);
    let values: Vec<_> = symbols.zip(mechanism.parameters.iter().copied()).collect();
    let known = |symbol| values.iter().find(|(known, _)| *known == symbol).map(|(_, value)| *value);
    let rod = |(span_idx, span): (usize, &bksim_scene::Span)| {
        let joint = model.joints.iter().find(|joint| joint.name == span.name)?;
        let length = joint.kind.link_length()?;
        // A length that follows time has no value here.
        let length =
            model.pool.evaluate(length, &known).ok().filter(|length| length.is_finite())?;
        Some(Rod { span_idx, length })
    };
    scene.spans.iter().enumerate().filter_map(rod).collect()
}

/// The line of a link along x of its frame.
pub(super) fn entity(rod: &Rod, scene: &Scene) -> Entity {
    let name = scene.spans[rod.span_idx].name.clone();
    let points = vec![[0.0; 3], [rod.length, 0.0, 0.0]];
    let lines = stage::line(Role::Link, points, false).into_iter().collect();
    Entity { id: name.clone(), frame: name, areas: Vec::new(), lines }
}

/// The frame of a link between two points: its origin is the first, its x points to the second; about x it turns as
/// little as it can. `previous` decides the sign of the quaternion, as for bodies.
pub(super) fn placement([from, to]: [[f64; 3]; 2], previous: &Placement) -> Placement {
    let d: [f64; 3] = std::array::from_fn(|i| to[i] - from[i]);
    let length = d[0].hypot(d[1]).hypot(d[2]);
    // The half-way between x and d, times 2 |d|: (x × d, |d| + d_x) is the quaternion from x to d.
    let q = [0.0, -d[2], d[1], length + d[0]];
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Opposite to x any half turn will do; ends that coincide have no direction.
    let q = if norm > 1e-12 * length { q.map(|x| x / norm) } else { [0.0, 0.0, 1.0, 0.0] };
    let q = if length > 0.0 { q } else { previous.rotation };
    let along: f64 = q.iter().zip(previous.rotation).map(|(a, b)| a * b).sum();
    let rotation = if along < 0.0 { q.map(|x| -x) } else { q };
    Placement { translation: from, rotation }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The axis x turned by a quaternion.
    fn turned([x, y, z, w]: [f64; 4]) -> [f64; 3] {
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)]
    }

    #[test]
    fn the_frame_of_a_link_points_along_it_and_does_not_jump() {
        let mut previous = Placement::default();
        for step in 0..=720 {
            let (angle, tilt) = (0.01 * f64::from(step), 0.3 * (0.02 * f64::from(step)).sin());
            let along = [angle.cos() * tilt.cos(), angle.sin() * tilt.cos(), tilt.sin()];
            let from = [0.5, -1.0, 2.0];
            let to = std::array::from_fn(|i| from[i] + 1.5 * along[i]);
            let found = placement([from, to], &previous);
            let x = turned(found.rotation);
            let worst = (0..3).map(|i| (x[i] - along[i]).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-12, "step {step}: {x:?} is not {along:?}");
            let dot: f64 = found.rotation.iter().zip(previous.rotation).map(|(a, b)| a * b).sum();
            assert!(dot >= 0.0);
            previous = found;
        }
        let back = placement([[0.0; 3], [-2.0, 0.0, 0.0]], &Placement::default());
        assert_eq!(turned(back.rotation), [-1.0, 0.0, 0.0]);
    }
}
