//! Stops and dry friction as constraint rows, each with the law that opens and closes it.

use bksim_expr::{Expr, Function, Pool, SymbolId};

use crate::constraint::{Constraint, Source};
use crate::coupling::{along, flank_wrenches};
use crate::folding::short;
use crate::force::Wrench;
use crate::joint;
use crate::kinematics::Kinematics;
use crate::rope::{self, section_wrenches};
use crate::rubbing::friction;
use crate::signal::{signal_values, values_at_start};
use crate::sliding::Sliding;
use crate::touch::{Touching, is_on_track, pressing, speed_along, way_of_slip};
use bksim_model::{FrictionLaw, JointId, LoadId, LoadKind, Model, MotionKind, Opposed, Signal};

/// A constraint row that opens and closes.
#[derive(Clone, Debug)]
pub struct Contact {
    /// The stop or the friction.
    pub load: LoadId,
    /// The joint it acts in; `None` of a rope.
    pub joint: Option<JointId>,
    /// Position p of the motion it acts on, rad or m; φ of a rope or of a place of a contact, whose friction has its
    /// coefficient here.
    pub position: Expr,
    /// φ′ of a stop, p′ of friction.
    pub rate: Expr,
    /// φ of a stop, whether or not its row holds; p₀ − p of friction.
    pub expression: Expr,
    /// Row among the constraints of the system.
    pub row: usize,
    /// Symbol of κ: 1 while the row holds, else 0.
    pub closed: SymbolId,
    /// The law by which it opens and closes.
    pub law: Law,
}

/// The law of a contact.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// The row is the penetration φ ≤ 0, its multiplier the force λ ≥ 0 that keeps the bodies apart.
    Stop {
        /// Speed after an impact over the speed before.
        restitution: Expr,
        /// Positive where there is one: outlines touch as far as their edges reach. One of other stops.
        reach: Expr,
    },
    /// The row is p₀ − p, its multiplier the friction along p, |λ| no greater than `sticking`.
    Friction {
        /// Friction F while it slides, N or N m; it may depend on multipliers of its joint. In one of two directions its
        /// component, F times that of the unit vector along the slip.
        sliding: Expr,
        /// Largest friction F₀ while it sticks, N or N m; so may this.
        sticking: Expr,
        /// Symbol of ς: the sign of p′ while it slides, else 0.
        slip: SymbolId,
        /// Symbol of p₀, the position at which it sticks.
        stuck_at: SymbolId,
        /// In two directions of a tangent plane: the contact of the other one. Both have one limit, √(λ₁² + λ₂²) ≤ F₀, and
        /// their ς are the components of the unit vector in which the slip began.
        other: Option<usize>,
    },
}

impl Law {
    /// The friction −λ while it slides; `None` of a stop.
    pub fn slipping(&self, pool: &Pool) -> Option<Expr> {
        let Self::Friction { sliding, slip, other, .. } = *self else { return None };
        Some(if other.is_some() { sliding } else { pool.mul(pool.symbol_expr(slip), sliding) })
    }

    /// F while friction slides and F₀ while it sticks, with the multiplier `lambda` of its row; `None` of a stop.
    ///
    /// Friction holds with no less than it would slide with, against the motion that it keeps from beginning.
    ///
    /// # Panics
    /// Never: `sign` has one argument and `max` two.
    pub fn friction(&self, pool: &Pool, lambda: SymbolId) -> Option<[Expr; 2]> {
        let Self::Friction { sliding, sticking, slip, other, .. } = *self else { return None };
        if other.is_some() {
            return Some([sliding, sticking]);
        }
        let held = pool.call(Function::Sign, &[pool.symbol_expr(lambda)]).expect("one argument");
        let sliding_then = pool.substitute(sliding, &[(slip, pool.neg(held))]);
        let sticking = if sticking == sliding_then {
            sticking
        } else {
            pool.call(Function::Max, &[sticking, sliding_then]).expect("two arguments")
        };
        Some([sliding, sticking])
    }
}

