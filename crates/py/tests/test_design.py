"""Optima, fits, tolerances and synthesis through Python."""

from pathlib import Path

import numpy as np
import pytest

import bksim

BAR = """
[parameters]
a = "60 mm"
b = "170 mm"
c = "120 mm"
d = "180 mm"
[ground]
points = { A = [0, 0], D = ["d", 0] }
[bodies.crank]
points = { A = [0, 0], B = ["a", 0] }
[bodies.coupler]
points = { B = [0, 0], C = ["b", 0] }
[bodies.rocker]
points = { D = [0, 0], C = ["c", 0] }
[joints]
A = { type = "revolute", between = ["ground.A", "crank.A"] }
B = { type = "revolute", between = ["crank.B", "coupler.B"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker.D"] }
[initial]
A = { angle = "40 deg" }
D = { guess = { angle = "85 deg" } }
"""


def test_an_optimum_over_positions_is_a_model():
    found = bksim.optimize(
        BAR,
        maximize="a",
        vary={"a": ["10 mm", "65 mm"]},
        subject_to=["peak_to_peak(D.angle) <= 40 deg"],
        over="A.angle=0:360 deg:721",
    )
    a, b, c, d = found["quantities"][0]["after"], 0.17, 0.12, 0.18

    def at(r):
        return np.arccos((c * c + d * d - r * r) / (2 * c * d))

    assert abs(np.degrees(at(b + a) - at(b - a)) - 40) < 1e-3
    assert found["conditions"][0]["is_active"]
    assert found.model_text.replace(found["quantities"][0]["written"], "60 mm") == BAR


def test_an_optimum_is_resumed_from_its_answer():
    question = (
        '[optimize]\nminimize = "abs(peak_to_peak(D.angle) - 30 deg)"\n'
        'vary = { a = ["10 mm", "65 mm"] }\nover = "A.angle=0:360 deg:181"\n'
    )
    found = bksim.optimize(BAR + question)
    again = bksim.optimize(BAR + question, resume=found)
    assert again["after"] <= found["after"] * (1 + 1e-9)
    assert again["evaluations"] <= found["evaluations"]
    assert again["ends"][0]["quantities"]["a"] == pytest.approx(
        found["ends"][0]["quantities"]["a"], rel=1e-6
    )


def test_a_fit_takes_arrays():
    phi = np.linspace(0, 6, 40)
    x, y = 0.06 * np.cos(phi) - 0.18, 0.06 * np.sin(phi)
    far = np.hypot(x, y)
    psi = np.arctan2(y, x) - np.arccos((far**2 + 0.12**2 - 0.17**2) / (2 * far * 0.12))
    found = bksim.fit(
        BAR,
        {"phi [rad]": phi, "psi [rad]": psi},
        vary={"a": "55 mm", "b": "160 mm"},
        drive={"A.angle": "phi"},
        compare={"psi": "D.angle"},
    )
    estimates = {one["name"]: one["estimate"] for one in found["unknowns"]}
    assert abs(estimates["a"] - 0.06) < 1e-9
    assert abs(estimates["b"] - 0.17) < 1e-9


def test_degrees_without_a_unit_are_warned_of():
    phi = np.linspace(0, 6, 40)
    runs = {"phi [rad]": phi, "psi": 20 + 10 * np.cos(phi)}
    asked = {"vary": {"a": "55 mm"}, "drive": {"A.angle": "phi"}, "compare": {"psi": "D.angle"}}
    with pytest.warns(bksim.InputWarning, match="30 rad = 4.8 turns") as caught:
        bksim.fit(BAR, runs, **asked)
    assert caught[0].message.diagnostic.code == "M034"
    assert Path(caught[0].filename) == Path(__file__)


def test_tolerances_are_proved():
    found = bksim.tolerance(
        BAR, of="rocker.angle", limits={"a": "±0.1 mm", "c": "±0.15 mm"}, samples=500
    )
    band = found["poses"][0]["bands"][0]
    assert band["proved"]
    low, high = band["exact_interval"]
    assert low < band["sampled"][0] < band["sampled"][1] < high
    assert found.model_text is None


def test_linkages_are_models():
    found = bksim.synthesize("straight_line", length="200 mm")
    assert len(found.models) == 5
    for text in found.models.values():
        assert bksim.loads(text).solve(t_end=0.1).t[-1] == pytest.approx(0.1)


def test_faults_are_those_of_models():
    with pytest.raises(bksim.ModelError) as raised:
        bksim.optimize(BAR, minimize="a")
    assert raised.value.diagnostics[0].code == "O002"
