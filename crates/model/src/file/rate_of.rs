//! Rates of expressions of positions, as expressions of signals.

use bksim_expr::{Expr, SymbolId};

use super::reader::Reader;
use crate::ids::GROUND;
use crate::measure::Measure;

impl Reader<'_> {
    /// The rate of an expression of positions.
    pub(super) fn rate_of(&mut self, expr: Expr) -> Expr {
        let used: Vec<(SymbolId, Measure)> = self
            .names
            .signals
            .iter()
            .filter(|signal| self.pool.depends_on(expr, signal.symbol))
            .map(|signal| (signal.symbol, signal.measure))
            .collect();
        let mut terms = Vec::new();
        for (symbol, position) in used {
            let name = format!("{}_rate", self.pool.symbol_name(symbol));
            for (k, (sign, rate)) in self.rates_of_position(position).into_iter().enumerate() {
                let name = if k == 0 { name.clone() } else { format!("{name}_{k}") };
                let rate = self.names.signal(&self.pool, &name, rate);
                let slope = self.pool.mul(self.pool.int(sign), self.pool.diff(expr, symbol));
                terms.push(self.pool.mul(slope, rate));
            }
        }
        self.pool.sum(terms)
    }

    /// True if every position of an expression has a rate.
    pub(super) fn has_rate(&self, expr: Expr) -> bool {
        let mut used =
            self.names.signals.iter().filter(|signal| self.pool.depends_on(expr, signal.symbol));
        used.all(|signal| !self.rates_of_position(signal.measure).is_empty())
    }

    /// The rates of which that of a position is the sum, with their signs; none where it has none.
    fn rates_of_position(&self, position: Measure) -> Vec<(i64, Measure)> {
        match position {
            Measure::PointPosition(body, point, axis) => {
                vec![(1, Measure::PointVelocity(body, point, axis))]
            }
            Measure::BodyAngle(body) => vec![(1, Measure::BodyRate(body))],
            Measure::JointPosition(joint, motion_idx) => {
                vec![(1, Measure::JointVelocity(joint, motion_idx))]
            }
            Measure::Turn(body, against, joint) => {
                let ends = self.joint_ends.get(joint.0).copied().flatten();
                let ends = ends.map(|ends| ends.map(|end| end.body));
                if ends == Some([against, body]) {
                    vec![(1, Measure::JointVelocity(joint, 0))]
                } else if ends == Some([body, against]) {
                    vec![(-1, Measure::JointVelocity(joint, 0))]
                } else if self.spatial.is_some() {
                    Vec::new()
                } else {
                    let bodies = [(1, body), (-1, against)].into_iter();
                    let moving = bodies.filter(|(_, body)| *body != GROUND);
                    moving.map(|(sign, body)| (sign, Measure::BodyRate(body))).collect()
                }
            }
            _ => Vec::new(),
        }
    }
}
