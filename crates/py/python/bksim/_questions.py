"""Questions to a mechanism besides its motion in time."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _bksim
from ._checked import names, pairs, real
from ._html import table
from ._show import Picture
from ._solution import Solution
from ._text import counted

Values: TypeAlias = str | tuple[float, float, int] | NDArray[np.float64]
"""A range as text, ``"0:360 deg:361"``, as the first value, the last and their number, or as an array with even steps, of
``numpy.linspace`` (of frequencies, of ``numpy.geomspace``), in SI."""


class Answer(Mapping[str, NDArray[np.float64]]):
    """An answer: columns of a table by their names, in SI units and radians, and ``facts``.

    ``facts`` are what ``--json`` prints for the command of the question; ``str(answer)`` is what it prints
    otherwise, and ``units`` has the unit of each column.
    """

    def __init__(self, told: _bksim._Told) -> None:
        facts, self._text, columns, units, self._values = told
        self.facts: dict[str, Any] = json.loads(facts)
        self.units: dict[str, str] = dict(zip(columns, units, strict=True))
        self._places = {name: place for place, name in enumerate(columns)}

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        column: NDArray[np.float64] = self._values[self._places[name]]
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def __str__(self) -> str:
        return _bksim.said_answer(self._text)

    def __repr__(self) -> str:
        n_rows = self._values.shape[1]
        columns, rows = counted(len(self), "column", "columns"), counted(n_rows, "row", "rows")
        return f"<bksim.{type(self).__name__}: {columns}, {rows}>"

    def _repr_html_(self) -> str:
        most = 20
        rows = [[f"{value:g}" for value in row] for row in self._values.T[:most]]
        return table(list(self), rows)


class Assemblies(Answer):
    """The ways in which a start closes, a row for each; a notebook shows them as small pictures."""

    def __init__(self, told: _bksim._Told, svg: str) -> None:
        super().__init__(told)
        self._picture = Picture(svg)

    @property
    def all_proved(self) -> bool:
        """True where it is proved that there are no others."""
        return self.facts["proof"] is not None

    def picture(self) -> Picture:
        """All of them beside each other."""
        return self._picture

    def _repr_html_(self) -> str:
        return self._picture.svg + super()._repr_html_()


class LinearSystem(Answer):
    """x' = A x + B u, z = C x + D u about a state."""

    @property
    def A(self) -> NDArray[np.float64]:
        """By states, rows and columns."""
        return self._matrix("A", len(self.states), len(self.states))

    @property
    def B(self) -> NDArray[np.float64]:
        """By states and inputs."""
        return self._matrix("B", len(self.states), len(self.inputs))

    @property
    def C(self) -> NDArray[np.float64]:
        """By outputs and states."""
        return self._matrix("C", len(self.outputs), len(self.states))

    @property
    def D(self) -> NDArray[np.float64]:
        """By outputs and inputs."""
        return self._matrix("D", len(self.outputs), len(self.inputs))

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(state["name"] for state in self.facts["states"])

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(self.facts["inputs"])

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(output["name"] for output in self.facts["outputs"])

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of A, 1/s."""
        return _complex(self.facts["poles"])

    def to_control(self, dt: float | None = None, method: str = "zoh") -> Any:
        """As ``StateSpace`` of the package ``control``, with the names of states, inputs and outputs, ``_`` in place of
        their points; with ``dt`` sampled every ``dt`` seconds by ``method``, as of ``control.c2d``."""
        import control

        kinds = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        names = {kind: [name.replace(".", "_") for name in all] for kind, all in kinds.items()}
        system = control.ss(self.A, self.B, self.C, self.D, **names)
        if dt is None:
            return system
        sampled = control.c2d(system, dt, method)
        sampled.update_names(**names)
        return sampled

    def _matrix(self, key: str, n_rows: int, n_columns: int) -> NDArray[np.float64]:
        return np.array(self.facts[key], dtype=np.float64).reshape(n_rows, n_columns)


class Modes(Answer):
    """Small motions about an equilibrium, a row for each."""

    @property
    def s(self) -> NDArray[np.complex128]:
        """Of each mode s of e^(s t), 1/s; of pairs that with Im s > 0."""
        return _complex([mode["s"] for mode in self.facts["modes"]])


class Response(Answer):
    """A frequency response, a row for each frequency."""

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Of the system, 1/s."""
        return _complex(self.facts["poles"])

    def zeros(self, input: str, output: str) -> NDArray[np.complex128]:
        """Of an input and an output, 1/s."""
        return _complex(self._transfer(input, output)["zeros"])

    def transfer(self, input: str, output: str) -> NDArray[np.complex128]:
        """H(i omega) from an input to an output."""
        found = self._transfer(input, output)
        gain, phase = np.array(found["gain"]), np.array(found["phase"])
        return np.asarray(gain * np.exp(1j * phase), dtype=np.complex128)

    def _transfer(self, input: str, output: str) -> dict[str, Any]:
        for transfer in self.facts["transfers"]:
            if (transfer["input"], transfer["output"]) == (input, output):
                return dict(transfer)
        raise KeyError(f"no response of {output!r} to {input!r}")


