"""The parts of a model as objects, and as the tables of a model file.

Values are numbers in the units of the file (SI unless it says otherwise), or texts with a unit or an
expression: ``0.25``, ``"250 mm"``, ``"l1/2"``. What is ``None`` is left out.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

from ._assigned import Part, plain

Value = Union[float, str]
"""A number, a quantity or an expression."""

Point = Union[Sequence[Value], NDArray[np.float64]]
"""``[x, y]`` or ``[x, y, z]``, length."""

Table = dict[str, Any]


@dataclass(slots=True)
class Body(Part):
    """A rigid body: mass, centre of mass and points in its own frame.

    >>> import bksim
    >>> bksim.Body(mass="0.5 kg", com=["l1/2", 0], points={"A": [0, 0], "B": ["l1", 0]}).mass
    '0.5 kg'
    """

    _section: ClassVar[str] = "bodies"

    mass: Value | None = None
    com: Point | None = None
    inertia: Value | Sequence[Value] | Mapping[str, Value] | None = None
    points: dict[str, Point] = field(default_factory=dict)
    outline: Sequence[Any] | None = None
    density: Value | None = None
    thickness: Value | None = None
    shapes: Sequence[Mapping[str, Any]] | None = None
    coordinates: Sequence[str] | None = None
    free: bool | None = None


@dataclass(slots=True)
class Ground:
    """The body that does not move."""

    points: dict[str, Point] = field(default_factory=dict)
    outline: Sequence[Any] | None = None
    shapes: Sequence[Mapping[str, Any]] | None = None


@dataclass(slots=True)
class Joint(Part):
    """What joins two points, ``"ground.O"`` and ``"crank.A"``."""

    _section: ClassVar[str] = "joints"

    type: ClassVar[str]

    first: str
    second: str
    _: dataclasses.KW_ONLY
    cut: bool | None = None


@dataclass(slots=True)
class Revolute(Joint):
    """Turns about ``axis``, which is z unless given."""

    type: ClassVar[str] = "revolute"

    axis: Sequence[Value] | None = None
    coordinate: str | None = None
    second_: Sequence[Value] | None = None


@dataclass(slots=True)
class Prismatic(Joint):
    """Slides along ``axis`` of the first body, or at the angle ``direction`` to its x."""

    type: ClassVar[str] = "prismatic"

    axis: Sequence[Value] | None = None
    direction: Value | None = None
    angle: Value | None = None
    coordinate: str | None = None
    second_: Sequence[Value] | None = None


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

    With a ``radius`` a roller about the point touches the curve, on its ``side`` ``"left"`` or ``"right"``.
    """

    type: ClassVar[str] = "point-on-curve"

    curve: str
    radius: Value | None = None
    side: str | None = None
    coordinate: str | None = None


@dataclass(slots=True)
class LineOnCurve(Joint):
    """The line along ``axis`` through the second point touches the ``curve`` of that name."""

    type: ClassVar[str] = "line-on-curve"

    curve: str
    axis: Sequence[Value] | None = None
    direction: Value | None = None
    coordinate: str | None = None


@dataclass(slots=True)
class CurveOnCurve(Joint):
    """The ``second_curve`` of the second body touches the ``curve`` of the first.

    ``tangents`` are ``"opposite"`` or the ``"same"`` as both parameters rise. With ``rolling``, the parameters of two
    points that come together, the curves do not slip.
    """

    type: ClassVar[str] = "curve-on-curve"

    curve: str
    second_curve: str
    tangents: str | None = None
    rolling: Sequence[Value] | None = None
    coordinate: Sequence[str] | None = None


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


@dataclass(kw_only=True, slots=True)
class Load(Part):
    """What pulls, pushes or turns."""

    _section: ClassVar[str] = "loads"

    type: ClassVar[str]


@dataclass(kw_only=True, slots=True)
class Gravity(Load):
    """Free fall: ``Gravity(acceleration=[0, "-9.81 m/s^2"])``."""

    type: ClassVar[str] = "gravity"

    acceleration: Sequence[Value]


@dataclass(kw_only=True, slots=True)
class Force(Load):
    """``vector`` at the point ``on``, or ``value`` along the line ``between`` two points or in a ``joint``."""

    type: ClassVar[str] = "force"

    on: str | None = None
    vector: Sequence[Value] | None = None
    axes: str | None = None
    between: Sequence[str] | None = None
    joint: str | None = None
    of: str | None = None
    value: Value | None = None


