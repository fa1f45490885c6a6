//! Inverse dynamics: a motion gives the efforts of the actuators, all reactions, and the power.
//!
//! ```text
//! positions, velocities and accelerations from the constraints and the prescribed motions
//! Gᵀ λ = f − M a        the efforts of the actuators are the multipliers of their rows
//! ```
//!
//! More actuators than free motions share the load by the smallest efforts, and fewer leave something out: see
//! [`crate::actuation`].

use bksim_mbs::constraint::Source;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_model::{Drive as ModelDrive, Initial, Measure, Model};
use nalgebra::DMatrix;

use crate::PoseQuantity;
use crate::actuation::{Actuation, EffortLimit, Efforts};
use crate::drive::Range;
use crate::duty::{Duty, MotorCurve};
use crate::equilibrium::reaction_columns;
use crate::error::AnalysisError;
use crate::forces::{At, Forces};
use crate::loaded::{Loaded, without_states};
use crate::motion::{Motion, driven};
use crate::positions::Positions;
use crate::ranges::{Bounded, ranges};
use crate::rows::Clock;
use crate::table::{Column, Table};
use crate::walk::Walk;

/// The actuators, and how much each can give.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Actuators {
    /// Joints or drives that have an effort; the drives of the model and the joints of the motions where there are none.
    pub named: Vec<String>,
    /// Limits of efforts.
    pub limits: Vec<EffortLimit>,
    /// Curves of motors.
    pub curves: Vec<MotorCurve>,
}

/// Largest and quadratic mean of a quantity over a motion.
#[derive(Clone, PartialEq, Debug)]
pub struct Load {
    /// Name of the column of the table.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The value of largest magnitude.
    pub peak: f64,
    /// Time of the peak, s.
    pub at: f64,
    /// √(1/T ∫ x² dt), by the trapezoidal rule.
    pub rms: f64,
}

/// An effort beside its limit.
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
    /// `A.missing`; the reactions of the joints.
    pub table: Table,
    /// Of all efforts, powers and reactions.
    pub loads: Vec<Load>,
    /// Largest number of independent inner forces: of efforts that move nothing.
    pub n_inner: usize,
    /// Motions along which an effort is missing.
    pub missing: Vec<String>,
    /// Times at which no efforts keep to the limits, s; of mechanisms with inner forces.
    pub impossible: Vec<f64>,
    /// Efforts with a limit.
    pub limits: Vec<LimitUse>,
    /// Operating points beside curves of motors.
    pub duties: Vec<Duty>,
}

/// A motion that is prescribed, an actuator, or both.
struct Channel {
    name: String,
    measure: Measure,
    is_prescribed: bool,
    /// Number of its drive in the model of the forces.
    drive_idx: Option<usize>,
}

/// Efforts that make `model` follow `motions`, and its own drives, at `times`.
///
/// # Errors
/// [`AnalysisError`] when there is no start, motions are left free, or the motion cannot be followed.
pub fn inverse(
    mut model: Model,
    motions: &[Motion],
    times: &Range,
    actuators: &Actuators,
) -> Result<Inverse, AnalysisError> {
    without_states(&model)?;
    let mut channels = channels(&mut model, motions, &actuators.named)?;
    let forced = model.snapshot();

    // Positions: each motion of a joint is a drive of the start.
    let n_own = model.drives.len();
    prescribe_start(&mut model, motions, times.from);
    let positions = Positions::of(model)?;
    let measures: Vec<Measure> = motions.iter().map(|m| m.measure).collect();
    let added: Vec<usize> = (n_own..positions.model().drives.len()).collect();
    let mut rows = positions.rows(&measures, &added, Clock::Running)?;
    let mut walk = Walk { x: rows.scaled(&positions.q), t: times.from, motions };
    walk.check_drives(&mut rows, positions.model().drives.len())?;

    // Forces of the same mechanism, masses and loads included, with a drive for each actuator.
    let mut forced = forced.to_model();
    act(&mut forced, &mut channels);
    let mechanism = bksim_sim::Mechanism::derive(forced, Vec::new())?;
    let loaded = Loaded::at_position(mechanism, &positions);
    let system = loaded.system();
    let mut forces =
        Forces::compile(loaded.model(), system, &loaded.kept, &[], &loaded.parameters)?;
    let quantities = quantities(&loaded, &channels);
    let mut rates = loaded.rates(&quantities)?;
    let mut slopes = loaded.scalars(&quantities)?;
    let actuation = actuation(&loaded, &channels, &quantities, &actuators.limits)?;

    let mut record = Record::default();
    for t in times.values() {
        let [q, v, a] = walk.to(&mut rows, t).ok_or(AnalysisError::Lost { t })?;
        let nothing = vec![0.0; forces.nc()];
        let at = forces.at(At { t, q: &q, v: &v, a: &a, lambda: &nothing, p: &[] });
        let gradients = slopes.gradients(t, &q);
        let prescribed: Vec<usize> =
            (0..channels.len()).filter(|&k| channels[k].is_prescribed).collect();
        let along = DMatrix::from_fn(prescribed.len(), q.len(), |k, i| gradients[prescribed[k]][i]);
        let Efforts { lambda, missing, inner } =
            actuation.efforts(&at, &along).ok_or(AnalysisError::Lost { t })?;
        let mut lambda = forces.all_multipliers(system.constraints.len(), &lambda);
        let reactions = loaded.reactions(t, &loaded.parameters, [&q, &v, &a], &mut lambda);
        record.shown.push(rates.at(t, [&q, &v, &a]));
        record.efforts.push(efforts_of(&loaded, &channels, &lambda));
        record.missing.push(missing);
        record.inner.push(inner);
        record.reactions.push(reactions.concat());
        record.times.push(t);
    }
    Ok(record.told(&loaded, (&channels, &quantities), actuators))
}

