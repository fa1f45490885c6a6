//! Four-bars that generate a function, by Freudenstein's equation.
//!
//! ```text
//! K₁ cos ψ − K₂ cos φ + K₃ = cos(φ − ψ)       K₁ = d/a, K₂ = d/c, K₃ = (a² − b² + c² + d²)/(2 a c)
//! ```
//!
//! Three points give K; four leave one offset free, five both. With offsets the equation is linear in the parts of
//! K₁ e^{iψ₀}, K₂ e^{iφ₀}, K₃, e^{i(φ₀ − ψ₀)}: two vectors span its solutions, and that the arguments fit is a
//! polynomial of degree two or three in their ratio. Source: Freudenstein, Trans. ASME 77 (1955).

use bksim::expr::{Pool, Tape};
use bksim::model::message::short;
use nalgebra::{Complex, DMatrix, DVector};
use serde::Deserialize;

use super::four_bar::FourBar;
use super::polynomial::{roots, through};
use super::{Candidate, DesignError, Synthesis, all_si, none, optional};
use crate::codes;
use crate::spec::Written;

/// Pairs of angles, or a function with its scales.
#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Wish {
    /// Angles of the crank at the points, or its first and last with `function`.
    phi: Vec<Written>,
    /// Angles of the follower.
    psi: Vec<Written>,
    /// An expression of `x`: `log10(x)`.
    function: Option<String>,
    /// Range of x.
    x: Option<[f64; 2]>,
    /// Number of accuracy points, at Chebyshev's places; 3 unless given.
    points: Option<usize>,
    /// `none`, `phi`, `psi` or `both`: which angles may be counted from anywhere.
    offsets: Option<String>,
    /// Distance of the pivots; 1 m unless given.
    ground: Option<Written>,
}

/// A function and how x and y are angles.
struct Scaled {
    tape: Tape,
    x: [f64; 2],
    y: [f64; 2],
    phi: [f64; 2],
    psi: [f64; 2],
}

impl Scaled {
    fn y(&self, x: f64) -> f64 {
        let mut out = [0.0];
        self.tape.evaluate(&mut self.tape.workspace(&[]), &[x], &mut out);
        out[0]
    }

    fn angles(&self, x: f64) -> [f64; 2] {
        let share = |value: f64, [from, to]: [f64; 2]| (value - from) / (to - from);
        let at = |share: f64, [from, to]: [f64; 2]| from + share * (to - from);
        [at(share(x, self.x), self.phi), at(share(self.y(x), self.y), self.psi)]
    }
}

/// Values beyond this many of those at the ends belong to a pole.
const UNBOUNDED: f64 = 1e6;

fn scaled(wish: &Wish, text: &str, phi: &[f64], psi: &[f64]) -> Result<Scaled, DesignError> {
    let bad = |why: &str| {
        let help = "write `function = \"log10(x)\"`, `x = [1, 2]`, and the first and last angle as `phi` and `psi`";
        DesignError::fault(codes::BAD_QUESTION, why, help)
    };
    let pool = Pool::new();
    let e = pool.parse(text).map_err(|error| bad(&format!("`{text}` is no function: {error}")))?;
    let x = wish.x.ok_or_else(|| bad("the function has no range"))?;
    let symbol = pool.symbol_id(pool.symbol("x")).ok_or_else(|| bad("the function has no `x`"))?;
    let tape =
        Tape::compile(&pool, &[e], &[symbol], &[]).map_err(|error| bad(&error.to_string()))?;
    let two = |all: &[f64]| {
        <[f64; 2]>::try_from(all).map_err(|_| bad("`phi` and `psi` have two ends each"))
    };
    let mut found = Scaled { tape, x, y: [0.0; 2], phi: two(phi)?, psi: two(psi)? };
    found.y = [found.y(x[0]), found.y(x[1])];
    if !(found.y[0] - found.y[1]).is_normal() {
        return Err(bad("the function has the same value at both ends of its range, or none"));
    }
    // Nor may it leave all bounds in between: the follower would have to turn without end.
    let size = |x: f64| Some(found.y(x).abs()).filter(|y| !y.is_nan()).unwrap_or(f64::INFINITY);
    let (most, at) = largest(&size, x);
    if most > UNBOUNDED * (found.y[0].abs() + found.y[1].abs()) {
        let message = format!("the function has no finite value near x = {}", short(at));
        let help = "end the range before that place, or begin after it";
        let fault = DesignError::fault(codes::BAD_QUESTION, message, help);
        return Err(fault);
    }
    Ok(found)
}

