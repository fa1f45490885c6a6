//! Rotors that turn with joints: the inertia `armature` along the joint's own motion.
//!
//! ```text
//! T += ½ a ṡ²,   ṡ = J v       M += a Jᵀ J,   h += a Jᵀ (J̇ v)
//! ```
//!
//! A motor's rotor turns n times as fast as its joint and adds n² times its inertia along the motion s of the joint;
//! that it turns with the body that carries it is left out, as its axis may be any. J is a row of zeros and a one
//! for a joint of the tree.

use bksim_expr::{Expr, SymbolId};
use bksim_model::{JointId, Measure, Model};

use crate::folding::short;
use crate::kinematics::Kinematics;
use crate::sparse::SparseMatrix;

/// One rotor: its inertia and the rate of its motion.
struct Rotor {
    /// a, kg m² or kg.
    inertia: Expr,
    /// Row J by the coordinates that it depends on.
    row: Vec<(usize, Expr)>,
    /// J̇ v.
    bias: Expr,
}

/// The rotors of a model.
fn rotors(model: &Model, kinematics: &Kinematics) -> Vec<Rotor> {
    let pool = &model.pool;
    let symbols = |of: fn(&crate::coordinate::Coordinate) -> SymbolId| -> Vec<SymbolId> {
        kinematics.coordinates.iter().map(of).collect()
    };
    let (q, v) = (symbols(|c| c.q), symbols(|c| c.v));
    let with_rotor = (0..model.joints.len()).map(JointId);
    let with_rotor = with_rotor.filter(|id| !pool.is_zero(model.joints[id.0].armature));
    let rotor = |id: JointId| {
        let rate = short(pool, kinematics.measure(model, Measure::JointVelocity(id, 0)));
        let entries = pool.jacobian(&[rate], &v).entries;
        let slopes = pool.jacobian(&[rate], &q).entries;
        let terms = slopes.into_iter().map(|(_, k, slope)| pool.mul(slope, pool.symbol_expr(v[k])));
        Rotor {
            inertia: model.joints[id.0].armature,
            row: entries.into_iter().map(|(_, k, slope)| (k, slope)).collect(),
            bias: pool.sum(terms.collect::<Vec<_>>()),
        }
    };
    with_rotor.map(rotor).collect()
}

/// True where a joint of the model carries a rotor.
pub(crate) fn are_there(model: &Model) -> bool {
    model.joints.iter().any(|joint| !model.pool.is_zero(joint.armature))
}

/// The terms ½ a ṡ² of T.
pub(crate) fn kinetic_energy(model: &Model, kinematics: &Kinematics, rates: &[Expr]) -> Vec<Expr> {
    let pool = &model.pool;
    let term = |rotor: Rotor| {
        let parts = rotor.row.iter().map(|&(k, slope)| pool.mul(slope, rates[k]));
        let rate = pool.sum(parts.collect::<Vec<_>>());
        pool.product([pool.rational(1, 2), rotor.inertia, pool.powi(rate, 2)])
    };
    rotors(model, kinematics).into_iter().map(term).collect()
}

/// M with the entries a Jᵀ J.
pub(crate) fn mass_matrix(
    model: &Model,
    kinematics: &Kinematics,
    matrix: &SparseMatrix,
) -> SparseMatrix {
    let pool = &model.pool;
    let rotors = rotors(model, kinematics);
    let terms = rotors.iter().flat_map(|rotor| {
        let of_row = move |&(i, of_i): &(usize, Expr)| {
            let of = move |&(j, of_j)| (i, j, pool.product([rotor.inertia, of_i, of_j]));
            rotor.row.iter().map(of)
        };
        rotor.row.iter().flat_map(of_row)
    });
    matrix.plus(pool, terms)
}

/// Adds a Jᵀ (J v̇ + J̇ v) to generalised forces that a motion needs, by coordinate.
pub(crate) fn add_forces(
    model: &Model,
    kinematics: &Kinematics,
    accelerations: &[Expr],
    forces: &mut [Expr],
) {
    let pool = &model.pool;
    for rotor in rotors(model, kinematics) {
        let parts = rotor.row.iter().map(|&(k, slope)| pool.mul(slope, accelerations[k]));
        let acceleration = pool.sum(parts.chain([rotor.bias]).collect::<Vec<_>>());
        for &(k, slope) in &rotor.row {
            let own = pool.product([rotor.inertia, slope, acceleration]);
            forces[k] = pool.add(forces[k], own);
        }
    }
}
