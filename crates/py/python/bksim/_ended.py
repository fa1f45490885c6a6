"""Runs that ended early, as exceptions with what there is; the compiled part makes its exceptions here, by
:func:`made`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ._errors import (
    AssemblyError,
    Diagnostic,
    Error,
    InternalError,
    LogError,
    ModelError,
    diagnostics_of,
)

if TYPE_CHECKING:
    from ._solution import Solution


class SolverError(Error):
    """The integrator could not go on.

    :attr:`t` is the last instant, s; :attr:`reason` says why; :attr:`result` is the solution up to
    there, if one was asked for.
    """

    def __init__(
        self,
        message: str,
        t: float,
        reason: str,
        result: Solution | None,
        diagnostics: tuple[Diagnostic, ...] = (),
    ) -> None:
        super().__init__(message)
        self.t = t
        self.reason = reason
        self.result = result
        self.diagnostics = diagnostics


class LimitError(Error):
    """More was asked for than there may be; :attr:`result` is what there is, if a run has begun."""

    def __init__(self, message: str, result: Solution | None = None) -> None:
        super().__init__(message)
        self.result = result


def made(kind: str, message: str, diagnostics: str) -> Error:
    """The exception of a kind that the compiled part names."""
    if kind == "model":
        return ModelError(message, diagnostics_of(diagnostics))
    if kind == "assembly":
        return AssemblyError(message, diagnostics_of(diagnostics))
    if kind == "limit":
        return LimitError(message)
    if kind == "log":
        return LogError(message)
    if kind == "drawing":
        return Error(message)
    return InternalError(message)


def stopped(t: float, message: str, diagnostics: str) -> SolverError:
    """The exception of a motion that cannot go on."""
    faults = diagnostics_of(diagnostics)
    return SolverError(message, t, faults[0].message, None, faults)
