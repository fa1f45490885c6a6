"""A program as type checkers see it: each wrong line is marked as such (run by mypy, not by pytest)."""

from __future__ import annotations

from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import bksim

Array = NDArray[np.float64]


def law(t: float, q: Array, v: Array) -> float:
    return float(-q[0])


def program(m: bksim.Model) -> None:
    m.parameters["l1"] = "12 cm"
    m.bodies["b"] = bksim.Body(mass="2 kg", com=np.array([0.0, 1.0]))
    m.joints["A"] = bksim.Revolute("ground", "b")
    m.inputs["u"] = law
    sol = m.solve(t_end=1, sensitivity=["l1"], method="radau")
    assert_type(sol["theta"], Array)
    assert_type(sol.sensitivity["l1"].q, Array)
    assert_type(sol.sensitivity["l1"]["reactions.A.fx"], Array)
    assert_type(sol.gradient({"theta": sol.t}, by=["l1"]), dict[str, float])
    f = m.compile()
    assert_type(f.measure(["b.x"], sol.q.T), Array)
    assert_type(f.derivatives("forces", 0.0, sol.q[:, 0], by="q"), dict[str, Array])
    f.derivatives(["b.x", "energy.total"], 0.0, sol.q[:, 0])


def wrong(m: bksim.Model) -> None:
    m.solve(method="rk4")  # type: ignore[arg-type]
    m.solve(formulation="index4")  # type: ignore[arg-type]
    bksim.sweep(m, {"l1": [1.0]}, design="lhs")  # type: ignore[arg-type]
    bksim.load("x.toml", jit="yes")  # type: ignore[arg-type]
    bksim.Revolute("ground")  # type: ignore[call-arg]
    bksim.expr.symbol("x").written("html")  # type: ignore[arg-type]
