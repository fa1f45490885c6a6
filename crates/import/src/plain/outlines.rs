//! Outlines of the shapes of SVG: lines, arcs and splines in the units of the shape.

use std::f64::consts::TAU;

use bksim_cad::geometry::vector::{along, cross, direction, distance, dot, norm, sub};
use bksim_cad::geometry::{Curve, Path, Point, Spline};
use kurbo::{Arc, SvgArc, Vec2};
use roxmltree::Node;
use svgtypes::{PathParser, PathSegment, PointsParser};

/// Part of a radius by which a curve of Bézier that is meant as an arc misses it: a quarter of a circle does by 2.7e-4.
const ROUND: f64 = 6e-4;

/// Outlines of an element, whose lengths `length` reads; `None` of what is no shape.
pub(super) fn paths(node: Node<'_, '_>, length: &dyn Fn(&str) -> Option<f64>) -> Option<Vec<Path>> {
    let number = |name: &str| length(name).unwrap_or_default();
    Some(match node.tag_name().name() {
        "line" => {
            let [from, to] = [["x1", "y1"], ["x2", "y2"]].map(|names| names.map(number));
            vec![Path::of(Curve::Segment { from, to })]
        }
        "polyline" | "polygon" => {
            let points = PointsParser::from(node.attribute("points").unwrap_or_default());
            let mut pen = Pen::default();
            points.for_each(|(x, y)| pen.line_to([x, y]));
            if node.tag_name().name() == "polygon" {
                pen.close();
            }
            pen.finish()
        }
        "circle" => {
            let centre = ["cx", "cy"].map(number);
            vec![ellipse(centre, [number("r"); 2])]
        }
        "ellipse" => vec![ellipse(["cx", "cy"].map(number), ["rx", "ry"].map(number))],
        "rect" => vec![rectangle(&number, [length("rx"), length("ry")])],
        "path" => along_path(node.attribute("d").unwrap_or_default()),
        _ => return None,
    })
}

/// An arrow as a triangle with this length.
pub(super) fn arrow(tip: Point, inner: Point, size: f64) -> Path {
    let back = sub(inner, tip);
    let back = [0, 1].map(|k| back[k] / norm(back).max(f64::MIN_POSITIVE));
    let foot = along(tip, size, back);
    let corners = [along(foot, 0.2 * size, [-back[1], back[0]]), tip];
    let mut pen = Pen::default();
    pen.line_to(along(foot, -0.2 * size, [-back[1], back[0]]));
    for corner in corners {
        pen.line_to(corner);
    }
    pen.close();
    pen.finish().pop().unwrap_or_default()
}

fn ellipse(centre: Point, [rx, ry]: [f64; 2]) -> Path {
    if (rx - ry).abs() <= ROUND * rx {
        return Path::circle(centre, rx);
    }
    let (major, minor) = ([rx, 0.0], [0.0, ry]);
    let curve = Curve::Ellipse { centre, major, minor, start: 0.0, sweep: TAU };
    Path { curves: vec![curve], is_closed: true }
}

fn rectangle(number: &dyn Fn(&str) -> f64, radii: [Option<f64>; 2]) -> Path {
    let ([x, y], [w, h]) = (["x", "y"].map(number), ["width", "height"].map(number));
    let [rx, ry] = match radii {
        [None, None] => [0.0; 2],
        [Some(r), None] | [None, Some(r)] => [r; 2],
        [Some(rx), Some(ry)] => [rx, ry],
    };
    let [rx, ry] = [rx.clamp(0.0, 0.5 * w.max(0.0)), ry.clamp(0.0, 0.5 * h.max(0.0))];
    let mut pen = Pen::default();
    let corners = [
        ([x + w - rx, y], [x + w, y + ry]),
        ([x + w, y + h - ry], [x + w - rx, y + h]),
        ([x + rx, y + h], [x, y + h - ry]),
        ([x, y + ry], [x + rx, y]),
    ];
    pen.line_to([x + rx, y]);
    for (before, after) in corners {
        pen.line_to(before);
        if rx > 0.0 && ry > 0.0 {
            pen.arc_to([rx, ry], 0.0, [false, true], after);
        }
    }
    pen.close();
    pen.finish().pop().unwrap_or_default()
}

