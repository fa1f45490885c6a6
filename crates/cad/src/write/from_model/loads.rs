//! Loads and drives.

use bksim_model::{Anchor, BodyId, JointId, LoadKind};
use toml_edit::Item;

use super::texts::{all, words};
use super::units::dimension;
use super::{LOAD_LAYER, Sketch, Unwritten, Values, kind, no_place};
use crate::geometry::Point;
use crate::kind::Kind;

impl Sketch<'_> {
    /// Draws all loads.
    pub(super) fn loads(&mut self) -> Result<(), Unwritten> {
        let model = self.model;
        for load in &model.loads {
            let (kind, place, ends) = self.load(&load.name, &load.kind)?;
            let mut values: Values = vec![("name", load.name.clone())];
            values.extend(ends);
            self.stated("loads", &load.name, kind, &mut values)?;
            self.insert(kind, LOAD_LAYER, place, values)?;
        }
        Ok(())
    }

    /// Its kind, where it is drawn, and what it acts on.
    fn load(
        &self,
        name: &str,
        load: &LoadKind,
    ) -> Result<(&'static Kind, [Point; 2], Values), Unwritten> {
        let along = |at: Point, [x, y]: Point| [at, [at[0] + x, at[1] + y]];
        Ok(match load {
            LoadKind::Gravity { acceleration: [x, y, _] } => {
                let [low, high] = self.places.extent();
                let at = [low[0] - 5.0 * self.size, high[1]];
                let down = self.places.vector([*x, *y]).unwrap_or([0.0, -1.0]);
                // The block's own arrow points along −y.
                (kind("gravity"), along(at, [-down[1], down[0]]), Values::new())
            }
            LoadKind::Force { on, vector: [x, y, _], .. } => {
                let push = self.places.vector([*x, *y]).unwrap_or([1.0, 0.0]);
                let body = self.model.bodies[on.body.0].name.clone();
                let values = vec![("body", body), ("point", self.places.point_name(*on))];
                (kind("force"), along(self.places.anchor(*on)?, push), values)
            }
            LoadKind::ForceBetween { a, b, .. } => {
                (kind("actuator"), self.line(*a, *b)?, self.ends(*a, *b))
            }
            LoadKind::Torque { on, .. } => {
                (kind("torque"), along(self.beside(*on), [1.0, 0.0]), Values::new())
            }
            LoadKind::Spring { a, b, .. } => {
                let item = self.item("loads", name).and_then(Item::as_table_like);
                let is_damper = item.and_then(|t| words(t, "type")).is_some_and(|t| t == "damper");
                let kind = kind(if is_damper { "damper" } else { "spring" });
                (kind, self.line(*a, *b)?, self.ends(*a, *b))
            }
            LoadKind::Torsion { joint, .. } => {
                (kind("torsion"), self.at_joint(*joint)?, Values::new())
            }
            LoadKind::Stop { joint, .. } => (kind("stop"), self.at_joint(*joint)?, Values::new()),
            LoadKind::Friction { joint, .. } => {
                (kind("friction"), self.at_joint(*joint)?, Values::new())
            }
        })
    }

    fn line(&self, a: Anchor, b: Anchor) -> Result<[Point; 2], Unwritten> {
        Ok([self.places.anchor(a)?, self.places.anchor(b)?])
    }

    fn at_joint(&self, joint: JointId) -> Result<[Point; 2], Unwritten> {
        self.places.joint(joint)
    }

    /// The keys of a table of the file, but for those that geometry says.
    fn stated(
        &self,
        section: &str,
        name: &str,
        kind: &'static Kind,
        values: &mut Values,
    ) -> Result<(), Unwritten> {
        let Some(table) = self.item(section, name).and_then(Item::as_table_like) else {
            return Ok(());
        };
        let joint = words(table, "joint");
        let joint = self.model.joints.iter().position(|j| Some(&j.name) == joint.as_ref());
        let of = words(table, "of");
        let slides = joint.is_some_and(|joint| self.slides(JointId(joint), of.as_deref()));
        for (key, _) in all(table) {
            // What a torque acts on is a body, what a force acts on is a point and known by now.
            let known = match (kind.name, key) {
                (_, "type" | "between") | ("force", "on") => continue,
                ("torque", "on") => Some("body"),
                _ => kind.keys.iter().find(|known| **known == key).copied(),
            };
            let Some(known) = known else {
                let owner = format!("`{name}` in `[{section}]`");
                return Err(no_place(&format!("`{key}`"), &owner).into());
            };
            let words = words(table, key).unwrap_or_default();
            values.push((known, self.units.complete(words, dimension(kind.name, key, slides))));
        }
        Ok(())
    }

    /// Draws all drives.
    pub(super) fn drives(&mut self) -> Result<(), Unwritten> {
        let model = self.model;
        for drive in &model.drives {
            let mut values: Values = vec![("name", drive.name.clone())];
            self.stated("drives", &drive.name, kind("drive"), &mut values)?;
            let place = self.at_joint(drive.joint)?;
            self.insert(kind("drive"), LOAD_LAYER, place, values)?;
        }
        Ok(())
    }

    /// Where something that stands nowhere is put: the centre of mass of a body.
    fn beside(&self, body: BodyId) -> Point {
        let [x, y, _] = self.model.bodies[body.0].com;
        let com = self.places.vector([x, y]).unwrap_or_default();
        self.places.on_body(body, com)
    }
}
