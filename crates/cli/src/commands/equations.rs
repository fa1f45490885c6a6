//! `bksim equations`: T, V, the Lagrange equations with multipliers, the constraints; how much they
//! compute, and a certificate that they are right.

use bksim::mbs::equations::page::Style;
use bksim::reading::{Contents, Reading, Unreadable};

use crate::args::Switch;
use crate::args::text::{Angles, Equations, Format};
use crate::exit::{Failure, Status};
use crate::output;
use crate::render;
use crate::source::{Text, derive, load};
use crate::waiting::waiting;

/// Characters of a line where there is no terminal to ask.
const WIDTH: usize = 100;

pub(crate) fn run(args: &Equations, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (format, is_document) = format(args);
    let as_json = as_json || format == Format::Json;
    if as_json && args.document {
        let help = "`--format` is one of text, aligned, latex, typst and mathml";
        return Err(Failure::usage("a document has a format to be written in", help));
    }
    let loaded = load(&args.model, nesting)?;
    let mechanism = derive(&loaded.source, loaded.model)?;
    let contents = Contents {
        in_absolute_angles: args.angles == Angles::Absolute,
        has_named_constants: args.groups == Switch::On,
        has_steps: args.steps && !as_json,
        has_levels: args.levels && !as_json,
        has_free_bodies: args.free_bodies && !as_json,
        has_effort: args.effort && !as_json,
    };
    let reading = waiting("writing the equations", || Reading::of(&mechanism, contents));
    let reading = reading.map_err(|why| without(why, &loaded.source))?;
    if as_json {
        let mut body = reading.json();
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("equations", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    output::text(&reading.written(style(args, format), is_document))?;
    Ok(Status::Done)
}

/// The option to leave out where a part of the equations does not exist.
fn without(why: Unreadable, source: &Text) -> Failure {
    let help = match &why {
        Unreadable::NoAbsoluteAngles => {
            "leave out `--angles absolute`: it is for the plane, and for bodies that do not bend"
        }
        Unreadable::NoSteps => {
            "leave out --steps: its equations are found body by body, from the first to the last and back, \
             without a kinetic energy that is written out"
        }
        Unreadable::NoEffort => {
            "leave out --effort: it is for one drive without other free motions, stops or friction, and for \
             joints that do not repeat each other; `bksim inverse` has the numbers"
        }
        Unreadable::Rejected(_) => "",
    };
    match why {
        Unreadable::Rejected(error) => source.rejected(error.0).into(),
        other => Failure::usage(other.to_string(), help),
    }
}

/// The format, and whether it is that of a document: as asked for, else by the ending of the file.
fn format(args: &Equations) -> (Format, bool) {
    let ending = args.file.output.as_deref().and_then(|path| path.extension());
    let of_file = match ending.and_then(|ending| ending.to_str()) {
        Some("tex") => (Format::Latex, true),
        Some("typ") => (Format::Typst, true),
        Some("html") => (Format::Mathml, true),
        Some("json") => (Format::Json, false),
        _ => (Format::Text, args.document),
    };
    args.format.map_or(of_file, |format| (format, args.document))
}

fn style(args: &Equations, format: Format) -> Style {
    match format {
        Format::Text | Format::Json => Style::Text,
        Format::Aligned => {
            let width = args.width.map_or_else(terminal_width, usize::from);
            Style::Aligned { width, unicode: args.unicode }
        }
        Format::Latex => Style::Latex,
        Format::Typst => Style::Typst,
        Format::Mathml => Style::MathMl,
    }
}

/// Columns of the terminal, if stdout is one or `COLUMNS` says so.
fn terminal_width() -> usize {
    let stated = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let found = || terminal_size::terminal_size().map(|(width, _)| usize::from(width.0));
    stated.or_else(found).filter(|&width| width >= 20).unwrap_or(WIDTH)
}
