//! `bksim import` of a drawing without attributes: what was understood, and the questions that remain.

use std::io::{self, BufRead as _, IsTerminal as _, Write as _};
use std::path::Path;

use bksim::cad::{container, patch::apply, units};
use bksim::import::plain::{
    Material, Options, Question, Understanding, excerpt, is_svg, understand,
};
use serde_json::{Value, json};

use crate::args::import::Import;
use crate::exit::{Failure, Status};
use crate::output;
use crate::output_file::{check_ending, put};
use crate::render;
use crate::source::Text;

/// True if a file is a drawing or a picture, by its bytes, or by its name where those are damaged.
pub(super) fn is_drawing(path: &Path, bytes: &[u8]) -> bool {
    let ending = path.extension().map(|it| it.to_string_lossy().to_ascii_lowercase());
    container::recognise(bytes).is_ok()
        || is_svg(bytes)
        || matches!(ending.as_deref(), Some("dxf" | "dwg"))
}

pub(super) fn run(
    args: &Import,
    as_json: bool,
    name: &str,
    bytes: &[u8],
) -> Result<Status, Failure> {
    args.output.iter().try_for_each(|path| check_ending(path, &["toml", "dxf", "dwg"]))?;
    args.picture.iter().try_for_each(|path| check_ending(path, &["svg"]))?;
    let mut options = options(args)?;
    let rejected = |diagnostics| Failure::Model {
        source: Box::new(Text::new(args.file.clone(), excerpt(bytes))),
        diagnostics,
    };
    let mut understood = understand(name, bytes, &options).map_err(rejected)?;
    let may_ask = !as_json && io::stdin().is_terminal() && io::stderr().is_terminal();
    if may_ask && put_questions(&understood, &mut options) {
        understood = understand(name, bytes, &options).map_err(rejected)?;
    }
    let ending = |path: &Path| path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    match &args.output {
        // A drawing in place of a model file: the same one, with what was understood attached to it.
        Some(path) if matches!(ending(path), Some(it) if it == "dxf" || it == "dwg") => {
            if ending(path) != ending(&args.file) {
                let message =
                    format!("`{}` is another kind of file than the drawing", path.display());
                return Err(Failure::usage(message, "a drawing with attributes keeps its format"));
            }
            let edits = understood.records.clone().map_err(|fault| rejected(vec![fault]))?;
            let attached = apply(bytes.to_vec(), &edits).map_err(rejected)?;
            write(path, &args.file, args.force, &attached.bytes)?;
        }
        Some(path) => write(path, &args.file, args.force, understood.model.as_bytes())?,
        None => (),
    }
    if let Some(path) = &args.picture {
        write(path, &args.file, args.force, understood.picture.as_bytes())?;
    }
    if as_json {
        output::json("import", as_object(args, name, &understood))?;
        return Ok(Status::Done);
    }
    let source = Text::new(args.file.clone(), excerpt(bytes));
    render::print_all(&source, &understood.warnings);
    match &args.output {
        None => output::text(understood.model.trim_end())?,
        Some(path) => output::report(&report(path, &understood))?,
    }
    Ok(Status::Done)
}

/// Writes a text that was made of a file next to it, never over that file.
pub(super) fn write(path: &Path, input: &Path, force: bool, bytes: &[u8]) -> Result<(), Failure> {
    let own = path.canonicalize().ok();
    if own.is_some() && own == input.canonicalize().ok() {
        let what = "is read by this command; nothing was written".to_owned();
        return Err(Failure::file(path, what, Some("name another file with -o".to_owned())));
    }
    if path.exists() && !force {
        let help = Some("add --force to overwrite it".to_owned());
        return Err(Failure::file(path, "exists already; nothing was written".to_owned(), help));
    }
    put(path, bytes)
}

fn options(args: &Import) -> Result<Options, Failure> {
    let usage = |message: String, help: &str| Failure::usage(message, help);
    let unit = match &args.units {
        None => None,
        Some(name) => Some(units::by_name(name).ok_or_else(|| {
            usage(format!("`{name}` is no unit of length"), "write mm, cm, m or inch")
        })?),
    };
    let mut answers = Vec::new();
    for answer in &args.answers {
        let Some((key, value)) = answer.split_once('=') else {
            let message = format!("`{answer}` is no answer");
            return Err(usage(
                message,
                "write the key of the question, `=` and the answer: --answer drive=A",
            ));
        };
        answers.push((key.trim().to_owned(), value.trim().to_owned()));
    }
    let material = args
        .density
        .zip(args.thickness)
        .map(|(density, thickness)| Material { density, thickness });
    if material.is_some_and(|it| !(it.density > 0.0 && it.thickness > 0.0)) {
        let message = "density and thickness are above zero".to_owned();
        return Err(usage(message, "write them in kg/m³ and m: --density 7850 --thickness 0.005"));
    }
    Ok(Options { unit, answers, material })
}

/// Puts the open questions to the user at the terminal; whether any was answered.
fn put_questions(understood: &Understanding, options: &mut Options) -> bool {
    let mut has_answers = false;
    let mut lines = io::stdin().lock().lines();
    let open = understood.questions.iter().filter(|question| question.answer.is_none());
    for question in open {
        let mut stderr = io::stderr().lock();
        let asked = write!(stderr, "{}", in_words(question)).and_then(|()| stderr.flush());
        drop(stderr);
        // Nobody reads what cannot be written: the rest stays open.
        if asked.is_err() {
            break;
        }
        // The end of the input leaves the rest open.
        let Some(Ok(line)) = lines.next() else { break };
        let line = line.trim();
        let by_number = line.parse::<usize>().ok().and_then(|number| {
            question.readings.get(number.checked_sub(1)?).map(|reading| reading.answer.clone())
        });
        let answer = if question.takes_number { None } else { by_number };
        if !line.is_empty() {
            options.answers.push((question.key.clone(), answer.unwrap_or_else(|| line.to_owned())));
            has_answers = true;
        }
    }
    has_answers
}

