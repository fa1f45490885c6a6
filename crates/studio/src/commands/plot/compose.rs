//! From curves to a figure: names, titles, colours.

use bksim::model::file::ShownUnit;
use bksim::model::message::counted;
use bksim::overview::word;
use bksim_cli::output::number;
use bksim_plot::{Axis, Curve, Figure, Mark, Panel, Point, Scale};
use serde_json::{Value, json};

use super::choose::{PanelPlan, Plan, Quantity};
use super::curves::{Drawn, Run};
use super::units::Units;

/// The logs that were read.
pub(super) struct Drawing<'a> {
    pub(super) runs: &'a [Run],
    pub(super) plan: &'a Plan,
    pub(super) x: Option<&'a Quantity>,
    /// The unit of the abscissa.
    pub(super) x_unit: ShownUnit,
    /// The units that parameters are told in.
    pub(super) units: &'a Units,
    /// For each run, a curve for each quantity of the plan.
    pub(super) drawn: &'a [Vec<Option<Drawn>>],
}

/// A figure, with what its curves are.
pub(super) struct Plotted {
    pub(super) figure: Figure,
    pub(super) n_left_out: usize,
    /// Curves that are zero from end to end and were not named.
    n_zero: usize,
    /// For each panel, its curves.
    curves: Vec<Vec<CurveReport>>,
}

/// A curve, as the report of a plot lists it.
struct CurveReport {
    channel: String,
    run: usize,
    unit: String,
    n_values: u64,
    range: Option<[f64; 2]>,
    is_dense: bool,
    /// True if it is the same in every solution of the equilibrium, all along.
    is_unique: bool,
}

/// Values of a table that are drawn as points; more of them are a line.
const MAX_POINTS: u64 = 400;
/// Curves this much smaller than the largest are zero but for rounding.
const ROUNDING: f64 = 1e-13;

