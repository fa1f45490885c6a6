"""A chain of rods on spherical joints in MuJoCo, by its Runge–Kutta method of order four."""

import time

import numpy
from common import package, read, write

mujoco = package("mujoco")


def text(request, h):
    """The chain, straight along x, with a site at its free end."""
    n = request["n"]
    length = 1 / n
    body = (
        f'<inertial pos="{length / 2!r} 0 0" mass="{1 / n!r}" '
        f'diaginertia="{request["along"]!r} {request["across"]!r} {request["across"]!r}"/>'
    )
    rods = ""
    for k in range(n):
        rods += f'<body pos="{length if k else 0.0!r} 0 0"><joint type="ball"/>{body}'
    rods += f'<site name="end" pos="{length!r} 0 0"/>' + "</body>" * n
    return f"""
    <mujoco>
      <compiler balanceinertia="false" boundinertia="0"/>
      <option gravity="0 0 -9.81" integrator="RK4" timestep="{h!r}">
        <flag contact="disable" limit="disable" constraint="disable"/>
      </option>
      <worldbody>{rods}</worldbody>
    </mujoco>"""


def main():
    request = read()
    runs = []
    ready = evaluation = 0.0
    for h in request["sizes"]:
        began = time.process_time()
        model = mujoco.MjModel.from_xml_string(text(request, h))
        state = mujoco.MjData(model)
        ready = time.process_time() - began
        state.qvel[2] = 1.0
        began = time.process_time()
        mujoco.mj_step(model, state, round(request["t_end"] / h))
        seconds = time.process_time() - began
        mujoco.mj_forward(model, state)
        tip = numpy.array(state.site("end").xpos)
        runs.append({"size": h, "seconds": seconds, "measured": tip.tolist()})
        n_calls = max(20, 20000 // request["n"])
        began = time.process_time()
        for _ in range(n_calls):
            mujoco.mj_forward(model, state)
        evaluation = (time.process_time() - began) / n_calls
    write({"runs": runs, "ready_s": ready, "evaluation_s": evaluation})


main()
