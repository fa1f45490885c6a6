//! [`Equilibrium`]: a pose at rest in which all forces are balanced.

use crate::open_reactions::OpenReactions;
use crate::table::Column;
use crate::way_rates::WayRates;

/// Stability of an equilibrium.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stability {
    /// The potential has a minimum, whatever is damped; of other forces, and with states, all small motions decay.
    Stable,
    /// A small motion grows without turning back.
    Unstable,
    /// A small motion grows to and fro, as by forces that follow or by damping below zero.
    Flutter,
    /// Small motions neither decay nor grow, though no potential keeps them small: what is left out decides.
    Marginal,
    /// A stiffness is zero: the next derivatives decide, or neighbouring poses are in balance, too.
    Neutral,
}

impl Stability {
    /// The most stable first.
    pub(crate) fn rank(self) -> usize {
        match self {
            Self::Stable => 0,
            Self::Marginal => 1,
            Self::Neutral => 2,
            Self::Flutter => 3,
            Self::Unstable => 4,
        }
    }
}

/// Equilibria of which every one has neighbours that are in balance, too.
#[derive(Clone, PartialEq, Debug)]
pub struct Family {
    /// Number of independent ways along it: 1 of a curve.
    pub dimension: usize,
    /// Positions of joints, coordinates of bodies without one, and states, that change along it.
    pub moves: Vec<String>,
    /// All quantities of the pose that change along it: their values are one choice of many.
    pub free: Vec<String>,
}

/// A stop that is closed.
#[derive(Clone, PartialEq, Debug)]
pub struct BearingStop {
    /// Name of the stop.
    pub name: String,
    /// `min` or `max`.
    pub limit: &'static str,
    /// The force or moment that it bears; above zero it pushes.
    pub effort: f64,
    /// `N` or `N*m`.
    pub unit: &'static str,
}

/// A stop that a pose lies beyond.
#[derive(Clone, PartialEq, Debug)]
pub struct PassedStop {
    /// Name of the stop.
    pub name: String,
    /// `min` or `max`.
    pub limit: &'static str,
    /// How far beyond the limit.
    pub depth: f64,
    /// `rad` or `m`.
    pub unit: &'static str,
}

/// One of the branches of poses that cross in an equilibrium.
#[derive(Clone, PartialEq, Debug)]
pub struct CrossingBranch {
    /// Rates of joints along it, the first of which is one.
    pub rates: WayRates,
    /// Stability along it.
    pub stability: Stability,
    /// Second derivative of the potential along it by the first of its rates, N m/rad or N/m.
    pub stiffness: f64,
    /// Rates of the coordinates along it, SI.
    pub(crate) direction: Vec<f64>,
}

/// A pose at rest in which all forces are balanced.
#[derive(Clone, PartialEq, Debug)]
pub struct Equilibrium {
    /// Generalised coordinates, SI.
    pub q: Vec<f64>,
    /// Multipliers of all constraint rows, SI.
    pub lambda: Vec<f64>,
    /// Stability; of a mechanism that nothing can move, stable.
    pub stability: Stability,
    /// Eigenvalues of K_r, ascending, SI; with states of controllers held. None where branches cross.
    pub stiffness: Vec<f64>,
    /// The branches of poses that cross in it, each with its own stability; none of a pose on one branch alone.
    pub branches: Vec<CrossingBranch>,
    /// The family that it stands for, of one that is not isolated; told by [`crate::statics`] alone.
    pub family: Option<Family>,
    /// Every joint position, body angle and point: name, value, unit; then states, without theirs.
    pub pose: Vec<(String, f64, &'static str)>,
    /// Reactions of the joints on their second bodies: force, then moment, world axes.
    pub reactions: Vec<[f64; 6]>,
    /// Stops that are closed in it.
    pub bearing: Vec<BearingStop>,
    /// Stops that are open at the start and that it lies beyond: the mechanism cannot come to rest there.
    pub beyond: Vec<PassedStop>,
    /// The reactions that equilibrium leaves open.
    pub open: OpenReactions,
}

/// Columns of a table of equilibria: stability, the smallest stiffness, the pose, the reactions.
pub(crate) fn columns(of: Option<&Equilibrium>, joints: &[String]) -> Vec<Column> {
    let first = [Column::new("stability", ""), Column::new("stiffness", "")];
    let pose = of.map_or(&[][..], |equilibrium| &equilibrium.pose);
    let pose = pose.iter().map(|(name, _, unit)| Column::new(name.clone(), *unit));
    first.into_iter().chain(pose).chain(reaction_columns(joints)).collect()
}

/// A row of that table; the stability is 1, 0, −1 for stable, neutral or marginal, unstable.
pub(crate) fn cells(equilibrium: &Equilibrium) -> Vec<f64> {
    let stability = match equilibrium.stability {
        Stability::Stable => 1.0,
        Stability::Neutral | Stability::Marginal => 0.0,
        Stability::Unstable | Stability::Flutter => -1.0,
    };
    let by_branch = equilibrium.branches.iter().map(|branch| branch.stiffness);
    let by_branch = by_branch.fold(f64::INFINITY, f64::min);
    let least = equilibrium.stiffness.first().copied().unwrap_or(by_branch);
    let pose = equilibrium.pose.iter().map(|(_, value, _)| *value);
    let reactions = equilibrium.reactions.iter().flatten().copied();
    [stability, least].into_iter().chain(pose).chain(reactions).collect()
}

/// Columns of the reactions of joints: force and moment on the second body, world axes.
pub(crate) fn reaction_columns(joints: &[String]) -> Vec<Column> {
    let words =
        [("fx", "N"), ("fy", "N"), ("fz", "N"), ("mx", "N*m"), ("my", "N*m"), ("mz", "N*m")];
    let of =
        |joint: &String| words.map(|(word, unit)| Column::new(format!("{joint}.{word}"), unit));
    joints.iter().flat_map(of).collect()
}