@dataclass(kw_only=True, slots=True)
class Torque(Load):
    """``value`` about z, or ``vector``, ``on`` a body ``from_`` another; at a ``joint``, ``value`` about its axis."""

    type: ClassVar[str] = "torque"

    on: str | None = None
    from_: str | None = None
    joint: str | None = None
    of: str | None = None
    value: Value | None = None
    vector: Sequence[Value] | None = None


@dataclass(kw_only=True, slots=True)
class Spring(Load):
    """Between two points or in a ``joint`` that slides, with the unloaded ``length``."""

    type: ClassVar[str] = "spring"

    between: Sequence[str] | None = None
    joint: str | None = None
    of: str | None = None
    stiffness: Value
    length: Value
    damping: Value | None = None


@dataclass(kw_only=True, slots=True)
class Damper(Load):
    """Between two points or in a ``joint`` that slides."""

    type: ClassVar[str] = "damper"

    between: Sequence[str] | None = None
    joint: str | None = None
    of: str | None = None
    damping: Value


@dataclass(kw_only=True, slots=True)
class Torsion(Load):
    """A spring, a damper or both about a joint that turns."""

    type: ClassVar[str] = "torsion"

    joint: str
    of: str | None = None
    stiffness: Value | None = None
    damping: Value | None = None
    angle: Value | None = None


@dataclass(kw_only=True, slots=True)
class Stop(Load):
    """Where the motion of a joint ends."""

    type: ClassVar[str] = "stop"

    joint: str
    of: str | None = None
    min: Value | None = None
    max: Value | None = None
    restitution: Value | None = None


@dataclass(kw_only=True, slots=True)
class Friction(Load):
    """Dry friction of a joint: a ``force`` where it slides, a ``torque`` where it turns, or a coefficient
    ``mu``, which follows the reaction of the joint: with the ``length`` of a sleeve whose ends bear, or the
    ``radius`` of a pin or thread."""

    type: ClassVar[str] = "friction"

    joint: str
    of: str | None = None
    force: Value | None = None
    torque: Value | None = None
    mu: Value | None = None
    static: Value | None = None
    length: Value | None = None
    radius: Value | None = None


@dataclass(kw_only=True, slots=True)
class Drive(Part):
    """A prescribed motion of a joint: ``Drive(joint="A", motion="2 rad/s*t")``."""

    _section: ClassVar[str] = "drives"

    joint: str
    motion: Value
    of: str | None = None


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
    Distance,
    Cylinder,
)
LOADS: tuple[type[Load], ...] = (
    Gravity,
    Force,
    Torque,
    Spring,
    Damper,
    Torsion,
    Stop,
    Friction,
)


def to_table(part: Body | Ground | Joint | Load | Drive) -> Table:
    """The table of a part in a model file."""
    if not isinstance(part, (Body, Ground, Joint, Load, Drive)):
        words = "no part of a model: write for example bksim.Body(…), bksim.Revolute(…), bksim.Gravity(…)"
        raise TypeError(f"{part!r} is {words}")
    table: Table = {}
    if isinstance(part, (Joint, Load)):
        table["type"] = part.type
    if isinstance(part, Joint):
        table["between"] = [part.first, part.second]
    for item in dataclasses.fields(part):
        value = getattr(part, item.name)
        if item.name in ("first", "second") or value is None or isinstance(value, dict) and not value:
            continue
        table[item.name.rstrip("_")] = plain(value)
    return table


P = TypeVar("P", Body, Ground, Drive)


def from_table(kind: type[P], table: Table) -> P:
    """The part that a table of a model file says."""
    return kind(**table)


def joint_from_table(table: Table) -> Joint:
    """The joint that a table of a model file says."""
    rest = {key: value for key, value in table.items() if key not in ("type", "between", "second")}
    if "second" in table:
        rest["second_"] = table["second"]
    kind = next(kind for kind in JOINTS if kind.type == table["type"])
    return kind(*table["between"], **rest)


def load_from_table(table: Table) -> Load:
    """The load that a table of a model file says."""
    rest = {key: value for key, value in table.items() if key not in ("type", "from")}
    if "from" in table:
        rest["from_"] = table["from"]
    kind = next(kind for kind in LOADS if kind.type == table["type"])
    return kind(**rest)
