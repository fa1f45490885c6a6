//! Positions of names around their points, where they hide neither each other nor an arrow.

use crate::{Align, Color, Item, Stroke};

/// Width of a letter against its height, on average over the letters of usual names.
const LETTER: f32 = 0.58;
/// With more names than this, all stand at the upper right of their points.
const MANY: usize = 300;

/// A box: left, top, right, bottom.
type Area = [f32; 4];

/// A name to be placed.
pub(crate) struct Label {
    /// The named point, pixels.
    pub(crate) at: [f32; 2],
    pub(crate) text: String,
}

/// Distances from their point at which names are tried, in gaps; from those that are far a line leads to the point.
const REACH: [f32; 4] = [1.0, 2.6, 4.4, 6.5];
/// Cost of a step farther away, in squares of letters.
const FARTHER: f32 = 0.6;

/// Places names, each at the best of eight positions around its point, or farther away where these are taken.
pub(crate) struct Labels<'a> {
    /// Size of the picture, pixels.
    pub(crate) size: [f32; 2],
    /// Height of letters, pixels.
    pub(crate) text: f32,
    pub(crate) color: Color,
    /// Distance of a name from its point, pixels.
    pub(crate) gap: f32,
    /// Points along arrows, which should stay free.
    pub(crate) taken: &'a [[f32; 2]],
}

impl Labels<'_> {
    /// The names as items, in the order given.
    pub(crate) fn place(&self, labels: Vec<Label>) -> Vec<Item> {
        let points: Vec<[f32; 2]> = labels.iter().map(|label| label.at).collect();
        let mut placed: Vec<Area> = Vec::new();
        let mut items = Vec::new();
        for label in labels {
            let n_letters = label.text.chars().count() as f32;
            let extent = [n_letters * LETTER * self.text, 1.1 * self.text];
            let candidates = self.candidates(label.at, extent);
            let crowding = |area: &Area| -> f32 {
                // Farther away is better than over another name, however little of it.
                let hidden = |other: &Area| {
                    let both = shared(area, other);
                    if both > 0.0 { both + 2.0 * self.text * self.text } else { 0.0 }
                };
                let names: f32 = placed.iter().map(hidden).sum();
                let hides = |p: &&[f32; 2]| is_inside(**p, area);
                let arrows = self.taken.iter().filter(hides).count() as f32;
                let pins = points.iter().filter(hides).count() as f32;
                names + self.text * (3.0 * arrows + 2.0 * pins) + 5.0 * self.lost(area)
            };
            let (mut best, mut is_far) = (candidates[0], false);
            if points.len() <= MANY {
                let mut least = f32::INFINITY;
                for (place, area) in candidates.into_iter().enumerate() {
                    let steps = (place / 8) as f32;
                    let cost = crowding(&area) + FARTHER * steps * self.text * self.text;
                    // The first of equally good ones, for a picture that does not flicker.
                    if cost < least - 1.0 {
                        (best, least, is_far) = (area, cost, place >= 8);
                    }
                }
            }
            let area = self.within(best);
            if is_far {
                items.push(self.leader(label.at, &area));
            }
            placed.push(area);
            items.push(Item::Text {
                at: [area[0], area[3] - 0.28 * self.text],
                align: Align::Start,
                text: label.text,
                size: self.text,
                color: self.color,
            });
        }
        items
    }

    /// A line from a point towards its name.
    fn leader(&self, [x, y]: [f32; 2], area: &Area) -> Item {
        let end = [x.clamp(area[0], area[2]), y.clamp(area[1], area[3])];
        let long = (end[0] - x).hypot(end[1] - y).max(1.0);
        let off = (0.7 * self.gap / long).min(1.0);
        let from = [x + off * (end[0] - x), y + off * (end[1] - y)];
        let stroke = Stroke { color: self.color.with_opacity(0.55), width: 0.8 };
        Item::Line { points: vec![from, end], is_closed: false, stroke }
    }

    /// Boxes around a point, nearer ones first: each time upper right, then the other corners, then the sides.
    fn candidates(&self, at: [f32; 2], extent: [f32; 2]) -> Vec<Area> {
        REACH.iter().flat_map(|reach| Self::around(at, extent, reach * self.gap)).collect()
    }

    fn around([x, y]: [f32; 2], [width, height]: [f32; 2], side: f32) -> [Area; 8] {
        let gap = 0.75 * side;
        let area = |left: f32, top: f32| [left, top, left + width, top + height];
        let (middle, half) = (x - 0.5 * width, y - 0.5 * height);
        [
            area(x + gap, y - gap - height),
            area(x - gap - width, y - gap - height),
            area(x + gap, y + gap),
            area(x - gap - width, y + gap),
            area(x + side, half),
            area(x - side - width, half),
            area(middle, y - side - height),
            area(middle, y + side),
        ]
    }

    /// The area of a box that lies outside of the picture.
    fn lost(&self, area: &Area) -> f32 {
        let [width, height] = self.size;
        (area[2] - area[0]) * (area[3] - area[1]) - shared(area, &[0.0, 0.0, width, height])
    }

    /// The box moved into the picture.
    fn within(&self, [left, top, right, bottom]: Area) -> Area {
        let inwards = |low: f32, high: f32, size: f32| {
            let back = (size - high).min(0.0);
            back + (-(low + back)).max(0.0)
        };
        let dx = inwards(left, right, self.size[0]);
        let dy = inwards(top, bottom, self.size[1]);
        [left + dx, top + dy, right + dx, bottom + dy]
    }
}

