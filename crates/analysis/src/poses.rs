//! [`Poses`]: where a mechanism is in balance, and where stops that are open at the start would bear it.

use bksim_mbs::coordinate::CoordinateKind;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

use crate::balance::Balance;
use crate::equilibrium::{Equilibrium, Stability};
use crate::error::AnalysisError;
use crate::reduced::Reduced;

/// Positions in balance, sorted by what stops that are open at the start allow.
#[derive(Clone, Debug, Default)]
pub(crate) struct Poses {
    /// Before all of these stops.
    pub(crate) balanced: Vec<Vec<f64>>,
    /// Beyond one of them.
    pub(crate) beyond: Vec<Vec<f64>>,
    /// Positions in which one of them closes and is pressed on, each with its number in [`crate::stops::Stops`]; `None` where
    /// they take a search.
    pub(crate) on_stops: Option<Vec<(usize, Vec<f64>)>>,
    /// True where there are no others on the assembly of the start.
    pub(crate) is_complete: bool,
}

/// Poses from which equilibria are searched.
pub(crate) const N_POSES: usize = 300;

impl Balance<'_> {
    /// Positions of all equilibria, and whether there are no others on the assembly of the start.
    pub(crate) fn all(&mut self) -> Result<Poses, AnalysisError> {
        let q = self.start();
        let n_free = self.n_free(&q).unwrap_or(2);
        match n_free {
            0 if self.states().is_empty() => {
                let nowhere = Some(Vec::new());
                Ok(self.sorted(vec![q], nowhere, true))
            }
            1 if self.states().is_empty() => self.along_free_motion(),
            _ => {
                let found = self.search_many_poses(N_POSES);
                Ok(self.sorted(found, None, false))
            }
        }
    }

    /// Number of free motions at a position.
    pub(crate) fn n_free(&mut self, q: &[f64]) -> Option<usize> {
        let lambda = vec![0.0; self.forces.nc()];
        let jacobian = self.at(q, &lambda).jacobian;
        Reduced::at(self.loaded, &jacobian, &[]).ok().map(|reduced| reduced.n())
    }

    /// Positions in balance, sorted by the stops.
    pub(crate) fn sorted(
        &mut self,
        found: Vec<Vec<f64>>,
        on_stops: Option<Vec<(usize, Vec<f64>)>>,
        is_complete: bool,
    ) -> Poses {
        let (balanced, beyond) = found.into_iter().partition(|q| self.stops.allow(q));
        Poses { balanced, beyond, on_stops, is_complete }
    }

    /// Newton's iteration on all equations from the start and many other poses.
    pub(crate) fn search_many_poses(&mut self, mut n_poses: usize) -> Vec<Vec<f64>> {
        /// Where they are not isolated.
        const N_POSES_OF_FAMILIES: usize = 60;
        let mut random = Pcg64::seed_from_u64(1);
        let start = self.start();
        let coordinates = self.loaded.system().coordinates();
        let kinds: Vec<CoordinateKind> = coordinates.iter().map(|c| c.kind).collect();
        let size = self.loaded.size;
        let mut found: Vec<Vec<f64>> = Vec::new();
        let mut k = 0;
        while k < n_poses {
            let mut aside = |i: usize| {
                let share: f64 = random.random_range(-1.0..1.0);
                share
                    * match kinds[i] {
                        CoordinateKind::Angle => std::f64::consts::PI,
                        CoordinateKind::Length => 2.0 * size,
                        CoordinateKind::Quaternion | CoordinateKind::Integral => 1.0,
                    }
            };
            let guess: Vec<f64> = match k {
                0 => start.clone(),
                _ => (0..start.len()).map(|i| start[i] + aside(i)).collect(),
            };
            k += 1;
            let Some(q) = self.newton(&guess) else { continue };
            let q = self.in_turn_of_start(q);
            let q = self.in_turn_before_stops(q);
            let is_same =
                |other: &Vec<f64>| self.apart(&q, other).iter().all(|off| off.abs() < 1e-6);
            if !found.iter().any(is_same) {
                if found.is_empty() && self.family(&q).is_some() {
                    n_poses = n_poses.min(N_POSES_OF_FAMILIES);
                }
                found.push(q);
            }
        }
        found
    }

    /// An equilibrium with those angles a turn on that bring it before more of the stops.
    fn in_turn_before_stops(&mut self, mut q: Vec<f64>) -> Vec<f64> {
        let mut passed = self.stops.numbers_before(&q);
        for k in passed.clone() {
            let gradient = self.stops.gradients(&q).swap_remove(k);
            let coordinates = self.loaded.system().coordinates();
            let is_angle = |i: &usize| coordinates[*i].kind == CoordinateKind::Angle;
            let turning: Vec<usize> =
                (0..q.len()).filter(|&i| gradient[i] != 0.0).filter(is_angle).collect();
            for (i, turn) in turning.into_iter().flat_map(|i| [(i, TAU), (i, -TAU)]) {
                let mut turned = q.clone();
                turned[i] += turn;
                let left = self.stops.numbers_before(&turned);
                if left.len() < passed.len() && self.is_equilibrium(&turned) {
                    (q, passed) = (turned, left);
                    break;
                }
            }
        }
        q
    }

    /// The equilibrium nearest to the start, before all stops: a stable one, if there is any.
    pub(crate) fn nearest(&mut self) -> Result<Equilibrium, AnalysisError> {
        let Poses { balanced, beyond, on_stops, .. } = self.all()?;
        let start = self.start();
        let coordinates = self.loaded.system().coordinates();
        // Whole turns count where forces differ by them.
        let is_turn = |i: usize| self.counts_turns && coordinates[i].kind == CoordinateKind::Angle;
        let distance = |q: &[f64]| -> f64 {
            let off = self.apart(q, &start).into_iter().enumerate();
            let off = off.map(|(i, off)| if is_turn(i) { q[i] - start[i] } else { off });
            off.map(|off| off.powi(2)).sum()
        };
        let mut order: Vec<Vec<f64>> = balanced;
        order.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let mut first = None;
        for q in order {
            let found = self.equilibrium(&q)?;
            if found.stability != Stability::Unstable {
                return Ok(found);
            }
            first = first.or(Some(found));
        }
        match first {
            Some(found) => Ok(found),
            None => Err(self.without_equilibrium(&beyond, &on_stops.unwrap_or_default())),
        }
    }

    /// The fault that no equilibrium lies before the stops.
    pub(crate) fn without_equilibrium(
        &mut self,
        beyond: &[Vec<f64>],
        on_stops: &[(usize, Vec<f64>)],
    ) -> AnalysisError {
        let numbers = beyond.iter().flat_map(|q| self.stops.numbers_before(q));
        let numbers = numbers.chain(on_stops.iter().map(|(k, _)| *k));
        let mut stops: Vec<String> = Vec::new();
        for k in numbers.collect::<Vec<_>>() {
            let name = self.stops.name(k).to_owned();
            if !stops.contains(&name) {
                stops.push(name);
            }
        }
        if stops.is_empty() {
            AnalysisError::NoEquilibrium
        } else {
            AnalysisError::StopsBefore { stops }
        }
    }
}
