//! Loops of four parts in a planar linkage: four-bars and slider-cranks with their types.
//!
//! ```text
//! four-bar       s + l < p + q      Grashof: the shortest link turns against all others
//! slider-crank   s + e < l          the shorter of both links turns; e the offset of the guide
//! ```
//!
//! Source: F. Grashof, *Theoretische Maschinenlehre* II (1883); C. R. Barker, *A complete classification of planar four-bar
//! linkages*, Mech. Mach. Theory 20 (1985) 535; R. L. Norton, *Design of Machinery*, section 2.13 and table 2-4.

use bksim_model::Model;

use super::place::{dot, left, length, less};
use super::structure::{Pair, Structure, geometry};
use crate::error::AnalysisError;
use crate::positions::Positions;

/// True where the shortest link of a loop can turn all the way round.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rotatability {
    /// It can: s + l < p + q.
    Grashof,
    /// It can just so: in some pose all links are in line, and motions cross there.
    ChangePoint,
    /// No link can.
    NonGrashof,
}

/// A loop of four parts with four pins.
#[derive(Clone, PartialEq, Debug)]
pub struct FourBar {
    /// Names of the frame, the input, the coupler and the output; where none of them is the ground, the first in the file
    /// is the frame.
    pub parts: [String; 4],
    /// Names of the joints: frame–input, input–coupler, coupler–output, output–frame.
    pub joints: [String; 4],
    /// Lengths of frame, input, coupler and output, m.
    pub lengths: [f64; 4],
    /// p + q − s − l, m: how much is left until the linkage is another one.
    pub excess: f64,
    /// By the sign of the excess.
    pub rotatability: Rotatability,
    /// Type after Barker.
    pub barker: BarkerType,
}

/// A row of Barker's table.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BarkerType {
    /// From 1 to 14.
    pub number: usize,
    /// `GCRR`.
    pub code: &'static str,
    /// `crank-rocker`.
    pub name: &'static str,
}

/// A loop of four parts with three pins and a guide.
#[derive(Clone, PartialEq, Debug)]
pub struct SliderCrank {
    /// Names of both parts with pins alone, the one that is pinned to the guide's second part first, then of both parts
    /// that slide on each other.
    pub parts: [String; 4],
    /// Names of the joints: between the links, from the second link to the first sliding part, the guide, from the second
    /// sliding part to the first link.
    pub joints: [String; 4],
    /// Lengths of both links, m.
    pub lengths: [f64; 2],
    /// Distance of both pins on the sliding parts across the guide, m.
    pub offset: f64,
    /// l − s − e, m.
    pub excess: f64,
    /// By the sign of the excess.
    pub rotatability: Rotatability,
    /// The name of its inversion, by the part that is the ground: `slider-crank`.
    pub inversion: &'static str,
    /// The link that turns all the way round against both sliding parts, if one does.
    pub turning: Option<String>,
}

/// Lengths that differ by less than this share of the longest are equal.
const EQUAL: f64 = 1e-9;

const BARKER: [BarkerType; 14] = {
    const fn row(number: usize, code: &'static str, name: &'static str) -> BarkerType {
        BarkerType { number, code, name }
    }
    [
        row(1, "GCCC", "double-crank"),
        row(2, "GCRR", "crank-rocker"),
        row(3, "GRCR", "double-rocker"),
        row(4, "GRRC", "rocker-crank"),
        row(5, "RRR1", "triple-rocker"),
        row(6, "RRR2", "triple-rocker"),
        row(7, "RRR3", "triple-rocker"),
        row(8, "RRR4", "triple-rocker"),
        row(9, "SCCC", "change-point double-crank"),
        row(10, "SCRR", "change-point crank-rocker"),
        row(11, "SRCR", "change-point double-rocker"),
        row(12, "SRRC", "change-point rocker-crank"),
        row(13, "S2X", "parallelogram or deltoid"),
        row(14, "S3X", "square"),
    ]
};

/// All four-bars and slider-cranks of a planar mechanism of pins, guides and links, drives released.
pub(crate) fn four_bars(
    positions: &Positions,
) -> Result<(Vec<FourBar>, Vec<SliderCrank>), AnalysisError> {
    let (model, size) = (positions.model(), positions.size);
    let Some(geometry) = geometry(positions)? else { return Ok(Default::default()) };
    let Some(structure) = Structure::holding(model, &geometry, &[], size) else {
        return Ok(Default::default());
    };
    let loops = Loops { model, structure: &structure };
    let (mut four_bars, mut slider_cranks) = (Vec::new(), Vec::new());
    for (parts, pairs) in loops.of_four() {
        let n_slides = pairs.iter().filter(|pair| matches!(pair, Pair::Slide(_))).count();
        match n_slides {
            0 => four_bars.extend(loops.four_bar(parts, pairs)),
            1 => slider_cranks.extend(loops.slider_crank(parts, pairs)),
            _ => {}
        }
    }
    Ok((four_bars, slider_cranks))
}

