//! [`Reader`]: the state that all parts of the file reader share, and access to tables that reports
//! unknown, missing and misplaced keys once each.

use bksim_expr::{Expr, Pool};

use super::Formula;
use super::beam_parts::Parts;
use super::codes;
use super::definition::ParameterState;
use super::grids::MeasuredTable;
use super::letters::{first_foreign, spelled, visible};
use super::misplaced::{meant_key, meant_type, misplaced};
use super::names::{Names, SampledName};
use super::naming::is_name;
use super::play::Play;
use super::replay::{Constant, Constants};
use super::tree::{Entry, Node, Quoted, Table, Value};
use super::units::FileUnits;
use super::value::Lowered;
use super::words::{closest, cut, suggest};
use crate::belt::Belt;
use crate::body::Anchor;
use crate::curve::{CamLaw, Curve};
use crate::diagnostic::{Code, Diagnostic, Span};
use crate::ids::BodyId;
use crate::load::Load;
use crate::load_case::LoadCase;
use crate::measure::Signal;
use crate::rope::Rope;
use crate::state::{HeldSignal, NamedSignal};
use crate::table::{MeasuredCurve, NamedFunction, TableCall};

/// Faults after which further ones are no longer explained; comparing names takes time.
const ENOUGH: usize = 200;

/// Elements that other programs have among joints or loads, and where they are written here.
const ELSEWHERE: [(&[&str], &str); 3] = [
    (
        &["gear", "belt", "chain", "rack", "rack-and-pinion", "pulley", "rope", "coupling"],
        "gears, belts, chains, ropes, racks and relations connect joints: they stand in `[couplings.NAME]`",
    ),
    (
        &["cam", "cam-follower", "curve"],
        "cams and tracks are curves, `[curves.NAME]`, which `point-on-curve` and `line-on-curve` follow",
    ),
    (&["motor", "drive", "actuator"], "prescribed motions stand in `[drives.NAME]`"),
];

/// The state of one reading.
pub(super) struct Reader<'a> {
    pub(super) text: &'a str,
    pub(super) nesting: usize,
    /// True if every body must have a mass.
    pub(super) needs_masses: bool,
    pub(super) pool: Pool,
    pub(super) units: FileUnits,
    pub(super) names: Names,
    pub(super) parameters: Vec<ParameterState>,
    /// Indices of the parameters, each after those it uses.
    pub(super) parameter_order: Vec<usize>,
    /// Tables, laws and paths that were called or named.
    pub(super) functions: Vec<NamedFunction>,
    /// Calls of those that have no value beyond their rows.
    pub(super) table_calls: Vec<TableCall>,
    /// Measured tables, in file order.
    pub(super) tables: Vec<MeasuredTable>,
    /// Measured curves of one argument, in the order in which they are stated.
    pub(super) measured: Vec<MeasuredCurve>,
    /// The paths of `[curves]` by name, `None` where one could not be read.
    pub(super) curves: Vec<(String, Option<Curve>)>,
    /// The laws of `[curves]` that could be read.
    pub(super) laws: Vec<CamLaw>,
    /// A name that stands for a symbol in the expression that is read.
    pub(super) local: Option<(String, Expr)>,
    /// The values of states, then of signals, once they are read.
    pub(super) values: Vec<Option<Lowered>>,
    /// Signals with a clock.
    pub(super) sampled: Vec<SampledName>,
    /// Belts around any number of wheels.
    pub(super) belts: Vec<Belt>,
    pub(super) ropes: Vec<Rope>,
    /// Ropes that may become slack.
    pub(super) rope_loads: Vec<Load>,
    /// Parts of flexible bodies.
    pub(super) flexible: Vec<Parts>,
    /// Their lengths, wraps and tensions.
    pub(super) belt_signals: Vec<NamedSignal>,
    /// Symbols that stand for positions at the start.
    pub(super) at_start: Vec<Signal>,
    /// Values of outputs that wait for the signals of couplings and beams.
    pub(super) waiting: Vec<usize>,
    /// Counts of the half turns of ropes and belts.
    pub(super) counts: Vec<HeldSignal>,
    /// Symbols of the signals that conditions latch.
    pub(super) latched: Vec<Expr>,
    pub(super) faults: Vec<Diagnostic>,
    /// How values follow from parameters that vary.
    pub(super) constants: Constants,
    /// Values of the parameters of a model that was read.
    pub(super) recorded: Option<Vec<Constant>>,
    /// First position with a part out of the plane z = 0.
    pub(super) spatial: Option<Span>,
    /// The points of each joint, predecessor first; `None` where the joint could not be read.
    pub(super) joint_ends: Vec<Option<[Anchor; 2]>>,
    /// The bodies of each joint, predecessor first; `None` where the joint could not be read.
    pub(super) joint_bodies: Vec<Option<[BodyId; 2]>>,
    /// True if a joint or a coupling could not be read, so that the topology and the names of its force are not known.
    pub(super) topology_unknown: bool,
    /// Parameters without unit that were multiplied as pure numbers, in a file with units of its own.
    pub(super) read_as_pure: Vec<usize>,
    /// Formulas that are no part of the text, and those that could be read.
    pub(super) formulas: &'a [Formula<'a>],
    pub(super) found: Vec<Expr>,
    /// The load cases of the text.
    pub(super) cases: Vec<LoadCase>,
    /// Joints with a clearance.
    pub(super) plays: Vec<Play>,
}

