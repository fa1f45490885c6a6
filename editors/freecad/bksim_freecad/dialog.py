"""The dialog of an element: a row for each key of its kind, and one for each place in the drawing."""

import FreeCAD
import FreeCADGui
from PySide import QtGui

from . import editing, elements, geometry, kinds, operations

PLACES = {"place_one": "Place", "place_two": "Second place", "axis_from": "Axis from"}
current = None  # the dialog that is open


def selected_places():
    """What is selected, each an object with one of its vertices, edges or faces, or none."""
    found = []
    for choice in FreeCADGui.Selection.getSelectionEx():
        found += [(choice.Object, sub) for sub in choice.SubElementNames or [""]]
    return found


def shown(target):
    """A place in words."""
    return f"{target[0].Label} {target[1]}".strip() if target else "none"


class Row:
    """A text that can be typed or, of a list, chosen."""

    def __init__(self, key, value, names=()):
        self.key = key
        if key.choices or names:
            self.widget = QtGui.QComboBox()
            self.widget.setEditable(not key.choices)
            self.widget.addItems(["", *(key.choices or names)])
            self.widget.setCurrentText(value) if not key.choices else self.widget.setCurrentIndex(
                max(self.widget.findText(value), 0)
            )
        else:
            self.widget = QtGui.QLineEdit(value)
            self.widget.setPlaceholderText(key.meaning.replace("`", ""))
        self.widget.setToolTip(key.meaning)

    @property
    def text(self):
        return self.widget.currentText() if isinstance(self.widget, QtGui.QComboBox) else self.widget.text()

    @text.setter
    def text(self, value):
        if not isinstance(self.widget, QtGui.QComboBox):
            self.widget.setText(value)
        elif self.widget.isEditable():
            self.widget.setEditText(value)
        else:
            self.widget.setCurrentIndex(self.widget.findText(value))


class PlaceRow:
    """A place that is taken from the selection."""

    def __init__(self, value):
        self.value, self.widget = value, QtGui.QWidget()
        self.words = QtGui.QLabel(shown(value))
        layout = QtGui.QHBoxLayout(self.widget)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.words, 1)
        for title, tip, action in (
            ("Take", "Take what is selected", self.take),
            ("✕", "Take none", lambda: self.put(None)),
        ):
            button = QtGui.QToolButton()
            button.setText(title)
            button.setToolTip(tip)
            button.clicked.connect(lambda *_, action=action: action())
            layout.addWidget(button)

    def put(self, value):
        self.value = value
        self.words.setText(shown(value))

    def take(self):
        found = selected_places()
        self.put(found[0] if found else None)


class PartsRow(PlaceRow):
    """The parts of a body, taken from the selection."""

    def put(self, value):
        self.value = value or []
        self.words.setText(", ".join(part.Label for part in self.value) or "none")

    def take(self):
        self.put([obj for obj in FreeCADGui.Selection.getSelection() if not elements.is_element(obj)])


