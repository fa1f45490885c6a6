//! Forward sweeps: the nodes reachable from some roots, operands before users.
//!
//! A chain of sums or products is one step with many operands, whatever its length, so passes see
//! `a + b + c` and not `(a + b) + c`. Every pass over expressions is a loop over the steps.

use crate::named_row::FunctionId;
use crate::op::Op;
use crate::pool::{Expr, Pool, SymbolId};

/// One reachable node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) expr: Expr,
    pub(crate) op: Op,
    /// Index of the number, symbol or function with a name.
    pub(crate) data: u32,
    start: u32,
    end: u32,
}

impl Step {
    /// The symbol of a symbol step.
    pub(crate) fn symbol(&self) -> Option<SymbolId> {
        (self.op == Op::Symbol).then_some(SymbolId(self.data))
    }
}

/// A task left in a depth-first walk.
enum Visit {
    Enter(Expr),
    Leave(Expr),
}

/// The reachable nodes, operands before users.
#[derive(Debug)]
pub(crate) struct Sweep {
    pub(crate) steps: Vec<Step>,
    operands: Vec<u32>,
    /// Position of each root among the steps.
    pub(crate) roots: Vec<usize>,
}

impl Sweep {
    /// Positions of the operands of a step, all smaller than its own.
    pub(crate) fn operands(&self, step: &Step) -> impl ExactSizeIterator<Item = usize> + Clone {
        self.operands[step.start as usize..step.end as usize].iter().map(|&p| p as usize)
    }

    /// Positions of the operands of a step that has `N` of them.
    pub(crate) fn operand_array<const N: usize>(&self, step: &Step) -> [usize; N] {
        let mut operands = self.operands(step);
        std::array::from_fn(|_| operands.next().expect("a step has the operands of its operation"))
    }

    /// Positions of the condition of an `if`, of its value where that holds and of the other one.
    pub(crate) fn branches(&self, step: &Step) -> [usize; 3] {
        let [condition, pair] = self.operand_array(step);
        let [then, otherwise] = self.operand_array(&self.steps[pair]);
        [condition, then, otherwise]
    }
}

impl Pool {
    /// The operands of a node; those of the whole chain for sums and products.
    pub(crate) fn operands_of(&self, e: Expr) -> Vec<Expr> {
        let node = self.node(e);
        match node.op {
            Op::Number | Op::Symbol | Op::Pi => Vec::new(),
            Op::Add | Op::Mul => self.chain(e, node.op),
            Op::Call(function) if function.arity() == 1 => vec![node.left],
            Op::Named if self.named_arity(e) == 1 => vec![node.left],
            Op::Pow | Op::Pair | Op::Call(_) | Op::Named => vec![node.left, node.right],
        }
    }

    /// Collects everything reachable from `roots`: depth first, operands in canonical order, so
    /// that the order of the steps is the same in every pool.
    pub(crate) fn sweep(&self, roots: &[Expr]) -> Sweep {
        self.clear_positions();
        let index = |n: usize| u32::try_from(n).expect("fewer than 2^32 operands in a sweep");
        let mut sweep = Sweep { steps: Vec::new(), operands: Vec::new(), roots: Vec::new() };
        let mut pending: Vec<Visit> = roots.iter().rev().map(|&root| Visit::Enter(root)).collect();
        while let Some(visit) = pending.pop() {
            match visit {
                Visit::Enter(expr) => {
                    if self.visit(expr) {
                        pending.push(Visit::Leave(expr));
                        self.push_operands(expr, &mut pending);
                    }
                }
                Visit::Leave(expr) => {
                    self.set_position(expr, index(sweep.steps.len()));
                    let start = index(sweep.operands.len());
                    let operands = self.operands_of(expr).into_iter();
                    sweep.operands.extend(operands.map(|o| self.position(o)));
                    let node = self.node(expr);
                    let end = index(sweep.operands.len());
                    sweep.steps.push(Step { expr, op: node.op, data: node.data, start, end });
                }
            }
        }
        sweep.roots = roots.iter().map(|&root| self.position(root) as usize).collect();
        sweep
    }

    /// Pushes the operands of a node so that the first is popped first.
    fn push_operands(&self, e: Expr, pending: &mut Vec<Visit>) {
        let operands = self.operands_of(e).into_iter().rev();
        pending.extend(operands.map(Visit::Enter));
    }

    /// Builds the node of `step` on new operands.
    pub(crate) fn rebuild(&self, step: &Step, operands: &[Expr]) -> Expr {
        match (step.op, operands) {
            (Op::Add, _) => self.sum(operands.iter().copied()),
            (Op::Mul, _) => self.product(operands.iter().copied()),
            (Op::Pow, &[base, exponent]) => self.pow(base, exponent),
            (Op::Pair, &[a, b]) => self.intern(Op::Pair, a, b, 0),
            (Op::Named, _) => self.apply(FunctionId(step.data), operands),
            (Op::Call(function), &[a]) => self.call_one(function, a),
            (Op::Call(crate::op::Function::If), &[condition, pair]) => {
                let branches = self.node(pair);
                self.select(condition, branches.left, branches.right)
            }
            (Op::Call(function), &[a, b]) => self.call_two(function, a, b),
            (Op::Number | Op::Symbol | Op::Pi, _) => step.expr,
            (op, operands) => unreachable!("{op:?} on {} operands", operands.len()),
        }
    }

    /// Rebuilds every step from its operands' images; `image_of` gives the images of some steps.
    pub(crate) fn map_sweep(
        &self,
        sweep: &Sweep,
        mut image_of: impl FnMut(&Step) -> Option<Expr>,
    ) -> Vec<Expr> {
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        let mut operands = Vec::new();
        for step in &sweep.steps {
            let image = image_of(step).unwrap_or_else(|| {
                let unchanged = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
                if unchanged {
                    return step.expr;
                }
                operands.clear();
                operands.extend(sweep.operands(step).map(|o| images[o]));
                self.rebuild(step, &operands)
            });
            images.push(image);
        }
        images
    }

    /// True if the symbol `x` occurs in `e`.
    pub fn depends_on(&self, e: Expr, x: SymbolId) -> bool {
        self.sweep(&[e]).steps.iter().any(|step| step.symbol() == Some(x))
    }

    /// The symbols that occur in `e`, in ascending order.
    pub fn symbols_of(&self, e: Expr) -> Vec<SymbolId> {
        let mut symbols: Vec<_> = self.sweep(&[e]).steps.iter().filter_map(Step::symbol).collect();
        symbols.sort_unstable();
        symbols
    }
}
