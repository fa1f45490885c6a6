"""Tables of pandas, Polars, xarray and Arrow, out of the package and into it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bksim
from bksim._frames import columns_of

FORMS = ["to_pandas", "to_polars", "to_xarray", "to_arrow"]


@pytest.mark.parametrize("form", FORMS)
def test_samples_go_out_and_come_back(form: str) -> None:
    if form == "to_polars":
        pytest.importorskip("polars")
    sol = bksim.example("slider-crank").solve(t_end=0.2)
    columns = columns_of(getattr(sol, form)())
    assert columns is not None
    unit = lambda name: "" if form == "to_polars" else f" [{sol.unit(name)}]"  # noqa: E731
    assert np.array_equal(np.array(columns["t" + unit("t")]), sol.t)
    name = "state.theta1" if "state.theta1" in sol.names else sol.names[0]
    assert np.array_equal(np.array(columns[name + unit(name)]), sol[name])


def test_a_sweep_is_a_frame_of_polars() -> None:
    polars = pytest.importorskip("polars")
    s = bksim.sweep(bksim.example("slider-crank"), {"l1": [0.1, 0.12]}, t_end=0.05)
    frame: Any = s.to_polars()
    assert isinstance(frame, polars.DataFrame) and frame.height == 2
    assert frame["l1"].to_list() == [0.1, 0.12]
    output = s.outputs[0]
    assert np.array_equal(frame[output].to_numpy(), s[output])


@pytest.mark.parametrize("form", ["dict", "pandas", "polars"])
def test_a_fit_takes_frames(form: str) -> None:
    t = np.linspace(0, 2, 81)
    frame: Any = {"t [s]": t, "theta [rad]": 0.1 * np.cos(np.sqrt(9.81 / 0.5) * t)}
    if form != "dict":
        frame = pytest.importorskip(form).DataFrame(frame)
    p = bksim.Model("pendulum", parameters={"l": "0.6 m"})
    p.bodies["bob"] = bksim.Body(mass="1 kg", com=[0, "-l"])
    p.joints["A"] = bksim.Revolute("ground", "bob")
    p.loads["gravity"] = bksim.Gravity(acceleration=[0, "-9.81 m/s^2"])
    p.initial["A"] = {"angle": "0.1 rad"}
    found = bksim.fit(p, frame, vary=["l"], compare={"theta": "A.angle"})
    # The swing of 0.1 rad takes (1 + 0.1^2/16) times as long as the cosine says: l is smaller by twice that part.
    assert found["unknowns"][0]["estimate"] == pytest.approx(0.5 * (1 - 2 * 0.1**2 / 16), rel=1e-5)
