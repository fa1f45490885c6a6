//! Linear equations about a state: A, B, C, D, and the modes of an equilibrium.
//!
//! ```text
//! M δa + C δv + K δq + Gᵀ δλ = B u            K with ∂(Gᵀ λ)/∂q
//! G δq = 0,  G δv + Ġ_q δq = 0,  G δa + γ_q δq + γ_v δv = 0
//! ẋ = A x + B u,   z = C x + D u,   x = (y, ẏ): deviations of the independent quantities
//! ```
//!
//! Rows between rates take part in the second and third line alone: x = (y, w) then has more positions y than rates w, and
//! every position more is an eigenvalue of zero.
//!
//! States of controllers are velocities of coordinates that nothing depends on: of those the deviation is left out, so that
//! x = (y, ẏ, z) with the states z.
//!
//! Reactions are functions of a and λ, too, so that as outputs they follow inputs at once: D is theirs.
//!
//! Source: the linearisation of multibody systems in the null space of their constraints, e.g. J. García
//! de Jalón and E. Bayo, *Kinematic and Dynamic Simulation of Multibody Systems* (1994), chapter 8.

use bksim_mbs::constraint::Source;
use bksim_mbs::quantity::{coordinate_units, rate_unit};
use bksim_model::{Model, ParameterId};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::about::About;
use crate::balance::{Balance, named_quantity, pose_of};
use crate::channels::{Channels, Input};
use crate::eigenvalues::eigenvalues;
use crate::equilibrium::Equilibrium;
use crate::error::AnalysisError;
use crate::forces::{At, Forces, ForcesAt, with_definitions};
use crate::linear_outputs::{Changes, Outputs, beside, moved, pole_among};
use crate::loaded::{HeldContacts, Loaded};
use crate::reduced::{Reduced, pseudo_inverse};
use crate::state::State;
use crate::table::{Column, Table};

