//! T, M, h and ∂V/∂q by Lagrange's equations.
//!
//! ```text
//! T = ½ q̇ᵀ M q̇,  M = Σ (J_Tᵀ m J_T + J_Rᵀ I′ J_R)                              (1.1)
//! h_k = Σ_lm (∂M_kl/∂q_m − ½ ∂M_lm/∂q_k) v_l v_m
//! ```
//!
//! Source: Lê Hồng Lam and Đinh Văn Phong (2008), equation (1.1), and the Christoffel sums of M for
//! d/dt ∂T/∂q̇ − ∂T/∂q = M q̈ + h. Everything is derived in the [absolute
//! angles](crate::absolute_angles) of the bodies and pulled back to the generalised coordinates.

use std::collections::BTreeMap;

use bksim_expr::{Expr, Pool, SymbolId};

use crate::absolute_angles::AbsoluteAngles;
use crate::coordinate::{Coordinate, CoordinateKind};
use crate::inertia::central_inertia;
use crate::kinematics::Kinematics;
use crate::norm::{self, unnamed};
use crate::rotor;
use crate::sparse::SparseMatrix;
use crate::spatial;
use bksim_model::{BodyId, Model, Vector};

/// Number of terms up to which a sum that was pulled back is collected again.
const MAX_COLLECTED_TERMS: usize = 64;

/// The left side of Lagrange's equations without loads and constraints.
pub(crate) struct LeftSide {
    /// T(q, v), J.
    pub(crate) kinetic_energy: Expr,
    /// V(q), J.
    pub(crate) potential_energy: Expr,
    /// M(q), nq × nq.
    pub(crate) mass_matrix: SparseMatrix,
    /// h(q, v), nq.
    pub(crate) bias: Vec<Expr>,
    /// ∂V/∂q, nq.
    pub(crate) potential_gradient: Vec<Expr>,
    /// h + ∂V/∂q, nq.
    pub(crate) resistance: Vec<Expr>,
    /// M v̇ + h + ∂V/∂q, nq, where there is a shorter way to it than by M.
    pub(crate) inverse_dynamics: Option<Vec<Expr>>,
}

impl LeftSide {
    /// Gives the states their rows, in which a rate stands for a force.
    pub(crate) fn add_states(&mut self, model: &Model, kinematics: &Kinematics) {
        let pool = &model.pool;
        let states = kinematics.coordinates.iter().enumerate();
        let states = states.filter(|(_, c)| c.kind == CoordinateKind::Integral);
        let states: Vec<(usize, Expr)> = states.map(|(i, c)| (i, pool.symbol_expr(c.a))).collect();
        let n = self.mass_matrix.n_rows();
        let of_states = states.iter().map(|&(i, _)| (i, i, pool.one()));
        let entries = self.mass_matrix.entries().chain(of_states).collect::<Vec<_>>();
        self.mass_matrix = SparseMatrix::new(n, n, entries);
        if let Some(forces) = &mut self.inverse_dynamics {
            for (i, rate) in states {
                forces[i] = rate;
            }
        }
    }

    /// Gives the joints their rotors.
    pub(crate) fn add_rotors(&mut self, model: &Model, kinematics: &Kinematics) {
        let pool = &model.pool;
        let symbols = |of: fn(&Coordinate) -> SymbolId| -> Vec<Expr> {
            kinematics.coordinates.iter().map(|c| pool.symbol_expr(of(c))).collect()
        };
        let (v, a) = (symbols(|c| c.v), symbols(|c| c.a));
        let at_rest = vec![pool.zero(); v.len()];
        let kinetic = rotor::kinetic_energy(model, kinematics, &v);
        self.kinetic_energy = pool.sum([self.kinetic_energy].into_iter().chain(kinetic));
        self.mass_matrix = rotor::mass_matrix(model, kinematics, &self.mass_matrix);
        for forces in [&mut self.bias, &mut self.resistance] {
            rotor::add_forces(model, kinematics, &at_rest, forces);
        }
        if let Some(forces) = &mut self.inverse_dynamics {
            rotor::add_forces(model, kinematics, &a, forces);
        }
    }

    /// Gives the lengths of quaternions their inertia.
    pub(crate) fn add_norms(&mut self, model: &Model, kinematics: &Kinematics) {
        let pool = &model.pool;
        let symbols = |of: fn(&Coordinate) -> SymbolId| -> Vec<Expr> {
            kinematics.coordinates.iter().map(|c| pool.symbol_expr(of(c))).collect()
        };
        let (v, a) = (symbols(|c| c.v), symbols(|c| c.a));
        let at_rest = vec![pool.zero(); v.len()];
        let kinetic = norm::kinetic_energy(model, kinematics, &v, &unnamed);
        self.kinetic_energy = pool.sum([self.kinetic_energy].into_iter().chain(kinetic));
        self.mass_matrix = norm::mass_matrix(model, kinematics, &self.mass_matrix);
        for forces in [&mut self.bias, &mut self.resistance] {
            norm::add_forces(model, kinematics, [&v, &at_rest], forces, &unnamed);
        }
        if let Some(forces) = &mut self.inverse_dynamics {
            norm::add_forces(model, kinematics, [&v, &a], forces, &unnamed);
        }
    }
}

