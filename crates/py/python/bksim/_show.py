"""Plots, pictures and animations that a notebook shows."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from . import _bksim
from ._checked import path as checked_path

if TYPE_CHECKING:
    from ._samples import Samples

INSTANTS = 1201
"""Instants at which curves are drawn where the motion between samples is known."""


@dataclass(frozen=True, repr=False)
class Picture:
    """A drawing as SVG."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the SVG."""
        file = checked_path(path, [".svg"], "solution.render() draws PNG, GIF and MP4")
        file.write_text(self.svg, encoding="utf-8")

    def __repr__(self) -> str:
        return f"<bksim.Picture: {len(self.svg)} characters of SVG>"


@dataclass(frozen=True, repr=False)
class Plot:
    """Curves; ``save`` writes SVG, PNG or PDF."""

    title: str
    panels: list[tuple[str, str, list[tuple[str, Any, Any]]]]
    x: tuple[str, str]
    dark: bool

    @classmethod
    def of(
        cls,
        solution: Samples,
        samples: Samples,
        names: Sequence[str],
        x: str | None,
        title: str,
        dark: bool,
    ) -> Plot:
        """Curves of a solution, drawn through ``samples`` of its motion; see ``Solution.plot``."""
        across = samples.t if x is None else samples[x]
        shown: list[tuple[str, str, list[tuple[str, Any, Any]]]] = []
        for what, unit, quantities in _named(solution, names) if names else _overview(solution):
            curves = []
            for name, channels in quantities:
                # What only samples know is drawn through those.
                is_dense = channels[0] in samples and np.isfinite(samples[channels[0]]).any()
                of = samples if is_dense else solution
                along = across if of is samples else (of.t if x is None else of[x])
                parts = [of[channel] for channel in channels]
                curves.append((name, along, parts[0] if len(parts) == 1 else np.hypot.reduce(parts)))
            shown.append((curves[0][0] if len(curves) == 1 else what, unit, curves))
        axis = ("Time", "s") if x is None else (x, solution.unit(x))
        return cls(title, shown, axis, dark)

    def _drawn(self, format: str) -> bytes:
        return _bksim.figure(self.title, self.panels, self.x, format, self.dark)

    def _repr_svg_(self) -> str:
        return self._drawn("svg").decode()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a picture; the ending of its name chooses SVG, PNG or PDF."""
        file = checked_path(path, [".svg", ".png", ".pdf"], "these are the pictures there are")
        file.write_bytes(self._drawn(file.suffix.lstrip(".").lower()))

    def __repr__(self) -> str:
        n = sum(len(curves) for _, _, curves in self.panels)
        return f"<bksim.Plot {self.title!r}: {n} curves in {len(self.panels)} panels>"


_Panels: TypeAlias = "list[tuple[str, str, list[tuple[str, list[str]]]]]"
"""What is shown, its unit, and of each curve its name and the quantities that it is the size of."""


def _named(solution: Samples, names: Sequence[str]) -> _Panels:
    """Those of one unit together."""
    panels: dict[str, list[tuple[str, list[str]]]] = {}
    for name in names:
        panels.setdefault(solution.unit(name), []).append((name, [name]))
    return [(_bksim.unit_word(unit), unit, quantities) for unit, quantities in panels.items()]


def _overview(solution: Samples) -> _Panels:
    """What ``bksim plot`` shows."""
    panels = _bksim.overview([(name, solution.unit(name)) for name in solution.names])
    # The names of one panel are of one topic.
    return [
        (what, unit, [(name.split(".", 1)[1], channels) for name, channels in quantities])
        for what, unit, quantities in panels
    ]


@dataclass(frozen=True, repr=False)
class Animation:
    """A page with the moving mechanism; a notebook shows it inline."""

    html: str
    height: int

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe srcdoc="{escape(self.html)}" style="{style}"></iframe>'

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page, which any browser opens without a network."""
        file = checked_path(path, [".html", ".htm"], "solution.render() makes films")
        file.write_text(self.html, encoding="utf-8")

    def __repr__(self) -> str:
        return f"<bksim.Animation: {len(self.html)} characters of HTML>"
