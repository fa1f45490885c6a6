//! [`Curves`]: chosen channels over the whole motion, computed a little in each frame.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use bksim::model::file::{ShownUnit, ShownUnits};
use bksim::overview::floor;
use bksim::playback::Playback;
use bksim::record::Signal;
use bksim::sim::run::Unreplayed;
use egui_plot::PlotPoint;

use crate::show::Show;

/// Number of instants of a curve: more than a panel has pixels.
const INSTANTS: usize = 800;

/// Time that a frame may spend on curves.
const BUDGET: Duration = Duration::from_millis(4);

/// Number of coordinates chosen at first.
const FIRST: usize = 3;

/// A channel over the motion.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// Name of the curve, such as `state.A_angle`.
    pub(super) name: String,
    /// The unit that it is shown in.
    pub(super) unit: String,
    /// SI.
    si: String,
    shown: ShownUnit,
    signal: Signal,
    points: Vec<PlotPoint>,
    /// Whether each of them is one of many solutions of the equilibrium.
    shared: Vec<bool>,
}

impl Curve {
    /// Points in pieces that meet, each with whether it is one of many solutions of the equilibrium.
    pub(super) fn pieces(&self) -> impl Iterator<Item = (bool, &[PlotPoint])> {
        let mut next = 0;
        self.shared.chunk_by(|a, b| a == b).map(move |alike| {
            let first = next;
            next += alike.len();
            (alike[0], &self.points[first.saturating_sub(1)..next])
        })
    }

    /// True if it is one of many solutions of the equilibrium at the instant shown.
    pub(super) fn is_shared(&self, playback: &Playback) -> bool {
        is_shared(self.signal, playback, playback.sample().t)
    }

    /// Value at the instant shown.
    pub(super) fn value(&self, playback: &Playback) -> f64 {
        self.shown.of_si(playback.value(self.signal))
    }
}

/// Chosen channels over the motion.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    /// Names of the channels, in the order they were chosen; kept when the motion lacks them.
    chosen: Vec<String>,
    /// True if the user has chosen; then another motion keeps the choice.
    is_chosen_by_hand: bool,
    all: Vec<Curve>,
    /// The reader's units.
    units: ShownUnits,
    /// Number of points of each curve so far.
    n_known: usize,
    /// By unit the largest size of all channels so far.
    largest: BTreeMap<String, f64>,
}

impl Curves {
    /// Takes another motion, with those of the chosen channels that it has.
    pub(super) fn set_motion(&mut self, show: &Show) {
        let playback = show.playback();
        self.units = show.units.clone();
        if !self.is_chosen_by_hand {
            self.chosen = overview(playback);
        }
        self.find(playback);
    }

    /// Adds or removes a channel.
    pub(super) fn toggle(&mut self, name: &str, playback: &Playback) {
        self.is_chosen_by_hand = true;
        match self.chosen.iter().position(|known| known == name) {
            Some(idx) => drop(self.chosen.remove(idx)),
            None => self.chosen.push(name.to_owned()),
        }
        self.find(playback);
    }

    /// True if a channel is chosen.
    pub(super) fn has(&self, name: &str) -> bool {
        self.chosen.iter().any(|known| known == name)
    }

    /// The curves in groups of one unit, in the order they were chosen.
    pub(super) fn groups(&self) -> Vec<Vec<(usize, &Curve)>> {
        let mut groups: Vec<Vec<(usize, &Curve)>> = Vec::new();
        for (idx, curve) in self.all.iter().enumerate() {
            match groups.iter_mut().find(|group| group[0].1.unit == curve.unit) {
                Some(group) => group.push((idx, curve)),
                None => groups.push(vec![(idx, curve)]),
            }
        }
        groups
    }

    /// True if points are left to compute.
    pub(super) fn is_unfinished(&self) -> bool {
        !self.all.is_empty() && self.n_known < INSTANTS
    }

    /// Computes more points, within the time of a frame. The show is at another instant afterwards.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub(super) fn go_on(&mut self, show: &mut Show) -> Result<(), Unreplayed> {
        let begun = Instant::now();
        let [first, last] = show.span();
        while self.is_unfinished() && begun.elapsed() < BUDGET {
            let part = self.n_known as f64 / (INSTANTS - 1) as f64;
            let t = first + part * (last - first);
            show.seek(t)?;
            for curve in &mut self.all {
                curve.points.push(PlotPoint::new(t, curve.value(show.playback())));
                curve.shared.push(is_shared(curve.signal, show.playback(), t));
            }
            let playback = show.playback();
            for (signal, _, field) in playback.channels().signals() {
                let size = playback.value(signal).abs();
                if size.is_finite() && size > self.largest.get(&field.unit).copied().unwrap_or(0.0)
                {
                    self.largest.insert(field.unit.clone(), size);
                }
            }
            self.n_known += 1;
        }
        if !self.is_unfinished() {
            self.leave_out_rounding();
        }
        Ok(())
    }

    fn leave_out_rounding(&mut self) {
        for curve in &mut self.all {
            let largest = self.largest.get(&curve.si).copied().unwrap_or(0.0);
            let floor = curve.shown.of_si(floor(&curve.si, largest));
            for point in curve.points.iter_mut().filter(|point| point.y.abs() <= floor) {
                point.y = 0.0;
            }
        }
    }

    /// Starts the curves of the chosen channels, those that the motion has.
    fn find(&mut self, playback: &Playback) {
        self.n_known = 0;
        self.largest.clear();
        let found = self.chosen.iter().filter_map(|name| {
            let mut signals = playback.channels().signals();
            let (signal, name, field) = signals.find(|(_, known, _)| known == name)?;
            let si = field.unit.clone();
            let shown = self.units.of(&si);
            let (unit, points, shared) = (shown.unit.clone(), Vec::new(), Vec::new());
            Some(Curve { name, unit, si, shown, signal, points, shared })
        });
        self.all = found.collect();
    }
}

