//! From what is attached to a drawing to the text of a model.
//!
//! ```text
//! layers, records, inserts → parts → joints → frames → masses → text of a model
//!                 gather      connect                   plate     model, draft
//! ```
//!
//! A file beside the drawing is merged over what the drawing says. Every value of the text keeps
//! its location, so that whatever is found wrong with it later is shown where its author wrote it.

mod connect;
mod draft;
mod gather;
mod model;
mod origins;
mod part;
mod partners;
mod plate;
mod shapes;
mod side;

use std::collections::BTreeMap;
use std::ops::Range;

use bksim_mbs::diagnostic::Diagnostic;

pub use origins::Origin;
pub use part::Frame;
pub use side::{DRAWING_KEY, named_drawing};

use crate::attachment::Attachment;
use crate::codes;
use crate::drawing::{Drawing, Location};
use crate::excerpt::Excerpts;
use crate::geometry::{Path, Point};
use crate::kind::Section;
use crate::mass::AreaProperties;
use connect::Connection;
use draft::Draft;
use origins::Origins;
use part::{Part, text_of};
use side::Side;

/// The snapping tolerance over the diagonal of the drawing, unless it is given.
pub const RELATIVE_TOLERANCE: f64 = 1e-4;

/// Coordinates are written to this many digits of the size of the drawing: what is below is rounding.
const DIGITS: i32 = 14;

/// Digits of corners of outlines, which are for pictures.
const PICTURE_DIGITS: i32 = 6;

/// How a drawing is composed.
#[derive(Clone, Copy, Debug, Default)]
pub struct ComposeOptions<'a> {
    /// The text of the model file beside the drawing; it must be TOML.
    pub side: Option<&'a str>,
    /// The snapping tolerance, drawing units; [`RELATIVE_TOLERANCE`] of the diagonal unless given.
    pub tolerance: Option<f64>,
    /// Density and thickness of bodies that state none, as texts of a model file.
    pub plate: [Option<&'a str>; 2],
}

/// A model that came out of a drawing.
#[derive(Clone, Debug)]
pub struct Composition {
    /// The text of the model, complete by itself; empty when there was an error.
    pub text: String,
    /// Bodies, in the order of the drawing.
    pub bodies: Vec<BodyReport>,
    /// Joints, in the order of the drawing.
    pub joints: Vec<JointReport>,
    /// Points that were taken as one.
    pub snaps: Vec<Snap>,
    /// The snapping tolerance, drawing units.
    pub tolerance: f64,
    /// Errors and warnings; spans are those of the drawing's text.
    pub diagnostics: Vec<Diagnostic>,
    origins: Origins,
}

impl Composition {
    /// Where a range of the text comes from.
    pub fn origin(&self, span: &Range<usize>) -> Origin {
        self.origins.find(span)
    }
}

/// A body of a drawing.
#[derive(Clone, Debug)]
pub struct BodyReport {
    /// Its name.
    pub name: String,
    /// Where its mass comes from.
    pub source: MassSource,
    /// Its mass as the text of a model file.
    pub mass: Option<String>,
    /// Centre of mass in world axes, drawing units.
    pub centre: Point,
    /// Its outline's areas and moments, drawing units.
    pub area: Option<AreaProperties>,
    /// Its frame.
    pub frame: Frame,
    /// Its curves in world axes, drawing units.
    pub paths: Vec<Path>,
    /// Where it was first met.
    pub location: Location,
}

/// Where a mass comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MassSource {
    /// The author states it.
    Stated,
    /// Density, thickness and area.
    Computed,
    /// Nothing says it.
    Missing,
}

/// A joint of a drawing.
#[derive(Clone, PartialEq, Debug)]
pub struct JointReport {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Its bodies, the first one first.
    pub bodies: [String; 2],
    /// Where it is on each, world axes, drawing units.
    pub at: [Point; 2],
}

/// Two points taken as one.
#[derive(Clone, PartialEq, Debug)]
pub struct Snap {
    /// What was placed.
    pub what: String,
    /// The body it was placed on.
    pub body: String,
    /// The point of the body.
    pub from: Point,
    /// The point that it was taken as.
    pub to: Point,
    /// Their distance, drawing units.
    pub distance: f64,
}

/// Composes the model of a drawing.
pub fn compose(
    drawing: &Drawing,
    attachments: &[Attachment],
    excerpts: &Excerpts<'_>,
    options: ComposeOptions<'_>,
) -> Composition {
    let [low, high] = drawing.extent;
    let size = (high[0] - low[0]).hypot(high[1] - low[1]);
    let reach = size.max(low[0].abs()).max(low[1].abs()).max(high[0].abs()).max(high[1].abs());
    let tolerance = options.tolerance.unwrap_or(RELATIVE_TOLERANCE * size);
    let decimals = |digits: i32| {
        // The last decimal that a number of the size of the drawing has.
        (0..300).find(|&n| reach * 10_f64.powi(n) >= 10_f64.powi(digits)).unwrap_or(0)
    };
    let mut composer = Composer {
        drawing,
        attachments,
        excerpts,
        side: Side::new(options.side.unwrap_or_default()),
        tolerance,
        plate: options.plate,
        step: reach * 1e-12,
        decimals: decimals(DIGITS),
        picture_decimals: decimals(PICTURE_DIGITS),
        picture_tolerance: size * 1e-4,
        parts: vec![Part::new("ground")],
        owners: vec![None; drawing.entities.len()],
        inserts: BTreeMap::new(),
        insert_points: BTreeMap::new(),
        connections: Vec::new(),
        draft: Draft::default(),
        bodies: Vec::new(),
        joints: Vec::new(),
        snaps: Vec::new(),
        faults: Vec::new(),
    };
    composer.gather();
    composer.connect();
    composer.choose_frames();
    composer.write();
    composer.finish(options.side.unwrap_or_default())
}

