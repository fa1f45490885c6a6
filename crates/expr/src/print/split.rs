//! Expressions split into constant and varying parts: the first step to naming constants.

use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, Pool, SymbolId};
use crate::sweep::{Step, Sweep};
use std::collections::{HashMap, HashSet};

/// One term of a sum, `constant · varying`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SplitTerm {
    /// All factors that depend on the given symbols only, numbers among them.
    pub constant: Expr,
    /// All other factors.
    pub varying: Expr,
}

impl Pool {
    /// Multiplies `e` out and collects it by the parts that depend on more than `constants`: no two
    /// terms have the same varying part. Terms come in reading order.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("x*(a + b*x) + c*(x - 1)").expect("valid");
    /// let constants = ["a", "b", "c"].map(|name| pool.find_symbol(name).expect("was parsed"));
    /// let terms = pool.split_terms(e, &constants);
    /// let texts: Vec<_> =
    ///     terms.iter().map(|t| [t.constant, t.varying].map(|e| pool.to_text(e))).collect();
    /// assert_eq!(texts, [["a + c", "x"], ["b", "x^2"], ["-c", "1"]]);
    /// ```
    pub fn split_terms(&self, e: Expr, constants: &[SymbolId]) -> Vec<SplitTerm> {
        let expanded = self.expand(e);
        let sweep = self.sweep(&[expanded]);
        let flags = constant_flags(&sweep, constants);
        let steps = sweep.steps.iter().zip(flags).filter(|(_, flag)| *flag);
        let known: HashSet<Expr> = steps.map(|(step, _)| step.expr).collect();

        let mut index_of: HashMap<Expr, usize> = HashMap::new();
        let mut collected: Vec<(Expr, Vec<Expr>)> = Vec::new();
        for term in self.chain(expanded, Op::Add) {
            let (number, monic) = self.split_coefficient(term);
            let (constant, varying): (Vec<Expr>, Vec<Expr>) =
                self.chain(monic, Op::Mul).into_iter().partition(|factor| known.contains(factor));
            let constant = self.product(constant.into_iter().chain([self.number(number)]));
            let varying = self.product(varying);
            let index = *index_of.entry(varying).or_insert(collected.len());
            if index == collected.len() {
                collected.push((varying, Vec::new()));
            }
            collected[index].1.push(constant);
        }
        let mut terms: Vec<SplitTerm> = collected
            .into_iter()
            .map(|(varying, constants)| SplitTerm { constant: self.sum(constants), varying })
            .filter(|term| !self.is_zero(term.constant))
            .collect();
        self.sort_for_reading(&mut terms);
        terms
    }

    /// Sorts terms as the sum of their varying parts is read; the constant term comes last.
    fn sort_for_reading(&self, terms: &mut [SplitTerm]) {
        let sum = self.sum(terms.iter().map(|term| term.varying).filter(|&e| e != ONE));
        let order = super::Reader::new(self, &[sum], [&[], &[]]).ordered_terms(sum);
        let position: HashMap<Expr, usize> = order.into_iter().zip(0..).collect();
        terms.sort_by_key(|term| position.get(&term.varying).copied().unwrap_or(usize::MAX));
    }

    /// Replaces every largest part that depends on `constants` only, also where it is a part of a
    /// longer sum or product. Angles of sines, cosines and tangents, and exponents, stay.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("-2*m*l^2*x + cos(x + a + 1)*(a + b + x)").expect("valid");
    /// let constants = ["m", "l", "a", "b"].map(|name| pool.find_symbol(name).expect("was parsed"));
    /// let mut parts = Vec::new();
    /// pool.map_constants(&[e], &constants, &mut |part| {
    ///     parts.push(pool.to_text(part));
    ///     part
    /// });
    /// parts.sort();
    /// assert_eq!(parts, ["-2*l^2*m", "a + b"]);
    /// ```
    pub fn map_constants(
        &self,
        roots: &[Expr],
        constants: &[SymbolId],
        image_of: &mut dyn FnMut(Expr) -> Expr,
    ) -> Vec<Expr> {
        // The steps that are constant, and those that are reached through others than these.
        let sweep = self.sweep(roots);
        let is_constant = constant_flags(&sweep, constants);
        let is_needed = needed_flags(&sweep, &is_constant);

        // The images of all other steps, operands first: the constant operands of a sum or product
        // are replaced together.
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for (position, step) in sweep.steps.iter().enumerate() {
            if !is_needed[position] || is_constant[position] {
                images.push(step.expr);
                continue;
            }
            let operands = factors_of(&sweep, step);
            let image = match step.op {
                Op::Add | Op::Mul => {
                    let (constant, rest): (Vec<usize>, Vec<usize>) =
                        operands.into_iter().partition(|&o| is_constant[o]);
                    let constant = constant.into_iter().map(|o| sweep.steps[o].expr);
                    let rest = rest.into_iter().map(|o| images[o]);
                    let join = |parts: Vec<Expr>| match step.op {
                        Op::Add => self.sum(parts),
                        _ => self.product(parts),
                    };
                    let constant: Vec<Expr> = constant.collect();
                    let image = (!constant.is_empty()).then(|| image_of(join(constant)));
                    join(rest.chain(image).collect())
                }
                _ => {
                    let parts: Vec<Expr> = operands.iter().map(|&o| images[o]).collect();
                    self.rebuild(step, &parts)
                }
            };
            images.push(image);
        }

        // A root that is constant is a largest part itself.
        let root = |&root: &usize| {
            if is_constant[root] { image_of(sweep.steps[root].expr) } else { images[root] }
        };
        sweep.roots.iter().map(root).collect()
    }

