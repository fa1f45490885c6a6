//! Faults of the start: loops that cannot close, stated values that exclude each other.

use super::values::FaultInstant;
use super::words::name;
use super::{amount, closing, pole, switch};
use crate::codes;
use crate::compiled::CompiledSystem;
use crate::mobility::Mobility;
use crate::start::StartError;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::{counted, listed, short};
use bksim_model::{Body, BodyId, GROUND, Joint, JointId, Load, Model, Space};

/// The diagnostic of a start that was not found.
pub fn diagnose_start(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    error: &StartError,
) -> Diagnostic {
    match error {
        StartError::NoCoordinates => {
            let message = "the model has no coordinates: every body is welded to the ground";
            let fault = Diagnostic::error(codes::NO_MOBILITY, message)
                .help("give at least one body a joint that lets it move");
            match model.joints.first() {
                Some(joint) => fault.at(joint.span.clone(), "this joint allows no motion"),
                None => fault,
            }
        }
        StartError::CannotClose { gaps, .. } => closing::cannot_close(model, gaps),
        StartError::DrivesOutOfReach { drives } => closing::drives_out_of_reach(model, drives),
        StartError::StatedPositions { conflicts } => {
            closing::stated_positions(model, system, conflicts)
        }
        StartError::StatedVelocities { conflicts } => {
            closing::conflict(model, conflicts, codes::STATED_VELOCITIES, "rates")
        }
        StartError::DriveCannotMove { drive_idx } => {
            let drive = &model.drives[*drive_idx];
            let message = format!("drive `{}` cannot move its joint at the start", drive.name);
            let fault = Diagnostic::error(codes::DRIVE_AT_START, message)
                .at(drive.span.clone(), "this rate is excluded by the other constraints")
                .note(format!("at t = {} s the joints allow no such rate", model.solve.t_start));
            closing::one_freedom(model, drive, fault).unwrap_or_else(|fault| {
                fault.help("start from another position, or drive another joint")
            })
        }
        StartError::NoInertia { coordinates, q } => pole::at_start(model, system, coordinates, q)
            .unwrap_or_else(|| no_inertia(model, system, compiled, coordinates)),
        StartError::SharedReaction { joint } => shared_reaction(model, *joint),
        StartError::TooMuch => amount::too_much(&model.solve, compiled),
        StartError::TooManyTicks { clock, every } => amount::too_many_ticks(model, *clock, *every),
        StartError::Irreversible => irreversible(model, system),
        StartError::NotFinite { q, v } => not_finite(model, system, compiled, (q, v)),
        StartError::BeyondStop { load, by } => switch::beyond_stop(model, *load, *by),
        StartError::NoConsistentModes(fault) => {
            switch::no_consistent_modes(model, system, fault, model.solve.t_start)
        }
        StartError::Compile(error) => {
            Diagnostic::error(codes::NOT_FINITE_AT_START, error.to_string())
        }
    }
}

/// Friction that no equilibrium of rigid bodies determines.
fn shared_reaction(model: &Model, joint: JointId) -> Diagnostic {
    let rubs = |load: &&Load| {
        let of = load.kind.joint_motion().filter(|_| load.kind.coulomb().is_some());
        of.is_some_and(|(of, _)| of == joint)
    };
    let joint_name = &model.joints[joint.0].name;
    let message =
        format!("the friction of joint `{joint_name}` depends on a reaction that is not unique");
    let fault = Diagnostic::error(codes::SHARED_REACTION, message)
        .note("other joints could bear this load in its place, and rigid bodies do not tell which does")
        .help("let the joints that repeat each other give way, or state the friction itself: `force = …`");
    if let Some(load) = model.loads.iter().find(rubs) {
        return fault.at(load.span.clone(), "this friction");
    }
    let message = format!("the reaction of joint `{joint_name}` is used, but is not unique");
    let span = model.joints[joint.0].span.clone();
    let help = "let the joints that repeat each other give way";
    Diagnostic { message, ..fault }.at(span, "bears what others could").help(help)
}

