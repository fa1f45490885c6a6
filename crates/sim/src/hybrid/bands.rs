//! [`Bands`]: how near to zero an indicator counts as zero.

use crate::modes::indicators::{EventIndicators, IndicatorValues};
use crate::multiplier::largest;
use bksim_mbs::system::SwitchOf;

/// Sizes below which indicators are zero, at one tolerance.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Bands {
    /// By switch, in the unit of its function.
    pub(crate) kinks: Vec<f64>,
    /// Of rounding, m or rad.
    pub(crate) position: f64,
    /// m/s or rad/s.
    pub(crate) rate: f64,
    /// Bounces no higher, m or rad, and no faster, m/s or rad/s, come to rest.
    pub(crate) rest: [f64; 2],
    /// Part of the largest multiplier that functions of multipliers are known to.
    pub(crate) force: f64,
}

/// Part of the absolute tolerance that functions and rates are known to.
const PART: f64 = 1e-3;
/// Part of a function that is rounding.
const ROUNDING: f64 = 1e-12;
/// A body that falls through the band gains speed; no more than rounding is needed.
const ROUNDING_OF_POSITION: f64 = 64.0 * f64::EPSILON;
/// An event is located where its function has passed the band; bands this much wider hold all that is
/// zero there.
const SLACK: f64 = 4.0;
/// Part of the relative tolerance that multipliers are known to, and of their size that is rounding.
const PART_OF_FORCE: f64 = 0.1;
const ROUNDING_OF_FORCE: f64 = 1e-9;
/// Rates by which the run lets held rows drift, in those that come to rest.
const DRIFT: f64 = 10.0;

impl Bands {
    /// The bands for the absolute and the relative tolerance, with the rounding of these values of the switches.
    ///
    /// Switches that depend on time alone have none: their instants are known exactly.
    pub(crate) fn new(
        (atol, rtol): (f64, f64),
        values: &IndicatorValues,
        indicators: &EventIndicators,
    ) -> Self {
        let band = |(u, of): (&f64, &SwitchOf)| match of {
            SwitchOf::Time => 0.0,
            SwitchOf::State | SwitchOf::Multipliers => PART * atol + ROUNDING * u.abs(),
        };
        Self {
            kinks: values.kinks.iter().zip(&indicators.switches).map(band).collect(),
            position: ROUNDING_OF_POSITION,
            rate: PART * atol,
            rest: [atol; 2],
            force: ROUNDING_OF_FORCE.max(PART_OF_FORCE * rtol),
        }
    }

    /// The band of a switch that depends on multipliers, of which these are all: what tolerances make of a force that is
    /// zero must not be an event.
    pub(super) fn of_multipliers(&self, kink: usize, lambda: &[f64]) -> f64 {
        let size = self.force * largest(lambda);
        if size.is_finite() { self.kinks[kink] + size } else { self.kinks[kink] }
    }

    /// φ ≥ 0 up to rounding: the gap of a stop is closed.
    pub(super) fn is_closed(&self, penetration: f64) -> bool {
        penetration >= -SLACK * self.position
    }

    /// φ′ > 0 beyond rounding: bodies run into a stop.
    pub(super) fn is_approaching(&self, rate: f64) -> bool {
        rate > SLACK * self.rate
    }

    /// The rate of a motion that other rows hold: no more than the run lets them drift by, m/s or rad/s.
    pub(super) fn drift(&self, v: &[f64]) -> f64 {
        DRIFT * self.rest[1] * largest(v).max(1.0)
    }

    /// φ′ = 0 or p′ = 0 up to rounding.
    pub(crate) fn is_at_rest(&self, rate: f64) -> bool {
        rate.abs() <= SLACK * self.rate
    }
}
