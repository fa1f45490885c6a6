//! The picture of a sweep: curves over one input, contours over two, points over more.

use bksim_plot::{Axis, Curve, Figure, Mark, Panel, Point, Scale, round_numbers, unit_text};
use bksim_sweep::Table;
use contour::ContourBuilder;

/// Curves of a family, and lines of equal height, that a reader tells apart.
const N_CURVES: usize = 6;
/// Panels that a page holds.
const N_PANELS: usize = 24;

/// The part of a table that is drawn.
pub(super) struct Columns<'t> {
    pub(super) table: &'t Table,
    /// Which outputs.
    pub(super) shown: Vec<usize>,
    /// The input that is the abscissa, where one was named.
    pub(super) across: Option<usize>,
    pub(super) log_y: bool,
}

/// The picture of a table.
pub(super) fn figure(columns: &Columns<'_>, title: &str) -> Figure {
    let inputs = &columns.table.inputs;
    let varied: Vec<usize> =
        (0..inputs.len()).filter(|&idx| values(&inputs[idx].1).len() > 1).collect();
    let (panels, n_columns) = match (columns.table.is_grid, columns.across, varied.as_slice()) {
        (true, Some(across), _) => (columns.families(across), None),
        (_, None, &[one]) => (columns.families(one), None),
        (true, None, &[first, second]) => (columns.contours([first, second]), None),
        (false, Some(across), _) => (columns.points(&[across]), None),
        _ => (columns.points(&varied), Some(varied.len())),
    };
    let mut figure = Figure::new(title, panels);
    figure.panels.truncate(N_PANELS);
    figure.n_columns = n_columns;
    figure
}

impl Columns<'_> {
    fn axis_of_input(&self, input: usize) -> Axis {
        let (column, values) = &self.table.inputs[input];
        let mut axis = Axis::new(&column.name, &column.unit);
        if is_even_in_ratio(&self::values(values)) {
            axis.scale = Scale::Logarithmic;
        }
        axis
    }

    fn axis_of_output(&self, output: usize) -> Axis {
        let (column, _) = &self.table.outputs[output];
        let mut axis = Axis::new(&column.name, &column.unit);
        axis.scale = if self.log_y { Scale::Logarithmic } else { Scale::Linear };
        axis
    }

    /// For each output its curves over an input, one for each combination of the others.
    fn families(&self, across: usize) -> Vec<Panel> {
        let inputs = &self.table.inputs;
        let others: Vec<usize> = (0..inputs.len()).filter(|&idx| idx != across).collect();
        let combination = |case: usize| -> Vec<u64> {
            others.iter().map(|&idx| inputs[idx].1[case].to_bits()).collect()
        };
        let mut members: Vec<(Vec<u64>, Vec<usize>)> = Vec::new();
        for case in 0..inputs[across].1.len() {
            let key = combination(case);
            match members.iter_mut().find(|(known, _)| *known == key) {
                Some((_, cases)) => cases.push(case),
                None => members.push((key, vec![case])),
            }
        }
        // Of many curves those at even distances are drawn, the first and the last among them.
        let n = members.len();
        let kept = (0..n.min(N_CURVES)).map(|idx| match n.min(N_CURVES) {
            1 => 0,
            n_kept => idx * (n - 1) / (n_kept - 1),
        });
        let kept: Vec<&Vec<usize>> = kept.map(|idx| &members[idx].1).collect();
        let name = |case: usize| {
            let words = others.iter().map(|&idx| {
                let (column, values) = &inputs[idx];
                format!("{} = {} {}", column.name, short(values[case]), unit_text(&column.unit))
            });
            words.map(|word| word.trim_end().to_owned()).collect::<Vec<_>>().join(", ")
        };
        let panel = |&output: &usize| {
            let values = &self.table.outputs[output].1;
            let curve = |cases: &&Vec<usize>| {
                let mut points: Vec<Point> =
                    cases.iter().map(|&case| [inputs[across].1[case], values[case]]).collect();
                points.sort_by(|a, b| a[0].total_cmp(&b[0]));
                Curve::new(&name(cases[0]), points)
            };
            let curves = kept.iter().map(curve).collect();
            Panel::new(self.axis_of_input(across), self.axis_of_output(output), curves)
        };
        self.shown.iter().map(panel).collect()
    }

    /// For each output its lines of equal height over two inputs of a grid.
    fn contours(&self, [first, second]: [usize; 2]) -> Vec<Panel> {
        let inputs = &self.table.inputs;
        let [xs, ys] = [first, second].map(|input| values(&inputs[input].1));
        let panel = |&output: &usize| {
            let heights = self.heights(output, [first, second], [&xs, &ys]);
            let (x, y) = (self.axis_of_input(first), self.axis_of_input(second));
            let (column, _) = &self.table.outputs[output];
            let levels = levels(&heights);
            let builder = ContourBuilder::new(xs.len(), ys.len(), true);
            let lines = builder.lines(&heights, &levels).unwrap_or_default();
            let curves = lines.iter().map(|line| {
                let pieces = line.geometry().0.iter().map(|piece| &piece.0);
                let mut points: Vec<Point> = Vec::new();
                for piece in pieces {
                    points.extend(piece.iter().map(|at| {
                        let place = [at.x, at.y].map(|index| index - 0.5);
                        [between(&xs, place[0]), between(&ys, place[1])]
                    }));
                    points.push([f64::NAN; 2]);
                }
                let height = format!("{} {}", short(line.threshold()), unit_text(&column.unit));
                Curve::new(height.trim_end(), points)
            });
            let mut curves: Vec<Curve> = curves.collect();
            // The legend says once what its heights are of.
            if let Some(first) = curves.first_mut() {
                first.name = format!("{}: {}", column.name, first.name);
            }
            // Where mechanisms do not close or run, a map has dots.
            let without = heights.iter().enumerate().filter(|(_, height)| height.is_nan());
            let without: Vec<Point> =
                without.map(|(k, _)| [xs[k % xs.len()], ys[k / xs.len()]]).collect();
            if !without.is_empty() {
                curves.push(Curve { mark: Mark::Dots, ..Curve::new("no answer", without) });
            }
            let mut panel = Panel::new(x, y, curves);
            panel.x.range = ends(&xs);
            panel.y.range = ends(&ys);
            panel
        };
        // What does not vary has no lines.
        self.shown.iter().map(panel).filter(|panel| !panel.curves.is_empty()).collect()
    }

    /// The values of an output row by row of a grid; what failed is NaN.
    fn heights(
        &self,
        output: usize,
        [first, second]: [usize; 2],
        [xs, ys]: [&[f64]; 2],
    ) -> Vec<f64> {
        let inputs = &self.table.inputs;
        let mut heights = vec![f64::NAN; xs.len() * ys.len()];
        for (case, &height) in self.table.outputs[output].1.iter().enumerate() {
            let at = |sorted: &[f64], value: f64| sorted.iter().position(|known| *known == value);
            let place = at(xs, inputs[first].1[case]).zip(at(ys, inputs[second].1[case]));
            if let Some((column, row)) = place {
                heights[row * xs.len() + column] = height;
            }
        }
        heights
    }

    /// For each output and each of these inputs the cases as points.
    fn points(&self, inputs: &[usize]) -> Vec<Panel> {
        let panels = self.shown.iter().flat_map(|&output| {
            inputs.iter().map(move |&input| {
                let (xs, ys) = (&self.table.inputs[input].1, &self.table.outputs[output].1);
                let points = xs.iter().zip(ys).map(|(x, y)| [*x, *y]).collect();
                let dots = Curve { mark: Mark::Dots, ..Curve::new("cases", points) };
                Panel::new(self.axis_of_input(input), self.axis_of_output(output), vec![dots])
            })
        });
        panels.collect()
    }
}

