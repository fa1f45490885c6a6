//! Solutions, balls and bounds against numbers that are known otherwise.

use bksim_homotopy::{C, Quadratic, n_inverse_pairs, solutions};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Rank of the edges of a graph in a set: vertices less parts.
fn graph_rank(edges: &[(usize, usize)]) -> impl Fn(u32) -> u32 {
    move |set| {
        let n = edges.iter().map(|(a, b)| 1 + *a.max(b)).max().unwrap_or(0);
        let mut leader: Vec<usize> = (0..n).collect();
        let mut rank = 0;
        for (_, &(a, b)) in edges.iter().enumerate().filter(|(k, _)| set >> k & 1 == 1) {
            let (from, to) = (leader[a], leader[b]);
            if from != to {
                leader.iter_mut().filter(|l| **l == from).for_each(|l| *l = to);
                rank += 1;
            }
        }
        rank
    }
}

#[test]
fn rigid_graphs_have_the_known_numbers_of_realisations() {
    let check = |edges: &[(usize, usize)], expected: u64| {
        assert_eq!(n_inverse_pairs(edges.len(), graph_rank(edges)), Some(expected), "{edges:?}");
    };
    // A triangle; two on one side; the prism of Desargues; K(3,3).
    check(&[(0, 1), (1, 2), (2, 0)], 2);
    check(&[(0, 1), (1, 2), (2, 0), (1, 3), (2, 3)], 4);
    let prism = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)];
    check(&prism, 24);
    let k33: Vec<(usize, usize)> = (0..3).flat_map(|a| (3..6).map(move |b| (a, b))).collect();
    check(&k33, 16);
}

#[test]
fn spaces_in_general_position_have_all_that_bezout_allows() {
    for d in 1..5_u32 {
        let n = 2 * d + 1;
        let expected = (1..=u64::from(d)).fold(1, |c, k| c * (u64::from(d) + k) / k);
        let rank = |set: u32| set.count_ones().min(d + 1);
        assert_eq!(n_inverse_pairs(n as usize, rank), Some(expected));
    }
}

#[test]
fn bilinear_equations_have_all_their_solutions() {
    let mut random = Pcg64::seed_from_u64(3);
    for (d, expected) in [(1, 2), (2, 6), (3, 20)] {
        let mut number = || C::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0));
        let forms: Vec<DMatrix<C>> =
            (0..2 * d).map(|_| DMatrix::from_fn(d + 1, d + 1, |_, _| number())).collect();
        let found = solutions(&forms, 1, 1000).expect("few paths");
        let is_zero = |(p, q): &&(DVector<C>, DVector<C>)| {
            forms.iter().all(|form| (p.transpose() * form * q)[0].norm() < 1e-12)
        };
        assert_eq!(found.iter().filter(is_zero).count(), expected);
        let ratio = |k: usize| found[k].0[0] / found[k].0[1];
        let differ = |a: usize, b: usize| (ratio(a) - ratio(b)).norm() > 1e-8;
        assert!((0..expected).all(|a| (0..a).all(|b| differ(a, b))));
    }
}

/// x² = 2 has a ball that reaches to the other root; x² = 0 has none.
#[test]
fn a_ball_holds_one_solution() {
    let square = |c: f64| Quadratic::new(vec![vec![(C::from(1.0), 1, 1), (C::from(-c), 0, 0)]]);
    let mut near = DVector::from_element(1, C::from(1.4));
    let found = square(2.0).enclose(&mut near, 0.0).expect("a ball");
    assert_eq!(near[0].re, 2.0_f64.sqrt());
    assert!(found.left < 1e-29 && found.ball.radius < 1e-15, "{found:?}");
    // In units of the root the other one is two away.
    assert!(found.ball.alone > 0.9 && found.ball.alone < 2.0, "{found:?}");
    assert_eq!(square(0.0).enclose(&mut DVector::from_element(1, C::from(1e-8)), 0.0), None);
}
