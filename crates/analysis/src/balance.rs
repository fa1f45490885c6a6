//! [`Balance`]: the forces of a mechanism at rest, at one value of the parameters that are varied.
//!
//! ```text
//! ∂V/∂q − Q(q, 0) + Gᵀ λ = 0,   g = 0
//! K_r = Zᵀ (∂r/∂q) Z        stable where all its eigenvalues are positive
//! ```
//!
//! States of controllers are velocities of coordinates that nothing depends on. Here the states stand in the place of
//! those coordinates: in balance their rates are zero, and small motions decide about stability.

use bksim_mbs::coordinate::{Coordinate, CoordinateKind};
use bksim_model::{Measure, MotionKind, ParameterId};
use bksim_sim::{Svd, solve_square};
use nalgebra::{DMatrix, DVector};

use crate::around::Way;
use crate::drive::unknown_measure;
use crate::equilibrium::Equilibrium;
use crate::error::AnalysisError;
use crate::forces::{At, Forces, ForcesAt};
use crate::loaded::Loaded;
use crate::open_reactions::{ReactionBound, least, open_reactions};
use crate::quantity::PoseQuantity;
use crate::reduced::Reduced;
use crate::rows::wrapped;
use crate::scalar::Scalars;
use crate::stops::{Stops, bearing};

/// Forces at rest.
pub(crate) struct Balance<'a> {
    pub(crate) loaded: &'a Loaded,
    pub(crate) forces: Forces,
    /// Parameters that are varied.
    free: Vec<ParameterId>,
    /// Their values.
    p: Vec<f64>,
    /// Values of all parameters.
    parameters: Vec<f64>,
    /// Everything that a pose shows.
    pose: Scalars,
    /// Stops that no row holds.
    pub(crate) stops: Stops,
    /// Measures that the stiffness is by, and their slopes.
    pub(crate) by: (Vec<PoseQuantity>, Scalars),
    /// No accelerations.
    rest: Vec<f64>,
    /// Velocities of the steady motion with the drives; zero where they are held.
    steady: Vec<f64>,
    /// Coordinates whose velocities are states.
    states: Vec<usize>,
    /// True where forces are others after whole turns of the one free motion.
    pub(crate) counts_turns: bool,
    /// Number of free motions around the start, once that is looked at.
    pub(crate) n_motions: Option<usize>,
    /// A pose next to the start where branches cross in that.
    pub(crate) regular: Option<Vec<f64>>,
    /// These branches.
    pub(crate) ways: Vec<Way>,
    /// Bounds of reactions that are not unique.
    pub(crate) bounds: Vec<ReactionBound>,
}

impl<'a> Balance<'a> {
    /// The forces of `loaded` as functions of the parameters `free`, at their values in the model; the stiffness
    /// is by the measures `by`.
    pub(crate) fn of(
        loaded: &'a Loaded,
        by: &[String],
        free: &[ParameterId],
    ) -> Result<Self, AnalysisError> {
        let model = loaded.model();
        let forces =
            Forces::compile(model, loaded.system(), &loaded.kept, free, &loaded.parameters)?;
        let by: Vec<PoseQuantity> =
            by.iter().map(|name| named_quantity(loaded, name)).collect::<Result<_, _>>()?;
        let slopes = loaded.scalars(&by)?;
        let mut balance = Self {
            loaded,
            forces,
            free: free.to_vec(),
            p: free.iter().map(|id| loaded.parameters[id.0]).collect(),
            parameters: loaded.parameters.clone(),
            pose: loaded.scalars(&loaded.quantities)?,
            stops: Stops::of(loaded)?,
            by: (by, slopes),
            rest: vec![0.0; loaded.q.len()],
            steady: vec![0.0; loaded.q.len()],
            states: loaded.state_coordinates(),
            counts_turns: false,
            n_motions: None,
            regular: None,
            ways: Vec::new(),
            bounds: Vec::new(),
        };
        balance.follow_drives();
        Ok(balance)
    }