/// The motions and actuators: own drives, motions in whose place they stand, then joints that act besides.
fn channels(
    model: &mut Model,
    motions: &[Motion],
    named: &[String],
) -> Result<Vec<Channel>, AnalysisError> {
    let measure_of = |drive: &ModelDrive| Measure::JointPosition(drive.joint, drive.motion_idx);
    // A drive that is there already goes.
    model.drives.retain(|drive| !motions.iter().any(|m| m.measure == measure_of(drive)));
    let own = model.drives.iter().map(|drive| (drive.name.clone(), measure_of(drive)));
    let joint_name = |m: &Motion| match m.measure {
        Measure::JointPosition(joint, _) => model.joints[joint.0].name.clone(),
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
        let measure = [format!("{name}.angle"), format!("{name}.position"), name.clone()];
        let measure = measure.iter().find_map(|name| driven(model, name).ok());
        let unknown = || AnalysisError::UnknownMeasure { name: name.clone() };
        let measure = measure.filter(|&m| is_joint(m)).ok_or_else(unknown)?;
        match channels.iter_mut().find(|c| c.measure == measure) {
            Some(channel) => channel.drive_idx = Some(0),
            None => channels.push(Channel {
                name: name.clone(),
                measure,
                is_prescribed: false,
                drive_idx: Some(0),
            }),
        }
    }
    Ok(channels)
}

/// States where the motions begin: drives of joints, values of other measures.
fn prescribe_start(model: &mut Model, motions: &[Motion], from: f64) {
    model.solve.t_start = from;
    for motion in motions {
        let start = model.pool.float((motion.law)(from)[0]);
        match motion.measure {
            Measure::JointPosition(joint, motion_idx) => {
                let (span, name) = {
                    let of = &model.joints[joint.0];
                    (of.span.clone(), of.name.clone())
                };
                model.drives.push(ModelDrive { name, joint, motion_idx, motion: start, span });
            }
            measure => {
                model.initial.retain(|initial| initial.measure != measure);
                let (name, span) = (motion.name.clone(), 0..0);
                model.initial.push(Initial { measure, value: start, is_guess: false, name, span });
            }
        }
    }
    // What is stated of a driven joint would be stated twice.
    let is_driven = |measure: Measure| {
        model.drives.iter().any(|d| {
            measure == Measure::JointPosition(d.joint, d.motion_idx)
                || measure == Measure::JointVelocity(d.joint, d.motion_idx)
        })
    };
    model.initial.retain(|initial| !is_driven(initial.measure));
    let is_motion = |measure: Measure| motions.iter().any(|m| m.measure == measure);
    for initial in model.initial.iter_mut().filter(|initial| !is_motion(initial.measure)) {
        initial.is_guess = true;
    }
}

