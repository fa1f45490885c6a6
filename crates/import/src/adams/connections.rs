//! Joints, primitives, couplers and motions.

use crate::codes;
use crate::draft::{Table, number, signed};
use crate::job::short;
use crate::spatial::{Pose, Rotation, cross, dot, norm, scale, sub, unit};

use super::function::translated;
use super::statement::{self, Statement};
use super::{Joined, Reader, whole};

/// Joints by their words in the file, with their types here; those whose axis is z first.
const JOINTS: [(&str, &str); 11] = [
    ("REVOLUTE", "revolute"),
    ("TRANSLATIONAL", "prismatic"),
    ("CYLINDRICAL", "cylindrical"),
    ("PLANAR", "planar"),
    ("SCREW", "screw"),
    ("SPHERICAL", "spherical"),
    ("FIXED", "weld"),
    ("HOOKE", "universal"),
    ("UNIVERSAL", "universal"),
    ("CONVEL", "constant-velocity"),
    ("RACKPIN", ""),
];

/// Primitives by their words, with their types here.
const PRIMITIVES: [(&str, &str); 6] = [
    ("ATPOINT", "spherical"),
    ("INLINE", "point-on-line"),
    ("INPLANE", "point-on-plane"),
    ("PARALLEL_AXES", "parallel-axes"),
    // With another joint that holds the turn about z.
    ("ORIENTATION", "parallel-axes"),
    ("PERPENDICULAR", "perpendicular-axes"),
];

/// A joint with one motion that turns, or slides, in expressions; whether it slides.
fn scalar(joined: &Joined) -> Option<(String, bool)> {
    match joined.word.as_str() {
        "REVOLUTE" | "CYLINDRICAL" => Some((format!("{}.angle", joined.name), false)),
        "TRANSLATIONAL" => Some((format!("{}.position", joined.name), true)),
        _ => None,
    }
}

impl Reader<'_, '_> {
    /// The markers I and J of a statement.
    pub(super) fn ends(&mut self, statement: &Statement) -> Option<[u64; 2]> {
        let mut ends = [0; 2];
        for (end, key) in ends.iter_mut().zip(["I", "J"]) {
            let id = statement.number(key).and_then(whole);
            let Some(known) = id.filter(|id| self.markers.contains_key(id)) else {
                let id = id.map_or(String::new(), |id| format!(" {id}"));
                let message = format!("{} has no marker {key}{id}", short(&statement.keyword));
                let help = "name a marker of the file";
                self.job.error(codes::UNKNOWN_NAME, message, (&statement.place, ""), help);
                return None;
            };
            *end = known;
        }
        Some(ends)
    }

    /// A point with the frame of a marker, turned by `turn`.
    pub(super) fn point_at(&mut self, marker: u64, turn: Rotation) -> String {
        let Some(of) = self.markers.get(&marker).cloned() else { return String::new() };
        let pose = of.pose.then(Pose { at: [0.0; 3], turn });
        self.draft.frame(of.part, &format!("m{marker}"), pose)
    }

    pub(super) fn world_of(&self, marker: u64) -> Pose {
        let Some(of) = self.markers.get(&marker) else { return Pose::NONE };
        of.part.map_or(Pose::NONE, |part| self.poses[part]).then(of.pose)
    }

    fn called(&mut self, statement: &Statement, kind: &'static str) -> String {
        let id = statement.id.map_or(String::new(), |id| format!("_{id}"));
        let word = statement.keyword.to_lowercase();
        let written = statement.name.clone().unwrap_or_else(|| format!("{word}{id}"));
        self.names.take(kind, &written)
    }

