"""The command line: ``bksim``, or ``python -m bksim``."""

import signal
import sys

from ._bksim import command


def main() -> int:
    """Does what the arguments of the process say, and gives its exit status."""
    # Ctrl-C is heard by the command itself, which ends as it does without Python.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return command(["bksim", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
