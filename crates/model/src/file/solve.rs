//! `[solve]`: time span, output interval, tolerances and method.

use super::codes;
use super::reader::{Fields, Reader};
use super::replay::{Constant, Setting};
use super::tree::{Node, Table, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::diagnostic::{Diagnostic, Span};
use crate::solve::{Formulation, Jit, Method, Outputs, SolveOptions};

pub(super) const SOLVE_KEYS: &[&str] = &[
    "t_start",
    "t_end",
    "every",
    "times",
    "rtol",
    "atol",
    "step",
    "newton_tolerance",
    "formulation",
    "method",
    "jit",
];

/// The smallest relative tolerance that numbers of 16 digits can keep through a step.
const SMALLEST_RTOL: f64 = 1e-13;

impl Reader<'_> {
    /// Reads the options; what is not stated keeps its default.
    pub(super) fn read_solve(&mut self, root: &Table) -> SolveOptions {
        // The defaults, which stand for what is not written.
        let mut solve = SolveOptions {
            t_start: 0.0,
            t_end: 10.0,
            every: None,
            outputs: Outputs::Even,
            rtol: 1e-6,
            atol: 1e-8,
            step: None,
            newton_tolerance: 1e-10,
            method: Method::default(),
            formulation: Formulation::default(),
            jit: Jit::default(),
            spans: Vec::new(),
        };
        let Some(entry) = root.get("solve") else { return solve };
        let Some(table) = self.table(&entry.node, "`solve`") else { return solve };
        let owner = "`[solve]`".to_owned();
        let fields = Fields::open(self, table, owner, entry.key_span.clone(), SOLVE_KEYS);
        for entry in &table.entries {
            solve.spans.push((entry.key.clone(), entry.node.span.clone()));
        }
        // Times and tolerances.
        self.read_times(&fields, &mut solve);
        if let Some((rtol, span)) = self.option(&fields, "rtol", Quantity::NUMBER) {
            let rtol = self.constants.pinned(rtol);
            self.check_rtol(rtol, span);
            solve.rtol = rtol;
        }
        if let Some((atol, _)) = self.positive_option(&fields, "atol", Quantity::NUMBER) {
            solve.atol = self.constants.pinned(atol);
        }
        let tolerance = self.positive_option(&fields, "newton_tolerance", Quantity::NUMBER);
        if let Some((tolerance, _)) = tolerance {
            solve.newton_tolerance = self.constants.pinned(tolerance);
        }
        // Choices among a few words.
        let formulations = [
            ("ggl", Formulation::Ggl),
            ("index2", Formulation::Index2),
            ("index3", Formulation::Index3),
            ("index1", Formulation::Index1),
        ];
        if let Some(node) = fields.get("formulation") {
            let what = fields.what("formulation");
            solve.formulation = self.choice(node, &what, &formulations).unwrap_or_default();
        }
        if let Some(node) = fields.get("method") {
            let methods =
                [("auto", Method::Auto), ("radau", Method::Radau), ("explicit", Method::Explicit)];
            solve.method = self.choice(node, &fields.what("method"), &methods).unwrap_or_default();
        }
        let is_explicit = solve.method == Method::Explicit;
        if let Some(node) = fields.get("formulation").filter(|_| is_explicit) {
            let message = "`formulation` has no effect with `method = \"explicit\"`";
            self.report(
                Diagnostic::warning(codes::KEY_CONFLICT, message)
                    .at(node.span.clone(), "only Radau IIA integrates a formulation")
                    .help("leave it out, or write `method = \"radau\"`"),
            );
        }
        if let Some(node) = fields.get("jit") {
            let choices = [("auto", Jit::Auto), ("on", Jit::On), ("off", Jit::Off)];
            solve.jit = self.choice(node, &fields.what("jit"), &choices).unwrap_or_default();
        }
        solve
    }

    fn read_times(&mut self, fields: &Fields<'_>, solve: &mut SolveOptions) {
        let start = self.option(fields, "t_start", Quantity::TIME);
        let end = self.option(fields, "t_end", Quantity::TIME);
        let written = |t: f64| Constant::written(t);
        let from = start.as_ref().map_or(written(solve.t_start), |(t, _)| *t);
        let to = end.as_ref().map_or(written(solve.t_end), |(t, _)| *t);
        solve.t_start = self.constants.set(Setting::Start, from);
        solve.t_end = self.constants.set(Setting::End, to);
        // A time that could not be read says nothing about the span.
        let known = |key: &str, read: bool| read || fields.get(key).is_none();
        let both = known("t_start", start.is_some()) && known("t_end", end.is_some());
        if both && !self.constants.differ(from, to) {
            let location = end.or(start).map_or(fields.span.clone(), |(_, span)| span);
            let from = solve.t_start;
            self.report(
                Diagnostic::error(
                    codes::BAD_TIME_SPAN,
                    format!("the end `t_end` = {from} s is the start `t_start` as well"),
                )
                .at(location, "the end must differ from the start")
                .help(format!("write for example `t_end = \"{} s\"`", from + 10.0)),
            );
        }
        self.read_outputs(fields, solve);
        let step = self.positive_option(fields, "step", Quantity::INTERVAL);
        solve.step = step.map(|(step, _)| self.constants.set(Setting::Step, step));
    }

    /// `every`, an interval or `"step"`, or `times`.
    fn read_outputs(&mut self, fields: &Fields<'_>, solve: &mut SolveOptions) {
        let every: Option<&Node> = fields.get("every");
        if every.is_some_and(|node| matches!(&node.value, Value::Text(text) if text == "step")) {
            solve.outputs = Outputs::Steps;
        } else {
            let every = self.positive_option(fields, "every", Quantity::INTERVAL);
            solve.every = every.map(|(every, _)| self.constants.set(Setting::Every, every));
        }
        let Some(node) = fields.get("times") else { return };
        let what = fields.what("times");
        if every.is_some() {
            self.report(
                Diagnostic::error(
                    codes::KEY_CONFLICT,
                    "both `every` and `times` say when to output",
                )
                .at(node.span.clone(), "given together with `every`")
                .help("leave out one of them"),
            );
        }
        let example = "`times = [0.1, \"500 ms\"]`";
        let Some(nodes) = self.array(node, &what, "an array of times", example) else { return };
        let read = |node| {
            let value = self.scalar(node, Quantity::TIME, &what, Scope::Constant)?.value;
            value.map(|value| self.constants.pinned(value))
        };
        solve.outputs = Outputs::Times(nodes.iter().filter_map(read).collect());
    }

    fn option(
        &mut self,
        fields: &Fields<'_>,
        key: &str,
        quantity: Quantity,
    ) -> Option<(Constant, Span)> {
        let node: &Node = fields.get(key)?;
        let scalar = self.scalar(node, quantity, &fields.what(key), Scope::Constant)?;
        Some((scalar.value?, scalar.span))
    }

    fn positive_option(
        &mut self,
        fields: &Fields<'_>,
        key: &str,
        quantity: Quantity,
    ) -> Option<(Constant, Span)> {
        let node: &Node = fields.get(key)?;
        let what = fields.what(key);
        let scalar = self.scalar(node, quantity, &what, Scope::Constant)?;
        self.check_positive(&what, &scalar, quantity).then_some(())?;
        Some((scalar.value?, scalar.span))
    }

    fn check_rtol(&mut self, rtol: f64, span: Span) {
        let fault = if rtol < SMALLEST_RTOL {
            let message = format!("`rtol` = {rtol:e} is below what numbers of 16 digits can hold");
            Diagnostic::error(codes::BAD_TOLERANCE, message)
                .at(span, "too small")
                .help(format!("the smallest useful value is {SMALLEST_RTOL:e}; 1e-6 is usual"))
        } else if rtol >= 1.0 {
            let message = format!("`rtol` = {rtol} asks for no correct digit");
            Diagnostic::error(codes::BAD_TOLERANCE, message)
                .at(span, "must be below 1")
                .help("write for example 1e-6 for six digits")
        } else {
            return;
        };
        self.report(fault);
    }
}
