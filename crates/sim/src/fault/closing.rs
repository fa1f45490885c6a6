//! Faults of positions: loops that do not close, drives out of reach, stated values that exclude
//! each other.

use super::guesses::written;
use super::reach::{Short, Span, in_words, reach_of_others, shortest_loop, spans, unit, value};
use super::words::{bodies_of, drive_position, drive_value, name, position_of, unit_of};
use super::{pole, within_turn};
use crate::codes;
use crate::mobility::loop_through;
use crate::start::{Conflict, Gap};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::{Code, Diagnostic};
use bksim_model::message::{listed, short};
use bksim_model::{Drive, JointId, Measure, Model, Parameter, Space};

/// Three digits: what a search for the edge of a reach is good for.
pub(super) fn estimate(value: f64) -> String {
    format!("{value:.2e}").parse().map_or_else(|_| short(value), short)
}

/// A loop that does not close: proved by its lengths, or not found to.
pub(super) fn cannot_close(model: &Model, gaps: &[Gap]) -> Diagnostic {
    let worst = gaps.first().copied();
    let too_short = shortest_loop(model, worst.map(|gap| gap.joint), &|_| None);
    if let Some(short) = too_short {
        return lengths_exclude(model, &short, gaps);
    }
    let Some(worst) = worst else {
        return Diagnostic::error(codes::CANNOT_CLOSE, "no position that closes was found");
    };
    let around = loop_through(model, worst.joint);
    let joint = &model.joints[worst.joint.0];
    let message = format!(
        "no position was found that closes the loop of joints {}: {}",
        in_order(model, &around),
        left_open(model, worst)
    );
    let mut fault = Diagnostic::error(codes::CANNOT_CLOSE, message)
        .at(joint.span.clone(), format!("joint `{}` stays open", joint.name));
    for note in [oblique_axes(model, &around), half_turn(model, worst)].into_iter().flatten() {
        fault = fault.note(note);
    }
    with_drives(model, fault, &around).help(format!(
        "check the points of {} and the axes of these joints, or give guesses nearer to the closed \
         position",
        listed(&bodies_of(model, &around))
    ))
}

/// A loop whose longest part is longer than all others together.
fn lengths_exclude(model: &Model, found: &Short, gaps: &[Gap]) -> Diagnostic {
    let Short { around, spans, long, gap } = found;
    let joint = &model.joints[around[0].0];
    let message = format!(
        "the loop of joints {} cannot close: the smallest gap is {} m between `{}` and `{}`",
        in_order(model, around),
        short(*gap),
        model.anchor_name(joint.predecessor),
        model.anchor_name(joint.successor),
    );
    let is_open = gaps.iter().any(|gap| gap.joint == around[0]);
    let label = if is_open { "stays open" } else { "is in this loop" };
    let fault = Diagnostic::error(codes::CANNOT_CLOSE, message)
        .at(joint.span.clone(), format!("joint `{}` {label}", joint.name));
    let (_, most) = reach_of_others(spans, *long);
    let long = &spans[*long];
    let who = in_words(long);
    // What slides has no length of its own, only a distance of its line from the next joint.
    let is_line = long.most > long.least;
    let (least, most) = (short(long.least), short(most));
    let (note, help) = if is_line {
        (
            format!(
                "{who} keeps the line that it slides on {least} m from the next joint, all other links together are {most} m"
            ),
            format!("bring that line nearer than {most} m, or make the other links longer"),
        )
    } else {
        (
            format!("{who} is {least} m between its joints, all other links together {most} m"),
            format!(
                "make {who} shorter than {most} m: the longest link must be shorter than the sum of the others"
            ),
        )
    };
    with_drives(model, fault, around).note(note).help(help)
}

/// The drives of a loop and where they hold it.
fn with_drives(model: &Model, mut fault: Diagnostic, around: &[JointId]) -> Diagnostic {
    for drive in model.drives.iter().filter(|drive| around.contains(&drive.joint)) {
        let position = drive_position(model, drive, model.solve.t_start, short);
        fault = fault.note(format!(
            "drive `{}` holds `{}` at {position} at the start",
            drive.name,
            name(model, drive.joint)
        ));
    }
    fault
}

