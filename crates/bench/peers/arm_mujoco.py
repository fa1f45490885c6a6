"""An arm of revolutes in MuJoCo, by its Runge–Kutta method of order four."""

from common import package, race, read

mujoco = package("mujoco")


def text(request, h):
    """The arm: each body hangs on the one before it."""
    words = lambda numbers: " ".join(repr(x) for x in numbers)  # noqa: E731
    bodies = ""
    for body in request["bodies"]:
        # A body without mass turns about a fixed axis through its centre: any mass does, and none is refused.
        inertial = f'mass="{body["mass"] or 1.0!r}" pos="{words(body["com"])}" fullinertia="{words(body["inertia"])}"'
        bodies += f'<body pos="{words(body["place"])}"><joint axis="{words(body["axis"])}"/><inertial {inertial}/>'
    return f"""
    <mujoco>
      <compiler balanceinertia="false" boundinertia="0"/>
      <option gravity="{words(request["gravity"])}" integrator="RK4" timestep="{h!r}">
        <flag contact="disable" limit="disable" constraint="disable"/>
      </option>
      <worldbody>{bodies}{"</body>" * len(request["bodies"])}</worldbody>
    </mujoco>"""


def build(request, h):
    model = mujoco.MjModel.from_xml_string(text(request, h))
    state = mujoco.MjData(model)
    state.qpos[:] = request["q"]
    return model, state


def run(machine, request, h):
    mujoco.mj_step(*machine, round(request["t_end"] / h))


race(read(), build, run, lambda machine: machine[1].qpos, lambda machine: mujoco.mj_forward(*machine), 5000)
