//! Functions that have a name and an expression of their own, such as a table of measured values: a call is one
//! node, which is differentiated, simplified and printed as such, and expanded where values are computed.
//!
//! ```text
//! define  lift(a) = 3*a^2        apply  lift(2*q)        diff  2*lift'(2*q)        expand  12*q
//! ```

use crate::named_row::{FunctionId, NamedRow};
use crate::op::Op;
use crate::pool::{Expr, Pool, SymbolId, ZERO, fact, unit_random};

impl Pool {
    /// Defines a function of one argument or two; `body` has no other symbols than its parameters.
    ///
    /// A function that is defined again with the same name and the same body is the same one.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let a = pool.symbol_id(pool.symbol("a")).expect("a symbol");
    /// let lift = pool.define("lift", &[a], pool.parse("3*a^2").expect("valid"));
    ///
    /// let q = pool.symbol("q");
    /// let called = pool.apply(lift, &[q]);
    /// let slope = pool.diff(called, pool.symbol_id(q).expect("a symbol"));
    /// assert_eq!(pool.to_text(slope), "lift'(q)");
    /// assert_eq!(pool.to_text(pool.expand_named(&[slope])[0]), "6*q");
    /// ```
    ///
    /// # Panics
    /// When there are no parameters or more than two, or other symbols in `body`.
    pub fn define(&self, name: &str, parameters: &[SymbolId], body: Expr) -> FunctionId {
        assert!((1..=2).contains(&parameters.len()), "a function of one argument or two");
        let symbols = self.symbols_of(body);
        assert!(symbols.iter().all(|symbol| parameters.contains(symbol)), "no other symbols");
        let body = self.expand_named(&[body])[0];
        let known = self.find_named(|row| {
            row.name == name
                && row.parameters == parameters
                && row.body == body
                && row.orders == [0; 2]
        });
        known.unwrap_or_else(|| {
            self.add_named(NamedRow {
                name: name.to_owned(),
                parameters: parameters.to_vec(),
                orders: [0; 2],
                body,
                base: None,
                derivatives: [None; 2],
                hash: 0,
            })
        })
    }

    /// The value of a function at arguments; of constants it is expanded at once.
    ///
    /// # Panics
    /// When the number of arguments is not that of its parameters.
    pub fn apply(&self, function: FunctionId, arguments: &[Expr]) -> Expr {
        let n = self.named(function, |row| row.parameters.len());
        assert_eq!(arguments.len(), n, "as many arguments as parameters");
        let is_constant = |&e: &Expr| self.has_fact(e, fact::CONSTANT);
        let body = self.named(function, |row| row.body);
        if is_constant(&body) || arguments.iter().all(is_constant) {
            return self.body_at(function, arguments);
        }
        let second = arguments.get(1).copied().unwrap_or(ZERO);
        self.intern(Op::Named, arguments[0], second, function.0)
    }

    /// Writes functions with names out, so that no call of one is left.
    pub fn expand_named(&self, roots: &[Expr]) -> Vec<Expr> {
        self.map_named(roots, |function, arguments| self.body_at(function, arguments))
    }

