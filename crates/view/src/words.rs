//! Words of a picture, set by egui: in a window, and on a canvas without one.

use bksim_scene::{Align, Color, Item};
use egui::{Color32, FontId, Painter, Pos2, Vec2};

/// Paints the words among `items`, whose positions are relative to `origin`, in points.
pub fn paint_words(painter: &Painter, origin: Pos2, items: &[Item]) {
    for item in items {
        let Item::Text { at, align, text, size, color } = item else { continue };
        let color = color32(*color);
        let galley = painter.layout_no_wrap(text.clone(), FontId::proportional(*size), color);
        // The baseline of the first letter; a text without letters has none, and paints nothing.
        let first = galley.rows.first().and_then(|row| Some((row, row.glyphs.first()?)));
        let baseline = first.map_or(0.0, |(row, glyph)| row.pos.y + glyph.pos.y);
        let left = match align {
            Align::Start => 0.0,
            Align::Middle => 0.5 * galley.size().x,
            Align::End => galley.size().x,
        };
        let corner = origin + Vec2::from(*at) - Vec2::new(left, baseline);
        painter.galley(corner, galley, color);
    }
}

/// A colour in the type of egui.
pub fn color32(Color([r, g, b, a]): Color) -> Color32 {
    Color32::from_rgba_unmultiplied(r, g, b, a)
}
