//! The ways in which the start of a mechanism closes.

use std::f64::consts::PI;

use bksim_model::{JointId, Measure, Model, MotionKind, Space};
use bksim_sim::Svd;
use bksim_sim::mobility::loop_through;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::assur::{Apart, Proof};
use crate::curve::independent_rows;
use crate::error::AnalysisError;
use crate::platform::Reached;
use crate::positions::Positions;
use crate::rows::{Clock, RANK_TOLERANCE, Rows, wrapped};

/// A way in which the start closes.
#[derive(Clone, PartialEq, Debug)]
pub struct Assembly {
    /// From one; the start's own is the first.
    pub number: usize,
    /// A name that says what differs: `A-B-C-D open`.
    pub name: String,
    /// Everything that a pose shows: name, value, unit.
    pub pose: Vec<(String, f64, &'static str)>,
    /// Generalised coordinates.
    pub q: Vec<f64>,
}

/// All ways that were found.
#[derive(Clone, PartialEq, Debug)]
pub struct Assemblies {
    /// The start's own first.
    pub assemblies: Vec<Assembly>,
    /// Measures that are held at their values in the start: those that the model states, and as many more as
    /// leave nothing free.
    pub held: Vec<(String, f64, &'static str)>,
    /// Why there are no others, where that is proved.
    pub proof: Option<Proof>,
    /// The number of the one that the model holds, if it holds one.
    pub held_number: Option<usize>,
    /// Poses that were found in which the mechanism can move although all is held: samples of ways without number, which
    /// are left out.
    pub n_moving: usize,
}

/// Finds the assemblies of `model` at the values that its start states.
///
/// # Errors
/// [`AnalysisError::Rejected`] when the start does not close.
pub fn assemblies(model: Model) -> Result<Assemblies, AnalysisError> {
    let (model, held_number) = without_held_pose(model);
    let positions = Positions::of(model)?;
    Ok(Assemblies { held_number, ..assemblies_of(&positions)? })
}

/// The model as it was written, without the pose of the assembly that it holds.
pub(crate) fn without_held_pose(mut model: Model) -> (Model, Option<usize>) {
    let Some(found) = model.assembly.take().and_then(|chosen| chosen.found) else {
        return (model, None);
    };
    model.initial = found.written;
    (model, Some(found.number))
}

/// Assemblies of a start that has closed; see [`assemblies`].
pub(crate) fn assemblies_of(positions: &Positions) -> Result<Assemblies, AnalysisError> {
    let (measures, held) = held(positions)?;
    let mut rows = positions.rows(&measures, &[], Clock::Held)?;
    let u: Vec<f64> = held.iter().map(|(_, value, _)| *value).collect();
    let start = rows.scaled(&positions.q);
    let mut found = vec![start.clone()];
    let proof = match Apart::of(positions, &measures)? {
        Some(mut apart) => proved(positions, &mut apart, (&mut rows, &u), &mut found),
        None => match Reached::of(positions, &measures, &u)? {
            Some(reached) => of_platform(positions, reached, (&mut rows, &u), &mut found)?,
            None => None,
        },
    };
    let mut n_moving = 0;
    if proof.is_none() {
        found.truncate(1);
    }
    // Ways that paths found are not lost where there may be more.
    let proof = proof.filter(Proof::is_complete);
    if proof.is_none() {
        n_moving = search(positions, &mut rows, &u, &start, &mut found)?;
    }

    // Names, and the pose of each.
    let shapes: Vec<LoopPolygons> = found
        .iter()
        .map(|x| LoopPolygons::of(positions, &rows.unscaled(x)))
        .collect::<Result<_, _>>()?;
    let mut names = names(positions, &shapes);
    let mut scalars = positions.scalars(positions.quantities())?;
    let mut pose = |q: &Vec<f64>| -> Vec<(String, f64, &'static str)> {
        let values = scalars.values(positions.t(), q);
        let shown = positions.quantities().iter().zip(values);
        shown.map(|(quantity, value)| (quantity.names[0].clone(), value, quantity.unit)).collect()
    };
    let all: Vec<Vec<f64>> = found.iter().map(|x| rows.unscaled(x)).collect();
    let poses: Vec<_> = all.iter().map(&mut pose).collect();
    tell_apart(&mut names, &poses);
    let all = all.into_iter().zip(poses).zip(names).enumerate();
    let assembly = |(k, ((q, pose), name))| Assembly { number: k + 1, name, pose, q };
    let assemblies = all.map(assembly).collect();
    Ok(Assemblies { assemblies, held, proof, held_number: None, n_moving })
}

/// Adds to `found` all assemblies of a linkage that comes apart into Assur groups; none where the start is not among them, or
/// one does not close.
fn proved(
    positions: &Positions,
    apart: &mut Apart,
    (rows, u): (&mut Rows, &[f64]),
    found: &mut Vec<Vec<f64>>,
) -> Option<Proof> {
    let (ways, proof) = apart.assemblies(positions.model())?;
    for places in &ways {
        let mut is_here = |x: &Vec<f64>| apart.is_at(&rows.unscaled(x), places);
        if found.iter().any(&mut is_here) {
            continue;
        }
        let guess = rows.scaled(&apart.coordinates(positions, places));
        let x = closed(rows, positions.t(), guess, u)?;
        if !apart.is_at(&rows.unscaled(&x), places) {
            return None;
        }
        found.push(tidied(rows, &x));
    }
    // Each once, the start among them.
    (found.len() == ways.len()).then_some(proof)
}

/// Adds to `found` all poses of a platform; none where the start is not among them, or one is not reached.
fn of_platform(
    positions: &Positions,
    mut reached: Reached,
    (rows, u): (&mut Rows, &[f64]),
    found: &mut Vec<Vec<f64>>,
) -> Result<Option<Proof>, AnalysisError> {
    let start = rows.scaled(&positions.q);
    let Reached { reach, real, platform } = &mut reached;
    let mut add = |there, rows: &mut Rows, found: &mut Vec<Vec<f64>>| {
        if found.iter().any(|x| reach.is_at(&rows.unscaled(x), there)) {
            return Some(());
        }
        let guess = reach.coordinates(&start, there)?;
        let x = closed(rows, positions.t(), guess, u)?;
        reach.is_at(&rows.unscaled(&x), there).then(|| found.push(tidied(rows, &x)))
    };
    let mut all = |rows: &mut Rows, found: &mut Vec<Vec<f64>>| {
        let is_whole = real.iter().all(|there| add(there, rows, found).is_some());
        is_whole && found.len() == real.len()
    };
    // Where no way leads to one, many guesses may.
    if platform.is_complete() && !all(rows, found) {
        found.truncate(1);
        search(positions, rows, u, &start, found)?;
    }
    let is_whole = platform.is_complete() && all(rows, found);
    let n = real.len();
    Ok(is_whole.then(|| Proof::of_platform(reached.platform, n)))
}

/// Coordinates with angles within half a turn.
fn tidied(rows: &Rows, x: &[f64]) -> Vec<f64> {
    let all = x.iter().zip(&rows.is_turn);
    all.map(|(x, &is_turn)| if is_turn { wrapped(*x) } else { *x }).collect()
}

/// Positions on all rows from many guesses, in units of the mechanism: samples of every branch, of as many
/// free motions as there are.
pub(crate) fn closed_poses(positions: &Positions, rows: &mut Rows) -> Vec<Vec<f64>> {
    const N_GUESSES: usize = 120;
    let mut random = Pcg64::seed_from_u64(2);
    let start = rows.scaled(&positions.q);
    let guesses = (0..N_GUESSES).map(|_| guess(rows, &start, &mut random));
    let guesses: Vec<Vec<f64>> = guesses.collect();
    guesses.into_iter().filter_map(|x| closed(rows, positions.t(), x, &[])).collect()
}

/// Measures to hold: those stated, then joints with the ground first, as long as they leave less free.
#[expect(clippy::type_complexity, reason = "measures, and the same with names and values")]
pub(crate) fn held(
    positions: &Positions,
) -> Result<(Vec<Measure>, Vec<(String, f64, &'static str)>), AnalysisError> {
    let model = positions.model();
    let stated = model.initial.iter().filter(|i| !i.is_guess && !i.measure.is_velocity());
    let mut candidates: Vec<(String, Measure)> =
        stated.map(|initial| (initial.name.clone(), initial.measure)).collect();
    let is_on_ground = |joint: &&(usize, &bksim_model::Joint)| {
        joint.1.predecessor.body == bksim_model::GROUND
            || joint.1.successor.body == bksim_model::GROUND
    };
    let joints: Vec<(usize, &bksim_model::Joint)> = model.joints.iter().enumerate().collect();
    let (first, rest): (Vec<_>, Vec<_>) = joints.iter().partition(|joint| is_on_ground(joint));
    for (idx, joint) in first.into_iter().chain(rest) {
        for (motion_idx, motion) in joint.kind.motions().iter().enumerate() {
            let word = if *motion == MotionKind::Rotation { "angle" } else { "position" };
            let measure = Measure::JointPosition(JointId(idx), motion_idx);
            candidates.push((format!("{}.{word}", joint.name), measure));
        }
    }
    let mut rows = positions.rows(&[], &[], Clock::Held)?;
    let x = rows.scaled(&positions.q);
    let mut matrix = rows.at(positions.t(), &x, &[]).jacobian;
    let mut rank = independent_rows(&matrix).len();
    let (mut measures, mut held) = (Vec::new(), Vec::new());
    for (name, measure) in candidates {
        if rank == x.len() {
            break;
        }
        let quantity = positions.quantity_of(&name, measure);
        let mut scalars = positions.scalars(std::slice::from_ref(&quantity))?;
        let slopes = scalars.gradients(positions.t(), &positions.q);
        let value = scalars.values(positions.t(), &positions.q)[0];
        let unit = if quantity.is_angle() { 1.0 } else { positions.size };
        let row = DMatrix::from_fn(1, x.len(), |_, i| slopes[0][i] * rows.unit_of_column[i] / unit);
        let mut more = DMatrix::zeros(matrix.nrows() + 1, x.len());
        more.rows_mut(0, matrix.nrows()).copy_from(&matrix);
        more.rows_mut(matrix.nrows(), 1).copy_from(&row);
        let with = independent_rows(&more).len();
        if with > rank {
            (matrix, rank) = (more, with);
            measures.push(measure);
            held.push((name, value, quantity.unit));
        }
    }
    Ok((measures, held))
}

/// Adds to `found` what many guesses lead to, but for poses in which something can still move: their number.
fn search(
    positions: &Positions,
    rows: &mut Rows,
    u: &[f64],
    start: &[f64],
    found: &mut Vec<Vec<f64>>,
) -> Result<usize, AnalysisError> {
    const N_GUESSES: usize = 600;
    /// Guesses without anything new after which a search ends.
    const PATIENCE: usize = 200;
    let mut random = Pcg64::seed_from_u64(1);
    let mut aligned = Aligned::of(positions)?;
    let (mut last_new, mut n_moving) = (0, 0);
    for k in 0..N_GUESSES {
        if k > last_new + PATIENCE {
            break;
        }
        let x = guess(rows, start, &mut random);
        let Some(x) = closed(rows, positions.t(), x, u) else { continue };
        let is_same = |other: &Vec<f64>| rows.is_same(&x, other, 1e-6);
        if aligned.holds(positions.t(), &rows.unscaled(&x)) && !found.iter().any(is_same) {
            if can_move(rows, positions.t(), &x, u) {
                n_moving += 1;
                continue;
            }
            last_new = k;
            found.push(tidied(rows, &x));
        }
    }
    Ok(n_moving)
}

/// True of a pose from which there is a way on although all is held: not of one that is singular by itself.
fn can_move(rows: &mut Rows, t: f64, x: &[f64], u: &[f64]) -> bool {
    /// Part of a radian or of the longest link.
    const AWAY: f64 = 1e-3;
    let jacobian = rows.at(t, x, u).jacobian;
    let Some(svd) = Svd::new(&jacobian) else { return false };
    let is_free = |&k: &usize| svd.singular_values[k] <= RANK_TOLERANCE * svd.largest();
    (0..svd.singular_values.len()).filter(is_free).any(|k| {
        let aside = (0..x.len()).map(|i| x[i] + AWAY * svd.v_t[(k, i)]).collect();
        let there = closed(rows, t, aside, u);
        there.is_some_and(|there| {
            let off = there.iter().zip(x).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            off > 0.5 * AWAY && off < 2.0 * AWAY
        })
    })
}

fn guess(rows: &Rows, start: &[f64], random: &mut Pcg64) -> Vec<f64> {
    let mut aside = |is_turn: bool| {
        let share: f64 = random.random_range(-1.0..1.0);
        share * if is_turn { PI } else { 2.0 }
    };
    start.iter().zip(&rows.is_turn).map(|(x, &is_turn)| x + aside(is_turn)).collect()
}

/// Newton's iteration with bounded steps onto all rows; the nearest solution of each where some motions
/// are free.
pub(crate) fn closed(rows: &mut Rows, t: f64, mut x: Vec<f64>, u: &[f64]) -> Option<Vec<f64>> {
    const MOST: usize = 60;
    const LONGEST: f64 = 0.7;
    for _ in 0..MOST {
        let at = rows.at(t, &x, u);
        if at.value.amax() < 1e-13 {
            return Some(x);
        }
        let tolerance = RANK_TOLERANCE * at.jacobian.norm();
        let regular =
            at.jacobian.is_square().then(|| at.jacobian.clone().lu().solve(&at.value)).flatten();
        let step: DVector<f64> = match regular {
            Some(step) if step.iter().all(|x| x.is_finite()) => step,
            _ => Svd::new(&at.jacobian)?.solve(&at.value, tolerance),
        };
        let size = step.norm();
        if !size.is_finite() {
            return None;
        }
        let share = if size > LONGEST { LONGEST / size } else { 1.0 };
        x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x -= share * step);
        if size < 1e-13 {
            break;
        }
    }
    (rows.at(t, &x, u).value.amax() < 1e-11).then_some(x)
}

/// Whether the axes of cut joints point the same way.
struct Aligned(crate::scalar::Scalars);

impl Aligned {
    fn of(positions: &Positions) -> Result<Self, AnalysisError> {
        let (model, system) = (positions.model(), positions.system());
        let cosines = system.tree.cuts.iter().flat_map(|id| {
            let joint = &model.joints[id.0];
            let sides = system.kinematics.sides(model, joint);
            bksim_mbs::joint::alignments(&model.pool, joint, &sides)
        });
        let cosines: Vec<_> =
            if model.space == Space::Planar { Vec::new() } else { cosines.collect() };
        let parameters = &positions.mechanism.parameters;
        Ok(Self(crate::scalar::Scalars::compile(model, system, &cosines, parameters)?))
    }

