//! The elimination and its solutions written down: as expressions, and as arithmetic of a tape.

use bksim_expr::{Composition, Expr, Pool, Value};

use super::{Elimination, Run};

impl Elimination {
    /// The elimination and the solution for one right side, carried out with expressions: the
    /// solution, coordinates first, and the factors for [`Elimination::take`].
    pub(crate) fn with_expressions(
        &self,
        pool: &Pool,
        (mass, jacobian): (&[Expr], &[Expr]),
        right_side: Vec<Expr>,
    ) -> (Vec<Expr>, Vec<Expr>) {
        // The factors.
        let n = self.order.nodes.len();
        let mut values = vec![pool.zero(); self.values.len()];
        for (&slot, &value) in self.order.slots.iter().zip(mass.iter().chain(jacobian)) {
            values[slot] = value;
        }
        let mut next = 0;
        let mut inverses = Vec::with_capacity(n);
        for k in 0..n {
            let inverse = pool.powi(values[k], -1);
            let (from, to) = (n + self.order.starts[k], n + self.order.starts[k + 1]);
            for j in from..to {
                let factor = pool.mul(values[j], inverse);
                let mut update = |target: usize, i: usize| {
                    values[target] = pool.sub(values[target], pool.mul(factor, values[i]));
                };
                update(self.order.rows[j - n], j);
                let mut i = j + 1;
                while i < to {
                    let Run { target, length } = self.order.runs[next];
                    (0..length).for_each(|offset| update(to + target + offset, i + offset));
                    i += length;
                    next += 1;
                }
            }
            values[from..to].iter_mut().for_each(|l| *l = pool.mul(*l, inverse));
            inverses.push(inverse);
        }

        // Solutions with L, then with D Lᵀ.
        let mut x: Vec<Expr> = self.order.nodes.iter().map(|&node| right_side[node]).collect();
        for k in 0..n {
            for p in self.order.starts[k]..self.order.starts[k + 1] {
                let row = self.order.rows[p];
                x[row] = pool.sub(x[row], pool.mul(values[n + p], x[k]));
            }
        }
        for k in (0..n).rev() {
            let below = (self.order.starts[k]..self.order.starts[k + 1])
                .map(|p| pool.mul(values[n + p], x[self.order.rows[p]]));
            let below: Vec<Expr> = below.collect();
            x[k] = pool.sub(pool.mul(x[k], inverses[k]), pool.sum(below));
        }
        let mut solution = right_side;
        self.order.nodes.iter().zip(x).for_each(|(&node, x)| solution[node] = x);
        values.pop();
        (solution, values)
    }

    /// [`Elimination::solve_in_place`] written down, with these factors: the first nq numbers of the solution for a
    /// right side that is zero but in its multipliers.
    pub(crate) fn record_step(
        &self,
        recorder: &mut Composition,
        factors: &[Value],
        of_multipliers: &[Value],
    ) -> Vec<Value> {
        let n = self.order.nodes.len();
        let (diagonal, lower) = factors.split_at(n);
        let right = |&node: &usize| node.checked_sub(self.order.nq).map(|row| of_multipliers[row]);
        // Nothing stands for zero.
        let mut x: Vec<Option<Value>> = self.order.nodes.iter().map(right).collect();
        let subtract_product = |recorder: &mut Composition, x, l, y| {
            let product = recorder.multiply(l, y);
            recorder.subtract(x, product)
        };
        for k in 0..n {
            let Some(value) = x[k] else { continue };
            for p in self.order.starts[k]..self.order.starts[k + 1] {
                let row = &mut x[self.order.rows[p]];
                let before = row.unwrap_or_else(|| recorder.constant(0.0));
                *row = Some(subtract_product(recorder, before, lower[p], value));
            }
        }
        for k in (0..n).rev() {
            let mut value = x[k].map(|x| recorder.divide(x, diagonal[k]));
            for p in self.order.starts[k]..self.order.starts[k + 1] {
                let Some(x) = x[self.order.rows[p]] else { continue };
                let before = value.unwrap_or_else(|| recorder.constant(0.0));
                value = Some(subtract_product(recorder, before, lower[p], x));
            }
            x[k] = value;
        }
        let mut solution = vec![recorder.constant(0.0); self.order.nq];
        for (&node, x) in self.order.nodes.iter().zip(x) {
            if let (Some(place), Some(x)) = (solution.get_mut(node), x) {
                *place = x;
            }
        }
        solution
    }
}