/// A limit of a stop as a function of the position alone.
#[derive(Clone, Debug)]
pub struct Penetration {
    /// The stop.
    pub load: LoadId,
    /// `min` or `max`, as of its constraint row.
    pub direction: &'static str,
    /// φ, rad or m: negative while there is a gap.
    pub expression: Expr,
    /// Rotation where φ is an angle.
    pub motion: MotionKind,
}

/// The limits of all stops, in file order, for positions without loads.
pub fn penetrations(model: &Model, kinematics: &Kinematics) -> Vec<Penetration> {
    let pool = &model.pool;
    let mut all = Vec::new();
    for (load_idx, load) in model.loads.iter().enumerate() {
        if let Some(excess) = load.kind.excess() {
            let values = signal_values(model, kinematics);
            all.push(Penetration {
                load: LoadId(load_idx),
                direction: one_sided(&load.kind),
                expression: pool.substitute(excess, &values),
                motion: load.effort(),
            });
            continue;
        }
        let (Some((joint, motion_idx)), Some([min, max])) =
            (load.kind.joint_motion(), load.kind.limits())
        else {
            continue;
        };
        let position = kinematics.joint_positions(model, joint)[motion_idx];
        let motion = model.joints[joint.0].kind.motions()[motion_idx];
        let at = |limit: Expr| {
            let is_used = |s: &&Signal| pool.depends_on(limit, s.symbol);
            let used = model.signals.iter().filter(is_used);
            let mut values: Vec<_> =
                used.map(|s| (s.symbol, kinematics.measure(model, s.measure))).collect();
            let at_start: Vec<Signal> = model.at_start.iter().filter(is_used).copied().collect();
            values.extend(values_at_start(model, kinematics, &at_start));
            pool.substitute(limit, &values)
        };
        let ends = [
            min.map(|min| ("min", pool.sub(at(min), position))),
            max.map(|max| ("max", pool.sub(position, at(max)))),
        ];
        all.extend(ends.into_iter().flatten().map(|(direction, expression)| Penetration {
            load: LoadId(load_idx),
            direction,
            expression,
            motion,
        }));
    }
    all
}

/// The direction of the row of a coupling on one side.
fn one_sided(kind: &LoadKind) -> &'static str {
    match kind.is_back_flank() {
        Some(false) => "forward",
        Some(true) => "back",
        None => "rope",
    }
}

/// A row of a contact before it has a multiplier.
pub(crate) struct ContactRow {
    load: LoadId,
    joint: Option<JointId>,
    position: Expr,
    /// Symbols of ς and p₀ of friction.
    states: Option<[SymbolId; 2]>,
    /// φ of a stop, p₀ − p of friction.
    pub(crate) expression: Expr,
    pub(crate) source: Source,
    pub(crate) direction: &'static str,
    /// Translation where λ is a force.
    pub(crate) effort: MotionKind,
    /// On the joint's two bodies for λ = 1.
    pub(crate) wrenches: Vec<Wrench>,
    /// φ′ or p′, where it is not the derivative of the position.
    rate: Option<Expr>,
    /// How far a stop reaches, where it has ends.
    reach: Option<Expr>,
}