    fn holds(&mut self, t: f64, q: &[f64]) -> bool {
        self.0.values(t, q).iter().all(|cosine| *cosine > 0.0)
    }
}

/// The loops of an assembly as polygons of their joints.
struct LoopPolygons {
    /// Of each loop the joints and their places.
    loops: Vec<Vec<(JointId, [f64; 2])>>,
}

impl LoopPolygons {
    fn of(positions: &Positions, q: &[f64]) -> Result<Self, AnalysisError> {
        let (model, system) = (positions.model(), positions.system());
        if model.space != Space::Planar {
            return Ok(Self { loops: Vec::new() });
        }
        let places: Vec<_> = (model.joints.iter())
            .flat_map(|joint| system.kinematics.anchor(model, joint.successor).into_iter().take(2))
            .collect();
        let parameters = &positions.mechanism.parameters;
        let mut scalars = crate::scalar::Scalars::compile(model, system, &places, parameters)?;
        let values = scalars.values(positions.t(), q);
        let place = |joint: JointId| (joint, [values[2 * joint.0], values[2 * joint.0 + 1]]);
        let around = |&cut: &JointId| {
            let mut corners: Vec<(JointId, [f64; 2])> = Vec::new();
            for joint in loop_through(model, cut) {
                let next = place(joint);
                let is_new = |(_, p): &(JointId, [f64; 2])| {
                    (p[0] - next.1[0]).hypot(p[1] - next.1[1]) > 1e-9 * positions.size
                };
                if corners.iter().all(is_new) {
                    corners.push(next);
                }
            }
            // From the first joint of the file on.
            let first = (0..corners.len()).min_by_key(|&k| corners[k].0.0).unwrap_or(0);
            corners.rotate_left(first);
            if corners.len() > 2 && corners[1].0.0 > corners[corners.len() - 1].0.0 {
                corners[1..].reverse();
            }
            corners
        };
        Ok(Self { loops: system.tree.cuts.iter().map(around).collect() })
    }

