"""The algebra by itself."""

from __future__ import annotations

import numpy as np
import pytest

from bksim import expr

x, y = expr.symbols("x, y")


def test_operators_and_numbers_build_expressions() -> None:
    assert 2 * x + x == 3 * x
    assert 1 - x == -(x - 1)
    assert (x / 2) ** 2 * 4 == x**2
    assert 2**x != x**2 and hash(x + y) == hash(y + x)
    assert repr(x / 3) == "1/3*x"
    assert float(expr.Expr(np.float64(0.5)) + 1) == 1.5
    with pytest.raises(TypeError):
        x + "y"  # type: ignore[operator]
    with pytest.raises(TypeError):
        x * None  # type: ignore[operator]


def test_arrays_are_met_element_by_element() -> None:
    numbers = np.array([1.0, 2.0])
    for product in (x * numbers, numbers * x):
        assert list(product) == [x, 2 * x]
    assert list(numbers - x) == [1 - x, 2 - x] and list(x - numbers) == [x - 1, x - 2]
    assert list(x ** np.array([1, 2])) == [x, x**2]
    matrix = np.array([[x, y], [0, 1]], dtype=object)
    assert list(matrix @ np.array([1, 2])) == [x + 2 * y, 2]
    assert x * np.float64(2) == np.float64(2) * x == 2 * x


def test_derivatives_simplify_subs_and_series() -> None:
    assert (x**3).diff(x, 2) == 6 * x
    assert (expr.sin(x) ** 2 + expr.cos(x) ** 2).simplify() == 1
    assert (x * y + 1).subs({x: y, y: x}) == x * y + 1
    assert expr.exp(x).series(x, 0, 2) == 1 + x + x**2 / 2
    assert (expr.sin(x) / x).series(x, 1, 0) == expr.sin(expr.Expr(1))
    for e in (1 / x, expr.sqrt(x), expr.log(x), expr.sin(x) / x):
        with pytest.raises(ValueError, match="no series about x = 0"):
            e.series(x)
    assert ((x + 1) ** 2).expand() == x**2 + 2 * x + 1
    with pytest.raises(ValueError, match="not a symbol"):
        x.diff(x + y)


def test_texts_are_read_and_written() -> None:
    e = expr.parse("sqrt(x^2 + y^2)")
    assert e.evaluate({x: 3, y: 4}) == 5.0
    assert e.latex() == r"\sqrt{x^{2} + y^{2}}" or e.latex().startswith(r"\sqrt")
    assert e.free_symbols == {x, y}
    assert e._repr_latex_().startswith("$")
    with pytest.raises(ValueError):
        expr.parse("x +")
    with pytest.raises(ValueError):
        expr.symbol("2x")
    with pytest.raises(ValueError):
        (x + y).evaluate({x: -1})


def test_equal_values_are_found_where_forms_differ() -> None:
    e = expr.sin(2 * x)
    assert e != 2 * expr.sin(x) * expr.cos(x)
    assert e.equals(2 * expr.sin(x) * expr.cos(x)) and not e.equals(2 * expr.sin(x))


def test_lambdify_broadcasts() -> None:
    f = expr.lambdify([x, y], expr.atan2(y, x))
    grid = np.linspace(0.1, 1, 7)
    assert np.allclose(f(grid, grid[:, None]), np.arctan2(grid[:, None], grid), rtol=1e-15)
    both = expr.lambdify([x], [x + 1, 2])(np.arange(3.0))
    assert np.array_equal(both[0], [1, 2, 3]) and np.array_equal(both[1], [2, 2, 2])
    with pytest.raises(TypeError):
        f(1.0)
    with pytest.raises(ValueError):
        expr.lambdify([x], x + y)
