//! Moments, forces and stresses in the sections of beams, as results.

use bksim_expr::{Expr, Function};

use super::beam_parts::Parts;
use super::flexible::Section;
use super::reader::Reader;
use crate::diagnostic::Span;
use crate::flexible::legendre;
use crate::measure::Measure;
use crate::state::NamedSignal;

impl Reader<'_> {
    /// Puts moments and stresses at the root and at the author's points among the results.
    ///
    /// ```text
    /// M = EI/L Σ q_k P_k−1(ξ)      N = EA/L Σ u_k P_k−1(ξ)      σ = |M| c/I + |M′| c′/I′ + N/A
    /// ```
    ///
    /// M bends the beam towards y, M′ towards z; σ is the largest tension at the edges c and c′ of the section.
    pub(super) fn log_sections(
        &mut self,
        name: &str,
        parts: &Parts,
        section: &Section,
        (points, places): (&[String], &[f64]),
        span: &Span,
    ) {
        let has_root = places.contains(&0.0);
        let root = (!has_root).then_some(("root", 0.0));
        let points = points.iter().map(String::as_str).zip(places.iter().copied());
        for (point, xi) in root.into_iter().chain(points) {
            // M, M′ and N.
            let efforts: [Option<Expr>; 3] = std::array::from_fn(|kind| {
                let shapes = &parts.shapes[kind];
                let pool = &self.pool;
                let per = pool.div(section.stiffness[kind]?, section.length);
                let terms =
                    shapes.iter().zip(legendre(shapes.len(), xi)).map(|(&(id, _), value)| {
                        let word = if kind == 2 { "position" } else { "angle" };
                        let name = format!("{}.{word}", self.names.joints[id.0].name);
                        let own = self.names.signal(pool, &name, Measure::JointPosition(id, 0));
                        pool.mul(pool.float(value), own)
                    });
                let sum = pool.sum(terms.collect::<Vec<_>>());
                (!shapes.is_empty()).then(|| pool.mul(per, sum))
            });
            let pool = &self.pool;
            let mut stress =
                efforts[2].zip(section.moduli[2]).map(|(force, area)| pool.div(force, area));
            let mut is_known = efforts[2].is_none() || stress.is_some();
            for kind in 0..2 {
                let Some(moment) = efforts[kind] else { continue };
                let Some((edge, second)) = section.edges[kind].zip(section.moduli[kind]) else {
                    is_known = false;
                    continue;
                };
                let size = pool.call(Function::Abs, &[moment]).expect("one argument");
                let own = pool.div(pool.mul(size, edge), second);
                stress = Some(stress.map_or(own, |sum| pool.add(sum, own)));
            }
            let rows = [
                ("moment", efforts[0], "N m"),
                ("moment_across", efforts[1], "N m"),
                ("force", efforts[2], "N"),
                ("stress", stress.filter(|_| is_known), "Pa"),
            ];
            for (what, value, unit) in rows {
                let name = format!("{name}_{what}_{point}");
                let Some(value) = value.filter(|_| self.names.plain(&name).is_none()) else {
                    continue;
                };
                let (unit, span) = (unit.to_owned(), span.clone());
                self.belt_signals.push(NamedSignal { name, value, unit, is_output: true, span });
            }
        }
    }
}
