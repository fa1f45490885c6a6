//! Checks on values and on the whole model: physics, plausibility and what hangs together.

use super::bodies::{BodyFacts, Position};
use super::codes;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::units::Quantity;
use super::value::Scalar;
use crate::body::Body;
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::{BodyId, GROUND};
use crate::message::short;

/// Mechanisms larger than this are rare, m.
const LARGE_M: f64 = 100.0;

/// Bodies heavier than this are rare, kg.
const HEAVY_KG: f64 = 1e7;

impl Reader<'_> {
    /// Whether a value is greater than zero; reports it otherwise.
    pub(super) fn check_positive(
        &mut self,
        what: &str,
        scalar: &Scalar,
        quantity: Quantity,
    ) -> bool {
        let zero = Constant::written(0.0);
        let Some(value) = scalar.value.filter(|&value| !self.constants.is_above(value, zero))
        else {
            return true;
        };
        let value = value.look();
        let unit = quantity.dimension().to_string();
        let space = if unit.is_empty() { "" } else { " " };
        self.report(
            Diagnostic::error(codes::NOT_POSITIVE, format!("{what} is {value}{space}{unit}"))
                .at(scalar.span.clone(), "must be greater than 0")
                .help(format!("write for example \"{}\"", quantity.example)),
        );
        false
    }

    /// Moments of inertia that a body can have.
    pub(super) fn check_inertia(
        &mut self,
        fields: &Fields<'_>,
        components: &[Scalar],
        com: Option<[f64; 3]>,
        body: &Body,
        facts: &BodyFacts,
    ) {
        // One moment may vary if it keeps its sign; several are pinned.
        let values: Option<Vec<Constant>> = components.iter().map(|scalar| scalar.value).collect();
        let Some(values) = values else { return };
        let values = &values[..values.len().min(3)];
        let zero = Constant::written(0.0);
        let moments: Vec<f64> = match values {
            [one] => {
                self.constants.is_not_below(*one, zero);
                vec![one.look()]
            }
            several => several.iter().map(|&value| self.constants.pinned(value)).collect(),
        };
        let moments = moments.as_slice();
        let what = fields.what("inertia");
        // No moment is negative.
        if let Some(idx) = moments.iter().position(|value| *value < 0.0) {
            self.report(
                Diagnostic::error(codes::BAD_INERTIA, format!("{what} is {} kg m^2", moments[idx]))
                    .at(components[idx].span.clone(), "must not be negative")
                    .help(format!("write \"{} kg m^2\"", -moments[idx])),
            );
            return;
        }
        // The triangle inequality of the principal moments.
        if let [xx, yy, zz] = *moments {
            let largest = xx.max(yy).max(zz);
            let others = xx + yy + zz - largest;
            if largest > others * (1.0 + 1e-9) {
                let [xx, yy, zz, largest, others] = [xx, yy, zz, largest, others].map(short);
                let span = components[0].span.start..components[2].span.end;
                let message = format!(
                    "{what} is [{xx}, {yy}, {zz}] kg m^2, but no moment may exceed the sum of the other two"
                );
                self.report(
                    Diagnostic::error(codes::BAD_INERTIA, message)
                        .at(span, format!("{largest} > {others}"))
                        .help(format!(
                            "check units, axes and centre of mass; the largest may be {others} kg m^2"
                        )),
                );
                return;
            }
        }
        self.check_about_pin(moments, com, body, facts);
    }

    /// Steiner: the moment about the centre of mass is I − m d² and cannot be negative.
    fn check_about_pin(
        &mut self,
        moments: &[f64],
        com: Option<[f64; 3]>,
        body: &Body,
        facts: &BodyFacts,
    ) {
        let (Some(point), Some(com), Some((mass, _)), Some(span)) =
            (body.inertia.about, com, facts.mass.as_ref(), body.inertia_span.clone())
        else {
            return;
        };
        let Some(pin) = facts.points.get(point.0).copied().flatten() else { return };
        let [dx, dy] = [com[0] - pin[0], com[1] - pin[1]];
        let (stated, distance) = (moments[moments.len() - 1], dx.hypot(dy));
        let steiner = mass * distance * distance;
        if stated >= steiner * (1.0 - 1e-9) {
            return;
        }
        let (name, pin) = (&body.name, &body.points[point.0].name);
        let message = format!(
            "inertia of body `{name}` about its centre of mass would be {} kg m^2",
            short(stated - steiner)
        );
        self.report(
            Diagnostic::warning(codes::INERTIA_ABOUT_PIN, message)
                .at(span, format!("less than m d^2 = {} kg m^2", short(steiner)))
                .note(format!(
                    "stated {} kg m^2 about `{pin}`; mass {} kg at {} m from it",
                    short(stated),
                    short(*mass),
                    short(distance)
                ))
                .help(format!(
                    "no rigid body has this: give at least \"{} kg m^2\" about `{pin}`",
                    short(steiner)
                )),
        );
    }

    /// Which bodies are joined to what. `joints` are the bodies of each joint.
    pub(super) fn check_topology(
        &mut self,
        bodies: &[(Option<Body>, BodyFacts)],
        joints: &[[BodyId; 2]],
    ) {
        let n_bodies = bodies.len();
        if self.topology_unknown {
            return;
        }
        if n_bodies == 1 {
            self.report(
                Diagnostic::error(codes::NO_BODIES, "the model has no bodies")
                    .help("write a table such as `[bodies.crank]` with `mass = \"1 kg\"`"),
            );
            return;
        }
        let mut is_used = vec![false; n_bodies];
        for body in joints.iter().flatten() {
            is_used[body.0] = true;
        }
        for (idx, (_, facts)) in bodies.iter().enumerate().skip(1) {
            if !is_used[idx] && !facts.is_free {
                self.report_unused(BodyId(idx));
            }
        }
        // Every connected group must hold the ground or a body that is free.
        for members in connected_groups(n_bodies, joints) {
            let is_held = members.iter().any(|&i| i == GROUND.0 || bodies[i].1.is_free);
            if !is_held && is_used[members[0]] {
                self.report_no_gshort(&members);
            }
        }
    }

    fn body_place(&self, body: BodyId) -> (String, Span) {
        let name = &self.names.bodies[body.0];
        (name.name.clone(), name.span.clone())
    }

    fn report_unused(&mut self, body: BodyId) {
        let (name, span) = self.body_place(body);
        self.report(
            Diagnostic::error(codes::UNUSED_BODY, format!("body `{name}` is in no joint"))
                .at(span, "joined to nothing")
                .help(format!(
                    "add a joint with `between = [\"ground\", \"{name}\"]`, or `free = true` to let it float"
                )),
        );
    }

    fn report_no_gshort(&mut self, members: &[usize]) {
        let names: Vec<String> =
            members.iter().map(|&idx| self.names.bodies[idx].name.clone()).collect();
        let (first, span) = self.body_place(BodyId(members[0]));
        let listed = names.iter().take(8).map(|name| format!("`{name}`")).collect::<Vec<_>>();
        let more = if names.len() > 8 { ", …" } else { "" };
        let message = format!("no joint connects {}{more} with the ground", listed.join(", "));
        self.report(
            Diagnostic::error(codes::NO_GROUND, message)
                .at(span, "one of these must be held by the ground")
                .help(format!(
                    "add for example a joint of type \"weld\" with `between = [\"ground\", \"{first}\"]`, or `free = true` to let it float"
                )),
        );
    }

    /// Warns when bare numbers look like another unit.
    pub(super) fn check_size(&mut self, bodies: &[(Option<Body>, BodyFacts)]) {
        // The largest body by bare numbers, and the heaviest.
        let sizes = bodies.iter().filter_map(|(_, facts)| {
            let bare: Vec<&Position> =
                facts.positions.iter().filter(|position| position.is_bare).collect();
            let far = |position: &&&Position| length(position.numbers(), [0.0; 3]);
            let farthest = bare.iter().max_by(|a, b| far(a).total_cmp(&far(b)))?;
            Some((extent(&bare), farthest.span.clone()))
        });
        let size = sizes.max_by(|a, b| a.0.total_cmp(&b.0));
        let mass = bodies
            .iter()
            .filter_map(|(_, facts)| facts.mass.clone())
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(mass, _)| *mass > HEAVY_KG);
        let has_density = bodies.iter().any(|(_, facts)| facts.has_density);
        let size = size.filter(|(size, _)| *size > LARGE_M && !self.units.length_stated);
        // One warning for both.
        let fault = match (size, mass) {
            (Some((size, span)), mass) => {
                let heavy = mass.as_ref().map_or(String::new(), |(mass, _)| {
                    format!(", and its heaviest body has {mass:e} kg")
                });
                Diagnostic::warning(
                    codes::IMPLAUSIBLE_SIZE,
                    format!("the mechanism is {} m large{heavy}", short(size)),
                )
                .at(span, "a number without unit is in metres")
                .help(
                    "if millimetres are meant, add `[units]` with `length = \"mm\"`; if metres, `length = \"m\"`",
                )
            }
            (None, Some((mass, span))) => {
                let help = if has_density {
                    "check the units of density, thickness and outline"
                } else {
                    "if another unit is meant, write it, for example \"1 g\" or \"1 t\""
                };
                Diagnostic::warning(
                    codes::IMPLAUSIBLE_SIZE,
                    format!("the heaviest body has {mass:e} kg"),
                )
                .at(span, "this mass")
                .help(help)
            }
            (None, None) => return,
        };
        self.report(fault);
    }
}

