//! `bksim render`: pictures and films of a motion, without a window.

mod faults;

use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;
use std::time::Instant;

use bksim::modal::Swinging;
use bksim_view::render::{Format, RenderError, Rendering, Request};
use bksim_view::show::{Show, ShowOptions};
use serde_json::{Value, json};

use crate::curve_fault::no_curve;
use crate::modal::mode_of;
use bksim_cli::args::ModelArgs;
use bksim_cli::args::render::{Arrows, Render};
use bksim_cli::exit::{Failure, Status};
use bksim_cli::origin::{is_of_model, label_of, may_be_own, stamp_file, stamped};
use bksim_cli::output;
use bksim_cli::output_file::OutputFile;
use bksim_cli::progress::{Progress, StopWish};
use bksim_cli::source::logged::unplayable;
use bksim_cli::source::motion::{self, Opened, Opening};

pub(crate) fn run(args: &Render, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let begun = Instant::now();
    let mut order = order(args)?;
    order.check().map_err(|e| refused(args, &e))?;
    let plan = |may_replace: bool| {
        let inputs = ("motion", &[args.input.as_path()][..]);
        OutputFile::plan(&args.output, inputs, may_replace, "nothing was drawn")
    };
    // What may be one of the same model is judged when that is known.
    let is_film = matches!(order.format, Format::Film(_));
    let output = plan(args.force || may_be_own(&args.output))?;
    let model = ModelArgs {
        model: args.input.clone(),
        set: args.set.clone(),
        drawing: args.drawing.clone(),
    };
    let stop = StopWish::watch().map_err(|e| Failure::writing(&args.output, &e))?;
    let request = args.mode.request().map_err(|e| no_curve(&args.input, &e))?;
    let (opened, period) = if let Some(request) = request {
        let Swinging { playback, period, .. } = mode_of(&model, nesting, &request)?;
        let diagnostics = json!([]);
        let file = label_of(&args.input);
        (Opened { playback, file, is_complete: true, diagnostics }, Some(period))
    } else {
        let opening = Opening { cannot: "drawn", nesting, as_json, stop: &stop };
        (motion::open(&model, opening)?, None)
    };
    let Opened { playback, file: label, is_complete, diagnostics } = opened;
    let show = Show::new(playback);
    if let Some(period) = period {
        suit_mode(&mut order, &show, period);
    }
    if let Some(status) = stop.status() {
        return Ok(status);
    }
    let may_replace = args.force || is_of_model(&args.output, &label);
    output.check_again(may_replace, "nothing was drawn")?;
    let mut rendering = order.prepare(show).map_err(|e| refused(args, &e))?;
    let mut out = BufWriter::new(output.create()?);
    let progress = Progress::of("drawing", rendering.clip.from, rendering.clip.to);
    let mut go_on = |t: f64| {
        progress.reached(t);
        stop.status().is_none()
    };
    let written = if is_film {
        rendering.write(&mut out, &mut go_on).map_err(|e| refused(args, &e))
    } else {
        let mut picture = Vec::new();
        let written = rendering.write(&mut picture, &mut go_on).map_err(|e| refused(args, &e));
        let marked = stamped(&args.output, picture, &label);
        out.write_all(&marked).map_err(|e| Failure::writing(&args.output, &e))?;
        written
    };
    progress.finish();
    if !written? {
        return Ok(stop.status().unwrap_or(Status::Interrupted));
    }
    let unwritten = |error: &io::Error| Failure::writing(&args.output, error);
    let mut out = out.into_inner().map_err(|error| unwritten(error.error()))?;
    if is_film && output.is_regular() {
        stamp_file(out.path_now(), &args.output, &label).map_err(|error| unwritten(&error))?;
    }
    let n_bytes = out.seek(SeekFrom::End(0)).map_err(|error| unwritten(&error))?;
    out.finish()?;
    let report = Report { args, rendering, n_bytes };
    if as_json {
        let mut body = report.describe(begun);
        body["complete"] = is_complete.into();
        body["diagnostics"] = diagnostics;
        output::json("render", body)?;
    } else {
        output::report(&report.text(begun))?;
    }
    Ok(Status::Done)
}

/// The request of the command line.
/// Seconds of film that a period of a mode takes.
const PERIOD_S: f64 = 2.0;
/// Ghosts in the picture of a mode.
const MODE_GHOSTS: usize = 4;

/// Options that suit a mode where nothing is said: a film of two seconds, a picture of one end with ghosts from the other.
fn suit_mode(order: &mut Request, show: &Show, period: f64) {
    let [first, _] = show.span();
    if order.format.is_film() {
        order.speed = order.speed.or(Some(period / PERIOD_S));
        // The last instant is the first one again.
        order.to = order.to.or(Some(first + period * (1.0 - 1.0 / 50.0)));
    } else if order.at.is_none() {
        order.at = Some(first + 0.5 * period);
        if order.options.ghosts == 0 {
            order.options.ghosts = MODE_GHOSTS;
        }
    }
}