/// A linkage: K, offsets.
struct Solved {
    k: [f64; 3],
    phi0: f64,
    psi0: f64,
}

pub(super) fn solve(wish: &Wish) -> Result<Synthesis, DesignError> {
    let ground = optional(wish.ground.as_ref())?.unwrap_or(1.0);
    let (mut phi, mut psi) = (all_si(&wish.phi)?, all_si(&wish.psi)?);
    let function =
        wish.function.as_deref().map(|text| scaled(wish, text, &phi, &psi)).transpose()?;
    let mut facts = std::collections::BTreeMap::new();
    if let Some(function) = &function {
        let n = wish.points.unwrap_or(3).clamp(3, 10_000);
        let [from, to] = function.x;
        let place = |k: usize| {
            let angle = std::f64::consts::PI * (2 * k + 1) as f64 / (2 * n) as f64;
            0.5 * (from + to) - 0.5 * (to - from) * angle.cos()
        };
        let points: Vec<f64> = (0..n).map(place).collect();
        let angles: Vec<[f64; 2]> = points.iter().map(|&x| function.angles(x)).collect();
        phi = angles.iter().map(|a| a[0]).collect();
        psi = angles.iter().map(|a| a[1]).collect();
        facts.insert("accuracy_points".to_owned(), points);
    }
    if phi.len() != psi.len() || phi.len() < 3 {
        let message = format!(
            "{} angles of the crank and {} of the follower make no task",
            phi.len(),
            psi.len()
        );
        return Err(DesignError::fault(
            codes::BAD_QUESTION,
            message,
            "give as many of both, three or more",
        ));
    }
    let offsets = wish.offsets.as_deref().unwrap_or("none");
    let (solved, n_complex) = match (offsets, phi.len()) {
        ("none", _) => (plain(&phi, &psi).into_iter().collect(), 1),
        ("phi", 4) => with_offsets(&phi, &psi, false),
        ("psi", 4) => with_offset_of_psi(&phi, &psi),
        ("both", 5) => with_offsets(&phi, &psi, true),
        _ => {
            let message =
                format!("`offsets = \"{offsets}\"` does not go with {} points", phi.len());
            let help = "3 points and more have `offsets = \"none\"`, 4 `\"phi\"` or `\"psi\"`, 5 `\"both\"`";
            return Err(DesignError::fault(codes::BAD_QUESTION, message, help));
        }
    };
    facts.insert("complex_solutions".to_owned(), vec![f64::from(n_complex)]);
    let mut candidates = Vec::new();
    for (number, one) in solved.iter().enumerate() {
        if let Some(found) = candidate(one, number + 1, ground, (&phi, &psi), function.as_ref()) {
            candidates.push(found);
        }
    }
    facts.insert("real_solutions".to_owned(), vec![candidates.len() as f64]);
    if candidates.is_empty() {
        return Err(none(
            "no four-bar with real lengths generates this",
            "change the ranges of the angles, or free the offsets",
        ));
    }
    let error = |c: &Candidate| c.numbers.get("structural_error_max").copied().unwrap_or(0.0);
    candidates.sort_by(|a, b| error(a).total_cmp(&error(b)));
    Ok(Synthesis { task: "function".to_owned(), facts, candidates, ..Synthesis::default() })
}

/// K without offsets; of more than three points by least squares.
fn plain(phi: &[f64], psi: &[f64]) -> Option<Solved> {
    let n = phi.len();
    let matrix = DMatrix::from_fn(n, 3, |i, j| [psi[i].cos(), -phi[i].cos(), 1.0][j]);
    let right = DVector::from_fn(n, |i, _| (phi[i] - psi[i]).cos());
    let k = if n == 3 {
        matrix.lu().solve(&right)?
    } else {
        matrix.svd(true, true).solve(&right, 1e-13).ok()?
    };
    Some(Solved { k: [k[0], k[1], k[2]], phi0: 0.0, psi0: 0.0 })
}

