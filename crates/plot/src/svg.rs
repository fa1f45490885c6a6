//! The picture as SVG.
//!
//! Texts stay texts. Their widths are those of the font in the program; `textLength` gives a
//! browser's substitute for the font the same width.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::decimate::{LARGEST, Point, reduce};
use crate::figure::{Figure, Mark, Size};
use crate::layout::{AXIS_SIZE, Layout, PanelLayout, TICK_GAP, TICK_SIZE, TITLE_SIZE};
use crate::legend::{SAMPLE, TEXT_SIZE};
use crate::thin::thin;
use crate::{Curve, Panel, Theme, font};

/// Buckets in the width of a pixel: vector pictures are looked at enlarged.
const BUCKETS_PER_PIXEL: f64 = 2.0;
/// Largest distance of the drawn line from a point of its curve, px.
const FLATNESS: f64 = 0.05;
/// Width of curves, px.
const CURVE_WIDTH: f64 = 1.8;
/// Diameter of dots, px.
const DOT_WIDTH: f64 = 4.0;
/// Width of bars, px.
const BAR_WIDTH: f64 = 9.0;
/// Lengths of dashes and gaps, px.
const DASHES: [&str; 4] = ["", "7 4", "2 3", "8 3 2 3"];
const FAMILIES: &str = "Ubuntu, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif";

impl Figure {
    /// The figure as an SVG document of this size.
    pub fn to_svg(&self, size: Size, theme: &Theme) -> String {
        let layout = Layout::new(self, size);
        let mut svg = Svg { out: String::new(), theme };
        svg.open(size, &self.title);
        for (panel, own) in self.panels.iter().zip(&layout.panels) {
            svg.axes(own);
            svg.curves(panel, own);
            svg.legend(&panel.curves, own);
        }
        let [x, y] = layout.title_at;
        svg.text(&layout.title, &Font { size: TITLE_SIZE, anchor: "start", turned: false }, [x, y]);
        svg.out.push_str("</svg>\n");
        svg.out
    }
}

struct Svg<'a> {
    out: String,
    theme: &'a Theme,
}

struct Font {
    size: f64,
    anchor: &'static str,
    turned: bool,
}

