//! Velocities after an impact of bodies that rub: Newton's law of restitution with Coulomb's friction.
//!
//! ```text
//! u⁺ = u⁻ − W_nn P + W_nt L,     w⁺ = w⁻ − W_tn P + W_tt L
//! u⁺ + ε u⁻ ≤ 0,  P ≥ 0,  one of them 0
//! w⁺ = 0 and |L| ≤ μ Σ P,   or   L = −μ Σ P sign w⁺
//! ```
//!
//! u is the rate of penetration, w the speed of slip, P and L are the impulses along them, and W the response of the
//! mechanism with its constraints. Σ P is over the places that rub along one line. So friction ends the slip if it can, and
//! is μ times the pressing impulse where it cannot.
//!
//! With friction, Newton's restitution may give back more energy than there was. Then ε is made smaller, of all stops in
//! one proportion, until it does not: with ε = 0 the impulses never do positive work.
//!
//! Source: C. Glocker and F. Pfeiffer (1996), §8.2; J. J. Moreau (1988) for the law in velocities; T. R. Kane and
//! D. A. Levinson (1985) for the energy that Newton's restitution may gain.

use nalgebra::{DMatrix, DVector};

use super::complementarity::{holds, pushes, slips_against_friction, stays_apart};
use super::impact::{Impact, ImpactEquations, Rubbing};
use super::lemke::{Complementary, lemke};
use super::mode_sets::ModeSets;
use crate::linear::matrix::Matrix;
use crate::linear::rows::SparseRows;

/// Relative size of rounding in a sign.
const ROUNDING: f64 = 1e-9;
/// Singular values below this part of the largest are none.
const SMALLEST: f64 = 1e-11;
/// Part of the energy of an impact that is rounding.
const GAIN: f64 = 1e-12;
/// Parts of the largest force and acceleration that are none.
const APART: f64 = 1e-8;
/// Stops and tracks that feel each other, up to which choices are tried one after the other; and tries of more.
const FEW: usize = 14;
const MOST_SETS: usize = 2000;
/// Halvings of the range in which the restitution is made smaller.
const HALVINGS: usize = 60;

/// The mechanism as contacts feel it.
pub(crate) struct Response {
    n_stops: usize,
    /// Velocities without impulses of contacts, and their change by unit impulses of each.
    free: DVector<f64>,
    columns: Vec<DVector<f64>>,
    /// u and w without impulses.
    pub(super) rates: DVector<f64>,
    /// The change of u and w by impulses P and L, with their signs.
    pub(super) w: DMatrix<f64>,
}

/// Stops and tracks in a solution of a complementarity problem.
pub(super) struct Choices {
    /// Stops with a force.
    pub(super) pushes: Vec<bool>,
    /// Stops that stay in touch.
    pub(super) stays: Vec<bool>,
    /// Tracks whose friction is at its limit: the sense of the slip, and whether there is one.
    pub(super) slips: Vec<Option<(f64, bool)>>,
    /// Tracks whose friction is needed to hold bodies that others do not hold.
    pub(super) rubs: Vec<bool>,
}

/// Impulses P and L in one set of choices.
pub(super) struct Outcome {
    pub(super) impulses: DVector<f64>,
    pub(super) rates: DVector<f64>,
}

impl ImpactEquations<'_> {
    /// The response of the mechanism at the velocities `v`; `None` where it has none.
    pub(super) fn response(&self, v: &DVector<f64>, rubbing: &SparseRows) -> Option<Response> {
        let mut factored = self.factored(&self.stops.select(&[]))?;
        let momentum = self.mass.times(v);
        let nothing = DVector::zeros(0);
        let (free, _) = factored.solve(self.g_rate, &nothing, &momentum)?;
        let zeros = vec![0.0; self.g_rate.len()];

        let rows = self.stops.dense();
        let rubbing = rubbing.dense();
        let (n, m) = (rows.nrows(), rubbing.nrows());
        // Impulses push against penetration, and along slip, which the rows have with the opposite sign.
        let direction = |k: usize| -> DVector<f64> {
            let row = if k < n { rows.row(k) } else { rubbing.row(k - n) };
            -row.transpose()
        };
        let columns: Option<Vec<DVector<f64>>> =
            (0..n + m).map(|k| Some(factored.solve(&zeros, &nothing, &direction(k))?.0)).collect();
        let columns = columns?;
        let mut felt = DMatrix::zeros(n + m, v.len());
        for k in 0..n {
            felt.row_mut(k).copy_from(&rows.row(k));
        }
        for k in 0..m {
            felt.row_mut(n + k).copy_from(&(-rubbing.row(k)));
        }
        let rates = &felt * &free;
        let w = DMatrix::from_columns(&columns.iter().map(|c| &felt * c).collect::<Vec<_>>());
        let w = if columns.is_empty() { DMatrix::zeros(0, 0) } else { w };
        Some(Response { n_stops: n, free, columns, rates, w })
    }

    /// The velocities after an impact with friction at the velocities `v`; `None` when no set of choices is consistent.
    pub(crate) fn solve_rubbing(&self, v: &DVector<f64>, rubbing: &Rubbing<'_>) -> Option<Impact> {
        let response = self.response(v, rubbing.rows)?;
        let n = response.n_stops;
        let approach = Matrix::of(self.stops.clone()).times(v);
        let at = |part: f64| {
            let parting = (0..n).map(|k| -part * self.restitution[k] * approach[k]);
            response.outcome(&DVector::from_iterator(n, parting), rubbing)
        };
        let mut found = at(1.0)?;
        if response.gains(&found) {
            let (mut good, mut bad) = (0.0, 1.0);
            found = at(good)?;
            for _ in 0..HALVINGS {
                let part = 0.5 * (good + bad);
                match at(part).filter(|outcome| !response.gains(outcome)) {
                    Some(outcome) => (good, found) = (part, outcome),
                    None => bad = part,
                }
            }
        }
        let mut after = response.free.clone();
        for (column, impulse) in response.columns.iter().zip(found.impulses.iter()) {
            after += column * *impulse;
        }
        let impulses = found.impulses.rows(0, n).map(|p| p.max(0.0));
        after.iter().all(|value| value.is_finite()).then_some(Impact { v: after, impulses })
    }
}

