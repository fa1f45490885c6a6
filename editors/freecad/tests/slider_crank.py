"""The slider-crank of the paper, drawn at a crank angle of 55° and attached by the operations of the commands."""

import math

import FreeCAD
import Part

from bksim_freecad import elements

V = FreeCAD.Vector
LENGTHS = {
    "g": "9.8 m/s^2",
    "m1": "5 kg",
    "m2": "5 kg",
    "m3": "20 kg",
    "i1": "1 kg m^2",
    "i2": "1 kg m^2",
    "s1": "0.5 m",
    "q1": "55 N m",
}
CRANK, ROD = 1000.0, 3000.0


def bar(doc, name, x0, x1, half):
    """A sketch of a bar along x, with circles of pins at its ends."""
    sketch = doc.addObject("Sketcher::SketchObject", name)
    corners = [V(x0, -half, 0), V(x1, -half, 0), V(x1, half, 0), V(x0, half, 0)]
    for first, second in zip(corners, corners[1:] + corners[:1]):
        sketch.addGeometry(Part.LineSegment(first, second))
    for x in (x0 + half, x1 - half):
        sketch.addGeometry(Part.Circle(V(x, 0, 0), V(0, 0, 1), half / 3))
    return sketch


def draw(doc, angle=math.radians(55)):
    """Three sketches, each in a frame of its own, in the pose of a crank angle."""
    crank = bar(doc, "Crank", -100, CRANK + 100, 100)
    rod = bar(doc, "Rod", -ROD / 2 - 60, ROD / 2 + 60, 60)
    slider = doc.addObject("Sketcher::SketchObject", "Slider")
    corners = [V(-300, -200, 0), V(300, -200, 0), V(300, 200, 0), V(-300, 200, 0)]
    for first, second in zip(corners, corners[1:] + corners[:1]):
        slider.addGeometry(Part.LineSegment(first, second))
    slider.addGeometry(Part.Circle(V(0, 0, 0), V(0, 0, 1), 50))
    pin = V(CRANK * math.cos(angle), CRANK * math.sin(angle), 0)
    end = V(pin.x + math.sqrt(ROD**2 - pin.y**2), 0, 0)
    turn = math.degrees(math.atan2(end.y - pin.y, end.x - pin.x))
    crank.Placement = FreeCAD.Placement(V(), FreeCAD.Rotation(V(0, 0, 1), math.degrees(angle)))
    rod.Placement = FreeCAD.Placement((pin + end) * 0.5, FreeCAD.Rotation(V(0, 0, 1), turn))
    slider.Placement = FreeCAD.Placement(end, FreeCAD.Rotation())
    doc.recompute()
    return crank, rod, slider


# Kind, name, typed values, and links: names of sketches, with the edge where one is meant. Edges 5 and 6 are the pins.
ATTACHED = [
    *(("parameters", name, {"value": value}, {}) for name, value in LENGTHS.items()),
    (
        "bodies",
        "crank",
        {"mass": "m1", "com": "[s1, 0]", "inertia": "{ value = i1, about = A, as_stated = true }"},
        {"parts": ["Crank"]},
    ),
    ("bodies", "rod", {"mass": "m2", "inertia": "i2", "coordinates": "[x2, y2, theta2]"}, {"parts": ["Rod"]}),
    ("bodies", "slider", {"mass": "m3", "inertia": "0"}, {"parts": ["Slider"]}),
    (
        "joints.revolute",
        "A",
        {"coordinate": "theta1", "initial": "{ angle = 0, rate = 0 }"},
        {"place_one": ("Crank", "Edge5")},
    ),
    ("joints.revolute", "C", {"cut": "true"}, {"place_one": ("Rod", "Edge6"), "place_two": ("Slider", "Edge5")}),
    ("joints.revolute", "B", {"cut": "true"}, {"place_one": ("Crank", "Edge6"), "place_two": ("Rod", "Edge5")}),
    ("points", "O", {"at": "[0, 0]"}, {}),
    (
        "joints.prismatic",
        "D",
        {"coordinate": "x3"},
        {"place_one": "O", "place_two": ("Slider", "Edge5"), "axis_from": ("Slider", "Edge1")},
    ),
    ("loads.gravity", "gravity", {"acceleration": "[0, -g]"}, {}),
    ("loads.torque", "motor", {"on": "crank", "value": "q1"}, {}),
    ("solve", "", {"t_end": "5 s", "every": "0.01 s", "rtol": "1e-8", "atol": "1e-10"}, {}),
]


def linked(doc, links):
    """The objects of the names in links: a list of parts, an element of a sketch, or a named point."""

    def of(value):
        if isinstance(value, list):
            return [doc.getObject(name) for name in value]
        if isinstance(value, str):
            return (elements.find(doc, "points", value), "")
        return (doc.getObject(value[0]), value[1])

    return {key: of(value) for key, value in links.items()}


def judge_end(doc, root):
    """Holds the last sample and the parts there against the log of the example's own model."""
    import os
    import tempfile

    from bksim_freecad import motion, operations, program

    channels = ["state", "energy.total"]
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "example.mcap")
        program.answer(["solve", os.path.join(root, "examples/slider-crank/model.toml"), "-o", log])
        right = {name: column[-1] for name, column in motion.table(log, channels).items()}
    found = {name: column[-1] for name, column in operations.curves(doc, channels).items()}
    assert found.keys() == right.keys(), (found, right)
    # Both runs are within 1e-8 at each step; their errors grow along the motion.
    for name, value in right.items():
        assert abs(found[name] - value) < 1e-6 * (1 + abs(value)), (name, found[name], value)
    # Parts are millimetres in the tree, and where the coordinates say.
    crank, slider = doc.Crank.Placement, doc.Slider.Placement
    angle = math.degrees(right["state.theta1"]) - math.degrees(crank.Rotation.Angle) * crank.Rotation.Axis.z
    assert abs((angle + 180) % 360 - 180) < 1e-4, angle
    assert abs(slider.Base.x - 1000 * right["state.x3"]) < 1e-3, (slider.Base.x, right["state.x3"])
    return found, right
