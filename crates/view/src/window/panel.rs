//! The panel at the side: curves, with a cursor at the instant shown.

use bksim_scene::Theme;
use egui::{Color32, RichText, Ui, vec2};
use egui_plot::{AxisHints, Line, LineStyle, Plot, PlotPoints, VLine};

use super::clock::Clock;
use super::curves::{Curve, Curves};
use super::said::said;
use super::{grid, number, style};
use crate::show::Show;

/// Least height of a plot, points; the panel scrolls if they do not all fit.
const LOWEST: f32 = 120.0;

/// Height of a row of a legend, points.
const ROW: f32 = 18.0;

/// The panel of curves.
pub(super) struct CurvePanel {
    /// The chosen channels.
    pub(super) curves: Curves,
    /// True if the panel is shown.
    pub(super) is_open: bool,
    /// Text in the search field of the channels.
    search: String,
}

impl CurvePanel {
    /// A panel without curves.
    pub(super) fn new(is_open: bool) -> Self {
        Self { curves: Curves::default(), is_open, search: String::new() }
    }

    /// Shows the panel; a drag in a plot moves the clock.
    pub(super) fn ui(&mut self, ui: &mut Ui, show: &Show, clock: &mut Clock) {
        let Self { curves, search, .. } = self;
        ui.horizontal(|ui| {
            ui.label(RichText::new(said("Curves")).strong());
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.menu_button(said("Channels"), |ui| channels(ui, curves, search, show));
            });
        });
        let groups = curves.groups();
        if groups.is_empty() {
            ui.add_space(8.0);
            ui.weak(said("Choose channels to see them over time."));
            return;
        }
        ui.spacing_mut().interact_size.y = ROW;
        ui.spacing_mut().item_spacing.y = 3.0;
        // Plots share the height that the legends leave.
        let rows: usize = groups.iter().map(Vec::len).sum();
        let legends = (ROW + 3.0) * rows as f32;
        let free = ui.available_height() - legends - 16.0 * groups.len() as f32;
        let height = (free / groups.len() as f32).max(LOWEST);
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for (group_idx, group) in groups.iter().enumerate() {
                let theme = style::theme(ui.visuals().dark_mode);
                for (curve_idx, curve) in group {
                    legend(ui, color(*curve_idx, theme), curve, show);
                }
                plot(ui, group_idx, group, height, clock);
                ui.add_space(6.0);
            }
        });
    }
}

/// Colour of a curve.
fn color(curve_idx: usize, theme: &Theme) -> Color32 {
    style::color32(theme.palette[curve_idx % theme.palette.len()])
}

/// A row with a curve's colour, name and value.
fn legend(ui: &mut Ui, color: Color32, curve: &Curve, show: &Show) {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(12.0, 12.0), egui::Sense::hover());
        let line = [rect.left_center(), rect.right_center()];
        ui.painter().line_segment(line, egui::Stroke::new(2.5, color));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let value = number::value(curve.value(show.playback()));
            let unit = bksim_plot::unit_text(&curve.unit);
            ui.label(RichText::new(format!("{value} {unit}")).monospace());
            if curve.is_shared(show.playback()) {
                let words = "one of many solutions of the equilibrium; dashed in the plot";
                ui.label(RichText::new(said("not unique")).italics()).on_hover_text(said(words));
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                ui.add(egui::Label::new(&curve.name).truncate());
            });
        });
    });
}

/// Distances of labels, points: the grid has no lines that are too near.
const ANY: std::ops::RangeInclusive<f32> = 1.0..=2.0;

/// An axis whose numbers are those of the grid.
fn numbered(hints: AxisHints<'_>) -> AxisHints<'_> {
    hints.label_spacing(ANY).formatter(|mark, _| grid::label(mark))
}

/// Curves of one unit.
fn plot(ui: &mut Ui, group_idx: usize, group: &[(usize, &Curve)], height: f32, clock: &mut Clock) {
    let theme = style::theme(ui.visuals().dark_mode);
    let [first, last] = clock.span();
    let (low, high) = (first.min(last), first.max(last));
    let t = clock.t();
    let cursor = style::color32(theme.text.with_opacity(0.6));
    let plot = Plot::new(("curves", group_idx))
        .height(height)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .show_x(false)
        .show_y(false)
        .show_crosshair(false)
        .grid_spacing(28.0..=300.0)
        .grid_color(style::color32(theme.text.with_opacity(0.25)))
        .x_grid_spacer(grid::marks)
        .y_grid_spacer(grid::marks)
        .custom_x_axes(vec![numbered(AxisHints::new_x())])
        .custom_y_axes(vec![numbered(AxisHints::new_y()).min_thickness(44.0)])
        .set_margin_fraction(vec2(0.0, 0.08))
        .label_formatter(|_| None);
    let response = plot.show(ui, |ui| {
        ui.set_plot_bounds_x(low..=high);
        for (curve_idx, curve) in group {
            for (is_shared, points) in curve.pieces() {
                let points = PlotPoints::Borrowed(points);
                let line = Line::new(curve.name.as_str(), points).allow_hover(false);
                let style = if is_shared { LineStyle::dashed_loose() } else { LineStyle::Solid };
                ui.line(line.color(color(*curve_idx, theme)).width(1.5).style(style));
            }
        }
        ui.vline(VLine::new("now", t).color(cursor).width(1.0).allow_hover(false));
        let is_held = ui.response().is_pointer_button_down_on();
        ui.pointer_coordinate().filter(|_| is_held).map(|point| point.x)
    });
    if let Some(t) = response.inner {
        clock.seek(t);
    }
}

/// The list of channels, with a field that searches it.
fn channels(ui: &mut Ui, curves: &mut Curves, search: &mut String, show: &Show) {
    ui.set_width(260.0);
    let field = egui::TextEdit::singleline(search).hint_text(said("search"));
    ui.add(field.desired_width(f32::INFINITY));
    let playback = show.playback();
    let searched = search.to_lowercase();
    let names: Vec<(String, String)> = playback
        .channels()
        .signals()
        .filter(|(_, name, _)| name.to_lowercase().contains(&searched))
        .map(|(_, name, field)| (name, field.description.clone()))
        .collect();
    if names.is_empty() {
        ui.weak(said("no channel has this in its name"));
    }
    let height = ui.text_style_height(&egui::TextStyle::Body) + 8.0;
    let list = egui::ScrollArea::vertical().max_height(320.0).auto_shrink([false, true]);
    list.show_rows(ui, height, names.len(), |ui, rows| {
        for (name, description) in &names[rows] {
            let mut is_on = curves.has(name);
            let response = ui.checkbox(&mut is_on, name);
            if response.changed() {
                curves.toggle(name, playback);
            }
            response.on_hover_text(description);
        }
    });
}
