//! The coefficients against all order conditions, written as rooted trees.

use super::coefficients::{A, C, D, E3, E5, N_EXTENDED, N_STAGES, Term};
use crate::dense::ContinuousExtension;

/// A rooted tree: the subtrees of its root, each by its index in the list of all trees.
type Tree = Vec<usize>;

/// All rooted trees with up to `order` nodes, by ascending order, with their orders.
fn trees(order: usize) -> Vec<(Tree, usize)> {
    let mut all: Vec<(Tree, usize)> = vec![(Vec::new(), 1)];
    for size in 2..=order {
        let known = all.clone();
        let mut found = Vec::new();
        extend(&known, size - 1, 0, &mut Vec::new(), &mut found);
        all.extend(found.into_iter().map(|tree| (tree, size)));
    }
    all
}

/// Every multiset of known trees, from index `from` on, with `left` nodes in all.
fn extend(
    known: &[(Tree, usize)],
    left: usize,
    from: usize,
    chosen: &mut Tree,
    found: &mut Vec<Tree>,
) {
    if left == 0 {
        found.push(chosen.clone());
        return;
    }
    for idx in from..known.len() {
        if known[idx].1 <= left {
            chosen.push(idx);
            extend(known, left - known[idx].1, idx, chosen, found);
            chosen.pop();
        }
    }
}

/// `1/γ` and the elementary weights `Φ_i` of every tree, HNW1 §II.2.
fn weights(trees: &[(Tree, usize)]) -> Vec<(f64, [f64; N_EXTENDED])> {
    let mut all: Vec<(f64, [f64; N_EXTENDED])> = Vec::new();
    for (tree, order) in trees {
        let mut inverse_density = 1.0 / *order as f64;
        let mut phi = [1.0; N_EXTENDED];
        for &branch in tree {
            let (density, inner) = all[branch];
            inverse_density *= density;
            for (phi, row) in phi.iter_mut().zip(A) {
                *phi *= row.iter().map(|&(j, a)| a * inner[j]).sum::<f64>();
            }
        }
        all.push((inverse_density, phi));
    }
    all
}

fn sum(row: &[Term], phi: &[f64; N_EXTENDED]) -> f64 {
    row.iter().map(|&(i, b)| b * phi[i]).sum()
}

#[test]
fn all_order_conditions_up_to_order_eight_hold_and_not_all_of_order_nine() {
    let trees = trees(9);
    let counts: Vec<usize> =
        (1..=9).map(|order| trees.iter().filter(|tree| tree.1 == order).count()).collect();
    assert_eq!(counts, [1, 1, 2, 4, 9, 20, 48, 115, 286]);
    let mut worst_of_nine = 0.0f64;
    for ((_, order), (inverse_density, phi)) in trees.iter().zip(weights(&trees)) {
        let defect = (sum(A[N_STAGES], &phi) - inverse_density).abs();
        if *order == 9 {
            worst_of_nine = worst_of_nine.max(defect);
        } else {
            assert!(defect < 1e-14, "order {order}: defect {defect:e}");
        }
    }
    assert!(worst_of_nine > 1e-7, "{worst_of_nine:e}");
}

#[test]
fn embedded_formulas_have_order_five_and_three() {
    let trees = trees(6);
    for (row, embedded) in [(E5, 5), (E3, 3)] {
        let mut beyond = 0.0f64;
        for ((_, order), (_, phi)) in trees.iter().zip(weights(&trees)) {
            // The method and the embedded formula agree on every tree that both get right.
            let defect = sum(row, &phi).abs();
            if *order <= embedded {
                assert!(defect < 1e-14, "order {embedded}: tree of order {order}, {defect:e}");
            } else if *order == embedded + 1 {
                beyond = beyond.max(defect);
            }
        }
        assert!(beyond > 1e-5, "order {embedded} is exceeded: {beyond:e}");
    }
}

#[test]
fn nodes_are_row_sums() {
    for (c, row) in C.iter().zip(A) {
        let sum: f64 = row.iter().map(|&(_, a)| a).sum();
        assert!((c - sum).abs() < 1e-13, "c = {c}, row sum {sum}");
    }
}

#[test]
fn the_extension_has_order_seven_everywhere() {
    let trees = trees(7);
    for ((_, order), (inverse_density, phi)) in trees.iter().zip(weights(&trees)) {
        // u(θ) is linear in the k: its terms on the elementary weights, with h = 1 and y0 = 0.
        let change = sum(A[N_STAGES], &phi);
        let second = phi[0] - change;
        let mut terms = vec![change, second, change - phi[N_STAGES] - second];
        terms.extend(D.iter().map(|row| sum(row, &phi)));
        let extension = ContinuousExtension { h: 1.0, terms, ..ContinuousExtension::new(1) };
        for theta in [0.1, 0.3, 0.5, 0.8, 1.0] {
            let (mut value, mut slope) = ([0.0], [0.0]);
            extension.value_into(theta, &mut value);
            let exponent = i32::try_from(*order).expect("small");
            let exact = f64::powi(theta, exponent) * inverse_density;
            let defect = (value[0] - exact).abs();
            assert!(defect < 1e-13, "θ = {theta}, order {order}: defect {defect:e}");
            extension.derivative_into(theta, &mut slope);
            let exact = f64::from(exponent) * f64::powi(theta, exponent - 1) * inverse_density;
            let defect = (slope[0] - exact).abs();
            assert!(defect < 1e-12, "slope at θ = {theta}, order {order}: defect {defect:e}");
        }
    }
}
