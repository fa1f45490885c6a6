"""A six-legged platform in MuJoCo: legs and platform as trees, the balls as equalities, which are soft: springs that
the solver stiffens as far as the step allows."""

import numpy
from common import package, race, read
from legs import legs

mujoco = package("mujoco")


def text(request, h):
    """The platform; a soft constraint must not be faster than two steps."""
    words = lambda numbers: " ".join(repr(float(x)) for x in numbers)  # noqa: E731

    def inertial(body):
        return (f'<inertial pos="0 0 {body["com"]!r}" mass="{body["mass"]!r}" '
                f'diaginertia="{words(body["inertia"])}"/>')

    bodies = equalities = sites = ""
    for idx, (foot, ball, _, _, stiffness) in enumerate(legs(request)):
        spring = f'stiffness="{stiffness!r}" springref="{request["unloaded"]!r}" damping="{request["damping"]!r}"'
        bodies += f"""
        <body pos="{words(foot)}"><joint axis="1 0 0"/><joint axis="0 1 0"/>{inertial(request["tube"])}
          <body><joint type="slide" axis="0 0 1" {spring}/>{inertial(request["piston"])}<site name="e{idx}"/></body>
        </body>"""
        sites += f'<site name="p{idx}" pos="{words(ball)}"/>'
        equalities += f'<connect site1="e{idx}" site2="p{idx}" solref="{2 * h!r} 1" solimp="0.9999 0.9999 0.001"/>'
    return f"""
    <mujoco>
      <compiler balanceinertia="false" boundinertia="0"/>
      <option gravity="{words(request["gravity"])}" integrator="RK4" timestep="{h!r}" tolerance="1e-14">
        <flag contact="disable" limit="disable"/>
      </option>
      <worldbody>{bodies}
        <body name="platform"><freejoint/>{inertial(request["platform"])}{sites}</body>
      </worldbody>
      <equality>{equalities}</equality>
    </mujoco>"""


def build(request, h):
    model = mujoco.MjModel.from_xml_string(text(request, h))
    state = mujoco.MjData(model)
    start = [x for _, _, angles, length, _ in legs(request) for x in (*angles, length)]
    state.qpos[:] = [*start, 0, 0, request["height"], 1, 0, 0, 0]
    return model, state


def run(machine, request, h):
    mujoco.mj_step(*machine, round(request["t_end"] / h))


def measured(machine):
    mujoco.mj_forward(*machine)
    return numpy.concatenate([machine[1].site(f"p{idx}").xpos for idx in (0, 2, 4)])


race(read(), build, run, measured, lambda machine: mujoco.mj_forward(*machine), 2000)
