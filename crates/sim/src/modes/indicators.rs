//! Event indicators: the functions of the motion whose signs decide the modes, compiled.
//!
//! ```text
//! switch     u                 u′, of functions of λ 0
//! stop       φ, φ′, ε, r       φ″
//! friction   p, p′, F, F₀      p″
//! ```
//!
//! r is positive where a place of a contact is one, and one of other stops; friction of a contact has its coefficient
//! in the place of p. The left column is a function of (t, q, v), u, F and F₀ may be of λ too, the right one of the
//! accelerations.

use bksim_expr::{Expr, SymbolId, TapeError};

use super::{ContactMode, Modes};
use crate::function::{Buffers, Function};
use crate::sampled::Held;
use bksim_mbs::contact::{Law, pressed_by};
use bksim_mbs::system::{Switch, SwitchOf, SymbolicSystem};
use bksim_model::{LoadId, Model};

/// Outlines that end at one place touch, whichever of them rounding makes longer, m.
const BEYOND_END: f64 = 1e-9;

/// The indicators of one mechanism.
#[derive(Clone, Debug)]
pub(crate) struct EventIndicators {
    /// u of every switch, then four numbers per contact, see [`ContactState::of`].
    functions: Function,
    /// No multipliers.
    idle_lambda: Vec<f64>,
    /// u′ of every switch, then the acceleration of every contact.
    rates: Function,
    /// Kind of each switch.
    pub(crate) switches: Vec<SwitchOf>,
    /// By switch: σ where u is zero and stays so, as the author wrote the condition.
    pub(crate) at_zero: Vec<f64>,
    pub(crate) contacts: Vec<CompiledContact>,
    /// Of friction of a contact: the stops whose forces press it together.
    pub(crate) pressed_by: Vec<Vec<usize>>,
    n_held: usize,
    has_latches: bool,
}

/// A contact without its expressions.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct CompiledContact {
    pub(crate) load: LoadId,
    /// Constraint row of the contact.
    pub(crate) row: usize,
    pub(crate) law: ContactLaw,
    /// Whether it is a place where outlines touch, or their friction.
    pub(crate) is_outline: bool,
    /// Of friction in two directions: the contact of the other one.
    pub(crate) other: Option<usize>,
}

/// The law of a contact.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum ContactLaw {
    Stop,
    Friction,
}

/// One indicator.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Indicator {
    /// That of the switch of this index.
    Kink(usize),
    /// That of the contact of this index.
    Contact(usize),
}

/// The state of one contact, whatever its mode.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum ContactState {
    /// A stop.
    Stop {
        /// φ, m or rad: negative while there is a gap.
        penetration: f64,
        /// φ′.
        rate: f64,
        /// ε.
        restitution: f64,
        /// Positive as far as the place reaches.
        reach: f64,
    },
    /// Dry friction on a motion.
    Friction {
        /// p, m or rad.
        position: f64,
        /// p′.
        rate: f64,
        /// |p′|, of two directions together.
        speed: f64,
        /// F, N or N m.
        sliding: f64,
        /// F₀, no less than F.
        sticking: f64,
    },
}

/// All indicators at one instant.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct IndicatorValues {
    /// u of every switch.
    pub(crate) kinks: Vec<f64>,
    pub(crate) contacts: Vec<ContactState>,
}

/// How the indicators change at one instant.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct IndicatorRates<'a> {
    /// u′ of every switch.
    pub(crate) kinks: &'a [f64],
    /// φ″ or p″ of every contact.
    pub(crate) contacts: &'a [f64],
}

impl ContactState {
    /// Outputs per contact of the compiled functions.
    const N_OUTPUTS: usize = 4;

    /// From φ, φ′, ε and the reach, or from p, p′, F and F₀.
    fn of(law: ContactLaw, outputs: &[f64]) -> Self {
        let [position, rate, first, second] = *outputs else {
            unreachable!("every contact has four outputs")
        };
        match law {
            ContactLaw::Stop => {
                let reach = second + BEYOND_END;
                Self::Stop { penetration: position, rate, restitution: first, reach }
            }
            ContactLaw::Friction => {
                let speed = rate.abs();
                Self::Friction { position, rate, speed, sliding: first, sticking: second.max(0.0) }
            }
        }
    }

