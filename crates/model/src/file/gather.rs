//! The names of a file, gathered before any value is read, so that the order of the tables in the
//! file does not matter.

use bksim_expr::Function;

use super::codes;
use super::joint_types::type_of;
use super::names::{BodyName, JointName, Meaning, quantities, quantity_of};
use super::play::contacts_of_joint;
use super::reader::{Reader, entry_like};
use super::tree::{Entry, Node, Table, Value};
use super::units::Quantity;
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::JointId;
use crate::joint::{MotionKind, motion_words};
use crate::measure::Measure;
use crate::measure_names::BODY_WORDS;

/// Loads that act between two points, by their types.
const LINES: [&str; 3] = ["spring", "damper", "force"];

impl Reader<'_> {
    /// Gathers the names of all bodies, points and joints.
    pub(super) fn gather_names(&mut self, root: &Table) {
        let ground_points = root.get("ground").and_then(|entry| match &entry.node.value {
            Value::Table(ground) => entry_like(ground, "points"),
            _ => None,
        });
        let points = self.gather_points(ground_points.map(|entry| &entry.node));
        self.names.add_body(BodyName { name: "ground".to_owned(), points, span: 0..0 });
        for (name, span, table) in sub_tables(root, "bodies") {
            if name == "ground" {
                self.report(
                    Diagnostic::error(codes::BAD_NAME, "a body cannot be named `ground`")
                        .at(span, "the ground is given and does not move")
                        .help("write its points under `[ground]`, or rename the body"),
                );
                continue;
            }
            self.usable_name(name, &span, "body");
            let points =
                table.and_then(|table| entry_like(table, "points")).map(|entry| &entry.node);
            let points = self.gather_points(points);
            self.names.add_body(BodyName { name: name.to_owned(), points, span });
        }
        let mut of_joints = Vec::new();
        for (name, span, table) in sub_tables(root, "joints") {
            self.usable_name(name, &span, "joint");
            self.check_joint_name(name, &span);
            let known = table.and_then(|table| table.get("type")).and_then(|entry| {
                let Value::Text(word) = &entry.node.value else { return None };
                type_of(word, table?)
            });
            let (kind, freedoms) = known.map(|of| (of.word, of.motions)).unzip();
            if let Some((table, Value::Text(word))) =
                table.and_then(|table| Some((table, &table.get("type")?.node.value)))
            {
                of_joints.extend(contacts_of_joint(name, table, word));
            }
            let has_radius = table.is_some_and(|table| table.get("radius").is_some());
            self.names.add_joint(JointName { name: name.to_owned(), kind, freedoms, has_radius });
        }
        self.gather_flexible(root);
        self.gather_drives(root);
        self.gather_forces(root);
        self.names.contacts.extend(of_joints);
    }

    /// Gathers the names of the forces of couplings, which are among the results, from what their tables say.
    fn gather_forces(&mut self, root: &Table) {
        for (name, _, table) in sub_tables(root, "couplings") {
            self.names.forces.extend(table.map(|table| forces_of(name, table)).unwrap_or_default());
        }
        self.names.contacts =
            sub_tables(root, "contacts").into_iter().map(|(name, ..)| name.to_owned()).collect();
        let is_line = |table: &Table| {
            let kind = table.get("type").map(|entry| &entry.node.value);
            let is_kind = matches!(kind, Some(Value::Text(word)) if LINES.contains(&word.as_str()));
            is_kind && table.get("between").is_some()
        };
        let loads = sub_tables(root, "loads").into_iter();
        let lines = loads.filter(|(_, _, table)| table.is_some_and(is_line));
        self.names.lines = lines.map(|(name, ..)| name.to_owned()).collect();
    }

    /// Gathers the names of drives with the motions that they drive: their efforts are among the results.
    fn gather_drives(&mut self, root: &Table) {
        let word = |table: &Table, key: &str| match &table.get(key)?.node.value {
            Value::Text(text) => Some(text.clone()),
            _ => None,
        };
        for (name, _, table) in sub_tables(root, "drives") {
            let freedoms = table.and_then(|table| {
                let joint = self.names.joint(&word(table, "joint")?)?;
                self.names.joints[joint.0].freedoms
            });
            let of = table.and_then(|table| word(table, "of"));
            let motion = freedoms.and_then(|freedoms| {
                let is_it = |&idx: &usize| match &of {
                    Some(of) => motion_words(freedoms, idx)[0] == of,
                    None => freedoms.len() == 1,
                };
                (0..freedoms.len()).find(is_it).map(|idx| freedoms[idx])
            });
            self.names.drives.push((name.to_owned(), motion));
        }
    }

    fn gather_points(&mut self, node: Option<&Node>) -> Vec<String> {
        let Some(Node { value: Value::Table(points), .. }) = node else { return Vec::new() };
        for entry in &points.entries {
            self.usable_name(&entry.key, &entry.key_span, "point");
        }
        points.entries.iter().map(|entry| entry.key.clone()).collect()
    }

    /// Joints and bodies share one namespace: `A.angle` must have one meaning.
    fn check_joint_name(&mut self, name: &str, span: &Span) {
        let Some(body) = self.names.body(name) else { return };
        let fault = Diagnostic::error(
            codes::NAME_CLASH,
            format!("`{name}` is the name of a joint and of a body"),
        )
        .at(span.clone(), "the joint");
        let fault = match self.names.bodies[body.0].span.clone() {
            ground if ground.is_empty() => fault.note("`ground` is always a body"),
            body => fault.at(body, "the body"),
        };
        self.report(
            fault.help(format!("rename one of them, for example the joint to `{name}_joint`")),
        );
    }

    /// Gives a plain name its meaning, or reports that it already has one.
    pub(super) fn define(&mut self, name: &str, meaning: Meaning, span: Option<Span>) -> bool {
        /// Words between operands.
        const WORDS: [&str; 5] = ["and", "or", "not", "then", "else"];
        if name == "pi" || WORDS.contains(&name) || Function::from_name(name).is_some() {
            let what = match name {
                "pi" => "the number 3.14159…",
                _ if WORDS.contains(&name) => "a word of conditions",
                _ => "a function",
            };
            self.report(
                Diagnostic::error(codes::NAME_CLASH, format!("the name `{name}` is already taken"))
                    .at(span.unwrap_or(0..0), "this needs a name of its own")
                    .note(format!("`{name}` is {what}"))
                    .help(format!("rename it, for example `{name}_1`")),
            );
            return false;
        }
        let Some((_, before)) = self.names.plain.get(name) else {
            self.names.plain.insert(name.to_owned(), (meaning, span));
            return true;
        };
        let fault =
            Diagnostic::error(codes::NAME_CLASH, format!("the name `{name}` is already taken"));
        let fault = fault.at(span.unwrap_or(0..0), "this needs a name of its own");
        let fault = match before.clone() {
            Some(location) => fault.at(location, "taken here"),
            None => fault.note(format!("`{name}` is the time")),
        };
        self.report(fault.help(format!("rename one of them, for example this to `{name}_1`")));
        false
    }

    /// The tables of the section of a kind, in file order: name, its position, table. What is no table is
    /// reported.
    pub(super) fn own_tables<'t>(
        &mut self,
        root: &'t Table,
        kind: &str,
    ) -> Vec<(&'t str, Span, &'t Table)> {
        let mut tables = Vec::new();
        for (name, span, table) in sub_tables(root, &plural(kind)) {
            match table {
                Some(table) => tables.push((name, span, table)),
                None => self.not_a_table(kind, name, &span),
            }
        }
        tables
    }

    /// Reports an entry of a section that should be a table.
    pub(super) fn not_a_table(&mut self, kind: &str, name: &str, span: &Span) {
        self.report(
            Diagnostic::error(codes::WRONG_KIND, format!("{kind} `{name}` must be a table"))
                .at(span.clone(), "")
                .help(format!("write its keys below a line `[{}.{name}]`", plural(kind))),
        );
    }

    /// Gathers the names that the author gave to coordinates.
    pub(super) fn gather_coordinates(&mut self, root: &Table) {
        for (idx, (_, _, table)) in sub_tables(root, "joints").into_iter().enumerate() {
            let Some(entry) = table.and_then(|table| table.get("coordinate")) else { continue };
            let freedoms = self.names.joints[idx].freedoms.unwrap_or_default();
            let joint = JointId(idx);
            let measures = freedoms.iter().enumerate().map(|(at, freedom)| {
                let [value, rate] = quantities(*freedom);
                [
                    (Measure::JointPosition(joint, at), value),
                    (Measure::JointVelocity(joint, at), rate),
                ]
            });
            self.define_coordinates(&entry.node, &measures.collect::<Vec<_>>());
        }
        for (name, _, table) in sub_tables(root, "bodies") {
            let Some(entry) = table.and_then(|table| table.get("coordinates")) else { continue };
            let Some(body) = self.names.body(name) else { continue };
            // In the plane x, y and angle; in space x, y, z and three angles.
            let named = |at: usize| BODY_WORDS[at].1(body, None);
            let slide = |at: usize| [named(at), named(3 + at)];
            let turn = |at| [Measure::CardanAngle(body, at), Measure::CardanRate(body, at)];
            let measures = if coordinate_names(&entry.node, self.text).len() > 3 {
                vec![slide(0), slide(1), slide(2), turn(0), turn(1), turn(2)]
            } else {
                vec![slide(0), slide(1), [named(6), named(7)]]
            };
            let with_quantity = |pair: [Measure; 2]| pair.map(|of| (of, quantity_of(of)));
            let measures: Vec<_> = measures.into_iter().map(with_quantity).collect();
            self.define_coordinates(&entry.node, &measures);
        }
    }

    fn define_coordinates(&mut self, node: &Node, measures: &[[(Measure, Quantity); 2]]) {
        for (idx, (name, span)) in coordinate_names(node, self.text).into_iter().enumerate() {
            if !self.usable_name(&name, &span, "coordinate") {
                continue;
            }
            for (at, suffix) in ["", "_dot"].into_iter().enumerate() {
                let full = format!("{name}{suffix}");
                // A name too many is reported with its table; here it only must not be unknown.
                let known = measures.get(idx).map(|pair| pair[at]);
                let meaning =
                    known.map_or(Meaning::Faulty, |(measure, _)| Meaning::Measure(measure));
                if !self.define(&full, meaning, Some(span.clone())) {
                    break;
                }
                if let Some((_, quantity)) = known {
                    self.names.quantities.insert(full, quantity);
                }
            }
        }
    }
}

