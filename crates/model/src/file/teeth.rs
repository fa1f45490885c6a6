//! Friction of teeth: the part of their power that their sliding takes.
//!
//! The place where two involute teeth touch moves along the line of action, and they slide at a speed that grows with
//! its distance s from the pitch point, where the sliding reverses: v = s (ω₁ ± ω₂). Teeth that are together in touch
//! share the load. Over one base pitch p_b = π m cos α the mean of the loss is the part μ H of the power:
//!
//! ```text
//! H = π/2 (1/z₁ ± 1/z₂) Σ (ε² + (1 − ε) |1 − ε|)         + of outer teeth, − in a ring, 1/z₂ = 0 of a rack
//! ε = (√((z/2 + 1)² − (z/2 cos α)²) − z/2 sin α)/(π cos α)   way beyond the pitch point, over p_b, to the tip circle
//! ε = (z/2 sin α − √((z/2 − 1)² − (z/2 cos α)²))/(π cos α)   to that of a ring
//! ε = 1/(π sin α cos α)                                      to the tips of a rack
//! ```
//!
//! of teeth with an addendum of one module, and no way beyond the point where the line of action leaves the base circle
//! of the other wheel, z/2 sin α modules from the pitch point. Source: G. Niemann and H. Winter, *Maschinenelemente* II
//! (tooth loss factor H_V, the sum being 2 (1 − ε₁ − ε₂ + ε₁² + ε₂²) where no ε exceeds one); ISO/TR 14179-2. It holds
//! for one or two pairs of teeth in touch, ε₁ + ε₂ in 1 … 2.

use bksim_expr::{Expr, Function, Pool};

use super::codes;
use super::reader::{Fields, Reader};
use super::units::Quantity;
use super::value::Scope;
use crate::coupling::{Coupling, CouplingKind, Rack, Wheels};
use crate::diagnostic::Diagnostic;
use crate::ids::{CouplingId, JointId};
use crate::load::{FrictionLaw, Surface};

/// The mate of the smaller wheel.
#[derive(Clone, Copy)]
enum Mate {
    /// A wheel with this number of teeth outside.
    Wheel(Expr),
    /// A ring with this number of teeth inside.
    Ring(Expr),
    Rack,
}

