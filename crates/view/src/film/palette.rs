//! [`Palette`]: the best 255 colours for some pictures.
//!
//! Pictures of mechanisms have a few flat colours and their mixtures at edges. So the colours that
//! fill most pixels are kept as they are, and the others are gathered by median cut: the box of
//! colours that spreads widest is halved at the median of its pixels (P. Heckbert, *Color image
//! quantization for frame buffer display*, SIGGRAPH 1982).

use std::collections::{BTreeMap, HashMap};

use crate::offscreen::Image;

/// Red, green, blue.
type Rgb = [u8; 3];

/// Number of colours of a palette; the last of 256 entries is transparent.
const N_COLORS: usize = 255;

/// Number of the most frequent colours, which are kept as they are.
const N_KEPT: usize = 32;

/// Numbers of pixels of each colour in some pictures.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Colors {
    counts: BTreeMap<Rgb, u64>,
}

impl Colors {
    /// Counts the pixels of another picture, except those that are more than half transparent.
    pub fn add(&mut self, image: &Image) {
        // Most pixels repeat the one before.
        let pixels: &[[u8; 4]] = image.rgba.as_chunks().0;
        for run in pixels.chunk_by(|a, b| a == b) {
            let [r, g, b, a] = run[0];
            if a >= 128 {
                *self.counts.entry([r, g, b]).or_default() += run.len() as u64;
            }
        }
    }
}

/// The colours of a GIF.
#[derive(Clone, Debug, Default)]
pub struct Palette {
    colors: Vec<Rgb>,
    /// Indices of colours that were looked up.
    known: HashMap<Rgb, u8>,
}

impl Palette {
    /// The index of transparent pixels.
    pub const TRANSPARENT: u8 = 255;

    /// The best palette for pictures with these colours.
    pub fn of(colors: Colors) -> Self {
        let counts = colors.counts;
        let mut counts: Vec<(Rgb, u64)> = counts.into_iter().collect();
        counts.sort_by_key(|&(color, count)| (std::cmp::Reverse(count), color));
        let mut colors: Vec<Rgb> = Vec::with_capacity(N_COLORS);
        if counts.len() <= N_COLORS {
            colors.extend(counts.iter().map(|&(color, _)| color));
        } else {
            let (kept, rest) = counts.split_at(N_KEPT);
            colors.extend(kept.iter().map(|&(color, _)| color));
            colors.extend(median_cut(rest.to_vec(), N_COLORS - N_KEPT));
        }
        if colors.is_empty() {
            colors.push([0; 3]);
        }
        Self { colors, known: HashMap::new() }
    }

    /// Red, green and blue of all colours, then black for the transparent entry.
    pub fn bytes(&self) -> Vec<u8> {
        let mut all = self.colors.clone();
        all.resize(N_COLORS + 1, [0; 3]);
        all.into_flattened()
    }

    /// The palette indices of all pixels of a picture.
    pub fn indices(&mut self, image: &Image) -> Vec<u8> {
        let pixels: &[[u8; 4]] = image.rgba.as_chunks().0;
        let mut indices = Vec::with_capacity(pixels.len());
        for run in pixels.chunk_by(|a, b| a == b) {
            indices.resize(indices.len() + run.len(), self.index(run[0]));
        }
        indices
    }

    /// The index of the nearest colour; the last for a pixel that is more than half transparent.
    fn index(&mut self, [r, g, b, a]: [u8; 4]) -> u8 {
        if a < 128 {
            return Self::TRANSPARENT;
        }
        let Self { colors, known } = self;
        *known.entry([r, g, b]).or_insert_with(|| nearest(colors, [r, g, b]))
    }
}

