//! Function calls in expressions: what each function takes and gives.

use bksim_expr::{COMPOSED, Expr, Function, function_names};

use super::codes;
use super::dimension::Dimension;
use super::lower::Context;
use super::misread::foreign_function;
use super::names::PREVIOUS;
use super::reader::Reader;
use super::replay::Constant;
use super::sampled::Rounding;
use super::value::{Kind, Lowered, PURE};
use super::words::{cut, suggest};
use crate::diagnostic::{Diagnostic, Span};
use crate::message::short;

impl Reader<'_> {
    pub(super) fn call(
        &mut self,
        name: &str,
        name_span: &Span,
        arguments: &[Option<Lowered>],
        span: Span,
        context: &Context<'_>,
    ) -> Option<Lowered> {
        let location = context.quoted.span_of(name_span);
        if let Some(table_idx) = self.table_named(name) {
            let arguments: Vec<Lowered> = arguments.iter().cloned().collect::<Option<_>>()?;
            return self.look_up(table_idx, &arguments, span, context.what);
        }
        if let Some(rounding) = Rounding::named(name) {
            return self.rounded(rounding, arguments, (span, location), context);
        }
        if self.has_wrong_count(name, arguments.len(), &location) {
            return None;
        }
        let Some(function) = Function::from_name(name) else {
            let tables: Vec<String> = self.tables.iter().map(|table| table.name.clone()).collect();
            let mut names: Vec<&str> = tables.iter().map(String::as_str).collect();
            function_names().for_each(|known| names.push(known));
            names.push(PREVIOUS);
            let message = format!("unknown function `{}`", cut(name));
            // The help of a function of another language is for the whole call.
            let of = |at: &Option<Lowered>| self.text.get(at.as_ref()?.span.clone());
            let texts: Option<Vec<&str>> = arguments.iter().map(of).collect();
            let texts = texts.filter(|_| context.quoted.start.is_some()).unwrap_or_default();
            let foreign = foreign_function(name, &texts);
            let location = if foreign.is_some() && !texts.is_empty() { span } else { location };
            self.report(
                Diagnostic::error(codes::UNKNOWN_FUNCTION, message)
                    .at(location, "no function has this name")
                    .note("`bksim explain M022` lists all functions")
                    .help(foreign.unwrap_or_else(|| suggest(name, &names))),
            );
            return None;
        };
        let arguments: Vec<Lowered> = arguments.iter().cloned().collect::<Option<_>>()?;
        self.apply(function, arguments, span, context)
    }

    /// Reports a call with more or fewer arguments than the function takes.
    fn has_wrong_count(&mut self, name: &str, found: usize, location: &Span) -> bool {
        let composed = COMPOSED.iter().find(|composed| composed.name == name);
        let (needs, example) = match (Function::from_name(name), composed) {
            (Some(function), _) if found == function.arity() => return false,
            // The written-out functions that are left have a wrong number.
            (_, Some(composed)) => (composed.arguments.split(',').count(), composed.arguments),
            (Some(function), None) => {
                let needs = function.arity();
                (needs, ["x", "x, y", "condition, x, y"][needs.clamp(1, 3) - 1])
            }
            (None, None) => return false,
        };
        let plural = if needs == 1 { "" } else { "s" };
        let message = format!("`{name}` takes {needs} argument{plural}, found {found}");
        self.report(
            Diagnostic::error(codes::EXPRESSION, message)
                .at(location.clone(), "")
                .help(format!("give it what it takes: `{name}({example})`")),
        );
        true
    }

    /// Applies a function, with what it needs and gives.
    fn apply(
        &mut self,
        function: Function,
        mut arguments: Vec<Lowered>,
        span: Span,
        context: &Context<'_>,
    ) -> Option<Lowered> {
        use Function as F;
        // The dimension of the value, from those of the arguments.
        let is_literal = arguments.iter().all(|argument| argument.is_literal);
        let role = format!("the argument of `{}`", function.name());
        let mut is_angle = matches!(function, F::Asin | F::Acos | F::Atan | F::Atan2);
        let kind = match function {
            F::Sin | F::Cos | F::Tan => {
                let is_constant = |a: &&Lowered| a.kind == Kind::Bare && a.value.is_some();
                let bare = Some(&arguments[0]).filter(is_constant);
                if let Some(number) = bare.or(arguments[0].addend.as_deref()) {
                    self.check_among_angles(&number.clone());
                }
                let adopted = self.adopt_if_bare(&arguments[0], true);
                self.pure(&adopted, &role, context)?;
                arguments[0] = adopted;
                PURE
            }
            F::Asin | F::Acos | F::Atan | F::Sinh | F::Cosh | F::Tanh | F::Exp | F::Ln => {
                self.pure(&arguments[0], &role, context)?;
                PURE
            }
            F::Sqrt => {
                self.power_kind(&arguments[0], Some(Constant::written(0.5)), &span, context)?
            }
            F::Abs => {
                is_angle = arguments[0].is_angle;
                arguments[0].kind
            }
            F::Sign => PURE,
            // Called by the names of `sampled`, which know what it takes.
            F::Floor => arguments[0].kind,
            F::Atan2 | F::Min | F::Max | F::Lt | F::Le | F::Gt | F::Ge | F::If => {
                let first = arguments.len() - 2;
                let (a, b) = self.alike(&arguments[first], &arguments[first + 1], "compare")?;
                let kept = (a.kind, a.is_angle);
                (arguments[first], arguments[first + 1]) = (a, b);
                if matches!(function, F::Min | F::Max | F::If) {
                    is_angle = kept.1;
                    kept.0
                } else {
                    PURE
                }
            }
        };
        // The expression and, where it is constant, its value.
        let operands: Vec<Expr> = arguments.iter().map(|argument| argument.expr).collect();
        let expr = self.pool.call(function, &operands)?;
        let values: Option<Vec<Constant>> =
            arguments.iter().map(|argument| argument.value).collect();
        let value = values.map(|values| self.constants.call(function, &values));
        if value.is_some_and(|value| value.look().is_nan()) {
            self.no_real_value(function, &arguments, &span);
            return None;
        }
        let is_literal = is_literal && kind == Kind::Bare;
        Some(Lowered { is_angle, is_literal, ..Lowered::new(expr, kind, value, span) })
    }

    fn adopt_if_bare(&mut self, lowered: &Lowered, is_angle: bool) -> Lowered {
        match lowered.kind {
            Kind::Bare => self.adopt(lowered, Dimension::NONE, is_angle),
            Kind::Known(_) => lowered.clone(),
        }
    }

    fn no_real_value(&mut self, function: Function, arguments: &[Lowered], span: &Span) {
        let values: Vec<String> = arguments
            .iter()
            .filter_map(|argument| argument.value)
            .map(|value| short(value.look()))
            .collect();
        let message =
            format!("`{}` of {} has no real value", function.name(), values.join(" and "));
        self.report(
            Diagnostic::error(codes::NOT_REAL, message)
                .at(span.clone(), "")
                .help("change the parameters it uses so that it stays in range"),
        );
    }
}
