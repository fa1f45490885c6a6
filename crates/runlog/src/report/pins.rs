//! The sheet of the largest pin forces: by joint the force with its direction, instant and pose.

use std::fmt::Write;

use bksim_model::file::{ShownUnit, ShownUnits};

use super::Report;

/// The reaction of a joint on its second body at the instant of its largest force.
#[derive(Clone, PartialEq, Debug)]
pub struct PinForce {
    /// fx, fy, fz, mx, my, mz along the axes of the ground, N and N m.
    pub reaction: [f64; 6],
    /// Positions of all joints there, of driven ones first: name, value, unit.
    pub pose: Vec<(String, f64, &'static str)>,
}

impl PinForce {
    /// The angle of the force in the x-y plane from x, rad, or `None` where it has another component or is zero.
    pub fn direction(&self) -> Option<f64> {
        let [fx, fy, fz, ..] = self.reaction;
        let size = fx.hypot(fy);
        (size > 0.0 && fz.abs() <= 1e-9 * size).then(|| fy.atan2(fx))
    }
}

/// The largest pin forces as comma-separated values: a row for each joint, its heading with the units.
pub fn pin_sheet(report: &Report, units: &ShownUnits) -> String {
    let [force, moment, time] = ["N", "N*m", "s"].map(|si| units.of(si));
    let angle = angle_unit(units);
    let heading = |name: &str, unit: &ShownUnit| format!("{name} [{}]", unit.unit);
    let mut heads = vec!["joint".to_owned(), heading("force", &force)];
    heads.extend(["fx", "fy", "fz"].map(|name| heading(name, &force)));
    heads.extend(["mx", "my", "mz"].map(|name| heading(name, &moment)));
    heads.extend([heading("direction", &angle), heading("t", &time)]);
    let of_pose = |unit: &str| if unit == "rad" { angle.clone() } else { units.of(unit) };
    if let Some(first) = report.reactions.first() {
        heads
            .extend(first.largest.pose.iter().map(|(name, _, unit)| heading(name, &of_pose(unit))));
    }
    let mut text = heads.join(",") + "\n";
    // What is far below the largest force is rounding.
    let largest = report.reactions.iter().map(|joint| joint.force.value).fold(0.0, f64::max);
    let floored = |x: f64| if x.abs() < 1e-11 * largest { 0.0 } else { x };
    for joint in &report.reactions {
        let direction = joint.largest.direction();
        let reaction = joint.largest.reaction.iter().enumerate();
        let unit = |k: usize| if k < 3 { &force } else { &moment };
        let reaction = reaction.map(|(k, &x)| unit(k).of_si(floored(x)));
        let pose = joint.largest.pose.iter().map(|(_, x, unit)| of_pose(unit).of_si(*x));
        let mut row = vec![joint.name.clone(), force.of_si(joint.force.value).to_string()];
        row.extend(reaction.map(|x| x.to_string()));
        row.push(direction.map_or_else(String::new, |x| angle.of_si(x).to_string()));
        row.push(time.of_si(joint.force.t).to_string());
        row.extend(pose.map(|x| x.to_string()));
        // Writing to a text does not fail.
        let _ = writeln!(text, "{}", row.join(","));
    }
    text
}

/// The unit of angles: degrees where none is asked for.
pub(super) fn angle_unit(units: &ShownUnits) -> ShownUnit {
    let own = units.of("rad");
    let degrees = || ShownUnit::parse("deg").unwrap_or_else(|| units.of("rad"));
    if own.unit == "rad" { degrees() } else { own }
}