/// A linear system, SI.
#[derive(Clone, PartialEq, Debug)]
pub struct Linear {
    /// Names and units of the states: quantities, their rates, then states of controllers.
    pub states: Vec<Column>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names and units of the outputs.
    pub outputs: Vec<Column>,
    /// n × n.
    pub a: DMatrix<f64>,
    /// n × inputs.
    pub b: DMatrix<f64>,
    /// outputs × n.
    pub c: DMatrix<f64>,
    /// outputs × inputs.
    pub d: DMatrix<f64>,
    /// Eigenvalues of A: real and imaginary parts.
    pub poles: Vec<[f64; 2]>,
    /// The state that they are about.
    pub state: State,
    /// Pose of the state.
    pub pose: Vec<(String, f64, &'static str)>,
    /// Stops and friction that count as constraints, and friction that is left out.
    pub held: HeldContacts,
}

/// The equations of `model`, linear about a state.
///
/// # Errors
/// [`AnalysisError`] when there is no such state, or a name is unknown.
pub fn linearize(model: Model, about: About, channels: &Channels) -> Result<Linear, AnalysisError> {
    let channels = &channels.or_stated(&model);
    let mut loaded = Loaded::of(model)?;
    match about {
        About::Instant(t) => loaded.run_to(t)?,
        About::Start => (),
        _ => loaded.put_at_rest()?,
    }
    let mut found = equations(&loaded, about, channels)?;
    if let About::Start | About::Instant(_) = about {
        found.state.by_quaternions = channels.states.is_empty() && turns_by_quaternion(&loaded);
        found.state.is_passing = is_passing(loaded, about, channels, &found);
    }
    Ok(found)
}

/// True if a body turns whose orientation is a quaternion: the components of that turn with half its rate.
fn turns_by_quaternion(loaded: &Loaded) -> bool {
    let turnings = &loaded.system().kinematics.turnings;
    let rates = turnings.iter().flat_map(|turning| &loaded.v[turning.first..turning.first + 4]);
    rates.fold(0.0, |a: f64, rate| a.max(rate.abs())) > 0.0
}

/// True if the motion changes the matrix A of a state that it passes: a little later an entry differs.
fn is_passing(mut loaded: Loaded, about: About, channels: &Channels, found: &Linear) -> bool {
    // Part of the fastest period after which A is compared, and change of a row that no tolerance explains.
    const LATER: f64 = 0.01;
    const CHANGED: f64 = 1e-3;
    let poles = found.poles.iter().map(|[re, im]| re.hypot(*im));
    let fastest = poles.chain(loaded.v.iter().map(|rate| rate.abs())).fold(0.0, f64::max);
    let held = loaded.held_contacts();
    if loaded.v.iter().all(|rate| *rate == 0.0)
        || loaded.run_to(loaded.t + LATER / fastest).is_err()
    {
        return false;
    }
    let inputs = Channels { outputs: Vec::new(), ..channels.clone() };
    let Ok(later) = equations(&loaded, about, &inputs) else { return false };
    if later.states != found.states || loaded.held_contacts() != held {
        return true;
    }
    // Rows of rounding alone say nothing.
    let least = 1e-9 * found.a.amax();
    let differs = |row: usize| {
        let off = (later.a.row(row) - found.a.row(row)).amax();
        off > least && off > CHANGED * found.a.row(row).amax()
    };
    (0..found.a.nrows()).any(differs)
}

/// The equations about the state that is loaded, or an equilibrium.
fn equations(loaded: &Loaded, about: About, channels: &Channels) -> Result<Linear, AnalysisError> {
    let model = loaded.model();
    let (free, inputs) = inputs_of(loaded, &channels.inputs)?;

    // The state.
    let balance = Balance::of(loaded, &channels.states, &[])?;
    let ((q, v, a, lambda), state) = state_of(loaded, balance, about)?;
    let mut forces =
        Forces::compile(model, loaded.system(), &loaded.kept, &free, &loaded.parameters)?;
    let p: Vec<f64> = free.iter().map(|id| loaded.mechanism.parameters[id.0]).collect();
    let at = forces.at(At { t: loaded.t, q: &q, v: &v, a: &a, lambda: &lambda, p: &p });
    let positions = Balance::of(loaded, &channels.states, &[])?.reduced(&q, &at.jacobian)?;
    // Rows between rates leave positions free.
    let jacobian = with_rows_of_rates(loaded, &at);
    let reduced = match jacobian.as_ref() {
        Some(jacobian) => Balance::of(loaded, &[], &[])?.reduced(&q, jacobian)?,
        None => positions.clone(),
    };
    let jacobian = jacobian.unwrap_or_else(|| at.jacobian.clone());

    // δq = Z y, δv = Z' w + S y; then δa of each state and input.
    let (n, n_positions, n_free) = (q.len(), positions.n(), reduced.n());
    let back = pseudo_inverse(&jacobian);
    let aside = -(&back * &at.velocity_by_position * &positions.basis);
    let shift = &aside - &reduced.basis * (&reduced.slopes * &aside);
    let by_position = -(&at.stiffness * &positions.basis) - &at.damping * &shift;
    let by_velocity = -(&at.damping * &reduced.basis);
    let mut by_input = DMatrix::zeros(n, inputs.len());
    for (k, input) in inputs.iter().enumerate() {
        let column = match input {
            Input::Parameter(idx) => -at.by_parameter.column(*idx),
            Input::Effort(quantity) => {
                let slopes =
                    loaded.scalars(std::slice::from_ref(quantity))?.gradients(loaded.t, &q);
                DVector::from_column_slice(&slopes[0])
            }
        };
        by_input.column_mut(k).copy_from(&column);
    }
    let kept = [
        -(&at.acceleration_by_position * &positions.basis) - &at.acceleration_by_velocity * &shift,
        -(&at.acceleration_by_velocity * &reduced.basis),
        DMatrix::zeros(forces.nc(), inputs.len()),
    ];
    let right = [by_position, by_velocity, by_input];
    let multipliers = pseudo_inverse(&jacobian.transpose());
    let solved: Vec<_> = right
        .iter()
        .zip(&kept)
        .map(|(forces, rows)| {
            if at.pressing.iter().any(|slope| *slope != 0.0) {
                return pressed_accelerations(&at, &jacobian, forces, rows);
            }
            let found = accelerations(&at, &reduced, &back, forces, rows)?;
            let multipliers = &multipliers * (forces - &at.mass * &found);
            Some((found, multipliers))
        })
        .collect::<Option<_>>()
        .ok_or_else(|| AnalysisError::Undetermined { what: "masses".into(), n: n_free })?;
    let (solved, multipliers): (Vec<DMatrix<f64>>, Vec<DMatrix<f64>>) = solved.into_iter().unzip();

    let size = n_positions + n_free;
    let mut matrix_a = DMatrix::zeros(size, size);
    if n_positions == n_free {
        matrix_a.view_mut((0, n_free), (n_free, n_free)).fill_with_identity();
    } else {
        let rates = [&positions.slopes * &shift, &positions.slopes * &reduced.basis];
        matrix_a.view_mut((0, 0), (n_positions, n_positions)).copy_from(&rates[0]);
        matrix_a.view_mut((0, n_positions), (n_positions, n_free)).copy_from(&rates[1]);
    }
    matrix_a
        .view_mut((n_positions, 0), (n_free, n_positions))
        .copy_from(&(&reduced.slopes * &solved[0]));
    matrix_a
        .view_mut((n_positions, n_positions), (n_free, n_free))
        .copy_from(&(&reduced.slopes * &solved[1]));
    let mut matrix_b = DMatrix::zeros(size, inputs.len());
    matrix_b
        .view_mut((n_positions, 0), (n_free, inputs.len()))
        .copy_from(&(&reduced.slopes * &solved[2]));

    // Changes of the state by y, ẏ and u.
    let nothing = |n_columns: usize| DMatrix::zeros(n, n_columns);
    let changes = Changes {
        q: beside([&positions.basis, &nothing(n_free), &nothing(inputs.len())]),
        v: beside([&shift, &reduced.basis, &nothing(inputs.len())]),
        a: beside([&solved[0], &solved[1], &solved[2]]),
        lambda: beside([&multipliers[0], &multipliers[1], &multipliers[2]]),
    };
    let moving = At { t: loaded.t, q: &q, v: &v, a: &a, lambda: &lambda, p: &p };
    let outputs = Outputs::of(loaded, channels, &inputs, &free)?;
    let numbers = (loaded.parameters.as_slice(), loaded.kept.as_slice());
    let slopes = outputs.slopes(loaded)?;
    let (matrix_c, matrix_d) = slopes.matrices(numbers, moving, &changes, size, &inputs);
    let pole = slopes.pole(numbers, moving, &changes, [&matrix_c, &matrix_d], &inputs);
    let names = outputs.columns.iter().map(|output| output.name.clone());
    let pole = pole.map(|(row, column, value)| (names.clone().nth(row), column, value));
    // Slopes of the accelerations: those of the forces, and of what holds.
    let followed = |at: &ForcesAt| {
        let by_parameter = inputs.iter().map(|input| match input {
            Input::Parameter(idx) => at.by_parameter.column(*idx).into_owned(),
            Input::Effort(_) => DVector::zeros(n),
        });
        let by_state = &at.stiffness * &changes.q + &at.damping * &changes.v;
        let by_state = by_state.columns(0, size).into_owned();
        let by_parameter: Vec<_> = by_parameter.collect();
        let none = DMatrix::zeros(n, 0);
        let inputs = if by_parameter.is_empty() {
            none.clone()
        } else {
            DMatrix::from_columns(&by_parameter)
        };
        beside([&by_state, &inputs, &none])
    };
    let near = |k: usize, share: f64| {
        let [q, v] = [moved(&q, &changes.q, k, share), moved(&v, &changes.v, k, share)];
        let [a, lambda] =
            [moved(&a, &changes.a, k, share), moved(&lambda, &changes.lambda, k, share)];
        followed(&forces.at(At { t: loaded.t, q: &q, v: &v, a: &a, lambda: &lambda, p: &p }))
    };
    let of_forces = pole_among(&followed(&at), size, near).map(|(row, column, value)| {
        let rate = &loaded.system().coordinates()[row].rate_name;
        (Some(format!("d/dt {rate}")), column, -value)
    });
    let outputs = outputs.columns;
    let (kept, states) = kept_states(loaded, &positions, &reduced);
    if let Some((name, column, value)) = pole.or(of_forces) {
        let state = kept.iter().position(|&k| k == column).map(|k| &states[k].name);
        let by = state.or_else(|| channels.inputs.get(column.checked_sub(size)?));
        let by = by.map_or_else(String::new, |by| format!(" by {by}"));
        let name = format!("{}{by}", name.unwrap_or_default());
        let place = "about this state".to_owned();
        return Err(AnalysisError::NoNumber { name, place, value });
    }
    let matrix_a = matrix_a.select_rows(&kept).select_columns(&kept);
    let poles = eigenvalues(&matrix_a).iter().map(|s| [s.re, s.im]).collect();
    let linear = Linear {
        states,
        inputs: channels.inputs.clone(),
        d: matrix_d,
        outputs,
        a: matrix_a,
        b: matrix_b.select_rows(&kept),
        c: matrix_c.select_columns(&kept),
        poles,
        state,
        pose: pose_of(loaded, &q)?,
        held: loaded.held_contacts(),
    };
    linear.check_numbers()?;
    Ok(linear)
}

/// G with its rows between rates, which ∂g/∂q does not have; `None` where there are none.
fn with_rows_of_rates(loaded: &Loaded, at: &ForcesAt) -> Option<DMatrix<f64>> {
    let is_of_rates = |row: usize| loaded.system().constraints[row].is_of_rates();
    let rows = loaded.kept.iter().enumerate().filter(|(_, row)| is_of_rates(**row));
    let rows: Vec<usize> = rows.map(|(k, _)| k).collect();
    let mut jacobian = (!rows.is_empty()).then(|| at.jacobian.clone())?;
    for k in rows {
        jacobian.set_row(k, &at.wrenches.row(k));
    }
    Some(jacobian)
}

/// The inputs of these names, and the parameters among them: parameters of loads, efforts by what they work on.
pub(crate) fn inputs_of(
    loaded: &Loaded,
    names: &[String],
) -> Result<(Vec<ParameterId>, Vec<Input>), AnalysisError> {
    let model = loaded.model();
    let mut free: Vec<ParameterId> = Vec::new();
    let mut inputs = Vec::new();
    for name in names {
        if let Ok(id) = loaded.parameter(name) {
            without_motion(loaded, id)?;
            inputs.push(Input::Parameter(free.len()));
            free.push(id);
            continue;
        }
        let is_joint = model.joints.iter().any(|joint| joint.name == *name);
        let quantity = if is_joint {
            let angle = named_quantity(loaded, &format!("{name}.angle"));
            angle.or_else(|_| named_quantity(loaded, &format!("{name}.position")))?
        } else {
            named_quantity(loaded, name)?
        };
        inputs.push(Input::Effort(quantity));
    }
    Ok((free, inputs))
}

/// Refuses a parameter that conditions on positions depend on, as of a drive: with it positions change, and so rates.
fn without_motion(loaded: &Loaded, id: ParameterId) -> Result<(), AnalysisError> {
    let model = loaded.model();
    let parameter = &model.parameters[id.0];
    let moves = |row: &&usize| {
        let own = with_definitions(model, &[id], loaded.system().constraints[**row].expression);
        model.pool.depends_on(own, parameter.symbol)
    };
    let Some(&row) = loaded.kept.iter().find(moves) else { return Ok(()) };
    let what = match loaded.system().constraints[row].source {
        Source::Drive(id) => format!("drive `{}`", model.drives[id.0].name),
        Source::Joint(id) => format!("joint `{}`", model.joints[id.0].name),
        Source::Coupling(id) => format!("coupling `{}`", model.couplings[id.0].name),
        Source::Stop(id) | Source::Friction(id) => format!("load `{}`", model.loads[id.0].name),
        Source::Quaternion(id) => format!("body `{}`", model.bodies[id.0].name),
    };
    Err(AnalysisError::MovingInput { name: parameter.name.clone(), what })
}

impl Linear {
    /// Refuses slopes that are no numbers, as of a root where it is zero.
    fn check_numbers(&self) -> Result<(), AnalysisError> {
        let columns = self.states.iter().map(|state| &state.name).chain(&self.inputs);
        let columns: Vec<&String> = columns.collect();
        let heads = self.states.iter().map(|state| format!("d/dt {}", state.name));
        let heads = heads.chain(self.outputs.iter().map(|output| output.name.clone()));
        for (head, row) in heads.zip(self.table().rows) {
            if let Some(k) = row.iter().position(|x| !x.is_finite()) {
                let name = format!("{head} by {}", columns[k]);
                let place = "about this state".to_owned();
                return Err(AnalysisError::NoNumber { name, place, value: row[k] });
            }
        }
        Ok(())
    }

