//! [`Cutting`]: the section plane of a window, which keys and a menu move.

use bksim::model::file::{ShownUnit, ShownUnits};
use bksim_scene::{CutSide, Section};
use egui::{Align, Layout, Ui};

use super::action::Action;
use super::number;
use super::said::said;

/// Steps of the keys over the whole mechanism.
const STEPS: f64 = 50.0;

/// The section plane of a window.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Cutting {
    /// The plane, if the mechanism is cut.
    pub(super) plane: Option<Section>,
    /// Unit of its distance from the origin.
    pub(super) unit: ShownUnit,
    /// Least and largest distance of the mechanism from the origin along its normal, m.
    reach: [f64; 2],
}

impl Default for Cutting {
    fn default() -> Self {
        Self::of(None)
    }
}

/// The unit vector along an axis, 0 to 2.
fn along(axis: usize) -> [f64; 3] {
    std::array::from_fn(|i| f64::from(u8::from(i == axis)))
}

impl Cutting {
    /// The section plane, of a mechanism that is not known yet.
    pub(super) fn of(plane: Option<Section>) -> Self {
        Self { plane, unit: ShownUnits::default().of("m"), reach: [0.0; 2] }
    }

    /// Does an action on the section plane of a mechanism that reaches to these points over its motion, m.
    pub(super) fn apply(&mut self, action: Action, points: &[[f64; 3]]) {
        match (action, &mut self.plane) {
            (Action::Section(axis), plane) => {
                let normal = along(axis);
                if plane.take_if(|plane| plane.normal() == normal).is_none() {
                    *plane = Section::new(normal, [0.0; 3], CutSide::Nearer);
                    self.measure(points);
                    // It begins in the middle.
                    let [low, high] = self.reach;
                    self.plane.iter_mut().for_each(|plane| plane.offset = 0.5 * (low + high));
                }
            }
            (Action::MoveSection(steps), Some(plane)) => {
                let [low, high] = self.reach;
                let offset = plane.offset + f64::from(steps) * (high - low) / STEPS;
                plane.offset = offset.max(low).min(high);
            }
            _ => (),
        }
    }

    /// Measures how far a mechanism reaches along the normal.
    pub(super) fn measure(&mut self, points: &[[f64; 3]]) {
        let Some(plane) = self.plane else { return };
        let normal = plane.normal();
        let heights = points.iter().map(|p| (0..3).map(|i| normal[i] * p[i]).sum::<f64>());
        let empty = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = heights
            .filter(|height| height.is_finite())
            .fold(empty, |(low, high), height| (low.min(height), high.max(height)));
        self.reach = if low <= high { [low, high] } else { [plane.offset; 2] };
    }
}

/// The menu: the axis, the place, and the side that is left out.
pub(super) fn menu(ui: &mut Ui, cutting: &mut Cutting, actions: &mut Vec<Action>) {
    ui.set_width(220.0);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        ui.horizontal(|ui| {
            let mut is_on = cutting.plane.is_some_and(|plane| plane.normal() == along(axis));
            if ui.checkbox(&mut is_on, format!("{} {name}", said("across"))).changed() {
                actions.push(Action::Section(axis));
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.weak(name.to_uppercase()));
        });
    }
    let Cutting { plane: Some(plane), unit, reach } = cutting else { return };
    ui.separator();
    let mut offset = unit.of_si(plane.offset);
    let [low, high] = reach.map(|x| unit.of_si(x));
    let slider = egui::Slider::new(&mut offset, low..=high).show_value(false).trailing_fill(true);
    if ui.add(slider).changed() {
        plane.offset = unit.to_si(offset);
    }
    ui.label(format!("{} {} {}", said("at"), number::value(offset), unit.unit));
    ui.radio_value(&mut plane.side, CutSide::Nearer, said("leave out the nearer side"));
    let is_fixed = plane.side == CutSide::Above;
    if ui.radio(is_fixed, said("leave out a fixed side")).clicked() {
        // Once more: the other one.
        *plane = if is_fixed { plane.reversed() } else { *plane };
        plane.side = CutSide::Above;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 3]; 3] = [[-1.0, 0.0, 2.0], [3.0, 0.0, 6.0], [f64::NAN; 3]];

    #[test]
    fn a_key_cuts_in_the_middle_and_again_no_longer() {
        let mut cutting = Cutting::default();
        cutting.apply(Action::Section(0), &POINTS);
        let plane = cutting.plane.expect("a plane");
        assert_eq!((plane.normal(), plane.offset), ([1.0, 0.0, 0.0], 1.0));
        cutting.apply(Action::Section(2), &POINTS);
        assert_eq!(cutting.plane.map(|plane| plane.offset), Some(4.0));
        cutting.apply(Action::Section(2), &POINTS);
        assert_eq!(cutting.plane, None);
        cutting.apply(Action::MoveSection(1), &POINTS);
        assert_eq!(cutting.plane, None);
    }

    #[test]
    fn it_moves_in_steps_up_to_the_ends_of_the_mechanism() {
        let mut cutting = Cutting::default();
        cutting.apply(Action::Section(0), &POINTS);
        let offset = |cutting: &Cutting| cutting.plane.map_or(f64::NAN, |plane| plane.offset);
        cutting.apply(Action::MoveSection(-1), &POINTS);
        assert!((offset(&cutting) - (1.0 - 4.0 / STEPS)).abs() < 1e-12);
        for _ in 0..60 {
            cutting.apply(Action::MoveSection(1), &POINTS);
        }
        assert_eq!(offset(&cutting), 3.0);
    }
}
