//! Derivatives along a direction, along weights, along time, and twice.
//!
//! ```text
//! J d     change of the functions f along a direction d of the symbols      one forward sweep
//! Jᵀ w    the gradient of w·f, with the weights w held                      one backward sweep
//! ḟ       J d for the rates of the symbols
//! H       ∂²f/∂xᵢ∂xⱼ
//! ```
//!
//! Neither product builds J. A symbol may be anything: a coordinate, a velocity, a parameter.

use super::SparseJacobian;
use super::dependence::Dependence;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool, SymbolId, ZERO};

impl Pool {
    /// The rate of `e` when each symbol changes at its rate and all others are constant:
    /// Σ ∂e/∂xᵢ · rateᵢ.
    ///
    /// With the velocities as the rates of the coordinates this is d/dt; with the accelerations as
    /// those of the velocities it can be taken again.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let x = pool.parse("l*sin(q)").expect("valid");
    /// let [q, v] = ["q", "v"].map(|name| pool.symbol(name));
    /// let rates = [(q, v), (v, pool.symbol("a"))];
    /// let rates = rates.map(|(x, rate)| (pool.symbol_id(x).expect("a symbol"), rate));
    /// let velocity = pool.total_derivative(x, &rates);
    /// assert_eq!(pool.to_text(velocity), "l*v*cos(q)");
    /// let acceleration = pool.total_derivative(velocity, &rates);
    /// assert_eq!(pool.to_text(acceleration), "a*l*cos(q) - l*v^2*sin(q)");
    /// ```
    pub fn total_derivative(&self, e: Expr, rates: &[(SymbolId, Expr)]) -> Expr {
        self.total_derivatives(&[e], rates)[0]
    }

    /// The rates of several expressions, shared parts once.
    pub fn total_derivatives(&self, roots: &[Expr], rates: &[(SymbolId, Expr)]) -> Vec<Expr> {
        let sweep = self.sweep(roots);
        let tangents = self.tangents(&sweep, rates);
        sweep.roots.iter().map(|&root| tangents[root]).collect()
    }

    /// The Jacobian times a vector: Σⱼ ∂fᵢ/∂xⱼ · dⱼ, one entry for each output.
    ///
    /// One forward sweep, whatever the number of symbols. The direction has one entry for each
    /// symbol of `wrt`; symbols without an entry are constant. It may depend on the symbols: it is
    /// not differentiated.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let f = ["x^2*y", "x + k"].map(|text| pool.parse(text).expect("valid"));
    /// let wrt = ["x", "y"].map(|name| pool.find_symbol(name).expect("was parsed"));
    /// let along = pool.jvp(&f, &wrt, &[pool.symbol("a"), pool.zero()]);
    /// assert_eq!(pool.to_text(along[0]), "2*a*x*y");
    /// assert_eq!(pool.to_text(along[1]), "a");
    /// ```
    pub fn jvp(&self, outputs: &[Expr], wrt: &[SymbolId], direction: &[Expr]) -> Vec<Expr> {
        let rates: Vec<(SymbolId, Expr)> =
            wrt.iter().copied().zip(direction.iter().copied()).collect();
        self.total_derivatives(outputs, &rates)
    }

    /// A vector times the Jacobian: Σᵢ wᵢ · ∂fᵢ/∂xⱼ, one entry for each symbol.
    ///
    /// One backward sweep, whatever the number of outputs and symbols. There is one weight for each
    /// output; outputs without a weight count nothing. Weights may depend on the symbols: they are
    /// not differentiated. With multipliers as weights of the constraints this is the constraint
    /// force.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let constraints = ["x^2 + y^2 - l^2", "x - u"].map(|text| pool.parse(text).expect("valid"));
    /// let wrt = ["x", "y"].map(|name| pool.find_symbol(name).expect("was parsed"));
    /// let lambda = ["r", "s"].map(|name| pool.symbol(name));
    /// let force = pool.vjp(&constraints, &lambda, &wrt);
    /// assert_eq!(pool.to_text(force[0]), "2*r*x + s");
    /// assert_eq!(pool.to_text(force[1]), "2*r*y");
    /// ```
    pub fn vjp(&self, outputs: &[Expr], weights: &[Expr], wrt: &[SymbolId]) -> Vec<Expr> {
        let sweep = self.sweep(outputs);
        let mut shares = vec![Vec::new(); sweep.steps.len()];
        let mut products = vec![ZERO; wrt.len()];
        // Branches are differentiated column by column, all else needs no columns.
        let has_branches = sweep.steps.iter().any(|step| step.op == Op::Call(Function::If));
        let groups = if has_branches {
            Dependence::in_groups(&sweep, wrt)
        } else {
            vec![(0, Dependence::on_any(&sweep, wrt))]
        };
        for (first, dependence) in groups {
            for (&root, &weight) in sweep.roots.iter().zip(weights) {
                if !dependence.is_empty(root) {
                    shares[root].push(weight);
                }
            }
            let reach = dependence.reach(&sweep, &sweep.roots);
            for (column, sum) in self.reverse(&sweep, &dependence, &reach, &mut shares) {
                products[first + column] = sum;
            }
        }
        products
    }

    /// The second derivatives ∂²e/∂xᵢ∂xⱼ that are not identically zero. Both triangles are listed,
    /// and entries across the diagonal are one expression.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let energy = pool.parse("m*x^2*w^2/2 + k*z").expect("valid");
    /// let xs = ["x", "w", "z"].map(|name| pool.find_symbol(name).expect("was parsed"));
    /// let hessian = pool.hessian(energy, &xs);
    /// let listed: Vec<_> =
    ///     hessian.entries.iter().map(|&(i, j, e)| (i, j, pool.to_text(e))).collect();
    /// let expected = [(0, 0, "m*w^2"), (0, 1, "2*m*w*x"), (1, 0, "2*m*w*x"), (1, 1, "m*x^2")];
    /// assert_eq!(listed, expected.map(|(i, j, text)| (i, j, text.to_owned())));
    /// ```
    pub fn hessian(&self, e: Expr, xs: &[SymbolId]) -> SparseJacobian {
        let gradient = self.gradient(e, xs);
        let mut hessian = self.jacobian(&gradient, xs);
        let lower = hessian.entries.iter().copied().filter(|&(row, column, _)| column <= row);
        let lower: Vec<_> = lower.collect();
        let upper = lower.iter().filter(|entry| entry.1 < entry.0).map(|&(i, j, e)| (j, i, e));
        hessian.entries = lower.iter().copied().chain(upper).collect();
        hessian.entries.sort_unstable_by_key(|&(row, column, _)| (row, column));
        hessian
    }
}
