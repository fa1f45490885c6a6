//! Links of PMKS+: a planar linkage in the query of an address.
//!
//! Parts are divided by points: switches, scale, speed and time step, units, joints, links, forces, what is selected.
//! Numbers have the digits `0-9A-Za-z_-`, the most significant one first; decimals are thousandths, and a `0` before
//! the first digit makes a number negative. Lengths are taken as metres, masses as kilograms: the codes of units are
//! kept as a comment.

use std::collections::BTreeMap;

use crate::codes;
use crate::draft::{Body, Draft, Point, Table, list, number, quoted};
use crate::job::{Job, Place, short};
use crate::names::Names;
use crate::spatial::{Inertia, Rotation};

/// The digits of a number in the order of their values.
const DIGITS: &[u8; 64] = b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-";

/// A point of the plane.
type Flat = [f64; 2];

#[derive(Debug)]
struct Joint {
    id: String,
    name: String,
    at: Flat,
    /// Direction of its guide, rad.
    angle: f64,
    slides: bool,
    is_input: bool,
    is_ground: bool,
    /// The link with its slot.
    carrier: Option<String>,
}

#[derive(Debug)]
struct Link {
    id: String,
    name: String,
    mass: f64,
    moment: f64,
    com: Flat,
    joints: Vec<String>,
    is_block: bool,
}

#[derive(Debug)]
struct Force {
    link: String,
    name: String,
    from: Flat,
    to: Flat,
    size: f64,
    turns: bool,
    is_outward: bool,
}

/// The text of a link, part by part.
struct Parts<'t> {
    texts: Vec<(usize, &'t str)>,
    next: usize,
    file: usize,
}

impl<'t> Parts<'t> {
    fn of(text: &'t str, start: usize, file: usize) -> Self {
        let mut texts = Vec::new();
        let mut at = start;
        for part in text[start..].split('.') {
            texts.push((at, part));
            at += part.len() + 1;
        }
        Self { texts, next: 0, file }
    }

    fn take(&mut self) -> Option<(&'t str, Place)> {
        let &(at, part) = self.texts.get(self.next)?;
        self.next += 1;
        Some((part, Place { file: self.file, span: at..at + part.len() }))
    }

    /// Parts up to an empty one.
    fn group(&mut self) -> Vec<(&'t str, Place)> {
        let mut group = Vec::new();
        while let Some((part, place)) = self.take() {
            if part.is_empty() {
                break;
            }
            group.push((part, place));
        }
        group
    }
}

/// Reads the link in a file.
pub(crate) fn draft(job: &mut Job<'_>, names: &mut Names, file: usize) -> Option<Draft> {
    let text = job.sources[file].text.trim_end().to_owned();
    let start = text.find('?')? + 1;
    let mut parts = Parts::of(&text, start, file);
    let whole = Place { file, span: start..text.len() };
    let head: Vec<(&str, Place)> = (0..4).filter_map(|_| parts.take()).collect();
    let [(switches, _), _, (speed, speed_place), (units, _)] = head.as_slice() else {
        bad(job, &whole, "the link ends before its joints");
        return None;
    };
    let joints: Vec<Joint> = parts.group().iter().filter_map(|part| joint(job, part)).collect();
    let links: Vec<Link> = parts.group().iter().filter_map(|part| link(job, part)).collect();
    let forces: Vec<Force> = parts.group().iter().filter_map(|part| force(job, part)).collect();
    check_end(job, &text, start, file);
    let bits = switches.bytes().fold(0, |sum, digit| sum * 64 + digit_of(digit).unwrap_or(0));
    let mut linkage = Linkage {
        job,
        names,
        draft: Draft { name: "linkage".to_owned(), ..Draft::default() },
        joints,
        links,
        bodies: BTreeMap::new(),
    };
    linkage.draft.is_planar = true;
    linkage.draft.heading = vec![
        "From a link of PMKS+.".to_owned(),
        format!("Its numbers are taken as metres, kilograms, newtons and radians; its code of units is {units}."),
        "The frame of a link has its origin in the first joint, and x along the line to the second one.".to_owned(),
    ];
    if bits & 2 != 0 {
        linkage.draft.gravity = Some([0.0, -9.81, 0.0]);
    }
    linkage.all_links(&whole);
    linkage.all_joints();
    let speed = speed.split(',').next().unwrap_or_default();
    let speed = integer(speed);
    if speed.is_none() {
        bad(linkage.job, speed_place, "the speed is no number");
    }
    let sign = if bits & 1 != 0 { -1.0 } else { 1.0 };
    linkage.drive(sign * speed.unwrap_or(0.0));
    for force in &forces {
        linkage.force(force);
    }
    Some(linkage.draft)
}