impl Drawing<'_> {
    pub(super) fn plotted(&self, title: Option<&str>, log_y: bool) -> Plotted {
        let mut plotted = Plotted {
            figure: Figure::new(&self.title(title), Vec::new()),
            n_left_out: self.plan.n_left_out,
            n_zero: 0,
            curves: Vec::new(),
        };
        // What rounding leaves of a zero next to the forces it is the difference of.
        let size = |drawn: &Drawn| drawn.range.map_or(0.0, |[low, high]| high.max(-low));
        let largest = self.drawn.iter().flatten().flatten().map(size).fold(0.0, f64::max);
        let is_zero = |drawn: &Drawn| drawn.range.is_some() && size(drawn) <= ROUNDING * largest;
        // Where everything is zero, that is what there is to see.
        let has_more = self.drawn.iter().flatten().flatten().any(|drawn| !is_zero(drawn));
        let mut first = 0;
        for plan in &self.plan.panels {
            let places = first..first + plan.quantities.len();
            first = places.end;
            let mut curves = Vec::new();
            for (quantity, place) in plan.quantities.iter().zip(places) {
                let of_runs = self.drawn.iter().enumerate();
                let found: Vec<_> = of_runs
                    .filter_map(|(run, drawn)| Some((run, quantity, drawn[place].as_ref()?)))
                    .collect();
                if has_more && !quantity.is_named && found.iter().all(|(.., drawn)| is_zero(drawn))
                {
                    plotted.n_zero += found.len();
                } else {
                    curves.push(found);
                }
            }
            curves.retain(|found| !found.is_empty());
            if !curves.is_empty() {
                let (panel, told) = self.panel(plan, &curves, log_y);
                plotted.figure.panels.push(panel);
                plotted.curves.push(told);
            }
        }
        plotted
    }

    fn title(&self, given: Option<&str>) -> String {
        if let Some(title) = given {
            return title.to_owned();
        }
        let mut names: Vec<&str> = Vec::new();
        for run in self.runs {
            if !names.contains(&run.header.model_name.as_str()) {
                names.push(&run.header.model_name);
            }
        }
        names.join(", ")
    }

    /// A panel of curves, those of one quantity together.
    fn panel(
        &self,
        plan: &PanelPlan,
        curves: &[Vec<(usize, &Quantity, &Drawn)>],
        log_y: bool,
    ) -> (Panel, Vec<CurveReport>) {
        let is_one = curves.len() == 1;
        let mut drawn_curves = Vec::new();
        let mut told = Vec::new();
        let has_points = self.runs.iter().any(Run::is_table);
        for (place, found) in curves.iter().enumerate() {
            for (run, quantity, drawn) in found {
                let short = self.short(quantity);
                let name = match (self.runs.len(), is_one) {
                    (1, _) => short,
                    (_, true) => self.run_name(*run),
                    (_, false) => format!("{short}, {}", self.run_name(*run)),
                };
                // Colours tell runs apart, where there are several, and dashes quantities; the points of tables have
                // no dashes, but the colour of the curve that they are compared with.
                let (color, dash) = match self.runs.len() {
                    1 => (place, place / 6),
                    _ if has_points && !is_one => (place, *run),
                    _ => (*run, place),
                };
                let is_points = self.runs[*run].is_table() && drawn.n_values <= MAX_POINTS;
                let mark = if is_points { Mark::Dots } else { Mark::Line };
                // Rounding is no result.
                let floor = self.runs[*run].floor(&quantity.unit);
                let is_rounding = |y: f64| y.abs() <= floor;
                let x_of = |x| self.x_unit.of_si(x);
                let y_of = |y| quantity.shown.of_si(if is_rounding(y) { 0.0 } else { y });
                let points = drawn.points.iter().map(|&[x, y]| [x_of(x), y_of(y)]).collect();
                let curve = Curve { name, points, color, dash, mark };
                drawn_curves.extend(self.by_uniqueness(curve, *run, quantity));
                told.push(CurveReport {
                    channel: quantity.name.clone(),
                    run: *run,
                    unit: quantity.shown.unit.clone(),
                    n_values: drawn.n_values,
                    range: drawn.range.map(|range| range.map(|y| quantity.shown.of_si(y))),
                    is_dense: drawn.is_dense,
                    is_unique: !self.runs[*run].is_ever_shared(quantity),
                });
            }
        }
        let x = match self.x {
            None => Axis::new("Time", &self.x_unit.unit),
            Some(x) => Axis::new(&self.short(x), &self.x_unit.unit),
        };
        let label = match (curves, &plan.label) {
            // A single curve has no legend: the axis tells.
            ([one], None) if drawn_curves.len() == 1 => one.first().map(|&(run, quantity, _)| {
                let is_shared = self.runs[run].is_ever_shared(quantity);
                self.short(quantity) + if is_shared { " (not unique)" } else { "" }
            }),
            ([one], None) => one.first().map(|(_, quantity, _)| self.short(quantity)),
            ([one], Some(words)) => {
                one.first().map(|(_, quantity, _)| format!("{words}: {}", self.short(quantity)))
            }
            (_, words) => words.clone(),
        };
        let words = || word(&plan.unit).unwrap_or("Value").to_owned();
        let mut y = Axis::new(&label.unwrap_or_else(words), &plan.shown.unit);
        y.scale = if log_y { Scale::Logarithmic } else { Scale::Linear };
        let is_path = self.x.is_some_and(|x| x.unit == "m") && plan.unit == "m" && !log_y;
        (Panel { x, y, curves: drawn_curves, equal_scale: is_path }, told)
    }

    /// A curve as it is, or its parts: dashed and named so where it is one of many solutions of the
    /// equilibrium.
    fn by_uniqueness(&self, curve: Curve, run: usize, quantity: &Quantity) -> Vec<Curve> {
        let run = &self.runs[run];
        if !run.is_ever_shared(quantity) {
            return vec![curve];
        }
        // Over another abscissa, points do not tell their time.
        let is_shared = |point: &Point| {
            self.x.is_some() || run.is_shared_at(quantity, self.x_unit.to_si(point[0]))
        };
        let part = |is_wanted: bool| -> Vec<Point> {
            let kept =
                |point: &Point| if is_shared(point) == is_wanted { point[1] } else { f64::NAN };
            curve.points.iter().map(|point| [point[0], kept(point)]).collect()
        };
        let [unique, shared] = [part(false), part(true)];
        let has_values = |points: &[Point]| points.iter().any(|point| !point[1].is_nan());
        let name = format!("{} (not unique)", curve.name);
        let shared = Curve { name, points: shared, dash: curve.dash + 1, ..curve.clone() };
        let unique = Curve { points: unique, ..curve };
        [unique, shared].into_iter().filter(|curve| has_values(&curve.points)).collect()
    }

    /// The name without its topic, unless that makes two names one: `state.theta1` as `theta1`. A measure, `A.angle`,
    /// has none: its owner stays.
    fn short(&self, quantity: &Quantity) -> String {
        let last = |name: &str| {
            let is_measured = self.runs.iter().any(|run| run.is_measured(name));
            let rest = name.split_once('.').filter(|_| !is_measured).map(|(_, rest)| rest);
            rest.unwrap_or(name).to_owned()
        };
        let own = last(&quantity.name);
        let all = self.plan.quantities().chain(self.x);
        let is_double =
            all.into_iter().any(|other| other.name != quantity.name && last(&other.name) == own);
        if is_double { quantity.name.clone() } else { own }
    }

    /// The name of the file without its ending, or with its directory where two have one name; then the parameters
    /// that differ from one run of the same model to the other: `strong, q1 = 70 N*m`.
    fn run_name(&self, run: usize) -> String {
        let stem = |run: &Run| run.path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let own = stem(&self.runs[run]);
        let is_double =
            self.runs.iter().enumerate().any(|(other, of)| other != run && stem(of) == own);
        let path = || self.runs[run].path.display().to_string();
        let name = own.filter(|_| !is_double).unwrap_or_else(path);
        let values = self.differing(run).into_iter().map(|(name, quantity)| {
            // A value that was set has the unit of the one in its place.
            let units = self.runs.iter().filter_map(|run| run.header.parameters.get(name));
            let mut units = std::iter::once(quantity).chain(units).map(|other| other.unit.as_str());
            let unit = units.find(|unit| !unit.is_empty()).unwrap_or_default();
            let shown = self.units.of(name, unit);
            let value = self.shortest(name, quantity.value, |value| shown.of_si(value));
            let text = format!("{name} = {value} {}", shown.unit);
            text.trim_end().to_owned()
        });
        std::iter::once(name).chain(values).collect::<Vec<_>>().join(", ")
    }

    /// A value of a parameter in four digits, or in as many as tell it apart from those of the other runs.
    fn shortest(&self, name: &str, value: f64, shown: impl Fn(f64) -> f64) -> String {
        let short = |value: f64| {
            let value = shown(value);
            format!("{value:.3e}").parse::<f64>().unwrap_or(value)
        };
        let others = self.runs.iter().filter_map(|run| run.header.parameters.get(name));
        let mut others = others.map(|other| other.value).filter(|other| *other != value);
        if others.any(|other| short(other) == short(value)) {
            return number(shown(value));
        }
        number(short(value))
    }

    /// The parameters of a run with other values in other runs of its model; none where more differ than a legend holds.
    fn differing(&self, run: usize) -> Vec<(&str, &bksim::log::Quantity)> {
        const MOST: usize = 3;
        let own = &self.runs[run].header;
        let alike = self.runs.iter().map(|run| &run.header);
        let alike: Vec<_> = alike
            .filter(|of| of.model_name == own.model_name && !of.parameters.is_empty())
            .collect();
        let differs = |(name, quantity): &(&String, &bksim::log::Quantity)| {
            alike
                .iter()
                .any(|of| of.parameters.get(*name).is_some_and(|o| o.value != quantity.value))
        };
        let found: Vec<_> = own.parameters.iter().filter(differs).collect();
        let found = if found.len() > MOST { Vec::new() } else { found };
        found.into_iter().map(|(name, quantity)| (name.as_str(), quantity)).collect()
    }
}

