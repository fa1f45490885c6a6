"""Mechanisms to equations a person can read, and to motion they can trust.

>>> import bksim
>>> m = bksim.example("slider-crank")
>>> sol = m.solve(t_end=1)
>>> sol["crank.angle"].shape == sol.t.shape
True
"""

from . import expr
from ._bksim import __version__, explain
from ._design import Design, fit, optimize, synthesize, tolerance
from ._ended import LimitError, SolverError
from ._equations import Equations
from ._errors import (
    AssemblyError,
    Diagnostic,
    Error,
    InputWarning,
    InternalError,
    Label,
    LogError,
    ModelError,
    WorthWarning,
)
from ._facts import Check, Start
from ._functions import Functions
from ._load import example, import_model, load, loads
from ._model import Model
from ._joints import (
    ConstantVelocity,
    CurveOnCurve,
    Cylinder,
    Cylindrical,
    Distance,
    Free,
    Joint,
    KnifeEdge,
    LineOnCurve,
    Link,
    ParallelAxes,
    PerpendicularAxes,
    Planar,
    PointOnCurve,
    PointOnLine,
    PointOnPlane,
    Prismatic,
    Revolute,
    Rolling,
    Screw,
    Slot,
    Spherical,
    Universal,
    Weld,
)
from ._parts import (
    Body,
    Damper,
    Drive,
    Force,
    Friction,
    Gravity,
    Ground,
    Load,
    Spring,
    Stop,
    Torque,
    Torsion,
)
from ._live import LivePage, live
from ._questions import Answer, Assemblies, LinearSystem, Modes, Response
from ._report import Report
from ._show import Animation, Picture, Plot
from ._samples import Samples
from ._solution import Solution, open
from ._sampled import Sampled
from ._stepping import SavedState, Stepping
from ._said import speak
from ._sweep import Failure, Sweep, sweep
from ._values import Inputs, Parameters

__all__ = [
    "Animation",
    "Answer",
    "Assemblies",
    "AssemblyError",
    "Body",
    "Check",
    "ConstantVelocity",
    "CurveOnCurve",
    "Cylinder",
    "Cylindrical",
    "Damper",
    "Design",
    "Distance",
    "Diagnostic",
    "Drive",
    "Equations",
    "Error",
    "Failure",
    "Force",
    "Free",
    "Friction",
    "Functions",
    "Gravity",
    "Ground",
    "InputWarning",
    "Inputs",
    "InternalError",
    "Joint",
    "Label",
    "LimitError",
    "KnifeEdge",
    "LineOnCurve",
    "LinearSystem",
    "Link",
    "LivePage",
    "Load",
    "LogError",
    "Model",
    "ModelError",
    "Modes",
    "ParallelAxes",
    "Parameters",
    "PerpendicularAxes",
    "Picture",
    "Planar",
    "Plot",
    "PointOnCurve",
    "PointOnLine",
    "PointOnPlane",
    "Prismatic",
    "Report",
    "Response",
    "Revolute",
    "Rolling",
    "Sampled",
    "Samples",
    "SavedState",
    "Screw",
    "Slot",
    "Solution",
    "SolverError",
    "Spherical",
    "Spring",
    "Start",
    "Stepping",
    "Stop",
    "Sweep",
    "Torque",
    "Torsion",
    "Universal",
    "Weld",
    "WorthWarning",
    "__version__",
    "example",
    "import_model",
    "fit",
    "explain",
    "expr",
    "live",
    "load",
    "loads",
    "open",
    "speak",
    "sweep",
    "optimize",
    "synthesize",
    "tolerance",
]
