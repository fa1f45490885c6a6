//! [`Layout`]: positions of all parts of a figure, from the widths of its texts.
//!
//! Panels stand in a grid; areas of one column are equally wide and those of one row equally high.
//! The texts around an area depend on its size, which depends on them: insets grow until all texts
//! fit, which takes two or three rounds.

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
/// Gap between a number and its axis, px.
pub(crate) const TICK_GAP: f64 = 7.0;
/// Margin around the picture, px.
const MARGIN: f64 = 12.0;
/// Gaps between columns and between rows, px.
const BETWEEN: [f64; 2] = [22.0, 16.0];
/// Height of a line of text relative to its size.
const LINE: f64 = 1.3;
/// Least distance of ticks on an ordinate, px.
const TICK_SPACE: f64 = 30.0;
/// Least gap between numbers of an abscissa, px.
const NUMBER_SPACE: f64 = 26.0;
/// Part of the height of a panel that its legend takes at most, unless names would be too short.
const LEGEND: f64 = 0.4;
/// Least distance of numbers on an ordinate, px.
const LINE_SPACE: f64 = 1.15 * TICK_SIZE;
/// Largest number of rounds in which insets grow.
const N_ROUNDS: usize = 4;

/// The layout of a figure at a size.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Layout {
    /// The title, shortened to fit; its baseline begins at `title_at`.
    pub(crate) title: String,
    pub(crate) title_at: [f64; 2],
    /// The panels in order.
    pub(crate) panels: Vec<PanelLayout>,
}

/// The layout of one panel.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct PanelLayout {
    pub(crate) area: Area,
    pub(crate) x: Side,
    pub(crate) y: Side,
    pub(crate) legend: Vec<Entry>,
    /// Left end and middle of the legend's first row.
    pub(crate) legend_at: [f64; 2],
}

/// The rectangle between the axes, px from the top left corner of the picture.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Area {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

/// The layout of one axis.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Side {
    pub(crate) map: Map,
    pub(crate) ticks: Ticks,
    pub(crate) title: String,
    /// Middle of the title's baseline.
    pub(crate) title_at: [f64; 2],
    /// True if numbers and title are written.
    pub(crate) has_texts: bool,
}

/// Space for texts, px: left and right of each column's areas, above each row's.
#[derive(Clone, PartialEq, Debug)]
struct Insets {
    left: Vec<f64>,
    right: Vec<f64>,
    above: Vec<f64>,
}

impl Layout {
    pub(crate) fn new(figure: &Figure, size: Size) -> Self {
        let (n_columns, n_rows) = figure.grid();
        let shared = shared_ends(figure);
        let mut insets = Insets {
            left: vec![40.0; n_columns],
            right: vec![0.0; n_columns],
            above: vec![0.0; n_rows],
        };
        let mut panels = place_panels(figure, size, &insets, shared);
        for _ in 1..N_ROUNDS {
            let grown = insets.grown_for(&panels, n_columns);
            if grown == insets {
                break;
            }
            insets = grown;
            panels = place_panels(figure, size, &insets, shared);
        }
        let title = font::fitted(&figure.title, TITLE_SIZE, size.width - 2.0 * MARGIN);
        let left = panels.first().map_or(MARGIN, |panel| panel.area.left);
        let is_short = left + font::width(&title, TITLE_SIZE) + MARGIN <= size.width;
        let title_x = if is_short { left } else { MARGIN };
        Self { title, title_at: [title_x, MARGIN + TITLE_SIZE * 0.85], panels }
    }
}

impl Insets {
    fn grown_for(&self, panels: &[PanelLayout], n_columns: usize) -> Self {
        let mut insets = self.clone();
        for (idx, panel) in panels.iter().enumerate() {
            let (column, row) = (idx % n_columns, idx / n_columns);
            let widest = panel.y.ticks.labels.iter().map(|label| font::width(label, TICK_SIZE));
            let left = AXIS_SIZE * LINE + widest.fold(0.0, f64::max) + TICK_GAP + 4.0;
            let [left_inset, right_inset] = [&mut insets.left[column], &mut insets.right[column]];
            *left_inset = left_inset.max(left.ceil());
            *right_inset = right_inset.max(panel.overhang().ceil());
            let above = &mut insets.above[row];
            // Half of the highest number of the ordinate stands above the area.
            *above = above.max(legend::height(&panel.legend).max(TICK_SIZE * 0.4));
        }
        insets
    }
}

impl PanelLayout {
    /// Overhang of the numbers of the abscissa on the right, px.
    fn overhang(&self) -> f64 {
        let ends = self.x.ticks.values.iter().zip(&self.x.ticks.labels).map(|(value, label)| {
            self.x.map.position(*value) + 0.5 * font::width(label, TICK_SIZE) - self.area.right
        });
        if self.x.has_texts { ends.fold(0.0, f64::max) } else { 0.0 }
    }
}

/// Ends of the abscissa that all panels share, if they do.
fn shared_ends(figure: &Figure) -> Option<[f64; 2]> {
    let first = &figure.panels.first()?.x;
    let is_shared = figure.panels.iter().all(|panel| panel.x == *first && !panel.equal_scale);
    let values = figure.panels.iter().flat_map(|panel| panel.values(0));
    is_shared.then(|| first.ends(values, margin_of_x(&figure.panels)))
}

/// Margin of the abscissa: curves over time fill the width, others keep off both ends.
fn margin_of_x(panels: &[Panel]) -> Margin {
    let is_monotonic = |points: &[[f64; 2]]| {
        let numbers = || points.iter().filter(|point| !point[1].is_nan());
        numbers().is_sorted_by(|a, b| a[0] <= b[0]) || numbers().is_sorted_by(|a, b| a[0] >= b[0])
    };
    let is_over_time =
        panels.iter().flat_map(|panel| &panel.curves).all(|curve| is_monotonic(&curve.points));
    if is_over_time { Margin::None } else { Margin::Narrow }
}

