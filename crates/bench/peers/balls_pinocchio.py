"""A chain of rods on spherical joints in Pinocchio: articulated bodies, integrated by SciPy's DOP853."""

import time

import numpy
from common import package, read, write

pin = package("pinocchio")
package("scipy")
from scipy.integrate import solve_ivp  # noqa: E402


def build(request):
    """The chain, with the place of its free end in the last joint's frame."""
    n = request["n"]
    length = 1 / n
    model = pin.Model()
    model.gravity.linear = numpy.array([0, 0, -9.81])
    moments = numpy.diag([request["along"], request["across"], request["across"]])
    inertia = pin.Inertia(1 / n, numpy.array([length / 2, 0, 0]), moments)
    parent = 0
    for k in range(n):
        place = pin.SE3(numpy.eye(3), numpy.array([length if k else 0.0, 0, 0]))
        parent = model.addJoint(parent, pin.JointModelSpherical(), place, f"j{k}")
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    return model, parent, numpy.array([length, 0, 0])


def rates(q, v):
    """The rates of quaternions x, y, z, w that turn by v in their own frames."""
    x, y, z, w = q.reshape(-1, 4).T
    p, r, s = v.reshape(-1, 3).T
    parts = [w * p + y * s - z * r, w * r + z * p - x * s, w * s + x * r - y * p, -x * p - y * r - z * s]
    return 0.5 * numpy.array(parts).T.ravel()


def main():
    request = read()
    began = time.process_time()
    model, last, end = build(request)
    data = model.createData()
    ready = time.process_time() - began
    torque = numpy.zeros(model.nv)
    start = numpy.concatenate((pin.neutral(model), torque))
    start[model.nq + 2] = 1.0

    def slope(_, y):
        q, v = y[: model.nq].copy(), y[model.nq :]
        acceleration = pin.aba(model, data, pin.normalize(model, q), v, torque)
        return numpy.concatenate((rates(q, v), acceleration))

    runs = []
    for tolerance in request["sizes"]:
        began = time.process_time()
        found = solve_ivp(slope, (0, request["t_end"]), start, "DOP853", rtol=tolerance, atol=tolerance)
        seconds = time.process_time() - began
        q = pin.normalize(model, found.y[: model.nq, -1].copy())
        pin.forwardKinematics(model, data, q)
        tip = data.oMi[last].act(end)
        runs.append({"size": tolerance, "seconds": seconds, "measured": tip.tolist()})
    n_calls = max(20, 20000 // request["n"])
    q, v = pin.randomConfiguration(model), numpy.linspace(-1, 1, model.nv)
    began = time.process_time()
    for _ in range(n_calls):
        pin.aba(model, data, q, v, torque)
    evaluation = (time.process_time() - began) / n_calls
    write({"runs": runs, "ready_s": ready, "evaluation_s": evaluation})


main()
