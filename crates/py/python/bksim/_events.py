"""Events of a motion as SciPy's ``solve_ivp`` has them: where functions of the state, or quantities, pass zero."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeAlias, Union

import numpy as np

from ._named import Array

if TYPE_CHECKING:
    from ._samples import Samples
    from ._solution import Solution

Event: TypeAlias = Union[str, Callable[[float, Array, Array], float]]
"""A quantity by name, or a function of t, q and v, with the attributes ``terminal`` and ``direction``."""

PER_STEP = 4
"""Instants in a step of the integrator at which signs are compared."""

LEAST = 1000
"""And at least so many in a motion."""


def found(solution: Solution, events: Sequence[Event]) -> tuple[list[Array], float | None]:
    """The instants of each event, and that of the first one that ends the motion."""
    first, last = solution.span
    n = max(LEAST, PER_STEP * int(solution.summary.get("steps", {}).get("n_step", 0)))
    grid = np.linspace(first, last, n + 1)
    samples = solution(grid)
    ends: list[float] = []
    instants: list[Array] = []
    for event in events:
        g = _values(event, samples)
        direction = float(getattr(event, "direction", 0.0))
        rises, falls = (g[:-1] < 0) & (g[1:] >= 0), (g[:-1] > 0) & (g[1:] <= 0)
        passes = rises & (direction >= 0) | falls & (direction <= 0)
        at = np.array([_passage(solution, event, grid[k], grid[k + 1]) for k in np.flatnonzero(passes)])
        instants.append(at)
        # As in SciPy: True for the first passage, or the number of the one that ends the motion.
        count = int(getattr(event, "terminal", 0) or 0)
        if 0 < count <= len(at):
            ends.append(float(at[count - 1]))
    forward = 1 if last >= first else -1
    return instants, min(ends, key=lambda t: forward * t, default=None)


def _values(event: Event, samples: Samples) -> Array:
    if isinstance(event, str):
        return np.atleast_1d(samples[event])
    q, v, t = np.atleast_2d(samples.q.T), np.atleast_2d(samples.v.T), np.atleast_1d(samples.t)
    values = [float(event(float(at), q[k], v[k])) for k, at in enumerate(t)]
    return np.array(values)


def _passage(solution: Solution, event: Event, low: float, high: float) -> float:
    """Where it passes zero between two instants, by halving down to neighbouring numbers."""
    sign = np.sign(_values(event, solution(low))[0])
    for _ in range(64):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if np.sign(_values(event, solution(middle))[0]) == sign:
            low = middle
        else:
            high = middle
    return float(high)
