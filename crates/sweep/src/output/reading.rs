//! Text to outputs: names get their meaning, units are checked, and takes are told from functions.

use bksim::Mechanism;
use bksim::expr::{
    BinaryOperator, Expr, Function as F, Number, ParseOptions, Pool, SymbolId, Syntax, SyntaxKind,
    parse,
};
use bksim::model::Measure;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{WrittenUnit, suggest};
use bksim::record::Channels;
use bksim::sim::observable::Observables;

use super::quantity::{Names, Origin};
use super::unit::{Unit, either, product};
use super::{Asked, Output, Take};
use crate::codes;

/// Takes that are written as functions of one quantity.
const TAKES: [(&str, Take); 6] = [
    ("final", Take::Final),
    ("min", Take::Min),
    ("max", Take::Max),
    ("peak_to_peak", Take::PeakToPeak),
    ("mean", Take::Mean),
    ("rms", Take::Rms),
];
const QUANTILE: &str = "quantile";
const FIRST: &str = "first";

/// Nothing nests deeper in what a person asks for.
const DEEPEST: usize = 64;

/// When a value is known: always, at every instant of a run, or at its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    Constant,
    OverTime,
    Taken,
}

/// A part of an output.
#[derive(Clone, Debug)]
struct Part {
    expr: Expr,
    unit: Unit,
    stage: Stage,
    /// The name and the unit of a signal that this part is nothing but.
    signal: Option<(String, String)>,
}

/// A number that is taken of a quantity.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    /// With the name of the first output that it is part of.
    pub(super) asked: Asked,
    pub(super) symbol: SymbolId,
}

/// Reads outputs of the runs of a mechanism.
pub(super) struct Reader<'m> {
    mechanism: &'m Mechanism,
    channels: &'m Channels,
    pub(super) pool: Pool,
    pub(super) names: Names,
    pub(super) over_time: Vec<Expr>,
    pub(super) takes: Vec<Taken>,
    /// The output that is being read.
    text: String,
}

impl<'m> Reader<'m> {
    pub(super) fn new(mechanism: &'m Mechanism, channels: &'m Channels) -> Self {
        let pool = Pool::new();
        let parameters = mechanism.model.parameters.iter();
        let symbol = |name: &str| symbol(&pool, name);
        let names = Names::of_parameters(parameters.map(|p| symbol(&p.name)).collect());
        Self {
            mechanism,
            channels,
            pool,
            names,
            over_time: Vec::new(),
            takes: Vec::new(),
            text: String::new(),
        }
    }

    /// Reads one output, and gives its value as an expression of takes and parameters.
    pub(super) fn output(&mut self, text: &str) -> Result<(Output, Expr), Diagnostic> {
        let text = text.trim();
        text.clone_into(&mut self.text);

        // `theta1@0.5`: the value at a time.
        let (text, at) = match text.rsplit_once('@') {
            Some((quantity, time)) => (quantity.trim(), Some(instant(quantity, time)?)),
            None => (text, None),
        };

        // The tree, and its parts from the leaves to the root.
        let syntax = self.tree(text)?;
        let mut parts: Vec<Part> = Vec::with_capacity(syntax.nodes.len());
        for node in &syntax.nodes {
            let part = self.part(&node.kind, &syntax, &parts)?;
            parts.push(part);
        }
        let root = parts.pop().expect("a parsed expression has at least one node");

        // One number of it, and its name: that of a signal is written in full.
        let name = |text: &str| match at {
            Some(t) => format!("{text}@{t}"),
            None => text.to_owned(),
        };
        let given = name(&text.split_whitespace().collect::<Vec<_>>().join(" "));
        let take = at.map_or(Take::Final, Take::At);
        if at.is_some() && root.stage != Stage::OverTime {
            return Err(fault(
                format!("`{}` is one number of a run already", shorten(text)),
                "leave out `@` and the time".to_owned(),
            ));
        }
        let signal = root.signal.clone();
        let unit = root.unit.text();
        let result = self.taken(root, take, None);
        let output = match signal {
            Some((word, unit)) => Output { name: name(&word), unit },
            None => Output { name: given, unit },
        };
        Ok((output, result.expr))
    }

