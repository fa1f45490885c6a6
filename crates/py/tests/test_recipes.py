"""The recipes of docs/python-recipes.md, each where its packages are installed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).parents[3] / "docs" / "python-recipes.md"
RECIPES = re.findall(r"^## (.*?)\n.*?```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.M)


@pytest.mark.parametrize(("title", "code"), RECIPES, ids=[title for title, _ in RECIPES])
@pytest.mark.filterwarnings("default")
def test_a_recipe_runs(title: str, code: str, examples: Path, tmp_path: Path) -> None:
    for package in re.findall(r"^(?:import|from) (\w+)", code, re.M):
        pytest.importorskip(package)
    (tmp_path / "examples").symlink_to(examples, target_is_directory=True)
    names: dict[str, Any] = {}
    exec(compile(code, title, "exec"), names)


def test_there_are_recipes() -> None:
    assert len(RECIPES) == 4
