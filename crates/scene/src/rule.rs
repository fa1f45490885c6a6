//! Size and direction of the view: a bar of a round length, and the axes of the world.

use crate::{Align, Camera, Item, Stroke, Theme};

/// Distance from the edges of the picture, pixels.
const EDGE: f32 = 14.0;
/// Length of an axis that lies in the picture, pixels.
const AXIS: f64 = 34.0;

/// A bar of a round length, about a fifth of the picture wide, in its lower left corner.
pub fn scale_bar(camera: &Camera, theme: &Theme) -> Vec<Item> {
    let longest = 0.22 * camera.size[0] / camera.scale;
    let Some((length, text)) = round_length(longest) else { return Vec::new() };
    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    let (width, bottom) = ((length * camera.scale) as f32, camera.size[1] as f32 - EDGE);
    let stroke = Stroke { color: theme.faint, width: 1.5 * theme.sizes.lines };
    let tick = 4.0;
    let points = vec![
        [EDGE, bottom - tick],
        [EDGE, bottom],
        [EDGE + width, bottom],
        [EDGE + width, bottom - tick],
    ];
    vec![
        Item::Line { points, is_closed: false, stroke },
        Item::Text {
            at: [EDGE + 0.5 * width, bottom - 5.0],
            align: Align::Middle,
            text,
            size: 0.9 * theme.sizes.text,
            color: theme.faint,
        },
    ]
}

/// The axes of the world as the camera sees them, in the lower right corner; an axis along the view
/// is left out.
pub fn world_axes(camera: &Camera, theme: &Theme) -> Vec<Item> {
    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    let [right, bottom] = camera.size.map(|x| x as f32 - EDGE - 1.5 * AXIS as f32);
    let stroke = Stroke { color: theme.faint, width: 1.5 * theme.sizes.lines };
    let mut items = Vec::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let [x, y] = [camera.r_view_from_world[0][axis], -camera.r_view_from_world[1][axis]];
        if x.hypot(y) < 0.1 {
            continue;
        }
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let at = |length: f64| [right + (length * x) as f32, bottom + (length * y) as f32];
        items.push(Item::Line { points: vec![at(0.0), at(AXIS)], is_closed: false, stroke });
        let [tx, ty] = at(AXIS + 9.0);
        items.push(Item::Text {
            at: [tx, ty + 0.33 * theme.sizes.text],
            align: Align::Middle,
            text: name.into(),
            size: 0.9 * theme.sizes.text,
            color: theme.faint,
        });
    }
    items
}

/// The largest of 1, 2 and 5 times a power of ten that is at most `longest`, m, and its text.
fn round_length(longest: f64) -> Option<(f64, String)> {
    let power = longest.log10().floor();
    if !(-30.0..30.0).contains(&power) {
        return None;
    }
    let ten = 10f64.powf(power);
    let factor = [5.0, 2.0].into_iter().find(|f| f * ten <= longest).unwrap_or(1.0);
    let length = factor * ten;
    let units = [(1e3, "km"), (1.0, "m"), (1e-3, "mm"), (1e-6, "µm")];
    let unit = units.into_iter().find(|(size, _)| length >= 0.999 * size);
    let (size, name) = unit.unwrap_or((1.0, "m"));
    let number = length / size;
    // Digits beyond the first are rounding errors.
    let text = if (1e-3..1e4).contains(&number) {
        format!("{}", (number * 1e3).round() / 1e3)
    } else {
        format!("{number:.0e}")
    };
    Some((length, format!("{text} {name}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round_and_in_a_fitting_unit() {
        let words = |longest| round_length(longest).map(|(_, text)| text);
        assert_eq!(words(0.34).as_deref(), Some("200 mm"));
        assert_eq!(words(1.0).as_deref(), Some("1 m"));
        assert_eq!(words(7.9e3).as_deref(), Some("5 km"));
        assert_eq!(words(2.1e-5).as_deref(), Some("20 µm"));
        for nothing in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
            assert_eq!(words(nothing), None);
        }
    }
}
