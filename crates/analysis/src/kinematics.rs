//! Positions, velocities and accelerations over a range of prescribed motions.

use bksim_mbs::quantity::rate_unit;
use bksim_model::{Measure, Model, NamedSignal};
use bksim_sim::held_assembly::AssemblyChange;

use crate::assembly_watch::AssemblyWatch;
use crate::beyond::Beyond;
use crate::curve::Curve;
use crate::drive::{Drive, Range};
use crate::error::AnalysisError;
use crate::extreme::{Extreme, Extremes};
use crate::follow::follow;
use crate::kinematic_row::row;
use crate::loaded::without_rates;
use crate::path::{Law, Path};
use crate::pose_values::PoseValues;
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::rows::{Clock, Rows, wrapped};
use crate::table::{Column, Table};

/// The motions that are prescribed.
#[derive(Clone, PartialEq, Debug)]
pub enum Prescribed {
    /// These measures, all at once, over ranges with the same number of values; drives of the model stand still,
    /// but those in whose place one of them is.
    Drives {
        /// At least one.
        drives: Vec<Drive>,
        /// True if the motion goes on through dead points of the drives, which then turn back.
        through: bool,
    },
    /// The drives of the model, over times, s.
    Times(Range),
}

/// Positions over a range with their rates.
#[derive(Clone, PartialEq, Debug)]
pub struct Kinematics {
    /// A row for each value: first what is prescribed, then every quantity with rate and acceleration.
    pub table: Table,
    /// Limit positions of joints and bodies on the way.
    pub limits: Vec<Extreme>,
    /// Where the range could not be continued, if so: the prescribed values there.
    pub stopped: Option<Vec<f64>>,
    /// Where the motion passes over into another assembly than the one that the model holds: the value of the first
    /// prescribed measure there, or the time, and the joint that goes through its dead centre.
    pub changes: Vec<AssemblyChange>,
    /// Stops that some of the positions lie beyond, as `stop `NAME``.
    pub beyond: Vec<String>,
}

/// Follows the prescribed motions from the start of `model`.
///
/// # Errors
/// [`AnalysisError`] when the start does not close, too many or too few motions are prescribed, or the first
/// value is not reached.
pub fn kinematics(model: Model, prescribed: &Prescribed) -> Result<Kinematics, AnalysisError> {
    kinematics_along(model, prescribed, KinematicsOptions::default())
}

/// Choices about positions over a range.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct KinematicsOptions {
    /// Number of the branch that is followed where branches cross in the start, from one.
    pub branch: Option<usize>,
    /// True for the third rates of all quantities.
    pub has_jerk: bool,
}

/// Positions over a range as [`kinematics`] finds them, with these choices.
///
/// # Errors
/// [`AnalysisError`] as of [`kinematics`], or when there is no such branch.
pub fn kinematics_along(
    model: Model,
    prescribed: &Prescribed,
    options: KinematicsOptions,
) -> Result<Kinematics, AnalysisError> {
    without_rates(&model)?;
    // Positions alone have no signals.
    let signals = model.named_signals.clone();
    let positions = Positions::of(model)?;
    let found = match prescribed {
        Prescribed::Drives { drives, through } => {
            over_drives((&positions, &signals), drives, *through, options)?
        }
        Prescribed::Times(times) => over_times((&positions, &signals), *times, options)?,
    };
    if !found.table.rows.is_empty() {
        // An output may have no value in a pose.
        let is_named = |column: &Column| {
            ["outputs.", "signals."].iter().any(|topic| column.name.starts_with(topic))
        };
        return found.table.check_numbers(is_named).map(|()| found);
    }
    Err(prescribed.nowhere())
}

impl Prescribed {
    /// The fault of a range that is left at its first value.
    fn nowhere(&self) -> AnalysisError {
        match self {
            Self::Drives { drives, .. } => AnalysisError::Singular {
                name: drives.first().map_or_else(String::new, |drive| drive.name.clone()),
            },
            Self::Times(times) => AnalysisError::Lost { t: times.from },
        }
    }
}

