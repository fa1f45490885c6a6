//! A panel: a legend with values, which hides curves, and the plot below it.

use bksim_plot::Theme;
use egui::{Color32, PointerButton, RichText, Sense, Stroke, Ui, Vec2b, vec2};
use egui_plot::{
    AxisHints, Line as PlotLine, LineStyle, Plot, PlotBounds, PlotPoint, PlotPoints, PlotUi, VLine,
};

use super::clip::{Bounds, between, clipped, thinned};
use super::graph::{Graph, Line, Measured, ends};
use crate::window::{grid, number};

/// Distances of labels, points: the grid has no lines that are too near.
const ANY: std::ops::RangeInclusive<f32> = 1.0..=2.0;

/// Enlargement per point of scrolling: a notch of the wheel is about a fifth.
const PER_POINT: f32 = 0.004;

/// Margin between curves and the edges, as a fraction of their extent.
const MARGIN: f64 = 0.05;

/// Smallest extent of an axis, relative to the numbers at its ends: below it they are all the same.
const FINEST: f64 = 1e-10;

/// The chosen ranges of a panel's axes; those of the curves where none is chosen.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct View {
    pub(super) x: Option<[f64; 2]>,
    pub(super) y: Option<[f64; 2]>,
}

/// The effect of the pointer on a panel.
pub(super) struct PointerInput {
    /// Position on the common axis of all panels.
    pub(super) cursor: Option<f64>,
    /// True if it has changed the view.
    pub(super) is_moved: bool,
}

/// Shows a panel in all the space that is left.
pub(super) fn show(
    ui: &mut Ui,
    graph: &mut Graph,
    view: &mut View,
    cursor: Option<f64>,
    theme: &Theme,
) -> PointerInput {
    let cursor = cursor.filter(|_| graph.is_over_time);
    legend(ui, graph, cursor, theme);

    // The visible parts of the curves, no finer than columns of pixels.
    let n_columns = ui.available_width().max(1.0).round();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand")]
    let n_columns = n_columns as usize;
    let bounds = bounds(graph, *view);
    let lines: Vec<(&Line, Vec<Vec<PlotPoint>>)> = graph
        .shown()
        .map(|line| (line, visible_parts(line, graph.is_over_time, bounds, n_columns)))
        .collect();

    // The curves and the cursor; the wheel zooms at the pointer, over time along the time alone.
    let response = plot(graph, view, theme).show(ui, |plot| {
        plot.set_plot_bounds_x(bounds.x[0]..=bounds.x[1]);
        plot.set_plot_bounds_y(bounds.y[0]..=bounds.y[1]);
        for (line, parts) in lines {
            draw(plot, line, parts, theme);
        }
        if let Some(x) = cursor {
            let line = VLine::new("cursor", x).color(color32(theme.axis)).allow_hover(false);
            plot.vline(line.width(1.0));
        }
        let scroll = plot.ctx().input(|input| input.smooth_scroll_delta().y);
        if scroll != 0.0 && plot.response().contains_pointer() {
            let factor = (PER_POINT * scroll).exp();
            let along_y = if graph.is_over_time { 1.0 } else { factor };
            plot.zoom_bounds_around_hovered(vec2(factor, along_y));
        }
        plot.pointer_coordinate().filter(|_| plot.response().hovered())
    });

    // A double click shows everything again; otherwise the view follows drags and zooms.
    let before = *view;
    if response.response.double_clicked() {
        *view = View::default();
    } else {
        take(view, bounds, response.transform.bounds());
    }

    // The values at the pointer: in the legend over time, else next to the pointer.
    let pointer = response.inner;
    if let (Some(at), false) = (pointer, graph.is_over_time) {
        let words = [(&graph.x, at.x), (&graph.y, at.y)];
        let words =
            words.map(|(axis, x)| format!("{} {}", axis.name, number::value(axis.value(x))));
        response.response.on_hover_text_at_pointer(words.join("\n"));
    }
    let cursor = pointer.filter(|_| graph.is_over_time).map(|at| at.x);
    PointerInput { cursor, is_moved: *view != before }
}

/// Draws the visible parts of a curve.
fn draw<'a>(plot: &mut PlotUi<'a>, line: &'a Line, parts: Vec<Vec<PlotPoint>>, theme: &Theme) {
    let color = color32(theme.palette[line.color % theme.palette.len()]);
    for part in parts {
        let points = PlotPoints::Owned(part);
        let drawn = PlotLine::new(line.name.as_str(), points).allow_hover(false);
        plot.line(drawn.color(color).width(1.6).style(style(line.dash)));
    }
}

