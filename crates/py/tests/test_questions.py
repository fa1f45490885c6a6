"""Questions besides motion in time."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bksim

PENDULUM = """
[parameters]
k = "3 N m/rad"
m = "2 kg"
[bodies.rod]
mass = "m"
inertia = 0.1
com = [0, -0.4]
[joints.A]
type = "revolute"
between = ["ground", "rod"]
[loads.g]
type = "gravity"
acceleration = [0, -9.81]
[loads.s]
type = "torsion"
joint = "A"
stiffness = "k"
damping = 0.2
"""


def pendulum() -> bksim.Model:
    return bksim.loads(PENDULUM)


def swinging() -> bksim.Model:
    return bksim.loads(PENDULUM.replace("damping = 0.2", "") + "[initial]\nA.angle = 0.5\n")


# About the pin.
INERTIA = 0.1 + 2 * 0.4**2
STIFFNESS = 3 + 2 * 9.81 * 0.4


def test_positions_over_a_range(examples: Path) -> None:
    m = bksim.load(examples / "four-bar" / "model.toml")
    a = m.kinematics({"A.angle": (0.6, 0.7, 11)}, rate="2 rad/s")
    assert np.allclose(a["A.angle"], np.linspace(0.6, 0.7, 11), atol=1e-12)
    assert np.allclose(a["A.rate"], 2, atol=1e-12)
    slope = np.gradient(a["D.angle"], a["A.angle"])
    assert np.allclose(a["D.rate"][1:-1], 2 * slope[1:-1], atol=1e-4)
    assert a.units["D.angle"] == "rad" and a.facts["table"]["rows"]
    assert not a["D.rate"].flags.writeable


def test_an_array_with_even_steps_is_a_range(examples: Path) -> None:
    m = bksim.load(examples / "four-bar" / "model.toml")
    angles = np.radians(np.linspace(30, 40, 5))
    assert np.allclose(m.kinematics({"A.angle": angles})["A.angle"], angles, atol=1e-12)
    assert len(m.inverse(times=np.linspace(0, 0.5, 6))["t"]) == 6
    omega = np.geomspace(0.1, 10, 5)
    assert np.allclose(swinging().bode("A", "A.angle", omega=omega)["omega"], omega)
    for wrong in (angles**2, angles[np.newaxis], np.array([0.1, np.nan])):
        with pytest.raises(ValueError, match="numpy.linspace"):
            m.kinematics({"A.angle": wrong})
    with pytest.raises(ValueError, match="greater than zero"):
        swinging().bode("A", "A.angle", omega=np.array([0.0, 1.0]))


def test_a_load_case_is_chosen_by_name() -> None:
    text = PENDULUM + "[cases.heavy]\nset = { m = 5 }\n"
    assert bksim.loads(text).parameters["m"] == 2
    assert bksim.loads(text, set={"case": "heavy"}).parameters["m"] == 5
    with pytest.raises(bksim.ModelError, match="M135"):
        bksim.loads(text, set={"case": "light"})


def test_limits_and_assemblies(examples: Path) -> None:
    m = bksim.load(examples / "four-bar" / "model.toml")
    assert m.limits().facts["branches"]
    found = m.assemblies()
    assert len(found.facts["assemblies"]) == 2 and found.all_proved
    # Both are beside each other in one picture, which notebooks show above the table.
    svg = found.picture().svg
    assert all(assembly["name"][:16] in svg for assembly in found.facts["assemblies"])
    assert found._repr_html_().startswith(svg) and "<table>" in found._repr_html_()


def test_equilibria_over_a_parameter_and_balanced() -> None:
    m = pendulum()
    found = m.static()
    assert len(found["stability"]) == 1 and found["stiffness"][0] == pytest.approx(STIFFNESS)
    over = m.static(over={"k": "-12:3 N m/rad:4"})
    names = {point["name"] for branch in over.facts["branches"] for point in branch["points"]}
    assert "B1" in names
    critical = over["k"][over["kind"] == 2]
    assert np.allclose(critical, -2 * 9.81 * 0.4, atol=1e-6)
    with pytest.raises(ValueError, match="one parameter"):
        m.static(over={"k": (0, 1, 2)}, solve="m")
    aside = bksim.loads(PENDULUM.replace("stiffness =", "angle = 1\nstiffness =") + "[initial]\nA = { angle = 0.3 }\n")
    assert aside.static(solve="k")["k"][0] == pytest.approx(2 * 9.81 * 0.4 * np.sin(0.3) / 0.7)


def test_a_rest_on_a_stop_has_what_the_stop_bears() -> None:
    stop = '[loads.end]\ntype = "stop"\njoint = "A"\nmin = "20 deg"\nmax = "50 deg"\n[initial]\nA = { angle = "30 deg" }\n'
    found = bksim.loads(PENDULUM + stop).static()
    bearing = [stop for one in found.facts["equilibria"] for stop in one["bearing"]]
    assert bearing and all(one["stop"] == "end" and one["effort"] > 0 for one in bearing)
    assert found.facts["left_out"] and found.facts["left_out"][0]["beyond"][0]["stop"] == "end"


def test_a_linear_system_has_the_poles_of_its_modes() -> None:
    m = pendulum()
    system = m.linearize("A", "A.angle")
    assert system.A.shape == (2, 2) and system.B.shape == (2, 1)
    assert system.C.tolist() == [[1, 0]] and system.D.tolist() == [[0]]
    expected = np.roots([INERTIA, 0.2, STIFFNESS])
    assert np.allclose(np.sort_complex(system.poles), np.sort_complex(expected), rtol=1e-10)
    assert np.allclose(m.modes().s, expected[expected.imag > 0], rtol=1e-10)


def test_a_linear_system_becomes_one_of_python_control(examples: Path) -> None:
    control = pytest.importorskip("control")
    linear = bksim.load(examples / "cart-pole/model.toml").linearize("u", "pole.angle", at="start")
    system = linear.to_control()
    np.testing.assert_array_equal(system.A, linear.A)
    assert system.output_labels == ["pole_angle"] and system.input_labels == ["u"]
    sampled = linear.to_control(dt=0.01)
    exact = control.c2d(control.ss(linear.A, linear.B, linear.C, linear.D), 0.01)
    np.testing.assert_allclose(sampled.A, exact.A)
    assert sampled.state_labels == system.state_labels and sampled.dt == 0.01


def test_a_linear_system_names_its_state_and_another_can_be_chosen() -> None:
    upright = PENDULUM.replace('k = "3 N m/rad"', 'k = "0 N m/rad"') + '[initial]\nA = { angle = "179 deg" }\n'
    m = bksim.loads(upright)
    system = m.linearize("A", "A.angle")
    state = system.facts["state"]
    assert (state["stability"], state["number"], len(state["others"])) == ("unstable", 1, 1)
    assert max(system.poles.real) > 0.0
    assert str(system).splitlines()[0].endswith("unstable; 1 other")
    for at in (2, "stable"):
        assert m.linearize("A", "A.angle", at=at).facts["state"]["stability"] == "stable"
        assert m.modes(at=at).facts["state"]["number"] == 2


def test_a_range_from_a_branch_point_follows_the_branch_that_is_named() -> None:
    flat = """
