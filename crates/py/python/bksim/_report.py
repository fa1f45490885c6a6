"""The numbers of a run."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from ._html import table
from ._said import said

Table = tuple[str, list[list[str]]]
"""A table with its name; the first row is its head."""


@dataclass(frozen=True)
class Report:
    """Limits, strokes, time ratios, largest velocities and accelerations, efforts, reactions, outputs, energies.

    ``values`` holds all numbers in SI, with the keys of ``bksim report --json``; ``report["reactions"]`` is one
    of its lists. Printed, or shown in a notebook, it is tables in the units that were asked for.
    """

    title: str
    values: dict[str, Any]
    tables: tuple[Table, ...]

    @classmethod
    def of(cls, title: str, values: str, tables: list[Table]) -> Report:
        """A report from an object of JSON and tables."""
        own = tuple((said(name), [[said(cell) for cell in rows[0]], *rows[1:]]) for name, rows in tables)
        return cls(title, json.loads(values), own)

    def __getitem__(self, key: str) -> Any:
        return self.values[key]

    def __str__(self) -> str:
        parts = [self.title]
        for name, rows in self.tables:
            widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
            lines = (
                "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
                for row in rows
            )
            parts.append("\n".join([name, *(f"  {line}".rstrip() for line in lines)]))
        return "\n\n".join(parts)

    def _repr_html_(self) -> str:
        parts = (f"<p>{name}</p>{table(rows[0], rows[1:])}" for name, rows in self.tables)
        return f"<b>{self.title}</b>" + "".join(parts)
