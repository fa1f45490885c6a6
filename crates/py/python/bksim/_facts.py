"""The parts of a model, and its start."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from ._errors import Diagnostic, diagnostics_of
from ._html import table
from ._said import said


@dataclass(frozen=True)
class Check:
    """Parts, coordinates and mobility of a mechanism."""

    model: str
    space: str
    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    loads: tuple[str, ...]
    drives: tuple[str, ...]
    coordinates: tuple[str, ...]
    coordinate_policy: str
    cut_joints: tuple[str, ...]
    constraints: int
    rank: int
    gruebler: int
    mobility: int
    redundant_joints: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]

    @classmethod
    def _of(cls, body: dict[str, Any]) -> Check:
        body["diagnostics"] = diagnostics_of(json.dumps(body["diagnostics"]))
        names = cls.__dataclass_fields__
        plain: dict[str, Any] = {key: value for key, value in body.items() if key in names}
        of_lists: dict[str, Any] = {k: tuple(v) for k, v in plain.items() if isinstance(v, list)}
        return cls(**(plain | of_lists))

    def _rows(self) -> list[list[str]]:
        def counted(what: str, names: tuple[str, ...]) -> list[str]:
            return [said(what), str(len(names)), " ".join(names)]

        rows = [
            counted("bodies", self.bodies),
            counted("joints", self.joints),
            counted("loads", self.loads),
            counted("drives", self.drives),
            counted("coordinates", self.coordinates),
            counted("cut joints", self.cut_joints),
            [said("constraints"), str(self.constraints), said(f"{self.rank} independent")],
            [said("Grübler count"), str(self.gruebler), ""],
            [said("true mobility"), str(self.mobility), ""],
            counted("redundant joints", self.redundant_joints),
        ]
        return rows + [[said("warning"), fault.code, fault.message] for fault in self.diagnostics]

    def __str__(self) -> str:
        rows = self._rows()
        widths = [max(len(row[k]) for row in rows) for k in range(2)]
        lines = (f"  {a:<{widths[0]}}  {b:>{widths[1]}}  {c}".rstrip() for a, b, c in rows)
        return "\n".join([self.model, *lines])

    def _repr_html_(self) -> str:
        return f"<b>{self.model}</b>" + table([], self._rows())


@dataclass(frozen=True)
class Start:
    """A consistent start: the constraints hold at position, velocity and acceleration level.

    ``q``, ``v``, ``a`` and ``lam`` are values by name, in SI; ``initial`` tells of each stated or
    guessed value what was given, what was found and how far it was moved.
    """

    model: str
    t: float
    q: dict[str, float]
    v: dict[str, float]
    a: dict[str, float]
    lam: dict[str, float]
    initial: tuple[dict[str, Any], ...]
    position_residual: float
    velocity_residual: float
    mobility: int

    @classmethod
    def _of(cls, body: dict[str, Any]) -> Start:
        return cls(
            model=body["model"],
            t=body["t"],
            q=body["q"],
            v=body["v"],
            a=body["a"],
            lam=body["lambda"],
            initial=tuple(body["initial"]),
            position_residual=body["residual"]["position"],
            velocity_residual=body["residual"]["velocity"],
            mobility=body["mobility"],
        )

    def _repr_html_(self) -> str:
        rows = [
            [name, f"{q:.9g}", f"{v:.9g}", f"{a:.9g}"]
            for name, q, v, a in zip(
                self.q, self.q.values(), self.v.values(), self.a.values(), strict=True
            )
        ]
        return table(["coordinate", "value", "velocity", "acceleration"], rows)
