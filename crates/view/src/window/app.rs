//! [`App`]: what a window is made of, and one frame of it.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bksim_scene::Extras;
use eframe::egui_wgpu;
use egui::{Context, Frame, Ui, ViewportCommand};

use super::action::{self, Action};
use super::choices::Choices;
use super::clock::Clock;
use super::curves::Curves;
use super::eye::Eye;
use super::measure::Measure;
use super::source::{Loader, News};
use super::{Outcome, Report, WindowOptions, controls, overlay, panel, picture, style};
use crate::renderer::SceneRenderer;
use crate::show::Show;

/// The window's wide enough for curves from here on.
const WIDE: f32 = 900.0;

/// What a frame may spend on trails and on the scale of arrows, which grow from frame to frame.
const PATIENCE: Duration = Duration::from_millis(3);

/// A renderer that the window's render pass shares.
pub(super) type SharedRenderer = Arc<Mutex<SceneRenderer>>;

/// What a window is made of.
pub(super) struct App<'a> {
    pub(super) clock: Clock,
    pub(super) eye: Eye,
    pub(super) choices: Choices,
    pub(super) show: Option<Box<Show>>,
    pub(super) renderer: SharedRenderer,
    /// What is drawn beside the mechanism at the instant shown.
    pub(super) extras: Extras,
    pub(super) measure: Measure,
    curves: Curves,
    search: String,
    loader: Loader,
    fault: Option<String>,
    is_panel_open: bool,
    is_help_open: bool,
    /// Choices and look that the show has.
    applied: Option<(Choices, bool)>,
    /// The instant that [`App::extras`] are of.
    extras_t: Option<f64>,
    last_tick: Instant,
    /// The instant to begin at, until a motion is there.
    first_t: Option<f64>,
    is_playing_at_first: bool,
    report: Box<dyn FnMut(Report<'_>) + 'a>,
    outcome: Rc<RefCell<Outcome>>,
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
        Some(Self {
            clock: Clock::default(),
            eye: Eye::new(true),
            choices: Choices::default(),
            show: None,
            renderer: Arc::new(Mutex::new(renderer)),
            extras: Extras::default(),
            measure: Measure::new(options),
            curves: Curves::default(),
            search: String::new(),
            loader,
            fault: None,
            is_panel_open: options.size[0] >= WIDE,
            is_help_open: false,
            applied: None,
            extras_t: None,
            last_tick: Instant::now(),
            first_t: options.t,
            is_playing_at_first: !options.is_paused,
            report,
            outcome,
        })
    }

    /// Takes what the background has to tell.
    fn take_news(&mut self) {
        let news: Vec<News> = self.loader.news().collect();
        for news in news {
            match news {
                News::Unwatched(why) => {
                    (self.report)(Report::Unwatched(&why));
                }
                News::Loaded(loaded, seconds) => {
                    self.measure.settle();
                    if let Some(show) = loaded.show {
                        self.take_show(show);
                    }
                    (self.report)(match &loaded.fault {
                        Some(fault) => Report::Fault(fault),
                        None => Report::Loaded(seconds),
                    });
                    self.outcome.borrow_mut().loads.push(loaded.fault.is_none());
                    self.fault = loaded.fault;
                }
            }
        }
    }

    /// Shows another motion: time, camera and choices stay.
    fn take_show(&mut self, mut show: Box<Show>) {
        show.patience = Some(PATIENCE);
        let known = self.show.as_ref().map(|known| known.scene().is_planar);
        if known != Some(show.scene().is_planar) {
            self.eye = Eye::new(show.scene().is_planar);
        }
        self.clock.set_span(show.span());
        if known.is_none() {
            self.clock.seek(self.first_t.take().unwrap_or(show.span()[0]));
            if self.is_playing_at_first {
                self.clock.toggle();
            }
        }
        self.curves.set_motion(show.playback());
        lock(&self.renderer).set_scene(Arc::clone(show.scene()), show.theme());
        (self.applied, self.extras_t) = (None, None);
        self.show = Some(show);
    }

    /// Lets time go on.
    fn tick(&mut self) {
        // A window that was hidden, or a slow adapter, does not make the motion jump.
        let elapsed = self.last_tick.elapsed().as_secs_f64().min(0.25);
        self.last_tick = Instant::now();
        self.clock.advance(elapsed);
    }

    /// Does what keys and buttons ask for.
    fn act(&mut self, action: Action, context: &Context) {
        let Some(show) = &mut self.show else {
            match action {
                Action::Quit => context.send_viewport_cmd(ViewportCommand::Close),
                Action::Theme => toggle_theme(context),
                Action::Help => self.is_help_open = !self.is_help_open,
                Action::Dismiss => self.is_help_open = false,
                _ => (),
            }
            return;
        };
        if self.choices.apply(action, show.scene()) {
            return;
        }
        let clock = &mut self.clock;
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
            Action::Speed(places) => clock.change_speed(places),
            Action::RealSpeed => clock.set_speed(1.0),
            Action::Loop => clock.is_looping = !clock.is_looping,
            Action::Fit => {
                let size = self.eye.camera().size;
                self.eye.fit(size, show.points_over_run());
            }
            Action::Theme => toggle_theme(context),
            Action::Panel => self.is_panel_open = !self.is_panel_open,
            Action::Help => self.is_help_open = !self.is_help_open,
            Action::Dismiss => self.is_help_open = false,
            Action::Quit => context.send_viewport_cmd(ViewportCommand::Close),
            Action::Labels
            | Action::Trails
            | Action::Reactions
            | Action::Velocities
            | Action::Forces => (),
        }
    }

    /// Brings the show to the clock's instant, with everything that is drawn beside it.
    fn compute(&mut self, is_dark: bool) {
        let Some(show) = &mut self.show else { return };
        let t = self.clock.t();
        let wanted = (&self.choices, is_dark);
        if self.applied.as_ref().map(|(choices, dark)| (choices, *dark)) != Some(wanted) {
            self.choices.put_into(show, is_dark);
            self.applied = Some((self.choices.clone(), is_dark));
            self.extras_t = None;
        }
        let curves = if self.is_panel_open { self.curves.go_on(show) } else { Ok(()) };
        let computed = curves.and_then(|()| {
            if show.t() != t {
                show.seek(t)?;
            }
            if self.extras_t != Some(t) {
                self.extras = show.extras()?;
                self.extras_t = show.is_whole().then_some(t);
            }
            Ok(())
        });
        if let Err(error) = computed {
            self.fault = Some(error.to_string());
        }
    }

    /// The panels and the picture.
    fn lay_out(&mut self, ui: &mut Ui) {
        let is_dark = ui.visuals().dark_mode;
        let margin = egui::Margin::symmetric(10, 8);
        let bar = Frame::new().fill(ui.visuals().panel_fill).inner_margin(margin);
        let mut actions = Vec::new();
        egui::Panel::bottom("controls").frame(bar).show(ui, |ui| {
            let scene = self.show.as_ref().map(|show| Arc::clone(show.scene()));
            let (clock, choices) = (&mut self.clock, &mut self.choices);
            let is_open = self.is_panel_open;
            controls::show(ui, clock, choices, scene.as_deref(), is_open, &mut actions);
        });
        self.compute(is_dark);
        if self.is_panel_open
            && let Some(show) = &self.show
        {
            let most = (0.6 * ui.available_width()).max(160.0);
            let side = egui::Panel::right("curves").frame(bar).default_size(340.0_f32.min(most));
            side.min_size(160.0).max_size(most).show(ui, |ui| {
                panel::show(ui, &mut self.curves, &mut self.search, show, &mut self.clock);
            });
        }
        let rect = egui::CentralPanel::default()
            .frame(Frame::new().fill(style::color32(style::theme(is_dark).background)))
            .show(ui, |ui| picture::show(ui, self))
            .inner;
        if let Some(fault) = &self.fault {
            overlay::fault(ui, rect, fault, self.show.is_some());
        }
        if let Some(part) = self.loader.task.part() {
            let words = if self.show.is_some() { "loading again" } else { "loading" };
            overlay::progress(ui, rect, part, words);
            ui.ctx().request_repaint_after_secs(0.05);
        }
        if self.is_help_open {
            self.is_help_open = overlay::help(ui);
        }
        if !actions.is_empty() {
            ui.ctx().request_repaint();
        }
        for action in actions {
            self.act(action, ui.ctx());
        }
    }

    /// Whether the next frame will be another one.
    fn is_moving(&self) -> bool {
        let is_behind = self.show.as_ref().is_some_and(|show| show.t() != self.clock.t());
        let has_curves = self.is_panel_open && self.show.is_some() && self.curves.is_unfinished();
        let has_more = self.show.as_ref().is_some_and(|show| !show.is_whole());
        self.clock.is_playing() || is_behind || has_curves || has_more
    }
}

