//! A drawing without attributes as a mechanism.
//!
//! ```text
//! DXF, DWG, SVG → Sheet → lines, bows, circles, rings → frame, dimensions, ground, springs taken away
//!                   pieces                        notes, hatching, springs
//!         → bodies → joints → freedoms, questions → Understanding → text of a model, picture
//!           bodies   joints   mobility  questions                    model           picture
//! ```
//!
//! What a draughtsman draws in one way only is read: circles at ends are pins, hatching is ground, touching pitch
//! circles mesh. What has two readings is a [`Question`] with its place and what each reading means for the freedoms;
//! a line that belongs to nothing stays a line.

mod attached;
mod bodies;
mod cams;
mod hatching;
mod joint;
mod joints;
mod loops;
mod mobility;
mod model;
mod naming;
mod notes;
mod outlines;
mod picture;
mod pieces;
mod questions;
mod report;
mod springs;
mod stands;
mod straighten;
mod svg;
mod wheels;

use bksim_cad::drawing::{LengthUnit, Location};
use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::distance;
use bksim_cad::open::{OpenOptions, Opened, open};
use bksim_cad::read::{Sheet, sheet};
use bksim_cad::units;
use bksim_model::diagnostic::Diagnostic;

use bodies::{Bodies, Pin};
use hatching::Base;
use joint::{Joint, Kind, On, Scene};
use model::Writing;
use naming::Named;
use notes::Notes;
use pieces::Pieces;
use questions::Asked;
use report::{elements, found_bodies, found_joint, left_out};
use springs::Zigzag;

pub use model::Material;
pub use questions::{Question, Reading};

use crate::names::Names;

/// Most lines, arcs and curves that are read: a mechanism has hundreds.
const MAX_STROKES: usize = 2000;

/// Comments and declarations before the first element of a picture, bytes.
const MAX_HEADING: usize = 16 << 10;

/// Most texts, and most bodies.
const MAX_WORDS: usize = 2000;
const MAX_BODIES: usize = 100;

/// Options of the user about a drawing.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Options {
    /// The length of one unit; that of the drawing unless given.
    pub unit: Option<LengthUnit>,
    /// Answers to questions, by their keys.
    pub answers: Vec<(String, String)>,
    /// Material of bodies with outlines.
    pub material: Option<Material>,
}

/// A body that was found.
#[derive(Clone, PartialEq, Debug)]
pub struct FoundBody {
    /// Name in the model.
    pub name: String,
    /// The text next to it.
    pub label: Option<String>,
    /// `bar`, `plate`, `block`, `wheel` or `lines`.
    pub drawn_as: &'static str,
    /// Handles of its entities.
    pub handles: Vec<u64>,
}

/// A joint that was found.
#[derive(Clone, PartialEq, Debug)]
pub struct FoundJoint {
    /// Name in the model.
    pub name: String,
    /// `pin`, `slide`, `pin in slot`, `gear`, `gear inside`, `rack` or `cam`.
    pub kind: &'static str,
    /// In the units of the file.
    pub at: Point,
    /// Names of the bodies, `ground` first.
    pub bodies: Vec<String>,
    /// Direction of slides, slots and racks.
    pub axis: Option<Point>,
    /// Rate of the second wheel over that of the first.
    pub ratio: Option<f64>,
    /// Pitch radius of a pinion.
    pub radius: Option<f64>,
    /// True if it is there only if a question is answered so.
    pub is_asked: bool,
    /// Handles of its entities.
    pub handles: Vec<u64>,
}

/// A spring or a mass.
#[derive(Clone, PartialEq, Debug)]
pub struct Element {
    /// Name in the model.
    pub name: String,
    /// `spring` or `mass`.
    pub kind: &'static str,
    /// Both ends of a spring, the place of a mass.
    pub ends: Vec<Point>,
    /// Bodies at the ends.
    pub bodies: Vec<String>,
    /// Mass where a text states it, kg.
    pub mass: Option<f64>,
}

/// All that was understood of a drawing.
#[derive(Clone, PartialEq, Debug)]
pub struct Understanding {
    /// Bodies other than the ground.
    pub bodies: Vec<FoundBody>,
    /// Joints, those that are asked last.
    pub joints: Vec<FoundJoint>,
    /// Springs and masses.
    pub elements: Vec<Element>,
    /// Freedoms, without what is asked.
    pub mobility: i64,
    /// True length of one unit of the file, mm.
    pub mm_per_unit: f64,
    /// The file's unit of length; `None` where it has none and millimetres are assumed.
    pub unit: Option<&'static str>,
    /// Questions that the drawing leaves open.
    pub questions: Vec<Question>,
    /// Entities that are no part of the mechanism, in words, with their places.
    pub left_out: Vec<(String, Vec<Location>)>,
    /// The text of the model.
    pub model: String,
    /// Records of extended data that make the drawing itself the model, or why it cannot be.
    pub records: Result<Vec<bksim_cad::patch::Edit>, Diagnostic>,
    /// The drawing with what was understood over it, as SVG.
    pub picture: String,
    /// Warnings of the drawing itself.
    pub warnings: Vec<Diagnostic>,
}