/// The pen on its way: outlines that are drawn, and the one under way.
#[derive(Default)]
struct Pen {
    done: Vec<Path>,
    curves: Vec<Curve>,
    first: Option<Point>,
    at: Point,
}

impl Pen {
    fn move_to(&mut self, to: Point) {
        self.end(false);
        (self.first, self.at) = (Some(to), to);
    }

    fn line_to(&mut self, to: Point) {
        if self.first.is_none() {
            return self.move_to(to);
        }
        if to != self.at {
            self.curves.push(Curve::Segment { from: self.at, to });
        }
        self.at = to;
    }

    fn arc_to(&mut self, radii: Point, turn: f64, [is_large, is_positive]: [bool; 2], to: Point) {
        let [from, end] = [self.at, to].map(|[x, y]| kurbo::Point::new(x, y));
        let svg = SvgArc {
            from,
            to: end,
            radii: Vec2::new(radii[0], radii[1]),
            x_rotation: turn,
            large_arc: is_large,
            sweep: is_positive,
        };
        let Some(arc) = Arc::from_svg_arc(&svg) else { return self.line_to(to) };
        let centre = [arc.center.x, arc.center.y];
        let [rx, ry] = [arc.radii.x, arc.radii.y];
        let (start, sweep) = (arc.start_angle, arc.sweep_angle);
        self.curves.push(if (rx - ry).abs() <= ROUND * rx {
            Curve::Arc { centre, radius: rx, start: start + arc.x_rotation, sweep }
        } else {
            let [cos, sin] = direction(arc.x_rotation);
            let (major, minor) = ([rx * cos, rx * sin], [-ry * sin, ry * cos]);
            Curve::Ellipse { centre, major, minor, start, sweep }
        });
        self.at = to;
    }

    /// A curve of Bézier: a line, an arc, or a spline.
    fn curve_to(&mut self, [a, b, to]: [Point; 3]) {
        let control = vec![self.at, a, b, to];
        let length = distance(self.at, to);
        let is_between =
            |p: &Point| cross(sub(to, self.at), sub(*p, self.at)).abs() <= 1e-6 * length * length;
        if length > 0.0 && [a, b].iter().all(is_between) {
            return self.line_to(to);
        }
        let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        let spline = Spline { degree: 3, knots, control, weights: vec![1.0; 4] };
        self.curves.push(as_arc(&spline).unwrap_or(Curve::Spline(spline)));
        self.at = to;
    }

    fn close(&mut self) {
        if let Some(first) = self.first {
            self.line_to(first);
        }
        let first = self.first;
        self.end(true);
        (self.first, self.at) = (first, first.unwrap_or_default());
    }

    fn end(&mut self, is_closed: bool) {
        let curves = merged(std::mem::take(&mut self.curves));
        let meets = |curves: &[Curve]| {
            let ends = curves.first().zip(curves.last());
            ends.is_some_and(|(first, last)| {
                distance(first.start_point(), last.end_point())
                    <= 1e-9 * (1.0 + norm(first.start_point()))
            })
        };
        let is_closed = is_closed || curves.len() > 1 && meets(&curves) || is_whole(&curves);
        if !curves.is_empty() {
            self.done.push(Path { curves, is_closed });
        }
    }

    fn finish(mut self) -> Vec<Path> {
        self.end(false);
        self.done
    }
}

fn is_whole(curves: &[Curve]) -> bool {
    matches!(curves, [Curve::Arc { sweep, .. }] if (sweep.abs() - TAU).abs() < 1e-9)
}

