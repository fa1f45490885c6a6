//! The panel of values: a slider for each parameter that is a number, and buttons that keep what was changed.

use bksim::model::StatedRange;
use bksim::model::file::ShownUnit;
use bksim_edit::range_about;
use egui::{RichText, Slider, Ui};

use crate::show::Show;

use super::said::said;

/// The panel of values.
#[derive(Debug, Default)]
pub(super) struct ValuePanel {
    /// True if the panel is shown.
    pub(super) is_open: bool,
    rows: Vec<Row>,
}

/// A parameter with its slider.
#[derive(Clone, PartialEq, Debug)]
struct Row {
    name: String,
    unit: ShownUnit,
    /// In `unit`.
    value: f64,
    range: [f64; 2],
}

/// A request of the panel.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Wish {
    /// Another value of a parameter, as text.
    Set(String, String),
    /// The changed values are written into the file.
    Save,
    /// The values of the file come back.
    Revert,
}

impl ValuePanel {
    /// Takes the parameters of another motion; ranges stay while values lie in them.
    pub(super) fn set_motion(&mut self, show: &Show) {
        let mechanism = show.playback().mechanism();
        let model = &mechanism.model;
        let known = std::mem::take(&mut self.rows);
        let numbers = model.parameters.iter().zip(&mechanism.parameters);
        // Those that depend on no others.
        let numbers = numbers.filter(|(p, _)| model.pool.evaluate(p.definition, &|_| None).is_ok());
        self.rows = numbers
            .map(|(parameter, si)| {
                let unit = show.units.of(&parameter.unit);
                let value = unit.of_si(*si);
                let old = known.iter().find(|row| row.name == parameter.name && row.unit == unit);
                let range = old.map(|row| row.range).filter(|[a, b]| (*a..=*b).contains(&value));
                let is_own =
                    |range: &&StatedRange| range.path == format!("parameters.{}", parameter.name);
                let stated = model.ranges.iter().find(is_own);
                let stated = stated.map(|range| range.ends.map(|end| unit.of_si(end)));
                let range = stated.or(range).unwrap_or_else(|| range_about(value, &unit.unit));
                Row { name: parameter.name.clone(), unit, value, range }
            })
            .collect();
    }

    /// Shows the panel, with buttons to keep changes if `n_unsaved` parameters have other values than in the file.
    pub(super) fn ui(&mut self, ui: &mut Ui, takes_values: bool, n_unsaved: usize) -> Vec<Wish> {
        ui.label(RichText::new(said("Values")).strong());
        if self.rows.is_empty() || !takes_values {
            ui.add_space(8.0);
            ui.weak(said(if takes_values {
                "The model has no parameters that are numbers."
            } else {
                "A log keeps its values: open its model to change them."
            }));
            return Vec::new();
        }
        let mut wishes = Vec::new();
        ui.add_enabled_ui(n_unsaved > 0, |ui| {
            ui.horizontal(|ui| {
                let save = ui.button(said("Save in the file")).on_hover_text("Ctrl + S");
                wishes.extend(save.clicked().then_some(Wish::Save));
                wishes.extend(ui.button(said("Undo all")).clicked().then_some(Wish::Revert));
            });
        });
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for row in &mut self.rows {
                ui.label(&row.name);
                let [low, high] = row.range;
                let slider = Slider::new(&mut row.value, low..=high).max_decimals(6);
                let slider = slider.suffix(format!(" {}", row.unit.unit));
                let slider = slider.clamping(egui::SliderClamping::Never);
                if ui.add(slider).changed() {
                    let text = format!("{} {}", row.value, row.unit.unit);
                    wishes.push(Wish::Set(row.name.clone(), text.trim_end().to_owned()));
                }
            }
        });
        wishes
    }
}
