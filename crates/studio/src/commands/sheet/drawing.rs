//! Drawings of a mechanism to scale: with the lengths of its links, and with the forces at its pins.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use bksim::Mechanism;
use bksim::model::file::ShownUnits;
use bksim::model::{Anchor, Parameter};
use bksim::report::six_digits;
use bksim::sim::run::Unreplayed;
use bksim_cli::output::number;
use bksim_plot::{ROOM, Size};
use bksim_scene::{Camera, MarkerKind, StandardView, Theme, picture, svg};
use bksim_view::show::{Show, ShowOptions};

use super::CaseRun;

/// Pixels of 1/96 inch in a metre.
const PER_METRE: f64 = 96.0 / 0.0254;
/// The scales of drawings: paper to nature.
const SCALES: [f64; 3] = [5.0, 2.0, 1.0];
/// Space for dimensions around a mechanism, px.
const EDGE: f64 = 56.0;
/// Largest height of a drawing over its width.
const HIGHEST: f64 = 0.9;
/// Distance of a dimension from its link, its letters and its arrowheads, px.
const AWAY: f64 = 20.0;
const LETTERS: f64 = 10.0;
const HEAD: f64 = 6.0;

/// A drawing with its scale in words.
pub(super) struct Drawing {
    pub(super) svg: String,
    pub(super) size: Size,
    pub(super) scale: String,
}

/// The largest of 5, 2 and 1 times a power of ten that is at most `most`, and in words, `1:5`.
fn standard(most: f64) -> (f64, String) {
    let ten = 10f64.powf(most.log10().floor());
    let factor = SCALES.into_iter().find(|f| f * ten <= most * (1.0 + 1e-12)).unwrap_or(1.0);
    let scale = factor * ten;
    let words = |x: f64| number(x.round());
    if scale >= 1.0 {
        (scale, format!("{}:1", words(scale)))
    } else {
        (scale, format!("1:{}", words(1.0 / scale)))
    }
}

/// The camera that shows the whole motion to a standard scale in a picture of some width.
fn camera(show: &mut Show, width: f64) -> Result<(Camera, String), Unreplayed> {
    let is_planar = show.scene().is_planar;
    let [azimuth, elevation] = StandardView::Isometric.angles_deg().map(f64::to_radians);
    let of_size = |size: [f64; 2]| {
        if is_planar { Camera::planar(size) } else { Camera::spatial(size, azimuth, elevation) }
    };
    let mut points = show.points_over_run().to_vec();
    points.extend(show.arrow_tips_over_run()?);
    let height = HIGHEST * width;
    let room = [width - 2.0 * EDGE, height - 2.0 * EDGE];
    let fit = of_size(room).fitted(points.iter().copied(), 0.0);
    let (scale, words) = standard(fit.scale / PER_METRE);
    // As high as it needs to be at this scale.
    let seen = points.iter().map(|&p| fit.project(p)[1]).filter(|y| y.is_finite());
    let (low, high) =
        seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(y), b.max(y)));
    let needed = (high - low) * scale * PER_METRE / fit.scale + 2.0 * EDGE;
    let height = if needed.is_finite() { needed.clamp(120.0, height) } else { height };
    let camera =
        Camera { scale: scale * PER_METRE, centre: fit.centre, ..of_size([width, height]) };
    Ok((camera, words))
}

/// Instants among which the pose for dimensions is chosen.
const POSES: u32 = 48;

/// The pins of the joints at the instant shown, in the order of the model; `None` of a joint without a marker.
fn pins(show: &Show) -> Vec<Option<[f64; 3]>> {
    let n = show.playback().mechanism().model.joints.len();
    let pin = |joint: usize| {
        let mut markers = show.scene().markers.iter();
        let marker = markers.find(|marker| marker.kind == MarkerKind::Joint(joint))?;
        Some(show.poses().get(marker.at.body)?.place(marker.at.position))
    };
    (0..n).map(pin).collect()
}

/// The instant at which the pins are spread over the largest area: there links hide each other least.
fn widest(show: &mut Show) -> Result<f64, Unreplayed> {
    let [first, last] = show.span();
    let (mut best, mut largest) = (first, -1.0);
    for k in 0..=POSES {
        let t = first + (last - first) * f64::from(k) / f64::from(POSES);
        show.seek(t)?;
        let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for pin in pins(show).into_iter().flatten() {
            for (end, x) in ends.iter_mut().zip(pin) {
                *end = [end[0].min(x), end[1].max(x)];
            }
        }
        let area = (ends[0][1] - ends[0][0]) * (ends[1][1] - ends[1][0]);
        // An earlier pose that is as good stays.
        if area > largest * (1.0 + 1e-6) {
            (best, largest) = (t, area);
        }
    }
    Ok(best)
}

