"""The examples of the README, one after the other as a reader would run them."""

import re
from pathlib import Path
from typing import Any

import numpy as np


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
