//! Pictures and films of runs.

use std::path::{Path, PathBuf};

use bksim_scene::StandardView;
use bksim_view::film::FilmError;
use bksim_view::render::{Background, Format, RenderError, Request};
use bksim_view::show::{Show, ShowOptions};
use pyo3::prelude::*;

use crate::fault::{Fault, guard};
use crate::file::{replace, unwritten};
use crate::interrupt::Interruption;
use crate::show::playback;
use crate::solution::{Rows, Run};

/// The request of a picture or a film.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RenderRequest {
    at: Option<f64>,
    span: Option<(f64, f64)>,
    fps: Option<f64>,
    speed: Option<f64>,
    size: Option<[u32; 2]>,
    density: Option<f32>,
    view: Option<View>,
    section: Option<String>,
    background: String,
    labels: bool,
    title: Option<String>,
    time: bool,
    caption: Option<String>,
    trails: Vec<String>,
    arrows: Vec<String>,
    ghosts: usize,
    past: Option<f64>,
    /// Told the instant that is drawn, s, now and then.
    notify: Option<Py<PyAny>>,
}

/// A direction of view.
#[derive(FromPyObject)]
enum View {
    /// A standard view by its word.
    Named(String),
    /// Azimuth and elevation, degrees.
    Angles([f64; 2]),
}

impl View {
    fn angles_deg(&self) -> Result<[f64; 2], Fault> {
        let word = match self {
            Self::Angles(angles) => return Ok(*angles),
            Self::Named(word) => word,
        };
        StandardView::named(word).map(StandardView::angles_deg).ok_or_else(|| {
            let words = StandardView::ALL.map(StandardView::word).join(", ");
            Fault::Value(format!("view: {word:?} is none of {words}"))
        })
    }
}

/// Kinds of arrows.
const ARROWS: [&str; 3] = ["reactions", "velocities", "forces"];

impl RenderRequest {
    fn order(&self, format: Format) -> Result<Request, Fault> {
        if let Some(kind) = self.arrows.iter().find(|kind| !ARROWS.contains(&kind.as_str())) {
            let words = format!("arrows: {kind:?} is none of {}", ARROWS.join(", "));
            return Err(Fault::Value(words));
        }
        let has = |kind: &str| self.arrows.iter().any(|known| known == kind);
        let background: Result<Background, &str> = self.background.parse();
        let background = background.map_err(|why| Fault::Value(format!("background: {why}")))?;
        let section = self.section.as_deref().map(bksim::section::parse).transpose();
        let section = section.map_err(|why| Fault::Value(format!("section: {why}")))?;
        let options = ShowOptions {
            section,
            labels: self.labels,
            title: self.title.clone().unwrap_or_default(),
            time: self.time,
            caption: self.caption.clone().unwrap_or_default(),
            past_s: self.past.unwrap_or(f64::INFINITY),
            reactions: has(ARROWS[0]),
            velocities: has(ARROWS[1]),
            forces: has(ARROWS[2]),
            ghosts: self.ghosts,
            ..ShowOptions::default()
        };
        Ok(Request {
            at: self.at,
            from: self.span.map(|(from, _)| from),
            to: self.span.map(|(_, to)| to),
            fps: self.fps,
            speed: self.speed,
            size: self.size,
            density: self.density,
            view: self.view.as_ref().map(View::angles_deg).transpose()?,
            background,
            options,
            trails: self.trails.clone(),
            ..Request::new(format)
        })
    }
}

/// Writes a picture or a film, replacing a file of that name only once it is whole.
#[pyfunction]
pub(crate) fn render(
    py: Python<'_>,
    run: Py<Run>,
    path: PathBuf,
    wanted: RenderRequest,
) -> PyResult<()> {
    let run = run.get();
    let rows = run.rows(py);
    guard(py, || rendered(run, &rows, &path, &wanted))
}

fn rendered(run: &Run, rows: &Rows, path: &Path, wanted: &RenderRequest) -> Result<(), Fault> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let known = Format::ALL.iter().map(|(name, _)| format!(".{name}")).collect::<Vec<_>>();
    let unknown = || Fault::Value(format!("{}: no {}", path.display(), known.join(", ")));
    let order = wanted.order(Format::of_ending(&ending).ok_or_else(unknown)?)?;
    let mut rendering = order.prepare(shown(run, rows)?).map_err(refused)?;

    let interruption = Interruption::new(wanted.notify.as_ref());
    let mut go_on = |t: f64| !interruption.is_wished(t);
    replace(path, |out| {
        let written = rendering.write(out, &mut go_on);
        match (written, interruption.raised()) {
            (_, Some(error)) => Err(Fault::Python(error)),
            (Err(RenderError::Film(FilmError::Io(error))), None) => Err(unwritten(path, &error)),
            (Err(error), None) => Err(refused(error)),
            (Ok(_), None) => Ok(()),
        }
    })
}

/// The mechanism at an instant as SVG.
#[pyfunction]
pub(crate) fn picture(py: Python<'_>, run: Py<Run>, t: f64, is_dark: bool) -> PyResult<String> {
    let run = run.get();
    let rows = run.rows(py);
    guard(py, || {
        let background = if is_dark { Background::Dark } else { Background::Light };
        let order = Request { at: Some(t), background, ..Request::new(Format::Svg) };
        let mut rendering = order.prepare(shown(run, &rows)?).map_err(refused)?;
        let mut svg = Vec::new();
        rendering.write(&mut svg, &mut |_| true).map_err(refused)?;
        String::from_utf8(svg).map_err(|error| Fault::Log(error.to_string()))
    })
}

fn shown(run: &Run, rows: &Rows) -> Result<Show, Fault> {
    playback(run, rows).map(Show::new)
}

fn refused(error: RenderError) -> Fault {
    match error {
        RenderError::Unreplayed(error) => Fault::Log(error.to_string()),
        RenderError::Canvas(error) => {
            let help = error.help().map(|help| format!(": {help}")).unwrap_or_default();
            Fault::Drawing(format!("{error}{help}"))
        }
        RenderError::Film(error) => Fault::Drawing(error.to_string()),
        wrong => Fault::Value(wrong.to_string()),
    }
}