/// The values of an input, each once, in order.
fn values(all: &[f64]) -> Vec<f64> {
    let mut values = all.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// True of values at even ratios that span more than a decade.
fn is_even_in_ratio(values: &[f64]) -> bool {
    let [first, second, .., last] = values else { return false };
    let ratio = second / first;
    let is_even = values.windows(2).all(|pair| (pair[1] / pair[0] / ratio - 1.0).abs() < 1e-6);
    *first > 0.0 && last / first > 10.0 && is_even
}

/// Round heights inside of what the numbers span.
fn levels(heights: &[f64]) -> Vec<f64> {
    let numbers = || heights.iter().copied().filter(|height| height.is_finite());
    let (Some(low), Some(high)) = (numbers().reduce(f64::min), numbers().reduce(f64::max)) else {
        return Vec::new();
    };
    let inside = round_numbers(low, high, N_CURVES).into_iter();
    inside.filter(|level| low < *level && *level < high).take(N_CURVES).collect()
}

/// The value at a place between the values of an axis; NaN outside, where lines follow the border.
fn between(values: &[f64], place: f64) -> f64 {
    let last = values.len() - 1;
    #[expect(clippy::cast_precision_loss, reason = "a grid has far fewer values")]
    if !(0.0..=last as f64).contains(&place) {
        return f64::NAN;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "inside of the axis"
    )]
    let idx = (place.floor() as usize).min(last.saturating_sub(1));
    #[expect(clippy::cast_precision_loss, reason = "a grid has far fewer values")]
    let share = place - idx as f64;
    let next = values[(idx + 1).min(last)];
    values[idx] + share * (next - values[idx])
}

fn ends(values: &[f64]) -> Option<[f64; 2]> {
    values.first().zip(values.last()).map(|(first, last)| [*first, *last])
}

/// A number with four digits at most.
fn short(value: f64) -> String {
    let text = format!("{value:.3e}");
    text.parse::<f64>().map_or(text, |rounded| rounded.to_string())
}
