"""Runs that end early, threads, memory."""

from __future__ import annotations

import gc
import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import bksim
from bksim import _bksim

FREE = """
[bodies.block]
mass = "2 kg"
[joints.S]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
"""
"""Uniform motion, which takes few steps."""
LONG = 1e6
"""Seconds of motion that nobody waits for."""


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


@pytest.fixture
def crank(examples: Path) -> bksim.Model:
    return bksim.load(examples / "slider-crank" / "model.toml")


def blocked() -> bksim.Model:
    """A force that holds against both ways of a slide: it has no motion beyond the switch."""
    return bksim.load("""
[bodies.block]
mass = 1
[joints.S]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[loads.rub]
type = "force"
on = "block"
vector = ["-5 N*sign(S.velocity)", 0]
[initial]
S = { position = 0, velocity = 1 }
[solve]
t_end = 1
""")


def test_a_run_that_cannot_go_on_says_where_and_keeps_what_there_is() -> None:
    m = blocked()
    with pytest.raises(bksim.SolverError) as caught:
        m.solve()
    error = caught.value
    assert 0.19 < error.t < 0.21 and error.reason and error.diagnostics[0].code == "R006"
    assert error.result.t[-1] == error.t and not error.result.success
    # Before it, all is well, and the failure leaves nothing behind.
    arrays = [m.solve(t_end=0.1).q for _ in range(3)]
    assert np.array_equal(arrays[0], arrays[1]) and np.array_equal(arrays[0], arrays[2])


def test_a_solver_used_three_times_gives_the_same_arrays(crank: bksim.Model) -> None:
    first, second, third = (crank.solve(t_end=0.5)._table for _ in range(3))
    assert np.array_equal(first, second) and np.array_equal(first, third)


def interrupted(crank: bksim.Model) -> tuple[float, bksim.Solution]:
    """Seconds from Ctrl-C to the end of a long run, and what there was."""
    sent: list[float] = []

    def interrupt() -> None:
        time.sleep(0.4)
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        crank.solve(t_end=LONG, every=1.0)
    taken = time.perf_counter() - sent[0]
    thread.join()
    return taken, caught.value.result  # type: ignore[attr-defined]


def test_ctrl_c_ends_a_run_within_a_fifth_of_a_second(crank: bksim.Model) -> None:
    # A busy machine may keep a process waiting for longer: once is enough to show that it works.
    taken = []
    for _ in range(5):
        seconds, result = interrupted(crank)
        assert result.t[-1] > 0 and not result.success
        taken.append(seconds)
        if seconds < 0.2:
            return
    pytest.fail(f"{taken} s")


def test_other_threads_run_while_a_run_does(crank: bksim.Model) -> None:
    counts = 0
    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(crank.solve, t_end=100.0, every=0.05)
        while not future.done():
            counts += 1
            time.sleep(0.001)
        future.result()
    assert counts > 20


def test_eight_threads_solve_at_once(crank: bksim.Model) -> None:
    expected = crank.solve(t_end=1.0)._table
    with ThreadPoolExecutor(8) as pool:
        solutions = list(pool.map(lambda _: crank.solve(t_end=1.0), range(16)))
    assert all(np.array_equal(s._table, expected) for s in solutions)


def test_a_thousand_solves_leave_no_memory_behind(crank: bksim.Model) -> None:
    def solve(n: int) -> None:
        for _ in range(n):
            crank.solve(t_end=0.1)(0.05)
        gc.collect()

    # The allocator may keep what it got once, as after other tests; a leak grows in every round.
    solve(100)
    grown = []
    for _ in range(3):
        before = resident_bytes()
        solve(1000)
        grown.append(resident_bytes() - before)
    assert min(grown) < 5e6, f"{[size / 1e6 for size in grown]} MB"


def test_memory_has_a_limit(crank: bksim.Model) -> None:
    with pytest.raises(bksim.LimitError, match="memory_limit") as caught:
        crank.solve(t_end=LONG, every=100.0, memory_limit=10_000_000)
    result = caught.value.result
    assert result is not None and 0 < result.t[-1] < LONG
    # Where samples alone are too many, nothing is begun.
    with pytest.raises(bksim.LimitError, match="memory_limit") as caught:
        crank.solve(t_end=LONG, every=1e-9, memory_limit=10_000_000)
    assert caught.value.result is None


def test_ctrl_c_is_heard_within_a_step_of_many_samples() -> None:
    m = bksim.loads(FREE)
    thread = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    thread.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt) as caught:
        m.solve(t_end=1000, every=1e-4, dense=False)
    assert time.monotonic() - begun < 2
    assert 0 < len(caught.value.result) < 10_000_000


def test_a_panic_is_an_internal_error() -> None:
    with pytest.raises(bksim.InternalError, match="a fault"):
        _bksim._panic("a fault")
    assert issubclass(bksim.InternalError, Exception)


def test_progress_hears_the_time(crank: bksim.Model) -> None:
    tqdm = pytest.importorskip("tqdm")
    assert tqdm
    solution = crank.solve(t_end=30.0, progress=True)
    assert solution.success


def test_what_notify_raises_ends_the_run(crank: bksim.Model) -> None:
    class Enough(Exception):
        pass

    def alarm(_signal: int, _frame: object) -> None:
        raise Enough

    before = signal.signal(signal.SIGALRM, alarm)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(Enough) as caught:
            crank.solve(t_end=LONG, every=1.0)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert len(caught.value.result) > 1  # type: ignore[attr-defined]


def test_a_fault_at_the_first_sample_names_its_instant() -> None:
    model = bksim.loads(FREE + '[outputs]\nratio = "1/(S.position/(1 m))"\n[solve]\nt_start = 2\nt_end = 3\n')
    with pytest.raises(bksim.SolverError, match="ratio") as caught:
        model.solve()
    assert caught.value.t == 2
