//! All four-bars whose coupler point passes through nine points: Alt's problem.
//!
//! ```text
//! a, b pivots; x, y pins, all from the first point; a bar over a letter is a conjugate, and an unknown of its own
//! δ a displacement of the coupler point, 1 + γ the turn of the coupler
//! x(δ̄ − ā) γ + x̄(δ − a) γ̄ + δδ̄ − aδ̄ − āδ + xδ̄ + x̄δ = 0       the bar from a to x keeps its length
//! the same with b and y;   γγ̄ + γ + γ̄ = 0                      eight times
//! ```
//!
//! γ and γ̄ from the first two equations by Cramer's rule leave one equation for each displacement, of degree seven. Displacements
//! in general position have 1442 triples of cognates, 8652 solutions with both orders of the bars. A file has one solution of each
//! triple for displacements in general position; each is followed to the displacements that are asked for, along a straight line.
//!
//! Source: C. W. Wampler, A. P. Morgan and A. J. Sommese, *Complete solution of the nine-point path synthesis problem for
//! four-bar linkages*, J. Mech. Des. 114 (1992) 153; J. D. Hauenstein and F. Sottile, *alphaCertified*, ACM Trans. Math. Softw. 38
//! (2012) 28, whose proof has at least as many solutions.

use bksim_homotopy::{At, C, End, Family, Quadratic, track};
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

/// Triples of cognates for displacements in general position.
pub(super) const N_TRIPLES: usize = 1442;

/// Eight displacements, then their conjugates.
type Displacements = [C; 16];

/// Displacements in general position with one solution of each triple: sixteen numbers, then eight of each solution, all as real
/// and imaginary part, little-endian. `cargo run --release -p bksim-design --example nine_points` writes it.
const START: &[u8] = include_bytes!("nine_points.bin");

/// A line between two sets of displacements, straight or with a bend into the imaginary: s + i b s (1 − s).
struct Line<'a> {
    from: &'a Displacements,
    to: &'a Displacements,
    bend: f64,
}

impl Family for Line<'_> {
    fn n(&self) -> usize {
        8
    }

    /// Unknowns a, ā, x, x̄, b, b̄, y, ȳ. Rows are divided by the sizes of their terms.
    fn at(&self, v: &DVector<C>, s: f64, at: &mut At) {
        let share = C::new(s, self.bend * s * (1.0 - s));
        let by_s = C::new(1.0, self.bend * (1.0 - 2.0 * s));
        for k in 0..8 {
            let (to, from) = ([self.to[k], self.to[8 + k]], [self.from[k], self.from[8 + k]]);
            let [d, e] = [0, 1].map(|i| from[i] * (C::from(1.0) - share) + to[i] * share);
            let [dd, de] = [0, 1].map(|i| (to[i] - from[i]) * by_s);
            // Coefficients of γ, of γ̄ and the rest, of both bars.
            let [first, second] = [0, 4].map(|i| {
                let (p, q, x, y) = (v[i], v[i + 1], v[i + 2], v[i + 3]);
                [x * (e - q), y * (d - p), d * e - p * e - q * d + x * e + y * d]
            });
            let cross = |i: usize, j: usize| first[i] * second[j] - first[j] * second[i];
            let (g, h, det) = (cross(1, 2), cross(2, 0), cross(0, 1));
            let scale = 1.0 / (1e-300 + g.norm() * h.norm() + det.norm() * (g.norm() + h.norm()));
            at.value[k] = (g * h + det * (g + h)) * scale;
            // Slopes by g, h, det, then by the coefficients of either bar.
            let (by_g, by_h, by_det) = ((h + det) * scale, (g + det) * scale, (g + h) * scale);
            let of = |other: &[C; 3], sign: f64| {
                [
                    (by_det * other[1] - by_h * other[2]) * sign,
                    (by_g * other[2] - by_det * other[0]) * sign,
                    (by_h * other[0] - by_g * other[1]) * sign,
                ]
            };
            let mut rate = C::default();
            for (i, by) in [(0, of(&second, 1.0)), (4, of(&first, -1.0))] {
                let (p, q, x, y) = (v[i], v[i + 1], v[i + 2], v[i + 3]);
                at.jacobian[(k, i)] = -by[1] * y - by[2] * e;
                at.jacobian[(k, i + 1)] = -by[0] * x - by[2] * d;
                at.jacobian[(k, i + 2)] = by[0] * (e - q) + by[2] * e;
                at.jacobian[(k, i + 3)] = by[1] * (d - p) + by[2] * d;
                rate +=
                    (by[1] * y + by[2] * (e - q + y)) * dd + (by[0] * x + by[2] * (d - p + x)) * de;
            }
            at.rate[k] = rate;
        }
    }
}

