//! Signals with `when`: values that are latched by conditions, as those of a relay or a pawl are.

use bksim_expr::{BinaryOperator, Expr, Number, Syntax, SyntaxKind};

use super::codes;
use super::dimension::Dimension;
use super::names::PREVIOUS;
use super::reader::{Fields, Reader};
use super::tree::{Node, Value};
use super::value::{Kind, Lowered, Scope, describe};
use crate::diagnostic::Diagnostic;
use crate::state::{HeldChange, HeldSignal, LatchRow};

/// The way to write a latched signal.
const EXAMPLE: &str = "[{ condition = \"A.angle > 0.1 rad\", value = \"0 N m\" }]";

impl Reader<'_> {
    /// The value that stands for a latched signal where it is used: known by its start, before any expression.
    pub(super) fn name_latched(
        &mut self,
        name: &str,
        value_idx: usize,
        fields: &Fields<'_>,
    ) -> Option<Lowered> {
        if ["clock", "value"].iter().any(|key| fields.conflict(self, "when", key)) {
            return None;
        }
        let help = "write the value before any condition holds, for example `start = \"0 N\"`";
        let node = fields.require(self, "start", help)?;
        let start = self.lowered(node, &fields.what("start"), Scope::Constant)?;
        let symbol = self.pool.symbol(name);
        self.latched.push(symbol);
        let Lowered { kind, is_angle, ref span, .. } = start;
        let held = Lowered { is_angle, ..Lowered::new(symbol, kind, None, span.clone()) };
        self.values[value_idx] = Some(held);
        Some(start)
    }

    /// The rows of a latched signal that starts so, once every name has its meaning.
    pub(super) fn read_latched(
        &mut self,
        name: &str,
        fields: &Fields<'_>,
        start: &Lowered,
    ) -> Option<HeldSignal> {
        let node = fields.get("when")?;
        let what = fields.what("when");
        let rows = self.array(node, &what, "an array of conditions", EXAMPLE)?;
        if rows.is_empty() {
            self.report(
                Diagnostic::error(codes::NO_CONDITION, format!("{what} has no condition"))
                    .at(node.span.clone(), "never changes the signal")
                    .help(format!("write for example `when = {EXAMPLE}`, or a parameter instead")),
            );
            return None;
        }
        let rows: Vec<Option<LatchRow>> = rows
            .iter()
            .enumerate()
            .map(|(idx, row)| {
                let owner = format!("row {} of `when` of {}", idx + 1, fields.owner);
                self.latch_row(row, owner, start)
            })
            .collect();
        let rows = rows.into_iter().collect::<Option<Vec<_>>>()?;
        let symbol = |name: &str| self.pool.symbol_id(self.pool.symbol(name));
        Some(HeldSignal {
            held: symbol(name)?,
            previous: symbol(&format!("'{PREVIOUS}_{name}"))?,
            name: name.to_owned(),
            start: start.expr,
            change: HeldChange::Event { rows },
            span: node.span.clone(),
        })
    }

    fn latch_row(&mut self, node: &Node, owner: String, start: &Lowered) -> Option<LatchRow> {
        let Value::Table(table) = &node.value else {
            let help = "write for example { condition = \"A.angle > 0.1 rad\", value = \"0 N m\" }";
            self.wrong_kind(node, &owner, "a table", &node.value, help);
            return None;
        };
        let keys = &["condition", "value"];
        let fields = Fields::open(self, table, owner, node.span.clone(), keys);
        let help = "write for example `condition = \"A.angle > 0.1 rad\"`";
        let condition = fields.require(self, "condition", help);
        let condition = condition.and_then(|node| self.condition(node, &fields.what("condition")));
        let value = fields.require(self, "value", "write the value that the signal then takes");
        let value = value.and_then(|node| self.lowered(node, &fields.what("value"), Scope::Tick));
        let value = self.of_kind(value?, start, &fields.what("value"))?;
        Some(LatchRow { condition: condition?, value: value.expr })
    }

    /// An expression that is one where it holds, and zero elsewhere.
    fn condition(&mut self, node: &Node, what: &str) -> Option<Expr> {
        let quoted = self.text_of(node, what, "A.angle > 0.1 rad")?;
        let syntax = self.parse(&quoted, what, "A.angle > 0.1 rad")?;
        let lowered = self.lower(&syntax, &quoted, what, Scope::Motion)?;
        if is_condition(&syntax) {
            return Some(lowered.expr);
        }
        self.report(
            Diagnostic::error(codes::NO_CONDITION, format!("{what} compares nothing"))
                .at(lowered.span, "a quantity, not a condition")
                .help("compare two quantities by `<`, `<=`, `>` or `>=`, such as \"A.angle > 0.1 rad\""),
        );
        None
    }

    /// The value in the dimension of the start.
    fn of_kind(&mut self, value: Lowered, start: &Lowered, what: &str) -> Option<Lowered> {
        match (start.kind, value.kind) {
            (Kind::Known(own), Kind::Bare) => Some(self.adopt(&value, own, start.is_angle)),
            (Kind::Known(own), Kind::Known(found)) if own == found => Some(value),
            (Kind::Bare, Kind::Bare) => Some(value),
            (Kind::Bare, Kind::Known(found)) if found == Dimension::NONE => Some(value),
            (own, Kind::Known(found)) => {
                let words = match own {
                    Kind::Known(own) => describe(own, start.is_angle),
                    Kind::Bare => "a number without unit".to_owned(),
                };
                let message = format!("{what} has another unit than the start of its signal");
                self.report(
                    Diagnostic::error(codes::WRONG_DIMENSION, message)
                        .at(value.span, describe(found, value.is_angle))
                        .at(start.span.clone(), words)
                        .help("give `start` and all values one unit"),
                );
                None
            }
        }
    }
}

/// True of comparisons, and of `and`, `or` and `not` between conditions: an `and` is their product, an `or` their
/// larger one, and `not` what is left of one.
fn is_condition(syntax: &Syntax) -> bool {
    let mut holds: Vec<bool> = Vec::with_capacity(syntax.nodes.len());
    for node in &syntax.nodes {
        let is_condition = match &node.kind {
            SyntaxKind::Call { name, arguments, .. } => match name.as_str() {
                "lt" | "le" | "gt" | "ge" => true,
                "max" => arguments.iter().all(|&operand| holds[operand]),
                _ => false,
            },
            SyntaxKind::Binary { operator: BinaryOperator::Multiply, left, right, .. } => {
                holds[*left] && holds[*right]
            }
            SyntaxKind::Binary { operator: BinaryOperator::Subtract, left, right, .. } => {
                let one = SyntaxKind::Number(Number::from(1));
                syntax.nodes[*left].kind == one && holds[*right]
            }
            _ => false,
        };
        holds.push(is_condition);
    }
    holds.last() == Some(&true)
}
