//! Buttons with signs, drawn as shapes: no font has all of them.

use egui::{Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};

use super::said::said;
use super::style;

/// A sign on a button.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Icon {
    Play,
    Pause,
    Start,
    FrameBack,
    FrameOn,
    Loop,
    Fit,
    Curves,
    Help,
}

/// Width and height of a button.
pub(super) const BUTTON: f32 = 28.0;

/// A button with a sign; `is_on` marks a switch that is on.
pub(super) fn button(ui: &mut Ui, icon: Icon, is_on: bool, words: &str) -> Response {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(BUTTON), Sense::click());
    if ui.is_rect_visible(rect) {
        let visuals = ui.style().interact(&response);
        let accent = style::accent(style::theme(ui.visuals().dark_mode));
        let color = if is_on { accent } else { visuals.fg_stroke.color };
        if response.hovered() || response.is_pointer_button_down_on() {
            ui.painter().rect_filled(rect, visuals.corner_radius, visuals.weak_bg_fill);
        }
        let sign = Rect::from_center_size(rect.center(), Vec2::splat(14.0));
        icon.paint(ui.painter(), sign, Stroke::new(1.6, color));
    }
    let words = said(words);
    let kind = egui::Role::Button;
    response.widget_info(|| egui::WidgetInfo::labeled(kind, true, words));
    response.on_hover_text(words)
}

impl Icon {
    /// Paints the sign into a square.
    fn paint(self, painter: &Painter, square: Rect, stroke: Stroke) {
        // Brushes, in coordinates from 0 to 1.
        let at = |x: f32, y: f32| square.lerp_inside(vec2(x, y));
        let color = stroke.color;
        let triangle = |points: [Pos2; 3]| {
            painter.add(Shape::convex_polygon(points.to_vec(), color, Stroke::NONE));
        };
        let bar = |x: f32, width: f32| {
            let rect = Rect::from_min_max(at(x, 0.08), at(x + width, 0.92));
            painter.rect_filled(rect, 1.0, color);
        };
        let line = |points: &[Pos2]| {
            painter.add(Shape::line(points.to_vec(), stroke));
        };

        // The signs.
        match self {
            Self::Play => triangle([at(0.16, 0.02), at(0.96, 0.5), at(0.16, 0.98)]),
            Self::Pause => {
                bar(0.16, 0.24);
                bar(0.6, 0.24);
            }
            Self::Start => {
                bar(0.1, 0.13);
                triangle([at(0.92, 0.08), at(0.32, 0.5), at(0.92, 0.92)]);
            }
            Self::FrameBack => {
                triangle([at(0.54, 0.12), at(0.02, 0.5), at(0.54, 0.88)]);
                bar(0.72, 0.13);
            }
            Self::FrameOn => {
                triangle([at(0.46, 0.12), at(0.98, 0.5), at(0.46, 0.88)]);
                bar(0.15, 0.13);
            }
            Self::Loop => {
                let (centre, radius) = (square.center(), 0.42 * square.width());
                let point = |angle: f32| centre + radius * Vec2::angled(angle);
                // An arc that is open at its arrow.
                let arc: Vec<Pos2> = (0..=28).map(|i| point(0.1 + 0.19 * i as f32)).collect();
                line(&arc);
                let tip = point(0.1 + 0.19 * 28.0);
                triangle([tip + vec2(2.4, 2.8), tip + vec2(-3.4, 1.6), tip + vec2(1.6, -3.2)]);
            }
            Self::Fit => {
                for (x, y) in [(0.04, 0.04), (0.96, 0.04), (0.04, 0.96), (0.96, 0.96)] {
                    let inward = |from: f32| from + 0.3 * (0.5 - from).signum();
                    line(&[at(inward(x), y), at(x, y), at(x, inward(y))]);
                }
            }
            Self::Curves => {
                line(&[at(0.04, 0.02), at(0.04, 0.96), at(1.0, 0.96)]);
                let wave = |i: u8| {
                    let x = f32::from(i) / 16.0;
                    at(0.2 + 0.76 * x, 0.42 - 0.28 * (5.6 * x).sin())
                };
                line(&(0..=16).map(wave).collect::<Vec<_>>());
            }
            Self::Help => {
                let font = egui::FontId::proportional(17.0);
                let centre = pos2(square.center().x, square.center().y);
                painter.text(centre, egui::Align2::CENTER_CENTER, "?", font, color);
            }
        }
    }
}
