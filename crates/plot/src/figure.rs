//! Figures as plain data.

use crate::Axis;
use crate::decimate::Point;

/// Panels under one title.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Figure {
    /// Title above all panels; may be empty.
    pub title: String,
    /// Panels in reading order.
    pub panels: Vec<Panel>,
    /// How many panels stand side by side; one or two, by their number, unless given.
    pub n_columns: Option<usize>,
}

/// Curves on one pair of axes.
#[derive(Clone, PartialEq, Debug)]
pub struct Panel {
    /// Abscissa, towards the right.
    pub x: Axis,
    /// Ordinate, upwards.
    pub y: Axis,
    /// Curves in the order of the legend, the first drawn first.
    pub curves: Vec<Curve>,
    /// True if a unit is equally long in both directions, as for the path of a point; for linear
    /// axes.
    pub equal_scale: bool,
}

/// A line through points.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points; one that is not finite makes a gap.
    pub points: Vec<Point>,
    /// Number of its colour in [`crate::Theme::palette`], which repeats.
    pub color: usize,
    /// Number of its dashes: solid, dashed, dotted, dash-dotted, which repeat.
    pub dash: usize,
    /// The line through its points, or the points themselves.
    pub mark: Mark,
}

/// How a curve is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Mark {
    /// A line through its points.
    #[default]
    Line,
    /// A dot at each of its points.
    Dots,
    /// A bar from zero to the abscissa of each point, at the height of its ordinate.
    Bars,
}

/// Width and height of a picture, in CSS pixels of 1/96 inch.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Size {
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Figure {
    /// A figure of these panels.
    pub fn new(title: &str, panels: Vec<Panel>) -> Self {
        Self { title: title.to_owned(), panels, n_columns: None }
    }

    /// The figure with all its texts replaced.
    #[must_use]
    pub fn renamed(&self, rename: &dyn Fn(&str) -> String) -> Self {
        let axis = |axis: &Axis| Axis {
            label: rename(&axis.label),
            unit: rename(&axis.unit),
            ..axis.clone()
        };
        let curve = |curve: &Curve| Curve { name: rename(&curve.name), ..curve.clone() };
        let panel = |panel: &Panel| Panel {
            x: axis(&panel.x),
            y: axis(&panel.y),
            curves: panel.curves.iter().map(curve).collect(),
            equal_scale: panel.equal_scale,
        };
        let panels = self.panels.iter().map(panel).collect();
        Self { title: rename(&self.title), panels, n_columns: self.n_columns }
    }

    /// Number of columns and of rows of the panels.
    pub fn grid(&self) -> (usize, usize) {
        let n = self.panels.len().max(1);
        let n_columns = self.n_columns.unwrap_or(if n <= 3 { 1 } else { 2 }).max(1);
        (n_columns, n.div_ceil(n_columns))
    }

    /// The size at which all panels are well readable.
    pub fn natural_size(&self) -> Size {
        let (n_columns, n_rows) = self.grid();
        let is_path = self.panels.iter().any(|panel| panel.equal_scale);
        let height = match n_rows {
            1 if is_path => 560.0,
            1 => 440.0,
            n => 40.0 + 250.0 * n as f64,
        };
        let width = match n_columns {
            1 => 720.0,
            n => 960.0f64.max(360.0 * n as f64),
        };
        Size { width, height }
    }
}

impl Panel {
    /// A panel; the curves get colours by their order, and dashes when the colours repeat.
    pub fn new(x: Axis, y: Axis, mut curves: Vec<Curve>) -> Self {
        let n_colors = crate::Theme::LIGHT.palette.len();
        for (idx, curve) in curves.iter_mut().enumerate() {
            (curve.color, curve.dash) = (idx % n_colors, idx / n_colors);
        }
        Self { x, y, curves, equal_scale: false }
    }

    /// Coordinates of all points along an axis.
    pub(crate) fn values(&self, axis: usize) -> impl Iterator<Item = f64> {
        let points = self.curves.iter().flat_map(|curve| &curve.points);
        // The abscissa of a gap does not count.
        points.filter(|point| !point[1].is_nan()).map(move |point| point[axis])
    }
}

impl Curve {
    /// A curve of the first colour.
    pub fn new(name: &str, points: Vec<Point>) -> Self {
        Self { name: name.to_owned(), points, color: 0, dash: 0, mark: Mark::Line }
    }
}