    /// Takes the velocities of the steady motion with the drives, where the mechanism has one.
    fn follow_drives(&mut self) {
        if self.loaded.turns {
            self.steady = self.steady_rates().unwrap_or_else(|| self.rest.clone());
        }
    }

    /// Coordinates whose velocities are states.
    pub(crate) fn states(&self) -> &[usize] {
        &self.states
    }

    /// Units of the coordinates: 1, and the longest link of lengths.
    pub(crate) fn units(&self) -> DVector<f64> {
        let coordinates = self.loaded.system().coordinates();
        let unit = |kind| if kind == CoordinateKind::Length { self.loaded.size } else { 1.0 };
        DVector::from_iterator(coordinates.len(), coordinates.iter().map(|c| unit(c.kind)))
    }

    /// Unit of the motion that the effort of a constraint row works on: 1 rad, or the longest link.
    pub(crate) fn unit_of_row(&self, row: usize) -> f64 {
        match self.loaded.system().constraints[row].effort {
            MotionKind::Rotation => 1.0,
            MotionKind::Translation => self.loaded.size,
        }
    }

    /// The position of the start, states in their places.
    pub(crate) fn start(&self) -> Vec<f64> {
        let mut q = self.loaded.q.clone();
        self.states.iter().for_each(|&i| q[i] = self.loaded.v[i]);
        q
    }

    /// Velocities of the steady motion with the drives.
    pub(crate) fn steady(&self) -> &[f64] {
        &self.steady
    }

    /// The equations at a position with velocities, without accelerations and multipliers.
    pub(crate) fn moving_at(&mut self, t: f64, [q, v]: [&[f64]; 2]) -> ForcesAt {
        let lambda = vec![0.0; self.forces.nc()];
        self.forces.at(At { t, q, v, a: &self.rest, lambda: &lambda, p: &self.p })
    }

    /// The velocities at a position: those of states, and of the steady motion with the drives.
    pub(crate) fn velocities(&self, q: &[f64]) -> Vec<f64> {
        let mut v = self.steady.clone();
        self.states.iter().for_each(|&i| v[i] = q[i]);
        v
    }

    /// Values of all parameters.
    pub(crate) fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// The multipliers of smallest norm that balance the forces as well as any do, where slopes of some rows follow from those
    /// of others up to rounding.
    pub(crate) fn smallest_balancing(&mut self, q: &[f64]) -> Option<Vec<f64>> {
        /// Part of the largest singular value that rounding of a singular pose leaves.
        const FLOOR: f64 = 1e-6;
        let nothing = vec![0.0; self.forces.nc()];
        let at = self.at(q, &nothing);
        let transposed = at.jacobian.transpose();
        let lambda = Svd::new(&transposed)?.solve(&-at.residual, FLOOR * transposed.norm());
        Some(lambda.as_slice().to_vec())
    }

    /// Gives the varied parameters values.
    pub(crate) fn set(&mut self, p: &[f64]) {
        if self.p == p {
            return;
        }
        self.p = p.to_vec();
        self.parameters = self.loaded.parameters_with(&self.free, p);
        self.pose.set_parameters(&self.parameters);
        self.stops.set_parameters(&self.parameters);
        self.by.1.set_parameters(&self.parameters);
        self.follow_drives();
    }

    /// The free motions at a position.
    pub(crate) fn reduced(
        &mut self,
        q: &[f64],
        jacobian: &DMatrix<f64>,
    ) -> Result<Reduced, AnalysisError> {
        let slopes = self.by.1.gradients(self.loaded.t, q);
        let mut named: Vec<_> = (self.by.0.iter().zip(slopes))
            .map(|(quantity, slopes)| (quantity.names[0].clone(), quantity.unit, slopes))
            .collect();
        if !named.is_empty() {
            let coordinates = self.loaded.system().coordinates();
            named.extend(self.states.iter().map(|&i| {
                let mut slopes = vec![0.0; q.len()];
                slopes[i] = 1.0;
                (coordinates[i].name.clone(), "", slopes)
            }));
        }
        Reduced::at(self.loaded, jacobian, &named)
    }

