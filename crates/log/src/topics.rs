//! Names of the topics that this crate fills itself; no topic of samples may have one of them.

/// Topic of the [`Note`](crate::Note)s; every log has it, and no [`Topic`](crate::Topic) may take its
/// name.
pub const LOG_TOPIC: &str = "/log";

/// Topic of the [`Segment`](crate::Segment)s; every log has it, and no [`Topic`](crate::Topic) may take
/// its name.
pub const MOTION_TOPIC: &str = "/motion";

/// Topic of the transforms, for other programs.
pub(crate) const TRANSFORMS: &str = "/tf";
/// Topic of the scene, for other programs.
pub(crate) const SCENE: &str = "/scene";
/// Topic of the entities that change their shape, for other programs.
pub(crate) const SPANS: &str = "/spans";
/// Topic of the joints, for other programs.
pub(crate) const JOINT_STATES: &str = "/joint_states";
/// Topics of the points of frames begin so, for other programs.
pub(crate) const OUTLINES: &str = "/outlines/";

/// True if no topic of samples may have this name.
pub(crate) fn is_reserved(topic_name: &str) -> bool {
    [LOG_TOPIC, MOTION_TOPIC, TRANSFORMS, SCENE, SPANS, JOINT_STATES].contains(&topic_name)
        || topic_name.starts_with(OUTLINES)
}
