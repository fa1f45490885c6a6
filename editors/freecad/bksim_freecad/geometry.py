"""Places, directions, frames and masses of what is drawn. Lengths are millimetres, as in all of FreeCAD.

A placement `x_a_from_b` takes coordinates in the frame b to those in a.
"""

import math
from dataclasses import dataclass

import FreeCAD
import Part

SMALL = 1e-9
Z = FreeCAD.Vector(0, 0, 1)


def owners(part):
    """An object and the containers that it is in, innermost first."""
    found = [part]
    while found[-1] is not None:
        found.append(found[-1].getParentGeoFeatureGroup())
    return found[:-1]


def holder(part):
    """The placement of the container that an object is in, seen from the world."""
    seen = FreeCAD.Placement()
    for container in owners(part)[1:]:
        seen = container.Placement * seen
    return seen


def pose(part):
    """Where an object is in the world."""
    return holder(part) * part.Placement


def movable(part):
    """The object to move for one that is drawn: a feature moves with its body of the Part Design workbench."""
    return next((own for own in owners(part) if own.TypeId == "PartDesign::Body"), part)


def shape_of(part, sub=""):
    """The shape of an object, or of its vertex, edge or face, where it is in the world."""
    shape = Part.getShape(part, sub, needSubElement=bool(sub))
    shape = shape.copy()
    shape.Placement = holder(part) * shape.Placement
    return shape


def circle_of(shape):
    """The circle that an edge is, or `None`."""
    is_edge = shape.ShapeType == "Edge"
    return shape.Curve if is_edge and isinstance(shape.Curve, Part.Circle) else None


def place_of(part, sub):
    """The point that is meant by an object or its element, in the world.

    A vertex is its point, a circle and a cylinder their centre, other edges and faces the centre of their length or
    area, an object without element the origin of its placement.
    """
    if not sub:
        return pose(part).Base
    shape = shape_of(part, sub)
    if shape.ShapeType == "Vertex":
        return shape.Point
    return circle_of(shape).Center if circle_of(shape) else shape.CenterOfMass


def direction_of(part, sub):
    """The direction of a line, an axis or the normal of a plane in the world, or `None`."""
    if not sub:
        return None
    shape = shape_of(part, sub)
    if circle_of(shape):
        return shape.Curve.Axis
    if shape.ShapeType == "Edge" and isinstance(shape.Curve, Part.Line):
        return shape.tangentAt(shape.FirstParameter)
    if shape.ShapeType == "Face":
        return getattr(shape.Surface, "Axis", None)
    return None


def flat(placement, unturned):
    """The frame in the plane z = 0 next to a placement, with the angle about z by which it is turned.

    What is not turned has the axes of the plane, or the axes `unturned`: those of the world seen from the plane. All
    that is turned otherwise has the angle zero.
    """
    turns = (placement.Rotation, placement.Rotation * unturned.inverted())
    about_z = [turn for turn in turns if turn.multVec(Z).getAngle(Z) < SMALL]
    angle = angle_of(FreeCAD.Placement(FreeCAD.Vector(), about_z[0])) if about_z else 0.0
    base = FreeCAD.Vector(placement.Base.x, placement.Base.y, 0)
    return FreeCAD.Placement(base, FreeCAD.Rotation(Z, math.degrees(angle)))


def angle_of(placement):
    """The angle about z of a frame in the plane, rad."""
    x = placement.Rotation.multVec(FreeCAD.Vector(1, 0, 0))
    return math.atan2(x.y, x.x)


def faces_of_wires(shape):
    """A plate with its holes from closed wires, or `None`."""
    closed = [wire for wire in shape.Wires if wire.isClosed()]
    if not closed:
        return None
    try:
        return Part.makeFace(closed, "Part::FaceMakerBullseye")
    except Part.OCCError:
        return None


@dataclass(frozen=True)
class Extent:
    """Volume, area or length of parts, mm to the `dimension`, with the second moments of a density of one."""

    dimension: int
    size: float
    centre: FreeCAD.Vector
    moments: tuple  # xx yy zz xy yz zx of the tensor about the centre, mm²: per mass


def pieces(parts):
    """Solids of the parts, else their faces, those of closed wires included, else their edges: with the dimension."""
    shapes = [shape_of(part) for part in parts]
    solids = [solid for shape in shapes for solid in shape.Solids]
    if solids:
        return 3, solids
    flats = [shape if shape.Faces else faces_of_wires(shape) for shape in shapes]
    faces = [face for shape in flats if shape is not None for face in shape.Faces]
    return (2, faces) if faces else (1, [edge for shape in shapes for edge in shape.Edges])


def size_of(piece, dimension):
    """Volume, area or length."""
    return (piece.Length, piece.Area, piece.Volume)[dimension - 1]


def extent(parts, x_world_from_body):
    """The extent of parts in the frame of their body, or `None` where nothing is drawn."""
    dimension, found = pieces(parts)
    sizes = [size_of(piece, dimension) for piece in found]
    size = sum(sizes)
    if size <= 0:
        return None
    to_body = x_world_from_body.inverse()
    centres = [to_body.multVec(piece.CenterOfMass) for piece in found]
    centre = sum((c * s for c, s in zip(centres, sizes)), FreeCAD.Vector()) * (1 / size)
    tensor = [[0.0] * 3 for _ in range(3)]
    for piece, own_size, own_centre in zip(found, sizes, centres):
        turned = piece.copy()
        turned.Placement = to_body * turned.Placement
        own, offset = turned.MatrixOfInertia.A, own_centre - centre
        # Steiner: the moments about the common centre.
        for row in range(3):
            for column in range(3):
                square = offset.dot(offset) if row == column else 0.0
                tensor[row][column] += own[4 * row + column] + own_size * (square - offset[row] * offset[column])
    entries = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    return Extent(dimension, size, centre, tuple(tensor[row][column] / size for row, column in entries))


def outlines(parts, x_world_from_body):
    """Polygons of the outer wires of what is drawn flat, or of solids in their middle, in the frame of their body."""
    dimension, found = pieces(parts)
    if dimension == 3:
        # Solids are cut through their middle.
        normal = x_world_from_body.Rotation.multVec(Z)
        cuts = (Part.makeCompound(solid.slice(normal, normal.dot(solid.CenterOfMass))) for solid in found)
        found = [face for plate in map(faces_of_wires, cuts) if plate is not None for face in plate.Faces]
    if dimension == 1:
        return []
    to_body = x_world_from_body.inverse()
    polygons = []
    for face in found:
        deflection = max(face.BoundBox.DiagonalLength / 500, 1e-6)
        corners = [to_body.multVec(p) for p in face.OuterWire.discretize(Deflection=deflection)]
        # The last corner repeats the first.
        corners = corners[:-1] if corners[0].isEqual(corners[-1], 1e-6) else corners
        polygons.append([(round(c.x, 6), round(c.y, 6)) for c in corners])
    return polygons
