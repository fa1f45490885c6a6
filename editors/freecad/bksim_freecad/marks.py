"""Marks of elements in the drawing: a ring where a joint turns, an arrow along an axis, a line between two points."""

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


def shape(obj, x_now):
    """The mark of an element, where `x_now` gives the poses of bodies seen from the ground."""
    kind = elements.kind_of(obj)
    ends = [frames.place(obj.Document, elements.link(obj, "PlaceOne"))] if kind.section == "points" else frames.ends(obj)
    seen = [x_now(end.body).multVec(end.at) for end in ends if end.at is not None]
    width = size(obj.Document)
    if len(seen) == 2 and (seen[1] - seen[0]).Length > width / 2:
        draw = zigzag if kind.type == "spring" else lambda start, end, _: Part.makePolygon([start, end])
        return draw(seen[0], seen[1], width / 2)
    if not seen:
        return Part.Shape()
    if kind.section == "points":
        return Part.Vertex(seen[0])
    axis = frames.axis(obj, ends) if kind.key("axis") else None
    turned = x_now(ends[0].body).Rotation.multVec(axis) if axis else FreeCAD.Vector(0, 0, 1)
    ring = Part.makeCircle(width / 2, seen[-1], turned)
    return Part.makeCompound([ring, Part.makePolygon([seen[-1] - turned * width, seen[-1] + turned * width])])


def drawn_pose(body):
    """The pose in which a body, or the ground, is drawn."""
    return frames.x_ground_from_body(body) if body else FreeCAD.Placement()


def redraw(obj, x_now=drawn_pose):
    """Draws the mark of an element where its places are."""
    if elements.link(obj, "PlaceOne") is None or elements.kind_of(obj).places == 0:
        return
    mark = shape(obj, x_now)
    if not mark.isNull():
        obj.Shape = mark
        obj.Placement = elements.mechanism(obj.Document).Plane
