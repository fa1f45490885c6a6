"""Values of parts, looked at where they are set: a text of a wrong unit is refused there."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, ClassVar, Union

import numpy as np
from numpy.typing import NDArray

from . import _bksim
from ._errors import ModelError

Value = Union[float, str]
"""A number, a quantity or an expression."""

Point = Union[Sequence[Value], NDArray[np.float64]]
"""``[x, y]`` or ``[x, y, z]``, length."""

# Unknown units, other dimensions, sums of different ones. What else is wrong may become right by other parts.
OF_UNITS = ("M030", "M031", "M032")

_is_trusted: ContextVar[bool] = ContextVar("_is_trusted", default=False)


@contextmanager
def trusted() -> Iterator[None]:
    """Parts that are made within are not looked at: they come from a text that was read."""
    token = _is_trusted.set(True)
    try:
        yield
    finally:
        _is_trusted.reset(token)


class Part:
    """A part of a model: a text of a wrong unit is refused where it is set."""

    __slots__ = ()
    _section: ClassVar[str]

    def __setattr__(self, name: str, value: Any) -> None:
        table: dict[str, Any] = {name.rstrip("_"): plain(value)}
        if kind := getattr(type(self), "type", None):
            table["type"] = kind
        refuse_units(type(self).__name__, name, value, {self._section: {"part": table}})
        object.__setattr__(self, name, value)

    def __setstate__(self, state: tuple[Any, Mapping[str, Any]]) -> None:
        # A copy, or what comes out of a pickle, was looked at before.
        for name, value in state[1].items():
            object.__setattr__(self, name, value)


def plain(value: Any) -> Any:
    """A value as JSON has it: NumPy's numbers and arrays become Python's."""
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(item) for item in value]
    return value


def refuse_units(owner: str, key: str, value: Any, tables: Mapping[str, Any]) -> None:
    """Raises ModelError where ``tables``, a model of nothing but this value, has a fault of units."""
    if _is_trusted.get() or not _has_units(value):
        return
    try:
        text = _bksim.to_toml(json.dumps(tables, allow_nan=False))
        _bksim.check_values(text, Path("part.toml"), "part", [])
    except ModelError as refused:
        faults = tuple(fault for fault in refused.diagnostics if fault.code in OF_UNITS)
        if faults:
            first = faults[0]
            reason = first.message.rpartition("`: ")[2] if "`: " in first.message else first.message
            way_out = f" ({first.help})" if first.help else ""
            words = f"{owner}.{key} = {value!r}: {reason} [{first.code}]{way_out}"
            raise ModelError(words, faults) from None
    except (TypeError, ValueError):
        return  # what cannot be written down is refused with the whole model


def _has_units(value: Any) -> bool:
    """True where a text with a digit and a letter is somewhere in it."""
    if isinstance(value, str):
        return any(c.isdigit() for c in value) and any(c.isalpha() for c in value)
    if isinstance(value, Mapping):
        return any(_has_units(item) for item in value.values())
    return isinstance(value, Sequence) and any(_has_units(item) for item in value)
