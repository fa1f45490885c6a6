//! Surroundings of a mechanism on its sheet: frame, title block, dimensions as lines and arrows, and the scale.

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{between, cross, distance, dot, sub};
use bksim_cad::read::{Sheet, number_in};

use super::pieces::{Pieces, is_inside, skew, to_segment, turned};

/// A measured length and the number that the drawing shows for it.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    pub(super) measured: f64,
    pub(super) shown: f64,
}

/// Notes of the sheet besides the mechanism.
#[derive(Clone, Default, Debug)]
pub(super) struct Notes {
    pub(super) lengths: Vec<Shown>,
    /// Drawn to true size as the title block has it, `0.5` for 1:2, with the text's index.
    pub(super) stated_scale: Option<(f64, usize)>,
    /// Texts that are part of the sheet or of dimensions.
    pub(super) taken: Vec<bool>,
    /// Strokes of frame, title block and dimensions.
    pub(super) frame: Vec<usize>,
    pub(super) dimensions: Vec<usize>,
}

impl Notes {
    pub(super) fn of(sheet: &Sheet, pieces: &mut Pieces, pins: &[Point]) -> Self {
        let mut notes = Self { taken: vec![false; sheet.words.len()], ..Self::default() };
        for length in &sheet.lengths {
            notes.lengths.push(Shown { measured: length.measured, shown: length.shown });
        }
        notes.take_dimensions(sheet, pieces);
        notes.take_frames(sheet, pieces, pins);
        for (idx, words) in sheet.words.iter().enumerate() {
            if let Some(scale) = scale_in(&words.text)
                && (notes.stated_scale.is_none() || notes.taken[idx])
            {
                notes.stated_scale = Some((scale, idx));
                notes.taken[idx] = true;
            }
        }
        notes
    }

    /// The ratio of shown to measured lengths that most dimensions agree on.
    pub(super) fn ratio(&self) -> Option<f64> {
        let ratios: Vec<f64> = self
            .lengths
            .iter()
            .filter(|it| it.measured > 0.0 && it.shown > 0.0)
            .map(|it| it.shown / it.measured)
            .collect();
        // Texts are rounded to the digits they show: two of a hundred is within all rounding.
        let agree =
            |ratio: f64| ratios.iter().filter(|other| (*other / ratio - 1.0).abs() < 0.02).count();
        let best = ratios.iter().copied().max_by_key(|ratio| agree(*ratio))?;
        let near: Vec<f64> =
            ratios.iter().copied().filter(|r| (r / best - 1.0).abs() < 0.02).collect();
        Some(near.iter().sum::<f64>() / near.len() as f64)
    }

    /// Dimensions that are lines with two arrows and a number.
    fn take_dimensions(&mut self, sheet: &Sheet, pieces: &mut Pieces) {
        let tips = arrow_tips(sheet, pieces.pin);
        let near = 0.5 * pieces.tolerance;
        for idx in 0..pieces.lines.len() {
            let ends = pieces.lines[idx].ends;
            let is_tip = |p: Point| tips.iter().any(|(tip, _)| distance(*tip, p) < near);
            if !is_tip(ends[0]) && !is_tip(ends[1]) {
                continue;
            }
            pieces.lines[idx].is_used = true;
            self.dimensions.extend(pieces.lines[idx].from.clone());
            if !(is_tip(ends[0]) && is_tip(ends[1])) {
                continue;
            }
            self.take_number(sheet, ends);
            let direction = pieces.lines[idx].direction();
            let overshoot = tips.iter().map(|(_, length)| *length).fold(0.0, f64::max) * 1.5;
            for line in pieces.lines.iter_mut().filter(|line| !line.is_used) {
                let is_extension = |end: Point| {
                    to_segment(end, line.ends) < near
                        && line.ends.iter().any(|p| distance(*p, end) < overshoot)
                        && skew(line.direction(), direction) > 0.5
                };
                if ends.iter().any(|end| is_extension(*end)) {
                    line.is_used = true;
                    self.dimensions.extend(line.from.clone());
                }
            }
        }
    }

    fn take_number(&mut self, sheet: &Sheet, ends: [Point; 2]) {
        let middle = between(ends[0], ends[1], 0.5);
        let numbers = sheet.words.iter().enumerate().filter_map(|(idx, words)| {
            let shown = number_in(&words.text)?;
            let away = distance(words.at, middle);
            (!self.taken[idx] && away < 4.0 * words.height + 0.25 * distance(ends[0], ends[1]))
                .then_some((away, idx, shown))
        });
        if let Some((_, idx, shown)) = numbers.min_by(|a, b| a.0.total_cmp(&b.0)) {
            self.taken[idx] = true;
            self.lengths.push(Shown { measured: distance(ends[0], ends[1]), shown });
        }
    }

