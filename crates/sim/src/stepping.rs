//! [`Stepping`]: a run that its caller advances, with inputs that the caller sets.
//!
//! An input is a parameter that nothing but loads depend on. It keeps its value until it is set again, as the
//! output of a sampled controller does. A run whose inputs stay as they are takes the steps of an
//! uninterrupted one, however often it is held: its states are the samples of that, to the last bit. Where
//! an input has changed, the run goes on from the state that it is held in; nothing is compiled again.

mod saved;

pub use saved::{SavedState, UnreadableState};

use std::sync::Arc;

use self_cell::self_cell;

use bksim_dae::Checkpoint;
use bksim_model::diagnostic::{Diagnostic, Rejected};
use bksim_model::{Outputs, SolveOptions};

use crate::input::InputError;
use crate::modes::Modes;
use crate::run::hold::{Ledger, Unobserved};
use crate::run::{Run, Sample, Summary};
use crate::simulation::Simulation;
use crate::start::Start;
use crate::state::{AccelerationRef, State, StateRef};

/// A run that its caller advances.
///
/// ```
/// use bksim_sim::Mechanism;
///
/// let mechanism = Mechanism::from_toml(
///     r#"
///     [parameters]
///     u = "0 N"
///     [bodies.cart]
///     mass = "2 kg"
///     [joints.rail]
///     type = "prismatic"
///     between = ["ground", "cart"]
///     axis = [1, 0]
///     coordinate = "x"
///     [loads.motor]
///     type = "force"
///     on = "cart"
///     vector = ["u", 0]
///     [solve]
///     t_end = "2 s"
///     "#,
///     "cart",
/// )?;
/// let mut run = mechanism.simulation()?.begin()?;
/// for k in 1..=20 {
///     // Bring the cart to 1 m and keep it there.
///     let [x, v] = [run.state().q[0], run.state().v[0]];
///     run.set_input("u", 40.0 * (1.0 - x) - 18.0 * v)?;
///     run.advance_to(0.1 * f64::from(k))?;
/// }
/// assert!((run.state().q[0] - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Stepping {
    held: HeldRun,
    /// Values of the parameters from now on.
    parameters: Vec<f64>,
    /// The run before the step in which it is held.
    mark: Checkpoint,
    /// Instants of that step at which it has been held.
    instants: Vec<f64>,
}

/// Everything that a part of a run with constant inputs follows from.
#[derive(Debug)]
struct Beginning {
    simulation: Simulation,
    start: Start,
    /// The state that it goes on from, and the modes that held there; nothing of a run at its very start.
    turn: Option<(State, Modes)>,
}

impl Beginning {
    /// Run with these parameters from a state on.
    fn going_on(&self, parameters: &[f64], turn: (State, Modes)) -> Result<Self, Diagnostic> {
        let mut simulation = self.simulation.clone();
        simulation.set_parameters(parameters);
        let start = simulation.going_on(&self.start, turn.0.clone(), &turn.1)?;
        Ok(Self { simulation, start, turn: Some(turn) })
    }
}

self_cell!(
    struct HeldRun {
        owner: Arc<Beginning>,
        #[covariant]
        dependent: Run,
    }
);

/// Why a run cannot be advanced.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AdvanceError {
    /// The time is not one that lies ahead in the run.
    #[error("t = {t} s lies outside of what is left of the run, {reached} s to {t_end} s")]
    Outside {
        /// The time asked for, s.
        t: f64,
        /// Where the run is held, s.
        reached: f64,
        /// End of the run, s.
        t_end: f64,
    },
    /// The motion cannot go on.
    #[error("{}", .0.message)]
    Failed(Box<Diagnostic>),
}

impl Simulation {
    /// A run from the consistent start, held there. Its end is that of the options, whose output times mean
    /// nothing to it.
    ///
    /// # Errors
    /// [`Rejected`] when there is no consistent start.
    pub fn begin(&self) -> Result<Stepping, Rejected> {
        self.begin_at(&self.start()?)
    }

    /// A run from this start, held there; a caller may have changed its state.
    ///
    /// # Errors
    /// [`Rejected`] when the motion cannot begin in that state.
    pub fn begin_at(&self, start: &Start) -> Result<Stepping, Rejected> {
        let start = self.up_to_date(start);
        let start =
            start.map_err(|error| Rejected(vec![self.diagnose_start(&error)]))?.into_owned();
        let simulation = self.without_outputs();
        let parameters = simulation.parameters().to_vec();
        let beginning = Beginning { simulation, start, turn: None };
        let mut held = HeldRun::new(Arc::new(beginning), |beginning| {
            let Beginning { simulation, start, .. } = &**beginning;
            Run::begin(simulation.problem(start), &mut Unobserved)
        });
        let mark = held.with_dependent_mut(|_, run| run.save());
        Ok(Stepping { held, parameters, mark, instants: Vec::new() })
    }

