//! Functions of a mechanism that leave the program: tapes with the names and units of what goes in and comes out.
//!
//! ```text
//! M(q) v̇ + G(t, q)ᵀ λ = f(t, q, v, u, λ)   terms: M, f, G, γ, ∂f/∂λ
//! G v̇ = −γ(t, q, v)                        accelerations: v̇, λ
//! g(t, q) = 0                              constraints: g, ∂g/∂t
//! x(t, q), ẋ(t, q, v)                      kinematics: joints, bodies, points
//! ```
//!
//! f depends on multipliers where friction has a coefficient, or expressions read reactions.

mod equations;

use bksim_expr::{Expr, Quantity, Signature, SymbolId, Tape};
use bksim_mbs::coordinate::{Coordinate, CoordinateKind};
use bksim_mbs::modes::with_branches;
use bksim_mbs::quantity::coordinate_units;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use bksim_sim::compiled::{Terms, solved_accelerations, terms};
use bksim_sim::{Mechanism, pressing_symbols};

pub use equations::{Equations, equations};

use crate::error::AnalysisError;
use crate::loaded::without_contacts;
use crate::quantity::pose_quantities;

/// The functions that are asked for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Part {
    /// The equations of motion.
    Dynamics,
    /// Positions and rates of joints, bodies and points.
    Kinematics,
}

/// A function with the names of its arguments and results.
#[derive(Clone, Debug)]
pub struct ExportedFunction {
    /// Operations of the function.
    pub tape: Tape,
    /// Names and units.
    pub signature: Signature,
    /// Results in a few words.
    pub summary: &'static str,
    /// Values of its parameters in the model, SI; those of modes are of open contacts.
    pub parameters: Vec<f64>,
    /// A line about the function as a whole, such as the state that linear equations are about.
    pub note: String,
}

/// The functions of a part of `mechanism`; the parameters `inputs` become arguments u of the dynamics.
///
/// # Errors
/// [`AnalysisError::UnknownParameter`] names an input that is none, [`AnalysisError::Rejected`] is the fault of
/// a mechanism that has no start.
pub fn exported(
    mechanism: &Mechanism,
    part: Part,
    inputs: &[String],
) -> Result<Vec<ExportedFunction>, AnalysisError> {
    let interface = Interface::new(mechanism, inputs)?;
    match part {
        Part::Dynamics => {
            without_contacts(&mechanism.model)?;
            interface.dynamics()
        }
        Part::Kinematics => Ok(vec![interface.kinematics()?]),
    }
}

/// Arguments and parameters of all functions of a mechanism.
struct Interface<'a> {
    mechanism: &'a Mechanism,
    /// The equations, in which kinks take the branch of each state.
    system: SymbolicSystem,
    time: (SymbolId, Quantity),
    q: Vec<(SymbolId, Quantity)>,
    v: Vec<(SymbolId, Quantity)>,
    u: Vec<(SymbolId, Quantity)>,
    /// Multipliers that forces depend on.
    pressing: Vec<(SymbolId, Quantity)>,
    parameters: Vec<(SymbolId, Quantity)>,
    /// Values of the parameters.
    values: Vec<f64>,
    /// Values of the inputs.
    u_values: Vec<f64>,
}

impl<'a> Interface<'a> {
    fn new(mechanism: &'a Mechanism, inputs: &[String]) -> Result<Self, AnalysisError> {
        let model = &mechanism.model;
        let system = with_branches(&model.pool, &mechanism.system);
        // Coordinates and their rates.
        let units = |c: &Coordinate| coordinate_units(model, c);
        let coordinates = system.coordinates();
        let q = coordinates.iter().map(|c| (c.q, Quantity::new(&c.name, &units(c)[0]))).collect();
        let v =
            coordinates.iter().map(|c| (c.v, Quantity::new(&c.rate_name, &units(c)[1]))).collect();
        // Parameters: the model's own, then modes of contacts.
        let own = model.parameters.len();
        let is_branch = |symbol: &SymbolId| system.switches.iter().any(|s| s.mode == *symbol);
        let quantity = |(idx, symbol): (usize, SymbolId)| {
            let known = model.parameters.get(idx).map(|p| Quantity::new(&p.name, &p.unit));
            (symbol, known.unwrap_or_else(|| Quantity::new(&model.pool.symbol_name(symbol), "")))
        };
        let mut symbols = system.parameters(model);
        symbols.retain(|symbol| !is_branch(symbol));
        let mut parameters: Vec<_> = symbols.into_iter().enumerate().map(quantity).collect();
        let mut values = mechanism.parameters.clone();
        values.resize(own.max(parameters.len()), 0.0);
        let (mut u, mut u_values) = (Vec::new(), Vec::new());
        for name in inputs {
            let at = parameters.iter().position(|(_, quantity)| quantity.name == *name);
            let at = at.ok_or_else(|| AnalysisError::UnknownParameter { name: name.clone() })?;
            u.push(parameters.remove(at));
            u_values.push(values.remove(at));
        }
        let time = (model.time, Quantity::new("t", "s"));
        let used = pressing_symbols(model, &system);
        let multipliers = system.constraints.iter().zip(&mechanism.compiled.multipliers);
        let pressing = multipliers
            .filter(|(row, _)| used.contains(&row.lambda))
            .map(|(row, known)| (row.lambda, Quantity::new(&known.name, &known.unit)))
            .collect();
        Ok(Self { mechanism, system, time, q, v, u, pressing, parameters, values, u_values })
    }

