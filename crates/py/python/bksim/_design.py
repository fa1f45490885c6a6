"""Mechanisms from what they are to do: optima, fits to measurements, tolerances, synthesis."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _bksim
from ._frames import columns_of

if TYPE_CHECKING:
    from ._model import Model

__all__ = ["Design", "fit", "optimize", "synthesize", "tolerance"]


class Design(dict[str, Any]):
    """The answer to a question of design: the object of ``--json``, and the texts of models that it gives.

    ``model_text`` is the model with the values that were found; ``models`` are those of all linkages, by name.
    """

    def __init__(self, answer: Mapping[str, Any], models: Mapping[str, str]) -> None:
        super().__init__(answer)
        self.models = dict(models)

    @property
    def model_text(self) -> str | None:
        """The text of the first model; of tolerances, if results keep theirs."""
        return next(iter(self.models.values()), None)


def optimize(
    model: Model | str | os.PathLike[str],
    *,
    minimize: str | Sequence[str] | None = None,
    maximize: str | None = None,
    vary: Mapping[str, Sequence[str | float]] | None = None,
    subject_to: Sequence[str] | None = None,
    over: str | None = None,
    cases: Mapping[str, Mapping[str, str | float]] | None = None,
    starts: int | None = None,
    choose: Mapping[str, Mapping[str, Mapping[str, str | float]]] | None = None,
    points: int | None = None,
    resume: Mapping[str, Any] | None = None,
) -> Design:
    """Finds values of parameters for which a number of a mechanism is least or largest.

    ``model`` is a model, its text, or the path of its file. Without arguments the question is its section
    ``[optimize]``; with any, they are the whole question. ``resume`` is an earlier answer to the same question: the search
    goes on from where its starts are, that for a front after its last finished point.

    Raises ModelError for faults of the model or the question, and where nothing meets the conditions.
    """
    front = None if resume is None else resume.get("unfinished")
    ends = None if resume is None or front else resume["ends"]
    question = {
        "minimize": minimize,
        "maximize": maximize,
        "vary": vary,
        "subject_to": subject_to,
        "over": over,
        "cases": cases,
        "starts": starts if ends is None else 0,
        "choose": choose,
        "points": points,
        "from": None if ends is None else [end["quantities"] for end in ends],
    }
    earlier: list[tuple[str, str, list[tuple[str, str]]]] = [("front", json.dumps(front), [])] if front else []
    return _answer("optimize", model, question, earlier)


def fit(
    model: Model | str | os.PathLike[str],
    data: Any,
    *,
    vary: Sequence[str] | Mapping[str, str | float] | None = None,
    unknowns: Mapping[str, str | float] | None = None,
    compare: Mapping[str, str] | None = None,
    drive: Mapping[str, str] | None = None,
    sigma: Mapping[str, str | float] | None = None,
    delay: Mapping[str, str] | None = None,
    loss: str | None = None,
    scale: float | None = None,
) -> Design:
    """Finds parameters, initial values and unknowns of sensors from measured curves.

    ``data`` is the path of a table, its text, columns by their headings, ``{"t [s]": t, "theta [deg]": theta}``, or a data
    frame of pandas or Polars, a dataset of xarray or a table of Arrow, with headings of that kind or units of its own;
    a list of them is several runs, and ``(table, {"m": "2 kg"})`` one with other values of parameters. Without
    further arguments the question is the section ``[fit]`` of the model.

    Raises ModelError for faults of the model, the question or the data.
    """
    question = {
        "vary": vary,
        "unknowns": unknowns,
        "compare": compare,
        "drive": drive,
        "sigma": sigma,
        "delay": delay,
        "loss": loss,
        "scale": scale,
    }
    runs = data if isinstance(data, list) else [data]
    return _answer("fit", model, question, [_measured(run, k + 1) for k, run in enumerate(runs)])


def tolerance(
    model: Model | str | os.PathLike[str],
    *,
    of: str | Sequence[str] | None = None,
    limits: Mapping[str, Any] | None = None,
    at: Mapping[str, str | float] | None = None,
    distribution: str | None = None,
    samples: int | None = None,
    seed: int | None = None,
    play: Mapping[str, str] | None = None,
    keep: Mapping[str, str] | None = None,
    weights: Mapping[str, float] | None = None,
    by: str | None = None,
) -> Design:
    """Finds what limits of lengths do to positions: slopes, proved bounds, samples.

    Without arguments the question is the section ``[tolerance]`` of the model. ``play`` has pins by the names of their
    joints: how far the centres of pin and hole come apart. With ``keep``, results with the limits that they are to keep,
    the limits of the parts follow as the cheapest, ``model_text`` has them, and ``cheapest`` of the answer says what they cost.

    Raises ModelError for faults of the model or the question, and for poses that are not reached.
    """
    question = {
        "of": of,
        "limits": limits,
        "at": at,
        "distribution": distribution,
        "samples": samples,
        "seed": seed,
        "play": play,
        "keep": keep,
        "weights": weights,
        "by": by,
    }
    return _answer("tolerance", model, question, [])


def synthesize(task: str | os.PathLike[str] | None = None, **keys: Any) -> Design:
    """Finds linkages for a task, each a model that solves.

    ``task`` is the path or the text of a task, or its name with its keys: ``synthesize("quick_return",
    time_ratio=1.6, ground="300 mm", stroke="250 mm")``.

    >>> import bksim
    >>> lever = bksim.synthesize("quick_return", time_ratio=1.6, ground=0.3, stroke=0.25)
    >>> round(lever["candidates"][0]["numbers"]["crank"], 6)
    0.106381

    Raises ModelError for a task that cannot be read, or that no linkage does.
    """
    if keys:
        return _answer("synthesize", "\n", {"task": task, **keys}, [])
    text, name = _text_of(task if task is not None else "\n")
    return _found("synthesize", text, name, None, [])


def _answer(
    kind: str,
    model: Model | str | os.PathLike[str],
    question: Mapping[str, Any],
    data: list[tuple[str, str, list[tuple[str, str]]]],
) -> Design:
    text, name = _text_of(model)
    stated = {key: value for key, value in question.items() if value is not None}
    section = None
    if stated:
        lines = [f"{json.dumps(key)} = {_written(value)}" for key, value in stated.items()]
        section = "\n".join([f"[{kind}]", *lines, ""])
    return _found(kind, text, name, section, data)


def _found(
    kind: str,
    text: str,
    name: str,
    section: str | None,
    data: list[tuple[str, str, list[tuple[str, str]]]],
) -> Design:
    answer, models = _bksim.design_answer(kind, text, name, section, data)
    return Design(json.loads(answer), dict(models))


def _text_of(model: Any) -> tuple[str, str]:
    if isinstance(model, str) and "\n" in model:
        return model, "model"
    if isinstance(model, (str, os.PathLike)):
        path = Path(model)
        return path.read_text(encoding="utf-8"), path.stem
    return model.text, model.name


def _written(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, Mapping):
        pairs = [f"{json.dumps(str(key))} = {_written(of)}" for key, of in value.items()]
        return "{ " + ", ".join(pairs) + " }"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    # Arrays and numbers of NumPy have lists and numbers in them.
    items: Any = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(items, (list, tuple)):
        return "[" + ", ".join(_written(item) for item in items) + "]"
    return repr(float(items))


def _measured(run: Any, number: int) -> tuple[str, str, list[tuple[str, str]]]:
    """A run with its data as a table in text."""
    values: Mapping[str, str | float] = {}
    if isinstance(run, tuple):
        run, values = run
    of_run = [(name, str(value)) for name, value in values.items()]
    found = columns_of(run)
    if found is not None:
        columns = [list(column) for column in found.values()]
        rows = [",".join(repr(float(cell)) for cell in row) for row in zip(*columns, strict=True)]
        return f"run {number}", "\n".join([",".join(found), *rows, ""]), of_run
    text, name = _text_of(run)
    return name, text, of_run
