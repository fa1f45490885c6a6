//! Questions that a drawing leaves open, with their places, the readings and what each means for the freedoms.

use bksim_cad::drawing::LengthUnit;
use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::distance;
use bksim_cad::units;
use bksim_model::diagnostic::Diagnostic;

use super::joint::{Joint, Kind, On};
use super::naming::Named;
use super::{Found, Options};
use crate::codes;

/// A question.
#[derive(Clone, PartialEq, Debug)]
pub struct Question {
    /// Key for answers: `drive`, `circle.4A`.
    pub key: String,
    /// In words.
    pub text: String,
    /// Handle of the entity it is about.
    pub handle: Option<u64>,
    /// Where that is.
    pub at: Option<Point>,
    /// Readings that may be meant; the first is taken until the question is answered.
    pub readings: Vec<Reading>,
    /// True if a number may be answered instead.
    pub takes_number: bool,
    /// The answer that was given.
    pub answer: Option<String>,
}

impl Question {
    /// The answer, or the reading that is taken without one.
    pub fn taken(&self) -> &str {
        match (&self.answer, self.readings.first()) {
            (Some(answer), _) => answer,
            (None, Some(first)) => &first.answer,
            (None, None) => "",
        }
    }

    fn new(key: &str, text: String) -> Self {
        Self {
            key: key.to_owned(),
            text,
            handle: None,
            at: None,
            readings: Vec::new(),
            takes_number: false,
            answer: None,
        }
    }

    fn about(mut self, handle: Option<u64>, at: Point) -> Self {
        self.handle = handle;
        self.at = Some(at);
        self
    }

    fn reading(mut self, answer: &str, meaning: impl Into<String>, freedoms: Option<i64>) -> Self {
        let (answer, meaning) = (answer.to_owned(), meaning.into());
        self.readings.push(Reading { answer, meaning, freedoms });
        self
    }

    fn number(mut self) -> Self {
        self.takes_number = true;
        self
    }
}

/// One reading of what a question is about.
#[derive(Clone, PartialEq, Debug)]
pub struct Reading {
    /// Answer that chooses the reading.
    pub answer: String,
    /// In words.
    pub meaning: String,
    /// Freedoms of the mechanism then, where it changes them.
    pub freedoms: Option<i64>,
}

/// Questions, and what follows from their answers.
#[derive(Clone, Default, Debug)]
pub(super) struct Asked {
    pub(super) questions: Vec<Question>,
    /// Joints that are there only by an answer; whether it was given.
    pub(super) joints: Vec<(Joint, bool)>,
    /// Lone circles that are masses: pin, body, kg.
    pub(super) masses: Vec<(usize, usize, f64)>,
    pub(super) mm_per_unit: f64,
    pub(super) unit: Option<&'static str>,
}

impl Asked {
    /// The answer of a question, or its first reading.
    pub(super) fn taken(&self, key: &str) -> Option<&str> {
        self.questions.iter().find(|question| question.key == key).map(Question::taken)
    }

    /// The answer of a question, where one was given.
    pub(super) fn answer(&self, key: &str) -> Option<&str> {
        self.questions.iter().find(|question| question.key == key)?.answer.as_deref()
    }
}

pub(super) fn too_many(count: usize, limit: usize, what: &str) -> Diagnostic {
    let message =
        format!("the drawing has {what} {count}; at most {limit} are read as a mechanism");
    let help =
        "save the mechanism without its surroundings as a drawing of its own, and import that";
    Diagnostic::error(codes::TOO_MANY_STROKES, message).help(help)
}

pub(super) fn no_joints(found: &Found) -> Diagnostic {
    let circles = found.pins.len();
    let message = "no joints are found in the drawing".to_owned();
    Diagnostic::error(codes::NO_MECHANISM, message)
        .note(format!(
            "small circles {circles}, borders of the ground {}, outlines and lines of bodies {}",
            found.bases.len(),
            found.pieces.rings.len() + found.pieces.lines.len(),
        ))
        .help("draw a circle where bodies turn on each other, lines or outlines between the circles, and hatch the ground")
}