impl Reader<'_> {
    /// Records a fault.
    pub(super) fn report(&mut self, fault: Diagnostic) {
        self.faults.push(fault);
    }

    /// True if so much is wrong that looking further costs time without helping anyone.
    pub(super) fn has_seen_enough(&self) -> bool {
        self.faults.len() > ENOUGH && self.faults.iter().any(Diagnostic::is_error)
    }

    /// The table a node must be.
    pub(super) fn table<'n>(&mut self, node: &'n Node, what: &str) -> Option<&'n Table> {
        match &node.value {
            Value::Table(table) => Some(table),
            other => {
                self.wrong_kind(node, what, "a table", other, "write keys and values below it");
                None
            }
        }
    }

    /// The elements of an array.
    pub(super) fn array<'n>(
        &mut self,
        node: &'n Node,
        what: &str,
        expected: &str,
        example: &str,
    ) -> Option<&'n [Node]> {
        match &node.value {
            Value::Array(values) => Some(values),
            other => {
                self.wrong_kind(node, what, expected, other, &format!("for example {example}"));
                None
            }
        }
    }

    /// A quoted text.
    pub(super) fn text_of<'n>(
        &mut self,
        node: &'n Node,
        what: &str,
        example: &str,
    ) -> Option<Quoted<'n>> {
        let quoted = node.text(self.text);
        if quoted.is_none() {
            let help = format!("for example \"{example}\"");
            self.wrong_kind(node, what, "a text in quotes", &node.value, &help);
        }
        quoted
    }

    /// `true` or `false`.
    pub(super) fn flag(&mut self, node: &Node, what: &str) -> Option<bool> {
        match &node.value {
            Value::Bool(value) => Some(*value),
            other => {
                self.wrong_kind(node, what, "`true` or `false`", other, "write true or false");
                None
            }
        }
    }

    /// One of a few words.
    pub(super) fn choice<T: Copy>(
        &mut self,
        node: &Node,
        what: &str,
        choices: &[(&str, T)],
    ) -> Option<T> {
        let quoted = self.text_of(node, what, choices[0].0)?;
        let word = quoted.text;
        if let Some((_, value)) = choices.iter().find(|(name, _)| *name == word) {
            return Some(*value);
        }
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        let location = quoted.span_of(&(0..word.len()));
        let message = format!("{what} cannot be `{}`", cut(word));
        let fault = Diagnostic::error(codes::NOT_A_CHOICE, message)
            .at(location, "not one of the choices")
            .help(match meant_type(word, &names) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => suggest(word, &names),
            });
        let elsewhere = ELSEWHERE.iter().find(|(words, _)| words.contains(&word));
        let is_element = what.starts_with("`type` of joint") || what.starts_with("`type` of load");
        self.report(match elsewhere.filter(|_| is_element) {
            Some((_, note)) => fault.note(*note),
            None => fault,
        });
        None
    }

    /// Reports a value of the wrong kind.
    pub(super) fn wrong_kind(
        &mut self,
        node: &Node,
        what: &str,
        expected: &str,
        found: &Value,
        help: &str,
    ) {
        self.report(
            Diagnostic::error(
                codes::WRONG_KIND,
                format!("{what}: expected {expected}, found {}", found.describe()),
            )
            .at(node.span.clone(), "")
            .help(help),
        );
    }

    /// Reports a name that nothing has, with the nearest that exists.
    pub(super) fn unknown(
        &mut self,
        code: Code,
        message: String,
        (location, label): (Span, &str),
        (word, candidates): (&str, &[&str]),
    ) {
        if self.has_seen_enough() {
            return;
        }
        // Letters that nobody sees are shown by their numbers.
        let message = match first_foreign(word) {
            Some(_) => message.replace(word, &visible(word)),
            None => message,
        };
        let mut fault = Diagnostic::error(code, message).at(location, label);
        if candidates.iter().any(|known| known.eq_ignore_ascii_case(word)) {
            fault = fault.note("names are case-sensitive");
        }
        self.report(fault.help(suggest(word, candidates)));
    }

    /// Checks a name that the author chose. Reports and returns `false` when it cannot be used.
    pub(super) fn usable_name(&mut self, name: &str, location: &Span, what: &str) -> bool {
        if is_name(name) {
            return true;
        }
        let better = spelled(name, what.chars().next().unwrap_or('n'));
        let shown = visible(&cut(name));
        let fault = Diagnostic::error(codes::BAD_NAME, format!("`{shown}` cannot name a {what}"))
            .at(location.clone(), "letters a–z, digits and `_`, not starting with a digit")
            .help(format!("rename it, for example `{better}`"));
        self.report(match first_foreign(name) {
            Some(letter) => {
                fault.note(format!("character {} is {}", letter.character, letter.named()))
            }
            None => fault,
        });
        false
    }
}