/// Everything between the stages.
struct Found {
    sheet: Sheet,
    pieces: Pieces,
    notes: Notes,
    pins: Vec<Pin>,
    is_fixed: Vec<bool>,
    bases: Vec<Base>,
    bodies: Bodies,
    joints: Vec<Joint>,
    springs: Vec<Zigzag>,
    /// Extent of the joints.
    size: f64,
}

/// Reads a drawing; `name` is that of the file.
///
/// # Errors
/// Faults of the drawing, with spans in [`bksim_cad::tags::excerpt_text`] of the same bytes.
pub fn understand(
    name: &str,
    bytes: &[u8],
    options: &Options,
) -> Result<Understanding, Vec<Diagnostic>> {
    let Paper { sheet, unit, has_unit, own_unit, warnings } = paper(bytes, options)?;
    let n_strokes = sheet.strokes.iter().map(|stroke| stroke.path.curves.len()).sum();
    for (count, limit, what) in
        [(n_strokes, MAX_STROKES, "strokes"), (sheet.words.len(), MAX_WORDS, "texts")]
    {
        if count > limit {
            return Err(vec![questions::too_many(count, limit, what)]);
        }
    }
    let (mut found, mut first) = with_wheels(&sheet, options);
    first.extend(grounded(&mut found, options));
    let n_bodies = found.bodies.all.len();
    if n_bodies > MAX_BODIES {
        return Err(vec![questions::too_many(n_bodies, MAX_BODIES, "bodies")]);
    }
    straighten::straighten(&mut found);
    if found.joints.is_empty() {
        return Err(vec![questions::no_joints(&found)]);
    }
    let mut names = Names::default();
    let named = naming::name(&mut found, &mut names);
    let asked = questions::ask(&found, &named, first, (unit, has_unit), options)?;
    Ok(finish(name, found, &named, asked, own_unit, options, warnings))
}

/// Puts everything together.
fn finish(
    name: &str,
    mut found: Found,
    named: &Named,
    asked: Asked,
    own_unit: Option<(f64, bool)>,
    options: &Options,
    warnings: Vec<Diagnostic>,
) -> Understanding {
    let answered: Vec<Joint> = asked
        .joints
        .iter()
        .filter(|(_, is_there)| *is_there)
        .map(|(joint, _)| joint.clone())
        .collect();
    let mobility = found.freedoms(&answered);
    let elements = elements(&found, named, &asked);
    let mut joints: Vec<FoundJoint> =
        found.joints.iter().map(|joint| found_joint(&found, joint, false)).collect();
    joints
        .extend(asked.joints.iter().map(|(joint, is_there)| found_joint(&found, joint, !is_there)));
    let bodies = found_bodies(&found, named);
    let left_out = left_out(&found);
    let picture = picture::svg(&found, &asked);
    found.joints.extend(answered);
    let writing = Writing { found: &found, asked: &asked, elements: &elements, options };
    let model = writing.draft(name, mobility, &left_out);
    let records = match own_unit {
        Some(unit) => attached::records(&writing, unit),
        None => Err(attached::refused("a picture in SVG has no place for attributes".to_owned())),
    };
    Understanding {
        bodies,
        joints,
        elements,
        mobility,
        mm_per_unit: asked.mm_per_unit,
        unit: asked.unit,
        questions: asked.questions,
        left_out,
        model: crate::write::text(&model, &[], &[], &[]),
        records,
        picture,
        warnings,
    }
}

/// Sheet of a drawing with its unit.
struct Paper {
    sheet: Sheet,
    unit: LengthUnit,
    has_unit: bool,
    /// The unit that the file itself states, in metres, and true if it does; `None` of a picture, which holds no model.
    own_unit: Option<(f64, bool)>,
    warnings: Vec<Diagnostic>,
}

/// True of a picture in SVG.
pub fn is_svg(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(MAX_HEADING)]);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    text.starts_with('<') && crate::first_element(text) == Some("svg")
}

/// The text of a drawing or a picture that faults are about.
pub fn excerpt(bytes: &[u8]) -> String {
    if is_svg(bytes) {
        String::from_utf8_lossy(bytes).into_owned()
    } else {
        bksim_cad::tags::excerpt_text(bytes)
    }
}

