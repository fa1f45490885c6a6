//! Bodies: bars, plates, blocks, wheels and lines, with the pins on each.

use std::collections::BTreeSet;

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{between, distance, sub};
use bksim_cad::read::Dash;

use super::hatching::Plate;
use super::loops::{Form, pairs};
use super::pieces::{Line, Pieces, Ring, area, is_inside, skew, to_border, to_segment, unit};

/// A pin: circles about one centre.
#[derive(Clone, Debug)]
pub(super) struct Pin {
    pub(super) at: Point,
    /// Radii of its circles, ascending.
    pub(super) radii: Vec<f64>,
    pub(super) from: Vec<usize>,
}

impl Pin {
    pub(super) fn reach(&self) -> f64 {
        self.radii.last().copied().unwrap_or_default()
    }
}

/// Way in which a body is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Look {
    /// A bar with a middle line.
    Bar,
    /// An outline around pins.
    Plate,
    /// A rectangle.
    Block,
    /// Circles about a pin.
    Wheel,
    /// Lines that are joined.
    Lines,
}

impl Look {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bar => "bar",
            Self::Plate => "plate",
            Self::Block => "block",
            Self::Wheel => "wheel",
            Self::Lines => "lines",
        }
    }
}

/// A body.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) look: Look,
    /// Border of the body, where it has one.
    pub(super) border: Vec<Point>,
    /// Straight edges and lines.
    pub(super) segments: Vec<[Point; 2]>,
    /// Centre of a wheel and radii of its pitch circles, or of the circle that it is drawn as.
    pub(super) wheel: Option<(Point, Vec<f64>)>,
    pub(super) pins: BTreeSet<usize>,
    pub(super) from: Vec<usize>,
    pub(super) name: String,
}

impl Body {
    pub(super) fn new(look: Look, from: Vec<usize>) -> Self {
        Self {
            look,
            border: Vec::new(),
            segments: Vec::new(),
            wheel: None,
            pins: BTreeSet::new(),
            from,
            name: String::new(),
        }
    }

    /// Area of the border; infinite without one.
    pub(super) fn size(&self) -> f64 {
        if self.border.is_empty() { f64::INFINITY } else { area(&self.border).abs() }
    }

    /// Distance of a point from what is drawn of the body.
    pub(super) fn away(&self, p: Point) -> f64 {
        let lines = self.segments.iter().map(|segment| to_segment(p, *segment));
        let border = (!self.border.is_empty()).then(|| to_border(&self.border, p));
        let wheel = self.wheel.as_ref().map(|(centre, radii)| {
            radii.iter().map(|r| (distance(*centre, p) - r).abs()).fold(f64::INFINITY, f64::min)
        });
        lines.chain(border).chain(wheel).fold(f64::INFINITY, f64::min)
    }
}

/// A slot: its middle line and half its width.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    pub(super) ends: [Point; 2],
    pub(super) half: f64,
    /// The body that has it.
    pub(super) body: usize,
    pub(super) from: Vec<usize>,
}

/// A slot whose body is not known yet: middle line, half its width, strokes, border.
type OpenSlot = ([Point; 2], f64, Vec<usize>, Vec<Point>);

/// Everything that moves.
#[derive(Clone, Default, Debug)]
pub(super) struct Bodies {
    pub(super) all: Vec<Body>,
    /// Toothed rings of the ground: centre, pitch radius, stroke.
    pub(super) rings: Vec<(Point, f64, usize)>,
    pub(super) slots: Vec<Slot>,
}

/// Circles about common centres that are small enough for pins; larger ones remain.
pub(super) fn pins(pieces: &Pieces) -> Vec<Pin> {
    let mut pins: Vec<Pin> = Vec::new();
    let small =
        pieces.circles.iter().filter(|c| c.dash == Dash::Solid && c.radius < 3.2 * pieces.pin);
    for circle in small {
        match pins.iter_mut().find(|pin| distance(pin.at, circle.centre) < pieces.tolerance) {
            Some(pin) => {
                pin.radii.push(circle.radius);
                pin.from.push(circle.from);
            }
            None => pins.push(Pin {
                at: circle.centre,
                radii: vec![circle.radius],
                from: vec![circle.from],
            }),
        }
    }
    for pin in &mut pins {
        pin.radii.sort_by(f64::total_cmp);
    }
    pins
}

