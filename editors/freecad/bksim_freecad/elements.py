"""Bodies, joints, loads and the rest of a mechanism as objects of a document, saved with it.

An element has its kind, its name, a text for each key, and what it refers to in the drawing: the parts of a body,
the places and the axis of a joint or load. Its property `Fault` has what `bksim` finds.
"""

import re

from . import geometry, kinds
from .values import split

PLACE = re.compile(r"\w+(\.\w+)?")


def mechanism(doc):
    """The group that holds the elements of a document, or `None`."""
    return next((obj for obj in doc.Objects if getattr(obj, "IsMechanism", False)), None)


def all_of(doc, section=None):
    """The elements of a document in their order, or those of one section."""
    group = mechanism(doc)
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


def text(obj, key):
    """The text of a key; empty where the element has none."""
    known = kind_of(obj).key(key)
    return getattr(obj, known.attribute, "").strip() if known else ""


def typed_places(obj):
    """The points that a joint or load names in words: `crank.A`, or a body alone."""
    kind = kind_of(obj)
    if not kind.places or kind.section == "points":
        return []
    words = [word.strip("\"'") for word in split((text(obj, "between") or text(obj, "on")).strip("[] "))]
    return words if all(PLACE.fullmatch(word) for word in words) else []


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
