//! The sheet of the largest pin forces: by joint the force with its direction, instant and pose.

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

/// A cell of a table.
#[derive(Clone, PartialEq, Debug)]
pub enum Cell {
    /// A name.
    Text(String),
    /// A number, in the unit of its column.
    Number(f64),
}

impl Cell {
    /// The cell as text; empty of what is no number.
    pub fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(x) if x.is_nan() => String::new(),
            Self::Number(x) => x.to_string(),
        }
    }
}

/// A table of numbers under headings with their units.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct PinTable {
    /// Headings, `force [N]`.
    pub heads: Vec<String>,
    /// One row for each joint of each case.
    pub rows: Vec<Vec<Cell>>,
}

impl PinTable {
    /// The table as comma-separated values.
    pub fn csv(&self) -> String {
        let quoted = |text: String| {
            let is_plain = !text.contains([',', '"', '\n']);
            if is_plain { text } else { format!("\"{}\"", text.replace('"', "\"\"")) }
        };
        let heads = self.heads.iter().cloned().map(quoted).collect::<Vec<_>>();
        let row = |row: &Vec<Cell>| row.iter().map(|cell| quoted(cell.text())).collect::<Vec<_>>();
        let lines = std::iter::once(heads).chain(self.rows.iter().map(row));
        lines.map(|cells| cells.join(",") + "\n").collect()
    }
}

/// A number to the sixth digit of `scale`: what is smaller is beyond the accuracy of a run, and of a component that is zero
/// nothing is left.
pub fn six_digits(x: f64, scale: f64) -> f64 {
    if !(x.is_finite() && scale.is_finite() && scale > 0.0) {
        return x;
    }
    #[expect(clippy::cast_possible_truncation, reason = "an exponent is small")]
    let decimals = 5 - scale.log10().floor() as i32;
    let rounded = match usize::try_from(decimals) {
        // By the decimal text, so that the number reads back as it is written.
        Ok(decimals) => format!("{x:.decimals$}").parse().unwrap_or(x),
        Err(_) => (x * 10f64.powi(decimals)).round() / 10f64.powi(decimals),
    };
    if rounded == 0.0 { 0.0 } else { rounded }
}

/// Part of the largest force of all below which another one is rounding.
const ROUNDING: f64 = 1e-9;
/// The size from which a position counts, m or rad: a range that is smaller is rest.
const REST: f64 = 1e-6;

/// The largest pin forces of some cases, each by its name: six digits of a force, its components to the same digit.
pub fn pin_table(cases: &[(&str, &Report)], units: &ShownUnits) -> PinTable {
    let [force, moment, time] = ["N", "N*m", "s"].map(|si| units.of(si));
    let angle = angle_unit(units);
    let has_cases = cases.iter().any(|(name, _)| !name.is_empty());
    let heading = |name: &str, unit: &ShownUnit| format!("{name} [{}]", unit.unit);
    let mut heads = if has_cases { vec!["case".to_owned()] } else { Vec::new() };
    heads.extend(["joint".to_owned(), heading("force", &force)]);
    heads.extend(["fx", "fy", "fz"].map(|name| heading(name, &force)));
    heads.extend(["mx", "my", "mz"].map(|name| heading(name, &moment)));
    heads.extend([heading("direction", &angle), heading("t", &time)]);
    let of_pose = |unit: &str| if unit == "rad" { angle.clone() } else { units.of(unit) };
    let first = cases.iter().find_map(|(_, report)| report.reactions.first());
    heads.extend(
        first
            .iter()
            .flat_map(|first| &first.largest.pose)
            .map(|(name, _, unit)| heading(name, &of_pose(unit))),
    );
    let all = cases.iter().flat_map(|(_, report)| &report.reactions);
    let floor = ROUNDING * all.map(|joint| joint.force.value).fold(0.0, f64::max);
    let mut rows = Vec::new();
    for (case, report) in cases {
        let range = |name: &str| {
            let motion = report.motions.iter().find(|motion| motion.name == name);
            let ends = motion.map_or([0.0; 2], |motion| motion.limits.map(|end| end.value));
            ends[0].abs().max(ends[1].abs()).max(REST)
        };
        for joint in &report.reactions {
            let of = |x: f64, scale: f64, unit: &ShownUnit| {
                Cell::Number(six_digits(unit.of_si(x), unit.of_si(scale).abs()))
            };
            let size = joint.force.value.max(floor);
            let [.., mx, my, mz] = joint.largest.reaction;
            let largest_moment = mx.abs().max(my.abs()).max(mz.abs()).max(floor);
            let mut row = if has_cases { vec![Cell::Text((*case).to_owned())] } else { Vec::new() };
            row.push(Cell::Text(joint.name.clone()));
            let value = if joint.force.value > floor { joint.force.value } else { 0.0 };
            row.push(of(value, size, &force));
            row.extend(joint.largest.reaction.iter().enumerate().map(|(k, &x)| {
                let (scale, unit) = if k < 3 { (size, &force) } else { (largest_moment, &moment) };
                if x.abs() <= floor { Cell::Number(0.0) } else { of(x, scale, unit) }
            }));
            let direction = joint.largest.direction().filter(|_| value > 0.0);
            row.push(match direction {
                Some(x) => of(x, std::f64::consts::PI, &angle),
                None => Cell::Number(f64::NAN),
            });
            let end = report.span[0].abs().max(report.span[1].abs());
            row.push(of(joint.force.t, end, &time));
            let pose = joint.largest.pose.iter();
            row.extend(pose.map(|(name, x, unit)| of(*x, range(name), &of_pose(unit))));
            rows.push(row);
        }
    }
    PinTable { heads, rows }
}

/// The largest pin forces of a run as comma-separated values: a row for each joint, its heading with the units.
pub fn pin_sheet(report: &Report, units: &ShownUnits) -> String {
    pin_table(&[("", report)], units).csv()
}

/// For each joint the case in which its force is largest.
pub fn worst_cases(reports: &[&Report]) -> Vec<usize> {
    let n_joints = reports.first().map_or(0, |report| report.reactions.len());
    let force = |case: usize, joint: usize| {
        reports[case].reactions.get(joint).map_or(f64::NEG_INFINITY, |one| one.force.value)
    };
    let worst = |joint: usize| {
        (1..reports.len())
            .fold(0, |best, next| if force(next, joint) > force(best, joint) { next } else { best })
    };
    (0..n_joints).map(worst).collect()
}

/// The unit of angles: degrees where none is asked for.
pub fn angle_unit(units: &ShownUnits) -> ShownUnit {
    let own = units.of("rad");
    let degrees = || ShownUnit::parse("deg").unwrap_or_else(|| units.of("rad"));
    if own.unit == "rad" { degrees() } else { own }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_component_keeps_the_digits_of_its_force() {
        assert_eq!(six_digits(51.226_510_067, 51.2), 51.2265);
        assert_eq!(six_digits(-0.080_195_67, 51.2), -0.0802);
        assert_eq!(six_digits(3e-9, 51.2), 0.0);
        assert_eq!(six_digits(1_234_567.8, 1_234_567.8), 1_234_570.0);
        assert!(six_digits(-1e-12, 1.0).is_sign_positive(), "no zero has a sign");
    }
}
