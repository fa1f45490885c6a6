"""Words with numbers; small tables for terminals, as those of data frames: the first and the last rows, and what fits
the width."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ._said import said

WIDTH = 96
"""Characters of a line."""

SHOWN = (3, 2)
"""First and last rows."""


def counted(n: int, one: str, many: str) -> str:
    """So many things: ``1 body``, ``3 bodies``."""
    return said(f"{n} {one if n == 1 else many}")


def small_table(columns: Sequence[tuple[str, str, Any]]) -> str:
    """Columns by name, unit and values; those that find no room are counted."""
    n_rows = len(columns[0][2]) if columns else 0
    first, last = SHOWN
    rows = list(range(n_rows))
    is_cut = n_rows > first + last + 1
    if is_cut:
        rows = rows[:first] + rows[-last:]
    cells: list[list[str]] = []
    width = 0
    for name, unit, values in columns:
        column = [name, f"[{unit}]" if unit else "", *(_number(values[k]) for k in rows)]
        if is_cut:
            column.insert(2 + first, "…")
        room = max(map(len, column))
        if cells and width + 2 + room > WIDTH - 4:
            break
        width += 2 + room
        cells.append([text.rjust(room) for text in column])
    n_left = len(columns) - len(cells)
    lines = ["  ".join(line) + ("  …" if n_left else "") for line in zip(*cells, strict=True)]
    if n_left:
        lines.append(f"… and {counted(n_left, 'more column', 'more columns')}")
    return "\n".join(line.rstrip() for line in lines)


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
