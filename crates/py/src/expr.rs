//! The algebra by itself. All expressions of a process share one pool, so that any of them can be
//! combined and equal ones are one; it lives as long as the process.

use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use bksim::expr::{self, Batch, Function, Notation, Pool, Printer, SymbolId, Tape};
use numpy::ndarray::Array2;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::basic::CompareOp;
use pyo3::prelude::*;

use crate::fault::{Fault, guard};

static POOL: LazyLock<Mutex<Pool>> = LazyLock::new(|| Mutex::new(Pool::new()));

fn pool() -> MutexGuard<'static, Pool> {
    // A pool is whole between its calls, also after a panic in one.
    POOL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An expression.
#[pyclass(frozen, from_py_object, module = "bksim.expr")]
#[derive(Clone, Copy)]
pub(crate) struct Expr(expr::Expr);

/// A Python value that stands for an expression.
#[derive(FromPyObject)]
enum Operand {
    Expr(Expr),
    Int(i64),
    Float(f64),
}

impl Operand {
    fn lowered(&self, pool: &Pool) -> expr::Expr {
        match *self {
            Self::Expr(Expr(e)) => e,
            Self::Int(n) => pool.int(n),
            Self::Float(x) => pool.float(x),
        }
    }
}

fn symbol(pool: &Pool, e: Expr) -> Result<SymbolId, Fault> {
    let not = || Fault::Value(format!("`{}` is not a symbol", pool.to_text(e.0)));
    pool.symbol_id(e.0).ok_or_else(not)
}

impl Expr {
    fn with(
        self,
        py: Python<'_>,
        other: Operand,
        build: impl FnOnce(&Pool, expr::Expr, expr::Expr) -> expr::Expr + Send,
    ) -> PyResult<Self> {
        guard(py, move || {
            let pool = pool();
            let other = other.lowered(&pool);
            Ok(Self(build(&pool, self.0, other)))
        })
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "methods of Python take a reference")]
#[pymethods]
impl Expr {
    /// The symbol of a name.
    #[staticmethod]
    fn symbol(py: Python<'_>, name: String) -> PyResult<Self> {
        guard(py, move || {
            let is_first = |c: char| c.is_alphabetic() || c == '_';
            let is_name = name.chars().next().is_some_and(is_first)
                && name.chars().all(|c| is_first(c) || c.is_ascii_digit());
            if !is_name {
                return Err(Fault::Value(format!("{name:?} cannot be the name of a symbol")));
            }
            Ok(Self(pool().symbol(&name)))
        })
    }

    /// A number, an integer exactly.
    #[staticmethod]
    fn number(py: Python<'_>, value: Operand) -> PyResult<Self> {
        guard(py, move || Ok(Self(value.lowered(&pool()))))
    }

    /// The expression of a text.
    #[staticmethod]
    fn parse(py: Python<'_>, text: String) -> PyResult<Self> {
        guard(py, move || pool().parse(&text).map(Self).map_err(|e| Fault::Value(e.to_string())))
    }

    /// A function of the algebra at expressions.
    #[staticmethod]
    fn call(py: Python<'_>, name: String, arguments: Vec<Operand>) -> PyResult<Self> {
        guard(py, move || {
            let function = Function::from_name(&name)
                .ok_or_else(|| Fault::Name(format!("no function is called `{name}`")))?;
            let pool = pool();
            let arguments: Vec<_> = arguments.iter().map(|a| a.lowered(&pool)).collect();
            let called = pool.call(function, &arguments).map(Self);
            let n = function.arity();
            called.ok_or_else(|| Fault::Value(format!("`{name}` takes {n} arguments")))
        })
    }

    fn __add__(&self, py: Python<'_>, other: Operand) -> PyResult<Self> {
        self.with(py, other, Pool::add)
    }

    fn __radd__(&self, py: Python<'_>, other: Operand) -> PyResult<Self> {
        self.with(py, other, |pool, a, b| pool.add(b, a))
    }

    fn __sub__(&self, py: Python<'_>, other: Operand) -> PyResult<Self> {
        self.with(py, other, Pool::sub)
    }

    fn __rsub__(&self, py: Python<'_>, other: Operand) -> PyResult<Self> {
        self.with(py, other, |pool, a, b| pool.sub(b, a))
    }

    fn __mul__(&self, py: Python<'_>, other: Operand) -> PyResult<Self> {
        self.with(py, other, Pool::mul)
    }

