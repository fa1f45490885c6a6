//! Accelerations and multipliers of a small mechanism as one piece of straight-line code, from (t, q, v) to v̇ and λ.
//!
//! The elimination is carried out once with the arithmetic of a tape in place of numbers. Its unrolled steps have no
//! indices, no loops and no zeros, and become machine code together with the equations they follow.

use bksim_expr::{Composition, Tape, Value};

use crate::linear::elimination::Elimination;
use crate::linear::shape::Shape;

/// Updates of the elimination up to which straight-line code is made: beyond, translating it takes
/// longer than runs do, and loops over numbers are as fast.
const LARGEST: usize = 1000;

/// Processor cycles from the positions of a stage to its velocities: these follow from the accelerations of the stage
/// before, those from its velocities. What positions determine is known by then.
const OF_A_STAGE: u32 = 200;

/// v̇, nq, λ, nc, and the factors, see [`Elimination::take`], from M v̇ + Gᵀ λ = f, G v̇ = −γ: a function of the
/// arguments (t, q, v, …) of `terms`, which gives the entries of M and G, f and γ. `None` for a mechanism that is too
/// large, or has a coordinate without inertia of its own.
pub(crate) fn solved_with_factors(shape: &Shape, terms: &Tape) -> Option<Tape> {
    let (recorder, solution, factors) = record(shape, terms)?;
    Some(recorder.finish(&[solution, factors].concat()))
}

/// Solution without the factors.
pub(crate) fn solved(shape: &Shape, terms: &Tape) -> Option<Tape> {
    let (recorder, solution, _) = record(shape, terms)?;
    Some(recorder.finish(&solution))
}

fn record(shape: &Shape, terms: &Tape) -> Option<(Composition, Vec<Value>, Vec<Value>)> {
    let Shape { nq, nc, ref mass, ref jacobian, .. } = *shape;
    // Where bodies may touch in many places, planning all of them would take long.
    if least_updates(shape) > LARGEST {
        return None;
    }
    let rows: Vec<usize> = (0..nc).collect();
    let has_inertia = |i: usize| mass.contains(&(i, i));
    let elimination = Elimination::new(shape, &rows);
    if elimination.n_updates() > LARGEST || !(0..nq).all(has_inertia) {
        return None;
    }
    // The terms.
    let n_inputs = terms.n_inputs();
    let mut recorder = Composition::new(n_inputs, terms.n_parameters());
    (1 + nq..n_inputs).for_each(|i| recorder.delay_input(i, OF_A_STAGE));
    let arguments: Vec<Value> = (0..n_inputs).map(|i| recorder.input(i)).collect();
    let terms = recorder.call(terms, &arguments);

    // What they are the equations of.
    let (matrix, right_side) = terms.split_at(mass.len() + jacobian.len());
    let (force, gamma) = right_side.split_at(nq);
    let resisting: Vec<Value> = gamma.iter().map(|&gamma| recorder.negate(gamma)).collect();
    let right_side = [force, &resisting].concat();
    let matrix = matrix.split_at(mass.len());
    let (solution, factors) = elimination.record(&mut recorder, matrix, &right_side);
    Some((recorder, solution, factors))
}

/// Updates that an elimination of all rows has at least: every coordinate comes before all of its rows.
fn least_updates(shape: &Shape) -> usize {
    let mut n_rows = vec![0; shape.nq];
    shape.jacobian.iter().for_each(|&(_, i)| n_rows[i] += 1);
    n_rows.iter().map(|n| n * (n + 1) / 2).sum()
}
