//! [`Viewport`]: the mechanism at the clock's instant, and a camera that the mouse moves.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use bksim::sim::run::Unreplayed;
use bksim_scene::{Extras, Section, StandardView};
use eframe::egui_wgpu;
use egui::{Painter, PointerButton, Rect, Response, Sense, Ui, vec2};

use super::action::Action;
use super::choices::Choices;
use super::cutting::Cutting;
use super::eye::Eye;
use super::hand::{self, Hand};
use super::measure::Measure;
use super::{overlay, style};
use crate::renderer::{Counts, Frame, SceneRenderer};
use crate::show::Show;
use crate::words::paint_words;

/// Time that a frame may spend on trails and on the scale of arrows, which grow from frame to
/// frame.
const PATIENCE: Duration = Duration::from_millis(3);

/// Enlargement per point of scrolling: a notch of the wheel is about a fifth.
const PER_POINT: f64 = 0.004;

/// Angle per point of dragging, rad.
const TURN: f64 = 0.008;

/// A renderer that the window's render pass shares.
type SharedRenderer = Arc<Mutex<SceneRenderer>>;

/// The mechanism in the window: its motion, the camera, and the additions that are chosen.
pub(super) struct Viewport {
    /// The motion, once there is one.
    pub(super) show: Option<Box<Show>>,
    /// Additions that the user has chosen.
    pub(super) choices: Choices,
    eye: Eye,
    renderer: SharedRenderer,
    /// Additions to the mechanism at the instant shown.
    extras: Extras,
    /// The instant of `extras`; none if they are incomplete or out of date.
    extras_t: Option<f64>,
    /// The choices and the look that the show has.
    applied: Option<(Choices, bool)>,
    /// The hand on the mechanism, once there was one.
    hand: Option<Hand>,
}

impl Viewport {
    /// A viewport without a motion, which `section` will cut.
    pub(super) fn new(renderer: SceneRenderer, section: Option<Section>) -> Self {
        Self {
            show: None,
            choices: Choices { cutting: Cutting::of(section), ..Choices::default() },
            eye: Eye::new(true),
            renderer: Arc::new(Mutex::new(renderer)),
            extras: Extras::default(),
            extras_t: None,
            applied: None,
            hand: None,
        }
    }

    /// Takes another motion; the camera stays if it still fits, the choices in any case.
    pub(super) fn set_show(&mut self, mut show: Box<Show>) {
        show.patience = Some(PATIENCE);
        let is_planar = show.scene().is_planar;
        if self.show.as_ref().map(|known| known.scene().is_planar) != Some(is_planar) {
            self.eye = Eye::new(is_planar);
        }
        self.choices.cutting.unit = show.units.of("m");
        self.choices.cutting.measure(show.points_over_run());
        lock(&self.renderer).set_scene(Arc::clone(show.scene()), show.theme());
        (self.applied, self.extras_t, self.hand) = (None, None, None);
        self.show = Some(show);
    }

    /// Gives the show the choices and the look, if they have changed.
    pub(super) fn apply_choices(&mut self, is_dark: bool) {
        let Some(show) = &mut self.show else { return };
        let current = (&self.choices, is_dark);
        if self.applied.as_ref().map(|(choices, dark)| (choices, *dark)) != Some(current) {
            self.choices.put_into(show, is_dark);
            self.applied = Some((self.choices.clone(), is_dark));
            self.extras_t = None;
        }
    }

