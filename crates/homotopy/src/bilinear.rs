//! [`solutions`]: equations that are linear in each of two groups of unknowns.
//!
//! ```text
//! pᵀ Qⱼ q = 0,  j = 1 … 2d,  p, q ∈ P^d
//! H = (1 − s) γ (lⱼ·p)(rⱼ·q) + s pᵀ Qⱼ q,  α·p = β·q = 1
//! ```
//!
//! At s = 0 d of the factors lⱼ and the other d factors rⱼ vanish: C(2d, d) solutions, as many as Bézout's theorem for
//! products of projective spaces allows. For numbers l, r, γ, α, β outside of a set of measure zero every isolated solution at
//! s = 1 is the end of a path.
//!
//! Source: A. J. Sommese and C. W. Wampler, *The Numerical Solution of Systems of Polynomials* (2005), section 8.4.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::C;
use crate::path::{At, End, Family, track};

/// A product of lines that becomes one of the given forms.
struct Bilinear<'a> {
    forms: &'a [DMatrix<C>],
    /// γ lⱼ and rⱼ.
    lines: Vec<[DVector<C>; 2]>,
    /// α and β.
    patches: [DVector<C>; 2],
}

impl Family for Bilinear<'_> {
    fn n(&self) -> usize {
        self.forms.len() + 2
    }

    fn at(&self, x: &DVector<C>, s: f64, at: &mut At) {
        let half = x.len() / 2;
        let (p, q) = (x.rows(0, half), x.rows(half, half));
        let (rest, s) = (C::from(1.0 - s), C::from(s));
        at.jacobian.fill(C::default());
        for (j, (form, [l, r])) in self.forms.iter().zip(&self.lines).enumerate() {
            let (lp, rq) = (l.dot(&p), r.dot(&q));
            let by_p = form * q;
            let mut value = C::default();
            for i in 0..half {
                value += p[i] * by_p[i];
                at.jacobian[(j, i)] = rest * rq * l[i] + s * by_p[i];
                let by_q = (0..half).map(|k| p[k] * form[(k, i)]).sum::<C>();
                at.jacobian[(j, half + i)] = rest * lp * r[i] + s * by_q;
            }
            at.value[j] = rest * lp * rq + s * value;
            at.rate[j] = value - lp * rq;
        }
        let n = self.forms.len();
        for (k, (patch, part)) in self.patches.iter().zip([p, q]).enumerate() {
            at.value[n + k] = patch.dot(&part) - C::from(1.0);
            at.rate[n + k] = C::default();
            for i in 0..half {
                at.jacobian[(n + k, k * half + i)] = patch[i];
            }
        }
    }
}

/// Common zeros (p, q) of 2d forms on d + 1 numbers each, up to factors: all regular ones, a path that is lost apart. Regular zeros
/// at infinity are among them. Seeds choose other paths. `None` where there would be more than `most` paths.
pub fn solutions(
    forms: &[DMatrix<C>],
    seed: u64,
    most: usize,
) -> Option<Vec<(DVector<C>, DVector<C>)>> {
    let (n, half) = (forms.len(), forms.first()?.nrows());
    if n + 2 != 2 * half || n > 40 {
        return None;
    }
    let subsets: Vec<u64> = of_size(n, half - 1, most)?;
    let mut random = Pcg64::seed_from_u64(seed);
    let mut vector = || DVector::from_fn(half, |_, _| on_circle(&mut random));
    let lines: Vec<[DVector<C>; 2]> = (0..n).map(|_| [vector(), vector()]).collect();
    let patches = [vector(), vector()];
    // γ belongs to all factors at once.
    let gamma = vector()[0];
    let with_gamma = lines.iter().map(|[l, r]| [l * gamma, r.clone()]).collect();
    let family = Bilinear { forms, lines: with_gamma, patches };
    let end = |subset: u64| {
        let start = start(&family, subset)?;
        match track(&family, &start) {
            End::Arrived(x) => {
                Some((x.rows(0, half).into_owned(), x.rows(half, half).into_owned()))
            }
            End::Lost { .. } => None,
        }
    };
    Some(subsets.into_iter().filter_map(end).collect())
}

/// A number on the unit circle.
fn on_circle(random: &mut Pcg64) -> C {
    let share: f64 = random.random_range(0.0..1.0);
    C::from_polar(1.0, std::f64::consts::TAU * share)
}

/// Zeros of the chosen factors l and of the other factors r.
fn start(family: &Bilinear<'_>, subset: u64) -> Option<DVector<C>> {
    let half = family.patches[0].len();
    let solve = |k: usize| {
        let chosen = family.lines.iter().enumerate();
        let chosen = chosen.filter(|(j, _)| (subset >> j & 1 == 1) == (k == 0));
        let rows = chosen.map(|(_, pair)| pair[k].transpose());
        let rows: Vec<_> = rows.chain([family.patches[k].transpose()]).collect();
        let mut right = DVector::from_element(half, C::default());
        right[half - 1] = C::from(1.0);
        DMatrix::from_rows(&rows).lu().solve(&right)
    };
    let (p, q) = (solve(0)?, solve(1)?);
    Some(DVector::from_iterator(2 * half, p.iter().chain(q.iter()).copied()))
}

/// All subsets of `size` of n things, none where they are more than `most`.
fn of_size(n: usize, size: usize, most: usize) -> Option<Vec<u64>> {
    let mut found = vec![(0_u64, 0_usize)];
    for k in 0..n {
        let mut next = Vec::new();
        for (set, count) in found {
            if count < size {
                next.push((set | 1 << k, count + 1));
            }
            // Without it the rest must suffice.
            if n - k - 1 + count >= size {
                next.push((set, count));
            }
        }
        if next.len() > most {
            return None;
        }
        found = next;
    }
    Some(found.into_iter().map(|(set, _)| set).collect())
}