/// The quantities of `positions` with rate and acceleration at the first of the prescribed values.
pub(crate) fn at_first(
    positions: &Positions,
    prescribed: &Prescribed,
) -> Result<Vec<f64>, AnalysisError> {
    let first = |range: Range| Range { to: range.from, n: 1, ..range };
    let of_drive = |drive: &Drive| Drive { range: first(drive.range), ..drive.clone() };
    let options = KinematicsOptions::default();
    let (found, n_prescribed) = match prescribed {
        Prescribed::Drives { drives, .. } => {
            let drives: Vec<Drive> = drives.iter().map(of_drive).collect();
            (over_drives((positions, &[]), &drives, false, options)?, 3 * drives.len())
        }
        Prescribed::Times(times) => (over_times((positions, &[]), first(*times), options)?, 1),
    };
    let row = found.table.rows.first().map(|row| row[n_prescribed..].to_vec());
    row.filter(|row| row.iter().all(|x| x.is_finite())).ok_or_else(|| prescribed.nowhere())
}

fn over_drives(
    (positions, signals): (&Positions, &[NamedSignal]),
    drives: &[Drive],
    through: bool,
    options: KinematicsOptions,
) -> Result<Kinematics, AnalysisError> {
    let measures: Vec<Measure> = drives.iter().map(|drive| drive.measure).collect();
    if let Some(first) = drives.first()
        && let Some(other) = drives.iter().find(|drive| drive.range.n != first.range.n)
    {
        return Err(AnalysisError::Counts { first: first.range.n, other: other.range.n });
    }
    let released = positions.replaced_drives(&measures)?;
    let mut rows = positions.rows(&measures, &released, Clock::Held)?;
    let prescribed: Vec<PoseQuantity> =
        drives.iter().map(|drive| positions.quantity_of(&drive.name, drive.measure)).collect();
    let rate: Vec<f64> = drives.iter().map(|drive| drive.rate).collect();
    let acceleration: Vec<f64> = drives.iter().map(|drive| drive.acceleration).collect();

    // From the start to the first values.
    let x = rows.scaled(&positions.q);
    let from: Vec<f64> = drives.iter().map(|drive| drive.range.from).collect();
    let x = approach((positions, &mut rows), (drives, &prescribed), x, &from, options.branch)?;

    // Along the range.
    let span: Vec<f64> = drives.iter().map(|drive| drive.range.to - drive.range.from).collect();
    let longest = span
        .iter()
        .enumerate()
        .fold(0.0, |a: f64, (k, span)| a.max(span.abs() / rows.unit_of_prescribed(k)));
    let per_parameter = if longest > 0.0 { 1.0 / longest } else { 1.0 };
    let law = Law {
        t: positions.t(),
        t_slope: 0.0,
        u: from,
        u_slope: span.iter().map(|span| span * per_parameter).collect(),
    };
    let n = drives.first().map_or(1, |drive| drive.range.n);
    let shares = Range { from: 0.0, to: 1.0, n }.values();
    let targets: Vec<f64> = shares.iter().map(|share| share * longest).collect();
    let request = Request { positions, signals, law, targets, through, options };
    let mut found = request.follow(&mut rows, &x, &rate, &acceleration, drives.len())?;

    // What is prescribed comes first, with the numbers that were asked for.
    let columns: Vec<Column> =
        prescribed.iter().flat_map(|of| heads(of, options.has_jerk)).collect();
    for (row, s) in found.table.rows.iter_mut().zip(&found.parameters) {
        let own = (0..drives.len()).flat_map(|k| {
            let own = [request.law.u[k] + request.law.u_slope[k] * s, rate[k], acceleration[k]];
            own.into_iter().chain(options.has_jerk.then_some(0.0))
        });
        row.splice(0..0, own.collect::<Vec<_>>());
    }
    found.table.columns.splice(0..0, columns);
    Ok(found.without_twins(&request))
}

