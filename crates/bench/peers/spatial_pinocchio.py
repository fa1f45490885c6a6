"""Trees of revolute joints in Pinocchio: M, h and g at given states, and the time of each call."""

import numpy
from common import package, read, samples, write

pin = package("pinocchio")


def build(bodies, gravity):
    """A joint for each body; a body comes after the one that carries it."""
    model = pin.Model()
    model.gravity.linear = numpy.array(gravity)
    joints = [0]
    for idx, body in enumerate(bodies):
        place = pin.SE3(numpy.eye(3), numpy.array(body["place"]))
        axis = numpy.array(body["axis"])
        joint = pin.JointModelRevoluteUnaligned(axis / numpy.linalg.norm(axis))
        joints.append(model.addJoint(joints[body["parent"]], joint, place, f"j{idx}"))
        xx, yy, zz, xy, yz, zx = body["inertia"]
        about_com = numpy.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
        inertia = pin.Inertia(body["mass"], numpy.array(body["com"]), about_com)
        model.appendBodyToJoint(joints[-1], inertia, pin.SE3.Identity())
    return model


def main():
    request = read()
    model = build(request["bodies"], request["gravity"])
    data = model.createData()
    zero = numpy.zeros(model.nv)
    states = [[numpy.array(part) for part in state] for state in request["states"]]
    found = []
    for q, v, _ in states:
        pin.crba(model, data, q)
        mass = numpy.triu(data.M) + numpy.triu(data.M, 1).T
        gradient = pin.computeGeneralizedGravity(model, data, q).copy()
        bias = pin.rnea(model, data, q, v, zero).copy() - gradient
        found.append([mass.tolist(), bias.tolist(), gradient.tolist()])

    def calls(function):
        n = request["calls"]

        def work(_):
            for k in range(n):
                function(*states[k % len(states)])

        times, _ = samples(request["runs"], lambda: None, work)
        return [t / n for t in times]

    write(
        {
            "found": found,
            "inverse_s": calls(lambda q, v, a: pin.rnea(model, data, q, v, a)),
            "mass_s": calls(lambda q, _v, _a: pin.crba(model, data, q)),
        }
    )


if __name__ == "__main__":
    main()