    /// The tree of an output's text, with functions that are made of others written out.
    fn tree(&self, text: &str) -> Result<Syntax, Diagnostic> {
        let is_unit = |word: &str| WrittenUnit::parse(word).is_some();
        let is_name = |word: &str| {
            self.mechanism.model.parameters.iter().any(|p| p.name == word)
                || self
                    .channels
                    .signals()
                    .any(|(_, name, field)| name == word || field.name == word)
        };
        let options = ParseOptions {
            max_depth: DEEPEST,
            is_unit: &is_unit,
            is_name: &is_name,
            is_variable: &|word| word == "t",
        };
        match parse(text, &options) {
            Ok(syntax) => Ok(syntax.written_out(&|_| false)),
            Err(error) => {
                let message = format!("`{}` is no output: {error}", shorten(text));
                Err(fault(message, "write one as in `max(reactions.B.fx)`".to_owned()))
            }
        }
    }

    /// The part that a node is; those below it come before.
    fn part(
        &mut self,
        kind: &SyntaxKind,
        syntax: &Syntax,
        parts: &[Part],
    ) -> Result<Part, Diagnostic> {
        match kind {
            SyntaxKind::Number(number) => Ok(self.constant(number, Unit::Bare)),
            SyntaxKind::Quantity { value, factors, .. } => {
                let unit = WrittenUnit::of(factors).ok_or_else(unknown_unit)?;
                Ok(self.constant(&Number::float(unit.to_si(value.to_f64())), Unit::Known(unit)))
            }
            SyntaxKind::Unit { operand, factors } => {
                let unit = WrittenUnit::of(factors).ok_or_else(unknown_unit)?;
                let factor = self.constant(&Number::float(unit.to_si(1.0)), Unit::Known(unit));
                let one = parts[*operand].clone();
                Ok(self.join([one, factor], |pool, [a, b]| pool.mul(a, b), product))
            }
            SyntaxKind::Name(name) => self.named(name),
            SyntaxKind::Negate(operand) => {
                let part = parts[*operand].clone();
                Ok(Part { expr: self.pool.neg(part.expr), signal: None, ..part })
            }
            SyntaxKind::Binary { operator, left, right, .. } => {
                self.binary(*operator, [parts[*left].clone(), parts[*right].clone()])
            }
            SyntaxKind::Call { name, arguments, .. } => {
                let operands: Vec<Part> = arguments.iter().map(|&at| parts[at].clone()).collect();
                let conditions: Vec<&SyntaxKind> =
                    arguments.iter().map(|&at| &syntax.nodes[at].kind).collect();
                self.call(name, operands, &conditions, parts)
            }
        }
    }

    fn constant(&self, number: &Number, unit: Unit) -> Part {
        let expr = self.pool.number(number.clone());
        Part { expr, unit, stage: Stage::Constant, signal: None }
    }

    fn binary(&mut self, operator: BinaryOperator, parts: [Part; 2]) -> Result<Part, Diagnostic> {
        match operator {
            BinaryOperator::Add => {
                alike("add", &parts)?;
                Ok(self.join(parts, |pool, [a, b]| pool.add(a, b), either))
            }
            BinaryOperator::Subtract => {
                alike("subtract", &parts)?;
                Ok(self.join(parts, |pool, [a, b]| pool.sub(a, b), either))
            }
            BinaryOperator::Multiply => {
                Ok(self.join(parts, |pool, [a, b]| pool.mul(a, b), product))
            }
            BinaryOperator::Divide => {
                let quotient = |[a, b]: [Unit; 2]| product([a, b.power(-1.0).unwrap_or(b)]);
                Ok(self.join(parts, |pool, [a, b]| pool.div(a, b), quotient))
            }
            BinaryOperator::Power => {
                let exponent = self.pool.as_number(parts[1].expr).map(|n| n.to_f64());
                let unit = match exponent {
                    Some(exponent) => parts[0].unit.power(exponent),
                    None => parts[0].unit.is_pure().then_some(parts[0].unit),
                };
                let unit = unit.ok_or_else(|| {
                    let help = "write one, as in `^2`, or divide by a unit first";
                    fault(
                        "a power of a quantity with a unit needs a simple number".to_owned(),
                        help.to_owned(),
                    )
                })?;
                Ok(self.join(parts, |pool, [a, b]| pool.pow(a, b), |_| unit))
            }
        }
    }

