//! Where everything of a figure stands, from the widths of its texts.
//!
//! Panels stand in a grid; areas of one column are equally wide and those of one row equally high.
//! The texts around an area depend on its size, which depends on them: rooms grow until all texts
//! fit, which two or three rounds bring about.

use crate::axis::{Map, Margin};
use crate::figure::{Figure, Panel, Size};
use crate::legend::{self, Entry};
use crate::ticks::Ticks;
use crate::{Axis, Scale, font};

/// Size of the figure's title, px.
pub(crate) const TITLE_SIZE: f64 = 17.0;
/// Size of the axes' titles, px.
pub(crate) const AXIS_SIZE: f64 = 15.0;
/// Size of the numbers at ticks, px.
pub(crate) const TICK_SIZE: f64 = 14.0;
/// Between a number and its axis, px.
pub(crate) const TICK_GAP: f64 = 7.0;
/// Around the picture, px.
const MARGIN: f64 = 12.0;
/// Between columns and between rows, px.
const BETWEEN: [f64; 2] = [22.0, 16.0];
/// Height of a line of text in its size.
const LINE: f64 = 1.3;
/// Pixels for each tick of an ordinate, at least, and between numbers of an abscissa.
const TICK_SPACE: f64 = 30.0;
const NUMBER_SPACE: f64 = 26.0;
const N_ROUNDS: usize = 4;

/// A figure at a size.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Layout {
    /// The title, as much as fits; its baseline begins at `title_at`.
    pub(crate) title: String,
    pub(crate) title_at: [f64; 2],
    /// One for each panel.
    pub(crate) panels: Vec<Place>,
}

/// A panel in the picture.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Place {
    pub(crate) area: Area,
    pub(crate) x: Side,
    pub(crate) y: Side,
    pub(crate) legend: Vec<Entry>,
    /// Left end and middle of the legend's first row.
    pub(crate) legend_at: [f64; 2],
}

/// What the axes enclose, px from the top left corner of the picture.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Area {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

/// An axis in the picture.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Side {
    pub(crate) map: Map,
    pub(crate) ticks: Ticks,
    pub(crate) title: String,
    /// Middle of the title's baseline.
    pub(crate) title_at: [f64; 2],
    /// Whether numbers and title are written.
    pub(crate) has_texts: bool,
}

/// What texts take up: left and right of each column's areas, above each row's.
#[derive(Clone, PartialEq, Debug)]
struct Rooms {
    left: Vec<f64>,
    right: Vec<f64>,
    above: Vec<f64>,
}

impl Layout {
    pub(crate) fn new(figure: &Figure, size: Size) -> Self {
        let (n_columns, n_rows) = figure.grid();
        let shared = shared_ends(figure);
        let mut rooms = Rooms {
            left: vec![40.0; n_columns],
            right: vec![0.0; n_columns],
            above: vec![0.0; n_rows],
        };
        let mut panels = place_all(figure, size, &rooms, shared);
        for _ in 1..N_ROUNDS {
            let wanted = rooms.grown_for(&panels, n_columns);
            if wanted == rooms {
                break;
            }
            rooms = wanted;
            panels = place_all(figure, size, &rooms, shared);
        }
        let title = font::fitted(&figure.title, TITLE_SIZE, size.width - 2.0 * MARGIN);
        let left = panels.first().map_or(MARGIN, |panel| panel.area.left);
        let is_short = left + font::width(&title, TITLE_SIZE) + MARGIN <= size.width;
        let title_x = if is_short { left } else { MARGIN };
        Self { title, title_at: [title_x, MARGIN + TITLE_SIZE * 0.85], panels }
    }
}

impl Rooms {
    fn grown_for(&self, panels: &[Place], n_columns: usize) -> Self {
        let mut rooms = self.clone();
        for (place, panel) in panels.iter().enumerate() {
            let (column, row) = (place % n_columns, place / n_columns);
            let widest = panel.y.ticks.labels.iter().map(|label| font::width(label, TICK_SIZE));
            let left = AXIS_SIZE * LINE + widest.fold(0.0, f64::max) + TICK_GAP + 4.0;
            let [left_room, right_room] = [&mut rooms.left[column], &mut rooms.right[column]];
            *left_room = left_room.max(left.ceil());
            *right_room = right_room.max(panel.overhang().ceil());
            let above = &mut rooms.above[row];
            // The highest number of the ordinate stands half above the area.
            *above = above.max(legend::height(&panel.legend).max(TICK_SIZE * 0.4));
        }
        rooms
    }
}

impl Place {
    /// How far numbers of the abscissa stand out on the right.
    fn overhang(&self) -> f64 {
        let ends = self.x.ticks.values.iter().zip(&self.x.ticks.labels).map(|(value, label)| {
            self.x.map.place(*value) + 0.5 * font::width(label, TICK_SIZE) - self.area.right
        });
        if self.x.has_texts { ends.fold(0.0, f64::max) } else { 0.0 }
    }
}

/// Ends of the abscissa of all panels, if it is one for all.
fn shared_ends(figure: &Figure) -> Option<[f64; 2]> {
    let first = &figure.panels.first()?.x;
    let is_one = figure.panels.iter().all(|panel| panel.x == *first && !panel.equal_scale);
    let values = figure.panels.iter().flat_map(|panel| panel.values(0));
    is_one.then(|| first.ends(values, margin_of_x(&figure.panels)))
}

/// Curves over time fill the width; others need room at both sides.
fn margin_of_x(panels: &[Panel]) -> Margin {
    let goes_on = |points: &[[f64; 2]]| {
        let numbers = || points.iter().filter(|point| !point[1].is_nan());
        numbers().is_sorted_by(|a, b| a[0] <= b[0]) || numbers().is_sorted_by(|a, b| a[0] >= b[0])
    };
    let is_over_time =
        panels.iter().flat_map(|panel| &panel.curves).all(|curve| goes_on(&curve.points));
    if is_over_time { Margin::None } else { Margin::Narrow }
}

