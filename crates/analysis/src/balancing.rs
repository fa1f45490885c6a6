//! Values of parameters that make the pose of the start an equilibrium.
//!
//! ```text
//! F(p) = Z₀ᵀ P r(q(p), p) = 0        as many unknowns p as free motions
//! P = Z Zᵀ, G Z = 0; Z₀ = Z at the model's own values; q(p) the start that closes at p
//! ```
//!
//! Newton's iteration; slopes are differences, since p may move the start itself. Forces are linear in stiffnesses,
//! masses and loads, so that one step leads there.

use bksim_mbs::coordinate::CoordinateKind;
use bksim_model::{Model, ParameterId};
use nalgebra::{DMatrix, DVector};

use crate::balance::Balance;
use crate::equilibrium::{Equilibrium, cells, columns};
use crate::error::AnalysisError;
use crate::loaded::{Loaded, without_states};
use crate::reduced::null_space;
use crate::table::{Column, Table};

/// The start as an equilibrium.
#[derive(Clone, PartialEq, Debug)]
pub struct Balanced {
    /// The parameters with their values, SI, and those that they had.
    pub values: Vec<(Column, f64, f64)>,
    /// Names of the joints, for the reactions.
    pub joints: Vec<String>,
    /// The independent quantities that the stiffness is by, with their units.
    pub by: Vec<(String, &'static str)>,
    /// The equilibrium.
    pub equilibrium: Equilibrium,
    /// Stops and friction that count as constraints.
    pub held: Vec<String>,
}

/// Finds the values of the parameters `names` at which the start of `model` is in balance; the stiffness is by
/// the measures `by`, else by coordinates.
///
/// # Errors
/// [`AnalysisError`] when there are not as many unknowns as free motions, or no values balance them.
pub fn balanced(model: Model, names: &[String], by: &[String]) -> Result<Balanced, AnalysisError> {
    /// Most steps.
    const MOST: usize = 60;
    without_states(&model)?;
    let mut loaded = Loaded::of(model)?;
    let ids: Vec<ParameterId> =
        names.iter().map(|name| loaded.parameter(name)).collect::<Result<_, _>>()?;
    let own: Vec<f64> = ids.iter().map(|id| loaded.parameters[id.0]).collect();
    let unbalanced = || AnalysisError::NotBalanced { names: names.to_vec() };
    let basis = free_motions(&loaded)?;
    if basis.ncols() != ids.len() {
        return Err(AnalysisError::Unknowns { n_unknown: ids.len(), n_free: basis.ncols() });
    }

    // Newton's steps, shortened until less is left.
    let mut p = DVector::from_column_slice(&own);
    let mut at = work(&mut loaded, &ids, p.as_slice(), &basis)?;
    let mut is_done = at.value.norm() <= at.rounding;
    for _ in 0..MOST {
        if is_done {
            break;
        }
        let slopes = slopes(&mut loaded, &ids, &p, &basis)?;
        let step = slopes.lu().solve(&-&at.value).filter(|step| step.iter().all(|x| x.is_finite()));
        let step = step.ok_or_else(unbalanced)?;
        let mut share = 1.0;
        let (next, there) = loop {
            let next = &p + &step * share;
            let there = work(&mut loaded, &ids, next.as_slice(), &basis);
            match there {
                Ok(there) if there.value.norm() <= at.value.norm().max(there.rounding) => {
                    break (next, there);
                }
                _ if share < 1e-6 => return Err(unbalanced()),
                _ => share *= 0.5,
            }
        };
        let gone = (0..p.len()).all(|k| (next[k] - p[k]).abs() <= 1e-14 * next[k].abs());
        (p, at) = (next, there);
        if gone || at.value.norm() == 0.0 {
            is_done = true;
        }
        if at.value.norm() <= 1e-14 * at.size {
            is_done = true;
        }
    }
    if !is_done && at.value.norm() > 1e-10 * at.size {
        return Err(unbalanced());
    }
    let mut balance = Balance::of(&loaded, by, &[])?;
    let q = loaded.q.clone();
    let by = balance.by_names(&q)?;
    let equilibrium = balance.equilibrium(&q)?;
    let column = |id: &ParameterId| {
        let parameter = &loaded.model().parameters[id.0];
        Column::new(parameter.name.clone(), parameter.unit.clone())
    };
    let values = ids.iter().zip(p.iter().zip(&own));
    Ok(Balanced {
        values: values.map(|(id, (value, own))| (column(id), *value, *own)).collect(),
        joints: loaded.mechanism.compiled.joints.clone(),
        by,
        equilibrium,
        held: loaded.held_contacts(),
    })
}

impl Balanced {
    /// One row: the parameters, then as of a table of equilibria.
    pub fn table(&self) -> Table {
        let heads = self.values.iter().map(|(column, ..)| column.clone());
        let values = self.values.iter().map(|(_, value, _)| *value);
        Table {
            columns: heads.chain(columns(Some(&self.equilibrium), &self.joints)).collect(),
            rows: vec![values.chain(cells(&self.equilibrium)).collect()],
        }
    }
}

/// The rest of the balance.
struct Work {
    /// F, J per radian or longest link.
    value: DVector<f64>,
    /// The size of what it is the sum of.
    size: f64,
    /// The part of that which is rounding.
    rounding: f64,
}

/// Free motions of the start, orthonormal in units of the mechanism.
fn free_motions(loaded: &Loaded) -> Result<DMatrix<f64>, AnalysisError> {
    let mut balance = Balance::of(loaded, &[], &[])?;
    let nothing = vec![0.0; balance.forces.nc()];
    let at = balance.at(&loaded.q, &nothing);
    Ok(null_space(&scaled(loaded, &at.jacobian)))
}

fn unit(loaded: &Loaded, i: usize) -> f64 {
    let is_length = loaded.system().coordinates()[i].kind == CoordinateKind::Length;
    if is_length { loaded.size } else { 1.0 }
}

fn scaled(loaded: &Loaded, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |row, i| {
        jacobian[(row, i)] * unit(loaded, i)
    })
}

