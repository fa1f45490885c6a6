"""The panel at the side: what was found, equations, curves, and the slider of the motion."""

import os
import tempfile
import time

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from . import elements, motion, operations, program

INTERVAL_MS = 40
SPEEDS = {"1/10": 0.1, "1/4": 0.25, "1": 1.0, "4": 4.0}
panel = None  # the one panel, once it is needed


def mono():
    """A field for text in columns."""
    field = QtGui.QPlainTextEdit()
    field.setReadOnly(True)
    field.setLineWrapMode(QtGui.QPlainTextEdit.NoWrap)
    field.setFont(QtGui.QFont("Monospace", 9))
    return field


def column(*widgets):
    """Widgets one above the other."""
    holder = QtGui.QWidget()
    layout = QtGui.QVBoxLayout(holder)
    layout.setContentsMargins(2, 2, 2, 2)
    for widget in widgets:
        layout.addWidget(widget)
    return holder


def row(*widgets):
    """Widgets side by side."""
    holder = QtGui.QWidget()
    layout = QtGui.QHBoxLayout(holder)
    layout.setContentsMargins(0, 0, 0, 0)
    for widget in widgets:
        layout.addWidget(widget)
    return holder


def button(title, action):
    """A button that does something."""
    made = QtGui.QPushButton(title)
    made.clicked.connect(lambda *_: action())
    return made


