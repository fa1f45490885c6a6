//! Pictures of answers: fitted curves with their bands, contributors of tolerances, bands over a range, fronts.

use std::f64::consts::TAU;

use bksim_design::{Band, Curve as Compared, Fit, Optimized, PathBand, Tolerance};
use bksim_plot::{Axis, Curve, Figure, Mark, Panel, Point};

/// Standard deviations on either side that bands are drawn with.
const N_SIGMA: f64 = 2.0;

/// Values in the unit in which they are drawn: angles in degrees.
fn shown(unit: &str) -> (f64, &str) {
    if unit == "rad" { (360.0 / TAU, "deg") } else { (1.0, unit) }
}

/// Points on both sides of a curve, as one curve with a gap.
fn both_sides(
    xs: &[f64],
    centre: &dyn Fn(usize) -> f64,
    half: &dyn Fn(usize) -> f64,
) -> Vec<Point> {
    let side = |sign: f64| {
        let at = move |(k, x): (usize, &f64)| [*x, centre(k) + sign * half(k)];
        xs.iter().enumerate().map(at).collect::<Vec<Point>>()
    };
    [side(-1.0), vec![[f64::NAN; 2]], side(1.0)].concat()
}

/// Measured values, the fitted curves and where another measurement lies.
pub(super) fn fitted(name: &str, found: &Fit) -> Figure {
    let panel = |of: &Compared| {
        let mut order: Vec<usize> = (0..of.at.len()).collect();
        order.sort_by(|a, b| of.at[*a].total_cmp(&of.at[*b]));
        let [(x_factor, x_unit), (factor, unit)] = [0, 1].map(|axis: usize| shown(&of.units[axis]));
        let xs: Vec<f64> = order.iter().map(|&k| x_factor * of.at[k]).collect();
        let line = |values: &[f64]| -> Vec<Point> {
            order.iter().zip(&xs).map(|(&k, x)| [*x, factor * values[k]]).collect()
        };
        let band = |error: &[f64]| {
            let half = |k: usize| factor * N_SIGMA * error[order[k]];
            both_sides(&xs, &|k| factor * of.fitted[order[k]], &half)
        };
        let curves = vec![
            Curve { mark: Mark::Dots, ..Curve::new("measured", line(&of.measured)) },
            Curve::new("fitted", line(&of.fitted)),
            Curve::new("fitted ± 2 standard errors", band(&of.standard_error)),
            Curve::new("another measurement, ± 2 standard deviations", band(&of.prediction_error)),
        ];
        let (x, y) = (Axis::new(&of.over, x_unit), Axis::new(&of.column, unit));
        let mut panel = Panel::new(x, y, curves);
        for (curve, dash) in panel.curves.iter_mut().zip([0, 0, 1, 2]) {
            curve.dash = dash;
        }
        panel
    };
    Figure::new(name, found.curves.iter().map(panel).collect())
}

/// Both objectives of a front, its compromise marked; `None` of one objective.
pub(super) fn front(name: &str, found: &Optimized) -> Option<Figure> {
    let front = found.front.as_ref()?;
    let ((a, first), (b, second)) = (shown(&found.unit), shown(&front.unit));
    let points: Vec<Point> =
        front.points.iter().map(|point| [a * point.values[0], b * point.values[1]]).collect();
    let compromise = points.get(front.compromise).copied().into_iter().collect();
    let curves = vec![
        Curve::new("front", points.clone()),
        Curve { mark: Mark::Dots, ..Curve::new("its points", points) },
        Curve { mark: Mark::Dots, ..Curve::new("compromise", compromise) },
    ];
    let (x, y) = (Axis::new(&found.objective, first), Axis::new(&front.against, second));
    Some(Figure::new(name, vec![Panel::new(x, y, curves)]))
}

/// Contributors of one pose, or bands over several.
pub(super) fn toleranced(name: &str, found: &Tolerance) -> Figure {
    let (ranged, poses): (Vec<_>, Vec<_>) =
        found.poses.iter().cloned().partition(|pose| pose.over.is_some());
    let found = Tolerance { poses, ..found.clone() };
    let mut panels: Vec<Panel> = if let [one] = found.poses.as_slice() {
        one.bands.iter().map(contributors).collect()
    } else {
        let n = found.poses.first().map_or(0, |pose| pose.bands.len());
        let bands = (0..n).flat_map(|k| over_range(&found, k));
        bands.chain(paths(&found)).collect()
    };
    panels.extend(ranged.iter().flat_map(|one| &one.bands).map(contributors));
    Figure::new(name, panels)
}

