//! [`Solver`]: the motion of a text; equations are derived when more than values of parameters has changed.

use bksim_dae::Control;
use bksim_mbs::quantity::rate_unit;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::{Recording, Source, read_recorded};
use bksim_model::{Model, SolveOptions};
use bksim_scene::Scene;
use bksim_sim::pose::{Pose, Poses};
use bksim_sim::redundancy::UniquenessChange;
use bksim_sim::run::{Observer, Sample, Segment};
use bksim_sim::sensitivity::StateSensitivity;
use bksim_sim::{Mechanism, Simulation};
use serde_json::Value;

use crate::forces::{Forces, WrittenForces};
use crate::numbers::literal;
use crate::places::Places;
use crate::pose::{numbers, written};

/// Most frames of a motion that is shown.
const MOST_FRAMES: usize = 3000;
/// Number of poses from which the lengths of guides and springs come.
const N_POSES: usize = 100;

/// The last motion with its equations.
#[derive(Debug, Default)]
pub struct Solver {
    known: Option<Known>,
}

/// Equations of a text, for all values of its parameters.
#[derive(Debug)]
struct Known {
    /// The text without the values of parameters.
    skeleton: String,
    mechanism: Mechanism,
    simulation: Simulation,
    recording: Option<Recording>,
    varied: Vec<String>,
}

/// A motion as a page shows it.
#[derive(Debug)]
pub struct Moved {
    /// Times of the frames, s.
    pub times: Vec<f64>,
    /// For each frame the poses of all bodies, 18 numbers for each.
    pub frames: Vec<f64>,
    /// All that acts on the bodies.
    pub forces: WrittenForces,
    /// Curves: name, unit, a value for each frame.
    pub curves: Vec<(String, String, Vec<f64>)>,
    /// The shapes, their guides as long as the motion needs them.
    pub scene: Value,
    /// Why the motion ended early, if it did, and warnings.
    pub faults: Vec<Diagnostic>,
    /// Whether the equations were derived, or known.
    pub is_derived: bool,
}

/// Samples, each with the number of the modes that hold there; and the changes of what is unique.
#[derive(Default)]
struct Taking {
    samples: Vec<(Sample, usize)>,
    modes: Vec<Vec<f64>>,
    uniqueness: Vec<UniquenessChange>,
}

impl Observer for Taking {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.samples.push((sample.clone(), self.modes.len()));
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        if self.modes.last() != Some(&segment.modes) {
            self.modes.push(segment.modes.clone());
        }
    }

    fn uniqueness(&mut self, change: &UniquenessChange) {
        self.uniqueness.push(change.clone());
    }
}

impl Taking {
    /// The modes of a sample; at the start those of the first step.
    fn modes_of(&self, number: usize) -> &[f64] {
        self.modes.get(number.saturating_sub(1)).map_or(&[], Vec::as_slice)
    }

    /// The times in which the reaction of a joint is one of many solutions.
    fn shared(&self, joint: usize) -> Vec<[f64; 2]> {
        let ends = self.uniqueness.iter().skip(1).map(|change| change.t);
        let last = self.samples.last().map_or(0.0, |(sample, _)| sample.t);
        let of_joint = |change: &UniquenessChange| {
            let own = change.uniqueness.reactions.get(joint);
            own.is_some_and(|six| six[..3].contains(&false))
        };
        let spans = self.uniqueness.iter().zip(ends.chain([last]));
        spans.filter(|(change, _)| of_joint(change)).map(|(change, end)| [change.t, end]).collect()
    }
}

impl Solver {
    /// The motion of a text that was read as `model`.
    ///
    /// # Errors
    /// Faults of the equations and of the start, their places in `text`.
    pub fn solve(
        &mut self,
        text: &str,
        name: &str,
        model: Model,
    ) -> Result<Moved, Vec<Diagnostic>> {
        let is_derived = !self.takes_values(text, &model);
        if is_derived {
            self.known = None;
            self.known = Some(Known::derive(text, name, model)?);
            return self.run(is_derived);
        }
        let moved = self.run(is_derived);
        let is_faulty = moved.as_ref().map_or(true, |moved| !moved.faults.is_empty());
        if is_faulty {
            // Places of faults are those of the text that was derived.
            self.known = Some(Known::derive(text, name, model)?);
            return self.run(true);
        }
        moved
    }

    /// The motion of the equations that are known.
    fn run(&self, is_derived: bool) -> Result<Moved, Vec<Diagnostic>> {
        let Some(known) = &self.known else { return Err(Vec::new()) };
        let simulation = &known.simulation;
        let start = simulation.start().map_err(|rejected| rejected.0)?;
        let mut taking = Taking::default();
        let ended = simulation.run(&start, &mut taking, &|| false);
        let faults = ended.err().map(|failure| simulation.diagnose(&failure));
        Ok(known.moved(&taking, faults.into_iter().collect(), is_derived))
    }

    /// Gives the known equations the values of another text; false where it needs its own.
    fn takes_values(&mut self, text: &str, model: &Model) -> bool {
        let Some(known) = &mut self.known else { return false };
        let Some((skeleton, _)) = skeleton(text).filter(|(own, _)| *own == known.skeleton) else {
            return false;
        };
        let Some(recording) = &known.recording else { return false };
        let value =
            |name: &String| model.parameters.iter().find(|p| p.name == *name).map(|p| p.value);
        let Some(varied) = known.varied.iter().map(value).collect::<Option<Vec<f64>>>() else {
            return false;
        };
        // The reader has the last word on each of them.
        let own: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
        let mut replayed = vec![0.0; known.mechanism.parameters.len()];
        let mut solve: SolveOptions = known.mechanism.model.solve.clone();
        let is_same = recording.replay(&varied, &mut Vec::new(), &mut replayed, &mut solve)
            && replayed.len() == own.len()
            && replayed.iter().zip(&own).all(|(a, b)| a.to_bits() == b.to_bits());
        if is_same {
            known.skeleton = skeleton;
            known.mechanism.parameters.clone_from(&own);
            known.simulation.set_parameters(&own);
            known.simulation.set_options(&model.solve);
        }
        is_same
    }

