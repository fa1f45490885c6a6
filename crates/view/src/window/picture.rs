//! The picture: the mechanism at the clock's instant, and what the mouse does to it.

use egui::{PointerButton, Rect, Response, Sense, Ui, vec2};

use super::app::{App, Paint, lock};
use super::eye::Eye;
use super::{overlay, style};
use crate::renderer::Frame;
use crate::words::paint_words;

/// Enlargement per point of scrolling: a notch of the wheel is about a fifth.
const PER_POINT: f64 = 0.004;

/// Angle per point of dragging, rad.
const TURN: f64 = 0.008;

/// Shows the picture and says where it is.
pub(super) fn show(ui: &mut Ui, app: &mut App<'_>) -> Rect {
    let picture = ui.max_rect();
    let response = ui.allocate_rect(picture, Sense::click_and_drag());
    let size = [picture.width(), picture.height()].map(f64::from);
    let Some(show) = &mut app.show else { return picture };

    if app.eye.wants_fit(size) {
        app.eye.fit(size, show.points_over_run());
    } else {
        app.eye.resize(size);
    }
    move_eye(ui, &response, picture, &mut app.eye);

    let theme = show.theme();
    let camera = app.eye.camera();
    let frame = Frame {
        poses: show.poses(),
        extras: &app.extras,
        camera,
        theme,
        pixels_per_point: ui.ctx().pixels_per_point(),
    };
    let painter = ui.painter_at(picture);
    let paint = Paint(app.renderer.clone());
    painter.add(eframe::egui_wgpu::Callback::new_paint_callback(picture, paint));
    {
        let mut renderer = lock(&app.renderer);
        app.measure.count(renderer.prepare(&frame));
        paint_words(&painter, picture.min, renderer.words());
    }

    let (scene, poses) = (show.scene(), show.poses());
    let mut arrows = Vec::new();
    if let Some(scales) = show.scales() {
        if app.choices.reactions || app.choices.forces {
            arrows.push((style::color32(theme.force), scales.force, "N"));
        }
        if app.choices.velocities {
            arrows.push((style::color32(theme.velocity), scales.velocity, "m/s"));
        }
    }
    overlay::scales(&painter, picture, camera.scale, &arrows, theme);

    // A point under the pointer has its name; a click gives it a trail.
    let pointer = response.hover_pos().map(|at| at - picture.min);
    let at = pointer.map(|at| [at.x, at.y].map(f64::from));
    if let Some((place, [x, y])) = at.and_then(|at| overlay::marker_at(camera, scene, poses, at)) {
        let name = &scene.markers[place].name;
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let centre = picture.min + vec2(x as f32, y as f32);
        let stroke = egui::Stroke::new(2.0, style::accent(theme));
        painter.circle_stroke(centre, 9.0, stroke);
        if response.clicked() {
            app.choices.toggle_trail(name);
            ui.ctx().request_repaint();
        }
        response.on_hover_cursor(egui::CursorIcon::PointingHand).on_hover_text_at_pointer(name);
    }
    picture
}

/// Pans, turns and zooms.
fn move_eye(ui: &Ui, response: &Response, picture: Rect, eye: &mut Eye) {
    let drag = response.drag_delta();
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
