//! `[states.…]`, `[signals.…]` and `[outputs]`: quantities that are integrated with the motion, and named expressions
//! of both, some of them sampled or latched, some of results alone.

use std::ops::Range;

use bksim_expr::Expr;

use super::codes;
use super::dimension::Dimension;
use super::gather::{entries_of, sub_tables};
use super::names::{Meaning, Names};
use super::reader::{Fields, Reader};
use super::sampled::names_used;
use super::tree::{Entry, Node, Table, Value};
use super::units::Quantity;
use super::value::{Kind, Lowered, Scope};
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::StateId;
use crate::measure::{Initial, Measure};
use crate::state::{Clock, HeldSignal, NamedSignal, State};

/// The content of the sections of controllers.
#[derive(Default)]
pub(super) struct Controllers {
    pub(super) states: Vec<State>,
    pub(super) signals: Vec<NamedSignal>,
    pub(super) clocks: Vec<Clock>,
    pub(super) held: Vec<HeldSignal>,
    /// The starts of the states.
    pub(super) initial: Vec<Initial>,
}

/// A table of one of the sections.
struct ControllerEntry<'t> {
    /// Place among the values of the reader.
    value_idx: usize,
    name: &'t str,
    span: Span,
    table: &'t Table,
}

/// The dimension of a state, and whether it is an angle.
struct StateUnit {
    dimension: Dimension,
    is_angle: bool,
}

/// Keys of a state.
pub(super) const STATE_KEYS: [&str; 2] = ["rate", "start"];
/// Keys of a signal, whichever it is.
pub(super) const SIGNAL_KEYS: [&str; 4] = ["when", "start", "clock", "value"];

