//! Equilibria that are not isolated: curves and surfaces of poses that are all in balance, such as of a balanced lamp.
//!
//! ```text
//! F(x) = (g, Zᵀ r) = 0        G Z = 0
//! F′ n = 0                    n: the directions that the slopes leave free
//! F(x) = 0,  nᵀ (x − x₀) = s  solved for s = ± 0.02: tangents; for s = ± 0.1 along these: the family
//! ```
//!
//! A stiffness of zero need not mean neighbours in balance: in the potential x⁴ there are none. Coordinates count in units of the
//! mechanism, radians and longest links, forces in parts of what joints and loads bear.

use bksim_mbs::coordinate::Owner;
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::balance::Balance;
use crate::equilibrium::{Equilibrium, Family, Stability};
use crate::error::AnalysisError;
use crate::poses::Poses;
use crate::reduced::{null_space, pseudo_inverse};

/// A family with its directions at one of its members.
#[derive(Clone, Debug)]
pub(crate) struct FamilyAt {
    pub(crate) family: Family,
    /// Directions along it, orthonormal in units of the mechanism, in columns.
    tangents: DMatrix<f64>,
}

/// F with its slopes.
struct Equations {
    value: DVector<f64>,
    slopes: DMatrix<f64>,
    /// Largest |g|, and largest part of the forces that is not in balance.
    closure: f64,
    work: f64,
}

/// Steps along the directions that are tried, and along the tangents that come of them.
const NEAR: f64 = 0.02;
const FAR: f64 = 0.1;
/// Singular values of the slopes below this part of the largest count as zero.
const FREE: f64 = 1e-9;
/// Part of the loads that is left by rounding.
const IN_BALANCE: f64 = 1e-10;
/// Equilibria this near to each other that have no stiffness are one, rad or parts of the longest link.
const CLOSE: f64 = 0.05;
/// Differences of poses that are the same.
const SAME: f64 = 1e-6;

