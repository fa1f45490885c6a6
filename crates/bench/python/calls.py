"""Cost of a call of a compiled function at one state from Python.

    python crates/bench/python/calls.py
    valgrind --tool=callgrind python crates/bench/python/calls.py --only measure --number 20000

The first prints microseconds, the least of five rounds; the second counts instructions, of which two runs of different
numbers of calls leave those of the calls.
"""

from __future__ import annotations

import argparse
import timeit

import bksim
import numpy as np


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", metavar="CALL", help="this call alone, once so often as --number says")
    parser.add_argument("--number", type=int, default=20_000)
    args = parser.parse_args()
    m = bksim.example("slider-crank")
    f, sol = m.compile(), m.solve(t_end=0.1, progress=False)
    q, v, a, lam = (np.ascontiguousarray(x[:, -1]) for x in (sol.q, sol.v, sol.a, sol.lam))
    points = ["rod.B.x", "rod.B.y"]
    calls = {
        "mass_matrix": lambda: f.mass_matrix(q),
        "constraint_jacobian": lambda: f.constraint_jacobian(q),
        "constraints": lambda: f.constraints(0.0, q),
        "forces": lambda: f.forces(0.0, q, v),
        "accelerations": lambda: f.accelerations(0.0, q, v),
        "residual": lambda: f.residual(0.0, q, v, a, lam),
        "measure": lambda: f.measure(points, q, v),
        "measure a reaction": lambda: f.measure("reactions.B.fx", q, v),
        "derivatives of points": lambda: f.derivatives(points, 0.0, q, v, by="q"),
        "derivatives of accelerations": lambda: f.derivatives("accelerations", 0.0, q, v),
    }
    for name, call in calls.items():
        if args.only in (None, name):
            call()
            rounds = timeit.repeat(call, number=args.number, repeat=1 if args.only else 5)
            print(f"{name:30} {min(rounds) / args.number * 1e6:7.2f} µs")


if __name__ == "__main__":
    main()
