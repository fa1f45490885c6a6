//! All of the equations of motion as one function with its layout, for scripts of other programs.

use bksim_expr::{Expr, Quantity};
use bksim_model::Model;
use bksim_sim::Mechanism;
use bksim_sim::compiled::{Terms, terms};

use super::{ExportedFunction, Interface};
use crate::error::AnalysisError;
use crate::loaded::without_memory;

/// The equations of motion as one function, and the place of every output of it.
///
/// ```text
/// M(q) a + G(t, q)ᵀ λ = f(t, q, v, u, λ),   G a = −γ(t, q, v),   g(t, q) = 0,   q̇ = v
/// ```
#[derive(Clone, Debug)]
pub struct Equations {
    /// From t, q, v, u and the pressing multipliers: entries of M, f, entries of G, γ, g, ∂g/∂t, then ∂f/∂λ by these
    /// multipliers, row by row.
    pub function: ExportedFunction,
    /// Coordinates q.
    pub coordinates: Vec<Quantity>,
    /// Rates v.
    pub rates: Vec<Quantity>,
    /// Multipliers λ, one for each row that takes part.
    pub multipliers: Vec<Quantity>,
    /// Places among the multipliers of those that f depends on, ascending.
    pub pressing: Vec<usize>,
    /// Inputs u with their values.
    pub inputs: Vec<(Quantity, f64)>,
    /// Row and column of the entries of the lower triangle of M.
    pub mass: Vec<[usize; 2]>,
    /// Row and column of the entries of G.
    pub jacobian: Vec<[usize; 2]>,
    /// Consistent start: t, q and v.
    pub start: (f64, Vec<f64>, Vec<f64>),
    /// Parameters that follow from others in the model, and are numbers here.
    pub calculated: Vec<String>,
    /// Multipliers of rows that follow from the others at the start.
    pub left_out: Vec<String>,
    /// Stops and friction, which are open and do not stick here.
    pub contacts: Vec<String>,
}

/// The equations of motion of `mechanism`; the parameters `inputs` become arguments u.
///
/// Rows that follow from others at the start, and those of stops and of sticking, take no part.
///
/// # Errors
/// [`AnalysisError::UnknownParameter`] names an input that is none, [`AnalysisError::Rejected`] is the fault of
/// a mechanism that has no start, or whose equations are more than functions of its state.
pub fn equations(mechanism: &Mechanism, inputs: &[String]) -> Result<Equations, AnalysisError> {
    let model = &mechanism.model;
    without_memory(model)?;
    let mut interface = Interface::new(mechanism, inputs)?;
    let start = mechanism.start()?;
    let contacts = &interface.system.contacts;
    let mut is_kept = vec![true; interface.system.constraints.len()];
    for &row in start.inactive_rows() {
        is_kept[row] = false;
    }
    for contact in contacts {
        is_kept[contact.row] = false;
    }
    // Rows that take no part have no multipliers that forces could follow.
    let rows = interface.system.constraints.iter().zip(&is_kept);
    let gone =
        rows.filter(|(_, is_kept)| !**is_kept).map(|(row, _)| (row.lambda, model.pool.zero()));
    let gone: Vec<_> = gone.collect();
    let force = model.pool.substitute_all(&interface.system.applied_force, &gone);
    interface.pressing.retain(|(lambda, _)| gone.iter().all(|(symbol, _)| symbol != lambda));
    interface.system.applied_force = force;
    let contacts = &interface.system.contacts;
    let is_contact = |row: usize| contacts.iter().any(|contact| contact.row == row);
    let multipliers = &interface.unknowns()[interface.q.len()..];
    let rows = || multipliers.iter().enumerate();
    let left_out = rows().filter(|(row, _)| !is_kept[*row] && !is_contact(*row));
    let mut of_contacts: Vec<String> =
        contacts.iter().map(|c| model.loads[c.load.0].name.clone()).collect();
    of_contacts.dedup();
    let mut jacobian = Vec::new();
    let outputs = rows_of(&interface, &is_kept, &mut jacobian);
    let state = [interface.q.as_slice(), &interface.v, &interface.u, &interface.pressing];
    let summary = "M, f, G, gamma, g and its rate by time, without their zeros";
    let kept = interface.system.constraints.iter().zip(&is_kept).filter(|(_, is_kept)| **is_kept);
    let of_pressing = kept
        .enumerate()
        .filter(|(_, (row, _))| interface.pressing.iter().any(|(lambda, _)| *lambda == row.lambda));
    Ok(Equations {
        function: interface.function(("equations", summary), &state, outputs)?,
        coordinates: interface.q.iter().map(|(_, quantity)| quantity.clone()).collect(),
        rates: interface.v.iter().map(|(_, quantity)| quantity.clone()).collect(),
        multipliers: rows().filter(|(row, _)| is_kept[*row]).map(|(_, q)| q.clone()).collect(),
        pressing: of_pressing.map(|(place, _)| place).collect(),
        inputs: interface
            .u
            .iter()
            .map(|(_, q)| q.clone())
            .zip(interface.u_values.clone())
            .collect(),
        mass: interface.system.mass_matrix.lower().map(|(i, j, _)| [i, j]).collect(),
        jacobian,
        start: (start.t, start.q.clone(), start.v.clone()),
        calculated: calculated(model, inputs),
        left_out: left_out.map(|(_, quantity)| quantity.name.clone()).collect(),
        contacts: of_contacts,
    })
}

/// Parameters that follow from others.
fn calculated(model: &Model, inputs: &[String]) -> Vec<String> {
    let is_calculated = |p: &&bksim_model::Parameter| {
        !model.pool.symbols_of(p.definition).is_empty() && !inputs.contains(&p.name)
    };
    model.parameters.iter().filter(is_calculated).map(|p| p.name.clone()).collect()
}

/// The outputs, row by row; the places of those of G go to `places`.
fn rows_of(
    interface: &Interface<'_>,
    is_kept: &[bool],
    places: &mut Vec<[usize; 2]>,
) -> Vec<(Expr, Quantity)> {
    let system = &interface.system;
    let Terms { mass, jacobian, force, gamma } = terms(interface.model(), system);
    let mut new_row = Vec::new();
    let mut n = 0;
    for &kept in is_kept {
        new_row.push(n);
        n += usize::from(kept);
    }
    let mut all: Vec<(Expr, String)> = Vec::new();
    let places_of_mass = system.mass_matrix.lower();
    all.extend(places_of_mass.zip(mass).map(|((i, j, _), e)| (e, format!("M[{i},{j}]"))));
    all.extend(force.into_iter().enumerate().map(|(i, e)| (e, format!("f[{i}]"))));
    for ((row, column, _), e) in system.constraint_jacobian.entries().zip(jacobian) {
        if is_kept[row] {
            places.push([new_row[row], column]);
            all.push((e, format!("G[{},{column}]", new_row[row])));
        }
    }
    let closed = system.constraints.iter().map(|c| c.expression).collect();
    for (name, rows) in [("gamma", gamma), ("g", closed), ("g_t", system.constraint_rate.clone())] {
        let kept = rows.into_iter().enumerate().filter(|(row, _)| is_kept[*row]);
        all.extend(kept.map(|(row, e)| (e, format!("{name}[{}]", new_row[row]))));
    }
    let all = all.into_iter().map(|(e, name)| (e, Quantity::new(&name, "")));
    all.chain(interface.slopes()).collect()
}