fn is_inside([x, y]: [f32; 2], area: &Area) -> bool {
    x > area[0] && x < area[2] && y > area[1] && y < area[3]
}

/// Area that two boxes share.
fn shared(a: &Area, b: &Area) -> f32 {
    let width = a[2].min(b[2]) - a[0].max(b[0]);
    let height = a[3].min(b[3]) - a[1].max(b[1]);
    width.max(0.0) * height.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes(items: &[Item]) -> Vec<Area> {
        let area = |item: &Item| match item {
            Item::Text { at: [x, y], text, size, .. } => {
                let width = text.chars().count() as f32 * LETTER * size;
                let bottom = y + 0.28 * size;
                [*x, bottom - 1.1 * size, x + width, bottom]
            }
            _ => panic!("{item:?} is no text"),
        };
        items.iter().map(area).collect()
    }

    fn labels(taken: &[[f32; 2]]) -> Labels<'_> {
        let color = Color::opaque(0);
        Labels { size: [300.0, 200.0], text: 12.0, color, gap: 9.0, taken }
    }

    #[test]
    fn eight_names_of_one_point_do_not_overlap() {
        let label = |i: u8| Label { at: [150.0, 100.0], text: char::from(b'A' + i).to_string() };
        let placed = boxes(&labels(&[]).place((0..8).map(label).collect()));
        for (i, a) in placed.iter().enumerate() {
            for b in &placed[..i] {
                assert!(shared(a, b) < 1e-3, "{a:?} and {b:?}");
            }
        }
    }

    #[test]
    fn twenty_names_of_one_point_do_not_overlap() {
        let label = |i: u8| Label { at: [150.0, 100.0], text: format!("link{i}") };
        let items = labels(&[]).place((0..20).map(label).collect());
        let (lines, names): (Vec<Item>, Vec<Item>) =
            items.into_iter().partition(|item| matches!(item, Item::Line { .. }));
        assert!(!lines.is_empty(), "far names have lines");
        let placed = boxes(&names);
        for (i, a) in placed.iter().enumerate() {
            for b in &placed[..i] {
                assert!(shared(a, b) < 1.0, "{a:?} and {b:?}");
            }
        }
    }

    #[test]
    fn names_stay_in_the_picture_and_off_the_arrows() {
        let arrow: Vec<[f32; 2]> = (1_u8..20).map(|i| [f32::from(i) * 3.0, 90.0]).collect();
        let at = [[0.0, 100.0], [299.0, 1.0], [150.0, 250.0], [f32::NAN, 3.0]];
        let label = |at| Label { at, text: "coupler.P".into() };
        let mut items = labels(&arrow).place(at.into_iter().map(label).collect());
        items.retain(|item| matches!(item, Item::Text { .. }));
        let placed = boxes(&items);
        for area in placed.iter().take(3) {
            assert!(area[0] >= 0.0 && area[1] >= -1e-3 && area[2] <= 300.0 && area[3] <= 200.001);
            assert!(!arrow.iter().any(|&p| is_inside(p, area)), "{area:?}");
        }
    }
}
