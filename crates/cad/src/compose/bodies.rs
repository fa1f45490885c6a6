//! The bodies of a drawing with their geometry, and the questions that joints and loads ask of them.

use crate::attachment::{Content, Value, find};
use crate::drawing::{Drawing, Entity, Handle, Location, Shape};
use crate::geometry::vector::distance;
use crate::geometry::{Bounds, Curve, Path, Point};
use crate::outline::Outline;

use super::frame::Frame;

/// The index of the ground among the bodies.
pub(super) const GROUND: usize = 0;

/// A body of the drawing.
#[derive(Clone, Debug)]
pub(super) struct Body {
    /// Name of the body; `ground` for the first.
    pub(super) name: String,
    /// Where it was first met; every body but the ground was.
    location: Option<Location>,
    /// Stated values, the drawing's and those of the sidecar, which come first.
    pub(super) values: Vec<Value>,
    /// Curves in world axes, drawing units, each with the index of its entity.
    pub(super) paths: Vec<(Path, usize)>,
    /// Points of it that a joint may be meant to meet: centres, corners, ends.
    pub(super) features: Vec<Point>,
    /// Marks that are drawn as points.
    pub(super) marks: Vec<Point>,
    /// Closed outlines of the body.
    pub(super) outline: Option<Outline>,
    /// True if its outline has a fault that was reported.
    pub(super) has_bad_outline: bool,
    /// The box around an outline that is not closed: what meets it, meets no body yet.
    pub(super) lost: Option<Bounds>,
    /// Stated centre of mass, in world axes.
    pub(super) centre: Option<Point>,
    /// Stated frame.
    pub(super) frame: Option<Frame>,
}

impl Body {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            location: None,
            values: Vec::new(),
            paths: Vec::new(),
            features: Vec::new(),
            marks: Vec::new(),
            outline: None,
            has_bad_outline: false,
            lost: None,
            centre: None,
            frame: None,
        }
    }

    /// The stated value of a key.
    pub(super) fn value(&self, key: &str) -> Option<&Value> {
        find(&self.values, key)
    }

    /// Where a body that is not the ground was first met.
    pub(super) fn location(&self) -> &Location {
        self.location.as_ref().expect("every body but the ground was met at an entity")
    }

    /// Whether a point is one where a pin goes through the body: the centre of a circle or an arc, or a
    /// point that is drawn by itself; not a corner or an end.
    pub(super) fn is_pinned_at(&self, at: Point, tolerance: f64) -> bool {
        let is_here = |point: Point| distance(point, at) <= tolerance;
        let mut curves = self.paths.iter().flat_map(|(path, _)| &path.curves);
        let is_centre =
            |curve: &Curve| matches!(curve, Curve::Arc { centre, .. } if is_here(*centre));
        self.marks.iter().any(|mark| is_here(*mark)) || curves.any(is_centre)
    }

    /// True if a feature is a centre, not a corner of the outline.
    pub(super) fn has_centre_at(&self, feature: Point, rounding: f64) -> bool {
        let mut curves = self.paths.iter().flat_map(|(path, _)| &path.curves);
        curves.any(|curve| {
            matches!(curve, Curve::Arc { centre, .. } if distance(*centre, feature) <= rounding)
        })
    }
}

/// All bodies of a drawing, and which of them each entity belongs to.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    /// The ground first.
    pub(super) list: Vec<Body>,
    /// By entity: the index of its body.
    owners: Vec<Option<usize>>,
}

impl Bodies {
    /// The ground alone, before any entity belongs to a body.
    pub(super) fn new(n_entities: usize) -> Self {
        Self { list: vec![Body::new("ground")], owners: vec![None; n_entities] }
    }

    /// The index of the body of this name; a new one if there is none yet.
    pub(super) fn named_or_new(&mut self, name: &str, location: &Location) -> usize {
        let known = self.list.iter().position(|body| body.name == name);
        let body_idx = known.unwrap_or_else(|| {
            self.list.push(Body::new(name));
            self.list.len() - 1
        });
        self.list[body_idx].location.get_or_insert_with(|| location.clone());
        body_idx
    }

