//! Closures of groups beyond dyads and triads, of any class, with pins and guides.
//!
//! ```text
//! z, T = e^(iθ), S = σ T                    shift and turn of a part, way along a guide; Z, 1/T, S/T² their conjugates
//! z_a + T_a p_a = z_b + T_b p_b             pin
//! T_a = T_b,  z_b − z_a = e S               guide
//! T T̄ = 1,  S T̄ = S̄ T                       2d equations on the points of a linear space, d + 1 numbers p, and of its conjugate, q
//! ```
//!
//! A group has as many parts as there are such equations, so d is half of them. All closures in complex numbers are ends of C(2d, d) paths. Their number
//! has a bound that follows from ranks of the linear space; a guide is the limit of pins far away, so the bound for pins in
//! general position holds for it. As many certain solutions as the bound allows are all.
//!
//! Source: C. W. Wampler, *Solving the kinematics of planar mechanisms*, J. Mech. Des. 121 (1999) 387; the bound is
//! [`bksim_homotopy::n_inverse_pairs`].

use std::cell::Cell;

use bksim_homotopy::{Ball, C, Quadratic, n_inverse_pairs, solutions};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::place::Place;
use super::structure::Structure;

/// A closure in complex numbers.
#[derive(Clone, PartialEq, Debug)]
pub struct Solution {
    /// Of each part e^(iθ) as real and imaginary part; of size one in an assembly.
    pub turns: Vec<[f64; 2]>,
    /// One solution is within this distance in all unknowns, in lengths of the longest link or, of larger unknowns, as a share.
    pub radius: f64,
    /// True of an assembly; other solutions are certain to be none.
    pub is_assembly: bool,
}

/// All that was found.
pub(super) struct Closed {
    /// Largest number of isolated solutions.
    pub(super) bound: u64,
    pub(super) solutions: Vec<Solution>,
    pub(super) ways: Vec<Vec<(usize, Place)>>,
}

/// Most paths of a group.
const MOST_PATHS: usize = 1000;

/// The turn of a part.
#[derive(Clone, Copy)]
enum Turn {
    Known(C),
    Free(usize),
}

/// Unknowns of a group as columns: one, shifts, turns, ways along guides.
struct Unknowns<'a> {
    structure: &'a Structure,
    parts: &'a [usize],
    /// By place in `parts`.
    turns: Vec<Turn>,
    n_turns: usize,
    /// Guides with a part of the group.
    slides: Vec<usize>,
    /// Pins on what stands.
    standing: Vec<bool>,
}

/// All closures of `parts` on what stands; none where rounding could decide or the group is too large.
pub(super) fn closures(
    structure: &Structure,
    parts: &[usize],
    way: &[Option<Place>],
    size: f64,
) -> Option<Closed> {
    /// Other paths that are tried while solutions are missing.
    const N_SEEDS: u64 = 3;
    /// Relative error of points and of what stands already.
    const COEFFICIENTS: f64 = 64.0 * f64::EPSILON;
    let unknowns = Unknowns::of(structure, parts, way)?;
    let linear = unknowns.linear(way, size)?;
    let basis = null_space(&linear)?;
    let half = unknowns.n_quadrics() / 2;
    if basis.ncols() != half + 1 || unknowns.n_quadrics() % 2 == 1 {
        return None;
    }
    let bound = unknowns.bound(&basis)?;
    let equations = unknowns.equations(&linear);
    let forms = unknowns.forms(&basis);
    let mut found: Vec<(DVector<C>, Ball)> = Vec::new();
    for seed in 1..=N_SEEDS {
        for (p, q) in solutions(&forms, seed, MOST_PATHS)? {
            let Some(mut x) = affine(&basis, &p, &q) else { continue };
            let Some(enclosed) = equations.enclose(&mut x, COEFFICIENTS) else { continue };
            let ball = enclosed.ball;
            let is_other = |(y, other): &(DVector<C>, Ball)| ball.is_apart(&x, other, y);
            if found.iter().all(is_other) {
                found.push((x, ball));
            }
        }
        if found.len() as u64 >= bound {
            break;
        }
    }
    let (mut all, mut ways) = (Vec::new(), Vec::new());
    for (x, ball) in &found {
        let is_assembly = is_real(x, ball)?;
        if is_assembly {
            ways.push(unknowns.places(x, size));
        }
        let turn = |k: usize| {
            let t = unknowns.turn(k, x);
            [t.re, t.im]
        };
        let turns = (0..parts.len()).map(turn).collect();
        all.push(Solution { turns, radius: ball.radius, is_assembly });
    }
    Some(Closed { bound, solutions: all, ways })
}

