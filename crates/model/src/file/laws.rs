//! `[curves.…]`: laws of motion of cam followers as functions of an angle, called as tables are.
//!
//! A law goes through rises, returns and dwells one after the other. The normalised laws f(u), u and f in
//! 0 ..= 1, are those of R. L. Norton, *Cam Design and Manufacturing Handbook* (2009), chapters 2 to 4; all but
//! the polynomials are put together from their accelerations.

use std::f64::consts::PI;

use super::codes;
use super::pieces::{Columns, Piece};
use super::reader::{Fields, Reader};
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::{Kind, Scope};
use crate::curve::{CamLaw, LawSegment};
use crate::diagnostic::Diagnostic;
use crate::message::short;

/// Most turns that a law is written out for.
const MOST_TURNS: f64 = 1000.0;

/// A normalised law of motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Law {
    /// 10 u³ − 15 u⁴ + 6 u⁵.
    Polynomial345,
    /// 35 u⁴ − 84 u⁵ + 70 u⁶ − 20 u⁷.
    Polynomial4567,
    /// u − sin(2π u)/2π.
    Cycloidal,
    /// (1 − cos π u)/2.
    Harmonic,
    /// An acceleration of two sines of different lengths.
    ModifiedSine,
    /// An acceleration of quarter sines and constants.
    ModifiedTrapezoid,
}

/// The words for the laws.
const LAWS: [(&str, Law); 6] = [
    ("3-4-5", Law::Polynomial345),
    ("4-5-6-7", Law::Polynomial4567),
    ("cycloidal", Law::Cycloidal),
    ("harmonic", Law::Harmonic),
    ("modified-sine", Law::ModifiedSine),
    ("modified-trapezoid", Law::ModifiedTrapezoid),
];

/// A part of a law: a rise, a return below zero, or a dwell.
struct Segment {
    /// rad.
    over: f64,
    /// m or rad.
    rise: f64,
    law: Option<Law>,
    is_length: bool,
}

