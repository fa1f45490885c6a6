//! Sums ordered the way mechanics reads them: parameters first, then the state.
//!
//! ```text
//! e = Σ  coefficient(parameters) · (sine or cosine) · (rest of the state)
//! ```
//!
//! Each product of state functions occurs once and carries all its parameters as one factored
//! coefficient, which a tape computes ahead of every evaluation. The cofactors of one coefficient
//! and one sine or cosine are a bracket of their own: `c*sin(q2)*(v1^2 - (v1 + v2)^2)`.

use super::cost::{CALL, TRIGONOMETRIC};
use super::factor::{Preference, factored};
use super::poly::{Algebra, Monomial, Poly, Reading, Term, is_trigonometric};
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool, SymbolId};
use std::collections::{HashMap, HashSet};

/// Multiplications of terms spent on one sum; beyond it the sum stays as it is.
const COLLECT_BUDGET: usize = 60_000;
/// Terms that a sum may have multiplied out so that a form between all sums and all products is looked for.
const MAX_SIMPLIFIED_TERMS: u64 = 100;
/// Symbols in a bracket up to which it is simplified by itself.
const MAX_BRACKET_SYMBOLS: usize = 3;

impl Pool {
    /// Collects `e` by functions of the symbols `state`; all other symbols are parameters.
    ///
    /// Products of sines and cosines become sums of angles where that leaves less to compute from
    /// the state. Sums without a sine or cosine are kept as they are.
    pub fn collect(&self, e: Expr, state: &[SymbolId]) -> Expr {
        self.collect_all(&[e], state)[0]
    }

    /// Collects several expressions; knowledge of their parts is shared.
    pub fn collect_all(&self, roots: &[Expr], state: &[SymbolId]) -> Vec<Expr> {
        let mut collector = Collector {
            pool: self,
            state: state.iter().copied().collect(),
            algebra: Algebra::new(self, COLLECT_BUDGET),
            is_state: HashMap::new(),
            brackets: HashMap::new(),
        };
        let mut known: HashMap<Expr, Expr> = HashMap::with_capacity(roots.len());
        roots
            .iter()
            .map(|&root| *known.entry(root).or_insert_with(|| collector.collect(root)))
            .collect()
    }
}

struct Collector<'p> {
    pool: &'p Pool,
    state: HashSet<SymbolId>,
    algebra: Algebra<'p>,
    /// Whether an atom depends on the state.
    is_state: HashMap<Expr, bool>,
    /// Brackets in their shorter form.
    brackets: HashMap<Expr, Expr>,
}

/// State monomials in the order of first occurrence, each with its coefficient as a polynomial in
/// the parameters.
type Groups = Vec<(Monomial, Poly)>;

/// The form with the least work so far.
struct LeastWork {
    work: u64,
    e: Expr,
}

