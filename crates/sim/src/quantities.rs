//! Every quantity of a run by its name, as an expression of t, q, v, a and λ: channels, measures, reactions.

use std::cell::OnceCell;

use bksim_expr::{Expr, SymbolId};
use bksim_mbs::constraint::{Constraint, Source};
use bksim_mbs::coordinate::Coordinate;
use bksim_mbs::quantity::{coordinate_units, coupling_quantities, multiplier_quantities};
use bksim_mbs::reaction::{Reaction, force_of, reactions, reported, reported_force};
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{
    CouplingId, ENERGIES, Frame, JointId, Load, Measure, Model, MotionKind, NamedSignal,
    ParameterId,
};

use crate::compiled::energy_outputs;

/// The one way from a name to its formula: coordinates, measures, reactions, multipliers, signals, energies of a
/// mechanism; those that take work are made once.
#[derive(Debug)]
pub struct Quantities<'m> {
    model: &'m Model,
    /// With modes in place of everything that switches.
    system: &'m SymbolicSystem,
    reactions: OnceCell<Vec<Reaction>>,
    reported: OnceCell<Vec<(SymbolId, Expr)>>,
}

impl<'m> Quantities<'m> {
    /// The quantities of a model with these equations, or those of its runs if its loads switch.
    pub fn new(model: &'m Model, system: &'m SymbolicSystem) -> Self {
        let (reactions, reported) = (OnceCell::new(), OnceCell::new());
        Self { model, system: system.integrated(), reactions, reported }
    }

    /// The quantity of a name with its SI unit: `state.theta`, `theta_dot`, `energy.total`, `couplings.pair`,
    /// `signals.u`, and all that [`Measure::named`] finds, `reactions.A.force`, `drives.crank`, `rod.B.vx`. `None`
    /// where nothing has this name, or no formula of the state: the work and the counters of a run, and values that
    /// are held between events.
    pub fn named(&self, name: &str) -> Option<(Expr, String)> {
        let Self { model, .. } = self;
        let of_measure = || {
            let measure = Measure::named(model, name)?;
            Some((self.measure(measure), measure.unit(model).to_owned()))
        };
        let of_signal = || Some(self.signal(model.signal_named(name)?));
        let (topic, field) = name.split_once('.').unwrap_or(("", name));
        let found = self.coordinate(topic, field).or_else(|| self.of_topic(topic, field));
        found.or_else(of_measure).or_else(of_signal)
    }

    /// Names of quantities by which [`Quantities::named`] finds them, as a message suggests them.
    pub fn names(&self) -> Vec<String> {
        let Self { model, system, .. } = self;
        let coordinates = system.coordinates().iter();
        let coordinates =
            coordinates.flat_map(|c| [&c.name, &c.rate_name, &c.second_rate_name]).cloned();
        let signals = model.named_signals.iter().map(|signal| format!("signals.{}", signal.name));
        let couplings = model.couplings.iter().map(|of| format!("couplings.{}", of.name));
        let energies = ENERGIES.iter().map(|(part, _)| format!("energy.{part}"));
        let first = coordinates.chain(energies).chain(signals).chain(couplings);
        first.chain(Measure::names(model)).collect()
    }

    /// A coordinate, its rate or second rate, by the topic of its order or by itself.
    fn coordinate(&self, topic: &str, field: &str) -> Option<(Expr, String)> {
        let found = |c: &Coordinate| {
            let is = |of: &str, own: &str| (topic.is_empty() || topic == of) && field == own;
            let own = [("state", &c.name, c.q), ("state", &c.rate_name, c.v)];
            let own = own.into_iter().chain([("acceleration", &c.second_rate_name, c.a)]);
            let order = own.enumerate().find(|(_, (of, own, _))| is(of, own));
            order.map(|(order, (.., symbol))| (self.model.pool.symbol_expr(symbol), order))
        };
        self.system.coordinates().iter().find_map(|c| {
            let (value, order) = found(c)?;
            Some((value, coordinate_units(self.model, c)[order].replace('*', " ")))
        })
    }

