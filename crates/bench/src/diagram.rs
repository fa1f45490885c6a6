//! Diagrams with a linear and a logarithmic axis, as SVG.
//!
//! Colours and grey are of middle lightness, so that a diagram is readable on white and on black;
//! the background is transparent.

use std::fmt;

/// A curve.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// Name in the legend.
    pub(crate) name: String,
    /// x and y; points that are not finite are left out.
    pub(crate) points: Vec<(f64, f64)>,
}

/// A diagram; its text form is an SVG file.
#[derive(Clone, Debug)]
pub(crate) struct Diagram {
    pub(crate) title: String,
    /// Label of the linear axis.
    pub(crate) x_label: String,
    /// Label of the logarithmic axis.
    pub(crate) y_label: String,
    pub(crate) series: Vec<Series>,
}

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 52.0;
const GREY: &str = "#808790";
const COLOURS: [&str; 7] =
    ["#1a7fe0", "#e0562a", "#2f9e63", "#8fb02a", "#9a63d6", "#c08a1e", "#c2558f"];

/// The map from values to positions in the picture.
struct Scale {
    /// Range of x.
    x: [f64; 2],
    /// Range of log₁₀ y.
    y: [f64; 2],
}

impl Scale {
    /// The scale of ranges that end at whole numbers and decades around all points.
    fn around(series: &[Series]) -> Self {
        let points = || series.iter().flat_map(|series| finite(&series.points));
        let around = |values: &mut dyn Iterator<Item = f64>| {
            let values: Vec<f64> = values.collect();
            let low = values.iter().copied().fold(f64::INFINITY, f64::min).floor();
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max).ceil();
            if low < high { [low, high] } else { [0.0, 1.0] }
        };
        Self {
            x: around(&mut points().map(|(x, _)| x)),
            y: around(&mut points().map(|(_, y)| y.log10())),
        }
    }

    fn x(&self, x: f64) -> f64 {
        LEFT + (x - self.x[0]) / (self.x[1] - self.x[0]) * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, log_y: f64) -> f64 {
        HEIGHT - BOTTOM - (log_y - self.y[0]) / (self.y[1] - self.y[0]) * (HEIGHT - TOP - BOTTOM)
    }
}

fn finite(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> + '_ {
    points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite() && *y > 0.0)
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

impl fmt::Display for Diagram {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scale = Scale::around(&self.series);
        writeln!(
            f,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
             font-family=\"sans-serif\" font-size=\"13\" fill=\"{GREY}\">"
        )?;
        writeln!(f, "<title>{}</title>", escape(&self.title))?;
        writeln!(
            f,
            "<text x=\"{LEFT}\" y=\"24\" font-size=\"15\" font-weight=\"bold\">{}</text>",
            escape(&self.title)
        )?;
        self.write_axes(f, &scale)?;
        for (idx, series) in self.series.iter().enumerate() {
            write_series(f, &scale, series, idx)?;
        }
        writeln!(f, "</svg>")
    }
}

