"""Parts of a sweep on the workers of an executor: Dask's, or one of ``concurrent.futures``.

What is sent is the text of the model with what is asked of it, and numbers of parts. A worker derives
and compiles the equations once and keeps them.
"""

from __future__ import annotations

import os
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Iterator, Sequence
from queue import Empty, SimpleQueue
from typing import Any

from . import _bksim

TASK_S = 1.0
"""How long a task is to take: what it costs to send one, some milliseconds, is nothing beside it."""

TASKS_PER_SLOT = 4
"""At least so many tasks for each that can run at a time, so that all end together."""

IN_FLIGHT = 1024
"""Tasks that are sent ahead of their results, so that neither side holds all of a large sweep."""

KEPT = 4
"""Studies that a worker keeps."""

_studies: OrderedDict[str, _bksim.Study] = OrderedDict()
_lock = threading.Lock()


def _study(asked: _bksim._Swept, fingerprint: str) -> _bksim.Study:
    """The study of a sweep, prepared by the first task of it in this process."""
    with _lock:
        study = _studies.get(fingerprint)
        if study is None:
            study = _bksim.Study.prepare(asked)
            if study.fingerprint != fingerprint:
                words = f"bksim {_bksim.__version__} of this worker is not that of the sweep"
                raise RuntimeError(f"{words}: install the same version everywhere")
            _studies[fingerprint] = study
            if len(_studies) > KEPT:
                _studies.popitem(last=False)
        _studies.move_to_end(fingerprint)
        return study


def work(
    asked: _bksim._Swept, fingerprint: str, form: str, parts: list[int], jobs: int
) -> tuple[float, list[Any]]:
    """What a worker does: the parts as ``blocks`` or ``tables``, and how long it took, s."""
    study = _study(asked, fingerprint)
    begun = time.perf_counter()
    done: Sequence[Any]
    if form == "tables":
        done, stopped = study.tables(parts, jobs, None)
    else:
        done, stopped = study.blocks(parts, jobs, None)
    if stopped is not None:
        raise stopped
    return time.perf_counter() - begun, list(done)


def _slots(executor: Any) -> int:
    """How many tasks can run at a time."""
    if hasattr(executor, "nthreads"):
        return max(int(sum(executor.nthreads().values())), 1)
    return int(getattr(executor, "_max_workers", 0) or os.cpu_count() or 1)


def parts_done(
    study: _bksim.Study,
    executor: Any,
    asked: _bksim._Swept,
    jobs: int,
    form: str,
    parts: Sequence[int],
) -> Iterator[tuple[int, Any]]:
    """Parts as they are done, in any order."""
    fingerprint = study.fingerprint
    n_slots = _slots(executor)
    waiting = deque(parts)
    flying: dict[Any, list[int]] = {}
    done: SimpleQueue[Any] = SimpleQueue()
    # One part each tells how long parts take.
    size, most = 1, n_slots

    def send() -> None:
        while waiting and len(flying) < most:
            group = [waiting.popleft() for _ in range(min(size, len(waiting)))]
            future = executor.submit(work, asked, fingerprint, form, group, jobs)
            flying[future] = group
            future.add_done_callback(done.put)

    try:
        send()
        while flying:
            try:
                # Not forever, so that Ctrl-C is heard everywhere.
                future = done.get(timeout=0.05)
            except Empty:
                continue
            group = flying.pop(future)
            seconds, values = future.result()
            if most != IN_FLIGHT:
                fair = -(-len(waiting) // (TASKS_PER_SLOT * n_slots))
                size = max(1, min(int(TASK_S / max(seconds / len(group), 1e-9)), fair))
                most = IN_FLIGHT
            send()
            yield from zip(group, values, strict=True)
    finally:
        for future in flying:
            future.cancel()