/// Keys of one table of the model, for example those of body `crank`.
pub(super) struct Fields<'t> {
    table: &'t Table,
    /// `body `crank``.
    pub(super) owner: String,
    /// Position of its name.
    pub(super) span: Span,
    /// Keys an unknown key was probably meant to be: they are not reported as missing.
    excused: Vec<&'t str>,
}

impl<'t> Fields<'t> {
    /// Opens a table whose keys must be among `known`.
    pub(super) fn open(
        reader: &mut Reader<'_>,
        table: &'t Table,
        owner: String,
        span: Span,
        known: &[&'t str],
    ) -> Self {
        let free: Vec<&'t str> =
            known.iter().copied().filter(|known| table.get(known).is_none()).collect();
        let mut excused = Vec::new();
        for entry in &table.entries {
            let key = entry.key.as_str();
            if known.contains(&key) || reader.has_seen_enough() {
                continue;
            }
            if let Some(help) = misplaced(&owner, key) {
                let message = format!("unknown key `{key}` in {owner}");
                let fault = Diagnostic::error(codes::UNKNOWN_KEY, message);
                reader.report(fault.at(entry.key_span.clone(), "not a key here").help(help));
                continue;
            }
            if let Some(meant) = meant_key(&owner, entry, table.get("on").is_some(), &free) {
                excused.push(meant);
                let message = format!("unknown key `{key}` in {owner}");
                let fault = Diagnostic::error(codes::UNKNOWN_KEY, message);
                let written = &reader.text[entry.node.span.clone()];
                let help = match &entry.node.value {
                    Value::Text(_) | Value::Number { .. } if meant == "vector" => {
                        format!("write `vector = [{written}, 0]`")
                    }
                    _ => format!("write `{meant}` for it"),
                };
                reader.report(fault.at(entry.key_span.clone(), "not a key here").help(help));
                continue;
            }
            let meant = closest(key, &free);
            excused.extend(meant);
            let is_case = known.iter().any(|known| known.eq_ignore_ascii_case(key));
            if meant.is_none() && !is_case && first_foreign(key).is_none() && owner != "the model" {
                let message = format!("unknown key `{}` in {owner}", cut(key));
                let fault = Diagnostic::error(codes::UNKNOWN_KEY, message);
                let help = match free.as_slice() {
                    [] => "remove it".to_owned(),
                    [only] => format!("remove it, or write `{only}`"),
                    free => format!("remove it, or write {}", suggest("", free)),
                };
                reader.report(fault.at(entry.key_span.clone(), "not a key here").help(help));
                continue;
            }
            reader.unknown(
                codes::UNKNOWN_KEY,
                format!("unknown key `{}` in {owner}", cut(key)),
                (entry.key_span.clone(), "not a key here"),
                (key, if meant.is_some() { &free } else { known }),
            );
        }
        Self { table, owner, span, excused }
    }

    /// Opens a table whose `type` is one of some words, each with the keys that go with it; that word too.
    pub(super) fn of_type<'w>(
        reader: &mut Reader<'_>,
        table: &'t Table,
        owner: String,
        span: Span,
        types: &[(&'w str, &'static [&'static str])],
    ) -> Option<(&'w str, Self)> {
        let Some(entry) = table.get("type") else {
            // Without a type the other keys cannot be judged.
            let known: Vec<&str> = types.iter().flat_map(|(_, keys)| *keys).copied().collect();
            let fields = Self::open(reader, table, owner, span, &known);
            let help = format!("write for example `type = \"{}\"`", types[0].0);
            fields.require(reader, "type", &help);
            return None;
        };
        let words = types.iter().map(|of_type| (of_type.0, *of_type)).collect::<Vec<_>>();
        let what = format!("`type` of {owner}");
        let (word, keys) = reader.choice(&entry.node, &what, &words)?;
        Some((word, Self::open(reader, table, owner, span, keys)))
    }

    /// The position of the first of some keys that is there, else that of the table.
    pub(super) fn location(&self, keys: &[&str]) -> Span {
        let found = keys.iter().find_map(|key| self.get(key));
        found.map_or(&self.span, |node| &node.span).clone()
    }

    /// The value of a key.
    pub(super) fn get(&self, key: &str) -> Option<&'t Node> {
        self.entry(key).map(|entry| &entry.node)
    }

    /// The key with its value.
    pub(super) fn entry(&self, key: &str) -> Option<&'t Entry> {
        self.table.get(key)
    }

    /// Whether the key is there, or something that was probably meant to be it.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some() || self.excused.contains(&key)
    }