/// Derives the left side for the bodies of `model` in the potential V(q).
pub(crate) fn left_side(model: &Model, kinematics: &Kinematics, potential: Expr) -> LeftSide {
    let pool = &model.pool;
    let angles = AbsoluteAngles::of(model, kinematics);
    let derivation = AngleDerivation {
        model,
        kinematics,
        state: [angles.state(), vec![model.time]].concat(),
        symbols: angles.coordinates.iter().map(|c| c.q).collect(),
        angles,
    };
    let lower = derivation.mass_matrix();
    let bias = derivation.bias(&lower);
    let [potential] = derivation.angles.to_angles(&[potential])[..] else {
        unreachable!("one expression in, one out")
    };
    let potential = pool.collect(potential, &derivation.state);
    let gradient = pool.jacobian(&[potential], &derivation.symbols).entries;
    let gradient = gradient.into_iter().map(|(_, k, slope)| (k, slope)).collect();

    let energies = derivation.angles.back_to_q(&[derivation.kinetic_energy(&lower), potential]);
    let mass_matrix = derivation.pulled_back_matrix(lower);
    let bias = derivation.pulled_back(bias);
    let potential_gradient = derivation.pulled_back(gradient);
    let resistance = bias.iter().zip(&potential_gradient).map(|(&h, &slope)| pool.add(h, slope));
    let resistance = resistance.collect();
    LeftSide {
        kinetic_energy: energies[0],
        potential_energy: energies[1],
        mass_matrix,
        bias,
        potential_gradient,
        resistance,
        inverse_dynamics: None,
    }
}

/// The lower triangle of a symmetric matrix, without entries that are zero.
type Lower = BTreeMap<(usize, usize), Expr>;

struct AngleDerivation<'m> {
    model: &'m Model,
    kinematics: &'m Kinematics,
    angles: AbsoluteAngles<'m>,
    /// Coordinates of the derivation, their rates and time: all symbols but the parameters.
    state: Vec<SymbolId>,
    symbols: Vec<SymbolId>,
}

/// One body's share of an entry of M: a mass times the product of two columns of J_T. Bodies with
/// equal columns share one product.
#[derive(Default)]
struct MassEntry {
    translation: Vec<((Vector, Vector), Vec<Expr>)>,
    rotation: Vec<Expr>,
}

