//! [`EffortContacts`]: what stops and dry friction do along a given motion.
//!
//! ```text
//! φ = 0, φ̇ = 0, φ̈ = 0     a stop bears, λ ≥ 0
//! ṗ ≠ 0, or ṗ = 0 ≠ p̈     friction slides with the sign of that: λ = −ς F
//! ṗ = 0 = p̈               it rests: |λ| ≤ F₀
//! ```
//!
//! The motion is known, and so is the sense in which everything slides; F and F₀ are the functions of a run.

use std::collections::BTreeSet;

use bksim_expr::{Expr, SymbolId, Tape, Workspace};
use bksim_mbs::contact::{Contact, Law};
use bksim_model::{LoadKind, Model, MotionKind};

use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::scalar::Rates;

/// Rates and accelerations below this part of the largest along a motion are rounding.
const AT_REST: f64 = 1e-9;
/// Gaps and penetrations that are rounding, rad or parts of the longest link.
pub(crate) const CLOSED: f64 = 1e-9;

/// All stops and friction of a mechanism along a motion.
pub(crate) struct EffortContacts {
    /// φ of stops, p of friction.
    rates: Rates,
    laws: Tape,
    laws_space: Workspace,
    /// In the order of the system.
    pub(crate) all: Vec<EffortContact>,
    /// Place of the first number of a contact among the parameters.
    first_number: usize,
    /// Rows whose multipliers loads and friction depend on.
    pub(crate) pressing: Vec<usize>,
    n_rows: usize,
}

/// A stop or friction.
pub(crate) struct EffortContact {
    pub(crate) name: String,
    pub(crate) span: bksim_model::diagnostic::Span,
    /// Constraint row of the contact.
    pub(crate) row: usize,
    /// True of a rope that may become slack.
    pub(crate) is_rope: bool,
    /// `min` or `max` of a stop; none of friction.
    pub(crate) limit: Option<&'static str>,
    /// 1 rad or the longest link.
    unit: f64,
}

/// State of a contact at an instant.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Touch {
    /// A stop without a force.
    Open,
    /// A stop that bears.
    Closed,
    /// Friction that slides with this sign.
    Slides(f64),
    /// Friction at rest in this position.
    Rests(f64),
}

/// Largest rate and acceleration of a motion, in radians and longest links.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) struct MotionSize {
    pub(crate) rate: f64,
    pub(crate) acceleration: f64,
}

/// Forces of friction at an instant, N or N m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct FrictionForces {
    /// F while it slides.
    pub(crate) sliding: f64,
    /// Bounds of λ at rest.
    pub(crate) resting: [f64; 2],
}

impl Touch {
    /// True where the row of the contact has a force of its own.
    pub(crate) fn is_touching(self) -> bool {
        matches!(self, Self::Closed | Self::Rests(_))
    }
}

impl EffortContacts {
    /// Compiles the stops and friction of `loaded`.
    pub(crate) fn of(loaded: &Loaded) -> Result<Self, AnalysisError> {
        let (model, system) = (loaded.model(), loaded.system());
        let pool = &model.pool;
        let functions: Vec<Expr> = (system.contacts.iter())
            .map(|contact| match contact.law {
                Law::Stop { .. } => contact.expression,
                Law::Friction { .. } => contact.position,
            })
            .collect();
        let rates = Rates::compile(model, system, &functions, &loaded.parameters)?;

        // F, and F₀ for either sign of its force.
        let mut laws = Vec::new();
        for contact in &system.contacts {
            let own = system.constraints[contact.row].lambda;
            let [sliding, sticking] =
                contact.law.friction(pool, own).unwrap_or([pool.zero(), pool.zero()]);
            let held = |sign: i64| pool.substitute(sticking, &[(own, pool.int(sign))]);
            laws.extend([sliding, held(-1), held(1)]);
        }
        let coordinates = system.coordinates();
        let (q, v): (Vec<SymbolId>, Vec<SymbolId>) = coordinates.iter().map(|c| (c.q, c.v)).unzip();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let arguments = [vec![model.time], q, v, lambda.clone()].concat();
        let tape = Tape::compile(pool, &laws, &arguments, &system.parameters(model))?;

        let used: BTreeSet<SymbolId> = (system.applied_force.iter().chain(&laws))
            .flat_map(|&force| pool.symbols_of(force))
            .collect();
        let pressing = (0..lambda.len()).filter(|&row| used.contains(&lambda[row])).collect();
        let contact = |contact: &Contact| contact_of(loaded, contact);
        Ok(Self {
            rates,
            laws_space: tape.workspace(&loaded.parameters),
            laws: tape,
            all: system.contacts.iter().map(contact).collect(),
            first_number: loaded.mechanism.parameters.len() + system.switches.len(),
            pressing,
            n_rows: lambda.len(),
        })
    }

