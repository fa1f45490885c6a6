"""The model file of a document: what is typed as it is, and what the drawing gives where nothing is typed."""

import FreeCAD

from . import elements, frames, geometry, kinds
from .values import key_text, split, vector, with_unit, written, written_pair

# The point at the origin of each body's frame, in models of which a run is to move the parts.
ORIGIN = "origin_of_frame"
DEFAULT_UNITS = {"mass": "kg", "length": "m", "time": "s"}


def number(value):
    """A number without noise of the last bits: of lengths to 1e-9 mm."""
    rounded = round(value, 9) + 0.0
    return str(int(rounded)) if rounded == int(rounded) else repr(rounded)


def length(value_mm):
    """A length with its unit."""
    shown = number(value_mm)
    return "0" if shown == "0" else f'"{shown} mm"'


class Text:
    """Lines of a model file, each with the element and the key that it is about."""

    def __init__(self):
        self.lines, self.abouts = [], []

    def write(self, line, obj=None, key=""):
        self.lines.append(line)
        self.abouts.append((obj, key))

    def header(self, name, obj=None):
        """Begins a table."""
        if self.lines:
            self.write("")
        self.write(f"[{name}]", obj)

    @property
    def text(self):
        return "\n".join(self.lines) + "\n"

    def about(self, line):
        """Element and key of a line, counted from 1."""
        return self.abouts[line - 1] if 0 < line <= len(self.abouts) else (None, "")


class Points:
    """The named points of each body, `None` being the ground: typed ones, and those of places in the drawing."""

    def __init__(self, doc):
        self.doc, self.is_planar, self.rows = doc, frames.is_planar(doc), {}
        for obj in [*elements.all_of(doc, "bodies"), *elements.all_of(doc, "ground")]:
            body = obj if elements.section_of(obj) == "bodies" else None
            for name, value in typed_points(obj):
                self.of(body)[name] = (value, obj, None)
        for obj in elements.all_of(doc, "points"):
            body, at = frames.point(obj)
            value = written(elements.text(obj, "at")) if at is None else self.written(at)
            self.of(body)[obj.ElementName] = (value, obj, at)

    def of(self, body):
        """The points of a body by their names."""
        return self.rows.setdefault(body.Name if body else "", {})

    def written(self, at):
        """A place in the frame of a body, as a model file has it."""
        return vector((at.x, at.y) if self.is_planar else (at.x, at.y, at.z), length)

    def name(self, place, wanted, obj, turned=None):
        """`crank.A` for a place, of a point that is there already or is added as `wanted`.

        With `turned`, a rotation from the point's frame to that of the body, the point is a frame.
        """
        owner = place.body.ElementName if place.body else "ground"
        is_turned = turned is not None and not turned.isSame(FreeCAD.Rotation(), 1e-12)
        if place.name and (place.at is None or not is_turned):
            return f"{owner}.{place.name}"
        known, value = self.of(place.body), self.written(place.at)
        is_origin = not set(value) - set("[0, ]")
        if place.is_whole and is_origin and not is_turned:
            return owner
        if is_turned:
            x, z = (turned.multVec(FreeCAD.Vector(*unit)) for unit in ((1, 0, 0), (0, 0, 1)))
            value = f"{{ at = {value}, x = {vector((x.x, x.y, x.z))}, z = {vector((z.x, z.y, z.z))} }}"
        same = (name for name, row in known.items() if row[0] == value)
        name = next(same, None)
        if name is None:
            names = (wanted, *(f"{wanted}_{number}" for number in range(2, len(known) + 3)))
            name = next(one for one in names if one not in known)
            known[name] = (value, obj, place.at)
        return f"{owner}.{name}"


def typed_points(obj):
    """Names and values in the typed `points` of a body or the ground."""
    text = elements.text(obj, "points")
    if not (text.startswith("{") and text.endswith("}")):
        return []
    pairs = (pair.partition("=") for pair in split(text[1:-1]))
    return [(name.strip(), written(value)) for name, _, value in pairs]


