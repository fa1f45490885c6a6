//! Closures of a platform on three legs.
//!
//! ```text
//! z, T = e^(iθ)                            shift and turn of the platform; everything a complex number
//! E   s z z̄ + α(T) z̄ + ᾱ z + γ(T) = 0      of each leg
//! RR  |z + T p − a|² = l²                  s = 1, α = T p − a
//! PR  Re(n̄ (z + T p − f)) = 0              s = 0, α = n/2
//! RP  Re(T̄ n̄ (z − a + T c)) = 0            s = 0, α = T n/2
//! ```
//!
//! Differences of two circles and the equations of guides are linear in z and z̄; two of them give z = N/Δ, z̄ = N̄/Δ,
//! and the third equation becomes a polynomial in T, of degree six for three links. Three guides give a determinant.
//! z is measured so that a link begins in the origin: E is z z̄ = l² for it, and the degree is the lowest.

use super::laurent::{C, Laurent, Root};
use super::order::Leg;
use super::place::{Place, heading, left, less, turned};
use super::structure::{Pair, Structure};

/// The equation of a leg.
struct Equation {
    /// True with z z̄.
    is_circle: bool,
    alpha: Laurent,
    gamma: Laurent,
}

/// A leg in numbers, in lengths of the mechanism.
enum Span {
    /// Standing pin a, platform's point p, length l.
    Link { a: C, p: C, l: f64 },
    /// Point f and normal n of the line, platform's point p.
    Guided { f: C, n: C, p: C },
    /// Standing pin a, the leg's point c on it, normal n of the guide.
    Sliding { a: C, c: C, n: C },
}

/// Roots of the platform's turn, and the closures of those on the circle.
type Closed = (Vec<Root>, Vec<Vec<(usize, Place)>>);

/// All closures; none where rounding could decide.
pub(super) fn closures(
    structure: &Structure,
    platform: usize,
    legs: &[Leg; 3],
    way: &[Option<Place>],
    size: f64,
) -> Option<Closed> {
    /// Sines, and |Δ| over its parts, below which two equations are one.
    const DEPENDENT: f64 = 1e-9;
    let spans: Vec<Span> =
        legs.iter().map(|leg| span(structure, platform, leg, way, size)).collect::<Option<_>>()?;
    // The first link begins in the origin.
    let origin = spans.iter().find_map(|span| match *span {
        Span::Link { a, p, .. } => Some((a, p)),
        _ => None,
    });
    let (a0, p0) = origin.unwrap_or_default();
    let equations: Vec<Equation> = spans.iter().map(|span| equation(span, a0, p0)).collect();

    // Linear ones, the circle apart.
    let circle = equations.iter().find(|e| e.is_circle);
    let linear: Vec<(Laurent, Laurent)> = equations
        .iter()
        .filter(|e| circle.is_none_or(|circle| !std::ptr::eq(*e, circle)))
        .map(|e| match circle {
            Some(circle) if e.is_circle => {
                (e.alpha.minus(&circle.alpha), e.gamma.minus(&circle.gamma))
            }
            _ => (e.alpha.clone(), e.gamma.clone()),
        })
        .collect();
    let delta = |i: usize, j: usize| {
        let (a, b) = (&linear[i].0, &linear[j].0);
        a.times(&b.conjugate()).minus(&a.conjugate().times(b))
    };
    // Numerator of z from equations i and j.
    let shift = |i: usize, j: usize| {
        let ((a, c), (b, d)) = (&linear[i], &linear[j]);
        b.times(c).minus(&a.times(d))
    };
    let polynomial = if let Some(circle) = circle {
        let (delta, z) = (delta(0, 1), shift(0, 1));
        // z̄ = N̄/Δ̄, and Δ̄ = −Δ.
        let square = z.times(&z.conjugate());
        let across = circle.alpha.times(&z.conjugate()).minus(&circle.alpha.conjugate().times(&z));
        let rest = circle.gamma.times(&delta).minus(&across);
        square.minus(&rest.times(&delta))
    } else {
        // det (α, ᾱ, γ) = 0.
        let minors = [(0, 1, 2), (1, 2, 0), (2, 0, 1)];
        let terms = minors.map(|(k, i, j)| linear[k].1.times(&delta(i, j)));
        terms[0].plus(&terms[1]).plus(&terms[2])
    };
    let roots = polynomial.roots()?;

    let mut ways = Vec::new();
    for root in roots.iter().filter(|root| root.is_assembly) {
        let angle = root.im.atan2(root.re);
        let t = C::from_polar(1.0, angle);
        // The two equations that are farthest from being one.
        let pairs = if circle.is_some() { vec![(0, 1)] } else { vec![(0, 1), (1, 2), (2, 0)] };
        let best = pairs.into_iter().map(|(i, j)| {
            let scale = linear[i].0.at(t).norm() * linear[j].0.at(t).norm();
            (delta(i, j).at(t).norm() / scale, i, j)
        });
        let (sine, i, j) = best.max_by(|a, b| a.0.total_cmp(&b.0))?;
        if sine.is_nan() || sine < DEPENDENT {
            return None;
        }
        let z = shift(i, j).at(t) / delta(i, j).at(t) - t * p0 + a0;
        let place = Place { at: [z.re * size, z.im * size], angle };
        let mut closure = vec![(platform, place)];
        for leg in legs {
            closure.push((leg.part, leg_place(structure, platform, leg, &place, way)?));
        }
        ways.push(closure);
    }
    Some((roots, ways))
}

