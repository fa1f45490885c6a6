//! Ropes and belts, and the pulleys and wheels that have no shape of their own.

use bksim_mbs::belt::ends;
use bksim_model::Anchor;

use super::Sketch;
use super::wheels::fine_circle;
use crate::geometry::Plane;
use crate::{Cord, CordPlace, Shape};

impl Sketch<'_> {
    /// The ropes and belts; their turns are counted from the first instant of the motion, if it is known.
    pub(super) fn cords(&self) -> Vec<Cord> {
        let model = self.model();
        let place = |center: Anchor, radius: f64, leaves: bool| {
            let at = self.numbers.attached(center);
            CordPlace { at, radius, leaves, first: None }
        };
        let belts = model.belts.iter().map(|belt| Cord {
            name: belt.name.clone(),
            places: (belt.wheels.iter())
                .map(|wheel| place(ends(model, wheel)[1], self.numbers.value(wheel.radius), false))
                .collect(),
            is_closed: true,
        });
        let ropes = model.ropes.iter().map(|rope| Cord {
            name: rope.name.clone(),
            places: (rope.nodes.iter())
                .map(|node| place(node.center, self.numbers.value(node.radius), node.leaves))
                .collect(),
            is_closed: false,
        });
        let mut cords: Vec<Cord> = belts.chain(ropes).collect();
        if let Some(poses) = self.numbers.first_poses() {
            for cord in &mut cords {
                cord.begin(poses);
            }
        }
        cords
    }

    /// Discs of wheels and pulleys.
    pub(super) fn pulleys(&self) -> Vec<Shape> {
        let model = self.model();
        let wheels = model.belts.iter().flat_map(|belt| &belt.wheels);
        let wheels = wheels.map(|wheel| (ends(model, wheel)[0], wheel.radius));
        let nodes = model.ropes.iter().flat_map(|rope| &rope.nodes);
        let round = wheels.chain(nodes.map(|node| (node.center, node.radius)));
        let disc = |(center, radius)| {
            let at = self.numbers.attached(center);
            let radius = self.numbers.value(radius).abs();
            let plane = Plane { origin: at.position, ..Plane::XY };
            (radius > 0.0 && !self.has_own_shape(at.body)).then(|| {
                Shape::region(at.body, self.role_of(at.body), &plane, &[fine_circle(radius)])
            })
        };
        round.filter_map(disc).collect()
    }
}