class Questions:
    """The questions that a model answers without its motion in time."""

    def _engine(self) -> _bksim.Engine:
        raise NotImplementedError

    def kinematics(
        self,
        drive: Mapping[str, Values],
        *,
        rate: str | Sequence[str] = (),
        acceleration: str | Sequence[str] = (),
        through: bool = False,
        branch: int | None = None,
        jerk: bool = False,
    ) -> Answer:
        """Positions, velocities and accelerations over a range of one measure, or of several together.

        >>> import bksim
        >>> m = bksim.example("four-bar")
        >>> a = m.kinematics({"A.angle": "30:40 deg:11"})
        >>> a["D.angle"].shape
        (11,)

        ``rate`` and ``acceleration`` are those of the drives, ``"25 rad/s"``; 1 and 0 unless given.
        ``through`` goes on through dead points; where branches cross in the start, ``branch`` is the number of the one to
        follow. ``jerk`` gives the third rates, too.
        """
        driven = [(name, _range(values)) for name, values in drive.items()]
        rates = (names("rate", rate), names("acceleration", acceleration))
        return Answer(_bksim.kinematics_of(self._engine(), driven, rates, (through, branch, jerk)))

    def closing(self, solve: str | Sequence[str]) -> Answer:
        """The values of parameters with which the start closes at all the positions that it states: ``closing("L")["L"]``."""
        return Answer(_bksim.closing_of(self._engine(), names("solve", solve)))

    def limits(
        self, drive: str | None = None, of: str | Sequence[str] = (), *, all_assemblies: bool = False
    ) -> Answer:
        """Ranges, limit positions, dead points and transmission angles; with a drive, time ratios and fastest
        motions of the outputs ``of``."""
        found = _bksim.limits_of(self._engine(), drive, names("of", of), all_assemblies)
        return Answer(found)

    def curves(
        self,
        points: str | Sequence[str] = (),
        *,
        centrodes: str | Sequence[str] = (),
        swept: str | Sequence[str] = (),
        all_assemblies: bool = False,
    ) -> Answer:
        """Ways of points with their double points and cusps, instant centres at the start, centrodes of bodies
        (``"coupler"``, ``"coupler/crank"``) and the regions that bodies sweep; with nothing named, the ways of the
        points that no joint connects."""
        asked = (names("points", points), names("centrodes", centrodes), names("swept", swept))
        return Answer(_bksim.curves_of(self._engine(), *asked, all_assemblies))

    def workspaces(self, points: str | Sequence[str]) -> Answer:
        """Where points of a mechanism with two free motions or more can be brought."""
        return Answer(_bksim.workspaces_of(self._engine(), names("points", points)))

    def assemblies(self) -> Assemblies:
        """The ways in which the start closes.

        >>> import bksim
        >>> found = bksim.example("four-bar").assemblies()
        >>> len(found["number"]), found.all_proved
        (2, True)

        A notebook shows each as a small picture; ``found.picture().save("ways.svg")`` writes them.
        """
        return Assemblies(*_bksim.assemblies_of(self._engine()))

    def static(
        self,
        *,
        by: str | Sequence[str] = (),
        over: Mapping[str, Values] | None = None,
        solve: str | Sequence[str] = (),
        compliance: Mapping[str, str | Sequence[str]] | None = None,
        bound: Mapping[str, str] | None = None,
    ) -> Answer:
        """Equilibria, their stability and the reactions in them; ``by`` are measures that the stiffness is by.

        ``over={"k": "1:5 N/m:41"}`` follows them over a parameter, through limit points and branch points;
        ``solve="k"`` finds the value with which the start is in balance.
        ``compliance={"A": "1e8 N/m"}`` lets joints yield that share what they carry, each by one stiffness or several,
        ``["1e8 N/m", "1e5 N m/rad"]``; ``bound={"A.fy": "0:500 N"}``
        bounds reactions that are not unique.
        """
        ranges = [(name, _range(values)) for name, values in (over or {}).items()]
        if len(ranges) > 1 or (ranges and solve):
            raise ValueError("equilibria are followed over one parameter, or balanced")
        asked = ranges[0] if ranges else None
        reactions = (pairs(compliance), pairs(bound))
        solving = names("solve", solve)
        found = _bksim.static_of(self._engine(), names("by", by), asked, solving, reactions)
        return Answer(found)

    def linearize(
        self,
        input: str | Sequence[str] = (),
        output: str | Sequence[str] = (),
        *,
        state: str | Sequence[str] = (),
        at: str | int = "static",
        letters: bool = False,
    ) -> LinearSystem:
        """The equations, linear about the equilibrium nearest to the start, whatever its stability.

        ``at="stable"`` takes the nearest stable one, ``at=2`` the second one as ``static`` lists them, ``at="start"`` the start
        as it is, ``at="t=1 s"`` the run at an instant; ``facts["state"]`` names the state, with the others.

        An input is a parameter of loads or a joint that an effort works on, an output a measure. With ``letters``,
        ``facts["letters"]`` has A, B, C and D in letters with a certificate, of small mechanisms at rest; its
        ``blocks`` are names for long parts with their definitions.
        """
        channels = (names("input", input), names("output", output), names("state", state))
        return LinearSystem(_bksim.linearize_of(self._engine(), str(at), channels, letters))

    def modes(self, *, at: str | int = "static") -> Modes:
        """Frequencies, damping and shapes of small motions about an equilibrium, chosen by ``at`` as in :meth:`linearize`, or about
        the start as if at rest (``at="start"``); ``facts["state"]`` names it."""
        return Modes(_bksim.modes_of(self._engine(), str(at)))

    def bode(
        self,
        input: str | Sequence[str],
        output: str | Sequence[str],
        *,
        omega: Values | None = None,
        at: str | int = "static",
    ) -> Response:
        """The frequency response with poles and zeros; ``omega`` is a range in even steps of its logarithm."""
        channels = (names("input", input), names("output", output))
        frequencies = None if omega is None else _range(omega, geometric=True)
        return Response(_bksim.bode_of(self._engine(), str(at), channels, frequencies))

    def inverse(
        self,
        motion: Mapping[str, str | tuple[ArrayLike, ArrayLike] | Solution] | None = None,
        *,
        times: Values | None = None,
        smoothing: float = 0.0,
        actuator: str | Sequence[str] = (),
        limit: Mapping[str, str] | None = None,
        curve: Mapping[str, str | tuple[ArrayLike, ArrayLike]] | None = None,
        compliance: Mapping[str, str | Sequence[str]] | None = None,
    ) -> Answer:
        """The efforts, reactions and powers that a motion needs.

        A motion is a formula of t in SI, ``{"A.angle": "0.4 + 6*t"}``, or with units, tables and laws of the model,
        ``{"S.position": "100 mm*sin(2 rad/s*t)"}``, or times and values, through which a natural
        cubic spline goes, the smoother the larger ``smoothing`` is, or a solution (a run, or a log that ``bksim.open``
        has opened), whose samples of value, rate and acceleration are joined. States of controllers and signals with a
        clock follow the motion. Friction acts as in a run; where joints at rest leave efforts a range, ``A.effort_min`` and
        ``A.effort_max`` are its ends, and ``facts["open"]`` says why. ``actuator`` names the joints that have an effort,
        ``limit={"A": "12 N m"}`` their largest ones; ``curve={"A": (speeds, efforts)}`` is the curve of a motor in
        SI, ``curve={"A": "motor"}`` that of a table of the model.
        """

        def listed(value: tuple[ArrayLike, ArrayLike]) -> tuple[list[float], list[float]]:
            first, second = (np.asarray(part, dtype=np.float64).tolist() for part in value)
            return (first, second)

        def written(
            name: str, value: str | tuple[ArrayLike, ArrayLike] | Solution
        ) -> str | tuple[list[float], list[float]] | tuple[list[float], list[list[float]]]:
            if isinstance(value, str):
                return value
            return _samples(name, value) if isinstance(value, Solution) else listed(value)

        motions = [(name, written(name, value)) for name, value in (motion or {}).items()]
        asked = None if times is None else _range(times)
        smooth = real("smoothing", smoothing) or 0.0
        motors = ((name, value if isinstance(value, str) else listed(value)) for name, value in (curve or {}).items())
        acting = (names("actuator", actuator), pairs(limit), list(motors), pairs(compliance))
        return Answer(_bksim.inverse_of(self._engine(), motions, smooth, asked, acting))

    def doctor(self, drive: str | None = None) -> Answer:
        """Free motions, conditions that repeat others, and changes of joints that cure them.

        With ``drive``, such as ``"crank.angle"``, also the singular poses along the whole motion.
        """
        return Answer(_bksim.doctor_of(self._engine(), drive))

    def verify(self, t_end: float | None = None, *, patience: float = 60.0) -> Answer:
        """The run beside the same motion in other coordinates by another method: the table has the differences of
        all channels, ``facts["within"]`` says whether all keep to the tolerances. Each of the runs takes at most
        ``patience`` seconds; what they have reached then is compared."""
        longest = real("patience", patience) or 0.0
        return Answer(_bksim.verify_of(self._engine(), real("t_end", t_end), longest))