impl Diagram {
    fn write_axes(&self, f: &mut fmt::Formatter<'_>, scale: &Scale) -> fmt::Result {
        let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
        writeln!(f, "<g stroke=\"{GREY}\" stroke-opacity=\"0.35\">")?;
        for x in whole_numbers(scale.x) {
            let x = scale.x(x);
            writeln!(f, "<path d=\"M{x:.2} {TOP}V{bottom}\"/>")?;
        }
        for decade in whole_numbers(scale.y) {
            let y = scale.y(decade);
            writeln!(f, "<path d=\"M{LEFT} {y:.2}H{right}\"/>")?;
            // Fainter lines at 2 and 5 times a power of ten.
            for y in [2.0f64, 5.0].map(|part| scale.y(decade + part.log10())) {
                if y > TOP {
                    writeln!(f, "<path d=\"M{LEFT} {y:.2}H{right}\" stroke-opacity=\"0.13\"/>")?;
                }
            }
        }
        writeln!(f, "</g>")?;
        for x in whole_numbers(scale.x) {
            let (at, below) = (scale.x(x), bottom + 18.0);
            writeln!(f, "<text x=\"{at:.2}\" y=\"{below}\" text-anchor=\"middle\">{x}</text>")?;
        }
        for decade in whole_numbers(scale.y) {
            let (at, value) = (scale.y(decade) + 4.0, 10f64.powf(decade));
            let before = LEFT - 8.0;
            writeln!(f, "<text x=\"{before}\" y=\"{at:.2}\" text-anchor=\"end\">{value}</text>")?;
        }
        let (middle, below) = (f64::midpoint(LEFT, right), HEIGHT - 12.0);
        let label = escape(&self.x_label);
        writeln!(f, "<text x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">{label}</text>")?;
        let (height, label) = (f64::midpoint(TOP, bottom), escape(&self.y_label));
        writeln!(
            f,
            "<text transform=\"translate(18 {height}) rotate(-90)\" \
             text-anchor=\"middle\">{label}</text>"
        )
    }
}

/// Writes a line with its marks, and its row of the legend.
fn write_series(
    f: &mut fmt::Formatter<'_>,
    scale: &Scale,
    series: &Series,
    idx: usize,
) -> fmt::Result {
    let colour = COLOURS[idx % COLOURS.len()];
    let positions: Vec<(f64, f64)> =
        finite(&series.points).map(|(x, y)| (scale.x(x), scale.y(y.log10()))).collect();
    let path: Vec<String> = positions.iter().map(|(x, y)| format!("{x:.2} {y:.2}")).collect();
    writeln!(f, "<g stroke=\"{colour}\" fill=\"{colour}\">")?;
    if !path.is_empty() {
        let path = path.join("L");
        writeln!(f, "<path d=\"M{path}\" fill=\"none\" stroke-width=\"2\"/>")?;
    }
    let row = TOP + 12.0 + 22.0 * idx as f64;
    let legend = WIDTH - RIGHT + 22.0;
    for (x, y) in positions.into_iter().chain([(legend, row)]) {
        writeln!(f, "{}", mark(idx, x, y))?;
    }
    writeln!(f, "</g>")?;
    let (name, x, y) = (escape(&series.name), legend + 12.0, row + 4.5);
    writeln!(f, "<text x=\"{x}\" y=\"{y}\">{name}</text>")
}

/// A mark of its own for every curve: not everyone can distinguish them by colour alone.
fn mark(idx: usize, x: f64, y: f64) -> String {
    match idx % 5 {
        0 => format!("<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"4\"/>"),
        1 => format!("<path d=\"M{:.2} {:.2}h8v8h-8z\"/>", x - 4.0, y - 4.0),
        2 => format!("<path d=\"M{x:.2} {:.2}l5 9h-10z\"/>", y - 5.5),
        3 => format!("<path d=\"M{x:.2} {:.2}l5 5-5 5-5-5z\"/>", y - 5.0),
        _ => format!(
            "<path d=\"M{x:.2} {:.2}v10m-5-5h10\" fill=\"none\" stroke-width=\"2.5\"/>",
            y - 5.0
        ),
    }
}

fn whole_numbers(range: [f64; 2]) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(range[0]), |x| Some(x + 1.0)).take_while(move |&x| x <= range[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_at_their_values_on_the_axes() {
        let diagram = Diagram {
            title: "a < b".to_owned(),
            x_label: String::new(),
            y_label: String::new(),
            series: vec![Series {
                name: "one".to_owned(),
                points: vec![(2.0, 0.1), (f64::NAN, 1.0), (4.0, 10.0)],
            }],
        };
        let text = diagram.to_string();
        // The corners of the frame: two digits at 0.1, four at 10.
        let corners =
            format!("M{:.2} {:.2}L{:.2} {:.2}", LEFT, HEIGHT - BOTTOM, WIDTH - RIGHT, TOP);
        assert!(text.contains(&corners), "{text}");
        assert!(text.contains("a &lt; b") && !text.contains("NaN"));
    }

    #[test]
    fn an_empty_diagram_has_axes() {
        let series = vec![Series { name: "none".to_owned(), points: Vec::new() }];
        let empty = Diagram {
            title: String::new(),
            x_label: String::new(),
            y_label: String::new(),
            series,
        };
        assert!(!empty.to_string().contains("inf"));
    }
}
