"""N square windows side by side in MuJoCo: uprights on hinges, beams on the uprights, and every beam
connected to the next upright."""

import time

from common import package, read, write

mujoco = package("mujoco")

request = read()
n, h = request["n"], request["h"]


def link(name, place, centre, inner=""):
    """A homogeneous link of 1 m and 1 kg on a hinge."""
    return (
        f'<body name="{name}" pos="{place}"><joint axis="0 0 1"/>'
        f'<inertial pos="{centre}" mass="1" diaginertia="{1 / 12} {1 / 12} {1 / 12}"/>{inner}</body>'
    )


def upright(i):
    """Upright i with its beam to the right, if there is one."""
    top = f'<site name="top{i}" pos="0 1 0"/>'
    beam = link(f"h{i}", "0 1 0", "0.5 0 0", f'<site name="end{i}" pos="1 0 0"/>') if i < n else ""
    return link(f"u{i}", f"{i} 0 0", "0 0.5 0", top + beam)


bodies = "".join(upright(i) for i in range(n + 1))
loops = "".join(
    f'<connect site1="end{i}" site2="top{i + 1}" solref="{2 * h!r} 1" solimp="0.9999 0.9999 1"/>'
    for i in range(n)
)
model = mujoco.MjModel.from_xml_string(
    f'<mujoco><option gravity="0 -9.81 0" integrator="RK4" timestep="{h!r}">'
    '<flag contact="disable" limit="disable"/></option>'
    f"<worldbody>{bodies}</worldbody><equality>{loops}</equality></mujoco>"
)
state = mujoco.MjData(model)
for i in range(n + 1):
    state.joint(2 * i).qvel[:] = -1
    if i < n:
        state.joint(2 * i + 1).qvel[:] = 1
began = time.process_time()
mujoco.mj_step(model, state, round(request["t_end"] / h))
seconds = time.process_time() - began
write({"version": mujoco.__version__, "seconds": seconds, "angle": -float(state.qpos[0])})
