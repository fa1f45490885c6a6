"""The recipes of docs/python-recipes.md: those of what the tests ask for, and others where their packages are."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "python-recipes.md"
REQUIRED = re.findall(r"^([\w-]+)==", (ROOT / "tests" / "requirements.txt").read_text(), re.M)
"""Packages that are there wherever the tests run; NumPy comes with bksim."""
RECIPES = re.findall(r"^## (.*?)\n.*?```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.M)


@pytest.mark.parametrize(("title", "code"), RECIPES, ids=[title for title, _ in RECIPES])
@pytest.mark.filterwarnings("default")
def test_a_recipe_runs(title: str, code: str, examples: Path, tmp_path: Path) -> None:
    for package in re.findall(r"^(?:import|from) (\w+)", code, re.M):
        if package not in (*REQUIRED, "numpy", "bksim"):
            pytest.importorskip(package)
    (tmp_path / "examples").symlink_to(examples, target_is_directory=True)
    names: dict[str, Any] = {}
    exec(compile(code, title, "exec"), names)


def test_there_are_recipes() -> None:
    assert len(RECIPES) == 5
