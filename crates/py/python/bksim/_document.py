"""The model as its author wrote it, as objects."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from ._assigned import Value, plain, trusted
from ._joints import Joint, joint_from_table
from ._parts import Body, Drive, Ground, Load, from_table, load_from_table, to_table


# Sections without classes of their own.
OTHERS = ("tables", "curves", "couplings", "conditions", "contacts", "states", "clocks", "signals", "outputs")


@dataclass
class Document:
    """A model as its author wrote it, as objects."""

    name: str | None = None
    space: str | None = None
    policy: str | None = None
    units: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, Value] = field(default_factory=dict)
    ground: Ground = field(default_factory=Ground)
    bodies: dict[str, Body] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    loads: dict[str, Load] = field(default_factory=dict)
    drives: dict[str, Drive] = field(default_factory=dict)
    # Tables, curves, couplings, states, clocks and signals, as they are written.
    others: dict[str, dict[str, Any]] = field(default_factory=dict)
    initial: dict[str, Any] = field(default_factory=dict)
    options: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, tables: dict[str, Any]) -> Document:
        with trusted():
            return cls._of(tables)

    @classmethod
    def _of(cls, tables: dict[str, Any]) -> Document:
        def each(key: str) -> Iterator[tuple[str, dict[str, Any]]]:
            return iter(tables.get(key, {}).items())

        return cls(
            name=tables.get("name"),
            space=tables.get("space"),
            policy=tables.get("coordinates"),
            units=tables.get("units", {}),
            parameters=tables.get("parameters", {}),
            ground=from_table(Ground, tables.get("ground", {})),
            bodies={name: from_table(Body, table) for name, table in each("bodies")},
            joints={name: joint_from_table(table) for name, table in each("joints")},
            loads={name: load_from_table(table) for name, table in each("loads")},
            drives={name: from_table(Drive, table) for name, table in each("drives")},
            others={key: tables[key] for key in OTHERS if key in tables},
            initial=tables.get("initial", {}),
            options=tables.get("solve", {}),
        )

    def tables(self) -> dict[str, Any]:
        tables: dict[str, Any] = {
            "name": self.name,
            "space": self.space,
            "coordinates": self.policy,
            "units": plain(self.units),
            "parameters": plain(self.parameters),
            "ground": to_table(self.ground),
            "bodies": {name: to_table(body) for name, body in self.bodies.items()},
            "joints": {name: to_table(joint) for name, joint in self.joints.items()},
            "loads": {name: to_table(load) for name, load in self.loads.items()},
            "drives": {name: to_table(drive) for name, drive in self.drives.items()},
            **{key: plain(table) for key, table in self.others.items()},
            "initial": plain(self.initial),
            "solve": plain(self.options),
        }
        return {key: table for key, table in tables.items() if table}
