"""Models: read, built in code, changed; their equations."""

from __future__ import annotations

import copy
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import bksim

PENDULUM = """
[parameters]
l = "0.5 m"
[bodies.bob]
mass = "2 kg"
com = [0, "-l"]
[joints.A]
type = "revolute"
between = ["ground", "bob"]
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[initial]
A = { angle = "30 deg" }
[solve]
t_end = "1 s"
"""

LIFT = """
space = "spatial"
[bodies.car]
mass = "40 kg"
inertia = ["2 kg m^2", "2 kg m^2", "1 kg m^2"]
[joints.mast]
type = "cylindrical"
between = ["ground", "car"]
axis = [0, 0, 1]
"""


def pendulum_in_code() -> bksim.Model:
    m = bksim.Model("model", parameters={"l": "0.5 m"})
    m.bodies["bob"] = bksim.Body(mass="2 kg", com=[0, "-l"])
    m.joints["A"] = bksim.Revolute("ground", "bob")
    m.loads["gravity"] = bksim.Gravity(acceleration=[0, "-9.81 m/s^2"])
    m.initial["A"] = {"angle": "30 deg"}
    m.options["t_end"] = "1 s"
    return m


def test_a_model_built_in_code_is_the_model_of_the_text() -> None:
    read, built = bksim.load(PENDULUM), pendulum_in_code()
    assert built.equations.text == read.equations.text
    assert np.array_equal(built.solve().q, read.solve().q)
    assert bksim.load(built.text).bodies == built.bodies


def test_joints_of_every_kind_survive_the_way_through_their_tables() -> None:
    from bksim._joints import JOINTS, joint_from_table
    from bksim._parts import to_table

    needed = {"length": "1 m", "lead": "5 mm", "second_": [0, 1, 0], "curve": "track", "second_curve": "rail"}
    needed |= {"shape": "disc", "radius": "20 cm"}
    for kind in JOINTS:
        own = {name: needed[name] for name in needed if name in kind.__dataclass_fields__}
        joint = kind("ground", "body.P", **own)
        assert to_table(joint)["type"] == kind.type
        assert joint_from_table(to_table(joint)) == joint
    assert {"spherical", "screw", "point-on-curve"} < {kind.type for kind in JOINTS}


def test_every_example_survives_the_way_through_its_objects(example: Path) -> None:
    m = bksim.load(example)
    before = m.solve(t_end=0.1).q
    m.options["rtol"] = m.options.get("rtol", 1e-6)
    m.bodies["another"] = bksim.Body(mass=1, free=True)
    del m.bodies["another"]
    m._document.name = m.name  # type: ignore[union-attr]
    assert np.array_equal(m.solve(t_end=0.1).q, before)


def test_parameters_are_si_or_text() -> None:
    m = bksim.load(PENDULUM)
    assert m.parameters["l"] == 0.5
    assert m.parameters.unit("l") == "m"
    m.parameters["l"] = 0.8
    assert m.parameters["l"] == 0.8
    m.parameters["l"] = "80 cm"
    assert math.isclose(m.parameters["l"], 0.8, rel_tol=1e-15)
    del m.parameters["l"]
    assert m.parameters["l"] == 0.5
    with pytest.raises(KeyError, match="did you mean 'l'"):
        m.parameters["ll"] = 1.0


def test_a_value_that_is_refused_can_be_replaced(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "model.toml")
    m.parameters["m2"] = -1.0
    with pytest.raises(bksim.ModelError, match="mass"):
        m.solve(t_end=0.1)
    m.parameters["m2"] = 4.0
    assert m.solve(t_end=0.1).success and m.parameters["m2"] == 4.0


def test_a_parameter_in_a_file_of_millimetres_is_set_in_metres() -> None:
    m = bksim.load('[units]\nlength = "mm"\n' + PENDULUM.replace("0.5 m", "500 mm"))
    assert m.parameters["l"] == 0.5
    m.parameters["l"] = 0.25
    assert m.parameters["l"] == 0.25