/// The mechanism to scale, with the names of its joints and the distances of the pins of each body, in the pose that shows
/// them best; with its instant.
pub(super) fn with_dimensions(
    show: &mut Show,
    units: &ShownUnits,
) -> Result<(Drawing, f64), Unreplayed> {
    show.options = ShowOptions::default();
    let t = if show.scene().is_planar { widest(show)? } else { show.span()[0] };
    let (camera, scale) = camera(show, ROOM)?;
    show.seek(t)?;
    let mut drawn = drawn(show, &camera)?;
    let mut over = String::new();
    if show.scene().is_planar {
        over.extend(dimensions(show, units).iter().map(|it| it.svg(&camera)));
    }
    let joints = &show.playback().mechanism().model.joints;
    let mut named: Vec<([f64; 2], String)> = Vec::new();
    for (joint, pin) in joints.iter().zip(pins(show)) {
        let Some(pin) = pin else { continue };
        let [x, y, _] = camera.project(pin);
        // Joints at one place share a label.
        let near = |(at, _): &&mut ([f64; 2], String)| (at[0] - x).hypot(at[1] - y) < LETTERS;
        match named.iter_mut().find(near) {
            Some((_, names)) => names.extend([", ", joint.name.as_str()]),
            None => named.push(([x, y], joint.name.clone())),
        }
    }
    over.extend(labels(&named));
    insert(&mut drawn, &over);
    let [width, height] = camera.size;
    Ok((Drawing { svg: drawn, size: Size { width, height }, scale }, t))
}

/// Names next to their points: each at the first of four corners where it is on no other name.
fn labels(named: &[([f64; 2], String)]) -> Vec<String> {
    const CORNERS: [([f64; 2], &str); 4] = [
        ([8.0, -8.0], "start"),
        ([8.0, 16.0], "start"),
        ([-8.0, -8.0], "end"),
        ([-8.0, 16.0], "end"),
    ];
    let mut taken: Vec<[f64; 4]> = Vec::new();
    let place = |(at, name): &([f64; 2], String)| {
        let width = 0.58 * LETTERS * name.chars().count() as f64;
        let area = |([dx, dy], anchor): ([f64; 2], &str)| {
            let [x, y] = [at[0] + dx, at[1] + dy];
            let left = if anchor == "end" { x - width } else { x };
            [left, y - LETTERS, left + width, y]
        };
        let is_free = |corner: &&([f64; 2], &str)| {
            let [left, top, right, bottom] = area(**corner);
            !taken.iter().any(|b| left < b[2] && b[0] < right && top < b[3] && b[1] < bottom)
        };
        let corner = *CORNERS.iter().find(is_free).unwrap_or(&CORNERS[0]);
        taken.push(area(corner));
        let ([dx, dy], anchor) = corner;
        text_at([at[0] + dx, at[1] + dy], 0.0, anchor, name)
    };
    named.iter().map(place).collect()
}

/// The mechanism at an instant with the reactions as arrows and their sizes, in a picture of this width.
pub(super) fn with_forces(
    case: &mut CaseRun,
    t: f64,
    units: &ShownUnits,
    width: f64,
) -> Result<Drawing, Unreplayed> {
    let (reactions, contacts) = case.bearings(t)?;
    let (show, report) = (&mut case.show, &case.report);
    show.options = ShowOptions { reactions: true, ..ShowOptions::default() };
    show.seek(t)?;
    let (camera, scale) = camera(show, width)?;
    show.seek(t)?;
    let mut drawn = drawn(show, &camera)?;
    let unit = units.of("N");
    let largest = reactions.iter().map(|r| r[0].hypot(r[1]).hypot(r[2])).fold(0.0, f64::max);
    let mut words = String::new();
    let points = pins(show).into_iter().chain(contacts.into_iter().map(Some));
    for ((pin, &[fx, fy, fz, ..]), bearing) in points.zip(&reactions).zip(&report.reactions) {
        let Some(pin) = pin else { continue };
        let size = fx.hypot(fy).hypot(fz);
        if size <= 1e-9 * largest {
            continue;
        }
        let name = &bearing.name;
        let shown = six_digits(unit.of_si(size), 100.0 * unit.of_si(size));
        let text = format!("{name}: {} {}", number(shown), unit.unit);
        // Where the arrow does not go.
        let ahead = std::array::from_fn(|i| pin[i] + [fx, fy, fz][i] / size);
        let [a, b] = [pin, ahead].map(|p| camera.project(p));
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let long = dx.hypot(dy).max(f64::MIN_POSITIVE);
        let at = [a[0] - 14.0 * dx / long, a[1] - 14.0 * dy / long + 0.35 * LETTERS];
        let anchor = match dx / long {
            x if x > 0.4 => "end",
            x if x < -0.4 => "start",
            _ => "middle",
        };
        words += &text_at(at, 0.0, anchor, &text);
    }
    insert(&mut drawn, &words);
    let [width, height] = camera.size;
    Ok(Drawing { svg: drawn, size: Size { width, height }, scale })
}

