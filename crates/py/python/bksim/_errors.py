"""Faults as exceptions; those that hold a result are in ``_ended``."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Label:
    """A place in a file: line and column count from one.

    Of a model that was built in code they are those of ``Model.text``, and ``part`` is what stands there:
    ``joints["A"].second``.
    """

    line: int
    column: int
    text: str
    part: str = ""


@dataclass(frozen=True)
class Diagnostic:
    """One fault of a model: ``bksim.explain(diagnostic.code)`` tells the way out."""

    code: str
    severity: str
    message: str
    file: str
    labels: tuple[Label, ...]
    notes: tuple[str, ...]
    help: str | None

    def __str__(self) -> str:
        first = self.labels[0] if self.labels else None
        if first is None:
            place = ""
        elif first.part:
            place = f"{first.part}: "
        else:
            place = f"{self.file}:{first.line}:{first.column}: "
        return f"{place}{self.severity}[{self.code}]: {self.message}"


class Error(Exception):
    """The base of all errors of bksim."""

    def __reduce__(self) -> tuple[Any, ...]:
        # Not by what it was made with, which Exception would take: so that a pool of processes can raise it.
        return _again, (type(self), self.args, self.__dict__)


def _again(kind: type[Error], words: tuple[Any, ...], rest: dict[str, Any]) -> Error:
    error = kind.__new__(kind, *words)
    error.args = words
    error.__dict__.update(rest)
    return error


class _Said(UserWarning):
    """A diagnostic as a warning."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(str(diagnostic))
        self.diagnostic = diagnostic

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.diagnostic,)


class WorthWarning(_Said):
    """A run that went to its end, but whose results are worth less than its tolerances promise, or that took
    far more steps than expected; :attr:`diagnostic` says how much."""


class InputWarning(_Said):
    """An input that is hardly meant as it is written, such as degrees without a unit; :attr:`diagnostic` says what to
    write instead."""


def warn(diagnostics: str, depth: int) -> None:
    """Warns of inputs, given as JSON; the caller is so many functions of the package away."""
    for diagnostic in diagnostics_of(diagnostics):
        warnings.warn(InputWarning(diagnostic), stacklevel=depth + 2)


class ModelError(Error):
    """The model is refused; :attr:`diagnostics` holds every fault."""

    def __init__(self, message: str, diagnostics: tuple[Diagnostic, ...] = ()) -> None:
        super().__init__(message)
        self.diagnostics = diagnostics


class AssemblyError(Error):
    """The mechanism has no consistent start: a loop does not close, or stated values exclude each
    other."""

    def __init__(self, message: str, diagnostics: tuple[Diagnostic, ...] = ()) -> None:
        super().__init__(message)
        self.diagnostics = diagnostics


class LogError(Error):
    """A log cannot be read, or not be played."""


class InternalError(Error):
    """A fault of bksim itself: please report it with the model."""


def diagnostics_of(text: str) -> tuple[Diagnostic, ...]:
    """Diagnostics out of the JSON that the compiled part writes."""

    def one(body: dict[str, Any]) -> Diagnostic:
        labels = tuple(
            Label(at["line"], at["column"], at["text"], at.get("part", "")) for at in body["labels"]
        )
        return Diagnostic(
            code=body["code"],
            severity=body["severity"],
            message=body["message"],
            file=body["file"],
            labels=labels,
            notes=tuple(body["notes"]),
            help=body["help"],
        )

    return tuple(one(body) for body in json.loads(text))
