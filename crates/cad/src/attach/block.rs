//! Inserts of our blocks with their attributes.

use super::Gathering;
use crate::attachment::{Attachment, Content, Way};
use crate::drawing::{Entity, Shape};
use crate::kind::Placement;

impl Gathering<'_> {
    /// An insert of one of our blocks.
    pub(super) fn read_block(&mut self, entity_idx: usize, entity: &Entity) {
        let Shape::Insert(insert) = &entity.shape else { return };
        let Some(kind) = self.kind(&insert.block, &entity.location, |kind| kind.block) else {
            return;
        };
        let mut values = Vec::new();
        for attribute in insert.attributes.iter().filter(|a| !a.value.is_empty()) {
            let content = Content::Text(attribute.value.clone());
            let location = self.excerpts.narrowed(&attribute.location, &attribute.value);
            values.extend(self.value(kind, &attribute.tag, content, &location));
        }
        let [x, y] = [insert.x, insert.y];
        // The arrow of gravity points down where the block is not turned.
        let axis = if kind.name == "gravity" { [-y[0], -y[1]] } else { x };
        let end = [insert.at[0] + x[0], insert.at[1] + x[1]];
        self.attachments.push(Attachment {
            kind,
            entity_idx,
            location: entity.location.clone(),
            way: Way::Block,
            values,
            at: (kind.placement != Placement::Anywhere).then_some(insert.at),
            axis: (kind.placement == Placement::Frame).then_some(axis),
            to: (kind.placement == Placement::Line).then_some(end),
        });
    }
}