/// `A → B → C`.
fn in_order(model: &Model, around: &[JointId]) -> String {
    around.iter().map(|&j| name(model, j)).collect::<Vec<_>>().join(" → ")
}

/// How far a joint is open in the closest position found.
fn left_open(model: &Model, gap: Gap) -> String {
    let joint = &model.joints[gap.joint.0];
    let ends = [joint.predecessor, joint.successor].map(|end| model.anchor_name(end));
    if let Some(length) = joint.kind.link_length() {
        let length = value(model, length);
        let apart = (length * length + 2.0 * length * gap.distance).max(0.0).sqrt();
        return format!(
            "the ends `{}` and `{}` of `{}` are {} m apart in the closest position found, {} m from \
             its length",
            ends[0],
            ends[1],
            joint.name,
            short(apart),
            short((apart - length).abs())
        );
    }
    let distance = gap.distance.abs();
    if gap.angle > distance {
        return format!(
            "the bodies at joint `{}` stay turned by {}° out of what it allows",
            joint.name,
            estimate(gap.angle.to_degrees())
        );
    }
    format!(
        "the smallest gap found is {} m between `{}` and `{}`",
        short(distance),
        ends[0],
        ends[1]
    )
}

/// A joint that would close if one of its sides were turned over.
fn half_turn(model: &Model, gap: Gap) -> Option<String> {
    const HALF: f64 = std::f64::consts::PI - 1e-6;
    (gap.angle > HALF && gap.distance.abs() < 1e-9).then(|| {
        format!(
            "joint `{0}` closes with one of its sides turned by 180°: turn the frame or the axis of \
             one of the two points of `{0}`",
            name(model, gap.joint)
        )
    })
}

/// Neighbouring axes of a loop that are all but parallel, where others are parallel.
fn oblique_axes(model: &Model, around: &[JointId]) -> Option<String> {
    const PARALLEL: f64 = 1e-9;
    const NEARLY: f64 = 0.3;
    /// Angle that a direction of three digits may be off, rad.
    const ROUNDED: f64 = 2e-3;
    let turning: Vec<JointId> =
        around.iter().copied().filter(|j| model.joints[j.0].kind.is_pin()).collect();
    if turning.len() < 3 || turning.len() < around.len() {
        return None;
    }
    // A revolute joint has its axis with the same components in both of its bodies.
    let axis = |j: JointId| unit(model.joints[j.0].axis.map(|e| value(model, e)));
    let sine = |a: [f64; 3], b: [f64; 3]| {
        let cross = |i: usize| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        };
        (0..3).map(|i| cross(i).powi(2)).sum::<f64>().sqrt()
    };
    let n = turning.len();
    let pairs = (0..n).map(|k| (turning[k], turning[(k + 1) % n]));
    let angles: Vec<(JointId, JointId, f64)> =
        pairs.map(|(a, b)| (a, b, sine(axis(a), axis(b)).min(1.0).asin())).collect();
    let is_parallel = angles.iter().any(|(.., angle)| *angle < PARALLEL);
    let oblique = angles.iter().filter(|(.., angle)| (PARALLEL..NEARLY).contains(angle));
    let (a, b, angle) = oblique.max_by(|a, b| a.2.total_cmp(&b.2)).filter(|_| is_parallel)?;
    let rounded = if *angle < ROUNDED {
        "; where digits were rounded away, write the direction as a formula: \
         `axis = [\"cos(30 deg)\", \"sin(30 deg)\", 0]`"
    } else {
        ""
    };
    Some(format!(
        "the axes of joints `{}` and `{}` are {}° apart on the body between them: in a loop with \
         parallel axes all must be parallel, unless one of these joints is `spherical`{rounded}",
        name(model, *a),
        name(model, *b),
        estimate(angle.to_degrees())
    ))
}