    pub(super) fn joint(&mut self, statement: &Statement) {
        let Some(&(word, kind)) = JOINTS.iter().find(|(word, _)| statement.has(word)) else {
            self.job.error(
                codes::UNKNOWN_WORD,
                "a joint has no type that is known".to_owned(),
                (&statement.place, ""),
                "write for example `JOINT/1, REVOLUTE, I = 101, J = 201`",
            );
            return;
        };
        if kind.is_empty() {
            return;
        }
        let Some([i, j]) = self.ends(statement) else { return };
        let name = self.called(statement, "joint");
        let mut turns = [Rotation::NONE; 2];
        let mut keys: Vec<(&'static str, String)> = Vec::new();
        match word {
            // The axes of the cross: y of J and x of I; z of both for the other joint of this kind.
            "HOOKE" => {
                keys.push(("axis", "[0, 1, 0]".to_owned()));
                keys.push(("second", "[1, 0, 0]".to_owned()));
            }
            "UNIVERSAL" => {
                turns[1] = Rotation::about([0.0, 1.0, 0.0], -std::f64::consts::FRAC_PI_2);
                keys.push(("axis", "[0, 0, 1]".to_owned()));
                keys.push(("second", "[1, 0, 0]".to_owned()));
            }
            "SPHERICAL" => (),
            "FIXED" => turns[0] = self.world_of(j).turn.inverse().then(self.world_of(i).turn),
            "TRANSLATIONAL" => {
                // The markers keep the angle about z that they have in the file.
                let relative = self.world_of(j).turn.inverse().then(self.world_of(i).turn).axes();
                let angle = relative[0][1].atan2(relative[0][0]);
                keys.push(("axis", "[0, 0, 1]".to_owned()));
                if angle.abs() > 1e-12 {
                    keys.push(("angle", number(angle)));
                }
            }
            "SCREW" => {
                let pitch = statement.number("PITCH").unwrap_or(1.0) * self.units.length;
                keys.push(("axis", "[0, 0, 1]".to_owned()));
                keys.push(("lead", number(pitch)));
            }
            _ => keys.push(("axis", "[0, 0, 1]".to_owned())),
        }
        let (first, second) = (self.point_at(j, turns[0]), self.point_at(i, turns[1]));
        let mut table = Table::new(name.clone(), kind).between(&first, &second);
        table.keys.extend(keys);
        self.draft.joints.push(table.note(format!("JOINT/{}", statement.id.unwrap_or(0))));
        if statement.text("IC").is_some() {
            let what = format!("initial conditions of JOINT/{}", statement.id.unwrap_or(0));
            self.job.leave_out(what, &statement.place);
        }
        if let Some(id) = statement.id {
            self.joints.insert(id, Joined { name, word: word.to_owned(), ends: [i, j] });
        }
    }

    pub(super) fn primitive(&mut self, statement: &Statement) {
        let Some(&(word, kind)) = PRIMITIVES.iter().find(|(word, _)| statement.has(word)) else {
            let message = "this primitive is not a joint of a model".to_owned();
            let help = "replace it in the model by a joint that holds the same directions";
            self.job.warn(codes::NOT_MODELLED, message, (&statement.place, "left out"), help);
            return self.leave_out(statement);
        };
        let Some([i, j]) = self.ends(statement) else { return };
        let name = self.called(statement, "joint");
        let (first, second) = (self.point_at(j, Rotation::NONE), self.point_at(i, Rotation::NONE));
        let mut table = Table::new(name, kind).between(&first, &second);
        if kind != "spherical" {
            table = table.key("axis", "[0, 0, 1]");
        }
        if kind == "perpendicular-axes" {
            let turn = Rotation::about([0.0, 1.0, 0.0], -std::f64::consts::FRAC_PI_2);
            let second = self.point_at(i, turn);
            table = Table::new(table.name.clone(), kind).between(&first, &second);
            table = table.key("axis", "[0, 0, 1]").key("second", "[1, 0, 0]");
        }
        let note = format!("JPRIM/{}", statement.id.unwrap_or(0));
        if word == "ORIENTATION" {
            // Next to z of both, x of J and y of I stay perpendicular.
            let about_z = self.names.coin(&format!("{}_about_z", table.name));
            let about_z = Table::new(about_z, "perpendicular-axes").between(&first, &second);
            let about_z = about_z.key("axis", "[1, 0, 0]").key("second", "[0, 1, 0]");
            self.draft.joints.push(about_z.note(note.clone()));
        }
        self.draft.joints.push(table.note(note));
    }

    /// `DM(i, j) - length` is a rod without mass; other constraints are left out.
    pub(super) fn general_constraint(&mut self, statement: &Statement) {
        let text = statement.expression("FUNCTION").unwrap_or_default().to_ascii_uppercase();
        let clean: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let rod = clean.strip_prefix("DM(").and_then(|rest| {
            let (ids, length) = rest.split_once(")-")?;
            let (i, j) = ids.split_once(',')?;
            Some((i.parse::<u64>().ok()?, j.parse::<u64>().ok()?, statement::number(length)?))
        });
        let known =
            rod.filter(|(i, j, _)| self.markers.contains_key(i) && self.markers.contains_key(j));
        let Some((i, j, length)) = known else {
            let message = "this constraint is not one of a model".to_owned();
            let help = "write it into the model as a coupling of type `relation`";
            self.job.warn(codes::NOT_MODELLED, message, (&statement.place, "left out"), help);
            return self.leave_out(statement);
        };
        let name = self.called(statement, "joint");
        let (first, second) = (self.point_at(j, Rotation::NONE), self.point_at(i, Rotation::NONE));
        let table = Table::new(name, "distance").between(&first, &second);
        self.draft.joints.push(table.number("length", length * self.units.length));
    }

    /// A rack and pinion as a relation of the joints of pinion and rack: a turn of I about its z moves J along its z.
    pub(super) fn rack(&mut self, statement: &Statement) {
        if !statement.has("RACKPIN") {
            return;
        }
        let Some([i, j]) = self.ends(statement) else { return };
        let part =
            |reader: &Self, marker: u64| reader.markers.get(&marker).and_then(|marker| marker.part);
        let of = |reader: &Self, marker: u64, word: &str| {
            let fits = |joined: &&Joined| {
                joined.word == word
                    && joined.ends.iter().any(|end| part(reader, *end) == part(reader, marker))
            };
            let joined = reader.joints.values().find(fits)?.clone();
            // Seen from the other side the motion has the other sign; so it has against an axis the other way.
            let own =
                joined.ends.iter().position(|end| part(reader, *end) == part(reader, marker))?;
            let z = |marker: u64| reader.world_of(marker).turn.axes()[2];
            let sign = if own == 0 { 1.0 } else { -1.0 };
            let sign = sign * dot(z(joined.ends[1]), z(marker)).signum();
            Some((scalar(&joined)?.0, sign))
        };
        let (pinion, rack) = (of(self, i, "REVOLUTE"), of(self, j, "TRANSLATIONAL"));
        let (Some((pinion, turn)), Some((rack, slide))) = (pinion, rack) else {
            return self.leave_out(statement);
        };
        let radius = statement.number("PD").unwrap_or(0.0) / 2.0 * self.units.length;
        let name = self.called(statement, "coupling");
        let relation = format!("{rack} {} m*{pinion}", signed(-radius * turn * slide));
        let table = Table::new(name, "relation").text("relation", &relation);
        self.draft.couplings.push(table.note("rack and pinion: check the sense of turning"));
    }

    pub(super) fn coupler(&mut self, statement: &Statement) {
        let ids = statement.numbers("JOINTS").unwrap_or_default();
        let scales = statement.numbers("SCALES").unwrap_or_default();
        let mut text = String::new();
        for (k, id) in ids.iter().enumerate() {
            let joined = whole(*id).and_then(|id| self.joints.get(&id)).cloned();
            let Some((of, is_length)) = joined.and_then(|joined| scalar(&joined)) else {
                return self.leave_out(statement);
            };
            let factor = scales.get(k).copied().unwrap_or(1.0);
            let of = if is_length { format!("{of}/({} m)", number(self.units.length)) } else { of };
            text = if text.is_empty() {
                format!("{}*{of}", number(factor))
            } else {
                format!("{text} {}*{of}", signed(factor))
            };
        }
        if ids.len() < 2 {
            return self.leave_out(statement);
        }
        let name = self.called(statement, "coupling");
        self.draft.couplings.push(Table::new(name, "relation").text("relation", &text));
    }

    /// Two joints whose parts have one speed at the marker `CV` along its z.
    pub(super) fn gear(&mut self, statement: &Statement) {
        let ids = statement.numbers("JOINTS").unwrap_or_default();
        let cv = statement.number("CV").and_then(whole).filter(|cv| self.markers.contains_key(cv));
        let (Some(cv), [a, b]) = (cv, ids.as_slice()) else { return self.leave_out(statement) };
        let at = self.world_of(cv);
        let mut terms = Vec::new();
        for id in [a, b] {
            let Some(joined) = whole(*id).and_then(|id| self.joints.get(&id)).cloned() else {
                return self.leave_out(statement);
            };
            let Some((of, is_length)) = scalar(&joined) else {
                return self.leave_out(statement);
            };
            let frame = self.world_of(joined.ends[1]);
            let axis = frame.turn.axes()[2];
            let direction = if is_length { axis } else { cross(axis, sub(at.at, frame.at)) };
            let factor = dot(direction, at.turn.axes()[2]);
            let unit = if is_length { "" } else { " m" };
            terms.push((factor, unit, of));
        }
        let [(a, of_a, first), (b, of_b, second)] = terms.as_slice() else { return };
        let name = self.called(statement, "coupling");
        let relation = format!("{}{of_a}*{first} {}{of_b}*{second}", number(*a), signed(-b));
        self.draft.couplings.push(Table::new(name, "relation").text("relation", &relation));
    }

    /// A motion of a joint as a function of time.
    pub(super) fn motion(&mut self, statement: &Statement) {
        let joined =
            statement.number("JOINT").and_then(whole).and_then(|id| self.joints.get(&id)).cloned();
        let is_law = !["VELOCITY", "ACCELERATION"].iter().any(|word| statement.has(word));
        let time = format!("(t/({} s))", number(self.units.time));
        let law = statement
            .expression("FUNCTION")
            .and_then(|text| translated(&text, &time, &|_, _| None));
        let (Some(joined), Some(law), true) = (joined, law, is_law) else {
            let message = "this motion is not one of a model".to_owned();
            let help = "write it into the model as a drive: a position as a function of time";
            self.job.warn(codes::NOT_MODELLED, message, (&statement.place, "left out"), help);
            return self.leave_out(statement);
        };
        let slides = statement.has("TRANSLATIONAL") || joined.word == "TRANSLATIONAL";
        let name = self.called(statement, "drive");
        let motion = if slides { format!("{} m*({law})", number(self.units.length)) } else { law };
        let mut table = Table::plain(name).text("joint", &joined.name);
        if joined.word == "CYLINDRICAL" {
            table = table.text("of", if slides { "position" } else { "angle" });
        }
        self.draft.drives.push(table.text("motion", &motion));
    }

    /// The direction of a unit vector from one marker to another, for checks.
    pub(super) fn distance(&self, i: u64, j: u64) -> f64 {
        let away = sub(self.world_of(i).at, self.world_of(j).at);
        unit(away).map_or(0.0, |along| norm(scale(dot(along, away), along)))
    }
}
