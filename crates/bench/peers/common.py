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


def race(request, build, run, measured, evaluate, n_calls):
    """Runs a machine at all sizes, step sizes in s or tolerances: what is measured at the end, CPU seconds of each run,
    until it is built, and of an evaluation; that of a step where `evaluate` is None."""
    runs, ready, evaluation = [], 0.0, 0.0
    for size in request["sizes"]:
        (ready,), machine = samples(1, lambda: None, lambda _, size=size: build(request, size))
        (seconds,), steps = samples(1, lambda: machine, lambda machine, size=size: run(machine, request, size))
        runs.append({"size": size, "seconds": seconds, "measured": [float(x) for x in measured(machine)]})
        evaluation = seconds / steps if steps else 0.0
    if evaluate is not None:
        times, _ = samples(3, lambda: machine, lambda machine: [evaluate(machine) for _ in range(n_calls)])
        evaluation = min(times) / n_calls
    write({"runs": runs, "ready_s": ready, "evaluation_s": evaluation})