def from_places(obj, points):
    """What the drawing gives for the keys of a joint or load."""
    kind, given = elements.kind_of(obj), {}
    if not kind.places or kind.section == "points":
        return given
    found = [end for end in frames.ends(obj) if end.at is not None or end.name]
    if kind.key("axis") and not elements.text(obj, "axis") and not elements.text(obj, "direction"):
        axis = frames.axis(obj, found)
        if axis:
            given["axis"] = vector((axis.x, axis.y) if points.is_planar else (axis.x, axis.y, axis.z), number)
    if kind.key("between") and not elements.text(obj, "between") and len(found) == 2:
        first, second = found
        x_first, x_second = (frames.x_ground_from_body(end.body) if end.body else FreeCAD.Placement() for end in found)
        turn = x_second.inverse().Rotation * x_first.Rotation
        is_joint = kind.section == "joints"
        names = [
            points.name(first, obj.ElementName, obj),
            points.name(second, obj.ElementName, obj, turn if is_joint and not points.is_planar else None),
        ]
        given["between"] = "[" + ", ".join(f'"{name}"' for name in names) + "]"
        angle = -geometry.angle_of(FreeCAD.Placement(FreeCAD.Vector(), turn))
        if (
            is_joint
            and points.is_planar
            and kind.key("angle")
            and not elements.text(obj, "angle")
            and abs(angle) > 1e-12
        ):
            given["angle"] = f'"{angle!r} rad"'
    if kind.key("on") and not elements.text(obj, "between") and not elements.text(obj, "on") and len(found) == 1:
        given["on"] = f'"{points.name(found[0], obj.ElementName, obj)}"'
    return given


def unit(doc, of):
    """The unit of bare masses, lengths or times."""
    units = elements.find(doc, "units")
    return (elements.text(units, of) if units else "") or DEFAULT_UNITS[of]


class Named:
    """Parameters for what the drawing gives, so that equations have a name for it."""

    def __init__(self, doc):
        self.taken, self.rows = {obj.ElementName for obj in elements.all_of(doc)}, []

    def name(self, obj, key, value):
        """The expression for a key of a body: a parameter, or the value itself where the name is taken."""
        wanted = f"{obj.ElementName}_{key}"
        if wanted in self.taken or not wanted.isidentifier():
            return value
        self.rows.append((wanted, f'"{value}"', obj, key))
        return wanted


def drawn_mass(obj, drawn):
    """The mass of parts of a density, as an expression."""
    doc, size = obj.Document, f"{drawn.size!r} mm^{drawn.dimension}"
    density = with_unit(elements.text(obj, "density"), f"{unit(doc, 'mass')}/{unit(doc, 'length')}^3")
    if drawn.dimension == 3:
        return f"{density}*{size}"
    return f"{density}*{with_unit(elements.text(obj, 'thickness') or '0', unit(doc, 'length'))}*{size}"


def from_parts(obj, is_planar, named):
    """What the parts of a body give for the keys that are left empty."""
    if not obj.Parts or not obj.FromDrawing:
        return {}
    doc, given = obj.Document, {}
    x_now = displaced(obj, elements.mechanism(doc).Plane * frames.x_ground_from_body(obj))
    drawn = geometry.extent(obj.Parts, x_now)
    if drawn is None:
        return {}
    mass = elements.text(obj, "mass")
    if not mass and elements.text(obj, "density") and drawn.dimension > 1:
        mass = named.name(obj, "mass", drawn_mass(obj, drawn))
        given |= {"mass": f'"{mass}"', "density": "", "thickness": ""}
    if mass and not elements.text(obj, "com"):
        given["com"] = vector(tuple(drawn.centre)[: 2 if is_planar else 3], length)
    if mass and not elements.text(obj, "inertia"):
        moments = [f"{with_unit(mass, unit(doc, 'mass'))}*({moment!r} mm^2)" for moment in drawn.moments]
        if is_planar:
            given["inertia"] = f'"{named.name(obj, "inertia", moments[2])}"'
        else:
            given["inertia"] = "[" + ", ".join(f'"{moment}"' for moment in moments) + "]"
    if is_planar and not elements.text(obj, "outline") and not elements.text(obj, "shapes"):
        polygons = geometry.outlines(obj.Parts, x_now)
        if polygons:
            rows = ["[" + ", ".join(vector(corner, length) for corner in polygon) + "]" for polygon in polygons]
            given["outline"] = "[" + ", ".join(rows) + "]"
    return given


def displaced(obj, x_world_from_body):
    """Where the frame of a body is now: its parts may have moved from where they are drawn."""
    first = obj.Parts[0]
    return geometry.pose(first) * frames.home(obj, first).inverse() * x_world_from_body


