//! Formulas over the quantities of a pose, parameters and names of a question's own.

use bksim::expr::{Expr, Function, Number, ParseOptions, UnitFactor, parse};
use bksim::mbs::system::SymbolicSystem;
use bksim::model::file::{WrittenUnit, suggest};
use bksim::model::{Measure, Model};

use crate::codes;
use crate::error::DesignError;

/// Nothing nests deeper in what a person asks for.
const DEEPEST: usize = 64;

/// A formula with its SI unit, where it is nothing but one quantity.
#[derive(Clone, Debug)]
pub(crate) struct Formula {
    pub(crate) expr: Expr,
    pub(crate) unit: String,
}

/// Reads a formula; `own` names go before those of the model, which are there if it has a `system`.
pub(crate) fn formula(
    text: &str,
    model: &Model,
    system: Option<&SymbolicSystem>,
    own: &[(String, Expr)],
) -> Result<Formula, DesignError> {
    let pool = &model.pool;
    let quantity = |name: &str| -> Option<(Expr, String)> {
        if let Some((_, expr)) = own.iter().find(|(known, _)| known == name) {
            return Some((*expr, String::new()));
        }
        if let Some(parameter) = model.parameters.iter().find(|p| p.name == name) {
            return Some((pool.symbol_expr(parameter.symbol), parameter.unit.clone()));
        }
        let system = system?;
        if let Some(c) = system.coordinates().iter().find(|c| c.name == name) {
            return Some((pool.symbol_expr(c.q), c.kind.unit().to_owned()));
        }
        let measure =
            Measure::named(model, name).filter(|m| !m.is_velocity() && !m.is_reaction())?;
        Some((system.kinematics.measure(model, measure), measure.unit(model).to_owned()))
    };
    let is_unit = |word: &str| WrittenUnit::parse(word).is_some();
    let is_name = |word: &str| quantity(word).is_some();
    let options = ParseOptions {
        max_depth: DEEPEST,
        is_unit: &is_unit,
        is_name: &is_name,
        is_variable: &|_| false,
    };
    let bad = |why: String| {
        let message = format!("`{text}` is no formula: {why}");
        DesignError::fault(codes::BAD_QUESTION, message, "write one as in `rocker.angle - o2`")
    };
    let syntax = parse(text, &options).map_err(|error| bad(error.to_string()))?;
    let syntax = syntax.written_out(&|name| Function::from_name(name).is_some());
    let mut resolve = |name: &str, _| match name {
        "pi" => Ok(pool.pi()),
        name => quantity(name).map(|(expr, _)| expr).ok_or_else(|| name.to_owned()),
    };
    let mut with_unit = |value: Number, factors: &[UnitFactor], _| {
        let unit = WrittenUnit::of(factors).ok_or_else(|| "a unit".to_owned())?;
        Ok(pool.number(Number::float(unit.to_si(value.to_f64()))))
    };
    let lowered = pool.lower_quantities(&syntax, &mut resolve, &mut with_unit);
    let expr = lowered.map_err(|error| match error {
        bksim::expr::LowerError::Resolve(name) => {
            let names = names(model, system, own);
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let message = format!("`{name}` in `{text}` is nothing that this question knows");
            DesignError::fault(codes::UNKNOWN_QUANTITY, message, suggest(&name, &names))
        }
        bksim::expr::LowerError::Syntax(error) => bad(error.to_string()),
    })?;
    let unit = quantity(text.trim()).map_or_else(String::new, |(_, unit)| unit);
    Ok(Formula { expr, unit })
}

/// Names that a formula may have, for suggestions.
fn names(model: &Model, system: Option<&SymbolicSystem>, own: &[(String, Expr)]) -> Vec<String> {
    let mut all: Vec<String> = own.iter().map(|(name, _)| name.clone()).collect();
    all.extend(model.parameters.iter().map(|p| p.name.clone()));
    if system.is_some() {
        all.extend(model.joints.iter().map(|joint| format!("{}.angle", joint.name)));
        all.extend(model.bodies.iter().skip(1).map(|body| format!("{}.angle", body.name)));
        for body in model.bodies.iter().skip(1) {
            all.extend(body.points.iter().map(|point| format!("{}.{}.x", body.name, point.name)));
        }
    }
    all
}

/// The one argument of a call of `name` that is all of the text.
pub(crate) fn argument<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    let rest = text.trim().strip_prefix(name)?.trim_start().strip_prefix('(')?;
    let mut depth = 1;
    for (at, c) in rest.char_indices() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        match (depth, c) {
            (0, _) => return (at + 1 == rest.len()).then(|| rest[..at].trim()),
            (1, ',') => return None,
            _ => (),
        }
    }
    None
}
