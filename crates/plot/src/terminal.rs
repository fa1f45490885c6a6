//! The picture in characters: curves in braille dots, axes and numbers around them.
//!
//! A letter at the right end of each curve identifies it, so that the picture is readable without
//! colours, too.

use std::fmt::Write as _;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::widgets::Widget;
use ratatui::widgets::canvas::{Canvas, Line};

use crate::axis::{Map, Margin};
use crate::decimate::{LARGEST, Point};
use crate::{Curve, Figure, Mark, Panel};

/// The text screen that shows the picture.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Screen {
    /// Columns.
    pub width: u16,
    /// Rows of each panel, its axes and legend included.
    pub panel_height: u16,
    /// True if characters have colours.
    pub has_colors: bool,
}

/// Colours that every terminal has, readable on light and dark ones.
const COLORS: [Color; 6] =
    [Color::Blue, Color::Yellow, Color::Green, Color::Magenta, Color::Red, Color::Cyan];
/// Their codes of ISO 6429.
const CODES: [&str; 6] = ["34", "33", "32", "35", "31", "36"];
/// Smallest readable picture: columns, rows.
const LEAST: [u16; 2] = [30, 8];
/// Largest picture.
const MOST: [u16; 2] = [400, 200];
/// Rows around the area: the ordinate's title above; the axis, numbers and title below.
const ROWS_ABOVE: u16 = 1;
const ROWS_BELOW: u16 = 3;

impl Figure {
    /// The figure as lines of text, no wider than the screen.
    pub fn to_text(&self, screen: Screen) -> String {
        let mut text = String::new();
        if !self.title.is_empty() {
            let _ = writeln!(text, "{}", fitted(&self.title, usize::from(screen.width)));
        }
        for (idx, panel) in self.panels.iter().enumerate() {
            if idx > 0 {
                text.push('\n');
            }
            text.push_str(&panel_text(panel, screen));
        }
        text
    }
}

fn panel_text(panel: &Panel, screen: Screen) -> String {
    // Size of the picture, below which the legend stands.
    let width = screen.width.clamp(LEAST[0], MOST[0]);
    let legend = legend(&panel.curves, usize::from(width));
    let n_legend = u16::try_from(legend.len()).unwrap_or(u16::MAX);
    let height =
        screen.panel_height.clamp(LEAST[1], MOST[1]).saturating_sub(n_legend).max(LEAST[1]);

    // Ends of both axes, and the area that the numbers of the ordinate leave.
    let x_ends = panel.x.ends(panel.values(0), Margin::None);
    let y_ends = panel.y.ends(panel.values(1), Margin::Narrow);
    let n_rows = height - ROWS_ABOVE - ROWS_BELOW;
    let y_ticks = panel.y.ticks(y_ends, usize::from(n_rows / 3).max(2));
    let numbers = y_ticks.labels.iter().map(|label| count(label)).max().unwrap_or(0);
    let left = u16::try_from(numbers).unwrap_or(u16::MAX).min(width / 3) + 1;
    // One column for the axis, one for the letters.
    let area = Rect::new(left + 1, ROWS_ABOVE, width - left - 3, n_rows);

    // The curves, in dots: two to a column, four to a row.
    let mut buffer = Buffer::empty(Rect::new(0, 0, width, height));
    let maps = [
        Map::new(x_ends, [0.0, f64::from(area.width * 2 - 1)], panel.x.scale),
        Map::new(y_ends, [0.0, f64::from(area.height * 4 - 1)], panel.y.scale),
    ];
    draw_curves(panel, area, maps, &mut buffer);

    // The ordinate: title, line, ticks and numbers.
    let put = |buffer: &mut Buffer, x: u16, y: u16, text: &str| {
        buffer.set_stringn(x, y, text, usize::from(width - x), Style::new());
    };
    put(&mut buffer, 0, 0, &fitted(&panel.y.title(&y_ticks), usize::from(width)));
    for row in area.top()..area.bottom() {
        put(&mut buffer, left, row, "│");
    }
    for (value, label) in y_ticks.values.iter().zip(&y_ticks.labels) {
        let row = area.bottom() - 1 - cell(maps[1].position(*value), 4, area.height);
        let label = fitted(label, usize::from(left));
        let n = u16::try_from(count(&label)).expect("a fitted label has at most `left` letters");
        put(&mut buffer, left - n, row, &label);
        put(&mut buffer, left, row, "┤");
    }

    // The abscissa: line, ticks, numbers where they do not overlap, title.
    let row = area.bottom();
    put(&mut buffer, left, row, "└");
    put(&mut buffer, left + 1, row, &"─".repeat(usize::from(area.width)));
    let x_ticks = panel.x.ticks(x_ends, usize::from(area.width / 14).max(1));
    let mut free_from = 0;
    for (value, label) in x_ticks.values.iter().zip(&x_ticks.labels) {
        let column = area.left() + cell(maps[0].position(*value), 2, area.width);
        put(&mut buffer, column, row, "┬");
        let half = u16::try_from(count(label) / 2).expect("labels of ticks have few letters");
        let first = column.saturating_sub(half).min(width - half.saturating_mul(2).min(width));
        if first >= free_from {
            put(&mut buffer, first, row + 1, label);
            free_from = first + half * 2 + 2;
        }
    }
    let title = fitted(&panel.x.title(&x_ticks), usize::from(area.width));
    let title_width = u16::try_from(count(&title)).expect("a fitted title is within the area");
    put(&mut buffer, area.left() + (area.width - title_width) / 2, row + 2, &title);

    // The picture as text, and the legend below it.
    let mut text = lines(&buffer, screen.has_colors);
    for row in legend {
        for (curve, entry) in row {
            let color = CODES[panel.curves[curve].color % CODES.len()];
            let _ = if screen.has_colors {
                write!(text, "  \x1b[{color}m{entry}\x1b[0m")
            } else {
                write!(text, "  {entry}")
            };
        }
        text.push('\n');
    }
    text
}

