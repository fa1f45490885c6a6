"""Motions that are advanced from Python, with inputs that are set on the way."""

from __future__ import annotations

import copy
import math
from functools import cached_property

import numpy as np

from . import _bksim
from ._named import Array, Named, resolved, short_names, unknown
from ._said import said


class SavedState:
    """A state of a :class:`Stepping`, from which it goes on as if it had never left it; also in another
    process, to which it is pickled."""

    def __init__(self, state: _bksim.SavedState) -> None:
        self._state = state


class Stepping:
    """A motion that is held at one instant, and advanced from there: ``Model.begin()``.

    An input is a parameter that nothing but loads depend on. It keeps its value until it is set again, as
    the output of a sampled controller does:

    >>> import bksim
    >>> run = bksim.example("cart-pole").begin()
    >>> for k in range(100):
    ...     run.set_input("u", -10 * run["x"])
    ...     run.advance_to(0.001 * (k + 1))
    >>> round(run.t, 9)
    0.1

    While inputs stay as they are, the states are those of ``Model.solve`` to the last bit, however often
    the motion is held. A copy, or what comes out of a pickle, goes on as the motion itself does.
    """

    def __init__(self, run: _bksim.Stepping) -> None:
        self._run = run
        self._row: Array | None = None

    @property
    def t(self) -> float:
        """Time at which the motion is held, s."""
        return self._run.t

    @property
    def q(self) -> Array:
        """Coordinates there, (nq,), in the order of ``Model.coordinates``."""
        return self._run.q

    @property
    def v(self) -> Array:
        """Their rates, (nq,)."""
        return self._run.v

    @property
    def a(self) -> Array:
        """Their accelerations, (nq,), with the inputs that have led there."""
        return self._run.a

    @property
    def lam(self) -> Array:
        """Multipliers, (nc,), with the inputs that have led there."""
        return self._run.lam

    @property
    def reactions(self) -> Named:
        """Force and moment of each joint, (6,): N and N m, world axes, with the inputs that have led
        there."""
        six = self._run.reactions.reshape(-1, 6)
        return Named(dict(zip(self._run.engine.joints(), six, strict=True)))

    @cached_property
    def _columns(self) -> dict[str, int]:
        return {name: k for k, (name, _, _) in enumerate(self._run.engine.columns())}

    def __getitem__(self, name: str) -> float:
        """A quantity by the name that it has in a solution: ``run["energy.total"]``, ``run["theta"]``,
        ``run["pole.x"]``.

        Raises KeyError when there is none of this name, ValueError when it has no finite value here, such as
        an output that divides by zero; what is not unique, as a reaction may be, is NaN.
        """
        value = self._value(name)
        if math.isinf(value):
            raise ValueError(f"`{name}` has no value at t = {self.t:.9g} s: it is {value}")
        return value

    def _value(self, name: str) -> float:
        column = resolved(name, self._columns)
        if column is None and self._run.engine.measure_unit(name) is not None:
            run = self._run
            parts = (part[:, np.newaxis] for part in (run.q, run.v, run.a, run.lam, run.reactions))
            return float(run.engine.measured([name], *parts)[0, 0])
        if column is None:
            raise KeyError(unknown(name, [*self._columns, *short_names(self._columns)]))
        if self._row is None:
            self._row = self._run.row()
        return float(self._row[column])

    def set_input(self, name: str, value: float) -> None:
        """Lets a parameter have this value from now on, in SI units.

        Raises KeyError when there is none of this name, ValueError when more than loads depends on it.
        """
        self._run.set_input(name, value)

    def advance_to(self, t: float) -> None:
        """Advances the motion to ``t``, s, and holds it there.

        Raises ValueError unless ``t`` lies ahead and before the end; SolverError, without a ``result``,
        when the motion cannot go on. Ctrl-C ends it within a fifth of a second.
        """
        self._row = None
        self._run.advance_to(t)

    def save(self) -> SavedState:
        """The state in which the motion is held."""
        return SavedState(self._run.save())

    def restore(self, state: SavedState) -> None:
        """Holds the motion in a state that was saved: what follows is the same to the last bit."""
        self._row = None
        self._run.restore(state._state)

    def __copy__(self) -> Stepping:
        return copy.deepcopy(self)

    def __repr__(self) -> str:
        return said("<bksim.Stepping {} at t = {} s>").format(repr(self._run.engine.name), f"{self.t:g}")