/// Brings the prescribed measures from where they are at the start to their first values.
fn approach(
    (positions, rows): (&Positions, &mut Rows),
    (drives, prescribed): (&[Drive], &[PoseQuantity]),
    x: Vec<f64>,
    from: &[f64],
    branch: Option<usize>,
) -> Result<Vec<f64>, AnalysisError> {
    let now = positions.scalars(prescribed)?.values(positions.t(), &positions.q);
    let off = |k: usize| {
        let off = from[k] - now[k];
        if prescribed[k].is_angle() { wrapped(off) } else { off }
    };
    let off: Vec<f64> = (0..drives.len()).map(off).collect();
    let longest = off
        .iter()
        .enumerate()
        .fold(0.0, |a: f64, (k, off)| a.max(off.abs() / rows.unit_of_prescribed(k)));
    if longest < 1e-13 {
        return Ok(x);
    }
    let mut reached = f64::NAN;
    // The short way; for one angle that it does not lead to, the long way.
    let long = if let ([off], [quantity]) = (off.as_slice(), prescribed)
        && quantity.is_angle()
    {
        Some(vec![off - std::f64::consts::TAU * off.signum()])
    } else {
        None
    };
    for way in std::iter::once(off).chain(long) {
        let length = way.iter().enumerate().fold(0.0, |a: f64, (k, off): (usize, &f64)| {
            a.max(off.abs() / rows.unit_of_prescribed(k))
        });
        let law = Law {
            t: positions.t(),
            t_slope: 0.0,
            u: from.iter().zip(&way).map(|(from, off)| from - off).collect(),
            u_slope: way.iter().map(|off| off / length).collect(),
        };
        let start = law.u.first().copied().unwrap_or(0.0);
        let slope = law.u_slope.first().copied().unwrap_or(0.0);
        let mut curve = free_curve((positions, rows), law, (&x, branch), drives.len())?;
        let mut passed = Vec::new();
        let first = curve.equations.unknowns(&x);
        let end =
            follow(&mut curve, first, &[length], false, &mut |_, _, _| {}, &mut |_, (z, _), _| {
                passed.push(z.as_slice()[..x.len()].to_vec());
            });
        match (passed.pop(), end) {
            (Some(x), _) => return Ok(x),
            (None, end) => {
                reached =
                    if reached.is_nan() { start + slope * end.unwrap_or(0.0) } else { reached };
            }
        }
    }
    let first = &drives[0];
    Err(AnalysisError::NotReached {
        name: first.name.clone(),
        from: now[0],
        to: from[0],
        at: reached,
        unit: prescribed[0].unit,
    })
}

/// The cure of a start in which branches cross.
const CHOOSE: &str = "write `--branch 1` to follow the first of them";

/// The curve of what is prescribed, if nothing else is free.
fn free_curve<'r>(
    (positions, rows): (&Positions, &'r mut Rows),
    law: Law,
    (x, branch): (&[f64], Option<usize>),
    n_driven: usize,
) -> Result<Curve<Path<'r>>, AnalysisError> {
    let of_number = |n_free: usize| AnalysisError::NDrives {
        n_free: (n_free + n_driven).saturating_sub(1),
        n_driven,
    };
    Path::along(rows, (law, true), x, branch)
        .map_err(|no_path| positions.no_path(no_path, CHOOSE, of_number))
}

fn over_times(
    (positions, signals): (&Positions, &[NamedSignal]),
    times: Range,
    options: KinematicsOptions,
) -> Result<Kinematics, AnalysisError> {
    let mut rows = positions.rows(&[], &[], Clock::Running)?;
    let x = rows.scaled(&positions.q);
    let span = times.to - times.from;
    // The start is at its own time.
    let lead = times.from - positions.t();
    let x = if lead == 0.0 {
        x
    } else {
        let law = Law { t: positions.t(), t_slope: lead.signum(), ..Law::default() };
        let n_driven = positions.model().drives.len();
        let from = (x.as_slice(), options.branch);
        let mut curve = free_curve((positions, &mut rows), law, from, n_driven)?;
        let mut passed = Vec::new();
        let first = curve.equations.unknowns(&x);
        follow(&mut curve, first, &[lead.abs()], false, &mut |_, _, _| {}, &mut |_, (z, _), _| {
            passed.push(z.as_slice()[..x.len()].to_vec());
        });
        passed.pop().ok_or(AnalysisError::Lost { t: times.from })?
    };
    let law = Law { t: times.from, t_slope: if span < 0.0 { -1.0 } else { 1.0 }, ..Law::default() };
    let shares = Range { from: 0.0, to: 1.0, n: times.n }.values();
    let targets: Vec<f64> = shares.iter().map(|share| share * span.abs()).collect();
    let request = Request { positions, signals, law, targets, through: false, options };
    let mut found = request.follow(&mut rows, &x, &[], &[], positions.model().drives.len())?;
    for (row, s) in found.table.rows.iter_mut().zip(&found.parameters) {
        row.insert(0, request.law.t + request.law.t_slope * s);
    }
    found.table.columns.insert(0, Column::new("t", "s"));
    Ok(found.without_twins(&request))
}

