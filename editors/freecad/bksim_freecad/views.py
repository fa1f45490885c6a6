"""How the mechanism and its elements look in the tree."""

import os

FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "icons")


def icon(name):
    """The file of an icon, that of an element of no special kind where there is none."""
    path = os.path.join(FOLDER, f"{name}.svg")
    return path if os.path.exists(path) else os.path.join(FOLDER, "element.svg")


class GroupView:
    """The mechanism in the tree."""

    def __init__(self, view):
        view.Proxy = self

    def getIcon(self):
        return icon("workbench")

    def dumps(self):
        return None

    def loads(self, state):
        return None

    __getstate__, __setstate__ = dumps, loads


class ElementView(GroupView):
    """An element in the tree: the icon of its section, or that of an error; a double click edits it."""

    def __init__(self, view):
        super().__init__(view)
        view.LineColor = view.PointColor = (0.96, 0.56, 0.1)
        view.LineWidth, view.PointSize = 2, 5

    def attach(self, view):
        self.view = view

    def getIcon(self):
        obj = self.view.Object
        return icon("fault" if "error" in obj.Fault else obj.Kind.partition(".")[0])

    def updateData(self, obj, name):
        if name == "Fault":
            obj.ViewObject.signalChangeIcon()

    def doubleClicked(self, view):
        import FreeCADGui

        FreeCADGui.Selection.clearSelection()
        FreeCADGui.Selection.addSelection(view.Object)
        FreeCADGui.runCommand("Bksim_Edit")
        return True

    def getDisplayModes(self, view):
        return []

    def __getstate__(self):
        return None

    dumps = __getstate__
