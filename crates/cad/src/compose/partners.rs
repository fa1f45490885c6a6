//! Which bodies meet at a point.
//!
//! A body is met at a point where it has a centre, a corner or an end within the snapping tolerance; if
//! fewer than are needed are met so, those whose outline surrounds the point are, too.

use bksim_mbs::diagnostic::Diagnostic;
use bksim_mbs::file::suggest;

use super::{Composer, Snap, title};
use crate::attachment::{Attachment, Way};
use crate::codes;
use crate::excerpt::short;
use crate::geometry::Point;
use crate::geometry::vector::distance;

use super::part::find;

/// Centres this many tolerances away look as if they had been meant.
const NEARLY: f64 = 100.0;

impl Composer<'_> {
    /// The point of an attachment; a fault if it has none.
    pub(super) fn point_of(&mut self, attachment: &Attachment) -> Option<Point> {
        if attachment.at.is_none() {
            let message = format!("{} has no place", title(attachment));
            let help =
                "give its record `at` and a point (1011), or attach it to a circle or a point";
            let fault = Diagnostic::error(codes::NO_PLACE, message).help(help);
            self.fault(fault, &attachment.location);
        }
        attachment.at
    }

    /// The body that a key names, or that surrounds the point.
    pub(super) fn body_at(
        &mut self,
        attachment: &Attachment,
        key: &str,
        at: Point,
    ) -> Option<usize> {
        if let Some(value) = find(&attachment.values, key) {
            return self.named(value);
        }
        if let Some(owner) = self.own_body(attachment) {
            return Some(owner);
        }
        let met = self.met_at(at);
        let found = if met.is_empty() { self.around(at) } else { met };
        match found.as_slice() {
            [one] => Some(*one),
            [] => {
                let [x, y] = at.map(short);
                let message = format!("{} at ({x}, {y}) belongs to no body", title(attachment));
                let help = format!("name the body: `{key}=…`");
                self.fault(
                    Diagnostic::error(codes::NO_BODY_THERE, message).help(help),
                    &attachment.location,
                );
                None
            }
            many => {
                self.ambiguous(
                    attachment,
                    at,
                    many,
                    &format!("name the one that is meant: `{key}=…`"),
                );
                None
            }
        }
    }

    /// The two bodies of a joint or of a load between two points, the first one first.
    pub(super) fn partners(
        &mut self,
        attachment: &Attachment,
        at: [Point; 2],
    ) -> Option<[usize; 2]> {
        let stated = ["body1", "body2"].map(|key| find(&attachment.values, key));
        let mut known = [None; 2];
        for (slot, value) in known.iter_mut().zip(stated) {
            if let Some(value) = value {
                *slot = Some(self.named(value)?);
            }
        }
        if at[0] != at[1] {
            for (end_idx, slot) in known.iter_mut().enumerate() {
                if slot.is_none() {
                    *slot = Some(self.end_body(attachment, at[end_idx])?);
                }
            }
        }
        let pair = match known {
            [Some(first), Some(second)] => [first, second],
            [Some(first), None] => [first, self.other(attachment, at[0], first)?],
            [None, Some(second)] => [self.other(attachment, at[0], second)?, second],
            [None, None] => match self.own_body(attachment) {
                Some(own) => ordered(own, self.other(attachment, at[0], own)?),
                None => self.pair_at(attachment, at[0])?,
            },
        };
        if pair[0] == pair[1] {
            let name = &self.parts[pair[0]].name;
            let message = format!("{} joins `{name}` to itself", title(attachment));
            let help = "name two bodies: `body1=…` and `body2=…`";
            let fault = Diagnostic::error(codes::NO_BODY_THERE, message).help(help);
            self.fault(fault, &attachment.location);
            return None;
        }
        Some(pair)
    }

    /// The body that a record stands on, unless that is its own marker.
    fn own_body(&self, attachment: &Attachment) -> Option<usize> {
        match attachment.way {
            Way::Xdata(_) => self.owners[attachment.entity_idx],
            Way::Block | Way::Layer => None,
        }
    }

    /// The body at one end of a spring or a link; the ground where there is none.
    fn end_body(&mut self, attachment: &Attachment, at: Point) -> Option<usize> {
        let met = self.met_at(at);
        let found = if met.is_empty() { self.around(at) } else { met };
        match found.as_slice() {
            [] => Some(0),
            [one] => Some(*one),
            many => {
                let help = "name the two that are meant: `body1=…` and `body2=…`";
                self.ambiguous(attachment, at, many, help);
                None
            }
        }
    }

    /// The second body of a joint whose first is known; the ground where there is none.
    fn other(&mut self, attachment: &Attachment, at: Point, first: usize) -> Option<usize> {
        let but_first = |found: Vec<usize>| -> Vec<usize> {
            found.into_iter().filter(|&part_idx| part_idx != first).collect()
        };
        let met = but_first(self.met_at(at));
        let found = if met.is_empty() { but_first(self.around(at)) } else { met };
        match found.as_slice() {
            [] => Some(0),
            [one] => Some(*one),
            many => {
                let help = "name the two that are meant: `body1=…` and `body2=…`";
                self.ambiguous(attachment, at, many, help);
                None
            }
        }
    }

    /// The two bodies that meet at a point.
    fn pair_at(&mut self, attachment: &Attachment, at: Point) -> Option<[usize; 2]> {
        let mut found = self.met_at(at);
        if found.len() < 2 {
            for part_idx in self.around(at) {
                if !found.contains(&part_idx) {
                    found.push(part_idx);
                }
            }
        }
        match found.as_slice() {
            [] | [0] => {
                let [x, y] = at.map(short);
                let message = format!("no body meets {} at ({x}, {y})", title(attachment));
                let names: Vec<&str> =
                    self.parts.iter().skip(1).map(|part| part.name.as_str()).collect();
                let help = if names.is_empty() {
                    "the drawing has no bodies yet: put the shape of each on a layer of its own, \
                     BK_BODY_name, or BK_BODY inside of it"
                        .to_owned()
                } else {
                    format!(
                        "draw it where two bodies have a centre, a corner or their shape, or name \
                         them: `body1=…` and `body2=…`; bodies are {}",
                        names.join(", ")
                    )
                };
                let fault = Diagnostic::error(codes::NO_BODY_THERE, message).help(help);
                self.fault(fault, &attachment.location);
                None
            }
            [one] => Some([0, *one]),
            [a, b] => Some(ordered(*a, *b)),
            many => {
                let help = "name the two that are meant: `body1=…` and `body2=…`; a pin through \
                            three bodies is two joints";
                self.ambiguous(attachment, at, many, help);
                None
            }
        }
    }

    fn named(&mut self, value: &crate::attachment::Value) -> Option<usize> {
        match self.named_body(&value.content) {
            Ok(part_idx) => Some(part_idx),
            Err(words) => {
                let names: Vec<&str> = self.parts.iter().map(|part| part.name.as_str()).collect();
                let word = match &value.content {
                    crate::attachment::Content::Text(name) => name.as_str(),
                    _ => "",
                };
                let fault =
                    Diagnostic::error(codes::UNKNOWN_PARTNER, words).help(suggest(word, &names));
                self.fault_at(fault, &value.location, "no body has this name");
                None
            }
        }
    }

    fn ambiguous(&mut self, attachment: &Attachment, at: Point, many: &[usize], help: &str) {
        let names: Vec<String> =
            many.iter().map(|&part_idx| format!("`{}`", self.parts[part_idx].name)).collect();
        let [x, y] = at.map(short);
        let message = format!(
            "{} bodies meet {} at ({x}, {y}): {}",
            many.len(),
            title(attachment),
            names.join(", ")
        );
        let fault = Diagnostic::error(codes::AMBIGUOUS_PARTNERS, message).help(help);
        self.fault(fault, &attachment.location);
    }

    /// Parts with a feature at a point, in their order.
    fn met_at(&self, at: Point) -> Vec<usize> {
        let is_met = |part_idx: &usize| {
            let features = &self.parts[*part_idx].features;
            features.iter().any(|feature| distance(*feature, at) <= self.tolerance)
        };
        (0..self.parts.len()).filter(is_met).collect()
    }

    /// Bodies whose outer outline surrounds a point or passes through it, in their order.
    fn around(&self, at: Point) -> Vec<usize> {
        let surrounds = |part_idx: &usize| {
            let outline = self.parts[*part_idx].outline.as_ref();
            outline.is_some_and(|outline| {
                outline.outer_contains(at) || outline.distance(at) <= self.tolerance
            })
        };
        (0..self.parts.len()).filter(surrounds).collect()
    }

    /// Lists what is taken as one point though it is drawn as two, and what is nearly one.
    pub(super) fn snap(&mut self, attachment: &Attachment, at: Point, part_idx: usize) {
        let part = &self.parts[part_idx];
        let mut near: Vec<(f64, Point)> = part
            .features
            .iter()
            .map(|&feature| (distance(feature, at), feature))
            .filter(|(away, _)| *away <= NEARLY * self.tolerance)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.dedup_by(|a, b| distance(a.1, b.1) <= self.step);
        let Some(&(away, feature)) = near.first() else { return };
        let name = part.name.clone();
        let title = title(attachment);
        let [x, y] = at.map(short);
        let [fx, fy] = feature.map(short);
        let unit = self.drawing.unit.name;
        if away > self.tolerance {
            if !self.is_centre(part_idx, feature) {
                return;
            }
            let message = format!(
                "a centre of `{name}` at ({fx}, {fy}) is {} {unit} away from {title} at ({x}, {y})",
                short(away)
            );
            let help = format!(
                "nothing was moved; move one onto the other, or take them as one point with \
                 `--tolerance {}`",
                short(away * 1.1)
            );
            self.fault(
                Diagnostic::warning(codes::NOT_SNAPPED, message).help(help),
                &attachment.location,
            );
            return;
        }
        if let Some((next, second)) = near.get(1).filter(|(away, _)| *away <= self.tolerance) {
            let [sx, sy] = second.map(short);
            let message = format!(
                "two points of `{name}`, ({fx}, {fy}) and ({sx}, {sy}), are within {} {unit} of \
                 {title} at ({x}, {y})",
                short(self.tolerance)
            );
            let help = format!(
                "take a smaller tolerance, `--tolerance {}`, or remove one of the points",
                short(f64::midpoint(away, *next))
            );
            self.fault(
                Diagnostic::error(codes::AMBIGUOUS_SNAP, message).help(help),
                &attachment.location,
            );
            return;
        }
        if away > self.step {
            let snap = Snap { what: title, body: name, from: feature, to: at, distance: away };
            let message = format!(
                "`{}` at ({fx}, {fy}) and {} at ({x}, {y}) are {} {unit} apart: taken as one point",
                snap.body,
                snap.what,
                short(away)
            );
            let help = super::shapes::apart(away);
            self.fault(
                Diagnostic::warning(codes::JOINT_SNAPPED, message).help(help),
                &attachment.location,
            );
            self.snaps.push(snap);
        }
    }
}

/// The ground first, then in the order of the drawing.
fn ordered(a: usize, b: usize) -> [usize; 2] {
    if b == 0 { [b, a] } else { [a, b] }
}