/// Lines across a pin that mark its centre.
pub(super) fn take_centre_marks(pieces: &mut Pieces, pins: &[Pin]) {
    let near = pieces.tolerance;
    for line in &mut pieces.lines {
        let middle = line.middle();
        let is_mark = |pin: &Pin| {
            distance(pin.at, middle) < near
                && line.length() < 4.4 * pin.radii[0].max(0.6 * pin.reach())
        };
        line.is_used |= pins.iter().any(is_mark);
    }
}

/// Finds all bodies.
pub(super) fn bodies(
    pieces: &mut Pieces,
    pins: &[Pin],
    plates: &[Plate],
    is_fixed: &[bool],
) -> Bodies {
    let mut found = Bodies::default();
    let tolerance = pieces.tolerance;
    let mut slots: Vec<OpenSlot> = Vec::new();
    for plate in plates {
        add_plate(&mut found, pieces, pins, plate);
    }
    for ring in &mut pieces.rings {
        if ring.is_used || area(&ring.points).abs() < pieces.pin * pieces.pin {
            continue;
        }
        ring.is_used = true;
        match ring.form() {
            Form::Round { ends, half } => {
                let at_end =
                    |end: Point| pins.iter().any(|pin| distance(pin.at, end) < 1.5 * tolerance);
                if !at_end(ends[0]) && !at_end(ends[1]) && half < 3.5 * pieces.pin {
                    slots.push((ends, half, ring.from.clone(), ring.points.clone()));
                    continue;
                }
                found.all.push(of_ring(ring, Look::Bar));
                let body = found.all.last_mut().expect("just pushed");
                body.segments.push(ends);
                let on = |pin: &Pin| to_segment(pin.at, ends) < 1.3 * tolerance;
                body.pins = (0..pins.len()).filter(|&idx| on(&pins[idx])).collect();
            }
            form => {
                let look = if matches!(form, Form::Box { .. }) { Look::Block } else { Look::Plate };
                if let Form::Box { ends, half } = form {
                    let is_narrow = distance(ends[0], ends[1]) > 3.0 * half;
                    let fits = |pin: &Pin| {
                        to_segment(pin.at, ends) < tolerance
                            && pin.radii.iter().any(|r| (0.75..1.1).contains(&(r / half)))
                    };
                    if is_narrow && half < 2.0 * pieces.pin && pins.iter().any(fits) {
                        slots.push((ends, half, ring.from.clone(), ring.points.clone()));
                        continue;
                    }
                }
                found.all.push(of_ring(ring, look));
                let body = found.all.last_mut().expect("just pushed");
                let holds = |pin: &Pin| {
                    is_inside(&body.border, pin.at)
                        || to_border(&body.border, pin.at) < 1.2 * tolerance
                };
                let inside = (0..pins.len()).filter(|&idx| holds(&pins[idx])).collect();
                body.pins = inside;
            }
        }
    }
    add_pairs(&mut found, pieces, pins);
    add_triangles(&mut found, pieces, pins, is_fixed);
    add_lines(&mut found, pieces, pins);
    for (ends, half, from, points) in slots {
        let holders = found.all.iter().enumerate().filter(|(_, body)| {
            !body.border.is_empty() && points.iter().all(|p| is_inside(&body.border, *p))
        });
        let holder = holders.min_by(|a, b| a.1.size().total_cmp(&b.1.size())).map(|(idx, _)| idx);
        let body = holder.unwrap_or_else(|| {
            let mut body = Body::new(Look::Bar, from.clone());
            body.border.clone_from(&points);
            found.all.push(body);
            found.all.len() - 1
        });
        found.slots.push(Slot { ends, half, body, from });
    }
    found
}

fn of_ring(ring: &Ring, look: Look) -> Body {
    let mut body = Body::new(look, ring.from.clone());
    body.border.clone_from(&ring.points);
    body.segments.clone_from(&ring.sides);
    body
}

fn add_plate(found: &mut Bodies, pieces: &mut Pieces, pins: &[Pin], plate: &Plate) {
    let near = 1.5 * pieces.tolerance;
    let mut body = Body::new(Look::Plate, Vec::new());
    body.border.clone_from(&plate.points);
    let on_border = |p: Point| to_border(&plate.points, p) < near;
    for line in pieces.lines.iter_mut().filter(|line| !line.is_used) {
        if line.ends.iter().all(|p| on_border(*p)) && on_border(line.middle()) {
            line.is_used = true;
            body.from.extend(line.from.clone());
        }
    }
    let size = area(&plate.points).abs();
    for ring in pieces.rings.iter_mut().filter(|ring| !ring.is_used) {
        let is_alike = (area(&ring.points).abs() / size - 1.0).abs() < 0.6;
        if is_alike
            && plate
                .points
                .iter()
                .all(|p| is_inside(&ring.points, *p) || to_border(&ring.points, *p) < near)
        {
            ring.is_used = true;
            body.from.extend(ring.from.clone());
            body.border.clone_from(&ring.points);
        }
    }
    let holds =
        |pin: &Pin| is_inside(&body.border, pin.at) || to_border(&body.border, pin.at) < near;
    body.pins = (0..pins.len()).filter(|&idx| holds(&pins[idx])).collect();
    found.all.push(body);
}

