//! Poses of a platform in the numbers of E. Study, and how many there can be.
//!
//! ```text
//! x = (e, g) up to a factor,  e·g = 0,  N = e·e           quaternions
//! N R p = e p e*,   N t = 2 g e*,   N Rᵀt = 2 e* g,   N t·t = 4 g·g
//! N (|b|² + |p|² − L²) + N t·t − 2 b·N t + 2 p·N Rᵀt − 2 b·N R p = 0        a leg
//! ```
//!
//! A leg is linear in 1, t·t, t, Rᵀt and R: seventeen functions. Six legs leave ten unknowns among them, which the quadratic
//! equations between these functions bind: their number of solutions is bounded by [`bksim_homotopy::most_zeros`].
//!
//! Source: M. L. Husty (1996), see [`super`]; the functions: M. Gallet, G. Nawratil and J. Schicho, *Bond theory for pentapods and
//! hexapods*, J. Geom. 106 (2015) 211.

use bksim_homotopy::{Ball, Between, C, End, Quadratic, most_zeros, track};
use nalgebra::{DMatrix, DVector, Quaternion, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::legs::Legs;

/// A solution in complex numbers.
#[derive(Clone, PartialEq, Debug)]
pub struct StudyPoint {
    /// e and g as real and imaginary parts, scaled so that the largest is one; lengths in those of the longest link, from the
    /// mean of the points on the base to that of the points on the platform, turned from the start.
    pub numbers: [[f64; 2]; 8],
    /// One solution is within this distance in all numbers.
    pub radius: f64,
    /// True of a pose; other solutions are certain to be none.
    pub is_assembly: bool,
}

/// A displacement of the platform from its place in the start, against the base: x ↦ R x + t, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Displacement {
    pub(super) rotation: UnitQuaternion<f64>,
    pub(super) shift: Vector3<f64>,
}

/// All that was found.
pub(super) struct Solved {
    pub(super) bound: Option<usize>,
    pub(super) points: Vec<StudyPoint>,
    /// Displacements of the real ones.
    pub(super) real: Vec<Displacement>,
}

const N_FUNCTIONS: usize = 17;
/// Solutions in general position.
const N_GENERAL: usize = 40;

/// A platform in general position with its solutions: six rows of seventeen numbers, a patch of eight, then eight of each
/// solution, all as real and imaginary part, little-endian. `cargo run --release -p bksim-analysis --example platform` writes it.
const START: &[u8] = include_bytes!("start.bin");

/// All solutions of a platform; none where rounding could decide what is real or the legs depend on each other.
pub(super) fn solved(legs: &Legs) -> Option<Solved> {
    /// Other ways from the start that are tried while solutions are missing.
    const N_SEEDS: u64 = 4;
    /// Relative error of points.
    const COEFFICIENTS: f64 = 64.0 * f64::EPSILON;
    let frame = Frame::of(legs);
    let rows = orthonormal(&frame.rows(legs))?;
    let bound = bound(&rows);
    let start = Start::read();
    let target = forms(&rows.map(C::from));
    let mut random = Pcg64::seed_from_u64(7);
    let patch = DVector::from_fn(8, |_, _| C::from(random.random_range(-1.0..1.0)));
    let equations = equations(&target, &patch);
    let mut found: Vec<(DVector<C>, Ball)> = Vec::new();
    for seed in 0..N_SEEDS {
        let mixed = start.mixed(seed);
        for x in &start.solutions {
            let family = Between { from: &mixed, to: &target, patch: &start.patch };
            let End::Arrived(x) = track(&family, x) else { continue };
            let mut x = &x / patch.dot(&x);
            let Some(enclosed) = equations.enclose(&mut x, COEFFICIENTS) else { continue };
            // No displacement, and on a surface of such.
            if x.rows(0, 4).camax() < 1e-9 * x.camax() {
                continue;
            }
            let ball = enclosed.ball;
            if found.iter().all(|(y, other)| ball.is_apart(&x, other, y)) {
                found.push((x, ball));
            }
        }
        if found.len() >= bound.unwrap_or(N_GENERAL) {
            break;
        }
    }
    let (mut points, mut real) = (Vec::new(), Vec::new());
    for (x, ball) in &found {
        let is_assembly = ball.is_own(x, &x.map(|c| c.conj()))?;
        if is_assembly {
            real.push(frame.displacement(x));
        }
        let largest =
            x.iter().copied().fold(C::default(), |a, b| if b.norm() > a.norm() { b } else { a });
        let number = |k: usize| {
            let share = x[k] / largest;
            [share.re, share.im]
        };
        // In the norm of balls, whose weights are at least one.
        let radius = ball.radius * x.camax().max(1.0) / largest.norm();
        points.push(StudyPoint { numbers: std::array::from_fn(number), radius, is_assembly });
    }
    Some(Solved { bound, points, real })
}

