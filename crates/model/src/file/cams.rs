//! `[curves.…]` of type `cam`: the profile that moves a follower by a law, in closed form.
//!
//! ```text
//! point or roller    path of its centre c in the frame of the cam, R(−θ) c(s); the profile of a roller is the
//!                    curve at the distance of its radius inside
//! flat face          the envelope of its lines n · x = h(θ):  x = h n + h′/φ′ t,  φ the angle of n
//! ```
//!
//! The parameter of the curve is the angle θ by which the cam has turned, in its sense.

use bksim_expr::{Expr, Function, Pool};

use super::codes;
use super::reader::{Fields, Reader};
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::{Lowered, PURE, Scalar, Scope};
use crate::curve::{Cam, Curve, FollowerKind};
use crate::diagnostic::Diagnostic;
use crate::ids::{LawId, Vector};

/// The kinds of follower and their keys.
const FOLLOWERS: [(&str, FollowerKind, &[&str]); 3] = [
    ("knife", FollowerKind::Knife, &["kind", "offset", "direction", "arm", "pivot", "sense"]),
    (
        "roller",
        FollowerKind::Roller,
        &["kind", "radius", "offset", "direction", "arm", "pivot", "sense"],
    ),
    ("flat", FollowerKind::Flat, &["kind", "direction", "pivot", "sense"]),
];

/// Senses of turning, with the sign of the angle.
const SENSES: [(&str, i32); 2] = [("counter-clockwise", 1), ("clockwise", -1)];

/// A follower as it is asked for, in the frame of the cam at its angle zero.
struct Asked {
    kind: FollowerKind,
    /// m; zero but of a roller.
    radius: Scalar,
    guide: Guide,
}

/// The way that a follower has.
enum Guide {
    /// Along a direction; the axis of the cam is `offset` to the left of the way of its point.
    Straight { direction: [Expr; 2], offset: Scalar },
    /// About a pivot, outwards in a sense; the point is at the end of an arm, a face goes through the pivot.
    Swing { pivot: [Expr; 2], distance: Scalar, arm: Option<Scalar>, sense: i32 },
}

/// A follower in the plane of the cam, not turned yet.
struct Placed {
    /// Of its point; of a face the foot of the perpendicular from the axis.
    at: [Expr; 2],
    /// Unit vector along which the lift moves it; of a face its normal.
    travel: [Expr; 2],
    /// Of a face: its distance from the axis, m.
    height: Expr,
    /// Of a face: the angle by which it turns with the lift, 0, 1 or −1.
    turning: Expr,
}

