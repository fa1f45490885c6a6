"""Where bodies and places are in the drawn pose, whether or not the parts have moved since.

The frame of a body is that of its first part; in a plane it has an angle alone, that by which the part is turned
against the axes of the plane or of the world. The frame of the ground is the property `Plane` of the mechanism.
"""

from dataclasses import dataclass

import FreeCAD

from . import elements, geometry
from .kinds import APART, SLIDING


def is_planar(doc):
    """Whether the mechanism is one of a plane."""
    top = elements.find(doc, "model")
    return top is None or elements.text(top, "space") != "spatial"


def home(body, part):
    """Where a part of a body is drawn, in the world."""
    return body.Home[body.Parts.index(part)] if body.Home else geometry.pose(part)


def x_ground_from_body(body):
    """The drawn pose of a body: where its frame is, seen from the ground."""
    doc = body.Document
    if not body.Parts:
        return FreeCAD.Placement()
    plane = elements.mechanism(doc).Plane.inverse()
    seen = plane * home(body, body.Parts[0])
    return geometry.flat(seen, plane.Rotation) if is_planar(doc) else seen


def x_body_from_part(body, part):
    """Where a part is on its body."""
    drawn = elements.mechanism(body.Document).Plane * x_ground_from_body(body)
    return drawn.inverse() * home(body, part)


@dataclass(frozen=True)
class Place:
    """A point of a body, `None` for the ground, in its frame; `name` where it has one already."""

    body: object
    at: FreeCAD.Vector | None
    name: str = ""
    direction: FreeCAD.Vector | None = None
    is_whole: bool = False


def to_ground(place):
    """A place as the ground sees it in the drawn pose."""
    return x_ground_from_body(place.body).multVec(place.at) if place.body else place.at


def onto(body, at_ground):
    """The place of a body, or of the ground, at a point of the ground in the drawn pose."""
    return Place(body, x_ground_from_body(body).inverse().multVec(at_ground) if body else at_ground)


def place(doc, target):
    """The place that a link leads to: of a point, a body, or an element of what is drawn."""
    obj, sub = target
    if elements.is_element(obj):
        if elements.section_of(obj) == "points":
            body, at = point(obj)
            return Place(body, at, obj.ElementName)
        return Place(obj if elements.section_of(obj) == "bodies" else None, FreeCAD.Vector(), is_whole=True)
    body = elements.body_of(doc, obj)
    at, direction = geometry.place_of(obj, sub), geometry.direction_of(obj, sub)
    if body is None:
        x_frame_from_world = elements.mechanism(doc).Plane.inverse()
    else:
        part = next(own for own in geometry.owners(obj) if own in body.Parts)
        x_frame_from_world = x_body_from_part(body, part) * geometry.pose(part).inverse()
    turned = x_frame_from_world.Rotation.multVec(direction) if direction else None
    return Place(body, x_frame_from_world.multVec(at), "", turned, not sub)


def point(obj):
    """The body of a point and where it is in its frame: `None` where that is typed, or nowhere."""
    named = elements.find(obj.Document, "bodies", obj.Body) if obj.Body else None
    target = elements.link(obj, "PlaceOne")
    if target is None:
        return named, None
    found = place(obj.Document, target)
    if obj.Body and found.body != named:
        found = onto(named, to_ground(found))
    return found.body, None if elements.text(obj, "at") else found.at


def ends(obj):
    """The places of a joint or load, as many as it has; a joint on one part alone joins it to the ground.

    Where the two points of a joint come together, a second place without element is the first on another body.
    """
    doc, kind = obj.Document, elements.kind_of(obj)
    targets = [elements.link(obj, f"Place{number}") for number in ("One", "Two")[: kind.places]]
    found = [place(doc, target) for target in targets if target is not None]
    if kind.places < 2 or kind.type in APART or not found or found[0].at is None:
        return found
    first = found[0]
    if len(found) == 1:
        return [onto(None, to_ground(first)), first] if first.body else found
    second = found[1]
    return [first, onto(second.body, to_ground(first)) if second.is_whole else second]


def axis(obj, found):
    """The axis that the drawing gives a joint, in the frame of its first body, or `None`."""
    doc, kind = obj.Document, elements.kind_of(obj)
    target = elements.link(obj, "AxisFrom")
    given = [place(doc, target)] if target else [one for one in found if one.direction]
    if not given or given[0].direction is None or not found:
        return None
    seen, first = given[0], found[0].body
    turn = x_ground_from_body(seen.body).Rotation if seen.body else FreeCAD.Rotation()
    back = x_ground_from_body(first).Rotation.inverted() if first else FreeCAD.Rotation()
    direction = back.multVec(turn.multVec(seen.direction))
    if is_planar(doc) and (kind.type not in SLIDING or abs(direction.z) > geometry.SMALL):
        return None
    return direction