/// The third pivot of a four-bar's cognates, and its conjugate.
fn third_pivot(v: &DVector<C>) -> [C; 2] {
    [0, 1].map(|i| v[i] - (v[i + 4] - v[i]) * v[i + 2] / (v[i + 6] - v[i + 2]))
}

/// Numbers that are equal for all of a triple and both orders of its bars.
fn fingerprint(v: &DVector<C>) -> [C; 3] {
    let [c, d] = third_pivot(v);
    let (a, b) = (v[0], v[4]);
    [a + b + c, v[1] + v[5] + d, a * b + b * c + c * a]
}

/// Solutions, one of each triple.
#[derive(Default)]
struct Known {
    solutions: Vec<DVector<C>>,
    /// Fingerprints by the real part of the first number, with the starts of their paths.
    sorted: Vec<(f64, [C; 3], usize)>,
}

impl Known {
    /// Keeps a solution of a triple that is not yet here; the start of the one that is.
    fn insert(&mut self, v: DVector<C>, from: usize) -> Option<usize> {
        const SAME: f64 = 1e-7;
        let print = fingerprint(&v);
        let is_finite = |c: &C| c.re.is_finite() && c.im.is_finite();
        if !print.iter().all(is_finite) {
            return Some(usize::MAX);
        }
        let near = SAME * (1.0 + print[0].norm());
        let first = self.sorted.partition_point(|(key, ..)| *key < print[0].re - near);
        let within = self.sorted[first..].iter().take_while(|(key, ..)| *key <= print[0].re + near);
        let is_same = |(_, known, _): &&(f64, [C; 3], usize)| {
            (0..3).all(|i| (known[i] - print[i]).norm() < SAME * (1.0 + print[i].norm()))
        };
        if let Some((_, _, other)) = within.clone().find(is_same) {
            return Some(*other);
        }
        let at = self.sorted.partition_point(|(key, ..)| *key < print[0].re);
        self.sorted.insert(at, (print[0].re, print, from));
        self.solutions.push(v);
        None
    }
}

fn number(random: &mut Pcg64) -> C {
    C::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0))
}

fn displacements(random: &mut Pcg64) -> Displacements {
    std::array::from_fn(|_| number(random))
}

/// Follows solutions on all cores.
fn followed(
    (from, to, bend): (&Displacements, &Displacements, f64),
    all: &[DVector<C>],
) -> Vec<Option<DVector<C>>> {
    let line = Line { from, to, bend };
    all.par_iter()
        .map(|v| match track(&line, v) {
            End::Arrived(v) => Some(v),
            End::Lost { .. } => None,
        })
        .collect()
}

/// Displacements in general position with one solution of each triple, found by going round loops from one solution;
/// `reached` is called with their number after each.
pub fn general_solutions(seed: u64, reached: &dyn Fn(usize)) -> Vec<C> {
    const MOST_LOOPS: usize = 60;
    let mut random = Pcg64::seed_from_u64(seed);
    let (base, first) = std::iter::repeat_with(|| with_solution(&mut random))
        .flatten()
        .next()
        .unwrap_or_else(|| (displacements(&mut Pcg64::seed_from_u64(seed)), DVector::default()));
    let equations = equations(&base);
    let mut known = Known::default();
    known.insert(first, 0);
    for _ in 0..MOST_LOOPS {
        let corners = [base, displacements(&mut random), displacements(&mut random), base];
        let mut moved: Vec<Option<DVector<C>>> =
            known.solutions.iter().cloned().map(Some).collect();
        for side in corners.windows(2) {
            let here: Vec<DVector<C>> = moved.into_iter().flatten().collect();
            moved = followed((&side[0], &side[1], 0.0), &here);
        }
        // Paths that were lost and found again may come back with what is no solution.
        let is_solution = |v: &DVector<C>| checked(&equations, &base, v).is_certain;
        let back: Vec<DVector<C>> = moved.into_par_iter().flatten().filter(is_solution).collect();
        for v in back {
            known.insert(v, 0);
        }
        reached(known.solutions.len());
        if known.solutions.len() >= N_TRIPLES {
            break;
        }
    }
    let all = known.solutions.iter().flat_map(|v| v.iter().copied());
    base.into_iter().chain(all).collect()
}

