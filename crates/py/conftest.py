"""What tests and the examples in docstrings share."""

import signal
from pathlib import Path

import pytest

# What a shell runs in the background ignores what Ctrl-C sends, and is not to do so here.
signal.signal(signal.SIGINT, signal.default_int_handler)

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Examples in docstrings write files. They know no names but those that they import.
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def examples() -> Path:
    """The models of the examples."""
    return EXAMPLES


@pytest.fixture(params=sorted(path.parent.name for path in EXAMPLES.glob("*/model.toml")))
def example(request: pytest.FixtureRequest) -> Path:
    """The model of each example."""
    return EXAMPLES / str(request.param) / "model.toml"
