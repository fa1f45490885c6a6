//! Outlines, and the mass properties of a uniform plate cut along them.
//!
//! With corners (x_i, y_i), c_i = x_i y_{i+1} − x_{i+1} y_i and counter-clockwise order:
//!
//! ```text
//! A   = ½ Σ c_i
//! A x = ⅙ Σ (x_i + x_{i+1}) c_i
//! J   = 1/12 Σ (x_i² + x_i x_{i+1} + x_{i+1}² + y_i² + y_i y_{i+1} + y_{i+1}²) c_i
//! ∫xy = 1/24 Σ (x_i y_{i+1} + 2 x_i y_i + 2 x_{i+1} y_{i+1} + x_{i+1} y_i) c_i
//! ```
//!
//! J is the polar moment of area about the origin of the body frame; its parts with x and with y
//! are ∫x² and ∫y². Source: Green's theorem;
//! for example Steger, "On the calculation of arbitrary moments of polygons" (1996).

use bksim_expr::Expr;

use super::bodies::{BodyFacts, Position, VectorValue};
use super::codes;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::body::Body;
use crate::diagnostic::Diagnostic;

/// Closed polygons.
pub(super) type Outline = Vec<Vec<[Expr; 2]>>;

/// Area and its first and second moments about the origin of the frame.
pub(super) struct AreaMoments {
    pub(super) area: Expr,
    pub(super) first: [Expr; 2],
    polar: Expr,
    /// ∫x², ∫y², ∫xy.
    pub(super) second: [Expr; 3],
}