    /// The functions with names that are called in some expressions, derivatives as themselves, in the order of
    /// their definition.
    pub fn functions_of(&self, roots: &[Expr]) -> Vec<FunctionId> {
        let sweep = self.sweep(roots);
        let named = sweep.steps.iter().filter(|step| step.op == Op::Named);
        let mut found: Vec<FunctionId> = named.map(|step| FunctionId(step.data)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The function of which this one is a derivative; of others the function itself.
    pub fn base_function(&self, function: FunctionId) -> FunctionId {
        self.named(function, |row| row.base).unwrap_or(function)
    }

    /// The name and parameters of a function.
    pub fn signature_of(&self, function: FunctionId) -> (String, Vec<SymbolId>) {
        self.named(function, |row| (row.name.clone(), row.parameters.clone()))
    }

    /// The function that text calls so: `gas`, `gas'` or `torque_x`.
    pub(crate) fn function_written(&self, written: &str) -> Option<FunctionId> {
        let of_name = |name: &str| self.find_named(|row| row.name == name && row.orders == [0; 2]);
        let name = written.trim_end_matches('\'');
        if let Some(function) = of_name(name) {
            let n = written.len() - name.len();
            return Some((0..n).fold(function, |of, _| self.named_derivative(of, 0)));
        }
        // Behind the name of a function of two variables those by which it is differentiated.
        let ends = name.match_indices('_').map(|(at, _)| at);
        ends.filter_map(|at| Some((of_name(&name[..at])?, &name[at + 1..]))).find_map(|(of, by)| {
            let (_, parameters) = self.signature_of(of);
            let names: Vec<String> = parameters.iter().map(|&s| self.symbol_name(s)).collect();
            by.split('_').try_fold(of, |of, variable| {
                let parameter = names.iter().position(|name| name == variable)?;
                Some(self.named_derivative(of, parameter))
            })
        })
    }

    /// The derivative by a parameter.
    pub(crate) fn named_derivative(&self, function: FunctionId, parameter: usize) -> FunctionId {
        if let Some(known) = self.named(function, |row| row.derivatives[parameter]) {
            return known;
        }
        let mut row = self.named(function, Clone::clone);
        row.base = row.base.or(Some(function));
        row.orders[parameter] += 1;
        row.derivatives = [None; 2];
        // ∂²f/∂x∂y is one function, whichever came first.
        let known = self.find_named(|one| one.base == row.base && one.orders == row.orders);
        let derivative = known.unwrap_or_else(|| {
            row.body = self.diff(row.body, row.parameters[parameter]);
            self.add_named(row)
        });
        self.note_derivative(function, parameter, derivative);
        derivative
    }

    /// The slopes of a call by its arguments.
    pub(crate) fn named_slope(&self, call: Expr, parameter: usize) -> Expr {
        let node = self.node(call);
        let function = self.named_derivative(FunctionId(node.data), parameter);
        self.apply(function, &self.operands_of(call))
    }

    /// Number of arguments of a call.
    pub(crate) fn named_arity(&self, call: Expr) -> usize {
        self.named(FunctionId(self.node(call).data), |row| row.parameters.len())
    }

    /// A call with a smooth function in its place: sin(α x + β y + γ), the numbers by the name, so that the place
    /// of a derivative is taken by the same derivative of it.
    pub(crate) fn stand_in_call(&self, function: FunctionId, arguments: &[Expr]) -> Expr {
        let orders = self.named(function, |row| row.orders);
        let mut state = self.named(self.base_function(function), |row| row.hash);
        let mut thousandths = || {
            #[expect(clippy::cast_possible_truncation, reason = "below a thousand")]
            let n = (1000.0 * unit_random(&mut state)) as i64;
            self.rational(200 + n, 1000)
        };
        let (rates, phase) = ([thousandths(), thousandths()], thousandths());
        let terms = arguments.iter().zip(rates).map(|(&a, rate)| self.mul(rate, a));
        let quarters = self.mul(self.rational(i64::from(orders[0] + orders[1]), 2), self.pi());
        let angle = self.sum(terms.chain([phase, quarters]));
        let scale = rates.iter().zip(orders).map(|(&rate, n)| self.powi(rate, i64::from(n)));
        self.product(scale.chain([self.sin(angle)]))
    }

    /// Replaces the calls of functions with names by their images.
    pub(crate) fn map_named(
        &self,
        roots: &[Expr],
        image: impl Fn(FunctionId, &[Expr]) -> Expr,
    ) -> Vec<Expr> {
        if !self.has_named() {
            return roots.to_vec();
        }
        let sweep = self.sweep(roots);
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let operands: Vec<Expr> = sweep.operands(step).map(|o| images[o]).collect();
            let is_same = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
            images.push(match step.op {
                Op::Named => image(FunctionId(step.data), &operands),
                _ if is_same => step.expr,
                _ => self.rebuild(step, &operands),
            });
        }
        sweep.roots.iter().map(|&root| images[root]).collect()
    }

    fn body_at(&self, function: FunctionId, arguments: &[Expr]) -> Expr {
        let (body, parameters) = self.named(function, |row| (row.body, row.parameters.clone()));
        let map: Vec<(SymbolId, Expr)> =
            parameters.into_iter().zip(arguments.iter().copied()).collect();
        self.substitute(body, &map)
    }
}

#[cfg(test)]
mod tests {
    use super::FunctionId;
    use crate::pool::{Expr, Pool};
    use crate::print::{Notation, Printer};

    fn pool() -> (Pool, [FunctionId; 2]) {
        let pool = Pool::new();
        let [x, y] = ["x", "y"].map(|name| pool.symbol_id(pool.symbol(name)).expect("a symbol"));
        let body = |text: &str| pool.parse(text).expect("valid");
        let gas = pool.define("gas", &[x], body("if(lt(x, 1), x^3, 3*x - 2)"));
        let torque = pool.define("torque", &[x, y], body("x^2*y + sin(y)"));
        (pool, [gas, torque])
    }