/// A four-bar at random, and displacements that it reaches.
fn with_solution(random: &mut Pcg64) -> Option<(Displacements, DVector<C>)> {
    let v = DVector::from_fn(8, |_, _| number(random));
    let mut all = [C::default(); 16];
    for k in 0..8 {
        let g = number(random);
        let h = -g / (C::from(1.0) + g);
        // Newton's iteration for δ and δ̄.
        let (mut d, mut e) = (number(random), number(random));
        for _ in 0..30 {
            let row = |i: usize| {
                let (p, q, x, y) = (v[i], v[i + 1], v[i + 2], v[i + 3]);
                let value =
                    x * (e - q) * g + y * (d - p) * h + d * e - p * e - q * d + x * e + y * d;
                (value, y * h + e - q + y, x * g + d - p + x)
            };
            let ((f, fd, fe), (r, rd, re)) = (row(0), row(4));
            let det = fd * re - fe * rd;
            d -= (f * re - r * fe) / det;
            e -= (fd * r - rd * f) / det;
        }
        (all[k], all[8 + k]) = (d, e);
    }
    let mut at = At::zeros(8);
    Line { from: &all, to: &all, bend: 0.0 }.at(&v, 0.0, &mut at);
    let is_solution = at.value.norm() < 1e-12 && all.iter().all(|c| c.norm() < 4.0);
    is_solution.then_some((all, v))
}

/// All that nine points have.
pub(super) struct All {
    /// Triples that were reached.
    pub(super) n_triples: usize,
    /// Triples whose solution is enclosed.
    pub(super) n_certain: usize,
    /// Largest share of its terms that an equation of a real four-bar misses, in thirty digits.
    pub(super) left: f64,
    /// Pivots and pins of one real four-bar of each triple: a, b, x, y.
    pub(super) real: Vec<[C; 4]>,
}

/// The turn of the coupler of the real four-bar [a, b, x, y] at a displacement.
pub(super) fn turn([a, b, x, y]: [C; 4], d: C) -> C {
    let v = DVector::from_vec(vec![a, a.conj(), x, x.conj(), b, b.conj(), y, y.conj()]);
    let [g, _] = turns(&v, d, d.conj());
    let turn = C::from(1.0) + g;
    // In the first point nothing has turned.
    if d.norm() == 0.0 { C::from(1.0) } else { turn / turn.norm() }
}

/// γ and γ̄ at a displacement.
fn turns(v: &DVector<C>, d: C, e: C) -> [C; 2] {
    let [first, second] = [0, 4].map(|i| {
        let (p, q, x, y) = (v[i], v[i + 1], v[i + 2], v[i + 3]);
        [x * (e - q), y * (d - p), d * e - p * e - q * d + x * e + y * d]
    });
    let cross = |i: usize, j: usize| first[i] * second[j] - first[j] * second[i];
    [cross(1, 2) / cross(0, 1), cross(2, 0) / cross(0, 1)]
}

fn start() -> (Displacements, Vec<DVector<C>>) {
    let numbers: Vec<f64> = START
        .chunks_exact(8)
        .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap_or_default()))
        .collect();
    let all: Vec<C> = numbers.chunks_exact(2).map(|pair| C::new(pair[0], pair[1])).collect();
    let base = std::array::from_fn(|k| all.get(k).copied().unwrap_or_default());
    let solutions = all.get(16..).unwrap_or_default().chunks_exact(8);
    (base, solutions.map(DVector::from_column_slice).collect())
}

