//! [`most_zeros`]: how many solutions quadratic equations can have in affine space, from ranks alone.
//!
//! ```text
//! N₃ = { f : f(W₃) = 0 },  W₃ ∋ each equation, times one and times each unknown
//! N₂ = N₃ restricted to degree two;  f stays in N₃ while p ↦ f(yₖ p) is in N₂ for all k
//! G_d = { f on forms of degree d : f(yₖ ·) ∈ G_{d−1} for all k },  G₃ = { f ∈ N₃ : f = 0 on degree two }
//! number ≤ dim N₃ + dim G₄ + dim G₅ + …
//! ```
//!
//! Functionals are on polynomials up to degree three. Every solution gives one, so those that vanish on the equations and what
//! follows from them bound the number; what solutions distinguish only in degree four or more is in the forms. Solutions at
//! infinity, isolated or not, do not count: they are what makes functionals leave N₃. The sum ends at the first G_d without
//! dimension, since all later ones have none.
//!
//! Source: H. M. Möller and H. J. Stetter, *Multivariate polynomial equations with multiple zeros solved by matrix
//! eigenproblems*, Numer. Math. 70 (1995) 311; F. S. Macaulay, *The Algebraic Theory of Modular Systems* (1916), inverse systems.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

/// A product of unknowns, by their numbers in ascending order.
type Monomial = Vec<usize>;

/// Largest number of unknowns, and the degree up to which forms are followed.
const MOST_UNKNOWNS: usize = 12;
const MOST_DEGREE: usize = 8;

/// Largest number of solutions of yᵀ A y = 0 for all of these symmetric matrices with y₀ = 1, counted with their
/// multiplicities; none where a rank is not certain or the number has no bound.
pub fn most_zeros(equations: &[DMatrix<f64>]) -> Option<usize> {
    let n = equations.first()?.nrows() - 1;
    if n == 0 || n > MOST_UNKNOWNS {
        return None;
    }
    let degrees: Vec<Vec<Monomial>> = (0..=3).map(|d| monomials(n, d)).collect();
    let of_three = Numbered::of(degrees.concat());
    let of_two = Numbered::of(degrees[..3].concat());
    let low = of_two.all.len();

    // N₃ by the equations and their multiples.
    let multiples = |equation: &DMatrix<f64>| -> Vec<Vec<f64>> {
        let by = |factor: Option<usize>| {
            let mut row = vec![0.0; of_three.all.len()];
            for i in 0..=n {
                for j in 0..=n {
                    let unknowns = [i, j].into_iter().filter(|k| *k > 0).map(|k| k - 1);
                    let mut of: Monomial = unknowns.chain(factor).collect();
                    of.sort_unstable();
                    row[of_three.number[&of]] += equation[(i, j)];
                }
            }
            row
        };
        std::iter::once(None).chain((0..n).map(Some)).map(by).collect()
    };
    let rows: Vec<Vec<f64>> = equations.iter().flat_map(multiples).collect();
    let matrix = DMatrix::from_fn(rows.len(), of_three.all.len(), |i, j| rows[i][j]);
    let mut functionals = null_space(matrix)?;

    // What lower degrees leave of it.
    let mut restricted = functionals.rows(0, low).into_owned();
    loop {
        let known = column_space(&restricted)?;
        let mut off = DMatrix::zeros((n + 1) * low, functionals.ncols());
        for k in 0..=n {
            let shifted = if k == 0 {
                restricted.clone()
            } else {
                let from = |p: &Monomial| of_three.number[&times(p, k - 1)];
                functionals.select_rows(&of_two.all.iter().map(from).collect::<Vec<_>>())
            };
            off.rows_mut(k * low, low).copy_from(&(&shifted - &known * known.tr_mul(&shifted)));
        }
        let kept = null_space(off)?;
        if kept.ncols() == functionals.ncols() {
            break;
        }
        functionals *= kept;
        restricted = functionals.rows(0, low).into_owned();
    }

    // Forms of degree three, and what follows of higher ones.
    let mut number = functionals.ncols();
    let top = functionals.rows(low, of_three.all.len() - low).into_owned();
    let mut forms = top * null_space(restricted)?;
    let mut here = Numbered::of(degrees[3].clone());
    for degree in 4..=MOST_DEGREE {
        if forms.ncols() == 0 {
            return Some(number);
        }
        let next = monomials(n, degree);
        forms = prolonged(n, &forms, &here, &next)?;
        number += forms.ncols();
        here = Numbered::of(next);
    }
    None
}

/// Functionals on the forms `next` of which those with one unknown less are all among `forms` on the monomials `here`.
fn prolonged(
    n: usize,
    forms: &DMatrix<f64>,
    here: &Numbered,
    next: &[Monomial],
) -> Option<DMatrix<f64>> {
    let r = forms.ncols();
    let without = |of: &Monomial, place: usize| {
        let mut rest = of.clone();
        rest.remove(place);
        here.number[&rest]
    };
    let places = |of: &Monomial| -> Vec<usize> {
        (0..of.len()).filter(|&k| k == 0 || of[k] != of[k - 1]).collect()
    };
    // Unknowns: of each k the coefficients of f(yₖ ·); they agree on every form.
    let mut rows: Vec<(usize, Monomial, usize)> = Vec::new();
    for of in next {
        rows.extend(places(of).into_iter().skip(1).map(|place| (of[place], of.clone(), place)));
    }
    let mut matrix = DMatrix::zeros(rows.len(), n * r);
    for (row, (k, of, place)) in rows.iter().enumerate() {
        for (k, place, sign) in [(of[0], 0, 1.0), (*k, *place, -1.0)] {
            let value = forms.row(without(of, place)) * sign;
            matrix.view_mut((row, k * r), (1, r)).copy_from(&value);
        }
    }
    let free = null_space(matrix)?;
    let value = |i: usize, j: usize| {
        let of = &next[i];
        (0..r).map(|c| forms[(without(of, 0), c)] * free[(of[0] * r + c, j)]).sum()
    };
    Some(DMatrix::from_fn(next.len(), free.ncols(), value))
}

