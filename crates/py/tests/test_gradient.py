"""Gradients of one number of a motion, back along it: against the derivatives of the motion, and what is refused."""

from __future__ import annotations

import pickle
import signal
from pathlib import Path

import numpy as np
import pytest

import bksim
from bksim import _bksim

BY = ("l1", "m3", "A.rate")


@pytest.fixture(scope="module")
def sol() -> bksim.Solution:
    from conftest import EXAMPLES

    m = bksim.load(EXAMPLES / "slider-crank" / "model.toml")
    return m.solve(t_end=0.5, rtol=1e-10, atol=1e-12, sensitivity=BY)


def same(sol: bksim.Solution, weights: dict[str, np.ndarray], found: dict[str, float]) -> None:
    """Compares with the derivatives forward, relative to the parts of their sum."""
    for by in BY:
        parts = np.array([weights[name] * sol.sensitivity[by][name] for name in weights])
        size = np.abs(parts).sum()
        assert size > 0, by
        assert abs(found[by] - parts.sum()) <= 1e-6 * size, (by, found[by], parts.sum(), size)


def test_names_are_those_of_the_derivatives(sol: bksim.Solution) -> None:
    assert _bksim.weight_columns(sol._engine) == list(sol.sensitivity["l1"])


@pytest.mark.parametrize(
    "names",
    [
        ["x3"],
        ["theta1", "state.theta2_dot"],
        ["acceleration.x2_ddot", "theta1_ddot"],
        ["reactions.B.fx", "energy.kinetic"],
        ["rod.B.vx", "x3_dot"],
        ["crank.angle", "rod.ax", "rod.y"],
        ["x3", "theta1_dot", "theta2_ddot", "reactions.D.fy", "energy.power", "slider.x"],
    ],
)
def test_a_gradient_is_the_sum_of_weighted_derivatives(names: list[str], sol: bksim.Solution) -> None:
    numbers = np.random.default_rng(5)
    weights = {name: numbers.uniform(-1, 1, len(sol)) for name in names}
    # A number may depend on few of the samples.
    weights[names[0]][::3] = 0
    same(sol, weights, sol.gradient(weights, by=BY))


def test_multipliers_have_weights(sol: bksim.Solution) -> None:
    name = next(name for name in sol.names if name.startswith("multipliers."))
    weights = {name: np.linspace(1, 2, len(sol))}
    same(sol, weights, sol.gradient(weights, by=BY))


def test_two_names_of_one_quantity_add_up(sol: bksim.Solution) -> None:
    ones = np.ones(len(sol))
    both = sol.gradient({"x3": ones, "state.x3": 2 * ones}, by="l1")
    assert both == {"l1": pytest.approx(3 * sol.gradient({"x3": ones}, by="l1")["l1"], rel=1e-7)}


def test_all_that_has_a_derivative_is_differentiated_by(sol: bksim.Solution, examples: Path) -> None:
    weights = {"x3": np.ones(len(sol))}
    found = sol.gradient(weights)
    names = [name for name, _, _ in sol._engine.parameters()]
    assert list(found) == [*names, "A.angle", "A.rate"]
    few = sol.gradient(weights, by=("A.rate", "l1", "l1"))
    assert list(few) == ["A.rate", "l1"]
    assert few == pytest.approx({name: found[name] for name in few}, rel=1e-7)
    assert sol.gradient(weights, by=[]) == {}


def test_what_admits_no_other_value_is_left_out(examples: Path) -> None:
    text = (examples / "parallelogram" / "model.toml").read_text()
    # The third crank has a length of its own: it cannot change alone, nor can that of the others.
    text = text.replace('R = ["l", 0]', 'R = ["l3", 0]').replace("\nw = ", '\nl3 = "0.4 m"\nw = ')
    m = bksim.loads(text)
    sol = m.solve(t_end=0.1)
    weights = {m.coordinates[0]: np.ones(len(sol))}
    assert list(sol.gradient(weights)) == ["g", "w", "A.angle", "A.rate"]
    for name in ("l", "l3"):
        with pytest.raises(bksim.ModelError, match="no motion exists"):
            sol.gradient(weights, by=["g", name])


def test_what_is_no_weight_is_refused(sol: bksim.Solution) -> None:
    ones = np.ones(len(sol))
    with pytest.raises(KeyError, match="did you mean 'theta1_dot'"):
        sol.gradient({"theta1_dott": ones})
    with pytest.raises(KeyError, match="energy.work"):
        sol.gradient({"energy.work": ones})
    for wrong in (ones[1:], 1.0, ones[:, np.newaxis]):
        with pytest.raises(ValueError, match="weights of shape .* one for each of the 51 samples"):
            sol.gradient({"x3": wrong})
    with pytest.raises(ValueError, match="'x3' at sample 2 is nan"):
        sol.gradient({"x3": np.where(np.arange(len(sol)) == 2, np.nan, 1.0)})
    with pytest.raises(TypeError, match="array of numbers"):
        sol.gradient({"x3": ["one"] * len(sol)})
    with pytest.raises(TypeError, match="an array for each name"):
        sol.gradient(ones)  # type: ignore[arg-type]
    for by in ("nothing", "D.position"):
        with pytest.raises(bksim.ModelError, match="S012"):
            sol.gradient({"x3": ones}, by=by)


def test_a_motion_that_is_not_whole_has_no_gradient(sol: bksim.Solution, tmp_path: Path) -> None:
    m = bksim.load("""
[bodies.block]
mass = 1
[joints.S]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
coordinate = "x"
[loads.rub]
type = "force"
on = "block"
vector = ["-5 N*sign(S.velocity)", 0]
[initial]
S = { position = 0, velocity = 1 }
[solve]
t_end = 1
""")
    with pytest.raises(bksim.SolverError) as caught:
        m.solve()
    result = caught.value.result
    assert result is not None
    with pytest.raises(ValueError, match="ended early"):
        result.gradient({"x": np.ones(len(result))})
    whole = m.solve(t_end=0.1)
    # At the end of x = t − 5 t²/2.
    end = np.zeros(len(whole))
    end[-1] = 1
    assert whole.gradient({"x": end})["S.velocity"] == pytest.approx(0.1, rel=1e-8)

    sol.save(tmp_path / "run.mcap")
    for logged in (bksim.open(tmp_path / "run.mcap"), pickle.loads(pickle.dumps(sol))):
        with pytest.raises(bksim.LogError, match="comes from a log"):
            logged.gradient({"x3": np.ones(len(logged))})


def test_inputs_have_no_derivatives(examples: Path) -> None:
    m = bksim.load(examples / "cart-pole" / "model.toml")
    m.inputs["u"] = lambda t, q, v: -q[0]
    sol = m.solve(t_end=0.1)
    with pytest.raises(bksim.ModelError, match="inputs"):
        sol.gradient({"x": np.ones(len(sol))})


def test_ctrl_c_ends_it(examples: Path) -> None:
    sol = bksim.load(examples / "slider-crank" / "model.toml").solve(t_end=50.0, every=0.1)
    weights = {"x3": np.ones(len(sol))}
    signal.signal(signal.SIGALRM, lambda *_: signal.default_int_handler(signal.SIGINT, None))
    signal.setitimer(signal.ITIMER_REAL, 0.01)
    try:
        with pytest.raises(KeyboardInterrupt):
            sol.gradient(weights)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
    assert set(sol.gradient(weights, by="l1")) == {"l1"}