/// All questions, with the answers of the user.
pub(super) fn ask(
    found: &Found,
    named: &Named,
    wheels: Vec<Question>,
    (unit, has_unit): (LengthUnit, bool),
    options: &Options,
) -> Result<Asked, Vec<Diagnostic>> {
    let mut asked = Asked { unit: has_unit.then_some(unit.name), ..Asked::default() };
    if !has_unit {
        let mut question = Question::new("unit", "the file states no unit of length".to_owned());
        for name in ["mm", "cm", "in", "m"] {
            question = question.reading(name, format!("one unit of the drawing is 1 {name}"), None);
        }
        asked.questions.push(question);
    }
    ask_scale(found, &mut asked);
    ask_circles(found, named, &mut asked);
    ask_slots(found, &mut asked);
    asked.questions.extend(wheels);
    ask_drive(found, &mut asked);
    asked.questions.push(
        Question::new("gravity", "which way the weight acts".to_owned())
            .reading("none", "it is left out, as in a plane that lies level", None)
            .reading("down", "downwards on the sheet, 9.81 m/s²", None),
    );
    let text = "the drawing states no masses of the bodies".to_owned();
    asked.questions.push(
        Question::new("mass", text)
            .reading("1", "each body has 1 kg, spread along it; any other number of kilograms may be answered", None)
            .number(),
    );
    for (name, spring) in named.springs.iter().zip(&found.springs) {
        let text = format!("the drawing states no stiffness of the spring `{name}`");
        let handle = handle_of(found, &spring.from);
        asked.questions.push(
            Question::new(&format!("stiffness.{name}"), text)
                .about(handle, super::naming::middle(spring))
                .reading("1000", "it has 1000 N/m; any other number may be answered", None)
                .number(),
        );
    }
    answer(&mut asked, options)?;
    settle(found, &mut asked, unit, has_unit);
    Ok(asked)
}

/// Handle of the first of some strokes that has one.
pub(super) fn handle_of(found: &Found, from: &[usize]) -> Option<u64> {
    from.iter().find_map(|&idx| found.sheet.strokes[idx].location.handle).map(|handle| handle.0)
}

/// A ratio of true to drawn lengths that scales are stated by, near a measured one.
fn usual(ratio: f64) -> Option<f64> {
    const STEPS: [f64; 15] =
        [1.0, 2.0, 2.5, 3.0, 4.0, 5.0, 10.0, 15.0, 20.0, 25.0, 50.0, 100.0, 200.0, 500.0, 1000.0];
    let all = STEPS.into_iter().flat_map(|step| [step, 1.0 / step]);
    all.into_iter().find(|step| (ratio / step - 1.0).abs() < 0.02)
}

fn ask_scale(found: &Found, asked: &mut Asked) {
    let shown = found.notes.ratio().map(|ratio| usual(ratio).unwrap_or(ratio));
    let stated = found.notes.stated_scale.map(|(scale, words)| (1.0 / scale, words));
    asked.mm_per_unit = shown.or(stated.map(|(ratio, _)| ratio)).unwrap_or(1.0);
    let Some((by_title, words)) = stated else { return };
    let words = &found.sheet.words[words];
    let by_lengths = shown.unwrap_or(1.0);
    if (by_title / by_lengths - 1.0).abs() < 0.02 {
        return;
    }
    let says = if shown.is_some() { "the dimensions" } else { "the drawing without dimensions" };
    let text = format!("`{}` of the sheet and {says} do not agree on the scale", words.text);
    let question = Question::new("scale", text)
        .about(words.location.handle.map(|handle| handle.0), words.at)
        .reading(
            "dimensions",
            format!("one unit drawn is {by_lengths} units, as the numbers of dimensions have it"),
            None,
        )
        .reading("sheet", format!("one unit drawn is {by_title} units, as the sheet has it"), None)
        .number();
    asked.mm_per_unit = by_lengths;
    asked.questions.push(question);
}