impl Reader<'_> {
    /// Friction of the teeth of a coupling.
    pub(super) fn read_friction_of_teeth(
        &mut self,
        fields: &Fields<'_>,
        couplings: &[Coupling],
    ) -> Option<(JointId, usize, FrictionLaw)> {
        let others = ["joint", "of", "force", "torque", "length", "radius"];
        if others.iter().any(|other| fields.conflict(self, "coupling", other)) {
            return None;
        }
        let coefficients = self.coefficients(fields);
        let id = self.coupling_with_teeth(fields, couplings)?;
        let worm = match couplings[id.0].kind {
            CouplingKind::Gear(wheels) => wheels.worm,
            _ => None,
        };
        let (joint, mates) = match couplings[id.0].kind {
            CouplingKind::Gear(wheels) => (wheels.axes[0], self.mates(&wheels)),
            CouplingKind::Rack(Rack { joints, teeth, .. }) => {
                (joints[0], teeth.map(|teeth| (teeth, Mate::Rack)))
            }
            _ => return None,
        };
        let loss = match worm {
            // All of the normal force rubs.
            Some(worm) if !fields.has("loss") && !fields.has("pressure_angle") => Some(worm.normal),
            _ => self.loss(fields, mates),
        };
        let ([sliding, sticking], loss) = (coefficients?, loss?);
        let surface = Surface::Teeth { coupling: id, loss };
        let law = FrictionLaw::Coulomb { sliding, sticking, surface };
        Some((joint, 0, law))
    }

    /// The gear or rack that `coupling` names.
    fn coupling_with_teeth(
        &mut self,
        fields: &Fields<'_>,
        couplings: &[Coupling],
    ) -> Option<CouplingId> {
        let node = fields.get("coupling")?;
        let quoted = self.text_of(node, &fields.what("coupling"), "pair")?;
        let has_teeth = |coupling: &&Coupling| {
            matches!(coupling.kind, CouplingKind::Gear(_) | CouplingKind::Rack(_))
        };
        let found = couplings.iter().position(|coupling| coupling.name == quoted.text);
        if let Some(idx) = found.filter(|&idx| has_teeth(&&couplings[idx])) {
            return Some(CouplingId(idx));
        }
        let message =
            format!("{} rubs in `{}`, which is no gear or rack", fields.owner, quoted.text);
        let named = couplings.iter().filter(has_teeth).map(|coupling| coupling.name.clone());
        let help = match named.collect::<Vec<_>>().as_slice() {
            [] => "state the friction of a joint: `joint = \"A\"`".to_owned(),
            names => format!("write one of `{}`", names.join("`, `")),
        };
        let fault = Diagnostic::error(codes::NO_SURFACE, message);
        self.report(fault.at(node.span.clone(), "no teeth here").help(help));
        None
    }

    /// The smaller wheel and what it meshes with.
    fn mates(&self, wheels: &Wheels) -> Option<(Expr, Mate)> {
        let pool = &self.pool;
        let [first, second] = wheels.teeth?;
        let is_outer = pool.is_zero(pool.simplify(pool.add(wheels.ratio, pool.div(first, second))));
        if is_outer {
            return Some((first, Mate::Wheel(second)));
        }
        let of = |function| pool.call(function, &[first, second]).expect("two arguments");
        Some((of(Function::Min), Mate::Ring(of(Function::Max))))
    }

    /// The loss factor as stated, or of these teeth.
    fn loss(&mut self, fields: &Fields<'_>, mates: Option<(Expr, Mate)>) -> Option<Expr> {
        if fields.conflict(self, "loss", "pressure_angle") {
            return None;
        }
        if let Some(node) = fields.get("loss") {
            let what = fields.what("loss");
            let loss = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
            return self.check_positive(&what, &loss, Quantity::NUMBER).then_some(loss.expr);
        }
        let alpha = match fields.get("pressure_angle") {
            Some(node) => {
                let what = fields.what("pressure_angle");
                let alpha = self.scalar(node, Quantity::ANGLE, &what, Scope::Constant)?;
                self.check_positive(&what, &alpha, Quantity::ANGLE).then_some(alpha.expr)?
            }
            None => self.pool.div(self.pool.pi(), self.pool.int(9)),
        };
        let Some((teeth, mate)) = mates else {
            let message =
                format!("{} has `mu`, but the numbers of teeth are not stated", fields.owner);
            self.report(
                Diagnostic::error(codes::NO_SURFACE, message)
                    .at(fields.location(&["coupling"]), "wheels without `teeth`")
                    .note("how far teeth slide follows from their numbers")
                    .help("write `loss = 0.1`: friction takes `mu*loss` of the power"),
            );
            return None;
        };
        Some(loss_factor(&self.pool, teeth, mate, alpha))
    }
}