/// A run back in time over what switches.
fn irreversible(model: &Model, system: &SymbolicSystem) -> Diagnostic {
    let (from, to) = (model.solve.t_start, model.solve.t_end);
    let message =
        format!("the run goes back in time, from {from} s to {to} s, but something switches");
    let fault = Diagnostic::error(codes::IRREVERSIBLE, message)
        .note("stops, friction and kinks of expressions are passed forwards in time only")
        .help("end the run after its start, or leave out what switches");
    match system.contacts.first() {
        Some(contact) => {
            let load = &model.loads[contact.load.0];
            fault.at(load.span.clone(), "what this does cannot be undone")
        }
        None => fault,
    }
}

/// Warnings about redundant joints and about mechanisms that cannot move.
pub fn diagnose_mobility(model: &Model, mobility: &Mobility) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    if !mobility.redundant.is_empty() {
        let names: Vec<&str> = mobility.redundant.iter().map(|&j| name(model, j)).collect();
        let who = match names.as_slice() {
            [only] => format!("joint `{only}` repeats constraints of the other joints"),
            _ => format!("joints {} repeat each other's constraints", listed(&names)),
        };
        let counted = counter(model);
        let message = format!(
            "{who}: {counted} counts {}, true mobility is {}, {}",
            mobility.gruebler,
            mobility.mobility,
            match mobility.n_redundant {
                1 => "1 condition is redundant".to_owned(),
                n => format!("{n} conditions are redundant"),
            }
        );
        let mut links = superfluous_links(model);
        // Without its only body nothing is left of a mechanism.
        if let [_, only] = model.bodies.as_slice() {
            links.retain(|name| *name != only.name);
        }
        let help = match links.as_slice() {
            [] => {
                "the run goes on with the smallest reactions; nothing needs to be done".to_owned()
            }
            links => format!(
                "the run goes on with the smallest reactions; without {} they would be unique",
                one_of(links)
            ),
        };
        let first = &model.joints[mobility.redundant[0].0];
        found.push(
            Diagnostic::warning(codes::REDUNDANT, message)
                .at(first.span.clone(), "one of the redundant joints")
                .note("the motion is unique; some reactions of these joints are not")
                .note(format!("not unique: {}", shared_directions(model, mobility)))
                .note(format!("redundant: {}", repeated_conditions(model, mobility)))
                .help(help),
        );
    }
    if mobility.mobility == 0 && !is_led_by_lengths(model) {
        let message = format!(
            "mobility 0: nothing can move; {} counts {}, and {} {}",
            counter(model),
            mobility.gruebler,
            counted(mobility.rank, "independent constraint holds", "independent constraints hold"),
            counted(mobility.rank, "coordinate", "coordinates")
        );
        let fault = Diagnostic::warning(codes::NO_MOBILITY, message);
        found.push(match superfluous_links(model).as_slice() {
            [] if !mobility.redundant.is_empty() => fault
                .note("a flat loop in space is rigid where its axes are parallel but for rounding")
                .help(
                    "give axes that are meant parallel all their digits: `bksim doctor` shows how far they are off; else \
                     remove a body that locks the mechanism, together with its joints",
                ),
            [] => fault.help("remove a body that locks the mechanism, together with its joints"),
            links => fault
                .note(format!("{} locks a loop that could move without it", one_of(links)))
                .help(format!("remove {} together with its joints", one_of(links))),
        });
    }
    found
}

/// Whether lengths or relations that change in time move the mechanism, though it has no freedom left.
fn is_led_by_lengths(model: &Model) -> bool {
    let lengths = model.joints.iter().filter_map(|joint| joint.kind.link_length());
    let relations = model.couplings.iter().map(|coupling| coupling.relation);
    lengths.chain(relations).any(|e| model.pool.depends_on(e, model.time))
}

/// Who counted the freedoms so.
fn counter(model: &Model) -> &'static str {
    if model.space == Space::Planar { "Grübler" } else { "Kutzbach" }
}