def _samples(name: str, run: Solution) -> tuple[list[float], list[list[float]]]:
    """Times of a run, with value, rate and acceleration at each; an event has two samples at one time."""
    names = run._engine.motion_names(name)
    if names is None:
        raise ValueError(f"{name!r} is no position of a joint, body or point with a rate of its own")
    rows = np.stack([run[known] for known in names], axis=1)
    return run.t.tolist(), rows.tolist()


def _range(values: Values, *, geometric: bool = False) -> str:
    if isinstance(values, str):
        return values
    if isinstance(values, np.ndarray):
        first, last, n = _ends(values, geometric=geometric)
    else:
        first, last, n = values
    return f"{float(first)!r}:{float(last)!r}:{int(n)}"


def _ends(values: NDArray[np.float64], *, geometric: bool) -> tuple[float, float, int]:
    """First and last value of an array with even steps, or with steps that are even in its logarithm, and their number."""
    own = "numpy.geomspace" if geometric else "numpy.linspace"
    if values.ndim != 1 or len(values) == 0 or not np.isfinite(values).all():
        raise ValueError(f"values are a row of finite numbers, as {own} gives them")
    first, last, n = float(values[0]), float(values[-1]), len(values)
    if geometric and not (first > 0 and last > 0):
        raise ValueError("frequencies are greater than zero")
    even = np.geomspace(first, last, n) if geometric else np.linspace(first, last, n)
    if not np.allclose(values, even, rtol=1e-9, atol=1e-12 * float(np.abs(values).max())):
        raise ValueError(f"values have even steps here, as {own} gives them")
    return first, last, n


def _complex(pairs: list[list[float]]) -> NDArray[np.complex128]:
    parts = np.array(pairs, dtype=np.float64).reshape(len(pairs), 2)
    return np.asarray(parts[:, 0] + 1j * parts[:, 1], dtype=np.complex128)
