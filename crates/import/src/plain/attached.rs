//! Extended data on the entities of a drawing that makes the drawing itself the model that was understood.
//!
//! Bodies, joints, couplings, springs, gravity and the drive are records on the entities that show them, with their places as
//! points; every other byte of the file stays.

use bksim_cad::drawing::Handle;
use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{along, distance};
use bksim_cad::patch::{Edit, Entry};
use bksim_model::diagnostic::Diagnostic;

use super::joint::{Joint, Kind, On};
use super::model::Writing;
use super::questions::handle_of;
use super::report::{body_name, handles};
use crate::codes;
use crate::draft::number;

/// The records, or why the drawing cannot hold them; `unit` is the length of one unit of the file in metres, and whether the
/// file states it.
pub(super) fn records(
    writing: &Writing<'_>,
    (unit, has_unit): (f64, bool),
) -> Result<Vec<Edit>, Diagnostic> {
    let drawn = writing.asked.mm_per_unit * 1e-3;
    if has_unit && (drawn / unit - 1.0).abs() > 1e-9 {
        let message = format!(
            "one unit of the drawing stands for {} mm, and of its file for {} mm",
            number(drawn * 1e3),
            number(unit * 1e3)
        );
        return Err(refused(message)
            .note("a drawing with attributes is read in the units of its file, at the scale 1:1"));
    }
    let mut records = Records { writing, edits: Vec::new() };
    records.bodies()?;
    for joint in &writing.found.joints {
        records.joint(joint)?;
    }
    records.springs()?;
    records.drive()?;
    Ok(records.edits)
}

pub(super) fn refused(message: String) -> Diagnostic {
    Diagnostic::error(codes::NOT_ATTACHED, message).help("write a model file: `-o model.toml`")
}

fn key(key: &str, value: impl Into<String>) -> Entry {
    Entry::Text { key: key.to_owned(), value: value.into() }
}

fn at(key: &str, point: Point) -> Entry {
    Entry::Point { key: key.to_owned(), point }
}

fn axis(direction: Point) -> Entry {
    Entry::Direction { key: "axis".to_owned(), direction }
}

struct Records<'a> {
    writing: &'a Writing<'a>,
    edits: Vec<Edit>,
}

