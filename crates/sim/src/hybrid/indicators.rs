//! The functions that decide the modes, compiled.

use bksim_expr::{Expr, Runner, SymbolId, Tape, TapeError, Workspace};

use super::modes::{Modes, Touch};
use crate::evaluator::gather;
use bksim_mbs::contact::Law;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{LoadId, Model};

/// Everything that decides, as functions of t, q, v and, for the rates, the accelerations.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    /// u of every switch; then per contact `position`, `rate` and its two numbers, see [`Seen`].
    functions: Runner,
    /// Rate of u of every switch; then per contact its acceleration.
    rates: Runner,
    /// Whether each switch depends on time alone.
    pub(crate) timed: Vec<bool>,
    pub(crate) contacts: Vec<Watched>,
}

/// A contact without its expressions.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Watched {
    pub(crate) load: LoadId,
    /// Its constraint row.
    pub(crate) row: usize,
    pub(crate) is_friction: bool,
}

/// What decides a mode.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Decider {
    /// The switch of this place.
    Kink(usize),
    /// The contact of this place.
    Contact(usize),
}

/// The numbers of one contact at an instant.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) struct Seen {
    /// Penetration φ of a stop, or position p of a motion with friction.
    pub(crate) position: f64,
    /// Its rate.
    pub(crate) rate: f64,
    /// Restitution of a stop, or F of friction.
    pub(crate) first: f64,
    /// Nothing of a stop, or F₀ of friction, no less than F.
    pub(crate) limit: f64,
}

/// Everything that decides at one instant.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct View {
    /// u of every switch.
    pub(crate) kinks: Vec<f64>,
    pub(crate) contacts: Vec<Seen>,
}

/// Outputs per contact of the functions.
const PER_CONTACT: usize = 4;

impl Watch {
    /// Compiles the functions of `system`.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub(crate) fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let system = system.integrated();
        let (pool, kinematics) = (&model.pool, &system.kinematics);
        let mut functions: Vec<Expr> = system.switches.iter().map(|s| s.function).collect();
        let mut rates: Vec<Expr> =
            functions.iter().map(|&u| kinematics.second_rate(model, u)).collect();
        let mut contacts = Vec::new();
        for contact in &system.contacts {
            let is_friction = matches!(contact.law, Law::Friction { .. });
            let (position, numbers) = match contact.law {
                Law::Stop { restitution } => (contact.expression, [restitution, pool.zero()]),
                Law::Friction { sliding, sticking, .. } => (contact.position, [sliding, sticking]),
            };
            let rate = kinematics.rate(model, position);
            functions.extend([position, rate]);
            functions.extend(numbers);
            rates.push(kinematics.second_rate(model, rate));
            contacts.push(Watched { load: contact.load, row: contact.row, is_friction });
        }
        let coordinates = system.coordinates();
        let parameters = system.parameters(model);
        let runner =
            |outputs: &[Expr], parts: &[fn(&bksim_mbs::kinematics::Coordinate) -> SymbolId]| {
                let state = parts.iter().flat_map(|part| coordinates.iter().map(part));
                let inputs: Vec<SymbolId> = std::iter::once(model.time).chain(state).collect();
                let tape = Tape::compile(pool, outputs, &inputs, &parameters)?;
                Ok::<_, TapeError>(Runner::new(tape, model.solve.jit))
            };
        Ok(Self {
            functions: runner(&functions, &[|c| c.q, |c| c.v])?,
            rates: runner(&rates, &[|c| c.q, |c| c.v, |c| c.a])?,
            timed: system.switches.iter().map(|switch| switch.is_timed).collect(),
            contacts,
        })
    }

    /// Whether nothing ever switches.
    pub(crate) fn is_empty(&self) -> bool {
        self.timed.is_empty() && self.contacts.is_empty()
    }

    /// Contacts apart, friction without effect, every σ positive: what holds before anything is known.
    pub(crate) fn idle(&self) -> Modes {
        let idle = |contact: &Watched| {
            if contact.is_friction { Touch::Sliding(0.0) } else { Touch::Apart }
        };
        Modes {
            signs: vec![1.0; self.timed.len()],
            touches: self.contacts.iter().map(idle).collect(),
        }
    }

    /// The modes whose functions are not zero at a state, all contacts idle.
    pub(crate) fn decided(&self, parameters: &[f64], t: f64, q: &[f64], v: &[f64]) -> Modes {
        let mut modes = self.idle();
        // A function may have the mode of one before it in it.
        for _ in 0..=modes.signs.len() {
            let view = self.at(&modes.behind(parameters)).view(t, q, v).clone();
            let signs = view.kinks.iter().map(|&u| if u < 0.0 { -1.0 } else { 1.0 }).collect();
            if modes.signs == signs {
                break;
            }
            modes.signs = signs;
        }
        modes
    }

    /// The functions at the given parameters, which end with the modes.
    pub(crate) fn at(&self, parameters: &[f64]) -> Watcher<'_> {
        let tapes = [self.functions.tape(), self.rates.tape()];
        let n_outputs = tapes[0].n_outputs().max(tapes[1].n_outputs());
        Watcher {
            watch: self,
            functions: tapes[0].workspace(parameters),
            rates: tapes[1].workspace(parameters),
            inputs: Vec::new(),
            out: vec![0.0; n_outputs],
            view: View::default(),
        }
    }
}

/// The functions of a [`Watch`] at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub(crate) struct Watcher<'a> {
    watch: &'a Watch,
    functions: Workspace,
    rates: Workspace,
    inputs: Vec<f64>,
    out: Vec<f64>,
    view: View,
}

impl<'a> Watcher<'a> {
    /// The contacts, in the order of [`View::contacts`].
    pub(crate) fn contacts(&self) -> &'a [Watched] {
        &self.watch.contacts
    }

    /// Everything that decides at a state.
    pub(crate) fn view(&mut self, t: f64, q: &[f64], v: &[f64]) -> &View {
        gather(&mut self.inputs, t, &[q, v]);
        let out = &mut self.out[..self.watch.functions.tape().n_outputs()];
        self.watch.functions.evaluate(&mut self.functions, &self.inputs, out);
        let (kinks, contacts) = out.split_at(self.watch.timed.len());
        self.view.kinks.clear();
        self.view.kinks.extend_from_slice(kinks);
        self.view.contacts.clear();
        self.view.contacts.extend(contacts.chunks_exact(PER_CONTACT).map(|four| Seen {
            position: four[0],
            rate: four[1],
            first: four[2],
            limit: four[3].max(four[2]).max(0.0),
        }));
        &self.view
    }

    /// Rates of the switches, then accelerations of the contacts.
    pub(crate) fn rates(&mut self, t: f64, q: &[f64], v: &[f64], a: &[f64]) -> &[f64] {
        gather(&mut self.inputs, t, &[q, v, a]);
        let out = &mut self.out[..self.watch.rates.tape().n_outputs()];
        self.watch.rates.evaluate(&mut self.rates, &self.inputs, out);
        out
    }
}