[ground]
points = { D = [0.5, 0] }
[bodies]
crank = { mass = 1, inertia = 0.01, points = { B = [0.2, 0] } }
coupler = { mass = 1, inertia = 0.01, points = { C = [0.5, 0] } }
rocker = { mass = 1, inertia = 0.01, points = { C = [0.2, 0] } }
[joints]
A = { type = "revolute", between = ["ground", "crank"] }
B = { type = "revolute", between = ["crank.B", "coupler"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker"] }
[initial]
A = { angle = 0 }
"""
    m = bksim.loads(flat)
    with pytest.raises(bksim.ModelError, match="branches cross"):
        m.kinematics({"A.angle": "0:90 deg:10"})
    found = m.kinematics({"A.angle": "0:90 deg:10"}, branch=1)
    assert np.allclose(found["D.angle"], found["A.angle"], atol=1e-9)


def test_a_response_is_that_of_the_linear_system() -> None:
    response = pendulum().bode("A", "A.angle", omega=(0.1, 100, 31))
    s = 1j * response["omega"]
    expected = 1 / (INERTIA * s**2 + 0.2 * s + STIFFNESS)
    assert np.allclose(response.transfer("A", "A.angle"), expected, rtol=1e-10)
    assert response.zeros("A", "A.angle").shape == (0,)
    with pytest.raises(KeyError):
        response.transfer("A", "B.angle")


def test_present_values_of_parameters_count() -> None:
    m = pendulum()
    m.parameters["k"] = 5
    assert m.static()["stiffness"][0] == pytest.approx(STIFFNESS + 2)


def test_efforts_of_a_formula_and_of_a_table() -> None:
    m = pendulum()
    formula = m.inverse({"A.angle": "0.1*sin(2*t)"}, times="0:1 s:11")
    t = np.linspace(0, 1, 401)
    by_table = m.inverse({"A.angle": (t, 0.1 * np.sin(2 * t))}, times=(0, 1, 11))
    assert set(formula) == set(by_table)
    name = next(load["name"] for load in formula.facts["loads"])
    assert np.allclose(formula[name][1:-1], by_table[name][1:-1], atol=1e-3)
    with pytest.warns(bksim.InputWarning, match="30 rad = 4.8 turns") as caught:
        m.inverse({"A.angle": "30*sin(2*t)"}, times="0:1 s:11")
    assert Path(caught[0].filename) == Path(__file__)


RUBBING = """
[units]
length = "mm"
[bodies.cart]
mass = "2 kg"
[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
[loads.rub]
type = "friction"
joint = "rail"
force = "5 N"
[curves.lift]
type = "cam-law"
segments = [{ rise = "60 mm", over = "90 deg", law = "3-4-5" }, { dwell = "270 deg" }]
"""


def test_efforts_against_friction_and_motions_with_units() -> None:
    m = bksim.loads(RUBBING)
    moved = m.inverse({"rail.position": "100 mm*t/(1 s)"}, times="0:1 s:3")
    assert np.allclose(moved["rail.position"], [0, 0.05, 0.1])
    assert np.allclose(moved["rail.effort"], 5) and moved.facts["open"] == []
    # A dwell of the law is a rest.
    lifted = m.inverse({"rail.position": "lift(90 deg/s*t)"}, times="0:3 s:4")
    assert np.allclose(lifted["rail.position"][1:], 0.06)
    assert np.allclose([lifted["rail.effort_min"][-1], lifted["rail.effort_max"][-1]], [-5, 5])
    assert lifted.facts["open"] == ["rub"]
    with pytest.raises(bksim.ModelError, match="length"):
        m.inverse({"rail.position": "100 mm/s*t*t"})


def test_a_motion_through_a_stop_is_refused_with_the_instant() -> None:
    m = bksim.loads(RUBBING + "[loads.end]\ntype = \"stop\"\njoint = \"rail\"\nmax = \"50 mm\"\n")
    with pytest.raises(bksim.ModelError, match=r"`end` at t = 0.5 s"):
        m.inverse({"rail.position": "100 mm*t/(1 s)"}, times="0:1 s:3")


def test_the_curve_of_a_motor_is_that_of_a_table_of_the_model() -> None:
    m = bksim.loads(PENDULUM + "[tables.motor]\npoints = [[0, 2], [4, 1]]\ninterpolation = \"linear\"\n")
    motion = {"A.angle": "0.5*sin(3*t)"}
    by_name = m.inverse(motion, times="0:2 s:41", curve={"A": "motor"})
    by_points = m.inverse(motion, times="0:2 s:41", curve={"A": ([0, 4], [2, 1])})
    assert by_name.facts["duties"] == by_points.facts["duties"]
    assert 0 < len(by_name.facts["duties"][0]["outside"]) < 41
    with pytest.raises(bksim.ModelError, match="motor"):
        m.inverse(motion, curve={"A": "other"})


def test_freedoms_and_a_run_verified() -> None:
    m = pendulum()
    assert m.doctor().facts["count"] == {"counted": 1, "mobility": 1, "redundant": 0}
    verified = m.verify(t_end=1.0)
    assert verified.facts["within"] and "A.angle" in verified
    # Without patience a run ends where it is.
    assert swinging().verify(t_end=1e5, patience=0.2)["t"][-1] < 1e5


def test_a_run_needs_no_other_efforts_than_its_own(tmp_path: Path) -> None:
    m = swinging()
    run = m.solve(t_end=1.0, every=1e-3, rtol=1e-10, atol=1e-11)
    run.save(tmp_path / "run.mcap")
    for known in (run, bksim.open(tmp_path / "run.mcap")):
        efforts = m.inverse({"A.angle": known}, times="0:1 s:11")
        assert np.allclose(efforts["A.effort"], 0, atol=1e-6)
    # Times are those of the run.
    assert m.inverse({"A.angle": run})["t"][-1] == pytest.approx(1.0)


def test_a_door_is_in_balance_wherever_it_is() -> None:
    m = bksim.loads(
        "[bodies.door]\nmass = 20\ninertia = 3\n[joints.hinge]\ntype = \"revolute\"\n"
        "between = [\"ground\", \"door\"]\n"
    )
    (only,) = m.static().facts["equilibria"]
    family = only["family"]
    assert (family["dimension"], family["moves"]) == (1, ["hinge.angle"])
    assert "hinge.angle" in family["free"]
    assert pendulum().static().facts["equilibria"][0]["family"] is None


BEAM = """
[parameters]
m = "5 kg"
[bodies.beam]
mass = "m"
inertia = 0.1
com = [0.6, 0]
points = { B = [1, 0], C = [1.5, 0] }
[ground.points]
B = [1, 0]
C = [1.5, 0]
[joints]
A = { type = "revolute", between = ["ground", "beam"] }
B = { type = "revolute", between = ["ground.B", "beam.B"] }
C = { type = "revolute", between = ["ground.C", "beam.C"] }
[loads.weight]
type = "gravity"
acceleration = [0, -9.81]
[solve]
t_end = 0.01
"""


def test_joints_that_yield_share_in_runs_and_sweeps_what_the_command_says(tmp_path: Path) -> None:
    file = tmp_path / "beam.toml"
    file.write_text(BEAM)
    m = bksim.load(file)
    springs = {"A": "1e8 N/m", "B": "3e8 N/m", "C": ["1e8 N/m", "1e5 N m/rad"]}
    run = m.solve(compliance=springs)
    force = run["reactions.B.fy"]
    assert abs(force[0] - m.solve()["reactions.B.fy"][0]) > 1
    # Settling by y + angle*x, each force is k*(y + angle*x); y and angle from the balance.
    k, x = np.array([1, 3, 1]), np.array([0, 1, 1.5])
    y, angle = np.linalg.solve([[k.sum(), k @ x], [k @ x, k @ x**2]], 5 * 9.81 * np.array([1, 0.6]))
    assert np.allclose(force, 3 * (y + angle), rtol=1e-9)
    assert not any("fy" in name for _, names in run.not_unique for name in names)

    words = [sys.executable, "-m", "bksim", "solve", str(file), "-o", str(tmp_path / "command.mcap")]
    for name, stiffness in [("A", "1e8 N/m"), ("B", "3e8 N/m"), ("C", "1e8 N/m"), ("C", "1e5 N m/rad")]:
        words += ["--compliance", f"{name}={stiffness}"]
    subprocess.run(words, check=True, capture_output=True)
    run.save(tmp_path / "python.mcap")
    logs = [bksim.open(tmp_path / name) for name in ("command.mcap", "python.mcap")]
    for known in (*logs, pickle.loads(pickle.dumps(run))):
        assert np.array_equal(known["reactions.B.fy"], force)
        assert np.array_equal(known(0.005)["reactions.B.fy"], run(0.005)["reactions.B.fy"])
        assert known.not_unique == run.not_unique

    s = bksim.sweep(m, {"m": [5, 7]}, outputs=["final(reactions.B.fy)"], compliance=springs)
    m.parameters["m"] = 7
    assert s["final(reactions.B.fy)"][1] == m.solve(compliance=springs)["reactions.B.fy"][-1]
    assert s.solve(0)["reactions.B.fy"][-1] == pytest.approx(force[-1])
    with pytest.raises(bksim.ModelError, match="Q002"):
        m.solve(compliance={"D": "1 N/m"})


def test_an_unknown_name_is_told() -> None:
    with pytest.raises(bksim.ModelError, match="q2"):
        pendulum().static(over={"q2": (0, 1, 2)})
    with pytest.raises(ValueError, match="static"):
        pendulum().modes(at="somewhere")


def test_an_answer_shows_itself() -> None:
    answer = pendulum().modes()
    assert "1 mode," in str(answer) and "columns" in repr(answer) and "<table" in answer._repr_html_()
