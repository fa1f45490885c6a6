//! Bodies and planes that are hardly meant: warnings with the numbers, about a model that was read.
//!
//! ```text
//! radius of gyration   k = √(I/m), against the reach r of the body, the distance of its farthest point from the
//!                      centre of mass: of a bar 0.58 r, of a disc with a pin at a tenth of its radius 7 r
//! centre of mass       its distance from the box around the points, against the diagonal of the box
//! ```
//!
//! A wrong unit changes k by √1000 and more: grams for kilograms, kg mm² for kg m².

use bksim_expr::{Expr, SymbolId};

use super::bodies::BodyFacts;
use super::codes;
use super::reader::Reader;
use crate::body::{Body, Space};
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::Vector;
use crate::message::short;
use crate::model::Model;

/// The largest radius of gyration over the reach of a body whose centre of mass is apart from its points: that of a disc all of
/// whose points are within a tenth of its radius, √½/0.1; and of one at whose centre of mass there is a point: a flywheel, of which
/// those of presses have 9. No ratio is impossible, for matter may be beyond the points.
const LARGEST_RADIUS: [f64; 2] = [7.1, 10.0];
/// The least one of a body whose mass is between its points, and of one whose mass is at one of them: a bob.
const LEAST_RADIUS: [f64; 2] = [1.0 / 50.0, 1.0 / 300.0];
/// A centre of mass is at a point if it is within this part of the reach.
const AT_POINT: f64 = 0.1;
/// The distance of a centre of mass from the points of its body, in sizes of these.
const FAR: f64 = 2.0;

/// A body in numbers, SI.
struct Numbers {
    mass: f64,
    com: [f64; 3],
    com_span: Option<Span>,
    /// Points and corners.
    points: Vec<[f64; 3]>,
}

/// Numbers of a body and of the planes of a model.
struct Values<'m> {
    model: &'m Model,
}

impl Values<'_> {
    fn of(&self, e: Expr) -> Option<f64> {
        let value = |symbol: SymbolId| {
            let known = self.model.parameters.iter().find(|p| p.symbol == symbol);
            known.map(|p| p.value)
        };
        self.model.pool.evaluate(e, &value).ok().filter(|x| x.is_finite())
    }

    fn vector(&self, v: Vector) -> Option<[f64; 3]> {
        Some([self.of(v[0])?, self.of(v[1])?, self.of(v[2])?])
    }

    fn numbers(&self, body: &Body, facts: &BodyFacts) -> Option<Numbers> {
        let points = body.points.iter().map(|point| self.vector(point.position));
        let points: Option<Vec<_>> = points.collect();
        let corners =
            body.outline.iter().flatten().map(|[x, y]| Some([self.of(*x)?, self.of(*y)?, 0.0]));
        let corners: Option<Vec<_>> = corners.collect();
        Some(Numbers {
            mass: self.of(body.mass)?,
            com: self.vector(body.com)?,
            com_span: facts.com_span.clone(),
            points: [points?, corners?].concat(),
        })
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

impl Reader<'_> {
    /// Warns of what can be solved but is hardly meant; `is_stated` says that the author wrote `space`.
    pub(super) fn check_plausible(&mut self, model: &Model, facts: &[BodyFacts], is_stated: bool) {
        let values = Values { model };
        for (body, facts) in model.bodies.iter().zip(facts).skip(1) {
            // Shapes with a density have the mass and the inertia that they have.
            if facts.has_density || !body.solids.is_empty() {
                continue;
            }
            let Some(numbers) = values.numbers(body, facts) else { continue };
            if numbers.mass > 0.0 && numbers.points.len() > 1 {
                let far = far_centre(model, &values, body, &numbers);
                let is_meant = facts.is_inertia_meant;
                let radius = || implausible_radius(&values, body, &numbers).filter(|_| !is_meant);
                let fault = far.or_else(radius);
                self.faults.extend(fault);
            }
        }
        if !is_stated && model.space == Space::Spatial {
            self.faults.extend(across_the_plane(&values, facts));
        }
    }
}

