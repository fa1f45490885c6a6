//! The channels of viewers: poses of the bodies, motions of the joints, moving shapes.

use std::io::Write;

use bksim_log::{
    Entity, Joint, JointState, LogError, LogWriter, Moment, Placement, Stage, Viewers,
};
use bksim_mbs::coordinate::{CoordinateKind, Owner};
use bksim_scene::{Scene, Stretched};
use bksim_sim::pose::{Pose, PoseRunner, Poses};

use super::rods::{self, Rod};
use super::stage;
use crate::channels::TopicKind;
use bksim_sim::Mechanism;

/// Points of spans are written to at least this part of a pin's radius.
const PARTS_OF_A_PIN: f64 = 256.0;

/// Where springs and dampers are seen best from, there being no camera: they lie in planes that hold
/// a horizontal line.
const ABOVE: [f64; 3] = [0.0, 0.0, 1.0];

/// Fills the channels of other programs from those of a sample.
#[derive(Debug)]
pub(super) struct Shown {
    viewers: Viewers,
    poses: PoseRunner,
    scene: Scene,
    /// Massless links, whose frames follow those of the bodies.
    rods: Vec<Rod>,
    root: String,
    /// For each coordinate the index of its drive, if it has one.
    drives: Vec<Option<usize>>,
    /// Number of coordinates that are joints; integrals of states follow.
    n_joints: usize,
    /// The values of three topics.
    state: Vec<f64>,
    accelerations: Vec<f64>,
    efforts: Vec<f64>,
    at: Vec<Pose>,
    moment: Moment,
}

impl Shown {
    /// Adds the channels to a log. `None` when the mechanism is so large that its scene does
    /// not fit in messages that readers take: then the log does without.
    pub(super) fn add<W: Write>(
        writer: &mut LogWriter<W>,
        mechanism: &Mechanism,
    ) -> Result<Option<Self>, LogError> {
        // What the equations could not be compiled with is refused long before.
        let Ok(poses) = Poses::compile(&mechanism.model, &mechanism.system) else {
            return Ok(None);
        };
        let scene = Scene::of(&mechanism.model, &mechanism.parameters);
        let rods = rods::rods(mechanism, &scene);
        let stage = stage(mechanism, &scene, &rods);
        let viewers = match writer.add_viewers(&stage) {
            Ok(viewers) => viewers,
            Err(LogError::TooLarge { .. }) => return Ok(None),
            Err(error) => return Err(error),
        };
        Ok(Some(Self {
            viewers,
            poses: poses.runner(&mechanism.parameters),
            drives: drives(mechanism),
            n_joints: stage.joints.len(),
            scene,
            rods,
            root: stage.root,
            state: Vec::new(),
            accelerations: Vec::new(),
            efforts: Vec::new(),
            at: Vec::new(),
            moment: Moment::default(),
        }))
    }

    /// Takes note of the values of a topic.
    pub(super) fn learn(&mut self, of: TopicKind, values: &[f64]) {
        let known = match of {
            TopicKind::State => &mut self.state,
            TopicKind::Acceleration => &mut self.accelerations,
            TopicKind::Drives => &mut self.efforts,
            _ => return,
        };
        known.clear();
        known.extend_from_slice(values);
    }

    /// Writes what follows from the topics of the sample at time `t`.
    pub(super) fn write<W: Write>(
        &mut self,
        writer: &mut LogWriter<W>,
        t: f64,
    ) -> Result<(), LogError> {
        let (q, v) = self.state.split_at(self.drives.len());
        self.poses.at(q, v, &mut self.at);
        let Self { moment, at, .. } = self;
        // The ground is the root itself.
        let n_bodies = at.len().saturating_sub(1);
        moment.frames.resize(n_bodies + self.rods.len(), Placement::default());
        for (placement, pose) in moment.frames.iter_mut().zip(&at[1..]) {
            let rotation = quaternion(&pose.r_world_from_body, placement.rotation);
            *placement = Placement { translation: pose.origin, rotation };
        }
        for (placement, rod) in moment.frames[n_bodies..].iter_mut().zip(&self.rods) {
            let ends = self.scene.spans[rod.span_idx].ends;
            let ends = ends.map(|end| at[end.body].place(end.position));
            *placement = rods::placement(ends, placement);
        }
        moment.joints.clear();
        let drives = self.drives.iter().take(self.n_joints).enumerate();
        moment.joints.extend(drives.map(|(i, drive)| JointState {
            position: q[i],
            velocity: v[i],
            acceleration: self.accelerations[i],
            effort: drive.and_then(|idx| self.efforts.get(idx).copied()),
        }));
        moment.spans.clear();
        let (scene, root) = (&self.scene, &self.root);
        moment
            .spans
            .extend(scene.stretched(at, ABOVE).into_iter().map(|it| entity(scene, root, it)));
        writer.show(&mut self.viewers, t, moment)
    }
}

