//! Loads and drives.

use bksim_model::{Anchor, BodyId, JointId, LoadKind, MotionKind};
use toml_edit::Item;

use super::texts::{all, words};
use super::units::{Dimension, dimension};
use super::{LOAD_LAYER, Sketch, Unwritten, Values, kind, no_place};
use crate::geometry::Point;
use crate::kind::Kind;

impl Sketch<'_> {
    /// Draws all loads.
    pub(super) fn loads(&mut self) -> Result<(), Unwritten> {
        let model = self.model;
        for load in &model.loads {
            // The limits of cylinders are keys of these.
            if self.item("loads", &load.name).is_none() {
                continue;
            }
            let (kind, ends, partners) = self.load(&load.name, &load.kind)?;
            let mut values: Values = vec![("name", load.name.clone())];
            values.extend(partners);
            self.stated("loads", &load.name, kind, &mut values)?;
            self.insert(kind, LOAD_LAYER, ends, values)?;
        }
        Ok(())
    }

    /// Kind of a load, where it is drawn, and the bodies and points it acts on.
    fn load(
        &self,
        name: &str,
        load: &LoadKind,
    ) -> Result<(&'static Kind, [Point; 2], Values), Unwritten> {
        let along = |at: Point, [x, y]: Point| [at, [at[0] + x, at[1] + y]];
        Ok(match load {
            LoadKind::Gravity { acceleration: [x, y, _] } => {
                let [low, high] = self.positions.extent();
                let at = [low[0] - 5.0 * self.size, high[1]];
                let down = self.positions.vector([*x, *y]).unwrap_or([0.0, -1.0]);
                // The block's own arrow points along −y.
                (kind("gravity"), along(at, [-down[1], down[0]]), Values::new())
            }
            LoadKind::Force { on, vector: [x, y, _], .. } => {
                let push = self.positions.vector([*x, *y]).unwrap_or([1.0, 0.0]);
                let body = self.model.bodies[on.body.0].name.clone();
                let values = vec![("body", body), ("point", self.positions.point_name(*on))];
                (kind("force"), along(self.positions.anchor(*on)?, push), values)
            }
            LoadKind::ForceBetween { a, b, .. } => {
                (kind("actuator"), self.line(*a, *b)?, self.ends(*a, *b))
            }
            LoadKind::Torque { on, .. } => {
                (kind("torque"), along(self.centre_of_mass(*on), [1.0, 0.0]), Values::new())
            }
            LoadKind::Spring { a, b, .. } => {
                (self.spring_or_damper(name), self.line(*a, *b)?, self.ends(*a, *b))
            }
            LoadKind::Effort { joint, motion_idx, .. } if self.turns(*joint, *motion_idx) => {
                let on = self.model.joints[joint.0].successor.body;
                (kind("torque"), along(self.centre_of_mass(on), [1.0, 0.0]), Values::new())
            }
            LoadKind::JointSpring { joint, motion_idx, .. } if self.turns(*joint, *motion_idx) => {
                (kind("torsion"), self.at_joint(*joint)?, Values::new())
            }
            // Along the motion of a joint that slides.
            LoadKind::Effort { joint, .. } => (kind("force"), self.along(*joint)?, Values::new()),
            LoadKind::JointSpring { joint, .. } => {
                (self.spring_or_damper(name), self.along(*joint)?, Values::new())
            }
            LoadKind::Flank { .. } => {
                return Err(no_place("the play of", &format!("`{name}`")).into());
            }
            LoadKind::Mesh { .. } => {
                return Err(no_place("the stiffness of", &format!("`{name}`")).into());
            }
            LoadKind::Capstan { .. } => {
                return Err(no_place("the friction of rope", &format!("`{name}`")).into());
            }
            LoadKind::Rope { .. } => return Err(no_place("the rope", &format!("`{name}`")).into()),
            LoadKind::Touch { .. } | LoadKind::Rub { .. } => {
                return Err(no_place("the contact", &format!("`{name}`")).into());
            }
            LoadKind::Stop { joint, .. } => (kind("stop"), self.at_joint(*joint)?, Values::new()),
            LoadKind::Friction { joint, .. } => {
                (kind("friction"), self.at_joint(*joint)?, Values::new())
            }
        })
    }

    fn turns(&self, joint: JointId, motion_idx: usize) -> bool {
        self.model.joints[joint.0].kind.motions()[motion_idx] == MotionKind::Rotation
    }

    fn line(&self, a: Anchor, b: Anchor) -> Result<[Point; 2], Unwritten> {
        Ok([self.positions.anchor(a)?, self.positions.anchor(b)?])
    }

    fn spring_or_damper(&self, name: &str) -> &'static Kind {
        let table = self.item("loads", name).and_then(Item::as_table_like);
        let is_damper = table.and_then(|t| words(t, "type")).is_some_and(|t| t == "damper");
        kind(if is_damper { "damper" } else { "spring" })
    }

    /// A line at a joint along its axis, long enough to be seen.
    fn along(&self, joint: JointId) -> Result<[Point; 2], Unwritten> {
        let [at, to] = self.at_joint(joint)?;
        Ok([at, [0, 1].map(|i| at[i] + 3.0 * self.size * (to[i] - at[i]))])
    }

    fn at_joint(&self, joint: JointId) -> Result<[Point; 2], Unwritten> {
        self.positions.joint(joint)
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
        let owner = format!("`{name}` in `[{section}]`");
        let has_mu = all(table).iter().any(|(key, _)| *key == "mu");
        for (key, _) in all(table) {
            // A torque acts on a body; a force acts on a point, which is known by now.
            let known = match (kind.name, key) {
                (_, "type" | "between") | ("force", "on") => continue,
                ("torque", "on") => Some("body"),
                _ => kind.keys.iter().find(|known| **known == key).copied(),
            };
            let unwritten = || no_place(&format!("`{key}`"), &owner);
            let known = known.ok_or_else(unwritten)?;
            let words = words(table, key).ok_or_else(unwritten)?;
            let dimension = match key {
                "static" if has_mu => Dimension::Open,
                _ => dimension(kind.name, key, slides),
            };
            values.push((known, self.units.complete(words, dimension)));
        }
        Ok(())
    }

    /// Draws all drives.
    pub(super) fn drives(&mut self) -> Result<(), Unwritten> {
        let model = self.model;
        for drive in &model.drives {
            let mut values: Values = vec![("name", drive.name.clone())];
            self.stated("drives", &drive.name, kind("drive"), &mut values)?;
            let ends = self.at_joint(drive.joint)?;
            self.insert(kind("drive"), LOAD_LAYER, ends, values)?;
        }
        Ok(())
    }

    /// Where a load without a point is drawn: the centre of mass of its body.
    fn centre_of_mass(&self, body: BodyId) -> Point {
        let [x, y, _] = self.model.bodies[body.0].com;
        let com = self.positions.vector([x, y]).unwrap_or_default();
        self.positions.on_body(body, com)
    }
}
