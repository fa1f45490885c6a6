//! Limits of a mechanism with one free motion: ranges, dead points, transmission angles, time ratios, fastest
//! motions, mechanical advantage, and the double points of curves that points draw.

use std::f64::consts::TAU;

use bksim_model::{Measure, Model};

use crate::assemblies::closed_poses;
use crate::assur::{FourBar, SliderCrank, four_bars};
use crate::beyond::Beyond;
use crate::curve::{Curve, Point};
use crate::drive::position;
use crate::error::AnalysisError;
use crate::extreme::{Extreme, Extremes};
use crate::path::{Law, Path};
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::rows::{Clock, Rows};
use crate::scalar::Rates;
use crate::trace::Trace;
use crate::transmission::{TRANSMISSION, Transmission, Transmissions, angles, arms};
use crate::way_rates::ASIDE;
use crate::whole_turns::Turn;

/// The limits that are asked for.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct LimitsRequest {
    /// The measure that drives: rates, ratios and time ratios are per its rate.
    pub drive: Option<String>,
    /// Measures whose time ratio and fastest motions are wanted; they need a drive.
    pub outputs: Vec<String>,
    /// True if all assemblies count, not that of the start alone.
    pub all_assemblies: bool,
}

/// Limits of all assemblies that were asked for.
#[derive(Clone, PartialEq, Debug)]
pub struct Limits {
    /// The one of the start first.
    pub branches: Vec<Branch>,
    /// Loops of four parts with pins, with their types.
    pub four_bars: Vec<FourBar>,
    /// Loops of four parts with three pins and a guide.
    pub slider_cranks: Vec<SliderCrank>,
    /// Stops that poses lie beyond and contacts, which limits do not keep to: `stop `NAME``.
    pub beyond: Vec<String>,
}

/// Poses that are connected by motion.
#[derive(Clone, PartialEq, Debug)]
pub struct Branch {
    /// Whether the motion comes back to where it began; else it ends, or goes on without end.
    pub is_closed: bool,
    /// Ranges of joints, bodies and transmission angles.
    pub ranges: Vec<RangeOf>,
    /// Where they turn back, in order along the motion: dead points of a mechanism that they drive.
    pub extremes: Vec<Extreme>,
    /// Transmission and pressure angles, at their least and greatest.
    pub transmissions: Vec<Transmission>,
    /// Of each output.
    pub outputs: Vec<OutputLimits>,
}

/// The range of a quantity.
#[derive(Clone, PartialEq, Debug)]
pub struct RangeOf {
    /// `rocker.angle`; `transmission C` for the angle between the links that joint C connects.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// True if it turns all the way round, so that there are no limits.
    pub turns: bool,
}

/// Limits of an output per rate of the drive.
#[derive(Clone, PartialEq, Debug)]
pub struct OutputLimits {
    /// The output.
    pub name: String,
    /// The drive.
    pub drive: String,
    /// SI units of the drive and of the output.
    pub units: [&'static str; 2],
    /// Time of the slower stroke over that of the faster, at a constant rate of a drive that turns round.
    pub time_ratio: Option<f64>,
    /// Value of the drive, of the output, and its rate per rate of the drive, where that is extreme.
    pub fastest: Vec<[f64; 3]>,
    /// The least mechanical advantage, the effort of the output over that of the drive without losses, which is
    /// |drive rate / output rate|; with the value of the drive there. Where the output turns back it has no bound.
    pub least_advantage: Option<[f64; 2]>,
    /// Values of the drive at which the advantage has no bound, or is none: dead points of the output, and of the drive.
    pub dead_points: [Vec<f64>; 2],
}

/// Finds the limits of `model`, whose drives are released.
///
/// # Errors
/// [`AnalysisError`] when the start does not close, or more than one motion is free.
pub fn limits(model: Model, request: &LimitsRequest) -> Result<Limits, AnalysisError> {
    let positions = Positions::of(model)?;
    let released: Vec<usize> = (0..positions.model().drives.len()).collect();
    let mut rows = positions.rows(&[], &released, Clock::Held)?;
    let arms = arms(&positions);
    let angles = angles(&positions, &arms);
    let mut extremes = Extremes::of(&positions, &angles)?;
    let mut transmissions = Transmissions::of(&positions, &arms)?;
    let (four_bars, slider_cranks) = four_bars(&positions)?;
    let mut outputs = Outputs::of(&positions, request, &released)?;

    // The branch of the start, then those of other assemblies that are on none of these.
    let x = rows.scaled(&positions.q);
    let others =
        if request.all_assemblies { closed_poses(&positions, &mut rows) } else { Vec::new() };
    let mut curve = free_curve(&mut rows, &positions, &x)?;
    let traces = Trace::all(&mut curve, &x, &others);
    let mut beyond = Beyond::of(&positions)?;
    beyond.along(&curve, &traces);
    let is_turn = curve.equations.rows.is_turn.clone();
    let branches = traces.iter().map(|trace| {
        let turn = trace.is_closed.then(|| trace.turn(&is_turn));
        extremes.tell_near_start(turn.clone());
        if let Some(outputs) = &mut outputs {
            outputs.turn.clone_from(&turn);
        }
        let transmissions = transmissions.along(&mut curve, trace, turn);
        Branch { transmissions, ..branch(&mut curve, trace, &mut extremes, &mut outputs) }
    });
    let branches = branches.collect();
    Ok(Limits { branches, four_bars, slider_cranks, beyond: beyond.names(positions.model()) })
}

/// The curve of the one motion that is free.
pub(crate) fn free_curve<'r>(
    rows: &'r mut Rows,
    positions: &Positions,
    x: &[f64],
) -> Result<Curve<Path<'r>>, AnalysisError> {
    let law = Law { t: positions.t(), ..Law::default() };
    let one = |n_free| AnalysisError::NotOneMotion { n_free };
    Path::through(rows, (law, false), x).map_err(|no_path| positions.no_path(no_path, ASIDE, one))
}

