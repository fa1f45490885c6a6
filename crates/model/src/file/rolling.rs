//! Joints of two curves in touch, and the curves on which something rolls or rubs.

use bksim_expr::Expr;

use super::codes;
use super::reader::{Fields, Reader};
use super::units::Quantity;
use super::value::Scope;
use crate::diagnostic::Diagnostic;
use crate::ids::CurveId;
use crate::joint::JointKind;

/// How the tangents of two curves point where they touch.
const TANGENTS: [(&str, bool); 2] = [("opposite", false), ("same", true)];

impl Reader<'_> {
    /// A joint of type `curve-on-curve`.
    pub(super) fn curves_in_touch(&mut self, fields: &Fields<'_>) -> Option<JointKind> {
        let curves = ["curve", "second_curve"].map(|key| self.curve_of(fields, key));
        let is_same_way = match fields.get("tangents") {
            Some(node) => self.choice(node, &fields.what("tangents"), &TANGENTS),
            None => Some(false),
        };
        let together = fields.has("rolling").then(|| self.points_together(fields));
        let [first, second] = [curves[0]?, curves[1]?];
        let arcs = match together {
            Some(together) => Some(self.arcs(fields, [first, second], together?)?),
            None => None,
        };
        Some(JointKind::CurveOnCurve { curves: [first, second], is_same_way: is_same_way?, arcs })
    }

    /// The parameters of two points that come together.
    fn points_together(&mut self, fields: &Fields<'_>) -> Option<[Expr; 2]> {
        const EXAMPLE: &str = "[0, \"pi\"]";
        let node = fields.get("rolling")?;
        let what = fields.what("rolling");
        let kind = "an array of two parameters";
        let nodes = self.array(node, &what, kind, EXAMPLE)?;
        let [first, second] = nodes else {
            let help = "write the parameters of two points that come together, such as [0, \"pi\"]";
            self.wrong_kind(node, &what, kind, &node.value, help);
            return None;
        };
        let [first, second] =
            [first, second].map(|n| self.scalar(n, Quantity::ANGLE, &what, Scope::Constant));
        Some([first?.expr, second?.expr])
    }

    /// The lengths of both curves from the points that come together.
    fn arcs(
        &mut self,
        fields: &Fields<'_>,
        curves: [CurveId; 2],
        together: [Expr; 2],
    ) -> Option<[Expr; 2]> {
        let mut arcs = [self.pool.zero(); 2];
        for (place, id) in curves.into_iter().enumerate() {
            let from = together[place];
            let Some(length) = self.arc(id, from) else {
                let help =
                    "write the whole period in `range`, or remove `rolling`: the curves then slide";
                self.without_length(fields, id, ("rolls", "rolling", "without slip"), help);
                return None;
            };
            arcs[place] = length;
        }
        Some(arcs)
    }

    /// The length along a curve from the parameter zero, on which the owner of `fields` rubs.
    pub(super) fn length_along(&mut self, fields: &Fields<'_>, id: CurveId) -> Option<Expr> {
        let length = self.arc(id, self.pool.zero());
        if length.is_none() {
            let help = "write the whole period in `range`, or remove the friction";
            self.without_length(fields, id, ("rubs", "mu", "slides along it"), help);
        }
        length
    }

    /// The fault of a curve whose length has no formula.
    fn without_length(
        &mut self,
        fields: &Fields<'_>,
        id: CurveId,
        (what, key, label): (&str, &str, &str),
        help: &str,
    ) {
        let Some(curve) = self.curve(id) else { return };
        let (name, owner) = (&curve.name, &fields.owner);
        let message =
            format!("the length along curve `{name}`, on which {owner} {what}, is not known");
        let note = "lengths are known of lines, circles, curves through points, profiles of cams, and formulas that are smooth and closed over their `range`; curves with cusps, and those of more than 512 pieces, have none";
        self.report(
            Diagnostic::error(codes::NO_CURVE, message)
                .at(fields.location(&[key]), label)
                .note(note)
                .help(help),
        );
    }
}