/// Names in a text or an array of texts, with their positions.
pub(super) fn coordinate_names(node: &Node, source: &str) -> Vec<(String, Span)> {
    let nodes = match &node.value {
        Value::Array(values) => values.iter().collect(),
        _ => vec![node],
    };
    nodes
        .into_iter()
        .filter_map(|node| node.text(source))
        .map(|quoted| (quoted.text.to_owned(), quoted.span_of(&(0..quoted.text.len()))))
        .collect()
}

/// The tables below a section, in file order: name, position of the name, table if it is one.
pub(super) fn sub_tables<'t>(
    root: &'t Table,
    section: &str,
) -> Vec<(&'t str, Span, Option<&'t Table>)> {
    let Some(entry) = root.get(section) else { return Vec::new() };
    let Value::Table(table) = &entry.node.value else { return Vec::new() };
    let as_table = |node: &'t Node| match &node.value {
        Value::Table(table) => Some(table),
        _ => None,
    };
    table
        .entries
        .iter()
        .map(|entry| (entry.key.as_str(), entry.key_span.clone(), as_table(&entry.node)))
        .collect()
}

/// The entries of a section that is a table, whatever their values.
pub(super) fn entries_of<'t>(root: &'t Table, section: &str) -> &'t [Entry] {
    match root.get(section).map(|entry| &entry.node.value) {
        Some(Value::Table(table)) => &table.entries,
        _ => &[],
    }
}