/// Parts in a loop, and the pair after each.
type Loop = ([usize; 4], [Pair; 4]);

struct Loops<'a> {
    model: &'a Model,
    structure: &'a Structure,
}

impl Loops<'_> {
    /// Each loop once: it begins at the part with the smallest number, and goes on to the smaller neighbour.
    fn of_four(&self) -> Vec<Loop> {
        let mut neighbours: Vec<Vec<(usize, Pair)>> = vec![Vec::new(); self.structure.n_parts];
        for (k, pin) in self.structure.pins.iter().enumerate() {
            let parts = || pin.on.iter().map(|(part, _)| *part);
            for a in parts() {
                neighbours[a].extend(parts().filter(|b| *b != a).map(|b| (b, Pair::Pin(k))));
            }
        }
        for (k, slide) in self.structure.slides.iter().enumerate() {
            let [a, b] = slide.parts;
            neighbours[a].push((b, Pair::Slide(k)));
            neighbours[b].push((a, Pair::Slide(k)));
        }
        let mut found: Vec<Loop> = Vec::new();
        for a in 0..neighbours.len() {
            for &(b, ab) in neighbours[a].iter().filter(|(b, _)| *b > a) {
                for &(c, bc) in neighbours[b].iter().filter(|(c, _)| *c > a) {
                    for &(d, cd) in neighbours[c].iter().filter(|(d, _)| *d > b) {
                        let ends = neighbours[d].iter().filter(|(end, _)| *end == a);
                        for &(_, da) in ends {
                            let pairs = [ab, bc, cd, da];
                            let differ = (0..4).all(|i| (0..i).all(|j| pairs[i] != pairs[j]));
                            if differ && b != c && c != d {
                                found.push(([a, b, c, d], pairs));
                            }
                        }
                    }
                }
            }
        }
        found
    }

    fn pin(&self, pair: Pair, part: usize) -> [f64; 2] {
        match pair {
            Pair::Pin(pin) => self.structure.point(pin, part),
            Pair::Slide(_) => [f64::NAN; 2],
        }
    }

    /// Position of a pair in the file, a driven joint before all others.
    fn rank(&self, pair: Pair) -> (bool, usize) {
        let name = self.structure.joint_name(self.model, pair);
        let place = self.model.joints.iter().position(|joint| joint.name == name);
        let is_driven = self.model.drives.iter().any(|drive| Some(drive.joint.0) == place);
        (!is_driven, place.unwrap_or(usize::MAX))
    }

    fn four_bar(&self, parts: [usize; 4], pairs: [Pair; 4]) -> Option<FourBar> {
        // The frame first, then the side whose joint is driven, or else the first in the file.
        let (mut parts, mut pairs) = turned_to_ground(self.structure, parts, pairs);
        if self.rank(pairs[3]) < self.rank(pairs[0]) {
            (parts, pairs) = reversed(parts, pairs);
        }
        let side = |k: usize| {
            let [before, after] = [pairs[(k + 3) % 4], pairs[k]];
            length(less(self.pin(after, parts[k]), self.pin(before, parts[k])))
        };
        let lengths = [0, 1, 2, 3].map(side);
        let longest = lengths.into_iter().fold(0.0, f64::max);
        // Pins in one place make no link.
        if lengths.iter().any(|l| l.is_nan() || *l < EQUAL * longest) {
            return None;
        }
        let (excess, rotatability, barker) = classified(lengths);
        Some(FourBar {
            parts: parts.map(|part| self.structure.name(self.model, part)),
            joints: pairs.map(|pair| self.structure.joint_name(self.model, pair)),
            lengths,
            excess,
            rotatability,
            barker,
        })
    }

    fn slider_crank(&self, parts: [usize; 4], pairs: [Pair; 4]) -> Option<SliderCrank> {
        // Turned so that the guide is the third pair: links, then the parts that slide.
        let (mut parts, mut pairs) = (parts, pairs);
        while !matches!(pairs[2], Pair::Slide(_)) {
            parts.rotate_left(1);
            pairs.rotate_left(1);
        }
        let ground = self.structure.part_of_body[0];
        // The guide that stands is the last part.
        if parts[2] == ground || (parts[3] != ground && parts[1] == ground) {
            (parts, pairs) =
                ([1, 0, 3, 2].map(|k| parts[k]), [pairs[0], pairs[3], pairs[2], pairs[1]]);
        }
        let Pair::Slide(slide) = pairs[2] else { return None };
        let a = length(less(self.pin(pairs[0], parts[0]), self.pin(pairs[3], parts[0])));
        let b = length(less(self.pin(pairs[1], parts[1]), self.pin(pairs[0], parts[1])));
        let way = less(self.pin(pairs[1], parts[2]), self.pin(pairs[3], parts[3]));
        let offset = dot(left(self.structure.slides[slide].axis), way).abs();
        let size = a.max(b);
        // What is left by rounding is none.
        let offset = if offset <= EQUAL * size { 0.0 } else { offset };
        if !(a.min(b) > EQUAL * size && offset.is_finite()) {
            return None;
        }
        let excess = (a - b).abs() - offset;
        let rotatability = rotatability(excess, size);
        let name = |part: usize| self.structure.name(self.model, part);
        let turning = (rotatability != Rotatability::NonGrashof)
            .then(|| if a < b { name(parts[0]) } else { name(parts[1]) });
        let inversion = match parts.iter().position(|part| *part == ground) {
            Some(2 | 3) => "slider-crank",
            Some(_) if rotatability == Rotatability::NonGrashof => "inverted slider-crank",
            // The shortest link stands: both that are pinned to it turn.
            Some(k) if (k == 0) == (a < b) => "inverted slider-crank, turning guide",
            Some(_) => "inverted slider-crank, swinging guide",
            None => "slider-crank between moving parts",
        };
        Some(SliderCrank {
            parts: parts.map(name),
            joints: pairs.map(|pair| self.structure.joint_name(self.model, pair)),
            lengths: [a, b],
            offset,
            excess,
            rotatability,
            inversion,
            turning,
        })
    }
}

