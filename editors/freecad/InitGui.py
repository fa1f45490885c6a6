"""The workbench `bksim` of FreeCAD."""

import FreeCADGui


class BksimWorkbench(FreeCADGui.Workbench):
    """Bodies, joints and loads on what is drawn, their equations and motion."""

    MenuText = "bksim"
    ToolTip = "Mechanisms: bodies, joints, equations, motion"

    def __init__(self):
        from bksim_freecad.views import icon

        self.__class__.Icon = icon("workbench")

    def Initialize(self):
        from bksim_freecad import commands

        for title, names in commands.register():
            self.appendMenu(["bksim", title], names)
            if title != "More elements":
                self.appendToolbar(title, names)

    def GetClassName(self):
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(BksimWorkbench())
