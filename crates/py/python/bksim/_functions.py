"""The compiled functions of the equations, for control, optimisation and integrators of one's own."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _bksim

Array = NDArray[np.float64]


def _compiled(engine: _bksim.Engine) -> Functions:
    return Functions(_bksim.compiled_functions(engine))


class Functions:
    r"""M(q) a + G(q)ᵀ λ = f(t, q, v) with g(t, q) = 0, each part as a function of numbers.

    ``q``, ``v`` and ``a`` have ``nq`` values in the order of ``Model.coordinates``, ``lam`` has ``nc``;
    all of them may have a leading axis, over which the function is evaluated without the interpreter
    lock. ``t`` is a number, or one per state.

    >>> f = load(EXAMPLES / "four-bar" / "model.toml").compile()
    >>> f.mass_matrix(np.zeros((10, f.nq))).shape == (10, f.nq, f.nq)
    True
    """

    def __init__(self, functions: _bksim.Functions) -> None:
        self._functions = functions
        self.nq, self.nc = functions.sizes

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
        is_batch, times, (q,) = self._batch(t, (q, self.nq))
        out = self._functions.mass_matrix(times, q)
        return self._shaped(out, is_batch, self.nq, self.nq)

    def forces(self, t: ArrayLike, q: ArrayLike, v: ArrayLike) -> Array:
        """f, (…, nq): loads, potentials, and what velocities make of inertia, N or N m."""
        is_batch, times, (q, v) = self._batch(t, (q, self.nq), (v, self.nq))
        return self._shaped(self._functions.forces(times, q, v), is_batch, self.nq)

    def constraint_jacobian(self, q: ArrayLike, t: ArrayLike = 0.0) -> Array:
        """G = ∂g/∂q, (…, nc, nq)."""
        is_batch, times, (q,) = self._batch(t, (q, self.nq))
        out = self._functions.constraint_jacobian(times, q)
        return self._shaped(out, is_batch, self.nc, self.nq)

    def constraints(self, t: ArrayLike, q: ArrayLike) -> Array:
        """g, (…, nc): m or rad."""
        is_batch, times, (q,) = self._batch(t, (q, self.nq))
        return self._shaped(self._functions.constraints(times, q), is_batch, self.nc)

    def accelerations(self, t: ArrayLike, q: ArrayLike, v: ArrayLike) -> Array:
        """v̇, (…, nq), which keeps the constraints: m/s² or rad/s²; NaN where there is none."""
        return self.accelerations_and_multipliers(t, q, v)[0]

    def accelerations_and_multipliers(
        self, t: ArrayLike, q: ArrayLike, v: ArrayLike
    ) -> tuple[Array, Array]:
        """v̇, (…, nq), and λ, (…, nc); the smallest λ where it is not unique."""
        is_batch, times, (q, v) = self._batch(t, (q, self.nq), (v, self.nq))
        both = self._functions.accelerations(times, q, v)
        a, lam = both[:, : self.nq], both[:, self.nq :]
        return (a, lam) if is_batch else (a[0], lam[0])

    def residual(
        self, t: ArrayLike, q: ArrayLike, v: ArrayLike, a: ArrayLike, lam: ArrayLike
    ) -> Array:
        """M a + Gᵀ λ − f, then g, (…, nq + nc)."""
        n, m = self.nq, self.nc
        is_batch, times, (q, v, a, lam) = self._batch(t, (q, n), (v, n), (a, n), (lam, m))
        return self._shaped(self._functions.residual(times, q, v, a, lam), is_batch, n + m)

    def __repr__(self) -> str:
        return f"<bksim.Functions: {self.nq} coordinates, {self.nc} constraints>"