impl Svg<'_> {
    // Writing to a string cannot fail.

    fn open(&mut self, Size { width, height }: Size, title: &str) {
        let [width, height] = [width, height].map(px);
        let background = color(self.theme.background);
        let _ = writeln!(
            self.out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{FAMILIES}\" \
             fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
             <title>{}</title>\n<rect width=\"{width}\" height=\"{height}\" fill=\"{background}\"/>",
            escaped(title),
        );
    }

    fn axes(&mut self, layout: &PanelLayout) {
        let area = layout.area;
        // The grid; a line at zero is stronger.
        let mut grid = String::new();
        let mut zero = String::new();
        for value in &layout.x.ticks.values {
            let x = px(layout.x.map.position(*value));
            let _ = write!(grid, "M{x} {}V{}", px(area.top), px(area.bottom));
        }
        for value in &layout.y.ticks.values {
            let line = if *value == 0.0 { &mut zero } else { &mut grid };
            let y = px(layout.y.map.position(*value));
            let _ = write!(line, "M{} {y}H{}", px(area.left), px(area.right));
        }
        let colors = [self.theme.grid, self.theme.axis].map(color);
        let _ = writeln!(
            self.out,
            "<path class=\"grid\" d=\"{grid}\" stroke=\"{}\" stroke-width=\"1\"/>",
            colors[0]
        );
        if !zero.is_empty() {
            let _ = writeln!(
                self.out,
                "<path class=\"zero\" d=\"{zero}\" stroke=\"{}\" stroke-width=\"0.8\" \
                 stroke-opacity=\"0.6\"/>",
                colors[1]
            );
        }
        let _ = writeln!(
            self.out,
            "<path class=\"axes\" d=\"M{left} {top}V{bottom}H{right}\" stroke=\"{}\" \
             stroke-width=\"1.2\"/>",
            colors[1],
            left = px(area.left),
            top = px(area.top),
            bottom = px(area.bottom),
            right = px(area.right),
        );
        self.numbers(layout);
    }

    fn numbers(&mut self, layout: &PanelLayout) {
        let area = layout.area;
        let end = Font { size: TICK_SIZE, anchor: "end", turned: false };
        for (value, label) in layout.y.ticks.values.iter().zip(&layout.y.ticks.labels) {
            let y = layout.y.map.position(*value) + 0.35 * TICK_SIZE;
            self.text(label, &end, [area.left - TICK_GAP, y]);
        }
        let title = Font { size: AXIS_SIZE, anchor: "middle", turned: true };
        self.text(&layout.y.title, &title, layout.y.title_at);
        if layout.x.has_texts {
            let middle = Font { size: TICK_SIZE, anchor: "middle", turned: false };
            for (value, label) in layout.x.ticks.values.iter().zip(&layout.x.ticks.labels) {
                let at = [layout.x.map.position(*value), area.bottom + TICK_GAP + 0.8 * TICK_SIZE];
                self.text(label, &middle, at);
            }
            let title = Font { turned: false, ..title };
            self.text(&layout.x.title, &title, layout.x.title_at);
        }
    }

    fn curves(&mut self, panel: &Panel, layout: &PanelLayout) {
        // A given range may cut the curves.
        let is_cut = panel.x.range.is_some() || panel.y.range.is_some();
        if is_cut {
            let area = layout.area;
            let [x, y] = [area.left, area.top].map(px);
            let [width, height] = [area.right - area.left, area.bottom - area.top].map(px);
            let _ = writeln!(
                self.out,
                "<clipPath id=\"area-{x}-{y}\"><rect x=\"{x}\" y=\"{y}\" width=\"{width}\" \
                 height=\"{height}\"/></clipPath>\n<g clip-path=\"url(#area-{x}-{y})\">"
            );
        }
        for curve in &panel.curves {
            let path = match curve.mark {
                Mark::Line => path(&curve.points, layout),
                Mark::Dots => dots(&curve.points, layout),
                Mark::Bars => bars(&curve.points, layout),
            };
            let _ = writeln!(
                self.out,
                "<g class=\"curve\"><title>{}</title><path d=\"{path}\" {}/></g>",
                escaped(&curve.name),
                self.stroke(curve),
            );
        }
        if is_cut {
            self.out.push_str("</g>\n");
        }
    }

    fn stroke(&self, curve: &Curve) -> String {
        let color = color(self.theme.curve(curve.color));
        if curve.mark == Mark::Dots {
            return format!(
                "stroke=\"{color}\" stroke-width=\"{DOT_WIDTH}\" stroke-opacity=\"0.6\""
            );
        }
        let stroke = format!("stroke=\"{color}\" stroke-width=\"{CURVE_WIDTH}\"");
        if curve.mark == Mark::Bars {
            return format!(
                "stroke=\"{color}\" stroke-width=\"{BAR_WIDTH}\" stroke-linecap=\"butt\""
            );
        }
        match DASHES[curve.dash % DASHES.len()] {
            "" => stroke,
            // Round ends would fill the gaps.
            dashes => {
                format!("{stroke} stroke-dasharray=\"{dashes}\" stroke-linecap=\"butt\"")
            }
        }
    }

    fn legend(&mut self, curves: &[Curve], layout: &PanelLayout) {
        let [left, top] = layout.legend_at;
        let font = Font { size: TEXT_SIZE, anchor: "start", turned: false };
        for entry in &layout.legend {
            let y = top + entry.row as f64 * crate::legend::ROW_HEIGHT;
            let x = left + entry.x;
            let curve = &curves[entry.curve];
            let stroke = self.stroke(curve);
            let key = match curve.mark {
                Mark::Line | Mark::Bars => format!("M{} {}h{}", px(x), px(y), px(SAMPLE)),
                Mark::Dots => {
                    let dot = |part: f64| format!("M{} {}h0", px(x + part * SAMPLE), px(y));
                    [0.1, 0.5, 0.9].map(dot).concat()
                }
            };
            let _ = writeln!(self.out, "<path class=\"key\" d=\"{key}\" {stroke}/>");
            self.text(&entry.text, &font, [left + entry.text_x(), y + 0.35 * TEXT_SIZE]);
        }
    }

    fn text(&mut self, text: &str, font: &Font, [x, y]: Point) {
        if text.is_empty() {
            return;
        }
        let [x, y, size] = [x, y, font.size].map(px);
        let position = if font.turned {
            format!("transform=\"translate({x} {y}) rotate(-90)\"")
        } else {
            format!("x=\"{x}\" y=\"{y}\"")
        };
        // The font has raised digits, but no raised minus sign: such powers are raised here.
        let (length, text) = if text.contains('⁻') {
            (String::new(), raised(text, font.size))
        } else {
            let length = px(font::width(text, font.size));
            let length = format!(" textLength=\"{length}\" lengthAdjust=\"spacingAndGlyphs\"");
            (length, escaped(text))
        };
        let _ = writeln!(
            self.out,
            "<text {position} font-size=\"{size}\" fill=\"{}\" text-anchor=\"{}\"{length}>{text}</text>",
            color(self.theme.text),
            font.anchor,
        );
    }
}

