"""The blocks of a mechanism, as a designer may have made them: a symbol and attributes."""

FALL = [((0, 0), (0, -4)), ((0, -4), (0.6, -3)), ((0, -4), (-0.6, -3))]
TURN = [("circle", (0, 0), 1.5), ((1.5, 0), (0.9, -0.3)), ((1.5, 0), (1.8, -0.6))]
CROSS = [((-1, 0), (1, 0)), ((0, -1), (0, 1))]
SLIDE = [((-3, 0), (3, 0)), ((3, 0), (2, 0.6)), ((-3, 0), (-2, -0.6))]
# From (0, 0) to (1, 0).
COIL = [
    ((0, 0), (0.3, 0)), ((0.3, 0), (0.35, 0.1)), ((0.35, 0.1), (0.45, -0.1)),
    ((0.45, -0.1), (0.55, 0.1)), ((0.55, 0.1), (0.65, -0.1)), ((0.65, -0.1), (0.7, 0)),
    ((0.7, 0), (1, 0)),
]
NOTE = [((0, 0), (1, 0)), ((0, 0), (0, -1))]

BLOCKS = {
    "BK_GROUND": ([((0, 0), (-1, -1.5)), ((-1, -1.5), (1, -1.5)), ((1, -1.5), (0, 0))], "NAME"),
    "BK_BODY": (
        [((-0.5, 0), (0.5, 0)), ((0, -0.5), (0, 0.5))],
        "NAME MASS INERTIA ABOUT DENSITY THICKNESS COORDINATES",
    ),
    "BK_FRAME": ([((0, 0), (2, 0)), ((0, 0), (0, 2))], "BODY"),
    "BK_POINT": (CROSS, "NAME BODY"),
    "BK_COM": ([("circle", (0, 0), 0.8), *CROSS], "BODY"),
    "BK_REVOLUTE": ([("circle", (0, 0), 1)], "NAME BODY1 BODY2 COORDINATE CUT ANGLE RATE"),
    "BK_PRISMATIC": (
        SLIDE,
        "NAME BODY1 BODY2 POINT1 POINT2 COORDINATE CUT POSITION VELOCITY",
    ),
    "BK_SLOT": ([("circle", (0, 0), 1), *SLIDE], "NAME BODY1 BODY2 POINT1 POINT2"),
    "BK_GRAVITY": (FALL, "NAME ACCELERATION"),
    "BK_SPRING": (COIL, "NAME BODY1 BODY2 STIFFNESS LENGTH DAMPING"),
    "BK_TORQUE": (TURN, "NAME BODY VALUE"),
    "BK_DRIVE": (TURN, "NAME JOINT MOTION"),
    "BK_PARAMETER": (NOTE, "NAME VALUE"),
    "BK_SOLVE": (NOTE, "T_END EVERY RTOL ATOL"),
}


def define(pen, *names):
    """Defines the blocks of these names, and a layer for them."""
    pen.doc.layers.add("BKSIM", color=5)
    for name in names:
        symbol, tags = BLOCKS[name]
        pen.block(name, symbol, tags.split())
