//! `bksim expr`: the algebra by itself, on one expression.
//!
//! The expression is read, then changed by the operations that are asked for, always in the order
//! of the list below; the result is printed in the notation asked for.

use std::convert::Infallible;
use std::io::Read;
use std::ops::Range;
use std::path::PathBuf;

use bksim::expr::{
    Certificate, Expr, LowerError, Notation, Operations, ParseError, ParseErrorKind, ParseOptions,
    Pool, Printer, SolveError, SymbolId, parse,
};
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{WrittenUnit, code};
use serde_json::{Value, json};

use crate::args::{Expression, FormulaNotation};
use crate::exit::{Failure, Status};
use crate::output::{self, number, table};
use crate::render;
use crate::source::Text;

/// Longest text that is read from standard input.
const LONGEST_INPUT_BYTES: u64 = 16 * 1024 * 1024;

/// The results of the operations on an expression.
struct Results {
    read: Expr,
    result: Expr,
    /// The unknown of `--solve`.
    unknown: Option<SymbolId>,
    /// Expressions that must not be zero for the solution to hold.
    nonzero: Vec<Expr>,
    value: Option<f64>,
    /// The result against what it was before it was rewritten.
    certificate: Option<Certificate>,
}

pub(crate) fn run(args: &Expression, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let source = source(&args.text)?;
    let pool = Pool::new();
    let request = Request { pool: &pool, args, source: &source, nesting };
    let outcome = request.outcome()?;
    if as_json {
        output::json("expr", request.describe(&outcome))?;
    } else {
        output::text(&request.report(&outcome))?;
    }
    Ok(Status::Done)
}

/// The expression as written, or standard input for `-`.
fn source(argument: &str) -> Result<Text, Failure> {
    if argument != "-" {
        return Ok(Text::new("expression", argument));
    }
    let path = PathBuf::from("standard input");
    let mut text = String::new();
    let mut input = std::io::stdin().lock().take(LONGEST_INPUT_BYTES);
    match input.read_to_string(&mut text) {
        Ok(_) => Ok(Text::new(path, text.trim_end().to_owned())),
        Err(error) => Err(Failure::reading(&path, &error)),
    }
}

/// Operations of the longest result that is written: some ten megabytes.
const MOST_WRITTEN_OPERATIONS: u64 = 1_000_000;

struct Request<'a> {
    pool: &'a Pool,
    args: &'a Expression,
    source: &'a Text,
    nesting: usize,
}