    fn without_outputs(&self) -> Self {
        let mut simulation = self.clone();
        let outputs = Outputs::Times(Vec::new());
        simulation.set_options(&SolveOptions { outputs, ..simulation.options().clone() });
        simulation
    }
}

impl Stepping {
    /// Time at which the run is held, s.
    pub fn t(&self) -> f64 {
        self.sample().t
    }

    /// Positions and velocities there.
    pub fn state(&self) -> StateRef<'_> {
        let Sample { t, q, v, .. } = self.sample();
        StateRef { t: *t, q, v }
    }

    /// Accelerations and multipliers there, with the inputs that have led there.
    pub fn acceleration(&self) -> AccelerationRef<'_> {
        let Sample { a, lambda, .. } = self.sample();
        AccelerationRef { a, lambda }
    }

    /// Joint reactions there, in the order of the joints: force, N, then moment, N m, in world axes; with
    /// the inputs that have led there.
    pub fn reactions(&self) -> &[[f64; 6]] {
        &self.sample().reactions
    }

    /// Everything that a log says of an instant.
    pub fn sample(&self) -> &Sample {
        self.held.borrow_dependent().sample()
    }

    /// The run up to the end of the last step: energies, events, changes of the method.
    pub fn summary(&self) -> &Summary {
        self.held.borrow_dependent().summary()
    }

    /// The mechanism with its values and options.
    pub fn simulation(&self) -> &Simulation {
        &self.held.borrow_owner().simulation
    }

    /// Value of each parameter from now on, in the order of the model, SI.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Lets a parameter that only loads depend on have this value from now on, SI.
    ///
    /// # Errors
    /// [`InputError`] when there is none of this name, or it is no input.
    pub fn set_input(&mut self, name: &str, value: f64) -> Result<(), InputError> {
        let id = self.simulation().settable(name)?;
        if !value.is_finite() {
            return Err(InputError::NotFinite { name: name.to_owned(), value });
        }
        self.parameters[id.0] = value;
        Ok(())
    }

    /// Advances the run to `t`, s, and holds it there.
    ///
    /// # Errors
    /// [`AdvanceError`] when `t` does not lie ahead, or the motion cannot go on; the run is then held where
    /// it got to and cannot be advanced further.
    pub fn advance_to(&mut self, t: f64) -> Result<&Sample, AdvanceError> {
        self.advance_to_unless(t, &|| false)?;
        Ok(self.sample())
    }

    /// Advance ([`Stepping::advance_to`]) that returns false where `stop`, asked before every step of the
    /// integrator, wishes so. The state is then still that of before, and the run can be advanced to what
    /// lies beyond the steps that it has taken.
    ///
    /// # Errors
    /// [`AdvanceError`] as [`Stepping::advance_to`].
    pub fn advance_to_unless(
        &mut self,
        t: f64,
        stop: &dyn Fn() -> bool,
    ) -> Result<bool, AdvanceError> {
        let t_end = self.simulation().options().t_end;
        if t == self.t() {
            return Ok(true);
        }
        let is_later = |a: f64, b: f64| (t_end - a).abs() < (t_end - b).abs();
        let stepped = self.held.borrow_dependent().reached().t;
        let reached = if is_later(stepped, self.t()) { stepped } else { self.t() };
        if !(reached.min(t_end)..=reached.max(t_end)).contains(&t) {
            return Err(AdvanceError::Outside { t, reached, t_end });
        }
        if self.parameters != self.simulation().parameters() {
            self.take_inputs()?;
        }
        self.hold_at(t, stop)
    }

    /// Goes on with the inputs that have been set, from the state in which the run is held.
    fn take_inputs(&mut self) -> Result<(), AdvanceError> {
        let run = self.held.borrow_dependent();
        let (state, ledger): (State, Ledger) = (self.state().to_state(), run.ledger());
        let turn = (state, run.modes().clone());
        let next = self.held.borrow_owner().going_on(&self.parameters, turn);
        let next = next.map_err(|fault| AdvanceError::Failed(Box::new(fault)))?;
        self.held = HeldRun::new(Arc::new(next), |beginning| {
            let Beginning { simulation, start, .. } = &**beginning;
            Run::begin_with(simulation.problem(start), ledger)
        });
        self.mark = self.held.with_dependent_mut(|_, run| run.save());
        self.instants.clear();
        Ok(())
    }

    fn hold_at(&mut self, t: f64, stop: &dyn Fn() -> bool) -> Result<bool, AdvanceError> {
        let Self { held, mark, instants, .. } = self;
        let mut take_mark = |numbers| {
            *mark = numbers;
            instants.clear();
        };
        let outcome = held.with_dependent_mut(|_, run| run.hold_at(t, &mut take_mark, stop));
        if outcome == Ok(true) {
            instants.push(t);
        }
        outcome
            .map_err(|failure| AdvanceError::Failed(Box::new(self.simulation().diagnose(&failure))))
    }
}
