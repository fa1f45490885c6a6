"""Draws every mechanism in every variant, and the press: `author.py FOLDER [MECHANISM-VARIANT…]`."""

import importlib
import sys
from pathlib import Path

from pen import VARIANTS, Pen

MECHANISMS = ["slider-crank", "four-bar", "five-link", "quick-return"]


def draw(mechanism, variant, out, part="draw"):
    drawing = importlib.import_module(mechanism.replace("-", "_"))
    pen = Pen(VARIANTS[variant], drawing.UNIT, drawing.TEXT)
    getattr(drawing, part)(pen)
    pen.save(out)


if __name__ == "__main__":
    folder, *names = sys.argv[1:]
    for mechanism in MECHANISMS:
        for variant in VARIANTS:
            name = f"{mechanism}-{variant}"
            if not names or name in names:
                draw(mechanism, variant, Path(folder) / f"{name}.dxf")
                print(name)
    for name, part in {"press-outlines": "outlines", "press-plain": "draw"}.items():
        if not names or name in names:
            draw("press", "plain", Path(folder) / f"{name}.dxf", part)
            print(name)
