//! The elimination and its solutions written down as arithmetic of a tape.

use std::iter;

use bksim_expr::{Composition, Value};

use super::{Elimination, Order, Run};

impl Elimination {
    /// The elimination and the solution for one right side written down: the solution, coordinates first, and the
    /// factors for [`Elimination::take`].
    ///
    /// Each pivot is divided by once, and no quotient waits for the right side: the solution takes a product and a
    /// difference for each row above its own, on the way down and on the way back.
    pub(crate) fn record(
        &self,
        recorder: &mut Composition,
        (mass, jacobian): (&[Value], &[Value]),
        right_side: &[Value],
    ) -> (Vec<Value>, Vec<Value>) {
        let Order { nodes, starts, rows, runs, slots, .. } = &*self.order;
        let n = nodes.len();
        let (zero, one) = (recorder.constant(0.0), recorder.constant(1.0));
        let mut values = vec![zero; self.values.len()];
        for (&slot, &value) in slots.iter().zip(mass.iter().chain(jacobian)) {
            values[slot] = value;
        }

        // The factors: of each entry first what it is diminished by.
        let mut diminished: Vec<Vec<Value>> = vec![Vec::new(); values.len()];
        let mut inverses = Vec::with_capacity(n);
        let mut next = 0;
        for k in 0..n {
            let (from, to) = (n + starts[k], n + starts[k + 1]);
            for entry in iter::once(k).chain(from..to) {
                values[entry] = recorder.signed_sum(&[values[entry]], &diminished[entry]);
            }
            let inverse = recorder.divide(one, values[k]);
            for j in from..to {
                let factor = recorder.multiply(values[j], inverse);
                let mut update = |target: usize, i: usize| {
                    diminished[target].push(recorder.multiply(factor, values[i]));
                };
                update(rows[j - n], j);
                let mut i = j + 1;
                while i < to {
                    let Run { target, length } = runs[next];
                    (0..length).for_each(|offset| update(to + target + offset, i + offset));
                    i += length;
                    next += 1;
                }
                // Nothing reads the entry itself after its own update.
                values[j] = factor;
            }
            inverses.push(inverse);
        }
        values.truncate(n + rows.len());

        // The solution with L, then with D Lᵀ.
        let lower = &values[n..];
        let mut diminished: Vec<Vec<Value>> = vec![Vec::new(); n];
        let mut x: Vec<Value> = nodes.iter().map(|&node| right_side[node]).collect();
        for k in 0..n {
            x[k] = recorder.signed_sum(&[x[k]], &diminished[k]);
            for p in starts[k]..starts[k + 1] {
                diminished[rows[p]].push(recorder.multiply(lower[p], x[k]));
            }
        }
        for k in (0..n).rev() {
            let own = recorder.multiply(x[k], inverses[k]);
            let products = (starts[k]..starts[k + 1]).map(|p| (lower[p], x[rows[p]]));
            let products: Vec<Value> = products.map(|(l, x)| recorder.multiply(l, x)).collect();
            x[k] = recorder.signed_sum(&[own], &products);
        }
        let mut solution = right_side.to_vec();
        nodes.iter().zip(x).for_each(|(&node, x)| solution[node] = x);
        (solution, values)
    }

    /// [`Elimination::solve_in_place`] written down, with these factors, for a right side that is zero but in its
    /// multipliers.
    pub(crate) fn record_step(
        &self,
        recorder: &mut Composition,
        factors: &[Value],
        of_multipliers: &[Value],
    ) -> Vec<Value> {
        let mut right_side = vec![None; self.order.nq];
        right_side.extend(of_multipliers.iter().copied().map(Some));
        self.record_solution(recorder, factors, &right_side)
    }

    /// Records the solution for any right side, coordinates first; nothing stands for zero.
    pub(crate) fn record_solution(
        &self,
        recorder: &mut Composition,
        factors: &[Value],
        right_side: &[Option<Value>],
    ) -> Vec<Value> {
        let n = self.order.nodes.len();
        let (diagonal, lower) = factors.split_at(n);
        let one = recorder.constant(1.0);
        let mut x: Vec<Option<Value>> =
            self.order.nodes.iter().map(|&node| right_side[node]).collect();
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
            let mut value = x[k].map(|x| {
                let inverse = recorder.divide(one, diagonal[k]);
                recorder.multiply(x, inverse)
            });
            for p in self.order.starts[k]..self.order.starts[k + 1] {
                let Some(x) = x[self.order.rows[p]] else { continue };
                let before = value.unwrap_or_else(|| recorder.constant(0.0));
                value = Some(subtract_product(recorder, before, lower[p], x));
            }
            x[k] = value;
        }
        let mut solution = vec![recorder.constant(0.0); n];
        for (&node, x) in self.order.nodes.iter().zip(x) {
            solution[node] = x.unwrap_or(solution[node]);
        }
        solution
    }
}
