//! The meaning of a name in an expression, and what to say of a name without one.

use bksim_expr::Expr;

use super::codes;
use super::lower::Context;
use super::names::Meaning;
use super::reader::Reader;
use super::replay::Constant;
use super::units::{Quantity, find_unit};
use super::value::Scope;
use super::value::{Kind, Lowered, PURE};
use super::words::cut;
use super::written_unit::WrittenUnit;
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::JointId;
use crate::joint::motion_words;
use crate::measure::{Frame, Measure, Resultant};
use crate::measure_names::{
    BODY_WORDS, CONTACT_WORDS, CONTACTS, COUPLINGS, DRIVES, LINE_WORDS, LOADS, N_POINT_WORDS,
    REACTIONS, reaction_words,
};

impl Reader<'_> {
    /// A parameter, the time, or something of the motion.
    pub(super) fn named(
        &mut self,
        name: &str,
        range: &Span,
        context: &Context<'_>,
    ) -> Option<Lowered> {
        let span = context.quoted.span_of(range);
        // Constants, parameters and the time.
        if name == "pi" {
            let value = Some(Constant::written(std::f64::consts::PI));
            return Some(Lowered::new(self.pool.pi(), PURE, value, span));
        }
        if let Some((local, symbol)) = &self.local
            && local == name
        {
            return Some(Lowered::new(*symbol, PURE, None, span));
        }
        let parts: Vec<&str> = name.split('.').collect();
        let (measure, quantity) = match (parts.as_slice(), self.names.plain(name)) {
            // A name with dots is one that a value of the file was given as a parameter.
            (_, Some(Meaning::Parameter(idx))) => {
                let known = self.parameters[idx].result.clone()?;
                return Some(Lowered { span, ..known });
            }
            ([_], Some(Meaning::Time)) => {
                if matches!(context.scope, Scope::Constant | Scope::Position) {
                    self.not_constant(name, span, context);
                    return None;
                }
                let kind = Kind::Known(Quantity::TIME.dimension());
                return Some(Lowered::new(self.pool.symbol("t"), kind, None, span));
            }
            ([_], Some(Meaning::Value(idx))) => {
                let Some(known) = self.value_of(idx) else {
                    // Constants and motions of drives are read before all of these; elsewhere one that could not be read
                    // was reported there.
                    let waits = self.waiting.contains(&idx) && context.scope != Scope::Output;
                    if matches!(context.scope, Scope::Constant | Scope::Time) || waits {
                        self.not_constant(name, span, context);
                    }
                    return None;
                };
                let is_refused = match context.scope {
                    Scope::Constant => known.value.is_none(),
                    Scope::Position => !self.follows_positions(known.expr),
                    Scope::Time => self.moves(known.expr),
                    Scope::Motion | Scope::Tick => {
                        self.presses(known.expr) || self.accelerates(known.expr)
                    }
                    Scope::Load => self.accelerates(known.expr),
                    Scope::Output => false,
                };
                if is_refused {
                    self.not_constant(name, span, context);
                    return None;
                }
                return Some(Lowered { span, ..known });
            }
            ([_], Some(Meaning::Faulty)) => return None,
            ([_], Some(Meaning::Measure(_))) => self.names.coordinate(name)?,
            ([_], None) if let Some(known) = self.result_named(name, context.scope) => {
                return Some(Lowered { span, ..known });
            }
            ([owner, rest @ ..], _) => {
                let accelerations = || self.names.acceleration(owner, rest);
                let is_result = context.scope == Scope::Output;
                let found = self.names.measure(owner, rest);
                let found = found.or_else(|| is_result.then(accelerations)?);
                if found.is_none() {
                    self.unknown_name(&parts, range, context);
                }
                found?
            }
            _ => return None,
        };
        // Everything else is of the motion: a signal stands for it.
        let is_refused = match context.scope {
            Scope::Constant | Scope::Time => true,
            Scope::Position => measure.is_velocity(),
            Scope::Motion | Scope::Tick => measure.is_reaction(),
            Scope::Load | Scope::Output => false,
        };
        if is_refused {
            self.not_constant(name, span, context);
            return None;
        }
        let expr = match measure {
            Measure::Resultant(joint, whole) => self.resultant(name, joint, whole),
            _ => self.names.signal(&self.pool, name, measure),
        };
        let kind = Kind::Known(quantity.dimension());
        Some(Lowered { is_angle: quantity.is_angle(), ..Lowered::new(expr, kind, None, span) })
    }

    /// A signal that a coupling or a beam adds to the results, which outputs may use.
    fn result_named(&self, name: &str, scope: Scope) -> Option<Lowered> {
        let signal = self.belt_signals.iter().find(|signal| signal.name == name);
        let signal = signal.filter(|_| scope == Scope::Output)?;
        let unit = WrittenUnit::parse(&signal.unit);
        let (kind, is_angle) =
            unit.map_or((PURE, false), |unit| (Kind::Known(unit.dimension), unit.is_angle));
        Some(Lowered { is_angle, ..Lowered::new(signal.value, kind, None, signal.span.clone()) })
    }

    /// The size of a reaction, of the signals of its components; `name` is `reactions.A.force`.
    fn resultant(&mut self, name: &str, joint: JointId, whole: Resultant) -> Expr {
        let owner = name.rsplit_once('.').map_or(name, |(owner, _)| owner);
        let words: Vec<String> = reaction_words().collect();
        let squares = whole.components().map(|k| {
            let component = Measure::Reaction(joint, Frame::World, k);
            let written = format!("{owner}.{}", words[k]);
            self.pool.powi(self.names.signal(&self.pool, &written, component), 2)
        });
        let squares: Vec<Expr> = squares.collect();
        self.pool.sqrt(self.pool.sum(squares))
    }

    fn not_constant(&mut self, name: &str, span: Span, context: &Context<'_>) {
        let (rule, help) = match context.scope {
            Scope::Constant => {
                ("must not change during the motion", "use numbers and parameters only")
            }
            Scope::Position => (
                "must follow from positions",
                "use numbers, parameters, positions such as `A.angle`, and signals that are latched or sampled",
            ),
            Scope::Motion | Scope::Tick => (
                "must follow from positions, velocities and the time",
                "use reactions in loads, in `rate` of states and in signals without a clock",
            ),
            _ => ("is prescribed", "use numbers, parameters and the time `t` only"),
        };
        let message = format!("{} {rule}, but uses `{}`", context.what, cut(name));
        self.report(
            Diagnostic::error(codes::NOT_CONSTANT, message)
                .at(span, "changes with the motion")
                .help(help),
        );
    }

    /// A name without meaning: says which part of it is at fault.
    fn unknown_name(&mut self, parts: &[&str], range: &Span, context: &Context<'_>) {
        // The part at fault, and the names that could stand there.
        let owner = parts[0];
        let joint = self.names.joint(owner).map(|joint| self.names.joints[joint.0].freedoms);
        if joint == Some(None) {
            return;
        }
        let body = self.names.body(owner);
        let is_result = context.scope == Scope::Output;
        let (part, candidates) = if parts.len() == 1 && body.is_none() && joint.is_none() {
            let mut names = self.owned_names(|names| names.plain_names());
            names.push("pi".to_owned());
            names.extend(self.local.iter().map(|(name, _)| name.clone()));
            (0, names)
        } else if let Some(Some(freedoms)) = joint {
            let words = (0..freedoms.len()).flat_map(|idx| {
                let [value, rate, _] = motion_words(freedoms, idx);
                [value, rate]
            });
            (1, words.map(str::to_owned).collect())
        } else if let (None, REACTIONS, [_, joint, ..]) = (body, owner, parts) {
            match self.names.joint(joint) {
                Some(_) => (2, reaction_words().collect()),
                None => (1, self.names.joint_names().into_iter().map(str::to_owned).collect()),
            }
        } else if let (None, DRIVES, [_, _], true) = (body, owner, parts, is_result) {
            (1, self.names.drives.iter().map(|(name, _)| name.clone()).collect())
        } else if let (None, COUPLINGS, [_, _], true) = (body, owner, parts, is_result) {
            (1, self.names.forces.iter().map(|(name, _)| name.clone()).collect())
        } else if let (None, CONTACTS, [_, contact, ..], true) = (body, owner, parts, is_result) {
            if self.names.contacts.iter().any(|known| known == contact) {
                (2, CONTACT_WORDS.map(|(word, _)| word.to_owned()).to_vec())
            } else {
                (1, self.names.contacts.clone())
            }
        } else if let (None, LOADS, [_, load, ..], true) = (body, owner, parts, is_result) {
            if self.names.lines.iter().any(|known| known == load) {
                (2, LINE_WORDS.map(|(word, _)| word.to_owned()).to_vec())
            } else {
                (1, self.names.lines.clone())
            }
        } else if let Some(body) = body {
            let points = self.names.bodies[body.0].points.clone();
            let words = BODY_WORDS.map(|(word, _)| word.to_owned());
            match parts {
                [_, point, ..] if points.iter().any(|known| known == point) => {
                    (2, words[..N_POINT_WORDS].to_vec())
                }
                [_, _, _, ..] => (1, points),
                _ => (1, [words.to_vec(), points].concat()),
            }
        } else {
            let mut names = self.owned_names(|names| names.joint_names());
            names.extend(self.owned_names(|names| names.body_names()));
            (0, names)
        };
        // A name that is too short needs a further part.
        let candidates: Vec<&str> = candidates.iter().map(String::as_str).collect();
        let name = parts.join(".");
        let message = format!("undefined `{}` in {}", cut(&name), context.what);
        let Some(word) = parts.get(part) else {
            let location = context.quoted.span_of(range);
            let help = format!("write for example `{name}.{}`", candidates.first().unwrap_or(&"x"));
            let label = "needs a point or a measure after it";
            self.report(
                Diagnostic::error(codes::UNKNOWN_NAME, message).at(location, label).help(help),
            );
            return;
        };
        // A unit without a number, or a name that nothing has.
        let start = range.start + parts[..part].iter().map(|p| p.len() + 1).sum::<usize>();
        let location = context.quoted.span_of(&(start..start + word.len()));
        if part == 0 && find_unit(word).is_some() {
            // The letter of gravity.
            let is_gravity = context.what.contains("`acceleration`")
                && context.quoted.text.trim_start_matches(['-', '+', ' ']).trim_end() == "g";
            let help = if is_gravity {
                "write \"-9.81 m/s^2\", or define a parameter `g`".to_owned()
            } else {
                format!(
                    "add `{word} = …` to `[parameters]` if it is meant as a quantity; as a unit it \
                     follows a number, `1 {word}`, or a unit and a space, `1 kg {word}`"
                )
            };
            self.report(
                Diagnostic::error(codes::UNKNOWN_NAME, message)
                    .at(location, "no such name")
                    .help(help),
            );
            return;
        }
        let label = (location, "no such name");
        let foreign = if parts.len() == 1 { self.foreign_name(word, context.scope) } else { None };
        if let Some(help) = foreign {
            self.report(
                Diagnostic::error(codes::UNKNOWN_NAME, message).at(label.0, label.1).help(help),
            );
            return;
        }
        self.unknown(codes::UNKNOWN_NAME, message, label, (word, &candidates));
    }
}
