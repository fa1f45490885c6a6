//! Changes of a motion across an event: they jump, because the event comes at another time.
//!
//! ```text
//! dt = −(ψ_x s + ψ_p) / ψ̇            ψ(t, x, p) = 0 where it switches
//! s* = s⁻ + x′⁻ dt                    the change of the state in which it does
//! s⁺ = R_x s* + R_t dt + R_p − x′⁺ dt   x⁺ = R(t, x⁻, p): an impact, else nothing
//! ```
//!
//! ψ̇ is the rate of ψ along the motion before: where it vanishes, the motion only grazes, and for other values it
//! would not: then there is no derivative. An impact is [Newton's law](crate::hybrid) as a linear system, whose
//! solution v⁺, Λ changes with its matrix and right side. Sources: M. A. Aizerman and F. R. Gantmacher, *On the
//! stability of periodic motions*, J. Appl. Math. Mech. 22 (1958); P. C. Müller, *Calculation of Lyapunov exponents
//! for dynamic systems with discontinuities*, Chaos Solitons Fractals 5 (1995).

use nalgebra::{DMatrix, DVector};

use super::direction::Change;
use super::follower::Follower;
use super::tangent::{TangentPoint, Tangents};
use crate::hybrid::{ImpactRecord, Passage};
use crate::modes::ContactMode;
use crate::modes::indicators::{ContactLaw, ContactState, Indicator};
use crate::run::Undefined;
use crate::state::{AccelerationRef, StateRef};

/// Part of velocities or accelerations by which they jump as little as rounding makes them.
const NO_JUMP: f64 = 1e-9;
/// Part by which times of events at one instant may change differently.
const TOGETHER: f64 = 1e-6;
/// A motion that would turn back by itself within this many tolerances beyond a stop only grazes it.
const TOUCH: f64 = 10.0;

/// The motion just before an event, with the changes of its accelerations and multipliers with time.
struct Before<'p> {
    state: StateRef<'p>,
    a: Vec<f64>,
    lambda: Vec<f64>,
    rates: Vec<f64>,
}

impl Before<'_> {
    fn point(&self) -> TangentPoint<'_> {
        let acceleration = AccelerationRef { a: &self.a, lambda: &self.lambda };
        TangentPoint { state: self.state, acceleration }
    }
}

impl Follower<'_, '_> {
    /// Takes the changes across an event.
    ///
    /// # Errors
    /// [`Undefined`] where they have no value after it.
    pub(super) fn jump(&mut self, passage: &Passage) -> Result<(), Undefined> {
        let before = self.before(passage)?;
        let after = &passage.after;
        if let Some(&stop) = passage.fired.iter().find(|of| self.is_only_touched(**of, passage)) {
            return Err(self.touched(stop));
        }
        let is_smooth = after.impacts.is_empty()
            && is_near(&after.v, before.state.v)
            && is_near(&after.a, &before.a);
        let instants = if is_smooth {
            vec![0.0; self.n_sensitive()]
        } else {
            self.instants(passage, &before)?
        };

        // The state in which it switches, then the one that follows.
        for (k, dt) in instants.into_iter().enumerate() {
            let (mut dq, mut dv) = self.column(k);
            add(&mut dq, dt, before.state.v);
            add(&mut dv, dt, &before.a);
            let change = Change { dt, ..self.equations.change(k) };
            for impact in &after.impacts {
                self.strike(impact, before.state, (change, k), (&dq, &mut dv))?;
            }
            add(&mut dq, -dt, &after.v);
            add(&mut dv, -dt, &after.a);
            self.set_column(k, &dq, &dv);
        }

        // Go on in the modes after it.
        let parameters = after.modes.parameters_with_modes(self.problem.parameters);
        self.enter(parameters, after.inactive.clone());
        let state = StateRef { t: passage.t(), q: &after.q, v: &after.v };
        let acceleration = AccelerationRef { a: &after.a, lambda: &after.lambda };
        let at = TangentPoint { state, acceleration };
        self.take_offsets(at);
        if self.onto_constraints(at) { Ok(()) } else { Err(Undefined::Singular) }
    }

