//! Functions by name, piece by piece, as they are told below the equations that call them.

use bksim_expr::{Expr, FunctionId, Number, Pool};

use super::form::ReadingForm;
use bksim_model::{FunctionPiece, Model};

/// One formula of a function, and where it holds.
#[derive(Clone, PartialEq, Debug)]
pub struct FunctionText {
    /// The function with its arguments.
    pub call: Expr,
    /// Terms of its value.
    pub terms: Vec<Expr>,
    /// The arguments.
    pub arguments: Vec<Expr>,
    /// First and last value of each argument, SI; infinite where there is none.
    pub ranges: Vec<[f64; 2]>,
}

/// The functions that a form calls, each with its pieces; those of which only derivatives occur are among them.
pub fn functions(model: &Model, form: &ReadingForm) -> Vec<FunctionText> {
    let pool = &model.pool;
    let called = pool.functions_of(&form.everything(pool));
    let called: Vec<FunctionId> = called.into_iter().map(|f| pool.base_function(f)).collect();
    let told = model.functions.iter().filter(|one| called.contains(&one.function));
    told.flat_map(|one| {
        let (_, parameters) = pool.signature_of(one.function);
        let arguments: Vec<Expr> = parameters.iter().map(|&s| pool.symbol_expr(s)).collect();
        let call = pool.apply(one.function, &arguments);
        one.pieces.iter().map(move |piece| FunctionText {
            call,
            terms: terms(pool, piece, &arguments),
            arguments: arguments.clone(),
            ranges: piece.ranges.clone(),
        })
    })
    .collect()
}

/// The terms of a piece that are not zero.
fn terms(pool: &Pool, piece: &FunctionPiece, arguments: &[Expr]) -> Vec<Expr> {
    let number = |value: f64| pool.number(Number::float(value));
    let distance = |i: usize| pool.sub(arguments[i], number(piece.origin[i]));
    let term = |&(powers, c): &([usize; 2], f64)| {
        let factors = (0..arguments.len()).map(|i| {
            let n = i64::try_from(powers[i]).unwrap_or(i64::MAX);
            pool.powi(distance(i), n)
        });
        pool.product(factors.chain([number(c)]))
    };
    let mut terms: Vec<Expr> = piece.terms.iter().filter(|(_, c)| *c != 0.0).map(term).collect();
    if let Some([a, omega, phi]) = piece.sine {
        let angle = pool.add(pool.mul(number(omega), distance(0)), number(phi));
        terms.push(pool.mul(number(a), pool.sin(angle)));
    }
    if terms.is_empty() { vec![pool.zero()] } else { terms }
}