fn heads(quantity: &PoseQuantity, has_jerk: bool) -> Vec<Column> {
    let names = quantity.names.iter().zip(quantity.units());
    let jerk = has_jerk.then(|| Column::new(quantity.jerk_name(), rate_unit(quantity.unit, 3)));
    names.map(|(name, unit)| Column::new(name.clone(), unit)).chain(jerk).collect()
}

/// A range to follow.
struct Request<'a> {
    positions: &'a Positions,
    signals: &'a [NamedSignal],
    law: Law,
    /// Values of the parameter with a row each, ascending from zero.
    targets: Vec<f64>,
    through: bool,
    options: KinematicsOptions,
}

/// Rows that were found, and the parameter of each.
struct Found {
    table: Table,
    parameters: Vec<f64>,
    limits: Vec<Extreme>,
    changes: Vec<AssemblyChange>,
    beyond: Vec<String>,
    end: Option<f64>,
}

impl Request<'_> {
    /// The prescribed values, or the time, at a value of the parameter.
    fn prescribed(&self, s: f64) -> Vec<f64> {
        let Law { t, t_slope, u, u_slope } = &self.law;
        if u.is_empty() {
            return vec![t + t_slope * s];
        }
        u.iter().zip(u_slope).map(|(u, slope)| u + slope * s).collect()
    }

    fn follow(
        &self,
        rows: &mut Rows,
        x: &[f64],
        u_dot: &[f64],
        u_ddot: &[f64],
        n_driven: usize,
    ) -> Result<Found, AnalysisError> {
        let positions = self.positions;
        let quantities = positions.quantities();
        let has_jerk = self.options.has_jerk;
        let mut rates = positions.rates_with(quantities, has_jerk)?;
        if has_jerk {
            positions.add_jerks(rows)?;
        }
        let mut values = PoseValues::of(positions, self.signals)?;
        let mut extremes = Extremes::of(positions, &[])?;
        let heads = quantities.iter().flat_map(|of| heads(of, has_jerk));
        let columns = heads.chain(values.columns.clone()).collect();
        let mut table = Table { columns, rows: Vec::new() };
        let mut parameters = Vec::new();
        let mut limits = Vec::new();
        let from = (x, self.options.branch);
        let mut curve = free_curve((positions, rows), self.law.clone(), from, n_driven)?;
        let first = curve.equations.unknowns(x);
        let mut watch = AssemblyWatch::of(positions)?;
        let mut beyond = Beyond::of(positions)?;
        let end = follow(
            &mut curve,
            first,
            &self.targets,
            self.through,
            &mut |curve, (from, to), ds| {
                limits.extend(extremes.between(curve, (from, to), ds));
                if let Some(watch) = &mut watch {
                    watch.step(curve, (from, to), ds[0]);
                }
            },
            &mut |curve, at, s| {
                let q = curve.equations.rows.unscaled(&at.0.as_slice()[..x.len()]);
                beyond.look(curve.equations.time(s), &q);
                table.rows.push(row(curve, (&mut rates, &mut values), at, (u_dot, u_ddot)));
                parameters.push(s);
            },
        );
        let changes = watch.map_or_else(Vec::new, |watch| watch.changes);
        // By what is prescribed first, not by the parameter.
        let prescribed = |change: AssemblyChange| {
            let at = self.prescribed(change.t);
            AssemblyChange { t: at.first().copied().unwrap_or(f64::NAN), ..change }
        };
        let changes = changes.into_iter().map(prescribed).collect();
        let beyond = beyond.names(positions.model());
        Ok(Found { table, parameters, limits, changes, beyond, end })
    }
}

impl Found {
    /// The answer, each column once.
    fn without_twins(self, request: &Request<'_>) -> Kinematics {
        let Self { mut table, limits, changes, beyond, end, .. } = self;
        let mut known = std::collections::HashSet::new();
        let keep: Vec<bool> =
            table.columns.iter().map(|column| known.insert(column.name.clone())).collect();
        if keep.contains(&false) {
            let kept = |k: &usize| keep[*k];
            let columns = (0..keep.len()).filter(kept).map(|k| table.columns[k].clone());
            table.columns = columns.collect();
            for row in &mut table.rows {
                let mut keep = keep.iter();
                row.retain(|_| keep.next().is_some_and(|keep| *keep));
            }
        }
        let stopped = end.map(|s| request.prescribed(s));
        Kinematics { table, limits, stopped, changes, beyond }
    }
}
