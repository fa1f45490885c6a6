"""The language of tables, summaries and answers that people read."""

from __future__ import annotations

import os

from . import _bksim


def speak(language: str) -> None:
    """Sets the language of tables, summaries and answers: ``"vi"``, ``"en"``, or a locale such as ``"vi_VN.UTF-8"``.

    >>> import bksim
    >>> bksim.speak("vi")
    >>> bksim.example("four-bar")
    <bksim.Model 'four-bar': 3 tọa độ, 4 khớp>
    >>> bksim.speak("en")

    Names, numbers, and the messages of exceptions, whose codes :func:`bksim.explain` knows, stay as they are. Without a call
    the language is that of ``LC_ALL``, ``LC_MESSAGES`` or ``LANG``, as on the command line.
    """
    _bksim.speak(language)


def said(text: str) -> str:
    """A heading, a label or a sentence in the language that is spoken."""
    return _bksim.said(text)


def _of_surroundings() -> None:
    names = ("LC_ALL", "LC_MESSAGES", "LANG")
    speak(next(filter(None, map(os.environ.get, names)), ""))


_of_surroundings()
