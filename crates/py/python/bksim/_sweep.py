"""One mechanism at many values: on all cores here, or on a cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from . import _bksim
from ._cluster import parts_done
from ._checked import names, pairs, path, real, whole
from ._progress import DELAY_S, _bars
from ._swept import About, Again, Failure, InFile, InMemory, Sweep
from ._words import Design, Formulation, Method

if TYPE_CHECKING:
    from ._model import Model

__all__ = ["Failure", "Sweep", "sweep"]

Axis: TypeAlias = "str | ArrayLike | Sequence[str]"
Notify: TypeAlias = Callable[[int], None]


def sweep(
    model: Model,
    axes: Mapping[str, Axis] | None = None,
    *,
    outputs: str | Sequence[str] | None = None,
    design: Design = "grid",
    n: int | None = None,
    seed: int = 0,
    t_end: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    step: float | None = None,
    every: float | None = None,
    method: Method | None = None,
    formulation: Formulation | None = None,
    compliance: Mapping[str, str | Sequence[str]] | None = None,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    jobs: int = 0,
    executor: Any = None,
    progress: bool | None = None,
) -> Sweep:
    """Solves a model at many values of its parameters and stated initial values.

    ``axes`` are values by name (``l1``, ``A.rate``): numbers in SI, or a text as the command line
    takes it, ``"80 mm:120 mm:41"``. They make a grid, the last one turning fastest; with the design
    ``"pairs"`` a case takes one value of each, so that a table of trials is swept row by row. The designs
    ``"random"``, ``"latin-hypercube"`` and ``"sobol"`` take ``n`` samples: of a tuple ``(low, high)``
    anything between, of a list its values, and without ``axes`` the ranges below ``[ranges]`` of the model. ``outputs`` are numbers of each run, ``final(state.x)``,
    ``min``, ``max``, ``mean``, ``rms``, ``peak_to_peak`` of any column of a solution, ``"state.x@0.5"`` its
    value at 0.5 s, ``quantile(x, 0.95)``, ``first(x > 1 m)``, of expressions and in expressions, as
    ``max(hypot(reactions.B.fx, reactions.B.fy))/m``; unless given, the final, smallest and largest value of every coordinate. ``t_end`` to
    ``compliance`` are those of :meth:`Model.solve`.

    The equations are derived and compiled once. A row is what ``solve`` gives at its values, to the
    last bit; a case that fails is a row with its reason.

    ``out`` names a file of Parquet that rows stream to, so that memory stays flat and an interrupted
    sweep goes on: ``resume=True`` does the parts that are missing, and nothing when the file is there
    already; ``overwrite=True`` begins anew.

    ``jobs`` is how many threads there are, one per core for 0. ``executor`` is a client of Dask, or
    anything else with ``submit``: it is sent the text of the model and numbers of cases, and each of
    its tasks takes ``jobs`` threads, one for 0. Workers need this version of bksim.

    Ctrl-C ends a sweep within a fifth of a second. The KeyboardInterrupt has the rows so far as
    ``result``, unless they are in parts of a file.

    Raises ModelError for faults of the model, the axes and the outputs; FileExistsError when ``out``
    is there and neither ``resume`` nor ``overwrite`` says what to do; ValueError for options that make
    no sense.
    """
    is_sampled = design not in ("grid", "pairs")
    if not is_sampled and n is not None:
        raise ValueError(f"n is a number of samples, and design = {design!r} has none: name a design")
    if is_sampled and n is None:
        raise ValueError(f"design = {design!r} needs n, the number of samples")
    if out is None and (resume or overwrite):
        raise ValueError("resume and overwrite are about a file: name it as out")
    if resume and overwrite:
        raise ValueError("resume goes on with a sweep, overwrite begins anew: give one of them")
    if jobs < 0:
        raise ValueError(f"jobs = {jobs}: give how many threads, 0 for one per core")
    if model.inputs:
        words = "functions of Python, and cases run without it"
        raise ValueError(f"the inputs {', '.join(model.inputs)} are {words}: take them off for a sweep")
    asked = _asked(model, axes or {}, design)
    asked.update(
        n=None if n is None else whole("n", n),
        seed=whole("seed", seed),
        outputs=names("outputs", outputs),
        t_end=real("t_end", t_end),
        rtol=real("rtol", rtol),
        atol=real("atol", atol),
        step=real("step", step),
        every=real("every", every),
        method=method,
        formulation=formulation,
        compliance=pairs(compliance),
    )
    study = _bksim.Study.prepare(asked)
    about = About.of(study, asked["outputs"])
    again = Again(model.copy(), asked)
    sent = None if executor is None else (executor, asked, max(jobs, 1))
    with _told(about.n_cases, progress) as notify:
        if out is None:
            return _in_memory(study, about, again, jobs, sent, notify)
        existing = "replace" if overwrite else "resume" if resume else "refuse"
        file = path(out, [".parquet"], "sweeps are written as Parquet")
        return _in_file(study, about, again, file, existing, jobs, sent, notify)


_Sent: TypeAlias = "tuple[Any, _bksim._Swept, int] | None"
"""An executor, what it is sent, and threads per task."""


def _in_memory(
    study: _bksim.Study,
    about: About,
    again: Again,
    jobs: int,
    sent: _Sent,
    notify: Notify | None,
) -> Sweep:
    blocks: dict[int, _bksim._Block] = {}
    stopped: BaseException | None = None
    parts = list(range(study.n_parts))
    n_kept = 0
    if sent is None:
        done, stopped = study.blocks(parts, jobs, notify)
        blocks = {part: block for part, block in zip(parts, done, strict=True) if block is not None}
    else:
        try:
            for part, block in parts_done(study, *sent, "blocks", parts):
                blocks[part] = block
                n_kept += len(block[0])
                _tell(notify, n_kept)
        except KeyboardInterrupt as interrupt:
            stopped = interrupt
    rows = InMemory(about, [blocks[part] for part in sorted(blocks)])
    result = Sweep(about, rows, again)
    if stopped is None:
        return result
    words = f"interrupted: {len(result)} of {about.n_cases} cases are in the result of this exception"
    raise _interrupt(stopped, f"{words}; with out= a sweep can be resumed", result)


def _in_file(
    study: _bksim.Study,
    about: About,
    again: Again,
    path: Path,
    existing: str,
    jobs: int,
    sent: _Sent,
    notify: Notify | None,
) -> Sweep:
    result = Sweep(about, InFile(about, path), again)
    if existing == "resume" and study.is_whole(path):
        return result
    has_parts = path.with_name(f"{path.name}.parts").exists()
    if path.exists() and existing != "replace" and not (existing == "resume" and has_parts):
        what = "is not this sweep" if existing == "resume" else "is there already"
        raise FileExistsError(f"`{path}` {what}: overwrite=True replaces it, or name another")
    stopped: BaseException | None = None
    if sent is None:
        is_whole, n_kept, stopped = study.write(path, existing, jobs, notify)
    else:
        missing = study.open_parts(path, existing)
        n_missing = sum(_n_cases(study, part) for part in missing)
        n_kept = about.n_cases - n_missing
        try:
            for part, table in parts_done(study, *sent, "tables", missing):
                study.put_part(path, part, table)
                n_kept += _n_cases(study, part)
                _tell(notify, n_kept)
            study.join_parts(path)
        except KeyboardInterrupt as interrupt:
            stopped = interrupt
        is_whole = stopped is None
    if stopped is None:
        return result
    words = f"interrupted: {n_kept} of {about.n_cases} cases are kept"
    how = f"{words}; the same call with resume=True goes on"
    raise _interrupt(stopped, how, result if is_whole else None)


def _n_cases(study: _bksim.Study, part: int) -> int:
    first, end = study.cases_of(part)
    return end - first


def _interrupt(stopped: BaseException, words: str, result: Sweep | None) -> BaseException:
    """What ends an interrupted sweep: a KeyboardInterrupt that tells what to do, or whatever a handler
    of signals has raised."""
    if isinstance(stopped, KeyboardInterrupt):
        stopped = KeyboardInterrupt(words)
    stopped.result = result  # type: ignore[attr-defined]
    return stopped


def _asked(model: Model, axes: Mapping[str, Axis], design: str) -> Any:
    """Model and axes, plain enough to be sent."""
    text, path, name = model._text()
    engine = model._engine()
    is_sampled = design not in ("grid", "pairs")
    return {
        "text": text,
        "path": path,
        "name": name,
        "fixed": [(key, value) for key, value in model._overrides.items() if key not in axes],
        "axes": [_axis(engine, key, values, is_sampled) for key, values in axes.items()],
        "design": design,
        "jit": model._jit,
    }


def _axis(
    engine: _bksim.Engine, name: str, values: Axis, is_sampled: bool
) -> tuple[str, str, str, list[float]]:
    if isinstance(values, str):
        return name, "text", values, []
    is_range = is_sampled and isinstance(values, tuple) and len(values) == 2
    if isinstance(values, (list, tuple)):
        texts = [value for value in values if isinstance(value, str)]
        if texts and len(texts) == len(values):
            return name, "text", (":" if is_range else ",").join(texts), []
    try:
        numbers = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError) as error:
        raise ValueError(f"the axis {name!r} takes numbers in SI, or texts: {error}") from error
    if numbers.ndim != 1:
        raise ValueError(f"the axis {name!r} has values of shape {numbers.shape}: give one row")
    unit = _bksim.si_unit(engine, name) or ""
    return name, "range" if is_range else "list", unit, numbers.tolist()


@contextmanager
def _told(n_cases: int, wanted: bool | None) -> Iterator[Notify | None]:
    """What is to be told how many cases have ended; nothing without a bar."""
    bar_of = _bars(wanted)
    if bar_of is None:
        yield None
        return
    delay = 0.0 if wanted else DELAY_S
    with bar_of(total=n_cases, delay=delay, unit="case", unit_scale=True, leave=False) as bar:

        def notify(n_ended: int) -> None:
            bar.update(n_ended - bar.n)

        yield notify


def _tell(notify: Notify | None, n_ended: int) -> None:
    if notify is not None:
        notify(n_ended)
