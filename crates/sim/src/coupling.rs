//! Checks of couplings that need the equations: angles that count turns, and wheels that fit their centres.

use bksim_expr::{Expr, SymbolId, Tape, TapeError};
use bksim_mbs::belt::ends;
use bksim_mbs::coordinate::Owner;
use bksim_mbs::coupling::{Cones, center_line, turn};
use bksim_mbs::signal::{coordinates_at_start, signal_values};
use bksim_mbs::system::SymbolicSystem;
use bksim_mbs::worm::Worm;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{
    Belt, BodyId, Coupling, CouplingKind, GROUND, Measure, Model, MotionKind, Rope, RopeGrip,
    Space, Vector, Wheels,
};

use crate::belt::{NoStrand, Way, span_between};
use crate::codes;

/// Largest difference of a centre distance from the sum of the radii, relative to it.
const FIT: f64 = 1e-6;

/// The faults of the couplings of `model`.
///
/// # Errors
/// [`TapeError`] when an expression cannot be compiled.
pub(crate) fn check_couplings(
    model: &Model,
    system: &SymbolicSystem,
) -> Result<Vec<Diagnostic>, TapeError> {
    let mut faults = Vec::new();
    for coupling in model.all_couplings() {
        // A belt in space is refused as a whole.
        if !matches!(coupling.kind, CouplingKind::Strand(..) | CouplingKind::Rope(..)) {
            faults.extend(uncounted(model, system, coupling));
        }
        if let CouplingKind::Gear(wheels) | CouplingKind::Belt(wheels) = &coupling.kind {
            faults.extend(misfit(model, system, coupling, wheels)?);
            faults.extend(skew(model, system, coupling, wheels)?);
        }
    }
    for belt in &model.belts {
        faults.extend(belt_fault(model, system, belt)?);
    }
    for rope in &model.ropes {
        faults.extend(gripped(model, system, rope));
        faults.extend(rope_fault(model, system, rope)?);
    }
    Ok(faults)
}

/// A rope that grips a pulley of a body that no joint lets turn: it is as if tied to the body.
fn gripped(model: &Model, system: &SymbolicSystem, rope: &Rope) -> Option<Diagnostic> {
    let coordinates = coordinates_at_start(model, &system.kinematics);
    let turns = |body: BodyId| {
        let angle = system.kinematics.measure(model, Measure::BodyAngle(body));
        coordinates.iter().any(|(symbol, _)| model.pool.depends_on(angle, *symbol))
    };
    let inner = 1..rope.nodes.len().saturating_sub(1);
    let place = (inner.map(|k| (k, &rope.nodes[k]))).find(|(_, node)| {
        node.grip == RopeGrip::Holds && node.center.body != GROUND && !turns(node.center.body)
    });
    let (k, node) = place?;
    let center = model.anchor_name(node.center);
    let body = &model.bodies[node.center.body.0].name;
    let message = format!(
        "rope `{}` grips the pulley at `{center}`, and the joints of `{body}` do not let it turn",
        rope.name
    );
    let label = format!("at place {} of `over`", k + 1);
    let help =
        "write `slips = true` of the pulley: the rope runs over it, as if it turned in the body";
    Some(
        Diagnostic::error(codes::PULLEY_CANNOT_TURN, message)
            .at(rope.span.clone(), label)
            .help(help),
    )
}

/// A rope without a way where the start puts what it goes over.
fn rope_fault(
    model: &Model,
    system: &SymbolicSystem,
    rope: &Rope,
) -> Result<Option<Diagnostic>, TapeError> {
    let fault = |message: String, label: &str, help: String| {
        let fault = Diagnostic::error(codes::ROPE_WAY, message).at(rope.span.clone(), label);
        Ok(Some(fault.help(help)))
    };
    if model.space == Space::Spatial {
        let message = format!("rope `{}` is laid in space", rope.name);
        let help =
            "write a joint of type `distance` with `max` for a straight rope between two points";
        return fault(message, "needs a planar model", help.to_owned());
    }
    let wheels: Vec<(Vector, Expr)> = (rope.nodes.iter())
        .map(|node| (system.kinematics.anchor(model, node.center), node.radius))
        .collect();
    let wheels = at_the_start(model, system, &wheels)?;
    let missing = wheels.windows(2).position(|pair| span_between(pair[0], pair[1]).is_none());
    let Some(k) = missing else { return Ok(None) };
    let (([ax, ay], a), ([bx, by], b)) = (wheels[k], wheels[k + 1]);
    let mm = |length: f64| format!("{} mm", short(1e3 * length));
    let message = format!(
        "rope `{}` has no way from place {} of `over` to place {}",
        rope.name,
        k + 1,
        k + 2
    );
    let label = format!("they are {} apart at the start", mm((bx - ax).hypot(by - ay)));
    let help = format!(
        "bring them more than {} apart: move them, state or guess in `[initial]` where they begin, or turn the other way around one",
        mm((b - a).abs())
    );
    fault(message, &label, help)
}