impl Reader<'_> {
    /// One polygon, or several that do not overlap.
    pub(super) fn read_outline(
        &mut self,
        fields: &Fields<'_>,
        facts: &mut BodyFacts,
    ) -> Option<Outline> {
        let node = fields.get("outline")?;
        let what = fields.what("outline");
        let example = "[[0, 0], [1, 0], [0, 1]]";
        let values = self.array(node, &what, "an array of corners", example)?;
        let polygons: Vec<&Node> = match values.first().map(|first| &first.value) {
            Some(Value::Array(corner))
                if corner.iter().all(|v| matches!(v.value, Value::Array(_))) =>
            {
                values.iter().collect()
            }
            _ => vec![node],
        };
        let mut outline = Vec::new();
        for polygon in polygons {
            outline.push(self.read_polygon(polygon, &what, facts)?);
        }
        Some(outline)
    }

    /// The corners of one polygon, counter-clockwise.
    pub(super) fn read_polygon(
        &mut self,
        node: &Node,
        what: &str,
        facts: &mut BodyFacts,
    ) -> Option<Vec<[Expr; 2]>> {
        let example = "[[0, 0], [1, 0], [0, 1]]";
        let nodes = self.array(node, what, "an array of corners", example)?;
        let corners: Vec<Option<VectorValue>> = nodes
            .iter()
            .map(|node| self.vector(node, Quantity::LENGTH, what, Scope::Constant))
            .collect();
        let corners: Vec<VectorValue> = corners.into_iter().collect::<Option<_>>()?;
        facts.positions.extend(corners.iter().filter_map(|corner| corner.position.clone()));
        let positions: Vec<[Constant; 3]> =
            corners.iter().filter_map(|corner| corner.position.as_ref().map(|p| p.value)).collect();
        let doubled = self.twice_area(&positions);
        self.constants.pinned_sign(doubled);
        let doubled = doubled.look();
        if corners.len() < 3 || doubled == 0.0 {
            let message = if corners.len() < 3 {
                format!("{what} has {} corners", corners.len())
            } else {
                format!("{what} encloses no area")
            };
            self.report(
                Diagnostic::error(codes::BAD_OUTLINE, message)
                    .at(node.span.clone(), "encloses nothing")
                    .help(format!(
                        "give at least three corners not in one line, for example {example}"
                    )),
            );
            return None;
        }
        let mut polygon: Vec<[Expr; 2]> =
            corners.iter().map(|corner| [corner.components[0], corner.components[1]]).collect();
        if doubled < 0.0 {
            polygon.reverse();
        }
        Some(polygon)
    }

    /// Mass, centre of mass and moment of inertia from density, thickness and outline.
    pub(super) fn read_density(
        &mut self,
        fields: &Fields<'_>,
        outline: Option<&[Vec<[Expr; 2]>]>,
        body: &mut Body,
        facts: &mut BodyFacts,
    ) {
        let help = "a density needs an `outline` and a `thickness`, or `shapes`; or write `mass` \
                    instead";
        let thickness = fields.require(self, "thickness", help);
        let shape = fields.require(self, "outline", help);
        let mut positive = |key: &str, node: Option<&Node>, quantity: Quantity| {
            let what = fields.what(key);
            let scalar = self.scalar(node?, quantity, &what, Scope::Constant)?;
            self.check_positive(&what, &scalar, quantity).then_some(scalar)
        };
        let density = positive("density", fields.get("density"), Quantity::DENSITY);
        let thickness = positive("thickness", thickness, Quantity::LENGTH);
        let (Some(density), Some(thickness), Some(outline), Some(shape)) =
            (density, thickness, outline, shape)
        else {
            return;
        };
        let pool = &self.pool;
        let sheet = pool.mul(density.expr, thickness.expr);
        let moments = self.area_moments(outline);
        body.mass = pool.simplify(pool.mul(sheet, moments.area));
        for (com, first) in body.com.iter_mut().zip(moments.first) {
            *com = pool.simplify(pool.div(first, moments.area));
        }
        // Steiner: the polar moment about the origin, less that of the mass in its centre.
        let [x, y, _] = body.com;
        let arm = self.total(&[pool.powi(x, 2), pool.powi(y, 2)]);
        let about_origin = pool.mul(sheet, moments.polar);
        body.inertia.moments[2] = pool.simplify(pool.sub(about_origin, pool.mul(body.mass, arm)));
        // In space, the moments about axes in the plate: about its middle, half of it on either side.
        let [xx, yy, xy] = moments.second;
        let square = pool.mul(pool.rational(1, 12), pool.powi(thickness.expr, 2));
        let along = |second: Expr, arm: Expr| {
            let less = pool.sub(pool.mul(sheet, second), pool.mul(body.mass, pool.powi(arm, 2)));
            pool.simplify(pool.add(less, pool.mul(body.mass, square)))
        };
        let [ixx, iyy] = [along(yy, y), along(xx, x)];
        let mixed = pool.sub(pool.mul(body.mass, pool.mul(x, y)), pool.mul(sheet, xy));
        body.inertia.products[0] = pool.simplify(mixed);
        [body.inertia.moments[0], body.inertia.moments[1]] = [ixx, iyy];
        facts.has_density = true;
        let corners: Vec<[f64; 3]> = facts.positions.iter().map(Position::numbers).collect();
        if let (Some(density_value), Some(height), [_]) = (density.value, thickness.value, outline)
        {
            let (density_value, height) = (density_value.look(), height.look());
            let area = twice_area(&corners[corners.len() - outline[0].len()..]).abs() / 2.0;
            facts.mass = Some((density_value * height * area, shape.span.clone()));
        }
    }

    /// Area ([`twice_area`]) following what varies.
    fn twice_area(&mut self, corners: &[[Constant; 3]]) -> Constant {
        let constants = &mut self.constants;
        let mut doubled = Constant::written(0.0);
        for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let products = [constants.multiply(a[0], b[1]), constants.multiply(b[0], a[1])];
            let cross = constants.subtract(products[0], products[1]);
            doubled = constants.add(doubled, cross);
        }
        doubled
    }

    pub(super) fn area_moments(&self, outline: &[Vec<[Expr; 2]>]) -> AreaMoments {
        let pool = &self.pool;
        let mut area = Vec::new();
        let mut first = [Vec::new(), Vec::new()];
        let mut polar = Vec::new();
        let mut second = [const { Vec::new() }; 3];
        for polygon in outline {
            let next = polygon.iter().cycle().skip(1);
            for (a, b) in polygon.iter().zip(next) {
                let cross = pool.sub(pool.mul(a[0], b[1]), pool.mul(b[0], a[1]));
                area.push(cross);
                let mut squares = Vec::new();
                for axis in 0..2 {
                    first[axis].push(pool.mul(pool.add(a[axis], b[axis]), cross));
                    let own =
                        [pool.powi(a[axis], 2), pool.mul(a[axis], b[axis]), pool.powi(b[axis], 2)];
                    squares.extend(own);
                    second[axis].push(pool.mul(self.total(&own), cross));
                }
                polar.push(pool.mul(self.total(&squares), cross));
                let twice = |p: &[Expr; 2]| pool.mul(pool.int(2), pool.mul(p[0], p[1]));
                let mixed = [pool.mul(a[0], b[1]), twice(a), twice(b), pool.mul(b[0], a[1])];
                second[2].push(pool.mul(self.total(&mixed), cross));
            }
        }
        let scaled =
            |terms: &[Expr], divisor: i64| pool.mul(pool.rational(1, divisor), self.total(terms));
        AreaMoments {
            area: scaled(&area, 2),
            first: [scaled(&first[0], 6), scaled(&first[1], 6)],
            polar: scaled(&polar, 12),
            second: [scaled(&second[0], 12), scaled(&second[1], 12), scaled(&second[2], 24)],
        }
    }
}

/// Twice the area of a polygon, positive when counter-clockwise.
fn twice_area(corners: &[[f64; 3]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum()
}