/// The plot of a panel, with its axes and the gestures that it handles itself.
fn plot<'a>(graph: &'a Graph, view: &View, theme: &Theme) -> Plot<'a> {
    // Ordinates that follow the curves cannot be dragged.
    let follows = graph.is_over_time && view.y.is_none();
    let plot = Plot::new("plot")
        .allow_drag(Vec2b::new(true, !follows))
        .allow_scroll(false)
        .allow_zoom(Vec2b::new(true, !graph.is_over_time))
        .allow_axis_zoom_drag(true)
        .allow_double_click_reset(false)
        .boxed_zoom_pointer_button(PointerButton::Secondary)
        .show_x(false)
        .show_y(false)
        .show_crosshair(false)
        .label_formatter(|_| None)
        .grid_spacing(36.0..=300.0)
        .grid_color(color32(theme.axis).gamma_multiply(0.4))
        .custom_x_axes(vec![axis(AxisHints::new_x(), &graph.x).label_spacing(ANY)])
        .custom_y_axes(vec![
            axis(AxisHints::new_y(), &graph.y).label_spacing(ANY).min_thickness(52.0),
        ]);
    // Positions on a logarithmic axis are whole where the numbers are powers of ten.
    let plot = if graph.x.is_logarithmic { plot } else { plot.x_grid_spacer(grid::marks) };
    let plot = if graph.y.is_logarithmic { plot } else { plot.y_grid_spacer(grid::marks) };
    if graph.is_equal { plot.data_aspect(1.0) } else { plot }
}

/// An axis with its name, and with numbers instead of logarithms.
fn axis<'a>(hints: AxisHints<'a>, measured: &'a Measured) -> AxisHints<'a> {
    let hints = hints.label(RichText::new(&measured.name).small());
    if !measured.is_logarithmic {
        return hints.formatter(|mark, _| grid::label(mark));
    }
    hints.formatter(|mark, _| format!("{:.0e}", measured.value(mark.value)))
}

/// Takes over the ranges that a drag or a zoom has moved the plot to.
fn take(view: &mut View, shown: Bounds, bounds: &PlotBounds) {
    let ([left, bottom], [right, top]) = (bounds.min(), bounds.max());
    let is_other = |a: [f64; 2], b: [f64; 2]| {
        let slack = 1e-9 * (a[1] - a[0]).abs();
        (a[0] - b[0]).abs() > slack || (a[1] - b[1]).abs() > slack
    };
    let is_fine = |[low, high]: [f64; 2]| {
        let size = low.abs().max(high.abs());
        high - low > FINEST * size && size <= bksim_plot::LARGEST
    };
    for (range, now, old) in
        [(&mut view.x, [left, right], shown.x), (&mut view.y, [bottom, top], shown.y)]
    {
        if is_other(old, now) && is_fine(now) {
            *range = Some(now);
        }
    }
}

/// The bounds of a view: chosen ranges, or those of the curves that are shown.
fn bounds(graph: &Graph, view: View) -> Bounds {
    let x = view.x.or_else(|| {
        let margin = if graph.is_over_time { 0.0 } else { MARGIN };
        graph.x_ends().map(|ends| widened(ends, margin))
    });
    let x = x.unwrap_or([0.0, 1.0]);
    let pieces = graph.shown().flat_map(|line| &line.pieces);
    let heights = pieces.flat_map(|piece| {
        let points = if graph.is_over_time { between(piece, x) } else { piece };
        points.iter().map(|point| point.y)
    });
    let y = view.y.or_else(|| ends(heights).map(|ends| widened(ends, MARGIN)));
    Bounds { x, y: y.unwrap_or([0.0, 1.0]) }
}

/// Ends with a margin, and apart from each other.
fn widened([low, high]: [f64; 2], margin: f64) -> [f64; 2] {
    let (extent, size) = (high - low, low.abs().max(high.abs()));
    if extent > FINEST * size {
        return [low - margin * extent, high + margin * extent];
    }
    let half = if size > 0.0 { 0.1 * size } else { 1.0 };
    [low - half, high + half]
}

/// The visible parts of a curve, thinned to `n` columns over time.
fn visible_parts(line: &Line, is_over_time: bool, bounds: Bounds, n: usize) -> Vec<Vec<PlotPoint>> {
    let parts = line.pieces.iter().map(|piece| {
        if is_over_time {
            clipped(&thinned(between(piece, bounds.x), bounds.x, n), bounds)
        } else {
            clipped(piece, bounds)
        }
    });
    parts.flatten().collect()
}

/// Names of the curves, with their values at the cursor; a click hides one.
fn legend(ui: &mut Ui, graph: &mut Graph, cursor: Option<f64>, theme: &Theme) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().interact_size.y = 18.0;
        ui.spacing_mut().item_spacing = vec2(14.0, 2.0);
        for (idx, line) in graph.lines.iter().enumerate() {
            let is_hidden = graph.hidden.contains(&idx);
            let value = cursor.filter(|_| !is_hidden).and_then(|x| line.at(x));
            let value = value.map(|y| number::value(graph.y.value(y))).unwrap_or_default();
            let color = color32(theme.palette[line.color % theme.palette.len()]);
            if name(ui, line, color, is_hidden, &value).clicked() && !graph.hidden.remove(&idx) {
                graph.hidden.insert(idx);
            }
        }
    });
}

