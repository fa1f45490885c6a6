//! Attachments of a drawing, in each of the three ways.

mod block;
mod comma;
mod layer;
mod xdata;

use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::suggest;

use crate::attachment::{Attachment, Content, Value};
use crate::codes;
use crate::drawing::{Drawing, Location};
use crate::excerpt::Excerpts;
use crate::kind::{KINDS, Kind};

/// Inserts on this layer are a legend, not a part of the mechanism.
pub const LEGEND_LAYER: &str = "BK_LEGEND";

/// All attachments, in the order of the drawing, and their faults.
pub fn attachments(
    drawing: &Drawing,
    excerpts: &Excerpts<'_>,
) -> (Vec<Attachment>, Vec<Diagnostic>) {
    let mut gathering = Gathering { excerpts, attachments: Vec::new(), faults: Vec::new() };
    for (entity_idx, entity) in drawing.entities.iter().enumerate() {
        if entity.location.layer.eq_ignore_ascii_case(LEGEND_LAYER) {
            continue;
        }
        gathering.read_xdata(entity_idx, entity);
        gathering.read_block(entity_idx, entity);
    }
    gathering.read_joint_layer(drawing);
    gathering.attachments.sort_by_key(|attachment| attachment.entity_idx);
    (gathering.attachments, gathering.faults)
}

/// The attachments and faults that were found so far.
struct Gathering<'a> {
    excerpts: &'a Excerpts<'a>,
    attachments: Vec<Attachment>,
    faults: Vec<Diagnostic>,
}

impl Gathering<'_> {
    /// A value under the key of its kind; an unknown key is a fault.
    fn value(
        &mut self,
        kind: &'static Kind,
        key: &str,
        content: Content,
        location: &Location,
    ) -> Option<Value> {
        if let Some(key) = kind.keys.iter().find(|known| known.eq_ignore_ascii_case(key)) {
            if let Content::Text(text) = &content {
                let fault = comma::decimal_comma(kind, key, text);
                self.faults.extend(fault.map(|fault| self.excerpts.at(fault, location, "")));
            }
            return Some(Value { key, content, location: location.clone() });
        }
        let message = format!("{} has no key `{key}`", kind.name);
        let fault = Diagnostic::error(codes::UNKNOWN_ATTRIBUTE, message)
            .help(suggest(&key.to_ascii_lowercase(), kind.keys));
        self.faults.push(self.excerpts.at(fault, location, "not a key"));
        None
    }

    /// The kind of a name; an unknown one is a fault.
    fn kind(
        &mut self,
        name: &str,
        location: &Location,
        by: fn(&Kind) -> &'static str,
    ) -> Option<&'static Kind> {
        if let Some(kind) = KINDS.iter().find(|kind| by(kind).eq_ignore_ascii_case(name)) {
            return Some(kind);
        }
        let names: Vec<&str> = KINDS.iter().map(by).collect();
        let message = format!("`{name}` is nothing that can be attached");
        let fault = Diagnostic::error(codes::UNKNOWN_KIND, message).help(suggest(name, &names));
        self.faults.push(self.excerpts.at(fault, location, ""));
        None
    }
}
