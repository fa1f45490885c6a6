//! `[contacts.…]`: outlines of two bodies that touch, push each other apart, and rub.

use bksim_expr::Expr;

use super::bodies::BodyFacts;
use super::codes;
use super::places::{Points, cross, places_of};
use super::reader::{Fields, Reader};
use super::tangent_planes::rows_in_space;
use super::tree::{Node, Table, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::body::{Anchor, Body, Space};
use crate::contact::{ContactPair, EdgesForm, Round, Shape};
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::{BodyId, ContactId};
use crate::load::{Load, LoadKind, Opposed};

/// Keys of a contact.
pub(super) const CONTACT_KEYS: [&str; 5] = ["between", "mu", "static", "rolling", "restitution"];
/// Keys of a shape that is no point.
const SHAPE_KEYS: [&str; 11] = [
    "disc", "ring", "line", "edges", "outline", "ball", "bowl", "points", "plane", "radius",
    "normal",
];
/// How many of them name a shape.
const N_KINDS: usize = 9;
/// How shapes are written.
const SHAPES: &str = "write a point `\"rod.A\"`, `{ disc = \"ball.C\", radius = \"40 mm\" }`, a `ring` of the same form, or \
                      `{ line = [\"ground.A\", \"ground.B\"] }`, `edges` or an `outline` of points; in space a point, \
                      `{ ball = \"ball.C\", radius = \"40 mm\" }`, a `bowl` of the same form, `{ plane = \"ground.A\" }` or \
                      `points`";
/// Places that one contact may have.
const MOST_PLACES: usize = 200;

impl Reader<'_> {
    /// Reads all contacts, in file order; their rows become loads after those of the author.
    pub(super) fn read_contacts(
        &mut self,
        root: &Table,
        bodies: &mut [(Option<Body>, BodyFacts)],
        loads: &mut Vec<Load>,
    ) -> Vec<ContactPair> {
        let plays = self.plays.clone();
        let of_joints: Vec<_> = plays
            .iter()
            .flat_map(|play| {
                self.shapes_of_play(play, bodies).into_iter().map(move |of| (play, of))
            })
            .collect();
        let points = |anchor: Anchor| {
            let point = anchor.point.and_then(|point| bodies[anchor.body.0].1.points.get(point.0));
            point.copied().flatten().map_or([0.0; 2], |at| [at[0], at[1]])
        };
        let mut pairs: Vec<ContactPair> = Vec::new();
        for (name, span, table) in self.own_tables(root, "contact") {
            self.usable_name(name, &span, "contact");
            if self.is_load(loads, name, &span, "contact") {
                continue;
            }
            let fields =
                Fields::open(self, table, format!("contact `{name}`"), span, &CONTACT_KEYS);
            let id = ContactId(pairs.len());
            if let Some((pair, rows)) = self.read_contact(name, &fields, id, &points) {
                loads.extend(rows);
                pairs.push(pair);
            }
        }
        for (play, (name, shapes)) in of_joints {
            if let Some(pair) = pairs.iter().find(|pair| pair.name == name) {
                let message = format!("`{name}` is a contact and that of joint `{}`", play.name);
                self.report(
                    Diagnostic::error(codes::DUPLICATE, message)
                        .at(play.span.clone(), "the same name again")
                        .at(pair.span.clone(), "the contact")
                        .help(format!("rename the contact, for example `{name}_contact`")),
                );
            } else if !self.is_load(loads, &name, &play.span, "load") {
                let (places, tracks) = places_of(&shapes, &points, self.pool.zero());
                let (play_of, span) = (self.names.joint(&play.name), play.span.clone());
                let pair = ContactPair { name, shapes, places, tracks, play_of, span };
                loads.extend(rows_of(
                    &pair,
                    ContactId(pairs.len()),
                    play.restitution,
                    play.friction,
                    None,
                ));
                pairs.push(pair);
            }
        }
        pairs
    }

    /// Reports a contact that has the name of a load; one of this `kind` is to be renamed.
    fn is_load(&mut self, loads: &[Load], name: &str, span: &Span, kind: &str) -> bool {
        let Some(load) = loads.iter().find(|load| load.name == name) else { return false };
        let message = format!("`{name}` is a load and a contact");
        self.report(
            Diagnostic::error(codes::DUPLICATE, message)
                .at(span.clone(), "the same name again")
                .at(load.span.clone(), "the load")
                .help(format!("rename the {kind}, for example `{name}_{kind}`")),
        );
        true
    }

    /// Outlines are in a plane, surfaces in space.
    pub(super) fn check_space_of_contacts(&mut self, space: Space, contacts: &[ContactPair]) {
        let zero = self.pool.zero();
        let is_other = |pair: &&ContactPair| {
            let mut spaces = pair.shapes.iter().filter_map(|shape| shape.is_spatial(zero));
            spaces.any(|is_spatial| is_spatial != (space == Space::Spatial))
        };
        let Some(pair) = contacts.iter().find(is_other) else { return };
        if space == Space::Planar {
            let message =
                format!("contact `{}` is of surfaces in space, the model is planar", pair.name);
            self.report(
                Diagnostic::error(codes::SURFACE_IN_PLANE, message)
                    .at(pair.span.clone(), "these touch in space alone")
                    .help("make the model spatial, or use a `disc`, `ring` or `line`"),
            );
            return;
        }
        let message = format!("contact `{}` is in a spatial model", pair.name);
        let help = if matches!(pair.shapes[0], Shape::Curve { .. }) {
            "remove `lifts`, or keep to the plane"
        } else if pair.play_of.is_some() {
            "remove `clearance`, or keep to the plane"
        } else {
            "use a `ball`, `bowl` or `plane`, or `points` of the body that touch, or keep to the plane"
        };
        self.report(
            Diagnostic::error(codes::CONTACT_IN_SPACE, message)
                .at(pair.span.clone(), "outlines touch in a plane alone")
                .help(help),
        );
    }

    fn read_contact(
        &mut self,
        name: &str,
        fields: &Fields<'_>,
        id: ContactId,
        points: Points<'_>,
    ) -> Option<(ContactPair, Vec<Load>)> {
        let restitution = match fields.get("restitution") {
            None => Some(self.pool.zero()),
            Some(node) => self.restitution(node, &fields.what("restitution")),
        };
        let friction = if fields.has("mu") || fields.has("static") {
            Some(self.coefficients(fields)?)
        } else {
            None
        };
        let rolling = match fields.get("rolling") {
            Some(node) => Some(self.friction(fields, "rolling", node, Quantity::LENGTH)?.expr),
            None => None,
        };
        let help = format!("write two shapes, `between = [A, B]`: {SHAPES}");
        let node = fields.require(self, "between", &help)?;
        let what = fields.what("between");
        let nodes =
            self.array(node, &what, "an array of two shapes", "[\"rod.A\", \"ground.B\"]")?;
        let [first, second] = nodes else {
            self.wrong_kind(node, &what, "an array of two shapes", &node.value, &help);
            return None;
        };
        let shapes = [first, second].map(|node| self.shape(node, fields, points));
        let [first, second] = shapes;
        let shapes = [first?, second?];
        let bodies = [0, 1].map(|k| shapes[k].anchors()[0].body);
        if bodies[0] == bodies[1] {
            let body = self.names.bodies[bodies[0].0].name.clone();
            let message = format!("contact `{name}` is between parts of one body, `{body}`");
            self.report(
                Diagnostic::error(codes::SELF_CONTACT, message)
                    .at(node.span.clone(), "these do not move against each other")
                    .help("name a shape of another body, or of the ground"),
            );
            return None;
        }
        let span = node.span.clone();
        let (places, tracks) = places_of(&shapes, points, self.pool.zero());
        let spaces = [0, 1].map(|k| shapes[k].is_spatial(self.pool.zero()));
        if let [Some(first), Some(second)] = spaces
            && first != second
        {
            let message = format!("contact `{name}` is of a shape in the plane and one in space");
            self.report(
                Diagnostic::error(codes::SURFACE_IN_PLANE, message)
                    .at(span, "these never meet")
                    .help("in space, use a `ball` for a `disc`, a `bowl` for a `ring` and a `plane` for a `line`"),
            );
            return None;
        }
        if places.is_empty() {
            let message = format!("the two shapes of contact `{name}` cannot touch");
            self.report(
                Diagnostic::error(codes::NO_TOUCH, message)
                    .at(span, "two points, two lines, or two rings")
                    .help("give one of them another shape, for example a point a `disc` with a radius"),
            );
            return None;
        }
        if places.len() > MOST_PLACES {
            let message = format!(
                "contact `{name}` has {} places where corners can meet edges, more than {MOST_PLACES}",
                places.len()
            );
            self.report(
                Diagnostic::error(codes::MANY_PLACES, message)
                    .at(span, "outlines with many corners")
                    .help("use fewer corners, a `disc`, or only the `edges` that can touch"),
            );
            return None;
        }
        let is_disc = |shape: &Shape| matches!(shape, Shape::Round(round) if round.radius != self.pool.zero());
        if rolling.is_some() && !shapes.iter().any(is_disc) {
            let message = format!("contact `{name}` has `rolling` and no disc");
            let help = if spaces.contains(&Some(true)) {
                "remove `rolling`, which is for discs in the plane"
            } else {
                "remove `rolling`, or give one of them the shape of a `disc` with a radius"
            };
            self.report(
                Diagnostic::error(codes::NO_DISC, message)
                    .at(span, "neither of these rolls")
                    .help(help),
            );
            return None;
        }
        let restitution = restitution?;
        let name = name.to_owned();
        let pair = ContactPair { name, shapes, places, tracks, play_of: None, span };
        let rows = if pair.is_spatial(self.pool.zero()) {
            rows_in_space(&pair, id, restitution, friction)
        } else {
            rows_of(&pair, id, restitution, friction, rolling)
        };
        Some((pair, rows))
    }

    /// A point as text, or a shape as a table.
    fn shape(&mut self, node: &Node, fields: &Fields<'_>, points: Points<'_>) -> Option<Shape> {
        let what = fields.what("between");
        let Value::Table(table) = &node.value else {
            if !matches!(node.value, Value::Text(_)) {
                self.wrong_kind(node, &what, "a shape", &node.value, SHAPES);
                return None;
            }
            let center = self.point_of_shape(node, &what, fields)?;
            return Some(Shape::Round(Round { center, radius: self.pool.zero() }));
        };
        let owner = format!("a shape of {}", fields.owner);
        let own = Fields::open(self, table, owner, node.span.clone(), &SHAPE_KEYS);
        let kinds: Vec<&str> =
            SHAPE_KEYS[..N_KINDS].iter().copied().filter(|key| own.has(key)).collect();
        if let [one, other, ..] = kinds[..] {
            own.conflict(self, one, other);
            return None;
        }
        let Some(&kind) = kinds.first() else {
            own.require(self, "outline", SHAPES);
            return None;
        };
        let node = own.get(kind)?;
        let is_round = matches!(kind, "disc" | "ring" | "ball" | "bowl");
        let unfit = [
            ("radius", is_round, "disc, ring, ball or bowl"),
            ("normal", kind == "plane", "plane"),
        ];
        for (key, fits, forms) in unfit {
            if let Some(entry) = own.entry(key).filter(|_| !fits) {
                let message = format!("{} has a `{key}` and is no {forms}", own.owner);
                self.report(
                    Diagnostic::error(codes::KEY_CONFLICT, message)
                        .at(entry.key_span.clone(), "of no meaning here")
                        .help(format!("remove it, or name a {forms}")),
                );
                return None;
            }
        }
        if kind == "plane" {
            return self.flat(node, &own);
        }
        if is_round {
            let center = self.point_of_shape(node, &own.what(kind), fields);
            let radius = own.require(self, "radius", "write for example `radius = \"40 mm\"`")?;
            let what = own.what("radius");
            let radius = self.scalar(radius, Quantity::LENGTH, &what, Scope::Constant)?;
            let is_good = self.check_positive(&what, &radius, Quantity::LENGTH);
            let round = Round { center: center?, radius: radius.expr };
            let shape = match kind {
                "disc" => Shape::Round(round),
                "ring" => Shape::Ring(round),
                "ball" => Shape::Ball(round),
                _ => Shape::Bowl(round),
            };
            return is_good.then_some(shape);
        }
        self.edges(kind, node, &own, fields, points)
    }

    fn edges(
        &mut self,
        kind: &str,
        node: &Node,
        own: &Fields<'_>,
        fields: &Fields<'_>,
        points: Points<'_>,
    ) -> Option<Shape> {
        let what = own.what(kind);
        let nodes = self.array(node, &what, "an array of points", "[\"box.A\", \"box.B\"]")?;
        let (form, fewest) = match kind {
            "points" => (EdgesForm::Chain, 1),
            "line" => (EdgesForm::Line, 2),
            "edges" => (EdgesForm::Chain, 2),
            _ => (EdgesForm::Outline, 3),
        };
        let corners: Vec<Option<Anchor>> =
            nodes.iter().map(|node| self.point_of_shape(node, &what, fields)).collect();
        let mut corners = corners.into_iter().collect::<Option<Vec<Anchor>>>()?;
        let wrong = |message: String, label: &str, help: &str| {
            Diagnostic::error(codes::BAD_SHAPE, message).at(node.span.clone(), label).help(help)
        };
        if corners.len() < fewest || form == EdgesForm::Line && corners.len() > 2 {
            let message = format!("{what} has {} points", corners.len());
            let help = match form {
                _ if kind == "points" => "give one point at least",
                EdgesForm::Line => "give two points of the line; what touches it is to its left",
                EdgesForm::Chain => {
                    "give two points at least, in order; what touches them is to their left"
                }
                EdgesForm::Outline => "give three corners at least, in order",
            };
            self.report(wrong(message, "not this number", help));
            return None;
        }
        if let Some(other) = corners.iter().find(|corner| corner.body != corners[0].body) {
            let names =
                [corners[0].body, other.body].map(|BodyId(k)| self.names.bodies[k].name.clone());
            let message = format!("{what} has points of `{}` and of `{}`", names[0], names[1]);
            self.report(wrong(
                message,
                "a shape belongs to one body",
                "take all points from one body",
            ));
            return None;
        }
        if kind == "points" {
            return Some(Shape::Points(corners));
        }
        let at: Vec<[f64; 2]> = corners.iter().map(|&corner| points(corner)).collect();
        let n = at.len();
        let n_edges = if form == EdgesForm::Outline { n } else { n - 1 };
        let equal = (0..n_edges).find(|&k| at[k] == at[(k + 1) % n]);
        if equal.is_some() {
            let message = format!("{what} has an edge of no length");
            let help = "give points that are apart, each once; an outline closes by itself";
            self.report(wrong(message, "two points at one place", help));
            return None;
        }
        if form == EdgesForm::Outline {
            let area: f64 = (0..n).map(|k| cross(at[k], at[(k + 1) % n])).sum();
            if area == 0.0 {
                let message = format!("{what} encloses no area");
                let help = "give at least three corners that are not in one line, in order";
                self.report(wrong(message, "encloses nothing", help));
                return None;
            }
            // The outside to the left.
            if area > 0.0 {
                corners.reverse();
            }
        }
        Some(Shape::Edges { corners, form })
    }

    /// A named point of a body or of the ground.
    pub(super) fn point_of_shape(
        &mut self,
        node: &Node,
        what: &str,
        fields: &Fields<'_>,
    ) -> Option<Anchor> {
        let anchor = self.anchor(node, what, &fields.owner)?;
        if anchor.point.is_none() {
            let body = self.names.bodies[anchor.body.0].name.clone();
            let message = format!("{}: this place on `{body}` has no name", fields.owner);
            self.report(
                Diagnostic::error(codes::UNKNOWN_POINT, message)
                    .at(node.span.clone(), "a body, and not one of its points")
                    .help(format!(
                        "give it a point there, `points = {{ P = [0, 0] }}`, and write `{body}.P`"
                    )),
            );
            return None;
        }
        Some(anchor)
    }
}

/// The rows of a contact, those that rub after those that press.
fn rows_of(
    pair: &ContactPair,
    contact: ContactId,
    restitution: Expr,
    friction: Option<[Expr; 2]>,
    rolling: Option<Expr>,
) -> Vec<Load> {
    let load = |kind| Load { name: pair.name.clone(), kind, span: pair.span.clone() };
    let touches =
        (0..pair.places.len()).map(|place| load(LoadKind::Touch { contact, place, restitution }));
    let mut rows: Vec<Load> = touches.collect();
    let of_rolling = rolling.map(|arm| (Opposed::Roll, [arm; 2]));
    let of_slip = friction.map(|coefficients| (Opposed::Slip, coefficients));
    for (opposed, [sliding, sticking]) in of_slip.into_iter().chain(of_rolling) {
        let rub = |track| LoadKind::Rub { contact, track, opposed, sliding, sticking };
        rows.extend((0..pair.tracks.len()).map(|track| load(rub(track))));
    }
    rows
}
