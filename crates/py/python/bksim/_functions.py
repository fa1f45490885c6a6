"""The compiled functions of the equations, for control, optimisation and integrators of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _bksim
from ._text import counted

Array = NDArray[np.float64]

Function: TypeAlias = Literal[
    "mass_matrix",
    "forces",
    "constraint_jacobian",
    "constraints",
    "accelerations",
    "multipliers",
    "residual",
]
"""A function that has derivatives."""


@dataclass(frozen=True)
class _Derived:
    """A function with its derivatives, and where those by each variable lie."""

    compiled: _bksim.Derivatives
    shape: tuple[int, ...]
    """The axes of the function, then one of all variables."""
    parts: list[tuple[str, slice | int]]
    """Along the last axis: several places of a variable, one of a number."""

    def named(self, found: Array) -> dict[str, Array]:
        return {name: found[..., place] for name, place in self.parts}


def _compiled(engine: _bksim.Engine) -> Functions:
    return Functions(_bksim.compiled_functions(engine))


class Functions:
    r"""M(q) a + G(q)ᵀ λ = f(t, q, v) with g(t, q) = 0, each part as a function of numbers.

    ``q``, ``v`` and ``a`` have ``nq`` values in the order of ``Model.coordinates``, ``lam`` has ``nc``;
    all of them may have a leading axis, over which the function is evaluated without the interpreter
    lock. ``t`` is a number, or one per state.

    >>> import bksim
    >>> import numpy as np
    >>> f = bksim.example("four-bar").compile()
    >>> f.mass_matrix(np.zeros((10, f.nq))).shape == (10, f.nq, f.nq)
    True
    """

    def __init__(self, functions: _bksim.Functions) -> None:
        self._functions = functions
        self.nq, self.nc = functions.sizes
        self._rest = np.zeros(self.nq)
        self._derived: dict[tuple[str | tuple[str, ...], tuple[str, ...]], _Derived] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        # Compiled again from the text, which gives the same bits.
        return _compiled, (self._functions.engine,)

    def __copy__(self) -> Functions:
        return self

    def __deepcopy__(self, memo: Any) -> Functions:
        return self

    def _batch(self, t: ArrayLike, *states: tuple[ArrayLike, int]) -> tuple[bool, Array, list[Array]]:
        """Whether there is a batch, and the instants and states with one."""
        arrays = [np.asarray(state, dtype=np.float64) for state, _ in states]
        for array, (_, n) in zip(arrays, states, strict=True):
            if array.ndim not in (1, 2) or array.shape[-1] != n:
                raise ValueError(f"a state of shape {array.shape} where ({n},) or (batch, {n}) is needed")
        times = np.asarray(t, dtype=np.float64)
        if times.ndim == 0 and all(array.ndim == 1 for array in arrays):
            # One state, as most calls have it: to broadcast it costs more than to evaluate it.
            return False, times.reshape(1), [array.reshape(1, -1) for array in arrays]
        is_batch = times.ndim > 0 or any(array.ndim == 2 for array in arrays)
        sizes = [len(array) for array in arrays if array.ndim == 2] + list(times.shape[:1])
        # As arrays broadcast: one stands for all.
        several = [size for size in sizes if size != 1]
        n_states = several[0] if several else 1
        if any(size != n_states for size in several):
            raise ValueError(f"batches of {', '.join(map(str, several))} states: one size is needed")
        rows = [np.broadcast_to(a, (n_states, a.shape[-1])) for a in arrays]
        return is_batch, np.broadcast_to(times, (n_states,)), rows

    @staticmethod
    def _shaped(out: Array, is_batch: bool, *shape: int) -> Array:
        return out.reshape(len(out), *shape) if is_batch else out.reshape(shape)

    def mass_matrix(self, q: ArrayLike, t: ArrayLike = 0.0) -> Array:
        """M, (…, nq, nq): kg, kg m or kg m²."""
        one = self._functions.mass_matrix_at(t, q)
        if one is not None:
            return one
        is_batch, times, (q,) = self._batch(t, (q, self.nq))
        out = self._functions.mass_matrix(times, q)
        return self._shaped(out, is_batch, self.nq, self.nq)

    def forces(self, t: ArrayLike, q: ArrayLike, v: ArrayLike) -> Array:
        """f, (…, nq): loads, potentials, and what velocities make of inertia, N or N m."""
        one = self._functions.forces_at(t, q, v)
        if one is not None:
            return one
        is_batch, times, (q, v) = self._batch(t, (q, self.nq), (v, self.nq))
        return self._shaped(self._functions.forces(times, q, v), is_batch, self.nq)

    def constraint_jacobian(self, q: ArrayLike, t: ArrayLike = 0.0) -> Array:
        """G = ∂g/∂q, (…, nc, nq)."""
        one = self._functions.constraint_jacobian_at(t, q)
        if one is not None:
            return one
        is_batch, times, (q,) = self._batch(t, (q, self.nq))
        out = self._functions.constraint_jacobian(times, q)
        return self._shaped(out, is_batch, self.nc, self.nq)

    def constraints(self, t: ArrayLike, q: ArrayLike) -> Array:
        """g, (…, nc): m or rad."""
        one = self._functions.constraints_at(t, q)
        if one is not None:
            return one
        is_batch, times, (q,) = self._batch(t, (q, self.nq))
        return self._shaped(self._functions.constraints(times, q), is_batch, self.nc)

    def accelerations(self, t: ArrayLike, q: ArrayLike, v: ArrayLike) -> Array:
        """v̇, (…, nq), which keeps the constraints: m/s² or rad/s²; NaN where there is none."""
        return self.accelerations_and_multipliers(t, q, v)[0]

    def accelerations_and_multipliers(
        self, t: ArrayLike, q: ArrayLike, v: ArrayLike
    ) -> tuple[Array, Array]:
        """v̇, (…, nq), and λ, (…, nc); the smallest λ where it is not unique."""
        one = self._functions.accelerations_at(t, q, v)
        if one is not None:
            return one[: self.nq], one[self.nq :]
        is_batch, times, (q, v) = self._batch(t, (q, self.nq), (v, self.nq))
        both = self._functions.accelerations(times, q, v)
        a, lam = both[:, : self.nq], both[:, self.nq :]
        return (a, lam) if is_batch else (a[0], lam[0])

    def residual(
        self, t: ArrayLike, q: ArrayLike, v: ArrayLike, a: ArrayLike, lam: ArrayLike
    ) -> Array:
        """M a + Gᵀ λ − f, then g, (…, nq + nc)."""
        one = self._functions.residual_at(t, q, v, a, lam)
        if one is not None:
            return one
        n, m = self.nq, self.nc
        is_batch, times, (q, v, a, lam) = self._batch(t, (q, n), (v, n), (a, n), (lam, m))
        return self._shaped(self._functions.residual(times, q, v, a, lam), is_batch, n + m)

    def measure(
        self,
        names: str | Sequence[str],
        q: ArrayLike,
        v: ArrayLike | None = None,
        t: ArrayLike = 0.0,
    ) -> Array:
        """Quantities of the motion by name at states, (…, len(names)), or (…) of one name: coordinates of points,
        energies, and with the accelerations that follow from the state, reactions. ``v`` is zero unless given.

        >>> import bksim
        >>> import numpy as np
        >>> f = bksim.example("four-bar").compile()
        >>> q = np.array([1.0, 0.2, 0.8])
        >>> f.measure(["coupler.x", "energy.kinetic"], q).shape
        (2,)

        Raises KeyError for a name of nothing that follows from the state.
        """
        of = (names,) if isinstance(names, str) else tuple(names)
        v = self._rest if v is None else v
        one = self._derivative(of, ()).compiled.at_one(t, q, v, None)
        if one is not None:
            return one[0][0] if isinstance(names, str) else one[0]
        is_batch, times, (q, v) = self._batch(t, (q, self.nq), (v, self.nq))
        values, _ = self._derivative(of, ()).compiled.at(times, q, v, None)
        values = values[:, 0] if isinstance(names, str) else values
        return values if is_batch else values[0]

    def derivatives(
        self,
        of: Function | Sequence[str],
        t: ArrayLike,
        q: ArrayLike,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        lam: ArrayLike | None = None,
        *,
        by: str | Sequence[str] = ("q", "v"),
    ) -> dict[str, Array]:
        """Exact derivatives of a function of this class, or of the quantities of a list of names, at states.

        ``of`` is ``"mass_matrix"``, ``"forces"``, ``"constraint_jacobian"``, ``"constraints"``,
        ``"accelerations"``, ``"multipliers"`` or ``"residual"`` (which takes ``a`` and ``lam``), or a list as
        for :meth:`measure`. ``by`` names variables of the state, ``"t"``, ``"q"`` and ``"v"``, of a residual also
        ``"a"`` and ``"lam"``, and parameters, with those that are defined through them. A variable adds its axis
        at the end of that of the function, a parameter and ``t`` add none.

        >>> import bksim
        >>> import numpy as np
        >>> f = bksim.example("cart-pole").compile()
        >>> d = f.derivatives("accelerations", 0.0, np.zeros(2), np.zeros(2), by=["q", "u"])
        >>> d["q"].shape, d["u"].shape
        ((2, 2), (2,))

        They are derived once for each ``of`` and ``by``, and compiled. Raises KeyError for unknown names, and
        ValueError for multipliers that joints share.
        """
        by = (by,) if isinstance(by, str) else tuple(by)
        kind = of if isinstance(of, str) else tuple(of)
        v = self._rest if v is None else v
        if of == "residual":
            if a is None or lam is None:
                raise ValueError("a residual is one of accelerations and multipliers: give a and lam")
        elif a is not None or lam is not None:
            raise ValueError(f"{of!r} takes no a and lam: they follow from t, q and v")
        given = None if a is None or lam is None else (a, lam)
        derived = self._derivative(kind, by)
        one = derived.compiled.at_one(t, q, v, given)
        if one is not None:
            return derived.named(one[1].reshape(derived.shape))
        states = [(q, self.nq), (v, self.nq)]
        if given is not None:
            states += [(given[0], self.nq), (given[1], self.nc)]
        is_batch, times, rows = self._batch(t, *states)
        _, found = derived.compiled.at(times, rows[0], rows[1], (rows[2], rows[3]) if given else None)
        found = found.reshape(len(times), *derived.shape)
        return derived.named(found if is_batch else found[0])

    def _derivative(self, of: str | tuple[str, ...], by: tuple[str, ...]) -> _Derived:
        key = (of, by)
        if key not in self._derived:
            word, names = (of, []) if isinstance(of, str) else ("", list(of))
            compiled = _bksim.derivatives_of(self._functions, word, names, list(by))

            # The axes of the function, then that of each variable.
            n, m = self.nq, self.nc
            shapes = {"mass_matrix": (n, n), "constraint_jacobian": (m, n), "constraints": (m,)}
            shapes |= {"multipliers": (m,), "residual": (n + m,)}
            shape = shapes.get(of, (n,)) if isinstance(of, str) else (len(of),)
            sizes = {"q": n, "v": n} | ({"a": n, "lam": m} if of == "residual" else {})
            parts: list[tuple[str, slice | int]] = []
            end = 0
            for name in by:
                parts.append((name, slice(end, end + sizes[name]) if name in sizes else end))
                end += sizes.get(name, 1)
            self._derived[key] = _Derived(compiled, (*shape, end), parts)
        return self._derived[key]

    def __repr__(self) -> str:
        return (
            f"<bksim.Functions: {counted(self.nq, 'coordinate', 'coordinates')}, "
            f"{counted(self.nc, 'constraint', 'constraints')}>"
        )
