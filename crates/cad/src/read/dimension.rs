//! Dimensions: linear and aligned ones, with the text that stands in place of their measured length.

use acadrust::Vector3;
use acadrust::entities::mtext_format::parse_mtext;

use super::plane::planar;
use crate::drawing::{Handle, Shape};
use crate::geometry::Point;
use crate::tags::Tags;

/// The types of dimensions by group 70, its flags aside: DXF reference, *DIMENSION*.
const LINEAR: i64 = 0;
const ALIGNED: i64 = 1;
const TYPE_BITS: i64 = 7;

/// A linear or an aligned dimension with a text of its own; `None` for any other.
pub(super) fn dimension(tags: &Tags, handle: Handle) -> Option<Shape> {
    let record = tags.known_record(handle)?;
    let own: Vec<usize> = record.take_while(|&idx| tags.code(idx) < 1000).collect();
    let find = |code: i16| own.iter().copied().find(|&idx| tags.code(idx) == code);
    let number = |code: i16| find(code).and_then(|idx| tags.number(idx));
    let text = find(1).map(|idx| tags.text(idx).into_owned()).filter(|it| !it.trim().is_empty())?;
    let text = parse_mtext(&text, true).to_plain_text();

    let kind = find(70).and_then(|idx| tags.integer(idx)).unwrap_or(LINEAR) & TYPE_BITS;
    let [z, one] = [0.0, 1.0];
    let [nx, ny, nz] =
        [(210, z), (220, z), (230, one)].map(|(code, or)| number(code).unwrap_or(or));
    let ocs = planar(Vector3 { x: nx, y: ny, z: nz })?;
    let along = match kind {
        LINEAR => {
            let (sin, cos) = number(50).unwrap_or(0.0).to_radians().sin_cos();
            Some(ocs.vector([cos, sin]))
        }
        ALIGNED => None,
        _ => return None,
    };
    let point = |x: i16, y: i16| -> Option<Point> { Some([number(x)?, number(y)?]) };
    Some(Shape::Dimension { ends: [point(13, 23)?, point(14, 24)?], along, text })
}
