//! Adams/Solver statements: parts with markers, joints between markers, motions, springs and forces.
//!
//! `REULER` turns about z, x and z of the frame, one after the other; a number that ends in `D` is in degrees. A joint
//! measures its marker `I` against its marker `J`, about or along their z. Parts start where the file has them as
//! guesses, since markers need not coincide there.

mod connections;
mod forces;
mod function;
mod statement;

use std::collections::BTreeMap;

use crate::codes;
use crate::draft::{Body, Draft, Table, list, number};
use crate::job::{Job, Place, short};
use crate::names::Names;
use crate::spatial::{
    Inertia, Pose, Rotation, Tensor, Vector, cross, of_point, scale, sub, turned, unit,
};
use statement::{Statement, statements};

/// Units of the file by those of SI.
#[derive(Clone, Copy, Debug)]
struct Units {
    length: f64,
    mass: f64,
    time: f64,
    force: f64,
}

/// Words of units with their size in SI, by the first letters.
const UNITS: [(&str, &[(&str, f64)]); 4] = [
    (
        "LENGTH",
        &[
            ("METER", 1.0),
            ("MILLIMETER", 1e-3),
            ("MM", 1e-3),
            ("CENTIMETER", 1e-2),
            ("CM", 1e-2),
            ("KILOMETER", 1e3),
            ("INCH", 0.0254),
            ("FOOT", 0.3048),
            ("FEET", 0.3048),
            ("YARD", 0.9144),
            ("MILE", 1609.344),
        ],
    ),
    (
        "MASS",
        &[
            ("KILOGRAM", 1.0),
            ("KG", 1.0),
            ("GRAM", 1e-3),
            ("MEGAGRAM", 1e3),
            ("TONNE", 1e3),
            ("POUND_MASS", 0.453_592_37),
            ("SLUG", 14.593_902_937_206_364),
            ("OUNCE_MASS", 0.028_349_523_125),
        ],
    ),
    (
        "TIME",
        &[("SECOND", 1.0), ("MILLISECOND", 1e-3), ("MS", 1e-3), ("MINUTE", 60.0), ("HOUR", 3600.0)],
    ),
    (
        "FORCE",
        &[
            ("NEWTON", 1.0),
            ("KNEWTON", 1e3),
            ("KILONEWTON", 1e3),
            ("MILLINEWTON", 1e-3),
            ("DYNE", 1e-5),
            ("KILOGRAM_FORCE", 9.806_65),
            ("KGF", 9.806_65),
            ("POUND_FORCE", 4.448_221_615_260_5),
            ("KPOUND_FORCE", 4_448.221_615_260_5),
            ("OUNCE_FORCE", 0.278_013_850_953_781_2),
        ],
    ),
];

/// A marker: its part, and its frame in that of the part.
#[derive(Clone, Debug)]
struct Marker {
    part: Option<usize>,
    pose: Pose,
}

/// A joint of the file as loads and motions find it.
#[derive(Clone, Debug)]
struct Joined {
    name: String,
    word: String,
    /// Markers I and J.
    ends: [u64; 2],
}

struct Reader<'r, 'a> {
    job: &'r mut Job<'a>,
    names: &'r mut Names,
    draft: Draft,
    units: Units,
    /// By the ids of the file; `None` is the ground.
    parts: BTreeMap<u64, Option<usize>>,
    /// Poses of bodies in the world.
    poses: Vec<Pose>,
    markers: BTreeMap<u64, Marker>,
    joints: BTreeMap<u64, Joined>,
}

/// Reads the statements of a file.
pub(crate) fn draft(job: &mut Job<'_>, names: &mut Names, file: usize) -> Draft {
    let all = statements(job, file);
    let title = job.sources[file].text.lines().next().unwrap_or("adams").trim().to_owned();
    let name = title.rsplit(':').next().map_or("adams", str::trim).to_owned();
    let heading = vec![
        format!("From {}, statements of Adams/Solver.", job.sources[file].name),
        "Metres, kilograms, seconds and radians, whatever the units of the file. The frame of a body is that of its part.".to_owned(),
        "A joint measures its marker I against its marker J.".to_owned(),
    ];
    let name = if name.is_empty() { "adams".to_owned() } else { short(&name) };
    let draft = Draft { name, heading, ..Draft::default() };
    let units = Units { length: 1.0, mass: 1.0, time: 1.0, force: 1.0 };
    let mut reader = Reader {
        job,
        names,
        draft,
        units,
        parts: BTreeMap::new(),
        poses: Vec::new(),
        markers: BTreeMap::new(),
        joints: BTreeMap::new(),
    };
    let of =
        |keyword: &'static str| all.iter().filter(move |statement| statement.keyword == keyword);
    of("UNITS").for_each(|statement| reader.units(statement));
    of("PART").chain(of("POINT_MASS")).for_each(|statement| reader.part(statement));
    of("MARKER").for_each(|statement| reader.marker(statement));
    of("PART").chain(of("POINT_MASS")).for_each(|statement| reader.inertia(statement));
    of("JOINT").for_each(|statement| reader.joint(statement));
    of("JPRIM").for_each(|statement| reader.primitive(statement));
    of("GCON").for_each(|statement| reader.general_constraint(statement));
    of("JOINT").for_each(|statement| reader.rack(statement));
    of("COUPLER").for_each(|statement| reader.coupler(statement));
    of("GEAR").for_each(|statement| reader.gear(statement));
    of("MOTION").for_each(|statement| reader.motion(statement));
    of("SPRINGDAMPER").for_each(|statement| reader.spring(statement));
    of("SFORCE").for_each(|statement| reader.force(statement));
    of("ACCGRAV").for_each(|statement| reader.gravity(statement));
    reader.rest(&all);
    reader.hold_free_parts();
    reader.draft
}

