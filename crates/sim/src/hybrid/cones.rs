//! Forces and impulses of contacts that rub in two directions, within one cone of friction each.
//!
//! ```text
//! s = b_n + A_nn P + A_nt L ≥ 0 ⊥ P ≥ 0             s: how fast bodies part, beyond what is asked of them
//! w = b_t + A_tn P + A_tt L
//! w = 0 and |L| ≤ μ P,   or   L = −μ P w/|w|
//! ```
//!
//! of impulses and velocities, or of forces and accelerations. Contacts are solved one after the other, each exactly with the
//! forces of the others as they are, until nothing changes (the Gauss–Seidel method of nonsmooth contact dynamics). What is
//! found so says which contacts push, stick and slide; with these, Newton's method takes the forces to the last digit.
//!
//! Source: M. Jean, *The non-smooth contact dynamics method*, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235; V. Acary and
//! B. Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008), §13.7.

use nalgebra::{DMatrix, DVector};

/// State of a contact in a solution: apart, sticking or sliding.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Grip {
    /// No force.
    Apart,
    /// Without slip, or without friction.
    Sticks,
    /// With the slip along this unit vector.
    Slides([f64; 2]),
}

/// The friction of a contact.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Cone {
    /// Row of its pressing force.
    pub(super) normal: usize,
    /// Rows of its friction; `None` without friction.
    pub(super) along: Option<[usize; 2]>,
    /// μ while it slides, and while it sticks.
    pub(super) mu: f64,
    pub(super) holding: f64,
    /// The unit vector along which it slides whatever the forces, where it does.
    pub(super) slip: Option<[f64; 2]>,
    /// It has just reached its limit, and slides unless nothing else is possible.
    pub(super) lets_go: bool,
}

/// Contacts as they feel each other's forces.
pub(super) struct Cones<'a> {
    /// Parting and slip by unit forces.
    pub(super) a: &'a DMatrix<f64>,
    /// Parting and slip without forces.
    pub(super) b: &'a DVector<f64>,
    pub(super) places: &'a [Cone],
}

/// Forces with what each contact does.
pub(super) struct Forces {
    pub(super) p: DVector<f64>,
    pub(super) grips: Vec<Grip>,
}

/// Rounds over all contacts, and the part of the largest force by which the last one changes them.
const MOST_ROUNDS: usize = 4000;
const UNCHANGED: f64 = 1e-15;
/// Part of the largest force with which Newton's method is begun, and with which the rounds may end.
const NEAR: f64 = 1e-4;
const FITS: f64 = 1e-10;
/// Rounds between tries of Newton's method.
const BETWEEN: usize = 20;
/// Directions among which that of the slip is sought, and halvings between two of them.
const DIRECTIONS: u32 = 48;
const HALVINGS: usize = 60;
const MOST_STEPS: usize = 12;
/// Singular values below this part of the largest are none.
const SMALLEST: f64 = 1e-11;

