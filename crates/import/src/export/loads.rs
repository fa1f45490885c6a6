//! Loads in joints and between them, and relations, as far as a format holds them.

use bksim_expr::{Expr, SymbolId};
use bksim_model::diagnostic::Span;
use bksim_model::{FrictionLaw, LoadKind, Measure, Model};

use crate::Format;

use super::numbers::Numbers;
use super::parts::{MAX_POWER, Mimic, Motor, Report, Robot, Tendon, axis_name};

impl Robot {
    /// Puts everything that acts where the format has it; lists the rest.
    pub(super) fn add_loads(&mut self, model: &Model, format: Format, report: &mut Report) {
        for load in &model.loads {
            if !self.has_taken(model, &load.name, &load.kind, (format, &load.span, report)) {
                let what = format!("load {}", load.name);
                if report.left_out.last().is_none_or(|(last, _)| *last != what) {
                    report.leave_out(what, &load.span);
                }
            }
        }
        for coupling in &model.couplings {
            let relation = polynomial(model, coupling.relation, |measure| {
                self.motion_of(model, format, measure)
            });
            let free = relation
                .into_iter()
                .find(|(of, ..)| self.mimics.iter().all(|known| known.of != *of));
            let is_affine = |c: &[f64]| c[2..].iter().all(|c| *c == 0.0);
            match free {
                Some((of, by, coefficients))
                    if format == Format::Mjcf || (by.is_some() && is_affine(&coefficients)) =>
                {
                    let name = coupling.name.clone();
                    self.mimics.push(Mimic { name, of, by, coefficients });
                }
                _ => report.leave_out(format!("coupling {}", coupling.name), &coupling.span),
            }
        }
        for drive in &model.drives {
            report.leave_out(format!("drive {}, a stated motion", drive.name), &drive.span);
        }
    }

    /// The name and sign of the motion that a measure is, if the file has it as a coordinate.
    fn motion_of(&self, model: &Model, format: Format, measure: Measure) -> Option<(String, f64)> {
        let (joint, motion, sign) = match measure {
            Measure::JointPosition(joint, motion) => (joint, motion, 1.0),
            Measure::Turn(body, against, joint) => {
                let of = &model.joints[joint.0];
                let ends = (of.successor.body, of.predecessor.body);
                let sign = if ends == (body, against) { 1.0 } else { -1.0 };
                if ends != (body, against) && ends != (against, body) {
                    return None;
                }
                let slides = of.kind.motions().iter();
                let turn = slides.take_while(|kind| **kind == bksim_model::MotionKind::Translation);
                (joint, turn.count(), sign)
            }
            _ => return None,
        };
        let of = &model.joints[joint.0];
        let name = axis_name(of, of.kind.motions().len() == 1, motion);
        let connection = self.connections.iter().find(|known| known.joint == Some(joint.0))?;
        let is_open = !connection.is_loop || format == Format::Sdf;
        let is_there = connection.axes.iter().any(|axis| axis.name == name);
        (is_open && is_there).then_some((name, sign))
    }

    /// True if a load is in the file.
    fn has_taken(
        &mut self,
        model: &Model,
        name: &str,
        kind: &LoadKind,
        (format, span, report): (Format, &Span, &mut Report),
    ) -> bool {
        let numbers = Numbers(model);
        let (joint, motion) = match *kind {
            LoadKind::Gravity { acceleration } => {
                let Some(acceleration) = numbers.vector(acceleration) else { return false };
                let is_usual = acceleration == crate::urdf::GRAVITY;
                return format != Format::Urdf || is_usual;
            }
            LoadKind::Spring { a, b, stiffness, length, damping } => {
                let frames = numbers.frame(a).zip(numbers.frame(b));
                let values = [stiffness, length, damping].map(|value| numbers.value(value));
                let (
                    Format::Mjcf,
                    Some((first, second)),
                    [Some(stiffness), Some(length), Some(damping)],
                ) = (format, frames, values)
                else {
                    return false;
                };
                let ends = [(a.body.0, first.at), (b.body.0, second.at)];
                self.tendons.push(Tendon {
                    name: name.to_owned(),
                    ends,
                    stiffness,
                    length,
                    damping,
                });
                return true;
            }
            _ => match kind.joint_motion() {
                Some(motion) => motion,
                None => return false,
            },
        };
        let Some((of, _)) = self.motion_of(model, format, Measure::JointPosition(joint, motion))
        else {
            return false;
        };
        let Some(axis) = self.axis_mut(joint.0, &of) else { return false };
        match *kind {
            LoadKind::JointSpring { stiffness, unloaded, damping, .. } => {
                let values = [stiffness, unloaded, damping].map(|value| numbers.value(value));
                let [Some(stiffness), Some(rest), Some(damping)] = values else { return false };
                axis.damping += damping;
                if format == Format::Urdf && stiffness != 0.0 {
                    report.leave_out(format!("stiffness of load {name}"), span);
                } else if stiffness != 0.0 {
                    let sum = axis.stiffness + stiffness;
                    axis.rest = (axis.stiffness * axis.rest + stiffness * rest) / sum;
                    axis.stiffness = sum;
                }
            }
            LoadKind::Stop { min, max, restitution, .. } => {
                let limits = [min, max].map(|limit| limit.map(|limit| numbers.value(limit)));
                if limits.contains(&Some(None)) || axis.limits.is_some() {
                    return false;
                }
                axis.limits = Some(limits.map(Option::flatten));
                if numbers.value(restitution) != Some(0.0) {
                    report.leave_out(format!("restitution of stop {name}"), span);
                }
            }
            LoadKind::Friction { law: FrictionLaw::Stated { sliding, sticking }, .. } => {
                let Some(value) = numbers.value(sliding) else { return false };
                axis.friction += value;
                if numbers.value(sticking) != Some(value) {
                    report.leave_out(format!("sticking of friction {name}"), span);
                }
            }
            LoadKind::Effort { value, .. } if format == Format::Mjcf => {
                let Some(gear) = gain(model, value) else { return false };
                self.motors.push(Motor { name: name.to_owned(), on: of, gear });
            }
            _ => return false,
        }
        true
    }
}

