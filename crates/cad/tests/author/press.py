"""The press of docs/drawings.md: as outlines, and with the blocks that make it a mechanism."""

import math

from blocks import define
from shapes import angle, bar, base, bearing, centre_line, cross, middle, point, rectangle, sheet

UNIT, TEXT = "mm", 0.008
L1, L2, TURN = 0.1, 0.3, math.radians(50)

A = (0.0, 0.0)
B = (L1 * math.cos(TURN), L1 * math.sin(TURN))
C = (B[0] + math.sqrt(L2**2 - B[1] ** 2), 0.0)
WALL = (C[0] + 0.2, 0.0)


def outlines(pen):
    bar(pen, A, B, 0.018, 0.006, "OUTLINE", pins=[A, B])
    bar(pen, B, C, 0.015, 0.006, "OUTLINE", pins=[C])
    corners = [(-45, -35), (45, -35), (60, -12), (60, 12), (45, 40), (-45, 40)]
    pen.polyline([(C[0] + x / 1000, y / 1000, 0) for x, y in corners], "OUTLINE")
    bearing(pen, A, 0.025)
    base(pen, (C[0] - 0.14, -0.035), (C[0] + 0.1, -0.035), 0.012)
    base(pen, (WALL[0], 0.05), (WALL[0], -0.05), 0.012)
    for p in (A, B, C):
        cross(pen, p, 0.028)
    centre_line(pen, A, B, 0.03)
    centre_line(pen, B, C, 0.03)
    pen.dimension(A, B, 0.055)
    pen.dimension(B, C, 0.055)
    sheet(pen, (-0.12, -0.16), (0.56, 0.2), "Press", "plates of 10 mm, lengths in mm")


def draw(pen):
    define(pen, *"""BK_BODY BK_REVOLUTE BK_PRISMATIC BK_DRIVE BK_GRAVITY BK_SPRING
        BK_SOLVE""".split())
    outlines(pen)
    steel = {"density": "7850 kg/m^3", "thickness": "10"}
    pen.insert("BK_BODY", middle(A, B), name="crank", **steel)
    pen.insert("BK_BODY", middle(B, C), name="rod", **steel)
    pen.insert("BK_BODY", (C[0] + 0.03, 0.022), name="slider", mass="1.5 kg")
    for name, p in {"A": A, "B": B, "C": C}.items():
        pen.insert("BK_REVOLUTE", p, name=name)
    pen.insert("BK_PRISMATIC", (C[0] - 0.025, -0.027), name="guide")
    pen.insert("BK_DRIVE", A, name="motor", motion="50 deg + 60 rpm*t")
    pen.insert("BK_GRAVITY", (0.5, 0.17), acceleration="9.81 m/s^2")
    end = (C[0] + 0.06, 0.0)
    pen.insert_between("BK_SPRING", end, WALL, name="spring", stiffness="2 N/mm", length="150")
    pen.insert("BK_SOLVE", (-0.1, 0.17), t_end="2 s", every="10 ms")
