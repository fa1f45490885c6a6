//! `shapes`: solids of a body, and the mass properties of a body made of them.
//!
//! About their own middles, per density, with the volume V:
//!
//! ```text
//! box       V = a b c        V/12 diag(b² + c², c² + a², a² + b²)
//! cylinder  V = π r² l       V diag(r²/4 + l²/12, r²/4 + l²/12, r²/2)
//! ball      V = 4/3 π r³     2/5 V r² 1
//! plate     V = A t          from the moments of its area, see `outline`, and t²/12
//! ```
//!
//! Turned by R into the axes of the body, J becomes R J Rᵀ; Steiner's theorem adds them up.

use bksim_expr::Expr;

use super::bodies::BodyFacts;
use super::frames::{FRAME_KEYS, turned};
use super::reader::{Fields, Reader};
use super::tree::Node;
use super::units::Quantity;
use super::value::Scope;
use crate::body::{Body, Solid, SolidForm};
use crate::ids::Vector;

/// A form as its type names it.
#[derive(Clone, Copy)]
enum SolidKind {
    Box,
    Cylinder,
    Sphere,
    Plate,
}

const TYPES: [(&str, SolidKind); 4] = [
    ("box", SolidKind::Box),
    ("cylinder", SolidKind::Cylinder),
    ("sphere", SolidKind::Sphere),
    ("plate", SolidKind::Plate),
];

/// Entries of a symmetric matrix: xx, yy, zz, xy, yz, zx.
const ENTRIES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

type Matrix = [[Expr; 3]; 3];

/// A solid of density one.
struct Volume {
    /// V, m³.
    size: Expr,
    /// Its middle in the body frame, m.
    middle: Vector,
    /// The inertia tensor about the middle in body axes, m⁵.
    inertia: Matrix,
}

