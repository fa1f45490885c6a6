//! Extended data: `revolute { name=A … at (x, y) }`, any number of records on one entity.

use bksim_model::diagnostic::Diagnostic;

use super::Gathering;
use crate::attachment::{Attachment, Content, Way};
use crate::codes;
use crate::drawing::{Entity, Shape, XValue};
use crate::geometry::{Curve, Point};

impl Gathering<'_> {
    /// All records of an entity.
    pub(super) fn read_xdata(&mut self, entity_idx: usize, entity: &Entity) {
        let mut rest = entity.xdata.as_slice();
        let mut record_idx = 0;
        while let [XValue::Text(name), XValue::Open, after @ ..] = rest {
            let end = after.iter().position(|value| *value == XValue::Close);
            let Some(end) = end else { break };
            if let Some(mut attachment) = self.read_record(entity, name, &after[..end]) {
                attachment.entity_idx = entity_idx;
                attachment.way = Way::Xdata(record_idx);
                self.attachments.push(attachment);
            }
            record_idx += 1;
            rest = &after[end + 1..];
        }
        if let Some(stray) = rest.first() {
            let found = match stray {
                XValue::Text(text) => format!("the text `{text}`"),
                XValue::Open => "`{`".to_owned(),
                XValue::Close => "`}`".to_owned(),
                _ => "a number or a point".to_owned(),
            };
            let message = format!("extended data of `BKSIM`: {found} where a record was expected");
            let help = "a record is its kind, `{`, its entries and `}`, for example revolute { \
                        name=A }; `bksim cad … remove` takes a broken one away";
            let fault = Diagnostic::error(codes::BROKEN_RECORD, message).help(help);
            self.faults.push(self.excerpts.at(fault, &entity.location, ""));
        }
    }

    fn read_record(
        &mut self,
        entity: &Entity,
        name: &str,
        entries: &[XValue],
    ) -> Option<Attachment> {
        let location = self.excerpts.narrowed(&entity.location, name);
        let kind = self.kind(name.trim(), &location, |kind| kind.name)?;
        let mut attachment = Attachment {
            kind,
            entity_idx: 0,
            location: entity.location.clone(),
            way: Way::Xdata(0),
            values: Vec::new(),
            at: None,
            axis: None,
            to: None,
        };

        // Entries: `key=value` in one text, or a key and the value after it.
        let mut rest = entries;
        while let [XValue::Text(text), after @ ..] = rest {
            let location = self.excerpts.narrowed(&entity.location, text.trim());
            if let Some((key, value)) = text.split_once('=') {
                let (key, value) = (key.trim(), value.trim());
                if !value.is_empty() {
                    let content = Content::Text(value.to_owned());
                    attachment.values.extend(self.value(kind, key, content, &location));
                }
                rest = after;
                continue;
            }
            let (key, Some(value)) = (text.trim(), after.first()) else { break };
            let content = match value {
                XValue::Point(point) | XValue::Displacement(point) | XValue::Direction(point) => {
                    let slot = match key.to_ascii_lowercase().as_str() {
                        "at" => &mut attachment.at,
                        "to" => &mut attachment.to,
                        "axis" => &mut attachment.axis,
                        _ => break,
                    };
                    *slot = Some(*point);
                    rest = &after[1..];
                    continue;
                }
                XValue::Number(number) | XValue::Factor(number) => Content::Number(*number),
                XValue::Distance(length) => Content::Length(*length),
                XValue::Handle(handle) => Content::Entity(*handle),
                XValue::Text(_) | XValue::Layer(_) | XValue::Open | XValue::Close => break,
            };
            attachment.values.extend(self.value(kind, key, content, &location));
            rest = &after[1..];
        }

        // An entry that is neither breaks the record.
        if !rest.is_empty() {
            let message = format!("a record `{name}` of `BKSIM` has an entry that says nothing");
            let help = "an entry is `key=value`, or a key followed by a number, a handle, or, for \
                        `at`, `to` and `axis`, a point";
            let fault = Diagnostic::error(codes::BROKEN_RECORD, message).help(help);
            self.faults.push(self.excerpts.at(fault, &location, ""));
            return None;
        }
        attachment.at = attachment.at.or_else(|| natural_point(&entity.shape));
        Some(attachment)
    }
}

/// The point that an entity stands for.
fn natural_point(shape: &Shape) -> Option<Point> {
    match shape {
        Shape::Point(at) | Shape::Text { at, .. } => Some(*at),
        Shape::Insert(insert) => Some(insert.at),
        Shape::Path(path) => match path.curves.as_slice() {
            [Curve::Arc { centre, .. } | Curve::Ellipse { centre, .. }] => Some(*centre),
            [Curve::Segment { from, to }] => {
                Some([f64::midpoint(from[0], to[0]), f64::midpoint(from[1], to[1])])
            }
            _ => None,
        },
        Shape::Paths(_)
        | Shape::Hatch(_)
        | Shape::Dimension { .. }
        | Shape::Unread { .. }
        | Shape::Other => None,
    }
}