/// The section of a kind: `bodies` for `body`.
/// The names of the forces of a coupling, whose own name is `name`.
fn forces_of(name: &str, table: &Table) -> Vec<(String, MotionKind)> {
    use MotionKind::{Rotation, Translation};
    let text = |node: &Node| match &node.value {
        Value::Text(text) => Some(text.clone()),
        _ => None,
    };
    let list = |key: &str| match table.get(key).map(|entry| &entry.node.value) {
        Some(Value::Array(nodes)) => nodes.as_slice(),
        _ => &[],
    };
    let has = |keys: &[&str]| keys.iter().any(|key| table.get(key).is_some());
    let word = table.get("type").and_then(|entry| text(&entry.node)).unwrap_or_default();
    let wheels: Vec<Option<String>> = list("between").iter().map(text).collect();
    let is_loop = wheels.len() > 2 || has(&["turns", "length"]);
    let own = |kind| (name.to_owned(), kind);
    let with_sides = |kind: MotionKind| {
        let sides = ["forward", "back"].map(|side| (format!("{name}_{side}"), kind));
        let sides = sides.into_iter().filter(|_| has(&["backlash"]));
        std::iter::once(own(kind)).chain(sides).collect()
    };
    match word.as_str() {
        "rope" => {
            let parts = (1..list("over").len()).map(|k| (format!("{name}_{k}"), Translation));
            std::iter::once(own(Translation)).chain(parts).collect()
        }
        "belt" | "chain" if is_loop => {
            let next = wheels.iter().cycle().skip(1);
            let strand = |(from, to): (&Option<String>, &Option<String>)| {
                Some((format!("{name}_{}_{}", from.as_ref()?, to.as_ref()?), Translation))
            };
            wheels.iter().zip(next).filter_map(strand).collect()
        }
        // Teeth that give have signals in place of a multiplier.
        "gear" | "rack" if has(&["stiffness"]) => Vec::new(),
        "gear" | "belt" | "chain" if !has(&["radii", "module"]) => with_sides(Rotation),
        "gear" | "belt" | "chain" | "rack" | "screw" => with_sides(Translation),
        _ => Vec::new(),
    }
}

fn plural(kind: &str) -> String {
    if kind == "body" { "bodies".to_owned() } else { format!("{kind}s") }
}
