//! [`State`]: the state that an answer is about, how it was chosen, and the other equilibria that could have been.
//!
//! Equilibria are numbered from the nearest to the start on, whatever their stability; of those that are as near, stable ones
//! come first. [`statics`](crate::statics()) lists them in the same order.

use bksim_mbs::quantity::rate_unit;

use crate::about::About;
use crate::balance::{Balance, pose_of};
use crate::equilibrium::{Equilibrium, Stability};
use crate::error::AnalysisError;
use crate::kinks::Kink;
use crate::loaded::Loaded;
use crate::poses::Poses;

/// Names, values and units of the quantities that say where a mechanism is, SI.
pub type Place = Vec<(String, f64, &'static str)>;

/// The state that an answer is about.
#[derive(Clone, PartialEq, Debug)]
pub struct State {
    /// How it was chosen.
    pub about: About,
    /// Time, s.
    pub t: f64,
    /// Where the mechanism is, by independent quantities.
    pub place: Place,
    /// Stability of an equilibrium; `None` of a state of the motion.
    pub stability: Option<Stability>,
    /// Number of an equilibrium, from one; `None` of a state of the motion.
    pub number: Option<usize>,
    /// The other equilibria.
    pub others: Vec<OtherState>,
    /// The search for them, on the assembly of the start.
    pub search: Search,
    /// Rates of the start that the answer leaves out: it is as if at rest.
    pub left_out: Vec<(String, f64, String)>,
    /// True if the motion goes on to other linear equations: these are of this instant alone.
    pub is_passing: bool,
    /// True if deviations are of the components of a quaternion that turns: its poles are not those of the angles.
    pub by_quaternions: bool,
    /// Kinks of the forces in the state: linear equations are those of one side.
    pub kinks: Vec<Kink>,
}

/// Extent of a search for other equilibria.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Search {
    /// There are no more than were found.
    Complete,
    /// There may be more than were found.
    Partial,
    /// Nothing was searched for, as of mechanisms with many unknowns.
    None,
}

/// Another equilibrium that an answer could be about.
#[derive(Clone, PartialEq, Debug)]
pub struct OtherState {
    /// Number of the state, from one.
    pub number: usize,
    /// Where the mechanism is there.
    pub place: Place,
    /// Stability of the state.
    pub stability: Stability,
}

/// Part of the largest rate below which one counts as none.
const NO_RATE: f64 = 1e-12;

impl State {
    /// A state of the motion at coordinates, without a name among equilibria.
    pub(crate) fn of_motion(loaded: &Loaded, about: About, place: Place) -> Self {
        Self {
            about,
            t: loaded.t,
            place,
            stability: None,
            number: None,
            others: Vec::new(),
            search: Search::Complete,
            left_out: Vec::new(),
            is_passing: false,
            by_quaternions: false,
            kinks: Vec::new(),
        }
    }
}