/// The rows of all stops and frictions, in file order; `signals` are the measures as expressions.
pub(crate) fn contact_rows(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
) -> Vec<ContactRow> {
    let pool = &model.pool;
    let mut rows: Vec<ContactRow> = Vec::new();
    for (load_idx, load) in model.loads.iter().enumerate() {
        let load_id = LoadId(load_idx);
        if let Some(excess) = load.kind.excess() {
            let expression = pool.substitute(excess, signals);
            let direction = one_sided(&load.kind);
            let wrenches = match &load.kind {
                LoadKind::Rope { rope, section, .. } => {
                    section_wrenches(model, kinematics, *rope, *section)
                }
                LoadKind::Flank { teeth, is_back, .. } => {
                    flank_wrenches(model, kinematics, teeth, *is_back)
                }
                _ => unreachable!("only these have an excess"),
            };
            rows.push(ContactRow {
                load: load_id,
                joint: None,
                position: expression,
                states: None,
                expression,
                source: Source::Stop(load_id),
                direction,
                effort: load.effort(),
                wrenches,
                rate: None,
                reach: None,
            });
            continue;
        }
        if let LoadKind::Capstan { rope, section, node, slipped, .. } = load.kind {
            let position = pool.substitute(slipped, signals);
            let states = states_of(pool, load_id);
            rows.push(ContactRow {
                load: load_id,
                joint: None,
                position,
                states: Some(states),
                expression: pool.sub(pool.symbol_expr(states[1]), position),
                source: Source::Friction(load_id),
                direction: "friction",
                effort: MotionKind::Translation,
                wrenches: rope::slip_wrenches(model, kinematics, rope, (section, node)),
                rate: None,
                reach: None,
            });
            continue;
        }
        if load.contact().is_some() {
            rows.extend(row_of_contact(model, kinematics, load_id));
            continue;
        }
        let (LoadKind::Stop { joint, motion_idx, .. }
        | LoadKind::Friction { joint, motion_idx, .. }) = load.kind
        else {
            continue;
        };
        // The position of the motion, and the wrenches of a unit effort along and against it.
        let positions = kinematics.joint_positions(model, joint);
        let position = positions[motion_idx];
        let of = &model.joints[joint.0];
        let sides = kinematics.sides(model, of);
        let up = joint::effort(pool, of, motion_idx, &positions, &sides);
        let down = up.reversed(pool);
        let through = |wrench| Wrench::through_joint(model, kinematics, joint, wrench);
        let own = Sliding { position, wrenches: through(&up), kind: of.kind.motions()[motion_idx] };
        let sliding = Sliding::of(model, kinematics, &load.kind).unwrap_or(own);
        let position = sliding.position;
        let mut add = |expression, source, direction, wrenches, states| {
            rows.push(ContactRow {
                load: load_id,
                joint: Some(joint),
                position,
                states,
                expression,
                source,
                direction,
                effort: sliding.kind,
                wrenches,
                rate: None,
                reach: None,
            });
        };

        // A row for each limit of a stop, one for the friction.
        match load.kind {
            LoadKind::Stop { min, max, .. } => {
                let source = Source::Stop(load_id);
                let at = |limit| pool.substitute(limit, signals);
                if let Some(min) = min {
                    let bearing = on_what_it_follows(model, kinematics, min, signals);
                    let wrenches = [through(&up), bearing].concat();
                    add(pool.sub(at(min), position), source, "min", wrenches, None);
                }
                if let Some(max) = max {
                    let bearing = on_what_it_follows(model, kinematics, pool.neg(max), signals);
                    let wrenches = [through(&down), bearing].concat();
                    add(pool.sub(position, at(max)), source, "max", wrenches, None);
                }
            }
            LoadKind::Friction { .. } => {
                let [slip, stuck_at] = states_of(pool, load_id);
                let expression = pool.sub(pool.symbol_expr(stuck_at), position);
                let states = Some([slip, stuck_at]);
                let wrenches = sliding.wrenches.clone();
                add(expression, Source::Friction(load_id), "friction", wrenches, states);
            }
            _ => (),
        }
    }
    rows
}

/// The symbols of ς and p₀ of a friction.
fn states_of(pool: &Pool, LoadId(load): LoadId) -> [SymbolId; 2] {
    let id = |name: String| pool.symbol_id(pool.symbol(&name)).expect("a symbol was just made");
    ["slip", "place"].map(|word| id(format!("'{word}{load}")))
}

