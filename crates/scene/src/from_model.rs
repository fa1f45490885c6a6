//! From a model to its scene: outlines where there are some, textbook symbols for the rest.
//!
//! Everything is measured in radii of a pin, which follows from the lengths of the mechanism
//! itself.

mod beams;
mod bodies;
mod cords;
mod curves;
mod ground;
mod looks;
mod markers;
mod numbers;
mod outlines;
mod rail;
mod sizes;
mod solids;
mod spans;
mod stops;
mod symbols;
mod turns;
mod wheels;

use bksim_model::{Model, Space};
use bksim_sim::pose::Pose;

use crate::geometry::{Plane, Point};
use crate::{Attached, Form, Role, Scene, Shape};

use numbers::Numbers;
use rail::Rail;
use sizes::SymbolSizes;

impl Scene {
    /// The shapes of a model at these values of its parameters.
    ///
    /// The travel of sliders is not known: guides and slots are as long as the model's start
    /// suggests. [`Scene::of_motion`] takes it from a motion.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn of(model: &Model, parameters: &[f64]) -> Self {
        Self::of_motion(model, parameters, &[])
    }

    /// The shapes of a model that moves as in `motion`: the poses of all bodies, the ground first,
    /// at some instants, the earliest first. Guides and slots cover the travel of their sliders,
    /// supports stand on the side where the links are less often.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn of_motion(model: &Model, parameters: &[f64], motion: &[Vec<Pose>]) -> Self {
        assert_eq!(parameters.len(), model.parameters.len(), "one value per parameter");
        let shown = beams::without_parts(model);
        let model = shown.as_ref().unwrap_or(model);
        let sketch = Sketch::new(Numbers::new(model, parameters, motion));

        // Back to front; springs lie between the bodies and the pins, see `Role::is_in_front`.
        let mut shapes = sketch.ground();
        shapes.extend(sketch.curves());
        let (blocks, others): (Vec<usize>, Vec<usize>) = (1..model.bodies.len())
            .filter(|&body| model.bodies[body].flexible.is_none())
            .partition(|&body| sketch.is_slider(body));
        shapes.extend(blocks.into_iter().flat_map(|body| sketch.body(body)));
        // Wide plates and wheels are under thin links, which they would hide.
        let wheels = [sketch.wheels(), sketch.pulleys()].concat().into_iter();
        let wheels = wheels.map(|wheel| (sketch.box_of([&wheel]), vec![wheel]));
        let others = others.into_iter().map(|body| (sketch.width(body), sketch.body(body)));
        let mut layers: Vec<(f64, Vec<Shape>)> = wheels.chain(others).collect();
        layers.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        shapes.extend(layers.into_iter().flat_map(|(_, layer)| layer));
        shapes.extend(sketch.outlines());
        shapes.extend(sketch.stops());
        shapes.extend(sketch.torsion_springs());
        shapes.extend(sketch.pins());
        shapes.extend(sketch.welds());
        shapes.extend(sketch.drives());
        let (torques, turns) = sketch.torques();
        shapes.extend(torques);
        shapes.extend(sketch.masses());
        shapes.retain(Shape::is_finite);
        Self {
            is_planar: model.space == Space::Planar,
            bodies: model.bodies.iter().map(|body| body.name.clone()).collect(),
            shapes,
            spans: [sketch.spans(), sketch.beams()].concat(),
            cords: sketch.cords(),
            markers: sketch.markers(),
            turns,
            pin: sketch.pin,
        }
    }
}

/// Values that all shapes of a model depend on.
struct Sketch<'a> {
    numbers: Numbers<'a>,
    /// By body: its points that something is attached to, in its frame.
    attached: Vec<Vec<[f64; 3]>>,
    /// By joint: its guide or slot.
    rails: Vec<Option<Rail>>,
    /// By body: the number of its colour.
    colours: Vec<u8>,
    /// Radius of a pin, m.
    pin: f64,
}

impl<'a> Sketch<'a> {
    fn new(numbers: Numbers<'a>) -> Self {
        let mut attached = vec![Vec::new(); numbers.model.bodies.len()];
        for at in attachments(&numbers) {
            attached[at.body].push(at.position);
        }
        let sizes = SymbolSizes::of(&numbers, &attached);
        let rails = rail::rails(&numbers, &sizes, &attached);
        let colours = colours(numbers.model);
        Self { numbers, attached, rails, colours, pin: sizes.pin }
    }

    fn is_planar(&self) -> bool {
        self.model().space == Space::Planar
    }