impl Cones<'_> {
    /// The first contact that slides so that its own force, with the friction that it brings about, does not part the
    /// bodies.
    pub(super) fn weak(&self) -> Option<usize> {
        let is_weak = |cone: &&Cone| {
            let (Some([j, k]), Some([c, s])) = (cone.along, cone.slip) else { return false };
            let a = |column: usize| self.a[(cone.normal, column)];
            a(cone.normal) <= cone.mu * (a(j) * c + a(k) * s)
        };
        self.places.iter().find(is_weak).map(|cone| cone.normal)
    }

    /// The forces; `None` where the rounds do not converge.
    pub(super) fn solve(&self) -> Option<Forces> {
        let n = self.b.len();
        let mut p = DVector::zeros(n);
        let mut grips = vec![Grip::Apart; self.places.len()];
        let mut change = f64::INFINITY;
        for round in 1..=MOST_ROUNDS {
            let before = p.clone();
            for (cone, grip) in self.places.iter().zip(&mut grips) {
                *grip = self.solve_one(cone, &mut p)?;
            }
            let size = p.amax();
            change = (&p - before).amax();
            if change <= UNCHANGED * size {
                return Some(Forces { p, grips });
            }
            if change <= NEAR * size
                && round % BETWEEN == 0
                && let Some(found) = self.polished(&Forces { p: p.clone(), grips: grips.clone() })
            {
                return Some(found);
            }
        }
        (change <= FITS * p.amax()).then_some(Forces { p, grips })
    }

    /// The parting and slip that one contact would have without its own force.
    fn without(&self, row: usize, own: &[usize], p: &DVector<f64>) -> f64 {
        let all: f64 = self.a.row(row).iter().zip(p.iter()).map(|(a, p)| a * p).sum();
        let mine: f64 = own.iter().map(|&k| self.a[(row, k)] * p[k]).sum();
        self.b[row] + all - mine
    }

    /// Puts the force of one contact in place; `None` where its own force does not part its bodies.
    fn solve_one(&self, cone: &Cone, p: &mut DVector<f64>) -> Option<Grip> {
        let i = cone.normal;
        let a = |row: usize, column: usize| self.a[(row, column)];
        let Some([j, k]) = cone.along else {
            let free = self.without(i, &[i], p);
            p[i] = if free < 0.0 { -free / a(i, i) } else { 0.0 };
            return Some(if free < 0.0 { Grip::Sticks } else { Grip::Apart });
        };
        let own = [i, j, k];
        let free = own.map(|row| self.without(row, &own, p));
        let put = |p: &mut DVector<f64>, force: [f64; 3]| {
            own.iter().zip(force).for_each(|(&row, force)| p[row] = force);
        };
        if free[0] >= 0.0 {
            put(p, [0.0; 3]);
            return Some(Grip::Apart);
        }
        // Force and slip where friction is along a unit vector.
        let sliding = |[c, s]: [f64; 2]| {
            let parts = a(i, i) - cone.mu * (a(i, j) * c + a(i, k) * s);
            let push = -free[0] / parts;
            let force = [push, -cone.mu * push * c, -cone.mu * push * s];
            let slip = [1, 2].map(|at| {
                free[at] + own.iter().zip(force).map(|(&of, f)| a(own[at], of) * f).sum::<f64>()
            });
            (parts > 0.0).then_some((force, slip))
        };
        if let Some(way) = cone.slip {
            let (force, _) = sliding(way)?;
            put(p, force);
            return Some(Grip::Slides(way));
        }
        let block = DMatrix::from_fn(3, 3, |row, column| a(own[row], own[column]));
        let held = block.lu().solve(&-DVector::from_column_slice(&free));
        let held =
            held.filter(|held| held[0] >= 0.0 && held[1].hypot(held[2]) <= cone.holding * held[0]);
        let hold = |p: &mut DVector<f64>| {
            let held = held.as_ref()?;
            put(p, [held[0], held[1], held[2]]);
            Some(Grip::Sticks)
        };
        if !cone.lets_go && held.is_some() {
            return hold(p);
        }
        let least = if cone.lets_go { -FITS * free[1].hypot(free[2]) } else { 0.0 };
        // The slip is along the unit vector that its friction is against: a root of their product across.
        let at = |angle: f64| {
            let (s, c) = angle.sin_cos();
            let (_, [w1, w2]) = sliding([c, s])?;
            Some((c * w2 - s * w1, c * w1 + s * w2))
        };
        let step = std::f64::consts::TAU / f64::from(DIRECTIONS);
        let mut best: Option<(f64, f64)> = None;
        for n in 0..DIRECTIONS {
            let [mut low, mut high] = [f64::from(n) * step, f64::from(n + 1) * step];
            let (Some((mut below, _)), Some((above, _))) = (at(low), at(high)) else { continue };
            if (below > 0.0) == (above > 0.0) {
                continue;
            }
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(low, high);
                let (value, _) = at(middle)?;
                if (value > 0.0) == (below > 0.0) {
                    (low, below) = (middle, value);
                } else {
                    high = middle;
                }
            }
            let angle = f64::midpoint(low, high);
            let (_, speed) = at(angle)?;
            if speed >= least && best.is_none_or(|(_, most)| speed > most) {
                best = Some((angle, speed));
            }
        }
        let Some((angle, _)) = best else { return hold(p) };
        let way = [angle.cos(), angle.sin()];
        let (force, _) = sliding(way)?;
        put(p, force);
        Some(Grip::Slides(way))
    }

    /// The forces to the last digit while contacts go on doing what they do; `None` where they do not.
    fn polished(&self, near: &Forces) -> Option<Forces> {
        let mut p = near.p.clone();
        let n = p.len();
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let rates = self.b + self.a * &p;
            let (mut matrix, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
            let hold = |matrix: &mut DMatrix<f64>, right: &mut DVector<f64>, row: usize| {
                matrix.row_mut(row).copy_from(&self.a.row(row));
                right[row] = -rates[row];
            };
            for (cone, grip) in self.places.iter().zip(&near.grips) {
                let i = cone.normal;
                if *grip == Grip::Apart {
                    for row in cone.rows() {
                        matrix[(row, row)] = 1.0;
                        right[row] = -p[row];
                    }
                    continue;
                }
                hold(&mut matrix, &mut right, i);
                let Some([j, k]) = cone.along else { continue };
                let speed = rates[j].hypot(rates[k]);
                match *grip {
                    Grip::Slides(way) if cone.slip.is_some() || speed == 0.0 => {
                        for (row, part) in [j, k].into_iter().zip(way) {
                            matrix[(row, row)] = 1.0;
                            matrix[(row, i)] = cone.mu * part;
                            right[row] = -p[row] - cone.mu * part * p[i];
                        }
                    }
                    Grip::Slides(_) => {
                        // L |w| + μ P w = 0.
                        let unit = [rates[j] / speed, rates[k] / speed];
                        for row in [j, k] {
                            for column in 0..n {
                                let slower =
                                    unit[0] * self.a[(j, column)] + unit[1] * self.a[(k, column)];
                                matrix[(row, column)] =
                                    p[row] * slower + cone.mu * p[i] * self.a[(row, column)];
                            }
                            matrix[(row, row)] += speed;
                            matrix[(row, i)] += cone.mu * rates[row];
                            right[row] = -p[row] * speed - cone.mu * p[i] * rates[row];
                        }
                    }
                    _ => [j, k].into_iter().for_each(|row| hold(&mut matrix, &mut right, row)),
                }
            }
            let decomposed = matrix.svd(true, true);
            let smallest = SMALLEST * decomposed.singular_values.max();
            let step = decomposed.solve(&right, smallest).ok()?;
            p += &step;
            let change = step.amax() / p.amax().max(f64::MIN_POSITIVE);
            if change >= last && change <= FITS {
                return self.fitting(p, near);
            }
            last = change;
        }
        None
    }

    /// These forces, where every contact does with them what it did before.
    fn fitting(&self, p: DVector<f64>, near: &Forces) -> Option<Forces> {
        let rates = self.b + self.a * &p;
        let (force, rate) = (FITS * p.amax(), FITS * self.b.amax().max(rates.amax()));
        let mut grips = near.grips.clone();
        for (cone, grip) in self.places.iter().zip(&mut grips) {
            let i = cone.normal;
            let fits = match (&grip, cone.along) {
                (Grip::Apart, _) => rates[i] >= -rate,
                (_, None) => p[i] >= -force,
                (Grip::Sticks, Some([j, k])) => {
                    p[i] >= -force && p[j].hypot(p[k]) <= cone.holding * p[i] + force
                }
                (Grip::Slides(_), Some([j, k])) => {
                    let (w, speed) = ([rates[j], rates[k]], rates[j].hypot(rates[k]));
                    let is_against = p[j] * w[0] + p[k] * w[1] <= force * speed + f64::MIN_POSITIVE;
                    if cone.slip.is_none() && speed > rate {
                        *grip = Grip::Slides([w[0] / speed, w[1] / speed]);
                    }
                    p[i] >= -force && (cone.slip.is_some() || is_against)
                }
            };
            if !fits {
                return None;
            }
        }
        Some(Forces { p, grips })
    }
}