def canvas(columns, units):
    """Curves over time, drawn by Matplotlib; raises `ImportError` where it is not installed."""
    from matplotlib.backends.backend_qtagg import FigureCanvasQTAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 3.2), layout="constrained")
    names = [name for name in columns if name != "t"]
    by_unit = {}
    for name in names:
        by_unit.setdefault(units.get(name, ""), []).append(name)
    axes = figure.subplots(max(len(by_unit), 1), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (unit, group) in zip(axes, by_unit.items()):
        for name in group:
            axis.plot(columns["t"], columns[name], label=name)
        axis.set_ylabel(unit or "1")
        axis.legend(fontsize="small")
        axis.grid(alpha=0.3)
    axes[-1].set_xlabel("t, s")
    drawn = FigureCanvasQTAgg(figure)
    drawn.cursors = [axis.axvline(columns["t"][0], color="black", linewidth=0.8) for axis in axes]
    return drawn


def picture(log, names):
    """The same as the picture of `bksim plot`."""
    try:
        from PySide.QtSvgWidgets import QSvgWidget
    except ImportError:
        from PySide.QtSvg import QSvgWidget

    path = os.path.join(tempfile.mkdtemp(), "curves.svg")
    program.text_of(["plot", log, *names, "-o", path])
    return QSvgWidget(path)


class Panel(QtGui.QDockWidget):
    """The dock with its tabs and the slider below them."""

    def __init__(self):
        super().__init__("bksim", FreeCADGui.getMainWindow())
        self.setObjectName("bksim")
        self.summary, self.faults = mono(), QtGui.QListWidget()
        self.faults.setWordWrap(True)
        self.faults.itemClicked.connect(self.select)
        self.text = mono()
        buttons = row(button("Copy as LaTeX", self.copy_latex), button("Open as page", self.open_page))
        self.channels, self.plot = QtGui.QListWidget(), QtGui.QStackedWidget()
        self.channels.setSelectionMode(QtGui.QAbstractItemView.ExtendedSelection)
        self.channels.setMaximumHeight(140)
        self.tabs = QtGui.QTabWidget()
        self.tabs.addTab(column(self.summary, self.faults), "Report")
        self.tabs.addTab(column(self.text, buttons), "Equations")
        self.tabs.addTab(column(self.channels, button("Draw", self.draw), self.plot), "Curves")
        self.slider = QtGui.QSlider(QtCore.Qt.Horizontal)
        self.slider.valueChanged.connect(self.move_to)
        self.clock, self.speed = QtGui.QLabel("t = 0 s"), QtGui.QComboBox()
        self.speed.addItems(list(SPEEDS))
        self.speed.setCurrentText("1")
        self.play_button = button("Play", self.play)
        self.setWidget(
            column(
                self.tabs, self.slider, row(self.play_button, self.speed, self.clock, button("Drawn pose", self.home))
            )
        )
        self.timer = QtCore.QTimer(self)
        self.timer.setInterval(INTERVAL_MS)
        self.timer.timeout.connect(self.advance)
        self.abouts, self.began = [], (0.0, 0.0)
        FreeCADGui.getMainWindow().addDockWidget(QtCore.Qt.RightDockWidgetArea, self)

    @property
    def doc(self):
        return FreeCAD.ActiveDocument

    @property
    def run(self):
        return motion.run_of(self.doc) if self.doc else None

    def report(self, text, faults=()):
        """Shows what a command answers, and faults with the elements that they are about."""
        self.summary.setPlainText(text)
        self.faults.clear()
        self.abouts = []
        for fault, obj, key in faults:
            place = f" — {obj.Label}{', ' + key if key else ''}" if obj else ""
            help_line = f"\n{fault['help']}" if fault.get("help") else ""
            self.faults.addItem(f"{fault['code']} {fault['severity']}{place}\n{fault['message']}{help_line}")
            self.abouts.append(obj.Name if obj else None)
        self.tabs.setCurrentIndex(0)
        self.show()

    def select(self, item):
        """Selects the element that a fault is about, and what it refers to in the drawing."""
        name = self.abouts[self.faults.row(item)]
        obj = self.doc.getObject(name) if name else None
        FreeCADGui.Selection.clearSelection()
        if obj is None:
            return
        FreeCADGui.Selection.addSelection(obj)
        for part in getattr(obj, "Parts", []):
            FreeCADGui.Selection.addSelection(part)

    def equations(self, text):
        self.text.setPlainText(text)
        self.tabs.setCurrentIndex(1)
        self.show()

    def copy_latex(self):
        QtGui.QApplication.clipboard().setText(operations.equations(self.doc, "latex"))

    def open_page(self):
        path = os.path.join(program.folder(self.doc), f"{self.doc.Name}-equations.html")
        with open(path, "w", encoding="utf-8") as file:
            file.write(operations.equations(self.doc, "html"))
        QtGui.QDesktopServices.openUrl(QtCore.QUrl.fromLocalFile(path))

    def solved(self):
        """Takes the run that has been made: its samples on the slider, its channels in the list."""
        self.units = operations.channels(self.doc)
        self.channels.clear()
        self.channels.addItems(list(self.units))
        self.slider.setRange(0, len(self.run.times) - 1)
        self.slider.setValue(0)
        self.move_to(0)

    def draw(self, names=None):
        """Draws the chosen channels; the coordinates, where none is."""
        if self.run is None:
            return
        if self.channels.count() == 0:
            self.solved()
        names = names or [item.text() for item in self.channels.selectedItems()]
        names = names or [name for name in self.units if name.startswith("state.") and not name.endswith("_dot")]
        log = elements.mechanism(self.doc).Log
        try:
            drawn = canvas(operations.curves(self.doc, names), self.units)
        except ImportError:
            drawn = picture(log, names)
        while self.plot.count():
            self.plot.removeWidget(self.plot.widget(0))
        self.plot.addWidget(drawn)
        self.tabs.setCurrentIndex(2)
        self.show()

    def move_to(self, idx):
        """Puts the parts, the clock and the cursor of the curves at a sample."""
        if self.run is None or not self.run.times:
            return
        t = self.run.times[idx]
        motion.show(self.doc, self.run, idx)
        self.clock.setText(f"t = {t:.4g} s")
        for cursor in getattr(self.plot.currentWidget(), "cursors", []):
            cursor.set_xdata([t, t])
            self.plot.currentWidget().draw_idle()

    def play(self):
        """Starts the motion where the slider is, from the start at its end, or stops it."""
        if self.run is None or self.timer.isActive():
            self.stop()
            return
        if self.slider.value() == self.slider.maximum():
            self.slider.setValue(0)
        self.began = (time.monotonic(), self.run.times[self.slider.value()])
        self.play_button.setText("Stop")
        self.timer.start()

    def stop(self):
        self.timer.stop()
        self.play_button.setText("Play")

    def advance(self):
        """Moves on to the sample of this instant."""
        if self.run is None:
            self.stop()
            return
        since, t = self.began
        idx = self.run.sample(t + (time.monotonic() - since) * SPEEDS[self.speed.currentText()])
        self.slider.setValue(idx)
        if idx == self.slider.maximum():
            self.stop()

    def home(self):
        self.stop()
        if self.doc:
            operations.home(self.doc)


def get():
    """The panel, made when it is first needed."""
    global panel
    panel = panel or Panel()
    return panel