fn complex([x, y]: [f64; 2]) -> C {
    C::new(x, y)
}

fn span(
    structure: &Structure,
    platform: usize,
    leg: &Leg,
    way: &[Option<Place>],
    size: f64,
) -> Option<Span> {
    let number = |v: [f64; 2]| complex(v) / size;
    let own = |pin: usize, part: usize| number(structure.point(pin, part));
    Some(match (leg.standing, leg.platform) {
        (Pair::Pin(a), Pair::Pin(x)) => Span::Link {
            a: number(structure.standing_pin(a, way)?),
            p: own(x, platform),
            l: (own(x, leg.part) - own(a, leg.part)).norm(),
        },
        (Pair::Slide(slide), Pair::Pin(x)) => {
            let by = way[structure.other(slide, leg.part)]?;
            let normal = left(turned(structure.slides[slide].axis, by.angle));
            let foot = by.apply(structure.point(x, leg.part));
            Span::Guided { f: number(foot), n: complex(normal), p: own(x, platform) }
        }
        (Pair::Pin(a), Pair::Slide(slide)) => Span::Sliding {
            a: number(structure.standing_pin(a, way)?),
            c: own(a, leg.part),
            n: complex(left(structure.slides[slide].axis)),
        },
        (Pair::Slide(_), Pair::Slide(_)) => return None,
    })
}

/// The equation of a leg, points measured from a₀ on what stands and from p₀ on the platform.
fn equation(span: &Span, a0: C, p0: C) -> Equation {
    let half = C::from(0.5);
    // Twice the real part of c T.
    let both = |c: C| Laurent::new(&[(1, c), (-1, c.conj())]);
    let number = |x: f64| Laurent::new(&[(0, C::from(x))]);
    match *span {
        Span::Link { a, p, l } => {
            let (a, p) = (a - a0, p - p0);
            Equation {
                is_circle: true,
                alpha: Laurent::new(&[(1, p), (0, -a)]),
                gamma: number(p.norm_sqr() + a.norm_sqr() - l * l).minus(&both(p * a.conj())),
            }
        }
        Span::Guided { f, n, p } => {
            let (f, p) = (f - a0, p - p0);
            Equation {
                is_circle: false,
                alpha: Laurent::new(&[(0, n * half)]),
                gamma: both(n.conj() * p * half).minus(&number((n.conj() * f).re)),
            }
        }
        Span::Sliding { a, c, n } => {
            let (a, c) = (a - a0, c - p0);
            Equation {
                is_circle: false,
                alpha: Laurent::new(&[(1, n * half)]),
                gamma: number((n.conj() * c).re).minus(&both(n * a.conj() * half)),
            }
        }
    }
}

/// The place of a leg where the platform stands.
fn leg_place(
    structure: &Structure,
    platform: usize,
    leg: &Leg,
    place: &Place,
    way: &[Option<Place>],
) -> Option<Place> {
    Some(match (leg.standing, leg.platform) {
        (Pair::Pin(a), Pair::Pin(x)) => {
            let from = structure.standing_pin(a, way)?;
            let to = place.apply(structure.point(x, platform));
            let own = less(structure.point(x, leg.part), structure.point(a, leg.part));
            let angle = heading(less(to, from)) - heading(own);
            Place::bringing(structure.point(a, leg.part), from, angle)
        }
        (Pair::Slide(slide), Pair::Pin(x)) => {
            let to = place.apply(structure.point(x, platform));
            let angle = way[structure.other(slide, leg.part)]?.angle;
            Place::bringing(structure.point(x, leg.part), to, angle)
        }
        (Pair::Pin(a), _) => {
            let from = structure.standing_pin(a, way)?;
            Place::bringing(structure.point(a, leg.part), from, place.angle)
        }
        (Pair::Slide(_), Pair::Slide(_)) => return None,
    })
}
