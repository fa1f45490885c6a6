"""Parameters that are functions of Python."""

import threading
import time
from pathlib import Path

import bksim
import numpy as np
import pytest

FIXTURES = Path(__file__).parents[3] / "tests" / "fixtures"
ARM = (FIXTURES / "driven-arm.toml").read_text(encoding="utf-8")


def arm(law: str = "u") -> bksim.Model:
    return bksim.loads(ARM.replace('value = "u"', f'value = "{law}"'))


def control(t, q, v):
    return 9.81 - 40 * (q[0] - 0.5) - 5 * v[0] + np.sin(3 * t)


WRITTEN = "9.81 N m - 40 N m*(theta - 0.5) - 5 N m s*theta_dot + 1 N m*sin(3*t/(1 s))"


@pytest.mark.parametrize("method", ["explicit", "radau"])
def test_the_motion_is_that_of_the_same_law_in_the_model(method):
    m = arm()
    m.inputs["u"] = control
    sol, own = m.solve(method=method), arm(WRITTEN).solve(method=method)
    np.testing.assert_allclose(sol["theta"], own["theta"], atol=1e-7)
    np.testing.assert_allclose(sol.a, own.a, atol=1e-5)
    wanted = [control(t, q, v) for t, q, v in zip(sol.t, sol.q.T, sol.v.T, strict=True)]
    np.testing.assert_allclose(sol.inputs["u"], wanted, rtol=1e-12)
    assert sol["u"] is not None and sol.unit("u") == "N*m"
    np.testing.assert_allclose(sol(0.777)["u"], control(0.777, sol(0.777).q, sol(0.777).v))


def test_compiled_functions_call_it_too():
    m = arm()
    m.inputs["u"] = control
    f, own = m.compile(), arm(WRITTEN).compile()
    q, v = np.linspace(0, 1, 7)[:, None], np.linspace(-1, 1, 7)[:, None]
    np.testing.assert_allclose(f.forces(0.3, q, v), own.forces(0.3, q, v))
    np.testing.assert_allclose(f.accelerations(0.3, q, v), own.accelerations(0.3, q, v))


def test_it_is_a_number_again_once_it_is_taken_off():
    m = arm()
    before = m.solve()["theta"]
    m.inputs["u"] = control
    assert list(m.inputs) == ["u"] and not np.allclose(m.solve()["theta"], before)
    del m.inputs["u"]
    assert np.array_equal(m.solve()["theta"], before)


def test_what_it_raises_ends_the_run_with_its_motion():
    def law(t, q, v):
        if t > 0.5:
            raise ZeroDivisionError("no more")
        return 1.0

    m = arm()
    m.inputs["u"] = law
    with pytest.raises(ZeroDivisionError, match="no more") as caught:
        m.solve()
    result = caught.value.result
    assert 0.4 < result.t[-1] <= 0.5 and not result.success
    m.inputs["u"] = lambda t, q, v: 1.0
    assert m.solve().success, "nothing of it is left"


@pytest.mark.parametrize("law", [lambda t, q: 1.0, lambda: 1.0])
def test_a_function_that_does_not_fit_says_so_at_the_start(law):
    m = arm()
    m.inputs["u"] = law
    with pytest.raises(TypeError):
        m.solve()
    with pytest.raises(TypeError):
        m.assemble()


def test_a_value_that_is_not_finite_is_named():
    m = arm()
    m.inputs["u"] = lambda t, q, v: 1.0 if t < 0.5 else np.nan
    with pytest.raises(bksim.SolverError, match="the input `u` has no value") as caught:
        m.solve()
    assert caught.value.t == pytest.approx(0.5)


def test_only_loads_may_depend_on_it():
    m = arm()
    with pytest.raises(KeyError, match="did you mean 'u'"):
        m.inputs["uu"] = control
    with pytest.raises(TypeError, match="parameters"):
        m.inputs["u"] = 3.0
    m.inputs["length"] = control
    with pytest.raises(bksim.ModelError) as caught:
        m.solve()
    assert caught.value.diagnostics[0].code == "S013"


def test_a_log_keeps_its_samples(tmp_path):
    m = arm()
    m.inputs["u"] = control
    sol = m.solve(every=0.01)
    sol.save(tmp_path / "run.mcap")
    logged = bksim.open(tmp_path / "run.mcap")
    assert np.array_equal(logged.inputs["u"], sol.inputs["u"])
    # Between samples it is a straight line there.
    np.testing.assert_allclose(logged(0.777).q, sol(0.777).q, atol=1e-12)
    np.testing.assert_allclose(logged(0.777).a, sol(0.777).a, atol=2e-3)


def test_a_sweep_refuses_it():
    m = arm()
    m.inputs["u"] = control
    with pytest.raises(ValueError, match="inputs u"):
        bksim.sweep(m, {"length": [1.0, 1.1]}, outputs=["final(theta)"])