    /// True if no two sides of a loop cross.
    fn is_open(&self, k: usize) -> bool {
        let corners: Vec<[f64; 2]> = self.loops[k].iter().map(|(_, p)| *p).collect();
        let n = corners.len();
        let side = |i: usize| (corners[i], corners[(i + 1) % n]);
        let pairs = (0..n).flat_map(|i| (i + 2..n).map(move |j| (i, j)));
        pairs.filter(|&(i, j)| (j + 1) % n != i).all(|(i, j)| !cross(side(i), side(j)))
    }

    /// True if a corner lies to the left of the line between its neighbours.
    fn is_left(&self, k: usize, corner: usize) -> bool {
        let corners = &self.loops[k];
        let n = corners.len();
        let [a, b, c] = [(corner + n - 1) % n, corner, (corner + 1) % n].map(|i| corners[i].1);
        turn(a, c, b) > 0.0
    }
}

/// Twice the area of a triangle, positive to the left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn cross((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> bool {
    turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
}

/// Names of assemblies: each loop open or crossed, then, where that does not tell them apart, on which side
/// joints lie.
fn names(positions: &Positions, shapes: &[LoopPolygons]) -> Vec<String> {
    let model = positions.model();
    let joint = |id: JointId| model.joints[id.0].name.as_str();
    let basic = |shape: &LoopPolygons| {
        let word = |k: usize| {
            let corners: Vec<&str> = shape.loops[k].iter().map(|(id, _)| joint(*id)).collect();
            let word = if shape.is_open(k) { "open" } else { "crossed" };
            format!("{} {word}", corners.join("-"))
        };
        (0..shape.loops.len()).map(word).collect::<Vec<_>>().join(", ")
    };
    let basics: Vec<String> = shapes.iter().map(basic).collect();
    let full = |(i, shape): (usize, &LoopPolygons)| {
        let twins: Vec<&LoopPolygons> =
            (0..shapes.len()).filter(|&j| basics[j] == basics[i]).map(|j| &shapes[j]).collect();
        let mut name = basics[i].clone();
        if twins.len() == 1 {
            return name;
        }
        for k in 0..shape.loops.len() {
            let corners = &shape.loops[k];
            let n = corners.len();
            let differs = |&c: &usize| {
                twins.iter().any(|twin| {
                    twin.loops[k].len() == n && twin.is_left(k, c) != shape.is_left(k, c)
                })
            };
            if let Some(c) = (0..n).find(differs) {
                let [before, here, after] =
                    [(c + n - 1) % n, c, (c + 1) % n].map(|i| joint(corners[i].0));
                let side = if shape.is_left(k, c) { "left" } else { "right" };
                let place = format!(", {here} {side} of {before}-{after}");
                name.push_str(&place);
            }
        }
        name
    };
    shapes.iter().enumerate().map(full).collect()
}

/// Tells assemblies of one name apart by the first joint in which all of them differ: by its place along a guide, or else by
/// the order of its angles.
fn tell_apart(names: &mut [String], poses: &[Vec<(String, f64, &'static str)>]) {
    const DIFFERENT: f64 = 1e-6;
    for i in 0..names.len() {
        let twins: Vec<usize> = (i..names.len()).filter(|&j| names[j] == names[i]).collect();
        if twins.len() < 2 {
            continue;
        }
        let n_quantities = poses[i].len();
        let values = |k: usize| -> Vec<f64> { twins.iter().map(|&j| poses[j][k].1).collect() };
        let tells = |&k: &usize| {
            let mut sorted = values(k);
            sorted.sort_by(f64::total_cmp);
            sorted.windows(2).all(|pair| pair[1] - pair[0] > DIFFERENT)
        };
        let is_guide = |&k: &usize| poses[i][k].0.ends_with(".position");
        let all = || (0..n_quantities).filter(tells);
        let Some(k) = all().find(is_guide).or_else(|| all().next()) else { continue };
        let of = values(k);
        let (what, unit) = (poses[i][k].0.clone(), poses[i][k].2);
        let what = what.rsplit_once('.').map_or(what.as_str(), |(joint, _)| joint);
        for (twin, value) in twins.iter().zip(&of) {
            let place = 1 + of.iter().filter(|other| *other < value).count();
            let words = match (unit, of.len(), place) {
                ("m", 2, 1) => format!("{what} behind"),
                ("m", 2, _) => format!("{what} ahead"),
                (_, n, place) => format!("{what} {place} of {n}"),
            };
            let name = &mut names[*twin];
            let comma = if name.is_empty() { "" } else { ", " };
            *name = format!("{name}{comma}{words}");
        }
    }
}