/// The pin at a point: its centre, or its border with the line towards its centre.
fn pin_at(pins: &[Pin], p: Point, toward: Point, tolerance: f64) -> Option<usize> {
    let aims = |pin: &Pin| {
        let direction = unit(sub(p, toward));
        skew(direction, sub(pin.at, p)) < tolerance
    };
    let fits = |pin: &Pin| {
        let away = distance(pin.at, p);
        away < 1.2 * tolerance || away < 1.1 * pin.reach() + tolerance && aims(pin)
    };
    let near = (0..pins.len()).filter(|&idx| fits(&pins[idx]));
    near.min_by(|&a, &b| distance(pins[a].at, p).total_cmp(&distance(pins[b].at, p)))
}

/// Bars drawn as two parallel lines from pin to pin.
fn add_pairs(found: &mut Bodies, pieces: &mut Pieces, pins: &[Pin]) {
    let tolerance = pieces.tolerance;
    for ([i, k], ends, _) in pairs(pieces) {
        if pieces.lines[i].is_used || pieces.lines[k].is_used {
            continue;
        }
        let at_end = |p: Point| pins.iter().position(|pin| distance(pin.at, p) < 1.6 * tolerance);
        if ends.iter().all(|end| at_end(*end).is_none()) || at_end(ends[0]) == at_end(ends[1]) {
            continue;
        }
        let mut body = Body::new(Look::Bar, Vec::new());
        for idx in [i, k] {
            pieces.lines[idx].is_used = true;
            body.from.extend(pieces.lines[idx].from.clone());
            body.segments.push(pieces.lines[idx].ends);
        }
        let [first, second] = [pieces.lines[i].ends, pieces.lines[k].ends];
        let is_along = distance(first[1], second[1]) < distance(first[1], second[0]);
        let second = if is_along { second } else { [second[1], second[0]] };
        body.border = vec![first[0], first[1], second[1], second[0]];
        body.segments.push(ends);
        let on = |pin: &Pin| to_segment(pin.at, ends) < 1.6 * tolerance;
        body.pins = (0..pins.len()).filter(|&idx| on(&pins[idx])).collect();
        found.all.push(body);
    }
}

/// Plates drawn as three lines between three pins.
fn add_triangles(found: &mut Bodies, pieces: &mut Pieces, pins: &[Pin], is_fixed: &[bool]) {
    let spans: Vec<(usize, [usize; 2])> = (0..pieces.lines.len())
        .filter(|&idx| !pieces.lines[idx].is_used)
        .filter_map(|idx| {
            let [a, b] = pieces.lines[idx].ends;
            let ends =
                [pin_at(pins, a, b, pieces.tolerance)?, pin_at(pins, b, a, pieces.tolerance)?];
            let is_frame = is_fixed[ends[0]] && is_fixed[ends[1]];
            (ends[0] != ends[1] && !is_frame).then_some((idx, ends))
        })
        .collect();
    let other =
        |[a, b]: [usize; 2], pin: usize| if a == pin { Some(b) } else { (b == pin).then_some(a) };
    for (n, &(first, [a, b])) in spans.iter().enumerate() {
        for &(second, second_ends) in &spans[n + 1..] {
            let Some((c, from)) =
                other(second_ends, a).map(|c| (c, b)).or(other(second_ends, b).map(|c| (c, a)))
            else {
                continue;
            };
            let closes =
                |&&(_, ends): &&(usize, [usize; 2])| ends.contains(&c) && ends.contains(&from);
            let Some(&(third, _)) =
                spans[n + 1..].iter().filter(|(idx, _)| *idx != second).find(closes)
            else {
                continue;
            };
            let all = [first, second, third];
            if all.iter().any(|&idx| pieces.lines[idx].is_used) {
                continue;
            }
            let mut body = Body::new(Look::Plate, Vec::new());
            for idx in all {
                pieces.lines[idx].is_used = true;
                body.from.extend(pieces.lines[idx].from.clone());
                body.segments.push(pieces.lines[idx].ends);
            }
            body.border = [a, b, c].map(|pin| pins[pin].at).to_vec();
            body.pins = [a, b, c].into_iter().collect();
            found.all.push(body);
        }
    }
}

