//! Syntax tree to expression: one forward pass over the nodes.

use crate::number::Number;
use crate::op::Function;
use crate::parse::{ParseOptions, parse};
use crate::pool::{Expr, Pool, ZERO};
use crate::syntax::{
    BinaryOperator, ParseError, ParseErrorKind, Syntax, SyntaxKind, SyntaxNode, UnitFactor, error,
};
use std::ops::Range;

/// Reason why a syntax tree does not become an expression.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum LowerError<E> {
    /// An unknown function, a wrong number of arguments, or a unit where none is allowed.
    #[error(transparent)]
    Syntax(ParseError),
    /// A name or quantity was refused by the caller's resolver.
    #[error("{0}")]
    Resolve(E),
}

/// Gives the meaning of a name, written at a span.
type Resolve<'a, E> = dyn FnMut(&str, Range<usize>) -> Result<Expr, E> + 'a;
/// Gives the value of a number with a unit, written at a span.
type ResolveQuantity<'a, E> =
    dyn FnMut(Number, &[UnitFactor], Range<usize>) -> Result<Expr, E> + 'a;
type LowerQuantity<'a, E> =
    dyn FnMut(&SyntaxNode, Number, &[UnitFactor]) -> Result<Expr, LowerError<E>> + 'a;

/// True if an operator joins the terms of a sum; the factors of a product otherwise.
fn is_sum(operator: BinaryOperator) -> bool {
    matches!(operator, BinaryOperator::Add | BinaryOperator::Subtract)
}

/// Which nodes are the left part of a longer sum or product, without parentheses around them: these
/// are read as one sum or product, however long. One built of pieces has parentheses around them.
fn goes_on(syntax: &Syntax) -> Vec<bool> {
    let mut goes_on = vec![false; syntax.nodes.len()];
    for node in &syntax.nodes {
        let SyntaxKind::Binary { operator, left, .. } = &node.kind else { continue };
        let inner = &syntax.nodes[*left];
        if let SyntaxKind::Binary { operator: before, .. } = inner.kind
            && ![*operator, before].contains(&BinaryOperator::Power)
            && is_sum(*operator) == is_sum(before)
            && inner.span.start == node.span.start
        {
            goes_on[*left] = true;
        }
    }
    goes_on
}

impl Pool {
    /// Builds the expression of a syntax tree; `resolve` gives the meaning of names.
    ///
    /// # Errors
    /// Names that `resolve` refuses, unknown functions, wrong numbers of arguments, any unit.
    ///
    /// # Panics
    /// When there are no nodes, which parsing never gives.
    pub fn lower<E>(
        &self,
        syntax: &Syntax,
        resolve: &mut Resolve<'_, E>,
    ) -> Result<Expr, LowerError<E>> {
        let not_allowed = |node: &SyntaxNode| {
            Err(LowerError::Syntax(error(ParseErrorKind::UnitNotAllowed, node.span.clone())))
        };
        self.lower_nodes(syntax, resolve, &mut |node, _, _| not_allowed(node))
    }

    /// Lowering ([`Pool::lower`]) with `quantity` giving the value of numbers with units.
    ///
    /// # Errors
    /// Names and quantities that `resolve` and `quantity` refuse, unknown functions, wrong numbers
    /// of arguments.
    ///
    /// # Panics
    /// When there are no nodes, which parsing never gives.
    pub fn lower_quantities<E>(
        &self,
        syntax: &Syntax,
        resolve: &mut Resolve<'_, E>,
        quantity: &mut ResolveQuantity<'_, E>,
    ) -> Result<Expr, LowerError<E>> {
        self.lower_nodes(syntax, resolve, &mut |node, value, factors| {
            quantity(value, factors, node.span.clone()).map_err(LowerError::Resolve)
        })
    }