    /// φ′ or p′.
    pub(crate) fn rate(&self) -> f64 {
        match *self {
            Self::Stop { rate, .. } | Self::Friction { rate, .. } => rate,
        }
    }

    /// |φ′| or |p′|, of friction in two directions that of both together.
    pub(crate) fn speed(&self) -> f64 {
        match *self {
            Self::Stop { rate, .. } => rate.abs(),
            Self::Friction { speed, .. } => speed,
        }
    }

    /// F₀ of friction.
    pub(crate) fn sticking(&self) -> f64 {
        match *self {
            Self::Stop { .. } => 0.0,
            Self::Friction { sticking, .. } => sticking,
        }
    }
}

impl EventIndicators {
    /// Compiles the indicators of `system`.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub(crate) fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let system = system.integrated();
        let (functions, contacts) = indicator_functions(model, system);
        let rates = indicator_rates(model, system, &functions);

        // Functions of time and the state, rates of the accelerations too.
        let coordinates = system.coordinates();
        let parameters = system.parameters(model);
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let a: Vec<SymbolId> = coordinates.iter().map(|c| c.a).collect();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let t = [model.time];
        Ok(Self {
            functions: Function::compile(model, &functions, &[&t, &q, &v, &lambda], &parameters)?,
            idle_lambda: vec![0.0; lambda.len()],
            rates: Function::compile(model, &rates, &[&t, &q, &v, &a], &parameters)?,
            switches: system.switches.iter().map(|switch| switch.of).collect(),
            at_zero: system.switches.iter().map(|switch| switch.at_zero.unwrap_or(1.0)).collect(),
            pressed_by: (system.contacts.iter())
                .map(|contact| pressed_by(model, &system.contacts, contact))
                .collect(),
            contacts,
            n_held: model.held.len(),
            has_latches: model.held.iter().any(|signal| !signal.rows().is_empty()),
        })
    }

    /// True if nothing ever switches.
    pub(crate) fn is_empty(&self) -> bool {
        self.switches.is_empty() && self.contacts.is_empty() && !self.has_latches
    }

    /// True if nothing switches but expressions of multipliers, whose signs a run finds by itself.
    pub(crate) fn is_still(&self) -> bool {
        (0..self.switches.len()).all(|k| self.is_of_multipliers(k))
            && self.contacts.is_empty()
            && !self.has_latches
    }

    /// The switches that depend on multipliers.
    pub(crate) fn of_multipliers(&self) -> impl Iterator<Item = usize> {
        (0..self.switches.len()).filter(|&k| self.is_of_multipliers(k))
    }

    /// True if a switch depends on multipliers.
    pub(crate) fn is_of_multipliers(&self, switch: usize) -> bool {
        self.switches[switch] == SwitchOf::Multipliers
    }

    /// True if surfaces rub in two directions.
    pub(crate) fn has_planes(&self) -> bool {
        self.contacts.iter().any(|contact| contact.other.is_some())
    }

    /// True if outlines rub.
    pub(crate) fn has_tracks(&self) -> bool {
        self.pressed_by.iter().any(|stops| !stops.is_empty())
    }

    /// The modes before anything is known: stops open, friction without force, every σ positive but those of expressions
    /// of multipliers, which are as written, nothing held.
    pub(crate) fn idle(&self) -> Modes {
        let idle = |contact: &CompiledContact| match contact.law {
            ContactLaw::Stop => ContactMode::Open,
            ContactLaw::Friction => ContactMode::Slip(0.0),
        };
        Modes {
            signs: self.switches.iter().map(|of| sign_before_any(*of)).collect(),
            contacts: self.contacts.iter().map(idle).collect(),
            held: Held::zeros(self.n_held),
        }
    }

    /// The modes with the signs that the switches have at a state and these values held, all contacts idle. Where
    /// functions are zero, the first conditions on them are as written; so is what depends on multipliers.
    pub(crate) fn decided(
        &self,
        held: Held,
        parameters: &[f64],
        (t, q, v): (f64, &[f64], &[f64]),
    ) -> Modes {
        let modes = Modes { held, ..self.idle() };
        self.with_signs_at(modes, parameters, (t, q, v), &|k| self.at_zero[k])
    }

    /// `modes` with the signs that the switches have at a state, and with those of `at_zero` where functions are zero:
    /// with zero itself every condition is as written.
    pub(crate) fn with_signs_at(
        &self,
        mut modes: Modes,
        parameters: &[f64],
        (t, q, v): (f64, &[f64], &[f64]),
        at_zero: &dyn Fn(usize) -> f64,
    ) -> Modes {
        // A function may have the mode of one before it in it.
        for _ in 0..=modes.signs.len() {
            let values = self.at(&modes.parameters_with_modes(parameters)).values(t, q, v).clone();
            let sign = |(k, &u): (usize, &f64)| match u {
                _ if self.is_of_multipliers(k) => 0.0,
                u if u < 0.0 => -1.0,
                0.0 => at_zero(k),
                _ => 1.0,
            };
            let signs = values.kinks.iter().enumerate().map(sign).collect();
            if modes.signs == signs {
                break;
            }
            modes.signs = signs;
        }
        modes
    }

    /// The modes whose numbers follow the parameters in [`Modes::parameters_with_modes`]; `None` when
    /// their count is not that of these switches and contacts.
    pub(crate) fn modes_from_numbers(&self, numbers: &[f64]) -> Option<Modes> {
        let (signs, mut rest) = numbers.split_at_checked(self.switches.len())?;
        let mut contacts = Vec::with_capacity(self.contacts.len());
        for contact in &self.contacts {
            let (mode, after) = match (contact.law, rest) {
                (ContactLaw::Stop, [active, after @ ..]) if *active == 0.0 => {
                    (ContactMode::Open, after)
                }
                (ContactLaw::Stop, [_, after @ ..]) => (ContactMode::Closed, after),
                (ContactLaw::Friction, [active, sign, _, after @ ..]) if *active == 0.0 => {
                    (ContactMode::Slip(*sign), after)
                }
                (ContactLaw::Friction, [_, _, position, after @ ..]) => {
                    (ContactMode::Stick(*position), after)
                }
                _ => return None,
            };
            contacts.push(mode);
            rest = after;
        }
        let held = Held::of_values(rest);
        (rest.len() == self.n_held).then(|| Modes { signs: signs.to_vec(), contacts, held })
    }

    /// The indicators at the given parameters, which end with the modes.
    pub(crate) fn at(&self, parameters: &[f64]) -> IndicatorEvaluator<'_> {
        IndicatorEvaluator {
            indicators: self,
            functions: self.functions.buffers(parameters),
            rates: self.rates.buffers(parameters),
            values: IndicatorValues::default(),
        }
    }
}

