//! [`EffortSolver`]: the efforts of a mechanism at any instant of a motion.

use bksim_mbs::constraint::Source;
use bksim_mbs::coordinate::CoordinateKind;
use nalgebra::DMatrix;

use crate::PoseQuantity;
use crate::actuation::{Actuation, EffortEquations, EffortLimit};
use crate::effort_channels::Channel;
use crate::effort_contacts::{EffortContact, EffortContacts, MotionSize, Touch};
use crate::effort_faults::{friction_jams, shared_reaction};
use crate::effort_forces::{EffortInstant, FoundEfforts, Wanted};
use crate::effort_ranges::{EffortRanges, effort_ranges};
use crate::effort_stops::MotionState;
use crate::error::AnalysisError;
use crate::forces::Forces;
use crate::loaded::Loaded;
use crate::reduced::null_space;
use crate::scalar::Scalars;

/// Parts of a combination of multipliers that are rounding.
const ROUNDING: f64 = 1e-9;

/// Everything that the efforts at an instant follow from, but for the instant.
pub(crate) struct EffortSolver<'a> {
    pub(crate) loaded: &'a Loaded,
    forces: Forces,
    contacts: EffortContacts,
    actuation: Actuation,
    /// D of all channels.
    slopes: Scalars,
    prescribed: Vec<usize>,
    /// Rows of stops that bear throughout.
    bearing: Vec<usize>,
    size: MotionSize,
    limits: Vec<f64>,
}

/// Efforts at an instant.
pub(crate) struct SolvedEfforts {
    pub(crate) found: FoundEfforts,
    pub(crate) equations: EffortEquations,
    touches: Vec<Touch>,
    /// All parameters, with what contacts do.
    pub(crate) parameters: Vec<f64>,
}

/// Where the efforts of an instant are looked for.
#[derive(Clone, Copy)]
pub(crate) struct InstantState<'s> {
    pub(crate) t: f64,
    /// q, v and a of all coordinates, integrals of states among them.
    pub(crate) state: [&'s [f64]; 3],
    /// Coordinates that move.
    pub(crate) n_moving: usize,
    /// Parameters without contacts.
    pub(crate) parameters: &'s [f64],
}

impl<'a> EffortSolver<'a> {
    /// The solver of `loaded`, all of whose rows are kept; `bearing` are rows of stops that bear throughout.
    pub(crate) fn of(
        loaded: &'a Loaded,
        (channels, quantities): (&[Channel], &[PoseQuantity]),
        limits: &[EffortLimit],
        bearing: Vec<usize>,
    ) -> Result<Self, AnalysisError> {
        let forces = Forces::compile(
            loaded.model(),
            loaded.system(),
            &loaded.kept,
            &[],
            &loaded.parameters,
        )?;
        let limit_of = |channel: &Channel| {
            let own = limits.iter().find(|limit| limit.name == channel.name);
            own.map_or(f64::INFINITY, |limit| limit.limit)
        };
        let acting = channels.iter().filter(|c| c.drive_idx.is_some());
        Ok(Self {
            forces,
            contacts: EffortContacts::of(loaded)?,
            actuation: actuation(loaded, channels, quantities, (limits, &bearing)),
            slopes: loaded.scalars(quantities)?,
            prescribed: (0..channels.len()).filter(|&k| channels[k].is_prescribed).collect(),
            bearing,
            size: MotionSize::default(),
            limits: acting.map(limit_of).collect(),
            loaded,
        })
    }

    /// Takes the size of a motion through these states.
    pub(crate) fn measure(&mut self, states: &[MotionState]) {
        let units = &self.actuation.unit_of_column;
        let largest = |values: &[f64]| {
            values.iter().zip(units).fold(0.0, |most: f64, (x, unit)| most.max((x / unit).abs()))
        };
        for [_, v, a] in states {
            self.size.rate = self.size.rate.max(largest(v));
            self.size.acceleration = self.size.acceleration.max(largest(a));
        }
    }

