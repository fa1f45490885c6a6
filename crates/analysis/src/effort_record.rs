//! [`Inverse`]: efforts over a motion as a table, with peaks and means, next to limits and curves of motors.

use nalgebra::DMatrix;

use crate::PoseQuantity;
use crate::actuation::EffortLimit;
use crate::controllers::ControllerState;
use crate::duty::{Duty, MotorCurve};
use crate::effort_channels::Channel;
use crate::effort_faults::no_actuator;
use crate::effort_ranges::EffortRanges;
use crate::equilibrium::reaction_columns;
use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::table::{Column, Table};

/// Largest and quadratic mean of a quantity over a motion.
#[derive(Clone, PartialEq, Debug)]
pub struct Load {
    /// Name of the column of the table.
    pub name: String,
    /// Unit of the load.
    pub unit: String,
    /// The value of largest magnitude.
    pub peak: f64,
    /// Time of the peak, s.
    pub at: f64,
    /// √(1/T ∫ x² dt), by the trapezoidal rule.
    pub rms: f64,
}

/// An effort next to its limit.
#[derive(Clone, PartialEq, Debug)]
pub struct LimitUse {
    /// Name of the actuator.
    pub name: String,
    /// N or N m.
    pub limit: f64,
    /// Largest |effort| over the limit.
    pub share: f64,
    /// Time of that, s.
    pub at: f64,
}

/// Efforts over a motion.
#[derive(Clone, PartialEq, Debug)]
pub struct Inverse {
    /// A row for each time: t; for each motion its position, rate, acceleration, for each actuator besides its effort and
    /// power, with the range that inner forces leave free, `A.effort_min` and `A.effort_max`; what no actuator can meet,
    /// `A.missing`; states and signals of controllers, `z` and `signals.u`; the reactions of the joints.
    pub table: Table,
    /// Of all efforts, powers and reactions.
    pub loads: Vec<Load>,
    /// Largest number of independent inner forces: of efforts that move nothing.
    pub n_inner: usize,
    /// Motions along which a small part of the effort is missing, no more than the samples of a motion are off.
    pub missing: Vec<String>,
    /// Friction of joints at rest and stops that bear, whose forces leave efforts a range.
    pub open: Vec<String>,
    /// Times at which no efforts keep to the limits, s; of mechanisms with inner forces.
    pub impossible: Vec<f64>,
    /// Efforts with a limit.
    pub limits: Vec<LimitUse>,
    /// Operating points next to curves of motors.
    pub duties: Vec<Duty>,
    /// States and sampled signals of controllers, which follow the motion and act besides the efforts.
    pub controllers: Vec<String>,
}

/// A motion that the actuators do not meet.
struct Unmet {
    t: f64,
    q: Vec<f64>,
    /// Free motions there.
    free: DMatrix<f64>,
    /// By prescribed motion, in units of the motions.
    parts: Vec<f64>,
}

/// Part of the terms along the motions that samples of a motion may leave: joined by polynomials, they keep to the equations only so
/// far.
const OFF: f64 = 1e-5;

/// Everything about the times of a motion.
#[derive(Default)]
pub(crate) struct Record {
    pub(crate) times: Vec<f64>,
    /// Value, rate and acceleration of the channels.
    pub(crate) shown: Vec<Vec<[f64; 3]>>,
    /// Of the actuators.
    pub(crate) efforts: Vec<Vec<f64>>,
    /// Of the prescribed motions.
    pub(crate) missing: Vec<Vec<f64>>,
    /// Ends of the ranges of efforts.
    pub(crate) ranges: Vec<EffortRanges>,
    /// Largest number of inner forces.
    n_inner: usize,
    /// Contacts that leave efforts open.
    open: Vec<String>,
    /// Largest of the terms of the equations along the motions, in units of the motions.
    largest: f64,
    /// Largest load that the actuators cannot meet.
    unmet: Option<Unmet>,
    pub(crate) controllers: Vec<ControllerState>,
    /// Of the named signals.
    pub(crate) signals: Vec<Vec<f64>>,
    pub(crate) reactions: Vec<Vec<f64>>,
}

impl Record {
    /// Notes what no actuator meets at a time.
    pub(crate) fn note_missing(
        &mut self,
        t: f64,
        (q, free): (&[f64], &DMatrix<f64>),
        (parts, size): (&[f64], f64),
    ) {
        self.largest = self.largest.max(size);
        let worst = parts.iter().fold(0.0, |most: f64, part| most.max(*part));
        let is_first = self
            .unmet
            .as_ref()
            .is_none_or(|unmet| unmet.parts.iter().all(|part| *part <= OFF * self.largest));
        if worst > OFF * self.largest && is_first {
            let (q, free, parts) = (q.to_vec(), free.clone(), parts.to_vec());
            self.unmet = Some(Unmet { t, q, free, parts });
        }
    }

