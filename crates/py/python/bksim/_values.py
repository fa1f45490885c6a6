"""Values of a model's parameters: numbers, and functions of the motion."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import _bksim
from ._checked import real
from ._errors import ModelError
from ._assigned import Value
from ._said import said
from ._sampled import Sampled

NO_VALUE = frozenset({"M020", "M021", "M022", "M024", "M030", "M031", "M032", "M033"})
"""Faults of a text that no other values could mend: it cannot be read, or its unit is another one."""

Law: TypeAlias = "Callable[[float, NDArray[np.float64], NDArray[np.float64]], float]"
"""The value of an input, SI, at t, q and v."""


class Owner(Protocol):
    """A model, as far as its values go."""

    _overrides: dict[str, str]
    _numbers: dict[str, float]
    _inputs: dict[str, Law | Sampled]

    @property
    def parameters(self) -> Parameters: ...

    def _engine(self) -> _bksim.Engine: ...

    def _readable(self) -> _bksim.Engine: ...

    def _text(self) -> tuple[str, Path, str]: ...


class Parameters(MutableMapping[str, float]):
    """Values of parameters in SI. What is set may be a number in SI, or a text as in a model file:
    ``m.parameters["l1"] = 0.8``, ``m.parameters["l1"] = "80 cm"``. ``del`` and ``clear`` bring the
    model's own definitions back.

    A parameter without a unit, for which :meth:`unit` is empty, is a plain number: used as a length in a
    file of millimetres, it is one of millimetres.
    """

    def __init__(self, model: Owner) -> None:
        self._model = model

    def _values(self) -> dict[str, tuple[float, str]]:
        return {name: (value, unit) for name, value, unit in self._model._engine().parameters()}

    def __getitem__(self, name: str) -> float:
        known = self._values()
        if name not in known:
            raise KeyError(_unknown("parameter", name, known))
        return known[name][0]

    def __setitem__(self, name: str, value: Value) -> None:
        engine = self._model._readable()
        known = {name: value for name, value, _ in engine.parameters()}
        if name not in known:
            raise KeyError(_unknown("parameter", name, known))
        if name in self._model._inputs:
            raise ValueError(f"{name} is an input: del model.inputs[{name!r}] makes it a number again")
        if isinstance(value, str):
            self._check(name, value)
            self._model._numbers.pop(name, None)
        else:
            number = real(name, value)
            if number is None or not math.isfinite(number):
                raise ValueError(f"{name} = {value!r}: give a finite number, or a text with a unit")
            unit = _bksim.si_unit(engine, name) or ""
            value = f"{number!r} {unit}".strip()
            self._model._numbers[name] = number
        self._model._overrides[name] = value

    def _check(self, name: str, value: str) -> None:
        """Refuses a text that is no value, or one of another kind, where it is set; whether a mechanism may have
        the value is seen when all are set."""
        text, path, model = self._model._text()
        values = {**self._model._overrides, name: value}
        try:
            _bksim.check_values(text, path, model, list(values.items()))
        except ModelError as refused:
            faults = [fault for fault in refused.diagnostics if fault.code in NO_VALUE]
            if not faults:
                return
            words = "; ".join(f"{fault.message} [{fault.code}]" for fault in faults)
            help = f" ({faults[0].help})" if faults[0].help else ""
            raise ModelError(f"{name} = {value!r}: {words}{help}", tuple(faults)) from None

    def __delitem__(self, name: str) -> None:
        if name not in {name for name, _, _ in self._model._readable().parameters()}:
            raise KeyError(name)
        self._model._overrides.pop(name, None)
        self._model._numbers.pop(name, None)

    def clear(self) -> None:
        """Brings all of the model's own definitions back."""
        self._model._overrides.clear()
        self._model._numbers.clear()

    def popitem(self) -> tuple[str, float]:
        """Raises TypeError: a model keeps its parameters."""
        raise TypeError("a model keeps its parameters: del brings its own definition of one back")

    def __iter__(self) -> Iterator[str]:
        return iter(self._values())

    def __len__(self) -> int:
        return len(self._values())

    def unit(self, name: str) -> str:
        """The SI unit of a parameter; empty when the model leaves it open."""
        return self._values()[name][1]

    def __repr__(self) -> str:
        try:
            known = self._values()
        except ModelError as refused:
            set_to = ", ".join(f"{name} = {value}" for name, value in self._model._overrides.items())
            return said("<refused with {}: {}>").format(set_to or said("its own values"), first_line(refused))
        rows = (f"{name}: {value:g} {unit}".strip() for name, (value, unit) in known.items())
        return "{" + ", ".join(rows) + "}"

    def _repr_html_(self) -> str:
        from ._html import table

        rows = [[name, f"{value:g}", unit] for name, (value, unit) in self._values().items()]
        return table(["parameter", "value", "unit"], rows)