/// Centres and radii where the start puts them, m.
fn at_the_start(
    model: &Model,
    system: &SymbolicSystem,
    wheels: &[(Vector, Expr)],
) -> Result<Vec<([f64; 2], f64)>, TapeError> {
    let pool = &model.pool;
    let start: Vec<(SymbolId, Expr)> = coordinates_at_start(model, &system.kinematics);
    let parts = wheels.iter().flat_map(|(center, radius)| [center[0], center[1], *radius]);
    let outputs: Vec<Expr> = parts.map(|part| pool.substitute(part, &start)).collect();
    let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let values: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    let tape = Tape::compile(pool, &outputs, &[], &symbols)?;
    let mut out = vec![0.0; outputs.len()];
    tape.evaluate(&mut tape.workspace(&values), &[], &mut out);
    Ok(out.as_chunks::<3>().0.iter().map(|&[x, y, r]| ([x, y], r)).collect())
}

/// A belt that does not fit its wheels where the start puts them.
fn belt_fault(
    model: &Model,
    system: &SymbolicSystem,
    belt: &Belt,
) -> Result<Option<Diagnostic>, TapeError> {
    let fault = |message: String, label: &str, help: String| {
        let fault = Diagnostic::error(codes::BELT_WAY, message).at(belt.span.clone(), label);
        Ok(Some(fault.help(help)))
    };
    if model.space == Space::Spatial {
        let message = format!("belt `{}` goes around its wheels in space", belt.name);
        let help = "couple the wheels two by two, each pair with a belt of its own";
        return fault(message, "needs a planar model", help.to_owned());
    }

    // The wheels where the start puts them, and the way around them.
    let (pool, kinematics) = (&model.pool, &system.kinematics);
    let start: Vec<(SymbolId, Expr)> = coordinates_at_start(model, kinematics);
    let mut outputs = Vec::new();
    for wheel in &belt.wheels {
        let center = kinematics.anchor(model, ends(model, wheel)[1]);
        outputs.extend([center[0], center[1]].map(|part| pool.substitute(part, &start)));
        outputs.push(wheel.radius);
    }
    outputs.push(belt.length.unwrap_or(pool.zero()));
    let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let values: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    let tape = Tape::compile(pool, &outputs, &[], &symbols)?;
    let mut out = vec![0.0; outputs.len()];
    tape.evaluate(&mut tape.workspace(&values), &[], &mut out);
    let (wheels, rest) = out.as_chunks::<3>();
    let wheels: Vec<([f64; 2], f64)> = wheels.iter().map(|&[x, y, r]| ([x, y], r)).collect();
    let mm = |length: f64| format!("{} mm", short(1e3 * length));
    let name = |k: usize| &model.joints[belt.wheels[k % wheels.len()].joint.0].name;
    let way = match Way::around(&wheels) {
        Ok(way) => way,
        Err(NoStrand(k)) => {
            let (([ax, ay], a), ([bx, by], b)) = (wheels[k], wheels[(k + 1) % wheels.len()]);
            let distance = (bx - ax).hypot(by - ay);
            let message = format!(
                "belt `{}` has no way from the wheel of `{}` to that of `{}`",
                belt.name,
                name(k),
                name(k + 1)
            );
            let label = format!("their centres are {} apart at the start", mm(distance));
            let help = format!(
                "bring them more than {} apart: move them, or state or guess in `[initial]` where they begin",
                mm((b - a).abs())
            );
            return fault(message, &label, help);
        }
    };

    // A belt that goes around more than once crosses itself.
    let turns = way.turns(&wheels);
    let is_crossed = wheels.iter().any(|w| w.1 > 0.0) && wheels.iter().any(|w| w.1 < 0.0);
    let is_simple = (turns.abs() - 1.0).abs() < 0.5 || is_crossed && turns.abs() < 0.5;
    if !is_simple {
        let message =
            format!("belt `{}` winds {} times around itself", belt.name, short(turns.round()));
        let help = "list the wheels in the order in which the belt comes to them, counter-clockwise, or say by `turns` in which sense it goes around each";
        return fault(message, "does not follow these wheels", help.to_owned());
    }
    let signals = signal_values(model, kinematics);
    let moving = pool.simplify(pool.substitute(belt.way, &signals));
    let is_moving = !kinematics.coordinates_in(pool, &[moving]).is_empty();
    let (length, found) = (rest[0], way.length(&wheels));
    if is_moving && belt.length.is_none() {
        let message = format!("belt `{}` has no length, but its wheels move", belt.name);
        let help = format!("write its length; the way at the start is `length = \"{found} m\"`");
        return fault(message, "as long as the way around the wheels allows", help);
    }
    let is_rigid = belt.tensions.is_empty() && belt.length.is_some();
    if !is_moving && is_rigid && (found - length).abs() > FIT * found {
        let message = format!(
            "belt `{}` is {} long, the way around its wheels {}",
            belt.name,
            mm(length),
            mm(found)
        );
        let help = format!(
            "write `length = \"{found} m\"` or leave it out, move a wheel, or give the belt a `stiffness`"
        );
        return fault(message, "nothing can move to make up for it", help);
    }
    Ok(None)
}

