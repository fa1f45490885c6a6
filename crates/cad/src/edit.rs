//! Commands on bodies, joints, loads and drives as plans of edits, whichever way a thing is attached to
//! the drawing.

use bksim_model::diagnostic::Diagnostic;

use crate::attachment::{Attachment, Content, Way};
use crate::codes;
use crate::drawing::{Drawing, Handle};
use crate::geometry::Point;
use crate::kind::{BODY_LAYER, KINDS, Kind, Placement, Section, by_name};
use crate::patch::{Edit, Entry};

/// The things that a command changes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Subject {
    /// Bodies and their parts: the ground, points, centres of mass.
    Body,
    /// Joints.
    Joint,
    /// Loads.
    Load,
    /// Drives.
    Drive,
}

impl Subject {
    fn word(self) -> &'static str {
        match self {
            Self::Body => "body",
            Self::Joint => "joint",
            Self::Load => "load",
            Self::Drive => "drive",
        }
    }

    fn has(self, kind: &Kind) -> bool {
        match self {
            Self::Body => matches!(
                kind.section,
                Section::Bodies
                    | Section::Ground
                    | Section::Points
                    | Section::Centre
                    | Section::Frames
            ),
            Self::Joint => kind.section == Section::Joints,
            Self::Load => kind.section == Section::Loads,
            Self::Drive => kind.section == Section::Drives,
        }
    }

    /// The kind that is meant when none is given.
    fn usual(self) -> Option<&'static str> {
        match self {
            Self::Body => Some("body"),
            Self::Joint => Some("revolute"),
            Self::Drive => Some("drive"),
            Self::Load => None,
        }
    }
}

/// A thing to attach, to change or to remove.
#[derive(Clone, PartialEq, Debug)]
pub struct Statement {
    /// Group of things.
    pub subject: Subject,
    /// The name of the body, joint, load or drive.
    pub name: String,
    /// The kind, as in [`Kind::name`]; the usual one, or any when something is changed.
    pub kind: Option<String>,
    /// The entities it is attached to, or those meant among several.
    pub entities: Vec<Handle>,
    /// Point of the statement, drawing units, world axes.
    pub at: Option<Point>,
    /// Second point of the statement.
    pub to: Option<Point>,
    /// Direction of the statement.
    pub axis: Option<Point>,
    /// Keys and values, as in a model file; an empty value removes the key.
    pub values: Vec<(String, String)>,
}

/// The edits that do what was asked for.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Plan {
    /// In the order in which they have to be applied.
    pub edits: Vec<Edit>,
    /// Warnings for the author.
    pub warnings: Vec<Diagnostic>,
}

/// Attaches something new to entities as extended data: all of it to the first one, and to further
/// ones, which only bodies and the ground have, its name.
///
/// # Errors
/// `D060` without an entity, `D064` for keys the kind does not have, `D065` for a name in use.
pub fn add(attachments: &[Attachment], statement: &Statement) -> Result<Plan, Diagnostic> {
    let kind = stated_kind(statement)?.ok_or_else(|| which_kind(statement.subject))?;
    let Some((&first, others)) = statement.entities.split_first() else {
        return Err(Diagnostic::error(
            codes::NOT_THERE,
            format!("`{}` is to be attached to no entity", statement.name),
        )
        .help(
            "name one with --entity and its handle, as the command LIST of CAD programs shows it",
        ));
    };
    let is_spread = matches!(kind.section, Section::Bodies | Section::Ground);
    if !others.is_empty() && !is_spread {
        let message =
            format!("a {} is attached to one entity, not to {}", kind.name, others.len() + 1);
        return Err(Diagnostic::error(codes::NOT_THERE, message).help("leave one --entity"));
    }
    if !is_spread {
        check_name_is_free(attachments, statement.subject, kind, &statement.name)?;
    }
    check_geometry(kind, statement)?;

    // A name comes first in the keys of every kind; of a centre of mass it is the body's.
    let name = text_entry(kind.keys[0], &statement.name);
    let mut entries = vec![name.clone()];
    for (key, value) in &statement.values {
        let key = checked_key(kind, key)?;
        if !value.is_empty() {
            entries.push(text_entry(key, value));
        }
    }
    entries.extend(geometry(statement));
    let record = |entity: Handle, entries: Vec<Entry>| Edit::AddRecord {
        entity,
        kind: kind.name.to_owned(),
        entries,
    };
    let mut edits = vec![record(first, entries)];
    edits.extend(others.iter().map(|&entity| record(entity, vec![name.clone()])));
    Ok(Plan { edits, warnings: Vec::new() })
}

