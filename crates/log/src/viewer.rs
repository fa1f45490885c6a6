//! Channels for programs that know nothing of bksim: messages that Foxglove has published, filled from
//! plain data.
//!
//! | topic | schema | holds |
//! |---|---|---|
//! | `/tf` | `foxglove.FrameTransforms` | where every frame is in the root frame, once per sample |
//! | `/scene` | `foxglove.SceneUpdate` | the entities that are fixed to frames, once, at the start |
//! | `/outlines/crank` … | `foxglove.PointCloud` | points along its lines, a topic per frame, once: Rerun draws no scenes |
//! | `/spans` | `foxglove.SceneUpdate` | the entities that change their shape, once per sample |
//! | `/joint_states` | `foxglove.JointStates` | joints, once per sample |
//!
//! Schemas: <https://docs.foxglove.dev/docs/visualization/message-schemas/introduction>; the
//! crate `foxglove` carries them as they are published.

mod scene;

use std::collections::BTreeMap;
use std::io::Write;

use foxglove::messages::{
    self as published, FrameTransform, FrameTransforms, JointStates, PointCloud, SceneUpdate,
};
use prost::Message as _;

use crate::topics::{JOINT_STATES, OUTLINES, SCENE, SPANS, TRANSFORMS};
use crate::write::{Channel, check_size};
use crate::{LogError, LogWriter};

/// The scene that is shown, written once before the first sample.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Stage {
    /// Name of the frame that rests.
    pub root: String,
    /// Names of the frames that move in it.
    pub frames: Vec<String>,
    /// The entities that are fixed to frames.
    pub entities: Vec<Entity>,
    /// Entities fixed to frames that are among the outlines alone, since spans show them elsewhere.
    pub rods: Vec<Entity>,
    /// True if something is drawn again for every sample.
    pub has_spans: bool,
    /// The joints.
    pub joints: Vec<Joint>,
}

/// Areas and lines in one frame.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Entity {
    /// Name of the entity; a later entity of this name takes its place.
    pub id: String,
    /// Name of its frame.
    pub frame: String,
    /// The areas.
    pub areas: Vec<Area>,
    /// The lines.
    pub lines: Vec<Line>,
}

/// Triangles of one colour.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Area {
    /// Their corners, m.
    pub points: Vec<[f64; 3]>,
    /// Three indices in `points` for each.
    pub triangles: Vec<[u32; 3]>,
    /// Red, green, blue, opacity: 0 to 1.
    pub color: [f64; 4],
}

/// Straight lines through points.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Line {
    /// The points, m.
    pub points: Vec<[f64; 3]>,
    /// True if the last is joined to the first.
    pub is_closed: bool,
    /// Pixels.
    pub width: f64,
    /// Red, green, blue, opacity: 0 to 1.
    pub color: [f64; 4],
}

/// A joint that is shown.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct Joint {
    /// Name of the joint.
    pub name: String,
    /// Unit of its position, rad or m.
    pub unit: String,
}

/// Where a frame is in the root frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Placement {
    /// Of its origin, m.
    pub translation: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
}

impl Default for Placement {
    /// That of the root frame.
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0] }
    }
}

/// The motion of a joint; SI.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct JointState {
    /// rad or m.
    pub position: f64,
    /// rad/s or m/s.
    pub velocity: f64,
    /// rad/s² or m/s².
    pub acceleration: f64,
    /// Of its drive, N·m or N, if it has one.
    pub effort: Option<f64>,
}

/// The state of a scene at a sample.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Moment {
    /// One placement per frame.
    pub frames: Vec<Placement>,
    /// One state per joint.
    pub joints: Vec<JointState>,
    /// The entities that change their shape, in the root frame; none unless the stage says so.
    pub spans: Vec<Entity>,
}

/// The channels of a [`Stage`] in one log.
#[derive(Debug)]
pub struct Viewers {
    tf: Channel,
    joint_states: Channel,
    spans: Option<Channel>,
    /// The messages, kept to allocate their names once.
    transforms: FrameTransforms,
    joints: JointStates,
}

