//! Directions of tooth forces and play between teeth.
//!
//! ```text
//! radial   F_r = F_t tan α/cos β         α, β in the normal section: of the tool that cuts the teeth
//! axial    F_a = F_t tan β               β above zero where the teeth of the first are right-handed
//! play     −b ≤ s ≤ 0                    s by which the first leads the second, b the backlash
//! ```
//!
//! F_r parts the wheels, or presses a pinion away from the teeth of its ring, whichever flank bears. Source: G. Niemann
//! and H. Winter, *Maschinenelemente* II (tooth forces of spur and helical gears).

use bksim_expr::{Expr, Function};

use super::codes;
use super::reader::{Fields, Reader};
use super::units::Quantity;
use super::value::Scope;
use crate::coupling::{Coupling, CouplingKind, Flanks, Wheels};
use crate::diagnostic::{Diagnostic, Span};
use crate::joint::MotionKind;
use crate::load::{Load, LoadKind};
use crate::measure::Measure;
use crate::state::NamedSignal;

/// Keys of the directions of tooth forces and of play.
pub(super) const FLANK_KEYS: [&str; 6] =
    ["pressure_angle", "helix", "backlash", "restitution", "stiffness", "damping"];

/// A right angle, rad.
const RIGHT: f64 = std::f64::consts::FRAC_PI_2;

