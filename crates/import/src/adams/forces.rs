//! Springs, and forces by functions.

use crate::codes;
use crate::draft::{Table, number};
use crate::spatial::Rotation;

use super::Reader;
use super::function::translated;
use super::statement::Statement;

impl Reader<'_, '_> {
    /// The joint whose parts are those of two markers, which turns about their z; +1 where it counts I against J.
    fn turning(&self, [i, j]: [u64; 2]) -> Option<(String, f64)> {
        let part = |marker: u64| self.markers.get(&marker).map(|marker| marker.part);
        let joints = self.joints.values().filter(|joined| joined.word == "REVOLUTE");
        let z = |marker: u64| self.world_of(marker).turn.axes()[2];
        let found = joints.filter_map(|joined| {
            let ends = joined.ends.map(part);
            let sign = match () {
                () if ends == [part(i), part(j)] => 1.0,
                () if ends == [part(j), part(i)] => -1.0,
                () => return None,
            };
            let along = crate::spatial::dot(z(joined.ends[1]), z(j));
            (along.abs() > 1.0 - 1e-9).then(|| (joined.name.clone(), sign * along.signum()))
        });
        found.into_iter().next()
    }

    fn load_name(&mut self, statement: &Statement) -> String {
        let id = statement.id.map_or(String::new(), |id| format!("_{id}"));
        let word = statement.keyword.to_lowercase();
        let written = statement.name.clone().unwrap_or_else(|| format!("{word}{id}"));
        self.names.take("load", &written)
    }

    pub(super) fn spring(&mut self, statement: &Statement) {
        let Some([i, j]) = self.ends(statement) else { return };
        let of = |key: &str| statement.number(key).unwrap_or(0.0);
        let u = self.units;
        if statement.has("ROTATIONAL") {
            let Some((joint, sign)) = self.turning([i, j]) else {
                return self.leave_out(statement);
            };
            let torque = u.force * u.length;
            let (k, c) = ((of("KT") + of("K")) * torque, (of("CT") + of("C")) * torque * u.time);
            let name = self.load_name(statement);
            let mut table =
                Table::new(name, "torsion").text("joint", &joint).number("stiffness", k);
            table = table.number("angle", sign * of("ANGLE")).number("damping", c);
            self.draft.loads.push(table);
            if of("TORQUE") != 0.0 {
                let name = self.names.coin(&format!("{joint}_preload"));
                let value = number(sign * of("TORQUE") * torque);
                self.draft
                    .loads
                    .push(Table::new(name, "torque").text("joint", &joint).key("value", value));
            }
            return;
        }
        let (first, second) = (self.point_at(j, Rotation::NONE), self.point_at(i, Rotation::NONE));
        let name = self.load_name(statement);
        let mut table = Table::new(name.clone(), "spring").between(&first, &second);
        table = table
            .number("stiffness", of("K") * u.force / u.length)
            .number("length", of("LENGTH") * u.length);
        if of("C") != 0.0 {
            table = table.number("damping", of("C") * u.force * u.time / u.length);
        }
        self.draft.loads.push(table);
        if of("FORCE") != 0.0 {
            let name = self.names.coin(&format!("{name}_preload"));
            let value = number(of("FORCE") * u.force);
            self.draft
                .loads
                .push(Table::new(name, "force").between(&first, &second).key("value", value));
        }
    }

    /// A force between two markers, or a torque between two parts, by a function.
    pub(super) fn force(&mut self, statement: &Statement) {
        let Some([i, j]) = self.ends(statement) else { return };
        let done = if statement.has("ACTIONONLY") {
            self.action_by(statement, [i, j])
        } else if statement.has("ROTATIONAL") {
            self.torque_by(statement, [i, j])
        } else {
            self.force_by(statement, [i, j])
        };
        if done.is_none() {
            let message = "the function of this force is not one of a model".to_owned();
            let help = "write the force into the model as a load with a `value`";
            self.job.warn(codes::NOT_MODELLED, message, (&statement.place, "left out"), help);
            self.leave_out(statement);
        }
    }

