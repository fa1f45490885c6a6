"""Evaluations that `bksim.optimize` and SciPy's SLSQP take for the designs of the documentation.

    python crates/bench/python/optimizers.py

Both begin in the middles of the ranges and see the same numbers: SLSQP evaluates the objective and the conditions by sweeps of one
case, and takes differences for slopes, as it does by itself. Every evaluation of the mechanism counts.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import bksim
import numpy as np
from scipy.optimize import Bounds, minimize

DOCS = Path(__file__).parents[3] / "docs"


def models() -> dict[str, str]:
    """The models of the pages that ask for an optimum over a motion, by the names of their files."""
    found = {}
    for page in ("design.md", "tasks/six-designs.md"):
        for text in re.findall(r"```toml\n(.*?)```", (DOCS / page).read_text("utf-8"), re.S):
            wish = tomllib.loads(text).get("optimize", {})
            is_plain = not {"over", "cases", "choose"} & wish.keys()
            if isinstance(wish.get("minimize"), str) and is_plain:
                found[text.split()[1]] = text
    return found


def sides(condition: str) -> str:
    """What of a condition is not to be below zero."""
    left, sign, right = re.split("(<=|>=)", condition)
    return f"({right}) - ({left})" if sign == "<=" else f"({left}) - ({right})"


class Problem:
    """The functions of a model's question over the unit cube, each evaluation counted."""

    def __init__(self, text: str, name: str) -> None:
        wish = tomllib.loads(text)["optimize"]
        self.model = bksim.loads(text, name=name)
        self.names = list(wish["vary"])
        self.outputs = [wish["minimize"], *map(sides, wish.get("subject_to", []))]
        ends = [self.ends(name, [str(end) for end in wish["vary"][name]]) for name in self.names]
        self.low, self.high = np.array(ends).T
        self.start = np.full(len(self.names), 0.5)
        self.known: dict[bytes, np.ndarray] = {}
        self.n = 0

    def ends(self, name: str, values: list[str]) -> list[float]:
        """Both ends of a range in SI units."""
        cases = [
            bksim.sweep(self.model, {name: [value]}, outputs=[name], progress=False)
            for value in values
        ]
        return [float(case[name][0]) for case in cases]

    def at(self, x: np.ndarray) -> np.ndarray:
        key = np.asarray(x).tobytes()
        if key not in self.known:
            self.n += 1
            point = self.low + np.asarray(x) * (self.high - self.low)
            axes = {name: [value] for name, value in zip(self.names, point, strict=True)}
            found = bksim.sweep(
                self.model, axes, outputs=self.outputs, rtol=1e-10, atol=1e-12, progress=False
            )
            self.known[key] = np.array([found[name][0] for name in self.outputs])
        return self.known[key]


def main() -> None:
    print("| design | varies | program | evaluations | objective |\n| --- | --- | --- | --- | --- |")
    for name, text in models().items():
        problem = Problem(text, Path(name).stem)
        size = abs(problem.at(problem.start)[0]) or 1.0
        problem.n, problem.known = 0, {}
        conditions = [
            {"type": "ineq", "fun": lambda x, k=k: problem.at(x)[k]}
            for k in range(1, len(problem.outputs))
        ]
        found = minimize(
            lambda x: problem.at(x)[0] / size,
            problem.start,
            method="SLSQP",
            bounds=Bounds(0, 1),
            constraints=conditions,
            options={"ftol": 1e-12, "maxiter": 200},
        )
        n = len(problem.names)
        middle = 0.5 * (problem.low + problem.high)
        values = ", ".join(f"{name} = {x!r}" for name, x in zip(problem.names, map(float, middle)))
        asked = text.replace("starts =", "# starts =")
        alone = bksim.optimize(asked.replace("[optimize]", f"[optimize]\nfrom = [{{ {values} }}]"))
        print(f"| {name} | {n} | bksim | {alone['evaluations']} | {alone['after']:.9g} |")
        print(f"| | | SLSQP | {problem.n} | {size * found.fun:.9g} |", flush=True)


if __name__ == "__main__":
    main()