    /// A take, or a function.
    fn call(
        &mut self,
        name: &str,
        operands: Vec<Part>,
        written: &[&SyntaxKind],
        parts: &[Part],
    ) -> Result<Part, Diagnostic> {
        let take = TAKES.iter().find(|(known, _)| *known == name).map(|&(_, take)| take);
        match (name, take, operands.as_slice(), written) {
            (_, Some(take), [quantity], _) => self.take(name, (take, None), quantity.clone()),
            ("max_between" | "min_between", _, [quantity, from, to], _) => {
                let end = |part: &Part| {
                    let number = self.pool.as_number(part.expr).map(|number| number.to_f64());
                    number.filter(|_| ["", "s"].contains(&part.unit.text().as_str()))
                };
                let window = end(from).zip(end(to)).filter(|(from, to)| from <= to);
                let (from, to) = window.ok_or_else(|| {
                    let help = format!("write two times, as in `{name}(theta, 0.2 s, 0.4 s)`");
                    fault(format!("`{name}` is of no part of the time"), help)
                })?;
                let take = if name == "max_between" { Take::Max } else { Take::Min };
                self.take(name, (take, Some([from, to])), quantity.clone())
            }
            (QUANTILE, _, [quantity, part], _) => {
                let part = self.pool.as_number(part.expr).map(|part| part.to_f64());
                let part = part.filter(|part| (0.0..=1.0).contains(part)).ok_or_else(|| {
                    let help = "write it from 0 to 1, as in `quantile(theta, 0.95)`";
                    fault("a quantile is of a part of the time".to_owned(), help.to_owned())
                })?;
                self.take(name, (Take::Quantile(part), None), quantity.clone())
            }
            (FIRST, _, [_], [SyntaxKind::Call { name: compare, arguments, .. }])
                if ["gt", "ge", "lt", "le"].contains(&compare.as_str()) =>
            {
                // The two sides were compared, so they are alike.
                let sides = [parts[arguments[0]].clone(), parts[arguments[1]].clone()];
                let [low, high] = if compare.starts_with('g') { [1, 0] } else { [0, 1] };
                let [low, high] = [sides[low].clone(), sides[high].clone()];
                let above = self.join([high, low], |pool, [a, b]| pool.sub(a, b), either);
                let above = Part { signal: None, ..above };
                let taken = self.take(name, (Take::First, None), above)?;
                Ok(Part { unit: Unit::of("s"), ..taken })
            }
            (FIRST, ..) => {
                let help = "write one comparison, as in `first(theta > 90 deg)`";
                Err(fault("the first time of what?".to_owned(), help.to_owned()))
            }
            (QUANTILE, ..) => {
                let help = "write `quantile(theta, 0.95)`";
                Err(fault("a quantile is of a quantity and a part".to_owned(), help.to_owned()))
            }
            _ => self.function(name, operands),
        }
    }

    /// A number taken of a quantity over time.
    fn take(
        &mut self,
        name: &str,
        (take, window): (Take, Option<[f64; 2]>),
        quantity: Part,
    ) -> Result<Part, Diagnostic> {
        if quantity.stage == Stage::Taken {
            let help = format!("write `{name}(…)` around what varies over the run");
            return Err(fault(format!("`{name}` of what is one number already"), help));
        }
        let signal = quantity.signal.clone();
        let taken = self.taken(quantity, take, window);
        let signal = signal.map(|(word, unit)| (format!("{name}({word})"), unit));
        // A quantile's name has its part in it, and that of a window its times: as it was written.
        let is_whole = !matches!(take, Take::Quantile(_)) && window.is_none();
        Ok(Part { signal: signal.filter(|_| is_whole), ..taken })
    }

