"""A sweep of 10 000 slider-cranks from Python, beside single solves and beside Exudyn.

    python crates/bench/python/sweep.py [--cases 100x100] [--peer-cases 20x20] [--jobs 2] [--rounds 3]

The interpreter needs `bksim`, and for the comparison `exudyn`. CPU times are of one thread and one
process; the wall times of all cores mean something on an idle machine alone, so the load is printed.
Errors are of the crank's angle at the end of the run, against bksim at rtol 1e-12.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from statistics import median

import bksim
import numpy as np

MODEL = Path(__file__).parents[3] / "examples/slider-crank/model.toml"
INERTIA = 2.0
"""Of the crank about its pin, kg m²: that of the example leaves less than none about its centre, which
other programs need not take."""
T_END = 0.5
OUTPUT = "final(state.theta1)"
# The numbers of the example.
G, M1, M2, M3, I2, S1, S2 = 9.8, 5.0, 5.0, 20.0, 1.0, 0.5, 1.5
STEPS = (1e-2, 1e-3)
"""Step sizes of the peer, s."""


def axes(n_l1: int, n_q1: int) -> dict[str, np.ndarray]:
    return {"l1": np.linspace(0.8, 1.2, n_l1), "q1": np.linspace(40, 60, n_q1)}


def cpu(work) -> tuple[float, object]:
    begun = time.process_time()
    result = work()
    return time.process_time() - begun, result


def wall(work) -> float:
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def exudyn_case(parameters: dict[str, float]) -> float:
    """The angle of the crank in the end, by generalised alpha with steps of `parameters["h"]`."""
    import exudyn

    l1, q1, h = parameters["l1"], parameters["q1"], parameters["h"]
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject({"objectType": "Ground", "referencePosition": [0, 0, 0]})

    def marker(body: int, x: float) -> int:
        at = {"bodyNumber": body, "localPosition": [x, 0, 0]}
        return system.AddMarker({"markerType": "BodyRigid", **at})

    def bar(mass: float, inertia: float, x: float) -> tuple[int, int]:
        still = {"initialCoordinates": [0, 0, 0], "initialVelocities": [0, 0, 0]}
        place = {"referenceCoordinates": [x, 0, 0]}
        node = system.AddNode({"nodeType": "RigidBody2D", **place, **still})
        about = {"mass": mass, "inertia": inertia, "nodeNumber": node}
        body = system.AddObject({"objectType": "RigidBody2D", **about})
        weight = {"markerNumber": marker(body, 0), "loadVector": [0, -G * mass, 0]}
        system.AddLoad({"loadType": "ForceVector", **weight})
        return node, body

    def pin(first: int, second: int) -> None:
        system.AddObject({"objectType": "JointRevolute2D", "markerNumbers": [first, second]})

    crank_node, crank = bar(M1, INERTIA - M1 * S1**2, S1)
    _, rod = bar(M2, I2, l1 + S2)
    still = {"initialCoordinates": [0, 0], "initialVelocities": [0, 0]}
    place = {"referenceCoordinates": [l1 + 2 * S2, 0]}
    slider = system.AddNode({"nodeType": "Point2D", **place, **still})
    mass = system.AddObject({"objectType": "MassPoint2D", "mass": M3, "nodeNumber": slider})
    centre = {"bodyNumber": mass, "localPosition": [0, 0, 0]}
    point = system.AddMarker({"markerType": "BodyPosition", **centre})
    fixed = system.AddNode({"nodeType": "PointGround", "referenceCoordinates": [0, 0, 0]})
    heights = [
        system.AddMarker({"markerType": "NodeCoordinate", "nodeNumber": node, "coordinate": 1})
        for node in (fixed, slider)
    ]
    system.AddObject({"objectType": "ConnectorCoordinate", "markerNumbers": heights})
    pin(marker(ground, 0), marker(crank, -S1))
    pin(marker(crank, l1 - S1), marker(rod, -S2))
    pin(marker(rod, S2), point)
    torque = {"markerNumber": marker(crank, 0), "loadVector": [0, 0, q1]}
    system.AddLoad({"loadType": "TorqueVector", **torque})
    system.Assemble()

    settings = exudyn.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime, integration.numberOfSteps = T_END, round(T_END / h)
    integration.verboseMode = 0
    # At least as fast as the default here.
    integration.newton.useModifiedNewton = False
    settings.solution.file.write = False
    system.SolveDynamic(settings)
    return float(system.GetNodeOutput(crank_node, exudyn.OutputVariableType.Coordinates)[2])


def exudyn_sweep(n_l1: int, n_q1: int, h: float, jobs: int) -> np.ndarray:
    from exudyn.processing import ParameterVariation

    grid = {"l1": (0.8, 1.2, n_l1), "q1": (40.0, 60.0, n_q1), "h": (h, h, 1)}
    how = {"useMultiProcessing": jobs > 1, "numberOfThreads": jobs, "showProgress": False}
    given, values = ParameterVariation(exudyn_case, grid, **how)
    order = np.lexsort([given["q1"], given["l1"]])
    return np.asarray(values)[order]


def main() -> None:
    sizes = lambda text: tuple(int(n) for n in text.split("x"))  # noqa: E731
    options = argparse.ArgumentParser()
    options.add_argument("--cases", type=sizes, default=(100, 100))
    options.add_argument("--peer-cases", type=sizes, default=(20, 20))
    options.add_argument("--jobs", type=int, default=os.cpu_count())
    options.add_argument("--rounds", type=int, default=3)
    options = options.parse_args()
    n, n_peer = np.prod(options.cases), np.prod(options.peer_cases)

    model = bksim.load(MODEL, set={"i1": INERTIA})
    how = {"outputs": [OUTPUT], "t_end": T_END}
    sweep = lambda **more: bksim.sweep(model, axes(*options.cases), **how, **more)  # noqa: E731
    solve = lambda: model.solve(T_END, dense=False)  # noqa: E731

    def resolve() -> None:
        for l1 in np.linspace(0.8, 1.2, 20):
            model.parameters["l1"] = l1
            solve()
        del model.parameters["l1"]

    solve()
    fine = {"rtol": 1e-12, "atol": 1e-13}
    exact = bksim.sweep(model, axes(*options.peer_cases), **how, **fine)[OUTPUT]
    ours = bksim.sweep(model, axes(*options.peer_cases), **how)[OUTPUT]
    rows: dict[str, list[float]] = {}
    walls: dict[str, list[float]] = {}
    errors = {"bksim.sweep": np.abs(ours - exact).max()}
    for _ in range(options.rounds):
        def note(what: str, seconds: float) -> None:
            rows.setdefault(what, []).append(seconds)

        note("Model.solve, derived before", cpu(lambda: [solve() for _ in range(200)])[0] / 200)
        note("Model.solve, another length each", cpu(resolve)[0] / 20)
        note("bksim.sweep", cpu(lambda: sweep(jobs=1))[0] / n)
        walls.setdefault("bksim.sweep", []).append(wall(lambda: sweep(jobs=options.jobs)) / n)
        try:
            import exudyn
        except ImportError:
            print("exudyn is missing")
            continue
        for h in STEPS:
            name = f"Exudyn {exudyn.__version__}, steps of {h:g} s"
            seconds, found = cpu(lambda: exudyn_sweep(*options.peer_cases, h, 1))
            note(name, seconds / n_peer)
            errors[name] = np.abs(found - exact).max()
            taken = wall(lambda: exudyn_sweep(*options.peer_cases, h, options.jobs))
            walls.setdefault(name, []).append(taken / n_peer)

    own = rows["bksim.sweep"]
    print(f"{n} cases, {n_peer} of Exudyn, {options.rounds} rounds, {options.jobs} jobs")
    print(f"load of {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print("| per case | CPU time | beside the sweep | wall time, all jobs | error, rad |")
    print("|---|---:|---:|---:|---:|")
    for name, seconds in rows.items():
        beside = median(a / b for a, b in zip(seconds, own))
        all_jobs = f"{1e3 * median(walls[name]):.3f} ms" if name in walls else ""
        error = f"{errors[name]:.1e}" if name in errors else ""
        print(f"| {name} | {1e3 * median(seconds):.3f} ms | {beside:.2f} | {all_jobs} | {error} |")


if __name__ == "__main__":
    main()