/// Changes keys where they stand: a record of extended data, or an attribute of an insert. A key that
/// is stated nowhere yet goes to the first entity the thing is attached to.
///
/// # Errors
/// `D060` when nothing of this name is attached, `D062` when it is there by its layer alone, `D064`
/// for keys the kind does not have, `D065` for a new name in use.
pub fn set(
    drawing: &Drawing,
    attachments: &[Attachment],
    statement: &Statement,
) -> Result<Plan, Diagnostic> {
    let found = found(drawing, attachments, statement)?;
    let mut own = beyond_layers(&found, statement)?;
    // Keys of a body are meant, not those of its points and its centre of mass.
    if own.iter().any(|it| it.kind.section == Section::Bodies) {
        own.retain(|it| it.kind.section == Section::Bodies);
    }
    let mut changes: Vec<Vec<(String, Option<Entry>)>> = vec![Vec::new(); own.len()];
    for (key, value) in &statement.values {
        let key = checked_key(own[0].kind, key)?;
        let entry = (!value.is_empty()).then(|| text_entry(key, value));
        if key == own[0].kind.keys[0] {
            check_name_is_free(attachments, statement.subject, own[0].kind, value)?;
        }
        // A name stands on every entity of a body.
        let mut holders: Vec<usize> = (0..own.len()).filter(|&it| states(own[it], key)).collect();
        if holders.is_empty() {
            holders.push(0);
        }
        for holder in holders {
            changes[holder].push((key.to_owned(), entry.clone()));
        }
    }
    check_geometry(own[0].kind, statement)?;
    for entry in geometry(statement) {
        changes[0].push((entry.key().to_owned(), Some(entry)));
    }
    let mut plan = Plan::default();
    for (attachment, entries) in own.into_iter().zip(changes) {
        if !entries.is_empty() {
            plan.edits.extend(set_one(attachment, entries)?);
        }
    }
    Ok(plan)
}

/// Removes what has this name, wherever it is attached: records, and inserts of our blocks. From an
/// entity that is named but has no sound record, whatever stands there under our name.
///
/// # Errors
/// `D060` when nothing of this name is attached, `D062` when it is there by its layer alone.
pub fn remove(
    drawing: &Drawing,
    attachments: &[Attachment],
    statement: &Statement,
) -> Result<Plan, Diagnostic> {
    let has_record = |entity: &Handle| {
        let mut all = attachments.iter();
        all.any(|it| it.location.handle == Some(*entity) && it.way != Way::Layer)
    };
    if !statement.entities.is_empty() && !statement.entities.iter().any(has_record) {
        let edits = statement.entities.iter().map(|&entity| Edit::RemoveAll { entity }).collect();
        return Ok(Plan { edits, warnings: Vec::new() });
    }
    let found = found(drawing, attachments, statement)?;
    let own = beyond_layers(&found, statement)?;
    let mut plan = Plan::default();
    if own.len() < found.len() {
        let mut warning = by_layer(statement, layer_of(&found));
        warning.severity = bksim_model::diagnostic::Severity::Warning;
        plan.warnings.push(warning);
    }
    for attachment in own.into_iter().rev() {
        let entity = handle(attachment)?;
        plan.edits.push(match attachment.way {
            Way::Xdata(record_idx) => Edit::RemoveRecord { entity, record_idx },
            _ => Edit::RemoveInsert { insert: entity },
        });
    }
    // Of the records of one entity the last goes first, so that the numbers of the others hold.
    plan.edits.sort_by_key(|edit| match edit {
        Edit::RemoveRecord { record_idx, .. } => std::cmp::Reverse(*record_idx),
        _ => std::cmp::Reverse(0),
    });
    Ok(plan)
}

fn set_one(
    attachment: &Attachment,
    entries: Vec<(String, Option<Entry>)>,
) -> Result<Vec<Edit>, Diagnostic> {
    let entity = handle(attachment)?;
    if let Way::Xdata(record_idx) = attachment.way {
        return Ok(vec![Edit::SetEntries { entity, record_idx, entries }]);
    }
    let attribute = |(key, entry): (String, Option<Entry>)| match entry {
        Some(Entry::Point { .. } | Entry::Direction { .. }) => {
            let message =
                format!("`{key}` of an insert of `{}` is where it stands", attachment.kind.block);
            Err(Diagnostic::error(codes::NO_SUCH_KEY, message)
                .help("move, turn or scale the insert in the CAD program"))
        }
        Some(Entry::Text { value, .. }) => {
            Ok(Edit::SetAttribute { insert: entity, tag: key.to_uppercase(), value })
        }
        None => {
            Ok(Edit::SetAttribute { insert: entity, tag: key.to_uppercase(), value: String::new() })
        }
    };
    entries.into_iter().map(attribute).collect()
}