    /// A number of the run: itself, or what is taken of a quantity over time.
    fn taken(&mut self, part: Part, take: Take, window: Option<[f64; 2]>) -> Part {
        if part.stage == Stage::Taken {
            return part;
        }
        let known = self.over_time.iter().position(|&known| known == part.expr);
        let quantity = known.unwrap_or_else(|| {
            self.over_time.push(part.expr);
            self.over_time.len() - 1
        });
        let same = |Taken { asked, .. }: &&Taken| {
            (asked.take, asked.window, asked.quantity) == (take, window, quantity)
        };
        let symbol = if let Some(known) = self.takes.iter().find(same) {
            known.symbol
        } else {
            // No name of a run has a space.
            let symbol = symbol(&self.pool, &format!("take {}", self.takes.len()));
            let asked = Asked { take, window, quantity, output: self.text.clone() };
            self.takes.push(Taken { asked, symbol });
            symbol
        };
        Part { expr: self.pool.symbol_expr(symbol), stage: Stage::Taken, signal: None, ..part }
    }

    fn function(&mut self, name: &str, operands: Vec<Part>) -> Result<Part, Diagnostic> {
        let function = F::from_name(name).ok_or_else(|| unknown_function(name))?;
        if function.arity() != operands.len() {
            let message = format!("`{name}` takes {} arguments", function.arity());
            return Err(fault(message, format!("it has {} here", operands.len())));
        }
        let unit = match (function, operands.as_slice()) {
            (F::Abs | F::Floor, [a]) => a.unit,
            (F::Sqrt, [a]) => a.unit.power(0.5).unwrap_or(Unit::Unknown),
            (F::Min | F::Max | F::Atan2 | F::Lt | F::Le | F::Gt | F::Ge, [a, b])
            | (F::If, [_, a, b]) => {
                alike("compare", &[a.clone(), b.clone()])?;
                match function {
                    F::Min | F::Max | F::If => either([a.unit, b.unit]),
                    F::Atan2 => Unit::of("rad"),
                    _ => Unit::Known(WrittenUnit::PURE),
                }
            }
            (_, [a]) => {
                if !a.unit.is_pure() {
                    let message = format!("`{name}` of a quantity with a unit");
                    return Err(fault(message, "divide by a unit first".to_owned()));
                }
                let is_inverse = matches!(function, F::Asin | F::Acos | F::Atan);
                if is_inverse { Unit::of("rad") } else { Unit::Known(WrittenUnit::PURE) }
            }
            _ => Unit::Unknown,
        };
        let operands = self.at_one_stage(operands);
        let stage = operands.iter().map(|part| part.stage).fold(Stage::Constant, later);
        let arguments: Vec<Expr> = operands.iter().map(|part| part.expr).collect();
        let expr = self.pool.call(function, &arguments).ok_or_else(|| unknown_function(name))?;
        Ok(Part { expr, unit, stage, signal: None })
    }

    /// Two parts as one.
    fn join(
        &mut self,
        parts: [Part; 2],
        build: impl Fn(&Pool, [Expr; 2]) -> Expr,
        unit: impl Fn([Unit; 2]) -> Unit,
    ) -> Part {
        let unit = unit([parts[0].unit, parts[1].unit]);
        let parts = self.at_one_stage(Vec::from(parts));
        let stage = later(parts[0].stage, parts[1].stage);
        Part { expr: build(&self.pool, [parts[0].expr, parts[1].expr]), unit, stage, signal: None }
    }

    /// Beside numbers of the run, quantities over time are their final values.
    fn at_one_stage(&mut self, parts: Vec<Part>) -> Vec<Part> {
        if !parts.iter().any(|part| part.stage == Stage::Taken) {
            return parts;
        }
        let taken = |part: Part| match part.stage {
            Stage::OverTime => self.taken(part, Take::Final, None),
            _ => part,
        };
        parts.into_iter().map(taken).collect()
    }

