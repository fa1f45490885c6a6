"""Draws a drawing as a picture: `picture.py DRAWING OUT.svg`. Needs Pillow in addition to ezdxf."""

import sys

import ezdxf
from ezdxf import bbox
from ezdxf.addons.drawing import Frontend, RenderContext, layout
from ezdxf.addons.drawing.properties import LayoutProperties
from ezdxf.addons.drawing.svg import SVGBackend

# Of the picture, in mm.
WIDTH = 200


def main(drawing, out):
    doc = ezdxf.readfile(drawing)
    msp = doc.modelspace()
    box = bbox.extents(msp, fast=True)
    backend = SVGBackend()
    paper = LayoutProperties.from_layout(msp)
    paper.set_colors("#ffffff")
    Frontend(RenderContext(doc), backend).draw_layout(msp, layout_properties=paper)
    page = layout.Page(WIDTH, WIDTH * box.size.y / box.size.x, layout.Units.mm, layout.Margins.all(2))
    with open(out, "w", encoding="utf-8") as file:
        file.write(backend.get_string(page, settings=layout.Settings(output_coordinate_space=20_000)))


main(*sys.argv[1:])
