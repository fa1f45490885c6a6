"""What is given to calls, with plain words for what is something else."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any


def real(option: str, value: Any) -> float | None:
    """A number, or None."""
    if value is None:
        return None
    try:
        if isinstance(value, (str, bytes)):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{option} = {value!r}: give a number") from None


def whole(option: str, value: Any) -> int:
    """A whole number, not below zero."""
    try:
        number = operator.index(value)
    except TypeError:
        if not (isinstance(value, float) and value.is_integer()):
            raise TypeError(f"{option} = {value!r}: give a whole number") from None
        number = int(value)
    if number < 0:
        raise ValueError(f"{option} = {value!r}: give a number from 0 on")
    return number


def names(option: str, value: str | Iterable[str] | None) -> list[str]:
    """Names; one may stand by itself."""
    found = [value] if isinstance(value, str) else list(value or ())
    for name in found:
        if not isinstance(name, str):
            raise TypeError(f"{option} has {name!r} in it: give names as texts")
    return found


def pairs(values: Mapping[str, str | Sequence[str]] | None) -> list[tuple[str, str]]:
    """Names with values as texts; a name may have several."""
    each = ((name, [value] if isinstance(value, str) else value) for name, value in (values or {}).items())
    return [(str(name), str(value)) for name, all in each for value in all]


def path(name: str | os.PathLike[str], endings: Sequence[str], instead: str) -> Path:
    """A file to be written, whose name ends as what is written into it."""
    file = Path(name).expanduser()
    if file.suffix.lower() not in endings:
        raise ValueError(f"{file.name}: the name must end in {' or '.join(endings)}; {instead}")
    return file