/// The warning of a centre of mass far outside of the points of its body.
fn far_centre(
    model: &Model,
    values: &Values<'_>,
    body: &Body,
    numbers: &Numbers,
) -> Option<Diagnostic> {
    let span = numbers.com_span.clone()?;
    let bound = |choose: fn(f64, f64) -> f64| {
        let mut all = numbers.points.iter().copied();
        let first = all.next().unwrap_or_default();
        all.fold(first, |a, b| [0, 1, 2].map(|i| choose(a[i], b[i])))
    };
    let [low, high] = [bound(f64::min), bound(f64::max)];
    let inside = [0, 1, 2].map(|i| numbers.com[i].clamp(low[i], high[i]));
    let (size, away) = (distance(low, high), distance(inside, numbers.com));
    if size == 0.0 || away <= FAR * size {
        return None;
    }
    // In the axes of the world it would be that of the body plus the place of its joint on the ground.
    let is_within =
        |p: &[f64; 3]| (0..3).all(|i| (low[i] - 0.2 * size..=high[i] + 0.2 * size).contains(&p[i]));
    let in_body = places_of(model, values, body).into_iter().find_map(|[ground, own]| {
        let p = [0, 1, 2].map(|i| numbers.com[i] - ground[i] + own[i]);
        is_within(&p).then_some(p)
    });
    let better = in_body.unwrap_or_else(|| [0, 1, 2].map(|i| 0.5 * (low[i] + high[i])));
    let written: Vec<String> = better
        .iter()
        .take(if better[2] == 0.0 { 2 } else { 3 })
        .map(|&x| if x == 0.0 { "0".to_owned() } else { format!("\"{} m\"", short(x)) })
        .collect();
    let name = &body.name;
    let message = format!(
        "the centre of mass of body `{name}` is {} m away from its points, which span {} m",
        short(away),
        short(size)
    );
    let fault = Diagnostic::warning(codes::FAR_CENTRE, message)
        .at(span, "in the frame of the body, as its points are")
        .help(format!(
            "write for example [{}], or give the body a point there if it is right",
            written.join(", ")
        ));
    Some(match in_body {
        Some(_) => fault.note("in the axes of the world it would be between them"),
        None => fault,
    })
}

/// The places of the joints between a body and the ground: on the ground, and on the body.
fn places_of(model: &Model, values: &Values<'_>, body: &Body) -> Vec<[[f64; 3]; 2]> {
    let place = |anchor: crate::body::Anchor| match anchor.point {
        Some(point) => values.vector(model.bodies[anchor.body.0].points[point.0].position),
        None => Some([0.0; 3]),
    };
    let between = model.joints.iter().filter_map(|joint| {
        let ends = [joint.predecessor, joint.successor];
        let is_ground = ends.map(|end| end.body.0 == 0);
        let of_body = ends.map(|end| model.bodies[end.body.0].name == body.name);
        match (is_ground, of_body) {
            ([true, _], [_, true]) => Some([place(ends[0])?, place(ends[1])?]),
            ([_, true], [true, _]) => Some([place(ends[1])?, place(ends[0])?]),
            _ => None,
        }
    });
    between.collect()
}

