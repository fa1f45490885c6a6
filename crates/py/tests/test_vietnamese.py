"""Tables, summaries and answers in Vietnamese: no text of the package lacks its row in the catalogue."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import bksim
from bksim import _bksim


@pytest.fixture(autouse=True)
def vietnamese() -> Iterator[None]:
    bksim.speak("vi_VN.UTF-8")
    yield
    bksim.speak("en")


def texts() -> Iterator[tuple[str, str]]:
    """Literals that the package passes to `said`, `counted` and heads of `table`, with their files."""
    for path in sorted(Path(bksim.__file__).parent.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
                continue
            literals = [of.value for of in ast.walk(node) if isinstance(of, ast.Constant) and isinstance(of.value, str)]
            if node.func.id == "said" and isinstance(node.args[0], ast.Constant):
                yield path.name, node.args[0].value
            elif node.func.id == "counted" and path.name != "_facts.py":
                yield from ((path.name, f"3 {text}") for text in literals[-2:])
            elif node.func.id == "counted":
                yield path.name, literals[0]
            elif node.func.id == "table" and isinstance(node.args[0], ast.List):
                heads = node.args[0].elts
                yield from ((path.name, of.value) for of in heads if isinstance(of, ast.Constant))


def test_every_text_is_translated() -> None:
    found = list(texts())
    assert len(found) > 40
    same = {text for _, text in found if _bksim.said(text) == text}
    assert not same, f"docs/vi/answers.toml lacks {sorted(same)}"


def test_answers_and_summaries_are_in_vietnamese() -> None:
    m = bksim.example("slider-crank")
    assert "tọa độ" in repr(m) and "các khớp" in str(m.check())
    sol = m.solve(t_end=0.1)
    assert "mẫu, từ 0 s đến 0.1 s" in repr(sol)
    assert "Phản lực" in str(sol.report()) or "phản lực" in str(sol.report())
    answer = m.doctor()
    told = str(answer)
    bksim.speak("en")
    assert str(m.doctor()) != told and m.doctor().facts == answer.facts
    assert repr(sol).startswith("<bksim.Solution 'slider-crank'") and " s to 0.1 s" in repr(sol)