    /// States of all contacts at an instant of a motion of this size; stops whose rows are among `bearing` bear throughout.
    pub(crate) fn at(
        &mut self,
        t: f64,
        state: [&[f64]; 3],
        size: MotionSize,
        bearing: &[usize],
    ) -> Vec<Touch> {
        let found = self.rates.at(t, state);
        let touch = |(contact, [value, rate, acceleration]): (&EffortContact, [f64; 3])| {
            let is_moving = rate.abs() > AT_REST * contact.unit * size.rate;
            let is_starting = acceleration.abs() > AT_REST * contact.unit * size.acceleration;
            match (contact.limit, is_moving || is_starting) {
                (Some(_), _) if bearing.contains(&contact.row) => Touch::Closed,
                (Some(_), false) if value.abs() <= CLOSED * contact.unit => Touch::Closed,
                (Some(_), _) => Touch::Open,
                (None, true) => Touch::Slides(if is_moving { rate } else { acceleration }.signum()),
                (None, false) => Touch::Rests(value),
            }
        };
        self.all.iter().zip(found).map(touch).collect()
    }

    /// `parameters` with the numbers of contacts that do this.
    pub(crate) fn parameters(&self, parameters: &[f64], touches: &[Touch]) -> Vec<f64> {
        let mut all = parameters.to_vec();
        let mut at = self.first_number;
        for touch in touches {
            let numbers: &[f64] = match touch {
                Touch::Open => &[0.0],
                Touch::Closed => &[1.0],
                Touch::Slides(sign) => &[0.0, *sign, 0.0],
                Touch::Rests(position) => &[1.0, 0.0, *position],
            };
            all[at..at + numbers.len()].copy_from_slice(numbers);
            at += numbers.len();
        }
        all
    }

    /// Gives the laws of friction these parameters.
    pub(crate) fn set_parameters(&mut self, parameters: &[f64]) {
        self.laws_space = self.laws.workspace(parameters);
    }

    /// Forces of friction under these multipliers of all rows.
    pub(crate) fn friction(
        &mut self,
        t: f64,
        [q, v]: [&[f64]; 2],
        lambda: &[f64],
    ) -> Vec<FrictionForces> {
        let inputs = [&[t], q, v, lambda].concat();
        let mut outputs = vec![0.0; self.laws.n_outputs()];
        self.laws.evaluate(&mut self.laws_space, &inputs, &mut outputs);
        let forces = |three: &[f64]| FrictionForces {
            sliding: three[0],
            resting: [-three[1].max(0.0), three[2].max(0.0)],
        };
        outputs.chunks_exact(3).map(forces).collect()
    }

    /// Number of constraint rows.
    pub(crate) fn n_rows(&self) -> usize {
        self.n_rows
    }
}

fn contact_of(loaded: &Loaded, contact: &Contact) -> EffortContact {
    let model: &Model = loaded.model();
    let (load, row) = (&model.loads[contact.load.0], &loaded.system().constraints[contact.row]);
    let is_stop = matches!(contact.law, Law::Stop { .. });
    EffortContact {
        name: load.name.clone(),
        span: load.span.clone(),
        is_rope: matches!(load.kind, LoadKind::Rope { .. }),
        row: contact.row,
        limit: is_stop.then_some(row.direction),
        unit: if row.effort == MotionKind::Rotation { 1.0 } else { loaded.size },
    }
}
