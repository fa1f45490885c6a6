"""Five links in Exudyn: planar rigid bodies with revolute joints, generalised alpha."""

import math
import time

import five_link as m
from common import package, read, write

exudyn = package("exudyn")


def build(angles):
    """The mechanism at rest, and the nodes of the links in the order 1, 2, 4, 5."""
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject({"objectType": "Ground", "referencePosition": [0, 0, 0]})

    def link(mass, moment, x, y, angle):
        node = system.AddNode({
            "nodeType": "RigidBody2D", "referenceCoordinates": [x, y, angle],
            "initialCoordinates": [0, 0, 0], "initialVelocities": [0, 0, 0],
        })
        body = system.AddObject({
            "objectType": "RigidBody2D", "mass": mass,
            "inertia": moment, "nodeNumber": node,
        })
        centre = marker(body, 0)
        system.AddLoad({
            "loadType": "ForceVector", "markerNumber": centre,
            "loadVector": [0, -m.GRAVITY * mass, 0],
        })
        return node, body

    def marker(body, x, y=0.0):
        return system.AddMarker({
            "markerType": "BodyRigid", "bodyNumber": body, "localPosition": [x, y, 0],
        })

    def pin(first, second):
        system.AddObject({
            "objectType": "JointRevolute2D", "markerNumbers": [first, second],
        })

    t1, t2, t4, t5 = angles
    (m1, s1, i1), (m5, s5, i5) = m.LINK1, m.LINK5
    x1, y1 = m.L1 * math.cos(t1), m.L1 * math.sin(t1)
    x5, y5 = m.H[0] + m.L5 * math.cos(t5), m.H[1] + m.L5 * math.sin(t5)
    nodes, bodies = zip(
        link(m1, i1, s1 * math.cos(t1), s1 * math.sin(t1), t1),
        link(1, 1, x1 + m.S2 * math.cos(t2), y1 + m.S2 * math.sin(t2), t2),
        link(1, 1, x5 + m.S4 * math.cos(t4), y5 + m.S4 * math.sin(t4), t4),
        link(m5, i5, m.H[0] + s5 * math.cos(t5), m.H[1] + s5 * math.sin(t5), t5),
    )
    link1, link2, link4, link5 = bodies
    # The slider is a point that stays at its first height, zero but for rounding.
    slider = system.AddNode({
        "nodeType": "Point2D", "referenceCoordinates":
            [x1 + 2 * m.S2 * math.cos(t2), y1 + 2 * m.S2 * math.sin(t2)],
        "initialCoordinates": [0, 0], "initialVelocities": [0, 0],
    })
    mass = system.AddObject({
        "objectType": "MassPoint2D", "mass": 1, "nodeNumber": slider,
    })
    place = system.AddMarker({
        "markerType": "BodyPosition", "bodyNumber": mass, "localPosition": [0, 0, 0],
    })
    system.AddLoad({
        "loadType": "ForceVector", "markerNumber": place,
        "loadVector": [0, -m.GRAVITY, 0],
    })
    fixed = system.AddNode({
        "nodeType": "PointGround", "referenceCoordinates": [0, 0, 0],
    })
    height = system.AddMarker({
        "markerType": "NodeCoordinate", "nodeNumber": slider, "coordinate": 1,
    })
    zero = system.AddMarker({
        "markerType": "NodeCoordinate", "nodeNumber": fixed, "coordinate": 1,
    })
    system.AddObject({
        "objectType": "ConnectorCoordinate", "markerNumbers": [zero, height],
    })
    pin(marker(ground, 0), marker(link1, -s1))
    pin(marker(link1, m.L1 - s1), marker(link2, -m.S2))
    pin(marker(link2, m.S2), place)
    pin(marker(link2, 0), marker(link4, m.S4))
    pin(marker(link4, -m.S4), marker(link5, m.L5 - s5))
    pin(marker(ground, m.H[0], m.H[1]), marker(link5, -s5))
    system.AddLoad({
        "loadType": "TorqueVector", "markerNumber": marker(link1, 0),
        "loadVector": [0, 0, m.TORQUE],
    })
    system.Assemble()
    return container, system, nodes


def run(h, request):
    """One run of step size h: CPU seconds and error."""
    rows = request["rows"]
    container, system, nodes = build(m.start(rows))
    sensors = [
        system.AddSensor({
            "sensorType": "Node", "name": f"s{node}", "nodeNumber": node,
            "outputVariableType": exudyn.OutputVariableType.Rotation, "storeInternal": True,
            "writeToFile": False,
        })
        for node in nodes
    ]
    system.Assemble()
    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime = rows[-1]["t"]
    integration.numberOfSteps = round(rows[-1]["t"] / h)
    integration.verboseMode = 0
    # a third of the time of the default here
    integration.newton.useModifiedNewton = False
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = rows[1]["t"]
    began = time.process_time()
    system.SolveDynamic(settings)
    seconds = time.process_time() - began
    angles = [system.GetSensorStoredData(sensor)[:, -1] for sensor in sensors]
    found = [list(values) for values in zip(*angles)]
    return {"h": h, "seconds": seconds, "error": m.error(found, rows)}


request = read()
runs = [run(h, request) for h in request["sizes"]]
write({"version": exudyn.__version__, "runs": runs})
