//! [`DenseOutput`]: the motion over one step, at every instant of it.

use bksim_dae::{Stats, Step};

use crate::state::StateRef;

/// The motion over a step, or over the part of it before an event: positions and velocities at
/// every instant, not projected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DenseOutput<'a> {
    /// Where it begins, s.
    pub(crate) t0: f64,
    /// Where it ends, s.
    pub(crate) t1: f64,
    /// Size of the integrator's step, signed, s.
    pub(crate) h: f64,
    /// Work of the integrator so far.
    pub(crate) stats: Stats,
    /// True if the number after q and v is the work of loads and drives.
    pub(crate) has_work: bool,
    unknowns: Unknowns<'a>,
}

/// The integrator's unknowns, of which q and v are the first.
#[derive(Clone, Copy, Debug)]
enum Unknowns<'a> {
    Step(Step<'a>),
    /// Unknowns at the end, of which alone is asked.
    End(&'a [f64]),
    Instant(StateRef<'a>),
}

impl<'a> From<Step<'a>> for DenseOutput<'a> {
    fn from(step: Step<'a>) -> Self {
        Self {
            t0: step.t0(),
            t1: step.t1(),
            h: step.h(),
            stats: *step.stats(),
            has_work: false,
            unknowns: Unknowns::Step(step),
        }
    }
}

impl<'a> DenseOutput<'a> {
    /// A step from `t0` to `t1` of which only the unknowns `y1` at its end are known, the work of loads and drives among
    /// them.
    pub(crate) fn end(t0: f64, (t1, y1): (f64, &'a [f64]), stats: Stats) -> Self {
        Self { t0, t1, h: t1 - t0, stats, has_work: true, unknowns: Unknowns::End(y1) }
    }

    /// A step of no extent.
    pub(crate) fn instant(state: StateRef<'a>, h: f64, stats: Stats) -> Self {
        let unknowns = Unknowns::Instant(state);
        Self { t0: state.t, t1: state.t, h, stats, has_work: false, unknowns }
    }

    /// Degree of the polynomial that it is.
    pub(crate) fn degree(&self) -> usize {
        match self.unknowns {
            Unknowns::Step(step) => step.degree(),
            Unknowns::End(_) | Unknowns::Instant(_) => 0,
        }
    }

    /// Writes the integrator's unknowns at `t` to the first numbers of `y`, q and v before all
    /// others.
    pub(crate) fn at(&self, t: f64, y: &mut [f64]) {
        match self.unknowns {
            Unknowns::Step(step) => step.at(t, &mut y[..step.y1().len()]),
            Unknowns::End(y1) => y[..y1.len()].copy_from_slice(y1),
            Unknowns::Instant(StateRef { q, v, .. }) => {
                y[..q.len()].copy_from_slice(q);
                y[q.len()..q.len() + v.len()].copy_from_slice(v);
            }
        }
    }
}