fn paper(bytes: &[u8], options: &Options) -> Result<Paper, Vec<Diagnostic>> {
    if is_svg(bytes) {
        let (sheet, has_size) = svg::read(&excerpt(bytes), options.unit.is_some())?;
        let unit = options.unit.or_else(|| units::by_name("mm")).expect("millimetres are a unit");
        let has_unit = has_size || options.unit.is_some();
        return Ok(Paper { sheet, unit, has_unit, own_unit: None, warnings: Vec::new() });
    }
    let (opened, has_unit) = opened(bytes, options)?;
    // A drawing with attributes is read in the unit that its file states.
    let stated = options.unit.and_then(|_| open(bytes.to_vec(), &OpenOptions::default()).ok());
    let own_unit = match (stated, options.unit) {
        (Some(stated), _) => (stated.unit.metres, true),
        (None, Some(unit)) => (unit.metres, false),
        (None, None) => (opened.unit.metres, has_unit),
    };
    let (sheet, unit, own_unit) = (sheet(&opened), opened.unit, Some(own_unit));
    Ok(Paper { sheet, unit, has_unit, own_unit, warnings: opened.warnings })
}

/// Opens the drawing; whether it states its unit.
fn opened(bytes: &[u8], options: &Options) -> Result<(Opened, bool), Vec<Diagnostic>> {
    let first = open(bytes.to_vec(), &OpenOptions { unit: options.unit, ..OpenOptions::default() });
    let is_unitless =
        |faults: &[Diagnostic]| faults.iter().all(|fault| fault.code == bksim_cad::codes::NO_UNITS);
    match first {
        Ok(opened) => {
            let stated = opened.tags.header("$INSUNITS").and_then(|idx| opened.tags.integer(idx));
            let has_unit = options.unit.is_some() || stated.is_some_and(|number| number > 0);
            Ok((opened, has_unit))
        }
        Err(faults) if is_unitless(&faults) => {
            let unit = units::by_name("mm");
            Ok((open(bytes.to_vec(), &OpenOptions { unit, ..OpenOptions::default() })?, false))
        }
        Err(faults) => Err(faults),
    }
}

/// Everything that can be read, and the questions whether wheels turn on their own or with the links at their pins.
fn with_wheels(sheet: &Sheet, options: &Options) -> (Found, Vec<Question>) {
    let first = found(sheet.clone(), &[]);
    let doubtful = wheels::doubtful(&first.bodies);
    let free = first.freedoms(&[]);
    let (mut held, mut questions) = (Vec::new(), Vec::new());
    for pin in doubtful {
        let fixed = found(sheet.clone(), &[pin]).freedoms(&[]);
        // Nobody draws what is locked.
        if fixed < 1 {
            continue;
        }
        let question = questions::about_wheel(&first, pin, [free, fixed]);
        let answer = options.answers.iter().find(|(key, _)| *key == question.key);
        let taken = answer.map_or(question.taken(), |(_, value)| value);
        if taken == questions::WITH_LINK {
            held.push(pin);
        }
        questions.push(question);
    }
    let found = if held.is_empty() { first } else { found(sheet.clone(), &held) };
    (found, questions)
}

/// Makes a body the ground where the drawing shows none, and asks which.
fn grounded(found: &mut Found, options: &Options) -> Option<Question> {
    let is_shown = found.joints.iter().any(|joint| joint.on.contains(&On::Ground));
    if is_shown || found.joints.is_empty() {
        return None;
    }
    let question = questions::about_ground(found);
    let answer = options.answers.iter().find(|(key, _)| *key == question.key);
    let taken = answer.map_or(question.taken(), |(_, value)| value);
    let body = question.readings.iter().position(|reading| reading.answer == taken);
    // What is no answer is refused with the other answers.
    let body = questions::by_joints(found)[body.unwrap_or_default()];
    found.fix(body);
    Some(question)
}