impl Reader<'_> {
    /// A law of motion, as a table of the angle.
    pub(super) fn read_law(&mut self, name: &str, fields: &Fields<'_>) -> Option<Columns> {
        let turns = match fields.get("turns") {
            Some(node) => {
                let what = fields.what("turns");
                let turns = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
                if !self.check_positive(&what, &turns, Quantity::NUMBER) {
                    return None;
                }
                let count = self.constants.pinned(turns.value?).ceil();
                if count > MOST_TURNS {
                    self.report(
                        Diagnostic::error(
                            codes::BAD_TABLE,
                            format!("{what} is {}, more than {MOST_TURNS}", short(count)),
                        )
                        .at(turns.span, "every turn is written out")
                        .help("write as many as the run needs"),
                    );
                    return None;
                }
                count
            }
            None => 1.0,
        };
        let help = "write for example `segments = [{ rise = \"20 mm\", over = \"120 deg\", law = \"3-4-5\" }, { dwell = \"240 deg\" }]`";
        let node = fields.require(self, "segments", help)?;
        let what = fields.what("segments");
        let example = "[{ rise = \"20 mm\", over = \"120 deg\", law = \"3-4-5\" }]";
        let nodes = self.array(node, &what, "an array of segments", example)?;
        let segments: Option<Vec<Segment>> = nodes
            .iter()
            .enumerate()
            .map(|(idx, node)| {
                self.read_segment(node, &format!("segment {} of {}", idx + 1, fields.owner))
            })
            .collect();
        let segments = segments?;
        if segments.iter().all(|segment| segment.law.is_none()) {
            self.report(
                Diagnostic::error(codes::BAD_TABLE, format!("{what} never move"))
                    .at(node.span.clone(), "needs a rise")
                    .help(help),
            );
            return None;
        }

        // One segment after the other, turn after turn.
        let mut pieces = Vec::new();
        let (mut at, mut height, mut turn) = (0.0, 0.0, 0.0);
        while turn < turns {
            for segment in &segments {
                match segment.law {
                    Some(law) => {
                        law.append(&mut pieces, (at, height), (segment.over, segment.rise));
                    }
                    None => pieces.push((at, Piece::polynomial(vec![height]))),
                }
                at += segment.over;
                height += segment.rise;
            }
            turn += 1.0;
        }
        let is_length = segments.iter().any(|segment| segment.is_length);
        let quantity = if is_length { Quantity::LENGTH } else { Quantity::ANGLE };
        let kinds = [Quantity::ANGLE, quantity].map(|of| Kind::Known(of.dimension()));
        let (mut x, pieces): (Vec<f64>, Vec<Piece>) = pieces.into_iter().unzip();
        x.push(at);
        let columns = Columns::new(kinds, [true, !is_length], x, pieces);

        // For those who ask about the law itself.
        let angle = self.pool.symbol(&format!("'angle {name}"));
        let function = self.function_of_columns(name, "theta", &columns);
        let lift = self.pool.apply(function, &[angle]);
        let angle = self.pool.symbol_id(angle).expect("a symbol was just made");
        let mut from = 0.0;
        let segments = segments.iter().map(|segment| {
            let of = |x: &&f64| (from..from + segment.over).contains(*x);
            let borders = columns.x.iter().filter(of).copied().collect();
            let word = |law: Law| LAWS.iter().find(|(_, of)| *of == law).map(|(word, _)| *word);
            let law = segment.law.and_then(word);
            let read = LawSegment { from, over: segment.over, rise: segment.rise, law, borders };
            from += segment.over;
            read
        });
        let segments = segments.collect();
        let name = name.to_owned();
        self.laws.push(CamLaw { name, angle, lift, is_angle: !is_length, segments });
        Some(columns)
    }

    fn read_segment(&mut self, node: &Node, what: &str) -> Option<Segment> {
        let Value::Table(table) = &node.value else {
            let help = "write for example { dwell = \"60 deg\" }";
            self.wrong_kind(node, what, "a table", &node.value, help);
            return None;
        };
        let span = node.span.clone();
        let keys = &["rise", "return", "dwell", "over", "law"];
        let fields = Fields::open(self, table, what.to_owned(), span, keys);
        let conflicts = [
            ("rise", "return"),
            ("rise", "dwell"),
            ("return", "dwell"),
            ("dwell", "over"),
            ("dwell", "law"),
        ];
        if conflicts.iter().any(|(one, other)| fields.conflict(self, one, other)) {
            return None;
        }
        let angle = |reader: &mut Self, key: &str, help: &str| {
            let node = fields.require(reader, key, help)?;
            let what = fields.what(key);
            let angle = reader.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?;
            let is_positive = reader.check_positive(&what, &angle, Quantity::ANGLE);
            is_positive.then_some(reader.constants.pinned(angle.value?))
        };
        if fields.has("dwell") {
            let over = angle(self, "dwell", "")?;
            return Some(Segment { over, rise: 0.0, law: None, is_length: false });
        }
        let key = if fields.has("return") { "return" } else { "rise" };
        let node = fields.require(self, key, "write `rise`, `return` or `dwell`")?;
        let lift = self.lowered(node, &fields.what(key), Scope::Constant)?;
        let length = Kind::Known(Quantity::LENGTH.dimension());
        let is_length = lift.kind == length;
        if !is_length && !lift.is_angle {
            let what = fields.what(key);
            self.report(
                Diagnostic::error(
                    codes::WRONG_DIMENSION,
                    format!("{what} must be a length or an angle"),
                )
                .at(lift.span, "")
                .help("write for example \"20 mm\", or \"15 deg\" of a follower that swings"),
            );
            return None;
        }
        let lift = self.constants.pinned(lift.value?);
        let over = angle(self, "over", "write for example `over = \"120 deg\"`")?;
        let node = fields.require(self, "law", "write for example `law = \"3-4-5\"`")?;
        let law = self.choice(node, &fields.what("law"), &LAWS)?;
        let rise = if key == "return" { -lift } else { lift };
        Some(Segment { over, rise, law: Some(law), is_length })
    }
}