    /// Names and units of the independent quantities.
    pub(crate) fn by_names(
        &mut self,
        q: &[f64],
    ) -> Result<Vec<(String, &'static str)>, AnalysisError> {
        let lambda = vec![0.0; self.forces.nc()];
        let at = self.at(q, &lambda);
        let reduced = self.reduced(q, &at.jacobian)?;
        let coordinates = self.loaded.system().coordinates();
        // A state is known by its own name, not by that of its integral.
        let named = |name: String| {
            let state = self.states.iter().find(|&&i| coordinates[i].name == name);
            state.map_or(name, |&i| coordinates[i].rate_name.clone())
        };
        Ok(reduced.names.into_iter().map(named).zip(reduced.units).collect())
    }

    pub(crate) fn at(&mut self, q: &[f64], lambda: &[f64]) -> ForcesAt {
        let (t, v) = (self.loaded.t, self.velocities(q));
        let at = self.forces.at(At { t, q, v: &v, a: &self.rest, lambda, p: &self.p });
        at.with_states_as_positions(&self.states)
    }

    /// The multipliers that balance the forces at a position as well as any do.
    pub(crate) fn balancing(&mut self, q: &[f64]) -> Option<Vec<f64>> {
        let v = self.velocities(q);
        self.forces.balancing(self.loaded.t, [q, &v], &self.p)
    }

    /// Values of all quantities at a position, then of states, whose units are those of the author and not named.
    pub(crate) fn pose_at(&mut self, q: &[f64]) -> Vec<(String, f64, &'static str)> {
        let values = self.pose.values(self.loaded.t, q);
        let named = self.loaded.quantities.iter().zip(values);
        let named =
            named.map(|(quantity, value)| (quantity.names[0].clone(), value, quantity.unit));
        let coordinates = self.loaded.system().coordinates();
        let state = |&i: &usize| (coordinates[i].rate_name.clone(), q[i], "");
        named.chain(self.states.iter().map(state)).collect()
    }

    /// The slopes of all quantities of a pose by the coordinates.
    pub(crate) fn pose_gradients(&mut self, q: &[f64]) -> Vec<Vec<f64>> {
        self.pose.gradients(self.loaded.t, q)
    }

    /// The largest moment or work per longest link that joints bear, J: what forces in balance are measured by.
    pub(crate) fn load_size(&self, q: &[f64], lambda: &[f64]) -> f64 {
        let loaded = self.loaded;
        let mut lambda = self.forces.all_multipliers(loaded.system().constraints.len(), lambda);
        let v = self.velocities(q);
        let state = [q, &v, &self.rest];
        let reactions = loaded.reactions(loaded.t, &self.parameters, state, &mut lambda);
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let size = |r: &[f64; 6]| (norm(&r[..3]) * loaded.size).max(norm(&r[3..]));
        reactions.iter().map(size).fold(0.0, f64::max)
    }