fn place_panels(
    figure: &Figure,
    size: Size,
    insets: &Insets,
    shared: Option<[f64; 2]>,
) -> Vec<PanelLayout> {
    let (n_columns, n_rows) = figure.grid();
    let n = figure.panels.len();
    // Texts of a shared abscissa stand below the lowest panel of each column, others below each.
    let has_texts = |idx: usize| shared.is_none() || idx + n_columns >= n;
    let below = |row: usize| {
        let is_any = (row * n_columns..((row + 1) * n_columns).min(n)).any(has_texts);
        if is_any { TICK_GAP + TICK_SIZE + AXIS_SIZE * LINE + 3.0 } else { 0.0 }
    };
    let title = if figure.title.is_empty() { 0.0 } else { TITLE_SIZE * LINE + 6.0 };
    let texts = |insets: &[f64]| insets.iter().sum::<f64>();
    let all_below: f64 = (0..n_rows).map(below).sum();
    // Columns share the free width equally, and rows the free height.
    let free = [
        size.width - texts(&insets.left) - texts(&insets.right),
        size.height - title - texts(&insets.above) - all_below,
    ];
    let [width, height] = [(free[0], n_columns, BETWEEN[0]), (free[1], n_rows, BETWEEN[1])].map(
        |(free, n, between)| ((free - 2.0 * MARGIN - between * (n - 1) as f64) / n as f64).max(1.0),
    );
    // A panel with its legend, whatever the legend's height.
    let whole = size.height - title - all_below - 2.0 * MARGIN - BETWEEN[1] * (n_rows - 1) as f64;
    let max_rows = count(LEGEND * whole / n_rows as f64 / legend::ROW_HEIGHT, [1.0, 100.0]);
    let panel_at = |(idx, panel): (usize, &Panel)| {
        let (column, row) = (idx % n_columns, idx / n_columns);
        let left = MARGIN
            + texts(&insets.left[..=column])
            + texts(&insets.right[..column])
            + column as f64 * (width + BETWEEN[0]);
        let top = MARGIN
            + title
            + texts(&insets.above[..=row])
            + (0..row).map(below).sum::<f64>()
            + row as f64 * (height + BETWEEN[1]);
        let area = Area { left, top, right: left + width, bottom: top + height };
        let space = Space { area, left_inset: insets.left[column], max_rows };
        place_panel(panel, &space, shared, has_texts(idx))
    };
    figure.panels.iter().enumerate().map(panel_at).collect()
}

/// The space that a panel has.
struct Space {
    area: Area,
    /// Left of the area, px.
    left_inset: f64,
    /// Rows that its legend is to have at most.
    max_rows: usize,
}

fn place_panel(
    panel: &Panel,
    space: &Space,
    shared: Option<[f64; 2]>,
    has_texts: bool,
) -> PanelLayout {
    let &Space { area, left_inset, max_rows } = space;

    // Ends of both axes, with one scale for both if the panel has equal scales.
    let margin = margin_of_x(std::slice::from_ref(panel));
    let mut x_ends = shared.unwrap_or_else(|| panel.x.ends(panel.values(0), margin));
    let mut y_ends = panel.y.ends(panel.values(1), Margin::Narrow);
    let (width, height) = (area.right - area.left, area.bottom - area.top);
    if panel.equal_scale && [panel.x.scale, panel.y.scale] == [Scale::Linear; 2] {
        widen(&mut x_ends, &mut y_ends, width / height);
    }

    // The legend above the area.
    let legend = legend::entries(&panel.curves, width, max_rows);
    let legend_at = [area.left, area.top - legend::height(&legend) + 0.5 * legend::ROW_HEIGHT];

    // The abscissa, its title centred below its numbers.
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

    // The ordinate, its title along the left.
    let y_map = Map::new(y_ends, [area.bottom, area.top], panel.y.scale);
    let mut y_ticks = panel.y.ticks(y_ends, count(height / TICK_SPACE, [2.0, 10.0]));
    keep_apart(&mut y_ticks, &y_map);
    let y_title = panel.y.title_within(&y_ticks, AXIS_SIZE, height + legend::height(&legend));
    // A title that is longer than its axis extends upwards, next to the legend.
    let length = font::width(&y_title, AXIS_SIZE);
    let middle = (0.5 * (area.top + area.bottom)).min(area.bottom - 0.5 * length);
    let y = Side {
        map: y_map,
        ticks: y_ticks,
        title: y_title,
        title_at: [area.left - left_inset + AXIS_SIZE * 0.85, middle],
        has_texts: true,
    };
    PanelLayout { area, x, y, legend, legend_at }
}

/// Leaves out numbers of an ordinate that would touch others; those kept include zero.
fn keep_apart(ticks: &mut Ticks, map: &Map) {
    let positions: Vec<f64> = ticks.values.iter().map(|&value| map.position(value)).collect();
    let gaps = positions.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let gap = gaps.fold(f64::INFINITY, f64::min);
    let stride = [1_usize, 2, 5, 10].into_iter().find(|&n| n as f64 * gap >= LINE_SPACE);
    let stride = stride.unwrap_or(ticks.values.len());
    let zero = ticks.values.iter().position(|&value| value == 0.0).unwrap_or(0);
    for (idx, label) in ticks.labels.iter_mut().enumerate() {
        if !idx.abs_diff(zero).is_multiple_of(stride.max(1)) {
            label.clear();
        }
    }
}

/// The most ticks whose numbers fit into the width.
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

/// Widens one of two ranges, so that both have one scale in an area of this ratio of width to
/// height.
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
