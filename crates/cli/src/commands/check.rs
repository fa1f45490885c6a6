//! `bksim check`: every fault at once, or what the mechanism is made of and how it can move.

use bksim::analysis::{Positions, diagnose_singular_start};
use bksim::describe::{self, coordinate_policy, joint_names};
use bksim::mbs::particle::particles;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::code;
use bksim::model::{CoordinatePolicy, Model, Space};
use bksim::sim::codes::POSITIONS_ALONE;
use bksim::sim::mobility::{Mobility, freedoms_of_body, mobility};
use bksim::{Mechanism, Rejected};

use crate::args::ModelArgs;
use crate::exit::{Failure, Status};
use crate::output::{self, facts};
use crate::render;
use crate::source::{derive, load, load_geometry};
use crate::waiting::waiting;

pub(crate) fn run(args: &ModelArgs, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let loaded = match load(args, nesting) {
        Ok(loaded) => loaded,
        Err(failure) => return of_positions(args, as_json, nesting, failure),
    };
    let mechanism = derive(&loaded.source, loaded.model)?;
    let (found, warnings) = at_start(&mechanism, loaded.warnings)
        .map_err(|rejected| loaded.source.rejected(rejected.0))?;

    if as_json {
        let mut body = describe::parts(&mechanism, &found);
        body["diagnostics"] = render::json_all(&loaded.source, &warnings);
        output::json("check", body)?;
    } else {
        render::print_all(&loaded.source, &warnings);
        output::text(&report(&mechanism, &found))?;
    }
    Ok(Status::Done)
}

/// The freedoms at the start of a mechanism, and all warnings, with those of the reading of its model.
///
/// # Errors
/// [`Rejected`] has the faults of a model without a start.
pub(crate) fn at_start(
    mechanism: &Mechanism,
    read: Vec<Diagnostic>,
) -> Result<(Mobility, Vec<Diagnostic>), Rejected> {
    let start = waiting("looking for the start", || mechanism.start())?;
    let found = mobility(&mechanism.model, &mechanism.system, &start);
    let mut warnings = mechanism.warnings_of(&start, &found, read);
    warnings.extend(diagnose_singular_start(mechanism, &start));
    Ok((found, warnings))
}

/// True if all errors of a model are that bodies have no mass.
pub(crate) fn lacks_masses_alone(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().any(lacks_mass)
        && diagnostics.iter().filter(|of| of.is_error()).all(lacks_mass)
}

fn lacks_mass(of: &Diagnostic) -> bool {
    of.code == code::NO_BODIES
        || of.code == code::MISSING_KEY && of.message.ends_with("has no `mass`")
}

/// The warning that takes the place of these errors of a model whose positions alone can be asked for; `None` where a
/// motion in time is meant.
pub(crate) fn of_positions_alone(model: &Model, diagnostics: &[Diagnostic]) -> Option<Diagnostic> {
    let first = diagnostics.iter().find(|of| lacks_mass(of))?;
    let n_faults = diagnostics.iter().filter(|of| lacks_mass(of)).count();
    let is_of_laws = model.bodies.len() == 1;
    // Where some bodies have masses, or loads act, a motion in time is meant.
    let are_all = is_of_laws || n_faults == model.bodies.len() - 1;
    if !are_all || !model.loads.is_empty() || model.joints.is_empty() && !is_of_laws {
        return None;
    }
    let (what, commands) = if is_of_laws {
        ("there are no bodies", "`bksim cam`")
    } else {
        ("bodies have no mass", "`bksim kinematics`, `curves`, `polygons`, `doctor` or `cam`")
    };
    let message = format!("{what}: positions alone can be asked for");
    let mut warning = Diagnostic::warning(POSITIONS_ALONE, message).help(format!(
        "ask {commands}; for a motion in time {}",
        first.help.as_deref().unwrap_or("give all bodies their masses")
    ));
    warning.labels.clone_from(&first.labels);
    Some(warning)
}

/// A model that lacks nothing but masses: what can be asked of its positions. The failure as it is for every other
/// one.
fn of_positions(
    args: &ModelArgs,
    as_json: bool,
    nesting: usize,
    failure: Failure,
) -> Result<Status, Failure> {
    let Failure::Model { diagnostics, .. } = &failure else { return Err(failure) };
    if !lacks_masses_alone(diagnostics) {
        return Err(failure);
    }
    let Ok(loaded) = load_geometry(args, nesting) else { return Err(failure) };
    let model = &loaded.model;
    let Some(warning) = of_positions_alone(model, diagnostics) else { return Err(failure) };
    let mut warnings = loaded.warnings;
    warnings.push(warning);

    let is_of_laws = model.bodies.len() == 1;
    let names: Vec<&str> = model.bodies.iter().skip(1).map(|body| body.name.as_str()).collect();
    // Joints that cannot meet are a fault for every question.
    let joints: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
    let body = serde_json::json!({ "model": model.name, "bodies": names, "joints": joints });
    let row = |what: &str, of: &[&str]| vec![what.to_owned(), of.len().to_string(), of.join(" ")];
    let text = format!(
        "{}: no errors\n{}",
        model.name,
        facts(&[row("bodies", &names), row("joints", &joints)])
    );
    if !is_of_laws {
        Positions::of(loaded.model).map_err(|error| loaded.source.rejected(error.diagnostics()))?;
    }
    if as_json {
        let mut body = body;
        body["diagnostics"] = render::json_all(&loaded.source, &warnings);
        output::json("check", body)?;
    } else {
        render::print_all(&loaded.source, &warnings);
        output::text(&text)?;
    }
    Ok(Status::Done)
}

