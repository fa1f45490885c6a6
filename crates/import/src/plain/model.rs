//! Text of a model of what was understood.

use std::fmt::Write as _;

use bksim_cad::drawing::Location;
use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{along, distance, dot, sub};

use super::bodies::{Body, anchor};
use super::joint::{Joint, Kind, On};
use super::mobility::joint_centre;
use super::pieces::{area, turned};
use super::questions::{Asked, drivable};
use super::report::body_name;
use super::{Element, Found, Options};
use crate::draft::{self, Draft, Parameter, Table, list, number};
use crate::spatial::Inertia;

/// Material of the bodies: plates of one thickness.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Material {
    /// kg/m³.
    pub density: f64,
    /// m.
    pub thickness: f64,
}

/// A mechanism that was understood, with what its text is written from.
pub(super) struct Writing<'a> {
    pub(super) found: &'a Found,
    pub(super) asked: &'a Asked,
    pub(super) elements: &'a [Element],
    pub(super) options: &'a Options,
}

impl Writing<'_> {
    /// Metres in a unit of the file.
    pub(super) fn metres(&self, length: f64) -> f64 {
        let value = length * self.asked.mm_per_unit * 1e-3;
        // What a drawing states to 1e-9 of its size is not longer than that.
        format!("{value:.9}").parse().unwrap_or(value)
    }

    pub(super) fn point(&self, origin: Point, p: Point) -> [f64; 3] {
        let [x, y] = sub(p, origin);
        [self.metres(x), self.metres(y), 0.0]
    }

    /// The model, with what is said above it.
    pub(super) fn draft(
        &self,
        name: &str,
        mobility: i64,
        left_out: &[(String, Vec<Location>)],
    ) -> Draft {
        let found = self.found;
        let origins: Vec<Point> = (0..found.bodies.all.len()).map(|idx| self.origin(idx)).collect();
        let mut draft = Draft {
            name: name
                .rsplit(['/', '\\'])
                .next()
                .unwrap_or(name)
                .trim_end_matches(".dxf")
                .to_owned(),
            heading: self.heading(name, mobility, left_out),
            is_planar: true,
            ..Draft::default()
        };
        draft.parameters.push(Parameter {
            name: "body_mass".to_owned(),
            value: draft::quoted(&format!("{} kg", self.asked.taken("mass").unwrap_or("1"))),
            note: "of each body: assumed, for the drawing states none".to_owned(),
        });
        for (idx, body) in found.bodies.all.iter().enumerate() {
            draft.bodies.push(self.body(idx, body, origins[idx]));
        }
        for joint in &found.joints {
            self.joint(&mut draft, joint, &origins);
        }
        self.springs(&mut draft, &origins);
        self.drive(&mut draft);
        draft
    }

    pub(super) fn origin(&self, body: usize) -> Point {
        let first = self.found.joints.iter().find(|joint| joint.on.contains(&On::Body(body)));
        first.map_or_else(|| anchor(&self.found.bodies.all[body]), |joint| joint.at)
    }

    fn heading(
        &self,
        name: &str,
        mobility: i64,
        left_out: &[(String, Vec<Location>)],
    ) -> Vec<String> {
        let mut lines = vec![
            format!("What was understood of the drawing {name}: a mechanism with freedoms {mobility}."),
            format!(
                "One unit of the drawing is {} mm; all lengths here are in metres, y is up.",
                number(self.asked.mm_per_unit)
            ),
            "Bodies stand as drawn: their frames are not turned, and have their origins at their first joints.".to_owned(),
            String::new(),
            "Questions that the drawing leaves, with what is taken here; answer them by --answer KEY=ANSWER:".to_owned(),
        ];
        for question in &self.asked.questions {
            let mut line = format!("- {}: {}", question.key, question.text);
            if let Some(handle) = question.handle {
                let _ = write!(line, " (entity {handle:X})");
            }
            if let Some([x, y]) = question.at {
                let _ = write!(line, " at ({x:.3}, {y:.3})");
            }
            lines.push(line);
            for reading in &question.readings {
                let mark = if reading.answer == question.taken() { "*" } else { " " };
                let freedoms =
                    reading.freedoms.map_or(String::new(), |n| format!("; freedoms {n}"));
                lines.push(format!("  {mark} {}: {}{freedoms}", reading.answer, reading.meaning));
            }
        }
        if !left_out.is_empty() {
            lines.push(String::new());
            lines.push("Drawn, and no part of the mechanism:".to_owned());
        }
        for (what, places) in left_out {
            let shown: Vec<String> = places
                .iter()
                .take(12)
                .map(|place| {
                    place
                        .handle
                        .map_or_else(|| place.kind.clone(), |handle| format!("{:X}", handle.0))
                })
                .collect();
            let more = if places.len() > 12 {
                format!(" and {} more", places.len() - 12)
            } else {
                String::new()
            };
            lines.push(format!("- {what}: {}{more}", shown.join(" ")));
        }
        lines
    }

    fn body(&self, idx: usize, body: &Body, origin: Point) -> draft::Body {
        let mut out = draft::Body::new(
            body.name.clone(),
            Inertia { mass: 0.0, com: [0.0; 3], tensor: [0.0; 6] },
        );
        let outline = self.outline(body, origin);
        match (self.options.material, body.border.len() > 2 || body.wheel.is_some()) {
            (Some(material), true) => {
                out.keys.push((
                    "density",
                    draft::quoted(&format!("{} kg/m^3", number(material.density))),
                ));
                out.keys.push((
                    "thickness",
                    draft::quoted(&format!("{} m", number(material.thickness))),
                ));
            }
            _ => self.assumed(&mut out, idx, body, origin),
        }
        if let Some(outline) = outline {
            out.keys.push(("outline", outline));
        }
        for question in self.asked.masses.iter().filter(|(_, on, _)| *on == idx) {
            out.notes.push(format!(
                "It carries a mass of {} kg, a body of its own.",
                number(question.2)
            ));
        }
        out
    }

    /// The mass of a rod or a disc, as a key in letters of the common parameter.
    fn assumed(&self, out: &mut draft::Body, idx: usize, body: &Body, origin: Point) {
        let (centre, reach) = self.middle(idx);
        out.keys.push(("mass", draft::quoted("body_mass")));
        if let Some((_, radii)) = &body.wheel {
            let disc = self.point(origin, self.rod(idx, body, 1.0).0);
            if disc != [0.0; 3] {
                out.keys.push(("com", list(&disc[..2])));
            }
            let radius = self.metres(radii[0]);
            out.keys
                .push(("inertia", draft::quoted(&format!("body_mass*({} m)^2/2", number(radius)))));
            return;
        }
        let com = self.point(origin, centre);
        if com != [0.0; 3] {
            out.keys.push(("com", list(&com[..2])));
        }
        let length = self.metres(reach.max(2.0 * self.found.pieces.pin));
        out.keys
            .push(("inertia", draft::quoted(&format!("body_mass*({} m)^2/12", number(length)))));
    }

    /// Middle of the joints of a body, and their largest distance.
    fn middle(&self, body: usize) -> (Point, f64) {
        let joints = self.found.joints.iter().filter(|joint| joint.on.contains(&On::Body(body)));
        let ends: Vec<Point> = joints.map(|joint| joint.at).collect();
        let mut reach = 0.0_f64;
        for a in &ends {
            reach = ends.iter().map(|b| distance(*a, *b)).fold(reach, f64::max);
        }
        let share = 1.0 / ends.len().max(1) as f64;
        (ends.iter().fold([0.0; 2], |sum, p| along(sum, share, *p)), reach)
    }

    /// Centre of mass of a rod or a disc of `mass` kilograms, and its moment of inertia about it, kg m².
    pub(super) fn rod(&self, idx: usize, body: &Body, mass: f64) -> (Point, f64) {
        let (centre, reach) = self.middle(idx);
        if let Some((wheel, radii)) = &body.wheel {
            // A wheel is about its pin, but for what the drawing misses; an eccentric disc is not.
            let origin = self.origin(idx);
            let is_about = distance(*wheel, origin) < 3.0 * self.found.pieces.tolerance;
            return (
                if is_about { origin } else { *wheel },
                mass * self.metres(radii[0]).powi(2) / 2.0,
            );
        }
        let length = self.metres(reach.max(2.0 * self.found.pieces.pin));
        (centre, mass * length * length / 12.0)
    }

    /// The border of a body in its frame, thinned where it is round.
    fn outline(&self, body: &Body, origin: Point) -> Option<String> {
        let points: Vec<Point> = match (&body.wheel, body.border.len()) {
            (Some((centre, radii)), _) => (0..48)
                .map(|k| {
                    along(
                        *centre,
                        radii[0],
                        bksim_cad::geometry::vector::direction(
                            f64::from(k) * std::f64::consts::TAU / 48.0,
                        ),
                    )
                })
                .collect(),
            (None, 0..=2) => return None,
            _ => body.border.clone(),
        };
        let ordered: Vec<Point> =
            if area(&points) < 0.0 { points.into_iter().rev().collect() } else { points };
        let corners: Vec<String> =
            ordered.iter().map(|p| list(&self.point(origin, *p)[..2])).collect();
        Some(format!("[{}]", corners.join(", ")))
    }

    pub(super) fn place(
        &self,
        draft: &mut Draft,
        on: On,
        name: &str,
        at: Point,
        origins: &[Point],
    ) -> String {
        let (body, origin) = match on {
            On::Ground => (None, [0.0; 2]),
            On::Body(idx) => (Some(idx), origins[idx]),
        };
        let point = draft::Point {
            name: name.to_owned(),
            at: self.point(origin, at),
            axes: draft::Axes::Own,
        };
        draft.point(body, name, &point)
    }

    fn joint(&self, draft: &mut Draft, joint: &Joint, origins: &[Point]) {
        let name = joint.name.as_str();
        let axis_text = |axis: &Point| list(&axis[..]);
        match &joint.kind {
            Kind::Pin => {
                for (k, other) in joint.on[1..].iter().enumerate() {
                    let own = joint.part_name(k);
                    let first = self.place(draft, joint.on[0], name, joint.at, origins);
                    let second = self.place(draft, *other, name, joint.at, origins);
                    draft.joints.push(Table::new(own, "revolute").between(&first, &second));
                }
            }
            Kind::Slide { axis } => {
                let first = self.place(draft, joint.on[0], name, joint.at, origins);
                let second = self.place(draft, joint.on[1], name, joint.at, origins);
                let table = Table::new(name.to_owned(), "prismatic").between(&first, &second);
                draft.joints.push(table.key("axis", axis_text(axis)));
            }
            Kind::Slot { axis } => {
                let first = self.place(draft, joint.on[1], name, joint.at, origins);
                let second = self.place(draft, joint.on[0], name, joint.at, origins);
                let table = Table::new(name.to_owned(), "slot").between(&first, &second);
                draft.joints.push(table.key("axis", axis_text(axis)));
            }
            Kind::Gear { radii, is_internal, .. } => {
                let names = [0, 1].map(|k| self.bearing(joint, k));
                let [Some(first), Some(second)] = names else { return };
                // The place of a ring of the ground is a point there.
                if joint.on[0] == On::Ground
                    && let Some(pin) = self.bearing_pin(joint, 0)
                {
                    self.place(draft, On::Ground, &pin.name, pin.at, origins);
                }
                let lengths = self
                    .pitch_radii(joint, *radii, *is_internal)
                    .map(|r| self.asked.mm_per_unit * 1e-3 * r);
                let mut table = Table::new(name.to_owned(), "gear")
                    .between(&first, &second)
                    .key("radii", list(&lengths));
                if *is_internal {
                    table = table.key("internal", "true");
                }
                if let Some(carrier) = self.carrier(joint) {
                    table = table.text("carrier", &carrier);
                }
                draft.couplings.push(table);
            }
            Kind::Rack { radius, .. } => {
                let slide = self.found.joints.iter().find(|it| {
                    matches!(it.kind, Kind::Slide { .. }) && it.on.contains(&joint.on[1])
                });
                let (Some(first), Some(slide)) = (self.bearing(joint, 0), slide) else { return };
                let Kind::Slide { axis: along_slide } = slide.kind else { return };
                let centre = joint_centre(&self.found.joints, joint);
                let centre = if centre == joint.at { self.wheel_centre(joint, 0) } else { centre };
                let moves = dot(turned(sub(joint.at, centre)), along_slide);
                let mut table = Table::new(name.to_owned(), "rack").between(&first, &slide.name);
                table = table.number("radius", self.metres(*radius));
                if moves < 0.0 {
                    table = table.key("reversed", "true");
                }
                draft.couplings.push(table);
            }
            Kind::Cam { normal, roller } => self.cam(draft, joint, (*normal, *roller), origins),
        }
    }

    fn wheel_centre(&self, gear: &Joint, which: usize) -> Point {
        let On::Body(idx) = gear.on[which] else {
            let Kind::Gear { radii, .. } = gear.kind else { return [0.0; 2] };
            let rings = &self.found.bodies.rings;
            let ring = rings.iter().find(|(_, radius, _)| *radius == radii[which]);
            return ring.map_or([0.0; 2], |(centre, ..)| *centre);
        };
        self.found.bodies.all[idx].wheel.as_ref().map_or([0.0; 2], |(centre, _)| *centre)
    }

    /// Pitch radii in drawing units: they touch; what the drawing misses is shared between them.
    pub(super) fn pitch_radii(&self, gear: &Joint, radii: [f64; 2], is_internal: bool) -> [f64; 2] {
        let centres = [0, 1].map(|k| self.bearing_place(gear, k));
        let reach = if is_internal { (radii[0] - radii[1]).abs() } else { radii[0] + radii[1] };
        let fit = distance(centres[0], centres[1]) / reach;
        radii.map(|radius| radius * fit)
    }

    /// The pin about which a wheel turns.
    fn bearing_pin(&self, gear: &Joint, which: usize) -> Option<&Joint> {
        let (wheel, centre) = (gear.on[which], self.wheel_centre(gear, which));
        let near = 2.0 * self.found.pieces.tolerance;
        self.found.joints.iter().find(|joint| {
            joint.kind == Kind::Pin
                && joint.on.contains(&wheel)
                && distance(joint.at, centre) < near
        })
    }

    fn bearing_place(&self, gear: &Joint, which: usize) -> Point {
        self.bearing_pin(gear, which).map_or_else(|| self.wheel_centre(gear, which), |pin| pin.at)
    }

    /// The moving body that carries both wheels of a gear.
    pub(super) fn carrier(&self, gear: &Joint) -> Option<String> {
        let [first, second] = [0, 1].map(|k| self.bearing_pin(gear, k));
        let common = first?.on.iter().filter(|on| second.is_some_and(|pin| pin.on.contains(on)));
        let moving = |on: &&On| **on != On::Ground && !gear.on.contains(on);
        common.into_iter().find(moving).map(|on| body_name(self.found, *on))
    }

    /// The joint about which a wheel turns.
    pub(super) fn bearing(&self, gear: &Joint, which: usize) -> Option<String> {
        let wheel = gear.on[which];
        let pin = self.bearing_pin(gear, which)?;
        if wheel == On::Ground {
            return Some(format!("ground.{}", pin.name));
        }
        let place = pin.on.iter().position(|on| *on == wheel)?;
        Some(pin.part_name(place.saturating_sub(1)))
    }

    fn springs(&self, draft: &mut Draft, origins: &[Point]) {
        let on = |name: &str| {
            let idx = self.found.bodies.all.iter().position(|body| body.name == name);
            idx.map_or(On::Ground, On::Body)
        };
        for element in self.elements {
            if element.kind == "mass" {
                let body = on(&element.bodies[0]);
                let mass = element.mass.unwrap_or_default();
                let at = self.place(draft, body, &element.name, element.ends[0], origins);
                let inertia = Inertia { mass, com: [0.0; 3], tensor: [0.0; 6] };
                draft.bodies.push(draft::Body::new(element.name.clone(), inertia));
                let name = format!("{}_weld", element.name);
                draft.joints.push(Table::new(name, "weld").between(&at, &element.name));
                continue;
            }
            let ends = [0, 1].map(|k| (on(&element.bodies[k]), element.ends[k]));
            let [first, second] =
                ends.map(|(on, at)| self.place(draft, on, &element.name, at, origins));
            let key = format!("stiffness.{}", element.name);
            let stiffness = self.asked.taken(&key).unwrap_or("1000").to_owned();
            let length = self.metres(distance(element.ends[0], element.ends[1]));
            let table = Table::new(element.name.clone(), "spring")
                .note("Unloaded as drawn; its stiffness is assumed unless it was answered.")
                .between(&first, &second)
                .key("stiffness", draft::quoted(&format!("{stiffness} N/m")))
                .number("length", length);
            draft.loads.push(table);
        }
    }

    fn drive(&self, draft: &mut Draft) {
        draft.gravity = (self.asked.answer("gravity") == Some("down")).then_some([0.0, -9.81, 0.0]);
        let Some((name, rate)) = self.driven() else { return };
        draft.parameters.push(Parameter {
            name: "drive_rate".to_owned(),
            value: draft::quoted(rate),
            note: "rate of the driven body, assumed".to_owned(),
        });
        draft.drives.push(
            Table::plain("motor".to_owned()).text("joint", &name).text("motion", "drive_rate*t"),
        );
    }

    /// The joint that is driven by the answer, and its rate.
    pub(super) fn driven(&self) -> Option<(String, &'static str)> {
        let answer = self.asked.answer("drive").filter(|answer| *answer != "none")?;
        let (name, idx, _) = drivable(self.found).into_iter().find(|(name, ..)| name == answer)?;
        let is_slide = matches!(self.found.joints[idx].kind, Kind::Slide { .. });
        Some((name, if is_slide { "0.01 m/s" } else { "60 rpm" }))
    }
}