impl AngleDerivation<'_> {
    fn pool(&self) -> &Pool {
        &self.model.pool
    }

    /// M by (1.1): J_T = ∂r_c/∂q in world axes; J_R = ∂ω/∂q̇ in body axes, where I′ is constant.
    fn mass_matrix(&self) -> Lower {
        // Columns of J_T, body by body.
        let pool = self.pool();
        let n_bodies = self.model.bodies.len();
        let positions: Vec<Expr> = (1..n_bodies)
            .flat_map(|b| self.kinematics.position(self.model, BodyId(b), None))
            .collect();
        let jacobian = pool.jacobian(&self.angles.to_angles(&positions), &self.symbols);
        let mut columns: Vec<BTreeMap<usize, Vector>> = vec![BTreeMap::new(); n_bodies];
        for (row, k, slope) in jacobian.entries {
            let column = columns[1 + row / 3].entry(k).or_insert_with(|| spatial::zero(pool));
            column[row % 3] = slope;
        }

        // Each body adds m J_Tᵀ J_T and J_Rᵀ I′ J_R.
        let rotations = self.kinematics.poses.iter().map(|pose| &pose.rotation);
        let turning = self.angles.turning(rotations);
        let mut entries: BTreeMap<(usize, usize), MassEntry> = BTreeMap::new();
        for (body_idx, columns) in columns.iter().enumerate().skip(1) {
            let body = &self.model.bodies[body_idx];
            if !pool.is_zero(body.mass) {
                for (&k, j_k) in columns {
                    for (&l, j_l) in columns.range(..=k) {
                        let entry = entries.entry((k, l)).or_default();
                        match entry.translation.iter_mut().find(|(pair, _)| *pair == (*j_k, *j_l)) {
                            Some((_, masses)) => masses.push(body.mass),
                            None => entry.translation.push(((*j_k, *j_l), vec![body.mass])),
                        }
                    }
                }
            }
            let inertia = central_inertia(self.model, BodyId(body_idx));
            let turning = &turning[body_idx];
            for (k, j_k) in turning {
                let momentum: Vector =
                    std::array::from_fn(|i| spatial::dot(pool, &inertia[i], j_k));
                for (l, j_l) in turning.iter().filter(|(l, _)| l <= k) {
                    let entry = entries.entry((*k, *l)).or_default();
                    entry.rotation.push(spatial::dot(pool, &momentum, j_l));
                }
            }
        }

        // Entries by functions of the state, so that each coefficient is a group of parameters.
        let (indices, sums): (Vec<_>, Vec<_>) =
            entries.into_iter().map(|(at, entry)| (at, self.entry_sum(entry))).unzip();
        let collected = pool.collect_all(&sums, &self.state);
        indices.into_iter().zip(collected).filter(|&(_, e)| !pool.is_zero(e)).collect()
    }

    fn entry_sum(&self, entry: MassEntry) -> Expr {
        let pool = self.pool();
        let translation = entry
            .translation
            .into_iter()
            .map(|((j_k, j_l), masses)| pool.mul(pool.sum(masses), spatial::dot(pool, &j_k, &j_l)));
        pool.sum(translation.chain(entry.rotation).collect::<Vec<_>>())
    }

    fn rate(&self, k: usize) -> Expr {
        self.pool().symbol_expr(self.angles.coordinates[k].v)
    }

    /// ½ vᵀ M v, each product of rates once.
    fn kinetic_energy(&self, lower: &Lower) -> Expr {
        let pool = self.pool();
        let terms = lower.iter().map(|(&(k, l), &entry)| {
            let factor = if k == l { pool.rational(1, 2) } else { pool.one() };
            pool.product([factor, entry, self.rate(k), self.rate(l)])
        });
        pool.sum(terms.collect::<Vec<_>>())
    }

    /// The Christoffel sums, from the slopes ∂M_kl/∂q_m that are not zero.
    fn bias(&self, lower: &Lower) -> BTreeMap<usize, Expr> {
        let pool = self.pool();
        let indices: Vec<(usize, usize)> = lower.keys().copied().collect();
        let entries: Vec<Expr> = lower.values().copied().collect();
        let mut terms: BTreeMap<usize, Vec<Expr>> = BTreeMap::new();
        let mut add = |k: usize, factors: [Expr; 4]| {
            terms.entry(k).or_default().push(pool.product(factors));
        };
        for (row, m, slope) in pool.jacobian(&entries, &self.symbols).entries {
            let (k, l) = indices[row];
            let [v_k, v_l, v_m] = [k, l, m].map(|i| self.rate(i));
            add(k, [slope, v_l, v_m, pool.one()]);
            if k == l {
                add(m, [slope, v_k, v_l, pool.rational(-1, 2)]);
            } else {
                add(l, [slope, v_k, v_m, pool.one()]);
                add(m, [slope, v_k, v_l, pool.int(-1)]);
            }
        }
        terms.into_iter().map(|(k, terms)| (k, pool.sum(terms))).collect()
    }

    /// Sᵀ x in terms of q and v.
    fn pulled_back(&self, x: BTreeMap<usize, Expr>) -> Vec<Expr> {
        let n_terms = self.symbols.len();
        let sizes: Vec<usize> =
            self.angles.spreads().into_iter().map(|spread| spread * n_terms).collect();
        let mut sums = vec![self.pool().zero(); sizes.len()];
        for (i, sum) in self.angles.pull_back(&self.back_to_q(x)) {
            sums[i] = sum;
        }
        self.collected(sums, &sizes)
    }

    /// Sᵀ X S in terms of q and v.
    fn pulled_back_matrix(&self, lower: Lower) -> SparseMatrix {
        let spreads = self.angles.spreads();
        let lower = self.angles.congruent(&self.back_to_q(lower));
        let (indices, entries): (Vec<_>, Vec<_>) = lower.into_iter().unzip();
        let sizes: Vec<usize> = indices.iter().map(|&(i, j)| spreads[i] * spreads[j]).collect();
        let entries = indices.into_iter().zip(self.collected(entries, &sizes));
        let entries = entries.filter(|&(_, e)| !self.pool().is_zero(e)).flat_map(|((i, j), e)| {
            [Some((i, j, e)), (i != j).then_some((j, i, e))].into_iter().flatten()
        });
        SparseMatrix::new(spreads.len(), spreads.len(), entries)
    }

    /// Entries in terms of q and v.
    fn back_to_q<K: Ord>(&self, entries: impl IntoIterator<Item = (K, Expr)>) -> BTreeMap<K, Expr> {
        let (keys, values): (Vec<K>, Vec<Expr>) = entries.into_iter().unzip();
        keys.into_iter().zip(self.angles.back_to_q(&values)).collect()
    }

    /// Short sums are collected once more: terms of different bodies may have met.
    fn collected(&self, mut sums: Vec<Expr>, sizes: &[usize]) -> Vec<Expr> {
        let short: Vec<usize> =
            (0..sums.len()).filter(|&i| sizes[i] <= MAX_COLLECTED_TERMS).collect();
        let roots: Vec<Expr> = short.iter().map(|&i| sums[i]).collect();
        for (i, e) in short.into_iter().zip(self.pool().collect_all(&roots, &self.state)) {
            sums[i] = e;
        }
        sums
    }
}
