//! `[clocks.…]`, and the signals that have one: values that change at ticks and are held in between.

use bksim_expr::{Expr, Function, Syntax, SyntaxKind};

use super::codes;
use super::dimension::Dimension;
use super::gather::sub_tables;
use super::lower::Context;
use super::names::{Meaning, PREVIOUS, SampledName};
use super::reader::{Fields, Reader};
use super::replay::{Constant, Constants};
use super::tree::Table;
use super::units::Quantity;
use super::value::{Kind, Lowered, Scalar, Scope};
use super::words::cut;
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::ClockId;
use crate::message::short;
use crate::state::{Clock, HeldChange, HeldSignal};

/// Functions that round; all are made of the first.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Rounding {
    Floor,
    Ceil,
    Round,
    Mod,
}

/// Keys of a clock.
pub(super) const CLOCK_KEYS: [&str; 2] = ["every", "start"];

/// Their names.
pub(super) const ROUNDINGS: [(&str, Rounding); 4] = [
    ("floor", Rounding::Floor),
    ("ceil", Rounding::Ceil),
    ("round", Rounding::Round),
    ("mod", Rounding::Mod),
];

impl Rounding {
    pub(super) fn named(name: &str) -> Option<Self> {
        ROUNDINGS.iter().find(|(known, _)| *known == name).map(|(_, rounding)| *rounding)
    }
}

/// The names that an expression needs at once, and those of which it needs what was before.
pub(super) fn names_used(syntax: &Syntax) -> [Vec<&str>; 2] {
    let earlier: Vec<usize> = syntax
        .nodes
        .iter()
        .filter_map(|node| match &node.kind {
            SyntaxKind::Call { name, arguments, .. } if name == PREVIOUS => Some(arguments),
            _ => None,
        })
        .flatten()
        .copied()
        .collect();
    let mut used = [Vec::new(), Vec::new()];
    for (idx, node) in syntax.nodes.iter().enumerate() {
        if let SyntaxKind::Name(name) = &node.kind {
            used[usize::from(earlier.contains(&idx))].push(name.as_str());
        }
    }
    used
}

