"""Five links in MuJoCo: a tree of hinges, two loops closed by stiff equality constraints."""

import math
import time

import five_link as m
import numpy
from common import package, read, write

mujoco = package("mujoco")

MODEL = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 -{g} 0" integrator="RK4" timestep="{h!r}" tolerance="1e-14" iterations="50">
    <flag contact="disable" limit="disable"/>
  </option>
  <worldbody>
    <body name="link1"><joint axis="0 0 1"/>
      <inertial pos="{s1} 0 0" mass="{m1}" diaginertia="{i1} {i1} {i1}"/>
      <body name="link2" pos="{l1} 0 0"><joint axis="0 0 1"/>
        <inertial pos="{s2} 0 0" mass="1" diaginertia="1 1 1"/>
        <site name="M2" pos="{s2} 0 0"/><site name="B2" pos="{l2} 0 0"/></body></body>
    <body name="link3"><joint type="slide" axis="1 0 0"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><site name="B3"/></body>
    <body name="link5" pos="{hx} {hy} 0"><joint axis="0 0 1"/>
      <inertial pos="{s5} 0 0" mass="{m5}" diaginertia="{i5} {i5} {i5}"/>
      <body name="link4" pos="{l5} 0 0"><joint axis="0 0 1"/>
        <inertial pos="{s4} 0 0" mass="1" diaginertia="1 1 1"/>
        <site name="M4" pos="{l4} 0 0"/></body></body>
  </worldbody>
  <equality>
    <connect site1="B2" site2="B3" solref="{stiff!r} 1" solimp="0.9999 0.9999 1"/>
    <connect site1="M2" site2="M4" solref="{stiff!r} 1" solimp="0.9999 0.9999 1"/>
  </equality>
</mujoco>
"""


def run(h, request):
    """One run of step size h: CPU seconds and error."""
    rows = request["rows"]
    (m1, s1, i1), (m5, s5, i5) = m.LINK1, m.LINK5
    text = MODEL.format(
        g=m.GRAVITY, h=h, s1=s1, m1=m1, i1=i1, l1=m.L1, s2=m.S2, l2=2 * m.S2, hx=m.H[0],
        hy=m.H[1], s5=s5, m5=m5, i5=i5, l5=m.L5, s4=m.S4, l4=2 * m.S4, stiff=2 * h,
    )
    model = mujoco.MjModel.from_xml_string(text)
    state = mujoco.MjData(model)
    t1, t2, t4, t5 = m.start(rows)
    # joints: 1, 2 on 1, slider, 5, 4 on 5
    slider = m.L1 * math.cos(t1) + 2 * m.S2 * math.cos(t2)
    state.qpos[:] = [t1, t2 - t1, slider, t5, t4 - t5]
    state.qfrc_applied[0] = m.TORQUE
    found = [m.start(rows)]
    began = time.process_time()
    for before, row in zip(rows, rows[1:]):
        mujoco.mj_step(model, state, round((row["t"] - before["t"]) / h))
        q = state.qpos
        found.append([q[0], q[0] + q[1], q[3] + q[4], q[3]])
    seconds = time.process_time() - began
    return {"h": h, "seconds": seconds, "error": m.error(numpy.array(found).tolist(), rows)}


request = read()
write({"version": mujoco.__version__, "runs": [run(h, request) for h in request["sizes"]]})
