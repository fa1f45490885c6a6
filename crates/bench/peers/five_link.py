"""The five-link mechanism of src/mechanisms.rs, for all peers: numbers, and error at the samples.

Links 1 and 5 turn about fixed pivots, so only the product of mass and distance and the moment about
the pivot matter. The published numbers leave a negative moment about the centre of mass, which no
program takes: mass and distance are replaced by others with the same two products.
"""

import math

GRAVITY, TORQUE = 9.8, 500.0
L1, S2, S4, L5 = 25.0, 50.0, 12.5, 100.0
H = (103.0, -99.0)

# mass, distance of the centre of mass from the pivot, moment about the centre of mass
LINK1 = (250.0, 0.05, 1 - 250 * 0.05**2)
LINK5 = (5000.0, 0.01, 1 - 5000 * 0.01**2)


def start(rows):
    """Angles of links 1, 2, 4 and 5 at the start."""
    return rows[0]["angles"]


def error(found, rows):
    """Largest error of the four angles over all samples, rad."""
    worst = 0.0
    for angles, row in zip(found, rows, strict=True):
        for angle, reference in zip(angles, row["angles"], strict=True):
            worst = max(worst, abs(math.remainder(angle - reference, 2 * math.pi)))
    return worst
