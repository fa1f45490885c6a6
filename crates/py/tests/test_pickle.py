"""What goes to another process and comes back: models, functions, expressions, solutions, faults."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bksim
from bksim import expr


def again(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))


@pytest.fixture(scope="module")
def sol() -> bksim.Solution:
    from conftest import EXAMPLES

    m = bksim.load(EXAMPLES / "slider-crank" / "model.toml")
    m.parameters["l1"] = 1.05
    return m.solve(t_end=0.3, sensitivity="l1")


def same(one: bksim.Solution, other: bksim.Solution) -> None:
    assert other.names == one.names
    assert np.array_equal(other._table, one._table, equal_nan=True) and np.array_equal(other.t, one.t)
    assert other.summary == one.summary and other.warnings == one.warnings
    assert other.success == one.success and other.events == one.events
    assert repr(other) == repr(one)


def test_a_solution_comes_back_with_every_bit(sol: bksim.Solution, tmp_path: Path) -> None:
    other = again(sol)
    same(sol, other)
    t = np.linspace(0.0, 0.3, 37)
    assert np.array_equal(other(t)._table, sol(t)._table, equal_nan=True)
    assert np.array_equal(other["rod.B.vx"], sol["rod.B.vx"])
    assert np.array_equal(other.sensitivity["l1"].lam, sol.sensitivity["l1"].lam)
    assert not other.t.flags.writeable and not other.q.flags.writeable
    assert other.picture(0.1).svg == sol.picture(0.1).svg
    same(sol, again(other))
    # Its log is the one of the solution that it was.
    sol.save(tmp_path / "one.mcap")
    other.save(tmp_path / "other.mcap")
    assert (tmp_path / "one.mcap").read_bytes() == (tmp_path / "other.mcap").read_bytes()
    assert len(pickle.dumps(sol)) < 2 * (tmp_path / "one.mcap").stat().st_size


def test_an_opened_log_needs_its_file_no_more(sol: bksim.Solution, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    sol.save(path)
    logged = bksim.open(path)
    data = pickle.dumps(logged)
    path.unlink()
    same(logged, pickle.loads(data))


def test_samples_alone_come_back(sol: bksim.Solution) -> None:
    for samples in (sol(0.1), sol([0.1, 0.2])):
        other = again(samples)
        assert other.names == samples.names and np.array_equal(other.t, samples.t)
        assert np.array_equal(other["state.x3"], samples["state.x3"])
        assert np.array_equal(other["rod.B.vx"], samples["rod.B.vx"])
        assert np.array_equal(other.reactions["A"], samples.reactions["A"])
        assert not other.q.flags.writeable


def test_a_copy_of_what_cannot_change_is_itself(sol: bksim.Solution) -> None:
    f = bksim.loads(PENDULUM).compile()
    x = expr.symbol("x")
    for value in (sol, f, x):
        assert copy.copy(value) is value and copy.deepcopy(value) is value


PENDULUM = """
[parameters]
l = "0.5 m"
k = "2"
m = "k*1 kg"
u = "0 N m"
[bodies.bob]
mass = "m"
com = [0, "-l"]
[joints.A]
type = "revolute"
between = ["ground", "bob"]
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[loads.motor]
type = "torque"
on = "bob"
value = "u"
[initial]
A = { angle = "30 deg" }
[solve]
t_end = "1 s"
"""


def law(t: float, q: np.ndarray, v: np.ndarray) -> float:
    return -0.3 * float(v[0])


@pytest.mark.parametrize("change", ["none", "number", "text", "input"])
def test_functions_are_those_of_the_values_that_they_had(change: str) -> None:
    m = bksim.loads(PENDULUM)
    if change == "number":
        m.compile()
        m.parameters["l"] = 0.7
        m.parameters["k"] = 3
    if change == "text":
        m.parameters["l"] = "70 cm"
    if change == "input":
        m.inputs["u"] = law
    f = m.compile()
    m.parameters["l"] = 9.0
    other = again(f)
    q, v = np.array([0.3]), np.array([-0.7])
    assert np.array_equal(other.accelerations(0.0, q, v), f.accelerations(0.0, q, v))
    assert np.array_equal(other.mass_matrix(q), f.mass_matrix(q))
    assert np.array_equal(again(other).forces(0.0, q, v), f.forces(0.0, q, v))


def test_a_model_comes_back_with_its_values_and_inputs() -> None:
    m = bksim.loads(PENDULUM)
    m.parameters["l"] = 0.7
    m.inputs["u"] = law
    other = again(m)
    same(m.solve(t_end=0.2), other.solve(t_end=0.2))
    assert again(m.equations).text == m.equations.text
    assert dict(again(m.parameters)) == dict(m.parameters)
    same(copy.deepcopy(m).solve(t_end=0.2), m.solve(t_end=0.2))


def test_expressions_come_back_as_the_same(tmp_path: Path) -> None:
    x, y = expr.symbols("x y")
    e = expr.sin(x) ** 2 / 3 + expr.atan2(y, x) * 0.1 + expr.parse("if(lt(x, 0), x^2, y)")
    assert again(e) == e and again([e, x])[1] == x
    deep = x
    for _ in range(100):
        # Written out, this has 2^100 symbols.
        deep = expr.cos(deep * deep + deep)
    assert again(deep) == deep and len(pickle.dumps(deep)) < 20_000
    f = expr.lambdify([x, y], [e, e.diff(x)])
    assert again(f)(0.3, 0.4) == f(0.3, 0.4)
    g = expr.lambdify([x], 2 * x)
    assert again(g)(3.0) == 6.0 and np.array_equal(again(g)(np.arange(3)), [0, 2, 4])


def test_faults_come_back_with_their_facts(tmp_path: Path) -> None:
    with pytest.raises(bksim.ModelError) as refused:
        bksim.loads("[bodies.b]\nmass = 'x'\n")
    other = again(refused.value)
    assert type(other) is bksim.ModelError and str(other) == str(refused.value)
    assert other.diagnostics == refused.value.diagnostics
    m = bksim.loads(PENDULUM.replace('value = "u"', 'value = "sqrt(0.5 - t/(1 s))*u"'))
    with pytest.raises(bksim.SolverError) as stopped:
        m.solve()
    other = again(stopped.value)
    assert type(other) is bksim.SolverError and (other.t, other.reason) == (
        stopped.value.t,
        stopped.value.reason,
    )
    same(stopped.value.result, other.result)
    assert other.result._run.fault == stopped.value.result._run.fault
    limit = again(bksim.LimitError("words", None))
    assert str(limit) == "words" and limit.result is None


def solved(length: float) -> tuple[bksim.Solution, bksim.Functions]:
    m = bksim.loads(PENDULUM)
    m.parameters["l"] = length
    return m.solve(t_end=0.2), m.compile()


def failing(_: float) -> bksim.Solution:
    return bksim.loads(PENDULUM.replace('value = "u"', 'value = "sqrt(0.5 - t/(1 s))*u"')).solve()


def test_a_pool_of_processes_returns_solutions_functions_and_faults() -> None:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        for length, (sol, f) in zip((0.4, 0.6), pool.map(solved, (0.4, 0.6)), strict=True):
            own, g = solved(length)
            same(own, sol)
            assert np.array_equal(f.mass_matrix([0.1]), g.mass_matrix([0.1]))
        with pytest.raises(bksim.SolverError, match="0.5"):
            pool.submit(failing, 0.0).result()
