//! Bodies: shapes, frames with masses, centres of mass, points.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::{Anchor, BodyId, GROUND, JointId, PointId};
use toml_edit::{Item, TableLike, Value};

use super::shape::{block, rounded_hull};
use super::texts::{all, entries, text, words};
use super::units::{Dimension, dimension};
use super::{MARK_LAYER, Sketch, Unwritten, Values, kind, no_place};
use crate::codes;
use crate::geometry::Point;
use crate::kind::{BODY_LAYER, GROUND_LAYER};
use crate::write::blocks::Words;
use crate::write::canvas::{Mark, Release};
use crate::write::template::BODY_COLOURS;

impl Sketch<'_> {
    /// Draws all bodies, the ground first.
    pub(super) fn bodies(&mut self) -> Result<(), Unwritten> {
        self.check_names()?;
        for idx in 0..self.model.bodies.len() {
            let body = BodyId(idx);
            let layer = self.layer_of(body);
            if body != GROUND {
                self.canvas.layer(&layer, BODY_COLOURS[(idx - 1) % BODY_COLOURS.len()]);
            }
            self.shape(body, &layer)?;
            if body != GROUND {
                self.frame(body)?;
            }
            self.points(body)?;
        }
        Ok(())
    }

    fn layer_of(&self, body: BodyId) -> String {
        match body {
            GROUND => GROUND_LAYER.to_owned(),
            _ => format!("{BODY_LAYER}{}", self.model.bodies[body.0].name),
        }
    }

    /// Names of layers do not know small from large letters, and are short in old drawings.
    fn check_names(&self) -> Result<(), Unwritten> {
        const LONGEST_IN_R12: usize = 31;
        for (idx, body) in self.model.bodies.iter().enumerate().skip(1) {
            let before = &self.model.bodies[1..idx];
            if let Some(other) = before.iter().find(|b| b.name.eq_ignore_ascii_case(&body.name)) {
                let message = format!(
                    "bodies `{}` and `{}` would share a layer: names of layers do not know small \
                     from large letters",
                    other.name, body.name
                );
                return Err(Diagnostic::error(codes::TOO_LONG, message)
                    .at(body.span.clone(), "rename this body")
                    .into());
            }
            let is_short = BODY_LAYER.len() + body.name.len() <= LONGEST_IN_R12;
            if self.release == Release::R12 && !is_short {
                let message = format!("the name of body `{}` is too long for a layer", body.name);
                return Err(Diagnostic::error(codes::TOO_LONG, message)
                    .at(body.span.clone(), "23 characters fit into a drawing of R12")
                    .help("write a newer release")
                    .into());
            }
        }
        Ok(())
    }

    /// Outlines of the sketch, or a bar about its points.
    fn shape(&mut self, body: BodyId, layer: &str) -> Result<(), Unwritten> {
        let outlines = &self.model.bodies[body.0].outline;
        for outline in outlines {
            let corner = |&p: &[bksim_expr::Expr; 2]| self.positions.vector(p);
            let corners: Option<Vec<Point>> = outline.iter().map(corner).collect();
            let Some(corners) = corners else {
                let owner = format!("body `{}`", self.model.bodies[body.0].name);
                return Err(no_place("an outline", &owner).into());
            };
            let drawn: Vec<Point> =
                corners.into_iter().map(|p| self.positions.on_body(body, p)).collect();
            self.canvas.draw(layer, Mark::chain(&drawn, true))?;
        }
        if outlines.is_empty() && body != GROUND {
            let radius = 0.5 * self.size;
            let points = self.used_points(body)?;
            let mark = match (self.pitch_circle(body)?, self.slide(body)?, &points[..]) {
                (Some((centre, radius)), ..) => Some(Mark::Circle(centre, radius)),
                (_, Some(angle), &[at]) => Some(block(at, angle, radius)),
                _ => rounded_hull(&points, radius),
            };
            if let Some(mark) = mark {
                self.canvas.draw(layer, mark)?;
            }
        }
        Ok(())
    }

    /// The named points of a body and its origin if something is fastened there, in the drawing,
    /// each position once.
    fn used_points(&self, body: BodyId) -> Result<Vec<Point>, Unwritten> {
        let n_points = self.model.bodies[body.0].points.len();
        let named = (0..n_points).map(|i| Some(PointId(i)));
        let origin = self.origin_is_used(body).then_some(None);
        let mut positions: Vec<Point> = Vec::new();
        for point in named.chain(origin) {
            let at = self.positions.anchor(Anchor { body, point })?;
            let is_new =
                |other: &Point| (other[0] - at[0]).hypot(other[1] - at[1]) > 1e-6 * self.size;
            if positions.iter().all(is_new) {
                positions.push(at);
            }
        }
        Ok(positions)
    }

    /// Whether a joint or a load is fastened to the origin of a body without naming a point.
    fn origin_is_used(&self, body: BodyId) -> bool {
        let origin = Anchor { body, point: None };
        let in_joints =
            self.model.joints.iter().any(|j| [j.predecessor, j.successor].contains(&origin));
        let in_loads = self.model.loads.iter().any(|load| load.kind.points().contains(&origin));
        in_joints || in_loads
    }

    /// The angle of the slide that a body is on, if it is.
    fn slide(&self, body: BodyId) -> Result<Option<f64>, Unwritten> {
        for (idx, joint) in self.model.joints.iter().enumerate() {
            if joint.kind.is_slide() && joint.successor.body == body {
                let [at, to] = self.positions.joint(JointId(idx))?;
                return Ok(Some((to[1] - at[1]).atan2(to[0] - at[0])));
            }
        }
        Ok(None)
    }

    /// `BK_BODY` with the values of the file, `BK_FRAME` and `BK_COM`.
    fn frame(&mut self, body: BodyId) -> Result<(), Unwritten> {
        let (pose, model) = (self.positions.pose(body), self.model);
        let stated = &model.bodies[body.0];
        let name = stated.name.clone();
        let mut values: Values = vec![("name", name.clone())];
        let bodies = entries(self.document, "bodies");
        let table = bodies.iter().find(|(known, _)| *known == name);
        if let Some(table) = table.and_then(|(_, item)| item.as_table_like()) {
            self.body_values(&name, table, &mut values)?;
        }
        let has_mass = values.iter().any(|(key, _)| *key == "mass");
        if has_mass && !values.iter().any(|(key, _)| *key == "inertia") {
            values.push(("inertia", "0".to_owned()));
        }
        let at = self.positions.drawn(pose.origin);
        let (sin, cos) = pose.angle.sin_cos();
        let frame = [at, [at[0] + cos, at[1] + sin]];
        let [x, y, _] = stated.com;
        let com = self.positions.vector([x, y]);
        let com = com.ok_or_else(|| no_place("the centre of mass", &format!("body `{name}`")))?;
        let com = self.positions.on_body(body, com);
        let here = [com, [com[0] + 1.0, com[1]]];
        self.insert_with(kind("body"), MARK_LAYER, here, Words::At(com), values)?;
        self.insert(kind("frame"), MARK_LAYER, frame, vec![("body", name.clone())])?;
        if has_mass {
            let at = com;
            let values = vec![("body", name)];
            self.insert(kind("com"), MARK_LAYER, [at, [at[0] + 1.0, at[1]]], values)?;
        }
        Ok(())
    }

    /// The keys of `[bodies.…]` that are not geometry.
    fn body_values(
        &self,
        name: &str,
        table: &dyn TableLike,
        values: &mut Values,
    ) -> Result<(), Unwritten> {
        let kind = kind("body");
        for (key, item) in all(table) {
            let known = kind.keys.iter().find(|known| **known == key);
            let unwritten = || no_place(&format!("`{key}`"), &format!("body `{name}`"));
            match (key, known) {
                ("com" | "points" | "outline", _) => (),
                ("inertia", _) => self.inertia(item, values),
                (_, Some(&known)) => {
                    let words = words(table, key).ok_or_else(unwritten)?;
                    values.push((known, self.units.complete(words, dimension("body", key, false))));
                }
                (_, None) => return Err(unwritten().into()),
            }
        }
        Ok(())
    }

    /// A value, a value about a point, or, of a tensor, the entry of the plane: Izz.
    fn inertia(&self, item: &Item, values: &mut Values) {
        let complete = |words| self.units.complete(words, Dimension::Inertia);
        if let Some(table) = item.as_table_like() {
            values.extend(words(table, "value").map(|words| ("inertia", complete(words))));
            values.extend(words(table, "about").map(|words| ("about", words)));
        } else if let Some(moments) = item.as_array() {
            values.extend(moments.get(2).map(|izz| ("inertia", complete(text(izz)))));
        } else if let Some(value) = item.as_value().map(|value: &Value| text(value)) {
            values.push(("inertia", complete(value)));
        }
    }

    /// `BK_POINT` for every named point, and for the origin where it is used.
    fn points(&mut self, body: BodyId) -> Result<(), Unwritten> {
        let model = self.model;
        let owner = model.bodies[body.0].name.clone();
        // A joint's name is enough.
        let joints: Result<Vec<_>, Unwritten> =
            (0..model.joints.len()).map(|idx| self.positions.joint(JointId(idx))).collect();
        let (joints, reach) = (joints?, 0.5 * self.size);
        let is_here = |at: Point| {
            move |joint: &[Point; 2]| (joint[0][0] - at[0]).hypot(joint[0][1] - at[1]) < reach
        };
        let named = (0..model.bodies[body.0].points.len()).map(|i| Some(PointId(i)));
        let origin = self.origin_is_used(body).then_some(None);
        for point in named.chain(origin) {
            let anchor = Anchor { body, point };
            let at = self.positions.anchor(anchor)?;
            let values = vec![("name", self.positions.point_name(anchor)), ("body", owner.clone())];
            let ends = [at, [at[0] + 1.0, at[1]]];
            let words = if joints.iter().any(is_here(at)) { Words::Hidden } else { Words::Usual };
            self.insert_with(kind("point"), MARK_LAYER, ends, words, values)?;
        }
        Ok(())
    }
}
