//! [`Graph`]: a panel of a figure, prepared to be shown in every frame.

use std::collections::BTreeSet;

use bksim_plot::{Axis, Panel, Point, Scale};
use egui_plot::PlotPoint;

/// A panel of a figure. Positions on a logarithmic axis are logarithms to the base of ten.
pub(super) struct Graph {
    pub(super) x: Measured,
    pub(super) y: Measured,
    pub(super) lines: Vec<Line>,
    /// True if a unit is equally long in both directions.
    pub(super) is_equal: bool,
    /// True if every curve has one value at each abscissa, as over time.
    pub(super) is_over_time: bool,
    /// Indices of the curves that are not shown.
    pub(super) hidden: BTreeSet<usize>,
}

/// An axis of a panel.
pub(super) struct Measured {
    /// Quantity and unit, such as `angle (rad)`.
    pub(super) name: String,
    pub(super) is_logarithmic: bool,
}

/// A curve as pieces between its gaps.
pub(super) struct Line {
    pub(super) name: String,
    /// Number of its colour.
    pub(super) color: usize,
    /// Number of its dashes.
    pub(super) dash: usize,
    pub(super) pieces: Vec<Vec<PlotPoint>>,
}

impl Measured {
    fn new(axis: &Axis) -> Self {
        Self { name: axis.name(), is_logarithmic: axis.scale == Scale::Logarithmic }
    }

    /// The number at a position on the axis.
    pub(super) fn value(&self, position: f64) -> f64 {
        if self.is_logarithmic { 10f64.powf(position) } else { position }
    }

    /// The position of a number on the axis; not finite if it has none.
    fn position(&self, value: f64) -> f64 {
        if self.is_logarithmic { value.log10() } else { value }
    }
}

impl Graph {
    pub(super) fn new(panel: &Panel) -> Self {
        let (x, y) = (Measured::new(&panel.x), Measured::new(&panel.y));
        let mut lines = Vec::new();
        for curve in &panel.curves {
            let positions = curve.points.iter().map(|&[a, b]| [x.position(a), y.position(b)]);
            lines.push(Line {
                name: curve.name.clone(),
                color: curve.color,
                dash: curve.dash,
                pieces: pieces(positions),
            });
        }
        let all = || lines.iter().flat_map(|line| &line.pieces);
        let is_over_time = all().all(|piece| piece.is_sorted_by(|a, b| a.x <= b.x));
        let is_equal = panel.equal_scale;
        Self { x, y, lines, is_equal, is_over_time, hidden: BTreeSet::new() }
    }

    /// The curves that are not hidden.
    pub(super) fn shown(&self) -> impl Iterator<Item = &Line> {
        let lines = self.lines.iter().enumerate();
        lines.filter(|(idx, _)| !self.hidden.contains(idx)).map(|(_, line)| line)
    }

    /// The smallest and the largest abscissa.
    pub(super) fn x_ends(&self) -> Option<[f64; 2]> {
        let all = self.lines.iter().flat_map(|line| line.pieces.iter().flatten());
        ends(all.map(|point| point.x))
    }
}

impl Line {
    /// The value of a curve over time at an abscissa, interpolated linearly; none in gaps.
    pub(super) fn at(&self, x: f64) -> Option<f64> {
        let is_over = |piece: &&Vec<PlotPoint>| {
            piece.first().is_some_and(|a| a.x <= x) && piece.last().is_some_and(|b| x <= b.x)
        };
        let piece = self.pieces.iter().find(is_over)?;
        let after = piece.partition_point(|point| point.x < x).max(1).min(piece.len() - 1);
        let (a, b) = (piece[after.saturating_sub(1)], piece[after]);
        let part = if b.x > a.x { (x - a.x) / (b.x - a.x) } else { 1.0 };
        Some(a.y + part * (b.y - a.y))
    }
}

/// The smallest and the largest of numbers.
pub(super) fn ends(numbers: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    numbers.fold(None, |ends, x| {
        let [low, high] = ends.unwrap_or([x, x]);
        Some([low.min(x), high.max(x)])
    })
}

/// The pieces of points between gaps, those with falling abscissae reversed.
fn pieces(points: impl Iterator<Item = Point>) -> Vec<Vec<PlotPoint>> {
    let mut pieces = vec![Vec::new()];
    for [x, y] in points {
        // Differences of larger numbers would overflow.
        let is_drawn = x.abs() <= bksim_plot::LARGEST && y.abs() <= bksim_plot::LARGEST;
        match pieces.last_mut() {
            Some(piece) if is_drawn => piece.push(PlotPoint::new(x, y)),
            Some(piece) if piece.is_empty() => (),
            _ => pieces.push(Vec::new()),
        }
    }
    pieces.retain(|piece| !piece.is_empty());
    for piece in &mut pieces {
        if piece.is_sorted_by(|a, b| a.x >= b.x) {
            piece.reverse();
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use bksim_plot::Curve;

    use super::*;

    fn graph(points: &[Point], scale: Scale) -> Graph {
        let y = Axis { scale, ..Axis::new("force", "N") };
        Graph::new(&Panel::new(Axis::new("time", "s"), y, vec![Curve::new("f", points.to_vec())]))
    }

    #[test]
    fn values_lie_between_points_and_gaps_have_none() {
        let gap = [1.5, f64::NAN];
        let of = graph(&[[0.0, 1.0], [1.0, 3.0], gap, [2.0, 5.0], [3.0, 5.0]], Scale::Linear);
        let line = &of.lines[0];
        assert_eq!(line.pieces.len(), 2);
        assert!(of.is_over_time);
        assert_eq!([0.0, 0.25, 1.0, 2.5, 3.0].map(|x| line.at(x)), {
            [Some(1.0), Some(1.5), Some(3.0), Some(5.0), Some(5.0)]
        });
        assert_eq!([-0.1, 1.5, 3.1, f64::NAN].map(|x| line.at(x)), [None; 4]);
        assert_eq!(of.x_ends(), Some([0.0, 3.0]));
    }

    #[test]
    fn runs_back_in_time_are_reversed_and_closed_curves_are_not_over_time() {
        let back = graph(&[[2.0, 0.0], [1.0, 4.0], [0.0, 4.0]], Scale::Linear);
        assert!(back.is_over_time);
        assert_eq!(back.lines[0].at(1.5), Some(2.0));
        let round = graph(&[[0.0, 0.0], [1.0, 1.0], [0.0, 2.0]], Scale::Linear);
        assert!(!round.is_over_time);
    }

    #[test]
    fn logarithms_leave_gaps_where_there_are_none() {
        let of = graph(&[[0.0, 10.0], [1.0, -1.0], [2.0, 1000.0]], Scale::Logarithmic);
        let positions: Vec<f64> = of.lines[0].pieces.iter().flatten().map(|p| p.y).collect();
        assert_eq!(positions.len(), 2);
        assert!((positions[0] - 1.0).abs() < 1e-12 && (positions[1] - 3.0).abs() < 1e-12);
        assert!((of.y.value(positions[1]) - 1000.0).abs() < 1e-9);
        assert_eq!(of.y.name, "force (N)");
        let empty = graph(&[[0.0, f64::NAN]], Scale::Linear);
        assert_eq!((empty.x_ends(), empty.lines[0].at(0.0)), (None, None));
    }
}
