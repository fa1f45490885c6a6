"""Events, units at the assignment: what a program of SciPy's users expects."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import bksim

THROW = """
[bodies.ball]
mass = "1 kg"
[joints.guide]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
coordinate = "y"
[loads.gravity]
type = "gravity"
acceleration = [0, "-10 m/s^2"]
[initial]
guide = { position = "1 m", velocity = "5 m/s" }
[solve]
t_end = "2 s"
"""


def top(t: float, q: np.ndarray, v: np.ndarray) -> float:
    return float(v[0])


def test_zeros_of_functions_and_quantities_are_located() -> None:
    sol = bksim.loads(THROW).solve(events=[top, "ball.y", "y"])
    ground = (5 + np.sqrt(45)) / 10
    for found, expected in zip(sol.t_events, ([0.5], [ground], [ground]), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9)
    assert sol.success and sol.t[-1] == 2.0
    np.testing.assert_allclose(sol.y_events[0], [[2.25, 0.0]], atol=1e-8)
    assert sol.y_events[1].shape == (1, 2)
    assert np.array_equal(pickle.loads(pickle.dumps(sol)).t_events[1], sol.t_events[1])
    assert bksim.loads(THROW).solve().t_events == []


def test_a_terminal_event_ends_the_motion_and_a_direction_is_kept() -> None:
    def ground(t: float, q: np.ndarray, v: np.ndarray) -> float:
        return float(q[0])

    def height(t: float, q: np.ndarray, v: np.ndarray) -> float:
        return float(q[0]) - 2.0

    ground.terminal = True  # type: ignore[attr-defined]
    height.direction = -1  # type: ignore[attr-defined]
    sol = bksim.loads(THROW).solve(events=(ground, height))
    end = (5 + np.sqrt(45)) / 10
    assert sol.t[-1] == pytest.approx(end, abs=1e-9) and sol["y"][-1] == pytest.approx(0, abs=1e-8)
    np.testing.assert_allclose(sol.t_events[1], [(5 + np.sqrt(5)) / 10], atol=1e-9)
    height.direction = 1  # type: ignore[attr-defined]
    height.terminal = True  # type: ignore[attr-defined]
    sol = bksim.loads(THROW).solve(events=(ground, height))
    assert sol.t[-1] == pytest.approx((5 - np.sqrt(5)) / 10, abs=1e-9) and len(sol.t_events[0]) == 0
    with pytest.raises(ValueError, match="dense=False"):
        bksim.loads(THROW).solve(events=ground, dense=False)


def test_a_text_of_another_kind_is_refused_where_it_is_set(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "model.toml")
    before = dict(m.parameters)
    for name, value, code in [
        ("l1", "3 kg", "M031"),
        ("l1", "3 mm2x", "M030"),
        ("l1", "2*l9", "M021"),
        ("q1", "3 N", "M031"),
        ("l1", "2*", "M020"),
    ]:
        with pytest.raises(bksim.ModelError, match=code) as refused:
            m.parameters[name] = value
        assert str(refused.value).startswith(f"{name} = {value!r}: ")
    assert dict(m.parameters) == before
    m.parameters["l1"] = "80 cm"
    assert m.parameters["l1"] == 0.8
    # A value that no mechanism may have is refused when all are set.
    m.parameters["m1"] = "-1 kg"
    with pytest.raises(bksim.ModelError, match="M040"):
        m.solve()
    m.parameters["m1"] = "2 kg"
    assert m.solve(t_end=0.1).success