class Dialog:
    """A task panel for one element, or for a new one of a section."""

    def __init__(self, section, obj=None):
        self.doc = obj.Document if obj else FreeCAD.ActiveDocument or FreeCAD.newDocument()
        self.obj, self.section = obj, section
        self.form = QtGui.QWidget()
        self.form.setWindowTitle("bksim: " + (obj.Label if obj else section))
        self.layout = QtGui.QFormLayout(self.form)
        self.choices = kinds.of_section(section)
        self.type = QtGui.QComboBox()
        self.type.addItems([kind.type for kind in self.choices])
        if obj:
            self.type.setCurrentText(elements.kind_of(obj).type)
        if len(self.choices) > 1:
            self.layout.addRow("type", self.type)
        self.rows, self.links, self.proposed = {}, {}, ""
        # What was selected when the dialog was opened are its places and parts.
        chosen = [] if obj else selected_places()
        self.chosen = dict(zip(("place_one", "place_two"), chosen))
        parts = (geometry.movable(part) for part, _ in chosen if not elements.is_element(part))
        self.parts = list(dict.fromkeys(parts))
        self.fill()
        self.type.currentIndexChanged.connect(lambda *_: self.fill())

    @property
    def kind(self):
        return self.choices[max(self.type.currentIndex(), 0)]

    def fill(self):
        """Rows for the kind that is chosen, with what has been typed in those that it had before."""
        typed = {name: row.text for name, row in self.rows.items()}
        kept = {name: row.value for name, row in self.links.items()}
        while self.layout.rowCount() > (1 if len(self.choices) > 1 else 0):
            self.layout.removeRow(self.layout.rowCount() - 1)
        self.rows, self.links = {}, {}
        if self.kind.form in ("table", "row", "point"):
            name = typed.get("name", self.obj.ElementName if self.obj else self.proposed)
            if name == self.proposed and not self.obj:
                # A name that nobody has typed follows the kind.
                parts = self.parts if self.section == "bodies" else ()
                name = self.proposed = editing.free_name(self.doc, self.kind, parts)
            self.rows["name"] = Row(kinds.Key("name", "its name in the model"), name)
            self.layout.addRow("name", self.rows["name"].widget)
        if self.section in ("bodies", "ground"):
            value = kept.get("parts", self.obj.Parts if self.obj else self.parts)
            self.add_link("parts", "Parts", PartsRow([]))
            self.links["parts"].put(value)
        wanted = list(PLACES)[: self.kind.places] + (["axis_from"] if self.kind.key("axis") else [])
        for name in wanted:
            attribute = "".join(word.capitalize() for word in name.split("_"))
            value = elements.link(self.obj, attribute) if self.obj else self.chosen.get(name)
            self.add_link(name, PLACES[name], PlaceRow(kept.get(name, value)))
        for key in self.kind.keys:
            value = typed.get(f"key {key.name}", elements.text(self.obj, key.name) if self.obj else "")
            row = self.rows[f"key {key.name}"] = Row(key, value, self.names(key))
            self.layout.addRow(key.name, row.widget)

    def add_link(self, name, title, row):
        self.links[name] = row
        self.layout.addRow(title, row.widget)

    def names(self, key):
        """Names of the mechanism that a key may have."""
        sections = {
            "joint": "joints",
            "on": "bodies",
            "from": "bodies",
            "carrier": "bodies",
            "coupling": "couplings",
            "curve": "curves",
            "second_curve": "curves",
            "clock": "clocks",
            "law": "curves",
        }
        section = sections.get(key.name)
        return [obj.ElementName for obj in elements.all_of(self.doc, section)] if section else []

    def values(self):
        """What is typed in the rows of keys."""
        return {name[4:]: row.text for name, row in self.rows.items() if name.startswith("key ")}

    def accept(self):
        """Adds or changes the element, and closes."""
        links = {name: row.value for name, row in self.links.items()}
        name = self.rows["name"].text.strip() if "name" in self.rows else ""
        if self.obj:
            with operations.step(self.doc, "Edit"):
                self.obj.ElementName = name
                editing.edit(self.obj, self.kind.id, self.values(), **links)
        else:
            self.obj = operations.add(self.doc, self.kind.id, name, self.values(), **links)
        return close()

    def reject(self):
        return close()


class Starts:
    """A task panel with the start of every joint and body."""

    def __init__(self):
        self.doc = FreeCAD.ActiveDocument
        self.form = QtGui.QWidget()
        self.form.setWindowTitle("bksim: initial values")
        layout = QtGui.QFormLayout(self.form)
        self.rows = {}
        for section in reversed(kinds.WITH_START):
            for obj in elements.all_of(self.doc, section):
                row = Row(kinds.Key("initial", kinds.START), elements.text(obj, "initial"))
                self.rows[obj.ElementName] = row
                layout.addRow(obj.Label, row.widget)

    def accept(self):
        operations.set_starts(self.doc, {name: row.text for name, row in self.rows.items()})
        return close()

    def reject(self):
        return close()


def show(panel):
    """Opens a task panel; refusals of the program that it needs are said in a box."""
    global current
    current = panel
    FreeCADGui.Control.closeDialog()
    FreeCADGui.Control.showDialog(panel)
    return panel


def close():
    """Closes the task panel."""
    global current
    current = None
    FreeCADGui.Control.closeDialog()
    return True


def add(section):
    """Opens the dialog of a new element, or of the one that a mechanism has of its section."""
    doc = FreeCAD.ActiveDocument
    single = kinds.of_section(section)[0].form in ("single", "top")
    return show(Dialog(section, elements.find(doc, section) if doc and single else None))


def edit(obj):
    """Opens the dialog of an element."""
    return show(Dialog(elements.section_of(obj), obj))
