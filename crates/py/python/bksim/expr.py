"""The algebra by itself: exact, shared, simplified within a budget.

>>> import numpy as np
>>> from bksim import expr
>>> a, b = expr.symbols("a b")
>>> e = expr.sin(a) * expr.cos(b) + expr.cos(a) * expr.sin(b)
>>> e.simplify()
sin(a + b)
>>> e.diff(a).subs({a: 0, b: 0})
1
>>> f = expr.lambdify([a, b], e)
>>> bool(abs(f(0.5, 0.25) - np.sin(0.75)) < 1e-15)
True

Expressions of one process share an arena, in which equal ones are one; it is as large as everything
that was ever built.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Union, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _bksim
from ._words import Notation

Operand = Union["Expr", int, float]
"""What stands for an expression."""


class Expr:
    """An expression: operators build new ones, ``==`` asks whether two are the same."""

    __slots__ = ("_e",)
    _e: _bksim.Expr

    def __init__(self, value: Operand | str) -> None:
        if isinstance(value, Expr):
            self._e = value._e
        elif isinstance(value, str):
            self._e = _bksim.Expr.parse(value)
        else:
            self._e = _bksim.Expr.number(_plain(value))

    @classmethod
    def _of(cls, e: _bksim.Expr) -> Expr:
        made = object.__new__(cls)
        made._e = e
        return made

    def _with(self, other: Any, of: Callable[[Any, Any], _bksim.Expr], is_left: bool = True) -> Any:
        operand = _operand(other)
        if operand is None:
            # Arrays apply the operator to their elements.
            return NotImplemented
        return Expr._of(of(self._e, operand) if is_left else of(operand, self._e))

    def __add__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.add))

    def __radd__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.add, is_left=False))

    def __sub__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.sub))

    def __rsub__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.sub, is_left=False))

    def __mul__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.mul))

    def __rmul__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.mul, is_left=False))

    def __truediv__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.truediv))

    def __rtruediv__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.truediv, is_left=False))

    def __pow__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.pow))

    def __rpow__(self, other: Operand) -> Expr:
        return cast(Expr, self._with(other, operator.pow, is_left=False))

    def __neg__(self) -> Expr:
        return Expr._of(-self._e)

    def __pos__(self) -> Expr:
        return self

    def __eq__(self, other: object) -> bool:
        if isinstance(other, (Expr, int, float)):
            return self._e == _lowered(other)
        return NotImplemented

    def __hash__(self) -> int:
        return hash(self._e)

    def __reduce__(self) -> tuple[Any, ...]:
        # By its steps, each once: written out, shared parts would have no end.
        return _listed, (self._e.listing(),)

    def __copy__(self) -> Expr:
        return self

    def __deepcopy__(self, memo: Any) -> Expr:
        return self

    def diff(self, by: Expr, n: int = 1) -> Expr:
        """The derivative by a symbol, ``n`` times."""
        return Expr._of(self._e.diff(_symbol(by)._e, n))

    def simplify(self) -> Expr:
        """The cheapest form that is found; its value is kept on the whole domain."""
        return Expr._of(self._e.simplify())

    def expand(self) -> Expr:
        """Products multiplied out."""
        return Expr._of(self._e.expand())

    def subs(self, values: Mapping[Expr, Operand]) -> Expr:
        """Symbols replaced, all at once."""
        return Expr._of(
            self._e.substitute([(_symbol(of)._e, _lowered(by)) for of, by in values.items()])
        )

    def series(self, by: Expr, about: Operand = 0, order: int = 3) -> Expr:
        """The Taylor polynomial about a point. Raises ValueError where the expression or one of its
        derivatives has no finite value there."""
        return Expr._of(self._e.series(_symbol(by)._e, _lowered(about), order))

    def evaluate(self, values: Mapping[Expr, float] | None = None) -> float:
        """The value where symbols have these values, as floating point has it: ``1/a`` is infinite at 0,
        ``log(-1)`` NaN. Raises ValueError when a symbol has none."""
        pairs = [(_symbol(of)._e, float(value)) for of, value in (values or {}).items()]
        return self._e.evaluate(pairs)

    def __float__(self) -> float:
        return self.evaluate()

    @property
    def free_symbols(self) -> set[Expr]:
        """The symbols in it."""
        return {Expr._of(e) for e in self._e.symbols()}

    @property
    def n_operations(self) -> int:
        """Operations it takes, each shared part once."""
        return self._e.n_operations()

    def equals(self, other: Operand) -> bool:
        """Whether it has the values of another at random points, to 30 digits."""
        return self._e.equals(_lowered(other))

    def written(self, notation: Notation = "text") -> str:
        """As ``text``, ``unicode``, ``latex``, ``typst`` or ``mathml``."""
        return self._e.written(notation)

    def latex(self) -> str:
        """As LaTeX."""
        return self.written("latex")

    def __repr__(self) -> str:
        return self.written("text")

    def _repr_latex_(self) -> str:
        return f"${self.latex()}$"


def _listed(listing: str) -> Expr:
    return Expr._of(_bksim.Expr.of_listing(listing))


def _plain(value: Any) -> int | float:
    value = value.item() if hasattr(value, "item") else value
    if isinstance(value, float) and value != value:
        raise ValueError("NaN is no number")
    if isinstance(value, (int, float)):
        return value
    raise TypeError(f"{type(value).__name__} is no expression and no number")


def _operand(value: Any) -> _bksim.Expr | None:
    """What stands for an expression; None for anything else."""
    is_number = isinstance(value, (Expr, int, float, np.number)) or np.shape(value) == ()
    try:
        return _lowered(value) if is_number else None
    except TypeError:
        return None


def _symbol(value: Expr) -> Expr:
    if isinstance(value, Expr):
        return value
    raise TypeError(f"{value!r} is no symbol: make one with symbol({value!r})")


def _lowered(value: Any) -> _bksim.Expr:
    return value._e if isinstance(value, Expr) else _bksim.Expr.number(_plain(value))


def symbol(name: str) -> Expr:
    """The symbol of a name; the same one whenever it is asked for."""
    return Expr._of(_bksim.Expr.symbol(name))


def symbols(names: str) -> tuple[Expr, ...]:
    """Symbols of names with spaces or commas between them."""
    return tuple(symbol(name) for name in names.replace(",", " ").split())


def parse(text: str) -> Expr:
    """The expression of a text. Raises ValueError saying what is wrong."""
    return Expr._of(_bksim.Expr.parse(text))


def _function(name: str) -> Callable[..., Expr]:
    def function(*arguments: Operand) -> Expr:
        return Expr._of(_bksim.Expr.call(name, [_lowered(a) for a in arguments]))

    function.__name__ = function.__qualname__ = name
    function.__doc__ = f"The function ``{name}``."
    return function


sin, cos, tan = _function("sin"), _function("cos"), _function("tan")
asin, acos, atan, atan2 = (_function(name) for name in ("asin", "acos", "atan", "atan2"))
sinh, cosh, tanh = _function("sinh"), _function("cosh"), _function("tanh")
exp, log, sqrt = _function("exp"), _function("ln"), _function("sqrt")
sign, minimum, maximum = _function("sign"), _function("min"), _function("max")
absolute = _function("abs")
pi: Expr = parse("pi")


def lambdify(
    arguments: Sequence[Expr], expressions: Expr | Sequence[Operand]
) -> Lambda:
    """A function of numbers or arrays, which are broadcast; one value for one expression, a list of
    them for several. It is compiled once and evaluated in lanes."""
    return Lambda(tuple(arguments), expressions if isinstance(expressions, Expr) else tuple(expressions))


class Lambda:
    """Expressions as a compiled function of numbers or arrays: see :func:`lambdify`.

    It is pickled as its expressions, and compiled again where it is needed.
    """

    def __init__(self, arguments: tuple[Expr, ...], expressions: Expr | tuple[Operand, ...]) -> None:
        self.arguments = arguments
        self.expressions = expressions
        outputs = (expressions,) if isinstance(expressions, Expr) else expressions
        self._compiled = _bksim.Compiled([a._e for a in arguments], [_lowered(e) for e in outputs])

    def __call__(self, *values: ArrayLike) -> Any:
        if len(values) != len(self.arguments):
            raise TypeError(f"{len(values)} values for {len(self.arguments)} arguments")
        arrays = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in values))
        shape = arrays[0].shape if arrays else ()
        rows: NDArray[np.float64] = np.stack([a.ravel() for a in arrays]) if arrays else np.empty((0, 1))
        out = self._compiled.evaluate(rows)
        results = [row.reshape(shape) if shape else np.float64(row[0]) for row in out]
        return results[0] if isinstance(self.expressions, Expr) else results

    def __reduce__(self) -> tuple[Any, ...]:
        return Lambda, (self.arguments, self.expressions)

    def __repr__(self) -> str:
        return f"<bksim.expr.Lambda of {', '.join(map(str, self.arguments)) or 'nothing'}>"