impl Law {
    /// Adds the pieces of a rise from a height at an angle.
    fn append(
        self,
        pieces: &mut Vec<(f64, Piece)>,
        (at, height): (f64, f64),
        (over, rise): (f64, f64),
    ) {
        let scaled = |powers: &[f64]| {
            let mut factor = rise;
            let scale = |c: &f64| {
                let scaled = factor * c;
                factor /= over;
                scaled
            };
            let mut powers: Vec<f64> = powers.iter().map(scale).collect();
            powers[0] += height;
            Piece::polynomial(powers)
        };
        match self {
            Self::Polynomial345 => pieces.push((at, scaled(&[0.0, 0.0, 0.0, 10.0, -15.0, 6.0]))),
            Self::Polynomial4567 => {
                pieces.push((at, scaled(&[0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0])));
            }
            _ => {
                // Position and slope at the borders follow from the accelerations before.
                let (mut s, mut v) = (0.0, 0.0);
                let accelerations = self.accelerations();
                for (k, &(from, a)) in accelerations.iter().enumerate() {
                    let to = accelerations.get(k + 1).map_or(1.0, |next| next.0);
                    let piece = Piece::of_acceleration(s, v, a);
                    pieces.push((at + from * over, piece.stretched(over, rise, height)));
                    (s, v) = (piece.at(to - from), piece.slope(to - from));
                }
            }
        }
    }

    /// The acceleration A sin(ω s + φ) of the normalised law from each border on, s the distance from it.
    fn accelerations(self) -> Vec<(f64, [f64; 3])> {
        let constant = |a: f64| [a, 0.0, 0.0];
        match self {
            Self::Polynomial345 | Self::Polynomial4567 => Vec::new(),
            Self::Cycloidal => vec![(0.0, [2.0 * PI, 2.0 * PI, 0.0])],
            Self::Harmonic => vec![(0.0, [0.5 * PI * PI, PI, 0.5 * PI])],
            Self::ModifiedSine => {
                let a = 4.0 * PI * PI / (4.0 + PI);
                vec![
                    (0.0, [a, 4.0 * PI, 0.0]),
                    (0.125, [a, 4.0 * PI / 3.0, 0.5 * PI]),
                    (0.875, [a, 4.0 * PI, 1.5 * PI]),
                ]
            }
            Self::ModifiedTrapezoid => {
                let a = 8.0 * PI / (2.0 + PI);
                vec![
                    (0.0, [a, 4.0 * PI, 0.0]),
                    (0.125, constant(a)),
                    (0.375, [a, 4.0 * PI, 0.5 * PI]),
                    (0.625, constant(-a)),
                    (0.875, [-a, 4.0 * PI, 0.5 * PI]),
                ]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest slopes and accelerations of the laws: Norton, table 3-2 and closed forms.
    #[test]
    fn laws_have_their_peak_factors_and_end_where_they_should() {
        let expected = [
            (Law::Polynomial345, 1.875, 5.773_502_691_896_26),
            (Law::Polynomial4567, 2.1875, 7.513_188_404_399_29),
            (Law::Cycloidal, 2.0, 2.0 * PI),
            (Law::Harmonic, 0.5 * PI, 0.5 * PI * PI),
            (Law::ModifiedSine, 1.759_603_385_953_77, 5.527_957_070_544_09),
            (Law::ModifiedTrapezoid, 2.0, 8.0 * PI / (2.0 + PI)),
        ];
        for (law, speed, acceleration) in expected {
            let mut pieces = Vec::new();
            law.append(&mut pieces, (0.0, 0.0), (1.0, 1.0));
            let (last_from, last) = pieces.last().expect("a piece");
            assert!((last.at(1.0 - last_from) - 1.0).abs() < 1e-14, "{law:?}");
            let mut peaks = [0.0_f64; 2];
            for i in 0..=40_000 {
                let u = f64::from(i) / 40_000.0;
                let (from, piece) =
                    pieces.iter().rev().find(|(from, _)| *from <= u).expect("a piece");
                let h = 1e-6;
                let bend = (piece.slope(u - from + h) - piece.slope(u - from - h)) / (2.0 * h);
                peaks = [peaks[0].max(piece.slope(u - from).abs()), peaks[1].max(bend.abs())];
            }
            assert!((peaks[0] - speed).abs() < 1e-8, "{law:?}: {peaks:?}");
            assert!((peaks[1] - acceleration).abs() < 1e-6, "{law:?}: {peaks:?}");
        }
    }
}