/// F at values of the parameters.
fn work(
    loaded: &mut Loaded,
    ids: &[ParameterId],
    p: &[f64],
    basis: &DMatrix<f64>,
) -> Result<Work, AnalysisError> {
    let n_own = loaded.mechanism.parameters.len();
    let values = loaded.parameters_with(ids, p);
    loaded.restart(&values[..n_own])?;
    let mut balance = Balance::of(loaded, &[], &[])?;
    let nothing = vec![0.0; balance.forces.nc()];
    let at = balance.at(&loaded.q, &nothing);
    let free = null_space(&scaled(loaded, &at.jacobian));
    let forces = DVector::from_fn(at.residual.len(), |i, _| at.residual[i] * unit(loaded, i));
    let value = basis.transpose() * (&free * (free.transpose() * &forces));
    Ok(Work { value, size: forces.norm(), rounding: 1e-14 * forces.norm() })
}

/// ∂F/∂p by central differences.
fn slopes(
    loaded: &mut Loaded,
    ids: &[ParameterId],
    p: &DVector<f64>,
    basis: &DMatrix<f64>,
) -> Result<DMatrix<f64>, AnalysisError> {
    let mut slopes = DMatrix::zeros(basis.ncols(), ids.len());
    for k in 0..ids.len() {
        let step = if p[k] == 0.0 { 1e-5 } else { 1e-5 * p[k].abs() };
        let mut at = |sign: f64| {
            let mut aside = p.clone();
            aside[k] += sign * step;
            work(loaded, ids, aside.as_slice(), basis)
        };
        let [more, less] = [at(1.0)?.value, at(-1.0)?.value];
        slopes.column_mut(k).copy_from(&((more - less) / (2.0 * step)));
    }
    Ok(slopes)
}
