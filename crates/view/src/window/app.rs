//! [`App`]: the state of a window, and one frame of it.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use bksim::sim::run::Unreplayed;
use egui::{Context, Frame, Rect, Ui, ViewportCommand};

use super::action::{self, Action};
use super::clock::Clock;
use super::measure::Measure;
use super::options::WindowOptions;
use super::panel::CurvePanel;
use super::report::{Outcome, Report};
use super::said::said;
use super::source::{Loader, News};
use super::values::{ValuePanel, Wish};
use super::viewport::Viewport;
use super::{controls, overlay, style};
use crate::renderer::SceneRenderer;
use crate::show::Show;

/// Width from which a window opens with its curves, points.
const WIDE: f32 = 900.0;

/// The state of a window.
pub(super) struct App<'a> {
    time: Time,
    viewport: Viewport,
    panel: CurvePanel,
    values: ValuePanel,
    loader: Loader,
    /// The last fault, until the files are read without one.
    fault: Option<String>,
    /// True if it ended the motion that is shown.
    is_fault_of_shown: bool,
    is_help_open: bool,
    reporting: Reporting<'a>,
}

/// The clock of a window, and how it is driven.
struct Time {
    clock: Clock,
    last_tick: Instant,
    /// The start of the first motion, until there is one.
    start: Option<Start>,
}

/// The start of the first motion.
struct Start {
    /// The first instant shown, s; that of the motion if none.
    t: Option<f64>,
    is_playing: bool,
}

/// The reports of a window to its caller.
struct Reporting<'a> {
    measure: Measure,
    report: Box<dyn FnMut(Report<'_>) + 'a>,
    outcome: Rc<RefCell<Outcome>>,
}

impl Time {
    /// Takes another motion.
    fn set_span(&mut self, span: [f64; 2]) {
        self.clock.set_span(span);
        if let Some(start) = self.start.take() {
            self.clock.seek(start.t.unwrap_or(span[0]));
            if start.is_playing {
                self.clock.toggle();
            }
        }
    }

    /// Advances the clock by the time since the last frame; gives the time of the motion that has passed, s.
    fn tick(&mut self) -> f64 {
        // A window that was hidden, or a slow adapter, does not make the motion jump.
        let elapsed = self.last_tick.elapsed().as_secs_f64().min(0.25);
        self.last_tick = Instant::now();
        self.clock.advance(elapsed);
        elapsed * self.clock.speed()
    }
}

