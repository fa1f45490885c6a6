//! Modes: frequencies, damping and shapes of small motions about an equilibrium.
//!
//! ```text
//! (M_r s² + C_r s + K_r) y = 0
//! ```
//!
//! Motions without inertia have no frequency: they are taken out before, as y₂ = −K₂₂⁻¹ K₂₁ y₁ where
//! nothing damps them, as ẏ₂ = −C₂₂⁻¹ (…) where something does, and counted as infinite. So are states of
//! controllers, whose equations are of first order; they have modes of their own, and are not counted.

use bksim_expr::{Expr, Tape};
use bksim_mbs::inertia::central_inertia;
use bksim_mbs::spatial;
use bksim_model::{BodyId, Model};
use nalgebra::{Complex, DVector};

use crate::about::About;
use crate::around::Around;
use crate::balance::Balance;
use crate::equilibrium::{CrossingBranch, Stability};
use crate::error::AnalysisError;
use crate::forces::ForcesAt;
use crate::linear_outputs::{moved, pole_among};
use crate::loaded::{HeldContacts, Loaded, without_rates};
use crate::pencil::Pencil;
use crate::quantity::PoseQuantity;
use crate::state::State;
use crate::table::{Column, Table};
use crate::way_rates::WayRates;

/// One motion y e^{s t}; of a pair of complex ones that with Im s > 0.
#[derive(Clone, PartialEq, Debug)]
pub struct Mode {
    /// s, 1/s: real and imaginary part.
    pub s: [f64; 2],
    /// |s|, rad/s: the angular frequency without damping.
    pub omega: f64,
    /// −Re s/|s|; zero for s = 0.
    pub damping: f64,
    /// Changes of joint positions, body angles and points, real and imaginary parts; the largest of the body
    /// angles, else of all, is 1.
    pub shape: Vec<[f64; 2]>,
    /// Changes of the generalised coordinates to the same scale.
    pub coordinates: Vec<[f64; 2]>,
    /// Part of each body in the kinetic energy of the mode; the ground is left out.
    pub shares: Vec<f64>,
    /// Where branches cross, the number of that along which it is, from one.
    pub branch: Option<usize>,
}

/// The modes about an equilibrium.
#[derive(Clone, PartialEq, Debug)]
pub struct Modes {
    /// Ascending by |s|.
    pub modes: Vec<Mode>,
    /// Number of modes without a finite frequency, of motions without inertia.
    pub n_infinite: usize,
    /// Names and units of the entries of a shape.
    pub quantities: Vec<Column>,
    /// Names of the bodies, for the shares.
    pub bodies: Vec<String>,
    /// Generalised coordinates of the equilibrium.
    pub q: Vec<f64>,
    /// Stability of the equilibrium.
    pub stability: Stability,
    /// The state that they are about.
    pub state: State,
    /// The branches of poses that cross in the equilibrium: each has modes of its own.
    pub branches: Vec<WayRates>,
    /// Stops and friction that count as constraints, and friction that is left out.
    pub held: HeldContacts,
}

/// An eigenvalue, the real and imaginary parts of the coordinates, and the number of a branch.
type Along = (Complex<f64>, [DVector<f64>; 2], Option<usize>);

/// Finds the modes of `model` about an equilibrium, or about the start itself as if at rest: its rates are left out, as the
/// state says.
///
/// # Errors
/// [`AnalysisError`] when there is no equilibrium.
pub fn modes(model: Model, about: About) -> Result<Modes, AnalysisError> {
    modes_of(&Loaded::at_rest(model)?, about)
}

