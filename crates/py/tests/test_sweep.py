"""Sweeps on all cores here: rows, designs, failures, files, interrupts, executors."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bksim
from bksim._sweep import _asked

LONG = 1e6
"""Seconds of motion that nobody waits for."""

OUTPUTS = ["final(state.x3)", "max(energy.kinetic)", "min(reactions.A.fy)", "theta1@0.1"]


@pytest.fixture
def crank(examples: Path) -> bksim.Model:
    return bksim.load(examples / "slider-crank" / "model.toml")


def interrupt_after(condition: Any) -> threading.Thread:
    """Sends what Ctrl-C sends as soon as a condition holds."""

    def wait() -> None:
        while not condition():
            time.sleep(0.005)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=wait)
    thread.start()
    return thread


def test_a_row_is_what_solve_gives_to_the_last_bit(crank: bksim.Model) -> None:
    axes = {"l1": np.linspace(0.8, 1.1, 7), "A.rate": [0.0, 0.3], "m2": (4.0, 5.5)}
    s = bksim.sweep(crank, axes, outputs=OUTPUTS, t_end=0.2, rtol=1e-7)
    assert len(s) == 28 and s.ok.all() and s.is_whole and s.failures == ()
    assert s.inputs == ("l1", "A.rate", "m2") and s.shape == (7, 2, 2)
    for k in range(len(s)):
        text = crank.text.replace("rate = 0", f"rate = {s['A.rate'][k]!s}")
        alone = bksim.loads(text, set={"l1": s["l1"][k], "m2": s["m2"][k]})
        assert alone.parameters["l1"] == s["l1"][k]
        sol = alone.solve(t_end=0.2, rtol=1e-7)
        assert s["final(state.x3)"][k] == sol["x3"][-1]
        assert s["max(energy.kinetic)"][k] == sol["energy.kinetic"].max()
        assert s["min(reactions.A.fy)"][k] == sol["reactions.A.fy"].min()
        assert s["theta1@0.1"][k] == sol["theta1"][np.searchsorted(sol.t, 0.1 - 1e-9)]
    assert s.unit("l1") == "m" and s.unit("A.rate") == "1/s" and s.unit("theta1@0.1") == "rad"
    torque = bksim.sweep(crank, {"q1": "40:60 N m:2"}, outputs=["max(reactions.A.mz)"], t_end=0.05)
    assert torque.unit("q1") == torque.unit("max(reactions.A.mz)") == "N*m"


def test_a_case_is_solved_again_with_its_values(crank: bksim.Model, tmp_path: Path) -> None:
    crank.parameters["m2"] = 1.5
    swept = bksim.sweep(
        crank, {"l1": "80 cm:120 cm:3", "A.rate": [1.0, 2.0]}, outputs=OUTPUTS[:3], t_end=0.2
    )
    # What is set later changes nothing of it, and it can be sent.
    crank.parameters["m2"] = 9.0
    for case in range(len(swept)):
        sol = pickle.loads(pickle.dumps(swept)).solve(case)
        assert sol.t[-1] == 0.2
        assert sol["state.x3"][-1] == swept["final(state.x3)"][case]
        # The least value is searched between the samples, too.
        sampled, least = sol["reactions.A.fy"].min(), swept["min(reactions.A.fy)"][case]
        assert least <= sampled <= least + 1e-3 * abs(least)
    swept.solve(4, t_end=0.1).save(tmp_path / "case-4.mcap")
    assert bksim.open(tmp_path / "case-4.mcap").t[-1] == 0.1
    with pytest.raises(IndexError, match="0 to 5"):
        swept.solve(6)


@pytest.mark.parametrize("every", [0.01, 0.001])
@pytest.mark.parametrize("outputs", [["final(state.theta1)"], ["final(state.theta1)", "theta1@0.07"], None])
def test_a_case_solved_again_is_its_row_whatever_is_kept(
    crank: bksim.Model, every: float, outputs: list[str] | None
) -> None:
    # At this tolerance the explicit method follows from how many samples there are.
    swept = bksim.sweep(
        crank, {"l1": [0.9, 1.0]}, outputs=outputs, t_end=0.1, rtol=1e-9, every=every
    )
    for case in range(len(swept)):
        sol = swept.solve(case)
        assert sol["state.theta1"][-1] == swept["final(state.theta1)"][case]


def test_what_is_set_on_the_model_holds_in_its_sweeps(crank: bksim.Model) -> None:
    axes = {"l1": [0.9, 1.0]}
    before = bksim.sweep(crank, axes, outputs=OUTPUTS, t_end=0.1)
    crank.parameters["q1"] = 80.0
    after = bksim.sweep(crank, axes, outputs=OUTPUTS, t_end=0.1)
    assert np.all(before["max(energy.kinetic)"] < after["max(energy.kinetic)"])
    # What is varied is no longer what was set.
    crank.parameters["l1"] = 0.5
    again = bksim.sweep(crank, axes, outputs=OUTPUTS, t_end=0.1)
    assert np.array_equal(again["max(energy.kinetic)"], after["max(energy.kinetic)"])


def test_rates_are_varied_and_set_in_si() -> None:
    m = bksim.loads("""
