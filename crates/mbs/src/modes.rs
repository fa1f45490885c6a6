//! The equations with modes in place of everything that switches.

use std::collections::BTreeSet;

use bksim_expr::{Expr, Function, Pool, SymbolId};

use crate::contact::{Law, slip_wrenches};
use crate::system::{Switch, SwitchOf, SymbolicSystem};
use bksim_model::Model;

/// Replaces what switches in `system`, its contacts included; `None` when nothing does.
pub(crate) fn with_modes(model: &Model, system: &SymbolicSystem) -> Option<SymbolicSystem> {
    let pool = &model.pool;
    let mut integrated = system.clone();

    // Friction acts as a load while it slides; open rows vanish.
    for contact in &system.contacts {
        let row = contact.row;
        if let Some(effort) = contact.law.slipping(pool) {
            // The row holds −∂p/∂q.
            for &(i, g) in system.constraint_jacobian.row(row) {
                integrated.applied_force[i] =
                    pool.add(integrated.applied_force[i], pool.mul(effort, g));
            }
        }
        let closed = pool.symbol_expr(contact.closed);
        let scale = |e: &mut Expr| *e = pool.mul(closed, *e);
        scale(&mut integrated.constraints[row].expression);
        scale(&mut integrated.constraint_rate[row]);
        integrated.constraint_jacobian.row_mut(row).for_each(scale);
    }
    integrated.wrenches.extend(slip_wrenches(model, &system.contacts, &system.constraints));

    let roots = switching_roots(&mut integrated);
    let exprs: Vec<Expr> = roots.iter().map(|root| **root).collect();
    let (images, switches) = switches_of(model, system, &exprs);
    roots.into_iter().zip(images).for_each(|(root, image)| *root = image);
    integrated.switches = switches;
    let is_smooth = integrated.switches.is_empty() && integrated.contacts.is_empty();
    (!is_smooth).then_some(integrated)
}

/// Every expression of a system that depends on a load or a drive.
fn switching_roots(system: &mut SymbolicSystem) -> Vec<&mut Expr> {
    let mut roots: Vec<&mut Expr> = vec![&mut system.potential_energy];
    roots.extend(&mut system.potential_gradient);
    roots.extend(&mut system.applied_force);
    roots.extend(system.constraints.iter_mut().map(|c| &mut c.expression));
    roots.extend(system.constraint_jacobian.entries_mut());
    roots.extend(&mut system.constraint_rate);
    roots.extend(&mut system.resistance);
    roots.extend(system.inverse_dynamics.iter_mut().flatten());
    roots.extend(&mut system.conditions);
    for wrench in &mut system.wrenches {
        roots.extend(&mut wrench.force);
        roots.extend(&mut wrench.at);
        roots.extend(&mut wrench.moment);
    }
    for contact in &mut system.contacts {
        match &mut contact.law {
            Law::Stop { restitution, .. } => roots.push(restitution),
            Law::Friction { sliding, sticking, .. } => roots.extend([sliding, sticking]),
        }
    }
    roots
}

/// The equations that are integrated with the sign of its own function in place of every mode of a kink: each state takes
/// its own branches, and where a function is zero, conditions are as written. Modes of contacts stay parameters.
///
/// # Panics
/// Never: a sign has one operand.
pub fn with_branches(pool: &Pool, system: &SymbolicSystem) -> SymbolicSystem {
    let mut branching = system.integrated().clone();
    let mut signs: Vec<(SymbolId, Expr)> = Vec::new();
    for switch in &branching.switches {
        // A function may have the mode of one before it in it.
        let function = pool.substitute(switch.function, &signs);
        let sign = match switch.of {
            SwitchOf::Multipliers => pool.zero(),
            _ => pool.call(Function::Sign, &[function]).expect("one argument"),
        };
        signs.push((switch.mode, sign));
    }
    put_modes(pool, &mut branching, &signs);
    branching
}

