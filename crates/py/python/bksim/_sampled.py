"""Laws of inputs that are sampled: called at even intervals, each once, and held in between."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ._checked import real

if TYPE_CHECKING:
    from ._stepping import Stepping

Array = NDArray[np.float64]


class Sampled:
    """A law that is called every so many seconds, in order and each time once, as a digital controller is.

    Its value holds until the next call. Unlike a plain function, which the integrator calls at states that
    it only tries, it may have a memory: integrals, filters, hysteresis.

    ``reset`` is called at the beginning of every solve; without it, the method ``reset`` of the law is, if
    it has one.

    >>> import bksim
    >>> class Integral:
    ...     def reset(self):
    ...         self.sum = 0.0
    ...     def __call__(self, t, q, v):
    ...         self.sum += 0.01 * (0.5 - q[0])
    ...         return 5 * self.sum
    >>> m = bksim.example("cart-pole")
    >>> m.inputs["u"] = bksim.Sampled(Integral(), every=0.01)
    >>> first, second = m.solve(t_end=0.5), m.solve(t_end=0.5)
    >>> bool((first["x"] == second["x"]).all())
    True
    """

    def __init__(
        self,
        law: Callable[[float, Array, Array], float],
        every: float,
        *,
        reset: Callable[[], object] | None = None,
    ) -> None:
        if not callable(law):
            raise TypeError(f"{law!r} is no function of t, q and v")
        interval = real("every", every)
        if interval is None or not 0 < interval < math.inf:
            raise ValueError(f"every = {every!r}: give the interval of the calls in s, above 0")
        self.law = law
        self.every = interval
        self._reset = reset if reset is not None else getattr(law, "reset", None)

    def begin(self) -> None:
        """Forgets what the law remembers of an earlier run."""
        if self._reset is not None:
            self._reset()

    def __repr__(self) -> str:
        return f"Sampled({self.law!r}, every={self.every!r})"


class Held:
    """A function of time that holds each value until the next: what a sampled law has returned."""

    def __init__(self, times: Sequence[float], values: Sequence[float]) -> None:
        self._times = list(times)
        self._values = list(values)

    def __call__(self, t: float, q: Array, v: Array) -> float:
        return self._values[max(bisect_right(self._times, t) - 1, 0)]


def held(run: Stepping, laws: Mapping[str, Sampled], t_end: float) -> dict[str, Held]:
    """Advances a motion with its sampled laws, and returns what these have returned as functions of time."""
    start = run.t
    if t_end < start:
        raise ValueError("sampled laws go forwards in time: end the run after its start")
    found: dict[str, tuple[list[float], list[float]]] = {name: ([], []) for name in laws}
    for law in laws.values():
        law.begin()
    while True:
        # Call the laws that are due, at the state that the motion has reached.
        for name, law in laws.items():
            times, values = found[name]
            if start + len(times) * law.every <= run.t:
                value = float(law.law(run.t, run.q, run.v))
                if not math.isfinite(value):
                    raise ValueError(f"the input `{name}` is {value} at t = {run.t} s")
                times.append(run.t)
                values.append(value)
                run.set_input(name, value)
        # Go on to the next call.
        due = min(start + len(found[name][0]) * law.every for name, law in laws.items())
        if due >= t_end:
            return {name: Held(*table) for name, table in found.items()}
        run.advance_to(due)
