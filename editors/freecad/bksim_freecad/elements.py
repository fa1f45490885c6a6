"""Bodies, joints, loads and the rest of a mechanism as objects of a document, saved with it.

An element has its kind, its name, a text for each key, and what it refers to in the drawing: the parts of a body,
the places and the axis of a joint or load. Faults that `bksim` finds stand in its property `Fault`.
"""

import FreeCAD

from . import geometry, kinds
from .values import typed

GEOMETRY = "Drawing"
KEYS = "bksim"
# Bits of a property in FreeCAD.
READ_ONLY, HIDDEN = 1, 4
# Units of bare numbers in a mechanism that is begun in a document: those of the drawing.
BEGUN_WITH = {"units": {"length": "mm"}, "model": {"space": "planar"}}


class Element:
    """What FreeCAD calls for an element; everything that is kept is in its properties."""

    def __init__(self, obj):
        obj.Proxy = self

    def execute(self, obj):
        """Draws the mark again when what it refers to has changed, unless the parts are moving."""
        from . import marks

        if not any(body.Home for body in all_of(obj.Document, "bodies")):
            marks.redraw(obj)

    def dumps(self):
        return None

    def loads(self, state):
        return None

    __getstate__, __setstate__ = dumps, loads


def mechanism(doc, create=True, begun_with=BEGUN_WITH):
    """The group that holds the elements of a document, made with some elements in it where there is none."""
    for obj in doc.Objects:
        if getattr(obj, "IsMechanism", False):
            return obj
    if not create:
        return None
    group = doc.addObject("App::DocumentObjectGroupPython", "Mechanism")
    group.addProperty("App::PropertyBool", "IsMechanism", KEYS, "", HIDDEN | READ_ONLY)
    group.addProperty("App::PropertyPlacement", "Plane", KEYS,
                      "The frame of the ground: the mechanism of a plane lies in its x and y")
    group.addProperty("App::PropertyString", "Log", KEYS, "The log of the last run", HIDDEN)
    group.IsMechanism = True
    if FreeCAD.GuiUp:
        from .views import GroupView

        GroupView(group.ViewObject)
    for section, values in begun_with.items():
        add(doc, section, "", values)
    return group


def all_of(doc, section=None):
    """The elements of a document in their order, or those of one section."""
    group = mechanism(doc, create=False)
    found = [obj for obj in group.Group if hasattr(obj, "Kind")] if group else []
    return [obj for obj in found if section is None or section_of(obj) == section]


def section_of(obj):
    """The section of the model file that an element belongs to."""
    return obj.Kind.partition(".")[0]


def kind_of(obj):
    """The kind of an element."""
    return kinds.all_kinds()[obj.Kind]


def is_element(obj):
    """Whether an object of a document is an element."""
    return hasattr(obj, "Kind") and hasattr(obj, "ElementName")


def find(doc, section, name=""):
    """The element of a section and name, or `None`."""
    return next((obj for obj in all_of(doc, section) if obj.ElementName == name), None)


def free_name(doc, kind):
    """A name that no element of the section has: letters for joints, numbered words for the rest."""
    taken = {obj.ElementName for obj in all_of(doc)}
    letters = (chr(code) for code in range(ord("A"), ord("Z") + 1))
    stem = kind.type.replace("-", "_") or {"bodies": "body", "points": "P"}.get(kind.section, kind.section.rstrip("s"))
    numbered = (f"{stem}{number}" for number in range(1, len(taken) + 2))
    choices = [*letters, *numbered] if kind.section == "joints" else [stem, *numbered]
    return next(name for name in choices if name not in taken)


def set_kind(obj, kind):
    """Gives an element the properties of a kind; those of keys that the kind has not are removed."""
    obj.Kind = kind.id
    wanted = {key.attribute: key for key in kind.keys}
    for name in obj.PropertiesList:
        if obj.getGroupOfProperty(name) == KEYS and name not in (*wanted, "Kind", "ElementName", "Fault", "Body", "FromDrawing"):
            obj.removeProperty(name)
    for name, key in wanted.items():
        if name not in obj.PropertiesList:
            obj.addProperty("App::PropertyString", name, KEYS, key.meaning)
    for number in ("One", "Two")[:kind.places]:
        if f"Place{number}" not in obj.PropertiesList:
            obj.addProperty("App::PropertyLinkSubGlobal", f"Place{number}", GEOMETRY, "Where it is, on which part")
    if kind.key("axis") and "AxisFrom" not in obj.PropertiesList:
        obj.addProperty("App::PropertyLinkSubGlobal", "AxisFrom", GEOMETRY, "A line, circle or face that gives its axis")


def create(doc, kind):
    """An empty element in the group of the mechanism."""
    obj = doc.addObject("Part::FeaturePython", kind.section)
    Element(obj)
    obj.addProperty("App::PropertyString", "Kind", KEYS, "Section and type in the model file", READ_ONLY)
    obj.addProperty("App::PropertyString", "ElementName", KEYS, "Its name in the model file")
    obj.addProperty("App::PropertyString", "Fault", KEYS, "What bksim found", READ_ONLY)
    if kind.section in ("bodies", "ground"):
        obj.addProperty("App::PropertyLinkListGlobal", "Parts", GEOMETRY, "Sketches, wires and solids that it is made of")
    if kind.section == "bodies":
        obj.addProperty("App::PropertyBool", "FromDrawing", KEYS,
                        "Takes what is left empty from its parts: centre of mass, inertia, and the guess of its start")
        obj.addProperty("App::PropertyPlacementList", "Home", GEOMETRY, "Where its parts are drawn, while they move", HIDDEN)
        obj.FromDrawing = True
    if kind.section == "points":
        obj.addProperty("App::PropertyString", "Body", KEYS, "Its body, or `ground`, where its place is on another one")
    if FreeCAD.GuiUp:
        from .views import ElementView

        ElementView(obj.ViewObject)
    mechanism(doc).addObject(obj)
    return obj


def add(doc, kind_id, name="", values=None, **links):
    """A new element, or the one of this section and name with its values replaced.

    `values` has a text, a number or a list for each key; `links` are `parts` (objects), `place_one`, `place_two` and
    `axis_from` (an object, or an object and the name of its element), `body` and `from_drawing`.
    """
    kind = kinds.all_kinds()[kind_id]
    mechanism(doc)
    is_named = kind.form in ("table", "row", "point")
    name = (name or free_name(doc, kind)) if is_named else ""
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
        setattr(obj, attribute, value)
    obj.Label = label(obj)
    obj.touch()
    return obj


def label(obj):
    """What the tree shows: the name and the kind."""
    kind = kind_of(obj)
    word = kind.type or {"bodies": "body", "points": "point"}.get(kind.section, kind.section.rstrip("s"))
    return f"{obj.ElementName} ({word})" if obj.ElementName else word


def text(obj, key):
    """The text of a key; empty where the element has none."""
    known = kind_of(obj).key(key)
    return getattr(obj, known.attribute, "").strip() if known else ""


def link(obj, attribute):
    """The object and its element that a link of an element leads to, or `None`."""
    value = getattr(obj, attribute, None)
    if not value or value[0] is None:
        return None
    return value[0], (value[1][0] if value[1] else "")


def body_of(doc, part):
    """The body that an object of the drawing is a part of, or `None` for the ground."""
    chain = geometry.owners(part)
    return next((body for body in all_of(doc, "bodies") if any(own in body.Parts for own in chain)), None)