    /// Brings the show to an instant, with its additions.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub(super) fn seek(&mut self, t: f64) -> Result<(), Unreplayed> {
        let Some(show) = &mut self.show else { return Ok(()) };
        if show.t() != t {
            show.seek(t)?;
            lock(&self.renderer).follow(show.scene());
            // Another instant is asked for: the hand gives the picture back.
            if let Some(hand) = &mut self.hand {
                hand.open();
            }
        }
        if self.extras_t != Some(t) {
            self.extras = show.extras()?;
            self.extras_t = show.is_whole().then_some(t);
        }
        Ok(())
    }

    /// Begins or ends a motion without an end, which the hand can pull at.
    pub(super) fn toggle_live(&mut self) {
        let Some(show) = &self.show else { return };
        if self.hand.is_none() {
            self.hand = Hand::of(show.playback());
        }
        if let Some(hand) = &mut self.hand {
            hand.toggle_live(show.playback());
        }
    }

    /// Advances a live motion by `dt`, s.
    pub(super) fn advance(&mut self, dt: f64) {
        if let Some(hand) = &mut self.hand {
            hand.advance(dt);
        }
    }

    /// True while a live motion goes on.
    pub(super) fn is_live(&self) -> bool {
        self.hand.as_ref().is_some_and(Hand::is_live)
    }

    /// True while the hand decides what is shown.
    pub(super) fn is_posed(&self) -> bool {
        self.hand.as_ref().is_some_and(|hand| hand.poses().is_some())
    }

    /// Takes hold of the body under the pointer, moves it, and lets it go; true while it is held.
    fn hold(&mut self, ui: &Ui, response: &Response, picture: Rect) -> bool {
        let Some(show) = &self.show else { return false };
        let pixel = |at: egui::Pos2| {
            let at = at - picture.min;
            [at.x, at.y].map(f64::from)
        };
        if response.drag_started_by(PointerButton::Primary)
            && let Some(origin) = ui.input(|input| input.pointer.press_origin())
        {
            let poses = self.hand.as_ref().and_then(Hand::poses).unwrap_or(show.poses());
            let hit = hand::hit(self.eye.camera(), show.scene(), poses, pixel(origin));
            if let Some(hit) = hit {
                if self.hand.is_none() {
                    self.hand = Hand::of(show.playback());
                }
                if let Some(hand) = &mut self.hand {
                    hand.grab(show.playback(), hit);
                }
            }
        }
        let Some(hand) = &mut self.hand else { return false };
        let Some(held) = hand.held() else { return false };
        if response.drag_stopped() {
            hand.release();
        } else if let Some(pointer) = response.interact_pointer_pos() {
            hand.drag(self.eye.camera().unproject_like(pixel(pointer), held));
        }
        true
    }

    /// True if the picture of instant `t` is not complete yet.
    pub(super) fn is_unfinished(&self, t: f64) -> bool {
        self.show.as_ref().is_some_and(|show| show.t() != t || !show.is_whole())
    }

    /// Fits the whole motion into the picture.
    pub(super) fn fit(&mut self) {
        let Some(show) = &mut self.show else { return };
        let size = self.eye.camera().size;
        self.eye.fit(size, show.points_over_run());
    }

    /// Looks at a spatial mechanism from a standard direction, with the whole motion in the picture.
    pub(super) fn look(&mut self, view: StandardView) {
        self.eye.look(view);
        self.fit();
    }

    /// Does an action on the section plane; a planar mechanism has none.
    pub(super) fn cut(&mut self, action: Action) {
        if let Some(show) = self.show.as_mut().filter(|show| !show.scene().is_planar) {
            self.choices.cutting.apply(action, show.points_over_run());
        }
    }

    /// Shows the picture in all the space that is left; returns its rectangle.
    pub(super) fn ui(&mut self, ui: &mut Ui, measure: &mut Measure) -> Rect {
        let picture = ui.max_rect();
        let response = ui.allocate_rect(picture, Sense::click_and_drag());
        let size = [picture.width(), picture.height()].map(f64::from);
        let Some(show) = &mut self.show else { return picture };
        if self.eye.needs_fit(size) {
            self.eye.fit(size, show.points_over_run());
        } else {
            self.eye.resize(size);
        }
        let is_held = self.hold(ui, &response, picture);
        move_eye(ui, &response, picture, &mut self.eye, is_held);

        let painter = ui.painter_at(picture);
        if let Some(show) = &self.show {
            measure.count(self.paint(show, &painter, picture));
            let scale = self.eye.camera().scale;
            overlay::scales(&painter, picture, scale, &show.arrow_kinds(), show.theme());
            if let Some(hand) = &self.hand {
                let t = hand.t().map(|t| format!("live, t = {t:.2} s   ")).unwrap_or_default();
                overlay::words(&painter, picture, &format!("{t}{}", hand.words()), show.theme());
            }
        }
        self.point(ui, response, &painter, picture);
        picture
    }

    /// Paints the mechanism with its additions and words.
    fn paint(&self, show: &Show, painter: &Painter, picture: Rect) -> Counts {
        // Trails, arrows and ghosts are those of the run.
        let bare = Extras {
            has_labels: self.extras.has_labels,
            section: self.extras.section,
            ..Extras::default()
        };
        let posed = self.hand.as_ref().and_then(Hand::poses);
        let frame = Frame {
            poses: posed.unwrap_or(show.poses()),
            extras: if posed.is_some() { &bare } else { &self.extras },
            camera: self.eye.camera(),
            theme: show.theme(),
            pixels_per_point: painter.ctx().pixels_per_point(),
        };
        let callback = PaintScene(Arc::clone(&self.renderer));
        painter.add(egui_wgpu::Callback::new_paint_callback(picture, callback));
        let mut renderer = lock(&self.renderer);
        let counts = renderer.prepare(&frame);
        paint_words(painter, picture.min, renderer.words());
        counts
    }

    /// Names the point under the pointer; a click switches its trail.
    fn point(&mut self, ui: &Ui, response: Response, painter: &Painter, picture: Rect) {
        let Some(show) = &self.show else { return };
        let Some(pointer) = response.hover_pos().map(|at| at - picture.min) else { return };
        let at = [pointer.x, pointer.y].map(f64::from);
        let poses = self.hand.as_ref().and_then(Hand::poses).unwrap_or(show.poses());
        let marker = overlay::marker_at(self.eye.camera(), show.scene(), poses, at);
        let Some((marker_idx, [x, y])) = marker else { return };
        let name = &show.scene().markers[marker_idx].name;
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let centre = picture.min + vec2(x as f32, y as f32);
        let stroke = egui::Stroke::new(2.0, style::accent(show.theme()));
        painter.circle_stroke(centre, 9.0, stroke);
        if response.clicked() {
            self.choices.toggle_trail(name);
            ui.ctx().request_repaint();
        }
        response.on_hover_cursor(egui::CursorIcon::PointingHand).on_hover_text_at_pointer(name);
    }
}