/// Drives that start where the joints cannot follow.
pub(super) fn drives_out_of_reach(model: &Model, nearest: &[(usize, f64)]) -> Diagnostic {
    let t = model.solve.t_start;
    let moved = |&(drive, off): &(usize, f64)| (&model.drives[drive], off);
    let furthest = nearest.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(moved);
    let Some((drive, off)) = furthest else {
        return Diagnostic::error(codes::DRIVE_OUT_OF_REACH, "no drive can start where it is put");
    };
    let start = drive_value(model, drive, t);
    let message = format!(
        "drive `{}` starts out of reach: it puts `{}` at {}, and the nearest position where the \
         mechanism was found to close is {}",
        drive.name,
        name(model, drive.joint),
        position_of(model, drive, start, short),
        position_of(model, drive, start + off, estimate)
    );
    let fault = Diagnostic::error(codes::DRIVE_OUT_OF_REACH, message)
        .at(drive.span.clone(), format!("at t = {} s", short(t)));
    let beyond = shortest_loop(model, Some(drive.joint), &held_by_drives(model, t));
    let note = beyond.map(|found| beyond_reach(&found)).or_else(|| reach_note(model, drive, t));
    let fault = note.into_iter().fold(fault, Diagnostic::note);
    one_freedom(model, drive, fault).unwrap_or_else(|fault| {
        fault.help("start within the reach, or change the lengths of the links of this loop")
    })
}

/// The fault of a drive together with another one in a loop that has one freedom: both by their names, and the
/// freedom. The fault as it is where there is no other.
///
/// # Errors
/// The fault as it is where no other drive moves the same freedom.
pub(super) fn one_freedom(
    model: &Model,
    drive: &Drive,
    fault: Diagnostic,
) -> Result<Diagnostic, Diagnostic> {
    let around = loop_through(model, drive.joint);
    let is_other = |other: &&Drive| other.name != drive.name && around.contains(&other.joint);
    let others: Vec<&Drive> = model.drives.iter().filter(is_other).collect();
    // A loop in the plane takes three freedoms from those of its joints.
    let of_joints: usize = around.iter().map(|j| model.joints[j.0].kind.motions().len()).sum();
    let is_planar = model.space == Space::Planar;
    let n_free = of_joints.saturating_sub(if is_planar { 3 } else { 6 });
    let Some(other) = others.last().filter(|_| !is_planar || others.len() + 1 > n_free) else {
        return Err(fault);
    };
    let held = |drive: &Drive| {
        let position = drive_position(model, drive, model.solve.t_start, short);
        format!("drive `{}` holds `{}` at {position}", drive.name, name(model, drive.joint))
    };
    let what = match n_free {
        1 => "the one freedom".to_owned(),
        n => format!("the {n} freedoms"),
    };
    let message = format!(
        "drives `{}` and `{}` move {what} of the loop {}, each in its own way",
        other.name,
        drive.name,
        in_order(model, &around)
    );
    let fault = Diagnostic { message, ..fault }.at(other.span.clone(), "the other drive");
    Ok(fault
        .note(format!("at the start {}, and {}", held(other), held(drive)))
        .help(format!("remove `[drives.{}]` or `[drives.{}]`", drive.name, other.name)))
}

/// A stated position of a joint that a drive holds at another one.
fn held_by_drive(model: &Model, conflicts: &[Conflict]) -> Option<Diagnostic> {
    let (conflict, drive) = conflicts.iter().find_map(|conflict| {
        let Measure::JointPosition(joint, idx) = model.initial[conflict.initial_idx].measure else {
            return None;
        };
        let drive = model.drives.iter().find(|d| (d.joint, d.motion_idx) == (joint, idx))?;
        Some((conflict, drive))
    })?;
    let initial = &model.initial[conflict.initial_idx];
    let start = drive_value(model, drive, model.solve.t_start);
    let shown = |value: f64| match unit_of(model, initial.measure) {
        "rad" => format!("{} deg ({} rad)", short(value.to_degrees()), short(value)),
        unit => format!("{} {unit}", short(value)),
    };
    let message = format!(
        "drive `{}` holds `{}` at {} at the start, and it is stated as {}",
        drive.name,
        initial.name,
        shown(start),
        shown(conflict.stated)
    );
    Some(
        Diagnostic::error(codes::STATED_POSITIONS, message)
            .at(initial.span.clone(), "stated here")
            .at(
                drive.span.clone(),
                format!("{} at t = {} s", shown(start), short(model.solve.t_start)),
            )
            .help(format!(
                "remove `{}` from `[initial]`, or add {} to the `motion` of the drive",
                initial.name,
                shown(conflict.stated - start)
            )),
    )
}

