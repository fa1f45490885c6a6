//! Syntax tree to expression: one forward pass over the nodes.

use crate::number::Number;
use crate::op::Function;
use crate::parse::{ParseOptions, parse};
use crate::pool::{Expr, Pool};
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

    /// As [`Pool::lower`], with `quantity` giving the value of numbers with units.
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
        for node in &syntax.nodes {
            let value = match &node.kind {
                SyntaxKind::Number(number) => self.number(number.clone()),
                SyntaxKind::Quantity { value, factors, .. } => {
                    quantity(node, value.clone(), factors)?
                }
                SyntaxKind::Name(name) => {
                    resolve(name, node.span.clone()).map_err(LowerError::Resolve)?
                }
                SyntaxKind::Negate(operand) => self.neg(values[*operand]),
                SyntaxKind::Binary { operator, left, right, .. } => {
                    self.binary(*operator, values[*left], values[*right])
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

    fn binary(&self, operator: BinaryOperator, left: Expr, right: Expr) -> Expr {
        match operator {
            BinaryOperator::Add => self.add(left, right),
            BinaryOperator::Subtract => self.sub(left, right),
            BinaryOperator::Multiply => self.mul(left, right),
            BinaryOperator::Divide => self.div(left, right),
            BinaryOperator::Power => self.pow(left, right),
        }
    }

    fn call_by_name(&self, name: &str, arguments: &[Expr]) -> Result<Expr, ParseErrorKind> {
        let unknown = || ParseErrorKind::UnknownFunction { name: name.to_owned() };
        let function = Function::from_name(name).ok_or_else(unknown)?;
        self.call(function, arguments).ok_or_else(|| ParseErrorKind::WrongArity {
            name: name.to_owned(),
            expected: function.arity(),
            found: arguments.len(),
        })
    }

    /// Reads an expression; names become symbols, except that `pi` is the constant.
    ///
    /// # Errors
    /// A [`ParseError`] names the first fault and its span.
    pub fn parse(&self, text: &str) -> Result<Expr, ParseError> {
        let syntax = parse(text, &ParseOptions::default())?;
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