impl Plotted {
    /// The curves of several figures of one pair of axes in one panel, each called by its name.
    pub(super) fn join(&mut self, others: Vec<(String, Self)>) {
        let mut joined: Option<(Panel, Vec<CurveReport>)> = None;
        for (number, (name, other)) in others.into_iter().enumerate() {
            let Self { figure, curves, .. } = other;
            for (mut panel, told) in figure.panels.into_iter().zip(curves) {
                for curve in &mut panel.curves {
                    curve.name.clone_from(&name);
                    (curve.color, curve.dash) = (number, number / 6);
                }
                if let Some((known, all)) = &mut joined {
                    known.curves.extend(panel.curves);
                    all.extend(told);
                } else {
                    let axis = |label: &str, axis: &Axis| Axis::new(label, &axis.unit);
                    (panel.x, panel.y) = (axis("x", &panel.x), axis("y", &panel.y));
                    panel.equal_scale = true;
                    joined = Some((panel, told));
                }
            }
        }
        if let Some((panel, told)) = joined {
            self.figure.panels.push(panel);
            self.curves.push(told);
        }
    }

    pub(super) fn n_values(&self) -> usize {
        self.figure.panels.iter().flat_map(|panel| &panel.curves).map(|c| c.points.len()).sum()
    }

    /// `3 panels, 12 curves`, and what was left out.
    pub(super) fn summary(&self) -> String {
        let n_curves: usize = self.curves.iter().map(Vec::len).sum();
        let panels = counted(self.figure.panels.len(), "panel", "panels");
        let words = format!("{panels}, {}", counted(n_curves, "curve", "curves"));
        self.left_out().map_or_else(|| words.clone(), |more| format!("{words}; {more}"))
    }

    pub(super) fn left_out(&self) -> Option<String> {
        let more = counted(self.n_left_out, "more channel was", "more channels were");
        let more = format!("{more} left out: name those to see");
        let zero = counted(self.n_zero, "curve that stays zero was", "curves that stay zero were");
        let zero = format!("{zero} left out");
        match (self.n_left_out, self.n_zero) {
            (0, 0) => None,
            (_, 0) => Some(more),
            (0, _) => Some(zero),
            _ => Some(format!("{more}; {zero}")),
        }
    }

    pub(super) fn panels_json(&self, runs: &[Run]) -> Vec<Value> {
        let curve = |told: &CurveReport| {
            json!({
                "channel": told.channel,
                "log": runs[told.run].path.display().to_string(),
                "unit": told.unit,
                "values": told.n_values,
                "from": if told.is_dense { "motion" } else { "samples" },
                "smallest": told.range.map(|[low, _]| low),
                "largest": told.range.map(|[_, high]| high),
                "unique": told.is_unique,
            })
        };
        let panels = self.figure.panels.iter().zip(&self.curves);
        let panel = |(panel, told): (&Panel, &Vec<CurveReport>)| {
            json!({
                "label": panel.y.label,
                "unit": panel.y.unit,
                "curves": told.iter().map(curve).collect::<Vec<_>>(),
            })
        };
        panels.map(panel).collect()
    }
}
