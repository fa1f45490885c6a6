"""Derivatives of compiled functions and of quantities by name, against differences."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import bksim

FUNCTIONS = (
    "mass_matrix",
    "forces",
    "constraint_jacobian",
    "constraints",
    "accelerations",
    "multipliers",
    "residual",
)


def slope(f: Callable[[np.ndarray], np.ndarray], x: np.ndarray, h: float = 1e-5) -> np.ndarray:
    """Differences of fourth order, the variable as the last axis."""
    columns = []
    for k in range(len(x)):
        e = h * np.eye(len(x))[k]
        near, far = f(x + e) - f(x - e), f(x + 2 * e) - f(x - 2 * e)
        columns.append((8 * near - far) / (12 * h))
    return np.stack(columns, axis=-1) if columns else np.empty((*f(x).shape, 0))


def close(found: np.ndarray, expected: np.ndarray) -> None:
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, atol=1e-6 * (1 + np.abs(expected).max(initial=0.0)))


@pytest.mark.parametrize("name", ["slider-crank", "four-bar", "spring-pendulum", "governor"])
@pytest.mark.parametrize("of", FUNCTIONS)
def test_functions_have_the_slopes_of_their_differences(name: str, of: str, examples: Path) -> None:
    m = bksim.load(examples / name / "model.toml")
    sol, f = m.solve(t_end=0.2), m.compile()
    k = len(sol) // 2
    t, q, v, a, lam = float(sol.t[k]), *(x[:, k].copy() for x in (sol.q, sol.v, sol.a, sol.lam))
    given = {"a": a, "lam": lam} if of == "residual" else {}

    def value(q: np.ndarray, v: np.ndarray, f: bksim.Functions = f, t: float = t) -> np.ndarray:
        match of:
            case "mass_matrix":
                return f.mass_matrix(q, t)
            case "constraint_jacobian":
                return f.constraint_jacobian(q, t)
            case "constraints":
                return f.constraints(t, q)
            case "forces":
                return f.forces(t, q, v)
            case "residual":
                return f.residual(t, q, v, a, lam)
        return f.accelerations_and_multipliers(t, q, v)[of == "multipliers"]

    found = f.derivatives(of, t, q, v, **given, by=["t", "q", "v"])
    close(found["q"], slope(lambda x: value(x, v), q))
    close(found["v"], slope(lambda x: value(q, x), v))
    close(found["t"], slope(lambda x: value(q, v, t=float(x[0])), np.array([t]))[..., 0])
    if of == "residual":
        by = f.derivatives(of, t, q, v, a, lam, by=["a", "lam"])
        close(by["a"], slope(lambda x: f.residual(t, q, v, x, lam), a))
        close(by["lam"], slope(lambda x: f.residual(t, q, v, a, x), lam))

    # By a parameter, with those that are defined through it.
    parameter = next(iter(m.parameters))

    def at(x: np.ndarray) -> np.ndarray:
        other = m.copy()
        other.parameters[parameter] = float(x[0])
        return value(q, v, other.compile())

    found = f.derivatives(of, t, q, v, **given, by=f"parameters.{parameter}")
    expected = slope(at, np.array([m.parameters[parameter]]))[..., 0]
    close(found[f"parameters.{parameter}"], expected)


def test_quantities_are_those_of_the_solution_with_their_slopes(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "model.toml")
    sol, f = m.solve(t_end=0.3), m.compile()
    names = ["rod.B.vx", "crank.angle", "energy.total", "energy.power", "reactions.B.fx", "reactions.A.mz"]
    names += ["reactions.B.fy_joint", "x3", "state.theta1_dot", "rod.ax"]
    found = f.measure(names, sol.q.T, sol.v.T, sol.t)
    for k, name in enumerate(names):
        np.testing.assert_allclose(found[:, k], sol[name], rtol=1e-8, atol=1e-8, err_msg=name)
    q, v = sol.q[:, 20].copy(), sol.v[:, 20].copy()
    assert np.array_equal(f.measure("x3", q, v), f.measure(names, q, v)[names.index("x3")])
    slopes = f.derivatives(names, 0.0, q, v)
    close(slopes["q"], slope(lambda x: f.measure(names, x, v), q))
    close(slopes["v"], slope(lambda x: f.measure(names, q, x), v))
    batch = f.derivatives(names, sol.t, sol.q.T, sol.v.T, by="q")["q"]
    assert batch.shape == (len(sol), len(names), f.nq) and np.array_equal(batch[20], slopes["q"])
    with pytest.raises(KeyError, match="energy.work"):
        f.measure("energy.work", q)
    with pytest.raises(KeyError, match="is no parameter"):
        f.derivatives("forces", 0.0, q, v, by="a")
    with pytest.raises(ValueError, match="give a and lam"):
        f.derivatives("residual", 0.0, q, v)


def test_a_controller_follows_from_the_derivatives(examples: Path) -> None:
    m = bksim.load(examples / "cart-pole" / "model.toml")
    d = m.compile().derivatives("accelerations", 0.0, np.zeros(2), np.zeros(2), by=["q", "v", "u"])
    by_hand = m.linearize(at="start")
    assert np.linalg.matrix_rank(np.column_stack([d["u"], d["q"] @ d["u"]])) == 2
    assert by_hand is not None


def test_multipliers_that_are_shared_have_no_slopes(examples: Path) -> None:
    m = bksim.load(examples / "parallelogram" / "model.toml")
    f = m.compile()
    q = m.solve(t_end=0.05).q[:, -1].copy()
    assert np.isfinite(f.derivatives("accelerations", 0.0, q, by="q")["q"]).all()
    with pytest.raises(ValueError, match="repeat each other"):
        f.derivatives("multipliers", 0.0, q, by="q")


@pytest.mark.parametrize("by", ["l1", "A.rate"])
def test_sensitivities_have_every_name_of_a_solution(by: str, examples: Path, tmp_path: Path) -> None:
    names = ["reactions.B.fx", "energy.total", "energy.kinetic", "rod.B.vx", "crank.angle", "rod.ax"]
    names += ["reactions.B.fy_joint", "state.x3", "acceleration.theta1_ddot"]

    def solved(step: float, **how: str) -> bksim.Solution:
        text = (examples / "slider-crank" / "model.toml").read_text()
        m = bksim.loads(text)
        if by == "l1":
            m.parameters["l1"] = 1.0 + step
        else:
            m.initial["A"] = {**m.initial["A"], "rate": 0.3 + step}
        return m.solve(t_end=0.3, rtol=1e-11, atol=1e-13, method="radau", **how)

    h = 1e-4
    sol, high, low = solved(0.0, sensitivity=by), solved(h), solved(-h)
    for name in names:
        expected = (high[name] - low[name]) / (2 * h)
        found = sol.sensitivity[by][name]
        np.testing.assert_allclose(found, expected, atol=2e-5 * (1 + np.abs(expected).max()), err_msg=name)
    sol.save(tmp_path / "run.mcap")
    logged = bksim.open(tmp_path / "run.mcap").sensitivity[by]["reactions.B.fx"]
    np.testing.assert_allclose(logged, sol.sensitivity[by]["reactions.B.fx"], rtol=1e-9)
    with pytest.raises(KeyError, match="nothing is called"):
        sol.sensitivity[by]["rod.B.vxx"]


def test_stepping_has_every_name_of_a_solution(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "model.toml")
    run, sol = m.begin(t_end=0.2), m.solve(t_end=0.2)
    run.advance_to(0.2)
    for name in ("rod.B.vx", "reactions.B.fx_joint", "crank.angle", "energy.total"):
        assert run[name] == pytest.approx(sol[name][-1], rel=1e-12), name


def test_one_state_needs_no_more_than_a_few_calls_of_numpy(examples: Path) -> None:
    from time import process_time

    m = bksim.load(examples / "slider-crank" / "model.toml")
    sol, f = m.solve(t_end=0.2), m.compile()
    q, v = sol.q[:, 20].copy(), sol.v[:, 20].copy()
    a, lam = sol.a[:, 20].copy(), sol.lam[:, 20].copy()

    def cost(call: Callable[[], object]) -> float:
        best = np.inf
        for _ in range(20):
            begun = process_time()
            for _ in range(200):
                call()
            best = min(best, process_time() - begun)
        return best

    # np.cos of five numbers takes about half a microsecond; a call was 40 of them before its buffers were kept.
    unit = cost(lambda: np.cos(q))
    for call in (
        lambda: f.mass_matrix(q),
        lambda: f.forces(0.0, q, v),
        lambda: f.accelerations(0.0, q, v),
        lambda: f.residual(0.0, q, v, a, lam),
    ):
        assert cost(call) < 15 * unit
    assert np.array_equal(f.forces(0, list(q), list(v)), f.forces(0.0, q, v))
    assert np.array_equal(f.mass_matrix(q[None])[0], f.mass_matrix(q))
