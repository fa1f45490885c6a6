//! [`Poses`]: where a mechanism is in balance, and where stops that are open at the start would bear it.

use bksim_mbs::coordinate::CoordinateKind;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

use crate::around::Around;
use crate::balance::Balance;
use crate::error::AnalysisError;
use crate::loaded::without_rates;

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
    /// False where none but the one to which the start leads was searched for.
    pub(crate) is_searched: bool,
}

/// Poses from which equilibria are searched.
const N_POSES: usize = 300;
/// Most unknowns with which that many are; of more there are fewer, as an iteration takes their third power.
const N_UNKNOWNS: usize = 60;
/// Fewest poses.
const FEWEST: usize = 8;
/// Unknowns above which a few poses say nothing of equilibria besides the one to which the start leads.
const N_LARGE: usize = 150;

impl Balance<'_> {
    /// Positions of all equilibria, and whether there are no others on the assembly of the start.
    ///
    /// # Errors
    /// [`AnalysisError::GoesNowhere`] for a start that yields, but goes nowhere.
    pub(crate) fn all(&mut self) -> Result<Poses, AnalysisError> {
        self.equilibria(false)
    }

    /// Positions of all equilibria ([`Balance::all`]); of a mechanism with many unknowns the one to which the start leads, if
    /// it leads to one.
    ///
    /// # Errors
    /// [`AnalysisError::GoesNowhere`] for a start that yields, but goes nowhere.
    pub(crate) fn around_one(&mut self) -> Result<Poses, AnalysisError> {
        self.equilibria(self.n_unknowns() > N_LARGE)
    }

    fn equilibria(&mut self, is_one_enough: bool) -> Result<Poses, AnalysisError> {
        without_rates(self.loaded.model())?;
        let q = self.start();
        let around = self.around_start()?;
        match around {
            Around::Regular(0) if self.states().is_empty() => {
                let nowhere = Some(Vec::new());
                Ok(self.sorted(vec![q], nowhere, true))
            }
            Around::Regular(1) if self.states().is_empty() => self.along_free_motion(&[q]),
            Around::Crossing(ways) if self.states().is_empty() => {
                let ahead: Vec<Vec<f64>> =
                    ways.iter().map(|way| self.position(&way.ahead)).collect();
                self.along_free_motion(&ahead)
            }
            _ => {
                let nearest = if is_one_enough { self.search_many_poses(1) } else { Vec::new() };
                let nearest = self.sorted(nearest, None, false);
                if !nearest.balanced.is_empty() {
                    return Ok(Poses { is_searched: false, ..nearest });
                }
                let found = self.search_many_poses(self.affordable(N_POSES));
                Ok(self.sorted(found, None, false))
            }
        }
    }

    /// Number of poses to search from: `n_poses`, or fewer for a mechanism with many unknowns.
    pub(crate) fn affordable(&self, n_poses: usize) -> usize {
        let n = self.n_unknowns();
        if n <= N_UNKNOWNS { n_poses } else { (n_poses * N_UNKNOWNS.pow(3) / n.pow(3)).max(FEWEST) }
    }

    fn n_unknowns(&self) -> usize {
        self.forces.n() + self.forces.nc()
    }

    /// True of two positions that are one, whole turns aside.
    fn is_same(&self, a: &[f64], b: &[f64]) -> bool {
        self.apart(a, b).iter().all(|off| off.abs() < 1e-6)
    }

    /// Positions in balance, sorted by the stops.
    pub(crate) fn sorted(
        &mut self,
        found: Vec<Vec<f64>>,
        on_stops: Option<Vec<(usize, Vec<f64>)>>,
        is_complete: bool,
    ) -> Poses {
        // Both quaternions of a rotation are one pose.
        let mut once: Vec<Vec<f64>> = Vec::new();
        for q in found {
            let is_same = |other: &Vec<f64>| self.is_same(&q, other);
            if self.counts_turns || !once.iter().any(is_same) {
                once.push(q);
            }
        }
        let (balanced, beyond) = once.into_iter().partition(|q| self.stops.allow(q));
        Poses { balanced, beyond, on_stops, is_complete, is_searched: true }
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
            let is_same = |other: &Vec<f64>| self.is_same(&q, other);
            if !found.iter().any(is_same) && self.forces_hold(&q) {
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
        let left_out = self.loaded.held_contacts().left_out;
        match (stops.is_empty(), left_out.is_empty()) {
            (false, _) => AnalysisError::StopsBefore { stops },
            (true, false) => AnalysisError::NoneWithoutFriction { left_out },
            (true, true) => AnalysisError::NoEquilibrium,
        }
    }
}
