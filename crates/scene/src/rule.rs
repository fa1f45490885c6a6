//! Size of the view: a bar of a round length, and arrows of the vectors of each kind; words around a mechanism.

use crate::vectors::ArrowKind;
use crate::{Align, Camera, Item, Stroke, Theme, Words};

/// Distance from the edges of the picture, pixels.
const EDGE: f32 = 14.0;

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

/// An arrow of a round size for each kind of arrow, above each other in the lower left corner.
pub(crate) fn arrow_legend(kinds: &[ArrowKind], camera: &Camera, theme: &Theme) -> Vec<Item> {
    let mut items = Vec::new();
    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    let mut y = camera.size[1] as f32 - EDGE;
    for kind in kinds {
        for (size, metres) in kind.scale.samples() {
            #[expect(clippy::cast_possible_truncation, reason = "pixels")]
            let width = (metres * camera.scale) as f32;
            let (tip, head) = (EDGE + width, theme.sizes.head.min(width));
            let stroke = Stroke { color: kind.color, width: theme.sizes.arrow };
            let points = vec![[EDGE, y], [tip - head, y]];
            items.push(Item::Line { points, is_closed: false, stroke });
            let half = 0.35 * head;
            let ring = vec![[tip, y], [tip - head, y - half], [tip - head, y + half]];
            items.push(Item::Region { rings: vec![ring], fill: kind.color });
            let text = format!("{} {}", kind.name, quantity(size, kind.unit));
            let at = [tip + 6.0, y + 0.33 * theme.sizes.text];
            let size = 0.9 * theme.sizes.text;
            items.push(Item::Text { at, align: Align::Start, text, size, color: kind.color });
            y -= 1.5 * theme.sizes.text;
        }
    }
    items
}

/// Title, instant and caption around a mechanism.
#[expect(clippy::cast_possible_truncation, reason = "pixels")]
pub(crate) fn written(words: &Words, camera: &Camera, theme: &Theme) -> Vec<Item> {
    let [width, height] = camera.size.map(|side| side as f32);
    let text = theme.sizes.text;
    let item = |at, align, text: &str, size| Item::Text {
        at,
        align,
        text: text.to_owned(),
        size,
        color: theme.text,
    };
    let (mut items, mut y) = (Vec::new(), EDGE);
    if !words.title.is_empty() {
        y += 1.3 * text;
        items.push(item([EDGE, y], Align::Start, &words.title, 1.3 * text));
    }
    if let Some(instant) = &words.instant {
        y += 1.4 * text;
        items.push(item([EDGE, y], Align::Start, instant, text));
    }
    if !words.caption.is_empty() {
        items.push(item([0.5 * width, height - EDGE], Align::Middle, &words.caption, text));
    }
    items
}

/// A size with the prefix of its unit that leaves few digits: `50 kN`, `0.2 m/s`.
fn quantity(size: f64, unit: &str) -> String {
    let prefixes = [(1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")];
    let fits = prefixes.into_iter().find(|(factor, _)| size >= 0.999 * factor);
    let (factor, prefix) = fits.filter(|_| unit == "N").unwrap_or((1.0, ""));
    // Digits beyond the first are rounding errors.
    let number = format!("{:.0e}", size / factor).parse::<f64>().unwrap_or(size / factor);
    format!("{number} {prefix}{unit}")
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