/// Everything that can be read without asking; wheels at the pins `held` turn with a link.
fn found(sheet: Sheet, held: &[usize]) -> Found {
    let mut pieces = Pieces::of(&sheet);
    let pins = bodies::pins(&pieces);
    let places: Vec<Point> = pins.iter().map(|pin| pin.at).collect();
    let tips = notes::arrow_tips(&sheet, pieces.pin);
    let fixed: Vec<Point> =
        places.iter().copied().chain(tips.iter().map(|(tip, _)| *tip)).collect();
    pieces.join_cuts(&fixed);
    bodies::take_centre_marks(&mut pieces, &pins);
    let notes = Notes::of(&sheet, &mut pieces, &places);
    let rings = hatching::rings(&sheet, &mut pieces);
    let (bases, plates) = hatching::bases(&sheet, &mut pieces, &places);
    pieces.merge_lines(&places);
    let with_radii: Vec<(Point, f64)> = pins.iter().map(|pin| (pin.at, pin.reach())).collect();
    let mut is_fixed = stands::stands(&mut pieces, &bases, &with_radii);
    let springs = springs::springs(&mut pieces);
    loops::close_rings(&mut pieces, &places);
    stands::stand_symbols(&mut pieces, &bases, &with_radii, &mut is_fixed);
    let mut bodies = bodies::bodies(&mut pieces, &pins, &plates, &is_fixed);
    wheels::add_wheels(&mut bodies, &pieces, (&pins, held), &rings);
    let mut scene = Scene {
        pieces: &pieces,
        pins: &pins,
        bases: &bases,
        is_fixed: &mut is_fixed,
        bodies: &mut bodies,
    };
    // What turns in a ring of the ground turns about its centre.
    for (centre, ..) in &scene.bodies.rings {
        let mut pins = scene.pins.iter().enumerate();
        let pin = pins.find(|(_, pin)| distance(pin.at, *centre) < scene.pieces.tolerance);
        if let Some((idx, _)) = pin {
            scene.is_fixed[idx] = true;
        }
    }
    let joints = joints::joints(&mut scene);
    let mut found =
        Found { sheet, pieces, notes, pins, is_fixed, bases, bodies, joints, springs, size: 0.0 };
    found.keep_joined();
    found.measure();
    found
}

impl Found {
    /// Makes a body the ground.
    fn fix(&mut self, body: usize) {
        for joint in &mut self.joints {
            for on in &mut joint.on {
                match on {
                    On::Body(idx) if *idx == body => *on = On::Ground,
                    On::Body(idx) if *idx > body => *idx -= 1,
                    _ => (),
                }
            }
            // The ground comes first, but for what the order means something.
            if matches!(joint.kind, Kind::Pin | Kind::Slide { .. }) {
                joint.on.sort_by_key(|on| *on != On::Ground);
            }
        }
        for pin in &self.bodies.all[body].pins {
            self.is_fixed[*pin] = true;
        }
        self.bodies.all.remove(body);
        self.bodies.slots.retain(|slot| slot.body != body);
        for slot in &mut self.bodies.slots {
            slot.body -= usize::from(slot.body > body);
        }
    }

    /// Drops bodies without joints: side views, loose lines.
    fn keep_joined(&mut self) {
        let is_joined: Vec<bool> = (0..self.bodies.all.len())
            .map(|idx| self.joints.iter().any(|joint| joint.on.contains(&On::Body(idx))))
            .collect();
        let mut next = 0;
        let number: Vec<usize> = is_joined
            .iter()
            .map(|keep| {
                next += usize::from(*keep);
                next.saturating_sub(1)
            })
            .collect();
        for joint in &mut self.joints {
            for on in &mut joint.on {
                if let On::Body(idx) = on {
                    *idx = number[*idx];
                }
            }
        }
        self.bodies.slots.retain(|slot| is_joined[slot.body]);
        for slot in &mut self.bodies.slots {
            slot.body = number[slot.body];
        }
        let mut keep = is_joined.iter();
        self.bodies.all.retain(|_| *keep.next().expect("one for each body"));
    }

    /// The size of the mechanism, and how far points miss that are meant to be one.
    fn measure(&mut self) {
        let at: Vec<Point> = self.joints.iter().map(|joint| joint.at).collect();
        for a in &at {
            self.size = at.iter().map(|b| distance(*a, *b)).fold(self.size, f64::max);
        }
        self.size = self.size.max(4.0 * self.pieces.pin);
        let near = self.pieces.tolerance;
        let mut misses = Vec::new();
        for body in &self.bodies.all {
            for pin in &body.pins {
                let ends = body.segments.iter().flatten();
                misses.extend(
                    ends.map(|end| distance(*end, self.pins[*pin].at)).filter(|miss| *miss < near),
                );
            }
        }
        for miss in misses {
            self.pieces.note_miss(miss);
        }
    }

    /// Singular values below this are zero within the drawing's own error.
    fn looseness(&self) -> f64 {
        (4.0 * self.pieces.miss / self.size).clamp(1e-7, 0.02)
    }

    fn freedoms(&self, more: &[Joint]) -> i64 {
        let all: Vec<Joint> = self.joints.iter().chain(more).cloned().collect();
        mobility::freedoms(&all, self.bodies.all.len(), self.size, self.looseness())
    }
}
