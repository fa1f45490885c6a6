//! A mode as a motion to look at: the mechanism to and fro about its equilibrium, as far as is asked for.
//!
//! ```text
//! q(t) = q₀ + a Re(y e^{iωt}), brought onto the constraints
//! ```
//!
//! Decay and growth are left out; what has no frequency takes a second.

use std::f64::consts::{PI, TAU};

use bksim_model::{Model, Space};
use bksim_sim::Mechanism;
use bksim_sim::run::Segment;

use crate::about::About;
use crate::assemblies::closed;
use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::modes::{Mode, modes_of};
use crate::rows::Rows;

/// The mode that is wanted as a motion.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ModeRequest {
    /// Number of the mode from one, in the order of [`modes`](crate::modes()).
    pub number: usize,
    /// The largest change of a body's angle, rad, or, where no body turns, of a position, m; a visible one unless given.
    pub amplitude: Option<f64>,
    /// The state that it is about.
    pub about: About,
}

/// One period of a mode.
#[derive(Debug)]
pub struct ModeMotion {
    /// The mechanism, its drives at rest.
    pub mechanism: Mechanism,
    /// The motion.
    pub segments: Vec<Segment>,
    /// The mode.
    pub mode: Mode,
    /// The amplitude, rad or m.
    pub amplitude: f64,
    /// Duration of the motion, s.
    pub period: f64,
}

/// Amplitude unless given, rad; and the largest way of a point, longest links.
const VISIBLE: [f64; 2] = [0.25, 0.2];
/// Polynomials in a period, and their degree.
const PIECES: [usize; 2] = [24, 5];

/// The motion of a mode of `model`.
///
/// # Errors
/// [`AnalysisError`] when there is no equilibrium, or no mode of this number.
pub fn mode_motion(model: Model, request: &ModeRequest) -> Result<ModeMotion, AnalysisError> {
    let mut loaded = Loaded::at_rest(model)?;
    let found = modes_of(&loaded, request.about)?;
    // Shown with drives that stay, in the frame that they move.
    if !loaded.model().drives.is_empty() {
        loaded = Loaded::at_rest(at_rest(loaded.mechanism.model))?;
    }
    let n = found.modes.len();
    let mode = request.number.checked_sub(1).and_then(|k| found.modes.get(k));
    let mode = mode.ok_or(AnalysisError::NoMode { number: request.number, n })?.clone();
    let amplitude = request.amplitude.unwrap_or_else(|| visible(&loaded, &mode));
    let omega = if mode.s[1] > 0.0 { mode.s[1] } else { TAU };
    let start = loaded.mechanism.start().ok();
    let dependent = start.map(|start| start.inactive_rows().to_vec()).unwrap_or_default();
    let n_own = loaded.mechanism.parameters.len();
    let modes = loaded.parameters[n_own..].to_vec();
    let mut rows = loaded.rows()?;
    let mut swing = Swing { rows: &mut rows, t: loaded.t, q: &found.q, mode: &mode, amplitude };

    // Polynomials through Chebyshev's points.
    let [n_pieces, degree] = PIECES;
    let period = TAU / omega;
    let mut segments = Vec::new();
    for piece in 0..n_pieces {
        let [from, to] = [piece, piece + 1].map(|k| TAU * k as f64 / n_pieces as f64);
        let mut values = Vec::new();
        for k in 0..=degree {
            let tau = ((2 * k + 1) as f64 * PI / (2 * degree + 2) as f64).cos();
            let phase = 0.5 * (from + to) + 0.5 * tau * (to - from);
            values.extend(swing.state(phase, omega));
        }
        let [t0, t1] = [from, to].map(|phase| loaded.t + phase / omega);
        let (modes, dependent) = (modes.clone(), dependent.clone());
        segments.push(Segment { t0, t1, values, modes, dependent });
    }
    Ok(ModeMotion { mechanism: loaded.mechanism, segments, mode, amplitude, period })
}

/// The model with its drives where they are at the start.
fn at_rest(mut model: Model) -> Model {
    let now = model.pool.float(model.solve.t_start);
    for drive in &mut model.drives {
        drive.motion = model.pool.substitute(drive.motion, &[(model.time, now)]);
    }
    model
}

/// An amplitude that is seen and that bodies can move by.
fn visible(loaded: &Loaded, mode: &Mode) -> f64 {
    let size = |[re, im]: &[f64; 2]| re.hypot(*im);
    let shape = || loaded.quantities.iter().zip(&mode.shape);
    let largest = |unit: &str| {
        let own = shape().filter(|(quantity, _)| quantity.unit == unit);
        own.map(|(_, c)| size(c)).fold(0.0, f64::max)
    };
    let way = VISIBLE[1] * loaded.size / largest("m");
    let is_planar = loaded.model().space == Space::Planar;
    let turn = VISIBLE[0] / largest("rad").max(if is_planar { 1e-9 } else { 1e-6 });
    way.min(turn)
}

/// A mechanism that swings in a mode.
struct Swing<'a> {
    rows: &'a mut Rows,
    t: f64,
    q: &'a [f64],
    mode: &'a Mode,
    amplitude: f64,
}

impl Swing<'_> {
    fn position(&mut self, phase: f64) -> Vec<f64> {
        let (sin, cos) = phase.sin_cos();
        let changes = self.mode.coordinates.iter().map(|[re, im]| re * cos - im * sin);
        let q: Vec<f64> =
            self.q.iter().zip(changes).map(|(q, change)| q + self.amplitude * change).collect();
        let x = self.rows.scaled(&q);
        // Farther than the mechanism can go it is drawn as the small motion goes on.
        closed(self.rows, self.t, x, &[]).map_or(q, |x| self.rows.unscaled(&x))
    }

    /// Positions and velocities.
    fn state(&mut self, phase: f64, omega: f64) -> Vec<f64> {
        const ASIDE: f64 = 1e-4;
        let q = self.position(phase);
        let [before, after] = [-ASIDE, ASIDE].map(|aside| self.position(phase + aside));
        let v = before.iter().zip(after).map(|(a, b)| omega * (b - a) / (2.0 * ASIDE));
        q.iter().copied().chain(v).collect()
    }
}
