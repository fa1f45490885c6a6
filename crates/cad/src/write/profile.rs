//! Closed and open curves as drawings of their own, at full size: as DXF, and as SVG.

use super::canvas::{Canvas, Mark, Release, WriteError};
use crate::geometry::Point;

/// A curve through points.
#[derive(Clone, PartialEq, Debug)]
pub struct Outline {
    /// Layer of the outline.
    pub layer: String,
    /// Corners, m, each with the angle by which the curve turns on the way to the next one, rad.
    pub corners: Vec<(Point, f64)>,
    /// The last corner is before the first again.
    pub is_closed: bool,
}

/// mm in a metre.
const MM: f64 = 1e3;
/// Colours of the layers, one after the other.
const COLOURS: [u8; 4] = [7, 5, 1, 3];
/// Layer of the origin and the circles about it.
const CENTRE: &str = "CENTRE";
/// Space around the curves of a picture, mm.
const MARGIN: f64 = 5.0;

/// The curves in mm as a DXF file, with arcs from corner to corner, and circles about the origin.
///
/// # Errors
/// [`WriteError`].
pub fn dxf(outlines: &[Outline], circles: &[f64]) -> Result<Vec<u8>, WriteError> {
    let mut canvas = Canvas::new(Release::R2000, "mm")?;
    for (outline, colour) in outlines.iter().zip(COLOURS.into_iter().cycle()) {
        canvas.layer(&outline.layer, colour);
        // A bulge is the tangent of a quarter of the angle of its arc.
        let corner = |&([x, y], turn): &(Point, f64)| ([MM * x, MM * y], (0.25 * turn).tan());
        let corners = outline.corners.iter().map(corner).collect();
        canvas.draw(&outline.layer, Mark::Polyline { corners, is_closed: outline.is_closed })?;
    }
    canvas.layer(CENTRE, 8);
    canvas.draw(CENTRE, Mark::Dot([0.0, 0.0]))?;
    for radius in circles {
        canvas.draw(CENTRE, Mark::Circle([0.0, 0.0], MM * radius))?;
    }
    let [low, high] = extent(outlines, circles);
    canvas.view([low, high], [low, high]);
    canvas.bytes()
}

/// Outlines as SVG.
pub fn svg(outlines: &[Outline], circles: &[f64]) -> String {
    let [low, high] = extent(outlines, circles);
    let [width, height] = [0, 1].map(|i| high[i] - low[i] + 2.0 * MARGIN);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.3}mm\" height=\"{height:.3}mm\" \
         viewBox=\"{:.3} {:.3} {width:.3} {height:.3}\">\n\
         <g fill=\"none\" stroke=\"black\" stroke-width=\"0.25\">\n",
        low[0] - MARGIN,
        -high[1] - MARGIN,
    );
    for (idx, outline) in outlines.iter().enumerate() {
        let points =
            outline.corners.iter().map(|([x, y], _)| format!("{:.4},{:.4}", MM * x, -MM * y));
        let points = points.collect::<Vec<_>>().join(" L");
        let end = if outline.is_closed { " Z" } else { "" };
        let dashes = if idx == 0 { "" } else { " stroke-dasharray=\"2 1\"" };
        let layer = &outline.layer;
        text.extend([format!("<path id=\"{layer}\"{dashes} d=\"M{points}{end}\"/>\n")]);
    }
    for radius in circles {
        let radius = MM * radius;
        text.extend([format!("<circle r=\"{radius:.4}\" stroke-dasharray=\"4 1 0.5 1\"/>\n")]);
    }
    text + "<path d=\"M-2,0 L2,0 M0,-2 L0,2\"/>\n</g>\n</svg>\n"
}

/// Lower left and upper right corner, mm.
fn extent(outlines: &[Outline], circles: &[f64]) -> [Point; 2] {
    let corners = outlines.iter().flat_map(|outline| &outline.corners).map(|(corner, _)| *corner);
    let circles = circles.iter().flat_map(|&radius| [[-radius; 2], [radius; 2]]);
    let points = corners.chain(circles).filter(|point| point.iter().all(|x| x.is_finite()));
    let ends = points.fold([[0.0; 2]; 2], |[low, high]: [Point; 2], p| {
        [[0, 1].map(|i| low[i].min(p[i])), [0, 1].map(|i| high[i].max(p[i]))]
    });
    ends.map(|corner| corner.map(|x| MM * x))
}