impl eframe::App for App<'_> {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        // It shows through the lines between panels.
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.measure.begin_frame(frame.info().cpu_usage);
        self.take_news();
        self.tick();
        if !context.text_edit_focused() {
            for action in context.input_mut(action::pressed) {
                self.act(action, &context);
            }
        }
        self.lay_out(ui);

        if self.measure.end_frame(&context, self.show.is_some()) {
            (self.report)(Report::FirstFrame);
        }
        if self.is_moving() {
            context.request_repaint();
        }
        let mut outcome = self.outcome.borrow_mut();
        self.measure.write_into(&mut outcome);
        if self.measure.is_done() {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }
}

/// The renderer; a panic elsewhere while it was held leaves nothing half done that matters.
pub(super) fn lock(renderer: &SharedRenderer) -> MutexGuard<'_, SceneRenderer> {
    renderer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Light becomes dark, and dark light.
pub(super) fn toggle_theme(context: &Context) {
    let is_dark = context.theme() == egui::Theme::Dark;
    context.set_theme(if is_dark { egui::Theme::Light } else { egui::Theme::Dark });
}

/// Paints the scene in the window's render pass.
pub(super) struct Paint(pub(super) SharedRenderer);

impl egui_wgpu::CallbackTrait for Paint {
    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &egui_wgpu::CallbackResources,
    ) {
        lock(&self.0).paint(pass);
    }
}
