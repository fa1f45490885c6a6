//! Which bodies meet at a point.
//!
//! A body is met at a point where it has a centre, a corner or an end within the snapping tolerance; if
//! fewer than are needed are met so, those whose outline surrounds the point are, too.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::suggest;

use super::bodies::{Bodies, GROUND};
use super::faults::Faults;
use super::source::Source;
use crate::attachment::{Attachment, Content, Value, Way};
use crate::codes;
use crate::excerpt::short;
use crate::geometry::Point;

/// A way out where more than two bodies are met.
const NAME_TWO: &str = "name the two that are meant: `body1=…` and `body2=…`";

/// The point of an attachment; a fault if it has none.
pub(super) fn point_of(attachment: &Attachment, faults: &mut Faults<'_>) -> Option<Point> {
    if attachment.at.is_none() {
        let message = format!("{} has no place", attachment.title());
        let help = "give its record `at` and a point (1011), or attach it to a circle or a point";
        let fault = Diagnostic::error(codes::NO_PLACE, message).help(help);
        faults.add(fault, &attachment.location);
    }
    attachment.at
}

/// The bodies among which attachments find theirs.
#[derive(Clone, Copy)]
pub(super) struct Partners<'a> {
    pub(super) source: Source<'a>,
    pub(super) bodies: &'a Bodies,
}