/// Circles on one body alone: holes, marks, pins or masses.
fn ask_circles(found: &Found, named: &Named, asked: &mut Asked) {
    let free = found.freedoms(&[]);
    let near = found.pieces.tolerance;
    for (idx, pin) in found.pins.iter().enumerate() {
        let holders: Vec<usize> = (0..found.bodies.all.len())
            .filter(|&k| found.bodies.all[k].pins.contains(&idx))
            .collect();
        let is_joined = found.joints.iter().any(|joint| distance(joint.centre(), pin.at) < near);
        let [body] = holders[..] else { continue };
        if is_joined || found.is_fixed[idx] {
            continue;
        }
        let name = &found.bodies.all[body].name;
        let handle = handle_of(found, &pin.from);
        let key = match (&named.letters[idx], handle) {
            (Some(letter), _) => format!("circle.{letter}"),
            (None, Some(handle)) => format!("circle.{handle:X}"),
            (None, None) => format!("circle.{}", idx + 1),
        };
        let joint = Joint {
            kind: Kind::Pin,
            at: pin.at,
            on: vec![On::Ground, On::Body(body)],
            name: format!("pin_{}", key.trim_start_matches("circle.").to_lowercase()),
            from: pin.from.clone(),
        };
        let has_spring = found
            .springs
            .iter()
            .any(|spring| spring.ends.iter().any(|end| distance(*end, pin.at) < 2.0 * near));
        let fixed = found.freedoms(std::slice::from_ref(&joint));
        let text = format!("a circle on `{name}` where no other body is");
        let mut question = Question::new(&key, text).about(handle, pin.at);
        let reach = 8.0 * found.pieces.pin;
        let mass = named
            .masses
            .iter()
            .find(|(_, words)| distance(found.sheet.words[*words].at, pin.at) < reach);
        let hole = if has_spring { "the eye of the spring" } else { "a hole or a mark" };
        question = question.reading("hole", format!("{hole}: it joins nothing"), Some(free));
        if let Some((mass, _)) = mass {
            question =
                question.reading("mass", format!("a mass of {mass} kg on `{name}`"), Some(free));
            asked.masses.push((idx, body, *mass));
        }
        question = question.reading("pin", format!("a pin of `{name}` on the ground"), Some(fixed));
        asked.joints.push((joint, false));
        asked.questions.push(question);
    }
}

/// Bodies that may be the ground, that with the most joints first: those that no gear or slot measures.
pub(super) fn by_joints(found: &Found) -> Vec<usize> {
    let is_plain = |idx: &usize| {
        let joints = found.joints.iter().filter(|joint| joint.on.contains(&On::Body(*idx)));
        joints.clone().all(|joint| matches!(joint.kind, Kind::Pin | Kind::Slide { .. }))
    };
    let count = |idx: &usize| {
        found.joints.iter().filter(|joint| joint.on.contains(&On::Body(*idx))).count()
    };
    let mut all: Vec<usize> = (0..found.bodies.all.len()).filter(is_plain).collect();
    if all.is_empty() {
        all = (0..found.bodies.all.len()).collect();
    }
    all.sort_by_key(|idx| std::cmp::Reverse(count(idx)));
    all
}

/// Which body stands still, where nothing is hatched.
pub(super) fn about_ground(found: &Found) -> Question {
    let text = "nothing is hatched and no bearing is drawn: which body stands still".to_owned();
    let mut question = Question::new("ground", text);
    for idx in by_joints(found) {
        let body = &found.bodies.all[idx];
        let handle = handle_of(found, &body.from);
        let answer = handle.map_or(format!("{}", idx + 1), |handle| format!("{handle:X}"));
        let [x, y] = super::bodies::anchor(body);
        let meaning = format!("the {} at ({x:.3}, {y:.3})", body.look.name());
        question = question.reading(&answer, meaning, None);
    }
    question
}

/// Answer that joins a wheel to a link.
pub(super) const WITH_LINK: &str = "with_link";

/// True if the wheel at a pin turns on its own, or with the link that ends there; `free` and `fixed` are the freedoms then.
pub(super) fn about_wheel(found: &Found, pin: usize, [free, fixed]: [i64; 2]) -> Question {
    let it = &found.pins[pin];
    let handle = handle_of(found, &it.from);
    let key = handle.map_or(format!("{}", pin + 1), |handle| format!("{handle:X}"));
    let text = "a wheel and a link have one pin".to_owned();
    let question = Question::new(&format!("wheel.{key}"), text).about(handle, it.at);
    let alone =
        |question: Question| question.reading("alone", "the wheel turns on its own", Some(free));
    let with_link = |question: Question| {
        question.reading(WITH_LINK, "the wheel turns with the link", Some(fixed))
    };
    // A machine that one motor drives is likelier than one that is locked or loose.
    if fixed == 1 && free != 1 { alone(with_link(question)) } else { with_link(alone(question)) }
}

fn ask_slots(found: &Found, asked: &mut Asked) {
    let near = found.pieces.tolerance;
    for joint in found.joints.iter().filter(|joint| matches!(joint.kind, Kind::Slot { .. })) {
        let slot = found
            .bodies
            .slots
            .iter()
            .find(|slot| super::pieces::to_segment(joint.at, slot.ends) < near);
        let pin = found.pins.iter().find(|pin| distance(pin.at, joint.at) < near);
        let (Some(slot), Some(pin)) = (slot, pin) else { continue };
        if pin.radii.iter().any(|radius| radius / slot.half > 0.95) {
            continue;
        }
        let free = found.freedoms(&[]);
        let text = format!("whether a block is between pin `{}` and its slot", joint.name);
        let question = Question::new(&format!("slot.{}", joint.name), text)
            .about(handle_of(found, &joint.from), joint.at)
            .reading("pin", "the pin touches the sides of the slot", Some(free))
            .reading("block", "a block turns on the pin and slides in the slot: a body more, with the same freedoms", Some(free));
        asked.questions.push(question);
    }
}