/// The row of a place of a contact, or of the friction of some of them; `None` of other loads.
///
/// Bodies that stick hold the rate of their slip at zero: where they touch, the way along an outline is no function of
/// their positions alone.
fn row_of_contact(model: &Model, kinematics: &Kinematics, id: LoadId) -> Option<ContactRow> {
    let pool = &model.pool;
    let (contact, place, coefficient) = match model.loads[id.0].kind {
        LoadKind::Touch { contact, place, .. } => (contact, place, None),
        LoadKind::Rub { contact, track, opposed, sliding, .. } => {
            (contact, model.contacts[contact.0].tracks[track][0], Some((sliding, opposed)))
        }
        _ => return None,
    };
    let touching = Touching::of(model, kinematics, &model.contacts[contact.0].places[place]);
    let common = ContactRow {
        load: id,
        joint: None,
        position: touching.penetration,
        states: None,
        expression: touching.penetration,
        source: Source::Stop(id),
        direction: "touch",
        effort: MotionKind::Translation,
        wrenches: touching.pushing(pool),
        rate: None,
        reach: Some(touching.reach),
    };
    let Some((position, opposed)) = coefficient else { return Some(common) };
    let wrenches = touching.against(pool, opposed);
    Some(ContactRow {
        position,
        states: Some(states_of(pool, id)),
        expression: pool.zero(),
        source: Source::Friction(id),
        direction: match opposed {
            Opposed::Slip => "along",
            Opposed::Across => "across",
            Opposed::Roll => "roll",
        },
        effort: model.loads[id.0].effort(),
        rate: Some(speed_along(model, kinematics, &wrenches)),
        reach: None,
        wrenches,
        ..common
    })
}

/// The wrenches of a unit multiplier on the positions that a limit follows: −∂φ/∂s along every position s, so
/// that a cam bears what its follower takes.
fn on_what_it_follows(
    model: &Model,
    kinematics: &Kinematics,
    penetration: Expr,
    signals: &[(SymbolId, Expr)],
) -> Vec<Wrench> {
    let pool = &model.pool;
    let mut wrenches = Vec::new();
    for signal in model.signals.iter().filter(|s| pool.depends_on(penetration, s.symbol)) {
        let slope = pool.diff(penetration, signal.symbol);
        let effort = pool.neg(short(pool, pool.substitute(slope, signals)));
        let unit = along(model, kinematics, signal.measure);
        wrenches.extend(unit.iter().map(|wrench| wrench.scaled(pool, effort)));
    }
    wrenches
}