fn bad(job: &mut Job<'_>, place: &Place, message: &str) {
    let help = "copy the whole link again, as the page gives it";
    job.error(codes::BAD_LINK, message.to_owned(), (place, "here"), help);
}

fn digit_of(digit: u8) -> Option<u32> {
    DIGITS.iter().position(|known| *known == digit).and_then(|value| u32::try_from(value).ok())
}

/// A whole number.
fn integer(text: &str) -> Option<f64> {
    let (sign, digits) = match text.strip_prefix('0') {
        Some("") => return Some(0.0),
        Some(rest) => (-1.0, rest),
        None => (1.0, text),
    };
    if digits.is_empty() || digits.len() > 8 {
        return None;
    }
    let mut value = 0.0;
    for digit in digits.bytes() {
        value = value * 64.0 + f64::from(digit_of(digit)?);
    }
    Some(sign * value)
}

/// A number with three decimals.
fn decimal(text: &str) -> Option<f64> {
    integer(text).map(|thousandths| thousandths / 1000.0)
}

/// The last character is the length before it, modulo 62.
fn check_end(job: &mut Job<'_>, text: &str, start: usize, file: usize) {
    let Some(last) = text.as_bytes().last().copied() else { return };
    let place = Place { file, span: text.len() - 1..text.len() };
    let length = text.len() - 1 - start;
    let counts = [length % 62, (length + 1) % 62];
    let found = digit_of(last).and_then(|digit| usize::try_from(digit).ok());
    if !found.is_some_and(|found| counts.contains(&found)) {
        let help =
            "copy the whole link again, as the page gives it; the last character counts the others";
        let message = "the link is shorter or longer than it says".to_owned();
        job.warn(codes::BAD_LINK, message, (&place, "does not fit the length"), help);
    }
}

fn joint(job: &mut Job<'_>, (part, place): &(&str, Place)) -> Option<Joint> {
    let fields: Vec<&str> = part.split(',').collect();
    let read = || {
        let [head, name, x, y, angle, rest @ ..] = fields.as_slice() else { return None };
        let bits = digit_of(*head.as_bytes().first()?)?;
        Some(Joint {
            id: head.get(1..)?.to_owned(),
            name: (*name).to_owned(),
            at: [decimal(x)?, decimal(y)?],
            angle: decimal(angle)?,
            slides: bits & 1 != 0,
            is_input: bits & 2 != 0,
            is_ground: bits & 4 != 0,
            carrier: rest
                .first()
                .filter(|carrier| !carrier.is_empty())
                .map(|&carrier| carrier.to_owned()),
        })
    };
    let joint = read();
    if joint.is_none() {
        bad(job, place, &format!("`{}` is no joint", short(part)));
    }
    joint
}

fn link(job: &mut Job<'_>, (part, place): &(&str, Place)) -> Option<Link> {
    let fields: Vec<&str> = part.split(',').collect();
    let read = || {
        let [head, name, mass, moment, x, y, _, rest @ ..] = fields.as_slice() else { return None };
        let kinds = head.as_bytes().get(..2)?;
        let joints = rest.iter().take_while(|id| !id.is_empty()).map(|&id| id.to_owned());
        let link = Link {
            id: head.get(2..)?.to_owned(),
            name: (*name).to_owned(),
            mass: decimal(mass)?,
            moment: decimal(moment)?,
            com: [decimal(x)?, decimal(y)?],
            joints: joints.collect(),
            is_block: kinds[1] == b'P',
        };
        Some((link, kinds[0] == b'Y'))
    };
    let Some((link, is_root)) = read() else {
        bad(job, place, &format!("`{}` is no link", short(part)));
        return None;
    };
    // Parts of welded links are in their roots.
    is_root.then_some(link)
}

fn force(job: &mut Job<'_>, (part, place): &(&str, Place)) -> Option<Force> {
    let fields: Vec<&str> = part.split(',').collect();
    let read = || {
        let [head, link, name, a, b, c, d, size, ..] = fields.as_slice() else { return None };
        let bits = digit_of(*head.as_bytes().first()?)?;
        Some(Force {
            link: (*link).to_owned(),
            name: (*name).to_owned(),
            from: [decimal(a)?, decimal(b)?],
            to: [decimal(c)?, decimal(d)?],
            size: decimal(size)?,
            turns: bits & 1 != 0,
            is_outward: bits & 2 != 0,
        })
    };
    let force = read();
    if force.is_none() {
        bad(job, place, &format!("`{}` is no force", short(part)));
    }
    force
}

