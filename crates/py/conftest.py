"""What tests and the examples in docstrings share."""

import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bksim

# What a shell runs in the background ignores what Ctrl-C sends, and is not to do so here.
signal.signal(signal.SIGINT, signal.default_int_handler)

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(autouse=True)
def _names(
    doctest_namespace: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Examples in docstrings write files.
    monkeypatch.chdir(tmp_path)
    doctest_namespace.update({name: getattr(bksim, name) for name in bksim.__all__})
    doctest_namespace.update(EXAMPLES=EXAMPLES, np=np)


@pytest.fixture
def examples() -> Path:
    """The models of the examples."""
    return EXAMPLES


@pytest.fixture(params=sorted(path.parent.name for path in EXAMPLES.glob("*/model.toml")))
def example(request: pytest.FixtureRequest) -> Path:
    """The model of each example."""
    return EXAMPLES / str(request.param) / "model.toml"