impl Request<'_> {
    fn outcome(&self) -> Result<Results, Failure> {
        let (pool, args) = (self.pool, self.args);
        let read = self.read()?;
        let symbol = |name: &String| self.symbol(name);

        let mut map = Vec::new();
        for (name, text) in &args.substitute {
            map.push((self.symbol(name)?, self.argument("--substitute", text)?));
        }
        let mut e = pool.substitute(read, &map);
        for name in &args.diff {
            e = pool.diff(e, self.occurring(e, name)?);
            self.writable(e)?;
        }
        if let Some((name, text)) = &args.series {
            let about = self.argument("--series", text)?;
            let series = pool.series(e, self.occurring(e, name)?, about, args.order);
            if pool.is_singular(series) && !pool.is_singular(e) {
                let message = format!("there is no series about `{name} = {text}`");
                let help = "the expression or one of its derivatives has no finite value there: \
                            choose another point";
                return Err(Failure::usage(message, help));
            }
            e = series;
        }
        let (mut unknown, mut nonzero) = (None, Vec::new());
        if let Some(name) = &args.solve {
            let x = symbol(name)?;
            let solution = pool.solve_linear(&[e], &[x]).map_err(|fault| self.unsolved(&fault))?;
            e = solution.values.first().copied().unwrap_or(e);
            (unknown, nonzero) = (Some(x), solution.nonzero);
        }
        let before = e;
        if args.expand {
            e = pool.expand(e);
        }
        if args.simplify {
            e = pool.simplify(e);
        }
        self.writable(e)?;
        let certificate = args.certificate.then(|| pool.certificate(before, e));
        let value = self.value(e, &nonzero)?;
        Ok(Results { read, result: e, unknown, nonzero, value, certificate })
    }

    /// Refuses a result that would fill the disk: shared parts are written out wherever they occur,
    /// so that each derivative may be several times as long as the one before.
    fn writable(&self, e: Expr) -> Result<(), Failure> {
        let n_operations = self.pool.printed_operations(&[e]).total();
        if n_operations <= MOST_WRITTEN_OPERATIONS {
            return Ok(());
        }
        let message = format!("the result takes {n_operations} operations written out");
        let is_derived = !self.args.diff.is_empty() || self.args.series.is_some();
        let help = if is_derived {
            "ask for fewer derivatives or a lower order"
        } else {
            "write it with fewer repeated parts, or leave out `--expand`"
        };
        Err(Failure::usage(message, help))
    }

    /// The expression; with `--solve` also an equation, which becomes its left less its right side.
    fn read(&self) -> Result<Expr, Failure> {
        let text = &self.source.text;
        let Some(at) = equals_sign(text).filter(|_| self.args.solve.is_some()) else {
            return self.lowered(text, 0);
        };
        let (left, right) = (self.lowered(&text[..at], 0)?, self.lowered(&text[at + 1..], at + 1)?);
        Ok(self.pool.sub(left, right))
    }

    /// Reads a part of the source that begins at byte `offset`.
    fn lowered(&self, text: &str, offset: usize) -> Result<Expr, Failure> {
        let options = ParseOptions { max_depth: self.nesting, ..ParseOptions::default() };
        let rejected = |fault: ParseError| self.source.rejected(vec![diagnostic(&fault, offset)]);
        let syntax = parse(text, &options).map_err(rejected)?.written_out(&|_| false);
        let mut resolve = |name: &str, _: Range<usize>| {
            let is_pi = name == "pi";
            Ok::<_, Infallible>(if is_pi { self.pool.pi() } else { self.pool.symbol(name) })
        };
        self.pool.lower(&syntax, &mut resolve).map_err(|fault| match fault {
            LowerError::Syntax(fault) => rejected(fault).into(),
            LowerError::Resolve(never) => match never {},
        })
    }

    /// The expression of an option, such as the point of a series.
    fn argument(&self, option: &str, text: &str) -> Result<Expr, Failure> {
        self.pool.parse(text).map_err(|fault| {
            let message = format!("`{option}` cannot read `{text}`: {fault}");
            Failure::usage(message, "`bksim expr --help` shows how it is written")
        })
    }

    fn symbol(&self, name: &str) -> Result<SymbolId, Failure> {
        let symbol = self.pool.parse(name).ok().and_then(|e| self.pool.symbol_id(e));
        symbol.ok_or_else(|| {
            Failure::usage(format!("`{name}` is no name of a symbol"), "write a name such as `x1`")
        })
    }

    /// A symbol that should occur in `e`; a warning if it does not.
    fn occurring(&self, e: Expr, name: &str) -> Result<SymbolId, Failure> {
        let symbol = self.symbol(name)?;
        if !self.pool.depends_on(e, symbol) {
            render::warning(&format!("`{name}` does not occur in the expression"));
        }
        Ok(symbol)
    }

    /// The value at the point of `--at`, at which none of `nonzero` may be zero.
    fn value(&self, e: Expr, nonzero: &[Expr]) -> Result<Option<f64>, Failure> {
        if self.args.at.is_empty() {
            return Ok(None);
        }
        let mut point = Vec::new();
        for (name, text) in &self.args.at {
            point.push((self.symbol(name)?, self.number(name, text)?));
        }
        let of = |symbol| point.iter().find(|(id, _)| *id == symbol).map(|&(_, value)| value);
        let evaluate = |e| {
            self.pool.evaluate(e, &of).map_err(|fault| {
                Failure::usage(
                    fault.to_string(),
                    "give every symbol a value: `--at x=1.5 --at y=2`",
                )
            })
        };
        for &condition in nonzero {
            if evaluate(condition)? == 0.0 {
                let condition = self.pool.to_text(condition);
                let message = format!("the solution does not hold there: `{condition}` is zero");
                return Err(Failure::usage(message, "choose a point at which it is not"));
            }
        }
        evaluate(e).map(Some)
    }

    /// A value of `--at`, in SI units: a formula of numbers, or a number with its unit.
    fn number(&self, name: &str, text: &str) -> Result<f64, Failure> {
        let with_unit = text.trim().split_once(' ').and_then(|(number, unit)| {
            Some(WrittenUnit::parse(unit.trim())?.to_si(number.parse().ok()?))
        });
        if let Some(value) = with_unit {
            return Ok(value);
        }
        let value = self.argument("--at", text)?;
        self.pool.evaluate(value, &|_| None).map_err(|fault| {
            let help = "a value is a number such as `1.5`, or one with its unit, `\"25 mm\"`";
            Failure::usage(format!("`--at {name}`: {fault}"), help)
        })
    }

    fn unsolved(&self, fault: &SolveError) -> Failure {
        let mut diagnostic = Diagnostic::error(
            code::EXPRESSION,
            match fault {
                SolveError::NotLinear { .. } => {
                    "the equation is not linear in the unknown".to_owned()
                }
                SolveError::Undetermined { name, .. } => format!("nothing determines `{name}`"),
                other => other.to_string(),
            },
        );
        diagnostic = diagnostic.at(0..self.source.text.len(), "this is zero");
        self.source.rejected(vec![diagnostic]).into()
    }

    fn notation(&self) -> Notation {
        match self.args.format {
            _ if self.args.latex => Notation::Latex,
            FormulaNotation::Text => Notation::Text,
            FormulaNotation::Unicode => Notation::Unicode,
            FormulaNotation::Latex => Notation::Latex,
            FormulaNotation::Typst => Notation::Typst,
            FormulaNotation::Mathml => Notation::MathMl,
        }
    }

    fn report(&self, outcome: &Results) -> String {
        let printer = Printer::new(self.pool, self.notation());
        let formula = printer.expr(outcome.result);
        let mut lines = vec![match outcome.unknown {
            Some(x) if self.notation() != Notation::MathMl => {
                format!("{} = {formula}", printer.symbol(x))
            }
            _ => formula,
        }];
        let mut rows: Vec<Vec<String>> = Vec::new();
        let mut row = |name: &str, text: String| rows.push(vec![name.to_owned(), text]);
        for &condition in &outcome.nonzero {
            row("where", format!("{} is not zero", self.pool.to_text(condition)));
        }
        if let Some(value) = outcome.value {
            row("value", number(value));
        }
        if self.args.count {
            row("before", counted(self.pool, outcome.read));
            row("after", counted(self.pool, outcome.result));
        }
        if let Some(certificate) = outcome.certificate {
            row("certificate", certified(certificate));
        }
        if !rows.is_empty() {
            lines.push(table(&rows));
        }
        lines.join("\n")
    }

    fn describe(&self, outcome: &Results) -> Value {
        let pool = self.pool;
        let names: Vec<String> =
            pool.symbols_of(outcome.result).iter().map(|&s| pool.symbol_name(s)).collect();
        let operations = |e| {
            let kinds = |o: Operations| {
                json!({
                    "multiply": o.multiplications, "add": o.additions, "divide": o.divisions,
                    "call": o.calls, "total": o.total(),
                })
            };
            json!({
                "shared": kinds(pool.operation_count(&[e]).operations()),
                "written_out": kinds(pool.printed_operations(&[e])),
            })
        };
        let certificate = |c: Certificate| {
            json!({
                "equal": (c.n_points > 0).then(|| c.is_equal()), "points": c.n_points,
                "worst_f64": c.worst_double, "worst_106_bits": c.worst_extended,
            })
        };
        let mut body = json!({
            "expression": pool.to_text(outcome.read),
            "result": pool.to_text(outcome.result),
            "formula": Printer::new(pool, self.notation()).expr(outcome.result),
            "symbols": names,
            "nonzero": outcome.nonzero.iter().map(|&e| pool.to_text(e)).collect::<Vec<_>>(),
            "value": outcome.value,
            "operations": {
                "before": operations(outcome.read),
                "after": operations(outcome.result),
            },
        });
        if let Some(found) = outcome.certificate {
            body["certificate"] = certificate(found);
        }
        body
    }
}

