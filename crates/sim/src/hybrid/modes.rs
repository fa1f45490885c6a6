//! The values of the modes between two events.

use bksim_dae::{Loader, Saver, SolveError};

use super::indicators::{Watch, Watcher};

/// What every switch and every contact does until the next event.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Modes {
    /// σ of every switch, ±1.
    pub(crate) signs: Vec<f64>,
    /// Every contact, in the order of the system.
    pub(crate) touches: Vec<Touch>,
}

/// What one contact does.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Touch {
    /// A stop that is not in contact.
    Apart,
    /// A stop that holds.
    Resting,
    /// Friction on a motion in the direction of this sign, ±1.
    Sliding(f64),
    /// Friction that holds its motion at this position.
    Sticking(f64),
}

impl Touch {
    /// Whether the row of the contact holds.
    pub(crate) fn is_closed(self) -> bool {
        matches!(self, Self::Resting | Self::Sticking(_))
    }
}

impl Modes {
    /// As numbers.
    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.slice(&self.signs);
        for touch in &self.touches {
            let (kind, value) = match *touch {
                Touch::Apart => (0, 0.0),
                Touch::Resting => (1, 0.0),
                Touch::Sliding(sign) => (2, sign),
                Touch::Sticking(place) => (3, place),
            };
            saver.count(kind);
            saver.real(value);
        }
    }

    /// Takes over the modes of the same switches and contacts; stops and friction keep their kinds.
    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        const OTHER: SolveError = SolveError::Checkpoint { reason: "saved with other contacts" };
        loader.fill(&mut self.signs)?;
        for touch in &mut self.touches {
            let is_friction = matches!(touch, Touch::Sliding(_) | Touch::Sticking(_));
            let (kind, value) = (loader.count()?, loader.real()?);
            *touch = match (kind, is_friction) {
                (0, false) => Touch::Apart,
                (1, false) => Touch::Resting,
                (2, true) => Touch::Sliding(value),
                (3, true) => Touch::Sticking(value),
                _ => return Err(OTHER),
            };
        }
        Ok(())
    }

    /// The model's parameters with these modes behind them, as `SymbolicSystem::parameters` has
    /// their symbols.
    pub(crate) fn behind(&self, parameters: &[f64]) -> Vec<f64> {
        let mut all = parameters.to_vec();
        all.extend(&self.signs);
        for touch in &self.touches {
            match *touch {
                Touch::Apart => all.push(0.0),
                Touch::Resting => all.push(1.0),
                Touch::Sliding(sign) => all.extend([0.0, sign, 0.0]),
                Touch::Sticking(place) => all.extend([1.0, 0.0, place]),
            }
        }
        all
    }

    /// The modes whose numbers stand behind the parameters in [`Modes::behind`], in a system with
    /// these switches and contacts; `None` when there are other numbers than that.
    pub(crate) fn from_numbers(watch: &Watch, numbers: &[f64]) -> Option<Self> {
        let (signs, mut rest) = numbers.split_at_checked(watch.timed.len())?;
        let mut touches = Vec::with_capacity(watch.contacts.len());
        for contact in &watch.contacts {
            let (touch, after) = match (contact.is_friction, rest) {
                (false, [closed, after @ ..]) if *closed == 0.0 => (Touch::Apart, after),
                (false, [_, after @ ..]) => (Touch::Resting, after),
                (true, [closed, sign, _, after @ ..]) if *closed == 0.0 => {
                    (Touch::Sliding(*sign), after)
                }
                (true, [_, _, place, after @ ..]) => (Touch::Sticking(*place), after),
                _ => return None,
            };
            touches.push(touch);
            rest = after;
        }
        rest.is_empty().then(|| Self { signs: signs.to_vec(), touches })
    }

    /// Friction that slides shows as its multiplier, which it has not in the equations.
    pub(crate) fn fill_friction(
        &self,
        watcher: &mut Watcher<'_>,
        (t, q, v): (f64, &[f64], &[f64]),
        lambda: &mut [f64],
    ) {
        if self.touches.iter().all(|touch| !matches!(touch, Touch::Sliding(_))) {
            return;
        }
        let contacts = watcher.contacts();
        let view = watcher.view(t, q, v);
        for ((contact, seen), touch) in contacts.iter().zip(&view.contacts).zip(&self.touches) {
            if let Touch::Sliding(sign) = touch {
                lambda[contact.row] = -sign * seen.first;
            }
        }
    }
}
