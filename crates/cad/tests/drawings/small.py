"""Writes the small drawings of this folder: one of each thing that is read, in few lines.

    python small.py FOLDER

ezdxf adds styles, views and layouts to every drawing; what no reader needs is left out, so that
mutations hit what matters.
"""

import sys
from pathlib import Path

import ezdxf
from ezdxf.document import Drawing


def revolute(entity, name):
    entity.set_xdata("BKSIM", [
        (1000, "revolute"), (1002, "{"), (1000, f"name={name}"), (1000, "at"), (1011, (1, 2, 0)),
        (1002, "}"),
    ])


def draw(version: str) -> Drawing:
    doc = ezdxf.new(version)
    doc.header["$INSUNITS"] = 4
    doc.header["$MEASUREMENT"] = 1
    for name in ["BKSIM", "OTHER"]:
        doc.appids.add(name)
    doc.layers.add("BK_BODY_crank")
    doc.layers.add("BK_JOINTS")
    msp = doc.modelspace()
    bar = [(0, 0, 0, 0, 0.5), (100, 0), (100, 50)]
    if version == "R12":
        outline = msp.add_polyline2d([(0, 0), (100, 0), (100, 50)], close=True)
    else:
        outline = msp.add_lwpolyline(bar, close=True)
    outline.dxf.layer = "BK_BODY_crank"
    outline.set_xdata("OTHER", [(1000, "keep"), (1070, 3), (1011, (1, 2, 3))])
    circle = msp.add_circle((1, 2), 3, dxfattribs={"layer": "BK_JOINTS"})
    revolute(circle, "B")
    msp.add_line((0, 0), (1, 1))
    msp.add_arc((5, 5), 2, 10, 170)
    msp.add_point((7, 8))
    msp.add_text("żółw é", dxfattribs={"insert": (3, 3), "height": 2})
    block = doc.blocks.new("BK_BODY")
    block.add_attdef("NAME", (0, 0))
    block.add_attdef("MASS", (0, -5))
    block.add_line((0, 0), (1, 0))
    outer = doc.blocks.new("OUTER")
    outer.add_blockref("BK_BODY", (1, 1))
    insert = msp.add_blockref("BK_BODY", (5, 5), dxfattribs={"rotation": 30})
    insert.add_auto_attribs({"NAME": "crank", "MASS": "1 kg"})
    msp.add_blockref("OUTER", (9, 9), dxfattribs={"column_count": 2, "row_count": 3})
    if version != "R12":
        msp.add_mtext("hello\\Pthere")
        msp.add_spline([(0, 0), (1, 2), (3, 1), (4, 4)])
        msp.add_ellipse((0, 0), (5, 0), 0.5)
        hatch = msp.add_hatch(2)
        hatch.paths.add_polyline_path([(0, 0), (1, 0, 0.3), (1, 1)])
        edges = hatch.paths.add_edge_path()
        edges.add_line((0, 0), (1, 0))
        edges.add_arc((0, 0), 1, 0, 90)
        edges.add_spline(control_points=[(0, 1), (-1, 1), (-1, 0), (0, 0)], degree=3,
                         knot_values=[0, 0, 0, 0, 1, 1, 1, 1])
        msp.add_linear_dim((0, 5), (0, 0), (10, 0)).render()
        xrecord = circle.new_extension_dict().add_xrecord("MINE")
        xrecord.reset([(1, "text"), (40, 2.5), (70, 7)])
        doc.layout("Layout1").add_line((0, 0), (1, 1))
    return doc


def main(folder: Path) -> None:
    for version in ["R12", "R2000", "R2010", "R2018"]:
        doc = draw(version)
        doc.saveas(folder / f"{version}.dxf")
        if version in ("R12", "R2010"):
            doc.saveas(folder / f"{version}_binary.dxf", fmt="bin")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
