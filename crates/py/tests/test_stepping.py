"""Motions that are advanced from Python."""

import copy
import pickle
import threading
import time
from pathlib import Path

import bksim
import numpy as np
import pytest

FIXTURES = Path(__file__).parents[3] / "tests" / "fixtures"
ARM = (FIXTURES / "driven-arm.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("method", ["explicit", "radau"])
def test_held_states_are_the_samples_of_a_solution(method):
    m = bksim.loads(ARM, set={"u": 3})
    sol, run = m.solve(method=method), m.begin(method=method)
    for k, t in enumerate(sol.t):
        run.advance_to(t)
        assert run.t == t
        np.testing.assert_array_equal(run.q, sol.q[:, k])
        np.testing.assert_array_equal(run.v, sol.v[:, k])
        np.testing.assert_array_equal(run.a, sol.a[:, k])
        np.testing.assert_array_equal(run.reactions["A"], sol.reactions["A"][:, k])
        assert run["energy.total"] == sol["energy.total"][k]


def test_a_controller_keeps_the_arm_where_it_is_wanted():
    run = bksim.loads(ARM).begin()
    integral = 0.0
    for k in range(2000):
        error = 0.5 - run["theta"]
        integral += 1e-3 * error
        run.set_input("u", 120 * error + 200 * integral - 15 * run.v[0])
        run.advance_to(1e-3 * (k + 1))
    assert run["theta"] == pytest.approx(0.5, abs=2e-3)
    # What holds it there is what gravity asks for.
    assert run["reactions.A.mz"] == pytest.approx(0, abs=1e-9)
    assert 120 * error + 200 * integral == pytest.approx(9.81 * np.cos(0.5), rel=0.05)


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda run: pickle.loads(pickle.dumps(run))])
def test_a_copy_goes_on_as_the_motion_does(again):
    run = bksim.loads(ARM).begin(method="radau", rtol=1e-8)
    for t, u in ((0.1, 20.0), (0.303, -5.0)):
        run.set_input("u", u)
        run.advance_to(t)
    # An input that is set and has not acted yet is copied, too.
    run.set_input("u", 7.0)
    other = again(run)
    assert other.t == 0.303 and other is not run
    assert np.array_equal(other.lam, run.lam) and other["energy.work"] == run["energy.work"]
    other.advance_to(1.1)
    assert run.t == 0.303
    run.advance_to(1.1)
    assert np.array_equal(other.q, run.q) and np.array_equal(other.v, run.v)
    assert other["energy.work"] == run["energy.work"]


def test_a_saved_state_goes_to_another_process():
    run = bksim.loads(ARM).begin()
    run.advance_to(0.303)
    state = pickle.dumps(run.save())
    run.advance_to(1.7)
    other = bksim.loads(ARM).begin()
    other.restore(pickle.loads(state))
    assert other.t == 0.303
    other.advance_to(1.7)
    assert np.array_equal(other.q, run.q) and np.array_equal(other.v, run.v)


def test_a_saved_state_goes_on_the_same():
    run = bksim.loads(ARM).begin()

    def later():
        run.set_input("u", 20.0)
        run.advance_to(0.7)
        run.set_input("u", -5.0)
        run.advance_to(1.9)
        return run.q, run.v, run["energy.work"]

    run.advance_to(0.303)
    state = run.save()
    first = later()
    run.restore(state)
    assert run.t == 0.303
    assert all(np.array_equal(a, b) for a, b in zip(first, later(), strict=True))


def test_what_cannot_be_is_refused():
    run = bksim.loads(ARM).begin(t_end=1)
    with pytest.raises(KeyError, match="no parameter is called `w`"):
        run.set_input("w", 1.0)
    with pytest.raises(ValueError, match="`m` cannot be an input: the kinetic energy depends"):
        run.set_input("m", 1.0)
    with pytest.raises(ValueError, match="outside of what is left of the run, 0 s to 1 s"):
        run.advance_to(1.5)
    with pytest.raises(KeyError, match="did you mean 'theta'"):
        run["thta"]
    m = bksim.loads(ARM)
    m.inputs["u"] = lambda t, q, v: 1.0
    with pytest.raises(ValueError, match="`u` follows a law"):
        m.begin().set_input("u", 1.0)


def test_a_motion_that_cannot_go_on_says_why():
    m = bksim.loads(ARM.replace('value = "u"', 'value = "u + 1 N m*sqrt(0.5 - t/(1 s))"'))
    run = m.begin()
    with pytest.raises(bksim.SolverError, match="load `motor` has no value at t = 0.5 s") as caught:
        run.advance_to(1.0)
    assert caught.value.t == pytest.approx(0.5) and caught.value.result is None


def test_control_c_ends_a_long_advance():
    m = bksim.loads(ARM)
    m.inputs["u"] = lambda t, q, v: np.sin(1e6 * t)
    run = m.begin(t_end=1e6)
    begun = time.monotonic()
    threading.Timer(0.3, lambda: __import__("_thread").interrupt_main()).start()
    with pytest.raises(KeyboardInterrupt):
        run.advance_to(1e6)
    assert time.monotonic() - begun < 5


def test_the_example_brings_the_pole_to_rest(examples, capsys):
    import runpy

    runpy.run_path(str(examples / "cart-pole" / "control.py"), run_name="__main__")
    shown = capsys.readouterr().out
    readme = (examples / "cart-pole" / "README.md").read_text(encoding="utf-8")
    assert shown in readme


def test_a_quantity_without_a_value_is_an_error():
    run = bksim.loads(ARM + '\n[outputs]\nratio = "1/max(t - 0.5, 0)"\n').begin()
    with pytest.raises(ValueError, match="`ratio` has no value at t = 0 s: it is inf"):
        run["ratio"]
    assert run["theta"] == 0.0