    /// A signal, something that the model can name, a parameter, the time or π.
    fn named(&mut self, word: &str) -> Result<Part, Diagnostic> {
        let fields = || self.channels.signals().filter(|(_, _, field)| field.name == word);
        let whole = self.channels.signals().find(|(_, name, _)| name == word);
        let alone = || fields().next().filter(|_| fields().nth(1).is_none());
        if let Some((signal, name, field)) = whole.or_else(alone) {
            let unit = field.unit.clone();
            return Ok(self.over_time_named(name, unit, Origin::Signal(signal)));
        }
        let model = &self.mechanism.model;
        if let Some(measure) = Observables::named(model, word) {
            let unit = measure.unit(model).replace(' ', "*");
            return Ok(self.over_time_named(word.to_owned(), unit, Origin::Measure(measure)));
        }
        if let Some(parameter) = model.parameters.iter().find(|p| p.name == word) {
            let expr = self.pool.symbol(word);
            let unit = match parameter.unit.as_str() {
                "" => Unit::Unknown,
                unit => Unit::of(unit),
            };
            return Ok(Part { expr, unit, stage: Stage::Constant, signal: None });
        }
        match word {
            "t" => Ok(self.over_time_named("t".to_owned(), "s".to_owned(), Origin::Time)),
            "pi" => Ok(self.constant(&Number::float(std::f64::consts::PI), Unit::Bare)),
            _ => Err(self.unknown(word)),
        }
    }

    fn over_time_named(&mut self, name: String, unit: String, origin: Origin) -> Part {
        let expr = self.pool.symbol(&name);
        self.names.add(symbol(&self.pool, &name), origin);
        let of = Unit::of(&unit);
        Part { expr, unit: of, stage: Stage::OverTime, signal: Some((name, unit)) }
    }

    fn unknown(&self, word: &str) -> Diagnostic {
        let signals = || self.channels.signals();
        let same: Vec<String> =
            signals().filter(|(_, _, field)| field.name == word).map(|(_, name, _)| name).collect();
        let all: Vec<String> = signals().map(|(_, name, _)| name).collect();
        let all = [all, Measure::names(&self.mechanism.model)].concat();
        let (message, names) = match same.as_slice() {
            [] => (format!("a run has no signal `{}`", shorten(word)), all),
            _ => (format!("several signals have a field `{}`", shorten(word)), same),
        };
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        fault(message, suggest(word, &names))
    }
}

/// The time after `@`.
fn instant(quantity: &str, time: &str) -> Result<f64, Diagnostic> {
    let time = time.trim().trim_end_matches('s').trim();
    let known = time.parse::<f64>().ok().filter(|t| t.is_finite());
    known.ok_or_else(|| {
        let whole = format!("{quantity}@{time}");
        let help = format!("write seconds after `@`, as in `{}@0.5`", shorten(quantity.trim()));
        fault(format!("`{}` names no time", shorten(&whole)), help)
    })
}

fn symbol(pool: &Pool, name: &str) -> SymbolId {
    pool.symbol_id(pool.symbol(name)).expect("a symbol has an id")
}

fn later(a: Stage, b: Stage) -> Stage {
    let rank = |stage| match stage {
        Stage::Constant => 0,
        Stage::OverTime => 1,
        Stage::Taken => 2,
    };
    if rank(a) >= rank(b) { a } else { b }
}

/// Refuses parts of different dimensions.
fn alike(verb: &str, [a, b]: &[Part; 2]) -> Result<(), Diagnostic> {
    let (Unit::Known(first), Unit::Known(second)) = (a.unit, b.unit) else { return Ok(()) };
    if first.is_alike(&second) {
        return Ok(());
    }
    let noun = |part: &Part| match part.unit.text() {
        unit if unit.is_empty() => "a pure number".to_owned(),
        unit => unit,
    };
    let message = format!("an output cannot {verb} {} and {}", noun(a), noun(b));
    Err(fault(message, "bring both to one dimension".to_owned()))
}

fn unknown_unit() -> Diagnostic {
    fault("an output has an unknown unit".to_owned(), "`bksim explain M030` lists them".to_owned())
}

fn unknown_function(name: &str) -> Diagnostic {
    let more = [QUANTILE, FIRST, "max_between", "min_between"];
    let takes = TAKES.iter().map(|(word, _)| *word).chain(more);
    let names: Vec<&str> = takes.chain(bksim::expr::function_names()).collect();
    fault(format!("`{}` is no output", shorten(name)), suggest(name, &names))
}

fn fault(message: String, help: String) -> Diagnostic {
    Diagnostic::error(codes::UNKNOWN_OUTPUT, message).help(help)
}

fn shorten(text: &str) -> String {
    text.chars().take(60).collect()
}
