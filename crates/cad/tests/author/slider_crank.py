"""The slider-crank by blocks with attributes alone, drawn at a crank angle of 50 degrees.

The frames of the links stand in their middles; that the motion begins with the crank lying is
stated at its joint.
"""

import math

from blocks import define
from shapes import angle, bar, base, bearing, centre_line, cross, middle, point, rectangle, sheet

UNIT, TEXT = "mm", 0.06
L1, L2, TURN = 1.0, 3.0, math.radians(50)

A = (0.0, 0.0)
B = (L1 * math.cos(TURN), L1 * math.sin(TURN))
C = (B[0] + math.sqrt(L2**2 - B[1] ** 2), 0.0)


def draw(pen):
    define(pen, *"""BK_GROUND BK_BODY BK_FRAME BK_COM BK_REVOLUTE BK_PRISMATIC BK_GRAVITY BK_TORQUE
        BK_PARAMETER BK_SOLVE""".split())
    parts(pen)
    bodies(pen)
    joints(pen)
    numbers(pen)


def parts(pen):
    """What the designer drew."""
    bar(pen, A, B, 0.12, 0.04, "OUTLINE")
    bar(pen, B, C, 0.1, 0.04, "OUTLINE", pins=[C])
    pen.polyline(rectangle(C, 0, 0.7, 0.4), "OUTLINE")
    bearing(pen, A, 0.18)
    base(pen, (C[0] - 1.4, -0.2), (C[0] + 1.0, -0.2), 0.1)
    for p in (A, B, C):
        cross(pen, p, 0.2)
    centre_line(pen, A, B, 0.25)
    centre_line(pen, B, C, 0.25)
    centre_line(pen, A, C, 0.6)
    pen.dimension(A, B, 0.45)
    pen.dimension(B, C, 0.45)
    sheet(pen, (-1.1, -1.25), (5.0, 1.9), "Slider-crank", "tłok 20 kg, korba i łącznik 5 kg, mm")


def bodies(pen):
    pen.insert("BK_BODY", middle(A, B), name="crank", mass="m1", inertia="i1", about="A")
    pen.insert(
        "BK_BODY", middle(B, C),
        name="rod", mass="m2", inertia="i2", coordinates="x2, y2, theta2",
    )
    pen.insert("BK_FRAME", middle(B, C), angle(B, C), body="rod")
    # Next to the rod's end: there its insertion point is in the slider alone.
    pen.insert("BK_BODY", point(C, 0, 0.22, 0.13), name="slider", mass="m3", inertia="0")
    pen.insert("BK_COM", C, body="slider")
    pen.insert("BK_GROUND", A)


def joints(pen):
    pen.insert("BK_REVOLUTE", A, name="A", coordinate="theta1", angle="0", rate="0")
    pen.insert("BK_REVOLUTE", C, name="C", body1="rod", body2="slider", cut="true")
    pen.insert("BK_REVOLUTE", B, name="B", cut="true")
    pen.insert(
        "BK_PRISMATIC", point(C, 0, 0, -0.2),
        name="D", body1="ground", body2="slider", point1="A", point2="C", coordinate="x3",
    )


def numbers(pen):
    pen.insert("BK_GRAVITY", (4.5, 1.6), name="gravity", acceleration="g")
    pen.insert("BK_TORQUE", point(A, TURN, 0.3), name="motor", body="crank", value="q1")
    values = {
        "g": "9.8 m/s^2", "m1": "5 kg", "m2": "5 kg", "m3": "20 kg",
        "i1": "1 kg m^2", "i2": "1 kg m^2", "q1": "55 N m",
    }
    for i, (name, value) in enumerate(values.items()):
        pen.insert("BK_PARAMETER", (-0.9 + 0.25 * i, 1.7), name=name, value=value)
    pen.insert("BK_SOLVE", (-0.9, 1.5), t_end="5 s", every="0.01 s", rtol="1e-8", atol="1e-10")
