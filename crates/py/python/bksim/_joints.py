"""The joints of a model as objects: the two anchors that they join, then what their kind has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

from ._assigned import Part, Point, Value


@dataclass(slots=True)
class Joint(Part):
    """Two points that are joined, ``"ground.O"`` and ``"crank.A"``."""

    _section: ClassVar[str] = "joints"

    type: ClassVar[str]

    first: str
    second: str
    _: KW_ONLY
    cut: bool | None = None


@dataclass(slots=True)
class Revolute(Joint):
    """Turns about ``axis``, which is z unless given."""

    type: ClassVar[str] = "revolute"

    axis: Sequence[Value] | None = None
    coordinate: str | None = None
    second_: Sequence[Value] | None = None
    armature: Value | None = None
    clearance: Value | None = None
    radius: Value | None = None
    mu: Value | None = None
    static: Value | None = None
    restitution: Value | None = None


@dataclass(slots=True)
class Prismatic(Joint):
    """Slides along ``axis`` of the first body, or at the angle ``direction`` to its x."""

    type: ClassVar[str] = "prismatic"

    axis: Sequence[Value] | None = None
    direction: Value | None = None
    angle: Value | None = None
    coordinate: str | None = None
    second_: Sequence[Value] | None = None
    armature: Value | None = None
    clearance: Value | None = None
    length: Value | None = None
    width: Value | None = None
    mu: Value | None = None
    static: Value | None = None
    restitution: Value | None = None


@dataclass(slots=True)
class Slot(Joint):
    """The point of the second body slides along ``axis`` of the first, and turns."""

    type: ClassVar[str] = "slot"

    axis: Sequence[Value] | None = None
    direction: Value | None = None
    coordinate: Sequence[str] | None = None


@dataclass(slots=True)
class Weld(Joint):
    """Allows nothing."""

    type: ClassVar[str] = "weld"

    angle: Value | None = None


@dataclass(slots=True)
class Link(Joint):
    """A massless rod of a ``length`` between the two points."""

    type: ClassVar[str] = "link"

    length: Value


@dataclass(slots=True)
class Spherical(Joint):
    """The points coincide; the bodies turn as they like."""

    type: ClassVar[str] = "spherical"

    coordinate: Sequence[str] | None = None


@dataclass(slots=True)
class Universal(Joint):
    """The points coincide; ``axis`` of the first body stays perpendicular to ``second_`` of the other."""

    type: ClassVar[str] = "universal"

    second_: Sequence[Value]
    axis: Sequence[Value] | None = None
    coordinate: Sequence[str] | None = None


@dataclass(slots=True)
class Cylindrical(Joint):
    """Slides along ``axis`` and turns about it."""

    type: ClassVar[str] = "cylindrical"

    axis: Sequence[Value] | None = None
    coordinate: Sequence[str] | None = None
    second_: Sequence[Value] | None = None


@dataclass(slots=True)
class Planar(Joint):
    """Slides across ``axis`` and turns about it."""

    type: ClassVar[str] = "planar"

    axis: Sequence[Value] | None = None
    coordinate: Sequence[str] | None = None
    second_: Sequence[Value] | None = None


@dataclass(slots=True)
class Screw(Joint):
    """Turns about ``axis``, and with each turn slides one ``lead`` along it."""

    type: ClassVar[str] = "screw"

    lead: Value
    axis: Sequence[Value] | None = None
    coordinate: str | None = None
    second_: Sequence[Value] | None = None


@dataclass(slots=True)
class Free(Joint):
    """Allows everything."""

    type: ClassVar[str] = "free"

    coordinate: Sequence[str] | None = None


@dataclass(slots=True)
class PointOnLine(Joint):
    """The second point stays on a line of the first body along ``axis``."""

    type: ClassVar[str] = "point-on-line"

    axis: Sequence[Value] | None = None
    coordinate: Sequence[str] | None = None


@dataclass(slots=True)
class PointOnPlane(Joint):
    """The second point stays in a plane of the first body across ``axis``."""

    type: ClassVar[str] = "point-on-plane"

    axis: Sequence[Value] | None = None
    coordinate: Sequence[str] | None = None


@dataclass(slots=True)
class ParallelAxes(Joint):
    """``axis`` stays parallel in both bodies."""

    type: ClassVar[str] = "parallel-axes"

    axis: Sequence[Value] | None = None
    coordinate: Sequence[str] | None = None
    second_: Sequence[Value] | None = None


@dataclass(slots=True)
class PerpendicularAxes(Joint):
    """``axis`` of the first body stays perpendicular to ``second_`` of the other."""

    type: ClassVar[str] = "perpendicular-axes"

    second_: Sequence[Value]
    axis: Sequence[Value] | None = None
    coordinate: Sequence[str] | None = None


@dataclass(slots=True)
class ConstantVelocity(Joint):
    """The points coincide, and both bodies turn about their ``axis`` by the same angle."""

    type: ClassVar[str] = "constant-velocity"

    axis: Sequence[Value] | None = None
    second_: Sequence[Value] | None = None


@dataclass(slots=True)
class PointOnCurve(Joint):
    """The second point stays on the ``curve`` of that name, in the frame of the first one.

    With a ``radius`` a roller about the point touches the curve, on its ``side`` ``"left"`` or ``"right"``. With
    ``lifts`` the point or roller lifts off the curve to that side, and rubs and bounces as contacts do.
    """

    type: ClassVar[str] = "point-on-curve"

    curve: str
    radius: Value | None = None
    side: str | None = None
    lifts: bool | None = None
    mu: Value | None = None
    static: Value | None = None
    restitution: Value | None = None
    coordinate: str | None = None


@dataclass(slots=True)
class LineOnCurve(Joint):
    """The line along ``axis`` through the second point touches the ``curve`` of that name.

    With ``lifts`` it lifts off to the ``side`` ``"left"`` or ``"right"`` of the curve.
    """

    type: ClassVar[str] = "line-on-curve"

    curve: str
    axis: Sequence[Value] | None = None
    direction: Value | None = None
    side: str | None = None
    lifts: bool | None = None
    mu: Value | None = None
    static: Value | None = None
    restitution: Value | None = None
    coordinate: str | None = None


@dataclass(slots=True)
class CurveOnCurve(Joint):
    """The ``second_curve`` of the second body touches the ``curve`` of the first.

    ``tangents`` are ``"opposite"`` or the ``"same"`` as both parameters rise. With ``rolling``, the parameters of two
    points that come together, the curves do not slip. With ``lifts`` the second lifts off to the ``side`` ``"left"`` or
    ``"right"`` of the first.
    """

    type: ClassVar[str] = "curve-on-curve"

    curve: str
    second_curve: str
    tangents: str | None = None
    rolling: Sequence[Value] | None = None
    side: str | None = None
    lifts: bool | None = None
    mu: Value | None = None
    static: Value | None = None
    restitution: Value | None = None
    coordinate: Sequence[str] | None = None


@dataclass(slots=True)
class KnifeEdge(Joint):
    """A blade at the second point moves along ``axis``, which is fixed in the second body, and not across it.

    It moves in the plane of x and y of the first point's frame.
    """

    type: ClassVar[str] = "knife-edge"

    axis: Sequence[Value] | None = None
    direction: Value | None = None


@dataclass(slots=True)
class Rolling(Joint):
    """A ``"disc"`` or ``"ball"`` about the second point rolls on the plane of x and y of the first point's frame.

    ``radius`` is that of the whole, ``rim`` the one by which the rim of a disc is round, and ``axis`` its axle.
    """

    type: ClassVar[str] = "rolling"

    shape: str
    radius: Value
    rim: Value | None = None
    axis: Sequence[Value] | None = None


@dataclass(slots=True)
class Distance(Joint):
    """A rod of a ``length``, which may be a function of time, or a rope between its limits."""

    type: ClassVar[str] = "distance"

    length: Value | None = None
    min: Value | None = None
    max: Value | None = None
    restitution: Value | None = None
    coordinate: str | None = None


@dataclass(slots=True)
class Cylinder(Joint):
    """An actuator between the two points, whose length drives, loads and stops act on."""

    type: ClassVar[str] = "cylinder"

    min: Value | None = None
    max: Value | None = None
    restitution: Value | None = None
    coordinate: str | None = None


JOINTS: tuple[type[Joint], ...] = (
    Revolute,
    Prismatic,
    Slot,
    Weld,
    Link,
    Spherical,
    Universal,
    Cylindrical,
    Planar,
    Screw,
    Free,
    PointOnLine,
    PointOnPlane,
    ParallelAxes,
    PerpendicularAxes,
    ConstantVelocity,
    PointOnCurve,
    LineOnCurve,
    CurveOnCurve,
    KnifeEdge,
    Rolling,
    Distance,
    Cylinder,
)


def joint_from_table(table: dict[str, Any]) -> Joint:
    """The joint that a table of a model file says."""
    rest = {key: value for key, value in table.items() if key not in ("type", "between", "second")}
    if "second" in table:
        rest["second_"] = table["second"]
    kind = next(kind for kind in JOINTS if kind.type == table["type"])
    return kind(*table["between"], **rest)