/// The way from attachments to a text.
struct Composer<'a> {
    drawing: &'a Drawing,
    attachments: &'a [Attachment],
    excerpts: &'a Excerpts<'a>,
    side: Side,
    /// Density and thickness of bodies that state none.
    plate: [Option<&'a str>; 2],
    /// Points nearer than this are taken as one.
    tolerance: f64,
    /// Points nearer than this are one but for rounding.
    step: f64,
    decimals: i32,
    picture_decimals: i32,
    picture_tolerance: f64,
    /// The ground first.
    parts: Vec<Part>,
    /// The part of each entity.
    owners: Vec<Option<usize>>,
    /// Places of the inserts of `BK_BODY`, by their parts.
    inserts: BTreeMap<usize, Location>,
    /// Where they are.
    insert_points: BTreeMap<usize, Point>,
    connections: Vec<Connection<'a>>,
    draft: Draft,
    bodies: Vec<BodyReport>,
    joints: Vec<JointReport>,
    snaps: Vec<Snap>,
    faults: Vec<Diagnostic>,
}

impl<'a> Composer<'a> {
    fn finish(mut self, side_text: &str) -> Composition {
        let has_error = self.faults.iter().any(Diagnostic::is_error);
        let (mut text, mut origins) = (String::new(), Origins::default());
        if !has_error {
            for body in &self.bodies {
                let used: &[&str] = match body.source {
                    // What is stated here was made a part of the computed values.
                    MassSource::Computed => &["density", "thickness"],
                    MassSource::Stated | MassSource::Missing => &[],
                };
                self.side.forget(&body.name, used);
            }
            text = self.side.merged(&self.draft.document);
            origins = Origins::new(&text, side_text, self.draft.locations);
        }
        Composition {
            text,
            bodies: self.bodies,
            joints: self.joints,
            snaps: self.snaps,
            tolerance: self.tolerance,
            diagnostics: self.faults,
            origins,
        }
    }

    /// Attachments of a section with their names; those without one are numbered.
    fn names(
        &mut self,
        section: Section,
        default: fn(&Attachment) -> String,
    ) -> Vec<(&'a Attachment, String)> {
        let of_section: Vec<&'a Attachment> =
            self.attachments.iter().filter(|a| a.kind.section == section).collect();
        let mut named: Vec<(&'a Attachment, String)> = Vec::new();
        let stated: Vec<&str> = of_section.iter().filter_map(|a| text_of(a, "name")).collect();
        for &attachment in &of_section {
            if let Some(name) = text_of(attachment, "name") {
                if let Some((twin, _)) = named.iter().find(|(_, known)| known == name) {
                    let message = format!("two {} are called `{name}`", words(section));
                    let help = "give each a name of its own";
                    self.twins(&message, help, [&attachment.location, &twin.location]);
                    continue;
                }
                named.push((attachment, name.to_owned()));
                continue;
            }
            let base = default(attachment);
            let is_single = section != Section::Joints
                && of_section.iter().filter(|other| default(other) == base).count() == 1;
            let numbered = (1..).map(|number| format!("{base}{number}"));
            let candidates = is_single.then(|| base.clone()).into_iter().chain(numbered);
            let is_free = |name: &String| {
                !stated.contains(&name.as_str()) && named.iter().all(|(_, known)| known != name)
            };
            let name = candidates.into_iter().find(is_free).unwrap_or(base);
            named.push((attachment, name));
        }
        named
    }

    fn fault(&mut self, fault: Diagnostic, location: &Location) {
        self.fault_at(fault, location, "");
    }

    fn fault_at(&mut self, fault: Diagnostic, location: &Location, words: &str) {
        let fault = self.excerpts.at(fault, location, words);
        if !self.faults.contains(&fault) {
            self.faults.push(fault);
        }
    }

    fn twins(&mut self, message: &str, help: &str, [here, there]: [&Location; 2]) {
        let fault = Diagnostic::error(codes::DUPLICATE_NAME, message).help(help);
        let fault = self.excerpts.at(fault, here, "here");
        self.fault_at(fault, there, "and here");
    }

    fn nameless(&mut self, what: &str, attachment: &Attachment) {
        let fault = Diagnostic::error(codes::NO_NAME, format!("{what} has no name"))
            .help("give it one: the attribute NAME, or `name=…` in its record");
        self.fault(fault, &attachment.location);
    }

    /// A point without what rounding left beyond the digits of the drawing.
    fn tidy(&self, point: Point) -> Point {
        point.map(|x| rounded(x, self.decimals))
    }

    /// A point for pictures.
    fn coarse(&self, point: Point) -> Point {
        point.map(|x| rounded(x, self.picture_decimals))
    }
}

/// What an attachment is, for messages: ``joint `B` ``.
fn title(attachment: &Attachment) -> String {
    let what = match attachment.kind.section {
        Section::Joints => "joint",
        Section::Points => "point",
        _ => attachment.kind.name,
    };
    match text_of(attachment, "name") {
        Some(name) => format!("{what} `{name}`"),
        None => what.to_owned(),
    }
}

fn rounded(x: f64, decimals: i32) -> f64 {
    let decimals = usize::try_from(decimals).unwrap_or(0);
    // Adding zero turns a negative zero into a plain one.
    format!("{x:.decimals$}").parse().unwrap_or(x) + 0.0
}

fn words(section: Section) -> &'static str {
    match section {
        Section::Joints => "joints",
        Section::Loads => "loads",
        Section::Drives => "drives",
        _ => "things",
    }
}
