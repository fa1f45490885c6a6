"""Small tables for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from ._said import said


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table under its head, in the language that is spoken, unless that is empty."""
    cells = "".join(f"<th>{escape(said(cell))}</th>" for cell in head)
    lines = [f"<tr>{cells}</tr>"] if head else []
    for row in rows:
        cells = "".join(f"<td style='text-align:left'>{escape(cell)}</td>" for cell in row)
        lines.append(f"<tr>{cells}</tr>")
    return f"<table>{''.join(lines)}</table>"