/// The part of a loop that does not reach while joints are held.
fn beyond_reach(short_loop: &Short) -> String {
    let Short { spans, long, .. } = short_loop;
    let (_, most) = reach_of_others(spans, *long);
    let span = &spans[*long];
    let length = short(span.least);
    let held = match span.names.as_slice() {
        [_] => format!("{} is {length} m long between its joints", in_words(span)),
        _ => format!("the outer joints of {} are {length} m apart there", in_words(span)),
    };
    format!("{held}, beyond the reach of {}: {} m", others_in_words(spans, *long), short(most))
}

/// The bodies and links of all parts but one.
fn others_in_words(spans: &[Span], one: usize) -> String {
    let others = spans.iter().enumerate().filter(|(i, _)| *i != one);
    let names: Vec<&str> =
        others.flat_map(|(_, span)| span.names.iter().map(String::as_str)).collect();
    listed(&names)
}

/// Positions of joints that drives hold.
fn held_by_drives(model: &Model, t: f64) -> impl Fn(JointId) -> Option<f64> {
    move |joint| {
        let drive = model.drives.iter().find(|drive| drive.joint == joint)?;
        Some(drive_value(model, drive, t))
    }
}

/// How far apart a drive puts the ends of its part of the loop, and what the other parts bridge.
pub(super) fn reach_note(model: &Model, drive: &Drive, t: f64) -> Option<String> {
    let spans = spans(model, &loop_through(model, drive.joint), &held_by_drives(model, t))?;
    let own = spans.iter().position(|span| span.held.contains(&drive.joint))?;
    let (least, most) = reach_of_others(&spans, own);
    if spans[own].most.is_infinite() || most.is_infinite() {
        return None;
    }
    Some(format!(
        "the outer joints of {} are {} m apart there; the reach of {} is from {} m to {} m",
        in_words(&spans[own]),
        estimate(spans[own].least),
        others_in_words(&spans, own),
        short(least),
        short(most)
    ))
}

/// Stated positions that exclude each other, with the part of the loop that does not reach.
pub(super) fn stated_positions(
    model: &Model,
    system: &SymbolicSystem,
    conflicts: &[Conflict],
) -> Diagnostic {
    let special =
        held_by_drive(model, conflicts).or_else(|| within_turn::stated(model, system, conflicts));
    if let Some(fault) = special.or_else(|| pole::stated(model, conflicts)) {
        return fault;
    }
    let mut fault = conflict(model, conflicts, codes::STATED_POSITIONS, "positions");
    if let Some(help) = &mut fault.help {
        help.push_str(&length_that_closes(model, system));
    }
    let stated = |joint: JointId| {
        let own = |c: &&Conflict| {
            model.initial[c.initial_idx].measure == Measure::JointPosition(joint, 0)
        };
        let driven = || {
            let drive = model.drives.iter().find(|drive| drive.joint == joint)?;
            Some(drive_value(model, drive, model.solve.t_start))
        };
        conflicts.iter().find(own).map(|c| c.stated).or_else(driven)
    };
    let fault = match shortest_loop(model, None, &stated) {
        // Two pins of the same bodies: no other part has a length.
        Some(Short { around, spans, .. }) if spans.len() == 1 => {
            let joints: Vec<&str> =
                around.iter().map(|id| model.joints[id.0].name.as_str()).collect();
            fault.help = Some(format!(
                "remove one of the joints {} if the bodies should turn, or what is stated of it",
                listed(&joints)
            ));
            let [joints, bodies] = [listed(&joints), in_words(&spans[0])];
            fault.note(format!("{joints} join {bodies}: together they leave no turn between them"))
        }
        Some(found) => fault.note(beyond_reach(&found)),
        None => fault,
    };
    // Drives hold what they drive, and so what is joined with it.
    let of_loop = conflicts.iter().filter_map(|c| match model.initial[c.initial_idx].measure {
        Measure::JointPosition(joint, _) => Some(loop_through(model, joint)),
        _ => None,
    });
    with_drives(model, fault, &of_loop.flatten().collect::<Vec<_>>())
}