impl Records<'_> {
    fn put(&mut self, entity: u64, kind: &str, entries: Vec<Entry>) {
        let entity = Handle(entity);
        self.edits.push(Edit::AddRecord { entity, kind: kind.to_owned(), entries });
    }

    /// The first entity of some strokes.
    fn entity(&self, from: &[usize], what: &str) -> Result<u64, Diagnostic> {
        handle_of(self.writing.found, from).ok_or_else(|| {
            refused(format!("the entities of {what} have no handles, which attributes are kept by"))
        })
    }

    fn name(&self, on: On) -> String {
        body_name(self.writing.found, on)
    }

    fn bodies(&mut self) -> Result<(), Diagnostic> {
        let found = self.writing.found;
        let mass = self.writing.asked.taken("mass").unwrap_or("1").to_owned();
        for (idx, body) in found.bodies.all.iter().enumerate() {
            let entity = self.entity(&body.from, &format!("`{}`", body.name))?;
            let origin = self.writing.origin(idx);
            let mut entries = vec![key("name", &body.name), at("at", origin), axis([1.0, 0.0])];
            let weighs = (body.border.len() > 2 || body.wheel.is_some())
                .then_some(self.writing.options.material)
                .flatten();
            if let Some(material) = weighs {
                entries.push(key("density", format!("{} kg/m^3", number(material.density))));
                entries.push(key("thickness", format!("{} m", number(material.thickness))));
            } else {
                let (centre, inertia) = self.writing.rod(idx, body, mass.parse().unwrap_or(1.0));
                entries.push(key("mass", format!("{mass} kg")));
                entries.push(key("inertia", format!("{} kg*m^2", number(inertia))));
                self.put(entity, "com", vec![key("body", &body.name), at("at", centre)]);
            }
            self.put(entity, "body", entries);
            let others = handles(found, &body.from).into_iter().filter(|other| *other != entity);
            // Lines of a body with an outline of its own say nothing more of it.
            for other in others {
                self.put(other, "body", vec![key("name", &body.name)]);
            }
        }
        Ok(())
    }

    fn joint(&mut self, joint: &Joint) -> Result<(), Diagnostic> {
        let entity = self.entity(&joint.from, &format!("`{}`", joint.name))?;
        let mut between = |kind: &str, name: &str, [first, second]: [On; 2], more: Vec<Entry>| {
            let (first, second) = (self.name(first), self.name(second));
            let entries = vec![
                key("name", name),
                key("body1", first),
                key("body2", second),
                at("at", joint.at),
            ];
            self.put(entity, kind, [entries, more].concat());
        };
        match &joint.kind {
            Kind::Pin => {
                for (k, other) in joint.on[1..].iter().enumerate() {
                    between("revolute", &joint.part_name(k), [joint.on[0], *other], Vec::new());
                }
            }
            Kind::Slide { axis: along } => {
                between("prismatic", &joint.name, [joint.on[0], joint.on[1]], vec![axis(*along)]);
            }
            Kind::Slot { axis: along } => {
                between("slot", &joint.name, [joint.on[1], joint.on[0]], vec![axis(*along)]);
            }
            Kind::Gear { radii, is_internal, .. } => {
                let names = [0, 1].map(|k| self.writing.bearing(joint, k));
                let [Some(first), Some(second)] = names else { return Ok(()) };
                if first.starts_with("ground.") {
                    let message =
                        format!("the ring of `{}` is on the ground, where no joint is", joint.name);
                    return Err(refused(message));
                }
                let radii = self.writing.pitch_radii(joint, *radii, *is_internal);
                let mut entries = vec![
                    key("name", &joint.name),
                    key("between", format!("{first}, {second}")),
                    key(
                        "radii",
                        radii.map(|r| format!("{} m", number(self.writing.metres(r)))).join(", "),
                    ),
                ];
                if *is_internal {
                    entries.push(key("internal", "true"));
                }
                entries.extend(self.writing.carrier(joint).map(|carrier| key("carrier", carrier)));
                self.put(entity, "gear", entries);
            }
            Kind::Rack { .. } | Kind::Cam { .. } => {
                let message = format!("`{}` is a {}", joint.name, joint.kind.name());
                return Err(refused(message)
                    .note("what a curve or the travel of a rack is counted from has no place in a drawing"));
            }
        }
        Ok(())
    }

    fn springs(&mut self) -> Result<(), Diagnostic> {
        let found = self.writing.found;
        for element in self.writing.elements {
            if element.kind == "mass" {
                let message = format!("`{}` is a mass on a body", element.name);
                return Err(refused(message));
            }
            let spring = found.springs.iter().find(|it| it.ends.to_vec() == element.ends);
            let Some(spring) = spring else { continue };
            let entity = self.entity(&spring.from, &format!("`{}`", element.name))?;
            let stiffness = format!("stiffness.{}", element.name);
            let stiffness = self.writing.asked.taken(&stiffness).unwrap_or("1000").to_owned();
            let length = distance(element.ends[0], element.ends[1]);
            let entries = vec![
                key("name", &element.name),
                key("body1", &element.bodies[0]),
                key("body2", &element.bodies[1]),
                at("at", element.ends[0]),
                at("to", element.ends[1]),
                key("stiffness", format!("{stiffness} N/m")),
                key("length", format!("{} m", number(self.writing.metres(length)))),
            ];
            self.put(entity, "spring", entries);
        }
        Ok(())
    }

    /// The drive and the weight, on the entity of the driven joint or of the first one.
    fn drive(&mut self) -> Result<(), Diagnostic> {
        let found = self.writing.found;
        let Some(first) = found.joints.first() else { return Ok(()) };
        let entity = self.entity(&first.from, &format!("`{}`", first.name))?;
        let asked = self.writing.asked;
        if asked.answer("gravity") == Some("down") {
            let down = along([0.0; 2], -1.0, [0.0, 1.0]);
            let entries =
                vec![key("name", "gravity"), key("acceleration", "9.81 m/s^2"), axis(down)];
            self.put(entity, "gravity", entries);
        }
        if let Some((name, rate)) = self.writing.driven() {
            let rate_entries = vec![key("name", "drive_rate"), key("value", rate)];
            self.put(entity, "parameter", rate_entries);
            let entries =
                vec![key("name", "motor"), key("joint", name), key("motion", "drive_rate*t")];
            self.put(entity, "drive", entries);
        }
        Ok(())
    }
}
