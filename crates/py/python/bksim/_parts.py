"""The parts of a model as objects, and as the tables of a model file.

Values are numbers in the units of the file (SI unless it says otherwise), or texts with a unit or an
expression: ``0.25``, ``"250 mm"``, ``"l1/2"``. What is ``None`` is left out.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeVar

from ._assigned import Part, Point, Value, plain
from ._joints import Joint

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
    as_stated: bool | None = None
    flexible: Mapping[str, Any] | None = None


@dataclass(slots=True)
class Ground:
    """The body that does not move."""

    points: dict[str, Point] = field(default_factory=dict)
    outline: Sequence[Any] | None = None
    shapes: Sequence[Mapping[str, Any]] | None = None


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
    ``radius`` of a pin or thread. Of teeth ``coupling`` names the gear or rack, with ``pressure_angle`` or the
    ``loss`` factor."""

    type: ClassVar[str] = "friction"

    joint: str | None = None
    coupling: str | None = None
    of: str | None = None
    force: Value | None = None
    torque: Value | None = None
    mu: Value | None = None
    static: Value | None = None
    length: Value | None = None
    radius: Value | None = None
    pressure_angle: Value | None = None
    loss: Value | None = None


@dataclass(kw_only=True, slots=True)
class Drive(Part):
    """A prescribed motion of a joint: ``Drive(joint="A", motion="2 rad/s*t")``."""

    _section: ClassVar[str] = "drives"

    joint: str
    motion: Value
    of: str | None = None


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


def load_from_table(table: Table) -> Load:
    """The load that a table of a model file says."""
    rest = {key: value for key, value in table.items() if key not in ("type", "from")}
    if "from" in table:
        rest["from_"] = table["from"]
    kind = next(kind for kind in LOADS if kind.type == table["type"])
    return kind(**rest)