/// Shifts and turns with their conjugates where those of one are one; none at infinity.
fn affine(basis: &DMatrix<C>, p: &DVector<C>, q: &DVector<C>) -> Option<DVector<C>> {
    const AT_INFINITY: f64 = 1e-9;
    let (x, y) = (basis * p, basis.conjugate() * q);
    if x[0].norm() < AT_INFINITY * x.norm() || y[0].norm() < AT_INFINITY * y.norm() {
        return None;
    }
    let of = |v: DVector<C>| v.iter().skip(1).map(|c| c / v[0]).collect::<Vec<C>>();
    Some(DVector::from_vec([of(x), of(y)].concat()))
}

/// Whether the solution in a ball is its own mirror image; none where that is not certain.
fn is_real(x: &DVector<C>, ball: &Ball) -> Option<bool> {
    let half = x.len() / 2;
    let mirrored = DVector::from_fn(2 * half, |i, _| x[(i + half) % (2 * half)].conj());
    ball.is_own(x, &mirrored)
}

/// Orthonormal basis of the zeros of a matrix; none where its rank is not certain.
fn null_space(matrix: &DMatrix<C>) -> Option<DMatrix<C>> {
    const ZERO: f64 = 1e-12;
    const NOT_ZERO: f64 = 1e-8;
    let n = matrix.ncols();
    let mut square = DMatrix::from_element(n.max(matrix.nrows()), n, C::default());
    square.rows_mut(0, matrix.nrows()).copy_from(matrix);
    let svd = square.svd(false, true);
    let v_t = svd.v_t?;
    let largest = svd.singular_values.max();
    let share = |k: usize| svd.singular_values[k] / largest;
    if (0..n).any(|k| share(k) > ZERO && share(k) < NOT_ZERO) {
        return None;
    }
    let zero: Vec<usize> = (0..n).filter(|&k| share(k) <= ZERO).collect();
    Some(DMatrix::from_fn(n, zero.len(), |i, k| v_t[(zero[k], i)].conj()))
}

impl<'a> Unknowns<'a> {
    fn of(structure: &'a Structure, parts: &'a [usize], way: &[Option<Place>]) -> Option<Self> {
        let own = |part: usize| parts.iter().position(|p| *p == part);
        // What slides on each other has one turn.
        let mut class: Vec<usize> = (0..parts.len()).collect();
        let mut known: Vec<Option<C>> = parts
            .iter()
            .map(|part| structure.angles.contains(part).then(|| C::from(1.0)))
            .collect();
        let has_own = |k: &usize| {
            let [a, b] = structure.slides[*k].parts;
            let stands = |part: usize| way[part].is_some();
            let is_own = |part: usize| own(part).is_some();
            (is_own(a) || is_own(b)) && [a, b].into_iter().all(|p| is_own(p) || stands(p))
        };
        let slides: Vec<usize> = (0..structure.slides.len()).filter(has_own).collect();
        for &slide in &slides {
            let [a, b] = structure.slides[slide].parts;
            match (own(a), own(b)) {
                (Some(a), Some(b)) => {
                    let (to, from) = (class[a], class[b]);
                    class.iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
                }
                (Some(k), None) | (None, Some(k)) => {
                    let by = way[if own(a).is_some() { b } else { a }]?;
                    known[k] = Some(C::from_polar(1.0, by.angle));
                }
                (None, None) => {}
            }
        }
        let mut free: Vec<usize> = Vec::new();
        let turns = (0..parts.len()).map(|k| {
            let mut of_class = (0..parts.len()).filter(|&j| class[j] == class[k]);
            if let Some(turn) = of_class.find_map(|j| known[j]) {
                return Turn::Known(turn);
            }
            let number = free.iter().position(|c| *c == class[k]);
            Turn::Free(number.unwrap_or_else(|| {
                free.push(class[k]);
                free.len() - 1
            }))
        });
        let turns = turns.collect();
        let pins = 0..structure.pins.len();
        let standing = pins.map(|pin| structure.standing_pin(pin, way).is_some()).collect();
        Some(Self { structure, parts, turns, n_turns: free.len(), slides, standing })
    }

    fn own(&self, part: usize) -> Option<usize> {
        self.parts.iter().position(|p| *p == part)
    }

    fn turn_column(&self, turn: usize) -> usize {
        1 + self.parts.len() + turn
    }

    fn slide_column(&self, slide: usize) -> usize {
        1 + self.parts.len() + self.n_turns + slide
    }