/// The attachments of this name, on the entities if some are named.
fn found<'a>(
    drawing: &Drawing,
    attachments: &'a [Attachment],
    statement: &Statement,
) -> Result<Vec<&'a Attachment>, Diagnostic> {
    let kind = stated_kind_or_any(statement)?;
    let is_meant = |it: &&Attachment| {
        statement.subject.has(it.kind)
            && kind.is_none_or(|kind| kind.name == it.kind.name)
            && name(it) == Some(&*statement.name)
            && (statement.entities.is_empty()
                || it.location.handle.is_some_and(|handle| statement.entities.contains(&handle)))
    };
    let found: Vec<&Attachment> = attachments.iter().filter(is_meant).collect();
    if found.is_empty() {
        let layer = format!("{BODY_LAYER}{}", statement.name);
        let mut entities = drawing.entities.iter();
        let is_there = statement.subject == Subject::Body
            && entities.any(|entity| entity.location.layer.eq_ignore_ascii_case(&layer));
        return Err(if is_there {
            by_layer(statement, &layer)
        } else {
            not_found(attachments, statement)
        });
    }
    Ok(found)
}

/// From 0 to 1; capitals count for nothing.
fn likeness(a: &str, b: &str) -> f64 {
    strsim::jaro_winkler(&a.to_lowercase(), &b.to_lowercase())
}

fn not_found(attachments: &[Attachment], statement: &Statement) -> Diagnostic {
    let word = statement.subject.word();
    let mut message = format!("no {word} `{}` is attached to the drawing", statement.name);
    if let [entity, ..] = statement.entities[..] {
        message =
            format!("no {word} `{}` is attached to the entity {:X}", statement.name, entity.0);
    }
    let own = attachments.iter().filter(|it| statement.subject.has(it.kind));
    let mut names: Vec<&str> = own.filter_map(name).collect();
    names.sort_unstable();
    names.dedup();
    let nearest = names
        .iter()
        .max_by(|a, b| likeness(a, &statement.name).total_cmp(&likeness(b, &statement.name)));
    let fault = Diagnostic::error(codes::NOT_THERE, message);
    match nearest {
        Some(near) if likeness(near, &statement.name) > 0.7 && *near != statement.name => {
            fault.help(format!("did you mean `{near}`?"))
        }
        Some(_) => fault.note(format!("there are {}", names.join(", "))),
        None => fault.note(format!("nothing in the drawing is a {word}")),
    }
}

/// Elements that are attached by data, not by their layer alone.
fn beyond_layers<'a>(
    found: &[&'a Attachment],
    statement: &Statement,
) -> Result<Vec<&'a Attachment>, Diagnostic> {
    let own: Vec<&Attachment> = found.iter().copied().filter(|it| it.way != Way::Layer).collect();
    if own.is_empty() { Err(by_layer(statement, layer_of(found))) } else { Ok(own) }
}

/// The layer of what is attached by its layer.
fn layer_of<'a>(found: &[&'a Attachment]) -> &'a str {
    let by_layer = found.iter().find(|it| it.way == Way::Layer);
    by_layer.map_or("", |it| &it.location.layer)
}

fn by_layer(statement: &Statement, layer: &str) -> Diagnostic {
    let word = statement.subject.word();
    let message = format!("the {word} `{}` is there by its layer `{layer}`", statement.name);
    Diagnostic::error(codes::BY_LAYER, message)
        .note("what is there by its layer has no data that could be changed or removed")
        .help(format!(
            "move the geometry to another layer in the CAD program; keys are given to it by \
             `bksim cad {word} add` on one of its entities"
        ))
}

fn name(attachment: &Attachment) -> Option<&str> {
    let value = attachment.values.iter().find(|it| it.key == attachment.kind.keys[0])?;
    match &value.content {
        Content::Text(text) => Some(text),
        _ => None,
    }
}

fn states(attachment: &Attachment, key: &str) -> bool {
    attachment.values.iter().any(|value| value.key == key)
}