impl Reader<'_> {
    /// The solids of a body; `None` after a fault.
    pub(super) fn read_shapes(
        &mut self,
        fields: &Fields<'_>,
        facts: &mut BodyFacts,
    ) -> Option<Vec<Solid>> {
        let Some(node) = fields.get("shapes") else { return Some(Vec::new()) };
        let what = fields.what("shapes");
        let example = "[{ type = \"sphere\", radius = \"25 mm\" }]";
        let values = self.array(node, &what, "an array of tables", example)?;
        let solids: Vec<Option<Solid>> = values
            .iter()
            .enumerate()
            .map(|(idx, node)| {
                self.read_solid(node, &format!("shape {} of {}", idx + 1, fields.owner), facts)
            })
            .collect();
        solids.into_iter().collect()
    }

    fn read_solid(&mut self, node: &Node, owner: &str, facts: &mut BodyFacts) -> Option<Solid> {
        let table = self.table(node, owner)?;
        // The type says which keys there are.
        let kind = match table.get("type") {
            Some(entry) => Some(self.choice(&entry.node, &format!("`type` of {owner}"), &TYPES)?),
            None => None,
        };
        let own: &[&str] = match kind {
            Some(SolidKind::Box) => &["size"],
            Some(SolidKind::Cylinder) => &["radius", "length"],
            Some(SolidKind::Sphere) => &["radius"],
            Some(SolidKind::Plate) => &["outline", "thickness"],
            None => &["size", "radius", "length", "outline", "thickness"],
        };
        let known: Vec<&str> = ["type"].iter().chain(own).chain(&FRAME_KEYS).copied().collect();
        let fields = Fields::open(self, table, owner.to_owned(), node.span.clone(), &known);
        fields.require(self, "type", "write for example `type = \"box\"`")?;
        let form = self.read_form(kind?, &fields, facts)?;
        let mut position = [self.pool.zero(); 3];
        if let Some(node) = fields.get("at") {
            let at = self.vector(node, Quantity::LENGTH, &fields.what("at"), Scope::Constant)?;
            position = at.components;
            facts.positions.extend(at.position);
        }
        let orientation = self.orientation(&fields);
        Some(Solid { form, position, orientation })
    }

    fn read_form(
        &mut self,
        kind: SolidKind,
        fields: &Fields<'_>,
        facts: &mut BodyFacts,
    ) -> Option<SolidForm> {
        let length = |reader: &mut Self, key: &str| {
            let node = fields.require(reader, key, "write for example \"25 mm\"")?;
            reader.positive_length(node, &fields.what(key))
        };
        match kind {
            SolidKind::Box => {
                let help =
                    "write its lengths, for example `size = [\"80 mm\", \"50 mm\", \"10 mm\"]`";
                let node = fields.require(self, "size", help)?;
                let what = fields.what("size");
                let example = "[\"80 mm\", \"50 mm\", \"10 mm\"]";
                let values = self.array(node, &what, "[x, y, z]", example)?;
                let [x, y, z] = values else {
                    let help = format!("for example {example}");
                    self.wrong_kind(node, &what, "[x, y, z]", &node.value, &help);
                    return None;
                };
                let [x, y, z] = [x, y, z].map(|node| self.positive_length(node, &what));
                Some(SolidForm::Box([x?, y?, z?]))
            }
            SolidKind::Cylinder => {
                let [radius, length] = ["radius", "length"].map(|key| length(self, key));
                Some(SolidForm::Cylinder { radius: radius?, length: length? })
            }
            SolidKind::Sphere => Some(SolidForm::Sphere(length(self, "radius")?)),
            SolidKind::Plate => {
                let help = "write its corners, for example `outline = [[0, 0], [1, 0], [0, 1]]`";
                let outline = fields.require(self, "outline", help);
                // Corners are in the frame of the plate, and are not positions of the body.
                let mut apart = BodyFacts::default();
                let what = fields.what("outline");
                let corners = outline.and_then(|node| self.read_polygon(node, &what, &mut apart));
                let thickness = length(self, "thickness")?;
                facts.positions.extend(apart.positions);
                Some(SolidForm::Plate { corners: corners?, thickness })
            }
        }
    }

    fn positive_length(&mut self, node: &Node, what: &str) -> Option<Expr> {
        let scalar = self.scalar(node, Quantity::LENGTH, what, Scope::Constant)?;
        self.check_positive(what, &scalar, Quantity::LENGTH).then_some(scalar.expr)
    }

    /// Mass, centre of mass and inertia from density and shapes.
    pub(super) fn read_density_of_shapes(
        &mut self,
        fields: &Fields<'_>,
        body: &mut Body,
        facts: &mut BodyFacts,
    ) {
        fields.conflict(self, "thickness", "shapes");
        let solids = self.read_shapes(fields, facts);
        let what = fields.what("density");
        let density = fields.get("density").and_then(|node| {
            let scalar = self.scalar(node, Quantity::DENSITY, &what, Scope::Constant)?;
            self.check_positive(&what, &scalar, Quantity::DENSITY).then_some(scalar.expr)
        });
        let (Some(solids), Some(density)) = (solids, density) else { return };
        if solids.is_empty() {
            if let Some(node) = fields.get("shapes") {
                let what = fields.what("shapes");
                let help = "give at least one shape, or write `mass` instead of `density`";
                self.wrong_kind(node, &what, "at least one shape", &node.value, help);
            }
            return;
        }
        let volumes: Vec<Volume> = solids.iter().map(|solid| self.volume(solid)).collect();
        let pool = &self.pool;
        let over =
            |f: &dyn Fn(&Volume) -> Expr| self.total(&volumes.iter().map(f).collect::<Vec<_>>());
        // What follows from numbers alone is a number in the equations.
        let plain = |e: Expr| {
            let simple = pool.simplify(e);
            pool.evaluate(simple, &|_| None).map_or(simple, |value| pool.float(value))
        };
        let volume = plain(over(&|one| one.size));
        body.mass = pool.simplify(pool.mul(density, volume));
        for (axis, com) in body.com.iter_mut().enumerate() {
            let first = over(&|one| pool.mul(one.size, one.middle[axis]));
            *com = plain(pool.div(first, volume));
        }
        // Steiner: J + V (d² 1 − d dᵀ), with d from the centre of mass of all.
        let com = body.com;
        let entry = |[i, j]: [usize; 2]| {
            let about_com = over(&|one| {
                let d: Vector = std::array::from_fn(|axis| pool.sub(one.middle[axis], com[axis]));
                let across = if i == j {
                    self.total(&[(i + 1) % 3, (i + 2) % 3].map(|k| pool.powi(d[k], 2)))
                } else {
                    pool.neg(pool.mul(d[i], d[j]))
                };
                pool.add(one.inertia[i][j], pool.mul(one.size, across))
            });
            pool.simplify(pool.mul(density, plain(about_com)))
        };
        let [xx, yy, zz, xy, yz, zx] = ENTRIES.map(entry);
        body.inertia.moments = [xx, yy, zz];
        body.inertia.products = [xy, yz, zx];
        facts.has_density = true;
        body.solids = solids;
    }

    /// The volume of a solid, its middle and its inertia.
    fn volume(&self, solid: &Solid) -> Volume {
        let pool = &self.pool;
        let zero = pool.zero();
        let product = |factors: &[Expr]| pool.product(factors.iter().copied());
        let part = |p: i64, q: i64, e: Expr| pool.mul(pool.rational(p, q), e);
        let square = |e: Expr| pool.powi(e, 2);
        let mut middle = [zero; 3];
        // Volume, and the tensor per volume.
        let (volume, moments, xy) = match &solid.form {
            SolidForm::Box(size) => {
                let [x, y, z] = size.map(|length| part(1, 12, square(length)));
                (product(size), [pool.add(y, z), pool.add(z, x), pool.add(x, y)], zero)
            }
            SolidForm::Cylinder { radius, length } => {
                let [quarter, half] = [4, 2].map(|n| part(1, n, square(*radius)));
                let across = pool.add(quarter, part(1, 12, square(*length)));
                (product(&[pool.pi(), square(*radius), *length]), [across, across, half], zero)
            }
            SolidForm::Sphere(radius) => {
                let volume = part(4, 3, pool.mul(pool.pi(), pool.powi(*radius, 3)));
                (volume, [part(2, 5, square(*radius)); 3], zero)
            }
            SolidForm::Plate { corners, thickness } => {
                let moments = self.area_moments(std::slice::from_ref(corners));
                let over_area = |e: Expr| pool.div(e, moments.area);
                let [x, y] = moments.first.map(over_area);
                middle = [x, y, zero];
                let [xx, yy, xy] = moments.second.map(over_area);
                let across = part(1, 12, square(*thickness));
                let [xx, yy] = [pool.sub(xx, square(x)), pool.sub(yy, square(y))];
                let moments_of_plate =
                    [pool.add(yy, across), pool.add(xx, across), pool.add(xx, yy)];
                let xy = pool.sub(pool.mul(x, y), xy);
                (pool.mul(moments.area, *thickness), moments_of_plate, xy)
            }
        };
        let [xx, yy, zz] = moments.map(|moment| pool.mul(volume, moment));
        let xy = pool.mul(volume, xy);
        let own = [[xx, xy, zero], [xy, yy, zero], [zero, zero, zz]];
        // Into the axes of the body.
        let images = [0, 1, 2].map(|axis| {
            let mut unit = [zero; 3];
            unit[axis] = pool.one();
            turned(pool, &solid.orientation, unit)
        });
        let r = transposed(&images);
        let inertia = self.times(&self.times(&r, &own), &images);
        let middle = turned(pool, &solid.orientation, middle);
        let middle = std::array::from_fn(|i| pool.add(solid.position[i], middle[i]));
        Volume { size: volume, middle, inertia }
    }

    fn times(&self, a: &Matrix, b: &Matrix) -> Matrix {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| self.total(&[0, 1, 2].map(|k| self.pool.mul(a[i][k], b[k][j]))))
        })
    }
}

fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}