/// The place of a `=` that is no part of `<=` or `>=`.
fn equals_sign(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    (0..bytes.len())
        .find(|&at| bytes[at] == b'=' && !(at > 0 && matches!(bytes[at - 1], b'<' | b'>')))
}

/// A fault of the text in the words of the other diagnostics.
fn diagnostic(fault: &ParseError, offset: usize) -> Diagnostic {
    let span = fault.span.start + offset..fault.span.end + offset;
    let (code, help) = match &fault.kind {
        ParseErrorKind::UnknownFunction { .. } => (
            code::UNKNOWN_FUNCTION,
            Some(format!(
                "functions are {}",
                bksim::expr::function_names().collect::<Vec<_>>().join(", ")
            )),
        ),
        ParseErrorKind::UnexpectedCharacter { found: '=' } => {
            (code::EXPRESSION, Some("an equation needs an unknown: `--solve x`".to_owned()))
        }
        ParseErrorKind::TooDeep { .. } => {
            (code::EXPRESSION, Some("`--max-nesting` allows more".to_owned()))
        }
        _ => (code::EXPRESSION, None),
    };
    let mut diagnostic =
        Diagnostic::error(code, "the expression cannot be read").at(span, fault.kind.to_string());
    diagnostic.help = help;
    diagnostic
}

fn counted(pool: &Pool, e: Expr) -> String {
    let Operations { multiplications, additions, divisions, calls } =
        pool.operation_count(&[e]).operations();
    format!(
        "{multiplications} multiply, {additions} add, {divisions} divide, {calls} call; \
         {} written out",
        pool.printed_operations(&[e]).total()
    )
}

fn certified(certificate: Certificate) -> String {
    let Certificate { n_points, worst_double, worst_extended, is_rounded } = certificate;
    // More bits then show how constants were rounded.
    let rounded = if is_rounded { " (constants have 16 digits)" } else { "" };
    let verdict = match (n_points, certificate.is_equal()) {
        (0, _) => return "not compared: no point has values".to_owned(),
        (_, true) => "equal",
        (_, false) => "different",
    };
    format!(
        "{verdict} at {n_points} random points: within {worst_double:.1e} in f64, \
         {worst_extended:.1e} with 106 bits{rounded}"
    )
}
