//! `[use.…]`: parts, models of their own in other files, and what the model says of each.
//!
//! A part gives everything but its name, its space, its `[solve]` and its gravity. Its ground is the ground of
//! the model, or the body that `on` names. `with` sets its parameters and signals, and puts bodies and joints of
//! the model in the place of its own.

use super::super::codes;
use super::super::gather::sub_tables;
use super::super::tree::{Entry, Node, Table, Value};
use super::super::words::suggest;
use super::merge::{given_in_place, put_ground_points, section_of};
use super::rename::{Host, Renaming};
use super::{Expander, OF_LIBRARY, Unopened};
use crate::diagnostic::{Code, Diagnostic, Span};
use crate::library::{LIBRARY, LibraryPart};

const USE_KEYS: [&str; 4] = ["file", "part", "on", "with"];

/// Sections of a part that are its own matter.
const LEFT_OUT: [&str; 6] = ["name", "space", "coordinates", "solve", "ranges", "cases"];

/// Parts within parts.
const DEEPEST: usize = 16;

impl Expander<'_> {
    /// Puts the parts that a model uses into it.
    pub(super) fn use_parts(&mut self, root: &mut Table) {
        let Some(place) = root.entries.iter().position(|section| section.key == "use") else {
            return;
        };
        let section = root.entries.remove(place);
        let Value::Table(uses) = section.node.value else {
            self.report(
                Diagnostic::error(codes::WRONG_KIND, "`use` must be a table of tables")
                    .at(section.node.span, "")
                    .help("write a table for each part, such as `[use.motor]`"),
            );
            return;
        };
        for Entry { key, key_span, node } in uses.entries {
            let Value::Table(keys) = node.value else {
                self.report(
                    Diagnostic::error(
                        codes::WRONG_KIND,
                        format!("the use `{key}` must be a table"),
                    )
                    .at(key_span, "")
                    .help(format!("write its keys below a line `[use.{key}]`")),
                );
                continue;
            };
            self.use_part(root, &key, &key_span, &keys);
        }
    }

    fn use_part(&mut self, root: &mut Table, name: &str, span: &Span, keys: &Table) -> Option<()> {
        if self.is_full {
            return None;
        }
        // The file, opened.
        let mut are_known = true;
        for entry in keys.entries.iter().filter(|entry| !USE_KEYS.contains(&entry.key.as_str())) {
            let message = format!("unknown key `{}` in use `{name}`", entry.key);
            let label = (entry.key_span.clone(), "not a key here");
            self.unknown(codes::UNKNOWN_KEY, message, label, (&entry.key, &USE_KEYS));
            are_known = false;
        }
        let (file, mut part) = match (keys.get("file"), keys.get("part")) {
            (Some(file), None) => (file, self.part_in_file(name, &file.node)?),
            (None, Some(known)) => (known, self.part_of_library(name, &known.node)?),
            (Some(_), Some(known)) => {
                let message = format!("`file` and `part` of use `{name}` exclude each other");
                self.report(
                    Diagnostic::error(codes::KEY_CONFLICT, message)
                        .at(known.key_span.clone(), "")
                        .help("keep one of them"),
                );
                return None;
            }
            (None, None) => {
                if are_known {
                    self.report(
                        Diagnostic::error(codes::MISSING_KEY, format!("use `{name}` has no `file`"))
                            .at(span.clone(), "`file` is missing")
                            .help("write for example `file = \"parts/motor.toml\"`, or the name of a `part` that `bksim parts` lists"),
                    );
                }
                return None;
            }
        };

        // What it does not bring along.
        let host = self.host_of(root, name, keys)?;
        self.check_units(root, name, &part, &file.node.span)?;
        part.entries
            .retain(|section| !LEFT_OUT.contains(&section.key.as_str()) && section.key != "units");
        let is_gravity = |entry: &Entry| match &entry.node.value {
            Value::Table(keys) => match keys.get("type").map(|kind| &kind.node.value) {
                Some(Value::Text(kind)) => kind == "gravity",
                _ => false,
            },
            _ => false,
        };
        if let Some(loads) = section_of(&mut part, "loads") {
            loads.entries.retain(|entry| !is_gravity(entry));
        }

        // Its names and values, as the model has them.
        let with = match keys.get("with") {
            Some(with) => self.with_of(name, &with.node)?,
            None => &Table::default(),
        };
        let given = given_in_place(&mut part, with);
        let renaming = Renaming::new(&part, name, &host, given, self.nesting);
        renaming.rename(&mut part);
        self.set_values(&mut part, name, with, &renaming);
        put_ground_points(root, &mut part, &renaming, &host);
        self.merge(root, part, name, span);
        Some(())
    }

    /// A part that comes with bksim.
    fn part_of_library(&mut self, name: &str, node: &Node) -> Option<Table> {
        let Value::Text(known) = &node.value else {
            self.report(
                Diagnostic::error(codes::WRONG_KIND, format!("`part` of use `{name}` is no text"))
                    .at(node.span.clone(), "the name of a part, in quotes")
                    .help("write for example `part = \"gas-spring\"`"),
            );
            return None;
        };
        let Some(part) = LibraryPart::named(known) else {
            let names: Vec<&str> = LIBRARY.iter().map(|part| part.name).collect();
            let message = format!("use `{name}` is of unknown part `{known}`");
            let label = (node.span.clone(), "no part that comes with bksim has this name");
            self.unknown(codes::BAD_PART, message, label, (known, &names));
            return None;
        };
        if !self.pays_for(part.text.len(), name, node.span.clone()) {
            return None;
        }
        self.whole(&format!("{OF_LIBRARY}{}", part.name), part.text.to_owned())
    }

    /// The part in a file, with its own parts.
    fn part_in_file(&mut self, name: &str, node: &Node) -> Option<Table> {
        let Value::Text(file) = &node.value else {
            self.report(
                Diagnostic::error(codes::WRONG_KIND, format!("`file` of use `{name}` is no text"))
                    .at(node.span.clone(), "the name of a file, in quotes")
                    .help("write for example `file = \"parts/motor.toml\"`"),
            );
            return None;
        };
        let by = self.stack.last().cloned().unwrap_or_default();
        let path = beside(&by, file);
        let is_circle = self.stack.contains(&path);
        if is_circle || self.stack.len() > DEEPEST {
            let way: Vec<&str> = self.stack.iter().chain([&path]).map(String::as_str).collect();
            let message = if is_circle {
                format!("parts use each other: {}", way.join(" → "))
            } else {
                format!("parts within parts, more than {DEEPEST} deep")
            };
            self.report(
                Diagnostic::error(codes::BAD_PART, message)
                    .at(node.span.clone(), "used here")
                    .help("take this use out, or use another file"),
            );
            return None;
        }
        let text = match self.text_of(&path) {
            Ok(text) => text,
            Err(Unopened { why, help }) => {
                let usual = "name a model file in the folder of the model, or below it";
                let file = path.rsplit(['/', ':']).next().unwrap_or_default();
                let of_library = LibraryPart::named(file.trim_end_matches(".toml"));
                let help = of_library
                    .map(|part| format!("write `part = \"{}\"`: it comes with bksim", part.name))
                    .or(help);
                self.report(
                    Diagnostic::error(codes::BAD_PART, format!("the part `{path}` {why}"))
                        .at(node.span.clone(), "this file")
                        .help(help.unwrap_or_else(|| usual.to_owned())),
                );
                return None;
            }
        };
        if !self.pays_for(text.len(), name, node.span.clone()) {
            return None;
        }
        let part = self.whole(&path, text)?;
        if part.get("drawing").is_some() {
            self.report(
                Diagnostic::error(codes::BAD_PART, format!("the part `{path}` names a drawing"))
                    .at(node.span.clone(), "parts are model files")
                    .help("write the model of the drawing with `bksim cad model`, and use that"),
            );
            return None;
        }
        Some(part)
    }

    /// The body and point that `on` names: the ground of the part.
    fn host_of(&mut self, root: &Table, name: &str, keys: &Table) -> Option<Host> {
        let ground = Host { body: "ground".to_owned(), point: None };
        let Some(on) = keys.get("on") else { return Some(ground) };
        let Value::Text(text) = &on.node.value else {
            self.report(
                Diagnostic::error(codes::WRONG_KIND, format!("`on` of use `{name}` is no text"))
                    .at(on.node.span.clone(), "a body, or a point of one")
                    .help("write for example `on = \"arm.mount\"`"),
            );
            return None;
        };
        let (body, point) = match text.split_once('.') {
            Some((body, point)) => (body, Some(point)),
            None => (text.as_str(), None),
        };
        let bodies = sub_tables(root, "bodies");
        let table = match bodies.iter().find(|(known, ..)| *known == body) {
            Some((.., table)) => *table,
            None if body == "ground" => root.get("ground").and_then(|entry| entry.node.table()),
            None => {
                let mut names: Vec<&str> = bodies.iter().map(|(name, ..)| *name).collect();
                names.push("ground");
                let message = format!("use `{name}` is on unknown body `{body}`");
                let label = (on.node.span.clone(), "no body has this name");
                self.unknown(codes::UNKNOWN_BODY, message, label, (body, &names));
                return None;
            }
        };
        if let Some(point) = point {
            let points = table.and_then(|keys| keys.get("points")?.node.table());
            let names: Vec<&str> = points
                .map(|points| points.entries.iter().map(|entry| entry.key.as_str()).collect())
                .unwrap_or_default();
            if !names.contains(&point) {
                let message = format!("body `{body}` has no point `{point}`");
                let label = (on.node.span.clone(), "no point has this name");
                self.unknown(codes::UNKNOWN_POINT, message, label, (point, &names));
                return None;
            }
        }
        Some(Host { body: body.to_owned(), point: point.map(str::to_owned) })
    }

    /// Units that a part states must be those of the model: bare numbers of both are read in one way.
    fn check_units(&mut self, root: &Table, name: &str, part: &Table, span: &Span) -> Option<()> {
        let Some(Value::Table(units)) = part.get("units").map(|entry| &entry.node.value) else {
            return Some(());
        };
        let of_model = root.get("units").and_then(|entry| entry.node.table());
        for Entry { key, key_span, node } in &units.entries {
            let Value::Text(unit) = &node.value else { continue };
            let known = of_model.and_then(|units| units.get(key)).map(|entry| &entry.node.value);
            if !matches!(known, Some(Value::Text(known)) if known == unit) {
                self.report(
                    Diagnostic::error(
                        codes::BAD_PART,
                        format!("the part of use `{name}` has its {key}s in {unit}, and the model has not"),
                    )
                    .at(key_span.clone(), "for numbers without a unit")
                    .at(span.clone(), "used here")
                    .help("write the units with the numbers of the part, and take its `[units]` out"),
                );
                return None;
            }
        }
        Some(())
    }

    fn with_of<'n>(&mut self, name: &str, with: &'n Node) -> Option<&'n Table> {
        if with.table().is_none() {
            self.report(
                Diagnostic::error(
                    codes::WRONG_KIND,
                    format!("`with` of use `{name}` must be a table"),
                )
                .at(with.span.clone(), "")
                .help("write for example `with = { R = \"2 ohm\" }`"),
            );
        }
        with.table()
    }

    /// Reports a name that nothing has.
    pub(super) fn unknown(
        &mut self,
        code: Code,
        message: String,
        (span, label): (Span, &str),
        (word, candidates): (&str, &[&str]),
    ) {
        let fault = Diagnostic::error(code, message).at(span, label);
        self.report(fault.help(suggest(word, candidates)));
    }
}

/// The name of a file that another one names, against the folder of the model.
pub(super) fn beside(by: &str, file: &str) -> String {
    let folder = by.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(file.split('/')) {
        match part {
            "" | "." => (),
            ".." if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    let is_absolute = file.starts_with('/');
    if is_absolute { file.to_owned() } else { parts.join("/") }
}