/// Ranges and extremes along one trace.
fn branch(
    curve: &mut Curve<Path<'_>>,
    trace: &Trace,
    extremes: &mut Extremes,
    outputs: &mut Option<Outputs>,
) -> Branch {
    let mut found = Vec::new();
    for (pair, &step) in trace.points.windows(2).zip(&trace.steps) {
        found.extend(extremes.between(curve, (&pair[0], &pair[1]), [step, step]));
    }
    if trace.is_endless {
        // The same in every turn.
        let is_same = |a: &Extreme, b: &Extreme| {
            let off = (a.value - b.value).abs();
            a.name == b.name
                && a.is_maximum == b.is_maximum
                && off <= 1e-9 * a.value.abs().max(1e-3)
        };
        let mut once: Vec<Extreme> = Vec::new();
        for extreme in found {
            if !once.iter().any(|known| is_same(known, &extreme)) {
                once.push(extreme);
            }
        }
        found = once;
    }
    let mut values: Vec<Vec<f64>> =
        trace.points.iter().map(|p| extremes.values(curve, p)).collect();
    let (names, units) = (extremes.names().to_vec(), extremes.unit_names().to_vec());
    let mut ranges = Vec::new();
    for (k, (name, unit)) in names.iter().zip(units).enumerate() {
        // Angles without their jumps.
        for i in 1..values.len() {
            if unit == "rad" {
                let jump = values[i][k] - values[i - 1][k];
                values[i][k] -= TAU * (jump / TAU).round();
            }
        }
        let all = values.iter().map(|row| row[k]);
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        all.for_each(|value| (min, max) = (min.min(value), max.max(value)));
        let net = values.last().map_or(0.0, |last| last[k] - values[0][k]);
        let is_round = trace.is_closed || trace.is_endless && net.abs() > TAU;
        let turns = unit == "rad" && is_round && net.abs() > 1.0;
        // Located extremes are exact.
        for extreme in found.iter().filter(|extreme| extreme.name == *name) {
            let end = if extreme.is_maximum { &mut max } else { &mut min };
            let value = extreme.value
                + if unit == "rad" { TAU * ((*end - extreme.value) / TAU).round() } else { 0.0 };
            if (value - *end).abs() < 0.01 {
                *end = if extreme.is_maximum { end.max(value) } else { end.min(value) };
            }
        }
        if name.starts_with(TRANSMISSION) {
            // An angle between two arms is counted from either in turn: its least value is the one within half a turn.
            let turn = TAU * (min / TAU).round();
            (min, max) = (min - turn, max - turn);
            for extreme in &mut found {
                extreme.within(name, [min, max]);
            }
        }
        ranges.push(RangeOf { name: name.clone(), unit, min, max, turns });
    }
    let outputs = outputs.as_mut().map_or_else(Vec::new, |o| o.along(curve, trace, &found));
    let transmissions = Vec::new();
    Branch { is_closed: trace.is_closed, ranges, extremes: found, transmissions, outputs }
}

/// Outputs per rate of a drive.
struct Outputs {
    rows: Rows,
    rates: Rates,
    drive: PoseQuantity,
    names: Vec<String>,
    units: Vec<&'static str>,
    t: f64,
    /// The turn of a motion that closes, near whose start poses are told.
    turn: Option<Turn>,
}

