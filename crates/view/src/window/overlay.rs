//! Overlays of the picture: faults, progress, scales, and the list of keys.

use bksim_scene::vectors::ArrowKind;
use bksim_scene::{Camera, Scene, Theme};
use egui::{Align2, FontId, Margin, Painter, Rect, RichText, Stroke, Ui, pos2, vec2};

use super::action::{BINDINGS, MOUSE};
use super::said::said;
use super::{number, style};
use bksim::sim::pose::Pose;

/// Distance of overlays from the edges of the picture, points.
const EDGE: f32 = 14.0;

/// Largest distance of the pointer from a point that it selects, points.
const REACH: f64 = 10.0;

/// The frame of an overlay.
fn frame(ui: &Ui) -> egui::Frame {
    let visuals = ui.visuals();
    egui::Frame::new()
        .fill(visuals.window_fill)
        .stroke(visuals.window_stroke)
        .corner_radius(8)
        .inner_margin(Margin::same(12))
}

/// The motion in the picture below a fault.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Beneath {
    /// Nothing.
    Nothing,
    /// That of an earlier state of the files.
    Earlier,
    /// That of the files, as far as it came.
    Own,
}

impl Beneath {
    /// The headline of the fault.
    fn title(self) -> &'static str {
        match self {
            Self::Nothing => "Nothing to show until this is put right",
            Self::Earlier => {
                "Not what is shown: the last good motion stays until this is put right"
            }
            Self::Own => "The motion ended early: it is shown as far as it came",
        }
    }
}

/// A fault, over the upper part of the picture.
pub(super) fn fault(ui: &Ui, picture: Rect, text: &str, beneath: Beneath) {
    let width = picture.width() - 2.0 * EDGE;
    let area = egui::Area::new(ui.scope_id().with("fault"))
        .order(egui::Order::Middle)
        .fixed_pos(picture.min + vec2(EDGE, EDGE))
        .movable(false);
    area.show(ui.ctx(), |ui| {
        let red = ui.visuals().error_fg_color;
        frame(ui).stroke(Stroke::new(1.5, red)).show(ui, |ui| {
            ui.set_width((width - 27.0).max(80.0));
            ui.label(RichText::new(said(beneath.title())).strong().color(red));
            ui.add_space(2.0);
            // A motion stays visible below it.
            let part = if beneath == Beneath::Nothing { 0.8 } else { 0.28 };
            let area = egui::ScrollArea::vertical().max_height(part * picture.height());
            area.auto_shrink([false, true]).show(ui, |ui| {
                let text = RichText::new(text).monospace();
                ui.add(egui::Label::new(text).wrap().selectable(true));
            });
        });
    });
}

/// Progress of the work in the background, in the lower right corner.
pub(super) fn progress(ui: &Ui, picture: Rect, part: f64, words: &str) {
    let theme = style::theme(ui.visuals().dark_mode);
    let painter = ui.painter_at(picture);
    let size = vec2(150.0, 30.0);
    let box_ = Rect::from_min_size(picture.max - vec2(EDGE, EDGE) - size, size);
    painter.rect_filled(box_, 8.0, ui.visuals().window_fill);
    painter.rect_stroke(box_, 8.0, ui.visuals().window_stroke, egui::StrokeKind::Inside);
    let text = box_.left_top() + vec2(12.0, 5.0);
    let color = style::color32(theme.text);
    painter.text(text, Align2::LEFT_TOP, words, FontId::proportional(12.0), color);
    let rail =
        Rect::from_min_size(box_.left_bottom() + vec2(12.0, -8.0), vec2(box_.width() - 24.0, 2.5));
    painter.rect_filled(rail, 1.0, ui.visuals().widgets.active.bg_fill);
    #[expect(clippy::cast_possible_truncation, reason = "0 to 1")]
    let done = Rect::from_min_size(rail.min, vec2(rail.width() * part as f32, rail.height()));
    painter.rect_filled(done, 1.0, style::accent(theme));
}

/// The nearest moving marker at a pixel of the picture, and its own pixel.
pub(super) fn marker_at(
    camera: &Camera,
    scene: &Scene,
    poses: &[Pose],
    [x, y]: [f64; 2],
) -> Option<(usize, [f64; 2])> {
    let distance = |(idx, marker): (usize, &bksim_scene::Marker)| {
        let pose = poses.get(marker.at.body).filter(|_| marker.at.body != 0)?;
        let [px, py, _] = camera.project(pose.place(marker.at.position));
        Some(((px - x).hypot(py - y), idx, [px, py]))
    };
    let markers = scene.markers.iter().enumerate().filter_map(distance);
    let near = markers.filter(|(distance, ..)| *distance <= REACH);
    let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, idx, at)| (idx, at))
}

