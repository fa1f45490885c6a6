//! Dimensions: linear and aligned ones, with the text that stands in place of their measured length.

use std::ops::Range;

use acadrust::Vector3;
use acadrust::entities::mtext_format::parse_mtext;

use super::first_of;
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
    let text = text(tags, &record)?;
    let (ends, along) = ends(tags, &record)?;
    Some(Shape::Dimension { ends, along, text })
}

/// The text of its own that a dimension has.
pub(super) fn text(tags: &Tags, record: &Range<usize>) -> Option<String> {
    let text = first_of(tags, record, 1).map(|idx| tags.text(idx).into_owned());
    let text = text.filter(|it| !it.trim().is_empty())?;
    Some(parse_mtext(&text, true).to_plain_text())
}

/// The points that a linear or an aligned dimension is between, and the direction along which a linear one measures.
pub(super) fn ends(tags: &Tags, record: &Range<usize>) -> Option<([Point; 2], Option<Point>)> {
    let number = |code: i16| first_of(tags, record, code).and_then(|idx| tags.number(idx));
    let kind = first_of(tags, record, 70).and_then(|idx| tags.integer(idx)).unwrap_or(LINEAR);
    let [z, one] = [0.0, 1.0];
    let [nx, ny, nz] =
        [(210, z), (220, z), (230, one)].map(|(code, or)| number(code).unwrap_or(or));
    let ocs = planar(Vector3 { x: nx, y: ny, z: nz })?;
    let along = match kind & TYPE_BITS {
        LINEAR => {
            let (sin, cos) = number(50).unwrap_or(0.0).to_radians().sin_cos();
            Some(ocs.vector([cos, sin]))
        }
        ALIGNED => None,
        _ => return None,
    };
    let point = |x: i16, y: i16| -> Option<Point> { Some([number(x)?, number(y)?]) };
    Some(([point(13, 23)?, point(14, 24)?], along))
}