impl Collector<'_> {
    fn collect(&mut self, e: Expr) -> Expr {
        let pool = self.pool;
        let products =
            Reading { is_fourier: false, keeps_plain_sums: true, splits_tangents: false };
        let sums = Reading { is_fourier: true, ..products };
        let mut best = LeastWork { work: self.state_work(e), e };
        let Some(plain) = self.groups(e, products) else { return e };
        // Nothing to fold where no term has two sines or cosines.
        let is_folded = plain.iter().all(|(monomial, _)| is_folded(pool, monomial));
        let plain = self.written(plain);
        let plain_work = self.consider(plain, &mut best);
        if is_folded {
            return best.e;
        }
        if let Some(folded) = self.groups(e, sums) {
            let folded = self.written(folded);
            // All sums or all products; where products win, something between may be shorter still.
            if plain_work < self.consider(folded, &mut best) {
                self.consider(pool.simplify_up_to(e, MAX_SIMPLIFIED_TERMS), &mut best);
            }
        }
        best.e
    }

    /// Takes a form of less work; at equal work the later form, which reads better.
    fn consider(&mut self, e: Expr, best: &mut LeastWork) -> u64 {
        let work = self.state_work(e);
        if work <= best.work {
            *best = LeastWork { work, e };
        }
        work
    }

    /// Operations at every evaluation: those on the state, weighted as by `cost`.
    fn state_work(&mut self, e: Expr) -> u64 {
        let sweep = self.pool.sweep(&[e]);
        let mut is_state: Vec<bool> = Vec::with_capacity(sweep.steps.len());
        let mut work = 0;
        for step in &sweep.steps {
            let n_state = sweep.operands(step).filter(|&o| is_state[o]).count();
            let n_early = usize::from(sweep.operands(step).len() > n_state);
            work += match step.op {
                _ if n_state == 0 => 0,
                Op::Add | Op::Mul => (n_state + n_early) as u64 - 1,
                Op::Pow => 1,
                Op::Call(Function::Sin | Function::Cos | Function::Tan) => TRIGONOMETRIC,
                _ => CALL,
            };
            is_state.push(match step.symbol() {
                Some(symbol) => self.state.contains(&symbol),
                None => n_state > 0,
            });
        }
        work
    }

    fn groups(&mut self, e: Expr, reading: Reading) -> Option<Groups> {
        self.algebra.budget = COLLECT_BUDGET;
        let poly = self.algebra.read(e, reading)?;
        let mut groups = Groups::new();
        let mut known: HashMap<Monomial, usize> = HashMap::with_capacity(poly.len());
        for Term { monomial, coefficient } in poly {
            let (of_state, of_parameters): (Monomial, Monomial) =
                monomial.into_iter().partition(|&(atom, _)| self.depends_on_state(atom));
            let term = Term { monomial: of_parameters, coefficient };
            if let Some(&index) = known.get(&of_state) {
                groups[index].1.push(term);
            } else {
                known.insert(of_state.clone(), groups.len());
                groups.push((of_state, vec![term]));
            }
        }
        Some(groups)
    }

    fn depends_on_state(&mut self, atom: Expr) -> bool {
        let (pool, state) = (self.pool, &self.state);
        *self.is_state.entry(atom).or_insert_with(|| {
            pool.sweep(&[atom])
                .steps
                .iter()
                .any(|step| step.symbol().is_some_and(|s| state.contains(&s)))
        })
    }

    /// The groups as one sum; those that share coefficient and call share a bracket.
    fn written(&mut self, groups: Groups) -> Expr {
        let pool = self.pool;
        let mut brackets: Vec<((Expr, Expr), Vec<Expr>)> = Vec::new();
        let mut known: HashMap<(Expr, Expr), usize> = HashMap::new();
        for (monomial, coefficient) in groups {
            let coefficient = factored(pool, &coefficient, Preference::Frequent);
            let (number, parameters) = pool.split_coefficient(coefficient);
            let (calls, rest): (Monomial, Monomial) =
                monomial.into_iter().partition(|&(atom, _)| is_trigonometric(pool, atom));
            let rest = pool.mul(pool.number(number), power_product(pool, &rest));
            let key = (parameters, power_product(pool, &calls));
            if let Some(&index) = known.get(&key) {
                brackets[index].1.push(rest);
            } else {
                known.insert(key, brackets.len());
                brackets.push((key, vec![rest]));
            }
        }
        let terms = brackets.into_iter().map(|((parameters, call), rest)| {
            let bracket = if rest.len() == 1 { rest[0] } else { self.bracket(pool.sum(rest)) };
            pool.product([parameters, call, bracket])
        });
        let terms: Vec<Expr> = terms.collect();
        pool.sum(terms)
    }

    /// A short bracket in its shortest form: `v1^2 - (v1 + v2)^2` is `-v2*(2*v1 + v2)`.
    fn bracket(&mut self, e: Expr) -> Expr {
        let pool = self.pool;
        *self.brackets.entry(e).or_insert_with(|| {
            let n_symbols = pool.symbols_of(e).len();
            if n_symbols <= MAX_BRACKET_SYMBOLS { pool.simplify(e) } else { e }
        })
    }
}

/// At most one sine or cosine, to the first power.
fn is_folded(pool: &Pool, monomial: &Monomial) -> bool {
    let calls = monomial.iter().filter(|&&(atom, _)| is_trigonometric(pool, atom));
    calls.map(|&(_, n)| n.unsigned_abs()).sum::<u32>() <= 1
}

fn power_product(pool: &Pool, monomial: &Monomial) -> Expr {
    let powers = monomial.iter().map(|&(atom, n)| pool.powi(atom, i64::from(n)));
    pool.product(powers.chain([pool.number(Number::ONE)]))
}

#[cfg(test)]
mod tests {
    use crate::pool::Pool;

    #[test]
    fn parameters_gather_before_functions_of_the_state() {
        for (text, expected) in [
            (
                "I1 + m*(l*cos(q))^2 + m*(l*sin(q))^2 + k*cos(q) + l*cos(q)",
                "I1 + l^2*m + (k + l)*cos(q)",
            ),
            ("a*cos(q)*b*cos(p) + a*sin(q)*b*sin(p)", "a*b*cos(p - q)"),
            ("c*sin(q)*v^2 - c*sin(q)*(v + w)^2", "-c*w*(2*v + w)*sin(q)"),
        ] {
            let pool = Pool::new();
            let e = pool.parse(text).expect(text);
            let state: Vec<_> = ["q", "p", "v", "w"].iter().map(|name| pool.symbol(name)).collect();
            let state: Vec<_> = state.iter().filter_map(|&s| pool.symbol_id(s)).collect();
            let collected = pool.collect(e, &state);
            assert_eq!(pool.to_text(collected), expected, "{text}");
            assert!(pool.certificate(e, collected).is_equal(), "{text}");
        }
    }
}
