"""What all peers share: JSON in, JSON out, CPU times."""

import json
import sys
import time


def read():
    """The input of this run."""
    return json.load(sys.stdin)


def write(result):
    """The result of this run."""
    json.dump(result, sys.stdout)


def package(name):
    """Imports a package, or says that it is missing and ends the run."""
    try:
        return __import__(name)
    except ImportError:
        write({"missing": f"the Python package {name}"})
        sys.exit(0)


def samples(runs, prepare, work):
    """CPU seconds of each run; what `prepare` returns is not timed. Also the last result."""
    times, result = [], None
    for _ in range(runs):
        state = prepare()
        start = time.process_time()
        result = work(state)
        times.append(time.process_time() - start)
    return times, result
