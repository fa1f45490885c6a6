"""Words that options take, for editors and type checkers."""

from __future__ import annotations

from typing import Literal, TypeAlias

Jit: TypeAlias = Literal["auto", "on", "off"]
Method: TypeAlias = Literal["auto", "radau", "explicit"]
Formulation: TypeAlias = Literal["ggl", "index2", "index3", "index1"]
Design: TypeAlias = Literal["grid", "pairs", "random", "latin-hypercube", "sobol"]
Notation: TypeAlias = Literal["text", "unicode", "latex", "typst", "mathml"]
Form: TypeAlias = Literal["text", "aligned", "latex", "typst", "mathml"]