/// An angle of the relation that is known up to whole turns only.
fn uncounted(model: &Model, system: &SymbolicSystem, coupling: &Coupling) -> Option<Diagnostic> {
    let used = |symbol: SymbolId| model.pool.depends_on(coupling.relation, symbol);
    let mut signals = model.signals.iter().filter(|signal| used(signal.symbol));
    let kinematics = &system.kinematics;
    let is_spatial = model.space == Space::Spatial;
    let name = signals.find_map(|signal| match signal.measure {
        Measure::Turn(body, against, joint) => {
            let is_counted = turn(model, kinematics, body, against, joint).is_some();
            (!is_counted).then(|| &model.joints[joint.0].name)
        }
        Measure::JointPosition(joint, idx) => {
            let of = &model.joints[joint.0];
            let owner = Owner::Joint(joint, idx);
            let is_own = kinematics.coordinates.iter().any(|c| c.owner == owner);
            let turns = of.kind.motions().get(idx) == Some(&MotionKind::Rotation);
            (is_spatial && turns && !is_own).then_some(&of.name)
        }
        Measure::BodyAngle(body) => is_spatial.then(|| &model.bodies[body.0].name),
        Measure::CardanAngle(body, _)
        | Measure::RollPitchYaw(body, _)
        | Measure::Quaternion(body, _)
        | Measure::DirectionCosine(body, ..) => Some(&model.bodies[body.0].name),
        _ => None,
    })?;
    let message = format!("coupling `{}` cannot count the turns of `{name}`", coupling.name);
    Some(
        Diagnostic::error(codes::UNCOUNTED_TURNS, message)
            .at(coupling.span.clone(), "needs an angle that goes on beyond a turn")
            .note("in space only the coordinate of a joint that is not cut counts its turns")
            .help(
                "couple angles of revolute joints about parallel axes, and leave out `cut = true` there",
            ),
    )
}

