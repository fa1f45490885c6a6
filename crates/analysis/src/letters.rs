//! [`Letters`]: A, B, C and D about a pose at rest in letters, with a certificate.
//!
//! ```text
//! G Z = 0, Z = 1 on the independent coordinates        by exact elimination
//! Zᵀ M Z w = −Zᵀ (K Z y + C Z ẏ) + Zᵀ B u              K with ∂(Gᵀ λ)/∂q; λ are letters, too
//! Gᵀ δλ = B u − K Z y − C Z ẏ − M Z w                  by the rows of the dependent coordinates
//! δz = z_q Z y + z_v Z ẏ + z_a Z w + z_λ δλ + z_u u    outputs
//! ```
//!
//! The certificate compares every entry with numbers that come another way, by singular values of G and compiled derivatives,
//! at random coordinates, multipliers and parameters. As entries are analytic functions, agreement there is
//! agreement everywhere but for an event of probability zero and rounding.

mod blocks;
mod certificate;
mod equations;

use bksim_expr::Expr;
use bksim_model::Model;

use crate::about::About;
use crate::balance::Balance;
use crate::channels::{Channels, Input};
use crate::curve::independent_rows;
use crate::equilibrium::Equilibrium;
use crate::error::AnalysisError;
use crate::forces::Forces;
use crate::linear::{inputs_of, kept_states};
use crate::linear_outputs::Outputs;
use crate::loaded::{Loaded, without_rates};
use crate::table::Column;
use certificate::{Certificate, N_POINTS};
use equations::{Equations, Symbolic, column};

/// Linear equations in letters: ẋ = A x + B u, z = C x + D u.
#[derive(Clone, PartialEq, Debug)]
pub struct Letters {
    /// Names and units of the states.
    pub states: Vec<Column>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names and units of the outputs.
    pub outputs: Vec<Column>,
    /// Names for parts that are long, with their definitions, each by names before it.
    pub blocks: Vec<(String, String)>,
    /// n × n, row by row.
    pub a: Vec<Vec<String>>,
    /// n × inputs, row by row.
    pub b: Vec<Vec<String>>,
    /// outputs × n, row by row.
    pub c: Vec<Vec<String>>,
    /// outputs × inputs, row by row.
    pub d: Vec<Vec<String>>,
    /// Letters of the pose, coordinates, states and multipliers, with their values there, SI.
    pub pose: Vec<(String, f64)>,
    /// Random points at which the entries were compared with numbers.
    pub n_points: usize,
    /// Largest difference there, over the largest entry of its matrix.
    pub largest_difference: f64,
}

/// Most free motions, and most coordinates that depend on them, of equations in letters.
const LARGEST: usize = 4;
/// Letters of the columns by y, by ẏ and by the inputs: those of stiffness, of damping and of the inputs.
const LETTERS: [&str; 3] = ["K", "C", "B"];