/// The modes of a mechanism whose start is found.
pub(crate) fn modes_of(loaded: &Loaded, about: About) -> Result<Modes, AnalysisError> {
    without_rates(loaded.model())?;
    let mut balance = Balance::of(loaded, &[], &[])?;
    let (found, state) = match about {
        About::Instant(t) => return Err(AnalysisError::NotAtRest { t }),
        About::Start => {
            let start = balance.start();
            // Along branches that are not in balance there is no stiffness.
            if let Around::Crossing(ways) = balance.around_start()?
                && !balance.rests_on_all(&start, &ways)
            {
                balance.on_one_branch()?;
            }
            let found = balance.equilibrium(&start)?;
            let stability = Some(found.stability);
            let left_out = balance.rates_of_start()?;
            let kinks = balance.kinks_of(&found);
            (found, State { stability, left_out, kinks, ..balance.of_motion(about)? })
        }
        _ => balance.chosen(about)?,
    };
    let lambda: Vec<f64> = loaded.kept.iter().map(|&row| found.lambda[row]).collect();
    let at = balance.at(&found.q, &lambda);

    // Finite modes, then shapes of all bodies and shares of energy.
    let (motions, n_infinite) = if found.branches.is_empty() {
        let reduced = balance.reduced(&found.q, &at.jacobian)?;
        let pole = pole_among(&(&at.stiffness * &reduced.basis), reduced.n(), |k, share| {
            let q = moved(&found.q, &reduced.basis, k, share);
            balance.at(&q, &lambda).stiffness * &reduced.basis
        });
        if let Some((row, _, value)) = pole {
            let name = format!("stiffness along {}", loaded.system().coordinates()[row].name);
            let place = "in this state".to_owned();
            return Err(AnalysisError::NoNumber { name, place, value });
        }
        let pencil = Pencil::of(&at, &reduced);
        let (values, n_light) = pencil.finite_eigenvalues();
        let vectors = pencil.vectors(&values);
        let parts = |y: &DVector<Complex<f64>>| {
            [y.map(|c| c.re), y.map(|c| c.im)].map(|part| &reduced.basis * part)
        };
        let motion = |(s, y): (&Complex<f64>, &DVector<Complex<f64>>)| (*s, parts(y), None);
        let motions: Vec<Along> = values.iter().zip(&vectors).map(motion).collect();
        (motions, n_light - balance.states().len())
    } else {
        along_branches(&at, &found.branches)
    };
    let mut energies = Energies::compile(loaded)?;
    let mut scalars = loaded.scalars(&loaded.quantities)?;
    let mut modes = Vec::new();
    for (s, parts, branch) in motions {
        let along = parts.each_ref().map(|part| scalars.along(loaded.t, &found.q, part.as_slice()));
        let mut shape: Vec<Complex<f64>> =
            along[0].iter().zip(&along[1]).map(|(re, im)| Complex::new(*re, *im)).collect();
        // Of a mode of states alone the bodies have but rounding.
        let of_states = balance.states().iter().map(|&i| parts[0][i].hypot(parts[1][i]));
        let floor = 1e-12 * of_states.fold(0.0, f64::max);
        let unit = unit_of(&shape, &loaded.quantities, loaded.model(), floor);
        for c in &mut shape {
            *c /= unit;
        }
        let pairs = parts[0].iter().zip(parts[1].iter());
        let coordinates = pairs.map(|(re, im)| Complex::new(*re, *im) / unit);
        let shares = energies.shares(loaded, &found.q, parts.each_ref().map(DVector::as_slice));
        let omega = s.norm();
        modes.push(Mode {
            s: [s.re, s.im],
            omega,
            damping: if omega > 0.0 { -s.re / omega } else { 0.0 },
            shape: shape.iter().map(|c| [c.re, c.im]).collect(),
            coordinates: coordinates.map(|c| [c.re, c.im]).collect(),
            shares,
            branch,
        });
    }
    let columns = loaded.quantities.iter().map(|q| Column::new(q.names[0].clone(), q.unit));
    let mut held = loaded.held_contacts();
    // The state names these rates itself.
    if !state.left_out.is_empty() {
        held.stopped.clear();
    }
    Ok(Modes {
        modes,
        n_infinite,
        quantities: columns.collect(),
        bodies: loaded.model().bodies.iter().skip(1).map(|body| body.name.clone()).collect(),
        stability: found.stability,
        state,
        branches: found.branches.into_iter().map(|branch| branch.rates).collect(),
        q: found.q,
        held,
    })
}

/// The motions along branches that cross, m s² + c s + k = 0 along each, and the number of those without inertia.
fn along_branches(at: &ForcesAt, branches: &[CrossingBranch]) -> (Vec<Along>, usize) {
    let mut found = Vec::new();
    let mut n_infinite = 0;
    for (k, branch) in branches.iter().enumerate() {
        let t = DVector::from_column_slice(&branch.direction);
        let [m, c] = [&at.mass, &at.damping].map(|matrix| t.dot(&(matrix * &t)));
        if m <= 0.0 {
            n_infinite += 1;
            continue;
        }
        let (mean, square) = (-0.5 * c / m, branch.stiffness / m);
        let inside = mean * mean - square;
        let roots = if inside < 0.0 {
            vec![Complex::new(mean, (-inside).sqrt())]
        } else {
            [1.0, -1.0].map(|sign| Complex::new(mean + sign * inside.sqrt(), 0.0)).to_vec()
        };
        let parts = || [t.clone(), DVector::zeros(t.len())];
        found.extend(roots.into_iter().map(|s| (s, parts(), Some(k + 1))));
    }
    found.sort_by(|a, b| a.0.norm().total_cmp(&b.0.norm()));
    (found, n_infinite)
}