/// Monomials with their numbers.
struct Numbered {
    all: Vec<Monomial>,
    number: BTreeMap<Monomial, usize>,
}

impl Numbered {
    fn of(all: Vec<Monomial>) -> Self {
        let number = all.iter().cloned().enumerate().map(|(k, of)| (of, k)).collect();
        Self { all, number }
    }
}

/// All products of this many unknowns.
fn monomials(n: usize, degree: usize) -> Vec<Monomial> {
    (0..degree).fold(vec![Vec::new()], |lower: Vec<Monomial>, _| {
        let longer = |of: &Monomial| {
            let first = of.last().copied().unwrap_or(0);
            (first..n).map(|k| [&of[..], &[k]].concat()).collect::<Vec<_>>()
        };
        lower.iter().flat_map(longer).collect()
    })
}

fn times(of: &Monomial, k: usize) -> Monomial {
    let mut product = of.clone();
    product.insert(product.partition_point(|other| *other <= k), k);
    product
}

/// Orthonormal basis of the zeros of a matrix; none where its rank is not certain.
fn null_space(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = matrix.ncols();
    let (values, vectors) = right_vectors(matrix)?;
    let zero: Vec<usize> = zeros(&values)?;
    Some(DMatrix::from_fn(n, zero.len(), |i, k| vectors[(zero[k], i)]))
}

/// Orthonormal basis of the space of the columns; none where its dimension is not certain.
fn column_space(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let m = matrix.nrows();
    let (values, vectors) = right_vectors(matrix.transpose())?;
    let zero = zeros(&values)?;
    let kept: Vec<usize> = (0..values.len()).filter(|k| !zero.contains(k)).collect();
    Some(DMatrix::from_fn(m, kept.len(), |i, k| vectors[(kept[k], i)]))
}

/// Singular values with the right vectors as rows, as many as there are columns.
fn right_vectors(mut matrix: DMatrix<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
    const MOST_SWEEPS: usize = 10_000;
    let n = matrix.ncols();
    if n == 0 {
        return Some((Vec::new(), matrix));
    }
    // A triangle has the same ones.
    if matrix.nrows() > n {
        matrix = matrix.qr().r();
    } else if matrix.nrows() < n {
        matrix = matrix.resize_vertically(n, 0.0);
    }
    let svd = matrix.try_svd(false, true, f64::EPSILON, MOST_SWEEPS)?;
    Some((svd.singular_values.iter().copied().collect(), svd.v_t?))
}

/// Numbers of the singular values that are zero; none where that is not certain.
fn zeros(values: &[f64]) -> Option<Vec<usize>> {
    /// Shares of one: matrices come from orthonormal bases, and from equations of that size.
    const ZERO: f64 = 1e-10;
    const NOT_ZERO: f64 = 1e-7;
    let is_certain = values.iter().all(|v| !(*v > ZERO && *v < NOT_ZERO));
    is_certain.then(|| (0..values.len()).filter(|&k| values[k] <= ZERO).collect())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    /// A symmetric matrix from terms c yᵢ yⱼ.
    fn form(n: usize, terms: &[(f64, usize, usize)]) -> DMatrix<f64> {
        let mut form = DMatrix::zeros(n + 1, n + 1);
        for &(c, i, j) in terms {
            form[(i, j)] += 0.5 * c;
            form[(j, i)] += 0.5 * c;
        }
        form
    }

    #[test]
    fn two_conics_meet_four_times_and_two_circles_twice() {
        let ellipse = form(2, &[(1.0, 1, 1), (3.0, 2, 2), (-1.0, 0, 0)]);
        let hyperbola = form(2, &[(1.0, 1, 1), (-1.0, 2, 2), (0.3, 1, 2), (0.1, 0, 1)]);
        assert_eq!(most_zeros(&[ellipse, hyperbola]), Some(4));
        let circle = |x: f64, r: f64| {
            form(2, &[(1.0, 1, 1), (1.0, 2, 2), (-2.0 * x, 0, 1), (x * x - r * r, 0, 0)])
        };
        assert_eq!(most_zeros(&[circle(0.0, 1.0), circle(0.7, 1.1)]), Some(2));
        // Concentric: none.
        assert_eq!(most_zeros(&[circle(0.0, 1.0), circle(0.0, 1.1)]), Some(0));
    }

    #[test]
    fn quadrics_in_general_position_meet_as_bezout_says_and_a_curve_has_no_number() {
        let mut random = Pcg64::seed_from_u64(1);
        for n in 1..=4 {
            let mut equation = |_| {
                let half = DMatrix::from_fn(n + 1, n + 1, |_, _| random.random_range(-1.0..1.0));
                &half + half.transpose()
            };
            let equations: Vec<DMatrix<f64>> = (0..n).map(&mut equation).collect();
            assert_eq!(most_zeros(&equations), Some(1 << n), "{n} quadrics");
            if n > 1 {
                assert_eq!(most_zeros(&equations[1..]), None, "a curve");
            }
        }
    }
}