impl Reader<'_, '_> {
    fn bad(&mut self, place: &Place, message: &str) {
        let help = "write the statement as Adams/Solver has it, such as `MARKER/101, PART = 1, QP = 0, 0, 0`";
        self.job.error(codes::BAD_STATEMENT, message.to_owned(), (place, ""), help);
    }

    fn leave_out(&mut self, statement: &Statement) {
        let what = format!(
            "{}/{}",
            statement.keyword,
            statement.id.map_or(String::new(), |id| id.to_string())
        );
        self.job.leave_out(what, &statement.place);
    }

    /// Statements that are not used.
    fn rest(&mut self, all: &[Statement]) {
        const USED: [&str; 14] = [
            "UNITS",
            "PART",
            "POINT_MASS",
            "MARKER",
            "JOINT",
            "JPRIM",
            "GCON",
            "COUPLER",
            "GEAR",
            "MOTION",
            "SPRINGDAMPER",
            "SFORCE",
            "ACCGRAV",
            "END",
        ];
        for statement in all {
            if !USED.contains(&statement.keyword.as_str()) {
                self.leave_out(statement);
            }
        }
    }

    fn units(&mut self, statement: &Statement) {
        if let Some(system) = statement.text("SYSTEM") {
            let [length, mass, force] = match system.to_ascii_uppercase().as_str() {
                "MMKS" => [1e-3, 1.0, 1.0],
                "CGS" => [1e-2, 1e-3, 1e-5],
                "IPS" => [0.0254, 0.453_592_37, 4.448_221_615_260_5],
                _ => [1.0, 1.0, 1.0],
            };
            self.units = Units { length, mass, force, time: 1.0 };
        }
        for (key, words) in UNITS {
            let Some(word) = statement.text(key).map(str::to_ascii_uppercase) else { continue };
            let Some((_, size)) = words.iter().find(|(known, _)| *known == word) else {
                let message =
                    format!("the unit `{}` of {} is not known", short(&word), key.to_lowercase());
                self.bad(&statement.place, &message);
                continue;
            };
            match key {
                "LENGTH" => self.units.length = *size,
                "MASS" => self.units.mass = *size,
                "TIME" => self.units.time = *size,
                _ => self.units.force = *size,
            }
        }
    }

    /// `REULER`, or `ZP` with `XP`, as a rotation.
    fn orientation(&mut self, statement: &Statement, at: Vector) -> Rotation {
        let [x, z] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        if let Some([a, b, c]) = statement.vector("REULER") {
            return Rotation::about(z, a).then(Rotation::about(x, b)).then(Rotation::about(z, c));
        }
        let toward =
            |key: &str| statement.vector(key).map(|p| sub(scale(self.units.length, p), at));
        let Some(zp) = toward("ZP").and_then(unit) else { return Rotation::NONE };
        let xp = toward("XP").unwrap_or(x);
        let y = unit(cross(zp, xp)).unwrap_or_else(|| crate::spatial::across(zp));
        if statement.has("USEXP") {
            let across = unit(cross(xp, zp)).unwrap_or(y);
            let x = unit(xp).unwrap_or(x);
            return Rotation::of_axes([x, scale(-1.0, across), cross(x, scale(-1.0, across))]);
        }
        Rotation::of_axes([cross(y, zp), y, zp])
    }

    fn part(&mut self, statement: &Statement) {
        let Some(id) = statement.id else { return self.bad(&statement.place, "a part has no id") };
        if self.parts.contains_key(&id) {
            let message = format!("two parts have the id {id}");
            self.job.error(
                codes::TWICE,
                message,
                (&statement.place, ""),
                "give each part an id of its own",
            );
            return;
        }
        if statement.has("GROUND") {
            self.parts.insert(id, None);
            return;
        }
        let written = statement.name.clone().unwrap_or_else(|| format!("part_{id}"));
        let name = self.names.take("body", &written);
        let at = scale(self.units.length, statement.vector("QG").unwrap_or([0.0; 3]));
        let turn = self.orientation(statement, at);
        let mut body = Body::new(name, Inertia::default());
        body.notes.push(format!("PART/{id}"));
        body.place = Some(statement.place.clone());
        self.parts.insert(id, Some(self.draft.bodies.len()));
        self.poses.push(Pose { at, turn });
        self.draft.bodies.push(body);
    }

