//! Places for names, where they hide neither lines nor each other.

/// A box: left, top, right, bottom.
type Area = [f32; 4];

/// Width of a letter against its height, on the safe side.
const LETTER: f32 = 0.62;
/// Distances from a point or a line that are tried, in heights of letters.
const GAPS: [f32; 5] = [0.35, 0.7, 1.2, 2.0, 3.0];

/// Names that are placed one after the other.
pub(super) struct Labels {
    area: Area,
    text: f32,
    lines: Vec<[[f32; 2]; 2]>,
    taken: Vec<Area>,
}

impl Labels {
    /// No names yet, in an area with these lines.
    pub(super) fn new(area: Area, text: f32, lines: Vec<[[f32; 2]; 2]>) -> Self {
        Self { area, text, lines, taken: Vec::new() }
    }

    /// Keeps a point free.
    pub(super) fn keep_free(&mut self, [x, y]: [f32; 2]) {
        let half = 0.25 * self.text;
        self.taken.push([x - half, y - half, x + half, y + half]);
    }

    /// The place of a name next to a point: the begin of its base line.
    pub(super) fn beside(&mut self, [x, y]: [f32; 2], text: &str) -> Option<[f32; 2]> {
        let [width, height] = self.extent(text);
        let around = |gap: f32| {
            (0..16_u8).map(move |k| {
                // From the upper right, round both ways.
                let turn = f32::from(k.div_ceil(2)) * if k % 2 == 0 { 1.0 } else { -1.0 };
                let (sin, cos) = (0.8 + turn * std::f32::consts::TAU / 16.0).sin_cos();
                let centre = [x + cos * (gap + 0.5 * width), y - sin * (gap + 0.5 * height)];
                [centre[0] - 0.5 * width, centre[1] - 0.5 * height]
            })
        };
        let gaps = GAPS.map(|gap| gap * self.text);
        self.first_free(gaps.into_iter().flat_map(around).collect(), [width, height])
    }

    /// The place of a name next to a line.
    pub(super) fn along(&mut self, [a, b]: [[f32; 2]; 2], text: &str) -> Option<[f32; 2]> {
        let [width, height] = self.extent(text);
        let long = (b[0] - a[0]).hypot(b[1] - a[1]);
        if long == 0.0 {
            return None;
        }
        let normal = [-(b[1] - a[1]) / long, (b[0] - a[0]) / long];
        // As far aside as the box needs in that direction.
        let half = 0.5 * (width * normal[0].abs() + height * normal[1].abs());
        let mut corners = Vec::new();
        for gap in GAPS.into_iter().take(3) {
            for share in [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8] {
                for side in [1.0, -1.0] {
                    let aside = side * (half + gap * 0.6 * self.text);
                    let centre = [0, 1].map(|i| a[i] + share * (b[i] - a[i]) + aside * normal[i]);
                    corners.push([centre[0] - 0.5 * width, centre[1] - 0.5 * height]);
                }
            }
        }
        self.first_free(corners, [width, height])
    }

    fn extent(&self, text: &str) -> [f32; 2] {
        [text.chars().count() as f32 * LETTER * self.text, 1.15 * self.text]
    }

    fn first_free(
        &mut self,
        corners: Vec<[f32; 2]>,
        [width, height]: [f32; 2],
    ) -> Option<[f32; 2]> {
        let boxes = corners.into_iter().map(|[x, y]| [x, y, x + width, y + height]);
        let area = boxes.into_iter().find(|area| self.is_free(area))?;
        self.taken.push(area);
        Some([area[0], area[3] - 0.28 * self.text])
    }

    fn is_free(&self, area: &Area) -> bool {
        let is_inside = area[0] >= self.area[0]
            && area[1] >= self.area[1]
            && area[2] <= self.area[2]
            && area[3] <= self.area[3];
        is_inside
            && !self.taken.iter().any(|other| overlap(area, other))
            && !self.lines.iter().any(|line| passes(*line, area))
    }
}

fn overlap(a: &Area, b: &Area) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// True if a line between two points passes through a box: Liang and Barsky's clipping.
fn passes([a, b]: [[f32; 2]; 2], area: &Area) -> bool {
    let (mut low, mut high) = (0.0_f32, 1.0_f32);
    for i in 0..2 {
        let d = b[i] - a[i];
        let [near, far] = [area[i] - a[i], area[i + 2] - a[i]];
        if d == 0.0 {
            if near > 0.0 || far < 0.0 {
                return false;
            }
            continue;
        }
        let [s, t] = [near / d, far / d];
        low = low.max(s.min(t));
        high = high.min(s.max(t));
    }
    low <= high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_hide_neither_lines_nor_each_other() {
        let lines = vec![[[50.0, 50.0], [250.0, 150.0]], [[50.0, 50.0], [250.0, 50.0]]];
        let mut labels = Labels::new([0.0, 0.0, 300.0, 200.0], 13.0, lines.clone());
        for line in &lines {
            for text in ["v_B", "v_C/B", "a_C/B t"] {
                labels.along(*line, text);
            }
            labels.beside(line[1], "coupler.P");
        }
        assert!(labels.taken.len() >= 6, "{:?}", labels.taken);
        for (i, a) in labels.taken.iter().enumerate() {
            assert!(!lines.iter().any(|line| passes(*line, a)), "{a:?}");
            assert!(!labels.taken[..i].iter().any(|b| overlap(a, b)), "{a:?}");
        }
    }
}