fn handle(attachment: &Attachment) -> Result<Handle, Diagnostic> {
    attachment.location.handle.ok_or_else(|| {
        let kind = &attachment.location.kind;
        Diagnostic::error(codes::NOT_THERE, format!("the {kind} has no handle to find it by"))
            .help("save the drawing in a newer version than R12, which gives every entity a handle")
    })
}

fn text_entry(key: &str, value: &str) -> Entry {
    Entry::Text { key: key.to_owned(), value: value.to_owned() }
}

/// The entries of the points and the direction that a statement has.
fn geometry(statement: &Statement) -> impl Iterator<Item = Entry> {
    let point = |key: &str, point: Option<Point>| {
        point.map(|point| Entry::Point { key: key.to_owned(), point })
    };
    let axis =
        statement.axis.map(|direction| Entry::Direction { key: "axis".to_owned(), direction });
    [point("at", statement.at), point("to", statement.to), axis].into_iter().flatten()
}

fn stated_kind_or_any(statement: &Statement) -> Result<Option<&'static Kind>, Diagnostic> {
    let Some(stated) = &statement.kind else { return Ok(None) };
    let known = by_name(stated).filter(|kind| statement.subject.has(kind));
    if known.is_none() {
        let message = format!("there is no {} of the kind `{stated}`", statement.subject.word());
        let fault = Diagnostic::error(codes::NO_SUCH_KEY, message);
        return Err(fault.help(kinds_of(statement.subject)));
    }
    Ok(known)
}

fn stated_kind(statement: &Statement) -> Result<Option<&'static Kind>, Diagnostic> {
    let stated = stated_kind_or_any(statement)?;
    Ok(stated.or_else(|| statement.subject.usual().and_then(by_name)))
}

fn which_kind(subject: Subject) -> Diagnostic {
    let message = format!("a {} has no usual kind", subject.word());
    Diagnostic::error(codes::NO_SUCH_KEY, message)
        .help(format!("say --kind; {}", kinds_of(subject)))
}

fn kinds_of(subject: Subject) -> String {
    let names: Vec<&str> =
        KINDS.iter().filter(|kind| subject.has(kind)).map(|kind| kind.name).collect();
    format!("the kinds are {}", names.join(", "))
}

/// The key as it is written, if the kind has it.
fn checked_key(kind: &'static Kind, key: &str) -> Result<&'static str, Diagnostic> {
    if let Some(known) = kind.keys.iter().find(|known| known.eq_ignore_ascii_case(key.trim())) {
        return Ok(known);
    }
    let message = format!("a {} has no key `{}`", kind.name, key.trim());
    let near = kind.keys.iter().find(|known| likeness(known, key) > 0.8);
    let fault = Diagnostic::error(codes::NO_SUCH_KEY, message);
    Err(match near {
        Some(near) => fault.help(format!("did you mean `{near}`?")),
        None => fault.help(format!("its keys are {}", kind.keys.join(", "))),
    })
}

fn check_geometry(kind: &Kind, statement: &Statement) -> Result<(), Diagnostic> {
    let refuse = |key: &str| {
        let message = format!("a {} has no `{key}`", kind.name);
        Err(Diagnostic::error(codes::NO_SUCH_KEY, message).help(format!("leave --{key} out")))
    };
    match kind.placement {
        Placement::Anywhere if statement.at.is_some() => refuse("at"),
        _ if statement.axis.is_some() && kind.placement != Placement::Frame => refuse("axis"),
        _ if statement.to.is_some() && kind.placement != Placement::Line => refuse("to"),
        _ => Ok(()),
    }
}

/// Names are unique among joints, loads and drives each, and among bodies; points are of a body.
fn check_name_is_free(
    attachments: &[Attachment],
    subject: Subject,
    kind: &Kind,
    new_name: &str,
) -> Result<(), Diagnostic> {
    if matches!(kind.section, Section::Points | Section::Centre) {
        return Ok(());
    }
    let mut same = attachments.iter().filter(|it| it.kind.section == kind.section);
    let Some(taken) = same.find(|it| name(it) == Some(new_name)) else { return Ok(()) };
    let message = format!("there is a {} `{new_name}` already", subject.word());
    let location = &taken.location;
    let entity =
        location.handle.map_or_else(String::new, |handle| format!(", handle {:X}", handle.0));
    Err(Diagnostic::error(codes::NAME_TAKEN, message)
        .note(format!("{}{entity}, layer {}", location.kind, location.layer))
        .help("choose another name, or change it with `set`"))
}