    /// The factors of a product with their integer exponents; `e` itself if it is none.
    pub fn factors(&self, e: Expr) -> Vec<(Expr, i64)> {
        let (number, monic) = self.split_coefficient(e);
        let number = (!number.is_one() || monic == ONE).then(|| self.number(number));
        let factors = self.chain(monic, Op::Mul).into_iter().filter(|&factor| factor != ONE);
        number.into_iter().chain(factors).map(|factor| self.split_power(factor)).collect()
    }

    /// The terms of a sum; `e` itself if it is none.
    pub fn sum_terms(&self, e: Expr) -> Vec<Expr> {
        self.chain(e, Op::Add)
    }

    /// The function that `e` is a call of, and its arguments.
    pub fn called_function(&self, e: Expr) -> Option<(Function, Vec<Expr>)> {
        let node = self.node(e);
        let Op::Call(function) = node.op else { return None };
        let branches = self.node(node.right);
        let arguments = match function {
            Function::If => vec![node.left, branches.left, branches.right],
            _ => vec![node.left, node.right][..function.arity()].to_vec(),
        };
        Some((function, arguments))
    }

    /// All calls of a function below `roots`, those inside of others first.
    pub fn calls_of(&self, function: Function, roots: &[Expr]) -> Vec<Expr> {
        let sweep = self.sweep(roots);
        let calls = sweep.steps.iter().filter(|step| step.op == Op::Call(function));
        calls.map(|step| step.expr).collect()
    }
}

/// Which steps depend on nothing but `constants`.
fn constant_flags(sweep: &Sweep, constants: &[SymbolId]) -> Vec<bool> {
    let constants: HashSet<SymbolId> = constants.iter().copied().collect();
    let mut flags: Vec<bool> = Vec::with_capacity(sweep.steps.len());
    for step in &sweep.steps {
        let is_constant = match step.symbol() {
            Some(symbol) => constants.contains(&symbol),
            None => sweep.operands(step).all(|o| flags[o]),
        };
        flags.push(is_constant);
    }
    flags
}

/// Which steps are used elsewhere than in angles, exponents and constant parts.
fn needed_flags(sweep: &Sweep, is_constant: &[bool]) -> Vec<bool> {
    let mut needed = vec![false; sweep.steps.len()];
    sweep.roots.iter().for_each(|&root| needed[root] = true);
    for (position, step) in sweep.steps.iter().enumerate().rev() {
        let is_angle = matches!(step.op, Op::Call(Function::Sin | Function::Cos | Function::Tan));
        if !needed[position] || is_constant[position] || is_angle {
            continue;
        }
        let n_seen = if step.op == Op::Pow { 1 } else { usize::MAX };
        let operands = factors_of(sweep, step).into_iter().take(n_seen);
        operands.for_each(|operand| needed[operand] = true);
    }
    needed
}

/// The operands of a step; a coefficient and the factors of the product after it are those of one
/// product.
fn factors_of(sweep: &Sweep, step: &Step) -> Vec<usize> {
    let mut operands = Vec::new();
    for operand in sweep.operands(step) {
        let inner = &sweep.steps[operand];
        if step.op == Op::Mul && inner.op == Op::Mul {
            operands.extend(sweep.operands(inner));
        } else {
            operands.push(operand);
        }
    }
    operands
}