/// The matrices of `model` about the equilibrium nearest to the start; `None` of a mechanism that is too large for letters.
///
/// # Errors
/// [`AnalysisError`] as [`crate::linearize`].
pub fn letters(model: Model, channels: &Channels) -> Result<Option<Letters>, AnalysisError> {
    let channels = channels.or_stated(&model);
    without_rates(&model)?;
    let loaded = Loaded::at_rest(model)?;
    // However many of the rows follow from others.
    if loaded.system().coordinates().len() > 2 * LARGEST + loaded.state_coordinates().len() {
        return Ok(None);
    }
    let (free, inputs) = inputs_of(&loaded, &channels.inputs)?;
    let mut balance = Balance::of(&loaded, &[], &[])?;
    let (found, _) = balance.chosen(About::Static)?;
    let Equilibrium { q, .. } = found.on_one_branch()?;
    let none = vec![0.0; balance.forces.nc()];
    let jacobian = balance.at(&q, &none).jacobian;
    let reduced = balance.reduced(&q, &jacobian)?;

    // Rows that do not follow from others, and the coordinates that the free motions are by.
    let (model, system) = (loaded.model(), loaded.system());
    let rows: Vec<usize> =
        independent_rows(&jacobian).into_iter().map(|k| loaded.kept[k]).collect();
    let coordinates = system.coordinates();
    let place = |name: &String| coordinates.iter().position(|c| c.name == *name);
    let by: Vec<usize> = reduced.names.iter().filter_map(place).collect();
    if by.len() > LARGEST + loaded.state_coordinates().len() || rows.len() > LARGEST {
        return Ok(None);
    }
    let mut symbolic = Equations::of(&loaded, (&rows, &by), balance.steady());
    let Some(z) = symbolic.free_motions() else { return Ok(None) };
    // Columns by y, by ẏ and by the inputs.
    let forces = symbolic.forces(&z, &loaded, &inputs, &free);
    let columns = LETTERS.into_iter().zip(&forces);
    let accelerations: Option<Vec<Symbolic>> =
        columns.map(|columns| symbolic.accelerations(&z, columns)).collect();
    let Some(accelerations) = accelerations else { return Ok(None) };
    let outputs = Outputs::of(&loaded, &channels, &inputs, &free)?;
    let columns = Columns { z: &z, forces: &forces, accelerations: &accelerations };
    let Some([by_y, by_rate, by_input]) = columns.outputs(&symbolic, &outputs, &inputs) else {
        return Ok(None);
    };

    // x = (y, ẏ, z) in letters.
    let pool = &model.pool;
    let n = by.len();
    let (kept, states) = kept_states(&loaded, &reduced, &reduced);
    let rate = |i: usize, j: usize| if i == j { pool.one() } else { pool.zero() };
    let [stiffness, damping, efforts] = [0, 1, 2].map(|k| &accelerations[k]);
    let entry_a = |i: usize, j: usize| match (i < n, j < n) {
        (true, true) => pool.zero(),
        (true, false) => rate(i, j - n),
        (false, true) => stiffness[j][i - n],
        (false, false) => damping[j - n][i - n],
    };
    let entry_b = |i: usize, k: usize| if i < n { pool.zero() } else { efforts[k][i - n] };
    let entry_c = |i: usize, j: usize| if j < n { by_y[j][i] } else { by_rate[j - n][i] };
    let of_inputs = 0..inputs.len();
    let a = kept.iter().map(|&i| kept.iter().map(|&j| entry_a(i, j)).collect()).collect();
    let b = kept.iter().map(|&i| of_inputs.clone().map(|k| entry_b(i, k)).collect()).collect();
    let of_outputs = 0..outputs.columns.len();
    let c = of_outputs.clone().map(|i| kept.iter().map(|&j| entry_c(i, j)).collect()).collect();
    let d = of_outputs.map(|i| of_inputs.clone().map(|k| by_input[k][i]).collect()).collect();
    let matrices: [Symbolic; 4] = [a, b, c, d];
    let written_out = |rows: &Symbolic| -> Symbolic {
        rows.iter().map(|row| symbolic.blocks.written_out(row)).collect()
    };
    let compared = matrices.each_ref().map(written_out);
    let [a, b, c, d] = &matrices;

    let mut forces = Forces::compile(model, system, &rows, &free, &loaded.parameters)?;
    let rest = balance.velocities(&q);
    let p: Vec<f64> = free.iter().map(|id| loaded.parameters[id.0]).collect();
    let lambda = forces.balancing(loaded.t, [&q, &rest], &p).unwrap_or_default();
    let slopes = outputs.slopes(&loaded)?;
    let certificate =
        Certificate { loaded: &loaded, rows: &rows, by: &by, kept: &kept, outputs: &slopes };
    let largest_difference =
        certificate.largest(compared.each_ref(), (&mut forces, &inputs), (&q, &free))?;
    let text = |rows: &Symbolic| {
        rows.iter().map(|row| row.iter().map(|&e| pool.to_text(e)).collect()).collect()
    };
    let entries: Vec<Expr> = matrices.iter().flatten().flatten().copied().collect();
    let blocks = symbolic.blocks.needed(&entries).into_iter();
    let compared: Vec<Expr> = compared.iter().flatten().flatten().copied().collect();
    Ok(Some(Letters {
        states,
        inputs: channels.inputs.clone(),
        outputs: outputs.columns.clone(),
        blocks: blocks.map(|(name, e)| (name, pool.to_text(e))).collect(),
        a: text(a),
        b: text(b),
        c: text(c),
        d: text(d),
        pose: symbolic.pose(&compared, (&q, &rest, &lambda)),
        n_points: N_POINTS,
        largest_difference,
    }))
}

/// Columns of Z, of ∂r and of ÿ, by y, by ẏ and by the inputs.
struct Columns<'a> {
    z: &'a Symbolic,
    forces: &'a [Symbolic; 3],
    accelerations: &'a [Symbolic],
}

impl Columns<'_> {
    /// The changes of the outputs, a column for each of y, of ẏ and of the inputs.
    fn outputs(
        &self,
        equations: &Equations<'_>,
        outputs: &Outputs<'_>,
        inputs: &[Input],
    ) -> Option<[Symbolic; 3]> {
        let Self { z, forces, accelerations } = self;
        let expressions = &outputs.expressions;
        let pool = equations.pool();
        let follows = outputs.follows_forces(equations.system);
        let mut all = [Vec::new(), Vec::new(), Vec::new()];
        for (k, found) in all.iter_mut().enumerate() {
            // Positions and rates follow neither accelerations nor multipliers.
            let lambda = if follows {
                equations.multipliers(z, (LETTERS[k], &forces[k]), &accelerations[k])?
            } else {
                vec![vec![pool.zero(); equations.rows.len()]; forces[k].len()]
            };
            for (j, (own, lambda)) in accelerations[k].iter().zip(&lambda).enumerate() {
                let a = equations.times(z, own);
                let moved = (k < 2).then(|| column(z, j));
                let q = moved.as_deref().filter(|_| k == 0);
                let v = moved.as_deref().filter(|_| k == 1);
                let mut changes = equations.outputs(expressions, [q, v, Some(&a)], lambda);
                if let Some(Input::Parameter(idx)) = inputs.get(j).filter(|_| k == 2) {
                    for (change, &e) in changes.iter_mut().zip(expressions) {
                        let slope = pool.diff(e, outputs.symbol(equations.model, *idx));
                        *change = pool.add(*change, equations.at_rest(slope));
                    }
                }
                found.push(equations.folded(&changes));
            }
        }
        Some(all)
    }
}
