"""Arrays by name, and the names of quantities."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Named(Mapping[str, Array]):
    """Arrays by name."""

    def __init__(self, arrays: dict[str, Array]) -> None:
        self._arrays = arrays

    def __getitem__(self, name: str) -> Array:
        if name not in self._arrays:
            raise KeyError(unknown(name, list(self._arrays)))
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        return f"<{', '.join(self._arrays) or 'nothing'}>"


def unknown(name: str, known: Sequence[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f"nothing is called {name!r}" + (f"; did you mean {near[0]!r}?" if near else "")


def resolved(name: str, rows: Mapping[str, int]) -> int | None:
    """The row of a quantity by its name, or by the last part of it where that is clear."""
    for topic in ("", "state.", "acceleration.", "multipliers.", "inputs.", "outputs.", "signals."):
        if topic + name in rows:
            return rows[topic + name]
    return None


def short_names(rows: Mapping[str, int]) -> list[str]:
    """The last parts of names that are clear."""
    ends = (name.split(".", 1)[-1] for name in rows)
    return [end for end in ends if resolved(end, rows) is not None]