    /// Everything about an equilibrium at a position.
    pub(crate) fn equilibrium(&mut self, q: &[f64]) -> Result<Equilibrium, AnalysisError> {
        if let Some(ways) = self.ways_at(q) {
            return self.at_crossing(q, &ways);
        }
        let undetermined = || AnalysisError::Undetermined { what: "the constraints".into(), n: 1 };
        let lambda = self.balancing(q).ok_or_else(undetermined)?;
        let at = self.at(q, &lambda);
        at.check_slopes(self.loaded.system().coordinates(), q)?;
        let reduced = self.reduced(q, &at.jacobian)?;
        // By the motions alone, states held.
        let coordinates = self.loaded.system().coordinates();
        let is_state = |name: &String| self.states.iter().any(|&i| coordinates[i].name == *name);
        let motions: Vec<usize> =
            (0..reduced.n()).filter(|&k| !is_state(&reduced.names[k])).collect();
        let projected = reduced.project(&at.stiffness);
        let projected = projected.select_rows(&motions).select_columns(&motions);
        let stiffness = symmetric_eigenvalues(&projected);
        let loads = self.load_size(q, &lambda);
        let stability = self.stability(&at, (&reduced, &motions), loads);
        let loaded = self.loaded;
        let n_rows = loaded.system().constraints.len();
        let mut lambda = self.forces.all_multipliers(n_rows, &lambda);
        let v = self.velocities(q);
        let state = [q, &v, &self.rest];
        let mut reactions = loaded.reactions(loaded.t, &self.parameters, state, &mut lambda);
        least(loaded, &self.parameters, (loaded.t, q), (&mut reactions, &mut lambda));
        let numbers = (self.parameters.as_slice(), self.bounds.as_slice());
        let open = open_reactions(loaded, numbers, (loaded.t, q), (&reactions, &lambda));
        Ok(Equilibrium {
            q: q.to_vec(),
            open,
            bearing: bearing((loaded.model(), loaded.system()), &loaded.kept, &lambda),
            beyond: self.stops.passed(q),
            lambda,
            stability,
            stiffness,
            branches: Vec::new(),
            family: None,
            pose: self.pose_at(q),
            reactions,
        })
    }

    /// By how much the coordinates of two poses differ: angles modulo 2π, lengths in units of the mechanism,
    /// and of the two quaternions of a rotation that which is nearer.
    pub(crate) fn apart(&self, a: &[f64], b: &[f64]) -> Vec<f64> {
        let system = self.loaded.system();
        let mut signs = vec![1.0; a.len()];
        for turning in &system.kinematics.turnings {
            let parts = turning.first..turning.first + 4;
            let cosine: f64 = parts.clone().map(|i| a[i] * b[i]).sum();
            signs[parts].fill(if cosine < 0.0 { -1.0 } else { 1.0 });
        }
        let off = |(i, c): (usize, &Coordinate)| match c.kind {
            CoordinateKind::Angle => wrapped(a[i] - b[i]),
            CoordinateKind::Length => (a[i] - b[i]) / self.loaded.size,
            CoordinateKind::Quaternion => a[i] - signs[i] * b[i],
            CoordinateKind::Integral => a[i] - b[i],
        };
        system.coordinates().iter().enumerate().map(off).collect()
    }