impl Balance<'_> {
    /// Equilibria before all stops, then poses in balance beyond one, each with the nearest to the start first.
    pub(crate) fn listed(&mut self, poses: &Poses) -> Result<[Vec<Equilibrium>; 2], AnalysisError> {
        let all: Vec<&Vec<f64>> = poses.balanced.iter().chain(&poses.beyond).collect();
        self.tell_apart(&all)?;
        let found = self.distinct(all.into_iter())?;
        let (before, beyond) =
            self.nearest_first(found).into_iter().partition(|e| e.beyond.is_empty());
        Ok([before, beyond])
    }

    /// Equilibria in the order of their distance from the start; of those that are as near, stable ones come first.
    pub(crate) fn nearest_first(&self, mut all: Vec<Equilibrium>) -> Vec<Equilibrium> {
        /// Distances that differ by less are equal, rad or parts of the longest link.
        const AS_NEAR: f64 = 1e-7;
        let start = self.start();
        let key = |e: &Equilibrium| (self.distance(&e.q, &start) / AS_NEAR).round();
        let rank = |e: &Equilibrium| e.stability.rank();
        all.sort_by(|a, b| key(a).total_cmp(&key(b)).then(rank(a).cmp(&rank(b))));
        all
    }

    /// The equilibrium that is meant, and the state that it is.
    ///
    /// # Errors
    /// [`AnalysisError`] where there is none before the stops, or none of this number.
    pub(crate) fn chosen(&mut self, about: About) -> Result<(Equilibrium, State), AnalysisError> {
        let poses = if about == About::Static { self.around_one()? } else { self.all()? };
        let [mut found, _] = self.listed(&poses)?;
        if found.is_empty() {
            let on_stops = poses.on_stops.unwrap_or_default();
            return Err(self.without_equilibrium(&poses.beyond, &on_stops));
        }
        let n = found.len();
        let place = match about {
            About::Number(number) => number.checked_sub(1).filter(|k| *k < n),
            About::Stable => found.iter().position(|e| e.stability == Stability::Stable),
            _ => Some(0),
        };
        let place = place.ok_or(match about {
            About::Number(number) => AnalysisError::NoSuchEquilibrium { number, n },
            _ => AnalysisError::NoStable { n },
        })?;
        let by = if found[place].branches.is_empty() {
            self.by_names(&found[place].q)?
        } else {
            self.by_names(&self.regular_pose())?
        };
        let names: Vec<&str> = by.iter().map(|(name, _)| name.as_str()).collect();
        let other = |(k, e): (usize, &Equilibrium)| OtherState {
            number: k + 1,
            place: place_of(&names, &e.pose),
            stability: e.stability,
        };
        let others = found.iter().enumerate().filter(|(k, _)| *k != place).map(other).collect();
        let own = found.swap_remove(place);
        let kinks = self.kinks_of(&own);
        let state = State {
            kinks,
            place: place_of(&names, &own.pose),
            stability: Some(own.stability),
            number: Some(place + 1),
            others,
            search: match (poses.is_searched, poses.is_complete) {
                (false, _) => Search::None,
                (true, false) => Search::Partial,
                (true, true) => Search::Complete,
            },
            ..State::of_motion(self.loaded, about, Vec::new())
        };
        Ok((own, state))
    }

    /// Kinks of the forces in an equilibrium; none where branches cross.
    pub(crate) fn kinks_of(&mut self, found: &Equilibrium) -> Vec<Kink> {
        if !found.branches.is_empty() {
            return Vec::new();
        }
        let kept = &self.loaded.kept;
        let lambda: Vec<f64> = kept.iter().map(|&row| found.lambda[row]).collect();
        self.kinks(&found.q, &lambda)
    }

    /// The state of the motion that the mechanism is in: its start, or an instant of its run.
    pub(crate) fn of_motion(&mut self, about: About) -> Result<State, AnalysisError> {
        let q = self.start();
        let by = self.by_names(&self.regular_pose()).unwrap_or_default();
        let names: Vec<&str> = by.iter().map(|(name, _)| name.as_str()).collect();
        let mut pose = pose_of(self.loaded, &self.loaded.q)?;
        let coordinates = self.loaded.system().coordinates();
        let state = |&i: &usize| (coordinates[i].rate_name.clone(), q[i], "");
        pose.extend(self.states().iter().map(state));
        Ok(State::of_motion(self.loaded, about, place_of(&names, &pose)))
    }

    /// Rates of joints and bodies at the start, for an answer that leaves them out.
    pub(crate) fn rates_of_start(&self) -> Result<Vec<(String, f64, String)>, AnalysisError> {
        let loaded = self.loaded;
        // What a steady motion has is not left out.
        let steady = self.steady().iter();
        let mut v: Vec<f64> = loaded.v.iter().zip(steady).map(|(v, steady)| v - steady).collect();
        self.states().iter().for_each(|&i| v[i] = 0.0);
        let largest = v.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        if largest == 0.0 {
            return Ok(Vec::new());
        }
        let n_of_joints: usize =
            loaded.model().joints.iter().map(|joint| joint.kind.motions().len()).sum();
        let quantities = &loaded.quantities;
        let rates = loaded.scalars(quantities)?.along(loaded.t, &loaded.q, &v);
        let turns = |k: &usize| rates[*k].abs() > NO_RATE * largest;
        let of_joints: Vec<usize> = (0..n_of_joints.min(rates.len())).filter(turns).collect();
        let all: Vec<usize> = (0..rates.len()).filter(turns).collect();
        let shown = if of_joints.is_empty() { all } else { of_joints };
        let rate = |k: usize| {
            let own = &quantities[k];
            (own.names[1].clone(), rates[k], rate_unit(own.unit, 1))
        };
        Ok(shown.into_iter().map(rate).collect())
    }

    /// Distance of two poses, angles in rad and lengths in longest links; whole turns count where forces differ by them.
    fn distance(&self, q: &[f64], start: &[f64]) -> f64 {
        let kinds = self.loaded.system().coordinates();
        let is_turn = |i: usize| {
            self.counts_turns && kinds[i].kind == bksim_mbs::coordinate::CoordinateKind::Angle
        };
        let off = self.apart(q, start).into_iter().enumerate();
        let off = off.map(|(i, off)| if is_turn(i) { q[i] - start[i] } else { off });
        off.map(|off| off.powi(2)).sum::<f64>().sqrt()
    }
}

/// The named quantities among those of a pose.
fn place_of(names: &[&str], pose: &[(String, f64, &'static str)]) -> Place {
    let own = |name: &&str| pose.iter().find(|(known, ..)| known == *name).cloned();
    names.iter().filter_map(own).collect()
}
