//! `bksim equations`: T, V, the Lagrange equations with multipliers, the constraints; how much they
//! compute, and a certificate that they are right.

use std::collections::HashMap;

use bksim::describe;
use bksim::expr::SymbolId;
use bksim::mbs::assemble::in_absolute_angles;
use bksim::mbs::equations::page::{Page, Style, Subject};
use bksim::mbs::equations::{
    Level, ReadingForm, drive_effort, free_bodies, levels, levels_at, proof, steps,
};
use bksim::mbs::quantity::coordinate_quantities;
use bksim::mbs::system::SymbolicSystem;
use bksim::{Mechanism, Rejected};

use crate::args::Switch;
use crate::args::text::{Angles, Equations, Format};
use crate::exit::{Failure, Status};
use crate::output;
use crate::render;
use crate::source::{derive, load};
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
    let Mechanism { model, compiled, .. } = &mechanism;
    let other = in_angles(args.angles, &mechanism)?;
    let system = other.as_ref().unwrap_or(&mechanism.system);
    let (form, proof) = waiting("writing the equations", || {
        let form = match args.groups {
            Switch::On => ReadingForm::grouped(model, system),
            Switch::Off => ReadingForm::plain(model, system),
        };
        let proof = proof(model, system, &form);
        (form, proof)
    });
    if as_json {
        let mut body = describe::equations(&mechanism, system, &form, &proof);
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("equations", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    let coordinates = &coordinate_quantities(model, system);
    let multipliers = &compiled.multipliers;
    let subject = Subject { model, system, coordinates, multipliers, form: &form, proof: &proof };
    if args.effort && drive_effort(model, system, &form).is_empty() {
        let message = "the effort of a drive has no explicit form here";
        let help = "leave out --effort: it is for one drive without other free motions, stops or \
                    friction, and for joints that do not repeat each other; `bksim inverse` has \
                    the numbers";
        return Err(Failure::usage(message, help));
    }
    if args.steps && steps(model, system, &form).is_empty() {
        let message = "this mechanism has no derivation step by step";
        let help = "leave out --steps: its equations are found body by body, from the first to the last and back, \
                    without a kinetic energy that is written out";
        return Err(Failure::usage(message, help));
    }
    let levels = further(args, &mechanism, system, &form)
        .map_err(|error| loaded.source.rejected(error.0))?;
    let page = Page::with_levels(&subject, style(args, format), &levels);
    output::text(&if is_document { page.document() } else { page.formulas() })?;
    Ok(Status::Done)
}

/// The equations in other angles than those of the joints, where these are asked for.
fn in_angles(angles: Angles, mechanism: &Mechanism) -> Result<Option<SymbolicSystem>, Failure> {
    if angles == Angles::Relative {
        return Ok(None);
    }
    let found = waiting("deriving the equations in the angles of the bodies", || {
        in_absolute_angles(&mechanism.model, &mechanism.system)
    });
    found.map(Some).ok_or_else(|| {
        let message = "there are no equations in the angles of the bodies here";
        let help =
            "leave out `--angles absolute`: it is for the plane, and for bodies that do not bend";
        Failure::usage(message, help)
    })
}

/// The equations that are asked for besides those of motion.
fn further(
    args: &Equations,
    mechanism: &Mechanism,
    system: &SymbolicSystem,
    form: &ReadingForm,
) -> Result<Vec<Level>, Rejected> {
    let Mechanism { model, parameters, .. } = mechanism;
    let mut all = Vec::new();
    if args.steps {
        all.extend(steps(model, system, form));
    }
    if args.levels {
        let start = mechanism.start()?;
        let own = model.parameters.iter().map(|parameter| parameter.symbol);
        let mut values: HashMap<SymbolId, f64> = own.zip(parameters.iter().copied()).collect();
        values.insert(model.time, model.solve.t_start);
        let own = mechanism.system.coordinates().iter();
        for ((coordinate, &q), &v) in own.zip(&start.q).zip(&start.v) {
            values.extend([(coordinate.q, q), (coordinate.v, v)]);
        }
        for (i, coordinate) in system.coordinates().iter().enumerate() {
            let Some(angle) = system.kinematics.absolute_angle(i) else { continue };
            let at_start = |e| model.pool.evaluate(e, &|symbol| values.get(&symbol).copied());
            let [q, v] = angle.by_joints.map(|e| at_start(e).unwrap_or(f64::NAN));
            values.extend([(coordinate.q, q), (coordinate.v, v)]);
        }
        all.extend(levels(model, system));
        all.extend(levels_at(model, system, &|symbol| values.get(&symbol).copied()));
    }
    if args.free_bodies {
        all.push(free_bodies(model, system));
    }
    if args.effort {
        all.extend(drive_effort(model, system, form));
    }
    Ok(all)
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