impl Modes {
    /// A row for each mode: s, ω, frequency, damping ratio, shares, shape.
    pub fn table(&self) -> Table {
        let heads = [
            ("re", "1/s"),
            ("im", "1/s"),
            ("omega", "rad/s"),
            ("frequency", "Hz"),
            ("damping", ""),
        ];
        let mut columns: Vec<Column> =
            heads.iter().map(|(name, unit)| Column::new(*name, *unit)).collect();
        columns.extend(self.bodies.iter().map(|body| Column::new(format!("share.{body}"), "")));
        for quantity in &self.quantities {
            for part in ["re", "im"] {
                columns
                    .push(Column::new(format!("{}.{part}", quantity.name), quantity.unit.clone()));
            }
        }
        let row = |mode: &Mode| {
            let first = [
                mode.s[0],
                mode.s[1],
                mode.omega,
                mode.omega / std::f64::consts::TAU,
                mode.damping,
            ];
            first
                .into_iter()
                .chain(mode.shares.iter().copied())
                .chain(mode.shape.iter().flatten().copied())
                .collect()
        };
        Table { columns, rows: self.modes.iter().map(row).collect() }
    }
}

/// The largest body angle of a shape, or, where no body turns, its largest entry; one where none is above `floor`.
fn unit_of(
    shape: &[Complex<f64>],
    quantities: &[PoseQuantity],
    model: &Model,
    floor: f64,
) -> Complex<f64> {
    let is_body_angle = |quantity: &PoseQuantity| {
        model.bodies.iter().any(|body| quantity.names[0] == format!("{}.angle", body.name))
    };
    let largest = |which: &dyn Fn(&PoseQuantity) -> bool| {
        let entries = shape.iter().zip(quantities).filter(|(_, quantity)| which(quantity));
        entries.map(|(c, _)| *c).max_by(|a, b| a.norm().total_cmp(&b.norm()))
    };
    let whole = largest(&|_| true).map_or(0.0, Complex::norm);
    let by_angle = largest(&is_body_angle).filter(|c| c.norm() > 1e-9 * whole);
    let unit = by_angle.or_else(|| largest(&|_| true)).filter(|c| c.norm() > floor);
    unit.unwrap_or(Complex::new(1.0, 0.0))
}

/// Kinetic energies of the bodies as functions of q and v.
struct Energies {
    tape: Tape,
}

impl Energies {
    fn compile(loaded: &Loaded) -> Result<Self, AnalysisError> {
        let model = loaded.model();
        let pool = &model.pool;
        let system = loaded.system();
        let kinematics = &system.kinematics;
        let half = pool.rational(1, 2);
        let energy = |id: usize| -> Expr {
            let body = &model.bodies[id];
            let p_world_com = kinematics.position(model, BodyId(id), None);
            let v_world_com = p_world_com.map(|component| kinematics.rate(model, component));
            let pose = &kinematics.poses[id];
            let omega = pose.rotation.apply_inverse(pool, &pose.omega);
            let inertia = central_inertia(model, BodyId(id));
            let spin = inertia.map(|row| spatial::dot(pool, &row, &omega));
            let moving = pool.mul(body.mass, spatial::dot(pool, &v_world_com, &v_world_com));
            pool.mul(half, pool.add(moving, spatial::dot(pool, &spin, &omega)))
        };
        let energies: Vec<Expr> = (1..model.bodies.len()).map(energy).collect();
        let coordinates = system.coordinates();
        let arguments: Vec<_> =
            coordinates.iter().map(|c| c.q).chain(coordinates.iter().map(|c| c.v)).collect();
        let symbols = system.parameters(model);
        Ok(Self { tape: Tape::compile(pool, &energies, &arguments, &symbols)? })
    }

    /// Part of each body in the kinetic energy of velocities with real and imaginary `parts`.
    fn shares(&mut self, loaded: &Loaded, q: &[f64], parts: [&[f64]; 2]) -> Vec<f64> {
        let mut workspace = self.tape.workspace(&loaded.parameters);
        let mut sums = vec![0.0; self.tape.n_outputs()];
        for v in parts {
            let mut energies = vec![0.0; sums.len()];
            self.tape.evaluate(&mut workspace, &[q, v].concat(), &mut energies);
            sums.iter_mut().zip(energies).for_each(|(sum, energy)| *sum += energy);
        }
        let whole: f64 = sums.iter().sum();
        sums.iter().map(|sum| if whole > 0.0 { sum / whole } else { 0.0 }).collect()
    }
}