    /// Frames around all pins, and tables: straight lines in two directions that touch each other.
    fn take_frames(&mut self, sheet: &Sheet, pieces: &mut Pieces, pins: &[Point]) {
        self.take_drawn_frames(sheet, pieces, pins);
        let groups = touching(pieces);
        for group in groups {
            let first = pieces.lines[group[0]].direction();
            let is_square = group.iter().all(|&idx| {
                let across = skew(first, pieces.lines[idx].direction());
                !(0.02..=0.9998).contains(&across)
            });
            if !is_square || group.len() < 4 {
                continue;
            }
            let axes = [first, turned(first)];
            let bounds = axes.map(|axis| {
                let places = group.iter().flat_map(|&idx| pieces.lines[idx].ends);
                let places = places.map(|p| dot(p, axis));
                places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                    [low.min(x), high.max(x)]
                })
            });
            let holds =
                |p: Point| (0..2).all(|k| (bounds[k][0]..=bounds[k][1]).contains(&dot(p, axes[k])));
            let encloses = pins.len() > 1 && pins.iter().all(|pin| holds(*pin));
            let words = sheet.words.iter().enumerate().filter(|(_, words)| holds(words.at));
            let inside: Vec<usize> = words.map(|(idx, _)| idx).collect();
            let is_table =
                inside.len() >= 2 && !pins.iter().any(|pin| holds(*pin)) && group.len() >= 5;
            if !encloses && !is_table {
                continue;
            }
            for &idx in &group {
                pieces.lines[idx].is_used = true;
                self.frame.extend(pieces.lines[idx].from.clone());
            }
            // In a frame, the words that are boxed in by its inner lines are those of the title block.
            for idx in inside {
                if is_table || is_boxed(sheet.words[idx].at, pieces, &group) {
                    self.taken[idx] = true;
                }
            }
        }
    }

    fn take_drawn_frames(&mut self, sheet: &Sheet, pieces: &mut Pieces, pins: &[Point]) {
        for ring in pieces.rings.iter_mut().filter(|ring| ring.arcs.is_empty()) {
            let encloses = pins.len() > 1 && pins.iter().all(|pin| is_inside(&ring.points, *pin));
            let has_words =
                sheet.words.iter().filter(|it| is_inside(&ring.points, it.at)).count() >= 2;
            let is_cell = has_words && !pins.iter().any(|pin| is_inside(&ring.points, *pin));
            if ring.sides.len() == 4 && (encloses || is_cell) {
                ring.is_used = true;
                self.frame.extend(ring.from.clone());
                if is_cell {
                    for (idx, words) in sheet.words.iter().enumerate() {
                        self.taken[idx] |= is_inside(&ring.points, words.at);
                    }
                }
            }
        }
    }
}

/// True if lines of the group other than the outermost ones are close on several sides.
fn is_boxed(p: Point, pieces: &Pieces, group: &[usize]) -> bool {
    let reach = 12.0 * pieces.pin;
    let near = group.iter().filter(|&&idx| {
        let line = &pieces.lines[idx];
        let d = line.direction();
        let along = dot(sub(p, line.ends[0]), d);
        (0.0..=line.length()).contains(&along) && cross(d, sub(p, line.ends[0])).abs() < reach
    });
    near.count() >= 2
}

/// Groups of lines that touch each other, directly or by others.
fn touching(pieces: &Pieces) -> Vec<Vec<usize>> {
    let free: Vec<usize> =
        (0..pieces.lines.len()).filter(|&idx| !pieces.lines[idx].is_used).collect();
    let near = 0.3 * pieces.tolerance;
    let mut group_of: Vec<usize> = (0..free.len()).collect();
    for i in 0..free.len() {
        for k in 0..i {
            let (first, second) = (&pieces.lines[free[i]], &pieces.lines[free[k]]);
            let touches = first.ends.iter().any(|end| second.away(*end) < near)
                || second.ends.iter().any(|end| first.away(*end) < near);
            if touches && group_of[i] != group_of[k] {
                let (from, to) = (group_of[i], group_of[k]);
                for group in &mut group_of {
                    if *group == from {
                        *group = to;
                    }
                }
            }
        }
    }
    let mut groups: std::collections::BTreeMap<usize, Vec<usize>> =
        std::collections::BTreeMap::new();
    for (n, group) in group_of.into_iter().enumerate() {
        groups.entry(group).or_default().push(free[n]);
    }
    groups.into_values().collect()
}

/// Points of filled triangles that are arrow heads, with their lengths.
pub(super) fn arrow_tips(sheet: &Sheet, pin: f64) -> Vec<(Point, f64)> {
    let mut tips = Vec::new();
    for fill in sheet.fills.iter().filter(|fill| !fill.has_pattern) {
        for border in &fill.borders {
            let mut corners: Vec<Point> = Vec::new();
            for curve in &border.curves {
                let p = curve.start_point();
                if !corners.iter().any(|known| distance(*known, p) < 1e-9) {
                    corners.push(p);
                }
            }
            let [a, b, c] = corners[..] else { continue };
            let sides = [(distance(b, c), a), (distance(c, a), b), (distance(a, b), c)];
            let shortest = sides.iter().min_by(|p, q| p.0.total_cmp(&q.0));
            let longest = sides.iter().map(|side| side.0).fold(0.0, f64::max);
            if let Some((base, tip)) = shortest
                && longest < 4.0 * pin
                && *base < 0.8 * longest
            {
                tips.push((*tip, longest));
            }
        }
    }
    tips
}

/// The scale in a text, such as `SCALE 1:2`; a count of sheets has another sign between its numbers.
fn scale_in(text: &str) -> Option<f64> {
    for (colon, _) in text.match_indices(':') {
        let before: String = text[..colon]
            .trim_end()
            .chars()
            .rev()
            .take_while(|c| c.is_ascii_digit() || *c == '.')
            .collect();
        let before: String = before.chars().rev().collect();
        let after: String = text[colon + 1..]
            .trim_start()
            .chars()
            .take_while(|c| c.is_ascii_digit() || *c == '.')
            .collect();
        if let (Ok(drawn), Ok(real)) = (before.parse::<f64>(), after.parse::<f64>())
            && drawn > 0.0
            && real > 0.0
            // Clock times have two digits after the colon.
            && !(after.len() == 2 && after.starts_with('0'))
        {
            return Some(drawn / real);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::scale_in;

    #[test]
    fn scales_are_read_and_sheets_are_not() {
        assert_eq!(scale_in("MASSSTAB 1:2"), Some(0.5));
        assert_eq!(scale_in("Échelle 5 : 1"), Some(5.0));
        assert_eq!(scale_in("SHEET 1/1"), None);
        assert_eq!(scale_in("DATE 12.03"), None);
    }
}
