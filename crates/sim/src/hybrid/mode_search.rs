//! The modes that are consistent at one instant, and the blow that leads to them.
//!
//! Signs and contacts that are clearly on one side follow from the state. The rest — functions that
//! are zero, stops in touch, friction at rest — must agree with what the accelerations then do:
//!
//! ```text
//! kink      σ u′ ≥ 0
//! stop      λ ≥ 0 at rest,            φ″ ≤ 0 apart
//! friction  |λ| ≤ F₀ sticking,        ς p″ ≥ 0 sliding
//! ```
//!
//! All combinations are tried in a fixed order, contacts closed first, until one is consistent.

use nalgebra::DVector;

use super::fixed::{Frozen, Matrices, largest};
use super::impact::{Stops, impact};
use super::indicators::{Decider, View, Watch};
use super::modes::{Modes, Touch};
use crate::compiled::CompiledSystem;
use crate::linear::dense::dependent_rows;

/// Combinations of undecided modes that are tried before the search is given up.
const MAX_COMBINATIONS: usize = 4096;
/// Relative size of what counts as rounding in forces and accelerations.
const ROUNDING: f64 = 1e-9;
/// A drive may jump by this part of the size of the state before it counts as a jump.
const JUMP: f64 = 1e-6;
/// An event is located where its function has passed the band; bands this much wider hold what is
/// zero there.
const SLACK: f64 = 4.0;
/// Bounces no higher than this many bands come to rest.
const HIDDEN: f64 = 1e3;
/// Blows that may follow one another at one instant.
const MAX_BLOWS: usize = 8;

/// What is known before the modes are chosen.
pub(crate) struct Instant<'a> {
    pub(crate) compiled: &'a CompiledSystem,
    /// The model's own.
    pub(crate) parameters: &'a [f64],
    /// s.
    pub(crate) t: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// The modes until now.
    pub(crate) before: &'a Modes,
    /// What has just crossed zero.
    pub(crate) fired: &'a [Decider],
    pub(crate) bands: Bands,
}

/// How near to zero counts as zero.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Bands {
    /// By switch, in the unit of its function.
    pub(crate) kinks: Vec<f64>,
    /// m or rad: of rounding.
    pub(crate) position: f64,
    /// m/s or rad/s.
    pub(crate) rate: f64,
    /// Bounces no higher, m or rad, and no faster, m/s or rad/s, come to rest.
    pub(crate) rest: [f64; 2],
}

/// Consistent modes with the state they start from.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Settled {
    pub(crate) modes: Modes,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) a: Vec<f64>,
    pub(crate) lambda: Vec<f64>,
    /// Rows that are open or follow from others.
    pub(crate) dependent: Vec<usize>,
    /// Change of the kinetic energy by blows, J.
    pub(crate) blow: f64,
    /// Contacts that were hit, each with its speed of approach.
    pub(crate) hits: Vec<(usize, f64)>,
}

/// Why no modes are consistent.
#[derive(Clone, PartialEq, Debug)]
pub enum Unsettled {
    /// Whichever branch is taken leads back to the switch.
    Chatter {
        /// The switch.
        kink: usize,
    },
    /// No set of contacts is consistent.
    Contacts {
        /// The contacts in question.
        contacts: Vec<usize>,
    },
    /// A prescribed position jumps.
    Jump {
        /// The constraint row.
        row: usize,
        /// By how much, m or rad.
        by: f64,
    },
}

/// One mode that the state alone does not decide, and what it may be, in order of preference.
struct Open {
    decider: Decider,
    choices: Vec<Choice>,
}

#[derive(Clone, Copy)]
enum Choice {
    Sign(f64),
    Touch(Touch),
}

/// Chooses the modes at an instant.
///
/// # Errors
/// [`Unsettled`] when there are none.
pub(crate) fn settle(instant: Instant<'_>) -> Result<Settled, Unsettled> {
    let mut work = Work::of(instant);
    work.decide();
    for _ in 0..MAX_BLOWS {
        if !work.blow()? {
            break;
        }
        work.decide();
    }
    let open = work.undecided();
    work.choose(&open)
}

/// As [`settle`], without blows: bodies that run into a stop are left to do so.
///
/// # Errors
/// [`Unsettled`] when there are no consistent modes.
pub(crate) fn settle_smoothly(instant: Instant<'_>) -> Result<Settled, Unsettled> {
    let mut work = Work::of(instant);
    work.decide();
    let open = work.undecided();
    work.choose(&open)
}