    /// The equilibrium that Newton's iteration leads to from a position.
    pub(crate) fn newton(&mut self, guess: &[f64]) -> Option<Vec<f64>> {
        const MOST: usize = 60;
        const LONGEST: f64 = 0.5;
        let n = self.forces.n();
        let nc = self.forces.nc();
        let mut q = guess.to_vec();
        let units = self.units();
        let mut lambda = self.balancing(&q)?;
        // Slopes that vanish where all poses are in balance lead anywhere.
        if self.states.is_empty() && self.is_balanced(&q, &lambda, &units) {
            return Some(q);
        }
        for _ in 0..MOST {
            let at = self.at(&q, &lambda);
            let mut matrix = DMatrix::zeros(n + nc, n + nc);
            matrix.view_mut((0, 0), (n, n)).copy_from(&at.stiffness);
            matrix.view_mut((0, n), (n, nc)).copy_from(&at.jacobian.transpose());
            matrix.view_mut((n, 0), (nc, n)).copy_from(&at.jacobian);
            let right = DVector::from_iterator(
                n + nc,
                at.residual.iter().chain(at.closure.iter()).map(|value| -value),
            );
            // Units of length and force weigh rows and columns.
            let scale = DVector::from_fn(n + nc, |i, _| if i < n { units[i] } else { 1.0 });
            let scaled =
                DMatrix::from_fn(n + nc, n + nc, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
            let right = right.component_mul(&scale);
            let is_fair = |step: &DVector<f64>| {
                step.iter().all(|x| x.is_finite()) && step.rows(0, n).amax() < 1e3
            };
            let mut step = solve_square(&scaled, &right);
            if !is_fair(&step) {
                step = Svd::new(&scaled)?.solve(&right, 1e-12 * scaled.norm());
            }
            // A state may change by any amount: its unit has no size of the mechanism.
            let moves = (0..n).filter(|i| !self.states.contains(i));
            let longest = moves.fold(0.0, |a: f64, i| a.max(step[i].abs()));
            let is_settled =
                self.states.iter().all(|&i| step[i].abs() <= 1e-12 * (1.0 + q[i].abs()));
            let share = if longest > LONGEST { LONGEST / longest } else { 1.0 };
            for i in 0..n {
                q[i] += share * step[i] * scale[i];
            }
            for k in 0..nc {
                lambda[k] += share * step[n + k];
            }
            if !longest.is_finite() {
                return None;
            }
            if longest < 1e-13 && is_settled {
                break;
            }
        }
        self.is_equilibrium(&q).then_some(q)
    }

    /// True where joints close and some multipliers balance the forces.
    pub(crate) fn is_equilibrium(&mut self, q: &[f64]) -> bool {
        let units = self.units();
        self.balancing(q).is_some_and(|lambda| self.is_balanced(q, &lambda, &units))
    }

    /// True where joints close and the forces are in balance, up to rounding of what they are the sum of.
    fn is_balanced(&mut self, q: &[f64], lambda: &[f64], units: &DVector<f64>) -> bool {
        let (n, nothing) = (q.len(), vec![0.0; lambda.len()]);
        let at = self.at(q, lambda);
        // Work per radian or longest link: of the loads, of what they change by, and of what joints bear.
        let work = |forces: &DVector<f64>| forces.component_mul(units).amax();
        let changes = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let changes = changes
            .fold(0.0, |a: f64, (i, j)| a.max((at.stiffness[(i, j)] * units[i] * units[j]).abs()));
        let loads = work(&self.at(q, &nothing).residual).max(changes);
        let loads = loads.max(1e-3 * self.load_size(q, lambda));
        if at.residual.iter().any(|force| !force.is_finite()) {
            return false;
        }
        let closure = if at.closure.is_empty() { 0.0 } else { at.closure.amax() };
        closure < 1e-9 * self.loaded.size.max(1.0) && work(&at.residual) <= 1e-9 * loads
    }
}

/// A measure as a quantity.
pub(crate) fn named_quantity(loaded: &Loaded, name: &str) -> Result<PoseQuantity, AnalysisError> {
    let model = loaded.model();
    let fits =
        |m: Measure| !(m.is_acceleration() || m.is_reaction() || matches!(m, Measure::State(_)));
    let measure = Measure::named(model, name).filter(|&measure| fits(measure));
    let measure =
        measure.ok_or_else(|| unknown_measure(model, name, |measure| measure.is_some_and(fits)))?;
    let value = loaded.system().kinematics.measure(model, measure);
    let names = [name.to_owned(), format!("{name}'"), format!("{name}''")];
    Ok(PoseQuantity { names, unit: measure.fixed_unit(model), value })
}

/// Values of all quantities at a position.
pub(crate) fn pose_of(
    loaded: &Loaded,
    q: &[f64],
) -> Result<Vec<(String, f64, &'static str)>, AnalysisError> {
    let values = loaded.scalars(&loaded.quantities)?.values(loaded.t, q);
    let named = loaded.quantities.iter().zip(values);
    Ok(named.map(|(quantity, value)| (quantity.names[0].clone(), value, quantity.unit)).collect())
}

fn symmetric_eigenvalues(matrix: &DMatrix<f64>) -> Vec<f64> {
    if matrix.is_empty() {
        return Vec::new();
    }
    let symmetric = (matrix + matrix.transpose()) * 0.5;
    let mut values: Vec<f64> = symmetric.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}