/// Joints on the ground that may be driven: name in the model, index, and the body that is driven.
pub(super) fn drivable(found: &Found) -> Vec<(String, usize, usize)> {
    let mut all = Vec::new();
    for (idx, joint) in found.joints.iter().enumerate() {
        let is_drivable = matches!(joint.kind, Kind::Pin | Kind::Slide { .. });
        if !is_drivable || joint.on[0] != On::Ground {
            continue;
        }
        for (k, on) in joint.on[1..].iter().enumerate() {
            if let On::Body(body) = on {
                all.push((joint.part_name(k), idx, *body));
            }
        }
    }
    all
}

fn ask_drive(found: &Found, asked: &mut Asked) {
    let free = found.freedoms(&[]);
    if free < 1 {
        return;
    }
    let mut question = Question::new("drive", "what drives the mechanism".to_owned()).reading(
        "none",
        "nothing: it moves by its weight and springs alone",
        Some(free),
    );
    for (joint, idx, body) in drivable(found) {
        let name = &found.bodies.all[body].name;
        let meaning = match found.joints[idx].kind {
            Kind::Pin => format!("`{name}` turns about `{joint}`"),
            _ => format!("`{name}` is moved along `{joint}`"),
        };
        question = question.reading(&joint, meaning, Some(free - 1));
    }
    asked.questions.push(question);
}

/// Puts the answers to their questions.
fn answer(asked: &mut Asked, options: &Options) -> Result<(), Vec<Diagnostic>> {
    let mut faults = Vec::new();
    for (key, value) in &options.answers {
        let Some(question) = asked.questions.iter_mut().find(|question| question.key == *key)
        else {
            let keys: Vec<String> =
                asked.questions.iter().map(|it| format!("`{}`", it.key)).collect();
            let message = format!("the drawing leaves no question `{key}`");
            let help = format!("answer one of these: {}", keys.join(", "));
            faults.push(Diagnostic::error(codes::NO_QUESTION, message).help(help));
            continue;
        };
        let is_number = question.takes_number
            && value.parse::<f64>().is_ok_and(|number| number > 0.0 && number.is_finite());
        if is_number || question.readings.iter().any(|reading| reading.answer == *value) {
            question.answer = Some(value.clone());
            continue;
        }
        let known: Vec<String> =
            question.readings.iter().map(|it| format!("`{}`", it.answer)).collect();
        let message = format!("the question `{key}` has no answer `{value}`");
        let number = if question.takes_number { " or a number above zero" } else { "" };
        let help = format!("answer {}{number}", known.join(", "));
        faults.push(Diagnostic::error(codes::NO_ANSWER, message).help(help));
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Follows the answers that change what was found.
fn settle(found: &Found, asked: &mut Asked, unit: LengthUnit, has_unit: bool) {
    let answered = asked.answer("unit").and_then(units::by_name);
    let metres = answered.map_or(if has_unit { unit.metres } else { 1e-3 }, |unit| unit.metres);
    let ratio = match asked.answer("scale") {
        Some("sheet") => found.notes.stated_scale.map_or(1.0, |(scale, _)| 1.0 / scale),
        Some("dimensions") | None => asked.mm_per_unit,
        Some(number) => number.parse().unwrap_or(1.0),
    };
    // Inches in millimetres are 25.4 to the last digit.
    asked.mm_per_unit = ((metres * ratio * 1e3) * 1e12).round() / 1e12;
    let circles: Vec<bool> = asked
        .questions
        .iter()
        .filter(|question| question.key.starts_with("circle."))
        .map(|question| question.answer.as_deref() == Some("pin"))
        .collect();
    for (joint, is_pin) in asked.joints.iter_mut().zip(circles) {
        joint.1 = is_pin;
    }
    let is_mass = |pin: usize, asked: &Asked| {
        let at = found.pins[pin].at;
        asked.questions.iter().any(|it| it.at == Some(at) && it.answer.as_deref() == Some("mass"))
    };
    let masses = std::mem::take(&mut asked.masses);
    asked.masses = masses.into_iter().filter(|(pin, _, _)| is_mass(*pin, asked)).collect();
}