    fn of_topic(&self, topic: &str, field: &str) -> Option<(Expr, String)> {
        let Self { model, system, .. } = self;
        let pool = &model.pool;
        match topic {
            "multipliers" => {
                let is_it = |row: &Constraint| pool.symbol_name(row.lambda) == field;
                let k = system.constraints.iter().position(is_it)?;
                let unit = multiplier_quantities(model, system)[k].unit.replace('*', " ");
                Some((pool.symbol_expr(system.constraints[k].lambda), unit))
            }
            "couplings" => {
                if let Some(k) = model.couplings.iter().position(|of| of.name == field) {
                    let unit = coupling_quantities(model)[k].unit.replace('*', " ");
                    return Some((self.multiplier(Source::Coupling(CouplingId(k)))?, unit));
                }
                let is_pull = |load: &&Load| load.is_coupling() || load.is_capstan();
                let mut teeth = model.loads.iter().filter(is_pull);
                let is_it = |load: &&Load| {
                    load.name == field || load.teeth().is_some_and(|teeth| teeth.name == field)
                };
                let unit = match teeth.find(is_it)?.effort() {
                    MotionKind::Translation => "N",
                    MotionKind::Rotation => "N m",
                };
                Some((force_of(model, system, field)?, unit.to_owned()))
            }
            "inputs" => {
                let is_it = |&&ParameterId(k): &&ParameterId| model.parameters[k].name == field;
                let ParameterId(k) = *model.inputs.iter().find(is_it)?;
                let of = &model.parameters[k];
                Some((pool.symbol_expr(of.symbol), of.unit.clone()))
            }
            "energy" => {
                let [kinetic, potential, power] = energy_outputs(pool, system);
                let (_, unit) = ENERGIES.iter().find(|(part, _)| *part == field)?;
                let value = match field {
                    "kinetic" => kinetic,
                    "potential" => potential,
                    "total" => pool.add(kinetic, potential),
                    _ => power,
                };
                Some((value, (*unit).to_owned()))
            }
            _ => None,
        }
    }

    fn signal(&self, signal: &NamedSignal) -> (Expr, String) {
        let Self { model, system, .. } = self;
        let pool = &model.pool;
        let value = pool.substitute(signal.value, &signal_values(model, &system.kinematics));
        (pool.substitute(value, self.reported()), signal.unit.clone())
    }

    fn multiplier(&self, source: Source) -> Option<Expr> {
        let row = self.system.constraints.iter().find(|row| row.source == source)?;
        Some(self.model.pool.symbol_expr(row.lambda))
    }

    fn reactions(&self) -> &[Reaction] {
        self.reactions.get_or_init(|| reactions(self.model, self.system))
    }

    /// The values of the symbols that stand for reactions and efforts; none where no signal measures one.
    fn reported(&self) -> &[(SymbolId, Expr)] {
        let is_one = |m: Measure| {
            m.is_reaction()
                || matches!(
                    m,
                    Measure::Effort(_)
                        | Measure::Force(_)
                        | Measure::Moment(_)
                        | Measure::Contact(..)
                        | Measure::Line(..)
                )
        };
        if !self.model.signals.iter().any(|signal| is_one(signal.measure)) {
            return &[];
        }
        self.reported.get_or_init(|| reported(self.model, self.system, self.reactions()))
    }

    /// A measure as an expression, reactions and efforts by the multipliers.
    fn measure(&self, measure: Measure) -> Expr {
        let Self { model, system, .. } = self;
        let pool = &model.pool;
        let component = |joint: JointId, frame: Frame, k: usize| {
            self.reactions()[joint.0].component(model, &system.kinematics, frame, k)
        };
        match measure {
            Measure::Reaction(joint, frame, k) => component(joint, frame, k),
            Measure::Resultant(joint, whole) => {
                let parts = whole.components().map(|k| component(joint, Frame::World, k));
                pool.sqrt(pool.sum(parts.map(|part| pool.powi(part, 2)).collect::<Vec<_>>()))
            }
            _ => reported_force(model, system, measure)
                .unwrap_or_else(|| system.kinematics.measure(model, measure)),
        }
    }
}