/// All four-bars through the origin and eight displacements from there, of a size about one.
pub(super) fn all(points: &[C; 8]) -> All {
    /// Bends that lead around a point where paths meet.
    const BENDS: [f64; 6] = [0.01, -0.01, 0.03, -0.03, 0.1, -0.1];
    /// Paths that are followed along one bend, one after the other.
    const MOST: usize = 40;
    let target: Displacements =
        std::array::from_fn(|k| if k < 8 { points[k] } else { points[k - 8].conj() });
    let (base, solutions) = start();
    let mut known = Known::default();
    let mut lost = Vec::new();
    for (k, end) in followed((&base, &target, 0.0), &solutions).into_iter().enumerate() {
        match end {
            Some(v) => drop(known.insert(v, k)),
            None => lost.push(k),
        }
    }
    // A bend exchanges the ends of some paths: go on with the one whose end was found.
    for bend in BENDS {
        for &first in &lost {
            let mut next = Some(first);
            for _ in 0..MOST {
                let Some(k) = next.filter(|_| known.solutions.len() < solutions.len()) else {
                    break;
                };
                let end = followed((&base, &target, bend), &solutions[k..=k]).pop().flatten();
                next =
                    end.and_then(|v| known.insert(v, k)).filter(|other| *other < solutions.len());
            }
        }
    }
    let equations = equations(&target);
    let checked: Vec<Checked> =
        known.solutions.par_iter().map(|v| checked(&equations, &target, v)).collect();
    let is_real = |one: &&Checked| one.is_real;
    All {
        n_triples: known.solutions.len(),
        n_certain: checked.iter().filter(|one| one.is_certain).count(),
        left: checked.iter().filter(is_real).map(|one| one.left).fold(0.0, f64::max),
        real: checked.iter().filter(is_real).map(|one| one.places).collect(),
    }
}

struct Checked {
    is_certain: bool,
    is_real: bool,
    left: f64,
    places: [C; 4],
}

/// A solution in a ball that holds no other, and whether it is its own mirror image.
fn checked(equations: &Quadratic, target: &Displacements, v: &DVector<C>) -> Checked {
    const NEARLY_REAL: f64 = 1e-6;
    let mut x = with_turns(target, v);
    let enclosed = equations.enclose(&mut x, 0.0);
    let mirrored = DVector::from_fn(x.len(), |i, _| x[i ^ 1].conj());
    // The mirror image is a solution, too: of a real one in the same ball.
    let is_real = enclosed.map_or_else(
        || (&x - &mirrored).camax() < NEARLY_REAL * (1.0 + x.camax()),
        |found| found.ball.is_own(&x, &mirrored) == Some(true),
    );
    let left = enclosed.map_or(f64::INFINITY, |enclosed| enclosed.left);
    Checked { is_certain: enclosed.is_some(), is_real, left, places: [x[0], x[4], x[2], x[6]] }
}

/// The unknowns with products xā, x̄a, yb̄, ȳb and eight pairs γ, γ̄ after them.
fn with_turns(target: &Displacements, v: &DVector<C>) -> DVector<C> {
    let mut all: Vec<C> = v.iter().copied().collect();
    all.extend([v[2] * v[1], v[3] * v[0], v[6] * v[5], v[7] * v[4]]);
    for k in 0..8 {
        all.extend(turns(v, target[k], target[8 + k]));
    }
    DVector::from_vec(all)
}

/// All equations, quadratic in these unknowns.
fn equations(target: &Displacements) -> Quadratic {
    let one = C::from(1.0);
    let mut rows = Vec::new();
    for (product, x, q) in [(9, 3, 2), (10, 4, 1), (11, 7, 6), (12, 8, 5)] {
        rows.push(vec![(one, 0, product), (-one, x, q)]);
    }
    for k in 0..8 {
        let (d, e) = (target[k], target[8 + k]);
        let (g, h) = (13 + 2 * k, 14 + 2 * k);
        for (i, product) in [(1, 9), (5, 11)] {
            let (p, q, x, y) = (i, i + 1, i + 2, i + 3);
            rows.push(vec![
                (e, x, g),
                (-one, product, g),
                (d, y, h),
                (-one, product + 1, h),
                (d * e, 0, 0),
                (-e, 0, p),
                (-d, 0, q),
                (e, 0, x),
                (d, 0, y),
            ]);
        }
        rows.push(vec![(one, g, h), (one, 0, g), (one, 0, h)]);
    }
    Quadratic::new(rows)
}
