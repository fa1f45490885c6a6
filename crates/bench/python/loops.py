"""By how far loops are open while they move, in bksim and in MuJoCo, whose equalities are soft.

    python crates/bench/python/loops.py [--time 5]

One robot file serves both: bksim writes an example as MJCF, and reads it again. What acts is the weight.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import bksim
import mujoco
import numpy as np

EXAMPLES = ("four-bar", "spatial-four-bar")
FIXTURE = Path(__file__).parents[3] / "tests/fixtures/import/four_bar_connect.xml"
INSTANTS = 6


def robots() -> dict[str, str]:
    """Robot files with loops, by their names."""
    texts = {name: bksim.example(name).robot("mjcf") for name in EXAMPLES}
    return {**texts, FIXTURE.stem: FIXTURE.read_text("utf-8")}


def ours(text: str, times: np.ndarray) -> np.ndarray:
    """The largest condition of the loops at each time."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "robot.xml")
        file.write_text(text)
        model = bksim.import_model(file)
    model.options["t_end"] = times[-1]
    model.options["every"] = times[1] - times[0]
    run = model.solve()
    gaps = model.compile().constraints(run.t, run.q.T)
    return np.abs(gaps).max(axis=1)


def theirs(text: str, times: np.ndarray, step: float) -> np.ndarray:
    """The largest position error of the equalities at each time."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = step
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    found = []
    for t in times:
        while data.time < t - 0.5 * step:
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        equalities = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        found.append(np.abs(data.efc_pos[equalities]).max(initial=0.0))
    return np.array(found)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--time", type=float, default=5.0)
    t_end = arguments.parse_args().time
    times = np.linspace(0.0, t_end, INSTANTS)
    print("| loop | program |", " | ".join(f"{t:g} s" for t in times), "|")
    print("|---|---|" + "---:|" * INSTANTS)
    for name, text in robots().items():
        runs = {"bksim": ours(text, times)}
        runs |= {f"MuJoCo, {step * 1e3:g} ms": theirs(text, times, step) for step in (2e-3, 2e-4)}
        for program, gaps in runs.items():
            print(f"| {name} | {program} |", " | ".join(f"{gap:.1e}" for gap in gaps), "|")


if __name__ == "__main__":
    main()