/// The frames, joints and shapes of a mechanism.
fn stage(mechanism: &Mechanism, scene: &Scene, rods: &[Rod]) -> Stage {
    let mut frames = mechanism.model.bodies.iter().map(|body| body.name.clone());
    let root = frames.next().unwrap_or_default();
    let joint = |coordinate: &bksim_mbs::coordinate::Coordinate| Joint {
        name: coordinate.name.clone(),
        unit: coordinate.kind.unit().into(),
    };
    let coordinates = mechanism.system.coordinates().iter();
    let rods: Vec<Entity> = rods.iter().map(|rod| rods::entity(rod, scene)).collect();
    Stage {
        root,
        frames: frames.chain(rods.iter().map(|rod| rod.frame.clone())).collect(),
        entities: stage::entities(scene),
        rods,
        has_spans: !(scene.spans.is_empty() && scene.cords.is_empty()),
        joints: coordinates.filter(|c| c.kind != CoordinateKind::Integral).map(joint).collect(),
    }
}

/// For each coordinate the index of its drive among the drives.
fn drives(mechanism: &Mechanism) -> Vec<Option<usize>> {
    let drive_of = |owner: Owner| match owner {
        Owner::Joint(joint, motion_idx) => {
            let mut drives = mechanism.model.drives.iter();
            drives.position(|drive| drive.joint == joint && drive.motion_idx == motion_idx)
        }
        Owner::Body(..) | Owner::Quaternion(..) | Owner::State(_) => None,
    };
    mechanism.system.coordinates().iter().map(|c| drive_of(c.owner)).collect()
}

/// A span or rope where its bodies are.
fn entity(scene: &Scene, root: &str, stretched: Stretched<'_>) -> Entity {
    let mut lines: Vec<_> = stretched
        .lines
        .into_iter()
        .filter_map(|(role, points)| stage::line(role, points, false))
        .collect();
    // Written again for every sample: numbers of few digits take less room, and nobody sees it.
    let grid = (scene.pin / PARTS_OF_A_PIN).log2().floor().exp2();
    if grid > 0.0 {
        let numbers = lines.iter_mut().flat_map(|line| line.points.as_flattened_mut());
        for x in numbers {
            *x = (*x / grid).round() * grid;
        }
    }
    let (id, frame) = (stretched.name.to_owned(), root.to_owned());
    Entity { id, frame, areas: Vec::new(), lines }
}

/// The unit quaternion x, y, z, w of a rotation matrix given by its rows, with the sign that is
/// nearer to `previous`: ±q are one rotation, and what interpolates must not take the long way.
///
/// Source: Shepperd, "Quaternion from Rotation Matrix", J. Guidance and Control 1 (1978) 223: the
/// component that is largest is taken from the diagonal, so that no small number divides.
fn quaternion(r: &[[f64; 3]; 3], previous: [f64; 4]) -> [f64; 4] {
    let trace = r[0][0] + r[1][1] + r[2][2];
    // 4 times the square of each component, less one.
    let squares = [2.0 * r[0][0] - trace, 2.0 * r[1][1] - trace, 2.0 * r[2][2] - trace, trace];
    let largest = (1..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
    let q = match largest {
        0 => [1.0 + squares[0], r[1][0] + r[0][1], r[0][2] + r[2][0], r[2][1] - r[1][2]],
        1 => [r[1][0] + r[0][1], 1.0 + squares[1], r[2][1] + r[1][2], r[0][2] - r[2][0]],
        2 => [r[0][2] + r[2][0], r[2][1] + r[1][2], 1.0 + squares[2], r[1][0] - r[0][1]],
        _ => [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1], 1.0 + squares[3]],
    };
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let along = q.iter().zip(previous).map(|(a, b)| a * b).sum::<f64>();
    let scale = if along < 0.0 { -norm } else { norm };
    q.map(|x| x / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotation matrix of a unit quaternion.
    fn matrix([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    #[test]
    fn a_quaternion_is_its_matrix_and_does_not_jump() {
        let mut previous = Placement::default().rotation;
        for step in 0..2000 {
            // Round an axis that itself goes round, through every half turn.
            let (half, tilt) = (0.01 * f64::from(step), 0.003 * f64::from(step));
            let axis = [tilt.sin() * half.cos(), tilt.cos(), tilt.sin() * half.sin()];
            let [x, y, z] = axis.map(|part| part * half.sin());
            let expected = [x, y, z, half.cos()];
            let found = quaternion(&matrix(expected), previous);
            let worst = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-14, "step {step}: {found:?} is not {expected:?}");
            previous = found;
        }
    }
}