/// H of the formulas above.
fn loss_factor(pool: &Pool, teeth: Expr, mate: Mate, alpha: Expr) -> Expr {
    let (sin, cos) = (pool.sin(alpha), pool.cos(alpha));
    let pitch = pool.mul(pool.pi(), cos);
    let half = |z: Expr| pool.mul(pool.rational(1, 2), z);
    let of = |function, arguments: &[Expr]| {
        pool.call(function, arguments).expect("as many arguments as it takes")
    };
    // From the pitch point to the tip circle `addendum` modules beyond the pitch circle, and to the base circle.
    let to_tip = |z: Expr, addendum: i64| {
        let tip = pool.add(half(z), pool.int(addendum));
        let square = pool.sub(pool.powi(tip, 2), pool.powi(pool.mul(half(z), cos), 2));
        let root = pool.sqrt(of(Function::Max, &[square, pool.zero()]));
        let way = pool.sub(root, pool.mul(half(z), sin));
        pool.div(if addendum < 0 { pool.neg(way) } else { way }, pitch)
    };
    let to_base = |z: Expr| pool.div(pool.mul(half(z), sin), pitch);
    let shorter = |a: Expr, b: Expr| of(Function::Min, &[a, b]);
    let one = pool.one();
    let (own, other, slide) = match mate {
        Mate::Wheel(z) => (
            shorter(to_tip(teeth, 1), to_base(z)),
            to_tip(z, 1),
            pool.add(pool.div(one, teeth), pool.div(one, z)),
        ),
        Mate::Ring(z) => {
            (to_tip(teeth, 1), to_tip(z, -1), pool.sub(pool.div(one, teeth), pool.div(one, z)))
        }
        Mate::Rack => {
            let way = pool.div(one, pool.mul(pitch, sin));
            (to_tip(teeth, 1), way, pool.div(one, teeth))
        }
    };
    let other = shorter(other, to_base(teeth));
    let signed_square = |part: Expr| {
        let rest = pool.sub(one, part);
        pool.mul(rest, of(Function::Abs, &[rest]))
    };
    let parts = [own, other].map(|part| pool.add(pool.powi(part, 2), signed_square(part)));
    let mean = half(pool.add(parts[0], parts[1]));
    pool.product([pool.pi(), slide, mean])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(pool: &Pool, teeth: i64, mate: Mate) -> f64 {
        let alpha = pool.div(pool.pi(), pool.int(9));
        let loss = loss_factor(pool, pool.int(teeth), mate, alpha);
        pool.evaluate(loss, &|_| None).expect("a number")
    }

    /// The mean of |v| F over one base pitch, pair by pair, in lengths of the base pitch.
    fn mean_loss(slide: f64, [own, other]: [f64; 2]) -> f64 {
        let n = 200_000;
        let mean: f64 = (0..n)
            .map(|k| {
                // The pair that has come into touch last, then those before it.
                let last = -other + (f64::from(k) + 0.5) / f64::from(n);
                let places: Vec<f64> =
                    (0..3).map(|j| last + f64::from(j)).filter(|&s| s < own).collect();
                places.iter().map(|s| s.abs()).sum::<f64>() / places.len() as f64
            })
            .sum::<f64>()
            / f64::from(n);
        // F v = F_n s p_b (ω₁ ± ω₂) and F_n cos α r₁ ω₁ is the power.
        std::f64::consts::TAU * slide * mean
    }

    #[test]
    fn the_loss_factor_is_the_mean_over_a_base_pitch() {
        let pool = Pool::new();
        let (sin, cos) = 20f64.to_radians().sin_cos();
        let pitch = std::f64::consts::PI * cos;
        let tip = |z: f64, add: f64| {
            let way = ((z / 2.0 + add).powi(2) - (z / 2.0 * cos).powi(2)).sqrt() - z / 2.0 * sin;
            (way * add / pitch).abs()
        };
        for (z, w) in [(20, 45), (35, 35), (17, 120)] {
            let (a, b) = (z as f64, w as f64);
            let ways = [tip(a, 1.0), tip(b, 1.0).min(a / 2.0 * sin / pitch)];
            let expected = mean_loss(1.0 / a + 1.0 / b, ways);
            let found = value(&pool, z, Mate::Wheel(pool.int(w)));
            assert!((found - expected).abs() < 1e-6, "{z} on {w}: {found} for {expected}");
            // Whichever comes first.
            let other = value(&pool, w, Mate::Wheel(pool.int(z)));
            assert!((found - other).abs() < 1e-12, "{found} {other}");
        }
        let (a, b) = (20.0, 60.0);
        let ways = [tip(a, 1.0), tip(b, -1.0).min(a / 2.0 * sin / pitch)];
        let found = value(&pool, 20, Mate::Ring(pool.int(60)));
        let expected = mean_loss(1.0 / a - 1.0 / b, ways);
        assert!((found - expected).abs() < 1e-6, "ring: {found} for {expected}");
        let ways = [tip(a, 1.0), (1.0 / (sin * pitch)).min(a / 2.0 * sin / pitch)];
        let (found, expected) = (value(&pool, 20, Mate::Rack), mean_loss(1.0 / a, ways));
        assert!((found - expected).abs() < 1e-6, "rack: {found} for {expected}");
    }
}