def test_threads_share_a_model_whose_law_waits_for_the_interpreter():
    m = arm()
    m.inputs["u"] = control
    expected = m.solve()["theta"]
    found = []

    def work():
        for _ in range(3):
            found.append(m.solve()["theta"])
            assert m.name == "model" and m.parameters["length"] == 1.0

    threads = [threading.Thread(target=work, daemon=True) for _ in range(6)]
    begun = time.monotonic()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert time.monotonic() - begun < 60
    assert len(found) == 18 and all(np.array_equal(theta, expected) for theta in found)


def test_a_function_may_use_the_model_itself():
    m = arm()
    f = arm().compile()
    m.inputs["u"] = lambda t, q, v: -float(f.forces(t, q, v)[0]) + 0 * len(m.coordinates)
    sol = m.solve()
    # The motor holds what gravity pulls.
    np.testing.assert_allclose(sol["theta"], 0, atol=1e-12)


def test_what_a_function_raises_has_the_line_that_raised_it():
    def law(t, q, v):
        return [1.0, 2.0][5] if t > 0.5 else 1.0

    m = arm()
    m.inputs["u"] = law
    with pytest.raises(IndexError) as caught:
        m.solve()
    assert caught.traceback[-1].name == "law"


@pytest.mark.parametrize("value", [None, "much", np.zeros(1), np.zeros(2)])
def test_a_value_that_is_no_number_is_named_with_its_input(value):
    m = arm()
    m.inputs["u"] = lambda t, q, v: value
    with pytest.raises(TypeError, match="input `u` is"):
        m.solve()


def test_a_function_that_solves_its_own_model_ends():
    m = arm()
    m.inputs["u"] = lambda t, q, v: float(m.solve(t_end=0.01)["theta"][-1])
    with pytest.raises(RecursionError):
        m.solve()


def test_no_value_at_the_start_is_laid_to_the_input():
    m = arm()
    m.inputs["u"] = lambda t, q, v: np.nan
    with pytest.raises(bksim.AssemblyError, match="a function of the motion"):
        m.solve()


def test_an_input_is_no_number_meanwhile():
    m = arm()
    m.inputs["u"] = control
    with pytest.raises(ValueError, match="is an input"):
        m.parameters["u"] = 3.0


class Integral:
    """The integral of the error, as a controller without a clock has it."""

    def __init__(self):
        self.reset()

    def reset(self):
        self.sum, self.calls = 0.0, []

    def __call__(self, t, q, v):
        self.calls.append(t)
        self.sum += 0.01 * (0.5 - q[0])
        return 9.81 + 20 * self.sum - 5 * v[0]


def test_a_law_with_a_memory_is_refused():
    class Remembering:
        last, sum = 0.0, 0.0

        def __call__(self, t, q, v):
            self.sum += (t - self.last) * (0.5 - q[0])
            self.last = t
            return 9.81 + 20 * self.sum - 5 * v[0]

    m = arm()
    for law in [Remembering(), Integral()]:
        m.inputs["u"] = law
        with pytest.raises(ValueError, match="the input `u` is .* at the same t, q and v.*Sampled"):
            m.solve()
        with pytest.raises(ValueError, match="the input `u` is .* at the same t, q and v.*Sampled"):
            m.begin()
    m.inputs["u"] = control
    assert m.solve().success
    m.inputs["u"] = bksim.Sampled(Integral(), every=0.01)
    with pytest.raises(ValueError, match="the inputs u have sampled laws"):
        m.begin()


def test_a_law_that_remembers_only_later_is_refused_when_the_run_has_ended():
    class Latch:
        closed = False

        def __call__(self, t, q, v):
            self.closed = self.closed or t > 0.5
            return 5.0 if self.closed else 1.0

    m = arm()
    m.inputs["u"] = Latch()
    with pytest.raises(ValueError, match="is 1 and then 5 at the same"):
        m.solve()


def test_a_sampled_law_is_called_once_per_interval_and_anew_in_every_solve():
    m, law = arm(), Integral()
    m.inputs["u"] = bksim.Sampled(law, every=0.01)
    first = m.solve(t_end=0.5)
    np.testing.assert_allclose(law.calls, np.arange(50) * 0.01, atol=1e-12)
    second = m.solve(t_end=0.5)
    assert np.array_equal(first["theta"], second["theta"])
    assert len(law.calls) == 50

    # The same, advanced by hand.
    by_hand, again = arm().begin(t_end=0.5), Integral()
    for k in range(50):
        by_hand.set_input("u", again(by_hand.t, by_hand.q, by_hand.v))
        by_hand.advance_to(0.01 * (k + 1))
    np.testing.assert_allclose(first["theta"][-1], by_hand["theta"], atol=1e-6)


def test_a_sampled_law_says_what_is_wrong_with_it():
    with pytest.raises(ValueError, match="every = 0"):
        bksim.Sampled(control, every=0)
    with pytest.raises(TypeError, match="no function"):
        bksim.Sampled(3.0, every=0.1)
    m = arm()
    m.inputs["u"] = bksim.Sampled(lambda t, q, v: float("nan"), every=0.1)
    with pytest.raises(ValueError, match="the input `u` is nan at t = 0"):
        m.solve()
