"""An arm of revolutes in Exudyn: a kinematic tree in minimal coordinates, by its Runge–Kutta method of order seven."""

import numpy
from common import package, race, read

exudyn = package("exudyn")
from exudyn.itemInterface import (  # noqa: E402
    NodeGenericODE2,
    ObjectKinematicTree,
)


def build(request, _):
    """The arm; its axes are those of the frames."""
    bodies = request["bodies"]
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    kinds = [exudyn.JointType.RevoluteX, exudyn.JointType.RevoluteY, exudyn.JointType.RevoluteZ]
    moments = [[[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]] for xx, yy, zz, xy, yz, zx in
               (body["inertia"] for body in bodies)]
    n = len(bodies)
    node = system.AddNode(NodeGenericODE2(
        referenceCoordinates=[0.0] * n, initialCoordinates=request["q"], initialCoordinates_t=[0.0] * n,
        numberOfODE2Coordinates=n,
    ))
    system.AddObject(ObjectKinematicTree(
        nodeNumber=node,
        jointTypes=[kinds[body["axis"].index(1)] for body in bodies],
        linkParents=[body["parent"] - 1 for body in bodies],
        jointTransformations=exudyn.Matrix3DList([numpy.eye(3)] * n),
        jointOffsets=exudyn.Vector3DList([body["place"] for body in bodies]),
        linkInertiasCOM=exudyn.Matrix3DList([numpy.array(m) for m in moments]),
        linkCOMs=exudyn.Vector3DList([body["com"] for body in bodies]),
        linkMasses=[body["mass"] for body in bodies],
        gravity=request["gravity"],
    ))
    system.Assemble()
    return container, system


def run(machine, request, h):
    steps = round(request["t_end"] / h)
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime = request["t_end"]
    integration.numberOfSteps = steps
    integration.verboseMode = 0
    integration.automaticStepSize = False
    settings.solution.file.write = False
    machine[1].SolveDynamic(settings, solverType=exudyn.DynamicSolverType.RK67)
    return steps


race(read(), build, run, lambda machine: machine[1].systemData.GetODE2Coordinates(), None, 0)