/// The command that finds a length with which all that is stated holds, in words that go on.
fn length_that_closes(model: &Model, system: &SymbolicSystem) -> String {
    let is_length = |p: &&Parameter| {
        let mut rows = system.constraints.iter();
        p.unit == "m" && rows.any(|row| model.pool.depends_on(row.expression, p.symbol))
    };
    let Some(length) = model.parameters.iter().rfind(is_length) else { return String::new() };
    format!(
        "; or take the value of `{0}` with which all that is stated holds: `bksim kinematics MODEL --solve {0}` finds it",
        length.name
    )
}

/// Stated values that exclude each other, each with what the others allow.
pub(super) fn conflict(
    model: &Model,
    conflicts: &[Conflict],
    code: Code,
    what: &str,
) -> Diagnostic {
    let initial = |c: &Conflict| &model.initial[c.initial_idx];
    let unit = |c: &Conflict| unit_of(model, initial(c).measure);
    // The cosines of an orientation were stated as one.
    let turned = |c: &Conflict| match initial(c).measure {
        Measure::DirectionCosine(body, ..) => Some(model.bodies[body.0].name.as_str()),
        _ => None,
    };
    if conflicts.is_empty() {
        // Guesses alone led nowhere.
        let message = format!("from the guesses no {what} were found that all joints allow");
        let fault = Diagnostic::error(code, message)
            .help("write guesses nearer to a pose in which all joints close: `guess = { … }`");
        return match model.initial.first() {
            Some(initial) => fault.at(initial.span.clone(), "the first of the guesses"),
            None => fault,
        };
    }
    let mut names: Vec<&str> =
        conflicts.iter().map(|c| turned(c).unwrap_or(initial(c).name.as_str())).collect();
    names.dedup();
    let message = match (conflicts, names.as_slice()) {
        ([first, ..], [only]) if turned(first).is_some() => {
            format!("the stated orientation of `{only}` cannot be reached")
        }
        ([only], _) => format!(
            "the stated value of `{}` = {} {} cannot be reached",
            initial(only).name,
            short(only.stated),
            unit(only)
        ),
        _ => format!("the stated {what} of {} exclude each other", listed(&names)),
    };
    // The last one stated is the one to reconsider: those before it stand.
    let mut fault = Diagnostic::error(code, message);
    let mut last = None;
    for c in conflicts.iter().rev() {
        let span = initial(c).span.clone();
        if turned(c).is_none() {
            fault = fault.at(span, format!("{} {}", short(c.stated), unit(c)));
        } else if last != Some(&initial(c).span) {
            fault = fault.at(span, "its orientation");
        }
        last = Some(&initial(c).span);
    }
    let suggestion = conflicts.iter().rev().find_map(|c| c.consistent.map(|value| (c, value)));
    let is_turned = conflicts.iter().any(|c| turned(c).is_some());
    if let Some((c, value)) = suggestion.filter(|_| !is_turned) {
        let others: Vec<String> = conflicts
            .iter()
            .filter(|other| other.initial_idx != c.initial_idx)
            .map(|other| {
                format!("`{}` = {} {}", initial(other).name, short(other.stated), unit(other))
            })
            .collect();
        let given = if others.is_empty() {
            String::new()
        } else {
            format!("with {}, ", others.join(" and "))
        };
        fault = fault
            .note(format!("{given}`{}` would be {}", initial(c).name, written(value, unit(c))))
            .help(format!(
                "remove `{}`, or write it as a guess: `guess = {{ … }}`",
                initial(c).name
            ));
    } else {
        fault = fault.help("keep fewer stated values and write the others as `guess = { … }`");
    }
    fault
}