impl Response {
    /// The part of φ″ of a stop that its own unit force takes away while it slides in the direction `slip` with the
    /// friction `mu` of the first track. Where it is not positive, its force does not part the bodies.
    pub(super) fn own(&self, stop: usize, track: usize, slip: f64, mu: f64) -> f64 {
        -self.w[(stop, stop)] + slip * mu * self.w[(stop, self.n_stops + track)]
    }

    /// True where the impulses do positive work.
    fn gains(&self, outcome: &Outcome) -> bool {
        let both = &self.rates + &outcome.rates;
        let n = self.n_stops;
        let sign = |k: usize| if k < n { -0.5 } else { 0.5 };
        let terms = (0..both.len()).map(|k| sign(k) * outcome.impulses[k] * both[k]);
        let (mut work, mut size) = (0.0, 0.0);
        for term in terms {
            work += term;
            size += f64::abs(term);
        }
        work > GAIN * size
    }

    /// The impulses for which stops part at these speeds, u⁺ = `parting` where they push: those of each group that
    /// others leave alone by itself, none where nothing meets.
    fn outcome(&self, parting: &DVector<f64>, rubbing: &Rubbing<'_>) -> Option<Outcome> {
        if rubbing.is_spatial {
            return self.outcome_in_cones(parting, rubbing);
        }
        let n = self.n_stops;
        let mut impulses = DVector::zeros(self.rates.len());
        for group in self.groups(rubbing) {
            if group.iter().all(|&k| self.rates[k].abs() <= SMALLEST * self.rates.amax()) {
                continue;
            }
            let (stops, tracks): (Vec<usize>, Vec<usize>) = group.iter().partition(|&&k| k < n);
            let place = |stop: &usize| stops.iter().position(|own| own == stop);
            let mu: Vec<f64> = tracks.iter().map(|&k| rubbing.mu[k - n]).collect();
            let pressed_by: Vec<Vec<usize>> = (tracks.iter())
                .map(|&k| rubbing.pressed_by[k - n].iter().filter_map(place).collect())
                .collect();
            let own = [stops.clone(), tracks].concat();
            let part = Self {
                n_stops: stops.len(),
                free: DVector::zeros(0),
                columns: Vec::new(),
                rates: self.rates.select_rows(&own),
                w: self.w.select_rows(&own).select_columns(&own),
            };
            let rubbing = Rubbing { mu: &mu, pressed_by: &pressed_by, ..*rubbing };
            let found = part.outcome_of_group(&parting.select_rows(&stops), &rubbing)?;
            own.iter().zip(found.impulses.iter()).for_each(|(&k, p)| impulses[k] = *p);
        }
        let rates = &self.rates + &self.w * &impulses;
        Some(Outcome { impulses, rates })
    }

    /// Stops and tracks in groups that do not feel each other's impulses.
    fn groups(&self, rubbing: &Rubbing<'_>) -> Vec<Vec<usize>> {
        let size = self.rates.len();
        let least = SMALLEST * self.w.amax();
        let is_linked = |i: usize, j: usize| {
            let presses = |stop: usize, track: usize| {
                let track = track.checked_sub(self.n_stops);
                track.is_some_and(|track| rubbing.pressed_by[track].contains(&stop))
            };
            self.w[(i, j)].abs() > least || presses(i, j) || presses(j, i)
        };
        let mut group_of: Vec<Option<usize>> = vec![None; size];
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for first in 0..size {
            if group_of[first].is_some() {
                continue;
            }
            let mut members = vec![first];
            group_of[first] = Some(groups.len());
            let mut at = 0;
            while let Some(&k) = members.get(at) {
                for other in 0..size {
                    if group_of[other].is_none() && is_linked(k, other) {
                        group_of[other] = Some(groups.len());
                        members.push(other);
                    }
                }
                at += 1;
            }
            members.sort_unstable();
            groups.push(members);
        }
        groups
    }