fn in_words(question: &Question) -> String {
    let mut lines = vec![question.text.clone()];
    if let (Some([x, y]), handle) = (question.at, question.handle) {
        let entity = handle.map_or(String::new(), |handle| format!(", entity {handle:X}"));
        lines[0] = format!("{} — at ({x:.3}, {y:.3}){entity}", lines[0]);
    }
    for (idx, reading) in question.readings.iter().enumerate() {
        let freedoms = reading.freedoms.map_or(String::new(), |n| format!("; freedoms {n}"));
        lines.push(format!("  {}  {}: {}{freedoms}", idx + 1, reading.answer, reading.meaning));
    }
    let asks = if question.takes_number { "a number" } else { "a number or word of these" };
    lines.push(format!("{asks}, empty for the first: "));
    lines.join("\n")
}

fn report(path: &Path, understood: &Understanding) -> String {
    let n_open = understood.questions.iter().filter(|it| it.answer.is_none()).count();
    let n_joints = understood.joints.iter().filter(|joint| !joint.is_asked).count();
    let mut lines = vec![format!(
        "wrote {}: drawing, bodies {}, joints {n_joints}, freedoms {}",
        path.display(),
        understood.bodies.len(),
        understood.mobility
    )];
    for joint in understood.joints.iter().filter(|joint| !joint.is_asked) {
        let [x, y] = joint.at;
        lines.push(format!(
            "{} `{}` of {} at ({x:.3}, {y:.3})",
            joint.kind,
            joint.name,
            joint.bodies.join(", ")
        ));
    }
    for question in understood.questions.iter().filter(|question| question.answer.is_none()) {
        let readings: Vec<&str> = question.readings.iter().map(|it| it.answer.as_str()).collect();
        lines.push(format!("asked {}: {} ({})", question.key, question.text, readings.join(", ")));
    }
    for (what, places) in &understood.left_out {
        lines.push(format!("left out {what} ({})", places.len()));
    }
    if n_open > 0 {
        lines.push(
            "answer by --answer KEY=ANSWER; without one, the first reading is taken".to_owned(),
        );
    }
    lines.join("\n")
}

fn hex(handle: u64) -> String {
    format!("{handle:X}")
}

fn as_object(args: &Import, name: &str, understood: &Understanding) -> Value {
    let joints = understood.joints.iter().map(|joint| {
        let mut object = json!({
            "name": joint.name,
            "kind": joint.kind,
            "at": joint.at,
            "bodies": joint.bodies,
            "asked": joint.is_asked,
            "handles": joint.handles.iter().map(|handle| hex(*handle)).collect::<Vec<_>>(),
        });
        let more = [
            ("axis", joint.axis.map(|axis| json!(axis))),
            ("ratio", joint.ratio.map(|ratio| json!(ratio))),
            ("radius", joint.radius.map(|radius| json!(radius))),
        ];
        for (key, value) in more {
            if let Some(value) = value {
                object[key] = value;
            }
        }
        object
    });
    let bodies = understood.bodies.iter().map(|body| {
        json!({
            "name": body.name,
            "label": body.label,
            "drawn_as": body.drawn_as,
            "handles": body.handles.iter().map(|handle| hex(*handle)).collect::<Vec<_>>(),
        })
    });
    let elements = understood.elements.iter().map(|element| {
        json!({
            "name": element.name,
            "kind": element.kind,
            "ends": element.ends,
            "bodies": element.bodies,
            "mass": element.mass,
        })
    });
    let questions = understood.questions.iter().map(|question| {
        let readings = question.readings.iter().map(|reading| {
            json!({ "answer": reading.answer, "meaning": reading.meaning, "freedoms": reading.freedoms })
        });
        let mut object = json!({
            "key": question.key,
            "text": question.text,
            "handle": question.handle.map(hex),
            "readings": readings.collect::<Vec<_>>(),
            "answer": question.answer,
        });
        if let Some(at) = question.at {
            object["at"] = json!(at);
        }
        object
    });
    let open = understood.questions.iter().filter(|question| question.answer.is_none());
    let left_out = understood.left_out.iter().flat_map(|(what, places)| {
        places.iter().map(move |place| {
            json!({
                "what": what,
                "file": name,
                "handle": place.handle.map(|handle| hex(handle.0)),
                "line": place.lines.map(|[first, _]| first),
            })
        })
    });
    let source = Text::new(args.file.clone(), String::new());
    json!({
        "output": args.output.as_ref().map(|path| path.display().to_string()),
        "picture": args.picture.as_ref().map(|path| path.display().to_string()),
        "format": "drawing",
        "files": [name],
        "n_bodies": understood.bodies.len(),
        "n_joints": understood.joints.iter().filter(|joint| !joint.is_asked).count(),
        "mobility": understood.mobility,
        "unit": understood.unit,
        "mm_per_unit": understood.mm_per_unit,
        "bodies": bodies.collect::<Vec<_>>(),
        "joints": joints.collect::<Vec<_>>(),
        "elements": elements.collect::<Vec<_>>(),
        "asked": open.map(|question| question.key.clone()).collect::<Vec<_>>(),
        "questions": questions.collect::<Vec<_>>(),
        "left_out": left_out.collect::<Vec<_>>(),
        "model": understood.model,
        "diagnostics": render::json_all(&source, &understood.warnings),
    })
}