/// The factor of an input in an effort that is this multiple of it.
fn gain(model: &Model, effort: Expr) -> Option<f64> {
    let numbers = Numbers(model);
    let inputs = model.io.inputs.iter();
    let mut symbols = inputs.filter_map(|name| model.parameters.iter().find(|p| p.name == *name));
    let input = symbols.find(|p| model.pool.depends_on(effort, p.symbol))?;
    let slope = model.pool.diff(effort, input.symbol);
    let (factor, value) = (numbers.value(slope)?, numbers.value(effort)?);
    let is_multiple = (value - factor * input.value).abs() <= 1e-12 * value.abs();
    let is_straight = !model.pool.depends_on(slope, input.symbol);
    (is_straight && is_multiple && factor != 0.0).then_some(factor)
}

/// A relation solved for one of its two motions: the one that follows, the one that leads, coefficients.
type Solved = (String, Option<String>, [f64; MAX_POWER + 1]);

/// The ways in which a relation is y = c₀ + c₁ x + …, by what `motion` calls its measures.
fn polynomial(
    model: &Model,
    relation: Expr,
    motion: impl Fn(Measure) -> Option<(String, f64)>,
) -> Vec<Solved> {
    let pool = &model.pool;
    let used = model.signals.iter().filter(|signal| pool.depends_on(relation, signal.symbol));
    let used: Option<Vec<(SymbolId, (String, f64))>> =
        used.map(|signal| Some((signal.symbol, motion(signal.measure)?))).collect();
    let Some(used) = used else { return Vec::new() };
    let value_at_zero = |e: Expr| {
        let of = |symbol: SymbolId| {
            let is_motion = used.iter().any(|(known, _)| *known == symbol);
            let known = model.parameters.iter().find(|parameter| parameter.symbol == symbol);
            known.map(|parameter| parameter.value).or(is_motion.then_some(0.0))
        };
        pool.evaluate(e, &of).ok().filter(|value| value.is_finite())
    };
    let slope = |y: usize| Numbers(model).value(pool.diff(relation, used[y].0));
    let solved = |y: usize, x: Option<usize>| -> Option<Solved> {
        let (_, (of, y_sign)) = &used[y];
        let slope = slope(y).filter(|slope| *slope != 0.0)?;
        let mut coefficients = [0.0; MAX_POWER + 1];
        let (mut derivative, mut factorial, mut sign) = (relation, 1.0, *y_sign);
        for (power, coefficient) in coefficients.iter_mut().enumerate() {
            *coefficient = -value_at_zero(derivative)? * sign / (slope * factorial);
            let Some(x) = x else { break };
            derivative = pool.diff(derivative, used[x].0);
            factorial *= f64::from(u32::try_from(power).unwrap_or(u32::MAX)) + 1.0;
            sign *= used[x].1.1;
        }
        // What is left after the highest power must be nothing at all.
        let is_whole = x.is_none() || Numbers(model).value(derivative) == Some(0.0);
        let by = x.map(|x| used[x].1.0.clone());
        is_whole.then(|| (of.clone(), by, coefficients))
    };
    match used.len() {
        1 => solved(0, None).into_iter().collect(),
        // A relation is mostly written as y − p(x).
        2 => {
            let ways = if slope(1) == Some(1.0) { [(1, 0), (0, 1)] } else { [(0, 1), (1, 0)] };
            ways.into_iter().filter_map(|(y, x)| solved(y, Some(x))).collect()
        }
        _ => Vec::new(),
    }
}