    fn model(&self) -> &'a Model {
        self.numbers.model
    }

    /// The guides and slots that a body has.
    fn rails_of(&self, body: usize) -> impl Iterator<Item = &Rail> {
        self.rails.iter().flatten().filter(move |rail| rail.body == body)
    }

    /// True if a body slides on a rail.
    fn is_slider(&self, body: usize) -> bool {
        let mut sliders = self.rails.iter().flatten().filter_map(|rail| rail.slider);
        sliders.any(|slider| slider.body == body)
    }

    /// Area of a body in the plane, in squares of pins: of the box around its solids, or of the plate through its
    /// points; zero of what has two points at most.
    fn width(&self, body: usize) -> f64 {
        if !self.is_planar() {
            return 0.0;
        }
        let solids = self.solids(body);
        if !solids.is_empty() {
            return self.box_of(&solids);
        }
        let points = &self.attached[body];
        if points.len() < 3 || !self.model().bodies[body].outline.is_empty() {
            return 0.0;
        }
        let across = |p: &[f64; 3], a: &[f64; 3], b: &[f64; 3]| {
            ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])).abs()
        };
        let (first, rest) = (&points[0], &points[1..]);
        let areas = rest.windows(2).map(|pair| across(&pair[1], first, &pair[0]));
        areas.fold(0.0, f64::max) / (self.pin * self.pin)
    }

    /// Area of the box around shapes of a body, in squares of pins.
    fn box_of<'s>(&self, shapes: impl IntoIterator<Item = &'s Shape>) -> f64 {
        let corners: Vec<_> = shapes.into_iter().flat_map(|shape| shape.form.reach()).collect();
        let span = |axis: usize| {
            let along = || corners.iter().map(|p| p[axis]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        span(0) * span(1) / (self.pin * self.pin)
    }

    fn role_of(&self, body: usize) -> Role {
        if body == 0 { Role::Ground } else { Role::Body(self.colours[body]) }
    }
}

/// Points of bodies that joints and loads are attached to, in the order of the file.
fn attachments(numbers: &Numbers) -> Vec<Attached> {
    let joints = numbers.model.joints.iter().flat_map(|j| [j.predecessor, j.successor]);
    let loads = numbers.model.loads.iter().flat_map(|load| load.kind.points());
    let outlines = numbers.model.contacts.iter().flat_map(|pair| &pair.shapes);
    let outlines = outlines.flat_map(bksim_model::Shape::anchors);
    joints.chain(loads).chain(outlines).map(|anchor| numbers.attached(anchor)).collect()
}

/// Number of different colours.
const N_COLOURS: usize = 6;

/// The colour of every body: in file order, and different from those of its neighbours if possible.
fn colours(model: &Model) -> Vec<u8> {
    let mut neighbours = vec![Vec::new(); model.bodies.len()];
    for joint in &model.joints {
        let (a, b) = (joint.predecessor.body.0, joint.successor.body.0);
        neighbours[a.max(b)].push(a.min(b));
    }
    let mut colours: Vec<u8> = vec![0; model.bodies.len()];
    for body in 1..colours.len() {
        let is_free = |&colour: &u8| {
            !neighbours[body].iter().any(|&other| other > 0 && colours[other] == colour)
        };
        let in_turn = |i: usize| {
            u8::try_from((body - 1 + i) % N_COLOURS).expect("there are fewer than 256 colours")
        };
        colours[body] = (0..N_COLOURS).map(in_turn).find(is_free).unwrap_or(in_turn(0));
    }
    colours
}

impl Shape {
    /// An area in a plane of a body.
    fn region(body: usize, role: Role, plane: &Plane, rings: &[Vec<Point>]) -> Self {
        let rings = rings.iter().map(|ring| plane.lifted(ring)).collect();
        Self { body, role, form: Form::Region(rings) }
    }

    /// A line in a plane of a body.
    fn line(body: usize, role: Role, plane: &Plane, points: &[Point]) -> Self {
        let points = plane.lifted(points);
        Self { body, role, form: Form::Line { points, is_closed: false } }
    }

    fn is_finite(&self) -> bool {
        let is_finite = |points: &Vec<[f64; 3]>| points.iter().flatten().all(|x| x.is_finite());
        match &self.form {
            Form::Region(rings) | Form::Section { rings, .. } => rings.iter().all(is_finite),
            Form::Line { points, .. } => is_finite(points),
            Form::Rod { ends, radius } => {
                radius.is_finite() && ends.iter().flatten().all(|x| x.is_finite())
            }
            Form::Solid(solid) => is_finite(&solid.corners),
        }
    }
}
