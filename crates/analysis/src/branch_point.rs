//! Balance where branches of poses cross: the free motions there are curves, not a plane.
//!
//! ```text
//! F · τ_b = 0        along every branch b
//! κ_b = d²V/dσ²      along the branch, by central differences of the work at poses of it
//! ```
//!
//! The slopes of the constraints leave more directions free than there are motions, and along these neither V nor its
//! second derivatives mean anything.

use nalgebra::{DMatrix, DVector};

use crate::around::{Around, Way, around, neighbour, yielding, yielding_below};
use crate::balance::Balance;
use crate::curve::Equations;
use crate::equilibrium::{CrossingBranch, Equilibrium, Stability};
use crate::error::AnalysisError;
use crate::open_reactions::{least, open_reactions};
use crate::stops::bearing;
use crate::way_rates::{ASIDE, WayRates};

/// The closure of a mechanism in units of the mechanism: radians and longest links.
struct Closure<'b, 'l> {
    balance: &'b mut Balance<'l>,
}

impl Equations for Closure<'_, '_> {
    fn at(&mut self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let q = z.component_mul(&self.balance.units());
        self.balance.closure(q.as_slice())
    }
}

/// Step to either side by which the stiffness along a branch is found; twice that besides.
const STEP: f64 = 1e-2;
/// Part of the sum of its terms below which a stiffness or the work along a branch counts as none.
const NOTHING: f64 = 1e-6;

impl Equilibrium {
    /// The equilibrium, where one branch of poses alone goes through it.
    ///
    /// # Errors
    /// [`AnalysisError::BranchPoint`] where several do.
    pub(crate) fn on_one_branch(self) -> Result<Self, AnalysisError> {
        if self.branches.is_empty() {
            return Ok(self);
        }
        let ways = self.branches.into_iter().map(|branch| branch.rates).collect();
        let cure = "write `--at start`, or the number of another equilibrium: `bksim modes` has the motions along each branch";
        Err(AnalysisError::BranchPoint { ways, cure })
    }
}

