//! The functions whose evaluation is timed: residual and Jacobian of three mechanisms.
//!
//! ```text
//! r = M a + h + ∂V/∂q − Q + Gᵀ λ      nq
//! g(q) = 0                            nc
//! ```
//!
//! Inputs are q, v, a, λ, one after the other. Outputs are r, then g, then the entries of ∂r/∂q,
//! ∂r/∂v, the lower triangle of M, and G that are not identically zero, each row by row.

use bksim_expr::{Expr, Pool, SymbolId, Tape};
use bksim_mbs::assemble::assemble;
use serde_json::{Value, json};

use crate::error::BenchError;
use crate::models;

/// Equations of motion, with all that the peers need to compute the same.
#[derive(Debug)]
pub(crate) struct System {
    /// Name of the mechanism and of its C source.
    pub(crate) name: &'static str,
    q: Vec<SymbolId>,
    v: Vec<SymbolId>,
    a: Vec<SymbolId>,
    lambda: Vec<SymbolId>,
    parameters: Vec<(SymbolId, f64)>,
    /// A possible configuration, around which points are drawn.
    pose: Vec<f64>,
    residual: Vec<Expr>,
    constraints: Vec<Expr>,
    mass: Vec<(usize, usize, Expr)>,
    constraint_jacobian: Vec<(usize, usize, Expr)>,
    pool: Pool,
}

/// The outputs, with the entries of their blocks.
#[derive(Debug)]
pub(crate) struct Outputs {
    /// All outputs in order.
    pub(crate) all: Vec<Expr>,
    /// Row and column of each entry of ∂r/∂q, ∂r/∂v, M and G.
    pub(crate) entries: [Vec<(usize, usize)>; 4],
}

/// Equations as text, for [`System::parsed`].
pub(crate) struct Texts<'a> {
    /// Names of the coordinates; rates append `_v`, accelerations `_a`; multipliers are `l1`, ….
    pub(crate) coordinates: &'a [(&'a str, f64)],
    /// Names and values of the parameters.
    pub(crate) parameters: &'a [(&'a str, f64)],
    /// Abbreviations in later texts; each may contain those before it.
    pub(crate) abbreviations: &'a [(&'a str, &'a str)],
    /// Lower triangle of M: row, column, entry.
    pub(crate) mass: &'a [(usize, usize, &'a str)],
    /// f of M a = f − Gᵀλ.
    pub(crate) force: &'a [&'a str],
    /// g.
    pub(crate) constraints: &'a [&'a str],
}

impl System {
    /// The equations of a model, its coordinates in the order of `pose`.
    pub(crate) fn assembled(
        name: &'static str,
        text: &str,
        pose: &[(&str, f64)],
    ) -> Result<Self, BenchError> {
        // The order of our coordinates that `pose` gives.
        let model = models::model(text, name)?;
        let equations = assemble(&model);
        let coordinates = equations.coordinates();
        let order: Vec<usize> = pose
            .iter()
            .map(|(name, _)| coordinates.iter().position(|c| c.name == *name))
            .collect::<Option<_>>()
            .ok_or(BenchError::Data("coordinates of the model"))?;

        // G and M in that order, and r row by row.
        let pool = &model.pool;
        let zero = pool.zero();
        let g = |row: usize, column: usize| {
            equations.constraint_jacobian.get(row, order[column]).unwrap_or(zero)
        };
        let m = |row: usize, column: usize| {
            equations.mass_matrix.get(order[row], order[column]).unwrap_or(zero)
        };
        let lambda: Vec<SymbolId> = equations.constraints.iter().map(|c| c.lambda).collect();
        let (nq, nc) = (order.len(), lambda.len());
        let row = |i: usize| {
            let own = order[i];
            let inertia = (0..nq).map(|j| {
                let a = pool.symbol_expr(coordinates[order[j]].a);
                pool.mul(m(i, j), a)
            });
            let reaction = (0..nc).map(|k| pool.mul(g(k, i), pool.symbol_expr(lambda[k])));
            let applied = pool.neg(equations.applied_force[own]);
            let others = [equations.bias[own], equations.potential_gradient[own], applied];
            pool.sum(inertia.chain(reaction).chain(others).collect::<Vec<_>>())
        };

        // All blocks of the outputs.
        let residual = (0..nq).map(row).collect();
        let constraints = equations.constraints.iter().map(|c| c.expression).collect();
        let lower = (0..nq).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let mass = lower.map(|(i, j)| (i, j, m(i, j))).collect();
        let cells = (0..nc).flat_map(|k| (0..nq).map(move |j| (k, j)));
        let constraint_jacobian = cells.map(|(k, j)| (k, j, g(k, j))).collect();
        Ok(Self {
            name,
            q: order.iter().map(|&i| coordinates[i].q).collect(),
            v: order.iter().map(|&i| coordinates[i].v).collect(),
            a: order.iter().map(|&i| coordinates[i].a).collect(),
            parameters: model.parameters.iter().map(|p| (p.symbol, p.value)).collect(),
            pose: pose.iter().map(|&(_, value)| value).collect(),
            lambda,
            residual,
            constraints,
            mass,
            constraint_jacobian,
            pool: model.pool,
        })
    }

