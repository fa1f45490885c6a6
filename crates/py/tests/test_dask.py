"""Sweeps on a cluster: worker processes of Dask, one of which is killed."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bksim

distributed = pytest.importorskip("distributed")
# Its own deprecations, and sockets that a killed worker leaves open.
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with (
        distributed.LocalCluster(
            n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.fixture
def crank(examples: Path) -> bksim.Model:
    return bksim.load(examples / "slider-crank" / "model.toml")


def sampled(model: bksim.Model, n: int = 1024, **how: Any) -> bksim.Sweep:
    axes = {"l1": (0.8, 1.2), "m2": (-0.5, 6)}
    outputs = ["max(energy.kinetic)", "final(x3)"]
    return bksim.sweep(model, axes, design="sobol", n=n, outputs=outputs, t_end=1.0, **how)


def test_a_cluster_gives_the_same_rows(crank: bksim.Model, client: Any) -> None:
    here, there = sampled(crank), sampled(crank, executor=client)
    for name in here.names:
        a, b = here[name], there[name]
        assert np.array_equal(a, b, equal_nan=a.dtype == np.float64), name
    assert here.failures == there.failures and here.failures


def test_a_cluster_returns_solutions(crank: bksim.Model, client: Any) -> None:
    there = client.submit(lambda m: m.solve(t_end=0.2), crank).result()
    here = crank.solve(t_end=0.2)
    assert np.array_equal(there.q, here.q) and there.summary == here.summary


def interrupted(crank: bksim.Model, client: Any, path: Path) -> bool:
    """Whether a sweep was ended by Ctrl-C, sent when ten parts had arrived."""
    parts = path.with_name(f"{path.name}.parts")
    is_over = threading.Event()

    def interrupt() -> None:
        while not is_over.is_set():
            if len(list(parts.glob("*.parquet"))) >= 10:
                os.kill(os.getpid(), signal.SIGINT)
                return
            time.sleep(0.005)

    thread = threading.Thread(target=interrupt)
    thread.start()
    try:
        sampled(crank, 8192, executor=client, out=path)
    except KeyboardInterrupt as interrupt_:
        assert "resume=True" in str(interrupt_)
        assert len(list(parts.glob("*.parquet"))) >= 10
        return True
    finally:
        is_over.set()
        thread.join()
    return False


def test_ctrl_c_keeps_what_has_arrived_and_leaves_the_cluster_as_it_was(
    crank: bksim.Model, client: Any, tmp_path: Path
) -> None:
    here = sampled(crank, 8192, out=tmp_path / "here.parquet")
    # Python drops what is raised in a finaliser, and Dask has some: one of a few tries is enough.
    paths = (tmp_path / f"there{k}.parquet" for k in range(5))
    path = next((path for path in paths if interrupted(crank, client, path)), None)
    assert path is not None
    there = sampled(crank, 8192, executor=client, out=path, resume=True)
    assert there.path is not None and here.path is not None
    assert there.path.read_bytes() == here.path.read_bytes()


def test_a_worker_that_is_killed_half_way_loses_nothing(
    crank: bksim.Model, client: Any, tmp_path: Path
) -> None:
    here = sampled(crank, 8192, out=tmp_path / "here.parquet")
    parts = tmp_path / "there.parquet.parts"
    pids = client.run(os.getpid)
    assert len(set(pids.values())) == 3 and os.getpid() not in pids.values()
    victim = next(iter(pids.values()))
    seen: list[int] = []
    is_over = threading.Event()

    def kill() -> None:
        while (n_parts := len(list(parts.glob("*.parquet")))) < 40 and not is_over.is_set():
            time.sleep(0.005)
        os.kill(victim, signal.SIGKILL)
        seen.append(n_parts)

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        there = sampled(crank, 8192, executor=client, out=tmp_path / "there.parquet")
    finally:
        is_over.set()
        killer.join()
    assert 40 <= seen[0] < 128, "it was killed half way"
    assert here.path is not None and there.path is not None
    assert there.path.read_bytes() == here.path.read_bytes()
    assert len(there) == 8192 and not parts.exists()
    assert victim not in client.run(os.getpid).values()