    fn n_columns(&self) -> usize {
        self.slide_column(self.slides.len())
    }

    fn n_quadrics(&self) -> usize {
        self.n_turns + self.slides.len()
    }

    /// Adds `factor` times the turned point of a part, or of what stands.
    fn add_point(&self, row: &mut [C], factor: f64, k: usize, point: C) {
        row[shift_column(k)] += C::from(factor);
        match self.turns[k] {
            Turn::Known(turn) => row[0] += turn * point * factor,
            Turn::Free(turn) => row[self.turn_column(turn)] += point * factor,
        }
    }

    /// Pins and guides, linear in all columns.
    fn linear(&self, way: &[Option<Place>], size: f64) -> Option<DMatrix<C>> {
        let number = |[x, y]: [f64; 2]| C::new(x, y) / size;
        let mut rows: Vec<Vec<C>> = Vec::new();
        let empty = || vec![C::default(); self.n_columns()];
        for (pin, of) in self.structure.pins.iter().enumerate() {
            let mut own =
                of.on.iter().filter_map(|(p, point)| Some((self.own(*p)?, number(*point))));
            let mut first = empty();
            match self.structure.standing_pin(pin, way) {
                Some(at) => first[0] -= number(at),
                None => match own.next() {
                    Some((k, point)) => self.add_point(&mut first, -1.0, k, point),
                    None => continue,
                },
            }
            for (k, point) in own {
                let mut row = first.clone();
                self.add_point(&mut row, 1.0, k, point);
                rows.push(row);
            }
        }
        for (idx, &slide) in self.slides.iter().enumerate() {
            let of = &self.structure.slides[slide];
            let mut row = empty();
            for (part, sign) in of.parts.into_iter().zip([-1.0, 1.0]) {
                match self.own(part) {
                    Some(k) => self.add_point(&mut row, sign, k, C::default()),
                    None => row[0] += number(way[part]?.at) * sign,
                }
            }
            row[self.slide_column(idx)] = -C::new(of.axis[0], of.axis[1]);
            rows.push(row);
        }
        let n = rows.len();
        Some(DMatrix::from_fn(n, self.n_columns(), |i, j| rows[i][j]))
    }

    /// The turn of what slides on a guide.
    fn turn_of_slide(&self, slide: usize) -> Turn {
        let parts = self.structure.slides[self.slides[slide]].parts;
        let own = parts.into_iter().find_map(|part| self.own(part));
        own.map_or(Turn::Known(C::from(1.0)), |k| self.turns[k])
    }

    /// Terms c Xᵢ X̄ⱼ of the equations that are not linear.
    fn quadrics(&self) -> Vec<[(C, usize, usize); 2]> {
        let one = C::from(1.0);
        let turn = |k: usize| [(one, self.turn_column(k), self.turn_column(k)), (-one, 0, 0)];
        let slide = |k: usize| {
            let s = self.slide_column(k);
            match self.turn_of_slide(k) {
                Turn::Known(t) => [(t.conj(), s, 0), (-t, 0, s)],
                Turn::Free(t) => [(one, s, self.turn_column(t)), (-one, self.turn_column(t), s)],
            }
        };
        (0..self.n_turns).map(turn).chain((0..self.slides.len()).map(slide)).collect()
    }

    /// The quadrics on the linear space.
    fn forms(&self, basis: &DMatrix<C>) -> Vec<DMatrix<C>> {
        let form = |terms: [(C, usize, usize); 2]| {
            let term = |(c, i, j): (C, usize, usize)| {
                basis.row(i).transpose() * basis.row(j).conjugate() * c
            };
            term(terms[0]) + term(terms[1])
        };
        self.quadrics().into_iter().map(form).collect()
    }

    /// All equations in all unknowns, their conjugates after them.
    fn equations(&self, linear: &DMatrix<C>) -> Quadratic {
        let n = self.n_columns() - 1;
        let conjugate = |column: usize| if column == 0 { 0 } else { n + column };
        let mut rows: Vec<Vec<(C, usize, usize)>> = Vec::new();
        for row in linear.row_iter() {
            let terms = || row.iter().copied().enumerate().filter(|(_, c)| *c != C::default());
            rows.push(terms().map(|(j, c)| (c, 0, j)).collect());
            rows.push(terms().map(|(j, c)| (c.conj(), 0, conjugate(j))).collect());
        }
        let quadric = |terms: [(C, usize, usize); 2]| {
            terms.into_iter().map(|(c, i, j)| (c, i, conjugate(j))).collect()
        };
        rows.extend(self.quadrics().into_iter().map(quadric));
        Quadratic::new(rows)
    }

