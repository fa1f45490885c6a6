//! The drawing in grey with what was understood over it.

use std::fmt::Write as _;

use bksim_cad::geometry::vector::along;
use bksim_cad::geometry::{Bounds, Point};

use super::Found;
use super::bodies::{Look, anchor};
use super::joint::{Joint, Kind, On};
use super::questions::Asked;

const WIDTH: f64 = 960.0;
const MARGIN: f64 = 24.0;
/// Colours of bodies, told apart by all; the ground is dark.
const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7b3294", "#8c510a"];

struct View {
    origin: Point,
    scale: f64,
    height: f64,
}

impl View {
    fn at(&self, p: Point) -> Point {
        [
            MARGIN + (p[0] - self.origin[0]) * self.scale,
            self.height - MARGIN - (p[1] - self.origin[1]) * self.scale,
        ]
    }

    fn path(&self, points: &[Point]) -> String {
        let places: Vec<String> =
            points.iter().map(|p| self.at(*p)).map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
        format!("M{}", places.join("L"))
    }
}

pub(super) fn svg(found: &Found, asked: &Asked) -> String {
    let bounds = found
        .sheet
        .strokes
        .iter()
        .map(|stroke| stroke.path.bounds())
        .fold(Bounds::EMPTY, Bounds::union);
    let width = (bounds.max[0] - bounds.min[0]).max(f64::MIN_POSITIVE);
    let scale = (WIDTH - 2.0 * MARGIN) / width;
    let height =
        ((bounds.max[1] - bounds.min[1]) * scale + 2.0 * MARGIN).clamp(2.0 * MARGIN, 8.0 * WIDTH);
    let view = View { origin: bounds.min, scale, height };
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" width=\"{WIDTH}\" height=\"{height:.0}\" \
         font-family=\"sans-serif\" font-size=\"14\">\n<title>What was understood of the drawing</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<g fill=\"none\" stroke=\"#b8b8b8\" stroke-width=\"1\">\n"
    );
    let tolerance = 0.3 / scale;
    for stroke in &found.sheet.strokes {
        let mut points = stroke.path.flattened(tolerance);
        if stroke.path.is_closed {
            points.extend(points.first().copied());
        }
        let _ = writeln!(out, "<path d=\"{}\"/>", view.path(&points));
    }
    out.push_str("</g>\n");
    bodies(&mut out, found, &view);
    let pin = (found.pieces.pin * scale).clamp(4.0, 10.0);
    for joint in &found.joints {
        mark(&mut out, joint, &view, pin);
    }
    for (joint, _) in &asked.joints {
        let [x, y] = view.at(joint.at);
        let _ = writeln!(
            out,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{pin:.1}\" fill=\"#fff3b0\" stroke=\"#b07800\" stroke-width=\"2\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#7a5200\">?</text>",
            y + 5.0
        );
    }
    out.push_str("</svg>\n");
    out
}

fn bodies(out: &mut String, found: &Found, view: &View) {
    for base in &found.bases {
        let _ = writeln!(
            out,
            "<path d=\"{}\" fill=\"none\" stroke=\"#222\" stroke-width=\"4\"/>",
            view.path(&base.ends)
        );
    }
    for (centre, radius, _) in &found.bodies.rings {
        let ([x, y], r) = (view.at(*centre), radius * view.scale);
        let _ = writeln!(
            out,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" fill=\"none\" stroke=\"#222\" stroke-width=\"4\"/>"
        );
    }
    for (idx, body) in found.bodies.all.iter().enumerate() {
        let colour = COLOURS[idx % COLOURS.len()];
        let _ = writeln!(
            out,
            "<g stroke=\"{colour}\" stroke-width=\"2.5\" fill=\"{colour}\" fill-opacity=\"0.12\">"
        );
        if body.border.len() > 2 {
            let _ = writeln!(out, "<path d=\"{}Z\"/>", view.path(&body.border));
        }
        // Of a bar the middle line is no stroke.
        for segment in body.segments.iter().filter(|_| body.look != Look::Bar) {
            let _ = writeln!(out, "<path d=\"{}\"/>", view.path(segment));
        }
        if let Some((centre, radii)) = &body.wheel {
            let [x, y] = view.at(*centre);
            let _ = writeln!(
                out,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\"/>",
                radii[0] * view.scale
            );
        }
        out.push_str("</g>\n");
        let [x, y] = view.at(anchor(body));
        let _ = writeln!(
            out,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"{colour}\" stroke=\"white\" stroke-width=\"3\" paint-order=\"stroke\" \
             text-anchor=\"middle\">{}</text>",
            body.name
        );
    }
    for spring in &found.springs {
        let _ = writeln!(
            out,
            "<path d=\"{}\" stroke=\"#b2182b\" stroke-width=\"2.5\" stroke-dasharray=\"6 3\"/>",
            view.path(&spring.ends)
        );
    }
}

fn mark(out: &mut String, joint: &Joint, view: &View, pin: f64) {
    let [x, y] = view.at(joint.at);
    let is_fixed = joint.on.contains(&On::Ground);
    let fill = if is_fixed { "#222" } else { "white" };
    let name = match &joint.kind {
        Kind::Pin => {
            let _ = writeln!(
                out,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{pin:.1}\" fill=\"{fill}\" stroke=\"black\" stroke-width=\"2\"/>"
            );
            joint.name.clone()
        }
        Kind::Slide { axis } | Kind::Slot { axis } | Kind::Rack { axis, .. } => {
            let reach = 4.0 * pin / view.scale;
            let ends = [along(joint.at, -reach, *axis), along(joint.at, reach, *axis)];
            let _ = writeln!(
                out,
                "<path d=\"{}\" stroke=\"black\" stroke-width=\"3\"/>",
                view.path(&ends)
            );
            for end in ends {
                let [x, y] = view.at(end);
                let _ =
                    writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\"/>", 0.6 * pin);
            }
            format!("{} ({})", joint.name, joint.kind.name())
        }
        Kind::Gear { .. } | Kind::Cam { .. } => {
            let _ = writeln!(
                out,
                "<path d=\"M{:.1} {y:.1}h{w:.1}M{x:.1} {:.1}v{w:.1}\" stroke=\"black\" stroke-width=\"3\"/>",
                x - pin,
                y - pin,
                w = 2.0 * pin
            );
            format!("{} ({})", joint.name, joint.kind.name())
        }
    };
    let (dx, dy) =
        if joint.kind == Kind::Pin { (pin + 3.0, -pin) } else { (pin + 3.0, 2.0 * pin + 8.0) };
    let _ = writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" stroke=\"white\" stroke-width=\"3\" paint-order=\"stroke\">{name}</text>",
        x + dx,
        y + dy
    );
}
