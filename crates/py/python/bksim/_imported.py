"""What `bksim import` answers."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ._errors import ModelError, diagnostics_of


def imported(source: str, arguments: Iterable[str]) -> dict[str, Any]:
    """The answer of the command about a file, with its faults as exceptions."""
    command = [sys.executable, "-m", "bksim", "import", source, "--json", *arguments]
    # The same package again, from wherever this one was taken.
    around = os.pathsep.join([str(Path(__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": around})
    answer: dict[str, Any] = json.loads(done.stdout)
    if done.returncode == 0:
        return answer
    if "diagnostics" in answer:
        faults = diagnostics_of(json.dumps(answer["diagnostics"]))
        raise ModelError("\n".join(str(fault) for fault in faults), faults)
    if done.returncode == 4:
        raise OSError(answer["message"])
    raise ValueError(answer["message"])