/// Solutions with the offset of φ free, or both; real ones, and the number of complex ones.
fn with_offsets(phi: &[f64], psi: &[f64], both: bool) -> (Vec<Solved>, u32) {
    let n = phi.len();
    // Unknowns: K₁ e^{iψ₀} (K₁ alone), K₂ e^{iφ₀}, K₃, e^{i(φ₀ − ψ₀)}.
    let row = |i: usize| {
        let off = phi[i] - psi[i];
        let mut row = vec![psi[i].cos()];
        if both {
            row.push(-psi[i].sin());
        }
        row.extend([-phi[i].cos(), phi[i].sin(), 1.0, -off.cos(), off.sin()]);
        row
    };
    let m = if both { 7 } else { 6 };
    let rows: Vec<Vec<f64>> = (0..n).map(row).collect();
    let square = DMatrix::from_fn(m, m, |i, j| rows.get(i).map_or(0.0, |row| row[j]));
    let svd = square.svd(false, true);
    let Some(v_t) = svd.v_t else { return (Vec::new(), 0) };
    // The two vectors of least singular values.
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|a, b| svd.singular_values[*a].total_cmp(&svd.singular_values[*b]));
    let vector = |t: f64| -> Vec<f64> {
        (0..m).map(|j| v_t[(order[0], j)] + t * v_t[(order[1], j)]).collect()
    };
    let parts = |u: &[f64]| {
        let (z1, rest) = if both {
            (Complex::new(u[0], u[1]), &u[2..])
        } else {
            (Complex::new(u[0], 0.0), &u[1..])
        };
        (z1, Complex::new(rest[0], rest[1]), rest[2], Complex::new(rest[3], rest[4]))
    };
    let condition = |t: f64| {
        let u = vector(t);
        let (z1, z3, _, z6) = parts(&u);
        if both { (z6 * z1 * z3.conj()).im } else { (z6 * z3.conj()).im }
    };
    let degree = if both { 3 } else { 2 };
    let all = roots(&through(degree, condition));
    let n_complex = u32::try_from(all.len()).unwrap_or(0);
    let real = all.iter().filter(|root| root.im.abs() < 1e-7 * (1.0 + root.re.abs()));
    let one = |root: &Complex<f64>| {
        let u = vector(root.re);
        let (z1, z3, k3, z6) = parts(&u);
        let size = z6.norm();
        if size < 1e-12 {
            return None;
        }
        // A common factor, its sign so that K₂ and, by the offset of ψ, K₁ are above zero.
        let phi0 = z3.arg();
        let (scale, psi0) = if both {
            let psi0 = z1.arg();
            let fits = (z6 * Complex::from_polar(1.0, psi0 - phi0)).re > 0.0;
            (if fits { 1.0 / size } else { -1.0 / size }, psi0)
        } else {
            let fits = (z6 * Complex::from_polar(1.0, -phi0)).re > 0.0;
            (if fits { 1.0 / size } else { -1.0 / size }, 0.0)
        };
        // A factor below zero turns K₁ and K₂ about: both offsets by half a turn.
        let k1 = scale * if both { z1.norm() } else { z1.re };
        let k2 = scale * z3.norm();
        let (mut k1, mut k2, mut phi0, mut psi0) = (k1, k2, phi0, psi0);
        if both && k1 < 0.0 {
            (k1, psi0) = (-k1, psi0 + std::f64::consts::PI);
            (k2, phi0) = (-k2, phi0 + std::f64::consts::PI);
        }
        Some(Solved { k: [k1, k2, scale * k3], phi0: turned(phi0), psi0: turned(psi0) })
    };
    (real.filter_map(one).collect(), n_complex)
}

/// Solutions with the offset of ψ free: those of φ for the linkage seen from its other side, φ' = π − ψ, ψ' = π − φ.
fn with_offset_of_psi(phi: &[f64], psi: &[f64]) -> (Vec<Solved>, u32) {
    let seen = |angles: &[f64]| -> Vec<f64> {
        angles.iter().map(|angle| std::f64::consts::PI - angle).collect()
    };
    let (found, n_complex) = with_offsets(&seen(psi), &seen(phi), false);
    let back =
        |one: Solved| Solved { k: [one.k[1], one.k[0], one.k[2]], phi0: 0.0, psi0: -one.phi0 };
    (found.into_iter().map(back).collect(), n_complex)
}

/// Lengths beyond this many grounds are those of a linkage at infinity.
const LONGEST: f64 = 1e6;

/// An angle in −π ..= π.
fn turned(angle: f64) -> f64 {
    use std::f64::consts::TAU;
    angle - TAU * (angle / TAU).round()
}