/// The equations that are integrated, with expressions that depend on multipliers as they are written: for solvers that
/// find no events at zeros of multipliers.
pub fn with_modes_of_state(pool: &Pool, system: &SymbolicSystem) -> SymbolicSystem {
    let mut of_state = system.integrated().clone();
    let is_pressing = |switch: &Switch| switch.of == SwitchOf::Multipliers;
    let pressing: Vec<Switch> = of_state.switches.extract_if(.., |s| is_pressing(s)).collect();
    let as_written: Vec<_> = pressing.iter().map(|switch| (switch.mode, pool.zero())).collect();
    put_modes(pool, &mut of_state, &as_written);
    of_state
}

/// Puts values in place of modes.
fn put_modes(pool: &Pool, system: &mut SymbolicSystem, values: &[(SymbolId, Expr)]) {
    let roots = switching_roots(system);
    let exprs: Vec<Expr> = roots.iter().map(|root| **root).collect();
    let images = pool.substitute_all(&exprs, values);
    roots.into_iter().zip(images).for_each(|(root, image)| *root = image);
}

/// Replaces the kinks of some expressions of t, q, v and λ; the switches decide them.
pub fn switches_of(
    model: &Model,
    system: &SymbolicSystem,
    roots: &[Expr],
) -> (Vec<Expr>, Vec<Switch>) {
    let coordinates = system.coordinates();
    let state = coordinates.iter().flat_map(|c| [c.q, c.v]).collect();
    let multipliers = system.constraints.iter().map(|row| row.lambda).collect();
    let (pool, time) = (&model.pool, model.time);
    let mut kinks = Kinks { pool, time, state, multipliers, switches: Vec::new() };
    // Functions by name have their kinks inside.
    let roots = model.pool.expand_named(roots);
    let images = pool.map_calls(&roots, |function, operands| kinks.image(function, operands));
    (images, kinks.switches)
}

struct Kinks<'a> {
    pool: &'a Pool,
    time: SymbolId,
    state: BTreeSet<SymbolId>,
    multipliers: BTreeSet<SymbolId>,
    switches: Vec<Switch>,
}

impl Kinks<'_> {
    fn image(&mut self, function: Function, operands: &[Expr]) -> Option<Expr> {
        use Function::{Abs, Ge, Gt, Le, Lt, Max, Min, Sign};
        let pool = self.pool;
        // The function whose sign decides, and the sign with which a condition is as written where it is zero.
        let (u, at_zero) = match (function, operands) {
            (Abs | Sign, &[a]) => (a, None),
            (Min | Max, &[a, b]) => (pool.sub(a, b), None),
            (Gt, &[a, b]) => (pool.sub(a, b), Some(-1.0)),
            (Ge, &[a, b]) => (pool.sub(a, b), Some(1.0)),
            (Lt, &[a, b]) => (pool.sub(b, a), Some(-1.0)),
            (Le, &[a, b]) => (pool.sub(b, a), Some(1.0)),
            _ => return None,
        };
        let of = self.decided_by(u)?;
        let mode = self.mode_of(u, of, at_zero);
        let (zero, one) = (pool.zero(), pool.one());
        // What the function is where u is above zero, and below.
        let [above, below] = match (function, operands) {
            (Abs, &[a]) => [a, pool.neg(a)],
            (Sign, _) => [one, pool.neg(one)],
            (Min, &[a, b]) => [b, a],
            (Max, &[a, b]) => [a, b],
            _ => [one, zero],
        };
        let call = |function, a, b| pool.call(function, &[a, b]);
        if of == SwitchOf::Multipliers {
            let written = pool.call(function, operands)?;
            let not_above = pool.select(call(Lt, mode, zero)?, below, written);
            return Some(pool.select(call(Gt, mode, zero)?, above, not_above));
        }
        // A condition is 1 where it holds and 0 elsewhere, at zero as it is written; `if` then takes one branch only.
        // The slope of `abs` is that of one side where it is zero, as those of `min` and `max` are.
        Some(match function {
            Sign => mode,
            Abs => pool.select(call(Ge, mode, zero)?, above, below),
            Min | Max => pool.select(call(Gt, mode, zero)?, above, below),
            Gt | Lt => call(Gt, mode, zero)?,
            _ => call(Ge, mode, zero)?,
        })
    }

    /// Kind of the switch of `u`; `None` when it keeps its value between events.
    fn decided_by(&self, u: Expr) -> Option<SwitchOf> {
        let symbols = self.pool.symbols_of(u);
        if symbols.iter().any(|symbol| self.multipliers.contains(symbol)) {
            return Some(SwitchOf::Multipliers);
        }
        if symbols.iter().any(|symbol| self.state.contains(symbol)) {
            return Some(SwitchOf::State);
        }
        symbols.contains(&self.time).then_some(SwitchOf::Time)
    }

    /// σ of `u`, or −σ of −u. `at_zero` is the sign with which a condition is as written where u is zero.
    fn mode_of(&mut self, u: Expr, of: SwitchOf, at_zero: Option<f64>) -> Expr {
        let pool = self.pool;
        // Time does not rest, and the friction that depends on multipliers is continuous.
        let at_zero = at_zero.filter(|_| of == SwitchOf::State);
        let opposite = pool.neg(u);
        for known in &mut self.switches {
            let mode = pool.symbol_expr(known.mode);
            let (at_zero, mode) = match known.function {
                function if function == u => (at_zero, mode),
                function if function == opposite => (at_zero.map(|sign| -sign), pool.neg(mode)),
                _ => continue,
            };
            // Conditions that differ where their function is zero have a mode each.
            if known.at_zero.or(at_zero) == at_zero.or(known.at_zero) {
                known.at_zero = known.at_zero.or(at_zero);
                return mode;
            }
        }
        // Not an identifier, so that no name of the model can meet it.
        let mode = pool.symbol(&format!("'mode{}", self.switches.len()));
        let symbol = pool.symbol_id(mode).expect("a symbol was just made");
        self.switches.push(Switch { function: u, mode: symbol, of, at_zero });
        mode
    }
}