struct Linkage<'l, 'a> {
    job: &'l mut Job<'a>,
    names: &'l mut Names,
    draft: Draft,
    joints: Vec<Joint>,
    links: Vec<Link>,
    /// By the ids of links: the body, the origin of its frame and the direction of its x.
    bodies: BTreeMap<String, (usize, Flat, f64)>,
}

impl Linkage<'_, '_> {
    fn place_of(&self, id: &str) -> Option<Flat> {
        self.joints.iter().find(|joint| joint.id == id).map(|joint| joint.at)
    }

    fn all_links(&mut self, whole: &Place) {
        for idx in 0..self.links.len() {
            let link = &self.links[idx];
            let is_ground = |id: &&String| {
                self.joints.iter().any(|joint| &joint.id == *id && joint.is_ground && !joint.slides)
            };
            let missing = link.joints.iter().find(|id| self.place_of(id).is_none()).cloned();
            if let Some(id) = missing {
                let message = format!(
                    "link `{}` has a joint `{}` that is not there",
                    short(&link.name),
                    short(&id)
                );
                bad(self.job, whole, &message);
                return;
            }
            // The frame: from a ground joint, else the first one, to another one.
            let first = link.joints.iter().find(is_ground).or(link.joints.first());
            let origin = first.and_then(|id| self.place_of(id)).unwrap_or(link.com);
            let others = link.joints.iter().filter_map(|id| self.place_of(id));
            let other = others.filter(|at| *at != origin).find(|_| !link.is_block);
            let angle = other.map_or(0.0, |at| (at[1] - origin[1]).atan2(at[0] - origin[0]));
            let com = if link.is_block { [0.0; 2] } else { local(link.com, origin, angle) };
            let tensor = [0.0, 0.0, link.moment, 0.0, 0.0, 0.0];
            let inertia = Inertia { mass: link.mass, com: [com[0], com[1], 0.0], tensor };
            let (id, written, joints) = (link.id.clone(), link.name.clone(), link.joints.clone());
            let com_world = if link.is_block { origin } else { link.com };
            let name = self.names.take("body", &written);
            let body = self.draft.bodies.len();
            self.draft.bodies.push(Body::new(name.clone(), inertia));
            for joint in joints {
                let Some(known) = self.joints.iter().find(|known| known.id == joint) else {
                    continue;
                };
                let at = local(known.at, origin, angle);
                let point = Point {
                    name: known.name.clone(),
                    at: [at[0], at[1], 0.0],
                    axes: crate::draft::Axes::Own,
                };
                let called = crate::names::legal(&known.name, "point");
                if !self.draft.bodies[body].points.iter().any(|other| other.name == called) {
                    self.draft.bodies[body].points.push(Point { name: called, ..point });
                }
            }
            self.bodies.insert(id, (body, origin, angle));
            let [x, y] = com_world.map(number);
            let guess = format!("{{ guess = {{ x = {x}, y = {y}, angle = {} }} }}", number(angle));
            self.draft.initial.push((name, guess));
        }
    }

    /// The point of a link, or of the ground, at a joint.
    fn end(&mut self, link: Option<&str>, joint: usize) -> String {
        let joint = &self.joints[joint];
        let called = crate::names::legal(&joint.name, "point");
        if let Some(&(body, ..)) = link.and_then(|link| self.bodies.get(link)) {
            return format!("{}.{called}", self.draft.bodies[body].name);
        }
        let at = [joint.at[0], joint.at[1], 0.0];
        if !self.draft.ground.iter().any(|point| point.name == called) {
            let axes = crate::draft::Axes::Own;
            self.draft.ground.push(Point { name: called.clone(), at, axes });
        }
        format!("ground.{called}")
    }

