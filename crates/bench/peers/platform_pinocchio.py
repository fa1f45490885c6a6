"""A six-legged platform in Pinocchio: legs and platform as trees, the balls as point constraints of
`constraintDynamics`, at the level of accelerations and without stabilisation, integrated by SciPy's DOP853."""

import numpy
from common import package, race, read
from legs import legs

pin = package("pinocchio")
package("scipy")
from scipy.integrate import solve_ivp  # noqa: E402


def inertia(body):
    """Of a body with its centre on z."""
    return pin.Inertia(body["mass"], numpy.array([0, 0, body["com"]]), numpy.diag(body["inertia"]))


class Platform:
    """The platform, its constraints and its state."""

    def __init__(self, request, _):
        model = self.model = pin.Model()
        model.gravity.linear = numpy.array(request["gravity"])
        still = pin.SE3.Identity()
        ends, q, v = [], [], 0
        self.slides, self.springs = [], []
        for foot, ball, angles, length, stiffness in legs(request):
            cross = model.addJoint(0, pin.JointModelRX(), pin.SE3(numpy.eye(3), numpy.array(foot)), f"x{v}")
            tube = model.addJoint(cross, pin.JointModelRY(), still, f"y{v}")
            model.appendBodyToJoint(tube, inertia(request["tube"]), still)
            piston = model.addJoint(tube, pin.JointModelPZ(), still, f"z{v}")
            model.appendBodyToJoint(piston, inertia(request["piston"]), still)
            ends.append((piston, numpy.array(ball)))
            q += [*angles, length]
            self.slides.append(v + 2)
            self.springs.append(stiffness)
            v += 3
        self.platform = model.addJoint(0, pin.JointModelFreeFlyer(), still, "platform")
        model.appendBodyToJoint(self.platform, inertia(request["platform"]), still)
        self.place = [pin.SE3(numpy.eye(3), ball) for _, ball in ends]
        self.data = model.createData()
        self.constraints = pin.StdVec_RigidConstraintModel()
        for (piston, _), place in zip(ends, self.place):
            self.constraints.append(
                pin.RigidConstraintModel(
                    pin.ContactType.CONTACT_3D, model, piston, still, self.platform, place,
                    pin.ReferenceFrame.LOCAL,
                )
            )
        self.found = pin.StdVec_RigidConstraintData()
        for constraint in self.constraints:
            self.found.append(constraint.createData())
        pin.initConstraintDynamics(model, self.data, self.constraints, self.found)
        self.settings = pin.ProximalSettings(1e-12, 0.0, 1)
        self.request = request
        self.y = numpy.concatenate((q, [0, 0, request["height"], 0, 0, 0, 1], numpy.zeros(model.nv)))

    def accelerations(self, q, v):
        torque = numpy.zeros(self.model.nv)
        slides, request = self.slides, self.request
        torque[slides] = self.springs * (request["unloaded"] - q[slides]) - request["damping"] * v[slides]
        return pin.constraintDynamics(
            self.model, self.data, q, v, torque, self.constraints, self.found, self.settings
        )

    def slope(self, _, y):
        model = self.model
        q, v = y[: model.nq].copy(), y[model.nq :]
        x, y, z, w = q[-4:] = q[-4:] / numpy.linalg.norm(q[-4:])
        turn = numpy.array([[w, -z, y], [z, w, -x], [-y, x, w], [-x, -y, -z]])
        rotation = pin.Quaternion(w, x, y, z).matrix()
        rates = (v[:-6], rotation @ v[-6:-3], 0.5 * turn @ v[-3:])
        return numpy.concatenate((*rates, self.accelerations(q, v)))

    def run(self, request, tolerance):
        span = (0, request["t_end"])
        self.y = solve_ivp(self.slope, span, self.y, "DOP853", rtol=tolerance, atol=tolerance).y[:, -1]

    def measured(self):
        q = pin.normalize(self.model, self.y[: self.model.nq].copy())
        pin.forwardKinematics(self.model, self.data, q)
        pose = self.data.oMi[self.platform]
        return numpy.concatenate([pose.act(self.place[idx].translation) for idx in (0, 2, 4)])

    def evaluate(self):
        n = self.model.nq
        self.accelerations(self.y[:n], self.y[n:])


race(read(), Platform, Platform.run, Platform.measured, Platform.evaluate, 2000)