    /// Notes how open the efforts at a time are.
    pub(crate) fn note_ranges(&mut self, ends: EffortRanges, n_inner: usize, open: Vec<String>) {
        self.n_inner = self.n_inner.max(n_inner);
        if !matches!(ends, EffortRanges::Unique) {
            for name in open {
                if !self.open.contains(&name) {
                    self.open.push(name);
                }
            }
        }
        self.ranges.push(ends);
    }

    /// Refuses a motion that the actuators do not meet.
    pub(crate) fn check_met(
        &self,
        loaded: &Loaded,
        channels: &[Channel],
    ) -> Result<(), AnalysisError> {
        let Some(Unmet { t, q, free, parts }) = &self.unmet else { return Ok(()) };
        let prescribed = channels.iter().filter(|channel| channel.is_prescribed);
        let is_unmet = |(_, part): &(&Channel, &f64)| **part > OFF * self.largest;
        let names = prescribed.zip(parts).filter(is_unmet).map(|(channel, _)| channel.name.clone());
        let names: Vec<String> = names.collect();
        if names.is_empty() {
            return Ok(());
        }
        Err(no_actuator((loaded, channels), (*t, q), free, &names)?)
    }

    /// The answer, with the limits and curves of actuators.
    pub(crate) fn told(
        &self,
        loaded: &Loaded,
        (channels, quantities): (&[Channel], &[PoseQuantity]),
        (bounds, curves): (&[EffortLimit], &[MotorCurve]),
    ) -> Inverse {
        let n_inner = self.n_inner;
        let names: Vec<&str> =
            (channels.iter().filter(|c| c.drive_idx.is_some())).map(|c| c.name.as_str()).collect();
        let limit_of = |name: &str| {
            let own = bounds.iter().find(|limit| limit.name == name);
            own.map_or(f64::INFINITY, |limit| limit.limit)
        };
        let limits: Vec<f64> = names.iter().map(|name| limit_of(name)).collect();

        // The range of each effort within the limits, where any has one at some time.
        let mut impossible = Vec::new();
        let has_ranges = self.ranges.iter().any(|ends| !matches!(ends, EffortRanges::Unique));
        let free: Vec<Option<Vec<[f64; 2]>>> = (self.times.iter().zip(&self.ranges).enumerate())
            .map(|(k, (&t, ends))| {
                let keeps = |(effort, limit): (&f64, &f64)| effort.abs() <= *limit;
                let ends = match ends {
                    _ if !has_ranges => return None,
                    EffortRanges::Open(ends) => Some(ends.clone()),
                    EffortRanges::Unique if self.efforts[k].iter().zip(&limits).all(keeps) => {
                        Some(self.efforts[k].iter().map(|&effort| [effort; 2]).collect())
                    }
                    EffortRanges::Unique | EffortRanges::Impossible => None,
                };
                if ends.is_none() {
                    impossible.push(t);
                }
                Some(ends.unwrap_or_else(|| vec![[f64::NAN; 2]; names.len()]))
            })
            .collect();

        let is_missing = |k: usize| self.missing.iter().any(|row| row[k] != 0.0);
        let mut heads = vec![Column::new("t", "s")];
        let mut columns: Vec<Vec<f64>> = vec![self.times.clone()];
        let (mut n_prescribed, mut missing) = (0, Vec::new());
        for (k, (channel, quantity)) in channels.iter().zip(quantities).enumerate() {
            let name = &channel.name;
            let is_angle = quantity.is_angle();
            let effort_unit = if is_angle { "N*m" } else { "N" };
            let words = if is_angle {
                ["angle", "rate", "acceleration"]
            } else {
                ["position", "velocity", "acceleration"]
            };
            for (level, (word, unit)) in words.iter().zip(quantity.units()).enumerate() {
                heads.push(Column::new(format!("{name}.{word}"), unit));
                columns.push(self.shown.iter().map(|row| row[k][level]).collect());
            }
            if let Some(drive_idx) = channel.drive_idx {
                let efforts: Vec<f64> = self.efforts.iter().map(|row| row[drive_idx]).collect();
                let powers = efforts.iter().zip(&self.shown).map(|(e, row)| e * row[k][1]);
                heads.push(Column::new(format!("{name}.effort"), effort_unit));
                heads.push(Column::new(format!("{name}.power"), "W"));
                let powers = powers.collect();
                columns.extend([efforts, powers]);
                if has_ranges {
                    for (end, word) in ["effort_min", "effort_max"].into_iter().enumerate() {
                        heads.push(Column::new(format!("{name}.{word}"), effort_unit));
                        let own = |row: &Option<Vec<[f64; 2]>>| {
                            row.as_ref().map_or(f64::NAN, |row| row[drive_idx][end])
                        };
                        columns.push(free.iter().map(own).collect());
                    }
                }
            }
            if channel.is_prescribed {
                if is_missing(n_prescribed) {
                    missing.push(name.clone());
                    heads.push(Column::new(format!("{name}.missing"), effort_unit));
                    columns.push(self.missing.iter().map(|row| row[n_prescribed]).collect());
                }
                n_prescribed += 1;
            }
        }
        self.controllers(loaded, &mut heads, &mut columns);
        heads.extend(reaction_columns(&loaded.mechanism.compiled.joints));
        let row = |k: usize| -> Vec<f64> {
            let own = columns.iter().map(|column| column[k]);
            own.chain(self.reactions[k].iter().copied()).collect()
        };
        let rows = (0..self.times.len()).map(row).collect();
        let table = Table { columns: heads, rows };
        let is_bounded = |name: &&str| limit_of(name).is_finite();
        let limits = names.iter().copied().filter(is_bounded);
        let limits = limits.map(|name| limit_use(&table, name, limit_of(name))).collect();
        let duties = curves.iter().filter_map(|curve| duty(&table, curve));
        Inverse {
            loads: loads(&table),
            n_inner,
            missing,
            open: self.open.clone(),
            impossible,
            limits,
            duties: duties.collect(),
            controllers: names_of_controllers(loaded),
            table,
        }
    }
}

