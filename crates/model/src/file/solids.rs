//! `shapes`: solids of a body, and the mass properties of a body made of them.
//!
//! About their own middles, per density, with the volume V:
//!
//! ```text
//! box       V = a b c        V/12 diag(b² + c², c² + a², a² + b²)
//! cylinder  V = π r² l       V diag(r²/4 + l²/12, r²/4 + l²/12, r²/2)
//! ball      V = 4/3 π r³     2/5 V r² 1
//! plate     V = A t          from the moments of its area, see `outline`, and t²/12
//! mesh      by the divergence theorem, see `mesh`
//! ```
//!
//! Turned by R into the axes of the body, J becomes R J Rᵀ; Steiner's theorem adds them up.

use bksim_expr::Expr;

use super::bodies::BodyFacts;
use super::codes;
use super::expand::MOST_FACES;
use super::frames::{FRAME_KEYS, turned};
use super::reader::{Fields, Reader};
use super::tree::{Node, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::body::{Body, Solid, SolidForm};
use crate::diagnostic::Diagnostic;
use crate::ids::Vector;
use crate::mesh::{Mesh, MeshFault, MeshMoments};
use crate::message::short;

/// A form as its type names it.
#[derive(Clone, Copy)]
enum SolidKind {
    Box,
    Cylinder,
    Sphere,
    Plate,
    Mesh,
}

const TYPES: [(&str, SolidKind); 5] = [
    ("box", SolidKind::Box),
    ("cylinder", SolidKind::Cylinder),
    ("sphere", SolidKind::Sphere),
    ("plate", SolidKind::Plate),
    ("mesh", SolidKind::Mesh),
];

/// Entries of a symmetric matrix: xx, yy, zz, xy, yz, zx.
const ENTRIES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

type Matrix = [[Expr; 3]; 3];

/// A solid of density one.
struct Volume {
    /// V, m³.
    size: Expr,
    /// Middle in the body frame, m.
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
            Some(SolidKind::Mesh) => &["corners", "faces", "unit"],
            None => {
                &["size", "radius", "length", "outline", "thickness", "corners", "faces", "unit"]
            }
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
            SolidKind::Mesh => self.read_mesh(fields).map(SolidForm::Mesh),
        }
    }

    /// The triangles of a mesh; their corners are plain numbers in one unit of length.
    fn read_mesh(&mut self, fields: &Fields<'_>) -> Option<Mesh> {
        let help = "write `file = \"part.stl\"`, or `corners = [[0, 0, 0], …]` and `faces = [[0, 2, 1], …]`";
        let [corners, faces] = ["corners", "faces"].map(|key| fields.require(self, key, help));
        // One of its units, or of the file's.
        let what = fields.what("unit");
        let (span, value) = if let Some(node) = fields.get("unit") {
            let unit = self.text_of(node, &what, "mm")?.text;
            (node.span.clone(), Value::Text(format!("1 {unit}")))
        } else {
            (fields.span.clone(), Value::Number { value: 1.0, digits: "1".to_owned() })
        };
        let one = Node { span, value };
        let unit = self.scalar(&one, Quantity::LENGTH, &what, Scope::Constant)?;
        let unit = self.pool.evaluate(unit.expr, &|_| None).ok()?;
        let corners = self.triples(corners?, &fields.what("corners"), "[[0, 0, 0], [1, 0, 0]]")?;
        let faces_node = faces?;
        let faces = self.triples(faces_node, &fields.what("faces"), "[[0, 2, 1], [0, 1, 3]]")?;
        let corners: Vec<[f64; 3]> = corners.into_iter().map(|p| p.map(|x| unit * x)).collect();
        if faces.is_empty() || faces.len() > MOST_FACES {
            let message = format!("{} has {} faces", fields.owner, faces.len());
            self.report(
                Diagnostic::error(codes::BAD_MESH, message)
                    .at(faces_node.span.clone(), format!("between 1 and {MOST_FACES} are possible"))
                    .help("let the program that wrote the mesh simplify it"),
            );
            return None;
        }
        let mut triangles = Vec::with_capacity(faces.len());
        for (face_idx, face) in faces.iter().enumerate() {
            let corner = |&number: &f64| {
                let is_index = number >= 0.0 && number.fract() == 0.0;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "checked"
                )]
                is_index.then(|| corners.get(number as usize).copied()).flatten()
            };
            let [a, b, c] = [0, 1, 2].map(|i| corner(&face[i]).ok_or(face[i]));
            match (a, b, c) {
                (Ok(a), Ok(b), Ok(c)) => triangles.push([a, b, c]),
                (Err(wrong), ..) | (_, Err(wrong), _) | (.., Err(wrong)) => {
                    let owner = &fields.owner;
                    let message =
                        format!("face {} of {owner} has a corner {}", face_idx + 1, short(wrong));
                    let there =
                        format!("there are corners 0 to {}", corners.len().saturating_sub(1));
                    let span = match &faces_node.value {
                        Value::Array(rows) => rows[face_idx].span.clone(),
                        _ => faces_node.span.clone(),
                    };
                    self.report(
                        Diagnostic::error(codes::BAD_MESH, message)
                            .at(span, there)
                            .help("count the corners from 0, in their order"),
                    );
                    return None;
                }
            }
        }
        Some(Mesh::of_triangles(triangles))
    }

    /// Rows of three plain numbers.
    fn triples(&mut self, node: &Node, what: &str, example: &str) -> Option<Vec<[f64; 3]>> {
        let rows = self.array(node, what, "an array of rows", example)?;
        let number = |node: &Node| match node.value {
            Value::Number { value, .. } if value.is_finite() => Some(value),
            _ => None,
        };
        let mut triples = Vec::with_capacity(rows.len());
        for row in rows {
            let found = match &row.value {
                Value::Array(row) if row.len() == 3 => {
                    let [x, y, z] = [0, 1, 2].map(|i| number(&row[i]));
                    x.zip(y).zip(z).map(|((x, y), z)| [x, y, z])
                }
                _ => None,
            };
            let Some(found) = found else {
                let help = "write the numbers bare, and their unit as `unit = \"mm\"`";
                self.wrong_kind(
                    row,
                    &format!("a row of {what}"),
                    "three plain numbers",
                    &row.value,
                    help,
                );
                return None;
            };
            triples.push(found);
        }
        Some(triples)
    }

    /// Reports meshes that enclose no volume: true where there is none.
    fn check_meshes(&mut self, fields: &Fields<'_>, solids: &[Solid]) -> bool {
        let Some(Node { value: Value::Array(nodes), .. }) = fields.get("shapes") else {
            return true;
        };
        let spans: Vec<_> = nodes.iter().map(|node| node.span.clone()).collect();
        let before = self.faults.len();
        for (idx, (solid, span)) in solids.iter().zip(spans).enumerate() {
            let SolidForm::Mesh(mesh) = &solid.form else { continue };
            let Err(fault) = mesh.moments() else { continue };
            let edge = |[a, b]: [[f64; 3]; 2]| {
                let point = |p: [f64; 3]| p.map(short).join(", ");
                format!("from ({}) to ({}) m", point(a), point(b))
            };
            let (what, help) = match fault {
                MeshFault::Open(ends) => (
                    format!("is open at the edge {}", edge(ends)),
                    "close it in the program that wrote it, or state `mass` and `inertia`",
                ),
                MeshFault::Turned(ends) => (
                    format!("has faces of opposite orientation at the edge {}", edge(ends)),
                    "let all faces run counter-clockwise as seen from outside",
                ),
                MeshFault::InsideOut(volume) => (
                    format!("is inside out: its volume is {} m^3", short(volume)),
                    "let its faces run counter-clockwise as seen from outside",
                ),
                MeshFault::Flat => (
                    "encloses no volume".to_owned(),
                    "use a mesh of a solid, or state `mass` and `inertia`",
                ),
            };
            let message = format!("the mesh of shape {} of {} {what}", idx + 1, fields.owner);
            self.report(
                Diagnostic::error(codes::OPEN_MESH, message)
                    .at(span, "its mass cannot follow from a density")
                    .help(help),
            );
        }
        self.faults.len() == before
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
        if !self.check_meshes(fields, &solids) {
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
        // Volume, and the tensor per volume: xx, yy, zz, and xy; yz and zx of meshes.
        let [mut yz, mut zx] = [zero; 2];
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
            SolidForm::Mesh(mesh) => {
                // One without a volume is refused before.
                let found = mesh.moments().unwrap_or(MeshMoments::NONE);
                middle = found.middle.map(|x| pool.float(x));
                let entry = |i: usize, j: usize| pool.float(found.inertia[i][j] / found.volume);
                [yz, zx] = [entry(1, 2), entry(2, 0)];
                (pool.float(found.volume), [entry(0, 0), entry(1, 1), entry(2, 2)], entry(0, 1))
            }
        };
        let [xx, yy, zz] = moments.map(|moment| pool.mul(volume, moment));
        let [xy, yz, zx] = [xy, yz, zx].map(|product| pool.mul(volume, product));
        let own = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
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
