//! Couplings at their wheels; tables, curves, states, clocks and signals as sheets.

use bksim_model::{Anchor, BodyId, CouplingKind, JointId, PointId};
use toml_edit::{Array, Item, TableLike, Value};

use super::texts::{all, entries, one_line, quoted, words};
use super::units::dimension;
use super::{LOAD_LAYER, Sketch, Unwritten, Values, kind, no_place};
use crate::geometry::Point;
use crate::geometry::vector::distance;
use crate::kind::{Kind, NAMED, Placement, Section, by_name};

impl Sketch<'_> {
    /// Draws all couplings that have a place; relations are sheets.
    pub(super) fn couplings(&mut self) -> Result<(), Unwritten> {
        for (kind, values) in self.named()? {
            if kind.placement != Placement::Anywhere {
                let ends = self.coupled(&values)?;
                self.insert(kind, LOAD_LAYER, ends, values)?;
            }
        }
        Ok(())
    }

    /// The sheets of what is called by its name, in the order of the sections.
    pub(super) fn named_sheets(&self) -> Result<Vec<(&'static Kind, Values)>, Unwritten> {
        let mut sheets = self.named()?;
        sheets.retain(|(kind, _)| kind.placement == Placement::Anywhere);
        let split = |(kind, values)| {
            let parts = self.in_parts(values).into_iter();
            parts.map(move |values| (kind, values))
        };
        Ok(sheets.into_iter().flat_map(split).collect())
    }

    /// Values with more rows than one holds as several of one name, the others with further rows alone.
    fn in_parts(&self, mut values: Values) -> Vec<Values> {
        let Some(at) = values.iter().position(|(key, _)| *key == "points") else {
            return vec![values];
        };
        let parsed = values[at].1.parse::<Value>();
        let (true, Ok(Value::Array(rows))) =
            (values[at].1.chars().count() > self.longest(), parsed)
        else {
            return vec![values];
        };
        let mut parts: Vec<Array> = vec![Array::new()];
        for row in &rows {
            let last = parts.len() - 1;
            let mut longer = parts[last].clone();
            longer.push(row.clone());
            if longer.len() > 1 && one_line(&longer.to_string()).chars().count() > self.longest() {
                parts.push(Array::from_iter([row.clone()]));
            } else {
                parts[last] = longer;
            }
        }
        let name = values[0].clone();
        let mut parts = parts.iter().map(|rows| one_line(&rows.to_string()));
        values[at].1 = parts.next().unwrap_or_default();
        let further = parts.map(|rows| vec![name.clone(), ("points", rows)]);
        std::iter::once(values).chain(further).collect()
    }

    fn named(&self) -> Result<Vec<(&'static Kind, Values)>, Unwritten> {
        let mut all = Vec::new();
        for (section, word) in NAMED {
            for (name, item) in entries(self.document, word) {
                let owner = format!("`{name}` in `[{word}]`");
                let table = item.as_table_like().ok_or_else(|| no_place("the value", &owner))?;
                let kind = kind_of(section, table).ok_or_else(|| no_place("the type", &owner))?;
                let mut values = vec![("name", name.to_owned())];
                values.extend(self.keys_as_they_are(kind, table, &owner)?);
                all.push((kind, values));
            }
        }
        Ok(all)
    }

    fn keys_as_they_are(
        &self,
        kind: &'static Kind,
        table: &dyn TableLike,
        owner: &str,
    ) -> Result<Values, Unwritten> {
        let stated = all(table).into_iter().filter(|(key, _)| *key != "type");
        let value = |(key, item): (&str, &Item)| {
            let unwritten = || no_place(&format!("`{key}`"), owner);
            let known = kind.keys.iter().find(|known| **known == key).ok_or_else(unwritten)?;
            let words = quoted(item).ok_or_else(unwritten)?;
            Ok((*known, self.units.complete(words, dimension(kind.name, key, false))))
        };
        stated.map(value).collect()
    }

    /// From the first wheel that a coupling names to the second; both in one place are drawn apart.
    fn coupled(&self, values: &Values) -> Result<[Point; 2], Unwritten> {
        let between = values.iter().find(|(key, _)| *key == "between");
        let named = between.map(|(_, words)| words.as_str()).unwrap_or_default();
        let mut places = Vec::new();
        for name in named.split(['[', ']', '"', ',', ' ']).filter(|name| !name.is_empty()) {
            places.extend(self.wheel(name)?);
        }
        let [first, second] = match places.as_slice() {
            [first, second, ..] => [*first, *second],
            _ => return Err(no_place("`between`", "a coupling").into()),
        };
        let is_apart = distance(first, second) > 0.1 * self.size;
        Ok([first, if is_apart { second } else { [first[0] + self.size, first[1]] }])
    }

    /// The place of a joint, or of the centre of a wheel without a joint: a body, or one of its points.
    fn wheel(&self, name: &str) -> Result<Option<Point>, Unwritten> {
        if let Some(idx) = self.model.joints.iter().position(|joint| joint.name == name) {
            return Ok(Some(self.positions.joint(JointId(idx))?[0]));
        }
        let (body, point) = name.split_once('.').map_or((name, None), |(b, p)| (b, Some(p)));
        let Some(idx) = self.model.bodies.iter().position(|known| known.name == body) else {
            return Ok(None);
        };
        let named =
            self.model.bodies[idx].points.iter().position(|known| Some(&*known.name) == point);
        let anchor = Anchor { body: BodyId(idx), point: named.map(PointId) };
        self.positions.anchor(anchor).map(Some)
    }

    /// Centre and pitch radius of a wheel, in the drawing; `None` of what is no wheel or states no radius.
    pub(super) fn pitch_circle(&self, body: BodyId) -> Result<Option<(Point, f64)>, Unwritten> {
        let of_joint = |joint: JointId| {
            let joint = &self.model.joints[joint.0];
            [joint.predecessor, joint.successor].into_iter().find(|anchor| anchor.body == body)
        };
        let in_couplings = self.model.all_couplings().find_map(|coupling| match coupling.kind {
            CouplingKind::Gear(wheels) | CouplingKind::Belt(wheels) => {
                let place = wheels.wheels.iter().position(|wheel| wheel.body == body)?;
                Some((wheels.wheels[place], wheels.radii?[place]))
            }
            CouplingKind::Rack(rack) if rack.bodies[0] == body => {
                Some((of_joint(rack.joints[0])?, rack.radius))
            }
            _ => None,
        });
        let mut belts = self.model.belts.iter().flat_map(|belt| &belt.wheels);
        let on_belt = || belts.find_map(|wheel| Some((of_joint(wheel.joint)?, wheel.radius)));
        let Some((centre, radius)) = in_couplings.or_else(on_belt) else { return Ok(None) };
        let Some(radius) = self.positions.number(radius) else { return Ok(None) };
        let [radius, _] = self.positions.drawn([radius.abs(), 0.0]);
        Ok(Some((self.positions.anchor(centre)?, radius)))
    }

    /// Inputs and outputs of linear equations.
    pub(super) fn io_sheet(&self) -> Result<Option<(&'static Kind, Values)>, Unwritten> {
        let Some(table) = self.document.get("io").and_then(Item::as_table_like) else {
            return Ok(None);
        };
        Ok(Some((kind("io"), self.keys_as_they_are(kind("io"), table, "`[io]`")?)))
    }
}

/// The kind of an entry of a section: by its `type`, or the only one there is.
fn kind_of(section: Section, table: &dyn TableLike) -> Option<&'static Kind> {
    let word = words(table, "type");
    let name = match (section, word.as_deref()) {
        (Section::Curves, Some("formula" | "points")) => "curve",
        (Section::Couplings | Section::Curves, Some(word)) => word,
        (Section::Tables, _) => "table",
        (Section::States, _) => "state",
        (Section::Clocks, _) => "clock",
        (Section::Signals, _) => "signal",
        (Section::Parts, _) => "part",
        _ => return None,
    };
    by_name(name).filter(|kind| kind.section == section)
}