/// Means of the points on both sides, and the unit of lengths.
struct Frame {
    centres: [Vector3<f64>; 2],
    size: f64,
}

impl Frame {
    fn of(legs: &Legs) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "legs are six")]
        let share = 1.0 / legs.six.len() as f64;
        let centre =
            |k: usize| legs.six.iter().map(|leg| leg.ends[k]).sum::<Vector3<f64>>() * share;
        Self { centres: [centre(0), centre(1)], size: legs.size }
    }

    /// Coefficients of the seventeen functions, a row for each leg.
    fn rows(&self, legs: &Legs) -> DMatrix<f64> {
        let mut rows = DMatrix::zeros(legs.six.len(), N_FUNCTIONS);
        for (k, leg) in legs.six.iter().enumerate() {
            let [b, p] = [0, 1].map(|i| (leg.ends[i] - self.centres[i]) / self.size);
            let length = (leg.ends[1] - leg.ends[0]) / self.size;
            rows[(k, 0)] = b.dot(&b) + p.dot(&p) - length.dot(&length);
            rows[(k, 1)] = 1.0;
            for i in 0..3 {
                rows[(k, 2 + i)] = -2.0 * b[i];
                rows[(k, 5 + i)] = 2.0 * p[i];
                for j in 0..3 {
                    rows[(k, 8 + 3 * i + j)] = -2.0 * b[i] * p[j];
                }
            }
        }
        rows
    }

    /// The displacement of a real solution.
    fn displacement(&self, x: &DVector<C>) -> Displacement {
        let part = |k: usize| Quaternion::new(x[k].re, x[k + 1].re, x[k + 2].re, x[k + 3].re);
        let (e, g) = (part(0), part(4));
        let shift = (g * e.conjugate()).imag() * (2.0 * self.size / e.norm_squared());
        let rotation = UnitQuaternion::from_quaternion(e);
        // From means to the world.
        let [base, platform] = self.centres;
        Displacement { rotation, shift: shift + base - rotation * platform }
    }
}

/// The rows with their combinations orthonormal; none where one depends on the others.
fn orthonormal(rows: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    const DEPENDENT: f64 = 1e-9;
    let svd = rows.clone().try_svd(false, true, f64::EPSILON, 10_000)?;
    let values = &svd.singular_values;
    (values.min() > DEPENDENT * values.max()).then_some(svd.v_t?)
}

/// The seventeen functions as symmetric forms of (e, g).
fn functions() -> Vec<DMatrix<f64>> {
    type Q = Quaternion<f64>;
    let unit = |k: usize| -> [Q; 2] {
        let of = |half: usize| {
            let at = |i: usize| f64::from(u8::from(k == 4 * half + i));
            Q::new(at(0), at(1), at(2), at(3))
        };
        [of(0), of(1)]
    };
    // Bilinear in two points; symmetric parts are taken.
    let bilinear = |number: usize, x: [Q; 2], y: [Q; 2]| match number {
        0 => x[0].dot(&y[0]),
        1 => 4.0 * x[1].dot(&y[1]),
        2..5 => 2.0 * (x[1] * y[0].conjugate()).imag()[number - 2],
        5..8 => 2.0 * (x[0].conjugate() * y[1]).imag()[number - 5],
        _ => {
            let (i, j) = ((number - 8) / 3, (number - 8) % 3);
            let mut axis = Vector3::zeros();
            axis[j] = 1.0;
            (x[0] * Q::from_imag(axis) * y[0].conjugate()).imag()[i]
        }
    };
    let form = |number: usize| {
        let value = |i: usize, j: usize| bilinear(number, unit(i), unit(j));
        DMatrix::from_fn(8, 8, |i, j| 0.5 * (value(i, j) + value(j, i)))
    };
    (0..N_FUNCTIONS).map(form).collect()
}

/// Legs as forms of (e, g), then e·g.
fn forms(rows: &DMatrix<C>) -> Vec<DMatrix<C>> {
    let functions = functions();
    let of = |k: usize| {
        let mut sum = DMatrix::from_element(8, 8, C::default());
        for (function, c) in functions.iter().zip(rows.row(k).iter()) {
            sum += function.map(C::from) * *c;
        }
        sum
    };
    let half = |i: usize, j: usize| if i.abs_diff(j) == 4 { C::from(0.5) } else { C::default() };
    (0..rows.nrows()).map(of).chain([DMatrix::from_fn(8, 8, half)]).collect()
}

