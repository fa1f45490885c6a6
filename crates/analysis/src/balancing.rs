//! Values of parameters that make the pose of the start an equilibrium.
//!
//! ```text
//! F(p) = Z₀ᵀ P r(q(p), p) = 0        as many unknowns p as free motions
//! P = Z Zᵀ, G Z = 0; Z₀ = Z at the model's own values; q(p) the start that closes at p
//! ```
//!
//! States of controllers z are unknowns besides, and their rates at rest are zero, too: ż(q(p), 0, z, p) = 0.
//!
//! Newton's iteration; slopes are differences, since p may move the start itself. Forces are linear in stiffnesses,
//! masses and loads, so that one step leads there.

use bksim_mbs::coordinate::CoordinateKind;
use bksim_model::{Model, ParameterId};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::balance::Balance;
use crate::equilibrium::{Equilibrium, cells, columns};
use crate::error::AnalysisError;
use crate::loaded::{HeldContacts, Loaded};
use crate::reduced::{null_space, pseudo_inverse};
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
    /// Stops and friction that count as constraints, and friction that is left out.
    pub held: HeldContacts,
}

/// Finds the values of the parameters `names` at which the start of `model` is in balance, and states of controllers have no rates; the stiffness is by
/// the measures `by`, else by coordinates.
///
/// # Errors
/// [`AnalysisError`] when there are not as many unknowns as free motions, or no values balance them.
pub fn balanced(model: Model, names: &[String], by: &[String]) -> Result<Balanced, AnalysisError> {
    /// Most steps.
    const MOST: usize = 60;
    let mut loaded = Loaded::at_rest(model)?;
    let ids: Vec<ParameterId> =
        names.iter().map(|name| loaded.parameter(name)).collect::<Result<_, _>>()?;
    let own: Vec<f64> = ids.iter().map(|id| loaded.parameters[id.0]).collect();
    let unbalanced = || AnalysisError::NotBalanced { names: names.to_vec() };
    let basis = free_motions(&loaded)?;
    if basis.ncols() != ids.len() {
        return Err(AnalysisError::Unknowns { n_unknown: ids.len(), n_free: basis.ncols() });
    }
    let z = loaded.state_coordinates().into_iter().map(|i| loaded.v[i]);
    let unknowns = Unknowns { ids, basis };

    // Newton's steps, shortened until less is left.
    let mut x = DVector::from_iterator(unknowns.ids.len() + z.len(), own.iter().copied().chain(z));
    let mut at = unknowns.work(&mut loaded, x.as_slice())?;
    let mut is_done = at.value.norm() <= at.rounding;
    for _ in 0..MOST {
        if is_done {
            break;
        }
        let slopes = unknowns.slopes(&mut loaded, &x)?;
        let step = match slopes.clone().lu().solve(&-&at.value) {
            Some(step) if step.iter().all(|x| x.is_finite()) && !is_singular(&slopes) => step,
            _ => return Err(unknowns.without_a_step(&slopes, &at.value, names)),
        };
        let mut share = 1.0;
        let (next, there) = loop {
            let next = &x + &step * share;
            let there = unknowns.work(&mut loaded, next.as_slice());
            match there {
                Ok(there) if there.value.norm() <= at.value.norm().max(there.rounding) => {
                    break (next, there);
                }
                _ if share < 1e-6 => return Err(unbalanced()),
                _ => share *= 0.5,
            }
        };
        let gone = (0..x.len()).all(|k| (next[k] - x[k]).abs() <= 1e-14 * next[k].abs());
        (x, at) = (next, there);
        is_done = gone || at.value.norm() <= 1e-14 * at.size;
    }
    if !is_done && at.value.norm() > 1e-10 * at.size {
        return Err(unbalanced());
    }
    let ids = &unknowns.ids;
    let mut balance = Balance::of(&loaded, by, &[])?;
    let q = position(&loaded, &x.as_slice()[ids.len()..]);
    let by = balance.by_names(&q)?;
    let equilibrium = balance.equilibrium(&q)?;
    let column = |id: &ParameterId| {
        let parameter = &loaded.model().parameters[id.0];
        Column::new(parameter.name.clone(), parameter.unit.clone())
    };
    let values = ids.iter().zip(x.iter().zip(&own));
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
    /// F, J per radian or longest link, then −ż.
    value: DVector<f64>,
    /// The size of the forces that F is the sum of.
    size: f64,
    /// The part of that which is rounding.
    rounding: f64,
}

/// Parameters and states that are to be found, and the free motions that they are to balance.
struct Unknowns {
    ids: Vec<ParameterId>,
    /// Z₀, in units of the mechanism; zero for states.
    basis: DMatrix<f64>,
}

/// The position of the start with states in the places of their integrals.
fn position(loaded: &Loaded, z: &[f64]) -> Vec<f64> {
    let mut q = loaded.q.clone();
    loaded.state_coordinates().into_iter().zip(z).for_each(|(i, z)| q[i] = *z);
    q
}