class Inputs(MutableMapping[str, "Law | Sampled"]):
    """Parameters whose values are functions of the motion, such as what a controller commands.

    A function takes the time in s, the coordinates and their rates (in the order of
    ``Model.coordinates``, m or rad), and returns the value in the unit that ``Parameters.unit`` tells, SI;
    of a parameter without one, a plain number as the file would have it. It is called at every evaluation of
    the equations, also at states that are only tried, back and forth: see the README for what that costs. So
    it must not remember anything; :meth:`Model.solve` refuses one that gives another value at the same t, q
    and v. A law with a memory is :class:`Sampled`. Only loads may depend on the parameter. ``del``
    makes it a number again.

    >>> import bksim
    >>> m = bksim.loads('''
    ... [parameters]
    ... u = "0 N m"
    ... [bodies.arm]
    ... mass = "2 kg"
    ... com = ["0.5 m", 0]
    ... inertia = "0.1 kg m^2"
    ... [joints.A]
    ... type = "revolute"
    ... between = ["ground", "arm"]
    ... [loads]
    ... gravity = { type = "gravity", acceleration = [0, "-9.81 m/s^2"] }
    ... motor = { type = "torque", on = "arm", value = "u" }
    ... ''')
    >>> m.inputs["u"] = lambda t, q, v: 9.81 - 40 * (q[0] - 0.5) - 5 * v[0]
    >>> sol = m.solve(t_end=5)
    >>> bool(abs(sol["A.rate"][-1]) < 1e-6), sol.inputs["u"].shape
    (True, (501,))
    """

    def __init__(self, model: Owner) -> None:
        self._model = model

    def __getitem__(self, name: str) -> Law | Sampled:
        return self._model._inputs[name]

    def __setitem__(self, name: str, law: Law | Sampled) -> None:
        if not callable(law) and not isinstance(law, Sampled):
            words = f"{law!r} is no function of t, q and v: a number goes to parameters[{name!r}]"
            raise TypeError(words)
        if name not in self._model.parameters:
            raise KeyError(_unknown("parameter", name, self._model.parameters))
        self._model._inputs[name] = law

    def __delitem__(self, name: str) -> None:
        del self._model._inputs[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._model._inputs)

    def __len__(self) -> int:
        return len(self._model._inputs)

    def __repr__(self) -> str:
        return repr(self._model._inputs)

    def _repr_html_(self) -> str:
        from ._html import table

        rows = [[name, repr(law)] for name, law in self._model._inputs.items()]
        return table(["input", "function of t, q, v"], rows)


def first_line(error: ModelError) -> str:
    return str(error).partition("\n")[0]


def _unknown(what: str, name: str, known: Mapping[str, Any]) -> str:
    near = difflib.get_close_matches(name, list(known), n=1)
    hint = f"; did you mean {near[0]!r}?" if near else f"; there are {', '.join(known) or 'none'}"
    return f"no {what} is called {name!r}{hint}"
