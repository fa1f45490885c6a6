"""A chain of rods on spherical joints in Exudyn: bodies with Euler parameters, generalised alpha."""

import time

import numpy
from common import package, read, write

exudyn = package("exudyn")
from exudyn.utilities import RigidBodyInertia  # noqa: E402


def build(request):
    """The chain, straight along x and turning about z, with a sensor at its free end."""
    n = request["n"]
    length = 1 / n
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    moments = numpy.diag([request["along"], request["across"], request["across"]])
    inertia = RigidBodyInertia(mass=1 / n, inertiaTensor=moments)
    before = system.CreateGround()
    for k in range(n):
        body = system.CreateRigidBody(
            referencePosition=[(k + 0.5) * length, 0, 0],
            initialVelocity=[0, (k + 0.5) * length, 0],
            initialAngularVelocity=[0, 0, 1],
            inertia=inertia,
            gravity=[0, 0, -9.81],
        )
        system.CreateSphericalJoint(
            itemNumbers=[before, body], position=[k * length, 0, 0], show=False
        )
        before = body
    sensor = system.AddSensor({
        "sensorType": "Body", "name": "end", "bodyNumber": before,
        "localPosition": [length / 2, 0, 0],
        "outputVariableType": exudyn.OutputVariableType.Position,
        "storeInternal": True, "writeToFile": False,
    })
    system.Assemble()
    return container, system, sensor


def main():
    request = read()
    runs = []
    ready = evaluation = 0.0
    for h in request["sizes"]:
        began = time.process_time()
        container, system, sensor = build(request)
        ready = time.process_time() - began
        settings = exudyn.SimulationSettings()
        integration = settings.timeIntegration
        integration.endTime = request["t_end"]
        integration.numberOfSteps = round(request["t_end"] / h)
        integration.verboseMode = 0
        integration.newton.useModifiedNewton = True
        if request["n"] > 10:
            settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = request["t_end"]
        began = time.process_time()
        system.SolveDynamic(settings)
        seconds = time.process_time() - began
        tip = system.GetSensorStoredData(sensor)[-1, 1:4]
        runs.append({"size": h, "seconds": seconds, "measured": tip.tolist()})
        evaluation = seconds / integration.numberOfSteps
    write({"runs": runs, "ready_s": ready, "evaluation_s": evaluation})


main()