/// The loop from the ground on, if that is a part of it.
fn turned_to_ground(
    structure: &Structure,
    mut parts: [usize; 4],
    mut pairs: [Pair; 4],
) -> ([usize; 4], [Pair; 4]) {
    let ground = structure.part_of_body[0];
    let first = parts.iter().position(|part| *part == ground).unwrap_or(0);
    parts.rotate_left(first);
    pairs.rotate_left(first);
    (parts, pairs)
}

/// The loop the other way round, from the same part.
fn reversed(parts: [usize; 4], pairs: [Pair; 4]) -> ([usize; 4], [Pair; 4]) {
    ([0, 3, 2, 1].map(|k| parts[k]), [3, 2, 1, 0].map(|k| pairs[k]))
}

fn rotatability(excess: f64, size: f64) -> Rotatability {
    if excess.abs() < EQUAL * size {
        Rotatability::ChangePoint
    } else if excess > 0.0 {
        Rotatability::Grashof
    } else {
        Rotatability::NonGrashof
    }
}

/// Excess and type of a four-bar of these lengths: frame, input, coupler, output.
fn classified(lengths: [f64; 4]) -> (f64, Rotatability, BarkerType) {
    let mut order = [0, 1, 2, 3];
    order.sort_by(|&a, &b| lengths[a].total_cmp(&lengths[b]));
    let [shortest, second, third, longest] = order;
    let of = |k: usize| lengths[k];
    let excess = of(second) + of(third) - of(shortest) - of(longest);
    let rotatability = rotatability(excess, of(longest));
    let are_equal = |a: usize, b: usize| (of(a) - of(b)).abs() < EQUAL * of(longest);
    let row = match rotatability {
        Rotatability::Grashof => shortest,
        Rotatability::NonGrashof => 4 + longest,
        Rotatability::ChangePoint if are_equal(shortest, longest) => 13,
        Rotatability::ChangePoint if are_equal(shortest, second) && are_equal(third, longest) => 12,
        Rotatability::ChangePoint => 8 + shortest,
    };
    (excess, rotatability, BARKER[row])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Types against the definition itself: a link turns against its neighbour if, at every angle between them, the other
    /// two can close.
    #[test]
    fn types_are_those_of_the_links_that_turn() {
        let turns = |a: f64, b: f64, c: f64, d: f64| {
            (0..3600).all(|k| {
                let angle = f64::from(k) * std::f64::consts::TAU / 3600.0;
                let gap = (a * a + b * b - 2.0 * a * b * angle.cos()).max(0.0).sqrt();
                gap <= c + d && gap >= (c - d).abs()
            })
        };
        let mut counts = [0; 8];
        for k in 0..4096u32 {
            let length = |shift: u32| 1.0 + f64::from((k >> shift) & 7) + 0.01 * f64::from(shift);
            let lengths @ [r1, r2, r3, r4] = [0, 3, 6, 9].map(length);
            let longest = lengths.into_iter().fold(0.0, f64::max);
            if 2.0 * longest >= r1 + r2 + r3 + r4 {
                continue;
            }
            let (_, rotatability, barker) = classified(lengths);
            if rotatability == Rotatability::ChangePoint {
                continue;
            }
            // Input and output against the frame, and the coupler against the input.
            let found = [turns(r1, r2, r3, r4), turns(r2, r3, r4, r1), turns(r1, r4, r2, r3)];
            let expected = match barker.code {
                "GCCC" => [true, false, true],
                "GCRR" => [true, true, false],
                "GRCR" => [false, true, false],
                "GRRC" => [false, false, true],
                _ => [false; 3],
            };
            assert_eq!(found, expected, "{lengths:?} {barker:?}");
            counts[barker.number - 1] += 1;
        }
        assert!(counts.iter().all(|n| *n > 10), "{counts:?}");
    }
}
