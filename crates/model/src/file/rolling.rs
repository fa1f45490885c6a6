//! Joints of two curves in touch, wheels and balls on a plane, and the curves on which something rolls or rubs.

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

/// Shapes that roll on a plane, and whether each is a ball.
const SHAPES: [(&str, bool); 2] = [("disc", false), ("ball", true)];

impl Reader<'_> {
    /// A joint of type `curve-on-curve`.
    pub(super) fn curves_in_touch(&mut self, fields: &Fields<'_>) -> Option<JointKind> {
        let curves = ["curve", "second_curve"].map(|key| self.curve_of(fields, key));
        let lifts = self.lifts(fields);
        let is_stated = fields.has("tangents");
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
        Some(JointKind::CurveOnCurve {
            curves: [first, second],
            is_same_way: is_same_way?,
            is_stated,
            arcs,
            lifts: lifts?,
        })
    }

    /// A joint of type `rolling`: a disc, whose rim may be round, or a ball.
    pub(super) fn rolling_shape(&mut self, fields: &Fields<'_>) -> Option<JointKind> {
        let help = "write `shape = \"disc\"` of a wheel about its `axis`, or `shape = \"ball\"`";
        let shape = fields.require(self, "shape", help);
        let radius = fields.require(self, "radius", "write for example `radius = \"300 mm\"`");
        let (shape, radius) = (shape?, radius?);
        let is_ball = self.choice(shape, &fields.what("shape"), &SHAPES)?;
        let what = fields.what("radius");
        let radius = self.scalar(radius, Quantity::LENGTH, &what, Scope::Constant)?;
        if !self.check_positive(&what, &radius, Quantity::LENGTH) {
            return None;
        }
        let zero = self.pool.zero();
        if is_ball {
            for key in ["axis", "rim"] {
                if let Some(node) = fields.get(key) {
                    let message = format!("{} is a ball and has `{key}`", fields.owner);
                    self.report(
                        Diagnostic::error(codes::KEY_CONFLICT, message)
                            .at(node.span.clone(), "of discs only")
                            .help(format!("remove `{key}`, or write `shape = \"disc\"`")),
                    );
                    return None;
                }
            }
            return Some(JointKind::Rolling { circle: zero, rim: radius.expr });
        }
        let Some(node) = fields.get("rim") else {
            return Some(JointKind::Rolling { circle: radius.expr, rim: zero });
        };
        let what = fields.what("rim");
        let rim = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
        if !self.check_positive(&what, &rim, Quantity::LENGTH) {
            return None;
        }
        if let (Some(all), Some(own)) = (radius.value, rim.value)
            && !self.constants.is_above(all, own)
        {
            let message = format!("{what} is not smaller than `radius`");
            self.report(
                Diagnostic::error(codes::NO_ROLLING, message)
                    .at(rim.span.clone(), "the radius of the rim across the disc")
                    .at(radius.span.clone(), "the radius of the disc, rim included")
                    .help("write a smaller `rim`, or `shape = \"ball\"` without one"),
            );
            return None;
        }
        let circle = self.pool.sub(radius.expr, rim.expr);
        Some(JointKind::Rolling { circle, rim: rim.expr })
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