impl<'a> App<'a> {
    pub(super) fn new(
        created: &eframe::CreationContext<'_>,
        options: &WindowOptions,
        loader: Loader,
        report: Box<dyn FnMut(Report<'_>) + 'a>,
        outcome: Rc<RefCell<Outcome>>,
    ) -> Option<Self> {
        let context = &created.egui_ctx;
        style::set(context, options.look);
        let state = created.wgpu_render_state.as_ref()?;
        let renderer = SceneRenderer::new(&state.device, &state.queue, state.target_format);
        let start = Start { t: options.t, is_playing: !options.is_paused };
        Some(Self {
            time: Time { clock: Clock::default(), last_tick: Instant::now(), start: Some(start) },
            viewport: Viewport::new(renderer, options.section),
            panel: CurvePanel::new(options.size[0] >= WIDE),
            values: ValuePanel::default(),
            loader,
            fault: None,
            is_fault_of_shown: false,
            is_help_open: false,
            reporting: Reporting { measure: Measure::new(options), report, outcome },
        })
    }

    /// Handles the news from the background.
    fn take_news(&mut self) {
        let news: Vec<News> = self.loader.news().collect();
        for news in news {
            match news {
                News::Unwatched(why) => {
                    (self.reporting.report)(Report::Unwatched(&why));
                }
                News::Loaded(loaded, seconds) => {
                    self.reporting.measure.mark_loaded();
                    self.is_fault_of_shown = loaded.show.is_some();
                    if let Some(show) = loaded.show {
                        self.take_show(show);
                    }
                    (self.reporting.report)(match &loaded.fault {
                        Some(fault) => Report::Fault(fault),
                        None => Report::Loaded(seconds),
                    });
                    self.reporting.outcome.borrow_mut().loads.push(loaded.fault.is_none());
                    self.fault = loaded.fault;
                }
            }
        }
    }

    /// Shows another motion: time, camera and choices stay.
    fn take_show(&mut self, show: Box<Show>) {
        self.time.set_span(show.span());
        self.panel.curves.set_motion(&show);
        self.values.set_motion(&show);
        self.viewport.set_show(show);
    }

    /// Does the action of a key or a button.
    fn act(&mut self, action: Action, context: &Context) {
        match action {
            Action::Quit => context.send_viewport_cmd(ViewportCommand::Close),
            Action::Theme => style::toggle_theme(context),
            Action::Help => self.is_help_open = !self.is_help_open,
            Action::Dismiss => self.is_help_open = false,
            Action::Save => self.save(),
            _ => self.act_on_motion(action),
        }
    }

    /// Writes values that were changed into the file.
    fn save(&mut self) {
        if let Err(why) = self.loader.save() {
            (self.reporting.report)(Report::Fault(&why));
            self.is_fault_of_shown = false;
            self.fault = Some(why);
        }
    }

    /// Does an action that needs a motion, if there is one.
    fn act_on_motion(&mut self, action: Action) {
        let Some(show) = &self.viewport.show else { return };
        let clock = &mut self.time.clock;
        let [first, last] = clock.span();
        match action {
            Action::Play => clock.toggle(),
            Action::Frame(n) => clock.step_frame(n),
            Action::LogStep { is_onward } => {
                let segments = show.playback().log().segments.iter().map(|s| s.t1);
                clock.step_to(is_onward, std::iter::once(first).chain(segments));
            }
            Action::Start => clock.seek(first),
            Action::End => clock.seek(last),
            Action::Speed(steps) => clock.change_speed(steps),
            Action::RealSpeed => clock.set_speed(1.0),
            Action::Loop => clock.is_looping = !clock.is_looping,
            Action::Live => self.viewport.toggle_live(),
            Action::Values => self.values.is_open = !self.values.is_open,
            Action::Fit => self.viewport.fit(),
            Action::Look(view) => self.viewport.look(view),
            Action::Section(_) | Action::MoveSection(_) => self.viewport.cut(action),
            Action::Panel => self.panel.is_open = !self.panel.is_open,
            Action::Labels
            | Action::Trails
            | Action::Reactions
            | Action::Velocities
            | Action::Forces => {
                self.viewport.choices.apply(action, show.scene());
            }
            Action::Theme | Action::Help | Action::Dismiss | Action::Save | Action::Quit => (),
        }
    }

    /// Brings the show to the clock's instant, with its additions, and the curves a little further.
    fn compute(&mut self, is_dark: bool) -> Result<(), Unreplayed> {
        self.viewport.apply_choices(is_dark);
        // The curves move the show to other instants, so they come before the picture.
        if let Some(show) = self.viewport.show.as_mut().filter(|_| self.panel.is_open) {
            self.panel.curves.go_on(show)?;
        }
        self.viewport.seek(self.time.clock.t())
    }

    /// Lays out the panels, the picture and its overlays.
    fn lay_out(&mut self, ui: &mut Ui) {
        let is_dark = ui.visuals().dark_mode;
        let actions = self.bar(ui);
        if let Err(error) = self.compute(is_dark) {
            self.fault = Some(error.to_string());
        }
        self.side(ui);
        let picture = egui::CentralPanel::default()
            .frame(Frame::new().fill(style::color32(style::theme(is_dark).background)))
            .show(ui, |ui| self.viewport.ui(ui, &mut self.reporting.measure))
            .inner;
        // A hand holds the motion, too.
        if self.viewport.is_posed() {
            self.time.clock.pause();
        }
        self.overlays(ui, picture);
        if !actions.is_empty() {
            ui.ctx().request_repaint();
        }
        for action in actions {
            self.act(action, ui.ctx());
        }
    }

    /// The bar of controls at the bottom; returns the actions of its buttons.
    fn bar(&mut self, ui: &mut Ui) -> Vec<Action> {
        let mut actions = Vec::new();
        egui::Panel::bottom("controls").frame(panel_frame(ui)).show(ui, |ui| {
            let scene = self.viewport.show.as_ref().map(|show| Arc::clone(show.scene()));
            let switches = controls::Switches {
                curves: self.panel.is_open,
                values: self.values.is_open,
                live: self.viewport.is_live(),
            };
            let (clock, choices) = (&mut self.time.clock, &mut self.viewport.choices);
            controls::show(ui, clock, choices, scene.as_deref(), switches, &mut actions);
        });
        actions
    }

    /// The panels of curves and values, if they are open and there is a motion.
    fn side(&mut self, ui: &mut Ui) {
        if self.values.is_open && self.viewport.show.is_some() {
            let left = egui::Panel::left("values").frame(panel_frame(ui));
            let left = left.default_size(240.0).min_size(160.0);
            let (loader, n_unsaved) = (&self.loader, self.loader.unsaved().len());
            let panel = |ui: &mut Ui| self.values.ui(ui, loader.takes_values, n_unsaved);
            for wish in left.show(ui, panel).inner {
                match wish {
                    Wish::Set(name, value) => self.loader.set_value(name, value),
                    Wish::Save => self.save(),
                    Wish::Revert => self.loader.revert(),
                }
            }
        }
        let Some(show) = self.viewport.show.as_ref().filter(|_| self.panel.is_open) else { return };
        let most = (0.6 * ui.available_width()).max(160.0);
        let side = egui::Panel::right("curves").frame(panel_frame(ui));
        let side = side.default_size(340.0_f32.min(most)).min_size(160.0).max_size(most);
        side.show(ui, |ui| self.panel.ui(ui, show, &mut self.time.clock));
    }

    /// Fault, progress and list of keys over the picture.
    fn overlays(&mut self, ui: &Ui, picture: Rect) {
        let has_motion = self.viewport.show.is_some();
        if let Some(fault) = &self.fault {
            let beneath = match (has_motion, self.is_fault_of_shown) {
                (false, _) => overlay::Beneath::Nothing,
                (true, false) => overlay::Beneath::Earlier,
                (true, true) => overlay::Beneath::Own,
            };
            overlay::fault(ui, picture, fault, beneath);
        }
        if let Some(part) = self.loader.task.part() {
            let words = if has_motion { "loading again" } else { "loading" };
            overlay::progress(ui, picture, part, said(words));
            ui.ctx().request_repaint_after_secs(0.05);
        }
        if self.is_help_open {
            self.is_help_open = overlay::help(ui);
        }
    }

    /// True if the next frame will differ from this one.
    fn is_moving(&self) -> bool {
        let clock = &self.time.clock;
        let has_motion = self.viewport.show.is_some();
        let has_curves = self.panel.is_open && has_motion && self.panel.curves.is_unfinished();
        clock.is_playing()
            || self.viewport.is_live()
            || self.viewport.is_unfinished(clock.t())
            || has_curves
    }
}

/// The frame of the bar and of the panel at the side.
fn panel_frame(ui: &Ui) -> Frame {
    let margin = egui::Margin::symmetric(10, 8);
    Frame::new().fill(ui.visuals().panel_fill).inner_margin(margin)
}

impl eframe::App for App<'_> {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        // It shows through the lines between panels.
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.reporting.measure.begin_frame(frame.info().cpu_usage);
        self.take_news();
        let elapsed = self.time.tick();
        self.viewport.advance(elapsed);
        if !context.text_edit_focused() {
            for action in context.input_mut(action::pressed) {
                self.act(action, &context);
            }
        }
        self.lay_out(ui);

        let has_motion = self.viewport.show.is_some();
        if self.reporting.measure.end_frame(&context, has_motion) {
            (self.reporting.report)(Report::FirstFrame);
        }
        if self.is_moving() {
            context.request_repaint();
        }
        let Reporting { measure, outcome, .. } = &mut self.reporting;
        measure.write_into(&mut outcome.borrow_mut());
        if measure.is_done() {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }
}