/// Free motions of the start, orthonormal in units of the mechanism, states left out.
fn free_motions(loaded: &Loaded) -> Result<DMatrix<f64>, AnalysisError> {
    let mut balance = Balance::of(loaded, &[], &[])?;
    let nothing = vec![0.0; balance.forces.nc()];
    let at = balance.at(&loaded.q, &nothing);
    Ok(moving_null_space(loaded, &at.jacobian))
}

/// Directions of the coordinates that move which `jacobian` leaves free, in columns, in units of the mechanism.
fn moving_null_space(loaded: &Loaded, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let states = loaded.state_coordinates();
    let moving: Vec<usize> = (0..jacobian.ncols()).filter(|i| !states.contains(i)).collect();
    let scaled = DMatrix::from_fn(jacobian.nrows(), moving.len(), |row, k| {
        jacobian[(row, moving[k])] * unit(loaded, moving[k])
    });
    let free = null_space(&scaled);
    let mut all = DMatrix::zeros(jacobian.ncols(), free.ncols());
    moving.iter().enumerate().for_each(|(k, &i)| all.set_row(i, &free.row(k)));
    all
}

fn unit(loaded: &Loaded, i: usize) -> f64 {
    let is_length = loaded.system().coordinates()[i].kind == CoordinateKind::Length;
    if is_length { loaded.size } else { 1.0 }
}

/// Part of the largest singular value below which one counts as zero, of slopes that are differences.
const NO_SLOPE: f64 = 1e-9;

/// Slopes with rows and columns of the same size.
fn equilibrated(slopes: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scaled = slopes.clone();
    let positive = |norm: f64| if norm > 0.0 { norm } else { 1.0 };
    for mut row in scaled.row_iter_mut() {
        let size = positive(row.norm());
        row /= size;
    }
    for mut column in scaled.column_iter_mut() {
        let size = positive(column.norm());
        column /= size;
    }
    scaled
}

fn is_singular(slopes: &DMatrix<f64>) -> bool {
    // Slopes that are not finite determine nothing.
    Svd::values(&equilibrated(slopes)).is_none_or(|values| values.min() <= NO_SLOPE * values.max())
}

impl Unknowns {
    /// F, then the rates of the states, at values of the parameters and of the states.
    fn work(&self, loaded: &mut Loaded, x: &[f64]) -> Result<Work, AnalysisError> {
        let n_own = loaded.mechanism.parameters.len();
        let (p, z) = x.split_at(self.ids.len());
        let values = loaded.parameters_with(&self.ids, p);
        loaded.restart(&values[..n_own])?;
        let mut balance = Balance::of(loaded, &[], &[])?;
        let nothing = vec![0.0; balance.forces.nc()];
        let q = position(loaded, z);
        let at = balance.at(&q, &nothing);
        let free = moving_null_space(loaded, &at.jacobian);
        let states = loaded.state_coordinates();
        let force = |i: usize| if states.contains(&i) { 0.0 } else { at.residual[i] };
        let forces = DVector::from_fn(q.len(), |i, _| force(i) * unit(loaded, i));
        let moved = self.basis.transpose() * (&free * (free.transpose() * &forces));
        let rates = states.iter().map(|&i| at.residual[i]);
        let value: Vec<f64> = moved.iter().copied().chain(rates).collect();
        let size = forces.norm();
        Ok(Work { value: value.into(), size, rounding: 1e-14 * size })
    }

    /// The slopes of F and of the rates, by central differences.
    fn slopes(&self, loaded: &mut Loaded, x: &DVector<f64>) -> Result<DMatrix<f64>, AnalysisError> {
        let mut slopes = DMatrix::zeros(x.len(), x.len());
        for k in 0..x.len() {
            let step = if x[k] == 0.0 { 1e-5 } else { 1e-5 * x[k].abs() };
            let mut at = |sign: f64| {
                let mut aside = x.clone();
                aside[k] += sign * step;
                self.work(loaded, aside.as_slice())
            };
            let [more, less] = [at(1.0)?.value, at(-1.0)?.value];
            slopes.column_mut(k).copy_from(&((more - less) / (2.0 * step)));
        }
        Ok(slopes)
    }

    /// The reason why no step leads to a balance: nothing balances, or states do with any value of the parameters.
    fn without_a_step(
        &self,
        slopes: &DMatrix<f64>,
        value: &DVector<f64>,
        names: &[String],
    ) -> AnalysisError {
        let names = names.to_vec();
        let n = self.ids.len();
        let by_states = slopes.columns(n, slopes.ncols() - n).into_owned();
        let left = value - &by_states * (pseudo_inverse(&by_states) * value);
        if by_states.ncols() > 0 && left.norm() <= NO_SLOPE * value.norm() {
            AnalysisError::StatesBalance { names }
        } else {
            AnalysisError::NotBalanced { names }
        }
    }
}
