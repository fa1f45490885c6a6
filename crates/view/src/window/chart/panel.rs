//! A panel: a legend that tells values and hides curves, and the plot below it.

use bksim_plot::Theme;
use egui::{Color32, PointerButton, RichText, Sense, Stroke, Ui, Vec2b, vec2};
use egui_plot::{
    AxisHints, Line as PlotLine, LineStyle, Plot, PlotBounds, PlotPoint, PlotPoints, VLine,
};

use super::graph::{Graph, Line, Measured, ends};
use super::seen::{Window, between, clipped, thinned};
use crate::window::number;

/// Enlargement per point of scrolling: a notch of the wheel is about a fifth.
const PER_POINT: f32 = 0.004;

/// Room between curves and the edges, in parts of their extent.
const MARGIN: f64 = 0.05;

/// Smallest extent of an axis, in parts of the numbers at its ends: below it they are all the same.
const FINEST: f64 = 1e-10;

/// From where to where a panel goes; the extent of what there is where nothing is said.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct View {
    pub(super) x: Option<[f64; 2]>,
    pub(super) y: Option<[f64; 2]>,
}

/// What the pointer did in a panel.
pub(super) struct Read {
    /// Where it is along the axis of all panels.
    pub(super) cursor: Option<f64>,
    /// Whether the view is another one.
    pub(super) is_moved: bool,
}

/// Shows a panel in the room there is.
pub(super) fn show(
    ui: &mut Ui,
    graph: &mut Graph,
    view: &mut View,
    cursor: Option<f64>,
    theme: &Theme,
) -> Read {
    let cursor = cursor.filter(|_| graph.is_over_time);
    legend(ui, graph, cursor, theme);
    let n_columns = ui.available_width().max(1.0).round();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand")]
    let n_columns = n_columns as usize;
    let window = window(graph, *view);
    let lines = graph.lines.iter().enumerate();
    let lines: Vec<(&Line, Vec<Vec<PlotPoint>>)> = lines
        .filter(|(place, _)| !graph.hidden.contains(place))
        .map(|(_, line)| (line, seen(line, graph.is_over_time, window, n_columns)))
        .collect();

    let response = plot(graph, view, theme).show(ui, |plot| {
        plot.set_plot_bounds_x(window.x[0]..=window.x[1]);
        plot.set_plot_bounds_y(window.y[0]..=window.y[1]);
        for (line, parts) in lines {
            for part in parts {
                let color = color32(theme.palette[line.color % theme.palette.len()]);
                let points = PlotPoints::Owned(part);
                let drawn = PlotLine::new(line.name.as_str(), points).allow_hover(false);
                plot.line(drawn.color(color).width(1.6).style(style(line.dash)));
            }
        }
        if let Some(x) = cursor {
            let line = VLine::new("cursor", x).color(color32(theme.axis)).allow_hover(false);
            plot.vline(line.width(1.0));
        }
        // The wheel zooms where the pointer is: over time, along the time.
        let scroll = plot.ctx().input(|input| input.smooth_scroll_delta().y);
        if scroll != 0.0 && plot.response().contains_pointer() {
            let factor = (PER_POINT * scroll).exp();
            let along_y = if graph.is_over_time { 1.0 } else { factor };
            plot.zoom_bounds_around_hovered(vec2(factor, along_y));
        }
        plot.pointer_coordinate().filter(|_| plot.response().hovered())
    });
    let before = *view;
    if response.response.double_clicked() {
        *view = View::default();
    } else {
        take(view, window, response.transform.bounds());
    }
    let pointer = response.inner;
    if let (Some(at), false) = (pointer, graph.is_over_time) {
        let words = [(&graph.x, at.x), (&graph.y, at.y)];
        let words =
            words.map(|(axis, x)| format!("{} {}", axis.name, number::value(axis.value(x))));
        response.response.on_hover_text_at_pointer(words.join("\n"));
    }
    let cursor = pointer.filter(|_| graph.is_over_time).map(|at| at.x);
    Read { cursor, is_moved: *view != before }
}

/// What the plot does by itself.
fn plot<'a>(graph: &'a Graph, view: &View, theme: &Theme) -> Plot<'a> {
    // What follows the curves cannot be dragged.
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
        .custom_x_axes(vec![axis(AxisHints::new_x(), &graph.x).label_spacing(38.0..=60.0)])
        .custom_y_axes(vec![
            axis(AxisHints::new_y(), &graph.y).label_spacing(20.0..=36.0).min_thickness(52.0),
        ]);
    if graph.is_equal { plot.data_aspect(1.0) } else { plot }
}

/// What an axis measures, and numbers instead of logarithms.
fn axis<'a>(hints: AxisHints<'a>, measured: &'a Measured) -> AxisHints<'a> {
    let hints = hints.label(RichText::new(&measured.name).small());
    if !measured.is_logarithmic {
        return hints;
    }
    hints.formatter(|mark, _| format!("{:.0e}", measured.value(mark.value)))
}

