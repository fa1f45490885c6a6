//! [`Choices`]: the chosen additions to the mechanism; kept by name, so that they apply to another
//! motion of the same model, too.

use std::collections::BTreeSet;

use bksim_scene::Scene;

use super::action::Action;
use super::cutting::Cutting;
use crate::show::{Show, ShowOptions};

/// The chosen additions to the mechanism.
#[derive(Clone, PartialEq, Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of the view")]
pub(super) struct Choices {
    /// Names of joints and points.
    pub(super) labels: bool,
    /// Arrows of joint reactions.
    pub(super) reactions: bool,
    /// Arrows of velocities.
    pub(super) velocities: bool,
    /// Arrows of applied forces.
    pub(super) forces: bool,
    /// Names of the markers that leave trails.
    pub(super) trails: BTreeSet<String>,
    /// The section plane.
    pub(super) cutting: Cutting,
}

impl Choices {
    /// Does an action on additions; returns whether it was one.
    pub(super) fn apply(&mut self, action: Action, scene: &Scene) -> bool {
        let switch = match action {
            Action::Labels => &mut self.labels,
            Action::Reactions => &mut self.reactions,
            Action::Velocities => &mut self.velocities,
            Action::Forces => &mut self.forces,
            Action::Trails => {
                if self.trails.is_empty() {
                    self.trails = moving(scene).map(str::to_owned).collect();
                } else {
                    self.trails.clear();
                }
                return true;
            }
            _ => return false,
        };
        *switch = !*switch;
        true
    }

    /// Shows or hides the trail of a point.
    pub(super) fn toggle_trail(&mut self, name: &str) {
        if !self.trails.remove(name) {
            self.trails.insert(name.to_owned());
        }
    }

    /// Sets the options of a show; points that it does not have are skipped.
    pub(super) fn put_into(&self, show: &mut Show, is_dark: bool) {
        let trails = self.trail_indices(show.scene());
        let Self { labels, reactions, velocities, forces, .. } = *self;
        show.options = ShowOptions {
            labels,
            trails,
            reactions,
            velocities,
            forces,
            section: self.cutting.plane,
            dark: is_dark,
            ..ShowOptions::default()
        };
    }

    /// Indices of the markers that leave trails.
    fn trail_indices(&self, scene: &Scene) -> Vec<usize> {
        if self.trails.is_empty() {
            return Vec::new();
        }
        let markers = scene.markers.iter().enumerate();
        markers.filter(|(_, m)| self.trails.contains(&m.name)).map(|(idx, _)| idx).collect()
    }
}

/// Names of the points that move.
pub(super) fn moving(scene: &Scene) -> impl Iterator<Item = &str> {
    scene.markers.iter().filter(|m| m.at.body != 0).map(|m| m.name.as_str())
}

#[cfg(test)]
mod tests {
    use bksim_scene::{Attached, Marker, MarkerKind};

    use super::*;

    fn scene() -> Scene {
        let marker = |name: &str, body| Marker {
            name: name.into(),
            kind: MarkerKind::Point,
            at: Attached { body, position: [0.0; 3] },
        };
        let markers = vec![marker("O", 0), marker("crank.P", 1), marker("rod.P", 2)];
        Scene { markers, ..Scene::default() }
    }

    #[test]
    fn trails_are_of_all_moving_points_or_of_none() {
        let (scene, mut choices) = (scene(), Choices::default());
        assert!(choices.apply(Action::Trails, &scene));
        assert_eq!(choices.trail_indices(&scene), [1, 2]);
        choices.toggle_trail("crank.P");
        assert_eq!(choices.trail_indices(&scene), [2]);
        choices.apply(Action::Trails, &scene);
        assert!(choices.trails.is_empty());
    }

    #[test]
    fn another_scene_finds_the_same_points_by_name() {
        let (mut scene, mut choices) = (scene(), Choices::default());
        choices.toggle_trail("rod.P");
        choices.toggle_trail("gone");
        scene.markers.swap(0, 2);
        assert_eq!(choices.trail_indices(&scene), [0]);
    }

    #[test]
    fn switches_switch_and_other_actions_are_left_alone() {
        let (scene, mut choices) = (scene(), Choices::default());
        for action in [Action::Labels, Action::Reactions, Action::Velocities, Action::Forces] {
            let before = choices.clone();
            assert!(choices.apply(action, &scene) && choices != before);
            choices.apply(action, &scene);
            assert_eq!(choices, before);
        }
        assert!(!choices.apply(Action::Play, &scene));
    }
}
