"""Elements made, changed and given other kinds."""

import re

import FreeCAD

from . import geometry, kinds, marks, views
from .elements import all_of, find, kind_of, mechanism
from .values import typed

GEOMETRY = "Drawing"
KEYS = "bksim"
# Properties that an element of any kind keeps.
KEPT = ("Kind", "ElementName", "Fault", "Body", "FromDrawing")
# Bits of a property in FreeCAD.
READ_ONLY, HIDDEN = 1, 4
# Units of bare numbers in a mechanism that is begun in a document: those of the drawing.
BEGUN_WITH = {"units": {"length": "mm"}, "model": {"space": "planar"}}


def begin(doc, values=BEGUN_WITH):
    """The group that holds the elements of a document, made with some elements in it where there is none."""
    found = mechanism(doc)
    if found:
        return found
    group = doc.addObject("App::DocumentObjectGroupPython", "Mechanism")
    group.addProperty("App::PropertyBool", "IsMechanism", KEYS, "", HIDDEN | READ_ONLY)
    group.addProperty(
        "App::PropertyPlacement", "Plane", KEYS, "The frame of the ground: a mechanism of the plane is in its x and y"
    )
    group.addProperty("App::PropertyString", "Log", KEYS, "The log of the last run", HIDDEN)
    group.IsMechanism = True
    if FreeCAD.GuiUp:
        views.GroupView(group.ViewObject)
    for section, given in values.items():
        add(doc, section, "", given | ({"name": doc.Label} if section == "model" else {}))
    return group


def free_name(doc, kind, parts=()):
    """A name that no element has: letters for joints, that of its part for a body, numbered words for the rest."""
    taken = {obj.ElementName for obj in all_of(doc)}
    letters = (chr(code) for code in range(ord("A"), ord("Z") + 1))
    stem = kind.type.replace("-", "_") or {"bodies": "body", "points": "P"}.get(kind.section, kind.section.rstrip("s"))
    stem = re.sub(r"\W", "_", parts[0].Label) if parts else stem
    numbered = (f"{stem}{number}" for number in range(1, len(taken) + 2))
    choices = [*letters, *numbered] if kind.section == "joints" else [stem, *numbered]
    return next(name for name in choices if name not in taken)


def set_kind(obj, kind):
    """Gives an element the properties of a kind; those of keys that the kind has not are removed."""
    obj.Kind = kind.id
    wanted = {key.attribute: key for key in kind.keys}
    for name in obj.PropertiesList:
        if obj.getGroupOfProperty(name) == KEYS and name not in (*wanted, *KEPT):
            obj.removeProperty(name)
    for name, key in wanted.items():
        if name not in obj.PropertiesList:
            obj.addProperty("App::PropertyString", name, KEYS, key.meaning)
    for number in ("One", "Two")[: kind.places]:
        if f"Place{number}" not in obj.PropertiesList:
            obj.addProperty("App::PropertyLinkSubGlobal", f"Place{number}", GEOMETRY, "Where it is, on which part")
    if kind.key("axis") and "AxisFrom" not in obj.PropertiesList:
        obj.addProperty(
            "App::PropertyLinkSubGlobal", "AxisFrom", GEOMETRY, "A line, circle or face that gives its axis"
        )


def create(doc, kind):
    """An empty element in the group of the mechanism."""
    obj = doc.addObject("Part::FeaturePython", kind.section)
    marks.Element(obj)
    obj.addProperty("App::PropertyString", "Kind", KEYS, "Section and type in the model file", READ_ONLY)
    obj.addProperty("App::PropertyString", "ElementName", KEYS, "Its name in the model file")
    obj.addProperty("App::PropertyString", "Fault", KEYS, "What bksim found", READ_ONLY)
    if kind.section in ("bodies", "ground"):
        obj.addProperty(
            "App::PropertyLinkListGlobal", "Parts", GEOMETRY, "Sketches, wires and solids that it is made of"
        )
    if kind.section == "bodies":
        obj.addProperty(
            "App::PropertyBool",
            "FromDrawing",
            KEYS,
            "Takes what is left empty from its parts: centre of mass, inertia, and the guess of its start",
        )
        obj.addProperty(
            "App::PropertyPlacementList", "Home", GEOMETRY, "Where its parts are drawn, while they move", HIDDEN
        )
        obj.FromDrawing = True
    if kind.section == "points":
        obj.addProperty("App::PropertyString", "Body", KEYS, "Its body, or `ground`, where its place is on another one")
    if FreeCAD.GuiUp:
        views.ElementView(obj.ViewObject)
    mechanism(doc).addObject(obj)
    return obj


def add(doc, kind_id, name="", values=None, **links):
    """A new element, or the one of this section and name with its values replaced.

    `values` has a text, a number or a list for each key; `links` are `parts` (objects), `place_one`, `place_two` and
    `axis_from` (an object, or an object and the name of its element), `body` and `from_drawing`.
    """
    kind = kinds.all_kinds()[kind_id]
    begin(doc)
    is_named = kind.form in ("table", "row", "point")
    name = (name or free_name(doc, kind, links.get("parts"))) if is_named else ""
    obj = find(doc, kind.section, name) or create(doc, kind)
    obj.ElementName = name
    return edit(obj, kind_id, values or {}, **links)


def edit(obj, kind_id, values, **links):
    """Gives an element another kind, or other values and links; those that are not given stay."""
    kind = kinds.all_kinds()[kind_id]
    set_kind(obj, kind)
    for key, value in values.items():
        known = kind.key(key)
        if known is None:
            raise ValueError(f"`{kind_id}` has no key `{key}`: it has {', '.join(k.name for k in kind.keys)}")
        setattr(obj, known.attribute, value if isinstance(value, str) else typed(value))
    for link, value in links.items():
        attribute = "".join(word.capitalize() for word in link.split("_"))
        if link.startswith(("place", "axis")) and value is not None and not isinstance(value, tuple):
            value = (value, "")
        if link == "parts":
            value = list(dict.fromkeys(map(geometry.movable, value)))
        setattr(obj, attribute, value)
    obj.Label = label(obj)
    obj.touch()
    return obj


def label(obj):
    """What the tree shows: the name and the kind."""
    kind = kind_of(obj)
    word = kind.type or {"bodies": "body", "points": "point"}.get(kind.section, kind.section.rstrip("s"))
    return f"{obj.ElementName} ({word})" if obj.ElementName else word
