"""The four-bar by layers: outlines on BK_BODY_…, circles and their names on BK_JOINTS.

Masses, gravity, the drive and the solver's options stand in the model file next to it.
"""

import math

from shapes import bar, bearing, centre_line, cross, distance, sheet

UNIT, TEXT = "mm", 0.006
CRANK, COUPLER, ROCKER, TURN = 0.1, 0.3, 0.25, math.radians(60)

A, D = (0.0, 0.0), (0.3, 0.0)
B = (CRANK * math.cos(TURN), CRANK * math.sin(TURN))


def third(p, q, from_p, from_q):
    """The point left of the line from `p` to `q` at these distances from them."""
    d = distance(p, q)
    along = (from_p**2 - from_q**2 + d**2) / (2 * d)
    across = math.sqrt(from_p**2 - along**2)
    x, y = (q[0] - p[0]) / d, (q[1] - p[1]) / d
    return (p[0] + along * x - across * y, p[1] + along * y + across * x)


C = third(B, D, COUPLER, ROCKER)


def draw(pen):
    for name, colour in [
        ("BK_BODY_crank", 30), ("BK_BODY_coupler", 142), ("BK_BODY_rocker", 202), ("BK_GROUND", 8),
        ("BK_JOINTS", 5),
    ]:
        pen.doc.layers.add(name, color=colour)
    bar(pen, A, B, 0.012, 0.005, "BK_BODY_crank")
    bar(pen, B, C, 0.011, 0.005, "BK_BODY_coupler")
    bar(pen, D, C, 0.012, 0.005, "BK_BODY_rocker")
    for p in (A, D):
        bearing(pen, p, 0.018)
        pen.circle(p, 0.004, "BK_GROUND")
    for name, p in {"A": A, "B": B, "C": C, "D": D}.items():
        pen.circle(p, 0.008, "BK_JOINTS")
        pen.text(name, (p[0] - 0.022, p[1] + 0.011), layer="BK_JOINTS")
        cross(pen, p, 0.02)
    furniture(pen)


def furniture(pen):
    for p, q in [(A, B), (B, C), (D, C)]:
        centre_line(pen, p, q, 0.02)
    pen.dimension(A, D, -0.075)
    pen.dimension(A, B, 0.035)
    pen.dimension(B, C, 0.04)
    pen.dimension(C, D, 0.045)
    pen.arc(A, 0.035, 0, TURN, "DIMENSIONS")
    sheet(pen, (-0.1, -0.13), (0.42, 0.32), "Four-bar linkage", "pręty 24 x 10, sworznie 10, mm")
