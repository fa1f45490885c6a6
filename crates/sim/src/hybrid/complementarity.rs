//! The conditions that consistent modes satisfy, one function each.
//!
//! ```text
//! stop       φ ≤ 0,    λ ≥ 0,    λ φ = 0      apart or in contact, pushing but never pulling
//! friction   |λ| ≤ F₀ while p′ = 0            it holds up to its limit
//!            λ = −ς F, ς = sign p′            and opposes the motion beyond
//! kink       σ u ≥ 0                          the branch taken is that of the side
//! ```
//!
//! Where φ, p′ or u is zero, its next derivative that is not decides: φ″ ≤ 0 apart, ς p″ ≥ 0 slipping,
//! σ u′ ≥ 0 past a kink; in an impact the rates do, see [`super::impact`]. Every condition allows for
//! rounding of the stated size. Source: Glocker and Pfeiffer (1996), §5.2 and §5.3.

/// λ ≥ 0: a stop in contact pushes.
pub(super) fn pushes(force: f64, rounding: f64) -> bool {
    force >= -rounding
}

/// φ″ ≤ 0: a stop that is apart, φ = φ′ = 0, does not close at once. In an impact ξ ≤ 0.
pub(super) fn stays_apart(acceleration: f64, rounding: f64) -> bool {
    acceleration <= rounding
}

/// |λ| ≤ F₀: friction holds its motion.
pub(super) fn holds(force: f64, limit: f64, rounding: f64) -> bool {
    force.abs() <= limit + rounding
}

/// ς p″ ≥ 0: from rest, the motion slips in the direction that its friction opposes.
pub(super) fn slips_against_friction(sign: f64, acceleration: f64, rounding: f64) -> bool {
    sign * acceleration >= -rounding
}

/// σ u′ ≥ 0: from a kink, the motion leads to the side of the branch taken.
pub(super) fn leaves_to_its_side(sign: f64, rate: f64, rounding: f64) -> bool {
    sign * rate >= -rounding
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_hold_on_their_boundary_and_end_beyond_rounding() {
        let eps = 1e-9;
        for (name, at, beyond) in [
            ("λ ≥ 0", pushes(-eps, eps), pushes(-2.0 * eps, eps)),
            ("φ″ ≤ 0", stays_apart(eps, eps), stays_apart(2.0 * eps, eps)),
            ("|λ| ≤ F₀", holds(-5.0, 5.0, eps), holds(-5.0 - 2.0 * eps, 5.0, eps)),
            (
                "ς p″ ≥ 0",
                slips_against_friction(-1.0, eps, eps),
                slips_against_friction(-1.0, 2.0 * eps, eps),
            ),
            (
                "σ u′ ≥ 0",
                leaves_to_its_side(-1.0, eps, eps),
                leaves_to_its_side(-1.0, 2.0 * eps, eps),
            ),
        ] {
            assert!(at && !beyond, "{name}: {at} on the boundary, {beyond} beyond it");
        }
    }
}