    /// Gives an entity with its geometry to a body.
    pub(super) fn own(&mut self, body_idx: usize, entity_idx: usize, drawing: &Drawing) {
        if self.owners[entity_idx].replace(body_idx) == Some(body_idx) {
            return;
        }
        let body = &mut self.list[body_idx];
        match &drawing.entities[entity_idx].shape {
            Shape::Path(path) => {
                body.features.extend(features(path));
                body.paths.push((path.clone(), entity_idx));
            }
            Shape::Paths(paths) => {
                body.features.extend(paths.iter().flat_map(features));
                body.paths.extend(paths.iter().map(|path| (path.clone(), entity_idx)));
            }
            Shape::Hatch(paths) => {
                body.paths.extend(paths.iter().map(|path| (path.clone(), entity_idx)));
            }
            Shape::Point(at) => {
                body.features.push(*at);
                body.marks.push(*at);
            }
            Shape::Text { .. }
            | Shape::Insert(_)
            | Shape::Dimension { .. }
            | Shape::Unread { .. }
            | Shape::Other => (),
        }
    }

    /// The body that an entity belongs to.
    pub(super) fn owner(&self, entity_idx: usize) -> Option<usize> {
        self.owners[entity_idx]
    }

    /// The body that a value names, or the words for one that is not there.
    pub(super) fn named(&self, content: &Content, drawing: &Drawing) -> Result<usize, String> {
        match content {
            Content::Text(name) => self
                .list
                .iter()
                .position(|body| body.name == *name)
                .ok_or_else(|| format!("there is no body `{name}`")),
            Content::Entity(handle) => self
                .owner_of(*handle, drawing)
                .ok_or_else(|| format!("entity {:X} belongs to no body", handle.0)),
            Content::Number(number) | Content::Length(number) => {
                Err(format!("{number} is no body"))
            }
        }
    }

    fn owner_of(&self, handle: Handle, drawing: &Drawing) -> Option<usize> {
        let is_meant = |entity: &Entity| entity.location.handle == Some(handle);
        self.owner(drawing.entities.iter().position(is_meant)?)
    }

    /// True if a point is where the outline of a body is not closed.
    pub(super) fn is_lost(&self, at: Point) -> bool {
        self.list.iter().any(|body| body.lost.is_some_and(|lost| lost.contains(at)))
    }

    /// Bodies with a feature within the tolerance of a point, in their order.
    pub(super) fn met_at(&self, at: Point, tolerance: f64) -> Vec<usize> {
        self.where_body(|body| {
            body.features.iter().any(|feature| distance(*feature, at) <= tolerance)
        })
    }

    /// Bodies whose outer outline surrounds a point or passes through it, in their order.
    pub(super) fn around(&self, at: Point, tolerance: f64) -> Vec<usize> {
        self.where_body(|body| {
            let outline = body.outline.as_ref();
            outline.is_some_and(|outline| {
                outline.outer_contains(at) || outline.distance(at) <= tolerance
            })
        })
    }

    fn where_body(&self, is_meant: impl Fn(&Body) -> bool) -> Vec<usize> {
        let bodies = self.list.iter().enumerate();
        bodies.filter(|(_, body)| is_meant(body)).map(|(body_idx, _)| body_idx).collect()
    }
}

/// Centres, corners and ends of a path.
fn features(path: &Path) -> Vec<Point> {
    let mut points = Vec::new();
    for curve in &path.curves {
        match curve {
            Curve::Arc { centre, .. } | Curve::Ellipse { centre, .. } => points.push(*centre),
            Curve::Segment { from, to } => points.extend([*from, *to]),
            Curve::Spline(spline) => {
                points.extend(spline.control.first());
                points.extend(spline.control.last());
            }
        }
    }
    points
}
