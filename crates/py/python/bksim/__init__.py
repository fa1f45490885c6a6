"""Mechanisms to equations a person can read, and to motion they can trust.

>>> import bksim
>>> m = bksim.load(EXAMPLES / "slider-crank" / "model.toml")
>>> sol = m.solve(t_end=1)
>>> sol["crank.angle"].shape == sol.t.shape
True
"""

from . import expr
from ._bksim import __version__, explain
from ._equations import Equations
from ._errors import (
    AssemblyError,
    Diagnostic,
    Error,
    InternalError,
    Label,
    LimitError,
    LogError,
    ModelError,
    SolverError,
)
from ._functions import Functions
from ._model import Model, load, loads
from ._parts import (
    Body,
    Damper,
    Drive,
    Force,
    Friction,
    Gravity,
    Ground,
    Joint,
    Link,
    Load,
    Prismatic,
    Revolute,
    Slot,
    Spring,
    Stop,
    Torque,
    Torsion,
    Weld,
)
from ._report import Check, Start
from ._show import Animation, Picture, Plot
from ._solution import Samples, Solution, open
from ._sampled import Sampled
from ._stepping import SavedState, Stepping
from ._sweep import Failure, Sweep, sweep
from ._values import Inputs, Parameters

__all__ = [
    "Animation",
    "AssemblyError",
    "Body",
    "Check",
    "Damper",
    "Diagnostic",
    "Drive",
    "Equations",
    "Error",
    "Failure",
    "Force",
    "Friction",
    "Functions",
    "Gravity",
    "Ground",
    "Inputs",
    "InternalError",
    "Joint",
    "Label",
    "LimitError",
    "Link",
    "Load",
    "LogError",
    "Model",
    "ModelError",
    "Parameters",
    "Picture",
    "Plot",
    "Prismatic",
    "Revolute",
    "Sampled",
    "Samples",
    "SavedState",
    "Slot",
    "Solution",
    "SolverError",
    "Spring",
    "Start",
    "Stepping",
    "Stop",
    "Sweep",
    "Torque",
    "Torsion",
    "Weld",
    "__version__",
    "explain",
    "expr",
    "load",
    "loads",
    "open",
    "sweep",
]
