//! [`Channel`]: the motions that are prescribed and the actuators that have efforts, as drives of a model.

use bksim_model::{Drive as ModelDrive, Measure, Model};

use crate::PoseQuantity;
use crate::drive::{is_position, unknown_measure};
use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::motion::{Motion, driven};

/// A motion that is prescribed, an actuator, or both.
pub(crate) struct Channel {
    /// Of the joint or drive.
    pub(crate) name: String,
    pub(crate) measure: Measure,
    pub(crate) is_prescribed: bool,
    /// Number of its drive in the model of the forces.
    pub(crate) drive_idx: Option<usize>,
}

/// The motions and actuators: own drives, motions in whose place they stand, then joints that act besides.
pub(crate) fn channels(
    model: &mut Model,
    motions: &[Motion],
    named: &[String],
) -> Result<Vec<Channel>, AnalysisError> {
    let measure_of = |drive: &ModelDrive| Measure::JointPosition(drive.joint, drive.motion_idx);
    // A drive that is there already goes.
    model.drives.retain(|drive| !motions.iter().any(|m| m.measure == measure_of(drive)));
    let own = model.drives.iter().map(|drive| (drive.name.clone(), measure_of(drive)));
    // Of a joint with several motions each has a name of its own.
    let joint_name = |m: &Motion| match m.measure {
        Measure::JointPosition(joint, _) if model.joints[joint.0].kind.motions().len() == 1 => {
            model.joints[joint.0].name.clone()
        }
        _ => m.name.clone(),
    };
    let given = motions.iter().map(|m| (joint_name(m), m.measure));
    let prescribed = own.chain(given).map(|(name, measure)| Channel {
        name,
        measure,
        is_prescribed: true,
        drive_idx: None,
    });
    let mut channels: Vec<Channel> = prescribed.collect();
    let is_joint = |measure: Measure| matches!(measure, Measure::JointPosition(..));
    // Numbers of drives are given when these are there.
    if named.is_empty() {
        for channel in channels.iter_mut().filter(|c| is_joint(c.measure)) {
            channel.drive_idx = Some(0);
        }
    }
    for name in named {
        if let Some(channel) = channels.iter_mut().find(|c| c.name == *name && is_joint(c.measure))
        {
            channel.drive_idx = Some(0);
            continue;
        }
        let name = name.strip_prefix("drives.").unwrap_or(name);
        let measure = [format!("{name}.angle"), format!("{name}.position"), name.to_owned()];
        let measure = measure.iter().find_map(|name| driven(model, name).ok());
        let unknown = || unknown_measure(model, name, is_position);
        if measure.is_none() && is_given(model, name) {
            return Err(AnalysisError::GivenEffort { name: name.to_owned() });
        }
        let measure = measure.filter(|&m| is_joint(m)).ok_or_else(unknown)?;
        match channels.iter_mut().find(|c| c.measure == measure) {
            Some(channel) => channel.drive_idx = Some(0),
            None => channels.push(Channel {
                name: name.to_owned(),
                measure,
                is_prescribed: false,
                drive_idx: Some(0),
            }),
        }
    }
    Ok(channels)
}

/// True of what has its value from the model, so that no motion determines it: loads, signals and states.
fn is_given(model: &Model, name: &str) -> bool {
    model.loads.iter().any(|load| load.name == name)
        || model.states.iter().any(|state| state.name == name)
        || model.held.iter().any(|signal| signal.name == name)
        || model.named_signals.iter().any(|signal| signal.name == name)
}

/// Gives the model of the forces a drive for each actuator, and no others.
pub(crate) fn act(model: &mut Model, channels: &mut [Channel]) {
    model.drives.clear();
    for channel in channels.iter_mut().filter(|c| c.drive_idx.is_some()) {
        let Measure::JointPosition(joint, motion_idx) = channel.measure else { continue };
        channel.drive_idx = Some(model.drives.len());
        let (span, name) = (model.joints[joint.0].span.clone(), channel.name.clone());
        // The position does not matter to the forces.
        let motion = model.pool.zero();
        model.drives.push(ModelDrive { name, joint, motion_idx, motion, span });
    }
}

/// The position of each channel.
pub(crate) fn quantities(loaded: &Loaded, channels: &[Channel]) -> Vec<PoseQuantity> {
    let model = loaded.model();
    let quantity = |channel: &Channel| PoseQuantity {
        names: [channel.name.clone(), String::new(), String::new()],
        unit: channel.measure.fixed_unit(model),
        value: loaded.system().kinematics.measure(model, channel.measure),
    };
    channels.iter().map(quantity).collect()
}