    fn lower_nodes<E>(
        &self,
        syntax: &Syntax,
        resolve: &mut Resolve<'_, E>,
        quantity: &mut LowerQuantity<'_, E>,
    ) -> Result<Expr, LowerError<E>> {
        let mut values: Vec<Expr> = Vec::with_capacity(syntax.nodes.len());
        let goes_on = goes_on(syntax);
        for (index, node) in syntax.nodes.iter().enumerate() {
            let value = match &node.kind {
                // A part of a chain has no value of its own.
                _ if goes_on[index] => ZERO,
                SyntaxKind::Number(number) => self.number(number.clone()),
                SyntaxKind::Quantity { value, factors, .. } => {
                    quantity(node, value.clone(), factors)?
                }
                SyntaxKind::Unit { operand, factors } => {
                    let unit = quantity(node, Number::from(1), factors)?;
                    self.mul(values[*operand], unit)
                }
                SyntaxKind::Name(name) => {
                    resolve(name, node.span.clone()).map_err(LowerError::Resolve)?
                }
                SyntaxKind::Negate(operand) => self.neg(values[*operand]),
                SyntaxKind::Binary { operator: BinaryOperator::Power, left, right, .. } => {
                    self.pow(values[*left], values[*right])
                }
                SyntaxKind::Binary { operator, .. } => {
                    let operands = self.chain_operands(syntax, &goes_on, index, &values);
                    if is_sum(*operator) { self.sum(operands) } else { self.product(operands) }
                }
                SyntaxKind::Call { name, name_span, arguments } => {
                    let arguments: Vec<Expr> = arguments.iter().map(|&a| values[a]).collect();
                    self.call_by_name(name, &arguments)
                        .map_err(|kind| LowerError::Syntax(error(kind, name_span.clone())))?
                }
            };
            values.push(value);
        }
        Ok(*values.last().expect("a parsed expression has at least one node"))
    }

    /// The operands of a chain of sums or products that ends with the node at `index`.
    fn chain_operands(
        &self,
        syntax: &Syntax,
        goes_on: &[bool],
        index: usize,
        values: &[Expr],
    ) -> Vec<Expr> {
        let mut operands = Vec::new();
        let mut next = Some(index);
        while let Some(index) = next.take() {
            let SyntaxKind::Binary { operator, left, right, .. } = &syntax.nodes[index].kind else {
                break;
            };
            let operand = values[*right];
            operands.push(match operator {
                BinaryOperator::Subtract => self.neg(operand),
                BinaryOperator::Divide => self.powi(operand, -1),
                _ => operand,
            });
            if goes_on[*left] {
                next = Some(*left);
            } else {
                operands.push(values[*left]);
            }
        }
        operands.reverse();
        operands
    }

    fn call_by_name(&self, name: &str, arguments: &[Expr]) -> Result<Expr, ParseErrorKind> {
        let wrong_arity = |expected: usize| ParseErrorKind::WrongArity {
            name: name.to_owned(),
            expected,
            found: arguments.len(),
        };
        if let Some(function) = Function::from_name(name) {
            let call = self.call(function, arguments);
            return call.ok_or_else(|| wrong_arity(function.arity()));
        }
        let unknown = || ParseErrorKind::UnknownFunction { name: name.to_owned() };
        let named = self.function_written(name).ok_or_else(unknown)?;
        let (_, parameters) = self.signature_of(named);
        if parameters.len() != arguments.len() {
            return Err(wrong_arity(parameters.len()));
        }
        Ok(self.apply(named, arguments))
    }

    /// Reads an expression; names become symbols, except that `pi` is the constant.
    ///
    /// # Errors
    /// A [`ParseError`] names the first fault and its span.
    pub fn parse(&self, text: &str) -> Result<Expr, ParseError> {
        let is_known = |name: &str| self.function_written(name).is_some();
        let syntax = parse(text, &ParseOptions::default())?.written_out(&is_known);
        let mut resolve = |name: &str, _: Range<usize>| {
            Ok::<_, std::convert::Infallible>(if name == "pi" {
                self.pi()
            } else {
                self.symbol(name)
            })
        };
        self.lower(&syntax, &mut resolve).map_err(|fault| match fault {
            LowerError::Syntax(fault) => fault,
            LowerError::Resolve(never) => match never {},
        })
    }
}
