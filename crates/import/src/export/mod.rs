//! Models as robot files of other programs: URDF, MJCF, SDF.
//!
//! ```text
//! Model, poses of its start → Robot (links, a tree of joints, joints that close loops, numbers alone) → text
//!                             robot, tree, loads                                        urdf, mjcf, sdf
//! ```
//!
//! A model becomes numbers at its values of parameters. Bodies of a mechanism without loops are written where all
//! joints are at zero, as robot files have them; with loops where the start closes them.

mod loads;
mod mjcf;
mod numbers;
mod parts;
mod robot;
mod sdf;
mod tree;
mod urdf;

use std::fmt::Write as _;

use bksim_model::Model;
use bksim_model::diagnostic::{Diagnostic, Rejected, Span};
use bksim_sim::Mechanism;
use bksim_sim::pose::Poses;

use crate::Format;
use crate::draft::number;
use crate::spatial::{Pose, Rotation, Vector};
use parts::Robot;

/// A model in another format.
#[derive(Clone, PartialEq, Debug)]
pub struct Exported {
    /// Text of the file.
    pub text: String,
    /// Warnings, by places of the model.
    pub faults: Vec<Diagnostic>,
    /// Parts of the model that the file does not have, in a few words each, with their places.
    pub left_out: Vec<(String, Span)>,
    /// Number of bodies that the file has.
    pub n_bodies: usize,
    /// Number of joints that the file has, loops among them.
    pub n_joints: usize,
}

/// Writes a model in a format; `line` gives the place of a span in the model, such as `arm.toml:12`.
///
/// # Errors
/// [`Rejected`] where loops do not close, where a joint that carries a body is not one of the format, and for a format
/// that is only read.
pub fn export(
    model: Model,
    format: Format,
    line: &dyn Fn(&Span) -> String,
) -> Result<Exported, Rejected> {
    if !matches!(format, Format::Urdf | Format::Mjcf | Format::Sdf) {
        let message = format!("{} is a format that is only read", format.name());
        let fault = Diagnostic::error(crate::codes::NOT_HELD, message);
        return Err(Rejected(vec![fault.help("write URDF, MJCF or SDF")]));
    }
    let mechanism = Mechanism::positions(model)?;
    let start = poses_at_start(&mechanism)?;
    let (robot, mut report) = Robot::of(&mechanism.model, format, &start)?;
    let body = match format {
        Format::Urdf => urdf::text(&robot, &mut report),
        Format::Mjcf => mjcf::text(&robot, &mut report),
        _ => sdf::text(&robot, &mut report),
    };
    let mut text = String::from("<?xml version=\"1.0\"?>\n<!--\n");
    let mut heading = |line: &str| {
        let _ = writeln!(text, "  {}", line.replace("--", "- -"));
    };
    heading(&format!("The mechanism {} in {}, by bksim.", robot.name, format.name()));
    heading("Metres, kilograms, seconds and radians.");
    robot.notes.iter().for_each(|note| heading(note));
    if !report.left_out.is_empty() {
        heading("In the model, and not in this file:");
        for (what, span) in &report.left_out {
            heading(&format!("- {what} ({})", line(span)));
        }
    }
    text.push_str("-->\n");
    text.push_str(&body);
    Ok(Exported {
        text,
        faults: report.faults,
        left_out: report.left_out,
        n_bodies: robot.links.len() - 1,
        n_joints: robot.connections.len(),
    })
}

/// Poses of all bodies where the loops of the start are closed.
fn poses_at_start(mechanism: &Mechanism) -> Result<Vec<Pose>, Rejected> {
    let q = if mechanism.compiled.nq() == 0 { Vec::new() } else { mechanism.closed()?.q };
    let v = vec![0.0; q.len()];
    let poses = Poses::compile(&mechanism.model, &mechanism.system).map_err(|error| {
        let message = format!("the poses of the bodies have no values: {error}");
        Rejected(vec![Diagnostic::error(crate::codes::NOT_HELD, message)])
    })?;
    Ok(seen(&poses.at(&mechanism.parameters, [(&q[..], &v[..])])[0]))
}

fn seen(poses: &[bksim_sim::pose::Pose]) -> Vec<Pose> {
    let columns = |rows: &[[f64; 3]; 3]| {
        std::array::from_fn(|column| std::array::from_fn(|row| rows[row][column]))
    };
    let of = |pose: &bksim_sim::pose::Pose| Pose {
        at: pose.origin,
        turn: Rotation::of_axes(columns(&pose.r_world_from_body)),
    };
    poses.iter().map(of).collect()
}

/// Text of XML with one element a line.
#[derive(Default)]
struct Xml {
    text: String,
    depth: usize,
}

impl Xml {
    /// An element without children: its name with attributes.
    fn leaf(&mut self, element: &str) {
        let _ = writeln!(self.text, "{:1$}<{element}/>", "", 2 * self.depth);
    }

    /// An element around a text.
    fn text(&mut self, element: &str, text: &str) {
        let name = element.split(' ').next().unwrap_or(element);
        let _ = writeln!(self.text, "{:1$}<{element}>{text}</{name}>", "", 2 * self.depth);
    }

    fn open(&mut self, element: &str) {
        let _ = writeln!(self.text, "{:1$}<{element}>", "", 2 * self.depth);
        self.depth += 1;
    }

    fn close(&mut self, name: &str) {
        self.depth = self.depth.saturating_sub(1);
        let _ = writeln!(self.text, "{:1$}</{name}>", "", 2 * self.depth);
    }
}

/// Numbers with blanks between them; those that are rounding of the largest are zero.
fn numbers(values: &[f64]) -> String {
    let largest = values.iter().fold(0.0_f64, |max, value| max.max(value.abs()));
    let clean = |value: &f64| if value.abs() < 1e-14 * largest { 0.0 } else { *value };
    values.iter().map(|value| number(clean(value))).collect::<Vec<_>>().join(" ")
}

/// Roll, pitch and yaw of Rz(yaw) Ry(pitch) Rx(roll). Yaw comes off first, so that the others keep their digits where
/// pitch is a right angle.
fn rpy(turn: Rotation) -> Vector {
    let [x, ..] = turn.axes();
    let yaw = if x[0].hypot(x[1]) < 1e-12 { 0.0 } else { x[1].atan2(x[0]) };
    let [x, y, z] = Rotation::about([0.0, 0.0, 1.0], -yaw).then(turn).axes();
    [(-z[1]).atan2(y[1]), (-x[2]).atan2(x[0]), yaw]
}

/// An attribute's or element's text with the signs of XML replaced.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rpy_gives_back_its_rotation_also_at_right_angles() {
        for pitch in [0.3, 1.5, std::f64::consts::FRAC_PI_2, -std::f64::consts::FRAC_PI_2] {
            let turn = Rotation::of_rpy([0.4, pitch, -2.0]);
            let back = Rotation::of_rpy(rpy(turn));
            let same: f64 = turn.0.iter().zip(back.0).map(|(a, b)| a * b).sum();
            assert!((same.abs() - 1.0).abs() < 1e-14, "{pitch}: {same}");
            assert!(turn.then(back.inverse()).0[1..].iter().all(|c| c.abs() < 1e-14), "{pitch}");
        }
    }
}