impl Partners<'_> {
    /// The body that a key names, or that surrounds the point.
    pub(super) fn body_at(
        &self,
        attachment: &Attachment,
        key: &str,
        at: Point,
        faults: &mut Faults<'_>,
    ) -> Option<usize> {
        if let Some(value) = attachment.value(key) {
            return self.named(value, faults);
        }
        if let Some(owner) = self.own_body(attachment) {
            return Some(owner);
        }
        match self.met_or_around(at).as_slice() {
            [one] => Some(*one),
            // One mistake, one message.
            [] if self.bodies.is_lost(at) => None,
            [] => {
                let [x, y] = at.map(short);
                let message = format!("{} at ({x}, {y}) belongs to no body", attachment.title());
                let fault = Diagnostic::error(codes::NO_BODY_THERE, message)
                    .help(format!("name the body: `{key}=…`"));
                faults.add(fault, &attachment.location);
                None
            }
            many => {
                let help = format!("name the one that is meant: `{key}=…`");
                self.add_ambiguous(attachment, at, many, &help, faults);
                None
            }
        }
    }

    /// The bodies of a pin through more than two, the one that all others turn on first: those that
    /// `bodies` lists, or those that have a centre at the point. `None` for any other joint.
    pub(super) fn pinned(
        &self,
        attachment: &Attachment,
        at: Point,
        faults: &mut Faults<'_>,
    ) -> Option<Vec<usize>> {
        if attachment.kind.name != "revolute" {
            return None;
        }
        if let Some(value) = attachment.value("bodies") {
            return self.listed(attachment, value, faults);
        }
        let names_some = ["body1", "body2", "point1", "point2"];
        if names_some.iter().any(|key| attachment.value(key).is_some()) {
            return None;
        }
        let mut met = self.met_at(at);
        if let Some(own) = self.own_body(attachment).filter(|own| !met.contains(own)) {
            met.push(own);
            met.sort_unstable();
        }
        // A corner nearby says less than a hole: then it is asked which bodies are meant.
        let tolerance = self.source.scale.tolerance;
        let is_pinned = |body_idx: &usize| self.bodies.list[*body_idx].is_pinned_at(at, tolerance);
        (met.len() > 2 && met.iter().all(is_pinned)).then_some(met)
    }

    /// The bodies of a list of names.
    fn listed(
        &self,
        attachment: &Attachment,
        value: &Value,
        faults: &mut Faults<'_>,
    ) -> Option<Vec<usize>> {
        let Content::Text(text) = &value.content else { return None };
        let mut found = Vec::new();
        for name in text.split([',', ';']).map(str::trim).filter(|name| !name.is_empty()) {
            let one = Value { content: Content::Text(name.to_owned()), ..value.clone() };
            found.push(self.named(&one, faults)?);
        }
        let is_twice = |idx: usize| found[..idx].contains(&found[idx]);
        if found.len() < 2 || (0..found.len()).any(is_twice) {
            let message = format!("`bodies` of {} is `{text}`", attachment.title());
            let fault = Diagnostic::error(codes::NO_BODY_THERE, message)
                .help("list two bodies or more, each once: `bodies=crank, rod, lever`");
            faults.add(fault, &value.location);
            return None;
        }
        Some(found)
    }

    /// The two bodies of a joint or of a load between two points, the first one first.
    pub(super) fn pair(
        &self,
        attachment: &Attachment,
        at: [Point; 2],
        faults: &mut Faults<'_>,
    ) -> Option<[usize; 2]> {
        // Bodies that are named come first.
        let stated = ["body1", "body2"].map(|key| attachment.value(key));
        let mut known = [None; 2];
        for (slot, value) in known.iter_mut().zip(stated) {
            if let Some(value) = value {
                *slot = Some(self.named(value, faults)?);
            }
        }

        // With two points each has a body of its own.
        if at[0] != at[1] {
            for (end_idx, slot) in known.iter_mut().enumerate() {
                if slot.is_none() {
                    *slot = Some(self.end_body(attachment, at[end_idx], faults)?);
                }
            }
        }

        // With one point, the bodies that meet there are those that are still missing.
        let pair = match known {
            [Some(first), Some(second)] => [first, second],
            [Some(first), None] => [first, self.other(attachment, at[0], first, faults)?],
            [None, Some(second)] => [self.other(attachment, at[0], second, faults)?, second],
            [None, None] => match self.own_body(attachment) {
                Some(own) => ground_first(own, self.other(attachment, at[0], own, faults)?),
                None => self.pair_at(attachment, at[0], faults)?,
            },
        };
        if pair[0] == pair[1] {
            let name = &self.bodies.list[pair[0]].name;
            let message = format!("{} joins `{name}` to itself", attachment.title());
            let help = "name two bodies: `body1=…` and `body2=…`";
            let fault = Diagnostic::error(codes::NO_BODY_THERE, message).help(help);
            faults.add(fault, &attachment.location);
            return None;
        }
        Some(pair)
    }

    /// The body that a record stands on, unless that is its own marker.
    fn own_body(&self, attachment: &Attachment) -> Option<usize> {
        match attachment.way {
            Way::Xdata(_) => self.bodies.owner(attachment.entity_idx),
            Way::Block | Way::Layer => None,
        }
    }

    /// The body at one end of a spring or a link; the ground where there is none.
    fn end_body(
        &self,
        attachment: &Attachment,
        at: Point,
        faults: &mut Faults<'_>,
    ) -> Option<usize> {
        self.one_or_ground(attachment, at, &self.met_or_around(at), faults)
    }

    /// The second body of a joint whose first is known; the ground where there is none.
    fn other(
        &self,
        attachment: &Attachment,
        at: Point,
        first: usize,
        faults: &mut Faults<'_>,
    ) -> Option<usize> {
        let but_first = |mut found: Vec<usize>| {
            found.retain(|&body_idx| body_idx != first);
            found
        };
        let met = but_first(self.met_at(at));
        let found = if met.is_empty() { but_first(self.around(at)) } else { met };
        self.one_or_ground(attachment, at, &found, faults)
    }

    /// The only one of the bodies that were found, or the ground.
    fn one_or_ground(
        &self,
        attachment: &Attachment,
        at: Point,
        found: &[usize],
        faults: &mut Faults<'_>,
    ) -> Option<usize> {
        match found {
            [] => Some(GROUND),
            [one] => Some(*one),
            many => {
                self.add_ambiguous(attachment, at, many, NAME_TWO, faults);
                None
            }
        }
    }

    /// The two bodies that meet at a point.
    fn pair_at(
        &self,
        attachment: &Attachment,
        at: Point,
        faults: &mut Faults<'_>,
    ) -> Option<[usize; 2]> {
        let mut found = self.met_at(at);
        if found.len() < 2 {
            for body_idx in self.around(at) {
                if !found.contains(&body_idx) {
                    found.push(body_idx);
                }
            }
        }
        match found.as_slice() {
            [] | [GROUND] if self.bodies.is_lost(at) => None,
            [] | [GROUND] => {
                let [x, y] = at.map(short);
                let message = format!("no body meets {} at ({x}, {y})", attachment.title());
                let fault =
                    Diagnostic::error(codes::NO_BODY_THERE, message).help(self.help_to_meet());
                faults.add(fault, &attachment.location);
                None
            }
            [one] => Some([GROUND, *one]),
            [a, b] => Some(ground_first(*a, *b)),
            many => {
                let name = |&body_idx: &usize| self.bodies.list[body_idx].name.as_str();
                let names = many.iter().map(name).collect::<Vec<_>>().join(", ");
                let help = match attachment.kind.name {
                    "revolute" => {
                        format!("{NAME_TWO}, or all that one pin joins: `bodies={names}`")
                    }
                    _ => NAME_TWO.to_owned(),
                };
                self.add_ambiguous(attachment, at, many, &help, faults);
                None
            }
        }
    }

    /// How to draw bodies so that they meet.
    fn help_to_meet(&self) -> String {
        let bodies = self.bodies.list.iter().skip(1);
        let names: Vec<&str> = bodies.map(|body| body.name.as_str()).collect();
        if names.is_empty() {
            return "the drawing has no bodies yet: put the shape of each on a layer of its own, \
                    BK_BODY_name, or BK_BODY inside of it"
                .to_owned();
        }
        format!(
            "draw it where two bodies have a centre, a corner or their shape, or name them: \
             `body1=…` and `body2=…`; bodies are {}",
            names.join(", ")
        )
    }

    /// The body that a value names.
    pub(super) fn named(&self, value: &Value, faults: &mut Faults<'_>) -> Option<usize> {
        let named = self.bodies.named(&value.content, self.source.drawing);
        named
            .map_err(|words| {
                let bodies = self.bodies.list.iter();
                let names: Vec<&str> = bodies.map(|body| body.name.as_str()).collect();
                let name = match &value.content {
                    Content::Text(name) => name.as_str(),
                    _ => "",
                };
                let help = suggest(name, &names);
                let fault = Diagnostic::error(codes::UNKNOWN_PARTNER, words).help(help);
                faults.add_labelled(fault, &value.location, "no body has this name");
            })
            .ok()
    }

    fn add_ambiguous(
        &self,
        attachment: &Attachment,
        at: Point,
        many: &[usize],
        help: &str,
        faults: &mut Faults<'_>,
    ) {
        let name = |&body_idx: &usize| format!("`{}`", self.bodies.list[body_idx].name);
        let names: Vec<String> = many.iter().map(name).collect();
        let [x, y] = at.map(short);
        let message = format!(
            "{} bodies meet {} at ({x}, {y}): {}",
            many.len(),
            attachment.title(),
            names.join(", ")
        );
        let fault = Diagnostic::error(codes::AMBIGUOUS_PARTNERS, message).help(help);
        faults.add(fault, &attachment.location);
    }

    fn met_at(&self, at: Point) -> Vec<usize> {
        self.bodies.met_at(at, self.source.scale.tolerance)
    }

    fn around(&self, at: Point) -> Vec<usize> {
        self.bodies.around(at, self.source.scale.tolerance)
    }

    /// The bodies met at a point; where none is, those around it.
    fn met_or_around(&self, at: Point) -> Vec<usize> {
        let met = self.met_at(at);
        if met.is_empty() { self.around(at) } else { met }
    }
}

/// The ground first, then in the order of the drawing.
fn ground_first(a: usize, b: usize) -> [usize; 2] {
    if b == GROUND { [b, a] } else { [a, b] }
}
