"""The examples of the README, one after the other as a reader would run them."""

import re
from pathlib import Path
from typing import Any

import numpy as np

import bksim


def test_the_readme_runs(examples: Path, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(examples, target_is_directory=True)
    text = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) >= 5
    names: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    assert {"film.gif", "run.mcap"} <= {file.name for file in tmp_path.iterdir()}
    sol = names["sol"]
    law = -40 * sol.q[0] - 5 * sol.v[0]
    np.testing.assert_allclose(sol.inputs["u"], law, atol=1e-9)


def test_the_spring_is_fitted_to_its_measurements(tmp_path: Path) -> None:
    page = Path(__file__).parents[3] / "docs" / "tasks" / "fit-a-spring.md"
    text = page.read_text(encoding="utf-8")
    (model,), (steps, many) = (
        re.findall(rf"```{kind}\n(.*?)```", text, re.DOTALL) for kind in ("toml", "python")
    )
    (tmp_path / "plate.toml").write_text(model, encoding="utf-8")
    sol = bksim.load("plate.toml", set={"k": "171.3 N/m", "c": "2.4 N s/m"}).solve(rtol=1e-9)
    rows = np.column_stack([sol.t, sol["x"]])
    np.savetxt("measured.csv", rows, delimiter=",", header="t,state.x", comments="", fmt="%.17g")
    names: dict[str, Any] = {}
    exec(compile(steps, page.name, "exec"), names)
    np.testing.assert_allclose(names["p"], [171.3, 2.4], rtol=1e-6)
    exec(compile(many, page.name, "exec"), names)
    np.testing.assert_allclose(names["start"] * names["best"].x, [171.3, 2.4], rtol=3e-6)
