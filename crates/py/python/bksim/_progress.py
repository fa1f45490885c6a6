"""How far a run is, where tqdm is installed."""

from __future__ import annotations

import importlib.util
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

DELAY_S = 1.0
"""Shorter runs show no bar unless one is asked for."""


class Progress:
    """A bar over the time of a motion."""

    @staticmethod
    @contextmanager
    def over(
        start: float, end: float, wanted: bool | None
    ) -> Iterator[Callable[[float], None] | None]:
        """What is to be told the time that is reached; nothing without a bar."""
        bar_of = _bars(wanted)
        if bar_of is None:
            yield None
            return
        delay = 0.0 if wanted else DELAY_S
        form = "{l_bar}{bar}| {n:.3g}/{total:.3g} s [{elapsed}<{remaining}]"
        began, bar = time.monotonic(), None

        def notify(t: float) -> None:
            nonlocal bar
            # A notebook keeps each bar that was made, seen or not: short runs make none.
            if bar is None:
                elapsed = time.monotonic() - began
                if elapsed < delay:
                    return
                bar = bar_of(total=abs(end - start), bar_format=form, leave=False)
                bar.start_t -= elapsed
            bar.update(abs(t - start) - bar.n)

        try:
            yield notify
        finally:
            if bar is not None:
                bar.close()


def _bars(wanted: bool | None) -> Any:
    if wanted is False:
        return None
    is_seen = sys.stderr is not None and sys.stderr.isatty() or "ipykernel" in sys.modules
    if wanted is None and not is_seen:
        return None
    try:
        # The notebook's own bar needs more than tqdm.
        if "ipykernel" in sys.modules and importlib.util.find_spec("ipywidgets"):
            from tqdm.notebook import tqdm
        else:
            from tqdm import tqdm
    except ImportError:
        return None
    return tqdm
