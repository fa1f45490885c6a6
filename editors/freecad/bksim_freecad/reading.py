"""A model file, a drawing or a mechanism of another program as elements of a document.

What is typed in the file is typed in the elements. Outlines, or the points of a body that has none, become its drawing.
"""

import os
import re

import FreeCAD
import Part

from . import editing, elements, kinds, model, motion, program
from .values import NUMBER, typed, written

CORNER = "corner_of_outline"
LENGTH = re.compile(r"\s*(" + NUMBER.pattern + r")\s*([a-zµ]+)\s*")
MILLIMETRES = {"mm": 1, "cm": 10, "dm": 100, "m": 1000, "in": 25.4, "ft": 304.8}


def parsed(text):
    """The tables of a model file."""
    try:
        import tomllib
    except ImportError:
        raise program.Failed("models are read by FreeCAD with Python 3.11 or later") from None
    return tomllib.loads(text)


def model_text(path):
    """The model in a file as one text, whatever program it is of."""
    ending = os.path.splitext(path)[1].lower()
    if ending in (".dxf", ".dwg"):
        return program.text_of(["cad", "to-toml", path])
    if ending != ".toml":
        return program.text_of(["import", path])
    text = program.text_of(["expand", path])
    return program.text_of(["cad", "to-toml", path]) if "drawing" in parsed(text) else text


def add_tables(doc, text):
    """Elements for the tables of a model."""
    tables = parsed(text)
    starts = tables.pop("initial", {})
    owners = {name for section in kinds.WITH_START for name in tables.get(section, {})}
    top = {key: value for key, value in tables.items() if not isinstance(value, dict)}
    editing.add(doc, "model", "", {"space": space_of(tables, text)} | top)
    for section, found in tables.items():
        if not isinstance(found, dict):
            continue
        form = kinds.of_section(section)[0].form
        if form == "single":
            editing.add(doc, section, "", found)
        for name, value in found.items() if form != "single" else ():
            values = dict(value) if form == "table" else {"value": value}
            kind_type = values.pop("type", "") if form == "table" else ""
            if section in kinds.WITH_START and name in starts:
                values["initial"] = starts[name]
            links = {"from_drawing": False} if section == "bodies" else {}
            editing.add(doc, f"{section}.{kind_type}" if kind_type else section, name, values, **links)
    for name, value in starts.items():
        if name not in owners:
            editing.add(doc, "initial", name, {"value": value})


def space_of(tables, text):
    """Whether the model is one of a plane, as `bksim` reads it where that is not written."""
    try:
        return tables.get("space") or program.answer(["check", "-"], text)["space"]
    except program.Failed:
        return "planar"


def corners_of(obj):
    """The polygons of a body's outlines, each a list of corners that are values of TOML."""
    value = parsed(f"value = {written(elements.text(obj, 'outline') or '[]')}")["value"]
    is_one = value and not isinstance(value[0][0], list)
    return [value] if is_one else value


def millimetres(value, unit):
    """A length that is a number, or a number with its unit; `None` of an expression."""
    match = LENGTH.fullmatch(value if isinstance(value, str) else f"{value!r} {unit}")
    scale = MILLIMETRES.get(match[2]) if match else None
    return None if scale is None else float(match[1].replace("_", "")) * scale


def drawn(points):
    """A closed polygon of points that enclose something, else the line through them."""
    apart = [point for idx, point in enumerate(points) if idx == 0 or (point - points[idx - 1]).Length > 1e-6]
    if len(apart) < 2:
        return Part.Vertex(apart[0])
    return Part.makePolygon(apart)


def lines_of(obj, unit):
    """The lines that a body is drawn by, and points to add to it to learn where they are.

    Each line is a list of corners in millimetres, or of names of points: outlines, else all points of the body.
    """
    asked, lines = {}, []
    for polygon in corners_of(obj):
        line = [tuple(millimetres(value, unit) for value in corner) for corner in polygon]
        for number, corner in enumerate(polygon):
            if None in line[number]:
                line[number] = f"{CORNER}_{len(asked)}"
                asked[line[number]] = written(typed(corner))
        lines.append([*line, line[0]])
    return lines or [[*dict(model.typed_points(obj)), model.ORIGIN]], asked


def draw(doc):
    """Draws the bodies in the pose of the start; where a corner is an expression, a run is asked for it."""
    unit = model.unit(doc, "length")
    found = {body: lines_of(body, unit) for body in elements.all_of(doc, "bodies")}
    log = motion.short_run(doc, {body.ElementName: asked for body, (_, asked) in found.items()})
    start = motion.read(doc, log)
    named = {
        f"{body.ElementName}.{place}"
        for body, (lines, _) in found.items()
        for line in lines
        for place in line
        if isinstance(place, str)
    }
    columns = motion.table(log, [f"{name}.{axis}" for name in sorted(named) for axis in motion.POSE])
    seen = {name: FreeCAD.Vector(*(columns[f"{name}.{axis}"][0] for axis in motion.POSE)) * 1000 for name in named}
    for body, (lines, _) in found.items():
        name, pose = body.ElementName, start.pose(body.ElementName, 0)
        back = pose.inverse()
        wires = [
            drawn(
                [
                    back.multVec(seen[f"{name}.{place}"]) if isinstance(place, str) else FreeCAD.Vector(*place)
                    for place in line
                ]
            )
            for line in lines
        ]
        part = doc.addObject("Part::Feature", name)
        part.Shape, part.Placement = Part.makeCompound(wires), pose
        body.Parts = [part]
    motion.show(doc, start, 0)
    motion.go_home(doc)


def read_file(doc, path):
    """Adds what a file describes to a document that has no mechanism yet: bare numbers mean what they mean there."""
    if elements.mechanism(doc):
        raise program.Failed("the document has a mechanism already: open a new one for another")
    text = model_text(path)
    editing.begin(doc, {})
    add_tables(doc, text)
    draw(doc)