impl Reader<'_> {
    /// Reads the clocks.
    pub(super) fn read_clocks(&mut self, root: &Table) -> Vec<Clock> {
        let mut clocks = Vec::new();
        for (name, span, table) in sub_tables(root, "clocks") {
            let is_usable = self.usable_name(name, &span, "clock");
            let Some(table) = table else {
                self.not_a_table("clock", name, &span);
                continue;
            };
            let owner = format!("clock `{name}`");
            let fields = Fields::open(self, table, owner, span.clone(), &CLOCK_KEYS);
            let every = fields.require(self, "every", "write for example `every = \"2 ms\"`");
            let every = every.and_then(|node| {
                self.scalar(node, Quantity::INTERVAL, &fields.what("every"), Scope::Constant)
            });
            let start = match fields.get("start") {
                Some(node) => {
                    let what = fields.what("start");
                    self.scalar(node, Quantity::INTERVAL, &what, Scope::Constant).map(|s| s.expr)
                }
                None => Some(self.pool.zero()),
            };
            let (Some(every), Some(start), true) = (every, start, is_usable) else { continue };
            if self.is_period(&fields.owner, &every) {
                clocks.push(Clock { name: name.to_owned(), start, every: every.expr, span });
            }
        }
        clocks
    }

    /// True where a clock has a period greater than zero; reports where it has not.
    fn is_period(&mut self, owner: &str, every: &Scalar) -> bool {
        let zero = Constant::written(0.0);
        let Some(value) = every.value.filter(|&value| !self.constants.is_above(value, zero)) else {
            return true;
        };
        let message = format!("{owner} ticks every {} s", short(value.look()));
        self.report(
            Diagnostic::error(codes::BAD_CLOCK, message)
                .at(every.span.clone(), "must be greater than 0")
                .help("write the time from tick to tick, for example \"2 ms\""),
        );
        false
    }

    /// The names of a signal with a clock, before any expression uses it.
    pub(super) fn name_sampled(
        &mut self,
        root: &Table,
        (name, value_idx): (&str, usize),
        fields: &Fields<'_>,
    ) -> Option<()> {
        let node = fields.get("clock")?;
        let quoted = self.text_of(node, &fields.what("clock"), "c")?;
        let clocks = sub_tables(root, "clocks");
        let Some(clock) = clocks.iter().position(|(known, ..)| *known == quoted.text) else {
            let names: Vec<&str> = clocks.iter().map(|(known, ..)| *known).collect();
            let message = format!("{} has the unknown clock `{}`", fields.owner, cut(quoted.text));
            let location = quoted.span_of(&(0..quoted.text.len()));
            if names.is_empty() {
                self.report(
                    Diagnostic::error(codes::UNKNOWN_CLOCK, message)
                        .at(location, "no clock has this name")
                        .help(format!(
                            "add `[clocks.{}]` with `every = \"2 ms\"`",
                            cut(quoted.text)
                        )),
                );
            } else {
                let label = "no clock has this name";
                self.unknown(
                    codes::UNKNOWN_CLOCK,
                    message,
                    (location, label),
                    (quoted.text, &names),
                );
            }
            return None;
        };
        let start = match fields.get("start") {
            Some(node) => Some(self.lowered(node, &fields.what("start"), Scope::Constant)?),
            None => None,
        };
        let symbols = [name.to_owned(), format!("'{PREVIOUS}_{name}")];
        self.sampled.push(SampledName {
            value_idx,
            name: name.to_owned(),
            clock: ClockId(clock),
            start,
            symbols: symbols.map(|symbol| self.pool.symbol(&symbol)),
            was_used_early: false,
        });
        Some(())
    }

    /// The sampled signal of these names with its value at a tick, and what stands for it where it is used.
    pub(super) fn sampled_signal(
        &mut self,
        value_idx: usize,
        value: Lowered,
    ) -> Option<(HeldSignal, Lowered)> {
        let known = self.sampled.iter().find(|known| known.value_idx == value_idx)?.clone();
        let start = known.start.unwrap_or_else(|| {
            Lowered::new(self.pool.zero(), Kind::Bare, None, value.span.clone())
        });
        // One dimension of both.
        let (start_kind, value_kind) = (start.kind, value.kind);
        let (start, value) = match (start_kind, value_kind) {
            (Kind::Known(own), Kind::Known(found)) if own != found => {
                let message = format!("signal `{}` starts with another unit", known.name);
                self.report(
                    Diagnostic::error(codes::WRONG_DIMENSION, message)
                        .at(start.span, format!("in {}", words(own)))
                        .at(value.span, format!("in {}", words(found)))
                        .help("give `start` the unit of the value"),
                );
                return None;
            }
            (Kind::Known(own), Kind::Bare) => {
                let value = self.adopt(&value, own, start.is_angle);
                (start, value)
            }
            (Kind::Bare, Kind::Known(own)) => (self.adopt(&start, own, value.is_angle), value),
            _ => (start, value),
        };
        // A number without unit would have stood for one in units of the file.
        let is_bare_elsewhere = start_kind == Kind::Bare
            && known.was_used_early
            && matches!(value.kind, Kind::Known(own) if own != Dimension::NONE);
        if is_bare_elsewhere && !self.units.is_si() {
            let message = format!("`{PREVIOUS}({0})` needs the unit of `{0}`", known.name);
            self.report(
                Diagnostic::error(codes::NEEDS_UNIT, message)
                    .at(value.span, "no unit is known before this")
                    .help("add `start` with its unit"),
            );
            return None;
        }
        let [held, previous] = known.symbols.map(|symbol| self.pool.symbol_id(symbol));
        let signal = HeldSignal {
            name: known.name,
            held: held?,
            previous: previous?,
            start: start.expr,
            change: HeldChange::Tick { clock: known.clock, value: value.expr },
            span: value.span.clone(),
        };
        let held = Lowered {
            is_angle: value.is_angle,
            ..Lowered::new(known.symbols[0], value.kind, None, value.span)
        };
        Some((signal, held))
    }

    /// True where a value is held from tick to tick, or from event to event.
    pub(super) fn is_held(&self, expr: Expr) -> bool {
        let mut held =
            self.sampled.iter().map(|known| known.symbols[0]).chain(self.latched.clone());
        held.any(|symbol| {
            let symbol = self.pool.symbol_id(symbol);
            symbol.is_some_and(|symbol| self.pool.depends_on(expr, symbol))
        })
    }

    /// `previous(x)`: the value of a sampled signal before the last tick of its clock.
    pub(super) fn previous(
        &mut self,
        arguments: &[usize],
        span: Span,
        context: &Context<'_>,
    ) -> Option<Lowered> {
        let fault = |message: String| {
            Diagnostic::error(codes::NOT_SAMPLED, message).at(span.clone(), "not held by any clock")
        };
        if context.scope != Scope::Tick {
            let message = format!("{} uses `{PREVIOUS}`, but is not sampled", context.what);
            self.report(fault(message).help("give the signal a `clock`, or use a sampled signal"));
            return None;
        }
        let argument = match arguments {
            [only] => match &context.syntax.nodes[*only].kind {
                SyntaxKind::Name(name) => Some(name.as_str()),
                _ => None,
            },
            _ => None,
        };
        let value_idx = argument.and_then(|name| match self.names.plain(name) {
            Some(Meaning::Value(idx)) => Some(idx),
            _ => None,
        });
        let place =
            value_idx.and_then(|idx| self.sampled.iter().position(|known| known.value_idx == idx));
        let Some(place) = place else {
            let message =
                format!("{}: `{PREVIOUS}` takes the name of a sampled signal", context.what);
            let help = "name what it takes as a signal with a `clock`, and write `previous(name)`";
            self.report(fault(message).help(help));
            return None;
        };
        let lowered = value_idx.and_then(|idx| self.value_of(idx));
        let known = &mut self.sampled[place];
        known.was_used_early |= lowered.is_none();
        let kind = lowered.as_ref().or(known.start.as_ref());
        let (kind, is_angle) = kind.map_or((Kind::Bare, false), |it| (it.kind, it.is_angle));
        Some(Lowered { is_angle, ..Lowered::new(known.symbols[1], kind, None, span) })
    }

    /// `floor(x)`, `ceil(x)`, `round(x)` of pure numbers, `mod(a, b)` = a − b ⌊a/b⌋.
    pub(super) fn rounded(
        &mut self,
        rounding: Rounding,
        arguments: &[Option<Lowered>],
        (span, name_span): (Span, Span),
        context: &Context<'_>,
    ) -> Option<Lowered> {
        let name = ROUNDINGS[rounding as usize].0;
        let arity = if rounding == Rounding::Mod { 2 } else { 1 };
        if arguments.len() != arity {
            let plural = if arity == 1 { "" } else { "s" };
            let message =
                format!("`{name}` takes {arity} argument{plural}, found {}", arguments.len());
            let example = ["x", "a, b"][arity - 1];
            self.report(
                Diagnostic::error(codes::EXPRESSION, message)
                    .at(name_span, "")
                    .help(format!("give it what it takes: `{name}({example})`")),
            );
            return None;
        }
        let is_constant = arguments.iter().flatten().all(|argument| argument.value.is_some());
        if context.scope != Scope::Tick && !is_constant {
            let message = format!("{} uses `{name}`, but is not sampled", context.what);
            self.report(
                Diagnostic::error(codes::NOT_SAMPLED, message)
                    .at(name_span, "jumps at instants that nobody waits for")
                    .help("put it into a signal with a `clock`, and use that"),
            );
            return None;
        }
        let mut arguments = arguments.iter().cloned().collect::<Option<Vec<_>>>()?;
        if rounding == Rounding::Mod {
            let (a, b) = self.alike(&arguments[0], &arguments[1], "divide")?;
            let pool = &self.pool;
            let count = pool.call(Function::Floor, &[pool.div(a.expr, b.expr)])?;
            let expr = pool.sub(a.expr, pool.mul(b.expr, count));
            let value = a.value.zip(b.value).map(|(a, b)| {
                let ratio = self.constants.divide(a, b);
                let count = self.constants.call(Function::Floor, &[ratio]);
                let whole = self.constants.multiply(b, count);
                self.constants.subtract(a, whole)
            });
            let is_angle = a.is_angle;
            return Some(Lowered { is_angle, ..Lowered::new(expr, a.kind, value, span) });
        }
        let argument = arguments.remove(0);
        self.pure(&argument, &format!("the argument of `{name}`"), context)?;
        let rounded = self.rounded_number(rounding, &argument)?;
        Some(Lowered { span, ..rounded })
    }

    /// A pure number rounded.
    fn rounded_number(&mut self, rounding: Rounding, argument: &Lowered) -> Option<Lowered> {
        let (pool, constants) = (&self.pool, &mut self.constants);
        let floor = |x: Expr, value: Option<Constant>, constants: &mut Constants| {
            let value = value.map(|value| constants.call(Function::Floor, &[value]));
            Some((pool.call(Function::Floor, &[x])?, value))
        };
        let (x, value) = (argument.expr, argument.value);
        let (expr, value) = match rounding {
            Rounding::Ceil => {
                let minus = value.map(|value| constants.negate(value));
                let (expr, value) = floor(pool.neg(x), minus, constants)?;
                (pool.neg(expr), value.map(|value| constants.negate(value)))
            }
            Rounding::Round => {
                let half = Constant::written(0.5);
                let shifted = value.map(|value| constants.add(value, half));
                floor(pool.add(x, pool.rational(1, 2)), shifted, constants)?
            }
            Rounding::Floor | Rounding::Mod => floor(x, value, constants)?,
        };
        Some(Lowered::new(expr, argument.kind, value, argument.span.clone()))
    }
}

/// A dimension in words.
fn words(dimension: Dimension) -> String {
    if dimension == Dimension::NONE { "no unit".to_owned() } else { dimension.to_string() }
}