/// The warning of a moment of inertia that a body of this mass and size hardly has.
fn implausible_radius(values: &Values<'_>, body: &Body, numbers: &Numbers) -> Option<Diagnostic> {
    let span = body.inertia_span.clone()?;
    let moments = values.vector(body.inertia.moments)?;
    let stated = moments.into_iter().fold(0.0, f64::max);
    // About the centre of mass.
    let arm = match body.inertia.about {
        Some(point) => distance(numbers.com, *numbers.points.get(point.0)?),
        None => 0.0,
    };
    let inertia = stated - numbers.mass * arm * arm;
    let reach = numbers.points.iter().map(|&p| distance(p, numbers.com)).fold(0.0, f64::max);
    let nearest = numbers.points.iter().map(|&p| distance(p, numbers.com)).fold(reach, f64::min);
    if inertia <= 0.0 || reach == 0.0 {
        return None;
    }
    let radius = (inertia / numbers.mass).sqrt();
    let is_bob = nearest <= AT_POINT * reach;
    let is_large = radius > LARGEST_RADIUS[usize::from(is_bob)] * reach;
    if !is_large && radius >= LEAST_RADIUS[usize::from(is_bob)] * reach {
        return None;
    }
    // As much as a bar has that ends at the farthest point.
    let usual = numbers.mass * (reach * reach / 3.0 + arm * arm);
    let order = if is_large { "far beyond" } else { "a small part of" };
    let message = format!(
        "body `{}` of {} kg has a radius of gyration of {} m, {order} its reach of {} m",
        body.name,
        short(numbers.mass),
        short(radius),
        short(reach)
    );
    Some(
        Diagnostic::warning(codes::IMPLAUSIBLE_INERTIA, message)
            .at(span, format!("{} kg m^2 about its centre of mass", short(inertia)))
            .note("the reach is the distance of its farthest point from its centre of mass")
            .help(format!(
                "write for example \"{} kg m^2\", which a bar of this reach has, or check units of mass and inertia",
                short(usual)
            )),
    )
}

/// The warning of a planar mechanism that one direction alone takes out of its plane: that of gravity, or the axis
/// of a pin.
fn across_the_plane(values: &Values<'_>, facts: &[BodyFacts]) -> Option<Diagnostic> {
    let model = values.model;
    let is_flat = |v: Vector| values.of(v[2]).is_some_and(|z| z == 0.0);
    let points = model.bodies.iter().flat_map(|body| &body.points);
    let are_points_flat =
        points.clone().all(|point| is_flat(point.position) && point.orientation.is_empty());
    let is_of_solids = model.bodies.iter().any(|body| !body.solids.is_empty());
    let is_free = facts.iter().any(|facts| facts.is_free);
    if !are_points_flat
        || is_of_solids
        || is_free
        || !model.bodies.iter().all(|body| is_flat(body.com))
    {
        return None;
    }

    // Pins along z and guides in the plane; everything else is spatial on purpose.
    let mut crossed = Vec::new();
    let mut n_along = 0;
    for joint in &model.joints {
        let [x, y, z] = values.vector(joint.axis)?;
        let kind = joint.kind;
        if kind.is_pin() && x == 0.0 && y == 0.0 {
            n_along += 1;
        } else if (kind.is_pin() || kind.is_slot()) && z == 0.0 {
            crossed.push(joint);
        } else if !(kind.is_slide() && z == 0.0 || kind.is_weld() || kind.link_length().is_some()) {
            return None;
        }
        if !joint.alignment.is_empty() {
            return None;
        }
    }
    crossed.retain(|joint| joint.kind.is_pin());
    let mut across = model.loads.iter().filter_map(|load| {
        let [x, y, z] = values.vector(load.kind.gravity()?)?;
        (x == 0.0 && y == 0.0 && z != 0.0).then_some((load, z))
    });
    let across = across.next();
    match (crossed.as_slice(), across) {
        ([], Some((load, z))) => {
            let message = format!(
                "gravity `{}` of {} m/s^2 acts across the plane of all motions",
                load.name,
                short(z.abs())
            );
            Some(
                Diagnostic::warning(codes::GRAVITY_ACROSS, message)
                    .at(load.span.clone(), "along z, and everything moves in the plane of x and y")
                    .note("it moves nothing; the bearings take it")
                    .help(format!(
                        "write `acceleration = [0, \"{} m/s^2\"]`, or `space = \"spatial\"` at the top of the file if the mechanism is flat on a table",
                        short(z)
                    )),
            )
        }
        // One of several: where all are so, the plane is another one.
        ([joint], None) if n_along > 1 => {
            let message = format!(
                "the axis of pin `{}` is in the plane of x and y, and those of the other {n_along} are across it",
                joint.name
            );
            Some(
                Diagnostic::warning(codes::AXIS_IN_PLANE, message)
                    .at(joint.span.clone(), "it turns out of the plane in which all others move")
                    .help("write `axis = [0, 0, 1]`, or `space = \"spatial\"` at the top of the file if it is right"),
            )
        }
        _ => None,
    }
}
