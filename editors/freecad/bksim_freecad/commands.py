"""The commands of the workbench: each row of these tables is one, in the toolbar and the menu."""

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from . import dialog, elements, operations, panels, program
from .views import icon

# Sections of a model file in the order of a user's work, with what a new element of each is.
ADD = {
    "bodies": ("Body", "Make what is selected a body: its mass from the drawing with a density, or as it is typed"),
    "points": ("Point", "Name a point of a body, where a vertex, a circle or a face is selected"),
    "joints": ("Joint", "Join two bodies, or a body and the ground, at one or two selected places"),
    "couplings": ("Coupling", "Couple the motions of joints: gears, belts, racks, screws, relations"),
    "loads": ("Load", "Add gravity, a force, a torque, a spring, a damper, a stop or friction"),
    "drives": ("Drive", "Prescribe the motion of a joint"),
    "parameters": ("Parameter", "Give a value a name that others may use"),
    "solve": ("Run settings", "Say how long, how often and how exactly the motion is found"),
}
MORE = {
    "ground": ("Ground", "Name points of the body that does not move"),
    "units": ("Units", "Say what bare numbers mean"),
    "model": ("Mechanism", "Set its name, plane or space, and the choice of coordinates"),
    "outputs": ("Output", "Name a quantity of the results"),
    "signals": ("Signal", "Name an expression of the motion"),
    "states": ("State", "Add a quantity that is integrated with the motion"),
    "clocks": ("Clock", "Add instants at which signals are sampled"),
    "tables": ("Table", "Add measured values as a function"),
    "curves": ("Curve", "Add a path or the law of a cam"),
    "use": ("Use of a part", "Add a mechanism of another file, or one that comes with bksim"),
    "io": ("Inputs and outputs", "Say what goes into the mechanism and comes out"),
    "initial": ("Initial value", "State the start of a coordinate by its name"),
    "conditions": ("Condition", "Hold a sum of rates at zero"),
    "contacts": ("Contact", "Let two outlines touch, push each other apart and rub"),
    "ranges": ("Range", "Say between which values sliders and searches move a number"),
    "cases": ("Load case", "Name other values of parameters, loads and drives"),
    "optimize": ("Optimum", "Say what is to be least or largest, and what may vary"),
    "fit": ("Fit", "Say which values follow from measured curves"),
    "tolerance": ("Tolerance", "Give limits of values, and what they act on"),
}


def chosen():
    """Elements of the mechanism that are selected."""
    return [obj for obj in FreeCADGui.Selection.getSelection() if elements.is_element(obj)]


def document():
    return FreeCAD.ActiveDocument or FreeCAD.newDocument()


def edit():
    for obj in chosen()[:1]:
        dialog.edit(obj)


def delete():
    operations.delete(document(), chosen())


def starts():
    dialog.show(dialog.Starts())


def check():
    count, faults = operations.check(document())
    names = ("bodies", "joints", "couplings", "loads", "drives", "coordinates", "cut_joints")
    lines = [f"{name.replace('_', ' '):12} {' '.join(count[name])}" for name in names if count[name]] if count else []
    numbers = ("constraints", "gruebler", "mobility", "redundant_conditions")
    lines += [f"{name.replace('_', ' '):22} {count[name]}" for name in numbers] if count else ["rejected"]
    panels.get().report("\n".join(lines), faults)


def equations():
    panels.get().equations(operations.equations(document()))


def start():
    found, faults = operations.start(document())
    lines = [f"t = {found['t']} s", "", f"{'coordinate':16} {'value':>16} {'velocity':>16} {'acceleration':>16}"]
    for name, value in found["q"].items():
        rates = (found["v"].get(name), found["a"].get(name))
        lines.append(f"{name:16} {value:16.9g} " + " ".join("" if rate is None else f"{rate:16.9g}" for rate in rates))
    lines += ["", *(f"{name:16} {value:16.9g}" for name, value in found["lambda"].items())]
    panels.get().report("\n".join(lines), faults)


def solve():
    progress = QtGui.QProgressDialog("Solving …", "Stop", 0, 0, FreeCADGui.getMainWindow())
    progress.setMinimumDuration(500)

    def meanwhile():
        progress.setValue(0)
        QtCore.QCoreApplication.processEvents()
        return not progress.wasCanceled()

    try:
        found, faults = operations.solve(document(), meanwhile)
    finally:
        progress.close()
    panel = panels.get()
    panel.solved()
    steps, end = found["steps"], found["end"]
    panel.report(
        f"solved up to t = {end['t']:g} s{'' if end['reached'] else ', ended early'}\n"
        f"samples   {found['samples']}\n"
        f"steps     {steps['n_accept']} accepted, {steps['n_reject']} rejected\n"
        f"method    {', '.join(row['method'] for row in found['methods'])}\n"
        f"time      {found['time_s']['total']:.3f} s\n"
        f"log       {found['output']}",
        faults,
    )


def curves():
    panels.get().draw()


def play():
    panels.get().play()


def home():
    panels.get().home()


def export():
    path, _ = QtGui.QFileDialog.getSaveFileName(None, "Export", "model.toml", "Models (*.toml)")
    if path:
        operations.export(document(), path)


def read():
    kinds = "*.toml *.dxf *.dwg *.urdf *.xml *.sdf *.adm"
    path, _ = QtGui.QFileDialog.getOpenFileName(None, "Import", "", f"Mechanisms ({kinds});;All files (*)")
    if path:
        operations.read_file(document(), path)
        FreeCADGui.SendMsgToActiveView("ViewFit")


ASK = {
    "edit": ("Edit", "Change the selected element", edit),
    "delete": ("Delete", "Remove the selected elements", delete),
    "starts": ("Initial values", "State where and how fast the motion starts", starts),
    "check": ("Check", "Count freedoms and find faults", check),
    "equations": ("Equations", "Show energies, Lagrange's equations and constraints", equations),
    "start": ("Start", "Find the consistent start, and put the parts there", start),
    "run": ("Solve", "Find the motion", solve),
    "plot": ("Curves", "Draw results over time", curves),
    "play": ("Play", "Move the parts as they were found to move, or stop", play),
    "home": ("Drawn pose", "Put the parts where they are drawn", home),
    "export": ("Export model", "Write the model file", export),
    "import": ("Import", "Read a model file, a drawing with attributes, or a mechanism of another program", read),
}


class Command:
    """A row of the tables as FreeCAD calls it; what `bksim` refuses is shown in the panel."""

    def __init__(self, name, title, tip, action):
        self.name, self.title, self.tip, self.action = name, title, tip, action

    def GetResources(self):
        return {"Pixmap": icon(self.name), "MenuText": self.title, "ToolTip": self.tip}

    def IsActive(self):
        return True

    def Activated(self, *_):
        try:
            self.action()
        except (program.Failed, ValueError) as failed:
            FreeCAD.Console.PrintError(f"bksim: {failed}\n")
            panels.get().report(str(failed), getattr(failed, "faults", ()))


def command_name(name):
    """The name of a command for `FreeCADGui.runCommand`."""
    return f"Bksim_{name.capitalize()}"


def register():
    """Adds the commands to FreeCAD: titles of groups with their names."""
    groups = []
    for title, table in (("Elements", ADD), ("More elements", MORE), ("Questions", ASK)):
        names = []
        for name, (words, tip, *action) in table.items():
            act = action[0] if action else (lambda section=name: dialog.add(section))
            FreeCADGui.addCommand(command_name(name), Command(name, words, tip, act))
            names.append(command_name(name))
        groups.append((title, names))
    return groups
