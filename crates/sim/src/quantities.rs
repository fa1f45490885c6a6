//! Every quantity of a run by its name, as an expression of t, q, v, a and λ: channels, measures, reactions.

use std::cell::OnceCell;

use bksim_expr::{Expr, SymbolId};
use bksim_mbs::constraint::Source;
use bksim_mbs::reaction::{Reaction, reactions, reported};
use bksim_mbs::signal::signal_values;
use bksim_mbs::spatial;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{JointId, Measure, Model, ParameterId};

use crate::compiled::energy_outputs;
use crate::observable::Observable;

/// The quantities of a mechanism, those that take work made once.
pub(crate) struct Quantities<'m> {
    model: &'m Model,
    /// With modes in place of everything that switches.
    system: &'m SymbolicSystem,
    reactions: OnceCell<Vec<Reaction>>,
    reported: OnceCell<Vec<(SymbolId, Expr)>>,
}

/// Components of a reaction, world axes.
const COMPONENTS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

impl<'m> Quantities<'m> {
    pub(crate) fn new(model: &'m Model, system: &'m SymbolicSystem) -> Self {
        let (reactions, reported) = (OnceCell::new(), OnceCell::new());
        Self { model, system: system.integrated(), reactions, reported }
    }

    /// The quantity of a name: `state.theta`, `theta_dot`, `reactions.A.fx`, `energy.total`, `rod.B.vx`,
    /// `reactions.A.fx_joint`. None where nothing has this name, or no formula of the state: the work
    /// and the counters of a run, and values that are held between events.
    pub(crate) fn named(&self, name: &str) -> Option<Expr> {
        let Self { model, system, .. } = self;
        let symbol = |id: SymbolId| model.pool.symbol_expr(id);
        // Coordinates and their rates, by the topic of their order or by themselves.
        let (topic, field) = name.split_once('.').unwrap_or(("", name));
        for coordinate in system.coordinates() {
            let is = |topics: &[&str], own: &str| topics.contains(&topic) && field == own;
            if is(&["", "state"], &coordinate.name) {
                return Some(symbol(coordinate.q));
            }
            if is(&["", "state"], &coordinate.rate_name) {
                return Some(symbol(coordinate.v));
            }
            if is(&["", "acceleration"], &coordinate.second_rate_name) {
                return Some(symbol(coordinate.a));
            }
        }
        self.of_topic(topic, field).or_else(|| self.observable(name))
    }

    fn of_topic(&self, topic: &str, field: &str) -> Option<Expr> {
        let Self { model, system, .. } = self;
        let pool = &model.pool;
        let multiplier = |is_it: &dyn Fn(Source) -> bool| {
            let row = system.constraints.iter().find(|row| is_it(row.source))?;
            Some(pool.symbol_expr(row.lambda))
        };
        match topic {
            "multipliers" => {
                let rows = system.constraints.iter();
                let row = rows.map(|row| row.lambda).find(|&id| pool.symbol_name(id) == field)?;
                Some(pool.symbol_expr(row))
            }
            "drives" => multiplier(&|source| match source {
                Source::Drive(id) => model.drives[id.0].name == field,
                _ => false,
            }),
            "couplings" => multiplier(&|source| match source {
                Source::Coupling(id) => model.couplings[id.0].name == field,
                _ => false,
            }),
            "inputs" => {
                let is_it = |&&ParameterId(k): &&ParameterId| model.parameters[k].name == field;
                let ParameterId(k) = *model.inputs.iter().find(is_it)?;
                Some(pool.symbol_expr(model.parameters[k].symbol))
            }
            "signals" | "outputs" => {
                let signal = model.named_signals.iter().find(|signal| signal.name == field)?;
                let value =
                    pool.substitute(signal.value, &signal_values(model, &system.kinematics));
                Some(pool.substitute(value, self.reported()))
            }
            "energy" => {
                let [kinetic, potential, power] = energy_outputs(pool, system);
                match field {
                    "kinetic" => Some(kinetic),
                    "potential" => Some(potential),
                    "total" => Some(pool.add(kinetic, potential)),
                    "power" => Some(power),
                    _ => None,
                }
            }
            "reactions" => {
                let (joint, word) = field.rsplit_once('.')?;
                let joint = model.joints.iter().position(|of| of.name == joint)?;
                let component = COMPONENTS.iter().position(|known| *known == word)?;
                Some(self.reaction(JointId(joint))[component])
            }
            _ => None,
        }
    }

    fn reactions(&self) -> &[Reaction] {
        self.reactions.get_or_init(|| reactions(self.model, self.system))
    }

    /// The values of the symbols that stand for reactions and efforts; none where no signal measures one.
    fn reported(&self) -> &[(SymbolId, Expr)] {
        let is_one = |m: Measure| m.is_reaction() || matches!(m, Measure::Effort(_));
        if !self.model.signals.iter().any(|signal| is_one(signal.measure)) {
            return &[];
        }
        self.reported.get_or_init(|| reported(self.model, self.system, self.reactions()))
    }

    /// Force and moment of a joint, world axes.
    fn reaction(&self, joint: JointId) -> [Expr; 6] {
        let Reaction { force: [fx, fy, fz], moment: [mx, my, mz], .. } = self.reactions()[joint.0];
        [fx, fy, fz, mx, my, mz]
    }

    fn observable(&self, name: &str) -> Option<Expr> {
        let Self { model, system, .. } = self;
        match Observable::named(model, name)? {
            Observable::Measure(measure) => Some(system.kinematics.measure(model, measure)),
            Observable::ReactionInJoint(joint, component) => {
                let pool = &model.pool;
                let axis = spatial::axes(pool)[component % 3];
                let sides = system.kinematics.sides(model, &model.joints[joint.0]);
                let axis = sides.predecessor.rotation.apply(pool, &axis);
                let world = &self.reaction(joint)[component / 3 * 3..][..3];
                let terms = axis.iter().zip(world).map(|(&axis, &part)| pool.mul(axis, part));
                Some(pool.sum(terms.collect::<Vec<_>>()))
            }
        }
    }
}