fn report(mechanism: &Mechanism, found: &Mobility) -> String {
    let model = &mechanism.model;
    let bodies = model.bodies.iter().skip(1).map(|b| b.name.as_str());
    let joints = model.joints.iter().map(|j| j.name.as_str());
    let coordinates = describe::motion_coordinates(mechanism);
    let states = model.states.iter().map(|s| s.name.as_str());
    let couplings = model.couplings.iter().map(|c| c.name.as_str());
    let contacts = model.contacts.iter().map(|c| c.name.as_str());
    let loads = model.loads.iter().filter(|load| load.contact().is_none());
    let loads = loads.map(|l| l.name.as_str());
    let drives = model.drives.iter().map(|d| d.name.as_str());
    let row = |what: &str, n: String, names: String| vec![what.to_owned(), n, names];
    let counted =
        |what: &str, names: Vec<&str>| row(what, names.len().to_string(), names.join(" "));

    let mut rows = vec![
        counted("bodies", bodies.collect()),
        counted("joints", joints.collect()),
        counted("couplings", couplings.collect()),
        counted("contacts", contacts.collect()),
        counted("loads", loads.collect()),
        counted("drives", drives.collect()),
        counted("states", states.collect()),
        counted("coordinates", coordinates.collect()),
        row("", String::new(), policy_reason(mechanism)),
        counted("cut joints", joint_names(mechanism, &mechanism.system.tree.cuts)),
        row("constraints", found.n_constraints.to_string(), format!("{} independent", found.rank)),
        count(model, found),
        row("true mobility", found.mobility.to_string(), more_positions(found)),
        row("redundant conditions", found.n_redundant.to_string(), redundant(model, found)),
        counted("redundant joints", joint_names(mechanism, &found.redundant)),
    ];
    rows.retain(|row| {
        row[1] != "0"
            || !["couplings", "contacts", "loads", "drives", "states", "redundant conditions"]
                .contains(&row[0].as_str())
    });
    format!("{}: no errors\n{}", model.name, facts(&rows))
}

/// How many positions are free where more are than velocities.
fn more_positions(found: &Mobility) -> String {
    if found.of_positions == found.mobility {
        return String::new();
    }
    format!("of velocities; {} of positions", found.of_positions)
}

/// The redundant conditions, by joint and direction.
fn redundant(model: &Model, found: &Mobility) -> String {
    let words = found.repeated.iter().map(|repeated| repeated.condition.words(model));
    words.collect::<Vec<_>>().join("; ")
}

/// The row of Grübler's count; in space Kutzbach's, with what bodies have and the joints take, those that take
/// most first.
fn count(model: &Model, found: &Mobility) -> Vec<String> {
    let n = found.gruebler.to_string();
    if model.space == Space::Planar {
        return vec!["Grübler count".to_owned(), n, String::new()];
    }
    let mut terms =
        vec![format!("{}·{} of the bodies", freedoms_of_body(model.space), model.bodies.len() - 1)];
    let is_particle = particles(model);
    let bodies = model.bodies.iter().zip(is_particle).filter(|(_, is_particle)| *is_particle);
    let names: Vec<&str> = bodies.map(|(body, _)| body.name.as_str()).collect();
    if !names.is_empty() {
        terms.push(format!("3·{} turns of the particles {}", names.len(), names.join(" ")));
    }
    for each in (1..=6).rev() {
        let joints = model.joints.iter().filter(|joint| joint.kind.n_taken(model.space) == each);
        let names: Vec<&str> = joints.map(|joint| joint.name.as_str()).collect();
        if !names.is_empty() {
            terms.push(format!("{each}·{} {}", names.len(), names.join(" ")));
        }
    }
    let couplings: Vec<&str> = model.couplings.iter().map(|c| c.name.as_str()).collect();
    if !couplings.is_empty() {
        terms.push(format!("{} {}", couplings.len(), couplings.join(" ")));
    }
    vec!["Kutzbach count".to_owned(), n, terms.join(" − ")]
}

/// The coordinates in words, and who chose them.
fn policy_reason(mechanism: &Mechanism) -> String {
    let word = coordinate_policy(mechanism);
    let who = match mechanism.model.coordinates {
        CoordinatePolicy::Auto => "chosen by bksim",
        _ => "as the model asks",
    };
    let asked = mechanism.model.joints.iter().filter(|j| j.cut == Some(true)).count();
    match asked {
        0 => format!("{word}, {who}"),
        _ => format!("{word}, {who}; cut by the model itself: {asked}"),
    }
}