    /// The matrices one below the other: a row for each of their rows, named by state or output.
    pub fn table(&self) -> Table {
        let states = self.states.iter().map(|state| Column::new(state.name.clone(), ""));
        let inputs = self.inputs.iter().map(|input| Column::new(input.clone(), ""));
        let row = |left: &DMatrix<f64>, right: &DMatrix<f64>, i: usize| -> Vec<f64> {
            left.row(i).iter().chain(right.row(i).iter()).copied().collect()
        };
        let upper = (0..self.a.nrows()).map(|i| row(&self.a, &self.b, i));
        let lower = (0..self.c.nrows()).map(|i| row(&self.c, &self.d, i));
        Table { columns: states.chain(inputs).collect(), rows: upper.chain(lower).collect() }
    }
}

/// The places in (y, ẏ) of the states of the linear system, all but the integrals of states, with names and units:
/// quantities, their rates, then states.
pub(crate) fn kept_states(
    loaded: &Loaded,
    positions: &Reduced,
    reduced: &Reduced,
) -> (Vec<usize>, Vec<Column>) {
    let coordinates = loaded.system().coordinates();
    let integrals = loaded.state_coordinates();
    let named =
        |name: &String| integrals.iter().map(|&i| &coordinates[i]).find(|c| c.name == *name);
    let state = |k: usize| named(&reduced.names[k]);
    let n = positions.n();
    let (mut kept, mut columns) = (Vec::new(), Vec::new());
    for (k, name) in positions.names.iter().enumerate().filter(|(_, name)| named(name).is_none()) {
        kept.push(k);
        columns.push(Column::new(name.clone(), positions.units[k]));
    }
    let (of_states, of_motions): (Vec<usize>, Vec<usize>) =
        (0..reduced.n()).partition(|&k| state(k).is_some());
    let (names, units) = (&reduced.names, &reduced.units);
    for &k in &of_motions {
        kept.push(n + k);
        columns.push(Column::new(rate_name(&names[k]), rate_unit(units[k], 1)));
    }
    for &k in &of_states {
        kept.push(n + k);
        let unit = |c| coordinate_units(loaded.model(), c)[1].clone();
        let name = state(k).map_or_else(String::new, |c| c.rate_name.clone());
        columns.push(Column::new(name, state(k).map_or_else(String::new, unit)));
    }
    (kept, columns)
}

/// The name of the rate of a quantity: `crank.rate` of `crank.angle`, `t_A_dot` of `t_A`.
fn rate_name(name: &str) -> String {
    match name.rsplit_once('.') {
        Some((stem, "angle")) => format!("{stem}.rate"),
        Some((stem, "position")) => format!("{stem}.velocity"),
        Some((stem, word)) => format!("{stem}.v{word}"),
        None => format!("{name}_dot"),
    }
}

/// q, v, a and the multipliers of the rows that hold.
type Moving = (Vec<f64>, Vec<f64>, Vec<f64>, Vec<f64>);

/// The state that is meant, in numbers and by name.
fn state_of(
    loaded: &Loaded,
    mut balance: Balance<'_>,
    about: About,
) -> Result<(Moving, State), AnalysisError> {
    let of_kept = |all: &[f64]| loaded.kept.iter().map(|&row| all[row]).collect::<Vec<f64>>();
    if let About::Start | About::Instant(_) = about {
        balance.on_one_branch()?;
        let lambda = of_kept(&loaded.lambda);
        let moving = (loaded.q.clone(), loaded.v.clone(), loaded.a.clone(), lambda);
        return Ok((moving, balance.of_motion(about)?));
    }
    let (found, state) = balance.chosen(about)?;
    let Equilibrium { q, lambda, .. } = found.on_one_branch()?;
    let v = balance.velocities(&q);
    let rest = vec![0.0; q.len()];
    Ok(((q, v, rest, of_kept(&lambda)), state))
}

/// δa with M δa + Gᵀ δλ = `forces` and G δa = `rows`.
fn accelerations(
    at: &ForcesAt,
    reduced: &Reduced,
    back: &DMatrix<f64>,
    forces: &DMatrix<f64>,
    rows: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    // What the rows ask for, then the rest along the free motions.
    let asked = back * rows;
    let mass = reduced.project(&at.mass);
    let scale = mass.diagonal().map(|m| if m > 0.0 { 1.0 / m.sqrt() } else { 0.0 });
    let scale = DMatrix::from_diagonal(&scale);
    let rest = reduced.basis.transpose() * (forces - &at.mass * &asked);
    let inverse = (&scale * mass * &scale).try_inverse()?;
    if inverse.iter().any(|x| !x.is_finite() || x.abs() > 1e13) {
        return None;
    }
    Some(asked + &reduced.basis * (&scale * inverse * &scale * rest))
}

/// δa and δλ with M δa + (Gᵀ + ∂r/∂λ) δλ = `forces` and G δa = `rows`, where friction follows the multipliers.
fn pressed_accelerations(
    at: &ForcesAt,
    jacobian: &DMatrix<f64>,
    forces: &DMatrix<f64>,
    rows: &DMatrix<f64>,
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    const WEAKEST: f64 = 1e-12;
    let (n, nc) = (at.mass.nrows(), jacobian.nrows());
    let mut matrix = DMatrix::zeros(n + nc, n + nc);
    matrix.view_mut((0, 0), (n, n)).copy_from(&at.mass);
    matrix.view_mut((0, n), (n, nc)).copy_from(&(at.wrenches.transpose() + &at.pressing));
    matrix.view_mut((n, 0), (nc, n)).copy_from(jacobian);
    // Units of mass and length weigh rows and columns.
    let size = |i: usize| {
        let own = if i < n { at.mass[(i, i)] } else { jacobian.row(i - n).norm_squared() };
        if own > 0.0 { 1.0 / own.sqrt() } else { 1.0 }
    };
    let scale: Vec<f64> = (0..n + nc).map(size).collect();
    let scaled = DMatrix::from_fn(n + nc, n + nc, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let svd = Svd::new(&scaled)?;
    let mut solved = DMatrix::zeros(n + nc, forces.ncols());
    for k in 0..forces.ncols() {
        let [above, below] = [forces.column(k), rows.column(k)];
        let right = above.iter().chain(below.iter()).zip(&scale);
        let right = DVector::from_iterator(n + nc, right.map(|(value, scale)| value * scale));
        let found = svd.solve(&right, WEAKEST * svd.largest());
        solved
            .column_mut(k)
            .iter_mut()
            .zip(found.iter().zip(&scale))
            .for_each(|(x, (found, scale))| *x = found * scale);
    }
    Some((solved.rows(0, n).into_owned(), solved.rows(n, nc).into_owned()))
}