fn nearest(colors: &[Rgb], color: Rgb) -> u8 {
    let distance = |other: &Rgb| -> u32 {
        // The eye is most sensitive to green, least to blue.
        let weighted =
            |i: usize, weight: u32| weight * u32::from(other[i].abs_diff(color[i])).pow(2);
        weighted(0, 3) + weighted(1, 6) + weighted(2, 1)
    };
    let best = colors.iter().zip(0_u8..).min_by_key(|(other, _)| distance(other));
    best.map(|(_, idx)| idx).expect("a palette has at least one colour")
}

/// Gathers colours in at most `n` boxes; returns the mean of each.
fn median_cut(colors: Vec<(Rgb, u64)>, n: usize) -> Vec<Rgb> {
    let mut boxes = vec![colors];
    while boxes.len() < n {
        let spread = |colors: &Vec<(Rgb, u64)>| widest(colors).1;
        let divisible = boxes.iter().enumerate().filter(|(_, b)| b.len() > 1);
        let Some((idx, _)) = divisible.max_by_key(|(_, b)| spread(b)) else { break };
        let mut whole = boxes.swap_remove(idx);
        let (axis, _) = widest(&whole);
        whole.sort_by_key(|&(color, _)| (color[axis], color));
        let total: u64 = whole.iter().map(|(_, count)| count).sum();
        let mut below = 0;
        let mut before_half = |&(_, count): &(Rgb, u64)| {
            below += count;
            2 * below < total
        };
        let middle = whole.iter().take_while(|&color| before_half(color)).count();
        let upper = whole.split_off(middle.clamp(1, whole.len() - 1));
        boxes.extend([whole, upper]);
    }
    boxes.iter().filter(|colors| !colors.is_empty()).map(|colors| mean(colors)).collect()
}

/// The channel with the widest range of values, and that range.
fn widest(colors: &[(Rgb, u64)]) -> (usize, u8) {
    let range = |axis: usize| {
        let values = || colors.iter().map(|(color, _)| color[axis]);
        let ends = values().max().zip(values().min());
        ends.map_or(0, |(high, low)| high - low)
    };
    let ranges = (0..3).map(|axis| (axis, range(axis)));
    ranges.max_by_key(|&(_, range)| range).expect("there are three channels")
}

fn mean(colors: &[(Rgb, u64)]) -> Rgb {
    let total: u64 = colors.iter().map(|(_, count)| count).sum();
    std::array::from_fn(|axis| {
        let sum: u64 = colors.iter().map(|(color, count)| u64::from(color[axis]) * count).sum();
        u8::try_from((sum + total / 2) / total.max(1)).expect("a mean of bytes is a byte")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn palette(rgba: &[[u8; 4]]) -> Palette {
        let size = [u32::try_from(rgba.len()).expect("small"), 1];
        let mut colors = Colors::default();
        colors.add(&Image { size, rgba: rgba.as_flattened().to_vec() });
        Palette::of(colors)
    }

    #[test]
    fn few_colours_stay_as_they_are() {
        let colors = vec![[255, 255, 255, 255], [47, 111, 181, 255], [0, 0, 0, 0]];
        let mut palette = palette(&colors);
        let bytes = palette.bytes();
        for color in &colors[..2] {
            let first = 3 * usize::from(palette.index(*color));
            assert_eq!(bytes[first..first + 3], color[..3]);
        }
        assert_eq!(palette.index(colors[2]), Palette::TRANSPARENT);
    }

    #[test]
    fn many_colours_come_near() {
        let ramp = |i: u32| {
            let [_, r, g, b] = (i * 2654).to_be_bytes();
            [r, g, b, 255]
        };
        let colors: Vec<[u8; 4]> = (0..6000).map(ramp).collect();
        let mut palette = palette(&colors);
        let bytes = palette.bytes();
        let mut worst = 0;
        for color in colors {
            let first = 3 * usize::from(palette.index(color));
            let off = (0..3).map(|i| bytes[first + i].abs_diff(color[i])).max();
            worst = worst.max(off.expect("three channels"));
        }
        // 255 entries for 6000 colours spread over the whole cube.
        assert!(worst > 0 && worst < 64, "off by up to {worst}");
    }
}