/// Teeth with a pressure angle of which it is not known where they press: wheels whose axes neither are parallel nor meet,
/// and bevel wheels with a helix, or with both centres in the apex.
fn skew(
    model: &Model,
    system: &SymbolicSystem,
    coupling: &Coupling,
    wheels: &Wheels,
) -> Result<Option<Diagnostic>, TapeError> {
    const NEITHER: &str = "remove `pressure_angle` and `helix`";
    let Some(flanks) = wheels.flanks else { return Ok(None) };
    if wheels.worm.is_none() && center_line(model, &system.kinematics, wheels).is_some() {
        return Ok(None);
    }
    let name = &coupling.name;
    let fault = |message: String, help: &str| {
        let fault = Diagnostic::error(codes::SKEW_TEETH, message);
        Ok(Some(fault.at(coupling.span.clone(), "where its teeth press is not known").help(help)))
    };
    if let Some(size) = wheels.worm {
        let Some(worm) = Worm::of(model, &system.kinematics, wheels) else {
            let help = "turn one of the axes by 90 deg, or remove `worm_radius`";
            return fault(format!("the axes of worm `{name}` and its wheel are parallel"), help);
        };
        let sum = model.pool.add(size.radius, radii_of(model, wheels)[1]);
        let numbers = at_the_start(model, system, &[([worm.cosine, worm.distance, sum], sum)])?;
        let Some(&([cosine, distance], sum)) = numbers.first() else { return Ok(None) };
        if cosine.abs() > FIT {
            let help = "turn one of the axes, or remove `worm_radius` and `pressure_angle`";
            return fault(
                format!("the axes of worm `{name}` and its wheel do not cross at a right angle"),
                help,
            );
        }
        if (distance - sum).abs() > FIT * sum {
            let mm = |length: f64| format!("{} mm", short(1e3 * length));
            let message = format!(
                "the axes of worm `{name}` and its wheel are {} apart, and their radii ask for {}",
                mm(distance),
                mm(sum)
            );
            return fault(message, "move one of the axes, or write another `worm_radius`");
        }
        return Ok(None);
    }
    let cones = Cones::of(model, &system.kinematics, wheels);
    let radii = radii_of(model, wheels);
    let Some(Cones { sides: [a, b], apart, .. }) = cones else {
        return fault(format!("the wheels of gears `{name}` turn about one axis"), NEITHER);
    };
    let numbers = [([apart, a, a], radii[1]), ([b, b, b], radii[1])];
    let numbers = at_the_start(model, system, &numbers)?;
    let ([apart, a], radius) = numbers[0];
    let ([b, _], _) = numbers[1];
    if apart.abs() > FIT * radius {
        return fault(format!("the axes of gears `{name}` neither are parallel nor meet"), NEITHER);
    }
    if !model.pool.is_zero(flanks.axial) {
        return fault(format!("the bevel gears `{name}` have a `helix`"), "remove `helix`");
    }
    let least = FIT * radius * radius;
    if a.min(b) < -least && a.max(b) > least {
        let help = "turn the axis of one joint round, or write `internal = true` where its axes point away from each other";
        return fault(
            format!("the bevel gears `{name}` turn in senses that their places exclude"),
            help,
        );
    }
    if a.abs().max(b.abs()) <= least {
        let help = "move the points of their joints along the axes, to the middle of each wheel";
        return fault(
            format!("both centres of the bevel gears `{name}` are where their axes meet"),
            help,
        );
    }
    Ok(None)
}

/// Pitch radii of wheels, one where they are not stated.
fn radii_of(model: &Model, wheels: &Wheels) -> [Expr; 2] {
    wheels.radii.unwrap_or([model.pool.one(); 2])
}

/// Wheels whose radii do not fit the distance of their centres, where it is constant.
fn misfit(
    model: &Model,
    system: &SymbolicSystem,
    coupling: &Coupling,
    wheels: &Wheels,
) -> Result<Option<Diagnostic>, TapeError> {
    let Some(radii) = wheels.radii else { return Ok(None) };
    let Some((_, square)) = center_line(model, &system.kinematics, wheels) else { return Ok(None) };
    if !system.kinematics.coordinates_in(&model.pool, &[square]).is_empty() {
        return Ok(None);
    }
    let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let values: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    let outputs: Vec<Expr> = vec![square, radii[0], radii[1], wheels.ratio];
    let tape = Tape::compile(&model.pool, &outputs, &[], &symbols)?;
    let mut out = vec![0.0; outputs.len()];
    tape.evaluate(&mut tape.workspace(&values), &[], &mut out);
    let [square, first, second, ratio] = [out[0], out[1].abs(), out[2], out[3]];

    let distance = square.sqrt();
    let is_same = ratio > 0.0;
    let fitting = if is_same { (first - second).abs() } else { first + second };
    let mm = |length: f64| format!("{} mm", short(1e3 * length));
    let (fault, help) = match coupling.kind {
        CouplingKind::Gear(_) if (distance - fitting).abs() > FIT * fitting => (
            format!("the radii of gears `{}` ask for centres {} apart", coupling.name, mm(fitting)),
            format!(
                "move a centre to that distance, or write `ratio = {}` where the pitch circles are others",
                short(ratio)
            ),
        ),
        CouplingKind::Belt(_) if distance <= fitting => (
            format!("belt `{}` has no way around its wheels", coupling.name),
            format!("move the centres more than {} apart", mm(fitting)),
        ),
        _ => return Ok(None),
    };
    let fault = Diagnostic::error(codes::CENTRE_DISTANCE, fault)
        .at(coupling.span.clone(), format!("the centres are {} apart", mm(distance)));
    Ok(Some(fault.help(help)))
}