/// Bars of what each part adds to the worst case and to the variance, the largest on top.
fn contributors(band: &Band) -> Panel {
    let mut order: Vec<_> = band.contributors.iter().collect();
    order.sort_by(|a, b| a.linear.total_cmp(&b.linear));
    let bars = |aside: f64, of: &dyn Fn(&bksim_design::Contributor) -> f64| {
        (0u32..).zip(&order).map(|(k, one)| [of(one), f64::from(k) + aside]).collect()
    };
    let bar = |name: &str, points| Curve { mark: Mark::Bars, ..Curve::new(name, points) };
    let curves = vec![
        bar("of the worst case", bars(0.16, &|c| c.percent_of_worst)),
        bar("of the variance", bars(-0.16, &|c| c.percent_of_variance)),
    ];
    let names = order.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let top = (0u32..).zip(&names).last().map_or(0.0, |(k, _)| f64::from(k));
    let y = Axis { names, range: Some([-0.6, top + 0.6]), ..Axis::new(&band.of, "") };
    let most = curves.iter().flat_map(|c| &c.points).map(|p| p[0]).fold(1.0, f64::max);
    let x = Axis { range: Some([0.0, 1.05 * most]), ..Axis::new("share", "%") };
    Panel::new(x, y, curves)
}

/// The measure that the poses of a range differ by, with its values.
fn range_of(found: &Tolerance) -> (Axis, Vec<f64>) {
    let name = found.poses.first().and_then(|pose| pose.at.keys().next()).cloned();
    let name = name.unwrap_or_default();
    let is_angle = name.ends_with("angle");
    let (factor, unit) = shown(if is_angle { "rad" } else { "m" });
    let value = |pose: &bksim_design::PoseTolerance| pose.at.get(&name).map_or(0.0, |x| factor * x);
    (Axis::new(&name, unit), found.poses.iter().map(value).collect())
}

/// A result over the range, and below it how far parts within their limits are off.
fn over_range(found: &Tolerance, k: usize) -> [Panel; 2] {
    let (x, xs) = range_of(found);
    let bands: Vec<&Band> = found.poses.iter().map(|pose| &pose.bands[k]).collect();
    let (factor, unit) = shown(&bands[0].unit);
    let line = |of: &dyn Fn(&Band) -> f64| -> Vec<Point> {
        xs.iter().zip(&bands).map(|(x, band)| [*x, factor * of(band)]).collect()
    };
    let pair = |of: &dyn Fn(&Band) -> [f64; 2]| {
        [line(&|band| of(band)[0]), vec![[f64::NAN; 2]], line(&|band| of(band)[1])].concat()
    };
    let off = |[low, high]: [f64; 2], band: &Band| [low - band.nominal, high - band.nominal];
    let around = |band: &Band| [-1.0, 1.0].map(|sign| sign * 3.0 * band.sigma_linear);
    let curves = vec![
        Curve::new("nominal", line(&|band| band.nominal)),
        Curve::new("least and largest", pair(&|band| band.exact_interval)),
    ];
    let label = bands[0].of.as_str();
    let value = Panel::new(x.clone(), Axis::new(label, unit), curves);
    let curves = vec![
        Curve::new("least and largest", pair(&|band| off(band.exact_interval, band))),
        Curve::new("by slopes alone", pair(&|band| off(band.linear_interval, band))),
        Curve::new("± 3 standard deviations", pair(&around)),
    ];
    let mut change = Panel::new(x, Axis::new(&format!("Δ {label}"), unit), curves);
    for (dash, curve) in change.curves.iter_mut().enumerate() {
        curve.dash = dash;
    }
    [value, change]
}

/// Part of the size of a path that its band is widened to, so that it is seen.
const WIDE: f64 = 0.04;

/// Paths of points with their bands, widened by a round factor.
fn paths(found: &Tolerance) -> Vec<Panel> {
    let n = found.poses.first().map_or(0, |pose| pose.paths.len());
    let path = |k: usize| {
        let all: Vec<&PathBand> = found.poses.iter().map(|pose| &pose.paths[k]).collect();
        let span = |axis: usize| {
            let values = || all.iter().map(|one| one.at[axis]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        let widest = all.iter().map(|one| one.linear_worst).fold(0.0, f64::max);
        let factor = WIDE * span(0).hypot(span(1)) / widest;
        let factor = if factor.is_finite() && factor > 1.0 {
            let power = 10f64.powf(factor.log10().floor());
            power * (factor / power).floor()
        } else {
            1.0
        };
        let side = |sign: f64| -> Vec<Point> {
            let at = |one: &&PathBand| {
                let off = sign * factor * one.linear_worst;
                [0, 1].map(|axis| one.at[axis] + off * one.normal[axis])
            };
            all.iter().map(at).collect()
        };
        let wider = if factor > 1.0 { format!(", {factor} times wider") } else { String::new() };
        let curves = vec![
            Curve::new("nominal", all.iter().map(|one| one.at).collect()),
            Curve::new(
                &format!("worst case across the path{wider}"),
                [side(-1.0), vec![[f64::NAN; 2]], side(1.0)].concat(),
            ),
        ];
        let name = &all[0].of;
        let axis = |word: &str| Axis::new(&format!("{name}.{word}"), "m");
        Panel { equal_scale: true, ..Panel::new(axis("x"), axis("y"), curves) }
    };
    (0..n).map(path).collect()
}