    /// The value of a key that must be there.
    pub(super) fn require(
        &self,
        reader: &mut Reader<'_>,
        key: &str,
        help: &str,
    ) -> Option<&'t Node> {
        let found = self.get(key);
        if found.is_none() && !self.excused.contains(&key) {
            reader.report(
                Diagnostic::error(codes::MISSING_KEY, format!("{} has no `{key}`", self.owner))
                    .at(self.span.clone(), format!("`{key}` is missing"))
                    .help(help),
            );
        }
        found
    }

    /// `stiffness` of load `s`, for messages.
    pub(super) fn what(&self, key: &str) -> String {
        format!("`{key}` of {}", self.owner)
    }

    /// Reports keys that exclude each other; `true` when both are there.
    pub(super) fn conflict(&self, reader: &mut Reader<'_>, one: &str, other: &str) -> bool {
        let (Some(first), Some(second)) = (self.entry(one), self.entry(other)) else {
            return false;
        };
        let (first, second) = if first.key_span.start < second.key_span.start {
            (first, second)
        } else {
            (second, first)
        };
        reader.report(
            Diagnostic::error(
                codes::KEY_CONFLICT,
                format!("{} has both `{one}` and `{other}`", self.owner),
            )
            .at(second.key_span.clone(), "excludes the other")
            .at(first.key_span.clone(), "the other")
            .help(format!("remove `{}` or `{}`", first.key, second.key)),
        );
        true
    }
}

/// The entry of a key, or one that was probably meant to be it: a misspelt key is reported once
/// and must not make what stands below it unknown.
pub(super) fn entry_like<'t>(table: &'t Table, key: &str) -> Option<&'t Entry> {
    let alike = |entry: &&Entry| closest(&entry.key, &[key]).is_some();
    table.get(key).or_else(|| table.entries.iter().find(alike))
}