fn draw_curves(panel: &Panel, area: Rect, maps: [Map; 2], buffer: &mut Buffer) {
    let dots = |[x, y]: Point| {
        let is_drawn = x.abs() <= LARGEST && y.abs() <= LARGEST;
        if is_drawn { [maps[0].position(x), maps[1].position(y)] } else { [f64::NAN; 2] }
    };
    let bounds = [f64::from(area.width * 2 - 1), f64::from(area.height * 4 - 1)];
    Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([0.0, bounds[0]])
        .y_bounds([0.0, bounds[1]])
        .paint(|context| {
            for curve in &panel.curves {
                // A layer of its own, so that no curve takes the colour of another.
                context.layer();
                let color = COLORS[curve.color % COLORS.len()];
                let mut last: Option<Point> = None;
                for point in curve.points.iter().map(|point| dots(*point)) {
                    if point.iter().any(|coordinate| coordinate.is_nan()) {
                        last = None;
                        continue;
                    }
                    let [x1, y1] = last.unwrap_or(point).map(f64::round);
                    let [x2, y2] = point.map(f64::round);
                    context.draw(&Line::new(x1, y1, x2, y2, color));
                    last = (curve.mark == Mark::Line).then_some(point);
                }
            }
        })
        .render(area, buffer);
    if panel.curves.len() > 1 {
        letters(panel, area, maps, buffer);
    }
}

/// Writes a letter next to the last point of each curve, or in the nearest free row.
fn letters(panel: &Panel, area: Rect, maps: [Map; 2], buffer: &mut Buffer) {
    let mut is_free = vec![true; usize::from(area.height)];
    for (idx, curve) in panel.curves.iter().enumerate() {
        let Some(end) = curve.points.iter().rev().find(|point| !point[1].is_nan()) else {
            continue;
        };
        let last = area.height - 1 - cell(maps[1].position(end[1]), 4, area.height);
        let free = (0..area.height).filter(|&row| is_free[usize::from(row)]);
        let Some(row) = free.min_by_key(|row| row.abs_diff(last)) else { return };
        is_free[usize::from(row)] = false;
        let style = Style::new().fg(COLORS[curve.color % COLORS.len()]);
        buffer.set_string(area.right(), area.top() + row, letter(idx), style);
    }
}

fn letter(idx: usize) -> String {
    const LETTERS: &[u8; 26] = b"abcdefghijklmnopqrstuvwxyz";
    char::from(LETTERS[idx % LETTERS.len()]).to_string()
}

/// Rows of the legend: indices of curves, with their letters and names; none for one curve.
fn legend(curves: &[Curve], width: usize) -> Vec<Vec<(usize, String)>> {
    let mut rows: Vec<Vec<(usize, String)>> = Vec::new();
    let mut n_free = 0;
    // A single curve needs no name.
    for (idx, curve) in curves.iter().enumerate().filter(|_| curves.len() > 1) {
        let entry = fitted(&format!("{} {}", letter(idx), curve.name), width.saturating_sub(2));
        let n = count(&entry) + 2;
        match rows.last_mut() {
            Some(row) if n <= n_free => row.push((idx, entry)),
            _ => {
                rows.push(vec![(idx, entry)]);
                n_free = width;
            }
        }
        n_free = n_free.saturating_sub(n);
    }
    rows
}

/// The cell of a dot, among `n` cells of `dots` dots each.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and n")]
fn cell(position: f64, dots: u16, n: u16) -> u16 {
    (position.round() / f64::from(dots)).floor().clamp(0.0, f64::from(n.saturating_sub(1))) as u16
}

/// The buffer as lines, with codes for colours if the screen has them.
fn lines(buffer: &Buffer, has_colors: bool) -> String {
    let mut text = String::new();
    for row in 0..buffer.area.height {
        let mut line = String::new();
        let mut color = None;
        let cells = (0..buffer.area.width).map(|column| &buffer[(column, row)]);
        let end = cells.clone().rposition(|cell| cell.symbol() != " ").map_or(0, |end| end + 1);
        for cell in cells.take(end) {
            let own = COLORS.iter().position(|color| *color == cell.fg);
            if has_colors && own != color {
                let code = own.map_or("0", |own| CODES[own]);
                let _ = write!(line, "\x1b[{code}m");
                color = own;
            }
            line.push_str(cell.symbol());
        }
        if color.is_some() {
            line.push_str("\x1b[0m");
        }
        let _ = writeln!(text, "{line}");
    }
    text
}

fn count(text: &str) -> usize {
    text.chars().count()
}

/// The text, cut to a width, with `…` where it was cut.
fn fitted(text: &str, width: usize) -> String {
    if count(text) <= width {
        return text.to_owned();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}
