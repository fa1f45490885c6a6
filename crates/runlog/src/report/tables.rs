//! The numbers of a report in tables, in the reader's units.

use bksim_model::file::{ShownUnit, ShownUnits};

use super::number::number;
use super::pins::angle_unit;
use super::{Extreme, Report};

/// A row of a table under its heading.
pub type Row = Vec<String>;

/// The words for values in units.
struct Writing<'u> {
    units: &'u ShownUnits,
    time: ShownUnit,
    /// The largest sizes of forces and of moments and energies, N and J.
    scales: [f64; 2],
    /// Of the run, s.
    duration: f64,
}

/// Part of the run below which an instant is that of the start.
const RESOLUTION: f64 = 1e-8;

/// Part of the largest value of a kind below which another one is rounding.
const ROUNDING: f64 = 1e-11;

/// The size that rounding leaves of a quantity that is zero throughout, such as a force where nothing has a mass; SI.
const NOTHING: f64 = 1e-18;

/// A value, or zero where it is rounding next to a scale.
fn above(value: f64, scale: f64) -> f64 {
    if value.abs() < (ROUNDING * scale).max(NOTHING) { 0.0 } else { value }
}

/// The largest sizes of forces and of moments and energies in a report: what is far below is rounding of them.
fn scales(report: &Report) -> [f64; 2] {
    let of_drives = |unit: &str| {
        let own = report.drives.iter().filter(move |drive| drive.unit == unit);
        own.map(|drive| drive.peak.value).collect::<Vec<_>>()
    };
    let forces = report.reactions.iter().map(|reaction| reaction.force.value);
    let moments = report.reactions.iter().map(|reaction| reaction.moment.value);
    let energy = &report.energy;
    let [least, most] = energy.potential.map(|extreme| extreme.value);
    let energies = [energy.kinetic.value, least, most, energy.work];
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(0.0, |largest: f64, value| largest.max(value.abs()))
    };
    [
        largest(&mut forces.chain(of_drives("N"))),
        largest(&mut moments.chain(of_drives("N*m")).chain(energies)),
    ]
}

impl Writing<'_> {
    /// A value with its unit.
    fn value(&self, value: f64, si: &str) -> String {
        let unit = self.units.of(si);
        let value = self.floored(value, si);
        format!("{} {}", number(unit.of_si(value)), unit.unit).trim_end().to_owned()
    }

    /// A value, or zero where it is rounding of the largest one of its kind.
    fn floored(&self, value: f64, si: &str) -> f64 {
        let scale = match si {
            "N" => self.scales[0],
            "N*m" | "J" => self.scales[1],
            _ => 0.0,
        };
        above(value, scale)
    }

    /// An instant; where a smooth quantity is largest is known to the root of the rounding of its value.
    fn instant(&self, t: f64) -> String {
        let t = if t.abs() <= RESOLUTION * self.duration { 0.0 } else { t };
        format!("{} {}", number(self.time.of_si(t)), self.time.unit)
    }

    /// A value and its instant; none of what is zero but for rounding, or the same throughout.
    fn extreme(&self, extreme: Extreme, si: &str) -> [String; 2] {
        let is_zero = self.floored(extreme.value, si) == 0.0;
        let has_instant = !is_zero && !extreme.is_steady;
        let instant = if has_instant { self.instant(extreme.t) } else { String::new() };
        [self.value(extreme.value, si), instant]
    }
}

fn words<const N: usize>(words: [&str; N]) -> Row {
    words.map(str::to_owned).to_vec()
}

/// The largest force of each joint, with its heading; none where nothing bears a force.
fn pin_forces(report: &Report, w: &Writing<'_>) -> Vec<Row> {
    let angle = angle_unit(w.units);
    let is_spatial = |z: f64| w.floored(z, "N") != 0.0;
    let is_spatial = report.reactions.iter().any(|one| is_spatial(one.largest.reaction[2]));
    let n_parts = if is_spatial { 3 } else { 2 };
    let pins = report.reactions.iter().filter(|one| w.floored(one.force.value, "N") != 0.0);
    let pins = pins.map(|joint| {
        let [force, at] = [w.value(joint.force.value, "N"), w.instant(joint.force.t)];
        let parts = joint.largest.reaction[..n_parts].iter().map(|&part| w.value(part, "N"));
        let degrees = |x: f64| format!("{} {}", number(angle.of_si(x)), angle.unit);
        let direction = joint.largest.direction().map_or_else(String::new, degrees);
        let pose = joint.largest.pose.first().map_or_else(String::new, |(name, value, unit)| {
            let value = if *unit == "rad" { degrees(*value) } else { w.value(*value, unit) };
            format!("{name} = {value}")
        });
        let first = [joint.name.clone(), force].into_iter().chain(parts);
        first.chain([direction, at, pose]).collect()
    });
    let parts = &["fx", "fy", "fz"][..n_parts];
    let head = [&["joint", "force"][..], parts, &["direction", "at", "pose"]].concat();
    let head: Row = head.into_iter().map(str::to_owned).collect();
    let rows: Vec<Row> = pins.collect();
    if rows.is_empty() { rows } else { std::iter::once(head).chain(rows).collect() }
}