/// Links drawn as lines and bows; those that touch are one body, and one with an outline on which they end.
fn add_lines(found: &mut Bodies, pieces: &mut Pieces, pins: &[Pin]) {
    let tolerance = pieces.tolerance;
    let parts = parts(pieces);
    let at_pin = |p: Point| pins.iter().any(|pin| distance(pin.at, p) < 1.2 * tolerance);
    let mut group: Vec<usize> = (0..parts.len()).collect();
    for i in 0..parts.len() {
        for k in 0..i {
            let is_chain = parts[i].chain == parts[k].chain;
            let touches = |a: &Part, b: &Part| {
                let ends = [a.points[0], a.points[a.points.len() - 1]];
                ends.iter().any(|end| b.away(*end) < tolerance && !at_pin(*end))
            };
            if (is_chain || touches(&parts[i], &parts[k]) || touches(&parts[k], &parts[i]))
                && group[i] != group[k]
            {
                let (from, to) = (group[i], group[k]);
                group.iter_mut().filter(|it| **it == from).for_each(|it| *it = to);
            }
        }
    }
    let n_outlines = found.all.len();
    let mut names: Vec<usize> = group.clone();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let members: Vec<&Part> =
            (0..parts.len()).filter(|&k| group[k] == name).map(|k| &parts[k]).collect();
        let mut body = Body::new(Look::Lines, Vec::new());
        let mut touched = BTreeSet::new();
        for part in &members {
            body.from.extend(part.from.clone());
            body.segments.extend(part.points.windows(2).map(|pair| [pair[0], pair[1]]));
            let n = part.points.len();
            for (end, inner) in
                [(part.points[0], part.points[1]), (part.points[n - 1], part.points[n - 2])]
            {
                body.pins.extend(pin_at(pins, end, inner, tolerance));
                let outlines = found.all[..n_outlines].iter().enumerate();
                if !at_pin(end) {
                    touched.extend(
                        outlines
                            .filter(|(_, it)| it.away(end) < 0.8 * tolerance)
                            .map(|(idx, _)| idx),
                    );
                }
            }
            let on = |pin: &Pin| part.away(pin.at) < 1.1 * tolerance;
            body.pins.extend((0..pins.len()).filter(|&idx| on(&pins[idx])));
        }
        // What ends on the border of one outline only belongs to that body.
        let owner = touched.iter().next().copied().filter(|_| touched.len() == 1);
        match owner {
            Some(owner) if body.pins.len() < 2 => {
                let into = &mut found.all[owner];
                into.segments.extend(body.segments);
                into.from.extend(body.from);
                into.pins.extend(body.pins);
            }
            _ => found.all.push(body),
        }
    }
    pieces.lines.iter_mut().for_each(|line| line.is_used = true);
}

/// A line or bow as points.
struct Part {
    points: Vec<Point>,
    from: Vec<usize>,
    chain: usize,
}

impl Part {
    fn away(&self, p: Point) -> f64 {
        self.points
            .windows(2)
            .map(|pair| to_segment(p, [pair[0], pair[1]]))
            .fold(f64::INFINITY, f64::min)
    }
}

fn parts(pieces: &Pieces) -> Vec<Part> {
    // A line that lies on a longer one and shares no pin with its end repeats it.
    let repeats = |line: &Line| {
        let covers = |other: &Line| {
            other.length() > line.length() + pieces.tolerance
                && line.ends.iter().all(|p| other.away(*p) < 0.7 * pieces.tolerance)
        };
        pieces.lines.iter().any(|other| !other.is_used && covers(other))
    };
    let lines = pieces.lines.iter().filter(|line| !line.is_used && !repeats(line)).map(|line| {
        Part { points: line.ends.to_vec(), from: line.from.clone(), chain: line.chain }
    });
    let bows = pieces.bows.iter().filter(|bow| !bow.is_used).map(|bow| Part {
        points: bow.points.clone(),
        from: vec![bow.from],
        chain: bow.from,
    });
    lines.chain(bows).collect()
}

/// Middle of a body, where its name is written.
pub(super) fn anchor(body: &Body) -> Point {
    if let Some((centre, _)) = &body.wheel {
        return *centre;
    }
    if !body.border.is_empty() {
        return super::pieces::middle(&body.border);
    }
    let longest =
        body.segments.iter().max_by(|a, b| distance(a[0], a[1]).total_cmp(&distance(b[0], b[1])));
    longest.map_or([0.0; 2], |[a, b]| between(*a, *b, 0.5))
}
