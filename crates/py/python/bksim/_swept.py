"""What a sweep gives: a row per case, in memory or in a file of Parquet."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from . import _bksim
from ._html import table
from ._said import said
from ._text import counted, small_table

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

    from ._model import Model
    from ._solution import Solution

Array = NDArray[Any]

OWN = ("case", "status", "code", "reason", "t_reached", "steps")
"""Names of the columns that every sweep has."""

SHOWN = (5, 3)
"""First and last rows that a notebook shows of a long sweep."""


@dataclass(frozen=True)
class Failure:
    """A case that failed: ``bksim.explain(failure.code)`` tells the way out. ``status`` is
    ``refused`` (its values), ``no start``, or ``stopped`` (the run, early)."""

    case: int
    status: str
    code: str
    reason: str


@dataclass(frozen=True)
class About:
    """What is known of a sweep before any case is done."""

    model: str
    n_cases: int
    inputs: tuple[tuple[str, str], ...]
    outputs: tuple[tuple[str, str], ...]
    shape: tuple[int, ...] | None
    aliases: dict[str, str]

    @classmethod
    def of(cls, study: _bksim.Study, asked: Sequence[str]) -> About:
        """``asked`` are the outputs as they were asked for, in place of their full names."""
        outputs = tuple(study.outputs())
        return cls(
            model=study.model_name,
            n_cases=study.n_cases,
            inputs=tuple((_stored(name), unit) for name, unit in study.inputs()),
            outputs=outputs,
            shape=None if study.shape is None else tuple(study.shape),
            aliases={text: name for text, (name, _) in zip(asked, outputs, strict=False)},
        )

    @property
    def units(self) -> dict[str, str]:
        return dict((*self.inputs, *self.outputs, ("t_reached", "s")))

    @property
    def names(self) -> tuple[str, ...]:
        """Columns in the order of the file."""
        numbers = (name for name, _ in (*self.inputs, *self.outputs))
        return ("case", *numbers, *OWN[1:])


def _stored(name: str) -> str:
    return f"set.{name}" if name in OWN else name


class Rows(Protocol):
    """Where the rows are."""

    path: Path | None

    def __len__(self) -> int: ...

    def column(self, name: str) -> Array: ...

    def ok(self) -> NDArray[np.bool_]: ...

    def failures(self) -> tuple[Failure, ...]: ...

    def arrow(self) -> pyarrow.Table: ...


class InMemory:
    """Rows that were computed here."""

    path: Path | None = None

    def __init__(self, about: About, blocks: Sequence[_bksim._Block]) -> None:
        n_numbers = len(about.inputs) + len(about.outputs) + 1
        none = np.empty((n_numbers, 0))
        numbers: Array = np.concatenate([none, *(block[1] for block in blocks)], axis=1)
        numbers.flags.writeable = False
        self._about = about
        self._case = np.array([case for block in blocks for case in block[0]], dtype=np.int64)
        self._steps = np.array([n for block in blocks for n in block[2]], dtype=np.int64)
        names = [name for name, _ in (*about.inputs, *about.outputs)]
        self._numbers: dict[str, Array] = dict(zip([*names, "t_reached"], numbers, strict=True))
        self._failures = tuple(
            Failure(block[0][place], status, code, reason)
            for block in blocks
            for place, status, code, reason in block[3]
        )

    def __len__(self) -> int:
        return len(self._case)

    def column(self, name: str) -> Array:
        if name in self._numbers:
            return self._numbers[name]
        if name in ("case", "steps"):
            return self._case if name == "case" else self._steps
        texts = np.full(len(self), "done" if name == "status" else None, dtype=object)
        texts[~self.ok()] = [getattr(failure, name) for failure in self._failures]
        return texts

    def ok(self) -> NDArray[np.bool_]:
        is_ok: NDArray[np.bool_] = ~np.isin(self._case, [f.case for f in self._failures])
        return is_ok

    def failures(self) -> tuple[Failure, ...]:
        return self._failures

    def arrow(self) -> pyarrow.Table:
        import pyarrow

        has_failed = ~self.ok()
        outputs = {name for name, _ in self._about.outputs}

        def array(name: str) -> Any:
            return pyarrow.array(self.column(name), mask=has_failed if name in outputs else None)

        return pyarrow.table({name: array(name) for name in self._about.names})


class InFile:
    """Rows in a file of Parquet, read when they are asked for."""

    def __init__(self, about: About, path: Path) -> None:
        self._about = about
        self.path: Path | None = path

    @property
    def _file(self) -> Any:
        from pyarrow import parquet

        return parquet.ParquetFile(self.path, memory_map=True)

    def __len__(self) -> int:
        return self._about.n_cases

    def column(self, name: str) -> Array:
        with self._file as file:
            values: Array = file.read(columns=[name]).column(name).to_numpy()
            return values

    def ok(self) -> NDArray[np.bool_]:
        with self._file as file:
            codes = file.read(columns=["code"]).column("code")
            is_ok: NDArray[np.bool_] = codes.is_null().to_numpy()
            return is_ok

    def failures(self) -> tuple[Failure, ...]:
        found: list[Failure] = []
        with self._file as file:
            for group in range(file.num_row_groups):
                columns = ["case", "status", "code", "reason"]
                rows = file.read_row_group(group, columns=columns)
                rows = rows.filter(rows.column("code").is_valid())
                found += (Failure(**row) for row in rows.to_pylist())
        return tuple(found)

    def arrow(self) -> pyarrow.Table:
        with self._file as file:
            rows: pyarrow.Table = file.read()
            return rows


OPTIONS = ("t_end", "rtol", "atol", "step", "every", "method", "formulation")
"""Options of a sweep that its runs have."""


@dataclass(frozen=True)
class Again:
    """The model as it was swept, and the request, to solve a case once more."""

    model: Model
    asked: Any

    def solve(self, case: int, options: dict[str, Any]) -> Solution:
        model = self.model.copy()
        for name, value in _bksim.Study.prepare(self.asked).settings(case):
            model._numbers.pop(name, None)
            model._overrides[name] = value
        kept = {name: self.asked[name] for name in OPTIONS}
        compliance: dict[str, list[str]] = {}
        for name, stiffness in self.asked["compliance"]:
            compliance.setdefault(name, []).append(stiffness)
        kept["compliance"] = compliance
        return model.solve(**{**kept, **options})


class Sweep:
    """The rows of a sweep: columns by name, each with a value per case.

    >>> import bksim
    >>> m = bksim.example("slider-crank")
    >>> s = bksim.sweep(m, {"l1": [0.9, 1.0], "m2": [1, 2, 3]}, outputs=["max(energy.kinetic)"], t_end=0.1)
    >>> len(s), bool(s.ok.all()), s.grid("max(energy.kinetic)").shape
    (6, True, (2, 3))

    In memory, or in the file at :attr:`path`, from which columns are read when they are asked for
    (with PyArrow). A case that failed is NaN in outputs; :attr:`failures` says why. After an interrupt
    only the cases that were done are there: see ``s["case"]``.
    """

    def __init__(self, about: About, rows: Rows, again: Again) -> None:
        self._about = about
        self._rows = rows
        self._again = again

    @property
    def path(self) -> Path | None:
        """The file; None in memory."""
        return self._rows.path

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(name for name, _ in self._about.inputs)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of what was kept of each run."""
        return tuple(name for name, _ in self._about.outputs)

    @property
    def names(self) -> tuple[str, ...]:
        """All columns."""
        return self._about.names

    def _resolved(self, name: str) -> str:
        name = self._about.aliases.get(name, name)
        names = self.names
        return name if name in names else names[_bksim.column_named(list(names), name)]

    def __getitem__(self, name: str) -> Array:
        """A column, (n,), in SI."""
        return self._rows.column(self._resolved(name))

    def unit(self, name: str) -> str:
        """The SI unit of a column; empty for none."""
        return self._about.units.get(self._resolved(name), "")

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def is_whole(self) -> bool:
        """Whether every case of the sweep has a row."""
        return len(self) == self._about.n_cases

    @property
    def ok(self) -> NDArray[np.bool_]:
        """Which cases ran to their end, (n,)."""
        return self._rows.ok()

    @cached_property
    def failures(self) -> tuple[Failure, ...]:
        """The cases that failed, with the reasons."""
        return self._rows.failures()

    @property
    def shape(self) -> tuple[int, ...] | None:
        """Values per axis of a grid; None of samples."""
        return self._about.shape

    def grid(self, name: str) -> NDArray[np.float64]:
        """A column of numbers with an axis per axis of the grid; NaN where a case failed or was not
        done. Raises ValueError for samples, and for columns of text."""
        if self.shape is None:
            raise ValueError("samples have no grid: take columns, s[name]")
        values = self[name]
        if values.dtype == object:
            raise ValueError(f"{name!r} is a column of text: take s[{name!r}]")
        out = np.full(self._about.n_cases, np.nan)
        out[self["case"]] = values
        return out.reshape(self.shape)

    def solve(self, case: int, **options: Any) -> Solution:
        """The solution of a case, solved again with its values and the options of the sweep;
        ``options`` are those of :meth:`Model.solve`, in place of them. ``s.solve(7).save("case-7.mcap")``
        logs it. The numbers of its row are those of this solution, to the last bit, unless ``options`` change it.

        >>> import bksim
        >>> m = bksim.example("slider-crank")
        >>> s = bksim.sweep(m, {"l1": [0.9, 1.0]}, outputs=["final(state.theta1)"], t_end=0.1)
        >>> bool(s.solve(1)["state.theta1"][-1] == s["final(state.theta1)"][1])
        True

        Raises IndexError for a case that the sweep does not have, and what :meth:`Model.solve` raises.
        """
        case = operator.index(case)
        if not 0 <= case < self._about.n_cases:
            raise IndexError(f"there is no case {case}: they have the numbers 0 to {self._about.n_cases - 1}")
        return self._again.solve(case, options)

    def to_pandas(self) -> pandas.DataFrame:
        """A table with a row per case; units are in ``attrs["units"]``."""
        import pandas

        columns = {name: self._rows.column(name) for name in self.names if name != "case"}
        frame = pandas.DataFrame(columns, index=pandas.Index(self["case"], name="case"))
        frame.attrs["units"] = self._about.units
        return frame

    def to_polars(self) -> polars.DataFrame:
        """A data frame of Polars with a row per case; what failed is null. :meth:`to_arrow` has the units."""
        import polars

        frame = polars.from_arrow(self._rows.arrow())
        assert isinstance(frame, polars.DataFrame)
        return frame

    def to_arrow(self) -> pyarrow.Table:
        """An Arrow table; units are in the metadata of its fields. What failed is null."""
        import pyarrow

        rows = self._rows.arrow()
        units = self._about.units
        fields = [field.with_metadata({"unit": units.get(field.name, "")}) for field in rows.schema]
        return rows.cast(pyarrow.schema(fields, metadata=rows.schema.metadata))

    def _title(self) -> str:
        n_failed = len(self) - int(np.count_nonzero(self.ok))
        failed = ", " + said(f"{n_failed} failed") if n_failed else ""
        n_all = self._about.n_cases
        cases = counted(n_all, "case", "cases")
        if not self.is_whole:
            cases = said("{} of {}").format(len(self), cases)
        title = said("bksim.Sweep {}: {} over {}")
        return title.format(repr(self._about.model), cases, ", ".join(self.inputs)) + failed

    def __repr__(self) -> str:
        if self._rows.path is not None:
            # The file may be large.
            return f"<{self._title()}>"
        units = self._about.units
        names = ("case", *self.inputs, *self.outputs, "status")
        columns = [(name, units.get(name, ""), self._rows.column(name)) for name in names]
        return f"<{self._title()}>\n{small_table(columns)}"

    def _repr_html_(self) -> str:
        from html import escape

        names = ("case", *self.inputs, *self.outputs, "status")
        units = self._about.units
        head = [f"{name} [{units[name]}]" if units.get(name) else name for name in names]
        first, last = SHOWN
        places = list(range(len(self)))
        if len(places) > first + last:
            places = places[:first] + places[-last:]
        columns = [self._rows.column(name)[places] for name in names]
        rows = [[_shown(value) for value in row] for row in zip(*columns, strict=True)]
        if len(places) < len(self):
            rows.insert(first, ["…"] * len(names))
        return f"<p>{escape(self._title())}</p>" + table(head, rows)


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