/// The functions of a system with modes that decide them, then how they change: see the table at the top of this file.
pub fn event_functions(model: &Model, system: &SymbolicSystem) -> [Vec<Expr>; 2] {
    let (functions, _) = indicator_functions(model, system);
    let rates = indicator_rates(model, system, &functions);
    [functions, rates]
}

/// σ of a switch before anything is known.
fn sign_before_any(of: SwitchOf) -> f64 {
    if of == SwitchOf::Multipliers { 0.0 } else { 1.0 }
}

/// u′ of every switch, then the acceleration of every contact.
fn indicator_rates(model: &Model, system: &SymbolicSystem, functions: &[Expr]) -> Vec<Expr> {
    let kinematics = &system.kinematics;
    let (kinks, of_contacts) = functions.split_at(system.switches.len());
    let rate = |(&u, switch): (&Expr, &Switch)| match switch.of {
        // Without a rate of multipliers there is none.
        SwitchOf::Multipliers => model.pool.zero(),
        _ => kinematics.second_rate(model, u),
    };
    let rates = kinks.iter().zip(&system.switches).map(rate);
    let of_contacts = of_contacts.chunks_exact(ContactState::N_OUTPUTS);
    let of_contacts = of_contacts.map(|four| kinematics.second_rate(model, four[1]));
    rates.chain(of_contacts).collect()
}