fn is_shared(signal: Signal, playback: &Playback, t: f64) -> bool {
    !playback.channels().is_unique(signal, playback.uniqueness_at(t))
}

/// The channels chosen at first: some coordinates and the energies.
fn overview(playback: &Playback) -> Vec<String> {
    let names = || playback.channels().signals().map(|(_, name, _)| name);
    let is_coordinate = |name: &String| name.starts_with("state.") && !name.ends_with("_dot");
    let coordinates = names().filter(is_coordinate).take(FIRST);
    let energies = ["energy.kinetic", "energy.potential", "energy.total"];
    coordinates.chain(names().filter(|name| energies.contains(&name.as_str()))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::pendulum;

    /// A pendulum of one second.
    fn show() -> Show {
        pendulum("30 deg", "1 s")
    }

    #[test]
    fn an_overview_is_chosen_and_grouped_by_unit() {
        let (show, mut curves) = (show(), Curves::default());
        curves.set_motion(&show);
        let names: Vec<Vec<&str>> = curves
            .groups()
            .iter()
            .map(|group| group.iter().map(|(_, curve)| curve.name.as_str()).collect())
            .collect();
        let energies = vec!["energy.kinetic", "energy.potential", "energy.total"];
        assert_eq!(names, [vec!["state.A_angle"], energies]);
    }

    #[test]
    fn curves_have_the_values_of_their_instants_and_come_to_an_end() {
        let (mut show, mut curves) = (show(), Curves::default());
        curves.set_motion(&show);
        while curves.is_unfinished() {
            curves.go_on(&mut show).expect("the motion of the mechanism");
        }
        let groups = curves.groups();
        let angle = groups[0][0].1;
        assert_eq!(angle.points.len(), INSTANTS);
        for point in [angle.points[0], angle.points[123], angle.points[INSTANTS - 1]] {
            let sample = show.seek(point.x).expect("an instant");
            assert_eq!(sample.q[0], point.y);
        }
        assert_eq!(angle.points[INSTANTS - 1].x, 1.0);
    }

    #[test]
    fn a_curve_is_in_pieces_where_it_is_one_of_many_solutions() {
        let text = include_str!("../../../../tests/fixtures/block-against-stops.toml");
        let mechanism = bksim::Mechanism::from_toml(text, "block").expect("a model");
        let solved = bksim::solved::solve(mechanism, text, &|_| true).expect("a motion");
        let (mut show, mut curves) = (Show::new(solved.playback), Curves::default());
        let changes = show.playback().uniqueness();
        let (hit, first) = (changes[1].t, "multipliers.ld1");
        assert_eq!(changes.len(), 2, "{changes:?}");
        curves.toggle(first, show.playback());
        curves.toggle("state.rail_position", show.playback());
        while curves.is_unfinished() {
            curves.go_on(&mut show).expect("the motion of the mechanism");
        }
        let of = |name: &str| curves.all.iter().find(|curve| curve.name == name).expect("a curve");
        let pieces: Vec<_> = of(first).pieces().collect();
        let [(false, before), (true, after)] = pieces[..] else { panic!("{pieces:?}") };
        assert_eq!(before.last().map(|p| p.x), after.first().map(|p| p.x), "they meet");
        assert!(before.last().is_some_and(|p| p.x < hit) && after[1].x >= hit);
        assert_eq!(before.len() + after.len(), INSTANTS + 1);
        assert_eq!(of("state.rail_position").pieces().count(), 1);
        show.seek(0.0).expect("an instant");
        assert!(!of(first).is_shared(show.playback()));
        show.seek(1.0).expect("an instant");
        assert!(of(first).is_shared(show.playback()));
    }

    #[test]
    fn a_choice_by_hand_outlives_another_motion() {
        let (show, mut curves) = (show(), Curves::default());
        curves.set_motion(&show);
        curves.toggle("energy.kinetic", show.playback());
        curves.toggle("reactions.A.fx", show.playback());
        curves.set_motion(&show);
        assert!(curves.has("reactions.A.fx") && !curves.has("energy.kinetic"));
        assert_eq!(curves.groups().len(), 3, "an angle, energies, a force");
    }
}