    fn __rmul__(&self, py: Python<'_>, other: Operand) -> PyResult<Self> {
        self.with(py, other, |pool, a, b| pool.mul(b, a))
    }

    fn __truediv__(&self, py: Python<'_>, other: Operand) -> PyResult<Self> {
        self.with(py, other, Pool::div)
    }

    fn __rtruediv__(&self, py: Python<'_>, other: Operand) -> PyResult<Self> {
        self.with(py, other, |pool, a, b| pool.div(b, a))
    }

    fn __pow__(&self, py: Python<'_>, other: Operand, modulo: Option<i64>) -> PyResult<Self> {
        if modulo.is_some() {
            return guard(py, || Err(Fault::Value("powers have no modulus".to_owned())));
        }
        self.with(py, other, Pool::pow)
    }

    fn __rpow__(&self, py: Python<'_>, other: Operand, modulo: Option<i64>) -> PyResult<Self> {
        if modulo.is_some() {
            return guard(py, || Err(Fault::Value("powers have no modulus".to_owned())));
        }
        self.with(py, other, |pool, a, b| pool.pow(b, a))
    }

    fn __neg__(&self, py: Python<'_>) -> PyResult<Self> {
        let e = self.0;
        guard(py, move || Ok(Self(pool().neg(e))))
    }

    fn __pos__(&self) -> Self {
        *self
    }

    fn __richcmp__(&self, other: Operand, op: CompareOp) -> Option<bool> {
        let is_same = other.lowered(&pool()) == self.0;
        match op {
            CompareOp::Eq => Some(is_same),
            CompareOp::Ne => Some(!is_same),
            // Which is larger depends on the symbols.
            _ => None,
        }
    }

    /// The expression of a list of steps.
    #[staticmethod]
    fn of_listing(py: Python<'_>, listing: String) -> PyResult<Self> {
        guard(py, move || {
            let found = pool().read_listing(&listing).map_err(|e| Fault::Value(e.to_string()))?;
            let one = <[expr::Expr; 1]>::try_from(found).map_err(|found| {
                Fault::Value(format!("a list of {} expressions where one is needed", found.len()))
            })?;
            Ok(Self(one[0]))
        })
    }

    /// The steps that it is made of, each once.
    fn listing(&self, py: Python<'_>) -> PyResult<String> {
        let e = self.0;
        guard(py, move || Ok(pool().listing(&[e])))
    }

    fn __hash__(&self) -> u64 {
        use std::hash::{DefaultHasher, Hash, Hasher};
        let mut hasher = DefaultHasher::new();
        self.0.hash(&mut hasher);
        hasher.finish()
    }

    /// The derivative by a symbol, `n` times.
    fn diff(&self, py: Python<'_>, by: Expr, n: u32) -> PyResult<Self> {
        let e = self.0;
        guard(py, move || {
            let pool = pool();
            let by = symbol(&pool, by)?;
            Ok(Self((0..n).fold(e, |e, _| pool.diff(e, by))))
        })
    }

    /// The cheapest form that is found.
    fn simplify(&self, py: Python<'_>) -> PyResult<Self> {
        let e = self.0;
        guard(py, move || Ok(Self(pool().simplify(e))))
    }

    /// Products multiplied out.
    fn expand(&self, py: Python<'_>) -> PyResult<Self> {
        let e = self.0;
        guard(py, move || Ok(Self(pool().expand(e))))
    }

    /// Symbols replaced, all at once.
    fn substitute(&self, py: Python<'_>, map: Vec<(Expr, Operand)>) -> PyResult<Self> {
        let e = self.0;
        guard(py, move || {
            let pool = pool();
            let pair = |(of, by): &(Expr, Operand)| Ok((symbol(&pool, *of)?, by.lowered(&pool)));
            let map = map.iter().map(pair).collect::<Result<Vec<_>, Fault>>()?;
            Ok(Self(pool.substitute(e, &map)))
        })
    }