    fn model(&self) -> &'a Model {
        &self.mechanism.model
    }

    /// Compiles outputs as a function of groups of arguments.
    fn function(
        &self,
        (name, summary): (&str, &'static str),
        groups: &[&[(SymbolId, Quantity)]],
        outputs: Vec<(Expr, Quantity)>,
    ) -> Result<ExportedFunction, AnalysisError> {
        let expressions: Vec<Expr> = outputs.iter().map(|(e, _)| *e).collect();
        let quantities = outputs.into_iter().map(|(_, quantity)| quantity).collect();
        let tape = self.tape(groups, &expressions)?;
        Ok(self.of_tape((name, summary), groups, (tape, quantities)))
    }

    /// Expressions of groups of arguments as straight-line code.
    fn tape(
        &self,
        groups: &[&[(SymbolId, Quantity)]],
        expressions: &[Expr],
    ) -> Result<Tape, AnalysisError> {
        let symbols: Vec<SymbolId> = self.arguments(groups).map(|(symbol, _)| *symbol).collect();
        let parameters: Vec<SymbolId> = self.parameters.iter().map(|(symbol, _)| *symbol).collect();
        Ok(Tape::compile(&self.model().pool, expressions, &symbols, &parameters)?)
    }

    /// Time, then the arguments of some groups.
    fn arguments<'g>(
        &'g self,
        groups: &'g [&[(SymbolId, Quantity)]],
    ) -> impl Iterator<Item = &'g (SymbolId, Quantity)> {
        std::iter::once(&self.time).chain(groups.iter().copied().flatten())
    }

    /// Straight-line code of groups of arguments, with the meaning of its outputs.
    fn of_tape(
        &self,
        (name, summary): (&str, &'static str),
        groups: &[&[(SymbolId, Quantity)]],
        (tape, outputs): (Tape, Vec<Quantity>),
    ) -> ExportedFunction {
        let signature = Signature {
            name: format!("{}_{name}", self.model().name),
            inputs: self.arguments(groups).map(|(_, quantity)| quantity.clone()).collect(),
            parameters: self.parameters.iter().map(|(_, quantity)| quantity.clone()).collect(),
            outputs,
        };
        let (parameters, note) = (self.values.clone(), String::new());
        ExportedFunction { tape, signature, summary, parameters, note }
    }

    fn dynamics(&self) -> Result<Vec<ExportedFunction>, AnalysisError> {
        let state = [self.q.as_slice(), &self.v, &self.u, &self.pressing];
        let summary = if self.pressing.is_empty() {
            "M, f, G and gamma"
        } else {
            "M, f, G, gamma and slopes of f by multipliers"
        };
        let mut functions = vec![self.function(("terms", summary), &state, self.terms())?];
        if !self.system.constraints.is_empty() {
            let outputs = self.constraints();
            functions.push(self.function(
                ("constraints", "g and its rate by time"),
                &[&self.q],
                outputs,
            )?);
        }
        // Rows that depend on others have no multipliers of their own; loads that follow multipliers are iterated.
        let start = self.mechanism.start()?;
        if start.inactive_rows().is_empty() && self.pressing.is_empty() {
            let Terms { mass, jacobian, force, gamma } = terms(self.model(), &self.system);
            let terms = self.tape(&state, &[mass, jacobian, force, gamma].concat())?;
            if let Some(tape) = solved_accelerations(&self.system, &terms) {
                let summary = "accelerations, then multipliers";
                let code = (tape, self.unknowns());
                functions.push(self.of_tape(("accelerations", summary), &state, code));
            }
        }
        Ok(functions)
    }

    /// M and G row by row, with all their zeros.
    fn terms(&self) -> Vec<(Expr, Quantity)> {
        let Self { system, q, .. } = self;
        let pool = &self.model().pool;
        let (nq, nc) = (q.len(), system.constraints.len());
        let terms = terms(self.model(), system);
        // M is symmetric.
        let mut mass = vec![pool.zero(); nq * nq];
        for ((i, j, _), entry) in system.mass_matrix.lower().zip(terms.mass) {
            (mass[i * nq + j], mass[j * nq + i]) = (entry, entry);
        }
        let mut jacobian = vec![pool.zero(); nc * nq];
        for ((row, column, _), entry) in system.constraint_jacobian.entries().zip(terms.jacobian) {
            jacobian[row * nq + column] = entry;
        }
        let coordinates = system.coordinates();
        let turns = |i: usize| coordinates[i].kind != CoordinateKind::Length;
        let is_state = |i: usize| coordinates[i].kind == CoordinateKind::Integral;
        // The row of a state is that of its rate, with one for a mass.
        let inertia = |i: usize, j: usize| {
            let of_bodies = ["kg", "kg*m", "kg*m^2"][usize::from(turns(i)) + usize::from(turns(j))];
            if is_state(i) || is_state(j) { "" } else { of_bodies }
        };
        let effort = |i: usize| match coordinates[i].kind {
            CoordinateKind::Integral => coordinate_units(self.model(), &coordinates[i])[2].clone(),
            CoordinateKind::Length => "N".to_owned(),
            CoordinateKind::Angle | CoordinateKind::Quaternion => "N*m".to_owned(),
        };
        let entry =
            |name: &str, at: usize| format!("{name}[{},{}]", at / nq.max(1), at % nq.max(1));
        let mut outputs = Vec::new();
        for (at, e) in mass.into_iter().enumerate() {
            outputs.push((e, Quantity::new(&entry("M", at), inertia(at / nq, at % nq))));
        }
        for (i, e) in terms.force.into_iter().enumerate() {
            outputs.push((e, Quantity::new(&format!("f[{i}]"), &effort(i))));
        }
        for (at, e) in jacobian.into_iter().enumerate() {
            outputs.push((e, Quantity::new(&entry("G", at), "")));
        }
        for (row, e) in terms.gamma.into_iter().enumerate() {
            outputs.push((e, Quantity::new(&format!("gamma[{row}]"), "")));
        }
        outputs.extend(self.slopes());
        outputs
    }

    /// ∂f/∂λ by the multipliers that forces depend on, row by row.
    fn slopes(&self) -> Vec<(Expr, Quantity)> {
        let pool = &self.model().pool;
        let symbols: Vec<SymbolId> = self.pressing.iter().map(|(symbol, _)| *symbol).collect();
        let rows = self.system.applied_force.iter().enumerate();
        let row = |(i, &force): (usize, &Expr)| {
            let slopes = pool.gradient(force, &symbols).into_iter().enumerate();
            slopes.map(move |(k, e)| (e, Quantity::new(&format!("f_lambda[{i},{k}]"), "")))
        };
        rows.flat_map(row).collect()
    }

    fn constraints(&self) -> Vec<(Expr, Quantity)> {
        let rows = self.system.constraints.iter().map(|c| c.expression);
        let values = rows.enumerate().map(|(row, e)| (e, Quantity::new(&format!("g[{row}]"), "")));
        let rates = self.system.constraint_rate.iter().enumerate();
        let rates = rates.map(|(row, &e)| (e, Quantity::new(&format!("g_t[{row}]"), "")));
        values.chain(rates).collect()
    }

    /// Names of v̇ and λ.
    fn unknowns(&self) -> Vec<Quantity> {
        let coordinates = self.system.coordinates().iter();
        let accelerations = coordinates
            .map(|c| Quantity::new(&c.second_rate_name, &coordinate_units(self.model(), c)[2]));
        let multipliers = self.mechanism.compiled.multipliers.iter();
        let multipliers = multipliers.map(|known| Quantity::new(&known.name, &known.unit));
        accelerations.chain(multipliers).collect()
    }

    fn kinematics(&self) -> Result<ExportedFunction, AnalysisError> {
        let pool = &self.model().pool;
        let known = pose_quantities(self.model(), &self.system);
        let values: Vec<Expr> = known.iter().map(|quantity| quantity.value).collect();
        // Rates by the chain rule.
        let pairs = self.q.iter().zip(&self.v);
        let mut rates: Vec<(SymbolId, Expr)> =
            pairs.map(|((q, _), (v, _))| (*q, pool.symbol_expr(*v))).collect();
        rates.push((self.time.0, pool.one()));
        let rates = pool.total_derivatives(&values, &rates);
        let mut outputs = Vec::new();
        for ((quantity, value), rate) in known.iter().zip(values).zip(rates) {
            let [unit, per_second, _] = quantity.units();
            outputs.push((value, Quantity::new(&quantity.names[0], &unit)));
            outputs.push((rate, Quantity::new(&quantity.names[1], &per_second)));
        }
        let summary = "positions and rates of joints, bodies and points";
        self.function(("kinematics", summary), &[&self.q, &self.v], outputs)
    }
}