/// A curve as path data, with no more points than can be distinguished.
fn path(points: &[Point], layout: &PanelLayout) -> String {
    let mut pixels: Vec<Point> = points.to_vec();
    for point in &mut pixels {
        let is_drawn = point.iter().all(|value| value.abs() <= LARGEST);
        let [x, y] = [layout.x.map.position(point[0]), layout.y.map.position(point[1])];
        // A gap keeps only its position in the order.
        *point = [if x.is_nan() { 0.0 } else { x }, if is_drawn { y } else { f64::NAN }];
        if x.is_nan() {
            point[1] = f64::NAN;
        }
    }
    let numbers = || pixels.iter().filter(|point| !point[1].is_nan());
    // Curves over time, forwards or backwards, keep their extremes.
    if numbers().is_sorted_by(|a, b| a[0] <= b[0]) || numbers().is_sorted_by(|a, b| a[0] >= b[0]) {
        reduce(&mut pixels, |x| (x * BUCKETS_PER_PIXEL).floor());
    }
    thin(&mut pixels, [1.0; 2], FLATNESS);
    let mut path = String::new();
    for piece in pixels.split(|point| point[1].is_nan()) {
        for (idx, [x, y]) in piece.iter().enumerate() {
            let _ = write!(path, "{}{} {}", if idx == 0 { 'M' } else { 'L' }, px(*x), px(*y));
        }
        // A single point is drawn as a dot.
        if piece.len() == 1 {
            path.push_str("h0");
        }
    }
    path
}

/// Points as path data, those of one pixel once.
fn dots(points: &[Point], layout: &PanelLayout) -> String {
    let mut drawn: BTreeSet<(String, String)> = BTreeSet::new();
    for &[x, y] in points {
        let at = [layout.x.map.position(x), layout.y.map.position(y)];
        if at.iter().all(|value| value.is_finite()) {
            let [x, y] = at.map(|value| px((value * 2.0).round() / 2.0));
            drawn.insert((x, y));
        }
    }
    drawn.iter().fold(String::new(), |mut path, (x, y)| {
        let _ = write!(path, "M{x} {y}h0");
        path
    })
}

/// Bars from zero as path data.
fn bars(points: &[Point], layout: &PanelLayout) -> String {
    let zero = px(layout.x.map.position(0.0));
    points.iter().fold(String::new(), |mut path, &[x, y]| {
        let at = [layout.x.map.position(x), layout.y.map.position(y)];
        if at.iter().all(|value| value.is_finite()) {
            let _ = write!(path, "M{zero} {}H{}", px(at[1]), px(at[0]));
        }
        path
    })
}

/// A text with its superscripts as smaller, raised letters.
fn raised(text: &str, size: f64) -> String {
    const RAISED: &str = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹";
    const PLAIN: &str = "−0123456789";
    let plain = |letter: char| {
        let mut pairs = RAISED.chars().zip(PLAIN.chars());
        pairs.find(|(raised, _)| *raised == letter).map(|(_, plain)| plain)
    };
    let (up, small) = (px(0.4 * size), px(0.7 * size));
    let mut out = String::new();
    let mut is_up = false;
    for letter in text.chars() {
        match (plain(letter), is_up) {
            (Some(_), false) => {
                let _ = write!(out, "<tspan dy=\"-{up}\" font-size=\"{small}\">");
            }
            (None, true) => {
                let _ = write!(out, "</tspan><tspan dy=\"{up}\">");
            }
            _ => (),
        }
        is_up = plain(letter).is_some();
        out.push_str(&escaped(&plain(letter).unwrap_or(letter).to_string()));
    }
    // Close the spans of the last superscript, and those that lowered the text after one.
    let n_open = out.matches("<tspan").count() - out.matches("</tspan").count();
    out + &"</tspan>".repeat(n_open)
}

/// A length with two decimals, without trailing zeros.
fn px(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn color(rgb: u32) -> String {
    format!("#{rgb:06x}")
}

/// Text inside of XML; characters that XML cannot hold become `�`.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => out.push(' '),
            '\0'..' ' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            letter => out.push(letter),
        }
    }
    out
}