/// The forms as equations on a patch.
fn equations(forms: &[DMatrix<C>], patch: &DVector<C>) -> Quadratic {
    let row = |form: &DMatrix<C>| {
        let pairs = (0..8).flat_map(|i| (i..8).map(move |j| (i, j)));
        let term = |(i, j): (usize, usize)| {
            let c = if i == j { form[(i, j)] } else { form[(i, j)] * 2.0 };
            (c, i + 1, j + 1)
        };
        pairs.map(term).filter(|(c, ..)| *c != C::default()).collect()
    };
    let on_patch = patch.iter().enumerate().map(|(k, c)| (*c, 0, k + 1));
    let on_patch: Vec<_> = on_patch.chain([(C::from(-1.0), 0, 0)]).collect();
    Quadratic::new(forms.iter().map(row).chain([on_patch]).collect())
}

/// Largest number of displacements whose seventeen functions satisfy the rows.
fn bound(rows: &DMatrix<f64>) -> Option<usize> {
    let n_free = N_FUNCTIONS - rows.nrows();
    // An affine frame of what the rows leave: the first of its points has one in front, the others zero.
    let mut square = DMatrix::zeros(N_FUNCTIONS, N_FUNCTIONS);
    square.rows_mut(0, rows.nrows()).copy_from(rows);
    let v_t = square.try_svd(false, true, f64::EPSILON, 10_000)?.v_t?;
    let basis = v_t.rows(rows.nrows(), n_free).transpose();
    let first: DVector<f64> = basis.row(0).transpose();
    let size = first.norm();
    if size < 1e-9 {
        return Some(0);
    }
    let turn = DMatrix::from_fn(n_free, n_free, |i, j| {
        if j == 0 { first[i] } else { f64::from(u8::from(i == j)) }
    });
    let mut frame = basis * turn.qr().q();
    let scale = 1.0 / frame[(0, 0)];
    frame.column_mut(0).scale_mut(scale);
    let equations: Vec<DMatrix<f64>> =
        relations().iter().map(|relation| frame.tr_mul(&(relation * &frame))).collect();
    most_zeros(&equations)
}

/// The quadratic equations between the seventeen functions of a displacement, all there are.
fn relations() -> Vec<DMatrix<f64>> {
    let (t, w, r) = (|i: usize| 2 + i, |i: usize| 5 + i, |i: usize, j: usize| 8 + 3 * i + j);
    let mut all = Vec::new();
    let mut add = |terms: &[(f64, usize, usize)]| {
        let mut relation = DMatrix::zeros(N_FUNCTIONS, N_FUNCTIONS);
        for &(c, i, j) in terms {
            relation[(i, j)] += 0.5 * c;
            relation[(j, i)] += 0.5 * c;
        }
        all.push(relation);
    };
    for i in 0..3 {
        // R Rᵀ = RᵀR = 1, t = R w, w = Rᵀt.
        for j in i..3 {
            let one = if i == j { -1.0 } else { 0.0 };
            add(&[0, 1, 2, 3].map(|k| if k == 3 { (one, 0, 0) } else { (1.0, r(i, k), r(j, k)) }));
            add(&[0, 1, 2, 3].map(|k| if k == 3 { (one, 0, 0) } else { (1.0, r(k, i), r(k, j)) }));
        }
        add(&[0, 1, 2, 3].map(|k| if k == 3 { (-1.0, 0, t(i)) } else { (1.0, r(i, k), w(k)) }));
        add(&[0, 1, 2, 3].map(|k| if k == 3 { (-1.0, 0, w(i)) } else { (1.0, r(k, i), t(k)) }));
        for j in 0..3 {
            // Cofactors of R are R, and t × R e = R (w × e).
            let ([a, b], [c, d]) = ([1, 2].map(|k| (i + k) % 3), [1, 2].map(|k| (j + k) % 3));
            add(&[(1.0, r(a, c), r(b, d)), (-1.0, r(a, d), r(b, c)), (-1.0, 0, r(i, j))]);
            add(&[
                (1.0, t(a), r(b, j)),
                (-1.0, t(b), r(a, j)),
                (-1.0, w(d), r(i, c)),
                (1.0, w(c), r(i, d)),
            ]);
        }
    }
    add(&[0, 1, 2, 3].map(|k| if k == 3 { (-1.0, 0, 1) } else { (1.0, t(k), t(k)) }));
    add(&[0, 1, 2, 3].map(|k| if k == 3 { (-1.0, 0, 1) } else { (1.0, w(k), w(k)) }));
    all
}

/// A platform in general position.
struct Start {
    rows: DMatrix<C>,
    patch: DVector<C>,
    solutions: Vec<DVector<C>>,
}

