"""The equations of a mechanism, to be read and to be taken elsewhere."""

from __future__ import annotations

import json
import keyword
import re
from functools import cached_property
from typing import Any

from . import _bksim
from ._words import Form


class Equations:
    """T, V, Lagrange's equations with multipliers, and the constraints.

    ``print(m.equations)`` shows them as text; a notebook typesets them.
    """

    def __init__(self, engine: _bksim.Engine, *, _absolute: bool = False) -> None:
        self._engine = engine
        self._is_absolute = _absolute

    @property
    def in_absolute_angles(self) -> Equations:
        """These equations in the angles of the bodies against the ground, not those of the joints: in
        the plane. Raises ValueError where a body bends, and in space.
        """
        return Equations(self._engine, _absolute=True)

    @cached_property
    def _body(self) -> dict[str, Any]:
        body: dict[str, Any] = json.loads(self._engine.equations_json(self._is_absolute))
        return body

    @property
    def kinetic_energy(self) -> str:
        """T, J."""
        return str(self._body["kinetic_energy"])

    @property
    def potential_energy(self) -> str:
        """V, J."""
        return str(self._body["potential_energy"])

    @property
    def equations(self) -> tuple[str, ...]:
        """One left side per coordinate, each equal to zero, N or N m."""
        return tuple(self._body["equations"])

    @property
    def constraints(self) -> tuple[str, ...]:
        """One left side per multiplier, each equal to zero, m or rad."""
        return tuple(self._body["constraints"])

    @property
    def operations(self) -> dict[str, Any]:
        """How many operations they take, as derived and as simplified."""
        return dict(self._body["operations"])

    @property
    def certificate(self) -> dict[str, Any]:
        """How they were compared with equations derived from T and V in another way."""
        return dict(self._body["certificate"])

    def written(
        self,
        notation: Form = "text",
        *,
        document: bool = False,
        groups: bool = True,
        steps: bool = False,
        levels: bool = False,
        free_bodies: bool = False,
        effort: bool = False,
    ) -> str:
        """The formulas as ``text``, ``aligned``, ``latex``, ``typst`` or ``mathml``; ``document``
        makes a whole document, ``groups`` names constants that take more than one operation.

        ``steps`` adds the derivation step by step, ``levels`` the velocity and acceleration equations
        of the constraints, with the numbers of the start, ``free_bodies`` the balances of each body
        that is cut free, ``effort`` that of the only drive in explicit form. Raises ValueError where
        the mechanism has no such part.
        """
        asked = {"steps": steps, "levels": levels, "free_bodies": free_bodies, "effort": effort}
        parts = [name for name, is_asked in asked.items() if is_asked]
        return self._engine.equations_in(notation, document, groups, self._is_absolute, parts)

    @property
    def text(self) -> str:
        """The formulas as text."""
        return self.written("text")

    @property
    def latex(self) -> str:
        """The formulas as LaTeX."""
        return self.written("latex")

    @property
    def mathml(self) -> str:
        """The formulas as MathML."""
        return self.written("mathml")

    def __str__(self) -> str:
        return self.written("aligned")

    def __repr__(self) -> str:
        n, m = len(self.equations), len(self.constraints)
        return f"<bksim.Equations of {self._engine.name!r}: {n} equations, {m} constraints>"

    def _repr_latex_(self) -> str:
        kinetic, potential, equations, constraints = self._engine.latex(self._is_absolute)
        lines = [f"T &= {kinetic}", f"V &= {potential}"]
        lines += [f"{left} &= 0" for left in (*equations, *constraints)]
        return "$$\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}$$"

    def to_sympy(self) -> dict[str, Any]:
        """The same as SymPy expressions: ``kinetic_energy``, ``potential_energy``, and lists
        ``equations`` and ``constraints``. Raises ImportError unless SymPy is installed.

        Symbols have the names of the text: ``theta``, ``theta_dot``, ``theta_ddot``.
        """
        import sympy
        from sympy.parsing.sympy_parser import convert_xor, parse_expr, standard_transformations

        names = [*self._body["parameters"], "t", *(m["name"] for m in self._body["multipliers"])]
        for c in self._body["coordinates"]:
            names += [c["value"], c["velocity"], c["acceleration"]]
        known = {name: sympy.Symbol(name, real=True) for name in names}
        known |= {"sign": sympy.sign, "abs": sympy.Abs, "pi": sympy.pi}
        known |= {"min": sympy.Min, "max": sympy.Max}
        relations = {"lt": sympy.Lt, "le": sympy.Le, "gt": sympy.Gt, "ge": sympy.Ge}

        def branch(condition: Any, then: Any, otherwise: Any) -> Any:
            if not isinstance(condition, sympy.logic.boolalg.Boolean):
                condition = sympy.Ne(condition, 0)
            return sympy.Piecewise((then, condition), (otherwise, True))

        known |= {"if": branch, **relations}
        # Names that Python keeps for itself stand for others while it reads.
        kept = {name: f"_{name}_" for name in known if keyword.iskeyword(name)}
        known |= {other: known[name] for name, other in kept.items()}

        def parsed(text: str) -> Any:
            for name, other in kept.items():
                text = re.sub(rf"\b{name}\b", other, text)
            rules = (*standard_transformations, convert_xor)
            return parse_expr(text, local_dict=known, transformations=rules)

        return {
            "kinetic_energy": parsed(self.kinetic_energy),
            "potential_energy": parsed(self.potential_energy),
            "equations": [parsed(text) for text in self.equations],
            "constraints": [parsed(text) for text in self.constraints],
        }
