"""Derivatives of one number that a whole motion makes, by many quantities at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _bksim
from ._checked import names as checked_names
from ._functions import Functions
from ._named import Array, unknown
from ._samples import Samples


def gradient(
    sol: Samples,
    run: _bksim.Run,
    functions: Functions,
    weights: Mapping[str, ArrayLike],
    by: str | Sequence[str] | None,
) -> dict[str, float]:
    """See ``Solution.gradient``, of these samples of a run; ``functions`` are those of its model."""
    if not isinstance(weights, Mapping):
        raise TypeError(f"weights = {weights!r}: give an array for each name")
    places = {name: k for k, name in enumerate(_bksim.weight_columns(sol._engine))}
    rows: dict[int, Array] = {}
    measured: dict[str, Array] = {}
    for name in checked_names("weights", weights):
        values = _checked(name, weights[name], len(sol))
        place = _place(name, places)
        if place is not None:
            rows[place] = rows.get(place, 0.0) + values
        elif name in sol:
            measured[name] = values
        else:
            raise KeyError(unknown(name, [*places, *sol.names]))

    # What follows from the state has its weights there, and depends on parameters besides.
    factors = np.array(list(measured.values()))
    if measured:
        changes = functions.derivatives([*measured], sol.t, sol.q.T, sol.v.T, by=["q", "v"])
        by_state = np.concatenate([changes["q"], changes["v"]], axis=2)
        for place, values in enumerate(np.einsum("jn,njk->kn", factors, by_state)):
            rows[place] = rows.get(place, 0.0) + values
    table = np.array(list(rows.values())).reshape(len(rows), len(sol))
    wanted = None if by is None else checked_names("by", by)
    found = dict(_bksim.gradient_of(run, [*rows], table, wanted))
    own_names = {name for name, _, _ in sol._engine.parameters()}
    parameters = [name for name in found if name in own_names]
    if measured and parameters:
        own = [f"parameters.{name}" for name in parameters]
        changes = functions.derivatives([*measured], sol.t, sol.q.T, sol.v.T, by=own)
        for name, full in zip(parameters, own, strict=True):
            found[name] += float(np.einsum("jn,nj->", factors, changes[full]))
    return found


def _checked(name: str, given: ArrayLike, n: int) -> Array:
    """A number for each sample."""
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"the weights of {name!r} are {given!r}: give an array of numbers") from None
    if values.shape != (n,):
        words = f"give one for each of the {n} samples, an array of shape ({n},)"
        raise ValueError(f"weights of shape {values.shape} for {name!r}: {words}")
    if not np.isfinite(values).all():
        first = int(np.flatnonzero(~np.isfinite(values))[0])
        raise ValueError(f"the weight of {name!r} at sample {first} is {values[first]}")
    return values


def _place(name: str, places: Mapping[str, int]) -> int | None:
    """The place of a quantity by its name, or by the one that a table has for it."""
    if name in places:
        return places[name]
    topic, _, field = name.partition(".")
    if topic in ("state", "acceleration", "multipliers"):
        return places.get(field)
    return places.get(f"signals.{name}")