impl Start {
    fn read() -> Self {
        let numbers: Vec<f64> = START
            .chunks_exact(8)
            .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap_or_default()))
            .collect();
        let all: Vec<C> = numbers.chunks_exact(2).map(|pair| C::new(pair[0], pair[1])).collect();
        let (rows, rest) = all.split_at(6 * N_FUNCTIONS);
        let (patch, rest) = rest.split_at(8);
        Self {
            rows: DMatrix::from_row_slice(6, N_FUNCTIONS, rows),
            patch: DVector::from_column_slice(patch),
            solutions: rest.chunks_exact(8).map(DVector::from_column_slice).collect(),
        }
    }

    /// Forms of the legs, other combinations of them for other seeds.
    fn mixed(&self, seed: u64) -> Vec<DMatrix<C>> {
        let mut random = Pcg64::seed_from_u64(seed);
        let mixing = DMatrix::from_fn(6, 6, |_, _| number(&mut random));
        forms(&(mixing * &self.rows))
    }
}

fn number(random: &mut Pcg64) -> C {
    C::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0))
}

/// A platform in general position with its forty solutions, in the order of the file: one solution is chosen, and others are
/// found by going round loops of platforms.
pub fn general_points(seed: u64) -> Vec<C> {
    const MOST_LOOPS: usize = 100;
    const SAME: f64 = 1e-6;
    let mut random = Pcg64::seed_from_u64(seed);
    let patch = DVector::from_fn(8, |_, _| number(&mut random));
    let mut x = DVector::from_fn(8, |_, _| number(&mut random));
    // Onto e·g = 0 and the patch.
    let (e, g) = (x.rows(0, 4).into_owned(), x.rows(4, 4).into_owned());
    x.rows_mut(4, 4).axpy(-e.dot(&g) / e.dot(&e), &e, C::from(1.0));
    x /= patch.dot(&x);
    let mut general = || DMatrix::from_fn(6, N_FUNCTIONS, |_, _| number(&mut random));
    let values = functions().iter().map(|f| (f.map(C::from) * &x).dot(&x)).collect::<Vec<C>>();
    let values = DVector::from_vec(values);
    let mut base = general();
    let miss = &base * &values;
    base -= miss * values.adjoint() / values.dotc(&values);
    let base_forms = forms(&base);
    let mut known = vec![x];
    for _ in 0..MOST_LOOPS {
        let corners =
            [base_forms.clone(), forms(&general()), forms(&general()), base_forms.clone()];
        for k in 0..known.len() {
            let around = corners.windows(2).try_fold(known[k].clone(), |x, side| {
                let family = Between { from: &side[0], to: &side[1], patch: &patch };
                match track(&family, &x) {
                    End::Arrived(x) => Some(x),
                    End::Lost { .. } => None,
                }
            });
            let Some(x) = around else { continue };
            if known.iter().all(|y| (&x - y).camax() > SAME) {
                known.push(x);
            }
        }
        if known.len() >= N_GENERAL {
            break;
        }
    }
    let rows = base.transpose();
    let all = rows.iter().chain(patch.iter()).chain(known.iter().flat_map(|x| x.iter()));
    all.copied().collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    #[test]
    fn the_functions_of_a_displacement_are_those_of_its_rotation_and_shift() {
        let rotation = UnitQuaternion::from_euler_angles(0.3, -0.8, 1.9);
        let t = Vector3::new(0.4, -1.1, 0.7);
        let e = rotation.into_inner() * 1.7;
        let g = Quaternion::from_imag(t) * e * 0.5;
        let x = DVector::from_vec(vec![e.w, e.i, e.j, e.k, g.w, g.i, g.j, g.k]);
        let (r, w): (Matrix3<f64>, _) =
            (rotation.to_rotation_matrix().into_inner(), rotation.inverse() * t);
        let mut right = vec![1.0, t.dot(&t)];
        right.extend(t.iter().chain(w.iter()).chain(r.transpose().iter()));
        for (k, (function, right)) in functions().iter().zip(&right).enumerate() {
            let value = x.dot(&(function * &x)) / (1.7 * 1.7);
            assert!((value - right).abs() < 1e-14, "function {k}: {value} against {right}");
        }
        let right = DVector::from_vec(right);
        for (k, relation) in relations().iter().enumerate() {
            let miss = right.dot(&(relation * &right));
            assert!(miss.abs() < 1e-14, "relation {k} misses by {miss}");
        }
    }

    #[test]
    fn the_start_has_forty_solutions() {
        let start = Start::read();
        let forms = forms(&start.rows);
        let equations = equations(&forms, &start.patch);
        let mut found: Vec<(DVector<C>, Ball)> = Vec::new();
        for x in &start.solutions {
            let mut x = x.clone();
            let ball = equations.enclose(&mut x, 0.0).expect("a ball around each").ball;
            assert!(found.iter().all(|(y, other)| ball.is_apart(&x, other, y)), "one comes twice");
            found.push((x, ball));
        }
        assert_eq!(found.len(), N_GENERAL);
    }
}