/// u of every switch, then φ, φ′, ε and r of every stop, and p, p′, F and F₀ of every friction, of a system with
/// modes; and the contacts.
pub(crate) fn indicator_functions(
    model: &Model,
    system: &SymbolicSystem,
) -> (Vec<Expr>, Vec<CompiledContact>) {
    let pool = &model.pool;
    let mut functions: Vec<Expr> = system.switches.iter().map(|s| s.function).collect();
    let mut contacts = Vec::new();
    for contact in &system.contacts {
        let (law, position, numbers) = match contact.law {
            Law::Stop { restitution, reach } => {
                (ContactLaw::Stop, contact.expression, [restitution, reach])
            }
            Law::Friction { sliding, sticking, .. } => {
                let lambda = system.constraints[contact.row].lambda;
                let numbers = contact.law.friction(pool, lambda).unwrap_or([sliding, sticking]);
                (ContactLaw::Friction, contact.position, numbers)
            }
        };
        functions.extend([position, contact.rate]);
        functions.extend(numbers);
        let is_outline = model.loads[contact.load.0].contact().is_some();
        let other = match contact.law {
            Law::Friction { other, .. } => other,
            Law::Stop { .. } => None,
        };
        let (load, row) = (contact.load, contact.row);
        contacts.push(CompiledContact { load, row, law, is_outline, other });
    }
    (functions, contacts)
}

/// [`EventIndicators`] at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub(crate) struct IndicatorEvaluator<'a> {
    indicators: &'a EventIndicators,
    functions: Buffers,
    rates: Buffers,
    values: IndicatorValues,
}

impl IndicatorEvaluator<'_> {
    /// The indicators at a state, with friction as without multipliers.
    pub(crate) fn values(&mut self, t: f64, q: &[f64], v: &[f64]) -> &IndicatorValues {
        let lambda = &self.indicators.idle_lambda;
        self.values_with(t, (q, v), lambda)
    }

    /// The indicators at a state with these multipliers.
    pub(crate) fn values_with(
        &mut self,
        t: f64,
        (q, v): (&[f64], &[f64]),
        lambda: &[f64],
    ) -> &IndicatorValues {
        let EventIndicators { functions, switches, contacts, .. } = self.indicators;
        let out = functions.evaluate(&mut self.functions, &[&[t], q, v, lambda]);
        let (kinks, outputs) = out.split_at(switches.len());
        self.values.kinks.clear();
        self.values.kinks.extend_from_slice(kinks);
        let outputs = outputs.chunks_exact(ContactState::N_OUTPUTS);
        let states = contacts.iter().zip(outputs);
        self.values.contacts.clear();
        self.values
            .contacts
            .extend(states.map(|(contact, four)| ContactState::of(contact.law, four)));
        for (k, contact) in contacts.iter().enumerate() {
            let Some(other) = contact.other else { continue };
            let both = self.values.contacts[k].rate().hypot(self.values.contacts[other].rate());
            if let ContactState::Friction { speed, .. } = &mut self.values.contacts[k] {
                *speed = both;
            }
        }
        &self.values
    }

    /// How the indicators change at a state with these accelerations.
    pub(crate) fn rates(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64]) -> IndicatorRates<'_> {
        let EventIndicators { rates, switches, .. } = self.indicators;
        let out = rates.evaluate(&mut self.rates, &[&[t], q, v, a]);
        let (kinks, contacts) = out.split_at(switches.len());
        IndicatorRates { kinks, contacts }
    }

    /// Writes λ = −ς F of friction that slips: a load in the equations, but a multiplier for those
    /// who read the motion. Returns the first friction whose F is below zero by more than `slack`.
    pub(crate) fn fill_slip_friction(
        &mut self,
        modes: &Modes,
        (t, q, v): (f64, &[f64], &[f64]),
        lambda: &mut [f64],
        slack: f64,
    ) -> Option<LoadId> {
        if modes.contacts.iter().all(|mode| !matches!(mode, ContactMode::Slip(_))) {
            return None;
        }
        let contacts = &self.indicators.contacts;
        let values = self.values_with(t, (q, v), lambda);
        let mut driving = None;
        for ((contact, state), mode) in contacts.iter().zip(&values.contacts).zip(&modes.contacts) {
            if let (ContactMode::Slip(sign), ContactState::Friction { sliding, .. }) = (mode, state)
            {
                // In two directions it is a component already.
                let sign = if contact.other.is_some() { 1.0 } else { *sign };
                lambda[contact.row] = -sign * sliding;
                if sign != 0.0 && *sliding < -slack && !contact.is_outline {
                    driving = driving.or(Some(contact.load));
                }
            }
        }
        driving
    }
}