fn drawn(show: &mut Show, camera: &Camera) -> Result<String, Unreplayed> {
    let extras = show.extras()?;
    Ok(svg(&picture(show.scene(), show.poses(), &extras, camera, &Theme::LIGHT)))
}

/// Puts elements at the end of a picture.
fn insert(svg: &mut String, elements: &str) {
    let end = svg.rfind("</svg>").unwrap_or(svg.len());
    svg.insert_str(end, elements);
}

/// A text with a halo, turned by an angle, rad.
fn text_at([x, y]: [f64; 2], angle: f64, anchor: &str, text: &str) -> String {
    let angle = angle.to_degrees();
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    let halo = "stroke=\"#ffffff\" stroke-width=\"3\" stroke-linejoin=\"round\"";
    let one = |paint: &str| {
        format!(
            "<text transform=\"translate({x:.2} {y:.2}) rotate({angle:.2})\" font-size=\"{LETTERS}\" text-anchor=\"{anchor}\" {paint}>{text}</text>\n"
        )
    };
    one(halo) + &one("fill=\"#1f2328\"")
}

/// A distance between two points of the world.
struct Dimension {
    ends: [[f64; 3]; 2],
    text: String,
    /// How many dimensions of the body are nearer to it.
    row: usize,
    /// The middle of the body's pins, from which the dimension stands away.
    middle: [f64; 3],
}

impl Dimension {
    fn svg(&self, camera: &Camera) -> String {
        let [a, b] = self.ends.map(|p| camera.project(p));
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let long = dx.hypot(dy);
        if long < 2.0 * HEAD {
            return String::new();
        }
        let [ux, uy] = [dx / long, dy / long];
        let m = camera.project(self.middle);
        let side = (m[0] - a[0]) * -uy + (m[1] - a[1]) * ux;
        let sign = if side > 1e-6 { -1.0 } else { 1.0 };
        let away = sign * AWAY * (1.0 + self.row as f64);
        let [nx, ny] = [-uy * away, ux * away];
        let at = |p: [f64; 3], part: f64| [p[0] + part * nx, p[1] + part * ny];
        let [p, q] = [at(a, 1.0), at(b, 1.0)];
        let mut out = String::new();
        let mut line = |from: [f64; 2], to: [f64; 2]| {
            // Writing to a text does not fail.
            let _ = writeln!(
                out,
                "<path d=\"M{:.2} {:.2}L{:.2} {:.2}\" stroke=\"#5c636b\" stroke-width=\"0.7\" fill=\"none\"/>",
                from[0], from[1], to[0], to[1]
            );
        };
        line(at(a, 0.3), at(a, 1.25));
        line(at(b, 0.3), at(b, 1.25));
        line(p, q);
        for (tip, sense) in [(p, 1.0), (q, -1.0)] {
            let back = [tip[0] + sense * HEAD * ux, tip[1] + sense * HEAD * uy];
            let half = 0.18 * HEAD;
            let _ = writeln!(
                out,
                "<path d=\"M{:.2} {:.2}L{:.2} {:.2}L{:.2} {:.2}Z\" fill=\"#5c636b\"/>",
                tip[0],
                tip[1],
                back[0] - half * uy,
                back[1] + half * ux,
                back[0] + half * uy,
                back[1] - half * ux
            );
        }
        // Read from below or from the right.
        let mut angle = uy.atan2(ux);
        if angle > FRAC_PI_2 + 1e-9 {
            angle -= std::f64::consts::PI;
        } else if angle <= -FRAC_PI_2 + 1e-9 {
            angle += std::f64::consts::PI;
        }
        let over = [angle.sin() * 3.0, -angle.cos() * 3.0];
        let middle = [0.5 * (p[0] + q[0]) + over[0], 0.5 * (p[1] + q[1]) + over[1]];
        out + &text_at(middle, angle, "middle", &self.text)
    }
}

