"""Runs units with FMPy; prints a line for each that passes."""
import csv
import math
import os
import sys

import numpy as np
from fmpy import extract, fmi2, fmi3, read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

HERE = os.path.dirname(os.path.abspath(__file__))
G = 9.81


def near(got, want, allowed, what):
    scale = max(1.0, max(abs(w) for w in np.atleast_1d(want)))
    worst = float(np.max(np.abs(np.asarray(got) - np.asarray(want)))) / scale
    assert worst <= allowed, f"{what}: {worst:.2e}, allowed {allowed:g}"


class Slave:
    """Co-simulation of either version."""

    def __init__(self, path):
        self.md = read_model_description(path)
        self.three = self.md.fmiVersion.startswith("3")
        kind = fmi3.FMU3Slave if self.three else fmi2.FMU2Slave
        self.unit = kind(guid=self.md.guid, unzipDirectory=extract(path), instanceName="one",
                         modelIdentifier=self.md.coSimulation.modelIdentifier)
        self.unit.instantiate()
        if not self.three:
            self.unit.setupExperiment(tolerance=1e-10, startTime=0.0)
            self.unit.enterInitializationMode()
        else:
            self.unit.enterInitializationMode(tolerance=1e-10, startTime=0.0)
        self.unit.exitInitializationMode()
        self.vr = {v.name: v.valueReference for v in self.md.modelVariables}
        self.t = 0.0

    def get(self, *names):
        get = self.unit.getFloat64 if self.three else self.unit.getReal
        return list(get([self.vr[n] for n in names]))

    def steps(self, n, h):
        for k in range(n):
            self.unit.doStep(self.t + k * h, h)
        self.t += n * h

    def saved(self):
        if self.three:
            return bytes(bytearray(self.unit.serializeFMUState(self.unit.getFMUState())))
        return bytes(bytearray(self.unit.serializeFMUstate(self.unit.getFMUstate())))

    def restore(self, saved, t):
        if self.three:
            self.unit.setFMUState(self.unit.deserializeFMUState(saved))
        else:
            self.unit.setFMUstate(self.unit.deSerializeFMUstate(saved))
        self.t = t


def slider_crank(path):
    """Against values of 18 digits: theta1 and its loop, 5 s."""
    with open(os.path.join(HERE, "slider_crank.csv")) as file:
        rows = list(csv.reader(file))
    names, ref = rows[0][1:], np.array(rows[1:], float)
    r = simulate_fmu(path, start_time=0, stop_time=5, relative_tolerance=1e-10, output_interval=0.1, output=names,
                     fmi_type="ModelExchange", record_events=False)[::5]
    near(r["theta1"], ref[:, 1], 1e-7, "theta1 by CVODE")
    near(r["x3"], ref[:, 3], 1e-6, "x3 by CVODE")
    # The rod keeps its length: the dependent coordinates follow.
    near(3 * np.sin(r["theta2"]), -np.sin(r["theta1"]), 1e-9, "loop")
    s = Slave(path)
    for row in ref[1:]:
        s.steps(500, 0.001)
        near(s.get(*names), row[1:], 1e-6, f"co-simulation at {row[0]}")


def ball(path):
    """Bounces of closed form, found by both kinds."""
    md = read_model_description(path)
    starts = {v.name: float(v.start) for v in md.modelVariables if v.start is not None}
    position = next(v.name for v in md.modelVariables if v.causality == "output" and v.unit == "m")
    r = simulate_fmu(path, stop_time=1.0, relative_tolerance=1e-10, output=[position], fmi_type="ModelExchange",
                     record_events=False, output_interval=0.01)
    s = Slave(path)
    low = min(r[position])
    assert md.numberOfEventIndicators > 0 and starts
    for k, y in enumerate(r[position]):
        if k:
            s.steps(1, 0.01)
        near(s.get(position), [y], 1e-6, f"kinds at {k}")
    assert low > -1e-6, f"falls to {low}"


def pendulum(path):
    """An input, a start value, states saved, a derivative against differences."""
    names = ["pin.angle", "pin.rate"]
    push = np.array([(0.0, 0.0), (0.5, 0.0), (0.5, 3.0), (1.0, 3.0)], dtype=[("time", float), ("u", float)])
    r = simulate_fmu(path, stop_time=1, relative_tolerance=1e-10, input=push, output=names, fmi_type="ModelExchange",
                     start_values={"start.pin.angle": 0.2, "l": 0.8}, output_interval=0.1, record_events=False)
    # Energy: T + V rises by the work of the torque alone.
    energy = [0.5 * 2 * 0.64 * w * w - 2 * G * 0.8 * math.cos(a) for a, w in zip(r["pin.angle"], r["pin.rate"])]
    first = list(r["time"]).index(0.5) if 0.5 in list(r["time"]) else 5
    near(energy[:first], [energy[0]] * first, 1e-7, "energy")
    near(energy[-1] - energy[first], 3 * (r["pin.angle"][-1] - r["pin.angle"][first]), 1e-7, "work")
    near(r["pin.angle"][0], 0.2, 1e-12, "start value")
    s = Slave(path)
    s.steps(30, 0.01)
    saved = s.saved()
    s.steps(30, 0.01)
    there = s.get(*names)
    s.restore(saved, 0.3)
    s.steps(30, 0.01)
    assert s.get(*names) == there, "a restored state moves otherwise"
    md = read_model_description(path)
    rate = next(v for v in md.modelVariables if v.name == "der(state[2])")
    kind = fmi3.FMU3Model if s.three else fmi2.FMU2Model
    u = kind(guid=md.guid, unzipDirectory=extract(path), instanceName="two", modelIdentifier=md.modelExchange.modelIdentifier)
    u.instantiate()
    if not s.three:
        u.setupExperiment()
    u.enterInitializationMode()
    u.exitInitializationMode()
    state = next(v for v in md.modelVariables if v.name == "state[1]")
    got = u.getDirectionalDerivative([rate.valueReference], [state.valueReference], [1.0])
    near(list(got), [-G * math.cos(math.radians(30))], 1e-12, "derivative")
    by_input = u.getDirectionalDerivative([rate.valueReference], [s.vr["u"]], [1.0])
    near(list(by_input), [0.5], 1e-12, "derivative by the input")


def rattle(path):
    """Flanks that part slowly and meet again: a few events each time, and both kinds agree."""
    names = ["A.angle", "B.angle"]
    r = simulate_fmu(path, stop_time=0.05, relative_tolerance=1e-9, output=names, fmi_type="ModelExchange", output_interval=0.001)
    assert len(r) < 300, f"{len(r)} rows: events without end"
    s = Slave(path)
    s.steps(50, 0.001)
    near([r[name][-1] for name in names], s.get(*names), 1e-6, "both kinds")


TESTS = {"slider_crank": slider_crank, "ball": ball, "pendulum": pendulum, "rattle": rattle}

for path in sys.argv[1:]:
    problems = validate_fmu(path)
    assert not problems, f"{path}: {problems}"
    name = os.path.basename(path)[:-5]
    TESTS[name](path)
    print(name, "passed")