    /// The efforts at an instant.
    ///
    /// # Errors
    /// [`AnalysisError`] where a pose is singular, or no efforts are in balance with friction.
    pub(crate) fn at(&mut self, of: InstantState<'_>) -> Result<SolvedEfforts, AnalysisError> {
        let InstantState { t, state: [q, v, a], n_moving, parameters } = of;
        let touches = self.contacts.at(t, [q, v, a], self.size, &self.bearing);
        let parameters = self.contacts.parameters(parameters, &touches);
        self.set_parameters(&parameters);
        let nothing = vec![0.0; self.forces.nc()];
        let at = self.forces.at(crate::forces::At { t, q, v, a, lambda: &nothing, p: &[] });
        at.check_forces(self.loaded.system().coordinates(), t)?;
        let jacobian = at.wrenches.columns(0, n_moving).into_owned();

        // The motions that are prescribed, then the stops that bear throughout.
        let gradients = self.slopes.gradients(t, q);
        let n = self.prescribed.len();
        let slopes =
            DMatrix::from_fn(n + self.bearing.len(), n_moving, |k, i| match k.checked_sub(n) {
                None => gradients[self.prescribed[k]][i],
                Some(stop) => jacobian[(self.bearing[stop], i)],
            });
        let touching: Vec<usize> = (self.contacts.all.iter().zip(&touches))
            .filter(|(_, touch)| touch.is_touching())
            .map(|(contact, _)| contact.row)
            .collect();
        let equations = self.actuation.at(&jacobian, &slopes, &touching);
        let equations = equations.ok_or(AnalysisError::Lost { t })?;
        self.check_shared(&jacobian)?;
        let mut instant = EffortInstant {
            t,
            state: [q, v, a],
            forces: &mut self.forces,
            contacts: &mut self.contacts,
            touches: &touches,
            equations: &equations,
            n_moving,
        };
        let found = instant.efforts(Wanted::Smallest);
        let of = |k: usize| (self.contacts.all[k].name.as_str(), &self.contacts.all[k].span);
        let Some(found) = found else {
            let sliding = touches.iter().position(|touch| matches!(touch, Touch::Slides(_)));
            return Err(match sliding {
                Some(k) => friction_jams(of(k), t, false),
                None => AnalysisError::Lost { t },
            });
        };
        match found.driving {
            Some(k) => Err(friction_jams(of(k), t, true)),
            None => Ok(SolvedEfforts { found, equations, touches, parameters }),
        }
    }

    /// The ranges of the efforts at an instant, and the contacts that leave them open.
    pub(crate) fn ranges(
        &mut self,
        of: InstantState<'_>,
        solved: &SolvedEfforts,
    ) -> (EffortRanges, Vec<String>) {
        let InstantState { t, state, n_moving, .. } = of;
        self.set_parameters(&solved.parameters);
        let mut instant = EffortInstant {
            t,
            state,
            forces: &mut self.forces,
            contacts: &mut self.contacts,
            touches: &solved.touches,
            equations: &solved.equations,
            n_moving,
        };
        let found = effort_ranges(&mut instant, &solved.found, &self.limits);
        let open = solved.equations.open_contacts();
        let touching = self.contacts.all.iter().zip(&solved.touches);
        let touching = touching.filter(|(_, touch)| touch.is_touching());
        let names = touching.zip(open).filter(|(_, is_open)| *is_open);
        (found, names.map(|((contact, _), _)| contact.name.clone()).collect())
    }

    /// The stop that bears throughout and would have to pull, of efforts at an instant.
    pub(crate) fn pulling(&self, solved: &SolvedEfforts) -> Option<usize> {
        let missing = &solved.found.efforts.missing[self.prescribed.len()..];
        let units = &self.actuation.unit_of_motion[self.prescribed.len()..];
        let is_pulling = |(x, unit): (&f64, &f64)| (x * unit).abs() > ROUNDING * solved.found.size;
        let stop = missing.iter().zip(units).position(is_pulling)?;
        self.contacts.all.iter().position(|contact| contact.row == self.bearing[stop])
    }

