"""The five-link mechanism by extended data on the outlines, drawn at a crank angle of 60 degrees."""

import math

from four_bar import third
from shapes import angle, bar, base, bearing, centre_line, cross, middle, point, rectangle, sheet

UNIT, TEXT = "m", 2.2
L1, L2, L4, L5, TURN = 25.0, 100.0, 25.0, 100.0, math.radians(60)

O, H = (0.0, 0.0), (103.0, -99.0)
A = (L1 * math.cos(TURN), L1 * math.sin(TURN))
B = (A[0] + math.sqrt(L2**2 - A[1] ** 2), 0.0)
M = middle(A, B)
E = third(M, H, L4, L5)


def draw(pen):
    bearing(pen, O, 4)
    bearing(pen, H, 4)
    base(pen, (B[0] - 35, -4), (B[0] + 35, -4), 2.5)
    bodies = links(pen)
    pins(pen, bodies)
    furniture(pen)
    numbers(pen)


def links(pen):
    """The outlines with the bodies that they are; returns their entities by name."""
    ends = {"link1": (O, A), "link2": (A, B), "link4": (E, M), "link5": (H, E)}
    bodies = {}
    for name, pins in ends.items():
        bodies[name], *others = bar(pen, *pins, 2.6, 0.9, "OUTLINE")
        for entity in others:
            pen.attach(entity, ("body", {"name": name}))
    bodies["link3"] = pen.polyline(rectangle(B, 0, 14, 8), "OUTLINE")
    record = lambda name, **keys: pen.attach(bodies[name], ("body", {"name": name, "mass": "m", **keys}))
    record("link1", inertia="i", about="O")
    record("link2", inertia="i", at=M, axis=("axis", angle(A, B)), coordinates="x2, y2, ti2")
    record("link3", inertia="0")
    record("link4", inertia="i", at=middle(E, M), axis=("axis", angle(E, M)), coordinates="x4, y4, ti4")
    record("link5", inertia="i", about="H")
    # A centre of mass that stands on the outline of its body and moves with it.
    pen.attach(bodies["link5"], ("com", {"at": middle(H, E)}))
    pen.attach(bodies["link3"], ("com", {"at": B}))
    return bodies


def pins(pen, bodies):
    """Every joint on the circle of its pin; partners by handle, by name, or as they are found."""
    circles = {name: pen.circle(p, 1.5, "OUTLINE") for name, p in
               {"O": O, "M": M, "E": E, "B": B, "A": A}.items()}
    entity = lambda name: ("entity", bodies[name])
    revolute = lambda name, **keys: pen.attach(circles[name], ("revolute", {"name": name, **keys}))
    revolute("O", body1="ground", body2=entity("link1"), coordinate="ti1", angle=0.0, rate=0.0)
    revolute("M", body1=entity("link2"), body2=entity("link4"), cut="true")
    revolute("E", body1="link4", body2="link5", cut="true")
    revolute("B", body1=entity("link2"), body2=entity("link3"), cut="true")
    revolute("A", cut="true")
    pen.attach(pen.point(point(B, 0, 0, -4)), ("prismatic", {
        "name": "S", "body1": "ground", "body2": "link3", "point1": "O", "point2": "B",
        "axis": ("axis", 0.0), "coordinate": "x3",
    }))
    circles["H"] = pen.circle(H, 1.5, "OUTLINE")
    revolute("H", body1="ground", body2=entity("link5"), coordinate="ti5")


def furniture(pen):
    for p in (O, A, M, B, E, H):
        cross(pen, p, 4)
    for p, q in [(O, A), (A, B), (M, E), (H, E)]:
        centre_line(pen, p, q, 6)
    pen.dimension(O, A, 9)
    pen.dimension(A, B, 12)
    pen.dimension(E, H, 14)
    pen.dimension(M, E, -20)


def numbers(pen):
    title = sheet(pen, (-35, -125), (160, 50), "Five-link mechanism", "pięć członów po 1 kg, m")
    values = {"g": "9.8 m/s^2", "m": "1 kg", "i": "1 kg m^2", "q1": "500 N m"}
    pen.attach(
        title,
        *[("parameter", {"name": name, "value": value}) for name, value in values.items()],
        ("gravity", {"name": "gravity", "acceleration": "g", "axis": ("axis", -math.pi / 2)}),
        ("torque", {"name": "motor", "body": "link1", "value": "q1"}),
        # The model file counts this angle one turn back.
        ("initial", {"name": "link4", "angle": "-535 deg", "guess": "true"}),
        ("solve", {"t_end": "50 s", "every": 0.1, "rtol": 1e-8, "atol": 1e-8}),
    )