/// The components of reactions that are not unique, joints with the same ones together: "fx and fy of `A`
/// and `B`".
fn shared_directions(model: &Model, mobility: &Mobility) -> String {
    const COMPONENTS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];
    let mut groups: Vec<([bool; 6], Vec<&str>)> = Vec::new();
    for &joint in &mobility.redundant {
        let unique = mobility.unique[joint.0];
        match groups.iter_mut().find(|(of, _)| *of == unique) {
            Some((_, names)) => names.push(name(model, joint)),
            None => groups.push((unique, vec![name(model, joint)])),
        }
    }
    let told = |(unique, names): &([bool; 6], Vec<&str>)| {
        let shared = COMPONENTS.iter().zip(unique).filter(|(_, is_unique)| !**is_unique);
        let shared: Vec<&str> = shared.map(|(component, _)| *component).collect();
        format!("{} of {}", shared.join(", "), listed(names))
    };
    groups.iter().map(told).collect::<Vec<_>>().join("; ")
}

/// The redundant conditions, by joint and direction.
fn repeated_conditions(model: &Model, mobility: &Mobility) -> String {
    let words = mobility.repeated.iter().map(|repeated| repeated.condition.words(model));
    words.collect::<Vec<_>>().join("; ")
}

/// Bars that could go: bodies on two joints, and massless links, whose neighbours stay held by two
/// joints each without them.
fn superfluous_links(model: &Model) -> Vec<String> {
    let ends = |j: &bksim_model::Joint| [j.predecessor.body, j.successor.body];
    let joints_of = |body: BodyId| -> Vec<&bksim_model::Joint> {
        model.joints.iter().filter(|j| ends(j).contains(&body)).collect()
    };
    let stays_held = |body: BodyId| body == GROUND || joints_of(body).len() > 2;
    let bars = (1..model.bodies.len()).map(BodyId).filter(|&body| {
        let joints = joints_of(body);
        let neighbours = joints.iter().flat_map(|j| ends(j)).filter(|&other| other != body);
        joints.len() == 2 && neighbours.into_iter().all(stays_held)
    });
    let bars = bars.map(|body| model.bodies[body.0].name.clone());
    let is_link = |j: &&bksim_model::Joint| j.kind.link_length().is_some();
    let links = model.joints.iter().filter(is_link).filter(|j| ends(j).into_iter().all(stays_held));
    bars.chain(links.map(|j| j.name.clone())).collect()
}

/// "`a`", or "one of `a`, `b` and `c`".
fn one_of(names: &[String]) -> String {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    if names.len() == 1 { listed(&names) } else { format!("one of {}", listed(&names)) }
}

/// The two ball joints of a body that has no others.
fn between_balls(model: &Model, body: BodyId) -> Option<[&str; 2]> {
    let has = |joint: &&Joint| [joint.predecessor.body, joint.successor.body].contains(&body);
    let joints: Vec<&Joint> = model.joints.iter().filter(has).collect();
    match joints.as_slice() {
        [a, b] if [a, b].iter().all(|joint| joint.kind.is_ball()) => {
            Some([a.name.as_str(), b.name.as_str()])
        }
        _ => None,
    }
}

/// The ball joint of a body that has a mass at a distance from it, but not all moments of inertia.
fn ball_of_point(model: &Model, body: BodyId) -> Option<&str> {
    let value = |expr| {
        let value = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
        model.pool.evaluate(expr, &value).unwrap_or(f64::NAN)
    };
    let Body { mass, inertia, .. } = &model.bodies[body.0];
    let lacks_moment = inertia.moments.into_iter().any(|moment| value(moment) == 0.0);
    let has = |joint: &&Joint| [joint.predecessor.body, joint.successor.body].contains(&body);
    let ball = model.joints.iter().filter(has).find(|joint| joint.kind.is_ball())?;
    (value(*mass) > 0.0 && lacks_moment).then_some(ball.name.as_str())
}

