//! `clearance` of a pin or slide: its joint holds nothing, and contacts keep journal and bush, or slide and guide, together.
//!
//! ```text
//! pin     a disc of `radius` about the second point in a ring of radius + clearance about the first
//! slide   the corners (± length/2, ± width/2) about the second point between lines at ± (width/2 + clearance)
//! ```

use bksim_expr::Expr;

use super::bodies::BodyFacts;
use super::codes;
use super::play::{CLEARANCE, Form, Play, SIDES};
use super::reader::{Fields, Reader};
use super::units::Quantity;
use super::value::Scope;
use crate::body::{Anchor, Body, FixedTurn, Point};
use crate::contact::{EdgesForm, Round, Shape};
use crate::diagnostic::Diagnostic;
use crate::ids::{PointId, Vector};
use crate::joint::{Joint, motion_words};
use crate::measure::{Initial, Measure};

/// Keys of play, which need a clearance.
const PLAY_KEYS: [&str; 6] = ["radius", "length", "width", "mu", "static", "restitution"];

impl Reader<'_> {
    /// Refuses keys of play where there is none, and those that play has no use for.
    pub(super) fn check_play(&mut self, fields: &Fields<'_>) {
        if fields.has(CLEARANCE) {
            for key in ["second", "armature", "cut"] {
                fields.conflict(self, CLEARANCE, key);
            }
            return;
        }
        for key in PLAY_KEYS {
            let Some(entry) = fields.entry(key) else { continue };
            let message = format!("{} has `{key}` and no `clearance`", fields.owner);
            self.report(
                Diagnostic::error(codes::NO_PLAY, message)
                    .at(entry.key_span.clone(), "of a joint with play only")
                    .help(format!("remove `{key}`, or write for example `clearance = \"0.1 mm\"`")),
            );
        }
    }

    /// The play of a joint with a clearance; `axis` is that of its type.
    pub(super) fn play(
        &mut self,
        name: &str,
        word: &str,
        fields: &Fields<'_>,
        ends: [Anchor; 2],
        axis: Vector,
    ) -> Option<Play> {
        let clearance = self.positive(fields, CLEARANCE, None)?;
        let (restitution, friction) = self.surfaces_of_joint(fields)?;
        let zero = self.pool.zero();
        let form = if word == "revolute" {
            let radius = if fields.has("radius") || friction.is_some() {
                // Friction turns the bodies by the radius where it acts.
                let help = "that of the journal, `radius = \"10 mm\"`";
                self.positive(fields, "radius", Some(help))?
            } else {
                zero
            };
            Form::Pin { radius, clearance }
        } else {
            let help = "that of the slide along its axis, `length = \"60 mm\"`";
            let length = self.positive(fields, "length", Some(help))?;
            let width =
                if fields.has("width") { self.positive(fields, "width", None)? } else { zero };
            let angle = match fields.get("angle") {
                Some(node) => {
                    self.scalar(node, Quantity::ANGLE, &fields.what("angle"), Scope::Constant)?.expr
                }
                None => zero,
            };
            let back =
                FixedTurn { axis: [zero, zero, self.pool.one()], angle: self.pool.neg(angle) };
            let axes = [axis, self.turned(&[back], axis)];
            Form::Slide { length, width, clearance, angle, axes }
        };
        let span = fields.entry(CLEARANCE)?.key_span.clone();
        Some(Play { name: name.to_owned(), ends, form, restitution, friction, span })
    }

    /// Restitution and friction of what contacts hold.
    pub(super) fn surfaces_of_joint(
        &mut self,
        fields: &Fields<'_>,
    ) -> Option<(Expr, Option<[Expr; 2]>)> {
        let restitution = match fields.get("restitution") {
            Some(node) => self.restitution(node, &fields.what("restitution"))?,
            None => self.pool.zero(),
        };
        let rubs = fields.has("mu") || fields.has("static");
        let friction = if rubs { Some(self.coefficients(fields)?) } else { None };
        Some((restitution, friction))
    }

    /// Turns the frames of slides that are along neither x nor y: their coordinates are along the slide and across.
    pub(super) fn turn_slides(
        &mut self,
        bodies: &mut [(Option<Body>, BodyFacts)],
        joints: &mut [Option<Joint>],
    ) {
        for play in self.plays.clone() {
            let Form::Slide { axes: [axis @ [x, y, _], _], .. } = play.form else { continue };
            let joint = self.names.joint(&play.name).and_then(|id| joints[id.0].as_mut());
            let Some(joint) = joint.filter(|_| !self.pool.is_zero(x) && !self.pool.is_zero(y))
            else {
                continue;
            };
            let zero = self.pool.zero();
            let turn =
                FixedTurn { axis: [zero, zero, self.pool.one()], angle: self.pool.atan2(y, x) };
            let [predecessor, successor] = play.ends.map(|end| {
                let place = self.point_along(bodies, end, axis, [zero, zero], &play.name);
                let body = bodies[place.body.0].0.as_mut();
                let point = body.zip(place.point).and_then(|(body, id)| body.points.get_mut(id.0));
                if let Some(point) = point {
                    point.orientation.push(turn);
                }
                place
            });
            (joint.predecessor, joint.successor) = (predecessor, successor);
        }
    }

    /// Starts joints with play in the middle of it and without motion in it, unless the author states where they, or
    /// the bodies, are: the contacts alone would leave the mechanism open.
    pub(super) fn start_in_play(&self, initial: &mut Vec<Initial>) {
        for play in &self.plays {
            let Some(joint) = self.names.joint(&play.name) else { continue };
            let motions = self.names.joints[joint.0].freedoms.unwrap_or_default();
            let zero = self.pool.zero();
            let is_zero = |axis: Expr| self.pool.is_zero(axis);
            let middle: Vec<(usize, Expr)> = match play.form {
                Form::Curve(_) => continue,
                Form::Pin { .. } => vec![(0, zero), (1, zero)],
                Form::Slide { angle, axes: [[x, ..], _], .. } => {
                    let across = usize::from(!is_zero(x));
                    vec![(across, zero), (2, angle)]
                }
            };
            let bodies = play.ends.map(|end| end.body);
            let is_known = |of: &Initial, is_rate: bool| match of.measure {
                Measure::JointPosition(id, _) => !is_rate && id == joint,
                Measure::JointVelocity(id, _) => is_rate && id == joint,
                Measure::PointPosition(body, ..) => {
                    !is_rate && !of.is_guess && bodies.contains(&body)
                }
                Measure::PointVelocity(body, ..) => {
                    is_rate && !of.is_guess && bodies.contains(&body)
                }
                _ => false,
            };
            for is_rate in [false, true] {
                if initial.iter().any(|of| is_known(of, is_rate)) {
                    continue;
                }
                initial.extend(middle.iter().map(|&(motion_idx, value)| {
                    let words = motion_words(motions, motion_idx);
                    let (measure, word) = if is_rate {
                        (Measure::JointVelocity(joint, motion_idx), words[1])
                    } else {
                        (Measure::JointPosition(joint, motion_idx), words[0])
                    };
                    let value = if is_rate { zero } else { value };
                    let name = format!("{}.{word}", play.name);
                    Initial { measure, value, is_guess: false, name, span: play.span.clone() }
                }));
            }
        }
    }

    /// A length greater than zero; `help` says what to write where it is missing.
    fn positive(&mut self, fields: &Fields<'_>, key: &str, help: Option<&str>) -> Option<Expr> {
        let help = format!("write {}", help.unwrap_or("a length"));
        let node = fields.require(self, key, &help)?;
        let what = fields.what(key);
        let value = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
        self.check_positive(&what, &value, Quantity::LENGTH).then_some(value.expr)
    }

    /// A vector of the plane after turns about its normal.
    fn turned(&self, turns: &[FixedTurn], [x, y, z]: Vector) -> Vector {
        let pool = &self.pool;
        let angle = turns
            .iter()
            .fold(pool.zero(), |sum, turn| pool.add(sum, pool.mul(turn.axis[2], turn.angle)));
        let [sin, cos] = [pool.sin(angle), pool.cos(angle)];
        let along = pool.sub(pool.mul(cos, x), pool.mul(sin, y));
        [along, pool.add(pool.mul(sin, x), pool.mul(cos, y)), z]
    }

    /// The pairs of shapes that keep a joint with play together, by the names of their contacts; what they need of
    /// points is added to the bodies.
    pub(super) fn shapes_of_play(
        &mut self,
        play: &Play,
        bodies: &mut [(Option<Body>, BodyFacts)],
    ) -> Vec<(String, [Shape; 2])> {
        let [first, second] = play.ends;
        let (length, width, clearance, axes) = match play.form {
            Form::Curve(joint) => {
                let on_it = Round { center: second, radius: self.pool.zero() };
                let curve = Shape::Curve { joint, anchor: first };
                return vec![(play.name.clone(), [curve, Shape::Round(on_it)])];
            }
            Form::Pin { radius, clearance } => {
                let bush = Round { center: first, radius: self.pool.add(radius, clearance) };
                let journal = Round { center: second, radius };
                return vec![(play.name.clone(), [Shape::Ring(bush), Shape::Round(journal)])];
            }
            Form::Slide { length, width, clearance, axes, .. } => (length, width, clearance, axes),
        };
        let half = self.pool.div(length, self.pool.int(2));
        let aside = self.pool.div(width, self.pool.int(2));
        let beyond = self.pool.add(aside, clearance);
        let mut pairs = Vec::new();
        for (side, sign) in SIDES {
            let signed = |value: Expr| if sign < 0 { self.pool.neg(value) } else { value };
            // What slides is to the left of its guide.
            let [guide, corner] = [signed(beyond), signed(aside)];
            let ends = [signed(half), self.pool.neg(signed(half))];
            let name = format!("{}_{side}", play.name);
            let guide =
                ends.map(|along| self.point_along(bodies, first, axes[0], [along, guide], &name));
            let corners =
                ends.map(|along| self.point_along(bodies, second, axes[1], [along, corner], &name));
            let shapes = [
                Shape::Edges { corners: guide.to_vec(), form: EdgesForm::Line },
                Shape::Edges { corners: corners.to_vec(), form: EdgesForm::Chain },
            ];
            pairs.push((name, shapes));
        }
        pairs
    }

    /// A new point of a body, by its way along an axis and to the left of it from another one.
    fn point_along(
        &mut self,
        bodies: &mut [(Option<Body>, BodyFacts)],
        from: Anchor,
        axis: Vector,
        [along, left]: [Expr; 2],
        name: &str,
    ) -> Anchor {
        let (body, facts) = &mut bodies[from.body.0];
        let zero = self.pool.zero();
        let of = body.as_ref().zip(from.point).and_then(|(body, point)| body.points.get(point.0));
        let (position, orientation) =
            of.map_or(([zero; 3], Vec::new()), |point| (point.position, point.orientation.clone()));
        let [x, y, _] = self.turned(&orientation, axis);
        let pool = &self.pool;
        let at = |k: usize, along_axis: Expr, across: Expr| {
            pool.add(position[k], pool.add(pool.mul(along, along_axis), pool.mul(left, across)))
        };
        let position = [at(0, x, pool.neg(y)), at(1, y, x), position[2]];
        let names = &mut self.names.bodies[from.body.0].points;
        let id = PointId(names.len());
        let name = format!("{name}_{}", id.0);
        names.push(name.clone());
        facts.points.push(None);
        if let Some(body) = body {
            body.points.push(Point { name, position, orientation });
        }
        Anchor { body: from.body, point: Some(id) }
    }
}