impl Reader<'_> {
    /// Gathers the names of states and signals.
    pub(super) fn gather_controllers(&mut self, root: &Table) {
        for (section, what) in [("states", "state"), ("signals", "signal")] {
            for (name, span, table) in sub_tables(root, section) {
                if table.is_none() {
                    self.not_a_table(what, name, &span);
                }
                self.gather_value(name, span, what);
            }
        }
        for Entry { key, key_span, .. } in entries_of(root, "outputs") {
            self.gather_value(key, key_span.clone(), "output");
        }
    }

    /// The name of a value that is read later.
    fn gather_value(&mut self, name: &str, span: Span, what: &str) {
        let meaning = Meaning::Value(self.values.len());
        self.values.push(None);
        if self.usable_name(name, &span, what) {
            self.define(name, meaning, Some(span));
        }
    }

    /// Reads states and signals, each signal after those it uses.
    pub(super) fn read_controllers(&mut self, root: &Table) -> Controllers {
        let mut controllers =
            Controllers { clocks: self.read_clocks(root), ..Controllers::default() };
        let all: Vec<(&str, Span, Option<&Table>)> = ["states", "signals"]
            .into_iter()
            .flat_map(|section| sub_tables(root, section))
            .collect();
        let n_states = sub_tables(root, "states").len();
        let entry = |range: Range<usize>| {
            let entries = all.iter().enumerate().skip(range.start).take(range.len());
            let entries = entries.filter_map(|(value_idx, (name, span, table))| {
                Some(ControllerEntry { value_idx, name, span: span.clone(), table: (*table)? })
            });
            entries.collect::<Vec<_>>()
        };
        let (states, signals) = (entry(0..n_states), entry(n_states..all.len()));

        // A state is known by its start, before any expression that uses it.
        let mut opened = Vec::new();
        for state in &states {
            let owner = format!("state `{}`", state.name);
            let fields = Fields::open(self, state.table, owner, state.span.clone(), &STATE_KEYS);
            let id = StateId(opened.len());
            let kind = self.read_state_start(state, id, &fields, &mut controllers.initial);
            opened.push((state, fields, kind));
        }
        let no_table = Table::default();
        let outputs = outputs_of(root, &no_table);
        self.waiting = self.waiting_outputs(&outputs);
        let is_early =
            |(entry, _): &(ControllerEntry<'_>, _)| !self.waiting.contains(&entry.value_idx);
        let early: Vec<_> = outputs.into_iter().filter(is_early).collect();
        self.read_signals(root, (&signals, &early), &mut controllers);
        for (id, (state, fields, start)) in opened.into_iter().enumerate() {
            let Some((read, own)) =
                start.as_ref().and_then(|_| self.read_state_rate(state, &fields))
            else {
                continue;
            };
            controllers.states.push(read);
            // A bare start is in the file's unit of the state.
            let Some(start) = start.filter(|start| start.kind == Kind::Bare) else { continue };
            let start = self.adopt(&start, own.dimension, own.is_angle);
            let is_own = |initial: &&mut Initial| initial.measure == Measure::State(StateId(id));
            controllers.initial.iter_mut().filter(is_own).for_each(|i| i.value = start.expr);
        }
        controllers
    }

    /// Reads the outputs that use signals which couplings and beams add to the results.
    pub(super) fn read_results(&mut self, root: &Table, controllers: &mut Controllers) {
        let is_late =
            |(entry, _): &(ControllerEntry<'_>, _)| self.waiting.contains(&entry.value_idx);
        let no_table = Table::default();
        let late: Vec<_> = outputs_of(root, &no_table).into_iter().filter(is_late).collect();
        self.read_signals(root, (&[], &late), controllers);
    }

    /// The values of outputs with names that nothing has before couplings and beams are read, and of outputs that use
    /// them.
    fn waiting_outputs(&mut self, outputs: &[(ControllerEntry<'_>, &Node)]) -> Vec<usize> {
        let n_faults = self.faults.len();
        let names = |(entry, node): &(ControllerEntry<'_>, &Node)| -> Vec<String> {
            let quoted = node.text(self.text);
            let syntax = quoted.and_then(|quoted| self.parse(&quoted, entry.name, "A.angle"));
            let names = syntax.as_ref().map(|syntax| names_used(syntax).concat());
            names.unwrap_or_default().into_iter().map(str::to_owned).collect()
        };
        let used: Vec<Vec<String>> = outputs.iter().map(names).collect();
        // Faults are told where the outputs are read.
        self.faults.truncate(n_faults);
        let is_unknown =
            |name: &String| !name.contains('.') && name != "pi" && self.names.plain(name).is_none();
        let mut is_waiting: Vec<bool> =
            used.iter().map(|names| names.iter().any(is_unknown)).collect();
        loop {
            let waits = |name: &String| {
                let of_name = outputs.iter().position(|(entry, _)| entry.name == name);
                of_name.is_some_and(|k| is_waiting[k])
            };
            let more: Vec<bool> = used.iter().map(|names| names.iter().any(waits)).collect();
            let more: Vec<bool> = is_waiting.iter().zip(more).map(|(a, b)| *a || b).collect();
            if more == is_waiting {
                break;
            }
            is_waiting = more;
        }
        let all = outputs.iter().zip(is_waiting);
        all.filter(|(_, waits)| *waits).map(|((entry, _), _)| entry.value_idx).collect()
    }

    /// The start of a state, whose dimension is that of the state.
    fn read_state_start(
        &mut self,
        state: &ControllerEntry<'_>,
        id: StateId,
        fields: &Fields<'_>,
        initial: &mut Vec<Initial>,
    ) -> Option<Lowered> {
        let help = "write for example `start = 0`";
        let node = fields.require(self, "start", help)?;
        let start = self.lowered(node, &fields.what("start"), Scope::Constant)?;
        let measure = Measure::State(id);
        let expr = self.names.signal(&self.pool, state.name, measure);
        let value = Lowered {
            is_angle: start.is_angle,
            ..Lowered::new(expr, start.kind, None, start.span.clone())
        };
        self.values[state.value_idx] = Some(value);
        initial.push(Initial {
            measure,
            value: start.expr,
            is_guess: false,
            name: state.name.to_owned(),
            span: start.span.clone(),
        });
        Some(start)
    }

    fn read_state_rate(
        &mut self,
        state: &ControllerEntry<'_>,
        fields: &Fields<'_>,
    ) -> Option<(State, StateUnit)> {
        let known = self.value_of(state.value_idx)?;
        let help = "write for example `rate = \"0.3 m - A.position\"`";
        let node = fields.require(self, "rate", help)?;
        let what = fields.what("rate");
        let rate = self.lowered(node, &what, Scope::Load)?;
        let second = Quantity::TIME.dimension();
        let (rate, dimension) = match (known.kind, rate.kind) {
            (Kind::Known(own), Kind::Bare) => {
                (self.adopt(&rate, own.over(second), false), Some(own))
            }
            (Kind::Known(own), Kind::Known(found)) if found == own.over(second) => {
                (rate, Some(own))
            }
            (Kind::Known(own), Kind::Known(found)) => {
                let message = format!(
                    "{what}: state `{}` is in {}, so its rate is in {}, found {}",
                    state.name,
                    text(own),
                    text(own.over(second)),
                    text(found)
                );
                self.report(
                    Diagnostic::error(codes::WRONG_DIMENSION, message)
                        .at(rate.span, "")
                        .help("give `start` the unit of the state, or change the rate"),
                );
                return None;
            }
            (Kind::Bare, Kind::Known(found)) => (rate, Some(found.times(second))),
            (Kind::Bare, Kind::Bare) => (rate, None),
        };
        let own = dimension.unwrap_or(Dimension::NONE);
        let is_angle = own == Dimension::NONE && (known.is_angle || rate.is_angle);
        let state = State {
            name: state.name.to_owned(),
            rate: rate.expr,
            units: [own.times(second), own, own.over(second)]
                .map(|dimension| dimension.to_string()),
            exponents: dimension.and_then(Dimension::whole),
            span: rate.span,
        };
        Some((state, StateUnit { dimension: own, is_angle }))
    }

    /// Lowers all signals and outputs, each after those it uses; those that use each other are named.
    fn read_signals(
        &mut self,
        root: &Table,
        (entries, outputs): (&[ControllerEntry<'_>], &[(ControllerEntry<'_>, &Node)]),
        controllers: &mut Controllers,
    ) {
        let (mut read, mut latched) = (Vec::new(), Vec::new());
        let mut open = self.open_states(root);
        self.infer_states(&mut open);
        for entry in entries {
            let owner = format!("signal `{}`", entry.name);
            if entry.table.get("when").is_some() {
                let fields =
                    Fields::open(self, entry.table, owner, entry.span.clone(), &SIGNAL_KEYS);
                if let Some(start) = self.name_latched(entry.name, entry.value_idx, &fields) {
                    latched.push((entry, fields, start));
                }
                continue;
            }
            let is_sampled = entry.table.get("clock").is_some();
            let keys: &[&str] =
                if is_sampled { &["clock", "value", "start"] } else { &["value", "clock"] };
            let fields = Fields::open(self, entry.table, owner, entry.span.clone(), keys);
            if is_sampled
                && self.name_sampled(root, (entry.name, entry.value_idx), &fields).is_none()
            {
                continue;
            }
            let scope = if is_sampled { Scope::Tick } else { Scope::Load };
            let help = "write for example `value = \"2 N/m*(0.3 m - A.position)\"`";
            let node = fields.require(self, "value", help);
            let what = fields.what("value");
            let syntax = node.and_then(|node| {
                let quoted = node.text(self.text)?;
                self.parse(&quoted, &what, "2 N")
            });
            read.push((entry, node, (what, scope), syntax));
        }
        for (entry, node) in outputs {
            let what = format!("output `{}`", entry.name);
            let quoted = node.text(self.text);
            let syntax = quoted.and_then(|quoted| self.parse(&quoted, &what, "A.angle"));
            read.push((entry, Some(*node), (what, Scope::Output), syntax));
        }
        // Those that a signal uses come first.
        let place = |names: &Names, name: &str| match names.plain(name) {
            Some(Meaning::Value(idx)) => read.iter().position(|(entry, ..)| entry.value_idx == idx),
            _ => None,
        };
        let mut used: Vec<[Vec<usize>; 2]> = read
            .iter()
            .map(|(.., syntax)| match syntax {
                Some(syntax) => names_used(syntax).map(|names| {
                    names.into_iter().filter_map(|name| place(&self.names, name)).collect()
                }),
                None => [Vec::new(), Vec::new()],
            })
            .collect();
        // Where that is possible also those from which states that they use have their units.
        for ((.., syntax), used) in read.iter().zip(&mut used).filter(|_| !open.is_empty()) {
            let names = syntax.as_ref().map(|syntax| names_used(syntax).concat());
            let behind = self.names_behind(&open, &names.unwrap_or_default());
            used[1].extend(behind.iter().filter_map(|name| place(&self.names, name)));
        }
        let (order, circle) = ordered(&used);
        if !circle.is_empty() {
            let names: Vec<String> =
                circle.iter().map(|&k| format!("`{}`", read[k].0.name)).collect();
            let (first, _, (_, scope), _) = &read[circle[0]];
            let help = if *scope == Scope::Tick {
                "use `previous(…)` of one of them, or a quantity of the motion instead"
            } else {
                "make one of them a state, or use a quantity of the motion instead"
            };
            self.report(
                Diagnostic::error(
                    codes::ALGEBRAIC_LOOP,
                    format!("signals follow from each other: {}", names.join(" → ")),
                )
                .at(first.span.clone(), "part of the circle")
                .note("a signal has its value at once, so it cannot depend on itself")
                .help(help),
            );
        }
        for k in order {
            let (entry, node, (what, scope), syntax) = &read[k];
            let scope = *scope;
            let value = match (node, syntax) {
                (Some(node), Some(syntax)) => {
                    node.text(self.text).and_then(|quoted| self.lower(syntax, &quoted, what, scope))
                }
                (Some(node), None) if matches!(node.value, Value::Number { .. }) => {
                    self.lowered(node, what, scope)
                }
                (Some(node), None) => {
                    if !matches!(node.value, Value::Text(_)) {
                        let help = "write an expression in quotes, such as \"2*A.angle\"";
                        self.wrong_kind(node, what, "an expression", &node.value, help);
                    }
                    None
                }
                (None, _) => None,
            };
            let Some(mut value) = value else { continue };
            if scope == Scope::Tick {
                let Some((signal, held)) = self.sampled_signal(entry.value_idx, value) else {
                    continue;
                };
                controllers.held.push(signal);
                value = held;
            }
            let is_output = scope == Scope::Output;
            controllers.signals.push(NamedSignal { is_output, ..named_signal(entry.name, &value) });
            self.values[entry.value_idx] = Some(value);
            self.infer_states(&mut open);
        }
        // Conditions may use all of them.
        for (entry, fields, start) in latched {
            if let Some(held) = self.value_of(entry.value_idx) {
                controllers.signals.push(named_signal(entry.name, &held));
            }
            controllers.held.extend(self.read_latched(entry.name, &fields, &start));
        }
    }

    /// The value of a state or signal where it is used.
    pub(super) fn value_of(&self, value_idx: usize) -> Option<Lowered> {
        self.values[value_idx].clone()
    }

    /// True where an expression follows something of the motion.
    pub(super) fn moves(&self, expr: Expr) -> bool {
        self.names.signals.iter().any(|signal| self.pool.depends_on(expr, signal.symbol))
            || self.is_held(expr)
    }

    /// True where an expression depends on reactions.
    pub(super) fn presses(&self, expr: Expr) -> bool {
        let mut reactions = self.names.signals.iter().filter(|s| s.measure.is_reaction());
        reactions.any(|signal| self.pool.depends_on(expr, signal.symbol))
    }

    /// True where an expression depends on accelerations.
    pub(super) fn accelerates(&self, expr: Expr) -> bool {
        let mut found = self.names.signals.iter().filter(|s| s.measure.is_acceleration());
        found.any(|signal| self.pool.depends_on(expr, signal.symbol))
    }

    /// True where an expression depends on parameters, positions and values that are held alone.
    pub(super) fn follows_positions(&self, expr: Expr) -> bool {
        let time = self.pool.symbol_id(self.pool.symbol("t"));
        let follows_time = time.is_some_and(|time| self.pool.depends_on(expr, time));
        let mut rates = self.names.signals.iter().filter(|signal| signal.measure.is_velocity());
        !follows_time && !rates.any(|signal| self.pool.depends_on(expr, signal.symbol))
    }

    /// A value of any dimension.
    pub(super) fn lowered(&mut self, node: &Node, what: &str, scope: Scope) -> Option<Lowered> {
        match &node.value {
            Value::Number { value, digits } => {
                self.literal(*value, digits, what, "0.5", &node.span)
            }
            Value::Text(_) => {
                let quoted = node.text(self.text)?;
                let syntax = self.parse(&quoted, what, "0.5")?;
                self.lower(&syntax, &quoted, what, scope)
            }
            other => {
                self.wrong_kind(node, what, "a quantity", other, "for example \"0.5 m\"");
                None
            }
        }
    }
}

/// A signal with the unit that its value has.
fn named_signal(name: &str, value: &Lowered) -> NamedSignal {
    let unit = match value.kind {
        Kind::Known(Dimension::NONE) if value.is_angle => "rad".to_owned(),
        Kind::Known(dimension) => dimension.to_string(),
        Kind::Bare => String::new(),
    };
    let (name, span) = (name.to_owned(), value.span.clone());
    NamedSignal { name, value: value.expr, unit, is_output: false, span }
}

/// An order in which each comes after those it uses at once, and after those of which it uses what was before
/// where that is possible; and the members of a circle, if there is one.
fn ordered(used: &[[Vec<usize>; 2]]) -> (Vec<usize>, Vec<usize>) {
    let mut order: Vec<usize> = Vec::new();
    let mut is_done = vec![false; used.len()];
    loop {
        let are_done = |others: &[usize]| others.iter().all(|&other| is_done[other]);
        let left = || (0..used.len()).filter(|&k| !is_done[k] && are_done(&used[k][0]));
        let mut ready: Vec<usize> = left().filter(|&k| are_done(&used[k][1])).collect();
        if ready.is_empty() {
            ready.extend(left().next());
        }
        if ready.is_empty() {
            break;
        }
        for &k in &ready {
            is_done[k] = true;
        }
        order.extend(ready);
    }
    // From any that is left, the way along what it uses comes back to where it was.
    let Some(first) = is_done.iter().position(|done| !done) else { return (order, Vec::new()) };
    let mut way = vec![first];
    loop {
        let here = way[way.len() - 1];
        let Some(&next) = used[here][0].iter().find(|&&other| !is_done[other]) else { break };
        if let Some(start) = way.iter().position(|&known| known == next) {
            way.drain(..start);
            way.push(next);
            return (order, way);
        }
        way.push(next);
    }
    (order, way)
}

/// The outputs of a file, whose values follow those of states and signals.
fn outputs_of<'t>(root: &'t Table, table: &'t Table) -> Vec<(ControllerEntry<'t>, &'t Node)> {
    let n_before = sub_tables(root, "states").len() + sub_tables(root, "signals").len();
    let output = |(idx, entry): (usize, &'t Entry)| {
        let Entry { key, key_span, node } = entry;
        let (value_idx, span) = (n_before + idx, key_span.clone());
        (ControllerEntry { value_idx, name: key, span, table }, node)
    };
    entries_of(root, "outputs").iter().enumerate().map(output).collect()
}

/// A dimension in words.
fn text(dimension: Dimension) -> String {
    if dimension == Dimension::NONE { "a pure number".to_owned() } else { dimension.to_string() }
}
