//! Trials of the start: linkages with all their assemblies, and whether the one that was meant is
//! found.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use bksim::{Mechanism, Simulation};
use serde_json::Value;

/// How a start is asked for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Trial {
    /// One coordinate guessed exactly.
    Exact,
    /// One coordinate guessed 10° off.
    Off,
    /// The crank's angle alone.
    NoGuess,
    /// One coordinate stated exactly.
    Stated,
}

/// The outcome of a trial.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Verdict {
    /// The assembly that was meant.
    Right,
    /// Another one, or none of the list.
    Wrong,
    /// No start.
    Refused,
}

/// One trial of one linkage.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// The linkage.
    pub(crate) id: String,
    /// Class of the outcome.
    pub(crate) class: String,
    /// How the start was asked for.
    pub(crate) trial: Trial,
    /// The text written for that, or the fault.
    pub(crate) statement: String,
    /// The outcome.
    pub(crate) verdict: Verdict,
    /// The start alone.
    pub(crate) time: Duration,
}

/// A joint, or the angle of a body, that can be guessed.
#[derive(Clone, Debug)]
struct Coordinate {
    /// Key in an assembly.
    key: String,
    /// Name in `[initial]`, and the word for its value there.
    name: String,
    word: &'static str,
    /// A slide's rod, m; of an angle none.
    rod: Option<f64>,
}

/// A linkage with all its assemblies.
struct Linkage {
    id: String,
    model: String,
    crank: String,
    coordinates: Vec<Coordinate>,
    /// Values by the names that coordinates of the system may have.
    assemblies: Vec<BTreeMap<String, f64>>,
}

/// All trials of every `stride`th linkage of a file, from `first` on; of each linkage every coordinate,
/// or `some` of them that differ from one linkage to the next.
pub(crate) fn trials(
    text: &str,
    (first, stride): (usize, usize),
    some: Option<usize>,
) -> Vec<Outcome> {
    let linkages: Vec<Value> = serde_json::from_str(text).expect("a file of linkages");
    let mut outcomes = Vec::new();
    for (linkage_idx, value) in linkages.iter().enumerate().skip(first).step_by(stride) {
        let linkage = Linkage::read(value);
        linkage.without_guess(&mut outcomes);
        let n = linkage.coordinates.len();
        let mut n_left = some.unwrap_or(n);
        for k in 0..n {
            let coordinate = &linkage.coordinates[(k + 5 * linkage_idx) % n];
            if n_left > 0 && linkage.with(coordinate, &mut outcomes) {
                n_left -= 1;
            }
        }
    }
    outcomes
}

impl Linkage {
    fn read(value: &Value) -> Self {
        let text = |value: &Value| value.as_str().expect("a text").to_owned();
        let crank = text(&value["crank"]["joint"]);
        let angle = value["crank"]["angle"].as_f64().expect("a number");
        let all = value["assemblies"].as_array().expect("assemblies");
        let first = &all[0];
        let slide = value["construction"].as_array().into_iter().flatten();
        let rod = slide.filter(|step| step[0] == "slide").find_map(|step| step[2].as_f64());

        // Joints besides the crank's, and angles of bodies.
        let is_chosen = |name: &str| match value["coordinates"].as_array() {
            Some(chosen) => chosen.iter().any(|c| c == name),
            None => name != crank,
        };
        let joints = first["joints"].as_object().expect("joints").keys();
        let joint = |name: &String| {
            let is_slide = name == "guide"
                || text(&value["model"]).contains(&format!("{name} = {{ type = \"prismatic\""));
            Coordinate {
                key: format!("t_{name}"),
                name: name.clone(),
                word: if is_slide { "position" } else { "angle" },
                rod: is_slide.then(|| rod.unwrap_or(1.0)),
            }
        };
        let mut coordinates: Vec<Coordinate> =
            joints.filter(|name| is_chosen(name)).map(joint).collect();
        let bodies = first["bodies"].as_object().into_iter().flat_map(|bodies| bodies.keys());
        coordinates.extend(bodies.filter(|name| *name != "crank").map(|name| Coordinate {
            key: format!("a_{name}"),
            name: name.clone(),
            word: "angle",
            rod: None,
        }));
        let model = text(&value["model"]);
        Self {
            id: text(&value["id"]),
            model: format!("{model}\n[initial]\n{crank} = {{ angle = {angle:?} }}\n"),
            crank,
            coordinates,
            assemblies: all.iter().map(assembly).collect(),
        }
    }

    /// A simulation with one more statement.
    fn simulation(&self, statement: &str) -> Simulation {
        let text = format!("{}{statement}\n", self.model);
        let mechanism = Mechanism::from_toml(&text, &self.id).expect("a sound model");
        mechanism.simulation().expect("it compiles")
    }

    fn without_guess(&self, outcomes: &mut Vec<Outcome>) {
        let simulation = self.simulation("");
        outcomes.push(self.judge(&simulation, Trial::NoGuess, String::new(), &|_| true));
    }

