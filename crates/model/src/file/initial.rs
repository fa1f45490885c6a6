//! `[initial]`: stated values of the start, and guesses that may move; orientations are in
//! [`super::orientation`].

use super::codes;
use super::names::{quantities, quantity_of};
use super::orientation::ORIENTATION_KEYS;
use super::reader::{Fields, Reader};
use super::stated::Stated;
use super::tree::{Entry, Node, Table, Value};
use super::units::Quantity;
use super::value::Scope;
use super::words::cut;
use crate::assembly::{AssemblyChoice, ChosenAssembly};
use crate::diagnostic::Diagnostic;
use crate::ids::{BodyId, JointId};
use crate::joint::motion_words;
use crate::measure::{Initial, Measure, Orientation};
use crate::measure_names::{BODY_WORDS, BodyWord, N_START_WORDS};

/// A key of an initial value, what it measures and its quantity.
type Row = (&'static str, Measure, Quantity);

/// The key that chooses an assembly.
const ASSEMBLY: &str = "assembly";

impl Reader<'_> {
    /// Reads the whole table, in file order.
    pub(super) fn read_initial(
        &mut self,
        root: &Table,
    ) -> (Vec<Initial>, Vec<Orientation>, Option<ChosenAssembly>) {
        let mut initial = Stated::default();
        let mut assembly = None;
        let table = root.get("initial").and_then(|entry| self.table(&entry.node, "`initial`"));
        let Some(table) = table else { return Default::default() };
        for entry in &table.entries {
            if self.is_assembly(entry) {
                assembly = self.read_assembly(entry);
            } else {
                self.read_entry(entry, &mut initial);
            }
        }
        initial.values.sort_by_key(|value| value.span.start);
        (initial.values, initial.orientations, assembly)
    }

    /// True for the key `assembly`, unless something of the model has this name.
    fn is_assembly(&self, entry: &Entry) -> bool {
        let name = entry.key.as_str();
        name == ASSEMBLY
            && self.names.coordinate(name).is_none()
            && self.names.joint(name).is_none()
            && self.names.body(name).is_none()
    }

    fn read_assembly(&mut self, entry: &Entry) -> Option<ChosenAssembly> {
        let node = &entry.node;
        let choice = match &node.value {
            // Attributes of drawings are texts.
            Value::Text(name) => match name.trim().parse() {
                Ok(number @ 1..) => AssemblyChoice::Number(number),
                _ => AssemblyChoice::Name(name.clone()),
            },
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a small integer"
            )]
            Value::Number { value, .. } if (1.0..1e6).contains(value) && value.fract() == 0.0 => {
                AssemblyChoice::Number(*value as usize)
            }
            found => {
                let help = "write a number or a name that `bksim kinematics --assemblies` lists";
                let what = "`assembly` in `[initial]`";
                self.wrong_kind(node, what, "a number from 1 on or a name", found, help);
                return None;
            }
        };
        Some(ChosenAssembly { choice, span: node.span.clone(), found: None })
    }

    fn read_entry(&mut self, entry: &Entry, initial: &mut Stated) {
        let name = entry.key.as_str();
        if let Some((measure, quantity)) = self.names.coordinate(name) {
            self.read_coordinate(entry, measure, quantity, initial);
            return;
        }
        // A joint or a body, with the measures that its keys name.
        let mut turned = None;
        let (owner, rows) = if let Some(joint) = self.names.joint(name) {
            let Some(rows) = self.joint_rows(joint) else { return };
            if rows.is_empty() {
                let message = format!("joint `{name}` has no motion that could start");
                self.report(
                    Diagnostic::error(codes::WRONG_JOINT, message)
                        .at(entry.key_span.clone(), "a joint without coordinates")
                        .help(format!("remove `{name}` from `[initial]`")),
                );
                return;
            }
            (format!("the start of joint `{name}`"), rows)
        } else if let Some(body) = self.names.body(name).filter(|body| body.0 > 0) {
            turned = Some(body);
            (format!("the start of body `{name}`"), body_rows(body))
        } else {
            self.unknown_start(entry);
            return;
        };
        // The stated values.
        let what = format!("`{name}` in `[initial]`");
        let Value::Table(table) = &entry.node.value else {
            let help = format!("write for example {{ {} = {} }}", rows[0].0, quoted(rows[0].2));
            self.wrong_kind(&entry.node, &what, "a table", &entry.node.value, &help);
            return;
        };
        let mut known: Vec<&str> = rows.iter().map(|(key, ..)| *key).collect();
        if turned.is_some() {
            known.extend(ORIENTATION_KEYS);
        }
        known.push("guess");
        let fields = Fields::open(self, table, owner.clone(), entry.key_span.clone(), &known);
        self.read_rows(name, &fields, &rows, false, initial);
        if let Some(body) = turned {
            self.read_orientation((name, body), &fields, false, initial);
        }
        // The guesses, one table deeper.
        let Some(guess) = fields.get("guess") else { return };
        let Value::Table(inner) = &guess.value else {
            let help = format!("write for example {{ {} = {} }}", rows[0].0, quoted(rows[0].2));
            self.wrong_kind(guess, &fields.what("guess"), "a table", &guess.value, &help);
            return;
        };
        known.pop();
        let owner = format!("the guess of {owner}");
        let inner = Fields::open(self, inner, owner, guess.span.clone(), &known);
        self.read_rows(name, &inner, &rows, true, initial);
        if let Some(body) = turned {
            self.read_orientation((name, body), &inner, true, initial);
        }
    }

    fn read_rows(
        &mut self,
        name: &str,
        fields: &Fields<'_>,
        rows: &[Row],
        is_guess: bool,
        initial: &mut Stated,
    ) {
        for (key, measure, quantity) in rows {
            let Some(node) = fields.get(key) else { continue };
            if let Value::Table(table) = &node.value
                && let Some(guess) = table.get("guess").filter(|_| !is_guess)
            {
                let value = self.text.get(guess.node.span.clone()).unwrap_or_default();
                let help = format!(
                    "write the guess around the key: `{name} = {{ guess = {{ {key} = {value} }} }}`"
                );
                self.wrong_kind(node, &fields.what(key), "a quantity", &node.value, &help);
                continue;
            }
            let read = self.read_value(node, &fields.what(key), *quantity, |value, span| Initial {
                measure: *measure,
                value,
                is_guess,
                name: format!("{name}.{key}"),
                span,
            });
            if let Some(value) = read {
                self.push_initial(value, initial);
            }
        }
    }

    /// A start by the name of a coordinate: a value, or `{ guess = value }`.
    fn read_coordinate(
        &mut self,
        entry: &Entry,
        measure: Measure,
        quantity: Quantity,
        initial: &mut Stated,
    ) {
        let what = format!("the start of `{}`", entry.key);
        let (node, is_guess) = match &entry.node.value {
            Value::Table(table) => {
                let span = entry.key_span.clone();
                let fields = Fields::open(self, table, what.clone(), span, &["guess"]);
                let help = format!("write {} or {{ guess = {0} }}", quoted(quantity));
                let Some(node) = fields.require(self, "guess", &help) else { return };
                (node, true)
            }
            _ => (&entry.node, false),
        };
        let read = self.read_value(node, &what, quantity, |value, span| Initial {
            measure,
            value,
            is_guess,
            name: entry.key.clone(),
            span,
        });
        if let Some(value) = read {
            self.push_initial(value, initial);
        }
    }

    fn read_value(
        &mut self,
        node: &Node,
        what: &str,
        quantity: Quantity,
        make: impl Fn(bksim_expr::Expr, crate::diagnostic::Span) -> Initial,
    ) -> Option<Initial> {
        let scalar = self.scalar(node, quantity, what, Scope::Constant)?;
        Some(make(scalar.expr, scalar.span))
    }

    fn joint_rows(&self, joint: JointId) -> Option<Vec<Row>> {
        let freedoms = self.names.joints[joint.0].freedoms?;
        let rows = freedoms.iter().enumerate().flat_map(|(idx, freedom)| {
            let ([value, rate, _], quantities) =
                (motion_words(freedoms, idx), quantities(*freedom));
            [
                (value, Measure::JointPosition(joint, idx), quantities[0]),
                (rate, Measure::JointVelocity(joint, idx), quantities[1]),
            ]
        });
        Some(rows.collect())
    }

    fn unknown_start(&mut self, entry: &Entry) {
        let mut names = self.owned_names(|names| names.joint_names());
        names.extend(self.owned_names(|names| names.body_names()).into_iter().skip(1));
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let key = entry.key.as_str();
        let message = format!("`[initial]` refers to unknown joint or body `{}`", cut(key));
        let label = (entry.key_span.clone(), "no joint or body has this name");
        let code = codes::UNKNOWN_BODY;
        self.unknown(code, message, label, (key, &names));
    }
}

fn body_rows(body: BodyId) -> Vec<Row> {
    let row = |&(key, measure): &BodyWord| {
        let measure = measure(body, None);
        (key, measure, quantity_of(measure))
    };
    BODY_WORDS[..N_START_WORDS].iter().map(row).collect()
}

/// An example as it stands in a file.
fn quoted(quantity: Quantity) -> String {
    format!("\"{}\"", quantity.example)
}
