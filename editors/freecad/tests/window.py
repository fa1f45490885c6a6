"""The slider-crank by the commands of the workbench alone, in a window: selected, typed, accepted, run, played.

Run by FreeCAD with a window; pictures of it are written to the folder of the variable `PICTURES`.
"""

import os
import sys
import time
import traceback

sys.path[:0] = [os.path.dirname(os.path.abspath(__file__))]

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

import slider_crank

PICTURES = os.environ["PICTURES"]
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))


def wait(seconds):
    """Lets the window do what it has to."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        QtCore.QCoreApplication.processEvents()
        time.sleep(0.01)


def picture(name):
    wait(0.5)
    window = FreeCADGui.getMainWindow()
    pixels = QtGui.QGuiApplication.primaryScreen().grabWindow(window.winId())
    assert pixels.save(os.path.join(PICTURES, f"{name}.png"))


def select(doc, links):
    """Selects what links lead to, as by clicks in the drawing and the tree."""
    FreeCADGui.Selection.clearSelection()
    for value in links:
        for obj, sub in [(part, "") for part in value] if isinstance(value, list) else [value]:
            FreeCADGui.Selection.addSelection(obj, sub) if sub else FreeCADGui.Selection.addSelection(obj)


def attach(doc, kind, name, values, links):
    """Selects, calls the command, types and accepts."""
    from bksim_freecad import dialog, kinds

    found = slider_crank.linked(doc, links)
    axis = found.pop("axis_from", None)
    select(doc, list(found.values()))
    FreeCADGui.runCommand(f"Bksim_{kind.partition('.')[0].capitalize()}")
    panel = dialog.current
    panel.type.setCurrentText(kinds.all_kinds()[kind].type)
    if axis:
        select(doc, [axis])
        panel.links["axis_from"].take()
    if name:
        panel.rows["name"].text = name
    for key, value in values.items():
        panel.rows[f"key {key}"].text = value
    if name == "C":
        picture("dialog")
    panel.accept()
    wait(0.05)


def main():
    FreeCADGui.activateWorkbench("BksimWorkbench")
    from bksim_freecad import commands, elements, kinds, operations, panels

    sections = {kind.section for kind in kinds.all_kinds().values()}
    assert sections == commands.ADD.keys() | commands.MORE.keys(), "a section without a command"

    window = FreeCADGui.getMainWindow()
    window.resize(1200, 760)
    for dock in window.findChildren(QtGui.QDockWidget):
        dock.setVisible(dock.objectName() == "Combo View")
    doc = FreeCAD.newDocument("SliderCrank")
    slider_crank.draw(doc)
    FreeCADGui.ActiveDocument.ActiveView.viewTop()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    for row in slider_crank.ATTACHED:
        attach(doc, *row)
    assert len(elements.all_of(doc)) == len(slider_crank.ATTACHED) + 2, [obj.Label for obj in elements.all_of(doc)]

    # A fault is shown at its object, and goes away.
    rod = elements.find(doc, "bodies", "rod")
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(rod)
    FreeCADGui.runCommand("Bksim_Edit")
    from bksim_freecad import dialog

    dialog.current.rows["key mass"].text = "m2 + 1 m"
    dialog.current.accept()
    FreeCADGui.runCommand("Bksim_Check")
    assert "M03" in rod.Fault, rod.Fault
    picture("fault")
    doc.undo()
    FreeCADGui.runCommand("Bksim_Check")
    assert rod.Fault == "", rod.Fault

    FreeCADGui.runCommand("Bksim_Equations")
    assert "kinetic energy" in panels.get().text.toPlainText()
    picture("equations")
    FreeCADGui.runCommand("Bksim_Start")
    assert "theta1" in panels.get().summary.toPlainText()
    picture("start")
    FreeCADGui.runCommand("Bksim_Run")
    picture("solved")
    FreeCADGui.runCommand("Bksim_Plot")
    panel = panels.get()
    log = elements.mechanism(doc).Log
    drawn = panels.picture(log, ["state.x3"])
    assert drawn.renderer().isValid(), "curves without Matplotlib"
    assert panel.run is not None and len(panel.run.times) == 501
    panel.slider.setValue(180)
    picture("motion")
    before = FreeCAD.Placement(doc.Rod.Placement)
    FreeCADGui.runCommand("Bksim_Play")
    wait(1.0)
    FreeCADGui.runCommand("Bksim_Play")
    assert (doc.Rod.Placement.Base - before.Base).Length > 1 and panel.slider.value() > 180
    panel.slider.setValue(500)
    slider_crank.judge_end(doc, ROOT)
    FreeCADGui.runCommand("Bksim_Home")
    assert abs(doc.Crank.Placement.Rotation.Angle - 0.959931) < 1e-6
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(doc.Crank, "Edge5")
    FreeCADGui.runCommand("Bksim_Bodies")
    assert dialog.current.rows["name"].text == "Crank" and dialog.current.links["parts"].value == [doc.Crank]
    dialog.current.reject()
    FreeCADGui.runCommand("Bksim_Loads")
    dialog.current.type.setCurrentText("spring")
    assert dialog.current.rows["name"].text == "spring" and "key stiffness" in dialog.current.rows
    dialog.current.rows["name"].text = "return"
    dialog.current.type.setCurrentText("damper")
    assert dialog.current.rows["name"].text == "return"
    dialog.current.reject()
    FreeCADGui.runCommand("Bksim_Starts")
    assert dialog.current.rows["A"].text == "{ angle = 0, rate = 0 }"
    dialog.current.rows["A"].text = "{ angle = 10 deg, rate = 0 }"
    dialog.current.accept()
    assert elements.find(doc, "joints", "A").Initial == "{ angle = 10 deg, rate = 0 }"
    select(doc, [[elements.find(doc, "loads", "motor")]])
    FreeCADGui.runCommand("Bksim_Delete")
    assert elements.find(doc, "loads", "motor") is None
    operations.export(doc, os.path.join(PICTURES, "model.toml"))


try:
    main()
    print("window: passed", flush=True)
    status = 0
except Exception:
    traceback.print_exc()
    status = 1
os._exit(status)
