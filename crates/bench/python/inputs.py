"""What a torque costs that is a function of Python, beside the same torque written in the model.

    python crates/bench/python/inputs.py [--runs 50]

CPU times, the least of the runs, alternating.
"""

from __future__ import annotations

import argparse
import math
import time

import bksim

MODEL = """
[parameters]
u = "0 N m"

[bodies.arm]
mass = "2 kg"
com = ["0.5 m", 0]
inertia = "0.1 kg m^2"

[joints.A]
type = "revolute"
between = ["ground", "arm"]
coordinate = "theta"

[loads]
gravity = { type = "gravity", acceleration = [0, "-9.81 m/s^2"] }
motor = { type = "torque", on = "arm", value = "LAW" }

[solve]
t_end = "2 s"
rtol = 1e-8
"""
WRITTEN = "9.81 N m - 40 N m*(theta - 0.5) - 5 N m s*theta_dot + 1 N m*sin(3*t/(1 s))"


def control(t, q, v):
    return 9.81 - 40 * (q[0] - 0.5) - 5 * v[0] + math.sin(3 * t)


def cpu(model: bksim.Model) -> float:
    begun = time.process_time()
    model.solve(progress=False)
    return time.process_time() - begun


def n_calls(model: bksim.Model) -> int:
    """How often one solve calls the function."""
    calls = []
    model.inputs["u"] = lambda t, q, v: calls.append(t) or control(t, q, v)
    model.assemble()
    calls.clear()
    model.solve(progress=False)
    model.inputs["u"] = control
    return len(calls)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=50)
    runs = parser.parse_args().runs
    written = bksim.loads(MODEL.replace("LAW", WRITTEN))
    function = bksim.loads(MODEL.replace("LAW", "u"))
    calls = n_calls(function)
    # The first of each derives the equations.
    times = [(cpu(written), cpu(function)) for _ in range(runs + 1)][1:]
    own, called = (min(column) for column in zip(*times))
    print(f"in the model        {own * 1e3:.3f} ms")
    print(f"a function          {called * 1e3:.3f} ms, {called / own:.1f} times that")
    print(f"calls of a solve    {calls}, {(called - own) / calls * 1e6:.2f} us each")


if __name__ == "__main__":
    main()