/// A curve of Bézier as an arc, if it is one but for its thickness.
fn as_arc(spline: &Spline) -> Option<Curve> {
    let [a, b, c] = [0.0, 0.5, 1.0].map(|t| spline.point(t));
    let (u, v) = (sub(b, a), sub(c, a));
    let twice = 2.0 * cross(u, v);
    let [uu, vv] = [dot(u, u), dot(v, v)];
    if twice.abs() <= 1e-6 * uu.max(vv) {
        return None;
    }
    let centre = [a[0] + (v[1] * uu - u[1] * vv) / twice, a[1] + (u[0] * vv - v[0] * uu) / twice];
    let radius = distance(a, centre);
    let is_on = |t: f64| (distance(spline.point(t), centre) - radius).abs() <= ROUND * radius;
    if ![0.1, 0.25, 0.75, 0.9].into_iter().all(is_on) {
        return None;
    }
    let angle = |p: Point| (p[1] - centre[1]).atan2(p[0] - centre[0]);
    let half = |from: f64, to: f64| (to - from + 1.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
    let sweep = half(angle(a), angle(b)) + half(angle(b), angle(c));
    Some(Curve::Arc { centre, radius, start: angle(a), sweep })
}

/// Curves with arcs about one centre that follow each other made one.
fn merged(curves: Vec<Curve>) -> Vec<Curve> {
    let mut out: Vec<Curve> = Vec::new();
    for curve in curves {
        if let (
            Some(Curve::Arc { centre: known, radius, sweep: so_far, .. }),
            Curve::Arc { centre, radius: other, sweep, .. },
        ) = (out.last_mut(), &curve)
        {
            let near = 2.0 * ROUND * *radius;
            let total = *so_far + sweep;
            if distance(*known, *centre) <= near
                && (*radius - other).abs() <= near
                && *so_far * sweep > 0.0
                && total.abs() <= TAU + 0.01
            {
                *so_far =
                    if (total.abs() - TAU).abs() < 0.01 { TAU * total.signum() } else { total };
                continue;
            }
        }
        out.push(curve);
    }
    out
}

/// Outlines of the data of a path, up to what cannot be read.
fn along_path(data: &str) -> Vec<Path> {
    let mut pen = Pen::default();
    // The control point that a smooth curve reflects, of a cubic and of a quadratic one.
    let mut last: [Option<Point>; 2] = [None; 2];
    for segment in PathParser::from(data).map_while(Result::ok) {
        let at = pen.at;
        let from = |abs: bool, [x, y]: Point| if abs { [x, y] } else { [at[0] + x, at[1] + y] };
        let mirrored = |control: Option<Point>| {
            control.map_or(at, |[x, y]| [2.0 * at[0] - x, 2.0 * at[1] - y])
        };
        let [cubic, quadratic] = std::mem::take(&mut last);
        let mut smooth = |pen: &mut Pen, control: Point, to: Point| {
            let third = |end: Point| along(end, 2.0 / 3.0, sub(control, end));
            pen.curve_to([third(at), third(to), to]);
            last[1] = Some(control);
        };
        match segment {
            PathSegment::MoveTo { abs, x, y } => pen.move_to(from(abs, [x, y])),
            PathSegment::LineTo { abs, x, y } => pen.line_to(from(abs, [x, y])),
            PathSegment::HorizontalLineTo { abs, x } => {
                pen.line_to([from(abs, [x, 0.0])[0], at[1]]);
            }
            PathSegment::VerticalLineTo { abs, y } => pen.line_to([at[0], from(abs, [0.0, y])[1]]),
            PathSegment::CurveTo { abs, x1, y1, x2, y2, x, y } => {
                let control = [[x1, y1], [x2, y2], [x, y]].map(|p| from(abs, p));
                pen.curve_to(control);
                last[0] = Some(control[1]);
            }
            PathSegment::SmoothCurveTo { abs, x2, y2, x, y } => {
                let [second, to] = [[x2, y2], [x, y]].map(|p| from(abs, p));
                pen.curve_to([mirrored(cubic), second, to]);
                last[0] = Some(second);
            }
            PathSegment::Quadratic { abs, x1, y1, x, y } => {
                smooth(&mut pen, from(abs, [x1, y1]), from(abs, [x, y]));
            }
            PathSegment::SmoothQuadratic { abs, x, y } => {
                smooth(&mut pen, mirrored(quadratic), from(abs, [x, y]));
            }
            PathSegment::EllipticalArc { abs, rx, ry, x_axis_rotation, large_arc, sweep, x, y } => {
                let turn = x_axis_rotation.to_radians();
                pen.arc_to([rx, ry], turn, [large_arc, sweep], from(abs, [x, y]));
            }
            PathSegment::ClosePath { .. } => pen.close(),
        }
    }
    pen.finish()
}