/// The tables of a report in these units, with their names; those without rows are left out. The first row of each is
/// its heading.
pub fn tables(report: &Report, units: &ShownUnits) -> Vec<(&'static str, Vec<Row>)> {
    let duration = (report.span[1] - report.span[0]).abs();
    let writing = Writing { units, time: units.of("s"), scales: scales(report), duration };
    let w = &writing;
    let per =
        |unit: &str, n: usize| if n == 1 { format!("{unit}/s") } else { format!("{unit}/s^2") };
    let motions = report.motions.iter().map(|motion| {
        let floored =
            |limit: Extreme| Extreme { value: above(limit.value, motion.stroke()), ..limit };
        let [least, largest] = motion.limits.map(|limit| w.extreme(floored(limit), motion.unit));
        let stroke = [w.value(motion.stroke(), motion.unit)];
        let cells = [vec![motion.name.clone()], least.to_vec(), largest.to_vec(), stroke.to_vec()];
        cells.concat()
    });
    let rates = report.motions.iter().map(|motion| {
        let rate = w.extreme(motion.rate, &per(motion.unit, 1));
        // What a steady rate has of it is rounding.
        let least = motion.rate.value.abs() / duration;
        let acceleration =
            Extreme { value: above(motion.acceleration.value, least), ..motion.acceleration };
        let acceleration = w.extreme(acceleration, &per(motion.unit, 2));
        [vec![motion.name.clone()], rate.to_vec(), acceleration.to_vec()].concat()
    });
    let ratios = report.motions.iter().filter_map(|motion| {
        let ratio = motion.time_ratio?;
        let [forward, back] = [ratio.forward, ratio.back].map(|time| w.instant(time));
        Some(vec![motion.name.clone(), forward, back, number(ratio.value())])
    });
    let points = report.points.iter().map(|point| {
        let speed = w.extreme(point.speed, "m/s");
        let acceleration = w.extreme(point.acceleration, "m/s^2");
        [vec![point.name.clone()], speed.to_vec(), acceleration.to_vec()].concat()
    });
    let drives = report.drives.iter().map(|drive| {
        let [peak, at] = w.extreme(drive.peak, &drive.unit);
        let [power, power_at] = w.extreme(drive.power, "W");
        let mean = w.value(drive.mean_power, "W");
        vec![drive.name.clone(), peak, at, w.value(drive.rms, &drive.unit), power, power_at, mean]
    });
    let reactions = report.reactions.iter().map(|reaction| {
        let [force, at] = w.extreme(reaction.force, "N");
        let [moment, moment_at] = w.extreme(reaction.moment, "N*m");
        let mark = if reaction.is_unique { "" } else { " (not unique)" };
        let rms = [w.value(reaction.force_rms, "N"), w.value(reaction.moment_rms, "N*m")];
        let [force_rms, moment_rms] = rms;
        vec![
            format!("{}{mark}", reaction.name),
            force,
            at,
            force_rms,
            moment,
            moment_at,
            moment_rms,
        ]
    });
    let outputs = report.outputs.iter().map(|output| {
        let [least, largest] = output.limits.map(|limit| w.extreme(limit, &output.unit));
        let means = [output.mean, output.rms].map(|value| w.value(value, &output.unit));
        [vec![output.name.clone()], least.to_vec(), largest.to_vec(), means.to_vec()].concat()
    });
    let work = report.work.iter().map(|part| {
        let [work, stored] = [part.work, part.stored].map(|value| w.value(value, "J"));
        vec![part.name.clone(), part.kind.to_owned(), work, stored]
    });
    let energy = &report.energy;
    let at = |name: &str, extreme: Extreme, unit: &str| {
        [vec![name.to_owned()], w.extreme(extreme, unit).to_vec()].concat()
    };
    let joule =
        |name: &str, value: f64, t: &str| vec![name.to_owned(), w.value(value, "J"), t.to_owned()];
    let [first, last] = report.span.map(|t| w.instant(t));
    let energies = vec![
        at("kinetic energy, largest", energy.kinetic, "J"),
        at("potential energy, least", energy.potential[0], "J"),
        at("potential energy, largest", energy.potential[1], "J"),
        joule("total energy at the start", energy.total[0], &first),
        joule("total energy at the end", energy.total[1], &last),
        joule("work of loads and drives", energy.work, ""),
        at("their power, largest", energy.power, "W"),
    ];
    let headed = |head: Row, rows: Vec<Row>| {
        if rows.is_empty() { rows } else { std::iter::once(head).chain(rows).collect() }
    };
    let mut tables = vec![
        (
            "Limits and strokes",
            headed(words(["motion", "least", "at", "largest", "at", "stroke"]), motions.collect()),
        ),
        ("Time ratios", headed(words(["motion", "forward", "back", "ratio"]), ratios.collect())),
        (
            "Largest rates of joints",
            headed(words(["motion", "rate", "at", "acceleration", "at"]), rates.collect()),
        ),
        (
            "Largest velocities of points",
            headed(words(["point", "speed", "at", "acceleration", "at"]), points.collect()),
        ),
        (
            "Drives",
            headed(
                words(["drive", "peak", "at", "RMS", "power", "at", "mean power"]),
                drives.collect(),
            ),
        ),
        (
            "Reactions",
            headed(
                words(["joint", "force", "at", "RMS", "moment", "at", "RMS"]),
                reactions.collect(),
            ),
        ),
        ("Largest pin forces", pin_forces(report, w)),
        (
            "Outputs",
            headed(
                words(["output", "least", "at", "largest", "at", "mean", "RMS"]),
                outputs.collect(),
            ),
        ),
        ("Work", headed(words(["part", "kind", "work", "stored"]), work.collect())),
        ("Energies", headed(words(["energy", "value", "at"]), energies)),
    ];
    tables.retain(|(_, rows)| !rows.is_empty());
    tables
}
