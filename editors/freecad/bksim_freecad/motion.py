"""Runs of a mechanism, and the parts of its bodies where they are at an instant of one."""

import bisect
import csv
import os

import FreeCAD

from . import elements, frames, geometry, marks, model, program
from .values import with_unit

POSE = ("x", "y", "z")
TURN = ("e0", "e1", "e2", "e3")
runs = {}  # the motion of each document that has been solved, by its identifier


class Motion:
    """Poses of bodies and places of named points over time: metres and unit quaternions, as they were logged."""

    def __init__(self, bodies, points, columns):
        self.times = columns["t"]
        self.points = {
            name: list(zip(*(columns[f"{channel}.{axis}"] for axis in POSE))) for name, channel in points.items()
        }
        self.poses = {}
        for body in bodies:
            places = [columns[f"{body}.{model.ORIGIN}.{axis}"] for axis in POSE]
            turns = [columns[f"{body}.{part}"] for part in TURN]
            self.poses[body] = list(zip(*places, *turns))

    def pose(self, body, idx):
        """The pose of a body at a sample, seen from the ground, mm."""
        x, y, z, e0, e1, e2, e3 = self.poses[body][idx]
        # FreeCAD has the scalar part of a quaternion last.
        return FreeCAD.Placement(FreeCAD.Vector(x, y, z) * 1000, FreeCAD.Rotation(e1, e2, e3, e0))

    def point(self, name, idx):
        """Where a named point is at a sample, seen from the ground, mm; `None` of one that is not known."""
        if name == "ground":
            return FreeCAD.Vector()
        return FreeCAD.Vector(*self.points[name][idx]) * 1000 if name in self.points else None

    def sample(self, t):
        """The sample at or before a time."""
        return max(bisect.bisect_right(self.times, t + 1e-12) - 1, 0)


def probes(doc):
    """The points by which a run says where the frames of bodies are."""
    return {
        body.ElementName: {model.ORIGIN: "[0, 0]" if frames.is_planar(doc) else "[0, 0, 0]"}
        for body in elements.all_of(doc, "bodies")
    }


def table(log, channels):
    """Columns of numbers of a log, by their names, the time first."""
    rows = csv.reader(program.text_of(["export", log, *channels]).splitlines())
    names = next(rows)
    columns = zip(*([float(value or "nan") for value in row] for row in rows))
    return dict(zip(names, map(list, columns)))


def log_of(doc, name="run"):
    """Where a document's log is written: in its folder, under its name."""
    return os.path.join(program.folder(doc), f"{doc.Name}-{name}.mcap")


def read(doc, log):
    """The motion in a log of a document's model."""
    bodies = [body.ElementName for body in elements.all_of(doc, "bodies")]
    channels = [f"{body}.{model.ORIGIN}.{axis}" for body in bodies for axis in POSE]
    channels += [f"{body}.{part}" for body in bodies for part in TURN]
    named = {name for obj in elements.all_of(doc) for name in elements.typed_places(obj)} - {"ground"}
    points = {name: name if "." in name else f"{name}.{model.ORIGIN}" for name in sorted(named)}
    channels += [f"{channel}.{axis}" for channel in points.values() for axis in POSE]
    return Motion(bodies, points, table(log, channels))


def run_of(doc):
    """The motion of a document: of the run that has been made, or whose log is still there; or `None`.

    A log that lacks a body of today is of another mechanism.
    """
    group = elements.mechanism(doc)
    if doc.Uid not in runs and group and os.path.exists(group.Log):
        try:
            runs[doc.Uid] = read(doc, group.Log)
        except program.Failed:
            runs[doc.Uid] = None
    return runs.get(doc.Uid)


def go_home(doc):
    """Puts every part where it is drawn."""
    if not any(body.Home for body in elements.all_of(doc, "bodies")):
        return
    for body in elements.all_of(doc, "bodies"):
        for part, placement in zip(body.Parts, body.Home):
            set_global(part, placement)
        body.Home = []
    run = run_of(doc)
    for obj in elements.all_of(doc):
        marks.redraw(obj, spot=lambda name: run.point(name, 0) if run else None)


def set_global(part, placement):
    """Puts an object where it is to be in the world, whatever it is contained in."""
    part.Placement = geometry.holder(part).inverse() * placement


def show(doc, motion, idx):
    """Puts every part where a motion has it at a sample; the drawn pose is kept."""
    plane, poses = elements.mechanism(doc).Plane, {}
    for body in elements.all_of(doc, "bodies"):
        if body.Parts and not body.Home:
            body.Home = [geometry.pose(part) for part in body.Parts]
        if body.ElementName in motion.poses:
            poses[body.Name] = motion.pose(body.ElementName, idx)
            for part in body.Parts:
                set_global(part, plane * poses[body.Name] * frames.x_body_from_part(body, part))
    for obj in elements.all_of(doc):
        marks.redraw(
            obj,
            lambda body: poses.get(body.Name) if body else FreeCAD.Placement(),
            lambda name: motion.point(name, idx),
        )


def short_run(doc, corners=None):
    """The log of a run that ends at once, for the poses at the start; with more points of bodies by their names."""
    added = {body: names | (corners or {}).get(body, {}) for body, names in probes(doc).items()}
    solve = elements.find(doc, "solve")
    begin = with_unit((elements.text(solve, "t_start") if solve else "") or "0", model.unit(doc, "time"))
    brief = {"t_end": f'"{begin} + 1e-6 s"', "every": '"1e-6 s"', "times": "", "step": ""}
    text = model.generate(doc, added, brief)
    log = log_of(doc, "start")
    program.answer(["solve", "-", "-o", log, "--force"], text.text, program.folder(doc))
    return log