fn place_all(figure: &Figure, size: Size, rooms: &Rooms, shared: Option<[f64; 2]>) -> Vec<Place> {
    let (n_columns, n_rows) = figure.grid();
    let n = figure.panels.len();
    // Below the lowest panel of each column, or below each panel.
    let has_texts = |place: usize| shared.is_none() || place + n_columns >= n;
    let below = |row: usize| {
        let is_any = (row * n_columns..((row + 1) * n_columns).min(n)).any(has_texts);
        if is_any { TICK_GAP + TICK_SIZE + AXIS_SIZE * LINE + 3.0 } else { 0.0 }
    };
    let title = if figure.title.is_empty() { 0.0 } else { TITLE_SIZE * LINE + 6.0 };
    let texts = |rooms: &[f64]| rooms.iter().sum::<f64>();
    let all_below: f64 = (0..n_rows).map(below).sum();
    let free = [
        size.width - texts(&rooms.left) - texts(&rooms.right),
        size.height - title - texts(&rooms.above) - all_below,
    ];
    let [width, height] = [(free[0], n_columns, BETWEEN[0]), (free[1], n_rows, BETWEEN[1])].map(
        |(free, n, between)| ((free - 2.0 * MARGIN - between * (n - 1) as f64) / n as f64).max(1.0),
    );
    let place = |(place, panel): (usize, &Panel)| {
        let (column, row) = (place % n_columns, place / n_columns);
        let left = MARGIN
            + texts(&rooms.left[..=column])
            + texts(&rooms.right[..column])
            + column as f64 * (width + BETWEEN[0]);
        let top = MARGIN
            + title
            + texts(&rooms.above[..=row])
            + (0..row).map(below).sum::<f64>()
            + row as f64 * (height + BETWEEN[1]);
        let area = Area { left, top, right: left + width, bottom: top + height };
        place_panel(panel, area, rooms.left[column], shared, has_texts(place))
    };
    figure.panels.iter().enumerate().map(place).collect()
}

fn place_panel(
    panel: &Panel,
    area: Area,
    left_room: f64,
    shared: Option<[f64; 2]>,
    has_texts: bool,
) -> Place {
    let margin = margin_of_x(std::slice::from_ref(panel));
    let mut x_ends = shared.unwrap_or_else(|| panel.x.ends(panel.values(0), margin));
    let mut y_ends = panel.y.ends(panel.values(1), Margin::Narrow);
    let (width, height) = (area.right - area.left, area.bottom - area.top);
    if panel.equal_scale && [panel.x.scale, panel.y.scale] == [Scale::Linear; 2] {
        widen(&mut x_ends, &mut y_ends, width / height);
    }
    let legend = legend::entries(&panel.curves, width);
    let legend_at = [area.left, area.top - legend::height(&legend) + 0.5 * legend::ROW_HEIGHT];

    let x_ticks = abscissa_ticks(&panel.x, x_ends, width);
    let x_title = panel.x.title_within(&x_ticks, AXIS_SIZE, width);
    let baseline = area.bottom + TICK_GAP + TICK_SIZE + AXIS_SIZE * LINE;
    let x = Side {
        map: Map::new(x_ends, [area.left, area.right], panel.x.scale),
        ticks: x_ticks,
        title: x_title,
        title_at: [0.5 * (area.left + area.right), baseline],
        has_texts,
    };

    let y_ticks = panel.y.ticks(y_ends, count(height / TICK_SPACE, [2.0, 10.0]));
    let y_title = panel.y.title_within(&y_ticks, AXIS_SIZE, height + legend::height(&legend));
    // A title that is longer than its axis goes up beside the legend.
    let length = font::width(&y_title, AXIS_SIZE);
    let middle = (0.5 * (area.top + area.bottom)).min(area.bottom - 0.5 * length);
    let y = Side {
        map: Map::new(y_ends, [area.bottom, area.top], panel.y.scale),
        ticks: y_ticks,
        title: y_title,
        title_at: [area.left - left_room + AXIS_SIZE * 0.85, middle],
        has_texts: true,
    };
    Place { area, x, y, legend, legend_at }
}

/// As many ticks as have room for their numbers.
fn abscissa_ticks(axis: &Axis, ends: [f64; 2], width: f64) -> Ticks {
    let fits = |ticks: &Ticks| {
        let widths = ticks.labels.iter().map(|label| font::width(label, TICK_SIZE) + NUMBER_SPACE);
        widths.fold(0.0, f64::max) * ticks.labels.len().saturating_sub(1) as f64 <= width
    };
    let most = count(width / 60.0, [1.0, 12.0]);
    let found = (1..=most).rev().map(|n| axis.ticks(ends, n)).find(fits);
    found.unwrap_or_else(|| axis.ticks(ends, 1))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between the limits")]
fn count(value: f64, [least, most]: [f64; 2]) -> usize {
    value.clamp(least, most) as usize
}

/// Makes the narrower pair of ends wider, so that both have one scale in an area of this ratio of
/// width to height.
fn widen(x: &mut [f64; 2], y: &mut [f64; 2], ratio: f64) {
    let grow = |ends: &mut [f64; 2], span: f64| {
        let more = 0.5 * (span - (ends[1] - ends[0]));
        *ends = [ends[0] - more, ends[1] + more];
    };
    let (x_span, y_span) = (x[1] - x[0], y[1] - y[0]);
    if x_span < ratio * y_span {
        grow(x, ratio * y_span);
    } else {
        grow(y, x_span / ratio);
    }
}
