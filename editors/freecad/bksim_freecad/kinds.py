"""What can be added to a mechanism, with its keys: read from `bksim schema`, so that nothing is listed twice."""

import functools
import json
from dataclasses import dataclass

from . import program

# Keys that the document adds: the start of one body or joint is kept with it.
WITH_START = ("bodies", "joints")
START = "its entry of [initial], such as { angle = 30 deg, rate = 0 } or { guess = { angle = 30 deg } }"
POINT = "its place in the frame of the body, such as [l1, 0]; that of the geometry unless given"
# Joints and loads whose two points are apart.
APART = {"link", "distance", "cylinder", "spring", "damper", "force"}
# Joints of a plane whose axis is in it.
SLIDING = {"prismatic", "slot"}

# Properties that objects of FreeCAD have by themselves.
TAKEN = {"Name", "Shape"}


@dataclass(frozen=True)
class Key:
    """A key with its meaning; `choices` are those of a list, none for free text."""

    name: str
    meaning: str = ""
    choices: tuple = ()

    @property
    def attribute(self):
        """The property of a document's object that holds it."""
        camel = "".join(word.capitalize() for word in self.name.split("_"))
        return f"Model{camel}" if camel in TAKEN else camel


@dataclass(frozen=True)
class Kind:
    """A table of a model file: `[section.NAME]` with a type, `[section.NAME]`, `[section]`, or a row of it."""

    section: str
    type: str
    keys: tuple
    form: str  # "table", "row" of a section of rows, "single" table, "top" of the file

    @property
    def id(self):
        return f"{self.section}.{self.type}" if self.type else self.section

    def key(self, name):
        """The key of this name, or `None`."""
        return next((key for key in self.keys if key.name == name), None)

    @property
    def places(self):
        """How many places of the drawing it takes."""
        if self.section == "points":
            return 1
        if self.section == "couplings" or self.type == "torque":
            return 0
        return 2 if self.key("between") else int(self.key("on") is not None and self.section == "loads")


def key_from(name, entry):
    """A key of the schema."""
    choices = tuple(entry.get("enum", ()))
    if entry.get("type") == "boolean":
        choices = ("true", "false")
    return Key(name, entry.get("description", ""), choices)


def kinds_of(section, entry):
    """The kinds of one section of the schema."""
    rows = entry.get("additionalProperties")
    properties = rows.get("properties", {}) if isinstance(rows, dict) else {}
    if not properties and "properties" in entry:
        keys = tuple(key_from(name, key) for name, key in entry["properties"].items())
        return [Kind(section, "", keys, "single")]
    if not properties:
        return [Kind(section, "", (Key("value", entry.get("description", "")),), "row")]
    extra = (Key("initial", START),) if section in WITH_START else ()
    own = {name: key_from(name, key) for name, key in properties.items() if name != "type"}
    kinds = [
        Kind(
            section,
            case["if"]["properties"]["type"]["const"],
            tuple(own[name] for name in case["then"]["propertyNames"]["enum"] if name != "type") + extra,
            "table",
        )
        for case in rows.get("allOf", ())
    ]
    return kinds or [Kind(section, "", tuple(own.values()) + extra, "table")]


@functools.cache
def all_kinds():
    """Every kind by its id, in the order of the schema."""
    sections = json.loads(program.text_of(["schema"]))["properties"]
    is_table = {name: entry.get("type") == "object" for name, entry in sections.items()}
    top = tuple(key_from(name, entry) for name, entry in sections.items() if not is_table[name])
    found = [Kind("model", "", top, "top")]
    for name, entry in sections.items():
        if is_table[name]:
            found += kinds_of(name, entry)
        if name == "bodies":
            found.append(Kind("points", "", (Key("at", POINT),), "point"))
    return {kind.id: kind for kind in found}


def of_section(section):
    """The kinds of one section."""
    return [kind for kind in all_kinds().values() if kind.section == section]