/// A sample of the curve, its name, and space for a value, so that nothing moves with the pointer.
fn name(ui: &mut Ui, line: &Line, color: Color32, is_hidden: bool, value: &str) -> egui::Response {
    // The widths of the texts.
    let text = ui.visuals().text_color();
    let faint = if is_hidden { 0.4 } else { 1.0 };
    let font = |style| ui.style().text_styles[&style].clone();
    let (words, numbers) = (font(egui::TextStyle::Body), font(egui::TextStyle::Monospace));
    let painter = ui.painter();
    let words = painter.layout_no_wrap(line.name.clone(), words, text.gamma_multiply(faint));
    let widest = painter.layout_no_wrap("-8.8888e-88".to_owned(), numbers.clone(), text);
    let numbers = painter.layout_no_wrap(value.to_owned(), numbers, text);
    let size = vec2(30.0 + words.size().x + 6.0 + widest.size().x, 18.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());

    // The sample, with the dashes of the curve.
    let painter = ui.painter();
    let middle = rect.left_center();
    let ends = [middle, middle + vec2(22.0, 0.0)];
    let stroke = Stroke::new(2.2, color.gamma_multiply(faint));
    match style(line.dash) {
        LineStyle::Solid => {
            painter.line_segment(ends, stroke);
        }
        LineStyle::Dotted { .. } => {
            painter.extend(egui::Shape::dotted_line(&ends, stroke.color, 5.0, 1.4));
        }
        LineStyle::Dashed { length } => {
            painter.extend(egui::Shape::dashed_line(&ends, stroke, 0.7 * length, 0.4 * length));
        }
    }

    // The texts; the name of a hidden curve is struck out.
    let at = |x: f32, height: f32| middle + vec2(x, -0.5 * height);
    let width = words.size().x;
    if is_hidden {
        let line = [middle + vec2(30.0, 0.0), middle + vec2(30.0 + width, 0.0)];
        painter.line_segment(line, Stroke::new(1.0, text.gamma_multiply(faint)));
    }
    painter.galley(at(30.0, words.size().y), words, text);
    painter.galley(at(36.0 + width, numbers.size().y), numbers, text);
    let kind = egui::Role::CheckBox;
    let label = line.name.clone();
    response.widget_info(|| egui::WidgetInfo::selected(kind, true, !is_hidden, &label));
    response.on_hover_cursor(egui::CursorIcon::PointingHand)
}

/// Solid, dashed, dotted, and dashes of another length, which repeat.
fn style(dash: usize) -> LineStyle {
    match dash % 4 {
        0 => LineStyle::Solid,
        1 => LineStyle::Dashed { length: 9.0 },
        2 => LineStyle::Dotted { spacing: 6.0 },
        _ => LineStyle::Dashed { length: 4.0 },
    }
}

fn color32(rgb: u32) -> Color32 {
    let [_, r, g, b] = rgb.to_be_bytes();
    Color32::from_rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use bksim_plot::{Axis, Curve, Panel};

    use super::*;

    /// A flat part and a peak after it.
    fn graph() -> Graph {
        let points = vec![[0.0, 1.0], [4.0, 1.0], [5.0, 11.0], [6.0, 1.0]];
        let (x, y) = (Axis::new("time", "s"), Axis::new("force", "N"));
        Graph::new(&Panel::new(x, y, vec![Curve::new("f", points)]))
    }

    #[test]
    fn the_ordinates_follow_the_visible_curves_until_they_are_chosen() {
        let graph = graph();
        let whole = bounds(&graph, View::default());
        assert_eq!((whole.x, whole.y), ([0.0, 6.0], [0.5, 11.5]));
        let flat = bounds(&graph, View { x: Some([0.0, 3.0]), y: None });
        assert!(flat.y[0] < 1.0 && flat.y[1] > 1.0 && flat.y[1] < 2.0, "{flat:?}");
        let chosen = bounds(&graph, View { x: Some([0.0, 3.0]), y: Some([-5.0, 5.0]) });
        assert_eq!(chosen.y, [-5.0, 5.0]);
    }

    #[test]
    fn hidden_curves_do_not_count_and_a_panel_without_curves_has_bounds() {
        let mut graph = graph();
        graph.hidden.insert(0);
        assert_eq!(bounds(&graph, View::default()), Bounds { x: [0.0, 6.0], y: [0.0, 1.0] });
    }

    #[test]
    fn a_view_takes_over_moves_but_neither_rounding_errors_nor_empty_ranges() {
        let shown = Bounds { x: [0.0, 6.0], y: [0.0, 1.0] };
        let moved = |min, max| {
            let mut view = View::default();
            take(&mut view, shown, &PlotBounds::from_min_max(min, max));
            view
        };
        assert_eq!(moved([0.0, 1e-12], [6.0, 1.0]), View::default());
        assert_eq!(moved([1.0, 0.0], [7.0, 1.0]), View { x: Some([1.0, 7.0]), y: None });
        assert_eq!(moved([2.0, 0.0], [2.0, 1.0]), View::default());
        assert_eq!(moved([2.0, 0.0], [2.0 + 1e-14, 1.0]), View::default());
        assert_eq!(moved([f64::NAN, 0.0], [7.0, 2.0]).x, None);
    }
}