/// The follower's angle at an angle of the crank, nearest to one that is wanted.
fn follower([a, b, c, d]: [f64; 4], phi: f64, near: f64) -> Option<f64> {
    let (x, y) = (a * phi.cos() - d, a * phi.sin());
    let l = x.hypot(y);
    let cosine = (l * l + c * c - b * b) / (2.0 * l * c);
    if cosine.abs() > 1.0 {
        return None;
    }
    let angles = [1.0, -1.0].map(|sign| y.atan2(x) + sign * cosine.acos());
    let off = |angle: f64| turned(angle - near);
    let [first, second] = angles.map(off);
    Some(near + if first.abs() <= second.abs() { first } else { second })
}

fn candidate(
    solved: &Solved,
    number: usize,
    d: f64,
    (phi, psi): (&[f64], &[f64]),
    function: Option<&Scaled>,
) -> Option<Candidate> {
    let [k1, k2, k3] = solved.k;
    let (a, c) = (d / k1, d / k2);
    let b2 = a * a + c * c + d * d - 2.0 * a * c * k3;
    // Lengths without bound are a root of the polynomial, but no linkage.
    let is_bounded = [a, c].iter().all(|length| length.abs() < LONGEST * d.abs());
    if b2.is_nan() || b2 <= 0.0 || !is_bounded {
        return None;
    }
    let lengths = [a, b2.sqrt(), c, d];
    let at = |phi: f64, psi: f64| FourBar {
        pivots: [[0.0, 0.0], [d, 0.0]],
        pins: [
            [a * (phi + solved.phi0).cos(), a * (phi + solved.phi0).sin()],
            [d + c * (psi + solved.psi0).cos(), c * (psi + solved.psi0).sin()],
        ],
        point: None,
    };
    let poses: Vec<FourBar> = phi.iter().zip(psi).map(|(&phi, &psi)| at(phi, psi)).collect();
    let mut found = poses[0].candidate(&format!("function-{number}"));
    for (name, value) in [
        ("K1", k1),
        ("K2", k2),
        ("K3", k3),
        ("a", a),
        ("b", lengths[1]),
        ("c", c),
        ("phi0", solved.phi0),
        ("psi0", solved.psi0),
    ] {
        found.numbers.insert(name.to_owned(), value);
    }
    // One branch: the rocker pin on one side of the line from crank pin to rocker pivot.
    let sides =
        poses.iter().map(|bar| super::four_bar::side(bar.pins[0], bar.pivots[1], bar.pins[1]));
    let signs: Vec<bool> = sides.map(|side| side > 0.0).collect();
    found.checks.insert("one_branch".to_owned(), signs.windows(2).all(|pair| pair[0] == pair[1]));
    let least = poses.iter().map(FourBar::transmission).fold(f64::INFINITY, f64::min);
    found.numbers.insert("least_transmission_angle".to_owned(), least);
    if let Some(function) = function {
        let error = |x: f64| {
            let [phi, psi] = function.angles(x);
            let real = follower(lengths, phi + solved.phi0, psi + solved.psi0);
            real.map_or(f64::INFINITY, |real| (real - psi - solved.psi0).abs())
        };
        let (worst, x) = largest(&error, function.x);
        found.numbers.insert("structural_error_max".to_owned(), worst);
        found.numbers.insert("structural_error_at_x".to_owned(), x);
    }
    Some(found)
}

/// The largest value of a function over a range, and where it is.
pub(super) fn largest(f: &dyn Fn(f64) -> f64, [from, to]: [f64; 2]) -> (f64, f64) {
    let n = 2000;
    let at = |k: usize| if k == n { to } else { from + (to - from) * k as f64 / n as f64 };
    let f = |x: f64| Some(f(x)).filter(|y| !y.is_nan()).unwrap_or(f64::NEG_INFINITY);
    let values: Vec<f64> = (0..=n).map(|k| f(at(k))).collect();
    let best = (0..=n).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
    let (mut low, mut high) = (at(best.saturating_sub(1)), at((best + 1).min(n)));
    // Golden section.
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..80 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if f(a) < f(b) { low = a } else { high = b }
    }
    let x = 0.5 * (low + high);
    let inner = (f(x), x);
    [(values[best], at(best)), inner]
        .into_iter()
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or(inner)
}