    /// A stop or friction.
    pub(crate) fn contact(&self, k: usize) -> &EffortContact {
        &self.contacts.all[k]
    }

    /// Sizes of what is missing along the prescribed motions, in units of the motions.
    pub(crate) fn missing_parts(&self, found: &FoundEfforts) -> Vec<f64> {
        let own = found.efforts.missing.iter().zip(&self.actuation.unit_of_motion);
        own.take(self.prescribed.len()).map(|(x, unit)| (x * unit).abs()).collect()
    }

    fn set_parameters(&mut self, parameters: &[f64]) {
        self.forces.set_parameters(parameters);
        self.contacts.set_parameters(parameters);
    }

    /// Refuses friction by a reaction that joints share among themselves.
    fn check_shared(&self, jacobian: &DMatrix<f64>) -> Result<(), AnalysisError> {
        if self.contacts.pressing.is_empty() {
            return Ok(());
        }
        let bearing = &self.actuation.bearing;
        let shared = null_space(&jacobian.select_rows(bearing).transpose());
        let is_shared = |row: &&usize| {
            let at = bearing.iter().position(|own| own == *row);
            at.is_some_and(|at| shared.row(at).amax() > ROUNDING)
        };
        if shared.ncols() == 0 {
            return Ok(());
        }
        let found = self.contacts.pressing.iter().find(is_shared);
        found.map_or(Ok(()), |&row| Err(shared_reaction(self.loaded, row)))
    }
}

/// Rows and units of the equations; efforts without a limit weigh as those with the largest.
fn actuation(
    loaded: &Loaded,
    channels: &[Channel],
    quantities: &[PoseQuantity],
    (limits, stops): (&[EffortLimit], &[usize]),
) -> Actuation {
    let system = loaded.system();
    let rows = 0..system.constraints.len();
    let is_acting = |k: &usize| matches!(system.constraints[*k].source, Source::Drive(_));
    let is_bearing = |k: &usize| !is_acting(k) && !system.constraints[*k].source.is_contact();
    let actuators = || channels.iter().zip(quantities).filter(|(c, _)| c.drive_idx.is_some());
    let own = |name: &str| limits.iter().find(|l| l.name == name).map(|l| l.limit);
    let largest = limits.iter().fold(0.0, |most: f64, l| most.max(l.limit));
    let weight = |(channel, quantity): (&Channel, &PoseQuantity)| {
        let unit = if quantity.is_angle() { loaded.size } else { 1.0 };
        own(&channel.name).unwrap_or(if largest > 0.0 { largest } else { unit })
    };
    let unit_of_column = system
        .coordinates()
        .iter()
        .map(|c| if c.kind == CoordinateKind::Length { loaded.size } else { 1.0 });
    let prescribed = channels.iter().zip(quantities).filter(|(c, _)| c.is_prescribed);
    let unit_of_motion = prescribed.map(|(_, q)| if q.unit == "m" { loaded.size } else { 1.0 });
    let is_turn =
        |row: &usize| system.constraints[*row].effort == bksim_model::MotionKind::Rotation;
    let unit_of_stop = stops.iter().map(|row| if is_turn(row) { 1.0 } else { loaded.size });
    Actuation {
        bearing: rows.clone().filter(is_bearing).collect(),
        acting: rows.filter(is_acting).collect(),
        weights: actuators().map(weight).collect(),
        unit_of_column: unit_of_column.collect(),
        unit_of_motion: unit_of_motion.chain(unit_of_stop).collect(),
    }
}

/// Multipliers of all rows from those that the equations have.
pub(crate) fn all_rows(n_rows: usize, lambda: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; n_rows];
    all[..lambda.len()].copy_from_slice(lambda);
    all
}