    /// The motion just before an event, in the modes until then; changes are taken up to there.
    fn before<'p>(&mut self, passage: &'p Passage) -> Result<Before<'p>, Undefined> {
        let Passage { state, before, inactive, .. } = passage;
        let parameters = before.parameters_with_modes(self.problem.parameters);
        if self.phase.parameters != parameters {
            self.enter(parameters, inactive.clone());
        }
        let state = state.as_ref();
        if !self.phase.variation.take(state) {
            return Err(Undefined::Singular);
        }
        let variation = &self.phase.variation;
        let (a, lambda) = (variation.a.clone(), variation.lambda.clone());
        let mut rates = vec![0.0; a.len() + lambda.len()];
        variation.change_into(variation.time(), (state.v, &a), &mut rates);

        // A motion that ran into a place without values has been taken a moment ahead.
        let ahead = state.t - self.t;
        if ahead != 0.0 {
            for k in 0..self.n_sensitive() {
                let (mut dq, mut dv) = self.column(k);
                let mut dz = vec![0.0; rates.len()];
                self.phase.variation.change_into(k, (&dq, &dv), &mut dz);
                add(&mut dq, ahead, &dv);
                add(&mut dv, ahead, &dz[..a.len()]);
                self.set_column(k, &dq, &dv);
            }
            self.t = state.t;
        }
        Ok(Before { state, a, lambda, rates })
    }

    /// The change of the time of an event, by quantity.
    fn instants(&mut self, passage: &Passage, before: &Before<'_>) -> Result<Vec<f64>, Undefined> {
        let mut instants = vec![0.0; self.n_sensitive()];
        let nq = before.a.len();
        let zeros = vec![0.0; self.equations.n_parameters];
        let passing = Change { dt: 1.0, dp: &zeros };
        for (idx, &fired) in passage.fired.iter().enumerate() {
            // Along the motion, and by each quantity.
            let rates = before.rates.split_at(nq);
            let speed =
                self.of_indicator(fired, before, passing, (before.state.v, &before.a), rates);
            if self.only_grazes(fired, before, speed) {
                return Err(self.touched(fired));
            }
            for k in 0..instants.len() {
                let (dq, dv) = self.column(k);
                let mut dz = vec![0.0; before.rates.len()];
                self.phase.variation.change_into(k, (&dq, &dv), &mut dz);
                let change = self.equations.change(k);
                let moved = self.of_indicator(fired, before, change, (&dq, &dv), dz.split_at(nq));
                let dt = -moved / speed;
                let is_other = idx > 0
                    && (dt - instants[k]).abs() > TOGETHER * dt.abs().max(instants[k].abs());
                if is_other {
                    return Err(Undefined::Together);
                }
                instants[k] = dt;
            }
        }
        let are_finite = instants.iter().all(|dt| dt.is_finite());
        if are_finite { Ok(instants) } else { Err(self.touched(passage.fired[0])) }
    }

    /// The change of an indicator along changes of the state, and of accelerations and multipliers with it.
    fn of_indicator(
        &mut self,
        indicator: Indicator,
        before: &Before<'_>,
        change: Change<'_>,
        state: (&[f64], &[f64]),
        dz: (&[f64], &[f64]),
    ) -> f64 {
        let n_kinks = self.problem.compiled.indicators.switches.len();
        let arguments = before.point().arguments(change, state, dz);
        let out = self.following.indicators.evaluate(&mut self.phase.indicators, &[&arguments]);
        let contact = match indicator {
            Indicator::Kink(kink) => return out[kink],
            Indicator::Contact(contact) => contact,
        };
        let four = &out[n_kinks + 4 * contact..][..4];
        let row = self.problem.compiled.indicators.contacts[contact].row;
        match self.phase.modes.contacts[contact] {
            ContactMode::Open => four[0],
            ContactMode::Closed => dz.1[row],
            ContactMode::Slip(_) => four[1],
            ContactMode::Stick(_) => four[3] - before.lambda[row].signum() * dz.1[row],
        }
    }

    /// True where a function that passes zero at this rate would turn back at once.
    fn only_grazes(&mut self, indicator: Indicator, before: &Before<'_>, speed: f64) -> bool {
        let Indicator::Contact(contact) = indicator else { return speed == 0.0 };
        if self.phase.modes.contacts[contact] != ContactMode::Open {
            return speed == 0.0;
        }
        let StateRef { t, q, v } = before.state;
        let bend = self.phase.values.rates(t, q, v, &before.a).contacts[contact];
        let reach = TOUCH * self.problem.options.atol;
        speed <= 0.0 || bend < 0.0 && speed * speed <= -2.0 * bend * reach
    }

    /// True of a stop that the run went past without an impact, because the motion turns back by itself.
    fn is_only_touched(&self, indicator: Indicator, passage: &Passage) -> bool {
        let Indicator::Contact(k) = indicator else { return false };
        let contact = &self.problem.compiled.indicators.contacts[k];
        let modes = [&passage.before, &passage.after.modes].map(|modes| modes.contacts[k]);
        let is_stop = contact.law == ContactLaw::Stop && !contact.is_outline;
        is_stop && modes == [ContactMode::Open; 2] && passage.after.impacts.is_empty()
    }

    fn touched(&self, indicator: Indicator) -> Undefined {
        match indicator {
            Indicator::Kink(_) => Undefined::Touching(None),
            Indicator::Contact(contact) => {
                Undefined::Touching(Some(self.problem.compiled.indicators.contacts[contact].load))
            }
        }
    }

    /// Takes changes of v across an impact.
    ///
    /// ```text
    /// M Δ + Bᵀ Λ = 0                Δ = v⁺ − v⁻, B the rows that hold or take an impulse
    /// φ′(v⁺) + ε φ′(v⁻) = 0         ε = 0 of rows that hold
    /// ```
    fn strike(
        &mut self,
        impact: &ImpactRecord,
        StateRef { t, q, .. }: StateRef<'_>,
        (change, k): (Change<'_>, usize),
        (dq, dv): (&[f64], &mut [f64]),
    ) -> Result<(), Undefined> {
        let compiled = self.problem.compiled;
        let parameters = impact.modes.parameters_with_modes(self.problem.parameters);
        let mut tangents = Tangents::new(self.equations, compiled, &parameters, &[]);
        let contacts = &compiled.indicators.contacts;
        let stops = impact.stops.iter().map(|&(contact, _)| contacts[contact].row);
        let rows: Vec<usize> = impact.held.iter().copied().chain(stops).collect();
        let [from, to] = &impact.velocities;
        let [from, to] = [from, to].map(|v| StateRef { t, q, v });
        let (nq, nc) = (q.len(), compiled.nc());
        let idle = (vec![0.0; nq], vec![0.0; nc]);
        let at = |state, acceleration| TangentPoint { state, acceleration };
        let nothing = AccelerationRef { a: &idle.0, lambda: &idle.1 };

        // The matrix of the impact, and Λ.
        let jacobian = tangents.jacobian_at(at(from, nothing));
        let mass = tangents.mass_at(from);
        let n = nq + rows.len();
        let mut matrix = DMatrix::zeros(n, n);
        matrix.view_mut((0, 0), (nq, nq)).copy_from(&mass);
        for (i, &row) in rows.iter().enumerate() {
            for j in 0..nq {
                matrix[(nq + i, j)] = jacobian[(row, j)];
                matrix[(j, nq + i)] = jacobian[(row, j)];
            }
        }
        let lu = matrix.clone().lu();
        let leap = DVector::from_fn(nq, |i, _| to.v[i] - from.v[i]);
        let mut right = DVector::zeros(n);
        right.rows_mut(nq, rows.len()).copy_from(&(matrix.view((nq, 0), (rows.len(), nq)) * &leap));
        let solved = lu.solve(&right).ok_or(Undefined::Singular)?;
        let mut impulses = vec![0.0; nc];
        rows.iter().enumerate().for_each(|(i, &row)| impulses[row] = solved[nq + i]);

        // The changes of both equations with Δ and Λ held.
        let struck = AccelerationRef { a: leap.as_slice(), lambda: &impulses };
        let momentum = tangents.of_forces(at(from, struck), change, (dq, dv)).to_vec();
        let without = tangents.of_forces(at(from, nothing), change, (dq, dv)).to_vec();
        for i in 0..nq {
            right[i] = without[i] - momentum[i];
        }
        let leaving = tangents.of_velocities(at(to, nothing), change, (dq, dv)).to_vec();
        let coming = tangents.of_velocities(at(from, nothing), change, (dq, dv)).to_vec();
        for (i, &row) in rows.iter().enumerate() {
            right[nq + i] = -leaving[row];
            let Some(stop) = i.checked_sub(impact.held.len()) else { continue };
            let (contact, restitution) = impact.stops[stop];
            right[nq + i] -= restitution * coming[row];
            if restitution != 0.0 {
                let (changed, speed) = self.of_restitution(contact, from, (change, k), (dq, dv));
                right[nq + i] -= changed * speed;
            }
        }
        let solved = lu.solve(&right).ok_or(Undefined::Singular)?;
        dv.iter_mut().zip(solved.iter()).for_each(|(dv, step)| *dv += step);
        if dv.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(Undefined::Singular) }
    }

    /// The change of the restitution of a stop, and the speed of approach.
    fn of_restitution(
        &mut self,
        contact: usize,
        state: StateRef<'_>,
        (change, _): (Change<'_>, usize),
        (dq, dv): (&[f64], &[f64]),
    ) -> (f64, f64) {
        let compiled = self.problem.compiled;
        let idle = (vec![0.0; dq.len()], vec![0.0; compiled.nc()]);
        let acceleration = AccelerationRef { a: &idle.0, lambda: &idle.1 };
        let arguments =
            TangentPoint { state, acceleration }.arguments(change, (dq, dv), (&idle.0, &idle.1));
        let n_kinks = compiled.indicators.switches.len();
        let out = self.following.indicators.evaluate(&mut self.phase.indicators, &[&arguments]);
        let changed = out[n_kinks + 4 * contact + 2];
        let values = self.phase.values.values(state.t, state.q, state.v);
        let speed = match values.contacts[contact] {
            ContactState::Stop { rate, .. } => rate,
            ContactState::Friction { .. } => 0.0,
        };
        (changed, speed)
    }
}

fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}

fn is_near(one: &[f64], other: &[f64]) -> bool {
    let size = other.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
    one.iter().zip(other).all(|(a, b)| (a - b).abs() <= NO_JUMP * size)
}
