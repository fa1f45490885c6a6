//! Curves and pages of runs.

use bksim::log::LogReader;
use bksim::model::file::ShownUnits;
use bksim::overview::{Group, word};
use bksim::playback::Playback;
use bksim_page::Options;
use bksim_plot::{Axis, Curve, Figure, Format, Panel, PlotError};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::fault::{Fault, guard};
use crate::logged::bytes;
use crate::solution::{Rows, Run};

/// Curves of a panel that nobody asked for.
const CURVES: usize = 6;

/// A run as if played from its log.
pub(crate) fn playback(run: &Run, rows: &Rows) -> Result<Playback, Fault> {
    let bad = |e: &dyn std::fmt::Display| Fault::Log(e.to_string());
    let bytes = bytes(run, rows)?;
    let log = LogReader::open(bytes.as_slice()).map_err(|e| bad(&e))?;
    Playback::open(log).map_err(|e| bad(&e))
}

/// The page of a run as HTML.
#[pyfunction]
pub(crate) fn page(py: Python<'_>, run: Py<Run>, title: Option<String>) -> PyResult<String> {
    let run = run.get();
    let rows = run.rows(py);
    guard(py, || {
        let mut playback = playback(run, &rows)?;
        let units = ShownUnits::of_model(&playback.log().header.model_text);
        let options = Options { title, units, ..Options::default() };
        let page = bksim_page::page(&mut playback, &options);
        page.map(|page| page.html).map_err(|e| Fault::Log(e.to_string()))
    })
}

/// The live page of a model as HTML; `module` is the WebAssembly of live pages.
#[pyfunction]
pub(crate) fn live_page(text: &str, name: &str, title: &str, module: &[u8]) -> PyResult<String> {
    let options = bksim_page::LiveOptions { title: Some(title.to_owned()), ..Default::default() };
    bksim_page::live(text, name, module, &options)
        .map_err(|e| PyRuntimeError::new_err(e.to_string()))
}

/// Tables of a report with their names; the first row of each is its heading.
type Tables = Vec<(&'static str, Vec<Vec<String>>)>;

/// The numbers of a run, as an object of JSON and as tables in units.
#[pyfunction]
pub(crate) fn report(
    py: Python<'_>,
    run: Py<Run>,
    units: Option<String>,
) -> PyResult<(String, Tables)> {
    let run = run.get();
    let rows = run.rows(py);
    guard(py, || {
        let mut playback = playback(run, &rows)?;
        let units = match units {
            Some(units) => ShownUnits::parse(&units).map_err(Fault::Value)?,
            None => ShownUnits::of_model(&playback.log().header.model_text),
        };
        let found = bksim::report::report(&mut playback).map_err(|e| Fault::Log(e.to_string()))?;
        Ok((bksim::report::json_of(&found).to_string(), bksim::report::tables(&found, &units)))
    })
}

/// Curves to be shown together: what they are, their unit, and of each its name and channels.
type Shown = (String, String, Vec<(String, Vec<String>)>);

/// The choice of an overview from channels with these names and units.
#[pyfunction]
pub(crate) fn overview(channels: Vec<(String, String)>) -> Vec<Shown> {
    let shown = |group: Group| {
        let what = group.label.or_else(|| word(&group.unit)).unwrap_or("Value");
        let quantities = group.quantities.into_iter().map(|q| (q.name, q.channels)).collect();
        (what.to_owned(), group.unit, quantities)
    };
    bksim::overview::overview(&channels, CURVES).0.into_iter().map(shown).collect()
}

/// The quantity measured in a unit, in a word.
#[pyfunction]
pub(crate) fn unit_word(unit: &str) -> &'static str {
    word(unit).unwrap_or("Value")
}

/// A curve: its name, values along the abscissa, its own values.
type GivenCurve<'py> = (String, PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>);

/// Curves as a picture: panels are what is shown, its unit, and curves.
#[pyfunction]
pub(crate) fn figure<'py>(
    py: Python<'py>,
    title: String,
    panels: Vec<(String, String, Vec<GivenCurve<'py>>)>,
    x: (String, String),
    format: String,
    is_dark: bool,
) -> PyResult<std::borrow::Cow<'static, [u8]>> {
    let panel = |(what, unit, curves): (String, String, Vec<GivenCurve<'py>>)| {
        let curve = |(name, x, y): GivenCurve<'py>| {
            let points = x.as_array().iter().zip(y.as_array()).map(|(&x, &y)| [x, y]).collect();
            Curve::new(&name, points)
        };
        let curves = curves.into_iter().map(curve).collect();
        Panel::new(Axis::new(&x.0, &x.1), Axis::new(&what, &unit), curves)
    };
    let figure = Figure::new(&title, panels.into_iter().map(panel).collect());
    guard(py, move || {
        let Some(format) = Format::named(&format) else {
            return Err(Fault::Value(format!("{format:?} is none of svg, png and pdf")));
        };
        let theme = if is_dark { bksim_plot::Theme::DARK } else { bksim_plot::Theme::LIGHT };
        let drawn = figure.render(format, None, &theme);
        drawn.map(Into::into).map_err(|e: PlotError| Fault::Value(e.to_string()))
    })
}