    /// Impulses of one group.
    fn outcome_of_group(&self, parting: &DVector<f64>, rubbing: &Rubbing<'_>) -> Option<Outcome> {
        let (n, m) = (self.n_stops, rubbing.mu.len());
        // All stops push, all tracks stick: then whatever does not fit is changed, one thing at a time.
        let mut set = vec![0; n + m];
        let mut seen = Vec::new();
        while n + m <= FEW && !seen.contains(&set) && seen.len() <= 8 * (n + m) {
            seen.push(set.clone());
            let Some(outcome) = self.in_set(&set, parting, rubbing) else { break };
            match self.worst(&set, &outcome, parting, rubbing) {
                None => return Some(outcome),
                Some((k, choice)) => set[k] = choice,
            }
        }
        if let Some(Complementary { z, .. }) = self.complementary(parting, rubbing) {
            let along = (n..n + m).map(|k| z[k] - z[k + m]);
            let impulses = z.iter().take(n).copied().chain(along);
            let impulses = DVector::from_iterator(n + m, impulses);
            let rates = &self.rates + &self.w * &impulses;
            return Some(Outcome { impulses, rates });
        }
        let choices = (0..n + m).map(|k| if k < n { 2 } else { 3 }).collect();
        let mut sets = ModeSets::new(choices).take(MOST_SETS);
        sets.find_map(|set| {
            let outcome = self.in_set(&set, parting, rubbing)?;
            self.worst(&set, &outcome, parting, rubbing).is_none().then_some(outcome)
        })
    }

    /// The solution of a linear complementarity problem: with L = β₁ − β₂, both not negative,
    ///
    /// ```text
    /// u* − u ≥ 0 ⊥ P,   σ + w ≥ 0 ⊥ β₁,   σ − w ≥ 0 ⊥ β₂,   μ Σ P − β₁ − β₂ ≥ 0 ⊥ σ
    /// ```
    fn complementary(
        &self,
        parting: &DVector<f64>,
        rubbing: &Rubbing<'_>,
    ) -> Option<Complementary> {
        let (n, m) = (self.n_stops, rubbing.mu.len());
        let size = n + 3 * m;
        let mut matrix = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        for i in 0..n + m {
            // Rows of u and of w; that of −w again.
            let sense = if i < n { -1.0 } else { 1.0 };
            for j in 0..n + m {
                matrix[(i, j)] = sense * self.w[(i, j)];
                if j >= n {
                    matrix[(i, j + m)] = -sense * self.w[(i, j)];
                }
            }
            right[i] = sense * self.rates[i] + if i < n { parting[i] } else { 0.0 };
        }
        for k in n..n + m {
            for j in 0..n + 2 * m {
                matrix[(k + m, j)] = -matrix[(k, j)];
            }
            right[k + m] = -right[k];
            let bound = k + 2 * m;
            matrix[(k, bound)] = 1.0;
            matrix[(k + m, bound)] = 1.0;
            matrix[(bound, k)] = -1.0;
            matrix[(bound, k + m)] = -1.0;
            for &stop in &rubbing.pressed_by[k - n] {
                matrix[(bound, stop)] += rubbing.mu[k - n];
            }
        }
        // Rows and columns of unit size.
        let scale = DVector::from_fn(size, |i, _| {
            let own = matrix[(i, i)].abs();
            if own > 0.0 { 1.0 / own.sqrt() } else { 1.0 }
        });
        let scaled = DMatrix::from_fn(size, size, |i, j| scale[i] * matrix[(i, j)] * scale[j]);
        let found = lemke(&scaled, &right.component_mul(&scale))?;
        Some(Complementary { z: found.z.component_mul(&scale), ..found })
    }

    /// The choices that the complementarity problem of steady forces makes.
    pub(super) fn choices(&self, rubbing: &Rubbing<'_>) -> Option<Choices> {
        let (n, m) = (self.n_stops, rubbing.mu.len());
        let Complementary { z, is_basic } = self.complementary(&DVector::zeros(n), rubbing)?;
        let forces = DVector::from_fn(n + m, |k, _| if k < n { z[k] } else { z[k] - z[k + m] });
        let size = self.rates.amax().max(f64::MIN_POSITIVE);
        let rates = &self.rates + &self.w * &forces;
        let largest = forces.amax();
        let along = |k: usize| if z[k] > z[k + m] { -1.0 } else { 1.0 };
        Some(Choices {
            pushes: (0..n).map(|k| z[k] > APART * largest).collect(),
            stays: rates.rows(0, n).iter().map(|rate| rate.abs() <= APART * size).collect(),
            slips: (n..n + m)
                .map(|k| is_basic[k + 2 * m].then_some((along(k), z[k + 2 * m] > APART * size)))
                .collect(),
            rubs: (n..n + m).map(|k| is_basic[k] || is_basic[k + m]).collect(),
        })
    }