def test_numpy_values_are_written_as_numbers() -> None:
    m = pendulum_in_code()
    m.bodies["bob"].mass = np.float64(2.0)
    m.bodies["bob"].com = np.array([0.0, -0.5])  # type: ignore[assignment]
    assert np.allclose(m.solve().q, pendulum_in_code().solve().q, rtol=0, atol=1e-12)


def test_a_drawing_is_a_model(examples: Path) -> None:
    m = bksim.load(examples / "slider-crank" / "drawing.dxf")
    assert m.check().mobility == 1
    assert "[bodies" in m.text


def test_faults_have_places_and_names(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(PENDULUM.replace('"bob"]', '"bbo"]'))
    with pytest.raises(bksim.ModelError, match="bad.toml:9:") as caught:
        bksim.load(path)
    (fault,) = caught.value.diagnostics
    assert fault.severity == "error" and fault.labels[0].line == 9
    assert bksim.explain(fault.code)
    assert "## Cách sửa" in (bksim.explain(fault.code, "vi") or "")
    assert str(path) in str(fault)


def test_what_is_no_file_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        bksim.load(tmp_path / "none.toml")
    with pytest.raises(bksim.ModelError, match="written down"):
        m = pendulum_in_code()
        m.bodies["bob"].mass = math.nan
        m.check()


def test_a_loop_that_cannot_close_is_an_assembly_error(examples: Path) -> None:
    m = bksim.load(examples / "four-bar" / "model.toml")
    m.parameters["b"] = 3.0
    with pytest.raises(bksim.AssemblyError) as caught:
        m.assemble()
    assert isinstance(caught.value, bksim.Error) and caught.value.diagnostics


def test_check_counts(examples: Path) -> None:
    check = bksim.load(examples / "parallelogram" / "model.toml").check()
    assert check.mobility == 1 and check.gruebler == 0 and check.redundant_joints
    assert "true mobility" in str(check) and "<table>" in check._repr_html_()


def test_the_start_holds_the_constraints(example: Path) -> None:
    start = bksim.load(example).assemble()
    assert start.position_residual < 1e-9 and start.velocity_residual < 1e-9
    assert set(start.q) == set(start.v) == set(start.a)


def test_equations_are_text_latex_and_sympy() -> None:
    sympy = pytest.importorskip("sympy")
    equations = bksim.load(PENDULUM).equations
    assert equations.kinetic_energy == "l^2*A_angle_dot^2"
    assert equations._repr_latex_().startswith("$$\\begin{aligned}")
    assert r"\dot" in equations.latex and "<math" in equations.mathml
    assert equations.certificate["reading"]["equal"]
    found = equations.to_sympy()
    l, rate = sympy.symbols("l A_angle_dot", real=True)
    assert sympy.simplify(found["kinetic_energy"] - l**2 * rate**2) == 0
    with pytest.raises(ValueError, match="none of"):
        equations.written("word")


def test_equations_have_the_parts_that_are_asked_for(examples: Path) -> None:
    linkage = bksim.load(examples / "four-bar" / "model.toml").equations
    text = linkage.written(steps=True, levels=True, free_bodies=True)
    for title in ["step 1: centres of mass", "equations of motion", "velocity"]:
        assert title in text, text
    absolute = linkage.in_absolute_angles
    assert absolute.equations != linkage.equations
    assert "step 4" in absolute.written("latex", steps=True)
    with pytest.raises(ValueError, match="no explicit form"):
        bksim.load(examples / "slider-crank" / "model.toml").equations.written(effort=True)


def test_sympys_equations_are_those_that_are_solved(examples: Path) -> None:
    pytest.importorskip("sympy")
    m = bksim.load(examples / "slider-crank" / "model.toml")
    sol = m.solve(t_end=0.3)
    values = {name: value for name, value in m.parameters.items()} | {"t": float(sol.t[-9])}
    for k, name in enumerate(m.coordinates):
        values |= {name: sol.q[k, -9], f"{name}_dot": sol.v[k, -9], f"{name}_ddot": sol.a[k, -9]}
    names = [name.split(".")[1] for name in sol.names if name.startswith("multipliers.")]
    values |= {name: sol.lam[k, -9] for k, name in enumerate(names)}
    for left in m.equations.to_sympy()["equations"]:
        known = {symbol: values[symbol.name] for symbol in left.free_symbols}
        size = max(abs(float(term.subs(known))) for term in left.as_ordered_terms())
        assert abs(float(left.subs(known))) < 1e-9 * size


def test_other_numbers_need_no_other_equations(examples):
    path = examples / "slider-crank" / "model.toml"
    m = bksim.load(path)
    m.parameters["l1"], m.parameters["m1"] = 0.9, 4.0
    first = m.solve(t_end=0.5)
    engine = m._engine()
    for l1 in (1.1, 0.8):
        m.parameters["l1"] = l1
        sol = m.solve(t_end=0.5)
        assert engine.at([l1, 4.0], []) is not None, "the equations are those that are there"
        fresh = bksim.load(path, set={"l1": f"{l1} m", "m1": "4 kg"})
        assert np.array_equal(sol._table, fresh.solve(t_end=0.5)._table)
        assert m.parameters["l1"] == l1 and m.assemble() == fresh.assemble()
        assert str(m.check()) == str(fresh.check())
        assert m.equations.text == fresh.equations.text
    assert not np.array_equal(first.q, sol.q)
    own = bksim.load(path, set={"l1": "0.9 m", "m1": "4 kg"}).solve(t_end=0.5)
    assert np.array_equal(first(0.25).q, own(0.25).q), "a solution keeps its own values"
    # Where the reader must look itself, it does.
    m.parameters["m1"] = -4.0
    with pytest.raises(bksim.ModelError, match="M040"):
        m.solve()
    m.parameters["m1"] = 4.0
    assert np.array_equal(m.solve(t_end=0.5).q, sol.q)


def test_warnings_are_about_the_present_numbers(examples):
    m = bksim.load(examples / "slider-crank" / "model.toml")
    m.parameters["m3"] = 10.0
    before = [d.code for d in m.diagnostics]
    m.parameters["m3"] = 3e12
    assert [d.code for d in m.diagnostics] != before
    assert [d.code for d in m.check().diagnostics] == [d.code for d in m.diagnostics]


def test_all_own_values_come_back(examples):
    m = bksim.load(examples / "slider-crank" / "model.toml")
    own = dict(m.parameters)
    m.parameters["l1"], m.parameters["m1"] = 0.7, "4 kg"
    assert 'l1 = "0.7 m"' in m.text and 'm1 = "4 kg"' in m.text, "the text has what was set"
    assert bksim.loads(m.text).parameters["l1"] == 0.7
    with pytest.raises(TypeError, match="keeps its parameters"):
        m.parameters.popitem()
    m.parameters.clear()
    assert dict(m.parameters) == own


def test_a_copy_is_a_model_of_its_own(examples):
    m = bksim.load(examples / "slider-crank" / "model.toml")
    m.parameters["l1"] = 0.7
    m.solve(t_end=0.1)
    for other in (m.copy(), copy.copy(m), copy.deepcopy(m), pickle.loads(pickle.dumps(m))):
        assert np.array_equal(other.solve(t_end=0.1).q, m.solve(t_end=0.1).q)
        other.parameters["l1"] = 0.9
        other.loads["gravity"].acceleration = [0, -1.0]
        assert m.parameters["l1"] == 0.7 and m.loads["gravity"].acceleration != [0, -1.0]


def test_what_is_refused_can_still_be_looked_at(examples):
    m = bksim.load(examples / "slider-crank" / "model.toml")
    m.parameters["m3"] = -3.0
    assert "refused" in repr(m) and "m3 = -3.0 kg" in repr(m.parameters)
    assert "refused" in repr(bksim.Model())
    for value in (math.nan, math.inf, None):
        with pytest.raises(ValueError, match="finite number"):
            m.parameters["m3"] = value
    with pytest.raises(bksim.ModelError) as caught:
        m.solve()
    assert caught.value.diagnostics and str(caught.value).startswith("error"), str(caught.value)


def test_parts_refuse_what_they_do_not_have():
    body = bksim.Body(mass=1)
    with pytest.raises(AttributeError):
        body.masss = 5
    m = bksim.Model()
    m.bodies["b"] = None
    with pytest.raises(TypeError, match="no part of a model"):
        m.check()


def test_conditions_and_any_names_reach_sympy():
    sympy = pytest.importorskip("sympy")
    m = bksim.loads(PENDULUM.replace('l = "0.5 m"', 'l = "0.5 m"\nlambda = "1 N m"') + '''
[loads]
motor = { type = "torque", on = "bob", value = "if(A.angle > 0.1 rad, lambda, 0.2 N m)" }
''')
    found = m.equations.to_sympy()["equations"][0]
    assert found.has(sympy.Piecewise) and sympy.Symbol("lambda", real=True) in found.free_symbols


def test_a_changed_model_keeps_what_has_no_class(examples: Path) -> None:
    m = bksim.load(examples / "winch" / "model.toml")
    m.bodies["load"].mass = "41 kg"
    for section in ("couplings.sun1", "states.i", "signals.voltage"):
        assert f"[{section}]" in m.text
    weight = m.solve(t_end=2)["couplings.rope"][-1]
    assert abs(weight - 41 * 9.81) < 1e-2


def test_a_model_of_several_files_is_loaded_with_its_parts(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.toml").write_text(
        "[parameters]\nl = \"0.5 m\"\n[ground]\npoints = { O = [0, 0] }\n"
        '[bodies.bob]\nmass = "1 kg"\ncom = [0, "-l"]\n'
        '[joints.A]\ntype = "revolute"\nbetween = ["ground.O", "bob"]\n',
        encoding="utf-8",
    )
    path = tmp_path / "two.toml"
    path.write_text(
        '[loads.g]\ntype = "gravity"\nacceleration = [0, "-9.81 m/s^2"]\n'
        '[use.arm]\ncount = 2\nfile = "parts/arm.toml"\nwith = { l = "{i} m" }\n'
        '[initial.arm1_A]\nangle = "0.1 rad"\n[initial.arm2_A]\nangle = "0.1 rad"\n',
        encoding="utf-8",
    )
    m = bksim.load(path)
    assert list(m.coordinates) == ["arm1_A_angle", "arm2_A_angle"]
    end = m.solve(t_end=1.0).q[:, -1]
    m.parameters["arm2_l"] = 1.0
    same = m.solve(t_end=1.0).q[:, -1]
    assert abs(end[0] - end[1]) > 0.03
    np.testing.assert_allclose(same, end[0], rtol=1e-6)
    (tmp_path / "parts" / "arm.toml").unlink()
    with pytest.raises(bksim.ModelError, match=r"parts/arm.toml.*no such file"):
        bksim.load(path).check()


def test_a_motor_has_its_units(examples: Path) -> None:
    m = bksim.load(examples / "winch" / "model.toml")
    units = [m.parameters.unit(name) for name in ("R", "L", "K", "V_max")]
    assert units == ["ohm", "H", "N m/A", "V"]
    # A number is in SI, a text as it says.
    m.parameters["R"] = 0.3
    as_number = m.solve(t_end=0.2)
    m.parameters["R"] = "300 mohm"
    as_text = m.solve(t_end=0.2)
    assert np.array_equal(as_number.q, as_text.q)
    assert (as_text.unit("state.i"), as_text.unit("signals.voltage")) == ("A", "V")
    with pytest.raises(bksim.ModelError) as caught:
        m.parameters["R"] = "300 mV"
        m.solve(t_end=0.2)
    assert "M032" in str(caught.value)
    # A current at the start is an axis of a sweep, with its unit.
    del m.parameters["R"]
    swept = bksim.sweep(m, {"i": [0.0, 20.0]}, outputs=["max(i)", "i@0"], t_end=0.01)
    assert swept.unit("i") == swept.unit("max(i)") == "A"
    assert np.allclose(swept["i@0"], [0.0, 20.0], rtol=1e-14)


def test_faults_of_a_model_built_in_code_name_its_parts() -> None:
    m = pendulum_in_code()
    m.bodies["bob"].points["P"] = [0, "2 kg"]
    m.joints["A"].second = "bobb"
    m.initial["A"] = {"angle": "30 m"}
    m.loads["gravity"] = bksim.Gravity(acceleration=[0, "-g"])
    m.options["t_end"] = "1 m"
    with pytest.raises(bksim.ModelError) as caught:
        m.check()
    words = str(caught.value)
    assert ".toml" not in words
    assert '  --> joints["A"].second: no body has this name' in words
    parts = {label.part for fault in caught.value.diagnostics for label in fault.labels}
    assert {
        'bodies["bob"].points["P"][1]',
        'joints["A"].second',
        'loads["gravity"].acceleration[1]',
        'options["t_end"]',
    } <= parts
    first = caught.value.diagnostics[0]
    assert first.file == "" and str(first).startswith(first.labels[0].part)
    # The line and the column are those of its text.
    label = next(at for fault in caught.value.diagnostics for at in fault.labels if "second" in at.part)
    assert m.text.splitlines()[label.line - 1][label.column - 1 :].startswith("bobb")


def test_a_changed_model_of_a_file_has_no_lines_either(examples: Path) -> None:
    m = bksim.load(examples / "four-bar" / "model.toml")
    with pytest.raises(bksim.ModelError, match="model.toml"):
        bksim.load(examples / "four-bar" / "model.toml", set={"a": "1 kg"})
    m.bodies["crank"].mass = "-2 kg"
    with pytest.raises(bksim.ModelError, match=r'--> bodies\["crank"\]\.mass'):
        m.check()


def test_an_example_is_known_by_its_name() -> None:
    assert bksim.example("four-bar").name == "four-bar"
    with pytest.raises(KeyError, match="did you mean 'four-bar'"):
        bksim.example("fourbar")


def test_a_wrong_unit_is_refused_where_it_is_set() -> None:
    m = pendulum_in_code()
    with pytest.raises(bksim.ModelError, match=r"^Body\.mass = '2 m': expected mass, found length \[M031\]"):
        m.bodies["bob"].mass = "2 m"
    assert m.bodies["bob"].mass == "2 kg"
    with pytest.raises(bksim.ModelError, match=r"Gravity\.acceleration .*found length"):
        bksim.Gravity(acceleration=[0, "-9.81 m"])
    with pytest.raises(bksim.ModelError, match=r"Body\.points .*M030"):
        bksim.Body(mass=1, points={"A": [0, "2 furlongs"]})
    with pytest.raises(bksim.ModelError, match=r"Revolute\.second_|Spring\.stiffness"):
        bksim.Spring(between=["ground", "bob"], stiffness="3 N m", length="1 m")
    # What names of the model stand for is not known yet.
    bksim.Body(mass="2*m1 + 1 kg", com=["l1/2", 0])
    bksim.Drive(joint="A", motion="2 rad/s*t + phi0")
    again = copy.deepcopy(m.bodies["bob"])
    assert again == m.bodies["bob"] and pickle.loads(pickle.dumps(again)) == again


def test_a_robot_of_another_program_is_a_model(tmp_path: Path) -> None:
    robot = tmp_path / "arm.urdf"
    text = """<robot name="arm"><link name="base"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="pin" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint></robot>"""
    robot.write_text(text)
    m = bksim.import_model(robot)
    assert m.coordinates == ("pin_angle",)
    # About the pin: 0.1 + 2 · 0.5².
    np.testing.assert_allclose(m.compile().mass_matrix(np.zeros(1)), [[0.6]])
    # And back, with the values of now.
    again = tmp_path / "arm.xml"
    again.write_text(m.robot("mjcf"))
    np.testing.assert_allclose(bksim.import_model(again).compile().mass_matrix(np.zeros(1)), [[0.6]])
    with pytest.raises(bksim.ModelError, match="I024"):
        bksim.loads(LIFT).robot("sdf")
    robot.write_text(text.replace('child link="rod"', 'child link="rot"'))
    with pytest.raises(bksim.ModelError) as raised:
        bksim.import_model(robot)
    assert raised.value.diagnostics[0].code == "I005" and raised.value.diagnostics[0].help is not None
    with pytest.raises(OSError, match="no such file"):
        bksim.import_model(tmp_path / "nothing.urdf")
