//! The window of a figure: the same panels and curves as in a picture of it, to zoom into and to read.
//!
//! ```text
//! Figure → Graph     its curves as unbroken pieces, made once
//! View               chosen ranges of a panel's axes; over time all panels together
//! clip               the visible part of a curve, no finer than pixels
//! ```

mod clip;
mod graph;
mod panel;

use std::cell::RefCell;
use std::rc::Rc;

use bksim_plot::{Figure, Theme};
use egui::{Context, Key, Rect, RichText, Ui, UiBuilder, ViewportCommand, pos2, vec2};

use self::graph::Graph;
use self::panel::View;
use super::icon::{self, Icon};
use super::measure::Measure;
use super::options::WindowOptions;
use super::report::{Outcome, WindowError};
use super::said::said;
use super::{number, run, style};

/// Space around panels, points.
const GAP: f32 = 10.0;

/// Opens a window with a figure, and returns when it is closed. The start of a motion in the
/// options has no effect, and nothing is reported.
///
/// # Errors
/// [`WindowError`] when it cannot be opened.
pub fn open_figure(figure: &Figure, options: &WindowOptions) -> Result<Outcome, WindowError> {
    let outcome = Rc::new(RefCell::new(Outcome::default()));
    let chart = Chart {
        title: figure.title.clone(),
        n_columns: figure.grid().0,
        graphs: figure.panels.iter().map(Graph::new).collect(),
        views: vec![View::default(); figure.panels.len()],
        cursor: None,
        is_help_open: false,
        measure: Measure::new(options),
        outcome: Rc::clone(&outcome),
    };
    let look = options.look;
    run(&figure.title, options, move |created| {
        style::set(&created.egui_ctx, look);
        Some(Box::new(chart))
    })?;
    Ok(outcome.take())
}

/// The state of the window.
struct Chart {
    title: String,
    n_columns: usize,
    graphs: Vec<Graph>,
    views: Vec<View>,
    /// Position of the pointer on the common axis of all panels.
    cursor: Option<f64>,
    is_help_open: bool,
    measure: Measure,
    outcome: Rc<RefCell<Outcome>>,
}

impl Chart {
    /// The title, the instant at the pointer, and the buttons.
    fn head(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.label(RichText::new(&self.title).heading());
            let common = self.graphs.iter().find(|graph| graph.is_over_time);
            if let (Some(x), Some(graph)) = (self.cursor, common) {
                let value = number::value(graph.x.value(x));
                ui.add_space(12.0);
                ui.label(RichText::new(format!("{} {value}", graph.x.name)).monospace());
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if icon::button(ui, Icon::Help, false, "keys and mouse (?)").clicked() {
                    self.is_help_open = !self.is_help_open;
                }
                if icon::button(ui, Icon::Fit, false, "show everything (F)").clicked() {
                    self.views.fill(View::default());
                }
                let is_dark = ui.visuals().dark_mode;
                let words = if is_dark { "Light" } else { "Dark" };
                if ui.button(said(words)).on_hover_text(said("light, dark (D)")).clicked() {
                    style::toggle_theme(ui.ctx());
                }
            });
        });
    }

    /// Panels in reading order.
    fn panels(&mut self, ui: &mut Ui, theme: &Theme) {
        let n_rows = self.graphs.len().div_ceil(self.n_columns).max(1);
        let all = ui.available_rect_before_wrap();
        let size = vec2(all.width() / self.n_columns as f32, all.height() / n_rows as f32);
        let mut cursor = None;
        for (idx, graph) in self.graphs.iter_mut().enumerate() {
            let (row, column) = (idx / self.n_columns, idx % self.n_columns);
            let corner = pos2(all.left() + column as f32 * size.x, all.top() + row as f32 * size.y);
            let rect = Rect::from_min_size(corner, size).shrink(0.5 * GAP);
            let builder = UiBuilder::new().id_salt(idx).max_rect(rect);
            let input = ui.scope_builder(builder, |ui| {
                panel::show(ui, graph, &mut self.views[idx], self.cursor, theme)
            });
            let panel::PointerInput { cursor: at, is_moved } = input.inner;
            cursor = cursor.or(at);
            // Panels over time share their axis.
            if is_moved && graph.is_over_time {
                let x = self.views[idx].x;
                self.views.iter_mut().for_each(|view| view.x = x);
            }
        }
        if cursor != self.cursor {
            self.cursor = cursor;
            ui.ctx().request_repaint();
        }
    }

    /// Does the actions of the keys that are pressed.
    fn keys(&mut self, context: &Context) {
        let pressed = |key| context.input(|input| input.key_pressed(key));
        if pressed(Key::F) || pressed(Key::Home) {
            self.views.fill(View::default());
        }
        if pressed(Key::D) {
            style::toggle_theme(context);
        }
        if pressed(Key::Questionmark) || pressed(Key::H) {
            self.is_help_open = !self.is_help_open;
        }
        let is_command = context.input(|input| input.modifiers.command);
        if is_command && (pressed(Key::Q) || pressed(Key::W)) {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }
}

/// Actions of keys and the mouse.
const HELP: [(&str, &str); 9] = [
    ("pointer", "values at that instant"),
    ("wheel, pinch", "zoom at the pointer"),
    ("drag", "move"),
    ("drag at an axis", "zoom along it"),
    ("right drag", "zoom to a box"),
    ("double click, F, Home", "everything"),
    ("click a name", "hide the curve, or show it"),
    ("D", "light, dark"),
    ("Ctrl + Q", "close"),
];

/// The list of keys; false when it is to be closed.
fn help(ui: &Ui) -> bool {
    let modal = egui::Modal::new(ui.scope_id().with("help")).show(ui.ctx(), |ui| {
        ui.label(RichText::new(said("Keys and mouse")).heading());
        ui.add_space(6.0);
        egui::Grid::new("keys").num_columns(2).spacing(vec2(24.0, 3.0)).show(ui, |ui| {
            for (name, words) in HELP {
                ui.label(RichText::new(said(name)).strong());
                ui.label(said(words));
                ui.end_row();
            }
        });
    });
    !modal.should_close()
}

impl eframe::App for Chart {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.measure.begin_frame(frame.info().cpu_usage);
        self.measure.mark_loaded();
        self.keys(&context);
        let is_dark = ui.visuals().dark_mode;
        let theme = if is_dark { &Theme::DARK } else { &Theme::LIGHT };
        let fill = ui.visuals().extreme_bg_color;
        let frame = egui::Frame::new().fill(fill).inner_margin(egui::Margin::same(8));
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            self.head(ui);
            self.panels(ui, theme);
        });
        if self.is_help_open {
            self.is_help_open = help(ui);
        }
        self.measure.end_frame(&context, true);
        let mut outcome = self.outcome.borrow_mut();
        self.measure.write_into(&mut outcome);
        if self.measure.is_done() {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }
}
