//! Names, units and positions of parts of a model, as faults say them.

use bksim_model::{Drive, JointId, Measure, Model};

/// Where the drive puts its joint at time `t`, such as "1.0472 rad (60°)"; `write` gives the digits.
pub(super) fn drive_position(
    model: &Model,
    drive: &Drive,
    t: f64,
    write: fn(f64) -> String,
) -> String {
    position_of(model, drive, drive_value(model, drive, t), write)
}

/// A position of the joint of a drive in words.
pub(super) fn position_of(
    model: &Model,
    drive: &Drive,
    position: f64,
    write: fn(f64) -> String,
) -> String {
    match unit_of(model, Measure::JointPosition(drive.joint, drive.motion_idx)) {
        "rad" => format!("{} rad ({}°)", write(position), write(position.to_degrees())),
        unit => format!("{} {unit}", write(position)),
    }
}

/// Where the drive puts its joint at time `t`, rad or m.
pub(super) fn drive_value(model: &Model, drive: &Drive, t: f64) -> f64 {
    let value = |symbol| {
        let parameter = model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
        parameter.or_else(|| (symbol == model.time).then_some(t))
    };
    model.pool.evaluate(drive.motion, &value).unwrap_or(f64::NAN)
}

pub(super) fn bodies_of<'a>(model: &'a Model, around: &[JointId]) -> Vec<&'a str> {
    let mut names = Vec::new();
    for &joint in around {
        for anchor in [model.joints[joint.0].predecessor, model.joints[joint.0].successor] {
            let name = model.bodies[anchor.body.0].name.as_str();
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

/// The SI unit of a measure.
pub fn unit_of(model: &Model, measure: Measure) -> &str {
    measure.unit(model)
}

pub(super) fn name(model: &Model, joint: JointId) -> &str {
    &model.joints[joint.0].name
}