impl Reader<'_> {
    /// The profile of a cam.
    pub(super) fn read_cam(&mut self, name: &str, fields: &Fields<'_>) -> Option<Curve> {
        let symbol = self.pool.symbol(&format!("'along {name}"));
        let help = "write for example `base_circle = \"30 mm\"`, its radius";
        let base = fields.require(self, "base_circle", help).and_then(|node| {
            let what = fields.what("base_circle");
            let base = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
            self.check_positive(&what, &base, Quantity::LENGTH).then_some(base)
        });
        let sense = match fields.get("sense") {
            Some(node) => self.choice(node, &fields.what("sense"), &SENSES),
            None => Some(1),
        };
        let help = "write for example `follower = { kind = \"roller\", radius = \"10 mm\" }`";
        let follower = fields
            .require(self, "follower", help)
            .and_then(|node| self.read_follower(fields, node));
        let law = self.law_of(fields, symbol);
        let (base, sense, follower, (law, lift)) = (base?, sense?, follower?, law?);
        self.check_lift(fields, &lift, &follower)?;
        self.check_reach(fields, &base, &follower)?;

        // In terms of a base circle of any size.
        let any_base = self.pool.symbol(&format!("'base {name}"));
        let angle = if sense > 0 { self.pool.neg(symbol) } else { symbol };
        let placed = self.placed(&follower, any_base, lift.expr);
        let pool = &self.pool;
        let (at, travel) = (turned(pool, placed.at, angle), turned(pool, placed.travel, angle));
        let parameter = pool.symbol_id(symbol).expect("a symbol was just made");
        let diff = |e: Expr| pool.diff(e, parameter);
        let (pitch, profile) = match follower.kind {
            FollowerKind::Flat => {
                let across = [pool.neg(travel[1]), travel[0]];
                let of_lift = pool.mul(placed.turning, diff(lift.expr));
                let turning = pool.sub(of_lift, pool.int(i64::from(sense)));
                let contact = pool.div(diff(placed.height), turning);
                let envelope = sum(pool, at, scaled(pool, contact, across));
                (envelope, envelope)
            }
            FollowerKind::Knife => (at, at),
            FollowerKind::Roller => {
                let [x, y] = at.map(diff);
                let speed = pool.sqrt(pool.add(pool.powi(x, 2), pool.powi(y, 2)));
                let inside = pool.div(follower.radius.expr, speed);
                // A cam that turns counter-clockwise is passed clockwise, with its inside on the right.
                let inside = if sense > 0 { inside } else { pool.neg(inside) };
                (at, sum(pool, at, scaled(pool, inside, [y, pool.neg(x)])))
            }
        };

        let is_roller = follower.kind == FollowerKind::Roller;
        let in_space = |[x, y]: [Expr; 2]| -> Vector { [x, y, pool.zero()] };
        let any = pool.symbol_id(any_base).expect("a symbol was just made");
        let at_base = |v: Vector| v.map(|e| pool.substitute(e, &[(any, base.expr)]));
        let cam = Cam {
            law: LawId(law),
            kind: follower.kind,
            base: any,
            base_circle: base.expr,
            roller: is_roller.then_some(follower.radius.expr),
            pitch: in_space(pitch),
            travel: in_space(travel),
            is_clockwise: sense < 0,
            span: base.span.clone(),
        };
        Some(Curve {
            name: name.to_owned(),
            parameter,
            position: at_base(in_space(profile)),
            range: [pool.zero(), pool.mul(pool.int(2), pool.pi())],
            cam: Some(cam),
        })
    }

    /// The law that a cam names, and its value at the angle of the cam.
    fn law_of(&mut self, fields: &Fields<'_>, angle: Expr) -> Option<(usize, Lowered)> {
        let help = "write `law = \"lift\"` with the name of a curve of type `cam-law`";
        let node = fields.require(self, "law", help)?;
        let what = fields.what("law");
        let quoted = self.text_of(node, &what, "lift")?;
        let names: Vec<String> = self.laws.iter().map(|law| law.name.clone()).collect();
        let Some(law) = names.iter().position(|name| name == quoted.text) else {
            // One that could not be read was reported there.
            if self.table_named(quoted.text).is_some_and(|idx| self.tables[idx].form.is_none()) {
                return None;
            }
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let message = format!(
                "{} refers to unknown law `{}`",
                fields.owner,
                super::words::cut(quoted.text)
            );
            let location = quoted.span_of(&(0..quoted.text.len()));
            let label = (location, "no curve of type `cam-law` has this name");
            self.unknown(codes::UNKNOWN_CURVE, message, label, (quoted.text, &names));
            return None;
        };
        let table_idx = self.table_named(quoted.text)?;
        let span = node.span.clone();
        let argument = Lowered { is_angle: true, ..Lowered::new(angle, PURE, None, span.clone()) };
        let lift = self.look_up(table_idx, &[argument], span, &what)?;
        Some((law, lift))
    }

    fn read_follower(&mut self, of: &Fields<'_>, node: &Node) -> Option<Asked> {
        let Value::Table(table) = &node.value else {
            let help = "write for example { kind = \"flat\" }";
            self.wrong_kind(node, &of.what("follower"), "a table", &node.value, help);
            return None;
        };
        let owner = format!("the follower of {}", of.owner);
        let kinds = FOLLOWERS.map(|(word, kind, keys)| (word, (kind, keys)));
        let Some(entry) = table.get("kind") else {
            let fields = Fields::open(self, table, owner, node.span.clone(), FOLLOWERS[1].2);
            fields.require(self, "kind", "write `kind = \"knife\"`, `\"roller\"` or `\"flat\"`");
            return None;
        };
        let (kind, keys) = self.choice(&entry.node, &format!("`kind` of {owner}"), &kinds)?;
        let fields = Fields::open(self, table, owner, node.span.clone(), keys);
        let conflicts =
            [("pivot", "offset"), ("pivot", "direction"), ("offset", "arm"), ("direction", "arm")];
        if conflicts.iter().any(|(one, other)| fields.conflict(self, one, other)) {
            return None;
        }
        let radius = match kind {
            FollowerKind::Roller => self.length_of(&fields, "radius", "10 mm"),
            _ => Some(self.no_length(node)),
        };
        let guide = if ["pivot", "arm", "sense"].iter().any(|key| fields.has(key)) {
            self.read_swing(&fields, kind)
        } else {
            self.read_straight(&fields, node)
        };
        Some(Asked { kind, radius: radius?, guide: guide? })
    }

    fn read_straight(&mut self, fields: &Fields<'_>, node: &Node) -> Option<Guide> {
        let direction = match fields.get("direction") {
            Some(node) => {
                let what = fields.what("direction");
                let angle = self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?.expr;
                [self.pool.cos(angle), self.pool.sin(angle)]
            }
            None => [self.pool.zero(), self.pool.one()],
        };
        let offset = match fields.get("offset") {
            Some(node) => {
                self.scalar(node, Quantity::LENGTH, &fields.what("offset"), Scope::Constant)?
            }
            None => self.no_length(node),
        };
        Some(Guide::Straight { direction, offset })
    }

    fn read_swing(&mut self, fields: &Fields<'_>, kind: FollowerKind) -> Option<Guide> {
        let help = "write for example `pivot = [\"90 mm\", 0]`, where it swings about";
        let pivot = fields.require(self, "pivot", help).and_then(|node| {
            let what = fields.what("pivot");
            let pivot = self.vector(node, Quantity::LENGTH, &what, Scope::Constant)?;
            let value = pivot.position?.value;
            let [x, y, _] = pivot.components;
            let squares = [value[0], value[1]].map(|part| self.constants.multiply(part, part));
            let square = self.constants.add(squares[0], squares[1]);
            let distance = self.constants.call(Function::Sqrt, &[square]);
            let length = self.pool.sqrt(dot(&self.pool, [x, y], [x, y]));
            let distance = Scalar {
                expr: length,
                value: Some(distance),
                is_bare: false,
                span: node.span.clone(),
            };
            let help = "write for example [\"90 mm\", 0]";
            self.reaches(fields, &distance, None, "`pivot` is the axis of the cam", help)
                .then_some(([x, y], distance))
        });
        let arm = match kind {
            FollowerKind::Flat => None,
            _ => Some(self.length_of(fields, "arm", "70 mm")),
        };
        let sense = match fields.get("sense") {
            Some(node) => self.choice(node, &fields.what("sense"), &SENSES),
            None => Some(-1),
        };
        let arm = match arm {
            Some(arm) => Some(arm?),
            None => None,
        };
        let (pivot, distance) = pivot?;
        Some(Guide::Swing { pivot, distance, arm, sense: sense? })
    }

    /// A length that must be there, and positive.
    fn length_of(&mut self, fields: &Fields<'_>, key: &str, example: &str) -> Option<Scalar> {
        let help = format!("write for example `{key} = \"{example}\"`");
        let node = fields.require(self, key, &help)?;
        let what = fields.what(key);
        let length = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
        self.check_positive(&what, &length, Quantity::LENGTH).then_some(length)
    }

    fn no_length(&self, node: &Node) -> Scalar {
        let value = Some(super::replay::Constant::written(0.0));
        Scalar { expr: self.pool.zero(), value, is_bare: false, span: node.span.clone() }
    }

    /// Lifts are lengths of a follower that slides, and angles of one that swings.
    fn check_lift(&mut self, fields: &Fields<'_>, lift: &Lowered, of: &Asked) -> Option<()> {
        let swings = matches!(of.guide, Guide::Swing { .. });
        if lift.is_angle == swings {
            return Some(());
        }
        let (found, way, help) = if swings {
            (
                "lengths",
                "swings",
                "write its rises as angles, \"15 deg\", or take `pivot` from the follower",
            )
        } else {
            (
                "angles",
                "slides",
                "write its rises as lengths, \"20 mm\", or give the follower a `pivot`",
            )
        };
        let message = format!("the lifts of {} are {found}, but its follower {way}", fields.owner);
        self.report(
            Diagnostic::error(codes::WRONG_DIMENSION, message).at(lift.span.clone(), "").help(help),
        );
        None
    }

    /// A follower that can touch its base circle.
    fn check_reach(&mut self, fields: &Fields<'_>, base: &Scalar, of: &Asked) -> Option<()> {
        let sum = |reader: &mut Self, a: &Scalar, b: &Scalar| {
            let value = reader.constants.add(a.value?, b.value?);
            Some(Scalar { value: Some(value), ..a.clone() })
        };
        let centre = sum(self, base, &of.radius)?;
        let holds = match &of.guide {
            Guide::Straight { offset, .. } => {
                let size = self.constants.call(Function::Abs, &[offset.value?]);
                let offset = Scalar { value: Some(size), ..offset.clone() };
                let help = "make the offset smaller than the base circle and the roller together";
                self.reaches(
                    fields,
                    &centre,
                    Some(&offset),
                    "`offset` is beyond the base circle",
                    help,
                )
            }
            Guide::Swing { distance, arm: None, .. } => {
                let help = "put the pivot outside of the base circle";
                self.reaches(
                    fields,
                    distance,
                    Some(base),
                    "`pivot` is inside the base circle",
                    help,
                )
            }
            Guide::Swing { distance, arm: Some(arm), .. } => {
                let help = "an arm from the pivot to a roller on the base circle, with the line from the pivot to the \
                    axis, makes a triangle: change `arm` or `pivot`";
                let message = "the arm does not reach the base circle";
                let sides = [&centre, distance, arm];
                [0, 1, 2].into_iter().all(|k| {
                    let two = sum(self, sides[(k + 1) % 3], sides[(k + 2) % 3]);
                    let two = two.map(|two| Scalar { span: arm.span.clone(), ..two });
                    two.is_some_and(|two| self.reaches(fields, &two, Some(sides[k]), message, help))
                })
            }
        };
        holds.then_some(())
    }

    /// True of a length above another one, or zero; reported where it is not.
    fn reaches(
        &mut self,
        fields: &Fields<'_>,
        long: &Scalar,
        short: Option<&Scalar>,
        message: &str,
        help: &str,
    ) -> bool {
        let zero = super::replay::Constant::written(0.0);
        let least = short.map_or(Some(zero), |short| short.value);
        let (Some(value), Some(least)) = (long.value, least) else { return true };
        if self.constants.is_above(value, least) {
            return true;
        }
        let span = short.map_or(&long.span, |short| &short.span);
        self.report(
            Diagnostic::error(codes::NO_CURVE, format!("{message} in {}", fields.owner))
                .at(span.clone(), "touches nothing")
                .help(help),
        );
        false
    }

    /// The follower at a lift, with the cam not turned.
    fn placed(&self, follower: &Asked, base: Expr, lift: Expr) -> Placed {
        let pool = &self.pool;
        let centre = pool.add(base, follower.radius.expr);
        match &follower.guide {
            Guide::Straight { direction, offset } => {
                let squares = pool.sub(pool.powi(centre, 2), pool.powi(offset.expr, 2));
                let first = if pool.is_zero(offset.expr) { centre } else { pool.sqrt(squares) };
                let right = [direction[1], pool.neg(direction[0])];
                let along = scaled(pool, pool.add(first, lift), *direction);
                Placed {
                    at: sum(pool, scaled(pool, offset.expr, right), along),
                    travel: *direction,
                    height: pool.add(base, lift),
                    turning: pool.zero(),
                }
            }
            Guide::Swing { pivot, distance, arm, sense } => {
                // From the axis to the pivot, and across to the side that the arm turns away from.
                let [distance, lean] = [distance.expr, pool.int(i64::from(*sense))];
                let out = pivot.map(|part| pool.div(part, distance));
                let across = scaled(pool, lean, [pool.neg(out[1]), out[0]]);
                let towards = |angle: Expr| {
                    let [sin, cos] = [pool.sin(angle), pool.cos(angle)];
                    let along = sum(pool, scaled(pool, cos, out), scaled(pool, sin, across));
                    let travel =
                        sum(pool, scaled(pool, sin, out), scaled(pool, pool.neg(cos), across));
                    (scaled(pool, pool.int(-1), along), travel)
                };
                let Some(arm) = arm else {
                    let first = pool.asin(pool.div(base, distance));
                    let angle = pool.add(first, lift);
                    let (_, travel) = towards(angle);
                    let height = pool.mul(distance, pool.sin(angle));
                    return Placed {
                        at: scaled(pool, height, travel),
                        travel,
                        height,
                        turning: lean,
                    };
                };
                let squares = [arm.expr, distance].map(|side| pool.powi(side, 2));
                let squares = pool.sub(pool.add(squares[0], squares[1]), pool.powi(centre, 2));
                let twice = pool.mul(pool.int(2), pool.mul(arm.expr, distance));
                let first = pool.acos(pool.div(squares, twice));
                let (along, travel) = towards(pool.add(first, lift));
                let at = sum(pool, *pivot, scaled(pool, arm.expr, along));
                Placed { at, travel, height: pool.zero(), turning: lean }
            }
        }
    }
}

fn dot(pool: &Pool, a: [Expr; 2], b: [Expr; 2]) -> Expr {
    pool.add(pool.mul(a[0], b[0]), pool.mul(a[1], b[1]))
}

fn scaled(pool: &Pool, factor: Expr, v: [Expr; 2]) -> [Expr; 2] {
    v.map(|part| pool.mul(factor, part))
}

fn sum(pool: &Pool, a: [Expr; 2], b: [Expr; 2]) -> [Expr; 2] {
    [pool.add(a[0], b[0]), pool.add(a[1], b[1])]
}

/// A vector turned counter-clockwise.
fn turned(pool: &Pool, [x, y]: [Expr; 2], angle: Expr) -> [Expr; 2] {
    let [sin, cos] = [pool.sin(angle), pool.cos(angle)];
    [pool.sub(pool.mul(x, cos), pool.mul(y, sin)), pool.add(pool.mul(x, sin), pool.mul(y, cos))]
}