    /// Response to steady forces, with accelerations for rates. Tracks that slide are part of the forces that
    /// press them, −ς μ of each.
    pub(super) fn of_forces(
        mut self,
        rates: &DVector<f64>,
        slips: &[f64],
        rubbing: &Rubbing<'_>,
    ) -> (Self, Vec<usize>) {
        let n = self.n_stops;
        for (track, slip) in slips.iter().enumerate().filter(|(_, slip)| **slip != 0.0) {
            let column = self.w.column(n + track) * (-slip * rubbing.mu[track]);
            for &stop in &rubbing.pressed_by[track] {
                let changed = self.w.column(stop) + &column;
                self.w.column_mut(stop).copy_from(&changed);
            }
        }
        let resting: Vec<usize> = (0..slips.len()).filter(|&track| slips[track] == 0.0).collect();
        let own: Vec<usize> = (0..n).chain(resting.iter().map(|track| n + track)).collect();
        self.w = self.w.select_rows(&own).select_columns(&own);
        self.rates = rates.select_rows(&own);
        (self, resting)
    }

    /// The impulses with these choices: of a stop 0 where it pushes, of a track 0 where it sticks and 1 or 2 where it
    /// slips along or against its direction. `None` where they are not those of any.
    fn in_set(
        &self,
        set: &[usize],
        parting: &DVector<f64>,
        rubbing: &Rubbing<'_>,
    ) -> Option<Outcome> {
        let n = self.n_stops;
        let size = set.len();
        let mut matrix = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        for k in 0..size {
            let is_pressed = |track: usize| rubbing.pressed_by[track].iter().any(|&s| set[s] == 0);
            let holds = set[k] == 0 && (k < n || is_pressed(k - n));
            if holds {
                matrix.row_mut(k).copy_from(&self.w.row(k));
                right[k] = if k < n { parting[k] } else { 0.0 } - self.rates[k];
            } else {
                matrix[(k, k)] = 1.0;
                if k >= n && set[k] != 0 {
                    let sense = if set[k] == 1 { 1.0 } else { -1.0 };
                    for &stop in &rubbing.pressed_by[k - n] {
                        matrix[(k, stop)] += sense * rubbing.mu[k - n];
                    }
                }
            }
        }
        // Stops that repeat others share their impulses.
        let decomposed = matrix.clone().svd(true, true);
        let smallest = SMALLEST * decomposed.singular_values.max();
        let impulses = decomposed.solve(&right, smallest).ok()?;
        let left = (&matrix * &impulses - &right).amax();
        let fits = left <= ROUNDING * right.amax().max(f64::MIN_POSITIVE);
        let rates = &self.rates + &self.w * &impulses;
        fits.then_some(Outcome { impulses, rates })
    }

    /// First thing that does not fit, with the choice that it should have; `None` where all does.
    fn worst(
        &self,
        set: &[usize],
        outcome: &Outcome,
        parting: &DVector<f64>,
        rubbing: &Rubbing<'_>,
    ) -> Option<(usize, usize)> {
        let n = self.n_stops;
        let Outcome { impulses, rates } = outcome;
        let speed = ROUNDING * self.rates.amax().max(rates.amax());
        let impulse = ROUNDING * impulses.amax();
        // Stops first: friction follows them.
        for k in 0..n {
            if set[k] == 0 && !pushes(impulses[k], impulse) {
                return Some((k, 1));
            }
            if set[k] == 1 && !stays_apart(rates[k] - parting[k], speed) {
                return Some((k, 0));
            }
        }
        for (track, mu) in rubbing.mu.iter().enumerate() {
            let (k, stops) = (n + track, &rubbing.pressed_by[track]);
            if stops.iter().all(|&stop| set[stop] != 0) {
                continue;
            }
            let limit = mu * stops.iter().map(|&stop| impulses[stop]).sum::<f64>();
            let fits = match set[k] {
                0 => holds(impulses[k], limit, impulse),
                1 => slips_against_friction(1.0, rates[k], speed),
                _ => slips_against_friction(-1.0, rates[k], speed),
            };
            if !fits {
                let along = if impulses[k] < 0.0 { 1 } else { 2 };
                return Some((k, if set[k] == 0 { along } else { 0 }));
            }
        }
        None
    }
}
