"""Marks of elements in the drawing: a ring about an axis, a cross where none is known, a line between two points."""

import FreeCAD
import Part

from . import elements, frames

# Of the largest extent of what the bodies are made of.
SIZE = 0.03


def size(doc):
    """How large marks are drawn, mm."""
    box = FreeCAD.BoundBox()
    for body in elements.all_of(doc, "bodies"):
        for part in body.Parts:
            shape = getattr(part, "Shape", None)
            if shape is not None and not shape.isNull():
                box.add(shape.BoundBox)
    return SIZE * box.DiagonalLength if box.isValid() and box.DiagonalLength > 0 else 10.0


def zigzag(start, end, width):
    """The line of a spring."""
    along = end - start
    across = along.cross(FreeCAD.Vector(0, 0, 1))
    if across.Length < 1e-9:
        across = along.cross(FreeCAD.Vector(1, 0, 0))
    across = across.normalize() * width
    inner = [start + along * (0.1 + 0.08 * idx) + across * ((idx % 2) * 2 - 1) for idx in range(11)]
    return Part.makePolygon([start, *inner, end])


def shape(obj, x_now, spot):
    """The mark of an element, where `x_now` gives the poses of bodies seen from the ground, `spot` named points."""
    kind = elements.kind_of(obj)
    is_point = kind.section == "points" and elements.link(obj, "PlaceOne")
    ends = [frames.place(obj.Document, elements.link(obj, "PlaceOne"))] if is_point else frames.ends(obj)
    seen = [x_now(end.body).multVec(end.at) for end in ends if end.at is not None]
    seen = seen or [at for at in map(spot, elements.typed_places(obj)) if at is not None]
    width = size(obj.Document)
    if len(seen) == 2 and (seen[1] - seen[0]).Length > width / 2:
        draw = zigzag if kind.type == "spring" else lambda start, end, _: Part.makePolygon([start, end])
        return draw(seen[0], seen[1], width / 2)
    if not seen:
        return Part.Shape()
    if kind.section == "points":
        return Part.Vertex(seen[0])
    axis = frames.axis(obj, ends) if kind.key("axis") else None
    if not axis and not frames.is_planar(obj.Document):
        units = (FreeCAD.Vector(*unit) * (width / 2) for unit in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
        return Part.makeCompound([Part.makePolygon([seen[-1] - unit, seen[-1] + unit]) for unit in units])
    turned = x_now(ends[0].body).Rotation.multVec(axis) if axis else FreeCAD.Vector(0, 0, 1)
    ring = Part.makeCircle(width / 2, seen[-1], turned)
    return Part.makeCompound([ring, Part.makePolygon([seen[-1] - turned * width, seen[-1] + turned * width])])


def drawn_pose(body):
    """The pose in which a body, or the ground, is drawn."""
    return frames.x_ground_from_body(body) if body else FreeCAD.Placement()


def redraw(obj, x_now=drawn_pose, spot=lambda name: None):
    """Draws the mark of an element where its places are."""
    if elements.kind_of(obj).places == 0:
        return
    mark = shape(obj, x_now, spot)
    if not mark.isNull():
        obj.Shape = mark
        obj.Placement = elements.mechanism(obj.Document).Plane


class Element:
    """What FreeCAD calls for an element; everything that is kept is in its properties."""

    def __init__(self, obj):
        obj.Proxy = self

    def execute(self, obj):
        """Draws the mark again when what it refers to has changed, unless the parts are moving."""
        if not any(body.Home for body in elements.all_of(obj.Document, "bodies")):
            redraw(obj)

    def dumps(self):
        return None

    def loads(self, state):
        return None

    __getstate__, __setstate__ = dumps, loads
