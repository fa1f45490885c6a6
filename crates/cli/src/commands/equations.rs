//! `bksim equations`: T, V, the Lagrange equations with multipliers, the constraints; how much they
//! compute, and a certificate that they are right.

use bksim::Mechanism;
use bksim::describe;
use bksim::mbs::equations::page::{Page, Style, Subject};
use bksim::mbs::equations::{ReadingForm, proof};

use crate::args::{Equations, Format, Switch};
use crate::exit::{Failure, Status};
use crate::output;
use crate::render;
use crate::source::{derive, load};

/// Characters of a line where there is no terminal to ask.
const WIDTH: usize = 100;

pub(crate) fn run(args: &Equations, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let as_json = as_json || args.format == Format::Json;
    if as_json && args.document {
        let help = "`--format` is one of text, aligned, latex, typst and mathml";
        return Err(Failure::usage("a document has a format to be written in", help));
    }
    let loaded = load(&args.model, nesting)?;
    let mechanism = derive(&loaded.source, loaded.model)?;
    let Mechanism { model, system, compiled, .. } = &mechanism;
    let form = match args.groups {
        Switch::On => ReadingForm::grouped(model, system),
        Switch::Off => ReadingForm::plain(model, system),
    };
    let proof = proof(model, system, &form);
    if as_json {
        let mut body = describe::equations(&mechanism, &form, &proof);
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("equations", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    let (coordinates, multipliers) = (&compiled.coordinates, &compiled.multipliers);
    let subject = Subject { model, system, coordinates, multipliers, form: &form, proof: &proof };
    let page = Page::new(&subject, style(args));
    output::text(&if args.document { page.document() } else { page.formulas() })?;
    Ok(Status::Done)
}

fn style(args: &Equations) -> Style {
    match args.format {
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