impl Bands {
    /// The bands for an absolute tolerance, with rounding of what the switches have been so far.
    pub(crate) fn new(atol: f64, view: &View, watch: &Watch) -> Self {
        const PART: f64 = 1e-3;
        const ROUNDING: f64 = 1e-12;
        // A body that falls through the band gains speed; this is all that is needed.
        const ROUNDING_OF_POSITION: f64 = 64.0 * f64::EPSILON;
        let band = |(u, &timed): (&f64, &bool)| {
            if timed { 0.0 } else { PART * atol + ROUNDING * u.abs() }
        };
        Self {
            kinks: view.kinks.iter().zip(&watch.timed).map(band).collect(),
            position: ROUNDING_OF_POSITION,
            rate: PART * atol,
            rest: [atol; 2],
        }
    }
}

struct Work<'a> {
    at: Instant<'a>,
    modes: Modes,
    blow: f64,
    hits: Vec<(usize, f64)>,
}

impl<'a> Work<'a> {
    fn of(at: Instant<'a>) -> Self {
        Self { modes: at.before.clone(), at, blow: 0.0, hits: Vec::new() }
    }

    fn frozen(&self, modes: &Modes) -> Frozen<'a> {
        Frozen::new(self.at.compiled, &modes.behind(self.at.parameters))
    }

    fn view(&self, modes: &Modes) -> View {
        let Instant { t, q, v, .. } = &self.at;
        self.at.compiled.watch.at(&modes.behind(self.at.parameters)).view(*t, q, v).clone()
    }

    fn has_fired(&self, decider: Decider) -> bool {
        self.at.fired.contains(&decider)
    }

    /// Every mode that the state decides. A kink inside another is decided first, and another view
    /// taken: the outer function has a mode of the inner one in it.
    fn decide(&mut self) {
        for _ in 0..=self.modes.signs.len() {
            let view = self.view(&self.modes);
            let before = self.modes.clone();
            for (k, &u) in view.kinks.iter().enumerate() {
                if u.abs() > self.at.bands.kinks[k] {
                    self.modes.signs[k] = u.signum();
                } else if self.has_fired(Decider::Kink(k)) {
                    self.modes.signs[k] = -self.at.before.signs[k];
                }
            }
            for (k, seen) in view.contacts.iter().enumerate() {
                let watched = &self.at.compiled.watch.contacts[k];
                if watched.is_friction {
                    if !self.is_at_rest(seen.rate) {
                        self.modes.touches[k] = Touch::Sliding(seen.rate.signum());
                    }
                } else if !self.is_touching(k, seen.position)
                    || seen.rate < 0.0 && !self.is_at_rest(seen.rate)
                {
                    self.modes.touches[k] = Touch::Apart;
                }
            }
            if self.modes == before {
                break;
            }
        }
    }

    /// Contacts that hold are in touch; the run keeps them so.
    fn is_touching(&self, k: usize, penetration: f64) -> bool {
        self.modes.touches[k].is_closed() || penetration >= -SLACK * self.at.bands.position
    }

    fn is_at_rest(&self, rate: f64) -> bool {
        rate.abs() <= SLACK * self.at.bands.rate
    }

    /// Stops in touch, whether or not they are about to part.
    fn touching(&self, view: &View) -> Vec<usize> {
        let contacts = view.contacts.iter().enumerate();
        let is_stop = |k: usize| !self.at.compiled.watch.contacts[k].is_friction;
        let touching =
            contacts.filter(|(k, seen)| is_stop(*k) && self.is_touching(*k, seen.position));
        touching.map(|(k, _)| k).collect()
    }

    /// Stops that bodies run into, and prescribed rates that jump, change the velocities at once.
    /// False when there is neither.
    fn blow(&mut self) -> Result<bool, Unsettled> {
        let view = self.view(&self.modes);
        let touching = self.touching(&view);
        let (t, bands) = (self.at.t, &self.at.bands);
        let is_hit = |k: &usize| view.contacts[*k].rate > SLACK * bands.rate;
        let hits: Vec<usize> = touching.iter().copied().filter(is_hit).collect();
        let mut frozen = self.frozen(&self.modes_of_blow(&touching));

        // Onto the stops themselves, which the event has passed by rounding.
        let furthest = JUMP;
        onto_rows(&mut frozen, t, &mut self.at.q, &self.at.v, furthest)?;

        let rows: Vec<usize> =
            touching.iter().map(|&k| self.at.compiled.watch.contacts[k].row).collect();
        let at = frozen.matrices(t, &self.at.q, &self.at.v);
        let held = beside(&at, &rows);
        let (g, g_rate) = (at.jacobian.select_rows(&held), at.rate.select_rows(&held));
        let velocity = DVector::from_column_slice(&self.at.v);
        let jump = largest((&g * &velocity + &g_rate).as_slice());
        let has_jumped = jump > 10.0 * JUMP * (1.0 + largest(&self.at.v));
        if hits.is_empty() && !has_jumped {
            return Ok(false);
        }
        let jacobian = at.jacobian.select_rows(&rows);
        let restitution = self.restitutions(&touching, &view);
        let stops = Stops { jacobian: &jacobian, restitution: &restitution };
        let found = impact(&at.mass, &g, &g_rate, &stops, &velocity)
            .ok_or(Unsettled::Contacts { contacts: touching })?;
        let energy = |v: &DVector<f64>| 0.5 * (&at.mass * v).dot(v);
        self.blow += energy(&found.v) - energy(&velocity);
        self.hits.extend(hits.iter().map(|&k| (k, view.contacts[k].rate)));
        self.at.v = found.v.as_slice().to_vec();
        Ok(true)
    }

    /// All stops in touch hold; friction is bounded, so that it gives no impulse.
    fn modes_of_blow(&self, touching: &[usize]) -> Modes {
        let mut modes = self.modes.clone();
        for &k in touching {
            modes.touches[k] = Touch::Resting;
        }
        for touch in &mut modes.touches {
            if let Touch::Sticking(_) = touch {
                *touch = Touch::Sliding(0.0);
            }
        }
        modes
    }

    /// Restitution of each stop in touch; none where the bounces to come are too small to be seen.
    fn restitutions(&self, touching: &[usize], view: &View) -> Vec<f64> {
        let mut free = self.modes.clone();
        for &k in touching {
            free.touches[k] = Touch::Apart;
        }
        let pressing = self.accelerate(&free).map(|found| found.rates);
        let n_kinks = self.modes.signs.len();
        let [height, rate] = self.at.bands.rest;
        // Such bounces would be of rounding.
        let hidden = HIDDEN * self.at.bands.position;
        let restitution = |&k: &usize| {
            let seen = view.contacts[k];
            let speed = seen.first * seen.rate;
            // Left alone, the bodies come back with φ″ > 0 after a flight of height u²/2φ″.
            let pressing = pressing.as_ref().map_or(0.0, |rates| rates[n_kinks + k]);
            let square = speed * speed;
            let is_small = seen.rate <= rate && square <= 2.0 * pressing * height;
            let is_hidden = square <= 2.0 * pressing * hidden;
            if is_small || is_hidden { 0.0 } else { seen.first }
        };
        touching.iter().map(restitution).collect()
    }

    /// What the state leaves open, with the choices in order of preference.
    fn undecided(&self) -> Vec<Open> {
        let view = self.view(&self.modes);
        let mut open = Vec::new();
        for (k, &u) in view.kinks.iter().enumerate() {
            let decider = Decider::Kink(k);
            if u.abs() <= self.at.bands.kinks[k] || self.has_fired(decider) {
                let sign = self.modes.signs[k];
                let choices = vec![Choice::Sign(sign), Choice::Sign(-sign)];
                open.push(Open { decider, choices });
            }
        }
        for (k, seen) in view.contacts.iter().enumerate() {
            let watched = &self.at.compiled.watch.contacts[k];
            let decider = Decider::Contact(k);
            let before = self.at.before.touches[k];
            if !self.is_at_rest(seen.rate) {
                continue;
            }
            let mut touches = match before {
                _ if watched.is_friction => {
                    let place = match before {
                        Touch::Sticking(place) => place,
                        _ => seen.position,
                    };
                    vec![Touch::Sticking(place), Touch::Sliding(1.0), Touch::Sliding(-1.0)]
                }
                _ if self.is_touching(k, seen.position) => vec![Touch::Resting, Touch::Apart],
                _ => continue,
            };
            // What has just let go does not hold.
            if self.has_fired(decider) && before.is_closed() {
                touches.retain(|touch| !touch.is_closed());
            }
            open.push(Open { decider, choices: touches.into_iter().map(Choice::Touch).collect() });
        }
        open
    }

    /// The first consistent combination of choices.
    fn choose(self, open: &[Open]) -> Result<Settled, Unsettled> {
        let n_combinations = open
            .iter()
            .try_fold(1usize, |n, open| n.checked_mul(open.choices.len()))
            .unwrap_or(usize::MAX);
        for combination in 0..n_combinations.min(MAX_COMBINATIONS) {
            let mut modes = self.modes.clone();
            let mut rest = combination;
            for Open { decider, choices } in open {
                match (decider, choices[rest % choices.len()]) {
                    (&Decider::Kink(k), Choice::Sign(sign)) => modes.signs[k] = sign,
                    (&Decider::Contact(k), Choice::Touch(touch)) => modes.touches[k] = touch,
                    _ => (),
                }
                rest /= choices.len();
            }
            let Some(found) = self.accelerate(&modes) else { continue };
            if self.is_consistent(open, &modes, &found) {
                return Ok(self.landed(modes));
            }
        }
        let kink = open.iter().find_map(|open| match open.decider {
            Decider::Kink(kink) => Some(kink),
            Decider::Contact(_) => None,
        });
        let contacts = open.iter().filter_map(|open| match open.decider {
            Decider::Contact(contact) => Some(contact),
            Decider::Kink(_) => None,
        });
        Err(match kink {
            Some(kink) => Unsettled::Chatter { kink },
            None => Unsettled::Contacts { contacts: contacts.collect() },
        })
    }

    fn is_consistent(&self, open: &[Open], modes: &Modes, found: &Motion) -> bool {
        let view = self.view(modes);
        let n_kinks = modes.signs.len();
        let (a, lambda) = (largest(&found.a), largest(&found.lambda));
        let small = ROUNDING * a + f64::MIN_POSITIVE;
        open.iter().all(|open| match open.decider {
            Decider::Kink(k) => {
                let rate = found.rates[k];
                modes.signs[k] * rate >= -ROUNDING * rate.abs().max(found.scale)
            }
            Decider::Contact(k) => {
                let acceleration = found.rates[n_kinks + k];
                let force = found.lambda[self.at.compiled.watch.contacts[k].row];
                let limit = view.contacts[k].limit;
                match modes.touches[k] {
                    Touch::Resting => force >= -ROUNDING * lambda,
                    Touch::Apart => acceleration <= small,
                    Touch::Sticking(_) => force.abs() <= limit + ROUNDING * limit.max(lambda),
                    Touch::Sliding(sign) => sign * acceleration >= -small,
                }
            }
        })
    }

    fn accelerate(&self, modes: &Modes) -> Option<Motion> {
        let Instant { t, q, v, compiled, parameters, .. } = &self.at;
        let parameters = modes.behind(parameters);
        let mut frozen = Frozen::new(compiled, &parameters);
        let dependent = frozen.dependent(*t, q);
        let (a, lambda) = frozen.accelerations((*t, q, v), &dependent)?;
        let rates = compiled.watch.at(&parameters).rates(*t, q, v, &a).to_vec();
        let scale = largest(&a) + largest(v);
        Some(Motion { a, lambda, rates, scale })
    }

    /// The state on all rows that hold.
    fn landed(self, modes: Modes) -> Settled {
        let mut frozen = self.frozen(&modes);
        let Instant { t, mut q, mut v, .. } = self.at;
        let dependent = frozen.dependent(t, &q);
        frozen.project(t, &mut q, &mut v, &dependent);
        let none = || (vec![f64::NAN; q.len()], vec![f64::NAN; dependent.len()]);
        let (a, lambda) = frozen.accelerations((t, &q, &v), &dependent).unwrap_or_else(none);
        Settled { modes, q, v, a, lambda, dependent, blow: self.blow, hits: self.hits }
    }
}

