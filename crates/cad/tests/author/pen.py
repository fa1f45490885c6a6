"""A pen that draws with ezdxf in metres, whatever the unit, version and style of the drawing.

The variants of a drawing differ by the pen alone: the mechanisms are drawn once.
"""

import math
from dataclasses import dataclass, field

import ezdxf
from ezdxf.math import Matrix44, Vec2, Vec3

# No dates and identifiers that differ from one writing to the next.
ezdxf.options.write_fixed_meta_data_for_testing = True

METRES = {"mm": 0.001, "m": 1.0, "inch": 0.0254}
INSUNITS = {"mm": 4, "m": 6, "inch": 1}


@dataclass
class Variant:
    """How a mechanism is drawn."""

    version: str = "R2010"
    binary: bool = False
    encoding: str = ""  # the version's own: UTF-8, before R2007 code page 1252 with \U+0142
    unit: str = ""  # the mechanism's own
    outline: str = "polyline"  # or chained, hatch, ellipse, spline, insert
    # Everything is drawn somewhere else and moved by ezdxf's `transform`, as if the
    # drawing had been moved or mirrored in a CAD program.
    carry: Matrix44 = field(default_factory=Matrix44)


VARIANTS = {
    "plain": Variant(),
    "r12": Variant(version="R12"),
    "r2000": Variant(version="R2000"),
    "r2018": Variant(version="R2018"),
    "binary": Variant(binary=True),
    "cp1250": Variant(version="R2000", encoding="cp1250"),
    "inch": Variant(unit="inch"),
    "mirrored": Variant(carry=Matrix44.scale(-1, 1, 1)),
    "moved": Variant(carry=Matrix44.z_rotate(0.7) @ Matrix44.translate(120, -35, 0)),
    "scaled": Variant(carry=Matrix44.scale(2.5, 2.5, 2.5)),
    "chained": Variant(outline="chained"),
    "hatch": Variant(outline="hatch"),
    "ellipse": Variant(outline="ellipse"),
    "spline": Variant(outline="spline"),
    "insert": Variant(outline="insert"),
}