    fn marker(&mut self, statement: &Statement) {
        let Some(id) = statement.id else {
            return self.bad(&statement.place, "a marker has no id");
        };
        let part = statement.number("PART").or_else(|| statement.number("POINT_MASS"));
        // Without a part it is on the part before it, which ids alone do not tell.
        let Some(part) = part.and_then(whole).and_then(|part| self.parts.get(&part).copied())
        else {
            let message = format!("marker {id} is on no part of the file");
            self.job.error(
                codes::UNKNOWN_NAME,
                message,
                (&statement.place, ""),
                "write `PART = ` with the id of a part",
            );
            return;
        };
        let at = scale(self.units.length, statement.vector("QP").unwrap_or([0.0; 3]));
        let turn = self.orientation(statement, at);
        self.markers.insert(id, Marker { part, pose: Pose { at, turn } });
    }

    /// Mass and inertia of a part, which need its markers.
    fn inertia(&mut self, statement: &Statement) {
        let Some(Some(body)) = statement.id.and_then(|id| self.parts.get(&id).copied()) else {
            return;
        };
        let mass = statement.number("MASS").unwrap_or(0.0) * self.units.mass;
        let cm = self.own_marker(statement, "CM").unwrap_or(Pose::NONE);
        let im = self.own_marker(statement, "IM").unwrap_or(cm);
        let ip = statement.numbers("IP").unwrap_or_default();
        let entry = |k: usize| {
            ip.get(k).copied().unwrap_or(0.0)
                * self.units.mass
                * self.units.length
                * self.units.length
        };
        // Products are integrals; the tensor has their negatives.
        let tensor: Tensor = [entry(0), entry(1), entry(2), -entry(3), -entry(5), -entry(4)];
        let mut tensor = turned(im.turn, tensor);
        let away = of_point(mass, sub(cm.at, im.at));
        for (entry, moved) in tensor.iter_mut().zip(away) {
            *entry -= moved;
        }
        let tensor = tensor.map(|entry| {
            if entry.abs() < 1e-16 * ip.iter().fold(0.0_f64, |a, b| a.max(b.abs())) {
                0.0
            } else {
                entry
            }
        });
        self.draft.bodies[body].inertia = Inertia { mass, com: cm.at, tensor };
        self.start(statement, body, cm);
    }

    fn own_marker(&mut self, statement: &Statement, key: &str) -> Option<Pose> {
        let id = statement.number(key).and_then(whole)?;
        if let Some(marker) = self.markers.get(&id) {
            return Some(marker.pose);
        }
        let message = format!("there is no marker {id}");
        let help = "name a marker of the file";
        self.job.error(codes::UNKNOWN_NAME, message, (&statement.place, ""), help);
        None
    }

    /// A part starts, as a guess, where and as fast as the file has it.
    fn start(&mut self, statement: &Statement, body: usize, cm: Pose) {
        let pose = self.poses[body];
        let mut parts = Vec::new();
        for (word, value) in ["x", "y", "z"].into_iter().zip(pose.apply(cm.at)) {
            parts.push(format!("{word} = {}", number(value)));
        }
        parts.push(format!("quaternion = {}", list(&pose.turn.0)));
        for (word, key) in [("vx", "VX"), ("vy", "VY"), ("vz", "VZ")] {
            if let Some(value) = statement.number(key) {
                let value = value * self.units.length / self.units.time;
                parts.push(format!("{word} = {}", number(value)));
            }
        }
        let rates = ["WX", "WY", "WZ"].map(|key| statement.number(key));
        if rates.iter().any(Option::is_some) {
            let rates = rates.map(|rate| rate.unwrap_or(0.0) / self.units.time);
            let world = pose.turn.then(cm.turn).apply(rates);
            parts.push(format!("w = {}", list(&world)));
        }
        let name = self.draft.bodies[body].name.clone();
        self.draft.initial.push((name, format!("{{ guess = {{ {} }} }}", parts.join(", "))));
    }

    fn gravity(&mut self, statement: &Statement) {
        let of = |key: &str| statement.number(key).unwrap_or(0.0);
        let vector = [of("IGRAV"), of("JGRAV"), of("KGRAV")];
        let factor = self.units.length / (self.units.time * self.units.time);
        self.draft.gravity = Some(scale(factor, vector));
    }

    /// Parts in no joint move freely.
    fn hold_free_parts(&mut self) {
        for idx in 0..self.draft.bodies.len() {
            let name = self.draft.bodies[idx].name.clone();
            let mentions = |table: &Table| {
                let between = table.keys.iter().find(|(key, _)| *key == "between");
                between.is_some_and(|(_, ends)| {
                    ends.contains(&format!("\"{name}\"")) || ends.contains(&format!("\"{name}."))
                })
            };
            if !self.draft.joints.iter().any(mentions) {
                let joint = self.names.coin(&format!("{name}_free"));
                self.draft.joints.push(
                    Table::new(joint, "free")
                        .between("ground", &name)
                        .note("in no joint of the file"),
                );
            }
        }
    }
}

/// An id.
fn whole(value: f64) -> Option<u64> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked to be a whole number"
    )]
    (value >= 0.0 && value.fract() == 0.0 && value < 1e15).then_some(value as u64)
}