/// Moves q onto all rows that hold, which must be near.
fn onto_rows(
    frozen: &mut Frozen<'_>,
    t: f64,
    q: &mut [f64],
    v: &[f64],
    furthest: f64,
) -> Result<(), Unsettled> {
    let gaps = frozen.matrices(t, q, v).constraint;
    let worst = gaps.iter().map(|g| g.abs()).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((row, by)) = worst.filter(|(_, by)| *by > furthest * largest(q).max(1.0)) {
        return Err(Unsettled::Jump { row, by });
    }
    let dependent = frozen.dependent(t, q);
    frozen.project(t, q, &mut v.to_vec(), &dependent);
    Ok(())
}

/// The independent rows beside the stops; which these are must not depend on the stops.
fn beside(at: &Matrices, stops: &[usize]) -> Vec<usize> {
    let mut joints = at.jacobian.clone();
    for &row in stops {
        joints.row_mut(row).fill(0.0);
    }
    let dependent = dependent_rows(&joints).dependent;
    (0..joints.nrows()).filter(|row| !dependent.contains(row)).collect()
}

/// Accelerations and what follows from them.
struct Motion {
    a: Vec<f64>,
    lambda: Vec<f64>,
    /// Rates of the switches, then accelerations of the contacts.
    rates: Vec<f64>,
    /// Size of velocities and accelerations.
    scale: f64,
}
