//! [`Primitive`]: a triangle, a segment of a line or a rod, as the shader reads it.

use bytemuck::{Pod, Zeroable};

/// A triangle, a segment of a line or a rod, as the shader reads it.
///
/// A triangle has the corners `a`, `b`, `before`. A segment goes from `a` to `b` and knows the
/// points before and after it, so that neighbours share the pixels about their joint without
/// painting any twice. A rod goes from `a` to `b`, and `before` begins with its radius, m; of a ball
/// `after` is its red, green and blue across the light.
#[derive(Clone, Copy, PartialEq, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Primitive {
    /// First point, relative to the anchor of the body, m.
    pub(super) a: [f32; 3],
    /// Index of the body.
    pub(super) body: u32,
    /// Second point.
    pub(super) b: [f32; 3],
    /// Half of the width of a segment or rim, points.
    pub(super) half_width: f32,
    /// Point before `a`.
    pub(super) before: [f32; 3],
    /// Red, green, blue, opacity, the red in the lowest byte.
    pub(super) color: u32,
    /// Point after `b`; of a ball a colour, 0 to 1.
    pub(super) after: [f32; 3],
    /// [`Kind::bits`].
    pub(super) kind: u32,
}

/// Kind of a primitive.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// A triangle of an area.
    Triangle,
    /// A segment of a line.
    Segment {
        /// True if the line has a point before it.
        has_before: bool,
        /// True if the line has a point after it.
        has_after: bool,
    },
    /// The area of a rod.
    Rod,
    /// The edge of a rod.
    Rim,
    /// The area of a ball, in the light.
    Ball,
}

impl Kind {
    /// Bit of segments.
    const SEGMENT: u32 = 1;
    /// Bit of segments with a point before them.
    const HAS_BEFORE: u32 = 2;
    /// Bit of segments with a point after them.
    const HAS_AFTER: u32 = 4;
    /// Bit of rods and their rims.
    const ROD: u32 = 8;

    /// The number of the kind in the shader.
    pub(super) const fn bits(self) -> u32 {
        match self {
            Self::Triangle => 0,
            Self::Segment { has_before, has_after } => {
                Self::SEGMENT
                    | if has_before { Self::HAS_BEFORE } else { 0 }
                    | if has_after { Self::HAS_AFTER } else { 0 }
            }
            Self::Rod => Self::ROD,
            Self::Rim => Self::ROD | 1,
            Self::Ball => Self::ROD | 2,
        }
    }
}

/// A number in single precision, which the graphics card calculates with.
#[expect(clippy::cast_possible_truncation, reason = "the precision of pictures")]
pub(super) fn single(x: f64) -> f32 {
    x as f32
}

/// A count for the graphics card, which holds fewer than 2^32 of anything.
pub(super) fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// The unsigned constants of the shader.
    fn shader_constants() -> BTreeMap<&'static str, u32> {
        let lines = include_str!("shader.wgsl").lines();
        let definitions = lines.filter_map(|line| line.strip_prefix("const ")?.strip_suffix("u;"));
        let constant = |definition: &'static str| {
            let (name, value) = definition.split_once(" = ").expect("a name and a value");
            (name, value.parse().expect("an unsigned number"))
        };
        definitions.map(constant).collect()
    }

    #[test]
    fn the_shader_has_the_same_numbers_of_kinds() {
        let expected = [
            ("TRIANGLE", Kind::Triangle.bits()),
            ("HAS_BEFORE", Kind::HAS_BEFORE),
            ("HAS_AFTER", Kind::HAS_AFTER),
            ("ROD", Kind::Rod.bits()),
            ("RIM", Kind::Rim.bits()),
            ("BALL", Kind::Ball.bits()),
        ];
        assert_eq!(shader_constants(), BTreeMap::from(expected));
    }

    #[test]
    fn every_kind_has_a_number_of_its_own_and_rods_have_the_largest() {
        let segment = |has_before, has_after| Kind::Segment { has_before, has_after };
        let segments = [
            segment(false, false),
            segment(true, false),
            segment(false, true),
            segment(true, true),
        ];
        let flat = [Kind::Triangle].into_iter().chain(segments).map(Kind::bits);
        let flat: Vec<u32> = flat.collect();
        assert_eq!(flat, [0, 1, 3, 5, 7]);
        // The shader asks for `kind >= ROD`.
        assert!(flat.iter().all(|&bits| bits < Kind::Rod.bits()));
        let rods = [Kind::Rod, Kind::Rim, Kind::Ball].map(Kind::bits);
        assert!(rods.is_sorted_by(|a, b| a < b), "{rods:?}");
    }

    #[test]
    fn the_shader_has_the_light_of_all_pictures() {
        let parts = bksim_scene::LIGHT.map(|part| part.to_string()).join(", ");
        assert!(include_str!("rod.wgsl").contains(&format!("const LIGHT = vec3f({parts});")));
    }
}
