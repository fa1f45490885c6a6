"""How far a run is, where tqdm is installed."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from . import _bksim

DELAY_S = 1.0
"""Shorter runs show no bar unless one is asked for."""


class Progress:
    """A bar over the time of a run."""

    @staticmethod
    @contextmanager
    def over(
        engine: _bksim.Engine, t_end: float | None, wanted: bool | None
    ) -> Iterator[Callable[[float], None] | None]:
        """What is to be told the time that is reached; nothing without a bar."""
        bar_of = _bars(wanted)
        if bar_of is None:
            yield None
            return
        start, end = engine.options()[:2]
        last = end if t_end is None else t_end
        delay = 0.0 if wanted else DELAY_S
        form = "{l_bar}{bar}| {n:.3g}/{total:.3g} s [{elapsed}<{remaining}]"
        with bar_of(total=abs(last - start), delay=delay, bar_format=form, leave=False) as bar:

            def notify(t: float) -> None:
                bar.update(abs(t - start) - bar.n)

            yield notify


def _bars(wanted: bool | None) -> Any:
    if wanted is False:
        return None
    is_seen = sys.stderr is not None and sys.stderr.isatty() or "ipykernel" in sys.modules
    if wanted is None and not is_seen:
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm
