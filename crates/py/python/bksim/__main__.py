"""The command line: ``bksim``, or ``python -m bksim``."""

import os
import signal
import sys

from ._bksim import command
from ._live import module_path


def main() -> int:
    """Does what the arguments of the process say, and gives its exit status."""
    # Ctrl-C is heard by the command itself, which ends as it does without Python.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Live pages take the module of this package.
    if module_path().is_file():
        os.environ["BKSIM_LIVE"] = str(module_path())
    return command(["bksim", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