/// The bodies that hang together by joints, each group ascending, groups by their first body.
fn connected_groups(n_bodies: usize, joints: &[[BodyId; 2]]) -> Vec<Vec<usize>> {
    let mut joined = vec![Vec::new(); n_bodies];
    for &[a, b] in joints {
        joined[a.0].push(b.0);
        joined[b.0].push(a.0);
    }
    let mut is_seen = vec![false; n_bodies];
    let mut groups = Vec::new();
    for first in 0..n_bodies {
        let mut pending = vec![first];
        let mut members = Vec::new();
        while let Some(body) = pending.pop() {
            if !std::mem::replace(&mut is_seen[body], true) {
                members.push(body);
                pending.extend(&joined[body]);
            }
        }
        members.sort_unstable();
        groups.push(members);
    }
    groups.retain(|members| !members.is_empty());
    groups
}

/// Diagonal of the box around some points and the origin of their frame.
fn extent(positions: &[&Position]) -> f64 {
    let mut corners = [[0.0_f64; 3]; 2];
    for position in positions {
        for axis in 0..3 {
            corners[0][axis] = corners[0][axis].min(position.value[axis].look());
            corners[1][axis] = corners[1][axis].max(position.value[axis].look());
        }
    }
    length(corners[0], corners[1])
}

fn length(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