/// The one parameter that the distance of two points of a body is: equal to it, and growing as it does. Others may be
/// as large by chance.
fn parameter_of(mechanism: &Mechanism, points: [Anchor; 2], length: f64) -> Option<&Parameter> {
    let Mechanism { model, parameters, .. } = mechanism;
    // The distance where one parameter is twice as large.
    let distance = |doubled: usize| {
        let value = |symbol| {
            let at = model.parameters.iter().position(|of| of.symbol == symbol)?;
            Some(parameters[at] * if at == doubled { 2.0 } else { 1.0 })
        };
        let number = |expr| model.pool.evaluate(expr, &value).ok();
        let place = |at: Anchor| match at.point {
            None => Some([0.0; 2]),
            Some(point) => {
                let [x, y, _] = model.bodies[at.body.0].points[point.0].position;
                Some([number(x)?, number(y)?])
            }
        };
        let [a, b] = [place(points[0])?, place(points[1])?];
        Some((b[0] - a[0]).hypot(b[1] - a[1]))
    };
    let is_near = |value: f64, expected: f64| (value - expected).abs() <= 1e-9 * expected;
    let mut same = model.parameters.iter().enumerate().filter(|&(at, of)| {
        of.unit == "m"
            && is_near(parameters[at], length)
            && distance(at).is_some_and(|found| is_near(found, 2.0 * length))
    });
    let (first, others) = (same.next(), same.next());
    first.filter(|_| others.is_none()).map(|(_, parameter)| parameter)
}

/// The distances between the pins of each body, in the order of the file.
fn dimensions(show: &Show, units: &ShownUnits) -> Vec<Dimension> {
    let mechanism = show.playback().mechanism();
    let model = &mechanism.model;
    let unit = units.of("m");
    let pins = pins(show);
    let mut found = Vec::new();
    for body in 0..model.bodies.len() {
        // A joint that slides is nowhere on its guide.
        let on_body = model.joints.iter().zip(&pins).filter(|(joint, _)| {
            let is_pin = joint.kind.is_pin();
            joint.successor.body.0 == body || is_pin && joint.predecessor.body.0 == body
        });
        let mut points: Vec<[f64; 3]> = Vec::new();
        let mut anchors: Vec<Anchor> = Vec::new();
        for (joint, p) in on_body.filter_map(|(joint, pin)| Some((joint, (*pin)?))) {
            let is_new = |q: &[f64; 3]| (p[0] - q[0]).hypot(p[1] - q[1]) > 1e-9;
            if points.iter().all(is_new) {
                points.push(p);
                let is_second = joint.successor.body.0 == body;
                anchors.push(if is_second { joint.successor } else { joint.predecessor });
            }
        }
        let n = points.len() as f64;
        let middle = std::array::from_fn(|i| points.iter().map(|p| p[i] / n).sum());
        // From pin to pin; a third side closes a triangle.
        let mut pairs: Vec<[usize; 2]> = (1..points.len()).map(|k| [k - 1, k]).collect();
        if points.len() == 3 {
            pairs.push([0, 2]);
        }
        for (row, [i, j]) in pairs.into_iter().enumerate() {
            let ends = [points[i], points[j]];
            let length = (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]);
            let shown = number(six_digits(unit.of_si(length), unit.of_si(length)));
            let named = parameter_of(mechanism, [anchors[i], anchors[j]], length);
            let text = named.map_or_else(String::new, |of| format!("{} = ", of.name)) + &shown;
            let row = if body == 0 { row } else { 0 };
            found.push(Dimension { ends, text, row, middle });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_those_of_drawings() {
        let check = |most: f64, expected: &str| assert_eq!(standard(most).1, expected, "{most}");
        check(0.35, "1:5");
        check(0.5, "1:2");
        check(1.7, "1:1");
        check(7.0, "5:1");
        check(0.012, "1:100");
        check(30.0, "20:1");
    }
}
