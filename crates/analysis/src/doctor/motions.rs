//! Free motions, each by as few joints as can be.

use bksim_expr::{SymbolId, Tape};
use bksim_model::{BodyId, JointId, motion_words};
use nalgebra::{DMatrix, DVector};

use super::pose::Placed;
use crate::error::AnalysisError;
use crate::reduced::null_space;
use crate::rows::rank;

/// A way in which a mechanism can move.
#[derive(Clone, PartialEq, Debug)]
pub struct FreeMotion {
    /// Measures that change, with the rate of each for a rate of one of the first, and its unit.
    pub rates: Vec<(String, f64, &'static str)>,
    /// Bodies that move.
    pub bodies: Vec<String>,
    /// True where the motion goes on; else the pose yields, but does not move: it is singular.
    pub is_finite: bool,
    /// Rates of the coordinates of all bodies, in units of the mechanism.
    pub(crate) direction: Vec<f64>,
}

/// Parts of the largest rate below which one counts as none.
const NO_RATE: f64 = 1e-7;

/// The free motions of a mechanism in a pose.
pub(super) fn free_motions(placed: &Placed) -> Result<Vec<FreeMotion>, AnalysisError> {
    let jacobian = placed.jacobian();
    let free = if jacobian.nrows() == 0 {
        DMatrix::identity(placed.q.len(), placed.q.len())
    } else {
        null_space(&jacobian)
    };
    let is_joined = |body: &usize| {
        let of = BodyId(*body);
        placed.model.joints.iter().any(|j| j.predecessor.body == of || j.successor.body == of)
    };
    let all = 1..placed.model.bodies.len();
    let lone: Vec<usize> = all.clone().filter(|body| !is_joined(body)).collect();
    let (mut names, mut slopes) = measures(placed, &lone)?;
    let mut rates = &slopes * &free;
    // Of bodies that roll or touch, no joint has a position.
    if rank(&rates) < free.ncols() {
        (names, slopes) = measures(placed, &all.collect::<Vec<_>>())?;
        rates = &slopes * &free;
    }
    let mut found = Vec::new();
    for weights in sparse_combinations(&rates) {
        let along = &free * &weights;
        let shown = &slopes * &along;
        // The largest rate is one.
        let Some(first) = (0..shown.len()).max_by(|&a, &b| {
            // Of equal ones the first.
            (shown[a].abs(), b)
                .partial_cmp(&(shown[b].abs() * (1.0 + 1e-9), a))
                .unwrap_or(std::cmp::Ordering::Equal)
        }) else {
            continue;
        };
        let (along, shown) = (&along / shown[first], &shown / shown[first]);
        let moving = (0..shown.len()).filter(|&k| shown[k].abs() > NO_RATE);
        let rates = moving.map(|k| {
            let (name, unit, size) = &names[k];
            (name.clone(), shown[k] * size, *unit)
        });
        found.push(FreeMotion {
            rates: rates.collect(),
            bodies: moving_bodies(placed, &along)?,
            is_finite: is_finite(placed, &along),
            direction: along.iter().copied().collect(),
        });
    }
    Ok(found)
}

/// Joint positions, and the coordinates of these bodies: names, units with their sizes, slopes in units
/// of the mechanism.
#[expect(clippy::type_complexity, reason = "names of rows beside the matrix")]
fn measures(
    placed: &Placed,
    bodies: &[usize],
) -> Result<(Vec<(String, &'static str, f64)>, DMatrix<f64>), AnalysisError> {
    let Placed { model, system, .. } = placed;
    let size = placed.units.iter().copied().find(|unit| *unit != 1.0).unwrap_or(1.0);
    let mut names = Vec::new();
    let mut functions = Vec::new();
    for (idx, joint) in model.joints.iter().enumerate() {
        let motions = joint.kind.motions();
        let positions = system.kinematics.joint_positions(model, JointId(idx));
        for (k, position) in positions.into_iter().enumerate() {
            let is_turn = motions.get(k) == Some(&bksim_model::MotionKind::Rotation);
            let (unit, size) = if is_turn { ("rad", 1.0) } else { ("m", size) };
            names.push((format!("{}.{}", joint.name, motion_words(motions, k)[0]), unit, size));
            functions.push(position);
        }
    }
    for &body in bodies {
        for coordinate in system.coordinates() {
            let is_own = matches!(coordinate.owner, bksim_mbs::coordinate::Owner::Body(of, _) | bksim_mbs::coordinate::Owner::Quaternion(of, _) if of.0 == body);
            if is_own {
                let is_length = coordinate.kind == bksim_mbs::coordinate::CoordinateKind::Length;
                let size = if is_length { size } else { 1.0 };
                names.push((coordinate.name.clone(), coordinate.kind.unit(), size));
                functions.push(model.pool.symbol_expr(coordinate.q));
            }
        }
    }
    let mut slopes = gradients(placed, &functions)?;
    for (row, (.., size)) in names.iter().enumerate() {
        slopes.row_mut(row).scale_mut(1.0 / size);
    }
    Ok((names, slopes))
}

/// Slopes of functions in the pose, by coordinates in units of the mechanism.
fn gradients(
    placed: &Placed,
    functions: &[bksim_expr::Expr],
) -> Result<DMatrix<f64>, AnalysisError> {
    let model = &placed.model;
    let q: Vec<SymbolId> = placed.system.coordinates().iter().map(|c| c.q).collect();
    let jacobian = model.pool.jacobian(functions, &q);
    let entries: Vec<_> = jacobian.entries.iter().map(|entry| entry.2).collect();
    let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let tape = Tape::compile(&model.pool, &entries, &[&[model.time][..], &q].concat(), &symbols)?;
    let mut values = vec![0.0; entries.len()];
    let inputs = [&[model.solve.t_start], placed.q.as_slice()].concat();
    let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    tape.evaluate(&mut tape.workspace(&parameters), &inputs, &mut values);
    let mut matrix = DMatrix::zeros(functions.len(), q.len());
    for (&(row, column, _), value) in jacobian.entries.iter().zip(values) {
        // Angles at a pole have no slope.
        matrix[(row, column)] = if value.is_finite() { value * placed.units[column] } else { 0.0 };
    }
    Ok(matrix)
}

/// Combinations of the columns of `rates` that leave as many rows as possible at rest: as many independent ones
/// as there are columns.
fn sparse_combinations(rates: &DMatrix<f64>) -> Vec<DVector<f64>> {
    /// Most choices of resting rows that are tried.
    const MOST: usize = 20_000;
    let n = rates.ncols();
    if n <= 1 {
        return (0..n).map(|_| DVector::from_element(1, 1.0)).collect();
    }
    let largest = rates.amax();
    let moving: Vec<usize> =
        (0..rates.nrows()).filter(|&row| rates.row(row).norm() > NO_RATE * largest).collect();
    let mut candidates: Vec<(usize, DVector<f64>)> = Vec::new();
    let mut chosen: Vec<usize> = (0..n - 1).collect();
    for _ in 0..MOST {
        if chosen.last().is_none_or(|&last| last >= moving.len()) {
            break;
        }
        // The combination in which the chosen rows rest, if there is only one.
        let rows = DMatrix::from_fn(n - 1, n, |i, k| rates[(moving[chosen[i]], k)]);
        let left = null_space(&rows);
        if left.ncols() == 1 {
            let weights = left.column(0).clone_owned();
            let shown = rates * &weights;
            let most = shown.amax();
            let n_moving = shown.iter().filter(|rate| rate.abs() > NO_RATE * most).count();
            candidates.push((n_moving, weights));
        }
        // The next choice.
        let mut i = n - 1;
        while i > 0 && chosen[i - 1] + (n - i) >= moving.len() {
            i -= 1;
        }
        if i == 0 {
            break;
        }
        chosen[i - 1] += 1;
        for k in i..n - 1 {
            chosen[k] = chosen[k - 1] + 1;
        }
    }
    candidates.sort_by_key(|(n_moving, _)| *n_moving);
    let whole = (0..n).map(|k| DVector::from_fn(n, |i, _| f64::from(u8::from(i == k))));
    let mut found: Vec<DVector<f64>> = Vec::new();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for weights in candidates.into_iter().map(|(_, weights)| weights).chain(whole) {
        let mut rest = weights.normalize();
        for known in &basis {
            let along = known.dot(&rest);
            rest -= known * along;
        }
        if found.len() < n && rest.norm() > 1e-6 {
            basis.push(rest.normalize());
            found.push(weights);
        }
    }
    found
}

fn moving_bodies(placed: &Placed, along: &DVector<f64>) -> Result<Vec<String>, AnalysisError> {
    let Placed { model, system, .. } = placed;
    let pool = &model.pool;
    let mut functions = Vec::new();
    for (idx, pose) in system.kinematics.poses.iter().enumerate() {
        functions.extend(system.kinematics.position(model, BodyId(idx), None));
        for axis in 0..3 {
            let mut unit = [pool.zero(); 3];
            unit[axis] = pool.one();
            functions.extend(pose.rotation.apply(pool, &unit));
        }
    }
    let rates = gradients(placed, &functions)? * along;
    let largest = rates.amax();
    let moves = |idx: &usize| rates.rows(12 * idx, 12).amax() > NO_RATE * largest;
    let moving = (1..model.bodies.len()).filter(moves);
    Ok(moving.map(|idx| model.bodies[idx].name.clone()).collect())
}

/// True where the mechanism, moved a little, closes again next to the pose.
fn is_finite(placed: &Placed, along: &DVector<f64>) -> bool {
    const ASIDE: f64 = 1e-3;
    let length = along.norm();
    let direction = along / length;
    let moved = placed.q.iter().zip(direction.iter().zip(&placed.units));
    let moved: Vec<f64> = moved.map(|(q, (d, unit))| q + ASIDE * d * unit).collect();
    let Some(closed) = placed.closed(moved) else { return false };
    let gone = closed.iter().zip(&placed.q).zip(&placed.units);
    let gone = DVector::from_iterator(placed.q.len(), gone.map(|((a, b), unit)| (a - b) / unit));
    gone.dot(&direction) > 0.5 * ASIDE
}