impl<W: Write> LogWriter<W> {
    /// Adds the channels of other programs and writes the scene; to be called before the first sample.
    ///
    /// # Errors
    /// [`LogError::TooLarge`] (nothing was written then), [`LogError::Io`].
    pub fn add_viewers(&mut self, stage: &Stage) -> Result<Viewers, LogError> {
        // Messages, none of which may be too large for a reader.
        let start = self.timestamp(self.t_start());
        let scenes = scene::updates(&stage.entities, start)?;
        let outlines = scene::outlines(stage.entities.iter().chain(&stage.rods), start);
        for cloud in &outlines {
            check_size("an outline", cloud.data.len())?;
        }
        let transforms = transforms(stage);
        check_size("the frames", transforms.encoded_len() + MOVED * transforms.transforms.len())?;
        let joints = joints(stage);
        let names = stage.joints.iter().map(|joint| joint.name.len() + joint.unit.len());
        check_size("the joints", names.sum::<usize>() + (MOVED + 16) * joints.joints.len())?;

        // Channels with the units of their numbers.
        let unit = |name: &str, unit: &str| (format!("{name}.unit"), unit.to_owned());
        let lengths = BTreeMap::from([unit("translation", "m")]);
        let positions = stage.joints.iter().map(|joint| unit(&joint.name, &joint.unit));
        let points = BTreeMap::from([unit("points", "m")]);
        let viewers = Viewers {
            tf: self.add_published::<FrameTransforms>(TRANSFORMS, &lengths)?,
            joint_states: self.add_published::<JointStates>(JOINT_STATES, &positions.collect())?,
            spans: if stage.has_spans {
                Some(self.add_published::<SceneUpdate>(SPANS, &points)?)
            } else {
                None
            },
            transforms,
            joints,
        };
        // All channels come before the first message: readers that stop there know them.
        let mut scene = self.add_published::<SceneUpdate>(SCENE, &points)?;
        let mut clouds = Vec::with_capacity(outlines.len());
        for cloud in outlines {
            let topic = format!("{OUTLINES}{}", cloud.frame_id);
            clouds.push((self.add_published::<PointCloud>(&topic, &points)?, cloud));
        }
        for update in &scenes {
            self.put_published(&mut scene, self.t_start(), update)?;
        }
        for (mut channel, cloud) in clouds {
            self.put_published(&mut channel, self.t_start(), &cloud)?;
        }
        Ok(viewers)
    }

    /// Appends the state of the scene at time `t`, s, which follows the rule of [`LogWriter::write`].
    ///
    /// # Errors
    /// [`LogError::WrongLength`], [`LogError::BadTime`], [`LogError::TooLarge`] (nothing was written
    /// then), [`LogError::Io`].
    pub fn show(&mut self, viewers: &mut Viewers, t: f64, moment: &Moment) -> Result<(), LogError> {
        let Viewers { tf, joint_states, spans, transforms, joints } = viewers;
        check_length(TRANSFORMS, transforms.transforms.len(), moment.frames.len())?;
        check_length(JOINT_STATES, joints.joints.len(), moment.joints.len())?;
        self.advance(t)?;
        let now = Some(self.timestamp(t));
        for (transform, placement) in transforms.transforms.iter_mut().zip(&moment.frames) {
            transform.timestamp = now;
            transform.translation = Some(scene::vector(placement.translation));
            transform.rotation = Some(scene::quaternion(placement.rotation));
        }
        joints.timestamp = now;
        for (joint, state) in joints.joints.iter_mut().zip(&moment.joints) {
            joint.position = Some(state.position);
            joint.velocity = Some(state.velocity);
            joint.acceleration = Some(state.acceleration);
            joint.effort = state.effort;
        }
        let update = spans.as_mut().map(|spans| (spans, scene::update(&moment.spans, now)));
        if let Some((_, update)) = &update {
            check_size("the spans", update.encoded_len())?;
        }

        self.put_published(tf, t, transforms)?;
        self.put_published(joint_states, t, joints)?;
        match update {
            Some((spans, update)) => self.put_published(spans, t, &update),
            None => Ok(()),
        }
    }
}

/// Bytes of a transform's or joint's numbers: seven doubles, a time, tags and lengths.
const MOVED: usize = 128;

fn check_length(topic: &str, expected: usize, given: usize) -> Result<(), LogError> {
    if expected == given {
        return Ok(());
    }
    Err(LogError::WrongLength { topic: topic.into(), expected, given })
}

/// The message of the frames, with their names alone.
fn transforms(stage: &Stage) -> FrameTransforms {
    let transform = |name: &String| FrameTransform {
        parent_frame_id: stage.root.clone(),
        child_frame_id: name.clone(),
        ..FrameTransform::default()
    };
    FrameTransforms { transforms: stage.frames.iter().map(transform).collect() }
}

/// The message of the joints, with their names alone.
fn joints(stage: &Stage) -> JointStates {
    let joint = |joint: &Joint| published::JointState {
        name: joint.name.clone(),
        ..published::JointState::default()
    };
    JointStates { timestamp: None, joints: stage.joints.iter().map(joint).collect() }
}
