"""The quick return in all ways at once: blocks, layers, extended data and a sidecar.

The crank has extended data, the link and the ram are layers, the rod is a block; of the pins three
are circles on BK_JOINTS and one is a block, as are the slot and the guide. The cutting force
is in the sidecar.
"""

import math

from blocks import define
from shapes import (
    angle, bar, base, bearing, centre_line, cross, distance, middle, point, rectangle, sheet, slot,
    stadium,
)

UNIT, TEXT = "mm", 0.01
HEIGHT, CRANK, LINK, ROD, GUIDE = 0.25, 0.1, 0.5, 0.2, 0.48

O, C, G = (0.0, 0.0), (0.0, HEIGHT), (0.0, GUIDE)
P = (CRANK, HEIGHT)
SWING = angle(O, P)
T = point(O, SWING, LINK)
R = (T[0] + math.sqrt(ROD**2 - (GUIDE - T[1]) ** 2), GUIDE)


def draw(pen):
    define(pen, *"BK_BODY BK_POINT BK_REVOLUTE BK_SLOT BK_PRISMATIC BK_DRIVE BK_PARAMETER BK_SOLVE".split())
    for name, colour in [
        ("BK_BODY_link", 142), ("BK_BODY_ram", 202), ("BK_GROUND", 8), ("BK_JOINTS", 5),
    ]:
        pen.doc.layers.add(name, color=colour)
    links(pen)
    joints(pen)
    furniture(pen)


def links(pen):
    crank, *others = bar(pen, C, P, 0.022, 0.009, "OUTLINE")
    pen.attach(crank, ("body", {"name": "crank", "mass": 1.0, "inertia": "1 kg*(0.1 m)^2/12"}))
    for entity in others:
        pen.attach(entity, ("body", {"name": "crank"}))

    # The slotted link, with room for the pin at both ends of its way.
    near, far = HEIGHT - CRANK - 0.01, HEIGHT + CRANK + 0.01
    pen.polyline(stadium(O, T, 0.026), "BK_BODY_link")
    slot(pen, point(O, SWING, near), point(O, SWING, far), 0.012, "BK_BODY_link")
    for p in (O, T):
        pen.circle(p, 0.009, "BK_BODY_link")

    bar(pen, T, R, 0.018, 0.007, "OUTLINE")
    pen.insert(
        "BK_BODY", middle(T, R), name="rod", mass="0.8 kg", inertia="0.8 kg*(0.2 m)^2/12"
    )

    pen.polyline(rectangle(R, 0, 0.2, 0.07), "BK_BODY_ram")
    pen.polyline([(R[0] + 0.1, GUIDE - 0.03, 0), (R[0] + 0.17, GUIDE - 0.012, 0),
                  (R[0] + 0.17, GUIDE + 0.005, 0), (R[0] + 0.1, GUIDE + 0.005, 0)], "OUTLINE")
    pen.circle(R, 0.007, "BK_BODY_ram")


def joints(pen):
    for p in (O, C):
        pen.circle(p, 0.007, "BK_GROUND")
    pins(pen, C=C, O=O)
    pen.insert("BK_POINT", G, name="G", body="ground")
    pen.insert("BK_SLOT", P, SWING, name="slot", body1="link", body2="crank", point1="O")
    pins(pen, T=T)
    pen.insert("BK_REVOLUTE", R, name="R", body1="rod", body2="ram")
    pen.insert(
        "BK_PRISMATIC", R, name="guide", body1="ground", body2="ram", point1="G", point2="R"
    )
    pen.insert("BK_DRIVE", (C[0] - 0.06, C[1]), name="motor", joint="C", motion="speed*t")
    pen.insert("BK_PARAMETER", (-0.35, 0.57), name="speed", value="30 rpm")
    pen.insert("BK_SOLVE", (-0.35, 0.54), t_end="4 s", every="10 ms")


def pins(pen, **positions):
    for name, p in positions.items():
        pen.circle(p, 0.013, "BK_JOINTS")
        pen.text(name, (p[0] - 0.045, p[1] + 0.02), layer="BK_JOINTS")


def furniture(pen):
    bearing(pen, O, 0.035)
    bearing(pen, C, 0.03)
    base(pen, (R[0] - 0.25, GUIDE - 0.035), (R[0] + 0.3, GUIDE - 0.035), 0.015)
    for p in (O, C, P, T, R):
        cross(pen, p, 0.035)
    centre_line(pen, O, T, 0.05)
    centre_line(pen, (R[0] - 0.3, GUIDE), (R[0] + 0.3, GUIDE), 0)
    pen.circle(C, CRANK, "CENTRE")
    pen.dimension(C, O, -0.16)
    pen.dimension(O, T, -0.11)
    sheet(pen, (-0.42, -0.2), (0.86, 0.62), "Slotted-link quick return", "korba 30 obr/min, długości w mm")