/// Scale bars of lengths, and of each kind of arrow that is shown; `scale` is the number of pixels in a metre.
pub(super) fn scales(
    painter: &Painter,
    picture: Rect,
    scale: f64,
    arrows: &[ArrowKind],
    theme: &Theme,
) {
    let bar = Some(number::round_below(110.0 / scale)).filter(|metres| *metres > 0.0);
    let bar = bar
        .map(|metres| (style::color32(theme.faint), scale * metres, number::quantity(metres, "m")));
    let arrows = arrows.iter().flat_map(|kind| {
        let samples = kind.scale.samples();
        samples.into_iter().map(|(size, metres)| {
            let words = format!("{} {}", said(kind.name), number::quantity(size, kind.unit));
            (style::color32(kind.color), scale * metres, words)
        })
    });
    let mut y = picture.bottom() - EDGE;
    for (idx, (color, pixels, words)) in bar.into_iter().chain(arrows).enumerate() {
        if picture.width() < 260.0 {
            continue;
        }
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let width = pixels as f32;
        let left = pos2(picture.left() + EDGE, y - 4.0);
        let stroke = Stroke::new(1.6, color);
        if idx == 0 {
            let right = left + vec2(width, 0.0);
            painter.line_segment([left, right], stroke);
            for end in [left, right] {
                painter.vline(end.x, end.y - 4.0..=end.y + 4.0, stroke);
            }
        } else {
            let tip = left + vec2(width, 0.0);
            painter.line_segment([left, tip - vec2(6.0, 0.0)], stroke);
            let head = vec![tip, tip + vec2(-8.0, -3.5), tip + vec2(-8.0, 3.5)];
            painter.add(egui::Shape::convex_polygon(head, color, Stroke::NONE));
        }
        let text = left + vec2(width + 8.0, 0.0);
        painter.text(text, Align2::LEFT_CENTER, words, FontId::proportional(12.0), color);
        y -= 20.0;
    }
}

/// A line of words in the upper left corner.
pub(super) fn words(painter: &Painter, picture: Rect, text: &str, theme: &Theme) {
    let at = picture.min + vec2(EDGE, EDGE);
    let color = style::color32(theme.faint);
    painter.text(at, Align2::LEFT_TOP, text, FontId::proportional(14.0), color);
}

/// The list of keys; false when it is to be closed.
pub(super) fn help(ui: &Ui) -> bool {
    let modal = egui::Modal::new(ui.scope_id().with("help")).frame(frame(ui).inner_margin(18));
    let modal = modal.show(ui.ctx(), |ui| {
        ui.set_width(330.0);
        ui.spacing_mut().interact_size.y = 17.0;
        ui.label(RichText::new(said("Keys and mouse")).heading());
        ui.add_space(6.0);
        let height = ui.ctx().content_rect().height() - 110.0;
        let height = height.max(80.0);
        let area = egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height);
        area.show(ui, |ui| {
            egui::Grid::new("keys").num_columns(2).spacing(vec2(24.0, 3.0)).show(ui, |ui| {
                let keys = BINDINGS.iter().filter_map(|binding| binding.help);
                for (name, words) in keys.chain(MOUSE) {
                    ui.label(RichText::new(said(name)).strong());
                    ui.label(said(words));
                    ui.end_row();
                }
            });
        });
    });
    !modal.should_close()
}

#[cfg(test)]
mod tests {
    use bksim_scene::{Attached, Marker, MarkerKind};

    use super::*;

    #[test]
    fn the_nearest_moving_point_within_reach_is_found() {
        let marker = |body, x| Marker {
            name: String::new(),
            kind: MarkerKind::Point,
            at: Attached { body, position: [x, 0.0, 0.0] },
        };
        let markers = vec![marker(0, 0.0), marker(1, 0.0), marker(1, 5.0)];
        let scene = Scene { markers, ..Scene::default() };
        let poses = [Pose::default(); 2];
        let camera = Camera::planar([200.0, 100.0]);
        let found = |at| marker_at(&camera, &scene, &poses, at).map(|(idx, _)| idx);
        assert_eq!(found([100.0, 50.0]), Some(1));
        assert_eq!(found([103.0, 50.0]), Some(2));
        assert_eq!(found([115.0, 50.0]), Some(2), "at the reach");
        assert_eq!(found([116.0, 50.0]), None);
    }
}