/// Gives the model of the forces a drive for each actuator, and no others.
fn act(model: &mut Model, channels: &mut [Channel]) {
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

fn quantities(loaded: &Loaded, channels: &[Channel]) -> Vec<PoseQuantity> {
    let model = loaded.model();
    let quantity = |channel: &Channel| PoseQuantity {
        names: [channel.name.clone(), String::new(), String::new()],
        unit: channel.measure.unit(model),
        value: loaded.system().kinematics.measure(model, channel.measure),
    };
    channels.iter().map(quantity).collect()
}

fn actuation(
    loaded: &Loaded,
    channels: &[Channel],
    quantities: &[PoseQuantity],
    limits: &[EffortLimit],
) -> Result<Actuation, AnalysisError> {
    let system = loaded.system();
    let is_acting =
        |&k: &usize| matches!(system.constraints[loaded.kept[k]].source, Source::Drive(_));
    let (acting, bearing): (Vec<usize>, Vec<usize>) = (0..loaded.kept.len()).partition(is_acting);
    let actuators = || channels.iter().zip(quantities).filter(|(c, _)| c.drive_idx.is_some());
    for limit in limits {
        if !actuators().any(|(channel, _)| channel.name == limit.name) {
            return Err(AnalysisError::UnknownMeasure { name: limit.name.clone() });
        }
    }
    // Efforts without a limit weigh as those with the largest.
    let own = |name: &str| limits.iter().find(|l| l.name == name).map(|l| l.limit);
    let largest = limits.iter().fold(0.0, |most: f64, l| most.max(l.limit));
    let weight = |(channel, quantity): (&Channel, &PoseQuantity)| {
        let unit = if quantity.is_angle() { loaded.size } else { 1.0 };
        own(&channel.name).unwrap_or(if largest > 0.0 { largest } else { unit })
    };
    let unit_of_column = system
        .coordinates()
        .iter()
        .map(|c| if c.kind == CoordinateKind::Length { loaded.size } else { 1.0 });
    let prescribed = channels.iter().zip(quantities).filter(|(c, _)| c.is_prescribed);
    let unit_of_motion = prescribed.map(|(_, q)| if q.unit == "m" { loaded.size } else { 1.0 });
    Ok(Actuation {
        bearing,
        acting,
        weights: actuators().map(weight).collect(),
        unit_of_column: unit_of_column.collect(),
        unit_of_motion: unit_of_motion.collect(),
    })
}

/// The efforts of the actuators, in the order of their drives.
fn efforts_of(loaded: &Loaded, channels: &[Channel], lambda: &[f64]) -> Vec<f64> {
    let constraints = &loaded.system().constraints;
    let effort = |drive_idx: usize| {
        let is_own = |c: &bksim_mbs::constraint::Constraint| matches!(c.source, Source::Drive(id) if id.0 == drive_idx);
        constraints.iter().position(is_own).map_or(0.0, |row| lambda[row])
    };
    channels.iter().filter_map(|c| c.drive_idx).map(effort).collect()
}

/// Everything about the times of a motion.
#[derive(Default)]
struct Record {
    times: Vec<f64>,
    /// Value, rate and acceleration of the channels.
    shown: Vec<Vec<[f64; 3]>>,
    /// Of the actuators.
    efforts: Vec<Vec<f64>>,
    /// Of the prescribed motions.
    missing: Vec<Vec<f64>>,
    inner: Vec<DMatrix<f64>>,
    reactions: Vec<Vec<f64>>,
}

impl Record {
    fn told(
        &self,
        loaded: &Loaded,
        (channels, quantities): (&[Channel], &[PoseQuantity]),
        actuators: &Actuators,
    ) -> Inverse {
        let n_inner = self.inner.iter().map(DMatrix::ncols).max().unwrap_or(0);
        let names: Vec<&str> =
            (channels.iter().filter(|c| c.drive_idx.is_some())).map(|c| c.name.as_str()).collect();
        let limit_of = |name: &str| {
            let own = actuators.limits.iter().find(|limit| limit.name == name);
            own.map_or(f64::INFINITY, |limit| limit.limit)
        };
        let limits: Vec<f64> = names.iter().map(|name| limit_of(name)).collect();

        // The range of each effort within the limits.
        let mut impossible = Vec::new();
        let free: Vec<Option<Vec<[f64; 2]>>> = (self.times.iter().enumerate())
            .map(|(k, &t)| {
                if n_inner == 0 {
                    return None;
                }
                let found = ranges(&bounded(&self.efforts[k], &self.inner[k], &limits));
                if found.is_none() {
                    impossible.push(t);
                }
                Some(found.unwrap_or_else(|| vec![[f64::NAN; 2]; names.len()]))
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
                if n_inner > 0 {
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
        let duties = actuators.curves.iter().filter_map(|curve| duty(&table, curve));
        Inverse {
            loads: loads(&table),
            n_inner,
            missing,
            impossible,
            limits,
            duties: duties.collect(),
            table,
        }
    }
}

/// Efforts with what inner forces may add to them.
fn bounded(efforts: &[f64], inner: &DMatrix<f64>, limits: &[f64]) -> Vec<Bounded> {
    let of = |k: usize| Bounded {
        value: efforts[k],
        slopes: inner.row(k).iter().copied().collect(),
        bounds: [-limits[k], limits[k]],
    };
    (0..efforts.len()).map(of).collect()
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

/// The operating points of an actuator beside a curve; `None` where there is no such actuator.
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