def guess(obj, is_planar):
    """The drawn pose of a body as a guess of its start: keys with values."""
    if not obj.Parts or not obj.FromDrawing:
        return {}
    pose, found = frames.x_ground_from_body(obj), {}
    if not elements.text(obj, "com"):
        drawn = geometry.extent(obj.Parts, displaced(obj, elements.mechanism(obj.Document).Plane * pose))
        if drawn is not None:
            at = pose.multVec(drawn.centre)
            found = {name: length(getattr(at, name)) for name in ("xy" if is_planar else "xyz")}
    if is_planar:
        return found | {"angle": f'"{geometry.angle_of(pose)!r} rad"'}
    x, y, z, w = pose.Rotation.Q
    return found | {"quaternion": vector((w, x, y, z))}


def start_rows(doc, is_planar):
    """Rows of `[initial]`: stated with joints and bodies, guessed from the drawing, and those of their own."""
    for section in kinds.WITH_START:
        for obj in elements.all_of(doc, section):
            stated = elements.text(obj, "initial")
            pairs = split(stated[1:-1] if stated.startswith("{") and stated.endswith("}") else stated)
            guessed = guess(obj, is_planar) if section == "bodies" else {}
            names = {pair.partition("=")[0].strip() for pair in pairs}
            left = [f"{key} = {value}" for key, value in guessed.items() if key not in names]
            rows = [written_pair(pair) for pair in pairs]
            if left and "guess" not in names:
                rows.append("guess = { " + ", ".join(left) + " }")
            if rows:
                yield obj.ElementName, "{ " + ", ".join(rows) + " }", obj, "initial"
    for obj in elements.all_of(doc, "initial"):
        yield obj.ElementName, written(elements.text(obj, "value")), obj, "value"


def write_keys(text, obj, given):
    """The keys of an element: typed ones, else those that the drawing gives; an empty one is left out."""
    for key in elements.kind_of(obj).keys:
        value = given.get(key.name, written(elements.text(obj, key.name)) if elements.text(obj, key.name) else "")
        if value and key.name != "initial":
            text.write(f"{key.name} = {value}", obj, key.name)


def write_table(text, obj, given):
    """One table with its header."""
    kind = elements.kind_of(obj)
    text.header(f"{kind.section}.{key_text(obj.ElementName)}" if kind.form == "table" else kind.section, obj)
    if kind.type:
        text.write(f'type = "{kind.type}"', obj, "type")
    write_keys(text, obj, given)


def points_text(rows, probes):
    """The key `points` of a body."""
    pairs = [f"{key_text(name)} = {row[0]}" for name, row in rows.items()]
    pairs += [f"{name} = {value}" for name, value in probes.items()]
    return "{ " + ", ".join(pairs) + " }" if pairs else ""


def generate(doc, probes=None, solve=None):
    """The model of a document as a `Text`.

    `probes` adds points to bodies, by the names of the bodies; `solve` replaces keys of `[solve]`.
    """
    points, probes, text, named = Points(doc), probes or {}, Text(), Named(doc)
    given = {}
    for section in ("joints", "loads"):
        for obj in elements.all_of(doc, section):
            given[obj.Name] = from_places(obj, points)
    for obj in elements.all_of(doc, "bodies"):
        given[obj.Name] = from_parts(obj, points.is_planar, named)
        given[obj.Name]["points"] = points_text(points.of(obj), probes.get(obj.ElementName, {}))
    for obj in elements.all_of(doc, "ground"):
        given[obj.Name] = {"points": points_text(points.of(None), {})}
    for obj in elements.all_of(doc, "solve"):
        given[obj.Name] = solve or {}
    for obj in elements.all_of(doc, "model"):
        write_keys(text, obj, {})
    sections = dict.fromkeys(kind.section for kind in kinds.all_kinds().values())
    for section in sections:
        found, form = elements.all_of(doc, section), kinds.of_section(section)[0].form
        if section == "initial":
            write_rows(text, section, list(start_rows(doc, points.is_planar)))
        elif form == "row":
            rows = ((obj.ElementName, written(elements.text(obj, "value")), obj, "value") for obj in found)
            write_rows(text, section, [*rows, *(named.rows if section == "parameters" else [])])
        elif section == "ground" and not found and points.of(None):
            text.header("ground")
            text.write(f"points = {points_text(points.of(None), {})}")
        elif section == "solve" and not found and solve:
            text.header("solve")
            for key, value in solve.items():
                if value:
                    text.write(f"{key} = {value}")
        elif form in ("table", "single"):
            for obj in found:
                write_table(text, obj, given.get(obj.Name, {}))
    return text


def write_rows(text, section, rows):
    """A section of rows."""
    if rows:
        text.header(section)
    for name, value, obj, key in rows:
        text.write(f"{key_text(name)} = {value}", obj, key)
