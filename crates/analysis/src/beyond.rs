//! Stops and contacts that an answer about positions does not keep to.

use bksim_expr::Expr;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{LoadId, Measure, Model};

use crate::curve::Curve;
use crate::error::AnalysisError;
use crate::path::Path;
use crate::positions::Positions;
use crate::scalar::Scalars;
use crate::trace::Trace;

/// Penetration that is rounding, rad or parts of the longest link.
const CLOSED: f64 = 1e-9;

/// One end of the motion of a joint.
#[derive(Debug)]
pub(crate) struct Limit {
    /// The stop.
    pub(crate) load: LoadId,
    pub(crate) joint: String,
    /// 1 rad or the longest link.
    pub(crate) unit: f64,
    /// 1 of the upper end, −1 of the lower one, of a turn; else 0.
    turn: f64,
    /// φ, rad or m: negative while there is a gap.
    pub(crate) depth: Expr,
}

/// Both ends of every stop of the model whose limits follow from the pose; those that are latched or sampled hold none by
/// themselves.
pub(crate) fn limits(positions: &Positions) -> Vec<Limit> {
    let (model, system) = (positions.model(), positions.system());
    let pool = &model.pool;
    let measure = |measure: Measure| system.kinematics.measure(model, measure);
    let known: Vec<_> = model.signals.iter().map(|s| (s.symbol, measure(s.measure))).collect();
    let mut found = Vec::new();
    for (idx, load) in model.loads.iter().enumerate() {
        let (Some((joint, motion_idx)), Some([min, max])) =
            (load.kind.joint_motion(), load.kind.limits())
        else {
            continue;
        };
        let position = measure(Measure::JointPosition(joint, motion_idx));
        let is_turn = model.joints[joint.0].kind.turns(motion_idx);
        let unit = if is_turn { 1.0 } else { positions.size };
        let ends = [(-1.0, min), (1.0, max)];
        for (end, limit) in ends.into_iter().filter_map(|(end, limit)| Some((end, limit?))) {
            let depth =
                if end < 0.0 { pool.sub(limit, position) } else { pool.sub(position, limit) };
            let depth = pool.substitute_all(&[depth], &known)[0];
            let joint = model.joints[joint.0].name.clone();
            let turn = if is_turn { end } else { 0.0 };
            found.push(Limit { load: LoadId(idx), joint, unit, turn, depth });
        }
    }
    let parameters = &positions.mechanism.parameters;
    found.retain(|limit| Scalars::compile(model, system, &[limit.depth], parameters).is_ok());
    found
}

/// φ of all of these.
pub(crate) fn depths(
    (model, system): (&Model, &SymbolicSystem),
    limits: &[Limit],
    parameters: &[f64],
) -> Result<Scalars, AnalysisError> {
    let functions: Vec<Expr> = limits.iter().map(|limit| limit.depth).collect();
    Ok(Scalars::compile(model, system, &functions, parameters)?)
}

/// The stops that poses lie beyond.
pub(crate) struct Beyond {
    limits: Vec<Limit>,
    depths: Scalars,
    passed: Vec<bool>,
}

impl Beyond {
    pub(crate) fn of(positions: &Positions) -> Result<Self, AnalysisError> {
        let limits = limits(positions);
        let parts = (positions.model(), positions.system());
        let depths = depths(parts, &limits, &positions.mechanism.parameters)?;
        Ok(Self { passed: vec![false; limits.len()], limits, depths })
    }

    /// Looks at a pose; an angle is beyond a stop if it is in every turn.
    pub(crate) fn look(&mut self, t: f64, q: &[f64]) {
        if self.limits.is_empty() {
            return;
        }
        let depths = self.depths.values(t, q);
        for (k, limit) in self.limits.iter().enumerate() {
            let own = |k: &usize| self.limits[*k].load == limit.load;
            let is_before = |turns: f64| {
                let turned = turns * std::f64::consts::TAU;
                let mut ends = (0..depths.len()).filter(own);
                ends.all(|k| {
                    let of = &self.limits[k];
                    depths[k] + of.turn * turned <= CLOSED * of.unit
                })
            };
            let turns: &[f64] = if limit.turn == 0.0 { &[0.0] } else { &[0.0, -1.0, 1.0] };
            self.passed[k] |= !turns.iter().any(|turns| is_before(*turns));
        }
    }

    /// Looks at all poses of curves.
    pub(crate) fn along(&mut self, curve: &Curve<Path<'_>>, traces: &[Trace]) {
        let (rows, law) = (&curve.equations.rows, &curve.equations);
        let n = rows.unit_of_column.len();
        for point in traces.iter().flat_map(|trace| &trace.points) {
            self.look(law.time(0.0), &rows.unscaled(&point.z.as_slice()[..n]));
        }
    }

    /// The stops that poses lie beyond, and the contacts, which no position keeps to.
    pub(crate) fn names(&self, model: &Model) -> Vec<String> {
        let limits = self.limits.iter().zip(&self.passed).filter(|(_, passed)| **passed);
        let mut names: Vec<String> =
            limits.map(|(limit, _)| format!("stop `{}`", model.loads[limit.load.0].name)).collect();
        names.dedup();
        names.extend(model.contacts.iter().map(|contact| format!("contact `{}`", contact.name)));
        names
    }
}
