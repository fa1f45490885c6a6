//! [`Forces`]: all that acts on the bodies of a motion, instant by instant.

use bksim_model::BodyId;
use bksim_sim::Mechanism;
use bksim_sim::free_body::{FreeBody, Origin};
use bksim_sim::run::Sample;
use serde_json::{Value, json};

/// Numbers of a wrench: force N, the point where it acts m, moment N m.
const N_NUMBERS: usize = 9;

/// The wrenches on all bodies that move, as functions of samples.
pub(crate) struct Forces {
    bodies: Vec<(usize, FreeBody)>,
}

/// Wrenches of a motion as a page has them.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct WrittenForces {
    /// `[{"body": 1, "kind": "joint", "name": "A", "joint": 0}, …]`: a row for each wrench.
    pub rows: Value,
    /// Nine numbers for each wrench, frame by frame: force N, point m, moment N m, in world axes.
    pub numbers: Vec<f64>,
}

impl Forces {
    /// Of a mechanism; none of one whose wrenches cannot be compiled.
    pub(crate) fn of(mechanism: &Mechanism) -> Self {
        let free = |body| Some((body, FreeBody::compile(mechanism, BodyId(body)).ok()?));
        Self { bodies: (1..mechanism.model.bodies.len()).filter_map(free).collect() }
    }

    /// The wrenches at samples, each with the modes that hold there; the inertia is left out.
    pub(crate) fn at(
        mut self,
        mechanism: &Mechanism,
        samples: &[(&Sample, &[f64])],
    ) -> WrittenForces {
        let model = &mechanism.model;
        let mut numbers = Vec::new();
        for (sample, modes) in samples {
            for (_, free) in &mut self.bodies {
                let wrenches = free.at(sample, modes);
                for (origin, wrench) in free.origins().zip(wrenches) {
                    if origin != Origin::Inertia {
                        let parts = [wrench.force, wrench.point, wrench.moment];
                        numbers.extend(parts.into_iter().flatten());
                    }
                }
            }
        }
        let rows = self.bodies.iter().flat_map(|(body, free)| {
            free.origins().filter(|origin| *origin != Origin::Inertia).map(move |origin| {
                let (kind, name) = origin.named(model);
                let joint = if let Origin::Joint(joint) = origin { Some(joint.0) } else { None };
                let is_second = joint.is_some_and(|k| model.joints[k].successor.body.0 == *body);
                json!({
                    "body": body, "kind": kind, "name": name, "joint": joint, "is_second": is_second,
                })
            })
        });
        let rows: Vec<Value> = rows.collect();
        debug_assert_eq!(numbers.len(), N_NUMBERS * rows.len() * samples.len());
        WrittenForces { rows: Value::Array(rows), numbers }
    }
}
