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
    /// True if a value is greater than zero; reports it otherwise.
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
        let number = value.look();
        let value = short(number);
        let unit = quantity.dimension().to_string();
        let space = if unit.is_empty() { "" } else { " " };
        let help = if number < 0.0 {
            format!("write \"{}{space}{unit}\"", short(-number))
        } else {
            format!("write for example \"{}\"", quantity.example)
        };
        self.report(
            Diagnostic::error(codes::NOT_POSITIVE, format!("{what} is {value}{space}{unit}"))
                .at(scalar.span.clone(), "must be greater than 0")
                .help(help),
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
        let (values, products) = values.split_at(values.len().min(3));
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
                facts
                    .weigh(codes::BAD_INERTIA, format!("{what} is {} kg m^2", moments[idx]))
                    .at(components[idx].span.clone(), "must not be negative")
                    .help(format!("write \"{} kg m^2\"", -moments[idx])),
            );
            return;
        }
        // A tensor with products: what it is about its own axes.
        if let (&[xx, yy, zz], &[xy, yz, zx]) = (moments, products) {
            let [xy, yz, zx] = [xy, yz, zx].map(|product| self.constants.pinned(product));
            let principal = principal_moments([xx, yy, zz], [xy, yz, zx]);
            let span = components[0].span.start..components[5].span.end;
            if !self.are_moments(&what, principal, span, facts) {
                return;
            }
        } else if let [xx, yy, zz] = *moments {
            // The triangle inequality of the principal moments.
            let largest = xx.max(yy).max(zz);
            let others = xx + yy + zz - largest;
            if largest > others * (1.0 + 1e-9) {
                let [xx, yy, zz, largest, others] = [xx, yy, zz, largest, others].map(short);
                let span = components[0].span.start..components[2].span.end;
                let message = format!(
                    "{what} is [{xx}, {yy}, {zz}] kg m^2, but no moment may exceed the sum of the other two"
                );
                self.report(
                    facts
                        .weigh(codes::BAD_INERTIA, message)
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

    /// Whether a body can have these principal moments, the largest first; reports it otherwise.
    fn are_moments(
        &mut self,
        what: &str,
        principal: [f64; 3],
        span: Span,
        facts: &BodyFacts,
    ) -> bool {
        const ROUNDING: f64 = 1e-9;
        let [largest, middle, least] = principal;
        let [a, b, c] = principal.map(short);
        let message = format!("{what} has the principal moments [{a}, {b}, {c}] kg m^2");
        let (why, label) = if least < -ROUNDING * largest {
            ("none may be negative", format!("{c} < 0"))
        } else if largest > (middle + least) * (1.0 + ROUNDING) {
            let others = short(middle + least);
            ("none may exceed the sum of the other two", format!("{a} > {others}"))
        } else {
            return true;
        };
        self.report(
            facts
                .weigh(codes::BAD_INERTIA, format!("{message}, but {why}"))
                .at(span, label)
                .help("check the products ixy, iyz, izx: their signs, their units, and that they are about the centre of mass"),
        );
        false
    }

    /// True if a number that the author wrote has come out as zero, because it is too small to be held;
    /// reports it.
    pub(super) fn has_vanished(&mut self, what: &str, scalar: &Scalar) -> bool {
        let is_zero = scalar.value.is_some_and(|value| value.look() == 0.0);
        if !is_zero
            || self.pool.is_zero(scalar.expr)
            || !self.pool.symbols_of(scalar.expr).is_empty()
        {
            return false;
        }
        self.report(
            Diagnostic::error(codes::NOT_FINITE, format!("{what} is too small to be told from 0"))
                .at(scalar.span.clone(), "below 4.9e-324 there are no numbers")
                .help("write 0, or check the exponent and the unit"),
        );
        true
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
        if stated >= steiner * (1.0 - 1e-9) || facts.is_inertia_meant {
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
                    "no rigid body has this: give at least \"{} kg m^2\" about `{pin}`, or write `as_stated = true` in its table if it is meant so",
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
            // Laws and profiles can be asked about without a mechanism.
            let has_curves = !self.curves.is_empty() || !self.laws.is_empty();
            if has_curves && !self.needs_masses {
                return;
            }
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

/// The eigenvalues of a tensor of inertia, the largest first: O. K. Smith, *Eigenvalues of a symmetric
/// 3 × 3 matrix*, Communications of the ACM 4 (1961).
fn principal_moments(moments: [f64; 3], [xy, yz, zx]: [f64; 3]) -> [f64; 3] {
    let mean = moments.iter().sum::<f64>() / 3.0;
    let [x, y, z] = moments.map(|moment| moment - mean);
    let spread = (x * x + y * y + z * z + 2.0 * (xy * xy + yz * yz + zx * zx)) / 6.0;
    let spread = spread.sqrt();
    if spread == 0.0 {
        return moments;
    }
    let determinant = x * (y * z - yz * yz) - xy * (xy * z - yz * zx) + zx * (xy * yz - y * zx);
    let third = (determinant / (2.0 * spread.powi(3))).clamp(-1.0, 1.0).acos() / 3.0;
    let turn = 2.0 * std::f64::consts::FRAC_PI_3;
    let [largest, least] = [third, third + turn].map(|angle| mean + 2.0 * spread * angle.cos());
    [largest, 3.0 * mean - largest - least, least]
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

#[cfg(test)]
mod tests {
    use super::principal_moments;

    #[test]
    fn principal_moments_are_those_of_a_turned_tensor() {
        // Moments 1 and 3 turned by 30° about z.
        let (c, s) = (0.75, 0.25);
        let found = principal_moments(
            [1.0 * c + 3.0 * s, 1.0 * s + 3.0 * c, 2.5],
            [0.75_f64.sqrt() * 0.5 * (1.0 - 3.0), 0.0, 0.0],
        );
        for (found, expected) in found.into_iter().zip([3.0, 2.5, 1.0]) {
            assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
        }
        assert_eq!(principal_moments([2.0; 3], [0.0; 3]), [2.0; 3]);
    }
}