    /// The mechanism of the last motion, with its equations.
    pub fn mechanism(&self) -> Option<&Mechanism> {
        self.known.as_ref().map(|known| &known.mechanism)
    }
}

impl Known {
    fn derive(text: &str, name: &str, model: Model) -> Result<Self, Vec<Diagnostic>> {
        let (skeleton, values) = skeleton(text).unwrap_or_default();
        let varied: Vec<String> = values.iter().map(|(name, _)| name.clone()).collect();
        let source = Source { overrides: &values, ..Source::new(text, name) };
        let recording = read_recorded(&source, &varied).1;
        let mechanism = Mechanism::derive(model, Vec::new()).map_err(|rejected| rejected.0)?;
        let simulation = mechanism.simulation().map_err(|rejected| rejected.0)?;
        Ok(Self { skeleton, mechanism, simulation, recording, varied })
    }

    fn moved(&self, taking: &Taking, faults: Vec<Diagnostic>, is_derived: bool) -> Moved {
        let Mechanism { model, system, parameters, .. } = &self.mechanism;
        let n = taking.samples.len();
        let every = n.div_ceil(MOST_FRAMES).max(1);
        let is_kept = |k: usize| k.is_multiple_of(every) || k + 1 == n;
        let kept = (0..n).filter(|k| is_kept(*k)).map(|k| &taking.samples[k]);
        let with_modes: Vec<(&Sample, &[f64])> =
            kept.map(|(sample, modes)| (sample, taking.modes_of(*modes))).collect();
        let samples: Vec<&Sample> = with_modes.iter().map(|(sample, _)| *sample).collect();
        let states = samples.iter().map(|sample| (&sample.q[..], &sample.v[..]));
        let poses: Vec<Vec<Pose>> = Poses::compile(model, system)
            .map(|poses| poses.at(parameters, states))
            .unwrap_or_default();
        let part = poses.len().div_ceil(N_POSES).max(1);
        let some: Vec<Vec<Pose>> = poses.iter().step_by(part).cloned().collect();
        let scene = Scene::of_motion(model, parameters, &some);
        let turned =
            scene.torques(&self.mechanism).ok().flatten().map_or_else(Vec::new, |mut torques| {
                let at = |s: &&Sample| (s.t, torques.at((s.t, &s.q, &s.v), &s.lambda).to_vec());
                scene.turn_times(&samples.iter().map(at).collect::<Vec<_>>())
            });
        let scene = written(&scene, &some, &turned, &|joint| taking.shared(joint));
        Moved {
            times: samples.iter().map(|sample| sample.t).collect(),
            frames: poses.iter().flat_map(|bodies| numbers(bodies)).collect(),
            forces: Forces::of(&self.mechanism).at(&self.mechanism, &with_modes),
            curves: self.curves(&samples),
            scene,
            faults,
            is_derived,
        }
    }

    /// Coordinates, their rates, energies, and the sizes of reactions.
    fn curves(&self, samples: &[&Sample]) -> Vec<(String, String, Vec<f64>)> {
        let Mechanism { model, system, .. } = &self.mechanism;
        let mut curves = Vec::new();
        let mut add = |name: String, unit: String, of: &dyn Fn(&Sample) -> f64| {
            curves.push((name, unit, samples.iter().map(|sample| of(sample)).collect()));
        };
        for (k, coordinate) in system.coordinates().iter().enumerate() {
            let unit = coordinate.kind.unit();
            add(coordinate.name.clone(), unit.to_owned(), &|sample| sample.q[k]);
        }
        for (k, coordinate) in system.coordinates().iter().enumerate() {
            let unit = rate_unit(coordinate.kind.unit(), 1);
            add(coordinate.rate_name.clone(), unit, &|sample| sample.v[k]);
        }
        add("kinetic energy".to_owned(), "J".to_owned(), &|sample| sample.energy.kinetic);
        add("potential energy".to_owned(), "J".to_owned(), &|sample| sample.energy.potential);
        for (k, joint) in model.joints.iter().enumerate() {
            add(format!("reaction of {}", joint.name), "N".to_owned(), &|sample| {
                let [x, y, z, ..] = sample.reactions[k];
                x.hypot(y).hypot(z)
            });
        }
        curves
    }
}

/// A text without the values of parameters that are numbers, and these.
fn skeleton(text: &str) -> Option<(String, Vec<(String, String)>)> {
    let places = Places::of_whole(text)?;
    let mut rest = String::with_capacity(text.len());
    let mut values = Vec::new();
    let mut at = 0;
    for place in places.below(&["parameters"]).filter(|place| place.path.len() == 2) {
        let value = places.quoted(place).unwrap_or(places.text_of(place));
        if literal(value).is_none() {
            continue;
        }
        rest.push_str(&text[at..place.span.start]);
        rest.push('\u{0}');
        at = place.span.end;
        values.push((place.path[1].clone(), value.to_owned()));
    }
    rest.push_str(&text[at..]);
    Some((rest, values))
}