    /// The trials of one coordinate in all assemblies that it tells from the others; whether there
    /// are some.
    fn with(&self, coordinate: &Coordinate, outcomes: &mut Vec<Outcome>) -> bool {
        let [off, near] =
            [10.0_f64, 5.0].map(|degrees| degrees.to_radians() * coordinate.rod.unwrap_or(1.0));
        let value = |assembly: &BTreeMap<String, f64>| assembly[&coordinate.key];
        let apart = |a: f64, b: f64| coordinate.apart(a, b);
        let told = self.assemblies.iter().map(value).filter(|&chosen| {
            let others = self.assemblies.iter().map(|other| apart(value(other), chosen));
            others.into_iter().all(|apart| apart < 1e-6 || apart >= near)
        });
        let told: Vec<f64> = told.collect();
        let Coordinate { name, word, .. } = coordinate;
        let Some(first) = told.first() else { return false };
        let mut guessed =
            self.simulation(&format!("{name} = {{ guess = {{ {word} = {first:?} }} }}"));
        let mut stated = self.simulation(&format!("{name} = {{ {word} = {first:?} }}"));
        for &chosen in &told {
            let is_chosen =
                |assembly: &BTreeMap<String, f64>| apart(value(assembly), chosen) < 1e-6;
            let mut judge = |simulation: &mut Simulation, trial: Trial, given: f64| {
                simulation.set_initial(&[(1, given)]);
                let statement = format!("{name} = {given:?}");
                outcomes.push(self.judge(simulation, trial, statement, &is_chosen));
            };
            judge(&mut guessed, Trial::Exact, chosen);
            judge(&mut stated, Trial::Stated, chosen);
            // To the side where the chosen assembly stays the nearest.
            let stays = |guess: f64| {
                let mut others = self.assemblies.iter().filter(|other| !is_chosen(other));
                others.all(|other| apart(value(other), guess) >= off + near)
            };
            let guess = [chosen + off, chosen - off].into_iter().find(|&guess| stays(guess));
            if let Some(guess) = guess {
                judge(&mut guessed, Trial::Off, guess);
            }
        }
        true
    }

    /// The start of one trial against the assemblies.
    fn judge(
        &self,
        simulation: &Simulation,
        trial: Trial,
        statement: String,
        is_meant: &dyn Fn(&BTreeMap<String, f64>) -> bool,
    ) -> Outcome {
        const CLOSE: f64 = 1e-5;
        let begin = Instant::now();
        let start = simulation.start();
        let time = begin.elapsed();
        let (statement, verdict) = match start {
            Err(rejected) => (format!("{statement}: {rejected}"), Verdict::Refused),
            Ok(start) => {
                let names = simulation.compiled().coordinates.iter();
                let found: Vec<(&str, f64)> =
                    names.map(|c| c.name.as_str()).zip(start.q.iter().copied()).collect();
                let is_it = |assembly: &&BTreeMap<String, f64>| {
                    found.iter().all(|&(name, q)| match assembly.get(name) {
                        Some(&value) if is_length(name) => (q - value).abs() < CLOSE,
                        Some(&value) => wrapped(q - value).abs() < CLOSE,
                        None => true,
                    })
                };
                let met = self.assemblies.iter().find(is_it);
                // What is stated holds to the last digit.
                let own = ["t_NAME", "NAME_angle"].map(|key| key.replace("NAME", &self.crank));
                let crank = found.iter().find(|(name, _)| own.iter().any(|own| own == name));
                let holds = crank.is_none_or(|&(_, q)| q == self.assemblies[0][&own[0]]);
                let is_right = holds && met.is_some_and(is_meant);
                let said = if is_right { statement } else { format!("{statement}: {found:?}") };
                (said, if is_right { Verdict::Right } else { Verdict::Wrong })
            }
        };
        let class = self.id.rsplit_once('-').map_or(self.id.as_str(), |(class, _)| class);
        let (id, class) = (self.id.clone(), class.to_owned());
        Outcome { id, class, trial, statement, verdict, time }
    }
}

impl Coordinate {
    /// How far two of its values are from each other.
    fn apart(&self, a: f64, b: f64) -> f64 {
        if self.rod.is_some() { (a - b).abs() } else { wrapped(a - b).abs() }
    }
}

/// Values of an assembly by all names that a system may have for them.
fn assembly(value: &Value) -> BTreeMap<String, f64> {
    let number = |value: &Value| value.as_f64().expect("a number");
    let mut values = BTreeMap::new();
    for (name, joint) in value["joints"].as_object().expect("joints") {
        for key in ["t_NAME", "s_NAME", "NAME_angle", "NAME_position"] {
            values.insert(key.replace("NAME", name), number(joint));
        }
    }
    for (name, pose) in value["bodies"].as_object().into_iter().flatten() {
        for (k, axis) in ["x", "y", "a"].iter().enumerate() {
            values.insert(format!("{axis}_{name}"), number(&pose[k]));
        }
    }
    values
}

/// Whether a coordinate of this name is a length.
fn is_length(name: &str) -> bool {
    ["x_", "y_", "s_"].iter().any(|start| name.starts_with(start)) || name.ends_with("_position")
}

/// Angle in [−π, π].
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}
