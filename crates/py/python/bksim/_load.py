"""Models from files, drawings, texts, and the examples."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from . import _bksim
from ._assigned import Value
from ._imported import imported
from ._model import Model
from ._named import unknown
from ._reading import read, text_of
from ._words import Jit


def load(
    source: str | os.PathLike[str],
    *,
    set: Mapping[str, Value] | None = None,
    units: str | None = None,
    tolerance: float | None = None,
    jit: Jit | None = None,
) -> Model:
    """Reads a model.

    ``source`` is the path of a model file or of a drawing (DXF, DWG), or the text of a model, which
    has more than one line. ``set`` gives parameters other values, ``units`` is what one unit of a
    drawing is unless it says so, ``tolerance`` how far apart points of a drawing may be that are
    one. ``jit`` (``"auto"``, ``"on"``, ``"off"``) is whether the equations run as machine code.

    >>> import bksim
    >>> m = bksim.load('''
    ... [bodies.bob]
    ... mass = "2 kg"
    ... com = [0, "-0.5 m"]
    ... [joints.A]
    ... type = "revolute"
    ... between = ["ground", "bob"]
    ... ''')
    >>> m.coordinates
    ('A_angle',)

    Raises ModelError with every fault, OSError when the file cannot be read.
    """
    if isinstance(source, str) and "\n" in source:
        return loads(source, set=set, jit=jit)
    path = Path(source)
    path.stat()
    overrides = [(name, text_of(value)) for name, value in (set or {}).items()]
    engine = _bksim.Engine.open(path, overrides, units, tolerance, jit)
    return Model._of(engine, dict(overrides), jit)


def loads(
    text: str,
    *,
    name: str = "model",
    set: Mapping[str, Value] | None = None,
    jit: Jit | None = None,
) -> Model:
    """Reads the text of a model. See :func:`load`."""
    overrides = [(key, text_of(value)) for key, value in (set or {}).items()]
    engine = read((text, Path(f"{name}.toml"), name), overrides, jit)
    return Model._of(engine, dict(overrides), jit)


def import_model(
    source: str | os.PathLike[str],
    *,
    paths: Iterable[str | os.PathLike[str]] = (),
    free: bool = False,
    answers: Mapping[str, str] | None = None,
    units: str | None = None,
    jit: Jit | None = None,
) -> Model:
    """The model of a file of another program, as ``bksim import`` writes it; its text is ``Model.text``.

    ``source`` is a file in URDF, MJCF, SDF or of Adams, a drawing without attributes (DXF, DWG, SVG), or a link of PMKS+. ``paths`` are folders in
    which ``package://`` and ``model://`` are looked for. ``free`` lets the first link of a robot in URDF move. ``answers`` are those
    to the questions of a drawing, by their keys, ``units`` is what one unit of it is.

    Raises ModelError with every fault, OSError when the file cannot be read.
    """
    arguments = [f"--path={os.fspath(path)}" for path in paths]
    arguments += [f"--answer={key}={value}" for key, value in (answers or {}).items()]
    arguments += ["--free"] if free else []
    arguments += [f"--units={units}"] if units is not None else []
    answer = imported(os.fspath(source), arguments)
    name = Path(source).stem if "?" not in os.fspath(source) else "linkage"
    return loads(answer["model"], name=name, jit=jit)


def example(name: str) -> Model:
    """A model that comes with bksim: ``"four-bar"``, ``"trebuchet"``, … as ``bksim new --list`` names them.

    >>> import bksim
    >>> bksim.example("four-bar").coordinates
    ('A_angle', 'D_angle', 'B_angle')

    Raises KeyError when there is none of this name.
    """
    texts = dict(_bksim.examples())
    if name not in texts:
        raise KeyError(unknown(name, list(texts)))
    return loads(texts[name], name=name)