impl Record {
    /// Columns of states and signals: `z`, `signals.u`, `outputs.y`.
    fn controllers(&self, loaded: &Loaded, heads: &mut Vec<Column>, columns: &mut Vec<Vec<f64>>) {
        let model = loaded.model();
        for (k, state) in model.states.iter().enumerate() {
            heads.push(Column::new(state.name.clone(), state.units[1].replace(' ', "*")));
            columns.push(self.controllers.iter().map(|at| at.z[k]).collect());
        }
        for (k, signal) in model.named_signals.iter().enumerate() {
            let group = if signal.is_output { "outputs" } else { "signals" };
            let name = format!("{group}.{}", signal.name);
            heads.push(Column::new(name, signal.unit.replace(' ', "*")));
            columns.push(self.signals.iter().map(|at| at[k]).collect());
        }
    }
}

/// Names of the states and of the signals that clocks change.
fn names_of_controllers(loaded: &Loaded) -> Vec<String> {
    let model = loaded.model();
    let states = model.states.iter().map(|state| state.name.clone());
    states.chain(model.held.iter().map(|signal| signal.name.clone())).collect()
}

fn limit_use(table: &Table, name: &str, limit: f64) -> LimitUse {
    let efforts = table.column(&format!("{name}.effort")).unwrap_or_default();
    let worst = (0..efforts.len()).max_by(|&a, &b| efforts[a].abs().total_cmp(&efforts[b].abs()));
    let at = worst.map_or(0.0, |k| table.rows[k][0]);
    LimitUse {
        name: name.to_owned(),
        limit,
        share: worst.map_or(0.0, |k| efforts[k].abs() / limit),
        at,
    }
}

/// The operating points of an actuator next to a curve; `None` where there is no such actuator.
fn duty(table: &Table, curve: &MotorCurve) -> Option<Duty> {
    let name = &curve.name;
    let place = |word: &str| table.columns.iter().position(|c| c.name == format!("{name}.{word}"));
    let effort = place("effort")?;
    let speed = place("rate").or_else(|| place("velocity"))?;
    let units = [speed, effort].map(|k| table.columns[k].unit.clone());
    let point = |row: &Vec<f64>| [row[0], row[speed], row[effort], curve.at(row[speed])];
    Some(Duty { curve: curve.clone(), units, points: table.rows.iter().map(point).collect() })
}

/// Peaks and means of efforts, powers and reactions.
fn loads(table: &Table) -> Vec<Load> {
    let times: Vec<f64> = table.rows.iter().map(|row| row[0]).collect();
    let is_end = |name: &str| name.ends_with(".effort_min") || name.ends_with(".effort_max");
    let is_load = |column: &&(usize, &Column)| {
        matches!(column.1.unit.as_str(), "N" | "N*m" | "W") && !is_end(&column.1.name)
    };
    let of = |(k, column): (usize, &Column)| {
        let values: Vec<f64> = table.rows.iter().map(|row| row[k]).collect();
        let peak = (0..values.len()).max_by(|&a, &b| values[a].abs().total_cmp(&values[b].abs()));
        let peak = peak.unwrap_or(0);
        let steps = 1..times.len();
        let square: f64 = steps
            .map(|i| 0.5 * (values[i].powi(2) + values[i - 1].powi(2)) * (times[i] - times[i - 1]))
            .sum();
        let span = times.last().copied().unwrap_or(0.0) - times.first().copied().unwrap_or(0.0);
        let own = values.get(peak).copied().unwrap_or(0.0);
        Load {
            name: column.name.clone(),
            unit: column.unit.clone(),
            peak: own,
            at: times.get(peak).copied().unwrap_or(0.0),
            rms: if span == 0.0 { own.abs() } else { (square / span).sqrt() },
        }
    };
    let columns: Vec<(usize, &Column)> = table.columns.iter().enumerate().collect();
    columns.iter().filter(is_load).map(|&column| of(column)).collect()
}