    /// The Taylor polynomial about a point.
    fn series(&self, py: Python<'_>, by: Expr, about: Operand, order: u32) -> PyResult<Self> {
        let e = self.0;
        guard(py, move || {
            if order > 40 {
                return Err(Fault::Value("a series has order 40 at most".to_owned()));
            }
            let pool = pool();
            let (by, about) = (symbol(&pool, by)?, about.lowered(&pool));
            let series = pool.series(e, by, about, order);
            if pool.is_singular(series) && !pool.is_singular(e) {
                let (by, about) = (pool.symbol_name(by), pool.to_text(about));
                let words = format!(
                    "there is no series about {by} = {about}: the expression or one of its \
                     derivatives has no finite value there"
                );
                return Err(Fault::Value(words));
            }
            Ok(Self(series))
        })
    }

    /// In a notation.
    fn written(&self, py: Python<'_>, notation: String) -> PyResult<String> {
        let e = self.0;
        guard(py, move || {
            let notation = match notation.as_str() {
                "text" => Notation::Text,
                "unicode" => Notation::Unicode,
                "latex" => Notation::Latex,
                "typst" => Notation::Typst,
                "mathml" => Notation::MathMl,
                other => return Err(Fault::Value(format!("{other:?} is no notation"))),
            };
            Ok(Printer::new(&pool(), notation).expr(e))
        })
    }

    /// The symbols in it.
    fn symbols(&self, py: Python<'_>) -> PyResult<Vec<Self>> {
        let e = self.0;
        guard(py, move || {
            let pool = pool();
            Ok(pool.symbols_of(e).into_iter().map(|id| Self(pool.symbol_expr(id))).collect())
        })
    }

    /// Value where the symbols have these values.
    fn evaluate(&self, py: Python<'_>, values: Vec<(Expr, f64)>) -> PyResult<f64> {
        let e = self.0;
        guard(py, move || {
            let pool = pool();
            let pair = |&(of, value): &(Expr, f64)| Ok((symbol(&pool, of)?, value));
            let values = values.iter().map(pair).collect::<Result<Vec<_>, Fault>>()?;
            let value = |id| values.iter().find(|(known, _)| *known == id).map(|&(_, value)| value);
            pool.evaluate(e, &value).map_err(|e| Fault::Value(e.to_string()))
        })
    }

    /// Operations it takes, each shared part once.
    fn n_operations(&self, py: Python<'_>) -> PyResult<u64> {
        let e = self.0;
        guard(py, move || Ok(pool().operation_count(&[e]).operations().total()))
    }

    /// Whether it has the values of another at random points, to 30 digits.
    fn equals(&self, py: Python<'_>, other: Operand) -> PyResult<bool> {
        let e = self.0;
        guard(py, move || {
            let pool = pool();
            let other = other.lowered(&pool);
            Ok(pool.certificate(e, other).is_equal())
        })
    }
}

/// Expressions compiled as functions of symbols.
#[pyclass(frozen, module = "bksim._bksim")]
pub(crate) struct Compiled {
    n_outputs: usize,
    /// At no points yet; clones share its machine code.
    batch: Batch,
    n_inputs: usize,
}

#[pymethods]
impl Compiled {
    #[new]
    fn new(py: Python<'_>, inputs: Vec<Expr>, outputs: Vec<Operand>) -> PyResult<Self> {
        guard(py, move || {
            let pool = pool();
            let symbols: Result<Vec<_>, _> = inputs.iter().map(|e| symbol(&pool, *e)).collect();
            let outputs: Vec<_> = outputs.iter().map(|e| e.lowered(&pool)).collect();
            let tape = Tape::compile(&pool, &outputs, &symbols?, &[]);
            let tape = tape.map_err(|e| Fault::Value(e.to_string()))?;
            let (n_inputs, n_outputs) = (inputs.len(), tape.n_outputs());
            Ok(Self { n_outputs, batch: tape.batch(&[]), n_inputs })
        })
    }

    /// Rows of inputs to rows of outputs: a column per point.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        inputs: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let inputs = inputs.as_array();
        let out = guard(py, || {
            if inputs.nrows() != self.n_inputs {
                let message =
                    format!("{} inputs where {} are needed", inputs.nrows(), self.n_inputs);
                return Err(Fault::Value(message));
            }
            let n_points = inputs.ncols();
            let inputs: Vec<f64> = inputs.iter().copied().collect();
            let mut out = Array2::zeros((self.n_outputs, n_points));
            if let Some(out) = out.as_slice_mut() {
                self.batch.clone().evaluate(n_points, &inputs, out);
            }
            Ok(out)
        })?;
        Ok(PyArray2::from_owned_array(py, out))
    }
}