class Pen:
    """Draws into the model space of a new drawing; all lengths are in metres."""

    def __init__(self, variant: Variant, unit: str, text_height: float):
        self.variant = variant
        self.is_plain = tuple(variant.carry) == tuple(Matrix44())
        self.back = variant.carry.copy()
        self.back.inverse()
        m = self.back
        self.is_mirrored = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0] < 0
        unit = variant.unit or unit
        self.metres = METRES[unit]
        self.h = text_height
        self.doc = ezdxf.new(variant.version, setup=False)
        if variant.encoding:
            self.doc.encoding = variant.encoding
            self.doc.header["$DWGCODEPAGE"] = "ANSI_" + variant.encoding.removeprefix("cp")
        self.doc.header["$INSUNITS"] = INSUNITS[unit]
        self.doc.header["$MEASUREMENT"] = 0 if unit == "inch" else 1
        self.doc.appids.add("BKSIM")
        self.msp = self.doc.modelspace()
        self.doc.linetypes.add("CENTER", [2.0, 1.25, -0.25, 0.25, -0.25])
        self.doc.header["$LTSCALE"] = self.length(4 * text_height)
        style = self.doc.dimstyles.get("Standard").dxf
        text = self.length(text_height)
        style.dimtxt, style.dimasz = text, text
        style.dimexo, style.dimexe, style.dimgap = 0.5 * text, 0.5 * text, 0.3 * text
        style.dimtad, style.dimdec = 1, 1
        self.doc.header["$DIMTXT"] = self.doc.header["$DIMASZ"] = text
        for name, colour, linetype in [
            ("OUTLINE", 7, "Continuous"),
            ("CENTRE", 12, "CENTER"),
            ("DIMENSIONS", 94, "Continuous"),
            ("FRAME", 8, "Continuous"),
            ("SECTION", 8, "Continuous"),
        ]:
            self.doc.layers.add(name, color=colour, linetype=linetype)

    # Positions and sizes in the drawing, before it is moved as a whole.

    def length(self, metres):
        size = metres / self.metres
        if self.is_plain:
            return size
        return size * self.back.transform_direction(Vec3(1, 0, 0)).magnitude

    def place(self, p):
        p = Vec3(p[0] / self.metres, p[1] / self.metres)
        return Vec2(p if self.is_plain else self.back.transform(p))

    def direction(self, angle):
        v = Vec2(math.cos(angle), math.sin(angle))
        return v if self.is_plain else Vec2(self.back.transform_direction(Vec3(v)))

    def turn(self, angle):
        """The rotation, in degrees, of what stands at `angle` in the end."""
        return math.degrees(angle) if self.is_plain else self.direction(angle).angle_deg

    # Entities.

    def line(self, p, q, layer):
        return self.msp.add_line(self.place(p), self.place(q), dxfattribs={"layer": layer})

    def circle(self, centre, radius, layer):
        return self.msp.add_circle(
            self.place(centre), self.length(radius), dxfattribs={"layer": layer}
        )

    def point(self, p, layer="OUTLINE"):
        return self.msp.add_point(self.place(p), dxfattribs={"layer": layer})

    def arc(self, centre, radius, start, end, layer):
        """From the angle `start` counter-clockwise to `end`."""
        ends = [self.turn(start), self.turn(end)]
        if self.is_mirrored:
            ends.reverse()
        return self.msp.add_arc(
            self.place(centre), self.length(radius), *ends, dxfattribs={"layer": layer}
        )

    def polyline(self, vertices, layer, closed=True):
        """Vertices (x, y, bulge)."""
        sign = -1 if self.is_mirrored else 1
        points = [(*self.place(v), sign * v[2]) for v in vertices]
        attribs = {"layer": layer}
        if self.variant.version == "R12":
            return self.msp.add_polyline2d(points, format="xyb", close=closed, dxfattribs=attribs)
        return self.msp.add_lwpolyline(points, format="xyb", close=closed, dxfattribs=attribs)

    def text(self, words, p, height=None, layer="FRAME", angle=0.0):
        height = self.length(self.h if height is None else height)
        entity = self.msp.add_text(
            words, height=height, rotation=self.turn(angle), dxfattribs={"layer": layer}
        )
        return entity.set_placement(self.place(p))

    def dimension(self, p, q, distance):
        """An aligned dimension from `p` to `q`, `distance` to the left of the line."""
        dimension = self.msp.add_aligned_dim(
            p1=self.place(p),
            p2=self.place(q),
            distance=self.length(distance) * (-1 if self.is_mirrored else 1),
            dimstyle="Standard",
            dxfattribs={"layer": "DIMENSIONS"},
        )
        dimension.render()

    # Extended data: records `(kind, {key: value})`; a value is a text, a number, a point (a pair),
    # or ("entity", e), ("length", l), ("axis", angle).

    def attach(self, entity, *records):
        tags = entity.get_xdata("BKSIM") if entity.has_xdata("BKSIM") else []
        tags = [tuple(tag) for tag in tags]
        for kind, values in records:
            tags += [(1000, kind), (1002, "{")]
            for key, value in values.items():
                if isinstance(value, str):
                    tags.append((1000, f"{key}={value}"))
                    continue
                tags.append((1000, key))
                if isinstance(value, float):
                    tags.append((1040, value))
                elif value[0] == "entity":
                    tags.append((1005, value[1].dxf.handle))
                elif value[0] == "length":
                    tags.append((1041, self.length(value[1])))
                elif value[0] == "axis":
                    tags.append((1013, Vec3(self.direction(value[1]))))
                else:
                    tags.append((1011, Vec3(self.place(value))))
            tags.append((1002, "}"))
        entity.set_xdata("BKSIM", tags)

    # Blocks.

    def block(self, name, symbol, tags):
        """Defines a block of ours: strokes of its symbol in units of the text height, attributes."""
        layout = self.doc.blocks.new(name)
        for stroke in symbol:
            if stroke[0] == "circle":
                layout.add_circle(stroke[1], stroke[2], dxfattribs={"layer": "0"})
            else:
                layout.add_line(stroke[0], stroke[1], dxfattribs={"layer": "0"})
        # Blocks from point to point are one unit long, the others some heights of the text.
        h = 0.05 if symbol[0][1] == (0.3, 0) else 0.8
        for i, tag in enumerate(tags):
            definition = layout.add_attdef(
                tag, (1.5 * h, -1.5 * h * i), height=h, dxfattribs={"prompt": tag.lower()}
            )
            definition.is_invisible = tag != "NAME"

    def insert_between(self, block, p, q, /, **values):
        """Inserts a block of ours that is one unit long from `p` to `q`."""
        along = (q[0] - p[0], q[1] - p[1])
        angle = math.atan2(along[1], along[0])
        return self.insert(block, p, angle, math.hypot(*along), **values)

    def insert(self, block, p, angle=0.0, size=None, /, **values):
        """Inserts a block of ours; `values` are its attributes, `size` is that of one unit."""
        size = self.length(self.h if size is None else size)
        entity = self.msp.add_blockref(
            block,
            self.place(p),
            dxfattribs={
                "layer": "BKSIM",
                "rotation": self.turn(angle),
                "xscale": size,
                "yscale": -size if self.is_mirrored else size,
                "zscale": size,
            },
        )
        entity.add_auto_attribs({key.upper(): value for key, value in values.items()})
        return entity

    def save(self, path):
        if not self.is_plain:
            for entity in self.msp:
                entity.transform(self.variant.carry)
        auditor = self.doc.audit()
        assert not auditor.has_errors and not auditor.has_fixes, [e.message for e in auditor.errors]
        # The order of the classes would be that of a set.
        self.doc.classes.add_required_classes(self.doc.dxfversion)
        self.doc.classes.classes = dict(sorted(self.doc.classes.classes.items()))
        self.doc.saveas(path, fmt="bin" if self.variant.binary else "asc")
