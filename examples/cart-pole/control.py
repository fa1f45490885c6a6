"""A pole kept upright on its cart by a controller that acts a thousand times a second."""

import sys
import time
from pathlib import Path

import bksim
import numpy as np

PERIOD = 1e-3
"""Period of the controller, s."""

GAINS = np.array([-6.06523955, 53.61549303, -7.70642202, 13.53761468])
"""Of x, θ, and their rates: they place the poles of the linearised motion at −2 ± i and −4 ± i per second."""


def main() -> None:
    model = bksim.load(Path(__file__).with_name("model.toml"))
    run = model.begin()
    begun = time.perf_counter()
    n_periods = 5000
    print(f"{'t, s':>6}  {'x, m':>10}  {'theta, rad':>10}  {'u, N':>10}")
    for k in range(n_periods):
        # The controller reads the state and sets the force, which acts until the next period.
        u = -GAINS @ np.concatenate([run.q, run.v])
        run.set_input("u", u)
        if k % 500 == 0:
            print(f"{run.t:>6.3f}  {run.q[0]:>10.6f}  {run.q[1]:>10.6f}  {u:>10.6f}")
        run.advance_to(PERIOD * (k + 1))
    each = 1e6 * (time.perf_counter() - begun) / n_periods
    print(f"{n_periods} periods, {each:.1f} µs each", file=sys.stderr)


if __name__ == "__main__":
    main()