    fn law(
        &self,
        statement: &Statement,
        measures: &super::function::Measures<'_>,
    ) -> Option<String> {
        let time = format!("(t/({} s))", number(self.units.time));
        translated(&statement.expression("FUNCTION")?, &time, measures)
    }

    /// A force or torque on the part of I alone, along z of J: known where J is fixed in the world, and of a force also where it
    /// turns with the part of I.
    fn action_by(&mut self, statement: &Statement, [i, j]: [u64; 2]) -> Option<()> {
        let action = self.markers.get(&i)?.part?;
        let base = self.markers.get(&j)?.clone();
        let is_torque = statement.has("ROTATIONAL");
        let (turn, axes) = match base.part {
            None => (self.world_of(j).turn, "world"),
            Some(part) if part == action && !is_torque => (base.pose.turn, "body"),
            Some(_) => return None,
        };
        let direction = turn.axes()[2];
        let law = self.law(statement, &|_, _| None)?;
        let (unit, size) = if is_torque {
            ("N m", self.units.force * self.units.length)
        } else {
            ("N", self.units.force)
        };
        let component = |along: f64| format!("\"{} {unit}*({law})\"", number(size * along));
        let vector = format!("[{}]", direction.map(component).join(", "));
        let name = self.load_name(statement);
        let table = if is_torque {
            Table::new(name, "torque").text("on", &self.draft.bodies[action].name)
        } else {
            let point = self.point_at(i, Rotation::NONE);
            Table::new(name, "force").text("on", &point).text("axes", axes)
        };
        self.draft.loads.push(table.key("vector", vector));
        Some(())
    }

    fn torque_by(&mut self, statement: &Statement, ends: [u64; 2]) -> Option<()> {
        let (joint, sign) = self.turning(ends)?;
        let time = number(self.units.time);
        let measures = |word: &str, ids: &[u64]| {
            let side = match ids {
                [i, j, ..] if [*i, *j] == ends => sign,
                [j, i, ..] if [*i, *j] == ends => -sign,
                _ => return None,
            };
            let minus = if side < 0.0 { "-" } else { "" };
            match word {
                "AZ" => Some(format!("({minus}{joint}.angle)")),
                "WZ" => Some(format!("({minus}{joint}.rate*({time} s))")),
                _ => None,
            }
        };
        let law = self.law(statement, &measures)?;
        let name = self.load_name(statement);
        let unit = number(sign * self.units.force * self.units.length);
        let value = format!("{unit} N m*({law})");
        self.draft
            .loads
            .push(Table::new(name, "torque").text("joint", &joint).text("value", &value));
        Some(())
    }

    /// Along the line of two markers: an actuator without mass between them has the length.
    fn force_by(&mut self, statement: &Statement, ends: [u64; 2]) -> Option<()> {
        if self.distance(ends[0], ends[1]) == 0.0 {
            return None;
        }
        let line = statement
            .name
            .clone()
            .unwrap_or_else(|| format!("sforce_{}", statement.id.unwrap_or(0)));
        let line = self.names.coin(&format!("{line}_line"));
        let (length, time) = (number(self.units.length), number(self.units.time));
        let measures = |word: &str, ids: &[u64]| {
            let is_own = matches!(ids, [i, j, ..] if [*i, *j] == ends || [*j, *i] == ends);
            match word {
                "DM" if is_own => Some(format!("({line}.position/({length} m))")),
                "VR" if is_own => Some(format!("({line}.velocity/({length} m)*({time} s))")),
                _ => None,
            }
        };
        let law = self.law(statement, &measures)?;
        let (first, second) =
            (self.point_at(ends[1], Rotation::NONE), self.point_at(ends[0], Rotation::NONE));
        let table = Table::new(line.clone(), "cylinder").between(&first, &second);
        self.draft.joints.push(table.note("the line of a force, which holds nothing"));
        let name = self.load_name(statement);
        let value = format!("{} N*({law})", number(self.units.force));
        self.draft.loads.push(Table::new(name, "force").text("joint", &line).text("value", &value));
        Some(())
    }
}