fn no_inertia(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    coordinates: &[usize],
) -> Diagnostic {
    use bksim_mbs::coordinate::Owner;
    let owner = coordinates.first().map(|&i| system.coordinates()[i].owner);
    let (name, span) = match owner {
        Some(Owner::Joint(joint, _)) => {
            let moved = &model.bodies[model.joints[joint.0].successor.body.0].name;
            let words = format!("body `{moved}` in joint `{}`", name(model, joint));
            (words, Some(model.joints[joint.0].span.clone()))
        }
        Some(Owner::Body(body, _) | Owner::Quaternion(body, _)) => (
            format!("body `{}`", model.bodies[body.0].name),
            Some(model.bodies[body.0].span.clone()),
        ),
        Some(Owner::State(state)) => (
            format!("state `{}`", model.states[state.0].name),
            Some(model.states[state.0].span.clone()),
        ),
        None => ("the mechanism".to_owned(), None),
    };
    let moved: Vec<&str> =
        coordinates.iter().map(|&i| compiled.coordinates[i].name.as_str()).collect();
    let message =
        format!("a motion of {name} has no inertia: {} can accelerate freely", listed(&moved));
    let spinning = match owner {
        Some(Owner::Joint(joint, _)) => Some(model.joints[joint.0].successor.body),
        Some(Owner::Body(body, _) | Owner::Quaternion(body, _)) => Some(body),
        _ => None,
    };
    let fault = Diagnostic::error(codes::NO_INERTIA, message);
    let fault = match spinning.and_then(|body| between_balls(model, body)) {
        Some([one, other]) => fault
            .note(format!(
                "between the ball joints `{one}` and `{other}` it spins about the line through both, \
                 and nothing says how"
            ))
            .help(format!(
                "give it a moment of inertia about this line, make `{one}` a `universal` joint, or write a \
                 `link` in place of the body"
            )),
        None => fault.help(match spinning.and_then(|body| ball_of_point(model, body)) {
            Some(joint) => format!(
                "its mass resists no turn about the line through `{joint}` and its centre of mass: give it a moment of \
                 inertia about this line, however small, as in `inertia = [1e-6, 1e-6, 1e-6]`"
            ),
            None => "give the moving body a mass or a moment of inertia, or weld it".to_owned(),
        }),
    };
    match span {
        Some(span) => fault.at(span, "nothing resists this motion"),
        None => fault,
    }
}

/// The load, drive or input without a finite value at the positions and velocities found.
fn not_finite(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    (q, v): (&[f64], &[f64]),
) -> Diagnostic {
    let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    let known = |values: &[f64]| {
        if values.len() == compiled.nq() { values.to_vec() } else { vec![0.0; compiled.nq()] }
    };
    let t = model.solve.t_start;
    let (q, v) = (known(q), known(v));
    let instant = FaultInstant { model, system, compiled, parameters: &parameters, t, q, v };

    // An input, or an expression out of its domain.
    if let Some(input) = instant.no_input() {
        let help = "let inputs return finite numbers from the start on";
        return Diagnostic { code: codes::NOT_FINITE_AT_START, ..input }.help(help);
    }
    if let Some(fault) = instant.out_of_domain(codes::NOT_FINITE_AT_START) {
        return fault;
    }

    // A load whose law has a value, but not its force or energy.
    if let Some(fault) = instant.no_force(codes::NOT_FINITE_AT_START) {
        return fault;
    }

    // What is left is the motion itself: velocities or masses beyond all numbers.
    let message = format!("the equations have no finite value at t = {} s", short(t));
    let fault = Diagnostic::error(codes::NOT_FINITE_AT_START, message);
    match instant.largest_rate() {
        Some((name, x, unit)) => fault
            .note(format!("`{name}` is {} {unit}", short(x)))
            .help("look for a value in a wrong unit: squares of it must be below 1.8e308"),
        None => fault.help("look for masses, lengths and drives that are far too large"),
    }
}