/// The contacts of the last of `constraints`, which come from `rows`; `signals` are the measures as expressions.
pub(crate) fn contacts(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
    rows: &[ContactRow],
    constraints: &[Constraint],
) -> Vec<Contact> {
    let pool = &model.pool;
    let first = constraints.len() - rows.len();
    let law_of = |row: usize, ContactRow { load, joint, states, reach, .. }: &ContactRow| {
        let reach = reach.unwrap_or(pool.one());
        if let Some(restitution) = model.loads[load.0].kind.restitution() {
            return Law::Stop { restitution, reach };
        }
        let (law, [slip, stuck_at]) = match (&model.loads[load.0].kind, states) {
            (LoadKind::Friction { law, .. }, Some(states)) => (law, *states),
            (
                &LoadKind::Rub { contact, track, sliding, sticking, opposed },
                Some([slip, stuck_at]),
            ) => {
                let pressing = pressing(model, constraints, (contact, track));
                let is_spatial = model.contacts[contact.0].is_spatial(pool.zero());
                let other = is_spatial.then(|| other_way(row - first, opposed));
                let sizes = match other {
                    None => [sliding, sticking],
                    Some(other) => {
                        let at = row - first;
                        let (one, two) = (at.min(other), at.max(other));
                        let both = [&rows[one], &rows[two]];
                        let began = both.map(|row| {
                            row.states.map_or(pool.zero(), |[slip, _]| pool.symbol_expr(slip))
                        });
                        let rates = both.map(|row| row.rate.unwrap_or(pool.zero()));
                        let way = way_of_slip(pool, began, rates)[at - one];
                        [pool.mul(way, sliding), pool.max(sliding, sticking)]
                    }
                };
                let [sliding, sticking] = sizes.map(|mu| pool.mul(mu, pressing));
                let (slip, stuck_at) = (*slip, *stuck_at);
                return Law::Friction { sliding, sticking, slip, stuck_at, other };
            }
            (LoadKind::Capstan { mu: [sliding, sticking], .. }, Some([slip, stuck_at])) => {
                let own = pool.symbol_expr(constraints[row].lambda);
                let held = pool.call(Function::Sign, &[own]).expect("one argument");
                let size = |mu, slip| rope::friction(model, constraints, *load, (mu, slip));
                let sizes =
                    [size(*sliding, pool.symbol_expr(*slip)), size(*sticking, pool.neg(held))];
                let [sliding, sticking] = sizes.map(|e| pool.substitute(e, signals));
                let (slip, stuck_at) = (*slip, *stuck_at);
                return Law::Friction { sliding, sticking, slip, stuck_at, other: None };
            }
            _ => unreachable!("only stops and friction have rows"),
        };
        let [sliding, sticking] = match *law {
            FrictionLaw::Stated { sliding, sticking } => [sliding, sticking],
            FrictionLaw::Coulomb { sliding, sticking, surface } => {
                // Friction that sticks is against the motion that it keeps from beginning.
                let own = pool.symbol_expr(constraints[row].lambda);
                let held = pool.call(Function::Sign, &[own]).expect("one argument");
                let joint = joint.expect("friction acts in a joint");
                let at = (joint, surface);
                let size = |mu, slip| friction(model, kinematics, constraints, at, (mu, slip));
                [size(sliding, pool.symbol_expr(slip)), size(sticking, pool.neg(held))]
            }
        };
        let [sliding, sticking] = [sliding, sticking].map(|e| pool.substitute(e, signals));
        Law::Friction { sliding, sticking, slip, stuck_at, other: None }
    };
    let contact = |(k, row): (usize, &ContactRow)| {
        let closed = pool.symbol(&format!("'closed{k}"));
        let closed = pool.symbol_id(closed).expect("a symbol was just made");
        let law = law_of(first + k, row);
        let ContactRow { load, joint, position, expression, .. } = *row;
        let moving = if matches!(law, Law::Stop { .. }) { expression } else { position };
        let rate = row.rate.unwrap_or_else(|| kinematics.rate(model, moving));
        Contact { load, joint, position, rate, expression, row: first + k, closed, law }
    };
    rows.iter().enumerate().map(contact).collect()
}

/// The row of friction in the other direction: both follow each other.
fn other_way(row: usize, opposed: Opposed) -> usize {
    if opposed == Opposed::Across { row - 1 } else { row + 1 }
}

/// Wrenches of friction while it slides: −ς F on the successor along the motion, and the opposite on
/// the predecessor.
pub(crate) fn slip_wrenches(
    model: &Model,
    contacts: &[Contact],
    constraints: &[Constraint],
) -> Vec<Wrench> {
    let pool = &model.pool;
    let mut wrenches = Vec::new();
    for contact in contacts {
        let Some(slipping) = contact.law.slipping(pool) else { continue };
        let row = &constraints[contact.row];
        let effort = pool.neg(slipping);
        wrenches.extend(row.wrenches.iter().map(|wrench| wrench.scaled(pool, effort)));
    }
    wrenches
}

/// The contacts whose forces press friction together, by their numbers: none of friction in joints and of stops.
pub fn pressed_by(model: &Model, contacts: &[Contact], friction: &Contact) -> Vec<usize> {
    let Some((contact, track, _)) = model.loads[friction.load.0].kind.rub() else {
        return Vec::new();
    };
    let is_on = |other: &Contact| is_on_track(model, Source::Stop(other.load), (contact, track));
    (0..contacts.len()).filter(|&k| is_on(&contacts[k])).collect()
}