    /// Largest number of isolated solutions: by the ranks of turns of the group, or of one with pins in general position
    /// in place of guides. None where a rank is not certain.
    fn bound(&self, basis: &DMatrix<C>) -> Option<u64> {
        if !self.slides.is_empty() || self.n_turns < self.parts.len() {
            return self.bound_by_pins();
        }
        let rows: Vec<usize> =
            std::iter::once(0).chain((0..self.n_turns).map(|k| self.turn_column(k))).collect();
        bound_of_rows(basis, &rows)
    }

    /// The bound for pins in random points, and for angles that nobody holds.
    fn bound_by_pins(&self) -> Option<u64> {
        // A held angle would be a condition of half a pin.
        if self.parts.iter().any(|part| self.structure.angles.contains(part)) {
            return Some(binomial(self.n_quadrics()));
        }
        let mut random = Pcg64::seed_from_u64(4);
        let mut point = || C::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0));
        let n = self.parts.len();
        let mut rows: Vec<Vec<C>> = Vec::new();
        // Columns: one, shifts, turns.
        let mut pinned = |own: &[usize], stands: bool| {
            let mut first = vec![C::default(); 1 + 2 * n];
            let rest = if stands {
                first[0] = -point();
                own
            } else if let Some((k, rest)) = own.split_first() {
                first[1 + k] = C::from(-1.0);
                first[1 + n + k] = -point();
                rest
            } else {
                own
            };
            for k in rest {
                let mut row = first.clone();
                row[1 + k] = C::from(1.0);
                row[1 + n + k] = point();
                rows.push(row);
            }
        };
        for (idx, pin) in self.structure.pins.iter().enumerate() {
            let own: Vec<usize> = pin.on.iter().filter_map(|(p, _)| self.own(*p)).collect();
            pinned(&own, self.standing[idx]);
        }
        for &slide in &self.slides {
            let parts = self.structure.slides[slide].parts;
            let own: Vec<usize> = parts.into_iter().filter_map(|p| self.own(p)).collect();
            pinned(&own, own.len() == 1);
        }
        let matrix = DMatrix::from_fn(rows.len(), 1 + 2 * n, |i, j| rows[i][j]);
        let columns: Vec<usize> = std::iter::once(0).chain(1 + n..=2 * n).collect();
        bound_of_rows(&null_space(&matrix)?, &columns)
    }

    /// The turn of a part in a solution.
    fn turn(&self, k: usize, x: &DVector<C>) -> C {
        match self.turns[k] {
            Turn::Known(turn) => turn,
            Turn::Free(turn) => x[self.turn_column(turn) - 1],
        }
    }

    fn places(&self, x: &DVector<C>, size: f64) -> Vec<(usize, Place)> {
        let place = |(k, &part): (usize, &usize)| {
            let at = x[shift_column(k) - 1] * size;
            (part, Place { at: [at.re, at.im], angle: self.turn(k, x).arg() })
        };
        self.parts.iter().enumerate().map(place).collect()
    }
}

/// Column of the shift of a part.
fn shift_column(k: usize) -> usize {
    1 + k
}

/// The bound for the linear space with a basis, in its components `rows`.
fn bound_of_rows(basis: &DMatrix<C>, rows: &[usize]) -> Option<u64> {
    const ZERO: f64 = 1e-10;
    const NOT_ZERO: f64 = 1e-6;
    let is_certain = Cell::new(true);
    let rank = |set: u32| {
        let chosen: Vec<_> = (0..rows.len())
            .filter(|k| set >> k & 1 == 1)
            .map(|k| basis.row(rows[k]).into_owned())
            .map(|row| if row.norm() > ZERO { row.normalize() } else { row * C::default() })
            .collect();
        if chosen.is_empty() {
            return 0;
        }
        let values = DMatrix::from_rows(&chosen).singular_values();
        if values.iter().any(|v| *v > ZERO && *v < NOT_ZERO) {
            is_certain.set(false);
        }
        u32::try_from(values.iter().filter(|v| **v >= NOT_ZERO).count()).unwrap_or(0)
    };
    let bound = n_inverse_pairs(rows.len(), rank)?;
    is_certain.get().then_some(bound)
}

/// C(n, n/2): Bézout's number.
fn binomial(n: usize) -> u64 {
    let half = n as u64 / 2;
    (1..=half).fold(1, |c, k| c * (half + k) / k)
}