impl Balance<'_> {
    /// Positions of all equilibria that are isolated, over the parameter `name`.
    ///
    /// # Errors
    /// [`AnalysisError::NotIsolated`] where there are others alone.
    pub(crate) fn isolated(&mut self, name: &str) -> Result<Vec<Vec<f64>>, AnalysisError> {
        let Poses { balanced, beyond, .. } = self.all()?;
        // Over a parameter, a branch may come back from beyond a stop.
        let mut poses = [balanced, beyond].concat();
        let mut family = None;
        poses.retain(|q| {
            let own = self.family(q);
            let is_isolated = own.is_none();
            family = family.take().or(own);
            is_isolated
        });
        match family {
            Some(at) if poses.is_empty() => {
                let parameter = name.to_owned();
                Err(AnalysisError::NotIsolated { parameter, moves: at.family.moves })
            }
            _ => Ok(poses),
        }
    }

    /// The equilibria at positions, of each family the first.
    pub(crate) fn distinct<'q>(
        &mut self,
        poses: impl Iterator<Item = &'q Vec<f64>>,
    ) -> Result<Vec<Equilibrium>, AnalysisError> {
        let mut equilibria: Vec<Equilibrium> = Vec::new();
        let mut families: Vec<(usize, FamilyAt)> = Vec::new();
        for q in poses {
            // Where branches cross there are no directions that a family could have.
            let family = if self.ways_at(q).is_some() { None } else { self.family(q) };
            if let Some(at) = &family {
                let mut known = families.iter().filter(|(_, known)| {
                    let [own, other] = [&at.family, &known.family];
                    (own.dimension, &own.moves) == (other.dimension, &other.moves)
                });
                if known.any(|(k, known)| self.is_of_family(&equilibria[*k].q, known, q)) {
                    continue;
                }
            }
            let mut found = self.equilibrium(q)?;
            // A search comes only near to one whose stiffness vanishes.
            let is_near = |e: &Equilibrium| {
                e.stability == Stability::Neutral
                    && self.apart(&e.q, q).iter().all(|off| off.abs() < CLOSE)
            };
            if family.is_none()
                && found.stability == Stability::Neutral
                && equilibria.iter().any(is_near)
            {
                continue;
            }
            if let Some(at) = family {
                found.family = Some(at.family.clone());
                families.push((equilibria.len(), at));
            }
            equilibria.push(found);
        }
        Ok(equilibria)
    }

    /// The family that an equilibrium belongs to, unless it is isolated.
    pub(crate) fn family(&mut self, q: &[f64]) -> Option<FamilyAt> {
        let x = DVector::from_column_slice(q).component_div(&self.units());
        let free = null_space_of(&self.balance_equations(&x)?.slopes);
        // Where a step in each of the directions leads.
        let mut steps: Vec<DVector<f64>> = Vec::new();
        for direction in free.column_iter() {
            let direction = direction.into_owned();
            let ahead = self.along(&x, &direction, NEAR);
            let back = self.along(&x, &direction, -NEAR);
            if let (Some(ahead), Some(back)) = (ahead, back) {
                steps.push((ahead - back) / (2.0 * NEAR));
            }
        }
        if steps.is_empty() {
            return None;
        }
        let Svd { u, singular_values: values, .. } = Svd::new(&DMatrix::from_columns(&steps))?;
        let is_tangent = |&k: &usize| values[k] > 0.1 * values.max();
        let tangents: Vec<usize> = (0..values.len()).filter(is_tangent).collect();
        let tangents: Vec<DVector<f64>> = (tangents.into_iter())
            .map(|k| u.column(k).into_owned())
            .filter(|tangent| {
                [FAR, -FAR].iter().all(|&step| self.along(&x, tangent, step).is_some())
            })
            .collect();
        if tangents.is_empty() {
            return None;
        }
        let tangents = DMatrix::from_columns(&tangents);
        let [moves, free] = self.moved(q, &tangents);
        let family = Family { dimension: tangents.ncols(), moves, free };
        Some(FamilyAt { family, tangents })
    }

    /// True where a path of equilibria leads from a member of a family to another equilibrium.
    pub(crate) fn is_of_family(&mut self, from: &[f64], of: &FamilyAt, to: &[f64]) -> bool {
        let units = self.units();
        let x = DVector::from_column_slice(from).component_div(&units);
        let to = DVector::from_column_slice(to).component_div(&units);
        if self.leads(x.clone(), &to) {
            return true;
        }
        // A curve may lead away first.
        of.family.dimension == 1 && {
            let tangent = of.tangents.column(0).into_owned();
            self.passes(x.clone(), tangent.clone(), &to) || self.passes(x, -tangent, &to)
        }
    }

    /// Steps towards a pose among equilibria until it is reached, or they lead no nearer.
    fn leads(&mut self, mut x: DVector<f64>, to: &DVector<f64>) -> bool {
        const MOST: usize = 60;
        const LONGEST: f64 = 0.4;
        for _ in 0..MOST {
            let off = self.difference(to, &x);
            if off.amax() < SAME {
                return true;
            }
            let Some(at) = self.balance_equations(&x) else { return false };
            let free = null_space_of(&at.slopes);
            let along = &free * (free.transpose() * &off);
            let length = along.norm();
            if length < 0.1 * SAME {
                return false;
            }
            match self.along(&x, &(along / length), length.min(LONGEST)) {
                Some(next) => x = next,
                None => return false,
            }
        }
        false
    }

    /// True where a curve of equilibria passes a pose.
    fn passes(
        &mut self,
        mut x: DVector<f64>,
        mut tangent: DVector<f64>,
        to: &DVector<f64>,
    ) -> bool {
        const MOST: usize = 150;
        let first = x.clone();
        for k in 0..MOST {
            let Some(next) = self.along(&x, &tangent, FAR) else { return false };
            tangent = self.difference(&next, &x).normalize();
            x = next;
            if self.difference(to, &x).norm() < 2.0 * FAR && self.leads(x.clone(), to) {
                return true;
            }
            if k > 2 && self.difference(&first, &x).norm() < FAR {
                return false;
            }
        }
        false
    }

    /// The difference of two poses, angles without whole turns where these mean nothing.
    fn difference(&self, a: &DVector<f64>, b: &DVector<f64>) -> DVector<f64> {
        let units = self.units();
        let [a, b] = [a, b].map(|x| x.component_mul(&units));
        if self.counts_turns {
            return (a - b).component_div(&units);
        }
        self.apart(a.as_slice(), b.as_slice()).into()
    }

    /// The equilibrium at a step along a direction, if there is one.
    fn along(
        &mut self,
        x: &DVector<f64>,
        direction: &DVector<f64>,
        step: f64,
    ) -> Option<DVector<f64>> {
        const MOST: usize = 60;
        const LONGEST: f64 = 0.2;
        let mut next = x + direction * step;
        for _ in 0..MOST {
            let at = self.balance_equations(&next)?;
            let ahead = direction.dot(&(&next - x)) - step;
            if at.closure < IN_BALANCE && at.work < IN_BALANCE && ahead.abs() < IN_BALANCE {
                return Some(next);
            }
            let n_rows = at.slopes.nrows();
            let mut slopes = at.slopes.insert_row(n_rows, 0.0);
            slopes.row_mut(n_rows).copy_from(&direction.transpose());
            let right = -at.value.push(ahead);
            let change = pseudo_inverse(&slopes) * right;
            let length = change.norm();
            if !length.is_finite() {
                return None;
            }
            next += change * (LONGEST / length).min(1.0);
        }
        None
    }

    /// F and its slopes; `None` where they have no finite values.
    fn balance_equations(&mut self, x: &DVector<f64>) -> Option<Equations> {
        let units = self.units();
        let q = x.component_mul(&units);
        let lambda = self.balancing(q.as_slice())?;
        let loads = self.load_size(q.as_slice(), &lambda);
        let at = self.at(q.as_slice(), &lambda);
        let states = self.states().to_vec();
        let scaled = DMatrix::from_fn(at.jacobian.nrows(), x.len(), |row, i| {
            at.jacobian[(row, i)] * units[i]
        });
        // Rows of unit length; of states the rates themselves.
        let lengths: Vec<f64> =
            scaled.row_iter().map(|row| if row.norm() > 0.0 { row.norm() } else { 1.0 }).collect();
        let g = DMatrix::from_fn(scaled.nrows(), x.len(), |row, i| scaled[(row, i)] / lengths[row]);
        let z = null_space(&scaled);
        let stiffness =
            DMatrix::from_fn(x.len(), x.len(), |i, j| at.stiffness[(i, j)] * units[i] * units[j]);
        let is_force = |i: &usize| !states.contains(i);
        let forces: Vec<usize> = (0..x.len()).filter(is_force).collect();
        let largest = stiffness.select_rows(&forces).amax();
        let size = loads.max(largest);
        let size_of = |i: usize| {
            let own = if is_force(&i) { size } else { stiffness.row(i).amax() };
            if own > 0.0 { own } else { 1.0 }
        };
        let weights = DVector::from_fn(x.len(), |i, _| 1.0 / size_of(i));
        let residual = at.residual.component_mul(&units).component_mul(&weights);
        let stiffness = DMatrix::from_diagonal(&weights) * stiffness;
        let work = z.transpose() * &residual;
        let closure = DVector::from_fn(lengths.len(), |row, _| at.closure[row] / lengths[row]);
        let (n_rows, n_free) = (g.nrows(), z.ncols());
        let mut slopes = DMatrix::zeros(n_rows + n_free, x.len());
        slopes.rows_mut(0, n_rows).copy_from(&g);
        slopes.rows_mut(n_rows, n_free).copy_from(&(z.transpose() * stiffness));
        let value: Vec<f64> = closure.iter().chain(work.iter()).copied().collect();
        let is_finite = value.iter().chain(slopes.iter()).all(|value| value.is_finite());
        is_finite.then(|| Equations {
            closure: if n_rows > 0 { closure.amax() } else { 0.0 },
            work: if n_free > 0 { work.amax() } else { 0.0 },
            value: value.into(),
            slopes,
        })
    }

    /// Names of what moves along some directions, in units of the mechanism: joints and bodies without one, then all quantities.
    fn moved(&mut self, q: &[f64], tangents: &DMatrix<f64>) -> [Vec<String>; 2] {
        let units = self.units();
        let loaded = self.loaded;
        let (model, system) = (loaded.model(), loaded.system());
        let n_of_joints: usize = model.joints.iter().map(|joint| joint.kind.motions().len()).sum();
        let coordinates = system.coordinates();
        let is_of_body = |name: &str| {
            coordinates.iter().any(|c| c.name == name && matches!(c.owner, Owner::Body(..)))
        };
        let gradients = self.pose_gradients(q);
        let moves = |k: usize| {
            let own = DVector::from_column_slice(&gradients[k]).component_mul(&units);
            let unit = if loaded.quantities[k].is_angle() { 1.0 } else { loaded.size };
            (own.transpose() * tangents).norm() > 1e-3 * unit
        };
        let all = (0..loaded.quantities.len()).map(|k| (k, &loaded.quantities[k].names[0]));
        let moving: Vec<(usize, &String)> = all.filter(|&(k, _)| moves(k)).collect();
        let shown = moving.iter().filter(|&&(k, name)| k < n_of_joints || is_of_body(name));
        let of_states =
            self.states().to_vec().into_iter().filter(|&i| tangents.row(i).norm() > 1e-3);
        let of_states: Vec<String> = of_states.map(|i| coordinates[i].rate_name.clone()).collect();
        let names = |of: Vec<&(usize, &String)>| {
            of.into_iter().map(|(_, name)| (*name).clone()).chain(of_states.clone()).collect()
        };
        [names(shown.collect()), names(moving.iter().collect())]
    }
}

/// Directions that slopes with rows of unit size leave free.
fn null_space_of(slopes: &DMatrix<f64>) -> DMatrix<f64> {
    let n = slopes.ncols();
    let mut square = DMatrix::zeros(n.max(slopes.nrows()), n);
    square.rows_mut(0, slopes.nrows()).copy_from(slopes);
    let Some(svd) = Svd::new(&square) else { return DMatrix::zeros(n, 0) };
    let free: Vec<usize> = (0..n).filter(|&k| svd.singular_values[k] <= FREE).collect();
    DMatrix::from_fn(n, free.len(), |i, k| svd.v_t[(free[k], i)])
}