/// Pans, turns and zooms; a body that is held is moved instead.
fn move_eye(ui: &Ui, response: &Response, picture: Rect, eye: &mut Eye, is_held: bool) {
    let drag = if is_held { egui::Vec2::ZERO } else { response.drag_delta() };
    let [dx, dy] = [drag.x, drag.y].map(f64::from);
    if drag != egui::Vec2::ZERO {
        let middle = PointerButton::Middle;
        if response.dragged_by(PointerButton::Primary) || response.dragged_by(middle) {
            eye.pan([dx, dy]);
        } else if response.dragged_by(PointerButton::Secondary) {
            eye.orbit(-TURN * dx, TURN * dy);
        }
    }
    let Some(pointer) = response.hover_pos() else { return };
    let (scroll, pinch) =
        ui.input(|input| (f64::from(input.smooth_scroll_delta().y), input.zoom_delta()));
    let factor = f64::from(pinch) * (PER_POINT * scroll).exp();
    if factor != 1.0 {
        let at = pointer - picture.min;
        eye.zoom(factor, [at.x, at.y].map(f64::from));
    }
}

/// The renderer; a panic elsewhere while it was held leaves nothing half done that matters.
fn lock(renderer: &SharedRenderer) -> MutexGuard<'_, SceneRenderer> {
    renderer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Paints the scene in the window's render pass.
struct PaintScene(SharedRenderer);

impl egui_wgpu::CallbackTrait for PaintScene {
    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &egui_wgpu::CallbackResources,
    ) {
        lock(&self.0).paint(pass);
    }
}