[parameters]
omega = "3 rad/s"
[bodies.wheel]
mass = 1
inertia = 1
[joints.A]
type = "revolute"
between = ["ground", "wheel"]
[initial]
A = { angle = 0, rate = "omega" }
[solve]
t_end = 1
""")
    s = bksim.sweep(m, {"omega": [2.0, 4.0]}, outputs=["final(state.A_angle)"])
    assert np.allclose(s["final(state.A_angle)"], [2.0, 4.0], rtol=1e-12)
    m.parameters["omega"] = 4.0
    assert m.solve()["A.angle"][-1] == s["final(state.A_angle)"][1]


def test_texts_and_numbers_are_the_same_axis(crank: bksim.Model) -> None:
    def of(axis: Any) -> bksim.Sweep:
        return bksim.sweep(crank, {"l1": axis}, outputs=OUTPUTS, t_end=0.1)

    numbers = of([0.8, 0.9, 1.0])
    for axis in ("0.8:1:3", "0.8 m, 0.9 m, 1.0 m", ["0.8 m", "0.9", "1.0"], np.array([0.8, 0.9, 1])):
        other = of(axis)
        assert np.array_equal(other["l1"], numbers["l1"])
        assert np.array_equal(other["max(energy.kinetic)"], numbers["max(energy.kinetic)"])
    assert np.allclose(of("80 cm:100 cm:3")["l1"], numbers["l1"], rtol=1e-15)
    one = bksim.sweep(crank, {"l1": [0.8], "m2": "2*m1"}, outputs=OUTPUTS, t_end=0.1)
    assert one.inputs == ("l1",) and len(one) == 1


def test_cases_that_fail_are_rows_with_their_reason(crank: bksim.Model) -> None:
    s = bksim.sweep(crank, {"m2": [-1, 2.5, 5], "l1": [0.9, 1.0]}, outputs=OUTPUTS, t_end=0.1)
    assert s.ok.tolist() == [False, False, True, True, True, True]
    assert [f.case for f in s.failures] == [0, 1]
    assert {f.status for f in s.failures} == {"refused"}
    for failure in s.failures:
        with pytest.raises(bksim.ModelError) as caught:
            bksim.loads(crank.text, set={"m2": -1, "l1": s["l1"][failure.case]})
        fault = next(d for d in caught.value.diagnostics if d.severity == "error")
        assert (failure.code, failure.reason) == (fault.code, fault.message)
        assert bksim.explain(failure.code)
    assert np.isnan(s["max(energy.kinetic)"][:2]).all()
    assert np.isnan(s.grid("max(energy.kinetic)")[0]).all() and s.grid("l1").shape == (3, 2)
    assert "2 failed" in repr(s) and "refused" in s._repr_html_()


@pytest.mark.parametrize("design", ["random", "latin-hypercube", "sobol"])
def test_samples_lie_in_their_range_and_follow_their_seed(crank: bksim.Model, design: str) -> None:
    def of(seed: int) -> bksim.Sweep:
        axes = {"l1": (0.8, 1.2), "m2": [1.0, 2.0]}
        return bksim.sweep(
            crank, axes, design=design, n=32, seed=seed, outputs=["final(x3)"], t_end=0.05
        )

    first, same, other = of(1), of(1), of(2)
    assert len(first) == 32 and first.shape is None
    assert np.all((first["l1"] >= 0.8) & (first["l1"] < 1.2)) and set(first["m2"]) == {1.0, 2.0}
    assert len(set(first["l1"])) == 32
    assert np.array_equal(first["final(x3)"], same["final(x3)"])
    assert not np.array_equal(first["l1"], other["l1"])
    if design == "latin-hypercube":
        parts = np.floor((first["l1"] - 0.8) / 0.4 * 32)
        assert sorted(parts.tolist()) == list(range(32))
    with pytest.raises(ValueError, match="no grid"):
        first.grid("l1")


def test_tables_have_units(crank: bksim.Model, tmp_path: Path) -> None:
    axes = {"m2": [-1, 2, 3], "l1": [0.9, 1.0]}
    kept = bksim.sweep(crank, axes, outputs=OUTPUTS, t_end=0.1)
    filed = bksim.sweep(crank, axes, outputs=OUTPUTS, t_end=0.1, out=tmp_path / "s.parquet")
    assert filed.path == tmp_path / "s.parquet" and kept.path is None
    assert kept.failures == filed.failures and kept.names == filed.names
    for name in kept.names:
        a, b = kept[name], filed[name]
        assert a.dtype == b.dtype, name
        equal = np.array_equal(a, b, equal_nan=a.dtype == np.float64)
        assert equal, name
    a, b = kept.to_arrow(), filed.to_arrow()
    assert a.column_names == b.column_names and a.num_rows == 6
    for name in a.column_names:
        assert a.column(name).to_pylist() == b.column(name).to_pylist(), name
        assert a.schema.field(name).metadata == b.schema.field(name).metadata
    assert a.schema.field("min(reactions.A.fy)").metadata == {b"unit": b"N"}
    assert a.column("max(energy.kinetic)").null_count == 2
    assert b.schema.metadata[b"bksim.model"].decode() == crank.text
    frame = kept.to_pandas()
    assert frame.equals(filed.to_pandas()) and frame.attrs["units"]["l1"] == "m"
    assert frame.index.name == "case" and frame["status"].tolist()[:3] == ["refused"] * 2 + ["done"]


def test_unreadable_demands_are_refused(crank: bksim.Model, tmp_path: Path) -> None:
    def fails(error: type[Exception], match: str, axes: Any = None, **options: Any) -> None:
        with pytest.raises(error, match=match):
            bksim.sweep(crank, {"l1": [0.9, 1.0]} if axes is None else axes, **options)

    fails(bksim.ModelError, "P002", {"l7": [1, 2]})
    fails(bksim.ModelError, "P005", outputs=["max(energy.kinetik)"])
    fails(bksim.ModelError, "P001", {"l1": [np.nan]})
    fails(bksim.ModelError, "P001", {"l1": []})
    fails(bksim.ModelError, "P004", {"l1": (0.8, 1)}, design="random", n=0)
    fails(bksim.ModelError, "P007", rtol=7)
    fails(ValueError, "numbers in SI", {"l1": [[1], [2, 3]]})
    fails(ValueError, "shape", {"l1": [[1], [2]]})
    fails(ValueError, "design", design="grit", n=3)
    fails(ValueError, "needs n", design="sobol")
    fails(ValueError, "'grid' has none", n=3)
    fails(ValueError, "out", resume=True)
    fails(ValueError, "one of them", out=tmp_path / "s", resume=True, overwrite=True)
    fails(ValueError, "jobs", jobs=-1)
    fails(ValueError, "method", method="euler")
    with pytest.raises(KeyError, match="energy.kinetic"):
        bksim.sweep(crank, {"l1": [1.0]}, outputs=["max(energy.kinetic)"], t_end=0.1)["max(energy)"]


def test_a_file_is_replaced_only_when_that_is_asked_for(crank: bksim.Model, tmp_path: Path) -> None:
    path = tmp_path / "s.parquet"

    def run(axes: Any, **how: bool) -> bksim.Sweep:
        return bksim.sweep(crank, axes, outputs=["final(x3)"], t_end=0.05, out=path, **how)

    run({"l1": [0.9, 1.0]})
    first = path.read_bytes(), path.stat().st_mtime_ns
    with pytest.raises(FileExistsError, match="overwrite=True"):
        run({"l1": [0.9, 1.0]})
    # The same sweep is done already.
    assert len(run({"l1": [0.9, 1.0]}, resume=True)) == 2
    assert (path.read_bytes(), path.stat().st_mtime_ns) == first
    with pytest.raises(FileExistsError, match="not this sweep"):
        run({"l1": [0.9, 1.1]}, resume=True)
    assert run({"l1": [0.9, 1.1]}, overwrite=True)["l1"].tolist() == [0.9, 1.1]


AXES = {"l1": np.linspace(0.8, 1.2, 40), "m2": np.linspace(1, 6, 40)}


def sampled(model: bksim.Model, **how: Any) -> bksim.Sweep:
    """A sweep of some seconds."""
    return bksim.sweep(model, AXES, outputs=["max(energy.kinetic)"], t_end=1.0, **how)


def test_an_interrupted_sweep_says_how_to_go_on_and_does(
    crank: bksim.Model, tmp_path: Path
) -> None:
    whole = sampled(crank, out=tmp_path / "whole.parquet")
    path = tmp_path / "cut.parquet"
    parts = tmp_path / "cut.parquet.parts"
    thread = interrupt_after(lambda: len(list(parts.glob("*.parquet"))) >= 3)
    with pytest.raises(KeyboardInterrupt, match=r"of 1600 cases are kept.*resume=True"):
        sampled(crank, out=path)
    thread.join()
    assert not path.exists()
    kept = {file.name: file.stat().st_mtime_ns for file in parts.glob("*.parquet")}
    assert 3 <= len(kept) < 100
    with pytest.raises(FileExistsError, match="resume=True"):
        sampled(crank, out=path)
    with pytest.raises(FileExistsError, match="resume=True"):
        bksim.sweep(crank, {"l1": [1.0, 1.1]}, t_end=1.0, out=path, resume=True)
    assert {f.name: f.stat().st_mtime_ns for f in parts.glob("*.parquet")} == kept
    resumed = sampled(crank, out=path, resume=True)
    assert len(resumed) == 1600 and not parts.exists()
    assert whole.path is not None and path.read_bytes() == whole.path.read_bytes()


LARGE = {"l1": np.linspace(0.8, 1.2, 100), "m2": np.linspace(1, 6, 100)}


def test_an_interrupted_sweep_in_memory_keeps_what_was_done(crank: bksim.Model) -> None:
    name = "max(energy.kinetic)"
    # Cases are kept in parts of 128, one on each thread, which take a few times what these 64 do.
    few = {of: values[:8] for of, values in LARGE.items()}
    begun = time.perf_counter()
    bksim.sweep(crank, few, outputs=[name], t_end=10.0)
    begun, took = time.perf_counter(), time.perf_counter() - begun
    thread = interrupt_after(lambda: time.perf_counter() - begun > 12 * took)
    with pytest.raises(KeyboardInterrupt, match="result") as caught:
        bksim.sweep(crank, LARGE, outputs=[name], t_end=10.0)
    thread.join()
    result = caught.value.result  # type: ignore[attr-defined]
    assert 0 < len(result) < 10_000 and not result.is_whole
    case = result["case"]
    assert np.array_equal(result["l1"], LARGE["l1"][case // 100])
    assert np.count_nonzero(~np.isnan(result.grid(name))) == len(result)
    axes = {of: [float(result[of][-1])] for of in LARGE}
    alone = bksim.sweep(crank, axes, outputs=[name], t_end=10.0)
    assert alone[name][0] == result[name][-1]


def interrupted(crank: bksim.Model) -> float:
    """Seconds from Ctrl-C to the end of a long sweep."""
    sent: list[float] = []

    def condition() -> bool:
        time.sleep(0.5)
        sent.append(time.perf_counter())
        return True

    thread = interrupt_after(condition)
    with pytest.raises(KeyboardInterrupt):
        bksim.sweep(crank, {"l1": np.linspace(0.8, 1.2, 8)}, t_end=LONG, every=1.0)
    taken = time.perf_counter() - sent[0]
    thread.join()
    return taken


def test_ctrl_c_ends_a_sweep_within_a_fifth_of_a_second(crank: bksim.Model) -> None:
    # A busy machine may keep a process waiting for longer: once is enough to show that it works.
    taken = (interrupted(crank) for _ in range(5))
    assert any(seconds < 0.2 for seconds in taken)


def test_other_threads_run_while_a_sweep_does(crank: bksim.Model) -> None:
    counts = 0
    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(sampled, crank)
        while not future.done():
            counts += 1
            time.sleep(0.001)
        future.result()
    assert counts > 20


def test_the_number_of_threads_changes_nothing(crank: bksim.Model) -> None:
    one, many = sampled(crank, jobs=1), sampled(crank, jobs=3)
    assert np.array_equal(one["max(energy.kinetic)"], many["max(energy.kinetic)"])


def test_progress_hears_of_cases(crank: bksim.Model) -> None:
    pytest.importorskip("tqdm")
    assert len(sampled(crank, progress=True)) == 1600


def test_what_is_sent_is_the_text_of_the_model(crank: bksim.Model) -> None:
    asked = _asked(crank, AXES, "grid")
    assert len(pickle.dumps(asked)) < len(crank.text.encode()) + 2000
    assert not any("bksim" in type(value).__module__ for value in asked.values())


def test_an_executor_gives_the_same_rows_and_bytes(crank: bksim.Model, tmp_path: Path) -> None:
    here = sampled(crank, out=tmp_path / "here.parquet")
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn) as pool:
        there = sampled(crank, executor=pool, out=tmp_path / "there.parquet")
        kept = sampled(crank, executor=pool)
    assert here.path is not None and there.path is not None
    assert here.path.read_bytes() == there.path.read_bytes()
    assert not there.path.with_name("there.parquet.parts").exists()
    for name in kept.names:
        assert np.array_equal(kept[name], here[name]), name


class Failing(Executor):
    """Takes some tasks, then loses its workers."""

    def __init__(self, n: int) -> None:
        self.n = n

    def submit(self, fn: Any, /, *args: Any, **how: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self.n -= 1
        if self.n < 0:
            future.set_exception(ConnectionError("the workers are gone"))
        else:
            future.set_result(fn(*args, **how))
        return future


def test_what_a_broken_executor_has_done_is_kept(crank: bksim.Model, tmp_path: Path) -> None:
    path = tmp_path / "s.parquet"
    with pytest.raises(ConnectionError):
        sampled(crank, executor=Failing(5), out=path)
    parts = list((tmp_path / "s.parquet.parts").glob("*.parquet"))
    assert 1 <= len(parts) < 100
    sampled(crank, out=path, resume=True)
    whole = sampled(crank, out=tmp_path / "whole.parquet")
    assert whole.path is not None and path.read_bytes() == whole.path.read_bytes()


def test_an_interrupt_while_an_executor_works_keeps_what_has_arrived(
    crank: bksim.Model, tmp_path: Path
) -> None:
    path = tmp_path / "s.parquet"
    parts = tmp_path / "s.parquet.parts"
    thread = interrupt_after(lambda: len(list(parts.glob("*.parquet"))) >= 2)
    with ThreadPoolExecutor(2) as pool, pytest.raises(KeyboardInterrupt, match="resume=True"):
        sampled(crank, executor=pool, out=path)
    thread.join()
    assert 2 <= len(list(parts.glob("*.parquet"))) < 100
    sampled(crank, out=path, resume=True)
    assert path.exists()


def test_a_sweep_into_a_file_takes_no_more_memory_for_more_cases(tmp_path: Path) -> None:
    script = """
import resource, sys
import bksim, numpy as np
m = bksim.loads('''
[parameters]
l = "1 m"
[bodies.bob]
mass = 1
com = [0, "-l"]
[joints.A]
type = "revolute"
between = ["ground", "bob"]
[initial]
A = { angle = 1 }
[loads.gravity]
type = "gravity"
acceleration = [0, -9.81]
[solve]
t_end = 1e-3
''')
def peak(n):
    how = dict(outputs=["final(state.A_angle)"], overwrite=True, out=sys.argv[1])
    assert len(bksim.sweep(m, {"l": (1, 2)}, design="random", n=n, **how)) == n
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
before = peak(16384)
print(peak(131072) - before)
"""
    command = [sys.executable, "-c", script, str(tmp_path / "s.parquet")]
    grown_mb = float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    # In memory, the rows of the larger one take 5 MB as arrays alone, and several times as much as
    # objects.
    assert grown_mb < 4, f"{grown_mb} MB"
