"""Motions: arrays by name, the motion between samples, tables, logs and pictures."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _bksim
from ._checked import names as checked_names
from ._checked import path as checked_path
from ._checked import real, whole
from ._errors import Diagnostic, LogError, diagnostics_of
from ._functions import Functions
from ._gradient import gradient
from ._named import Array, Named, resolved, unknown
from ._progress import Progress
from ._report import Report
from ._said import said
from ._samples import Samples
from ._show import INSTANTS, Animation, Picture, Plot
from ._text import counted


def open(path: str | os.PathLike[str]) -> Solution:
    """Opens a log, also one that was cut short. Raises LogError when it is none."""
    file = Path(path).expanduser()
    file.stat()
    return Solution(_bksim.open_log(file))


def _carried(path: Path, log: bytes, facts: _bksim._Facts, t_events: list[Array]) -> Solution:
    """The solution whose log was carried here."""
    solution = Solution(_bksim.carried_run(path, log, facts))
    solution.t_events = t_events
    return solution


class Sensitivity(Named):
    """Derivatives of the motion by one quantity, (n,) by the name of what is differentiated.

    Iteration is over coordinates, rates, accelerations, multipliers, energies, reactions, signals and points. Anything
    else that a solution has by a name
    and that follows from the state has its derivative, too: ``["reactions.A.fx"]``, ``["energy.total"]``,
    ``["rod.B.vx"]``.
    """

    def __init__(
        self, arrays: dict[str, Array], table: Array, sizes: tuple[int, int], by: str, of: Solution
    ) -> None:
        super().__init__(arrays)
        self._table = table
        self._nq, self._nc = sizes
        self._by = by
        self._of = of
        self._made: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        if name in self._arrays:
            return self._arrays[name]
        row = resolved(name, {f"state.{known}": k for k, known in enumerate(self._arrays)})
        topic, _, field = name.partition(".")
        if row is None and topic in ("state", "acceleration", "multipliers") and field in self._arrays:
            return self._arrays[field]
        if name not in self._made:
            self._made[name] = self._derivative(name)
        return self._made[name]

    def _derivative(self, name: str) -> Array:
        """Along the change of the state: y_q ∂q + y_v ∂v + y_p."""
        of = self._of
        if name not in of:
            raise KeyError(unknown(name, [*self._arrays, *of.names]))
        functions = of._functions
        by_parameter = [self._by] if self._by in of._parameters else []
        changes = functions.derivatives([name], of.t, of.q.T, of.v.T, by=["q", "v", *by_parameter])
        total: Array = np.einsum("kn,nk->k", changes["q"][:, 0], self.q)
        total += np.einsum("kn,nk->k", changes["v"][:, 0], self.v)
        for parameter in by_parameter:
            total += changes[parameter][:, 0]
        total.flags.writeable = False
        return total

    @property
    def q(self) -> Array:
        """Of the coordinates, (nq, n)."""
        return self._table[: self._nq]

    @property
    def v(self) -> Array:
        """Of their rates, (nq, n)."""
        return self._table[self._nq : 2 * self._nq]

    @property
    def a(self) -> Array:
        """Of their accelerations, (nq, n)."""
        return self._table[2 * self._nq : 3 * self._nq]

    @property
    def lam(self) -> Array:
        """Of the multipliers, (nc, n)."""
        return self._table[3 * self._nq : 3 * self._nq + self._nc]


class Solution(Samples):
    """The motion of a mechanism: its samples, and by calling it, the motion at any other instant.

    >>> import bksim
    >>> import numpy as np
    >>> sol = bksim.example("four-bar").solve(t_end=0.2)
    >>> sol(0.1)["crank.angle"].shape
    ()
    >>> sol(np.linspace(0, 0.2, 7)).q.shape[1]
    7
    """

    def __init__(self, run: _bksim.Run) -> None:
        super().__init__(run.engine, run.t, run.table, run)
        self._run = run
        self.t_events: list[Array] = []
        """Instants of each event that ``solve`` was asked for, s."""

    @property
    def y_events(self) -> list[Array]:
        """The states there, (n, 2 nq): coordinates, then their rates."""

        def states(at: Array) -> Array:
            samples = self(at)
            return np.concatenate([samples.q, samples.v]).T

        return [states(at) for at in self.t_events]

    def __reduce__(self) -> tuple[Any, ...]:
        # By the log, as it is saved and opened; besides, what a log says in other words.
        run = self._run
        facts: _bksim._Facts = {
            "ending": run.ending,
            "fault": run.fault,
            "warnings": run.warnings,
            "summary": run.summary(),
        }
        return _carried, (self._engine.path, _bksim.log_bytes(run), facts, self.t_events)

    def __copy__(self) -> Solution:
        return self

    def __deepcopy__(self, memo: Any) -> Solution:
        return self

    @cached_property
    def _functions(self) -> Functions:
        return Functions(_bksim.compiled_functions(self._engine))

    @cached_property
    def _parameters(self) -> set[str]:
        return {name for name, _, _ in self._engine.parameters()}

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """How much less the results are worth than the tolerances promise, and why the run was slow."""
        return diagnostics_of(self._run.warnings)

    @property
    def span(self) -> tuple[float, float]:
        """First and last instant, s."""
        return float(self._t[0]), float(self._t[-1])

    def __call__(self, t: ArrayLike) -> Samples:
        """The motion at any instants within the span, from the integrator's own polynomials.

        Quantities that only samples have (work, counters) are NaN. Raises ValueError outside of the
        span, and when the run was solved with ``dense=False``.
        """
        span = self._needs_motion()
        times = np.asarray(t, dtype=np.float64)
        if times.ndim > 1:
            raise ValueError(f"instants of shape {times.shape}: one axis at most")
        low, high = min(span), max(span)
        # A sum of steps may miss an end by its last digits.
        slack = 1e-12 * max(abs(low), abs(high))
        times = np.where((times < low) & (times >= low - slack), low, times)
        times = np.where((times > high) & (times <= high + slack), high, times)
        wrong = ~((times >= low) & (times <= high))
        if np.any(wrong):
            first = np.atleast_1d(times)[np.atleast_1d(wrong)][0]
            raise ValueError(f"t = {first!r} s is outside of the motion, {low!r} s to {high!r} s")
        flat = np.ascontiguousarray(np.atleast_1d(times))
        table = self._run.at(flat)
        return Samples(self._engine, flat, table, self._run, is_one=times.ndim == 0)

    @property
    def sensitivity(self) -> Mapping[str, Sensitivity]:
        """Derivatives of the motion by what ``solve`` was asked for, in the unit of each over that of the
        quantity.

        >>> import bksim
        >>> m = bksim.example("four-bar")
        >>> sol = m.solve(t_end=0.1, sensitivity="a")
        >>> sol.sensitivity["a"].q.shape == sol.q.shape
        True
        """
        nq = len(self.q)
        blocks: dict[str, list[int]] = {}
        for k, (name, _, meaning) in enumerate(self._columns):
            if name.startswith("sensitivity."):
                blocks.setdefault(meaning.removeprefix("derivative by "), []).append(k)

        def one(by: str, block: list[int]) -> Sensitivity:
            table = self._table[block[0] : block[-1] + 1]
            names = [self._columns[k][0].removeprefix(f"sensitivity.{by}.") for k in block]
            return Sensitivity(dict(zip(names, table, strict=True)), table, (nq, len(self.lam)), by, self)

        return {by: one(by, block) for by, block in blocks.items()}

    def gradient(
        self, weights: Mapping[str, ArrayLike], by: str | Sequence[str] | None = None
    ) -> dict[str, float]:
        """Derivatives of one number J of the motion by parameters and stated initial values, in SI: J may depend on
        many quantities at many instants.

        ``weights`` are the derivatives of J by these: by name, an array with one for each sample. The names are
        those of a :class:`Sensitivity`. ``by`` names what J is differentiated by; unless given, all parameters and
        stated initial values that have a derivative.

        The motion is run again as it was, and back along it by the adjoint method, which takes as long for many
        parameters as for one. A fit to measurements, by the sum of squares J = Σ r²/2, has its residuals as weights:

        >>> import bksim
        >>> import numpy as np
        >>> m = bksim.example("slider-crank")
        >>> sol = m.solve(t_end=0.2, sensitivity="l1")
        >>> data = np.full(len(sol), 3.95)
        >>> r = sol["x3"] - data
        >>> J = r @ r / 2
        >>> g = sol.gradient({"x3": r})
        >>> set(m.parameters) <= set(g), bool(np.isclose(g["l1"], r @ sol.sensitivity["l1"]["x3"]))
        (True, True)

        The interpreter lock is released, and Ctrl-C ends it. Raises KeyError for unknown names of quantities;
        ValueError for weights that are not one finite number for each sample, and for a motion that ended early;
        LogError for one that comes from a log; ModelError as :meth:`Model.solve` does with ``sensitivity``, and
        SolverError where the motion has no derivatives.
        """
        return gradient(self, self._run, self._functions, weights, by)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """How the run went: end, methods, events, steps, residuals, energy balance; of a log also its
        notes. A log that was cut short tells no more than its notes and
        which reactions are unique."""
        summary: dict[str, Any] = json.loads(self._run.summary())
        return summary

    @property
    def not_unique(self) -> list[tuple[float, tuple[str, ...]]]:
        """From when on which signals are not unique, by the names of the table: ``[(0.0, ("reactions.A.fx",
        …)), …]``. Joints, drives or stops that repeat each other share these reactions and efforts: the
        table has one of many solutions of the equilibrium. A log that was cut short tells it up to the
        cut."""
        changes = self.summary["uniqueness"]
        return [(change["t"], tuple(change["not_unique"])) for change in changes]

    @property
    def success(self) -> bool:
        """Whether the end time was reached."""
        return self._run.ending == "reached"

    @property
    def events(self) -> list[dict[str, Any]]:
        """What switched: stops that were hit, friction that held, kinks. Raises LogError for a log
        that does not tell, as one that was cut short."""
        if "events" not in self.summary:
            why = ": it was cut short" if self.summary["end"] is None else ""
            raise LogError(f"the log does not tell what switched{why}")
        return list(self.summary["events"])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the log, as ``bksim solve`` does; :func:`bksim.open` reads it."""
        file = checked_path(path, [".mcap"], "to_pandas() and to_arrow() write tables")
        if self._run.is_logged:
            if file.resolve() != self._engine.path.resolve():
                shutil.copyfile(self._engine.path, file)
            return
        _bksim.save_log(self._run, file)

    def report(self, units: str | None = None) -> Report:
        """The numbers of the run: limits, strokes, time ratios, largest velocities, efforts, reactions,
        outputs and energies, in the units of the model or in others such as ``"mm, deg, rpm"``."""
        self._needs_motion()
        return Report.of(self._title(), *_bksim.report(self._run, units))

    def plot(
        self, *names: str, x: str | None = None, title: str | None = None, dark: bool = False
    ) -> Plot:
        """Curves of quantities over time, or over ``x``; those of one unit share a panel. Without
        names: coordinates, rates, energies, and efforts of drives or sizes of reactions."""
        samples: Samples = self
        if self._run.span() is not None and len(self) < INSTANTS:
            samples = self(np.linspace(*self.span, INSTANTS))
        return Plot.of(self, samples, names, x, title or self._engine.name, dark)

    def picture(self, t: float | None = None, *, dark: bool = False) -> Picture:
        """The mechanism at an instant, the middle of the motion unless given."""
        if t is not None:
            self(float(t))
        at = sum(self.span) / 2 if t is None else float(t)
        self._needs_motion()
        return Picture(_bksim.picture(self._run, at, dark))

    def render(
        self,
        path: str | os.PathLike[str],
        *,
        at: float | None = None,
        span: tuple[float, float] | None = None,
        fps: float | None = None,
        speed: float | None = None,
        size: tuple[int, int] | None = None,
        density: float | None = None,
        view: tuple[float, float] | str | None = None,
        section: str | None = None,
        background: str = "light",
        labels: bool = False,
        title: str | None = None,
        time: bool = False,
        caption: str | None = None,
        trails: str | Sequence[str] = (),
        arrows: str | Sequence[str] = (),
        ghosts: int = 0,
        past: float | None = None,
        progress: bool | None = None,
    ) -> None:
        """Writes a film (``.mp4``, ``.gif``, ``.apng``) or a picture (``.png``, ``.svg``), as
        ``bksim render`` does.

        A picture shows the instant ``at``, s, the middle of the motion unless given; a film shows
        ``span``, or the whole motion, with ``fps`` frames a second, each second of film being ``speed``
        seconds of motion. ``size`` is in pixels, of which a point has ``density``: else the mechanism
        chooses the shape. ``view`` is where a spatial mechanism is seen from: ``"front"``,
        ``"right"``, ``"top"``, ``"isometric"``, or azimuth and elevation in degrees. ``section`` cuts it by a plane:
        ``"x = 20 mm"`` leaves out the side nearer to the eye, ``"x < 20 mm"`` and ``"x > 20 mm"`` keep one; a plane
        with any normal is ``"[1, 1, 0] = [10, 0, 5] mm"``. ``background`` is ``"light"``, ``"dark"``,
        ``"transparent"`` or a colour such as ``"#fff8e7"``.

        ``trails`` names joints, points (``"crank.P"``) and bodies, for their centres of mass; ``arrows`` are
        ``"reactions"``, ``"velocities"`` and ``"forces"``; ``ghosts`` are drawn faintly at as many earlier
        instants. Both reach back ``past`` seconds, or to the start. ``title`` is written in the upper left corner, with
        ``time`` the instant below it, and ``caption`` below the mechanism.

        The interpreter lock is released; Ctrl-C ends it, and nothing is written. Raises bksim.Error where
        there is no graphics adapter, not even a software one, which ``.svg`` alone does without.

        >>> import bksim
        >>> sol = bksim.example("four-bar").solve(t_end=0.2)
        >>> sol.render("four-bar.svg", at=0.1, labels=True, arrows="velocities")
        """
        first, last = self._needs_motion()
        endings = [".mp4", ".gif", ".apng", ".png", ".svg"]
        file = checked_path(path, endings, "those are films and pictures")
        begin, end = (first, last) if span is None else span
        with Progress.over(begin, end, progress if file.suffix.lower() in endings[:3] else False) as notify:
            wanted: _bksim._Drawn = {
                "at": real("at", at),
                "span": span,
                "fps": real("fps", fps),
                "speed": real("speed", speed),
                "size": size,
                "density": real("density", density),
                "view": view,
                "section": section,
                "background": background,
                "labels": labels,
                "title": title,
                "time": time,
                "caption": caption,
                "trails": checked_names("trails", trails),
                "arrows": checked_names("arrows", arrows),
                "ghosts": whole("ghosts", ghosts),
                "past": real("past", past),
                "notify": notify,
            }
            _bksim.render(self._run, file, wanted)

    def animate(self, *, title: str | None = None, height: int = 640) -> Animation:
        """The moving mechanism with curves and equations, in a notebook or as a page of its own."""
        self._needs_motion()
        return Animation(_bksim.page(self._run, title), height)

    def _needs_motion(self) -> tuple[float, float]:
        """First and last instant of the motion between samples."""
        span = self._run.span()
        if span is None:
            raise ValueError("the motion between samples was not kept: solve with dense=True")
        return span[0], span[1]

    def _title(self) -> str:
        first, last = self.span
        n = len(self._t)
        how = "" if self.success else f", {self._run.ending}"
        span = said("{} s to {} s").format(f"{first:g}", f"{last:g}")
        return f"bksim.Solution {self._engine.name!r}: {counted(n, 'sample', 'samples')}, {span}{how}"

    def _repr_html_(self) -> str:
        from html import escape

        return f"<p>{escape(self._title())}</p>" + self.plot()._repr_svg_()