/// Takes over where the plot has been moved to.
fn take(view: &mut View, shown: Window, bounds: &PlotBounds) {
    let ([left, bottom], [right, top]) = (bounds.min(), bounds.max());
    let is_other = |a: [f64; 2], b: [f64; 2]| {
        let slack = 1e-9 * (a[1] - a[0]).abs();
        (a[0] - b[0]).abs() > slack || (a[1] - b[1]).abs() > slack
    };
    let is_fine = |[low, high]: [f64; 2]| {
        let size = low.abs().max(high.abs());
        high - low > FINEST * size && size <= bksim_plot::LARGEST
    };
    for (place, now, old) in
        [(&mut view.x, [left, right], shown.x), (&mut view.y, [bottom, top], shown.y)]
    {
        if is_other(old, now) && is_fine(now) {
            *place = Some(now);
        }
    }
}

/// The rectangle that a view shows.
fn window(graph: &Graph, view: View) -> Window {
    let x = view.x.or_else(|| {
        let margin = if graph.is_over_time { 0.0 } else { MARGIN };
        graph.x_ends().map(|ends| widened(ends, margin))
    });
    let x = x.unwrap_or([0.0, 1.0]);
    let shown = graph.lines.iter().enumerate().filter(|(place, _)| !graph.hidden.contains(place));
    let pieces = shown.flat_map(|(_, line)| &line.pieces);
    let heights = pieces.flat_map(|piece| {
        let points = if graph.is_over_time { between(piece, x) } else { piece };
        points.iter().map(|point| point.y)
    });
    let y = view.y.or_else(|| ends(heights).map(|ends| widened(ends, MARGIN)));
    Window { x, y: y.unwrap_or([0.0, 1.0]) }
}

/// Ends with some room, and apart from each other.
fn widened([low, high]: [f64; 2], margin: f64) -> [f64; 2] {
    let (extent, size) = (high - low, low.abs().max(high.abs()));
    if extent > FINEST * size {
        return [low - margin * extent, high + margin * extent];
    }
    let half = if size > 0.0 { 0.1 * size } else { 1.0 };
    [low - half, high + half]
}

/// What is seen of a curve.
fn seen(line: &Line, is_over_time: bool, window: Window, n: usize) -> Vec<Vec<PlotPoint>> {
    let parts = line.pieces.iter().map(|piece| {
        if is_over_time {
            clipped(&thinned(between(piece, window.x), window.x, n), window)
        } else {
            clipped(piece, window)
        }
    });
    parts.flatten().collect()
}

/// Names of the curves, with their values at the cursor; a click hides one.
fn legend(ui: &mut Ui, graph: &mut Graph, cursor: Option<f64>, theme: &Theme) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().interact_size.y = 18.0;
        ui.spacing_mut().item_spacing = vec2(14.0, 2.0);
        for (place, line) in graph.lines.iter().enumerate() {
            let is_hidden = graph.hidden.contains(&place);
            let value = cursor.filter(|_| !is_hidden).and_then(|x| line.at(x));
            let value = value.map(|y| number::value(graph.y.value(y))).unwrap_or_default();
            let color = color32(theme.palette[line.color % theme.palette.len()]);
            if name(ui, line, color, is_hidden, &value).clicked() && !graph.hidden.remove(&place) {
                graph.hidden.insert(place);
            }
        }
    });
}

/// A piece of line, the name, and room for a value, so that nothing moves with the pointer.
fn name(ui: &mut Ui, line: &Line, color: Color32, is_hidden: bool, value: &str) -> egui::Response {
    let text = ui.visuals().text_color();
    let faint = if is_hidden { 0.4 } else { 1.0 };
    let font = |style| ui.style().text_styles[&style].clone();
    let (words, numbers) = (font(egui::TextStyle::Body), font(egui::TextStyle::Monospace));
    let painter = ui.painter();
    let words = painter.layout_no_wrap(line.name.clone(), words, text.gamma_multiply(faint));
    let room = painter.layout_no_wrap("-8.8888e-88".to_owned(), numbers.clone(), text).size().x;
    let numbers = painter.layout_no_wrap(value.to_owned(), numbers, text);
    let size = vec2(30.0 + words.size().x + 6.0 + room, 18.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
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

    /// A flat stretch and a peak behind it.
    fn graph() -> Graph {
        let points = vec![[0.0, 1.0], [4.0, 1.0], [5.0, 11.0], [6.0, 1.0]];
        let (x, y) = (Axis::new("time", "s"), Axis::new("force", "N"));
        Graph::new(&Panel::new(x, y, vec![Curve::new("f", points)]))
    }

    #[test]
    fn the_ordinates_follow_what_is_seen_until_they_are_chosen() {
        let graph = graph();
        let whole = window(&graph, View::default());
        assert_eq!((whole.x, whole.y), ([0.0, 6.0], [0.5, 11.5]));
        let flat = window(&graph, View { x: Some([0.0, 3.0]), y: None });
        assert!(flat.y[0] < 1.0 && flat.y[1] > 1.0 && flat.y[1] < 2.0, "{flat:?}");
        let chosen = window(&graph, View { x: Some([0.0, 3.0]), y: Some([-5.0, 5.0]) });
        assert_eq!(chosen.y, [-5.0, 5.0]);
    }

    #[test]
    fn hidden_curves_have_no_say_and_a_panel_of_none_is_still_one() {
        let mut graph = graph();
        graph.hidden.insert(0);
        assert_eq!(window(&graph, View::default()), Window { x: [0.0, 6.0], y: [0.0, 1.0] });
    }

    #[test]
    fn a_view_takes_over_moves_but_neither_rounding_nor_what_has_no_extent() {
        let shown = Window { x: [0.0, 6.0], y: [0.0, 1.0] };
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