impl Reader<'_> {
    /// The directions of the tooth force of a gear or a rack, `Some(None)` where they are not stated; `is_parting` where
    /// the second is pushed along the line from the first, `is_axial_back` where it is pushed against the axis by a
    /// positive force of the coupling and a right-handed first.
    #[expect(clippy::option_option, reason = "at fault, not stated, or stated")]
    pub(super) fn flanks(
        &mut self,
        fields: &Fields<'_>,
        has_radii: bool,
        [is_parting, is_axial_back]: [bool; 2],
    ) -> Option<Option<Flanks>> {
        let helix = self.helix(fields)?;
        if fields.has("helix") {
            let help = "write for example `pressure_angle = \"20 deg\"`, that of the tool";
            fields.require(self, "pressure_angle", help)?;
        }
        let Some(node) = fields.get("pressure_angle") else { return Some(None) };
        let what = fields.what("pressure_angle");
        let alpha = self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?;
        if !self.check_positive(&what, &alpha, Quantity::ANGLE) {
            return None;
        }
        if alpha.value.is_some_and(|value| value.look() >= RIGHT) {
            return self.bad_angle(&what, alpha.span, "must be below 90 deg", "20 deg");
        }
        if !has_radii {
            let message = format!("{} has a `pressure_angle`, but no pitch radii", fields.owner);
            self.report(
                Diagnostic::error(codes::NO_PITCH_RADII, message)
                    .at(node.span.clone(), "of teeth whose place is not known")
                    .help("write `teeth` and `module`, or `radii`, in place of `ratio`"),
            );
            return None;
        }
        let pool = &self.pool;
        let tangent = |angle: Expr| pool.div(pool.sin(angle), pool.cos(angle));
        let radial = pool.div(tangent(alpha.expr), pool.cos(helix));
        let axial = tangent(helix);
        let signed = |part: Expr, is_plus: bool| if is_plus { part } else { pool.neg(part) };
        Some(Some(Flanks {
            radial: signed(radial, is_parting),
            axial: signed(axial, !is_axial_back),
        }))
    }

    /// The helix angle of the first wheel, or of the pinion, zero where it is not stated.
    pub(super) fn helix(&mut self, fields: &Fields<'_>) -> Option<Expr> {
        let Some(node) = fields.get("helix") else { return Some(self.pool.zero()) };
        let what = fields.what("helix");
        let helix = self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?;
        if helix.value.is_some_and(|value| value.look().abs() >= RIGHT) {
            return self.bad_angle(
                &what,
                helix.span,
                "must be within -90 deg and 90 deg",
                "15 deg",
            );
        }
        Some(helix.expr)
    }

    fn bad_angle<T>(&mut self, what: &str, span: Span, label: &str, example: &str) -> Option<T> {
        let fault = Diagnostic::error(codes::TOOTH_ANGLE, format!("{what} is no angle of teeth"));
        self.report(fault.at(span, label).help(format!("write for example \"{example}\"")));
        None
    }

    /// Two sides of teeth with play in place of a coupling.
    pub(super) fn read_play(&mut self, fields: &Fields<'_>, teeth: &Coupling) -> Option<()> {
        let arc = self.play_of_teeth(fields, teeth)?;
        let restitution = match fields.get("restitution") {
            Some(node) => self.restitution(node, &fields.what("restitution"))?,
            None => self.pool.zero(),
        };
        let lead = self.lead_of_teeth(teeth);
        let pool = &self.pool;
        let sides = [("forward", false, lead), ("back", true, pool.neg(pool.add(lead, arc)))];
        for (side, is_back, excess) in sides {
            let kind =
                LoadKind::Flank { teeth: Box::new(teeth.clone()), is_back, excess, restitution };
            let name = format!("{}_{side}", teeth.name);
            self.rope_loads.push(Load { name, kind, span: teeth.span.clone() });
        }
        let unit = if teeth.effort == MotionKind::Rotation { "rad" } else { "m" };
        self.log(format!("{}_lead", teeth.name), lead, unit, &teeth.span.clone());
        Some(())
    }

    /// The way by which the first leads the second, along the pitch circles or as an angle of the second.
    fn lead_of_teeth(&self, teeth: &Coupling) -> Expr {
        if teeth.kind.is_reversed() { self.pool.neg(teeth.relation) } else { teeth.relation }
    }

    /// The play between teeth, in the measure of their lead.
    fn play_of_teeth(&mut self, fields: &Fields<'_>, teeth: &Coupling) -> Option<Expr> {
        let slope = self.slope(teeth.kind)?;
        let node = fields.get("backlash")?;
        let what = fields.what("backlash");
        Some(match teeth.effort {
            MotionKind::Translation => {
                let kinds = [
                    (Quantity::ANGLE, MotionKind::Rotation),
                    (Quantity::LENGTH, MotionKind::Translation),
                ];
                let (play, kind) = self.one_of(node, &what, kinds)?;
                let quantity =
                    if kind == MotionKind::Rotation { Quantity::ANGLE } else { Quantity::LENGTH };
                self.check_positive(&what, &play, quantity).then_some(())?;
                if kind == MotionKind::Rotation {
                    self.pool.mul(play.expr, slope)
                } else {
                    play.expr
                }
            }
            MotionKind::Rotation => {
                let play = self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?;
                self.check_positive(&what, &play, Quantity::ANGLE).then_some(())?;
                self.pool.mul(play.expr, slope)
            }
        })
    }

    /// Teeth that give in place of a coupling.
    ///
    /// ```text
    /// F = (k s + c s′) cos² α cos² β                 along the pitch circles, k and c along the line of action
    /// F = max(0, …) where s > 0, − max(0, …) where s < −b, else 0      with play b
    /// ```
    pub(super) fn read_elastic_teeth(
        &mut self,
        fields: &Fields<'_>,
        teeth: &Coupling,
    ) -> Option<()> {
        if fields.conflict(self, "stiffness", "restitution") {
            return None;
        }
        let node = fields.get("stiffness")?;
        if teeth.effort == MotionKind::Rotation {
            let message = format!("{} has a `stiffness`, but no pitch radii", fields.owner);
            self.report(
                Diagnostic::error(codes::NO_PITCH_RADII, message)
                    .at(node.span.clone(), "of teeth whose place is not known")
                    .help("write `teeth` and `module`, or `radii`, in place of `ratio`"),
            );
            return None;
        }
        let mut size = |key: &str, quantity: Quantity| match fields.get(key) {
            Some(node) => {
                let what = fields.what(key);
                let scalar = self.scalar(node, quantity, &what, Scope::Constant)?;
                self.check_positive(&what, &scalar, quantity).then_some(scalar.expr)
            }
            None => Some(self.pool.zero()),
        };
        let (stiffness, damping) =
            (size("stiffness", Quantity::STIFFNESS), size("damping", Quantity::DAMPING));
        let (stiffness, damping) = (stiffness?, damping?);
        let arc = match fields.get("backlash") {
            Some(_) => Some(self.play_of_teeth(fields, teeth)?),
            None => None,
        };
        let lead = self.lead_of_teeth(teeth);
        if fields.has("damping") && !self.has_rate(lead) {
            let message = format!("{} has a `damping`, but no rate of its lead", fields.owner);
            self.report(
                Diagnostic::error(codes::KEY_CONFLICT, message)
                    .at(fields.location(&["damping"]), "of a wheel in space that no joint holds to the carrier")
                    .help("remove `damping`, or name in `between` the joints between wheels and carrier"),
            );
            return None;
        }
        let rate = self.rate_of(lead);
        let pool = &self.pool;
        // The square of the normal force over that along the pitch circles.
        let square = |e: Expr| pool.powi(e, 2);
        let normal = match teeth.kind {
            CouplingKind::Gear(Wheels { worm: Some(worm), .. }) => square(worm.normal),
            kind => kind.flanks().map_or(pool.one(), |Flanks { radial, axial }| {
                pool.sum([pool.one(), square(radial), square(axial)])
            }),
        };
        let pressed = |lead: Expr, rate: Expr| {
            let whole = pool.add(pool.mul(stiffness, lead), pool.mul(damping, rate));
            pool.div(whole, normal)
        };
        let of = |function, a: Expr, b: Expr| pool.call(function, &[a, b]).expect("two arguments");
        let push = |lead: Expr, rate: Expr| {
            let is_met = of(Function::Gt, lead, pool.zero());
            pool.select(is_met, of(Function::Max, pool.zero(), pressed(lead, rate)), pool.zero())
        };
        let force = match arc {
            Some(arc) => {
                let back = push(pool.neg(pool.add(lead, arc)), pool.neg(rate));
                pool.sub(push(lead, rate), back)
            }
            None => pressed(lead, rate),
        };
        let kind = LoadKind::Mesh { teeth: Box::new(teeth.clone()), force };
        let span = teeth.span.clone();
        self.rope_loads.push(Load {
            name: format!("{}_mesh", teeth.name),
            kind,
            span: span.clone(),
        });
        self.log(format!("{}_lead", teeth.name), lead, "m", &span);
        self.log(format!("{}_force", teeth.name), force, "N", &span);
        self.log_across(teeth, (force, None), &span);
        Some(())
    }

    /// Change of the relation of a gear or rack by a positive motion of the first, without its sign.
    fn slope(&self, kind: CouplingKind) -> Option<Expr> {
        let (slope, is_reversed) = match kind {
            CouplingKind::Gear(wheels) => {
                (wheels.radii.map_or(wheels.ratio, |[first, _]| first), !wheels.is_same)
            }
            CouplingKind::Rack(rack) => (rack.radius, rack.is_reversed),
            _ => return None,
        };
        Some(if is_reversed { self.pool.neg(slope) } else { slope })
    }

    /// Puts the parts of a tooth force across the pitch circles among the results.
    pub(super) fn log_flanks(&mut self, teeth: &Coupling, has_play: bool) {
        if teeth.kind.flanks().is_none() {
            return;
        }
        let force = |reader: &mut Self, name: &str| {
            let idx = reader.names.forces.iter().position(|(known, _)| known == name)?;
            Some(reader.names.signal(
                &reader.pool,
                &format!("couplings.{name}"),
                Measure::Force(idx),
            ))
        };
        let own = force(self, &teeth.name);
        let sides = ["forward", "back"].map(|side| force(self, &format!("{}_{side}", teeth.name)));
        let Some(own) = own else { return };
        let pressed = match sides {
            [Some(forward), Some(back)] if has_play => Some(self.pool.add(forward, back)),
            _ => None,
        };
        self.log_across(teeth, (own, pressed), &teeth.span.clone());
    }

    /// Puts the parts across the pitch circles of a force along them among the results; `pressed` is its size, where that is
    /// not its own.
    fn log_across(&mut self, teeth: &Coupling, (own, pressed): (Expr, Option<Expr>), span: &Span) {
        let Some(Flanks { radial, axial }) = teeth.kind.flanks() else { return };
        let pool = &self.pool;
        let size = |e: Expr| pool.call(Function::Abs, &[e]).expect("one argument");
        let pressed = pressed.unwrap_or_else(|| size(own));
        let parts = [("radial", pool.mul(pressed, size(radial))), ("axial", pool.mul(own, axial))];
        for (part, value) in parts {
            let name = format!("{}_{part}", teeth.name);
            if pool.is_zero(value) || self.names.plain(&name).is_some() {
                continue;
            }
            let (unit, span) = ("N".to_owned(), span.clone());
            self.belt_signals.push(NamedSignal { name, value, unit, is_output: true, span });
        }
    }
}