fn order(args: &Render) -> Result<Request, Failure> {
    let has = |kind| args.arrows.contains(&kind);
    let options = ShowOptions {
        labels: args.labels,
        past_s: args.past.unwrap_or(f64::INFINITY),
        reactions: has(Arrows::Reactions),
        velocities: has(Arrows::Velocities),
        forces: has(Arrows::Forces),
        ghosts: usize::from(args.ghosts),
        title: args.title.clone().unwrap_or_default(),
        time: args.time,
        caption: args.caption.clone().unwrap_or_default(),
        section: args.section,
        ..ShowOptions::default()
    };
    Ok(Request {
        format: format(&args.output)?,
        at: args.at,
        from: args.from,
        to: args.to,
        fps: args.fps,
        speed: args.speed,
        size: args.size,
        density: args.density,
        view: args.view,
        background: args.background,
        options,
        trails: args.trail.clone(),
        curves: [args.curve.clone(), args.path.clone()].concat(),
    })
}

fn format(path: &Path) -> Result<Format, Failure> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    Format::of_ending(&ending).ok_or_else(|| {
        let message = format!("`{}` does not say what it should be", path.display());
        let help = "end its name with .png or .svg for a picture, .gif, .mp4 or .apng for a film";
        Failure::usage(message, help)
    })
}

/// Why nothing is drawn, in the words of the command line.
fn refused(args: &Render, error: &RenderError) -> Failure {
    match error {
        RenderError::PictureTime => Failure::usage(
            "--at is for pictures, and this is a film",
            "say where it begins and ends with --from and --to",
        ),
        RenderError::FilmTimes => Failure::usage(
            "--from, --to, --fps and --speed are for films, and this is a picture",
            "choose its instant with --at",
        ),
        RenderError::Outside { option, t, span: [first, last] } => Failure::usage(
            format!("`--{option} {t}` lies outside of the motion"),
            &format!("the motion goes from {first} s to {last} s"),
        ),
        RenderError::TooLong(n) => Failure::usage(
            format!("the film would have {n} frames"),
            "show a part of the motion with --from and --to, or raise --speed",
        ),
        RenderError::TooLarge { n_frames, gigabytes } => Failure::usage(
            format!("the film would have {n_frames} frames and could take {gigabytes} GB"),
            "make it smaller with --size, shorter with --from and --to, or end its name with .mp4",
        ),
        RenderError::Planar { option } => Failure::usage(
            format!("--{option} is for spatial mechanisms, and this one is planar"),
            "leave it out",
        ),
        RenderError::UnknownPoint { name, known } => {
            let names: Vec<String> = known.iter().take(30).map(|n| format!("`{n}`")).collect();
            let help =
                format!("{} joints and points have names: {}", known.len(), names.join(", "));
            let help = if known.is_empty() { "nothing in it has a name" } else { &help };
            Failure::usage(format!("nothing that can leave a trail is called `{name}`"), help)
        }
        RenderError::Curves(error) => no_curve(&args.input, error),
        RenderError::Unreplayed(error) => unplayable(&args.input, "drawn", error),
        RenderError::Canvas(error) => faults::undrawn(args, error),
        RenderError::Film(error) => faults::unwritten(args, error),
        other => Failure::usage(other.to_string(), "`bksim render --help` shows what can be"),
    }
}

/// The files that were made.
struct Report<'a> {
    args: &'a Render,
    rendering: Rendering,
    n_bytes: u64,
}

impl Report<'_> {
    fn describe(&self, begun: Instant) -> Value {
        let Self { args, rendering, n_bytes } = self;
        let Rendering { format, size: [width, height], clip, .. } = rendering;
        let (is_film, n_frames) = (format.is_film(), rendering.n_frames());
        json!({
            "output": args.output.display().to_string(),
            "format": format.name(),
            "width": width,
            "height": height,
            "frames": n_frames,
            "from": clip.from,
            "to": is_film.then(|| clip.time(n_frames - 1)),
            "fps": is_film.then_some(clip.fps),
            "speed": is_film.then_some(clip.speed),
            "bytes": n_bytes,
            "adapter": rendering.adapter(),
            "seconds": begun.elapsed().as_secs_f64(),
        })
    }

    fn text(&self, begun: Instant) -> String {
        let Rendering { format, size: [width, height], clip, .. } = &self.rendering;
        let path = self.args.output.display();
        let kilobytes = self.n_bytes.div_ceil(1000);
        let seconds = begun.elapsed().as_secs_f64();
        if format.is_film() {
            let n = self.rendering.n_frames();
            let long = n as f64 / clip.fps;
            return format!(
                "wrote {path}: {width}x{height}, {n} frames, {long:.1} s, {kilobytes} kB, \
                 in {seconds:.1} s"
            );
        }
        let t = output::number(clip.from);
        format!("wrote {path}: {width}x{height}, t = {t} s, {kilobytes} kB, in {seconds:.1} s")
    }
}
