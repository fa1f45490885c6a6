"""From the text of a model to its equations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from . import _bksim
from ._assigned import Value
from ._values import Law
from ._words import Jit


def read(
    source: tuple[str, Path, str],
    overrides: list[tuple[str, str]],
    jit: Jit | None,
    inputs: Mapping[str, Law] | None = None,
    varied: Iterable[str] = (),
    is_built: bool = False,
) -> _bksim.Engine:
    """Derives the equations of a text; ``varied`` are the overrides that may take other numbers, and a model that
    ``is_built`` in code has no file with these lines."""
    text, path, name = source
    return _bksim.Engine.read(
        {
            "text": text,
            "path": path,
            "is_built": is_built,
            "name": name,
            "overrides": overrides,
            "jit": jit,
            "inputs": list((inputs or {}).items()),
            "varied": list(varied),
            "compliance": [],
        }
    )


def text_of(value: Value) -> str:
    """A value as it stands in a model."""
    return value if isinstance(value, str) else repr(float(value))
