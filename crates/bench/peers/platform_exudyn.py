"""A six-legged platform in Exudyn: bodies with Euler parameters and joints between them, generalised alpha."""

import numpy
from common import package, race, read
from legs import legs

exudyn = package("exudyn")
from exudyn.utilities import (  # noqa: E402
    RigidBodyInertia,
    RotationMatrixX,
    RotationMatrixY,
)


def build(request, _):
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.CreateGround()

    def body(name, place, rotation):
        """A body whose frame in the model is at `place`; Exudyn's is at its centre."""
        of = request[name]
        inertia = RigidBodyInertia(mass=of["mass"], inertiaTensor=numpy.diag(of["inertia"]))
        centre = place + rotation @ [0, 0, of["com"]]
        return system.CreateRigidBody(
            referencePosition=centre, referenceRotationMatrix=rotation, inertia=inertia,
            gravity=request["gravity"], show=False,
        )

    platform = body("platform", numpy.array([0, 0, request["height"]]), numpy.eye(3))
    sensors = []
    for foot, ball, (first, second), length, stiffness in legs(request):
        rotation = RotationMatrixX(first) @ RotationMatrixY(second)
        end = numpy.array(ball) + [0, 0, request["height"]]
        tube = body("tube", numpy.array(foot), rotation)
        piston = body("piston", end, rotation)
        system.CreateGenericJoint(
            itemNumbers=[ground, tube], position=foot, rotationMatrixAxes=RotationMatrixX(first),
            constrainedAxes=[1, 1, 1, 0, 0, 1], show=False,
        )
        system.CreatePrismaticJoint(
            itemNumbers=[tube, piston], position=end, axis=rotation[:, 2], show=False
        )
        system.CreateSphericalJoint(itemNumbers=[piston, platform], position=end, show=False)
        system.CreateSpringDamper(
            itemNumbers=[tube, piston], localPosition0=[0, 0, -request["tube"]["com"]],
            localPosition1=[0, 0, -request["piston"]["com"]], referenceLength=request["unloaded"],
            stiffness=stiffness, damping=request["damping"], show=False,
        )
    for idx, ball in enumerate(request["balls"][::2]):
        sensors.append(system.AddSensor({
            "sensorType": "Body", "name": f"end {idx}", "bodyNumber": platform,
            "localPosition": numpy.array(ball) - [0, 0, request["platform"]["com"]],
            "outputVariableType": exudyn.OutputVariableType.Position,
            "storeInternal": True, "writeToFile": False,
        }))
    system.Assemble()
    return container, system, sensors


def run(machine, request, h):
    steps = round(request["t_end"] / h)
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime = request["t_end"]
    integration.numberOfSteps = steps
    integration.verboseMode = 0
    integration.newton.useModifiedNewton = True
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = request["t_end"]
    machine[1].SolveDynamic(settings)
    return steps


def measured(machine):
    _, system, sensors = machine
    return numpy.concatenate([system.GetSensorStoredData(sensor)[-1, 1:4] for sensor in sensors])


race(read(), build, run, measured, None, 0)
