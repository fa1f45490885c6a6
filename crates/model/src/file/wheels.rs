//! Sizes and ratios of two wheels: gears, or those of a belt or chain.

use bksim_expr::Expr;

use super::codes;
use super::reader::{Fields, Reader};
use super::tree::Node;
use super::units::Quantity;
use super::value::{Scalar, Scope};
use crate::coupling::{CouplingKind, Flanks, Wheels, WormSize};
use crate::diagnostic::Diagnostic;
use crate::joint::MotionKind;
use crate::measure::Measure;

impl Reader<'_> {
    /// Two wheels: gears, or those of a belt.
    pub(super) fn read_wheels(
        &mut self,
        word: &str,
        fields: &Fields<'_>,
    ) -> Option<(CouplingKind, Expr, MotionKind)> {
        let is_gear = word == "gear";
        let members = self.two_members(fields);
        let flag = if is_gear { "internal" } else { "crossed" };
        let flagged = fields.get(flag).map(|node| self.flag(node, &fields.what(flag)));
        let sizes = self.wheel_sizes(fields);
        let phase = self.phase(fields, Quantity::ANGLE);
        let (carrier, axes, wheels) = self.wheels(members?, fields)?;
        // Gears turn in opposite senses, wheels of a belt in the same; the flag says otherwise.
        let is_same = flagged.unwrap_or(Some(false))? != (word != "gear");
        let sizes = sizes?;
        let is_same = sizes.is_same.unwrap_or(is_same);
        let ratio = self.signed_ratio(sizes, is_same, fields)?;
        let flanks = self.flanks(fields, sizes.radii.is_some(), [!is_same, is_same])?;
        let (flanks, worm) = self.worm(fields, sizes.radii, flanks)?;
        let phase = phase?;

        // ratio · first + phase − second, times the pitch radius of the second where it is known.
        let turn = |reader: &mut Self, at: usize| {
            let measure = Measure::Turn(wheels[at].body, carrier, axes[at]);
            let body = reader.names.bodies[wheels[at].body.0].name.clone();
            reader.names.signal(&reader.pool, &format!("{body}.turn"), measure)
        };
        let [first, second] = [turn(self, 0), turn(self, 1)];
        let pool = &self.pool;
        let Sizes { radii, teeth, .. } = sizes;
        let radii =
            radii.map(|[first, second]| [if is_same { first } else { pool.neg(first) }, second]);
        let rest = pool.sub(phase, second);
        let (relation, effort) = match radii {
            Some([r_first, r_second]) => {
                let arcs = [pool.mul(r_first, first), pool.mul(r_second, rest)];
                (pool.sum(arcs), MotionKind::Translation)
            }
            None => (pool.add(pool.mul(ratio, first), rest), MotionKind::Rotation),
        };
        let wheels =
            Wheels { axes, wheels, carrier, ratio, radii, teeth, phase, is_same, flanks, worm };
        let kind = if is_gear { CouplingKind::Gear(wheels) } else { CouplingKind::Belt(wheels) };
        Some((kind, relation, effort))
    }

    /// A worm in place of the first wheel, with the directions of its force: with the lead angle γ, tan γ = m z/2 r₁, it is F
    /// along the pitch circle of the wheel, F tan γ along its axis, and F tan α/cos γ from one to the other.
    fn worm(
        &mut self,
        fields: &Fields<'_>,
        radii: Option<[Expr; 2]>,
        flanks: Option<Flanks>,
    ) -> Option<(Option<Flanks>, Option<WormSize>)> {
        let Some(node) = fields.get("worm_radius") else { return Some((flanks, None)) };
        let what = fields.what("worm_radius");
        let radius = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
        if !self.check_positive(&what, &radius, Quantity::LENGTH) {
            return None;
        }
        let help = "write for example `module = \"4 mm\"`, that of the wheel: its pitch diameter over its teeth";
        fields.require(self, "module", help)?;
        let help =
            "write for example `pressure_angle = \"20 deg\"`, in the section across the threads";
        fields.require(self, "pressure_angle", help)?;
        let (Some([travel, _]), Some(Flanks { radial: tangent, .. })) = (radii, flanks) else {
            return None;
        };
        let (pool, radius) = (&self.pool, radius.expr);
        let size = pool.sqrt(pool.add(pool.powi(radius, 2), pool.powi(travel, 2)));
        let over_cosine = pool.div(size, radius);
        // The worm is outside of its wheel, whichever way it turns it.
        let tangent = pool.sqrt(pool.powi(tangent, 2));
        let normal = pool.sqrt(pool.add(pool.one(), pool.powi(tangent, 2)));
        let flanks = Flanks { radial: pool.mul(over_cosine, tangent), axial: pool.zero() };
        let worm = WormSize { radius, normal: pool.mul(over_cosine, normal) };
        Some((Some(flanks), Some(worm)))
    }

    /// The sizes of two wheels, in the form in which they are stated.
    fn wheel_sizes(&mut self, fields: &Fields<'_>) -> Option<Sizes> {
        let forms = [
            ("teeth", "radii"),
            ("teeth", "ratio"),
            ("radii", "ratio"),
            ("radii", "module"),
            ("ratio", "module"),
            ("ratio", "internal"),
            ("worm_radius", "radii"),
            ("worm_radius", "ratio"),
            ("worm_radius", "helix"),
        ];
        if forms.iter().any(|(one, other)| fields.conflict(self, one, other)) {
            return None;
        }
        if let Some(node) = fields.get("ratio") {
            let what = fields.what("ratio");
            let ratio = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
            let value = ratio.value?;
            self.constants.pinned_sign(value);
            if value.look() == 0.0 {
                self.report(
                    Diagnostic::error(codes::BAD_RATIO, format!("{what} is 0"))
                        .at(ratio.span, "must not be 0")
                        .note("the ratio is the rate of the second wheel over that of the first")
                        .help("write for example `ratio = -0.5`, below 0 where they turn in opposite senses"),
                );
                return None;
            }
            let is_same = Some(value.look() > 0.0);
            return Some(Sizes { ratio: Some(ratio.expr), radii: None, teeth: None, is_same });
        }
        if let Some(node) = fields.get("radii") {
            let radii = self.two_sizes(node, "radii", Quantity::LENGTH, fields)?;
            let radii = Some(radii.map(|radius| radius.expr));
            return Some(Sizes { ratio: None, radii, teeth: None, is_same: None });
        }
        let help = "write `teeth = [20, 45]`, `radii = [\"20 mm\", \"45 mm\"]` or `ratio`";
        let node = fields.require(self, "teeth", help)?;
        let teeth = self.two_sizes(node, "teeth", Quantity::NUMBER, fields)?;
        let radii = if fields.has("module") {
            let helix = self.helix(fields)?;
            let radii = self.module_radii(fields, &teeth, helix)?;
            Some([radii[0], radii[1]])
        } else {
            None
        };
        let teeth = Some(teeth.map(|teeth| teeth.expr));
        Some(Sizes { ratio: None, radii, teeth, is_same: None })
    }

    fn two_sizes(
        &mut self,
        node: &Node,
        key: &str,
        quantity: Quantity,
        fields: &Fields<'_>,
    ) -> Option<[Scalar; 2]> {
        let what = fields.what(key);
        let nodes = self.array(node, &what, "an array of two sizes", "[20, 45]")?;
        let [first, second] = nodes else {
            let help = "write the size of the first wheel, then that of the second";
            self.wrong_kind(node, &what, "an array of two sizes", &node.value, help);
            return None;
        };
        let mut size = |node: &Node| {
            let size = self.scalar(node, quantity, &what, Scope::Constant)?;
            let is_positive = self.check_positive(&what, &size, quantity);
            // Books count the teeth of a ring, and its radius, below zero.
            if let (false, Some(fault)) = (is_positive, self.faults.last_mut())
                && let Some(help) = &mut fault.help
            {
                if key == "teeth" && help.contains("for example") {
                    "write for example \"20\"".clone_into(help);
                }
                help.push_str(", and `internal = true` for a ring with its teeth inside");
            }
            is_positive.then_some(size)
        };
        let sizes = [size(first), size(second)];
        let [Some(first), Some(second)] = sizes else { return None };
        Some([first, second])
    }

    /// Pitch radii m z/(2 cos β) of wheels with these teeth.
    pub(super) fn module_radii(
        &mut self,
        fields: &Fields<'_>,
        teeth: &[Scalar],
        helix: Expr,
    ) -> Option<Vec<Expr>> {
        let help = "write for example `module = \"2 mm\"`: pitch diameter over teeth";
        let node = fields.require(self, "module", help)?;
        let what = fields.what("module");
        let module = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
        let is_positive = self.check_positive(&what, &module, Quantity::LENGTH);
        let pool = &self.pool;
        let half = pool.rational(1, 2);
        let radius = |teeth: &Scalar| {
            pool.div(pool.product([half, module.expr, teeth.expr]), pool.cos(helix))
        };
        is_positive.then(|| teeth.iter().map(radius).collect())
    }

    /// The ratio with its sign.
    fn signed_ratio(&mut self, sizes: Sizes, is_same: bool, fields: &Fields<'_>) -> Option<Expr> {
        let pool = &self.pool;
        let size = match sizes {
            Sizes { ratio: Some(ratio), .. } => return Some(ratio),
            Sizes { teeth, radii, .. } => teeth.or(radii)?,
        };
        let ratio = pool.div(size[0], size[1]);
        let ratio = if is_same { ratio } else { pool.neg(ratio) };
        if fields.get("internal").is_some() && is_same && pool.simplify(ratio) == pool.one() {
            let node = fields.get("internal")?;
            self.report(
                Diagnostic::error(
                    codes::BAD_RATIO,
                    format!("{} has an internal gear as large as the other", fields.owner),
                )
                .at(node.span.clone(), "a gear inside of one of its own size")
                .help("give the ring more teeth than the pinion, or remove `internal`"),
            );
            return None;
        }
        Some(ratio)
    }
}

/// The sizes of two wheels.
#[derive(Clone, Copy)]
struct Sizes {
    /// Rate of the second over that of the first, with its sign, where it is stated alone.
    ratio: Option<Expr>,
    /// Pitch radii, m.
    radii: Option<[Expr; 2]>,
    /// Numbers of teeth.
    teeth: Option<[Expr; 2]>,
    /// Whether both turn in one sense, where the ratio says so.
    is_same: Option<bool>,
}