    /// A system given in text; G is differentiated from g.
    pub(crate) fn parsed(name: &'static str, texts: &Texts<'_>) -> Result<Self, BenchError> {
        // Symbols of the state and the multipliers.
        let pool = Pool::new();
        let named =
            |name: &str| pool.symbol_id(pool.symbol(name)).expect("a symbol has an identity");
        let all = |suffix: &str| -> Vec<SymbolId> {
            let names = texts.coordinates.iter().map(|(name, _)| format!("{name}{suffix}"));
            names.map(|name| named(&name)).collect()
        };
        let (q, v, a) = (all(""), all("_v"), all("_a"));
        let nc = texts.constraints.len();
        assert_eq!(q.len(), texts.force.len(), "one force per coordinate");
        let lambda: Vec<SymbolId> = (1..=nc).map(|k| named(&format!("l{k}"))).collect();

        // Formulas without abbreviations.
        let mut known: Vec<(SymbolId, Expr)> = Vec::new();
        for (name, text) in texts.abbreviations {
            let e = pool.substitute(pool.parse(text)?, &known);
            known.push((named(name), e));
        }
        let read = |text: &&str| -> Result<Expr, BenchError> {
            Ok(pool.substitute(pool.parse(text)?, &known))
        };
        let force: Vec<Expr> = texts.force.iter().map(read).collect::<Result<_, _>>()?;
        let constraints: Vec<Expr> =
            texts.constraints.iter().map(read).collect::<Result<_, _>>()?;
        let constraint_jacobian = pool.jacobian(&constraints, &q).entries;
        let mut mass = Vec::new();
        for (i, j, text) in texts.mass {
            mass.push((*i, *j, read(text)?));
        }

        // r = M a − f + Gᵀλ, row by row.
        let mut rows: Vec<Vec<Expr>> = force.iter().map(|&f| vec![pool.neg(f)]).collect();
        for &(i, j, m) in &mass {
            rows[i].push(pool.mul(m, pool.symbol_expr(a[j])));
            if i != j {
                rows[j].push(pool.mul(m, pool.symbol_expr(a[i])));
            }
        }
        for &(k, j, g) in &constraint_jacobian {
            rows[j].push(pool.mul(g, pool.symbol_expr(lambda[k])));
        }
        let residual = rows.into_iter().map(|terms| pool.sum(terms)).collect();
        let parameters = texts.parameters.iter().map(|&(name, value)| (named(name), value));
        let parameters = parameters.collect();
        let pose = texts.coordinates.iter().map(|&(_, value)| value).collect();
        Ok(Self {
            name,
            q,
            v,
            a,
            lambda,
            parameters,
            pose,
            residual,
            constraints,
            mass,
            constraint_jacobian,
            pool,
        })
    }

    /// The outputs of the timed function.
    pub(crate) fn outputs(&self) -> Outputs {
        let pool = &self.pool;
        let nonzero = |entries: &[(usize, usize, Expr)]| -> Vec<(usize, usize, Expr)> {
            entries.iter().filter(|entry| !pool.is_zero(entry.2)).copied().collect()
        };
        let blocks = [
            pool.jacobian(&self.residual, &self.q).entries,
            pool.jacobian(&self.residual, &self.v).entries,
            nonzero(&self.mass),
            nonzero(&self.constraint_jacobian),
        ];
        let mut all: Vec<Expr> = self.residual.iter().chain(&self.constraints).copied().collect();
        all.extend(blocks.iter().flatten().map(|entry| entry.2));
        let entries = blocks.map(|block| block.into_iter().map(|(i, j, _)| (i, j)).collect());
        Outputs { all, entries }
    }

    /// Number of inputs: q, v, a, λ.
    pub(crate) fn n_inputs(&self) -> usize {
        3 * self.q.len() + self.lambda.len()
    }

    /// Compiles all outputs.
    pub(crate) fn tape(&self, outputs: &Outputs) -> Result<Tape, BenchError> {
        let inputs = [&self.q[..], &self.v, &self.a, &self.lambda].concat();
        let parameters: Vec<SymbolId> = self.parameters.iter().map(|p| p.0).collect();
        Ok(Tape::compile(&self.pool, &outputs.all, &inputs, &parameters)?)
    }

    /// Values of the parameters.
    pub(crate) fn parameter_values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.1).collect()
    }

    /// Points around the pose, one after the other: always the same ones.
    pub(crate) fn points(&self, n_points: usize) -> Vec<f64> {
        let mut noise = noise();
        let mut points = Vec::with_capacity(n_points * self.n_inputs());
        for _ in 0..n_points {
            points.extend(self.pose.iter().map(|q| q + 0.2 * noise()));
            points.extend((self.pose.len()..self.n_inputs()).map(|_| 4.0 * noise()));
        }
        points
    }

    /// Input of a peer: sizes, the entries of the outputs, the parameters by name, and all outputs
    /// as formulas of the inputs.
    pub(crate) fn to_json(&self, outputs: &Outputs) -> Value {
        let mut values: Vec<(SymbolId, Expr)> =
            self.parameters.iter().map(|&(s, value)| (s, self.pool.float(value))).collect();
        // Plain names that have no other meaning in any system.
        let inputs = [&self.q[..], &self.v, &self.a, &self.lambda].concat();
        let names: Vec<String> = (0..inputs.len()).map(|i| format!("in{i}")).collect();
        values.extend(inputs.iter().zip(&names).map(|(&s, name)| (s, self.pool.symbol(name))));
        let texts: Vec<String> = self
            .pool
            .substitute_all(&outputs.all, &values)
            .into_iter()
            .map(|e| self.pool.to_text(e))
            .collect();
        let parameters: serde_json::Map<String, Value> = self
            .parameters
            .iter()
            .map(|&(s, value)| (self.pool.symbol_name(s), json!(value)))
            .collect();
        json!({
            "name": self.name, "nq": self.q.len(), "nc": self.lambda.len(), "inputs": names,
            "entries": outputs.entries, "parameters": parameters, "texts": texts,
        })
    }
}

/// Numbers between −½ and ½, always the same ones.
pub(super) fn noise() -> impl FnMut() -> f64 {
    let mut state: u64 = 0x9E37_79B9_7F4A_7C15;
    move || {
        // A linear congruential generator (Knuth's constants); its high bits are good enough.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}