    fn written(pool: &Pool, e: Expr) -> [String; 5] {
        use Notation::{Latex, MathMl, Text, Typst, Unicode};
        [Text, Unicode, Latex, Typst, MathMl].map(|notation| Printer::new(pool, notation).expr(e))
    }

    #[test]
    fn derivatives_are_calls_of_their_own() {
        let (pool, [gas, torque]) = pool();
        let [q, p] = ["q", "p"].map(|name| pool.symbol(name));
        let [of_q, of_p] = [q, p].map(|e| pool.symbol_id(e).expect("a symbol"));
        let slope = pool.diff(pool.apply(gas, &[pool.mul(pool.int(2), q)]), of_q);
        let [text, unicode, latex, typst, mathml] = written(&pool, slope);
        assert_eq!((text.as_str(), unicode.as_str()), ("2*gas'(2*q)", "2·gas′(2·q)"));
        assert_eq!(latex, r"2 \, \mathrm{gas}'(2 \, q)");
        assert_eq!(typst, "2 thin \"gas\"'(2 thin q)");
        assert!(mathml.contains("gas</mi><mo lspace=\"0\">′</mo>"), "{mathml}");

        // ∂²/∂x∂y is one function, in whichever order.
        let call = pool.apply(torque, &[q, p]);
        let mixed = pool.diff(pool.diff(call, of_q), of_p);
        assert_eq!(mixed, pool.diff(pool.diff(call, of_p), of_q));
        for e in [slope, mixed] {
            assert_eq!(pool.parse(&pool.to_text(e)), Ok(e), "{}", pool.to_text(e));
        }
        let [text, _, latex, ..] = written(&pool, mixed);
        assert_eq!(text, "torque_x_y(q, p)");
        assert_eq!(latex, r"\partial_{x y}\mathrm{torque}(q, p)");
        assert_eq!(pool.to_text(pool.expand_named(&[mixed])[0]), "2*q");
    }

    #[test]
    fn forward_and_backward_derivatives_are_those_of_the_expression_written_out() {
        let (pool, [gas, torque]) = pool();
        let names = ["q", "p", "r", "s", "u"];
        let [q, p, r, s, u] = names.map(|name| pool.symbol(name));
        let inner = pool.sum([q, pool.mul(p, r), pool.mul(s, u)]);
        let e = pool.mul(pool.apply(gas, &[inner]), pool.apply(torque, &[inner, q]));
        let wrt = [q, p, r, s, u].map(|e| pool.symbol_id(e).expect("a symbol"));
        let outside = pool.expand_named(&pool.vjp(&[e], &[pool.one()], &wrt));
        let inside = wrt.map(|x| pool.diff(pool.expand_named(&[e])[0], x));
        for ((backward, direct), x) in outside.into_iter().zip(inside).zip(wrt) {
            let forward = pool.expand_named(&[pool.diff(e, x)])[0];
            assert!(pool.certificate(forward, direct).is_equal());
            assert!(pool.certificate(backward, direct).is_equal());
        }
    }

    #[test]
    fn certificates_tell_functions_and_their_derivatives_apart() {
        let (pool, [gas, torque]) = pool();
        let [q, p] = ["q", "p"].map(|name| pool.symbol(name));
        let of_q = pool.symbol_id(q).expect("a symbol");
        let one = pool.apply(gas, &[pool.add(q, p)]);
        let slope = pool.diff(one, of_q);
        let product = pool.mul(q, one);
        let by_rule = pool.add(one, pool.mul(q, slope));
        assert!(pool.certificate(pool.diff(product, of_q), by_rule).is_equal());
        assert!(!pool.certificate(one, slope).is_equal());
        assert!(!pool.certificate(one, pool.apply(torque, &[q, p])).is_equal());
    }

    #[test]
    fn calls_at_numbers_are_numbers_and_pools_from_snapshots_know_functions() {
        let (pool, [gas, _]) = pool();
        let value = |n: i64| pool.apply(gas, &[pool.rational(n, 2)]);
        assert_eq!([1, 4].map(value).map(|e| pool.to_text(e)), ["0.125", "4"]);
        let call = pool.apply(gas, &[pool.symbol("q")]);
        let thawed = pool.snapshot().to_pool();
        assert_eq!(thawed.to_text(call), "gas(q)");
        let q = thawed.find_symbol("q").expect("a symbol");
        assert_eq!(thawed.evaluate(call, &|s| (s == q).then_some(3.0)), Ok(7.0));
    }
}