    fn all_joints(&mut self) {
        for idx in 0..self.joints.len() {
            let joint = &self.joints[idx];
            let id = joint.id.clone();
            let mut ends: Vec<Option<String>> = Vec::new();
            if joint.is_ground {
                ends.push(None);
            }
            if let Some(carrier) =
                joint.carrier.as_ref().filter(|carrier| self.bodies.contains_key(*carrier))
            {
                ends.push(Some(carrier.clone()));
            }
            let (blocks, bars): (Vec<&Link>, Vec<&Link>) = self
                .links
                .iter()
                .filter(|link| link.joints.contains(&id))
                .partition(|link| link.is_block);
            let of =
                if joint.slides { blocks.iter().chain(&bars) } else { bars.iter().chain(&blocks) };
            for link in of {
                if !ends.contains(&Some(link.id.clone())) {
                    ends.push(Some(link.id.clone()));
                }
            }
            let (slides, angle, written) = (joint.slides, joint.angle, joint.name.clone());
            for (k, end) in ends.iter().enumerate().skip(1) {
                let name = if k == 1 {
                    self.names.take("joint", &written)
                } else {
                    self.names.coin(&format!("{written}_{k}"))
                };
                let first = self.end(ends[0].as_deref(), idx);
                let second = self.end(end.as_deref(), idx);
                let table = if slides && k == 1 {
                    let turn = |link: &Option<String>| {
                        link.as_ref()
                            .and_then(|link| self.bodies.get(link))
                            .map_or(0.0, |body| body.2)
                    };
                    let (along, held) = (angle - turn(&ends[0]), turn(end) - turn(&ends[0]));
                    let axis = format!("[{}, {}]", number(along.cos()), number(along.sin()));
                    let table =
                        Table::new(name, "prismatic").between(&first, &second).key("axis", axis);
                    if held == 0.0 { table } else { table.number("angle", held) }
                } else {
                    Table::new(name, "revolute").between(&first, &second)
                };
                self.draft.joints.push(table);
            }
        }
    }

    /// The input as a drive at the speed of the page.
    fn drive(&mut self, rpm: f64) {
        let Some(input) = self.joints.iter().find(|joint| joint.is_input) else { return };
        let (id, slides, written) = (input.id.clone(), input.slides, input.name.clone());
        let joint = self
            .names
            .renamed
            .iter()
            .find(|renamed| renamed.kind == "joint" && renamed.from == written);
        let joint = joint.map_or(written.clone(), |renamed| renamed.to.clone());
        let driven = self.links.iter().find(|link| link.joints.contains(&id));
        let start = driven.and_then(|link| self.bodies.get(&link.id)).map_or(0.0, |body| body.2);
        let name = self.names.coin(&format!("{joint}_drive"));
        let motion = if slides {
            format!("{} m/s*t", number(rpm))
        } else {
            format!("{} rad + {} rpm*t", number(start), number(rpm))
        };
        let table = Table::plain(name).text("joint", &joint).text("motion", &motion);
        let note = "speed of the page, its sign by the switch for clockwise";
        self.draft.drives.push(table.note(note));
    }

    fn force(&mut self, force: &Force) {
        let Some(&(body, origin, angle)) = self.bodies.get(&force.link) else { return };
        let along = [force.to[0] - force.from[0], force.to[1] - force.from[1]];
        let length = along[0].hypot(along[1]);
        if length == 0.0 {
            return;
        }
        let sign = if force.is_outward { force.size } else { -force.size };
        let vector = along.map(|part| sign * part / length);
        let at = local(force.from, origin, angle);
        let axes = crate::draft::Axes::Own;
        let point = Point { name: String::new(), at: [at[0], at[1], 0.0], axes };
        let on = self.draft.point(Some(body), &force.name, &point);
        let name = self.names.coin(&force.name);
        let shown = if force.turns { local(vector, [0.0; 2], angle) } else { vector };
        let mut table = Table::new(name, "force").text("on", &on).key("vector", list(&shown));
        if force.turns {
            table = table.key("axes", quoted("body"));
        }
        self.draft.loads.push(table);
    }
}

/// A place of the plane in the frame at `origin` whose x has the direction `angle`.
fn local(at: Flat, origin: Flat, angle: f64) -> Flat {
    let turn = Rotation::about([0.0, 0.0, 1.0], -angle);
    let [x, y, _] = turn.apply([at[0] - origin[0], at[1] - origin[1], 0.0]);
    [x, y]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_thousandths_to_the_base_of_64() {
        assert_eq!(decimal("Fe"), Some(1.0));
        assert_eq!(decimal("0RF"), Some(-1.743));
        assert_eq!(decimal("0"), Some(0.0));
        assert_eq!(integer("K"), Some(20.0));
        assert_eq!(decimal("F*"), None);
    }
}
