"""Five links in Pinocchio: constrained dynamics of a tree with two closed loops, integrated by SciPy's
DOP853."""

import math
import time

import five_link as m
import numpy
from common import package, read, write

pin = package("pinocchio")
package("scipy")
from scipy.integrate import solve_ivp  # noqa: E402


def build():
    """The tree, its loops, and the joints in the order 1, 2, slider, 5, 4."""
    model = pin.Model()
    model.gravity.linear = numpy.array([0, -m.GRAVITY, 0])

    def at(x, y):
        return pin.SE3(numpy.eye(3), numpy.array([x, y, 0.0]))

    def body(parent, joint, place, name, mass, com, moment):
        idx = model.addJoint(parent, joint, place, name)
        inertia = pin.Inertia(mass, numpy.array([com, 0.0, 0.0]), moment * numpy.eye(3))
        model.appendBodyToJoint(idx, inertia, pin.SE3.Identity())
        return idx

    (m1, s1, i1), (m5, s5, i5) = m.LINK1, m.LINK5
    link1 = body(0, pin.JointModelRZ(), at(0, 0), "1", m1, s1, i1)
    link2 = body(link1, pin.JointModelRZ(), at(m.L1, 0), "2", 1, m.S2, 1)
    link3 = body(0, pin.JointModelPX(), at(0, 0), "3", 1, 0, 1)
    link5 = body(0, pin.JointModelRZ(), at(*m.H), "5", m5, s5, i5)
    link4 = body(link5, pin.JointModelRZ(), at(m.L5, 0), "4", 1, m.S4, 1)
    point = pin.ContactType.CONTACT_3D
    loops = [
        pin.RigidConstraintModel(point, model, link2, at(2 * m.S2, 0), link3, at(0, 0)),
        pin.RigidConstraintModel(point, model, link2, at(m.S2, 0), link4, at(2 * m.S4, 0)),
    ]
    return model, pin.StdVec_RigidConstraintModel(loops)


def run(tolerance, request):
    """One run: CPU seconds and error."""
    rows = request["rows"]
    model, loops = build()
    data = model.createData()
    contacts = pin.StdVec_RigidConstraintData([loop.createData() for loop in loops])
    pin.initConstraintDynamics(model, data, loops, contacts)
    # The plane leaves one row of each loop without effect: it is regularised.
    settings = pin.ProximalSettings(1e-12, 1e-10, 10)
    torque = numpy.array([m.TORQUE, 0, 0, 0, 0])

    def slope(_, y):
        a = pin.constraintDynamics(model, data, y[:5], y[5:], torque, loops, contacts, settings)
        return numpy.concatenate((y[5:], a))

    t1, t2, t4, t5 = m.start(rows)
    slider = m.L1 * math.cos(t1) + 2 * m.S2 * math.cos(t2)
    begin = [t1, t2 - t1, slider, t5, t4 - t5] + [0.0] * 5
    times = [row["t"] for row in rows]
    began = time.process_time()
    motion = solve_ivp(
        slope, (0.0, times[-1]), begin, "DOP853", times, rtol=tolerance, atol=tolerance
    )
    seconds = time.process_time() - began
    if motion.status != 0:
        return {"h": tolerance, "seconds": seconds, "error": None}
    q = motion.y
    found = numpy.array([q[0], q[0] + q[1], q[3] + q[4], q[3]]).T.tolist()
    return {"h": tolerance, "seconds": seconds, "error": m.error(found, rows)}


request = read()
write({"version": pin.__version__, "runs": [run(size, request) for size in request["sizes"]]})