impl Balance<'_> {
    /// Refuses a start in which branches cross.
    ///
    /// # Errors
    /// [`AnalysisError::BranchPoint`], or [`AnalysisError::GoesNowhere`] of a start that leads on nowhere.
    pub(crate) fn on_one_branch(&mut self) -> Result<(), AnalysisError> {
        let Around::Crossing(ways) = self.around_start()? else { return Ok(()) };
        let q = self.start();
        let ways = self.loaded.named()?.of_ways(&q, &ways);
        Err(AnalysisError::BranchPoint { ways, cure: ASIDE })
    }

    /// Closed loops with their slopes, in units of the mechanism, whole turns aside.
    fn closure(&mut self, q: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let units = self.units();
        let nothing = vec![0.0; self.forces.nc()];
        let at = self.at(q, &nothing);
        let unit_of: Vec<f64> =
            (0..nothing.len()).map(|k| self.unit_of_row(self.loaded.kept[k])).collect();
        let value = DVector::from_fn(unit_of.len(), |k, _| {
            let is_turn =
                self.loaded.system().constraints[self.loaded.kept[k]].direction == "angle";
            let own = at.closure[k];
            if is_turn { crate::rows::wrapped(own) } else { own / unit_of[k] }
        });
        let slopes = DMatrix::from_fn(unit_of.len(), units.len(), |k, i| {
            at.jacobian[(k, i)] * units[i] / unit_of[k]
        });
        (value, slopes)
    }

    /// A position in units of the mechanism.
    fn scaled(&self, q: &[f64]) -> DVector<f64> {
        DVector::from_column_slice(q).component_div(&self.units())
    }

    /// The poses around the start.
    ///
    /// # Errors
    /// [`AnalysisError::GoesNowhere`] where it yields, but goes nowhere.
    pub(crate) fn around_start(&mut self) -> Result<Around, AnalysisError> {
        let q = self.start();
        let z = self.scaled(&q);
        let found = around(&mut Closure { balance: self }, &z);
        self.n_motions = match &found {
            Around::Nowhere(directions) => {
                return Err(self.loaded.named()?.nowhere(&q, directions));
            }
            Around::Regular(n) => Some(*n),
            Around::Crossing(_) => Some(1),
        };
        self.regular = match &found {
            Around::Crossing(ways) => ways.first().map(|way| self.position(&way.ahead)),
            _ => None,
        };
        self.ways = match &found {
            Around::Crossing(ways) if ways.len() > 1 => ways.clone(),
            _ => Vec::new(),
        };
        Ok(found)
    }

    /// The start, or where branches cross in it a pose next to it.
    pub(crate) fn regular_pose(&self) -> Vec<f64> {
        self.regular.clone().unwrap_or_else(|| self.start())
    }

    /// The branches that cross in the start, by rates of joints.
    pub(crate) fn ways_of_start(&self) -> Result<Vec<WayRates>, AnalysisError> {
        if self.ways.is_empty() {
            return Ok(Vec::new());
        }
        Ok(self.loaded.named()?.of_ways(&self.start(), &self.ways))
    }

    /// The position of coordinates in units of the mechanism.
    pub(crate) fn position(&self, z: &DVector<f64>) -> Vec<f64> {
        z.component_mul(&self.units()).as_slice().to_vec()
    }

    /// The branches that cross in a pose, where more than the motions of the mechanism are free by the slopes alone.
    pub(crate) fn ways_at(&mut self, q: &[f64]) -> Option<Vec<Way>> {
        let n_motions = self.n_motions.filter(|_| self.states().is_empty())?;
        let (_, slopes) = self.closure(q);
        if yielding(&slopes).len() <= n_motions {
            return None;
        }
        let z = self.scaled(q);
        match around(&mut Closure { balance: self }, &z) {
            Around::Crossing(ways) => Some(ways),
            _ => None,
        }
    }

    /// True where no branch through a pose has work along it.
    pub(crate) fn rests_on_all(&mut self, q: &[f64], ways: &[Way]) -> bool {
        let (forces, size) = self.forces_of(q);
        ways.iter().all(|way| forces.dot(&way.tangent).abs() <= NOTHING * size)
    }

    /// False where slopes lose rank in a pose and forces work along what yields there: only forces without bound would hold it.
    pub(crate) fn forces_hold(&mut self, q: &[f64]) -> bool {
        /// Part of the largest slope that is left near to such a pose.
        const NEAR: f64 = 1e-5;
        let Some(n_motions) = self.n_motions.filter(|_| self.states().is_empty()) else {
            return true;
        };
        let (_, slopes) = self.closure(q);
        let free = yielding_below(&slopes, NEAR);
        if free.len() <= n_motions {
            return true;
        }
        let (forces, size) = self.forces_of(q);
        free.iter().all(|d| forces.dot(d).abs() <= NOTHING * size)
    }

    /// −∂V/∂q + Q in units of work, J per radian or longest link, and the size of what they are made of and change by.
    fn forces_of(&mut self, q: &[f64]) -> (DVector<f64>, f64) {
        let nothing = vec![0.0; self.forces.nc()];
        let units = self.units();
        let at = self.at(q, &nothing);
        let forces = -at.residual.component_mul(&units);
        // Where a mechanism hangs no force may be left but by its changes.
        let n = units.len();
        let entries = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let changes = entries.map(|(i, j)| (at.stiffness[(i, j)] * units[i] * units[j]).abs());
        let size = changes.fold(forces.norm(), f64::max);
        (forces, size)
    }

    /// An equilibrium in which branches cross: stability is by each of them.
    pub(crate) fn at_crossing(
        &mut self,
        q: &[f64],
        ways: &[Way],
    ) -> Result<Equilibrium, AnalysisError> {
        let undetermined = || AnalysisError::Undetermined { what: "the constraints".into(), n: 1 };
        let lambda = self.smallest_balancing(q).ok_or_else(undetermined)?;
        let rates = self.loaded.named()?.of_ways(q, ways);
        let mut branches = Vec::new();
        for (way, rates) in ways.iter().zip(rates) {
            branches.extend(self.branch(q, way, rates));
        }
        let worst = branches.iter().map(|b| b.stability).max_by_key(|stability| stability.rank());
        let loaded = self.loaded;
        let mut lambda = self.forces.all_multipliers(loaded.system().constraints.len(), &lambda);
        let v = self.velocities(q);
        let rest = vec![0.0; q.len()];
        let parameters = self.parameters().to_vec();
        let mut reactions = loaded.reactions(loaded.t, &parameters, [q, &v, &rest], &mut lambda);
        least(loaded, &parameters, (loaded.t, q), (&mut reactions, &mut lambda));
        let numbers = (parameters.as_slice(), self.bounds.as_slice());
        let open = open_reactions(loaded, numbers, (loaded.t, q), (&reactions, &lambda));
        Ok(Equilibrium {
            q: q.to_vec(),
            open,
            bearing: bearing((loaded.model(), loaded.system()), &loaded.kept, &lambda),
            beyond: self.stops.passed(q),
            lambda,
            stability: worst.unwrap_or(Stability::Neutral),
            stiffness: Vec::new(),
            branches,
            family: None,
            pose: self.pose_at(q),
            reactions,
        })
    }

    /// Stability along a branch; `None` where its poses are not found.
    fn branch(&mut self, q: &[f64], way: &Way, rates: WayRates) -> Option<CrossingBranch> {
        let z = self.scaled(q);
        let mut work = |step: f64| -> Option<f64> {
            let there = neighbour(&mut Closure { balance: self }, &z, &way.tangent, step)?;
            let q = self.position(&there);
            let (_, slopes) = self.closure(&q);
            let free = yielding(&slopes);
            let along = free.first().filter(|_| free.len() == 1)?;
            let along = along / way.tangent.dot(along);
            Some(self.forces_of(&q).0.dot(&along))
        };
        let near = (work(-STEP)? - work(STEP)?) / (2.0 * STEP);
        let far = (work(-2.0 * STEP)? - work(2.0 * STEP)?) / (4.0 * STEP);
        let stiffness = (4.0 * near - far) / 3.0;
        let (_, size) = self.forces_of(q);
        let stability = match stiffness {
            k if k > NOTHING * size => Stability::Stable,
            k if k < -NOTHING * size => Stability::Unstable,
            _ => Stability::Neutral,
        };
        // By the first of its rates.
        let along = way.tangent.component_mul(&self.units());
        let first = rates.first().and_then(|(name, ..)| {
            let k = self.loaded.quantities.iter().position(|known| known.names[0] == *name)?;
            let slopes = self.pose_gradients(q).swap_remove(k);
            Some(slopes.iter().zip(&along).map(|(slope, d)| slope * d).sum::<f64>())
        });
        let first = first.filter(|rate: &f64| rate.abs() > 0.0 && rate.is_finite()).unwrap_or(1.0);
        Some(CrossingBranch {
            rates,
            stability,
            stiffness: stiffness / (first * first),
            direction: along.iter().map(|d| d / first).collect(),
        })
    }
}
