"""Models: from a file, a drawing, a text, or built in code; to equations and motion."""

from __future__ import annotations

import copy
import json
import os
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from . import _bksim
from ._checked import names, pairs, real, whole
from ._document import Document
from ._equations import Equations
from ._events import Event, found
from ._ended import LimitError, SolverError
from ._errors import Diagnostic, ModelError, WorthWarning, diagnostics_of
from ._functions import Functions
from ._imported import imported
from ._assigned import Value
from ._joints import Joint
from ._parts import Body, Drive, Ground, Load
from ._progress import Progress
from ._questions import Questions
from ._reading import read
from ._facts import Check, Start
from ._said import said
from ._sampled import Sampled, held
from ._solution import Solution
from ._stepping import Stepping
from ._text import counted
from ._values import Inputs, Law, Parameters, first_line
from ._words import Formulation, Jit, Method

MEMORY_LIMIT = 4 << 30
"""Bytes that the samples and the motion of one run may take unless ``memory_limit`` says otherwise."""


class Model(Questions):
    """A mechanism: what its author wrote, and from there its equations and its motion.

    Built in code:

    >>> import bksim
    >>> m = bksim.Model("pendulum")
    >>> m.bodies["bob"] = bksim.Body(mass="2 kg", com=[0, "-0.5 m"])
    >>> m.joints["A"] = bksim.Revolute("ground", "bob")
    >>> m.loads["gravity"] = bksim.Gravity(acceleration=[0, "-9.81 m/s^2"])
    >>> m.initial["A"] = {"angle": "30 deg"}
    >>> m.equations.kinetic_energy
    '0.25*A_angle_dot^2'
    """

    def __init__(
        self,
        name: str | None = None,
        *,
        space: str | None = None,
        coordinates: str | None = None,
        units: Mapping[str, str] | None = None,
        parameters: Mapping[str, Value] | None = None,
    ) -> None:
        self._document: Document | None = Document(
            name=name,
            space=space,
            policy=coordinates,
            units=dict(units or {}),
            parameters=dict(parameters or {}),
        )
        self._tables: dict[str, Any] | None = None
        self._overrides: dict[str, str] = {}
        self._numbers: dict[str, float] = {}
        self._inputs: dict[str, Law | Sampled] = {}
        self._known: tuple[Any, tuple[float, ...], _bksim.Engine] | None = None
        self._source: tuple[str, Path, str] | None = None
        self._jit: Jit | None = None

    @classmethod
    def _of(cls, engine: _bksim.Engine, overrides: dict[str, str], jit: Jit | None) -> Model:
        model = cls()
        model._document = None
        model._overrides = overrides
        model._source = (engine.text, engine.path, engine.name)
        model._jit = jit
        model._known = (model._key(engine.text), (), engine)
        return model

    def _key(self, text: str) -> tuple[Any, ...]:
        """What the equations follow from: all but the numbers of parameters."""
        texts = tuple(item for item in self._overrides.items() if item[0] not in self._numbers)
        return text, texts, tuple(self._numbers), tuple(self._inputs.items())

    def _engine(self) -> _bksim.Engine:
        """The equations of the model as it is now, derived only when more than numbers has changed."""
        source = self._text()
        key, numbers = self._key(source[0]), tuple(self._numbers.values())
        engine: _bksim.Engine | None = None
        overrides = list(self._overrides.items())
        if self._known is not None and self._known[0] == key:
            if self._known[1] == numbers:
                return self._known[2]
            engine = self._known[2].at(list(numbers), overrides)
        if engine is None:
            # Until a solve has called it, a sampled law leaves its parameter a number.
            laws = {k: law for k, law in self._inputs.items() if not isinstance(law, Sampled)}
            built = source is not self._source
            engine = read(source, overrides, self._jit, laws, self._numbers, built)
        self._known = (key, numbers, engine)
        return engine

    def _readable(self) -> _bksim.Engine:
        """The model with whatever values, also when its present ones are refused."""
        source, known = self._text(), self._known
        if known is not None and known[0][0] == source[0]:
            return known[2]
        try:
            return self._engine()
        except ModelError:
            return read(source, [], self._jit, is_built=source is not self._source)

    def _text(self) -> tuple[str, Path, str]:
        if self._document is None:
            assert self._source is not None
            return self._source
        tables = self._document.tables()
        if self._source is not None and tables == self._tables:
            return self._source
        name = self._document.name or (self._source[2] if self._source else "model")
        try:
            text = _bksim.to_toml(json.dumps(tables, allow_nan=False))
        except (TypeError, ValueError) as error:
            raise ModelError(f"the model cannot be written down: {error}") from error
        return text, Path(f"{name}.toml"), name

    def _parts(self) -> Document:
        if self._document is None:
            tables = json.loads(_bksim.from_toml(self._engine().text))
            self._document = Document.of(tables)
            self._tables = self._document.tables()
        return self._document

    # What the author wrote.

    @property
    def text(self) -> str:
        """The model as the text of a model file, with the values that its parameters have now."""
        return _bksim.with_values(self._text()[0], list(self._overrides.items()))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the text of the model to a file."""
        Path(path).expanduser().write_text(self.text, encoding="utf-8")

    def robot(self, to: Literal["urdf", "mjcf", "sdf"]) -> str:
        """The model as the text of a robot file, as ``bksim import --to`` writes it.

        What the format cannot hold is listed at the head of the text.
        Raises ModelError where the format cannot hold the model at all.
        """
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, f"{self.name}.toml")
            self.save(file)
            text: str = imported(str(file), [f"--to={to}"])["model"]
        return text

    def copy(self) -> Model:
        """A model of its own, with the same values and inputs."""
        return copy.copy(self)

    def __copy__(self) -> Model:
        other = Model()
        other.__dict__.update(self.__dict__)
        other._overrides, other._numbers = dict(self._overrides), dict(self._numbers)
        other._inputs, other._document = dict(self._inputs), copy.deepcopy(self._document)
        return other

    def __getstate__(self) -> dict[str, Any]:
        # What is compiled stays here, and is derived again where it is needed.
        return {**self.__dict__, "_known": None}

    @property
    def name(self) -> str:
        """The name of the mechanism."""
        return self._engine().name

    @property
    def ground(self) -> Ground:
        """The body that does not move."""
        return self._parts().ground

    @property
    def bodies(self) -> dict[str, Body]:
        """Bodies by name; what is changed here changes the model."""
        return self._parts().bodies

    @property
    def joints(self) -> dict[str, Joint]:
        """Joints by name."""
        return self._parts().joints

    @property
    def loads(self) -> dict[str, Load]:
        """Loads by name."""
        return self._parts().loads

    @property
    def drives(self) -> dict[str, Drive]:
        """Drives by name."""
        return self._parts().drives

    @property
    def initial(self) -> dict[str, Any]:
        """Where the motion starts: ``m.initial["A"] = {"angle": "30 deg"}``."""
        return self._parts().initial

    @property
    def options(self) -> dict[str, Any]:
        """The table ``[solve]`` of the model."""
        return self._parts().options

    @property
    def parameters(self) -> Parameters:
        """Values of the parameters."""
        return Parameters(self)

    @property
    def inputs(self) -> Inputs:
        """Parameters that are functions of the motion."""
        return Inputs(self)

    # What follows from it.

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the generalised coordinates, in the order of ``q``."""
        return tuple(name for name, _, _ in self._engine().coordinates())

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Warnings about the model."""
        return diagnostics_of(self._engine().diagnostics())

    @property
    def equations(self) -> Equations:
        """T, V, Lagrange's equations with multipliers and the constraints."""
        return Equations(self._engine())

    def check(self) -> Check:
        """What the mechanism is made of, and how it can move.

        Raises ModelError, and AssemblyError when it has no consistent start.
        """
        return Check._of(json.loads(self._engine().check()))

    def assemble(self) -> Start:
        """The consistent start. Raises AssemblyError."""
        return Start._of(json.loads(self._engine().assemble()))

    def compile(self) -> Functions:
        """The compiled functions of the equations at the present values of the parameters."""
        return Functions(_bksim.compiled_functions(self._engine()))

    def solve(
        self,
        t_end: float | None = None,
        *,
        rtol: float | None = None,
        atol: float | None = None,
        step: float | None = None,
        every: float | None = None,
        times: Sequence[float] | None = None,
        method: Method | None = None,
        formulation: Formulation | None = None,
        compliance: Mapping[str, str | Sequence[str]] | None = None,
        sensitivity: str | Sequence[str] = (),
        events: Event | Sequence[Event] = (),
        dense: bool = True,
        progress: bool | None = None,
        memory_limit: int = MEMORY_LIMIT,
    ) -> Solution:
        """Solves the equations of motion; what is not given is as the model says.

        ``t_end``, ``step`` and ``every`` (the interval of the output) are in s, ``times`` are output
        times in place of ``every``, besides the start and the end. ``dense`` keeps the motion between
        them, which ``solution(t)``, films and logs are made from. ``progress`` shows a bar where tqdm is
        installed; unless given, in runs of more than a second at a terminal or in a notebook.

        ``compliance={"A": "1e8 N/m"}`` lets joints yield, each by one stiffness or several: joints that repeat each other
        share loads by it, all others are rigid.

        ``sensitivity`` names parameters and stated initial values (``"l1"``, ``"A.rate"``) that the motion
        is differentiated by, exactly and across impacts and kinks: see ``Solution.sensitivity``.

        ``events`` are quantities by name (``"rod.B.y"``), or functions of t, q and v as the laws of inputs, whose
        zeros are located on the motion itself, as with SciPy's ``solve_ivp``: ``Solution.t_events`` and
        ``y_events``. An attribute ``direction`` of a function takes rising (above 0) or falling zeros alone,
        ``terminal`` ends the motion there.

        The interpreter lock is released. Ctrl-C ends the run within a fifth of a second; the
        KeyboardInterrupt has what there is as ``result``.

        Warns (:class:`WorthWarning`) where the balance of energy or the constraints are kept worse than the
        tolerances promise, or the run took far more steps than expected: see ``Solution.warnings``.

        Raises AssemblyError without a consistent start; SolverError, with the ``result`` so far, when
        the integrator cannot go on; LimitError, too, when samples take more than ``memory_limit``
        bytes; ValueError for options out of range.

        >>> import bksim
        >>> from pathlib import Path
        >>> m = bksim.example("slider-crank")
        >>> sol = m.solve(t_end=0.5, rtol=1e-8)
        >>> sol.q.shape == (len(m.coordinates), sol.t.size)
        True
        """
        wanted: _bksim._Wanted = {
            "t_end": real("t_end", t_end),
            "rtol": real("rtol", rtol),
            "atol": real("atol", atol),
            "step": real("step", step),
            "every": real("every", every),
            "times": None if times is None else [real("times", t) or 0.0 for t in times],
            "method": method,
            "formulation": formulation,
            "compliance": pairs(compliance),
            "sensitivity": names("sensitivity", sensitivity),
            "dense": dense,
            "most_bytes": whole("memory_limit", memory_limit),
            "notify": None,
        }
        watched: list[Event] = [events] if isinstance(events, str) or callable(events) else list(events)
        if watched and not dense:
            raise ValueError("events are located on the motion between samples: leave dense=False out")
        solution = self._solved(wanted, progress)
        if watched:
            instants, end = found(solution, watched)
            if end is not None:
                forward = end >= solution.span[0]
                instants = [at[at <= end] if forward else at[at >= end] for at in instants]
                times = wanted["times"]
                if times is not None:
                    times = [t for t in times if (t <= end) == forward]
                solution = self._solved({**wanted, "t_end": end, "times": times}, progress)
            solution.t_events = instants
        for warning in solution.warnings:
            warnings.warn(WorthWarning(warning), stacklevel=2)
        return solution

    def _solved(self, wanted: _bksim._Wanted, progress: bool | None) -> Solution:
        """The solution of a run with these options."""
        sampled = self._sampled()
        if sampled:
            # First with the laws, then along what they have returned, which is a function of time.
            other = self.copy()
            for name in sampled:
                del other.inputs[name]
            end = other._engine().options()[1] if wanted["t_end"] is None else wanted["t_end"]
            begun = other.begin(
                end,
                rtol=wanted["rtol"],
                atol=wanted["atol"],
                step=wanted["step"],
                method=wanted["method"],
                formulation=wanted["formulation"],
            )
            other._inputs.update(held(begun, sampled, end))
            return other._solved(wanted, progress)
        engine = self._engine()
        start, end = engine.options()[:2]
        if wanted["t_end"] is not None:
            end = wanted["t_end"]
        with Progress.over(start, end, progress) as notify:
            wanted["notify"] = notify
            run = _bksim.solve(engine, wanted)
        solution = Solution(run)
        if run.ending == "full":
            most = wanted["most_bytes"]
            words = f"samples take more than {most} bytes, at t = {solution.t[-1]:g} s"
            raise LimitError(f"{words}: raise `memory_limit`, or `every`", solution)
        if run.ending == "stopped":
            stopped = run.raised or KeyboardInterrupt()
            stopped.result = solution  # type: ignore[attr-defined]
            raise stopped
        if run.fault is not None:
            words, faults = run.fault
            diagnostics = diagnostics_of(faults)
            # A fault at the first sample leaves none.
            t = float(solution.t[-1]) if len(solution.t) else start
            raise SolverError(words, t, diagnostics[0].message, solution, diagnostics)
        return solution

    def _sampled(self) -> dict[str, Sampled]:
        """The laws that are called at even intervals, by their input."""
        return {name: law for name, law in self._inputs.items() if isinstance(law, Sampled)}

    def begin(
        self,
        t_end: float | None = None,
        *,
        rtol: float | None = None,
        atol: float | None = None,
        step: float | None = None,
        method: Method | None = None,
        formulation: Formulation | None = None,
    ) -> Stepping:
        """A motion at its start, which is advanced from here: for controllers, hardware in the loop and
        learning.

        >>> import bksim
        >>> run = bksim.example("cart-pole").begin(t_end=1)
        >>> run.set_input("u", 2.0)
        >>> run.advance_to(0.01)
        >>> bool(run["x"] > 0)
        True

        Inputs with a :class:`Sampled` law are refused: who advances a motion calls such a law, and sets what
        it returns. Raises as :meth:`solve` does.
        """
        if sampled := self._sampled():
            words = "call them between two steps, and set_input what they return"
            raise ValueError(f"the inputs {', '.join(sampled)} have sampled laws: {words}")
        run = _bksim.begin(
            self._engine(),
            {
                "t_end": real("t_end", t_end),
                "rtol": real("rtol", rtol),
                "atol": real("atol", atol),
                "step": real("step", step),
                "method": method,
                "formulation": formulation,
            },
        )
        return Stepping(run)

    def __repr__(self) -> str:
        try:
            engine = self._engine()
        except ModelError as refused:
            return said("<bksim.Model {}, refused: {}>").format(repr(self._text()[2]), first_line(refused))
        coordinates = counted(len(engine.coordinates()), "coordinate", "coordinates")
        return f"<bksim.Model {engine.name!r}: {coordinates}, {counted(len(engine.joints()), 'joint', 'joints')}>"

    def _repr_html_(self) -> str:
        try:
            return self.check()._repr_html_()
        except Exception as error:  # a notebook shows what is wrong in place of the model
            from html import escape

            return f"<pre>{escape(str(error))}</pre>"
