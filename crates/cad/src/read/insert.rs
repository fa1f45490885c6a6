//! Inserts: ours with their attributes, all others with the curves of their blocks.

use acadrust::EntityType;
use acadrust::entities::{EntityCommon, Insert};

use super::plane::planar;
use super::{Reading, shape, xdata};
use crate::drawing::{Entity, Insert as OurInsert, Shape, Unread};
use crate::geometry::{Affine, Path};

/// Blocks nested deeper are not followed.
pub(super) const MAX_DEPTH: usize = 16;

/// Larger arrays of inserts are not a part of a mechanism.
const MAX_CELLS: usize = 10_000;

/// Our blocks begin with this.
const PREFIX: &str = "BK_";

fn is_ours(block: &str) -> bool {
    block.get(..PREFIX.len()).is_some_and(|head| head.eq_ignore_ascii_case(PREFIX))
}

/// The positions of an array of inserts, in the axes of its block; one for a plain insert.
pub(super) fn cells(insert: &Insert) -> Vec<Affine> {
    let [columns, rows] = [insert.column_count.max(1), insert.row_count.max(1)];
    // Spacings are not scaled with the block.
    let along = |spacing: f64, scale: f64| if scale == 0.0 { 0.0 } else { spacing / scale };
    let dx = along(insert.column_spacing, insert.x_scale());
    let dy = along(insert.row_spacing, insert.y_scale());
    (0..rows)
        .flat_map(|row| (0..columns).map(move |column| (row, column)))
        .take(MAX_CELLS)
        .map(|(row, column)| Affine::translation([f64::from(column) * dx, f64::from(row) * dy]))
        .collect()
}

impl Reading<'_> {
    /// An insert of the model space.
    pub(super) fn read_insert(&mut self, insert: &Insert) {
        let Some(map) = self.map(insert) else {
            return self.pass_over("INSERT", &insert.common, None, Unread::OutOfPlane);
        };
        if is_ours(&insert.block_name) {
            self.read_ours(insert, &map, &Affine::IDENTITY, None);
            return;
        }
        // Curves by the layer they are on; in a block, layer 0 means that of the insert.
        let mut layers: Vec<(String, Vec<Path>)> = vec![(insert.common.layer.clone(), Vec::new())];
        let cells = cells(insert).into_iter().map(|cell| cell.then(&map));
        let mut waiting: Vec<_> =
            cells.map(|cell| (insert.clone(), cell, insert.common.layer.clone(), 0)).collect();
        'blocks: while let Some((insert, map, layer, depth)) = waiting.pop() {
            for entity in self.document.entities_in_block(&insert.block_name) {
                // Inserts of inserts may grow without bound: those beyond the budget are not drawn.
                if self.budget == 0 {
                    let limit = "all inserts together have more than 200 000 curves";
                    self.pass_over("INSERT", &insert.common, None, Unread::TooMany { limit });
                    break 'blocks;
                }
                self.budget -= 1;
                let own = &entity.common().layer;
                let layer = if own == "0" { layer.clone() } else { own.clone() };
                if let EntityType::Insert(inner) = entity {
                    let block = Some(insert.block_name.as_str());
                    let Some(inner_map) = self.map(inner) else {
                        self.pass_over("INSERT", &inner.common, block, Unread::OutOfPlane);
                        continue;
                    };
                    if is_ours(&inner.block_name) {
                        self.read_ours(inner, &inner_map, &map, Some(&layer));
                    } else if depth < MAX_DEPTH {
                        waiting.push((inner.clone(), inner_map.then(&map), layer, depth + 1));
                    } else {
                        let limit = "inserts stand within one another more than 16 deep";
                        self.pass_over("INSERT", &inner.common, block, Unread::TooMany { limit });
                    }
                    continue;
                }
                let path = match shape::shape(entity) {
                    Shape::Path(path) => path,
                    Shape::Unread { why, .. } => {
                        let kind = entity.as_entity().entity_type();
                        let block = Some(insert.block_name.as_str());
                        self.pass_over(kind, entity.common(), block, why);
                        continue;
                    }
                    _ => continue,
                };
                let path = path.transformed(&map);
                match layers.iter_mut().find(|(name, _)| *name == layer) {
                    Some((_, known)) => known.push(path),
                    None => layers.push((layer, vec![path])),
                }
            }
        }

        // One entity for each layer.
        for (layer_idx, (layer, paths)) in layers.into_iter().enumerate() {
            let location = self.location("INSERT", &insert.common, map.origin);
            let location = crate::drawing::Location { layer, ..location };
            // The insert's own data belong to the curves of its own layer.
            let xdata = if layer_idx == 0 { xdata(&insert.common) } else { Vec::new() };
            self.entities.push(Entity { location, shape: Shape::Paths(paths), xdata });
        }
    }

    /// Notes an entity that is passed over; one of a block once, however often that is inserted.
    fn pass_over(&mut self, kind: &str, common: &EntityCommon, block: Option<&str>, why: Unread) {
        if !self.unread.insert(common.handle.into()) {
            return;
        }
        let location = self.location(kind, common, self.first_point(common));
        let shape = Shape::Unread { why, block: block.map(str::to_owned) };
        self.entities.push(Entity { location, shape, xdata: Vec::new() });
    }

    /// An insert of one of our blocks, in a block that is itself inserted by `outer`.
    fn read_ours(&mut self, insert: &Insert, map: &Affine, outer: &Affine, layer: Option<&str>) {
        let map = map.then(outer);
        let attributes =
            insert.attributes.iter().map(|attribute| self.attribute(attribute, outer)).collect();
        let ours = OurInsert {
            block: insert.block_name.to_ascii_uppercase(),
            at: map.origin,
            x: map.x,
            y: map.y,
            attributes,
        };
        let mut location = self.location("INSERT", &insert.common, map.origin);
        if let Some(layer) = layer {
            layer.clone_into(&mut location.layer);
        }
        let shape = Shape::Insert(ours);
        self.entities.push(Entity { location, shape, xdata: xdata(&insert.common) });
    }

    /// From the axes of the block to those the insert stands in; `None` out of the plane.
    pub(super) fn map(&self, insert: &Insert) -> Option<Affine> {
        let ocs = planar(insert.normal)?;
        let base = self.document.block_records.get(&insert.block_name).map(|b| b.base_point);
        let base = base.map_or([0.0; 2], |p| [p.x, p.y]);
        // A block's own origin goes to the insertion point.
        Some(
            Affine::translation([-base[0], -base[1]])
                .then(&Affine::scaling(insert.x_scale(), insert.y_scale()))
                .then(&Affine::rotation(insert.rotation))
                .then(&Affine::translation([insert.insert_point.x, insert.insert_point.y]))
                .then(&ocs),
        )
    }
}