impl Outputs {
    fn of(
        positions: &Positions,
        request: &LimitsRequest,
        released: &[usize],
    ) -> Result<Option<Self>, AnalysisError> {
        let Some(drive) = &request.drive else { return Ok(None) };
        let model = positions.model();
        let measure = position(model, drive)?;
        let outputs: Vec<(String, Measure)> = request
            .outputs
            .iter()
            .map(|name| Ok((name.clone(), position(model, name)?)))
            .collect::<Result<_, AnalysisError>>()?;
        let quantity = positions.quantity_of(drive, measure);
        let mut all = vec![quantity.clone()];
        all.extend(outputs.iter().map(|(name, measure)| positions.quantity_of(name, *measure)));
        Ok(Some(Self {
            rows: positions.rows(&[measure], released, Clock::Held)?,
            rates: positions.rates(&all)?,
            drive: quantity,
            units: outputs.iter().map(|(_, measure)| measure.fixed_unit(model)).collect(),
            names: outputs.into_iter().map(|(name, _)| name).collect(),
            t: positions.t(),
            turn: None,
        }))
    }

    /// Drive, then outputs, each with rate and acceleration for the rate 1 and the acceleration 0 of the drive.
    fn at(&mut self, point: &Point) -> Option<Vec<[f64; 3]>> {
        let x = point.z.as_slice();
        let [v, a] = self.rows.rates(self.t, x, (&[1.0], &[0.0]))?;
        let told = self.turn.as_ref().map(|turn| turn.nearest(x));
        let q = self.rows.unscaled(told.as_deref().unwrap_or(x));
        Some(self.rates.at(self.t, [&q, &v, &a]))
    }

    fn along(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        trace: &Trace,
        extremes: &[Extreme],
    ) -> Vec<OutputLimits> {
        let all: Vec<Option<Vec<[f64; 3]>>> = trace.points.iter().map(|p| self.at(p)).collect();
        let mut found = Vec::new();
        for (k, name) in self.names.clone().iter().enumerate() {
            let mut fastest = Vec::new();
            for i in 1..all.len() {
                let (Some(before), Some(after)) = (&all[i - 1], &all[i]) else { continue };
                let (before, after) = (before[k + 1][2], after[k + 1][2]);
                if (before > 0.0) == (after > 0.0) || before == 0.0 {
                    continue;
                }
                let (from, step) = (&trace.points[i - 1], trace.steps[i - 1]);
                let mut bend = |_: &mut Curve<Path<'_>>, p: &Point| {
                    self.at(p).map_or(0.0, |all| all[k + 1][2])
                };
                let Some(point) = curve.root(from, step, (before, after), &mut bend) else {
                    continue;
                };
                let Some(there) = self.at(&point) else { continue };
                // At dead points of the drive the rate has no extreme, but no bound.
                if there[k + 1][1].abs() < 1e6 {
                    fastest.push([there[0][0], there[k + 1][0], there[k + 1][1]]);
                }
            }
            let own: Vec<f64> = extremes
                .iter()
                .filter(|extreme| extreme.name == *name)
                .filter_map(|extreme| {
                    let drive =
                        extreme.pose.iter().find(|(known, _)| *known == self.drive.names[0]);
                    drive.map(|(_, value)| *value)
                })
                .collect();
            let of_rate = |[drive, _, rate]: &[f64; 3]| [1.0 / rate.abs(), *drive];
            let least_advantage = fastest.iter().map(of_rate).min_by(|a, b| a[0].total_cmp(&b[0]));
            let of_drive = extremes.iter().filter(|extreme| extreme.name == self.drive.names[0]);
            let of_drive: Vec<f64> = of_drive.map(|extreme| extreme.value).collect();
            // There and back take times as a drive at a constant rate goes on, not one that turns back.
            let time_ratio = match own[..] {
                [a, b] if self.drive.is_angle() && of_drive.is_empty() => {
                    let stroke = (a - b).rem_euclid(TAU);
                    Some((stroke / (TAU - stroke)).max((TAU - stroke) / stroke))
                }
                _ => None,
            };
            found.push(OutputLimits {
                name: name.clone(),
                drive: self.drive.names[0].clone(),
                units: [self.drive.unit, self.units[k]],
                time_ratio,
                fastest,
                // Where the drive turns back, every rate is without bound.
                least_advantage: least_advantage.filter(|_| of_drive.is_empty()),
                dead_points: [own, of_drive],
            });
        }
        found
    }
}
