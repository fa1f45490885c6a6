"""An arm of revolutes in Pinocchio: articulated bodies, integrated by SciPy's DOP853."""

import numpy
from common import package, race, read

pin = package("pinocchio")
package("scipy")
from scipy.integrate import solve_ivp  # noqa: E402
from spatial_pinocchio import build as tree  # noqa: E402


class Arm:
    """The arm and its state."""

    def __init__(self, request, _):
        self.model = tree(request["bodies"], request["gravity"])
        self.data = self.model.createData()
        self.torque = numpy.zeros(self.model.nv)
        self.y = numpy.concatenate((request["q"], self.torque))

    def slope(self, _, y):
        n = self.model.nq
        return numpy.concatenate((y[n:], pin.aba(self.model, self.data, y[:n], y[n:], self.torque)))

    def run(self, request, tolerance):
        span = (0, request["t_end"])
        self.y = solve_ivp(self.slope, span, self.y, "DOP853", rtol=tolerance, atol=tolerance).y[:, -1]

    def measured(self):
        return self.y[: self.model.nq]

    def evaluate(self):
        n = self.model.nq
        pin.aba(self.model, self.data, self.y[:n], self.y[n:], self.torque)


race(read(), Arm, Arm.run, Arm.measured, Arm.evaluate, 5000)
