"""Shapes of machine parts and the furniture of a drawing."""

import math


def point(p, angle, along, across=0.0):
    """`p` displaced in the axes of a link that stands at `angle`."""
    c, s = math.cos(angle), math.sin(angle)
    return (p[0] + c * along - s * across, p[1] + s * along + c * across)


def angle(p, q):
    return math.atan2(q[1] - p[1], q[0] - p[0])


def distance(p, q):
    return math.hypot(q[0] - p[0], q[1] - p[1])


def middle(p, q):
    return ((p[0] + q[0]) / 2, (p[1] + q[1]) / 2)


def stadium(p, q, radius):
    """The corners (x, y, bulge) of a bar with round ends about `p` and `q`."""
    a, l = angle(p, q), distance(p, q)
    corners = [(0, -radius, 0), (l, -radius, 1), (l, radius, 0), (0, radius, 1)]
    return [(*point(p, a, x, y), bulge) for x, y, bulge in corners]


def rectangle(p, a, width, height):
    """The corners of a rectangle about `p`."""
    w, h = width / 2, height / 2
    return [(*point(p, a, x, y), 0) for x, y in [(-w, -h), (w, -h), (w, h), (-w, h)]]


def bar(pen, p, q, radius, hole, layer, pins=None):
    """A bar with round ends and a hole at each of its pins; returns the entities of its outline."""
    outline = OUTLINES[pen.variant.outline](pen, p, q, radius, layer)
    if pen.variant.outline != "insert":
        for pin in [p, q] if pins is None else pins:
            pen.circle(pin, hole, layer)
    return outline


def polyline_bar(pen, p, q, radius, layer):
    return [pen.polyline(stadium(p, q, radius), layer)]


def chained_bar(pen, p, q, radius, layer):
    """Two lines and two arcs, neither in order nor in one direction."""
    a = angle(p, q)
    corners = [c[:2] for c in stadium(p, q, radius)]
    return [
        pen.line(corners[0], corners[1], layer),
        pen.arc(p, radius, a + math.pi / 2, a - math.pi / 2, layer),
        pen.line(corners[2], corners[3], layer),
        pen.arc(q, radius, a - math.pi / 2, a + math.pi / 2, layer),
    ]


def hatch_bar(pen, p, q, radius, layer):
    """A hatch alone on the layer of a body; elsewhere the outline that it fills, too."""
    if layer == "OUTLINE":
        polyline_bar(pen, p, q, radius, layer)
    hatch = pen.msp.add_hatch(color=9, dxfattribs={"layer": layer})
    sign = -1 if pen.is_mirrored else 1
    corners = [(*pen.place(v), sign * v[2]) for v in stadium(p, q, radius)]
    hatch.paths.add_polyline_path(corners, is_closed=True)
    return [hatch]


def ellipse_bar(pen, p, q, radius, layer):
    half = distance(p, q) / 2 + 2 * radius
    axis = pen.direction(angle(p, q)).normalize(pen.length(half))
    return [
        pen.msp.add_ellipse(
            pen.place(middle(p, q)), (*axis, 0), ratio=2 * radius / half, dxfattribs={"layer": layer}
        )
    ]


def spline_bar(pen, p, q, radius, layer):
    """A closed cubic spline, the same on both sides of the middle."""
    a, l = angle(p, q), distance(p, q)
    upper = [(l + 2 * radius, 0), (l, 2 * radius), (l / 2, radius), (0, 2 * radius)]
    corners = upper + [(l - x, -y) for x, y in upper]
    spline = pen.msp.add_spline(dxfattribs={"layer": layer})
    spline.set_closed([(*pen.place(point(p, a, x, y)), 0) for x, y in corners])
    return [spline]


def insert_bar(pen, p, q, radius, layer):
    """An insert of a bar that is one unit long: scaled and turned."""
    if "BAR" not in pen.doc.blocks:
        block = pen.doc.blocks.new("BAR", base_point=(3, 1))
        block.add_lwpolyline(
            [(3 + x, 1 + y, b) for x, y, b in stadium((0, 0), (1, 0), 0.1)], format="xyb", close=True
        )
        for x in (3, 4):
            block.add_circle((x, 1), 0.04)
    size = pen.length(distance(p, q))
    return [
        pen.msp.add_blockref(
            "BAR",
            pen.place(p),
            dxfattribs={
                "layer": layer,
                "rotation": pen.turn(angle(p, q)),
                "xscale": size,
                "yscale": size,
                "zscale": size,
            },
        )
    ]


OUTLINES = {
    "polyline": polyline_bar,
    "chained": chained_bar,
    "hatch": hatch_bar,
    "ellipse": ellipse_bar,
    "spline": spline_bar,
    "insert": insert_bar,
}


def slot(pen, p, q, radius, layer):
    """A slot: a hole as long as the way from `p` to `q`."""
    return pen.polyline(stadium(p, q, radius), layer)


def bearing(pen, p, size, layer="OUTLINE"):
    """A pivot on the ground: a bracket with its base plate, and the section lines below it."""
    x, y = p
    foot = y - 2.2 * size
    pen.polyline(
        [(x - size, y, -1), (x + size, y, 0), (x + 1.6 * size, foot, 0), (x - 1.6 * size, foot, 0)],
        layer,
    )
    base(pen, (x - 2.4 * size, foot), (x + 2.4 * size, foot), 0.5 * size, layer)


def base(pen, p, q, thickness, layer="OUTLINE"):
    """A base plate below the line from `p` to `q`, with section lines."""
    a, l = angle(p, q), distance(p, q)
    pen.line(p, q, layer)
    n = max(4, min(40, round(l / (2 * thickness))))
    for i in range(n):
        top = point(p, a, (i + 1) * l / n)
        pen.line(top, point(p, a, (i + 0.5) * l / n, -thickness), "SECTION")


def cross(pen, p, size):
    """The centre lines of a hole."""
    x, y = p
    pen.line((x - size, y), (x + size, y), "CENTRE")
    pen.line((x, y - size), (x, y + size), "CENTRE")


def centre_line(pen, p, q, beyond):
    a = angle(p, q)
    pen.line(point(p, a, -beyond), point(q, a, beyond), "CENTRE")


def sheet(pen, low, high, title, remark):
    """The border of the sheet with its title block."""
    (x0, y0), (x1, y1) = low, high
    h = pen.h
    pen.polyline([(x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0)], "FRAME")
    left, top = x1 - 24 * h, y0 + 5 * h
    pen.polyline([(left, y0, 0), (left, top, 0), (x1, top, 0)], "FRAME", closed=False)
    pen.line((left, y0 + 2.2 * h), (x1, y0 + 2.2 * h), "FRAME")
    heading = pen.text(title, (left + h, y0 + 3 * h), height=1.3 * h)
    pen.text(remark, (left + h, y0 + 0.7 * h), height=0.8 * h)
    return heading