impl Cone {
    /// The rows of its forces.
    fn rows(&self) -> impl Iterator<Item = usize> {
        [self.normal].into_iter().chain(self.along.into_iter().flatten())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of radius 1 with 2/5 m r²: A_tt = 7/2 of 1/m. It slides while |w| > 7/2 μ P, against w.
    #[test]
    fn a_ball_that_lands_grips_or_slips() {
        let a = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 3.5, 3.5]));
        let b = DVector::from_vec(vec![-2.0, 3.0, -4.0]);
        for (mu, slides) in [(0.5, true), (0.8, false)] {
            let cones = [Cone {
                normal: 0,
                along: Some([1, 2]),
                mu,
                holding: mu,
                slip: None,
                lets_go: false,
            }];
            let Forces { p, grips } =
                Cones { a: &a, b: &b, places: &cones }.solve().expect("forces");
            assert!((p[0] - 2.0).abs() < 1e-14, "{p}");
            let expected =
                if slides { [-0.6 * 2.0 * mu, 0.8 * 2.0 * mu] } else { [-3.0 / 3.5, 4.0 / 3.5] };
            assert!((p[1] - expected[0]).hypot(p[2] - expected[1]) < 1e-13, "{p} at μ = {mu}");
            assert_eq!(matches!(grips[0], Grip::Slides(_)), slides, "{grips:?}");
        }
    }

    /// Two contacts that feel each other: the conditions of both hold.
    #[test]
    fn forces_of_two_contacts_are_in_their_cones() {
        let root = DMatrix::from_fn(6, 6, |i, j| {
            let (i, j) = (i as f64, j as f64);
            if i == j { 2.0 } else { (1.3 * i + 2.1 * j).sin() * 0.6 }
        });
        let a = &root * root.transpose();
        let b = DVector::from_vec(vec![-3.0, 1.0, -2.0, -2.0, 0.5, 4.0]);
        let cones = [0, 3].map(|n| Cone {
            normal: n,
            along: Some([n + 1, n + 2]),
            mu: 0.3,
            holding: 0.3,
            slip: None,
            lets_go: false,
        });
        let Forces { p, .. } = Cones { a: &a, b: &b, places: &cones }.solve().expect("forces");
        let rates = &b + &a * &p;
        for n in [0, 3] {
            assert!(
                p[n] >= 0.0 && rates[n] > -1e-12 && (p[n] * rates[n]).abs() < 1e-11,
                "{p} {rates}"
            );
            let (l, w) = (p[n + 1].hypot(p[n + 2]), rates[n + 1].hypot(rates[n + 2]));
            assert!(l <= 0.3 * p[n] + 1e-12, "{p}");
            let work = p[n + 1] * rates[n + 1] + p[n + 2] * rates[n + 2];
            assert!((work + 0.3 * p[n] * w).abs() < 1e-11, "{p} {rates}");
        }
    }
}
