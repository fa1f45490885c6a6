"""Samples of a motion: quantities at some instants, by their names."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

from . import _bksim
from ._named import Array, Named, resolved, short_names, unknown
from ._said import said
from ._text import counted, small_table

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow
    import xarray


class Samples:
    """Everything about a motion at some instants.

    All arrays are read-only views of one table: a row per quantity, contiguous in time. Of one
    instant alone they have no axis of time.
    """

    def __init__(
        self,
        engine: _bksim.Engine,
        t: Array,
        table: Array,
        described: _bksim.Engine | _bksim.Run | None,
        is_one: bool = False,
    ) -> None:
        self._engine = engine
        self._t = t
        self._table = table
        self._described = described
        self._is_one = is_one
        self._measured: dict[str, Array] = {}

    @cached_property
    def _columns(self) -> list[tuple[str, str, str]]:
        """Name, unit and description of every row of the table."""
        assert self._described is not None
        return self._described.columns()

    @cached_property
    def _row(self) -> dict[str, int]:
        return {name: k for k, (name, _, _) in enumerate(self._columns)}

    def __getstate__(self) -> dict[str, Any]:
        # Rows are views of the table, and what they are called is all that the run is asked for.
        return {**self.__dict__, "_columns": self._columns, "_described": None, "_measured": {}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for array in (self._t, self._table):
            array.flags.writeable = False

    def _rows(self, topic: str) -> Array:
        places = [k for k, (name, _, _) in enumerate(self._columns) if name.startswith(f"{topic}.")]
        rows = self._table[places[0] : places[-1] + 1] if places else self._table[:0]
        return self._at(rows)

    def _at(self, rows: Array) -> Array:
        return rows[..., 0] if self._is_one else rows

    @property
    def t(self) -> Array:
        """Instants, s."""
        return self._at(self._t)

    @property
    def q(self) -> Array:
        """Generalised coordinates, (nq, n): m or rad."""
        state = self._rows("state")
        return state[: len(state) // 2]

    @property
    def v(self) -> Array:
        """Their rates, (nq, n): m/s or rad/s."""
        state = self._rows("state")
        return state[len(state) // 2 :]

    @property
    def a(self) -> Array:
        """Their accelerations, (nq, n): m/s² or rad/s²."""
        return self._rows("acceleration")

    @property
    def lam(self) -> Array:
        """Multipliers, (nc, n): N or N m."""
        return self._rows("multipliers")

    @property
    def reactions(self) -> Named:
        """By joint, (6, n): force in N, then moment in N m, on the joint's second body, world axes."""
        names = self._engine.joints()
        return Named({name: self._rows(f"reactions.{name}") for name in names})

    @property
    def drives(self) -> Named:
        """By drive, (n,): the force or torque that its motion takes, N or N m."""
        return Named({name.removeprefix("drives."): self[name] for name in self._of("drives")})

    @property
    def inputs(self) -> Named:
        """By input, (n,): its value, SI."""
        return Named({name.removeprefix("inputs."): self[name] for name in self._of("inputs")})

    @property
    def energy(self) -> Named:
        """``kinetic``, ``potential``, ``total``, ``work`` in J, ``power`` in W, (n,)."""
        return Named({name.removeprefix("energy."): self[name] for name in self._of("energy")})

    def _of(self, topic: str) -> list[str]:
        return [name for name in self._row if name.startswith(f"{topic}.")]

    @property
    def names(self) -> tuple[str, ...]:
        """All quantities of the table: ``state.theta``, ``reactions.A.fx``, ``energy.total``."""
        return tuple(self._row)

    def _resolved(self, name: str) -> int | None:
        """The row of a quantity by its name, or by the last part of it where that is clear."""
        return resolved(name, self._row)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: object) -> bool:
        if not isinstance(name, str):
            return False
        is_row = name == "t" or self._resolved(name) is not None
        return is_row or self._engine.measure_unit(name) is not None

    def __getitem__(self, name: str) -> Array:
        """A quantity by name, (n,).

        A quantity of the table (``energy.total``, or ``theta`` for ``state.theta``), or anything that
        the expressions of a model file may name: ``A.angle``, ``rod.x``, ``rod.B.vy``, ``crank.angle``; also
        reactions in the axes of their joint's first point, ``reactions.A.fx_joint``.
        """
        if not isinstance(name, str):
            raise TypeError(f"{name!r} is no name: quantities have names, as in solution.names")
        if name == "t":
            return self.t
        row = self._resolved(name)
        if row is not None:
            return self._at(self._table[row])
        if name not in self._measured:
            if self._engine.measure_unit(name) is None:
                known = [*self._row, *short_names(self._row), *self._engine.measure_names()]
                raise KeyError(unknown(name, known))
            names = [known for known, _, _ in self._columns]
            state = [k for k, known in enumerate(names) if known.startswith("state.")]
            second = [k for k, known in enumerate(names) if known.startswith("acceleration.")]
            nq = len(state) // 2
            multipliers = [k for k, known in enumerate(names) if known.startswith("multipliers.")]
            reactions = [k for k, known in enumerate(names) if known.startswith("reactions.")]
            parts = (state[:nq], state[nq:], second, multipliers, reactions)
            motion = (self._table[rows] for rows in parts)
            self._measured[name] = self._engine.measured([name], *motion)[0]
        return self._at(self._measured[name])

    def unit(self, name: str) -> str:
        """The SI unit of a quantity."""
        if name == "t":
            return "s"
        row = self._resolved(name)
        if row is not None:
            return self._columns[row][1]
        unit = self._engine.measure_unit(name)
        if unit is None:
            raise KeyError(unknown(name, [*self.names, *self._engine.measure_names()]))
        return unit

    def _title(self) -> str:
        n, at = len(self._columns), counted(1 if self._is_one else len(self._t), "instant", "instants")
        return said("bksim.Samples: {} of {} at {}").format(counted(n, "quantity", "quantities"), repr(self._engine.name), at)

    def __repr__(self) -> str:
        columns = [("t", "s", self._t)]
        columns += [(name, unit, self._table[k]) for k, (name, unit, _) in enumerate(self._columns)]
        return f"<{self._title()}>\n{small_table(columns)}"

    def __len__(self) -> int:
        return len(self._t)

    def to_pandas(self) -> pandas.DataFrame:
        """A table with a row per instant; units are in ``attrs["units"]``."""
        import pandas

        frame = pandas.DataFrame(self._table.T, columns=list(self._row))
        frame.index = pandas.Index(self._t, name="t")
        frame.attrs["units"] = {"t": "s"} | {name: unit for name, unit, _ in self._columns}
        return frame

    def to_polars(self) -> polars.DataFrame:
        """A data frame of Polars with a row per instant: ``t``, then every quantity; :meth:`unit` has their units, SI."""
        import polars

        columns = {"t": self._t} | {name: self._table[k] for name, k in self._row.items()}
        return polars.DataFrame(columns)

    def to_xarray(self) -> xarray.Dataset:
        """A dataset over ``t`` with a variable per quantity, its unit and what it is in ``attrs``."""
        import xarray

        def variable(k: int) -> Any:
            _, unit, description = self._columns[k]
            return ("t", self._table[k], {"units": unit, "long_name": description})

        variables = {name: variable(k) for name, k in self._row.items()}
        t = ("t", self._t, {"units": "s", "long_name": "time"})
        return xarray.Dataset(variables, coords={"t": t})

    def to_arrow(self) -> pyarrow.Table:
        """An Arrow table; units are in the metadata of its fields."""
        import pyarrow

        def field(name: str, unit: str) -> Any:
            return pyarrow.field(name, pyarrow.float64(), nullable=False, metadata={"unit": unit})

        fields = [field("t", "s"), *(field(name, unit) for name, unit, _ in self._columns)]
        arrays = [pyarrow.array(values) for values in (self._t, *self._table)]
        return pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields))