#[cfg(test)]
mod tests {
    use crate::assemble::assemble;
    use bksim_model::file::{Source, read};

    fn system(value: &str) -> (bksim_model::Model, crate::system::SymbolicSystem) {
        let text = format!(
            "[bodies.block]\nmass = 1\n[joints.S]\ntype = \"prismatic\"\n\
             between = [\"ground\", \"block\"]\naxis = [1, 0]\n\
             [loads.F]\ntype = \"force\"\non = \"block\"\nvector = [\"{value}\", 0]\n"
        );
        let reading = read(&Source::new(&text, "block"));
        let faults = reading.diagnostics;
        let model = reading.model.unwrap_or_else(|| panic!("{faults:?}"));
        let system = assemble(&model);
        (model, system)
    }

    #[test]
    fn each_kink_becomes_the_branch_that_its_mode_selects() {
        let x = "S.position";
        let cases = [
            (format!("1 N/m*abs({x})"), "if(ge('mode0, 0), S_position, -S_position)", 1),
            (format!("1 N*if({x} > 0, 2, 1)"), "if(gt('mode0, 0), 2, 1)", 1),
            (format!("1 N*if({x} <= 0, 2, 1)"), "if(ge('mode0, 0), 2, 1)", 1),
            (format!("1 N*sign({x})"), "'mode0", 1),
            (format!("1 N/m*(abs({x}) + 2*max({x}, 0))"), "", 1),
            (format!("1 N/m*(max(0, {x}) + min({x}, 0))"), "", 1),
            (format!("1 N/m*abs(abs({x}) - 1)"), "", 2),
            ("if(lt(t, 1), 1, 2) * 1 N".to_owned(), "", 1),
        ];
        for (written, expected, n) in cases {
            let (model, system) = system(&written);
            let integrated = system.integrated();
            assert_eq!(integrated.switches.len(), n, "{written}");
            let text = model.pool.to_text(integrated.applied_force[0]);
            assert!(expected.is_empty() || text == expected, "{written}: {text}");
            for word in ["abs", "sign", "min", "max"] {
                assert!(!text.contains(&format!("{word}(")), "{written}: {text}");
            }
            // The equations that people read keep the functions as written.
            assert!(model.pool.to_text(system.applied_force[0]).contains('('), "{written}");
        }
    }

    #[test]
    fn what_never_changes_switches_nothing() {
        for written in ["1 N*abs(-3)", "1 N s/m*sqrt(S.velocity^2 + 1)", "3 N/m*S.position"] {
            let (_, system) = system(written);
            assert!(system.integrated().switches.is_empty(), "{written}");
        }
    }
}
